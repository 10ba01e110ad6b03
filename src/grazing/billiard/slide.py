"""A ball that slides or rests on a surface, without friction: how far, and what ends it. Proof: docs/table.md.

Where it stops is geometry and energy, in closed form; only when takes the motion: a uniformly accelerated one on a
line, that of a pendulum on a circle.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

from grazing.billiard.elements import (
    SAME,
    ahead_on_circle,
    ahead_on_line,
    along,
    apart,
    bend_of,
    count_of,
    element,
    gap_of,
    holds,
    is_passed,
    normal_of,
    rises,
    shares_end,
    slid,
    to_end,
    turns_at,
    width_of,
)
from grazing.billiard.faces import RISES, covered, from_end, from_end_of_arc, slack_of
from grazing.billiard.hit import away_of, first_turning, is_open, rows_of
from grazing.billiard.rows import CIRCLES, FACES, GRAVITY, WIDTH
from grazing.billiard.swept import horizon, swept
from grazing.billiard.swing import swing
from grazing.kernel.elementary import arccos, arctan2
from grazing.kernel.primitives import behind, inlined, unit
from grazing.outcome import AMBIGUOUS, OK

INFINITY = float("inf")
#: How many widths a ball may be below a surface that it touches: in a narrow corner rounding adds up.
DEEP = 64.0
#: What ends a slide: an impact with another surface, a surface on which it goes on without a jump, the end of its own,
#: the normal force, a flipper that begins or ends to turn; or nothing.
HITS, ONTO, ENDS, LEAVES, WAITS, STAYS = range(6)


@inlined
def pressing(nx: float, ny: float, bend: float, speed: float, g: float) -> float:
    """Return the normal force on a ball that moves along a surface, by its mass; below 0 it leaves."""
    return g * ny - bend * speed * speed


def until_it_leaves(el: Any, nx: float, ny: float, speed: float, way: float, g: float) -> float:
    """Return how far a ball slides on a circle until the normal force is 0, infinity for for ever: by its energy."""
    bend = bend_of(el)
    if not pressing(nx, ny, bend, speed, g) > 0.0:
        return 0.0
    if g == 0.0:
        return INFINITY
    target = (bend * speed * speed / g + 2.0 * ny) / 3.0
    if target <= -1.0 or el[0] == 0.0:
        return INFINITY
    return max(arccos(min(target, 1.0)) - way * el[0] * arctan2(-nx, ny), 0.0) * el[6]  # type: ignore[no-any-return]


def onto(
    surface: int, el: Any, x: float, y: float, nx: float, ny: float, way: float, clock: float, table: Any
) -> int:  # fmt: skip
    """Return the surface on which a ball goes on at the end of another one, -1 for none."""
    for other in range(count_of(table)):
        if other == surface or turns_at(other, clock, table):
            continue
        to = element(other, clock, table)
        width = width_of(to, x, y)
        fx, fy = along(el, x, y, way, 4.0 * width)
        if abs(gap_of(to, x, y)) <= width and holds(to, fx, fy, width):
            (mx, my), turned = normal_of(to, x, y), width / to[6] if to[0] != 0.0 else 0.0
            if mx * nx + my * ny > 0.5 and abs(mx * ny - my * nx) <= turned + SAME:
                return other
    return -1


def is_bare(surface: int, el: Any, table: Any) -> bool:
    """Say whether the other side of a surface is at the same place: the ball has no radius."""
    if el[0] == 0.0:
        return el[6] == 0.0 and surface < first_turning(table)
    base = 2 * int(table[FACES]) + int(table[CIRCLES])
    if surface < base or surface >= first_turning(table):
        return False
    twin = element(base + ((surface - base) ^ 1), 0.0, table)
    return twin[1] == el[1] and twin[6] == el[6]  # type: ignore[no-any-return]


@inlined
def closes(el: Any, other: Any, x: float, y: float, way: float, width: float) -> Any:
    """Say whether a face that a ball without a radius touches is before it as it moves along a surface.

    So it is on the side on which the ball is: moving to the end that both share or, where that face ends on the middle
    of the surface, as the ball's place says.
    """
    if shares_end(el, other, x, y, width):
        return to_end(el, x, y, way) < to_end(el, x, y, -way)
    return gap_of(other, x, y) >= -width


@unit
def meets(el: Any, at: int, s: float, x: float, y: float, why: int, width: float, clock: float, table: Any) -> Any:
    """Say whether a ball touches what it is about to hit, or a wall at whose foot it is put aside."""
    if why != HITS:
        return False
    to = element(at, clock, table)
    if is_open(int(to[1]), table):  # it holds nothing
        return False
    if s <= width:
        return True
    # what tells is not the same as seen from both ends of a wall
    return to[0] == 0.0 and is_bare(at, to, table) and gap_of(to, x, y) <= 3.0 * apart(to, el, x, y)


@unit
def hidden(
    surface: int, el: Any, other: int, to: Any, x: float, y: float, way: float, width: float, table: Any
) -> Any:  # fmt: skip
    """Say whether what ends where a ball without a radius comes on a surface lies behind that, or behind a face."""
    rows, faces, i, (nx, ny) = rows_of(table), int(table[FACES]), -1, normal_of(el, x, y)
    if to[0] == 0.0:
        i = other // 2
        row = behind(rows, WIDTH * i)
        b, back = from_end(row, x, y, slack_of(row, x, y)), not rises(to, x, y, nx, ny)
    else:
        b = from_end_of_arc(behind(rows, WIDTH * (other - faces)), x, y, 4.0 * DEEP * width)
        back = nx * b[0] + ny * b[1] < -RISES
    return back or covered(i, b, surface, x, y, (way * ny, -way * nx), (nx, ny), faces, rows)


@inlined
def touched(el: Any, other: Any, x: float, y: float, nx: float, ny: float, way: float, width: float) -> Any:
    """Return whether a surface that the ball touches lets it pass: HITS, ONTO, or STAYS for free."""
    mx, my = normal_of(other, x, y)
    rate = way * (nx * my - ny * mx)
    if rate < -SAME:
        return HITS
    if rate <= SAME and mx * nx + my * ny > 0.0 and bend_of(other) < bend_of(el):
        fx, fy = along(el, x, y, way, 4.0 * width)
        if holds(other, fx, fy, width):
            return ONTO
    return STAYS


@unit
def stop(surface: int, x: float, y: float, speed: float, way: float, clock: float, table: Any) -> Any:
    """Return (s, surface, why, flags): how far a ball can slide in one way, and what is there; nothing that turns."""
    el, g, gates = element(surface, clock, table), table[GRAVITY], away_of(table)
    nx, ny = normal_of(el, x, y)
    best, at, why, flags, doubt = to_end(el, x, y, way), -1, ENDS, OK, INFINITY
    leaves = until_it_leaves(el, nx, ny, speed, way, g) if g > 0.0 or el[0] > 0.0 else INFINITY
    if leaves < best:
        best, why = leaves, LEAVES
    for other in range(count_of(table)):
        if other == surface or turns_at(other, clock, table):
            continue
        to = element(other, clock, table)
        width = width_of(to, x, y) + width_of(el, x, y)
        s, how, touch, free, gone = INFINITY, HITS, INFINITY, True, False
        h = gap_of(to, x, y)
        on = h <= width and h >= -DEEP * width and holds(to, x, y, width)
        if on:
            how = touched(el, to, x, y, nx, ny, way, width)
            gone, free = how == HITS and is_passed(other, table), how == STAYS
            if how == HITS and not gone and is_bare(other, to, table):
                # in a corner: what it moves away from is not before it
                fast = speed * way > 0.0 and speed * speed > 2.0 * g * DEEP * width
                if to[0] == 0.0:
                    how = HITS if closes(el, to, x, y, way, width) else STAYS
                elif fast or to_end(el, x, y, -way) <= width:
                    how = STAYS
            s = 0.0 if how != STAYS else INFINITY
        if gone:  # once around a circle it is there again
            s = 2.0 * pi * el[6] if el[0] != 0.0 else INFINITY
        elif free:  # what it moves away from may come again
            how = HITS
            if el[0] == 0.0:
                s, touch = ahead_on_line(x, y, -way * ny, way * nx, to, width)
            else:
                s, joint, touch = ahead_on_circle(el, x, y, way, to, width)
                if joint < s:
                    jx, jy = along(el, x, y, way, joint)
                    mx, my = normal_of(el, jx, jy)
                    if touched(el, to, jx, jy, mx, my, way, width) == ONTO:
                        s, how = joint, ONTO
            if on and s <= width:
                s = INFINITY
        if touch < doubt:  # where both are on one side that is a joint
            jx, jy = along(el, x, y, way, touch)
            mx, my = normal_of(to, jx, jy)
            ax, ay = normal_of(el, jx, jy)
            if mx * ax + my * ay < 0.0 and holds(to, jx, jy, 4.0 * width):
                doubt = touch
        if not s <= best + width:
            continue
        fx, fy = along(el, x, y, way, s)
        if not holds(to, fx, fy, 4.0 * width):
            continue
        if how == HITS and is_bare(other, to, table) and hidden(surface, el, other, to, fx, fy, way, width, table):
            continue
        if at >= 0 and abs(s - best) <= width and how == HITS and why == HITS:
            if to[1] != element(at, clock, table)[1] and min(to[1], element(at, clock, table)[1]) < gates:
                flags |= AMBIGUOUS
        if s < best or at < 0:
            best, at, why = min(s, best), other, how
    if doubt < best:
        flags |= AMBIGUOUS
    return best, at, why, flags


@inlined
def wedged(el: Any, other: Any, x: float, y: float, nx: float, ny: float, way: float) -> Any:
    """Say whether a ball that a force presses along one surface against another one does not slide along that."""
    mx, my = normal_of(other, x, y)
    pushed = -mx  # the force along the other surface, whose direction is (-my, mx), by the gravity
    if pushed == 0.0:
        return True
    turn = 1.0 if pushed > 0.0 else -1.0
    return turn * (-my * nx + mx * ny) <= SAME


@inlined
def motion_on_line(speed: float, fall: float, low: float, high: float) -> Any:
    """Return (t, s, speed, which): when a ball first comes as far as ``high`` >= 0, 1, or ``low`` <= 0, -1."""
    best, at, new, which = INFINITY, 0.0, speed, 0
    for side in range(2):
        way = 1.0 - 2.0 * side
        goal, v, a = (high if side == 0 else -low), way * speed, way * fall
        D = v * v + 2.0 * a * goal
        if not (goal < INFINITY and D >= 0.0) or (v <= 0.0 and a <= 0.0):
            continue
        t = 2.0 * goal / (v + sqrt(D)) if v > 0.0 else (sqrt(D) - v) / a
        if t < best:
            best, at, new, which = t, way * goal, way * sqrt(D), 1 - 2 * side
    return best, at, new, which


@unit
def slide(x: float, y: float, vx: float, vy: float, surface: int, clock: float, table: Any) -> Any:
    """Return ((surface, why, t, flags), (x, y, vx, vy)): how a ball slides on a surface, and what ends that.

    The surface is the one that it then hits or slides on; -1 for a ball that rests.
    """
    el, g = element(surface, clock, table), table[GRAVITY]
    nx, ny = normal_of(el, x, y)
    speed, fall, bend, width = vy * nx - vx * ny, -g * nx, bend_of(el), width_of(el, x, y)
    here = x, y, -ny * speed, nx * speed
    if not pressing(nx, ny, bend, speed, g) > 0.0:  # it leaves, unless a surface that bends less begins here
        s, at, why, flags = stop(surface, x, y, speed, 1.0 if speed > 0.0 else -1.0, clock, table)
        begins = at >= 0 and s <= width
        return (at if begins else surface, why if begins else LEAVES, 0.0, flags), here
    high, above, why_high, said = stop(surface, x, y, speed, 1.0, clock, table)
    low, below, why_low, also = stop(surface, x, y, speed, -1.0, clock, table)
    flags, down, still = said | also, 1.0 if fall >= 0.0 else -1.0, speed == 0.0 and fall == 0.0
    if fall == 0.0 and speed < 0.0:
        down = -1.0
    s, at, why = (high, above, why_high) if down > 0.0 else (low, below, why_low)
    rise = g if speed * down > 0.0 else abs(fall)
    if speed * speed <= 2.0 * rise * DEEP * width and meets(el, at, s, x, y, why, width, clock, table):
        still = fall == 0.0 or wedged(el, element(at, clock, table), x, y, nx, ny, down)
    if speed * fall < 0.0 and speed * speed <= 2.0 * g * DEEP * width:
        up = (high, above, why_high) if speed > 0.0 else (low, below, why_low)
        if meets(el, up[1], up[0], x, y, up[2], width, clock, table):
            speed = 0.0  # it falls away from that
    which, t, far, new, turned = 0, INFINITY, 0.0, speed, 0.0
    if still:
        new, here, high, low = 0.0, (x, y, 0.0, 0.0), 0.0, 0.0
    elif el[0] == 0.0:
        t, far, new, which = motion_on_line(speed, fall, -low, high)
        if speed * fall < 0.0:  # it may turn round just where something is
            goal = high if speed > 0.0 else low
            if abs(speed * speed - 2.0 * abs(fall) * goal) <= 2.0 * abs(fall) * width:
                flags |= AMBIGUOUS
    else:
        upper, lower = (high, low) if el[0] > 0.0 else (low, high)
        t, turned, _rate, which, also = swing(
            arctan2(ny, nx), bend * speed, bend * g, -lower / el[6], upper / el[6], INFINITY
        )
        flags |= also
        which, far = which * int(el[0]), turned / bend
    s, at, why = (high, above, why_high) if which > 0 else (low, below, why_low)
    room = min(max(high, low), 2.0 * el[6]) if el[0] != 0.0 else max(high, low)
    end, busy = horizon(el, x, y, room, clock, table)
    if busy:
        late, hit = swept(surface, x, y, vx, vy, still, min(t, end), clock, table)
        if hit >= 0:
            return (hit, HITS, late, flags), (here if still else slid(surface, x, y, vx, vy, late, clock, table))
    if end < t:
        return (-1 if still else surface, WAITS, end, flags), (
            here if still else slid(surface, x, y, vx, vy, end, clock, table)
        )
    if not t < INFINITY:
        return (-1 if still else surface, STAYS, t, flags), here
    fx, fy = along(el, x, y, 1.0 if far > 0.0 else -1.0, abs(far))
    mx, my = normal_of(el, fx, fy)
    if el[0] != 0.0:  # by its energy
        new = which * sqrt(max(speed * speed + 2.0 * g * (y - fy), 0.0))
    if why == ENDS:
        at = onto(surface, el, fx, fy, mx, my, 1.0 if far > 0.0 else -1.0, clock + t, table)
        why = ONTO if at >= 0 else LEAVES
    return (at if why != LEAVES else surface, why, t, flags), (fx, fy, -my * new, mx * new)
