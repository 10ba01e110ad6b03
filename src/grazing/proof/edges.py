"""Proofs of the edges of windows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.curves import wrapped
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.one_impact import one_impact_orbits
from grazing.orbits.word_windows import flown, met
from grazing.oscillator.rig import Rig
from grazing.outcome import GrazingError
from grazing.proof.certify import Certificate
from grazing.proof.enclose import enclose
from grazing_checker.sentence import EVENTS

if TYPE_CHECKING:
    import xarray as xr

#: Parts of a window's width from its edge at which an orbit is taken to begin a proof from.
INSIDE = (1e-3, 1e-2, 1e-4)
#: Impacts whose phases differ by less are one: at a fold doubles tell a phase no better than to the root of rounding.
ALIKE = 1e-3


def edge_proofs(model: Rig, table: xr.Dataset) -> Iterator[tuple[int, str, Certificate | str]]:
    """Yield a proof of every edge of every window: the window, the side, and the proof or why there is none.

    Parameters
    ----------
    model : Rig
        That of the windows.
    table : xarray.Dataset
        What :func:`grazing.windows` returned for this model: a proof counts if its enclosure holds the edge and its
        impacts have the phase that the table has there.

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
        for side in ("low", "high"):
            kind = str(row[f"{side}_type"].values)
            if kind not in EVENTS:
                why = f"a proof needs an edge of type {', '.join(EVENTS)}; this one is of type {kind}"
                yield w, side, why
                continue
            yield w, side, _enclosed(model, name, _Edge(row, side))


class _Edge:
    """An edge of a window as its table tells it, and whether a proof is of it."""

    def __init__(self, row: xr.Dataset, side: str) -> None:
        self.N, self.kind = int(row["N"]), str(row[f"{side}_type"].values)
        self.value, self.phase = float(row[side]), float(row[f"{side}_phase"])
        self.across = float(row["high" if side == "low" else "low"]) - self.value
        self.word, self.symmetric, self.wall = "", False, ""
        if "word" in row:
            self.word, self.symmetric = str(row["word"].values), bool(row["symmetric"])
            self.wall = str(row[f"{side}_wall"].values)

    def other(self, proof: Certificate) -> str:
        """Return what else a proof is of, in words; empty if it is of this edge.

        Its enclosure holds the value of the edge, and the impact that begins the word has the phase of the window's
        orbit there. It grazes the wall that is named; an orbit that is its own mirror image grazes both.
        """
        assert proof.document is not None and proof.value is not None
        data, (low, high) = proof.document["data"], proof.value
        if not low <= self.value <= high:
            return f"of another value, [{low!r}, {high!r}]"
        if not any(abs(wrapped(phase - self.phase)) < ALIKE for phase in self._phases(data, low)):
            return "of another orbit, whose impacts have other phases"
        touched = data["dip"].get("wall", "")
        if self.wall and touched not in ("", self.wall) and not self.symmetric:
            return f"of a graze of the wall {touched}, not {self.wall}"
        return ""

    def _phases(self, data: Mapping[str, Any], value: float) -> Iterator[float]:
        """Yield the phases of the impacts in a proof that may begin the word."""
        omega, t0 = (
            value if x is None else float.fromhex(x) for x in (data["model"][name] for name in ("omega", "t0"))
        )
        hits = "".join(data["impacts"]) if self.word else ""
        for i, (low, _high) in enumerate(data["claims"]["box"][: len(hits) or 1]):
            if hits[i:] + hits[:i] == self.word[: len(hits)]:  # a double begins as the orbit that doubles
                yield omega * (float(low) + t0)


def _orbits(model: Rig, N: int, word: str) -> Sequence[ImpactOrbit]:
    """Return orbits of N periods: with one impact, or between walls that hit them in the order of a word."""
    if not model.walled:
        return one_impact_orbits(model.seen[0], N)
    P = stroboscopic_map(model)
    return met(P, N, [word], flown(P, N))


def _enclosed(model: Rig, name: str, edge: _Edge) -> Certificate | str:
    """Return the proof of one edge, begun from an orbit inside the window, or why there is none.

    Where a double is born, the multiplier -1 is that of the orbit that doubles, which repels inside.
    """
    why, half = "no orbit was found beside it", edge.word[: len(edge.word) // 2]
    begins = [(edge.N, edge.word)]
    if edge.kind == "pd" and half and edge.word == 2 * half and edge.N % 2 == 0:
        begins.append((edge.N // 2, half))
    for part, (N, word) in product(INSIDE, begins):
        value = edge.value + part * edge.across
        for orbit in _orbits(model.replace(**{name: value}), N, word):
            if not (orbit.admissible and (orbit.stable or N != edge.N)):
                continue
            try:
                proof = enclose(orbit, edge.kind, name)
            except GrazingError as error:
                why = str(error)
                continue
            if not isinstance(proof, Certificate) or proof.value is None:
                why = proof.reason
                continue
            other = edge.other(proof)
            if not other:
                return proof
            why = f"the proof is {other}"
    return why
