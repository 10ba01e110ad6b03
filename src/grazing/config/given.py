"""Check the parameters of a configuration: which there are, which are missing, and that the map can be made of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

from grazing.config.maps import PINBALL, beyond_pinball, map_of
from grazing.config.own import is_own
from grazing.config.parameters import AMPLITUDES, STIFFNESS, meaning
from grazing.config.problems import Problem, unknown_key
from grazing.config.values import DEFAULT, extremes, number, numbers, range_of
from grazing.config.walls import last_of
from grazing.outcome import GrazingError, InputError
from grazing.parameter import named_by

Recipe = dict[str, Any]


def shared(given: Recipe, known: Recipe) -> Iterator[Problem]:
    """Give r to each wall whose law has one, in place; yield what is then given twice."""
    for name in [name for name in given if name not in known and named_by(name, known)]:
        value = given.pop(name)
        for one in named_by(name, known):
            if one in given:
                yield Problem(("parameters", name), f"{name} stands for {one}, too, which is given beside it; give one")
            given[one] = value


def parameters(config: Recipe, known: Recipe, elsewhere: set[str]) -> Iterator[Problem]:
    """Yield parameters that the map does not have, or needs; then complete them and see that the map can be made."""
    given = config["parameters"]
    sound = True
    for name in given:
        if name not in known:
            sound = False
            extra = (
                f"the {config['law']} law has none"
                if name in ("r", "V", "trigger") and config.get("law")
                else "stiffness is given in its place"
                if name == "k" and STIFFNESS in known
                else "unknown parameter"
            )
            yield Problem(("parameters", name), partial(unknown_key, name, known, extra))
    for problem in all_numbers(given, known):
        sound = False
        yield problem
    for name, default in known.items():
        if default is None and name not in given and name not in elsewhere:
            sound = False
            yield Problem(("parameters", name), f"missing; give {_says(name)}{_why(config, name)}")
    complete = {name: given.get(name, default) for name, default in known.items()}
    chosen = {name for name, written in config["vary"].items() if isinstance(written, str) and written == DEFAULT}
    config["parameters"] = {
        name: value for name, value in complete.items() if value is not None and name not in elsewhere - chosen
    }
    searched = any(complete.get(name) is None for name in chosen & {*known})  # around which value is asked later
    if sound and not searched and config["map"] != "normal-form":
        filled = {name: _first(config, name) if value is None else value for name, value in complete.items()}
        try:
            map_of({**config, "parameters": filled})
        except GrazingError as error:
            yield Problem(("parameters",), str(error))


def _first(config: Recipe, name: str) -> float | list[float]:
    """Return a value of a parameter that varies; what is wrong with its range is said elsewhere."""
    if last_of(name) in AMPLITUDES:  # a list, of which cos1 may vary and cos may not
        return []
    try:
        return float(extremes(range_of(config["vary"][name], name))[0])
    except (InputError, KeyError):
        return 0.5


def all_numbers(given: Recipe, known: Iterable[str] | None = None) -> Iterator[Problem]:
    """Yield parameters that are no numbers, of those that are known, and take the others for numbers."""
    for name in [*given] if known is None else [name for name in given if name in known]:
        if name not in AMPLITUDES:
            try:
                several = last_of(name) in AMPLITUDES  # of a wall's motion
                given[name] = numbers(given[name], name, 0) if several else number(given[name], name)
            except InputError as error:
                yield Problem(("parameters", name), str(error))


def _says(name: str) -> str:
    return "amplitudes of the forcing, 0 for none" if name in AMPLITUDES else meaning(name)


def _why(config: Recipe, name: str) -> str:
    """Return why a parameter that the pinball has is missing all the same."""
    beyond = None if is_own(config["map"]) or config["map"] == "gap" else beyond_pinball(config)
    if beyond is None or config.get("mass") is not None or name not in (*PINBALL, *AMPLITUDES):
        return ""
    return f" (with {beyond} this is not the paper's pinball, and nothing is assumed)"
