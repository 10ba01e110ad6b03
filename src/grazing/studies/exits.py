"""Launches on a pinball table as a study of a map of launches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from grazing.maps.launches import HITS_OF, POINT, OfLaunches, launches
from grazing.maps.map import Map
from grazing.outcome import InputError

if TYPE_CHECKING:
    import xarray as xr


def exits(
    P: Map, grid: Mapping[str, ArrayLike] | None = None, *, fixed: Mapping[str, float] | None = None,
    threads: int | None = None,
) -> xr.Dataset:  # fmt: skip
    """Return what :func:`grazing.launches` does, of a map of launches: the study of that name.

    Parameters
    ----------
    P : Map
        Of :func:`grazing.launch_map`.
    grid : mapping of str to array_like, optional
        ``angle`` and ``speed``; what is missing is that of the plunger.
    fixed : mapping of str to float, optional
        Such a value of one of them.
    threads : int, optional
        As in :func:`grazing.launches`.

    Raises
    ------
    InputError
        As :func:`grazing.launches` does, and for another map.
    """
    origin = P.origin
    if not isinstance(origin, OfLaunches):
        raise InputError(f"launches need a map of launches, gz.launch_map(table); this is a {P.name}")
    point = tuple(P.params[name] for name in POINT) if POINT[0] in P.params else None
    chosen: dict[str, Any] = {**(fixed or {}), **(grid or {})}
    return launches(origin.table, point, **chosen, hits=int(P.params[HITS_OF]), threads=threads)
