"""Where random starts of an oscillator's maps are drawn, unless said: as far as its orbits go, in its own units.

The paper's pinball has boxes of its own: its force is 1, its figures are drawn from starts near the wall.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grazing.oscillator.model import Oscillator
from grazing.oscillator.reach import Reach

Pair = tuple[float, float]
Box = tuple[Pair, Pair]
#: A section's box from where orbits go, and whether the model is the paper's pinball.
Form = Callable[[Reach, bool], Box]


def paper_box(sigma: float, period: float) -> Box:
    """Return the box of the paper's pinball at a strobe."""
    width = max(min(1.0, 4.0 * period * period), 1e-6 * abs(sigma))
    return (sigma + 1e-3 * width, sigma + 0.1 * width), (-0.3 * width, 0.3 * width)


def reach_box(sigma: float, height: float, speed: float) -> Box:
    """Return the box of any other oscillator at a strobe."""
    return (sigma + 1e-3 * height, sigma + height), (-speed, speed)


def strobe_box(at: Reach, paper: bool) -> Box:
    """Return the box of the stroboscopic map: u and v."""
    return paper_box(at.sigma, at.period) if paper else reach_box(at.sigma, at.height, at.speed)


def impact_box(at: Reach, paper: bool) -> Box:
    """Return the box of the impact map: a phase, and the velocity after an impact."""
    return (0.0, at.period), (0.0, 1.0 if paper else at.after)


def local_box(at: Reach, paper: bool) -> Box:
    """Return the box of a map that is right near the wall: u and v."""
    height, speed = (1.0, 1.0) if paper else (at.height, at.speed)
    return (at.sigma, at.sigma + 0.1 * height), (-0.3 * speed, 0.3 * speed)


def boxes_at(model: Oscillator, form: Form, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the boxes at parameter values, rows in the order of the model's: shape (rows, 2, 2)."""
    return np.array([form(model.reach_at(row), model.paper) for row in rows.tolist()]).reshape(-1, 2, 2)
