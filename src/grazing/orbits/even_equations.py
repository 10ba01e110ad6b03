"""The equations of an orbit that is its own mirror image, in the first part of its impacts: regular where it breaks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.equations import Equations, Test
from grazing.orbits.orbit import Orbit
from grazing.orbits.special import Special
from grazing.outcome import InputError, shown

if TYPE_CHECKING:
    from grazing.orbits.impact_equations import ImpactEquations

Floats = NDArray[np.float64]
#: An orbit this near to its mirror image, in scaled unknowns, at a branch point is its own one there.
EVEN = 1e-3
#: Part of a parameter's range by which it is moved to see whether the model stays symmetric.
MOVED = 1e-4


class EvenEquations(Equations):
    """The equations of one part of a symmetric orbit, of m; those after it do the same, N/m T later each time.

    They are at the walls that its images meet. Where symmetry breaks, the equations of all impacts have a null vector
    that takes the parts apart. It is none of these.
    """

    def __init__(self, base: ImpactEquations, m: int) -> None:
        self.base, self.names, self.N, self.spans, self.m = base, base.names, base.N, base.spans, m
        n, h = base.n, base.n // m
        self._h, self._first = h, np.r_[:h, n : n + h]
        self._all = np.kron(np.eye(2), np.tile(np.eye(h), (m, 1)))
        self.scale = base.scale[self._first]

    def part(self, x: Floats, p: Floats) -> Floats:
        """Return the unknowns of an orbit of the base, or the nearest ones that are symmetric."""
        return np.asarray((x.reshape(2, self.m, self._h) - self._late(p)).mean(axis=1).ravel())

    def whole(self, x: Floats, p: Floats) -> Floats:
        """Return the unknowns of the base."""
        return np.asarray((x.reshape(2, 1, self._h) + self._late(p)).ravel())

    def _late(self, p: Floats) -> Floats:
        """Return by how much each part is later than the first one, (2, m, 1): its times, not its velocities."""
        late = np.zeros((2, self.m, 1))
        late[0, :, 0] = self.N / self.m * self.base.period_at(p) * np.arange(self.m)
        return late

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return the defects of the first part of the impacts, and their derivatives."""
        F, J = self.evaluated(x[None], p[None])
        return F[0], J[0]

    def evaluated(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return :meth:`defects` at several points."""
        F, J = self.base.evaluated(np.array([self.whole(*one) for one in zip(x, p, strict=True)]), p)
        return F[:, self._first], (J @ self._all)[:, self._first]

    def heights(self, x: Floats, p: Floats, index: int, kind: tuple[str, int]) -> Floats:
        """Return a test function at several points."""
        return self.base.heights(np.array([self.whole(*one) for one in zip(x, p, strict=True)]), p, index, kind)

    def tests(self, x: Floats, p: Floats) -> tuple[Test, ...]:
        """Return the test functions of the orbit: *lp* is zero where symmetry breaks, too."""
        return self.base.tests(self.whole(x, p), p)

    def touched(self, type: str, where: int) -> tuple[int, int]:
        """Return which impact or flight a test function is about, and the number of its wall."""
        return self.base.touched(type, where)

    def called(self, type: str, where: int, p: Floats) -> tuple[str, str]:
        """Return the type of a special point, and the letter of its wall."""
        return self.base.called(type, where, p)

    def broken(self, x: Floats, p: Floats) -> str:
        """Say why these are not the equations of an orbit any more."""
        return self.base.broken(self.whole(x, p), p)

    def orbit(self, x: Floats, p: Floats) -> Orbit:
        """Return the orbit."""
        return self.base.orbit(self.whole(x, p), p)


def evenly(special: Special, base: Equations, x: Floats, p: Floats) -> tuple[EvenEquations, Floats]:
    """Return the equations of the symmetric orbit at a point where symmetry breaks, and its unknowns.

    Raises
    ------
    InputError
        For another branch point, and for parameters that take the symmetry from the model.
    """
    even = base.even(x, p)
    if even is None:
        raise InputError(
            f"{shown(special)} cannot be followed: of branch points only those are at which symmetry breaks"
        )
    for j, name in enumerate(base.names):
        moved = p.copy()
        moved[j] += MOVED * base.spans[j]
        if even.m not in base.images(x, moved):
            raise InputError(
                f"{name} takes the symmetry from the model, and the {special.type} with it; give another one"
            )
    return even, even.part(x, p)
