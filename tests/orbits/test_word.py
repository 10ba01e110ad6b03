import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

import grazing as gz
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.orbits.word import least_rotation, letters_of, primitive, word, words

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


def moebius(n):
    primes = [p for p in range(2, n + 1) if n % p == 0 and all(p % q for q in range(2, p))]
    return 0 if any(n % (p * p) == 0 for p in primes) else (-1) ** len(primes)


@pytest.mark.parametrize("letters", ["L", "LR", "LRC", 0, 1, 3])
def test_as_many_words_as_moebius_counts(letters):
    k = len(letters) if isinstance(letters, str) else letters + 1
    symbols = letters if isinstance(letters, str) else None
    found = words(letters, 9)
    assert len(set(found)) == len(found)
    for n in range(1, 10):
        expected = sum(moebius(n // d) * k**d for d in range(1, n + 1) if n % d == 0) // n
        assert sum(len(letters_of(one, symbols)) == n for one in found) == expected


@pytest.mark.parametrize(("most", "length", "impacts"), [(1, 7, None), (2, 6, None), (2, 6, 3), (12, 3, 12), (3, 5, 0)])
def test_words_are_all_that_cycles_of_letters_give(most, length, impacts):
    cycles = (c for n in range(1, length + 1) for c in itertools.product(range(most + 1), repeat=n))
    every = {word(c) for c in cycles if len(primitive(c)) == len(c) and (impacts is None or sum(c) <= impacts)}
    found = words(most, length, impacts)
    assert set(found) == every and len(found) == len(every)
    assert list(found) == sorted(found, key=lambda one: (len(letters_of(one)), letters_of(one)))
    assert all(word(letters_of(one)) == one for one in found)


def test_a_bound_on_impacts_keeps_long_words_few():
    # one impact in up to 60 periods: the bound prunes, or 2^60 cycles would be gone through
    assert words(1, 60, impacts=1) == ("0", *("0" * n + "1" for n in range(60)))


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
        (lambda: words("", 3), "letters = ''; give different symbols, such as 'LR'"),
        (lambda: words("LRL", 3), "letters = 'LRL'; give different symbols"),
        (lambda: words("LR", 0), "length = 0; allowed is a whole number >= 1"),
        (lambda: words(-1, 2), "letters = -1; allowed is a whole number >= 0"),
        (lambda: words(1, 2, -1), "impacts = -1; allowed is a whole number >= 0"),
        (lambda: words("LR", 2, 1), "impacts = 1 for the symbols 'LR'; it bounds letters that are counts"),
        (lambda: letters_of("LS", "LR"), "word 'LS' has 'S' at position 1; allowed are L, R"),
    ],
)
def test_error_texts(call, said):
    with pytest.raises(gz.InputError, match=said):
        call()
