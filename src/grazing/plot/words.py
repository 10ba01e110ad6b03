"""Orbits told apart by their words: a class and a colour for each word."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.patches import Patch
from numpy.typing import NDArray

from grazing.plot.classes import UNUSED, order_of, patch, patches_of, written
from grazing.plot.style import PERIODS, period_colour

#: What words have in common that have no colour of their own: there are as many colours as for periods.
OTHERS = "#d9d9d9"


class Worded(NamedTuple):
    """Classes of orbits by word.

    ``codes``: of each orbit, from 1 on the place of its word in ``words``, the most common ones sorted by length, one
    more for any other word, below 1 as its period. ``colours`` by code.
    """

    codes: NDArray[np.int64]
    words: list[str]
    colours: dict[int, str]
    entries: list[Patch]


def worded(period: NDArray[Any], word: NDArray[Any], weight: NDArray[Any]) -> Worded:
    """Sort orbits by word.

    Parameters
    ----------
    period, word : ndarray
        Of orbits, of one shape.
    weight : ndarray
        How common each is, of the same shape.
    """
    periods, texts = np.asarray(period, np.int64), np.asarray(word, object).astype(str)
    found = np.where((periods >= 1) & (weight > 0.0) & (texts != ""), texts, "")
    present, which = np.unique(found, return_inverse=True)
    common = np.bincount(which.ravel(), np.asarray(weight, np.float64).ravel(), len(present))
    common[present == ""] = -1.0
    kept = [i for i in np.argsort(-common, kind="stable").tolist() if common[i] >= 0.0]
    own = sorted(kept[: len(PERIODS)], key=lambda i: (len(present[i]), present[i]))
    place = np.full(len(present), len(own) + 1, np.int64)
    place[own] = np.arange(1, len(own) + 1)
    codes = np.where(periods >= 1, place[which.reshape(periods.shape)], periods)
    words, shades = [str(present[i]) for i in own], PERIODS[: len(own)]
    entries = [patch(colour, written(one)) for one, colour in zip(words, shades, strict=True)]
    colours = dict(enumerate([*shades, OTHERS], 1))
    if (codes > len(own)).any():
        entries.append(patch(OTHERS, "other words"))
    rest = sorted({int(code) for code in np.unique(codes[codes < 1])} - {UNUSED}, key=order_of)
    colours |= {code: period_colour(code) for code in rest}
    return Worded(codes, words, colours, entries + list(patches_of(rest)))
