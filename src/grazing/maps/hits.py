"""Letters of a step between walls: the walls that are hit in it, in order."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grazing.outcome import InputError, listed, shown
from grazing.parameter import whole

#: Impacts between two walls that a letter can tell apart, and what stands for more: 3**19 is below 2**31.
MOST = 19
MANY = -5
#: Codes of chatter that was completed at the first wall, and of a ball that lay there throughout; for the second wall
#: two less.
CHATTER, LAY = -1, -2


#: What the letter of an impact map has more than the strobes passed, for each wall before the one that is hit: twelve
#: walls and sums of strobes fit.
LATER = 2**27


def most_of(walls: int) -> int:
    """Return how many impacts a letter can tell apart: digits to base walls + 1, below 2**31.

    Examples
    --------
    >>> from grazing.maps.hits import most_of
    >>> most_of(2), most_of(3), most_of(12)
    (19, 15, 8)
    """
    count = 0
    while (walls + 1) ** (count + 1) < 2**31:
        count += 1
    return count


def digits_of(code: int, base: int) -> list[int] | None:
    """Return the digits of the code of a letter, from 1 on; None for a code that has others."""
    found, left = list[int](), code
    while left > 0:
        left, digit = divmod(left, base)
        found.insert(0, digit)
    return None if code < 0 or 0 in found else found


class Alphabet:
    """What spells letters in words where they are neither counts nor one character each.

    ``most`` is how long a symbol is at most, without parentheses.
    """

    __slots__ = ()

    @property
    def most(self) -> int:
        """Characters of a symbol at most."""
        raise NotImplementedError

    def symbol(self, letter: int) -> str:
        """Return what stands for a letter in a word."""
        raise NotImplementedError

    def read(self, text: str, position: int) -> tuple[int, int]:
        """Return the letter that stands at a position of a text, and where the next one begins."""
        raise NotImplementedError

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of its letters."""
        raise NotImplementedError


@dataclass(frozen=True)
class Names(Alphabet):
    """The alphabet of a map whose letters are names of objects: one character as it is, longer ones in parentheses.

    Parameters
    ----------
    names : tuple of str
        Of letters 0, 1, ...

    Examples
    --------
    >>> from grazing.maps.hits import Names
    >>> names = Names(("A", "bumper"))
    >>> names.symbol(1), names.read("A(bumper)", 1)
    ('(bumper)', (1, 9))
    """

    names: tuple[str, ...]

    def __str__(self) -> str:
        return ", ".join(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    @property
    def most(self) -> int:
        """Characters of a name at most."""
        return max(map(len, self.names))

    def symbol(self, letter: int) -> str:
        """Return what stands for a letter in a word."""
        letter = whole(letter, "letter", 0)
        if letter >= len(self.names):
            raise InputError(f"letter {letter} has no name; allowed are 0 to {len(self.names) - 1}: {self}")
        name = self.names[letter]
        return name if len(name) == 1 else f"({name})"

    def read(self, text: str, position: int) -> tuple[int, int]:
        """Return the letter that stands at a position of a text, and where the next one begins."""
        end = text.find(")", position) if text[position] == "(" else position
        name = text[position : end + 1].strip("()") if end >= 0 else ""
        if name not in self.names:
            raise InputError(
                f"word {shown(text)} has {shown(text[position:])} at position {position}; allowed are "
                f"{', '.join(map(self.symbol, range(len(self.names))))}"
            )
        return self.names.index(name), end + 1

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of its letters."""
        codes = np.arange(len(self.names), dtype=np.int32)
        return {"long_name": "letter of the step", "flag_values": codes, "flag_meanings": " ".join(self.names)}


@dataclass(frozen=True, slots=True)
class Hits(Alphabet):
    """The alphabet of a map between walls.

    A letter is the walls hit in the step, in order: ``0`` for none, ``A``, ``B``, and several in parentheses, ``(AB)``.
    ``(more)`` are more impacts than a letter can tell apart: 19 between two walls. Between two, ``(CA)`` is chatter
    completed at A, ``(SA)`` a ball that lay on A throughout.

    Parameters
    ----------
    names : str
        Of the walls, from below or in their order: one letter each.

    Examples
    --------
    >>> from grazing.maps.hits import Hits
    >>> hits = Hits("AB")
    >>> hits.symbol(0), hits.symbol(1), hits.symbol(5), hits.symbol(-3)
    ('0', 'A', '(AB)', '(CB)')
    """

    names: str
    _symbols: re.Pattern[str] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        names, rests = re.escape(self.names), rf"[CS][{re.escape(self.names)}]|" if self.rests else ""
        several = rf"[{names}]{{2,{self.most}}}"
        object.__setattr__(self, "_symbols", re.compile(rf"0|[{names}]|\(({rests}{several}|more)\)"))

    def __str__(self) -> str:
        return self.names

    @property
    def base(self) -> int:
        """Of the digits in a code."""
        return len(self.names) + 1

    @property
    def most(self) -> int:
        """Impacts that a letter can tell apart."""
        return most_of(len(self.names))

    @property
    def rests(self) -> bool:
        """Whether there are letters for completed chatter and for rest."""
        return len(self.names) == 2

    @property
    def special(self) -> dict[int, str]:
        """What letters mean that are no impacts in order, by their codes."""
        many = {MANY: f"more_than_{self.most}_impacts"}
        if not self.rests:
            return many
        return {
            **many,
            **{CHATTER - 2 * j: f"completed_chatter_at_{name}" for j, name in enumerate(self.names)},
            **{LAY - 2 * j: f"stuck_throughout_on_{name}" for j, name in enumerate(self.names)},
        }

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of its letters."""
        digits = ", ".join(f"{name} is {digit}" for digit, name in enumerate(self.names, start=1))
        said = f"letter of the step: the walls that are hit, in order, as digits to base {self.base}: {digits}"
        return {
            "long_name": said,
            "flag_values": np.array(sorted(self.special), np.int32),
            "flag_meanings": " ".join(self.special[code] for code in sorted(self.special)),
            "surfaces": self.names,
        }

    def symbol(self, letter: int) -> str:
        """Return what stands for a letter in a word."""
        if letter == MANY:
            return "(more)"
        if MANY < letter < 0 and self.rests:
            return f"({'CS'[(-letter - 1) % 2]}{self.names[(-letter - 1) // 2]})"
        digits = digits_of(letter, self.base)
        if digits is None or len(digits) > self.most:
            raise InputError(f"letter {letter} has no symbol between the walls {' and '.join(self.names)}")
        found = "".join(self.names[digit - 1] for digit in digits)
        return found if len(found) == 1 else (f"({found})" if found else "0")

    def longer(self, letter: int, wall: int) -> int:
        """Return the letter of a step with one impact more, at a wall by its number."""
        if letter == MANY or letter * self.base + 1 >= self.base**self.most:
            return MANY
        return letter * self.base + 1 + wall

    def walls(self, letter: int) -> tuple[int, ...]:
        """Return the numbers of the walls that are hit in a step, in order; none for a letter that is no impacts."""
        symbol = self.symbol(letter)
        return () if letter <= 0 else tuple(self.names.index(name) for name in symbol.strip("()"))

    def read(self, text: str, position: int) -> tuple[int, int]:
        """Return the letter that stands at a position of a text, and where the next one begins."""
        found = self._symbols.match(text, position)
        if found is None:
            rests = [f"({kind}{name})" for name in self.names for kind in "CS"] if self.rests else ["(more)"]
            raise InputError(
                f"word {shown(text)} has {shown(text[position:])} at position {position}; allowed are "
                f"{', '.join(['0', *self.names])}, several impacts of one period such as ({self.names[:2]}), and "
                f"{', '.join(rests)}"
            )
        inside = found[1] or found[0]
        if inside == "more":
            return MANY, found.end()
        if inside[0] in "CS":
            return -1 - "CS".index(inside[0]) - 2 * self.names.index(inside[1]), found.end()
        letter = 0
        for name in inside if inside != "0" else "":
            letter = self.base * letter + 1 + self.names.index(name)
        return letter, found.end()


@dataclass(frozen=True, slots=True)
class Struck(Hits):
    """The alphabet of an impact map between walls.

    A letter is the wall that the step ends at, with the strobes passed on the way in front of it: ``A``, ``1B``.

    Examples
    --------
    >>> from grazing.maps.hits import LATER, Struck
    >>> struck = Struck("AB")
    >>> struck.symbol(0), struck.symbol(LATER + 12), struck.read("A12B", 1) == (LATER + 12, 4)
    ('A', '12B', True)
    """

    def __post_init__(self) -> None:
        object.__setattr__(self, "_symbols", re.compile(rf"(0|[1-9][0-9]{{0,4}})?([{re.escape(self.names)}])"))

    @property
    def most(self) -> int:
        """Signs of a letter beside the parentheses of others."""
        return 5

    @property
    def special(self) -> dict[int, str]:
        """What letters mean that are no impacts: there are none."""
        return {}

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of its letters."""
        more = ", ".join(f"{j * LATER} more for one at {name}" for j, name in enumerate(self.names) if j)
        said = f"letter of the step: strobes passed to an impact at {self.names[0]}; {more}"
        return {"long_name": said, "walls": self.names}

    def symbol(self, letter: int) -> str:
        """Return what stands for a letter in a word."""
        wall, strobes = divmod(letter, LATER)
        return f"{strobes or ''}{self.names[wall]}"

    def strobes(self, letter: int) -> int:
        """Return how many strobes a step passes."""
        return letter % LATER

    def walls(self, letter: int) -> tuple[int, ...]:
        """Return the number of the wall that is hit."""
        return (letter // LATER,)

    def read(self, text: str, position: int) -> tuple[int, int]:
        """Return the letter that stands at a position of a text, and where the next one begins."""
        found = self._symbols.match(text, position)
        if found is None:
            raise InputError(
                f"word {shown(text)} has {shown(text[position:])} at position {position}; allowed are "
                f"{listed(self.names)}, with the strobes passed in front: 1{self.names[-1]}"
            )
        return int(found[1] or 0) + LATER * self.names.index(found[2]), found.end()


@dataclass(frozen=True)
class Bounces(Alphabet):
    """The alphabet of a stroboscopic map of a table: the objects that are hit in the step, in order, or the way out.

    A letter is a name of one character as it is; longer ones, and several, are in parentheses: ``(bumper-A)``. ``0``
    is no impact, ``(more)`` more than a letter can tell apart.

    Parameters
    ----------
    names : tuple of str
        Of the objects, and *away*.

    Examples
    --------
    >>> from grazing.maps.hits import Bounces
    >>> bounces = Bounces(("A", "bumper", "away"))
    >>> bounces.symbol(0), bounces.symbol(1), bounces.symbol(1 * 4 + 2), bounces.read("A(A-bumper)0", 1)
    ('0', 'A', '(A-bumper)', (6, 11))
    """

    names: tuple[str, ...]

    def __str__(self) -> str:
        return ", ".join(self.names)

    @property
    def most(self) -> int:
        """Impacts that a letter can tell apart."""
        return most_of(len(self.names))

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of its letters."""
        said = f"letter of the step: the objects that are hit, in order, as digits to base {len(self.names) + 1}"
        many = {"flag_values": np.array([MANY], np.int32), "flag_meanings": f"more_than_{self.most}_impacts"}
        return {"long_name": said, **many, "objects": " ".join(self.names)}

    def symbol(self, letter: int) -> str:
        """Return what stands for a letter in a word."""
        if letter == MANY:
            return "(more)"
        digits = digits_of(letter, len(self.names) + 1)
        if digits is None or len(digits) > self.most:
            raise InputError(f"letter {letter} has no symbol between the objects {self}")
        found = "-".join(self.names[digit - 1] for digit in digits) or "0"
        return found if len(found) == 1 else f"({found})"

    def read(self, text: str, position: int) -> tuple[int, int]:
        """Return the letter that stands at a position of a text, and where the next one begins."""
        end = text.find(")", position) if text[position] == "(" else position
        inside = text[position : end + 1].strip("()") if end >= 0 else ""
        hit = [] if inside == "0" else inside.split("-")
        if inside == "more" and inside not in self.names:
            return MANY, end + 1
        if len(hit) > self.most or not all(name in self.names for name in hit):
            raise InputError(
                f"word {shown(text)} has {shown(text[position:])} at position {position}; allowed are "
                f"{', '.join(map(self.symbol, range(len(self.names) + 1)))}, up to {self.most} impacts of one period, "
                f"such as ({self.names[0]}-{self.names[-1]}), and (more)"
            )
        return self.letter([self.names.index(name) for name in hit]), end + 1

    def letter(self, hit: Sequence[int]) -> int:
        """Return the letter of a step in which objects are hit, by their numbers."""
        letter = 0
        for number in hit:
            letter = (len(self.names) + 1) * letter + 1 + number
        return letter if len(hit) <= self.most else MANY
