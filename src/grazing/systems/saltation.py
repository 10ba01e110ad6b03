"""The derivative of flights and impacts: of a flight by its start, and the saltation matrix of an impact.

With the law L(t, x) and the gap h, whose gradient is h_x and whose rate along the flight is h', a small change of the
state just before an impact becomes, just after it and at the same time,

    S = L_x + (f_plus - L_x f_minus - L_t) h_x / h'

with the flows f before and after, and the impact comes later by -h_x / h' times the change. All are derivatives of
closed forms, taken by five-point differences: good to about eleven digits, in any unit.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import pi
from typing import Any

from grazing.kernel.primitives import replaced
from grazing.systems.contact import Asked

#: Share of a coordinate's width, and of the time in which a flight turns, over which differences reach.
SHARE = 1e-3


@lru_cache(maxsize=16)
def product_of(n: int) -> Callable[..., Any]:
    """Return ``product(a, b)`` of n x n matrices, row by row in one flat tuple."""
    zero = (0.0,) * (n * n)

    def product(a: Any, b: Any) -> Any:
        found = zero
        for i in range(n):
            for j in range(n):
                total = 0.0
                for k in range(n):
                    total += a[i * n + k] * b[k * n + j]
                found = replaced(found, i * n + j, total)
        return found

    return product


def slope(after: float, before: float, far: float, back: float, h: float) -> float:
    """Return a derivative from values at +h, -h, +2h and -2h: exact for polynomials of degree four."""
    return (8.0 * (after - before) - (far - back)) / (12.0 * h)


@lru_cache(maxsize=256)
def derivative_of(fly: Callable[..., Any], n: int) -> Callable[..., Any]:
    """Return ``derivative(t, t0, state, widths, p)``: that of the flight by the n numbers at t0, row by row."""
    zero = (0.0,) * (n * n)

    def derivative(t: float, t0: float, state: Any, widths: Any, p: Any) -> Any:
        found = zero
        for j in range(n):
            h, x = SHARE * max(widths[j], abs(state[j])), state[j]
            a, b = fly(t, t0, replaced(state, j, x + h), p), fly(t, t0, replaced(state, j, x - h), p)
            c, d = fly(t, t0, replaced(state, j, x + 2.0 * h), p), fly(t, t0, replaced(state, j, x - 2.0 * h), p)
            for i in range(n):
                found = replaced(found, i * n + j, slope(a[i], b[i], c[i], d[i], h))
        return found

    return derivative


@lru_cache(maxsize=256)
def flow_of(asked: Asked, n: int) -> Callable[..., Any]:
    """Return ``flow(t, state, s, p)``: the rate of each coordinate along a flight, from states s before and after."""
    fly, zero = asked.flight, (0.0,) * n

    def flow(t: float, state: Any, s: float, p: Any) -> Any:
        a, b = fly(t + s, t, state, p), fly(t - s, t, state, p)
        c, d = fly(t + 2.0 * s, t, state, p), fly(t - 2.0 * s, t, state, p)
        found = zero
        for i in range(n):
            found = replaced(found, i, slope(a[i], b[i], c[i], d[i], s))
        return found

    return flow


@lru_cache(maxsize=256)
def moment_of(asked: Asked, n: int) -> Callable[..., Any]:
    """Return ``moment(j, t, state, widths, p)``: a time in which the flight near surface j hardly turns."""
    bound, period = asked.bound, asked.period

    def moment(j: int, t: float, state: Any, widths: Any, p: Any) -> float:
        speed = 0.0
        for i in range(n // 2, n):
            speed += max(widths[i], abs(state[i]))
        M = bound(j, t, 0.0, state, p)
        turn = period(p) / (2.0 * pi)
        return SHARE * (min(speed / M, turn) if M > 0.0 else turn)  # type: ignore[no-any-return]

    return moment


@lru_cache(maxsize=256)
def saltation_of(asked: Asked, n: int) -> Callable[..., Any]:
    """Return ``saltation(j, t, before, after, widths, p) -> (S, later)`` of an impact with surface j.

    ``later`` is how much later the impact comes, by the n numbers before it. Both are infinite where h' is 0.
    """
    gap, law = asked.gap, asked.law
    flat, zero = (0.0,) * (n * n), (0.0,) * n
    flow, moment = flow_of(asked, n), moment_of(asked, n)

    def saltation(j: int, t: float, before: Any, after: Any, widths: Any, p: Any) -> Any:
        s = moment(j, t, before, widths, p)
        first, then = flow(t, before, s, p), flow(t, after, s, p)
        Lx, hx = flat, zero
        for j2 in range(n):
            h, x = SHARE * max(widths[j2], abs(before[j2])), before[j2]
            one, two = replaced(before, j2, x + h), replaced(before, j2, x - h)
            far, back = replaced(before, j2, x + 2.0 * h), replaced(before, j2, x - 2.0 * h)
            (g1, _), (g2, _) = gap(j, t, one, p), gap(j, t, two, p)
            (g3, _), (g4, _) = gap(j, t, far, p), gap(j, t, back, p)
            hx = replaced(hx, j2, slope(g1, g2, g3, g4, h))
            a, b, c, d = law(j, t, one, p), law(j, t, two, p), law(j, t, far, p), law(j, t, back, p)
            for i in range(n):
                Lx = replaced(Lx, i * n + j2, slope(a[i], b[i], c[i], d[i], h))
        a, b = law(j, t + s, before, p), law(j, t - s, before, p)
        c, d = law(j, t + 2.0 * s, before, p), law(j, t - 2.0 * s, before, p)
        _h, rate = gap(j, t, before, p)
        found, later = flat, zero
        for k in range(n):
            later = replaced(later, k, -hx[k] / rate)
        for i in range(n):
            jump = then[i] - slope(a[i], b[i], c[i], d[i], s)
            for k in range(n):
                jump -= Lx[i * n + k] * first[k]
            for k in range(n):
                found = replaced(found, i * n + k, Lx[i * n + k] + jump * hx[k] / rate)
        return found, later

    return saltation
