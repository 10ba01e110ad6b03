"""Periodic orbits of a map by pieces, admissible and virtual: the equations of each word, from many guesses at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.corrector import closed
from grazing.orbits.equations import ONE
from grazing.orbits.finder import Tally
from grazing.orbits.one_orbit import moved
from grazing.orbits.orbit import Orbit
from grazing.orbits.piece_equations import PieceEquations
from grazing.orbits.piece_letters import letters_from
from grazing.orbits.piece_orbit import PieceOrbit
from grazing.orbits.search_windows import drawn
from grazing.orbits.switching import turns
from grazing.orbits.word import letters_of, words

Floats = NDArray[np.float64]

#: Guesses of each word in each region, and most words of one period that are solved.
GUESSES, WORDS = 24, 200
#: Newton steps from a guess, and the part of a size by which differences move it.
STEPS, MOVED = 30, 1e-6
#: Guesses that end nearer to each other than this part of a size are polished once.
NEAR = 1e-10
#: Sizes of the box beyond which a guess has run away.
FAR = 1e6


def spelled(P: Map, period: int, letters: tuple[int, ...] | None) -> list[tuple[int, ...]]:
    """Return the letters of all words of a period, each once and the doubles of shorter ones, or of a given word.

    None where there are too many.
    """
    if letters is not None:
        return [letters * (period // len(letters))]
    symbols = str(P.letters)
    if len(symbols) ** period / period > WORDS:
        return []
    found = [one for one in words(symbols, period) if len(one) == period]
    if period % 2 == 0:
        found += [one * 2 for one in words(symbols, period // 2) if len(one) == period // 2]
    return [letters_of(one, symbols) for one in found]


def piece_orbits(
    P: Map, period: int, letters: tuple[int, ...] | None, known: list[Orbit], where: Sequence[tuple[Floats, Floats]],
    seed: int, tally: Tally,
) -> list[Orbit]:  # fmt: skip
    """Return the orbits of a period: those known from simulation, and what each word has from random guesses.

    Parameters
    ----------
    P : Map
        By pieces.
    period : int
    letters : tuple of int or None
        Of the only word that is looked for.
    known : list of Orbit
        Found on the map itself.
    where : sequence of (low, high)
        Regions in which guesses are drawn.
    seed : int
    tally : Tally
        Counts.
    """
    nothing = np.empty(0)
    found: dict[str, list[tuple[PieceEquations, Floats, Floats, PieceOrbit]]] = {}

    def add(equations: PieceEquations, x: Floats) -> None:
        solved = closed(equations, x, nothing)
        if solved is None or turns(equations, solved, nothing) > 1:
            return
        orbit = equations.orbit(solved, nothing)
        same = found.setdefault(orbit.word, [])
        off = moved(*equations.defects(solved, nothing), solved, equations.rounded(solved), equations.scale, ONE)
        if not any(alike(equations, solved, off, other, y, its) for other, y, its, _orbit in same):
            same.append((equations, solved, off, orbit))

    for orbit in known:
        own, roots = letters_from(P, orbit.points)
        equations = PieceEquations(P, (), own)
        add(equations, equations.unknowns(orbit.points, roots))
    for one in spelled(P, period, letters):
        equations = PieceEquations(P, (), one)
        boxes = [np.column_stack([np.tile(low, period), np.tile(high, period)]) for low, high in where]
        guesses = np.hstack([drawn(seed, GUESSES, box, float(period)) for box in boxes]).T
        guesses = guesses.reshape(len(guesses), period, -1)
        x = equations.begun(np.ascontiguousarray(guesses), nothing)
        x[::2, equations.at_roots] *= -1.0  # virtual orbits beyond a root
        solutions = solved_at_once(equations, x)
        tally.attempts += len(x)
        tally.converged += len(solutions)
        tally.signatures.add((period, period))
        for solution in distinct(solutions / equations.scale):
            add(equations, solution * equations.scale)
    return [orbit for same in found.values() for _equations, _x, _off, orbit in same]


def alike(equations: PieceEquations, x: Floats, off: Floats, other: PieceEquations, y: Floats, its: Floats) -> bool:
    """Whether two solutions that rounding may move so far are one, begun at another point perhaps."""
    if len(x) != len(y):
        return False
    letters, starts = other.letters, other.starts
    turned = [-int(starts[k]) for k in range(other.N) if letters[k:] + letters[:k] == equations.letters]
    return any(bool((np.abs(np.roll(y, k) - x) <= off + np.roll(its, k)).all()) for k in turned)


def solved_at_once(equations: PieceEquations, x: Floats) -> Floats:
    """Return where Newton's method leads from many guesses (k, n), those that arrive."""
    n, scale = x.shape[1], equations.scale
    none = np.empty((1, 0))

    def missed(x: Floats) -> Floats:
        return equations.missed(x, *equations.ran(x, np.broadcast_to(none, (len(x), 0))))

    done = []
    before = np.full(len(x), np.inf)
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            F = missed(x)
            J = np.empty((len(x), n, n))
            for i in range(n):
                shift = np.zeros(n)
                shift[i] = MOVED * scale[i]
                J[:, :, i] = (missed(x + shift) - missed(x - shift)) / (2.0 * shift[i])
            good = np.asarray(np.isfinite(F).all(axis=1) & np.isfinite(J).all(axis=(1, 2)))
            good[good] = np.linalg.matrix_rank(J[good] * scale / scale[:, None]) == n
            x, F, J, before = x[good], F[good], J[good], before[good]
            move = np.linalg.solve(J, F[..., None])[..., 0]
            size = np.abs(move / scale).max(axis=1)
            x = x - move
            arrived = (size <= 1e-9) & (size >= 0.25 * before) | (size <= 1e-12)
            done.append(x[arrived])
            left = ~arrived & (np.abs(x / scale) < FAR).all(axis=1)
            x, before = x[left], size[left]
            if not len(x):
                break
    return np.concatenate(done) if done else np.empty((0, n))


def distinct(x: Floats) -> Floats:
    """Return scaled solutions (k, n), those that are near to each other once."""
    kept: list[Floats] = []
    for one in x:
        if not any((np.abs(one - other) <= NEAR * (1.0 + np.abs(other))).all() for other in kept):
            kept.append(one)
    return np.array(kept).reshape(-1, x.shape[1])
