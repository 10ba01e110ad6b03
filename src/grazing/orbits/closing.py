"""The equations of an orbit with n impacts in N periods, as kernels: flights from impact to impact that close.

Unknown are the times t_1 < ... < t_n of the impacts and the velocities w_1, ..., w_n after them. The flight from
impact i to the next one, the last being t_1 + N T, must end on the wall, and the law must give the next velocity:

    y_i(t_{i+1}) = 0,    w_{i+1} = g_{i+1}(v_i(t_{i+1})).

Each impact has its wall. A flight is that of an oscillator above the wall that it leaves, at rest, and heights and
velocities are those that the wall sees (:mod:`grazing.oscillator.frames`); where it ends at another wall, y_i and v_i
are what that one sees.

Flights are closed form, so this is analytic in all unknowns as long as the laws are: also where an impact's speed
passes through zero, at a graze, where a section's map has a square root. There the solution goes on, virtually, with
v > 0: the ball would come out of the wall. Each impact has its law g_i by address, a piece of its wall's own.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import floor
from typing import Any

import numpy as np

from grazing.kernel.compile import compiled
from grazing.kernel.elementary import exp
from grazing.kernel.primitives import called
from grazing.maps.linear import solved
from grazing.maps.period import product
from grazing.orbits.closure import contact_after, lowest_dip
from grazing.orbits.contacts import framer
from grazing.oscillator.constants import Constants, forcing
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.frames import Frames, frame_of, seen_across

#: Newton steps after which an orbit counts as not found.
STEPS = 40
#: Part of a flight's time that it keeps at least in one Newton step.
KEPT = 0.3
#: Columns of a profile, one row per flight: velocity at its end, slope of the law there, velocity that it gives,
#: lowest dip, which dip, number of dips, time of the lowest after the flight's start, the lowest with those of impacts
#: without speed (see :func:`grazing.orbits.closure.lowest_dip`), force on the wall at its start, time to the first
#: contact, 1 if that is one with the second wall. Dips are those to the wall that the flight leaves; OTHER columns
#: further are those to the other one.
ENDING, SLOPE, LEAVING, LOW, DIP, DIPS, WHEN, DEEP, FORCE, CONTACT, STRUCK = range(11)
OTHER = 8
PROFILE = DEEP + OTHER + 1


def leg(x: Any, i: int, n: int, N: int, T: float) -> tuple[float, float, float]:
    """Return the start, duration and initial velocity of flight i."""
    end = x[0] + N * T if i == n - 1 else x[i + 1]
    return x[i], end - x[i], x[n + i]


def ending(t: float, L: float, w: float, b: bool, there: bool, c: Frames) -> tuple[float, float]:
    """Return the end of a flight as the wall sees it that it ends at; ``b``, ``there``: whether that is the second."""
    here = frame_of(b, c)
    y, v = flight(L, anchored(t, 0.0, w, here), here)
    return (y, v) if b == there else seen_across(t + L, y, v, c)


def gaps(x: Any, n: int, N: int, laws: Any, c: Frames, F: Any, J: Any) -> bool:
    """Write the defects of the closing equations and their derivatives to F (2n,) and J (2n, 2n); False if no flight.

    ``laws`` (n, 4): addresses of each impact's law, of its slope, of their numbers, and 1 for the second wall.
    """
    for i in range(2 * n):
        for j in range(2 * n):
            J[i, j] = 0.0
    for i in range(n):
        t, L, w = leg(x, i, n, N, c.a.T)
        if not L > 0.0:
            return False
        k = 0 if i == n - 1 else i + 1
        b, there = laws[i, 3] > 0.0, laws[k, 3] > 0.0
        y, v = ending(t, L, w, b, there, c)
        here, beyond = frame_of(b, c), frame_of(there, c)
        E11, E12, E21, E22 = modes(L, here)
        F0, _dF = forcing(t, here)
        F1, _dF = forcing(t + L, beyond)
        lift = F0 - here.alpha * w
        fall = F1 - here.alpha * v - here.k2 * y
        turn = 1.0 if b == there else -1.0  # what is up for one wall is down for the other
        g = called(laws[k, 1], v, laws[k, 2])
        F[i] = y
        F[n + i] = x[n + k] - called(laws[k, 0], v, laws[k, 2])
        # starting later by dt is starting at (-w dt, -lift dt) in the flight's own time
        J[i, i] -= turn * (E11 * w + E12 * lift)
        J[i, k] += v
        J[i, n + i] += turn * E12
        J[n + i, i] += g * turn * (E21 * w + E22 * lift)
        J[n + i, k] -= g * fall
        J[n + i, n + i] -= g * turn * E22
        J[n + i, n + k] += 1.0
    return True


def stepped(x: Any, n: int, N: int, move: Any, T: float) -> bool:
    """Take a Newton step, shortened so that no flight loses more than most of its time; whether it was whole."""
    share = 1.0
    for i in range(n):
        _t, L, _w = leg(x, i, n, N, T)
        shrink = move[0 if i == n - 1 else i + 1] - move[i]  # x - move is the new point
        if shrink > (1.0 - KEPT) * L:
            share = min(share, (1.0 - KEPT) * L / shrink)
    for i in range(2 * n):
        x[i] -= share * move[i]
    return share == 1.0


def seen_at(i: int, laws: Any, c: Frames) -> Constants:
    """Return what the wall of impact i sees."""
    return frame_of(laws[i, 3] > 0.0, c)


def speed_of(c: Constants) -> float:
    """Return the size of velocities that a wall sees."""
    return c.size * max(c.rate, 1.0 / c.T) if c.size > 0.0 else 1.0


def close(x: Any, n: int, N: int, laws: Any, c: Frames, F: Any, J: Any) -> float:
    """Solve the closing equations by Newton's method from x, which becomes the solution; the residual, NaN for none."""
    move, unit, size = np.empty(2 * n), np.empty(2 * n), np.empty(n)
    T, before = c.a.T, float("inf")
    for i in range(n):
        here = seen_at(i, laws, c)
        size[i], unit[i], unit[n + i] = here.size, T, speed_of(here)
    for _ in range(STEPS):
        if not gaps(x, n, N, laws, c, F, J):
            return float("nan")
        for i in range(2 * n):
            move[i] = F[i]
        if not solved(J, move, unit):
            return float("nan")
        far = 0.0
        for i in range(n):
            far = max(far, abs(move[i]) / T, abs(move[n + i]) / (unit[n + i] + abs(x[n + i])))
        if not far < 1e6:
            return float("nan")
        whole = stepped(x, n, N, move, T)
        if whole and (far <= 1e-15 or (far <= 1e-9 and far >= 0.25 * before)):
            if not gaps(x, n, N, laws, c, F, J):
                return float("nan")
            worst = 0.0
            for i in range(n):
                k = 0 if i == n - 1 else i + 1
                worst = max(worst, abs(F[i]) / size[k], abs(F[n + i]) / (unit[n + k] + abs(x[n + i])))
            return worst
        before = far if whole else float("inf")
    return float("nan")


def profiled(x: Any, n: int, N: int, laws: Any, contacts: bool, c: Frames, table: Any) -> tuple[float, float, float]:
    """Write the profile of an orbit's flights to ``table`` (n, PROFILE); return (s tr J, s det J, s).

    J is the derivative of one turn, the product of S_i E_i with the saltation matrices S_i, and s = v_1 ... v_n, each
    in units of the speeds that its wall sees: with it nothing is infinite where the speed v_i of an impact is 0, and no
    product is lost in any unit. A turn changes walls an even number of times, so that
    the signs that come with each change cancel.
    """
    M, det, scale, T = (1.0, 0.0, 0.0, 1.0), 1.0, 1.0, c.a.T
    for i in range(n):
        t, L, w = leg(x, i, n, N, T)
        k = 0 if i == n - 1 else i + 1
        b, there = laws[i, 3] > 0.0, laws[k, 3] > 0.0
        y, v = ending(t, L, w, b, there, c)
        here, beyond = frame_of(b, c), frame_of(there, c)
        F0, _dF = forcing(t, here)
        F1, _dF = forcing(t + L, beyond)
        g = called(laws[k, 1], v, laws[k, 2])
        after = called(laws[k, 0], v, laws[k, 2])
        fall, lift = F1 - here.alpha * v - here.k2 * y, F1 - here.alpha * after
        fast = speed_of(beyond)
        M = product((after / fast, 0.0, (lift - g * fall) / fast, g * (v / fast)), product(modes(L, here), M))
        det *= g * (after / fast) * exp(-here.alpha * L)  # on its own: from M the difference of large numbers
        scale *= v / fast
        low, dip, dips, when, deep = lowest_dip(t, 0.0, w, L, b == there, here)
        table[i, 0], table[i, 1], table[i, 2], table[i, 3] = v, g, after, low
        table[i, 4], table[i, 5], table[i, 6], table[i, 7], table[i, 8] = dip, dips, when, deep, F0
        table[i, 9], table[i, 10] = float("nan"), laws[k, 3]
        if contacts and w >= 0.0:
            table[i, 9], struck = contact_after(t - T * floor(t / T), w, b, N, c)
            table[i, 10] = 1.0 if struck else 0.0
        low, dip, dips, when, deep = float("inf"), 0, 0, 0.0, float("inf")
        if c.two:
            y, v = seen_across(t, 0.0, w, c)
            low, dip, dips, when, deep = lowest_dip(t, y, v, L, b != there, frame_of(not b, c))
        table[i, 11], table[i, 12], table[i, 13], table[i, 14], table[i, 15] = low, dip, dips, when, deep
    return M[0] + M[3], det, scale


@lru_cache(maxsize=64)
def closer(harmonics: int, walled: bool) -> tuple[Callable[..., Any], Callable[..., Any], Callable[..., Any]]:
    """Compile the equations for models with so many harmonics, see :func:`grazing.orbits.contacts.framer`.

    Returns
    -------
    gaps : callable
        ``gaps(rows, x, N, laws, F, J)`` at k points: x (k, 2n), laws (k, n, 4), F (k, 2n), J (k, 2n, 2n).
    close : callable
        ``close(row, guesses, N, laws, residuals)``: Newton's method from each row of guesses (k, 2n).
    profile : callable
        ``profile(rows, x, N, laws, contacts, table, out)`` at k points: ``out`` (k, 3) gets what :func:`profiled`
        returns.
    """
    frames = framer(harmonics, walled)

    def gaps_at(rows: Any, x: Any, N: int, laws: Any, F: Any, J: Any) -> None:
        for i in range(x.shape[0]):
            gaps(x[i], x.shape[1] // 2, N, laws[i], frames(rows[i]), F[i], J[i])

    def close_all(row: Any, guesses: Any, N: int, laws: Any, residuals: Any) -> None:
        c = frames(row)
        n = guesses.shape[1] // 2
        F, J = np.empty(2 * n), np.empty((2 * n, 2 * n))
        for i in range(guesses.shape[0]):
            residuals[i] = close(guesses[i], n, N, laws, c, F, J)

    def profile_at(rows: Any, x: Any, N: int, laws: Any, contacts: bool, table: Any, out: Any) -> None:
        for i in range(x.shape[0]):
            n, c = x.shape[1] // 2, frames(rows[i])
            out[i, 0], out[i, 1], out[i, 2] = profiled(x[i], n, N, laws[i], contacts, c, table[i])

    return compiled(gaps_at), compiled(close_all), compiled(profile_at)
