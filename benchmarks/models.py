"""The models that every program computes, and the family of orbits that the speeds are measured on."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Model:
    """u'' + alpha u' + k^2 u = d + sum_j cos[j-1] cos(j omega t) + sin[j-1] sin(j omega t) above u = 0.

    An impact turns the velocity v into -r v + V. The constant force d belongs to the orbit, not to the model. With a
    ``gap`` a second wall like the first, its mirror image, is above the ball, at u = gap.
    """

    name: str
    alpha: float
    k: float
    omega: float
    r: float
    V: float
    cos: tuple[float, ...] = (1.0,)
    sin: tuple[float, ...] = (0.0,)
    gap: float | None = None

    @property
    def period(self) -> float:
        """The period of the forcing."""
        return 2.0 * pi / self.omega

    @property
    def waves(self) -> list[tuple[float, float, float]]:
        """Frequency, cosine and sine amplitude of each harmonic."""
        return [(j * self.omega, c, s) for j, (c, s) in enumerate(zip(self.cos, self.sin, strict=True), 1)]


STANDARD = Model("standard", alpha=3.0, k=1.0, omega=2.2, r=0.8, V=0.4)
PASSIVE = Model("passive", alpha=3.0, k=1.0, omega=2.2, r=0.8, V=0.0)
UNDER_DAMPED = Model("under-damped", alpha=0.5, k=1.0, omega=2.2, r=0.8, V=0.4)
THREE_HARMONICS = Model(
    "three harmonics", alpha=3.0, k=1.0, omega=2.2, r=0.8, V=0.4, cos=(1.0, 0.4, 0.2), sin=(0.0, 0.3, -0.1)
)
BETWEEN = Model("two walls", alpha=3.0, k=1.0, omega=2.2, r=0.8, V=0.4, gap=0.4)
NARROW = Model("two walls, narrow", alpha=3.0, k=1.0, omega=2.2, r=0.8, V=0.4, gap=0.35)
#: The models of the fixed set.
MODELS = {model.name: model for model in (STANDARD, PASSIVE, UNDER_DAMPED, THREE_HARMONICS)}


class Columns(NamedTuple):
    """Orbits in columns, one constant force a column: d (columns,), starts u and v (columns, starts)."""

    d: Array
    u: Array
    v: Array


def family(columns: int, starts: int) -> Columns:
    """Return random starts, u in (0, 0.1] and v in [-0.3, 0.3], for d from 0.05 to 0.16."""
    rng = np.random.default_rng(0)
    shape = (columns, starts)
    d = np.linspace(0.05, 0.16, columns)
    return Columns(d, 0.1 * (1.0 - rng.random(shape)), rng.uniform(-0.3, 0.3, shape))
