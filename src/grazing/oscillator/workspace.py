"""The workspace of a block: arrays one behind the other, named by where they begin.

One array for all of them lets the compiler see that they do not overlap, so that loops over them vectorise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grazing.oscillator.cells import cell_size, table_size

Floats = NDArray[np.float64]

#: Orbits of a block, and the room of an array in the workspace: loops may run over by up to 64.
LANES = 512
WIDTH = LANES + 72
#: Impacts that are solved together, step by step.
SOME = 48

# Arrays over the orbits of a block: the pair (c1, c2), what all rows must reach, 1 where they do and -1 where not, the
# narrowest miss, the slowest impact, the state where the scalar routine is needed, the number of the orbit, how often
# it hit the wall, where its state is, 1 where the scalar routine is wanted, the pair of a period ago.
C1, C2, NEED, FREE, NEAR, SLOW, U, V, NUMBER, HITS, WHERE, WANTED, OLD1, OLD2 = (i * WIDTH for i in range(14))
# Arrays over the impacts at hand: pair, margin, which orbit, how many impacts it had in this period, the place of what
# comes next, its cell, where the cell begins in the tables, the cell of the impact before;
X1, X2, DOUBT, ORBIT, MET, EVENT, INSIDE, RECORD, BACK = (i * WIDTH for i in range(14, 23))
# constants of the column in the order of the table: alpha, k^2, F0, omega^2, what the force can do to a velocity, the
# slowest impact allowed, the growth of errors there, 1 less the contraction of the law, which column it is;
A, K, F, W2, PUSH, SLOWEST_ALLOWED, WORSE, GAP, COLUMN = (i * WIDTH for i in range(23, 32))
# where to look from, time of the impact, velocity before and after, the inverse of that before, slope of the law,
# acceleration, 1 where proven,
SINCE, WHEN, BEFORE, AFTER, INVERSE, STEEP, PULL, PROVEN = (i * WIDTH for i in range(32, 40))
# after the impact: pair, margin (not finite where the ball does not fly), the speed of the impact; the list of those
# that do not fly free to the end of the period, and the margins of those that may pass the wall without an impact;
Z1, Z2, WIDER, SPEED, REST, CLEARANCE = (i * WIDTH for i in range(40, 46))
# derivatives 0 to 13 of the flight at the middle of the cell;
Y0, Y1, Y2, Y3, Y4, Y5, Y6, Y7, Y8, Y9, Y10, Y11, Y12, Y13 = (i * WIDTH for i in range(46, 60))
# the cell as it stands in the table: Y, Y', b1, b1', b2, b2' at its middle, where it ends, time left in the window,
# the inverse of the Wronskian, the row of the certificate to go on with; the harmonics.
YM, VM, B1, D1, B2, D2, UNTIL, ROOM, UNMIX, THEN, WAVES = (i * WIDTH for i in range(60, 71))

# Lists of columns: where the runs of equal ones begin among the impacts at hand, which these are, and which columns are
# flown in this period.
RUNS, WHOSE, AWAKE = (i * WIDTH for i in range(3))

NAN = float("nan")
#: Above every row that counts; a margin above this would let rows overflow.
HIGH = 1e280


def workspace_size(harmonics: int) -> int:
    """Return how many numbers the arrays of a block have."""
    return YM + cell_size(harmonics) * WIDTH


def workspace(harmonics: int, columns: int) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Return the arrays of a block, the tables of its columns, and room for lists of them."""
    w, tables = aligned(workspace_size(harmonics)), aligned(columns * table_size(harmonics))
    w[NUMBER : NUMBER + LANES], w[BEFORE : BEFORE + LANES] = np.arange(LANES), -1.0  # no law is asked about nonsense
    return w, tables, np.zeros(3 * WIDTH, np.int64)


def aligned(count: int) -> Floats:
    """Return zeros from an address on that 64 divides: then no vector lies across two lines of the cache."""
    room = np.zeros(count + 8)
    skip = -(room.ctypes.data // 8) % 8
    return room[skip : skip + count]
