"""What becomes of a ball up to its next impact, event by event, through gates, with derivatives of all that.

A derivative is carried along as the difference of two orbits at the same time. On a slide it has two numbers, place and
speed along the surface; on a flipper that turns these are taken anew from the four in each ride. At an event, which the
other orbit meets dt later, what jumps there is told apart for that long (saltation: Aizerman and Gantmakher 1958,
Müller 1995). Formulas: docs/table.md.
"""

from __future__ import annotations

from typing import Any

from grazing.billiard.contact import SLIDES, jammed, next_event, slid_on
from grazing.billiard.elements import bend_of, element, normal_of
from grazing.billiard.flippers import SIZE
from grazing.billiard.gates import STROKE, UNTIL, asked, gate_of, gate_under, motion_at, opened, passed_at, shut
from grazing.billiard.hit import away_of, met, period_of
from grazing.billiard.ride import begun, ridden, ridden_by
from grazing.billiard.rows import FACES, FLIPPERS, GRAVITY
from grazing.billiard.slide import pressing
from grazing.billiard.swing import swung_by
from grazing.billiard.turning import OFF, ON, RIDES
from grazing.kernel.elementary import arctan2
from grazing.kernel.primitives import behind, inlined, unit
from grazing.outcome import BAD_LAW, ESCAPED, FATAL, NO_IMPACT, TOO_MANY_SWINGS

#: Of a column of derivatives: those of x, y, vx and vy, or of place and speed on a slide; by how much the clock is
#: ahead; then of each gate, how far its flipper had turned, and until when its button is pressed.
DX, DY, DVX, DVY, AHEAD, OF_GATES = range(6)
DS, DU = 0, 1
OF_TURNED, OF_UNTIL, EACH = range(3)


@unit
def next_carried(
    x: float, y: float, vx: float, vy: float, left: float, clock: float, table: Any, slopes: Any, columns: int,
    width: int,
) -> Any:  # fmt: skip
    """Return what :func:`grazing.billiard.contact.next_impact` does, through gates, and the ball's acceleration before.

    Where there are gates, ``table`` is the ball's own. So many ``columns`` of ``slopes``, each ``width`` numbers, are
    carried along to just before the impact.
    """
    t, flags, still, gates, closed, end = 0.0, 0, 0.0, away_of(table), False, 0.0
    ax, ay, g = 0.0, -table[GRAVITY], table[GRAVITY]
    for _ in range(SLIDES):
        last, now = slid_on(left, clock + t, table), clock + t
        if columns > 0 and last < 0 and left == int(left) + ON:  # what it lay on begins to turn
            loosened(slopes, columns, width, int(left), x, y, vx, vy, now, table)
        found = next_event(x, y, vx, vy, left, now, table)
        (surface, owner, length, said, on), before, after, _speeds = found
        t, end = t + length, now + length
        through = owner >= gates
        if closed:
            closed = opened(owner, surface, after[0], after[1], table)
        flags |= said & ~ESCAPED if through else said
        ax, ay = 0.0, -g
        if columns > 0 and not said & FATAL:
            if last < 0:
                flown_by(slopes, columns, width, length)
            elif left == last + RIDES:
                ax, ay = ridden_along(slopes, columns, width, last, (x, y, vx, vy), now, found, table)
            else:
                ax, ay = slid_by(slopes, columns, width, last, (x, y, vx, vy), now, found, table)
            if owner < 0 and surface >= 0 and on == surface + ON and not (last == surface):
                onto_surface(slopes, columns, width, element(surface, end, table), after)
        if not through and (owner >= 0 or flags & (FATAL | ESCAPED)):
            flags |= jammed(owner, length, flags, on, end, after, table)
            return (surface, owner, t, flags, on), before, after, found[3], (ax, ay)
        still = still + length if on == left and after == (x, y, 0.0, 0.0) else 0.0
        if still > 0.0 and table[FLIPPERS] > 0.0 and still > 2.0 * period_of(table) > 0.0:
            return (surface, -1, t, flags | NO_IMPACT, on), before, after, found[3], (ax, ay)
        if not through:
            left, (x, y, vx, vy) = on, after
            continue
        x, y, vx, vy = before
        rides = left == last + RIDES
        slides = -1 if rides else last
        for i in range(int(table[FACES])):
            side = passed_at(i, surface, x, y, vx, vy, table)
            if side < 0:
                continue
            number = element(side, end, table)[1] - gates
            answer = crossed(number, side, (x, y, vx, vy), slides, end, table, slopes, columns, width)
            if answer < 0:
                return (surface, -1, t, flags | BAD_LAW, on), before, after, found[3], (ax, ay)
            if rides and answer == 1 and number == gate_under(last, table):  # it may turn back: an impact
                left = 1.0 * last
                pushed_on(slopes, columns, width, number, ax, ay + g)
            shut(side, table)
        closed = True
        if last < 0:
            left = -1.0
    return (-1, -1, t, flags | TOO_MANY_SWINGS, left), (x, y, vx, vy), (x, y, vx, vy), found[3], (ax, ay)


@inlined
def crossed(
    number: int, surface: int, state: Any, last: int, clock: float, table: Any, slopes: Any, columns: int, width: int
) -> int:  # fmt: skip
    """Ask at a gate, and let derivatives know what is pressed; return what :func:`asked` does."""
    x, y, vx, vy = state
    gate = gate_of(number, table)
    _turned, rate, by_turned, by_until = motion_at(gate, clock)
    said = asked(number, x, y, vx, vy, clock, table)
    if said == 1 and columns > 0:
        _owner, _x, _y, frame = met(surface, x, y, 0.0, clock, table)
        nx, ny = frame[0], frame[1]
        up = motion_at(gate, clock)[1]
        for k in range(columns):
            one = behind(slopes, width * k)
            own = behind(one, OF_GATES + EACH * number)
            if last < 0:
                late = -(nx * one[DX] + ny * one[DY]) / (nx * vx + ny * vy)
            else:
                late = -one[DS] / speed_on(element(last, clock, table), x, y, vx, vy)
            own[OF_TURNED] = by_turned * own[OF_TURNED] + by_until * own[OF_UNTIL] + (rate - up) * late
            own[OF_UNTIL] = late
    return said


@inlined
def pushed_on(slopes: Any, columns: int, width: int, number: int, ax: float, ay: float) -> None:
    """Let a flipper push for as much longer as a button is pressed later."""
    for k in range(columns):
        one = behind(slopes, width * k)
        late = one[OF_GATES + EACH * number + OF_UNTIL]
        one[DVX] += ax * late
        one[DVY] += ay * late


@inlined
def speed_on(el: Any, x: float, y: float, vx: float, vy: float) -> Any:
    """Return the speed along a surface."""
    nx, ny = normal_of(el, x, y)
    return vy * nx - vx * ny


@inlined
def flown_by(slopes: Any, columns: int, width: int, t: float) -> None:
    """Carry derivatives along a flight."""
    for k in range(columns):
        one = behind(slopes, width * k)
        one[DX] += t * one[DVX]
        one[DY] += t * one[DVY]


@inlined
def onto_surface(slopes: Any, columns: int, width: int, el: Any, after: Any) -> None:
    """Let a ball begin to slide: what derivatives have along the normal is lost."""
    nx, ny = normal_of(el, after[0], after[1])
    for k in range(columns):
        one = behind(slopes, width * k)
        one[DS], one[DU] = one[DY] * nx - one[DX] * ny, one[DVY] * nx - one[DVX] * ny


@inlined
def off_surface(
    slopes: Any, columns: int, width: int, frame: Any, speed: float, force: float, way: float
) -> None:  # fmt: skip
    """Let a slide end: derivatives are those of x, y, vx and vy again.

    The other ball ends it ``-way DS / speed`` later, with a normal force until then.
    """
    nx, ny, bend = frame
    for k in range(columns):
        one = behind(slopes, width * k)
        s, u = one[DS], one[DU]
        away = -bend * speed * s - (force * s / speed * way if way != 0.0 else 0.0)
        one[DX], one[DY] = -ny * s, nx * s
        one[DVX], one[DVY] = -ny * u + away * nx, nx * u + away * ny


def slid_by(slopes: Any, columns: int, width: int, last: int, state: Any, clock: float, found: Any, table: Any) -> Any:
    """Carry derivatives along a slide, and off the surface where it ends there; return the acceleration on it."""
    x, y, vx, vy = state
    (surface, owner, t, _flags, on), (bx, by, bvx, bvy), _after, _speeds = found
    el, g = element(last, clock, table), table[GRAVITY]
    bend, (nx, ny) = bend_of(el), normal_of(el, x, y)
    speed = vy * nx - vx * ny
    aa, ab, ba, bb = 1.0, t, 0.0, 1.0
    if surface < 0 and -g * nx != 0.0 and bvx == 0.0 and bvy == 0.0:  # something holds it
        aa, ab, ba, bb = 0.0, 0.0, 0.0, 0.0
    elif bend != 0.0:
        aa, ab, ba, bb = swung_by(arctan2(ny, nx), bend * speed, bend * g, t)
    for k in range(columns):
        one = behind(slopes, width * k)
        one[DS], one[DU] = aa * one[DS] + ab * one[DU], ba * one[DS] + bb * one[DU]
    nx, ny = normal_of(el, bx, by)
    speed = bvy * nx - bvx * ny
    force = pressing(nx, ny, bend, speed, g)
    if owner >= away_of(table) or on == last + ON:  # it goes on
        return force * nx, force * ny - g
    off_surface(slopes, columns, width, (nx, ny, bend), speed, force, 1.0 if on == surface + OFF else 0.0)
    return force * nx, force * ny - g


@inlined
def ahead_of(one: Any, surface: int, t: float, table: Any) -> Any:
    """Return by how much what is at a surface is ahead: a flipper that has turned more."""
    number = gate_under(surface, table)
    if number < 0:
        return one[AHEAD]
    own = behind(one, OF_GATES + EACH * number)
    _turned, rate, by_turned, by_until = motion_at(gate_of(number, table), t)
    return (by_turned * own[OF_TURNED] + by_until * own[OF_UNTIL]) / rate if rate != 0.0 else 0.0


@inlined
def moves_on(one: Any, surface: int, later: float, clock: float, t: float, table: Any) -> Any:
    """Return by how much later the motion of a flipper that turns from ``clock`` on changes, which it does at t.

    Where it stops that is earlier by what it is ahead; where its button is released, by how much later that is.
    """
    number = gate_under(surface, table)
    if number < 0:
        return -later
    gate = gate_of(number, table)
    turned, rate, _by_turned, _by_until = motion_at(gate, clock)
    end, top = clock + t, turned + rate * t
    released = rate > 0.0 and rate * abs(gate[UNTIL] - end) < abs(gate[STROKE] - top)
    return behind(one, OF_GATES + EACH * number)[OF_UNTIL] if released else -later


def ridden_along(
    slopes: Any, columns: int, width: int, last: int, state: Any, clock: float, found: Any, table: Any
) -> Any:  # fmt: skip
    """Carry derivatives along a slide on a flipper that turns, and off it; return the acceleration on it.

    The other ball leaves the end of the side later, or the flipper moves on otherwise under it: with a normal force
    until then.
    """
    x, y, vx, vy = state
    (surface, owner, t, _flags, on), _before, _after, _speeds = found
    (row, _way, omega), (s, q, nx, ny) = begun(x, y, vx, vy, last, clock, table)
    g, size = table[GRAVITY], row[SIZE]
    there, rate, mx, my = ridden(s, q, nx, ny, omega, g, t)
    force = g * my - omega * (2.0 * rate + omega * size)
    for k in range(columns):
        one = behind(slopes, width * k)
        later = ahead_of(one, last, clock, table)
        turn = omega * later
        ds, dq = one[DY] * nx - one[DX] * ny - size * turn, one[DVY] * nx - one[DVX] * ny + omega * s * turn
        ds, dq = ridden_by(ds, dq, turn, nx, ny, omega, g, t)
        along, away = ds + size * turn, -there * turn
        beside, off = dq - omega * there * turn, -omega * ds - (rate + omega * size) * turn
        if owner < 0 and on == last:
            off += force * moves_on(one, last, later, clock, t, table)
        elif on == surface + OFF and rate != 0.0:
            off -= force * ds / rate
        one[DX], one[DY] = along * -my + away * mx, along * mx + away * my
        one[DVX], one[DVY] = beside * -my + off * mx, beside * mx + off * my
    return force * mx, force * my - g


def loosened(
    slopes: Any, columns: int, width: int, last: int, x: float, y: float, vx: float, vy: float, clock: float, table: Any
) -> None:  # fmt: skip
    """Let a flipper begin to turn under a ball: that does not depend on where the ball is."""
    el, number = element(last, clock, table), gate_under(last, table)
    nx, ny = normal_of(el, x, y)
    speed, bend = vy * nx - vx * ny, bend_of(el)
    force = pressing(nx, ny, bend, speed, table[GRAVITY])
    off_surface(slopes, columns, width, (nx, ny, bend), speed, force, 0.0)
    for k in range(columns):
        one = behind(slopes, width * k)
        late = -one[AHEAD] if number < 0 else one[OF_GATES + EACH * number + OF_UNTIL]
        one[DVX] += force * late * nx
        one[DVY] += force * late * ny
