"""Where in mu the orbits of a word of the gap map begin, end and change stability."""

from __future__ import annotations

import math
from itertools import chain, pairwise
from typing import Any, NamedTuple

import numpy as np

from grazing.outcome import InputError, shown
from grazing.theory._inputs import LARGEST, FloatArray
from grazing.theory.collisions import collisions
from grazing.theory.edges import mu_bc, mu_gr
from grazing.theory.words import WordOrbit, blocks_of, checked_word, finite, root_length, word_orbits

__all__ = ["WordEdges", "WordWindow", "word_edges", "word_windows"]

#: Samples of an interval between two collisions: a stable piece that lies between two of them can be missed.
SAMPLES = 32
#: Part of the greatest mu of a search that is next to 0.
NEXT = 1e-9


class WordEdges(NamedTuple):
    """Values of mu at which an admissible orbit of a word meets a graze or a bifurcation, each in ascending order.

    Parameters
    ----------
    gr : tuple of float
        Graze: a point with letter R reaches 0.
    bc : tuple of float
        Border collision: a point with letter L reaches 0.
    pd : tuple of float
        Period doubling: multiplier -1.
    lp : tuple of float
        Fold: multiplier +1.
    """

    gr: tuple[float, ...]
    bc: tuple[float, ...]
    pd: tuple[float, ...]
    lp: tuple[float, ...]


class WordWindow(NamedTuple):
    """An open interval of mu with an admissible orbit of a word, and the types of its ends.

    Parameters
    ----------
    low, high : float
        The ends; they may be infinite.
    low_type, high_type : str
        ``gr``, ``bc``, ``pd``, ``lp`` as in :class:`WordEdges`, or ``end``: the end of the span searched.
    """

    low: float
    high: float
    low_type: str
    high_type: str


def word_edges(word: str, lam: float, l: float, span: tuple[float, float] | None = None) -> WordEdges:
    """Values of mu at which the admissible orbits of a word graze, collide with the border, double or fold.

    Parameters
    ----------
    word : str
        Letters L and R.
    lam : float
        Slope of the gap map for x < 0.
    l : float
        Gap.
    span : (low, high), optional
        The values of mu that are searched. Default, for 0 < lam < 1: all at which the word can have an admissible
        orbit (from 1e-9 of the greatest on, where that range begins at 0).

    Returns
    -------
    WordEdges

    Raises
    ------
    InputError
        For a bad word or number, or without a span where the default is not known.

    Notes
    -----
    Collisions are zeros of one function of mu, the image of 0 along the word; it is enclosed by intervals, which
    are halved until each holds no zero or exactly one. The default span for words with both letters: L leads from
    x < 0 to ``x < mu``, so that mu > 0. For l >= 0 every root is below sqrt(mu); with C and c of a block, ``C - c s
    < mu`` gives ``mu < mu_bc(m + 1, lam, l)``, and ``C >= 0`` gives ``mu >= mu_gr(m + 1, lam, l)``. For l < 0 every
    root is below sqrt(mu - l), from where a negative point follows for ``mu - l < 1`` only. Between two collisions
    the stable orbit, one at most (:func:`word_orbits`), is sampled at 46 values, close together near the ends; so a
    stable piece between two samples can be missed. A doubling or fold is polished by Newton's method for mu and all
    roots at once.

    Examples
    --------
    >>> from grazing import theory
    >>> edges = theory.word_edges("LLR", 0.9, 0.0)
    >>> round(edges.pd[0], 6), round(edges.bc[0], 6)
    (0.181577, 0.224377)
    """
    word, lam, l = checked_word(word), finite("lam", lam, LARGEST), finite("l", l, LARGEST)
    low, high = _span(word, lam, l, span)
    if "R" not in word:
        inside = lam != 1.0 and low <= 0.0 <= high and root_length(word) == len(word)
        return WordEdges((), (0.0,) if inside else (), (), ())
    return _edges(word, lam, l, low, high)


def word_windows(
    word: str, lam: float, l: float, span: tuple[float, float] | None = None, *, stable: bool = True
) -> tuple[WordWindow, ...]:
    """Intervals of mu in which a word has an admissible orbit that is stable, or any admissible orbit.

    Parameters
    ----------
    word : str
        Letters L and R; no repetition is ever stable.
    lam : float
        Slope of the gap map for x < 0.
    l : float
        Gap.
    span : (low, high), optional
        As in :func:`word_edges`.
    stable : bool
        False asks for existence instead, stable or not.

    Returns
    -------
    tuple of WordWindow
        In ascending order.

    Raises
    ------
    InputError
        As :func:`word_edges`.

    Examples
    --------
    >>> from grazing import theory
    >>> w = theory.word_windows("LLR", 0.8, 1.0)[0]
    >>> round(w.low, 6), round(w.high, 6), w.low_type, w.high_type
    (0.388197, 0.855534, 'pd', 'bc')
    >>> theory.word_windows("LLRLR", 0.5, 0.5)
    ()
    """
    return both_windows(word, lam, l, span)[0 if stable else 1]


def both_windows(
    word: str, lam: float, l: float, span: tuple[float, float] | None = None
) -> tuple[tuple[WordWindow, ...], tuple[WordWindow, ...]]:
    """Return the intervals with a stable orbit and those with any, as :func:`word_windows` does."""
    word, lam, l = checked_word(word), finite("lam", lam, LARGEST), finite("l", l, LARGEST)
    low, high = _span(word, lam, l, span)
    if "R" not in word:
        return _left_windows(word, lam, low, high, True), _left_windows(word, lam, low, high, False)
    edges = _edges(word, lam, l, low, high)
    cuts = {kind: [(mu, kind) for mu in getattr(edges, kind)] for kind in edges._fields}
    ends = [(mu, "gr" if mu == 0.0 and _at_zero(word, lam, l, high - low) else "end") for mu in (low, high)]
    every = [ends[0], *sorted(chain(*cuts.values())), ends[1]]
    if root_length(word) < len(word):  # the doubling is where it begins, and it is never stable
        return (), _where(word, lam, l, every, False)
    kept = [cut for cut in every if cut[1] != "pd"]
    return _where(word, lam, l, every, True), _where(word, lam, l, kept, False)


def _where(word: str, lam: float, l: float, cuts: list[tuple[float, str]], stable: bool) -> tuple[WordWindow, ...]:
    """Return the intervals between cuts in which a word has an orbit, joined where nothing happens to it."""
    found: list[WordWindow] = []
    for (a, a_kind), (b, b_kind) in pairwise(cuts):
        if not a < b or not _holds(word, lam, l, _between(a, b), stable):
            continue
        if found and found[-1].high == a:  # what happens here happens to another orbit of the word
            found[-1] = WordWindow(found[-1].low, b, found[-1].low_type, b_kind)
        else:
            found.append(WordWindow(a, b, a_kind, b_kind))
    return tuple(found)


def _span(word: str, lam: float, l: float, span: Any) -> tuple[float, float]:
    """Return the values of mu to be searched."""
    if span is not None:
        try:
            first, second = span
        except (TypeError, ValueError):
            raise InputError(
                f"span = {shown(span)} is not allowed; give the pair (low, high) of values of mu"
            ) from None
        low, high = finite("span", first, LARGEST), finite("span", second, LARGEST)
        if not low < high:
            raise InputError(f"span = ({shown(low)}, {shown(high)}) is not allowed; the lower end must come first")
        return low, high
    if "R" not in word:
        return -math.inf, math.inf
    if "L" not in word:
        return l, math.inf
    if not 0.0 < lam < 1.0:
        raise InputError(
            f"no span of mu for {word} at lam = {shown(lam)}: where its orbits can lie is known for 0 < lam < 1 only; "
            "give span=(low, high)"
        )
    slack = 1e-9  # so that the edges themselves lie inside
    if l < 0.0:
        return 0.0, max(1.0 + l, 0.0)
    counts = blocks_of(word, lam, 0.0, l).counts
    low = max(float(mu_gr(m + 1, lam, l)) for m in counts)
    high = min(float(mu_bc(m + 1, lam, l)) for m in counts if m)
    return low * (1.0 - slack), high * (1.0 + slack)


def _left_windows(word: str, lam: float, low: float, high: float, stable: bool) -> tuple[WordWindow, ...]:
    """Return where mu/(1 - lam) < 0."""
    if root_length(word) < len(word) or lam == 1.0 or (stable and not abs(lam) < 1.0):
        return ()
    a, b = (low, min(high, 0.0)) if lam < 1.0 else (max(low, 0.0), high)
    if not a < b:
        return ()
    return (WordWindow(a, b, "bc" if a == 0.0 else "end", "bc" if b == 0.0 else "end"),)


def _edges(word: str, lam: float, l: float, low: float, high: float) -> WordEdges:
    """Return the edges of a word with an R in a span."""
    length = root_length(word)
    half = word[:length]
    if len(word) // length > 2:
        return WordEdges((), (), (), ())
    if "L" not in word and high == math.inf:  # C = mu - l alone decides: 0, 3/4 and 1
        return WordEdges((l,), (), (l + 0.75,), ()) if word == "R" else WordEdges((l + 1.0,), (), (l + 0.75,), ())
    first = max(low, NEXT * high) if low >= 0.0 else low
    if not first < high:
        return WordEdges((), (), (), ())
    met: dict[str, list[float]] = {"L": [], "R": []}
    for j in range(length):
        # for lam > 0 a point x = 0 with letter L maps to mu, which lies right of the border
        if word[j] == "L" and lam > 0.0 and word[(j + 1) % len(word)] == "L" and first > 0.0:
            continue
        met[word[j]] += collisions(word, j, lam, l, first, high)
    if low < 0.0 < high and "L" in word and _at_zero(word, lam, l, high - low):
        met["R"].append(0.0)
    grazes, borders = (tuple(sorted(found)) for found in (met["R"], met["L"]))
    if length < len(word):
        return WordEdges(grazes, borders, word_edges(half, lam, l, (low, high)).pd, ())
    changes = _changes(word, lam, l, sorted({first, *grazes, *borders, high}))
    doublings, folds = (tuple(sorted(mu for mu, kind in changes if kind == one)) for one in ("pd", "lp"))
    return WordEdges(grazes, borders, doublings, folds)


def _at_zero(word: str, lam: float, l: float, scale: float) -> bool:
    """Whether orbits begin or end at mu = 0: without a gap all their points come to 0 there, and none comes alone."""
    if l != 0.0:
        return False
    tiny = NEXT * min(scale, 1.0)
    below, above = ([one.admissible for one in word_orbits(word, lam, mu, l)].count(True) for mu in (-tiny, tiny))
    return below != above


def _stable(word: str, lam: float, l: float, mu: float) -> WordOrbit | None:
    """Return the stable admissible orbit at mu, of which there is one at most."""
    return next((one for one in word_orbits(word, lam, mu, l) if one.stable and one.admissible), None)


def _holds(word: str, lam: float, l: float, mu: float, stable: bool) -> bool:
    return any(one.admissible and (one.stable or not stable) for one in word_orbits(word, lam, mu, l))


def _between(a: float, b: float) -> float:
    return a + 1.0 if b == math.inf else 0.5 * (a + b)


def _changes(word: str, lam: float, l: float, cuts: list[float]) -> list[tuple[float, str]]:
    """Return doublings and folds of the stable orbit between collisions."""
    found = []
    near = 10.0 ** -np.arange(4.0, 11.0)
    middle = 0.5 - 0.5 * np.cos(np.pi * (np.arange(SAMPLES) + 0.5) / SAMPLES)
    share = np.sort(np.concatenate([near, middle, 1.0 - near]))
    for a, b in pairwise(cuts):
        values = (a + share * (b - a)).tolist()
        there = [_stable(word, lam, l, mu) is not None for mu in values]
        for p, q, here, after in zip(values, values[1:], there, there[1:], strict=False):
            if here != after:
                good, bad = (p, q) if here else (q, p)
                critical = _critical(word, lam, l, good, bad)
                if critical is not None:
                    found.append(critical)
    return found


def _critical(word: str, lam: float, l: float, good: float, bad: float) -> tuple[float, str] | None:
    """Return where a stable orbit at `good` has lost its stability before `bad`, and how; None if it only ended."""
    for _ in range(40):
        middle = 0.5 * (good + bad)
        if _stable(word, lam, l, middle) is None:
            bad = middle
        else:
            good = middle
    orbit = _stable(word, lam, l, good)
    if orbit is None or abs(orbit.multiplier) < 0.95:
        return None  # rounding beside a collision
    kind = "pd" if orbit.multiplier < 0.0 else "lp"
    return _polished(word, lam, l, good, np.array(orbit.roots)), kind


def _polished(word: str, lam: float, l: float, mu: float, roots: FloatArray) -> float:
    """Solve for mu and all roots at once, the modulus of the multiplier being 1."""
    b = blocks_of(word, lam, mu, l)
    c, K = np.array(b.c), np.array(b.K)
    k, level = len(c), float(np.log(np.abs(c)).sum())

    def defect(s: FloatArray, at: float) -> FloatArray:
        return np.append(s * s + c * np.roll(s, 1) - (K * at - c * l), np.log(2.0 * s).sum() - level)

    off = defect(roots, mu)
    for _ in range(8):
        J = np.zeros((k + 1, k + 1))
        J[:k, :k] = np.diag(2.0 * roots)
        J[np.arange(k), np.arange(k) - 1 + k * (np.arange(k) == 0)] += c
        J[:k, k], J[k, :k] = -K, 1.0 / roots
        step = np.linalg.solve(J, off)
        new, at = roots - step[:k], mu - float(step[k])
        if not (new > 0.0).all():
            break
        ahead = defect(new, at)
        if not np.abs(ahead).max() < np.abs(off).max():
            break
        roots, mu, off = new, at, ahead
    return mu
