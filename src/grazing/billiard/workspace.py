"""The workspace of balls side by side: rows one behind the other, and a record that names where each of them begins."""

from __future__ import annotations

from typing import NamedTuple

#: Balls side by side.
LANES = 64


class Rows(NamedTuple):
    """Where the rows of a workspace begin, each of LANES numbers."""

    # of the balls: states and the time, the surface just left, which one it is, its impacts
    X: int
    Y: int
    VX: int
    VY: int
    CLOCK: int
    LEFT: int
    NUMBER: int
    HITS: int
    OUTCOME: int
    # what is found: surface, time, how late that may be, object; whether the ball is in doubt
    SURFACE: int
    TIME: int
    LATE: int
    WHO: int
    DOUBT: int
    LAST: int  # the surface just left, -1 for one of a flipper
    # of circles: the least part of k, the earliest safe step, of which pair, how long is looked; errors, k with them
    PART: int
    STEP: int
    FIRST: int
    END: int
    FALL: int
    BEND: int
    SPARE: int
    ONE: int
    # of pairs of a ball and a circle: which they are, as it is seen from the centre
    BALL: int
    DX: int
    DY: int
    PVX: int
    PVY: int
    PSIZE: int
    PTIME: int
    PEND: int
    PEX: int
    PEY: int
    PWHO: int
    # what looks find
    WHAT: int
    PLATE: int
    SAID: int
    H: int
    DH: int
    K: int
    C3: int
    REACH: int
    RATE: int
    S: int
    A: int
    B: int
    GOING: int
    # of each ball and each circle that it may meet: which pair that is; behind all of them, their safe steps
    PAIRS: int


W = Rows(*(LANES * i for i in range(len(Rows._fields))))


class Impacts(NamedTuple):
    """Rows of impacts: over those of pairs, which are done with by then."""

    # of the surface: a point, size, direction; the last number of that is the sign of a side of an arc
    PX: int
    PY: int
    SIZE: int
    EX: int
    EY: int
    # place, velocity before, frame, velocities along the normal and along the surface; the velocity after
    X: int
    Y: int
    BVX: int
    BVY: int
    NX: int
    NY: int
    BEND: int
    SPEED: int
    ALONG: int
    AWAY: int
    VX: int
    VY: int
    PLAIN: int  # whether that is all that happens


I = Impacts(*(W.BALL + LANES * i for i in range(len(Impacts._fields))))


class Faces(NamedTuple):
    """Rows of what is asked of all faces: over those of pairs, which are not used at that time."""

    FACE: int  # the face just left, and on which side: 1 for the right one, -1 for the left one
    SIGN: int
    ERROR: int  # of any gap of a face
    # of a flight up to what was found: where it ends; the face met there; velocities, times the side just left
    X: int
    Y: int
    MET: int
    VX: int
    VY: int
    FALLEN: int
    # how far a parabola leaves its chord, with errors; the errors; a rate that surely is one
    BOW: int
    UNSURE: int
    RATE: int


F = Faces(*(W.BALL + LANES * i for i in range(len(Faces._fields))))


def room_for(circles: int) -> int:
    """Return how many numbers a workspace has."""
    return W.PAIRS + (2 * circles + 1) * LANES
