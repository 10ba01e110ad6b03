"""What differences in place of derivatives can do to the exponents of a cycle: all of them, beside its maximum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grazing.maps.derivative import KINK, STEP, units_of
from grazing.maps.map import Map

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Points of cycles that are looked at together.
TOGETHER = 100_000


def error_of_cycles(P: Map, rows: Floats, points: Floats, periods: Ints, arithmetic: str) -> Floats:
    """Return the errors (n, dim) that differences leave in the exponents of cycles, the greatest exponent first.

    Each slope is moved by its rounding and by what it changes with twice the step: all up, in turns up and down, and
    both of their sizes, as slopes of either sign that all go up hardly change a product.

    Parameters
    ----------
    P : Map
    rows : ndarray, shape (n, parameters)
    points : ndarray, shape (n, keep, dim)
        The last points of orbits on cycles.
    periods : ndarray of int, shape (n,)
    arithmetic : {"fast", "strict"}
        That in which the map is compiled already.
    """
    n, _keep, d = points.shape
    found, at = np.zeros((n, d)), 0
    most = max(1, TOGETHER // max(1, int(periods.max(initial=1))))
    while at < n:
        some = slice(at, at + most)
        found[some] = _errors(P, rows[some], points[some], periods[some], arithmetic)
        at += most
    return found


def _errors(P: Map, rows: Floats, points: Floats, periods: Ints, arithmetic: str) -> Floats:
    n, keep, d = points.shape
    longest = int(periods.max())
    here = np.arange(longest) < periods[:, None]
    cycle, step = np.nonzero(here)
    x = points[cycle, keep - periods[cycle] + step]
    slopes, doubt = slopes_of(P, rows[cycle], x, arithmetic)
    turn = np.where(np.indices((d, d)).sum(axis=0) % 2 == 0, 1.0, -1.0)
    plain, moved = np.tile(np.eye(d), (n, 1, 1)), np.tile(np.eye(d), (8, n, 1, 1))
    ways = np.array([np.ones((d, d)), -np.ones((d, d)), turn, -turn])[:, None]
    moves = np.concatenate([ways * doubt, ways * np.copysign(doubt, slopes)])
    with np.errstate(divide="ignore", invalid="ignore"):
        for k in range(longest):
            now, which = cycle[step == k], np.flatnonzero(step == k)
            plain[now] = slopes[which] @ plain[now]
            moved[:, now] = (slopes[which] + moves[:, which]) @ moved[:, now]
            size = np.abs(plain[now]).max(axis=(1, 2))[:, None, None]
            size = np.where(size > 0.0, size, 1.0)  # of both the same: only their ratio counts
            plain[now], moved[:, now] = plain[now] / size, moved[:, now] / size
        logs = [np.log(_moduli(M)) for M in (plain, *moved)]
        return np.asarray(np.max([np.abs(one - logs[0]) for one in logs[1:]], axis=0) / periods[:, None])


def _moduli(M: Floats) -> Floats:
    finite = np.isfinite(M).all(axis=(1, 2))
    found = np.full(M.shape[:2], np.nan)
    found[finite] = -np.sort(-np.abs(np.linalg.eigvals(M[finite])), axis=1)
    return found


def slopes_of(P: Map, rows: Floats, x: Floats, arithmetic: str) -> tuple[Floats, Floats]:
    """Return slopes (m, dim, dim) at states (m, dim) by differences, and by how much each may be wrong."""
    d = x.shape[1]
    h = STEP * np.maximum(units_of(P.box), np.abs(x))
    ahead = np.concatenate([shift * np.eye(d) for shift in (0.0, 1.0, -1.0, 2.0, -2.0)])[d - 1 :]
    lanes = (x[:, None] + ahead * h[:, None]).transpose(0, 2, 1)
    seen = P.run_columns(rows, np.ascontiguousarray(lanes), 0, 1, arithmetic=arithmetic, threads=1)
    images = seen.points[:, 0]  # (m, dim, 4 dim + 1)
    alike = (seen.letters[:, 0] == seen.letters[:, 0, :1])[:, None]
    new, rest, alike = images[:, :, :1], images[:, :, 1:], alike[:, :, 1:]
    slopes = []
    for k in (0, 2):
        parts = [slice(d * (k + one), d * (k + one + 1)) for one in (0, 1)]
        up, down = rest[:, :, parts[0]] - new, new - rest[:, :, parts[1]]
        bent = np.abs(up - down) > KINK * np.maximum(np.abs(up), np.abs(down))
        sided = bent & (alike[:, :, parts[0]] != alike[:, :, parts[1]])
        both = np.where(sided, 2.0 * np.where(alike[:, :, parts[0]], up, down), up + down)
        slopes.append(both / ((k + 2.0) * h[:, None]))
    rounding = np.finfo(float).eps * np.maximum(np.array(units_of(P.box))[:, None], np.abs(new)) / h[:, None]
    return slopes[0], rounding + np.abs(slopes[1] - slopes[0])
