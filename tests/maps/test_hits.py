"""Letters between two walls: each code has one symbol, each symbol one code."""

import copy

import pytest

from grazing.maps.hits import CHATTER, LAY, MANY, MOST, Hits, Names
from grazing.orbits.word import letters_of, word
from grazing.outcome import InputError

HITS = Hits("AB")


def coded(text):
    letter = 0
    for name in text:
        letter = 3 * letter + 1 + "AB".index(name)
    return letter


@pytest.mark.parametrize("text", ["A", "B", "AB", "BA", "AAB", "BBBB", "A" * MOST, "B" * MOST])
def test_impacts_in_order_are_a_symbol_and_back(text):
    symbol = text if len(text) == 1 else f"({text})"
    assert HITS.symbol(coded(text)) == symbol and HITS.read(symbol, 0) == (coded(text), len(symbol))
    assert coded(text) < 2**31


def test_special_letters_have_symbols_of_their_own():
    said = {0: "0", CHATTER: "(CA)", LAY: "(SA)", CHATTER - 2: "(CB)", LAY - 2: "(SB)", MANY: "(more)"}
    for code, symbol in said.items():
        assert HITS.symbol(code) == symbol and HITS.read(symbol, 0) == (code, len(symbol))
    assert set(HITS.special) == set(said) - {0}


@pytest.mark.parametrize("code", [3, 9, 28 * 3, -6, 3 ** (MOST + 1)])
def test_a_code_that_means_nothing_is_refused(code):
    with pytest.raises(InputError, match="has no symbol between the walls A and B"):
        HITS.symbol(code)


def test_words_are_read_and_written():
    letters = (coded("AB"), 0, coded("B"), CHATTER - 2)
    assert letters_of("(AB)0B(CB)", HITS) == letters
    assert word(letters, HITS) == "(CB)(AB)0B"
    assert word((0, 1, 0, 1), HITS) == "0A"


@pytest.mark.parametrize("text", ["AB1", "(A)", "()", "(AC)", "R", "(AB"])
def test_other_texts_are_refused_with_what_is_allowed(text):
    with pytest.raises(InputError, match=r"allowed are 0, A, B, several impacts of one period such as \(AB\)"):
        letters_of(text, HITS)


def test_alphabets_are_values():
    assert copy.deepcopy(HITS) == HITS == Hits("AB") != Hits("XY") and str(Hits("XY")) == "XY"
    assert Hits("XY").symbol(coded("AB")) == "(XY)"


@pytest.mark.parametrize("names", ["AB", "ABC"])
def test_a_letter_grows_by_an_impact_until_it_tells_them_apart_no_more(names):
    hits, letter, walls = Hits(names), 0, []
    for i in range(hits.most):
        walls.append((7 * i + 1) % len(names))
        letter = hits.longer(letter, walls[-1])
        text = "".join(names[wall] for wall in walls)
        assert hits.symbol(letter) == (text if len(text) == 1 else f"({text})")
        assert hits.walls(letter) == tuple(walls)
    assert hits.longer(letter, 0) == MANY == hits.longer(MANY, 1) and hits.walls(MANY) == hits.walls(0) == ()


def test_names_of_objects_are_letters():
    names = Names(("A", "bumper", "left_drain"))
    for letter, symbol in enumerate(("A", "(bumper)", "(left_drain)")):
        assert names.symbol(letter) == symbol and names.read(f"A{symbol}", 1) == (letter, 1 + len(symbol))
    assert (len(names), list(names), names.most) == (3, ["A", "bumper", "left_drain"], 10)
    assert word((1, 0, 1, 0), names) == "A(bumper)" and letters_of("(bumper)A", names) == (1, 0)
    for text in ("B", "(A", "(bump)", "bumper"):
        with pytest.raises(InputError, match=r"allowed are A, \(bumper\), \(left_drain\)"):
            names.read(text, 0)
    with pytest.raises(InputError, match="letter 3 has no name"):
        names.symbol(3)
    with pytest.raises(InputError, match=r"letter = \['A'\]; allowed is a whole number"):
        names.symbol(["A"])
