"""Open a store as the labelled result that the study returns in memory."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.memory import refuse_too_large
from grazing.outcome import GrazingError, InputError, in_one_line, shown
from grazing.studies.outside import with_note
from grazing.studies.plan import POINTER, Plan
from grazing.sweep.codec import fill_value
from grazing.sweep.files import MISFIT
from grazing.sweep.grid import seconds_per_step
from grazing.sweep.layout import DONE, LAYOUT, MADE_BY, WHO
from grazing.sweep.letters import TEXT, decoded, restored_attrs
from grazing.sweep.manifest import Record
from grazing.sweep.opened import open_existing
from grazing.sweep.same import refuse_another
from grazing.sweep.store import Store, folder_of
from grazing.sweep.task import plan_from_recipe
from grazing.sweep.who import shares_of

if TYPE_CHECKING:
    import xarray as xr

#: Copies of letters while they become texts: as read, contiguous, and decoded.
LETTERS = 3
#: Seconds that this may take where nobody but the store asks for it.
PATIENCE = 20.0
NOTE, INCOMPLETE = "grazing_note", "grazing_incomplete"
MIXTURE, UNBOUND = "grazing_mixture", "grazing_unbound"


class Dear(InputError):
    """What a study adds would take long to find again."""


def open_store(store: str | os.PathLike[str], plan: Plan | None = None, *, code: str | None = None) -> xr.Dataset:
    """Return the result of a sweep, as the study would return it from memory.

    Parameters
    ----------
    store : path-like
    plan : Plan, optional
        For a store that keeps no recipe: what the study adds when all cells are there, such as a table of
        attractors, is added by the plan. Without it the result has an attribute ``grazing_note`` that says so.
    code : {"trust"}, optional
        Run the file of your own that the recipe names, to add the same. Without it nothing is run.

    Returns
    -------
    xarray.Dataset
        In memory, texts decoded. While chunks are missing it has a variable ``done``, by cell, and an attribute
        ``grazing_incomplete``; numbers of missing cells are NaN or 0, texts empty. If chunks were not all made by the
        code that the sweep was begun with, it has a variable ``made_by``, by cell, and an attribute
        ``grazing_mixture``; if the store has no manifest to hold it to, an attribute ``grazing_unbound``.

    Raises
    ------
    InputError
        If there is no sweep, it is damaged, the plan is another one, or the result takes more than half of the memory.

    Examples
    --------
    >>> import tempfile, numpy as np, grazing as gz
    >>> from grazing import sweep
    >>> G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    >>> plan = gz.plans.density(G, "mu", np.linspace(0.0, 0.3, 8), starts=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = sweep.run(plan, f"{folder}/a.zarr")
    ...     found = sweep.open_store(f"{folder}/a.zarr")
    >>> found.identical(gz.density(G, "mu", np.linspace(0.0, 0.3, 8), starts=3))
    True
    """
    found = open_existing(folder_of(store))
    if plan is not None:
        refuse_another(found, plan, other_code=True)  # reading mixes nothing
    names = [*found.layout.variables, *found.layout.coords]
    size = sum(_size(found, name) for name in names)
    refuse_too_large(size, f"open a part of it with xarray.open_zarr({str(found.path)!r})")
    done = found.done()
    records = _records(found, done)
    result = _dataset(found, records)
    finished = done.all() and found.layout.finish
    if finished and plan is None and found.recipe is None:
        result.attrs[NOTE] = "what the study adds at the end is missing: the store keeps no recipe; give the plan"
    elif finished:
        from grazing.config.own import NotNamed, named, refuse_unnamed

        other = ""
        try:
            if plan is None:
                refuse_unnamed(named(found.recipe or {}, code))
                _refuse_other_recipe(found)
                plan = plan_from_recipe(found, code)
                refuse_another(found, plan, other_code=True)
                _refuse_dear(plan, result)
        except NotNamed as error:
            other = str(error)
        except Dear as error:
            other = str(error)
        except GrazingError as error:
            other = f"its recipe is of another sweep ({error})"
        if other:
            result.attrs[NOTE] = f"what the study adds at the end is missing: {other}"
        elif plan is not None and plan.finish is not None:
            result = plan.finish(result)
    result = with_note(result)
    _say_who(found, records, result)
    if not done.all():
        result[DONE] = (found.layout.axes, _by_cell(found, done), {"long_name": "whether a cell has been computed"})
        result.attrs[INCOMPLETE] = f"{int((~done).sum())} of {len(done)} chunks are missing"
    return result


def _refuse_other_recipe(store: Store) -> None:
    """Raise InputError for a recipe of another study or of other sizes: to make its plan could take any time."""
    from grazing.catalogue import studies

    recipe, config = store.recipe or {}, json.loads(store.attrs["grazing_config"])
    study = studies().get(str(recipe.get("study")))
    if study is None or study.function != config.get("study") or study.plan is None or not study.takes_long:
        raise InputError(f"its study is {shown(recipe.get('study'))}")
    counts = [range_[-1].split(":")[2:3] for range_ in _ranges_in(recipe)]
    if any(count and count[0].strip().isdigit() and int(count[0][:20]) not in store.grid.shape for count in counts):
        raise InputError("other values vary in it")


def _ranges_in(recipe: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what varies in a recipe, if it is written as a range."""
    vary = recipe.get("vary")
    pairs = vary.items() if isinstance(vary, Mapping) else vary if isinstance(vary, list) else ()
    return [
        (str(pair[0]), pair[1])
        for pair in pairs
        if isinstance(pair, (list, tuple)) and len(pair) == 2 and isinstance(pair[1], str)
    ]


def _refuse_dear(plan: Plan, result: xr.Dataset) -> None:
    """Raise Dear if what the study adds takes long: to open a store that somebody made is no computation."""
    work = 0.0 if plan.finish_work is None else plan.finish_work(result)
    if work * seconds_per_step(plan) > PATIENCE:
        raise Dear(f"to find it again takes more than {PATIENCE:.0f} s; give the plan to have it")


def _records(store: Store, done: NDArray[np.bool_]) -> dict[int, Record | None]:
    """Return the records of the chunks that are there; None for each of an unbound store."""
    found: dict[int, Record | None] = {}
    for number in map(int, np.flatnonzero(done)):
        try:
            found[number] = None if store.template is None else store.record(number)
        except (OSError, ValueError) as error:
            raise _damaged(store, f"the record of chunk {number}", error) from error
    return found


def _say_who(store: Store, records: Mapping[int, Record | None], result: xr.Dataset) -> None:
    """Say in a result which cells were made by what, if not all by the code that the sweep was begun with."""
    if store.template is None:
        result.attrs[UNBOUND] = "made by version 0.1, without a manifest: chunks are not held to what was written"
        return
    shares = shares_of(store, records)
    if not shares.mixed:
        return
    who = np.full(store.grid.shape, -1, np.int32)
    for number, which in shares.who.items():
        who[store.grid.block(number)] = which
    result[WHO] = (store.layout.axes, who, shares.attrs)
    result.attrs[MIXTURE] = str(shares)


def _dataset(store: Store, records: Mapping[int, Record | None]) -> xr.Dataset:
    layout = store.layout
    texts = {name for name in store.arrays if TEXT in store.arrays[name].attrs}
    arrays = {name: (_texts if name in texts else _values)(store, name, records) for name in layout.variables}
    arrays |= {name: _coordinate(store, name, name in texts) for name in layout.coords}
    try:
        return _labelled(store, arrays)
    except MISFIT as error:  # metadata that nothing binds may say anything
        raise _damaged(store, "its metadata", error) from error


def _labelled(store: Store, arrays: Mapping[str, NDArray[Any]]) -> xr.Dataset:
    from grazing.late import xarray as xr

    layout = store.layout
    data: dict[str, Any] = {}
    for name, kind in {**layout.variables, **layout.coords}.items():
        values, dims, attrs = arrays[name], store.arrays[name].dims, dict(store.arrays[name].attrs)
        if attrs.pop(TEXT, None) is not None:
            dims = dims[:-1]
            values = values.astype(kind) if kind not in ("text", "object") else values
        data[name] = (dims, values, restored_attrs(attrs, name, layout.types))
    of_all = {name: value for name, value in store.attrs.items() if name not in (LAYOUT, MADE_BY, "coordinates")}
    return xr.Dataset(
        {name: data[name] for name in layout.variables},
        {name: data[name] for name in layout.coords},
        restored_attrs(of_all, "", layout.types),
    )


def _values(store: Store, name: str, records: Mapping[int, Record | None]) -> NDArray[Any]:
    """Return a variable, every chunk held to its record."""
    spec = store.arrays[name]
    values = np.full(spec.shape, fill_value(spec.dtype), spec.dtype)
    for number, record in records.items():
        values[store.grid.block(number)] = _chunk(store, name, number, record)
    return values


def _texts(store: Store, name: str, records: Mapping[int, Record | None]) -> NDArray[Any]:
    """Return the words of a variable, read chunk by chunk: their letters, all together, can be many times as large."""
    values = np.full(store.arrays[name].shape[:-1], "", object)
    known: dict[bytes, str] = {}
    for number, record in records.items():
        letters = _chunk(store, name, number, record)
        try:
            values[store.grid.block(number)] = decoded(letters, known)
        except (ValueError, TypeError) as error:
            raise _damaged(store, f"{name} in chunk {number}", error) from error
    return values


def _chunk(store: Store, name: str, number: int, record: Record | None) -> NDArray[Any]:
    try:
        return store.read(name, number, None if record is None else record.files)
    except (OSError, ValueError) as error:
        raise _damaged(store, f"{name} in chunk {number}", error) from error


def _coordinate(store: Store, name: str, texts: bool) -> NDArray[Any]:
    try:
        values = store.read(name, None, None if store.template is None else store.template.coordinates)
        return decoded(values) if texts else values
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise _damaged(store, name, error) from error


def _damaged(store: Store, what: str, error: Exception) -> InputError:
    return InputError(
        f"{store.path} is damaged: {what} cannot be read ({in_one_line(error)}); sweep.verify finds all that is, and "
        f"with repair=True (grazing sweep verify --repair) marks it as missing, so that resume computes it again"
    )


def _size(store: Store, name: str) -> int:
    """Return the bytes that an array takes in memory; texts are the same few words many times over."""
    spec = store.arrays[name]
    if TEXT in spec.attrs:
        letters = prod(spec.chunk) if name in store.layout.variables else prod(spec.shape)
        kind = store.layout.coords.get(name, "object")
        each = POINTER if kind in ("text", "object") else np.dtype(kind).itemsize
        return int(prod(spec.shape[:-1]) * each + LETTERS * letters)
    return int(prod(spec.shape) * np.dtype(spec.dtype).itemsize)


def _by_cell(store: Store, done: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which cells are done, spread from chunks."""
    grid = store.grid
    cells = np.zeros(grid.shape, bool)
    for number in np.flatnonzero(done):
        cells[grid.block(int(number))] = True
    return cells
