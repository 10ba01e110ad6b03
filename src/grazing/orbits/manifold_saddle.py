"""The saddle that a manifold is grown from: its eigenvectors, and how far the map is straight along them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.manifold_steps import stepped
from grazing.orbits.orbit import Orbit
from grazing.oscillator.reset import active_law, newton_law, triggered_law
from grazing.outcome import InputError, shown

Floats = NDArray[np.float64]

SIDES = ("unstable", "stable")
#: The short piece is this part of the box long at most, and at least LEAST of it.
SHORT, LEAST = 1e-6, 1e-12
#: The map bends the short piece by no more than this part of its length.
STRAIGHT = 1e-4


class Saddle(NamedTuple):
    """One side of a saddle: an eigenvector at each of its p points, shape (p, 2), and the multiplier of a turn.

    ``box`` (2,) are the sides of the box, in which everything is measured: eigenvectors are one side long. The map
    takes each to the direction of the next; only the last step may turn it round.
    """

    orbit: Orbit
    side: str
    directions: Floats
    multiplier: float
    box: Floats

    @property
    def forwards(self) -> bool:
        """Whether it is grown in forward time."""
        return self.side == "unstable"

    @property
    def stretch(self) -> float:
        """How much a whole turn of growth stretches it, > 1."""
        return abs(self.multiplier) if self.forwards else 1.0 / abs(self.multiplier)

    def reached(self, point: int, sign: int, order: int) -> tuple[int, int]:
        """Return the point and the sign of the branch to which ``order`` steps of growth lead from a branch."""
        to = point + order if self.forwards else point - order
        turned = (to // self.orbit.period) % 2 == 1 and self.multiplier < 0.0
        return to % self.orbit.period, -sign if turned else sign


def short_pieces(saddle: Saddle) -> Floats:
    """Return how far the short piece at each point of the saddle reaches: the map bends it by STRAIGHT of it, at most.

    One step of growth stretches each by the same factor.
    """
    orbit, e = saddle.orbit, saddle.directions
    P, p = orbit.map, orbit.period
    after = (np.arange(p) + 1) % p
    factors = np.array([_factor(saddle, j) for j in range(p)])
    even = abs(saddle.multiplier) ** (1.0 / p)
    share = np.append(1.0, np.cumprod(np.abs(factors[:-1]) / even))
    letters = stepped(P, orbit.points, 1)[1][:, 0]
    size = SHORT
    noise = 64.0 * np.finfo(float).eps * (1.0 + np.abs(orbit.points / saddle.box).max())
    while size >= LEAST:
        far = size * share / share.max()
        # on the unstable side the step is taken that ends on the short piece
        seed = far / even if saddle.forwards else far
        good = True
        for sign in (1.0, -1.0):
            image, own = stepped(P, orbit.points + sign * seed[:, None] * e, 1)
            ahead = orbit.points[after] + sign * (seed * factors)[:, None] * e[after]
            bend = np.abs((image - ahead) / saddle.box).max(axis=1)
            good &= bool((bend <= STRAIGHT * far[after] + noise).all() and (own[:, 0] == letters).all())
        if good:
            return np.asarray(far)
        size *= 0.25
    raise InputError(
        f"the map is not smooth within {LEAST:.1g} sides of the box of {shown(orbit)}, the shortest piece to begin "
        "with: the orbit grazes, or nearly; vary a parameter a little"
    )


def refuse_no_saddle(orbit: Any, side: str) -> None:
    """Raise InputError for what is no saddle of a map of the plane, or has no such manifold."""
    if not isinstance(orbit, Orbit):
        raise InputError(f"orbit is {shown(orbit)}; give a gz.Orbit, such as gz.one_impact_orbits(model, N) returns")
    if not isinstance(side, str) or side not in SIDES:
        raise InputError(f"side is {shown(side)}; allowed are 'unstable' and 'stable'")
    P = orbit.map
    if P.dimension != 2:
        raise InputError(f"{P.name} has {P.dimension} coordinate(s): {', '.join(P.coordinates)}; manifolds need two")
    if not orbit.admissible:
        raise InputError(f"{shown(orbit)}: the map does not visit a virtual orbit, which has no manifolds of the map")
    fast, slow = orbit.multipliers
    said = f"{shown(orbit)} with multipliers {fast:.6g} and {slow:.6g}"
    if not (np.isfinite(orbit.multipliers).all() and abs(fast) > 1.0 > abs(slow)):
        raise InputError(
            f"{said} is no saddle: one multiplier must lie outside the unit circle and one inside; choose another orbit"
        )
    if side == "stable":
        _invertible(orbit)


def saddle_of(orbit: Orbit, side: str, box: Floats) -> Saddle:
    """Return one side of a saddle, measured by the sides of a box."""
    fast, slow = orbit.multipliers
    value = float((fast if side == "unstable" else slow).real)
    return Saddle(orbit, side, _directions(orbit, value, box), value, box)


def _invertible(orbit: Orbit) -> None:
    """Refuse a saddle from which no way leads back."""
    P = orbit.map
    law = P.model.reset if P.model is not None else None
    if law is not None and law.law in (newton_law, active_law, triggered_law) and law.params["r"] == 0.0:
        raise InputError(
            "r = 0: a dead wall forgets the speed of impact, so that the map has no inverse and the stable manifold is "
            "no curve; the unstable one is"
        )
    if not abs(orbit.multipliers[1]) > 0.0:
        raise InputError(
            f"{shown(orbit)} has a multiplier 0: the map has no inverse next to it; only the unstable "
            f"manifold is a curve"
        )


def _directions(orbit: Orbit, value: float, box: Floats) -> Floats:
    """Return the eigenvectors (p, 2) at all points, turned so that only the last step may turn the sign."""
    p = orbit.period
    steps = [orbit.map.jacobian(point) * box / box[:, None] for point in orbit.points]
    found = np.empty((p, 2))
    for j in range(p):
        J = np.eye(2)
        for k in range(p):
            J = steps[(j + k) % p] @ J
        rows = J - value * np.eye(2)
        row = rows[int(np.argmax(np.hypot(*rows.T)))]
        size = float(np.hypot(*row))
        if not size > 0.0:
            raise InputError(
                f"the derivative of {orbit.map.name} along {shown(orbit)} is not defined, or has no direction"
            )
        found[j] = np.array([-row[1], row[0]]) / size
        if j > 0 and float(found[j] @ (steps[j - 1] @ found[j - 1])) < 0.0:
            found[j] *= -1.0
    return found * box


def _factor(saddle: Saddle, j: int) -> float:
    """Return what one step of the map, in forward time, makes of the eigenvector at point j."""
    after = (j + 1) % saddle.orbit.period
    moved = saddle.orbit.map.jacobian(saddle.orbit.points[j]) @ saddle.directions[j]
    return float((moved / saddle.box) @ (saddle.directions[after] / saddle.box))
