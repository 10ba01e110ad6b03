"""The Map protocol: every form of step, any dimension, outcomes, and the words of its errors."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.outcome import DIVERGED, NO_IMPACT
from tests.models import MODELS


def logistic(state, p):
    (x,) = state
    return (p.a * x * (1.0 - x),)


def henon(state, p):
    x, y = state
    return (1.0 - p.a * x * x + y, p.b * x), (0 if x < 0.0 else 1)


def rotor(state, p):
    x, y, z = state
    return (y, z, p.c * x - 1.0), 0, (4 if x > 0.9 else 0)


def make_logistic(**kw):
    return gz.Map(logistic, params={"a": 3.2}, coordinates=("x",), box=((0.0, 1.0),), **kw)


SHIPPED = [
    gz.gap_map(lam=0.5, mu=0.1, l=0.2),
    gz.gap_map(lam=-0.3, mu=0.4, l=0.0),
    gz.gap_map(lam=1.5, mu=0.1, l=0.2),
    gz.discontinuity_map(MODELS["standard"]),
    gz.discontinuity_map(MODELS["under-damped"], order="full"),
    gz.discontinuity_map(MODELS["own law"], order="full", phase=0.7),
    gz.discontinuity_map(MODELS["critical"], order="corrected"),
    gz.zdm(MODELS["two harmonics"]),
    gz.zdm(MODELS["trigger"], order="lowest"),
    gz.normal_form(MODELS["standard"], "d").xy_map(0.12),
    make_logistic(),
    gz.Map(henon, params={"a": 1.4, "b": 0.3}, coordinates=("x", "y"), box=((-0.5, 0.5), (-0.1, 0.1)), letters="LR"),
    gz.Map(rotor, params={"c": 0.9}, coordinates=("x", "y", "z"), box=((0.0, 1.0),) * 3),
]


@pytest.mark.parametrize("P", SHIPPED, ids=lambda P: f"{P.name} {P.dimension}")
def test_laws_of_maps(P):
    gz.testing.check_map(P)


def test_iterates_letters_and_outcomes():
    P = SHIPPED[-1]
    state, expected = (0.95, 0.2, 0.3), []
    for _ in range(5):
        state, letter, outcome = rotor(state, type("p", (), {"c": 0.9}))
        expected.append((state, letter, outcome))
    segment = P.orbit((0.95, 0.2, 0.3), 5)
    assert segment.points.shape == (6, 3)
    assert [tuple(row) for row in segment.points[1:]] == [one[0] for one in expected]
    assert segment.outcomes.tolist() == [one[2] for one in expected]
    assert P.iterate((0.1, 0.2, 0.3), 0).tolist() == [[0.1, 0.2, 0.3]]


def test_parameters_are_arguments_and_not_compiled_in():
    P = make_logistic()
    before = P._full_step
    Q = P.replace(a=2.0)
    assert Q._full_step is before
    assert (P((0.25,))[0][0], Q((0.25,))[0][0]) == (3.2 * 0.25 * 0.75, 2.0 * 0.25 * 0.75)
    assert dict(P.params) == {"a": 3.2}
    assert repr(Q) == "<Map logistic: (x); a=2>"


def test_jacobian_from_differences_is_good_to_nine_digits():
    P = SHIPPED[-2]
    assert P.jacobian((0.3, 0.1)) == pytest.approx(np.array([[-2.8 * 0.3, 1.0], [0.3, 0.0]]), abs=1e-9)


def test_escape_ends_an_orbit_as_diverged():
    P = make_logistic(escape=2.0).replace(a=5.0)
    segment = P.orbit((0.5,), 4)  # 1.25, then -1.5625, then -20.0
    assert segment.outcomes.tolist() == [0, 0, DIVERGED, DIVERGED]
    assert np.isnan(segment.points[3:]).all()
    assert make_logistic().replace(a=5.0).orbit((0.5,), 30).outcomes[-1] & DIVERGED  # overflow without a bound


def test_params_and_map_are_frozen():
    P = make_logistic()
    with pytest.raises(TypeError):
        P.params["a"] = 1.0
    with pytest.raises(AttributeError):
        P.name = "other"


def test_prepare_is_applied_once_per_run():
    def prepare(p):
        return p.a * 2.0

    def step(state, c):
        return (state[0] * c,)

    P = gz.Map(step, params={"a": 1.5}, coordinates=("x",), box=((0.0, 1.0),), prepare=prepare)
    assert P.iterate((1.0,), 3)[:, 0].tolist() == [1.0, 3.0, 9.0, 27.0]


def test_fast_arithmetic_agrees_before_chaos():
    P = SHIPPED[0]
    strict, fast = (np.linspace(-1, 0.1, 70)[None].copy() for _ in range(2))
    P.run(strict, 50, 0, arithmetic="strict")
    P.run(fast, 50, 0, arithmetic="fast")
    assert np.allclose(strict, fast, rtol=0.0, atol=1e-14)


def ends(state, p):
    return (2.0 * state[0],), 0, (NO_IMPACT if state[0] > p.a else 0)


def test_a_fatal_outcome_of_a_users_step_ends_the_orbit():
    segment = gz.Map(ends, {"a": 3.0}).orbit((1.0,), 5)
    assert segment.points[:3, 0].tolist() == [1.0, 2.0, 4.0]
    assert np.isnan(segment.points[3:]).all()
    assert segment.outcomes.tolist() == [0, 0, NO_IMPACT, NO_IMPACT | DIVERGED, NO_IMPACT | DIVERGED]


def test_infinity_is_not_ok():
    P = gz.Map(lambda s, p: (p.a / (s[0] - 1.0),), {"a": 0.5}, box=((0.0, 0.5),))
    segment = P.orbit((1.0,), 2)
    assert segment.outcomes.tolist() == [DIVERGED, DIVERGED]
    assert np.isnan(segment.points[1:]).all()


def test_a_map_may_have_no_parameters():
    P = gz.Map(lambda s, p: (0.5 * s[0],), {})
    assert P.iterate((1.0,), 2)[:, 0].tolist() == [1.0, 0.5, 0.25]
    gz.testing.check_map(P)


def raises(state, p):
    return (p.nothing,)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (
            lambda: gz.Map(logistic, {"a": 1.0}, box=(0.0, 1.0)),
            gz.InputError,
            r"box is \(0.0, 1.0\); give one \(low, high\)",
        ),
        (lambda: gz.Map(logistic, {"class": 1.0}), gz.InputError, r"parameter name 'class'; allowed is a Python name"),
        (lambda: gz.Map(logistic, {"_a": 1.0}), gz.InputError, r"parameter name '_a'; allowed is a Python name"),
        (lambda: gz.Map(logistic, None), gz.InputError, r"params is None; give a mapping of names to numbers"),
        (lambda: make_logistic().replace(b=1.0), gz.InputError, r"unknown parameter 'b' of logistic.* Allowed are: a"),
        (lambda: make_logistic().replace(a=math.nan), gz.InputError, r"a = nan is not finite"),
        (lambda: make_logistic()((0.1, 0.2)), gz.InputError, r"state has shape \(2,\); logistic needs \(1,\): x"),
        (lambda: make_logistic()((math.inf,)), gz.InputError, r"state \[inf\] is not finite; give finite x"),
        (lambda: make_logistic()("abc"), gz.InputError, r"state is 'abc'; give 1 numbers \(x\)"),
        (lambda: make_logistic().iterate((0.1,), -1), gz.InputError, r"n = -1; allowed is a whole number >= 0"),
        (lambda: make_logistic().iterate((0.1,), 2.5), gz.InputError, r"n = 2.5; allowed is a whole number >= 0"),
        (
            lambda: gz.Map(logistic, params={"a": 1.0}, coordinates=("x",), box=((1.0, 0.0),)),
            gz.InputError,
            r"box of x is \(1, 0\); the lower end must come first",
        ),
        (
            lambda: gz.Map(logistic, params={"a": 1.0}, coordinates=("x", "y"), box=((0.0, 1.0),)),
            gz.InputError,
            r"box has 1 intervals for 2 coordinates; give one \(low, high\) for each of x, y",
        ),
        (
            lambda: gz.Map(raises, params={"a": 1.0}),
            gz.UserCodeError,
            r"the step of raises raised AttributeError: .*nothing.*\(state \(0.5,\), parameters \{'a': 1.0\}\)",
        ),
        (
            lambda: gz.Map(lambda s, p: s[0] + 1.0, params={"a": 1.0}),
            gz.UserCodeError,
            r"returned 1.5; allowed are a tuple of 1 number\(s\), or \(state, letter\), or \(state, letter, outcome\)",
        ),
        (lambda: gz.Map(lambda s, p: (1.0, 2.0), params={"a": 1.0}), gz.UserCodeError, r"returned \(1.0, 2.0\)"),
        (
            lambda: gz.Map(lambda s, p: ((1.0,), 0.5), params={"a": 1.0}),
            gz.UserCodeError,
            r"returned \(\(1.0,\), 0.5\)",
        ),
    ],
)
def test_bad_input_is_answered_in_words(make, error, words):
    with pytest.raises(error, match=words):
        make()


def opens(state, p):
    return (float(f"{state[0]:g}"),)


def test_a_step_that_does_not_compile_names_the_construct():
    P = gz.Map(opens, params={"a": 1.0})
    with pytest.raises(gz.UserCodeError, match=r"the step of opens does not compile: .*Use arithmetic on floats"):
        P((0.5,))


def test_a_block_is_checked_over_many_states():
    gz.testing.check_map(gz.stroboscopic_map(gz.pinball(d=0.11, V=0.4)), states=1, steps=701)


def test_a_power_that_compiled_code_rounds_otherwise_is_told_from_a_wrong_step():
    P = gz.Map(lambda x, p: (p.a * x[0] - x[0] ** 3,), params={"a": 2.2}, box=((-1.5, 1.5),))
    with pytest.raises(AssertionError, match=r"by rounding alone: x\*\*3 is compiled as x\*x\*x"):
        gz.testing.check_map(P)
    gz.testing.check_map(gz.Map(lambda x, p: (p.a * x[0] - x[0] * x[0] * x[0],), params={"a": 2.2}, box=P.box))
