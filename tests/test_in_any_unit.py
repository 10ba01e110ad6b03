"""Studies of one oscillator in units that are powers of two: what has no unit is the same to the last bit."""

import numpy as np
import pytest

import grazing as gz
from grazing.studies.cobweb import places_of


def measured(L, T):
    """What studies say of a chaotic ball whose unit of length is L and of time T, without units."""
    S, F = L / T, L / T**2
    push = gz.Forcing(2.8 / T, offset=0.1 * F, cos=(F,))
    P = gz.stroboscopic_map(gz.Oscillator(0.3 / T, 1.0 / T, push, gz.newton(0.95)))
    forces, same = np.array([0.1, 0.16, 0.3]) * F, {"transient": 60, "arithmetic": "strict"}
    starts = np.array([[0.1, 0.2], [0.5, -0.3], [0.02, 0.0]]) * (L, S)
    exponents = gz.lyapunov(P, "offset", forces, starts=starts, steps=60, **same)
    chart = gz.chart(P, {"offset": forces, "r": [0.9, 0.95]}, starts=starts, exponent_steps=60, **same)
    found = gz.coexistence(P, "offset", forces, starts=starts, **same)
    count = gz.density(P, "offset", forces, starts=starts, bins=40, keep=40, **same)["count"]
    curve = gz.grazing_curve(P.model, preimages=1, points=200)
    return [
        exponents.exponent.values, exponents.exponent_per_time.values * T, chart.exponent.values, chart.period.values,
        found.lifetime.values, found.share.values, count.values, curve.graze.values / (L, S), curve.order.values,
    ]  # fmt: skip


@pytest.fixture(scope="module")
def plain():
    return measured(1.0, 1.0)


@pytest.mark.parametrize(("a", "b"), [(20, 0), (0, 20), (0, -20), (17, -13), (-19, 20)])
def test_studies_in_units_of_powers_of_two(a, b, plain):
    for one, other in zip(plain, measured(2.0**a, 2.0**b), strict=True):
        assert one.shape == other.shape and np.allclose(one, other, rtol=1e-9, atol=1e-9, equal_nan=True)


def test_windows():
    """Below 1e-14 units of force all edges were taken for one, and no window was found."""
    found = []
    for L, T in [(1.0, 1.0), (2.0**-50, 1.0), (2.0**-140, 1.0), (2.0**40, 2.0**45)]:
        numbers = (3.0, 1.0, 2.2, 0.12, 0.0, 0.8, 0.4, None)
        table = gz.windows(pushed(numbers, L, T), "offset", N=3)
        found.append([table[edge].values * T**2 / L for edge in ("low", "high")])
    assert found[0][0].shape == (1,) and np.allclose(found, found[0], rtol=1e-12, atol=0.0)


def test_rungs_of_the_ladder_and_cobwebs():
    """Steps of a parameter were at least 1e-12 long, and the graph of a cobweb reached down to -1e-12."""
    found = []
    for T in (1.0, 2.0**60):
        model = pushed((3.0, 1.0, 2.2, 0.12, 0.0, 0.8, 0.4, None), 1.0, T)
        found.append(gz.ladder(model, "omega", N=3, rungs=("lowest",)).error.values * T)
    assert np.all(found[0][0] != 0.0) and np.allclose(found[0], found[1], rtol=1e-9, atol=0.0)
    graph = places_of(np.array([-1.0, 0.5]) * 2.0**-100)
    assert np.array_equal(graph, places_of(np.array([-1.0, 0.5])) * 2.0**-100)


#: Of alpha, k, omega, offset, sigma, r, V and trigger in units, with one force: what is followed, whence and where to.
FOLLOWED = [
    ((0.05, 1.0, 0.6, 0.0, 0.0, 0.8, 0.0, None), 3, "sigma", (-1.6, 1.6)),  # all periods graze at once
    ((0.05, 1.0, 2.6, 0.1, 0.0, 0.8, 0.2, 0.3), 3, "offset", (-1.4, 1.6)),
    ((0.3, 1.0, 2.8, 0.2, 0.0, 0.6, 0.0, None), 2, "k", (0.5, 1.5)),  # an orbit halves there
]
UNITS = {"sigma": (1, 0), "offset": (1, -2), "k": (0, -1)}


def pushed(numbers, L, T):
    alpha, k, omega, offset, sigma, r, V, trigger = numbers
    law = gz.active(r, V * L / T) if trigger is None else gz.triggered(r, V * L / T, trigger * L / T)
    push = gz.Forcing(omega / T, offset=offset * L / T**2, cos=(L / T**2,))
    return gz.Oscillator(alpha / T, k / T, push, law, sigma * L)


def special_points(numbers, N, name, bounds, L, T):
    """What is found on branches of one-impact orbits, without units."""
    unit = L ** UNITS[name][0] * T ** UNITS[name][1]
    found = []
    for orbit in gz.one_impact_orbits(pushed(numbers, L, T), N):
        branch = gz.continuation(orbit.map, orbit, name, (bounds[0] * unit, bounds[1] * unit), limit=500, points=3000)
        found += [
            (s.type, s.orbit.word, s.converged, s.admissible, s.where, s.piece, s.to, s.value / unit, s.low / unit)
            for s in branch.special
        ]
    return found


@pytest.mark.parametrize("case", FOLLOWED, ids=["sigma", "offset", "k"])
def test_special_points_of_branches(case):
    # elimination chose its pivots, and a secant its end, by numbers with units; products of speeds were lost
    plain = special_points(*case, 1.0, 1.0)
    assert len(plain) > 5
    for L, T in [(2.0**-150, 1.0), (2.0**60, 2.0**-40)]:
        assert special_points(*case, L, T) == plain
    for L, T in [(1e-6, 1e-3)]:  # this rounds otherwise
        other = special_points(*case, L, T)
        assert [one[:-2] for one in other] == [one[:-2] for one in plain]
        assert np.allclose([one[-2] for one in other], [one[-2] for one in plain], rtol=1e-9, atol=1e-12)


def diagram_and_locus(L, T):
    """The special points of a bifurcation diagram and of the first one's locus, without units."""
    P = gz.stroboscopic_map(pushed((3.0, 1.0, 2.2, 0.1, 0.0, 0.8, 0.4, None), L, T))
    F = L / T**2
    result = gz.bifurcation_diagram(P, "offset", np.linspace(0.09, 0.12, 7) * F, starts=10)
    kinds = *result.special_type.values, *result.window_word.values, *result.special_converged.values
    orbit = gz.one_impact_orbits(P.model, 3)[0]
    branch = gz.continuation(P, orbit, "offset", (0.09 * F, 0.13 * F))
    curve = gz.locus(branch.special[0], ("offset", "V"), ((0.0, 0.14 * F), (0.2 * L / T, 0.6 * L / T)))
    met = [(one.type, one.converged, one.values[0] / F, one.values[1] * T / L) for one in curve.meetings]
    return kinds, [*(result.special_value.values / F), *(x for one in met for x in one[2:])], [one[:2] for one in met]


def test_special_points_of_bifurcation_diagrams_and_loci():
    kinds, values, met = diagram_and_locus(1.0, 1.0)
    assert len(values) > 6
    for L, T in [(2.0**17, 2.0**-13)]:
        assert diagram_and_locus(L, T) == (kinds, values, met)
    one, other, third = diagram_and_locus(1e-6, 1e-3)
    assert (one, third) == (kinds, met) and np.allclose(other, values, rtol=1e-9)


def henon(a, b, wide, high):
    """Henon's map in coordinates of other units: fold, period doublings and multipliers are in closed form."""

    def step(state, p):
        x, y = state[0] / p.wide, state[1] / p.high
        return p.wide * (1.0 - p.a * x * x + y), p.high * p.b * x

    box = ((-1.5 * wide, 1.5 * wide), (-0.5 * high, 0.5 * high))
    return gz.Map(step, params={"a": a, "b": b, "wide": wide, "high": high}, coordinates=("x", "y"), box=box)


@pytest.mark.parametrize(("wide", "high"), [(1.0, 1.0), (2.0**-30, 2.0**30), (1e-6, 1e3)])
def test_conjugate_maps_of_the_plane_have_the_same_branches(wide, high):
    b = 0.3
    (orbit,) = (one for one in gz.periodic_orbits(henon(0.1, b, wide, high), period=1) if one.stable)
    branch = gz.continuation(orbit.map, orbit, "a", (-0.9, 1.2), limit=200)
    found = {one.type: one for one in branch.special}
    assert sorted(found) == ["lp", "pd"] and all(one.converged for one in branch.special)
    assert found["lp"].value == pytest.approx(-0.25 * (1.0 - b) ** 2, abs=1e-9)
    assert found["pd"].value == pytest.approx(0.75 * (1.0 - b) ** 2, abs=1e-9)
    (second,) = (one for one in gz.continuation(orbit.map, found["pd"], "a", (0.0, 1.0)).special if one.type == "pd")
    assert second.value == pytest.approx((1.0 - b) ** 2 + 0.25 * (1.0 + b) ** 2, abs=1e-8) and second.converged
    a, b = gz.locus(found["pd"], ("a", "b"), ((-0.9, 4.0), (-0.95, 0.95)), step=0.1).values.T
    assert len(a) > 100
    assert np.abs(a - 0.75 * (1.0 - b) ** 2).max() < 1e-8


def stopped(M, L, T):
    """What studies say of a rig between two stops, of which one kicks, without units."""
    S, F = L / T, M * L / T**2
    stops = gz.wall(-0.3 * L, gz.newton(0.8)), gz.wall(0.5 * L, gz.active(0.6, 0.05 * S))
    rig = {"m": 1.5 * M, "c": 0.3 * M / T, "k": 2.0 * M / T**2, "force": 1.7 * F, "load": 0.1 * F, "omega": 1.4 / T}
    P = gz.stroboscopic_map(gz.Oscillator.from_si(**rig, walls=stops))
    Q, starts = gz.impact_map(P.walled), np.array([[0.1, 0.2], [-0.2, -0.5]]) * (L, S)
    hits = Q.orbit((0.3 * T, 0.7 * S), 20)
    orbits = gz.periodic_orbits(P, 1, starts=20, threads=1)
    proofs = [gz.certify(orbit) for orbit in orbits]
    values, few = np.linspace(1.5, 1.6, 3) / T, {"starts": starts, "keep": 5, "threads": 1, "points": 200}
    scan = gz.bifurcation_diagram(P, "omega", values, period=1, **few)
    curve = gz.response(P, "omega", values, period=1, **few)
    found = gz.windows(P.walled, "omega", [1], span=(1.2 / T, 1.6 / T), samples=2, words="AB")
    words = [[orbit.word, orbit.walls, proof.claims["stability"]] for orbit, proof in zip(orbits, proofs, strict=True)]
    words += [scan.word.values[:, 0].tolist(), scan.special_type.values.tolist(), curve.special_type.values.tolist()]
    words += [found.word.values.tolist(), found.low_type.values.tolist(), hits.letters.tolist()]
    return words, [
        hits.points / (T, S), np.concatenate([orbit.points for orbit in orbits]) / (L, S),
        np.array([Q.jacobian(state) for state in hits.points[:3]]) * [[1.0, S / T], [T / S, 1.0]],
        scan.special_value.values * T, curve.special_value.values * T, curve.special_amplitude.values / L,
        found.low.values * T, found.high.values * T,
    ]  # fmt: skip


def test_a_rig_between_stops_in_micrometres_and_in_kilometres():
    words, numbers = stopped(1.0, 1.0, 1.0)
    assert len(words) > 6 and words[0][0] == "(AB)"
    for units in [(1e-9, 1e-6, 1e-6), (1e3, 1e3, 60.0)]:
        said, other = stopped(*units)
        assert said == words
        for one, two in zip(numbers, other, strict=True):
            np.testing.assert_allclose(two, one, rtol=1e-8, atol=1e-9)


def grown(L, T):
    """The manifolds of a saddle whose units of length and time are L and T, without units."""
    P = gz.stroboscopic_map(pushed((3.0, 1.0, 2.2, 0.105, 0.0, 0.8, 0.4, None), L, T))
    (saddle,) = (one for one in gz.one_impact_orbits(P.model, 2) if one.admissible)
    found = [gz.manifolds(saddle, side, length=0.4, spacing=0.02) for side in ("unstable", "stable")]
    return [
        values for one in found for values in (
            one.manifold.values / (L, L / T), one.seed.values, one.order.values, one.piece_length.values,
            one.branch_length.values, one.direction.values / (L, L / T), one.branch_end.values,
        )
    ]  # fmt: skip


def test_manifolds():
    # their lengths added displacements to velocities
    plain = grown(1.0, 1.0)
    assert len(plain[0]) > 100
    for L, T in [(2.0**20, 1.0), (1.0, 2.0**-15), (2.0**-70, 2.0**30)]:
        for one, other in zip(plain, grown(L, T), strict=True):
            assert np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


@pytest.mark.parametrize("walls", [1, 2])
def test_orbits_in_a_block_have_the_same_bits(walls):
    # a margin was at least that of a free flight of one unit of time, so that other orbits were flown one by one
    def last(L, T):
        S, push = L / T, gz.Forcing(3.1 / T, offset=0.1 * L / T**2, cos=(L / T**2,))
        low, high = gz.wall(-0.2 * L, gz.newton(0.8)), gz.wall(0.3 * L, gz.active(0.7, 0.1 * S))
        laws = {"reset": low.law, "sigma": low.position} if walls == 1 else {"walls": [low, high]}
        P = gz.stroboscopic_map(gz.Oscillator(alpha=0.05 / T, k=1.0 / T, forcing=push, **laws))
        starts = np.column_stack([np.linspace(-0.15, 0.25, 24), np.linspace(-1.0, 1.0, 24)]) * (L, S)
        found = gz.orbit_diagram(P, "omega", [3.1 / T], starts=starts, transient=20, keep=20, arithmetic="fast")
        return np.stack([found.u.values / L, found.v.values / S])

    plain = last(1.0, 1.0)
    for L, T in [(1.0, 2.0**-8), (1.0, 2.0**-25), (2.0**30, 2.0**15)]:
        assert np.array_equal(plain, last(L, T))
