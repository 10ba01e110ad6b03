"""The plan of a study: checked input, the grid of its cells, and how some of them are computed.

A study in memory, a sweep into a store and a worker on a cluster run the same plan; they differ in which cells they
ask for and in where the numbers go.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial, wraps
from math import prod
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from grazing.copies import ByValue
from grazing.maps.map import Map
from grazing.memory import refuse_too_large
from grazing.pool import Progress as Progress
from grazing.pool import checked_progress, run_tasks, workers_of
from grazing.studies import labels
from grazing.studies.outside import with_note

if TYPE_CHECKING:
    import xarray as xr

Q = ParamSpec("Q")
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Arrays = Mapping[str, NDArray[Any]]
#: Bytes that a text takes in memory: the same few words many times over.
POINTER = 8
#: Copies of the arrays in memory where something is added when all cells are there.
FINISHED = 3


@dataclass(frozen=True, eq=False)
class Variable(ByValue):
    """What a study computes for each cell.

    Parameters
    ----------
    dims : tuple of str
        Dimensions after those of the cells.
    kind : str
        Name of a NumPy type, or ``"text"``.
    attrs : dict
        CF-style attributes.
    longest : int
        Most letters of a text.
    """

    dims: tuple[str, ...]
    kind: str
    attrs: labels.Attributes
    longest: int = 0

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the array; texts are Python objects, equal ones the same object."""
        return np.dtype(object if self.kind == "text" else self.kind)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Plan(ByValue):
    """A study before it runs.

    Parameters
    ----------
    P : Map
        The map, at the parameter values that the study does not vary.
    title : str
    config : mapping
        All that decides the numbers, as JSON can write it.
    axes : mapping of str to ndarray
        The dimensions of the cells with their values; a cell's number counts through their product, last axis fastest.
    sizes : mapping of str to int
        Sizes of the further dimensions.
    variables : mapping of str to Variable
    compute : callable
        ``compute(cells, arrays)``: an iterator that fills ``arrays[name][i]`` for the cell of number ``cells[i]`` and
        yields after every tile of work, each well under 0.2 s. What it writes depends on nothing but the cell.
    together : int
        How many cells are worth computing in one go.
    work : int
        Steps of the map that a cell takes, for estimates.
    working : int
        Bytes that a cell takes while it is computed, beside its variables.
    axis_attrs : mapping of str to dict
        Attributes of the axes.
    coords : mapping
        Further coordinates, as :class:`xarray.Dataset` takes them.
    finish : callable
        ``finish(result) -> result``: adds what is known only when all cells are there.
    finish_work : callable, optional
        ``finish_work(result)``: about how many steps of the map ``finish`` takes, which depends on the numbers.
    sequential : bool
        Whether a cell begins where its neighbour ended, so that the cells are one task.
    recipe : mapping, optional
        From which :func:`grazing.config.plan_of` makes this plan again, on another machine or another day.
    """

    P: Map
    title: str
    config: Mapping[str, Any]
    axes: Mapping[str, Floats]
    variables: Mapping[str, Variable]
    compute: Callable[[Ints, Arrays], Iterator[None]]
    together: int
    work: int
    working: int = 0
    sizes: Mapping[str, int] = field(default_factory=dict)
    axis_attrs: Mapping[str, labels.Attributes] = field(default_factory=dict)
    coords: Mapping[str, Any] = field(default_factory=dict)
    finish: Callable[[xr.Dataset], xr.Dataset] | None = None
    finish_work: Callable[[xr.Dataset], float] | None = None
    sequential: bool = False
    recipe: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        sizes = ", ".join(f"{name} ({size})" for name, size in self.sizes.items())
        refuse_too_large(self.size_of_cell + self.working, f"reduce {sizes or 'keep'}", "one cell")

    def __repr__(self) -> str:
        axes = " x ".join(f"{len(values)} {name}" for name, values in self.axes.items()) or "1 cell"
        return f"<Plan {self.title}: {axes}>"

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of cells along each axis."""
        return tuple(len(values) for values in self.axes.values())

    @property
    def cells(self) -> int:
        """Number of cells."""
        return prod(self.shape)

    @property
    def document(self) -> labels.Attributes:
        """The attributes of the whole result."""
        return labels.document(self.P, self.title, self.config)

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the dimensions of a variable."""
        return (*self.axes, *self.variables[name].dims)

    def shape_of(self, name: str) -> tuple[int, ...]:
        """Return the shape of a variable in one cell."""
        return tuple(self.sizes[dim] for dim in self.variables[name].dims)

    @property
    def size_of_cell(self) -> int:
        """Bytes that the variables of one cell take in memory."""
        return sum(
            prod(self.shape_of(name)) * (POINTER if variable.kind == "text" else variable.dtype.itemsize)
            for name, variable in self.variables.items()
        )

    def memory(self, cells: int, threads: int) -> int:
        """Return the bytes that so many cells take when they are computed in memory by so many threads at a time."""
        flying = min(cells, threads * max(1, self.together)) if not self.sequential else 1
        return cells * self.size_of_cell * (FINISHED if self.finish is not None else 1) + flying * self.working


class Planned(Protocol[Q]):
    """A study that runs a plan; made by :func:`planned`."""

    plan: Callable[..., Plan]

    def __call__(self, *args: Q.args, **kwargs: Q.kwargs) -> xr.Dataset:
        """Return the result of the plan."""


def empty_arrays(plan: Plan, cells: int) -> dict[str, NDArray[Any]]:
    """Return arrays for so many cells, to be filled by ``plan.compute``."""
    return {
        name: np.full((cells, *plan.shape_of(name)), "", object)
        if variable.kind == "text"
        else np.zeros((cells, *plan.shape_of(name)), variable.dtype)
        for name, variable in plan.variables.items()
    }


def labelled(plan: Plan, arrays: Arrays) -> xr.Dataset:
    """Return the arrays of all cells as the result of the study."""
    from grazing.late import xarray as xr

    data = {
        name: (plan.dims(name), arrays[name].reshape((*plan.shape, *plan.shape_of(name))), variable.attrs)
        for name, variable in plan.variables.items()
    }
    axes = {name: (name, values, plan.axis_attrs.get(name, {})) for name, values in plan.axes.items()}
    result = xr.Dataset(data, {**axes, **plan.coords}, plan.document)
    return with_note(result if plan.finish is None else plan.finish(result))


def run_plan(plan: Plan, threads: int | None = None, progress: Progress | None = None) -> xr.Dataset:
    """Compute all cells of a plan in memory.

    Parameters
    ----------
    plan : Plan
    threads : int, optional
        None for one per processor; the result does not depend on it.
    progress : callable, optional
        ``progress(done, total)``, called now and then with the number of finished cells.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    InputError
        For a result larger than half of the memory, or threads that are not a whole number >= 1.
    """
    axes = ", ".join(f"{name} ({len(values)})" for name, values in plan.axes.items())
    sizes = "".join(f", {name} ({size})" for name, size in plan.sizes.items())
    advice = f"reduce {axes}{sizes}, or sweep into a store: -o result.zarr, gz.sweep.run"
    workers, progress = workers_of(threads), checked_progress(progress)
    refuse_too_large(plan.memory(plan.cells, 1), advice)
    refuse_too_large(plan.memory(plan.cells, workers), f"use fewer threads ({workers}), or {advice}")
    arrays = empty_arrays(plan, plan.cells)
    step = plan.cells if plan.sequential else max(1, plan.together)

    def task(first: int) -> Iterator[None]:
        part = slice(first, min(first + step, plan.cells))
        yield from plan.compute(np.arange(part.start, part.stop), {name: array[part] for name, array in arrays.items()})

    def finished(done: int, _total: int) -> None:
        if progress is not None:
            progress(min(done * step, plan.cells), plan.cells)

    run_tasks([partial(task, first) for first in range(0, plan.cells, step)], threads, finished)
    return labelled(plan, arrays)


def planned(plan: Callable[Q, Plan]) -> Planned[Q]:
    """Return the study that a function plans: it runs the plan, with the arguments ``threads`` and ``progress``.

    Its attribute ``plan`` is the function without these two, as the number of threads changes no number.
    """
    known = inspect.signature(plan)
    alone = [item for name, item in known.parameters.items() if name not in ("threads", "progress")]
    without = known.replace(parameters=alone, return_annotation="Plan")

    @wraps(plan)
    def study(*args: Q.args, **more: Q.kwargs) -> xr.Dataset:
        made = plan(*args, **more)
        given = known.bind(*args, **more).arguments
        return run_plan(made, given.get("threads"), given.get("progress"))

    def planning(*args: Any, **more: Any) -> Plan:
        given = without.bind(*args, **more)
        return plan(**given.arguments)  # type: ignore[call-arg]

    planning.__name__ = planning.__qualname__ = "plan"
    planning.__module__, planning.__doc__ = plan.__module__, f"Return the plan of :func:`{plan.__name__}`."
    planning.__signature__ = without  # type: ignore[attr-defined]
    planning.__annotations__ = {**plan.__annotations__, "return": "Plan"}
    study.__annotations__ = {**plan.__annotations__, "return": "xr.Dataset"}
    study.__signature__ = known.replace(return_annotation="xr.Dataset")  # type: ignore[attr-defined]
    study.plan = planning  # type: ignore[attr-defined]
    return cast("Planned[Q]", study)
