"""The record of a study: all that the command line, configurations, sweeps, figures and tables of it are made from."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from grazing.late import named

Row = dict[str, Any]
PARAMETER, COORDINATE = "parameter", "coordinate"


@dataclass(frozen=True, kw_only=True)
class Study:
    """What can be asked for: the function that computes it, what it varies, and what is said of it.

    Functions are named as ``module:name`` where the module takes time to import, and are imported when they are first
    asked for. The arguments of ``compute`` are, in this order: a map or a model; what varies, if anything does; then,
    by name, its settings and those of ``order``, ``span``, ``threads`` and ``progress`` that it has. One with cells to
    sweep is :func:`grazing.studies.plan.planned`.

    Examples
    --------
    >>> from grazing.catalogue import studies
    >>> chart = studies()["chart"]
    >>> chart.function, chart.drawn_by, chart.most, chart.has("threads")
    ('chart', 'chart', 2, True)
    """

    #: Of the command, and of ``study`` in a configuration.
    name: str
    #: Where it stands in lists of all studies.
    place: int
    #: The function.
    compute: str
    #: What is computed: in a few words, for the schema; as a sentence; what may follow the name of the command.
    says: str
    help: str
    example: str
    #: What the command prints of a result: ``found(result)`` is text, numbers, and lists and tables of them, and
    #: ``words(found, result, recipe)`` the same as lines.
    prints: str
    found: Callable[[Any], Row]
    words: Callable[..., list[str]]
    #: How many parameters or coordinates vary; where several may, they are given as a mapping.
    least: int = 0
    most: int = 0
    varies: str = PARAMETER
    #: How what varies is written: *values* (start:stop:count or a list) or *bounds* (low:high).
    form: str = "values"
    #: What the function takes: a *map*, or the *model* itself; and how many coordinates the map must have.
    of: str = "map"
    dimension: int | None = None
    #: Settings that are its own, or mean something else here: a kind of :data:`grazing.config.settings.KINDS` and its
    #: arguments.
    options: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    #: Settings that the plan finds by a trial, which a recipe then keeps.
    kept: tuple[str, ...] = ()
    #: The function that makes a labelled result of what ``compute`` returns, if that is none.
    table: str = ""
    #: The function of :mod:`grazing.plot` that draws the result, that called as ``compute`` is if not given; empty if
    #: there is none. Why there is none where nothing varies.
    figure: str | None = None
    undrawn: str = ""
    #: Keys of the configuration that say what the figure shows beside the result.
    beside: tuple[str, ...] = ()
    #: How the titles begin of results that do not name their study.
    titled: str = ""
    #: What takes long, in words: all of it; of a function that says how far it is, what follows then.
    takes_long: str = ""
    #: What its ambiguous results are.
    counts: str = "orbits"
    #: What can be proven, in words; ``prove(of, found)`` gives a row for each proof, from the map or model and what
    #: ``compute`` returned.
    proves: str = ""
    prove: Callable[[Any, Any], list[Row]] | None = None
    #: Whether it is a study of orbits and branches: its tables then stand beside the summary.
    orbits: bool = False
    #: Of one of the model: whether it is offered for pinball tables as well. Whether it is of these alone.
    tables: bool = False
    tables_only: bool = False
    #: Whether its result is a motion that can be heard.
    sounds: bool = False

    @property
    def function(self) -> str:
        """Name of the function that computes it, which results record."""
        return self.compute.rpartition(":")[2]

    @property
    def drawn_by(self) -> str:
        """Name of the function of its figure, or empty."""
        return self.function if self.figure is None else self.figure

    @property
    def plan(self) -> Callable[..., Any] | None:
        """The function that makes the plan of its cells; None for what is computed as a whole."""
        return getattr(named(self.compute), "plan", None)

    @property
    def flown(self) -> bool:
        """Whether it is one motion of the oscillator itself."""
        return self.of == "model" and not self.most

    @property
    def single(self) -> bool:
        """Whether it is of one orbit, which begins at a state that is given."""
        return self.has("state")

    def has(self, argument: str) -> bool:
        """Say whether the function has an argument."""
        return argument in inspect.signature(named(self.compute)).parameters
