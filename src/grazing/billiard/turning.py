"""When a flight meets a side or the tip of a flipper that turns. Proof: docs/table.md.

The gap of a surface that turns is no polynomial: it is marched along by h(t + s) >= h + dh s + (k - B s) s^2, with the
second derivative 2 k now and a bound 6 B of the third one on what is left of the flight.
"""

from __future__ import annotations

from math import floor, sqrt
from typing import Any

from grazing.billiard.flippers import (
    ARM,
    AT_TIP,
    BEGIN,
    CX,
    CY,
    KINDS,
    LONG,
    OMEGA,
    PERIOD,
    PIECE_WIDTH,
    PIECES,
    PX,
    PY,
    REACH,
    SINE,
    SIZE,
    TIP,
)
from grazing.billiard.flippers import COSINE as LEAN
from grazing.billiard.gaps import (
    DEEP,
    EPS,
    GAP,
    LOOKS,
    ROOTS,
    crossing,
    first_guess,
    rests,
    safe_step,
    slid_off,
    touches,
)
from grazing.billiard.gaps import LEAST as SHORT
from grazing.kernel.elementary import sincos
from grazing.kernel.primitives import behind, inlined
from grazing.outcome import AMBIGUOUS, DIVERGED, FATAL, GRAZE, INSIDE_WALL, OK, STUCK, TOO_MANY_IMPACTS, TOO_MANY_SWINGS

INFINITY = float("inf")
#: What is added to the number of a surface: a ball slides on it, or while it turns, or has slid off it.
ON, RIDES, OFF = 0.5, 0.75, 0.25
#: Pieces of a flipper's motion that are looked at in one flight, after which it ends by name.
MOST = 1_000_000
#: A share of all sizes by which a ball is clear of a flipper, far more than rounding; most that may turn meanwhile.
CLEAR, QUARTER = 2.0**-40, 1.5
#: Times that the end of what a bound has to hold for is brought forward, to twice the step that it allows.
NARROWED = 3


@inlined
def clock_of(clock: float, row: Any) -> Any:
    """Return where in its motion a flipper is: the time, reduced by its period where there is one."""
    return clock % row[PERIOD] if row[PERIOD] > 0.0 else clock


@inlined
def begin_of(piece: int, turns: float, phase: float, row: Any, pieces: Any) -> Any:
    """Return when a piece of a motion begins, as a time of a flight that begins at ``phase``, some periods later."""
    if piece >= int(row[PIECES]):
        return (turns + 1.0) * row[PERIOD] - phase if row[PERIOD] > 0.0 else INFINITY
    return pieces[PIECE_WIDTH * piece + BEGIN] + turns * row[PERIOD] - phase


def piece_at(t: float, phase: float, row: Any, pieces: Any) -> Any:
    """Return (piece, turns): the piece of a motion at a time of a flight, and how many periods later that is."""
    turns, piece = 0.0, 0
    if row[PERIOD] > 0.0:
        turns = max(floor((phase + t) / row[PERIOD]), 0.0)
        if begin_of(int(row[PIECES]), turns, phase, row, pieces) <= t:
            turns += 1.0
        elif turns > 0.0 and turns * row[PERIOD] - phase > t:
            turns -= 1.0
    low, high = 0, int(row[PIECES])
    while high - low > 1:
        piece = (low + high) // 2
        if begin_of(piece, turns, phase, row, pieces) <= t:
            low = piece
        else:
            high = piece
    return low, turns


@inlined
def direction_at(t: float, begin: float, piece: Any) -> Any:
    """Return (x, y, angle turned): the direction of a flipper at a time of a flight, in a piece of its motion."""
    cx, cy = piece[CX], piece[CY]
    if piece[OMEGA] == 0.0 or t == begin:
        return cx, cy, 0.0
    turned = piece[OMEGA] * (t - begin)
    s, c = sincos(turned)
    return c * cx - s * cy, s * cx + c * cy, abs(turned)


@inlined
def normal_at(kind: int, ux: float, uy: float, row: Any) -> Any:
    """Return the unit vector along which a gap is measured: the normal of a side, the direction of the tip."""
    if kind == AT_TIP:
        return ux, uy
    side = (1.0 - 2.0 * kind) * row[LEAN]
    return row[SINE] * ux - side * uy, row[SINE] * uy + side * ux


@inlined
def look(t: float, flight: Any, kind: int, row: Any, begin: float, piece: Any) -> Any:
    """Return (h, dh, k), their errors (e, d, b), and (speed, distance from the pivot) at a time of a flight.

    ``flight`` is (dx, dy, vx, vy, g, x, y), the place as seen from the pivot first.
    """
    dx, dy, vx, vy, g, _x, _y = flight
    omega = piece[OMEGA]
    ux, uy, turned = direction_at(t, begin, piece)
    nx, ny = normal_at(kind, ux, uy, row)
    now, x, y = vy - g * t, dx + vx * t, dy + (vy - 0.5 * g * t) * t
    f, df = nx * x + ny * y, nx * vx + ny * now + omega * (nx * y - ny * x)
    bend = 0.5 * (2.0 * omega * (nx * now - ny * vx) - g * ny - omega * omega * f)
    spin, many = abs(omega), 1.0 + turned
    fast, far2 = abs(vx) + abs(vy) + g * t, x * x + y * y
    far, u = abs(dx) + abs(dy) + fast * t, GAP * EPS
    at = sqrt(vx * vx + now * now), sqrt(far2)
    if kind != AT_TIP:
        size, swing = row[SIZE], fast + spin * far
        return (
            (f - size, df, bend),
            (u * (many * far + size), u * many * swing, u * many * (g + spin * (swing + fast))),
            at,
        )
    arm, size = row[ARM], row[TIP]
    h, dh = far2 - 2.0 * arm * f + (arm - size) * (arm + size), 2.0 * (x * vx + y * now - arm * df)
    k, two, swing = at[0] * at[0] - g * y - 2.0 * arm * bend, 2.0 * arm * many, fast + spin * far
    e, d = u * (far * (far + two) + arm * arm + size * size), u * (far * fast + two * swing)
    return (h, dh, k), (e, d, u * (fast * fast + g * far + two * (g + spin * (swing + fast)))), at


@inlined
def third(w: float, at: Any, g: float, kind: int, row: Any, omega: float) -> Any:
    """Return a bound B of a sixth of the third derivative of a gap on the time w to come."""
    speed, spin = at[0] + g * w, abs(omega)
    far = at[1] + speed * w
    most = spin * (3.0 * g + spin * (3.0 * speed + spin * far)) / 6.0
    if kind == AT_TIP:
        most = g * speed + 2.0 * row[ARM] * most
    return most * (1.0 + GAP * EPS)


@inlined
def longest(low: float, fall: float, k: float, at: Any, g: float, kind: int, row: Any, omega: float, w: float) -> Any:
    """Return a time up to w for which a gap is surely not down at 0."""
    step = 0.0
    for _ in range(NARROWED):
        bound = third(w, at, g, kind, row, omega) * w if omega != 0.0 else 0.0
        new = safe_step(low, fall, k - bound)
        if new >= w:
            return w
        step = max(step, new)
        w = min(w, 2.0 * step)
    return step


def landing(h: float, dh: float, k: float, sign: float, t: float, reach: float, flight: Any, kind: int, row: Any,
            begin: float, piece: Any) -> float:  # fmt: skip
    """Return the root in [0, reach] of a gap at t + s, in which it falls throughout.

    The first guess is that of its second derivative now; a gap within its rounding is good for one more step.
    """
    s, a, b = first_guess(h, dh, k, reach), 0.0, reach
    for _ in range(ROOTS):
        (h, dh, _k), (e, _d, _b), _at = look(t + s, flight, kind, row, begin, piece)
        h, dh = sign * h, sign * dh
        if h > 0.0:
            a = s
        else:
            b = s
        new = s - h / dh if dh < 0.0 else 0.5 * (a + b)
        if not a <= new <= b:
            new = 0.5 * (a + b)
        if abs(h) <= e or abs(new - s) <= 2.0 * EPS * s or not a < b:
            return new
        s = new
    return s


@inlined
def turned(
    seen: Any, flight: Any, kind: int, row: Any, begin: float, piece: Any, sign: float, start: float, fresh: bool,
    end: float,
) -> Any:  # fmt: skip
    """Return (t, late, flags): when sign times a gap first comes down to 0 after ``start``, good to ``late``.

    As :func:`grazing.billiard.gaps.crossing`, in one piece of a flipper's motion; ``seen`` is the look at ``start``.
    """
    t, doubt, flags, omega, g = start, INFINITY, OK, piece[OMEGA], flight[4]
    for _ in range(LOOKS):
        (h, dh, bend), (e, d, b), at = seen
        h, dh, bend, w = sign * h, sign * dh, sign * bend, end - t
        if not (e < INFINITY and b < INFINITY):
            return t, 0.0, flags | DIVERGED
        if fresh:
            low, fall = 0.0, max(dh - d, 0.5 * dh, 0.0)
        else:
            up, rate, low, fall = h + e, dh + d, max(h - e, 0.0), dh - d
            if h < -e and doubt < INFINITY and rate >= 0.0:  # through and back, by less than can be decided
                return doubt, t - doubt, flags
            if rate < 0.0:
                if up <= 0.0 and doubt < INFINITY:
                    return doubt, t - doubt, flags
                near = min(4.0 * max(up, 0.0) / -rate, w)
                most = max(bend + b + third(near, at, g, kind, row, omega) * near, 0.0)
                D = rate * rate - 4.0 * most * up
                reach = 2.0 * up / (sqrt(D) - rate) if up > 0.0 and D > 0.0 else INFINITY
                if up <= 0.0 or reach <= near:
                    s = landing(h, dh, bend, sign, t, reach, flight, kind, row, begin, piece) if h > 0.0 else 0.0
                    return t + s, (e + d * near) / -rate + 4.0 * EPS * t, flags
        step = longest(low, fall, bend - b, at, g, kind, row, omega, w) * (1.0 - GAP * EPS) - 2.0 * EPS * t
        if step >= w * (1.0 - 2.0 * GAP * EPS) - 4.0 * EPS * t:
            return INFINITY, 0.0, flags
        if low > 0.0:
            doubt = INFINITY
        if not t + step > t or (low < e and not fresh):
            wide = 2.0 * sqrt(e / (abs(bend) + b))
            if fall != 0.0:
                wide = min(wide, 4.0 * e / abs(fall))
            if not t + step > t or step < SHORT * wide:
                flags |= GRAZE | AMBIGUOUS
                doubt, step = t, max(wide, 4.0 * EPS * t)
                if not t + step > t:
                    return t, 0.0, flags | TOO_MANY_IMPACTS
                if t + step >= end:
                    return INFINITY, 0.0, flags
        t, fresh = t + step, False
        seen = look(t, flight, kind, row, begin, piece)
    return t, 0.0, flags | TOO_MANY_SWINGS


@inlined
def at_surface(
    flight: Any, kind: int, row: Any, begin: float, piece: Any, start: float, fresh: bool, end: float
) -> Any:
    """Return (t, late, flags, apart): when a surface of a flipper is hit first in a piece of its motion.

    That is infinity for never. A crossing of the line of a side beyond its ends is none: the ball is then behind the
    line, until it comes back. ``apart``: up to the hit that line is between ball and flipper: nothing else is hit.
    """
    flags, outside, t, omega, apart = OK, True, start, piece[OMEGA], kind != AT_TIP
    for n in range(LOOKS):
        seen = look(t, flight, kind, row, begin, piece)
        if n == 0:
            (h, dh, k), (e, d, b), _at = seen
            leaves = fresh and omega != 0.0 and k > b and abs(dh) <= d  # if as fast as nothing at first
            if fresh:
                if rests(dh, k, e):
                    return t, 0.0, TOO_MANY_IMPACTS if omega != 0.0 and kind == AT_TIP else STUCK, False
                if not leaves and (dh < -d or (dh <= 0.0 and k <= 0.0)):  # it has begun to move towards the ball
                    return t, e / max(-dh, d), OK, False
            if kind == AT_TIP and omega == 0.0:
                cx, cy = row[PX] + row[ARM] * piece[CX], row[PY] + row[ARM] * piece[CY]
                _dx, _dy, vx, vy, g, x, y = flight
                t, late, said = crossing(x - cx, y - cy, vx, vy, g, row[TIP], 1.0, t, fresh, end)
                return t, late, said, False
            outside = kind == AT_TIP or (fresh and not leaves) or h >= -e
            if leaves:
                t, fresh = clear_until(flight, kind, row, begin, piece, end), False
                continue
        t, late, said = turned(seen, flight, kind, row, begin, piece, 1.0 if outside else -1.0, t, fresh, end)
        flags |= said
        apart = apart and outside and said == OK
        if t == INFINITY or said & FATAL or kind == AT_TIP:
            return t, late, flags, apart
        if outside:
            foot, unsure = foot_at(t, flight, kind, row, begin, piece)
            unsure += late * (abs(flight[2]) + abs(flight[3]) + flight[4] * t + abs(omega) * row[REACH])
            if foot >= -unsure and foot <= row[LONG] + unsure:
                return t, late, flags, apart
        outside, fresh, apart = not outside, True, False
    return t, 0.0, flags | TOO_MANY_SWINGS, False


@inlined
def foot_at(t: float, flight: Any, kind: int, row: Any, begin: float, piece: Any) -> Any:
    """Return (foot, error): how far along a side of a flipper the ball's centre is."""
    dx, dy, vx, vy, g, _x, _y = flight
    ux, uy, turned_by = direction_at(t, begin, piece)
    nx, ny = normal_at(kind, ux, uy, row)
    x, y, way = dx + vx * t, dy + (vy - 0.5 * g * t) * t, 1.0 - 2.0 * kind
    far = abs(dx) + abs(dy) + (abs(vx) + abs(vy) + g * t) * t
    return way * (ny * x - nx * y), GAP * EPS * (1.0 + turned_by) * far


@inlined
def comes_near(t: float, flight: Any, row: Any, end: float) -> Any:
    """Return a time from t on before which the ball is surely too far from a flipper to touch it."""
    dx, dy, vx, vy, g, _x, _y = flight
    now, x, y, w = vy - g * t, dx + vx * t, dy + (vy - 0.5 * g * t) * t, end - t
    far2, size, fast = x * x + y * y, row[REACH], abs(vx) + abs(vy) + g * t
    far = abs(dx) + abs(dy) + fast * t
    h, dh = far2 - size * size, 2.0 * (x * vx + y * now)
    e, d = GAP * EPS * (far * (abs(x) + abs(y)) + size * size), GAP * EPS * far * fast
    if h - e <= 0.0:
        return t
    c3, a4, s = -g * now, 0.25 * g * g, w
    if c3 >= 0.0:
        s = 0.0
    elif a4 > 0.0:
        s = min(-0.5 * c3 / a4, w)
    least = (c3 + a4 * s) * s if s < INFINITY else -INFINITY
    k = vx * vx + now * now - g * y + least - GAP * EPS * (fast * fast + g * (far + size))
    return t + safe_step(h - e, dh - d, k) * (1.0 - GAP * EPS)


@inlined
def clear_of(t: float, end: float, flight: Any, row: Any, begin: float, piece: Any) -> Any:
    """Return for each surface of a flipper whether a ball surely does not come to it from t to ``end``, in one piece.

    And the side on which it is at first.

    It stays on one side of all that the flipper sweeps, or of its axis, or nearer to the pivot than the tip is: its
    parabola leaves its chord by g (end - t)^2/8 at most.
    """
    dx, dy, vx, vy, g, _x, _y = flight
    omega, w, tip = piece[OMEGA], end - t, row[TIP]
    ax, ay, _turned = direction_at(t, begin, piece)
    px, py = dx + vx * t, dy + (vy - 0.5 * g * t) * t
    side = 0 if ax * py - ay * px >= 0.0 else 1
    if not (end < INFINITY and abs(omega) * w <= QUARTER):
        return (False, False, False), side
    bx, by, turned = direction_at(end, begin, piece)
    qx, qy = dx + vx * end, dy + (vy - 0.5 * g * end) * end
    far = abs(dx) + abs(dy) + (abs(vx) + abs(vy) + g * end) * end
    slack = 0.125 * g * w * w + CLEAR * (1.0 + turned) * (far + row[REACH])
    # of the leftmost direction and the rightmost one: how far left, or right, the ball stays, and how far along a side
    lx, ly = (bx, by) if omega > 0.0 else (ax, ay)
    rx, ry = (ax, ay) if omega > 0.0 else (bx, by)
    lp, lq, rp, rq = lx * py - ly * px, lx * qy - ly * qx, rx * py - ry * px, rx * qy - ry * qx
    left, right, lean, sine = min(lp, lq) - slack, -max(rp, rq) - slack, row[LEAN], abs(row[SINE])
    least = min(lean * (lx * px + ly * py) - sine * abs(lp), lean * (lx * qx + ly * qy) - sine * abs(lq))
    least = min(least, lean * (rx * px + ry * py) - sine * abs(rp), lean * (rx * qx + ry * qy) - sine * abs(rq))
    clear, short = max(left, right) > max(row[SIZE], tip), row[ARM] - tip - slack
    beside = clear or least - slack > row[LONG]
    within = short > 0.0 and max(px * px + py * py, qx * qx + qy * qy) < short * short
    return (beside or right > 0.0, beside or left > 0.0, within or max(left, right) > tip), side


def of_flipper(
    x: float, y: float, vx: float, vy: float, g: float, last: int, off: float, clock: float, row: Any, pieces: Any,
    end: float,
) -> Any:  # fmt: skip
    """Return (kind, t, late, flags): the first contact with a flipper before ``end``, infinity for none.

    ``last`` is the kind of the surface of this flipper that the ball just left, -1 for none; ``off`` is OFF if it slid
    off that, ON if it lay on it, and 0 for neither.
    """
    flight, phase, t, flags = (x - row[PX], y - row[PY], vx, vy, g, x, y), clock_of(clock, row), 0.0, OK
    over = last >= 0 and off == 0.0 and slips_over(flight, last, phase, row, pieces)
    off = OFF if over else off
    if last < 0:
        t = comes_near(0.0, flight, row, end)
        if not t < end:
            return -1, INFINITY, 0.0, OK
        if t == 0.0 and is_inside(flight, phase, row, pieces):
            return AT_TIP, 0.0, 0.0, INSIDE_WALL
    for _ in range(MOST):
        number, turns = piece_at(t, phase, row, pieces)
        piece, begin = behind(pieces, PIECE_WIDTH * number), begin_of(number, turns, phase, row, pieces)
        until = min(begin_of(number + 1, turns, phase, row, pieces), end)
        kind, first, slack, apart = -1, INFINITY, 0.0, False
        clear, side = clear_of(t, until, flight, row, begin, piece)
        for n in range(KINDS):
            i = abs(side - n) if n < AT_TIP else n  # the side on which the ball is before the other one
            if clear[i] or (apart and i != last):
                continue
            begins, slips = t, off > 0.0 and t == 0.0
            slips = slips and ((over and i == AT_TIP) or beside(flight, i, last == i, row, begin, piece))
            if slips and piece[OMEGA] != 0.0 and off == OFF:
                begins = clear_until(flight, i, row, begin, piece, until)
            if slips and piece[OMEGA] == 0.0:
                found, late, said = off_tip(flight, i, row, piece, until)
            else:
                found, late, said, apart = at_surface(
                    flight, i, row, begin, piece, begins, last == i and begins == 0.0, until
                )
            flags |= said
            if said & (FATAL | STUCK):
                return i, found, 0.0, flags
            if found < first:
                kind, first, slack = i, found, late
                until = min(until, found)
        if kind >= 0:
            return kind, first, slack, flags
        t = until
        if not t < end:
            return -1, INFINITY, 0.0, flags
        t = comes_near(t, flight, row, end)
        if not t < end:
            return -1, INFINITY, 0.0, flags
    return -1, t, 0.0, flags | TOO_MANY_SWINGS


def beside(flight: Any, kind: int, left: bool, row: Any, begin: float, piece: Any) -> Any:
    """Say whether a ball that has slid off something slid off this surface of a flipper, or off the end of it."""
    (h, dh, _k), (e, _d, _b), _at = look(0.0, flight, kind, row, begin, piece)
    unit = 2.0 * row[TIP] if kind == AT_TIP else 1.0  # that gap is the difference of two squares
    fast = unit * (abs(flight[2]) + abs(flight[3]))
    return left or ((kind != AT_TIP or piece[OMEGA] != 0.0) and touches(h, dh, e, fast))


def slips_over(flight: Any, last: int, phase: float, row: Any, pieces: Any) -> bool:
    """Say whether a ball leaves a surface of a flipper along that, where the next one begins, and neither holds it.

    Rounding may put it behind that one, which has the same normal there: it meets neither, as one that slid off.
    """
    number, turns = piece_at(0.0, phase, row, pieces)
    piece, begin = behind(pieces, PIECE_WIDTH * number), begin_of(number, turns, phase, row, pieces)
    fast, joined = abs(flight[2]) + abs(flight[3]), False
    for n in range(KINDS):
        i = (last + n) % KINDS
        (h, dh, k), (e, _d, b), _at = look(0.0, flight, i, row, begin, piece)
        unit = 2.0 * row[TIP] if i == AT_TIP else 1.0
        if touches(0.0 if i == last else h, dh, e, unit * fast):
            joined = joined or i != last
            if k < b:
                return False
        elif i == last:
            return False
    return joined


def clear_until(flight: Any, kind: int, row: Any, begin: float, piece: Any, end: float) -> Any:
    """Return until when a ball that slid off a flipper that turns surely does not come back to one of its surfaces.

    The gap and its rate are 0 at t = 0; so is its second derivative where the normal force has fallen to 0.
    """
    (_h, _dh, k), (_e, _d, b), at = look(0.0, flight, kind, row, begin, piece)
    (dx, dy, vx, vy, g, _x, _y), omega = flight, piece[OMEGA]
    spin = abs(omega)
    w = min(end, 1.0 / spin)
    clear = 0.5 * max(abs(k) - b, 0.0) / third(w, at, g, kind, row, omega)
    if k < -b or kind == AT_TIP:  # it is beyond the end of a side, and goes behind the line of that
        return min(w, clear)
    ux, uy, _turned = direction_at(0.0, begin, piece)
    nx, ny = normal_at(kind, ux, uy, row)
    swing = omega * (nx * dy - ny * dx) + 3.0 * (nx * vx + ny * vy)
    speed, c3 = at[0] + g * w, -omega * (omega * swing + 3.0 * g * nx)
    most = spin * spin * (6.0 * g + spin * (4.0 * speed + spin * (at[1] + speed * w)))
    return min(w, max(clear, 2.0 * max(c3, 0.0) / most))  # a second derivative above 0 only helps


@inlined
def off_tip(flight: Any, kind: int, row: Any, piece: Any, end: float) -> Any:
    """Return when a ball that slid off a flipper at rest comes back to its tip before ``end``; to sides it does not."""
    if kind != AT_TIP:
        return INFINITY, 0.0, OK
    _dx, _dy, vx, vy, g, x, y = flight
    cx, cy = row[PX] + row[ARM] * piece[CX], row[PY] + row[ARM] * piece[CY]
    t, late, said = slid_off(x - cx, y - cy, vx, vy, g, row[TIP], 1.0)
    return (t, late, said) if t < end else (INFINITY, 0.0, said)


def is_inside(flight: Any, phase: float, row: Any, pieces: Any) -> bool:
    """Say whether a ball surely overlaps a flipper at the begin of a flight, its hub apart."""
    number, turns = piece_at(0.0, phase, row, pieces)
    piece, begin = behind(pieces, PIECE_WIDTH * number), begin_of(number, turns, phase, row, pieces)
    (h, _dh, _k), (e, _d, _b), _at = look(0.0, flight, AT_TIP, row, begin, piece)
    if h < -DEEP * e:
        return True
    for kind in range(AT_TIP):
        (h, _dh, _k), (e, _d, _b), _at = look(0.0, flight, kind, row, begin, piece)
        foot, unsure = foot_at(0.0, flight, kind, row, begin, piece)
        if not (h < -DEEP * e and foot > unsure and foot < row[LONG] - unsure):
            return False
    return True
