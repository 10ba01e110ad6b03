"""Equations in the points of an orbit of a map: each is the image of the one before, and has its letter."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.equations import Equations
from grazing.orbits.one_sided import EPS
from grazing.orbits.orbit import doubt_of

Floats = NDArray[np.float64]


#: Multipliers farther from the unit circle are not doubted on account of the points' digits.
NEAR = 1e-5
#: How far points are moved at most, in scaled unknowns, to see how much multipliers depend on their digits.
MOVED = 1e-6


class PointEquations(Equations):
    """Equations whose unknowns are those of N points one after the other; ``letters`` (N,) are those of the points."""

    P: Map
    letters: tuple[int, ...]
    size: Floats

    def __init__(self) -> None:
        self._found: dict[str, tuple[tuple[bytes, bytes], Any]] = {}

    def once(self, make: Callable[[Floats, Floats], Any], x: Floats, p: Floats) -> Any:
        """Return what a method finds at x and p; defects, tests and slopes ask for the same one after the other."""
        place = x.tobytes(), p.tobytes()
        known = self._found.get(make.__name__)
        if known is None or known[0] != place:
            known = self._found[make.__name__] = place, make(x, p)
        return known[1]

    @abstractmethod
    def turn(self, x: Floats, p: Floats) -> Floats:
        """Return the derivative (dim, dim) of N steps at the first point."""

    @abstractmethod
    def turn_error(self, x: Floats, p: Floats) -> Floats:
        """Return by how much each number of that may be off."""

    def expanded(self, x: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
        """Return F, dF/dx and dF/dp."""
        return *self.defects(x, p), self.slopes(x, p)

    @abstractmethod
    def slopes(self, x: Floats, p: Floats) -> Floats:
        """Return dF/dp by differences that stay on one piece of the map."""

    def doubt(self, x: Floats, p: Floats, multipliers: NDArray[np.complex128]) -> float:
        """Return by how much multipliers may be off: by the derivative's errors, and by those of the points near 1.

        Where the derivative of the equations is nearly singular, rounding moves the points along its null vector.
        """
        unit = self.size / self.size[:, None]
        J = self.turn(x, p) * unit
        found = doubt_of(J, self.turn_error(x, p) * unit)
        if np.isfinite(J).all() and np.abs(np.abs(multipliers) - 1.0).min() < NEAR:
            F, wide = self.defects(x, p)
            least, along = (one[-1] for one in np.linalg.svd(wide * self.scale / self.scale[:, None])[1:])
            rounding = EPS * float(np.abs(wide * x / self.scale[:, None]).sum(axis=1).max()) + float(
                np.abs(F / self.scale).max()
            )
            far = MOVED if rounding >= MOVED * least else rounding / float(least)
            for side in (far, -far):
                moved = self.turn(x + side * along * self.scale, p) * unit
                found = max(found, doubt_of(J, np.abs(moved - J))) if np.isfinite(moved).all() else found
        return found if np.isfinite(found) else 0.0

    def like(self, letters: tuple[int, ...]) -> Self:
        """Return the equations of other letters in the same parameters."""
        return type(self)(self.P, self.names, letters, self.spans)  # type: ignore[call-arg]

    def turned_to(self, x: Floats, p: Floats, like: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """Return the solution, begun at another point, that is nearest to another, and its order."""
        N, d = self.N, len(x) // self.N
        orders = [
            np.roll(np.arange(N * d), -k * d) for k in range(N) if self.letters[k:] + self.letters[:k] == self.letters
        ]
        order = min(orders, key=lambda one: float(np.abs((x[one] - like) / self.scale).max()))
        return x[order], order

    def doubling(self, x: Floats, p: Floats) -> tuple[Equations, Floats]:
        """Return the equations of two turns, and the solution that goes round twice."""
        return self.like(self.letters * 2), np.tile(x, 2)

    def halving(self, x: Floats, p: Floats) -> tuple[Equations, Floats]:
        """Return the equations of half the turns, and the mean of both halves of a solution."""
        return self.like(self.letters[: self.N // 2]), 0.5 * (x[: len(x) // 2] + x[len(x) // 2 :])

    def later(self, x: Floats, p: Floats, k: int) -> Floats | None:
        """Return by how much an orbit differs, scaled, if begun a k-th of its turn later."""
        return np.asarray((np.roll(x, -len(x) // k) - x) / self.scale)

    def halved(self, x: Floats, p: Floats) -> Floats | None:
        """Return by how much the two halves of an orbit differ, scaled; None where they cannot be the same."""
        h = self.N // 2
        if self.N % 2 or self.letters[:h] != self.letters[h:]:
            return None
        half = len(x) // 2
        return np.asarray((x[half:] - x[:half]) / self.scale[:half])
