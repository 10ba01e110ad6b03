"""What a study costs beside the kernel it runs: diagrams, densities and charts at the size of a page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from statistics import median
from time import perf_counter

import numpy as np
from rich.console import Console
from rich.table import Table

import grazing as gz


@dataclass(frozen=True)
class Study:
    """A study, and the bare kernel run that it cannot do without.

    Parameters
    ----------
    name : str
    run, bare : callable
        Each does the whole work once.
    steps : float
        Steps of the map that both make.
    """

    name: str
    run: Callable[[], object]
    bare: Callable[[], object]
    steps: float


@dataclass(frozen=True)
class Cost:
    """Seconds of a study and of its bare kernel, medians over the rounds, and the median of their ratio."""

    name: str
    steps: float
    seconds: float
    bare: float
    ratio: float


def studies(share: float = 1.0) -> list[Study]:
    """Return the studies; ``share`` of their cells along each axis."""
    P, G = gz.stroboscopic_map(gz.pinball(V=0.4)), gz.gap_map(lam=0.5, mu=0.1, l=0.1)

    def many(count: int) -> int:
        return max(10, round(count * share))

    d, V, mu, lam = (0.05, 0.16), (0.0, 0.6), (0.0, 0.3), (0.1, 0.95)
    n, square, small = many(2000), many(1000), many(400)
    return [
        Study(
            f"density of the oscillator, {n} values, 100 starts, 200 + 500 periods",
            partial(gz.density, P, "d", np.linspace(*d, n), bins=1000),
            bare(P, {"d": np.linspace(*d, n)}, 100, 200, 500),
            n * 100 * 700,
        ),
        Study(
            f"diagram of the oscillator, {n} values, 20 starts, 200 + 50 periods",
            partial(gz.orbit_diagram, P, "d", np.linspace(*d, n), starts=20),
            bare(P, {"d": np.linspace(*d, n)}, 20, 200, 50),
            n * 20 * 250,
        ),
        Study(
            f"chart of the oscillator, {small} x {small}, 8 starts, 500 + 64 periods",
            partial(gz.chart, P, {"d": np.linspace(*d, small), "V": np.linspace(*V, small)}),
            bare(P, {"d": np.linspace(*d, small), "V": np.linspace(*V, small)}, 8, 500, 64),
            small**2 * 8 * 564,
        ),
        Study(
            f"chart of the gap map, {square} x {square}, 8 starts, 500 + 64 steps",
            partial(gz.chart, G, {"mu": np.linspace(*mu, square), "lam": np.linspace(*lam, square)}),
            bare(G, {"mu": np.linspace(*mu, square), "lam": np.linspace(*lam, square)}, 8, 500, 64),
            square**2 * 8 * 564,
        ),
    ]


def bare(P: gz.Map, axes: dict[str, np.ndarray], starts: int, transient: int, keep: int) -> Callable[[], object]:
    """Return what only runs the kernel: the same steps from random starts, points kept and dropped in large parts."""
    grids = np.meshgrid(*axes.values(), indexing="ij")
    rows = np.tile(list(P.params.values()), (grids[0].size, 1))
    for name, grid in zip(axes, grids, strict=True):
        rows[:, list(P.params).index(name)] = grid.ravel()
    low, high = np.array(P.box).T[:, None, :, None]
    part = max(1, 40_000_000 // (starts * keep * (P.dimension + 1)))

    def run() -> None:
        random = np.random.default_rng(0)
        for first in range(0, len(rows), part):
            some = rows[first : first + part]
            lanes = low + (high - low) * random.random((len(some), P.dimension, starts))
            P.run_columns(some, lanes.reshape(len(some), P.dimension, starts), transient, keep)

    return run


def cost(rounds: int, share: float, tell: Callable[[str], None]) -> list[Cost]:
    """Time every study beside its bare kernel, interleaved, after a first time that compiles."""
    for study in studies(0.01):
        tell(f"compiling: {study.name}")
        study.run()
        study.bare()
    times: dict[str, list[tuple[float, float]]] = {}
    chosen = studies(share)
    for i in range(rounds):
        for study in chosen:
            tell(f"round {i + 1} of {rounds}: {study.name}")
            times.setdefault(study.name, []).append((timed(study.run), timed(study.bare)))
    return [
        Cost(
            study.name,
            study.steps,
            median(a for a, _b in times[study.name]),
            median(b for _a, b in times[study.name]),
            median(a / b for a, b in times[study.name]),
        )
        for study in chosen
    ]


def timed(work: Callable[[], object]) -> float:
    """Return the seconds that some work takes."""
    before = perf_counter()
    work()
    return perf_counter() - before


def show_costs(out: Console, costs: list[Cost]) -> None:
    """Print the table."""
    table = Table(title="Studies, on all processors", title_justify="left")
    for heading in ("study", "seconds", "bare kernel", "ratio"):
        table.add_column(heading, justify="left" if heading == "study" else "right")
    for one in costs:
        table.add_row(one.name, f"{one.seconds:.2f}", f"{one.bare:.2f}", f"{one.ratio:.2f}")
    out.print(table)
