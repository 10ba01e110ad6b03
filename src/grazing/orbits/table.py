"""Orbits and windows as tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.windows import windows
from grazing.oscillator.rig import Rig
from grazing.outcome import InputError
from grazing.pool import Progress

if TYPE_CHECKING:
    import xarray as xr

    from grazing.orbits.periodic import Orbits


#: Periods of the windows that are looked for if none are named.
PERIODS: Sequence[int] = list(range(1, 8))


def orbit_table(found: Orbits) -> xr.Dataset:
    """Return periodic orbits as a labelled table.

    Parameters
    ----------
    found : Orbits
        From :func:`grazing.periodic_orbits`.

    Returns
    -------
    xarray.Dataset
        Dimension ``orbit``: ``word``, ``period``, ``impacts`` (-1 for a map that counts none), ``stable``, ``neutral``,
        ``admissible``, ``condition``, ``residual``; between walls also ``walls``, ``symmetric`` and ``depth``;
        ``multiplier_real`` and ``multiplier_imag`` (orbit, multiplier);
        the points by coordinate (orbit, n), filled up with NaN. Attribute ``statement``: how they were found.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.table import orbit_table
    >>> from grazing.orbits.periodic import periodic_orbits
    >>> table = orbit_table(periodic_orbits(gz.gap_map(lam=0.8, mu=0.5, l=1.0), range(1, 4)))
    >>> table.word.values.tolist(), table.stable.values.tolist()
    (['LR', 'LLR'], [0, 1])
    """
    from grazing.late import xarray as xr

    P, most = found.map, max((orbit.period for orbit in found), default=1)
    points = np.full((len(found), most, P.dimension), np.nan)
    for i, orbit in enumerate(found):
        points[i, : orbit.period] = orbit.points
    roots = np.array([orbit.multipliers for orbit in found], np.complex128).reshape(len(found), P.dimension)

    def column(values: Iterable[Any], dtype: Any, long_name: str) -> Any:
        return "orbit", np.array(list(values), dtype), {"long_name": long_name}

    table = {
        "word": column((one.word for one in found), object, "word"),
        "period": column((one.period for one in found), np.int64, "period"),
        "impacts": column((one.impacts if isinstance(one, ImpactOrbit) else -1 for one in found), np.int64, "impacts"),
        "stable": column((one.stable for one in found), np.int8, "whether the orbit is stable"),
        "neutral": column((one.neutral for one in found), np.int8, "whether the largest multiplier has modulus 1"),
        "admissible": column((one.admissible for one in found), np.int8, "whether the map has the orbit"),
        "condition": column((one.condition for one in found), np.float64, "condition number"),
        "residual": column((one.residual for one in found), np.float64, "largest defect of its equations"),
        "multiplier_real": (("orbit", "multiplier"), roots.real, {"long_name": "multiplier, real part"}),
        "multiplier_imag": (("orbit", "multiplier"), roots.imag, {"long_name": "multiplier, imaginary part"}),
    }
    if P.walled is not None:
        table["walls"] = column((getattr(one, "walls", "") for one in found), object, "walls that are hit, in order")
        table["symmetric"] = column((getattr(one, "symmetric", False) for one in found), np.int8, "own mirror image")
        table["depth"] = column((getattr(one, "depth", 0.0) for one in found), np.float64, "how far it passes a wall")
    for j, name in enumerate(P.coordinates):
        known = P.origin.describe(name)
        said = {"long_name": name, "symbol": name} if known is None else known.attributes
        table[name] = ("orbit", "n"), points[:, :, j], said
    attributes = {"title": f"periodic orbits of the {P.name or 'map'}", "statement": found.statement}
    return xr.Dataset(table, attrs=attributes | P.origin.attributes)


def window_table(
    model: Rig,
    name: str,
    N: Sequence[int] = PERIODS,
    span: tuple[float, float] | None = None,
    samples: int | None = None,
    sensitivity: bool = False,
    words: str | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the windows of one-impact orbits, with the derivatives of their edges if wanted.

    Parameters
    ----------
    model, name, N, span, samples, words, progress
        As for :func:`grazing.windows`.
    sensitivity : bool
        Whether to add ``derivative`` and ``error`` (window, edge, moved), see :func:`grazing.sensitivity`; the
        dimension ``moved`` has the names of the parameters.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.table import window_table
    >>> dict(window_table(gz.pinball(V=0.4), "d", [2, 3]).sizes)
    {'window': 2}
    """
    if sensitivity and isinstance(model, Rig) and model.walled:
        raise InputError("derivatives of edges are those of windows over one wall; leave out sensitivity")
    table = windows(model, name, N, span, samples, words, progress)
    if sensitivity:
        from grazing.orbits.sensitivity import sensitivity as derivatives

        moved = derivatives(model.seen[0], name, table.attrs["N"], span, table.attrs["samples"])[
            ["derivative", "error"]
        ]
        table = table.merge(moved.rename(parameter="moved"))
    return table
