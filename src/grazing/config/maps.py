"""The map that a configuration speaks of."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from grazing.billiard.table import COORDINATES
from grazing.catalogue import studies
from grazing.config.own import is_own, own_object
from grazing.config.parameters import AMPLITUDES, FLIGHT, GAP, LAWS, STIFFNESS, defaults_of, law_names, spring_in
from grazing.config.schema import MAPS, TABLE_MAPS
from grazing.config.tables import read_table
from grazing.config.walls import parameters_of, walled_defaults, walled_of
from grazing.maps.collisions import collision_map
from grazing.maps.discontinuity import discontinuity_map
from grazing.maps.gap import gap_map
from grazing.maps.impact import impact_map
from grazing.maps.launches import launch_map
from grazing.maps.map import Map
from grazing.maps.normal_form import normal_form
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.forcing import Forcing
from grazing.oscillator.model import Oscillator, pinball
from grazing.oscillator.si import based_on
from grazing.outcome import InputError

#: Maps that have a section in time.
PHASED = ("stroboscopic", "discontinuity")
#: The parameter that leads a normal form to its graze, if none is named.
UNFOLD = "d"
LAW = "active"
#: Parameters of the paper's pinball machine: its wall is at 0, its force one cosine of amplitude 1 beside d.
PINBALL = tuple(name for name in defaults_of(pinball) if name != "sigma")


def parameter_defaults(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters that a configuration's map has, in their order, with defaults; None where there is none.

    Parameters
    ----------
    config : mapping
        ``map``, ``model`` and ``law``, valid each by itself; ``parameters`` and ``vary``, whose names say whether it
        is the pinball, whose defaults are the paper's. Else only what leaves a term out has a default: 0.
    """
    kind, law = config["map"], config.get("law") or LAW
    if config.get("table"):
        return dict(of_table(config).params)
    if is_own(kind):
        found = own_object(kind)
        return dict(found.params)
    if kind == "gap":
        return dict.fromkeys(GAP)
    phase = defaults_of(stroboscopic_map)
    section = {"phase": phase["phase"]} if kind in PHASED else {}
    if config.get("walls"):
        return {**walled_defaults(config["walls"], config.get("vary", {}), spring_in(config)), **section}
    if config.get("model"):
        return {**own_model(config["model"]).params, **section}
    paper = defaults_of(pinball)
    spring = spring_in(config)
    flight = {spring if name == "k" else name: paper[name] for name in FLIGHT} | {
        "cos": list(pinball().forcing.cos),
        "sin": [],
    }
    known = {**flight, **{name: paper.get(name) for name in law_names(law)}, **section}
    if beyond_pinball(config) is None:
        return known
    for name, usual in known.items():
        if usual not in (0.0, []):
            moving = name in AMPLITUDES and any(harmonic(varied) == name for varied in config.get("vary", ()))
            known[name] = [0.0] if moving else None
    return known


def harmonic(name: str) -> str:
    """Return cos or sin for the name of an amplitude, such as cos1; else nothing."""
    return name[:3] if name[:3] in AMPLITUDES and name[3:].isdigit() else ""


def beyond_pinball(config: Mapping[str, Any]) -> str | None:
    """Return what a configuration names that the paper's pinball does not have; None if it is the pinball.

    A configuration that names all of the pinball is the pinball, too: recipes are complete.
    """
    if config.get("law") not in (None, LAW):
        return f"law = {config['law']}"
    given, varied = config.get("parameters", {}), list(config.get("vary", ()))
    if spring_in(config) == STIFFNESS:
        return STIFFNESS
    moved = [name for name in varied if name == "sigma" or harmonic(name)]
    named = [name for name in ("sigma", *AMPLITUDES) if name in given]
    if moved or not named:
        return moved[0] if moved else None
    usual = {"sigma": 0.0, "cos": [1.0], "sin": []}
    complete = all(name in given or name in varied for name in PINBALL)
    same = all(_without_zeros(given.get(name, value)) == value for name, value in usual.items())
    return None if complete and same else named[0]


def _without_zeros(value: Any) -> Any:
    """Return amplitudes without the zeros at their end, which add nothing to a force; else the value itself."""
    if isinstance(value, (list, tuple)):
        last = max((j for j, each in enumerate(value, start=1) if each != 0.0), default=0)
        return list(value[:last])
    return value


def of_table(config: Mapping[str, Any]) -> Any:
    """Return the table that a configuration names, or the map of it."""
    table, known = read_table(config["table"]), studies().get(config.get("study", ""))
    if config["map"] not in TABLE_MAPS or (known is not None and known.of == "model"):
        return table
    if config["map"] == "stroboscopic":
        return stroboscopic_map(table)
    return collision_map(table) if config["map"] == "collision" else launch_map(table)


def own_model(text: str) -> Any:
    """Return the oscillator that ``file.py:name`` names."""
    found = own_object(text, "model")
    if isinstance(found, Map):
        raise InputError(f"{text} is a gz.Map; give it as the map, and leave the model out")
    return found


def names_of(config: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """Return the parameters that can vary and the coordinates of a configuration's map, whatever their values."""
    kind = config["map"]
    if config.get("table"):
        found = of_table(config)
        return list(found.params), list(getattr(found, "coordinates", COORDINATES))
    if is_own(kind):
        P = own_object(kind)
        assert isinstance(P, Map)
        return list(P.params), list(P.coordinates)
    if kind == "gap":
        return _names(kind, LAW, "k", 0, 0)
    if config.get("model"):
        P = section_of(own_model(config["model"]), {**config, "parameters": {}})
        return list(P.params), list(P.coordinates)
    if config.get("walls"):
        phase = ["phase"] if kind in PHASED else []
        given, varied = config.get("parameters", {}), config.get("vary", {})
        coordinates = ["tau", "v_plus"] if kind == "impact" else ["u", "v"]
        return [*parameters_of(config["walls"], given, varied, spring_in(config)), *phase], coordinates
    waves = {name: config.get("parameters", {}).get(name) for name in AMPLITUDES}
    return _names(kind, config.get("law") or LAW, spring_in(config), *(len(waves[name] or ()) for name in AMPLITUDES))


@cache
def _names(kind: str, law: str, spring: str, cosines: int, sines: int) -> tuple[list[str], list[str]]:
    if kind in ("gap", "normal-form"):
        P = gap_map(0.5, 0.1, 0.1)
    else:
        known = parameter_defaults({"map": kind, "law": law, "parameters": {spring: 1.0}})
        known |= {name: 1.0 for name, value in known.items() if value is None}
        known |= {"cos": [1.0] + [0.0] * max(cosines - 1, 0), "sin": [0.0] * sines}
        P = map_of({"map": kind, "law": law, "parameters": known})
    return list(P.params), list(P.coordinates)


def map_of(config: Mapping[str, Any]) -> Map:
    """Return the map of a checked configuration.

    Parameters
    ----------
    config : mapping
        With all parameters that have no default.

    Examples
    --------
    >>> from grazing.config.maps import map_of
    >>> map_of({"map": "gap", "parameters": {"lam": 0.5, "mu": 0.1, "l": 0.2}})
    <Map gap map: (x); lam=0.5, mu=0.1, l=0.2>
    """
    kind, given = config["map"], dict(config.get("parameters", {}))
    if config.get("table"):
        seen: Map = of_table(config).replace(**given)
        return seen
    if is_own(kind):
        found = own_object(kind)
        assert isinstance(found, Map)
        return found.replace(**given)
    if kind == "gap":
        return gap_map(**given)
    return section_of(model_of(config), config)


def section_of(model: Any, config: Mapping[str, Any]) -> Map:
    """Return the map that a configuration makes of an oscillator."""
    kind = config["map"]
    phase = config.get("parameters", {}).get("phase")
    at = {} if phase is None else {"phase": phase}
    if kind == "impact":
        return impact_map(model)
    if kind == "discontinuity":
        return discontinuity_map(model, **({"order": config["order"]} if config.get("order") else {}), **at)
    if kind == "normal-form":
        name = config.get("unfold") or UNFOLD
        if name not in model.params:
            raise InputError(f"unfold = {name!r}; allowed are the parameters of the model: {', '.join(model.params)}")
        return normal_form(model, name).gap_map(model.params[name])
    assert kind in MAPS
    return stroboscopic_map(model, **at)


def has_beside(config: Mapping[str, Any]) -> bool:
    """Say whether a configuration is the graph of a stroboscopic map, which a discontinuity map can stand beside."""
    study = studies().get(str(config.get("study")))
    if study is None or not study.has("order"):
        return False
    if not is_own(config["map"]):
        return config["map"] == "stroboscopic" and not config.get("walls")
    found = own_object(config["map"])
    return isinstance(found, Map) and found.model is not None and found.section == "strobe"


def model_of(config: Mapping[str, Any]) -> Any:
    """Return the oscillator of a checked configuration: the paper's, where nothing else is said."""
    given = {name: value for name, value in config.get("parameters", {}).items() if name != "phase"}
    if config.get("table"):
        return read_table(config["table"]).replace(**given)
    if config.get("model"):
        return own_model(config["model"]).replace(**given)
    if config.get("walls"):
        known = {**parameter_defaults({**config, "map": "impact"}), **given}
        return walled_of(config["walls"], known, config.get("mass"), config.get("base"))
    law = config.get("law") or LAW
    known = {**parameter_defaults({**config, "map": "impact", "law": law}), **given}
    forcing = Forcing(known["omega"], known["t0"], known["d"], known["cos"], known["sin"])
    bounce = LAWS[law](**{name: known[name] for name in law_names(law)})
    paper = beyond_pinball(config) is None
    kept: dict[str, Any] = {"mass": config.get("mass"), "stop": config.get("stop"), "offset_name": "d", "paper": paper}
    kept["base"] = based_on(config.get("base"), forcing)
    kept[spring_in(config)] = known[spring_in(config)]
    return Oscillator(known["alpha"], forcing=forcing, reset=bounce, sigma=known["sigma"], **kept)
