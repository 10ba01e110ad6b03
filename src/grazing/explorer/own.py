"""A model of the user's own in the explorer: what the page is told of it, and who computes its reset law.

Where a WebAssembly linker is, the law becomes part of a module that stands in for the oscillator's. Elsewhere the
server computes, see :mod:`grazing.explorer.calls`.
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
from pathlib import Path
from typing import Any

from grazing.config.own import Named, is_own, located, own_object
from grazing.explorer.build import DESCRIPTION, described_module, shipped, toolchain
from grazing.explorer.calls import CALLS, Calls
from grazing.explorer.composed import Module
from grazing.explorer.oscillator import HARMONICS, OF_LAWS, WAVES, field_of, name_of, oscillator_module
from grazing.explorer.webassembly import exported, linker
from grazing.kernel.compile import call
from grazing.kernel.content import digest
from grazing.kernel.disk import cache_folder
from grazing.kernel.export import ENVIRONMENT
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.model import Oscillator
from grazing.oscillator.parameters import damped
from grazing.outcome import GrazingError, InputError, shown
from grazing.writing import whole_file

NAME = "oscillator"
#: Parameters that may have either sign as a rule: sliders reach as far to both sides.
SIGNED = (*WAVES, "offset", "d", "sigma")


def checked(text: Named) -> Oscillator:
    """Return the oscillator that ``file.py:name`` names, if the page can show it.

    Raises
    ------
    InputError
        For anything else, with what the page can show.
    """
    found = own_object(text, "model")
    name = text.rpartition(":")[2]
    shows = f"the explorer shows a gz.Oscillator above one wall at rest, with alpha >= 0, k and {HARMONICS} harmonics"
    if not isinstance(found, Oscillator):
        raise InputError(f"{name} is a gz.{type(found).__name__}; {shows}")
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


def rounded(value: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at least as large."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(float(f"{step * power:.3g}") for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value * (1.0 - 1e-9))


def short(value: float) -> float:
    """Return a number of three digits."""
    return float(f"{value:.3g}")


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


def described(said: str, model: Oscillator) -> dict[str, Any]:
    """Return what the page is told of a model: its values, how far sliders reach, and what programs call it."""
    law = name_of(model.reset) if model.reset.own else model.reset.name
    fields = {name: field_of(name) if name in model.reset.params else name for name in model.params}
    fields[model.offset_name] = "offset"
    file, _, name = said.rpartition(":")
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
        "said": said,
        "file": file,
        "name": name,
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
        raise InputError(f"model = {shown(said)}; give file.py:name, of a gz.Oscillator")
    text = Named(located(said, "."))
    model = checked(text)
    known, calls = shipped(), None
    known["model"] = described(said, model)
    if model.reset.own:
        made = oscillator_module(model.reset)
        module = described_module(NAME, made)
        if linker() is not None:
            code = module_of(text, made, say)
            (folder / module["file"]).write_bytes(code)
            module |= {"bytes": len(code), "sha256": hashlib.sha256(code).hexdigest()}
        elif copied:
            toolchain()  # says what to install: without this server nobody computes
        else:
            module |= {"file": "", "calls": CALLS}
            say("no WebAssembly linker (lld or ziglang): the server computes; compiling the law, some minutes at first")
            calls = Calls(made.entries, f"the reset law {model.reset.name}")
        known["modules"][NAME] = module
    (folder / DESCRIPTION).write_text(json.dumps(known) + "\n", encoding="utf-8")
    return calls


def module_of(text: Named, made: Module, say: Callable[[str], None]) -> bytes:
    """Return the module of a law, which is kept: it is compiled once."""
    parts = [*(digest(entry.kernel) for entry in made.entries), shipped()["exporter"], toolchain()]
    home = cache_folder()
    kept = home / "explorer" / f"{hashlib.sha256(repr(parts).encode()).hexdigest()}.wasm" if home is not None else None
    if kept is not None and kept.is_file():
        return kept.read_bytes()
    say("compiling the reset law for the browser, about a minute")
    with tempfile.TemporaryDirectory() as place:
        target = Path(place) / "own.wasm"
        command = [sys.executable, "-m", "grazing.explorer.own", str(target), text]
        settings = {**os.environ, **ENVIRONMENT, "GRAZING_CACHE": str(Path(place) / "cache")}
        done = subprocess.run(command, env=settings, capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr.strip().splitlines() or [f"the process ended with {done.returncode}"])[-1]
            raise InputError(f"the law could not be compiled for the browser: {last}")
        code = target.read_bytes()
    if kept is not None:
        kept.parent.mkdir(exist_ok=True)
        with whole_file(kept) as new:
            new.write_bytes(code)
    return code


def main() -> int:
    """Compile a law, in a process whose numba does not optimise for this machine."""
    target, text = sys.argv[1:]
    model = checked(Named(text))
    try:
        code = call(exported, oscillator_module(model.reset).entries, who=f"the reset law {model.reset.name}")
    except GrazingError as error:
        print(error, file=sys.stderr)
        return 2
    Path(target).write_bytes(code)
    return 0


if __name__ == "__main__":
    sys.exit(main())
