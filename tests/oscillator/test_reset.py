"""Reset laws: closed forms, declared slopes and contractions as laws, and the words of their errors."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import grazing as gz
from grazing.parameter import parameter_tuple
from tests.models import cubic

LAWS = [
    gz.newton(r=0.8),
    gz.newton(r=0.0),
    gz.newton(r=1.0),
    gz.active(r=0.8, V=0.4),
    gz.active(r=0.3, V=0.0),
    gz.triggered(r=0.6, V=0.5, trigger=0.1),
    gz.triggered(r=0.6, V=0.0, trigger=0.1),
    gz.reset(cubic, e=0.9, c=0.5),
    gz.reset(cubic, contraction=(0.9, 1e3), e=0.9, c=0.5),
    gz.reset(cubic, contraction=lambda p: (p.e, math.inf), e=0.7, c=0.0),
]


def parameters(law):
    return parameter_tuple(tuple(law.params))(*law.params.values())


@pytest.mark.parametrize("law", LAWS, ids=repr)
@given(v=st.floats(-10.0, -1e-12))
def test_laws_keep_what_they_declare(law, v):
    p = parameters(law)
    w = law(v)
    assert w == law.law(v, p) >= 0.0
    ratio, speed = law.contraction(p)
    if ratio < 1.0 and -v <= speed:
        assert w <= ratio * -v * (1.0 + 1e-15)
    h = 1e-6 * max(1.0, -v)
    if law.name != "triggered" or abs(-v - 0.1) > 2 * h:
        difference = (law.law(v + h, p) - law.law(v - h, p)) / (2.0 * h)
        assert law.slope(v, p) == pytest.approx(difference, abs=1e-6)


@pytest.mark.parametrize("unit", [1.0, 2.0**-30, 2.0**-100, 2.0**100])
def test_slopes_do_not_depend_on_the_unit_of_speed(unit):
    def kicking(v, p):
        return cubic(v, p) + p.V

    for V in (0.0, 0.4):
        law = gz.reset(kicking, e=0.9, c=0.5 / unit, V=V * unit)
        for v in (-3.0, -0.3, -1e-3, -1e-5):
            assert law.slope(v * unit, parameters(law)) == pytest.approx(-0.9 / (1.0 - 0.5 * v) ** 2, rel=1e-6)
    still = gz.reset(cubic, e=0.9, c=0.5)
    assert still.slope(0.0, parameters(still)) == pytest.approx(-0.9)


def test_values():
    assert gz.newton(r=0.25)(-2.0) == 0.5
    assert gz.active(r=0.25, V=1.0)(-2.0) == 1.5
    assert gz.triggered(r=0.25, V=1.0, trigger=0.5)(-0.5) == 1.125
    assert gz.triggered(r=0.25, V=1.0, trigger=0.5)(-0.25) == 0.0625
    assert gz.reset(cubic, e=0.5, c=1.0)(-1.0) == 0.25


def test_replace_and_repr():
    law = gz.active(r=0.8, V=0.4)
    assert repr(law.replace(V=0.1)) == "active(r=0.8, V=0.1)"
    assert dict(law.params) == {"r": 0.8, "V": 0.4}
    assert gz.reset(cubic, e=0.9, c=0.5).replace(c=0.0)(-3.0) == pytest.approx(2.7)
    with pytest.raises(TypeError):
        law.params["r"] = 0.1


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gz.newton(r=1.2), r"r = 1.2; allowed is 0 <= r <= 1 \(coefficient of restitution\)"),
        (lambda: gz.active(r=0.5, V=-1.0), r"V = -1; allowed is V >= 0, finite"),
        (lambda: gz.active(r=math.nan, V=1.0), r"r = nan is not finite; allowed is 0 <= r <= 1"),
        (lambda: gz.newton(r="0.8"), r"r = '0.8' is not a real number"),
        (lambda: gz.newton(r=True), r"r = True is not a real number"),
        (lambda: gz.triggered(r=0.5, V=1.0, trigger=-0.1), r"trigger = -0.1; allowed is trigger >= 0"),
        (lambda: gz.reset(0.8), r"law is 0.8; give a function law\(v_minus, p\) -> v_plus"),
        (
            lambda: gz.reset(cubic, contraction=(1.0, 1.0), e=1.0, c=0.0),
            r"contraction is \(1.0, 1.0\); allowed is 0 <= ratio < 1",
        ),
        (
            lambda: gz.reset(cubic, contraction=0.5, e=1.0, c=0.0),
            r"contraction is 0.5; give \(ratio, speed\)",
        ),
        (
            lambda: gz.reset(lambda v, p: 0.3, contraction=(0.8, 1.0)),
            r"contraction says v_plus <= 0.8 \|v_minus\| for speeds up to 1, but the law gives 0.3 for v_minus = 0",
        ),
        (lambda: gz.newton(r=0.5)(0.5), r"v_minus = 0.5 points away from the wall; give v_minus <= 0"),
        (lambda: gz.newton(r=0.5)("a"), r"v_minus = 'a' is not a real number"),
        (lambda: gz.reset(cubic, **{"lambda": 1.0}), r"parameter name 'lambda'; allowed is a Python name"),
        (lambda: gz.reset(cubic, e=math.inf, c=0.0), r"e = inf is not finite"),
    ],
)
def test_bad_numbers_are_answered_in_words(make, words):
    with pytest.raises(gz.InputError, match=words):
        make()


def into_the_wall(v, p):
    return 0.5 * v


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (
            into_the_wall,
            r"the reset law into_the_wall returned -5e-10 for v_minus = -1e-09; allowed is a finite v_plus >= 0",
        ),
        (lambda v, p: math.nan, r"returned nan for v_minus = 0"),
        (lambda v, p: None, r"returned None"),
        (lambda v, p: p.missing * v, r"raised AttributeError: .*missing.* \(v_minus = 0, \{\}\)"),
        (lambda v, p: 1.0 / v, r"raised ZeroDivisionError"),
    ],
)
def test_a_law_that_fails_is_named_with_its_velocity(law, words):
    with pytest.raises(gz.UserCodeError, match=words):
        gz.reset(law)


def fading(v, p):
    return -v * (1.0 + p.c * v)


def test_a_law_is_tried_at_the_speeds_of_its_model():
    """Valid up to 0.5 m/s: right for a slow rig, in millimetres too, and wrong for a fast one."""
    law = gz.reset(fading, c=2.0)
    assert [law(-0.1), law(-0.5)] == [pytest.approx(0.08), 0.0]
    rig = {"alpha": 0.1, "k": 1.0, "forcing": gz.Forcing(omega=2.0, offset=-0.1, cos=(0.1,))}
    assert gz.Oscillator(**rig, reset=law).reset(-0.05) == pytest.approx(0.045)
    small = {**rig, "forcing": gz.Forcing(omega=2.0, offset=-100.0, cos=(100.0,))}
    assert gz.Oscillator(**small, reset=gz.reset(fading, c=2e-3)).reset(-50.0) == pytest.approx(45.0)
    with pytest.raises(gz.UserCodeError, match=r"the reset law fading returned -\d.* for v_minus = -\d+"):
        gz.Oscillator(**small, reset=law)


def test_a_contraction_is_tried_where_it_is_said_to_hold():
    with pytest.raises(gz.InputError, match=r"contraction says v_plus <= 0\.5"):
        gz.reset(lambda v, p: -0.4 * v if v > -1e3 else -0.9 * v, contraction=(0.5, 1e4))
    fast = gz.reset(lambda v, p: -0.4 * v if v > -1.0 else -0.9 * v, contraction=(0.5, math.inf))
    with pytest.raises(gz.InputError, match=r"contraction says v_plus <= 0\.5"):
        gz.Oscillator(0.0, 1.0, gz.Forcing(2.0, cos=(30.0,)), fast)


def test_a_parameter_of_the_law_must_not_hide_one_of_the_model():
    with pytest.raises(
        gz.InputError, match="the reset law's parameter 'k' has the name of a model parameter; rename it"
    ):
        gz.Oscillator(alpha=1.0, k=1.0, forcing=gz.Forcing(omega=1.0), reset=gz.reset(lambda v, p: -p.k * v, k=0.5))
