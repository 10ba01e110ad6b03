"""Lyapunov exponents: closed forms, the sum rule, section against section, and where there are none."""

import json
import math
import sys

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import theory
from grazing.outcome import FATAL
from grazing.studies.growth import LEAST, MOST, carried, orthonormal, relieved, summed
from grazing.studies.lyapunov import WARM, lyapunov, plan
from grazing.studies.plan import empty_arrays, labelled
from tests.models import MODELS
from tests.studies.maps import FOLLOWER, HENON, LOGISTIC, SMOOTH, SPIRAL, linear_map, states_in

INF = np.inf
#: A passive ball, little damped, whose orbits at these values are chaotic (largest exponent about 0.14 a period).
CHAOTIC = {"alpha": 0.3, "k": 1.0, "omega": 2.8, "r": 0.95, "V": 0.0, "d": 0.1}


def eigenvalues(alpha, k):
    """Real parts of the roots of s^2 + alpha s + k^2, the larger one first; without cancellation."""
    D = alpha * alpha / 4.0 - k * k
    if D <= 0.0:
        return [-alpha / 2.0, -alpha / 2.0]
    fast = -alpha / 2.0 - np.sqrt(D)
    return [k * k / fast, fast]


@pytest.mark.parametrize(("alpha", "k"), [(0.2, 3.0), (1e-3, 1.0), (2.0, 1.5), (3.0, 1.0), (3.0, 1e-2), (6.0, 2.0)])
def test_without_impacts_they_are_real_parts_of_eigenvalues(alpha, k):
    model = gz.pinball(alpha=alpha, k=k, d=60.0 * k * k)  # a ball around u = 60
    found = lyapunov(gz.stroboscopic_map(model), starts=[[60.0, 0.0]], transient=1000)
    assert found.word.item() in ("0", "")
    assert found.exponent_per_time.values[0] == pytest.approx(eigenvalues(alpha, k), rel=1e-10, abs=1e-10)
    assert found.return_time.item() == pytest.approx(model.period, rel=1e-15)
    assert found.exponent.values[0] == pytest.approx(np.array(eigenvalues(alpha, k)) * model.period, rel=1e-10)


def test_at_critical_damping_the_two_are_told_apart_by_the_root_of_rounding_at_most():
    found = lyapunov(gz.stroboscopic_map(gz.pinball(alpha=2.0, k=1.0, d=60.0)), starts=[[60.0, 0.0]])
    assert found.exponent_per_time.values[0] == pytest.approx([-1.0, -1.0], abs=3e-8)
    assert found.exponent_per_time.values[0].sum() == pytest.approx(-2.0, abs=1e-10)


@pytest.mark.parametrize("alpha", [9.0, 12.0, 20.0, 60.0])
def test_without_impacts_however_strong_the_damping(alpha):
    found = lyapunov(gz.stroboscopic_map(gz.pinball(alpha=alpha, k=1.0, d=30.0)), starts=1)
    assert found.exponent_per_time.values[0] == pytest.approx(eigenvalues(alpha, 1.0), rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("kind", ["stroboscopic", "impact"])
@pytest.mark.parametrize(
    "model",
    [
        gz.pinball(V=0.4, d=0.12),
        gz.pinball(V=0.1, d=0.05),
        gz.pinball(V=0.0, d=0.05),
        gz.pinball(alpha=0.3, V=0.1, d=0.4),
        gz.pinball(V=0.4, d=0.05, r=0.0),
        gz.pinball(alpha=0.5, k=1.3, omega=1.5, V=0.3, d=0.6, sigma=0.2, r=0.5),
    ],
    ids=repr,
)
def test_one_impact_orbits(model, kind):
    seen = 0
    for N in range(1, 6):
        for orbit in gz.one_impact_orbits(model, N):
            if not (orbit.stable and orbit.admissible):
                continue
            if kind == "stroboscopic":
                P, start, steps = gz.stroboscopic_map(model), orbit.points[:1], N
            else:
                P, start, steps = gz.impact_map(model), [[orbit.tau, orbit.v_plus]], 1
            found = lyapunov(P, starts=start, transient=0)
            with np.errstate(divide="ignore"):
                exact = np.log(np.abs(orbit.multipliers))
            if model.params["r"] == 0.0:
                exact[1] = -INF  # the velocity before an impact is forgotten
            assert found.period.item() == steps
            assert found.return_time.item() == pytest.approx(N * model.period / steps, rel=1e-12)
            assert found.exponent.values[0] == pytest.approx(exact / steps, rel=1e-10, abs=1e-10)
            assert found.exponent_per_time.values[0] == pytest.approx(exact / (N * model.period), rel=1e-10, abs=1e-10)
            seen += 1
    assert seen


@pytest.mark.parametrize(
    ("N", "lam", "l"), [(1, 0.5, 0.1), (2, 0.5, 0.1), (3, 0.8, 1.0), (4, 0.34, 0.21), (6, 0.9, 0.8)]
)
def test_maximal_orbits_of_the_gap_map(N, lam, l):
    low = theory.mu_pd(N, lam, l)
    high = theory.mu_bc(N, lam, l) if N > 1 else low + 1.0
    for share in (1e-4, 0.3, 0.7, 0.99):
        mu = low + share * (high - low)
        start = theory.maximal_orbit(N, lam, mu, l)[:1, None] + 1e-7
        found = lyapunov(gz.gap_map(lam, mu, l), "mu", [mu], starts=start, transient=10)
        assert found.word.item() == "L" * (N - 1) + "R"
        assert found.exponent.item() == pytest.approx(np.log(abs(theory.multiplier(N, lam, mu, l))) / N, abs=1e-10)
        assert "return_time" not in found and found.trust.item() == 0


@pytest.mark.parametrize("d", [1, 2, 3])
def test_linear_maps_of_every_dimension(d):
    rng = np.random.default_rng(d)
    for _ in range(5):
        A = rng.normal(size=(d, d))
        A *= 0.8 / np.abs(np.linalg.eigvals(A)).max()
        found = lyapunov(linear_map(A), starts=2, transient=2000)
        exact = np.sort(np.log(np.abs(np.linalg.eigvals(A))))[::-1]
        assert found.exponent.values == pytest.approx(np.array([exact, exact]), abs=1e-10)
        assert (found.period == 1).all()


def test_chaos_of_known_exponents():
    logistic = lyapunov(SMOOTH.replace(a=4.0), starts=20, steps=20_000)
    assert logistic.exponent.values.mean() == pytest.approx(np.log(2.0), abs=2e-3)
    henon = lyapunov(HENON, starts=10, steps=20_000)
    assert henon.exponent.values[:, 0].mean() == pytest.approx(0.41922, abs=2e-3)  # Sprott, 2003, table A.1
    assert henon.exponent.values.sum(axis=1) == pytest.approx(np.log(0.3), abs=1e-10)
    assert (henon.period == -1).all() and (henon.word == "").all()


def test_three_exponents_of_a_map_with_two_followers():
    P = FOLLOWER.replace(a=3.9)
    found = lyapunov(P, starts=3, steps=4000)
    for j in range(3):
        values = found.exponent.values[j]
        assert (np.diff(values) < 0).all()
        assert values[1:] == pytest.approx([np.log(0.5), np.log(0.3)], abs=2e-3)  # transversal: they turn into place
        assert values[0] == pytest.approx(0.494, abs=0.03)
    cycle = lyapunov(FOLLOWER.replace(a=3.2), starts=2, transient=500).exponent.values
    assert cycle == pytest.approx(
        np.sort([np.log(0.16) / 2, np.log(0.5), np.log(0.3)])[::-1] * np.ones((2, 1)), abs=1e-10
    )


def plain(P, state, steps):
    """Exponents by NumPy's QR along an orbit, after the same warm-up; and the states at both ends."""
    Q, total = np.eye(P.dimension), np.zeros(P.dimension)
    side = np.ptp(P.box, axis=1)
    orbit = P.orbit(state, WARM + steps)
    for n, point in enumerate(orbit.points[:-1]):
        Q, R = np.linalg.qr(P.jacobian(point) * side / side[:, None] @ Q)
        if n >= WARM:
            total += np.log(np.abs(np.diag(R)))
    return np.sort(total)[::-1] / steps, orbit.points[WARM], orbit.points[-1]


@pytest.mark.parametrize(
    "P",
    [
        HENON,
        FOLLOWER.replace(a=3.9),
        SMOOTH.replace(a=3.9),
        LOGISTIC.replace(a=3.9),
        gz.gap_map(0.9, 0.1, 0.0),
        gz.stroboscopic_map(gz.pinball(**CHAOTIC)),
        gz.impact_map(gz.pinball(**CHAOTIC)),
        SPIRAL.replace(r=1.0),
    ],
    ids=lambda P: P.name,
)
def test_they_are_those_of_a_plain_qr(P):
    start = P.orbit(states_in(P, 1)[:, 0], 50).points[-1]
    found = lyapunov(P, starts=start[None], transient=20, keep=30, steps=200, arithmetic="strict")
    assert found.period.item() == -1
    state = P.orbit(start, 50).points[-1]
    exponents, first, last = plain(P, state, 200)
    assert found.exponent.values[0] == pytest.approx(exponents, abs=1e-9)
    if P.name == "impact map":
        letters = P.orbit(first, 200).letters.sum()
        time = (last[0] - first[0] + letters * P.model.period) / 200
        assert found.return_time.item() == pytest.approx(time, rel=1e-13)


def impacts_of(model, points):
    """Times, speeds before and after, of the impacts along strobes of an orbit; flown anew from every strobe."""
    T, found = model.period, []
    for n, point in enumerate(points[:-1]):
        flown = gz.trajectory(model, point, until=T, samples=2)
        found += [
            (n * T + t, v, w)
            for t, v, w in zip(flown.impact_time.values, flown.v_minus.values, flown.v_plus.values, strict=True)
        ]
    return np.array(found)


def test_the_sum_rule_on_a_chaotic_orbit():
    """Sum of the exponents per time = -alpha + sum of log|g'(v-) v+/v-| over the impacts of the segment, per time."""
    for change in ({}, {"V": 0.05}, {"r": 0.9, "d": 0.05}, {"alpha": 0.2}):
        model = gz.pinball(**{**CHAOTIC, **change})
        P = gz.stroboscopic_map(model)
        start, steps = P.orbit((0.3, 0.1), 60).points[-1], 150
        found = lyapunov(P, starts=start[None], transient=10, keep=10, steps=steps, arithmetic="strict")
        points = P.orbit(start, 20 + WARM + steps).points[20 + WARM :]
        hits = impacts_of(model, points)
        rule = -model.alpha + np.log(np.abs(model.params["r"] * hits[:, 2] / hits[:, 1])).sum() / (steps * model.period)
        assert found.period.item() <= 0 or change
        if found.period.item() > 0:  # a cycle: the rule holds over its own turn
            continue
        assert found.exponent_per_time.values[0].sum() == pytest.approx(rule, abs=1e-10), change


@pytest.mark.parametrize("name", ["standard", "two harmonics", "trigger", "own law", "under-damped", "critical"])
def test_the_sum_rule_on_cycles_of_every_model(name):
    model = MODELS[name]
    P = gz.stroboscopic_map(model)
    found = lyapunov(P, starts=6, transient=1500)
    seen = 0
    for j in np.flatnonzero((found.period.values > 0) & (found.outcome.values & 12 == 0)):
        N = int(found.period.values[j])
        states = P.orbit(lyapunov_start(P, j), 1500 + 64).points[-1]
        hits = impacts_of(model, P.orbit(states, N).points)
        g = [model.reset.slope(v, module_parameters(P)) for v in hits[:, 1]] if len(hits) else []
        rule = -model.alpha
        if len(hits):
            rule += np.log(np.abs(np.array(g) * hits[:, 2] / hits[:, 1])).sum() / (N * model.period)
        assert found.exponent_per_time.values[j].sum() == pytest.approx(rule, abs=1e-8 if name == "own law" else 1e-10)
        seen += 1
    assert seen


def lyapunov_start(P, j):
    from grazing.studies.starts import random_starts

    return random_starts(0, (), j + 1, P.box)[:, j]


def module_parameters(P):
    from grazing.parameter import parameters

    return parameters(P.params)


def growth_along(P, points):
    """Logarithms of the stretching along listed states, by QR."""
    Q, totals = np.eye(2), [np.zeros(2)]
    for point in points:
        Q, R = np.linalg.qr(P.jacobian(point) @ Q)
        totals.append(totals[-1] + np.log(np.abs(np.diag(R))))
    return np.array(totals)


def test_strobe_and_impacts_agree_on_one_segment_to_one_over_its_length():
    """On the same piece of a chaotic orbit the two sections' exponents per time differ by O(1/n)."""
    model = gz.pinball(**CHAOTIC)
    P, Q = gz.stroboscopic_map(model), gz.impact_map(model)
    points = P.orbit(P.orbit((0.3, 0.1), 80).points[-1], 800).points
    hits = impacts_of(model, points)
    T, ns = model.period, np.array([50, 100, 200, 400, 800])
    strobe = growth_along(P, points[:-1])
    impact = growth_along(Q, [(t % T, w) for t, _v, w in hits[:-1]])
    differences = []
    for n in ns:
        m = np.searchsorted(hits[:, 0], n * T) - 1
        differences.append(np.abs(strobe[n] / (n * T) - impact[m] / (hits[m, 0] - hits[0, 0])).max())
    differences = np.array(differences)
    assert (differences * ns * T < 8.0).all()  # what the two ends of the segment can be worth
    assert np.polyfit(np.log(ns), np.log(differences), 1)[0] < -0.6
    assert differences[-1] < 4e-3
    # and the study, on a segment that begins there
    one = lyapunov(P, starts=points[:1], transient=0, keep=1, steps=1000, arithmetic="strict")
    two = lyapunov(Q, starts=[[hits[0, 0] % T, hits[0, 2]]], transient=0, keep=1, steps=1000, arithmetic="strict")
    assert one.exponent_per_time.values[0] == pytest.approx(two.exponent_per_time.values[0], abs=0.02)
    assert two.return_time.item() == pytest.approx(np.diff(hits[:, 0]).mean(), rel=0.1)


def test_both_sections_give_one_cycle_the_same_exponents_per_time():
    for model in (gz.pinball(V=0.4, d=0.1), gz.pinball(alpha=0.3, V=0.1, d=0.1, r=0.6), gz.pinball(V=0.2, d=0.05)):
        P, Q = gz.stroboscopic_map(model), gz.impact_map(model)
        one, two = (lyapunov(R, starts=8, transient=1500) for R in (P, Q))
        ours, theirs = one.exponent_per_time.values[one.period > 0], two.exponent_per_time.values[two.period > 0]
        assert min(np.abs(x - y).max() for x in ours for y in theirs) < 1e-8


@pytest.mark.parametrize("kind", ["stroboscopic", "impact"])
@pytest.mark.parametrize(
    "model",
    [gz.pinball(r=0.3, V=0.0, d=-0.2), gz.pinball(r=0.0, V=0.0, d=-0.1), gz.pinball(r=0.7, V=0.0, d=-0.5)],
    ids=repr,
)
def test_through_chatter_and_sticking_they_are_minus_infinity(model, kind):
    P = gz.stroboscopic_map(model) if kind == "stroboscopic" else gz.impact_map(model)
    found = lyapunov(P, starts=6)
    assert (found.outcome.values & (gz.Outcome.chatter | gz.Outcome.stuck) != 0).all()
    assert (found.exponent.values == -INF).all()
    assert (found.exponent_per_time.values == -INF).all()
    assert np.isfinite(found.return_time.values).all()


def test_chaos_that_chatters_at_times_is_minus_infinity():
    model = gz.pinball(**{**CHAOTIC, "d": 0.0})
    found = lyapunov(gz.stroboscopic_map(model), starts=6, transient=500, steps=2000)
    chattered = found.outcome.values & gz.Outcome.chatter != 0
    late = np.isneginf(found.exponent.values[:, 0])
    assert late.any() and (late <= chattered).all()


def test_without_restitution_one_direction_is_lost():
    found = lyapunov(gz.stroboscopic_map(gz.pinball(r=0.0, V=0.4, d=0.05)), starts=4)
    assert np.isfinite(found.exponent.values[:, 0]).all()
    assert (found.exponent.values[:, 1] == -INF).all()
    singular = lyapunov(linear_map([[0.5, 0.25], [1.0, 0.5]]), starts=2)  # eigenvalues 1 and 0
    assert (singular.exponent.values[:, 1] == -INF).all()


def test_a_graze_has_no_exponent():
    found = lyapunov(gz.gap_map(0.5, 0.0, 0.0), starts=[[0.0]])  # the fixed point 0, where the slope is infinite
    assert found.trust.item() == 2
    assert np.isnan(found.exponent.item())


def test_a_derivative_that_is_not_a_number_says_so():
    def tangent(state, p):
        (x,) = state
        return (p.a - x * x,), 0, 0, (-2.0 * x if x < 1.2 else np.nan,)

    P = gz.Map(lambda state, p: (p.a - state[0] ** 2,), params={"a": 1.9}, tangent=tangent, name="half smooth")
    found = lyapunov(P, starts=[[0.1], [0.2]], steps=200)
    assert (found.period <= 0).all() and np.isnan(found.exponent.values).all()


def test_orbits_that_end_have_none():
    found = lyapunov(HENON, "a", [1.4, 3.0], starts=5)
    assert (found.period.sel(a=3.0) == -2).all()
    assert np.isnan(found.exponent.sel(a=3.0).values).all()
    assert np.isfinite(found.exponent.sel(a=1.4).values).all()

    def leaving(state, p):
        return (state[0] + p.a,)

    assert np.isnan(lyapunov(gz.gap_map(1e154, 0.3, 0.8), starts=1).exponent.item())  # beyond all doubles, unwarned
    P = gz.Map(leaving, params={"a": 1.0}, escape=500.0)
    late = lyapunov(P, starts=[[0.0]], transient=100, keep=50, steps=1000)  # it leaves while it is measured
    assert late.outcome.item() & gz.Outcome.diverged
    assert np.isnan(late.exponent.item())


def test_maps_without_a_derivative_of_their_own_are_numerical():
    exact, numerical = lyapunov(SMOOTH, starts=3, transient=500), lyapunov(LOGISTIC, starts=3, transient=500)
    assert (exact.trust == 0).all() and (numerical.trust == 1).all()
    assert numerical.exponent.values == pytest.approx(exact.exponent.values, abs=1e-8)
    assert exact.exponent.values == pytest.approx(np.log(0.16) / 2, abs=1e-10)


@pytest.mark.parametrize(
    ("P", "name", "values"),
    [
        (gz.gap_map(0.5, 0.1, 0.1), "mu", np.linspace(-0.1, 0.2, 7)),
        (HENON, "a", np.linspace(0.2, 1.5, 7)),
        (gz.stroboscopic_map(gz.pinball(**CHAOTIC)), "d", np.linspace(-0.1, 0.2, 7)),
        (gz.impact_map(gz.pinball(**CHAOTIC)), "d", np.linspace(-0.1, 0.2, 7)),
    ],
    ids=["gap map", "Henon", "oscillator", "impact map"],
)
def test_neither_threads_nor_pieces_change_a_bit(P, name, values):
    more = {"starts": 4, "transient": 60, "steps": 100}
    one = lyapunov(P, name, values, threads=1, **more)
    xr.testing.assert_identical(one, lyapunov(P, name, values, threads=3, **more))
    made = plan(P, name, values, **more)
    arrays = empty_arrays(made, made.cells)
    for cells in np.array_split(np.random.default_rng(0).permutation(made.cells), 3):
        some = empty_arrays(made, len(cells))
        for _ in made.compute(cells, some):
            pass
        for key, array in arrays.items():
            array[cells] = some[key]
    xr.testing.assert_identical(labelled(made, arrays), one)
    greatest_first = one.exponent.values[..., :-1] >= one.exponent.values[..., 1:]
    assert (greatest_first | np.isnan(one.exponent.values).any(axis=-1, keepdims=True)).all()


def test_tiles_change_nothing(monkeypatch):
    one = lyapunov(HENON, starts=3, steps=500)
    monkeypatch.setattr(sys.modules[plan.__module__], "TILE", 10)
    xr.testing.assert_identical(lyapunov(HENON, starts=3, steps=500), one)


def test_shortest_inputs():
    found = lyapunov(SMOOTH.replace(a=3.9), starts=1, transient=0, keep=1, steps=1)
    assert found.period.item() == 0 and np.isfinite(found.exponent.item())
    constant = gz.Map(lambda state, p: (0.5 * state[0] + 1.0,), params={})
    assert lyapunov(constant, starts=2).exponent.values == pytest.approx(np.log(0.5), abs=1e-9)


def test_labels_and_configuration():
    found = lyapunov(HENON, "a", [0.3, 0.2], starts=3, steps=50)
    assert found.exponent.dims == ("a", "start", "index") and dict(found.sizes) == {"a": 2, "start": 3, "index": 2}
    config = json.loads(found.attrs["grazing_config"])
    assert (config["study"], config["parameter"], config["steps"], config["params"]) == (
        "lyapunov",
        "a",
        50,
        {"b": 0.3},
    )
    alone = lyapunov(HENON, starts=3)
    assert alone.exponent.dims == ("start", "index") and "parameter" not in json.loads(alone.attrs["grazing_config"])


def test_frames():
    frame, image, sums, sides = np.empty((3, 3, 2)), np.full((3, 3, 2), 7.0), np.zeros((3, 2)), np.ones((3, 2))
    frame[...] = np.eye(3)[:, :, None]
    A = np.random.default_rng(0).normal(size=(3, 3))
    carried(3, tuple(A.ravel()), np.ones(3), frame, image, 1)
    assert np.allclose(image[:, :, 1], A)
    orthonormal(3, image, frame, sides, 1)
    summed(sums, sides, 1)
    assert np.allclose(frame[:, :, 1].T @ frame[:, :, 1], np.eye(3), atol=1e-15)
    assert sums[:, 1] == pytest.approx(np.log(np.abs(np.diag(np.linalg.qr(A)[1]))), abs=1e-13)
    carried(3, (0.0,) * 9, np.ones(3), frame, image, 1)
    assert not image[:, :, 1].any()
    carried(3, (np.nan,) * 9, np.ones(3), image, frame, 1)  # what has fallen on one orbit stays there
    assert not frame[:, :, 1].any()
    assert (image[:, :, 0] == 7.0).all() and not sums[:, 0].any()  # the other orbit's are left alone


def test_logarithms_are_taken_only_where_what_was_multiplied_up_leaves_its_range():
    sums, sides = np.zeros((1, 5)), np.array([[2.0, 10.0 * MOST, 0.1 * LEAST, 0.0, np.nan]])
    relieved(sums, sides, 5)
    assert sides[0].tolist() == [2.0, 1.0, 1.0, 1.0, 1.0]
    assert sums[0, :4].tolist() == [0.0, math.log(10.0 * MOST), math.log(0.1 * LEAST), -math.inf]
    assert math.isnan(sums[0, 4])
    sides[0, 1:] = 1e300
    relieved(sums, sides, 1)  # only the first orbit is asked
    assert sides[0, 1:].tolist() == [1e300] * 4


@pytest.mark.parametrize(
    ("arguments", "more", "said"),
    [
        ((HENON, "a"), {}, "give a parameter's name with its values, or neither of them"),
        ((HENON, None, [1.0]), {}, "give a parameter's name with its values, or neither"),
        ((HENON, "c", [1.0]), {}, "unknown parameter 'c' of Henon map"),
        ((HENON,), {"steps": 0}, "steps = 0; allowed is a whole number >= 1"),
        ((HENON,), {"steps": 1.5}, "steps = 1.5; allowed is a whole number >= 1"),
        ((HENON,), {"starts": [[0.0]]}, r"starts have shape \(1, 1\); give"),
        ((HENON,), {"keep": 0}, "keep = 0; allowed"),
        ((gz.Map(lambda s, p: (p.index * s[0],), {"index": 0.5}), "index", [0.1]), {}, "'index' names a dimension"),
        ((1,), {}, "the first argument is 1; give a map"),
    ],
)
def test_error_texts(arguments, more, said):
    with pytest.raises(gz.InputError, match=said):
        lyapunov(*arguments, **more)


def test_the_error_of_an_exponent_is_that_of_independent_steps_where_they_are():
    """The steps of a skew tent map are independent: its slopes are 1/c and 1/(1 - c) with probabilities c and 1 - c."""
    c, steps = 0.3, 500

    def tent(state, p):
        return (state[0] / p.c if state[0] < p.c else (1.0 - state[0]) / (1.0 - p.c),)

    P = gz.Map(tent, params={"c": c}, coordinates=("x",), box=((0.0, 1.0),))
    found = lyapunov(P, starts=400, steps=steps)
    assert (found.period.values == -1).all()
    exact = -c * math.log(c) - (1.0 - c) * math.log(1.0 - c)
    error = math.sqrt(c * (1.0 - c) / steps) * math.log((1.0 - c) / c)
    assert found.exponent_error.values.mean() == pytest.approx(error, rel=0.05)
    away = (found.exponent.values - exact) / found.exponent_error.values
    assert 0.95 < away.std() < 1.2 and abs(away.mean()) < 0.2  # Student's t with 19 degrees of freedom has 1.06


def test_errors_of_exponents_are_as_wide_as_starts_scatter():
    found = lyapunov(HENON.replace(a=1.4, b=0.3), starts=200, steps=2000)
    assert (found.period.values == -1).all()
    spread, said = found.exponent.values.std(axis=0), found.exponent_error.values.mean(axis=0)
    assert said == pytest.approx(spread, rel=0.35) and said[0] == pytest.approx(said[1], rel=1e-6)  # det J is constant


def test_an_exponent_of_a_cycle_has_no_statistical_error():
    found = lyapunov(gz.gap_map(lam=0.5, mu=0.07, l=0.1), starts=2)
    assert (found.exponent_error.values == 0.0).all()
    one = lyapunov(LOGISTIC.replace(**{name: 4.0 for name in LOGISTIC.params}), starts=2, steps=1)
    assert np.isnan(one.exponent_error.values).all()


def test_a_cycle_that_repels_is_ambiguous_when_rounding_leads_an_orbit_to_it():
    def doubling(x, p):
        return ((2.0 * x[0]) % 1.0, p.c * x[1] if x[0] < 0.5 else 1.0 - p.d + p.d * x[1])

    P = gz.Map(doubling, params={"c": 0.2, "d": 0.4}, box=((0.0, 1.0), (0.0, 1.0)), coordinates=("x", "y"))
    found = lyapunov(P, starts=3)  # after 53 steps all bits are gone; log 0.2 is not the exponent of any other orbit
    assert (found.trust.values == 2).all()
    line = gz.Map(lambda x, p: ((2.0 * x[0]) % 1.0,), box=((0.0, 1.0),))
    assert (lyapunov(line, starts=3).trust.values == 2).all()
    assert (lyapunov(LOGISTIC, "a", [3.2, 3.9], starts=3).trust.values < 2).all()  # attracted, and chaotic
    tripling = gz.Map(lambda x, p: ((3.0 * x[0]) % 1.0,), box=((0.0, 1.0),))
    exact, free = 2.0**-10, 0.3  # a cycle of 256 points, more than are kept; doubles hold one of some 2^50
    assert lyapunov(tripling, starts=[[exact], [free]]).trust.values.tolist() == [2, 1]


def test_an_orbit_that_ends_while_it_is_measured_has_ended():
    """Just beyond a = 4 orbits of the logistic map stay for hundreds of steps before they leave for good."""
    found = lyapunov(LOGISTIC.replace(a=4.00001), starts=20, transient=10, keep=20)
    ended = (found.outcome.values & FATAL) != 0
    assert 0 < ended.sum() < 20
    assert (found.period.values == np.where(ended, -2, -1)).all()
    assert (np.isnan(found.exponent.values[:, 0]) == ended).all()


@pytest.mark.parametrize("a", [2.0000001, 1.9, 3.3, 3.5, 3.8318740551, 3.2360679])
def test_differences_beside_a_maximum_are_as_wrong_as_the_error_of_a_cycle_says(a):
    """The error was 4e-11 wherever a cycle lies: at 3.8318740551 the exponent was off by 0.002."""
    found, exact = (lyapunov(P.replace(a=a), starts=3, transient=2000) for P in (LOGISTIC, SMOOTH))
    assert (found.period == exact.period).all() and (found.period > 0).all()
    off = abs(found.exponent - exact.exponent)
    assert (off <= found.exponent_error).all() and (found.exponent_error < 0.1).all()


def test_an_exponent_that_differences_do_not_know_has_no_error_that_is_a_number():
    """At a = 2 the maximum itself is a fixed point: the exponent is minus infinity, and what is not is rounding."""
    for P in (
        LOGISTIC,
        gz.Map(
            pieces={"L": LOGISTIC.step, "R": LOGISTIC.step},
            border=lambda x, p: x[0] - 0.5,
            params={"a": 2.0},
            box=((0.0, 1.0),),
        ),
    ):
        found = lyapunov(P.replace(a=2.0), starts=5)
        assert (found.period > 0).all()
        assert ((found.exponent_error > 1.0) | np.isnan(found.exponent_error)).all()


@pytest.mark.parametrize("b", [1e-3, 1e-7])
def test_differences_of_a_cycle_of_the_plane_have_an_error_for_each_exponent(b):
    """Of two points whose x are x and y the multipliers have the sum 4 a^2 x y + 2 b and the product b^2."""

    def flat(state, p):
        return 1.0 - p.a * state[0] * state[0] + p.b * state[1], state[0]

    a = 0.9
    P = gz.Map(flat, params={"a": a, "b": b}, coordinates=("x", "y"), box=((-1.0, 1.0), (-1.0, 1.0)))
    found = lyapunov(P, starts=2, transient=1000)
    assert (found.period == 2).all()
    product = ((1.0 - b) ** 2 - a) / a**2  # of x and y, the roots of a^2 z^2 - a (1 - b) z + (1 - b)^2 - a
    half = 2.0 * a * a * product + b
    greatest = abs(half) + math.sqrt(half * half - b * b)
    exact = np.log([greatest, b * b / greatest]) / 2.0
    off = abs(found.exponent.values - exact)
    assert (off <= found.exponent_error.values).all() and (found.exponent_error.values[:, 0] < 1e-8).all()


@pytest.mark.parametrize(("slope", "cubic"), [(0.01, 100.0), (1e-4, 2800.0), (0.01, 0.0)])
def test_slopes_of_either_sign_do_not_hide_the_error_of_a_cycle(slope, cubic):
    """All moved up, the slopes s and -s have the same product but for the square: 3.6e-7 off, the error was 4e-11."""

    def two(state, p):
        x = state[0]
        y = x - 0.3 if x < 0.5 else 0.7 - x
        z = p.s * y + p.cubic * y * y * y
        return (0.7 + z if x < 0.5 else 0.3 + z,)

    P = gz.Map(two, params={"s": slope, "cubic": cubic}, box=((0.0, 1.0),))
    found = lyapunov(P, starts=8, transient=1000)
    cycle = found.period.values == 2
    off = abs(found.exponent.values[cycle] - math.log(slope))
    assert cycle.any() and (off <= found.exponent_error.values[cycle]).all()
    assert (found.exponent_error.values[cycle] < 0.1).all()
