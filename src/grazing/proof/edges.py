"""Proofs of the edges of windows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.contacts import Model
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.one_impact import one_impact_orbits
from grazing.orbits.word_windows import met
from grazing.oscillator.model import Oscillator
from grazing.outcome import GrazingError
from grazing.proof.certify import Certificate
from grazing.proof.enclose import enclose
from grazing_checker.sentence import EVENTS

if TYPE_CHECKING:
    import xarray as xr

#: Parts of a window's width from its edge at which an orbit is taken to begin a proof from.
INSIDE = (1e-3, 1e-2, 1e-4)


def edge_proofs(model: Model, table: xr.Dataset) -> Iterator[tuple[int, str, Certificate | str]]:
    """Yield a proof of every edge of every window: the window, the side, and the proof or why there is none.

    Parameters
    ----------
    model : Oscillator or Walled
        That of the windows.
    table : xarray.Dataset
        What :func:`grazing.windows` returned.

    Yields
    ------
    (int, str, Certificate or str)

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.proof.edges import edge_proofs
    >>> model = gz.pinball(V=0.4)
    >>> [(side, proof.proven) for _w, side, proof in edge_proofs(model, gz.windows(model, "d", N=3))]
    [('low', True), ('high', True)]
    """
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
            word = str(row["word"].values) if "word" in row else ""
            proof = _enclosed(model, name, N, word, kind, ends[side], ends[other] - ends[side])
            yield w, side, proof if isinstance(proof, str) else _of_the_wall(proof, row, side)


def _of_the_wall(proof: Certificate, row: xr.Dataset, side: str) -> Certificate | str:
    """Return the proof of a graze if it is of the wall that the window names; its own mirror image grazes both."""
    touched = (proof.document or {})["data"].get("dip", {}).get("wall", "")
    named = str(row[f"{side}_wall"].values) if "word" in row else touched
    if touched in ("", named) or bool(row["symmetric"]):
        return proof
    return f"the proof is of a graze of the wall {touched}, not {named}"


def _orbits(model: Model, N: int, word: str) -> Sequence[ImpactOrbit]:
    """Return orbits of N periods: with one impact, or between walls that hit them in the order of a word."""
    return one_impact_orbits(model, N) if isinstance(model, Oscillator) else met(stroboscopic_map(model), N, [word])


def _enclosed(model: Model, name: str, N: int, word: str, kind: str, edge: float, across: float) -> Certificate | str:
    """Return the proof of one edge, begun from an orbit inside the window, or why there is none."""
    why = "no orbit was found beside it"
    for part in INSIDE:
        value = edge + part * across
        for orbit in _orbits(model.replace(**{name: value}), N, word):
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
