"""Near-recurrences of simulated orbits: stretches of n steps that end near where they began, as guesses of orbits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.random import mixed, uniform
from grazing.maps.map import Map, swift
from grazing.memory import refuse_too_large
from grazing.outcome import FATAL

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Steps of which every stretch is looked at, from a random start on; steps that are then skipped, so that the last
#: stretch lies on what the start is attracted to.
EARLY, SETTLING = 12, 240
#: Cells per coordinate: of stretches with one word, one in each cell is tried.
CELLS = 128
#: How often the stretches are in memory: cut, put together, and those that are finite.
COPIES = 3
#: Share of the visited points on either side that does not count for the size of the region.
OUTLIERS = 0.01
#: How far the second half of the starts is drawn, in sizes of the box around its middle.
WIDE = 4.0
#: Sizes of the box from its middle beyond which an orbit runs away, though it may take long to leave the numbers.
AWAY = 1e4


class Runs(NamedTuple):
    """Simulated orbits: ``points`` (steps + 1, dim, starts) with letters (steps, starts), and how many steps in all.

    ``early`` are the first steps after the start, ``late`` those after the transient, of the starts that are ``alive``
    then; the others have left the numbers, or the box by far. ``region`` is where orbits go, see :func:`region_of`.
    """

    early: tuple[Floats, Ints]
    late: tuple[Floats, Ints]
    alive: NDArray[np.bool_]
    steps: int
    starts: int
    region: tuple[Floats, Floats]


class Window(NamedTuple):
    """Stretches of N steps: the points (k, N, dim), the letters (k, N), and how far each is from closing (k,)."""

    points: Floats
    letters: Ints
    gaps: Floats


def drawn(seed: int, lanes: int, box: Floats, cell: float) -> Floats:
    """Return random states in a box, shape (dim, lanes); a state does not depend on how many there are."""
    numbers = uniform(seed, (cell,), lanes, len(box)).T
    return np.ascontiguousarray(box[:, :1] + (box[:, 1:] - box[:, :1]) * numbers)


def refuse_many(P: Map, starts: int, longest: int) -> None:
    """Raise InputError for more starts than a search has room for: their steps, and the stretches cut from them."""
    stretches = 2 * EARLY  # of each start, early and late
    size = COPIES * 8.0 * starts * stretches * (longest + 1) * (P.dimension + 1)
    refuse_too_large(size, f"reduce starts ({starts}) or period ({longest})", "the search")


def steps_of(longest: int) -> int:
    """Return how many steps each start is flown."""
    return EARLY + SETTLING + 2 * longest + 1


def simulated(P: Map, states: Floats, longest: int, threads: int | None) -> Runs:
    """Fly the starts, shape (dim, n), a while, skip a transient, and fly on for the longest period."""
    row, lanes, P = P.packed()[1][None], states[None].copy(), swift(P)
    early = P.run_columns(row, lanes, 0, EARLY + longest, threads=threads, arithmetic="fast")
    points = np.concatenate([states[None], early.points[0]])
    late = P.run_columns(row, lanes, SETTLING, longest + 1, threads=threads, arithmetic="fast")
    with np.errstate(invalid="ignore", over="ignore"):
        middle, half = middle_of(P)
        near = (np.abs(late.points[0] - middle) <= AWAY * half).all(axis=(0, 1))
    alive = ((late.outcomes[0, 0] & FATAL) == 0) & near
    n = states.shape[1]
    steps = n * steps_of(longest)
    region = region_of(P, points[1:], late.points[0], alive)
    return Runs((points, early.letters[0]), (late.points[0], late.letters[0, 1:]), alive, steps, n, region)


def middle_of(P: Map) -> tuple[Floats, Floats]:
    """Return the middle of a map's box and half its sides, both (dim, 1)."""
    box = np.array(P.box)
    return box.mean(axis=1, keepdims=True), 0.5 * (box[:, 1:] - box[:, :1])


def region_of(P: Map, early: Floats, late: Floats, alive: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return the low and high end of each coordinate where orbits go, but for outliers; the starts do not count.

    Where all run away it is where they pass in the wider box of the starts: orbits that repel are not where others end.
    """
    middle, half = middle_of(P)
    parts = (early[:, :, alive], late[:, :, alive]) if alive.any() else (early,)
    seen = np.concatenate([np.moveaxis(part, 1, 0).reshape(part.shape[1], -1) for part in parts], axis=1)
    seen = seen[:, np.isfinite(seen).all(axis=0)]
    if not alive.any():
        seen = seen[:, (np.abs(seen - middle) <= WIDE * half).all(axis=0)]
        if seen.shape[1] < 2:
            return (middle - WIDE * half)[:, 0], (middle + WIDE * half)[:, 0]
    low, high = np.quantile(seen, OUTLIERS, axis=1), np.quantile(seen, 1.0 - OUTLIERS, axis=1)
    return low, np.maximum(high, low + 1e-9 * np.maximum(half[:, 0], np.abs(low)))


def recurrences(runs: Runs, N: int, most: int) -> Window:
    """Return at most so many stretches of N steps, the nearest to closing first, spread over words and cells.

    Of stretches whose letters are the same cyclic word, and which lie in one cell of the region, the one with the
    smallest gap is kept; words then take turns.
    """
    low, high = runs.region
    parts = [_stretches(*part, N) for part in (runs.early, runs.late)]
    points, letters = np.concatenate([one[0] for one in parts]), np.concatenate([one[1] for one in parts])
    finite = np.isfinite(points).all(axis=(1, 2))
    points, letters = points[finite], letters[finite]
    with np.errstate(over="ignore"):  # beyond all numbers is far, too
        gaps = np.abs((points[:, N] - points[:, 0]) / (high - low)).max(axis=1)
    words, turn = cyclic_keys(letters)
    at = points[np.arange(len(points)), turn]
    with np.errstate(over="ignore"):
        cells = np.clip(np.floor((at - low) / (high - low) * CELLS), -1, CELLS).astype(np.int64)
    keys = words.copy()
    for column in cells.T:
        keys = mixed(keys ^ column.astype(np.uint64))
    order = np.lexsort((gaps, keys))
    first = order[np.append(True, keys[order][1:] != keys[order][:-1])[: len(order)]]
    chosen = first[_in_turns(words[first], gaps[first])][:most]
    return Window(points[chosen, :N], letters[chosen], gaps[chosen])


def _stretches(points: Floats, letters: Ints, N: int) -> tuple[Floats, Ints]:
    """Return all stretches of N steps, points (k, N + 1, dim) and letters (k, N)."""
    steps, n = letters.shape
    count = min(EARLY, steps - N + 1)
    many = np.stack([points[j : j + N + 1] for j in range(count)]), np.stack([letters[j : j + N] for j in range(count)])
    d = points.shape[1]
    return np.moveaxis(many[0], 3, 1).reshape(count * n, N + 1, d), np.moveaxis(many[1], 2, 1).reshape(count * n, N)


def cyclic_keys(letters: Ints) -> tuple[NDArray[np.uint64], Ints]:
    """Return for each row of letters (k, N) a number that all its rotations share, and the rotation that gave it."""
    k, N = letters.shape
    codes = mixed(letters.astype(np.uint64))
    best, turn = np.full(k, np.iinfo(np.uint64).max, np.uint64), np.zeros(k, np.int64)
    for start in range(N):
        key = np.zeros(k, np.uint64)
        for j in range(N):
            key = mixed(key ^ codes[:, (start + j) % N])
        turn = np.where(key < best, start, turn)
        best = np.minimum(best, key)
    return best, turn


def _in_turns(words: NDArray[np.uint64], gaps: Floats) -> Ints:
    """Return an order in which the nearest of every word come first, then the second of every word, and so on."""
    order = np.lexsort((gaps, words))
    begins = np.append(True, words[order][1:] != words[order][:-1])[: len(order)]
    first = np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order)) - first
    return np.lexsort((gaps, rank))
