"""The workspace of a block: arrays one behind the other, named by where they begin.

One array for all of them lets the compiler see that they do not overlap, so that loops over them vectorise.
"""

from __future__ import annotations

from grazing.oscillator.cells import cell_size

#: Orbits of a block, and the room of an array in the workspace: loops may run over by up to 64.
LANES = 512
WIDTH = LANES + 64

# Arrays over the orbits of a block: the pair (c1, c2), the margin, the least row, the narrowest miss, the slowest
# impact, the state where the scalar routine is needed, the number of the orbit.
C1, C2, LIMIT, LEAST, NEAR, SLOW, U, V, NUMBER = (i * WIDTH for i in range(9))
# Arrays over the impacts at hand: pair, margin, which orbit, the place of what comes next, its cell, where the table of
# its column and the cell begin, the cell of the impact before, the column;
X1, X2, DOUBT, ORBIT, EVENT, INSIDE, TABLE, RECORD, BACK, COLUMN = (i * WIDTH for i in range(9, 19))
# constants as they stand in the table: alpha, k^2, F0, omega^2, max|F|, how far a velocity carries, the slowest impact
# allowed, the growth of errors there;
A, K, F, W2, M, FAR, SLOWEST_ALLOWED, WORSE = (i * WIDTH for i in range(19, 27))
# where to look from, time of the impact, velocity before and after, slope of the law, acceleration, 1 where proven,
SINCE, WHEN, BEFORE, AFTER, STEEP, PULL, PROVEN = (i * WIDTH for i in range(27, 34))
# after the impact: pair, margin, 1 where the ball flies, the least row;
Z1, Z2, WIDER, FLIES, LOW = (i * WIDTH for i in range(34, 39))
# the cell as it stands in the table: Y, Y', b1, b1', b2, b2' at its middle, where it ends, time left in the window,
# place to go on from, 1 less the contraction of the law; the harmonics.
YM, VM, B1, D1, B2, D2, UNTIL, ROOM, ONE_ON, GAP, WAVES = (i * WIDTH for i in range(39, 50))

NAN = float("nan")
#: Above every row that counts; a margin above this would let rows overflow.
HIGH = 1e280


def workspace_size(harmonics: int) -> int:
    """Return how many numbers the workspace of a block has."""
    return YM + cell_size(harmonics) * WIDTH
