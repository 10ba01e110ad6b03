"""The library itself: the one place that knows how its kernels are entered."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

import grazing as gz
from grazing.maps.map import Map

from .models import Array, Columns, Model
from .program import Missing, Program


def run_columns(
    P: Map, rows: Array, lanes: Array, transient: int, keep: int, arithmetic: str, algorithm: str, threads: int
) -> Array:
    """Return the kept points (columns, keep, dim, starts).

    ``rows`` (columns, params) holds parameters in the order of P.params; ``lanes`` (columns, dim, starts) holds the
    starts and is overwritten.
    """
    if hasattr(P, "run_columns"):
        found: Any = P.run_columns(
            rows, lanes, transient, keep, arithmetic=arithmetic, algorithm=algorithm, threads=threads
        )
        return found[0]  # type: ignore[no-any-return]
    if algorithm == "block":
        raise Missing("this version of grazing has no block kernel")
    return one_map_a_column(P, rows, lanes, transient, keep, arithmetic, threads)


def one_map_a_column(
    P: Map, rows: Array, lanes: Array, transient: int, keep: int, arithmetic: str, threads: int
) -> Array:
    """Do the same with :meth:`Map.run`, column by column."""

    def column(i: int) -> Array:
        Q = P.replace(**dict(zip(P.params, rows[i].tolist(), strict=True)))
        return Q.run(lanes[i], transient, keep, arithmetic=arithmetic)[0]

    with ThreadPoolExecutor(threads) as pool:
        return np.stack(list(pool.map(column, range(len(rows)))))


def rows_of(P: Map, name: str, values: Sequence[float] | Array) -> Array:
    """Return the parameters of P, row by row, with one of them varied."""
    rows = np.tile(np.array(list(P.params.values())), (len(values), 1))
    rows[:, list(P.params).index(name)] = values
    return rows


def bumper(v: float, p: Any) -> float:
    """Kick like the built-in law; as a law of the user's own it must be compiled by itself."""
    return p.V - p.r * v  # type: ignore[no-any-return]


def oscillator(model: Model, own_law: bool = False) -> gz.Oscillator:
    """Return a model in the words of the library."""
    law = gz.reset(bumper, r=model.r, V=model.V) if own_law else gz.active(r=model.r, V=model.V)
    forcing = gz.Forcing(omega=model.omega, cos=model.cos, sin=model.sin)
    if model.gap is not None:
        walls = gz.wall(0.0, law), gz.wall(model.gap, law)
        return gz.Oscillator(model.alpha, model.k, forcing, walls=walls)  # type: ignore[call-arg]
    return gz.Oscillator(alpha=model.alpha, k=model.k, forcing=forcing, reset=law)


def program_of(
    model: Model, arithmetic: str = "fast", algorithm: str = "block", threads: int = 1, own_law: bool = False
) -> Program:
    """Return the stroboscopic map of the library as a program."""
    P = gz.stroboscopic_map(oscillator(model, own_law))

    def program(columns: Columns, transient: int, keep: int) -> tuple[Array, Array]:
        lanes = np.stack([columns.u, columns.v], axis=1)
        points = run_columns(P, rows_of(P, "offset", columns.d), lanes, transient, keep, arithmetic, algorithm, threads)
        return points[:, :, 0], points[:, :, 1]

    return program
