"""Orbits of every word of the gap map: against polynomial roots, iteration, and the closed forms of one R."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from grazing import theory
from grazing.outcome import InputError, OutsideForm
from tests.examples import examples
from tests.theory.naive import gap_map, slope

LAMS = st.floats(0.05, 0.98) | st.floats(-1.6, -0.05) | st.floats(1.02, 1.6)
MUS = st.floats(-0.5, 1.5)
GAPS = st.just(0.0) | st.floats(-0.8, 1.5)


def cyclic_words(longest):
    """Every primitive cyclic word, by trying them all."""
    for n in range(1, longest + 1):
        for letters in itertools.product("LR", repeat=n):
            spelled = "".join(letters)
            turns = [spelled[i:] + spelled[:i] for i in range(n)]
            if spelled == min(turns) and turns.count(spelled) == 1:
                yield spelled


WORDS = tuple(cyclic_words(7))


def by_polynomial(word, lam, mu, l):
    """Roots s >= 0 of the points R from the polynomial whose zeros they are, with how well it isolates each."""
    runs = [len(run) for run in word[:-1].split("R")]
    c = [lam**m for m in runs]
    C = [sum(lam**i for i in range(m + 1)) * mu - lam**m * l for m in runs]
    # backwards: s_(i-1) = (C_i - s_i^2)/c_i is a polynomial in the last root
    steps = [np.poly1d([1.0, 0.0])]
    for ci, Ci in zip(reversed(c), reversed(C), strict=True):
        steps.append((np.poly1d([Ci]) - steps[-1] * steps[-1]) * (1.0 / ci))
    zeros = (steps[-1] - steps[0]).roots
    real = zeros[np.abs(zeros.imag) < 1e-9].real
    values = np.array([[step(s) for step in steps] for s in real])
    kept = (values > 0.0).all(axis=1) if len(values) else np.zeros(0, bool)
    slopes = np.array([abs(np.polyval((steps[-1] - steps[0]).deriv(), s)) for s in real])
    unclear = bool(len(real)) and bool((np.abs(values).min(axis=1) < 1e-5).any() or (slopes < 1e-4).any())
    near = np.abs(zeros.imag)
    unclear = unclear or bool(((near >= 1e-9) & (near < 1e-4)).any())
    return np.sort(real[kept]), unclear


@pytest.mark.parametrize("word", [w for w in WORDS if 1 <= w.count("R") <= 4 and w[-1] == "R"])
def test_no_solution_is_missed(word):
    rng = np.random.default_rng(len(word) * 97 + word.count("R"))
    compared = found = 0
    for _ in range(60):
        lam = rng.choice([rng.uniform(0.1, 0.98), rng.uniform(-1.5, -0.1), rng.uniform(1.02, 1.5)])
        mu, l = rng.uniform(-0.5, 1.5), rng.choice([0.0, rng.uniform(-1.0, 1.0)])
        expected, unclear = by_polynomial(word, lam, mu, l)
        if unclear:
            continue
        orbits = theory.word_orbits(word, lam, mu, l)
        last = np.sort([orbit.roots[-1] for orbit in orbits])
        assert last == pytest.approx(expected, rel=1e-5, abs=1e-6), (lam, mu, l)
        compared += 1
        found += len(orbits)
    assert compared > 30
    assert found > 0


@settings(deadline=None, max_examples=examples(300))
@given(word=st.sampled_from(WORDS), lam=LAMS, mu=MUS, l=GAPS)
def test_points_letters_and_multiplier_of_every_solution(word, lam, mu, l):
    orbits = theory.word_orbits(word, lam, mu, l)
    assert len(orbits) <= 3 and sum(orbit.stable for orbit in orbits) <= 1
    for orbit in orbits:
        assert len(orbit.points) == len(word) and orbit.word == word and not orbit.points.flags.writeable
        size = np.abs(orbit.points).max() + abs(mu) + abs(l) + 1.0
        for letter, here, after in zip(word, orbit.points, np.roll(orbit.points, -1), strict=True):
            image = lam * here + mu if letter == "L" else mu - l - math.sqrt(here)
            assert image == pytest.approx(after, abs=1e-10 * size)
        assert orbit.admissible == all(x < 0 for letter, x in zip(word, orbit.points, strict=True) if letter == "L")
        if min(orbit.roots, default=1.0) > 1e-3:
            turn = math.prod(lam if a == "L" else -0.5 / math.sqrt(x) for a, x in zip(word, orbit.points, strict=True))
            assert orbit.multiplier == pytest.approx(turn, rel=1e-8)
        assert orbit.residual < 1e-12 * size * size


@settings(deadline=None)
@given(N=st.integers(1, 9), lam=st.floats(0.1, 0.98), l=st.floats(0.0, 3.0), share=st.floats(0.02, 0.98))
def test_one_right_letter_is_the_maximal_orbit_and_its_double(N, lam, l, share):
    word = "L" * (N - 1) + "R"
    exists = theory.existence_interval(N, lam, l)
    mu = exists.low + share * (min(exists.high, exists.low + 3.0) - exists.low)
    assume(mu > 0)
    (orbit,) = theory.word_orbits(word, lam, mu, l)
    assert orbit.admissible
    assert orbit.points == pytest.approx(theory.maximal_orbit(N, lam, mu, l), rel=1e-9, abs=1e-12)
    assert orbit.multiplier == pytest.approx(theory.multiplier(N, lam, mu, l), rel=1e-9)
    double = theory.doubled_interval(N, lam, l)
    assume(double.width > 1e-6 * double.high)
    mu = double.low + share * double.width
    (orbit,) = theory.word_orbits(word * 2, lam, mu, l)
    assert orbit.admissible and not orbit.stable
    assert orbit.points == pytest.approx(theory.doubled_orbit(N, lam, mu, l), rel=1e-6, abs=1e-9)
    assert orbit.multiplier == pytest.approx(theory.doubled_multiplier(N, lam, mu, l), rel=1e-6)


@pytest.mark.parametrize("word", ["LRLRR", "LRRRR", "LLRLRLR", "LRRR", "LLRRR"])
def test_doubled_orbits_of_words_with_several_right_letters_lie_around_the_single_one(word):
    rng = np.random.default_rng(5)
    found = 0
    for _ in range(400):
        lam, mu, l = rng.uniform(0.1, 0.95), rng.uniform(0.0, 2.0), rng.uniform(-1.0, 0.5)
        for orbit in theory.word_orbits(word * 2, lam, mu, l):
            found += 1
            assert orbit.multiplier > 1.0  # the doubling is subcritical, for every word
            (single,) = theory.word_orbits(word, lam, mu, l)
            assert single.stable  # as a solution of the equations, admissible or not
            half = len(word)
            at = word.index("R")
            assert sorted([orbit.points[at], orbit.points[at + half], single.points[at]])[1] == single.points[at]
            for here, after, letter in zip(orbit.points, np.roll(orbit.points, -1), word * 2, strict=True):
                image = lam * here + mu if letter == "L" else mu - l - math.sqrt(here)
                assert image == pytest.approx(after, abs=1e-9)
    assert found > 0 if word.count("R") % 2 else found == 0


@pytest.mark.parametrize("times", [3, 4, 6])
@pytest.mark.parametrize("word", ["L", "R", "LLR", "LRR", "LRLRR"])
def test_no_word_has_orbits_of_three_times_its_length_or_more(word, times):
    rng = np.random.default_rng(1)
    for _ in range(30):
        assert theory.word_orbits(word * times, *rng.uniform(0.1, 1.5, 2), rng.uniform(-1.0, 1.0)) == ()


def attractors(lam, mu, l, starts=60, steps=4000, longest=7):
    """Words and points of the periodic attractors of period <= longest that random starts settle on."""
    rng = np.random.default_rng(7)
    x = rng.uniform(-1.5, 1.5, starts)
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(steps):
            x = np.where(x < 0, lam * x + mu, mu - l - np.sqrt(np.maximum(x, 0)))
        turn = [x]
        for _ in range(longest):
            x = np.where(x < 0, lam * x + mu, mu - l - np.sqrt(np.maximum(x, 0)))
            turn.append(x)
    found = {}
    for lane in np.array(turn).T:
        if not np.isfinite(lane).all():
            continue
        n = next((n for n in range(1, longest + 1) if abs(lane[n] - lane[0]) < 1e-12 * (1 + abs(lane[0]))), 0)
        if n and np.abs(lane[:n]).min() > 1e-9:
            spelled = "".join("L" if v < 0 else "R" for v in lane[:n])
            turns = [(spelled[i:] + spelled[:i], i) for i in range(n)]
            best, shift = min(turns)
            found[best] = np.roll(lane[:n], -shift)
    return found


@pytest.mark.parametrize(
    ("lams", "mus", "gaps"),
    [
        ((0.05, 0.98), (0.0, 1.0), (0.0, 1.0)),
        ((0.05, 0.98), (0.0, 0.3), (0.0, 0.2)),
        ((0.05, 0.98), (-1.0, 1.0), (-1.0, 0.0)),
        ((-0.98, -0.05), (-1.0, 1.0), (-1.0, 1.0)),
        ((-1.8, -1.02), (-1.0, 1.0), (-1.0, 1.0)),
        ((1.02, 1.5), (-1.0, 1.0), (-1.0, 1.0)),
    ],
)
def test_against_iteration_from_random_starts(lams, mus, gaps):
    rng = np.random.default_rng(11)
    for _ in range(12):
        lam, mu, l = (rng.uniform(*ends) for ends in (lams, mus, gaps))
        stable = {
            orbit.word: orbit
            for word in WORDS
            for orbit in theory.word_orbits(word, lam, mu, l)
            if orbit.admissible and orbit.stable
        }
        seen = attractors(lam, mu, l)
        for word, points in seen.items():
            assert word in stable, (word, lam, mu, l)
            assert points == pytest.approx(stable[word].points, abs=1e-9)
        for word, orbit in stable.items():
            if abs(orbit.multiplier) > 0.95 or np.abs(orbit.points).min() < 1e-4:
                continue
            x = orbit.points[0] + 1e-7
            for _ in range(3000 * len(word)):
                x = gap_map(x, lam, mu, l)
            assert x == pytest.approx(orbit.points[0], abs=1e-9), (word, lam, mu, l)


def test_folds_give_three_orbits_and_the_middle_one_is_stable():
    # found among random parameters; LRR: s -> F(s) rises, and bends twice
    rng = np.random.default_rng(0)
    several = 0
    for _ in range(600):
        lam, mu, l = rng.uniform(0.4, 0.9), rng.uniform(0.02, 0.1), rng.uniform(-0.77, -0.44)
        orbits = theory.word_orbits("LRR", lam, mu, l)
        if len(orbits) == 3:
            several += 1
            assert [orbit.stable for orbit in orbits] == [False, True, False]
            assert all(orbit.multiplier > 0 for orbit in orbits)
    assert several > 0


def test_the_word_without_right_letters():
    (orbit,) = theory.word_orbits("L", 0.5, -0.2, 0.3)
    assert orbit.points.tolist() == [-0.4] and orbit.multiplier == 0.5 and orbit.admissible and orbit.stable
    (orbit,) = theory.word_orbits("L", 0.5, 0.2, 0.3)
    assert not orbit.admissible
    assert theory.word_orbits("LL", 0.5, -0.2, 0.3) == ()


def test_a_slope_of_zero_forgets_where_the_orbit_came_from():
    (orbit,) = theory.word_orbits("LLR", 0.0, 0.25, 1.0)
    assert orbit.points.tolist() == [-1.25, 0.25, 0.25] and orbit.multiplier == 0.0 and not orbit.admissible
    (orbit,) = theory.word_orbits("LR", 0.0, 0.25, 1.0)
    assert orbit.points.tolist() == [-1.25, 0.25] and orbit.multiplier == 0.0 and orbit.admissible
    (orbit,) = theory.word_orbits("LRR", 0.0, 0.25, -0.3)
    x = gap_map(0.25, 0.0, 0.25, -0.3)
    assert orbit.points == pytest.approx([gap_map(x, 0.0, 0.25, -0.3), 0.25, x], abs=1e-15)


def test_a_graze_counts_as_an_orbit_with_an_infinite_multiplier():
    (orbit,) = theory.word_orbits("R", 0.5, 0.25, 0.25)
    assert orbit.points.tolist() == [0.0] and orbit.multiplier == -math.inf and not orbit.stable


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda: theory.word_orbits("LXR", 0.5, 0.1, 0.1), InputError, "word = 'LXR'; allowed is a text of letters"),
        (lambda: theory.word_orbits("", 0.5, 0.1, 0.1), InputError, "word = ''"),
        (lambda: theory.word_orbits(3, 0.5, 0.1, 0.1), InputError, "word = 3"),
        (lambda: theory.word_orbits("LR", math.nan, 0.1, 0.1), InputError, "lam = nan is not allowed"),
        (lambda: theory.word_orbits("LR", 0.5, "a", 0.1), InputError, "mu = 'a' is not allowed; mu must be a finite"),
        (lambda: theory.word_orbits("LR", 0.5, 0.1, True), InputError, "l = True"),
        (lambda: theory.word_orbits("L", 1.0, 0.1, 0.1), OutsideForm, "come in families or not at all at lam = 1.0"),
        (lambda: theory.word_orbits("LL", -1.0, 0.1, 0.1), OutsideForm, "take another lam"),
        (lambda: theory.word_orbits("L" * 50 + "R", 1e9, 0.1, 0.1), InputError, "take a shorter word"),
    ],
)
def test_error_texts(call, error, said):
    with pytest.raises(error, match=said):
        call()


def test_slopes_of_the_naive_map_agree():
    for orbit in theory.word_orbits("LLRLR", 0.9, 0.3, 0.0):
        if orbit.admissible:
            assert orbit.multiplier == pytest.approx(math.prod(slope(x, 0.9) for x in orbit.points))


@pytest.mark.filterwarnings("error")
def test_slopes_below_all_numbers_are_no_error():
    """Their quotient was 0, of which there is no logarithm."""
    for one in theory.word_orbits("LRR", 5e-324, 2.5, 0.8):
        assert one.residual < 1e-12
