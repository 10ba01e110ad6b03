import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import grazing as gz
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.orbits.word import impacts_and_periods, least_rotation, letters_of, primitive, word

SEQUENCES = st.lists(st.integers(-2, 3), min_size=1, max_size=12)
COUNTS = st.lists(st.integers(-2, 25), min_size=1, max_size=12)


def rotations(s):
    return [tuple(s[i:] + s[:i]) for i in range(len(s))]


@given(SEQUENCES)
def test_least_rotation_is_the_least_of_all(s):
    assert least_rotation(s) == min(rotations(s))


@given(SEQUENCES, st.integers(1, 4))
def test_primitive_is_the_shortest_root(s, times):
    root = primitive(s * times)
    lengths = [k for k in range(1, len(s) + 1) if len(s) % k == 0 and s[:k] * (len(s) // k) == s]
    assert root == tuple(s[: lengths[0]])


@given(COUNTS, st.integers(0, 11), st.integers(1, 3))
def test_a_word_does_not_depend_on_where_the_orbit_starts(s, shift, times):
    shift %= len(s)
    assert word((s[shift:] + s[:shift]) * times) == word(s)


@given(COUNTS)
def test_letters_come_back_from_a_word(s):
    assert letters_of(word(s)) == least_rotation(primitive(s))


@given(st.lists(st.integers(0, 1), min_size=1, max_size=12))
def test_symbols_come_back_from_a_word(s):
    text = word(s, "LR")
    assert set(text) <= {"L", "R"}
    assert letters_of(text, "LR") == least_rotation(primitive(s))


@pytest.mark.parametrize(
    ("letters", "symbols", "expected"),
    [
        ((1, 0, 0), "LR", "LLR"),
        ((0, 1, 0), None, "001"),
        ((0, 1, 0, 0, 1, 0), None, "001"),
        ((12, 0, 9), None, "09(12)"),
        ((10, 2), None, "2(10)"),
        ((1, CHATTER_LETTER), None, "C1"),
        ((0, STUCK_LETTER, CHATTER_LETTER), None, "SC0"),
        ((0,), "C", "C"),
    ],
)
def test_words(letters, symbols, expected):
    assert word(letters, symbols) == expected


def test_order_is_by_code_and_not_by_symbol():
    assert word((1, 0), "RL") == "RL"  # letter 0 is R here
    assert word((10, 9)) == "9(10)"  # as text "(10)" comes before "9"


def test_words_of_orbits():
    gap = gz.gap_map(lam=0.8, mu=0.5, l=1.0).orbit((-1.0,), 300).letters
    assert word(gap[-3:], "LR") == "LLR"
    ball = gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4)).orbit((0.1, 0.0), 300).letters
    assert word(ball[-3:]) == "001"


def test_impacts_and_periods():
    assert impacts_and_periods((0, 0, 1, 0, 0, 1)) == (2, 6)
    assert impacts_and_periods((2, STUCK_LETTER)) == (2, 2)
    assert impacts_and_periods((0, CHATTER_LETTER)) == (math.inf, 2)
    # an impact that crosses the strobe changes the word, but not the pair
    assert word((2, 0)) != word((1, 1))
    assert impacts_and_periods((2, 0)) == impacts_and_periods((1, 1))


def test_long_words_take_linear_time():
    s = [0] * 200_000
    s[-1] = 1
    assert least_rotation(primitive(s)) == tuple(s)
    assert primitive([0, 1] * 100_000) == (0, 1)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: word(()), "a word of no letters; give the letters of at least one step"),
        (lambda: letters_of(""), "a word of no letters"),
        (lambda: word((0, 2), "LR"), "letter 2 has no symbol in 'LR'; allowed are 0 to 1"),
        (lambda: word((-1,), "LR"), "letter -1 has no symbol in 'LR'"),
        (lambda: word((-3,)), r"letter -3 has no symbol; allowed are counts >= 0, -1 \(C\) and -2 \(S\)"),
        (lambda: letters_of("00x"), r"word '00x' has 'x' at position 2; allowed are 0 to 9, \(10\) and above, C, S"),
        (lambda: letters_of("(3)"), r"word '\(3\)' has '\(3\)' at position 0"),
        (lambda: letters_of("LS", "LR"), "word 'LS' has 'S' at position 1; allowed are L, R"),
    ],
)
def test_error_texts(call, said):
    with pytest.raises(gz.InputError, match=said):
        call()
