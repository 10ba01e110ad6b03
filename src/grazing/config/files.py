"""Configurations in files: TOML in, TOML out."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grazing.config.check import Recipe, checked, plain_of
from grazing.config.toml import read_toml
from grazing.outcome import InputError, shown


def load_config(path: str | os.PathLike[str], *, code: str | None = None) -> Recipe:
    r"""Return the configuration in a TOML file, checked, with all that was left out filled in.

    Parameters
    ----------
    path : path-like
        Paths in it, of a user's own maps and models, begin at its folder.
    code : {"trust"}, optional
        Run the file that ``map`` or ``model`` names, if it is one of your own. Without it nothing is run, and what only
        that code knows is not checked.

    Returns
    -------
    dict
        For :func:`plan_of` and :func:`result_of`.

    Raises
    ------
    InputError
        With every error that there is, one a line, each with its path in the file, what was got and what is allowed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from grazing.config import load_config
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "study.toml"
    ...     _ = file.write_text('study = "diagram"\nvary.d = "0.05:0.16:12"\n[parameters]\nV = 0.2\n')
    ...     config = load_config(file)
    >>> config["parameters"]["V"], config["settings"]["transient"]
    (0.2, 200)
    """
    return checked(read_toml(path), folder=str(Path(path).parent), source=str(path), code=code)


def toml_of(config: Mapping[str, Any]) -> str:
    """Return a configuration as TOML; :func:`load_config` reads back the same.

    Examples
    --------
    >>> print(toml_of({"study": "diagram", "vary": {"d": "0:1:3"}, "settings": {"keep": 5, "box": [[0.0, 1.0]]}}))
    study = "diagram"
    <BLANKLINE>
    [vary]
    d = "0:1:3"
    <BLANKLINE>
    [settings]
    keep = 5
    box = [[0.0, 1.0]]
    <BLANKLINE>
    """
    if not isinstance(config, Mapping):
        raise InputError(f"the configuration is {shown(config)}; give a table of keys and values")
    config = plain_of(config)
    plain = [f"{_key(name)} = {_value(value)}\n" for name, value in config.items() if not isinstance(value, Mapping)]
    tables = [
        f"\n[{_key(name)}]\n" + "".join(f"{_key(key)} = {_value(item)}\n" for key, item in value.items())
        for name, value in config.items()
        if isinstance(value, Mapping) and value
    ]
    return "".join(plain + tables)


def _key(key: Any) -> str:
    name = str(key)
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _value(name)


def _value(value: Any) -> str:
    """Return a value as TOML writes it: text, numbers, lists and tables of them."""
    if hasattr(value, "tolist"):  # of NumPy
        value = value.tolist()
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(name)} = {_value(item)}" for name, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    if not isinstance(value, (str, os.PathLike)):
        raise InputError(f"{shown(value)} in a configuration; give numbers, texts, lists and tables")
    written = json.dumps(os.fspath(value), ensure_ascii=False)  # what no terminal should get is written as its number
    return "".join(letter if letter.isprintable() else f"\\U{ord(letter):08x}" for letter in written)
