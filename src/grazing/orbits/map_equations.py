"""The equations of a periodic orbit of any map, in all of its points: each one is the image of the one before."""

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


class MapEquations(PointEquations):
    """Points x_0, ..., x_{N-1} with x_{j+1} = P(x_j) and x_0 = P(x_{N-1}), each with the letter it has at the start."""

    def __init__(self, P: Map, names: tuple[str, ...], letters: tuple[int, ...], spans: Any = None) -> None:
        for name in names:
            if name not in P.params:
                raise unknown(name, P.params, P.name or "the map")
        self.P, self.names, self.letters, self.N = P, names, letters, len(letters)
        self.spans = np.ones(len(names)) if spans is None else np.asarray(spans, np.float64)
        size = np.array([high - low for low, high in P.box])
        self.scale = np.tile(size, self.N)
        self._held: tuple[bytes, Map] | None = None

    def map_at(self, p: Floats) -> Map:
        """Return the map with these values of the parameters that vary."""
        key = np.asarray(p, np.float64).tobytes()
        if self._held is None or self._held[0] != key:
            self._held = key, self.P.replace(**dict(zip(self.names, map(float, p), strict=True)))
        return self._held[1]

    def stepped(self, x: Floats, p: Floats) -> tuple[Floats, Floats, tuple[int, ...]]:
        """Return the images of all points (N, dim), the derivatives there (N, dim, dim) and the letters."""
        P, points = self.map_at(p), x.reshape(self.N, -1)
        row = P.packed()[1][None]
        found = P.run_columns(row, points.T[None].copy(), 0, 1, arithmetic="strict", algorithm="scalar", threads=1)
        J = np.array([P.jacobian(point) for point in points])
        return found.points[0, 0].T, J, tuple(found.letters[0, 0].tolist())

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return by how much each point misses the image of the one before, and the derivative of that."""
        d, N = self.P.dimension, self.N
        if not np.isfinite(x).all():
            return np.full(N * d, np.nan), np.full((N * d, N * d), np.nan)
        images, J, _letters = self.stepped(x, p)
        wide = -np.eye(N * d)
        for j in range(N):
            k = (j + 1) % N
            wide[k * d : (k + 1) * d, j * d : (j + 1) * d] += J[j]
        return np.roll(images, 1, axis=0).ravel() - x, wide

    def turn(self, x: Floats, p: Floats) -> Floats:
        """Return the derivative of N steps at the first point."""
        J = np.eye(self.P.dimension)
        for one in self.stepped(x, p)[1]:
            J = one @ J
        return J

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd, lp and ns of the turn, and whether each point has its letter still."""
        _images, steps, letters = self.stepped(x, p)
        J = np.eye(self.P.dimension)
        for step in steps:
            J = step @ J
        found = [
            Test("pd", float(np.linalg.det(np.eye(len(J)) + J))),
            Test("lp", float(np.linalg.det(np.eye(len(J)) - J))),
        ]
        if len(J) > 1:
            roots = np.linalg.eigvals(J)
            pairs = [1.0 - roots[i] * roots[j] for i in range(len(J)) for j in range(i)]
            found.append(Test("ns", float(np.prod(pairs).real)))
        same = [
            Test("bcb", 1.0 if a == b else -1.0, j) for j, (a, b) in enumerate(zip(letters, self.letters, strict=True))
        ]
        return (*found, *same)

    def broken(self, x: Floats, p: Floats) -> str:
        """Say whether a point has another letter than at the start."""
        letters = self.stepped(x, p)[2]
        if letters != self.letters:
            return "a point has crossed the border between two letters"
        return ""

    def orbit(self, x: Floats, p: Floats) -> Orbit:
        """Return the orbit; it is one of the map itself, so admissible as long as its letters are those of its word."""
        images, _steps, letters = self.stepped(x, p)
        J = self.turn(x, p)
        roots = np.linalg.eigvals(J).astype(np.complex128) if np.isfinite(J).all() else np.full(len(J), np.nan + 0j)
        return Orbit(
            map=self.map_at(p),
            points=x.reshape(self.N, -1),
            word=word(self.letters, self.P.letters),
            period=self.N,
            multipliers=roots[np.argsort(-np.abs(roots), kind="stable")],
            admissible=letters == self.letters,
            condition=condition_of(J),
            residual=float(np.abs(np.roll(images, 1, axis=0).ravel() - x).max()),
        )
