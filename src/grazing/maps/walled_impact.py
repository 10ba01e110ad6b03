"""The impact map between walls, or at one that moves or is above the ball: from one impact to the next with any."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from math import copysign
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.derivative import Derived, plainly, stepping
from grazing.maps.hits import LATER, Struck
from grazing.maps.map import Map
from grazing.maps.of_oscillator import OfWalls
from grazing.maps.returning import INFINITY, MAX_PERIODS, NAN, NO_DOUBT, derivative, next_period, within_period
from grazing.maps.settle import said_in_flight
from grazing.oscillator.constants import forcing
from grazing.oscillator.contact import MAX_SWINGS, next_contact, placed
from grazing.oscillator.departure import FLIES, LIES, departure_of
from grazing.oscillator.frames import Frames, first_contact, frame_of, plain_frames
from grazing.oscillator.legs import MAX_IMPACTS, flown_legs
from grazing.oscillator.model import refuse_phaseless
from grazing.oscillator.pointed import POINTED
from grazing.oscillator.walled import Walled
from grazing.outcome import AMBIGUOUS, BAD_LAW, DIVERGED, GRAZE, NO_IMPACT, OK, TOO_MANY_SWINGS, InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Law = tuple[Callable[..., float], Callable[..., float], Callable[..., Any]]


def sign_of(b: bool, c: Frames) -> float:
    """Return 1 for a wall below the ball, -1 for one above it."""
    return -1.0 if b else c.side


@lru_cache(maxsize=256)
def return_of(first: Law, second: Law, still: bool = False) -> Callable[..., Any]:
    """Return ``tangent(state, c) -> (state, letter, outcome, J)`` of the impact map for the laws of two walls.

    J is followed by the logarithm of |det J|. The sign of a velocity says which wall was left, that of a zero, too.
    ``still`` is for one wall at rest below the ball, whose frames are :func:`grazing.oscillator.frames.alone`.
    """
    departs, departs_b = departure_of(*first), departure_of(*second)
    slope, slope_b = first[1], second[1]

    def tangent(state: Any, c: Any) -> Any:
        tau, v = state
        lost, T = (NAN, NAN, NAN, NAN, NAN), c.a.T
        b = not still and c.two and copysign(1.0, v) < 0.0
        from_side = sign_of(b, c)
        w = abs(v)
        if not (w < INFINITY and abs(tau) < INFINITY) or (v != 0.0 and from_side * v < 0.0):
            return (NAN, NAN), 0, (OK if v != v or tau != tau else BAD_LAW), lost
        if T > MAX_SWINGS * c.a.piece:
            return (NAN, NAN), 0, TOO_MANY_SWINGS, lost
        start, left = within_period(tau, T), frame_of(b, c)
        ball, doubt = placed(start, 0.0, w, 0), NO_DOUBT
        strobes, outcome = 0, OK
        # from rest the flight is smooth where the force lifts the ball at once
        rests, lying, smooth = w == 0.0, False, w > 0.0 or forcing(start, left)[0] > 0.0
        while strobes <= MAX_PERIODS:
            hit = rests
            if not rests:
                if still:
                    hit, ball, flags, _near = next_contact(ball, c.a)
                else:
                    hit, b, ball, flags, _near = first_contact(ball, b, c)
                outcome |= flags
            if hit:
                arrived, here = ball.v, frame_of(b, c)
                if b:
                    kind, ball, flags = departs_b(ball, c.patience, here)
                else:
                    kind, ball, flags = departs(ball, c.patience, here)
                outcome |= flags
                if flags & (BAD_LAW | DIVERGED):
                    return (NAN, NAN), strobes, outcome, lost
                # a ball at rest that lifts off at once is a release only if it lay: else it is our own start
                if kind != LIES and (not rests or lying or kind != FLIES):
                    t, at = ball.t, strobes
                    if t >= T:
                        t, at = 0.0, strobes + 1
                    side, J = sign_of(b, c), (0.0, 0.0, 0.0, 0.0, -INFINITY) if lying or kind != FLIES else lost
                    if kind == FLIES and smooth and not outcome & (GRAZE | AMBIGUOUS):
                        g, turn = slope_b(arrived, here.p) if b else slope(arrived, here.p), from_side * side
                        J = derivative(start, w, ball.t + strobes * T, arrived, g, turn, left, here)
                        J = J[0], from_side * J[1], side * J[2], turn * J[3], J[4]
                    letter = at + LATER if b else at
                    return (t, copysign(ball.v, side)), letter, outcome, J
                smooth = smooth and kind == FLIES
                lying = lying or kind == LIES
                doubt = NO_DOUBT if kind == LIES else doubt
                rests = False
            if ball.t >= T:
                strobes += 1
                rests = ball.y == 0.0 and ball.v == 0.0
                ball, doubt = next_period(ball, doubt, frame_of(b, c))
        return (NAN, NAN), strobes, outcome | NO_IMPACT, lost

    return tangent


def box_of(model: Walled, row: list[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return where starts are drawn: any phase, and velocities after impacts with each wall."""
    reach = model.reach_at(row)
    after = [wall.sign * min(one.speed, one.after) for wall, one in zip(model.walls, reach, strict=True)]
    return (0.0, reach[0].period), (min(0.0, *after), max(0.0, *after))


class Returned(OfWalls):
    """The origin of an impact map of an oscillator between walls, or at one that moves or is above it."""

    section = "impact"
    sized = True
    box_of = staticmethod(box_of)

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values, from a model that checks their ranges."""
        return walled_impact_map(self.rig.replace(**params))

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step with the laws by address: compiled once for all."""
        return self._derived(return_of(POINTED, POINTED), np.column_stack([rows, np.zeros(len(rows))]), arithmetic)

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a velocity into the only wall, or a time without a phase.

        Of two walls the sign of the velocity says which was hit.
        """
        refuse_phaseless(self.rig, state[0], "tau")
        (wall, *others), v = self.rig.walls, float(state[1])
        if not others and wall.sign * v < 0.0:
            allowed = "v_plus >= 0" if wall.sign > 0.0 else "v_plus <= 0"
            raise InputError(f"v_plus = {v:g} points into the wall; give the velocity after an impact, {allowed}")

    def explain(self, row: Sequence[float], state: tuple[float, ...]) -> str:
        """Say what a reset law did wrong in the step from a state."""
        model, (start, v) = self.rig.replace(**dict(zip(self.rig.params, row, strict=True))), state
        wall = -1 if copysign(1.0, v) < 0.0 else 0
        at, speed = (float(one[wall, 0]) for one in model.places_at(np.array([start])))
        fly = partial(flown_legs, model, (at, speed + v), start, start + MAX_PERIODS * model.period, MAX_IMPACTS)
        return said_in_flight(fly, "a reset law")

    def clock(self, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
        """Return the time from one impact to a later one: the phases, and a period for every strobe between them."""
        omega = rows[:, list(self.rig.params).index("omega"), None]
        return last[:, 0] - first[:, 0] + (letters % LATER) * (2.0 * np.pi / omega)


def walled_impact_map(model: Walled) -> Map:
    """Return the impact map of an oscillator between walls; :func:`grazing.impact_map` calls this."""
    laws = [(wall.law.law, wall.law.slope, wall.law.contraction) for wall in model.walls]
    derived = return_of(laws[0], laws[-1])
    return Map(
        stepping(derived),
        params=model.params,
        coordinates=("tau", "v_plus"),
        box=box_of(model, list(model.params.values())),
        letters=Struck(model.names) if len(model.walls) > 1 else None,
        prepare=partial(_plain, model),
        tangent=plainly(derived),
        name="impact map",
        origin=Returned(model),
    )


def _plain(model: Walled, p: Any) -> Frames:
    return plain_frames(model, np.array([*p, 0.0], np.float64))
