"""Programs that fly balls on the same table, and what is said of their speed."""

import io

import numpy as np
import pytest
from rich.console import Console

from benchmarks import pinball
from benchmarks.engines import judged
from benchmarks.program import Missing


@pytest.mark.parametrize("name", pinball.PROGRAMS)
def test_every_program_flies_or_says_why_not(name):
    try:
        program, hits = pinball.PROGRAMS[name]()
    except Missing as reason:
        assert "install" in str(reason)
        return
    assert program(3, 0.005) > 0.0
    if hits is not None:
        assert hits(0.1) and not hits(-0.1)  # deep, and far away
    if name == "grazing, launches":
        assert judged(hits) == "0, 0 of 40"


def test_the_table_is_that_of_the_other_programs():
    table = pinball.table_of(pinball.places(8))
    assert table.gravity == 1.0 and table.rho == 0.0 and len(table.objects) == 12
    for place, one in zip(pinball.places(8), table.objects, strict=False):
        assert one.shape["radius"] == 0.5 and np.allclose(place, (one.shape["x"], one.shape["y"]))


def test_what_was_measured_is_shown():
    out = io.StringIO()
    rows = [pinball.Rate("one", dict.fromkeys(pinball.DISCS, 4.726), passes="1, 0 of 40"),
            pinball.Rate("two", missing="no g++ here")]  # fmt: skip
    pinball.show_pinball(Console(file=out), rows)
    assert "| one | 4.73 | 4.73 | 4.73 | 1, 0 of 40 |" in out.getvalue() and "| two | no g++ here |" in out.getvalue()
