"""Tasks for the driver of columns that fly ensembles of oscillators block by block."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache, partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call
from grazing.maps.columns import CUT, LONGEST, Columns
from grazing.maps.ensemble import Setting, above_wall, ensemble, padded
from grazing.oscillator.pointed import law_kind, pointed_rows, strike_address
from grazing.oscillator.reset import Reset
from grazing.oscillator.workspace import LANES, workspace
from grazing.pool import Task

Floats = NDArray[np.float64]
#: Columns of a block at most: the tables of more no longer stay near.
COLUMNS = 28
#: A task is so many blocks at most, as long as there are so many tasks.
BLOCKS, TASKS = 8, 32


def ensemble_tasks(
    harmonics: int, law: Reset, kind: type, rows: Floats, lanes: Floats, transient: int, found: Columns,
    arithmetic: str, block: bool,
) -> list[Task]:  # fmt: skip
    """Return tasks that take the oscillators of many columns through their periods.

    Parameters
    ----------
    harmonics : int
        Of the model.
    law : Reset
        Its reset law.
    kind : type
        The named tuple of the map's parameters: those of the flight, of the law, and the phase.
    rows : ndarray, shape (columns, parameters)
    lanes : ndarray, shape (columns, 2, starts)
        The starts; overwritten with the last states.
    transient : int
    found : Columns
        To be filled.
    arithmetic : {"strict", "fast"}
    block : bool
        Whether to use the block kernel; else every period goes through the scalar routine.
    """
    rows = np.ascontiguousarray(rows)
    flat = pointed_rows(harmonics, law, kind, rows, arithmetic)
    strike = strike_address(law.law, law.name, law_kind(law), arithmetic)
    who = f"the reset law {law.name}"
    return block_tasks(
        above_wall(harmonics), harmonics, flat, rows, (strike, strike), lanes, transient, found, arithmetic, block, who
    )


def block_tasks(
    setting: Setting, harmonics: int, rows: Floats, source: Floats, strikes: tuple[float, float], lanes: Floats,
    transient: int, found: Columns, arithmetic: str, block: bool, who: str,
) -> list[Task]:  # fmt: skip
    """Return tasks as :func:`ensemble_tasks` does, in any setting.

    Parameters
    ----------
    setting, harmonics, arithmetic
        See :func:`ensemble`.
    rows, strikes
        See :func:`ensemble`; shape (columns, numbers).
    source : ndarray
        What rows point to: it must live as long as the tasks.
    lanes, transient, found, block
        See :func:`ensemble_tasks`.
    who : str
        Who is to blame if a law does not compile.
    """
    flat, walls = rows.ravel(), setting.walls
    entry = ensemble(setting, harmonics, arithmetic)
    starts, keep = lanes.shape[2], found.points.shape[1]
    wide = min(starts, LANES // walls)
    stride = padded(wide)
    several = min(LANES // (walls * stride), COLUMNS // walls, len(rows))
    # a few blocks a task, for what a task costs, but many tasks, for threads
    together = several * min(max(len(rows) // (several * TASKS), 1), BLOCKS)
    spare = single(setting, harmonics) if len(rows) == 1 else []  # workspaces that no task is using
    pace = [1]  # so many blocks may be a tile: more where tiles turn out to be short; the bits do not depend on it

    def task(source: Floats, top: int, left: int) -> Iterator[None]:  # flat points to the source
        bottom = min(top + together, len(rows))
        try:
            space = spare.pop()
        except IndexError:  # asked first, another thread might take the last one in between
            space = workspace(harmonics, walls * several)
        while top < bottom:
            blocks, first = pace[0], top
            top = min(top + several * blocks, bottom)
            box = first, top, several, stride, left, min(left + wide, starts)
            for n in range(0, max(transient + keep, 1), CUT):
                end = min(n + CUT, transient + keep)
                passed = max(0, min(end, transient) - n)
                job = (
                    *box, int(block), passed, max(n - transient, 0), max(end - transient, 0),
                )  # fmt: skip
                before = perf_counter()
                call(entry, flat, strikes, job, *space, lanes, *found, who=who)
                spent = perf_counter() - before
                yield
            pace[0] = paced(blocks, spent)
        spare.append(space)

    return [partial(task, source, q, i) for q in range(0, len(rows), together) for i in range(0, starts, wide)]


@lru_cache(maxsize=16)
def single(setting: Setting, harmonics: int) -> list[tuple[Any, ...]]:
    """Return the workspaces for one column that are not in use: single orbits are asked for by the thousand."""
    return []


def paced(blocks: int, spent: float) -> int:
    """Return how many blocks the next tile may have, after one of so many took so many seconds."""
    if spent < 0.25 * LONGEST:
        return min(2 * blocks, BLOCKS)
    return max(blocks // 2, 1) if spent > 0.5 * LONGEST else blocks
