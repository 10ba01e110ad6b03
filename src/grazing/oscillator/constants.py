"""The constants of one oscillator at one parameter value: everything a flight needs, computed once."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import floor, pi, sqrt
from typing import Any, NamedTuple

from grazing.kernel.elementary import length
from grazing.kernel.primitives import replaced, unit
from grazing.oscillator.windows import series, window_edges
from grazing.outcome import InputError

TWO_PI = 2.0 * pi
#: Most harmonics of a flight: compiling it takes two minutes then, and with twice as many four times as long.
MOST_FLOWN = 200
# 2 pi in pieces of 23 bits and a rest, so that products with whole numbers below 2^30 are exact.
TWO_PI_1 = float.fromhex("0x1.921fb4p+2")
TWO_PI_2 = float.fromhex("0x1.4442dp-22")
TWO_PI_3 = float.fromhex("0x1.846988p-46")
TWO_PI_4 = float.fromhex("0x1.8cc51701b839ap-70")

#: Parameters in front of the harmonics cos1, sin1, cos2, ...; pinball calls the offset d, and the second one may be
#: the stiffness itself, see :func:`stiffness_of`.
HEAD = ("alpha", "k", "omega", "t0", "offset")
#: The place of the offset.
OFFSET = len(HEAD) - 1
#: A ball at less than this share of the wall's distance from 0 is far from the wall, if it is not on it.
FAR = 1e-3
#: A flight whose errors grow is cut where they have grown by e to this power, so that nothing in it overflows.
LEAP = 30.0


class Constants(NamedTuple):
    """What a flight needs, for u'' + alpha u' + k^2 u = f(t) with y = u - sigma and local time t in [0, T].

    k^2 stands for the stiffness, which may be negative, as may alpha.
    """

    alpha: float
    k2: float  # the stiffness
    q2: float  # alpha^2/4 - k^2: > 0 over-, < 0 under-damped
    l1: float  # the slow root, or the real part when under-damped; never less than l2
    l2: float  # the fast root, or the real part when under-damped
    spread: float  # q = sqrt(|q2|): half the distance of the roots, or the damped frequency
    omega: float
    theta: float  # phase of the forcing at local time 0
    T: float
    sigma: float
    F0: float  # offset - k^2 sigma, the constant part of F = f - k^2 sigma
    cos: tuple[float, ...]
    sin: tuple[float, ...]
    Y0: float  # constant part of the steady response
    hc: tuple[float, ...]  # its harmonics
    hs: tuple[float, ...]
    steady: bool  # whether the steady response is small enough to be subtracted without loss
    rate: float  # fastest rate of the flight; flights shorter than a fraction of 1/rate use the Duhamel form
    size: float  # bound on what the forced part adds up: steady response, or Duhamel's integral over a period
    force: float  # bound on |F|
    bend: float  # bound on |F''|
    piece: float  # longest piece of a window on which the lemma holds
    edges: tuple[float, ...]  # window edges in [0, T]: 0, zeros of F, T, T, ...
    first: float  # sign of F in the first window; signs alternate
    doubtful: tuple[float, ...]  # 1 for windows whose signs or ends rounding leaves open
    blur: float  # bound on the rounding of F
    grows: float  # fastest rate at which free flights part; 0 for alpha, k^2 >= 0, where none gains energy
    p: Any  # the parameters themselves, for the reset law


def by_stiffness(p: Any) -> bool:
    """Return whether the second parameter is the stiffness, not k; numbers of a kernel say it in a field of their own.

    What a named tuple has for fields the compiler knows: nothing of this is left where models have k.
    """
    return getattr(p, "direct", 1.0 if hasattr(p, "stiffness") else 0.0) > 0.0


def stiffness_of(p: Any) -> float:
    """Return the stiffness: k^2, or the second parameter itself."""
    return p[1] if by_stiffness(p) else p[1] * p[1]  # type: ignore[no-any-return]


def square_less(x: float, y: float) -> float:
    """Return x^2 - y to rounding, also where little is left of it; the square is split exactly (Dekker)."""
    split = 134217729.0 * x  # 2^27 + 1
    high = split - (split - x)
    low = x - high
    square = x * x
    return (square - y) + (((high * high - square) + 2.0 * high * low) + low * low)


def roots(p: Any) -> tuple[float, float, float, float]:
    """Return (q2, spread, l1, l2) without cancellation: q2 as a product, one root as k^2 over the larger one."""
    half, k2 = 0.5 * p[0], stiffness_of(p)
    q2 = square_less(half, k2) if by_stiffness(p) else (half - p[1]) * (half + p[1])
    spread = sqrt(abs(q2))
    if q2 <= 0.0:
        return q2, spread, -half, -half
    if half < 0.0:
        l1 = -half + spread
        return q2, spread, l1, k2 / l1
    l2 = -half - spread
    return q2, spread, k2 / l2, l2


def angle(omega: float, t: float) -> float:
    """Return omega t modulo 2 pi in [-pi, pi], to rounding for any |omega t| < 1e15.

    The product is split exactly (Dekker) and 2 pi is carried in four pieces: t0 = 1e9 costs no digit.
    """
    sign, t = (-1.0, -t) if t < 0.0 else (1.0, t)
    x = omega * t
    if not x > 3.0:
        return sign * x
    split = 134217729.0  # 2^27 + 1
    a, b = split * omega, split * t
    omega_high, t_high = a - (a - omega), b - (b - t)
    omega_low, t_low = omega - omega_high, t - t_high
    low = ((omega_high * t_high - x) + omega_high * t_low + omega_low * t_high) + omega_low * t_low
    n = floor(x / TWO_PI + 0.5)
    n_high = floor(n / 1048576.0) * 1048576.0  # 2^20: each product below is exact up to n = 2^50
    n_low = n - n_high
    x = (x - n_high * TWO_PI_1) - n_low * TWO_PI_1
    x = (x - n_high * TWO_PI_2) - n_low * TWO_PI_2
    x = (x - n_high * TWO_PI_3) - n_low * TWO_PI_3
    return sign * ((x + low) - n * TWO_PI_4)


def piece_of(q2: float, spread: float, grows: float, T: float) -> float:
    """Return the longest piece of a window on which the lemma holds: under half a turn of the free ball.

    And one on which free flights do not part further than :data:`LEAP` says.
    """
    piece = 0.95 * pi / spread if q2 < 0.0 else 2.0 * T
    return min(piece, LEAP / grows) if grows > 0.0 else piece


def natural_size(alpha: float, T: float, force: float) -> float:
    """Return how far a force can push the free ball in one period."""
    far = 0.5 * T * T
    return force * (min(far, T / alpha) if alpha > 0.0 else far)


def section_phase(p: Any) -> float:
    """Return the parameter ``phase``, for maps that have a section."""
    return p.phase  # type: ignore[no-any-return]


def no_phase(p: Any) -> float:
    """Return 0, for maps that measure time from t = 0."""
    return 0.0


def refuse_to_compile(harmonics: int) -> None:
    """Raise InputError for so many harmonics that nobody would wait for the compiler."""
    if harmonics > MOST_FLOWN:
        raise InputError(
            f"force and walls have {harmonics} harmonics; flights are compiled for at most {MOST_FLOWN}, as compiling "
            "takes a time that grows with their square: leave the highest ones out"
        )


@lru_cache(maxsize=64)
def constants_of(harmonics: int, phase: Callable[[Any], float] = no_phase, max_ratio: float = 100.0) -> Any:
    """Return ``prepare(p) -> Constants`` for parameters in the order of :attr:`Oscillator.params`.

    Parameters
    ----------
    harmonics : int
        At least 1, at most 200.
    phase : callable
        ``phase(p)``: the time that local time 0 stands for, :func:`section_phase` or :func:`no_phase`.
    max_ratio : float
        The steady response is subtracted while it is smaller than this multiple of what the force can do in one
        period; beyond (k -> 0, resonance) its digits would cancel, and the Duhamel form is used instead.
    """
    refuse_to_compile(harmonics)
    none = (0.0,) * harmonics
    no_edges = (0.0,) * (2 * harmonics + 2)
    head = len(HEAD)

    @unit
    def prepare(p: Any) -> Any:
        k2 = stiffness_of(p)
        q2, spread, l1, l2 = roots(p)
        grows = 0.0 if p.alpha >= 0.0 and k2 >= 0.0 else max(l1, 0.0)
        T = 2.0 * pi / p.omega
        theta = angle(p.omega, p.t0) + angle(p.omega, phase(p))
        F0 = p[head - 1] - k2 * p.sigma
        cos, sin, hc, hs = none, none, none, none
        force, bend, moving, top = abs(F0), 0.0, 0.0, 1
        steady = k2 != 0.0 or F0 == 0.0
        Y0 = F0 / k2 if k2 != 0.0 else 0.0
        response = abs(Y0)
        for j in range(harmonics):
            c, s = p[head + 2 * j], p[head + 2 * j + 1]
            W = (j + 1) * p.omega
            a, b = k2 - W * W, p.alpha * W
            det = a * a + b * b
            amplitude = length(c, s)
            cos, sin = replaced(cos, j, c), replaced(sin, j, s)
            force += amplitude
            bend += W * W * amplitude
            if amplitude > 0.0:
                moving, top = W, j + 1
                if det > 0.0:
                    hc = replaced(hc, j, (a * c - b * s) / det)
                    hs = replaced(hs, j, (b * c + a * s) / det)
                    response += amplitude / sqrt(det)
                else:
                    steady = False
        natural = natural_size(p.alpha, T, force)
        steady = steady and response <= max_ratio * natural
        rate = max(abs(p.alpha), sqrt(abs(k2)) if by_stiffness(p) else p[1], moving)
        size = response if steady else natural * top  # errors of phases add up to the highest harmonic
        piece = piece_of(q2, spread, grows, T)
        offset, lift = abs(p[head - 1]), abs(k2 * p.sigma)
        lost = 4e-16 * (offset + lift) if lift > 0.0 else 0.0
        blur = 1e-15 * force * harmonics + lost
        edges, first, doubtful = window_edges(F0, cos, sin, p.omega, theta, T, bend, no_edges, lost)
        return Constants(
            p.alpha, k2, q2, l1, l2, spread, p.omega, theta, T, p.sigma, F0, cos, sin, Y0, hc, hs,
            steady, rate, size, force, bend, piece, edges, first, doubtful, blur, grows, p,
        )  # fmt: skip

    return prepare


def forcing(t: float, c: Constants) -> tuple[float, float]:
    """Return F = f - k^2 sigma and dF/dt at local time t."""
    return series(t, c.F0, c.cos, c.sin, c.omega, c.theta)


def steady_response(t: float, c: Constants) -> tuple[float, float]:
    """Return the steady response Y and dY/dt at local time t; meaningful where ``c.steady``."""
    return series(t, c.Y0, c.hc, c.hs, c.omega, c.theta)


def steady_position(t: float, c: Constants) -> tuple[float, float]:
    """Return sigma + Y and dY/dt, of which the place of the wall takes no digits; meaningful where ``c.steady``."""
    return series(t, c.p[OFFSET] / c.k2 if c.k2 != 0.0 else c.sigma, c.hc, c.hs, c.omega, c.theta)
