"""Compile the kernels of the explorer: ``python -m grazing.explorer.build``, with ``--check`` to compare only.

Bytes can be compared only if numba and the linker are those that the shipped modules were built with. With others,
``--check --out FOLDER`` leaves the modules that it built there, so that what they compute can be compared.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from grazing.explorer import webassembly
from grazing.explorer.composed import Module
from grazing.explorer.gap import gap_module
from grazing.explorer.oscillator import oscillator_module
from grazing.explorer.sources import file_digest, source_digest
from grazing.explorer.table import described_tables, table_module
from grazing.explorer.webassembly import Entry, exported, linker, linker_version
from grazing.kernel import export
from grazing.kernel.export import ENVIRONMENT
from grazing.oscillator.parameters import damped
from grazing.outcome import FATAL, GrazingError, InputError, Outcome
from grazing.parameter import Parameter
from grazing.studies.classify import APERIODIC, ENDED, TOLERANCE, UNDECIDED

#: Where the modules lie, shipped with the package.
FOLDER = Path(__file__).parent / "kernels"
DESCRIPTION = "kernels.json"
#: The tables that ship, as the page gets them.
TABLES = "tables.json"
MODULES = {"gap": gap_module, "oscillator": oscillator_module, "table": table_module}


def described_parameter(parameter: Parameter) -> dict[str, Any]:
    """Return what a page needs to know of a parameter; null for no limit."""
    known = damped(parameter)
    low, high = (end if math.isfinite(end) else None for end in (known.low, known.high))
    return {
        "name": parameter.name,
        "symbol": parameter.symbol,
        "meaning": parameter.meaning,
        "low": low,
        "high": high,
        "open_low": parameter.open == "low",
    }


def described_entry(entry: Entry) -> dict[str, Any]:
    """Return what a page needs to call a function."""
    return {
        "name": entry.name,
        "meaning": entry.meaning,
        "sizes": list(entry.sizes),
        "arguments": [
            {"name": a.name, "kind": a.kind, "shape": list(a.shape), "meaning": a.meaning}
            for a in (() if entry.addressed else entry.arguments)
        ],
        "result": "int64" if entry.addressed else entry.result,
    }


def described_module(name: str, made: Module) -> dict[str, Any]:
    """Return what a page needs to know of a module."""
    return {
        "file": f"{name}.wasm",
        "coordinates": list(made.coordinates),
        "letters": made.letters,
        "fields": [
            described_parameter(field) if isinstance(field, Parameter) else dict(field) for field in made.fields
        ],
        "functions": [described_entry(entry) for entry in made.entries],
    }


def description() -> dict[str, Any]:
    """Return the description of all modules, but for what is known only when they are built."""
    modules = {}
    for name, module in MODULES.items():
        made = module()
        modules[name] = described_module(name, made)
        for entry, said in zip(made.entries, modules[name]["functions"], strict=True):
            said["source"] = source_digest(entry.kernel)
    return {
        "about": "written by python -m grazing.explorer.build; how to call a function is said in grazing/explorer",
        "outcomes": {str(flag.name): flag.value for flag in Outcome if flag},
        "fatal": FATAL,
        "periods": {"undecided": UNDECIDED, "aperiodic": APERIODIC, "ended": ENDED},
        "tolerance": TOLERANCE,
        "exporter": [file_digest(Path(file)) for file in (webassembly.__file__, export.__file__)],
        "modules": modules,
    }


def toolchain() -> dict[str, str]:
    """Return the versions that decide the bytes of a module.

    Raises
    ------
    InputError
        Without a linker.
    """
    command = linker()
    if command is None:
        raise InputError("no WebAssembly linker: install lld (apt) or ziglang (pip), or set GRAZING_WASM_LD")
    python = ".".join(map(str, sys.version_info[:2]))
    return {**{n: version(n) for n in ("numba", "llvmlite")}, "python": python, "linker": linker_version(command)}


def build(folder: Path) -> None:
    """Write all modules and their description to a folder; in a process of its own, see :func:`rebuild`."""
    folder.mkdir(parents=True, exist_ok=True)
    text = description()
    text["toolchain"] = toolchain()
    for name, module in MODULES.items():
        code = exported(module().entries)
        (folder / f"{name}.wasm").write_bytes(code)
        text["modules"][name] |= {"bytes": len(code), "sha256": hashlib.sha256(code).hexdigest()}
        print(f"{name}.wasm: {len(code)} bytes", file=sys.stderr, flush=True)
    (folder / TABLES).write_text(tables_text(), encoding="utf-8")
    (folder / DESCRIPTION).write_text(json.dumps(text, separators=(",", ":"), sort_keys=True) + "\n", encoding="utf-8")


def rebuild(folder: Path) -> None:
    """Build in a process whose numba neither optimises for this machine nor takes kernels from the disk.

    Raises
    ------
    InputError
        Without a linker, or if the build fails.
    """
    toolchain()  # says what is missing before a process is started
    with tempfile.TemporaryDirectory() as cache:
        settings = {**os.environ, **ENVIRONMENT, "GRAZING_CACHE": cache}
        done = subprocess.run(
            [sys.executable, "-m", "grazing.explorer.build", "--here", str(folder)], env=settings, check=False
        )
    if done.returncode:
        raise InputError(f"the kernels were not built: the process ended with {done.returncode}")


def shipped() -> dict[str, Any]:
    """Return the description of the modules in the package.

    Raises
    ------
    InputError
        If there is none.
    """
    try:
        return json.loads((FOLDER / DESCRIPTION).read_text(encoding="utf-8"))  # type: ignore[no-any-return]
    except (OSError, ValueError) as error:
        raise InputError(f"no {DESCRIPTION} in {FOLDER} ({error}); run python -m grazing.explorer.build") from None


def stale() -> list[str]:
    """Return which functions of the shipped modules are not those of their kernels any more; empty if all are."""
    now, then = description(), shipped()
    found = [] if now["exporter"] == then["exporter"] else ["the exporter"]
    for name, module in now["modules"].items():
        old = then["modules"].get(name, {})
        before = {function["name"]: function for function in old.get("functions", [])}
        found += [f"{name}.{f['name']}" for f in module["functions"] if before.pop(f["name"], None) != f]
        found += [f"{name}.{gone}" for gone in before]
        code = FOLDER / module["file"]
        known = hashlib.sha256(code.read_bytes()).hexdigest() if code.exists() else ""
        if known != old.get("sha256"):
            found.append(f"{name}.wasm")
        if {key: module[key] for key in ("fields", "coordinates", "letters")} != {
            key: old.get(key) for key in ("fields", "coordinates", "letters")
        }:
            found.append(f"the description of {name}")
    return found if tables_text() == _read(TABLES) else [*found, TABLES]


def tables_text() -> str:
    """Return the tables that ship as text for the page, which takes 2 for 2.0, and fills in what is left out here."""
    found = described_tables()
    for table in found["tables"].values():
        table |= {"block": _in_runs(table["block"]), "params": _around(table["params"], table["objects"])}
    return json.dumps(_whole(found), separators=(",", ":")) + "\n"


def _in_runs(block: list[float]) -> list[float | list[float]]:
    """Return the numbers of a block, with how many zeros there are, as a list of one, for each run of three or more."""
    found: list[float | list[float]] = []
    for zero, run in itertools.groupby(block, lambda value: value == 0.0):
        many = list(run)
        found += [[float(len(many))]] if zero and len(many) > 2 else many
    return found


def _around(names: list[str], objects: list[dict[str, Any]]) -> list[list[str]]:
    """Return the names of parameters before and after those of the objects, which follow from these."""
    law = [[] if one["law"] is None else one["law"]["params"] for one in objects]
    own = [f"{one['name']}.{each}" for one, more in zip(objects, law, strict=True) for each in [*one["shape"], *more]]
    first = names.index(own[0])
    if names[first : first + len(own)] != own:
        raise AssertionError("the parameters of a table are no longer in the order of its objects")
    return [names[:first], names[first + len(own) :]]


def _whole(value: Any) -> Any:
    """Return what JSON says with whole numbers as such: the same to a browser, in fewer letters."""
    if isinstance(value, dict):
        return {key: _whole(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_whole(each) for each in value]
    is_whole = isinstance(value, float) and value.is_integer() and str(value) != "-0.0" and abs(value) < 2.0**53
    return int(value) if is_whole else value


def _read(name: str) -> str:
    file = FOLDER / name
    return file.read_text(encoding="utf-8") if file.exists() else ""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(
        prog="python -m grazing.explorer.build", description="Compile the kernels of the explorer to WebAssembly."
    )
    parser.add_argument("--check", action="store_true", help="build elsewhere and compare with the shipped modules")
    parser.add_argument(
        "--out", metavar="FOLDER", type=Path, help="build to this folder; with --check only if bytes cannot be compared"
    )
    parser.add_argument("--here", metavar="FOLDER", help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    try:
        if given.here:
            build(Path(given.here))
        elif given.check:
            return check(given.out)
        else:
            rebuild(given.out or FOLDER)
    except GrazingError as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    except OSError as error:  # a full disk, or no folder for what is temporary
        print(f"{parser.prog}: {error.filename or 'the kernels'}: {error.strerror or error}", file=sys.stderr)
        return 2
    return 0


def check(out: Path | None = None) -> int:
    """Compare the shipped modules with their kernels, and byte by byte where the toolchain is theirs.

    Where it is another one, modules are built to ``out``, if given, for whoever compares what they compute.
    """
    said = stale()
    if said:
        print(f"not built from these kernels: {', '.join(said)}; run python -m grazing.explorer.build", file=sys.stderr)
        return 1
    here, theirs = toolchain(), shipped()["toolchain"]
    if here != theirs:
        print(f"built with {theirs}, here are {here}: bytes are not compared", file=sys.stderr)
        if out is not None:
            rebuild(out)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        rebuild(Path(folder))
        differ = [f"{n}.wasm" for n in MODULES if (Path(folder) / f"{n}.wasm").read_bytes() != _code(n)]
    if differ:
        print(f"{', '.join(differ)}: other bytes than shipped, from the same toolchain", file=sys.stderr)
        return 1
    print("the shipped modules are what these kernels compile to, byte by byte", file=sys.stderr)
    return 0


def _code(name: str) -> bytes:
    return (FOLDER / f"{name}.wasm").read_bytes()


if __name__ == "__main__":
    sys.exit(main())
