"""What a branch needs to know of the equations that it follows: defects, derivatives, test functions, the orbit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.orbit import Orbit
from grazing.outcome import InputError

if TYPE_CHECKING:
    from grazing.orbits.even_equations import EvenEquations

Floats = NDArray[np.float64]

#: Solutions of the same parameters that differ by less, in scaled unknowns, are one.
ONE = 1e-5
#: Where parameters are moved to, in one distance, for their derivatives of fourth order.
AROUND = (1.0, -1.0, 2.0, -2.0)


class Test(NamedTuple):
    """A function that is zero where something happens to an orbit.

    Parameters
    ----------
    type : str
        What happens: lp pd ns bp gr bcb v0 law st.
    value : float
        Positive where it has not happened yet, for tests of stability and admissibility.
    where : int
        Which impact, flight or point of the orbit it is about; -1 for the whole orbit.
    error : float
        By how much the value may be off, where it rests on differences.
    """

    type: str
    value: float
    where: int = -1
    error: float = 0.0


class Ending(NamedTuple):
    """What a path meets where its equations end.

    The type, empty if nothing is known; which point; by how much the scaled parameter may be off; and the equations
    that hold beyond, with a point next to their solution, if the map is smooth there. ``turned`` is what unknowns lose
    there that come round, as phases do.
    """

    type: str
    where: int
    error: float
    beyond: tuple[Equations, Floats, Floats] | None = None
    turned: float | Floats = 0.0


class Across(NamedTuple):
    """The equations and the unknowns of an orbit whose point at a border has the other letter.

    ``close`` says whether the map is continuous there, ``smooth`` whether it has one slope too.
    """

    equations: Equations
    x: Floats
    close: bool
    smooth: bool


class Equations(ABC):
    """Equations F(x, p) = 0 of an orbit, with as many unknowns x as equations, and parameters p by name.

    ``names`` are the parameters that vary and ``N`` is the period. ``scale`` is the size of each unknown, ``spans``
    that of each parameter: with them a step along a branch has a length. ``pieced`` equations hold on one piece of a
    map only; they say how far they ``reach``, and what their ``ending`` is.
    """

    pieced = False
    #: How often the way between two neighbouring points of a piece is looked at.
    looks = 16
    #: What begins other branches at a graze or at a border, see :func:`grazing.orbits.switching.partners`.
    others = "grazing.orbits.switching:flipped"
    #: Whether a solution with a multiplier 1 is one of a continuum, as it is of linear equations.
    linear = False

    names: tuple[str, ...]
    N: int
    scale: Floats
    spans: Floats

    @abstractmethod
    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return F, shape (n,), and dF/dx, shape (n, n); NaN where they are not defined."""

    @abstractmethod
    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return the test functions at a solution, always the same ones in the same order."""

    @abstractmethod
    def broken(self, x: Floats, p: Floats) -> str:
        """Say why these are not the equations of an orbit any more, such as a flight of no time; empty if they are."""

    @abstractmethod
    def orbit(self, x: Floats, p: Floats) -> Orbit:
        """Return the orbit of a solution, checked in full."""

    def turned_to(self, x: Floats, p: Floats, like: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """Return the solution, begun at another point or period, that is nearest to another, and its order."""
        return x, np.arange(len(x))

    def halved(self, x: Floats, p: Floats) -> Floats | None:
        """Return by how much the two halves of an orbit differ, scaled; None where they cannot be the same."""
        return None

    def images(self, x: Floats, p: Floats) -> dict[int, Floats]:
        """Return by how much an orbit differs, scaled, from its images, by the number of parts it could be made of."""
        return {}

    def reflections(self, x: Floats, p: Floats) -> list[Floats]:
        """Return the images of an orbit, each begun at the impact that the first one is to it."""
        return []

    def even(self, x: Floats, p: Floats) -> EvenEquations | None:
        """Return the equations of the orbits that are their own images, as this one nearly is; None where it is not."""
        return None

    def doubling(self, x: Floats, p: Floats) -> tuple[Equations, Floats]:
        """Return the equations of two turns, and the solution that goes round twice."""
        raise InputError("an orbit without impacts has no period doubling: its free flight is linear")

    def halving(self, x: Floats, p: Floats) -> tuple[Equations, Floats]:
        """Return the equations of half the turns, and the mean of both halves of a solution."""
        raise NotImplementedError

    def later(self, x: Floats, p: Floats, k: int) -> Floats | None:
        """Return by how much an orbit differs, scaled, if begun a k-th of its turn later; None for one that cannot."""
        return None

    def alike(self, other: Equations) -> bool:
        """Whether other equations are of the same kind, for as many steps."""
        return type(other) is type(self) and other.N == self.N

    def same(self, x: Floats, other: Equations, y: Floats, p: Floats) -> bool:
        """Whether a solution is one orbit with another, begun at another impact or point perhaps."""
        return len(x) == len(y) and any(
            bool(np.abs((np.roll(y, k) - x) / self.scale).max() < ONE) for k in range(len(x))
        )

    def called(self, type: str, where: int, p: Floats) -> tuple[str, str]:
        """Return the type of a special point, and the letter of the wall that it is about; empty for none."""
        return type, ""

    def across(self, x: Floats, p: Floats, where: int) -> Across | None:
        """Return the equations of an orbit whose point at a border has the other letter; None where there are none."""
        return None

    def strobes(self, x: Floats, p: Floats) -> Floats | None:
        """Return when impacts happen at several points, x (k, n) and p (k, names), in periods; None where none do.

        From one strobe to the next one: orbits whose impacts stay between their strobes have the same word.
        """
        return None

    def begins_in(self, x: Floats, p: Floats) -> int:
        """Return how many periods after the first one a solution has its first impact."""
        return 0

    def touched(self, type: str, where: int) -> tuple[int, int]:
        """Return which impact, flight or point a test function is about, and the number of its wall; -1 for none."""
        return where, -1

    def holds(self, x: Floats, p: Floats, defect: float = np.inf) -> NDArray[np.bool_]:
        """Whether these are the equations at each of several points, x (k, n) and p (k, names), with small defects."""
        return np.ones(len(x), np.bool_)

    def reach(self, x: Floats, p: Floats, dx: Floats, dp: Floats) -> float:
        """Return the part of a step from a point where the equations hold after which they hold still."""
        return 1.0

    def ending(self, x: Floats, p: Floats, dx: Floats, dp: Floats, gap: float) -> Ending:
        """Say what is met from a solution in a direction, in which there is no other one farther than ``gap``."""
        return Ending("", -1, 0.0)

    def evaluated(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return :meth:`defects` at several points, x (k, n) and p (k, names): shapes (k, n) and (k, n, n)."""
        found = [self.defects(*one) for one in zip(x, p, strict=True)]
        return np.array([F for F, _J in found]), np.array([J for _F, J in found])

    def rounded(self, x: Floats) -> Floats:
        """Return by how much rounding of what defects are the difference of may move them, which probes do not see."""
        return np.zeros_like(x)

    def heights(self, x: Floats, p: Floats, index: int, kind: tuple[str, int]) -> Floats:
        """Return a test function (k,) by its place at several points, x (k, n) and p (k, names).

        NaN where the one there is not of this type and about this impact, flight or point: then the tests are others.
        """
        found = np.full(len(x), np.nan)
        for i, one in enumerate(zip(x, p, strict=True)):
            tests = self.tests(*one)
            if index < len(tests) and tests[index][::2] == kind:
                found[i] = tests[index].value
        return found

    def expanded(self, x: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
        """Return F, dF/dx and dF/dp, shape (n, len(names)).

        The last by differences of fourth order; one-sided at the end of a range.
        """
        h = 1e-3 * np.minimum(self.spans, np.maximum(np.abs(p), 1e-3 * self.spans))
        F, J = self.evaluated(*beside(x, p, around(len(h)) * h))
        forward, back, ahead, behind = F[1:].reshape(len(AROUND), len(h), -1)
        columns = (8.0 * (forward - back) - (ahead - behind)) / (12.0 * h[:, None])
        known = np.isfinite(columns)
        if not known.all():
            for j in np.flatnonzero(~known.all(axis=1)):
                columns[j] = self._one_sided(x, p, np.eye(len(h))[j] * h, float(h[j]))
        return F[0], J[0], columns.T

    def _one_sided(self, x: Floats, p: Floats, shift: Floats, h: float) -> Floats:
        """Return one column of dF/dp from values on the side where the parameter is allowed."""
        for side in (1.0, -1.0):
            F = self.evaluated(*beside(x, p, side * np.outer(np.arange(5.0), shift)))[0]
            if np.isfinite(F).all():
                found = -25.0 * F[0] + 48.0 * F[1] - 36.0 * F[2] + 16.0 * F[3] - 3.0 * F[4]
                return np.asarray(side * found / (12.0 * h))
        return np.full(len(x), np.nan)


@lru_cache(maxsize=16)
def around(names: int) -> Floats:
    """Return where each parameter is moved to by itself, in its own distance: nowhere, then :data:`AROUND`."""
    return np.concatenate([np.zeros((1, names)), *(one * np.eye(names) for one in AROUND)])


def beside(x: Floats, p: Floats, shifts: Floats) -> tuple[Floats, Floats]:
    """Return the same unknowns (k, n) at shifted parameters (k, names)."""
    return np.repeat(x[None], len(shifts), axis=0), p + shifts
