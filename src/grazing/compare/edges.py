"""Windows on a rung: the stretches of a branch on which the orbit is stable and has its word, with typed edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing import late
from grazing.compare.branches import Point, Rung

Floats = NDArray[np.float64]
KINDS = ("pd", "lp", "ns")


class Edge(NamedTuple):
    """An end of a window: parameter value, type, the dip that touches the wall (1 the last, 0 none), the orbit."""

    value: float
    type: str
    dip: int
    point: Point


class Window(NamedTuple):
    """A window between two edges, in the order of the impact speed."""

    slow: Edge
    fast: Edge


def march(rung: Rung, speeds: Sequence[float], start: int, near: Point | None) -> list[Point]:
    """Return the orbits of a branch at rising speeds, as far as they are found to both sides of ``speeds[start]``."""
    first = rung.at(speeds[start], near)
    if first is None:
        return []
    found = [first]
    for s in speeds[start + 1 :]:
        point = rung.at(s, found[-1])
        if point is None:
            break
        found.append(point)
    for s in reversed(speeds[:start]):
        point = rung.at(s, found[0])
        if point is None:
            break
        found.insert(0, point)
    return found


def heights(point: Point) -> Floats:
    """Return all test functions of an orbit: pd, lp, ns, then the points left of the border."""
    return np.concatenate([point.tests, point.left])


def windows_on(rung: Rung, branch: list[Point]) -> list[Window]:
    """Return all windows along a branch, edges to the last bits of the speed."""
    if len(branch) < 2:
        return []
    zeros: list[Edge] = []
    table = np.array([heights(point) for point in branch])
    for (i, j), low, high in zip(pairwise(range(len(branch))), branch, branch[1:], strict=False):
        for column in np.flatnonzero((table[i] > 0.0) != (table[j] > 0.0)).tolist():
            point = _zero(rung, low, high, lambda p, column=column: float(heights(p)[column]))  # type: ignore[misc]
            if point is not None:
                zeros.append(_edge(rung, point, column))
    zeros.sort(key=lambda edge: edge.point.s)
    ends = [Edge(point.value, "end", 0, point) for point in (branch[0], branch[-1])]
    found: list[Window] = []
    for low_edge, high_edge in pairwise([ends[0], *zeros, ends[1]]):
        middle = rung.at(0.5 * (low_edge.point.s + high_edge.point.s), low_edge.point)
        if middle is None or not (heights(middle) > 0.0).all() or high_edge.point.s <= low_edge.point.s:
            continue
        if found and found[-1].fast is low_edge:  # a zero that changes nothing: the others decide
            found[-1] = Window(found[-1].slow, high_edge)
        else:
            found.append(Window(low_edge, high_edge))
    return found


def _edge(rung: Rung, point: Point, column: int) -> Edge:
    """Return the edge at which one test function is zero."""
    if column < len(KINDS):
        return Edge(point.value, KINDS[column], 0, point)
    return Edge(point.value, "gr", rung.N - 1 - (column - len(KINDS)), point)


def _zero(rung: Rung, low: Point, high: Point, height: Callable[[Point], float]) -> Point | None:
    """Return the orbit between two at which a test function is zero, or None where the branch is lost."""
    nearest = {low.s: low, high.s: high}

    def at(s: float) -> float:
        if s not in nearest:
            guess = min(nearest.values(), key=lambda point: abs(point.s - s))
            point = rung.at(s, guess)
            if point is None:
                raise ArithmeticError
            nearest[s] = point
        return height(nearest[s])

    try:
        s = float(late.optimize.brentq(at, low.s, high.s, xtol=1e-300, rtol=8.9e-16, maxiter=200))
        at(s)
    except (ArithmeticError, RuntimeError):
        return None
    return nearest[s]
