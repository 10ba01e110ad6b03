"""The map: a step on a section, with its parameters; the one idea that every study is written for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.copies import ByValue, alike, by_value, packed, plain
from grazing.kernel.compile import FLAGS, call
from grazing.kernel.lanes import runner
from grazing.maps.bordered import Formulas, Images, formulas, step_of, tried
from grazing.maps.columns import (
    Columns,
    checked_columns,
    empty_columns,
    run_columns,
    size_of_columns,
    stay_ended,
    step_tasks,
)
from grazing.maps.derivative import Derived, differences_of, extended, stepping, tangent_runner, units_of
from grazing.maps.hits import Alphabet
from grazing.maps.origin import NO_ORIGIN, Origin
from grazing.maps.own_step import normalised
from grazing.maps.pointed import pointed_derivative, pointed_loop
from grazing.maps.settle import settle_orbits, warn_of_bad_law
from grazing.memory import refuse_too_large
from grazing.outcome import AMBIGUOUS, BAD_LAW, InputError, listed, shown
from grazing.parameter import (
    Parameter,
    checked_box,
    checked_coordinates,
    checked_params,
    checked_text,
    in_order,
    parameter_tuple,
    parameters,
    updated,
    whole,
)
from grazing.pool import Progress, Task

if TYPE_CHECKING:
    from grazing.oscillator.model import Oscillator
    from grazing.oscillator.walled import Walled

#: Letters that are not counts: completed chatter and stuck throughout.
CHATTER_LETTER = -1
STUCK_LETTER = -2
GREEK = ("alpha", "beta", "gamma", "delta", "lambda", "mu", "nu", "omega", "phi", "rho", "sigma", "tau", "theta")
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
NAN = float("nan")
INFINITY = float("inf")

ESCAPE = Parameter("escape", "c", "a coordinate beyond it ends the orbit; with inf, none does", 0.0, open="low")


def _checked_letters(letters: Any) -> str | Alphabet | None:
    """Return the symbols of letters, or raise InputError for what words cannot be read from."""
    if letters is None or isinstance(letters, Alphabet):
        return letters
    found: dict[str, None] = {}
    wrong = InputError(f"letters is {shown(letters)}; give a text with a character for each, all different, as 'LR'")
    try:
        for text in in_order(letters):  # each looked at as it comes: there may be no end of them
            if not isinstance(text, str) or not text:
                raise wrong
            for one in text:
                if one in found or not one.isprintable() or one.isspace():
                    raise wrong
                found[one] = None
    except TypeError:
        raise wrong from None
    if not found:
        raise wrong
    return "".join(found)


def _checked_escape(escape: Any) -> float:
    """Return from where on orbits have escaped, or raise InputError; infinity for nowhere."""
    nowhere = isinstance(escape, (float, np.floating)) and escape == INFINITY
    return INFINITY if nowhere else ESCAPE.check(escape)


@by_value
class Segment(NamedTuple):
    """A piece of an orbit: points (n + 1, dim) with the start in row 0; letters (n,) and outcomes (n,) of the steps.

    Then how far to trust it: the height of its narrowest miss, the speed of its slowest impact (infinity for none) and
    the number of steps with a decision that could not be made for certain.
    """

    points: Floats
    letters: Ints
    outcomes: Ints
    near_miss: float = math.inf
    slowest: float = math.inf
    undecided: int = 0


#: What two equal maps have in common; all else follows from it, or is compiled from it.
VALUE = (
    "name", "params", "coordinates", "box", "letters", "escape", "origin", "step", "prepare", "tangent", "pieces",
    "border",
)  # fmt: skip
#: What may differ from the map that its origin makes.
OWN = ("name", "coordinates", "box", "letters", "escape")


@dataclass(frozen=True, eq=False)
class Map(ByValue):
    """A step on a section: ``step(state, c) -> (state, letter, outcome)``, or pieces and the border between them.

    A map of your own needs the first five arguments at most, and ``pieces`` with ``border`` in place of ``step``. The
    others are advanced: what makes it faster or says more of it.

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
    letters : str or Alphabet, optional
        The symbol of letter 0, 1, ...; None for counts (the oscillator: impacts in the period); between two walls,
        the walls that letters name.
    pieces : mapping of str to callable, optional
        Instead of ``step``: for each letter, one character, ``f(state, c) -> state``, a formula that holds beyond its
        border too. So virtual orbits, border collisions and their loci are found from both sides. ``f(state, c,
        root)``, one of two pieces, gets the square root of its distance from the border: positive on its own side,
        negative on virtual orbits, which go on smoothly through it.
    border : callable or sequence of callable, optional
        ``border(state, c) -> float`` is negative where the first piece holds; the second one holds where it is 0 or
        positive. For more pieces a tuple, one less than pieces: each but the last holds where its border is the first
        one that is negative.

    Other Parameters
    ----------------
    prepare : callable, optional
        ``prepare(p) -> c``, once per parameter value.
    tangent : callable, optional
        ``tangent(state, c) -> (state, letter, outcome, J)``, J row by row as a flat tuple. Without it
        :meth:`jacobian` uses central differences.
    name : str, optional
        Shown in messages and figures.
    escape : float
        A coordinate beyond it ends the orbit with outcome *diverged*.
    origin : Origin, optional
        What the map is made of, which knows more of it, see :mod:`grazing.maps.origin`. Maps of the library have one.

    Raises
    ------
    InputError
        For parameters that are not finite numbers, or a box that does not fit the coordinates.
    UserCodeError
        If the step raises or returns what it must not on a state in the middle of the box, or a piece on its side.

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

    By pieces, the skew tent map and its border collision:

    >>> def left(state, p):
    ...     return (p.a * state[0] + p.mu,)
    >>> def right(state, p):
    ...     return (p.b * state[0] + p.mu,)
    >>> def border(state, p):
    ...     return state[0]
    >>> params = {"a": 0.5, "b": -0.6, "mu": -0.2}
    >>> T = gz.Map(pieces={"L": left, "R": right}, border=border, params=params, box=((-1.0, 1.0),))
    >>> (orbit,) = gz.periodic_orbits(T, 1)
    >>> [(one.type, abs(one.value) < 1e-12) for one in gz.continuation(T, orbit, "mu", (-0.5, 0.5)).special]
    [('bcb', True)]
    """

    step: Callable[..., Any] = None  # type: ignore[assignment]  # made of the pieces where there are any
    params: Mapping[str, float] = field(default_factory=dict)
    coordinates: Sequence[str] = ("x",)
    box: Sequence[tuple[float, float]] = ((0.0, 1.0),)
    letters: str | Alphabet | None = None
    prepare: Callable[..., Any] | None = None
    tangent: Callable[..., Any] | None = None
    pieces: Mapping[str, Callable[..., Any]] | None = None
    border: Callable[..., Any] | Sequence[Callable[..., Any]] | None = None
    name: str | None = None
    escape: float = math.inf
    origin: Origin = NO_ORIGIN
    _full_step: Callable[..., Any] = field(init=False, repr=False, default=None)  # type: ignore[assignment]
    formulas: Formulas | None = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        if self.name is not None and not isinstance(self.name, str):
            raise InputError(f"name is {shown(self.name)}; give a text, or leave it out")
        for function in ("step", "prepare", "tangent"):
            if not (getattr(self, function) is None or callable(getattr(self, function))):
                raise InputError(f"{function} is {shown(getattr(self, function))}; give a function, or leave it out")
        params = checked_params(self.params)
        coordinates = checked_coordinates(self.coordinates)
        box = checked_box(self.box, coordinates)
        object.__setattr__(self, "params", MappingProxyType(params))
        object.__setattr__(self, "box", box)
        object.__setattr__(self, "coordinates", coordinates)
        object.__setattr__(self, "letters", _checked_letters(self.letters))
        object.__setattr__(self, "escape", _checked_escape(self.escape))
        if not isinstance(self.origin, Origin):
            raise InputError(f"origin is {shown(self.origin)}; leave it out: maps of the library have one")
        if self.pieces is not None or self.border is not None:
            self._join_pieces()
        elif self.step is None:
            raise InputError("step is missing; give a function step(state, p), or pieces={'L': f, 'R': g} and border")
        object.__setattr__(self, "name", self.name or getattr(self.step, "__name__", "map"))
        if self._full_step is None:
            object.__setattr__(self, "_full_step", self.step if self.origin.replace is not None else normalised(self))

    def _join_pieces(self) -> None:
        """Make step and letters of the pieces; a map of the library may have a faster step of its own."""
        letters, given = formulas(self.pieces, self.border)
        made, name = step_of(given), self.name or f"map of pieces {listed(letters)}"
        known = getattr(self.step, "formulas", None)
        own = self.origin.replace is None
        if self.step is not None and own and known != given:
            raise InputError("step is given with pieces; give one of them: the step is made of pieces and border")
        if self.letters not in (None, letters):
            raise InputError(f"letters is {shown(self.letters)} for the pieces {letters}; leave it out")
        values = {"step": made if own or self.step is None else self.step, "letters": letters,
                  "name": name, "formulas": given, "pieces": MappingProxyType(dict(self.pieces or {}))}  # fmt: skip
        for key, value in values.items():
            object.__setattr__(self, key, value)
        if own:
            p = parameters(self.params)
            tried(given, letters, name, self.box, self.prepare(p) if self.prepare is not None else p)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Map) and all(alike(getattr(self, name), getattr(other, name)) for name in VALUE)

    __hash__ = ByValue.__hash__

    def __reduce__(self) -> Any:
        if self.origin.replace is not None:
            return _made_again, (self.origin, dict(self.params), {name: getattr(self, name) for name in OWN})
        left_out = ("step",) if self.pieces is not None else ()  # made again
        kept = [item.name for item in fields(self) if item.init and item.name not in left_out]
        return _built_again, ({name: packed(getattr(self, name)) for name in kept},)

    def __repr__(self) -> str:
        values = listed(f"{name}={value:g}" for name, value in self.params.items())
        return f"<Map {self.name}: ({listed(self.coordinates)}); {values}>"

    @property
    def _linked(self) -> bool:
        """Whether kernels get the step by its address: of a map of one's own no more is compiled."""
        return self.origin.replace is None and self.prepare is None

    @property
    def model(self) -> Oscillator | None:
        """The oscillator over one wall that the map shows, exactly or nearly; None for any other map."""
        return self.origin.model  # type: ignore[no-any-return]

    @property
    def walled(self) -> Walled | None:
        """The oscillator that the map shows at the strobe, between walls of its own; None for any other map."""
        return self.origin.walled  # type: ignore[no-any-return]

    @property
    def section(self) -> str | None:
        """Where the map shows its model exactly: "strobe" or "impact"; None for any other map."""
        return self.origin.section

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
        if self.origin.replace is not None:  # it checks the ranges
            return self.origin.replace(values)
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
            ``points`` (n + 1, dim), ``letters`` (n,), ``outcomes`` (n,), ``near_miss``, ``slowest``, ``undecided``.
        """
        n = whole(n, "n", 0)
        start = self._start(state)
        lanes = start.reshape(1, -1, 1).copy()
        found = self.run_columns(self.packed()[1], lanes, 0, n, records=max(n, 1), arithmetic="strict", threads=1)
        points = np.empty((n + 1, self.dimension))
        points[0], points[1:] = start, found.points[0, :, :, 0]
        return Segment(
            points,
            found.letters[0, :, 0],
            found.outcomes[0, :n, 0],
            float(found.near_miss[0, 0]),
            float(found.slowest[0, 0]),
            int(found.undecided[0, 0]),
        )

    def run(
        self, lanes: Floats, transient: int, keep: int, *, records: int = 1, arithmetic: str = "strict"
    ) -> tuple[Floats, Ints, Ints]:
        """Advance many orbits at once.

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
        row = self.packed()[1][None]
        there = lanes[None] if isinstance(lanes, np.ndarray) else lanes
        found = self.run_columns(row, there, transient, keep, records=records, arithmetic=arithmetic, threads=1)
        return found.points[0], found.letters[0], found.outcomes[0]

    def run_columns(
        self,
        rows: ArrayLike,
        lanes: Floats,
        transient: int,
        keep: int,
        *,
        records: int = 1,
        arithmetic: str = "fast",
        algorithm: str | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Columns:
        """Advance many orbits at many parameter values: the door through which every study enters.

        Parameters
        ----------
        rows : array_like, shape (columns, len(params))
            Parameter values in the order of :attr:`params`, finite and in range: studies check them, this does not.
        lanes : ndarray of float, shape (columns, dim, n)
            The starts; overwritten with the last states.
        transient, keep : int
            Steps that are thrown away, then steps that are kept.
        records : int
            1 folds the outcomes of an orbit into one integer; ``keep`` stores them per step.
        arithmetic : {"fast", "strict"}
            strict for the same bits on every machine.
        algorithm : {"block", "scalar"}, optional
            Whether to use the map's ``block``, where it has one. None for block in fast and scalar in strict
            arithmetic. The two make the same decisions and agree to rounding.
        threads : int, optional
            None for one per processor; the result does not depend on it.
        progress : callable, optional
            ``progress(done, total)``, called now and then with a number of finished tasks.

        Returns
        -------
        Columns
            points (columns, keep, dim, n), letters (columns, keep, n), outcomes (columns, records, n), and per orbit
            (columns, n) near_miss, slowest and undecided.

        Raises
        ------
        InputError
            For shapes that do not fit, or a result larger than half of the memory.

        Examples
        --------
        >>> import grazing as gz, numpy as np
        >>> G = gz.gap_map(lam=0.5, mu=0.1, l=0.1)
        >>> found = G.run_columns([[0.5, 0.1, 0.1], [0.5, 0.07, 0.1]], np.zeros((2, 1, 4)), 100, 6)
        >>> found.letters[1, :, 0].tolist()
        [0, 1, 0, 0, 1, 0]
        """
        table = checked_columns(rows, lanes, self)
        transient, keep = whole(transient, "transient", 0), whole(keep, "keep", 0)
        if not isinstance(arithmetic, str) or arithmetic not in FLAGS:
            raise InputError(f"arithmetic is {shown(arithmetic)}; allowed are 'strict' and 'fast'")
        if algorithm is not None and not (isinstance(algorithm, str) and algorithm in ("block", "scalar")):
            raise InputError(f"algorithm is {shown(algorithm)}; allowed are 'block' and 'scalar'")
        records = whole(records, "records", 1)
        if records not in (1, max(keep, 1)):
            raise InputError(f"records = {records}; allowed are 1 and keep = {keep}")
        shape = len(table), self.dimension, lanes.shape[2], keep, records
        refuse_too_large(
            size_of_columns(*shape),
            f"reduce columns ({shape[0]}), starts ({shape[2]}) or keep ({keep}); keep=0 stores the last states only",
        )
        block = algorithm == "block" or (algorithm is None and arithmetic == "fast")
        whole_lanes = np.ascontiguousarray(lanes, np.float64)
        starts = None if self.origin.settle is None is self.origin.explain else whole_lanes.copy()

        def again(row: Floats, state: Floats, n: int) -> Columns:
            one, lane = empty_columns(1, self.dimension, 1, n, n), state.reshape(1, -1, 1).copy()
            run_columns(self._tasks(row[None], lane, 0, one, arithmetic, block), lane, one, 1, None)
            return one

        found = empty_columns(*shape)
        if 0 in (shape[0], shape[2]):
            return found
        tasks = self._tasks(table, whole_lanes, transient, found, arithmetic, block)
        run_columns(tasks, whole_lanes, found, threads, progress)
        if self.origin.settle is not None and self.origin.block is None:  # a block counts them itself
            found.undecided[...] = (np.bitwise_or.reduce(found.outcomes, axis=1) & AMBIGUOUS) != 0
        if self.origin.settle is not None and starts is not None and found.undecided.any():
            settle_orbits(table, starts, whole_lanes, transient, found, self.origin.settle, again)
            stay_ended(found)
        if starts is not None and self.origin.explain is not None and (found.outcomes & BAD_LAW).any():
            warn_of_bad_law(table, starts, transient + keep, found, self.origin.explain, again)
        if whole_lanes is not lanes:
            lanes[...] = whole_lanes
        return found

    def _tasks(
        self, rows: Floats, lanes: Floats, transient: int, found: Columns, arithmetic: str, block: bool
    ) -> list[Task]:
        kind = parameter_tuple(tuple(self.params))
        known = self.origin
        if known.block is not None:
            return known.block(kind, rows, lanes, transient, found, arithmetic, block)  # type: ignore[no-any-return]
        who, step, prepare, source, loop = f"the step of {self.name}", self._full_step, self.prepare, None, None
        if known.derivative is not None:  # compiled once, whatever the law or system; the same bits as the own step
            tangent, prepare, kind, rows, source, alone, loop = known.derivative(rows, arithmetic)
            who, step = who if self._linked else f"{known.asks} of {self.name}", alone or stepping(tangent)
        if loop is None and prepare is None:
            loop = pointed_loop(step, kind, self.dimension, arithmetic, who)
        loop = loop or runner(step, prepare, kind, self.dimension, arithmetic)
        return step_tasks(loop, rows, lanes, transient, found, who, source)

    def jacobian(self, state: ArrayLike) -> NDArray[np.float64]:
        """Return the Jacobian of one step, shape (dim, dim).

        From ``tangent`` where the map has one; else from central differences, good to about ten digits. NaN where
        it is undefined (a graze, an impact of zero speed).
        """
        start = self._start(state)
        matrix = np.empty((self.dimension, self.dimension))
        derived = self.derivative(self.packed()[1][None])
        entry = tangent_runner(derived.tangent, derived.prepare, derived.kind, self.dimension)
        call(entry, derived.rows[0], start.reshape(-1, 1).copy(), matrix, who=f"the tangent of {self.name}")
        return matrix

    def images(self) -> Images:
        """Return what applies the pieces of a map by pieces, beyond their borders too; raise InputError for others."""
        if self.formulas is None:
            raise InputError(f"{self.name} has no pieces; make it with gz.Map(pieces={{'L': f, 'R': g}}, border=h)")
        return Images(self)

    def derivative(self, rows: Floats) -> Derived:
        """Return the derivative of the step at parameter values ``rows`` (columns, parameters), ready to compile.

        That is the map's ``tangent``, compiled once for all reset laws or systems where there is one, else central
        differences. Where a step is long, or one's own, kernels get no more of it than an address.
        """
        each = self.packed()[1]  # kernels read so many numbers of a row, whatever there is
        if not isinstance(rows, np.ndarray) or rows.dtype != each.dtype or rows.shape[1:] != each.shape:
            raise InputError(f"rows is {shown(rows)}; give an array of floats, shape (columns, {len(each)})")
        if self.origin.derivative is not None:
            given = self.origin.derivative(rows)
        else:
            flat = np.ascontiguousarray(rows)
            given = Derived(extended(kernels_of(self)[1]), self.prepare, self.packed()[0], flat, flat)
        if self._linked or given.prepare is not None:
            return pointed_derivative(given, self.dimension, f"the step of {self.name}")
        return given

    def _start(self, state: ArrayLike) -> NDArray[np.float64]:
        try:
            if np.iscomplexobj(state):
                raise TypeError
            start = np.atleast_1d(np.asarray(in_order(state), dtype=np.float64))
        except Exception:  # of whatever object was given, or of one too large
            raise InputError(
                f"state is {shown(state)}; give {self.dimension} numbers ({', '.join(self.coordinates)})"
            ) from None
        if start.shape != (self.dimension,):
            raise InputError(
                f"state has shape {start.shape}; {self.name} needs ({self.dimension},): {', '.join(self.coordinates)}"
            )
        if not np.isfinite(start).all():
            raise InputError(f"state {start.tolist()} is not finite; give finite {', '.join(self.coordinates)}")
        self.origin.check(start.tolist(), self.params)
        return start

    def describe(self, name: str) -> Parameter:
        """Return what is known of a parameter or coordinate: symbol, meaning, range, units."""
        known = self.origin.describe(checked_text(name))
        if known is not None:
            return known
        full = "lambda" if name == "lam" else name
        kind = "parameter" if name in self.params else "coordinate"
        return Parameter(name, f"\\{full}" if full in GREEK else name, f"{kind} {name}")

    def packed(self) -> tuple[type, NDArray[np.float64]]:
        """Return the type of the parameters' named tuple and their values: how a kernel gets them."""
        return parameter_tuple(tuple(self.params)), np.array(list(self.params.values()) or [0.0], dtype=np.float64)


def kernels_of(P: Map) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the step of a map as kernels take it, and its derivative: ``tangent``, or else by differences."""
    step, tangent = P._full_step, P.tangent
    return step, tangent if tangent is not None else differences_of(step, P.dimension, units_of(P.box))


def _made_again(origin: Any, params: dict[str, float], own: dict[str, Any]) -> Map:
    """Return a map as its origin makes it, with what was changed since."""
    made: Map = origin.replace(params)
    for name, value in own.items():
        object.__setattr__(made, name, value)
    return made


def _built_again(parts: dict[str, Any]) -> Map:
    """Return a map from the fields that a pickle keeps."""
    return Map(**{name: plain(value) for name, value in parts.items()})


def swift(P: Map) -> Map:
    """Return the map without its exact arithmetic for steps that double precision cannot decide.

    For states that are guesses, or lie at a cut that is bisected to rounding: there either decision is right.
    """
    return P if P.origin.settle is None else replace(P, origin=P.origin.unsettled())


def eased(P: Map) -> Map:
    """Return the map with images beside its orbits too, where no orbit may begin: for Newton's method."""
    origin = P.origin.eased()
    return P if origin is P.origin else replace(P, origin=origin)
