"""A map of the user's own in the explorer: the module of its kernels, and what the page is told of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from grazing.explorer.composed import Module, Step, common_entries, counter_of, entries_of
from grazing.explorer.extents import rounded, short
from grazing.kernel.lanes import loop_of
from grazing.maps.map import Map, kernels_of
from grazing.outcome import InputError, UserCodeError
from grazing.studies.density import density

NAME = "map"
#: Values of a parameter at which it is tried where orbits live, starts at each, and steps.
TRIED, STARTS, STEPS = 121, 8, 100
#: Sizes of a parameter whose multiples, to which sliders reach, doubles hold.
SMALLEST, LARGEST = 1e-300, 1e300


def checked_own_map(name: str, P: Map) -> Map:
    """Return a map if the page can show it.

    Raises
    ------
    InputError
        For any other map, with what the page can show.
    """
    refused = {
        "is one of the library, which its own views show": P.origin.replace is not None,
        f"has {P.dimension} coordinates": P.dimension > 2,
        "has no parameters": not P.params,
        "has a parameter too large or too small for a slider": any(
            value and not SMALLEST < abs(value) < LARGEST for value in P.params.values()
        ),
        "spells its letters by an Alphabet": not (P.letters is None or isinstance(P.letters, str)),
    }
    for what, is_so in refused.items():
        if is_so:
            raise InputError(
                f"the map {name} {what}; the explorer shows a gz.Map of your own, of one or two coordinates and with "
                "parameters"
            )
    return P


def field_of(name: str) -> str:
    """Return the field of a parameter: a link has others of the same name."""
    return f"{NAME}.{name}"


def boxes_of(P: Map) -> Step:
    """Return the kernel that says where random starts are drawn, the same for all rows."""
    box = P.box

    def boxes(rows: Any, boxes: Any) -> None:
        for q in range(rows.shape[0]):
            for i in range(len(box)):
                boxes[q, i, 0], boxes[q, i, 1] = box[i][0], box[i][1]

    return boxes


def map_module(P: Map) -> Module:
    """Return the module."""
    step, tangent = kernels_of(P)
    kind = P.packed()[0]
    run, units = loop_of(step, P.prepare, kind, P.dimension), [high - low for low, high in P.box]
    entries = [
        *common_entries(boxes_of(P), len(P.params), P.dimension),
        *entries_of(run, counter_of(run, P.dimension), tangent, P.prepare, kind, P.dimension, units),
    ]  # fmt: skip
    fields = tuple(replace(P.describe(name), name=field_of(name)) for name in P.params)
    return Module(entries, fields, tuple(P.coordinates), P.letters if isinstance(P.letters, str) else None)


def extent_of(value: float) -> tuple[float, float]:
    """Return how far the slider of a parameter reaches, of which only its value is known."""
    if value == 0.0:
        return -1.0, 1.0
    far = rounded(2.0 * abs(value))
    ends = 0.05 * far, far  # not at 0, where a map may divide by it
    return ends if value > 0.0 else (-far, -ends[0])


def living(P: Map, name: str, extent: tuple[float, float]) -> tuple[float, float]:
    """Return the part of an extent, around the value of a parameter, in which some orbits do not end."""
    values = np.linspace(*extent, TRIED)
    try:
        found = density(
            P, name, values, bins=1, range=P.box[0], starts=STARTS, transient=STEPS, keep=1, arithmetic="strict"
        )
    except UserCodeError:  # the step has no value at one of its ends
        return extent
    lives = found["ended"].values < STARTS
    low = high = int(np.abs(values - P.params[name]).argmin())
    if not lives[low]:
        return extent
    while low > 0 and lives[low - 1]:
        low -= 1
    while high < TRIED - 1 and lives[high + 1]:
        high += 1
    return (short(values[low]), short(values[high])) if low < high else extent


def described_map(P: Map) -> dict[str, Any]:
    """Return what the page is told of a map beside its module: what it opens on, and how far sliders reach."""
    fields = {name: field_of(name) for name in P.params}
    extents = {fields[name]: extent_of(value) for name, value in P.params.items()}
    reaches = {fields[name]: living(P, name, extents[fields[name]]) for name in P.params}
    first, second = (list(P.params) * 2)[:2]
    middle = [0.5 * (low + high) for low, high in P.box]
    state = {fields[name]: value for name, value in P.params.items()} | {
        "view": NAME, "vary": fields[first], "reach": reaches[fields[first]],
        "second": fields[second], "heights": reaches[fields[second]],
        "coordinate": P.coordinates[0], "positions": P.box[0], "velocities": P.box[-1],
        "x0": middle[0], "y0": middle[-1], "chart": NAME if len(P.params) > 1 else "map-basins",
    }  # fmt: skip
    names = {field: name for name, field in fields.items()}
    return {
        "map": P.name, "coordinates": list(P.coordinates), "law": "", "own": [], "units": {}, "names": names,
        "extents": extents, "reaches": reaches, "state": state,
    }  # fmt: skip
