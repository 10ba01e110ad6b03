"""The zero-time discontinuity map and the local map it gives: (2.2) to (2.5) of the paper.

An orbit that is about to hit at low speed is carried to the wall, reset, and carried back by the same time delta:
a correction of the state in zero time, after which the whole period is flown as if there were no wall.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from math import inf, sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.copies import by_value
from grazing.maps.derivative import extended, stepping
from grazing.maps.map import Map
from grazing.maps.of_oscillator import OfOscillator, above_wall, apart
from grazing.maps.period import periods_passed, product
from grazing.maps.starting import local_box
from grazing.oscillator.constants import constants_of, forcing, section_phase
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.model import Oscillator, checked_model, checked_phase
from grazing.oscillator.pointed import pointed_law, pointed_slope
from grazing.oscillator.spring import refuse_stiffness
from grazing.oscillator.trajectory import checked_state
from grazing.outcome import AMBIGUOUS, OK, InputError, OutsideForm, shown
from grazing.parameter import parameters

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NAN = float("nan")
ORDERS = ("lowest", "full", "corrected")
#: A state behind the wall at the bottom of its flight has v = 0 but for rounding, of so much of its speed at the wall.
BOTTOM = 2.0**-32


def time_to_wall(y: float, v: float, A: float) -> tuple[float, float]:
    """Return (delta, sqrt(x)): the smaller root of y + v delta + A delta^2/2 = 0 and x = v^2 - 2 A y >= 0, v <= 0.

    The paper's delta = (-v - sqrt(x))/A, written so that A may vanish or be negative.
    """
    root = sqrt(max(v * v - 2.0 * A * y, 0.0))
    return 2.0 * y / (root - v), root


@lru_cache(maxsize=256)
def correction_of(law: Callable[..., float], slope: Callable[..., float], order: str) -> Callable[..., Any]:
    """Return ``correction(y, v, c) -> ((y3, v3), letter, outcome, J)``, the zero-time map at local time 0."""
    full = order != "lowest"
    drag = 1.0 if order == "corrected" else 0.0

    def correction(y: float, v: float, c: Any) -> Any:
        F, _dF = forcing(0.0, c)
        A = F - c.alpha * v - c.k2 * y
        x = v * v - 2.0 * A * y
        if not (x >= 0.0 and (v < 0.0 or (y < 0.0 and v < BOTTOM * sqrt(x)))):
            return (y, v), 0, OK, (1.0, 0.0, 0.0, 1.0)
        border = AMBIGUOUS if x == 0.0 else OK
        delta, root = time_to_wall(y, v, A)
        V2 = law(-root, c.p)
        g = slope(-root, c.p)
        # slopes of A, sqrt(x) and V2 in (y, v): A depends on the state, too
        A_y, A_v = -c.k2, -c.alpha
        root_y, root_v = -(A + y * A_y) / root, (v - y * A_v) / root
        if not full:  # (2.3) with delta A = -v - sqrt(x); the position as it is
            return (y, V2 + v + root), 1, border, (1.0, 0.0, (1.0 - g) * root_y, 1.0 + (1.0 - g) * root_v)
        # (2.2), (2.3): back to the start with the acceleration B, which an impact changes by -alpha (V2 - V1)
        B = A - drag * c.alpha * (V2 + root)
        B_y = A_y - drag * c.alpha * (1.0 - g) * root_y
        B_v = A_v - drag * c.alpha * (1.0 - g) * root_v
        d_y = (2.0 - delta * root_y) / (root - v)
        d_v = -delta * (root_v - 1.0) / (root - v)
        half = 0.5 * delta * delta
        J = (
            (B * delta - V2) * d_y + delta * g * root_y + half * B_y,
            (B * delta - V2) * d_v + delta * g * root_v + half * B_v,
            -g * root_y - B * d_y - delta * B_y,
            -g * root_v - B * d_v - delta * B_v,
        )
        return (B * half - delta * V2, V2 - delta * B), 1, border, J

    return correction


@lru_cache(maxsize=256)
def local_map_of(
    law: Callable[..., float], slope: Callable[..., float], order: str, flown: bool
) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return (step, tangent) of the zero-time map, followed by the period without impact if ``flown``."""
    correction = correction_of(law, slope, order)

    def tangent(state: Any, c: Any) -> Any:
        u, v = state
        (y, v), letter, outcome, J = correction(u - c.sigma, v, c)
        if flown:
            y, v = flight(c.T, anchored(0.0, y, v, c), c)
            J = product(modes(c.T, c), J)
        return (y + c.sigma, v), letter, outcome, J

    return stepping(tangent), tangent


def discontinuity_map(model: Oscillator, order: str = "lowest", phase: float = 0.0) -> Map:
    """Return the paper's local map: the zero-time discontinuity map, then a period without impact.

    Parameters
    ----------
    model : Oscillator
        Its low-velocity impact should come shortly after the section, as in the paper.
    order : {"lowest", "full", "corrected"}
        lowest: (2.4)/(2.5), which leaves the position as it is; full: all terms of (2.2)/(2.3); corrected: those,
        with the acceleration after the impact on the way back (see Notes).
    phase : float
        Time of the section, from t = 0.

    Returns
    -------
    Map
        State (u, v); letter 1 where v^2 - 2A(u - sigma) >= 0 and v < 0, with A the acceleration at the state, or where
        it is at the bottom of a flight through the wall, v = 0 but for rounding; else 0.

    Notes
    -----
    (2.5) is P_T alone, not P_T after the zero-time map as printed. The acceleration after an active impact differs
    from the one before by -alpha (v_plus - v_minus), which (2.2)/(2.3) neglect. Take impacts whose speed is of the
    order of the time to the wall, as they are near a graze. For V > 0 and alpha > 0 the error of
    *lowest* and *full* is therefore of first order in the time to the wall, in u and in v; *corrected* is of second
    order. For V = 0 all three are of second order (measured in ``tests/maps/test_discontinuity.py``).

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, equations (2.2) to (2.5).

    Examples
    --------
    >>> import grazing as gz
    >>> m = gz.pinball(alpha=3, k=1, omega=2.1, t0=2.2, r=0.8, d=0.11, V=0.2)
    >>> Z = gz.discontinuity_map(m)
    >>> Z((0.030, -0.23))[1], Z((0.045, -0.23))[1]
    (1, 0)
    """
    return _local_map(model, order, phase, flown=True)


def zdm(model: Oscillator, order: str = "full", phase: float = 0.0) -> Map:
    """Return the zero-time discontinuity map alone, (U0, V0) to (U3, V3), without the period that follows.

    Parameters
    ----------
    model : Oscillator
    order : {"lowest", "full", "corrected"}
        See :func:`discontinuity_map`.
    phase : float
        Time of the section, from t = 0.

    Returns
    -------
    Map
        State (u, v); the identity where no impact follows.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.zdm(gz.pinball())((0.5, 0.1))
    (array([0.5, 0.1]), 0)
    """
    return _local_map(model, order, phase, flown=False)


def _local_map(model: Oscillator, order: str, phase: float, flown: bool) -> Map:
    checked_model(model)
    refuse_stiffness(model, "a discontinuity map")
    if not isinstance(order, str) or order not in ORDERS:
        raise InputError(
            f"order is {shown(order)}; allowed are 'lowest' (2.4)/(2.5), 'full' (2.2)/(2.3) and 'corrected'"
        )
    law = model.reset
    step, tangent = local_map_of(law.law, law.slope, order, flown)
    return Map(
        step,
        params={**model.params, "phase": checked_phase(model, phase)},
        coordinates=("u", "v"),
        box=local_box(model.reach, model.paper),
        prepare=constants_of(model.harmonics, section_phase),
        tangent=tangent,
        name=f"{'discontinuity map' if flown else 'zero-time map'}, {order} order",
        origin=Flown(model, order) if flown else Local(model, order),
    )


class Local(OfOscillator):
    """The origin of a zero-time map: the oscillator that it comes near, and the order of its terms."""

    flown: ClassVar[bool] = False
    form = staticmethod(local_box)

    def __init__(self, model: Oscillator, order: str) -> None:
        super().__init__(model)
        self.order = order

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values, from a model that checks their ranges."""
        own, phase = apart(params)
        return _local_map(self.model.replace(**own), self.order, phase, self.flown)

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a start inside the wall."""
        above_wall(state, params)

    def compiled(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """Return the tangent and what prepares its numbers."""
        _step, tangent = local_map_of(pointed_law, pointed_slope, self.order, self.flown)
        return extended(tangent), constants_of(self.model.harmonics, section_phase)


class Flown(Local):
    """The origin of a discontinuity map with the period that follows; it may start where it ends, inside the wall."""

    flown = True

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Allow every start."""

    def clock(self, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
        """Return the time that orbits took for so many steps, each of a period."""
        return periods_passed(list(self.model.params).index("omega"), rows, first, last, letters, steps)


def zero_time_of(law: Callable[..., float]) -> Callable[..., Any]:
    """Return ``zero_time(y, v, c) -> (x, delta, A, root, V2, U3, V3)``: the four points of Figure 2.1, U from the wall.

    x = v^2 - 2 A y; the flight of constant acceleration A reaches the wall if v < 0 and x >= 0, else V2 is NaN.
    """

    def zero_time(y: float, v: float, c: Any) -> Any:
        A = forcing(0.0, c)[0] - c.alpha * v - c.k2 * y
        x = v * v - 2.0 * A * y
        delta, root = time_to_wall(y, v, A)
        V2 = law(-root, c.p) if v < 0.0 and x >= 0.0 else NAN
        return x, delta, A, root, V2, -delta * V2 + 0.5 * A * delta * delta, V2 - delta * A

    return zero_time


@by_value
class ZeroTime(NamedTuple):
    """The zero-time map of one state: points (4, 2), rows (U0, V0) to (U3, V3); delta; A; x = v^2 - 2A(u - sigma)."""

    points: NDArray[np.float64]
    delta: float
    acceleration: float
    x: float


def zdm_points(model: Oscillator, state: ArrayLike, phase: float = 0.0) -> ZeroTime:
    """Return the four points of the zero-time discontinuity map, as in Figure 2.1.

    Parameters
    ----------
    model : Oscillator
    state : array_like, shape (2,)
        (U0, V0) with U0 >= sigma, V0 < 0 and V0^2 >= 2A(U0 - sigma): the flight reaches the wall.
    phase : float
        Time of the section, from t = 0.

    Returns
    -------
    ZeroTime

    Raises
    ------
    OutsideForm
        Where the quadratic flight does not reach the wall.

    Examples
    --------
    >>> import grazing as gz
    >>> four = gz.zdm_points(gz.pinball(d=0.12), (0.02, -0.3))
    >>> float(four.points[1, 0]), round(float(four.points[2, 1] + 0.8 * four.points[1, 1]), 12)
    (0.0, 0.4)
    """
    checked_model(model)
    refuse_stiffness(model, "a discontinuity map")
    u, v = checked_state(state, model)
    params = {**model.params, "phase": checked_phase(model, phase)}
    p = parameters(params)
    c = constants_of(model.harmonics, section_phase)(p)
    y = u - model.sigma
    if not v < 0.0:
        raise OutsideForm(f"no impact follows from (u, v) = ({u:g}, {v:g}): v = {v:g} must be negative")
    if not v * v < inf:
        raise InputError(f"v = {v:g} is so fast that its square overflows; give a slower state")
    x, delta, A, root, V2, U3, V3 = zero_time_of(lambda speed, _p: model.reset(speed))(y, v, c)
    if not x >= 0.0:
        raise OutsideForm(
            f"no impact follows from (u, v) = ({u:g}, {v:g}): v^2 - 2A(u - sigma) = {x:g} must not be negative"
        )
    rows = [(y, v), (0.0, -root), (0.0, V2), (U3, V3)]
    return ZeroTime(np.array(rows) + np.array([model.sigma, 0.0]), delta, A, x)
