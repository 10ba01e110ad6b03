"""The module of the gap map (2.6): its orbits, its raster, what they settle on, and the edges of theory."""

from __future__ import annotations

from typing import Any

import numpy as np

from grazing.explorer.composed import Module, arguments, common_entries, entries_of
from grazing.explorer.webassembly import Entry
from grazing.kernel.lanes import loop_of
from grazing.kernel.primitives import at, inlined, picked
from grazing.maps.gap import PARAMETERS, gap_map, gap_step, gap_tangent
from grazing.outcome import AMBIGUOUS
from grazing.parameter import parameter_tuple
from grazing.theory.edges import collision_edge, doubling_edge, graze_edge

INFINITY = float("inf")
#: The parameters, in the order of a row.
FIELDS = tuple(PARAMETERS)
KIND = parameter_tuple(FIELDS)
((LOW, HIGH),) = gap_map(0.5, 0.1, 0.1).box
#: Orbits side by side: enough to hide how long a square root takes, few enough to be written out one by one.
BESIDE = 8


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


@inlined
def part_of(x: float, low: float, high: float, scale: float, bins: int) -> Any:
    """Return which number of a column counts a point, as :func:`grazing.studies.density.raster` does."""
    part = picked(x <= high, min((x - low) * scale, bins - 1.0), bins * 1.0)
    part = picked(x >= low, part, -1.0)
    return np.int32(picked(x == x, part, bins + 1.0)) + 1  # no part in between is below 0: cut off is rounded down


def count(
    rows: Any, lanes: Any, transient: int, keep: int, _i: int, low: float, high: float, bins: int, counts: Any,
    ended: Any, ambiguous: Any,
) -> None:  # fmt: skip
    """Count orbits in a raster as the kernel for any map does, but each point as soon as it is found.

    A picture of the page waits for this kernel: no point is written to memory, and what the loops read is not
    handed to other kernels, which in a module would be counted as one more owner at each iterate.
    """
    columns, n = lanes.shape[0], lanes.shape[2]
    scale, total = bins / (high - low), columns * n
    for q in range(columns):
        ended[q], ambiguous[q] = 0, 0
        for k in range(counts.shape[1]):
            counts[q, k] = 0
    x, c = np.empty(BESIDE), np.empty((3, BESIDE))
    said, which, part = np.empty(BESIDE, np.int64), np.empty(BESIDE, np.int64), np.empty(BESIDE, np.int32)
    for start in range(0, total, BESIDE):
        width = min(BESIDE, total - start)
        for j in range(BESIDE):  # beyond the last orbit, that one once more
            orbit = min(start + j, total - 1)
            q = orbit // n
            which[j], said[j], x[j] = q, 0, lanes[q, 0, orbit % n]
            c[0, j], c[1, j], c[2, j] = rows[q, 0], rows[q, 1], rows[q, 2]
        for _ in range(transient):
            for j in range(BESIDE):
                (x[j],), _letter, outcome = gap_step((x[j],), KIND(c[0, j], c[1, j], c[2, j]))
                said[j] |= outcome
        for _ in range(keep):
            for j in range(BESIDE):
                (x[j],), _letter, outcome = gap_step((x[j],), KIND(c[0, j], c[1, j], c[2, j]))
                said[j] |= outcome
            for j in range(BESIDE):
                part[j] = part_of(x[j], low, high, scale, bins)
            for j in range(width):
                counts[at(which[j]), at(part[j])] += 1
        for j in range(width):
            q = which[j]
            lanes[q, 0, (start + j) % n] = x[j]
            ended[q] += 0 if abs(x[j]) < INFINITY else 1
            ambiguous[q] += 1 if said[j] & AMBIGUOUS else 0


def boxes(rows: Any, boxes: Any) -> None:
    """Write where random starts are drawn, the same for all rows."""
    for q in range(rows.shape[0]):
        boxes[q, 0, 0], boxes[q, 0, 1] = LOW, HIGH


def gap_module() -> Module:
    """Return the module."""
    entries = [
        *common_entries(boxes, len(FIELDS), 1),
        *entries_of(loop_of(gap_step, None, KIND, 1), count, gap_tangent, None, KIND, 1),
        Entry(
            "edges", edges, ("periods",),
            (*arguments("""
                lam: float64  slope of the map for x < 0, 0 < lam < 1
                l: float64  size of the gap, l >= 0
                table: float64[periods, 3]  mu_gr, mu_pd and mu_bc of periods 1, 2, ...
            """),),
            meaning="the windows of the maximal orbits, Proposition 3.1",
        ),
    ]  # fmt: skip
    return Module(entries, tuple(PARAMETERS.values()), ("x",), "LR")
