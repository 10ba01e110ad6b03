"""The word of an orbit: the letters that it visits, written so that every start on the orbit gives the same word.

A word is primitive (no repetition of a shorter one) and in its least rotation, where letters are ordered by their
code. So L comes before R, counts are in order, and a ball at rest (S) and completed chatter (C), whose codes are
negative, come before all counts. A word names a class of orbits: a doubled LLR has word LLR and period 6.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any

from grazing.maps.hits import Alphabet
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.outcome import InputError, shown
from grazing.parameter import whole

_SPECIAL = {CHATTER_LETTER: "C", STUCK_LETTER: "S"}
_COUNTS = {"C": CHATTER_LETTER, "S": STUCK_LETTER}
_COUNT = re.compile(r"[0-9CS]|\(([1-9][0-9]+)\)")


#: Words that a list may have.
MANY = 10**7
#: Letters that a word in a list may have.
LONGEST = 500


def primitive(letters: Iterable[int]) -> tuple[int, ...]:
    """Return the shortest sequence of which the letters are a repetition, in linear time.

    Parameters
    ----------
    letters : iterable of int
        At least one letter.

    Returns
    -------
    tuple of int

    Examples
    --------
    >>> primitive((0, 0, 1, 0, 0, 1))
    (0, 0, 1)
    """
    s = _sequence(letters)
    border = [0] * len(s)  # longest proper prefix of s[:i+1] that is also its suffix (Knuth, Morris and Pratt)
    for i in range(1, len(s)):
        k = border[i - 1]
        while k and s[k] != s[i]:
            k = border[k - 1]
        border[i] = k + (s[k] == s[i])
    period = len(s) - border[-1]
    return s[:period] if len(s) % period == 0 else s


def least_rotation(letters: Iterable[int]) -> tuple[int, ...]:
    """Return the rotation that comes first in lexicographic order of the letters' codes, in linear time.

    Parameters
    ----------
    letters : iterable of int
        At least one letter.

    Returns
    -------
    tuple of int

    Examples
    --------
    >>> least_rotation((1, 0, 0))
    (0, 0, 1)
    """
    s = _sequence(letters)
    first = least_start(s, 0, len(s))
    return s[first:] + s[:first]


def wrapped(n: int, length: int) -> int:
    """Return n modulo the length, for n below twice the length: a division takes long."""
    return n - length if n >= length else n


def least_start(s: Any, first: int, n: int) -> int:
    """Return where, in the cycle of n letters from ``first`` on, the least rotation begins; counted from ``first``."""
    i, j, k = 0, 1, 0  # two rotations that agree in k letters; the larger one and all between them drop out
    while i < n and j < n and k < n:
        a, b = s[first + wrapped(i + k, n)], s[first + wrapped(j + k, n)]
        if a == b:
            k += 1
            continue
        if a > b:
            i += k + 1
        else:
            j += k + 1
        if i == j:
            j += 1
        k = 0
    return min(i, j)


def word(letters: Iterable[int], symbols: str | Alphabet | None = None) -> str:
    """Return the word of a cycle of letters.

    Parameters
    ----------
    letters : iterable of int
        The letters of one period, from any point of the orbit on; several periods give the same word.
    symbols : str or Alphabet, optional
        The symbol of letter 0, 1, ..., or the walls that letters name (:attr:`grazing.Map.letters`); None for counts,
        with those above 9 in parentheses, C for completed chatter and S for a ball at rest throughout.

    Returns
    -------
    str

    Raises
    ------
    InputError
        For no letter at all, or one that has no symbol.

    Examples
    --------
    >>> word((1, 0, 0, 1, 0, 0), "LR")
    'LLR'
    >>> word((12, 0))
    '0(12)'
    """
    return spelled(least_rotation(primitive(letters)), symbols)


def spelled(letters: Iterable[int], symbols: str | Alphabet | None = None) -> str:
    """Return letters as text, as :func:`word` writes them, but neither rotated nor shortened.

    Examples
    --------
    >>> spelled((1, 0, 0, 1, 0, 0), "LR")
    'RLLRLL'
    """
    return "".join(_symbol(int(letter), symbols) for letter in letters)


def letters_of(text: str, symbols: str | Alphabet | None = None) -> tuple[int, ...]:
    """Return the letters that a word spells; the inverse of :func:`word` on words.

    Parameters
    ----------
    text : str
        Any spelling: it need not be primitive or rotated.
    symbols : str, optional
        As in :func:`word`.

    Returns
    -------
    tuple of int

    Raises
    ------
    InputError
        For a text with a symbol that is not known, or for an empty one.

    Examples
    --------
    >>> letters_of("LLR", "LR"), letters_of("0(12)C")
    ((0, 0, 1), (0, 12, -1))
    """
    if not isinstance(text, str):
        raise InputError(f"word is {shown(text)}; give a text")
    letters: list[int] = []
    position = 0
    while position < len(text):
        if isinstance(symbols, Alphabet):
            letter, position = symbols.read(text, position)
            letters.append(letter)
            continue
        found = None if symbols is not None else _COUNT.match(text, position)
        if symbols is not None and text[position] in symbols:
            letters.append(symbols.index(text[position]))
            position += 1
        elif found is not None:
            letters.append(_COUNTS[found[0]] if found[0] in _COUNTS else int(found[1] or found[0]))
            position = found.end()
        else:
            allowed = "0 to 9, (10) and above, C, S" if symbols is None else ", ".join(symbols)
            raise InputError(
                f"word {shown(text)} has {shown(text[position:])} at position {position}; allowed are {allowed}"
            )
    return _sequence(letters)


def words(letters: str | int, length: int, impacts: int | None = None) -> tuple[str, ...]:
    """Return every word up to a length: one for each class of primitive cycles of letters.

    Parameters
    ----------
    letters : str or int
        The symbols of letter 0, 1, ..., such as ``"LR"`` for the gap map (:attr:`grazing.Map.letters`); or, for
        the oscillator, the greatest number of impacts in one period of the forcing.
    length : int
        Greatest number of letters, 1 to 500.
    impacts : int, optional
        Greatest number of impacts in the whole word, for letters that are counts.

    Returns
    -------
    tuple of str
        As :func:`word` writes them, by length and then in the order of the letters' codes.

    Raises
    ------
    InputError
        For no letters, repeated ones, or a number out of range.

    Notes
    -----
    Words in their least rotation are Lyndon words. They are read off the prefixes of necklaces, which the algorithm
    of Fredricksen, Kessler and Maiorana visits in constant mean time each (Ruskey, Savage and Wang, J. Algorithms 13
    (1992) 414-430); there are ``(1/n) sum_(d|n) moebius(n/d) k^d`` of length n on k letters.

    Examples
    --------
    >>> words("LR", 4)
    ('L', 'R', 'LR', 'LLR', 'LRR', 'LLLR', 'LLRR', 'LRRR')
    >>> words(2, 3, impacts=2)
    ('0', '1', '2', '01', '02', '001', '002', '011')
    """
    longest = whole(length, "length", 1)
    if isinstance(letters, str):
        if not letters or len(set(letters)) < len(letters):
            raise InputError(f"letters = {shown(letters)}; give different symbols, such as 'LR', or the most impacts")
        if impacts is not None:
            raise InputError(
                f"impacts = {shown(impacts)} for the symbols {shown(letters)}; it bounds letters that are counts"
            )
        symbols, count, most = letters, len(letters), None
    else:
        symbols, count = None, whole(letters, "letters", 0) + 1
        most = None if impacts is None else whole(impacts, "impacts", 0)
    known = min(count, MANY) ** min(longest, 64) // longest if count > 1 else longest  # without the shorter ones
    if most is None and known > MANY:
        raise InputError(
            f"there are more than {MANY} words of {count} letters up to length {longest}; give a shorter length"
        )
    if longest > LONGEST and (count > 1 or symbols is None):
        raise InputError(f"length = {longest}; allowed is a whole number from 1 to {LONGEST}")
    every = (one for n in range(1, longest + 1) for one in _lyndon(n, count, most))
    found = list(islice(every, MANY + 1))
    if len(found) > MANY:
        raise InputError(
            f"there are more than {MANY} words; give a shorter length ({longest}) or fewer impacts ({most})"
        )
    return tuple(spelled(one, symbols) for one in found)


def _lyndon(n: int, count: int, most: int | None) -> Iterator[tuple[int, ...]]:
    """Yield the Lyndon words of length n on the letters below `count`, with a sum of at most `most`, in order."""
    a = [0] * (n + 1)  # a[0] is a sentinel before the first letter
    last = count - 1 if most is None else min(count - 1, most)

    def extend(t: int, p: int, total: int) -> Iterator[tuple[int, ...]]:
        """Go through the prefixes of necklaces whose first t - 1 letters are set; p: their longest Lyndon prefix."""
        if t > n:
            if p == n:
                yield tuple(a[1:])
            return
        for letter in range(a[t - p], last + 1):
            if most is not None and total + letter > most:
                break
            a[t] = letter
            yield from extend(t + 1, p if letter == a[t - p] else t, total + letter)

    yield from extend(1, 1, 0)


def _sequence(letters: Iterable[int]) -> tuple[int, ...]:
    s = tuple(map(int, letters))
    if not s:
        raise InputError("a word of no letters; give the letters of at least one step")
    return s


def _symbol(letter: int, symbols: str | Alphabet | None) -> str:
    if isinstance(symbols, Alphabet):
        return symbols.symbol(letter)
    if symbols is None:
        if letter in _SPECIAL:
            return _SPECIAL[letter]
        if letter >= 0:
            return str(letter) if letter < 10 else f"({letter})"
        raise InputError(f"letter {letter} has no symbol; allowed are counts >= 0, {_names()}")
    if 0 <= letter < len(symbols):
        return symbols[letter]
    raise InputError(f"letter {letter} has no symbol in {shown(symbols)}; allowed are 0 to {len(symbols) - 1}")


def _names() -> str:
    return " and ".join(f"{letter} ({symbol})" for letter, symbol in _SPECIAL.items())
