"""Orbits that rest on the wall: released, chattering to rest, and the onset of complete chatter."""

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.branch import continuation
from grazing.orbits.resting import RestEquations
from grazing.orbits.search_rest import resting_orbits
from grazing.outcome import CHATTER

TWO = gz.Oscillator(
    alpha=0.4, k=0.8, forcing=gz.Forcing(omega=1.3, offset=-0.5, cos=(1.0, 0.2), sin=(0.1,)), sigma=0.2,
    reset=gz.newton(r=0.4),
)  # fmt: skip
MODELS = {
    "standard": (gz.pinball(V=0.0, r=0.3, d=-0.2), "d", (-0.9, 0.3)),
    "in r": (gz.pinball(V=0.0, r=0.3, d=-0.2), "r", (0.0, 0.9)),
    "two harmonics, shifted wall": (TWO, "r", (0.0, 0.95)),
    "trigger": (
        gz.Oscillator(
            alpha=3.0, k=1.0, forcing=gz.Forcing(omega=2.2, offset=-0.2), reset=gz.triggered(r=0.3, V=0.4, trigger=2.0)
        ), "offset", (-0.6, 0.2),
    ),
}  # fmt: skip


def resting(model):
    P = gz.stroboscopic_map(model)
    state = P.iterate((model.sigma + 0.1, 0.0), 80)[-1]
    path = P.orbit(state, 1)
    assert path.outcomes[0] & CHATTER
    return gz.Orbit(
        map=P, points=path.points[:1], word="C", period=1, multipliers=np.zeros(2, complex), admissible=True,
        condition=1.0, residual=0.0,
    )  # fmt: skip


@pytest.mark.parametrize("case", MODELS)
def test_the_onset_of_chatter_is_where_the_map_completes_it_no_longer(case):
    model, name, bounds = MODELS[case]
    orbit = resting(model)
    branch = continuation(orbit.map, orbit, name, bounds)
    onsets = [one for one in branch.special if one.type == "ch"]
    for one in branch:
        assert one.stable and one.admissible and one.residual < 1e-9
    assert onsets
    for onset in onsets:
        assert onset.converged and onset.high - onset.low < 1e-12
        equations = branch.pieces[0].equations
        found = equations.rest(np.array([onset.value]))
        assert abs(found.next - found.accumulation) < 1e-3 * model.period
        inside = onset.value + np.sign(branch.pieces[0].values.mean() - onset.value) * 1e-5
        outside = 2.0 * onset.value - inside
        seen = []
        for value in (inside, outside):  # brute force: the exact map, from anywhere
            P = orbit.map.replace(**{name: value})
            state = P.iterate((model.sigma + 0.1, 0.0), 200)[-1]
            seen.append(bool(np.any(P.orbit(state, 8).outcomes & CHATTER)))
        assert seen == [True, False]


@pytest.mark.parametrize("case", MODELS)
def test_the_accumulation_of_impacts_against_their_times(case):
    """Times of impacts converge geometrically: three of them extrapolate to where they accumulate (Aitken)."""
    model, _name, _bounds = MODELS[case]
    found = next(rest for rest in (RestEquations(model, (), i).rest(np.empty(0)) for i in range(3)) if rest is not None)
    path = gz.trajectory(model, (model.sigma, 0.0), start=found.release, until=found.next)
    a, b, c = path.impact_time.values[-4:-1]
    assert found.accumulation == pytest.approx(c - (c - b) ** 2 / ((c - b) - (b - a)), abs=1e-8 * model.period)
    assert found.impacts >= path.impact_time.size


def test_a_ball_that_begins_at_its_release_flies():
    """At the zero of the forcing where F rises the ball leaves the wall with no speed; this must not take for ever."""
    model = gz.pinball(V=0.0, r=0.3, d=-0.2)
    release = RestEquations(model, (), 0).rest(np.empty(0)).release
    for start in (release, np.nextafter(release, 0.0), np.nextafter(release, 9.0)):
        path = gz.trajectory(model, (0.0, 0.0), start=start, until=start + 2.0 * model.period)
        assert path.impact_time.size > 3 and float(path.u.max()) > 1e-3


def test_an_orbit_that_is_released_elsewhere_is_refused():
    model, _name, _bounds = MODELS["standard"]
    orbit = resting(model)
    moved = gz.Orbit(
        map=orbit.map, points=orbit.points + 0.01, word="C", period=1, multipliers=orbit.multipliers, admissible=True,
        condition=1.0, residual=0.0,
    )  # fmt: skip
    with pytest.raises(gz.InputError, match="it cannot be followed"):
        continuation(orbit.map, moved, "d", (-0.5, 0.0))
    with pytest.raises(gz.InputError, match="at phase 0 only"):
        continuation(orbit.map, orbit, "phase", (0.0, 1.0))


def test_a_ball_that_lies_on_a_moving_wall_is_not_followed():
    """Border collisions were found where it began, and a wall that moves less had the ball inside."""
    force = gz.Forcing(omega=1.3, offset=-1.5, cos=(0.2,))
    wall = gz.wall(-0.5, gz.newton(0.6), motion=gz.Forcing(omega=1.3, cos=(0.03,), sin=(0.04,)))
    P = gz.stroboscopic_map(gz.Oscillator(alpha=0.3, k=0.5, forcing=force, walls=[wall]))
    (orbit,) = gz.periodic_orbits(P, word="S", starts=2)
    for name in ("A.cos1", "A.sin1", "omega"):
        with pytest.raises(gz.InputError, match="rests on a wall when its map looks at it"):
            continuation(P, orbit, name, (0.5 * P.params[name], 1.5 * P.params[name]))
    branch = continuation(P, orbit, "offset", (-2.0, -1.4))  # which does not move the wall
    assert not branch.special and np.ptp(branch.dataset.offset.values) == pytest.approx(0.6)
    with pytest.raises(gz.InputError, match="and sigma moves that wall"):
        continuation(P, orbit, "sigma", (-0.6, -0.3))


# ---- between walls


def walled(turned):
    """The model with two harmonics over one wall among walls, or its mirror image below a wall."""
    f, sign = TWO.forcing, -1.0 if turned else 1.0
    force = gz.Forcing(f.omega, offset=sign * f.offset, cos=sign * np.array(f.cos), sin=sign * np.array(f.sin))
    wall = gz.wall(sign * 0.2, gz.newton(r=0.4), "above" if turned else "below")
    return gz.Oscillator(alpha=0.4, k=0.8, forcing=force, walls=[wall])


@pytest.mark.parametrize("turned", [False, True], ids=["below", "above"])
def test_at_one_wall_of_walls_the_branch_is_that_over_one_wall(turned):
    orbit = resting(TWO)
    known = continuation(orbit.map, orbit, "r", (0.0, 0.95))
    P = gz.stroboscopic_map(walled(turned))
    (found,) = (one for one in gz.periodic_orbits(P, 1, starts=50) if "C" in one.word)
    branch = continuation(P, found, "r", (0.0, 0.95))
    assert [(one.type, one.value) for one in branch.special] == [
        (one.type, pytest.approx(one.value, abs=1e-12)) for one in known.special
    ]
    assert branch.special and [one.word for one in branch] == [one.word for one in known]


def rattle(**more):
    """Between stops that take much speed: pushed to and fro, so that the ball rests on either."""
    walls = gz.wall(-0.3, gz.newton(0.1)), gz.wall(0.3, gz.newton(0.1))
    force = gz.Forcing(omega=1.0, **({"cos": (0.6,)} | more))
    return gz.Oscillator(0.1, 0.5, force, walls=walls)


@pytest.mark.parametrize(("more", "word"), [({"offset": -0.4}, "A"), ({}, "AB")], ids=["one wall", "both"])
def test_between_walls_an_orbit_rests_until_chatter_is_complete_no_longer(more, word):
    model = rattle(**more)
    P = gz.stroboscopic_map(model)
    found = [one for one in gz.periodic_orbits(P, 1, starts=50) if "C" in one.word or "S" in one.word]
    flown = gz.trajectory(model, tuple(found[0].points[0]), until=6 * model.period)
    rested = {str(name) for name, at in zip("AB", flown.wall_position.values, strict=True)
              if (np.isclose(flown.u.values, at) & (flown.v.values == 0.0)).sum() > 10}  # fmt: skip
    assert rested == {*word}
    branch = continuation(P, found[0], "A.r", (0.0, 0.95))
    assert all(one.residual < 1e-9 for one in branch)
    (onset,) = (one for one in branch.special if one.type == "ch")
    assert onset.converged and onset.high - onset.low < 1e-12 and 0.1 < onset.value < 0.95
    rests = []
    for value in (onset.value - 1e-3, onset.value + 1e-3):  # brute force: flights from anywhere
        there = model.replace(**{"A.r": value})
        state = gz.stroboscopic_map(there).iterate((0.0, 0.1), 200)[-1]
        rests.append(gz.trajectory(there, tuple(state), until=8 * model.period).sizes["rest"])
    assert 8 * len(word) <= rests[0] <= 8 * len(word) + 1 and rests[1] < rests[0] - 4


def test_the_rests_of_a_symmetric_orbit_are_half_a_period_apart():
    model = rattle()
    P = gz.stroboscopic_map(model)
    orbit = next(one for one in gz.periodic_orbits(P, 1, starts=50) if "C" in one.word or "S" in one.word)
    equations = continuation(P, orbit, "A.r", (0.05, 0.15)).pieces[0].equations
    found = equations.rest(np.array([0.1]))
    flown = gz.trajectory(model, tuple(orbit.points[0]), until=4 * model.period)
    rests = flown.rest_time.values
    rests = rests[(rests[:, 0] > model.period) & (rests[:, 1] < 3.5 * model.period)]
    assert np.diff(rests[:, 1]) == pytest.approx(np.full(len(rests) - 1, 0.5 * model.period), abs=1e-9)
    assert found.next - found.release == pytest.approx(model.period, abs=1e-9)
    assert found.left == pytest.approx(float((rests[:, 1] - rests[:, 0]).min()), rel=1e-6)


def test_an_orbit_that_is_released_twice_a_period_is_followed_over_one_wall():
    force = gz.Forcing(omega=1.0, offset=-0.6, cos=(0.1, 1.0))
    model = gz.Oscillator(alpha=0.4, k=0.0, forcing=force, reset=gz.newton(r=0.2))
    P = gz.stroboscopic_map(model)
    (orbit,) = [one for one in gz.periodic_orbits(P, 1, starts=50) if "C" in one.word]
    state = tuple(orbit.points[0])
    flown = gz.trajectory(model, state, until=4 * model.period)
    lies = (flown.u.values == 0.0) & (flown.v.values == 0.0)
    assert np.diff(lies.astype(int)).clip(0).sum() == 8  # two rests a period
    branch = continuation(P, orbit, "r", (0.0, 0.9))
    (onset,) = (one for one in branch.special if one.type == "ch")
    assert onset.converged and onset.value > 0.2 and all(one.residual < 1e-9 for one in branch)


def test_a_gap_in_the_rest_between_two_points_of_a_branch_is_an_end(monkeypatch):
    """A step is up to three times as long as this gap: what lies between points is looked at."""
    low, high, true = -0.482, -0.474, RestEquations.broken
    monkeypatch.setattr(RestEquations, "broken", lambda self, x, p: "gap" if low < p[0] < high else true(self, x, p))
    orbit = resting(gz.pinball(V=0.0, r=0.3, d=-0.2))
    branch = continuation(orbit.map, orbit, "d", (-0.9, -0.1))
    assert [(one.type, one.value) for one in branch.special] == [("ch", pytest.approx(high, abs=1e-9))]
    assert min(piece.values.min() for piece in branch.pieces) >= high


def test_a_ball_that_still_lies_on_a_moving_wall_at_the_strobe_is_not_inside_it():
    """A period later the wall is where it was but for rounding: below it, by less or more than a start may be."""
    random = np.random.default_rng(1)
    for omega in random.uniform(0.5, 20.0, 20):
        shake = gz.Forcing(omega=omega, sin=(1.0,), cos=())
        table = gz.wall(0.0, gz.newton(0.5), motion=shake)
        gravity = gz.Forcing(omega=omega, offset=-0.9 * omega**2, cos=())
        ball = gz.Oscillator(alpha=0, k=0, forcing=gravity, walls=[table])
        (orbit,) = resting_orbits(gz.stroboscopic_map(ball), 1)
        assert orbit.period == 1 and orbit.points[0, 0] >= 0.0
