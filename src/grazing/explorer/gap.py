"""The module of the gap map (2.6): its orbits, its raster, what they settle on, and the edges of theory."""

from __future__ import annotations

from typing import Any

from grazing.explorer.composed import Module, common_entries, entries_of
from grazing.kernel.export import Argument, Entry
from grazing.maps.gap import PARAMETERS, gap_map, gap_step, gap_tangent
from grazing.parameter import parameter_tuple
from grazing.theory.edges import collision_edge, doubling_edge, graze_edge

INFINITY = float("inf")
#: The parameters, in the order of a row.
FIELDS = tuple(PARAMETERS)
((LOW, HIGH),) = gap_map(0.5, 0.1, 0.1).box


def edges(lam: float, l: float, table: Any) -> None:
    """Write graze, period doubling and border collision in μ of the maximal orbits of period 1, 2, ... to rows."""
    c, k = 1.0, 1.0
    before, k_before = 0.0, 0.0
    for n in range(table.shape[0]):
        table[n, 0], table[n, 1] = graze_edge(c, k, l), doubling_edge(c, k, l)
        table[n, 2] = collision_edge(before, k_before, l) if n > 0 else INFINITY
        before, k_before = c, k
        c *= lam
        k += c


def boxes(rows: Any, boxes: Any) -> None:
    """Write where random starts are drawn, the same for all rows."""
    for q in range(rows.shape[0]):
        boxes[q, 0, 0], boxes[q, 0, 1] = LOW, HIGH


def gap_module() -> Module:
    """Return the module."""
    entries = [
        *common_entries(boxes, len(FIELDS), 1),
        *entries_of(gap_step, gap_tangent, None, parameter_tuple(FIELDS), 1),
        Entry(
            "edges",
            edges,
            ("periods",),
            (
                Argument("lam", "float64", (), "slope of the map for x < 0, 0 < lam < 1"),
                Argument("l", "float64", (), "size of the gap, l >= 0"),
                Argument("table", "float64", ("periods", 3), "mu_gr, mu_pd and mu_bc of periods 1, 2, ..."),
            ),
            meaning="the windows of the maximal orbits, Proposition 3.1",
        ),
    ]
    return Module(entries, tuple(PARAMETERS.values()), ("x",), "LR")
