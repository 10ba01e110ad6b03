"""Where starts are drawn: in the model's own units of length and time, and far enough to find what there is."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import grazing as gz
from tests.examples import examples

NUMBERS = st.floats(0.05, 20.0)
MODELS = st.fixed_dictionaries(
    {
        "alpha": st.one_of(st.just(0.0), NUMBERS),
        "k": st.one_of(st.just(0.0), NUMBERS),
        "omega": NUMBERS,
        "t0": st.floats(-3.0, 3.0),
        "offset": st.integers(-2000, 2000).map(lambda n: n / 100),
        "sigma": st.one_of(st.just(0.0), st.sampled_from([-5.0, -0.1, 2.0])),
        "cos": st.lists(st.integers(-50, 50).map(lambda n: n / 10), min_size=1, max_size=3),
        "sin": st.lists(st.integers(-50, 50).map(lambda n: n / 10), max_size=3),
        "law": st.sampled_from(["newton", "active", "triggered", "own"]),
        "r": st.floats(0.0, 1.0),
        "V": st.one_of(st.just(0.0), NUMBERS),
    }
)


def soft(v, p):
    return -p.r * v / (1.0 - p.c * v)


def made(g, length=1.0, time=1.0):
    """The same machine where a length is written as ``length`` times its number, and a time as ``time`` times."""
    speed, force = length / time, length / time**2
    law = {
        "newton": lambda: gz.newton(g["r"]),
        "active": lambda: gz.active(g["r"], g["V"] * speed),
        "triggered": lambda: gz.triggered(g["r"], g["V"] * speed, 0.1 * speed),
        "own": lambda: gz.reset(soft, r=g["r"], c=0.5 / speed),
    }[g["law"]]()
    forcing = gz.Forcing(
        g["omega"] / time, g["t0"] * time, g["offset"] * force,
        tuple(c * force for c in g["cos"]), tuple(s * force for s in g["sin"]),
    )  # fmt: skip
    return gz.Oscillator(g["alpha"] / time, g["k"] / time, forcing, law, g["sigma"] * length)


def maps_of(model):
    return gz.stroboscopic_map(model, 0.3 * model.period), gz.impact_map(model), gz.discontinuity_map(model)


@settings(deadline=None, max_examples=examples(150))
@given(MODELS, st.sampled_from([(1e3, 1.0), (2.0**-20, 1.0), (1.0, 1e3), (1e-3, 60.0)]))
def test_boxes_have_the_units_of_the_model(given_, units):
    length, time = units
    kicked = given_["V"] > 0.0 and given_["law"] in ("active", "triggered")
    assume(kicked or given_["offset"] != 0.0 or given_["sigma"] != 0.0 or any(given_["cos"]) or any(given_["sin"]))
    for P, Q, scale in zip(maps_of(made(given_)), maps_of(made(given_, *units)), SCALES(length, time), strict=True):
        low, high = np.array(P.box) * scale, np.array(Q.box)
        np.testing.assert_allclose(
            high, low, rtol=1e-9, atol=0 if time == 1.0 and length < 1.0 else 1e-12 * abs(low).max()
        )
        if units == (2.0**-20, 1.0):
            np.testing.assert_array_equal(high, low)  # no rounding hides in a power of two


def SCALES(length, time):
    state = np.array([[length], [length / time]])
    return state, np.array([[time], [length / time]]), state


@settings(deadline=None, max_examples=examples(60))
@given(MODELS)
def test_boxes_are_finite_and_those_of_the_map_made_again(given_):
    model = made(given_)
    for P in maps_of(model):
        box = np.array(P.box)
        assert np.isfinite(box).all() and (box[:, 0] < box[:, 1]).all()
        rows = np.array([[*(P.params | {"omega": omega, "sigma": 0.5}).values()] for omega in (0.7, 1.9)])
        again = [P.replace(omega=omega, sigma=0.5).box for omega in (0.7, 1.9)]
        np.testing.assert_array_equal(P.origin.boxes(rows), again)


@pytest.mark.parametrize("size", [1e-140, 1e-60, 1e60, 1e100])
def test_boxes_of_numbers_of_any_size_are_boxes(size):
    for alpha, k, omega, force, sigma in np.random.default_rng(3).choice([0.0, 1.0, size], (40, 5)):
        if not 1e-60 <= omega <= 1e60 or max(alpha, k) > 1e60 or force * max(1.0, omega) > 1e150:
            continue  # refused
        model = gz.Oscillator(alpha, k, gz.Forcing(omega, offset=force, cos=(force,)), gz.active(0.5, force), sigma)
        for P in maps_of(model):
            assert np.isfinite(P.box).all() and all(low < high for low, high in P.box)


def test_the_pinball_keeps_its_boxes():
    """The paper's figures are drawn from starts in them; its unit of length is that of its force, 1."""
    for model in (gz.pinball(), gz.pinball(V=0.0, d=-3.0, k=0.2), gz.pinball().replace(d=0.3, alpha=0.1, cos1=1.0)):
        strobe, impact, local = maps_of(model)
        assert strobe.box == strobe.replace(r=0.1).box == ((0.001, 0.1), (-0.3, 0.3))
        assert impact.box == ((0.0, model.period), (0.0, 1.0))
        assert local.box == ((0.0, 0.1), (-0.3, 0.3))
    width = 4.0 * gz.pinball(omega=50.0).period ** 2
    assert gz.stroboscopic_map(gz.pinball(omega=50.0)).box == ((1e-3 * width, 0.1 * width), (-0.3 * width, 0.3 * width))
    same = gz.Oscillator(3.0, 1.0, gz.Forcing(2.2, offset=0.12), gz.active(0.8, 0.4))
    assert gz.stroboscopic_map(same).box != gz.stroboscopic_map(gz.pinball()).box


def test_the_default_starts_find_all_five_attractors_of_a_bouncing_ball():
    forcing = gz.Forcing(omega=1, offset=-1, cos=(1.02,))
    P = gz.stroboscopic_map(gz.Oscillator(alpha=0, k=0, forcing=forcing, reset=gz.newton(0.85)))
    for seed in (0, 1):
        found = gz.coexistence(P, "r", [0.85], starts=200, transient=300, keep=64, seed=seed)
        assert {"C", "1", "01", "001", "021"} <= {*found.word.values.tolist()}


RIG = dict(alpha=0.1, k=1.0, omega=2.8, t0=0.0, offset=0.0, sigma=-0.1, cos=[1.0], sin=[], law="newton", r=0.9, V=0.0)


def told(model):
    """What studies and searches say of a model, but for its units: words, periods, shares, multipliers."""
    P = gz.stroboscopic_map(model)
    shares = gz.coexistence(P, "r", [0.5, 0.8], starts=40, transient=400, keep=48)
    found = gz.periodic_orbits(P, [1, 2], starts=100)
    low, high = np.array(P.box).T
    grid = {"u": np.linspace(low[0], high[0], 8), "v": np.linspace(low[1], high[1], 8)}
    reached = gz.basins(P, grid, transient=300, keep=32)
    windows = gz.windows(model.replace(r=0.6), "omega", N=[1, 2], span=None, samples=60)
    yield shares.word.values.tolist(), shares.share.values.tolist(), shares.period.values.tolist()
    yield [(orbit.word, orbit.admissible, orbit.stable, orbit.multipliers.tolist()) for orbit in found]
    yield [(orbit.word, orbit.admissible, orbit.phase) for N in (1, 2, 3) for orbit in gz.one_impact_orbits(model, N)]
    yield reached.basin.values.tolist(), reached.word.values.tolist()
    yield windows.N.values.tolist(), windows.low.values.tolist(), windows.low_type.values.tolist()


def test_a_machine_means_the_same_in_every_unit_of_length():
    """A power of two rounds nothing: every number agrees to the bit, unless something has a length of its own."""
    here = list(told(made(RIG)))
    for length in (2.0**10, 2.0**-40):
        for mine, theirs in zip(here, told(made(RIG, length)), strict=True):
            assert mine == theirs


def test_a_rig_in_metres_is_the_rig_in_millimetres():
    """From its default starts: a soft excitation 1.5 times above the resonance, a gap of twice the free swing."""
    shares = []
    for unit in (1.0, 1000.0):
        k = 20.0 * math.pi
        free = 1.0 / math.hypot(1.25 * k * k, 0.15 * k * k)
        forcing = gz.Forcing(omega=1.5 * k, cos=(unit,))
        m = gz.Oscillator(alpha=0.1 * k, k=k, forcing=forcing, sigma=-2.0 * free * unit, reset=gz.newton(0.9))
        P = gz.stroboscopic_map(m)
        found = gz.coexistence(P, "omega", [1.5 * k], starts=100, transient=1000, keep=60, seed=1)
        pairs = zip(found.word.values.flat, found.share.values.flat, strict=True)
        shares.append({str(word): float(share) for word, share in pairs if share > 0.0})
    metres, millimetres = shares
    assert metres == millimetres
    assert 0.0 < metres["1"] < 1.0  # most starts settle on the impacting orbit, some do not
