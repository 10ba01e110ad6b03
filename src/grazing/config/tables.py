"""Pinball tables in TOML files: objects by name, each with its kind, its numbers and its law. Nothing is executed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from inspect import signature
from pathlib import Path
from typing import Any

from grazing.billiard.objects import DRAIN, FLIPPER, GEOMETRY, Thing, checked_name
from grazing.billiard.players import NOBODY, flips, presses
from grazing.billiard.plunger import KNOWN as OF_PLUNGER
from grazing.billiard.plunger import Plunger
from grazing.billiard.strategy import Player
from grazing.billiard.table import OWN, Table, refuse_too_many, table
from grazing.config.problems import Problem, Refusal, refusal
from grazing.config.toml import read_toml
from grazing.oscillator.reset import KNOWN, Reset, active, newton, triggered
from grazing.outcome import InputError, abridged, listed, shown

#: Where the tables lie that ship with the library.
HOME = Path(__file__).parent / "tables"
LAWS: Mapping[str, Callable[..., Reset]] = {"newton": newton, "active": active, "triggered": triggered}
PLAYERS = "flips", "presses"


def shipped() -> list[str]:
    """Return the names of the tables that ship with the library."""
    return sorted(path.stem for path in HOME.glob("*.toml"))


class _Tried:
    """Makes parts of a table, and keeps all that is wrong with them."""

    def __init__(self) -> None:
        self.faults: list[Problem] = []

    def __call__(self, make: Callable[..., Any], *given: Any, at: str = "") -> Any:
        """Return what is made; nothing, and keep what is said of it, of what is refused."""
        try:
            return make(*given)
        except Refusal as error:
            self.faults += error.problems
        except InputError as error:
            said = str(error)
            self.faults.append(Problem((), said if said.startswith(at) else f"{at}: {said}"))

    def refuse(self) -> None:
        """Raise InputError if anything is wrong."""
        if self.faults:
            raise refusal(self.faults, "")


def _keys(given: Any, needed: list[str], optional: list[str], where: str) -> Mapping[str, Any]:
    """Return a table of TOML with all keys that it needs and no others, or raise InputError."""
    if not isinstance(given, Mapping):
        raise InputError(f"{where} is {shown(given)}; give a table of keys and values")
    allowed = listed([*needed, *optional])
    wrong = [f"has {shown(key)}; allowed are {allowed}" for key in given if key not in (*needed, *optional)]
    wrong += [f"has no {key}; it needs {listed(needed)}" for key in needed if key not in given]
    if wrong:
        raise refusal([Problem((), f"{where} {said}") for said in wrong], "")
    return given


def _one_of(given: Mapping[str, Any], key: str, allowed: Mapping[str, Any], where: str) -> str:
    found = given.get(key)
    if not (isinstance(found, str) and found in allowed):
        raise InputError(f"{where}.{key} = {shown(found)}; allowed are {listed(list(allowed))}")
    return found


def _object(name: str, given: Any) -> Thing:
    """Return an object of a table, or raise InputError that says all that is wrong with it."""
    where, tried = f"objects.{abridged(name)}", _Tried()
    if not isinstance(given, Mapping):
        raise InputError(f"{where} is {shown(given)}; give its kind, its numbers and its law")
    kind = tried(_one_of, given, "kind", GEOMETRY, where)
    called = tried(_one_of, given, "law", LAWS, where) if kind != DRAIN else None
    tried.refuse()  # what else it may have is not known
    numbers, law = {one.name: one for one in GEOMETRY[kind]}, LAWS[called] if called else None
    own = list(signature(law).parameters) if law else []
    tried(_keys, given, ["kind", *numbers, *(["law", *own] if law else [])], [], where)
    tried(checked_name, name, kind, at=where)
    for key, known in {**numbers, **{key: KNOWN[key] for key in own}}.items():
        if key in given:
            tried(known.check, given[key], at=where)
    tried.refuse()
    made = law(**{key: given[key] for key in own}) if law else None
    thing: Thing = tried(Thing, name, kind, {key: given[key] for key in numbers}, made, at=where)
    tried.refuse()
    return thing


def read_table(source: str | os.PathLike[str]) -> Table:
    """Return a pinball table from a TOML file, or one of those that ship with the library by its name.

    Parameters
    ----------
    source : path-like
        A file, or ``"classic"``, a pinball machine; ``"galton"``, a Galton board; ``"one_bumper"``, the nearest kin of
        the impact oscillator; ``"three_discs"``, the scatterer. A file has ``rho``, ``g`` and ``tilt``, which may be
        left out as in :func:`grazing.table`; in ``[objects]`` each object by its name, with its ``kind``, its numbers
        and its ``law`` with the numbers of that, called as in the table's parameters; and ``[flips]`` or ``[presses]``
        with what :func:`grazing.flips` or :func:`grazing.presses` take; and ``[plunger]`` with ``x``, ``y``, ``angle``,
        ``slow`` and ``fast`` of :func:`grazing.plunger`. It is read, and never executed.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        For a file that is missing or no TOML, and for what is no table, with the places of all that is wrong.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.read_table("three_discs")
    <Table A, B, C; rho=0, g=1, tilt=0>
    """
    known = isinstance(source, str) and source in shipped()
    path = HOME / f"{source}.toml" if known else source
    if isinstance(source, str) and not known and not source.endswith(".toml") and not os.path.exists(source):
        raise InputError(f"there is no file {shown(source)}; tables that ship are {listed(shipped())}")
    said, tried = read_toml(path), _Tried()
    tried(_keys, said, ["objects"], [*OWN, *PLAYERS, "plunger"], str(source))
    for name in OWN:
        if name in said:
            tried(OWN[name].check, said[name])
    things = tried(_things, said["objects"]) if "objects" in said else []
    player, launcher = tried(_player, said, str(source)), tried(_plunger, said)
    objects = [tried(_object, name, given) for name, given in things or ()]
    tried.refuse()
    return table(objects, **{key: said[key] for key in OWN if key in said}, player=player, plunger=launcher)


def _things(given: Any) -> Iterable[tuple[str, Any]]:
    if not isinstance(given, Mapping):
        raise InputError(f"objects is {shown(given)}; give a table of objects by their names")
    refuse_too_many(len(given), sum(isinstance(one, Mapping) and one.get("kind") == FLIPPER for one in given.values()))
    return given.items()


def _player(said: Mapping[str, Any], source: str) -> Player:
    if all(name in said for name in PLAYERS):
        raise InputError(f"{source} has {listed(list(PLAYERS))}; give one of them")
    if "flips" in said:
        return flips(**_keys(said["flips"], ["period", "hold"], ["phase"], "flips"))
    if "presses" not in said:
        return NOBODY
    if not isinstance(said["presses"], Mapping):
        raise InputError(f"presses is {shown(said['presses'])}; give the times of each flipper by its name")
    return presses(**said["presses"])


def _plunger(said: Mapping[str, Any]) -> Plunger | None:
    if "plunger" not in said:
        return None
    numbers = [name.partition(".")[2] for name in OF_PLUNGER]
    return Plunger(**_keys(said["plunger"], numbers, [], "plunger"))
