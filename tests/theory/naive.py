"""The gap map (2.6) as it stands on paper, and what follows from iterating it: no closed form in here."""

import math

import mpmath
from hypothesis import strategies as st

LAMS = st.floats(0.1, 0.98)
GAPS = st.just(0.0) | st.floats(1e-3, 5.0)
PERIODS = st.integers(1, 10)


def gap_map(x, lam, mu, l, sqrt=math.sqrt):
    """(2.6): L for x < 0, R for x >= 0; `sqrt` may be one of higher precision."""
    return lam * x + mu if x < 0 else mu - l - sqrt(x)


def slope(x, lam):
    return lam if x < 0 else -0.5 / math.sqrt(x)


def iterate(x, n, lam, mu, l):
    for _ in range(n):
        x = gap_map(x, lam, mu, l)
    return x


def word(x, n, lam, mu, l):
    """Letters of the n points from x on."""
    letters = []
    for _ in range(n):
        letters.append("L" if x < 0 else "R")
        x = gap_map(x, lam, mu, l)
    return "".join(letters)


def product_of_slopes(points, lam):
    return math.prod(slope(x, lam) for x in points)


def pass_of_word(x, N, lam, mu, l, sqrt=mpmath.sqrt):
    """x from right of the border through one R and then N - 1 times the L branch, whatever the signs."""
    x = mu - l - sqrt(x)
    for _ in range(N - 1):
        x = lam * x + mu
    return x


def exact(*values):
    return [mpmath.mpf(v) for v in values]


def true_right_point(N, lam, mu, l):
    """Fixed point of the pass L^(N-1) R, admissible or not, by bisection at high precision."""
    lam, mu, l = exact(lam, mu, l)
    low, high = mpmath.mpf(0), mpmath.mpf(1)
    while pass_of_word(high, N, lam, mu, l) > high:
        high *= 4
    for _ in range(400):
        middle = (low + high) / 2
        low, high = (middle, high) if pass_of_word(middle, N, lam, mu, l) > middle else (low, middle)
    return high
