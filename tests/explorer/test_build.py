"""The shipped modules: small, made of these kernels, made again to the same bytes, and safe to call."""

import hashlib
import json

import numpy as np
import pytest
import wasmtime

from grazing.explorer import build
from grazing.explorer.build import FOLDER, MODULES, description, main, rebuild, shipped, stale
from grazing.explorer.webassembly import linker
from tests.explorer.machine import Module

#: Largest sizes in bytes, to be raised knowingly: the page and all it needs have 900 kB. Of the oscillator 26 kB are
#: walls that move or are two: map, tangent and flights once more, as one wall at rest keeps kernels of its own. Of the
#: table 9 kB are slides on flippers that turn.
LARGEST = {"gap": 48_500, "oscillator": 125_000, "table": 88_500}


def test_shipped_modules_are_made_of_these_kernels():
    assert stale() == [], "run make explorer"


def test_sizes():
    sizes = {name: (FOLDER / f"{name}.wasm").stat().st_size for name in MODULES}
    assert all(sizes[name] <= LARGEST[name] for name in MODULES), sizes
    assert sum(sizes.values()) < 261_500


def test_description_lists_what_a_module_exports(machines, described):
    for name, machine in machines.items():
        own = {"memory", "__heap_base", "arena"}
        assert set(machine.exports.keys()) == own | {f["name"] for f in described[name]["functions"]}
        for function in described[name]["functions"]:
            assert function["meaning"]
            given = len(function["sizes"]) + len(function["arguments"])
            assert len(machine.exports[function["name"]].type(machine.store).params) == given
            assert len({a["name"] for a in function["arguments"]}) == len(function["arguments"])


def test_a_changed_kernel_is_noticed(monkeypatch):
    monkeypatch.setattr("grazing.explorer.gap.graze_edge", lambda c, k, l: c * l / k + 1.0)
    assert stale() == ["gap.edges"]


def test_a_changed_parameter_is_noticed(monkeypatch):
    known = shipped()
    known["modules"]["gap"]["fields"][1]["meaning"] = "something else"
    monkeypatch.setattr(build, "shipped", lambda: known)
    assert stale() == ["the description of gap"]


def test_changed_bytes_are_noticed(monkeypatch, tmp_path):
    for name in MODULES:
        (tmp_path / f"{name}.wasm").write_bytes((FOLDER / f"{name}.wasm").read_bytes())
    (tmp_path / "gap.wasm").write_bytes(b"\0asm")
    (tmp_path / build.DESCRIPTION).write_text((FOLDER / build.DESCRIPTION).read_text(encoding="utf-8"))
    monkeypatch.setattr(build, "FOLDER", tmp_path)
    assert stale() == ["gap.wasm", "tables.json"]


def test_description_does_not_depend_on_the_compiler(monkeypatch):
    """Hashes of compiled and of plain kernels are equal: a process without the compiler can tell, too."""
    import os
    import subprocess
    import sys

    code = "import json; from grazing.explorer.build import description; print(json.dumps(description()))"
    settings = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(FOLDER.parents[2])}
    said = subprocess.run([sys.executable, "-c", code], env=settings, capture_output=True, text=True, check=True).stdout
    assert json.loads(said) == json.loads(json.dumps(description()))


@pytest.mark.long
@pytest.mark.skipif(linker() is None, reason="no WebAssembly linker: install lld or ziglang to build the kernels")
def test_the_build_gives_the_same_bytes_again(tmp_path):
    rebuild(tmp_path / "one")
    rebuild(tmp_path / "two")
    for name in MODULES:
        one, two = ((tmp_path / folder / f"{name}.wasm").read_bytes() for folder in ("one", "two"))
        assert one == two
    if build.toolchain() == shipped()["toolchain"]:
        for name in MODULES:
            code = (tmp_path / "one" / f"{name}.wasm").read_bytes()
            assert hashlib.sha256(code).hexdigest() == shipped()["modules"][name]["sha256"]


def test_without_a_linker_the_command_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr(build, "linker", lambda: None)
    assert main([]) == 2
    assert "no WebAssembly linker: install lld (apt) or ziglang (pip)" in capsys.readouterr().err


def test_a_machine_without_room_for_what_is_temporary(monkeypatch, capsys):
    def full(*_given):
        raise OSError(28, "No space left on device", "/tmp/a")

    monkeypatch.setattr(build, "rebuild", full)
    assert main([]) == 2
    assert capsys.readouterr().err == "python -m grazing.explorer.build: /tmp/a: No space left on device\n"


def test_another_toolchain_builds_for_a_comparison_of_what_is_computed(monkeypatch, tmp_path, capsys):
    built = []
    monkeypatch.setattr(build, "toolchain", lambda: {**shipped()["toolchain"], "linker": "LLD 99"})
    monkeypatch.setattr(build, "rebuild", built.append)
    assert main(["--check"]) == 0 and built == []
    assert main(["--check", "--out", str(tmp_path / "other")]) == 0 and built == [tmp_path / "other"]
    assert capsys.readouterr().err.count("bytes are not compared") == 2


@pytest.mark.parametrize("same", [True, False])
def test_the_same_toolchain_compares_bytes(monkeypatch, tmp_path, capsys, same):
    def rebuilt(folder):
        for name in MODULES:
            (folder / f"{name}.wasm").write_bytes((FOLDER / f"{name}.wasm").read_bytes() if same else b"\0asm")

    monkeypatch.setattr(build, "toolchain", lambda: shipped()["toolchain"])
    monkeypatch.setattr(build, "rebuild", rebuilt)
    assert main(["--check", "--out", str(tmp_path / "other")]) == (0 if same else 1)
    assert not (tmp_path / "other").exists()
    said = capsys.readouterr().err
    assert ("byte by byte" in said) == same and ("gap.wasm, oscillator.wasm, table.wasm: other bytes" in said) != same


def test_without_a_description_the_command_says_what_to_run(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(build, "FOLDER", tmp_path)
    assert main(["--check"]) == 2
    assert "run python -m grazing.explorer.build" in capsys.readouterr().err


def called_often(machine, times):
    rows, lanes = np.tile([0.8, 0.1, 0.05], (3, 1)), np.full((3, 1, 4), -0.1)
    points, letters, outcomes = np.empty((3, 60, 1, 4)), np.empty((3, 60, 4), np.int32), np.zeros((3, 1, 4), np.int32)
    machine.call(
        "orbits", columns=3, starts=4, keep=60, rows=rows, lanes=lanes, transient=0, points=points, letters=letters,
        outcomes=outcomes,
    )  # fmt: skip
    arrays = {name: np.empty((3, 4), np.int32) for name in ("period", "begin", "length")}
    for _ in range(times):
        machine.call(
            "classify", columns=3, starts=4, keep=60, rows=rows, points=points, letters=letters, outcomes=outcomes,
            tolerance=1e-9, key=np.empty((3, 4), np.int64), **arrays,
        )  # fmt: skip
    return machine.memory.size(machine.store)


def fresh(described):
    return Module((FOLDER / "gap.wasm").read_bytes(), described["gap"])


def test_what_a_kernel_takes_it_gives_back(described):
    machine = fresh(described)
    before = called_often(machine, 1)
    assert called_often(machine, 200) == before


def test_memory_that_cannot_grow_traps_and_the_module_goes_on(described):
    machine = fresh(described)
    size = called_often(machine, 1)
    place = machine.exports["__heap_base"].value(machine.store)
    for arena, starts in ((place, 2**15), (2**32 - 2**20, 4)):  # room beyond 4 GiB, at once and from where it begins
        machine.exports["arena"](machine.store, arena - 2**32 if arena >= 2**31 else arena)
        with pytest.raises(wasmtime.Trap):
            machine.exports["classify"](
                machine.store, 2**16, starts, 1, place, place, place, place, 1e-9, place, place, place, place
            )
    assert called_often(machine, 1) == size
