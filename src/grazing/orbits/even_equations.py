"""The equations of an orbit that is its own mirror image, in the first half of its impacts: regular where it breaks."""

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
    """Half of the equations of a symmetric orbit; the other impacts are N/2 T later, at the walls that its image meets.

    Where symmetry breaks, the equations of all impacts have a null vector that takes the two halves apart. It is none
    of these.
    """

    def __init__(self, base: ImpactEquations) -> None:
        self.base, self.names, self.N, self.spans = base, base.names, base.N, base.spans
        n, h = base.n, base.n // 2
        self._h, self._first = h, np.r_[:h, n : n + h]
        self._both = np.kron(np.eye(2), np.tile(np.eye(h), (2, 1)))
        self.scale = base.scale[self._first]

    def half(self, x: Floats, p: Floats) -> Floats:
        """Return the unknowns of an orbit of the base, or the nearest ones that are symmetric."""
        h, n, turn = self._h, self.base.n, self._turn(p)
        return 0.5 * np.append(x[:h] + x[h:n] - turn, x[n : n + h] + x[n + h :])

    def whole(self, x: Floats, p: Floats) -> Floats:
        """Return the unknowns of the base."""
        times, after = x[: self._h], x[self._h :]
        return np.concatenate([times, times + self._turn(p), after, after])

    def _turn(self, p: Floats) -> float:
        return self.N / 2 * self.base.period_at(p)

    def defects(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return the defects of the first half of the impacts, and their derivatives."""
        F, J = self.evaluated(x[None], p[None])
        return F[0], J[0]

    def evaluated(self, x: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Return :meth:`defects` at several points."""
        F, J = self.base.evaluated(np.array([self.whole(*one) for one in zip(x, p, strict=True)]), p)
        return F[:, self._first], (J @ self._both)[:, self._first]

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
    apart, even = base.mirrored(x, p), base.even()
    if even is None or apart is None or np.abs(apart).max() > EVEN:
        raise InputError(
            f"{shown(special)} cannot be followed: of branch points only those are at which symmetry breaks"
        )
    for j, name in enumerate(base.names):
        moved = p.copy()
        moved[j] += MOVED * base.spans[j]
        if base.mirrored(x, moved) is None:
            raise InputError(
                f"{name} takes the symmetry from the model, and the {special.type} with it; give another one"
            )
    return even, even.half(x, p)
