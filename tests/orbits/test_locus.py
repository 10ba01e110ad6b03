"""Loci of special points in two parameters: closed forms, published curves, and where they meet."""

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.branch import continuation
from grazing.orbits.locus import edge, locus
from tests.orbits.test_branch import admissible, free_orbit


def test_the_graze_of_the_steady_response_in_two_parameters():
    """Without impacts the graze is F = sqrt((k^2 - omega^2)^2 + (alpha omega)^2) times the distance of the wall."""
    alpha, k, sigma = 0.3, 1.2, -0.7
    model = gz.Oscillator(
        alpha=alpha, k=k, forcing=gz.Forcing(omega=1.7, cos=(0.6,)), sigma=sigma, reset=gz.newton(r=0.8)
    )
    orbit = free_orbit(model)
    (graze,) = admissible(continuation(orbit.map, orbit, "cos1", (0.1, 3.0)), "gr")
    found = locus(graze, ("cos1", "omega"), ((0.01, 10.0), (0.8, 3.0)))
    F, omega = found.values.T
    np.testing.assert_allclose(F, -sigma * np.hypot(k * k - omega**2, alpha * omega), rtol=1e-11)
    assert omega.min() == pytest.approx(0.8) and omega.max() == pytest.approx(3.0)
    turned = locus(graze, ("omega", "cos1"), ((0.8, 3.0), (0.01, 10.0)))
    assert np.sort(turned.values[[0, -1], 0]) == pytest.approx([0.8, 3.0], rel=1e-15)
    omega, F = turned.values.T
    np.testing.assert_allclose(F, -sigma * np.hypot(k * k - omega**2, alpha * omega), rtol=1e-11)


def on_a_side(values, box):
    """Whether a point lies within a box and on one of its sides, to rounding."""
    low, high = np.transpose(box)
    inner = np.minimum(values - low, high - values) / (high - low)
    return abs(inner.min()) < 1e-14


@pytest.mark.parametrize("names", [("omega", "sigma"), ("sigma", "omega")])
def test_a_locus_goes_on_to_the_sides_of_its_box(names):
    model = gz.Oscillator(alpha=0.4, k=2.0, forcing=gz.Forcing(omega=2.5, cos=(0.5,)), sigma=-0.3, reset=gz.newton(0.8))
    (orbit,) = (one for one in gz.one_impact_orbits(model, 1) if one.stable and one.admissible)
    special = [one for one in continuation(orbit.map, orbit, "omega", (1.8, 2.8)).special if one.admissible]
    box = [{"omega": (1.2, 3.4), "sigma": (-0.6, -0.1)}[name] for name in names]
    for one in special:
        found = locus(one, names, tuple(box), step=0.1)
        assert found.ends == ("bounds", "bounds")
        assert on_a_side(found.values[0], box) and on_a_side(found.values[-1], box), one
    assert {one.type for one in special} == {"lp", "pd", "gr"}


@pytest.mark.filterwarnings("error")
def test_a_locus_may_begin_on_a_side_of_its_box_and_meet_others_beyond():
    model = gz.Oscillator(alpha=0.4, k=2.0, forcing=gz.Forcing(omega=2.5, cos=(0.5,)), sigma=-0.3, reset=gz.newton(0.8))
    (orbit,) = (one for one in gz.one_impact_orbits(model, 1) if one.stable and one.admissible)
    for one in continuation(orbit.map, orbit, "omega", (1.8, 2.8)).special:
        if one.admissible:
            box = ((-0.6, -0.3), (1.2, 3.4))
            found = locus(one, ("sigma", "omega"), box)
            assert found.ends == ("bounds", "bounds")
            assert sorted(found.values[[0, -1], 0]) == pytest.approx([-0.6, -0.3], rel=1e-14)


@pytest.mark.parametrize("type", ["gr", "pd", "v0"])
def test_each_point_of_a_locus_is_such_a_point_of_a_branch(type):
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[0]
    special = next(one for one in continuation(orbit.map, orbit, "d", (0.09, 0.13)).special if one.type == type)
    found = locus(special, ("d", "V"), ((0.0, 0.14), (0.1, 0.7)))
    assert found.ends == ("bounds", "bounds")
    for i in (3, len(found.orbits) // 3, -4):
        here = found.orbits[i]
        branch = continuation(here.map, here, "d", (found.values[i, 0] - 0.01, found.values[i, 0] + 0.01))
        near = [one.value for one in branch.special if one.type == type]
        assert min(abs(np.array(near) - found.values[i, 0])) < 1e-10


def test_the_edges_of_windows_move_along_loci():
    model = gz.pinball(V=0.4, r=0.8)
    table = gz.windows(model, "d", 4).isel(window=0)
    orbit = next(o for o in gz.one_impact_orbits(model.replace(d=float(table.low + table.high) / 2), 4) if o.stable)
    branch = continuation(orbit.map, orbit, "d", (0.12, 0.13))
    for type, side in (("gr", "low"), ("pd", "high")):
        found = locus(admissible(branch, type)[0], ("d", "r"), ((0.1, 0.14), (0.5, 1.0)))
        for d, r in found.values[:: len(found.values) // 5]:
            exact = gz.windows(model.replace(r=float(r)), "d", 4, span=(0.1, 0.14))
            edges = exact[side].values[exact[f"{side}_type"].values == type]
            assert np.abs(edges - d).min() < 1e-10


# F at which the 2-periodic orbit with one impact has the multiplier -1 or 1, at a few frequencies: from the data that
# Ghosh and Simpson published with arXiv:2510.16218 (alpha = 0.04, k = 1, r = 0.9, wall at -1; multipliers to 1e-5)
PUBLISHED = {
    "pd": {0.81: 0.3475333988945534, 0.80979: 0.3477866775793365, 0.80089: 0.3600268471434961},
    "lp": {0.799: 0.3628362019762544, 0.799011: 0.3628232155151501, 0.799741: 0.3618288199776485},
}


def resonant(type):
    """The branch of the 2-periodic orbit with one impact, and its special point next to the resonant graze."""
    omega, F = {"pd": (0.81, 0.348), "lp": (0.799, 0.3629)}[type]
    forcing = gz.Forcing(omega=omega, cos=(F,))
    model = gz.Oscillator(alpha=0.04, k=1.0, forcing=forcing, sigma=-1.0, reset=gz.newton(r=0.9))
    wanted = next(iter(PUBLISHED[type].values()))
    special = [
        one
        for orbit in gz.one_impact_orbits(model, 2)
        for one in continuation(orbit.map, orbit, "cos1", (0.3, 0.4)).special
    ]
    return next(one for one in special if one.type == type and abs(one.value - wanted) < 1e-4)


@pytest.mark.parametrize("type", ["pd", "lp"])
def test_published_curves_next_to_a_resonant_graze(type):
    special = resonant(type)
    for value, F in PUBLISHED[type].items():
        start = special.orbit.model.params["omega"]
        if value == start:
            assert special.value == pytest.approx(F, abs=2e-7)
            continue
        found = locus(special, ("cos1", "omega"), ((0.3, 0.4), (min(value, start), max(value, start))), step=0.01)
        end = min((0, -1), key=lambda i: abs(found.values[i, 1] - value))
        assert found.values[end] == pytest.approx((F, value), abs=2e-7)


@pytest.mark.parametrize("type", ["pd", "lp"])
def test_the_curves_of_a_resonant_graze_are_tangent_to_the_curve_of_grazes(type):
    """Simpson and Ghosh, arXiv:2602.22797: both are quadratically tangent to F = sqrt((1 - omega^2)^2 + (b omega)^2).

    The resonance is that of two periods with five half-turns of the damped free ball.
    """
    special = resonant(type)
    found = locus(special, ("cos1", "omega"), ((0.3, 0.4), (0.79, 0.82)), step=0.005)
    F, omega = found.values.T
    damped = np.sqrt(1.0 - 0.02**2)
    star = 4.0 * damped / 5.0
    graze = np.hypot(1.0 - omega**2, 0.04 * omega)
    side = (omega - star) * (special.orbit.model.params["omega"] - star) > 0.0
    away, gap = np.abs(omega - star)[side], np.abs(F - graze)[side]
    order = np.argsort(away)
    away, gap = away[order], gap[order]
    kept = (away > 2e-5) & (away < 2e-3)
    assert kept.sum() >= 4
    slope = np.polyfit(np.log(away[kept]), np.log(gap[kept]), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.1)
    assert any(set(meeting.type.split("+")) & {"v0", "gr"} for meeting in found.meetings)
    near = [m for m in found.meetings if abs(m.values[1] - star) < 1e-6]
    assert len(near) == 1 and near[0].type == "gr+lp+pd"  # one point, listed once, by one name
    assert abs(near[0].values[0] - np.hypot(1.0 - star**2, 0.04 * star)) < 1e-6


@pytest.mark.parametrize(
    "alpha, k, r, N, turns", [(0.04, 1.0, 0.9, 2, 5), (0.1, 1.3, 0.7, 1, 1), (0.02, 0.8, 0.5, 3, 7)]
)
@pytest.mark.parametrize("type", ["lp", "pd"])
def test_the_coefficients_of_the_curves_of_a_resonant_graze(type, alpha, k, r, N, turns):
    """The height of the steady response over the wall on both curves, to leading order in E12 = E12(N T).

    At the resonance E12 = 0 and E11 = E22 = e. With y = 0 and w = -r v at both ends of the flight,
    Y' = v (1 + e r)/(1 - e) and Y = E12 v (1 + r)/(1 - e)^2 at the impact, so that the least height is
    Y - Y'^2/2A = C E12 v - B v^2, A the acceleration at the graze. A multiplier is 1 or -1 where
    (1 + e r)^2 = E12 (1 + r) A/v, and (1 - e r)^2 = -E12 (1 + r) A/v.
    """
    damped = np.sqrt(k * k - 0.25 * alpha * alpha)
    star = 2.0 * N * damped / turns

    def flight(omega):
        L = 2.0 * np.pi * N / omega
        return np.exp(-0.5 * alpha * L) * np.array([np.sin(damped * L) / damped, np.cos(damped * L)])

    def stiffness(omega):
        return np.hypot(k * k - omega**2, alpha * omega)

    e, A, off = flight(star)[1], star**2, -4e-3 if type == "lp" else 4e-3
    C, B = (1.0 + r) / (1.0 - e) ** 2, (1.0 + e * r) ** 2 / (2.0 * A * (1.0 - e) ** 2)
    speed = (1.0 + r) * A / (1.0 + e * r) ** 2 if type == "lp" else -(1.0 + r) * A / (1.0 - e * r) ** 2  # v/E12
    height = C * speed - B * speed**2  # over E12^2
    if flight(star + off)[0] * speed > 0.0:
        off = -off
    omega = star + off
    F = stiffness(omega) * (1.0 - height * flight(omega)[0] ** 2)
    special = []
    for more in (3e-6, 1e-5, 1e-4, 1e-3, -1e-4):
        forcing = gz.Forcing(omega=omega, cos=(F * (1.0 + more),))
        model = gz.Oscillator(alpha=alpha, k=k, forcing=forcing, sigma=-1.0, reset=gz.newton(r=r))
        for orbit in gz.one_impact_orbits(model, N):
            found = continuation(orbit.map, orbit, "cos1", (0.97 * F, 1.03 * F)).special
            special += [one for one in found if one.type == type and abs(one.value - F) < 1e-3 * F]
        if special:
            break
    ends = (0.9 * F, 1.1 * F), (min(omega, star), max(omega, star))
    values = locus(special[0], ("cos1", "omega"), ends, step=0.003).values
    away = np.abs(values[:, 1] - star)
    kept = (away > 2e-5) & (away < 4e-4)
    assert kept.sum() >= 2
    for F, omega in values[kept]:
        ratio = (1.0 - F / stiffness(omega)) / (height * flight(omega)[0] ** 2)
        assert ratio == pytest.approx(1.0, abs=20.0 * abs(omega - star))


def test_loci_of_the_gap_map_are_the_formulas_of_theory():
    lam, l, N = 0.5, 0.1, 3
    mu = 0.5 * (gz.theory.mu_pd(N, lam, l) + gz.theory.mu_bc(N, lam, l))
    G = gz.gap_map(lam=lam, mu=mu, l=l)
    points = np.array(gz.theory.maximal_orbit(N, lam, mu, l)).reshape(-1, 1)
    orbit = gz.Orbit(
        map=G, points=points, word="LLR", period=N, multipliers=np.array([0j]), admissible=True, condition=1.0,
        residual=0.0,
    )  # fmt: skip
    branch = continuation(G, orbit, "mu", (0.0, 0.3))
    (pd,) = [one for one in branch.special if one.type == "pd"]
    bc = next(one for one in branch.special if one.type == "bcb" and one.admissible and one.value > mu)
    for special, formula in ((pd, gz.theory.mu_pd), (bc, gz.theory.mu_bc)):
        for name, low, high in (("l", 0.01, 0.5), ("lam", 0.2, 0.9)):
            found = locus(special, ("mu", name), ((0.0, 2.0), (low, high)), step=0.1)
            for value, other in found.values:
                arguments = {"lam": lam, "l": l, name: float(other)}
                assert value == pytest.approx(formula(N, arguments["lam"], arguments["l"]), abs=1e-12)


def test_a_cusp_of_folds():
    """x -> x + a + b x - x^3 has folds on 27 a^2 = 4 b^3, with a cusp at the origin."""

    def cubic(state, p):
        (x,) = state
        return (x + p.a + p.b * x - x * x * x,)

    P = gz.Map(cubic, params={"a": 0.0, "b": 0.5}, coordinates=("x",), box=((-2.0, 2.0),))
    x = np.sqrt(0.5)
    orbit = gz.Orbit(
        map=P, points=np.array([[x]]), word="0", period=1, multipliers=np.array([1.5 - 3.0 * x * x + 0j]),
        admissible=True, condition=1.0, residual=0.0,
    )  # fmt: skip
    folds = [one for one in continuation(P, orbit, "a", (-0.5, 0.5)).special if one.type == "lp"]
    found = locus(folds[0], ("a", "b"), ((-0.5, 0.5), (-0.2, 0.8)))
    a, b = found.values.T
    np.testing.assert_allclose(27.0 * a**2, 4.0 * b**3, atol=1e-9)
    (cusp,) = found.meetings
    assert cusp.type == "cusp" and cusp.values == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_table_and_a_figure(tmp_path):
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[0]
    special = [one for one in continuation(orbit.map, orbit, "d", (0.09, 0.13)).special if one.type in ("gr", "pd")]
    found = [locus(one, ("d", "V"), ((0.0, 0.14), (0.1, 0.7))) for one in special[:2]]
    gz.save(found[0].dataset, tmp_path / "gr.nc")
    back = gz.load(tmp_path / "gr.nc")
    np.testing.assert_array_equal(back["d"].values, found[0].values[:, 0])
    drawn = gz.plot.locus([back, found[1]])
    assert len(drawn["lines"]) == 4 and "Locus of gr" in repr(found[0])


def test_what_a_wrong_call_is_told():
    model = gz.pinball(d=0.11, V=0.4)
    orbit = gz.one_impact_orbits(model, 3)[0]
    special = continuation(orbit.map, orbit, "d", (0.09, 0.13)).special[0]
    ranges = ((0.0, 0.14), (0.1, 0.7))
    with pytest.raises(gz.InputError, match="cannot be followed"):
        locus(orbit, ("d", "V"), ranges)
    with pytest.raises(gz.InputError, match="two different ones"):
        locus(special, ("d", "d"), ranges)
    with pytest.raises(gz.InputError, match="two names and two pairs"):
        locus(special, "d", 3)
    with pytest.raises(gz.InputError, match="give two names of parameters"):
        locus(special, ("d", np.array([1.0, 2.0])), ranges)
    with pytest.raises(gz.InputError, match="unknown parameter"):
        locus(special, ("d", "W"), ranges)
    with pytest.raises(gz.InputError, match="outside of"):
        locus(special, ("d", "V"), ((0.0, 0.14), (0.5, 0.7)))
    with pytest.raises(gz.InputError, match="no locus can be drawn"):
        gz.plot.locus(special)


def test_meetings_have_one_name_are_drawn_once_and_say_whether_they_are_virtual():
    model = gz.Oscillator(0.1, 1.0, gz.Forcing(0.85, cos=(1.0,)), gz.newton(0.8), -2.0)
    P = gz.stroboscopic_map(model)
    orbit = next(one for one in gz.one_impact_orbits(model, 1) if one.admissible)
    names = ("sigma", "omega")
    branch = gz.continuation(P, orbit, "sigma", (-6.0, -0.5))
    ranges = ((-6.0, -0.5), (0.4, 2.2))
    loci = [locus(one, names, ranges) for one in branch.special if one.type in ("lp", "gr", "pd")]
    met = [one for curve in loci for one in curve.meetings]
    assert all(one.type.split("+") == sorted(one.type.split("+")) and "v0" not in one.type for one in met)
    for curve in loci:
        assert curve.dataset.meeting_admissible.values.tolist() == [int(edge(one.orbit)) for one in curve.meetings]
        assert repr(curve).count("(virtual)") == sum(not edge(one.orbit) for one in curve.meetings)
    drawn = gz.plot.locus(loci)
    places = {(one.type, *np.round(one.values, 5).tolist()) for one in met}
    assert len(drawn["markers"]) == len(places) <= len(met)
    assert sum("(virtual)" in text.get_text() for text in drawn["names"]) == len(
        {(one.type, *np.round(one.values, 5).tolist()) for one in met if not edge(one.orbit)}
    )
    assert repr(branch).count("(virtual)") == sum(not one.admissible for one in branch.special)


def _box(r=0.5, **more):
    shake, still = gz.Forcing(omega=1.0, sin=(1.0,), cos=()), gz.Forcing(omega=1.0, cos=())
    walls = [gz.wall(x, gz.newton(r), motion=shake) for x in (-1.5, 1.5)]
    return gz.stroboscopic_map(gz.Oscillator(**({"alpha": 0.0, "k": 0.0} | more), forcing=still, walls=walls))


@pytest.fixture(scope="module")
def broken():
    P = _box()
    orbit = next(one for one in gz.periodic_orbits(P, word="(BA)", starts=500) if one.stable)
    (point,) = (one for one in gz.continuation(P, orbit, "B.sigma", (0.9, 3.0)).special if one.type == "bp")
    return point


def test_the_locus_of_breaking_symmetry_is_that_of_the_impact_pair(broken):
    # the impact pair knows the length of its box in amplitudes of its motion, and nothing else
    length = (np.pi**2 / 2 - 2) * np.sin(np.pi + np.arctan(-2 * 1.5 / (np.pi * 0.5)))
    slid = locus(broken, ("B.sigma", "A.sigma"), ((0.5, 2.5), (-2.5, -0.5)))
    np.testing.assert_allclose(slid.values[:, 0] - slid.values[:, 1], length, rtol=1e-10)
    assert slid.type == "bp" and np.ptp(slid.values[:, 0]) > 1.5
    faster = locus(broken, ("B.sigma", "omega"), ((0.5, 2.5), (0.7, 1.3)))
    np.testing.assert_allclose(faster.values[:, 0], length - 1.5, rtol=1e-10)
    assert np.ptp(faster.values[:, 1]) == pytest.approx(0.6)


def test_on_the_locus_of_breaking_symmetry_branches_break_there(broken):
    curve = locus(broken, ("B.sigma", "alpha"), ((0.5, 2.5), (0.0, 0.3)))
    assert all(one.symmetric and abs(one.multipliers[0] - 1.0) < 1e-8 for one in curve.orbits)
    at = curve.values[len(curve.values) // 2]
    P = _box(alpha=float(at[1]))
    orbit = next(one for one in gz.periodic_orbits(P, word="(BA)", starts=500) if one.symmetric and one.stable)
    (point,) = (one for one in continuation(P, orbit, "B.sigma", (0.5, 2.5)).special if one.type == "bp")
    assert point.value == pytest.approx(at[0], rel=1e-9)
    drawn = gz.plot.locus(curve)
    assert drawn["lines"]


def test_parameters_that_break_the_symmetry_of_the_model_are_refused(broken):
    with pytest.raises(gz.InputError, match=r"A.r takes the symmetry from the model"):
        locus(broken, ("B.sigma", "A.r"), ((0.5, 2.5), (0.3, 0.7)))


def tent_left(state, p):
    return (p.mu + p.a * state[0],)


def tent_right(state, p):
    return (p.mu + p.b * state[0],)


def normal_left(state, p):
    return p.tL * state[0] + state[1] + p.mu, -p.dL * state[0]


def normal_right(state, p):
    return p.tR * state[0] + state[1] + p.mu, -p.dR * state[0]


def side(state, p):
    return state[0]


TENTS, SLOPES = {"L": tent_left, "R": tent_right}, {"mu": -0.5, "a": 0.4, "b": -1.5}
TENT = gz.Map(pieces=TENTS, border=side, params=SLOPES, box=((-2.0, 2.0),))
#: The border-collision normal form of the plane, Nusse and Yorke 1992, Banerjee and Grebogi 1999: traces, determinants.
NORMAL = gz.Map(
    pieces={"L": normal_left, "R": normal_right}, border=side, coordinates=("x", "y"), box=((-2.0, 2.0),) * 2,
    params={"mu": -0.3, "tL": 0.4, "dL": 0.5, "tR": -1.2, "dR": 0.3},
)  # fmt: skip


def only(P, word, name, bounds, kind):
    """The only special point of a kind on the branch of an orbit."""
    (orbit,) = gz.periodic_orbits(P, word=word)
    (special,) = [one for one in continuation(P, orbit, name, bounds, limit=200).special if one.type == kind]
    return special


@pytest.mark.parametrize(
    ("P", "word", "first", "second", "kind", "law", "met"),
    [
        (TENT, "L", ("mu", -1.0, 1.0), ("a", -2.0, 2.0), "bcb", lambda mu, a: mu,
         {"bcb+pd": (0.0, -1.0), "bcb+lp": (0.0, 1.0)}),
        (TENT, "L", ("a", -1.5, 1.5), ("mu", -1.0, 1.0), "pd", lambda a, mu: a + 1.0, {"bcb+pd": (-1.0, 0.0)}),
        (TENT.replace(mu=1.0, a=0.5), "LR", ("a", -2.0, 2.0), ("b", -4.0, -0.2), "pd", lambda a, b: a * b + 1.0,
         {"bcb+pd": (1.0, -1.0)}),
        (NORMAL, "L", ("mu", -1.0, 1.0), ("tL", -3.0, 3.0), "bcb", lambda mu, tL: mu,
         {"bcb+pd": (0.0, -1.5), "bcb+lp": (0.0, 1.5)}),
        (NORMAL, "L", ("tL", -3.0, 3.0), ("dL", -0.5, 1.5), "pd", lambda tL, dL: 1.0 + tL + dL, {"ns+pd": (-2.0, 1.0)}),
        (NORMAL, "L", ("dL", -1.0, 1.5), ("tL", -2.4, 0.6), "ns", lambda dL, tL: dL - 1.0, {"ns+pd": (1.0, -2.0)}),
        (NORMAL.replace(mu=0.3), "LR", ("tL", 0.1, 3.0), ("tR", -6.0, 3.0), "pd",
         lambda tL, tR: 1.0 + (tL * tR - 0.8) + 0.15, {"bcb+pd": (0.35 / 1.3, -1.3)}),
    ],
    ids=["tent, collision", "tent, flip", "tent, flip of LR", "plane, collision", "plane, flip", "plane, torus",
         "plane, flip of LR"],
)  # fmt: skip
def test_loci_of_piecewise_linear_maps_are_those_of_algebra(P, word, first, second, kind, law, met):
    special = only(P, word, first[0], first[1:], kind)
    found = locus(special, (first[0], second[0]), (first[1:], second[1:]))
    assert len(found.orbits) > 20 and np.abs(law(*found.values.T)).max() < 1e-11
    assert {one.type for one in found.meetings} == set(met)
    for one in found.meetings:
        assert one.values == pytest.approx(met[one.type], abs=1e-9)
    if kind == "ns":  # beyond a trace of -2 a neutral saddle
        for orbit in [one for one in found.orbits if abs(one.map.params["tL"] + 2.0) > 1e-6]:
            assert np.isreal(orbit.multipliers).all() == (orbit.map.params["tL"] < -2.0)


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid")
def test_what_happens_all_along_a_locus_is_no_meeting():
    """Both points of the orbit FH reach the border at rho = 0, whatever r2: 24 signs of rounding were meetings."""

    def free(state, p):
        x, y = state
        return (0.7 * x + y + p.rho, -0.05 * x)

    def hit(state, p, root):
        x, y = state
        return (y + p.rho - root, -0.05 * p.r2 * x)

    params = {"rho": 0.05, "r2": 0.8}
    box = ((-0.5, 0.3), (-0.3, 0.3))
    pieces = {"F": free, "H": hit}
    P = gz.Map(pieces=pieces, border=lambda state, p: state[0], params=params, coordinates=("x", "y"), box=box)
    (orbit,) = gz.periodic_orbits(P, word="FH")
    branch = gz.continuation(P, orbit, "rho", (-0.1, 0.2))
    reached = [one for one in branch.special if one.type == "bcb"]
    assert reached
    for special in reached:
        curve = gz.locus(special, ("rho", "r2"), ((-0.1, 0.2), (0.2, 1.0)))
        assert len(curve.values) > 10 and not curve.meetings
