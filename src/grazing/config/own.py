"""Models and maps from a user's own Python file, named ``file.py:name``.

To read is not to run. What a file says (a configuration, the recipe of a result, of a store, of a figure) is text, and
text runs nothing, whatever it names. Code runs only where the present call names it: such a name is :class:`Named`, and
only :func:`own_object`, which takes no other, executes a file. No decoder of any format makes one.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import stat
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grazing.copies import OWN_MODULE
from grazing.interrupt import interrupt_in
from grazing.maps.map import Map
from grazing.oscillator.model import Oscillator
from grazing.oscillator.walled import Walled
from grazing.outcome import GrazingError, InputError, UserCodeError, quoted, raised, shown
from grazing.paths import opened
from grazing.systems.contract import System

#: What a model of one's own may be.
Model = Oscillator | Walled | System
MODELS = (Oscillator, Walled, System)
#: The keys of a configuration that can name code.
KEYS = ("map", "model")
TRUST = "trust"
#: Letters of a name: no system opens a file with a longer one, and to look for it takes minutes.
LONGEST = 4096
#: Bytes of a file beyond which it is no program.
LARGEST = 2**24


class Named(str):
    """``file.py:name`` that the present call names: an option of the command line, or ``code="trust"`` in Python."""

    __slots__ = ()


class NotNamed(InputError):
    """Code that a file names and the present call does not."""


def is_own(text: str) -> bool:
    """Say whether a text names something in a Python file."""
    return ".py:" in text


def located(text: str, folder: str | Path) -> str:
    """Return ``file.py:name`` with the file's whole path, found from a folder."""
    file, _, name = text.rpartition(":")
    if len(text) > LONGEST:  # which is said where it is opened
        return text
    try:
        return type(text)(f"{os.path.realpath(Path(folder) / file)}:{name}")
    except (OSError, ValueError):  # it cannot be the name of a file, which is said where it is opened
        return text


def named(config: Mapping[str, Any], code: str | None) -> dict[str, Any]:
    """Return a configuration in which the code that it names is named by this call, if ``code`` is ``"trust"``.

    Raises
    ------
    InputError
        If ``code`` is anything else but None.
    """
    if not (code is None or (isinstance(code, str) and code == TRUST)):
        raise InputError(
            f"code = {shown(code)}; allowed are None, which runs none, and {TRUST!r}, which runs what is named"
        )
    found = dict(config)
    for key in KEYS if code == TRUST else ():
        if isinstance(found.get(key), str) and is_own(found[key]):
            found[key] = Named(found[key])
    return found


def unnamed(config: Mapping[str, Any]) -> str | None:
    """Return the first key of a configuration with code that this call does not name; None if there is none."""
    for key in KEYS:
        text = config.get(key)
        if isinstance(text, str) and is_own(text) and not isinstance(text, Named):
            return key
    return None


def refuse_unnamed(config: Mapping[str, Any]) -> None:
    """Raise :class:`NotNamed` for a configuration with code that this call does not name."""
    key = unnamed(config)
    if key is not None:
        raise not_named(config[key], key)


def not_named(text: str, key: str) -> NotNamed:
    """Return what is said of code that a file names and the present call does not."""
    text = _cut(text)
    return NotNamed(
        f"{key} = {text!r} is code that a file names, and reading a file runs no code. If you trust it, name it in "
        f"this call: --{key} {quoted(text)}; in Python code={TRUST!r}, or give the plan or the map itself"
    )


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def own_object(text: str, key: str = "map") -> Map | Model:
    """Return the map, the oscillator or the system that ``file.py:name`` names. Nothing else executes a file.

    Parameters
    ----------
    text : Named
        Any other text is refused before the file is looked at.
    key : {"map", "model"}
        Where it stands, for the message.

    Raises
    ------
    NotNamed
        If this call does not name it.
    InputError
        If there is no such file or name, or it is something else.
    UserCodeError
        If the file cannot be run.
    """
    if not is_own(text):
        raise InputError(f"{key} = {shown(text)}; give file.py:name")
    if not isinstance(text, Named):
        raise not_named(text, key)
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
        known = sorted(key for key, value in names.items() if isinstance(value, (Map, *MODELS)))
        hint = f"; it has {', '.join(known)}" if known else "; it has no gz.Map, gz.Oscillator or gz.System"
        raise InputError(f"{path} has no name {name!r}{hint}")
    found = names[name]
    if not isinstance(found, (Map, *MODELS)):
        kind = type(found).__name__
        raise InputError(f"{name} in {path} is a {kind}; allowed are a gz.Map, a gz.Oscillator and a gz.System")
    return found


class _Source(importlib.machinery.SourceFileLoader):
    """What runs is the text of the file that is named, as it was read, never what lies compiled beside it."""

    def __init__(self, name: str, path: str, text: bytes) -> None:
        super().__init__(name, path)
        self.text = text

    def get_code(self, fullname: str) -> Any:
        """Return the code of the text."""
        return self.source_to_code(self.text, self.path)


def _module(path: Path) -> Any:
    """Return the module of a file; run it once per process and state of the file."""
    with opened(path) as file:
        text, written = file.read(LARGEST + 1), os.fstat(file.fileno()).st_mtime_ns  # two edits can have one time
    if len(text) > LARGEST:
        raise InputError(f"{path} is larger than {LARGEST} bytes; give file.py:name")
    name = f"{OWN_MODULE}{path.stem}_{abs(hash((str(path.resolve()), written, text)))}"
    if name in sys.modules:
        return sys.modules[name]
    loader = _Source(name, str(path.resolve()), text)
    spec = importlib.util.spec_from_file_location(name, path, loader=loader)
    if path.suffix != ".py" or spec is None or spec.loader is None:
        raise InputError(f"{path} is no Python file; give file.py:name")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (GrazingError, KeyboardInterrupt):
        del sys.modules[name]
        raise
    except BaseException as error:  # of whatever kind; a program that calls sys.exit ends itself, not us
        del sys.modules[name]
        if asked := interrupt_in(error):  # Python says of one in the making of a class that a name cannot be set
            raise asked from None
        raise UserCodeError(f"{path} cannot be run: {raised(error)}") from error
    return module
