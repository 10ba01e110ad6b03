"""One forcing period in ball arithmetic: it decides what double precision cannot.

Every number is a ball that contains the true one, and a comparison counts only where it holds for all of the ball. What
a precision does not decide is tried again with twice the bits; an exact tie of a flight, which no number of bits
decides, stays undecided. Between walls each flight is seen from the wall that it left, and the other wall is asked
for what comes before.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from grazing.oscillator.exact_contact import Rule
from grazing.oscillator.exact_flight import Flight, next_impact, rounded
from grazing.oscillator.exact_motion import Motion, windows_of
from grazing.oscillator.frames import walls_at_strobe
from grazing.oscillator.rig import Rig
from grazing.oscillator.sure import Beyond, Undecided, rational, sign
from grazing.outcome import BAD_LAW, CHATTER, OK
from grazing.pool import LOCK

if TYPE_CHECKING:
    from flint import arb, fmpq

#: Bits of the midpoints, tried one after the other.
PRECISIONS = (128, 256, 512, 1024)
#: A state so near to a moving wall, in units of its position, may be that of a ball that lies on it.
NEAR = 4e-15


class Period(NamedTuple):
    """One period: state at its end and what happened in (0, T].

    ``walls`` are the numbers of those hit, in order, ``rest`` that on which the ball lay or came to rest last. ``near``
    is the height of the narrowest miss and ``slow`` the speed of the slowest impact, infinity for none; both are known
    to be above 0 where they are, but small ones only to their order of magnitude.
    """

    state: tuple[float, float]
    walls: tuple[int, ...]
    lay: bool
    outcome: int
    near: float
    slow: float
    rest: int = 0

    @property
    def impacts(self) -> int:
        """The number of impacts."""
        return len(self.walls)


class Frame:
    """What one wall sees, at the working precision: force, windows and contact rule; and where it is itself.

    All numbers of the model are taken as exact. With y = side (u - z), z the place of the wall, the force is
    side (f - z'' - alpha z' - k^2 z).
    """

    def __init__(self, model: Rig, j: int, phase: float) -> None:
        from flint import arb

        seen = model.seen[j]
        self.side, self.sigma = int(model.walls[j].sign), model.walls[j].position
        force, moved = _pairs(model.forcing.cos, model.forcing.sin), []
        if model.walls[j].motion is not None:
            wave = model.waves(j, np.array([list(model.params.values())]))[0].tolist()
            moved = _pairs(wave[::2], wave[1::2])
        omega, alpha = rational(model.forcing.omega), rational(model.alpha)
        k2 = rational(model.k) ** 2 if model.stiffness is None else rational(model.stiffness)
        nothing = rational(0.0)
        waves = []
        for i in range(max(len(force), len(moved))):
            (c, s), (a, b) = ((one[i] if i < len(one) else (nothing, nothing)) for one in (force, moved))
            W = (i + 1) * omega
            lift, drag = W * W - k2, alpha * W
            waves.append((self.side * (c + lift * a - drag * b), self.side * (s + lift * b + drag * a)))
        level = self.side * (rational(model.forcing.offset) - k2 * rational(self.sigma))
        self.motion = Motion(model.alpha, k2, model.forcing, level, waves, phase)
        self.wave = [(i * self.motion.omega, i, arb(a), arb(b)) for i, (a, b) in enumerate(moved, start=1) if a or b]
        self.windows = windows_of(self.motion)
        self.rule = Rule(self.motion, self.windows, seen.reset, {**seen.params, "phase": phase})

    def place(self, t: arb) -> tuple[arb, arb]:
        """Return where the wall is at local time t, and how fast it moves."""
        from flint import arb

        z, w, phase = arb(self.sigma), arb(0), self.motion.omega * t + self.motion.theta
        for W, i, a, b in self.wave:
            sine, cosine = (i * phase).sin_cos()
            z, w = z + a * cosine + b * sine, w + W * (b * cosine - a * sine)
        return z, w

    def seen(self, t: arb, u: arb, v: arb) -> tuple[arb, arb]:
        """Return distance and velocity of a ball at local time t."""
        z, w = self.place(t)
        return self.side * (u - z), self.side * (v - w)

    def shown(self, t: arb, y: arb, v: arb) -> tuple[float, float]:
        """Return the state, in doubles, of a ball at a distance and with a velocity relative to the wall."""
        if not self.wave:
            u = rounded(self.side * y, self.sigma)
            return (max(u, self.sigma) if self.side > 0 else min(u, self.sigma)), rounded(self.side * v, 0.0)
        z, w = self.place(t)
        return rounded(z + self.side * y, 0.0), rounded(w + self.side * v, 0.0)

    def window_at(self, t: arb) -> int:
        """Return the number of the window in which a local time lies."""
        for n, window in enumerate(self.windows):
            if sign(window.end - t) > 0:
                return n
        raise Undecided


def _pairs(cos: Sequence[float], sin: Sequence[float]) -> list[tuple[fmpq, fmpq]]:
    return [(rational(c), rational(s)) for c, s in zip(cos, sin, strict=True)]


def first_of(
    frames: list[Frame], j: int, i: int, t: arb, y: arb, v: arb
) -> tuple[tuple[arb, arb, int] | None, int, float, Flight]:
    """Fly from (y, v) at t, as wall j sees it in its window i, to the first impact with any wall.

    Returns time, velocity and window of it, or None; the wall; the height of the narrowest miss; the flight.
    """
    frame = frames[j]
    flight = Flight(frame.motion, t, y, v)
    found = next_impact(flight, i, frame.windows)
    if len(frames) == 1 or i == len(frame.windows):
        return found, j, flight.near, flight
    other, k = frames[1 - j], 1 - j
    (z, w), (z_other, w_other) = frame.place(t), other.place(t)
    across = Flight(other.motion, t, other.side * (z - z_other) - y, other.side * (w - w_other) - v)
    n = i if frame.motion.k2.is_zero() and not (frame.wave or other.wave) else other.window_at(t)  # the same windows
    earlier = next_impact(across, n, other.windows, None if found is None else found[0])
    if earlier is None:
        return found, j, min(flight.near, across.near), flight
    again = Flight(frame.motion, t, y, v)  # what was found beyond never comes
    if next_impact(again, i, frame.windows, earlier[0]) is not None:
        raise Undecided
    return earlier, k, min(again.near, across.near), across


def started(model: Rig, frames: list[Frame], u: float, v: float) -> tuple[int, arb, arb]:
    """Return the wall that sees a state at the strobe, and distance and velocity as it sees them.

    That is the first one, but for a ball on the second. Where a wall moves its place is no double: a ball so near to it
    may lie on it, which is not decided.
    """
    from flint import arb

    zero = arb(0)
    seen = [frame.seen(zero, arb(u), arb(v)) for frame in frames]
    for frame, (y, _v) in zip(frames, seen, strict=True):
        if frame.wave:
            size = abs(u) + abs(frame.sigma) + sum(abs(float(a)) + abs(float(b)) for _W, _i, a, b in frame.wave)
            if not y > NEAR * size:
                raise Beyond
    j = len(frames) - 1 if seen[-1][0].is_zero() else 0
    return j, *seen[j]


def followed(model: Rig, phase: float, u: float, v: float) -> Period:
    """Return the period at the working precision, or raise Undecided or Beyond."""
    from flint import arb

    frames = [Frame(model, j, phase) for j in range(len(model.walls))]
    j, y, speed = started(model, frames, u, v)
    t, i, T = arb(0), 0, frames[0].motion.T
    patience: arb | float = inf
    if len(frames) > 1:  # a hop that begins no faster rises to less than half the room in a period
        patience = arb(0.4999 * float(model.rooms(np.array([list(model.params.values())]))[0])) / T
    walls: list[int] = []
    outcome, near, slow, rest = OK, inf, inf, 0
    contact = y.is_zero() and speed <= 0
    while True:
        if contact:
            arrived = speed
            t, speed, i, flags = frames[j].rule.leave(t, speed, i, patience)
            outcome |= flags
            if flags & BAD_LAW:
                return Period((nan, nan), tuple(walls), False, outcome, near, slow, rest)
            if arrived < 0 or speed > 0:
                walls.append(j)
                slow = min(slow, float(-arrived))
            rest = j if flags & CHATTER else rest
            if i == len(frames[j].windows):
                lay = not walls  # to the bit where the next step has the wall, which so finds the ball at rest
                place = (frames[j].sigma, 0.0)
                if frames[j].wave:
                    place = walls_at_strobe(model, np.array([*model.params.values(), phase]))[j]
                return Period(place, tuple(walls), lay, outcome, near, slow, j if lay else rest)
        found, j, low, flight = first_of(frames, j, i, t, y, speed)
        near = min(near, low)
        if found is None:
            state = frames[j].shown(T, *flight.at(T - t))
            return Period(state, tuple(walls), False, outcome, near, slow, rest)
        t, speed, i = found
        y, contact = arb(0), True


def exact_period(model: Rig, state: tuple[float, float], phase: float = 0.0) -> Period | None:
    """Advance the oscillator by one period of its forcing, with every decision proved in ball arithmetic.

    Parameters
    ----------
    model : Oscillator
        Over one wall or between several. Its parameters are taken as exact.
    state : tuple of float
        (u, v) at time ``phase``, not inside a wall; taken as exact.
    phase : float
        Time of the section, as in :func:`grazing.stroboscopic_map`.

    Returns
    -------
    Period or None
        What double precision would return if it could decide; the state is the true one, rounded. Never *graze*
        or *ambiguous*. None if 1024 bits do not decide, as in an exact tie; if the work exceeds a fixed budget; if a
        reset law is not arithmetic, comparisons and ``abs`` on its arguments; if the ball lies on a moving wall at the
        beginning, whose place no double is; or if the state is not allowed.

    Examples
    --------
    >>> import grazing as gz
    >>> exact_period(gz.pinball(d=0.12, V=0.4), (0.1, 0.0)).impacts
    1
    """
    from flint import ctx

    u, v = (float(x) for x in state)
    if not (isfinite(u) and isfinite(v)) or _inside(model, u):
        return None
    for bits in PRECISIONS:
        try:
            with LOCK, ctx.workprec(bits):
                return followed(model, phase, u, v)
        except Undecided:
            continue
        except Beyond:
            return None
    return None


def _inside(model: Rig, u: float) -> bool:
    """Say whether a state is inside a wall at rest; those that move are asked in balls."""
    return any(one.motion is None and not one.sign * (u - one.position) >= 0.0 for one in model.walls)
