"""The map: a step on a section, with its parameters; the one idea that every study is written for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.kernel.compile import call
from grazing.kernel.lanes import runner, tangent_runner
from grazing.kernel.primitives import replaced
from grazing.outcome import DIVERGED, FATAL, InputError, UserCodeError
from grazing.parameter import checked_box, checked_params, parameter_tuple, updated, whole

#: Letters that are not counts: completed chatter and stuck throughout.
CHATTER_LETTER = -1
STUCK_LETTER = -2
NAN = float("nan")
INFINITY = float("inf")


class Segment(NamedTuple):
    """A piece of an orbit: points (n + 1, dim) with the start in row 0; letters (n,) and outcomes (n,) of the steps."""

    points: NDArray[np.float64]
    letters: NDArray[np.int64]
    outcomes: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Map:
    """A step on a section: ``step(state, c) -> (state, letter, outcome)``.

    Parameters
    ----------
    step : callable
        Plain scalar Python. ``state`` is a tuple of floats, ``c`` a named tuple of the parameters (or what
        ``prepare`` makes of them). Returns the next state, or (state, letter), or (state, letter, outcome).
    params : mapping of str to float
        Ordered; the fields of ``c``. They are arguments of the compiled code, never constants in it.
    coordinates : sequence of str
        Names of the state's components.
    box : sequence of (low, high)
        Where random starts are drawn, one pair per coordinate.
    letters : str, optional
        The symbol of letter 0, 1, ...; None for counts (the oscillator: impacts in the period).
    prepare : callable, optional
        ``prepare(p) -> c``, once per parameter value.
    tangent : callable, optional
        ``tangent(state, c) -> (state, letter, outcome, J)``, J row by row as a flat tuple. Without it
        :meth:`jacobian` uses central differences.
    block : callable, optional
        A faster twin of many steps; held to ``step`` by :func:`grazing.testing.check_map`.
    name : str, optional
        Shown in messages and figures.
    escape : float
        A coordinate beyond it ends the orbit with outcome *diverged*.
    check : callable, optional
        ``check(state, params)`` raises InputError for a start that is not allowed.
    exact : bool
        Whether ``tangent`` is exact; False, as for a reset law whose slope is a difference, marks what rests on it
        *numerical*.
    source : callable, optional
        ``source(params) -> Map`` makes the map again from the model behind it, which checks ranges.

    Raises
    ------
    InputError
        For parameters that are not finite numbers, or a box that does not fit the coordinates.
    UserCodeError
        If the step raises or returns what it must not on a state in the middle of the box.

    Examples
    --------
    >>> import grazing as gz
    >>> def step(state, p):
    ...     (x,) = state
    ...     return (p.a * x * (1.0 - x),)
    >>> P = gz.Map(step, params={"a": 3.2}, coordinates=("x",), box=((0.0, 1.0),))
    >>> P((0.5,))
    (array([0.8]), 0)
    >>> P.replace(a=2.0).iterate((0.5,), 2)[:, 0].tolist()
    [0.5, 0.5, 0.5]
    """

    step: Callable[..., Any]
    params: Mapping[str, float]
    coordinates: Sequence[str] = ("x",)
    box: Sequence[tuple[float, float]] = ((0.0, 1.0),)
    letters: str | None = None
    prepare: Callable[..., Any] | None = None
    tangent: Callable[..., Any] | None = None
    block: Callable[..., Any] | None = None
    name: str | None = None
    escape: float = math.inf
    check: Callable[..., None] | None = None
    exact: bool = True
    source: Callable[..., Map] | None = None
    _full_step: Callable[..., Any] = field(init=False, repr=False, default=None)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        params = checked_params(self.params)
        coordinates = tuple(self.coordinates)
        box = checked_box(self.box, coordinates)
        object.__setattr__(self, "params", MappingProxyType(params))
        object.__setattr__(self, "box", box)
        object.__setattr__(self, "coordinates", coordinates)
        object.__setattr__(self, "name", self.name or getattr(self.step, "__name__", "map"))
        if self._full_step is None:
            object.__setattr__(self, "_full_step", self.step if self.source is not None else _normalised(self))

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:g}" for name, value in self.params.items())
        return f"<Map {self.name}: ({', '.join(self.coordinates)}); {values}>"

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    def replace(self, **changes: float) -> Map:
        """Return the map with other parameter values; compiled code is kept.

        Parameters
        ----------
        **changes : float
            Names of :attr:`params`.
        """
        values = updated(self.params, changes, self.name or "map")
        if self.source is not None:  # the model behind the map checks the ranges
            return self.source(values)
        new = replace(self, params=values)
        object.__setattr__(new, "_full_step", self._full_step)
        return new

    def __call__(self, state: ArrayLike) -> tuple[NDArray[np.float64], int]:
        """Apply the step once: the next state, shape (dim,), and the letter."""
        segment = self.orbit(state, 1)
        return segment.points[1], int(segment.letters[0])

    def iterate(self, state: ArrayLike, n: int) -> NDArray[np.float64]:
        """Return n iterates, shape (n + 1, dim); row 0 is the start. After a fatal outcome rows are NaN."""
        return self.orbit(state, n).points

    def orbit(self, state: ArrayLike, n: int) -> Segment:
        """Return n iterates with letters and outcomes.

        Parameters
        ----------
        state : array_like, shape (dim,)
        n : int
            Number of steps, at least 0.

        Returns
        -------
        Segment
            ``points`` (n + 1, dim), ``letters`` (n,), ``outcomes`` (n,).
        """
        n = whole(n, "n", 0)
        start = self._start(state)
        lanes = start.reshape(-1, 1).copy()
        points, letters, outcomes = self.run(lanes, 0, n, records=max(n, 1))
        return Segment(np.vstack([start, points[:, :, 0]]), letters[:, 0], outcomes[:n, 0])

    def run(
        self, lanes: NDArray[np.float64], transient: int, keep: int, *, records: int = 1, arithmetic: str = "strict"
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """Advance many orbits at once; the start of every study.

        Parameters
        ----------
        lanes : ndarray, shape (dim, n)
            The starts; overwritten with the last states.
        transient, keep : int
            Steps that are thrown away, then steps that are kept.
        records : int
            1 folds the outcomes of an orbit into one integer; ``keep`` stores them per step.
        arithmetic : {"strict", "fast"}

        Returns
        -------
        points (keep, dim, n), letters (keep, n), outcomes (records, n)
        """
        dimension, n = lanes.shape
        points = np.empty((keep, dimension, n))
        letters = np.zeros((keep, n), np.int64)
        outcomes = np.zeros((records, n), np.int64)
        kind, row = self._packed()
        entry = runner(self._full_step, self.prepare, kind, dimension, arithmetic)
        call(entry, row, lanes, transient, points, letters, outcomes, who=f"the step of {self.name}")
        lost = ~np.isfinite(lanes).all(axis=0) & ((np.bitwise_or.reduce(outcomes, axis=0) & FATAL) == 0)
        outcomes[-1, lost] |= DIVERGED
        return points, letters, outcomes

    def jacobian(self, state: ArrayLike) -> NDArray[np.float64]:
        """Return the Jacobian of one step, shape (dim, dim).

        From ``tangent`` where the map has one; else from central differences, good to about ten digits. NaN where
        it is undefined (a graze, an impact of zero speed).
        """
        start = self._start(state)
        if self.tangent is None:
            return self._differences(start)
        matrix = np.empty((self.dimension, self.dimension))
        kind, row = self._packed()
        entry = tangent_runner(self.tangent, self.prepare, kind, self.dimension)
        call(entry, row, start.reshape(-1, 1).copy(), matrix, who=f"the tangent of {self.name}")
        return matrix

    def _differences(self, start: NDArray[np.float64]) -> NDArray[np.float64]:
        steps = 6e-6 * np.maximum(1.0, np.abs(start))  # cube root of the rounding error: balances it against curvature
        plus = start[:, None] + np.diag(steps)
        minus = start[:, None] - np.diag(steps)
        lanes = np.concatenate([plus, minus], axis=1)
        self.run(lanes, 1, 0)
        d = self.dimension
        slopes: NDArray[np.float64] = (lanes[:, :d] - lanes[:, d:]) / np.diagonal(plus - minus)
        return slopes

    def _start(self, state: ArrayLike) -> NDArray[np.float64]:
        try:
            start = np.atleast_1d(np.asarray(state, dtype=np.float64))
        except (TypeError, ValueError):
            raise InputError(
                f"state is {state!r}; give {self.dimension} numbers ({', '.join(self.coordinates)})"
            ) from None
        if start.shape != (self.dimension,):
            raise InputError(
                f"state has shape {start.shape}; {self.name} needs ({self.dimension},): {', '.join(self.coordinates)}"
            )
        if not np.isfinite(start).all():
            raise InputError(f"state {start.tolist()} is not finite; give finite {', '.join(self.coordinates)}")
        if self.check is not None:
            self.check(start, self.params)
        return start

    def _packed(self) -> tuple[type, NDArray[np.float64]]:
        return parameter_tuple(tuple(self.params)), np.array(list(self.params.values()) or [0.0], dtype=np.float64)


def _normalised(P: Map) -> Callable[..., Any]:
    """Wrap a step so that it returns (state, letter, outcome) whatever form the user chose; try it once first."""
    step, escape, dimension = P.step, P.escape, P.dimension
    kind, row = P._packed()
    p = kind(*row.tolist())
    middle = tuple(0.5 * (low + high) for low, high in P.box)
    try:
        result = step(middle, P.prepare(p) if P.prepare is not None else p)
    except Exception as error:
        raise UserCodeError(
            f"the step of {P.name} raised {type(error).__name__}: {error} (state {middle}, parameters {dict(P.params)})"
        ) from error
    form = _form(result, dimension)
    if form == 0:
        raise UserCodeError(
            f"the step of {P.name} returned {result!r}; allowed are a tuple of {dimension} number(s), "
            "or (state, letter), or (state, letter, outcome)"
        )
    if form == 1:

        def bare(state: Any, c: Any) -> Any:
            return step(state, c), 0, 0

        return _ending(bare, escape)
    if form == 2:

        def lettered(state: Any, c: Any) -> Any:
            new, letter = step(state, c)
            return new, letter, 0

        return _ending(lettered, escape)
    return _ending(step, escape)


def _ending(step: Callable[..., Any], escape: float) -> Callable[..., Any]:
    """Wrap a step so that an orbit ends, in NaN, beyond ``escape`` or with a fatal outcome."""

    def ending(state: Any, c: Any) -> Any:
        new, letter, outcome = step(state, c)
        for x in new:
            if abs(x) > escape or not abs(x) < INFINITY:
                outcome = outcome | DIVERGED
        if outcome & FATAL:
            for i in range(len(new)):
                new = replaced(new, i, NAN)
        return new, letter, outcome

    return ending


def _form(result: object, dimension: int) -> int:
    """Return which form a step's result has: 1 state, 2 with letter, 3 with letter and outcome, 0 none of them."""

    def is_state(value: object) -> bool:
        return (
            isinstance(value, tuple)
            and len(value) == dimension
            and all(isinstance(x, (int, float, np.floating)) and not isinstance(x, bool) for x in value)
        )

    if is_state(result):
        return 1
    if isinstance(result, tuple) and len(result) in (2, 3) and is_state(result[0]):
        if all(isinstance(x, (int, np.integer)) and not isinstance(x, bool) for x in result[1:]):
            return len(result)
    return 0
