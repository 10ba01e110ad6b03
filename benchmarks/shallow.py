"""Which solvers see a real, shallow impact.

The steady response of a weakly damped oscillator dips below the wall once a period, by ``depth`` times its
amplitude. Orbits start on it at random phases, so every one of them hits the wall within a period.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from rich.console import Console

from .finders import ALPHA, FINDERS, OMEGA, PERIOD, K, Sees
from .models import Array
from .program import Missing, foreign
from .table import show

GAIN = 1.0 / complex(K**2 - OMEGA**2, ALPHA * OMEGA)  # of the steady response
DEPTHS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)


class Shallow(NamedTuple):
    """The shares of impacts that a solver sees, by depth, or why there are none."""

    name: str
    shares: list[float]
    missing: str = ""


def starts(d: float, count: int) -> tuple[Array, Array, Array]:
    """Return random times and the states of the steady response there, all well above the wall."""
    times = np.random.default_rng(0).uniform(0.0, PERIOD, 4 * count)
    turning = GAIN * np.exp(1j * OMEGA * times)
    u, v = d / K**2 + turning.real, (1j * OMEGA * turning).real
    above = np.flatnonzero(u > 0.5 * abs(GAIN))[:count]
    return times[above], u[above], v[above]


def shallow(names: Sequence[str], count: int, tell: Callable[[str], None]) -> list[Shallow]:
    """Return the share of shallow impacts that each finder sees."""
    found = []
    for name in names:
        tell(f"shallow impacts: {name}")
        try:
            with foreign():
                sees = FINDERS[name]()
                found.append(Shallow(name, [share(sees, depth, count) for depth in DEPTHS]))
        except Missing as reason:
            found.append(Shallow(name, [], str(reason)))
    return found


def share(sees: Sees, depth: float, count: int) -> float:
    """Return the share of impacts of one depth that are seen."""
    d = K**2 * abs(GAIN) * (1.0 - depth)
    return float(np.mean([sees(d, *map(float, start)) for start in zip(*starts(d, count), strict=True)]))


def show_shares(out: Console, found: Sequence[Shallow], count: int) -> None:
    """Print the shares of shallow impacts seen."""
    head = ("solver, relative tolerance", *(f"{depth:.0e}".replace("e-0", "e-") for depth in DEPTHS))
    lines = [
        (s.name, *(f"{x:.2f}" for x in s.shares)) if s.shares else (f"{s.name} ({s.missing})", *("",) * len(DEPTHS))
        for s in found
    ]
    show(out, f"Share of shallow impacts seen, by depth in amplitudes, {count} random phases each", head, lines)
