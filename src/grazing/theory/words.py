"""Every periodic orbit of the gap map with a given word, admissible or virtual.

Let s_i >= 0 be the roots of the points right of the border, and m_i the letters L between two of them. One block
L^m R gives ``s_i^2 = C_i - c_i s_(i-1)`` with ``c = lam^m`` and ``C = K_(m+1) mu - c l``, so the orbits of a word
are the fixed points of a composition F of k maps ``s -> sqrt(C - c s)``: roots of a polynomial of degree 2^k.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from grazing.outcome import InputError, OutsideForm, abridged, shown
from grazing.theory._inputs import FloatArray

__all__ = ["WordOrbit", "word_orbits"]


@dataclass(frozen=True, eq=False)
class WordOrbit:
    """One solution of the equations of a word of the gap map.

    Parameters
    ----------
    word : str
        As it was given: letter j is that of point j.
    points : ndarray
        One period, in the order of the letters. Read-only.
    roots : tuple of float
        Square roots of the points with letter R, in the order of iteration.
    multiplier : float
        Product of the slopes along the orbit; infinite where a point with letter R is 0.
    admissible : bool
        Whether every point with letter L is negative, so that the map visits the points; else the orbit is virtual.
    residual : float
        Largest defect of the equations ``s_i^2 = C_i - c_i s_(i-1)``.
    """

    word: str
    points: FloatArray
    roots: tuple[float, ...]
    multiplier: float
    admissible: bool
    residual: float

    def __repr__(self) -> str:
        kept = "admissible" if self.admissible else "virtual"
        return f"<WordOrbit {abridged(self.word)}, {kept}, multiplier {self.multiplier:.6g}>"

    @property
    def stable(self) -> bool:
        """Whether the multiplier is inside (-1, 1)."""
        return abs(self.multiplier) < 1.0


class Blocks(NamedTuple):
    """The blocks L^m R of a word in cyclic order, the first of them after the last R of the word; C = K mu - c l."""

    word: str
    counts: tuple[int, ...]
    c: tuple[float, ...]
    C: tuple[float, ...]
    K: tuple[float, ...]


def word_orbits(word: str, lam: float, mu: float, l: float) -> tuple[WordOrbit, ...]:
    """All periodic orbits of the gap map with a word, admissible and virtual ones.

    Parameters
    ----------
    word : str
        Letters L and R, such as ``"LLR"``; a repetition such as ``"LLRLLR"`` asks for orbits of that least period.
    lam : float
        Slope of the gap map for x < 0: any finite number.
    mu : float
        Offset.
    l : float
        Gap; a negative one makes the map jump up.

    Returns
    -------
    tuple of WordOrbit
        In increasing order of the root that follows the first block. A word with an R has at most three orbits, at
        most one of them stable; a repetition has at most one, which is unstable.

    Raises
    ------
    InputError
        For another letter, no letter, or a number that is not finite.
    OutsideForm
        For words without R at lam = 1 or -1, where orbits come in families or not at all.

    Notes
    -----
    None is missed, because F is a monotone function on an interval, and the Schwarzian derivative of each of its
    factors, ``3 c^2/(8 (C - c s)^2)``, is positive, hence that of F (by the composition rule). If F falls, it has
    one fixed point at most. If F rises, ``F'^(-1/2)`` is concave, so F' < 1 on at most one interval: F(s) - s rises,
    falls and rises again, with at most one zero on each of the three pieces, whose ends are found by bisection of a
    convex function. Only the middle zero has a multiplier below 1. A monotone map has cycles of period 1 and 2
    only, the latter if it falls: of repetitions only the doubled word can have an orbit, and the cycle lies around
    the fixed point, on the two outer pieces, so that the period doubling of every word is subcritical. In double
    precision a pair closer than about 1e-8, at a fold or a period doubling, may count as none. Points with letter R
    that are negative have no real root and so no solution.

    One R needs no bisection (:func:`maximal_orbit` for 0 < lam < 1), nor does its doubling (:func:`doubled_orbit`).

    Examples
    --------
    >>> from grazing import theory
    >>> orbit = theory.word_orbits("LLR", 0.8, 0.5, 1.0)[0]
    >>> orbit.points.round(6).tolist(), round(orbit.multiplier, 6), orbit.admissible
    ([-1.006075, -0.30486, 0.256112], -0.632317, True)
    >>> [(o.admissible, round(o.multiplier, 3)) for o in theory.word_orbits("LLRLR", 0.9, 0.1, 0.05)]
    [(True, 8.694)]
    """
    letters = checked_word(word)
    lam, mu, l = (finite(name, value) for name, value in (("lam", lam), ("mu", mu), ("l", l)))
    length = root_length(letters)
    root, times = letters[:length], len(letters) // length
    if "R" not in letters:
        return _left_only(letters, times, lam, mu)
    blocks = blocks_of(root, lam, mu, l)
    falls = sum(c > 0.0 for c in blocks.c) % 2 == 1
    if times > 2 or (times == 2 and not falls) or (times == 2 and 0.0 in blocks.c):
        return ()
    solutions = _solved(blocks, falls) if times == 1 else _doubled(blocks)
    found = [_orbit(blocks, letters, roots, lam, mu, l) for roots in solutions]
    return tuple(sorted(found, key=lambda orbit: orbit.roots[0]))


def checked_word(word: object) -> str:
    """Return a word of letters L and R, or raise InputError."""
    if not isinstance(word, str) or not word or set(word) - {"L", "R"}:
        raise InputError(f"word = {shown(word)}; allowed is a text of letters L (x < 0) and R (x >= 0), such as 'LLR'")
    return word


def root_length(word: str) -> int:
    """Return the length of the shortest word of which this one is a repetition."""
    return (word + word).index(word, 1)


def finite(name: str, value: object, largest: float = math.inf) -> float:
    """Check one number and return it as a float; unlike in the propositions it may have any sign."""
    try:
        if isinstance(value, (bool, str, bytes)) or np.iscomplexobj(value) or np.ndim(value):  # type: ignore[arg-type]
            raise TypeError
        number = float(value)  # type: ignore[arg-type]
    except Exception:  # of whatever object was given
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{name} = {shown(value)} is not allowed; {name} must be a finite number")
    if abs(number) > largest:
        raise InputError(
            f"{name} = {shown(value)} is not allowed; {name} must be a finite number up to {largest:g} in size"
        )
    return number


def blocks_of(word: str, lam: float, mu: float, l: float) -> Blocks:
    """Return the blocks of a word with an R, and the coefficients of their equations."""
    last = word.rindex("R") + 1
    counts = tuple(len(run) for run in (word[last:] + word[:last])[:-1].split("R"))
    c, C, K = [], [], []
    for m in counts:
        total, power = 1.0, 1.0
        for _ in range(m):
            power *= lam
            total += power
        c.append(power)
        K.append(total)
        C.append(total * mu - power * l)
    if not all(map(math.isfinite, C)):
        raise InputError(
            f"lam = {shown(lam)} to the power {max(counts)} leaves the range of doubles; take a shorter word"
        )
    return Blocks(word, counts, tuple(c), tuple(C), tuple(K))


def _left_only(word: str, times: int, lam: float, mu: float) -> tuple[WordOrbit, ...]:
    """Return the fixed point left of the border; it has no further period."""
    if (times == 1 and lam == 1.0) or (times == 2 and lam == -1.0):
        raise OutsideForm(
            f"the orbits of {word} come in families or not at all at lam = {shown(lam)}; take another lam"
        )
    if times > 1:
        return ()
    x = mu / (1.0 - lam)
    points = np.array([x])
    points.flags.writeable = False
    return (WordOrbit(word, points, (), lam, x < 0.0, abs(lam * x + mu - x)),)


def _orbit(b: Blocks, word: str, roots: FloatArray, lam: float, mu: float, l: float) -> WordOrbit:
    """Return the orbit of given roots, one for each block of the word or of its repetition."""
    times = len(word) // len(b.word)
    c, C, counts = (np.tile(values, times) for values in (b.c, b.C, b.counts))
    points: list[float] = []
    for before, here, m in zip(np.roll(roots, 1).tolist(), roots.tolist(), counts.tolist(), strict=True):
        x = mu - l - before
        for _ in range(m):
            points.append(x)
            x = lam * x + mu
        points.append(here * here)
    turned = np.roll(points, word.rindex("R") + 1)
    turned.flags.writeable = False
    right = np.array([letter == "R" for letter in word])
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a graze has an infinite slope, if any
        slopes = np.where(c == 0.0, 0.0, -c / (2.0 * roots))
        turn = 0.0 if (slopes == 0.0).any() else float(np.prod(slopes))
    defect = np.abs(roots * roots - (C - c * np.roll(roots, 1)))
    return WordOrbit(
        word=word,
        points=turned,
        roots=tuple(roots.tolist()),
        multiplier=turn,
        admissible=bool((turned[~right] < 0.0).all()),
        residual=float(defect.max()),
    )


def _solved(b: Blocks, falls: bool) -> list[FloatArray]:
    """Return the roots s_1, ..., s_k of every solution, smooth at 0 and polished by Newton's method."""
    if len(b.c) == 1:
        return [np.array([s]) for s in _quadratic(b.c[0], b.C[0])]
    ends = domain(b)
    if ends is None:
        return []
    low, high = ends
    pieces = [(low, high)] if falls or 0.0 in b.c else _pieces(b, low, high)
    return [polished(b, s) for s in _zeros(b, pieces)]


def _quadratic(c: float, C: float) -> list[float]:
    """Return the roots s >= 0 of s^2 + c s - C = 0, without cancellation."""
    square = 0.25 * c * c + C
    if square < 0.0:
        return []
    far = 0.5 * abs(c) + math.sqrt(square)  # the root of larger modulus
    near = C / far if far > 0.0 else 0.0
    if c >= 0.0:
        return [near] if near >= 0.0 else []
    return [far] if near > 0.0 or square == 0.0 else [abs(near), far]


def _doubled(b: Blocks) -> list[FloatArray]:
    """Return the roots of the orbit of twice the period, where the composition F falls: none or one."""
    if len(b.c) == 1:  # s + t = c and s t = c^2 - C
        c, C = b.c[0], b.C[0]
        square = 4.0 * C - 3.0 * c * c
        if square <= 0.0 or C > c * c:
            return []
        great = 0.5 * (c + math.sqrt(square))
        return [np.array([(c * c - C) / great, great])]
    single = _solved(b, True)
    if not single:
        return []
    twice = Blocks(b.word * 2, b.counts * 2, b.c * 2, b.C * 2, b.K * 2)
    ends = domain(twice)
    s = float(single[0][-1])  # F takes it into itself
    if ends is None or not ends[0].s < s or log_slope(twice, s) >= 0.0:
        return []
    low = ends[0]
    least = min(_turn(twice, low.s, s), s)
    edge = _switch(lambda at: log_slope(twice, at) < 0.0, low.s, least)
    return [polished(twice, start) for start in _zeros(twice, [(low, _end(twice, edge))])]


def chain(b: Blocks, s: float) -> list[float]:
    """Return the roots that follow s, one for each block; the last is F(s)."""
    found = []
    for c, C in zip(b.c, b.C, strict=True):
        s = math.sqrt(max(C - c * s, 0.0))
        found.append(s)
    return found


class End(NamedTuple):
    """An end of an interval of s, and F there."""

    s: float
    image: float


def _end(b: Blocks, s: float) -> End:
    return End(s, chain(b, s)[-1])


def domain(b: Blocks) -> tuple[End, End] | None:
    """Return the interval of s >= 0 on which F is defined, up to a bound on all roots of an orbit; None if empty.

    F at an end is taken from the block where a root is 0 there, on: F is so steep beside a graze that its value at
    the rounded end says nothing.
    """
    a, d = max(map(abs, b.c)), max(map(abs, b.C))
    bound = 0.5 * a + math.sqrt(0.25 * a * a + d)  # s^2 <= d + a s for the greatest root
    bound *= 1.0 + 1e-12
    low, high = End(0.0, 0.0), End(bound, bound)
    for i in range(len(b.c) - 1, -1, -1):
        c, C = b.c[i], b.C[i]
        rest = b._replace(c=b.c[i:], C=b.C[i:])
        if c == 0.0:
            if not low.s * low.s <= C <= high.s * high.s:
                return None
            low, high = _end(rest, 0.0), _end(rest, bound)
            continue
        low, high = (End((C - end.s * end.s) / c, end.image) for end in ((high, low) if c > 0.0 else (low, high)))
        if low.s < 0.0:
            low = _end(rest, 0.0)
        if high.s > bound:
            high = _end(rest, bound)
        if not low.s <= high.s:
            return None
    return low, high


def log_slope(b: Blocks, s: float) -> float:
    """Return log |F'(s)|, a convex function of s."""
    pairs = zip(b.c, chain(b, s), strict=True)
    return sum(math.log(abs(c)) - math.log(2.0 * max(at, 1e-300)) for c, at in pairs)  # of the quotient 0 may be left


def _steepens(b: Blocks, s: float) -> bool:
    """Whether log |F'| rises at s."""
    slope, rise = 1.0, 0.0
    for c, at in zip(b.c, chain(b, s), strict=True):
        at = max(at, 1e-150)
        slope *= -c / (2.0 * at)
        rise -= slope / at
    return rise > 0.0


def _turn(b: Blocks, low: float, high: float) -> float:
    """Return where log |F'| is least."""
    return _switch(lambda s: _steepens(b, s), low, high)


def _pieces(b: Blocks, low: End, high: End) -> list[tuple[End, End]]:
    """Cut the domain of a rising F where F' = 1: F(s) - s is monotone on every piece."""
    least = _turn(b, low.s, high.s)
    if log_slope(b, least) >= 0.0:
        return [(low, high)]
    left = _end(b, _switch(lambda s: log_slope(b, s) < 0.0, low.s, least))
    right = _end(b, _switch(lambda s: log_slope(b, s) >= 0.0, least, high.s))
    return [(p, q) for p, q in ((low, left), (left, right), (right, high)) if p.s < q.s]


def _zeros(b: Blocks, pieces: list[tuple[End, End]]) -> list[float]:
    """Return the zeros of F(s) - s, one at most in every piece."""
    found = []
    for low, high in pieces:
        below, above = low.image - low.s, high.image - high.s
        if (below < 0.0) == (above < 0.0) and below != 0.0 and above != 0.0:
            continue
        rises = below < above
        found.append(_switch(lambda s, rises=rises: (chain(b, s)[-1] > s) == rises, low.s, high.s))  # type: ignore[misc]
    return found


def _switch(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Return the point from which on a condition holds, by bisection to 2^-64 of the interval or the last bits."""
    for _ in range(64):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def polished(b: Blocks, s: float) -> FloatArray:
    """Return the roots of an orbit from the last one: by Newton's steps on ``s_i^2 + c_i s_(i-1) = C_i`` for all i.

    The start is an orbit of F where F contracts, of its inverse where F expands.
    """
    start = chain(b, s)
    if 0.0 not in b.c and log_slope(b, s) > 0.0:
        for _ in range(3):
            for i in range(len(start) - 1, -1, -1):
                start[i - 1] = max((b.C[i] - start[i] * start[i]) / b.c[i], 0.0)
    roots, c, C = np.array(start), np.array(b.c), np.array(b.C)
    k = len(c)

    def defect(at: FloatArray) -> FloatArray:
        return np.asarray(at * at + c * np.roll(at, 1) - C)

    off = defect(roots)
    for _ in range(8):
        J = np.diag(2.0 * roots)
        J[np.arange(k), np.arange(k) - 1] += c
        try:
            new = roots - np.linalg.solve(J, off)
        except np.linalg.LinAlgError:
            break
        ahead = defect(new)
        away = np.abs(new - roots).max() > 1e-3 * (np.abs(roots).max() + 1e-300)
        if away or (new < 0.0).any() or not np.abs(ahead).max() < np.abs(off).max():
            break
        roots, off = new, ahead
    return roots
