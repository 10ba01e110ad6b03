"""Norms for counts: how a number becomes a place on a colour bar."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import LogNorm, Normalize
from numpy.typing import ArrayLike, NDArray

from grazing.outcome import InputError, shown

#: Steps of a histogram-equalised scale at most: finer ones than a screen has.
LEVELS = 1024
#: Norms that have names.
NORMS = ("eqhist", "log", "linear")


class EqHist(Normalize):
    """Histogram equalisation: equal shares of the bins that hold points have equal ranges of colour.

    Parameters
    ----------
    data : array_like
        Numbers; those that are not finite or not positive are left out.

    Examples
    --------
    >>> from grazing.plot.norms import EqHist
    >>> norm = EqHist([0, 1, 2, 2, 50])
    >>> [round(float(norm(x)), 3) for x in (1, 2, 26, 50)]
    [0.0, 0.667, 0.833, 1.0]
    >>> round(float(norm.inverse(norm(26))), 12)
    26.0
    """

    def __init__(self, data: ArrayLike) -> None:
        numbers = np.asarray(data, np.float64).ravel()
        levels, counts = np.unique(numbers[np.isfinite(numbers) & (numbers > 0.0)], return_counts=True)
        if levels.size < 2:  # a scale has two ends
            one = float(levels[0]) if levels.size else 1.0
            levels, counts = np.array([one, 2.0 * one]), np.array([1, 1])
        share = np.cumsum(counts, dtype=np.float64)
        share = (share - share[0]) / (share[-1] - share[0])
        if levels.size > LEVELS:
            kept = np.unique(np.append(np.searchsorted(share, np.linspace(0.0, 1.0, LEVELS)), levels.size - 1))
            levels, share = levels[kept], share[kept]
        self.levels, self.share = levels, share
        super().__init__(float(levels[0]), float(levels[-1]))

    def __call__(self, value: Any, clip: bool | None = None) -> Any:
        """Return the places of values between 0 and 1; what is masked stays so."""
        found, single = self.process_value(value)
        place = np.interp(found.data, self.levels, self.share, left=None if clip else -1.0)
        place = np.ma.array(place, mask=np.ma.getmask(found))
        return place[0] if single else place

    def inverse(self, value: Any) -> Any:
        """Return the values at places between 0 and 1."""
        return np.interp(value, self.share, self.levels)


def norm_of(norm: str | Normalize, data: NDArray[np.float64]) -> Normalize:
    """Return a norm by its name, for the positive numbers among the data, or the one given.

    Parameters
    ----------
    norm : {"eqhist", "log", "linear"} or matplotlib Normalize
    data : ndarray

    Raises
    ------
    InputError
        For anything else.
    """
    if isinstance(norm, Normalize):
        return norm
    if not isinstance(norm, str) or norm not in NORMS:
        raise InputError(f"norm is {shown(norm)}; allowed are {', '.join(map(repr, NORMS))} and a matplotlib Normalize")
    if norm == "eqhist":
        return EqHist(data)
    positive = data[np.isfinite(data) & (data > 0.0)]
    low, high = (float(positive.min()), float(positive.max())) if positive.size else (1.0, 1.0)
    if norm == "log":
        return LogNorm(low, high if high > low else 10.0 * low)
    return Normalize(0.0, high)


def round_ticks(norm: Normalize, apart: float = 0.07) -> list[float]:
    """Return round numbers on a scale, at least so far apart along the bar: powers of ten first, then 5, 2 and 3.

    Parameters
    ----------
    norm : Normalize
        With ``vmin`` and ``vmax`` set, both positive.
    apart : float
        As a share of the bar.

    Examples
    --------
    >>> from grazing.plot.norms import LogNorm, round_ticks
    >>> round_ticks(LogNorm(1.0, 1000.0))
    [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0]
    """
    low, high = float(norm.vmin or 1.0), float(norm.vmax or 1.0)
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    chosen: list[tuple[float, float]] = []
    for digit in (1.0, 5.0, 2.0, 3.0):
        for decade in decades:
            value = float(f"{digit:g}e{decade}")
            place = float(norm(value)) if low <= value <= high else np.nan
            if all(abs(place - other) >= apart for other, _ in chosen) and np.isfinite(place):
                chosen.append((place, value))
    return [value for _, value in sorted(chosen)]
