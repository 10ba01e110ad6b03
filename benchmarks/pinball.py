"""Collisions a second on pinball tables: a box of 6 x 10 under g = 1 with discs of radius 0.5, all impacts counted.

Beside this library, with every decision proven: a plain loop for such tables alone, disc by disc, and the same with
packed instructions in C++; neither accounts for rounding. Processor time is compared, in interleaved rounds.
"""

from __future__ import annotations

import atexit
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil, pi, sqrt
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import numpy as np
from rich.console import Console

from .engines import CORNERS, HEIGHT, RADIUS, WIDTH, Hits, Program, in_billiards, in_box2d, in_pymunk, judged, pass_over
from .engines import DISC as PASSED
from .measure import Tell
from .models import Array
from .program import Missing, foreign
from .table import show

ENERGY = 12.0
DISCS = (3, 8, 24)
#: So many impacts that what a call costs beside them, which the C++ program does not count, is below a hundredth.
LAUNCHES, HITS = 64, 40_000
SOURCE = Path(__file__).parent / "peers" / "pinball.cpp"
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math")


@dataclass(frozen=True)
class Rate:
    """Millions of collisions a second by the number of discs, the median of the rounds, or why there are none.

    ``passes`` says how many passes by a disc are missed, and how many are taken for impacts that are none.
    """

    name: str
    rates: dict[int, float] = field(default_factory=dict)
    missing: str = ""
    passes: str = ""


def places(count: int) -> Array:
    """Return the centres of discs, in shifted rows."""
    nx = ceil(sqrt(count * WIDTH / HEIGHT))
    ny = ceil(count / nx)
    found = [
        ((i + 0.5 + 0.25 * (j % 2)) * WIDTH / (nx + 0.25), (j + 0.5) * HEIGHT / ny)
        for j in range(ny)
        for i in range(nx)
    ]
    return np.array(found[:count])


def table_of(centres: Array) -> Any:
    """Return the table with discs there."""
    import grazing as gz

    law = gz.newton(1.0)
    walls = [gz.segment(f"wall{i}", CORNERS[i], CORNERS[(i + 1) % 4], law) for i in range(4)]
    discs = [gz.disc(f"disc{i}", place, RADIUS, law) for i, place in enumerate(centres.tolist())]
    return gz.table([*discs, *walls], tilt=0.5 * pi)


def launches() -> tuple[Program, Hits]:
    """Return the flights of :func:`grazing.launches`: no ball leaves the box."""
    import grazing as gz

    y = HEIGHT - 0.2
    speed, angle = sqrt(2.0 * (ENERGY - y)), np.linspace(0.1, 6.1, LAUNCHES)

    def program(count: int, share: float) -> float:
        table, hits = table_of(places(count)), max(round(HITS * share), 1)
        before = process_time()
        found = gz.launches(table, (0.2, y), angle, speed, hits=hits, threads=1)
        return float(found.hits.sum()) / (process_time() - before)

    table = table_of(np.array([PASSED]))

    def hits(depth: float) -> bool:
        state = pass_over(depth)
        return bool((gz.trajectory(table, state, until=1.2, samples=2).impact_wall == "disc0").any())

    return program, hits


def collisions() -> tuple[Program, None]:
    """Return the map from impact to impact, as studies run it."""
    import grazing as gz

    def program(count: int, share: float) -> float:
        P, steps = gz.collision_map(table_of(places(count))), max(round(HITS * share), 1)
        lanes = np.array([np.full(LAUNCHES, 0.1), np.linspace(-1.4, 1.4, LAUNCHES), np.full(LAUNCHES, 3.0)])
        before = process_time()
        P.run(lanes, steps, 0, arithmetic="fast")
        return LAUNCHES * steps / (process_time() - before)

    return program, None


def plain() -> tuple[Program, Hits]:
    """Return a loop for discs in a box alone, each disc marched to by itself."""
    import numba

    @numba.njit(error_model="numpy", fastmath={"contract"})  # type: ignore[untyped-decorator]
    def fly(states: Array, centres: Array, hits: int) -> None:  # pragma: no cover
        R2 = RADIUS * RADIUS
        for b in range(states.shape[0]):
            x, y, u, w = states[b]
            for _ in range(hits):
                T, kind = np.inf, -1
                if u != 0.0:
                    T, kind = ((WIDTH - x) if u > 0.0 else -x) / u, 0
                t = w + np.sqrt(w * w + 2.0 * max(y, 0.0))
                if t < T:
                    T, kind = t, 1
                D = w * w - 2.0 * (HEIGHT - y)
                if w > 0.0 and D >= 0.0:
                    t = 2.0 * (HEIGHT - y) / (w + np.sqrt(D))
                    if t < T:
                        T, kind = t, 2
                for j in range(centres.shape[0]):
                    dx, dy, t = x - centres[j, 0], y - centres[j, 1], 0.0
                    if (dx > RADIUS and dx + u * T > RADIUS) or (dx < -RADIUS and dx + u * T < -RADIUS):
                        continue
                    a3, a2 = -w, u * u + w * w - dy
                    a1, a0 = 2.0 * (dx * u + dy * w), dx * dx + dy * dy - R2
                    for _look in range(200):
                        q = (((0.25 * t + a3) * t + a2) * t + a1) * t + a0
                        rate = ((t + 3.0 * a3) * t + 2.0 * a2) * t + a1
                        low = min(max(w, t), T)
                        k = (3.0 * low + 6.0 * a3) * low + 2.0 * a2
                        if q <= 1e-15 and rate < 0.0:
                            T, kind = t, 3 + j
                            break
                        q = max(q, 0.0)
                        D = rate * rate - 2.0 * k * q
                        if D < 0.0 or (k >= 0.0 and rate >= 0.0):
                            break
                        s = 2.0 * q / (np.sqrt(D) - rate) if rate < 0.0 else -(rate + np.sqrt(D)) / k
                        t += s
                        if t >= T:
                            break
                        if s <= 1e-15 * max(1.0, t):
                            T, kind = t, 3 + j
                            break
                x, y, w = x + u * T, y + (w - 0.5 * T) * T, w - T
                if kind == 0:
                    x, u = (WIDTH if u > 0.0 else 0.0), -u
                elif kind < 3:
                    y, w = (0.0 if kind == 1 else HEIGHT), -w
                else:
                    nx, ny = x - centres[kind - 3, 0], y - centres[kind - 3, 1]
                    r = 1.0 / np.sqrt(nx * nx + ny * ny)
                    nx, ny = nx * r, ny * r
                    push = -2.0 * (u * nx + w * ny)
                    x, y = centres[kind - 3, 0] + RADIUS * nx, centres[kind - 3, 1] + RADIUS * ny
                    u, w = u + push * nx, w + push * ny
            states[b] = x, y, u, w

    def program(count: int, share: float) -> float:
        y, hits = HEIGHT - 0.2, max(round(HITS * share), 1)
        angle, speed = np.linspace(0.1, 6.1, LAUNCHES), sqrt(2.0 * (ENERGY - y))
        states = np.column_stack([np.full((LAUNCHES, 2), (0.2, y)), speed * np.cos(angle), speed * np.sin(angle)])
        before = process_time()
        fly(states, places(count), hits)
        spent = process_time() - before
        if not np.abs(0.5 * (states[:, 2:] ** 2).sum(axis=1) + states[:, 1] - ENERGY).max() < 1e-6:
            raise Missing("failed: the energy is not kept")
        return LAUNCHES * hits / spent

    def hits(depth: float) -> bool:
        states = np.array([pass_over(depth)])
        fly(states, np.array([PASSED]), 1)
        return bool(abs(np.hypot(states[0, 0] - PASSED[0], states[0, 1] - PASSED[1]) - RADIUS) < 1e-9)

    return program, hits


def packed() -> tuple[Program, None]:
    """Return the C++ program."""
    compiler = shutil.which("g++")
    if compiler is None:
        raise Missing("no g++ here: install a C++ compiler")
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    file = Path(folder) / "pinball"
    lanes = 8 if "avx512f" in Path("/proc/cpuinfo").read_text() else 4
    subprocess.run([compiler, *FLAGS, f"-DL={lanes}", str(SOURCE), "-o", str(file)], check=True)

    def program(count: int, share: float) -> float:
        work = str(max(round(LAUNCHES * HITS * share), 1000))
        said = subprocess.run([str(file), str(count), work], check=True, capture_output=True, text=True).stdout
        return float(said.split()[0])

    return program, None


PROGRAMS: dict[str, Callable[[], tuple[Program, Hits | None]]] = {
    "grazing, launches": launches,
    "grazing, collision map": collisions,
    "plain numba loop, rounding not accounted for": plain,
    "C++, packed, rounding not accounted for": packed,
    "pymunk, steps of 1e-3": in_pymunk,
    "Box2D, a bullet, steps of 1e-3": in_box2d,
    "billiards, no gravity": in_billiards,
}


def pinball(rounds: int, share: float, tell: Tell) -> list[Rate]:
    """Measure all programs."""
    ready: dict[str, Program] = {}
    found, passes = {}, {}
    for name, make in PROGRAMS.items():
        tell(f"making ready: {name}")
        try:
            with foreign():
                ready[name], hits = make()
                ready[name](DISCS[0], 0.01)
                passes[name] = "" if hits is None else judged(hits)
        except Missing as reason:
            ready.pop(name, None)
            found[name] = Rate(name, missing=str(reason))
    rates: dict[tuple[str, int], list[float]] = {}
    for n in range(rounds):
        for count in DISCS:
            for name in list(ready)[:: 1 if n % 2 == 0 else -1]:
                tell(f"round {n + 1} of {rounds}: {name}, {count} discs")
                rates.setdefault((name, count), []).append(ready[name](count, share))
    for name in ready:
        found[name] = Rate(name, {count: median(rates[name, count]) / 1e6 for count in DISCS}, passes=passes[name])
    return [found[name] for name in PROGRAMS]


def show_pinball(out: Console, found: list[Rate]) -> None:
    """Print millions of collisions a second, and how many passes by a disc, 1e-3 to 1e-13 deep or clear, are wrong."""
    head = ("program", *(f"{count} discs" for count in DISCS), "passes missed, made up")
    lines = [
        (one.name, *(f"{one.rates[count]:.3g}" if one.rates else one.missing for count in DISCS), one.passes or "-")
        for one in found
    ]
    show(out, "Pinball tables: millions of collisions a second and core", head, lines)
