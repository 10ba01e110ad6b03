"""Maps by pieces: one function a letter, borders whose signs choose, and what is made of both.

Each piece is a formula that holds beyond its border too. So an orbit of a word can be followed where another letter
would be chosen, and where it collides with a border is a zero that both sides see.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from itertools import product
from math import sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import address, call, compiled, jit_disabled
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import called_for_all, numbers, replaced
from grazing.outcome import AMBIGUOUS, DIVERGED, OK, InputError, UserCodeError, listed, shown, told

if TYPE_CHECKING:
    from grazing.maps.map import Map

Floats = NDArray[np.float64]
Function = Callable[..., Any]

NAN = float("nan")
#: In place of the row of a state that has been applied.
DONE = -1
#: States of the box along each coordinate at which pieces and borders are tried, and how many in all at most.
TRIED, MOST = (0.5, 0.0, 1.0, 0.25, 0.75), 125


class Formulas(NamedTuple):
    """Pieces in the order of their letters, the borders between them, and which pieces get the root of their border."""

    pieces: tuple[Function, ...]
    borders: tuple[Function, ...]
    rooted: tuple[bool, ...]


def formulas(pieces: object, border: object) -> tuple[str, Formulas]:
    """Return the letters and the formulas of a map by pieces.

    Raises
    ------
    InputError
        For names that are no letters, a missing border or piece, or too many borders.
    """
    if pieces is None:
        raise InputError("border is given without pieces; give pieces={'L': f, 'R': g} too, or a step alone")
    if not isinstance(pieces, Mapping) or not all(callable(one) for one in pieces.values()):
        raise InputError(f"pieces is {shown(pieces)}; give a function for each letter, such as {{'L': f, 'R': g}}")
    for name in pieces:
        if not (isinstance(name, str) and len(name) == 1 and name.isidentifier()):
            raise InputError(f"{shown(name)} is no letter for a piece; give one character a piece, such as 'L' and 'R'")
    if len(pieces) < 2:
        raise InputError(f"pieces has {len(pieces)} letter(s); give two or more, or a step without pieces")
    several = isinstance(border, Sequence) and not isinstance(border, str)
    count = len(border) if several else 1  # type: ignore[arg-type]
    borders: tuple[Any, ...] = tuple(border) if several and count < len(pieces) else (border,)  # type: ignore[arg-type]
    if count == len(borders) and not all(callable(one) for one in borders):
        raise InputError(
            f"border is {shown(border)}; give border(state, p), negative where the first piece holds, or a tuple of "
            "such functions, one less than pieces"
        )
    if count != len(pieces) - 1:
        raise InputError(
            f"{count} border(s) for {len(pieces)} pieces ({listed(pieces)}); give one less than pieces: each "
            "piece but the last holds where its border is the first one that is negative"
        )
    rooted = tuple(takes_root(one) for one in pieces.values())
    if any(rooted) and len(pieces) > 2:
        raise InputError(
            "a piece with the root of its border, f(state, p, root), needs two pieces: else it has several"
        )
    return "".join(pieces), Formulas(tuple(pieces.values()), borders, rooted)


@lru_cache(maxsize=256)
def takes_root(piece: Function) -> bool:
    """Whether a piece is f(state, p, root)."""
    try:
        wanted = inspect.signature(piece).parameters.values()
    except (TypeError, ValueError):
        return False
    return sum(one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD) for one in wanted) == 3


@lru_cache(maxsize=256)
def step_of(given: Formulas) -> Function:
    """Return ``step(state, c) -> (state, letter, outcome)`` of pieces: the first border that is negative chooses.

    On a border the letter after it is taken and the outcome is ambiguous; a border that is not a number ends the orbit.
    """

    def after(k: int) -> Function:
        """Return the choice among the pieces from the k-th on; b is the value of the border before."""
        piece = _with_root(given.pieces[k]) if given.rooted[k] else _without(given.pieces[k])
        if k == len(given.borders):

            def last(state: Any, c: Any, b: Any, said: Any) -> Any:
                return _floats(state, piece(state, c, b)), k, said

            return last
        border, rest = given.borders[k], after(k + 1)

        def choose(state: Any, c: Any, _b: Any, said: Any) -> Any:
            b = 1.0 * border(state, c)
            if b < 0.0:
                return _floats(state, piece(state, c, -b)), k, said
            if b == 0.0:
                said = said | AMBIGUOUS
            elif not b > 0.0:
                said = said | DIVERGED
            return rest(state, c, b, said)

        return choose

    first = after(0)

    def step(state: Any, c: Any) -> Any:
        return first(state, c, 0.0, OK)

    step.formulas = given  # type: ignore[attr-defined]
    return step


def _with_root(piece: Function) -> Function:
    def rooted(state: Any, c: Any, b: Any) -> Any:
        return piece(state, c, sqrt(b))

    return rooted


def _without(piece: Function) -> Function:
    def plain(state: Any, c: Any, _b: Any) -> Any:
        return piece(state, c)

    return plain


def _floats(state: Any, new: Any) -> Any:
    """Return an image as floats, whatever numbers the piece has returned."""
    out = state
    for i in range(len(state)):
        out = replaced(out, i, 1.0 * new[i])
    return out


def tried(given: Formulas, letters: str, name: str, box: Sequence[tuple[float, float]], p: Any) -> None:
    """Try borders and pieces in plain Python, so that an error of theirs comes with its own line and their name.

    A piece is tried at a state on its own side; beyond, a formula may have no value.

    Raises
    ------
    UserCodeError
        If one raises there, or returns what it must not.
    """
    states = [
        tuple(low + t * (high - low) for t, (low, high) in zip(place, box, strict=True))
        for place, _i in zip(product(TRIED, repeat=len(box)), range(MOST), strict=False)
    ]
    left = set(range(len(given.pieces)))
    for state in states:
        b, k = NAN, len(given.borders)
        for i, border in enumerate(given.borders):
            b = _tried_border(border, name, state, p)
            if b < 0.0:
                k = i
                break
        if k in left:
            left.discard(k)
            _tried_piece(given, k, letters, name, state, p, sqrt(abs(b)))
        if not left:
            return
    for k in left:  # the box holds no state of it: beyond its border a piece may raise
        try:
            new = given.pieces[k](states[0], p, *((0.0,) if given.rooted[k] else ()))
        except Exception:
            continue
        _checked_image(new, letters[k], name, states[0])


def _tried_border(border: Function, name: str, state: tuple[float, ...], p: Any) -> float:
    try:
        b = border(state, p)
    except Exception as error:
        raise UserCodeError(
            f"the border of {name} raised {told(error, border)} (state {state}, parameters {p})"
        ) from error
    number = isinstance(b, (int, float, np.floating, np.integer)) and not isinstance(b, bool)
    if not number or math.isnan(b):
        raise UserCodeError(
            f"the border of {name} returned {shown(b)} (state {state}); allowed is one number, negative where the "
            "piece before it holds"
        )
    return float(b)


def _tried_piece(
    given: Formulas, k: int, letters: str, name: str, state: tuple[float, ...], p: Any, root: float
) -> None:
    try:
        new = given.pieces[k](state, p, root) if given.rooted[k] else given.pieces[k](state, p)
    except Exception as error:
        raise UserCodeError(
            f"piece {letters[k]} of {name} raised {told(error, given.pieces[k])} (state {state}, parameters {p})"
        ) from error
    _checked_image(new, letters[k], name, state)


def _checked_image(new: object, letter: str, name: str, state: tuple[float, ...]) -> None:
    good = isinstance(new, tuple) and len(new) == len(state)
    if not good or not all(isinstance(x, (int, float, np.floating)) and not isinstance(x, bool) for x in new):  # type: ignore[attr-defined]
        raise UserCodeError(
            f"piece {letter} of {name} returned {shown(new)}; allowed is the next state alone, a tuple of "
            f"{len(state)} number(s): the letter is that of the piece"
        )


@lru_cache(maxsize=256)
def images_of(given: Formulas, prepare: Function | None, kind: type, dimension: int) -> Function:
    """Return the kernel that applies given pieces to many states, see :class:`Images`."""
    unpack, fields = unpacker(kind), len(kind._fields)  # type: ignore[attr-defined]
    width, zero = wide(given, dimension), (0.0,) * dimension
    constants = prepare if prepare is not None else _same
    guard = _guarded if jit_disabled() else _unguarded  # compiled code has no exceptions of arithmetic

    def among(k: int) -> Function:
        """Return what applies one of the pieces from the k-th on."""
        piece = guard(given.pieces[k], (NAN,) * dimension)
        taken = piece if given.rooted[k] else _without(piece)

        def own(state: Any, c: Any, root: Any) -> Any:
            return _floats(state, taken(state, c, root))

        if k + 1 == len(given.pieces):

            def last(state: Any, c: Any, _letter: Any, root: Any) -> Any:
                return own(state, c, root)

            return last
        rest = among(k + 1)

        def image(state: Any, c: Any, letter: Any, root: Any) -> Any:
            if letter <= k:
                return own(state, c, root)
            return rest(state, c, letter, root)

        return image

    def beyond(k: int) -> Function:
        """Return what writes the values of the borders from the k-th on."""
        border = guard(given.borders[k], NAN)
        if k + 1 == len(given.borders):

            def last(work: Any, place: Any, state: Any, c: Any) -> None:
                work[place] = 1.0 * border(state, c)

            return last
        rest = beyond(k + 1)

        def look(work: Any, place: Any, state: Any, c: Any) -> None:
            work[place] = 1.0 * border(state, c)
            rest(work, place + 1, state, c)

        return look

    apply, look = among(0), beyond(0)

    def images(work: Any, tables: Any, _room: Any, runs: Any, count: Any) -> None:
        row = int(runs[0])
        c = constants(unpack(tables, row * fields))
        for i in range(count):
            if runs[i] != row:
                row = int(runs[i])
                c = constants(unpack(tables, row * fields))
            place, state = i * width, zero
            for j in range(dimension):
                state = replaced(state, j, work[place + j])
            new = apply(state, c, work[place + dimension], work[place + dimension + 1])
            look(work, place + dimension, state, c)
            for j in range(dimension):
                work[place + j] = new[j]
            runs[i] = DONE

    return images


def wide(given: Formulas, dimension: int) -> int:
    """Return the length of a row of states: letter and root are behind the state, the borders then in their place."""
    return dimension + max(2, len(given.borders))


def _same(p: Any) -> Any:
    return p


def _unguarded(function: Function, _nothing: Any) -> Function:
    return function


def _guarded(function: Function, nothing: Any) -> Function:
    """Return a function that in plain Python has no value where compiled code has none, instead of an exception."""

    def guarded(state: Any, *rest: Any) -> Any:
        try:
            return function(state, *rest)
        except Exception:
            return nothing

    return guarded


def _at_once(code: float, work: Any, rows: Any, runs: Any) -> None:
    """Apply compiled pieces, by their address, to all rows of states: compiled once for every map."""
    called_for_all(code, numbers(work), numbers(rows), 0, numbers(runs), len(runs))


class Images:
    """Images of states on pieces that are told, beyond their borders too, of a map by pieces."""

    def __init__(self, P: Map) -> None:
        assert P.formulas is not None
        self.P, self.dimension, self.borders = P, P.dimension, len(P.formulas.borders)
        self._width = wide(P.formulas, P.dimension)
        code = images_of(P.formulas, P.prepare, P.packed()[0], P.dimension)
        self._code = address(code, "sweep", "strict", f"a piece of {P.name}")

    def __reduce__(self) -> Any:
        return Images, (self.P,)  # code has another address elsewhere

    def __call__(self, rows: Floats, which: Any, states: Floats, letters: Any, roots: Any) -> tuple[Floats, Floats]:
        """Return images and values of all borders at states (n, dim).

        Parameters
        ----------
        rows : ndarray, shape (columns, parameters)
        which : array_like of int, shape (n,)
            The row of each state, best in order.
        states : ndarray, shape (n, dim)
        letters, roots : array_like, shape (n,)
            The piece of each, and the root that it gets.

        Returns
        -------
        images : ndarray, shape (n, dim)
        borders : ndarray, shape (n, borders)
        """
        d, n = self.dimension, len(states)
        work = np.zeros((n, self._width))
        work[:, :d], work[:, d], work[:, d + 1] = states, letters, roots
        runs = np.empty(n, np.int64)
        runs[:] = which
        table, first = np.ascontiguousarray(rows, np.float64), 0
        while first < n:
            at = slice(first, n)
            with suppress(UserCodeError):
                call(compiled(_at_once), self._code, work[at], table, runs[at], who=f"a piece of {self.P.name}")
            if runs[-1] == DONE:
                break
            first += int(np.argmax(runs[at] != DONE))  # here one has raised: it has no value
            work[first], runs[first], first = np.nan, DONE, first + 1
        return work[:, :d], work[:, d : d + self.borders]
