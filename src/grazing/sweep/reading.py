"""Open a store as the labelled result that the study returns in memory."""

from __future__ import annotations

import os
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.memory import refuse_too_large
from grazing.outcome import InputError
from grazing.studies.plan import POINTER, Plan
from grazing.sweep.layout import DONE, LAYOUT
from grazing.sweep.letters import decoded, restored_attrs
from grazing.sweep.same import refuse_another
from grazing.sweep.store import Store, folder_of, in_one_line, open_existing
from grazing.sweep.task import plan_from_recipe
from grazing.sweep.writers import wait_for_zarr

if TYPE_CHECKING:
    import xarray as xr

NOTE, INCOMPLETE = "grazing_note", "grazing_incomplete"


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
        ``grazing_incomplete``; numbers of missing cells are NaN or 0, texts empty.

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
    result = _dataset(found, done)
    if not done.all():
        result[DONE] = (found.layout.axes, _by_cell(found, done), {"long_name": "whether a cell has been computed"})
        result.attrs[INCOMPLETE] = f"{int((~done).sum())} of {len(done)} chunks are missing"
        return result
    if not found.layout.finish:
        return result
    if plan is None and found.recipe is None:
        result.attrs[NOTE] = "what the study adds at the end is missing: the store keeps no recipe; give the plan"
        return result
    from grazing.config.own import NotNamed

    try:
        plan = plan_from_recipe(found, code) if plan is None else plan
    except NotNamed as error:
        result.attrs[NOTE] = f"what the study adds at the end is missing: {error}"
        return result
    return result if plan.finish is None else plan.finish(result)


def _dataset(store: Store, done: NDArray[np.bool_]) -> xr.Dataset:
    import xarray as xr

    layout = store.layout
    data: dict[str, Any] = {}
    for name, kind in {**layout.variables, **layout.coords}.items():
        array = store.arrays[name]
        dims = tuple(array.metadata.dimension_names or ())
        try:
            for number in np.flatnonzero(done) if name in layout.variables else ():
                if not store.file(name, int(number)).is_file():  # Zarr would answer with its fill value
                    raise FileNotFoundError("a file is missing")
            texts = name in layout.variables and "grazing_text" in array.attrs
            values = _texts(store, name, done) if texts else np.asarray(array[...])
        except Exception as error:  # damaged bytes can fail anywhere in the reader
            wait_for_zarr()
            said = in_one_line(error)
            raise InputError(
                f"{store.path} is damaged: {name} cannot be read ({said}); sweep.verify finds where"
            ) from error
        attrs = dict(array.attrs)
        if attrs.pop("grazing_text", None) is not None:
            values, dims = values if texts else decoded(values), dims[:-1]
            values = values.astype(kind) if kind not in ("text", "object") else values
        data[name] = (dims, values, restored_attrs(attrs, name, layout.types))
    attrs = {name: value for name, value in store.attrs.items() if name not in (LAYOUT, "coordinates")}
    return xr.Dataset(
        {name: data[name] for name in layout.variables},
        {name: data[name] for name in layout.coords},
        restored_attrs(attrs, "", layout.types),
    )


def _size(store: Store, name: str) -> int:
    """Return the bytes that an array takes in memory; texts are the same few words many times over."""
    array = store.arrays[name]
    if "grazing_text" in array.attrs:
        return int(prod(array.shape[:-1])) * POINTER
    return int(prod(array.shape) * np.dtype(array.dtype).itemsize)


def _texts(store: Store, name: str, done: NDArray[np.bool_]) -> NDArray[Any]:
    """Return the words of a variable, read chunk by chunk: their letters, all together, can be many times as large."""
    values = np.full(store.arrays[name].shape[:-1], "", object)
    known: dict[str, str] = {}
    for number in np.flatnonzero(done):
        words = decoded(store.read(name, int(number)))
        values[store.grid.block(int(number))] = np.vectorize(lambda word: known.setdefault(word, word), "O")(words)
    return values


def _by_cell(store: Store, done: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which cells are done, spread from chunks."""
    grid = store.grid
    cells = np.zeros(grid.shape, bool)
    for number in np.flatnonzero(done):
        cells[grid.block(int(number))] = True
    return cells
