"""Models and maps from a user's own Python file, named ``file.py:name``."""

from __future__ import annotations

import importlib.util
import os
import stat
import sys
from pathlib import Path
from typing import Any

from grazing.maps.map import Map
from grazing.oscillator.model import Oscillator
from grazing.outcome import GrazingError, InputError, UserCodeError, shown


def is_own(text: str) -> bool:
    """Say whether a text names something in a Python file."""
    return ".py:" in text


def located(text: str, folder: str | Path) -> str:
    """Return ``file.py:name`` with the file's whole path, found from a folder."""
    file, _, name = text.rpartition(":")
    try:
        return f"{os.path.realpath(Path(folder) / file)}:{name}"
    except (OSError, ValueError):  # it cannot be the name of a file, which is said where it is opened
        return text


def own_object(text: str) -> Map | Oscillator:
    """Return the map or the oscillator that ``file.py:name`` names.

    Parameters
    ----------
    text : str

    Raises
    ------
    InputError
        If there is no such file or name, or it is something else.
    UserCodeError
        If the file cannot be run.
    """
    file, _, name = text.rpartition(":")
    path = Path(file)
    try:
        regular = stat.S_ISREG(path.stat().st_mode)
    except FileNotFoundError:
        regular = False
    except (OSError, ValueError) as error:  # links in a circle, a name that is too long or holds a zero byte
        why = getattr(error, "strerror", None) or error
        raise InputError(f"{shown(file)} cannot be read: {why}; give file.py:name") from None
    if not regular:
        raise InputError(f"there is no file {path}; give file.py:name")
    names = vars(_module(path))
    if name not in names:
        known = sorted(key for key, value in names.items() if isinstance(value, (Map, Oscillator)))
        hint = f"; it has {', '.join(known)}" if known else "; it has neither a gz.Map nor a gz.Oscillator"
        raise InputError(f"{path} has no name {name!r}{hint}")
    found = names[name]
    if not isinstance(found, (Map, Oscillator)):
        raise InputError(f"{name} in {path} is a {type(found).__name__}; allowed are a gz.Map and a gz.Oscillator")
    return found


def _module(path: Path) -> Any:
    """Return the module of a file; run it once per process and state of the file."""
    name = f"_grazing_own_{path.stem}_{abs(hash((str(path.resolve()), path.stat().st_mtime_ns)))}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise InputError(f"{path} is no Python file; give file.py:name")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except GrazingError:
        del sys.modules[name]
        raise
    except Exception as error:
        del sys.modules[name]
        raise UserCodeError(f"{path} cannot be run: {type(error).__name__}: {error}") from error
    return module
