"""Collisions a second on a table whose flippers move, and the basins of its ways out on the table ``classic``.

Beside this library, with every decision proven: a plain loop that knows this table alone, and steps by quadratic bounds
of each gap without regard to rounding. Processor time is compared, in interleaved rounds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import hypot, pi
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from .measure import Tell
from .models import Array
from .table import show

Counts = NDArray[np.int64]
RHO, DISC, BUMPERS = 0.1, 0.5, ((1.8, 6.0), (4.2, 6.0), (3.0, 7.8))
WIDTH, HEIGHT, PIVOTS, ARM, THICK = 6.0, 10.0, ((1.2, 1.0), (4.8, 1.0)), 1.45, 0.05
RAILS = ((0.0, 2.2, 1.1, 1.2), (6.0, 2.2, 4.9, 1.2))
LOW, STROKE, SPEED, PERIOD, HOLD = -0.5, 1.0, 14.0, 0.9, 0.3
KICK, BOUNCE, BALLS, MOST = 1.0, 0.8, 4096, 2000
#: Launches along each side of the basins, and the seconds that they may take on two cores.
SIDE, ALLOWED = 1000, 60.0


@dataclass(frozen=True)
class Flips:
    """Millions of collisions a second with flippers that move, by program; the median of the rounds."""

    name: str
    rate: float


@dataclass(frozen=True)
class Basins:
    """Launches on ``classic``, the impacts of all of them, and their seconds, by the clock and of processors."""

    launches: int
    impacts: int
    seconds: float
    spent: float


def starts() -> tuple[Array, Array]:
    """Return angles and speeds from the middle of the top."""
    return np.linspace(-pi, 0.0, BALLS // 16), np.linspace(0.5, 2.0, 16)


def table() -> Any:
    """Return the table: three bumpers, rails and two flippers that are pressed in turn with the time."""
    import grazing as gz

    law = gz.newton(BOUNCE)
    discs = [gz.disc(f"bumper{i}", place, DISC, gz.active(BOUNCE, KICK)) for i, place in enumerate(BUMPERS)]
    walls = [
        gz.segment("left", (0, HEIGHT), (0, 0), law), gz.segment("right", (WIDTH, 0), (WIDTH, HEIGHT), law),
        gz.segment("top", (WIDTH, HEIGHT), (0, HEIGHT), law),
    ]  # fmt: skip
    rails = [gz.segment(f"rail{i}", one[:2], one[2:], law) for i, one in enumerate(RAILS)]
    angles = (LOW, LOW + STROKE), (pi - LOW, pi - LOW - STROKE)
    flippers = [
        gz.flipper(f"flipper{i}", PIVOTS[i], ARM, (THICK, THICK), *angles[i], law, up=SPEED, down=SPEED)
        for i in range(2)
    ]
    things = [*discs, *walls, *rails, *flippers, gz.drain("out", (0, 0), (WIDTH, 0))]
    return gz.table(things, RHO, tilt=0.5 * pi, player=gz.flips(PERIOD, HOLD))


def proven() -> Callable[[], Counts]:
    """Return the impacts of each launch, by this library."""
    import grazing as gz

    T = table()

    def program() -> Counts:
        found = gz.launches(T, (3.0, 9.3), *starts(), hits=MOST, threads=1)
        hits: Counts = found.hits.values.ravel()
        return hits

    return program


def plain() -> Callable[[], Counts]:
    """Return the same, by a loop for this table alone."""
    import numba

    jit = numba.njit(error_model="numpy")
    rails = np.array([(x, y, hypot(p - x, q - y), (p - x) / hypot(p - x, q - y), (q - y) / hypot(p - x, q - y))
                      for x, y, p, q in RAILS])  # fmt: skip
    stroke = STROKE / SPEED

    @jit  # type: ignore[untyped-decorator]
    def circle(x: float, y: float, u: float, w: float, size: float, T: float) -> float:  # pragma: no cover
        """Return when a ball meets a circle around the origin, T if not before that."""
        t = 0.0
        for _ in range(300):
            px, py, pw = x + u * t, y + (w - 0.5 * t) * t, w - t
            gap, rate = px * px + py * py - size * size, 2.0 * (px * u + py * pw)
            if gap <= 1e-13:
                if rate < 0.0:
                    return t
                gap = 0.0
            low = min(max(pw, 0.0), T - t)  # where the second derivative is least
            bend = 2.0 * (u * u + pw * pw - py) - 6.0 * pw * low + 3.0 * low * low
            D = rate * rate - 2.0 * bend * gap
            if D < 0.0 or (bend >= 0.0 and rate >= 0.0):
                return T
            step = 2.0 * gap / (np.sqrt(D) - rate) if rate < 0.0 else -(rate + np.sqrt(D)) / bend
            t += max(step, 1e-14)
            if t >= T:
                return T
        return t

    @jit  # type: ignore[untyped-decorator]
    def bar(
        x: float, y: float, u: float, w: float, angle: float, omega: float, size: float, long: float, T: float
    ) -> Any:  # pragma: no cover
        """Return (t, part): when a ball meets a bar that turns about the origin, 1 or -1 for its sides, 2 its end."""
        spin, part = abs(omega), 0
        far, fast = np.sqrt(x * x + y * y), np.sqrt(u * u + (abs(w) + T) ** 2)
        if far - fast * T > long + size:
            return T, 0
        far += fast * T
        most = 1.0 + 2.0 * spin * fast + spin * spin * far + 1e-12
        for side in (1.0, -1.0):
            t = 0.0
            for _ in range(400):
                c, s = np.cos(angle + omega * t), np.sin(angle + omega * t)
                px, py, pw = x + u * t, y + (w - 0.5 * t) * t, w - t
                foot = c * px + s * py
                gap, rate = side * (c * py - s * px) - size, side * (c * pw - s * u - omega * foot)
                if abs(gap) <= 1e-12:
                    if rate < 0.0 and foot >= 0.0 and foot <= long:
                        T, part = t, int(side)
                        break
                    t += max(1e-9, abs(rate) / most)
                else:
                    down = rate if gap > 0.0 else -rate
                    D = np.sqrt(down * down + 2.0 * most * abs(gap))
                    t += 2.0 * abs(gap) / (D - down) if down < 0.0 else (down + D) / most
                if t >= T:
                    break
        most, t = 2.0 * ((fast + spin * long) ** 2 + (far + long) * (1.0 + long * spin * spin)) + 1e-12, 0.0
        for _ in range(400):
            c, s = np.cos(angle + omega * t), np.sin(angle + omega * t)
            px, py = x + u * t - long * c, y + (w - 0.5 * t) * t - long * s
            pu, pw = u + long * omega * s, w - t - long * omega * c
            gap, rate = px * px + py * py - size * size, 2.0 * (px * pu + py * pw)
            if gap <= 1e-13:
                if rate < 0.0:
                    return t, 2
                gap = 0.0
            D = np.sqrt(rate * rate + 2.0 * most * gap)
            t += max(2.0 * gap / (D - rate) if rate < 0.0 else (rate + D) / most, 1e-13)
            if t >= T:
                break
        return T, part

    @jit  # type: ignore[untyped-decorator]
    def play(states: Array, bumpers: Array, rails: Array, pivots: Array, hits: Array) -> None:  # pragma: no cover
        for b in range(states.shape[0]):
            x, y, u, w = states[b]
            clock = 0.0
            while hits[b] < MOST:
                phase = clock % PERIOD
                if phase < stroke:
                    angle, omega, T = LOW + SPEED * phase, SPEED, stroke - phase
                elif phase < HOLD:
                    angle, omega, T = LOW + STROKE, 0.0, HOLD - phase
                elif phase < HOLD + stroke:
                    angle, omega, T = LOW + STROKE - SPEED * (phase - HOLD), -SPEED, HOLD + stroke - phase
                else:
                    angle, omega, T = LOW, 0.0, PERIOD - phase
                T, kind, at, part = T + 1e-13, 0, 0, 0
                wall = (WIDTH - RHO - x if u > 0.0 else RHO - x) / u if u != 0.0 else np.inf
                if wall < T:
                    T, kind = max(wall, 0.0), 1
                D = w * w - 2.0 * (HEIGHT - RHO - y)
                if w > 0.0 and D >= 0.0 and 2.0 * (HEIGHT - RHO - y) / (w + np.sqrt(D)) < T:
                    T, kind = max(2.0 * (HEIGHT - RHO - y) / (w + np.sqrt(D)), 0.0), 2
                for j in range(3):
                    t = circle(x - bumpers[j, 0], y - bumpers[j, 1], u, w, DISC + RHO, T)
                    if t < T:
                        T, kind, at = t, 3, j
                for j in range(2):
                    turn = np.arctan2(rails[j, 4], rails[j, 3])
                    t, which = bar(x - rails[j, 0], y - rails[j, 1], u, w, turn, 0.0, RHO, rails[j, 2], T)
                    if which != 0:
                        T, kind, at, part = t, 4, j, which
                    sign = 1.0 - 2.0 * j
                    turn, dx, dy = (angle if j == 0 else pi - angle), x - pivots[j, 0], y - pivots[j, 1]
                    t, which = bar(dx, dy, u, w, turn, sign * omega, THICK + RHO, ARM, T)
                    if which != 0:
                        T, kind, at, part = t, 5, j, which
                    t = circle(dx, dy, u, w, THICK + RHO, T)
                    if t < T:
                        T, kind, at, part = t, 5, j, 3
                x, y, w, clock = x + u * T, y + (w - 0.5 * T) * T, w - T, clock + T
                if y <= 0.0:
                    break
                if kind == 0:
                    continue
                hits[b] += 1
                if kind == 1:
                    u = -BOUNCE * u
                    continue
                if kind == 2:
                    w = -BOUNCE * w
                    continue
                px, py, long, turn, spin = 0.0, 0.0, 0.0, 0.0, 0.0
                if kind == 3:
                    px, py = bumpers[at, 0], bumpers[at, 1]
                elif kind == 4:
                    px, py, long = rails[at, 0], rails[at, 1], rails[at, 2]
                    turn = np.arctan2(rails[at, 4], rails[at, 3])
                else:
                    sign = 1.0 - 2.0 * at
                    px, py, long, spin = pivots[at, 0], pivots[at, 1], ARM, sign * omega
                    turn = angle + omega * T if at == 0 else pi - angle - omega * T
                nx, ny = x - px, y - py
                uw, ww = -spin * ny, spin * nx  # of the surface
                if part == 2:
                    nx, ny = nx - long * np.cos(turn), ny - long * np.sin(turn)
                elif kind > 3 and part != 3:
                    nx, ny = -part * np.sin(turn), part * np.cos(turn)
                r = np.sqrt(nx * nx + ny * ny)
                nx, ny = nx / r, ny / r
                speed = (u - uw) * nx + (w - ww) * ny
                push = -(1.0 + BOUNCE) * speed + (KICK if kind == 3 else 0.0)
                push = max(push, 1e-3 - speed)  # it knows no rest
                u, w = u + push * nx, w + push * ny

    def program() -> Counts:
        angle, speed = (one.ravel() for one in np.meshgrid(*starts(), indexing="ij"))
        states = np.column_stack([np.full((len(angle), 2), (3.0, 9.3)), speed * np.cos(angle), speed * np.sin(angle)])
        hits = np.zeros(len(angle), np.int64)
        play(states, np.array(BUMPERS), rails, np.array(PIVOTS), hits)
        return hits

    return program


PROGRAMS = {"grazing, launches": proven, "plain numba loop, rounding not accounted for": plain}


def flippers(rounds: int, tell: Tell) -> list[Flips]:
    """Measure both programs."""
    ready = {name: make() for name, make in PROGRAMS.items()}
    rates: dict[str, list[float]] = {name: [] for name in ready}
    for n in range(-1, rounds):  # the first one compiles
        for name in list(ready)[:: 1 if n % 2 == 0 else -1]:
            tell(f"round {n + 1} of {rounds}: {name}, flippers that move")
            before = process_time()
            hits = int(ready[name]().sum())
            rates[name].append(hits / (process_time() - before))
    return [Flips(name, median(found[1:]) / 1e6) for name, found in rates.items()]


def basins(share: float, tell: Tell) -> Basins:
    """Launch balls of ``classic`` from its plunger, in angle and speed, until they are out."""
    import grazing as gz

    T, side = gz.read_table("classic"), max(round(SIDE * share), 2)

    def found(count: int) -> int:
        return int(gz.launches(T, None, np.linspace(0.0, pi, count), np.linspace(12.0, 22.0, count)).hits.sum())

    tell(f"{side} x {side} launches on classic")
    found(2)  # compiles
    clock, before = perf_counter(), process_time()
    impacts = found(side)
    return Basins(side * side, impacts, perf_counter() - clock, process_time() - before)


def show_flippers(out: Console, found: list[Flips], seen: Basins) -> None:
    """Print millions of collisions a second, and what basins cost."""
    lines = [(one.name, f"{one.rate:.3g}") for one in found]
    show(out, "Flippers that move: millions of collisions a second and core", ("program", "rate"), lines)
    line = (f"{seen.launches:,}", f"{seen.impacts / seen.launches:.1f}", f"{seen.seconds:.3g}", f"{seen.spent:.3g}",
            f"{1e6 / seen.launches * seen.seconds:.3g}, {ALLOWED:g} allowed on two cores")  # fmt: skip
    head = "launches on classic", "impacts each", "seconds", "of processors", "seconds for a million"
    show(out, "Basins of ways out", head, [line])
