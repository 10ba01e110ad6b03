"""Border collisions of piecewise-linear maps of the plane, with gap and border anywhere, against rational numbers."""

from fractions import Fraction

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.branch import continuation
from tests.orbits.test_piece_end import orbit_of


def normal_form(state, p):
    x, y = state
    if x < p.c:
        return (p.tl * (x - p.c) + y + p.mu + p.c, -p.dl * (x - p.c)), 0
    return (p.tr * (x - p.c) + y + p.mu + p.l + p.c, -p.dr * (x - p.c)), 1


PARAMS = {"tl": 0.5, "dl": 0.2, "tr": -1.0, "dr": 0.3, "mu": 0.1, "l": 0.0, "c": 0.0}
PLANE = gz.Map(normal_form, params=PARAMS, coordinates=("x", "y"), box=((-1.0, 1.0), (-1.0, 1.0)), letters="LR")


def stepped(c, v, mu, tl, dl, tr, dr, l):
    """Return the image of (x, y), x measured from the border, on the piece of a letter."""
    (x, y), t, d = v, tl if c == "L" else tr, dl if c == "L" else dr
    return t * x + y + mu + (l if c == "R" else 0), -d * x


def orbit_at(word, mu, *coefficients):
    """Return the points of a word at one mu, or None where its matrix has an eigenvalue 1."""

    def turned(v):
        for c in word:
            v = stepped(c, v, mu, *coefficients)
        return v

    zero, one = Fraction(0), Fraction(1)
    e, f, g = turned((zero, zero)), turned((one, zero)), turned((zero, one))
    a, b, c, d = 1 - (f[0] - e[0]), -(g[0] - e[0]), -(f[1] - e[1]), 1 - (g[1] - e[1])
    if a * d == b * c:
        return None
    points = [((d * e[0] - b * e[1]) / (a * d - b * c), (a * e[1] - c * e[0]) / (a * d - b * c))]
    for letter in word[:-1]:
        points.append(stepped(letter, points[-1], mu, *coefficients))
    return points


def existence(word, *coefficients):
    """Return between which mu in [-1, 1] the word has its orbit, None if nowhere: points are affine in mu."""
    at = [orbit_at(word, Fraction(mu), *coefficients) for mu in (0, 1)]
    if None in at:
        return None
    low, high = Fraction(-1), Fraction(1)
    for c, (A, _y), (C, _z) in zip(word, *at, strict=True):
        B = C - A
        if B == 0:
            if (A < 0) != (c == "L"):
                return None
        elif (c == "R") == (B > 0):
            low = max(low, -A / B)
        else:
            high = min(high, -A / B)
    return (low, high) if low < high else None


def collisions(count, seed):
    rng, words, done = np.random.default_rng(seed), gz.words("LR", 4), 0
    while done < count:
        coefficients = [Fraction(int(rng.integers(-200, 200)), 100) for _ in range(5)]
        border, word = (0.0, 0.37, -12.0)[rng.integers(3)], words[rng.integers(len(words))]
        found = existence(word, *coefficients)
        if found is None or found[1] - found[0] < Fraction(1, 10**5):
            continue
        mu = (found[0] + found[1]) / 2
        points = [[float(x) + border, float(y)] for x, y in orbit_at(word, mu, *coefficients)]
        if np.abs(points).max() > 20.0:
            continue
        named = dict(zip(("tl", "dl", "tr", "dr", "l"), map(float, coefficients), strict=True))
        P = PLANE.replace(mu=float(mu), c=border, **named)
        special = continuation(P, orbit_of(P, points, word), "mu", (-1.0, 1.0)).special
        wanted = [float(end) for end in found if abs(end) != 1]
        assert [one.type for one in special] == ["bcb"] * len(wanted), (word, named, border, special)
        for one, value in zip(sorted(special, key=lambda one: one.value), wanted, strict=True):
            assert one.converged and one.low <= value <= one.high, (word, named, border, one)
            assert abs(one.value - value) < 2e-12
        done += 1


def test_border_collisions_in_the_plane_are_the_rational_ones():
    collisions(8, 1)


@pytest.mark.long
def test_many_border_collisions_in_the_plane():
    collisions(200, 2)
