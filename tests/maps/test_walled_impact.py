"""The impact map between walls: trajectories, laws of area, closed forms, and the stroboscopic map's orbits."""

import math
from itertools import pairwise

import numpy as np
import pytest

import grazing as gz
from grazing.cli import main
from grazing.maps.hits import LATER
from grazing.outcome import NO_IMPACT, STUCK, InputError

SHAKE = gz.Forcing(omega=1.0, sin=(1.0,), cos=())
STILL = gz.Forcing(omega=1.0, cos=())
#: Of the symmetric orbit of the impact pair, r = 0.5, half a gap of 1.5: cos phi + 2 s sin phi = -3 s, s = 1/(3 pi).
PHI = 2.0965418499633213
SWING = gz.Forcing(omega=2.8, cos=(0.1,))
FORCE = gz.Forcing(omega=2.0, offset=0.05, cos=(2.0, 0.1), sin=(0.0, 0.3))


def pair(half=1.5):
    box = gz.wall(-half, gz.newton(0.5), motion=SHAKE), gz.wall(half, gz.newton(0.5), motion=SHAKE)
    return gz.Oscillator(alpha=0, k=0, forcing=STILL, walls=box)


def rattle(**more):
    swing = gz.Forcing(omega=2.0, cos=(0.05,), sin=(0.1,))
    walls = gz.wall(-0.5, gz.newton(0.8), motion=swing), gz.wall(0.5, gz.active(0.6, 0.1))
    return gz.Oscillator(alpha=0.1, **({"k": 0.5} | more), forcing=FORCE, walls=walls)


MODELS = {
    "a moving wall and one at rest": rattle(),
    "negative stiffness and damping": gz.Oscillator(
        alpha=-0.02, stiffness=-0.3, forcing=FORCE, walls=[gz.wall(x, gz.newton(0.5)) for x in (-0.5, 0.6)]
    ),
    "impact pair": pair(),
    "one above": gz.Oscillator(
        0.1, 1.0, gz.Forcing(2.8, offset=0.3), walls=[gz.wall(0.4, gz.active(0.7, 0.3), "above", motion=SWING)]
    ),
    "table": gz.Oscillator(
        0, 0, gz.Forcing(1.0, offset=-1.0, cos=()),
        walls=[gz.wall(0.0, gz.newton(0.85), motion=gz.Forcing(1.0, sin=(2.0,), cos=()))],
    ),
}  # fmt: skip


def state_of(model, tau, v):
    """Position and velocity of a ball that has just left a wall."""
    wall = len(model.walls) - 1 if math.copysign(1.0, v) < 0.0 else 0
    at, speed = model.places_at(np.array([tau]))
    return float(at[wall, 0]), float(speed[wall, 0]) + v


@pytest.mark.parametrize("name", MODELS)
def test_steps_are_the_impacts_of_trajectories(name):
    model = MODELS[name]
    Q, v = gz.impact_map(model), model.walls[0].sign * 0.7
    orbit = Q.orbit((0.3, v), 12)
    flown = gz.trajectory(model, state_of(model, 0.3, v), start=0.3, until=0.3 + 14 * model.period)
    n = min(12, flown.sizes["impact"])
    assert n >= 8
    times = flown.impact_time.values[:n]
    _at, speed = model.places_at(times)
    walls = [model.names.index(wall) for wall in flown.impact_wall.values[:n]]
    after = flown.v_plus.values[:n] - speed[walls, np.arange(n)]
    assert orbit.points[1 : n + 1, 1] == pytest.approx(after, abs=1e-7)
    apart = np.angle(np.exp(2j * np.pi * (orbit.points[1 : n + 1, 0] - times) / model.period))
    assert np.abs(apart).max() < 1e-7
    strobes = np.cumsum(orbit.letters % LATER)[:n]
    assert strobes.tolist() == np.floor(times / model.period).astype(int).tolist()
    assert (orbit.letters[:n] // LATER).tolist() == walls if len(model.walls) > 1 else max(orbit.letters) < LATER


@pytest.mark.parametrize("name", MODELS)
def test_jacobians_are_those_of_differences_and_keep_the_law_of_area(name):
    model = MODELS[name]
    Q, checked = gz.impact_map(model), 0
    path = Q.orbit((0.3, model.walls[0].sign * 0.7), 12).points
    for state, after in pairwise(path):
        J, h = Q.jacobian(state), 1e-6
        if not np.isfinite(J).all():
            continue
        sides = [Q(state + sign * step)[0] for step in np.eye(2) * h for sign in (1.0, -1.0)]
        slopes = np.column_stack([(sides[0] - sides[1]) / (2 * h), (sides[2] - sides[3]) / (2 * h)])
        if np.abs(sides[0] - after).max() < 0.1:  # not across a strobe
            assert J == pytest.approx(slopes, rel=2e-4, abs=2e-4 * np.abs(J).max())
            checked += 1
        start = state_of(model, *state)
        flown = gz.trajectory(model, start, start=state[0], until=state[0] + 3 * model.period)
        time = float(flown.impact_time[0]) - state[0]
        law = model.walls[int(model.names.index(str(flown.impact_wall.values[0])))].law
        r = law.params["r"]
        area = r * abs(state[1]) / float(flown.impact_speed[0]) * math.exp(-model.alpha * time)
        assert abs(np.linalg.det(J)) == pytest.approx(area, rel=1e-6)
    assert checked >= 5


def test_the_orbits_are_those_of_the_stroboscopic_map():
    model = gz.Oscillator(
        alpha=0.1, k=0.5, forcing=gz.Forcing(omega=2.0, cos=(2.0,)),
        walls=(gz.wall(-0.5, gz.newton(0.8)), gz.wall(0.5, gz.newton(0.6))),
    )  # fmt: skip
    Q, P = gz.impact_map(model), gz.stroboscopic_map(model)
    seen = gz.periodic_orbits(Q, range(1, 4), starts=1000)
    strobed = gz.periodic_orbits(P, 1, starts=1000)
    own = [orbit for orbit in seen if sum(int(s or 0) for s in orbit.word.replace("B", "A").split("A")[:-1]) == 1]
    assert len(own) == len(strobed) == 3
    for orbit in own:
        J = np.linalg.multi_dot([Q.jacobian(point) for point in orbit.points[::-1]])
        assert np.sort(np.linalg.eigvals(J)) == pytest.approx(np.sort(orbit.multipliers), rel=1e-7)
        twins = [one for one in strobed if np.allclose(np.sort(one.multipliers), np.sort(orbit.multipliers), rtol=1e-8)]
        assert len(twins) == 1 and len(twins[0].times) == orbit.period
        walls = "".join(letter for letter in orbit.word if letter in "AB")
        assert sorted(walls) == sorted(twins[0].walls)
        assert Q.orbit(orbit.points[0], orbit.period).points[-1] == pytest.approx(orbit.points[0], abs=1e-9)


def test_the_impact_pair_in_closed_form():
    found = next(one for one in gz.periodic_orbits(gz.impact_map(pair()), word="A1B", starts=500) if one.stable)
    speed = (3 + 2 * np.sin(PHI)) / np.pi
    upper = found.points[np.argmin(found.points[:, 1])]
    assert upper == pytest.approx([PHI, -(speed + np.cos(PHI))], rel=1e-12)
    assert found.points.sum(axis=0) == pytest.approx([2 * PHI + np.pi, 0.0], abs=1e-12)
    roots = next(
        one for one in gz.periodic_orbits(gz.stroboscopic_map(pair()), word="(BA)", starts=50) if one.stable
    ).multipliers
    assert found.multipliers == pytest.approx(roots, rel=1e-10)


def test_a_branch_of_the_map_is_that_of_the_oscillator_and_breaks_its_symmetry():
    Q = gz.impact_map(pair())
    orbit = next(one for one in gz.periodic_orbits(Q, word="A1B", starts=500) if one.stable)
    branch = gz.continuation(Q, orbit, "B.sigma", (0.9, 1.6))
    phi = math.pi + math.atan(-2 * 1.5 / (math.pi * 0.5))
    L = (math.pi**2 / 2 - 2) * math.sin(phi)
    (point,) = (one for one in branch.special if one.type == "bp")
    assert point.value == pytest.approx(L - 1.5, rel=1e-9)


def test_exponents_of_time_are_those_of_the_stroboscopic_map():
    chaotic, orbit = rattle(), gz.periodic_orbits(gz.impact_map(pair()), word="A1B", starts=500)[0]
    P = gz.stroboscopic_map(pair())
    strobed = next(one for one in gz.periodic_orbits(P, word="(BA)", starts=50) if one.stable)
    cases = [(chaotic, "k", 0.5, 2, 2, 0.05), (pair(), "B.sigma", 1.5, orbit.points[:1], strobed.points[:1], 1e-8)]
    for model, name, value, first, second, close in cases:
        found = [
            gz.lyapunov(M, name, [value], starts=starts, transient=500, steps=20_000, keep=16)
            for M, starts in ((gz.impact_map(model), first), (gz.stroboscopic_map(model), second))
        ]
        rate = [one.exponent.values[0, 0] / one.return_time.values[0, 0] for one in found]
        assert rate[0] == pytest.approx(rate[1], rel=close)
        assert found[0].return_time.values[0, 0] == pytest.approx(math.pi, rel=1e-9) or model is chaotic


def test_basins_densities_and_diagrams_have_words_of_walls():
    Q = gz.impact_map(pair())
    basins = gz.basins(Q, {"tau": np.linspace(0.0, 6.0, 12), "v_plus": np.linspace(-2.0, 2.0, 11)}, transient=100)
    assert "A1B" in basins.word.values
    dense = gz.density(gz.impact_map(rattle()), "k", [0.5], coordinate="v_plus", starts=4, keep=100, bins=16)
    side = dense["count"].sel(k=0.5).groupby(dense["v_plus"] > 0.0).sum().values
    assert (side > 100).all() and side.sum() <= 400  # impacts with either wall
    diagram = gz.orbit_diagram(Q, "B.sigma", [1.4, 1.5], starts=3, transient=300, keep=8)
    assert "A1B" in diagram.word.values


def test_a_ball_that_lies_is_released_at_the_wall_that_held_it():
    force = gz.Forcing(omega=1.0, cos=(1.0,))
    walls = [gz.wall(-2.0, gz.newton(0.3)), gz.wall(2.0, gz.newton(0.3))]
    model = gz.Oscillator(alpha=0.2, k=0.0, forcing=force, walls=walls)
    Q = gz.impact_map(model)
    for at, lifted in ((0.0, 1.5 * np.pi), (-0.0, 0.5 * np.pi)):  # when the force turns upwards, or downwards
        orbit = Q.orbit((lifted - 0.5, at), 1)
        assert orbit.outcomes[0] & STUCK
        assert orbit.points[1] == pytest.approx([lifted, 0.0], abs=1e-12)
        assert math.copysign(1.0, orbit.points[1, 1]) == math.copysign(1.0, at)
        assert Q.letters.symbol(int(orbit.letters[0])) == ("A" if math.copysign(1.0, at) > 0.0 else "B")


def test_what_a_wrong_call_is_told():
    Q = gz.impact_map(pair())
    with pytest.raises(InputError, match="passes no strobe"):
        gz.periodic_orbits(Q, word="AB")
    with pytest.raises(InputError, match="allowed are A, B, with the strobes passed in front: 1B"):
        gz.periodic_orbits(Q, word="A1C")
    one = gz.impact_map(MODELS["one above"])
    with pytest.raises(InputError, match=r"v_plus = 0.5 points into the wall; .* v_plus <= 0"):
        one.orbit((0.0, 0.5), 1)
    away = gz.Oscillator(alpha=0, k=0, forcing=STILL, walls=[gz.wall(0.0, gz.newton(0.5))])
    assert gz.impact_map(away).orbit((0.0, 1.0), 1).outcomes[0] & NO_IMPACT
    with pytest.raises(InputError, match=r"model is .* oscillator"):
        gz.impact_map(3)


def test_the_shell(capsys):
    walls = "--walls A=newton,B=newton --alpha 0.1 --k 0.5 --omega 2 --cos 2 A.sigma=-0.5 A.r=0.8 B.sigma=0.5 B.r=0.6"
    assert main(["orbit", "--map", "impact", *walls.split(), "--period", "2", "--starts", "300"]) == 0
    assert "1AB" in capsys.readouterr().out
    assert main(["cobweb", "--map", "impact", *walls.split(), "tau=0", "v_plus=1"]) == 2
