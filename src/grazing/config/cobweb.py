"""One orbit of a one-dimensional map, as a labelled result."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from grazing.maps.map import Map
from grazing.outcome import InputError
from grazing.parameter import whole
from grazing.studies import labels

if TYPE_CHECKING:
    import xarray as xr


def cobweb(P: Map, state: Sequence[float], steps: int = 100, transient: int = 0) -> xr.Dataset:
    """Return one orbit of a one-dimensional map.

    Parameters
    ----------
    P : Map
        With one coordinate.
    state : sequence of float
        Where the orbit starts.
    steps, transient : int
        Steps that are kept, after steps that are thrown away.

    Returns
    -------
    xarray.Dataset
        On "n": the coordinate. On "step": ``letter`` and ``outcome`` of the step from point n to point n + 1.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.config.cobweb import cobweb
    >>> cobweb(gz.gap_map(lam=0.8, mu=0.5, l=1.0), [-1.0], steps=2).x.values.round(6).tolist()
    [-1.0, -0.3, 0.26]
    """
    import xarray as xr

    if P.dimension != 1:
        raise InputError(f"the {P.name} has coordinates {', '.join(P.coordinates)}; a cobweb needs a map with one")
    transient, steps = whole(transient, "transient", 0), whole(steps, "steps", 1)
    orbit = P.orbit(state, transient + steps)
    name = P.coordinates[0]
    data = {
        name: ("n", orbit.points[transient:, 0], labels.quantity(P, name)),
        "letter": ("step", orbit.letters[transient:], labels.letter_attributes(P)),
        "outcome": ("step", orbit.outcomes[transient:], labels.outcome_attributes()),
    }
    config = {"study": "cobweb", "state": list(state), "steps": steps, "transient": transient}
    return xr.Dataset(data, attrs=labels.document(P, f"orbit of the {P.name}", config))
