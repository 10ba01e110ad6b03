"""Files of a store: an interruption anywhere leaves a whole file or none, and is told as what it is."""

import os
import sys
from itertools import count
from linecache import getline

import pytest

from grazing.sweep import files
from grazing.sweep.files import append_line, remove_file, write_file


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
        # nothing is called at `try:`, so that no signal is handled there
        if event == "line" and getline(files.__file__, frame.f_lineno).strip() != "try:":
            self.left -= 1
            if self.left == 0:
                raise KeyboardInterrupt
        return self._line

    def __bool__(self):
        return self.left <= 0


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
