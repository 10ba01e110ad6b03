"""Branches: closed forms, methods against each other, laws, and what a wrong call is told."""

from dataclasses import replace

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.branch import Branch, continuation
from grazing.orbits.free_equations import FreeEquations
from grazing.orbits.special import SPECIAL

NOTHING = np.empty(0)


def free_orbit(model):
    equations = FreeEquations(model, ())
    return equations.orbit(equations.start(NOTHING), NOTHING)


def admissible(branch, type):
    return [one for one in branch.special if one.type == type and one.admissible]


@pytest.mark.parametrize("N", range(2, 8))
def test_windows_of_the_standard_model_by_continuation(N):
    model = gz.pinball(V=0.4)
    table = gz.windows(model, "d", N).isel(window=0)
    low, high = float(table.low), float(table.high)
    middle = 0.5 * (low + high)
    orbit = next(o for o in gz.one_impact_orbits(model.replace(d=middle), N) if o.stable and o.admissible)
    branch = continuation(orbit.map, orbit, "d", (low - 0.01, high + 0.01))
    graze, double = admissible(branch, "gr")[0], admissible(branch, "pd")[0]
    assert graze.value == pytest.approx(low, abs=1e-10) and graze.converged
    assert double.value == pytest.approx(high, abs=1e-10) and double.converged
    assert graze.low <= graze.value <= graze.high and graze.high - graze.low < 1e-12
    assert abs(double.orbit.multipliers[0] + 1.0) < 1e-9


# model, N, parameter, half of the range around the model's value
OTHERS = {
    "under-damped": (gz.pinball(alpha=0.2, k=1.0, omega=2.8, d=0.3, V=0.1, r=0.9), 2, "d", 0.25),
    "no stiffness": (gz.pinball(alpha=0.2, k=0.0, omega=1.1, d=-0.3, r=0.6, V=0.3), 2, "omega", 0.5),
    "shifted wall": (gz.pinball(sigma=-0.05, t0=0.7, d=0.02, V=0.4), 2, "sigma", 0.08),
    "passive": (gz.pinball(V=0.0, d=0.1), 2, "r", 0.6),
    "passive in d": (gz.pinball(V=0.0, d=0.1), 2, "d", 0.05),
    "two harmonics": (
        gz.Oscillator(
            alpha=0.5, k=1.3, sigma=-0.3, reset=gz.active(r=0.7, V=0.2),
            forcing=gz.Forcing(omega=1.1, t0=0.4, offset=0.2, cos=(1.0, 0.3), sin=(0.1, 0.25)),
        ), 1, "cos2", 0.8,
    ),
    "trigger": (
        gz.Oscillator(
            alpha=1.0, k=2.0, forcing=gz.Forcing(omega=2.5, offset=-0.1), reset=gz.triggered(r=0.6, V=0.5, trigger=0.1)
        ), 1, "offset", 0.6,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", OTHERS)
def test_edges_of_windows_are_special_points(case):
    """Every edge of a window that the closed forms find lies on the branch that passes through the window."""
    model, N, name, half = OTHERS[case]
    value = model.params[name]
    span = max(value - half, 0.0 if name in ("V", "r") else -np.inf), min(value + half, 1.0 if name == "r" else np.inf)
    table = gz.windows(model, name, N, span=span)
    assert table.sizes["window"] > 0
    checked = 0
    for i in range(table.sizes["window"]):
        row = table.isel(window=i)
        middle = 0.5 * (float(row.low) + float(row.high))
        orbits = [o for o in gz.one_impact_orbits(model.replace(**{name: middle}), N) if o.stable and o.admissible]
        special = [s for o in orbits for s in continuation(o.map, o, name, span).special if s.admissible]
        for side in ("low", "high"):
            type, edge = str(row[f"{side}_type"].values), float(row[side])
            if type == "end":
                continue
            wanted = {"gr", "v0"} if type in ("gr", "v0") else {type}
            near = [s for s in special if s.type in wanted and abs(s.value - edge) <= 1e-10 * (1.0 + abs(edge))]
            assert near, (type, edge, special)
            checked += 1
    assert checked > 0


def test_a_branch_passes_grazes_where_the_wall_is_passive():
    """The orbit without impacts, beyond its graze the one with an impact, period doublings and the next graze."""
    model = gz.pinball(d=0.14, V=0.0)
    start = free_orbit(model)
    branch = continuation(start.map, start, "d", (0.02, 0.16))
    graze = gz.normal_form(model, "d").graze
    (first,) = admissible(branch, "gr")
    assert first.value == pytest.approx(graze, abs=1e-14)
    assert [piece.equations.n for piece in branch.pieces] == [0, 1] and first.to == 1
    (pd,) = admissible(branch, "pd")
    doubled = continuation(start.map, pd, "d", (0.02, 0.16))
    values = [s.value for s in admissible(doubled, "gr")]
    assert len(values) == 2 and values[1] == pytest.approx(graze, abs=1e-12)
    assert "01" in {orbit.word for orbit in doubled if orbit.admissible and orbit.stable}
    for orbit in doubled:
        if orbit.admissible and orbit.stable and min(abs(orbit.incoming), default=0.0) > 1e-4:
            follows = orbit.map.iterate(orbit.points[0], orbit.period)[1:]
            np.testing.assert_allclose(follows, np.roll(orbit.points, -1, axis=0), atol=1e-12)


def test_every_orbit_of_a_branch_is_one_of_the_map_or_says_that_it_is_not():
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[0]
    branch = continuation(orbit.map, orbit, "d", (0.08, 0.125))
    both = {True: 0, False: 0}
    for one, event in zip(branch, branch.dataset["event"].values, strict=True):
        if event:
            continue
        after = one.map.iterate(np.maximum(one.points[0], [one.model.sigma, -np.inf]), one.period)[-1]
        back = np.abs(after - one.points[0]).max()
        assert (back < 1e-11 * max(1.0, abs(one.multipliers[0]))) == one.admissible
        assert one.residual < 1e-13
        both[one.admissible] += 1
    assert min(both.values()) > 3


def test_the_period_doubling_of_the_standard_model_is_subcritical():
    model = gz.pinball(V=0.4, d=0.05)
    for N in (2, 3, 4):
        table = gz.windows(model, "d", N).isel(window=0)
        value = 0.5 * (float(table.low) + float(table.high))
        orbit = next(o for o in gz.one_impact_orbits(model.replace(d=value), N) if o.stable and o.admissible)
        bounds = (0.0, 0.14)
        (pd,) = admissible(continuation(orbit.map, orbit, "d", bounds), "pd")
        doubled = continuation(orbit.map, pd, "d", bounds)
        piece = doubled.pieces[0]
        seen = [o for i, o in enumerate(piece.orbits) if o.admissible and i > 0 and i not in piece.events]
        assert len(seen) > 2 and not any(o.stable for o in seen)
        assert max(o.map.params["d"] for o in seen) <= pd.value
        assert all(o.period == 2 * N and abs(o.multipliers[0]) > 1.0 for o in seen)
        for o in seen[2:4]:  # confirmed by the exact map and its own derivative
            J = np.eye(2)
            for point in o.points:
                J = o.map.jacobian(point) @ J
            assert np.abs(np.linalg.eigvals(J)).max() == pytest.approx(abs(o.multipliers[0]), rel=1e-7)


def test_branches_of_the_gap_map_agree_with_theory():
    compared = 0
    for lam, l, periods in ((0.34, 0.21, (2,)), (0.5, 0.1, (3,)), (0.8, 0.4, (2, 4))):
        for N in periods:
            pd, bc = gz.theory.mu_pd(N, lam, l), gz.theory.mu_bc(N, lam, l)
            if not pd < bc:
                continue
            mu = 0.5 * (pd + bc)
            G = gz.gap_map(lam=lam, mu=mu, l=l)
            points = np.array(gz.theory.maximal_orbit(N, lam, mu, l))
            J = float(gz.theory.multiplier(N, lam, mu, l))
            orbit = gz.Orbit(
                map=G, points=points.reshape(-1, 1), word="L" * (N - 1) + "R", period=N,
                multipliers=np.array([J + 0j]), admissible=True, condition=1.0, residual=0.0,
            )  # fmt: skip
            branch = continuation(G, orbit, "mu", (pd - 0.1, bc + 0.1), step=0.1)
            types = {s.type: s.value for s in branch.special if s.admissible}
            assert types["pd"] == pytest.approx(pd, abs=1e-13)
            assert any(s.type == "bcb" and s.value == pytest.approx(bc, abs=1e-13) for s in branch.special)
            (switch,) = [s for s in branch.special if s.type == "pd" and s.admissible]
            doubled = continuation(G, switch, "mu", (pd - 0.1, bc + 0.1), step=0.1)
            for o in doubled:
                here = o.map.params["mu"]
                away = np.abs(o.points).min() > 1e-6  # from the border, where multipliers are infinite
                if o.admissible and here - pd > 1e-4 and away:
                    known = gz.theory.doubled_multiplier(N, lam, here, l)
                    assert o.multipliers[0].real == pytest.approx(known, rel=1e-6)
                    compared += 1
    assert compared > 10


def test_a_smooth_map_of_ones_own():
    """The Hénon map: fold and period doubling of its fixed points in closed form, Neimark-Sacker at b = -1."""

    def henon(state, p):
        x, y = state
        return (1.0 - p.a * x * x + y, p.b * x)

    P = gz.Map(henon, params={"a": 0.2, "b": 0.3}, coordinates=("x", "y"), box=((-2.0, 2.0), (-1.0, 1.0)))
    a, b = 0.2, 0.3
    x = (b - 1.0 + np.sqrt((1.0 - b) ** 2 + 4.0 * a)) / (2.0 * a)
    J = np.array([[-2.0 * a * x, 1.0], [b, 0.0]])
    orbit = gz.Orbit(
        map=P, points=np.array([[x, b * x]]), word="0", period=1, multipliers=np.linalg.eigvals(J) + 0j,
        admissible=True, condition=1.0, residual=0.0,
    )  # fmt: skip
    branch = continuation(P, orbit, "a", (-0.3, 1.2), limit=200)  # beyond the fold it goes to infinity
    found = {one.type: one.value for one in branch.special}
    assert found["lp"] == pytest.approx(-((1.0 - b) ** 2) / 4.0, abs=1e-9)
    assert found["pd"] == pytest.approx(3.0 * (1.0 - b) ** 2 / 4.0, abs=1e-9)
    (pd,) = [one for one in branch.special if one.type == "pd"]
    doubled = continuation(P, pd, "a", (-0.3, 1.2), limit=200)
    assert any(o.stable and o.period == 2 for o in doubled)
    (second,) = [one for one in doubled.special if one.type == "pd"]
    assert second.value == pytest.approx(((1.0 - b) ** 2 * 4.0 + (1.0 + b) ** 2) / 4.0, abs=1e-9)


def odd(state, p):
    x, y = state
    return p.a * x - x**3 + 0.1 * y, 0.3 * y + 0.2 * np.sin(x)


@pytest.mark.parametrize("bounds", [(0.1, 1.31), (0.18, 1.25), (0.26, 1.4)])
def test_a_branch_point_where_the_equations_are_singular_but_for_rounding(bounds):
    """Newton's method took steps of 1e120 there, and nothing was found."""
    P = gz.Map(odd, {"a": 0.5}, ("x", "y"), ((-1.0, 1.0),) * 2)
    (orbit,) = gz.periodic_orbits(P, 1, starts=20)
    (one,) = gz.continuation(P, orbit, "a", bounds).special
    assert one.type == "bp" and one.converged and one.value == pytest.approx(1.0 - 0.02 / 0.7, abs=1e-14)


def test_a_pitchfork_is_a_branch_point():
    def cubic(state, p):
        (x,) = state
        return (p.a * x - x * x * x,)

    P = gz.Map(cubic, params={"a": 0.5}, coordinates=("x",), box=((-2.0, 2.0),))
    orbit = gz.Orbit(
        map=P, points=np.zeros((1, 1)), word="0", period=1, multipliers=np.array([0.5 + 0j]), admissible=True,
        condition=2.0, residual=0.0,
    )  # fmt: skip
    branch = continuation(P, orbit, "a", (0.2, 1.7))
    (bp,) = [one for one in branch.special if one.type == "bp"]
    assert bp.value == pytest.approx(1.0, abs=1e-8)
    other = continuation(P, bp, "a", (0.2, 1.7))
    assert len(other.pieces) == 2
    for piece in other.pieces:
        np.testing.assert_allclose(piece.unknowns[:, 0] ** 2, piece.values - 1.0, atol=1e-8)


def test_orbits_at_a_value_and_the_relabelling_of_words():
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[0]
    branch = continuation(orbit.map, orbit, "t0", (0.0, 3.0))
    assert not branch.special and not branch.relabellings  # a shift of time changes nothing, 010 is 001
    for value in (0.4, 1.7):
        (found,) = branch.at(value)
        assert found.multipliers == pytest.approx(orbit.multipliers, abs=1e-10)
        assert np.mod(found.times[0] + value - orbit.times[0], model.period) == pytest.approx(0.0, abs=1e-9) or np.mod(
            found.times[0] + value - orbit.times[0], model.period
        ) == pytest.approx(model.period, abs=1e-9)
    assert branch.at(5.0) == ()


def test_an_impact_that_crosses_the_strobe_relabels_the_word():
    model = gz.pinball(d=0.1025, V=0.4)
    (orbit,) = [o for o in gz.one_impact_orbits(model, 2) if o.stable]
    (pd,) = admissible(continuation(orbit.map, orbit, "d", (0.09, 0.11)), "pd")
    doubled = continuation(orbit.map, pd, "d", (0.09, 0.11))
    (two,) = doubled.at(0.1025)
    assert two.impacts == 2 and not two.stable
    branch = continuation(two.map, two, "t0", (0.0, 3.0))
    assert not branch.special and len(branch.relabellings) >= 2
    for one in branch.relabellings:
        assert one.before != one.after
        (there,) = branch.at(one.value)
        strobe = np.mod(there.times / model.period + 0.5, 1.0) - 0.5
        assert np.abs(strobe).min() < 1e-9


def test_a_branch_as_a_table(tmp_path):
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[0]
    branch = gz.continuation(orbit.map, orbit, "d", (0.09, 0.13))
    assert isinstance(branch, Branch) and "001" in repr(branch) and "pd" in repr(branch)
    table = branch.dataset
    assert table.sizes["point"] == len(list(branch)) and table.sizes["special"] == len(branch.special)
    assert set(table["special_type"].values) <= set(SPECIAL)
    gz.save(table, tmp_path / "branch.nc")
    back = gz.load(tmp_path / "branch.nc")
    np.testing.assert_array_equal(back["u"].values, table["u"].values)
    assert back["word"].values.tolist() == table["word"].values.tolist()


def test_what_a_wrong_call_is_told():
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[0]
    P = orbit.map
    with pytest.raises(gz.InputError, match="give a map"):
        continuation(model, orbit, "d", (0.0, 0.2))
    with pytest.raises(gz.InputError, match="unknown parameter 'e'"):
        continuation(P, orbit, "e", (0.0, 0.2))
    with pytest.raises(gz.InputError, match=r"the pair \(low, high\)"):
        continuation(P, orbit, "d", 0.3)
    with pytest.raises(gz.InputError, match="the lower end must come first"):
        continuation(P, orbit, "d", (0.2, 0.1))
    with pytest.raises(gz.InputError, match="0 <= r <= 1"):
        continuation(P, orbit, "r", (0.5, 1.5))
    with pytest.raises(gz.InputError, match="outside of"):
        continuation(P, orbit, "d", (0.2, 0.3))
    with pytest.raises(gz.InputError, match="give its own map"):
        continuation(P.replace(r=0.7), orbit, "d", (0.0, 0.2))
    with pytest.raises(gz.InputError, match="give an Orbit"):
        continuation(P, (0.1, 0.2), "d", (0.0, 0.2))
    with pytest.raises(gz.InputError, match="limit"):
        continuation(P, orbit, "d", (0.0, 0.2), limit=1)
    branch = continuation(P, orbit, "d", (0.09, 0.13))
    graze = admissible(branch, "gr")[0]
    with pytest.raises(gz.InputError, match="another branch begins at pd and bp only"):
        continuation(P, graze, "d", (0.09, 0.13))
    wrong = gz.Orbit(
        map=P, points=orbit.points + 0.05, word="001", period=3, multipliers=orbit.multipliers, admissible=True,
        condition=1.0, residual=0.0,
    )  # fmt: skip
    with pytest.raises(gz.InputError, match="does not close"):
        continuation(P, wrong, "d", (0.0, 0.2))


def test_a_doubled_branch_ends_at_the_other_doubling():
    def bump(state, p):
        (x,) = state
        return ((3.2 - p.a * p.a) * x * (1.0 - x),)

    P = gz.Map(bump, params={"a": 0.0}, coordinates=("x",), box=((0.01, 0.99),))
    x = 1.0 - 1.0 / 2.8
    at = P.replace(a=np.sqrt(0.4))
    orbit = gz.Orbit(
        map=at, points=np.array([[x]]), word="0", period=1, multipliers=np.array([-0.8 + 0j]), admissible=True,
        condition=1.0, residual=0.0,
    )  # fmt: skip
    pds = [one for one in continuation(at, orbit, "a", (-1.0, 1.0)).special if one.type == "pd"]
    assert [one.value for one in pds] == pytest.approx([-np.sqrt(0.2), np.sqrt(0.2)], abs=1e-9)
    doubled = continuation(P, pds[0], "a", (-1.0, 1.0))
    assert doubled.pieces[0].ends == ("pd", "pd")
    (end,) = doubled.special
    assert end.type == "pd" and end.value == pytest.approx(np.sqrt(0.2), abs=1e-9) and end.orbit.period == 1
    result = gz.bifurcation_diagram(P, "a", np.linspace(-0.9, 0.9, 37), starts=5, transient=3000)
    lows = result.window_low.values[result.window_period.values == 2]
    highs = result.window_high.values[result.window_period.values == 2]
    assert lows == pytest.approx([-np.sqrt(0.2)], abs=1e-9) and highs == pytest.approx([np.sqrt(0.2)], abs=1e-9)


def test_a_force_of_the_second_harmonic_has_the_branch_of_the_first_at_twice_the_frequency():
    """An orbit of 3 periods of cos 2wt is one of 3/2 T twice: what doubles it takes both halves apart, a *bp* here."""
    reset = gz.pinball(V=0.4).reset
    first, second = (
        gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, gz.Forcing(omega=omega, offset=0.12, cos=cos), reset))
        for omega, cos in ((2.2, (1.0,)), (1.1, (0.0, 1.0)))
    )
    points = []
    for P in (first, second):
        (orbit,) = gz.periodic_orbits(P, 3)
        branch = continuation(P, orbit, "offset", (-0.3, 0.3))
        assert {orbit.period for orbit in branch} == {3}
        points.append([(one.type, one.value) for one in branch.special])
    halves = sorted((type.replace("pd", "bp"), value) for type, value in points[0])
    twice = sorted(set((type, round(value, 9)) for type, value in points[1]))
    assert [type for type, _value in twice] == [type for type, _value in halves]
    assert [value for _type, value in twice] == pytest.approx([value for _type, value in halves], abs=1e-9)


def test_what_breaks_off_where_the_force_repeats_itself_is_what_doubles_at_twice_the_frequency():
    reset, ends = gz.pinball(V=0.4).reset, []
    for omega, cos, type in ((2.2, (1.0,), "pd"), (1.1, (0.0, 1.0), "bp")):
        P = gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, gz.Forcing(omega=omega, offset=0.12, cos=cos), reset))
        (orbit,) = gz.periodic_orbits(P, 3)
        at = next(one for one in continuation(P, orbit, "offset", (0.1, 0.15)).special if one.type == type)
        broken = continuation(P, at, "offset", (0.1, 0.15))
        assert {orbit.period for orbit in broken} == {6 if type == "pd" else 3}
        ends.append(sorted({(one.type, round(one.value, 10)) for one in broken.special}))
    assert len(ends[0]) == 3 and ends[0] == ends[1]


def test_grazes_do_not_go_on_without_end_into_chatter():
    model = gz.pinball(V=0.0, r=0.3, d=0.1)
    orbit = next(o for o in gz.one_impact_orbits(model, 1) if o.admissible)
    branch = continuation(orbit.map, orbit, "d", (-0.2, 0.2))
    assert max(o.impacts for o in branch) <= 13
    assert all(np.isfinite(one.orbit.multipliers).all() for one in branch.special if one.type in ("pd", "ns"))


def test_a_parameter_followed_to_its_bound_and_a_ball_that_drifts():
    model = gz.pinball(alpha=0.1, k=0.0, d=-0.3, r=0.6, V=0.3, omega=2.0)
    orbit = next(o for o in gz.one_impact_orbits(model, 1) if o.admissible)
    branch = continuation(orbit.map, orbit, "alpha", (0.0, 0.17), step=0.1)
    assert min(o.map.params["alpha"] for o in branch) == 0.0
    passive = gz.pinball(alpha=0.2, k=0.0, d=-0.1, r=0.5, V=0.0)
    for orbit in gz.one_impact_orbits(passive, 1):
        assert continuation(orbit.map, orbit, "d", (-0.9, -0.05), step=0.1).pieces


def test_a_branch_begins_at_a_fold_too():
    model = gz.pinball(d=0.1, V=0.4)
    orbit = gz.one_impact_orbits(model, 2)[0]
    folds = [one for one in continuation(orbit.map, orbit, "d", (-1.0, 1.0)).special if one.type == "lp"]
    assert folds
    for fold in folds:
        assert len(list(continuation(fold.orbit.map, fold.orbit, "d", (-1.0, 1.0)))) > 10


def test_a_range_too_narrow_for_double_precision():
    orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    with pytest.raises(gz.InputError, match="double precision"):
        continuation(orbit.map, orbit, "d", (0.11, np.nextafter(0.11, 1.0)))


def test_the_table_of_a_branch_has_every_impact():
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[-1]
    branch = continuation(orbit.map, orbit, "omega", (2.0, 2.4))
    table = branch.dataset
    orbits = list(branch)
    at = table.impact_point.values
    assert np.array_equal(np.bincount(at, minlength=len(orbits)), table.impacts.values) and table.sizes["impact"] > 20
    for i, orbit in enumerate(orbits):
        np.testing.assert_array_equal(table.v_minus.values[at == i], orbit.incoming)
        np.testing.assert_array_equal(table.v_plus.values[at == i], orbit.outgoing)
        # flown from the row's own first point, the ball meets the wall at these times
        state = float(table.u[i, 0]), float(table.v[i, 0])
        T = orbit.model.period
        if orbit.admissible and orbit.clearance > 1e-6:
            path = gz.trajectory(orbit.model, state, until=3.0 * T, samples=2)
            times = np.mod(table.impact_time.values[at == i], 3.0 * T)
            np.testing.assert_allclose(path.impact_time.values, np.sort(times), atol=1e-9)
    for k in range(len(branch.pieces)):
        mine = (table.piece.values[at] == k).nonzero()[0]
        assert np.abs(np.diff(table.impact_time.values[mine])).max(initial=0.0) < 0.3 * model.period


def test_a_branch_of_the_impact_map_has_the_points_of_the_strobe():
    P = gz.impact_map(gz.pinball(d=0.12, V=0.4))
    [orbit] = gz.periodic_orbits(P, 1, starts=200)
    branch = continuation(P, orbit, "d", (0.11, 0.13))
    table = branch.dataset
    np.testing.assert_array_equal(table.u.values[5], list(branch)[5].points[:, 0])
    assert table.v_plus.dims == ("impact",) and "tau" not in table
    gz.plot.branch(table, coordinate="v")


def test_loops_in_the_frequency_are_followed_once():
    """Where the frequency varies the period does: two solutions are compared in the period that they have.

    The rig of the docs (0.8 kg, 2.4 N s/m, 3200 N/m, 2.5 N, a stop at 1.2 mm), whose orbits of one impact are a loop
    that closes, with grazes where the closed form of the response without impacts reaches the stop.
    """
    m, c, k, F, gap = 0.8, 2.4, 3200.0, 2.5, 1.2e-3
    low, high = 2.0 * np.pi * 4.0, 2.0 * np.pi * 20.0
    law, forcing = gz.newton(0.7), gz.Forcing(omega=high, cos=(-F / m,))
    model = gz.Oscillator(alpha=c / m, k=np.sqrt(k / m), forcing=forcing, sigma=-gap, reset=law)
    orbit = free_orbit(model)
    branch = continuation(orbit.map, orbit, "omega", (low, high))
    assert len(branch.pieces) == 3 and [max(o.impacts for o in piece.orbits) for piece in branch.pieces] == [0, 1, 2]
    # |k - m w^2 + i c w| = F/gap, a quadratic in w^2
    half = k / m - 0.5 * (c / m) ** 2
    edges = np.sqrt(half + np.array([-1.0, 1.0]) * np.sqrt(half**2 - (k / m) ** 2 + (F / m / gap) ** 2))
    grazes = sorted(one.value for one in admissible(branch, "gr") if one.orbit.impacts == 0)
    np.testing.assert_allclose(grazes, edges, rtol=1e-13)
    assert not any(one.type == "v0" for one in branch.special)  # nothing kicks: an impact of no speed is a graze
    doubles = [one for one in branch.special if one.type == "pd" and one.admissible]
    assert doubles and all(abs(one.orbit.multipliers[0] + 1.0) < 1e-9 for one in doubles)
    # what begins at a period doubling far from the frequency at which the branch was begun goes round twice there
    other = continuation(branch.map, doubles[0], "omega", (low, high), limit=40)
    begun = other.pieces[0].orbits[0]
    np.testing.assert_allclose(begun.times[2:] - begun.times[:2], begun.model.period, rtol=1e-9)


@pytest.mark.parametrize(("a", "b"), [(0, 20), (-20, 0)])
def test_what_is_admissible_is_so_in_any_unit(a, b):
    """Heights and speeds were 0 below a part of the period: where time is long, virtual points were admissible."""

    def followed(L, T):
        push = gz.Forcing(2.3 / T, offset=-0.20936675818337086 * L / T**2, cos=(L / T**2,))
        P = gz.stroboscopic_map(gz.Oscillator(0.0, 2.3 / T, push, gz.active(0.8, 0.4 * L / T), -0.3 * L))
        (orbit, *_) = gz.periodic_orbits(P, word="1", starts=400)
        branch = gz.continuation(P, orbit, "omega", (0.8 / T, 3.0 / T))
        return [(one.type, round(one.value * T, 6), one.admissible) for one in branch.special]

    plain = followed(1.0, 1.0)
    assert {admissible for _type, _value, admissible in plain} == {True, False}
    assert followed(2.0**a, 2.0**b) == plain


def test_where_two_pieces_meet_the_table_has_one_row():
    """Each piece has its own end there, and both are in ``branch.special``: the table listed every graze twice."""
    rig = {"m": 0.8, "c": 2.4, "k": 3200.0, "force": 2.5, "gap": 1.2e-3, "frequency": 14.0, "reset": gz.newton(0.7)}
    P = gz.stroboscopic_map(gz.Oscillator.from_si(**rig))
    stable = next(one for one in gz.periodic_orbits(P, 1, starts=50) if one.stable)
    branch = gz.continuation(P, stable, "omega", (30.0, 120.0))
    table = branch.dataset
    rows = list(zip(table.special_type.values, table.special_piece.values, table.special_to.values, strict=True))
    values = table.special_value.values
    both = [one for one in branch.special if one.to >= 0 and one.to != one.piece]
    assert len(both) > 1 and len(rows) < len(branch.special)
    assert {(one.type, round(one.value, 9)) for one in branch.special} == {
        (kind, round(value, 9)) for (kind, *_ends), value in zip(rows, values, strict=True)
    }
    for i, (kind, piece, to) in enumerate(rows):
        mirrored = [j for j in range(i) if rows[j] == (kind, to, piece) and abs(values[j] - values[i]) < 1e-9]
        assert not mirrored


def spun(state, p):
    """A rotation in a plane that is stretched by a and d, beside a coordinate that goes its own way."""
    x, y, z = state
    c, s = np.cos(p.t), np.sin(p.t)
    return p.a * (c * x - s * y), p.d * (s * x + c * y), p.b * z


@pytest.mark.parametrize(("a", "d", "t", "b"), [(1.0, 1.0, 1.0, -1.6), (1.0, 1.0, 1.0, 0.25), (0.8, 1.25, 0.0, 0.1)])
def test_a_saddle_turns_too_and_real_multipliers_do_not(a, d, t, b):
    """Of three multipliers the greatest was looked at: a torus beside a real one outside the circle was dropped."""
    params = {"a": 0.95 * a, "d": d, "t": t, "b": b}
    P = gz.Map(spun, params, ("x", "y", "z"), ((-1.0, 1.0),) * 3)
    (orbit,) = gz.periodic_orbits(P, 1, starts=20)
    found = [(one.type, one.converged, one.value) for one in gz.continuation(P, orbit, "a", (0.9 * a, 1.1 * a)).special]
    assert found == ([("ns", True, pytest.approx(a, abs=1e-9))] if t else [])


def test_a_branch_has_nothing_far_away():
    """The products of differences were too large for a double there, and too small where a range is very narrow."""
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[0]
    branch = continuation(orbit.map, orbit, "d", (0.105, 0.115))
    assert branch.at(1.7e154) == branch.at(-1e308) == ()
    piece = replace(branch.pieces[0], values=np.array([1.0, 2.0, 3.0]) * 1e-170)
    assert piece.passing(2.5e-170) == [1] and piece.passing(2e-170) == [0, 1] and piece.passing(4e-170) == []
