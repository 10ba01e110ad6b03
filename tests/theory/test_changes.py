"""Edges and windows of words: against the propositions, and against the orbits found at many values of mu."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grazing import theory
from grazing.outcome import InputError
from tests.examples import examples
from tests.theory.test_words import WORDS


@settings(deadline=None, max_examples=examples(60))
@given(N=st.integers(1, 9), lam=st.floats(0.1, 0.98), l=st.just(0.0) | st.floats(1e-3, 3.0))
def test_one_right_letter_has_the_edges_of_the_propositions(N, lam, l):
    word = "L" * (N - 1) + "R"
    closed = theory.window(N, lam, l)
    edges = theory.word_edges(word, lam, l)
    window = theory.word_windows(word, lam, l)
    if N > 1:
        assert edges.bc == pytest.approx([closed.mu_bc], rel=1e-11)
    if l > 0 and closed.mu_gr < closed.mu_bc * (1 - 1e-6):
        assert edges.gr == pytest.approx([closed.mu_gr], rel=1e-9)
    if closed.stability.width > 1e-6 * closed.mu_pd:
        assert edges.pd == pytest.approx([closed.mu_pd], rel=1e-11)
        ((low, high, low_type, high_type),) = window
        assert (low, low_type, high_type) == (pytest.approx(closed.mu_pd, rel=1e-11), "pd", "bc" if N > 1 else "end")
        assert high == pytest.approx(closed.mu_bc, rel=1e-11)
    elif closed.stability.empty and closed.mu_pd > closed.mu_bc * (1 + 1e-6):
        assert edges.pd == () and window == ()
    assert edges.lp == ()
    ((low, high, low_type, high_type),) = theory.word_windows(word, lam, l, stable=False)
    assert low == pytest.approx(closed.mu_gr, rel=1e-9, abs=1e-300) and high == pytest.approx(closed.mu_bc, rel=1e-11)
    assert (low_type, high_type) == ("gr", "bc" if N > 1 else "end")


@pytest.mark.parametrize(("N", "lam", "l"), [(1, 0.5, 0.2), (2, 0.5, 0.0), (3, 0.8, 1.0), (5, 0.9, 0.4), (6, 0.4, 2.0)])
def test_doubled_words_exist_where_the_closed_form_says(N, lam, l):
    word = ("L" * (N - 1) + "R") * 2
    low, high = theory.doubled_interval(N, lam, l)
    assert theory.word_windows(word, lam, l) == ()
    ((a, b, a_type, b_type),) = theory.word_windows(word, lam, l, stable=False)
    assert (a, b) == pytest.approx((low, high), rel=1e-10)
    assert a_type == "pd" and b_type in ("gr", "bc")
    assert theory.word_edges(word, lam, l).pd == pytest.approx([low], rel=1e-10)
    assert theory.word_windows(word * 2, lam, l, stable=False) == ()


@pytest.mark.parametrize(
    ("lam", "l", "span"),
    [
        (0.9, 0.0, None),
        (0.9, 0.0, (-1.0, 0.9)),
        (0.9, 0.4, None),
        (0.6, 0.05, None),
        (0.3, 0.7, None),
        (0.5, -0.6, None),
        (0.342, -0.668, None),
        (0.3, -0.25, None),
        (-0.3, -0.15, (-0.5, 1.0)),
        (-0.8, 0.3, (-0.5, 1.5)),
        (1.1, 0.2, (-0.3, 1.2)),
    ],
)
def test_windows_hold_exactly_the_values_with_an_orbit(lam, l, span):
    rng = np.random.default_rng(3)
    checked = 0
    for word in [w for w in WORDS if len(w) <= 5 or w in ("LLRLRR", "LRRRRR")]:
        stable = theory.word_windows(word, lam, l, span)
        exist = theory.word_windows(word, lam, l, span, stable=False)
        low, high = span or (-0.3, 1.8)
        values = [*rng.uniform(low, high, 4), *(10.0 ** rng.uniform(-4, 0, 3))]
        edges = np.array([end for w in (*stable, *exist) for end in w[:2]])
        values += [
            end * (1 + sign * size) for end in edges if np.isfinite(end) for sign in (-1, 1) for size in (1e-5, 0.03)
        ]
        for mu in values:
            if not low <= mu <= high or (edges.size and np.abs(edges - mu).min() <= 3e-6 * abs(mu)):
                continue
            admissible = [orbit for orbit in theory.word_orbits(word, lam, mu, l) if orbit.admissible]
            inside = any(a < mu < b for a, b, *_types in exist)
            assert inside == bool(admissible), (word, mu)
            inside = any(a < mu < b for a, b, *_types in stable)
            assert inside == any(orbit.stable for orbit in admissible), (word, mu)
            checked += 1
    assert checked > 100


@pytest.mark.parametrize(
    ("word", "lam", "l"),
    [("LLR", 0.8, 1.0), ("LLRR", 0.5, -0.6), ("LLRRLRR", 0.342, -0.668), ("LRRR", 0.297, -0.254), ("LRRRR", 0.3, -0.6)],
)
def test_at_an_edge_the_orbit_has_what_the_type_says(word, lam, l):
    edges = theory.word_edges(word, lam, l)
    assert sum(map(len, edges)) > 0
    beside = (1 - 1e-8, 1 + 1e-8)
    for kind, values in edges._asdict().items():
        for mu in values:
            orbits = [one for shift in beside for one in theory.word_orbits(word, lam, mu * shift, l)]
            assert orbits
            if kind in ("pd", "lp"):
                goal = -1.0 if kind == "pd" else 1.0
                near = min(abs(one.multiplier - goal) for one in orbits)
                assert near < (1e-4 if kind == "pd" else 1e-2)  # the multiplier leaves 1 as a square root
            else:
                letter = "R" if kind == "gr" else "L"
                at = [j for j, one in enumerate(word) if one == letter]
                assert min(np.abs(one.points[at]).min() for one in orbits) < 1e-5


def test_the_word_without_right_letters():
    assert theory.word_windows("L", 0.5, 0.3) == ((-math.inf, 0.0, "end", "bc"),)
    assert theory.word_windows("L", -1.5, 0.3) == ()
    assert theory.word_windows("L", 1.5, 0.3, stable=False) == ((0.0, math.inf, "bc", "end"),)
    assert theory.word_windows("L", 0.5, 0.3, (-1.0, 1.0)) == ((-1.0, 0.0, "end", "bc"),)
    assert theory.word_windows("LL", 0.5, 0.3) == ()
    assert theory.word_edges("L", 0.5, 0.3) == ((), (0.0,), (), ())


def test_a_span_cuts_windows():
    ((low, high, low_type, high_type),) = theory.word_windows("LLR", 0.8, 1.0, (0.5, 0.6))
    assert (low, high, low_type, high_type) == (0.5, 0.6, "end", "end")
    assert theory.word_windows("LLR", 0.8, 1.0, (2.0, 3.0)) == ()


def test_without_a_gap_all_points_come_to_the_border_at_once():
    whole, cut = (theory.word_windows("LLR", 0.9, 0.0, span, stable=False) for span in (None, (-0.5, 0.9)))
    assert cut == ((0.0, pytest.approx(whole[0].high, rel=1e-12), "gr", "bc"),)
    assert theory.word_edges("LLR", 0.9, 0.0, (-0.5, 0.9)).gr == (0.0,)
    # a zero that is a double is that double, in a span around it and in one that begins there
    assert theory.word_windows("R", 0.5, 0.0, (-1.0, 1.0), stable=False) == ((0.0, 1.0, "gr", "end"),)
    assert theory.word_windows("R", 0.5, 0.1, (0.1, 1.0), stable=False) == ((0.1, 1.0, "gr", "end"),)
    # with a gap an orbit that goes on below mu = 0 has no graze there
    assert theory.word_windows("R", 0.5, -0.3, (0.0, 1.0), stable=False) == ((0.0, 1.0, "end", "end"),)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: theory.word_edges("LRX", 0.5, 0.1), "word = 'LRX'"),
        (lambda: theory.word_windows("LR", math.inf, 0.1), "lam = inf is not allowed"),
        (lambda: theory.word_windows("LR", 1.5, 0.1), r"no span of mu for LR at lam = 1.5.*give span=\(low, high\)"),
        (lambda: theory.word_windows("LR", -0.5, 0.1), "known for 0 < lam < 1 only"),
        (lambda: theory.word_edges("LR", 0.5, 0.1, (1.0, 0.0)), "the lower end must come first"),
        (lambda: theory.word_edges("LR", 0.5, 0.1, 3.0), "give the pair"),
        (lambda: theory.word_edges("LR", 0.5, 0.1, (0.0, math.nan)), "span = nan"),
    ],
)
def test_error_texts(call, said):
    with pytest.raises(InputError, match=said):
        call()
