"""A box that orbits leave is said in the result, of any map and by every study that draws its starts there."""

import warnings

import numpy as np
import pytest

import grazing as gz
from grazing import plans, sweep
from grazing.studies.outside import beyond


def shift(state, p):
    (x,) = state
    return ((x - p.c) * p.half + p.c,)


def drawn_to(c):
    """Return a map all of whose orbits go to c, with starts drawn between 0 and 1."""
    return gz.Map(shift, {"c": c, "half": 0.5}, box=((0.0, 1.0),), name="shift")


STUDIES = {
    "orbit_diagram": lambda P, c, **k: gz.orbit_diagram(P, "c", c, starts=5, transient=60, keep=8, **k),
    "coexistence": lambda P, c, **k: gz.coexistence(P, "c", c, starts=5, transient=60, keep=8, **k),
    "chart": lambda P, c, **k: gz.chart(P, {"c": c, "half": [0.5]}, starts=5, transient=60, keep=8, **k),
    "density": lambda P, c, **k: gz.density(P, "c", c, starts=5, transient=60, keep=8, bins=10, **k),
}


@pytest.mark.parametrize("study", STUDIES)
def test_a_study_says_that_orbits_leave_the_box_of_its_starts(study):
    run, P = STUDIES[study], drawn_to(0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = run(P, [0.5, 3.0, -2.0, 1.0, 0.0])
    assert found.outside.values.ravel().tolist() == [0, 5, 5, 0, 0]  # on the edge of the box is in it
    assert found.attrs["grazing_outside"].startswith("10 orbits, in 2 of 5 cells, ended outside the box")
    assert "grazing_outside" not in run(P, [0.5, 0.9]).attrs
    chosen = run(P, [0.5, 3.0], box=((0.0, 1.0),))  # where someone has said where, there is nothing to say
    assert "grazing_outside" not in chosen.attrs and "outside" not in chosen


def test_basins_on_the_box_of_the_map_say_it_too():
    away, at_home = (gz.basins(drawn_to(c), transient=60, keep=8) for c in (3.0, 0.5))
    assert away.outside.values.all() and away.attrs["grazing_outside"].startswith("200 orbits")
    assert "grazing_outside" not in at_home.attrs
    assert "outside" not in gz.basins(drawn_to(3.0), {"x": [0.0, 1.0]}, transient=60, keep=8)


def test_a_store_says_what_the_study_says(tmp_path):
    made = plans.density(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.1, 30.0], starts=5)
    sweep.run(made, tmp_path / "a.zarr")
    found = sweep.open_store(tmp_path / "a.zarr")
    assert found.identical(gz.density(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.1, 30.0], starts=5))


def test_a_ball_that_flies_away_has_left_the_box_and_one_that_rests_has_not():
    away = gz.Oscillator(0.0, 0.0, gz.Forcing(1.0, offset=0.5, cos=(1.0,)), gz.newton(0.5))
    rests = gz.Oscillator(0.5, 0.0, gz.Forcing(1.0, offset=-3.0, cos=(1.0,)), gz.newton(0.5))
    notes = [
        gz.coexistence(gz.stroboscopic_map(m), "alpha", [m.alpha], starts=5, transient=300).attrs.get("grazing_outside")
        for m in (away, rests)
    ]
    assert notes[0].startswith("5 orbits, in 1 of 1 cells") and notes[1] is None


def test_orbits_that_are_lost_are_nowhere():
    last = np.array([[[np.nan, np.inf, -0.01, 1.03, 0.5]]])
    assert beyond(last, np.array([[[0.0, 1.0]]])).tolist() == [[False, True, False, True, False]]
