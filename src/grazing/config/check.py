"""Check a configuration: every error is found in one go, and what was left out is filled in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import date, time
from functools import partial
from math import inf
from typing import Any

from pydantic import ValidationError

from grazing.catalogue import studies
from grazing.catalogue.study import COORDINATE, Study
from grazing.config.given import all_numbers, parameters, shared
from grazing.config.maps import LAW, UNFOLD, has_beside, names_of, parameter_defaults
from grazing.config.own import KEYS, Named, is_own, located, named, own_object, unnamed
from grazing.config.parameters import STIFFNESS, defaults_of, described, parameter_names
from grazing.config.problems import Label, Problem, Refusal, dotted, found_by, refusal, unknown_key
from grazing.config.schema import ALONE, MAPS, Config, config_of
from grazing.config.settings import settings_of
from grazing.config.si import from_table
from grazing.config.tabled import beside_table, with_map
from grazing.config.values import DEFAULT, bounds_of, extremes, found_from, range_of
from grazing.config.walls import flat
from grazing.maps.discontinuity import ORDERS, discontinuity_map
from grazing.maps.map import Map
from grazing.outcome import GrazingError, InputError, shown
from grazing.parameter import named_by

Recipe = dict[str, Any]
#: Tables and lists in each other: no study needs more than four.
DEEPEST = 8
#: What a model has of its own, and what is said of maps without it.
BROUGHT = {
    "law": ("its own reset law", "has no reset law"), "mass": ("its own units", "is dimensionless"),
    "base": ("its own base", "has no base"), "stop": ("its own stop", "has no stop"),
}  # fmt: skip
#: Of the keys in a recipe.
ORDER = (
    "study", "map", "table", "order", "unfold", "model", "law", "walls", "mass", "base", "stop", "parameters", "vary",
    "settings", "curves", "coordinate", "units",
)  # fmt: skip


def checked(
    mapping: Mapping[str, Any], *, folder: str = ".", source: str = "", label: Label = dotted, code: str | None = None
) -> Recipe:
    """Return a configuration with all that was left out filled in, as JSON can write it.

    Parameters
    ----------
    mapping : mapping
        As a TOML file has it.
    folder : str
        From where a user's own files are found.
    source : str
        Where the mapping is from, for the message.
    label : callable
        How the message names a path in it.
    code : {"trust"}, optional
        Run the file that ``map`` or ``model`` names, if it is one of your own. Without it nothing is run: what only
        that code knows, such as its parameters, is neither checked nor filled in.

    Returns
    -------
    dict
        The recipe: equal ones give equal numbers.

    Raises
    ------
    InputError
        With every error that there is, one a line.

    Examples
    --------
    >>> from grazing.config import checked
    >>> try:
    ...     checked({"study": "diagram", "parameters": {"r": 1.2}, "vary": {"b": "0:1:10"}, "settings": {"strats": 9}})
    ... except ValueError as error:
    ...     print(error)
    there are 3 errors:
      parameters.r = 1.2; allowed is 0 <= r <= 1 (coefficient of restitution)
      settings.strats: unknown key; did you mean 'starts'? allowed are starts, transient, keep, seed, arithmetic, ...
      vary.b: unknown parameter; allowed are alpha, k, omega, t0, d, cos1, sin1, sigma, r, V, phase
    """
    if not isinstance(mapping, Mapping):
        raise InputError(f"{source or 'the configuration'} is {shown(mapping)}; give a table of keys and values")
    raw: Recipe = named(plain_of(mapping, source), code)
    raw |= {key: flat(raw[key], "table" in raw) for key in ("parameters", "vary") if key in raw}
    if nameless := [key for key in ("table", "model") if raw.get(key) == ""]:
        raise refusal([Problem((key,), "'' names nothing; leave it out") for key in nameless], source, label)
    if isinstance(raw.get("table"), str):
        with_map(raw, folder)
    if isinstance(raw.get("settings"), dict) and "units" in raw["settings"]:
        raw.setdefault("units", raw["settings"].pop("units"))  # of what is shown, not of how it is computed
    before: list[Problem] = []
    called: dict[str, str] = {}
    if raw.get("si") is not None:
        if said := _without_rig(raw):
            before = [Problem(("si",), said)]
            del raw["si"]
        else:
            raw, before, called = from_table(raw)
    problems, config = _by_schema(_located(raw, folder))
    if config is not None:
        problems += list(_across(config, raw, problems, called))
    if before or problems or config is None:
        raise refusal([*before, *problems], source, label)
    return config


def _without_rig(raw: Recipe) -> str:
    """Say why a configuration has no mass, spring and stop to be given in SI units; nothing where it has."""
    kind = raw.get("map")
    if raw.get("table") is not None:
        return "the table brings all that is on it; leave it out"
    if raw.get("model") is not None:
        return "the model brings its own numbers; leave it out"
    if kind == "gap":
        return "the map gap is dimensionless; leave it out"
    if isinstance(kind, str) and is_own(kind):
        return f"the map {kind} brings its own numbers; leave it out"
    return ""


def plain_of(value: Any, source: str = "", depth: int = 0) -> Any:
    """Return a copy made of tables with texts as keys and of lists; a configuration holds few of them in each other."""
    if depth > DEEPEST:
        raise InputError(f"{source or 'the configuration'} has more than {DEEPEST} tables and lists in each other")
    if isinstance(value, Mapping):
        return {str(key): plain_of(item, source, depth + 1) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_of(item, source, depth + 1) for item in value]
    if isinstance(value, (date, time)):  # TOML has them, no key takes one; 07:32:10 is not to pass for a range
        return f"the {'time' if isinstance(value, time) else 'date'} {value.isoformat()}"
    return value


def _located(raw: Recipe, folder: str) -> Recipe:
    """Return the mapping with whole paths of the user's files; a file that holds an oscillator is the model."""
    for key in KEYS:
        if isinstance(raw.get(key), str) and is_own(raw[key]):
            raw[key] = located(raw[key], folder)
    if isinstance(raw.get("curves"), (list, str)):  # files lie beside the one that names them
        raw["curves"] = found_from(raw["curves"], folder)
    return raw


def _by_schema(raw: Recipe) -> tuple[list[Problem], Recipe | None]:
    """Return what the schema finds wrong, and what is sound without it; None where nothing can be said of the rest."""
    study = raw.get("study")
    schema: type[Config] = config_of(study) if isinstance(study, str) and study in studies() else Config
    problems: list[Problem] = []
    own: dict[str, Any] = {}
    other = isinstance(raw.get("map"), str) and is_own(raw["map"])
    if (other or raw.get("table")) and isinstance(raw.get("parameters", {}), Mapping):
        own = dict(raw.pop("parameters", {}))  # these have parameters and ranges of their own
    try:
        config = schema.model_validate(raw)
    except ValidationError as error:
        problems = found_by(error, schema)
        try:
            config = schema.model_validate(_without(raw, problems))
        except ValidationError:
            return problems, None
    found = config.model_dump(exclude_none=True)
    if any(problem.path == ("study",) for problem in problems):  # any of them stood in, so that the rest can be seen
        del found["study"]
        found["settings"] = {}
    found |= {key: raw[key] for key in KEYS if isinstance(raw.get(key), Named) and key in found}  # the schema has text
    return problems, {**found, "parameters": {**found["parameters"], **own}}


def _without(raw: Recipe, problems: list[Problem]) -> Recipe:
    """Return a configuration without what is wrong in it; in place of what must be given stands something sound."""
    left: Recipe = plain_of(raw, "")
    for problem in problems:
        at: Any = left
        if problem.path == ("parameters", STIFFNESS):  # that it is there says which others there are
            left["parameters"][STIFFNESS] = 1.0
            continue
        for depth, part in enumerate(problem.path):
            if depth == len(problem.path) - 1 and part not in at:  # it is missing: None passes for a setting
                at[part] = None
                break
            at.setdefault(part, {})
            if depth == len(problem.path) - 1 or not isinstance(at[part], dict):
                del at[part]
                break
            at = at[part]
    if ("study",) in {problem.path for problem in problems}:
        left["study"] = next(iter(studies()))
    return left


# ---- checks across the parts


def _across(config: Recipe, raw: Recipe, before: list[Problem], called: Mapping[str, str]) -> Iterator[Problem]:
    """Yield what is wrong between the parts, and fill in what was left out; a rig has its own names of parameters."""
    broken = {problem.path for problem in before}
    if broken & {("map",), ("law",), ("model",), ("walls",)}:  # which say what parameters there are
        return
    kind = config["map"]
    if said := beside_table(config):
        yield said
        return
    if not config.get("table") and not is_own(kind) and kind not in MAPS:
        yield Problem(("map",), partial(unknown_key, kind, [*MAPS, "file.py:name"], f"map = {shown(kind)}"))
        return
    if unnamed(config):  # only the code knows the rest
        of = studies().get(config.get("study", ""))
        if config["vary"] and of is not None and not of.most:
            yield Problem(("vary",), _how_many(config, of, [], called))
        broken_ranges: list[Problem] = []
        config["vary"] = dict(_ranges(config, broken_ranges))
        yield from broken_ranges
        yield from all_numbers(config["parameters"])
        _order(config)
        return
    try:
        _adopt(config)
        known, (names, coordinates) = parameter_defaults(config), names_of(config)
    except GrazingError as error:
        key = next((key for key in ("table", "model") if config.get(key)), "map")
        each = [one.line(dotted) for one in error.problems] if isinstance(error, Refusal) else [str(error)]
        yield from (Problem((key,), line) for line in each)
        return
    for i, problem in enumerate(before):  # what is out of range, of a parameter that there is not
        if problem.path[0] == "parameters" and len(problem.path) > 1 and problem.path[1] not in known:
            before[i] = Problem(problem.path, partial(unknown_key, problem.path[1], known, "unknown parameter"))
    yield from _pieces(config)
    broken_ranges = []
    ranges = dict(_ranges(config, broken_ranges))
    yield from broken_ranges
    yield from _names(config, ranges, names, coordinates, ("vary",) in broken, called)
    yield from shared(config["parameters"], known)
    varied = {one for name in config["vary"] for one in (named_by(name, known) or [name])}
    yield from parameters(config, known, varied | {path[1] for path in broken if path[0] == "parameters" and path[1:]})
    yield from _fits(config, coordinates)
    study = studies().get(config.get("study", ""))
    if study is not None and study.dimension not in (None, len(coordinates)):
        yield Problem(
            ("map",),
            f"the {config['map']} map has coordinates {', '.join(coordinates)}; a {study.name} needs a map with "
            f"{'one, such as gap' if study.dimension == 1 else study.dimension}",
        )
    if study is not None and study.of == "model" and not config.get("table"):
        yield from _in_time(config, study)
        yield from _without_range(config, ranges, known, called)
    if isinstance(config["settings"], Mapping):
        yield from _orbits(config, ranges, names, ("settings", "period") in broken)
    config["vary"] = ranges
    _order(config)


def _order(config: Recipe) -> None:
    ordered = {key: config[key] for key in ORDER if key in config}
    config.clear()
    config |= ordered


def _adopt(config: Recipe) -> None:
    """Take a map that is an oscillator in a user's file for the stroboscopic map of that oscillator."""
    if is_own(config["map"]) and not isinstance(own_object(config["map"]), Map):
        if config.get("model"):
            raise InputError("map and model both name an oscillator; give one of them, and the map by its name")
        config |= {"model": config["map"], "map": "stroboscopic"}


def _pieces(config: Recipe) -> Iterator[Problem]:
    """Yield keys that have no meaning for this map, and fill in the defaults of those that have one."""
    kind = config["map"]
    if config.get("table"):
        return
    oscillator = not is_own(kind) and kind != "gap"
    if config.get("model") and not oscillator:
        yield Problem(("model",), f"the map {kind} is not made of an oscillator; leave the model out")
    for key, (own, none) in BROUGHT.items() if config.get("model") or not oscillator else ():
        if key in config:
            brings = f"the model brings {own}" if config.get("model") else f"the map {kind} {none}"
            yield Problem((key,), f"{brings}; leave the {key} out")
    for key in ("law", "model") if config.get("walls") and oscillator else ():
        if key in config:
            yield Problem((key,), f"the walls bring their own laws; leave the {key} out")
    if config.get("walls") and oscillator and "stop" in config:
        yield Problem(("stop",), "the walls say themselves where they are; leave the stop out")
    if config.get("walls") and not oscillator:
        yield Problem(("walls",), f"the map {kind} has no wall; leave them out")
    if "units" in config and "mass" not in config and not config.get("model") and not is_own(kind):
        yield Problem(("units",), "the model is dimensionless; give it with --si, or its mass with --mass")
    beside = has_beside(config)
    for key, at in (("order", "discontinuity"), ("unfold", "normal-form")):
        if config.get(key) and kind != at and not (key == "order" and beside):
            yield Problem((key,), f"the {at} map has one, the {kind} map has not; leave it out")
    if kind == "discontinuity" and config.get("order") == ALONE:
        yield Problem(
            ("order",),
            f"order = {ALONE!r} leaves out the map beside the stroboscopic map; allowed are {', '.join(ORDERS)}",
        )
        del config["order"]
    if kind == "discontinuity" or beside:
        config.setdefault("order", defaults_of(discontinuity_map)["order"])
    if kind == "normal-form":
        config.setdefault("unfold", UNFOLD)
    if oscillator and not config.get("model") and not config.get("walls"):
        config.setdefault("law", LAW)


def _in_time(config: Recipe, study: Study) -> Iterator[Problem]:
    """Yield what belongs to a map and means nothing for the oscillator itself."""
    flown = study.flown
    if config["map"] != "stroboscopic":
        who = f"a {study.name} is flown by" if flown else f"{study.name} belong to"
        yield Problem(("map",), f"map = {config['map']!r}; {who} the oscillator itself: leave it out")
    if config["parameters"].get("phase"):
        who = f"a {study.name} has no section; leave it out, start is the initial time"
        yield Problem(("parameters", "phase"), who if flown else f"{study.name} need no section; leave it out")


def _orbits(config: Recipe, ranges: Recipe, names: list[str], broken: bool) -> Iterator[Problem]:
    """Yield what is wrong with the settings of orbits and branches."""
    settings, study = config["settings"], config.get("study")
    named = broken or settings.get("period") is not None or settings.get("word") is not None
    if study is not None and {"period", "word"} <= {*settings_of(study).model_fields} and not named:
        yield Problem(("settings", "period"), "missing; give least periods, such as 3 or 1:6, or a word, such as 001")
    for name, (low, high) in (settings.get("locus") or {}).items():
        value = config["parameters"].get(name, low)
        if isinstance(value, float) and not low <= value <= high:
            said = f"{name} = {low:g}:{high:g}; it must hold {name} = {value:g}, where the special points are"
            yield Problem(("settings", "locus"), said)
        if name not in names:
            yield Problem(("settings", "locus"), partial(unknown_key, name, names, f"unknown parameter {shown(name)}"))
        elif name in ranges:
            yield Problem(("settings", "locus"), f"{name} is the parameter of the branch; give another one")
    at = settings.get("at")
    if not isinstance(at, list) or DEFAULT in ranges.values():  # bounds that a study chooses are not known here
        return
    for name, written in ranges.items():
        low, high = extremes(written)
        outside = [value for value in at if not low <= value <= high]
        if outside:
            yield Problem(("settings", "at"), f"at = {outside[0]:g}; allowed is {low:g} <= {name} <= {high:g}")


def _ranges(config: Recipe, problems: list[Problem]) -> Iterator[tuple[str, Any]]:
    study = studies().get(config.get("study", ""))
    bounded = study is not None and study.form == "bounds"
    for name, written in config["vary"].items():
        if study is not None and not study.most:  # that it varies at all is what is wrong
            continue
        try:
            found = bounds_of(written, name) if bounded else range_of(written, name)
            if found == DEFAULT and not (study is not None and study.has("span")):
                raise InputError(f"{name} has no range; give low:high, such as {name}=0.05:0.16")
            yield name, found
        except InputError as error:
            problems.append(Problem(("vary", name), str(error)))


def _names(
    config: Recipe, ranges: Recipe, names: list[str], coordinates: list[str], broken: bool, called: Mapping[str, str]
) -> Iterator[Problem]:
    """Yield what varies and cannot, how many should, and values that are out of range."""
    study = studies().get(config.get("study", ""))
    allowed = coordinates if study is not None and study.varies == COORDINATE else names
    for name in config["vary"]:
        if not named_by(name, allowed):
            what = "unknown coordinate" if allowed is coordinates else "unknown parameter"
            yield Problem(("vary", name), partial(unknown_key, name, allowed, what))
        elif (
            name in ranges
            and ranges[name] != DEFAULT
            and allowed is names
            and not is_own(config["map"])
            and not config.get("table")
            and config["map"] not in ("gap", "normal-form")
        ):
            for value in extremes(ranges[name]):
                try:
                    described(name).check(value)
                except InputError as error:
                    yield Problem(("vary", name), str(error))
                    break
    if study is not None and not broken and not study.least <= len(config["vary"]) <= study.most:
        yield Problem(("vary",), _how_many(config, study, allowed, called))


def _without_range(config: Recipe, ranges: Recipe, known: Recipe, called: Mapping[str, str]) -> Iterator[Problem]:
    """Yield what is searched over its usual range and has none: no value, no default, and no greatest value."""
    for name, written in ranges.items():
        absent = [one for one in named_by(name, known) if one not in config["parameters"] and known[one] is None]
        if written != DEFAULT or not absent or described(name).high < inf:
            continue
        own = called.get(name, name)
        said = f"it has no default, so its range is not known; give one, such as {own}=0.1:0.5"
        if own != name:
            said += ", or a value to search around among the numbers of the rig"
        elif name in parameter_names():
            said += f", or a value to search around, such as --{name} 0.3"
        yield Problem(("vary", own), said)


def _fits(config: Recipe, coordinates: list[str]) -> Iterator[Problem]:
    """Yield settings that do not fit the coordinates of the map."""
    settings, count, named = config["settings"], len(coordinates), ", ".join(coordinates)
    if not isinstance(settings, Mapping):
        return
    box, starts = settings.get("box"), settings.get("starts")
    if isinstance(box, (list, tuple)) and len(box) != count:
        yield Problem(
            ("settings", "box"), f"box has {len(box)} intervals; give one low:high for each of {named}, commas between"
        )
    if isinstance(starts, (list, tuple)):
        for state in starts:
            if isinstance(state, (list, tuple)) and len(state) != count:
                said = f"starts has a state of {len(state)} numbers; give {count} for each: {named}"
                yield Problem(("settings", "starts"), said)
                break
    for table, path in ((settings, ("settings", "coordinate")), (config, ("coordinate",))):
        if table.get("coordinate") is not None and table["coordinate"] not in coordinates:
            which = f"coordinate = {shown(table['coordinate'])}"
            yield Problem(path, partial(unknown_key, table["coordinate"], coordinates, which))
    for name in settings.get("fixed") or ():
        if name not in coordinates:
            yield Problem(("settings", "fixed", name), partial(unknown_key, name, coordinates, "unknown coordinate"))


def _how_many(config: Recipe, study: Study, allowed: list[str], called: Mapping[str, str]) -> str:
    if not study.most:
        article = "an" if study.name[0] in "aeiou" else "a"
        varied = ", ".join(called.get(name, name) for name in config["vary"])
        return f"{varied}: {article} {study.name} varies nothing; give single values"
    wanted = f"{study.least}" if study.least == study.most else f"{study.least} to {study.most}"
    plural = "" if study.most == 1 else "s"
    names = [called.get(name, name) for name in allowed]
    example = names[allowed.index("d") if "d" in allowed else 0]
    got = f"{len(config['vary'])} vary" if config["vary"] else "nothing varies"
    form = f"{example}=0.1:0.2" if study.form == "bounds" else f"{example}=0.1:0.2:100"
    return f"{got}; {study.name} varies {wanted} {study.varies}{plural} of {', '.join(names)}, such as {form}"
