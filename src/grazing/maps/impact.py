"""The impact map: from just after one impact to just after the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.derivative import plainly, stepping
from grazing.maps.impact_of_system import impact_map_of_system
from grazing.maps.map import Map
from grazing.maps.of_oscillator import OfOscillator
from grazing.maps.returning import MAX_PERIODS
from grazing.maps.settle import said_in_flight
from grazing.maps.starting import impact_box
from grazing.maps.walled_impact import return_of as return_between
from grazing.maps.walled_impact import walled_impact_map
from grazing.oscillator.constants import constants_of
from grazing.oscillator.frames import alone
from grazing.oscillator.legs import MAX_IMPACTS, flown_legs
from grazing.oscillator.model import checked_model, refuse_phaseless
from grazing.oscillator.pointed import POINTED
from grazing.oscillator.rig import Rig
from grazing.oscillator.walled import Walled
from grazing.outcome import InputError
from grazing.systems.contract import System

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@lru_cache(maxsize=256)
def return_of(
    law: Callable[..., float], slope: Callable[..., float], contraction: Callable[..., Any]
) -> Callable[..., Any]:
    """Return ``tangent(state, c) -> (state, letter, outcome, J)`` of the impact map for one reset law.

    J is followed by the logarithm of |det J|.
    """
    between = return_between((law, slope, contraction), (law, slope, contraction), True)

    def tangent(state: Any, c: Any) -> Any:
        return between(state, alone(c))

    return tangent


class Struck(OfOscillator):
    """The origin of an impact map: the oscillator that it shows after each impact."""

    section = "impact"
    phased = False
    form = staticmethod(impact_box)

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values, from a model that checks their ranges."""
        return impact_map(self.model.replace(**params))

    def compiled(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """Return the tangent and what prepares its numbers."""
        return return_of(*POINTED), constants_of(self.model.harmonics)

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a velocity into the wall, or a time without a phase."""
        refuse_phaseless(self.model, state[0], "tau")
        if state[1] < 0.0:
            raise InputError(
                f"v_plus = {state[1]:g} points into the wall; give the velocity after an impact, v_plus >= 0"
            )

    def explain(self, row: Sequence[float], state: tuple[float, ...]) -> str:
        """Say what the reset law did wrong in the step from a state."""
        model = self.model.replace(**dict(zip(self.model.params, row, strict=True)))
        start, v = state
        fly = partial(flown_legs, model, (model.sigma, v), start, start + MAX_PERIODS * model.period, MAX_IMPACTS)
        return said_in_flight(fly, f"the reset law {model.reset.name}")

    def clock(self, rows: Floats, first: Floats, last: Floats, letters: Ints, steps: int) -> Floats:
        """Return the time from one impact to a later one: the phases, and a period for every strobe between them."""
        omega = rows[:, list(self.model.params).index("omega"), None]
        return last[:, 0] - first[:, 0] + letters * (2.0 * np.pi / omega)


def impact_map(model: Rig | System) -> Map:
    """Return an oscillator, or a system of one's own, as a map from one impact to the next.

    Parameters
    ----------
    model : Oscillator or System

    Returns
    -------
    Map
        State (tau, v_plus): the phase in [0, T), measured from t = 0, and the velocity just after an impact. The
        letter counts the strobes t = nT crossed on the way. After completed chatter or sticking the state is the
        release: (time of release, 0). Without an impact in 1000 periods the outcome is *no_impact*. Between walls
        v_plus is relative to the wall, upwards: positive after an impact with the one below the ball, negative after
        one with the one above it (a ball released there has v_plus = -0.0). A letter is then the wall that is hit,
        with the strobes in front of it if there are any: ``A``, ``B``, ``1B``.

        Of a system of your own the state is (tau, ...): the phase, then its coordinates just after an impact. A start
        may lie anywhere outside of its surfaces. A system without a period is taken not to depend on time: there is no
        phase, and letters are the surfaces.

    Examples
    --------
    >>> import grazing as gz
    >>> Q = gz.impact_map(gz.pinball(d=0.12, V=0.4))
    >>> orbit = Q.iterate((0.0, 0.5), 50)
    >>> bool(abs(orbit[-1] - orbit[-2]).max() < 1e-12)
    True
    """
    if isinstance(model, System):
        return impact_map_of_system(model)
    if isinstance(model, Walled):
        return walled_impact_map(model)
    model = checked_model(model)
    derived = return_of(model.reset.law, model.reset.slope, model.reset.contraction)
    return Map(
        stepping(derived),
        params=model.params,
        coordinates=("tau", "v_plus"),
        box=impact_box(model.reach, model.paper),
        prepare=constants_of(model.harmonics),
        tangent=plainly(derived),
        name="impact map",
        origin=Struck(model),
    )
