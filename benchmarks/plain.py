"""What a careful user would write with numba: every flight in closed form, orbit by orbit, no tricks for speed.

It is for over-damped models with one cosine, |d| < 1 and V > 0. The same lemma as in the library says where an
impact can be: where the force F presses the ball on the wall there is one exactly if the flight would end below the
wall, and where F pulls there is at most one, decided at the lowest point.
"""

from __future__ import annotations

from collections.abc import Callable
from math import acos, cos, exp, pi, sin, sqrt
from typing import Any, TypeVar

import numba
import numpy as np

from .models import STANDARD, Array, Columns, Model
from .program import Program

F = TypeVar("F", bound=Callable[..., Any])


def jit(function: F) -> F:
    """Compile a function when it is first called."""
    compiled: F = numba.njit(error_model="numpy")(function)
    return compiled


@jit
def moment(t: float, m: Any) -> Any:
    """Return a time with all that is expensive about it."""
    _alpha, _k2, omega, l1, l2, _a, _b, _d = m
    return t, cos(omega * t), sin(omega * t), exp(l1 * t), exp(l2 * t)


@jit
def flight(at: Any, c: Any, m: Any) -> Any:
    """Return u, v and the acceleration at a moment of the flight with the amplitudes c of the two decaying modes."""
    alpha, k2, omega, l1, l2, a, b, d = m
    _t, co, si, e1, e2 = at
    e1, e2 = c[0] * e1, c[1] * e2
    u = d / k2 + a * co + b * si + e1 + e2
    v = omega * (b * co - a * si) + l1 * e1 + l2 * e2
    return u, v, co + d - alpha * v - k2 * u


@jit
def modes(at: Any, du: float, dv: float, m: Any) -> Any:
    """Return the amplitudes of the modes that add (du, dv) at a moment."""
    l1, l2 = m[3], m[4]
    return (dv - l2 * du) / ((l1 - l2) * at[3]), (l1 * du - dv) / ((l1 - l2) * at[4])


@jit
def crossing(low: float, high: float, t: float, c: Any, m: Any) -> Any:
    """Return when u falls through 0 between low (above) and high (below): Newton's method, halving if it strays."""
    for _ in range(100):
        u, v, _a = flight(moment(t, m), c, m)
        if u >= 0.0:
            low = t
        else:
            high = t
        step = -u / v
        if abs(step) < 1e-12 or high - low < 1e-15:
            return t + step
        t = t + step if low < t + step < high else 0.5 * (low + high)
    return t


@jit
def lowest(low: float, high: float, c: Any, m: Any) -> Any:
    """Return where v - l2 u, which rises while the ball is pulled off the wall, is zero between low and high; and u."""
    t = 0.5 * (low + high)
    for _ in range(100):
        u, v, a = flight(moment(t, m), c, m)
        slope = v - m[4] * u
        if slope < 0.0:
            low = t
        else:
            high = t
        step = -slope / (a - m[4] * v)
        if abs(step) < 1e-9 or high - low < 1e-15:
            break
        t = t + step if low < t + step < high else 0.5 * (low + high)
    return t, u


@jit
def impact_pressed(start: Any, end: Any, c: Any, m: Any) -> Any:
    """Return the first impact in a window in which F presses the ball on the wall, or -1."""
    if flight(end, c, m)[0] >= 0.0:
        return -1.0
    u, v, a = flight(start, c, m)
    if v > 0.0 and u < 1e-14:  # just thrown off: about 2 v/|a| in the air, and more than half of it
        return crossing(start[0] - v / a, end[0], min(start[0] - 2.0 * v / a, end[0]), c, m)
    return crossing(start[0], end[0], 0.5 * (start[0] + end[0]), c, m)


@jit
def impact_pulled(start: Any, end: Any, c: Any, m: Any) -> Any:
    """Return the only impact in a window in which F pulls the ball off the wall, or -1."""
    u, v, _a = flight(start, c, m)
    if v - m[4] * u >= 0.0:
        return -1.0
    low, high = start[0], end[0]
    u, v, _a = flight(end, c, m)
    if u >= 0.0:
        if v - m[4] * u <= 0.0:
            return -1.0
        high, u = lowest(low, high, c, m)
        if u >= 0.0:
            return -1.0
    return crossing(low, high, 0.5 * (low + high), c, m)


@jit
def kicked(at: Any, c: Any, m: Any, r: float, V: float) -> Any:
    """Return the amplitudes of the modes after an impact."""
    _u, v, _a = flight(at, c, m)
    c1, c2 = modes(at, 0.0, V - r * v - v, m)
    return c[0] + c1, c[1] + c2


@jit
def period(u: float, v: float, strobe: Any, turn: Any, back: Any, end: Any, m: Any, r: float, V: float) -> Any:
    """Return the state one period later; F pulls until the moment ``turn``, presses until ``back``, pulls again."""
    u0, v0, _a = flight(strobe, (0.0, 0.0), m)
    c = modes(strobe, u - u0, v - v0, m)
    t = impact_pulled(strobe, turn, c, m)
    if t >= 0.0:
        c = kicked(moment(t, m), c, m, r, V)
    at = turn
    while True:
        t = impact_pressed(at, back, c, m)
        if t < 0.0:
            break
        at = moment(t, m)
        c = kicked(at, c, m, r, V)
    t = impact_pulled(back, end, c, m)
    if t >= 0.0:
        c = kicked(moment(t, m), c, m, r, V)
    u, v, _a = flight(end, c, m)
    return u, v


@jit
def column(m: Any, r: float, V: float, u0: Array, v0: Array, transient: int, keep: int, u: Array, v: Array) -> None:
    """Follow the orbits of one column."""
    T, half = 2.0 * pi / m[2], acos(-m[7]) / m[2]
    strobe, turn, back, end = moment(0.0, m), moment(half, m), moment(T - half, m), moment(T, m)
    for j in range(len(u0)):
        x, y = u0[j], v0[j]
        for n in range(transient + keep):
            x, y = period(x, y, strobe, turn, back, end, m, r, V)
            if n >= transient:
                u[n - transient, j], v[n - transient, j] = x, y


def program_of(model: Model) -> Program:
    """Return the program."""
    assert model == STANDARD, "written for the standard model"
    k2, spread = model.k**2, sqrt(model.alpha**2 / 4.0 - model.k**2)
    l2 = -model.alpha / 2.0 - spread
    size = (k2 - model.omega**2) ** 2 + (model.alpha * model.omega) ** 2
    a, b = (k2 - model.omega**2) / size, model.alpha * model.omega / size

    def program(columns: Columns, transient: int, keep: int) -> tuple[Array, Array]:
        shape = (len(columns.d), keep, columns.u.shape[1])
        u, v = np.empty(shape), np.empty(shape)
        for i, d in enumerate(columns.d):
            m = (model.alpha, k2, model.omega, k2 / l2, l2, a, b, float(d))
            column(m, model.r, model.V, columns.u[i], columns.v[i], transient, keep, u[i], v[i])
        return u, v

    return program
