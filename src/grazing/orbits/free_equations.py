"""The equations of the orbit without impacts: the steady response, as long as it stays off the wall."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.closure import lowest_dip
from grazing.orbits.equations import Test
from grazing.orbits.flight_equations import FlightEquations
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.one_impact import multipliers
from grazing.orbits.orbit import condition_of
from grazing.orbits.word import word
from grazing.oscillator.constants import constants_of
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.model import Oscillator
from grazing.oscillator.pointed import flight_kind

Floats = NDArray[np.float64]

#: Instants of a period among which the fastest rise is sought: from there every local minimum lies inside the period.
INSTANTS = 16


class FreeEquations(FlightEquations):
    """The state (y, v) at the strobe, y = u - sigma, that one period of free flight repeats."""

    def __init__(self, model: Oscillator, names: tuple[str, ...], spans: Any = None) -> None:
        super().__init__(model, names, spans)
        self.n, self.N = 0, 1
        self._turn = turner(model.harmonics)
        c = self.constants(self.own)
        self.scale = np.array([c.size, c.size * c.rate])

    def turned(self, x: Floats, p: Floats) -> tuple[Floats, Floats, float, float]:
        """Return the state after a period, its derivative, the lowest local minimum and its time in [0, T)."""
        out = np.empty(8)
        call(self._turn, self.row(self.values(p)), np.ascontiguousarray(x, np.float64), out, who="the free flight")
        return out[:2], out[2:6].reshape(2, 2), float(out[6]), float(out[7])

    def start(self, p: Floats) -> Floats:
        """Return the solution, which is unique where the free flight has no multiplier 1; else NaN."""
        end, E, _low, _when = self.turned(np.zeros(2), p)
        try:
            return np.asarray(np.linalg.solve(np.eye(2) - E, end))
        except np.linalg.LinAlgError:  # no stiffness: the ball drifts
            return np.full(2, np.nan)

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return by how much the state after a period differs, and the derivative of that."""
        end, E, _low, _when = self.turned(x, p)
        return end - x, E - np.eye(2)

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd, lp and ns, and the clearance of the wall, in units of the motion's size."""
        _end, E, low, _when = self.turned(x, p)
        trace, det = float(np.trace(E)), self._area(p)
        return (
            Test("pd", 1.0 + trace + det),
            Test("lp", 1.0 - trace + det),
            Test("ns", 1.0 - det),
            Test("gr", low / (float(self.scale[0]) or 1.0), 0),
        )

    def _area(self, p: Floats) -> float:
        """Return exp(-alpha T), by which areas shrink in a period: exactly 1 where nothing damps."""
        c = self.constants(p)
        return float(np.exp(-c.alpha * c.T))

    def broken(self, x: Floats, p: Floats) -> str:
        """Say whether there is no steady response."""
        return "" if np.isfinite(x).all() else "the forcing is in resonance: there is no steady response"

    def orbit(self, x: Floats, p: Floats) -> ImpactOrbit:
        """Return the orbit, admissible if it stays off the wall."""
        end, E, low, _when = self.turned(x, p)
        trace, det = float(np.trace(E)), self._area(p)
        none = np.empty(0)
        model = self.model_at(p)
        return ImpactOrbit(
            map=stroboscopic_map(model),
            points=(x + np.array([model.sigma, 0.0]))[None],
            word=word((0,)),
            period=1,
            multipliers=multipliers(trace, det),
            admissible=low > 0.0,
            condition=condition_of(E),
            residual=float(np.abs(end - x).max()),
            times=none,
            incoming=none,
            outgoing=none,
            clearance=low,
        )


def free_orbit(model: Oscillator | None) -> ImpactOrbit | None:
    """Return the orbit without impacts, admissible or not; None where there is none, or one from every state."""
    if model is None:
        return None
    equations, own = FreeEquations(model, ()), np.empty(0)
    start = equations.start(own)
    return equations.orbit(start, own) if np.isfinite(start).all() else None


@lru_cache(maxsize=64)
def turner(harmonics: int) -> Callable[..., None]:
    """Compile ``turn(row, x, out)``: one period from (y, v); see :meth:`FreeEquations.turned`."""
    unpack, constants = unpacker(flight_kind(harmonics)), constants_of(harmonics)

    def turn(row: Any, x: Any, out: Any) -> None:
        c = constants(unpack(row))
        anchor = anchored(0.0, x[0], x[1], c)
        out[0], out[1] = flight(c.T, anchor, c)
        out[2], out[3], out[4], out[5] = modes(c.T, c)
        begin, fastest, height = 0.0, -float("inf"), x[0]
        for i in range(INSTANTS):
            y, v = flight(i * c.T / INSTANTS, anchor, c)
            if v > fastest:
                begin, fastest, height = i * c.T / INSTANTS, v, y
        low, _dip, _dips, when = lowest_dip(begin, height, fastest, c.T, c)
        out[6] = low
        out[7] = begin + when - (c.T if begin + when >= c.T else 0.0)

    return compiled(turn)
