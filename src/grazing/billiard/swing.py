"""A ball that slides on a circle: a pendulum, by Taylor series with a proven remainder. Proof: docs/table.md.

The normal at the ball has the polar angle a, and turns with the rate w = kappa u where the ball moves with the speed u
along a surface of curvature kappa. With b = kappa gamma it follows a'' = -b cos a.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

from grazing.kernel.elementary import sincos
from grazing.kernel.primitives import inlined, replaced
from grazing.outcome import AMBIGUOUS, OK, TOO_MANY_SWINGS

INFINITY = float("inf")
#: Terms of a series and its step, in units of 1/max(|w|, sqrt|b|): the remainder is below 1.32 6^-20/5 < 1e-16.
TERMS, STEP = 20, 0.125
ZEROS = (0.0,) * (TERMS + 1)
#: Steps after which a slide ends by name, and halvings of an interval with a root.
MOST, HALVINGS = 1_000_000, 60
#: A turning point so near to a stop, in radians, is not told from one behind it.
NEAR = 1e-13


def series(a: float, w: float, b: float) -> Any:
    """Return the Taylor coefficients of the angle, from its value and rate."""
    angle, _sine = series_with_sine(a, w, b)
    return angle


@inlined
def series_with_sine(a: float, w: float, b: float) -> Any:
    """Return those of the angle and of its sine."""
    sine, cosine = sincos(a)
    angle, c, s = replaced(replaced(ZEROS, 0, a), 1, w), replaced(ZEROS, 0, cosine), replaced(ZEROS, 0, sine)
    for k in range(TERMS - 1):
        angle = replaced(angle, k + 2, -b * c[k] / ((k + 1.0) * (k + 2.0)))
        dc, ds = 0.0, 0.0
        for j in range(k + 1):
            rate = (j + 1.0) * angle[j + 1]
            dc -= rate * s[k - j]
            ds += rate * c[k - j]
        c, s = replaced(c, k + 1, dc / (k + 1.0)), replaced(s, k + 1, ds / (k + 1.0))
    return angle, s


def varied(sine: Any, b: float, y: float, rate: float) -> Any:
    """Return the Taylor coefficients of a small change y of the angle, y'' = b y sin a, from its value and rate."""
    found = replaced(replaced(ZEROS, 0, y), 1, rate)
    for k in range(TERMS - 1):
        push = 0.0
        for j in range(k + 1):
            push += sine[j] * found[k - j]
        found = replaced(found, k + 2, b * push / ((k + 1.0) * (k + 2.0)))
    return found


def value(terms: Any, t: float) -> Any:
    """Return what a series gives at a time, without its first term, and its rate."""
    found, rate = 0.0, 0.0
    for i in range(TERMS):
        k = TERMS - i
        rate = rate * t + found
        found = found * t + terms[k]
    return found * t, rate * t + found


def scale_of(w: float, b: float) -> float:
    """Return the rate that sets the step of a series."""
    return max(abs(w), sqrt(abs(b)))


def root(terms: Any, low: float, high: float, goal: float, of_rate: bool) -> float:
    """Return when the series, or its rate, has a value between two times, where it is monotone."""
    end = value(terms, high)
    up = (end[1] if of_rate else end[0]) > goal
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        found = value(terms, middle)
        now = found[1] if of_rate else found[0]
        if (now < goal) == up:
            low = middle
        else:
            high = middle
        if not high - low > 2.0**-52 * high:
            break
    return 0.5 * (low + high)


def swing(a: float, w: float, b: float, low: float, high: float, end: float) -> Any:
    """Return (t, turned, rate, which, flags): when a pendulum has turned by ``low`` <= 0 or by ``high`` >= 0.

    ``which`` is -1 or 1 then; 0 if it has not at the time ``end``, and infinity is the time of one that never does.
    """
    t, turned, rate, turns, flags, scale = 0.0, 0.0, w, 0, OK, scale_of(w, b)
    if scale == 0.0:
        return (end if end < INFINITY else INFINITY), 0.0, 0.0, 0, flags
    for _ in range(MOST):
        terms = series(a + turned, rate, b)
        step = min(STEP / scale_of(rate, b), end - t)
        there, new = value(terms, step)
        middle = step
        if rate * new < 0.0:
            middle = root(terms, 0.0, step, 0.0, True)
            turns += 1
        for part in range(2):
            begin, stop = (0.0, middle) if part == 0 else (middle, step)
            if not stop > begin:
                continue
            at = turned + value(terms, stop)[0]
            if part == 0 and middle < step and min(abs(at - high), abs(at - low)) <= NEAR:
                flags |= AMBIGUOUS
            for which in range(2):
                goal = high if which == 1 else low
                if (at > goal) if which == 1 else (at < goal):
                    s = root(terms, begin, stop, goal - turned, False)
                    return t + s, goal, value(terms, s)[1], 2 * which - 1, flags
        t, turned, rate = t + step, turned + there, new
        if not t < end:
            return end, turned, rate, 0, flags
        if end == INFINITY and (turns > 2 or abs(turned) > 7.0):
            return INFINITY, 0.0, w, 0, flags
    return t, turned, rate, 0, flags | TOO_MANY_SWINGS


def swung(a: float, w: float, b: float, end: float) -> Any:
    """Return (turned, rate) of a pendulum after a time."""
    if end <= 0.0 or scale_of(w, b) == 0.0:
        return 0.0, w
    _t, turned, rate, _which, _flags = swing(a, w, b, -INFINITY, INFINITY, end)
    return turned, rate


def swung_by(a: float, w: float, b: float, end: float) -> Any:
    """Return how angle and rate after a time depend on those before: (aa, ab, ba, bb), row by row."""
    t, aa, ab, ba, bb = 0.0, 1.0, 0.0, 0.0, 1.0
    scale = scale_of(w, b)
    if scale == 0.0:
        return 1.0, end, 0.0, 1.0
    for _ in range(MOST):
        angle, sine = series_with_sine(a, w, b)
        step = min(STEP / scale_of(w, b), end - t)
        one, other = varied(sine, b, aa, ba), varied(sine, b, ab, bb)
        (turned, w), (change, ba), (also, bb) = value(angle, step), value(one, step), value(other, step)
        a, aa, ab, t = a + turned, aa + change, ab + also, t + step
        if not t < end:
            break
    return aa, ab, ba, bb
