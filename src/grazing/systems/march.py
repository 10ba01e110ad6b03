"""The first contact of a flight with any of several surfaces: no crossing can be jumped over. Proof: docs/march.md.

Of each surface a time is kept up to which the flight is proven free of it. The earliest such time is looked at
again, which proves more; a surface that the flight surely crosses gives a bracket. What is nearer than rounding is
*ambiguous*.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import sqrt
from typing import Any, NamedTuple

from grazing.kernel.primitives import replaced
from grazing.outcome import AMBIGUOUS, BAD_LAW, DIVERGED, GRAZE, INSIDE_WALL, OK, TOO_MANY_IMPACTS, TOO_MANY_SWINGS

INFINITY = float("inf")
EPS = 2.0**-52
#: Looks in one flight after which it ends by name: time scales are too far apart, or a bound is far too large.
LOOKS = 1_000_000
#: A step shorter than so many widths of the rounding error is none.
LEAST = 1e-3
#: Rounding errors by which a gap may be negative where it was proven to be none, or where it was just left: what is
#: proven holds of the exact flight, and that begins a rounding error away from the surface.
MANY = 4.0
#: Rounding errors that slow impacts in doubt may let a state sink into a surface before the flight ends by name.
DEEP = 64.0
#: In the place of the surface just left: whichever the flight rises from at t0, to rounding.
WHICHEVER = -2.0
#: The same, and from inside it too, however deep: the flights of points on a surface go on smoothly beside it.
RISING = -3.0
#: Steps of a root in its bracket; each that Newton's method does not take halves it.
ROOTS = 200
#: What is wrong with a user's functions, beside the outcome.
BOUND_BROKEN, LAW_BROKEN = 1, 2


class Kernels(NamedTuple):
    """The functions of a system as the march calls them: ``gap``, ``bound`` and ``law`` with the surface in front."""

    flight: Callable[..., Any]
    gap: Callable[..., Any]
    bound: Callable[..., Any]
    law: Callable[..., Any]
    rounding: Callable[..., Any]


def newton_along(gap: Callable[..., Any], positions: int, r: int) -> Callable[..., Any]:
    """Return Newton's law of a surface: the rate dh becomes -r dh by a push along the normal, masses being equal.

    dh is affine in the velocities; its coefficients n are read from it.
    """
    zero = (0.0,) * positions

    def law(t: float, state: Any, p: Any) -> Any:
        rest = state
        for i in range(positions):
            rest = replaced(rest, positions + i, 0.0)
        _h, carried = gap(t, rest, p)
        n, size = zero, 0.0
        for i in range(positions):
            _h, rate = gap(t, replaced(rest, positions + i, 1.0), p)
            n = replaced(n, i, rate - carried)
            size += (rate - carried) * (rate - carried)
        _h, rate = gap(t, state, p)
        after = state
        for i in range(positions):
            push = (1.0 + p[r]) * rate * n[i] / size
            after = replaced(after, positions + i, state[positions + i] - push)
        return after

    return law


@lru_cache(maxsize=256)
def kernels_of(positions: int, flight: Callable[..., Any], rounding: Any, *flat: Any) -> Kernels:
    """Return the kernels of a system from :attr:`grazing.systems.contract.System.parts`."""
    zero = (0.0,) * (2 * positions)
    gaps, bounds, laws, restitution = (flat[i::4] for i in range(4))
    laws = tuple(law or newton_along(gap, positions, r) for gap, law, r in zip(gaps, laws, restitution, strict=True))

    def fly(t: float, t0: float, state: Any, p: Any) -> Any:
        new, found = flight(t, t0, state, p), zero
        for i in range(len(zero)):
            found = replaced(found, i, new[i])
        return found

    return Kernels(fly, _gap_of(gaps), _bound_of(bounds), _law_of(laws, zero), rounding)


def _gap_of(gaps: tuple[Any, ...], i: int = 0) -> Callable[..., Any]:
    """Return ``gap(j, t, state, p)``: of surface j."""
    own = gaps[i]

    def last(_j: int, t: float, state: Any, p: Any) -> Any:
        h, dh = own(t, state, p)
        return 1.0 * h, 1.0 * dh

    if i == len(gaps) - 1:
        return last
    others = _gap_of(gaps, i + 1)

    def gap(j: int, t: float, state: Any, p: Any) -> Any:
        if j == i:
            h, dh = own(t, state, p)
            return 1.0 * h, 1.0 * dh
        return others(j, t, state, p)

    return gap


def _bound_of(bounds: tuple[Any, ...], i: int = 0) -> Callable[..., Any]:
    """Return ``bound(j, t, w, state, p)``: of surface j."""
    own = bounds[i]

    def last(_j: int, t: float, w: float, state: Any, p: Any) -> float:
        return 1.0 * own(t, w, state, p)  # type: ignore[no-any-return]

    if i == len(bounds) - 1:
        return last
    others = _bound_of(bounds, i + 1)

    def bound(j: int, t: float, w: float, state: Any, p: Any) -> float:
        if j == i:
            return 1.0 * own(t, w, state, p)  # type: ignore[no-any-return]
        return others(j, t, w, state, p)  # type: ignore[no-any-return]

    return bound


def _law_of(laws: tuple[Any, ...], zero: tuple[float, ...], i: int = 0) -> Callable[..., Any]:
    """Return ``law(j, t, state, p)``: of surface j."""
    own = laws[i]

    def last(_j: int, t: float, state: Any, p: Any) -> Any:
        new, found = own(t, state, p), zero
        for k in range(len(zero)):
            found = replaced(found, k, new[k])
        return found

    if i == len(laws) - 1:
        return last
    others = _law_of(laws, zero, i + 1)

    def law(j: int, t: float, state: Any, p: Any) -> Any:
        if j == i:
            new, found = own(t, state, p), zero
            for k in range(len(zero)):
                found = replaced(found, k, new[k])
            return found
        return others(j, t, state, p)

    return law


@lru_cache(maxsize=256)
def march_of(*parts: Any) -> Callable[..., Any]:
    """Return ``march(t0, state, end, left, p) -> (surface, t, flags, broken)``: the first contact after t0, up to end.

    ``left`` is the surface that was just left, which it touches at t0, -1 for none, :data:`WHICHEVER` or
    :data:`RISING`, as a float: a literal would be a type of its own. ``surface`` is -1 for no contact up to and with
    ``end``, ``flags`` are bits of an outcome, ``broken`` says what is wrong with a user's functions, or is 0.
    """
    flight, gap, bound, _law, rounding = kernels_of(*parts)
    n = (len(parts) - 3) // 4
    zero = (0.0,) * n

    def landing(j: int, a: float, b: float, t: float, level: float, t0: float, state: Any, p: Any) -> float:
        """Return where a gap comes down to a level in [a, b], beginning at t."""
        for _ in range(ROOTS):
            h, dh = gap(j, t, flight(t, t0, state, p), p)
            h -= level
            if h > 0.0:
                a = t
            else:
                b = t
            new = t - h / dh if dh < 0.0 else 0.5 * (a + b)
            if not a <= new <= b:
                new = 0.5 * (a + b)
            if abs(new - t) <= EPS * abs(t) or not a < b:
                return new
            t = new
        return t

    def consistent(hit: int, t: float, t0: float, state: Any, p: Any, offset: Any) -> bool:
        """Say whether a flight ends outside of all surfaces: a cheap look at promises that were not kept."""
        now, found = flight(t, t0, state, p), True
        for i in range(n):
            h, dh = gap(i, t, now, p)
            e, _d = rounding(t, t0, state, now, h, dh, p)
            if i != hit and h < -MANY * (e + offset[i]):
                found = False
        return found

    def march(t0: float, state: Any, end: float, left: float, p: Any) -> Any:
        safe, width, doubt, offset = zero, zero, zero, zero
        for i in range(n):
            safe, width, doubt = replaced(safe, i, t0), replaced(width, i, end - t0), replaced(doubt, i, INFINITY)
        hit, best, slack, flags = -1, end, 0.0, OK
        for _ in range(LOOKS):
            j, t = 0, safe[0]
            for i in range(1, n):
                if safe[i] < t:
                    j, t = i, safe[i]
            if t > min(best + slack, end):
                if flags == OK and not consistent(hit, best, t0, state, p, offset):
                    return -1, best, BAD_LAW, BOUND_BROKEN
                return hit, best, flags, 0
            now = flight(t, t0, state, p)
            w = min(width[j], end - t)
            h, dh = gap(j, t, now, p)
            M = bound(j, t, w, now, p)
            e, d = rounding(t, t0, state, now, h, dh, p)
            if not (abs(h) < INFINITY and abs(dh) < INFINITY and M != INFINITY and e + d != INFINITY):
                return hit, t, flags | DIVERGED, 0
            if not (M >= 0.0 and e >= 0.0 and d >= 0.0):
                return j, t, flags | BAD_LAW, BOUND_BROKEN
            fresh, dipped = t == t0 and left == j, False
            if t == t0 and left <= WHICHEVER and dh > d and h <= MANY * e:
                fresh = left == RISING or -DEEP * e <= h
            if fresh and h < -DEEP * e and left != RISING:  # sunk in by impacts in doubt: chatter that nothing resolves
                return -1, t, flags | AMBIGUOUS | TOO_MANY_IMPACTS, 0
            if t == t0 and (fresh or (h < 0.0 and h >= -MANY * e)):
                offset = replaced(offset, j, abs(h))
            e += offset[j]
            if h < -e and not fresh:
                if t == t0 and h < -MANY * e:
                    return j, t, flags | INSIDE_WALL, 0
                if t > t0 and doubt[j] == INFINITY and h < -MANY * e:  # proven free up to here: a promise is broken
                    return j, t, flags | BAD_LAW, BOUND_BROKEN
                if doubt[j] < INFINITY and dh + d >= 0.0:  # it went through and back, by less than can be decided
                    before, rate = gap(j, doubt[j], flight(doubt[j], t0, state, p), p)
                    if rate < 0.0:
                        t, h, dh, dipped = doubt[j], before, rate, True
            up, rate = h + e, dh + d
            if fresh:  # it is at 0 and leaves
                h, up = 0.0, INFINITY
            sure = dipped or (rate < 0.0 and rate * rate > 2.0 * M * up)
            reach = 0.0
            if sure and not dipped and up > 0.0:
                reach = 2.0 * up / (sqrt(rate * rate - 2.0 * M * up) - rate)
            if sure and t >= end and h <= e:
                flags |= AMBIGUOUS  # in this flight or at the beginning of the next
            if sure and (reach <= w or (t >= end and h <= 0.0)):
                if up < 0.0 and doubt[j] < INFINITY and not dipped:  # back to where it was in doubt, and no deeper
                    level, _rate = gap(j, doubt[j], flight(doubt[j], t0, state, p), p)
                    at = landing(j, doubt[j], t, t, min(level, 0.0), t0, state, p)
                    _level, falls = gap(j, at, flight(at, t0, state, p), p)
                    at = at if falls < 0.0 else t  # a law is asked only where it comes down
                else:
                    at = landing(j, t, t + min(reach, w), t, 0.0, t0, state, p)
                late = (e + d * reach) / max(-rate, d) + 2.0 * EPS * abs(t)
                if at + late >= end or (hit >= 0 and abs(at - best) <= late + slack):
                    flags |= AMBIGUOUS  # in which flight, or which of two surfaces first
                if hit < 0 or at < best:
                    hit, best, slack = j, at, late
                safe = replaced(safe, j, INFINITY)
                continue
            low, fall = max(h - e, 0.0), dh - d
            least = 2.0 * sqrt(2.0 * e / M) if M > 0.0 else INFINITY
            if fall != 0.0:
                least = min(least, 4.0 * e / abs(fall))
            step = INFINITY
            if M > 0.0:
                root = sqrt(fall * fall + 2.0 * M * low)
                step = 2.0 * low / (root - fall) if fall < 0.0 else (fall + root) / M
            elif fall < 0.0:
                step = low / -fall
            step = step * (1.0 - 16.0 * EPS) - 2.0 * EPS * abs(t)
            if step > w:
                safe = replaced(safe, j, INFINITY if t + w >= end else t + w)
                width, doubt = replaced(width, j, 4.0 * w), replaced(doubt, j, INFINITY)
                continue
            if (step < LEAST * least and low < e) or not t + step > t:
                if sure:  # it comes down at the very end of the flight, so that one looks there once more
                    flags |= AMBIGUOUS
                    safe = replaced(safe, j, end if t < end else INFINITY)
                    continue
                flags |= GRAZE | AMBIGUOUS
                step = max(least, 4.0 * EPS * abs(t))
                doubt = replaced(doubt, j, t)
            elif low > 0.0:
                doubt = replaced(doubt, j, INFINITY)
            safe = replaced(safe, j, t + step if t + step <= end else INFINITY)
            width = replaced(width, j, max(4.0 * step, least))
        return hit, safe[0], flags | TOO_MANY_SWINGS, 0

    return march
