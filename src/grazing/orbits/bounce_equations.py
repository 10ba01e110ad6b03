"""The closing equations of an orbit on a table as a branch follows them, with what happens on the way."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.table import Table
from grazing.maps.map import Map
from grazing.orbits.bounce_orbit import BounceOrbit, bounce_orbit, steps_of
from grazing.orbits.bounces import Bounces, Surface, solid_surfaces
from grazing.orbits.equations import Equations, Test
from grazing.orbits.map_equations import product, product_error, tests_of
from grazing.orbits.one_sided import EPS
from grazing.orbits.point_equations import PointEquations
from grazing.outcome import InputError
from grazing.parameter import unknown

Floats = NDArray[np.float64]
#: Shortest flight, as a part of the mean of its orbit: beyond, two impacts have become one.
SHORTEST = 1e-9
#: Part of a flight at either end in which its distance from a surface has no least value that counts.
ENDS = 1e-9


class BounceEquations(PointEquations):
    """The equations of :class:`grazing.orbits.bounces.Bounces` in parameters of the table.

    Unknowns are the coordinate of each impact and the time of the flight after it, one impact after the other; its
    letter is the number of the surface.

    Parameters
    ----------
    P : Map
        The collision map; gives the values of all parameters that do not vary.
    names : tuple of str
        Parameters that vary.
    letters : tuple of int
        The surfaces that are hit.
    spans : array_like
        Size of each parameter that varies.
    energy : float or None
        Where it is conserved.
    duration : float
        About how long a flight takes.
    """

    def __init__(
        self, P: Map, names: tuple[str, ...], letters: tuple[int, ...], spans: Any = None,
        energy: float | None = None, duration: float = 1.0,
    ) -> None:  # fmt: skip
        for name in names:
            if name not in P.params:
                raise unknown(name, P.params, P.name or "the map")
        self.P, self.names, self.letters, self.N = P, names, letters, len(letters)
        self.energy, self.duration = energy, duration
        self.spans = np.ones(len(names)) if spans is None else np.asarray(spans, np.float64)
        self.size = np.array([high - low for low, high in P.box])
        self._held: tuple[bytes, Bounces, tuple[Surface, ...]] | None = None
        here = self.at(np.array([P.params[name] for name in names]))
        self.scale = interleaved(np.concatenate([here.scale, np.full(self.N, duration)]))

    def like(self, letters: tuple[int, ...]) -> Self:
        """Return the equations of other surfaces in the same parameters."""
        return type(self)(self.P, self.names, letters, self.spans, self.energy, self.duration)

    def at(self, p: Floats) -> Bounces:
        """Return the equations at values of the parameters; InputError where there is no such table."""
        key = np.asarray(p, np.float64).tobytes()
        if self._held is None or self._held[0] != key:
            table: Table = self.P.origin.impacts_on.replace(**dict(zip(self.names, map(float, p), strict=True)))
            every = solid_surfaces(table)
            by_number = {surface.number: surface for surface in every}
            word = [by_number[number] for number in self.letters]
            self._held = key, Bounces(table, word, self.energy), every
        return self._held[1]

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return F and dF/dx; NaN for flights of no time, and where there is no such table."""
        n = 2 * self.N
        if not (x[1::2] > 0.0).all():
            return np.full(n, np.nan), np.full((n, n), np.nan)
        try:
            F, J = self.at(p).defects(apart(x)[None])
        except InputError:
            return np.full(n, np.nan), np.full((n, n), np.nan)
        return F[0], J[0][:, interleaved(np.arange(n))]

    def rounded(self, x: Floats) -> Floats:
        """Return by how much rounding may move the defects: of speeds that are nearly equal it leaves a plateau.

        Next to a law that takes hardly any speed, and gives as little, defects are 0 all over the reach of the probes.
        """
        assert self._held is not None
        return self._held[1].rounded(apart(x))

    def expanded(self, x: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
        """Return F, dF/dx and dF/dp: closed forms go on beyond the ends of objects, so that differences may."""
        return Equations.expanded(self, x, p)

    def slopes(self, x: Floats, p: Floats) -> Floats:
        """Return dF/dp."""
        return self.expanded(x, p)[2]

    def turn(self, x: Floats, p: Floats) -> Floats:
        """Return the derivative (3, 3) of one turn at the first impact."""
        return product(steps_of(self.at(p), apart(x)))

    def turn_error(self, x: Floats, p: Floats) -> Floats:
        """Return by how much that may be off: rounding."""
        steps = steps_of(self.at(p), apart(x))
        return product_error(steps, 4.0 * EPS * np.abs(steps))

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return pd, lp and, where energy is not conserved, ns of the turn; each impact's speed; each flight's dips.

        The turn has a pole where the speed of an impact is zero. It is taken away, so that no test jumps there.
        """
        bounces, y = self.at(p), apart(x)
        _p, normal, _m = bounces.frames(x[::2])
        _w, b = bounces.velocities(y)
        speeds = -(normal * b).sum(0) / np.hypot(*b)
        pole = float(np.prod(speeds))
        J, off = self.turn(x, p), self.turn_error(x, p)
        if self.energy is None:
            sizes = np.array([pole, pole, pole * pole])
            values = np.array(tests_of(J))
            moved = np.array([tests_of(J + one) for one in np.diag(off.ravel()).reshape(-1, 3, 3)])
            errors = np.abs(moved - values).sum(axis=0)  # ns is 0 all along where the map keeps areas
            found = [
                Test(kind, float(value), -1, float(error))
                for kind, value, error in zip(("pd", "lp", "ns"), values * sizes, errors * np.abs(sizes), strict=True)
            ]
        else:
            trace, error = float(np.trace(J)) - 1.0, abs(pole) * float(np.trace(off))
            found = [Test("pd", pole * (2.0 + trace), -1, error), Test("lp", pole * (2.0 - trace), -1, error)]
        found += [Test("v0", float(speed), i) for i, speed in enumerate(speeds)]
        assert self._held is not None
        found += [Test("gr", dip, i) for i, dip in enumerate(dips(bounces, y, self._held[2]))]
        return tuple(found)

    def broken(self, x: Floats, p: Floats) -> str:
        """Say whether two impacts have become one, or one has left its surface at an end."""
        if not (x[1::2] > SHORTEST * self.duration).all():
            return "two impacts have become one: the flight between them takes no time"
        names = self.P.origin.impacts_on.names
        for u, surface in zip(x[::2].tolist(), self.at(p).word, strict=True):
            if not surface.holds(u):
                return f"an impact has left {names[surface.owner]} at an end"
        return ""

    def orbit(self, x: Floats, p: Floats) -> BounceOrbit:
        """Return the orbit of a solution, flown by the collision map."""
        values = dict(zip(self.names, map(float, p), strict=True))
        return bounce_orbit(self.P.replace(**values), self.at(p), apart(x))


def interleaved(x: Any) -> Any:
    """Return places and times (2n,), one after the other, by impact."""
    return np.reshape(x, (2, -1)).T.ravel()


def apart(x: Floats) -> Floats:
    """Return unknowns by impact as places, then times."""
    return x.reshape(-1, 2).T.ravel()


def equations_of_bounces(orbit: BounceOrbit, names: tuple[str, ...], spans: Any) -> tuple[BounceEquations, Floats]:
    """Return the equations that an orbit solves in these parameters, and its unknowns."""
    energy, duration = orbit.energy if orbit.conserves else None, float(orbit.durations.mean())
    equations = BounceEquations(orbit.map, names, orbit.surfaces, spans, energy, duration)
    return equations, interleaved(np.concatenate([orbit.along, orbit.durations]))


def dips(bounces: Bounces, x: Floats, every: tuple[Surface, ...]) -> list[float]:
    """Return for each flight its least distance from a surface on the way, in sizes of that; 1 where none is nearer.

    Least values count that lie between the ends of the flight; negative ones where it passes through an object. Of the
    two sides of a segment or an arc that counts from which the ball comes to the least value, and to which it goes.
    """
    n, g = bounces.n, bounces.g
    p, _normal, _m = bounces.frames(x[:n])
    w, _b = bounces.velocities(x)
    found = []
    for i, ((px, py), (vx, vy), tau) in enumerate(zip(p.T.tolist(), w.T.tolist(), x[n:].tolist(), strict=True)):
        least, own = 1.0, (bounces.word[i], bounces.word[(i + 1) % n])
        for one in every:
            dx, dy = px - one.x, py - one.y
            times = turning(dx, dy, vx, vy, g) if one.round else face_turning(one, vx, vy, g)
            inside = sorted(t for t in times if ENDS * tau < t < (1.0 - ENDS) * tau)
            places = [(dx + vx * t, dy + (vy - 0.5 * g * t) * t) for t in (0.0, *inside, tau)]
            sides = [side_of(one, bounces.table.rho, *place) for place in places]
            for k, end in ((0, own[0]), (-1, own[1])):
                if (end.owner, end.x, end.y, end.round) == (one.owner, one.x, one.y, one.round):  # rounding moves it
                    sides[k] = 1.0 if end.sign == one.sign else -1.0
            for k, place in enumerate(places[1:-1], 1):
                if sides[k - 1] > 0.0 and sides[k + 1] > 0.0:
                    least = min(least, distance_from(one, bounces.table.rho, *place))
        found.append(least)
    return found


def side_of(one: Surface, rho: float, dx: float, dy: float) -> float:
    """Return what is > 0 where a place, seen from the point of a surface, is on its side of the object."""
    if one.round:
        return one.sign * (float(np.hypot(dx, dy)) - one.size) + rho
    return one.sign * (one.ey * dx - one.ex * dy)


def turning(dx: float, dy: float, vx: float, vy: float, g: float) -> list[float]:
    """Return the times at which the distance of a flight from a point has a least or greatest value."""
    c = [0.5 * g * g, -1.5 * vy * g, vx * vx + vy * vy - g * dy, dx * vx + dy * vy]
    if g == 0.0:
        return [-c[3] / c[2]]
    roots = np.roots(c)
    return [float(r.real) for r in roots if abs(r.imag) <= 1e-12 * (1.0 + abs(r.real))]


def face_turning(face: Surface, vx: float, vy: float, g: float) -> list[float]:
    """Return the time at which the distance of a flight from the line of a face is least; none where it is greatest."""
    nx, ny = face.sign * face.ey, -face.sign * face.ex
    return [(vx * nx + vy * ny) / (g * ny)] if g * ny < 0.0 else []


def distance_from(one: Surface, rho: float, dx: float, dy: float) -> float:
    """Return how far a place, seen from the point of a surface, is in front of it in its sizes; 1 if beside it.

    Nothing is beside a free end: where the ball is nearer to what ends there, it is in front of that.
    """
    if one.round:
        end = one.sign > 0.0 and one.size <= rho
        beside = not one.whole and not end and not one.holds(float(np.arctan2(dy, dx)))
        return 1.0 if beside else one.sign * (float(np.hypot(dx, dy)) - one.size) / one.size
    out, foot = one.sign * (one.ey * dx - one.ex * dy), dx * one.ex + dy * one.ey
    return (out - one.size) / one.high if 0.0 <= foot <= one.high else 1.0
