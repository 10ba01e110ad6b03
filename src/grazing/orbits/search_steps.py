"""Periodic orbits of a map of which no more is known than its step, or its pieces: by Newton's method on the map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from grazing.orbits.finder import Finder, Looked, Tally, Wanted, ranged
from grazing.orbits.search_map import Cycles
from grazing.orbits.search_pieces import piece_orbits, spelled
from grazing.orbits.search_windows import WIDE, drawn, middle_of, recurrences, refuse_many, simulated
from grazing.orbits.word import letters_of

if TYPE_CHECKING:
    from grazing.orbits.periodic import Searched

#: Random guesses of a period in each region.
GUESSES = 500


class Steps(Finder):
    """Finds orbits from near-recurrences and random guesses; of a map by pieces each word has equations of its own."""

    def find(self, wanted: Wanted) -> Looked:
        """Return the orbits."""
        P, (periods, starts, seed) = self.P, wanted[:3]
        refuse_many(P, starts, periods[-1])
        tally, box, (middle, half) = Tally(), np.array(P.box), middle_of(P)
        wide = np.hstack([middle - WIDE * half, middle + WIDE * half])
        many = starts // 2
        states = np.hstack([drawn(seed, starts - many, box, 0.0), drawn(seed, many, wide, 1.0)])
        runs = simulated(P, states, periods[-1], wanted.threads)
        tally.starts, tally.steps = runs.starts, runs.steps
        cycles, where = Cycles(P, tally), (runs.region, (box[:, 0], box[:, 1]))  # what repels may lie where none stays
        for n in periods:
            cycles.add(recurrences(runs, n, starts).points)
            for low, high in where:
                cycles.at_random(n, low, high, GUESSES, seed)
        found = [(n, cycles.orbits(n)) for n in periods]
        if P.formulas is not None:
            found = [(n, [*piece_orbits(P, n, wanted.letters, known, where, seed, tally)]) for n, known in found]
        orbits = [orbit for _n, some in found for orbit in some]
        return Looked(orbits, tally, sum(not orbit.admissible for orbit in orbits))

    def beside(self, s: Searched, word: str | None) -> str:
        """Say which words were solved by their pieces."""
        if self.P.formulas is None:
            return ""
        asked = letters_of(word, self.P.letters) if word is not None else None
        solved = tuple(n for n in s.periods if spelled(self.P, n, asked))
        which = "the word" if asked else "each word of the length" if len(solved) == len(s.periods) else ""
        which = which or (f"each word of period {ranged(solved)}" if solved else "")
        return f", with the pieces of {which} beyond the border too" if which else ""
