"""The periodic orbits of a ball on a table, word by word: what is impossible is left out, the rest solved."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.objects import ARC, DISC, DRAIN, SEGMENT
from grazing.billiard.table import AWAY, Table
from grazing.maps.map import Map
from grazing.orbits.bounce_guesses import guessed
from grazing.orbits.bounce_orbit import BounceOrbit, bounce_orbit, corrected_word, inside
from grazing.orbits.bounces import Bounces, conserves, solid_surfaces
from grazing.orbits.finder import LONGEST_WORDS, Finder, Looked, Tally, Wanted
from grazing.orbits.one_orbit import moved
from grazing.orbits.sight import gain_of, has_parallels, one_at_most, one_way, unseen
from grazing.orbits.word import least_rotation, primitive, word
from grazing.outcome import InputError

if TYPE_CHECKING:
    from grazing.orbits.periodic import Searched

Floats = NDArray[np.float64]
#: Words of surfaces of one length that are tried at most.
MOST_WORDS = 50_000
#: Guesses of a word: one where it has one orbit at most, elsewhere a share of all, within these bounds.
FEWEST, MOST = 8, 256
#: Scaled defect up to which a solution counts; solutions of which rounding is not known are one up to SAME.
CLOSED, SAME = 1e-11, 1e-8


@dataclass
class Found:
    """Orbits and what is known of words without any.

    ``impossible`` are reasons why words are, ``missing`` those of which no orbit was found although nothing forbids it,
    ``families`` those that conserve energy, of which none was given; ``single`` says that each word that was tried has
    one orbit at most.
    """

    orbits: list[BounceOrbit] = field(default_factory=list)
    impossible: dict[str, None] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    families: list[str] = field(default_factory=list)
    single: bool = True


class Words:
    """The words of a table: its surfaces, and which one can follow which."""

    def __init__(self, table: Table) -> None:
        moving = [one.name for one in table.objects if one.kind not in (DISC, SEGMENT, ARC, DRAIN)]
        if moving:
            raise InputError(f"orbits by word need objects at rest; {', '.join(moving)} may move")
        self.table = table
        self.surfaces = solid_surfaces(table)

    @cached_property
    def unseen(self) -> dict[tuple[int, int], str]:
        """Why a surface cannot follow another, by their numbers in the list; without those that can."""
        n = range(len(self.surfaces))
        said = {(i, j): unseen(self.table, self.surfaces[i], self.surfaces[j]) for i, j in product(n, n)}
        return {pair: reason for pair, reason in said.items() if reason}

    def never_next(self, a: int, b: int) -> str:
        """Say why an object cannot be hit next after another; empty if it can."""
        own = [[i for i, s in enumerate(self.surfaces) if s.owner == owner] for owner in (a, b)]
        for owner, surfaces in zip((a, b), own, strict=True):
            if not surfaces:
                return f"a ball without a radius never meets {self.table.names[owner]}"
        said = [self.unseen.get((i, j), "") for i, j in product(*own)]
        return said[0] if all(said) else ""

    def why_not(self, letters: Sequence[int]) -> str:
        """Say why no orbit has a word of objects; empty if nothing forbids it."""
        things, names = self.table.objects, self.table.names
        for one in letters:
            if one >= len(things) or things[one].kind == DRAIN:
                return f"a ball that has left through {names[one] if one < len(names) else AWAY} does not come back"
        for a, b in zip(letters, (*letters[1:], letters[0]), strict=True):
            if reason := self.never_next(a, b):
                return reason
        return one_way(self.table, letters)

    def sequences(self, n: int, letters: Sequence[int] | None) -> Iterator[tuple[int, ...]]:
        """Yield the cyclic sequences of n surfaces that nothing forbids, by their numbers in the list.

        Of their letters only those that go round a word, where one is given.
        """
        every = range(len(self.surfaces))

        def extend(front: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
            if len(front) == n:
                if (front[-1], front[0]) not in self.unseen and least_rotation(front) == front:
                    yield front
                return
            for k in every:
                if not front or (k >= front[0] and (front[-1], k) not in self.unseen):
                    yield from extend((*front, k))

        if letters is None:
            yield from extend(())
            return
        seen = set()
        spelled = tuple(letters) * (n // len(letters))
        own = [[i for i in every if self.surfaces[i].owner == owner] for owner in spelled]
        for one in product(*own):
            pairs = zip(one, (*one[1:], one[0]), strict=True)
            least = least_rotation(one)
            if least not in seen and not any(pair in self.unseen for pair in pairs):
                seen.add(least)
                yield least


def bounce_orbits(
    P: Map, periods: Sequence[int], letters: tuple[int, ...] | None, starts: int, seed: int, energy: float | None,
    tally: Tally,
) -> Found:  # fmt: skip
    """Return the periodic orbits of the map of a table from impact to impact, admissible and virtual.

    Raises
    ------
    InputError
        For a word that no orbit can have, and for too many words.
    """
    words, found = Words(P.origin.impacts_on), Found()
    table = words.table
    if letters is not None and (reason := words.why_not(letters)):
        raise InputError(f"no orbit of {P.name} has word {word(letters, P.letters)}: {reason}")
    _note_impossible(words, found)
    for n in periods:
        sequences = []
        for one in words.sequences(n, letters):
            owners = tuple(words.surfaces[k].owner for k in one)
            if one_way(table, owners):
                continue
            if one_at_most(table, owners):
                once = len(primitive(one))
                if len(one) == once * (1 + once % 2) and has_parallels([words.surfaces[k] for k in one]):
                    found.single = False
                if len(one) > once:
                    continue  # it would go round the orbit of a shorter word
            sequences.append(one)
            if len(sequences) > MOST_WORDS:
                raise InputError(
                    f"period {n} has more than {MOST_WORDS} words of sides and ends of objects; give a shorter one, or "
                    "a word"
                )
        _solve(
            P, words, sequences, max(FEWEST, min(MOST, starts // max(len(sequences), 1))), seed, energy, tally, found
        )
    return found


def _names(table: Table, owners: Sequence[int]) -> str:
    return ", ".join(sorted({table.names[owner] for owner in owners}))


def _note_impossible(words: Words, found: Found) -> None:
    """Note the pairs of objects that no orbit has, and the sets of them that give or take energy only."""
    owners = sorted({surface.owner for surface in words.surfaces})
    for a, b in product(owners, owners):
        if reason := words.never_next(a, b):
            found.impossible.setdefault(f"{words.table.names[a]} then {words.table.names[b]}: {reason}")
    gains = {owner: gain_of(words.table.objects[owner].law) for owner in owners}
    for sign in (-1, 1):
        if any(gain == sign for gain in gains.values()):
            alone = [owner for owner, gain in gains.items() if gain in (0, sign)]
            moved = [owner for owner in alone if gains[owner] == sign]
            found.impossible.setdefault(
                f"{_names(words.table, alone)} alone, one of {_names(words.table, moved)} among them: "
                f"{one_way(words.table, moved)}"
            )


def _solve(
    P: Map, words: Words, sequences: Sequence[tuple[int, ...]], many: int, seed: int, energy: float | None,
    tally: Tally, found: Found,
) -> None:  # fmt: skip
    """Solve sequences of surfaces of one length, and note which words had no solution."""
    table, solved = words.table, set[str]()
    met = dict.fromkeys(_spelled(P, words, one) for one in sequences if _primitive(words, one))
    for number, one in enumerate(sequences):
        spelled = _spelled(P, words, one)
        chosen = tuple(words.surfaces[k] for k in one)
        owners = [surface.owner for surface in chosen]
        conserved, single = conserves([table.objects[k] for k in owners]), one_at_most(table, owners)
        level = energy if energy is not None else 0.5 if table.gravity == 0.0 else None
        if conserved and level is None:
            found.families.append(spelled)
            continue
        found.single &= single
        if single and spelled in solved:
            continue
        bounces = Bounces(table, chosen, level if conserved else None)
        guesses = guessed(bounces, 1 if single else many, seed, number)
        tally.attempts += len(guesses)
        defects = bounces.solve(guesses)
        if single and not defects[0] < CLOSED:
            guesses = guessed(bounces, many, seed, number)
            tally.attempts += len(guesses)
            defects = bounces.solve(guesses)
        good = guesses[defects < CLOSED]
        tally.converged += len(good)
        tally.signatures.add((len(one), len(one)))
        for x in distinct(bounces, good):
            if inside(bounces, x):
                solved.add(spelled)
                found.orbits.append(bounce_orbit(P, *begun(bounces, x)))
    found.missing += [one for one in met if one not in solved and one not in found.families]
    found.families = list(dict.fromkeys(found.families))


def _primitive(words: Words, sequence: Sequence[int]) -> bool:
    """Whether the word of a sequence is as long as that."""
    return len(primitive([words.surfaces[k].owner for k in sequence])) == len(sequence)


def _spelled(P: Map, words: Words, sequence: Sequence[int]) -> str:
    return word([words.surfaces[k].owner for k in sequence], P.letters)


def begun(bounces: Bounces, x: Floats) -> tuple[Bounces, Floats]:
    """Return the equations and the solution begun where the word of the letters is in its least rotation."""
    owners, n = tuple(surface.owner for surface in bounces.word), bounces.n
    k = (corrected_word(owners) - 1) % n  # a letter names what is hit next
    turned = (*bounces.word[k:], *bounces.word[:k])
    return Bounces(bounces.table, turned, bounces.energy), np.concatenate([np.roll(x[:n], -k), np.roll(x[n:], -k)])


def distinct(bounces: Bounces, solutions: Floats) -> list[Floats]:
    """Return solutions (k, 2n) that differ, also when begun at another impact, and go round nothing shorter."""
    n = bounces.n
    kept: list[tuple[Floats, Floats]] = []
    numbers = [surface.number for surface in bounces.word]
    same = [k for k in range(n) if numbers[k:] + numbers[:k] == numbers]
    for x in solutions:
        off = _moved(bounces, x)
        turns = [(_turned(x, k), _turned(off, k)) for k in same]
        if any((_gap(bounces, turn, x) <= own + off).all() for turn, own in turns[1:]):
            continue
        if not any((_gap(bounces, turn, y) <= own + other).all() for turn, own in turns for y, other in kept):
            kept.append((x, off))
    return [x for x, _off in kept]


def _turned(x: Floats, k: int) -> Floats:
    """Return unknowns (2n,) begun at impact k instead."""
    n = len(x) // 2
    return np.concatenate([np.roll(x[:n], -k), np.roll(x[n:], -k)])


def _gap(bounces: Bounces, x: Floats, y: Floats) -> Floats:
    """Return by how much unknowns (2n,) differ; angles that differ by a turn are one."""
    gap = x - y
    gap[: bounces.n] -= np.where(bounces.q, 2.0 * np.pi * np.round(gap[: bounces.n] / (2.0 * np.pi)), 0.0)
    return np.abs(gap)


def _moved(bounces: Bounces, x: Floats) -> Floats:
    """Return by how much rounding may have moved a solution (2n,)."""
    n = bounces.n
    F, J = bounces.defects(x[None])
    scale = np.concatenate([bounces.scale, np.full(n, float(x[n:].mean()))])
    return moved(F[0], J[0], x, bounces.rounded(x), scale, SAME)


class Bounced(Finder):
    """Finds the orbits of a table, solved word by word."""

    longest = LONGEST_WORDS
    why = (
        "an orbit of a word is the shortest closed way from object to object in its order, and each word was solved or "
        "is impossible"
    )
    energetic = True

    def find(self, wanted: Wanted) -> Looked:
        """Return the orbits, and what is known of words without any."""
        tally = Tally()
        found = bounce_orbits(self.P, wanted.periods, wanted.letters, wanted.starts, wanted.seed, wanted.energy, tally)
        complete = found.single and not found.missing and not found.families
        said = tuple(found.impossible), tuple(found.missing), tuple(found.families)
        met = sum(not orbit.admissible for orbit in found.orbits)
        return Looked([*found.orbits], tally, met, complete, (), *said)

    def how(self, s: Searched, word: str | None, found: int) -> str:
        """Say how thoroughly words were searched."""
        said = f"found by {s.attempts} Newton attempts from guesses of each word, of which {s.converged} converged"
        said += "; words that are proven impossible were left out" if s.impossible else ""
        left_out = (s.families, "left out, as they conserve energy and none is given"), (s.missing, "without any orbit")
        for words, why in left_out:
            if words:
                said += f"; {len(words)} word{'s were' if len(words) > 1 else ' was'} {why}"
        return f"{said}; this is no proof that there are no others"
