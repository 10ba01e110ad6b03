"""The set-up: pins, version, and what `make` does before it does its job. Nothing here needs a network."""

import os
import re
import shutil
import subprocess
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import grazing

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
SET_UP = ["Makefile", "pyproject.toml", "constraints.txt", "scripts"]

needs_make = pytest.mark.skipif(shutil.which("make") is None, reason="without make only the pip lines remain")


def constraint_lines():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def pins():
    requirements = [Requirement(line) for line in constraint_lines()]
    return {canonicalize_name(r.name): r for r in requirements}


def needed(requirements, seen):
    """Collect the names of all distributions that the requirements bring along on this machine."""
    for requirement in map(Requirement, requirements):
        extras = requirement.extras or {""}
        if requirement.marker and not any(requirement.marker.evaluate({"extra": e}) for e in extras):
            continue
        name = canonicalize_name(requirement.name)
        if name not in seen:
            seen.add(name)
            without_extras = [r for r in metadata.requires(name) or [] if "extra ==" not in r]
            needed(without_extras, seen)
    return seen


# ---- pins


def test_constraints_are_exact_versions_and_nothing_else():
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[0-9][0-9a-z.]*", line) for line in constraint_lines())
    assert len(pins()) == len(constraint_lines())


@pytest.mark.parametrize("group", ["dependencies", "test"])
def test_everything_that_is_installed_is_pinned(group):
    direct = PROJECT["optional-dependencies"]["test"] if group == "test" else PROJECT["dependencies"]
    assert needed(direct, set()) - pins().keys() == set()


def test_the_build_is_pinned():
    # hatchling and all that it needs, and what it asks for in an editable installation.
    build = {"hatchling", "editables", "packaging", "pathspec", "pluggy", "tomlkit", "trove-classifiers"}
    assert build <= pins().keys()


def test_pins_lie_within_the_declared_bounds():
    declared = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["test"]]
    for requirement in map(Requirement, declared):
        (pin,) = pins()[canonicalize_name(requirement.name)].specifier
        assert requirement.specifier.contains(pin.version), requirement
        assert all(bound.operator == ">=" for bound in requirement.specifier), f"{requirement} has a cap"


# ---- version


def test_the_version_is_the_same_everywhere():
    version = PROJECT["version"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert grazing.__version__ == version
    assert re.findall(r"^version: (.+)$", citation, re.MULTILINE) == [version]
    assert re.findall(r"^## (\S+)", changes, re.MULTILINE)[0] == version


# ---- make


def checkout(folder):
    """Copy what the set-up consists of to a folder with spaces in its path."""
    copy = folder / "my own copy"
    copy.mkdir()
    for name in SET_UP:
        source = ROOT / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, copy / name)
    return copy


def with_environment(copy):
    """Pretend that both installations have been done."""
    program(copy / ".venv" / "bin", "python", "exit 0")
    (copy / ".venv" / "folder").write_text(f"{copy.resolve()}\n")
    for stamp in ("ready", "ready-test"):
        (copy / ".venv" / stamp).touch()
    return copy


def make(copy, *arguments, **environment):
    # The tests are run by a make themselves, whose options must not reach this one.
    outer = {"MAKEFLAGS", "MFLAGS", "MAKELEVEL"}
    settings = {name: value for name, value in os.environ.items() if name not in outer} | environment
    return subprocess.run(["make", *arguments], cwd=copy, env=settings, capture_output=True, text=True)


def program(folder, name, text):
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / name
    file.write_text(f"#!/bin/sh\n{text}\n")
    file.chmod(0o755)
    return str(file)


@needs_make
@pytest.mark.parametrize(("target", "job"), [("paper", "-m grazing paper"), ("test", "-m pytest")])
def test_a_second_run_only_does_its_job(tmp_path, target, job):
    dry = make(with_environment(checkout(tmp_path)), "-n", target)
    prepared, line = dry.stdout.splitlines()
    assert prepared.startswith(".venv/bin/python -m grazing.prepare || ")  # it looks whether kernels are as the sources
    assert line.startswith(".venv/bin/python ")
    assert job in line


@needs_make
@pytest.mark.parametrize("changed", ["pyproject.toml", "constraints.txt"])
def test_a_change_of_the_pins_installs_again(tmp_path, changed):
    copy = with_environment(checkout(tmp_path))
    newer = (copy / ".venv" / "ready-test").stat().st_mtime + 10
    os.utime(copy / changed, (newer, newer))
    assert "environment.sh runtime" in make(copy, "-n", "paper").stdout
    assert "environment.sh test" in make(copy, "-n", "test").stdout


@needs_make
@pytest.mark.parametrize("damage", ["moved", "python gone", "no stamp"])
def test_a_damaged_environment_is_made_again(tmp_path, damage):
    copy = with_environment(checkout(tmp_path))
    if damage == "moved":
        copy = copy.rename(tmp_path / "another place")
    elif damage == "python gone":
        (copy / ".venv" / "bin" / "python").unlink()
    else:
        (copy / ".venv" / "ready").unlink()
    assert "environment.sh runtime" in make(copy, "-n", "paper").stdout


@needs_make
def test_paper_asks_for_no_test_package(tmp_path):
    dry = make(checkout(tmp_path), "-n", "paper").stdout
    assert "environment.sh runtime" in dry
    assert "environment.sh test" not in dry


@needs_make
def test_make_alone_lists_the_targets(tmp_path):
    listed = make(checkout(tmp_path)).stdout
    assert all(f"make {target} " in listed for target in ("paper", "test", "test-long", "check", "clean"))


@needs_make
@pytest.mark.parametrize(
    ("python", "said"),
    [
        (None, ["there is no", "3.11 or newer", "apt install python3"]),
        ("exit 127", ["does not run", "make PYTHON="]),
        (
            'case "$2" in *print*) echo 3.9.2;; *) exit 1;; esac',
            ["is Python 3.9.2", "3.11 or newer", "make PYTHON="],
        ),
        (
            'case "$2" in *print*) echo 3.12.3;; *ensurepip*) exit 1;; esac',
            ["Python 3.12.3", "ensurepip", "apt install python3.12-venv"],
        ),
    ],
)
def test_a_python_that_will_not_do_is_answered_with_what_to_install(tmp_path, python, said):
    name = program(tmp_path / "bin", "python3", python) if python else "python-that-is-not-there"
    copy = checkout(tmp_path)
    run = make(copy, "paper", PYTHON=name)
    assert run.returncode != 0
    assert all(words in run.stderr for words in said)
    assert not (copy / ".venv").exists()


# An interpreter that makes environments whose pip notes what it is asked, and fails if told to.
STAND_IN = """
case "$*" in
*print*) echo 3.12.3;;
"-m venv .venv") mkdir -p .venv/bin && cp "$0" .venv/bin/python;;
*"-m pip"*) echo "$*" >> pip.log; env >> pip.log; test ! -e no-network;;
"-m grazing paper"*) echo "PYTHONPATH is ${PYTHONPATH-unset}";;
esac
"""


@needs_make
class TestInstallation:
    @pytest.fixture
    def copy(self, tmp_path, monkeypatch):
        monkeypatch.setenv("PYTHON", program(tmp_path / "bin", "python3", STAND_IN))
        return checkout(tmp_path)

    def asked(self, copy):
        log = copy / "pip.log"
        lines = log.read_text().splitlines() if log.exists() else []
        return [line for line in lines if line.startswith("-m pip")]

    def test_the_pins_are_used_and_the_stamp_comes_last(self, copy):
        assert make(copy, "paper").returncode == 0
        build, package = self.asked(copy)
        assert all("--constraint constraints.txt" in line for line in (build, package))
        assert build.endswith("hatchling editables")
        assert package.endswith("--no-build-isolation --editable .")
        assert (copy / ".venv" / "ready").exists()

    def test_a_second_run_calls_no_pip(self, copy):
        make(copy, "paper")
        make(copy, "test")
        before = self.asked(copy)
        assert make(copy, "paper").returncode == make(copy, "test").returncode == 0
        assert self.asked(copy) == before

    def test_a_failed_installation_leaves_no_stamp_and_is_done_again(self, copy):
        (copy / "no-network").touch()
        assert make(copy, "paper").returncode != 0
        assert len(self.asked(copy)) == 1
        assert not (copy / ".venv" / "ready").exists()
        (copy / "no-network").unlink()
        assert make(copy, "paper").returncode == 0

    def test_failing_to_install_the_tests_leaves_the_paper_alone(self, copy):
        make(copy, "paper")
        (copy / "no-network").touch()
        assert make(copy, "test").returncode != 0
        before = self.asked(copy)
        assert make(copy, "paper").returncode == 0
        assert self.asked(copy) == before

    def test_killed_while_installing_the_tests_it_starts_anew(self, copy):
        make(copy, "test")
        (copy / ".venv" / "ready").rename(copy / ".venv" / "ready-before")
        (copy / ".venv" / "left over").touch()
        assert make(copy, "test").returncode == 0
        assert not (copy / ".venv" / "left over").exists()

    def test_the_environment_cannot_lead_astray_but_the_index_stays(self, copy):
        led = {"PYTHONPATH": "elsewhere", "PYTHONHOME": "elsewhere", "PIP_USER": "1", "PIP_TARGET": "other"}
        kept = {"PIP_INDEX_URL": "mine", "PIP_FIND_LINKS": "mine", "HTTPS_PROXY": "mine", "PIP_NO_INDEX": "1"}
        run = make(copy, "paper", **led, **kept)
        assert "PYTHONPATH is unset" in run.stdout
        seen = set((copy / "pip.log").read_text().splitlines())
        assert not seen & {f"{name}={value}" for name, value in led.items()}
        assert {f"{name}={value}" for name, value in kept.items()} <= seen
