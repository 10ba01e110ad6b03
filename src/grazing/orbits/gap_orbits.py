"""All periodic orbits of the gap map of one period, from the words of that length."""

from __future__ import annotations

import numpy as np

from grazing.maps.map import Map
from grazing.orbits.finder import LONGEST_WORDS, Finder, Looked, Tally, Wanted
from grazing.orbits.orbit import Orbit
from grazing.orbits.word import letters_of, word, words
from grazing.outcome import InputError, shown
from grazing.parameter import whole
from grazing.theory import WordOrbit


def gap_orbits(G: Map, period: int) -> tuple[Orbit, ...]:
    """Return all periodic orbits of the gap map with a least period, admissible and virtual.

    Parameters
    ----------
    G : Map
        From :func:`grazing.gap_map`, or the gap map of a normal form; any finite lam, mu and l.
    period : int
        Least period, >= 1.

    Returns
    -------
    tuple of Orbit
        In the order of the words; then doubled orbits of words of half the length. ``points`` (period, 1) begin
        with the first letter of the word. ``condition`` is infinite at a fold and 0 at a graze.

    Raises
    ------
    InputError
        For another map, or a period that is no whole number >= 1.
    OutsideForm
        At lam = 1 or -1, where the orbits left of the border come in families or not at all.

    Notes
    -----
    The list is complete (:func:`grazing.theory.word_orbits` says why): each word has at most three orbits, and of
    repetitions of a word only the double has one. The number of words grows as 2^period/period.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.gap_orbits import gap_orbits
    >>> [orbit for orbit in gap_orbits(gz.gap_map(lam=0.8, mu=0.5, l=1.0), 3) if orbit.admissible]
    [<Orbit LLR, period 3, stable, admissible>]
    """
    if not isinstance(G, Map) or G.origin.orbits is None:
        raise InputError(
            f"the words of {shown(G)} cannot be solved; give a gap map, gz.gap_map(lam=..., mu=..., l=...)"
        )
    n = whole(period, "period", 1)
    spelled = [one for one in words("LR", n) if len(one) == n]
    if n % 2 == 0:
        spelled += [one * 2 for one in words("LR", n // 2) if len(one) == n // 2]
    return tuple(_orbit(G, found) for one in spelled for found in G.origin.orbits(one, G.params))


class Words(Finder):
    """Finds the orbits of a map whose words are solved by algebra."""

    longest = LONGEST_WORDS
    why = "every word of the length is solved by algebra"

    def find(self, wanted: Wanted) -> Looked:
        """Return all orbits."""
        found = [orbit for n in wanted.periods for orbit in gap_orbits(self.P, n)]
        tally = Tally(signatures={(n, n) for n in wanted.periods})
        return Looked(found, tally, sum(not orbit.admissible for orbit in found), complete=True)


def _orbit(G: Map, found: WordOrbit) -> Orbit:
    """Return a solution of a word as an orbit of the map."""
    away = abs(1.0 - found.multiplier)
    return Orbit(
        map=G,
        points=found.points[:, None],
        word=word(letters_of(found.word, "LR"), "LR"),
        period=len(found.word),
        multipliers=np.array([found.multiplier], dtype=np.complex128),
        admissible=found.admissible,
        condition=1.0 / away if away > 0.0 else float("inf"),
        residual=found.residual,
    )
