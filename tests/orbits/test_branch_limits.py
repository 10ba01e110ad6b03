"""Branches that are hard to follow: closed, doubled at both ends, with chains of grazes, to bounds of parameters."""

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.branch import continuation
from grazing.orbits.free_equations import FreeEquations


@pytest.mark.parametrize("N", [2, 3, 4])
@pytest.mark.parametrize("V", [0.25, 0.4])
def test_a_closed_branch_ends_where_it_began_although_times_have_moved_by_periods(N, V):
    model = gz.pinball(V=V, d=0.1)
    orbit = gz.one_impact_orbits(model, N)[0]
    branch = continuation(orbit.map, orbit, "d", (-2.0, 2.0))
    assert branch.pieces[0].ends == ("closed", "closed") and len(branch.pieces[0].orbits) < 300
    values = [(one.type, one.value) for one in branch.special]
    for i, (type, value) in enumerate(values):
        assert not any(type == other and abs(value - at) < 1e-12 for other, at in values[:i])


def bubble(state, p):
    (x,) = state
    return ((p.top - p.a * p.a) * x * (1.0 - x),)


@pytest.mark.parametrize("top", [3.1, 3.2, 3.4])
def test_a_doubled_branch_ends_at_the_other_period_doubling(top):
    edge = np.sqrt(top - 3.0)
    P = gz.Map(bubble, params={"a": 0.9, "top": top}, coordinates=("x",), box=((-0.5, 1.5),))
    x = 1.0 - 1.0 / (top - 0.81)
    orbit = gz.Orbit(
        map=P, points=np.array([[x]]), word="0", period=1, multipliers=np.array([0.5 + 0j]), admissible=True,
        condition=1.0, residual=0.0,
    )  # fmt: skip
    first, last = [s for s in continuation(P, orbit, "a", (-1.0, 1.0)).special if s.type == "pd"]
    doubled = continuation(P, first, "a", (-1.0, 1.0))
    (piece,) = doubled.pieces
    assert piece.ends == ("pd", "pd") and len(doubled.at(0.1)) == 1
    (end,) = doubled.special
    assert end.type == "pd" and end.value == pytest.approx(edge, abs=1e-9) and end.orbit.period == 1
    assert last.value == pytest.approx(edge, abs=1e-9)


@pytest.mark.parametrize("step", [0.03, 0.004])
def test_an_orbit_with_two_impacts_ends_at_the_period_doubling_of_the_one_with_one(step):
    model = gz.pinball(V=0.0, d=0.07)
    orbit = gz.one_impact_orbits(model, 2)[0]
    branch = continuation(orbit.map, orbit, "d", (0.01, 0.15), step=step, limit=8000)
    edge = float(gz.windows(model, "d", 1, span=(-0.1, 0.16)).high[0])
    assert any(s.type == "pd" and abs(s.value - edge) < 1e-10 for s in branch.special if s.admissible)
    assert not any(s.type == "lp" and abs(s.value - edge) < 1e-6 for s in branch.special)


def test_grazes_that_accumulate_end_the_search():
    model = gz.pinball(V=0.0, r=0.3, d=-0.07)
    orbit = next(o for o in gz.one_impact_orbits(model, 1) if o.clearance > -1.0)
    branch = continuation(orbit.map, orbit, "d", (-0.6, 0.1))
    assert max(getattr(o, "impacts", 0) for o in branch) <= 13
    assert all(s.converged for s in branch.special if s.type == "pd" and s.admissible)


def test_a_branch_reaches_the_bound_of_the_damping_where_there_is_no_stiffness():
    model = gz.pinball(alpha=0.1, k=0.0, d=-0.2, r=0.6, V=0.3, omega=2.4)
    for orbit in gz.one_impact_orbits(model, 2):
        branch = continuation(orbit.map, orbit, "alpha", (0.0, 0.2))
        assert "lost" not in branch.pieces[0].ends
        assert branch.pieces[0].values.min() == 0.0


def test_free_motion_without_damping_or_stiffness():
    still = gz.Oscillator(alpha=0.0, k=1.3, forcing=gz.Forcing(omega=2.1, offset=3.0), reset=gz.newton(r=0.7))
    equations = FreeEquations(still, ("k",), np.array([1.0]))
    start = equations.orbit(equations.start(np.array([1.3])), np.array([1.3]))
    assert start.admissible
    branch = continuation(start.map, start, "k", (0.3, 1.9))
    assert not [s for s in branch.special if s.type == "ns"]
    loose = still.replace(k=0.0)
    assert not np.isfinite(FreeEquations(loose, ("offset",)).start(np.array([0.2]))).all()


def test_a_trigger_that_adds_nothing_changes_nothing():
    reset = gz.triggered(r=0.7, V=0.0, trigger=0.1)
    model = gz.Oscillator(alpha=3.0, k=1.0, forcing=gz.Forcing(omega=2.5, offset=0.1), reset=reset)
    orbit = next(o for o in gz.one_impact_orbits(model, 2) if o.admissible)
    branch = continuation(orbit.map, orbit, "offset", (0.0, 0.15))
    assert "law" not in {s.type for s in branch.special}
    with_trigger = [o for o in branch if o.admissible and o.impacts and min(abs(o.incoming)) < 0.1]
    assert with_trigger


@pytest.mark.parametrize("step", [0.0, -0.1, float("nan"), "a"])
def test_a_step_that_is_none(step):
    orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    with pytest.raises(gz.InputError, match="step"):
        continuation(orbit.map, orbit, "d", (0.1, 0.12), step=step)


def test_a_branch_ends_at_its_limit_of_points_and_says_so():
    model = gz.Oscillator(alpha=0, k=1, forcing=gz.Forcing(omega=2.7, cos=(1,)), sigma=0, reset=gz.newton(0.8))
    [orbit] = [one for one in gz.one_impact_orbits(model, 1) if one.admissible]
    whole = continuation(orbit.map, orbit, "omega", (2.65, 4.0))
    [doubling] = [one for one in whole.special if one.type == "pd" and one.admissible]
    assert whole.complete and "unfinished" not in repr(whole) and "unfinished" not in whole.dataset.attrs
    cut = continuation(orbit.map, doubling, "omega", (1.5, 6.0), points=300)
    assert not cut.complete and "unfinished" in repr(cut) and "limit of points" in cut.dataset.attrs["unfinished"]
    with pytest.raises(gz.InputError, match="points"):
        continuation(orbit.map, orbit, "omega", (2.65, 4.0), points=1)


def test_what_was_found_between_walls_is_kept_when_the_limit_is_reached():
    walls = (gz.wall(-1.0, gz.newton(0.6)), gz.wall(1.0, gz.newton(0.6)))
    rattle = gz.Oscillator(alpha=0.1, k=0, forcing=gz.Forcing(omega=1, cos=(), sin=(0.9,)), walls=walls)
    orbit = next(one for one in gz.periodic_orbits(gz.stroboscopic_map(rattle), word="(BA)", starts=20) if one.stable)
    cut = continuation(orbit.map, orbit, "sin1", (0.2, 2.0), points=60)
    assert not cut.complete and 40 < sum(len(piece.orbits) for piece in cut.pieces) <= 62
    assert cut.special and cut.dataset.sizes["point"] > 40 and "limit" in cut.dataset.attrs["unfinished"]


@pytest.mark.parametrize("L", [1.0, 2.0**-60, 1e7])
@pytest.mark.parametrize(
    ("name", "bounds", "touch"),
    [("sigma", (-0.5, 0.5), 0.2), ("offset", (-0.3, 0.3), 0.0), ("offset", (-0.31, 0.3), 0.0)],
)
def test_a_ball_that_a_constant_force_holds_touches_the_wall_where_it_rests_on_it(name, bounds, touch, L):
    # dips of rounding were taken for its lowest point: grazes that are none, and rests in the wall that were no depth
    model = gz.Oscillator(0.3, 1.0, gz.Forcing(2.4, offset=0.2 * L, cos=()), gz.newton(0.5))
    free = FreeEquations(model, ())
    orbit = free.orbit(free.start(np.empty(0)), np.empty(0))
    branch = continuation(orbit.map, orbit, name, (bounds[0] * L, bounds[1] * L))
    (graze,) = branch.special
    assert graze.type == "gr" and graze.converged and graze.admissible
    assert abs(graze.value / L - touch) < 1e-14
    for below in (0.1 * L, 1e-9 * L):
        inside = FreeEquations(model.replace(sigma=0.2 * L + below), ())
        orbit = inside.orbit(inside.start(np.empty(0)), np.empty(0))
        assert not orbit.admissible and abs(orbit.depth - below) < 1e-15 * L
