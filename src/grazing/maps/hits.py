"""Letters of a step between two walls: the walls that are hit in it, in order."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from grazing.outcome import InputError, shown

#: Impacts that a letter can tell apart, and what stands for more: 3**19 is below 2**31.
MOST = 19
MANY = -5
#: Codes of chatter that was completed at the first wall, and of a ball that lay there throughout; for the second wall
#: two less.
CHATTER, LAY = -1, -2


@dataclass(frozen=True, slots=True)
class Hits:
    """The alphabet of a map between two walls.

    A letter is the walls hit in the step, in order: ``0`` for none, ``A``, ``B``, and several in parentheses, ``(AB)``.
    ``(CA)`` is chatter completed at A, ``(SA)`` a ball that lay on A throughout, ``(more)`` are more than 19 impacts.

    Parameters
    ----------
    names : str
        Of the walls, from below: one letter each.

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
        names = re.escape(self.names)
        object.__setattr__(self, "_symbols", re.compile(rf"0|[{names}]|\(([CS][{names}]|[{names}]{{2,{MOST}}}|more)\)"))

    def __str__(self) -> str:
        return self.names

    @property
    def special(self) -> dict[int, str]:
        """What letters mean that are no impacts in order, by their codes."""
        return {
            MANY: f"more_than_{MOST}_impacts",
            **{CHATTER - 2 * j: f"completed_chatter_at_{name}" for j, name in enumerate(self.names)},
            **{LAY - 2 * j: f"stuck_throughout_on_{name}" for j, name in enumerate(self.names)},
        }

    def symbol(self, letter: int) -> str:
        """Return what stands for a letter in a word."""
        if letter == MANY:
            return "(more)"
        if MANY < letter < 0:
            return f"({'CS'[(-letter - 1) % 2]}{self.names[(-letter - 1) // 2]})"
        found, left = "", letter
        while left > 0:
            left, digit = divmod(left, 3)
            if digit == 0:
                break
            found = self.names[digit - 1] + found
        if left or letter < MANY or len(found) > MOST:
            raise InputError(f"letter {letter} has no symbol between the walls {' and '.join(self.names)}")
        return found if len(found) == 1 else (f"({found})" if found else "0")

    def read(self, text: str, position: int) -> tuple[int, int]:
        """Return the letter that stands at a position of a text, and where the next one begins."""
        found = self._symbols.match(text, position)
        if found is None:
            low, high = self.names[0], self.names[1]
            raise InputError(
                f"word {shown(text)} has {shown(text[position:])} at position {position}; allowed are 0, {low}, "
                f"{high}, several impacts of one period such as ({low}{high}), and (C{low}), (S{low}), (C{high}), "
                f"(S{high})"
            )
        inside = found[1] or found[0]
        if inside == "more":
            return MANY, found.end()
        if inside[0] in "CS":
            return -1 - "CS".index(inside[0]) - 2 * self.names.index(inside[1]), found.end()
        letter = 0
        for name in inside if inside != "0" else "":
            letter = 3 * letter + 1 + self.names.index(name)
        return letter, found.end()
