"""Orbits that come to rest: released by the forcing, they hop, chatter to rest and wait for the next release.

A ball at rest is released at a zero of the forcing where F rises, whatever brought it there. So the orbit is a function
of the parameters alone and superstable; it lasts while the impacts accumulate before the next release (numerics:
``docs/chatter.md``). Where the time of accumulation meets the release, chatter is complete no longer: the onset.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.primitives import called
from grazing.maps.map import Map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.contacts import PIECES, addresses, framer, model_of, on_wall
from grazing.orbits.equations import Ending, Test
from grazing.orbits.flight_equations import FlightEquations
from grazing.orbits.orbit import Orbit
from grazing.orbits.word import word
from grazing.oscillator.constants import forcing
from grazing.oscillator.contact import placed, window_of, window_sign
from grazing.oscillator.frames import first_contact, frame_of
from grazing.oscillator.rig import Rig
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import InputError

Floats = NDArray[np.float64]

#: Speed, in units of that of the forced motion, below which the rest of a chatter is a geometric series.
SLOW = 1e-9
#: Impacts and periods after which a ball counts as never at rest.
IMPACTS, PERIODS = 10_000, 64
#: Rests on the way from a release to the same one again, and how near to it, in periods, a release is the same.
STAGES, ROUNDING = 8, 1e-9
#: Part of a period that accumulation and release may be apart at an onset of chatter.
MET = 1e-3
#: Bracket of an end, in units of the range, where rest has been left.
UNSURE = 1e-9


class Rest(NamedTuple):
    """From a release to the same one again.

    When the impacts last accumulate, the next release, how many impacts were followed, and how long the shortest rest
    is on the way.
    """

    release: float
    accumulation: float
    next: float
    impacts: int
    left: float


@lru_cache(maxsize=64)
def settler(harmonics: int, walled: bool) -> Callable[..., None]:
    """Compile ``settle(row, release, wall, laws, out)``: fly a ball from its release until it rests.

    ``wall`` is 1 for a release from the second wall, else 0. ``laws`` (2, 3): of each wall the address of the law, of
    its slope, of their numbers. ``out`` (5,): time of accumulation, end of the window in which F presses the ball down,
    number of impacts, 1 if it comes to rest, else 0, and on which wall.
    """
    frames = framer(harmonics, walled)

    def settle(row: Any, release: float, wall: float, laws: Any, out: Any) -> None:
        c = frames(row)
        b = wall > 0.5
        ball = placed(release, 0.0, 0.0, window_of(release, 0, frame_of(b, c)))
        out[3], impacts, period = 0.0, 0, 0
        while impacts < IMPACTS and period < PERIODS:
            hit, b, ball, _flags, _near = first_contact(ball, b, c)
            if not hit:
                ball = placed(0.0, ball.y, ball.v, 0)
                period += 1
                continue
            impacts += 1
            here, j = frame_of(b, c), 1 if b else 0
            w = called(laws[j, 0], ball.v, laws[j, 2])
            F, _dF = forcing(ball.t, here)
            i = window_of(ball.t, ball.i, here)
            if F < 0.0 and w <= SLOW * here.size * here.rate:
                ratio = -called(laws[j, 1], 0.0, laws[j, 2])
                end = here.edges[i + 1]
                if end >= here.T and window_sign(0, here) < 0.0:
                    end = here.T + here.edges[1]
                at = ball.t + (2.0 * w / (-F * (1.0 - ratio)) if w > 0.0 else 0.0)
                if window_sign(i, here) < 0.0 and at <= end:
                    out[0], out[1] = period * here.T + at, period * here.T + end
                    out[2], out[3], out[4] = impacts, 1.0, j
                    return
            ball = placed(ball.t, 0.0, w, i)
            if ball.t >= here.T:
                ball = placed(0.0, 0.0, w, 0)
                period += 1

    return compiled(settle)


class RestEquations(FlightEquations):
    """The equations of an orbit that rests: none, for the release decides all; the one unknown is 0.

    They hold as far as the impacts accumulate before that release.
    """

    pieced = True
    looks = 4  # flights to rest are long

    def __init__(self, model: Rig, names: tuple[str, ...], release: int, spans: Any = None) -> None:
        super().__init__(model, names, spans)
        self.release = release
        self.scale = np.ones(1)
        found = self.rest(self.own)
        self.N = 0 if found is None else round((found.next - found.release) / model.period)

    @property
    def size(self) -> float:
        """How far the forcing moves the ball, as the first wall sees it."""
        c = self.frames(self.own).a
        return float(self.model.period**2 * sum(np.hypot(c.cos, c.sin)))

    def begun(self, p: Floats) -> tuple[float, int] | None:
        """Return when and from which wall the ball is released; None where that release is none any more."""
        c = self.frames(p)
        known = [(time, j) for j, one in enumerate((c.a, c.b) if c.two else (c.a,)) for time in releases(one)]
        return known[self.release] if self.release < len(known) else None

    def rest(self, p: Floats) -> Rest | None:
        """Return what happens until the ball is released there again; None where it is not, or never rests."""
        at, first = self.prepared(p[None]), self.begun(p)
        if first is None or not at.room[0] > 0.0:
            return None
        (start, wall), T = first, self.period_at(p)
        laws, out = np.zeros((2, 3)), np.zeros(5)
        for j, (law, slope, place) in enumerate(addresses(self.model, [PIECES * j for j in range(len(at.seen))])):
            laws[j] = law, slope, float(at.seen[j].ctypes.data + place)
        settle, row = settler(self.model.harmonics, self.model.walled), at.rows[0]
        begun, time, impacts, left = start, start, 0, np.inf
        for _ in range(STAGES):
            call(settle, row, begun, float(wall), laws, out, who="the chatter")
            if out[3] == 0.0:
                return None
            impacts, left, wall = impacts + int(out[2]), min(left, float(out[1] - out[0])), int(out[4])
            rested, time = time - begun + float(out[0]), time - begun + float(out[1])
            begun = time - T * np.floor(time / T + ROUNDING)
            if wall == first[1] and abs(begun - start) <= ROUNDING * T:
                return Rest(start, rested, time, impacts, left)
        return None

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return the unknown itself."""
        return x.copy(), np.ones((1, 1))

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return nothing: until it ends nothing happens to an orbit whose multipliers are 0."""
        return ()

    def holds(self, x: Floats, p: Floats, defect: float = np.inf) -> NDArray[np.bool_]:
        """Whether the ball comes to rest before the same release at each of several points."""
        return np.array([not self.broken(*one) for one in zip(x, p, strict=True)])

    def reach(self, x: Floats, p: Floats, dx: Floats, dp: Floats) -> float:
        """Return whether the ball rests at the end of a step: 1 or 0."""
        return 0.0 if self.broken(x, p + dp) else 1.0

    def ending(self, x: Floats, p: Floats, dx: Floats, dp: Floats, gap: float) -> Ending:
        """Say that chatter is complete no longer; it surely is so if there is no rest left before the release."""
        found = self.rest(p)
        surely = found is not None and found.left < MET * self.model.period
        return Ending("ch", -1, 0.0 if surely else UNSURE)

    def broken(self, x: Floats, p: Floats) -> str:
        """Say whether the ball comes to rest no longer, or is released elsewhere."""
        found = self.rest(p)
        if found is None:
            return "the impacts do not accumulate before the release"
        if round((found.next - found.release) / self.period_at(p)) != self.N:
            return "the ball comes to rest in another period"
        return ""

    def orbit(self, x: Floats, p: Floats) -> Orbit:
        """Return the orbit as the stroboscopic map sees it; its multipliers are 0."""
        model = self.model_at(p)
        found, begun = self.rest(p), self.begun(p)
        if found is None or begun is None:
            raise InputError("the ball does not come to rest")
        P = stroboscopic_map(model)
        start = on_wall(model, begun[1], found.release)
        flown = trajectory(model, start, start=found.release, until=model.period)
        first = np.array([float(flown.u.values[-1]), float(flown.v.values[-1])])
        if not model.walled:
            first[0] = max(first[0], model.walls[0].position)
        path = P.orbit(first, max(self.N, 1))
        return Orbit(
            map=P,
            points=path.points[:-1],
            word=word(path.letters.tolist(), P.letters),
            period=max(self.N, 1),
            multipliers=np.zeros(2, np.complex128),
            admissible=True,
            condition=1.0,
            residual=float(np.abs(path.points[-1] - path.points[0]).max()),
        )


def releases(c: Any) -> list[float]:
    """Return the times in [0, T) at which the forcing lifts a ball off the wall."""
    edges = [edge for edge in c.edges if edge < c.T]
    signs = [window_sign(i, c) for i in range(len(edges))]
    inner = [edges[i] for i in range(1, len(edges)) if signs[i - 1] < 0.0 < signs[i]]
    around = [0.0] if signs and signs[-1] < 0.0 < signs[0] else []
    return around + inner


def resting_equations(P: Map, names: tuple[str, ...], points: Floats, spans: Any = None) -> RestEquations:
    """Return the equations of an orbit that rests on the wall, from its points in the stroboscopic map at phase 0.

    Raises
    ------
    InputError
        For an orbit that is not released where it was released before: with several windows in which the forcing
        presses the ball down it can go from one to another. For the phase of the map.
    """
    model = model_of(P)
    assert model is not None
    if "phase" in names:
        raise InputError("the orbit rests on the wall, and is followed at phase 0 only; vary a parameter of the model")
    p = np.array([model.params[name] for name in names])
    for release in range(len(model.walls) * (2 * model.harmonics + 1)):
        equations = RestEquations(model, names, release, spans)
        if equations.rest(p) is None:
            continue
        orbit = equations.orbit(np.zeros(1), p)
        apart = np.abs(orbit.points[:, None] - points[None]).max(axis=2).min(axis=0)
        if apart.max() < 1e-6 * equations.size:
            return equations
    raise InputError(
        "the orbit rests on a wall and is not released where it was released before: it cannot be followed; "
        "scan the parameter with gz.orbit_diagram"
    )
