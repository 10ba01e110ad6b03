"""Rounds are interleaved, ratios are taken round by round, and what cannot run says so."""

import pytest

from benchmarks import measure as module
from benchmarks.goals import Goal, goals, reached
from benchmarks.measure import Result, attention, beside, measure, ratio
from benchmarks.program import Missing, foreign
from benchmarks.row import Job, Row, part
from benchmarks.rows import rows


def silent(what):
    pass


def row(name, log, amount=1, **how):
    return Row(name, lambda share: Job(lambda: log.append(name), amount), ("a",), **how)


def test_every_row_runs_once_before_and_once_in_each_round(monkeypatch):
    clock = iter(range(1000))
    monkeypatch.setattr(module, "perf_counter", lambda: float(next(clock)))
    log = []
    results = measure([row("a", log), row("b", log, 6, threads=2)], 3, 1.0, silent)
    assert log == ["a", "b"] + 3 * ["a", "b"]
    assert results[0].rates == [1.0, 1.0, 1.0]
    assert results[1].rates == [3.0, 3.0, 3.0]  # per core
    assert ratio(results[1], results[0]) == 3.0
    assert len(results[0].cpu) == 3
    assert reached(Goal("b", 5.0, "a"), results) == 6.0
    assert reached(Goal("b", 5.0, "c"), results) is None


def test_a_ratio_is_the_median_over_rounds_and_not_the_ratio_of_medians():
    a, b = (Result(row("x", [], 1), Job(silent, 1), seconds=s) for s in ([1.0, 2.0, 8.0], [2.0, 6.0, 8.0]))
    assert ratio(a, b) == 2.0


def test_what_is_missing_says_so_and_is_not_timed():
    def nothing(share):
        raise Missing("not installed")

    log = []
    results = measure([Row("m", nothing, ("a",)), row("a", log)], 2, 1.0, silent)
    assert results[0].missing == "not installed"
    assert results[0].seconds == results[0].rates == []
    assert len(log) == 3
    assert beside(results[0], results) is results[1]


def test_a_failing_peer_becomes_a_row():
    with pytest.raises(Missing, match=r"failed: ValueError: first line$"), foreign():
        raise ValueError("first line\nsecond line")


def test_a_share_is_at_least_one():
    assert [part(25, 1.0), part(25, 0.2), part(2, 0.2)] == [25, 5, 1]


def test_names_are_unique_and_goals_name_rows():
    names = [row.name for row in rows(("kernels.py", "f"))]
    assert len(set(names)) == len(names)
    for goal in goals("f"):
        assert {goal.row, goal.other} <= set(names)
    for each in rows():
        assert set(each.beside) <= set(names)


def test_a_busy_machine_is_noticed():
    job = Job(silent, 1)
    results = [
        Result(row("a", []), job, seconds=[1.0, 2.0, 2.0], cpu=[1.0, 1.0, 1.2]),
        Result(row("b", [], threads=2), job, seconds=[1.0], cpu=[9.0]),
        Result(row("c", []), missing="not installed"),
    ]
    assert attention(results) == 0.6
    assert attention([]) == 1.0
