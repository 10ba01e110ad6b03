"""How far a sweep is."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from math import prod
from pathlib import Path

import numpy as np

from grazing.sweep.lock import Lock, holders
from grazing.sweep.manifest import Record
from grazing.sweep.opened import open_existing
from grazing.sweep.store import Store, folder_of
from grazing.sweep.task import time_of_work
from grazing.sweep.who import shares_of


@dataclass(frozen=True)
class Status:
    """How far a sweep is.

    Parameters
    ----------
    path : pathlib.Path
    title : str
    shape : dict of str to int
        Cells along each axis.
    chunk : dict of str to int
        Cells of a chunk along each axis.
    chunks, chunks_done : int
    cells, cells_done : int
    seconds : float
        Time of the finished chunks, over all processes.
    bytes : int
        On the disk, of the result.
    running : tuple of Lock
        Who works on it now.
    bound : bool
        Whether a manifest says what its files must hold; False for a store of version 0.1.
    damaged : int
        Finished chunks whose record is missing or not theirs. Their numbers are not read here: verify does.
    mixture : str
        Who made how many chunks, if not all were made by the code that the sweep was begun with.
    """

    path: Path
    title: str
    shape: dict[str, int]
    chunk: dict[str, int]
    chunks: int
    chunks_done: int
    cells: int
    cells_done: int
    seconds: float
    bytes: int
    running: tuple[Lock, ...]
    bound: bool = True
    damaged: int = 0
    mixture: str = ""

    @property
    def complete(self) -> bool:
        """Whether all chunks are there."""
        return self.chunks_done == self.chunks

    def __str__(self) -> str:
        share = 1.0 if not self.chunks else self.chunks_done / self.chunks
        lines = [
            f"{self.path}: {self.title}",
            f"{self.chunks_done} of {self.chunks} chunks ({share:.1%}), {self.cells_done} of {self.cells} cells",
            f"{self.seconds:.3g} s of work, {self.bytes / 1e6:.3g} MB",
        ]
        if not self.bound:
            lines.append("unbound: made by version 0.1, without a manifest; it can be read, and is not gone on with")
        if self.damaged:
            lines.append(f"damaged: the records of {self.damaged} chunks; verify the store")
        if self.mixture:
            lines.append(f"mixture: {self.mixture}")
        return "\n".join([*lines, *(f"running: {lock}" for lock in self.running)])


def status(store: str | os.PathLike[str]) -> Status:
    """Say how far a sweep is; it may be running.

    Parameters
    ----------
    store : path-like

    Returns
    -------
    Status

    Raises
    ------
    InputError
        If there is no sweep, or it is damaged.

    Examples
    --------
    >>> import tempfile, numpy as np, grazing as gz
    >>> from grazing import sweep
    >>> G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    >>> plan = gz.plans.density(G, "mu", np.linspace(0.0, 0.3, 8), starts=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     half = sweep.run(plan, f"{folder}/a.zarr", chunk=3, shard=(1, 2))
    ...     found = sweep.status(f"{folder}/a.zarr")
    >>> found.cells_done, found.cells, found.complete
    (5, 8, False)
    """
    return status_of(open_existing(folder_of(store)))


def status_of(store: Store) -> Status:
    """Say how far an open store is."""
    grid, axes = store.grid, store.layout.axes
    done = store.done()
    records: dict[int, Record | None] = {}
    for number in map(int, np.flatnonzero(done)) if store.template is not None else ():
        with suppress(OSError, ValueError):
            records[number] = store.record(number)
    shares = shares_of(store, records)
    return Status(
        store.path,
        str(store.attrs.get("title", "")),
        dict(zip(axes, grid.shape, strict=True)),
        dict(zip(axes, grid.chunk, strict=True)),
        grid.count,
        int(done.sum()),
        prod(grid.shape),
        sum(grid.size(int(number)) for number in np.flatnonzero(done)),
        time_of_work(store),
        _size(store),
        tuple(holders(store.locks)),
        store.template is not None,
        int(done.sum()) - len(records) if store.template is not None else 0,
        str(shares) if shares.mixed else "",
    )


def _size(store: Store) -> int:
    total = 0
    for folder, folders, files in os.walk(store.path):
        if Path(folder) == store.path and store.aside.name in folders:
            folders.remove(store.aside.name)
        for file in files:
            try:
                total += os.lstat(os.path.join(folder, file)).st_size
            except OSError:  # a temporary file that has got its name
                continue
    return total
