"""The command that makes a thing again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from grazing.config.check import Recipe, checked
from grazing.config.maps import LAW, UNFOLD, parameter_defaults
from grazing.config.own import is_own, unnamed
from grazing.config.parameters import AMPLITUDES, defaults_of, parameter_names
from grazing.config.settings import settings_of, text_of
from grazing.config.tabled import usual_map
from grazing.config.values import DEFAULT
from grazing.maps.discontinuity import discontinuity_map
from grazing.outcome import InputError, quoted, quoted_file, shown

#: What a configuration says beside study, parameters, ranges and settings, with what is meant if it does not.
KEYS = {
    "map": "stroboscopic",
    "table": None,
    "order": defaults_of(discontinuity_map)["order"],
    "unfold": UNFOLD,
    "model": None,
    "law": LAW,
    "walls": None,
    "mass": None,
    "base": None,
    "stop": None,
    "units": None,
    "si": None,
    "curves": None,
    "coordinate": None,
}


def command_of(config: Mapping[str, Any], out: Sequence[str] = ()) -> str:
    """Return the shell command that makes what a configuration asks for; it names what differs from the defaults.

    Parameters
    ----------
    config : mapping
    out : sequence of str
        Files to write.

    Returns
    -------
    str
        Quoted for a shell, in one line: bash, zsh, or what reads as POSIX says.

    Examples
    --------
    >>> from grazing.config import command_of
    >>> print(command_of({"study": "diagram", "vary": {"d": "0:0.2:500"}, "parameters": {"V": 0.3}}, ["figure 1.png"]))
    grazing diagram d=0:0.2:500 --V 0.3 -o 'figure 1.png'
    """
    if isinstance(out, (str, bytes)) or not isinstance(out, Sequence) or not all(isinstance(file, str) for file in out):
        raise InputError(f"out is {shown(out)}; give a list of names of files")
    recipe = checked(config)
    words = [quoted(token) for token in ("grazing", recipe["study"], *tokens_of(recipe))]
    return " ".join([*words, *(f"-o {quoted_file(file)}" for file in out)])


def tokens_of(recipe: Recipe) -> Iterator[str]:
    """Yield what follows the name of a study: ranges, the map, parameters and settings, without the defaults."""
    for name, written in recipe["vary"].items():
        yield name if written == DEFAULT else f"{name}={text_of('', written)}"
    for key, usual in KEYS.items():
        if key == "map" and "table" in recipe and usual_map(recipe["study"]) is not None:
            usual = usual_map(recipe["study"])
        if recipe.get(key, usual) != usual:
            for value in told_apart(recipe[key]) if key == "curves" else [recipe[key]]:
                yield from _option(key, value)
    unsaid = unnamed(recipe) is not None  # only the code knows its defaults
    usual = (
        {} if unsaid else parameter_defaults({**recipe, "parameters": {}})
    )  # the pinball's, unless law or what varies is not its
    said = {name: value for name, value in recipe["parameters"].items() if value != usual.get(name)}
    defaults = {} if unsaid else parameter_defaults({**recipe, "parameters": said})
    own = is_own(recipe["map"]) or "model" in recipe
    for name, value in recipe["parameters"].items():
        if value != defaults.get(name):
            if name in parameter_names() and not (own and name in AMPLITUDES):
                yield from _option(name, value)
            else:
                yield f"{name}={text_of('', value)}"
    settings = settings_of(recipe["study"]).model_fields
    for name, value in recipe["settings"].items():
        if isinstance(value, bool):
            if value != settings[name].get_default():
                yield f"--{name}" if value else f"--no-{name}"
        elif value != settings[name].get_default():
            yield from _option(name, value)


def told_apart(curves: Sequence[int | str]) -> list[Any]:
    """Return the periods among curves together, and each file."""
    periods = [one for one in curves if isinstance(one, int)]
    return [*([periods] if periods else []), *(one for one in curves if isinstance(one, str))]


def _option(name: str, value: Any) -> Iterator[str]:
    text = text_of(name, value)
    if text.startswith("-"):  # a shell's reader and ours take what begins with - for an option
        yield f"--{name.replace('_', '-')}={text}"
    else:
        yield f"--{name.replace('_', '-')}"
        yield text
