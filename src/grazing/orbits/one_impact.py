"""Periodic orbits of the oscillator with one impact in N periods, in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.period import product, saltation
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.orbits.closure import FIRED
from grazing.orbits.impact_orbit import ImpactOrbit, delay
from grazing.orbits.orbit import condition_of
from grazing.orbits.survey import (
    CLEARANCE,
    CONTACT,
    DET,
    LAW,
    PHASE,
    TAU,
    TRACE,
    V_MINUS,
    V_PLUS,
    Family,
    families,
    survey,
)
from grazing.orbits.word import word
from grazing.oscillator.constants import constants_of
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.model import Oscillator
from grazing.oscillator.trajectory import refuse_swings
from grazing.outcome import InputError, OutsideForm
from grazing.parameter import whole

#: Periods of the longest orbit: its flight is followed period by period.
MOST = 10**6


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class OneImpactOrbit(ImpactOrbit):
    """A periodic orbit of the oscillator with one impact.

    Parameters
    ----------
    phase : float
        Phase of the forcing at the impact, omega (tau + t0) modulo 2 pi.
    """

    phase: float

    @property
    def tau(self) -> float:
        """Time of the impact, in [0, T)."""
        return float(self.times[0])

    @property
    def v_minus(self) -> float:
        """Velocity just before the impact, < 0."""
        return float(self.incoming[0])

    @property
    def v_plus(self) -> float:
        """Velocity just after the impact, >= 0."""
        return float(self.outgoing[0])


def one_impact_orbits(model: Oscillator, N: int) -> tuple[OneImpactOrbit, ...]:
    """Return all periodic orbits with one impact in N periods of the forcing.

    Parameters
    ----------
    model : Oscillator
        Any damping, stiffness, forcing and wall; the reset law newton, active or triggered.
    N : int
        Periods of the forcing between impacts, 1 to 1,000,000.

    Returns
    -------
    tuple of OneImpactOrbit
        In increasing phase of the impact, at most 2m for m harmonics (and twice that for a trigger); admissible and
        virtual, stable and unstable ones. ``points`` (N, 2) are the states (u, v) at times T, 2T, ..., NT after an
        impact in (0, T], as ``stroboscopic_map(model)`` visits them.

    Raises
    ------
    InputError
        For N that is no whole number >= 1, or a model that is no oscillator.
    OutsideForm
        For a reset law that is not known to be affine, and at a resonance where every velocity closes the flight.

    Notes
    -----
    The phases are the zeros of a trigonometric polynomial (:mod:`grazing.orbits.closure`). None is missed, but a
    pair closer than 1e-7 of a turn, at a fold, counts as none, and so does a touch slower than rounding.
    ``admissible`` is decided by the exact advance, which flies from the impact to the first contact. ``residual`` is
    the larger of the errors in u and v at the end of that flight. Orbits that lie on the wall for a while (r = 0,
    V = 0) are not among them.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.one_impact import one_impact_orbits
    >>> for orbit in one_impact_orbits(gz.pinball(d=0.1, V=0.4), 2):
    ...     print(orbit, f"{orbit.tau:.6f} {orbit.v_minus:.6f} {orbit.clearance:.6f}")
    <OneImpactOrbit 01, period 2, stable, admissible> 2.302504 -0.060902 0.051885
    """
    N = whole(N, "N", 1)
    if N > MOST:
        raise InputError(f"N = {N}; allowed is a whole number from 1 to {MOST}")
    if isinstance(model, Oscillator):
        refuse_swings(model)
    found: list[OneImpactOrbit] = []
    for family in families(model, N):
        c: Any = constants_of(family.harmonics)(family.kind(*family.row.tolist()))
        _E11, E12, _E21, E22 = modes(N * c.T, c)
        if abs(E12) * c.rate + abs(1.0 + c.p.r * E22) < 1e-12:
            raise OutsideForm(
                f"at this resonance (alpha = 0, r = 1, k N T an odd multiple of pi, N = {N}) every velocity closes the "
                "flight, so that orbits come in families or not at all; vary k, omega, alpha or r a little"
            )
        table, counts = survey(family, np.zeros(1), contacts=True)
        rows = table[0, : counts[0]]
        within = (rows[:, LAW] > 0.0) | ((rows[:, LAW] == 0.0) & (family.law == FIRED))
        good = (rows[:, V_MINUS] < -1e-14 * c.size * c.rate) & within
        found += [_orbit(model, family, c, row) for row in rows[good]]
    return tuple(sorted(found, key=lambda orbit: orbit.phase))


def _orbit(model: Oscillator, family: Family, c: Any, row: NDArray[np.float64]) -> OneImpactOrbit:
    """Return the orbit of one row of a survey."""
    N, tau, v, w = family.N, float(row[TAU]), float(row[V_MINUS]), float(row[V_PLUS])
    before = tau if tau > 0.0 else c.T  # an impact at the strobe belongs to the period that ends there
    anchor = anchored(tau, 0.0, w, c)
    points = np.array([flight((j + 1) * c.T - before, anchor, c) for j in range(N)])
    if before == c.T:
        points[0] = 0.0, w
    y, v_end = flight(N * c.T, anchor, c)
    jump = saltation(tau, v, w, -c.p.r, c)
    J = product(modes(c.T - before, c), product(jump, modes(before + (N - 1) * c.T, c)))
    late = abs(row[CONTACT] - N * c.T)
    return OneImpactOrbit(
        map=stroboscopic_map(model),
        points=points + np.array([c.sigma, 0.0]),
        word=word((0,) * (N - 1) + (1,)),
        period=N,
        multipliers=multipliers(float(row[TRACE]), float(row[DET])),
        admissible=bool(late <= delay(np.array(v), c.size, c.T)),
        condition=condition_of(np.array(J).reshape(2, 2)),
        residual=max(abs(y), abs(v_end - v)),
        times=np.array([tau]),
        incoming=np.array([v]),
        outgoing=np.array([w]),
        clearance=float(row[CLEARANCE]),
        phase=float(row[PHASE]),
    )


def multipliers(trace: float, det: float) -> NDArray[np.complex128]:
    """Return the eigenvalues of a 2 x 2 matrix from its trace and determinant, largest modulus first."""
    half = 0.5 * trace
    root = np.sqrt(complex(half * half - det))
    if root.imag != 0.0:
        return np.array([half + root, half - root])
    large = half + root.real if half >= 0.0 else half - root.real
    return np.array([large, det / large if large != 0.0 else 0.0], dtype=np.complex128)
