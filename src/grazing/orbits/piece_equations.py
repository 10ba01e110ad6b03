"""The equations of a word of a map by pieces: each point is the image of the one before on the piece of its letter.

Pieces hold beyond their borders, so nothing ends at one: there an orbit is virtual. A piece that is given the root of
its distance from the border has that root as an unknown of its own, of either sign, and all equations are smooth.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map
from grazing.orbits.equations import ONE, Across, Ending, Equations, Test
from grazing.orbits.map_equations import MapEquations, alike, product, product_error, tests_of
from grazing.orbits.one_sided import EPS, FINER, FIRST, distances, slope
from grazing.orbits.orbit import condition_of
from grazing.orbits.piece_end import JUMP, TURN
from grazing.orbits.piece_letters import border_units
from grazing.orbits.piece_orbit import PieceOrbit
from grazing.orbits.point_equations import PointEquations
from grazing.orbits.word import word

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Coordinates smaller than this part of the box get finer differences: a formula may have a root there.
NEAR = 1e-4


class Looked(NamedTuple):
    """Images (N, dim) and borders (N, borders) of the points of an orbit, and how they change.

    The columns of ``J`` (N, dim, dim) are the coordinates, and one more the root if a piece gets it; ``across`` (N, 1,
    dim) is the derivative of the border then. ``along`` (N, dim or one more, parameters) are the derivatives of both in
    the parameters, ``error`` is that of J.
    """

    images: Floats
    borders: Floats
    J: Floats
    across: Floats
    along: Floats
    error: Floats


class PieceEquations(PointEquations):
    """Unknowns are the coordinates of each point and, where its piece gets it, the root of its distance.

    Parameters
    ----------
    P : Map
        By pieces.
    names : tuple of str
    letters : tuple of int
        The piece of each point, whether or not the map would choose it there.
    spans : ndarray, optional
    """

    pieced = True

    def __init__(self, P: Map, names: tuple[str, ...], letters: tuple[int, ...], spans: Any = None) -> None:
        super().__init__()
        assert P.formulas is not None
        plain = MapEquations(P, names, letters, spans)  # refuses names that it does not have
        self.P, self.names, self.letters, self.N, self.spans = P, names, letters, len(letters), plain.spans
        self._plain, self._images = plain, P.images()
        N, d, m = self.N, P.dimension, len(P.formulas.borders)
        self.size = np.array([0.5 * (high - low) for low, high in P.box])
        self.which = np.array(letters, np.int64)
        self.rooted = np.array([P.formulas.rooted[k] for k in letters])
        self.some = bool(self.rooted.any())
        self.side = np.where(self.which == 0, -1.0, 1.0)  # of rooted pieces, which are two
        self.before = np.arange(N) - 1
        #: Where the unknowns of each point begin, and where each coordinate and root is among them.
        self.starts = np.concatenate([[0], np.cumsum(d + self.rooted)])
        self.at_points = (self.starts[:N, None] + np.arange(d)).ravel()
        self.at_roots = self.starts[:N][self.rooted] + d
        self.units = border_units(P)
        self.scale = np.empty(int(self.starts[-1]))
        self.scale[self.at_points] = np.tile(self.size, N)
        self.scale[self.at_roots] = np.sqrt(self.units[0])
        #: The borders that a letter has, and its sign there: negative up to its own, positive at those before.
        self.sides = [
            [(i, 1.0) for i in range(min(k, m))] + [(i, -1.0) for i in range(k, min(k + 1, m))] for k in letters
        ]
        self._apart = distances(2.0, 2.0)[:, None]

    def parted(self, x: Floats) -> tuple[Floats, Floats]:
        """Return points (..., N, dim) and roots (..., N) of unknowns; a piece that gets no root has 0."""
        roots = np.zeros((*x.shape[:-1], self.N))
        if not self.some:
            return x.reshape(*x.shape[:-1], self.N, -1).copy(), roots
        roots[..., self.rooted] = x[..., self.at_roots]
        return x[..., self.at_points].reshape(*x.shape[:-1], self.N, -1), roots

    def unknowns(self, points: Floats, roots: Floats) -> Floats:
        """Return the unknowns of points (..., N, dim) with roots (..., N)."""
        x = np.empty((*points.shape[:-2], int(self.starts[-1])))
        x[..., self.at_points] = points.reshape(*points.shape[:-2], -1)
        x[..., self.at_roots] = roots[..., self.rooted]
        return x

    def rounded(self, x: Floats) -> Floats:
        """Return by how much rounding of a step moves the point that it leads to."""
        points = np.abs(self.parted(x)[0])
        return self.unknowns(np.broadcast_to(EPS * points.max(axis=0), points.shape), np.zeros(self.N))

    def begun(self, points: Floats, p: Floats) -> Floats:
        """Return unknowns of points (..., N, dim) on the sides of their letters: those beyond get the root 0."""
        flat = points.reshape(-1, self.P.dimension)
        roots = np.zeros(points.shape[:-1])
        if self.some:
            borders = self._images(self._plain.rows(p[None]), 0, flat, np.resize(self.which, len(flat)), 0.0)[1]
            roots = np.sqrt(np.maximum(self.side * borders[:, 0].reshape(roots.shape), 0.0))
        return self.unknowns(points, roots)

    def ran(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return images (k, N, dim) and borders (k, N, borders) of unknowns (k, n) at parameters (k, names)."""
        points, roots = self.parted(x)
        k, N, d = points.shape
        given = points.reshape(-1, d), np.tile(self.which, k), roots.ravel()
        images, borders = self._images(self._plain.rows(p), np.repeat(np.arange(k), N), *given)
        return images.reshape(k, N, d), borders.reshape(k, N, -1)

    def missed(self, x: Floats, images: Floats, borders: Floats) -> Floats:
        """Return the defects (k, n) of unknowns (k, n) with these images and borders."""
        points, roots = self.parted(x)
        F = np.empty(x.shape)
        F[:, self.at_points] = (images[:, self.before] - points).reshape(len(x), -1)
        if self.some:
            F[:, self.at_roots] = (self.side * borders[..., 0] - roots**2)[:, self.rooted]
        return F

    def looked(self, x: Floats, p: Floats) -> Looked:
        """Return images, borders, and their derivatives in coordinates and root."""
        found: Looked = self.once(self._looked, x, p)
        return found

    def _looked(self, x: Floats, p: Floats) -> Looked:
        points, roots = self.parted(x)
        return self._looked_at(points, roots, p[None], len(self.names))

    def heights(self, x: Floats, p: Floats, index: int, kind: tuple[str, int]) -> Floats:
        """Return a test function at several points."""
        points, roots = self.parted(x)
        if kind[0] == "bcb":
            return self._distances(self.ran(x, p)[1], roots)[index - (3 if self.P.dimension > 1 else 2)][1]
        near = (np.abs(points) < NEAR * self.size).any(axis=(1, 2))
        if near.any() and not (near.all() and alike(2.0 * self.size, points)):
            return super().heights(x, p, index, kind)
        d, k = self.P.dimension, len(x)
        at = self._looked_at(points.reshape(-1, d), roots.ravel(), p, 0)
        each = (Looked(*one) for one in zip(*(part.reshape(k, self.N, *part.shape[1:]) for part in at), strict=True))
        return np.array([self._height(*one, index) for one in zip(each, roots, strict=True)])

    def _looked_at(self, points: Floats, roots: Floats, p: Floats, m: int) -> Looked:
        """Return images, borders and derivatives at the points (k N, dim) of k orbits with parameters (k, names).

        Those in the first m parameters too: of one orbit all of them, of several none.
        """
        d, N = self.P.dimension, len(points)
        state, unit, place = points, self.size, points
        if self.some:
            state, unit = np.column_stack([points, roots]), np.append(self.size, np.sqrt(self.units[0]))
            place = np.column_stack([points, np.full(N, unit[-1])])
        k = len(unit)
        n = k + m  # what moves: the numbers of a point, then the parameters
        if (np.abs(place) < NEAR * unit).any():
            h = distances(2.0 * unit, place)
            L = len(h)
            moves, shifts, which = pattern(N, k, m, L)
            moves = np.sign(moves) * h[..., None, :]
        else:
            L = len(self._apart)
            moves, shifts, which = pattern(N, k, m, L)
            moves = moves * (2.0 * unit)
        here_at, pieces, own = state[:, None, :], np.resize(self.which, N), np.repeat(np.arange(len(p)), self.N)
        states, values = here_at + moves, p + shifts * self.spans if m else p
        which = which + own[:, None]
        off = np.abs(states - here_at).sum(axis=-1)
        if m:
            off[..., k:] = np.abs(values[1:] - p).sum(axis=-1).reshape(m, 2, L).transpose(1, 2, 0)[:, :, None]
        off[off == 0.0] = np.nan
        off = off[..., None]
        every, letters = (
            np.concatenate([state, states.reshape(-1, k)]),
            np.broadcast_to(pieces[:, None], which.shape),
        )
        images, ends = self._images(
            self._plain.rows(values), np.append(own, which), every[:, :d],
            np.append(pieces, letters), every[:, d] if self.some else 0.0,
        )  # fmt: skip
        here, borders = images[:N].copy(), ends[:N].copy()
        both = np.column_stack([images, ends]) if self.some else images
        middle, (low, high) = both[:N], both[N:].reshape(2, L, N, n, -1)
        if m and not (right := self._plain.allowed(values)).all():
            low[~right[which[0]]], high[~right[which[1]]] = np.nan, np.nan
        found = slope(middle[:, None], low, high, off[0], off[1])
        value, error = found.value.swapaxes(1, 2), found.error.swapaxes(1, 2)
        return Looked(here, borders, value[:, :d, :k], value[:, d:, :d], value[:, :, k:], error[:, :d, :k])

    def slopes(self, x: Floats, p: Floats) -> Floats:
        """Return dF/dp by differences."""
        at, d = self.looked(x, p), self.P.dimension
        columns = np.empty((len(x), len(self.names)))
        columns[self.at_points] = at.along[self.before, :d].reshape(self.N * d, -1)
        if self.some:
            columns[self.at_roots] = (self.side[:, None] * at.along[:, d])[self.rooted]
        return columns

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return by how much each point misses the image of the one before, and each root, and the derivative."""
        n = len(x)
        if not np.isfinite(x).all():
            return np.full(n, np.nan), np.full((n, n), np.nan)
        at = self.looked(x, p)
        F = self.missed(x[None], at.images[None], at.borders[None])[0]
        return F, self._wide(at, self.parted(x)[1])

    def _wide(self, at: Looked, roots: Floats) -> Floats:
        """Return the derivative of the equations in their unknowns."""
        n, d = int(self.starts[-1]), self.P.dimension
        wide = np.zeros((n, n))
        wide[self.at_points, self.at_points] = -1.0
        for j in range(self.N):
            own, to = int(self.starts[j]), int(self.starts[(j + 1) % self.N])
            wide[to : to + d, own : own + d + self.rooted[j]] += at.J[j][:, : d + self.rooted[j]]
            if self.rooted[j]:
                side = -1.0 if self.letters[j] == 0 else 1.0
                wide[own + d, own : own + d] = side * at.across[j, 0]
                wide[own + d, own + d] = -2.0 * roots[j]
        return wide

    def steps(self, x: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the derivatives (N, dim, dim) of all steps times twice their roots, those factors, and the errors."""
        return self._steps(self.looked(x, p), self.parted(x)[1])

    def _steps(self, at: Looked, roots: Floats) -> tuple[Floats, Floats, Floats]:
        d = self.P.dimension
        twice = np.where(self.rooted, 2.0 * roots, 1.0)
        if not self.some:
            return at.J, twice, at.error
        u = np.where(self.rooted[:, None], at.J[:, :, d], 0.0)
        g = self.side[:, None] * at.across[:, 0]
        error = np.abs(twice)[:, None, None] * at.error[:, :, :d]
        error += np.where(self.rooted[:, None], at.error[:, :, d], 0.0)[:, :, None] * np.abs(g)[:, None, :]
        return twice[:, None, None] * at.J[:, :, :d] + u[:, :, None] * g[:, None, :], twice, error

    def turn(self, x: Floats, p: Floats) -> Floats:
        """Return the derivative of N steps at the first point; not finite where a root is 0."""
        steps, twice, _error = self.steps(x, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            return product(steps / twice[:, None, None])

    def turn_error(self, x: Floats, p: Floats) -> Floats:
        """Return by how much that may be off."""
        steps, twice, error = self.steps(x, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            return product_error(*(one / np.abs(twice)[:, None, None] for one in (steps, error)))

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd, lp and ns without the poles that they have where a root is 0, and the distances from borders."""
        at, roots = self.looked(x, p), self.parted(x)[1]
        steps, twice, error = self._steps(at, roots)
        middle, *ends = (self._stability(one, twice) for one in (steps, steps - error, steps + error))
        with np.errstate(invalid="ignore"):
            off = np.max(np.abs(np.array(ends) - middle), axis=0).tolist()
        kinds = ("pd", "lp", "ns") if self.P.dimension > 1 else ("pd", "lp")
        values = self._without_poles(at, roots, twice, middle)
        found = [Test(*one) for one in zip(kinds, values, (-1,) * len(kinds), off, strict=True)]
        found += [Test("bcb", float(one[0]), j) for j, one in self._distances(at.borders[None], roots[None])]
        return tuple(found)

    def _distances(self, borders: Floats, roots: Floats) -> list[tuple[int, Floats]]:
        """Return for each point and border of its letter how far it is from it at k orbits, or the root of that."""
        found = []
        for j in range(self.N):
            if self.rooted[j]:
                found.append((j, roots[:, j] / np.sqrt(self.units[0])))
                continue
            found += [(j, s * borders[:, j, i] / self.units[i]) for i, s in self.sides[j]]
        return found

    def _without_poles(self, at: Looked, roots: Floats, twice: Floats, tests: list[float]) -> list[float]:
        """Return pd, lp and ns without the poles that they have where a root is 0, from those with factors."""
        if not self.some or self.P.dimension == 1:
            return tests
        pd, lp = self._closing(at, roots)
        return [pd, lp, self._turning(at, twice) if self.P.dimension == 2 else tests[2]]

    def _height(self, at: Looked, roots: Floats, index: int) -> float:
        """Return pd, lp or ns by its place."""
        steps, twice, _error = self._steps(at, roots)
        return self._without_poles(at, roots, twice, self._stability(steps, twice))[index]

    def _closing(self, at: Looked, roots: Floats) -> list[float]:
        """Return pd and lp, times the factors of all roots, without dividing by one: the derivative of the equations.

        Its determinant is that of 1 - J; with the last step reversed, that of 1 + J.
        """
        wide = -self._wide(at, roots)
        if not np.isfinite(wide).all():
            return [np.nan, np.nan]
        lp, d = float(np.linalg.det(wide)), self.P.dimension
        last = int(self.starts[-2])
        closing = wide[:d, last:].copy()
        if self.N == 1:
            closing[:, :d] -= np.eye(d)  # the point itself is no step
        wide[:d, last:] -= 2.0 * closing
        return [float(np.linalg.det(wide)), lp]

    def _turning(self, at: Looked, twice: Floats) -> float:
        """Return ns of a map of the plane, times the factors of all roots: 1 less the determinant of J."""
        J, u, g = at.J[:, :, :2], at.J[:, :, 2], self.side[:, None] * at.across[:, 0]
        plain = J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] * J[:, 1, 0]
        bent = g[:, 0] * (J[:, 1, 1] * u[:, 0] - J[:, 0, 1] * u[:, 1])
        bent += g[:, 1] * (J[:, 0, 0] * u[:, 1] - J[:, 1, 0] * u[:, 0])
        return float(np.prod(twice) - np.prod(twice * plain + np.where(self.rooted, bent, 0.0)))

    def _stability(self, steps: Floats, twice: Floats) -> list[float]:
        """Return pd, lp and ns, times the factors of all roots."""
        if not np.isfinite(steps).all():
            return [np.nan] * (3 if self.P.dimension > 1 else 2)
        poles = float(np.prod(twice))
        if self.P.dimension == 1:
            slope_of = float(np.prod(steps[:, 0, 0]))
            return [poles + slope_of, poles - slope_of]
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            J = product(steps / twice[:, None, None])
            if not np.isfinite(J).all():  # a root is 0: the limit from either side has no pole, see there
                twice = np.where(twice == 0.0, EPS * self.size.max(), twice)
                poles, J = float(np.prod(twice)), product(steps / twice[:, None, None])
        return [poles * one for one in tests_of(J)]

    def broken(self, x: Floats, p: Floats) -> str:
        """Say nothing: the equations hold beyond all borders."""
        return ""

    def holds(self, x: Floats, p: Floats, defect: float = np.inf) -> NDArray[np.bool_]:
        """Whether the pieces have values at orbits (k, n) with parameters (k, names), and the defects are small."""
        right = np.isfinite(x).all(axis=1) & self._plain.allowed(p)
        if right.any():
            images, borders = self.ran(x[right], p[right])
            apart = np.abs(self.missed(x[right], images, borders)) / self.scale
            right[right] = np.isfinite(images).all(axis=(1, 2)) & (apart <= defect).all(axis=1)
        return np.asarray(right)

    def ending(self, x: Floats, p: Floats, dx: Floats, dp: Floats, gap: float) -> Ending:
        """Say what is met where a piece has no value any more: as on maps that are not by pieces."""
        (points, _roots), (ahead, _along) = self.parted(x), self.parted(dx)
        flat, way = points.ravel(), ahead.ravel()
        if not self._plain.holds(flat[None], p[None])[0]:
            return Ending("", -1, 0.0)
        found = self._plain.ending(flat, p, way, dp, gap)
        if found.beyond is None:
            return found
        other, y, q = found.beyond
        assert isinstance(other, MapEquations)
        new = self.like(other.letters)
        return found._replace(beyond=(new, new.begun(y.reshape(self.N, -1), q), q))

    def same(self, x: Floats, other: Equations, y: Floats, p: Floats) -> bool:
        """Whether two solutions are one orbit; where all points are at one border, words that differ are others."""
        if not isinstance(other, PieceEquations):
            return super().same(x, other, y, p)
        if len(x) != len(y):
            return False
        turned = (k for k in range(self.N) if other.letters[k:] + other.letters[:k] == self.letters)
        return any(bool(np.abs((np.roll(y, -int(other.starts[k])) - x) / self.scale).max() < ONE) for k in turned)

    def turned_to(self, x: Floats, p: Floats, like: Floats) -> tuple[Floats, Ints]:
        """Return the solution, begun at another point, that is nearest to another, and its order."""
        orders = [
            np.roll(np.arange(len(x)), -int(self.starts[k]))
            for k in range(self.N) if self.letters[k:] + self.letters[:k] == self.letters
        ]  # fmt: skip
        order = min(orders, key=lambda one: float(np.abs((x[one] - like) / self.scale).max()))
        return x[order], order

    def margins(self, x: Floats, p: Floats) -> Floats:
        """Return how far each point lies on the side of its letter, in the units of borders."""
        at, (_points, roots) = self.looked(x, p), self.parted(x)
        known = [min(s * at.borders[j, i] for i, s in self.sides[j]) for j in range(self.N)]
        return np.where(self.rooted, roots * np.abs(roots), known)

    def orbit(self, x: Floats, p: Floats) -> PieceOrbit:
        """Return the orbit, admissible if every point lies on the side of its letter."""
        at, (points, _roots) = self.looked(x, p), self.parted(x)
        J, margins = self.turn(x, p), self.margins(x, p)
        finite = np.isfinite(J).all()
        roots = np.linalg.eigvals(J).astype(np.complex128) if finite else np.full(len(J), np.nan + 0j)
        if not finite and len(J) == 1:
            roots = J[0].astype(np.complex128)
        last = len(self.P.letters or "") - 1  # type: ignore[arg-type]
        own = (margins > 0.0) | ((margins == 0.0) & (self.which == last))
        return PieceOrbit(
            map=self._plain.map_at(p),
            points=points,
            word=word(self.letters, self.P.letters),
            period=self.N,
            multipliers=roots[np.argsort(-np.abs(roots), kind="stable")],
            admissible=bool(own.all()),
            condition=condition_of(J),
            residual=float(np.abs(at.images[self.before] - points).max()),
            letters=self.letters,
            margins=margins,
            doubt=self.doubt(x, p, roots),
        )

    def across(self, x: Floats, p: Floats, where: int) -> Across | None:
        """Return what lies beyond the border that a point is at; None where that is nothing else."""
        at, (points, roots) = self.looked(x, p), self.parted(x)
        i, side = min(self.sides[where], key=lambda one: abs(at.borders[where, one[0]] / self.units[one[0]]))
        signs = at.borders[where] >= 0.0
        signs[i] = side < 0.0
        letter = int(np.argmin(signs)) if not signs.all() else len(signs)
        if letter == self.letters[where]:
            return None
        new = self.like((*self.letters[:where], letter, *self.letters[where + 1 :]))
        roots[where] = 0.0
        y = new.unknowns(points, roots)
        here, there = self.looked(self.unknowns(points, roots), p), new.looked(y, p)
        a, b = here.images[where] / self.size, there.images[where] / self.size
        size = np.abs(points[where] / self.size).max() + np.abs(a).max()
        close = bool((np.abs(a - b) <= JUMP + 64.0 * EPS * (1.0 + size)).all())
        if self.rooted[where] or new.rooted[where]:
            return Across(new, y, close, smooth=False)
        turn, error = np.abs(here.J[where] - there.J[where]), here.error[where] + there.error[where]
        same = bool((turn <= TURN * (1.0 + np.abs(here.J[where])) + error).all())
        return Across(new, y, close, smooth=close and same)


@lru_cache(maxsize=64)
def pattern(N: int, k: int, m: int, L: int) -> tuple[Floats, Floats, Ints]:
    """Return in which parts of sizes the k numbers of N points and m parameters are moved, one after the other.

    Returns
    -------
    moves : ndarray, shape (2, L, 1, k + m, k)
        Of numbers, down and up, from far to near.
    shifts : ndarray, shape (1 + 2 L m, m)
        Of parameters; the first row is that of no shift.
    which : ndarray, shape (2, L, N, k + m)
        The row of parameters of each.
    """
    parts = FIRST * FINER ** -np.arange(float(L))
    both = np.stack([-parts, parts])
    moves, shifts = np.zeros((2, L, 1, k + m, k)), np.zeros((1 + 2 * L * m, m))
    which = np.zeros((2, L, N, k + m), np.int64)
    for i in range(k):
        moves[:, :, 0, i, i] = both
    for j in range(m):
        first = 1 + 2 * L * j
        shifts[first : first + 2 * L, j] = both.ravel()
        which[..., k + j] = (first + np.arange(2 * L)).reshape(2, L, 1)
    return moves, shifts, which
