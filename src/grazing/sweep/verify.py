"""Hold a store to its plan: read every chunk, compute some of them again and compare the bits."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, fields
from functools import partial
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import GrazingError, InputError, in_one_line, listed, shown
from grazing.parameter import real, whole
from grazing.pool import run_tasks
from grazing.studies.plan import Plan, Progress, empty_arrays
from grazing.sweep.grid import checked_plan
from grazing.sweep.layout import LAYOUT, MADE_BY, RECIPE, laid_out
from grazing.sweep.letters import stored_attrs
from grazing.sweep.lock import locked
from grazing.sweep.made_by import made_by
from grazing.sweep.manifest import MANIFEST
from grazing.sweep.mend import forget_chunks, mend_coordinates, mend_metadata
from grazing.sweep.opened import open_existing
from grazing.sweep.same import refuse_another
from grazing.sweep.store import ASIDE, Store, folder_of, stored_chunk
from grazing.sweep.task import computed, plan_from_recipe
from grazing.sweep.template import attrs_of_all

#: What a difference names where the record of a chunk is at fault.
RECORD = "record"
_NONE = object()


@dataclass(frozen=True)
class Difference:
    """A variable that is not what the plan says in a chunk (None for all of it): which cells, or why unreadable."""

    variable: str
    chunk: int | None
    cells: tuple[int, ...]
    where: str
    reason: str

    def __repr__(self) -> str:
        return f"<Difference: {self}; {len(self.cells)} cells>"

    def __str__(self) -> str:
        place = "" if self.chunk is None else f" in chunk {self.chunk} ({self.where})"
        return f"{self.variable}{place}: {self.reason}"


@dataclass(frozen=True)
class Verified:
    """What a verification found.

    Parameters
    ----------
    read : int
        Chunks that were read whole, which checks their checksums: all that are done.
    computed : tuple of int
        Chunks that were computed again and compared bit by bit.
    differences : tuple of Difference
    repaired : bool
        Whether the chunks with differences now count as missing.
    missing : tuple of int
        Those chunks.
    path : pathlib.Path
        The store.
    mended : tuple of str
        Files of metadata and coordinates that were put back, or removed.
    """

    read: int
    computed: tuple[int, ...]
    differences: tuple[Difference, ...]
    repaired: bool
    missing: tuple[int, ...]
    path: Path
    mended: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Verified({', '.join(f'{one.name}={shown(getattr(self, one.name))}' for one in fields(self))})"

    @property
    def ok(self) -> bool:
        """Whether everything agrees."""
        return not self.differences and not self.mended

    def __str__(self) -> str:
        said = f"{len(self.differences)} differences" if self.differences else "no difference"
        first = f"{self.read} chunks read, {len(self.computed)} of them computed again: {said}"
        return "\n".join([first, *map(str, self.differences), *self._done_about_it()])

    def _done_about_it(self) -> Iterator[str]:
        """Yield what was repaired, and what cannot be."""
        if self.mended:
            yield f"repaired: {', '.join(self.mended)}"
        if self.missing:
            which = f"{len(self.missing)} chunk{'' if len(self.missing) == 1 else 's'}"
            yield f"repaired: {which} marked as missing ({', '.join(map(str, self.missing))}); resume {self.path}"


def verify(
    store: str | os.PathLike[str],
    share: float = 0.01,
    seed: int = 0,
    plan: Plan | None = None,
    *,
    repair: bool = False,
    other_code: bool = False,
    threads: int | None = None,
    progress: Progress | None = None,
    code: str | None = None,
) -> Verified:
    """Hold a store to its manifest and its plan.

    Metadata, coordinates and every finished chunk are held to what was written there, which tells what a disk or a
    hand has changed, exchanged or put back. Coordinates, units and all other attributes are held to the plan. A random
    share of the chunks is computed again and compared bit by bit, which also tells a wrong computation.

    Parameters
    ----------
    store : path-like
    share : float
        Of the finished chunks, 0 <= share <= 1; at least one.
    seed : int
        Which of them.
    plan : Plan, optional
        Needed if the store keeps no recipe.
    repair : bool
        Put metadata back from the manifest, and coordinates from the plan; count the chunks with differences as
        missing, so that :func:`resume` computes them again. A manifest whose own template is damaged is made again
        from the metadata, or from the plan if it is given.
    other_code : bool
        Compare although the step, or this package, is not the one that the store was begun with.
    threads, progress
        See :func:`run`.
    code : {"trust"}, optional
        Run the file of your own that the recipe names. Without it, and without a plan, such a store is refused.

    Returns
    -------
    Verified

    Raises
    ------
    InputError
        If there is no sweep or another one, the plan is missing, or metadata are damaged and not to be repaired.

    Examples
    --------
    >>> import tempfile, numpy as np, grazing as gz
    >>> from grazing import sweep
    >>> G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    >>> plan = gz.plans.density(G, "mu", np.linspace(0.0, 0.3, 8), starts=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = sweep.run(plan, f"{folder}/a.zarr", chunk=2)
    ...     print(sweep.verify(f"{folder}/a.zarr", share=0.5, plan=plan))
    4 chunks read, 2 of them computed again: no difference
    """
    share = real(share, "share", "allowed is 0 <= share <= 1")
    if not 0.0 <= share <= 1.0:
        raise InputError(f"share = {share:g}; allowed is 0 <= share <= 1")
    seed = whole(seed, "seed", 0)
    path = folder_of(store)
    if plan is not None:
        checked_plan(plan)
    ours = any(os.path.isdir(path / name) for name in (ASIDE, MANIFEST))
    with locked(path / ASIDE / "locks", None) if repair and ours else nullcontext():
        mended = mend_metadata(path, plan) if repair else []
        found = open_existing(path)
        if repair and found.template is None:
            raise InputError(f"{path} has no manifest to repair it from: version 0.1 wrote none; begin another store")
        plan = plan_from_recipe(found, code) if plan is None else plan
        refuse_another(found, plan, other_code=other_code)
        done = np.flatnonzero(found.done())
        count = min(len(done), max(1, ceil(share * len(done))))
        chosen = np.sort(np.random.default_rng(seed).choice(done, count, replace=False)) if count else done
        coordinates = list(_coordinates(found, plan))
        differences = [*coordinates, *_attributes(found, plan), *_recipe(found, plan)]
        tasks = [
            partial(_check, plan, found, int(number), bool(again), differences)
            for number, again in zip(done, np.isin(done, chosen), strict=True)
        ]
        run_tasks(tasks, threads, progress)
        differences.sort(key=lambda one: (-1 if one.chunk is None else one.chunk, one.variable))
        bad = sorted({one.chunk for one in differences if one.chunk is not None}) if repair else []
        if bad:
            found.unseal()
        if repair:
            forget_chunks(found, sorted({*range(found.grid.count)} - {*done.tolist()} | {*bad}))
            mended += mend_coordinates(found, plan, sorted({one.variable for one in coordinates}))
            found.seal_if_complete()
    return Verified(
        len(done), tuple(map(int, chosen)), tuple(differences), repair, tuple(bad), found.path, tuple(mended)
    )


def _check(plan: Plan, store: Store, number: int, again: bool, differences: list[Difference]) -> Iterator[None]:
    """Read a chunk; if asked, compute it again and compare."""
    block = zip(store.layout.axes, store.grid.block(number), strict=True)
    where = ", ".join(f"{name} {part.start} to {part.stop - 1}" for name, part in block)
    all_cells = tuple(map(int, store.grid.cells(number)))
    there: dict[str, NDArray[Any]] = {}
    try:
        files = None if store.template is None else store.record(number).files
    except (OSError, ValueError) as error:
        differences.append(Difference(RECORD, number, all_cells, where, f"cannot be used: {in_one_line(error)}"))
        return
    for name in store.layout.variables:
        try:
            there[name] = store.read(name, number, files)
        except (OSError, ValueError) as error:
            differences.append(Difference(name, number, all_cells, where, f"cannot be read: {in_one_line(error)}"))
    yield
    if not again:
        return
    arrays = empty_arrays(plan, store.grid.size(number))
    yield from computed(plan, store, number, arrays)
    for name, here in stored_chunk(plan, store.grid.block_shape(number), arrays).items():
        if name in there:
            wrong = store.grid.cells(number)[_unequal(there[name], here, store.grid.size(number))]
            if len(wrong):
                reason = f"{len(wrong)} of {store.grid.size(number)} cells differ from what is computed"
                differences.append(Difference(name, number, tuple(map(int, wrong)), where, reason))


def _unequal(one: NDArray[Any], other: NDArray[Any], cells: int) -> NDArray[np.bool_]:
    """Return which cells differ in any bit; NaN equals the same NaN, and 0 is not -0."""
    bits = (np.ascontiguousarray(array).reshape(cells, -1).view(np.uint8) for array in (one, other))
    return np.asarray((next(bits) != next(bits)).any(axis=1))


def _attributes(store: Store, plan: Plan) -> Iterator[Difference]:
    """Compare what is said of the whole and of each array, such as units: no record of a chunk holds it.

    Other code may say it in other words, and whoever has allowed it knows.
    """
    here = made_by(plan)
    if any(here.get(key) != value for key, value in store.begun_by.items()):
        return
    layout, specs = laid_out(plan, store.grid)
    of_all = attrs_of_all(plan, layout) if store.template else stored_attrs(plan.document, "", {})
    pairs: dict[str, tuple[Mapping[str, Any], Mapping[str, Any]]] = {"zarr.json": (of_all, store.attrs)}
    pairs |= {name: (spec.attrs, store.arrays[name].attrs) for name, spec in specs.items()}
    for name, (wanted, there) in pairs.items():
        own = {RECIPE, LAYOUT} if name == "zarr.json" else set()
        own |= {MADE_BY, "coordinates"} if store.template is None else set()
        wrong = [key for key in sorted({*wanted, *there} - own) if wanted.get(key, _NONE) != there.get(key, _NONE)]
        if wrong:
            reason = f"its attributes {listed(wrong, 8)} are not those of the plan; begin another store"
            yield Difference(name, None, (), "", reason)


def _recipe(store: Store, plan: Plan) -> Iterator[Difference]:
    """Make the plan of the recipe, which says by what command a result is made again; code that it names is not run."""
    from grazing.config.own import NotNamed

    try:
        if store.recipe is not None and store.recipe != plan.recipe:
            refuse_another(store, plan_from_recipe(store), other_code=True)
    except NotNamed:
        return
    except GrazingError as error:
        yield Difference("zarr.json", None, (), "", f"its recipe is of another sweep ({error}); begin another store")


def _coordinates(store: Store, plan: Plan) -> Iterator[Difference]:
    """Compare the coordinates, which are small."""
    prints = None if store.template is None else store.template.coordinates
    for name, spec in laid_out(plan, store.grid)[1].items():
        if spec.data is None:
            continue
        try:
            there = store.read(name, None, prints)
            if there.tobytes() != np.ascontiguousarray(spec.data).tobytes():
                yield Difference(name, None, (), "", "its values are not those of the plan")
        except (OSError, ValueError, KeyError) as error:
            yield Difference(name, None, (), "", f"cannot be read: {in_one_line(error)}")
