"""Values of mu at which a point of a word's orbit is 0: zeros of one function, isolated by intervals."""

from __future__ import annotations

import math

__all__ = ["collisions"]

#: Relative slack of every interval operation, far above its rounding.
SLACK = 1e-14
#: A point may break the condition of its letter by so much of the greatest mu before a cell is given up.
LENIENT = 1e-9
#: Cells narrower than this part of the greatest mu are not halved again.
NARROWEST = 1e-15

Range = tuple[float, float]


def collisions(word: str, j: int, lam: float, l: float, low: float, high: float) -> list[float]:
    """Values of mu in [low, high] at which the admissible orbit of a word has its point j at the border 0.

    Notes
    -----
    The image of 0 along the word, as a function of mu, is enclosed together with its derivative. A cell of mu is
    dropped where the enclosure excludes 0, or where a point has the wrong sign for its letter; it is settled by the
    signs at its ends where the derivative has one sign; else it is halved.
    """
    turned = word[j:] + word[:j]
    scale = max(abs(low), abs(high), abs(l))
    found: list[float] = []
    cells = [(low, high)]
    while cells:
        a, b = cells.pop()
        enclosed = _enclosed(turned, lam, l, (a, b), LENIENT * scale)
        if enclosed is None:
            continue
        (x_low, x_high), (d_low, d_high) = enclosed
        if x_low > 0.0 or x_high < 0.0:
            continue
        if d_low > 0.0 or d_high < 0.0:
            zero = _zero(turned, lam, l, a, b)
            if zero is not None and _proper(turned, lam, l, zero):
                found.append(zero)
            continue
        middle = 0.5 * (a + b)
        if b - a > NARROWEST * scale and a < middle < b:
            cells += [(a, middle), (middle, b)]
    found.sort()
    # a zero at the common end of two cells belongs to both
    return [mu for i, mu in enumerate(found) if i == 0 or mu - found[i - 1] > 1e-13 * scale]


def _enclosed(turned: str, lam: float, l: float, mu: Range, lenient: float) -> tuple[Range, Range] | None:
    """Enclose the image of 0 along the letters and its derivative in mu; None where a letter cannot be right."""
    x: Range = (0.0, 0.0)
    d: Range = (0.0, 0.0)
    for place, letter in enumerate(turned):
        low, high = x
        if letter == "L":
            if place and low > lenient:
                return None
            x, d = _scaled(lam, x), _scaled(lam, d)
            x, d = (x[0] + mu[0], x[1] + mu[1]), (d[0] + 1.0, d[1] + 1.0)
        else:
            if high < -lenient:
                return None
            root = (math.sqrt(max(low, 0.0)), math.sqrt(max(high, 0.0)))
            x = (mu[0] - l - root[1], mu[1] - l - root[0])
            if place:
                d = _steep(d, root)
            else:
                d = (1.0, 1.0)
        size = SLACK * (abs(x[0]) + abs(x[1]) + abs(l) + abs(mu[1]))
        x = (x[0] - size, x[1] + size)
        size = SLACK * (abs(d[0]) + abs(d[1]))
        d = (d[0] - size, d[1] + size)
    return x, d


def _scaled(lam: float, x: Range) -> Range:
    return (lam * x[0], lam * x[1]) if lam >= 0.0 else (lam * x[1], lam * x[0])


def _steep(d: Range, root: Range) -> Range:
    """Enclose 1 - d/(2 root)."""
    if root[0] <= 0.0 or not all(map(math.isfinite, d)):
        return (-math.inf, math.inf)
    ends = [0.5 * one / at for one in d for at in root]
    return (1.0 - max(ends), 1.0 - min(ends))


def _image(turned: str, lam: float, l: float, mu: float) -> float:
    x = 0.0
    for letter in turned:
        x = lam * x + mu if letter == "L" else mu - l - math.sqrt(max(x, 0.0))
    return x


def _zero(turned: str, lam: float, l: float, a: float, b: float) -> float | None:
    """Return the zero of the image between two values of mu, by bisection to the last bits."""
    left, right = _image(turned, lam, l, a), _image(turned, lam, l, b)
    if left * right > 0.0:
        return None
    rises = left < right
    while True:
        middle = 0.5 * (a + b)
        if not a < middle < b:
            return min(b, a, key=lambda mu: abs(_image(turned, lam, l, mu)))
        if (_image(turned, lam, l, middle) > 0.0) == rises:
            b = middle
        else:
            a = middle


def _proper(turned: str, lam: float, l: float, mu: float) -> bool:
    """Whether no other point lies on the wrong side, or at 0 too: that is an orbit of a shorter period."""
    x = 0.0
    for place, letter in enumerate(turned):
        if place and (x >= 0.0 if letter == "L" else x <= 0.0):
            return False
        if place and abs(x) < 1e-13 * abs(mu) and letter == turned[0]:
            return False
        x = lam * x + mu if letter == "L" else mu - l - math.sqrt(max(x, 0.0))
    return True
