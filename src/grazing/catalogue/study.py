"""The record of a study: all that the command line, configurations, sweeps, figures and tables of it are made from."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any

Row = dict[str, Any]
PARAMETER, COORDINATE = "parameter", "coordinate"


@dataclass(frozen=True, kw_only=True)
class Study:
    """What can be asked for: the function that computes it, what it varies, and what is said of it.

    Functions are named as ``module:name`` where the module takes time to import, and are imported when they are first
    asked for. The arguments of ``compute`` are, in this order: a map or a model; what varies, if anything does; then,
    by name, its settings and those of ``order``, ``threads`` and ``progress`` that it has.

    Parameters
    ----------
    name : str
        Of the command, and of ``study`` in a configuration.
    place : int
        Where it stands in lists of all studies.
    compute : str
        The function.
    says : str
        What is computed, in a few words: the schema has it.
    help : str
        The same as a sentence.
    example : str
        What may follow the name of the command.
    prints : str
        What the command prints of a result.
    found : callable
        ``found(result)``: what was found, as text, numbers, and lists and tables of them.
    words : callable
        ``words(found, result, recipe)``: the same as lines of text.
    plan : str
        The function that makes the plan of its cells; none if it is computed as a whole.
    least, most : int
        How many parameters or coordinates vary. With ``most`` above 1 they are given as a mapping.
    varies : {"parameter", "coordinate"}
    form : {"values", "bounds"}
        How what varies is written: start:stop:count or a list, or low:high.
    of : {"map", "model"}
        What the function takes: a map, or the oscillator itself.
    dimension : int, optional
        How many coordinates the map must have.
    options : mapping of str to tuple
        Settings that are its own, or mean something else here: a kind of :data:`grazing.config.settings.KINDS` and its
        arguments.
    kept : tuple of str
        Settings that the plan finds by a trial, which a recipe then keeps.
    table : str
        The function that makes a labelled result of what ``compute`` returns, if that is none.
    figure : str, optional
        The function of :mod:`grazing.plot` that draws the result: the one called as ``compute`` is, if not given;
        empty if there is none.
    beside : tuple of str
        Keys of the configuration that say what the figure shows beside the result.
    undrawn : str
        Why there is no figure where nothing varies, if there is none then.
    titled : str
        How the titles begin of results that do not name their study.
    takes_long : str
        What takes long, in words: all of it; of a study with a plan, or one that says how far it is, what follows then.
    counts : str
        What its ambiguous results are.
    proves : str
        What can be proven of it, in words.
    prove : callable, optional
        ``prove(of, found)``: a row for each proof that is due, from the map or model and what ``compute`` returned.
    orbits : bool
        Whether it is a study of orbits and branches: its tables then stand beside the summary.

    Examples
    --------
    >>> from grazing.catalogue import studies
    >>> chart = studies()["chart"]
    >>> chart.function, chart.drawn_by, chart.most, chart.has("threads")
    ('chart', 'chart', 2, True)
    """

    name: str
    place: int
    compute: str
    says: str
    help: str
    example: str
    prints: str
    found: Callable[[Any], Row]
    words: Callable[..., list[str]]
    plan: str = ""
    least: int = 0
    most: int = 0
    varies: str = PARAMETER
    form: str = "values"
    of: str = "map"
    dimension: int | None = None
    options: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    kept: tuple[str, ...] = ()
    table: str = ""
    figure: str | None = None
    beside: tuple[str, ...] = ()
    undrawn: str = ""
    titled: str = ""
    takes_long: str = ""
    counts: str = "orbits"
    proves: str = ""
    prove: Callable[[Any, Any], list[Row]] | None = None
    orbits: bool = False

    @property
    def function(self) -> str:
        """Name of the function that computes it, which results record."""
        return self.compute.rpartition(":")[2]

    @property
    def drawn_by(self) -> str:
        """Name of the function of its figure, or empty."""
        return self.function if self.figure is None else self.figure

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


@cache
def named(text: str) -> Callable[..., Any]:
    """Return the function that a text names as ``module:name``."""
    module, _, name = text.partition(":")
    return getattr(import_module(module), name)  # type: ignore[no-any-return]
