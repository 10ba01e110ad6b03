"""What checks the page's types: pinned without addresses, and told the same of the kernels as kernels.json says."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from grazing.explorer.build import shipped
from grazing.explorer.server import FOLDER

ROOT = Path(__file__).parents[2]
KINDS = {"Floats": "float64", "Whole": "int32", "BigInt64Array<ArrayBuffer>": "int64"}


def lock():
    return json.loads((ROOT / "package-lock.json").read_text(encoding="utf-8"))["packages"]


def test_tools_are_pinned_exactly_and_the_lock_agrees():
    asked = json.loads((ROOT / "package.json").read_text(encoding="utf-8"))
    assert asked.keys() & {"dependencies", "scripts"} == set() and asked["private"]
    pins = asked["devDependencies"]
    checking, shipped_parts = {"axe-core", "typescript"}, {"d3-scale", "d3-selection", "d3-zoom"}
    typed = {f"@types/{name}" for name in shipped_parts}
    assert set(pins) == checking | shipped_parts | typed | {"esbuild"}
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", pin) for pin in pins.values())
    found = {name.removeprefix("node_modules/"): each for name, each in lock().items() if name}
    assert {name: found[name]["version"] for name in pins} == pins
    assert all(each["integrity"].startswith("sha512-") for each in found.values())


def test_the_lock_names_no_address():
    text = (ROOT / "package-lock.json").read_text(encoding="utf-8")
    assert "resolved" not in text and "://" not in text


@pytest.mark.skipif(
    not (ROOT / "node_modules/esbuild").exists(), reason="no esbuild: sh scripts/page.sh tools brings it"
)
def test_the_bundle_is_what_the_pins_give(tmp_path):
    """The parts of d3 in the page are made of the pinned packages, to the byte."""
    made = tmp_path / "d3.mjs"
    subprocess.run(["sh", "scripts/page.sh", "d3", str(made)], cwd=ROOT, check=True, capture_output=True)
    assert made.read_bytes() == (FOLDER / "page" / "d3.mjs").read_bytes()
    assert b"Permission to use, copy, modify" in made.read_bytes()  # and its license goes with it


def test_all_files_of_the_page_are_checked_strictly():
    settings = json.loads((ROOT / "tsconfig.json").read_text(encoding="utf-8"))
    assert settings["include"] == ["src/grazing/explorer/page/*.js"] and "exclude" not in settings
    assert settings["compilerOptions"]["strict"] and settings["compilerOptions"]["checkJs"]
    for path in (FOLDER / "page").glob("*.js"):
        assert not re.search(r"@ts-(?:ignore|nocheck|expect-error)", path.read_text(encoding="utf-8")), path.name


def test_arrays_have_the_types_that_kernels_give_them():
    text = (FOLDER / "page" / "machine.js").read_text(encoding="utf-8")
    typedef = re.search(r"@typedef \{\{([^}]*)\}\} Arrays", text).group(1)
    said = dict(re.findall(r"(\w+): ([\w<>]+)", typedef))
    functions = [each for module in shipped()["modules"].values() for each in module["functions"]]
    kinds = {(a["name"], a["kind"]) for each in functions for a in each["arguments"] if a["shape"]}
    assert len(kinds) == len({name for name, _kind in kinds}), "an array has two kinds"
    assert {(name, KINDS[kind]) for name, kind in said.items()} <= kinds


def without_node(tmp_path):
    """A path on which there is only what a shell script needs."""
    for name in ("sh", "cmp", "cp"):
        (tmp_path / name).symlink_to(shutil.which(name))
    return {**os.environ, "PATH": str(tmp_path)}


@pytest.mark.skipif(os.name != "posix", reason="the scripts are for a shell")
@pytest.mark.parametrize(
    ("job", "left_out"),
    [("types", "the types of the page are not checked by tsc"), ("tools", "the page is not checked by axe")],
)
def test_without_node_what_is_left_out_is_said_and_nothing_fails(tmp_path, job, left_out):
    run = subprocess.run(
        ["sh", "scripts/page.sh", job], cwd=ROOT, env=without_node(tmp_path), capture_output=True, text=True
    )
    assert (run.returncode, run.stdout) == (0, "")
    assert run.stderr.splitlines() == [
        "grazing: no node and npm here (Debian: apt install nodejs npm)",
        f"grazing: {left_out}",
    ]


@pytest.mark.skipif(os.name != "posix", reason="the scripts are for a shell")
def test_without_a_network_what_is_left_out_is_said_and_nothing_fails(tmp_path):
    settings = without_node(tmp_path)
    for name in ("node", "npm"):
        (tmp_path / name).write_text("#!/bin/sh\nexit 1\n")
        (tmp_path / name).chmod(0o755)
    (tmp_path / "here").mkdir()
    for name in ("scripts", "package-lock.json"):
        (tmp_path / "here" / name).symlink_to(ROOT / name)
    run = subprocess.run(
        ["sh", "scripts/page.sh", "types"], cwd=tmp_path / "here", env=settings, capture_output=True, text=True
    )
    assert run.returncode == 0
    assert "npm could not install" in run.stderr and "not checked by tsc" in run.stderr
