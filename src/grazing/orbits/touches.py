"""Touches followed back to the strobes before: every state at rest on the wall, as curves that are smooth to the eye.

To one touch and one choice of the branches of the inverse reset law belongs one state at every strobe before. So the
states are curves with one parameter, the time of the touch, in pieces: a piece ends where an impact crosses a strobe,
where the way back grazes the wall, or where no impact can have come before. Times are halved until neighbours are near
and the ends are where they are; then the exact routine follows every point forwards again.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.backward import BACK, CLIMB, HEIGHT, HIT, Seen, flown_back, impacts_before, periods_later, touches
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.contact import window_sign
from grazing.oscillator.model import Oscillator
from grazing.parameter import parameters

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Impacts in one period beyond which a touch is not followed back: a ball close to chatter.
MAX_IMPACTS = 20
#: A touch that ends a flight shorter than this part of a period is not followed back either.
SHORTEST = 1e-3
#: Contact times looked at, in units of ``points``, at most; each order has its share of them.
PATIENCE = 60
#: Lines, touches times choices of branches, that are followed at once, at most.
MAX_LINES = 1_000_000
#: Distance of neighbouring points on a curve, in half widths of the box, is this over ``points``, at most.
SPACING = 12.0
#: Distances outside the box count less.
OUTSIDE = 0.15
#: States farther away than this many half widths of a box are not told apart.
FAR = 20.0
#: What the map makes of a preimage of order k is, k times, the point on the curve to this relative error.
TOLERANCE = 1e-6
#: The lowest point next to a touch lies at the wall to within this part of the size of the motion.
FLAT = 1e-9


class Leaves:
    """States found: one row for each touch, order and choice of branches.

    ``back`` (n,) is the time T - s of the touch, ``window`` its window, ``order`` that of the preimage, ``code`` what
    the way back was like, ``state`` (n, 2) with the height y = u - sigma, ``ancestor`` (n, 2) the state of order 0,
    ``impacts`` those before the touch in its own period, ``hop`` the time of the flight that ends with the touch.
    """

    FIELDS = ("back", "window", "order", "code", "state", "ancestor", "impacts", "hop")

    def __init__(self, **columns: Any) -> None:
        self.back: Floats = columns["back"]
        self.window: Ints = columns["window"]
        self.order: Ints = columns["order"]
        self.code: NDArray[np.uint64] = columns["code"]
        self.state: Floats = columns["state"]
        self.ancestor: Floats = columns["ancestor"]
        self.impacts: Ints = columns["impacts"]
        self.hop: Floats = columns["hop"]

    def __len__(self) -> int:
        return len(self.back)

    def at(self, rows: Any) -> Leaves:
        """Return some of the rows."""
        return Leaves(**{name: getattr(self, name)[rows] for name in self.FIELDS})

    @staticmethod
    def joined(parts: list[Leaves]) -> Leaves:
        """Return all rows of several."""
        return Leaves(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in Leaves.FIELDS})


def stirred(code: NDArray[np.uint64], step: Any) -> NDArray[np.uint64]:
    """Return a number that stands for a history with one step more (a multiplicative hash)."""
    mixed = (code + np.asarray(step, np.uint64)) * np.uint64(0x9E3779B97F4A7C15)
    return np.asarray(mixed ^ (mixed >> np.uint64(29)), np.uint64)


def traced(model: Oscillator, phase: float, back: Floats, window: Ints, orders: int) -> Leaves:
    """Follow touches at times T - back through ``orders`` periods back, every branch of the inverse law."""
    seen, n = Seen.at(model, phase), len(back)
    leaves = Leaves(
        back=back, window=window, order=np.full(n, -1), code=stirred(np.zeros(n, np.uint64), window.astype(np.uint64)),
        state=np.zeros((n, 2)), ancestor=np.full((n, 2), np.nan), impacts=np.zeros(n, np.int64),
        hop=model.period - back,
    )  # fmt: skip
    found = []
    for _ in range(orders + 1):
        leaves = before(seen, leaves)
        found.append(leaves)
    return Leaves.joined(found)


def before(seen: Seen, leaves: Leaves) -> Leaves:
    """Follow states of one order through the period before their strobe; those of order -1 begin at their touch."""
    period, first = seen.model.period, bool((leaves.order < 0).any())
    lines = np.zeros((len(leaves), 4))
    lines[:, HEIGHT], lines[:, CLIMB] = leaves.state[:, 0], -leaves.state[:, 1]
    if first:
        lines[:, BACK] = leaves.back
    which, code, impacts, hop = np.arange(len(leaves)), leaves.code, leaves.impacts, leaves.hop
    done = []
    for _ in range(MAX_IMPACTS + 1):
        flown_back(seen, lines)
        hit = lines[:, HIT] > 0.0
        done.append((lines[~hit], which[~hit], code[~hit], impacts[~hit], hop[~hit]))
        lines, which, code, impacts, hop = lines[hit], which[hit], code[hit], impacts[hit], hop[hit]
        if first:
            hop = np.where(impacts == 0, lines[:, BACK] - leaves.back[which], hop)
            impacts = impacts + 1
        speeds = impacts_before(seen, -lines[:, CLIMB])
        speeds[hop < SHORTEST * period] = np.nan
        i, branch = np.nonzero(speeds > 0.0)
        lines = lines[i]
        lines[:, CLIMB] = speeds[i, branch]
        which, code, impacts, hop = which[i], stirred(code[i], branch + 1), impacts[i], hop[i]
        if len(lines) == 0 or len(lines) > MAX_LINES:
            break
    lines, which, code, impacts, hop = (np.concatenate(column) for column in zip(*done, strict=True))
    state = np.column_stack([lines[:, HEIGHT], -lines[:, CLIMB]])
    good = np.isfinite(state).all(axis=1)
    state, which = state[good], which[good]
    return Leaves(
        back=leaves.back[which], window=leaves.window[which], order=leaves.order[which] + 1,
        code=stirred(code[good], 1_000_003), state=state, ancestor=state if first else leaves.ancestor[which],
        impacts=impacts[good], hop=hop[good],
    )  # fmt: skip


class Ruler:
    """Distances in boxes: true inside, less outside, none beyond :data:`FAR`."""

    def __init__(self, boxes: list[Floats]) -> None:
        self.middle = [0.5 * (box[:, 0] + box[:, 1]) for box in boxes]
        self.half = [0.5 * (box[:, 1] - box[:, 0]) for box in boxes]

    def sizes(self, state: Floats) -> list[Floats]:
        """Return states (n, 2) in half widths from the middle, column by column and box by box."""
        with np.errstate(over="ignore"):  # beyond all numbers is far, too
            return [
                (state[:, j] - middle[j]) / half[j]
                for middle, half in zip(self.middle, self.half, strict=True)
                for j in (0, 1)
            ]

    def steps(self, state: Floats, passed: Any = False) -> Floats:
        """Return the distance of each state (n, 2) from the one before, the largest coordinate in the last box.

        Of states that are ``passed`` on the way to what is drawn distances in the other boxes count too, a quarter.
        """
        largest = np.zeros(max(len(state) - 1, 0))
        sizes = self.sizes(state)
        for column, size in enumerate(sizes):
            weight = 1.0 if column >= len(sizes) - 2 else np.where(passed, 0.25, 0.0)
            inside = np.clip(size, -1.0, 1.0)
            place = inside + OUTSIDE * np.arcsinh(np.clip(size, -FAR, FAR) - inside)
            np.maximum(largest, weight * np.abs(np.diff(place)), out=largest)
        return largest

    def away(self, state: Floats) -> Floats:
        """Return how many half widths states are away from the middle of the nearest box."""
        columns = [np.abs(size) for size in self.sizes(state)]
        nearest = np.full(len(state), np.inf)
        for u, v in zip(columns[::2], columns[1::2], strict=True):
            np.minimum(nearest, np.maximum(u, v), out=nearest)
        return nearest


def lifting(model: Oscillator, phase: float) -> list[tuple[float, float]]:
    """Return the stretches (low, high) of T - s on which the force lifts a ball off the wall."""
    c = constants_of(model.harmonics, section_phase)(parameters({**model.params, "phase": phase}))
    found = []
    for i in range(len(c.edges) - 1):
        if window_sign(i, c) > 0.0 and c.edges[i] < c.edges[i + 1]:
            found.append((c.T - c.edges[i + 1], c.T - c.edges[i]))
        if c.edges[i + 1] >= c.T:
            break
    return found


def first_touches(model: Oscillator, phase: float, points: int) -> tuple[Floats, Ints]:
    """Return times T - s, increasing, and the windows they lie in: evenly, and closer and closer to the ends."""
    times, windows = [], []
    for number, (low, high) in enumerate(lifting(model, phase)):
        count = max(16, round(points * (high - low) / model.period))
        near = 0.5 * 4.0 ** -np.arange(1.0, 9.0)
        share = np.unique(np.concatenate([(np.arange(count) + 0.5) / count, near, 1.0 - near]))
        inner = low + share * (high - low)
        inner = np.unique(np.concatenate([[low] if low == 0.0 else [], inner[(inner > low) & (inner < high)]]))
        times.append(inner)
        windows.append(np.full(len(inner), number))
    if not times:
        return np.empty(0), np.empty(0, np.int64)
    order = np.argsort(np.concatenate(times), kind="stable")
    return np.concatenate(times)[order], np.concatenate(windows)[order]


def ordered(leaves: Leaves, spots: Floats) -> tuple[Leaves, Ints, NDArray[np.bool_]]:
    """Return leaves along the curves, the place of each among the touches, and whether the next one continues it."""
    place = np.searchsorted(spots, leaves.back)
    rows = np.lexsort((place, leaves.code, leaves.order))
    leaves, place = leaves.at(rows), place[rows]
    same = (leaves.order[1:] == leaves.order[:-1]) & (leaves.code[1:] == leaves.code[:-1])
    return leaves, place, same & (place[1:] == place[:-1] + 1)


def crowded(
    leaves: Leaves, spots: Floats, windows: Ints, ruler: Ruler, spacing: float, orders: int
) -> NDArray[np.bool_]:
    """Return between which neighbouring touches something is not drawn smoothly yet, or begins or ends."""
    wanted = np.zeros(len(spots) + 1, bool)  # wanted[i + 1]: between i and i + 1
    leaves, place, joined = ordered(leaves, spots)
    if len(leaves):
        gap = ruler.steps(leaves.state, leaves.order[1:] < orders)
        wanted[place[:-1][joined & (gap > spacing)] + 1] = True
        away = ruler.away(leaves.state)
        width = np.concatenate([[1.0], np.diff(spots), [1.0]])  # width[i + 1]: between i and i + 1
        with np.errstate(over="ignore"):  # beyond all numbers is far, too
            rate = np.where(joined, gap / width[place[:-1] + 1], np.inf)
        for side, last in ((1, np.append(~joined, True)), (0, np.append(True, ~joined))):
            speed = np.append(np.inf, rate) if side else np.append(rate, np.inf)
            # an end is found when the curve, as fast as it was, moves no more than is seen
            found = (speed * width[place + side] < 0.25 * spacing) & (away < FAR)
            wanted[(place + side)[last & ~found]] = True
        # a dip towards the box between states far from it
        dip = np.zeros(len(leaves), bool)
        dip[1:-1] = (
            joined[1:] & joined[:-1] & (away[1:-1] < 0.75 * np.minimum(away[2:], away[:-2])) & (away[1:-1] > 1.0)
        )
        wanted[place[dip]] = wanted[place[dip] + 1] = True
    between = wanted[1:-1]
    between &= windows[1:] == windows[:-1]
    return np.asarray(between)


def refined(model: Oscillator, phase: float, orders: int, points: int, ruler: Ruler) -> tuple[Leaves, Floats]:
    """Return all states of all orders, from touches so close that curves are smooth and ends are where they are."""
    spots, windows = first_touches(model, phase, points)
    spacing, room = SPACING / points, PATIENCE * points
    leaves, seen = traced(model, phase, spots, windows, 0), Seen.at(model, phase)
    for order in range(orders + 1):
        if order > 0:
            leaves = Leaves.joined([leaves, before(seen, leaves.at(leaves.order == order - 1))])
        while True:
            here = np.flatnonzero(crowded(leaves, spots, windows, ruler, spacing, orders))
            middle = 0.5 * (spots[here] + spots[here + 1])
            inner = (spots[here] < middle) & (middle < spots[here + 1])
            here, middle = here[inner], middle[inner]
            left = room * (order + 1) // (orders + 1) - len(spots)
            if len(here) > left > 0:  # the widest first
                widest = np.sort(np.argsort(spots[here] - spots[here + 1], kind="stable")[:left])
                here, middle = here[widest], middle[widest]
            if len(here) == 0 or left <= 0:
                break
            fresh = traced(model, phase, middle, windows[here], order)
            leaves = Leaves.joined([leaves, fresh])
            windows = np.insert(windows, here + 1, windows[here])
            spots = np.insert(spots, here + 1, middle)
    return leaves, spots


def proven(model: Oscillator, phase: float, leaves: Leaves, size: Floats) -> NDArray[np.bool_]:
    """Return which states the exact routine, forwards, takes to their point on the curve, and that to its touch.

    ``size`` (2,) is the height and the speed of the motion.
    """
    up = np.array([model.sigma, 0.0])
    height, impacts = touches(model, phase, leaves.ancestor + up, model.period - leaves.back, leaves.hop)
    good = (np.abs(height) <= FLAT * size[0]) & (impacts == leaves.impacts)
    later = periods_later(model, phase, leaves.state + up, leaves.order) - up
    error = (np.abs(later - leaves.ancestor) / (size + np.abs(leaves.ancestor))).max(axis=1)
    return np.asarray(good & (error <= TOLERANCE * np.maximum(leaves.order, 1)))


def pieces(leaves: Leaves, spots: Floats, keep: NDArray[np.bool_], ruler: Ruler, spacing: float) -> tuple[Leaves, Ints]:
    """Return the states to be drawn and the number of the piece of each, less those that lie closer than is seen.

    ``keep`` belongs to leaves that are in order already, see :func:`ordered`.
    """
    _same, _place, joined = ordered(leaves, spots)
    gap = ruler.steps(leaves.state)
    goes_on = joined & keep[:-1] & keep[1:] & (gap <= 4.0 * spacing)
    piece = np.concatenate([[0], np.cumsum(~goes_on)])
    run = np.concatenate([[0.0], np.cumsum(np.where(goes_on, gap, 0.0))])
    cell = np.floor(run / (0.5 * spacing))
    ends = np.concatenate([[True], ~goes_on]) | np.concatenate([~goes_on, [True]])
    seen = keep & (ends | (cell != np.concatenate([[-1.0], cell[:-1]])))
    return leaves.at(seen), piece[seen]
