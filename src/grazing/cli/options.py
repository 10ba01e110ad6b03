"""The options of a study, made from the schema, and what was given on the command line put together with a file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from inspect import Parameter as Argument
from inspect import Signature
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from cyclopts import Group, Parameter

from grazing.catalogue import studies
from grazing.catalogue.study import COORDINATE, Study
from grazing.cli.whole import all_as_written, as_written
from grazing.config import checked
from grazing.config.command import KEYS
from grazing.config.maps import names_of, parameter_defaults
from grazing.config.own import KEYS as CODE
from grazing.config.own import Named, is_own, located, refuse_unnamed
from grazing.config.parameters import AMPLITUDES, GAP, parameter_names
from grazing.config.problems import Problem, Refusal, refusal
from grazing.config.schema import MAPS, config_of
from grazing.config.settings import settings_of, text_of
from grazing.config.si import gaps_asked
from grazing.config.tabled import usual_map
from grazing.config.tables import shipped
from grazing.config.toml import read_toml
from grazing.config.values import DEFAULT, number, other_range
from grazing.config.walls import flat, last_of
from grazing.outcome import GrazingError, InputError

MAP = Group("Map and model", sort_key=1)
PARAMETERS = Group(
    "Parameters of the map",
    help="Any other parameter of the map, such as one of your own: NAME=VALUE. Defaults are those of the paper's "
    "pinball; where another law, cos, sin or sigma is named, only t0, sigma, sin and phase have one: 0.",
    sort_key=2,
)
STUDY = Group("Study", sort_key=3)
RUN = Group("Run and output", sort_key=4)

Recipe = dict[str, Any]
Place = tuple[str, ...]
#: What stands for a value in the help.
METAVARS = {
    "walls": "NAME=LAW,...", "curves": "LIST|FILE", "si": "NAME=VALUE,...", "mass": "NUMBER", "base": "NAME=VALUE,...",
    "units": "LIST",
}  # fmt: skip
#: Tables of a file, which the command line has no option for.
TABLES = (("parameters",), ("vary",), ("settings",))
#: Options that may be repeated.
SEVERAL = ("curves",)
#: Keys that a study of the oscillator itself has.
OF_MODEL = ("table", "model", "law", "walls", "mass", "base", "stop", "si", "units")
#: Options whose values are files, and those for which completion offers words though others are allowed.
FILES, OFFERED = ("model",), {"map": tuple(MAPS), "table": tuple(shipped())}


def flag(name: str) -> str:
    """Return a name as an option; names keep their case."""
    return "--" + name.replace("_", "-")


def option(
    name: str, says: str, group: Group, default: object = None, choices: Sequence[str] = (), metavar: str = ""
) -> Argument:
    """Return an option of text: what is allowed is checked with all the rest, so that no error hides another."""
    shown = "" if default in (None, [], "") else text_of(name, default)
    extra: dict[str, Any] = {"metavar": metavar} if metavar else {}
    # the type says what completion offers; whatever was written is kept, and checked with all the rest
    words = tuple(choices) or OFFERED.get(name, ())
    kind: Any = Literal[words] | str if words else Path if name in FILES else str
    if name in SEVERAL:
        kind, extra["converter"], says = list[Path], all_as_written, f"{says}; may be repeated"
    if "LIST" in metavar:  # -1:1 is a range; only plain numbers are told from options by themselves
        extra["allow_leading_hyphen"] = True
    if choices:
        extra["metavar"] = "|".join(choices)
    annotation = Annotated[
        kind | None,
        Parameter(
            name=flag(name), help=says, group=group, show_default=(lambda _none: shown) if shown else False,
            show_choices=False, **{"converter": as_written, **extra},
        ),
    ]  # fmt: skip
    return Argument(name, Argument.KEYWORD_ONLY, default=None, annotation=annotation)


def switch(name: str, says: str, group: Group) -> Argument:
    """Return an option that is given or not; --no-... takes back what a file says."""
    annotation = Annotated[
        bool | None,
        Parameter(name=flag(name), negative=f"--no-{name}", help=says, group=group, show_default=False),
    ]
    return Argument(name, Argument.KEYWORD_ONLY, default=None, annotation=annotation)


def signature_of(study: str, run: Sequence[Argument]) -> Signature:
    """Return the signature of a study's command: what varies, the options of the schema, then those of the run."""
    asked = studies()[study]
    positional = Annotated[str, Parameter(name="NAME=...", help=_positional_help(asked), show=True)]
    arguments = [Argument("given", Argument.VAR_POSITIONAL, annotation=positional)]
    fields, of_model = config_of(study).model_json_schema()["properties"], asked.of == "model"
    for key, usual in KEYS.items():
        if key not in fields or (of_model and key not in OF_MODEL):
            continue
        choices = _choices(fields[key])
        group = RUN if key == "units" else STUDY if key in asked.beside else MAP
        metavar = METAVARS.get(key, "" if choices else "NAME")
        arguments.append(option(key, str(fields[key]["description"]), group, usual, choices, metavar))
    known = parameter_defaults({"map": "stroboscopic"})
    described = config_of(study).model_json_schema()["$defs"]["Parameters"]["properties"]
    for name in parameter_names():
        if of_model and name in ("phase", *GAP):  # it belongs to the oscillator, not to a map
            continue
        says = f"{described[name]['description']}{' (gap map)' if name in GAP else ''}"
        metavar = "LIST" if name in AMPLITUDES else "NUMBER"
        arguments.append(option(name, says, PARAMETERS, known.get(name), metavar=metavar))
    for name, setting in settings_of(study).model_fields.items():
        schema = setting.metadata[-1].json_schema if setting.metadata else {}
        if schema.get("type") == "boolean":
            arguments.append(switch(name, str(setting.description), STUDY))
            continue
        default = None if setting.is_required() else setting.default
        choices = tuple(schema.get("enum", ()))
        arguments.append(
            option(name, str(setting.description), STUDY, default, choices, "" if choices else _metavar(schema))
        )
    return Signature([*arguments, *run])


def _positional_help(known: Study) -> str:
    if known.single:
        rig = "; of a rig in m and m/s unless units are said: u='1 mm'" if known.flown else ""
        return f"Initial state and parameters: {'u=0.1 v=0 d=0.12' if known.flown else 'x=0.1 mu=0.05'}{rig}."
    if known.form == "bounds":
        usual = "; NAME alone for its usual range" if known.has("span") else ""
        return f"What varies: NAME=LOW:HIGH{usual}; NAME=VALUE sets a parameter."
    if not known.most:
        return "Parameters: d=0.12 V=0.4."
    form = "NAME=START:STOP:COUNT, NAME=START:STOP:COUNT:log or NAME=A,B,C"
    what = f"What varies: {form}" if known.least else f"What varies, if anything: {form}"
    several = "; the first is the horizontal axis" if known.most > 1 else ""
    single = f"; NAME=VALUE sets a parameter{' or a coordinate' if known.varies == COORDINATE else ''}"
    return f"{what}{several}{single}."


def _choices(field: Mapping[str, Any]) -> tuple[str, ...]:
    found: list[str] = []
    for item in [field, *field.get("anyOf", ())]:
        found += item.get("enum", [item["const"]] if "const" in item else [])
    return tuple(found)


def _metavar(schema: Mapping[str, Any]) -> str:
    kinds = {"integer": "N", "number": "NUMBER", "array": "LIST", "object": "NAME=VALUE", "string": "NAME"}
    return kinds.get(str(schema.get("type", "")), "N|LIST")


# ---- what was given


@dataclass
class Given:
    """A configuration put together, and which of it was given on the command line, and in NAME=VALUE."""

    mapping: Recipe
    here: set[Place]
    file: str | Path | None
    words: set[Place] = field(default_factory=set)

    def label(self, path: Place) -> str:
        """Return how an error names a path: an option, what varies, or a key of the file."""
        if not path:
            return ""
        if self.file and path not in self.here:
            return f"{self.file}: {'.'.join(path)}"
        if path in TABLES:
            return ""
        own = path[0] == "parameters" and path[-1] not in parameter_names()
        if path[0] == "vary" or path in self.words or own:
            return ".".join(path[1:])
        return flag(path[-1])


class Asked(NamedTuple):
    """The recipe that a command line asks for, and what it calls otherwise: see :func:`gaps_asked`."""

    recipe: Recipe
    gaps: dict[str, tuple[str, float]]


def asked_from(
    study: str, tokens: Sequence[str], options: Mapping[str, str | bool | None], file: str | Path | None
) -> Asked:
    """Return what a command line asks for: a file gives defaults, options override.

    Parameters
    ----------
    study : str
    tokens : sequence of str
        Such as ``d=0.05:0.16:500``.
    options : mapping of str to str, bool or None
        By the names of the schema; None for those not given.
    file : path-like or None
        A TOML file.

    Raises
    ------
    InputError
        With every error that there is.
    """
    mapping = read_toml(file) if file else {}
    tabled = "table" in mapping or options.get("table") is not None
    mapping |= {key: flat(mapping[key], tabled) for key in ("parameters", "vary") if key in mapping}
    if file and isinstance(mapping.get("table"), str) and mapping["table"] not in shipped():
        mapping["table"] = os.path.join(os.path.dirname(file), mapping["table"])
    for key in CODE:  # a file's own files lie beside it, those of the command line where we stand
        if file and isinstance(mapping.get(key), str) and is_own(mapping[key]):
            mapping[key] = located(mapping[key], os.path.dirname(file))
    given = Given(mapping, set(), file)
    problems: list[Problem] = []
    if mapping.setdefault("study", study) != study:
        problems.append(Problem(("study",), f"study = {mapping['study']!r}; this is the command for {study!r}"))
        mapping["study"] = study
    settings = settings_of(study).model_fields
    for name, text in options.items():
        if text is not None:
            text = Named(text) if name in CODE and isinstance(text, str) and is_own(text) else text
            put(
                given,
                ("settings", name) if name in settings else (name,) if name in KEYS else ("parameters", name),
                text,
            )
    refuse_unnamed(mapping)
    problems += assigned(given, tokens)
    for name, written in mapping["vary"].items() if isinstance(mapping.get("vary"), Mapping) else ():
        if ("parameters", name) in given.here and written != DEFAULT:  # whose range is chosen by the value
            where = "here" if ("vary", name) in given.here else f"in {file}"
            problems.append(
                Problem(("parameters", name), f"{name} varies {where}; give it a range there, or no single value")
            )
    try:
        recipe = checked(mapping, label=given.label)
    except GrazingError as error:
        if not problems:
            raise
        known = {problem.path for problem in problems}
        further = error.problems if isinstance(error, Refusal) else [Problem((), str(error))]
        further = [problem for problem in further if not problem.path or problem.path not in known]
        raise refusal([*problems, *further], "", given.label) from None
    if problems:
        raise refusal(problems, "", given.label)
    return Asked(recipe, gaps_asked(mapping))


def put(given: Given, path: Place, value: Any) -> None:
    """Set a value from the command line."""
    at = given.mapping
    for part in path[:-1]:
        if not isinstance(at.get(part), dict):
            at[part] = {}
        at = at[part]
    at[path[-1]] = value
    given.here.add(path)


def assigned(given: Given, tokens: Sequence[str]) -> list[Problem]:
    """Take in ``NAME=...``: a range varies, a value sets a parameter, a coordinate belongs to the state."""
    problems, coordinates, states = [], _coordinates(given.mapping), {}
    study = studies()[given.mapping["study"]]
    if study.has("span"):  # it chooses a range itself if only the name is given
        tokens = [token if "=" in token else f"{token}=:" for token in tokens]
    ranges = [token for token in tokens if "=" in token and _is_range(token)]
    before = given.mapping.get("vary")
    names = {token.partition("=")[0] for token in ranges}
    if ranges and not (isinstance(before, Mapping) and len(names | {*before}) <= study.most):
        given.mapping["vary"] = {}  # too many together: what varies here takes the place of all in the file
    for token in tokens:
        name, equals, text = token.partition("=")
        if not equals or not name:
            file = f"; a file is given with --config {token}" if token.endswith(".toml") else ""
            problems.append(Problem(("vary",), f"{token!r} is not {_forms(study)}{file}"))  # it may have been a range
            given.here.add(("vary",))
        elif (
            name in states
            or given.here & {("vary", name), ("settings", "fixed", name)}
            or (("parameters", name) in given.words)
        ):
            problems.append(Problem((), f"{token!r}: {name} is given twice"))
        elif token in ranges:
            put(given, ("vary", name), DEFAULT if text == ":" else text)
        elif name in coordinates and study.varies == COORDINATE:
            put(given, ("settings", "fixed", name), text)
        elif name in coordinates and study.single:
            states[name] = text
        else:
            put(given, ("parameters", name), text)
            given.words.add(("parameters", name))
    if states:
        missing = [name for name in coordinates if name not in states]
        if missing:
            turned = (
                "; of a rig u is x, and -x where the stop is above" if "si" in given.mapping and "u" in missing else ""
            )
            said = f"the initial state lacks {', '.join(missing)}; give {', '.join(coordinates)}{turned}"
            problems.append(Problem((), said))
        if ("settings", "state") in given.here:
            problems.append(Problem((), f"the initial state is given twice: by --state, and by {', '.join(states)}"))
        rig = any(key in given.mapping for key in ("si", "mass"))  # its numbers may have units
        for name, text in states.items():
            try:
                if not (rig and any(letter.isdigit() for letter in text)):
                    number(text, name)
            except InputError as error:
                problems.append(Problem((), str(error)))
                states[name] = "0"
        put(given, ("settings", "state"), [states.get(name, "0") for name in coordinates])
    return problems


def _forms(study: Study) -> str:
    """Return what follows the name of a study, with an example."""
    if not study.most:
        return "NAME=VALUE, such as d=0.12"
    if study.form == "bounds":
        return "NAME=LOW:HIGH or NAME=VALUE, such as d=0.05:0.16"
    return "NAME=START:STOP:COUNT or NAME=VALUE, such as d=0.05:0.16:500"


def _is_range(token: str) -> bool:
    name, _, text = token.partition("=")
    return ":" in text or ("," in text and last_of(name) not in AMPLITUDES) or other_range(text) is not None


def _coordinates(mapping: Mapping[str, Any]) -> list[str]:
    """Return the coordinates of the map that is asked for; what is wrong with it is said later."""
    study = studies()[mapping["study"]]
    if not study.single and study.varies != COORDINATE:
        return []
    if isinstance(mapping.get("table"), str) and mapping["table"]:
        return names_of_table(mapping)
    if study.flown and not isinstance(mapping.get("model"), Named):
        return ["u", "v"]
    asked = {key: mapping[key] for key in ("map", "model") if isinstance(mapping.get(key), str)}  # nothing else counts
    if not is_own(asked.setdefault("map", "stroboscopic")) and asked["map"] not in MAPS:
        return []
    try:
        return names_of(asked)[1]
    except (GrazingError, AssertionError):
        return []


def names_of_table(mapping: Mapping[str, Any]) -> list[str]:
    """Return the coordinates of the map of a table; what is wrong with it is said later."""
    kind = mapping.get("map") or usual_map(mapping["study"])
    try:
        return names_of({"map": kind, "table": mapping["table"]})[1]
    except GrazingError:
        return []
