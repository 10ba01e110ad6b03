"""The equation of a flight that begins with one impact and ends, N periods later, with the same one.

Let the ball leave the wall at forcing phase phi with velocity w and fly for L = N T. With E = exp(BL) the unforced
flight and R = (R_y, R_v) what the forcing adds (Duhamel's integral, a trigonometric polynomial in phi),

    y(L) = E12 w + R_y(phi) = 0,    v_minus = E22 w + R_v(phi),    w = -r v_minus + V.

Eliminating both velocities leaves one equation of degree m, the number of harmonics, and nothing in it is singular:

    G(phi) = E12 (V - r R_v) + (1 + r E22) R_y = 0.

All functions here are kernels: scalar, compiled by :func:`grazing.kernel.compile.compiled`, and plain Python too.
"""

from __future__ import annotations

from math import floor, pi, sqrt
from typing import Any, NamedTuple

from grazing.kernel.elementary import exp, length, sincos
from grazing.kernel.primitives import replaced
from grazing.oscillator.constants import Constants, forcing, steady_response
from grazing.oscillator.contact import placed, window_of, window_sign
from grazing.oscillator.flight import anchored, divided2, divided3, flight, modes
from grazing.oscillator.frames import Frames, first_contact, frame_of
from grazing.oscillator.windows import free_distance, series, window_edges

TWO_PI = 2.0 * pi
#: Test functions of :func:`impact_state`, in their order; an orbit is stable and admissible where all are > 0.
TESTS = ("pd", "lp", "ns", "v0", "law", "st", "gr")
#: Time, in that in which the fast mode of a flight falls by e, after which nothing is left of it: it was e^-100.
DRAGGED = 100.0
#: Part of the size of a motion by which dips differ that are not equal but for rounding.
EQUAL = 1e-12
#: Pieces of an affine reset law: one piece; a trigger that fires (|v_minus| >= trigger); one that does not.
WHOLE, FIRED, PASSIVE = 0, 1, 2


class Closing(NamedTuple):
    """The flight over L = N T from the wall back to the wall, as a function of the phase of the impact."""

    L: float
    rate: float  # fastest one of the flight
    r: float
    V: float
    E11: float
    E12: float
    E21: float
    E22: float
    y0: float  # R_y: constant part, cosine and sine amplitudes
    yc: tuple[float, ...]
    ys: tuple[float, ...]
    v0: float  # R_v
    vc: tuple[float, ...]
    vs: tuple[float, ...]
    g0: float  # G
    gc: tuple[float, ...]
    gs: tuple[float, ...]


def closing(N: int, law: int, c: Constants) -> Closing:
    """Return the closing equation of one affine piece of the reset law; ``c.p`` holds r, V and trigger."""
    r, V = c.p.r, (0.0 if law == PASSIVE else c.p.V)
    L = N * c.T
    E11, E12, E21, E22 = modes(L, c)
    if c.q2 > 0.0:
        a, b = complex(c.l1), complex(c.l2)
    else:
        a, b = complex(c.l1, c.spread), complex(c.l2, -c.spread)
    still = complex(0.0)
    d3 = divided3(a, b, still, L)
    y0 = c.F0 * d3.real
    v0 = c.F0 * (a * d3 + divided2(b, still, L)).real
    back = 1.0 + r * E22
    g0 = E12 * (V - r * v0) + back * y0
    yc, ys, vc, vs, gc, gs = c.cos, c.cos, c.cos, c.cos, c.cos, c.cos
    for j in range(len(c.cos)):
        node = complex(0.0, (j + 1) * c.omega)
        amplitude = complex(c.cos[j], -c.sin[j])
        d3 = divided3(a, b, node, L)
        y, v = amplitude * d3, amplitude * (a * d3 + divided2(b, node, L))
        yc, ys = replaced(yc, j, y.real), replaced(ys, j, -y.imag)
        vc, vs = replaced(vc, j, v.real), replaced(vs, j, -v.imag)
        gc = replaced(gc, j, back * y.real - E12 * r * v.real)
        gs = replaced(gs, j, E12 * r * v.imag - back * y.imag)
    return Closing(L, c.rate, r, V, E11, E12, E21, E22, y0, yc, ys, v0, vc, vs, g0, gc, gs)


def simple_zeros(
    g0: float, gc: tuple[float, ...], gs: tuple[float, ...], no_edges: tuple[float, ...]
) -> tuple[tuple[float, ...], int]:
    """Return the simple zeros in [0, 2 pi) of g0 + sum gc_j cos(j phi) + gs_j sin(j phi), and how many there are.

    The search starts where the polynomial is largest among 2m + 1 equidistant phases: there it is not zero.
    """
    m = len(gc)
    start, best, bend = 0.0, 0.0, 0.0
    for i in range(2 * m + 1):
        phi = TWO_PI * i / (2 * m + 1)
        G, _dG = series(phi, g0, gc, gs, 1.0, 0.0)
        if abs(G) > best:
            start, best = phi, abs(G)
    zeros, count = no_edges, 0
    if best == 0.0:
        return zeros, 0
    for j in range(m):
        bend += (j + 1) * (j + 1) * length(gc[j], gs[j])
    edges, _first, _doubtful = window_edges(g0, gc, gs, 1.0, start, TWO_PI, bend, no_edges)
    for i in range(1, len(no_edges) - 1):
        if edges[i] < TWO_PI:
            phi = start + edges[i]
            G, dG = series(phi, g0, gc, gs, 1.0, 0.0)
            newton = G / dG if dG != 0.0 else 0.0
            phi = phi - newton if abs(newton) < 1e-12 else phi
            phi -= TWO_PI if phi >= TWO_PI else 0.0
            zeros = replaced(zeros, count, max(phi, 0.0))
            count += 1
    return zeros, count


def turning(g: Closing, guess: float, no_edges: tuple[float, ...]) -> tuple[float, float]:
    """Return the extremum of G nearest to the phase ``guess`` (modulo 2 pi), and G there; NaN if there is none."""
    hc, hs = g.gc, g.gs
    for j in range(len(g.gc)):
        hc, hs = replaced(hc, j, (j + 1) * g.gs[j]), replaced(hs, j, -(j + 1) * g.gc[j])
    zeros, count = simple_zeros(0.0, hc, hs, no_edges)
    near, best = float("nan"), TWO_PI
    for i in range(count):
        away = abs(zeros[i] - guess - TWO_PI * floor((zeros[i] - guess) / TWO_PI + 0.5))
        if away < best:
            near, best = zeros[i], away
    if count == 0:
        return near, near
    G, _dG = series(near, g.g0, g.gc, g.gs, 1.0, 0.0)
    return near, G


def impact_velocities(phi: float, g: Closing) -> tuple[float, float]:
    """Return (v_plus, v_minus) at a zero of G, related by the reset law without rounding.

    w solves both E12 w = -R_y and (1 + r E22) w = V - r R_v; their least-squares mean divides by neither alone, with
    the first one in units of 1/rate.
    """
    Ry, _dRy = series(phi, g.y0, g.yc, g.ys, 1.0, 0.0)
    Rv, _dRv = series(phi, g.v0, g.vc, g.vs, 1.0, 0.0)
    back = 1.0 + g.r * g.E22
    side = g.E12 * g.rate
    w = (back * (g.V - g.r * Rv) - side * (Ry * g.rate)) / (back * back + side * side)
    v = g.E22 * w + Rv
    return g.V - g.r * v, v


def impact_time(phi: float, c: Constants) -> float:
    """Return the time tau in [0, T) of forcing phase phi."""
    tau = (phi - c.theta) / c.omega
    tau -= c.T * floor(tau / c.T)
    return tau if tau < c.T else 0.0


def impact_state(phi: float, law: int, g: Closing, c: Constants) -> tuple[float, ...]:
    """Return the orbit of a zero phi of G and its test functions.

    Returns
    -------
    tuple of 14 floats
        tau, v_plus, v_minus, trace, det, then the test functions of :data:`TESTS`: -v (1 + tr + det),
        -v (1 - tr + det), -v (1 - det) (all three free of the pole at v = v_minus = 0), -v, the distance of |v|
        from the trigger, the force that lifts a ball left at rest, the clearance; then which dip is the lowest,
        counted from the closing impact, and the number of dips.

    Notes
    -----
    J = E S with the saltation matrix S = [[w/v, 0], [(a_plus + r a_minus)/v, -r]], a = F - alpha v, so that
    det J = exp(-alpha L) (-r w/v): r^2 + r V/|v| for the active bumper, which can exceed 1.
    """
    tau = impact_time(phi, c)
    w, v = impact_velocities(phi, g)
    F, _dF = forcing(tau, c)
    v_trace = g.E11 * w + g.E12 * ((F - c.alpha * w) + g.r * (F - c.alpha * v)) - g.r * v * g.E22
    v_det = -g.r * w * exp(-c.alpha * g.L)
    trigger = -v - c.p.trigger
    if law != FIRED:
        trigger = -trigger if law == PASSIVE else 1.0
    lift = F if w == 0.0 else 1.0
    lowest, dip, count, _when, _deepest = lowest_dip(tau, 0.0, max(w, 0.0), g.L, False, c)
    safe = v if v != 0.0 else float("nan")
    return (
        tau, w, v, v_trace / safe, v_det / safe,
        -(v + v_trace + v_det), -(v - v_trace + v_det), v_det - v, -v, trigger, lift, lowest, float(dip), float(count),
    )  # fmt: skip


def second_derivative(t: float, cos: tuple[float, ...], sin: tuple[float, ...], c: Constants) -> tuple[float, float]:
    """Return the second derivative of a series of the forcing's harmonics at local time t, and a bound on the third."""
    s1, c1 = sincos(c.omega * t + c.theta)
    sj, cj = s1, c1
    second, bound = 0.0, 0.0
    for j in range(len(cos)):
        W = (j + 1) * c.omega
        second -= W * W * (cos[j] * cj + sin[j] * sj)
        bound += W * W * W * length(cos[j], sin[j])
        sj, cj = sj * c1 + cj * s1, cj * c1 - sj * s1
    return second, bound


def drags(s: float, c: Constants) -> bool:
    """Return whether of a free flight only what dies out slowly is left after time s."""
    return c.q2 > 0.0 and -c.l2 * s > DRAGGED


def dragged(t: float, v: float, c: Constants) -> tuple[float, float, float]:
    """Return the acceleration at local time t of a flight that :func:`drags`, and bounds on its jerk's parts.

    The velocity is that of the steady response, and a rest that falls as e^{l1 t}: so its slope has all its digits,
    where as a force and drag that are equal but for rounding it has none. The bounds are on the third derivative
    of the response, and on that of the rest now.
    """
    _Y, dY = steady_response(t, c)
    ddY, third = second_derivative(t, c.hc, c.hs, c)
    rest = v - dY
    return ddY + c.l1 * rest, third, c.l1 * c.l1 * abs(rest)


def gained(s: float, c: Constants) -> float:
    """Return by how much the energy e of :func:`lowest_dip` grows in time s at most, where nothing is forced."""
    return exp((max(-c.alpha, 0.0) + sqrt(max(-c.k2, 0.0))) * s) if c.grows > 0.0 else 1.0


def lowest_dip(
    tau: float, y: float, v: float, L: float, lands: bool, c: Constants
) -> tuple[float, int, int, float, float]:
    """Return the lowest local minimum of y in a flight of time L from (tau, y, v), which it is, their number, its time.

    The dip is counted from the end (1 is the last), its time from the start; without any dip y is infinite and the
    other numbers are 0. Of dips that are equal but for rounding, as those of a steady response in each period, it is
    the first. A flight that leaves into the wall, from y = 0 with v < 0, while it is lifted dips at once, and one that
    ``lands`` with v > 0 has just done so: these are the impacts, which have lost their speed. They count only for the
    last number, the lowest of all.

    No dip is missed: over the next step y''' is bounded by the energy
    e^2 = y''''^2 + |k^2| y'''^2, where e' <= |F'''| at most, and e' <= |F'''| + (|alpha| + |k|) e for a negative
    alpha and a negative k^2; so every step is proved either free of zeros of v or to have one only. Once a flight
    :func:`drags` its bounds are those of :func:`dragged`.
    """
    anchor = anchored(tau, y, v, c)
    low, at, count, when = float("inf"), 0, 0, 0.0
    others, other_at, other_when = low, at, when  # without the last one
    s, reach, turned, deepest = 0.0, c.T / 64.0, False, low
    into = y == 0.0 and v < 0.0 and forcing(tau, c)[0] - c.alpha * v > 0.0
    while s < L:
        if drags(s, c):
            acc, bend, rest = dragged(tau + s, v, c)
            bend += rest * exp(max(c.l1, 0.0) * reach)
        else:
            F, dF = forcing(tau + s, c)
            ddF, third = second_derivative(tau + s, c.cos, c.sin, c)
            acc = F - c.alpha * v - c.k2 * y
            jerk = dF - c.alpha * acc - c.k2 * v
            snap = ddF - c.alpha * jerk - c.k2 * acc
            bend = abs(jerk) + reach * (length(snap, sqrt(abs(c.k2)) * jerk) + reach * third) * gained(reach, c)
        monotone = 0.9 * abs(acc) / bend if bend > 0.0 else L
        step = max(0.9 * free_distance(v, acc, bend), monotone, 1e-7 * c.T)
        end = min(L, s + min(step, reach))
        reach = min(4.0 * step, 0.25 * c.T)
        y_end, v_end = flight(end, anchor, c)
        turned = (v < 0.0 or (v == 0.0 and acc < 0.0)) and v_end >= 0.0
        bottom, then = float("inf"), 0.0
        if turned and end < L:
            then, bottom = minimum(s, end, anchor, c)
            deepest = min(deepest, bottom)
        if bottom < float("inf") and not into:
            count += 1
            others, other_at, other_when = low, at, when
            if bottom < low - EQUAL * c.size:
                at, when = count, then
            low = min(low, bottom)
        into = into and not turned
        s, y, v = end, y_end, v_end
    if lands and v > 0.0 and count > 0 and not turned and forcing(tau + L, c)[0] - c.alpha * v - c.k2 * y > 0.0:
        count, low, at, when = count - 1, others, other_at, other_when
    return low, (count + 1 - at if count > 0 else 0), count, when, deepest


def minimum(lo: float, hi: float, anchor: Any, c: Constants) -> tuple[float, float]:
    """Return when y is least on [lo, hi], where v has one zero and changes from - to +, and y there."""
    s = 0.5 * (lo + hi)
    for _ in range(60):
        y, v = flight(s, anchor, c)
        acc = forcing(anchor.t + s, c)[0] - c.alpha * v - c.k2 * y
        if drags(s, c):
            acc = dragged(anchor.t + s, v, c)[0]
        if v < 0.0:
            lo = s
        else:
            hi = s
        new = s - v / acc if acc > 0.0 else lo
        if not lo < new < hi:
            new = 0.5 * (lo + hi)
        # an error of 1e-9 in the time is one of 1e-18 in the height
        if abs(new - s) <= 1e-10 * c.T or new == lo or new == hi:
            break
        s = new
    y, _v = flight(new, anchor, c)
    return new, y


def contact_after(tau: float, w: float, b: bool, N: int, c: Frames) -> tuple[float, bool]:
    """Return the time from an impact to the next contact, by the exact advance, and whether the second wall is hit.

    Infinite if none within N + 1 periods; 0 for a ball that leaves with w = 0 while the forcing presses it on the wall:
    it sticks. ``b`` says whether it leaves the second wall.
    """
    here = frame_of(b, c)
    ball = placed(tau, 0.0, w, window_of(tau, 0, here))
    if w == 0.0 and window_sign(ball.i, here) < 0.0:
        return 0.0, b
    for period in range(N + 2):
        hit, b, ball, _flags, _near = first_contact(ball, b, c)
        if hit:
            return period * here.T + ball.t - tau, b
        ball = placed(0.0, ball.y, ball.v, 0)
    return float("inf"), b
