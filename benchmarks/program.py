"""What a program under test looks like, and what is said of one that is not there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from math import cos, sin
from typing import Any

import numpy as np

from .models import Array, Columns, Model

#: ``program(columns, transient, keep) -> (u, v)``: the kept strobe states of all orbits, shape (columns, keep, starts).
Program = Callable[[Columns, int, int], tuple[Array, Array]]

#: ``follow(d, u, v, times) -> states``: one orbit from time 0, its states (2, len(times)) at the strobes asked for.
Follow = Callable[[float, float, float, Array], Array]

#: Tolerances of the peers that ask for some.
RTOL, ATOL = 1e-9, 1e-12


class Missing(Exception):
    """A program that cannot run here; the message says why, and what to do."""


def peer(name: str) -> Any:
    """Import a package that only the benchmarks need."""
    try:
        return import_module(name)
    except ModuleNotFoundError:
        raise Missing("not installed: pip install 'grazing[bench]'") from None


@contextmanager
def foreign() -> Iterator[None]:
    """Turn a failure of somebody else's program into a row that says so; the other rows go on."""
    try:
        yield
    except Missing:
        raise
    except Exception as error:
        raise Missing(f"failed: {summary(error)}") from error


def summary(error: Exception) -> str:
    """Return an error in one line."""
    lines = str(error).strip().splitlines() or [""]
    return f"{type(error).__name__}: {lines[0]}"


def strobes(model: Model, transient: int, keep: int) -> Array:
    """Return the times of the strobes that are kept."""
    times: Array = np.arange(transient + 1, transient + keep + 1, dtype=np.float64) * model.period
    return times


def one_by_one(model: Model, follow: Follow) -> Program:
    """Return the program that follows each orbit on its own."""

    def program(columns: Columns, transient: int, keep: int) -> tuple[Array, Array]:
        times = strobes(model, transient, keep)
        count, starts = columns.u.shape
        states = np.empty((2, count, keep, starts))
        for i, j in np.ndindex(count, starts):
            states[:, i, :, j] = follow(float(columns.d[i]), float(columns.u[i, j]), float(columns.v[i, j]), times)
        return states[0], states[1]

    return program


def in_lanes(
    advance: Callable[[Array, Array, Array], Array], columns: Columns, keep: int, width: int
) -> tuple[Array, Array]:
    """Deal the orbits in their order to batches of one width; the last batch is filled up with the last orbit.

    ``advance(d, u, v)`` takes one batch, each (width,), and returns its states (keep, 2, width).
    """
    count, starts = columns.u.shape
    total = count * starts
    order = np.minimum(np.arange(-(-total // width) * width), total - 1).reshape(-1, width)
    d, u, v = np.repeat(columns.d, starts), columns.u.ravel(), columns.v.ravel()
    found = np.concatenate([advance(d[lanes], u[lanes], v[lanes]) for lanes in order], axis=2)[:, :, :total]
    states = found.reshape(keep, 2, count, starts).transpose(1, 2, 0, 3)
    return states[0], states[1]


def force(model: Model) -> Callable[[float, float], float]:
    """Return the forcing f(t, d) in plain Python."""
    waves = model.waves
    if waves == [(model.omega, 1.0, 0.0)]:  # written out, as anybody would
        omega = model.omega
        return lambda t, d: d + cos(omega * t)
    return lambda t, d: d + sum(c * cos(w * t) + s * sin(w * t) for w, c, s in waves)
