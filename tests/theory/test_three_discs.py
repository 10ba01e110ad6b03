"""Cycles of three discs: closed forms, those of the whole plane, and a twin in mpmath."""

from decimal import Decimal
from math import sqrt

import mpmath as mp
import pytest

import grazing as gz
from grazing.theory import three_disc_cycles
from grazing.theory.three_discs import primitive_words
from tests.billiard.tables import three_discs


@pytest.mark.parametrize("ratio", [2.1, 3.0, 6.0, 100.0])
def test_back_and_forth_and_round_the_triangle_are_closed_forms(ratio):
    back, on = three_disc_cycles(ratio, 1, digits=30)
    with mp.workdps(35):
        for found, length, kick in ((back, ratio - mp.mpf(2), 2), (on, ratio - mp.sqrt(3), 4 / mp.sqrt(3))):
            half = 1 + length * kick / 2
            root = half + mp.sqrt(half**2 - 1)
            assert abs(mp.mpf(str(found.time)) - length) < 1e-28 * ratio
            assert abs(abs(mp.mpf(str(found.transverse[0]))) - root) < 1e-28 * root
    assert back.transverse[0] > 0 > on.transverse[0]


def twin(word, ratio):
    """Return time and multiplier of a word in the sixth, from its way in the whole plane, by mpmath's minimiser."""
    centres = [mp.mpc(0, ratio / mp.sqrt(3))] + [ratio * mp.mpc(s, -1 / mp.sqrt(3)) / 2 for s in (-1, 1)]
    before, now, discs, turns = 0, 1, [], 0
    while turns == 0 or (before, now) != (0, 1):
        for symbol in word:
            discs.append(now)
            before, now = now, before if symbol == 0 else 3 - before - now
        turns += 1
    n, places = len(discs), [centres[k] for k in discs]

    def on(u):
        return [c + mp.exp(1j * x) for c, x in zip(places, u, strict=True)]

    def reflected(*u):
        p = on(u)
        out = []
        for i in range(n):
            a, b = p[i - 1] - p[i], p[(i + 1) % n] - p[i]
            out.append(((a / abs(a) + b / abs(b)) * mp.exp(-1j * u[i])).imag)  # no part along the disc
        return out

    guess = []
    for i in range(n):
        a, b = places[i - 1] - places[i], places[(i + 1) % n] - places[i]
        guess.append(mp.arg(a / abs(a) + b / abs(b)))
    u = [guess[0]] if n == 1 else list(mp.findroot(reflected, guess, tol=mp.mpf(10) ** -50, maxsteps=60))
    p, M = on(u), mp.eye(2)
    for i in range(n):
        k = (i + 1) % n
        way = p[k] - p[i]
        cosine = abs((way * mp.exp(-1j * u[k])).real) / abs(way)
        M = -mp.matrix([[1, 0], [2 / cosine, 1]]) * mp.matrix([[1, abs(way)], [0, 1]]) * M
    trace = abs(M[0, 0] + M[1, 1])
    total = sum(abs(p[(i + 1) % n] - p[i]) for i in range(n))
    return total / turns, ((trace + mp.sqrt(trace**2 - 4)) / 2) ** (mp.mpf(1) / turns)


def test_every_word_to_length_four_is_that_of_a_twin():
    cycles = three_disc_cycles(2.5, 4, digits=30)
    words = [word for n in range(1, 5) for word in primitive_words(n)]
    with mp.workdps(40):
        for word, found in zip(words, cycles, strict=True):
            time, root = twin(word, mp.mpf("2.5"))
            assert abs(mp.mpf(str(found.time)) - time) < mp.mpf(10) ** -27
            assert abs(mp.mpf(str(found.transverse[0])) / root - (-1) ** sum(word)) < mp.mpf(10) ** -26
            assert abs(found.transverse[0] * found.transverse[1] - 1) < Decimal("1e-27")


def test_they_are_the_orbits_of_the_table():
    """AB goes twice round the word 0, ABC three times round 1, ABAC twice round 01."""
    P = gz.collision_map(three_discs(3.0))
    found = dict(zip(("0", "1", "01"), three_disc_cycles(3.0, 2), strict=True))
    for name, word, times in (("AB", "0", 2), ("ABC", "1", 3), ("ABAC", "01", 2)):
        (orbit,) = gz.periodic_orbits(P, word=name)
        assert orbit.time == pytest.approx(times * float(found[word].time), rel=1e-13)
        assert abs(orbit.multipliers[0]) == pytest.approx(abs(float(found[word].transverse[0])) ** times, rel=1e-11)
    assert float(found["0"].transverse[0]) == pytest.approx(2.0 + sqrt(3.0), rel=1e-15)


def test_what_is_out_of_range_is_refused():
    for arguments, name in (((2.0, 3), "ratio"), (("6", 3), "ratio"), ((6.0, 0), "length"), ((6.0, 17), "length")):
        with pytest.raises(gz.InputError, match=f"{name} is"):
            three_disc_cycles(*arguments)
    with pytest.raises(gz.InputError, match="digits is 2"):
        three_disc_cycles(6.0, 2, digits=2)
