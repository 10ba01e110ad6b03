"""All periodic orbits of a map that a search finds, stable and unstable, and how thoroughly it searched."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from grazing.maps.hits import Hits
from grazing.maps.map import Map
from grazing.orbits.contacts import model_of, section_of
from grazing.orbits.gap_orbits import gap_orbits
from grazing.orbits.orbit import Orbit
from grazing.orbits.search_bounces import ONE_EACH, bounce_orbits, how_thorough
from grazing.orbits.search_impacts import Tally
from grazing.orbits.search_map import Cycles
from grazing.orbits.search_pieces import piece_orbits, spelled
from grazing.orbits.search_rest import resting_orbits
from grazing.orbits.search_section import AIMED, Search, aimed_guesses, orbits_of, solutions_of
from grazing.orbits.search_windows import WIDE, drawn, middle_of, recurrences, refuse_many, simulated
from grazing.orbits.search_words import checked_word
from grazing.orbits.word import least_rotation, letters_of
from grazing.outcome import InputError, listed, shown
from grazing.parameter import real, whole

#: Longest period of a search; of one that solves each word, of which there are 2^period/period.
LONGEST, LONGEST_WORDS = 64, 20
#: Most impacts of a word that is looked for.
MOST_IMPACTS = 200
#: Orbits of one word and period with a multiplier 1 that are a continuum: at a fold two orbits meet.
FAMILY = 3
#: Random guesses of a period of a map that is no section of an oscillator.
GUESSES = 500


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
        said = f"{_counted(len(kept), 'orbit')} {which}of least period {_listed(s.periods)}, {stable} stable"
        said += (f", {neutral} neutral" if neutral else "") + f" and {len(kept) - stable - neutral} unstable"
        said += f", and {_counted(virtual, 'virtual one')}" if virtual else ""
        for spelled_as, N, many in s.continua:
            met = f"{many} with a multiplier 1 were met, one listed" if many > 1 else "the one in the middle is listed"
            said += f" (of word {spelled_as} and period {N} a continuum: {met})"
        if s.turned:
            said += f" (the same impacts in the same order, but another one first after the strobe: {listed(s.turned)})"
        tables = self.map.origin.impacts_on is not None
        if s.complete:
            why = ONE_EACH if tables else "every word of the length is solved by algebra"
            return f"{said}: these are all, because {why}"
        if tables:
            return f"{said}: {how_thorough(s)}"
        how = (
            f"{said}: found by {_counted(s.attempts, 'Newton attempt')}, of which {s.converged} converged, from "
            f"near-recurrences of {_counted(s.starts, 'random start')} in {_counted(s.steps, 'step')} and other guesses"
        )
        if self.map.formulas is not None:
            asked = letters_of(self.word, self.map.letters) if self.word is not None else None
            solved = [n for n in s.periods if spelled(self.map, n, asked)]
            which = "the word" if asked else "each word of the length" if len(solved) == len(s.periods) else ""
            which = which or (f"each word of period {_listed(tuple(solved))}" if solved else "")
            how += f", with the pieces of {which} beyond the border too" if which else ""
        if model_of(self.map) is not None and s.signatures:
            how += f", with up to {max(n for n, _N in s.signatures)} impacts"
            letters = letters_of(self.word, self.map.letters) if self.word is not None else ()
            impacts = max((n * impacts_in(self.map, letters) // max(len(letters), 1) for n in s.periods), default=0)
            if section_of(self.map) == "strobe" and aimed_guesses(impacts) < AIMED:
                how += f", {aimed_guesses(impacts)} random guesses of the word instead of {AIMED}, as each costs "
                how += f"the cube of its {impacts} impacts"
        if len(self) == 0:
            return f"{how}; more starts, another seed or virtual=True may find some, and others may exist"
        return f"{how}; this is no proof that there are no others"


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
    statement says how many were met.

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
    if energy is not None:
        if P.origin.impacts_on is None:
            raise InputError(
                f"energy is {shown(energy)}; only orbits of a table that conserve it come in families by it"
            )
        energy = real(energy, "energy", "give a finite value")
    asked, letters = checked_word(P, word)
    periods = _checked_periods(P, period, letters)
    strobe = letters is not None and section_of(P) == "strobe"
    impacts = impacts_in(P, letters) * periods[-1] // len(letters) if strobe else 0  # type: ignore[arg-type]
    if impacts > MOST_IMPACTS:
        raise InputError(
            f"word {shown(word)} and period {periods[-1]} have {impacts} impacts; allowed are {MOST_IMPACTS}: the "
            "search costs the cube of them. Simulate with gz.orbit_diagram; complete chatter is the letter C"
        )
    solved = P.origin.orbits is not None  # word by word, by algebra
    tally, met = Tally(), 0
    if P.origin.impacts_on is not None:
        return _bounced(P, periods, asked, letters, virtual, energy, starts, seed)
    if not solved:
        refuse_many(P, starts, periods[-1])
    if solved:
        found = [orbit for n in periods for orbit in gap_orbits(P, n)]
        tally.signatures.update((n, n) for n in periods)
        met = sum(not orbit.admissible for orbit in found)
    elif (model := model_of(P)) is not None:
        search = Search(P, model, periods, starts, seed, threads, letters)
        solutions = solutions_of(search, tally)
        found, met = orbits_of(search, solutions, virtual)
        found += [orbit for orbit in resting_orbits(P, periods[-1]) if orbit.period in periods]
        if asked is not None and not any(orbit.admissible and orbit.word == asked for orbit in found):
            found, met = orbits_of(search, solutions, virtual=True)
    else:
        found = _mapped(P, periods, starts, seed, threads, tally, letters)
        met = sum(not orbit.admissible for orbit in found)
    listing, continua = _one_of_each_continuum(_listing(found, asked, virtual))
    signatures, turned = tuple(sorted(tally.signatures)), _turned(found, asked) if strobe else ()
    searched = Searched(
        periods, tally.starts, tally.steps, tally.attempts, tally.converged, signatures, met, solved, seed, continua,
        turned,
    )  # fmt: skip
    return Orbits(listing, P, asked, searched)


def _bounced(
    P: Map, periods: tuple[int, ...], asked: str | None, letters: tuple[int, ...] | None, virtual: bool,
    energy: float | None, starts: int, seed: int,
) -> Orbits:  # fmt: skip
    """Return the orbits of the map of a table from impact to impact, solved word by word."""
    tally = Tally()
    found = bounce_orbits(P, periods, letters, starts, seed, energy, tally)
    listing, continua = _one_of_each_continuum(_listing(list(found.orbits), asked, virtual))
    met = sum(not orbit.admissible for orbit in found.orbits)
    signatures, complete = tuple(sorted(tally.signatures)), found.single and not found.missing and not found.families
    said = tuple(found.impossible), tuple(found.missing), tuple(found.families)
    searched = Searched(
        periods, 0, 0, tally.attempts, tally.converged, signatures, met, complete, seed, continua, (), *said
    )  # fmt: skip
    return Orbits(listing, P, asked, searched)


def _one_of_each_continuum(orbits: list[Orbit]) -> tuple[list[Orbit], tuple[tuple[str, int, int], ...]]:
    """Return a list with one orbit of each continuum in place of all that were met, and how many those were.

    Orbits that a multiplier 1 lets move along a line have one word; isolated ones with a multiplier 1 are at a fold,
    where two meet.
    """
    many: dict[tuple[str, int], list[Orbit]] = {}
    for orbit in orbits:
        if orbit.admissible and orbit.degenerate:
            many.setdefault((orbit.word, orbit.period), []).append(orbit)
    families = {key: found for key, found in many.items() if len(found) >= FAMILY or _flies(found[0])}
    left_out = {id(one) for found in families.values() for one in found[1:]}
    kept = [orbit for orbit in orbits if id(orbit) not in left_out]
    return kept, tuple((*key, len(found)) for key, found in families.items())


def _flies(orbit: Orbit) -> bool:
    """Whether an orbit of an oscillator is a flight without impacts."""
    P = orbit.map
    return section_of(P) == "strobe" and impacts_in(P, letters_of(orbit.word, P.letters)) == 0


def impacts_in(P: Map, letters: Sequence[int]) -> int:
    """Return how many impacts a word of a stroboscopic map has; one that rests counts as one, as it is no sequence."""
    if isinstance(P.letters, Hits):
        return sum(len(P.letters.walls(letter)) for letter in letters)
    return sum(map(abs, letters))


def _turned(found: list[Orbit], asked: str | None) -> tuple[str, ...]:
    """Return the words of admissible orbits that would have the word asked for, were the strobe at another time."""
    kept = [orbit for orbit in found if orbit.admissible]
    if asked is None or any(orbit.word == asked for orbit in kept):
        return ()
    around = {orbit.word: _around(orbit, orbit.word) for orbit in kept}
    return tuple(sorted({one.word for one in kept if around[one.word] and around[one.word] == _around(one, asked)}))


def _around(orbit: Orbit, text: str) -> tuple[int, ...]:
    """Return the walls that an orbit would hit in its period if it had a word, least rotation; none for other maps."""
    symbols = orbit.map.letters
    letters = letters_of(text, symbols)
    if not isinstance(symbols, Hits) or min(letters) < 0:
        return ()
    walls = [wall for letter in letters for wall in symbols.walls(letter)] * (orbit.period // len(letters))
    return least_rotation(walls) if walls else ()


def _listing(found: list[Orbit], asked: str | None, virtual: bool) -> list[Orbit]:
    """Return the orbits to be listed, in order."""
    fitting = [orbit for orbit in found if asked is None or orbit.word == asked]
    kept = [orbit for orbit in fitting if orbit.admissible]
    return sorted(fitting if virtual or (asked is not None and not kept) else kept, key=_order)


def _mapped(
    P: Map, periods: tuple[int, ...], starts: int, seed: int, threads: int | None, tally: Tally,
    letters: tuple[int, ...] | None,
) -> list[Orbit]:  # fmt: skip
    """Return the orbits of a map that is no section of an oscillator."""
    box, (middle, half) = np.array(P.box), middle_of(P)
    wide = np.hstack([middle - WIDE * half, middle + WIDE * half])
    many = starts // 2
    states = np.hstack([drawn(seed, starts - many, box, 0.0), drawn(seed, many, wide, 1.0)])
    runs = simulated(P, states, periods[-1], threads)
    tally.starts, tally.steps = runs.starts, runs.steps
    cycles, (low, high) = Cycles(P, tally), runs.region
    for n in periods:
        cycles.add(recurrences(runs, n, starts).points)
        cycles.at_random(n, low, high, GUESSES, seed)
    if P.formulas is None:
        return [orbit for n in periods for orbit in cycles.orbits(n)]
    where = low, high
    return [one for n in periods for one in piece_orbits(P, n, letters, cycles.orbits(n), where, seed, tally)]


def _checked_periods(P: Map, period: Any, letters: Sequence[int] | None) -> tuple[int, ...]:
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
    longest = LONGEST if P.origin.orbits is None and P.origin.impacts_on is None else LONGEST_WORDS
    if not found:
        raise InputError("period is an empty list; give whole numbers >= 1, such as range(1, 7)")
    if found[-1] > longest:
        raise InputError(
            f"period = {found[-1]}; allowed are periods up to {longest}: the number of orbits grows exponentially. "
            "Follow one that is known with gz.continuation, or simulate with gz.orbit_diagram"
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
    points = orbit.points / [high - low for low, high in orbit.map.box]
    return orbit.period, letters, not orbit.admissible, tuple(np.round(points, 9).ravel())


def _counted(n: int, what: str) -> str:
    return f"{n} {what}" if n == 1 else f"{n} {what}s"


def _listed(periods: tuple[int, ...]) -> str:
    if len(periods) > 2 and periods[-1] - periods[0] == len(periods) - 1:
        return f"{periods[0]} to {periods[-1]}"
    return listed(map(str, periods))
