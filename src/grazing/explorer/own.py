"""A model or a map of the user's own in the explorer: what the page is told of it, and who computes it.

Where a WebAssembly linker is, a reset law becomes part of a module that stands in for the oscillator's, and a map has
one for itself. Elsewhere, and where a module could not have the last digits of Python, the server computes, see
:mod:`grazing.explorer.calls`.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from grazing.config.own import Model, Named, is_own, located, own_object
from grazing.explorer.build import DESCRIPTION, described_module, shipped, toolchain
from grazing.explorer.calls import CALLS, Calls
from grazing.explorer.composed import Module
from grazing.explorer.extents import rounded, short
from grazing.explorer.oscillator import HARMONICS, OF_LAWS, WAVES, field_of, name_of, oscillator_module
from grazing.explorer.own_map import NAME as MAP
from grazing.explorer.own_map import checked_own_map, described_map, map_module
from grazing.explorer.webassembly import exported, linker
from grazing.kernel.compile import call
from grazing.kernel.content import digest
from grazing.kernel.disk import KernelFiles, folders
from grazing.kernel.export import ENVIRONMENT
from grazing.maps.map import Map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.model import Oscillator
from grazing.oscillator.parameters import damped
from grazing.outcome import GrazingError, InputError, shown

NAME = "oscillator"
#: Parameters that may have either sign as a rule: sliders reach as far to both sides.
SIGNED = (*WAVES, "offset", "d", "sigma")


class Brought(NamedTuple):
    """What the user brought: what describes it for the page, and its module, where it needs one of its own."""

    describe: Callable[[], dict[str, Any]]
    name: str
    module: Module | None
    who: str


def brought(text: Named) -> Brought:
    """Return what ``file.py:name`` names.

    Raises
    ------
    InputError
        For what the page cannot show, with what it can.
    """
    found = own_object(text, "model")
    name = text.rpartition(":")[2]
    if isinstance(found, Map):
        P = checked_own_map(name, found)
        return Brought(partial(described_map, P), MAP, map_module(P), f"the step of {P.name}")
    model = checked(name, found)
    module = oscillator_module(model.reset) if model.reset.own else None
    return Brought(partial(described, model), NAME, module, f"the reset law {model.reset.name}")


def checked(name: str, found: Model) -> Oscillator:
    """Return an oscillator if the page can show it.

    Raises
    ------
    InputError
        For anything else, with what the page can show.
    """
    shows = f"the explorer shows a gz.Oscillator above one wall at rest, with alpha >= 0, k and {HARMONICS} harmonics"
    if not isinstance(found, Oscillator):
        raise InputError(f"{name} is a gz.{type(found).__name__}; {shows}, or a gz.Map")
    refused = {
        "a stiffness in place of k": found.stiffness is not None,
        "negative damping": found.alpha < 0.0,
        "a base that moves": found.base is not None,
        "its wall above": found.stop == "above",
        f"{found.harmonics} harmonics": found.harmonics > HARMONICS,
    }
    for what, is_so in refused.items():
        if is_so:
            raise InputError(f"{name} has {what}; {shows} at most")
    return found


def extent_of(model: Oscillator, name: str, value: float) -> tuple[float, float]:
    """Return how far the slider of a parameter reaches."""
    known = damped(model.describe(name))
    if math.isfinite(known.high):
        return known.low, known.high
    of_law = name in model.reset.params and name not in OF_LAWS
    unit = 0.1 * model.unit_of(name) if name == "sigma" else model.unit_of(name)
    far = rounded(max(2.0 * abs(value), 0.0 if of_law and value else unit))
    if name in SIGNED or (of_law and value == 0.0):
        return -far, far
    if value < 0.0:
        return -far, 0.0
    return (0.05 * far if known.open == "low" else 0.0), far


def described(model: Oscillator) -> dict[str, Any]:
    """Return what the page is told of a model: its values, how far sliders reach, and what programs call it."""
    law = name_of(model.reset) if model.reset.own else model.reset.name
    fields = {name: field_of(name) if name in model.reset.params else name for name in model.params}
    fields[model.offset_name] = "offset"
    values = {fields[key]: value for key, value in model.params.items()}
    extents = {fields[key]: extent_of(model, key, value) for key, value in model.params.items()}
    added = [fields[key] for key in model.reset.params if key not in OF_LAWS]
    upper = {key: f"B{key[1:]}" if key in added else f"{key}_B" for key in map(field_of, model.reset.params)}
    (low, high), (slow, fast) = stroboscopic_map(model).box
    positions, velocities = (max(short(low), model.sigma), short(high)), (short(slow), short(fast))
    vary = added[0] if added else "offset"
    state: dict[str, Any] = dict.fromkeys(WAVES, 0.0) | values | {upper[key]: values[key] for key in upper}
    state |= {"sigma_B": positions[1], "law": law, "vary": vary, "reach": extents[vary], "chart": "oscillator"}
    state |= {"second": "omega" if vary == "r" or "r" not in values else "r", "line": positions}
    state |= {
        "positions": positions,
        "velocities": velocities,
        "v0": short(0.3 * slow),
        "u0": short(0.9 * low + 0.1 * high),
    }
    return {
        "law": law,
        "own": [fields[key] for key in model.reset.params] if model.reset.own else [],
        "names": {field: key for key, field in fields.items()},
        "units": {fields[key]: model.describe(key).units for key in model.params} if model.mass is not None else {},
        "extents": extents | {upper[key]: extents[key] for key in upper} | {"phase": (0.0, rounded(model.period))},
        "state": state,
    }


def prepared(said: str, folder: Path, copied: bool, say: Callable[[str], None]) -> Calls | None:
    """Write to a folder the kernels that differ from those that are shipped; return who answers calls, if any.

    Parameters
    ----------
    said : str
        ``file.py:name``, as this call names it.
    folder : Path
    copied : bool
        Whether the page is written to files, which no server computes for.
    say : callable
        Told what takes long.

    Raises
    ------
    InputError
        For a model that the page cannot show, and for a copy of one that no module could be made of.
    """
    if not is_own(said) or said.endswith(":"):
        raise InputError(f"model = {shown(said)}; give file.py:name, of a gz.Oscillator or a gz.Map")
    text = Named(located(said, "."))
    found, known, calls = brought(text), shipped(), None
    file, _, name = said.rpartition(":")
    known["model"] = {"said": said, "file": file, "name": name, **found.describe()}
    if found.module is not None:
        module = described_module(found.name, found.module)
        made = module_of(text, found, copied, say)
        if made is not None:
            (folder / module["file"]).write_bytes(made)
            module |= {"bytes": len(made), "sha256": hashlib.sha256(made).hexdigest()}
        else:
            module |= {"file": "", "calls": CALLS}
            calls = Calls(found.module.entries, found.who)
        known["modules"][found.name] = module
    (folder / DESCRIPTION).write_text(json.dumps(known) + "\n", encoding="utf-8")
    return calls


def module_of(text: Named, found: Brought, copied: bool, say: Callable[[str], None]) -> bytes | None:
    """Return the module of a law or a map, which is kept: it is compiled once; None if the server is to compute.

    Raises
    ------
    InputError
        For a copy, which no server computes for, of what could not be compiled, and for a file that has changed since.
    """
    instead = f"the server computes {found.who}; compiling it, which takes a while at first"
    if linker() is None and not copied:
        say(f"no WebAssembly linker (lld or ziglang): {instead}")
        return None
    tools = toolchain()  # says what to install
    content = content_of(found)
    parts = [*content, shipped()["exporter"], tools]
    home, read = folders()
    kept = KernelFiles(home, f"module-{hashlib.sha256(repr(parts).encode()).hexdigest()[:40]}", read)
    made: tuple[bytes | None, str] | None = kept.load(tools)
    if made is None:
        say(f"compiling {found.who} for the browser, about a minute")
        made = compiled_apart(text)
        if content_of(brought(text)) != content:  # the other process may have read it before, or afterwards
            raise InputError(f"{text.rpartition(':')[0]} has changed while {found.who} was compiled; start again")
        if made[0] is not None:
            kept.save(tools, made)
    code, why = made
    if why and not copied:
        say(f"{why}: {instead}")
        return None
    if code is None:
        raise InputError(f"{found.who} could not be compiled for the browser: {why}")
    if why:
        say(f"{why}: the copy can differ from Python in the last digit")
    return code


def content_of(found: Brought) -> list[str]:
    """Return the hashes of what a module is made of."""
    assert found.module is not None
    return [digest(entry.kernel) for entry in found.module.entries]


def compiled_apart(text: Named) -> tuple[bytes | None, str]:
    """Compile what is named in a process of its own: the module, None where there is none, and what is wrong."""
    with tempfile.TemporaryDirectory() as place:
        target = Path(place) / "own.wasm"
        command = [sys.executable, "-m", "grazing.explorer.own", str(target), text]
        settings = {**os.environ, **ENVIRONMENT, "GRAZING_CACHE": str(Path(place) / "cache")}
        done = subprocess.run(command, env=settings, capture_output=True, text=True, check=False)
        last = (done.stderr.strip().splitlines() or [""])[-1]
        if done.returncode:
            return None, last or f"the process ended with {done.returncode}"
        return target.read_bytes(), last


def main() -> int:
    """Compile a law or a map, in a process whose numba does not optimise for this machine."""
    target, text = sys.argv[1:]
    found = brought(Named(text))
    assert found.module is not None
    borrowed: set[str] = set()
    try:
        code = call(exported, found.module.entries, borrowed, who=found.who)
    except GrazingError as error:
        print(error, file=sys.stderr)
        return 2
    if borrowed:
        print(f"{found.who} takes {', '.join(sorted(borrowed))} of the library of this machine", file=sys.stderr)
    Path(target).write_bytes(code)
    return 0


if __name__ == "__main__":
    sys.exit(main())
