"""The response between walls and at moving ones: laws of momentum, closed forms, and the model with one wall."""

import json

import numpy as np
import pytest

import grazing as gz
from grazing.cli import main
from grazing.oscillator.gauge import BY_WALL, READINGS, flown_cycle, gauged, repeated_cycle

W = 2.0 * np.pi
STOPS = gz.wall("-0.8 mm", gz.newton(0.8)), gz.wall("1.2 mm", gz.newton(0.6))
RIG = gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, force=2.5, frequency=14, walls=STOPS)
STILL = gz.Forcing(omega=1.0, cos=())
SHAKE = gz.Forcing(omega=1.0, sin=(1.0,), cos=())
#: Of the symmetric orbit of the impact pair, r = 0.5, s = 1/(3 pi): cos phi + 2 s sin phi = -3 s.
PHI = 2.0965418499633213


def pair(half=1.5):
    box = gz.wall(-half, gz.newton(0.5), motion=SHAKE), gz.wall(half, gz.newton(0.5), motion=SHAKE)
    return gz.Oscillator(alpha=0, k=0, forcing=STILL, walls=box)


@pytest.fixture(scope="module")
def swept():
    grid = W * np.arange(7.0, 17.0, 1.0)
    return gz.response(gz.stroboscopic_map(RIG), "omega", grid, starts=2, transient=200, keep=16)


def test_walls_give_the_momentum_that_spring_and_load_take(swept):
    # over a period m v and u are the same again: A.impulse - B.impulse = T (k^2 mean - offset)
    for front in ("", "branch_"):
        omega = swept.omega if front == "" else swept.branch_omega
        net, mean = swept[f"{front}A.impulse"] - swept[f"{front}B.impulse"], swept[f"{front}mean"]
        held = 2.0 * np.pi / omega * RIG.k**2 * mean
        read = np.isfinite(net.values) & (swept["period"].values > 0 if front == "" else True)
        assert read.sum() > 20
        np.testing.assert_allclose(net.values[read], np.broadcast_to(held, net.shape)[read], atol=2e-12)


def test_what_is_said_of_each_wall_adds_up(swept):
    for front in ("", "branch_", "special_"):
        of = {name: [swept[f"{front}{wall}.{name}"].values for wall in "AB"] for name in BY_WALL}
        for name in ("impulse", "impacts_per_period"):
            np.testing.assert_allclose(swept[f"{front}{name}"].values, sum(of[name]), atol=1e-15)
        np.testing.assert_array_equal(swept[f"{front}impact_speed"].values, np.maximum(*of["impact_speed"]))
    assert swept["A.impulse"].attrs == {
        "long_name": "impulse of wall A in a period of the forcing, per unit of mass", "units": "N s/kg"
    }  # fmt: skip
    assert swept["A.impact_speed"].attrs["long_name"] == "greatest speed of an impact at wall A"


def test_branches_are_followed_through_unstable_orbits_and_their_grazes(swept):
    assert (swept.branch_stable.values == 0).any()
    kinds = set(swept.special_type.values[swept.special_admissible.values == 1])
    assert {"gr", "lp"} <= kinds and set(swept.special_wall.values) >= {"A", "B"}
    unstable = (swept.branch_stable.values == 0) & (swept.branch_admissible.values == 1)
    assert np.isfinite(swept.branch_amplitude.values[unstable]).all()


def test_readings_are_those_of_finely_sampled_motions(swept):
    flown = gz.stroboscopic_map(RIG.replace(omega=float(swept.omega[0]))).iterate((0.0, 0.0), 400)[-1]
    model = RIG.replace(omega=float(swept.omega[0]))
    motion = gz.trajectory(model, flown, until=8 * model.period, samples=20_000)
    found = gauged(model, flown_cycle(model, tuple(flown), 8))
    assert found["amplitude"] == pytest.approx(0.5 * np.ptp(motion.u.values), rel=1e-7)
    assert found["peak_velocity"] == pytest.approx(np.abs(motion.v.values).max(), rel=1e-7)
    mean = np.trapezoid(motion.u.values, motion.t.values) / motion.t.values[-1]
    assert found["mean"] == pytest.approx(mean, rel=1e-5, abs=1e-9)
    for wall in "AB":
        hits = motion.impact_wall.values == wall
        assert found[f"{wall}.impacts_per_period"] == hits.sum() / 8
        assert found[f"{wall}.impact_speed"] == pytest.approx(motion.impact_speed.values[hits].max(), rel=1e-9)


@pytest.mark.parametrize("half", [1.5, 2.0])
def test_the_impact_pair_in_closed_form(half):
    model = pair(half)
    orbit = next(one for one in gz.periodic_orbits(gz.stroboscopic_map(model), word="(BA)", starts=50) if one.symmetric)
    phi = orbit.times[orbit.walls.index("B")]
    speed = 2.0 * (half + np.sin(phi)) / np.pi
    incoming = speed - np.cos(phi)
    numbers = [model.names.index(wall) for wall in orbit.walls]
    state = tuple(orbit.points[0])
    cycle = repeated_cycle(model, state, orbit.times, orbit.incoming, orbit.outgoing, 1, numbers)
    for found in (gauged(model, cycle), gauged(model, flown_cycle(model, state, 1)) if orbit.stable else None):
        if found is not None:
            assert found["amplitude"] == pytest.approx(half + np.sin(phi), rel=1e-12)
            assert found["mean"] == pytest.approx(0.0, abs=1e-12)
            assert [found["rms_velocity"], found["peak_velocity"]] == pytest.approx([speed, speed], rel=1e-12)
            for wall in "AB":
                assert found[f"{wall}.impact_speed"] == pytest.approx(incoming, rel=1e-12)
                assert found[f"{wall}.impulse"] == pytest.approx(2.0 * speed, rel=1e-12)
    assert orbit.outgoing == pytest.approx(0.5 * incoming * np.ones(2), rel=1e-12)


def test_beside_a_period_doubling_all_runs_read_as_the_cycle_that_they_approach():
    # the doubling is at 11.93829 Hz; after 400 periods at 11.9385 Hz impact speeds are still off by a hundredth
    walls = gz.wall("-0.9 mm", gz.newton(0.55)), gz.wall("1.3 mm", gz.newton(0.8))
    P = gz.stroboscopic_map(
        gz.Oscillator.from_si(m=1.35, c=3.8, k=5100, force=4.2, frequency=11.9385, walls=walls)
    )  # fmt: skip
    values = W * np.array([11.9385, 11.94])
    found = gz.response(P, "omega", values, starts=3)
    assert (found.period.values == 1).all() and found.sizes["difference"] == 0
    for i, value in enumerate(values.tolist()):
        (orbit,) = (one for one in gz.periodic_orbits(P.replace(omega=value), 1, starts=40) if one.stable)
        for wall in "AB":
            [hit] = [k for k, letter in enumerate(orbit.walls) if letter == wall]
            speed, after = abs(orbit.incoming[hit]), abs(orbit.outgoing[hit])
            np.testing.assert_allclose(found[f"{wall}.impact_speed"].values[i], speed, rtol=1e-12)
            np.testing.assert_allclose(found[f"{wall}.impulse"].values[i], speed + after, rtol=1e-12)


def test_the_response_of_the_impact_pair_follows_its_symmetric_orbit():
    P, impulse = gz.stroboscopic_map(pair()), 2.0 * (3.0 + 2.0 * np.sin(PHI)) / np.pi
    found = gz.response(P, "A.sigma", [-1.5, -1.4], starts=1, transient=300, keep=8)["B.impulse"]
    assert found.sel(run="start 1").values[0] == pytest.approx(impulse, rel=1e-9)
    assert found.sel(run="up").values.tolist() == [0.0, 0.0]  # from rest in the middle, and no wall reaches it


def test_one_wall_among_walls_reads_as_the_model_with_one_wall():
    law, force = gz.newton(0.7), gz.Forcing(omega=2.8, offset=-0.1, cos=(0.8,), sin=(0.1,))
    below = gz.Oscillator(0.1, 1.0, force, law, sigma=-0.1)
    same = gz.Oscillator(0.1, 1.0, force, walls=[gz.wall(-0.1, law)])
    over = gz.Forcing(omega=2.8, offset=0.1, cos=(-0.8,), sin=(-0.1,))
    turned = gz.Oscillator(0.1, 1.0, over, walls=[gz.wall(0.1, law, "above")])
    grid = [2.5, 2.6]
    one, two, three = (
        gz.response(gz.stroboscopic_map(m), "omega", grid, starts=1, transient=300, keep=8)
        for m in (below, same, turned)
    )
    for name in READINGS:
        kept = one[name].sel(run=["up", "down"]).values
        np.testing.assert_allclose(two[name].sel(run=["up", "down"]).values, kept, atol=1e-12)
        sign = -1.0 if name == "mean" else 1.0
        np.testing.assert_allclose(sign * three[name].sel(run=["up", "down"]).values, kept, atol=1e-12)
    assert "A.impulse" not in two


def test_a_ball_that_rides_on_a_moving_table_moves_as_the_table():
    table = gz.wall(0.3, gz.newton(0.5), motion=gz.Forcing(omega=2.0, sin=(0.1,), cos=()))
    fall = gz.Forcing(omega=1.0, offset=-1.0, cos=())
    model = gz.Oscillator(alpha=0, k=0, forcing=fall, walls=[table])
    at, speed = model.places_at(np.zeros(1))
    found = gauged(model, flown_cycle(model, (float(at[0, 0]), float(speed[0, 0])), 3))
    assert found["amplitude"] == pytest.approx(0.1, rel=1e-12) and found["mean"] == pytest.approx(0.3, rel=1e-12)
    assert found["peak_velocity"] == pytest.approx(0.2, rel=1e-12)
    assert found["rms_velocity"] == pytest.approx(0.2 / np.sqrt(2.0), rel=1e-12)
    assert found["impacts_per_period"] == 0.0
    assert found["impulse"] == pytest.approx(model.period, rel=1e-15)  # the weight is 1


def test_walls_that_leave_no_place_for_a_ball_at_all_values_are_refused():
    swing = gz.Forcing(omega=2.0, cos=(5.0,))
    walls = [gz.wall(at, gz.newton(0.5), motion=swing) for at in (-1.0, 1.0)]
    P = gz.stroboscopic_map(gz.Oscillator(0.1, 1.0, gz.Forcing(2.0), walls=walls))
    with pytest.raises(gz.InputError, match="the walls move so far with t0"):
        gz.response(P, "t0", [0.0, np.pi / 2])


def test_the_shell_and_the_figure(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rig = "--walls A=newton,B=newton A.r=0.8 B.r=0.6 --si m=0.8,c=2.4,k=3200,force=2.5".split()
    places = ["A.gap=0.8 mm", "B.gap=1.2 mm", "--units", "Hz,mm,N s", "--starts", "1", "--transient", "50"]
    assert main(["response", "frequency=14:15:2", *rig, *places, "-o", "response.nc", "-o", "response.png"]) == 0
    assert gz.load("response.nc")["B.impulse"].attrs["units"] == "N s"
    said = capsys.readouterr().out
    assert "in frequency" in said and "omega" not in said


def test_a_reading_that_is_greatest_at_several_values_is_said_to_be(capsys):
    # wherever both stops are hit the amplitude is half of what lies between them, to rounding
    rig = "--walls A=newton,B=newton A.r=0.55 B.r=0.8 --si m=1.35,c=3.8,k=5100,force=4.2".split()
    tokens = ["response", "frequency=2:13:12", *rig, "A.gap=0.9 mm", "B.gap=1.3 mm", "--units", "Hz,mm"]
    assert main([*tokens, "--starts", "1", "--transient", "100", "-q"]) == 0
    out = capsys.readouterr().out
    assert "up    1.1 at " in out and " values of frequency, " in out
    assert main([*tokens, "--starts", "1", "--transient", "100", "-q", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    for way in ("up", "down"):
        read = {row["frequency"]: row["amplitude"] for row in found["swept"] if row["run"] == way}
        [peak] = [row for row in found["peaks"] if (row["run"], row["reading"]) == (way, "amplitude")]
        at = [value for value, amplitude in read.items() if abs(amplitude - 1.1) < 1e-8]
        assert peak["greatest"] == max(read.values()) and 1 < len(at) < len(read)
        assert (peak["frequency"], peak["last"], peak["values"]) == (min(at), max(at), len(at))
        where = f"{len(at)} values of frequency, {min(at):g} to {max(at):g} Hz"
        assert any(line.startswith(way) and f"1.1 at {where}" in line for line in out.splitlines())
