"""Files of a store: an interruption anywhere leaves a whole file or none, and is told as what it is."""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from dis import opname
from itertools import count
from linecache import getline

import pytest

import grazing as gz
from grazing import sweep
from grazing.outcome import InputError
from grazing.sweep import files
from grazing.sweep.files import append_line, place, remove_file, write_file
from grazing.sweep.store import Store


class Interrupted:
    """Ctrl-C at the n-th line of `files` that is run; true if there were that many."""

    def __init__(self, n):
        self.left = n

    def __enter__(self):
        self.before = sys.gettrace()
        sys.settrace(self._called)
        return self

    def __exit__(self, *_):
        sys.settrace(self.before)

    def _called(self, frame, event, argument):
        return self._line if frame.f_code.co_filename == files.__file__ else None

    def _line(self, frame, event, argument):
        if event == "line" and not _never_interrupted(frame):
            self.left -= 1
            if self.left == 0:
                raise KeyboardInterrupt
        return self._line

    def __bool__(self):
        return self.left <= 0


def _never_interrupted(frame):
    """No signal is handled where nothing is called; and at the end of a handler Python would keep its exception."""
    ends = opname[frame.f_code.co_code[frame.f_lasti]] == "POP_EXCEPT"
    return ends or getline(files.__file__, frame.f_lineno).strip() == "try:"


def interrupted_anywhere(work, check):
    """Interrupt at every line in turn; return how many there were."""
    for n in count(1):
        try:
            with Interrupted(n) as stop:
                work()
        except KeyboardInterrupt:
            check()
        else:
            assert not stop, "an interruption was swallowed"
            return n - 1
        assert sys.exc_info() == (None, None, None)


def test_an_interruption_anywhere_is_no_other_error_and_leaves_nothing_half_written(tmp_path):
    key = "c/3/0"

    def written():
        write_file(tmp_path, key, b"all of it")

    def check():
        found = [file for file in tmp_path.rglob("*") if file.is_file()]
        assert [file.name for file in found] in ([], ["0"])
        assert all(file.read_bytes() == b"all of it" for file in found)
        remove_file(tmp_path, key)

    assert interrupted_anywhere(written, check) > 20


def appended(root):
    append_line(root, "a/b/log", "1")


def removed(root):
    remove_file(root, "a/b/c")


@pytest.mark.parametrize("work", [appended, removed])
def test_an_interruption_of_a_line_or_a_removal_is_no_other_error(tmp_path, work):
    write_file(tmp_path, "a/b/log", b"0\n")
    assert interrupted_anywhere(lambda: work(tmp_path), lambda: None) > 5


@pytest.mark.skipif(os.name != "posix", reason="handles of folders")
def test_no_handle_is_closed_twice(tmp_path, monkeypatch):
    """A number that is closed twice may be somebody else's the second time."""
    opened, real_open, real_close = [], os.open, os.close

    def opens(*args, **options):
        opened.append(real_open(*args, **options))
        return opened[-1]

    def closes_and_is_interrupted(handle):
        opened.remove(handle)  # ValueError for the second time
        real_close(handle)
        raise KeyboardInterrupt

    monkeypatch.setattr(files.os, "open", opens)
    monkeypatch.setattr(files.os, "close", closes_and_is_interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_file(tmp_path, "a/b/c/d", b"")


def test_a_folder_that_two_remove_at_once_is_gone(tmp_path, monkeypatch):
    """One of them raised, or said nothing and left the rest there."""
    real, left = os.unlink, [3]

    def another_is_faster(name, **options):
        real(name, **options)
        left[0] -= 1
        if left[0] >= 0:
            raise FileNotFoundError(2, "no such file", name)

    for i in range(5):
        write_file(tmp_path, f"a/b/c/{i}", b"")
        write_file(tmp_path, f"a/d/c/{i}", b"")
    monkeypatch.setattr(files.os, "unlink", another_is_faster)
    remove_file(tmp_path, "a/b")
    left[0] = 3
    with place(tmp_path, "a") as here:
        here.remove("d")
    assert [*(tmp_path / "a").iterdir()] == []


def test_a_store_whose_leftovers_cannot_be_removed_says_so(tmp_path, monkeypatch):
    """Behind the workers of an executor it was a bare error of the system."""
    real, calls = Store.remove_partials, []

    def fails(store, numbers):
        calls.append(numbers)
        if len(calls) > 1:
            raise PermissionError(13, "Permission denied")
        real(store, numbers)

    monkeypatch.setattr(Store, "remove_partials", fails)
    plan = gz.plans.density(gz.gap_map(lam=0.8, mu=0.1, l=0.2), "mu", [0.1, 0.2], starts=3)
    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match="cannot be written: Permission denied"):
        sweep.run(plan, tmp_path / "a.zarr", executor=pool)
    assert len(calls) == 2
