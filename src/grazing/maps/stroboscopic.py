"""The stroboscopic map: the oscillator seen once per period of its forcing."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER, Map
from grazing.oscillator.constants import Constants, constants_of, forcing, section_phase
from grazing.oscillator.contact import FLIES, LIES, MAX_SWINGS, departure_of, next_contact, placed
from grazing.oscillator.flight import modes
from grazing.oscillator.model import Oscillator, checked_model, describe_parameter
from grazing.outcome import (
    AMBIGUOUS,
    BAD_LAW,
    CHATTER,
    DIVERGED,
    GRAZE,
    INSIDE_WALL,
    OK,
    TOO_MANY_IMPACTS,
    TOO_MANY_SWINGS,
    InputError,
)

#: Impacts in one period after which the step gives up by name.
MAX_IMPACTS = 10_000
INFINITY = float("inf")
NAN = float("nan")


def saltation(t: float, v: float, w: float, slope: float, c: Constants) -> tuple[float, float, float, float]:
    """Return the saltation matrix of an impact at t with velocities v < 0 and w; undefined (NaN) at v = 0.

    S = [[w/v, 0], [(a_plus - g' a_minus)/v, g']] with a = F - alpha v; det S = g' w/v.
    """
    if v == 0.0:
        return NAN, NAN, NAN, NAN
    F, _dF = forcing(t, c)
    return w / v, 0.0, ((F - c.alpha * w) - slope * (F - c.alpha * v)) / v, slope


def product(
    a: tuple[float, float, float, float], b: tuple[float, float, float, float]
) -> tuple[float, float, float, float]:
    """Return the product of two 2 x 2 matrices, row by row."""
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )


@lru_cache(maxsize=256)
def period_of(
    law: Callable[..., float], slope: Callable[..., float], contraction: Callable[..., Any], with_tangent: bool
) -> Callable[..., Any]:
    """Return ``period(state, c) -> (state, letter, outcome, J)``: one period (0, T] of the oscillator.

    The letter is the number of impacts, or says that chatter was completed or that the ball lay throughout. An
    impact exactly at the end counts; the state returned is the one after it.
    """
    departure = departure_of(law, slope, contraction)

    def period(state: Any, c: Any) -> Any:
        u, v = state
        J, lost = (1.0, 0.0, 0.0, 1.0), (NAN, NAN, NAN, NAN)
        y = u - c.sigma
        if not y >= 0.0 or not abs(v) < INFINITY:
            return (NAN, NAN), 0, (INSIDE_WALL if y < 0.0 else OK), lost
        if c.T > MAX_SWINGS * c.piece:
            return (NAN, NAN), 0, TOO_MANY_SWINGS, lost
        ball = placed(0.0, y, v, 0)
        impacts, outcome = 0, OK
        contact = y == 0.0 and v <= 0.0
        smooth, chattered, lay = True, False, False
        while True:
            if contact:
                arrived = ball.v
                kind, ball, flags = departure(ball, INFINITY, c)
                outcome |= flags
                if flags & (BAD_LAW | DIVERGED):
                    return (NAN, NAN), impacts, outcome, lost
                chattered = chattered or (flags & CHATTER) != 0
                if arrived < 0.0 or ball.v > 0.0:
                    impacts += 1
                if with_tangent:
                    if kind != FLIES:
                        J = (0.0, 0.0, 0.0, 0.0)
                    elif arrived < 0.0:
                        J = product(saltation(ball.t, arrived, ball.v, slope(arrived, c.p), c), J)
                    else:  # a touch, or a kick from rest: nearby orbits do something else
                        smooth = False
                if kind == LIES:
                    lay = impacts == 0
                    break
                if impacts > MAX_IMPACTS:
                    return (NAN, NAN), impacts, outcome | TOO_MANY_IMPACTS, lost
                if ball.t >= c.T:
                    break
            left = ball.t
            contact, ball, flags = next_contact(ball, c)
            outcome |= flags
            if with_tangent:
                J = product(modes(ball.t - left, c), J)
            if not contact:
                break
        if with_tangent and (not smooth or outcome & (GRAZE | AMBIGUOUS)):
            J = lost
        letter = CHATTER_LETTER if chattered else (STUCK_LETTER if lay else impacts)
        return (ball.y + c.sigma, ball.v), letter, outcome, J

    return period


@lru_cache(maxsize=256)
def step_of(
    law: Callable[..., float], slope: Callable[..., float], contraction: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the step of the stroboscopic map for one reset law."""
    period = period_of(law, slope, contraction, False)

    def step(state: Any, c: Any) -> Any:
        new, letter, outcome, _J = period(state, c)
        return new, letter, outcome

    return step


def above_wall(state: Any, params: Any) -> None:
    """Raise InputError for a ball inside the wall."""
    if state[0] < params["sigma"]:
        raise InputError(
            f"the ball starts inside the wall: u = {state[0]:g}, sigma = {params['sigma']:g}; start with u >= sigma"
        )


def stroboscopic_map(model: Oscillator, phase: float = 0.0) -> Map:
    """Return the oscillator as a map: its state once per period of the forcing.

    Parameters
    ----------
    model : Oscillator
        Any model, such as :func:`grazing.pinball`.
    phase : float
        Time of the section, from t = 0; any finite number, taken modulo the period.

    Returns
    -------
    Map
        State (u, v) at times phase + nT, after an impact there if there is one. Letters count the impacts in
        (nT, (n+1)T]; C is completed chatter, S a ball at rest throughout.

    Examples
    --------
    >>> import grazing as gz
    >>> P = gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4))
    >>> orbit = P.orbit((0.1, 0.0), 60)
    >>> orbit.letters[-6:].tolist()
    [1, 0, 0, 1, 0, 0]
    """
    checked_model(model)
    law = model.reset
    width = max(min(1.0, 4.0 * model.period**2), 1e-6 * abs(model.sigma))  # what the forcing can do in one period

    def again(values: dict[str, Any]) -> Map:
        return stroboscopic_map(model.replace(**{n: x for n, x in values.items() if n != "phase"}), values["phase"])

    return Map(
        step_of(law.law, law.slope, law.contraction),
        params={**model.params, "phase": describe_parameter("phase").check(phase)},
        coordinates=("u", "v"),
        box=((model.sigma + 1e-3 * width, model.sigma + 0.1 * width), (-0.3 * width, 0.3 * width)),
        prepare=constants_of(model.harmonics, section_phase),
        tangent=period_of(law.law, law.slope, law.contraction, True),
        name="stroboscopic map",
        check=above_wall,
        exact=law.exact_slope,
        source=again,
    )
