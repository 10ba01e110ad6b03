import os
import resource
import shutil
import subprocess
import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

import grazing as gz
import grazing.sweep.files
from grazing import sweep
from tests.sweep.plans import files, plan


def test_a_failing_disk_is_said_once_and_the_store_goes_on(tmp_path, monkeypatch):
    store, writes, write = tmp_path / "a.zarr", [], os.write

    def full(handle, content):
        writes.append(handle)
        if len(writes) > 24:
            raise OSError(28, "No space left on device")
        return write(handle, content)

    sweep.run(plan(9), store, chunk=1, shard=(9, 9))
    monkeypatch.setattr("grazing.sweep.files.os.write", full)
    said = (
        "a.zarr cannot be written: No space left on device. What is done is kept: make room or put it right, and resume"
    )
    with pytest.raises(gz.GrazingError, match=said):
        sweep.run(plan(9), store)
    monkeypatch.undo()
    assert 1 < sweep.status(store).chunks_done < 9
    assert sweep.run(plan(9), store).complete
    assert sweep.verify(store, 1.0, plan=plan(9)).ok


@contextmanager
def small_disk(folder, size):
    try:
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no small disk can be mounted")
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def test_a_full_disk(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    with small_disk(disk, "200k"):
        filler = disk / "filler"
        filler.write_bytes(b"x" * 60_000)
        with pytest.raises(
            gz.GrazingError, match=r"a.zarr cannot be written: No space left on device. What is done is"
        ):
            sweep.run(plan(40), disk / "a.zarr", chunk=1)
        found = sweep.status(disk / "a.zarr")
        assert 0 < found.chunks_done < 40
        with pytest.raises(gz.GrazingError, match=r"cannot be written: No space left on device"):
            sweep.run(plan(40), disk / "a.zarr")
        with pytest.raises(
            gz.InputError, match=r"b.zarr cannot be made: No space left on device; choose another folder"
        ):
            sweep.run(plan(40), disk / "b.zarr")
        assert {file.name for file in disk.iterdir()} == {"a.zarr", "filler"}
        moved = tmp_path / "a.zarr"  # to where there is room
        shutil.copytree(disk / "a.zarr", moved)
    assert sweep.run(plan(40), moved).complete
    sweep.run(plan(40), tmp_path / "b.zarr", chunk=1)
    assert files(moved) == files(tmp_path / "b.zarr")


def test_a_limit_on_the_size_of_files(tmp_path):
    store = tmp_path / "a.zarr"
    some = plan(4, keep=3000)
    sweep.run(some, store, chunk=1, shard=(4, 4))
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    size = (store / "points" / "c" / "3" / "0" / "0").stat().st_size
    resource.setrlimit(resource.RLIMIT_FSIZE, (size // 2, hard))
    try:
        with pytest.raises(gz.GrazingError, match=r"a.zarr cannot be written: File too large"):
            sweep.run(some, store)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert sweep.run(some, store).complete
    assert not list(store.rglob("*.partial"))


@contextmanager
def as_nobody():
    """Without the rights of the administrator, who may write anywhere."""
    if os.geteuid() == 0:
        os.seteuid(65534)
        try:
            yield
        finally:
            os.seteuid(0)
    else:
        yield


def test_folders_that_cannot_be_written():
    with tempfile.TemporaryDirectory() as name:  # one that others may enter
        folder = Path(name)
        folder.chmod(0o755)
        store = folder / "a.zarr"
        sweep.run(plan(), store, chunk=2, shard=(1, 2))
        full = folder / "full.zarr"
        sweep.run(plan(), full)
        for part in (folder, *folder.rglob("*")):
            part.chmod(0o555 if part.is_dir() else 0o444)
        try:
            with as_nobody():
                with pytest.raises(gz.InputError, match=r"b.zarr cannot be made: Permission denied; choose another"):
                    sweep.run(plan(), folder / "b.zarr")
                with pytest.raises(
                    gz.InputError, match=r"a.zarr cannot be written: Permission denied; a sweep needs a"
                ):
                    sweep.run(plan(), store)
                assert sweep.run(plan(), full).complete  # nothing to write
                assert sweep.open_store(full).attrs["title"] == "test orbits of gap map"
                assert sweep.verify(full, plan=plan()).ok
        finally:
            for part in (folder, *folder.rglob("*")):
                part.chmod(0o755 if part.is_dir() else 0o644)
        assert sweep.run(plan(), store).complete


def test_a_manifest_that_cannot_be_read_is_a_sentence():
    """Its owner alone may enter it: to repair the store ended in a traceback."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        store = folder / "a.zarr"
        sweep.run(plan(), store, chunk=2)
        (store / "manifest" / "template").write_bytes(b"rubbish")
        assert sweep.verify(store, plan=plan(), repair=True).mended
        for part in store.rglob("*"):
            part.chmod(0o777 if part.is_dir() else 0o666)
        (store / "manifest").chmod(0o000)
        try:
            with as_nobody(), pytest.raises(gz.InputError, match=r"a\.zarr cannot be written: Permission denied"):
                sweep.verify(store, plan=plan(), repair=True)
        finally:
            (store / "manifest").chmod(0o755)


def test_a_store_that_goes_away_is_not_made_again(tmp_path):
    store = tmp_path / "a.zarr"
    some, compute = plan(9), plan(9).compute

    def removing(cells, arrays):
        if cells[0] == 4:
            shutil.rmtree(store)
        yield from compute(cells, arrays)

    object.__setattr__(some, "compute", removing)
    with pytest.raises(gz.GrazingError, match=r"cannot be written: it was removed while it was being computed"):
        sweep.run(some, store, chunk=1, threads=1)
    assert not (store / "points").exists()


@pytest.mark.parametrize("how", ["removed", "moved", "head", "aside", "array", "manifest"])
@pytest.mark.parametrize("when", ["computing", "writing", "recording"])
def test_what_goes_away_under_a_run_is_a_plain_error_and_is_not_made_again(tmp_path, monkeypatch, how, when):
    store = tmp_path / "a.zarr"
    gone = {"head": "zarr.json", "aside": ".grazing", "array": "points", "manifest": "manifest"}.get(how, "")
    write = grazing.sweep.files.write_file

    def go():
        if (store / gone).exists():
            os.rename(store / gone, tmp_path / "gone")
            if how == "removed":
                shutil.rmtree(tmp_path / "gone")

    def writing(root, key, content, fsync=False):
        if key == {"writing": "period/c/4", "recording": "manifest/chunks/4"}.get(when):
            go()
        write(root, key, content, fsync)

    some, compute = plan(9), plan(9).compute

    def computing(cells, arrays):
        if when == "computing" and cells[0] == 4:
            go()
        yield from compute(cells, arrays)

    object.__setattr__(some, "compute", computing)
    monkeypatch.setattr("grazing.sweep.store.write_file", writing)
    with suppress(gz.GrazingError):  # what a run does not need, it does not miss
        found = sweep.run(some, store, chunk=1, threads=2)
        assert how in ("aside", "array", "manifest") and found.chunks_done
    monkeypatch.undo()
    if how in ("removed", "moved"):
        assert not store.exists()
        with pytest.raises(gz.InputError, match="there is no sweep in"):
            sweep.status(store)
        return
    with suppress(gz.InputError):
        sweep.open_store(store)
    sweep.verify(store, plan=plan(9), repair=True)
    assert sweep.run(plan(9), store).complete
    assert sweep.verify(store, 1.0, plan=plan(9)).ok
