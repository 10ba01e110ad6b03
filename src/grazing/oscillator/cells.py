"""Cells: one parameter value as a table, from which many orbits are flown side by side.

Write y = Y + c1 b1 + c2 b2, with Y a flight of the forced ball and b1, b2 two flights of the free one: an orbit
between impacts is the pair (c1, c2), and y at any instant is affine in it. Each sign window of the force is cut into
cells. A table holds, for its parameter value,

- the *certificate*: rows (p, q, r) such that p c1 + q c2 + r > margin in all of them proves a period without impact,
- a list of such rows for each cell: the first one that fails, in the order of time, tells where the next impact is,
- per cell, what a Taylor series needs.

The certificate. States that fly through a window without impact are a convex set, the intersection of the half
planes y(t) >= 0. Where F > 0 its boundary is the curve of states that graze at some t, so chords between states that
graze one after the other lie inside it; where F < 0 it is the half plane y(end) >= 0. See ``docs/proof.md``.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

from grazing.kernel.elementary import exp, sincos
from grazing.kernel.primitives import unit
from grazing.oscillator.constants import FAR, OFFSET, Constants, natural_size, steady_position
from grazing.oscillator.flight import duhamel, modes
from grazing.oscillator.taylor import REACH
from grazing.oscillator.windows import summed

#: Cells of one period beyond which a parameter value is left to the scalar routine.
MAX_CELLS = 96
#: Decay of the fast mode over a period beyond which the pair (c1, c2) would lose its digits.
MAX_DECAY = 30.0

# ---- where things stand in a table: the constants that each impact needs, the last being what the force can do to a
# velocity, the slowest impact to be solved here, the growth of errors there, 1 less the contraction of the law near
# zero speed, and which column of a block this is; then the rate of that growth, and the bound on the force;
ALPHA, K2, F0, OMEGA2, PUSH, SLOWEST, GROWTH, GAP, WHICH, RATE, FORCE = range(11)
CONSTANTS = 9
# margin = MARGIN[0] + MARGIN[1] |c1| + MARGIN[2] |c2|; the band;
MARGIN, BAND = 11, 14
# one period on: c -> s + A c, row by row; states from pairs: (u - sigma, v) = (y0 + y1 c1 + y2 c2, ...); pairs from
# states,
ONWARD, STATE, PAIR = 15, 21, 27
# how many rows the certificate has, padded to a multiple of 4, at least 8, and how many the list of all; the wall, and
# 1 where p = 1 in all rows;
COUNT, ROW_COUNT, SIGMA, UPRIGHT = 31, 32, 33, 34
# what is no matter of the table but of its column: where the numbers of its reset law are, 1 where there is a table,
# how many orbits need the scalar routine in this period, and how many have a state from there; 1 where its pairs were
# kept and no states came between, after how many periods they come back, if known, and until when it then stands still;
LAW, TABLED, NEEDY, HOLDING = 35, 36, 37, 38
LOOKED_AT, CYCLE, WAKE = 39, 40, 41
# then the certificate and the list of all rows, both in the order of time: all p, all q, all r, all places;
CERTIFICATE = 44
MAX_ROWS = 3 * MAX_CELLS + 24
ROWS = CERTIFICATE + 4 * MAX_ROWS
# for each cell the place from which to go on after an impact there, the first rows of the certificate and of the list
# that are not before it, and the time of its middle;
GO_ON = ROWS + 4 * MAX_ROWS
ENTER, LISTED, MIDDLE = (GO_ON + i * MAX_CELLS for i in (1, 2, 3))
# what a pair is as the other wall sees it, MIRROR - pair; what is added to the margin of a pair that comes from there;
# cells per time, and the last cell; the least of the comparison solutions; the share of the margin that chords do not
# magnify; how far from the wall an impact with the other one surely is; bounds on |E11| and |E22|, and on |E12|;
MIRROR, BROUGHT, PACE, LAST, LEAST, SHARP, SPAN, GROWN, LEVER = (
    MIDDLE + MAX_CELLS + i for i in (0, 2, 3, 4, 5, 6, 7, 8, 9)
)
# and the cells: Y, Y', b1, b1', b2, b2' at the middle, half the length, the time left in a window with F < 0, the
# inverse of the Wronskian b1 b2' - b2 b1', the first row of the certificate to be asked after an impact; the harmonics.
CELLS = LEVER + 3
HALF, TIME_LEFT, UNMIX, THEN = 6, 7, 8, 9
CELL = 10
# The points of a window while a table is filled, ends and middles of its cells: Y, Y', b1, b1', b2, b2' there, the
# sine and cosine of the forcing's phase, and the time.
POINTS = 2 * MAX_CELLS + 8
Y, DY, B1, D1, B2, D2, SINE, COSINE, TIME = (i * POINTS for i in range(9))
# In the order of time the start of the period has place 0, the chord of cell i place 2 i + 1, its end place 2 i + 2.

NEVER = 1e300  # as the constant of a row: holds for every orbit
ALWAYS = -1e300  # fails for every orbit: its cell is always looked into


def cell_size(harmonics: int) -> int:
    """Return how many numbers a cell has: a multiple of four."""
    return (CELL + 2 * harmonics + 3) // 4 * 4


def table_size(harmonics: int) -> int:
    """Return how many numbers a table has."""
    return CELLS + MAX_CELLS * cell_size(harmonics)


def exponential(c: Constants) -> bool:
    """Return whether the free flights are e^{l1 t}, e^{l2 t}; else the free fall from y = 1 and from v = 1."""
    return c.q2 * c.T * c.T >= 1.0


def put_points(x: Any, a: float, b: float, count: int, c: Constants) -> None:
    """Write the basis at the ends and in the middles of a window's cells, one after the other, as rows of ``x``."""
    points = 2 * count + 1
    for k in range(points):
        time = a + 0.5 * (b - a) / count * k if k < points - 1 else b
        x[TIME + k] = time
        x[SINE + k], x[COSINE + k] = sincos(c.omega * time + c.theta)
    if c.steady:
        for k in range(points):
            x[Y + k], x[DY + k] = summed(c.Y0, c.hc, c.hs, c.omega, x[SINE + k], x[COSINE + k])
    else:
        for k in range(points):
            x[Y + k], x[DY + k] = duhamel(x[TIME + k], 0.0, c)
    if exponential(c):
        for k in range(points):
            e1, e2 = exp(c.l1 * x[TIME + k]), exp(c.l2 * x[TIME + k])
            x[B1 + k], x[D1 + k], x[B2 + k], x[D2 + k] = e1, c.l1 * e1, e2, c.l2 * e2
    else:
        for k in range(points):
            E11, E12, E21, E22 = modes(x[TIME + k], c)
            damping = 0.5 * c.alpha
            x[B1 + k], x[D1 + k], x[B2 + k], x[D2 + k] = E11 - damping * E12, E21 - damping * E22, E12, E22


def cells_in(length: float, c: Constants) -> int:
    """Return into how many cells a window is cut; one more than a table has, where that is not enough."""
    cells = length * fastest(c) / REACH
    return int(cells) + 1 if cells < MAX_CELLS else MAX_CELLS + 1  # no whole number holds those of a stiff spring


def fastest(c: Constants) -> float:
    """Return the fastest rate of the flight: roots of the equation and harmonics of the force."""
    return max(max(-c.l2, sqrt(c.k2)), len(c.cos) * c.omega)


def out_of_range(c: Constants) -> bool:
    """Return whether doubles may not hold the 14 derivatives of a flight, or a pair the state over a wall far away."""
    if c.grows > 0.0:  # margins and bounds of a table are those of flights that gain no energy
        return True
    push = (c.force - abs(c.F0)) + abs(c.p[OFFSET])
    if not (c.steady and c.k2 > 0.0) and FAR * abs(c.sigma) > natural_size(c.alpha, c.T, push):
        return True
    return not (1e-15 <= fastest(c) <= 1e15 and (c.force == 0.0 or 1e-100 <= c.force <= 1e100))


def windows_in(c: Constants) -> int:
    """Return the number of sign windows in a period."""
    count = 1
    while count + 1 < len(c.edges) and c.edges[count] < c.T:
        count += 1
    return count


def put_row(t: Any, i: int, step: int, p: float, r: float, s: float) -> None:
    """Write a row (p, r, s); its numbers lie ``step`` apart."""
    t[i], t[i + step], t[i + 2 * step] = p, r, s


class Extent(NamedTuple):
    """How large the numbers of a table are, for the margin."""

    r: float  # of the rows: |r|,
    p: float  # |p|
    q: float  # and |q|
    b1: float  # of the free flights
    b2: float
    least: float  # the least value of the comparison solutions
    blur: float  # how much a chord magnifies the errors of its ends


def listed(t: Any, row: int, p: float, r: float, s: float, place: float) -> int:
    """Write a row of a list; return where the next one goes."""
    put_row(t, row, MAX_ROWS, p, r, s)
    t[row + 3 * MAX_ROWS] = place
    return row + 1


def pad(t: Any, row: int) -> None:
    """Write rows that every flight passes, to where whole vectors end."""
    end = row + 16
    while row < end:
        row = listed(t, row, 1.0, 0.0, NEVER, NEVER)


def row_from(t: Any, row: int, since: float) -> int:
    """Return the first row from ``row`` on whose place is ``since`` or later; lists end in padding of place NEVER."""
    while t[row + 3 * MAX_ROWS] < since:
        row += 1
    return row


def put_cell(t: Any, cell: int, x: Any, k: int, c: Constants) -> int:
    """Write what a Taylor series about point k needs; return where the cell's entries begin."""
    i = CELLS + cell * cell_size(len(c.cos))
    for h in range(6):
        t[i + h] = x[h * POINTS + k]
    sine, cosine = x[SINE + k], x[COSINE + k]
    sj, cj = sine, cosine
    for h in range(len(c.cos)):
        t[i + CELL + 2 * h] = c.cos[h] * cj + c.sin[h] * sj
        t[i + CELL + 2 * h + 1] = (h + 1) * c.omega * (c.sin[h] * cj - c.cos[h] * sj)
        sj, cj = sj * cosine + cj * sine, cj * cosine - sj * sine
    return i


def chord(
    f1: float, f2: float, g1: float, g2: float, h1: float, h2: float, band: float
) -> tuple[float, float, float, float]:
    """Return the row of the chord from (g1, g2) to (h1, h2), 1 on the comparison solution (f1, f2), and its blur.

    States with a value >= 0 lie on the side from which the wall is not touched; ``band`` is kept clear of the chord.
    """
    x1, x2 = h1 - g1, h2 - g2
    cross = f1 * x2 - f2 * x1
    size = abs(f1) * (abs(g2) + abs(h2)) + abs(f2) * (abs(g1) + abs(h1))
    if not size < 1e4 * abs(cross):
        return 0.0, 0.0, ALWAYS, 1.0
    inverse = 1.0 / cross
    return x2 / cross, -x1 * inverse, -(g1 * x2 - g2 * x1) * inverse - band, size * abs(inverse)


def extended(extent: Extent, p: float, q: float, r: float, blur: float) -> Extent:
    """Return the extent with a chord."""
    return Extent(
        max(extent.r, abs(r) if r > ALWAYS else 0.0), max(extent.p, abs(p)), max(extent.q, abs(q)),
        extent.b1, extent.b2, extent.least, max(extent.blur, blur),
    )  # fmt: skip


def fill_window(
    t: Any, x: Any, c: Constants, i: int, cell: int, n: int, m: int, extent: Extent, band: float
) -> tuple[int, int, int, Extent]:
    """Cut window i into cells, write them and their rows.

    Return the number of cells so far, where the next row of the certificate goes and where that of the list of all
    rows, and the extents.
    """
    a, b = c.edges[i], c.edges[i + 1]
    count = cells_in(b - a, c)
    length = (b - a) / count
    piece = min(count, max(1, int(c.piece / max(length, 1e-300))))  # cells on which one comparison solution is > 0
    positive = (-c.first if i % 2 == 1 else c.first) >= 0.0
    put_points(x, a, b, count, c)
    f1, f2, last, drawn = 1.0, 0.0, 0, True
    g1, g2, before1, before2 = 0.0, 0.0, 0.0, 0.0  # states that graze half a cell ago, and a whole one
    for k in range(2 * count + 1):
        j = k // 2
        if (j % piece == 0 and k % 2 == 1) or k == 0:
            last = min(j + piece, count)
            if c.q2 < 0.0:
                sine, cosine = sincos(c.spread * (a + 0.5 * length * (j + last)))
                f1, f2 = cosine, c.spread * sine
        y, v, b1, d1, b2, d2 = x[Y + k], x[DY + k], x[B1 + k], x[D1 + k], x[B2 + k], x[D2 + k]
        unmix = 1.0 / (b1 * d2 - b2 * d1)
        if k % 2 == 1:
            record = put_cell(t, cell + j, x, k, c)
            t[record + HALF], t[record + UNMIX] = 0.5 * length, unmix
            t[MIDDLE + cell + j] = x[TIME + k]
            t[record + TIME_LEFT] = 0.0 if positive else b - x[TIME + k]
            t[GO_ON + cell + j] = 2.0 * (cell + last) + 1.0 if positive else 2.0 * (cell + j) + 2.0
        if k == 0 or k == 2 * count:  # for put_maps: the first of all, and the last so far
            for h in range(6):
                t[(STATE if k == 0 and i == 0 else ONWARD) + h] = x[h * POINTS + k]
        phi = f1 * b1 + f2 * b2
        h1, h2 = (b2 * v - d2 * y) * unmix, (d1 * y - b1 * v) * unmix  # the state that grazes now
        inverse = 1.0 / phi
        p, r, s = b1 / phi, b2 * inverse, y * inverse
        extent = Extent(
            max(extent.r, abs(s)), max(extent.p, abs(p)), max(extent.q, abs(r)), max(extent.b1, abs(b1)),
            max(extent.b2, abs(b2)), min(extent.least, phi), extent.blur,
        )  # fmt: skip
        if k > 0 and positive:
            place = 2.0 * (cell + (k - 1) // 2) + 1.0
            cp, cr, cs, blur = chord(f1, f2, g1, g2, h1, h2, band)
            n = listed(t, n, cp, cr, cs, place)
            extent = extended(extent, cp, cr, cs, blur)
            drawn = cs > ALWAYS and (k % 2 == 1 or drawn)
            if k % 2 == 0:
                cp, cr, cs, blur = chord(f1, f2, before1, before2, h1, h2, band)
                m = listed(t, m, cp, cr, cs if drawn else ALWAYS, place)  # what the halves leave open is open
                extent = extended(extent, cp, cr, cs, blur)
        if k % 2 == 0 and (k > 0 or i == 0):
            m = listed(t, m, p, r, s, 2.0 * (cell + j))
            if j == last or k == 0:
                n = listed(t, n, p, r, s, 2.0 * (cell + j))
        if k % 2 == 0:
            before1, before2 = h1, h2
        g1, g2 = h1, h2
    return cell + count, n, m, extent


@unit
def fill_table(t: Any, x: Any, c: Constants, ratio: float, off: float = 0.0, off_v: float = 0.0) -> bool:
    """Fill a table; False where the parameter value must be left to the scalar routine.

    Parameters
    ----------
    t : ndarray, shape (table_size(harmonics),)
        The table, or the address of its numbers.
    x : ndarray, shape (9 * POINTS,)
        Room for the points of a window, or its address.
    c : Constants
    ratio : float
        Of the reset law's contraction near zero speed; 1 for none.
    off, off_v : float
        Errors of position and velocity that states bring along.
    """
    windows, total = windows_in(c), 0
    for i in range(windows):
        total += cells_in(c.edges[i + 1] - c.edges[i], c)
    if total > MAX_CELLS or -c.l2 * c.T > MAX_DECAY or out_of_range(c):
        return False
    # clearances below this are measured one by one: a few percent of what the chords cost
    band = 1e-3 * c.force * (0.5 * REACH / fastest(c)) ** 2
    extent = Extent(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
    start = int(0.0)  # of a literal 0 the compiler would make versions of their own
    cell, n, m = start, start + CERTIFICATE, start + ROWS
    for i in range(windows):
        cell, n, m, extent = fill_window(t, x, c, i, cell, n, m, extent, band)
    pad(t, n)
    pad(t, m)
    row, first, listing = start + CERTIFICATE, start + CERTIFICATE, start + ROWS
    for i in range(cell):
        row = row_from(t, row, t[GO_ON + i])
        t[CELLS + i * cell_size(len(c.cos)) + THEN] = row - CERTIFICATE
        first, listing = row_from(t, first, 2.0 * i + 1.0), row_from(t, listing, 2.0 * i + 1.0)
        t[ENTER + i], t[LISTED + i] = first, listing
    t[PACE], t[LAST] = cell / c.T, cell - 1
    reach = min(c.T, 1.0 / c.alpha) if c.alpha > 0.0 else c.T
    t[COUNT], t[ROW_COUNT] = max(8, (n - CERTIFICATE + 3) // 4 * 4), m - ROWS
    t[BAND] = band * extent.least
    t[ALPHA], t[K2], t[F0], t[OMEGA2] = c.alpha, c.k2, c.F0, c.omega * c.omega
    lever = min(reach, 1.0 / c.spread) if c.spread > 0.0 else reach  # |E12| is never more
    t[FORCE], t[PUSH], t[GROWTH] = c.force, lever * c.force, 1.0 + 4.0 * fastest(c) * lever
    t[SLOWEST], t[RATE] = 1e-5 * c.force * reach, 4.0 * fastest(c) + c.alpha
    t[GAP] = 1.0 - ratio
    t[UPRIGHT] = 1.0 if c.q2 >= 0.0 else 0.0  # then b1 is the comparison solution throughout
    small = 2.0**-40 * extent.blur
    t[LEAST], t[SHARP] = extent.least, 1.0 / extent.blur
    t[MARGIN] = small * (extent.r + (c.size + c.force * reach * c.T) / extent.least)
    t[MARGIN] += (t[GROWTH] * off + lever * off_v) / extent.least
    t[MARGIN + 1] = small * (extent.p + extent.b1 / extent.least)
    t[MARGIN + 2] = small * (extent.q + extent.b2 / extent.least)
    put_maps(t, c)
    return True


def put_maps(t: Any, c: Constants) -> None:
    """Write how pairs go over to the next period, and what they are as states."""
    first, end = STATE, ONWARD  # the windows left the basis at t = 0 and t = T here
    y, v, b1, d1, b2, d2 = (
        t[first], t[first + 1], t[first + 2], t[first + 3], t[first + 4], t[first + 5],
    )  # fmt: skip
    y_T, v_T, e1, f1, e2, f2 = t[end], t[end + 1], t[end + 2], t[end + 3], t[end + 4], t[end + 5]
    W = b1 * d2 - b2 * d1
    i11, i12, i21, i22 = d2 / W, -b2 / W, -d1 / W, b1 / W
    put_row(t, STATE, 1, y, b1, b2)
    t[SIGMA] = c.sigma
    u, _v = steady_position(0.0, c)
    if c.steady and abs(u) < FAR * abs(c.sigma):  # else little is left of positions as sums of a height and the wall's
        t[SIGMA], t[STATE] = 0.0, u
    put_row(t, STATE + 3, 1, v, d1, d2)
    t[PAIR], t[PAIR + 1], t[PAIR + 2], t[PAIR + 3] = i11, i12, i21, i22
    x1, x2 = (0.0, 0.0) if c.steady else (y_T - y, v_T - v)
    if exponential(c):
        put_row(t, ONWARD, 1, i11 * x1 + i12 * x2, e1, 0.0)
        put_row(t, ONWARD + 3, 1, i21 * x1 + i22 * x2, 0.0, e2)
    else:
        put_row(t, ONWARD, 1, i11 * x1 + i12 * x2, i11 * e1 + i12 * f1, i11 * e2 + i12 * f2)
        put_row(t, ONWARD + 3, 1, i21 * x1 + i22 * x2, i21 * e1 + i22 * f1, i21 * e2 + i22 * f2)
