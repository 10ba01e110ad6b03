"""A flight up to the first contact and the impact there: what trajectories and maps of a table are made of."""

from __future__ import annotations

from typing import Any

from grazing.billiard.hit import flown, is_open, met, struck
from grazing.billiard.march import first_contact
from grazing.billiard.rows import GRAVITY
from grazing.kernel.primitives import inlined, unit
from grazing.outcome import BAD_LAW, DIVERGED, ESCAPED, FATAL

NAN, INFINITY = float("nan"), float("inf")


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


@unit
def next_impact(x: float, y: float, vx: float, vy: float, left: float, clock: float, table: Any) -> Any:
    """Return (surface, owner, t, flags), and the states and velocities of :func:`impact`: a flight and what ends it.

    The surface is -1, and the time infinite, for a ball that leaves for good without meeting anything: it *escapes*.
    """
    surface, t, flags = first_contact(x, y, vx, vy, left, clock, table)
    return contact(surface, t, flags, x, y, vx, vy, clock, table)


@inlined
def contact(
    surface: int, t: float, flags: int, x: float, y: float, vx: float, vy: float, clock: float, table: Any
) -> Any:  # fmt: skip
    """Return what :func:`next_impact` does, of a flight whose first contact is known."""
    state, none = (x, y, vx, vy), (NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN)
    if flags & FATAL:
        return (surface, -1, t, flags), state, state, none
    if surface < 0:
        return (surface, -1, INFINITY, flags | ESCAPED), state, state, none
    if not t < INFINITY:
        return (surface, -1, t, flags | DIVERGED), state, state, none
    (owner, said), before, after, speeds = impact(surface, t, x, y, vx, vy, clock, table)
    return (surface, owner, t, flags | said), before, after, speeds
