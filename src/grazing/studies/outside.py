"""Orbits that end outside the box their random starts were drawn from: what a box that is too small hides is said."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grazing.studies import labels

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: The variable, and the attribute of a result that says it in words.
NAME, NOTE = "outside", "grazing_outside"
#: How far beyond the box is outside, as a share of its width: a ball at rest on the wall is not.
ROOM = 0.02
ATTRIBUTES: labels.Attributes = {
    "long_name": "orbits whose last point lies outside the map's own box, from which their starts were drawn",
    "units": "1",
}


def beyond(last: Floats, boxes: Floats) -> NDArray[np.bool_]:
    """Return which of the last points (cells, dim, n) lie outside boxes (cells, dim, 2); one that is lost does not."""
    room = ROOM * (boxes[:, :, 1] - boxes[:, :, 0])
    low, high = (boxes[:, :, 0] - room)[:, :, None], (boxes[:, :, 1] + room)[:, :, None]
    return np.asarray(((last < low) | (last > high)).any(axis=1))


def with_note(result: xr.Dataset) -> xr.Dataset:
    """Return the result of a study, with a note if orbits ended outside the box their starts were drawn from."""
    if NAME in result.data_vars and result[NAME].attrs.get("long_name") == ATTRIBUTES["long_name"]:
        counts = result[NAME].values
        if (counts > 0).any():
            result.attrs[NOTE] = (
                f"{int(counts.sum())} orbits, in {int((counts > 0).sum())} of {counts.size} cells, ended outside the "
                "box their starts were drawn from, the map's own; attractors may lie there that no start reached: "
                "give box or starts of your own"
            )
    return result
