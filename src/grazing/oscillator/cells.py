"""Cells: one parameter value as a table, from which many orbits are flown side by side.

Write y = Y + c1 b1 + c2 b2, with Y a flight of the forced ball and b1, b2 two flights of the free one: an orbit
between impacts is the pair (c1, c2), and y at any instant is affine in it. Each sign window of the force is cut into
cells. A table holds, for its parameter value,

- the *certificate*: rows (p, q, r) such that p c1 + q c2 + r > margin in all of them proves a period without impact,
- the rows again in the order of time, to find the cell of the first impact,
- per cell, what a Taylor series about its middle needs.

The certificate. States that fly through a window without impact are a convex set, the intersection of the half
planes y(t) >= 0. Where F > 0 its boundary is the curve of states that graze at some t, so chords between states that
graze at the ends of a cell lie inside it; where F < 0 it is the half plane y(end) >= 0. See ``docs/proof.md``.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

from grazing.kernel.elementary import exp, sincos
from grazing.oscillator.constants import Constants, steady_response
from grazing.oscillator.flight import duhamel, modes
from grazing.oscillator.taylor import REACH

#: Cells of one period beyond which a parameter value is left to the scalar routine.
MAX_CELLS = 48
#: Decay of the fast mode over a period beyond which the pair (c1, c2) would lose its digits.
MAX_DECAY = 30.0

# ---- where things stand in a table: the constants of the parameter value,
ALPHA, K2, F0, OMEGA2, FORCE, RATIO, SLOWEST, BAND = 0, 1, 2, 3, 4, 5, 6, 7
# margin = MARGIN[0] + MARGIN[1] |c1| + MARGIN[2] |c2|, and the least value of the comparison solution,
MARGIN = 8
LEAST = 11
# one period on: c -> A c + s, row by row; states from pairs: (u, v) = (u0 + u1 c1 + u2 c2, ...); pairs from states,
ONWARD, STATE, PAIR = 12, 18, 24
# how many rows of the certificate, how many cells, both padded;
CERTIFICATE_COUNT, CELL_COUNT, GROWTH = 28, 29, 31
# then the certificate: p of all rows, q, r, and the place of each in the order of time;
CERTIFICATE = 32
MAX_CERTIFICATE = 2 * MAX_CELLS + 16
# rows of the cells, in the same way: chord, rise (negative where y/phi falls at the end of the cell), end;
CHORD = CERTIFICATE + 4 * MAX_CERTIFICATE
RISE, END, CELLS = CHORD + 3 * MAX_CELLS, CHORD + 6 * MAX_CELLS, CHORD + 9 * MAX_CELLS
#: and the cells: Y, Y', b1, b1', b2, b2' at its middle, half its length, time left in a window with F < 0; the harmonics.
#: In the order of time the chord of cell i is number 2 i + 1, its end number 2 i + 2.
CELL = 8

NEVER = 1e300  # as the constant of a row: holds for every orbit
ALWAYS = -1e300  # fails for every orbit: its cell is always looked into


def table_size(harmonics: int) -> int:
    """Return how many numbers a table has."""
    return CELLS + MAX_CELLS * (CELL + 2 * harmonics)


def exponential(c: Constants) -> bool:
    """Return whether the free flights are e^{l1 t}, e^{l2 t}; else the free fall from y = 1 and from v = 1."""
    return c.q2 * c.T * c.T >= 1.0


def basis(t: float, c: Constants) -> tuple[float, float, float, float, float, float]:
    """Return Y, Y', b1, b1', b2, b2' at local time t."""
    if c.steady:
        Y, dY = steady_response(t, c)
    else:
        Y, dY = duhamel(t, 0.0, c)
    if exponential(c):
        e1, e2 = exp(c.l1 * t), exp(c.l2 * t)
        return Y, dY, e1, c.l1 * e1, e2, c.l2 * e2
    E11, E12, E21, E22 = modes(t, c)
    half = 0.5 * c.alpha
    return Y, dY, E11 - half * E12, E21 - half * E22, E12, E22


def cells_in(length: float, c: Constants) -> int:
    """Return into how many cells a window is cut."""
    return int(length * fastest(c) / REACH) + 1


def fastest(c: Constants) -> float:
    """Return the fastest rate of the flight: roots of the equation and harmonics of the force."""
    return max(max(-c.l2, sqrt(c.k2)), len(c.cos) * c.omega)


def windows_in(c: Constants) -> int:
    """Return the number of sign windows in a period."""
    count = 1
    while count + 1 < len(c.edges) and c.edges[count] < c.T:
        count += 1
    return count


def put_row(t: Any, q: int, at: int, step: int, p: float, r: float, s: float) -> None:
    """Write a row (p, r, s); its numbers lie ``step`` apart."""
    t[q, at], t[q, at + step], t[q, at + 2 * step] = p, r, s


def certified_by(t: Any, q: int, n: int, p: float, r: float, s: float, order: int) -> int:
    """Write row n of the certificate, which stands at place ``order`` in time; return n + 1."""
    put_row(t, q, CERTIFICATE + n, MAX_CERTIFICATE, p, r, s)
    t[q, CERTIFICATE + 3 * MAX_CERTIFICATE + n] = order
    return n + 1


def fill_table(t: Any, q: int, c: Constants, ratio: float) -> bool:
    """Fill table q; False where the parameter value must be left to the scalar routine.

    Parameters
    ----------
    t : ndarray, shape (tables, table_size(harmonics))
    q : int
    c : Constants
    ratio : float
        Of the reset law's contraction near zero speed; 1 for none.
    """
    windows, total = windows_in(c), 0
    for i in range(windows):
        total += cells_in(c.edges[i + 1] - c.edges[i], c)
    if total > MAX_CELLS or -c.l2 * c.T > MAX_DECAY:
        return False
    width = CELL + 2 * len(c.cos)
    wavy = c.q2 < 0.0
    p0, p1, p2, blur, least, size1, size2 = 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0
    certificate, cell = 0, 0
    # clearances below this are measured one by one, see ``near`` in maps/ensemble.py: a hundredth of what chords cost
    band = 1e-3 * c.force * (REACH / fastest(c)) ** 2
    Y0, dY0, s1, ds1, s2, ds2 = basis(0.0, c)
    Y, dY, b1, d1, b2, d2 = Y0, dY0, s1, ds1, s2, ds2
    for i in range(windows):
        a, b = c.edges[i], c.edges[i + 1]
        count = cells_in(b - a, c)
        length = (b - a) / count
        pieces = min(count, max(1, int(c.piece / length))) if length > 0.0 else count  # cells in which one phi is > 0
        positive = (-c.first if i % 2 == 1 else c.first) >= 0.0
        f1, f2, g1, g2 = 1.0, 0.0, 0.0, 0.0
        for j in range(2 * count + 1):
            time = b if j == 2 * count else a + 0.5 * length * j
            Y, dY, b1, d1, b2, d2 = basis(time, c)
            if j % 2 == 1:  # the middle of a cell
                at = CELLS + cell * width
                t[q, at], t[q, at + 1], t[q, at + 2], t[q, at + 3] = Y, dY, b1, d1
                t[q, at + 4], t[q, at + 5], t[q, at + 6] = b2, d2, 0.5 * length
                t[q, at + 7] = 0.0 if positive else b - time
                sine, cosine = sincos(c.omega * time + c.theta)
                sj, cj = sine, cosine
                for h in range(len(c.cos)):
                    t[q, at + CELL + 2 * h] = c.cos[h] * cj + c.sin[h] * sj
                    t[q, at + CELL + 2 * h + 1] = (h + 1) * c.omega * (c.sin[h] * cj - c.cos[h] * sj)
                    sj, cj = sj * cosine + cj * sine, cj * cosine - sj * sine
                continue
            if j == 0 or (wavy and (j - 2) % (2 * pieces) == 0):  # the first end of a piece
                start = max(j - 2, 0)
                middle = a + 0.5 * length * (start + min(pieces, count - start // 2))
                if wavy:
                    sine, cosine = sincos(c.spread * middle)
                    f1, f2 = cosine, c.spread * sine
            phi = f1 * b1 + f2 * b2
            least = min(least, phi)
            size1, size2 = max(size1, abs(b1)), max(size2, abs(b2))
            if j > 0 or i == 0:
                p0, p1, p2 = max(p0, abs(Y / phi)), max(p1, abs(b1 / phi)), max(p2, abs(b2 / phi))
            W = b1 * d2 - b2 * d1
            h1, h2 = (b2 * dY - d2 * Y) / W, (d1 * Y - b1 * dY) / W  # the state that grazes here
            if j == 0:
                if i == 0:
                    certificate = certified_by(t, q, 0, b1 / phi, b2 / phi, Y / phi, 0)
                g1, g2 = h1, h2
                continue
            x1, x2, r, cross = 0.0, 0.0, NEVER, 1.0
            if positive:
                x1, x2 = h1 - g1, h2 - g2
                cross = f1 * x2 - f2 * x1
                unsure = abs(cross) * 1e4 < abs(f1) * (abs(g2) + abs(h2)) + abs(f2) * (abs(g1) + abs(h1))
                if unsure or not abs(x2 / cross) + abs(x1 / cross) < NEVER:
                    x1, x2, r = 0.0, 0.0, ALWAYS
                    cross = 1.0
                else:
                    r = -(g1 * x2 - g2 * x1) / cross - band
                    blur = max(blur, (abs(f1) * (abs(g2) + abs(h2)) + abs(f2) * (abs(g1) + abs(h1))) / abs(cross))
                    p0, p1, p2 = max(p0, abs(r)), max(p1, abs(x2 / cross)), max(p2, abs(x1 / cross))
                certificate = certified_by(t, q, certificate, x2 / cross, -x1 / cross, r, 2 * cell + 1)
                g1, g2 = h1, h2
            psi = c.l1
            if wavy:
                sine, cosine = sincos(0.5 * c.spread * length)
                psi -= c.spread * sine / cosine
            put_row(t, q, CHORD + cell, MAX_CELLS, x2 / cross, -x1 / cross, r)
            put_row(t, q, RISE + cell, MAX_CELLS, d1 - psi * b1, d2 - psi * b2, dY - psi * Y)
            put_row(t, q, END + cell, MAX_CELLS, b1 / phi, b2 / phi, Y / phi)
            if j == 2 * count or j % (2 * pieces) == 0:
                certificate = certified_by(t, q, certificate, b1 / phi, b2 / phi, Y / phi, 2 * cell + 2)
            cell += 1
    while certificate % 8 != 0:
        certificate = certified_by(t, q, certificate, 0.0, 0.0, NEVER, 0)
    while cell % 16 != 0:
        put_row(t, q, CHORD + cell, MAX_CELLS, 0.0, 0.0, NEVER)
        put_row(t, q, RISE + cell, MAX_CELLS, 0.0, 0.0, 0.0)
        put_row(t, q, END + cell, MAX_CELLS, 0.0, 0.0, NEVER)
        cell += 1
    t[q, CERTIFICATE_COUNT], t[q, CELL_COUNT] = certificate, cell
    t[q, ALPHA], t[q, K2], t[q, F0], t[q, OMEGA2] = c.alpha, c.k2, c.F0, c.omega * c.omega
    reach = min(c.T, 1.0 / c.alpha) if c.alpha > 0.0 else c.T
    t[q, FORCE], t[q, GROWTH] = c.force * (1.0 + reach), 4.0 * (1.0 + fastest(c) * reach)
    t[q, RATIO], t[q, LEAST], t[q, BAND] = ratio, least, band * least
    t[q, SLOWEST] = 1e-5 * c.force * reach
    small = 2.0**-40 * blur
    t[q, MARGIN] = small * (p0 + (c.size + c.force * reach * c.T) / least)
    t[q, MARGIN + 1] = small * (p1 + size1 / least)
    t[q, MARGIN + 2] = small * (p2 + size2 / least)
    W = s1 * ds2 - s2 * ds1
    i11, i12, i21, i22 = ds2 / W, -s2 / W, -ds1 / W, s1 / W
    put_row(t, q, STATE, 1, c.sigma + Y0, s1, s2)
    put_row(t, q, STATE + 3, 1, dY0, ds1, ds2)
    t[q, PAIR], t[q, PAIR + 1], t[q, PAIR + 2], t[q, PAIR + 3] = i11, i12, i21, i22
    x1, x2 = (0.0, 0.0) if c.steady else (Y - Y0, dY - dY0)
    if exponential(c):
        put_row(t, q, ONWARD, 1, i11 * x1 + i12 * x2, b1, 0.0)
        put_row(t, q, ONWARD + 3, 1, i21 * x1 + i22 * x2, 0.0, b2)
    else:
        put_row(t, q, ONWARD, 1, i11 * x1 + i12 * x2, i11 * b1 + i12 * d1, i11 * b2 + i12 * d2)
        put_row(t, q, ONWARD + 3, 1, i21 * x1 + i22 * x2, i21 * b1 + i22 * d1, i21 * b2 + i22 * d2)
    return True
