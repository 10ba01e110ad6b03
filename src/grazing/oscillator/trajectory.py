"""Trajectories: flights and impacts in continuous time, every impact located, none sampled."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.memory import refuse_too_large
from grazing.oscillator.constants import FAR, piece_of, roots
from grazing.oscillator.contact import MAX_SWINGS
from grazing.oscillator.legs import (
    END,
    FLAGS,
    LEG,
    MAX_IMPACTS,
    PERIOD,
    START,
    V_MINUS,
    V_PLUS,
    V,
    Y,
    flown,
    flown_legs,
)  # fmt: skip
from grazing.oscillator.model import Oscillator, checked_model
from grazing.oscillator.reach import drive_of
from grazing.oscillator.rig import Rig
from grazing.oscillator.spring import frequency_of
from grazing.oscillator.walled import Walled
from grazing.oscillator.walled_trajectory import said_of, walled_trajectory
from grazing.outcome import AMBIGUOUS, TOO_MANY_SWINGS, InputError, Trust, describe, shown
from grazing.parameter import COARSE, LATEST, in_order, parameters, real, refuse_late, whole
from grazing.systems.contract import System
from grazing.systems.trajectory import system_trajectory

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: A trajectory samples every period; beyond so many points it is refused by name.
MAX_POINTS = 20_000_000
#: Bytes of a point, in its leg and joined, and of a leg beside its points.
POINT, LEG_SIZE = 136, 800


@runtime_checkable
class Follows(Protocol):
    """A system of a layer above that follows itself, such as :class:`grazing.billiard.table.Table`."""

    @property
    def autonomous(self) -> bool:
        """Whether nothing of it depends on time."""

    def trajectory(self, state: ArrayLike, start: float, until: float, samples: int) -> xr.Dataset:
        """Follow it in continuous time."""


def trajectory(
    model: Rig | System | Follows,
    state: ArrayLike,
    start: float = 0.0,
    until: float = 50.0,
    samples: int = 200,
) -> xr.Dataset:
    """Follow the ball in continuous time.

    Parameters
    ----------
    model : Oscillator, System or Table
        Also one with several walls; a system of your own; or a pinball table.
    state : array_like, shape (2,)
        (u, v) at time ``start``, u >= sigma. At u = sigma with v < 0 the ball is hit at once. Of a system of your own
        its coordinates, all gaps being >= 0; on a table (x, y, vx, vy) of the ball's centre.
    start, until : float
        Time interval, until > start.
    samples : int
        Points per forcing period, at least 2; each flight also has its two ends, so that velocities jump where
        they do. Impacts do not depend on it. On a table points over the whole time; :func:`grazing.plot.table` draws
        flights smoothly whatever it is.

    Returns
    -------
    xarray.Dataset
        ``u``, ``v`` on ``t``; ``impact_time``, ``v_minus``, ``v_plus`` on ``impact``; ``wall``, where it is;
        ``trust``, one word: *certified* (right for the state at each ``start`` + nT, as in the stroboscopic map) or
        *ambiguous*. Chatter is listed down to 1e-6 of the fastest departure since the last strobe or rest
        and then completed. Of a system of your own: its coordinates on ``t``; the rates of the gap ``v_minus`` and
        ``v_plus``, ``impact_wall`` and the states ``before`` and ``after`` on ``impact``; the attribute ``outcome``, a
        word: *ok*, *grazing*, *chatter not resolved* (1000 impacts within a thousandth of a period; the trajectory
        ends there), *diverged*; *certified* only where it says how its gaps are rounded, else *numerical*. On a table
        in place of the rates the velocities along the normal, and ``exit``, the drain through which the ball left, or
        away; then the outcome is *escaped*. *stays for ever* is that of a ball that rests, or slides to and fro, and
        *too many impacts* that of one after a million, or one that is jammed; *bounces too small to tell apart* that of
        one on a flipper that turns.

    Raises
    ------
    InputError
        For a ball inside the wall, an empty or reversed interval, or more impacts than can be listed.
    UserCodeError
        For a reset law that returns what it must not.

    Examples
    --------
    >>> import grazing as gz
    >>> tr = gz.trajectory(gz.pinball(d=0.12, V=0.4), (0.1, 0.0), until=20.0)
    >>> tr.sizes["impact"], str(tr.trust.item())
    (3, 'certified')
    """
    from grazing.late import xarray as xr

    if not isinstance(model, Rig | System | Follows):
        checked_model(model)
    start = real(start, "start", "a finite time is allowed")
    until = real(until, "until", "a finite time is allowed")
    samples = whole(samples, "samples", 2)
    if not until > start:
        raise InputError(f"until = {until:g} is not after start = {start:g}; give until > start")
    if isinstance(model, Rig):
        refuse_late(start, "start", model.period)
    else:  # on one clock throughout: that of its own flight, where nothing depends on time
        within = until - start
        if isinstance(model, System) and model.period is not None:
            within = min(within, model.span)
        most = LATEST if isinstance(model, Follows) and model.autonomous else COARSE
        for name, time in (("start", start), ("until", until)):
            refuse_late(time, name, within, most, "begin nearer to 0")
    if isinstance(model, Follows):
        return model.trajectory(state, start, until, samples)
    if isinstance(model, System):
        return system_trajectory(model, state, start, until, samples)
    u, v = two_numbers(state)
    _refuse_too_much(model, (until - start) / model.period * samples, samples)
    if isinstance(model, Walled):
        return walled_trajectory(model, (u, v), start, until, samples)
    given = model = model.seen[0]
    refuse_inside(u, model)
    model, legs = _flown(model, (u, v), start, until)
    times, us, vs = _sampled(model, legs, start, until, samples)
    ends = np.array([_instants(leg, start, model.period)[1] for leg in legs])
    hits = ~np.isnan(legs[:, V_MINUS]) & (ends <= until)
    flags = int(np.bitwise_or.reduce(legs[:, FLAGS].astype(int)))
    trust = Trust.ambiguous if flags & AMBIGUOUS else Trust.certified
    about = {name: model.describe(name).attributes for name in ("t", "u", "v", "v_minus", "v_plus")}
    return xr.Dataset(
        {
            "u": ("t", us, about["u"]),
            "v": ("t", vs, about["v"]),
            "impact_time": ("impact", ends[hits], about["t"] | {"long_name": "time of impact"}),
            "v_minus": ("impact", legs[hits, V_MINUS], about["v_minus"]),
            "v_plus": ("impact", legs[hits, V_PLUS], about["v_plus"]),
            "wall": ((), given.sigma, model.describe("sigma").attributes),
            "trust": ((), trust.value),
        },
        coords={"t": ("t", times, about["t"])},
        attrs=said_of(given, flags),
    )


def _flown(model: Oscillator, state: tuple[float, float], start: float, until: float) -> tuple[Oscillator, Floats]:
    """Return the legs of a trajectory, and the model whose wall their heights are above.

    Heights above a wall far below have few digits left. A ball that does not meet a nearer wall meets no wall.
    """
    (u, v), f, T = state, model.forcing, model.period
    k = frequency_of(model)
    swing, _speed = drive_of(model.alpha, k, f.omega, f.offset, f.cos, f.sin)
    stiff = max(k, f.omega)
    nearer = -64.0 * max(abs(u), abs(v) * T, swing, abs(f.offset) / stiff / stiff)
    if FAR * model.sigma < nearer < 0.0:
        raised = model.replace(sigma=nearer)
        legs = flown_legs(raised, state, start, until, MAX_IMPACTS)
        if not legs[:, FLAGS].any() and np.isnan(legs[:, V_MINUS]).all():
            return raised, legs
    return model, flown_legs(model, state, start, until, MAX_IMPACTS)


def _refuse_too_much(model: Rig, points: float, samples: int) -> None:
    if points > MAX_POINTS:
        raise InputError(
            f"{points:.3g} points are more than {MAX_POINTS:.3g}; choose an earlier end or fewer samples per period, "
            "or iterate the stroboscopic map"
        )
    # a period is a leg at least, whose three arrays are objects of their own until they are joined
    refuse_too_large(
        POINT * points + LEG_SIZE * (points / samples),
        "choose an earlier end or fewer samples per period",
        "the trajectory",
    )
    refuse_swings(model)


def refuse_swings(model: Rig) -> None:
    """Raise InputError for a free ball that swings more often in a period than can be followed."""
    q2, spread, l1, _l2 = roots(parameters(model.params))
    if model.period > MAX_SWINGS * piece_of(q2, spread, l1, model.period):
        raise InputError(describe(TOO_MANY_SWINGS))


def checked_state(state: ArrayLike, model: Oscillator) -> tuple[float, float]:
    """Return (u, v) as floats, or raise InputError: two finite numbers, not inside the wall."""
    u, v = two_numbers(state)
    refuse_inside(u, model)
    return u, v


def two_numbers(state: ArrayLike) -> tuple[float, float]:
    """Return (u, v) as floats, or raise InputError."""
    try:
        values = np.asarray(in_order(state), dtype=object).ravel().tolist() if len(state) == 2 else []  # type: ignore[arg-type]
    except Exception:  # of whatever object was given
        values = []
    if len(values) != 2:
        raise InputError(f"state is {shown(state)}; give two numbers (u, v)")
    u, v = (real(x, name, "any finite number is allowed") for x, name in zip(values, "uv", strict=True))
    return u, v


def refuse_inside(u: float, model: Oscillator) -> None:
    """Raise InputError for a ball inside the wall."""
    if u < model.sigma:
        above = "; here u is -x, as the stop is above" if model.stop == "above" else ""
        raise InputError(
            f"the ball starts inside the wall: u = {u:g}, sigma = {model.sigma:g}; start with u >= sigma{above}"
        )


def _instants(leg: Floats, start: float, period: float) -> tuple[float, float]:
    """Return the times at which a leg begins and ends; the end of a period is the beginning of the next."""
    origin, following = start + leg[PERIOD] * period, start + (leg[PERIOD] + 1.0) * period
    return min(origin + leg[START], following), following if leg[END] >= period else min(origin + leg[END], following)


def _sampled(
    model: Oscillator, legs: Floats, start: float, until: float, samples: int
) -> tuple[Floats, Floats, Floats]:
    """Return times, positions and velocities along the legs, both ends of every leg included."""
    times, ways, which, last = [], [], [], []
    for number, leg in enumerate(legs):
        begins, ends = _instants(leg, start, model.period)
        ends = min(ends, until)
        if begins > ends:
            continue
        length = leg[END] - leg[START] if ends < until else min(until - begins, leg[END] - leg[START])
        s = np.linspace(0.0, length, max(2, ceil(samples * length / model.period) + 1))
        times.append(np.minimum(begins + s, ends))
        times[-1][-1] = ends
        ways.append(s)
        which.append(number)
        last.append(length == leg[END] - leg[START])
    counts = np.array([len(s) for s in ways])
    begun = legs[np.repeat(which, counts)]
    t, y, w = np.ascontiguousarray(begun[:, [START, Y, V]].T)
    u, v = flown(model, start, t, y, w, np.concatenate(ways))
    rest = begun[:, LEG] != 0.0
    u[rest], v[rest] = model.sigma, 0.0
    # the ends of a flight are known better than by a formula
    flew = legs[which, LEG] == 0.0
    after = np.cumsum(counts)
    first = (after - counts)[flew]
    u[first], v[first] = legs[which, Y][flew] + model.sigma, legs[which, V][flew]
    hit = flew & np.array(last) & ~np.isnan(legs[which, V_MINUS])
    u[after[hit] - 1], v[after[hit] - 1] = model.sigma, legs[which, V_MINUS][hit]
    return np.concatenate(times), u, v
