"""The orbits along a path, made of its solutions when they are asked for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from grazing.copies import alike
from grazing.orbits.equations import Equations
from grazing.orbits.orbit import Orbit

Floats = NDArray[np.float64]


class Solved(Sequence[Orbit]):
    """Orbits of solutions of one set of equations, in order; each is made once, when it is first asked for.

    To make an orbit takes as long as to find its point did, and most are never looked at. A copy has all of them made,
    and holds no equations.
    """

    def __init__(self, orbits: Iterable[Orbit | tuple[Floats, Floats]], equations: Equations | None = None) -> None:
        self._each = list(orbits)
        self._equations = equations

    def __len__(self) -> int:
        return len(self._each)

    @overload
    def __getitem__(self, place: int) -> Orbit: ...

    @overload
    def __getitem__(self, place: slice) -> tuple[Orbit, ...]: ...

    def __getitem__(self, place: int | slice) -> Orbit | tuple[Orbit, ...]:
        if isinstance(place, slice):
            return tuple(self[i] for i in range(len(self))[place])
        found = self._each[place]
        if isinstance(found, tuple):
            assert self._equations is not None
            found = self._each[place] = self._equations.orbit(*found)
        return found

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Solved) and alike(tuple(self), tuple(other))

    def __hash__(self) -> int:
        return hash(tuple(self))

    def __repr__(self) -> str:
        return repr(tuple(self))

    def __reduce__(self) -> Any:
        return Solved, (tuple(self),)
