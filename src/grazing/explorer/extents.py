"""Numbers at which sliders and axes end for a model or a map of the user's own."""

from __future__ import annotations

import math


def rounded(value: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at least as large."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(float(f"{step * power:.3g}") for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value * (1.0 - 1e-9))


def short(value: float) -> float:
    """Return a number of three digits."""
    return float(f"{value:.3g}")
