"""The periodic orbit of a ball on a table, with its impacts."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, pi

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.hit import place_of
from grazing.maps.collide import in_three, slopes
from grazing.maps.map import Map
from grazing.orbits.bounces import Bounces
from grazing.orbits.map_equations import product
from grazing.orbits.orbit import ROUNDING, Orbit, condition_of
from grazing.orbits.word import word
from grazing.outcome import ESCAPED, FATAL, InputError

Floats = NDArray[np.float64]
#: How far the ball may come from the next impact, in sizes of the word and beside rounding.
NEAR = 1e-7


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class BounceOrbit(Orbit):
    """A periodic orbit of a ball on a table; ``map`` is its collision map, ``period`` its number of impacts.

    Parameters
    ----------
    surfaces : tuple of int, length n
        What is hit, by its number in the march: a side of a segment, a disc, an end, a side of an arc.
    along : ndarray, shape (n,)
        The coordinate of each impact on its surface: the angle of a circle, the foot on a face. Read-only, as are the
        next two.
    durations : ndarray, shape (n,)
        How long the flight after each impact takes.
    corners : ndarray, shape (n, 2)
        Where the ball's centre is at the impacts.
    energy : float
        Kinetic and potential energy of a ball of mass 1, where impacts conserve it; NaN elsewhere.

    Notes
    -----
    Orbits whose impacts conserve energy come in families along it: one multiplier is 1 and says nothing.
    """

    surfaces: tuple[int, ...]
    along: NDArray[np.float64]
    durations: NDArray[np.float64]
    corners: NDArray[np.float64]
    energy: float = float("nan")

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("along", "durations", "corners"):
            array = np.array(getattr(self, name), np.float64)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @property
    def solves(self) -> str:
        """What makes the equations of its impacts."""
        return "grazing.orbits.bounce_equations:equations_of_bounces"

    @property
    def proven_by(self) -> str:
        """What proves that it exists, in the places of its impacts and the times between them."""
        return "grazing.proof.certify:certify_bounces"

    @property
    def time(self) -> float:
        """How long one turn takes."""
        return float(self.durations.sum())

    @property
    def start(self) -> tuple[float, float, float, float]:
        """Place and velocity (x, y, vx, vy) just after the first impact, for :func:`grazing.trajectory`."""
        (x, y), (x1, y1) = self.corners[0], self.corners[1 % self.period]
        t, g = self.durations[0], self.map.origin.impacts_on.gravity
        return float(x), float(y), float((x1 - x) / t), float((y1 - y) / t + 0.5 * g * t)

    @property
    def conserves(self) -> bool:
        """Whether its impacts conserve energy."""
        return not np.isnan(self.energy)

    @property
    def transverse(self) -> NDArray[np.complex128]:
        """The multipliers without the 1 along a family by energy."""
        if not self.conserves:
            return self.multipliers
        return np.delete(self.multipliers, np.argmin(np.abs(self.multipliers - 1.0)))

    @property
    def degenerate(self) -> bool:
        """Whether a multiplier across a family by energy is 1."""
        return bool((np.abs(self.transverse - 1.0) <= ROUNDING).any())


def corrected_word(word: tuple[int, ...]) -> int:
    """Return which rotation of a sequence comes first."""
    return min(range(len(word)), key=lambda k: word[k:] + word[:k])


def points_of(bounces: Bounces, x: Floats) -> Floats:
    """Return the states (place, angle, speed) of the collision map, (n, 3), of unknowns (2n,)."""
    n, block = bounces.n, bounces.table.blocks(bounces.table.row(), "python")[0]
    p, normal, _m = bounces.frames(x[:n])
    w, _b = bounces.velocities(x)
    points = np.empty((n, 3))
    for i, surface in enumerate(bounces.word):
        (px, py), (nx, ny), (wx, wy) = p[:, i].tolist(), normal[:, i].tolist(), w[:, i].tolist()
        away, along = wx * nx + wy * ny, wy * nx - wx * ny
        points[i] = place_of(surface.number, px, py, block), atan2(along, away), hypot(away, along)
    return points


def inside(bounces: Bounces, x: Floats) -> bool:
    """Whether every impact lies on its surface, and the ball comes to it and leaves it."""
    n = bounces.n
    if not all(surface.holds(u) for u, surface in zip(x[:n].tolist(), bounces.word, strict=True)):
        return False
    _p, normal, _m = bounces.frames(x[:n])
    w, b = bounces.velocities(x)
    leaves, comes = ((normal * v).sum(0) for v in (w, b))
    return bool((leaves > 0.0).all() and (comes < 0.0).all() and (x[n:] > 0.0).all())


def flies(P: Map, bounces: Bounces, points: Floats) -> bool:
    """Whether the collision map itself leads from each impact to the next one."""
    after, size = np.roll(points, -1, axis=0), float(bounces.size.max() + np.abs(bounces.scale).max())
    for state, there, surface in zip(points, after, (*bounces.word[1:], bounces.word[0]), strict=True):
        try:
            found = P.orbit(state, 1)
        except InputError:  # no place of the map
            return False
        if int(found.outcomes[0]) & (FATAL | ESCAPED) or int(found.letters[0]) != surface.owner:
            return False
        off = found.points[1] - there
        if surface.whole:
            turn = 2.0 * pi * surface.size
            off[0] -= turn * round(off[0] / turn)
        if not (abs(off[0]) <= NEAR * size and abs(off[1]) <= NEAR and abs(off[2]) <= NEAR * there[2]):
            return False
    return True


def steps_of(bounces: Bounces, x: Floats) -> Floats:
    """Return the derivatives (n, 3, 3) of all steps in (place, angle, speed); NaN where an impact has no speed.

    They are those of the flights of the word, whatever else is in their way.
    """
    n = bounces.n
    found = np.full((n, 3, 3), np.nan)
    p, normal, _m = bounces.frames(x[:n])
    w, b = bounces.velocities(x)
    bent = bounces.slopes((normal * b).sum(0))
    curved = [surface.sign / surface.size if surface.round else 0.0 for surface in bounces.word]
    still = 0.0, 0.0, 0.0  # no surface turns
    frames = [(*normal[:, i].tolist(), curved[i], *still) for i in range(n)]
    for i, tau in enumerate(x[n:].tolist()):
        k = (i + 1) % n
        nx, ny = frames[k][:2]
        (bx, by), (wx, wy) = b[:, k].tolist(), w[:, k].tolist()
        speeds = bx * nx + by * ny, wx * nx + wy * ny, by * nx - bx * ny, *frames[k]
        if speeds[0] == 0.0 or not hypot(speeds[1], speeds[2]) > 0.0:
            continue
        (ax, ay), (mx, my) = w[:, i].tolist(), frames[i][:2]
        angle, speed = atan2(ay * mx - ax * my, ax * mx + ay * my), hypot(ax, ay)
        before = (*p[:, k].tolist(), bx, by)
        step = slopes(angle, speed, frames[i], tau, before, speeds, bent[k], bounces.g)
        found[i] = np.array(in_three(step)).reshape(3, 3)
    return found


def on_level(bounces: Bounces, x: Floats, speed: float, J: Floats) -> Floats:
    """Return the derivative (2, 2) of one turn in place and angle at a fixed energy, from a point of some speed."""
    _p, normal, _m = bounces.frames(x[: bounces.n])
    held = np.array([[1.0, 0.0], [0.0, 1.0], [-bounces.g * normal[0, 0] / speed, 0.0]])
    return np.asarray(J[:2] @ held)


def roots_of(J: Floats, conserved: bool) -> NDArray[np.complex128]:
    """Return the multipliers of a turn, largest modulus first.

    Where energy is conserved they are L, 1 and 1/L, as the measure cos(angle) ds d(angle) at a fixed energy is, too;
    so the trace has them, and 1/L is known as well as L.
    """
    if not np.isfinite(J).all():
        return np.full(3, np.nan + 0j)
    if not conserved:
        roots = np.linalg.eigvals(J).astype(np.complex128)
    else:
        half = 0.5 * complex(np.trace(J) - 1.0)
        root = np.sqrt(half * half - 1.0)
        large = half + root if (half * root.conjugate()).real >= 0.0 else half - root
        roots = np.array([large, 1.0, 1.0 / large])
    return roots[np.argsort(-np.abs(roots), kind="stable")]


def bounce_orbit(P: Map, bounces: Bounces, x: Floats) -> BounceOrbit:
    """Return the orbit of a solution (2n,): admissible if the collision map itself goes round it."""
    n, points = bounces.n, points_of(bounces, x)
    J = product(steps_of(bounces, x))
    conserved = bounces.energy is not None
    owners = tuple(surface.owner for surface in bounces.word)
    size = max(1.0, float(np.abs(bounces.velocities(x)[0]).max()))
    return BounceOrbit(
        map=P,
        points=points,
        word=word((*owners[1:], owners[0]), P.letters),
        period=n,
        multipliers=roots_of(J, conserved),
        admissible=inside(bounces, x) and flies(P, bounces, points),
        condition=condition_of(on_level(bounces, x, float(points[0, 2]), J) if conserved else J),
        residual=float(np.abs(bounces.defects(x[None])[0]).max()) / size,
        surfaces=tuple(surface.number for surface in bounces.word),
        along=x[:n],
        durations=x[n:],
        corners=bounces.frames(x[:n])[0].T,
        energy=bounces.energy if bounces.energy is not None else float("nan"),
    )
