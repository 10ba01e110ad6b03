"""Orbits told apart by their words: a class and a colour for each word, the same throughout a figure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from grazing.plot.classes import UNUSED, order_of, patch, patches_of, written
from grazing.plot.style import PERIODS, period_colour

#: What words have in common that have no colour of their own: there are as many colours as for periods.
OTHERS = "#e0c3ae"
#: Colours of the words in each figure that shows some.
_SHOWN: WeakKeyDictionary[Figure, dict[str, str]] = WeakKeyDictionary()


def words_in(figure: Figure) -> dict[str, str]:
    """Return the colours of the words that a figure shows; whatever is drawn into it next goes on with them."""
    return _SHOWN.setdefault(figure, {})


def with_words(known: dict[str, str], words: Iterable[str]) -> dict[str, str]:
    """Give words that have no colour yet the next free ones, the shortest first; return what is known."""
    free = [colour for colour in PERIODS if colour not in known.values()]
    fresh = sorted({*words} - {*known, ""}, key=lambda word: (len(word), word))
    known.update(zip(fresh, free, strict=False))
    return known


class Worded(NamedTuple):
    """Classes of orbits by word.

    ``codes``: of each orbit, from 1 on the place of its word in ``words``, the most common ones sorted by length, one
    more for any other word, below 1 as its period. ``colours`` by code.
    """

    codes: NDArray[np.int64]
    words: list[str]
    colours: dict[int, str]
    entries: list[Patch]


def worded(
    period: NDArray[Any],
    word: NDArray[Any],
    weight: NDArray[Any],
    known: dict[str, str] | None = None,
    also: Iterable[str] = (),
) -> Worded:
    """Sort orbits by word.

    Parameters
    ----------
    period, word : ndarray
        Of orbits, of one shape.
    weight : ndarray
        How common each is, of the same shape.
    known : dict of str to str, optional
        Words that have their colours, as :func:`words_in` returns them; what is chosen is added.
    also : iterable of str
        Words beside these orbits, as of curves: they have colours and stand in the legend, before any others.
    """
    known = with_words({} if known is None else known, ())
    lines = list(dict.fromkeys(also))
    periods, texts = np.asarray(period, np.int64), np.asarray(word, object).astype(str)
    found = np.where((periods >= 1) & (weight > 0.0) & (texts != ""), texts, "")
    present, which = np.unique(found, return_inverse=True)
    common = np.bincount(which.ravel(), np.asarray(weight, np.float64).ravel(), len(present))
    common[present == ""] = -1.0
    kept = [str(present[i]) for i in np.argsort(-common, kind="stable").tolist() if common[i] >= 0.0]
    room = len(PERIODS) - len(known) - len({*lines} - {*known})
    fresh = [one for one in kept if one not in known and one not in lines]
    with_words(known, [*lines, *fresh[: max(room, 0)]])
    words = sorted((one for one in kept if one in known), key=lambda one: (len(one), one))
    place = np.array([words.index(one) + 1 if one in words else len(words) + 1 for one in present.tolist()], np.int64)
    codes = np.where(periods >= 1, place[which.reshape(periods.shape)], periods)
    colours = dict(enumerate([*(known[one] for one in words), OTHERS], 1))
    listed = sorted({*words, *(one for one in lines if one in known)}, key=lambda one: (len(one), one))
    entries = [patch(known[one], written(one)) for one in listed]
    if (codes > len(words)).any():
        entries.append(patch(OTHERS, "other words"))
    rest = sorted({int(code) for code in np.unique(codes[codes < 1])} - {UNUSED}, key=order_of)
    colours |= {code: period_colour(code) for code in rest}
    return Worded(codes, words, colours, entries + list(patches_of(rest)))
