"""The graph of a map along one coordinate; of a stroboscopic map beside that of its discontinuity map."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.copies import by_value
from grazing.maps.discontinuity import ORDERS, discontinuity_map
from grazing.maps.map import Map
from grazing.outcome import InputError, shown
from grazing.studies import labels
from grazing.studies.runs import checked_fixed, checked_map, checked_values, describe_values

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Names of variables and dimensions of the result, which a coordinate must not have.
TAKEN = ("map", "letter", "outcome")


@by_value
class Graph(NamedTuple):
    """Starts along one coordinate, their images, shape (n, dim), and letters; made by :func:`graph_of`."""

    starts: Floats
    images: Floats
    letters: Ints
    coordinate: str
    coordinates: tuple[str, ...]


def graph(
    P: Map,
    name: str,
    values: ArrayLike,
    *,
    fixed: Mapping[str, float] | None = None,
    order: str | None = "lowest",
) -> xr.Dataset:
    """Return the images of a row of states under one step of a map.

    Parameters
    ----------
    P : Map
        Any map. Beside a stroboscopic map comes the discontinuity map of its oscillator, at the same phase.
    name : str
        The coordinate that varies.
    values : array_like, shape (n,)
        Of that coordinate.
    fixed : mapping of str to float, optional
        The other coordinates; each is in the middle of the map's box unless said.
    order : {"lowest", "full", "corrected"}, optional
        Of that discontinuity map, see :func:`grazing.discontinuity_map`; None for the stroboscopic map alone.

    Returns
    -------
    xarray.Dataset
        On "map", the names of the maps, and the values: ``image_u`` for a coordinate u, one such variable for each
        coordinate, ``letter`` and ``outcome`` of the step. The arithmetic is strict: the numbers are those of calling
        each map, on every machine.

    Raises
    ------
    InputError
        For an input out of range, or a state that is not allowed.

    References
    ----------
    Pring and Budd, IMA Journal of Applied Mathematics 76 (2011) 67-84, Figure 2.2.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.graph import graph
    >>> P = gz.stroboscopic_map(gz.pinball(omega=2.1, t0=2.2, d=0.11, V=0.2))
    >>> found = graph(P, "u", [0.03, 0.039, 0.05], fixed={"v": -0.23})
    >>> found["map"].values.tolist(), found.letter.values.tolist()
    (['stroboscopic map', 'discontinuity map, lowest order'], [[1, 0, 0], [1, 1, 0]])
    """
    from grazing.late import xarray as xr

    _checked_coordinate(P, name)
    if name in (*TAKEN, *(f"image_{own}" for own in P.coordinates)):
        raise InputError(f"{shown(name)} names a dimension or variable of the result; rename it in the map")
    if order is not None and (not isinstance(order, str) or order not in ORDERS):
        raise InputError(f"order is {shown(order)}; allowed are {', '.join(map(repr, ORDERS))} and None")
    x, others = checked_values(name, values, P), checked_fixed(P, (name,), fixed)
    for value in (x.min(), x.max()):
        P.origin.check(tuple({**others, name: float(value)}[own] for own in P.coordinates), P.params)
    config: dict[str, Any] = {
        "study": "graph",
        "grid": {name: describe_values(x)},
        "fixed": others,
        "arithmetic": "strict",
    }
    maps = [P]
    if P.model is not None and P.section == "strobe":
        if order is not None:
            maps.append(discontinuity_map(P.model, order, P.params["phase"]))
        config["order"] = "none" if order is None else order
    steps = [_step(each, x, name, others) for each in maps]
    dims = ("map", name)
    images = {
        f"image_{own}": (
            dims,
            np.array([points[i] for points, _letters, _outcomes in steps]),
            labels.quantity(P, own) | {"long_name": f"image of {own} under the map"},
        )
        for i, own in enumerate(P.coordinates)
    }
    data = {
        **images,
        "letter": (dims, np.array([letters for _points, letters, _outcomes in steps]), labels.letter_attributes(P)),
        "outcome": (dims, np.array([outcomes for *_rest, outcomes in steps]), labels.outcome_attributes()),
    }
    coords = {
        "map": ("map", np.array([each.name or "map" for each in maps]), {"long_name": "map"}),
        name: (name, x, labels.quantity(P, name)),
    }
    attrs = labels.document(P, f"graph of the {P.name or 'map'} in {name}", config)
    if len(maps) > 1:  # the code of both decides the numbers
        code = " ".join(map(labels.map_code, maps))
        attrs["grazing_code_sha256"] = hashlib.sha256(code.encode()).hexdigest()
    return xr.Dataset(data, coords, attrs)


def graph_of(P: Map, values: ArrayLike, coordinate: str | None = None, **fixed: float) -> Graph:
    """Apply a map once to a row of starts.

    Parameters
    ----------
    P : Map
    values : array_like, shape (n,)
        Of the coordinate that varies.
    coordinate : str, optional
        Default: the first one.
    **fixed : float
        The other coordinates; each is in the middle of the map's box unless said.

    Returns
    -------
    Graph

    Raises
    ------
    InputError
        For what is no map, no coordinate of it, or no numbers.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.plot.map_graph import graph_of
    >>> graph_of(gz.gap_map(0.8, 0.5, 1.0), [-1.0, 0.25]).images[:, 0].round(6).tolist()
    [-0.3, -1.0]
    """
    name = _checked_coordinate(P, P.coordinates[0] if isinstance(P, Map) and coordinate is None else coordinate)
    x = checked_values(name, values, P)
    points, letters, _outcomes = _step(P, x, name, checked_fixed(P, (name,), fixed))
    return Graph(x, points.T.copy(), letters, name, tuple(P.coordinates))


def _checked_coordinate(P: Map, name: Any) -> str:
    """Return the name of a coordinate of a map, or raise InputError."""
    checked_map(P)
    if not isinstance(name, str) or name not in P.coordinates:
        raise InputError(
            f"{shown(name)} is no coordinate of the {P.name or 'map'}; allowed are {', '.join(P.coordinates)}"
        )
    return name


def _step(P: Map, x: Floats, name: str, fixed: Mapping[str, float]) -> tuple[Floats, Ints, Ints]:
    """Return images, shape (dim, n), letters and outcomes of one step from starts along a coordinate."""
    lanes = np.array([x if own == name else np.full_like(x, fixed[own]) for own in P.coordinates])
    points, letters, outcomes = P.run(lanes, 0, 1)
    return points[0], letters[0], outcomes[0]
