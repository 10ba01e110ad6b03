"""Equations in the points of an orbit of a map: each is the image of the one before, and has its letter."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.equations import Equations

Floats = NDArray[np.float64]


class PointEquations(Equations):
    """Equations whose unknowns are those of N points one after the other; ``letters`` (N,) are those of the points."""

    P: Map
    letters: tuple[int, ...]

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

    def halved(self, x: Floats, p: Floats) -> Floats | None:
        """Return by how much the two halves of an orbit differ, scaled; None where they cannot be the same."""
        h = self.N // 2
        if self.N % 2 or self.letters[:h] != self.letters[h:]:
            return None
        half = len(x) // 2
        return np.asarray((x[half:] - x[:half]) / self.scale[:half])
