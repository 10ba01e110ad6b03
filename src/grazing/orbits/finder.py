"""How the periodic orbits of a map are found: each origin names its finder, by what it knows better than the step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from grazing.late import named
from grazing.maps.map import Map
from grazing.orbits.orbit import Orbit
from grazing.outcome import listed

if TYPE_CHECKING:
    from grazing.orbits.periodic import Searched

#: Longest period of a search; of one that solves each word, of which there are 2^period/period.
LONGEST, LONGEST_WORDS = 64, 20


@dataclass
class Tally:
    """What a search has done: simulated steps, Newton's method begun and converged, signatures tried."""

    starts: int = 0
    steps: int = 0
    attempts: int = 0
    converged: int = 0
    signatures: set[tuple[int, int]] = field(default_factory=set)


class Wanted(NamedTuple):
    """What is looked for: periods in steps of the map, and a word with its letters if any; how hard, and from where.

    ``virtual`` says whether virtual orbits are listed, ``energy`` is that of a conservative table.
    """

    periods: tuple[int, ...]
    starts: int
    seed: int
    threads: int | None = None
    word: str | None = None
    letters: tuple[int, ...] | None = None
    virtual: bool = False
    energy: float | None = None


class Looked(NamedTuple):
    """The orbits that were found, how many virtual ones were met, and what :class:`Searched` says of the search."""

    orbits: list[Orbit]
    tally: Tally
    virtual: int
    complete: bool = False
    turned: tuple[str, ...] = ()
    impossible: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    families: tuple[str, ...] = ()


class Finder:
    """Finds the periodic orbits of a map.

    ``longest`` is the longest period of a search, ``why`` says of a complete list why it is, and ``energetic`` whether
    orbits come in families by their energy.
    """

    longest: ClassVar[int] = LONGEST
    why: ClassVar[str] = ""
    energetic: ClassVar[bool] = False

    def __init__(self, P: Map) -> None:
        self.P = P

    def refuse_word(self, text: str, letters: tuple[int, ...]) -> None:
        """Raise InputError for a word that no orbit can have, known without a search."""

    def refuse_long(self, text: str, letters: tuple[int, ...], longest: int) -> None:
        """Raise InputError for a word that is too much work in so many steps."""

    def find(self, wanted: Wanted) -> Looked:
        """Return the orbits, admissible and virtual."""
        raise NotImplementedError

    def of_many(self, orbit: Orbit) -> bool:
        """Whether an orbit with a multiplier 1 is one of a continuum, of which no other need be met."""
        return False

    def how(self, s: Searched, word: str | None, found: int) -> str:
        """Say how orbits were found, of a word if one was asked for, and that there may be others."""
        said = (
            f"found by {counted(s.attempts, 'Newton attempt')}, of which {s.converged} converged, from "
            f"near-recurrences of {counted(s.starts, 'random start')} in {counted(s.steps, 'step')} and other guesses"
            f"{self.beside(s, word)}"
        )
        if found == 0:
            return f"{said}; more starts, another seed or virtual=True may find some, and others may exist"
        return f"{said}; this is no proof that there are no others"

    def beside(self, s: Searched, word: str | None) -> str:
        """Say what else was tried."""
        return ""


def finder_of(P: Map) -> Finder:
    """Return what finds the orbits of a map."""
    found: Finder = named(P.origin.finder)(P)
    return found


def ranged(periods: Sequence[int]) -> str:
    """Return periods with commas between them, or the first and the last of several in a row."""
    if len(periods) > 2 and periods[-1] - periods[0] == len(periods) - 1:
        return f"{periods[0]} to {periods[-1]}"
    return listed(map(str, periods))


def counted(n: int, what: str) -> str:
    """Return a number with what is counted."""
    return f"{n} {what}" if n == 1 else f"{n} {what}s"
