"""The orbit: what a map repeats, with its word, its multipliers and how far to trust it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grazing.copies import ByValue
from grazing.maps.map import Map
from grazing.outcome import abridged

#: Multipliers nearer to the unit circle are on it.
ROUNDING = 1e-12


@dataclass(frozen=True, eq=False, kw_only=True)
class Orbit(ByValue):
    """A periodic orbit of a map.

    Parameters
    ----------
    map : Map
        The map that repeats it.
    points : ndarray, shape (period, dim)
        Row j + 1 is the image of row j, row 0 that of the last. Read-only.
    word : str
        The primitive cyclic word of the letters, in its least rotation; it names the class of the orbit.
    period : int
        Number of steps after which the map comes back, at least 1; a multiple of the length of the word.
    multipliers : ndarray of complex, shape (dim,)
        Eigenvalues of the derivative of ``period`` steps, largest modulus first. Read-only.
    admissible : bool
        Whether the map itself visits the points; False for a virtual orbit, which satisfies the equations of its
        word but breaks a condition that they take for granted, such as no further impact.
    condition : float
        How far ``points[0]`` moves per unit error of ``period`` steps, both in the 2-norm: the spectral norm of
        (I - J)^-1. Infinite at a fold, where two orbits meet; NaN where J is undefined.
    residual : float
        Largest defect of the equations that define the orbit, in their own units.
    doubt : float
        By how much the multipliers may be off beyond rounding, where they rest on differences or on points that are
        known to few digits only, as near a fold. Of orbits made of impacts of an oscillator it is 0: near a graze
        their multipliers have no more digits than the speed of the slowest impact, of which rounding takes most where
        it is 1e-10 of others.

    Examples
    --------
    >>> from grazing.orbits.one_impact import one_impact_orbits
    >>> import grazing as gz
    >>> orbit = one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)[-1]
    >>> orbit.word, orbit.period, orbit.stable, orbit.admissible
    ('001', 3, True, True)
    """

    map: Map
    points: NDArray[np.float64]
    word: str
    period: int
    multipliers: NDArray[np.complex128]
    admissible: bool
    condition: float
    residual: float
    doubt: float = 0.0

    def __post_init__(self) -> None:
        for name in ("points", "multipliers"):
            array = np.array(getattr(self, name))
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @property
    def solves(self) -> str:
        """What makes the equations that it solves, ``module:name``, see :mod:`grazing.orbits.signature`."""
        return self.map.origin.equations

    @property
    def proven_by(self) -> str:
        """What proves that it exists, ``module:function``, see :func:`grazing.certify`."""
        return self.map.origin.prover

    @property
    def stable(self) -> bool:
        """Whether nearby orbits come back to it: every multiplier is surely inside the unit circle."""
        return bool((np.abs(self.multipliers) < 1.0 - max(ROUNDING, self.doubt)).all())

    @property
    def neutral(self) -> bool:
        """Whether the multipliers do not decide: the largest modulus is 1, as far as it is known.

        So it is at a bifurcation, on an orbit of a family, and without dissipation.
        """
        return bool(abs(np.abs(self.multipliers).max(initial=0.0) - 1.0) <= max(ROUNDING, self.doubt))

    @property
    def degenerate(self) -> bool:
        """Whether a multiplier is 1, to rounding: along a line of orbits, or at a fold."""
        return bool((np.abs(self.multipliers - 1.0) <= ROUNDING).any())

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "neutral" if self.neutral else "unstable"
        said = [kind, "admissible" if self.admissible else "virtual"]
        return f"<{type(self).__name__} {abridged(self.word)}, period {self.period}, {', '.join(said)}>"


def multipliers_of(P: Map, points: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return the multipliers of a cycle through points, shape (period, dim); NaN where a step has no derivative."""
    J = np.eye(P.dimension)
    for point in points:
        J = P.jacobian(point) @ J
    found = np.linalg.eigvals(J) if np.isfinite(J).all() else np.full(P.dimension, np.nan)
    return found.astype(np.complex128)


def doubt_of(J: NDArray[np.float64], error: NDArray[np.float64]) -> float:
    """Return by how much the eigenvalues of J (dim, dim) may be off, given by how much its numbers may.

    The smaller of the bounds of Bauer and Fike (1960) and of Elsner (1985); the second one holds where eigenvectors
    are nearly one.
    """
    if not (np.isfinite(J).all() and np.isfinite(error).all()):
        return float("nan")
    with np.errstate(over="ignore"):  # of squares beyond all doubles
        off, size, n = float(np.linalg.norm(error)), float(np.linalg.norm(J)), len(J)
    if n == 1 or off == 0.0:
        return off
    bound = float((2.0 * size + off) ** (1.0 - 1.0 / n) * off ** (1.0 / n))
    return min(bound, off * float(np.linalg.cond(np.linalg.eig(J)[1])))


def condition_of(J: NDArray[np.float64]) -> float:
    """Return the spectral norm of (I - J)^-1 for the derivative J, shape (dim, dim), of one turn of an orbit."""
    if not np.isfinite(J).all():
        return float("nan")
    least = float(np.linalg.svd(np.eye(len(J)) - J, compute_uv=False)[-1])
    return 1.0 / least if least > 0.0 else float("inf")
