"""Impact phases followed in a parameter: every zero of the closing equation as a curve from fold to fold."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing import late
from grazing.orbits.closure import TWO_PI
from grazing.orbits.survey import PHASE, SLOPE, V_MINUS, Family, extremum, survey

#: Roots are matched from one value to the next if none moves farther than this part of the smallest gap.
MOVE = 0.3
#: Part of the span, as far as it is not wider than so many natural sizes, at which halving stops. Nearer to a fold the
#: zeros of G drown in rounding; the extremum does not.
FINEST, WIDEST = 1e-10, 1e4
#: Zeros on either side of a cell that can be halved no further are the same within this phase.
NEAR = 0.01


class Edge(NamedTuple):
    """Where something ends: the value, its type, and how it was found (zero, bracket or span)."""

    value: float
    type: str
    status: str
    dip: int = 0


UNKNOWN = Edge(float("nan"), "end", "span")


@dataclass(eq=False)
class Curve:
    """One zero of the closing equation as a function of the parameter.

    ``values`` (n,) increase; ``rows`` (n, COLUMNS) are the columns of :mod:`grazing.orbits.survey` there. The curve
    ends at ``low`` and ``high``, which at a fold lie beyond the first and last value.
    """

    family: Family
    low: Edge
    values: list[float] = field(default_factory=list)
    rows: list[NDArray[np.float64]] = field(default_factory=list)
    high: Edge = field(default=UNKNOWN)

    def at(self, value: float) -> NDArray[np.float64]:
        """Return the row at any value on the curve; next to a fold, where the zero is lost, the nearest row."""
        i = min(max(bisect_left(self.values, value), 1), len(self.values) - 1)
        j = i - 1 if abs(value - self.values[i - 1]) <= abs(value - self.values[i]) else i
        if value == self.values[j] or not self.values[0] <= value <= self.values[-1]:
            return self.rows[j]
        lo, hi = self.rows[i - 1], self.rows[i]
        share = (value - self.values[i - 1]) / (self.values[i] - self.values[i - 1])
        guess = lo[PHASE] + share * wrapped(hi[PHASE] - lo[PHASE])
        table, counts = survey(self.family, np.array([value]))
        rows = table[0, : counts[0]]
        rows = rows[rows[:, SLOPE] * lo[SLOPE] > 0.0]
        if len(rows) == 0:
            return self.rows[j]
        nearest = int(np.argmin(np.abs(wrapped(rows[:, PHASE] - guess)))) if len(rows) > 1 else 0
        return np.asarray(rows[nearest])


def wrapped(phase: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return phases reduced to [-pi, pi]."""
    return np.asarray(phase - TWO_PI * np.round(np.asarray(phase) / TWO_PI))


def matching(a: NDArray[np.float64], b: NDArray[np.float64]) -> list[list[tuple[int, int]] | None]:
    """Match the zeros at either end of each cell one to one, in cyclic order and by the sign of the slope.

    Parameters
    ----------
    a, b : ndarray, shape (cells, n, COLUMNS)
        In increasing phase.

    Returns
    -------
    list
        The pairs of each cell; None where they are unclear.
    """
    cells, n = a.shape[:2]
    if n == 0:
        return [[] for _ in range(cells)]
    gap = np.full(cells, TWO_PI)
    for rows in (a, b):
        phases = rows[:, :, PHASE]
        around = np.concatenate([phases, phases[:, :1] + TWO_PI], axis=1)
        gap = np.minimum(gap, np.diff(around, axis=1).min(axis=1))
    shift = np.argmin(np.abs(wrapped(b[:, :, PHASE] - a[:, :1, PHASE])), axis=1)
    after = (np.arange(n) + shift[:, None]) % n
    there = b[np.arange(cells)[:, None], after]
    moved = np.abs(wrapped(there[:, :, PHASE] - a[:, :, PHASE])).max(axis=1)
    unclear = (moved >= MOVE * gap) | (there[:, :, SLOPE] * a[:, :, SLOPE] < 0.0).any(axis=1)
    return [
        None if lost else list(enumerate(places)) for lost, places in zip(unclear.tolist(), after.tolist(), strict=True)
    ]


def matched(table: NDArray[np.float64], counts: NDArray[np.int64]) -> list[list[tuple[int, int]] | None]:
    """Match the zeros of a survey from each value to the next; None where they are unclear."""
    found: list[list[tuple[int, int]] | None] = [None] * (len(counts) - 1)
    for n in np.unique(counts):
        cells = np.flatnonzero((counts[:-1] == n) & (counts[1:] == n))
        for i, pairs in zip(cells.tolist(), matching(table[cells, :n], table[cells + 1, :n]), strict=True):
            found[i] = pairs
    return found


def survivors(a: NDArray[np.float64], b: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Match across a bracket that can be halved no further: mutually nearest zeros with slopes of one sign."""
    if len(a) == 0 or len(b) == 0:
        return []
    away = np.abs(wrapped(b[None, :, PHASE] - a[:, None, PHASE]))
    away[a[:, None, SLOPE] * b[None, :, SLOPE] < 0.0] = np.inf
    pairs = [(i, int(np.argmin(away[i]))) for i in range(len(a))]
    return [(i, j) for i, j in pairs if away[i, j] < NEAR and int(np.argmin(away[:, j])) == i]


def curves(family: Family, values: NDArray[np.float64], size: float) -> list[Curve]:
    """Return every zero of the closing equation over a span as curves.

    Parameters
    ----------
    family : Family
    values : ndarray, shape (n,)
        Increasing. Cells are halved where zeros appear, disappear or move too far to be told apart; what can be
        missed is a pair of zeros that is born and dies within one cell.
    size : float
        A natural size of what varies.
    """
    table, counts = survey(family, values)
    nodes = [(float(value), table[i, : counts[i]]) for i, value in enumerate(values)]
    known = {(nodes[i][0], nodes[i + 1][0]): pairs for i, pairs in enumerate(matched(table, counts))}
    done: list[Curve] = []
    current = [Curve(family, Edge(nodes[0][0], "end", "span"), [nodes[0][0]], [row]) for row in nodes[0][1]]
    todo = nodes[:0:-1]
    here = nodes[0]
    smallest = FINEST * min(float(values[-1] - values[0]), WIDEST * size)
    while todo:
        there = todo[-1]
        cell = here[0], there[0]
        if cell not in known:
            alike = len(here[1]) == len(there[1])
            known[cell] = matching(here[1][None], there[1][None])[0] if alike else None
        pairs = known[cell]
        middle = 0.5 * (here[0] + there[0])
        if pairs is None and here[0] < middle < there[0] and there[0] - here[0] > smallest:
            rows, n = survey(family, np.array([middle]))
            todo.append((middle, rows[0, : n[0]]))
            continue
        if pairs is None:
            pairs = survivors(here[1], there[1])
        after: dict[int, Curve] = {}
        for i, j in pairs:
            current[i].values.append(there[0])
            current[i].rows.append(there[1][j])
            after[j] = current[i]
        kept = {i for i, _ in pairs}
        lost = [i for i in range(len(here[1])) if i not in kept]
        for i, edge in zip(lost, ends(family, here, there, lost), strict=True):
            current[i].high = edge
            done.append(current[i])
        born = [j for j in range(len(there[1])) if j not in after]
        for j, edge in zip(born, ends(family, there, here, born), strict=True):
            after[j] = Curve(family, edge, [there[0]], [there[1][j]])
        current = [after[j] for j in range(len(there[1]))]
        here = todo.pop()
    for curve in current:
        curve.high = Edge(here[0], "end", "span")
    return sorted([*done, *current], key=lambda curve: curve.low.value)


Node = tuple[float, NDArray[np.float64]]


def ends(family: Family, inside: Node, outside: Node, unmatched: list[int]) -> list[Edge]:
    """Return where zeros that exist at ``inside`` and not at ``outside`` end: neighbours together at a fold."""
    edges = []
    for i in unmatched:
        row, rows = inside[1][i], inside[1]
        partners = [rows[j] for j in unmatched if rows[j, SLOPE] * row[SLOPE] < 0.0]
        apart = [float(wrapped(other[PHASE] - row[PHASE])) for other in partners]
        nearest = min(apart, key=abs, default=np.inf)
        value = fold(family, inside[0], outside[0], row[PHASE] + 0.5 * nearest) if abs(nearest) < 0.5 else None
        if value is None:
            edges.append(broken(family, inside, outside[0], i))
        else:  # where all flights close, as at a resonance without damping, G is 0 at all phases
            beyond = value + 4.0 * (outside[0] - inside[0])
            edges.append(Edge(value, "v0" if passed(family, row, beyond) else "lp", "zero"))
    return edges


def passed(family: Family, row: NDArray[np.float64], beyond: float) -> bool:
    """Return whether a zero goes on at a value beyond its end, with a speed of the other sign."""
    table, counts = survey(family, np.array([beyond]))
    rows = table[0, : counts[0]]
    near = np.abs(wrapped(rows[:, PHASE] - row[PHASE])) < NEAR
    return bool((near & (rows[:, V_MINUS] * row[V_MINUS] < 0.0)).any())


def broken(family: Family, inside: Node, outside: float, i: int) -> Edge:
    """Return where zero i of ``inside`` ends without a fold, by halving to the last bit: as all forces vanish, say."""
    value, rows = inside
    row = rows[i]
    for _ in range(100):
        middle = 0.5 * (value + outside)
        table, counts = survey(family, np.array([middle]))
        pairs = dict(survivors(row[None, :], table[0, : counts[0]]))
        if 0 in pairs:
            value, row = middle, table[0, pairs[0]]
        else:
            outside = middle
    slow = abs(row[V_MINUS]) <= 1e-6 * abs(rows[i, V_MINUS])
    return Edge(value, "v0" if slow else "lp", "bracket")


def fold(family: Family, inside: float, outside: float, guess: float) -> float | None:
    """Return where an extremum of G crosses 0, between a value with two zeros and one with none; None if nowhere.

    A pair of zeros closer than 1e-7 of a turn is dropped by the search, so the fold may lie a little farther out.
    """

    def height(value: float) -> float:
        return extremum(family, value, guess)[1]

    start, reach = height(inside), outside - inside
    for _ in range(12):
        if start * height(inside + reach) <= 0.0:
            low, high = sorted((inside, inside + reach))
            return float(late.optimize.brentq(height, low, high, xtol=1e-18 * abs(reach), rtol=1e-15, maxiter=300))
        reach *= 8.0
    return None
