"""Reading never executes: every command and every public function is handed files that name code."""

import dataclasses
import inspect
import json
import shutil
import sys
import types
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import sweep
from grazing.catalogue import studies
from grazing.cli.app import app, main
from grazing.config.build import RECIPE, plan_of

CODE = """
with open({marker!r}, "a") as file:
    file.write("ran ")
import grazing as gz
def step(state, p):
    (x,) = state
    return (p.a * x * (1.0 - x),)
P = gz.Map(step, params={{"a": 3.2, "mu": 0.0}}, coordinates=("x",), box=((0.1, 0.9),))
ball = gz.Oscillator(0.1, 1.0, gz.Forcing(2.8), gz.newton(0.8))
"""


def recipes(code: Path) -> Iterator[dict]:
    """What an attacker writes: each study, with a map and with a model of his own."""
    for name, study in studies().items():
        form = {"values": "0.1:0.2:3", "bounds": "0.1:0.2"}[study.form]
        names = ("x", "u") if study.varies == "coordinate" else ("mu", "a")
        vary = {name: form for name in names[: study.least]}
        settings = {"state": [0.1], "period": 1} if name in ("cobweb", "orbit", "branch") else {}
        settings = {key: value for key, value in settings.items() if key == ("state" if name == "cobweb" else "period")}
        more = {"curves": [2, 3]} if name == "chart" else {}
        for own in ({"map": f"{code}:P"}, {"model": f"{code}:ball"}):
            yield {"study": name, **own, "vary": vary, "settings": settings, **more}


def written(folder: Path) -> Path:
    """The files that name code, and the marker that the code leaves when it is run."""
    from grazing.config import toml_of

    code = folder / "theirs.py"
    code.write_text(CODE.format(marker=str(folder / "ran")))
    G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    values = np.linspace(0.0, 0.1, 4)
    plans = {"coexistence": gz.plans.coexistence(G, "mu", values, starts=3, transient=20, keep=10)}
    plans["chart"] = gz.plans.chart(G, {"mu": values, "l": values}, starts=2, transient=20, keep=10)
    assert plans["coexistence"].finish is not None  # what opening a store computes from its recipe
    for i, recipe in enumerate(recipes(code)):
        (folder / f"{recipe['study']}-{i}.toml").write_text(toml_of(recipe))
        if recipe["study"] not in ("coexistence", "chart") or (recipe["study"] == "coexistence" and "model" in recipe):
            continue
        (folder / f"{i}.json").write_text(json.dumps({"kind": "orbit", "law": f"{code}:ball", "recipe": recipe}))
        kept = {**recipe, "vary": [list(item) for item in recipe["vary"].items()]}
        plan = dataclasses.replace(plans[recipe["study"]], recipe=kept)
        sweep.run(plan, folder / f"{i}.zarr", chunk=2)
        sweep.run(plan, folder / f"{i}-half.zarr", chunk=2, shard=(1, 2))
        result = sweep.open_store(folder / f"{i}.zarr", plan)
        gz.save(result.assign_attrs({RECIPE: json.dumps(kept)}), folder / f"{i}.nc")
        for ending in ("png", "svg", "pdf"):
            gz.plot.save(gz.plot.figure(20, 20), folder / f"{i}.{ending}", "forged", {RECIPE: kept})
    return folder


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    return written(tmp_path_factory.mktemp("hostile"))


def look(folder: Path) -> dict[Path, tuple[int, int]]:
    """What is in a folder, and whether it was changed."""
    found = ((path, path.lstat()) for path in folder.rglob("*"))
    return {path: (each.st_size, each.st_mtime_ns) for path, each in found}


@pytest.fixture(scope="module")
def copied(hostile, tmp_path_factory):
    """Copies of all files that are read, made anew when one was changed: some functions remove what they get."""
    kept: dict[str, object] = {}

    def copies() -> Path:
        if not kept or look(kept["folder"]) != kept["seen"]:
            kept["folder"] = tmp_path_factory.mktemp("copies") / "copies"
            shutil.copytree(hostile, kept["folder"])
            kept["seen"] = look(kept["folder"])
        return kept["folder"]

    return copies


@pytest.fixture
def theirs(hostile, copied, tmp_path, monkeypatch):
    """A folder to work in, and the files that are read, of each kind."""
    monkeypatch.chdir(tmp_path)
    marker = hostile / "ran"
    marker.unlink(missing_ok=True)
    for name in [name for name in sys.modules if "theirs" in name]:  # a file is run once per process
        del sys.modules[name]
    found = sorted(
        path for path in copied().iterdir() if path.suffix not in (".py", "") and not path.stem.startswith(".")
    )
    assert {path.suffix for path in found} == {".toml", ".json", ".zarr", ".nc", ".png", ".svg", ".pdf"}
    yield found
    assert not marker.exists(), "code was run that only a file names"


def test_the_code_does_run_where_a_call_names_it(hostile, tmp_path):
    """What shows that the marker would be seen."""
    marker = hostile / "ran"
    marker.unlink(missing_ok=True)
    copy = tmp_path / "theirs.py"
    shutil.copy(hostile / "theirs.py", copy)
    plan_of({"study": "diagram", "map": f"{copy}:P", "vary": {"a": "3:4:3"}}, code="trust")
    assert marker.exists()
    marker.unlink()


# ---- the command line


def commands(of=app, path=()) -> Iterator[tuple[tuple[str, ...], inspect.Signature]]:
    for name in of:
        if not name.startswith("-"):  # help, version, completion
            inner = of[name]
            if inner.default_command is not None:
                yield (*path, name), inspect.signature(inner.default_command)
            yield from commands(inner, (*path, name))


def calls(path: tuple[str, ...], signature: inspect.Signature, file: Path) -> Iterator[list[str]]:
    """Ways to hand a file to a command: in its place, with a figure to write, and for each option of a file."""
    yield [*path, str(file)]
    yield [*path, str(file), "again.zarr"]
    options = [name for name, item in signature.parameters.items() if item.kind is inspect.Parameter.KEYWORD_ONLY]
    if "out" in options:
        yield [*path, str(file), "-o", "out.png"]
    if "json" in options:
        yield [*path, str(file), "--json"]
    if "curves" in options:
        yield [*path, str(file), "--curves", "2,3", "-o", "out.png"]
    if "share" in options:
        yield [*path, str(file), "--share", "1"]
    if "config" in options and signature.parameters["config"].annotation is not bool:
        yield [*path, "--config", str(file)]
        yield [*path, "--config", str(file), "--dump-config"]
        yield [*path, "--config", str(file), "-o", "out.zarr"]
    elif "config" in options:
        yield [*path, str(file), "--config"]


LEAVES = dict(commands())


def test_there_are_commands_to_attack():
    assert {("plot",), ("info",), ("sweep", "verify"), ("config", "show"), ("diagram",)} <= set(LEAVES)


@pytest.mark.parametrize("path", LEAVES, ids=" ".join)
def test_no_command_runs_what_a_file_names(path, theirs, capsys):
    some = {".nc", ".toml"}
    asked = set()
    for file in theirs:
        if path[0] in studies() and path[0] not in file.name:  # its own configurations, and one of each other kind
            if file.suffix not in some:
                continue
            some.remove(file.suffix)
        ways = list(calls(path, LEAVES[path], file))
        own = file.suffix == ".toml" and "map" in file.read_text()
        # each file in its place; of configurations, which differ in their study only, two in every other way too
        for tokens in ways[:1] if (file.suffix, own) in asked and file.suffix == ".toml" else ways:
            main(tokens)
        asked.add((file.suffix, own))
    capsys.readouterr()


# ---- Python


def public(module=gz, above="gz", seen=None) -> Iterator[tuple[str, types.FunctionType]]:
    seen = set() if seen is None else seen
    for name in getattr(module, "__all__", [n for n in vars(module) if not n.startswith("_")]):
        value = getattr(module, name)
        if isinstance(value, types.ModuleType) and value.__name__.startswith("grazing.") and value not in seen:
            seen.add(value)
            yield from public(value, f"{above}.{name}", seen)
        elif isinstance(value, types.FunctionType) and value.__module__.startswith("grazing"):
            yield f"{above}.{name}", value


def takes(function) -> set[str]:
    """What the first argument can be: a path, a mapping, a result."""
    first = next(iter(inspect.signature(function).parameters.values()), None)
    said = "" if first is None else str(first.annotation)
    drawn = {"Dataset"} if function.__module__.startswith("grazing.plot.") and said == "Any" else set()
    return {kind for kind in ("Path", "Mapping", "Dataset") if kind in said} | drawn


PUBLIC = {name: function for name, function in public() if takes(function)}


def test_there_are_functions_to_attack():
    known = {"gz.load", "gz.config.load_config", "gz.config.recipe_of", "gz.config.plan_of", "gz.sweep.open_store",
             "gz.sweep.status", "gz.sweep.verify", "gz.sweep.resume", "gz.plot.provenance", "gz.plot.chart",
             "gz.check_certificate", "gz.save"}  # fmt: skip
    assert known <= set(PUBLIC)


def given(kinds: set[str], theirs: list[Path], code: Path) -> Iterator[object]:
    for file in theirs:
        if "Path" in kinds:
            yield file
        if file.suffix == ".nc" and kinds & {"Dataset", "Mapping"}:
            result = gz.load(file)
            yield from [result] * ("Dataset" in kinds) + [result.attrs] * ("Mapping" in kinds)
        elif file.suffix == ".png" and "Mapping" in kinds:
            yield gz.plot.provenance(file)["provenance"]
    if "Mapping" in kinds:
        yield from recipes(code)


@pytest.mark.parametrize("name", PUBLIC)
def test_no_function_runs_what_a_file_names(name, hostile, theirs, tmp_path):
    function = PUBLIC[name]
    _first, *others = inspect.signature(function).parameters.values()
    more = [item for item in others if item.default is item.empty and item.kind is item.POSITIONAL_OR_KEYWORD]
    for thing in given(takes(function), theirs, hostile / "theirs.py"):
        with suppress(Exception):  # what does not fit is refused; whether code ran is the question here
            function(thing, *(tmp_path / "out.nc" for _ in more))


def test_a_store_opens_with_its_numbers_and_says_what_would_have_to_run(theirs):
    whole = next(path for path in theirs if path.name.endswith(".zarr") and "half" not in path.name
                 and "grazing_note" in sweep.open_store(path).attrs)  # fmt: skip
    found = sweep.open_store(whole)
    assert isinstance(found, xr.Dataset) and found.data_vars
    assert "--map" in found.attrs["grazing_note"] and "theirs.py:P" in found.attrs["grazing_note"]
