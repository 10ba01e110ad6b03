"""The closing equations of a ball that goes round a word of surfaces on a table, in places of impacts and flight times.

Impact i of n is at the coordinate u_i of a surface, the angle of a circle or the foot on a face, at which the ball's
centre is at p_i(u_i), with normal n_i and T_i, n_i turned by a quarter; its flight to the next one takes tau_i. With
d_i = p_(i+1) - p_i and a = (0, -g) it leaves with w_i and comes to the next impact with b_(i+1),

    w_i = d_i/tau_i - a tau_i/2,    b_(i+1) = d_i/tau_i + a tau_i/2,

so that it lands by definition, and 2n equations say what the impacts do:

    T_i.(w_i - b_i) = 0,    n_i.w_i - law_i(n_i.b_i) = 0.

Nothing is singular at a graze, where n_i.b_i = 0. Where every law of the word is elastic the second ones follow from
each other but for their signs, and orbits come in families by their energy; the equations |w_i|^2/2 + g y_i = E take
their place. On a level table, a = 0, energy sets the scale of speed only: E = 1/2, and times are lengths.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.objects import DRAIN, Thing
from grazing.billiard.rows import ANGLE, EX, EY, LONG, OWNER, PX, PY, SIGN, SIZE, surfaces_of
from grazing.billiard.table import Table
from grazing.orbits.one_sided import EPS
from grazing.oscillator.reset import Reset
from grazing.parameter import parameters

Floats = NDArray[np.float64]
#: Speeds at which a law is held against the elastic one.
TRIED = 0.5 ** np.arange(-3.0, 20.0)
#: Newton steps after which an orbit counts as not found; part of a flight's time that a step leaves of it, at least.
STEPS, LEFT = 60, 0.25


class Surface(NamedTuple):
    """A surface of the ball's centre: its number in the march, its object, a point, size and side, its coordinate."""

    number: int
    owner: int
    x: float
    y: float
    size: float
    sign: float
    round: bool
    ex: float
    ey: float
    low: float
    high: float

    @property
    def whole(self) -> bool:
        """Whether it goes all around."""
        return self.round and self.high - self.low > 2.0 * np.pi * (1.0 - 1e-14)

    def holds(self, u: float) -> bool:
        """Whether a coordinate lies on it."""
        turned = self.low + (u - self.low) % (2.0 * np.pi) if self.round else u
        return self.whole or self.low <= turned <= self.high


def solid_surfaces(table: Table) -> tuple[Surface, ...]:
    """Return the surfaces of all objects but drains, in the order of their numbers."""
    rows, found = surfaces_of(table.objects, table.rho, table.params), []
    for i, row in enumerate(rows.faces.tolist()):
        if table.objects[int(row[OWNER])].kind != DRAIN:
            for side in range(2):
                at = row[PX], row[PY], row[SIZE], 2.0 * side - 1.0
                found.append(Surface(2 * i + side, int(row[OWNER]), *at, False, row[EX], row[EY], 0.0, row[LONG]))
    for i, row in enumerate([*rows.circles.tolist(), *rows.sides.tolist()], 2 * len(rows.faces)):
        sign = row[SIGN] if i >= 2 * len(rows.faces) + len(rows.circles) else 1.0
        ends = sorted((row[ANGLE], row[ANGLE] + sign * row[LONG] / row[SIZE]))
        at = row[PX], row[PY], row[SIZE], sign
        found.append(Surface(i, int(row[OWNER]), *at, True, 0.0, 0.0, ends[0], ends[1]))
    return tuple(found)


def by_number(law: Callable[..., float], params: object) -> Callable[[Floats], Floats]:
    """Return a law, or its slope, of many velocities at once; NaN where it gives no number.

    Newton's method asks for velocities away from the surface as well, at which a law need not be defined.
    """

    def one(v: float) -> float:
        try:
            return float(law(v, params))
        except Exception:  # of a law of one's own
            return float("nan")

    each = np.frompyfunc(one, 1, 1)

    def many(v: Floats) -> Floats:
        return np.asarray(each(v), np.float64)

    return many


def elastic(law: Reset | None) -> bool:
    """Say whether a law turns the velocity round and changes nothing else, at every speed that is tried."""
    return law is not None and bool((by_number(law.law, parameters(law.params))(-TRIED) == TRIED).all())


def conserves(things: Sequence[Thing]) -> bool:
    """Whether impacts with all of these objects conserve energy."""
    return all(elastic(one.law) for one in things)


class Bounces:
    """The equations of a word of surfaces on a table.

    Parameters
    ----------
    table : Table
    word : sequence of Surface
        In the order in which they are hit.
    energy : float, optional
        E, for a word whose impacts conserve it; None for the equations with the laws.
    """

    def __init__(self, table: Table, word: Sequence[Surface], energy: float | None = None) -> None:
        self.table, self.word, self.energy, self.n = table, tuple(word), energy, len(word)
        self.g = table.gravity
        columns = np.array([(s.x, s.y, s.size, s.sign, s.round, s.ex, s.ey) for s in word], np.float64).T
        self.centre, (self.size, self.sign, self.q), self.e = columns[:2], columns[2:5], columns[5:]
        self.rows = np.arange(self.n)
        self.before, self.after = (self.rows - 1) % self.n, (self.rows + 1) % self.n

    @cached_property
    def _laws(self) -> list[tuple[Callable[[Floats], Floats], Callable[[Floats], Floats]]]:
        found = []
        for one in self.word:
            law = self.table.objects[one.owner].law
            assert law is not None
            p = parameters(law.params)
            found.append((by_number(law.law, p), by_number(law.slope, p)))
        return found

    def slopes(self, coming: Floats) -> list[float]:
        """Return the slopes of the laws at the velocities (n,) along the normals just before the impacts."""
        return [float(bend(v)) for (_law, bend), v in zip(self._laws, coming, strict=True)]

    def frames(self, u: Floats) -> tuple[Floats, Floats, Floats]:
        """Return places p, normals and dp/du along T of coordinates (..., n): (..., 2, n) twice, and (n,)."""
        flat = np.empty((*u.shape[:-1], 2, self.n))
        flat[..., 0, :], flat[..., 1, :] = np.cos(u), np.sin(u)
        normal = np.where(self.q, flat * self.sign, self._flat_normals)
        way = np.where(self.q, self.size * flat, u[..., None, :] * self.e + self.size * normal)
        return self.centre + way, normal, np.where(self.q, self.size * self.sign, self.sign)

    @cached_property
    def _flat_normals(self) -> Floats:
        return np.asarray(np.stack([self.e[1], -self.e[0]]) * self.sign)

    def velocities(self, x: Floats) -> tuple[Floats, Floats]:
        """Return the velocities just after and just before the impacts of unknowns (..., 2n), (..., 2, n) each."""
        return self._flown(self.frames(x[..., : self.n])[0], x[..., None, self.n :])

    def _flown(self, p: Floats, tau: Floats) -> tuple[Floats, Floats]:
        """Return these velocities of flights between places (..., 2, n) that take times (..., 1, n)."""
        mean, fall = (p[..., self.after] - p) / tau, np.array([[0.0], [0.5 * self.g]]) * tau
        return mean + fall, (mean - fall)[..., self.before]

    def defects(self, x: Floats) -> tuple[Floats, Floats]:
        """Return the defects (k, 2n) of unknowns (k, 2n), and their derivatives (k, 2n, 2n)."""
        n, k, i, before, after = self.n, len(x), self.rows, self.before, self.after
        u, tau = x[:, :n], x[:, None, n:]
        p, normal, m = self.frames(u)
        T = np.empty_like(normal)
        T[:, 0], T[:, 1] = -normal[:, 1], normal[:, 0]
        w, b = self._flown(p, tau)
        ahead = (p[..., after] - p) / tau**2  # -d w/d tau, less gravity's part
        half = np.array([[0.0], [0.5 * self.g]])
        F, J = np.empty((k, 2 * n)), np.zeros((k, 2 * n, 2 * n))
        along, away, coming = (np.einsum("kcn,kcn->kn", *pair) for pair in ((T, w - b), (normal, w), (normal, b)))
        F[:, :n] = along
        slope = np.zeros((k, n))
        if self.energy is None:
            for at, (law, bend) in enumerate(self._laws):
                F[:, n + at], slope[:, at] = away[:, at] - law(coming[:, at]), bend(coming[:, at])
        else:
            F[:, n:] = 0.5 * dot(w, w) + self.g * p[:, 1] - self.energy
        # velocities change with (u_i, u_next, tau_i) and with (u_last, u_i, tau_last)
        turned = m * T
        into = tau[..., before]
        dw = (i, -turned / tau), (after, turned[..., after] / tau), (n + i, half - ahead)
        db = (before, -turned[..., before] / into), (i, turned / into), (n + before, -half - ahead[..., before])
        J[:, i, i] -= self.q * (away - coming)
        lead = normal if self.energy is None else w
        for j, change in dw:
            J[:, i, j] += dot(T, change)
            J[:, n + i, j] += dot(lead, change)
        for j, change in db:
            J[:, i, j] -= dot(T, change)
            if self.energy is None:
                J[:, n + i, j] -= slope * dot(normal, change)
        if self.energy is None:
            J[:, n + i, i] += self.q * (dot(T, w) - slope * dot(T, b))
        else:
            J[:, n + i, i] += self.g * m * T[:, 1]
        return F, J

    def rounded(self, x: Floats) -> Floats:
        """Return by how much rounding may move the defects (2n,) of unknowns (2n,)."""
        (w, b), places = self.velocities(x), self.frames(x[: self.n])[0]
        speeds = np.hypot(*w) + np.hypot(*b)
        if self.energy is None:
            return EPS * np.tile(speeds, 2)
        return EPS * np.concatenate([speeds, speeds**2 + np.abs(self.g * places[1]) + abs(self.energy)])

    @property
    def scale(self) -> Floats:
        """The size of each coordinate u, (n,): a radian, or the length of a face."""
        return np.array([1.0 if s.round else s.high for s in self.word])

    def solve(self, guesses: Floats) -> Floats:
        """Solve by Newton's method from each row of guesses (k, 2n), which they become; scaled defects, NaN for none.

        A step turns no angle by more than half a radian, and leaves of each time a quarter at least.
        """
        n = self.n
        worst, going, before = np.full(len(guesses), np.nan), np.arange(len(guesses)), np.full(len(guesses), np.inf)
        for _ in range(STEPS):
            if len(going) == 0:
                break
            x = guesses[going]
            with np.errstate(all="ignore"):
                F, J = self.defects(x)
            good = np.isfinite(F).all(1) & np.isfinite(J).all((1, 2))
            x, F, J, going = x[good], F[good], J[good], going[good]
            size = np.abs(J * np.concatenate([np.broadcast_to(self.scale, x[:, :n].shape), x[:, n:]], 1)[:, None]).max(
                2
            )
            size = np.where(size > 0.0, size, 1.0)
            move = stepped(J / size[..., None], F / size)
            parts = np.concatenate([2.0 * np.abs(move[:, :n]) / self.scale, move[:, n:] / x[:, n:] / (1.0 - LEFT)], 1)
            share = 1.0 / np.maximum(parts.max(1, initial=0.0), 1.0)
            guesses[going] = x - share[:, None] * move
            length = np.abs(np.concatenate([move[:, :n] / self.scale, move[:, n:] / x[:, n:]], 1)).max(1)
            arrived = (length <= 1e-15) | ((length <= 1e-9) & (length >= 0.25 * before[going]))
            worst[going[arrived]] = np.abs(F / size).max(1)[arrived]
            before[going] = length
            going = going[~arrived & (length < 1e6)]
        return worst


def dot(a: Floats, b: Floats) -> Floats:
    """Return the products of vectors (k, 2) or (k, 2, n): of two terms, for which a sum along an axis takes long."""
    return np.asarray(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])


def stepped(J: Floats, F: Floats) -> Floats:
    """Return Newton steps (k, n); NaN where a derivative is singular."""
    try:
        return np.asarray(np.linalg.solve(J, F[..., None])[..., 0])
    except np.linalg.LinAlgError:
        found = np.full(F.shape, np.nan)
        for i in range(len(F)):
            try:
                found[i] = np.linalg.solve(J[i], F[i])
            except np.linalg.LinAlgError:
                continue
        return found
