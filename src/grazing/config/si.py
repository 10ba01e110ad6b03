"""The table ``[si]`` of a configuration: mass, damper, spring and stop, in place of the parameters of the model."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any, NamedTuple

from grazing.catalogue import studies
from grazing.config import values
from grazing.config.problems import Problem
from grazing.config.values import DEFAULT
from grazing.config.walls import checked_walls, flat, front_of, last_of, sides_of
from grazing.oscillator.deflection import warn_of_gap
from grazing.oscillator.forcing import refuse_out_of_range
from grazing.oscillator.parameters import COORDINATES, parameter_units
from grazing.oscillator.si import AMPLITUDES, GAP, SI, SIDES, Numbers, faults_of, si_numbers
from grazing.outcome import InputError, shown
from grazing.parameter import unknown
from grazing.units import magnitude

#: The law of a stop, where nothing else is named.
LAW = "newton"
#: What the table may hold beside numbers with units.
WORDS = ("side", "moves")
#: What it must hold, and what stands for entries that are wrong while the rest is checked.
NEEDED = ("m", "c", "k", "gap")
UNITS = {**{name: known.units for name, known in SI.items()}, **AMPLITUDES}
UNITS |= {name: known.units for name, known in COORDINATES.items()}
SOUND = {"m": 1.0, "c": 0.0, "k": 1.0, "gap": 0.0, "omega": 1.0, "frequency": 1.0}
#: Coordinates of sections that are not u and v.
SECTIONS = {"impact": ("tau", "v_plus")}
SCHEMA = {
    "anyOf": [
        {"type": "string"},
        {
            "type": "object",
            "properties": {
                **{name: {"type": ["number", "string"], "description": known.meaning} for name, known in SI.items()},
                "force": {"type": ["number", "string", "array"], "description": "amplitude of the force, N"},
                "base": {
                    "type": ["number", "string", "array"],
                    "description": "amplitude of the base, m, which a sweep keeps",
                },
                "acceleration": {
                    "type": ["number", "string", "array"],
                    "description": "amplitude of the acceleration of the base, m/s^2, which a sweep keeps",
                },
                "side": {"enum": list(SIDES), "description": "where the stop is"},
                "moves": {"type": "string", "description": "what the base carries: both, spring or stop"},
            },
            "patternProperties": {
                "^[ABD-RT-Z]$": {
                    "type": "object",
                    "properties": {"gap": {"type": ["number", "string"]}},
                    "additionalProperties": False,
                },
                "^[ABD-RT-Z][.]gap$": {"type": ["number", "string"], "description": GAP.meaning},
            },
            "additionalProperties": False,
        },
    ]
}


def from_table(raw: Mapping[str, Any]) -> tuple[dict[str, Any], list[Problem], dict[str, str]]:
    """Return a configuration in which the table ``[si]`` has become parameters, a mass and a law.

    Parameters
    ----------
    raw : mapping
        ``si`` is a table as :meth:`grazing.Oscillator.from_si` takes it, or text: ``m=0.8,c=2.4,gap=1.2 mm``. With it
        ``frequency``, in Hz, ``force``, ``load``, ``gap``, ``c`` and ``k``, in N/m, may vary, and any other parameter
        in units that it has. What is of the rig may also stand among the parameters.

    Returns
    -------
    dict
    list of Problem
        All that is wrong: unknown names, numbers that are wrong or missing, parameters that the table gives too. In
        their place stands something sound, so that the rest can be checked.
    dict
        What the rig calls parameters of the model, for messages.
    """
    found = {name: value for name, value in raw.items() if name != "si"}
    gaps = gaps_of(raw.get("walls"))
    table, faults = _table(raw["si"], gaps)
    read = bool(table)
    if gaps is None and "side" not in table and "stop" in found:
        table["side"] = found.pop("stop")
    beside = _beside(found, table, gaps)
    placed = {name: table.pop(name) for name in gaps or () if name in table}
    vary = _mapping(found.get("vary"))
    given_frequency = {"frequency", "omega"} & {*table}
    open_frequency = not {"omega", "frequency"}.isdisjoint(vary) and not given_frequency
    wrong = faults_of(table)
    wrong_places = faults_of(placed)
    faults += [*wrong.values(), *(name.removesuffix("gap") + fault for name, fault in wrong_places.items())]
    placed |= dict.fromkeys(wrong_places, 1.0)
    usual: dict[str, Any] = {"side": "above", "moves": "both", "frequency": None}
    usual |= dict.fromkeys((*AMPLITUDES, "load"), 0.0)
    needed = NEEDED if gaps is None else NEEDED[:-1]
    absent = [name for name in needed if name not in table]
    missing = [name for name in absent if name not in vary]
    if missing and read:
        names, units = (" and ".join([", ".join(one[:-1]), one[-1]]) for one in (needed, [UNITS[n] for n in needed]))
        faults.append(f"{', '.join(missing)} missing; give {names}, with units or in {units}")
    table |= {name: SOUND.get(name, usual.get(name)) for name in (*absent, *wrong)}
    if gaps is not None:
        given = {**placed, **vary, **_mapping(found.get("parameters"))}
        open_gaps = [gap for gap, own in gaps.items() if gap not in given and own.name not in given]
        faults += [f"{gap} missing; give the distance to the stop, such as {gap}='1.2 mm'" for gap in open_gaps]
        table |= {"gap": 0.0, "side": "below"}
    try:
        made = si_numbers(**{**usual, "omega": 1.0 if open_frequency else None, **table})
    except InputError as error:
        faults += [str(error)] if read else []
        made = si_numbers(**{**usual, **SOUND, "frequency": None})
    cos, sin = (made.cos, made.sin) if made.base is None else (made.base.cos, made.base.sin)
    load = "d" if gaps is None else "offset"
    places = {"sigma": made.sigma} if gaps is None else _places(placed | dict.fromkeys(open_gaps, 1.0), gaps)
    parameters = {
        "alpha": made.alpha, "k": made.k, "omega": made.omega, load: made.offset, "cos": list(cos),
        "sin": list(sin) if any(sin) else [], **places,
    }  # fmt: skip
    if open_frequency:
        del parameters["omega"]
    given = found.get("parameters", {})
    both = sorted({*parameters, "mass", "base", "stop"} & {*given, *found}) if isinstance(given, Mapping) else []
    if both:
        follow = "follows from what it gives; leave it out" if len(both) == 1 else "follow from it; leave them out"
        faults.append(f"{', '.join(both)} {follow}")
    problems = [Problem(("si",), fault) for fault in faults] + beside
    if isinstance(given, Mapping):
        found["parameters"] = {**_measured(given, made.mass, problems), **parameters}
    found["mass"], side = made.mass, table.get("side", usual["side"])
    if made.base is not None:
        found["base"] = made.base.alone.text
    if gaps is None:
        found["stop"] = side
        found.setdefault("law", LAW)
    own = _sides(made, side, gaps)
    problems += _renamed(found, own, made.mass)
    problems += _begun(found, made.mass)
    if not problems:
        warn_of_gap(
            made, _least_gap(found, {own.name: own.factor for own in gaps.values()} if gaps else {"sigma": -1.0})
        )
    return found, problems, {one.name: name for name, one in own.items()}


def _mapping(table: Any) -> Mapping[str, Any]:
    """Return a table of a configuration; what is none is said by the schema."""
    return table if isinstance(table, Mapping) else {}


def _least_gap(found: Mapping[str, Any], stops: Mapping[str, float]) -> float:
    """Return the least gap of a study; 0 where it is open, as forces, what holds the mass, or a stop itself vary."""
    places = {name: found[name] if isinstance(found.get(name), Mapping) else {} for name in ("parameters", "vary")}
    moving = any(last_of(name) != name and last_of(name) in ("cos", "sin") for name in places["parameters"])
    if moving or {"alpha", "k", "d", "offset", "cos1", "sin1"} & {*places["vary"]}:
        return 0.0
    gaps = [0.0] if not stops else []
    for name, side in stops.items():
        written = places["vary"].get(name, places["parameters"].get(name, 0.0))
        ends = written.split(":")[:2] if isinstance(written, str) else written
        try:
            gaps += [side * float(end) for end in (ends if isinstance(ends, list) else [ends])]
        except (TypeError, ValueError):  # which is said elsewhere
            return 0.0
    return max(0.0, min(gaps, default=0.0))  # a range without values is refused elsewhere


def gaps_of(walls: Any) -> dict[str, Own] | None:
    """Return the gap of each wall of a configuration, by its name, as the position it is; None without walls."""
    if walls is None:
        return None
    try:
        named = checked_walls(walls) or {}
    except InputError:  # which the schema says
        named = {}
    sides = sides_of(named)
    fronts = {name: front_of(named, name) for name in named}
    return {f"{fronts[one]}gap": Own(f"{fronts[one]}sigma", -SIDES[sides[one]]) for one in named}


def gaps_asked(config: Mapping[str, Any]) -> dict[str, tuple[str, float]]:
    """Return the positions between walls whose gap varies in a configuration: that name, and the sign of the position.

    Examples
    --------
    >>> from grazing.config.si import gaps_asked
    >>> gaps_asked({"walls": "A=newton,B=newton", "vary": {"A.gap": "1 mm:2 mm:5", "B.sigma": "1:2:5"}})
    {'A.sigma': ('A.gap', -1.0)}
    """
    locus = _mapping(config.get("settings")).get("locus") or {}
    names = [locus.partition("=")[0].strip()] if isinstance(locus, str) else [*_mapping(locus)]
    varied = {*_mapping(config.get("vary")), *names}
    return {own.name: (gap, own.factor) for gap, own in (gaps_of(config.get("walls")) or {}).items() if gap in varied}


def _places(placed: Mapping[str, Any], gaps: Mapping[str, Own]) -> dict[str, float]:
    """Return the positions of walls whose gap is given."""
    return {gaps[name].name: gaps[name].of(_one(gap, name, 1.0)) for name, gap in placed.items()}


def _measured(given: Mapping[str, Any], mass: float, problems: list[Problem]) -> dict[str, Any]:
    """Return parameters of which some have units as plain numbers."""
    found = dict(given)
    for name, value in given.items():
        if isinstance(value, str) and value[-1:].isalpha():
            try:
                found[name] = _one(value, name, mass)
            except InputError as error:
                problems.append(Problem(("parameters", name), str(error)))
                found[name] = 0.5
    return found


def _beside(found: dict[str, Any], table: dict[str, Any], gaps: Mapping[str, Own] | None) -> list[Problem]:
    """Take what is of the rig and stands among the parameters into the table; return what is given twice."""
    given = found.get("parameters")
    if not isinstance(given, Mapping):
        return []
    own = {*_known(gaps)} - {"k", *(("omega",) if {"omega", "frequency"} & {*table} else ())}
    rig = {name: _number(value) if isinstance(value, str) else value for name, value in given.items() if name in own}
    twice = [
        Problem(("parameters", name), f"{name} = {shown(value)}; the table of the rig gives it, too: give it once")
        for name, value in rig.items()
        if name in table
    ]
    found["parameters"] = {name: value for name, value in given.items() if name not in rig}
    table |= {name: value for name, value in rig.items() if name not in table}
    return twice


def _known(gaps: Mapping[str, Own] | None) -> list[str]:
    """Return what a table may hold: between walls a gap of each, which says where its stop is."""
    names = [*SI, *AMPLITUDES, *WORDS]
    return names if gaps is None else [*(name for name in names if name not in ("gap", "side")), *gaps]


def _table(given: Any, gaps: Mapping[str, Own] | None) -> tuple[dict[str, Any], list[str]]:
    """Return the entries of the table, and what is wrong with it; numbers that a shell wrote as text are numbers."""
    if isinstance(given, str):
        parts = [part.partition("=") for part in given.split(",")]
        if not all(equals for _name, equals, _value in parts):
            alone = any(name.strip()[:1].isdigit() for name, equals, _value in parts if not equals)
            hint = "; write a decimal point in numbers" if alone else ""
            return {}, [f"si = {shown(given)}; give NAME=VALUE, commas between several: m=0.8,c=2.4,gap=1.2 mm{hint}"]
        given = {name.strip(): _number(value.strip()) for name, _equals, value in parts}
    if not isinstance(given, Mapping) or not given:
        return {}, [f"si = {shown(given)}; give a table, such as {{ m = 0.8, c = 2.4, k = 3200.0, ... }}"]
    given, known = flat(given), _known(gaps)
    faults = [
        f"{name} is that of one stop; of walls give {' and '.join(gaps)}, or their positions, such as A.sigma"
        if gaps is not None and name in ("gap", "side")
        else str(unknown(name, known, "si"))
        for name in given
        if name not in known
    ]
    return {name: value for name, value in given.items() if name in known}, faults


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


class Own(NamedTuple):
    """The parameter of the model that a quantity x of the rig is: factor x^power."""

    name: str
    factor: float = 1.0
    power: float = 1.0

    def of(self, x: float) -> float:
        """Return its value."""
        found = self.factor * (x if self.power == 1.0 else x**self.power)
        if self == FREQUENCY and found > 0.0:  # what is wrong with it is said of the rig's own quantity
            refuse_out_of_range(found, "frequency", self.factor)
        return found


FREQUENCY = Own("omega", 2.0 * pi)


def _sides(made: Numbers, side: Any, gaps: Mapping[str, Own] | None) -> dict[str, Own]:
    """Return what of the rig may vary, each with the parameter of the model that it is."""
    sign = SIDES.get(side, 1.0) / made.mass
    of_base = {} if made.base is not None else {"force": Own("cos1", sign)}
    springs = {"c": Own("alpha", 1.0 / made.mass), "k": Own("k", made.mass**-0.5, 0.5)}
    return {
        "frequency": FREQUENCY,
        "load": Own("d" if gaps is None else "offset", sign),
        **({"gap": Own("sigma", -1.0)} if gaps is None else gaps),
        **springs,
        **of_base,
    }


def _renamed(found: dict[str, Any], names: Mapping[str, Own], mass: float) -> list[Problem]:
    """Put what varies, and where and in what a branch is followed, in parameters of the model; return what is wrong."""
    faults: list[Problem] = []

    def converted(written: Any, name: str, bounded: bool, at: tuple[str, ...]) -> Any:
        try:
            return _in_model(written, name, names.get(name, Own(name)), mass, bounded)
        except InputError as error:
            faults.append(Problem((*at, name), str(error)))
            return "1:2" if bounded else "1:2:2"

    def named(table: Mapping[str, Any], bounded: bool, *at: str) -> dict[str, Any]:
        for name, own in names.items():
            if name != own.name and name in table and own.name in table:
                faults.append(Problem(("si",), f"{name} and {own.name} both vary; give one of them"))
        return {names.get(name, Own(name)).name: converted(item, name, bounded, at) for name, item in table.items()}

    study = studies().get(str(found.get("study")))
    if isinstance(found.get("vary"), Mapping):
        varied = [*found["vary"]]
        ranges = found["vary"]
        found["vary"] = named(ranges, study is not None and study.form == "bounds", "vary")
    else:
        varied = []
    settings = found.get("settings")
    if isinstance(settings, Mapping) and len(varied) == 1 and settings.get("at") is not None:
        at = settings["at"]
        items = at.split(",") if isinstance(at, str) else at if isinstance(at, (list, tuple)) else [at]
        try:
            own = names.get(varied[0], Own(varied[0]))
            places = [_one(item, varied[0], mass) for item in items]
            if not faults and ranges[varied[0]] != DEFAULT and own != Own(varied[0]):  # in the rig's own numbers
                written = ranges[varied[0]]
                ends = written.split(":") if isinstance(written, str) else written
                low, high = (_one(end, varied[0], mass) for end in ends)
                if outside := [place for place in places if not low <= place <= high]:
                    raise InputError(f"at = {outside[0]:g}; allowed is {low:g} <= {varied[0]} <= {high:g}")
            found["settings"] = {**settings, "at": [own.of(place) for place in places]}
        except InputError as error:
            faults.append(Problem(("settings", "at"), str(error)))
            found["settings"] = {key: value for key, value in settings.items() if key != "at"}
    settings = found.get("settings")
    if isinstance(settings, Mapping) and settings.get("locus") is not None:
        locus = settings["locus"]
        if isinstance(locus, str):
            name, equals, text = locus.partition("=")
            locus = {name.strip(): text} if equals else locus
        if isinstance(locus, Mapping):
            found["settings"] = {**settings, "locus": named(locus, True, "settings", "locus")}
    return faults


def _begun(found: dict[str, Any], mass: float) -> list[Problem]:
    """Put coordinates of a start that have units of their own in m, m/s and s; return what is wrong with them."""
    settings = _mapping(found.get("settings"))
    faults = []
    for key in ("state", "fixed"):
        given: Any = settings.get(key)
        if isinstance(given, str):
            parts = given.split(",")
            given = (
                parts if key == "state" else {part.partition("=")[0].strip(): part.partition("=")[2] for part in parts}
            )
        named = isinstance(given, Mapping)
        values: list[Any] = [*given.values()] if named else [*given] if isinstance(given, (list, tuple)) else []
        names = [*given] if named else [*SECTIONS.get(str(found.get("map")), ("u", "v")), *[key] * len(values)]
        if not any(isinstance(one, str) and _has_units(one) for one in values):
            continue
        for i, one in enumerate(values):
            try:
                values[i] = _one(one, names[i], mass) if isinstance(one, str) else one
            except InputError as error:
                faults.append(Problem(("settings", key), str(error)))
                values[i] = 0.0
        found["settings"] = settings = {**settings, key: dict(zip(names, values, strict=True)) if named else values}
    return faults


def _in_model(written: Any, name: str, own: Own, mass: float, bounded: bool) -> Any:
    """Return a range or bounds of a quantity of the rig as those of the parameter of the model that it is."""
    if written == DEFAULT or (own == Own(name) and not _has_units(written)):
        return written
    values.checked_form(written, name, bounded)
    if not (isinstance(written, str) and ":" in written):
        items = written.split(",") if isinstance(written, str) else written
        items = items if isinstance(items, (list, tuple)) else [items]
        if not items:
            raise InputError(f"{name} = {shown(written)}; give a list of numbers")
        found = [own.of(_one(item, name, mass)) for item in items]
        return found[::-1] if bounded and own.factor < 0.0 else found
    low, high, *rest = written.split(":")
    ends = [_one(end, name, mass) for end in (low, high)]
    plain = ":".join([*map(repr, ends), *rest])  # what is wrong with it is said of the rig's own quantity
    checked = values.bounds_of(plain, name) if bounded else values.range_of(plain, name)
    log = rest[1:] == ["log"]
    if not bounded and ((log and own.factor < 0.0) or (not log and own.power != 1.0)):  # no longer even in the model's
        return [own.of(value) for value in values.values_of(checked).tolist()]
    ends = [own.of(end) for end in (ends[::-1] if bounded and own.factor < 0.0 else ends)]
    return ":".join([*map(repr, ends), *rest])


def _has_units(written: Any) -> bool:
    texts = written if isinstance(written, (list, tuple)) else str(written).split(":")[:2]
    return any(
        isinstance(_number(part.strip()), str) for one in texts if isinstance(one, str) for part in one.split(",")
    )


def _one(value: Any, name: str, mass: float) -> float:
    """Return one value of a quantity of the rig, or of another parameter, given with or without its units."""
    plain = _number(value.strip()) if isinstance(value, str) else value
    if isinstance(plain, str) and any(letter.isdigit() for letter in plain):
        units = UNITS.get(last_of(name))
        units = parameter_units(name) if units is None else units
        of_mass = units == "N/kg" and not plain.endswith("/kg")
        plain = magnitude(plain, "N", name) / mass if of_mass else magnitude(plain, units, name)
    found = values.number(plain, name)
    return SI[last_of(name)].check(found) if last_of(name) in SI else found
