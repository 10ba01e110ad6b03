"""Paths: how much of the equations is evaluated on the way."""

from collections import Counter

import pytest

import grazing as gz
from grazing.orbits import corrector, impact_equations
from grazing.orbits.impact_equations import ImpactEquations
from grazing.orbits.map_equations import MapEquations
from grazing.orbits.piece_equations import PieceEquations
from grazing.oscillator.rig import Rig
from grazing.oscillator.walled import Walled
from tests.orbits.test_locus import NORMAL, only
from tests.test_in_any_unit import henon


@pytest.fixture
def work(monkeypatch):
    """How often something is done: Newton steps of paths, and what equations are asked for."""
    done = Counter()

    def count(owner, name, label):
        plain = getattr(owner, name)

        def counted(*args, **more):
            done[label] += 1
            return plain(*args, **more)

        monkeypatch.setattr(owner, name, counted)

    count(corrector, "linearised", "steps")
    count(corrector, "corrected", "points")
    count(Rig, "rows_seen", "prepared")
    count(ImpactEquations, "evaluated", "evaluated")
    count(ImpactEquations, "_profiles", "profiles")
    count(impact_equations, "call", "kernels")
    count(MapEquations, "ran", "runs")
    count(PieceEquations, "_looked_at", "runs")
    return done


def test_a_newton_step_along_a_branch_evaluates_the_closing_equations_once(work):
    orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    branch = gz.continuation(orbit.map, orbit, "d", (0.09, 0.13))
    orbits = len(list(branch)) + len(branch.special)
    assert work["points"] <= work["steps"] < 2.6 * work["points"]
    assert work["evaluated"] <= work["steps"] + orbits + 50  # where branches begin
    assert work["profiles"] <= work["points"] + orbits + 50
    assert work["prepared"] <= work["steps"] + work["points"] + 2 * orbits + 100
    assert work["kernels"] == work["evaluated"] + work["profiles"]


def test_a_newton_step_along_a_locus_evaluates_its_test_function_once(work):
    orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    graze = gz.continuation(orbit.map, orbit, "d", (0.09, 0.13)).special[0]
    work.clear()
    curve = gz.locus(graze, ("d", "V"), ((0.0, 0.14), (0.2, 0.6)))
    orbits = len(curve.orbits) + len(curve.meetings)
    assert work["evaluated"] <= work["steps"] + orbits + 20
    assert work["profiles"] <= work["steps"] + work["points"] + orbits + 20


@pytest.mark.parametrize("kind", ["step", "pieces"])
def test_a_newton_step_along_a_locus_of_a_map_runs_it_a_few_times(work, kind):
    if kind == "pieces":
        special, names, bounds = only(NORMAL, "L", "tL", (-3.0, 3.0), "pd"), ("tL", "dL"), ((-3.0, 3.0), (-0.5, 1.5))
    else:
        orbit = next(one for one in gz.periodic_orbits(henon(0.1, 0.3, 1.0, 1.0), period=1) if one.stable)
        found = gz.continuation(orbit.map, orbit, "a", (-0.9, 1.2), limit=400).special
        special, names, bounds = next(one for one in found if one.type == "pd"), ("a", "b"), ((0.2, 0.6), (0.1, 0.5))
    work.clear()
    curve = gz.locus(special, names, bounds)
    assert len(curve.orbits) > 10
    # derivatives, test function and slopes once a step; at each point whether the map jumps on the way, and the orbit
    assert work["runs"] <= 4 * work["steps"] + 6 * work["points"] + 4 * len(curve.orbits) + 40


def test_a_branch_between_walls_makes_a_model_for_each_orbit_and_one_for_each_point(monkeypatch):
    walls = gz.wall(-0.3, gz.newton(0.8)), gz.wall(0.5, gz.newton(0.8))
    P = gz.stroboscopic_map(gz.Oscillator(1.0, 1.2, gz.Forcing(1.4, offset=0.1, cos=(1.2,)), walls=walls))
    orbit = next(one for one in gz.periodic_orbits(P, 1, starts=20, threads=1) if one.impacts == 2)
    made, points = [], []
    plain, ran = Walled.replace, corrector.tangent_of
    monkeypatch.setattr(Walled, "replace", lambda model, **changes: made.append(1) or plain(model, **changes))
    monkeypatch.setattr(corrector, "tangent_of", lambda *args: points.append(1) or ran(*args))
    branch = gz.continuation(P, orbit, "omega", (1.2, 1.8))
    assert len(list(branch)) > 20  # whether a point is symmetric was asked of a model of its own from either side
    assert len(made) <= len(list(branch)) + len(points) + 10
