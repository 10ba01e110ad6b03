"""What a map is made of, and what is known of it beyond its step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from grazing.copies import ByValue
from grazing.maps.derivative import Derived
from grazing.parameter import Parameter

if TYPE_CHECKING:
    from grazing.maps.map import Map
    from grazing.maps.settle import Explain, Settle
    from grazing.theory import WordOrbit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Origin(ByValue):
    """What a map is made of: ``P.origin`` of a map P. This one knows nothing beyond the step, and counts as false.

    Studies, orbits and proofs ask the origin for what it knows better than the step alone. A system of the library
    makes its maps with an origin of its own, which overrides what it knows; what is None here it need not know.

    Attributes
    ----------
    replace : callable, optional
        ``replace(params) -> Map``: the map at other parameter values, from a system that checks their ranges.
    block : callable, optional
        A faster twin of many steps, ``block(kind, rows, lanes, transient, found, arithmetic, block) -> tasks`` as in
        :func:`grazing.maps.blocks.ensemble_tasks`; :func:`grazing.testing.check_map` holds it to the step.
    derivative : callable, optional
        ``derivative(rows, arithmetic="strict") -> Derived``: the derivative of the step with the reset law or the
        system by address, so that it is compiled once for all of them.
    settle : callable, optional
        ``settle(row, state)`` decides a step that double precision could not decide, see :mod:`grazing.maps.settle`.
    explain : callable, optional
        ``explain(row, state)`` says in words what a user's law did wrong in the step from a state.
    clock : callable, optional
        ``clock(rows, first, last, letters, steps)``: the time, shape (columns, n), that orbits took for so many steps
        from the first states to the last ones (columns, dim, n), ``letters`` (columns, n) being their sum.
    boxes : callable, optional
        ``boxes(rows)``: the box at each row of parameters, shape (columns, dim, 2), where it moves with them.
    rounds : callable, optional
        ``rounds(rows)``: after how much each coordinate comes round, as a phase does after a period, shape
        (columns, dim); infinite for those that do not.
    orbits : callable, optional
        ``orbits(word, params)``: all periodic orbits of a word, admissible and virtual, solved by algebra.
    exact : bool
        Whether the tangent is exact; False, as for a reset law whose slope is a difference, marks what rests on it
        *numerical*.
    sized : bool
        Whether orbits that leave the box by many times its size, and go on growing, have diverged.
    model : Oscillator, optional
        The oscillator over one wall at rest that the map shows.
    rig : Rig, optional
        The oscillator that the map shows, over one wall or between several; ``walled`` if these are walls of its own.
    impacts_on : Table, optional
        The table of which the steps of the map are the impacts, one each.
    starts_only : bool
        Whether the box is only where starts are drawn, as on one object of a table, and says nothing of where orbits
        go: of those that leave it nothing is said.
    together : int
        Orbits that are worth computing in one go, where the map knows; else 0.
    stirred : tuple of str
        Coordinates in which copies of an orbit are moved a little to part from it, in their own units; all if empty.
    asks : str
        Which functions of the user's a step may call, for the sentence that says that one raised.
    section : {"strobe", "impact"}, optional
        Where the map shows that oscillator, exactly; None for a map that only comes near it.
    """

    replace: Callable[[Mapping[str, float]], Map] | None = None
    block: Callable[..., Any] | None = None
    derivative: Callable[..., Derived] | None = None
    settle: Settle | None = None
    explain: Explain | None = None
    clock: Callable[..., Floats] | None = None
    boxes: Callable[[Floats], Floats] | None = None
    rounds: Callable[[Floats], Floats] | None = None
    orbits: Callable[[str, Mapping[str, float]], Sequence[WordOrbit]] | None = None
    exact: bool = True
    sized: ClassVar[bool] = False
    model: Any = None
    rig: Any = None
    impacts_on: Any = None
    starts_only: ClassVar[bool] = False
    together: ClassVar[int] = 0
    stirred: ClassVar[tuple[str, ...]] = ()
    section: ClassVar[str | None] = None
    asks: str = "the reset law"
    #: What proves orbits of the map, ``module:function``; that of an oscillator refuses all others.
    prover: ClassVar[str] = "grazing.proof.certify:certify_impacts"

    @property
    def finder(self) -> str:
        """What finds the map's periodic orbits, ``module:class``, see :mod:`grazing.orbits.finder`."""
        return "grazing.orbits.search_steps:Steps"

    @property
    def equations(self) -> str:
        """What makes the equations that an orbit of the map solves, see :mod:`grazing.orbits.signature`."""
        return "grazing.orbits.signature:of_points"

    @property
    def walled(self) -> Any:
        """The oscillator between walls of its own that the map shows; None for any other map."""
        return self.rig if self.rig is not None and self.rig.walled else None

    def __bool__(self) -> bool:
        return type(self) is not Origin

    def __repr__(self) -> str:
        return f"<{type(self).__name__}>"

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of a parameter or coordinate: symbol, meaning, range, units."""
        return None

    def check(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a start that is not allowed."""

    def refuse_late(self, state: Sequence[float], params: Mapping[str, float]) -> None:
        """Raise InputError for a phase so late that a double has none, see :func:`grazing.parameter.refuse_late`."""

    def complete(self, rows: Floats) -> Floats:
        """Write parameters that follow from others into rows (..., parameters), in place; return these."""
        return rows

    def refuse_made(self, names: Sequence[str]) -> None:
        """Raise InputError for parameters that follow from others, and cannot vary by themselves."""

    def left(self, letters: Ints) -> NDArray[np.bool_]:
        """Return which steps end with an orbit that has left, as a ball that is down a drain, by their letters."""
        return np.zeros(letters.shape, np.bool_)

    def units_of(self, names: Sequence[str]) -> str:
        """Return the units of several coordinates, one after the other; ``"1"`` if all is dimensionless."""
        return "1"

    def unsettled(self) -> Origin:
        """Return the origin without its arithmetic for steps that double precision cannot decide."""
        found = copy(self)
        found.settle = None
        return found

    def eased(self) -> Origin:
        """Return the origin of the map that has images beside its orbits too, where no orbit may begin."""
        return self

    @property
    def followers(self) -> tuple[str, ...]:
        """Parameters that follow from others."""
        return ()

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of the origin beside the parameters."""
        return {}

    @property
    def config(self) -> dict[str, str]:
        """What decides a result beside the map's name, coordinates and parameters."""
        return {}


class Formula(Origin):
    """The origin of a map that is a formula with named parameters.

    Parameters
    ----------
    make : callable
        ``make(**params) -> Map``.
    known : mapping of str to Parameter
        What is known of its parameters.
    """

    def __init__(self, make: Callable[..., Map], known: Mapping[str, Parameter]) -> None:
        self.make, self.known = make, known

    def replace(self, params: Mapping[str, float]) -> Map:
        """Make the map at other values."""
        return self.make(**params)

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of a parameter."""
        return self.known.get(name)


#: The origin of a map of one's own.
NO_ORIGIN = Origin()
