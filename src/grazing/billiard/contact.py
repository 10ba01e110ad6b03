"""A flight up to the first contact, a slide up to what ends it, and the impact there: what orbits are made of."""

from __future__ import annotations

from typing import Any

from grazing.billiard.elements import OFF, ON, element, turns_at, width_of
from grazing.billiard.hit import flown, is_open, met, period_of, struck
from grazing.billiard.march import first_contact
from grazing.billiard.rows import FLIPPERS, GRAVITY, LENGTH
from grazing.billiard.slide import HITS, LEAVES, STAYS, WAITS, pressing, slide
from grazing.kernel.primitives import inlined, unit
from grazing.outcome import (
    AMBIGUOUS,
    BAD_LAW,
    CHATTER,
    DIVERGED,
    ESCAPED,
    FATAL,
    GRAZE,
    NO_IMPACT,
    STUCK,
    TOO_MANY_SWINGS,
)

NAN, INFINITY = float("nan"), float("inf")
NONE = (NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN)
#: Flights and slides without an impact after which a ball ends by name.
SLIDES = 10_000
#: Rises that are looked at closer, as a share of the size of the table.
SLOW = 1e-9
#: How much less than what touches a rise must be that is none.
FINE = 4.0


@inlined
def impact(surface: int, t: float, x: float, y: float, vx: float, vy: float, clock: float, table: Any) -> Any:
    """Return what happens where a flight that begins at the time ``clock`` meets a surface after a time t.

    Returns
    -------
    (owner, flags), (x, y, vx, vy) just before, the same just after, (v_minus, v_plus, along, *frame)
        The velocities are those along the normal, relative to the surface, and the ball's own along the surface, which
        stays as it is; the frame is that of :func:`grazing.billiard.hit.met`. At a drain the state is that before, and
        there are no velocities.
    """
    bx, by, bvx, bvy = flown(x, y, vx, vy, table[GRAVITY], t)
    owner, px, py, frame = met(surface, bx, by, t, clock, table)
    nx, ny, _curvature, _omega, ux, uy = frame
    if is_open(owner, table):
        return (owner, ESCAPED), (bx, by, bvx, bvy), (bx, by, bvx, bvy), (NAN, NAN, NAN, *frame)
    push = ux * nx + uy * ny
    speed, along = min(bvx * nx + bvy * ny - push, 0.0), bvy * nx - bvx * ny
    away, flags = struck(owner, speed, table), 0
    if not (away >= 0.0 and away < INFINITY):
        flags = BAD_LAW
    out = away + push
    after = px, py, out * nx - along * ny, out * ny + along * nx
    return (owner, flags), (px, py, bvx, bvy), after, (speed, away, along, *frame)


@inlined
def settles(surface: int, after: Any, speeds: Any, clock: float, table: Any) -> Any:
    """Say whether an impact is none: the ball comes and would go by less than rounding can tell, and is pressed on."""
    before, away, along, nx, ny, bend, omega, _ux, _uy = speeds
    press, most = pressing(nx, ny, bend, along, table[GRAVITY]), max(before * before, away * away)
    if omega != 0.0 or not most <= SLOW * press * (abs(after[0]) + abs(after[1]) + table[LENGTH]):
        return False
    return most <= 2.0 * press * width_of(element(surface, clock, table), after[0], after[1]) / FINE


@inlined
def landed(surface: int, t: float, x: float, y: float, vx: float, vy: float, clock: float, table: Any) -> Any:
    """Return (owner, flags, left) and what :func:`impact` does besides; a ball that settles slides, owner -1."""
    (owner, flags), before, after, speeds = impact(surface, t, x, y, vx, vy, clock, table)
    left = 1.0 * surface
    if flags == 0 and settles(surface, after, speeds, clock + t, table):
        _before, _away, along, nx, ny = speeds[:5]
        after = after[0], after[1], -along * ny, along * nx
        return (-1, flags | STUCK, left + ON), before, after, NONE
    return (owner, flags, left), before, after, speeds


@inlined
def slid_on(left: float, clock: float, table: Any) -> Any:
    """Return the surface on which a ball slides, -1 for one that flies."""
    last = int(left)
    return last if left == last + ON and not turns_at(last, clock, table) else -1


@unit
def next_event(x: float, y: float, vx: float, vy: float, left: float, clock: float, table: Any) -> Any:
    """Return (surface, owner, t, flags, left), and the states and velocities of :func:`impact`: a flight or a slide.

    ``left`` is the surface that the ball just left, plus ON for one on which it slides, plus OFF for one off which it
    slid. The owner is that of what is hit, or -1. The surface is -1 for a ball that rests, and for one that leaves for
    good without meeting anything, it *escapes*; then, and if it slides or rests for ever, the time is infinite.
    """
    state, last = (x, y, vx, vy), slid_on(left, clock, table)
    if last >= 0:
        (surface, why, t, flags), there = slide(x, y, vx, vy, last, clock, table)
        flags |= STUCK
        if why == HITS:
            x, y, vx, vy = there
            (owner, said, left), _before, after, speeds = landed(surface, 0.0, x, y, vx, vy, clock + t, table)
            # in a corner it stays where it is, on the surface that it slid on: rounding must not push it through that
            return (surface, owner, t, flags | said, left), there, (x, y, after[2], after[3]), speeds
        if why == STAYS:
            return (surface, -1, INFINITY, flags | NO_IMPACT, left), there, there, NONE
        if why != WAITS:
            left = surface + (OFF if why == LEAVES else ON)
        return (surface, -1, t, flags, left), there, there, NONE
    surface, t, flags = first_contact(x, y, vx, vy, left, clock, table)
    return flight_to(surface, t, flags, state, left, clock, table)


@inlined
def flight_to(surface: int, t: float, flags: int, state: Any, left: float, clock: float, table: Any) -> Any:
    """Return what :func:`next_event` does, of a flight whose first contact is known."""
    x, y, vx, vy = state
    if flags & FATAL:
        return (surface, -1, t, flags, left), state, state, NONE
    if flags & STUCK:  # there is no flight, so what was doubtful about it is nothing: a slide begins
        flags = (flags | CHATTER) & ~(GRAZE | AMBIGUOUS)
        return (surface, -1, 0.0, flags, surface + ON), state, state, NONE
    if surface < 0:
        return (surface, -1, INFINITY, flags | ESCAPED, left), state, state, NONE
    if not t < INFINITY:
        return (surface, -1, t, flags | DIVERGED, left), state, state, NONE
    (owner, said, left), before, after, speeds = landed(surface, t, x, y, vx, vy, clock, table)
    return (surface, owner, t, flags | said, left), before, after, speeds


@unit
def next_impact(x: float, y: float, vx: float, vy: float, left: float, clock: float, table: Any) -> Any:
    """Return what :func:`next_event` does, for all flights and slides up to the next impact together.

    The time is that of all of them. A ball that is never hit again, or not within a whole period where flippers are
    worked periodically, has no next impact.
    """
    t, flags, still = 0.0, 0, 0.0
    for _ in range(SLIDES):
        (surface, owner, length, said, on), before, after, speeds = next_event(x, y, vx, vy, left, clock + t, table)
        t, flags = t + length, flags | said
        if owner >= 0 or flags & (FATAL | ESCAPED):
            return (surface, owner, t, flags, on), before, after, speeds
        still = still + length if on == left and after == (x, y, 0.0, 0.0) else 0.0
        if still > 0.0 and table[FLIPPERS] > 0.0 and still > 2.0 * period_of(table) > 0.0:
            return (surface, -1, t, flags | NO_IMPACT, on), before, after, speeds
        left, (x, y, vx, vy) = on, after
    return (-1, -1, t, flags | TOO_MANY_SWINGS, left), (x, y, vx, vy), (x, y, vx, vy), NONE
