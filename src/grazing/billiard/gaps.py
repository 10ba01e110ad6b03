"""When a flight meets one surface of a table. Proof: docs/table.md.

Flights are parabolas, so a gap is a polynomial: quadratic for a face, which is solved; quartic for a circle, whose
first root is marched to by lower bounds h(t + s) >= h + dh s + k s^2 that are proven on what is left of the flight.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

from grazing.kernel.primitives import inlined
from grazing.outcome import AMBIGUOUS, DIVERGED, GRAZE, INSIDE_WALL, OK, STUCK, TOO_MANY_IMPACTS, TOO_MANY_SWINGS

INFINITY = float("inf")
EPS = 2.0**-52
#: Rounding errors in units of the last place of the sizes that a number is made of, see docs/table.md.
GAP = 16.0
#: Errors of a gap by which a ball may begin below a surface.
DEEP = 64.0
#: A share of the speed that is none: a ball that moves along a surface.
ALONG = 2.0**-40
#: Looks at one surface in one flight after which it ends by name.
LOOKS = 10_000
#: A step shorter than so many widths of the rounding error is none.
LEAST = 1e-3
#: Steps of Newton's method from where it surely converges.
ROOTS = 60
#: What a look at a circle finds.
ON, HIT, MISSED, NEAR = range(4)


@inlined
def lowest(c3: float, a4: float, w: float) -> float:
    """Return the least value of c3 s + a4 s^2 for s in [0, w], a4 >= 0."""
    s = w
    if c3 >= 0.0:
        s = 0.0
    elif a4 > 0.0:
        s = min(c3 * (-0.5 / a4), w)  # the quotient is the same for all that fall alike
    return (c3 + a4 * s) * s if s < INFINITY else -INFINITY


@inlined
def highest(c3: float, a4: float, w: float) -> float:
    """Return the greatest value of c3 s + a4 s^2 for s in [0, w], a4 >= 0."""
    if w < INFINITY:
        return max(0.0, (c3 + a4 * w) * w)
    return INFINITY if a4 > 0.0 or c3 > 0.0 else 0.0


@inlined
def safe_step(h: float, dh: float, k: float) -> float:
    """Return the first root s > 0 of h + dh s + k s^2 with h >= 0, infinity for none; if h is 0, dh is not yet down."""
    D = dh * dh - 4.0 * k * h
    if ((dh >= 0.0) & (k >= 0.0)) | (D < 0.0):
        return INFINITY
    if not k > -INFINITY:
        return 0.0
    root = sqrt(D)
    return (2.0 * h if dh < 0.0 else -(dh + root)) / (root - dh if dh < 0.0 else 2.0 * k)


@inlined
def rests(dh: float, k: float, e: float) -> bool:
    """Say whether a ball that leaves a surface at rate dh and is pulled back rises by less than can be told."""
    return (k < 0.0) & (dh * dh <= -4.0 * k * e)


@inlined
def touches(h: float, dh: float, e: float, speed: float) -> bool:
    """Say whether a gap and its rate are 0 up to rounding: a ball that slides off beside the end of a surface."""
    return abs(h) <= DEEP * e and abs(dh) <= ALONG * speed


@inlined
def nearer_root(s: float, a: float, b: float, h: float, dh: float, k: float, c3: float, a4: float) -> Any:
    """Return (s, a, b, done) after a step of Newton's method for the root in [a, b], halved where it leaves that."""
    value = (((a4 * s + c3) * s + k) * s + dh) * s + h
    rate = ((4.0 * a4 * s + 3.0 * c3) * s + 2.0 * k) * s + dh
    if value > 0.0:
        a = s
    else:
        b = s
    middle = 0.5 * (a + b)
    new = s - value / rate if rate < 0.0 else middle
    new = new if (a <= new) & (new <= b) else middle
    return new, a, b, (abs(new - s) <= 2.0 * EPS * s) | (not a < b)


@inlined
def first_guess(h: float, dh: float, k: float, reach: float) -> float:
    """Return where Newton's method begins: the root of the parabola, if it has one in [0, reach]."""
    D = dh * dh - 4.0 * k * h
    return min(2.0 * h / (sqrt(D) - dh), reach) if D > 0.0 else 0.0


def landing(h: float, dh: float, k: float, c3: float, a4: float, reach: float) -> float:
    """Return the root of h + dh s + k s^2 + c3 s^3 + a4 s^4 in [0, reach], in which it falls throughout."""
    s, a, b = first_guess(h, dh, k, reach), 0.0, reach
    for _ in range(ROOTS):
        s, a, b, done = nearer_root(s, a, b, h, dh, k, c3, a4)
        if done:
            break
    return s


@inlined
def seen(
    dx: float, dy: float, vx: float, vy: float, g: float, size: float, sign: float, t: float, fresh: bool, end: float
) -> Any:  # fmt: skip
    """Return what can be told of the gap of a circle from the time t of a flight on, see :func:`crossing`.

    Returns
    -------
    (h, dh, k, c3), (e, d, finite), (near, rate, up, reach), (w, low, fall, k, step)
        The polynomial; its errors; until when it is looked at closer, an upper bound at t and in (0, near], where the
        only root is up to ``reach`` if that is not beyond; what is left, the lower bound, and its first root.
    """
    a4, size2 = 0.25 * g * g, size * size
    now = vy - g * t
    x, y = dx + vx * t, dy + (vy - 0.5 * g * t) * t
    fast = abs(vx) + abs(vy) + g * t
    far = abs(dx) + abs(dy) + fast * t
    h, dh = sign * (x * x + y * y - size2), sign * 2.0 * (x * vx + y * now)
    bend, c3, w = vx * vx + now * now - g * y, -g * now, end - t
    e, d = GAP * EPS * (far * (abs(x) + abs(y)) + size2), GAP * EPS * far * fast
    b = GAP * EPS * (fast * fast + g * (far + size))
    if sign < 0.0 and fast + g > 0.0:  # it is inside, and does not stay there
        w = min(w, 2.0 * size / sqrt(vx * vx + now * now + g * size))
    up, rate, low, fall = h + e, dh + d, max(h - e, 0.0), dh - d
    if fresh:
        low, fall = 0.0, max(fall, 0.5 * dh, 0.0)
    near = min(4.0 * max(up, 0.0) / -rate, w) if rate < 0.0 else 0.0
    most = highest(3.0 * c3, 6.0 * a4, near) if sign > 0.0 else -lowest(3.0 * c3, 6.0 * a4, near)
    most = max(sign * bend + most * (1.0 + GAP * EPS) + b, 0.0)
    D = rate * rate - 4.0 * most * up
    reach = 2.0 * up / (sqrt(D) - rate) if (rate < 0.0) & (up > 0.0) & (D > 0.0) else INFINITY
    least = lowest(c3, a4, w) if sign > 0.0 else -highest(c3, a4, w)
    k = sign * bend + least - b
    step = safe_step(low, fall, k) * (1.0 - GAP * EPS) - 2.0 * EPS * t
    finite = (e < INFINITY) & (b < INFINITY)
    return (h, dh, sign * bend, sign * c3), (e, d, finite), (near, rate, up, reach), (w, low, fall, k, step)


@inlined
def lands(fresh: bool, near: float, rate: float, up: float, reach: float) -> Any:
    """Say whether a gap surely comes down to 0, and only once until ``near``."""
    return (not fresh) & (rate < 0.0) & ((up <= 0.0) | (reach <= near))


@inlined
def lateness(error: float, rate: float, t: float) -> float:
    """Return how late a contact may be that is seen from t on, where the gap comes down at a rate with an error."""
    return error / -rate + 4.0 * EPS * t


@inlined
def look(
    dx: float, dy: float, vx: float, vy: float, g: float, size: float, sign: float, t: float, fresh: bool, end: float,
    doubt: float,
) -> Any:  # fmt: skip
    """Look at a circle once, at the time t of a flight, see :func:`crossing`.

    Returns
    -------
    (what, t, late, flags, doubt), (h, dh, k, c3, reach)
        What is found: ON, to be looked at again at t; HIT or MISSED; or NEAR, the polynomial from t on has its only
        root in (0, reach].
    """
    flags, what, late = OK, ON, 0.0
    (h, dh, bend, c3), (e, d, finite), (near, rate, up, reach), (w, low, fall, k, step) = seen(
        dx, dy, vx, vy, g, size, sign, t, fresh, end
    )
    again = not fresh and doubt < INFINITY
    if not finite:
        what, flags = HIT, DIVERGED
    elif again and ((h < -e and rate >= 0.0) or (rate < 0.0 and up <= 0.0)):
        what, late, t = HIT, t - doubt, doubt  # through and back, by less than can be decided
    elif lands(fresh, near, rate, up, reach):
        what, late = NEAR, lateness(e + d * near, rate, t)
        if not h > 0.0:
            what = HIT
    elif step >= w and t + w >= end:
        what = MISSED
    else:
        step = min(step, w)
        if low > 0.0:
            doubt = INFINITY
        if not t + step > t or (low < e and not fresh):
            wide = 2.0 * sqrt(e / (abs(k) + abs(bend)))
            if fall != 0.0:
                wide = min(wide, 4.0 * e / abs(fall))
            if not t + step > t or step < LEAST * wide:
                flags = GRAZE | AMBIGUOUS
                doubt, step = t, max(wide, 4.0 * EPS * t)
                if not t + step > t:
                    what, step, flags = HIT, 0.0, flags | TOO_MANY_IMPACTS
        t += step
    return (what, t, late, flags, doubt), (h, dh, bend, c3, reach)


@inlined
def glance(dx: float, dy: float, vx: float, vy: float, g: float, size: float, t: float, end: float) -> Any:
    """Return (what, t, doubt), (h, dh, k, c3, reach) as :func:`look` does, and (error, rate) for :func:`lateness`.

    The circle was not just left. Where it would be looked at closer, as it is touched within rounding, it is in doubt.
    """
    (h, dh, bend, c3), (e, d, finite), (near, rate, up, reach), (w, low, _fall, _k, step) = seen(
        dx, dy, vx, vy, g, size, 1.0, t, False, end
    )
    down, gone = lands(False, near, rate, up, reach), (step >= w) & (t + w >= end)
    what = (NEAR if h > 0.0 else HIT) if down else (MISSED if gone else ON)
    on, after = what == ON, t + min(step, w)
    doubt = (not finite) | (on & ((not after > t) | (low < e)))
    return (what, after if on else t, doubt), (h, dh, bend, c3, reach), (e + d * near, rate)


def crossing(
    dx: float, dy: float, vx: float, vy: float, g: float, size: float, sign: float, begin: float, fresh: bool,
    end: float,
) -> Any:  # fmt: skip
    """Return (t, late, flags): when h = sign (|d|^2 - size^2) first comes down to 0 after ``begin``, good to ``late``.

    d = (dx, dy) at t = 0 is the ball's place as seen from the centre. Infinity for never before ``end``. ``fresh``: it
    is at 0 and rises at ``begin``. Without it h >= 0 is known there, up to rounding.
    """
    t, doubt, flags = begin, INFINITY, OK
    for _ in range(LOOKS):
        (what, t, late, said, doubt), (h, dh, k, c3, reach) = look(dx, dy, vx, vy, g, size, sign, t, fresh, end, doubt)
        flags |= said
        if what == MISSED:
            return INFINITY, 0.0, flags
        if what == HIT:
            return t, late, flags
        if what == NEAR:
            return t + landing(h, dh, k, c3, sign * 0.25 * g * g, reach), late, flags
        fresh = False
    return t, 0.0, flags | TOO_MANY_SWINGS


@inlined
def face_doubt(h: float, dh: float, k: float, e: float, d: float) -> float:
    """Return the error of the discriminant of a gap that is good to e and d per time."""
    return 2.0 * abs(dh) * d + 4.0 * abs(k) * e + GAP * EPS * (dh * dh + 4.0 * abs(k * h))


@inlined
def face_root(h: float, dh: float, k: float, e: float, d: float, fresh: bool) -> Any:
    """Return (sure, t, late): whether a flight surely comes down to 0, and does not hardly do so, and when.

    All is computed at any rate, without a branch: what is not ``sure`` means nothing.
    """
    held, D = not fresh, dh * dh - 4.0 * k * h
    unsure = face_doubt(h, dh, k, e, d)
    away = ((k >= 0.0) & (fresh | (dh >= 0.0))) | (fresh & rests(dh, k, e))
    behind = (h < -e) & ((k >= 0.0) | (dh <= 0.0))
    sure = (not away) & (fresh | ((not behind) & (D > 2.0 * unsure)))  # sqrt(D - unsure) > 0.7 root
    root, down = dh if fresh else sqrt(max(D, 0.0)), (dh < 0.0) & held
    over, under = 2.0 * h if down else -(dh if fresh else 0.5 * (dh + root)), root - dh if down else k
    t = max(over / (under if sure else 1.0), 0.0)
    late = (e if fresh else 1.5 * (e + d * t)) / (root if sure else 1.0)
    return sure, t, late if fresh else late + 4.0 * EPS * t


def face_crossing(h: float, dh: float, k: float, e: float, d: float, fresh: bool) -> Any:
    """Return (t, late, flags): when h + dh t + k t^2, good to e and d per time, comes down to 0 after 0.

    Infinity for never. h < 0 is allowed: it is behind the line, and may come before it and back.
    """
    sure, t, late = face_root(h, dh, k, e, d, fresh)
    if sure:
        return t, late, OK
    if fresh and rests(dh, k, e):
        return 0.0, 0.0, STUCK
    D, unsure = dh * dh - 4.0 * k * h, face_doubt(h, dh, k, e, d)
    if (k >= 0.0 and (fresh or dh >= 0.0)) or (h < -e and (k >= 0.0 or dh <= 0.0 or D < 0.0)):
        return INFINITY, 0.0, OK
    if k > 0.0 and D <= unsure:
        return INFINITY, 0.0, OK if D < -unsure else GRAZE | AMBIGUOUS
    root = sqrt(max(D, 0.0))  # pressed against it, or hardly moving at all
    t = max(2.0 * h / (root - dh) if dh < 0.0 else -0.5 * (dh + root) / k, 0.0)
    return t, 3.0 * sqrt(unsure) / -k if k < 0.0 else t - max(h - e, 0.0) / (d - dh), OK


@inlined
def first_step(dx: float, dy: float, vx: float, vy: float, g: float, size: float, fresh: bool, least: float) -> Any:
    """Return (step, flags): how long a circle is surely not met; ``least`` is the part of k that all circles share."""
    far2, dh = dx * dx + dy * dy, 2.0 * (dx * vx + dy * vy)
    h, k = far2 - size * size, least - g * dy
    e, d = GAP * EPS * (2.0 * far2 + size * size), GAP * EPS * (abs(dx * vx) + abs(dy * vy))
    k -= GAP * EPS * (2.0 * (vx * vx + vy * vy) + g * (abs(dx) + abs(dy) + size))
    low, fall = 0.0 if fresh else max(h - e, 0.0), dh - d
    fall = max(fall, 0.5 * dh, 0.0) if fresh else fall
    stuck, inside = fresh & rests(dh, vx * vx + vy * vy - g * dy, e), (not fresh) & (h < -DEEP * e)
    step = 0.0 if stuck | inside else safe_step(low, fall, k) * (1.0 - GAP * EPS)
    return step, STUCK if stuck else (INSIDE_WALL if inside else OK)


def slid_off(dx: float, dy: float, vx: float, vy: float, g: float, size: float, sign: float) -> Any:
    """Return (t, late, flags): when a ball that has slid off a circle at t = 0 comes back to it, infinity for never.

    There h and h' are 0: so h = s^2 (k + c3 s + a4 s^2), and k >= 0 up to rounding, but for one without a radius that
    comes to the end of an arc.
    """
    k, c3, a4 = sign * (vx * vx + vy * vy - g * dy), -sign * g * vy, sign * 0.25 * g * g
    b = GAP * EPS * (vx * vx + vy * vy + g * (abs(dx) + abs(dy) + size))
    k = k if abs(k) > b else 0.0
    if a4 >= 0.0 and (c3 >= 0.0 or k < 0.0):
        return INFINITY, 0.0, OK
    D, unsure = c3 * c3 - 4.0 * a4 * k, GAP * EPS * c3 * c3 + 4.0 * abs(a4) * b
    if D <= unsure and (a4 > 0.0 or k < 0.0):
        return INFINITY, 0.0, OK if D < -unsure else GRAZE | AMBIGUOUS
    t = 2.0 * k / (sqrt(D) - c3) if c3 <= 0.0 and k > 0.0 else -(c3 + sqrt(D)) / (2.0 * a4)
    return (t, b / sqrt(D) + 4.0 * EPS * t, OK) if t > 0.0 else (INFINITY, 0.0, OK)
