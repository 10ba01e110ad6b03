"""What a store holds: every array with its dimensions, chunks, type and attributes, decided before any work."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import InputError
from grazing.studies.plan import Plan
from grazing.sweep.codec import type_named
from grazing.sweep.files import is_name
from grazing.sweep.grid import Grid
from grazing.sweep.letters import TEXT, Types, encoded, stored_attrs, width_of
from grazing.sweep.manifest import MANIFEST

#: Attributes of the whole store: what this module decided, from what the plan can be made again, who began it.
LAYOUT, RECIPE, MADE_BY = "grazing_sweep", "grazing_recipe", "grazing_made_by"
#: To be raised when a store is laid out in another way. Version 0.1 wrote stores without a manifest.
FORMAT, UNBOUND = 2, 1
#: Chunks of a store: a number beyond it is a mistake, and would take hours to look at.
MOST = 10**6
DONE = "done"
#: What a result says where chunks were made by different code.
WHO = "made_by"
#: Bytes of one file beyond which an array that one chunk of cells fills is cut further.
LARGEST_FILE = 2**28


@dataclass(frozen=True)
class Spec:
    """One array of a store; ``kind`` is ``"text"`` for rows of letters, else the name of the NumPy type."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    chunk: tuple[int, ...]
    kind: str
    attrs: Mapping[str, Any]
    data: NDArray[Any] | None = None

    @property
    def dtype(self) -> str:
        """NumPy's name of what is stored."""
        return "uint8" if self.kind == "text" else self.kind


@dataclass(frozen=True)
class Layout:
    """The arrays of a store and how its cells are cut.

    ``variables`` are filled chunk by chunk, ``coords`` belong to the template. ``types`` says which attributes were
    NumPy's, ``finish`` whether the plan adds something when all cells are there.
    """

    grid: Grid
    axes: tuple[str, ...]
    variables: Mapping[str, str]
    coords: Mapping[str, str]
    types: Types
    finish: bool
    format: int = FORMAT

    def text(self) -> str:
        """Return the layout as JSON, for the attributes of the store."""
        record = {
            "format": self.format,
            "axes": self.axes,
            "shape": self.grid.shape,
            "chunk": self.grid.chunk,
            "variables": self.variables,
            "coords": self.coords,
            "types": self.types,
            "finish": self.finish,
        }
        return json.dumps(record, separators=(",", ":"))

    @classmethod
    def read(cls, text: str) -> Layout:
        """Return the layout that :meth:`text` wrote."""
        record = json.loads(text)
        if type(record["format"]) is not int or record["format"] not in (UNBOUND, FORMAT):  # true is 1
            raise InputError(
                f"it has format {record['format']}, this version reads {UNBOUND} and {FORMAT}; update grazing"
            )
        shape, chunk = (tuple(map(int, record[name])) for name in ("shape", "chunk"))
        if not len(shape) == len(chunk) == len(record["axes"]) or min((*shape, *chunk), default=1) < 0 or 0 in chunk:
            raise ValueError("its cells are not cut into chunks")
        if Grid(shape, chunk).count > MOST:
            raise ValueError(f"it has more than {MOST} chunks")
        variables, coords = dict(record["variables"]), dict(record["coords"])
        for name in [*variables, *coords]:
            if not is_name(name) or name in (DONE, MANIFEST):
                raise ValueError(f"it names an array {name!r}, which no store has")
        for kind in {*variables.values(), *coords.values()} - {"text", "object"}:
            type_named(kind, "biufcU")
        return cls(
            Grid(shape, chunk),
            tuple(map(str, record["axes"])),
            variables,
            coords,
            {str(name): str(kind) for name, kind in dict(record["types"]).items()},
            bool(record["finish"]),
            record["format"],
        )


def laid_out(plan: Plan, grid: Grid) -> tuple[Layout, dict[str, Spec]]:
    """Decide all arrays of a store.

    Raises
    ------
    InputError
        For names that the store keeps for itself.
    """
    from grazing.late import xarray as xr

    if grid.count > MOST:
        raise InputError(f"the sweep has {grid.count} chunks, a store holds {MOST}; make chunks larger")
    types: Types = {}
    specs: dict[str, Spec] = {}
    for name, variable in plan.variables.items():
        shape = (*plan.shape, *plan.shape_of(name))
        chunk = (*grid.chunk, *(max(1, size) for size in plan.shape_of(name)))
        attrs = stored_attrs(variable.attrs, name, types)
        size = np.dtype("u1" if variable.kind == "text" else variable.kind).itemsize
        specs[name] = _spec(plan.dims(name), shape, chunk, variable.kind, attrs, variable.longest, size)
    axes = {name: (name, values, plan.axis_attrs.get(name, {})) for name, values in plan.axes.items()}
    coords: dict[str, str] = {}
    for key, coord in xr.Dataset(coords={**axes, **plan.coords}).coords.items():
        name, data = str(key), np.asarray(coord.values)
        coords[name] = data.dtype.str if data.dtype.kind != "O" else "object"
        attrs = stored_attrs(coord.attrs, name, types)
        dims = tuple(str(dim) for dim in coord.dims)
        specs[name] = _coordinate(name, dims, data, attrs)
    specs[DONE] = Spec(
        tuple(f"chunk_{name}" for name in plan.axes),
        grid.counts,
        (1,) * len(grid.counts),
        "uint8",
        {"long_name": "whether a chunk is there", "flag_values": [0, 1], "flag_meanings": "missing done"},
    )
    _refuse_names(plan, coords)
    variables = {name: variable.kind for name, variable in plan.variables.items()}
    stored_attrs(plan.document, "", types)
    return Layout(grid, tuple(plan.axes), variables, coords, types, plan.finish is not None), specs


def _spec(
    dims: tuple[str, ...],
    shape: tuple[int, ...],
    chunk: tuple[int, ...],
    kind: str,
    attrs: Any,
    longest: int,
    size: int,
) -> Spec:
    """Return the array of a variable; a file of it stays below the limit even where one cell is huge."""
    if kind == "text":
        width = width_of(longest)
        dims, shape, chunk = (*dims, f"{width}_letters"), (*shape, width), (*chunk, width)
        attrs = {**attrs, TEXT: "UTF-8 letters, zeros behind the last one"}
    return Spec(dims, shape, _cut(chunk, size), kind, attrs)


def _coordinate(name: str, dims: tuple[str, ...], data: NDArray[Any], attrs: dict[str, Any]) -> Spec:
    """Return the array of a coordinate with its numbers."""
    if data.dtype.kind in "OU":
        if not all(isinstance(text, str) for text in data.ravel()):
            raise InputError(
                f"coordinate {name!r} has values that are neither numbers nor text; a store holds no others"
            )
        width = width_of(max((len(text.encode()) for text in data.ravel()), default=0))
        rows = encoded(data, width, name)
        spec = _spec(dims, data.shape, tuple(max(1, n) for n in data.shape), "text", attrs, width, 1)
        return Spec(spec.dims, spec.shape, spec.chunk, spec.kind, spec.attrs, rows)
    chunk = _cut(tuple(max(1, size) for size in data.shape), data.dtype.itemsize)
    return Spec(dims, data.shape, chunk, data.dtype.name, attrs, data)


def _cut(chunk: tuple[int, ...], size: int) -> tuple[int, ...]:
    """Halve the longest side of a file until it is below the limit."""
    sides = list(chunk)
    while sides and int(np.prod(sides, dtype=np.float64)) * size > LARGEST_FILE and max(sides) > 1:
        longest = sides.index(max(sides))
        sides[longest] = -(-sides[longest] // 2)
    return tuple(sides)


def _refuse_names(plan: Plan, coords: Mapping[str, str]) -> None:
    for name in [*plan.variables, *coords]:
        if name in (DONE, MANIFEST, WHO) or not is_name(name):
            raise InputError(
                f"a variable is named {name!r}; a store keeps 'done', 'manifest' and 'made_by' for itself, "
                f"and allows no space, no slash, no . in front and no letter that is not printed"
            )
    both = sorted(set(plan.variables) & set(coords))
    if both:
        raise InputError(f"{', '.join(both)} is both a variable and a coordinate; rename one of them")
