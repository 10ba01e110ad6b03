"""Finder and checker fly by different methods: they must enclose the same flights, and mpmath's."""

import mpmath
import numpy as np
import pytest
from flint import arb, ctx

import grazing as gz
from grazing.proof.flow import MOST_STEPS, Flow, TooLong
from grazing_checker.flight import Checked, Motion, Path, exceeds, transition
from tests.models import PLAIN, THREE

NAMES = ("critical", "under-damped", "undamped, no stiffness", "near resonance", "stiff", "three harmonics", "soft")


@pytest.fixture(autouse=True)
def precision():
    with ctx.workprec(256):
        yield


def motion_of(model, name=None):
    p = {key: arb(x) for key, x in model.params.items()}
    js = range(1, model.harmonics + 1)
    known = "offset" if name == model.offset_name else name
    slopes = {} if name is None else {"k2": 2 * p["k"]} if name == "k" else {known: arb(1)}
    return Motion(
        p["alpha"], p["k"] ** 2, p["omega"], p["t0"], p[model.offset_name], p["sigma"],
        [p[f"cos{j}"] for j in js], [p[f"sin{j}"] for j in js], slopes,
    )  # fmt: skip


def flown(model, t, v, L):
    """Position above the wall and velocity after a flight from the wall, by mpmath's Taylor integrator."""
    with mpmath.workdps(30):
        f = model.forcing

        def force(s):
            total = mpmath.mpf(f.offset) - mpmath.mpf(model.k) ** 2 * model.sigma
            for j, (c, d) in enumerate(zip(f.cos, f.sin, strict=True), start=1):
                phase = j * f.omega * (s + f.t0)
                total += c * mpmath.cos(phase) + d * mpmath.sin(phase)
            return total

        solution = mpmath.odefun(
            lambda s, x: [x[1], force(s) - model.alpha * x[1] - mpmath.mpf(model.k) ** 2 * x[0]], t, [0, v]
        )
        y, w = solution(mpmath.mpf(t) + L)
        return arb(str(y)), arb(str(w))


@pytest.mark.parametrize("name", NAMES)
def test_both_ways_of_flying_enclose_the_same_flight(name):
    model = PLAIN[name]
    rng = np.random.default_rng(3)
    flow, flights = Flow(model), Checked(motion_of(model))
    for _ in range(4):
        t, v, L = rng.uniform(0, 5), rng.uniform(-1, 1), rng.uniform(0.1, 9)
        found = flow.read(flow.fly(flow.start(arb(t), arb(0), arb(v)), arb(t), arb(L)))
        other = Path(flights, arb(t), arb(0), arb(v), arb(L))
        for a, b in ((found.y, other.y), (found.v, other.v)):
            assert a.overlaps(b)
            assert max(a.rad(), b.rad()) < 1e-25
        for a, b in zip(flow.transition(arb(L)), transition(flights, arb(L)), strict=True):
            assert a.overlaps(b)
            assert max(a.rad(), b.rad()) < 1e-25


@pytest.mark.parametrize("name", ["critical", "three harmonics"])
def test_flights_agree_with_an_integrator(name):
    model = PLAIN[name]
    flow = Flow(model)
    y, v = flown(model, 0.3, 0.7, 0.6)
    found = flow.read(flow.fly(flow.start(arb(0.3), arb(0), arb(0.7)), arb(0.3), arb(0.6)))
    assert abs(found.y - y) < 1e-20
    assert abs(found.v - v) < 1e-20


def model_with_all():
    return gz.Oscillator(alpha=0.5, k=1.3, forcing=THREE, sigma=-0.3, reset=gz.newton(r=0.7))


@pytest.mark.parametrize("name", [name for name in model_with_all().params if name != "r"])
def test_derivatives_by_every_parameter_agree_with_each_other_and_with_differences(name):
    model = model_with_all()
    t, v, L, value = arb(0.4), arb(0.6), arb(7.3), arb(model.params[name])

    def at(p):
        flow = Flow(model, name, p, derivative=True)
        return flow.read(flow.fly(flow.start(t, arb(0), v), t, L))

    found, h = at(value), arb(2) ** -60
    above, beneath = at(value + h), at(value - h)
    for slope, difference in ((found.dy, above.y - beneath.y), (found.dv, above.v - beneath.v)):
        assert abs(slope - difference / (2 * h)) < 1e-28
    path = Path(Checked(motion_of(model, name), sensitive=True), t, arb(0), v, L)
    assert path.dy.overlaps(found.dy)
    assert path.dv.overlaps(found.dv)
    assert path.dy.rad() < 1e-25


def test_balls_hold_the_flights_of_their_points():
    model = PLAIN["under-damped"]
    flow, flights = Flow(model), Checked(motion_of(model))
    t, v, L = arb(0.5, 1e-8), arb(0.3, 1e-8), arb(3.0, 1e-8)
    wide = flow.read(flow.fly(flow.start(t, arb(0), v), t, L)), Path(flights, t, arb(0), v, L)
    rng = np.random.default_rng(1)
    for _ in range(20):
        a, b, c = (x.mid() + arb(s) * x.rad() for x, s in zip((t, v, L), rng.uniform(-1, 1, 3), strict=True))
        thin = flow.read(flow.fly(flow.start(a, arb(0), b), a, c))
        for one in wide:
            assert one.y.contains(thin.y)
            assert one.v.contains(thin.v)
    assert max(one.y.rad() for one in wide) < 1e-4


def test_cells_hold_the_flight_inside():
    flow = Flow(PLAIN["three harmonics"])
    h = arb(flow.reach)
    z = flow.start(arb(0.2), arb(0.1), arb(-0.4))
    around = flow.cell(h) * z
    for share in np.linspace(0, 1, 9):
        inside = flow.step(h * float(share)) * z
        assert all(around[i, 0].contains(inside[i, 0]) for i in range(flow.size))


def test_bounds_are_proven_where_they_hold_and_only_there():
    path = Path(Checked(motion_of(gz.pinball(d=0.2))), arb(0), arb(0.5), arb(0), arb(6.0))
    grid = [path.at(arb(float(s))) for s in np.linspace(0, 6, 4001)]
    least = min(float(y) for y in grid)
    zero, end = arb(0), arb(6.0)
    assert exceeds(path, zero, end, 0, arb(least - 1e-6))
    assert not exceeds(path, zero, end, 0, arb(least + 1e-12))
    fastest = max(float(path.at(arb(float(s)), 1)) for s in np.linspace(0, 6, 4001))
    assert exceeds(path, zero, end, 1, arb(-fastest - 1e-5), sign=-1)
    assert not exceeds(path, zero, end, 1, arb(-fastest + 1e-9), sign=-1)
    assert exceeds(path, zero, end, 2, arb(-2.0))


def test_a_flight_of_too_many_time_scales_is_given_up():
    flow = Flow(gz.pinball(alpha=1e6))
    with pytest.raises(TooLong):
        flow.fly(flow.start(arb(0), arb(0), arb(1)), arb(0), arb(MOST_STEPS))
