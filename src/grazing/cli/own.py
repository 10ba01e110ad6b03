"""Code of the user, named on the command line: what a file or a store names is not run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from grazing.outcome import InputError

OwnMap = Annotated[
    str | None,
    Parameter(
        name="--map",
        help="file.py:name of the gz.Map of your own that it is made of. What the file itself names is not run.",
        metavar="NAME",
    ),
]
OwnModel = Annotated[
    str | None,
    Parameter(
        name="--model",
        help="file.py:name of the gz.Oscillator of your own that it is made of. What the file itself names is not run.",
        metavar="NAME",
    ),
]


def named_here(
    recipe: Mapping[str, Any] | None, map: str | None, model: str | None, file: str | Path
) -> dict[str, Any]:
    """Return the code that this call names, by the keys of the recipe that it belongs to.

    Raises
    ------
    InputError
        For a name that is none of code, or a recipe that needs none there.
    """
    from grazing.config.own import Named, is_own, located

    found: dict[str, Any] = {}
    for key, text in (("map", map), ("model", model)):
        if text is None:
            continue
        if not is_own(text):
            raise InputError(f"--{key} {text}; give file.py:name")
        if not is_own(str((recipe or {}).get(key, ""))):
            raise InputError(f"--{key} {text}: {file} names no code of your own as its {key}; leave it out")
        found[key] = Named(located(text, "."))
    return found
