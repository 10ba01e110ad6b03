"""Launches that graze an object of a pinball table, as a study of a map of launches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from grazing.maps.grazes import CELLS, grazes
from grazing.maps.launches import POINT, OfLaunches
from grazing.maps.map import Map
from grazing.outcome import InputError

if TYPE_CHECKING:
    import xarray as xr


def grazed(
    P: Map, grid: Mapping[str, ArrayLike] | None = None, *, fixed: Mapping[str, float] | None = None, impacts: int = 1,
    objects: str | None = None,
) -> xr.Dataset:  # fmt: skip
    """Return what :func:`grazing.grazes` does, of a map of launches: the study of that name.

    Parameters
    ----------
    P : Map
        Of :func:`grazing.launch_map`.
    grid : mapping of str to array_like, optional
        ``angle`` and ``speed``: between the first and the last value there is a cell fewer than values. What is
        missing is that of the plunger.
    fixed : mapping of str to float, optional
        Refused: curves need a range of both.
    impacts : int
        Before the graze, at most.
    objects : str, optional
        Names of those that are grazed, with commas between them; all if not given.

    Raises
    ------
    InputError
        As :func:`grazing.grazes` does, and for another map.
    """
    origin = P.origin
    if not isinstance(origin, OfLaunches):
        raise InputError(f"grazes need a map of launches, gz.launch_map(table); this is a {P.name}")
    point = tuple(P.params[name] for name in POINT) if POINT[0] in P.params else None
    ends, cells = {}, dict(zip(("angle", "speed"), CELLS, strict=True))
    for name, given in {**{name: [value] for name, value in (fixed or {}).items()}, **(grid or {})}.items():
        values = np.asarray(given, np.float64)
        if len(values) < 2:
            raise InputError(f"{name} is always {values[0]:g}; give a range, such as {name}=1:2:65")
        ends[name], cells[name] = (float(values.min()), float(values.max())), len(values) - 1
    names = None if objects is None else [name.strip() for name in objects.split(",")]
    both = cells["angle"], cells["speed"]
    return grazes(origin.table, point, ends.get("angle"), ends.get("speed"), impacts, names, cells=both)
