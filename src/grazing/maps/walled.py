"""The stroboscopic map of an oscillator between walls, or at one that moves or is above it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.blocks import block_tasks
from grazing.maps.columns import Columns
from grazing.maps.derivative import Derived, deriving, stepping
from grazing.maps.ensemble import Setting
from grazing.maps.hits import CHATTER, LAY, MANY, MOST, Hits
from grazing.maps.map import Map
from grazing.maps.of_oscillator import OfWalls, apart
from grazing.maps.period import MAX_IMPACTS, periods_passed, walled_period
from grazing.maps.settle import Settled, said_in_flight
from grazing.oscillator.between import impacts_between_of
from grazing.oscillator.constants import refuse_to_compile
from grazing.oscillator.exact import exact_period
from grazing.oscillator.facing import fill_frames
from grazing.oscillator.frames import (
    Frames,
    frames_kind,
    frames_of,
    frames_rows,
    plain_frames,
    walls_at_strobe,
)  # fmt: skip
from grazing.oscillator.impacts import impacts_of
from grazing.oscillator.legs import flown_legs
from grazing.oscillator.pointed import POINTED, law_kind, strike_address
from grazing.oscillator.walled import Walled
from grazing.outcome import CHATTER as CHATTERED
from grazing.pool import Task

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def no_table(t: Any, s: Any, x: Any, c: Frames, blocks: int) -> bool:
    """Fill no table: all is left to the scalar routine."""
    return False


def no_impacts(
    w: Any, tables: Any, runs: Any, awake: int, columns: int, stride: int, strikes: Any, counted: bool
) -> int:  # fmt: skip
    """Take no orbit through its impacts."""
    return 0


@lru_cache(maxsize=64)
def between_walls(harmonics: int, walls: int) -> Setting:
    """Return the setting of an oscillator with one wall of any kind, or between two; of none for the scalar routine.

    That alone is compiled sooner, and is all that single orbits need.
    """
    fill, impacts = no_table, no_impacts
    if walls > 0:
        fill, impacts = fill_frames, impacts_between_of(harmonics) if walls > 1 else impacts_of(harmonics)
    period = walled_period(POINTED, POINTED, False)
    return Setting(max(walls, 1), frames_kind(harmonics), frames_of(harmonics), period, fill, impacts)


def box_of(model: Walled, row: list[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return where starts are drawn: between the walls, or as far from the only one as orbits go by an estimate."""
    (low, slow), (high, fast) = walls_at_strobe(model, np.array(row))
    reach, two = model.reach_at(row[:-1]), len(model.walls) > 1
    speed = max(min(one.speed, one.after) if two else one.speed for one in reach)
    if not two:
        low, high = sorted((low, low + model.walls[0].sign * reach[0].height))
    edge = 1e-3 * (high - low)
    return (low + edge, high - edge), (min(slow, fast) - speed, max(slow, fast) + speed)


class Strobed(OfWalls):
    """The origin of the stroboscopic map of an oscillator with two walls, or one that moves or is above it."""

    section = "strobe"
    box_of = staticmethod(box_of)

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values, from a model that checks their ranges."""
        own, phase = apart(params)
        return walled_map(self.rig.replace(**own), phase)

    def derivative(self, rows: Floats, arithmetic: str = "strict") -> Derived:
        """Return the derivative of the step with the laws by address: compiled once for all."""
        return self._derived(deriving(walled_period(POINTED, POINTED, True)), rows, arithmetic)

    def block(
        self, kind: type, rows: Floats, lanes: Floats, transient: int, found: Columns, arithmetic: str, block: bool
    ) -> list[Task]:
        """Return tasks as :func:`grazing.maps.blocks.ensemble_tasks` does."""
        model = self.rig
        numbers, source = frames_rows(model, np.ascontiguousarray(rows), arithmetic)
        laws = [one.law for one in model.walls]
        strikes = [strike_address(law.law, law.name, law_kind(law), arithmetic) for law in laws]
        setting = between_walls(model.harmonics, len(model.walls) if block else 0)
        who = " or ".join(f"the reset law {law.name}" for law in laws)
        ends = strikes[0], strikes[-1]
        return block_tasks(
            setting, model.harmonics, numbers, source, ends, lanes, transient, found, arithmetic, block, who
        )  # fmt: skip

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a ball inside a wall."""
        self.rig.refuse_inside(float(state[0]), params["phase"])

    def settle(self, row: Sequence[float], state: tuple[float, ...]) -> Settled | None:
        """Decide a step in ball arithmetic; None where no precision decides."""
        own, phase = apart(dict(zip([*self.rig.params, "phase"], row, strict=True)))
        proven = exact_period(self.rig.replace(**own), (state[0], state[1]), phase)
        if proven is None:
            return None
        letter = proven.impacts
        if len(self.rig.walls) > 1:
            letter = 0
            for wall in proven.walls:
                letter = 3 * letter + wall + 1
            letter = letter if proven.impacts <= MOST else MANY
        if proven.outcome & CHATTERED:
            letter = CHATTER - 2 * proven.rest
        elif proven.lay:
            letter = LAY - 2 * proven.rest
        return Settled(proven.state, letter, proven.outcome, proven.near, proven.slow)

    def explain(self, row: Sequence[float], state: tuple[float, ...]) -> str:
        """Say what a reset law did wrong in the step from a state."""
        own, phase = apart(dict(zip([*self.rig.params, "phase"], row, strict=True)))
        model = self.rig.replace(**own)
        fly = partial(flown_legs, model, (state[0], state[1]), phase, phase + model.period, MAX_IMPACTS)
        return said_in_flight(fly, "a reset law")

    def clock(self, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
        """Return the time that orbits took for so many steps, each of a period."""
        return periods_passed(list(self.rig.params).index("omega"), rows, first, last, letters, steps)


def walled_map(model: Walled, phase: float) -> Map:
    """Return the stroboscopic map of an oscillator between walls; :func:`grazing.stroboscopic_map` calls this."""
    refuse_to_compile(model.harmonics)
    laws = [(wall.law.law, wall.law.slope, wall.law.contraction) for wall in model.walls]
    params = {**model.params, "phase": phase}
    return Map(
        stepping(walled_period(laws[0], laws[-1], False)),
        params=params,
        coordinates=("u", "v"),
        box=box_of(model, list(params.values())),
        letters=Hits(model.names) if len(model.walls) > 1 else None,
        prepare=partial(_plain, model),
        tangent=deriving(walled_period(laws[0], laws[-1], True)),
        name="stroboscopic map",
        origin=Strobed(model),
    )


def _plain(model: Walled, p: Any) -> Frames:
    return plain_frames(model, np.array(p, np.float64))
