"""The gap map, and the limit it is held to: nothing but square roots, on as many numbers, in as wide registers."""

from __future__ import annotations

import re
from functools import cache
from math import sqrt
from typing import Any

import numba
import numpy as np

import grazing as gz

from .ours import rows_of, run_columns
from .row import Job

COLUMNS, STARTS, ITERATES = 15, 8192, 1200
LANES = 64  # numbers worked on together, as in the library


@cache
def roots() -> Any:
    """Return the compiled loop of square roots: LANES independent ones at a time, in the first-level cache."""

    def loop(x: Any, count: int) -> None:
        lanes = np.empty(LANES)
        for start in range(0, len(x), LANES):
            for j in range(LANES):
                lanes[j] = x[start + j]
            for _ in range(count):
                for j in range(LANES):
                    lanes[j] = sqrt(lanes[j]) + 0.5  # the sum costs nothing and keeps the numbers from becoming 1
            for j in range(LANES):
                x[start + j] = lanes[j]

    return numba.njit("void(float64[::1], int64)", error_model="numpy")(loop)


def vector_bits() -> int:
    """Return how many bits wide the square roots of the compiled loop are; 0 if it takes one number at a time."""
    (code,) = roots().inspect_asm().values()
    widths = {"zmm": 512, "ymm": 256, "xmm": 128}
    packed = re.findall(r"sqrtpd.*%(zmm|ymm|xmm)", code)
    return max((widths[register] for register in packed), default=128 if re.search(r"fsqrt.*\.2d", code) else 0)


def roots_job() -> Job:
    """Make the square roots ready."""
    x = np.random.default_rng(0).random(COLUMNS * STARTS)
    loop = roots()
    return Job(lambda: loop(x, ITERATES), x.size * ITERATES, note=f"{vector_bits()}-bit registers")


def map_job(arithmetic: str) -> Job:
    """Make the gap map ready: one mu a column."""
    G = gz.gap_map(lam=0.34, mu=0.05, l=0.21)
    mu = np.linspace(0.0, 0.2, COLUMNS)
    starts = np.random.default_rng(0).uniform(-1.0, 1.0, (len(mu), 1, STARTS))
    rows = rows_of(G, "mu", mu)

    def run() -> None:
        run_columns(G, rows, starts.copy(), ITERATES, 0, arithmetic, "scalar", 1)

    return Job(run, starts.size * ITERATES)
