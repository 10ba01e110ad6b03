"""Progress: a bar with rate and time left on a terminal, few plain lines elsewhere."""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from grazing.cli import progress

SOURCE = Path(__file__).parents[2] / "src"
COUNT = """
import sys, time
from grazing.cli import progress
with progress.counted("values") as show:
    for i in range(20):
        show(i + 1, 20)
        time.sleep(0.05)
print("done")
"""


class Clock:
    """A clock that is set by hand."""

    def __init__(self, monkeypatch):
        self.now = 100.0
        monkeypatch.setattr(progress.time, "monotonic", lambda: self.now)


@pytest.fixture
def clock(monkeypatch):
    return Clock(monkeypatch)


def lines(capsys):
    return capsys.readouterr().err.splitlines()


def test_lines_come_ever_more_rarely_with_rate_and_time_left(clock, capsys):
    total = 36000
    with progress.counted("values") as show:
        for second in range(1, 3601):
            clock.now += 1.0
            show(10 * second, total)
    said = lines(capsys)
    assert 50 <= len(said) <= 70
    assert said[0] == "[   50/36000]    5.0 s  10 values/s, 59 min 55 s left"
    assert said[-1] == "[36000/36000] 3600.0 s  10 values/s"


def test_what_was_there_already_is_not_in_the_rate(clock, capsys):
    with progress.counted("cells") as show:
        clock.now += 10.0
        show(900, 1000)
        clock.now += 10.0
        show(950, 1000)
    assert lines(capsys)[-1] == "[ 950/1000]   20.0 s  5 cells/s, 10 s left"


def test_a_quick_study_has_one_line(clock, capsys):
    with progress.counted("values") as show:
        for i in range(100):
            clock.now += 0.01
            show(i + 1, 100)
    assert lines(capsys) == ["[100/100]    1.0 s  100 values/s"]


def test_quiet_says_nothing(capsys):
    with progress.counted("values", quiet=True) as show:
        show(1, 1)
    with progress.said("following the curves", quiet=True):
        pass
    assert lines(capsys) == []


def test_a_step_of_unknown_length_is_said_before_it_begins(capsys):
    with progress.said("following the curves"):
        assert lines(capsys) == ["following the curves"]


def test_the_line_of_the_last_cell_names_what_follows(capsys):
    with progress.counted("cells", then="following the attractors") as show:
        show(5, 10)
        show(10, 10)
    assert lines(capsys)[-1].endswith("; following the attractors")


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0, "0 s"), (3.14159, "3.1 s"), (59.4, "59 s"), (3599.0, "59 min 59 s"), (1e5, "27 h 46 min")],
)
def test_durations_in_words(seconds, words):
    assert progress.duration(seconds) == words


@pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")
def test_a_terminal_gets_a_bar_with_rate_and_time_left():
    ours, theirs = pty.openpty()
    settings = os.environ | {"PYTHONPATH": str(SOURCE), "TERM": "xterm-256color", "COLUMNS": "100"}
    with subprocess.Popen(
        [sys.executable, "-c", COUNT], env=settings, stdout=subprocess.PIPE, stderr=theirs, stdin=theirs
    ) as process:
        os.close(theirs)
        shown = b""
        while select.select([ours], [], [], 30)[0]:
            try:
                piece = os.read(ours, 65536)
            except OSError:
                break
            if not piece:
                break
            shown += piece
        out = process.communicate(timeout=30)[0]
    os.close(ours)
    text = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown.decode())
    assert out == b"done\n"
    assert "━" in text and "values" in text and "20/20" in text and "left" in text
    assert re.search(r"\d/s", text)
    assert b"\x1b[2K" in shown  # the line is erased


#: The command line, which says when its study begins, with all of numba there: its parts in C lose an interrupt.
BEGUN = """
import runpy
import numba._devicearray
from grazing.studies import plan
run_tasks = plan.run_tasks
def told(*given):
    print("begun", flush=True)
    run_tasks(*given)
plan.run_tasks = told
runpy.run_module("grazing", run_name="__main__", alter_sys=True)
"""


def study_that_takes_for_ever(folder, *study):
    given = [*study, "--map", "gap", *([] if "chart" in study else ["--lam", "0.5"]), "--l", "0.1"]
    return subprocess.Popen(
        [sys.executable, "-c", BEGUN, *given, "--transient", "10000000", "--threads", "1", "-o", "a.png"],
        env=os.environ | {"PYTHONPATH": str(SOURCE)}, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
def test_ctrl_c_stops_a_study_at_once_and_leaves_no_file(tmp_path):
    processes = [
        study_that_takes_for_ever(tmp_path, "diagram", "mu=0:0.1:3000"),
        study_that_takes_for_ever(tmp_path, "chart", "mu=0:0.1:60", "lam=0.1:0.9:60"),
    ]
    try:
        for process in processes:
            assert process.stdout.readline() == "begun\n"
        time.sleep(0.5)  # into the kernels
        for process in processes:
            process.send_signal(signal.SIGINT)
        for process in processes:
            out, err = process.communicate(timeout=30)
            assert process.returncode == 130, err
            assert not out and "stopped: interrupted" in err and "Traceback" not in err
    finally:
        for process in processes:
            process.kill()
            process.communicate()
    assert list(tmp_path.iterdir()) == []


def test_what_follows_may_be_counted_up_to_a_limit(clock, capsys):
    """The time left was that to the limit, 55 minutes of a command that ended a second later."""
    with progress.counted("values", then="points of branches") as show:
        for done in range(1, 11):
            clock.now += 1.0
            show(done, 10)
        for done in range(100, 400, 100):
            clock.now += 10.0
            show(done, 1000)
    said = lines(capsys)
    assert any(line.endswith("; points of branches") for line in said)
    assert said[-1] == "[ 300 of at most 1000]   40.0 s  10 points of branches/s"
