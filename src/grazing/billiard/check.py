"""What is promised of a table, held against exact algebra and a dense search."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.exact import exact_contact
from grazing.billiard.flown import BEFORE, FIRST, FLAGS, LAST, LEFT, NEXT, OWNER, PATH, SURFACE, TIME, flights_of
from grazing.billiard.objects import DISC, DRAIN, FLIPPER
from grazing.billiard.roots import Undecided
from grazing.billiard.table import Table
from grazing.outcome import AMBIGUOUS, FATAL, InputError

Floats = NDArray[np.float64]
#: Flights of a start that are looked at, and places on each; places that are tried for a start.
FLIGHTS, PLACES, TRIED = 40, 200, 10_000
#: How far contacts in doubles may be from exact ones, as a share of the sizes involved.
SAME = 1e-11


def free_place(table: Table, random: np.random.Generator) -> tuple[float, float]:
    """Return where a ball fits among the objects, and beside them where there are only discs; or raise InputError."""
    points = np.concatenate([one.points for one in table.outlines()])
    beside = table.rho if all(one.kind in (DISC, DRAIN) for one in table.objects) else 0.0
    low, high = points.min(axis=0) - beside, points.max(axis=0) + beside
    for _ in range(TRIED):
        x, y = random.uniform(low, high)
        if table.overlap(x, y)[0] == 0.0:
            return float(x), float(y)
    raise InputError(f"a ball of radius {table.rho:g} fits nowhere among the objects of the table; make rho smaller")


def check(table: Table, states: int, seed: int) -> int:
    """Raise AssertionError for a flight that is wrong; return how many were looked at."""
    random = np.random.default_rng(seed)
    points = np.concatenate([one.points for one in table.outlines()])
    extent = float(np.ptp(points, axis=0).max()) + table.rho
    speed = max((2.0 * table.gravity * extent) ** 0.5, extent if table.gravity == 0.0 else 0.0)
    block, seen = table.blocks(table.row())[0], 0
    for _ in range(states):
        (x, y), angle = free_place(table, random), random.uniform(0.0, 2.0 * pi)
        fast = random.uniform(0.1, 1.0) * speed
        clock = 0.0
        for flight in flights_of(table, (x, y, fast * cos(angle), fast * sin(angle)), 0.0, np.inf, FLIGHTS):
            if flight[PATH] < 0.0:
                _check_flight(table, block, flight, clock, extent)
            clock, seen = clock + float(flight[TIME]), seen + 1
    return seen


def _check_flight(table: Table, block: Floats, flight: Floats, clock: float, extent: float) -> None:
    state, flags = flight[FIRST:LAST], int(flight[FLAGS])
    said = f"the flight from {tuple(state.tolist())}{f' at t = {clock!r}' if clock else ''}"
    if flags & (FATAL | AMBIGUOUS):
        return
    try:
        surface, t, _graze = exact_contact(block, tuple(state.tolist()), float(flight[LEFT]), clock)
    except Undecided:
        return
    assert surface == int(flight[SURFACE]), f"{said} ends at surface {int(flight[SURFACE])}; exact is {surface}"
    assert surface < 0 or abs(t - flight[TIME]) <= SAME * (extent / np.hypot(state[2], state[3]) + t), (
        f"{said} ends at t = {float(flight[TIME])!r}; exact is {t!r}"
    )
    x, y, vx, vy = state.tolist()
    size = SAME * (extent + abs(x) + abs(y))
    end = flight[TIME] if surface >= 0 else extent / max(np.hypot(vx, vy), 1e-300)
    for s in np.linspace(0.0, end, PLACES).tolist():
        now = table.distances(x + vx * s, y + (vy - 0.5 * table.gravity * s) * s, clock + s)
        for one in table.objects:
            assert one.kind == DRAIN or now[one.name] - table.rho >= -size, (
                f"{said} misses {one.name}: the ball overlaps it by {table.rho - now[one.name]:.1e} at t = {s!r}"
            )
    if np.isnan(flight[BEFORE]):
        return
    name = table.names[int(flight[OWNER])]
    gap = table.distances(flight[NEXT], flight[NEXT + 1], clock + float(flight[TIME]))[name] - table.rho
    assert abs(gap) <= size, f"{said} ends at {name}, but {gap:.1e} away from it"
    law = table.objects[int(flight[OWNER])].law
    assert law is not None
    after, before = flight[NEXT + 2 : PATH], flight[LAST + 2 : NEXT]
    if table.objects[int(flight[OWNER])].kind == FLIPPER:  # which gives energy, or takes it
        kick = law(float(flight[BEFORE])) - float(flight[BEFORE])
        assert abs(float(np.hypot(*(after - before))) - kick) <= 1e-9 * (kick + np.hypot(*before)), (
            f"{said} changes the velocity by {(after - before).tolist()} at {name}; the law of that says {kick!r}"
        )
        return
    away = float(after @ after - before @ before)
    kept = law(float(flight[BEFORE])) ** 2 - float(flight[BEFORE]) ** 2
    assert abs(away - kept) <= 1e-9 * (1.0 + abs(kept)) * (1.0 + float(before @ before)), (
        f"{said} changes the square of the speed by {away!r} at {name}; the law of that says {kept!r}"
    )
