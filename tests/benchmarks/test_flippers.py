"""A table whose flippers move, by two programs, and what basins cost."""

import io

import numpy as np
from rich.console import Console

from benchmarks import flippers as module


def test_both_programs_fly_the_same_balls(monkeypatch):
    """Until what rounding changes has grown: all launches with few impacts have as many in both."""
    monkeypatch.setattr(module, "BALLS", 1024)
    proven, plain = (make()() for make in module.PROGRAMS.values())
    few = proven <= 8
    assert few.sum() > 200 and np.array_equal(proven[few], plain[few])


def test_basins_of_classic_take_the_work_that_they_are_known_to_take():
    """That of 60 s for a million launches on two cores, at a million impacts a second and core."""
    seen = module.basins(0.03, lambda _what: None)
    assert seen.launches == 900 and 60 < seen.impacts / seen.launches < 95


def test_what_was_measured_is_shown():
    out = io.StringIO()
    found = [module.Flips("one", 1.4726)]
    module.show_flippers(Console(file=out), found, module.Basins(40_000, 3_080_000, 1.5, 2.9))
    assert "| one | 1.47 |" in out.getvalue() and "| 40,000 | 77.0 | 1.5 | 2.9 | 37.5, 60 allowed" in out.getvalue()
