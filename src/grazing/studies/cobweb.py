"""One orbit of a one-dimensional map, as a labelled result."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.outcome import FATAL, InputError
from grazing.parameter import whole
from grazing.pool import Progress, checked_progress
from grazing.studies import labels

if TYPE_CHECKING:
    import xarray as xr


#: Places at which the graph of the map is known, and how far it reaches beyond the orbit, as a part of its length.
PLACES, MARGIN = 1200, 0.12
#: Steps that pass by at a time.
TOGETHER = 1 << 24
#: What counts as beside a place, in shares of the largest one; alone where all are 0.
CLOSE = 1e-12


def cobweb(
    P: Map, state: Sequence[float], steps: int = 100, transient: int = 0, progress: Progress | None = None
) -> xr.Dataset:
    """Return one orbit of a one-dimensional map, and the graph of the map around it.

    Parameters
    ----------
    P : Map
        With one coordinate.
    state : sequence of float
        Where the orbit starts.
    steps, transient : int
        Steps that are kept, after steps that are thrown away.
    progress : callable, optional
        ``progress(done, total)``, called now and then with numbers of steps.

    Returns
    -------
    xarray.Dataset
        On "n": the coordinate. On "step": ``letter`` and ``outcome`` of the step from point n to point n + 1. On
        "place", a value of the coordinate: the graph of the map, ``image`` and ``image_letter``.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.cobweb import cobweb
    >>> cobweb(gz.gap_map(lam=0.8, mu=0.5, l=1.0), [-1.0], steps=2).x.values.round(6).tolist()
    [-1.0, -0.3, 0.26]
    """
    from grazing.late import xarray as xr

    if P.dimension != 1:
        raise InputError(f"the {P.name} has coordinates {', '.join(P.coordinates)}; a cobweb needs a map with one")
    transient, steps = whole(transient, "transient", 0), whole(steps, "steps", 1)
    progress = checked_progress(progress)
    if transient:  # its steps pass by, but the last, which comes to the first point that is kept
        points, letters, outcomes = settled(P, P.orbit(state, 0).points.T.copy(), transient - 1, steps + 1, progress)
        letters, outcomes = letters[1:], outcomes[1:]
    else:
        points, letters, outcomes, *_ = P.orbit(state, steps)
    name = P.coordinates[0]
    data = {
        name: ("n", points[:, 0], labels.quantity(P, name)),
        "letter": ("step", letters, labels.letter_attributes(P)),
        "outcome": ("step", outcomes, labels.outcome_attributes()),
    }
    place = places_of(np.asarray(points[:, 0], np.float64))
    images, image_letters, _outcomes = P.run(place[None].copy(), 0, 1)
    data |= {
        "image": ("place", images[0, 0], labels.quantity(P, name) | {"long_name": f"image of {name} under the map"}),
        "image_letter": ("place", image_letters[0], labels.letter_attributes(P)),
    }
    coords = {"place": ("place", place, labels.quantity(P, name))}
    config = {"study": "cobweb", "state": list(state), "steps": steps, "transient": transient}
    return xr.Dataset(data, coords, labels.document(P, f"orbit of the {P.name}", config))


def settled(
    P: Map, lanes: NDArray[np.float64], passing: int, kept: int, progress: Progress | None
) -> tuple[NDArray[Any], ...]:
    """Return points, letters and outcomes of so many steps of one orbit, after others that pass by."""
    total, left, seen = passing + kept, passing, 0
    while left > TOGETHER:
        before = lanes.copy()
        outcome = int(P.run(lanes, TOGETHER, 0)[2].item())
        if outcome & FATAL:  # it ends here, and stays ended
            lanes, left = before, TOGETHER
            break
        left, seen = left - TOGETHER, seen | outcome
        if progress is not None:
            progress(total - kept - left, total)
    points, letters, outcomes = (a[..., 0] for a in P.run(lanes, left, kept, records=kept))
    outcomes[0] |= seen
    return points, letters, outcomes


def places_of(points: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Return where the graph of a map is drawn around an orbit.

    The pieces of our maps meet at 0: it and a place close below it are among them, so that a jump is upright.
    """
    ended = points[np.isfinite(points)]
    low, high = (float(ended.min()), float(ended.max())) if ended.size else (0.0, 0.0)
    with np.errstate(over="ignore", invalid="ignore"):  # points that a double holds, but not how far they are apart
        pad = MARGIN * (max(high - low, CLOSE * max(abs(low), abs(high))) or CLOSE)
        low, high = low - pad, high + pad
        below = np.array([max(low, -CLOSE * high), 0.0])
        return np.union1d(np.linspace(low, high, PLACES), below if low < 0.0 < high else [low])
