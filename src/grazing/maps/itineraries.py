"""Itineraries of launches: which surfaces a ball meets up to some impact, and how fast it comes to them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.flown import (
    BEFORE,
    COLUMNS,
    FIRST,
    FLAGS,
    NEXT,
    OWNER,
    PATH,
    SURFACE,
    TIME,
    recorder,
)
from grazing.billiard.rows import CIRCLES, FACES, HEAD, PX, PY, SIDES, THING, THINGS, WIDTH
from grazing.billiard.table import Table
from grazing.kernel.compile import call
from grazing.maps.launch import heading
from grazing.outcome import AMBIGUOUS, ESCAPED, FATAL

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
INFINITY = float("inf")
#: Launches that are looked at together, and flights and slides without an impact that are expected on the way.
TOGETHER, IDLE = 1024, 3
#: Flights and slides after which a ball that does not come to its last impact is followed no further.
LONGEST = 4096


class Flown(NamedTuple):
    """What launches do up to some impact: arrays of shape (launches, flights), a number and -1 beyond the end."""

    #: How each flight or slide ends, one number for all that does not change along with the launch.
    codes: Integers
    #: The object that is hit, -1 for none; and the velocity along the normal just before, NaN without an impact.
    owners: Integers
    before: Floats


class Itineraries:
    """The itineraries of launches from a point of a table, each a number from 0 on."""

    def __init__(self, table: Table, x: float, y: float, impacts: int) -> None:
        self.table, self.x, self.y, self.impacts = table, x, y, impacts
        self.block: Floats = table.blocks(table.row())[0]
        self.record = recorder()
        self.numbers: dict[bytes, int] = {}
        #: Of each itinerary: codes and objects of its flights, as in :class:`Flown`.
        self.codes: list[Integers] = []
        self.owners: list[Integers] = []
        self.circles = _circles(self.block)

    def of(self, angles: Floats, speeds: Floats) -> Integers:
        """Return the numbers of the itineraries of launches."""
        found = np.empty(len(angles), np.int64)
        for first in range(0, len(angles), TOGETHER):
            flown = self.fly(angles[first : first + TOGETHER], speeds[first : first + TOGETHER])
            for i, (codes, owners) in enumerate(zip(flown.codes, flown.owners, strict=True)):
                codes = codes[codes >= 0]
                number = self.numbers.setdefault(codes.tobytes(), len(self.codes))
                if number == len(self.codes):
                    self.codes.append(codes)
                    self.owners.append(owners[: len(codes)].copy())
                found[first + i] = number
        return found

    def fly(self, angles: Floats, speeds: Floats) -> Flown:
        """Return what launches do up to their last impact, in arrays."""
        rows = self.impacts + IDLE
        flights = np.full((len(angles), rows, COLUMNS), np.nan)
        longer: dict[int, Floats] = {}
        for i, (angle, speed) in enumerate(zip(angles.tolist(), speeds.tolist(), strict=True)):
            s, c = heading(angle)
            found = self._followed((self.x, self.y, speed * c, speed * s), flights[i])
            if found is not flights[i]:
                longer[i] = found
        most = max(map(len, longer.values()), default=0)
        if most > rows:
            flights = np.concatenate([flights, np.full((len(angles), most - rows, COLUMNS), np.nan)], axis=1)
        for i, found in longer.items():
            flights[i, : len(found)] = found
        return self._told(flights)

    def _followed(self, state: tuple[float, ...], room: Floats) -> Floats:
        """Return the flights of a launch, in the room for them if that suffices.

        What doubles cannot tell apart, so near to a graze, goes either way: the bracket says how near.
        """
        now, known, impacts = np.array([0.0, -1.0, *state]), 0, 0
        while True:
            count = call(self.record, self.block, now, room[known:], INFINITY)
            new, known = room[known : known + abs(count)], known + abs(count)
            room[known:] = np.nan
            impacts += int((~np.isnan(new[:, BEFORE])).sum())
            last = new[-1]
            doubt = count < 0 and bool(int(last[FLAGS]) & AMBIGUOUS) and last[PATH] < 0.0
            if doubt:
                now[:] = now[0] + last[TIME], last[SURFACE], *last[NEXT:PATH]
            ends = count < 0 and (not doubt or bool(int(last[FLAGS]) & (ESCAPED | FATAL)))
            if ends or impacts >= self.impacts or known >= LONGEST:
                return room
            if known == len(room):
                room = np.concatenate([room, np.full((len(room), COLUMNS), np.nan)])

    def _told(self, flights: Floats) -> Flown:
        """Return what is told of flights, up to the last impact."""
        there = ~np.isnan(flights[:, :, FLAGS])
        hit = ~np.isnan(flights[:, :, BEFORE]) & there
        there &= np.cumsum(hit, axis=1) - hit < self.impacts
        flights = np.where(there[:, :, None], flights, -1.0)
        flags = flights[:, :, FLAGS].astype(np.int64) & (ESCAPED | FATAL)
        code = (4.0 * (flights[:, :, SURFACE] + 1.0)).astype(np.int64) * 4 + self._turns(flights)
        code = ((code * 2 + (flights[:, :, PATH] >= 0.0)) * 4096 + flags) * 4096 + flights[:, :, OWNER].astype(np.int64)
        return Flown(
            np.where(there, code + 1, -1),
            np.where(there, flights[:, :, OWNER], -1.0).astype(np.int64),
            np.where(there & hit, flights[:, :, BEFORE], np.nan),
        )

    def _turns(self, flights: Floats) -> Integers:
        """Return how often a flight comes nearer to the centre of the circle that it hits, or goes away, and turns.

        A ball that grazes a circle may come down on the same circle: the surface alone does not tell.
        """
        surface = flights[:, :, SURFACE].astype(np.int64)
        first = 2 * int(self.block[FACES])
        round_ = (surface >= first) & (surface < first + len(self.circles)) & (flights[:, :, PATH] < 0.0)
        turns = np.zeros(surface.shape, np.int64)
        flown = flights[round_]
        if len(flown):
            x, y = (flown[:, FIRST : FIRST + 2] - self.circles[surface[round_] - first]).T
            u, v, t, g = flown[:, FIRST + 2], flown[:, FIRST + 3], flown[:, TIME], self.table.gravity
            zero, one = x * u + y * v, u * u + v * v - g * y
            two, three = np.full_like(v, 1.5) * -g * v, np.full_like(v, 0.5 * g * g)
            turns[round_] = _sign_changes(zero, one, two, three, t)
        return turns


def _circles(block: Floats) -> Floats:
    """Return the centres of circles and sides of arcs, in the order of their surfaces."""
    faces, circles, sides, things = (int(block[k]) for k in (FACES, CIRCLES, SIDES, THINGS))
    first = HEAD + THING * things + WIDTH * faces
    rows = block[first : first + WIDTH * (circles + sides)].reshape(-1, WIDTH)
    return rows[:, [PX, PY]].copy()


def _sign_changes(zero: Floats, one: Floats, two: Floats, three: Floats, end: Floats) -> Integers:
    """Return how often cubics change their signs between 0 and an end: at their turning points they are looked at."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        root = np.sqrt(np.maximum(two * two - 3.0 * three * one, 0.0))
        q = -(two + np.copysign(root, two))
        turning = np.sort(np.nan_to_num([q / (3.0 * three), one / q], posinf=0.0, neginf=0.0), axis=0)
        at = np.clip([np.zeros_like(end), *turning, end], 0.0, end)
        signs = zero + at * (one + at * (two + at * three)) > 0.0
    found: Integers = (signs[1:] != signs[:-1]).sum(axis=0)
    return found
