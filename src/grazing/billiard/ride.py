"""A ball that slides on a side of a flipper while it turns: how far, and what ends that. Proof: docs/table.md.

With the normal n to the ball, its place s along the side, from the foot of the pivot on in the direction of n turned by
a quarter, and its rate q, seen from the flipper: s'' = omega^2 s - gamma n_x. That is linear, and has a closed form.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

from grazing.billiard.elements import bend_of, count_of, element, gap_of, holds, is_passed, normal_of, width_of
from grazing.billiard.flippers import LONG, OWNER, PX, PY, REACH, SIZE, TIP
from grazing.billiard.gaps import EPS, GAP, safe_step
from grazing.billiard.hit import first_turning, pose
from grazing.billiard.rows import GRAVITY
from grazing.billiard.slide import HITS, LEAVES, ONTO, WAITS, onto, pressing
from grazing.billiard.swept import horizon
from grazing.billiard.turning import normal_at
from grazing.kernel.elementary import sincos
from grazing.kernel.primitives import inlined, unit
from grazing.outcome import AMBIGUOUS, OK, TOO_MANY_IMPACTS, TOO_MANY_SWINGS

INFINITY = float("inf")
#: Terms of the series of one ride, and the angle up to which that turns: what is left is below 1e-19 of the sums.
TERMS, TURN = 9, 3.0
#: Steps after which a ride ends by name.
MOST = 100_000


@inlined
def quarters(z: float) -> Any:
    """Return the sums of z^4k/(4k + j)! over k, for j from 0 to 3: cosh z is the first one and z^2 times the third."""
    a, b, c, d, z4 = 1.0, 1.0, 1.0, 1.0, z * z * z * z
    for i in range(TERMS):
        k = 4.0 * (TERMS - 1 - i)
        most = (k + 2.0) * (k + 3.0) * (k + 4.0)
        a = 1.0 + a * z4 / ((k + 1.0) * most)
        b = 1.0 + b * z4 / (most * (k + 5.0))
        c = 1.0 + c * z4 / ((k + 3.0) * (k + 4.0) * (k + 5.0) * (k + 6.0))
        d = 1.0 + d * z4 / ((k + 4.0) * (k + 5.0) * (k + 6.0) * (k + 7.0))
    return a, b, c / 2.0, d / 6.0


@inlined
def ridden(s: float, q: float, nx: float, ny: float, omega: float, g: float, t: float) -> Any:
    """Return (s, q, nx, ny) after a time: the places of all balls draw apart as cosh and sinh do."""
    z = omega * t
    a, b, c, d = quarters(z)
    rise, run, (sine, cosine) = a + z * z * c, b + z * z * d, sincos(z)
    new = s * rise + t * (q * run - g * t * (c * nx - z * d * ny))
    rate = q * rise + t * (omega * omega * s * run - g * (b * nx - z * c * ny))
    return new, rate, cosine * nx - sine * ny, sine * nx + cosine * ny


@inlined
def ridden_by(s: float, q: float, turn: float, nx: float, ny: float, omega: float, g: float, t: float) -> Any:
    """Return (s, q) after a time of small changes of them, while the flipper is ahead by a small ``turn``.

    The normal is that at the begin; it turns ahead, too: s'' = omega^2 s + gamma n_y turn.
    """
    z = omega * t
    a, b, c, d = quarters(z)
    rise, run = a + z * z * c, b + z * z * d
    new = s * rise + t * (q * run + turn * g * t * (c * ny + z * d * nx))
    return new, q * rise + t * (omega * omega * s * run + turn * g * (b * ny + z * c * nx))


@inlined
def begun(x: float, y: float, vx: float, vy: float, surface: int, clock: float, table: Any) -> Any:
    """Return (row, side, omega), (s, q, nx, ny) of a ball on a side of a flipper that turns."""
    row, kind, ux, uy, omega = pose(surface, 0.0, clock, table)
    nx, ny = normal_at(kind, ux, uy, row)
    s, q = nx * (y - row[PY]) - ny * (x - row[PX]), nx * vy - ny * vx - omega * row[SIZE]
    return (row, 2.0 * kind - 1.0, omega), (s, q, nx, ny)


@inlined
def state_of(row: Any, omega: float, s: float, q: float, nx: float, ny: float) -> Any:
    """Return place and velocity of a ball."""
    size, u = row[SIZE], q + omega * row[SIZE]
    x, y = row[PX] + size * nx - s * ny, row[PY] + size * ny + s * nx
    return x, y, -u * ny - omega * s * nx, u * nx - omega * s * ny


def carried_to(surface: int, state: Any, t: float, clock: float, table: Any) -> Any:
    """Return place and velocity after a time, if nothing ends the ride before."""
    x, y, vx, vy = state
    (row, _way, omega), (s, q, nx, ny) = begun(x, y, vx, vy, surface, clock, table)
    s, q, nx, ny = ridden(s, q, nx, ny, omega, table[GRAVITY], t)
    return state_of(row, omega, s, q, nx, ny)


@inlined
def around(surface: int, own: int, t: float, clock: float, state: Any, pull: float, table: Any) -> Any:
    """Return (step, hit): how long a ball that rides meets nothing else for sure, or what it meets, -1 for nothing.

    The distance to what it may meet changes by the speeds of both and, with ``pull`` per time, by its acceleration.
    """
    x, y, vx, vy = state
    step = INFINITY
    for other in range(count_of(table)):
        to = element(other, clock + t, table)
        if to[1] == own:
            continue
        wx, wy, most = vx, vy, sqrt(vx * vx + vy * vy)
        if other >= first_turning(table):
            row, _kind, _ux, _uy, omega = pose(other, t, clock, table)
            wx, wy, most = wx + omega * (y - row[PY]), wy - omega * (x - row[PX]), most + abs(omega) * row[REACH]
        h, width, (nx, ny) = gap_of(to, x, y), 2.0 * width_of(to, x, y), normal_of(to, x, y)
        if abs(h) <= width and nx * wx + ny * wy < 0.0 and holds(to, x, y, width) and not is_passed(other, table):
            return 0.0, other
        far = abs(h)
        if to[0] == 0.0:
            foot = to[4] * (y - to[3]) - to[5] * (x - to[2])
            far = max(far, -foot, foot - to[7])
        if far > width:
            step = min(step, 2.0 * far / (most + sqrt(most * most + 2.0 * pull * far)))
        elif abs(h) <= width:
            step = min(step, width / (most + sqrt(pull * width)))
    return step, -1


@unit
def ride(x: float, y: float, vx: float, vy: float, surface: int, clock: float, table: Any) -> Any:
    """Return what :func:`grazing.billiard.slide.slide` does, of a ball on a side of a flipper that turns."""
    (row, way, omega), first = begun(x, y, vx, vy, surface, clock, table)
    g, spin, size, own = table[GRAVITY], abs(omega), row[SIZE], int(row[OWNER])
    end, _busy = horizon(element(surface, clock, table), x, y, INFINITY, clock, table)
    end, t, least, flags, state = min(end, TURN / spin), 0.0, 0.0, OK, (x, y, vx, vy)
    draw = spin * spin * row[LONG] + g  # the most that it is sped up by along the side
    for _ in range(MOST):
        s, q, nx, ny = ridden(first[0], first[1], first[2], first[3], omega, g, t)
        state = state_of(row, omega, s, q, nx, ny)
        if not t < end:
            return (surface, WAITS, end, flags), state
        press, tight = g * ny - omega * (2.0 * q + omega * size), 3.0 * g * nx - 2.0 * spin * spin * s
        tight *= omega  # how the normal force changes
        unsure = GAP * EPS * (g + spin * (2.0 * abs(q) + spin * size))
        w = min(end - t, 1.0 / spin)
        fast = abs(q) + draw * w
        bend = 1.5 * g * spin * spin + spin * spin * spin * fast  # half of the most by which that does
        if press <= 0.0 or (press <= unsure and tight < 0.0):
            flags |= AMBIGUOUS if tight * tight < 4.0 * bend * unsure else OK
            return (surface, LEAVES, t, flags), state
        foot, rate = way * s, way * q
        width = GAP * EPS * (row[LONG] + size)
        if foot >= row[LONG] - width and rate >= 0.0:  # beyond, on the tip, it is not followed
            flags |= TOO_MANY_IMPACTS if press * row[TIP] > q * q else OK
            return (surface, LEAVES, t, flags), state
        if foot <= width and rate <= 0.0:
            el = element(surface, clock + t, table)
            hub = onto(surface, el, state[0], state[1], nx, ny, -way, clock + t, table)
            bend = bend_of(element(hub, clock + t, table)) if hub >= 0 else 0.0
            on = hub >= 0 and pressing(nx, ny, bend, q + omega * size, g) > 0.0
            return (hub if hub >= 0 else surface, ONTO if on else LEAVES, t, flags), state
        step, hit = around(surface, own, t, clock, state, 2.0 * (g + spin * (2.0 * fast + spin * size)), table)
        if hit >= 0:
            return (hit, HITS, t, flags), state
        step = min(step, w, safe_step(press, tight, -bend), safe_step(max(row[LONG] - foot, 0.0), -rate, -draw))
        step = min(step, safe_step(max(foot, 0.0), rate, -draw))
        least = max(4.0 * EPS * t, width / (abs(q) + sqrt(draw * width)))
        t = min(t + max(step, least), end)
    return (surface, LEAVES, t, flags | TOO_MANY_SWINGS), state
