"""How the cells of a plan are cut into chunks, rectangular blocks that are computed and stored as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, prod

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import InputError, shown
from grazing.parameter import whole
from grazing.studies.plan import Plan

Ints = NDArray[np.int64]
#: What may be said of a chunk: cells in it, cells along some axes, or nothing.
Chunk = int | Mapping[str, int] | None

#: Seconds that a step takes, for choosing only: a map that is a formula; many flights at once, exponents being dearer
#: than counts; one flight after another.
FORMULA, BLOCK, FLIGHT = 10e-9, 300e-9, 1500e-9
#: Seconds that a chunk should take; a short sweep is cut into about so many pieces.
LONG, PIECES = 4.0, 24
#: Bytes of a chunk, all variables together, that are not exceeded unless one cell does.
LARGEST = 2**26


@dataclass(frozen=True)
class Grid:
    """The chunks of a grid of cells.

    Parameters
    ----------
    shape : tuple of int
        Cells along each axis.
    chunk : tuple of int
        Cells of a chunk along each axis; the last chunk of an axis may be shorter.

    Examples
    --------
    >>> grid = Grid((7, 2), (3, 2))
    >>> grid.counts, grid.block(2), grid.cells(2).tolist()
    ((3, 1), (slice(6, 7, None), slice(0, 2, None)), [12, 13])
    """

    shape: tuple[int, ...]
    chunk: tuple[int, ...]

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Number of chunks along each axis."""
        return tuple(ceil(length / size) for length, size in zip(self.shape, self.chunk, strict=True))

    @property
    def count(self) -> int:
        """Number of chunks."""
        return prod(self.counts)

    def place(self, number: int) -> tuple[int, ...]:
        """Return where a chunk stands among the chunks, by axis."""
        place: tuple[int, ...] = ()
        for count in reversed(self.counts):
            number, i = divmod(number, count)
            place = (i, *place)
        return place

    def block(self, number: int) -> tuple[slice, ...]:
        """Return the cells of a chunk, by axis."""
        place = zip(self.place(number), self.chunk, self.shape, strict=True)
        return tuple(slice(i * size, min((i + 1) * size, length)) for i, size, length in place)

    def block_shape(self, number: int) -> tuple[int, ...]:
        """Return the number of cells of a chunk, by axis."""
        return tuple(part.stop - part.start for part in self.block(number))

    def size(self, number: int) -> int:
        """Return the number of cells of a chunk."""
        return prod(self.block_shape(number))

    def cells(self, number: int) -> Ints:
        """Return the numbers of the cells of a chunk, last axis fastest."""
        if not self.shape:
            return np.zeros(1, np.int64)
        axes = np.ix_(*(np.arange(part.start, part.stop) for part in self.block(number)))
        return np.ravel_multi_index(axes, self.shape).astype(np.int64).ravel()


def checked_plan(plan: object) -> Plan:
    """Return a plan that can be cut into chunks, or raise InputError."""
    if not isinstance(plan, Plan):
        raise InputError(f"plan is {shown(plan)}; give one of gz.plans, such as gz.plans.density(...)")
    if plan.sequential:
        raise InputError(
            f"{plan.title!r} cannot be swept in chunks: each of its cells begins where its neighbour ended. "
            f"Compute it in memory, or choose starts that do not follow the attractor"
        )
    return plan


def grid_of(plan: Plan, chunk: Chunk = None) -> Grid:
    """Cut the cells of a plan.

    Parameters
    ----------
    plan : Plan
    chunk : int or mapping of str to int, optional
        Cells in a chunk, or cells along some of the axes (all of them along the others). None for chunks of a few
        seconds; the same plan then always gets the same chunks, so that shards that start together agree.

    Raises
    ------
    InputError
        For a chunk that is not a whole number >= 1, or an axis that the plan does not have.
    """
    if isinstance(chunk, Mapping):
        for name in chunk:
            if name not in plan.axes:
                raise InputError(f"chunk names {name!r}; the axes of this sweep are {', '.join(plan.axes)}")
        sizes = {name: whole(size, f"chunk[{name!r}]", 1) for name, size in chunk.items()}
        pairs = zip(plan.axes, plan.shape, strict=True)
        return Grid(plan.shape, tuple(max(1, min(sizes.get(name, length), length)) for name, length in pairs))
    return Grid(plan.shape, _block(plan.shape, _worthwhile(plan) if chunk is None else whole(chunk, "chunk", 1)))


def _worthwhile(plan: Plan) -> int:
    """Return a number of cells that take a few seconds and fit into memory."""
    cost = max(plan.work, 1) * seconds_per_step(plan)
    seconds = min(LONG, plan.cells * cost / PIECES)
    together = max(1, plan.together)
    wanted = max(1, round(seconds / cost / together)) * together
    return max(1, min(wanted, LARGEST // max(plan.size_of_cell, 1)))


def seconds_per_step(plan: Plan) -> float:
    """Return the seconds that a step takes, by a rule of thumb."""
    if plan.P.prepare is None:
        return FORMULA
    return FLIGHT if plan.P.origin.block is None or plan.config.get("arithmetic") == "strict" else BLOCK


def _block(shape: Sequence[int], cells: int) -> tuple[int, ...]:
    """Return a block of at most so many cells, long in the last axes; equal blocks rather than a last small one."""
    chunk: list[int] = []
    for length in reversed(shape):
        size = max(1, min(length, cells))
        size = ceil(length / ceil(length / size)) if length else 1
        chunk.append(size)
        cells = max(1, cells // size)
    return tuple(reversed(chunk))
