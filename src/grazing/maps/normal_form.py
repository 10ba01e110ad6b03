"""From a physical model to the normal form: the gap map (2.6) at the graze of the steady response."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import copysign, inf, isfinite, nan, sin, ulp
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.maps.gap import border, gap_map
from grazing.maps.map import Map
from grazing.maps.reduction import graze_search_of, mu_factor, reduction_of, steady_low
from grazing.oscillator.constants import Constants, constants_of, steady_response
from grazing.oscillator.model import Oscillator, checked_model
from grazing.oscillator.parameters import damped, describe_parameter
from grazing.oscillator.reset import in_python
from grazing.oscillator.spring import refuse_stiffness
from grazing.outcome import InputError, OutsideForm, shown
from grazing.parameter import checked_name, in_order, parameters, real

#: Without damping, sin(k T/2) that is 0 to rounding: k is a multiple of omega.
RESONANT = 1e-12
#: Low points of the steady response that differ by less than this share of its swing are equally low.
LEVEL = 1e-9
#: Samples in a period of the highest harmonic, between which a low point is looked for; steps of Newton's method.
SAMPLES, STEPS = 256, 6


def constants(model: Oscillator) -> Constants:
    """Return the constants of a model at local time t = 0, in plain Python."""
    return constants_of(model.harmonics)(parameters(model.params))  # type: ignore[no-any-return]


def steady_minimum(model: Oscillator) -> tuple[float, float]:
    """Return (time in [0, T), height above the wall) of the lowest point of the steady response without impacts.

    Raises
    ------
    OutsideForm
        If there is no steady response: k = 0 with a constant force, or k a multiple of omega without damping.
    """
    c = constants(model)
    if c.alpha < 0.0:
        raise OutsideForm(f"alpha = {c.alpha:g}: the steady response repels; the graze needs alpha >= 0")
    if c.alpha == 0.0 and abs(sin(0.5 * c.p.k * c.T)) <= RESONANT:
        turns = c.p.k / c.omega
        raise OutsideForm(
            f"alpha = 0 and k = {turns:.0f} omega: at this resonance there is no steady response, or one of a "
            "continuum; change k or omega, or give alpha > 0"
        )
    if c.k2 == 0.0 and c.F0 != 0.0:
        raise OutsideForm("k = 0 with a constant force: the ball drifts for ever; the graze needs k > 0")
    return steady_low(c)


def lowest_points(c: Constants) -> NDArray[np.float64]:
    """Return the times in [0, T) of all low points of the steady response that are as low as the lowest."""
    order = np.arange(1.0, len(c.hc) + 1.0)[:, None]
    cos, sin = np.array(c.hc)[:, None], np.array(c.hs)[:, None]

    def moved(phase: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Return the sum of the harmonics, and its first and second derivative in the phase."""
        C, S = np.cos(order * phase), np.sin(order * phase)
        y = cos * C + sin * S
        return y.sum(axis=0), (order * (sin * C - cos * S)).sum(axis=0), (-order * order * y).sum(axis=0)

    count = SAMPLES * len(order)
    phase = 2.0 * np.pi * np.arange(count) / count
    height = moved(phase)[0]
    low = phase[(height < np.roll(height, 1)) & (height <= np.roll(height, -1))]
    for _ in range(STEPS):
        _height, slope, bend = moved(low)
        low = low - np.divide(slope, bend, out=np.zeros(len(low)), where=bend > 0.0)
    depth = moved(low)[0]
    level = depth <= depth.min(initial=0.0) + LEVEL * np.ptp(height)
    return np.sort((low[level] - c.theta) % (2.0 * np.pi)) / c.omega


def _numbers(values: ArrayLike, name: str, last: int = 0) -> NDArray[np.float64]:
    """Return finite numbers in an array, of shape (..., last) if given, or raise InputError."""
    try:
        found = np.asarray(in_order(values))
    except Exception:  # of whatever object was given
        found = np.empty(0, object)
    fits = not last or found.shape[-1:] == (last,)
    if found.dtype.kind not in "iuf" or not fits or not np.isfinite(found).all():
        raise InputError(f"{name} = {shown(values)}; give finite numbers" + f" of shape (..., {last})" * bool(last))
    return found.astype(np.float64)


def clearance_of(model: Oscillator, name: str) -> Callable[[float], float]:
    """Return the height of the steady response's lowest point as a function of one parameter."""
    return lambda value: steady_minimum(model.replace(**{name: value}))[1]


def true_graze(model: Oscillator, name: str) -> float:
    """Return the value of a parameter, the nearest one to the model's, at which the steady response grazes the wall.

    Parameters
    ----------
    model : Oscillator
    name : str
        A parameter on which the steady response depends.

    Raises
    ------
    OutsideForm
        If no graze is found within the parameter's range (searched outwards to 1000 times the present value).
    """
    checked_name(name, model.params, "the model")
    clearance = clearance_of(model, name)
    now = model.params[name]
    here = clearance(now)
    if here == 0.0:
        return now
    if name in model.reset.params or name == "t0":
        raise OutsideForm(f"the graze does not depend on {name}; vary a parameter of the flight, such as the offset")
    known, unit = damped(describe_parameter(name)), model.unit_of(name)
    low = known.low if known.low > -inf else now - 1e3 * max(unit, abs(now))
    high = known.high if known.high < inf else now + 1e3 * max(unit, abs(now))
    found = graze_search_of(_height)((model, name), now, low, high, known.low > -inf and known.open == "low", unit)
    if isfinite(found):
        return found
    raise OutsideForm(
        f"no graze of the steady response found for {name} in [{low:g}, {high:g}] around {now:g}; "
        "vary another parameter, or start nearer"
    )


def _height(value: float, context: tuple[Oscillator, str]) -> float:
    model, name = context
    try:
        return clearance_of(model, name)(value)
    except (InputError, OutsideForm):
        return nan


@dataclass(frozen=True)
class NormalForm:
    """The reduction of a model near its graze; made by :func:`normal_form`.

    Attributes
    ----------
    model : Oscillator
        The model at the graze.
    name : str
        The parameter that unfolds the graze.
    graze : float
        Its value at the graze.
    time : float
        Phase in [0, T) at which the steady response touches the wall.
    acceleration : float
        A > 0, the acceleration there.
    lam, l, b : float
        Trace of exp(BT); V/(2 A b (1+r)^2); upper right entry of exp(BT).
    det : float
        exp(-alpha T): what the one-dimensional map neglects. It is 1 without damping, where the steady response exists
        but attracts nothing, so that the gap map does not apply: use :meth:`xy_map`.
    scale : float
        (2 A b (1+r))^2; x = v^2 - 2A(u - sigma) is scale times the gap map's x.
    r, V : float
        The law near zero speed: v_plus = -r v_minus + V.
    """

    model: Oscillator
    name: str
    graze: float
    time: float
    acceleration: float
    lam: float
    l: float
    b: float
    det: float
    scale: float
    r: float
    V: float
    entries: tuple[float, float, float, float]

    def __repr__(self) -> str:
        where = f"{self.name}={self.graze:.12g}"
        neglected = "" if self.det < 0.01 else f", det={self.det:.6g}, which the gap map neglects"
        if self.model.params["alpha"] == 0.0:
            neglected = ", det=1: without damping the steady response attracts nothing"
        return f"<NormalForm {where} at the graze: lam={self.lam:.6g}, l={self.l + 0.0:.6g}, b={self.b:.6g}{neglected}>"

    def mu(self, value: ArrayLike) -> Any:
        """Return μ for values of the parameter: -(height of the steady response) det(I - exp(BT))/(2 A b^2 (1+r)^2).

        This is the paper's [(d g1 - b g2) - g1]/(2 A b^2 (1+r)^2), since g = (I - exp(BT)) w at the steady state w.
        """
        clearance = clearance_of(self.model, self.name)
        factor = mu_factor(self.lam, self.det, self.acceleration, self.b, self.r)
        values = _numbers(value, self.name)
        found = np.array([factor * clearance(x) for x in values.ravel().tolist()]).reshape(values.shape)
        return found if values.ndim else float(found)

    def parameter(self, mu: float) -> float:
        """Return the value of the parameter at which μ is ``mu``, on the branch through the graze."""
        from grazing.late import optimize

        mu = real(mu, "mu", "give a finite number")
        if mu == 0.0:
            return self.graze
        h = 1e-4 * max(self.model.unit_of(self.name), abs(self.graze))
        slope = (self.mu(self.graze + h) - self.mu(self.graze - h)) / (2.0 * h)
        if slope == 0.0:
            raise OutsideForm(f"μ does not change with {self.name} at the graze; vary another parameter")
        far = self.graze + mu / slope
        if abs(mu) <= abs(self.mu(self.graze)) or abs(far - self.graze) <= 4.0 * ulp(self.graze):  # that is rounding
            return float(far)
        for factor in (1.0 + 1e-9, 1.05, 1.3, 2.0, 4.0):
            edge = self.graze + factor * (far - self.graze)
            try:
                if (self.mu(edge) - mu) * copysign(1.0, mu) >= 0.0:
                    return float(
                        optimize.brentq(
                            lambda x: self.mu(x) - mu, *sorted((self.graze, edge)), xtol=1e-300, rtol=8.9e-16
                        )
                    )
            except (InputError, OutsideForm):
                break
        raise OutsideForm(f"no value of {self.name} near the graze {self.graze:g} gives μ = {mu:g}")

    def gap_map(self, value: float | None = None) -> Map:
        """Return the gap map (2.6) at a parameter value (default: the graze), for λ of either sign.

        With T = 2π/ω and without overdamping λ = 2 exp(-αT/2) cos(ω_d T) and b = exp(-αT/2) sin(ω_d T)/ω_d, where
        ω_d^2 = k^2 - α^2/4: λ < 0 where ω_d/ω is within 1/4 of an odd multiple of 1/2, b > 0 where its fractional part
        is below 1/2. With overdamping both are positive. The theory of Section 3 needs 0 < λ < 1, and for other λ the
        functions of :mod:`grazing.theory` refuse by name.

        Raises
        ------
        OutsideForm
            If b <= 0: the square root then enters with the other sign, outside (2.6).
        """
        if self.b <= 0.0:
            raise OutsideForm(
                f"b = {self.b:g} <= 0: the square root enters with a plus sign, outside the gap map (2.6); use xy_map()"
            )
        return gap_map(self.lam, self.mu(self.graze if value is None else value), self.l)

    def to_xy(self, states: ArrayLike) -> NDArray[np.float64]:
        """Return (x, y) of states (u, v) at the section through the graze, shape (..., 2).

        x = v^2 - 2A(u - sigma); y = -[d x + 2Abv + 2A(d g1 - b g2)]. Then x' - v'^2 = λ x + y + ρ - a v^2 exactly,
        ρ = 2A[(d g1 - b g2) - g1]: the paper's linear map holds up to the squares of the velocities.
        """
        w = _numbers(states, "states", 2)
        _a, b, _c, d = self.entries
        g1, g2 = self._drift(self.model)
        A = self.acceleration
        x = w[..., 1] ** 2 - 2.0 * A * (w[..., 0] - self.model.sigma)
        return np.stack([x, -(d * x + 2.0 * A * b * w[..., 1] + 2.0 * A * (d * g1 - b * g2))], axis=-1)

    def from_xy(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the states (u, v) of points (x, y); the inverse of :meth:`to_xy`."""
        q = _numbers(points, "points", 2)
        _a, b, _c, d = self.entries
        g1, g2 = self._drift(self.model)
        A = self.acceleration
        v = -(q[..., 1] + d * q[..., 0] + 2.0 * A * (d * g1 - b * g2)) / (2.0 * A * b)
        return np.stack([(v * v - q[..., 0]) / (2.0 * A) + self.model.sigma, v], axis=-1)

    def _drift(self, model: Oscillator) -> tuple[float, float]:
        """Return (g1, g2) of the period without impact, for y = u - sigma, at the phase of the graze."""
        y, v = steady_response(self.time, constants(model))
        a, b, c, d = self.entries
        return y - a * y - b * v, v - c * y - d * v

    def xy_map(self, value: float | None = None) -> Map:
        """Return the two-dimensional map in (x, y) that the gap map comes from; any sign of b and λ.

        x' = λ x + y + ρ, y' = -det x; for x >= 0 less 2Ab((1+r) sqrt(x) + V). The gap map drops y, and λ x for x >= 0.
        In units of ``scale`` the root has the coefficient 1 where b > 0, and ρ is ``mu(value)``: with V = 0 these are
        α = ``lam``, γ = ``det``, τ = ``r`` and ρ of Chin, Ott, Nusse and Grebogi (1994), but for terms of order x where
        there is an impact.
        """
        rho = self.mu(self.graze if value is None else value) * self.scale + 0.0
        kick = 2.0 * self.acceleration * self.b
        return Map(
            pieces={"L": xy_left, "R": xy_right},
            border=border,
            params={
                "lam": self.lam, "det": self.det, "rho": rho,
                "root": kick * (1.0 + self.r), "jump": kick * self.V + 0.0,
            },
            coordinates=("x", "y"),
            box=((-self.scale, self.scale), (-self.scale, self.scale)),
            name="(x, y) map",
        )  # fmt: skip


def xy_left(state: Any, p: Any) -> Any:
    """Apply the two-dimensional square-root map where no impact is made, or would be."""
    x, y = state
    return p.lam * x + y + p.rho, -p.det * x


def xy_right(state: Any, p: Any, root: Any) -> Any:
    """Apply the two-dimensional square-root map with an impact."""
    x, y = state
    return p.lam * x + y + p.rho - (p.root * root + p.jump), -p.det * x


@lru_cache(maxsize=64)
def slope_at_rest(law: Callable[..., float], h: float) -> Callable[..., float]:
    """Return the slope of a law at rest, by a step h of the model's own: at rest a law knows no speed to step by."""

    def slope(_v: float, p: Any) -> float:
        return (3.0 * law(0.0, p) - 4.0 * law(-h, p) + law(-2.0 * h, p)) / (2.0 * h)

    return slope


def normal_form(model: Oscillator, name: str) -> NormalForm:
    """Reduce a model near the graze of its steady response to the gap map: λ, l and μ as a function of a parameter.

    Parameters
    ----------
    model : Oscillator
        Any model with a steady response, without damping also one that does not attract.
    name : str
        The parameter to unfold the graze with, such as ``"d"`` or ``"omega"``.

    Returns
    -------
    NormalForm
        Found at the true graze: the value of the parameter and the phase at which the steady response touches the
        wall, with the acceleration there.

    Raises
    ------
    OutsideForm
        Without a steady response, without a graze, with zero acceleration at the graze, or where the steady response
        touches the wall at several instants of a period.

    Notes
    -----
    There is one contact in it. A response with a second low point that is nearly as low touches the wall there as well
    a little beyond the graze: the form holds up to that value of the parameter, which may be very near.

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, section 2.2; the printed parameters of Figure 3.2 take
    cos(omega t0) for the acceleration, which is not the acceleration at the graze.

    Examples
    --------
    >>> import grazing as gz
    >>> nf = gz.normal_form(gz.pinball(alpha=3, k=1, omega=2.2, r=0.8, V=0.4), "d")
    >>> round(nf.graze, 12), round(nf.lam, 6), round(nf.l, 6), round(nf.acceleration, 6)
    (0.13096186935, 0.336482, 0.649353, 0.633855)
    """
    checked_model(model)
    refuse_stiffness(model, "the normal form at the graze of a steady response that attracts")
    value = true_graze(model, name)
    at = model.replace(**{name: value})
    c = constants(at)
    law, slow = in_python(at.reset.law), 1e-3 * at.unit_of("V")
    slope = in_python(at.reset.slope) if at.reset.exact_slope else slope_at_rest(law, 1e-2 * slow)
    found = reduction_of(law, slope)(c)
    A, b, r, V = found.acceleration, found.b, found.r, found.V
    if A <= 1e-12 * c.force:
        raise OutsideForm(f"the acceleration at the graze is {A:g}: the contact is degenerate, outside the normal form")
    touches = lowest_points(c)
    if len(touches) > 1:
        raise OutsideForm(
            f"the steady response touches the wall {len(touches)} times in a period, at t = "
            f"{', '.join(f'{t:.6g}' for t in touches)}: the normal form has one contact in it; where the force repeats "
            "itself so often, give it the omega that it has"
        )
    at_speed = at.reset(-slow)
    if not abs(at_speed - V - slow * r) <= 0.1 * slow + 1e-4 * V:
        raise OutsideForm(
            f"the reset law {at.reset.name} is not linear near zero speed (v_plus = {V:g} at rest, {at_speed:g} at "
            f"v_minus = {-slow:g}, slope {-r:g}): outside the normal form"
        )
    if b == 0.0:
        raise OutsideForm("b = 0: the square root drops out, outside the normal form")
    return NormalForm(
        model=at, name=name, graze=value, time=found.time, acceleration=A, lam=found.lam, l=found.l, b=b,
        det=found.det, scale=found.scale, r=r, V=V, entries=(found.a, b, found.e21, found.d),
    )  # fmt: skip
