"""The workspace of a block: rows one behind the other, a record that names where each of them begins.

One array for all of them lets the compiler see that they do not overlap, so that loops over them vectorise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.lanes import aligned
from grazing.oscillator.cells import cell_size, table_size

Floats = NDArray[np.float64]

#: Orbits of a block, and the room of an array in the workspace: loops may run over by up to 64.
LANES = 512
WIDTH = LANES + 72
#: Impacts that are solved together, step by step.
SOME = 48


class Rows(NamedTuple):
    """Where the rows of a workspace begin, each of :data:`WIDTH` numbers."""

    # over the orbits of a block
    C1: int  # the pair (c1, c2)
    C2: int
    NEED: int  # what all rows of the certificate must reach
    FREE: int  # 1 where they do, -1 where not
    NEAR: int  # the narrowest miss
    SLOW: int  # the slowest impact
    U: int  # the state, where the scalar routine is needed
    V: int
    NUMBER: int  # of the orbit
    HITS: int  # how often it hit the wall
    WHERE: int  # where its state is
    WANTED: int  # 1 where the scalar routine is wanted
    OLD1: int  # the pair of a period ago
    OLD2: int
    # over the impacts at hand
    X1: int  # the pair
    X2: int
    DOUBT: int  # its margin
    ORBIT: int  # which orbit
    MET: int  # how many impacts it had in this period
    EVENT: int  # the place of what comes next
    INSIDE: int  # the cell of that
    RECORD: int  # where the cell begins in the tables
    BACK: int  # the cell of the impact before
    PLACE: int  # of an orbit, its place among the impacts at hand
    START: int  # when the ball left a wall
    OFF_Y: int  # how wrong that may be: in position
    OFF_V: int  # and velocity
    BASE: int  # how wrong its height is anyway
    NEXT_Y: int  # the same of the departure after the impact
    NEXT_V: int
    PAST: int  # 1 where the wall that was hit is not hit again in this period, unless the other one is
    # constants of the column, in the order of the table
    A: int  # alpha
    K: int  # k^2
    F: int  # F0
    W2: int  # omega^2
    PUSH: int  # what the force can do to a velocity
    SLOWEST_ALLOWED: int  # of the impacts that are solved here
    WORSE: int  # the growth of errors there
    GAP: int  # 1 less the contraction of the law
    COLUMN: int  # which column it is
    # the impact
    SINCE: int  # where to look from
    WHEN: int  # its time
    BEFORE: int  # the velocity before
    AFTER: int  # and after
    INVERSE: int  # of the velocity before
    STEEP: int  # the slope of the law
    PULL: int  # the acceleration
    PROVEN: int  # 1 where it is
    # after the impact
    Z1: int  # the pair
    Z2: int
    WIDER: int  # the margin, not finite where the ball does not fly
    SPEED: int  # of the impact
    REST: int  # the list of those that do not fly free to the end of the period
    CLEARANCE: int  # the margins of those that may pass the wall without an impact
    # derivatives of the flight at the middle of the cell
    Y0: int
    Y1: int
    Y2: int
    Y3: int
    Y4: int
    Y5: int
    Y6: int
    Y7: int
    Y8: int
    Y9: int
    Y10: int
    Y11: int
    Y12: int
    Y13: int
    # the cell as it stands in the table: at its middle
    YM: int  # Y
    VM: int  # Y'
    B1: int  # b1
    D1: int  # b1'
    B2: int  # b2
    D2: int  # b2'
    UNTIL: int  # where it ends
    ROOM: int  # the time left in the window
    UNMIX: int  # the inverse of the Wronskian
    THEN: int  # the row of the certificate to go on with
    WAVES: int  # the harmonics: two rows each


#: The workspace as kernels name it: number i of row C1 is ``w[W.C1 + i]``.
W = Rows(*(i * WIDTH for i in range(len(Rows._fields))))

# Lists of columns: where the runs of equal ones begin among the impacts at hand, which these are, and which columns are
# flown in this period.
RUNS, WHOSE, AWAKE = (i * WIDTH for i in range(3))

#: Where an orbit's state is: in its pair, after a period in the block; in U and V, too; in U and V alone.
FLOWN, FRESH, HELD = 0.0, 1.0, 2.0

NAN = float("nan")
#: Above every row that counts; a margin above this would let rows overflow.
HIGH = 1e280


def workspace_size(harmonics: int) -> int:
    """Return how many numbers the arrays of a block have."""
    return W.YM + cell_size(harmonics) * WIDTH


def workspace(harmonics: int, columns: int) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Return the arrays of a block, the tables of its columns, and room for lists of them."""
    w, tables = aligned(workspace_size(harmonics)), aligned(columns * table_size(harmonics))
    w[W.NUMBER : W.NUMBER + LANES] = np.arange(LANES)
    w[W.BEFORE : W.BEFORE + LANES] = -1.0  # no law is asked about nonsense
    return w, tables, np.zeros(3 * WIDTH, np.int64)
