"""A rig with stops on either side: held to an integration of the engineer's own equation, in his own coordinates."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import grazing as gz
from grazing.measured import measured
from grazing.outcome import InputError

M, C, K, W = 0.8, 2.4, 3200.0, 2 * np.pi * 14.0
RIG = {"m": M, "c": C, "k": K, "force": 12.5, "frequency": 14.0}
LOW, HIGH = -0.8e-3, 1.2e-3
STOPS = gz.wall("-0.8 mm", gz.newton(0.8)), gz.wall("1.2 mm", gz.newton(0.6))
LAW = gz.newton(0.7)


def by_hand(until, moves="both", base=0.0, force=12.5, load=0.0):
    """Integrate m x'' = F + load - spring - damper, x upwards, with hits at either stop: time, stop, speed, x after."""
    foot, stop = moves in ("both", "spring"), moves in ("both", "stop")

    def z(t):
        return base * np.cos(W * t)

    def dz(t):
        return -base * W * np.sin(W * t)

    def flow(t, s):
        stretched = s[0] - foot * z(t), s[1] - foot * dz(t)
        return [s[1], (force * np.cos(W * t) + load - K * stretched[0] - C * stretched[1]) / M]

    def low(t, s):
        return s[0] - stop * z(t) - LOW

    def high(t, s):
        return HIGH - (s[0] - stop * z(t))

    for one in (low, high):
        one.terminal, one.direction = True, -1.0
    t, s, hits = 0.0, [stop * z(0.0), stop * dz(0.0)], []
    while t < until:
        leg = solve_ivp(flow, (t, until), s, events=(low, high), rtol=1e-11, atol=1e-14, max_step=2e-3, method="DOP853")
        t, s = leg.t[-1], leg.y[:, -1].copy()
        if leg.status == 1:
            which = 0 if leg.t_events[0].size else 1
            moving = stop * dz(t)
            hits.append((t, which, s[1] - moving))
            s[1] = moving - (0.8, 0.6)[which] * (s[1] - moving)
    return np.array(hits)


@pytest.mark.parametrize(
    "case",
    [{}, {"load": -0.9}, {"base": 1e-3}, {"base": 1e-3, "moves": "spring"}, {"base": -1e-3, "moves": "stop"}],
    ids=str,
)
def test_impacts_are_those_of_the_engineers_equation(case):
    model = gz.Oscillator.from_si(**RIG | case, walls=STOPS)
    flown, own = gz.trajectory(model, (0.0, 0.0), until=0.35), by_hand(0.35, **case)
    assert len(own) >= 5
    assert "".join(flown.impact_wall.values) == "".join("AB"[int(i)] for i in own[:, 1])
    assert flown.impact_time.values == pytest.approx(own[:, 0], abs=1e-8)
    assert flown.v_minus.values == pytest.approx(own[:, 2], abs=1e-6)


def test_one_stop_among_walls_is_the_rig_with_one_stop_in_its_own_x():
    for side, place in (("above", "1.2 mm"), ("below", "-1.2 mm")):
        one = gz.Oscillator.from_si(**RIG, gap="1.2 mm", side=side, reset=LAW)
        walls = gz.Oscillator.from_si(**RIG, walls=[gz.wall(place, LAW, side)])
        plain, between = (measured(gz.trajectory(model, (0.0, 0.0), until=0.5)) for model in (one, walls))
        assert np.array_equal(plain.impact_time.values, between.impact_time.values)
        assert np.array_equal(plain.v_minus.values, between.v_minus.values)
        assert plain.u.values == pytest.approx(between.u.values, abs=1e-17)
        assert plain.u.attrs["symbol"] == between.u.attrs["symbol"] == "x"


def test_results_carry_units_and_convert_to_those_of_the_rig():
    rig = gz.Oscillator.from_si(**RIG, walls=STOPS)
    flown = gz.in_units(gz.trajectory(rig, (0.0, 0.0), until=0.2), "mm", "mm/s", "ms")
    assert {flown[name].attrs["units"] for name in ("u", "wall_position")} == {"mm"}
    assert {flown[name].attrs["units"] for name in ("v", "v_minus", "impact_speed")} == {"mm/s"}
    assert flown.wall_position.values[:, 0].tolist() == pytest.approx([-0.8, 1.2])
    assert flown.u.values.min() == pytest.approx(-0.8) and flown.u.values.max() == pytest.approx(1.2)
    P = gz.stroboscopic_map(rig)
    swept = gz.orbit_diagram(P, "B.sigma", ["1 mm", "1.5 mm"], starts=2, transient=20, keep=3)
    assert swept["B.sigma"].values.tolist() == pytest.approx([1e-3, 1.5e-3], rel=1e-15)
    assert gz.in_units(swept, "mm")["B.sigma"].values.tolist() == pytest.approx([1.0, 1.5])
    assert swept.attrs["mass"] == M
    branch = gz.continuation(P, gz.periodic_orbits(P, word="(BA)", starts=50)[0], "omega", (0.98 * W, 1.02 * W))
    assert branch.dataset.omega.attrs["units"] == "rad/s" and branch.dataset.attrs["mass"] == M


def test_a_base_keeps_its_amplitude_while_the_frequency_varies():
    shaken = gz.Oscillator.from_si(m=M, c=C, k=K, base="1 mm", frequency=14.0, walls=STOPS)
    slower = gz.Oscillator.from_si(m=M, c=C, k=K, base="1 mm", frequency=12.0, walls=STOPS)
    assert shaken.replace(omega="12 Hz").params == pytest.approx(dict(slower.params), rel=1e-15)
    P, Q = gz.stroboscopic_map(shaken), gz.stroboscopic_map(slower)
    found = gz.orbit_diagram(P, "omega", [slower.params["omega"]], [(0.0, 0.0)], transient=30, keep=2)
    own = gz.orbit_diagram(Q, "omega", [slower.params["omega"]], [(0.0, 0.0)], transient=30, keep=2)
    assert np.array_equal(found.u.values, own.u.values)
    with pytest.raises(InputError, match="cos1 is made by the moving base"):
        gz.orbit_diagram(P, "cos1", [0.1, 0.2])
    with pytest.raises(InputError, match="cos1 is made by the moving base"):
        shaken.replace(cos1=3.0)


def test_a_branch_in_the_frequency_follows_the_base():
    shaken = gz.Oscillator.from_si(m=M, c=C, k=K, base="2 mm", frequency=14.0, walls=STOPS)
    P = gz.stroboscopic_map(shaken)
    branch = gz.continuation(P, gz.periodic_orbits(P, period=1, starts=50)[0], "omega", (0.97 * W, 1.03 * W))
    last = list(branch)[-1]
    own = P.replace(omega=last.map.params["omega"])
    assert own.params == last.map.params
    assert own(last.points[0])[0] == pytest.approx(last.points[0], abs=1e-10)


def test_what_belongs_to_one_stop_is_refused_beside_walls():
    for name, value in (("gap", 1e-3), ("reset", LAW), ("side", "below")):
        with pytest.raises(InputError, match=f"walls are given beside {name}"):
            gz.Oscillator.from_si(**RIG, walls=STOPS, **{name: value})
    with pytest.raises(InputError, match="gap is missing"):
        gz.Oscillator.from_si(**RIG, reset=LAW)
    with pytest.raises(InputError, match="has units, and the model has none"):
        gz.Oscillator(alpha=0.1, k=1.0, forcing=gz.Forcing(2.0), walls=STOPS)
    with pytest.raises(InputError, match="units do not match"):
        gz.wall("1.2 s", LAW)
