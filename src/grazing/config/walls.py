"""Walls in a configuration: which law each has, and on which side of the ball it is; their numbers are parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grazing.config.parameters import AMPLITUDES, LAWS, STIFFNESS, defaults_of, law_names, optional
from grazing.oscillator.forcing import Forcing
from grazing.oscillator.model import pinball
from grazing.oscillator.si import based_on
from grazing.oscillator.wall import SIDES, wall
from grazing.oscillator.walled import Walled
from grazing.outcome import InputError, shown

#: What is said of the walls of a configuration.
SAYS = "one wall or two, each with its law, in place of law and sigma: A=newton,B=active; a single one may be above"
NAMED = "a name is one capital letter other than C and S"
#: Numbers with which the names of a model's parameters are found.
SOME = {"alpha": 1.0, "omega": 1.0, "t0": 0.0, "offset": 0.0}


def checked_walls(value: Any) -> dict[str, str]:
    """Return the law and side of each wall from a table, or from text such as ``A=newton,B=active``."""
    given = value
    if isinstance(value, str):
        pairs = [([*item.strip().split("=", 1), ""])[:2] for item in value.split(",")]
        given = dict(pairs)
        if len(given) < len(pairs):
            raise InputError(f"walls = {shown(value)}: a name is given twice; {NAMED}")
    if not isinstance(given, Mapping) or not 1 <= len(given) <= 2:
        raise InputError(f"walls = {shown(value)}; give one or two, such as A=newton,B=active")
    found = {}
    for name, text in given.items():
        law, _blank, side = str(text).strip().partition(" ")
        if not (isinstance(name, str) and len(name) == 1 and "A" <= name <= "Z" and name not in "CS"):
            raise InputError(f"walls has {shown(name)}; {NAMED}")
        if law not in LAWS or side.strip() not in ("", *SIDES):
            raise InputError(f"walls.{name} = {shown(text)}; allowed are {_laws()}, such as 'newton above'")
        found[name] = " ".join([law, *side.split()])
    return found


def _laws() -> str:
    return f"{', '.join(LAWS)}, each alone or with above or below"


_SHAPES = [f"{law}{side}" for law in LAWS for side in ("", *(f" {side}" for side in SIDES))]
Walls = optional(
    checked_walls,
    {
        "type": "object",
        "propertyNames": {"pattern": "^[ABD-RT-Z]$"},
        "additionalProperties": {"enum": _SHAPES},
        "minProperties": 1,
        "maxProperties": 2,
    },
)


def flat(table: Any, every: bool = False) -> Any:
    """Return a table with ``A.r`` for r in a table A, as TOML reads ``A.r = 0.8``; what is no table stays as it is.

    Walls have names of one letter; ``every`` takes others, too.
    """
    if not isinstance(table, Mapping):
        return table
    nested = {
        key: value for key, value in table.items() if isinstance(value, Mapping) and (every or len(str(key)) == 1)
    }
    inside = {f"{key}.{name}": item for key, value in nested.items() for name, item in value.items()}
    return {**inside, **{key: value for key, value in table.items() if key not in nested}}


def front_of(walls: Mapping[str, str], name: str) -> str:
    """Return what stands before the parameters of a wall: nothing where there is one wall only."""
    return f"{name}." if len(walls) > 1 else ""


def sides_of(walls: Mapping[str, str]) -> dict[str, str]:
    """Return on which side of the ball each wall is: of two the first is below it, unless a side is said."""
    said = {name: text.partition(" ")[2] for name, text in walls.items()}
    first = said[next(iter(said))] if said else ""
    turned = first == "above" and len(said) > 1
    usual = dict(zip(said, ("above", "below") if turned else ("below", "above"), strict=False))
    return {name: side or usual[name] for name, side in said.items()}


def last_of(name: str) -> str:
    """Return the name of a parameter without that of its wall."""
    return name.rpartition(".")[2]


def walled_defaults(walls: Mapping[str, str], varied: Mapping[str, Any], spring: str = "k") -> dict[str, Any]:
    """Return the parameters of a model with these walls, in order, with defaults: 0 for what leaves a term out."""
    flight = {name: None for name in ("alpha", spring, "omega")}
    known: dict[str, Any] = {**flight, "t0": defaults_of(pinball)["t0"], "offset": 0.0, "cos": None, "sin": []}
    for name, text in walls.items():
        front, law = front_of(walls, name), text.partition(" ")[0]
        known[f"{front}sigma"] = None
        known |= {f"{name}.{wave}": [] for wave in AMPLITUDES}
        known |= {f"{front}{own}": None for own in law_names(law)}
    for name in varied:
        front, _dot, last = name.rpartition(".")
        wave = f"{front}.{last[:3]}" if front else last[:3]
        if last[:3] in AMPLITUDES and last[3:].isdigit() and not known.get(wave, True):
            known[wave] = [0.0] * int(last[3:])
    return known


def walled_of(
    walls: Mapping[str, str], given: Mapping[str, Any], mass: float | None = None, base: Any = None
) -> Walled:
    """Return the model of these walls, with all parameters given; amplitudes are lists. ``base`` is text."""
    omega, t0 = given["omega"], given["t0"]

    def made(name: str, text: str) -> Any:
        law, _blank, side = text.partition(" ")
        front = front_of(walls, name)
        waves = [tuple(given.get(f"{name}.{wave}") or ()) for wave in AMPLITUDES]
        motion = Forcing(omega, t0, 0.0, *waves) if any(waves) else None
        bounce = LAWS[law](**{own: given[f"{front}{own}"] for own in law_names(law)})
        return wall(given[f"{front}sigma"], bounce, side or None, motion, name)

    force = Forcing(omega, t0, given["offset"], tuple(given["cos"]), tuple(given["sin"]))
    stops = [made(name, text) for name, text in walls.items()]
    spring = {"k": None} | {name: given[name] for name in ("k", STIFFNESS) if name in given}
    return Walled(given["alpha"], forcing=force, walls=stops, mass=mass, base=based_on(base, force), **spring)


def parameters_of(
    walls: Mapping[str, str], given: Mapping[str, Any], varied: Mapping[str, Any], spring: str
) -> list[str]:
    """Return the names of the parameters that can vary."""
    usual = walled_defaults(walls, varied, spring)
    some = {name: 0.5 if value is None else value for name, value in usual.items()} | SOME
    some |= {name: place for name, place in zip((n for n in usual if last_of(n) == "sigma"), (-1.0, 1.0), strict=False)}
    for name in usual:  # the numbers of amplitudes count, not what they are
        if last_of(name) in AMPLITUDES:
            value = given.get(name, usual[name]) or ()
            some[name] = [0.0] * (len(value) if isinstance(value, (list, tuple)) else 1)
    return list(walled_of(walls, some).params)
