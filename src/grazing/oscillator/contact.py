"""From one contact to the next: the first impact of a flight. What the wall does then says the departure.

Why no impact can be missed. Let F = f - k^2 sigma have one sign on a window, y = u - sigma, and phi > 0 solve the
unforced equation there; k^2 stands for the stiffness, and neither its sign nor that of alpha matters. In the variable
xi with dxi = e^{-alpha t}/phi^2 dt the quotient y/phi is concave where F <= 0 and convex where F >= 0. So in a window
with F < 0 a flight from above hits the wall exactly if it ends below it, and at one point; in a window with F > 0 it
has one lowest point, and grazing can happen only there. Every search below is for a single simple root in a bracket:
there is no scan and no step size.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from grazing.kernel.elementary import length, sincos
from grazing.kernel.primitives import unit
from grazing.oscillator.constants import Constants, forcing, steady_response
from grazing.oscillator.flight import Anchor, anchored, flight, modes, noise, stiff
from grazing.oscillator.windows import free_distance
from grazing.outcome import AMBIGUOUS, DIVERGED, GRAZE, OK

#: Pieces of an under-damped flight in one period beyond which a step gives up by name.
MAX_SWINGS = 100_000
#: A ball so far from the wall, by a flight that gains energy, is lost: a little further no double would hold it.
LOST = 1e150
INFINITY = float("inf")
NAN = float("nan")


class Launch(NamedTuple):
    """The last departure from the wall: time, velocity, acceleration; and how wrong time and velocity may be.

    Errors are those made since the start of the step. A slow impact magnifies what came before it, and every later
    decision must know. In time and velocity of departure they grow as orbits part, no faster.
    """

    t: float
    w: float
    lift: float
    late: float
    off: float


class Ball(NamedTuple):
    """Where the ball is: local time, y = u - sigma, velocity, window; errors of this flight; the last departure."""

    t: float
    y: float
    v: float
    i: int
    error_y: float
    error_v: float
    launch: Launch


NO_LAUNCH = Launch(0.0, 0.0, 0.0, 0.0, 0.0)


def placed(t: float, y: float, v: float, i: int) -> Ball:
    """Return a ball whose state is exact."""
    return Ball(t, y, v, i, 0.0, 0.0, NO_LAUNCH)


def carried(t: float, launch: Launch, c: Constants) -> float:
    """Return how far y at time t may be off because of the errors of the departure."""
    if launch.late == 0.0 and launch.off == 0.0:
        return 0.0
    E11, E12, _E21, _E22 = modes(t - launch.t, c)
    far = abs(E11 * launch.w + E12 * launch.lift) * launch.late + abs(E12) * launch.off
    return far if far >= 0.0 else INFINITY  # of modes beyond all doubles nothing is known


def next_launch(ball: Ball, w: float, g: float, c: Constants) -> tuple[Launch, float]:
    """Return the departure after an impact with v < 0 that leaves with w, and the error of v; g = law'(v).

    The errors of the departure before it go through the Jacobian of the impact map, those of rounding are added.
    """
    F, _dF = forcing(ball.t, c)
    v, old = ball.v, ball.launch
    fall, lift = F - c.alpha * v, F - c.alpha * w
    late = ball.error_y / abs(v)
    unsure = ball.error_v + abs(fall) * late
    if old.late > 0.0 or old.off > 0.0:
        E11, E12, E21, E22 = modes(ball.t - old.t, c)
        y_tau, v_tau = -(E11 * old.w + E12 * old.lift), -(E21 * old.w + E22 * old.lift)
        late += abs(y_tau / v) * old.late + abs(E12 / v) * old.off
        unsure += abs(v_tau - fall * y_tau / v) * old.late + abs(E22 - fall * E12 / v) * old.off
    return Launch(ball.t, w, lift, late, abs(g) * unsure), unsure


def window_sign(i: int, c: Constants) -> float:
    """Return the sign of F in window i."""
    return -c.first if i % 2 == 1 else c.first


def push_in_doubt(t: float, late: float, kicks: bool, c: Constants) -> bool:
    """Return whether rounding leaves open which way F pushes a ball at rest on the wall at t, known to ``late``.

    Not so where F just turns from - to +: whether the ball lies for another 1e-12 T is no matter, unless the wall kicks
    a ball that is pressed on it.
    """
    F, dF = forcing(t, c)
    late += 4e-16 * c.T
    doubt = c.blur + c.bend * late * late
    return abs(F) < doubt + abs(dF) * late and (kicks or dF * 1e-12 * c.T <= doubt)


def window_of(t: float, i: int, c: Constants) -> int:
    """Return the window that begins at t or contains it, looking from window i on."""
    while i + 2 < len(c.edges) and t >= c.edges[i + 1] and c.edges[i + 1] < c.T:
        i += 1
    return i


def descent(a: Anchor, lo: float, hi: float, s: float, c: Constants) -> tuple[float, float]:
    """Return the time and velocity of the only zero of y in (lo, hi], where y(lo) >= 0 > y(hi); s is a first guess."""
    settled = noise(hi, a, c)[0] / 64.0
    if a.y == 0.0:  # a hop from the wall: settle relative to its own height
        settled = min(settled, 2e-16 * abs(a.v) * s)
    elif a.y <= 64.0 * settled:  # so near the wall: relative to the way that is left
        s = fall_time(a, hi, c)
        settled = min(settled, 2e-16 * max(a.y, a.v * s))
    for _ in range(100):
        y, v = flight(s, a, c)
        if y >= 0.0:
            lo = s
        else:
            hi = s
        if c.grows > 0.0:  # by the end of the bracket rounding may have grown without bound
            settled = min(settled, noise(s, a, c)[0] / 64.0)
        if abs(y) <= settled and v < 0.0:
            new = s - y / v
            s = new if lo <= new <= hi else s
            break
        new = s - y / v if v < 0.0 else lo
        if not lo < new < hi:
            new = 0.5 * (lo + hi)
        if new == s or new == lo or new == hi:
            break
        s = new
    _y, v = flight(s, a, c)
    return s, min(v, 0.0)


def fall_time(a: Anchor, hi: float, c: Constants) -> float:
    """Return the time of a fall from the anchor under the force that acts there, half of ``hi`` if it takes longer."""
    F, _dF = forcing(a.t, c)
    pull = c.alpha * a.v + c.k2 * a.y - F
    room = a.v * a.v + 2.0 * pull * a.y
    root = sqrt(room) if room > 0.0 else 0.0
    s = hi
    if a.v <= 0.0 and root > a.v:
        s = 2.0 * a.y / (root - a.v)
    elif pull > 0.0:
        s = (a.v + root) / pull
    return s if 0.0 < s < 0.5 * hi else 0.5 * hi


def slope_of_phi(s: float, length: float, c: Constants) -> float:
    """Return phi'/phi of the comparison solution on a piece of this length, s from its start."""
    if c.q2 >= 0.0:
        return c.l2
    sine, cosine = sincos(c.spread * (s - 0.5 * length))
    return c.l2 - c.spread * sine / cosine


def lowest(a: Anchor, length: float, c: Constants) -> tuple[float, float, float]:
    """Return where y/phi is lowest on a piece with F > 0 that starts falling and ends rising, y there, and its error.

    The zero of g = v - (phi'/phi) y, where g' = F - (alpha + phi'/phi) g; stops at the first point below the wall. The
    error is what the search has left; 0 where the ball is higher than that.
    """
    lo, hi = 0.0, length
    s, y, left = 0.5 * length, 0.0, 0.0
    for _ in range(1000):
        y, v = flight(s, a, c)
        if y < 0.0:
            break
        psi = slope_of_phi(s, length, c)
        g = v - psi * y
        if g < 0.0:
            lo = s
        else:
            hi = s
        F, _dF = forcing(a.t + s, c)
        rise = F - (c.alpha + psi) * g
        new = s - g / rise if rise > 0.0 else lo
        if not lo < new < hi:
            new = 0.5 * (lo + hi)
        # an error of 1e-9 in the time is one of 1e-18 in the height: too much for a ball as near the wall as that
        left = 2.0 * abs(g * (new - s))
        if (abs(new - s) <= 1e-9 * length and y > left) or new == lo or new == hi or new == s:
            break
        s = new
    return s, y, (0.0 if y < 0.0 or y > left else left)


def piece_hit(
    a: Anchor, length: float, sign: float, launch: Launch, c: Constants
) -> tuple[bool, float, float, float, int, float]:
    """Follow one piece of a window.

    Returns
    -------
    hit : bool
    s, y, v : float
        Time from the anchor and state, at the impact or at the end of the piece.
    flags : int
    near : float
        Height where y/phi is lowest, for a ball that turns there in a window with F > 0 and misses the wall: for a
        narrow miss its lowest point. Else infinity.
    """
    yb, vb = flight(length, a, c)
    end = a.t + length
    close = abs(yb) <= noise(length, a, c)[0] + carried(end, launch, c)
    flags = AMBIGUOUS if close and end >= c.T and vb < 0.0 else OK
    if sign < 0.0:
        if yb >= 0.0:
            return False, length, yb, vb, flags, INFINITY
        F, _dF = forcing(a.t, c)
        pull = c.alpha * a.v - F
        guess = 2.0 * a.v / pull if a.y == 0.0 and pull > 0.0 else 0.5 * length
        s, v = descent(a, 0.0, length, guess if guess < length else 0.5 * length, c)
        return True, s, 0.0, v, flags, INFINITY
    fall = slope_of_phi(0.0, length, c) * a.y
    if a.v - fall >= 4e-16 * (abs(a.v) + abs(fall)):
        # y is above 0: where rounding says otherwise, the ball must not be taken for one that arrives at the edge
        return False, length, max(yb, 0.0), vb, AMBIGUOUS if yb <= 0.0 and vb < 0.0 else OK, INFINITY
    if close:  # the lowest point may lie beside the end: either side may be the true one
        flags = AMBIGUOUS
    if yb < 0.0:
        s, v = descent(a, 0.0, length, 0.5 * length, c)
        return True, s, 0.0, v, flags, INFINITY
    if vb - slope_of_phi(length, length, c) * yb < 0.0:
        return False, length, yb, vb, flags, INFINITY
    low, y_low, left = lowest(a, length, c)
    close = abs(y_low) <= noise(low, a, c)[0] + carried(a.t + low, launch, c) + left
    flags = (AMBIGUOUS | GRAZE) if close else OK
    if y_low >= 0.0:
        return False, length, yb, vb, flags, y_low
    s, v = descent(a, 0.0, low, 0.5 * low, c)
    return True, s, 0.0, v, flags, INFINITY


def aloft(a: Anchor, launch: Launch, c: Constants) -> tuple[float, float, float]:
    """Return for how long a swinging ball surely stays off the wall, how high at least, and the error of its phase.

    The free part of the flight never swings further than it does now, and the steady response falls no faster than its
    slope and a bound on its bend allow. 0 where that is not much longer than the pieces that would be asked instead.
    """
    left = c.T - a.t
    if not (c.steady and stiff(left, c)):
        return 0.0, INFINITY, 0.0
    Y, dY = steady_response(a.t, c)
    lean = (a.h1 + 0.5 * c.alpha * a.h0) / c.spread
    swing = length(a.h0, lean)
    bend = 0.0
    for j in range(len(c.hc)):
        W = (j + 1) * c.omega
        bend += W * W * length(c.hc[j], c.hs[j])
    phase = 1e-15 * c.spread * left * swing
    reach = 1.0 / c.spread
    off = (abs(launch.w) * (1.0 + 0.5 * c.alpha * reach) + abs(launch.lift) * reach) * launch.late + reach * launch.off
    clear = Y - swing - 4.0 * (noise(left, a, c)[0] + phase + off)
    if not clear > 1e-4 * (c.size + swing):
        return 0.0, INFINITY, 0.0
    far = min(left, free_distance(0.5 * clear, dY, bend)) if bend > 0.0 else left
    if not stiff(far, c):
        return 0.0, INFINITY, 0.0
    return far, max(0.5 * clear, clear - (max(0.0, -dY) + 0.5 * bend * far) * far), phase


@unit
def contact_until(ball: Ball, until: float, c: Constants) -> tuple[bool, Ball, int, float]:
    """Fly to the first impact, or to a time, T at most.

    Returns
    -------
    hit : bool
    ball : Ball
        At the impact, with y = 0 and the incoming velocity, else at that time. NaN where it is lost: the contact rule
        then says so.
    flags : int
    near : float
        The narrowest miss on the way, a lower bound where the ball stayed well off the wall; infinity for none.
    """
    flags, near = OK, INFINITY
    while ball.t < until:
        if c.grows > 0.0 and not abs(ball.y) < LOST:
            return True, placed(ball.t, NAN, NAN, ball.i), DIVERGED, near
        i = window_of(ball.t, ball.i, c)
        a = anchored(ball.t, ball.y, ball.v, c, ball.error_y, ball.error_v)
        far, low, phase = aloft(a, ball.launch, c)
        if far > 0.0:
            far = min(far, until - ball.t)
            y, v = flight(far, a, c)
            error_y, error_v = noise(far, a, c)
            end = ball.t + far if far < until - ball.t else until
            near = min(near, low)
            ball = Ball(end, y, v, i, error_y + phase, error_v + c.rate * phase, ball.launch)
            continue
        end = min(c.edges[i + 1], ball.t + c.piece, until)
        hit, s, y, v, said, low = piece_hit(a, end - ball.t, window_sign(i, c), ball.launch, c)
        flags |= said
        near = min(near, low)
        error_y, error_v = noise(s, a, c)
        ball = Ball(min(ball.t + s, until) if hit else end, y, v, i, error_y, error_v, ball.launch)
        if hit or (y == 0.0 and v < 0.0):  # the second is an impact exactly at the edge
            return True, ball, flags, near
    return False, ball, flags, near


def next_contact(ball: Ball, c: Constants) -> tuple[bool, Ball, int, float]:
    """Fly to the first impact, or to the end of the period, see :func:`contact_until`."""
    return contact_until(ball, c.T, c)
