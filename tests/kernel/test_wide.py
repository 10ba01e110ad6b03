"""Where the wide forms are not taken the plain ones give the same bits, and it is said why."""

import json
import os
import re
from importlib.metadata import version
from pathlib import Path

import pytest

import grazing
from grazing.cli.info import info
from grazing.kernel import private, wide
from grazing.kernel.compile import compiled
from grazing.kernel.content import digest, is_kernel
from grazing.kernel.rows import all_passed
from grazing.kernel.turns import eights
from grazing.kernel.wide import forms
from tests.kernel import wide_program
from tests.processes import python

ROOT = Path(__file__).parents[2]
SOURCE = Path(grazing.__file__).parents[1]


def told(before="", bits=False, **environment):
    """Return what a process prints, in which something is done before the forms are chosen."""
    paths = [str(SOURCE), str(ROOT)]
    program = f"import sys; sys.path[:0] = {paths}\n{before}\nfrom tests.kernel.wide_program import tell\ntell({bits})"
    done = python(program, env={**os.environ, **environment, "NUMBA_DISABLE_JIT": "0"})
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def plain():
    return told(bits=not wide.plain(), GRAZING_WIDE="0")


def test_the_plain_forms_give_the_same_bits(plain):
    """The block and the scalar routine, strict: every orbit, letter, near miss and slow impact.

    Where this process takes the plain forms itself there is nothing to compare: they are compiled once, and fly.
    """
    assert plain["why"] == "GRAZING_WIDE is 0"
    here = wide_program.bits()
    assert wide.plain() or plain["bits"] == here


def test_the_forms_are_told_apart(plain):
    """On the disk, in hashes, and by the name of the processor that fast results carry."""
    here = wide_program.told_apart()
    if wide.plain():
        assert plain["apart"] == here
    else:
        assert not set(plain["apart"]) & set(here)
    assert plain["step"] == wide_program.step()  # what needs no wide form is the same in both


@pytest.mark.parametrize(
    ("before", "why"),
    [
        ("private.TRIED['numba'] = '0.1'", f"numba is {version('numba')}, they were tried on 0.1"),
        ("private.TRIED['llvmlite'] = '9'", f"llvmlite is {version('llvmlite')}, they were tried on 9"),
        ("private.WIDE['cgutils'] = 'numba.nowhere'", "No module named 'numba.nowhere'"),
        ("private.WIDE['lowering'] = 'numba.extending'", "module 'numba.extending' has no attribute 'lowering'"),
        ("private.KEPT['FunctionCache'] = 'numba.nowhere'", "No module named 'numba.nowhere'"),
    ],
)
def test_another_numba_means_plain_forms_and_the_same_numbers(before, why):
    """Whatever is not where it was; where files cannot be written as before, none is, and nothing fails."""
    found = told(f"from grazing.kernel import private; {before}")
    if not wide.plain():
        assert found["why"] == why
    assert found["small"] == wide_program.small()


def test_the_versions_at_hand_are_those_that_were_tried():
    at_hand = all(f"{version(name)}.".startswith(f"{tried}.") for name, tried in private.TRIED.items())
    wanted = at_hand and os.environ.get("GRAZING_WIDE") != "0" and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
    assert (not wide.plain()) == wanted
    assert (all_passed in forms()) == (eights in forms()) == (not is_kernel(all_passed)) == wanted
    if at_hand:
        assert all(getattr(private, name) is not None for name in (*private.WIDE, *private.KEPT))


def test_private_names_stand_in_one_file():
    named = re.compile(r"(?:from|import) (?:numba\.(?!extending)\w+|llvmlite\.\w+)")
    files = [file for file in (SOURCE / "grazing").rglob("*.py") if file.name != "private.py"]
    assert [file.name for file in files if named.search(file.read_text(encoding="utf-8"))] == []


def test_a_record_of_rows_is_frozen_into_a_kernel():
    first, same, other = (wide_program.reads(1, 2), wide_program.reads(1, 2), wide_program.reads(1, 3))
    assert digest(first) == digest(same) != digest(other)
    assert compiled(first)((5.0, 6.0, 7.0, 8.0)) == 13.0
    assert compiled(other)((5.0, 6.0, 7.0, 8.0)) == 14.0


def test_info_says_that_plain_forms_are_taken(tmp_path, monkeypatch, capsys):
    (tmp_path / "a.toml").write_text('study = "diagram"\n[vary]\nd = "0:1:2"\n')
    monkeypatch.setattr(wide, "plain", lambda: "numba is 9.9")
    assert info(tmp_path / "a.toml") == 0
    assert "here:      kernels are slower than they could be: numba is 9.9\n" in capsys.readouterr().out
    monkeypatch.setattr(wide, "plain", str)
    assert info(tmp_path / "a.toml") == 0
    assert "here:" not in capsys.readouterr().out
