"""The loop of the gap map is one of vectors: no machine code shows it, so this is told by the clock, with room."""

from time import perf_counter

import pytest

from benchmarks import gap


def spent(job):
    """Return the seconds of one unit of work, the least of several times."""
    job.run()
    found = []
    for _ in range(5):
        start = perf_counter()
        job.run()
        found.append(perf_counter() - start)
    return min(found) / job.amount


@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
def test_an_iterate_costs_about_a_square_root(monkeypatch, arithmetic):
    """Lane by lane it costs four; the goal of a tenth more at most is for quiet machines, see docs/benchmarks.md."""
    for name, value in (("COLUMNS", 3), ("STARTS", 2048), ("ITERATES", 300)):
        monkeypatch.setattr(gap, name, value)
    assert spent(gap.map_job(arithmetic)) < 2.5 * spent(gap.roots_job())
