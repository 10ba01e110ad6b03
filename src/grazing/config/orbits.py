"""Orbits and windows as tables, for files and the command line, and proofs of the edges of windows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.one_impact import one_impact_orbits
from grazing.orbits.windows import windows
from grazing.oscillator.model import Oscillator
from grazing.outcome import GrazingError

if TYPE_CHECKING:
    import xarray as xr

    from grazing.orbits.periodic import Orbits
    from grazing.proof.certify import Certificate

#: Periods of the windows that are looked for if none are named.
PERIODS: Sequence[int] = list(range(1, 8))
#: Parts of a window's width from its edge at which an orbit is taken to begin a proof from.
INSIDE = (1e-3, 1e-2, 1e-4)


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
    >>> from grazing.config.orbits import orbit_table
    >>> from grazing.orbits.periodic import periodic_orbits
    >>> table = orbit_table(periodic_orbits(gz.gap_map(lam=0.8, mu=0.5, l=1.0), range(1, 4)))
    >>> table.word.values.tolist(), table.stable.values.tolist()
    (['LR', 'LLR'], [0, 1])
    """
    import xarray as xr

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
    model: Oscillator,
    name: str,
    N: Sequence[int] = PERIODS,
    span: tuple[float, float] | None = None,
    samples: int = 2000,
    sensitivity: bool = False,
) -> xr.Dataset:
    """Return the windows of one-impact orbits, with the derivatives of their edges if wanted.

    Parameters
    ----------
    model, name, N, span, samples
        As for :func:`grazing.windows`.
    sensitivity : bool
        Whether to add ``derivative`` and ``error`` (window, edge, moved), see :func:`grazing.sensitivity`; the
        dimension ``moved`` has the names of the parameters.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.config.orbits import window_table
    >>> dict(window_table(gz.pinball(V=0.4), "d", [2, 3]).sizes)
    {'window': 2}
    """
    table = windows(model, name, N, span, samples)
    if sensitivity:
        from grazing.orbits.sensitivity import sensitivity as derivatives

        moved = derivatives(model, name, N, span, samples)[["derivative", "error"]]
        table = table.merge(moved.rename(parameter="moved"))
    return table


def edge_proofs(model: Oscillator, table: xr.Dataset) -> Iterator[tuple[int, str, Certificate | str]]:
    """Yield a proof of every edge of every window: the window, the side, and the proof or why there is none.

    Parameters
    ----------
    model : Oscillator
        That of the windows.
    table : xarray.Dataset
        What :func:`grazing.windows` returned.

    Yields
    ------
    (int, str, Certificate or str)

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.config.orbits import edge_proofs
    >>> model = gz.pinball(V=0.4)
    >>> [(side, proof.proven) for _w, side, proof in edge_proofs(model, gz.windows(model, "d", N=3))]
    [('low', True), ('high', True)]
    """
    from grazing_checker.sentence import EVENTS

    name = str(table.attrs["parameter"])
    for w in range(table.sizes["window"]):
        row = table.isel(window=w)
        N, ends = int(row["N"]), {side: float(row[side]) for side in ("low", "high")}
        for side, other in (("low", "high"), ("high", "low")):
            kind = str(row[f"{side}_type"].values)
            if kind not in EVENTS:
                why = f"a proof needs an edge of type {', '.join(EVENTS)}; this one is of type {kind}"
                yield w, side, why
                continue
            yield w, side, _enclosed(model, name, N, kind, ends[side], ends[other] - ends[side])


def _enclosed(model: Oscillator, name: str, N: int, kind: str, edge: float, across: float) -> Certificate | str:
    """Return the proof of one edge, begun from an orbit inside the window, or why there is none."""
    from grazing.proof.certify import Certificate
    from grazing.proof.enclose import enclose

    why = "no orbit was found beside it"
    for part in INSIDE:
        value = edge + part * across
        for orbit in one_impact_orbits(model.replace(**{name: value}), N):
            if not (orbit.admissible and orbit.stable):
                continue
            try:
                proof = enclose(orbit, kind, name)
            except GrazingError as error:
                why = str(error)
                continue
            if isinstance(proof, Certificate) and proof.value is not None:
                low, high = proof.value
                if low - 1e-9 * abs(across) <= edge <= high + 1e-9 * abs(across):
                    return proof
                why = f"the proof is of another value, [{low!r}, {high!r}]"
            else:
                why = proof.reason
    return why
