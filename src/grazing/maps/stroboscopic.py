"""The stroboscopic map: the oscillator seen once per period of its forcing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.table import Table
from grazing.maps.blocks import ensemble_tasks
from grazing.maps.columns import Columns
from grazing.maps.derivative import deriving, plainly, stepping
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER, Map
from grazing.maps.of_oscillator import OfOscillator, above_wall, apart
from grazing.maps.of_system import map_of_system
from grazing.maps.of_table import map_of_table
from grazing.maps.period import period_of, periods_passed
from grazing.maps.settle import Settled
from grazing.maps.starting import strobe_box
from grazing.maps.walled import walled_map
from grazing.oscillator.constants import constants_of, section_phase
from grazing.oscillator.exact import exact_period
from grazing.oscillator.model import checked_model, checked_phase
from grazing.oscillator.pointed import POINTED
from grazing.oscillator.rig import Rig
from grazing.oscillator.walled import Walled
from grazing.outcome import CHATTER, InputError, defined, shown, told
from grazing.parameter import parameters
from grazing.pool import Task
from grazing.systems.contract import System

INFINITY = float("inf")
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def step_of(*law: Callable[..., Any]) -> Callable[..., Any]:
    """Return the step of the stroboscopic map for one reset law: ``law``, ``slope`` and ``contraction``."""
    return stepping(period_of(*law, False))


def derived_of(*law: Callable[..., Any]) -> Callable[..., Any]:
    """Return the tangent of the stroboscopic map with log|det J| behind the Jacobian, for one reset law."""
    return deriving(period_of(*law, True))


def tangent_of(*law: Callable[..., Any]) -> Callable[..., Any]:
    """Return the step of the stroboscopic map with its Jacobian, for one reset law."""
    return plainly(derived_of(*law))


class Strobed(OfOscillator):
    """The origin of a stroboscopic map: the oscillator that it shows once a period."""

    section = "strobe"
    form = staticmethod(strobe_box)
    check = staticmethod(above_wall)

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values, from a model that checks their ranges."""
        own, phase = apart(params)
        return stroboscopic_map(self.model.replace(**own), phase)

    def compiled(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """Return the tangent and what prepares its numbers."""
        return derived_of(*POINTED), constants_of(self.model.harmonics, section_phase)

    def block(
        self, kind: type, rows: Floats, lanes: Floats, transient: int, found: Columns, arithmetic: str, block: bool
    ) -> list[Task]:
        """Return tasks that fly many orbits as blocks, see :func:`grazing.maps.blocks.ensemble_tasks`."""
        model = self.model
        return ensemble_tasks(model.harmonics, model.reset, kind, rows, lanes, transient, found, arithmetic, block)

    def clock(self, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
        """Return the time that orbits took for so many steps, each of a period."""
        return periods_passed(list(self.model.params).index("omega"), rows, first, last, letters, steps)

    def settle(self, row: Sequence[float], state: tuple[float, ...]) -> Settled | None:
        """Decide a step in ball arithmetic; None where no precision decides."""
        values = dict(zip(self.model.params, row, strict=False))  # the phase comes last
        proven = exact_period(self.model.replace(**values), (state[0], state[1]), row[-1])
        if proven is None:
            return None
        letter = CHATTER_LETTER if proven.outcome & CHATTER else (STUCK_LETTER if proven.lay else proven.impacts)
        return Settled(proven.state, letter, proven.outcome, proven.near, proven.slow)

    def explain(self, row: Sequence[float], state: tuple[float, ...]) -> str:
        """Say what the reset law did wrong in the step from a state."""
        names = *self.model.params, "phase"
        params = self.replace(dict(zip(names, row, strict=True))).params
        said: list[str] = []
        law = self.model.reset

        def watched(v: float, p: Any) -> float:
            try:
                w: float = law.law(v, p)
            except Exception as error:
                said.append(f"the reset law {law.name} raised {told(error, law.law)} for v_minus = {v:g}")
                raise
            if not 0.0 <= w < INFINITY:
                said.append(
                    f"the reset law {law.name} returned {w:g} for v_minus = {v:g}; allowed is a finite v_plus >= 0"
                    f"{defined(law.law)}"
                )
            return w

        period = period_of(watched, law.slope, law.contraction, False)
        with suppress(Exception):  # the law's own error has been noted, any other is one of plain Python alone
            period(state, constants_of(self.model.harmonics, section_phase)(parameters(params)))
        return said[0] if said else f"the reset law {law.name} returned what it must not{defined(law.law)}"


def stroboscopic_map(model: Rig | System | Table, phase: float = 0.0, period: float | None = None) -> Map:
    """Return the oscillator as a map: its state once per period of the forcing.

    Parameters
    ----------
    model : Oscillator, System or Table
        Any model, such as :func:`grazing.pinball`; a system of your own that has a period; or a table whose flippers
        are worked periodically, by :func:`grazing.flips`, or not at all.
    phase : float
        Time of the section, from t = 0; any finite number, taken modulo the period.
    period : float, optional
        Of a table on which nothing moves but the ball, the time from one strobe to the next, > 0: a parameter of the
        map. None for a twentieth of the time in which a ball as fast as a fall over the table crosses it. Others have
        a period of their own.

    Returns
    -------
    Map
        State (u, v) at times phase + nT, after an impact there if there is one. Letters count the impacts in
        (nT, (n+1)T]; C is completed chatter, S a ball at rest throughout. Of several walls or surfaces they name
        those that are hit, in order. The state of a system of your own are its coordinates. That of a table is the
        ball, (x, y, vx, vy), the letters are the objects that it hits, ``(left-bumper)``; a ball that has left stays
        at a place far beside the table, one for each way out, with outcome *escaped*.

    Raises
    ------
    InputError
        For anything else, a table whose flippers are worked by a recording or a strategy, a period of what has its own,
        or a phase so late that a double has none.

    Examples
    --------
    >>> import grazing as gz
    >>> P = gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4))
    >>> orbit = P.orbit((0.1, 0.0), 60)
    >>> orbit.letters[-6:].tolist()
    [1, 0, 0, 1, 0, 0]
    """
    if isinstance(model, Table):
        return map_of_table(model, phase, period)
    if period is not None:
        raise InputError(f"period is {shown(period)}; that of an oscillator or a system is its own: leave it out")
    if isinstance(model, System):
        return map_of_system(model, phase)
    if isinstance(model, Walled):
        return walled_map(model, checked_phase(model, phase))
    model = checked_model(model)
    law = model.reset

    return Map(
        step_of(law.law, law.slope, law.contraction),
        params={**model.params, "phase": checked_phase(model, phase)},
        coordinates=("u", "v"),
        box=strobe_box(model.reach, model.paper),
        prepare=constants_of(model.harmonics, section_phase),
        tangent=tangent_of(law.law, law.slope, law.contraction),
        name="stroboscopic map",
        origin=Strobed(model),
    )
