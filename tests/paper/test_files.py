import os
import stat
import time

import pytest

from grazing.outcome import InputError
from grazing.paper import files


def test_a_file_is_replaced_whole(tmp_path):
    path = tmp_path / "a.txt"
    files.write(path, "old")
    files.write(path, b"new")
    assert path.read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["a.txt"]
    assert stat.S_IMODE(path.stat().st_mode) == 0o644


@pytest.mark.parametrize("when", ["fsync", "replace"])
def test_an_interruption_leaves_the_old_file(tmp_path, monkeypatch, when):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def interrupt(*_args):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, when, interrupt)
    with pytest.raises(KeyboardInterrupt):
        files.write(path, "new, and much longer")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_what_a_killed_run_left_is_removed(tmp_path):
    left = tmp_path / f".{'0' * 32}.partial"
    left.write_text("half")
    os.utime(left, (0, 0))
    (tmp_path / "kept.txt").write_text("kept")
    files.folder(tmp_path)
    assert os.listdir(tmp_path) == ["kept.txt"]


def test_a_folder_is_made_with_its_parents(tmp_path):
    assert files.folder(tmp_path / "a" / "b").is_dir()


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path):
    path = tmp_path / "a"
    path.write_text("mine")
    with pytest.raises(InputError, match=r"cannot write to '.*a': .*; a folder that can be made .* is allowed"):
        files.folder(path)
    assert path.read_text() == "mine"


def test_a_disk_error_is_said(tmp_path, monkeypatch):
    def full(*_args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left on device"):
        files.write(tmp_path / "a", "text")
    assert os.listdir(tmp_path) == []


def test_what_other_programs_have_left_stays(tmp_path):
    theirs = [".film.mkv.part", ".index.html.partial", f".{'g' * 32}.partial", f".a-{'0' * 32}.partial"]
    for name in theirs:
        (tmp_path / name).write_text("half")
        os.utime(tmp_path / name, (0, 0))
    growing = f".{'0' * 32}.partial"  # of another run, right now
    (tmp_path / growing).write_text("half")
    for i, years in enumerate((-1, 30), start=1):  # ours, the second of a clock that was wrong
        (tmp_path / f".{i:032}.partial").write_text("half")
        os.utime(tmp_path / f".{i:032}.partial", (time.time() + years * 3e7,) * 2)
    files.folder(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*theirs, growing])
