"""All periodic orbits of a map that a search finds, stable and unstable, and how thoroughly it searched."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from grazing.maps.map import Map
from grazing.orbits.finder import Finder, Wanted, counted, finder_of, ranged
from grazing.orbits.orbit import Orbit
from grazing.orbits.word import least_rotation, letters_of, primitive
from grazing.orbits.word import word as spelled
from grazing.outcome import InputError, listed, shown
from grazing.parameter import real, whole

#: Orbits of one word and period with a multiplier 1 that are a continuum: at a fold two orbits meet.
FAMILY = 3


@dataclass(frozen=True)
class Searched:
    """How thoroughly a search looked for orbits.

    Parameters
    ----------
    periods : tuple of int
        Least periods that were looked for, in steps of the map.
    starts, steps : int
        Random starts, and steps of the map from them, whose near-recurrences gave guesses.
    attempts, converged : int
        How often Newton's method was begun, and how often it arrived at a solution.
    signatures : tuple of (int, int)
        For an oscillator (impacts, forcing periods) that were tried; for other maps (period, period).
    virtual : int
        Virtual orbits that were met, whether or not they are listed.
    complete : bool
        Whether the list is proved to hold every orbit: by algebra, for the gap map.
    seed : int
        Of the random starts and guesses.
    continua : tuple of (str, int, int)
        Words and periods of which so many orbits with a multiplier 1 were met, and one is listed.
    turned : tuple of str
        Where no orbit has the word that was asked for: the words of those that hit the same walls in the same order
        all around, but are elsewhere at the strobe, as (BA) is for (AB).
    impossible : tuple of str
        On a table: what no orbit can do, proven, each with the reason. Words with that were not looked for.
    missing : tuple of str
        On a table: words of which no orbit was found, not even a virtual one, though nothing forbids it.
    families : tuple of str
        On a table: words that conserve energy, and were not looked for as none was given.
    """

    periods: tuple[int, ...]
    starts: int
    steps: int
    attempts: int
    converged: int
    signatures: tuple[tuple[int, int], ...]
    virtual: int
    complete: bool
    seed: int
    continua: tuple[tuple[str, int, int], ...] = ()
    turned: tuple[str, ...] = ()
    impossible: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    families: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Searched({', '.join(f'{one.name}={shown(getattr(self, one.name))}' for one in fields(self))})"


class Orbits(tuple[Orbit, ...]):
    """The periodic orbits that :func:`periodic_orbits` found, in order, and how thoroughly it searched.

    Attributes
    ----------
    map : Map
    word : str or None
        The word that was asked for.
    searched : Searched
    """

    map: Map
    word: str | None
    searched: Searched

    def __new__(cls, orbits: Iterable[Orbit], P: Map, word: str | None, searched: Searched) -> Orbits:
        """Make the tuple and attach what is known of the search."""
        self = super().__new__(cls, orbits)
        self.map, self.word, self.searched = P, word, searched
        return self

    def __getnewargs__(self) -> Any:
        return tuple(self), self.map, self.word, self.searched

    def __repr__(self) -> str:
        return f"<Orbits of {self.map.name}: {self.statement}>"

    @property
    def statement(self) -> str:
        """One sentence: what was found, by what, and whether that is all."""
        s = self.searched
        kept = [orbit for orbit in self if orbit.admissible]
        stable, neutral = sum(orbit.stable for orbit in kept), sum(orbit.neutral for orbit in kept)
        which = f"of word {self.word}, " if self.word is not None else ""
        virtual = len(self) - len(kept)
        said = f"{counted(len(kept), 'orbit')} {which}of least period {ranged(s.periods)}, {stable} stable"
        said += (f", {neutral} neutral" if neutral else "") + f" and {len(kept) - stable - neutral} unstable"
        said += f", and {counted(virtual, 'virtual one')}" if virtual else ""
        for spelled_as, N, many in s.continua:
            met = f"{many} with a multiplier 1 were met, one listed" if many > 1 else "the one in the middle is listed"
            said += f" (of word {spelled_as} and period {N} a continuum: {met})"
        if s.turned:
            said += f" (the same impacts in the same order, but another one first after the strobe: {listed(s.turned)})"
        finder = finder_of(self.map)
        if s.complete:
            return f"{said}: these are all, because {finder.why}"
        return f"{said}: {finder.how(s, self.word, len(self))}"


def periodic_orbits(
    P: Map,
    period: int | Iterable[int] | None = None,
    *,
    word: str | None = None,
    virtual: bool = False,
    energy: float | None = None,
    starts: int = 4000,
    seed: int = 0,
    threads: int | None = None,
) -> Orbits:
    """Find the periodic orbits of a map, stable and unstable.

    Parameters
    ----------
    P : Map
        Any map. The stroboscopic and the impact map of an oscillator are searched in the times and velocities of
        impacts, that of a table word by word in the places of impacts and the times between them, the gap map by
        algebra, others by Newton's method on the map; of a map by pieces each word has
        equations of its own, which find virtual orbits too.
    period : int or iterable of int, optional
        Least periods, in steps of the map; by default the length of ``word``.
    word : str, optional
        Only orbits of this word, such as "001". If none is admissible its virtual orbits are listed.
    virtual : bool
        Whether to list virtual orbits as well; they are marked, ``orbit.admissible`` is False.
    energy : float, optional
        On a table: kinetic and potential energy, for a ball of mass 1, of orbits whose impacts conserve it. Without
        gravity it is 1/2, speed 1, unless given; with gravity such orbits are left out unless it is.
    starts : int
        Random starts, >= 1; also how many near-recurrences of each period become guesses. On a table guesses of each
        period, shared out among its words.
    seed : int
        Of starts and guesses; equal seeds give equal lists.
    threads : int, optional
        None for one per processor; the result does not depend on it.

    Returns
    -------
    Orbits
        A tuple of orbits by period, word and points; ``.statement`` and ``.searched`` say how they were found and
        whether the list is complete.

    Raises
    ------
    InputError
        For another map, a period out of range, or a word that no orbit can have.

    Notes
    -----
    Of an oscillator every flight between impacts is closed form, so that an orbit with n impacts solves 2n analytic
    equations (:mod:`grazing.orbits.closing`). Each solution is flown once more by the exact advance, which says whether
    it is admissible. Orbits that rest on the wall are found by flying from each instant at which the forcing lifts
    the ball; their list is complete. A guess costs the cube of its impacts, so of words with more than 15 fewer are
    tried; the statement says how many. Orbits that agree to 1e-7, at a fold, count as one. Where a ball without a
    spring flies wherever it likes, one flight is listed for all; of any other continuum that is met, one orbit, and the
    statement says how many were met. A ball that has left a table, whose map keeps it in a place, is no orbit.

    Examples
    --------
    >>> import grazing as gz
    >>> P = gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4))
    >>> periodic_orbits(P, 3)[0]
    <ImpactOrbit 001, period 3, stable, admissible>
    >>> periodic_orbits(gz.gap_map(lam=0.8, mu=0.5, l=1.0), range(1, 4)).statement
    '2 orbits of least period 1 to 3, 1 stable and 1 unstable: these are all, because every word of the length is solved
    by algebra'
    """
    if not isinstance(P, Map):
        raise InputError(f"P is {shown(P)}; give a map, such as gz.stroboscopic_map(model) or gz.gap_map(...)")
    starts, seed = whole(starts, "starts", 1), whole(seed, "seed", 0, 2**64 - 1)
    finder = finder_of(P)
    if not isinstance(virtual, bool):
        raise InputError(f"virtual is {shown(virtual)}; give True or False")
    if energy is not None:
        if not finder.energetic:
            raise InputError(
                f"energy is {shown(energy)}; only orbits of a table that conserve it come in families by it"
            )
        energy = real(energy, "energy", "give a finite value")
    asked, letters = checked_word(finder, word)
    periods = _checked_periods(finder, period, letters)
    if letters is not None:
        finder.refuse_long(str(word), letters, periods[-1])
    found = finder.find(Wanted(periods, starts, seed, threads, asked, letters, virtual, energy))
    listing, continua = _one_of_each_continuum(_listing(found.orbits, asked, virtual))
    tally = found.tally
    done = tally.starts, tally.steps, tally.attempts, tally.converged, tuple(sorted(tally.signatures))
    searched = Searched(periods, *done, found.virtual, found.complete, seed, continua, *found[4:])
    return Orbits(listing, P, asked, searched)


def checked_word(finder: Finder, text: object) -> tuple[str | None, tuple[int, ...] | None]:
    """Return a word as the library writes it, and its letters; None for none.

    Raises
    ------
    InputError
        For letters that the map does not have, and for words that no orbit of it can have.
    """
    if text is None:
        return None, None
    if not isinstance(text, str):
        raise InputError(f"word is {shown(text)}; give a text such as '001', or 'LLR' for a map with such letters")
    letters = least_rotation(primitive(letters_of(text, finder.P.letters)))
    finder.refuse_word(text, letters)
    return spelled(letters, finder.P.letters), letters


def _one_of_each_continuum(orbits: list[Orbit]) -> tuple[list[Orbit], tuple[tuple[str, int, int], ...]]:
    """Return a list with one orbit of each continuum in place of all that were met, and how many those were.

    Orbits that a multiplier 1 lets move along a line have one word; isolated ones with a multiplier 1 are at a fold,
    where two meet.
    """
    many: dict[tuple[str, int], list[Orbit]] = {}
    for orbit in orbits:
        if orbit.admissible and orbit.degenerate:
            many.setdefault((orbit.word, orbit.period), []).append(orbit)
    families = {
        key: found for key, found in many.items() if len(found) >= FAMILY or finder_of(found[0].map).of_many(found[0])
    }
    left_out = {id(one) for found in families.values() for one in found[1:]}
    kept = [orbit for orbit in orbits if id(orbit) not in left_out]
    return kept, tuple((*key, len(found)) for key, found in families.items())


def _listing(found: list[Orbit], asked: str | None, virtual: bool) -> list[Orbit]:
    """Return the orbits to be listed, in order."""
    fitting = [orbit for orbit in found if asked is None or orbit.word == asked]
    kept = [orbit for orbit in fitting if orbit.admissible]
    return sorted(fitting if virtual or (asked is not None and not kept) else kept, key=_order)


def _checked_periods(finder: Finder, period: Any, letters: Sequence[int] | None) -> tuple[int, ...]:
    """Return the periods, each once and in order, or raise InputError."""
    if period is None:
        if letters is None:
            raise InputError("period is missing; give the number of steps, such as period=3, or word='001'")
        return (len(letters),)
    try:
        items = list(period) if isinstance(period, Iterable) and not isinstance(period, str) else [period]
    except TypeError:
        items = [period]
    found = sorted({whole(one, "period", 1) for one in items})
    if not found:
        raise InputError("period is an empty list; give whole numbers >= 1, such as range(1, 7)")
    if found[-1] > finder.longest:
        raise InputError(
            f"period = {found[-1]}; allowed are periods up to {finder.longest}: the number of orbits grows "
            "exponentially. Follow one that is known with gz.continuation, or simulate with gz.orbit_diagram"
        )
    if letters is not None:
        odd = [n for n in found if n % len(letters)]
        if odd:
            raise InputError(
                f"period = {odd[0]} for a word of {len(letters)} letters; allowed are its multiples: an orbit of "
                "twice the length goes round the word twice"
            )
    return tuple(found)


def _order(orbit: Orbit) -> tuple[Any, ...]:
    """Return what orbits are sorted by: period, word, admissible ones first, points."""
    letters = letters_of(orbit.word, orbit.map.letters)
    with np.errstate(over="ignore"):  # a virtual orbit may lie far beyond the box
        points = orbit.points / [high - low for low, high in orbit.map.box]
    return orbit.period, letters, not orbit.admissible, tuple(round(x, 9) for x in points.ravel().tolist())
