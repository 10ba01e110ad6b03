"""The orbits of a study: parameter values, starts and lengths, checked once and shared by all studies of ensembles."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import FLAGS
from grazing.maps.columns import Columns
from grazing.maps.ensemble import padded
from grazing.maps.map import Map
from grazing.maps.pieces import joined, let_go, pieces, steps_of_piece
from grazing.memory import refuse_too_large
from grazing.oscillator.workspace import LANES
from grazing.outcome import InputError, shown
from grazing.parameter import checked_name, in_order, named_by, real, whole
from grazing.studies import labels, outside
from grazing.studies.classify import FLOOR, TOLERANCE
from grazing.studies.plan import Arrays, Variable
from grazing.studies.starts import checked_box, checked_seed, checked_starts, random_starts
from grazing.units import magnitude

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Box = tuple[tuple[float, float], ...]

#: Orbits that are computed together: two blocks of oscillators; of a map that is a formula so many that
#: a tile is worth its handling, and of one that follows flight after flight few.
TOGETHER, MANY, FEW = 1024, 8192, 64
#: Arrays of an orbit's points that are in use at a time, its pieces and what they are joined to, and of its state:
#: the start, the last one, outcomes and nearness.
PIECES_AND_WHOLE, STATES = 2, 8
#: Values of a parameter at which the map itself is made before a study begins.
LOOKS = 5


class Settings(NamedTuple):
    """How the orbits of a study begin and how long they run."""

    starts: int | Floats
    transient: int
    keep: int
    seed: int
    arithmetic: str
    box: Box | None

    @property
    def lanes(self) -> int:
        """Orbits of a cell."""
        return self.starts if isinstance(self.starts, int) else len(self.starts)


class Runs:
    """The orbits of a map over a grid of parameter values.

    Parameters
    ----------
    P : Map
    axes : mapping of str to ndarray
        Parameters that vary; cells are numbered through their product, last axis fastest.
    settings : Settings
    moving : tuple of int
        The axes along which the map's own box changes.
    """

    def __init__(self, P: Map, axes: Mapping[str, Floats], settings: Settings, moving: tuple[int, ...] = ()) -> None:
        self.P, self.axes, self.settings, self.moving = P, dict(axes), settings, moving
        self.shape = tuple(len(values) for values in self.axes.values())
        places = list(P.params)
        self._where = [[places.index(one) for one in named_by(name, places)] for name in self.axes]

    @property
    def together(self) -> int:
        """How many cells are worth computing in one go."""
        cells = max(1, together(self.P, self.settings.arithmetic) // self.settings.lanes)
        block = max(1, LANES // padded(self.settings.lanes)) if flies(self.P, self.settings.arithmetic) else 1
        return cells // block * block if cells > block else cells  # a block that is not full takes as long

    @property
    def kept_size(self) -> int:
        """Bytes that a cell takes while it is computed, where all points that are kept are needed at once."""
        return self.settings.lanes * size_of_orbit(self.P, self.settings.keep)

    @property
    def piece_size(self) -> int:
        """Bytes that a cell takes while it is computed, where points are used up as they come."""
        steps = min(self.settings.keep, steps_of_piece(self.P, self.settings.lanes))
        return self.settings.lanes * size_of_orbit(self.P, steps)

    @property
    def work(self) -> int:
        """Steps of the map that a cell takes."""
        return self.settings.lanes * (self.settings.transient + self.settings.keep)

    def values(self, cells: Ints) -> Floats:
        """Return the parameter values of cells, shape (cells, axes)."""
        if not self.axes:  # a single cell, the map as it is
            return np.empty((len(cells), 0))
        places = np.unravel_index(cells, self.shape)
        return np.column_stack([grid[i] for grid, i in zip(self.axes.values(), places, strict=True)])

    def rows(self, cells: Ints) -> Floats:
        """Return all parameters of the map in cells, shape (cells, parameters)."""
        row = list(self.P.params.values()) or [0.0]
        rows = np.empty((len(cells), len(row)))
        rows[:] = row
        for where, values in zip(self._where, self.values(cells).T, strict=True):
            rows[:, where] = values[:, None]
        return self.P.origin.complete(rows)

    def map_at(self, cell: int) -> Map:
        """Return the map of a cell."""
        values = self.values(np.array([cell]))[0].tolist()
        return self.P.replace(**dict(zip(self.axes, values, strict=True)))

    def states(self, cells: Ints) -> Floats:
        """Return the starts in cells, shape (cells, dim, starts)."""
        starts = self.settings.starts
        if not isinstance(starts, int):
            return np.tile(starts.T, (len(cells), 1, 1))  # they are overwritten, and every cell needs its own
        return random_starts(self.settings.seed, self.values(cells), starts, self.boxes(cells))

    def boxes(self, cells: Ints) -> Floats:
        """Return where random starts are drawn, shape (cells, dim, 2)."""
        fixed = self.settings.box or (None if self.moving else self.P.box)
        if fixed is not None:
            return np.broadcast_to(np.array(fixed), (len(cells), *np.shape(fixed)))
        if self.P.origin.boxes is not None:
            return self.P.origin.boxes(self.rows(cells))
        names = [list(self.axes)[i] for i in self.moving]
        different, which = np.unique(self.values(cells)[:, self.moving], axis=0, return_inverse=True)
        boxes = [self.P.replace(**dict(zip(names, row.tolist(), strict=True))).box for row in different]
        return np.array(boxes)[which.ravel()]

    @property
    def drawn(self) -> bool:
        """Whether starts are drawn from the map's own box, where its orbits are to be, so that nobody has chosen."""
        own = isinstance(self.settings.starts, int) and self.settings.box is None
        return own and not self.P.origin.starts_only

    @property
    def variables(self) -> dict[str, Variable]:
        """What is said of starts that are drawn, beside what a study is about."""
        return {outside.NAME: Variable((), "int32", outside.ATTRIBUTES)} if self.drawn else {}

    def say_outside(self, cells: Ints, last: Floats, arrays: Arrays) -> None:
        """Write how many orbits of each cell ended outside the box; ``last`` (cells, dim, n) are their last points."""
        if self.drawn:
            arrays[outside.NAME][...] = outside.beyond(last, self.boxes(cells)).sum(axis=1)

    def pieces(self, cells: Ints, states: Floats | None = None) -> Iterator[Columns]:
        """Run the orbits of cells piece by piece, from given states or from the starts of the study."""
        _starts, transient, keep, _seed, arithmetic, _box = self.settings
        lanes = self.states(cells) if states is None else states
        yield from pieces(self.P, self.rows(cells), lanes, transient, keep, arithmetic)

    def columns(self, cells: Ints, states: Floats | None = None) -> Iterator[Columns | None]:
        """Run the orbits of cells: None after every piece of work, then all that was kept."""
        parts = []
        for part in self.pieces(cells, states):
            parts.append(part)
            yield None
        yield let_go(self.P, joined(parts))

    @property
    def config(self) -> dict[str, Any]:
        """All that decides the numbers; the own value of a parameter that varies does not."""
        starts, transient, keep, seed, arithmetic, box = self.settings
        varied = {one for name in self.axes for one in named_by(name, self.P.params)}
        if isinstance(starts, int):
            own: Any = self.P.box
            if self.moving:  # that of the map at each value; the first and the last tell it from another map's
                own = {"moves": [self.map_at(cell).box for cell in (0, prod(self.shape) - 1)]}
            begin: dict[str, Any] = {"random": starts, "seed": seed, "box": own if box is None else box}
        else:
            begin = {"given": len(starts), "sha256": labels.fingerprint(starts)}
        return {
            "params": {name: value for name, value in self.P.params.items() if name not in varied},
            "starts": begin,
            "transient": transient,
            "keep": keep,
            "arithmetic": arithmetic,
        }


def size_of_orbit(P: Map, steps: int) -> int:
    """Return the bytes that an orbit takes with so many steps: points and letters in pieces and joined, and states."""
    return (PIECES_AND_WHOLE * steps + STATES) * 8 * (P.dimension + 1)


def flies(P: Map, arithmetic: str) -> bool:
    """Return whether orbits of a map fly as blocks; only fast arithmetic does that."""
    return P.origin.block is not None and arithmetic == "fast"


def together(P: Map, arithmetic: str) -> int:
    """Return how many orbits of a map are worth computing in one go."""
    if flies(P, arithmetic):
        return TOGETHER
    return P.origin.together or (MANY if P.prepare is None else FEW)


def checked_runs(
    P: Map,
    axes: Mapping[str, ArrayLike],
    starts: int | ArrayLike,
    transient: int,
    keep: int,
    seed: int,
    arithmetic: str,
    box: Sequence[tuple[float, float]] | None,
    taken: Sequence[str] = (),
    *,
    as_they_come: bool = False,
) -> Runs:
    """Return the orbits of a study, or raise InputError.

    Parameters
    ----------
    P, axes, starts, transient, keep, seed, arithmetic, box
        As the user gave them.
    taken : sequence of str
        Names of variables and dimensions of the result, which neither a parameter nor a coordinate may have.
    as_they_come : bool
        Whether the study uses points up as they come, and needs no cell's at once.
    """
    checked_map(P)
    grids: dict[str, Floats] = {}
    for name, values in axes.items():
        grids[checked_name(name, P.params, P.name or "the map")] = checked_values(name, values, P)
    P.origin.refuse_made(tuple(grids))
    every = [one for name in grids for one in named_by(name, P.params)]
    if len({*every}) < len(every):
        raise InputError(
            f"{' and '.join(grids)} stand for one parameter, {max(every, key=every.count)}; vary one of them"
        )
    for clash in sorted({*grids, *P.coordinates} & {*taken} | {*grids} & {*P.coordinates}):
        raise InputError(f"{shown(clash)} names a dimension or variable of the result; rename it in the map")
    settings = Settings(
        checked_starts(starts, P.coordinates),
        whole(transient, "transient", 0),
        whole(keep, "keep", 1),
        checked_seed(seed),
        checked_arithmetic(arithmetic),
        None if box is None else checked_box(box, P.coordinates),
    )
    for corner in zip(*settings.box, strict=True) if settings.box else ():
        P.origin.refuse_late(corner, P.params)
    found = Runs(P, grids, settings, _moving(P, grids, settings.starts))
    size = found.piece_size if as_they_come else found.kept_size
    refuse_too_large(size, f"reduce starts ({settings.lanes}) or keep ({settings.keep})", "the orbits of one cell")
    return found


def _moving(P: Map, grids: Mapping[str, Floats], starts: int | Floats) -> tuple[int, ...]:
    """Return the axes along which the map's own box changes; raise InputError for a value out of range on the way.

    Ranges belong to one parameter alone. The map itself is made at some values of each, the least and the greatest
    among them, beside the first and the last of the others. Given starts must be allowed at every value.
    """
    moving = []
    for i, (name, grid) in enumerate(grids.items()):
        known = P.describe(name)
        for value in (grid.min(), grid.max()):  # a range has no holes
            known.check(value)
        some = np.unique(np.quantile(grid, np.linspace(0.0, 1.0, LOOKS), method="nearest")).tolist()
        ends = {tuple((other, float(values[k])) for other, values in grids.items() if other != name) for k in (0, -1)}
        along = [{P.replace(**{name: value, **dict(others)}).box for value in some} for others in ends]
        if any(len(boxes) > 1 for boxes in along) or P.replace(**{name: some[0]}).box != P.box:
            moving.append(i)
        if not isinstance(starts, int):
            for others in sorted(ends):
                for value in grid.tolist():
                    for start in starts:
                        P.origin.check(start, {**P.params, **dict(others), name: value})
    for start in () if grids or isinstance(starts, int) else starts:
        P.origin.check(start, P.params)
    return tuple(moving)


def checked_map(P: object) -> Map:
    """Return a map, or raise InputError."""
    if not isinstance(P, Map):
        raise InputError(f"the first argument is {shown(P)}; give a map, such as gz.stroboscopic_map(model)")
    return P


def checked_arithmetic(arithmetic: str) -> str:
    """Return the name of an arithmetic, or raise InputError."""
    if not isinstance(arithmetic, str) or arithmetic not in FLAGS:
        raise InputError(f"arithmetic is {shown(arithmetic)}; allowed are 'strict' and 'fast'")
    return arithmetic


def checked_values(name: str, values: ArrayLike, P: Map | None = None) -> Floats:
    """Return finite values in a one-dimensional array, those of a quantity in the map's units, or raise InputError."""
    units = "1" if P is None else labels.quantity(P, name).get("units", "")
    if units != "1" or hasattr(values, "magnitude"):
        values = magnitude(values, units, name)
    wanted = f"give finite values of {name} in a list or a one-dimensional array"
    try:
        if np.iscomplexobj(values):
            raise TypeError
        grid = np.array(in_order(values), np.float64)
    except Exception:  # of whatever object was given, or of one too large
        raise InputError(f"values are not numbers: {shown(values)}; {wanted}") from None
    if grid.ndim != 1 or not grid.size:
        raise InputError(f"values have shape {grid.shape}; {wanted}")
    if not np.isfinite(grid).all():
        i = int(np.flatnonzero(~np.isfinite(grid))[0])
        raise InputError(f"values[{i}] = {grid[i]} is not finite; {wanted}")
    return grid


def checked_fixed(P: Map, seen: Collection[str], fixed: Mapping[str, float] | None) -> dict[str, float]:
    """Return the coordinates that are not shown: in the middle of the map's box, unless they are given."""
    others = {
        name: 0.5 * (low + high) for name, (low, high) in zip(P.coordinates, P.box, strict=True) if name not in seen
    }
    if fixed is not None and not isinstance(fixed, Mapping):
        raise InputError(f"fixed is {shown(fixed)}; give a mapping of coordinates to numbers, such as {{'v': 0.0}}")
    for name, value in (fixed or {}).items():
        if name not in others:
            raise InputError(
                f"fixed has {shown(name)}; allowed are {', '.join(others) or 'none: all coordinates vary'}"
            )
        others[name] = real(value, name, "give a finite number")
    return others


def describe_values(values: Floats) -> dict[str, Any]:
    """Return what a configuration says of the values of an axis."""
    return {
        "first": values[0],
        "last": values[-1],
        "count": values.size,
        "sha256": labels.fingerprint(values),
    }


def tolerance_config(keep: int) -> dict[str, Any]:
    """Return what a configuration says of how periods are found."""
    return {"period_limit": keep // 2, "tolerance": {"relative": TOLERANCE, "absolute": FLOOR}}
