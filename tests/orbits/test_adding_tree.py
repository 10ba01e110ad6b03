"""The tree of words: its shape, the rule of concatenation, and which of its words have windows."""

import json

import numpy as np
import pytest

from grazing.orbits.adding_tree import adding_tree
from grazing.orbits.word import letters_of, word
from grazing.outcome import InputError
from grazing.theory import mu_bc, mu_pd, word_orbits


@pytest.mark.parametrize(("between", "depth"), [(("L", "R"), 4), (("LRR", "LLRR"), 1), (("R", "LR"), 3)])
def test_every_word_joins_its_two_neighbours(between, depth):
    tree = adding_tree(0.5, 0.2, depth, between)
    words, levels = tree["word"].values.tolist(), tree["level"].values
    assert len(words) == len(set(words)) == 2**depth + 1
    assert (words[0], words[-1]) == between
    for i in range(len(words)):
        a, b = int(tree["left"][i]), int(tree["right"][i])
        if levels[i] == 0:
            assert (a, b) == (-1, -1)
            continue
        assert a < i < b and max(levels[a], levels[b]) == levels[i] - 1
        joined = letters_of(words[a], "LR") + letters_of(words[b], "LR")
        assert words[i] == word(joined, "LR") and len(words[i]) == int(tree["length"][i])
        # Farey: the share of letters R lies between those of the two words, as a mediant
        assert int(tree["right_letters"][i]) == words[a].count("R") + words[b].count("R")


def test_with_a_gap_that_falls_only_maximal_orbits_have_windows():
    lam, l = 0.7, 0.15
    tree = adding_tree(lam, l, 5)
    for i, spelled in enumerate(tree["word"].values.tolist()):
        row = tree.isel(node=i)
        if spelled.count("R") == 1 and spelled != "R":
            N = len(spelled)
            assert str(row["status"].values) == "stable" and int(row["windows"]) == 1
            assert (float(row["low"]), float(row["high"])) == pytest.approx((mu_pd(N, lam, l), mu_bc(N, lam, l)))
            assert (str(row["low_type"].values), str(row["high_type"].values)) == ("pd", "bc")
        elif spelled not in ("L", "R"):
            assert str(row["status"].values) != "stable" and np.isnan(float(row["low"]))
    assert {"unstable", "virtual"} <= set(tree["status"].values.tolist())


def test_with_a_gap_that_jumps_up_periods_are_added():
    # between the windows of LRR and LLRR lie those of all their concatenations, in the order of the tree
    lam, l = 0.342, -0.668
    tree = adding_tree(lam, l, 2, ("LLRR", "LRR"))
    assert set(tree["status"].values.tolist()) == {"stable"}
    low, high = tree["low"].values, tree["high"].values
    assert (low < high).all() and (high[:-1] < low[1:]).all()
    for i, spelled in enumerate(tree["word"].values.tolist()):
        mu = 0.5 * (low[i] + high[i])
        x = 0.01
        letters = ""
        for step in range(4000):
            letters = letters + ("L" if x < 0 else "R") if step >= 4000 - len(spelled) else letters
            x = lam * x + mu if x < 0 else mu - l - np.sqrt(x)
        assert word(letters_of(letters, "LR"), "LR") == spelled  # and simulation settles on it
        assert any(o.stable and o.admissible for o in word_orbits(spelled, lam, mu, l))


def test_attributes_say_how_it_came_about():
    tree = adding_tree(-0.5, 0.2, 1, span=(-0.5, 1.0))
    assert json.loads(tree.attrs["parameters"]) == {"lam": -0.5, "l": 0.2}
    assert tree.attrs["span"] == [-0.5, 1.0] and tree.attrs["between"] == ["L", "R"]
    assert tree["low"].attrs["symbol"] == r"\mu"


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: adding_tree(0.5, 0.1, 0), "depth = 0; allowed is a whole number >= 1"),
        (lambda: adding_tree(0.5, 0.1, 2, ("L", "L")), "give two different words"),
        (lambda: adding_tree(0.5, 0.1, 2, ("LR", "RL")), "give two different words"),
        (lambda: adding_tree(0.5, 0.1, 2, ("LRLR", "R")), "neither of them a repetition"),
        (lambda: adding_tree(0.5, 0.1, 2, ("LX", "R")), "'LX' has 'X' at position 1"),
        (lambda: adding_tree(0.5, 0.1, 2, "LRR"), "give two words of L and R"),
        (lambda: adding_tree(float("nan"), 0.1, 2), "lam = nan"),
        (lambda: adding_tree(1.5, 0.1, 2), r"give span=\(low, high\)"),
        (lambda: adding_tree(0.9, 1e308, 3, span=(0.0, 1e308)), "l = 1e.308 is not allowed; l must be .* up to 1e.100"),
    ],
)
def test_error_texts(call, said):
    with pytest.raises(InputError, match=said):
        call()
