"""The equations of an orbit with n impacts in N periods, as kernels: flights from impact to impact that close.

Unknown are the times t_1 < ... < t_n of the impacts and the velocities w_1, ..., w_n after them. The flight from
impact i to the next one, the last being t_1 + N T, must end on the wall, and the law must give the next velocity:

    y_i(t_{i+1}) = 0,    w_{i+1} = g_{i+1}(v_i(t_{i+1})).

Flights are closed form, so this is analytic in all unknowns as long as the laws are: also where an impact's speed
passes through zero, at a graze, where a section's map has a square root. There the solution goes on, virtually, with
v > 0: the ball would come out of the wall. Each impact has its law g_i by address, a piece of the model's own.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import floor
from typing import Any

import numpy as np

from grazing.kernel.compile import compiled
from grazing.kernel.elementary import exp
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import called
from grazing.maps.linear import solved
from grazing.maps.period import product
from grazing.orbits.closure import first_contact, lowest_dip
from grazing.oscillator.constants import Constants, constants_of, forcing
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.pointed import flight_kind

#: Newton steps after which an orbit counts as not found.
STEPS = 40
#: Part of a flight's time that it keeps at least in one Newton step.
KEPT = 0.3
#: Columns of a profile, one row per flight: velocity at its end, slope of the law there, velocity that it gives,
#: lowest dip, which dip, number of dips, time of the lowest after the flight's start, force on the wall at its
#: start, time to the first contact.
ENDING, SLOPE, LEAVING, LOW, DIP, DIPS, WHEN, FORCE, CONTACT = range(9)
PROFILE = 9


def leg(x: Any, i: int, n: int, N: int, c: Constants) -> tuple[float, float, float]:
    """Return the start, duration and initial velocity of flight i."""
    end = x[0] + N * c.T if i == n - 1 else x[i + 1]
    return x[i], end - x[i], x[n + i]


def gaps(x: Any, n: int, N: int, laws: Any, c: Constants, F: Any, J: Any) -> bool:
    """Write the defects of the closing equations and their derivatives to F (2n,) and J (2n, 2n); False if no flight.

    ``laws`` (n, 3): addresses of each impact's law, of its slope, of their numbers.
    """
    for i in range(2 * n):
        for j in range(2 * n):
            J[i, j] = 0.0
    for i in range(n):
        t, L, w = leg(x, i, n, N, c)
        if not L > 0.0:
            return False
        y, v = flight(L, anchored(t, 0.0, w, c), c)
        E11, E12, E21, E22 = modes(L, c)
        F0, _dF = forcing(t, c)
        F1, _dF = forcing(t + L, c)
        lift = F0 - c.alpha * w
        fall = F1 - c.alpha * v - c.k2 * y
        k = 0 if i == n - 1 else i + 1
        g = called(laws[k, 1], v, laws[k, 2])
        F[i] = y
        F[n + i] = x[n + k] - called(laws[k, 0], v, laws[k, 2])
        # starting later by dt is starting at (-w dt, -lift dt) in the flight's own time
        J[i, i] -= E11 * w + E12 * lift
        J[i, k] += v
        J[i, n + i] += E12
        J[n + i, i] += g * (E21 * w + E22 * lift)
        J[n + i, k] -= g * fall
        J[n + i, n + i] -= g * E22
        J[n + i, n + k] += 1.0
    return True


def stepped(x: Any, n: int, N: int, move: Any, c: Constants) -> bool:
    """Take a Newton step, shortened so that no flight loses more than most of its time; whether it was whole."""
    share = 1.0
    for i in range(n):
        _t, L, _w = leg(x, i, n, N, c)
        shrink = move[0 if i == n - 1 else i + 1] - move[i]  # x - move is the new point
        if shrink > (1.0 - KEPT) * L:
            share = min(share, (1.0 - KEPT) * L / shrink)
    for i in range(2 * n):
        x[i] -= share * move[i]
    return share == 1.0


def close(x: Any, n: int, N: int, laws: Any, c: Constants, F: Any, J: Any) -> float:
    """Solve the closing equations by Newton's method from x, which becomes the solution; the residual, NaN for none."""
    move, before = np.empty(2 * n), float("inf")
    speed = c.size * c.rate
    for _ in range(STEPS):
        if not gaps(x, n, N, laws, c, F, J):
            return float("nan")
        for i in range(2 * n):
            move[i] = F[i]
        if not solved(J, move):
            return float("nan")
        size = 0.0
        for i in range(n):
            size = max(size, abs(move[i]) / c.T, abs(move[n + i]) / (speed + abs(x[n + i])))
        if not size < 1e6:
            return float("nan")
        whole = stepped(x, n, N, move, c)
        if whole and (size <= 1e-15 or (size <= 1e-9 and size >= 0.25 * before)):
            if not gaps(x, n, N, laws, c, F, J):
                return float("nan")
            worst = 0.0
            for i in range(n):
                worst = max(worst, abs(F[i]) / c.size, abs(F[n + i]) / (speed + abs(x[n + i])))
            return worst
        before = size if whole else float("inf")
    return float("nan")


def profiled(x: Any, n: int, N: int, laws: Any, contacts: bool, c: Constants, table: Any) -> tuple[float, float, float]:
    """Write the profile of an orbit's flights to ``table`` (n, PROFILE); return (s tr J, s det J, s).

    J is the derivative of one turn, the product of S_i E_i with the saltation matrices S_i, and s = v_1 ... v_n: with
    it nothing is infinite where the speed v_i of an impact is 0.
    """
    M, det, scale = (1.0, 0.0, 0.0, 1.0), 1.0, 1.0
    for i in range(n):
        t, L, w = leg(x, i, n, N, c)
        y, v = flight(L, anchored(t, 0.0, w, c), c)
        F0, _dF = forcing(t, c)
        F1, _dF = forcing(t + L, c)
        k = 0 if i == n - 1 else i + 1
        g = called(laws[k, 1], v, laws[k, 2])
        after = called(laws[k, 0], v, laws[k, 2])
        fall, lift = F1 - c.alpha * v - c.k2 * y, F1 - c.alpha * after
        M = product((after, 0.0, lift - g * fall, g * v), product(modes(L, c), M))
        det *= g * after * exp(-c.alpha * L)  # on its own: from M it would be the difference of large numbers
        scale *= v
        low, dip, dips, when = lowest_dip(t, 0.0, w, L, c)
        table[i, 0], table[i, 1], table[i, 2], table[i, 3] = v, g, after, low
        table[i, 4], table[i, 5], table[i, 6], table[i, 7] = dip, dips, when, F0
        table[i, 8] = first_contact(t - c.T * floor(t / c.T), w, N, c) if contacts and w >= 0.0 else float("nan")
    return M[0] + M[3], det, scale


@lru_cache(maxsize=64)
def closer(harmonics: int) -> tuple[Callable[..., Any], Callable[..., Any], Callable[..., Any]]:
    """Compile the equations for models with so many harmonics.

    Returns
    -------
    gaps : callable
        ``gaps(row, x, N, laws, F, J) -> bool``.
    close : callable
        ``close(row, guesses, N, laws, residuals)``: Newton's method from each row of guesses (k, 2n).
    profile : callable
        ``profile(row, x, N, laws, contacts, table, out)``: ``out`` (3,) gets what :func:`profiled` returns.
    """
    unpack, constants = unpacker(flight_kind(harmonics)), constants_of(harmonics)

    def gaps_at(row: Any, x: Any, N: int, laws: Any, F: Any, J: Any) -> bool:
        return gaps(x, len(x) // 2, N, laws, constants(unpack(row)), F, J)

    def close_all(row: Any, guesses: Any, N: int, laws: Any, residuals: Any) -> None:
        c = constants(unpack(row))
        n = guesses.shape[1] // 2
        F, J = np.empty(2 * n), np.empty((2 * n, 2 * n))
        for i in range(guesses.shape[0]):
            residuals[i] = close(guesses[i], n, N, laws, c, F, J)

    def profile_at(row: Any, x: Any, N: int, laws: Any, contacts: bool, table: Any, out: Any) -> None:
        out[0], out[1], out[2] = profiled(x, len(x) // 2, N, laws, contacts, constants(unpack(row)), table)

    return compiled(gaps_at), compiled(close_all), compiled(profile_at)
