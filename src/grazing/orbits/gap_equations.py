"""The equations of a word of the gap map, without its square root: a letter R has the unknown s, and its point s^2."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.equations import Test
from grazing.orbits.orbit import Orbit, condition_of
from grazing.orbits.point_equations import PointEquations
from grazing.orbits.word import word
from grazing.parameter import unknown

Floats = NDArray[np.float64]


class GapEquations(PointEquations):
    """Unknown is x for a letter L and s = sqrt(x) for R; x -> lam x + mu and s -> mu - l - s give the next point.

    All equations are polynomials, so a branch goes on through a border collision, where x = 0 or s = 0; beyond, an
    orbit with s < 0 or with a letter L at x >= 0 is virtual.
    """

    def __init__(self, G: Map, names: tuple[str, ...], letters: tuple[int, ...], spans: Any = None) -> None:
        for name in names:
            if name not in G.params:
                raise unknown(name, G.params, G.name or "the gap map")
        self.P, self.names, self.letters, self.N = G, names, letters, len(letters)
        self.spans = np.ones(len(names)) if spans is None else np.asarray(spans, np.float64)
        self.scale = np.ones(self.N)
        self._right = np.array(letters) == 1

    def values(self, p: Floats) -> tuple[float, float, float]:
        """Return lam, mu and l."""
        values = {**self.P.params, **dict(zip(self.names, map(float, p), strict=True))}
        return values["lam"], values["mu"], values["l"]

    def points(self, x: Floats) -> Floats:
        """Return the points of the map, shape (N,)."""
        return np.where(self._right, x * x, x)

    def unknowns(self, points: Floats) -> Floats:
        """Return the unknowns of an orbit's points."""
        return np.where(self._right, np.sqrt(np.maximum(points, 0.0)), points)

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return by how much each point misses the image of the one before, and the derivative of that."""
        lam, mu, l = self.values(p)
        images = np.where(self._right, mu - l - x, lam * x + mu)
        wide = np.diag(-np.where(self._right, 2.0 * x, 1.0))
        for j in range(self.N):
            wide[(j + 1) % self.N, j] += -1.0 if self._right[j] else lam
        return np.roll(images, 1) - self.points(x), wide

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd and lp, free of the pole at s = 0, and for each point its distance from the border."""
        lam, _mu, _l = self.values(p)
        s = x[self._right]
        slope, scale = lam ** (self.N - len(s)) * (-1.0) ** len(s), float(np.prod(2.0 * s))
        border = [
            Test("bcb", float(v if right else -v), j) for j, (v, right) in enumerate(zip(x, self._right, strict=True))
        ]
        return (Test("pd", scale + slope), Test("lp", scale - slope), *border)

    def broken(self, x: Floats, p: Floats) -> str:
        """Say nothing: the equations hold everywhere."""
        return ""

    def orbit(self, x: Floats, p: Floats) -> Orbit:
        """Return the orbit, admissible if every point lies on the side of its letter."""
        lam, _mu, _l = self.values(p)
        s = x[self._right]
        with np.errstate(divide="ignore"):
            turn = np.prod(np.append(lam ** (self.N - len(s)), -0.5 / s))
        J = np.array([[turn]])
        return Orbit(
            map=self.P.replace(**dict(zip(self.names, map(float, p), strict=True))),
            points=self.points(x)[:, None],
            word=word(self.letters, self.P.letters),
            period=self.N,
            multipliers=np.array([turn], np.complex128),
            admissible=bool(((x >= 0.0) == self._right).all()),
            condition=condition_of(J),
            residual=float(np.abs(self.defects(x, p)[0]).max()),
        )
