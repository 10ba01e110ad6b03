"""The equations of a periodic orbit of any map, in all of its points: each one is the image of the one before."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.maps.map import Map, eased
from grazing.orbits.equations import Ending, Test
from grazing.orbits.one_sided import EPS, Slope, distances, slope
from grazing.orbits.orbit import Orbit, condition_of
from grazing.orbits.piece_end import ending
from grazing.orbits.point_equations import PointEquations
from grazing.orbits.word import word
from grazing.outcome import InputError
from grazing.parameter import unknown

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Parts of a Newton step that are tried where the whole step leaves the piece.
SHARES = 0.5 ** np.arange(1.0, 48.0)
#: Parts of a direction at which images are taken on either side, and all of them in order with the point itself.
ALONG = distances(1.0, 1.0)
BOTH_WAYS = np.concatenate([-ALONG, [0.0], ALONG[::-1]])


class Stepped(NamedTuple):
    """Images (N, dim) of the points of an orbit, derivatives (N, dim, dim) there, their errors, and letters."""

    images: Floats
    J: Floats
    error: Floats
    letters: tuple[int, ...]


def product(steps: Floats) -> Floats:
    """Return the derivative of all steps one after the other, not finite where it is beyond all doubles."""
    J = np.eye(steps.shape[-1])
    with np.errstate(over="ignore", invalid="ignore"):
        for step in steps:
            J = step @ J
    return J


def product_error(steps: Floats, error: Floats) -> Floats:
    """Return by how much the derivative of all steps may be off, given by how much each one may."""
    J, off = np.eye(steps.shape[-1]), np.zeros(steps.shape[1:])
    for step, e in zip(steps, error, strict=True):
        J, off = step @ J, np.abs(step) @ off + e @ (np.abs(J) + off)
    return off


def tests_of(J: Floats) -> list[float]:
    """Return pd, lp and, from two coordinates on, ns of the derivative of one turn."""
    if not np.isfinite(J).all():
        return [np.nan] * (3 if len(J) > 1 else 2)
    if len(J) == 1:  # as most maps of one's own, without the algebra of matrices
        return [1.0 + float(J[0, 0]), 1.0 - float(J[0, 0])]
    if len(J) == 2:
        (a, b), (c, d) = J.tolist()
        return [(1.0 + a) * (1.0 + d) - b * c, (1.0 - a) * (1.0 - d) - b * c, 1.0 - (a * d - b * c)]
    same, roots = np.eye(len(J)), np.linalg.eigvals(J)
    pairs = np.prod([1.0 - roots[i] * roots[j] for i in range(len(J)) for j in range(i)])
    return [float(np.linalg.det(same + J)), float(np.linalg.det(same - J)), float(pairs.real)]


def alike(size: Floats, places: Floats) -> bool:
    """Whether differences of orbits (k, ..., numbers) are taken at equally many distances."""
    with np.errstate(divide="ignore", over="ignore"):
        fine = (size / np.abs(places)).reshape(len(places), -1).max(axis=1)
    coarsest, finest = (places[i] for i in (int(fine.argmin()), int(fine.argmax())))
    return len(distances(size, coarsest)) == len(distances(size, finest))


class MapEquations(PointEquations):
    """Points x_0, ..., x_{N-1} with x_{j+1} = P(x_j) and x_0 = P(x_{N-1}), each with the letter it has at the start.

    They hold on one piece of the map, as long as all letters stay: across the border between two letters the map may
    jump, and what is learnt there says nothing of the orbit here.
    """

    pieced = True

    def __init__(self, P: Map, names: tuple[str, ...], letters: tuple[int, ...], spans: Any = None) -> None:
        super().__init__()
        for name in names:
            if name not in P.params:
                raise unknown(name, P.params, P.name or "the map")
        P.origin.refuse_made(names)
        self.P, self.names, self.letters, self.N = P, names, letters, len(letters)
        self._eased = eased(P)
        self.spans = np.ones(len(names)) if spans is None else np.asarray(spans, np.float64)
        self.size = np.array([high - low for low, high in P.box])
        self.scale = np.tile(self.size, self.N)
        self._row = np.array(list(P.params.values()) or [0.0])
        self._places = [list(P.params).index(name) for name in names]
        self._held: tuple[bytes, Map] | None = None

    def map_at(self, p: Floats) -> Map:
        """Return the map with these values of the parameters that vary."""
        key = np.asarray(p, np.float64).tobytes()
        if self._held is None or self._held[0] != key:
            self._held = key, self.P.replace(**dict(zip(self.names, map(float, p), strict=True)))
        return self._held[1]

    def ran(self, rows: Floats, states: Floats) -> tuple[Floats, Ints]:
        """Return images (columns, dim, n) and letters (columns, n) of states at rows of all parameters."""
        found = self._eased.run_columns(rows, states.copy(), 0, 1, arithmetic="strict", algorithm="scalar", threads=1)
        return found.points[:, 0], found.letters[:, 0]

    def rows(self, p: Floats) -> Floats:
        """Return the values of all parameters (k, parameters) for those that vary (k, names)."""
        rows = np.tile(self._row, (len(p), 1))
        rows[:, self._places] = p
        return self.P.origin.complete(rows)

    def rounds(self, p: Floats) -> Floats:
        """Return after how much each unknown comes round, as a phase does; infinite for those that do not."""
        known = self.P.origin.rounds
        return np.full(len(self.scale), np.inf) if known is None else np.tile(known(self.rows(p[None]))[0], self.N)

    def rounded(self, x: Floats) -> Floats:
        """Return by how much rounding of a step moves the point that it leads to."""
        points = np.abs(x).reshape(self.N, -1)
        return EPS * np.tile(points.max(axis=0), self.N)

    def visited(self, x: Floats, p: Floats) -> tuple[Floats, tuple[int, ...]]:
        """Return the images of all points (N, dim) and the letters."""
        images, letters = self.ran(self.rows(p[None]), x.reshape(1, self.N, -1).transpose(0, 2, 1))
        return images[0].T, tuple(letters[0].tolist())

    def stepped(self, x: Floats, p: Floats) -> Stepped:
        """Return the images of all points, the derivatives there, taken on one piece of the map, and the letters."""
        found: Stepped = self.once(self._stepped, x, p)
        return found

    def _stepped(self, x: Floats, p: Floats) -> Stepped:
        if self.P.tangent is not None:
            images, letters = self.visited(x, p)
            P = eased(self.map_at(p))
            J = np.array([P.jacobian(point) for point in x.reshape(self.N, -1)])
            return Stepped(images, J, 4.0 * EPS * np.abs(J), letters)
        images, J, error, seen = self._looked(x[None], p[None])
        return Stepped(images[0], J[0], error[0], tuple(seen[0].tolist()))

    def _looked(self, x: Floats, p: Floats) -> tuple[Floats, Floats, Floats, Ints]:
        """Return images, derivatives by differences, their errors and letters of the points of k orbits at once."""
        k, N, d = len(x), self.N, self.P.dimension
        points = x.reshape(k, N, d)
        h = distances(self.size, points)  # (levels, k, N, d), one for each coordinate that moves
        moved = np.eye(d) * h[None, ..., None]  # (1, levels, k, N, d, d)
        states = points[..., None, :] + np.concatenate([-moved, moved])
        flat = np.concatenate([points, states.transpose(2, 0, 1, 3, 4, 5).reshape(k, -1, d)], axis=1)
        after, seen = self.ran(self.rows(p), flat.transpose(0, 2, 1))
        after = after.transpose(0, 2, 1)
        middle, own = after[:, :N], seen[:, :N]
        values = after[:, N:].reshape(k, 2, -1, N, d, d).transpose(1, 2, 0, 3, 4, 5)
        same = seen[:, N:].reshape(k, 2, -1, N, d).transpose(1, 2, 0, 3, 4) == own[..., None]
        low, high = np.where(same[..., None], values, np.nan)
        places = np.einsum("slkjii->slkji", states)
        down, up = (np.abs(places - points) + np.where(places == points, np.nan, 0.0))[..., None]
        found = slope(middle[:, :, None], low, high, down, up)
        return middle, found.value.swapaxes(2, 3), found.error.swapaxes(2, 3), own

    def heights(self, x: Floats, p: Floats, index: int, kind: tuple[str, int]) -> Floats:
        """Return a test function at several points."""
        if self.P.tangent is not None or not alike(self.size, x.reshape(len(x), self.N, -1)):
            return super().heights(x, p, index, kind)
        return np.array([tests_of(product(one))[index] for one in self._looked(x, p)[1]])

    def slopes(self, x: Floats, p: Floats) -> Floats:
        """Return dF/dp by differences that stay on the piece."""
        found: Floats = self.once(self._slopes, x, p)
        return found

    def _slopes(self, x: Floats, p: Floats) -> Floats:
        columns = []
        for j in range(len(self.names)):
            found, _images, _letters = self.along(x, p, np.zeros(len(x)), np.eye(len(p))[j] * self.spans)
            columns.append(np.roll(found.value, 1, axis=0).ravel() / self.spans[j])
        return np.column_stack(columns) if columns else np.empty((len(x), 0))

    def along(self, x: Floats, p: Floats, dx: Floats, dp: Floats) -> tuple[Slope, Floats, Ints]:
        """Return the derivative of all images along a direction, the images there and the letters.

        One column of letters (columns, N) for each distance below, from far to near, the point itself, and each above.
        """
        h, t = ALONG, BOTH_WAYS
        rows = self.rows(p + t[:, None] * dp)
        states = (x + t[:, None] * dx).reshape(len(t), self.N, -1).transpose(0, 2, 1)
        right = self.allowed(p + t[:, None] * dp)
        images, letters = np.full(states.shape, np.nan), np.full((len(t), self.N), -1)
        images[right], letters[right] = self.ran(rows[right], states[right])
        images = images.transpose(0, 2, 1)
        on = np.where((letters == self.letters).all(axis=1)[:, None, None], images, np.nan)
        k = len(h)
        return slope(on[k], on[:k], on[:k:-1], h[:, None, None], h[:, None, None]), images, letters

    def allowed(self, p: Floats) -> NDArray[np.bool_]:
        """Whether the map allows each of several values (k, names) of its parameters."""
        if len(p) and self.in_range(p.min(axis=0)) and self.in_range(p.max(axis=0)):
            return np.ones(len(p), np.bool_)  # ranges are intervals
        return np.array([self.in_range(one) for one in p], np.bool_)

    def in_range(self, p: Floats) -> bool:
        """Whether the map allows these values of its parameters."""
        try:
            for name, value in zip(self.names, p, strict=True):
                self.P.describe(name).check(float(value))
        except InputError:
            return False
        return True

    def holds(self, x: Floats, p: Floats, defect: float = np.inf) -> NDArray[np.bool_]:
        """Whether all points of orbits (k, N dim) at parameters (k, names) have their letters and little defect."""
        letters = np.full((len(x), self.N), -1)
        right = np.isfinite(x).all(axis=1) & self.allowed(p)
        if right.any():
            rows = self.rows(p[right])
            states = x[right].reshape(len(rows), self.N, -1).transpose(0, 2, 1)
            images, letters[right] = self.ran(rows, states)
            apart = np.abs(np.roll(images, 1, axis=2) - states) / self.size[:, None]
            right[right] = (np.isfinite(images) & (apart <= defect)).all(axis=(1, 2))
        return np.asarray(right & (letters == self.letters).all(axis=1))

    def reach(self, x: Floats, p: Floats, dx: Floats, dp: Floats) -> float:
        """Return the largest of 1, 1/2, 1/4, ... of a step after which each point has its letter; 0 for none."""
        if self.holds((x + dx)[None], (p + dp)[None])[0]:
            return 1.0
        t = SHARES[:, None]
        good = np.flatnonzero(self.holds(x + t * dx, p + t * dp))
        return float(SHARES[good[0]]) if len(good) else 0.0

    def ending(self, x: Floats, p: Floats, dx: Floats, dp: Floats, gap: float) -> Ending:
        """Say what is met from a solution in a direction."""
        return ending(self, x, p, dx, dp, gap)

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return by how much each point misses the image of the one before, and the derivative of that.

        NaN where a point has another letter: these are the equations of one piece of the map.
        """
        d, N = self.P.dimension, self.N
        if not np.isfinite(x).all():
            return np.full(N * d, np.nan), np.full((N * d, N * d), np.nan)
        images, J, _error, letters = self.stepped(x, p)
        if letters != self.letters:
            return np.full(N * d, np.nan), np.full((N * d, N * d), np.nan)
        wide = -np.eye(N * d)
        for j in range(N):
            k = (j + 1) % N
            wide[k * d : (k + 1) * d, j * d : (j + 1) * d] += J[j]
        return np.roll(images, 1, axis=0).ravel() - x, wide

    def turn(self, x: Floats, p: Floats) -> Floats:
        """Return the derivative of N steps at the first point."""
        return product(self.stepped(x, p).J)

    def turn_error(self, x: Floats, p: Floats) -> Floats:
        """Return by how much that may be off."""
        _images, J, error, _letters = self.stepped(x, p)
        return product_error(J, error)

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd, lp and ns of the turn, with the error that the differences leave."""
        _images, J, error, _letters = self.stepped(x, p)
        middle, *ends = (tests_of(product(one)) for one in (J, J - error, J + error))
        with np.errstate(invalid="ignore"):
            off = np.max(np.abs(np.array(ends) - middle), axis=0)
        kinds = ("pd", "lp", "ns") if self.P.dimension > 1 else ("pd", "lp")
        return tuple(Test(kind, value, -1, miss) for kind, value, miss in zip(kinds, middle, off.tolist(), strict=True))

    def broken(self, x: Floats, p: Floats) -> str:
        """Say nothing: where a point gets another letter the equations hold no longer."""
        return ""

    def orbit(self, x: Floats, p: Floats) -> Orbit:
        """Return the orbit; it is one of the map itself, so admissible as long as its letters are those of its word."""
        images, _steps, _error, letters = self.stepped(x, p)
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
            doubt=self.doubt(x, p, roots),
        )
