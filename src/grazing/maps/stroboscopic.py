"""The stroboscopic map: the oscillator seen once per period of its forcing."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.ensemble import ensemble_tasks
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER, Map
from grazing.maps.of_system import map_of_system
from grazing.maps.period import period_of, periods_passed
from grazing.maps.settle import Settled
from grazing.maps.starting import boxes_at, strobe_box
from grazing.maps.walled import walled_map
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.exact import exact_period
from grazing.oscillator.model import Oscillator, checked_model, checked_phase
from grazing.oscillator.pointed import POINTED, pointed_derivative
from grazing.oscillator.walled import Walled
from grazing.outcome import CHATTER, InputError, told
from grazing.parameter import parameter_tuple, parameters
from grazing.systems.contract import System

INFINITY = float("inf")
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@lru_cache(maxsize=256)
def step_of(
    law: Callable[..., float], slope: Callable[..., float], contraction: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the step of the stroboscopic map for one reset law."""
    period = period_of(law, slope, contraction, False)

    def step(state: Any, c: Any) -> Any:
        new, letter, outcome, _J, _near, _slow = period(state, c)
        return new, letter, outcome

    return step


@lru_cache(maxsize=256)
def tangent_of(
    law: Callable[..., float], slope: Callable[..., float], contraction: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the step of the stroboscopic map with its Jacobian, for one reset law."""
    derived = derived_of(law, slope, contraction)

    def tangent(state: Any, c: Any) -> Any:
        new, letter, outcome, J = derived(state, c)
        return new, letter, outcome, (J[0], J[1], J[2], J[3])

    return tangent


@lru_cache(maxsize=256)
def derived_of(
    law: Callable[..., float], slope: Callable[..., float], contraction: Callable[..., Any]
) -> Callable[..., Any]:
    """Return the tangent of the stroboscopic map with log|det J| behind the Jacobian, for one reset law."""
    period = period_of(law, slope, contraction, True)

    def derived(state: Any, c: Any) -> Any:
        new, letter, outcome, J, _near, _slow = period(state, c)
        return new, letter, outcome, J

    return derived


def above_wall(state: Any, params: Any) -> None:
    """Raise InputError for a ball inside the wall."""
    if state[0] < params["sigma"]:
        raise InputError(
            f"the ball starts inside the wall: u = {state[0]:g}, sigma = {params['sigma']:g}; start with u >= sigma"
        )


def stroboscopic_map(model: Oscillator | Walled | System, phase: float = 0.0) -> Map:
    """Return the oscillator as a map: its state once per period of the forcing.

    Parameters
    ----------
    model : Oscillator or System
        Any model, such as :func:`grazing.pinball`; or a system of your own that has a period.
    phase : float
        Time of the section, from t = 0; any finite number, taken modulo the period.

    Returns
    -------
    Map
        State (u, v) at times phase + nT, after an impact there if there is one. Letters count the impacts in
        (nT, (n+1)T]; C is completed chatter, S a ball at rest throughout. Of several walls or surfaces they name
        those that are hit, in order. The state of a system of your own are its coordinates.

    Examples
    --------
    >>> import grazing as gz
    >>> P = gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4))
    >>> orbit = P.orbit((0.1, 0.0), 60)
    >>> orbit.letters[-6:].tolist()
    [1, 0, 0, 1, 0, 0]
    """
    if isinstance(model, System):
        return map_of_system(model, phase)
    if isinstance(model, Walled):
        return walled_map(model, checked_phase(model, phase))
    checked_model(model)
    law = model.reset

    def settle(row: list[float], state: tuple[float, ...]) -> Settled | None:
        values = dict(zip(model.params, row, strict=False))  # the phase comes last
        proven = exact_period(model.replace(**values), (state[0], state[1]), row[-1])
        if proven is None:
            return None
        letter = CHATTER_LETTER if proven.outcome & CHATTER else (STUCK_LETTER if proven.lay else proven.impacts)
        return Settled(proven.state, letter, proven.outcome, proven.near, proven.slow)

    def explain(row: list[float], state: tuple[float, ...]) -> str:
        P = _again(model, dict(zip([*model.params, "phase"], row, strict=True)))
        said = []

        def watched(v: float, p: Any) -> float:
            try:
                w = law.law(v, p)
            except Exception as error:
                said.append(f"the reset law {law.name} raised {told(error)} for v_minus = {v:g}")
                raise
            if not 0.0 <= w < INFINITY:
                said.append(
                    f"the reset law {law.name} returned {w:g} for v_minus = {v:g}; allowed is a finite v_plus >= 0"
                )
            return w

        p = parameters(P.params)
        period = period_of(watched, law.slope, law.contraction, False)
        with suppress(Exception):  # the law's own error has been noted, any other is one of plain Python alone
            period(state, constants_of(model.harmonics, section_phase)(p))
        return said[0] if said else f"the reset law {law.name} returned what it must not"

    return Map(
        step_of(law.law, law.slope, law.contraction),
        params={**model.params, "phase": checked_phase(model, phase)},
        coordinates=("u", "v"),
        box=strobe_box(model.reach, model.paper),
        boxes=partial(boxes_at, model, strobe_box),
        prepare=constants_of(model.harmonics, section_phase),
        tangent=tangent_of(law.law, law.slope, law.contraction),
        block=partial(ensemble_tasks, model.harmonics, law),
        name="stroboscopic map",
        check=above_wall,
        exact=law.exact_slope,
        source=partial(_again, model),
        settle=settle,
        explain=explain,
        pointed=partial(
            pointed_derivative,
            model.harmonics,
            law,
            derived_of(*POINTED),
            constants_of(model.harmonics, section_phase),
            parameter_tuple((*model.params, "phase")),
        ),
        describe=partial(Oscillator.describe, model),
        model=model,
        section="strobe",
        clock=partial(periods_passed, list(model.params).index("omega")),
    )


def _again(model: Oscillator, values: dict[str, Any]) -> Map:
    """Make the map at other values, from a model that checks their ranges."""
    return stroboscopic_map(model.replace(**{n: x for n, x in values.items() if n != "phase"}), values["phase"])
