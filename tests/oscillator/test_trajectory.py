"""Trajectories: closed forms, agreement with the reference, and the words of their errors."""

import math

import numpy as np
import pytest

import grazing as gz
from tests.models import MODELS, model_of
from tests.reference import PROBLEMS, advance
from tests.systems.balls import bouncing


def hopping(g=1.0, r=0.5, V=0.0, omega=0.05):
    """A ball under constant gravity: everything about it is known in closed form."""
    return gz.Oscillator(
        alpha=0.0, k=0.0, forcing=gz.Forcing(omega=omega, offset=-g, cos=(0.0,)), reset=gz.active(r, V)
    )


ONE = gz.pinball(d=0.12, V=0.4)
TWO = gz.Oscillator(
    0.2, 1.1, gz.Forcing(omega=1.7), walls=[gz.wall(-0.3, gz.newton(0.8)), gz.wall(0.3, gz.newton(0.8))]
)
TABLE = gz.table([gz.segment("floor", (0, 0), (6, 0), gz.newton(0.9))], rho=0.1, tilt=0.3)
SYSTEM = bouncing()


@pytest.mark.parametrize(
    ("name", "run"),
    [
        ("start", lambda t: gz.trajectory(ONE, (0.1, 0.0), start=t, until=t + 64.0)),
        ("start", lambda t: gz.trajectory(TWO, (0.1, 0.0), start=t, until=t + 64.0)),
        ("start", lambda t: gz.trajectory(TABLE, (1.0, 2.0, 1.5, 0.0), start=t, until=t + 64.0)),
        ("start", lambda t: gz.trajectory(SYSTEM, (0.5, 0.1), start=t, until=t + 64.0)),
        ("phase", lambda t: gz.stroboscopic_map(SYSTEM, phase=t)),
        ("tau", lambda t: gz.impact_map(ONE)((t, 0.5))),
        ("tau", lambda t: gz.impact_map(TWO)((t, 0.5))),
        ("tau", lambda t: gz.impact_map(SYSTEM).orbit((t, 0.0, 0.5), 2)),
    ],
)
@pytest.mark.parametrize("late", [1e17, -1e17])
def test_a_time_at_which_doubles_lie_too_far_apart_is_refused(name, run, late):
    """Such trajectories were *certified*, and such phases were taken for 0."""
    with pytest.raises(gz.InputError, match=rf"^{name} = \S+; allowed is \|{name}\| <= "):
        run(late)


def test_bouncing_ball():
    flown = gz.trajectory(hopping(g=2.0, r=0.5), (1.0, 0.0), until=4.0)
    first = 1.0  # sqrt(2h/g)
    hops = [first]
    v = 0.5 * 2.0
    while len(hops) < 6:
        hops.append(hops[-1] + 2.0 * v / 2.0)
        v *= 0.5
    assert flown.impact_time.values[:6] == pytest.approx(hops, abs=1e-15)
    assert flown.v_minus.values[:3].tolist() == pytest.approx([-2.0, -1.0, -0.5])
    assert flown.v_plus.values[:3].tolist() == pytest.approx([1.0, 0.5, 0.25])
    accumulation = first + 2.0 * 1.0 / 2.0 / (1.0 - 0.5)
    assert flown.impact_time.values[-1] == pytest.approx(accumulation, abs=4e-6)
    assert flown.attrs["chatter"] == 1
    late = flown.t.values > accumulation + 1e-5
    assert (flown.u.values[late] == 0.0).all()
    assert (flown.v.values[late] == 0.0).all()


def test_bumper_has_a_constant_rhythm():
    """r = 0: every hop starts with V and lasts 2V/g."""
    flown = gz.trajectory(hopping(g=1.0, r=0.0, V=0.5), (0.0, 0.5), until=10.5)
    assert np.diff(flown.impact_time.values) == pytest.approx(1.0, abs=1e-14)
    assert flown.u.max() == pytest.approx(0.125, rel=1e-3)


@pytest.mark.parametrize("name", ["standard d=0.12", "under-damped", "three harmonics", "many impacts", "low obstacle"])
def test_impacts_against_the_reference(name):
    problem = PROBLEMS[name]
    m = model_of(problem)
    start = (m.sigma + 0.2, -0.1)
    flown = gz.trajectory(m, start, until=5.0 * m.period)
    exact = [impact for strobe in advance(problem, *start, 5) for impact in strobe.impacts]
    assert len(exact) == flown.sizes["impact"]
    for i, impact in enumerate(exact):
        assert flown.impact_time.values[i] == pytest.approx(float(impact.t), abs=1e-12)
        assert flown.v_minus.values[i] == pytest.approx(float(impact.v_minus), abs=1e-12)


def test_start_in_the_middle_of_a_period_and_off_zero():
    m = MODELS["two harmonics"]
    whole = gz.trajectory(m, (0.5, 0.0), start=-3.0, until=20.0, samples=400)
    at = np.searchsorted(whole.t.values, 4.0)
    t, u, v = (float(whole[name].values[at]) for name in ("t", "u", "v"))
    rest = gz.trajectory(m, (u, v), start=t, until=20.0)
    later = whole.impact_time.values[whole.impact_time.values > t]
    assert rest.impact_time.values == pytest.approx(later, abs=1e-12)


def test_samples_do_not_move_impacts_and_jumps_have_both_sides():
    m = gz.pinball(d=0.12, V=0.4)
    coarse, fine = (gz.trajectory(m, (0.1, 0.0), until=20.0, samples=n) for n in (2, 500))
    assert np.array_equal(coarse.impact_time, fine.impact_time)
    for time, before, after in zip(coarse.impact_time, coarse.v_minus, coarse.v_plus, strict=True):
        there = coarse.v.values[coarse.t.values == time.item()]
        assert there.tolist() == [before.item(), after.item()]


def test_until_cuts_the_last_flight():
    flown = gz.trajectory(gz.pinball(), (0.1, 0.0), until=1.0)
    assert flown.t.values[-1] == 1.0
    assert flown.sizes["impact"] == 0


def test_it_survives_netcdf_types():
    flown = gz.trajectory(gz.pinball(), (0.1, 0.0), until=5.0)
    assert all(isinstance(value, (str, int, float)) for value in flown.attrs.values())
    assert {name: flown[name].attrs["units"] for name in ("t", "u", "v", "impact_time")} == dict.fromkeys(
        ("t", "u", "v", "impact_time"), "1"
    )
    assert flown.trust.item() == "certified"


def test_a_graze_makes_it_ambiguous():
    m = gz.Oscillator(
        alpha=0.0, k=0.0, forcing=gz.Forcing(omega=1.0, offset=2.0, cos=(0.0,)), reset=gz.active(0.8, 0.4)
    )
    flown = gz.trajectory(m, (1.0, -2.0), until=3.0)
    assert flown.trust.item() == "ambiguous"
    assert flown.sizes["impact"] == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (dict(state=(-0.1, 0.0)), r"the ball starts inside the wall: u = -0.1, sigma = 0; start with u >= sigma"),
        (dict(state=(0.1,)), r"state is \(0.1,\); give two numbers \(u, v\)"),
        (dict(state=(0.1, math.nan)), r"v = nan is not finite"),
        (dict(state=("a", 0.0)), r"u = 'a' is not a real number"),
        (dict(state=(0.1, 0.0), start=2.0, until=2.0), r"until = 2 is not after start = 2; give until > start"),
        (dict(state=(0.1, 0.0), start=2.0, until=-1.0), r"until = -1 is not after start = 2"),
        (dict(state=(0.1, 0.0), until=math.inf), r"until = inf is not finite"),
        (
            dict(state=(0.1, 0.0), start=1e17, until=1.1e17),
            r"start = 1e\+17; allowed is \|start\| <= 4.54545e\+14: beyond, doubles are too coarse for what happens "
            r"within 2.85599; take whole periods off",
        ),
        (dict(state=(0.1, 0.0), samples=1), r"samples = 1; allowed is a whole number >= 2"),
        (dict(state=(0.1, 0.0), samples=2.5), r"samples = 2.5; allowed is a whole number >= 2"),
    ],
)
def test_bad_input_is_answered_in_words(arguments, words):
    with pytest.raises(gz.InputError, match=words):
        gz.trajectory(gz.pinball(), **arguments)


def test_unbounded_work_ends_in_words():
    m = hopping(g=1.0, r=1.0)
    with pytest.raises(gz.InputError, match=r"more than 200000 impacts up to t = .*choose an earlier end"):
        gz.trajectory(m, (0.0, 1e-5), until=100.0)


@pytest.mark.parametrize(("d", "until"), [(-0.2, 5.0), (0.12, 5.7), (0.3, 100.0)])
def test_times_never_go_back_and_end_where_they_should(d, until):
    flown = gz.trajectory(gz.pinball(V=0.0, r=0.3, d=d), (0.1, 0.0), until=until)
    assert np.diff(flown.t.values).min() >= 0.0
    assert flown.t.values[-1] == until


@pytest.mark.parametrize("harmonics", [201, 1000])
def test_more_harmonics_than_can_be_compiled_are_refused_by_name(harmonics, monkeypatch):
    """At once, and not as a fault of the reset law, which is what the compiler would say after minutes."""
    monkeypatch.setattr("grazing.oscillator.pointed.law_addresses", lambda *_: pytest.fail("the law is compiled"))
    shaken = gz.Forcing(omega=2.2, offset=0.1, cos=(1.0,) * harmonics)
    model = gz.Oscillator(alpha=3, k=1, forcing=shaken, reset=gz.newton(0.8))
    far = gz.wall(0.0, gz.newton(0.8), motion=gz.Forcing(omega=2.2 * harmonics, cos=(0.1,)))
    moved = gz.Oscillator(alpha=3, k=1, forcing=gz.Forcing(omega=2.2), walls=[far])
    for asked in (lambda: gz.trajectory(model, (0.1, 0.0)), lambda: gz.stroboscopic_map(moved).step((0.2, 0.0))):
        with pytest.raises(gz.InputError, match=f"{harmonics} harmonics; flights are compiled for at most 200"):
            asked()


def test_a_trajectory_too_long_to_hold_is_refused_before_it_is_flown():
    with pytest.raises(gz.InputError, match=r"7e\+07 points are more than 2e\+07; choose an earlier end"):
        gz.trajectory(gz.pinball(d=3.0), (0.1, 0.0), until=1e6)


def test_a_wall_however_far_below_costs_no_digits():
    near, far, lost = (
        gz.trajectory(gz.pinball(sigma=sigma), (0.1, 0.3), until=9.0, samples=5) for sigma in (-1e3, -1e12, -1e100)
    )
    for other in (far, lost):
        assert np.allclose(other.u, near.u, rtol=1e-12, atol=1e-12) and np.allclose(other.v, near.v, atol=1e-12)
    assert lost.wall == lost.attrs["parameter_sigma"] == -1e100
