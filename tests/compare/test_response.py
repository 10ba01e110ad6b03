"""The response of a rig: closed forms, what the other studies say, and what a wrong call is told."""

import json
import warnings

import numpy as np
import pint
import pytest

import grazing as gz
from grazing.compare.response import response
from grazing.oscillator.gauge import READINGS

HERTZ = 2.0 * np.pi
#: 0.80 kg, 2.4 N s/m, 3200 N/m, 2.5 N, a stop at 1.2 mm above (u is -x), restitution 0.7; metres.
M, C, K, FORCE, GAP = 0.80, 2.4, 3200.0, 2.5, 1.2e-3


def rig(hertz=14.0, r=0.7):
    forcing = gz.Forcing(omega=HERTZ * hertz, cos=(-FORCE / M,))
    return gz.Oscillator(alpha=C / M, k=np.sqrt(K / M), forcing=forcing, sigma=-GAP, reset=gz.newton(r))


@pytest.fixture(scope="module")
def swept():
    return response(gz.stroboscopic_map(rig()), "omega", HERTZ * np.linspace(4.0, 20.0, 65), starts=6)


def linear(omega):
    return FORCE / np.hypot(K - M * omega**2, C * omega)


def admissible(result, kind):
    real = (result.special_admissible.values == 1) & (result.special_type.values == kind)
    return result.isel(special=np.flatnonzero(real))


def test_grazes_and_the_fold_of_the_rig(swept):
    grazes = admissible(swept, "gr")
    free = grazes.special_value.values[grazes.special_impacts_per_period.values == 0.0] / HERTZ
    half = K / M - 0.5 * (C / M) ** 2
    edges = np.sqrt(half + np.array([-1.0, 1.0]) * np.sqrt(half**2 - (K / M) ** 2 + (FORCE / M / GAP) ** 2)) / HERTZ
    np.testing.assert_allclose(edges, [5.951311, 12.922705], atol=5e-7)
    np.testing.assert_allclose(np.sort(free), edges, rtol=1e-12)
    grazing = grazes.isel(special=np.flatnonzero(grazes.special_impacts_per_period.values == 0.0))
    np.testing.assert_allclose(grazing.special_amplitude.values, GAP, rtol=1e-12)
    folds = admissible(swept, "lp").special_value.values / HERTZ
    assert folds.max() == pytest.approx(16.58097, abs=5e-6)


@pytest.mark.parametrize("way", ["metres", "millimetres", "pint"])
def test_the_rig_is_the_same_in_whatever_units_it_is_given(way):
    numbers = {"m": M, "c": C, "k": K, "force": FORCE, "gap": GAP, "frequency": 14.0}
    if way == "millimetres":
        numbers = {"m": "800 g", "c": "2.4e-3 N s/mm", "k": "3.2 N/mm", "force": "2500 mN", "gap": "1.2 mm",
                   "frequency": "840 rpm"}  # fmt: skip
    if way == "pint":
        units = pint.UnitRegistry()
        of = {"m": "kg", "c": "N*s/m", "k": "N/m", "force": "N", "gap": "m", "frequency": "Hz"}
        numbers = {name: units.Quantity(value, of[name]) for name, value in numbers.items()}
    made = gz.Oscillator.from_si(**numbers, side="above", reset=gz.newton(0.7))
    P = gz.stroboscopic_map(made)
    found = []
    for at, ends, word in ((5.6, (5.5, 6.5), "0"), (18.0, (12.0, 19.0), "0"), (14.0, (13.5, 17.0), "1")):
        (orbit,) = (one for one in gz.periodic_orbits(P.replace(omega=HERTZ * at), word=word) if one.stable)
        branch = gz.continuation(P, orbit, "omega", (HERTZ * ends[0], HERTZ * ends[1]))
        special = gz.in_units(branch, "Hz")
        found += special.special_value.values[special.special_type.values == ("gr" if word == "0" else "lp")].tolist()
    assert np.unique(np.round(found, 9)) == pytest.approx([5.951311, 12.922705, 16.580971], abs=5e-7)
    where = gz.basins(P, {"u": np.linspace(-1.2e-3, 9e-3, 80), "v": np.linspace(-0.4, 0.4, 80)}, preimages=0)
    assert (where.word.values[0], round(float(where.fraction[0]), 3)) == ("1", 0.981)


def test_up_and_down_differ_from_the_graze_to_the_fold(swept):
    up, down = (swept.amplitude.sel(run=run).values for run in ("up", "down"))
    hertz = swept.omega.values / HERTZ
    between = (hertz >= 13.25) & (hertz <= 16.5)
    np.testing.assert_allclose(down[between], linear(swept.omega.values[between]), rtol=1e-12)
    assert (up[between] > 1.3 * down[between]).all()
    above = hertz > 16.6
    np.testing.assert_allclose(up[above], linear(swept.omega.values[above]), rtol=1e-12)
    last = swept.isel(difference=-1)
    assert (float(last.difference_low) / HERTZ, float(last.difference_high) / HERTZ) == pytest.approx((13.25, 16.5))
    assert int(last.difference_values) == 14
    assert float(swept.difference_high.values[0]) < HERTZ * 6.0  # the other fold, at 5.17 Hz, and the other graze


def test_every_reading_is_that_of_a_trajectory(swept):
    i = int(np.argmin(np.abs(swept.omega.values - HERTZ * 14.0)))
    found = swept.isel(omega=i).sel(run="up")
    assert (str(found.word.item()), int(found.period)) == ("1", 1)
    omega = float(swept.omega[i])
    # the same orbit as closed forms give it, flown long and sampled finely
    orbit = next(one for one in gz.one_impact_orbits(rig(omega / HERTZ), 1) if one.stable and one.admissible)
    T = HERTZ / omega
    path = gz.trajectory(orbit.map.model, tuple(orbit.points[0]), until=400 * T, samples=500)
    late = path.t.values >= 399.0 * T - 1e-9
    u, v = path.u.values[late], path.v.values[late]
    assert float(found.amplitude) == pytest.approx(0.5 * np.ptp(u), rel=1e-4)
    assert float(found.peak_velocity) == pytest.approx(np.abs(v).max(), rel=1e-4)
    assert float(found.impact_speed) == pytest.approx(-float(path.v_minus[-1]), rel=1e-7)
    assert float(found.impulse) == pytest.approx(float(path.v_plus[-1] - path.v_minus[-1]), rel=1e-7)
    # balance of momentum: nothing pushes on the mean but the spring and the stop
    assert float(found.impulse) / T == pytest.approx(K / M * float(found["mean"]), rel=1e-6)


def test_branches_carry_readings_and_pass_through_what_was_reached(swept):
    alone = (swept.branch_stable.values == 1) & (swept.branch_admissible.values == 1) & (swept.branch_event.values == 0)
    omega, amplitude = swept.branch_omega.values, swept.branch_amplitude.values
    free = alone & (swept.branch_impacts.values == 0)
    np.testing.assert_allclose(amplitude[free], linear(omega[free]), rtol=1e-12)
    hitting = alone & (swept.branch_impacts.values == 1) & (omega > HERTZ * 13.0)
    order = np.argsort(omega[hitting])
    up = swept.amplitude.sel(run="up").values
    some = (swept.omega.values > HERTZ * 13.1) & (swept.omega.values < HERTZ * 16.4)
    drawn = np.interp(swept.omega.values[some], omega[hitting][order], amplitude[hitting][order])
    np.testing.assert_allclose(up[some], drawn, rtol=2e-3)
    unstable = (swept.branch_stable.values == 0) & (swept.branch_admissible.values == 1)
    assert np.isfinite(amplitude[unstable]).all() and unstable.any()
    special = swept.special_value.values[swept.special_admissible.values == 1]
    at = (np.abs(omega[:, None] - special) < 1e-10).any(axis=1)
    virtual = (swept.branch_admissible.values == 0) & ~at
    assert np.isnan(amplitude[virtual]).all() and virtual.any()
    assert np.bincount(swept.branch_impact_point.values).max() == 2


def test_random_starts_reach_what_the_sweeps_reach(swept):
    """Between graze and fold both attractors are reached; a start has the readings of the sweep it ended with."""
    starts = [run for run in swept.run.values.tolist() if run.startswith("start")]
    assert len(starts) == 6
    hertz = swept.omega.values / HERTZ
    between = swept.isel(omega=np.flatnonzero((hertz > 13.2) & (hertz < 16.4)))
    both = between.amplitude.sel(run=["up", "down"]).values[:, None, :]
    apart = np.abs(between.amplitude.sel(run=starts).values[:, :, None] / both - 1.0)
    assert (apart.min(axis=2) < 1e-12).all()
    assert (apart.argmin(axis=2) == 0).any()


def test_numbers_do_not_depend_on_the_section_nor_on_threads_nor_on_the_order_of_values():
    values = HERTZ * np.array([13.5, 14.5, 17.0])
    say = dict(starts=3, transient=200, keep=8)
    one = response(gz.stroboscopic_map(rig()), "omega", values, threads=1, **say)
    other = response(gz.stroboscopic_map(rig(), phase=0.02), "omega", values[::-1], threads=2, **say)
    np.testing.assert_array_equal(one.amplitude.values, other.amplitude.values[::-1])
    assert one.attrs["title"] == "response of the stroboscopic map in omega"
    config = json.loads(one.attrs["grazing_config"])
    assert (config["study"], config["parameter"], config["period"], config["starts"]["random"]) == (
        "response", "omega", 1, 3,
    )  # fmt: skip


def test_chaos_rest_and_what_ends_have_readings_or_none():
    chaotic = gz.pinball(alpha=0.02, k=1.0, omega=2.8, d=0.0, V=0.0, r=0.8)
    found = response(gz.stroboscopic_map(chaotic), "omega", [3.08, 3.1], starts=4, period=2)
    assert np.isfinite(found.amplitude.values).all() and (found.period.values[1] == -1).all()
    lies = gz.pinball(d=-3.0, V=0.0)
    still = response(gz.stroboscopic_map(lies), "d", [-3.0, -2.0], starts=2)
    assert (still.amplitude.values == 0.0).all() and (still.impacts_per_period.values == 0.0).all()
    assert still.sizes["difference"] == 0


def test_another_parameter_and_doubled_orbits():
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    found = response(P, "d", np.linspace(0.1, 0.13, 13), starts=6, period=3)
    windows = gz.windows(gz.pinball(V=0.4), "d", 3).isel(window=0)
    doubling = admissible(found, "pd").special_value.values
    assert np.abs(doubling - float(windows.high)).min() < 1e-9
    assert set(found.branch_period.values.tolist()) <= {1, 2, 3}
    assert set(found.period.values.ravel().tolist()) >= {2, 3}


@pytest.mark.parametrize("before", [1e-3, 1e-5])
def test_beside_a_period_doubling_all_runs_read_as_the_cycle_that_they_approach(before):
    P = gz.stroboscopic_map(gz.pinball(alpha=0.02, k=1.0, omega=2.6, d=0.0, V=0.0, r=0.8))
    high = float(gz.windows(P.model, "omega", 1).isel(window=0).high)
    values = high - np.array([before, 2.0 * before])
    found = response(P, "omega", values, starts=3)
    assert (found.period.values == 1).all() and (found.word.values == "1").all()
    for i, value in enumerate(values.tolist()):
        (orbit,) = (one for one in gz.one_impact_orbits(P.model.replace(omega=value), 1) if one.stable)
        assert -1.0 < orbit.multipliers.real.min() < -0.94
        np.testing.assert_allclose(found.impact_speed.values[i], -orbit.incoming[0], rtol=1e-12)
        np.testing.assert_allclose(found.impulse.values[i], orbit.outgoing[0] - orbit.incoming[0], rtol=1e-12)


def test_saved_and_loaded(swept, tmp_path):
    back = gz.load(gz.save(swept, tmp_path / "response.nc"))
    np.testing.assert_array_equal(back.amplitude.values, swept.amplitude.values)
    assert back.run.values.tolist() == swept.run.values.tolist()
    assert {f"{front}{name}" for name in READINGS for front in ("", "branch_", "special_")} <= set(back.data_vars)
    files = gz.to_csv(back, tmp_path / "response.csv")
    head = files[0].read_text().partition("\n")[0].split(",")
    assert files[0].name == "response.csv" and head[:2] == ["omega", "amplitude_up"]  # what was measured comes first


def test_progress_counts_all_three_scans():
    seen = []
    response(gz.stroboscopic_map(rig()), "omega", HERTZ * np.array([16.8, 17.0]), starts=2, transient=40, keep=4,
             progress=lambda done, total: seen.append((done, total)))  # fmt: skip
    scans, points = ([done for done, total in seen if (total == 6) == first] for first in (True, False))
    assert scans[-1] == 6 and scans == sorted(scans) and points == sorted(points) and points


def test_what_a_wrong_call_is_told():
    P = gz.stroboscopic_map(rig())
    with pytest.raises(gz.InputError, match="at least 2 different"):
        response(P, "omega", [80.0, 80.0])
    with pytest.raises(gz.InputError, match="a response is that of an oscillator"):
        response(gz.gap_map(0.5, 0.1, 0.1), "mu", [0.1, 0.2])
    with pytest.raises(gz.InputError, match="a response is that of an oscillator"):
        response(gz.impact_map(rig()), "omega", [80.0, 81.0])
    with pytest.raises(gz.InputError, match="phase"):
        response(P, "phase", [0.0, 0.1])
    with pytest.raises(gz.InputError, match="period"):
        response(P, "omega", [80.0, 81.0], period=0)
    with pytest.raises(gz.InputError, match="omega"):
        response(P, "omega", [-1.0, 81.0])


@pytest.mark.parametrize(("sigma", "offset"), [(0.0, 0.0), (-1e-3, -1e-3), (0.0, -0.1), (-1e-3, 1e-3)])
def test_a_still_ball_on_its_wall_or_above_it_is_followed_and_warned_of_once(sigma, offset):
    force = gz.Forcing(2.0, offset, cos=(0.0,))
    P = gz.stroboscopic_map(gz.Oscillator(alpha=0.3, k=1.0, forcing=force, reset=gz.newton(0.7), sigma=sigma))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = gz.response(P, "omega", [2.0, 2.1], starts=1, transient=5, keep=2)
    assert [str(one.message).partition(":")[0] for one in told] == ["nothing shakes the ball"]
    size = abs(sigma) + abs(offset)  # nothing moves, in units of whatever length there is
    assert (found.amplitude.sel(run=["up", "down"]).values <= 1e-12 * size).all()
    assert found.sizes["branch_point"] >= 2 and np.isfinite(found.branch_omega.values).all()


def test_a_rig_that_nothing_shakes_is_warned_about():
    still = gz.Oscillator(alpha=0.3, k=1.0, forcing=gz.Forcing(2.0, cos=(0.0,)), reset=gz.newton(0.7), sigma=-1.0)
    with pytest.warns(UserWarning, match="nothing shakes the ball: all amplitudes of the force are 0"):
        gz.response(gz.stroboscopic_map(still), "omega", [2.0, 2.1], starts=1, transient=5, keep=2)
    gz.response(gz.stroboscopic_map(still), "cos1", [0.0, 0.1], starts=1, transient=5, keep=2)
