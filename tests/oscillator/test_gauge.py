"""Readings of a motion: closed forms, the balance of momentum and of energy, and samples as fine as one likes."""

import numpy as np
import pytest

import grazing as gz
from grazing.oscillator.gauge import READINGS, flown_cycle, gauged, repeated_cycle

OSCILLATORS = {
    "the standard set": gz.pinball(d=0.12, V=0.4),
    "under-damped": gz.pinball(alpha=0.2, k=1.0, omega=2.8, d=0.3, V=0.1, r=0.9),
    "no stiffness": gz.pinball(alpha=0.2, k=0.0, omega=1.1, d=-0.3, r=0.6, V=0.3),
    "in resonance": gz.pinball(alpha=0.0, k=1.1, omega=1.1, d=0.1, r=0.4, V=0.0),
    "chatter": gz.pinball(alpha=0.3, k=1.0, omega=1.0, d=-0.5, r=0.5, V=0.0),
    "stiff": gz.pinball(alpha=60.0, k=40.0, omega=1.0, d=-0.3, r=0.9, V=0.2),
    "fast": gz.pinball(alpha=0.02, k=30.0, omega=1.0, d=0.2, r=0.8, V=0.1),
    "two harmonics": gz.Oscillator(
        alpha=0.5, k=1.3, sigma=-0.3, reset=gz.active(r=0.7, V=0.2),
        forcing=gz.Forcing(omega=1.1, t0=0.4, offset=0.2, cos=(1.0, -0.3), sin=(0.1, 0.25)),
    ),
}  # fmt: skip


def response_without_impacts(model):
    """Amplitude of u and of its velocity, and the mean: one harmonic, |k^2 - w^2 + i alpha w|."""
    p = model.params
    size = p["cos1"] / np.hypot(p["k"] ** 2 - p["omega"] ** 2, p["alpha"] * p["omega"])
    return size, size * p["omega"], p[model.offset_name] / p["k"] ** 2


@pytest.mark.parametrize("omega", [1e-3, 0.3, 0.999, 1.0, 2.8, 1e3])
def test_without_impacts_it_is_the_linear_response(omega):
    model = gz.pinball(alpha=0.1, k=1.0, omega=omega, d=20.0)
    [orbit] = gz.periodic_orbits(gz.stroboscopic_map(model), 1, starts=4)
    found = gauged(model, flown_cycle(model, tuple(orbit.points[0]), 3))
    amplitude, speed, mean = response_without_impacts(model)
    assert found["amplitude"] == pytest.approx(amplitude, rel=1e-11)
    assert found["peak_velocity"] == pytest.approx(speed, rel=1e-11)
    assert found["rms_velocity"] == pytest.approx(speed / np.sqrt(2.0), rel=1e-11)
    assert found["mean"] == pytest.approx(mean, rel=1e-14)
    assert [found[name] for name in list(READINGS)[4:]] == [0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("name", OSCILLATORS)
def test_no_sample_is_beyond_the_extremes_and_fine_ones_come_near(name):
    """Parabolas touch the extremes: samples that are h apart miss them by less than h^2/8 of the second derivative."""
    model, periods = OSCILLATORS[name], 4
    state = (model.sigma + 0.3, -0.2)
    found = gauged(model, flown_cycle(model, state, periods))
    per_period = 20_000
    path = gz.trajectory(model, state, until=periods * model.period, samples=per_period)
    t, u, v = path.t.values, path.u.values, path.v.values
    h, rate = model.period / per_period, max(model.alpha, model.k, model.harmonics * model.forcing.omega)
    half, fastest = 0.5 * np.ptp(u), np.abs(v).max()
    tiny = 1e-14 * (1.0 + np.abs(u).max() + fastest)
    force = np.abs([*model.forcing.cos, *model.forcing.sin, model.forcing.offset]).sum()
    push = force + model.alpha * fastest + model.k**2 * np.abs(u).max()  # |u''|
    hasty = rate * force + model.alpha * push + model.k**2 * fastest  # |v''|
    assert half - tiny <= found["amplitude"] <= half + push * h**2 / 8.0 + tiny
    assert fastest - tiny <= found["peak_velocity"] <= fastest + hasty * h**2 / 8.0 + tiny
    T = periods * model.period
    step = np.diff(t)
    mean = (0.5 * (u[1:] + u[:-1]) * step).sum() / T
    square = (0.5 * (v[1:] ** 2 + v[:-1] ** 2) * step).sum() / T
    assert abs(found["mean"] - mean) <= push * h**2 / 12.0 + tiny
    assert abs(found["rms_velocity"] ** 2 - square) <= (push**2 + fastest * hasty) * h**2 / 6.0 + tiny
    assert found["impacts_per_period"] == path.sizes["impact"] / periods
    if path.sizes["impact"]:
        assert found["impact_speed"] == np.abs(path.v_minus).max() > 0.0
        assert found["mean_impact_speed"] == pytest.approx(float(np.abs(path.v_minus).mean()), rel=1e-14)


@pytest.mark.parametrize("name", ["the standard set", "under-damped", "two harmonics"])
def test_momentum_and_energy_balance_over_a_closed_orbit(name):
    """Integrated over a cycle, impulses carry what force and spring leave, and damping and impacts take its work.

    With u'' = f - alpha u' - k^2 u: impulse/T = k^2 mean - offset, and alpha rms^2 T + sum (v-^2 - v+^2)/2 = the work
    of the force, which samples of its power give by the trapezoidal rule.
    """
    model = OSCILLATORS[name]
    P = gz.stroboscopic_map(model)
    diagram = gz.orbit_diagram(P, "r", [model.params["r"]], starts=20, transient=3000)
    chosen = np.flatnonzero(diagram.period.values[0] >= 1)[0]
    N = int(diagram.period.values[0, chosen])
    state = float(diagram.u.values[0, chosen, -1]), float(diagram.v.values[0, chosen, -1])
    found = gauged(model, flown_cycle(model, state, N))
    spring = model.k**2 * found["mean"] - model.forcing.offset
    assert found["impulse"] / model.period == pytest.approx(spring, rel=1e-7)
    path = gz.trajectory(model, state, until=N * model.period, samples=4000)
    lost = 0.5 * float((path.v_minus**2 - path.v_plus**2).sum())
    f, t = model.forcing, path.t.values
    waves = [c * np.cos(j * f.omega * (t + f.t0)) + s * np.sin(j * f.omega * (t + f.t0))
             for j, (c, s) in enumerate(zip(f.cos, f.sin, strict=True), 1)]  # fmt: skip
    power = (f.offset + sum(waves)) * path.v.values
    work = (0.5 * (power[1:] + power[:-1]) * np.diff(t)).sum()
    damped = model.alpha * found["rms_velocity"] ** 2 * N * model.period
    assert damped + lost == pytest.approx(work, abs=1e-5 * (damped + abs(lost)))


def test_an_orbit_of_impacts_reads_as_it_flies():
    model = gz.pinball(d=0.12, V=0.4)
    orbit = next(one for one in gz.one_impact_orbits(model, 3) if one.stable)
    closed = gz.continuation(orbit.map, orbit, "d", (0.11, 0.121)).at(0.12)[0]
    one = gauged(model, repeated_cycle(model, (0.0, 0.0), closed.times, closed.incoming, closed.outgoing, 3))
    other = gauged(model, flown_cycle(model, tuple(closed.points[0]), 3))
    for name in READINGS:
        assert one[name] == pytest.approx(other[name], rel=1e-12), name
    assert one["impacts_per_period"] == 1.0 / 3.0 and one["impact_speed"] == -closed.incoming[0]


def test_a_graze_reads_as_one_whatever_rounding_says():
    """Where the response touches the wall, the gap is its amplitude; flown, it hits at some 1e-9 or it does not."""
    model = gz.pinball(alpha=0.1, k=1.0, omega=2.0, d=0.0, V=0.0, sigma=-1.0 / np.hypot(3.0, 0.2))
    size, speed, _mean = response_without_impacts(model)
    u, v = size * -3.0 / np.hypot(3.0, 0.2), size * 2.0 * 0.2 / np.hypot(3.0, 0.2)
    none = np.empty(0)
    found = gauged(model, repeated_cycle(model, (u, v), none, none, none, 2))
    assert found["amplitude"] == pytest.approx(size, rel=1e-15) and found["impacts_per_period"] == 0.0
    assert found["peak_velocity"] == pytest.approx(speed, rel=1e-15)


def test_of_a_ball_that_lies_still_the_wall_alone_is_read():
    model = gz.pinball(d=-3.0, V=0.0, sigma=0.25)
    found = gauged(model, flown_cycle(model, (0.25, 0.0), 2))
    pressed = pytest.approx(3.25 * model.period, rel=1e-15)  # by the load, 3, and the spring
    assert found == {**dict.fromkeys(READINGS, 0.0), "mean": 0.25, "impulse": pressed}


def test_what_no_memory_holds_is_refused():
    model = gz.pinball(alpha=1e15, k=1.0, d=0.1)
    with pytest.raises(gz.InputError, match=r"one motion would take .* its flights change too fast"):
        gauged(model, flown_cycle(model, (0.5, 0.0), 1))


@pytest.mark.parametrize("walls", ["one", "two", "moving"])
def test_a_wall_gives_a_ball_that_lies_on_it_what_spring_and_load_take(walls):
    """Over a cycle the impulses, upwards, are the integral of k^2 u - f, as they are where impacts are all."""
    moves = gz.Forcing(omega=1.0, cos=(0.05,), sin=(0.02,)) if walls == "moving" else None
    made = gz.wall(-0.3, gz.newton(0.1), motion=moves), gz.wall(0.3, gz.newton(0.1))
    model = gz.Oscillator(alpha=0.1, k=0.5, forcing=gz.Forcing(omega=1.0, offset=-0.02, cos=(0.6,)), walls=made)
    model = gz.pinball(V=0.0, r=0.3, d=-0.2) if walls == "one" else model
    state = tuple(gz.stroboscopic_map(model).orbit((0.1, 0.0), 20).points[-1])
    cycle = flown_cycle(model, state, 1)
    assert set(cycle.rides[:, 2]) == set(range(len(model.walls)))
    found = gauged(model, cycle)
    net = found["impulse"] if walls == "one" else found["A.impulse"] - found["B.impulse"]
    taken = model.k2 * found["mean"] - model.forcing.offset
    assert net == pytest.approx(model.period * taken, rel=1e-9)
