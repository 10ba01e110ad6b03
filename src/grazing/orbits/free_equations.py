"""The equations of the orbit without impacts: the steady response, as long as it stays off the wall."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.closure import lowest_dip
from grazing.orbits.contacts import framer
from grazing.orbits.equations import Test
from grazing.orbits.flight_equations import FlightEquations
from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.one_impact import multipliers
from grazing.orbits.orbit import condition_of
from grazing.orbits.word import word
from grazing.oscillator.constants import Constants
from grazing.oscillator.contact import placed
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.frames import frame_of, seen_across, seen_at_strobe
from grazing.oscillator.rig import Rig

Floats = NDArray[np.float64]

#: Instants of a period among which the fastest rise is sought: from there every local minimum lies inside the period.
INSTANTS = 16
#: Of the size of the motion, beyond which a steady response has too few digits to be one.
FAR = 1e9


class FreeEquations(FlightEquations):
    """The state (y, v) at the strobe, as the first wall sees it, that one period of free flight repeats."""

    linear = True
    others = "grazing.orbits.grazes:risen"

    def __init__(self, model: Rig, names: tuple[str, ...], spans: Any = None) -> None:
        super().__init__(model, names, spans)
        self.n, self.N = 0, 1
        self._turn = turner(model.harmonics, model.walled)
        self.scale = np.array(self.sizes())

    def turned(self, x: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the state after a period, its derivative, and for each wall the lowest dip and its time in [0, T)."""
        ends, E, dips = self._turned(x[None], p[None])
        return ends[0], E[0], dips[0]

    def _turned(self, x: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
        """Return :meth:`turned` at several points, x (k, 2) and p (k, names)."""
        out, walls = np.empty((len(x), 10)), len(self.model.walls)
        call(self._turn, self.prepared(p).rows, np.ascontiguousarray(x, np.float64), out, who="the free flight")
        return out[:, :2], out[:, 2:6].reshape(-1, 2, 2), out[:, 6:].reshape(-1, 2, 2)[:, :walls]

    def start(self, p: Floats) -> Floats:
        """Return the solution, which is unique where the free flight has no multiplier 1; else NaN."""
        end, E, _dips = self.turned(np.zeros(2), p)
        try:
            found = np.linalg.solve(np.eye(2) - E, end)
        except np.linalg.LinAlgError:  # no stiffness: the ball drifts
            found = np.full(2, np.nan)
        # a multiplier that is 1 but for rounding puts it so far away that none of its digits counts
        return np.asarray(found if (np.abs(found) < FAR * self.scale).all() else np.full(2, np.nan))

    def neutral(self, p: Floats) -> Floats:
        """Return one of the orbits of a ball that no spring holds, in the middle of them; NaN where it drifts away."""
        end, E, _dips = self.turned(np.zeros(2), p)
        x: Floats = np.linalg.lstsq(np.eye(2) - E, end, rcond=1e-12)[0].astype(np.float64)
        if self.frames(p).a.k2 != 0.0 or not (np.abs(x - E @ x - end) <= 1e-12 * self.scale).all():
            return np.full(2, np.nan)
        lows = self.turned(x, p)[2][:, 0]
        up = 0.5 * float(lows[1] - lows[0]) if len(lows) > 1 else float(self.scale[0] - lows[0])
        return np.asarray(x + np.array([up, 0.0]))

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return by how much the state after a period differs, and the derivative of that."""
        F, J = self.evaluated(x[None], p[None])
        return F[0], J[0]

    def evaluated(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return :meth:`defects` at several points."""
        (ends, E, _dips), room = self._turned(x, p), self.prepared(p).room > 0.0
        return np.where(room[:, None], ends - x, np.nan), np.where(room[:, None, None], E - np.eye(2), np.nan)

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd, lp and ns, and the clearance of each wall, in units of the motion's size."""
        _end, E, dips = self.turned(x, p)
        trace, det = float(np.trace(E)), self._area(p)
        return (
            Test("pd", 1.0 + trace + det), Test("lp", 1.0 - trace + det), Test("ns", 1.0 - det),
            *(Test("gr", float(low / self.scale[0]), wall) for wall, (low, _when) in enumerate(dips)),
        )  # fmt: skip

    def touched(self, type: str, where: int) -> tuple[int, int]:
        """Return which flight a test function is about, and at which wall."""
        return (0, where) if type == "gr" else (where, -1)

    def state(self, orbit: ImpactOrbit) -> Floats:
        """Return the unknowns of an orbit without impacts."""
        (u, v), c = orbit.points[0], self.frames(self.own)
        return np.array([c.side * (u - c.za), c.side * (v - c.wa)])

    def _area(self, p: Floats) -> float:
        """Return exp(-alpha T), by which areas shrink in a period: exactly 1 where nothing damps."""
        c = self.constants(p)
        return float(np.exp(-c.alpha * c.T))

    def broken(self, x: Floats, p: Floats) -> str:
        """Say whether there is no steady response."""
        return "" if np.isfinite(x).all() else "the forcing is in resonance: there is no steady response"

    def orbit(self, x: Floats, p: Floats) -> ImpactOrbit:
        """Return the orbit, admissible if it stays off the wall."""
        end, E, dips = self.turned(x, p)
        trace, det, low = float(np.trace(E)), self._area(p), float(dips[:, 0].min())
        none = np.empty(0)
        P = stroboscopic_map(self.model_at(p))
        return ImpactOrbit(
            map=P,
            points=np.array([seen_at_strobe(placed(0.0, float(x[0]), float(x[1]), 0), False, self.frames(p))]),
            word=word((0,), P.letters),
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


def free_orbit(model: Rig | None) -> ImpactOrbit | None:
    """Return the orbit without impacts, admissible or not; None where there is none, or one from every state."""
    if model is None:
        return None
    equations, own = FreeEquations(model, ()), np.empty(0)
    start = equations.start(own)
    return equations.orbit(start, own) if np.isfinite(start).all() else None


@lru_cache(maxsize=64)
def turner(harmonics: int, walled: bool) -> Callable[..., None]:
    """Compile ``turn(rows, x, out)``: one period from each (y, v); see :meth:`FreeEquations.turned`."""
    frames = framer(harmonics, walled)

    def dip(y: float, v: float, c: Constants) -> tuple[float, float]:
        """Return the least height of a periodic flight that is at (y, v) at time 0, and its time in [0, T).

        It is that of a local minimum, or where the ball stays at one height, to rounding, that of an instant.
        """
        anchor, begin, fastest, height = anchored(0.0, y, v, c), 0.0, -float("inf"), y
        least, at = float("inf"), 0.0
        for i in range(INSTANTS):
            y, v = flight(i * c.T / INSTANTS, anchor, c)
            if v > fastest:
                begin, fastest, height = i * c.T / INSTANTS, v, y
            if y < least:
                least, at = y, i * c.T / INSTANTS
        low, _dip, _dips, when, _deepest = lowest_dip(begin, height, fastest, c.T, False, c)
        if least < low:
            return least, at
        return low, begin + when - (c.T if begin + when >= c.T else 0.0)

    def turn(rows: Any, x: Any, out: Any) -> None:
        for i in range(x.shape[0]):
            once(rows[i], x[i], out[i])

    def once(row: Any, x: Any, out: Any) -> None:
        c = frames(row)
        here = c.a
        out[0], out[1] = flight(here.T, anchored(0.0, x[0], x[1], here), here)
        out[2], out[3], out[4], out[5] = modes(here.T, here)
        out[6], out[7] = dip(x[0], x[1], here)
        out[8], out[9] = float("inf"), 0.0
        if c.two:
            y, v = seen_across(0.0, x[0], x[1], c)
            out[8], out[9] = dip(y, v, frame_of(True, c))

    return compiled(turn)
