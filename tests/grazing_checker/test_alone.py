"""The checker is independent: it runs from a copy of its folder, and its trusted base lists what it imports."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import flint
import pytest

import grazing_checker
from grazing_checker.check import KINDS, STANDARD_LIBRARY, TRUSTED_BASE, trusted_base
from tests.grazing_checker.bases import bases
from tests.grazing_checker.documents import changed, documents, resealed

FOLDER = Path(grazing_checker.__file__).parent


def imported(file):
    """Every module that a file imports, at whatever depth."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0
            yield node.module


def test_the_trusted_base_lists_exactly_what_is_imported():
    found = {file.name: set(imported(file)) for file in FOLDER.rglob("*.py")}
    own = {name for names in found.values() for name in names if name.split(".")[0] == "grazing_checker"}
    every = {name for names in found.values() for name in names} - own
    assert every == {"flint", *STANDARD_LIBRARY}
    assert [name for name, names in found.items() if "flint" in names] == ["balls.py"]
    assert set(STANDARD_LIBRARY) <= {*sys.stdlib_module_names, "collections.abc"}
    assert f": {', '.join(STANDARD_LIBRARY)}" in TRUSTED_BASE[1]
    assert "python-flint" in TRUSTED_BASE[0]
    assert not any(
        "__import__" in file.read_text() or "import_module" in file.read_text() for file in FOLDER.glob("*.py")
    )


def test_every_kind_says_what_it_rests_on():
    for kind in KINDS:
        assert trusted_base(kind)[: len(TRUSTED_BASE)] == list(TRUSTED_BASE)
        assert len(trusted_base(kind)) > len(TRUSTED_BASE)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """A folder with a copy of the checker and python-flint, and a way to run it there with nothing else of ours."""
    place = tmp_path_factory.mktemp("alone")
    shutil.copytree(FOLDER, place / "grazing_checker", ignore=shutil.ignore_patterns("__pycache__"))
    (place / "lib").mkdir()
    packages = Path(flint.__file__).parents[1]
    for name in ("flint", "python_flint.libs"):
        if (packages / name).exists():
            (place / "lib" / name).symlink_to(packages / name)
    code = (
        f"import runpy, sys; sys.path[:0] = [{str(place)!r}, {str(place / 'lib')!r}]\n"
        "try: runpy.run_module('grazing_checker', run_name='__main__', alter_sys=True)\n"
        "finally: print(*sorted(name.split('.')[0] for name in sys.modules), file=sys.stderr)"
    )

    def run(*files):
        return subprocess.run(
            [sys.executable, "-I", "-S", "-c", code, *map(str, files)], capture_output=True, text=True, cwd=place
        )

    return run


def test_a_copy_of_the_folder_checks_every_kind_with_nothing_but_python_flint(alone, tmp_path):
    paths, proofs = {}, {name.replace(" ", "-"): document for name, document in bases().items()}
    for name in ("stable", "free", "own", "pair", "kicked", "pd", "table-pd", "bowl-pd", "R", "gap-pd", "small"):
        paths[name] = tmp_path / f"{name}.json"
        paths[name].write_text(json.dumps(proofs[name]))
    assert {proofs[name]["kind"] for name in paths} == set(KINDS)
    done = alone(*paths.values())
    assert done.returncode == 0, done.stderr
    said = [f"{path}: {proofs[name]['statement']}" for name, path in paths.items()]
    assert done.stdout.splitlines() == said
    modules = set(done.stderr.split())
    assert {"flint", "grazing_checker"} <= modules
    assert not modules & {"grazing", "numpy", "scipy", "numba", "mpmath", "site"}


@pytest.mark.parametrize(
    ("copied", "called"),
    [(False, ["-m", "grazing_checker"]), (True, ["-m", "grazing_checker"]), (True, ["-Bmgrazing_checker"])],
    ids=["installed", "a copy beside", "in one word"],
)
def test_a_file_beside_a_certificate_is_not_run(tmp_path, copied, called):
    """Python looks for packages in the folder where -m was said: a flint.py there was run by who checked a proof."""
    for name in ("flint", "json", "hashlib", "fractions", "re", "pathlib", "typing"):
        (tmp_path / f"{name}.py").write_text("open('ran', 'a').write(__name__)\nraise SystemExit(7)\n")
    (tmp_path / "free.json").write_text(json.dumps(documents()["free"]))
    if copied:
        shutil.copytree(FOLDER, tmp_path / "grazing_checker", ignore=shutil.ignore_patterns("__pycache__"))
    env = {name: value for name, value in os.environ.items() if name not in ("PYTHONSAFEPATH", "PYTHONPATH")}
    env |= {} if copied else {"PYTHONPATH": str(FOLDER.parent)}
    asked = [sys.executable, *called, "free.json"]
    found = subprocess.run(asked, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=60)
    assert not (tmp_path / "ran").exists() and found.returncode == 0, found.stderr
    assert found.stdout.startswith("free.json: For the oscillator")


def test_the_exit_code_says_whether_all_are_right(alone, tmp_path):
    good, bad, none = tmp_path / "good.json", tmp_path / "bad.json", tmp_path / "none.json"
    good.write_text(json.dumps(documents()["free"]))
    bad.write_text(json.dumps(resealed(changed(documents()["free"], ("data", "radius", 0), lambda r: f"-{r}"))))
    done = alone(good, bad, none)
    assert done.returncode == 1
    assert done.stdout.startswith(f"{good}: For the oscillator")
    assert f"{bad}: rejected: the boxes are not one inside the other" in done.stderr
    assert f"{none}: rejected: no certificate can be read" in done.stderr
    for wrong in ((), ("--help",), ("-x", good)):
        done = alone(*wrong)
        assert done.returncode == 2
        assert "usage: python -m grazing_checker FILE" in done.stderr


def test_a_certificate_of_the_first_version_is_refused_and_says_how_to_prove_again(alone, tmp_path):
    old = tmp_path / "old.json"
    old.write_text(json.dumps({**documents()["free"], "version": 1}))
    done = alone(old)
    assert done.returncode == 1
    assert "version 1 of the format, this program reads 2; prove it again" in done.stderr
    assert "gz.certify(orbit)" in done.stderr and "gz.enclose(orbit, kind, name)" in done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a full disk of its own")
def test_an_output_that_cannot_be_written_is_no_traceback_and_no_success(tmp_path):
    """A reader that left, as ``| head``, or a full disk was a traceback; what was not said is not proven."""
    good = tmp_path / "good.json"
    good.write_text(json.dumps(bases()["R"]))
    command = [sys.executable, "-m", "grazing_checker", *[str(good)] * 3]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, cwd=FOLDER.parent)
    assert done.returncode == 1
    assert done.stderr == "what certificates prove cannot be written: No space left on device\n"
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=FOLDER.parent) as running:
        running.stdout.close()  # before anything is printed
        assert running.stderr.read() == b""
    assert running.returncode == 1


def test_the_referee_is_told_of_every_file_that_proves():
    """The tables of what is proven where were those of the checker before there were tables of a ball."""
    page = (FOLDER.parents[1] / "docs" / "referee.md").read_text(encoding="utf-8")
    aside = {"__init__", "__main__", "balls", "check", "envelope", "law", "reading", "sentence"}
    assert set(re.findall(r"`(\w+)\.py`", page)) == {file.stem for file in FOLDER.glob("*.py")} - aside
