"""Kernels that came with the package: found by content and processor, never for an edited source, damage or none."""

import hashlib
import os
import subprocess
import sys
import warnings

import numba
import pytest
from numba.core.codegen import JITCPUCodegen

from grazing.kernel import disk, prepared
from grazing.kernel.wide import plain
from tests.kernel.kept import SOURCE, fresh

pytestmark = pytest.mark.skipif(bool(plain()), reason=f"nothing is prepared in plain forms: {plain()}")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of prepared kernels that holds one, and an empty cache."""
    before, kept = tmp_path / "prepared", tmp_path / "kept"
    for each in (before, kept):
        each.mkdir(mode=0o700)
    monkeypatch.setenv("GRAZING_CACHE", str(before))
    disk.folders.cache_clear()
    assert fresh()(3.0) == 7.0
    monkeypatch.setenv("GRAZING_CACHE", str(kept))
    monkeypatch.setattr(disk, "folder", lambda: before)
    disk.folders.cache_clear()
    yield before
    disk.folders.cache_clear()


def test_what_is_prepared_is_not_compiled(folder):
    entry = fresh()
    assert entry(3.0) == 7.0 and sum(entry.stats.cache_hits.values()) == 1
    (file,) = folder.iterdir()
    assert file.name in prepared.used and not list(disk.cache_folder().iterdir())


def test_an_edited_source_finds_nothing(folder):
    entry = fresh(2.5)
    assert entry(3.0) == 8.5 and sum(entry.stats.cache_hits.values()) == 0


@pytest.mark.parametrize("harm", ["damaged", "of others"])
def test_one_line_says_what_is_not_used_and_the_number_is_right(folder, harm):
    (file,) = folder.iterdir()
    content = file.read_bytes()
    if harm == "damaged":
        file.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
    else:
        file.chmod(0o666)  # others could write it, and not our source
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert fresh()(3.0) == 7.0
    (line,) = [str(each.message) for each in said]
    assert line.startswith(f"the prepared kernel {file} cannot be used") and "\n" not in line
    assert file.exists()  # it is not ours to remove
    again = fresh()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert again(3.0) == 7.0 and sum(again.stats.cache_hits.values()) == 1  # from the cache now


def test_who_can_write_the_source_can_write_what_is_prepared(folder):
    """A package that somebody else installed for all is trusted already: its source runs."""
    (file,) = folder.iterdir()
    file.chmod(0o644)
    entry = fresh()
    assert entry(3.0) == 7.0 and sum(entry.stats.cache_hits.values()) == 1


def test_families_are_what_a_processor_can_do():
    every = ",".join(sorted(prepared.X86_64_V4))
    names = [name for _system, name, _features in prepared.machines(("linux", "mine", every))]
    assert names == ["mine", "x86-64-v4", "x86-64-v3", "x86-64-v2"]
    less = every.replace("+avx512dq", "-avx512dq")
    assert [name for _s, name, _f in prepared.machines(("linux", "mine", less))] == ["mine", "x86-64-v3", "x86-64-v2"]
    assert prepared.machines(("linux", "cortex", "+neon")) == [("linux", "cortex", "+neon")]


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"CPU_NAME": "generic", "CPU_FEATURES": ""},
        {"CPU_NAME": "x86-64-v2", "CPU_FEATURES": prepared.FAMILIES["x86-64-v2"]},
        {"CPU_NAME": "nehalem"},
        {"ENABLE_AVX": 0},
    ],
)
def test_the_processor_that_is_told_is_the_one_that_is_compiled_for(settings, monkeypatch):
    """Fast kernels have its last digits; a sweep that goes on with another one is a mixture."""
    for name, value in settings.items():
        monkeypatch.setattr(numba.config, name, value)
    assert prepared.own()[1:] == JITCPUCodegen("compiler").magic_tuple()[1:]


def test_code_for_a_family_is_found_and_computes_the_same_bits(tmp_path, monkeypatch):
    families = prepared.machines(prepared.own())[1:]
    if not families:
        pytest.skip("this processor belongs to no family that code is prepared for")
    _system, name, features = families[0]
    before, kept = tmp_path / "prepared", tmp_path / "kept"
    kept.mkdir(mode=0o700)
    program = (
        f"import sys; sys.path[:0] = {sys.path!r}\n"
        f"from grazing.kernel.compile import compiled\nnames = {{'__name__': 'a'}}\n"
        f"exec({SOURCE.format(factor=1.7)!r}, names)\nprint(compiled(names['outer'])(3.3).hex())"
    )
    env = {**os.environ, "GRAZING_CACHE": str(before), "NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": features}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
    monkeypatch.setenv("GRAZING_CACHE", str(kept))
    monkeypatch.setattr(disk, "folder", lambda: before)
    disk.folders.cache_clear()
    entry = fresh(1.7)
    assert entry(3.3).hex() == done.stdout.strip() and sum(entry.stats.cache_hits.values()) == 1
    disk.folders.cache_clear()


def test_the_label_of_fast_results_names_the_family(tmp_path, monkeypatch):
    """Their last digits are those of the code, which was compiled for the family."""
    monkeypatch.setattr(prepared, "folder", lambda: tmp_path)
    _system, name, features = prepared.own()
    able = f"{features},{','.join(prepared.X86_64_V2)}"
    prepared.family.cache_clear()
    assert prepared.family(name, able) == ""
    (tmp_path / "stamp-x86-64-v2").write_text(hashlib.sha256(b"").hexdigest())
    prepared.family.cache_clear()
    assert prepared.family(name, able) == "x86-64-v2"
    (tmp_path / "stamp").write_text("")  # prepared for this processor itself
    prepared.family.cache_clear()
    assert prepared.family(name, able) == ""
    prepared.family.cache_clear()
