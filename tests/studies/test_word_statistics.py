"""Statistics of words: counted as by hand, entropies of known maps, errors that hold."""

from collections import Counter

import numpy as np
import pytest

import grazing as gz
from grazing.catalogue import studies
from grazing.studies.starts import random_starts
from grazing.studies.word_statistics import GROUPS, counted, entropy_of, jackknifed
from tests.studies.maps import HENON


def tent(state, p):
    """Letters independent of each other, L with probability a."""
    left = state[0] < p.a
    return (state[0] / p.a if left else (1.0 - state[0]) / (1.0 - p.a),), 0 if left else 1


def no_two(state, p):
    """After R comes L, after L comes L with probability a."""
    left = state[0] < p.a
    return (state[0] / p.a if left else (state[0] - p.a) / (1.0 - p.a) * p.a,), 0 if left else 1


def on_unit(step, a):
    return gz.Map(step, params={"a": a}, coordinates=("x",), box=((0.0, 1.0),), letters="LR")


def by_hand(orbits, length):
    """Count words of letters, one list an orbit."""
    return Counter(tuple(one[i : i + length]) for one in orbits for i in range(len(one) - length + 1))


def within(found, truth, name, sigmas=5.0):
    apart = abs(found[name].values - truth) / found[f"{name}_error"].values
    assert (apart < sigmas).all(), apart


@pytest.mark.parametrize("a", [0.2, 0.45])
def test_independent_letters(a):
    found = gz.word_statistics(on_unit(tent, a), length=3, starts=400)
    chance = {"L": a, "R": 1.0 - a}
    words = found.word.values[:8].tolist()
    assert sorted(words) == [x + y + z for x in "LR" for y in "LR" for z in "LR"]
    truth = np.array([np.prod([chance[letter] for letter in word]) for word in words])
    within(found.isel(rank=slice(8)), truth, "share")
    h = -a * np.log(a) - (1.0 - a) * np.log(1.0 - a)
    within(found, h, "conditional_entropy")
    within(found, h * np.arange(1, 4), "entropy")
    assert (found.conditional_entropy_error.values < 0.01).all() and found.words.values.tolist() == [2, 4, 8]
    assert found.word.values[8:].tolist() == [""] * 12 and np.isnan(found.share.values[8:]).all()


def test_a_letter_that_rules_out_the_next():
    a = 0.6
    found = gz.word_statistics(on_unit(no_two, a), length=4, starts=400)
    here = -a * np.log(a) - (1.0 - a) * np.log(1.0 - a)
    within(found.isel(length=slice(1, None)), here / (2.0 - a), "conditional_entropy")
    p = np.array([1.0, 1.0 - a]) / (2.0 - a)
    within(found.isel(length=0), -(p * np.log(p)).sum(), "entropy")
    assert found.words.values.tolist() == [2, 3, 5, 8]  # Fibonacci numbers
    assert not any("RR" in word for word in found.word.values)


def test_entropy_a_step_is_the_lyapunov_exponent_of_an_expanding_map():
    T = on_unit(tent, 0.3)
    found, grown = gz.word_statistics(T, length=6, starts=300), gz.lyapunov(T, starts=20, steps=2000)
    rate, error = grown.exponent.values.mean(), grown.exponent.values.std() / np.sqrt(20)
    assert abs(found.conditional_entropy.values[-1] - rate) < 5 * np.hypot(
        error, found.conditional_entropy_error.values[-1]
    )


def test_an_orbit_with_a_period_has_no_entropy_a_step():
    found = gz.word_statistics(gz.gap_map(0.5, 0.07, 0.1), length=4, starts=10)
    assert found.words.values.tolist() == [2, 3, 3, 3]
    assert found.conditional_entropy.values[2:] == pytest.approx(0.0, abs=1e-12)
    assert found.share.values[:3] == pytest.approx(1 / 3, abs=1e-3)


@pytest.mark.parametrize("length", [1, 2, 5])
def test_counted_as_by_hand(length):
    rng = np.random.default_rng(length)
    letters = rng.choice([-1, 0, 3, 12], (30, 7), p=[0.1, 0.5, 0.3, 0.1])
    ends = rng.integers(0, 31, 7)
    found = counted(letters, np.arange(30)[:, None] < ends, length, 5)
    orbits = [letters[:end, j].tolist() for j, end in enumerate(ends)]
    for n in range(1, length + 1):
        known = by_hand(orbits, n)
        assert (found.words[n - 1], found.counted[n - 1]) == (len(known), known.total())
    known = by_hand(orbits, length)
    best = sorted(known.items(), key=lambda item: (-item[1], item[0]))[:5]
    assert [tuple(word) for word in found.first] == [word for word, _count in best]
    assert found.share == pytest.approx([count / known.total() for _word, count in best])


def test_letters_of_many_symbols_and_long_words_do_not_overflow():
    letters = np.arange(4000).reshape(40, 100)
    found = counted(letters, letters >= 0, 40, 2)
    assert found.words.tolist() == [4000 - 100 * n for n in range(40)]
    assert found.first == [list(range(j, 4000, 100)) for j in (0, 1)]


@pytest.mark.parametrize("transient", [0, 1, 3])
def test_a_ball_that_has_left_spells_nothing_more(transient):
    P = gz.collision_map(gz.read_table("three_discs"))
    found = gz.word_statistics(P, length=2, starts=200, transient=transient, keep=6, seed=3)
    begins = random_starts(3, np.empty((1, 0)), 200, np.array([P.box]))[0].T
    orbits = []
    for begin in begins:
        letters = [P.letters.symbol(int(k)) for k in P.orbit(tuple(begin), transient + 6).letters]
        ways = [i for i, one in enumerate(letters) if one == "(away)"]
        orbits.append(letters[transient : ways[0] + 1] if ways else letters[transient:])
    for n in (1, 2):
        assert found.counted.values[n - 1] == by_hand(orbits, n).total()
        assert found.words.values[n - 1] == len(by_hand(orbits, n))
    share = dict(zip(found.word.values.tolist(), found.share.values.tolist(), strict=True))
    known = by_hand(orbits, 2)
    assert {word: n / known.total() for word, n in known.items()} == pytest.approx(
        {(w[:1], w[1:]): s for w, s in share.items() if w}
    )


def test_launches_have_one_letter_each():
    L = gz.launch_map(gz.read_table("galton"), (0.3, 11.0))
    found = gz.word_statistics(L, length=1, starts=300, transient=0, keep=5, seed=2, arithmetic="strict")
    begins = random_starts(2, np.empty((1, 0)), 300, np.array([L.box]))[0].T
    ways = Counter(L.letters.symbol(L(tuple(begin))[1]) for begin in begins)
    assert int(found.counted[0]) == 300 == int(found.left)
    share = dict(zip(found.word.values.tolist(), found.share.values.tolist(), strict=True))
    assert {way: n / 300 for way, n in ways.items()} == pytest.approx({w: p for w, p in share.items() if w})


def test_what_ends_is_counted_up_to_its_end_and_said():
    found = gz.word_statistics(HENON, "a", [1.4, 2.0], length=1, starts=50, transient=0, keep=100)
    ended = gz.orbit_diagram(HENON, "a", [1.4, 2.0], starts=50, transient=0, keep=100)
    assert found.ended.values.tolist() == (ended.period.values == -2).sum(axis=1).tolist()
    assert found.ended.values[1] > 0
    assert found.counted.values[:, 0].tolist() == np.isfinite(ended.x.values).sum(axis=(1, 2)).tolist()


def test_the_jackknife_takes_off_the_bias_of_few_words_and_its_error_holds():
    rng, plain, jack, z = np.random.default_rng(1), [], [], []
    for _ in range(300):
        counts = np.array([np.bincount(rng.integers(0, 16, 20), minlength=16) for _ in range(GROUPS)])
        value, error = jackknifed(counts, entropy_of)
        plain.append(entropy_of(counts.sum(axis=0)))
        jack.append(value)
        z.append((value - np.log(16)) / error)
    bias = np.log(16) - np.mean(plain)
    assert bias == pytest.approx(15 / 800, rel=0.15)  # (words - 1) / 2n
    assert abs(np.log(16) - np.mean(jack)) < 0.15 * bias
    assert 0.7 < np.std(z) < 1.5


def test_nothing_is_known_of_the_error_of_a_single_word():
    found = counted(np.array([[4]]), np.array([[True]]), 2, 3)
    assert found.first == [] and found.counted.tolist() == [1, 0]
    assert found.entropy[0] == 0.0 and np.isnan(found.entropy_error[0]) and np.isnan(found.entropy[1])


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"length": 0}, "length"),
        ({"length": 65}, "length"),
        ({"length": 9, "keep": 8}, "length = 9 is more than keep = 8"),
        ({"most": 0}, "most"),
        ({"name": "mu"}, "give a parameter's name with its values"),
        ({"name": "nu", "values": [1.0]}, "nu"),
    ],
)
def test_what_is_refused(given, says):
    with pytest.raises(gz.InputError, match=says):
        gz.word_statistics(gz.gap_map(0.5, 0.07, 0.1), **given)


def test_neither_threads_nor_neighbours_change_a_number():
    G, values = gz.gap_map(0.5, 0.07, 0.1), [0.05, 0.07, 0.2]
    one = gz.word_statistics(G, "mu", values, starts=9, keep=60, threads=1)
    assert one.equals(gz.word_statistics(G, "mu", values, starts=9, keep=60, threads=2))
    alone = gz.word_statistics(G, "mu", values[1:2], starts=9, keep=60)
    assert alone.isel(mu=0).drop_vars("mu").equals(one.isel(mu=1).drop_vars("mu"))


def test_told_and_drawn():
    study = studies()["statistics"]
    T = on_unit(tent, 0.3)
    one = gz.word_statistics(T, length=2, most=3)
    told = study.words(study.found(one))
    assert told[0].split() == ["words", "of", "2", "letters", "share", "error"] and told[1].startswith("RR")
    assert [line.split()[0] for line in told if line][-2:] == ["1", "2"]
    drawn = gz.plot.word_statistics(one)
    assert [bar.get_width() for bar in drawn["shares"]] == one.share.values.tolist()
    assert drawn["note"].get_text() == f"1 more word has {100 * (1 - one.share.values.sum()):.3g} %"
    over = gz.word_statistics(T, "a", [0.3, 0.4], length=3)
    told = study.words(study.found(over))
    assert told[0] == "words of 3 letters" and told[2].split()[:2] == ["0.3", "8"]
    drawn = gz.plot.word_statistics(over)
    assert list(drawn["entropies"]) == [1, 2, 3]
    assert drawn["entropies"][3].get_ydata().tolist() == over.conditional_entropy.values[:, 2].tolist()
    gone = gz.word_statistics(gz.collision_map(gz.read_table("three_discs")), starts=5)
    assert "give a smaller --transient" in study.words(study.found(gone))[0]
    with pytest.raises(gz.InputError, match="no word"):
        gz.plot.word_statistics(gone)
