"""A flight up to the first contact, a slide up to what ends it, and the impact there: what orbits are made of."""

from __future__ import annotations

from math import sqrt
from typing import Any

from grazing.billiard.elements import (
    SAME,
    TOUCH,
    along,
    apart,
    element,
    gap_of,
    holds,
    joins,
    normal_of,
    turns_at,
    width_of,
)
from grazing.billiard.hit import coming, first_turning, flown, going, is_open, met, period_of, rows_of, struck
from grazing.billiard.march import first_contact
from grazing.billiard.ride import ride
from grazing.billiard.rows import FACES, FEET, FLIPPERS, GRAVITY, LENGTH, OWNER, WIDTH
from grazing.billiard.slide import HITS, LEAVES, STAYS, WAITS, pressing, slide
from grazing.billiard.turning import OFF, ON, RIDES
from grazing.kernel.primitives import behind, inlined, unit
from grazing.outcome import (
    AMBIGUOUS,
    BAD_LAW,
    CHATTER,
    DIVERGED,
    ESCAPED,
    FATAL,
    GRAZE,
    NO_IMPACT,
    OK,
    STUCK,
    TOO_MANY_IMPACTS,
    TOO_MANY_SWINGS,
)

NAN, INFINITY = float("nan"), float("inf")
NONE = (NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN)
#: Flights and slides without an impact after which a ball ends by name.
SLIDES = 10_000
#: Flights and slides without any time after an impact, after which a ball that a flipper pushes is jammed if it has
#: half of its speed then; those after which any other one is, and the share by which they change its velocity at most.
JAMMED, AGAIN, SAME_SPEED = 1000, 32, 2.0**-10
#: Rises that are looked at closer, as a share of the size of the table.
SLOW = 1e-9
#: The part of what tells a place from the line of a wall that rounding cannot make.
TOLD = 1.0 / 16.0
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
    if is_open(owner, table):
        return (owner, ESCAPED), (bx, by, bvx, bvy), (bx, by, bvx, bvy), (NAN, NAN, NAN, *frame)
    speed, along, push = coming(bvx, bvy, frame)
    away, flags = struck(owner, speed, table), 0
    if not (away >= 0.0 and away < INFINITY):
        flags = BAD_LAW
    after = px, py, *going(away, along, push, frame)
    return (owner, flags), (px, py, bvx, bvy), after, (speed, away, along, *frame)


@inlined
def may_settle(after: Any, speeds: Any, g: float, length: float) -> Any:
    """Return (said, most, press): whether an impact is so slow that it has to be looked at closer, and how fast."""
    before, away, along, nx, ny, bend, _omega, _ux, _uy = speeds
    press, most = pressing(nx, ny, bend, along, g), max(before * before, away * away)
    return most <= SLOW * press * (abs(after[0]) + abs(after[1]) + length), most, press


@inlined
def settles(surface: int, after: Any, speeds: Any, clock: float, table: Any) -> Any:
    """Say whether an impact is none: the ball comes and would go by less than rounding can tell, and is pressed on."""
    slow, most, press = may_settle(after, speeds, table[GRAVITY], table[LENGTH])
    if speeds[6] != 0.0 or not slow:
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
def cleared(
    surface: int, left: int, x: float, y: float, vx: float, vy: float, clock: float, table: Any
) -> Any:  # fmt: skip
    """Return (x, y, way, wall): the place of a ball that hit a surface with a velocity, beside walls that end there.

    At the foot of such a wall a ball without a radius is on its line, and neither what it left nor its velocity says on
    which side. So it is put on the side from which it came, as far as tells; ``way`` is how far that may be, and
    ``wall`` the side.
    """
    reach, beside = 0.0, -1
    if table[FEET] == 0.0 or surface >= first_turning(table):
        return x, y, reach, beside
    rows, el = rows_of(table), element(surface, clock, table)
    for i in range(int(table[FACES])):
        row = behind(rows, WIDTH * i)
        if is_open(int(row[OWNER]), table) or surface // 2 == i:
            continue
        wall = element(2 * i + 1, clock, table)
        far = apart(wall, el, x, y)
        if abs(gap_of(wall, x, y)) > far or not holds(wall, x, y, far) or not joins(el, wall, x, y, 0.5 * far):
            continue
        nx, ny = normal_of(el, x, y)
        gap, rate, lean = gap_of(wall, x, y), wall[4] * vx + wall[5] * vy, wall[5] * nx - wall[4] * ny
        side = 1.0 if gap >= 0.0 else -1.0
        if left // 2 == i:
            side = 2.0 * (left % 2) - 1.0
        elif abs(gap) <= TOLD * far and abs(rate) > SAME * (abs(vx) + abs(vy)):
            side = 1.0 if rate < 0.0 else -1.0
        x, y = along(el, x, y, side if lean > 0.0 else -side, (far - side * gap) / abs(lean))
        reach, beside = max(reach, 2.0 * far / abs(lean)), 2 * i + (1 if side > 0.0 else 0)
    return x, y, reach, beside


@inlined
def is_slow(left: float, v: Any, after: Any, g: float, length: float) -> Any:
    """Say whether a ball that left something is as slow before and after an impact as :func:`falls_out` asks."""
    x, y, vx, vy = after
    fast = max(v[0] * v[0] + v[1] * v[1], vx * vx + vy * vy)
    return (left >= 0.0) & (fast <= SLOW * g * (abs(x) + abs(y) + length))


@inlined
def falls_out(surface: int, left: int, v: Any, after: Any, clock: float, table: Any) -> Any:
    """Say whether gravity pulls a ball off what it hits and what it left, while it is on both up to rounding.

    So it is in a notch of a ceiling, where hits of no time take its speed to 0, and it falls out.
    """
    (x, y, vx, vy), g = after, table[GRAVITY]
    if not is_slow(1.0 * left, v, after, g, table[LENGTH]):
        return False
    fast = max(v[0] * v[0] + v[1] * v[1], vx * vx + vy * vy)
    here, there = element(surface, clock, table), element(left, clock, table)
    width = width_of(here, x, y) + width_of(there, x, y)
    hangs = normal_of(here, x, y)[1] < 0.0 and normal_of(there, x, y)[1] < 0.0
    return hangs and fast <= 2.0 * g * width and abs(gap_of(there, x, y)) <= width


@unit
def at_foot(
    surface: int, left: int, now: float, x: float, y: float, v: Any, after: Any, normal: Any, clock: float, table: Any
) -> Any:  # fmt: skip
    """Return (left, state) just after an impact, of a ball without a radius beside a wall that ends there.

    Where it is put its energy is the same. If it goes no faster than by a fall over that way, it rests or slides on
    what holds it.
    """
    px, py, reach, wall = cleared(surface, left, x, y, v[0], v[1], clock, table)
    g, (_x, _y, vx, vy), (nx, ny) = table[GRAVITY], after, normal
    fast = vx * vx + vy * vy
    if wall < 0 and falls_out(surface, left, v, after, clock, table):
        return now, (x, y, 0.0, 0.0)
    if wall < 0 or not fast > 0.0:
        return now, (px, py, vx, vy)
    if fast > 4.0 * g * reach:
        kept = sqrt(max(1.0 - 2.0 * g * (py - y) / fast, 0.0))
        return now, (px, py, kept * vx, kept * vy)
    _curved, _owner, _px, _py, mx, my, _size, _span = element(wall, clock, table)
    falls = mx * (mx * ny - my * nx) < 0.0  # the wall, from where it ends
    if my > 0.0 and (falls or ny <= 0.0):
        return 1.0 * wall + ON, (x, y, 0.0, 0.0)
    return (1.0 * surface + ON if ny > 0.0 else now), (px, py, 0.0, 0.0)


@inlined
def slid_on(left: float, clock: float, table: Any) -> Any:
    """Return the surface on which a ball slides, -1 for one that flies."""
    last = int(left)
    slides = left == last + RIDES or (left == last + ON and not turns_at(last, clock, table))
    return last if slides else -1


@unit
def next_event(x: float, y: float, vx: float, vy: float, left: float, clock: float, table: Any) -> Any:
    """Return (surface, owner, t, flags, left), and the states and velocities of :func:`impact`: a flight or a slide.

    ``left`` is the surface that the ball just left, plus ON or RIDES for one on which it slides, plus OFF for one off
    which it slid. The owner is that of what is hit, or -1. The surface is -1 for a ball that rests, and for one that
    leaves for good without meeting anything, it *escapes*; then, and if it slides or rests for ever, the time is
    infinite.
    """
    state, last = (x, y, vx, vy), slid_on(left, clock, table)
    if last >= 0:
        rides = left == last + RIDES
        if rides:
            (surface, why, t, flags), there = ride(x, y, vx, vy, last, clock, table)
        else:
            (surface, why, t, flags), there = slide(x, y, vx, vy, last, clock, table)
        flags |= STUCK
        if why == HITS:
            x, y, vx, vy = there
            (owner, said, left), _before, after, speeds = landed(surface, 0.0, x, y, vx, vy, clock + t, table)
            # in a corner it stays where it is, on the surface that it slid on: rounding must not push it through that
            normal = speeds[3], speeds[4]
            left, after = at_foot(surface, last, left, x, y, (vx, vy), after, normal, clock + t, table)
            return (surface, owner, t, flags | said, left), there, after, speeds
        if why == STAYS:
            return (surface, -1, INFINITY, flags | NO_IMPACT, left), there, there, NONE
        if why != WAITS:
            left = surface + (OFF if why == LEAVES else ON)
        elif rides:  # where its turning ends that is an impact, or the ball comes loose
            left = 1.0 * last
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
        on = RIDES if turns_at(surface, clock, table) else ON
        return (surface, -1, 0.0, flags, surface + on), state, state, NONE
    if surface < 0:
        return (surface, -1, INFINITY, flags | ESCAPED, left), state, state, NONE
    if not t < INFINITY:
        return (surface, -1, t, flags | DIVERGED, left), state, state, NONE
    (owner, said, now), before, after, speeds = landed(surface, t, x, y, vx, vy, clock, table)
    if said & STUCK and t == 0.0:
        flags &= ~(GRAZE | AMBIGUOUS)
    v = before[2], before[3]
    if table[FEET] > 0.0 or is_slow(left, v, after, table[GRAVITY], table[LENGTH]):
        x, y, normal = after[0], after[1], (speeds[3], speeds[4])
        now, after = at_foot(surface, int(left), now, x, y, v, after, normal, clock + t, table)
    return (surface, owner, t, flags | said, now), before, after, speeds


@inlined
def way_of(t: float, after: Any, g: float) -> Any:
    """Return how far a ball that moves on as an impact left it goes in a time at most."""
    return t * (abs(after[2]) + abs(after[3]) + g * t)


@inlined
def untold(after: Any, length: float) -> Any:
    """Return a way that rounding cannot tell from none."""
    return TOUCH * (abs(after[0]) + abs(after[1]) + length)


@inlined
def takes_no_time(t: float, after: Any, g: float, length: float) -> Any:
    """Say whether a ball that moves on as an impact left it goes no further in a time than rounding can tell."""
    return way_of(t, after, g) <= untold(after, length)


@unit
def jams(left: float, clock: float, state: Any, table: Any) -> Any:
    """Say whether a ball just after an impact is jammed: two things close on it, and impacts without any time go on.

    They do in a narrow corner, too, but turn its velocity there, or slow it down. Where a flipper pushes it and doubles
    no longer tell whether it comes loose it is jammed as well.
    """
    (x, y, vx, vy), (_x, _y, wx, wy) = state, state
    way, turning, same, g, length = 0.0, False, False, table[GRAVITY], table[LENGTH]
    for i in range(JAMMED):
        (surface, _owner, t, flags, left), _before, (x, y, vx, vy), _speeds = next_event(
            x, y, vx, vy, left, clock, table
        )
        way, clock = way + way_of(t, (x, y, vx, vy), g), clock + t
        turning = turning or (surface >= 0 and turns_at(surface, clock, table))
        if flags & (FATAL | ESCAPED) or not way <= JAMMED * untold((x, y, vx, vy), length):
            return turning and i >= AGAIN and flags & AMBIGUOUS > 0
        same = same or (2 * i >= AGAIN and abs(vx - wx) + abs(vy - wy) < SAME_SPEED * (abs(wx) + abs(wy)))
        if i == AGAIN and not turning:
            return same
    return vx * vx + vy * vy > 0.25 * (wx * wx + wy * wy)


@inlined
def jammed(owner: int, t: float, flags: int, left: float, clock: float, after: Any, table: Any) -> Any:
    """Return the flag of a ball that is jammed after an impact, for which it took a time t, at the time ``clock``."""
    if owner < 0 or flags & (FATAL | ESCAPED) or not takes_no_time(t, after, table[GRAVITY], table[LENGTH]):
        return OK
    return TOO_MANY_IMPACTS if jams(left, clock, after, table) else OK


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
            flags |= jammed(owner, length, flags, on, clock + t, after, table)
            return (surface, owner, t, flags, on), before, after, speeds
        still = still + length if on == left and after == (x, y, 0.0, 0.0) else 0.0
        if still > 0.0 and table[FLIPPERS] > 0.0 and still > 2.0 * period_of(table) > 0.0:
            return (surface, -1, t, flags | NO_IMPACT, on), before, after, speeds
        left, (x, y, vx, vy) = on, after
    return (-1, -1, t, flags | TOO_MANY_SWINGS, left), (x, y, vx, vy), (x, y, vx, vy), NONE
