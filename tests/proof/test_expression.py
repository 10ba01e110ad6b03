"""Laws in Python become expressions that do the same, or are refused with a reason."""

import random

import numpy as np
import pytest

import grazing as gz
from grazing.proof.expression import NotAnExpression, expression, in_doubles, leaves
from grazing_checker.law import law_text
from tests.models import cubic
from tests.proof.orbits import closed

NAMES = ("e", "c")
PARAMS = {"e": 0.8, "c": 0.5}


def of(law, params=PARAMS, names=NAMES):
    return expression(law, params, names)


def strange(v, p):
    return abs(v) ** 3 * p.e - (p.c - v) / (2 + v**2) + 3 ** (-v / 1e9) + (-v) ** p.e + (0.5 if v > -2.0 else 0.1 / -v)


def branches(v, p):
    if -1 < v <= -0.5 and not v == -0.75:
        w = p.c
        w += 1
        return w
    return max(p.e, -v, 0.25) if v or p.c > 2 else min(v, -3)


def one_of(values):
    return lambda v, p: next(value for value in values if value)


@pytest.mark.parametrize(
    "law",
    [
        cubic, strange, branches, lambda v, p: 0, lambda v, p: -v, lambda v, p: -v * (v < -1) + p.c * (v >= -1),
        lambda v, p: np.float64(0.5) * -v, lambda v, p: -v * np.float64(0.5), lambda v, p: p[0] * -v,
        lambda v, p: sum([-v, p.e, 1]), lambda v, p: +abs(v) ** 0.5, lambda v, p: 1e308 * v * v,
        lambda v, p: -v / (v + 1.2345678901234567),  # raises at one of the speeds that are tried, as does its tree
    ],
)  # fmt: skip
def test_a_law_and_its_expression_give_the_same_doubles(law):
    tree = of(law)
    p = gz.parameter.parameter_tuple(NAMES)(0.8, 0.5)
    for v in np.random.default_rng(3).uniform(-3.0, 0.0, 500).tolist():
        assert float(law(v, p)) == in_doubles(tree, {"v": v, **PARAMS})


def test_the_laws_of_the_package_are_expressions():
    for reset, said in (
        (gz.newton(0.5), "(-p.r)*v"),
        (gz.active(0.5, 0.2), "(-p.r)*v + p.V"),
        (gz.triggered(0.5, 0.2, 0.1), "((-p.r)*v + p.V if -v >= p.trigger else (-p.r)*v + 0.0)"),
    ):
        tree = expression(reset.law, reset.params, tuple(reset.params))
        assert law_text(tree) == said
        assert leaves(tree) == {"v", *reset.params}


calls = iter(range(10**9))


def counting(v, p):
    return -v * (0.5 + 1e-9 * (next(calls) % 7))


def loops(v, p):
    while v < -p.c:
        v = v / 2
    return -v


def grows(v, p):
    for _ in range(30):
        v = v + v * v
    return v


def stateful(v, p):
    return -v if next(calls) % 2 else (0.5 if v < -1 else -v)


def swallows(v, p):
    try:
        return p.e if v < -1 else p.c
    except BaseException:
        return 1.0


def typed(v, p):
    return -v if isinstance(v, float) else -p.e * v


def secret(v, p):
    """Another law at one of the speeds that are tried."""
    return -v if getattr(v, "hex", None) is None or abs(v) < 1 else -2 * v


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (lambda v, p: __import__("math").sqrt(-v), "must be real number"),
        (lambda v, p: np.sqrt(-v), "TypeError"),
        (lambda v, p: -v // 1, "unsupported operand"),
        (lambda v, p: -v % 1, "unsupported operand"),
        (lambda v, p: round(-v), "TypeError"),
        (lambda v, p: float(-v), "TypeError"),
        (lambda v, p: -v * complex(1, 0), "no number"),
        (lambda v, p: -v * 10**400, "no finite double"),
        (lambda v, p: -v + (2**53 + 1), "no finite double"),
        (lambda v, p: -v * float("nan"), "no finite double"),
        (lambda v, p: float("inf"), "no finite double"),
        (lambda v, p: None, "no number"),
        (lambda v, p: [v], "no number"),
        (lambda v, p: -v * random.random(), "something else"),
        (counting, "something else"),
        (loops, "paths|levels|long"),
        (grows, "too long"),
        (stateful, "same at every call|something else"),
        (swallows, "same at every call"),
        (typed, "something else"),
        (secret, "something else"),
        (lambda v, p: {0: 1}[v], "unhashable"),
        (lambda v, p: p.nothing, "AttributeError"),
        (lambda v, p: 1 / 0, "ZeroDivisionError"),
    ],
)
def test_what_is_no_expression_is_refused_with_a_reason(law, said):
    with pytest.raises(NotAnExpression, match=said):
        of(law)


@pytest.mark.parametrize("name", ["alpha", "k", "omega", "t0", "offset", "d", "sigma", "v", "cos1", "sin1", "cos9"])
def test_a_parameter_of_a_law_may_not_have_a_name_of_the_model(name):
    with pytest.raises(NotAnExpression, match="rename it"):
        expression(lambda v, p: -v, {name: 0.5}, (name,))


def test_a_law_cannot_see_the_parameters_of_the_model():
    def seeing(v, p):
        return -v * getattr(p, "omega", 0.5)

    assert of(seeing) == ["*", ["-", "v"], (0.5).hex()]
    with pytest.raises(NotAnExpression, match="uses 'omega' of the model"):
        expression(seeing, PARAMS, ("omega", *NAMES))


@pytest.mark.parametrize("name", ["alpha", "k", "omega", "t0", "offset", "d", "sigma", "cos1", "sin1", "cos2", "sin9"])
def test_a_model_refuses_a_law_with_a_parameter_of_its_own(name):
    law = gz.reset(lambda v, p: -0.5 * v, **{name: 0.5})
    with pytest.raises(gz.InputError, match="rename it"):
        gz.Oscillator(alpha=1.0, k=1.0, forcing=gz.Forcing(omega=2.0), reset=law)


def test_a_law_that_hides_a_branch_from_symbols_is_found_out_at_the_speeds_of_the_orbit():
    """It has the orbit of r v and, for doubles about it, another slope: what is proven of -r v is not of this law."""
    model = gz.Oscillator(0.3, 1.0, gz.Forcing(omega=2.2, offset=0.2), gz.newton(r=0.5))
    (orbit,) = gz.one_impact_orbits(model, 1)
    v0, width = float(orbit.incoming[0]), 1e-3

    def hiding(v, p):
        if isinstance(v, float) and abs(v - v0) < width:
            return -p.r * v0 - 3.0 * (v - v0)
        return -p.r * v

    assert expression(hiding, {"r": 0.5}, ("r",)) == ["*", ["-", "r"], "v"]  # no sample is there
    for width in (1.0, 1e-3, 1e-6, 1e-9, 1e-12):  # noqa: B007
        with pytest.raises(NotAnExpression, match="called with numbers"):
            expression(hiding, {"r": 0.5}, ("r",), [v0])
    width = 1e-3
    other = gz.Oscillator(0.3, 1.0, model.forcing, gz.reset(hiding, r=0.5))
    near = closed(other, orbit.period, orbit.times, orbit.outgoing, orbit.incoming)[0]
    assert "called with numbers it does something else" in gz.certify(near).reason
    assert "called with numbers it does something else" in gz.enclose(near, "pd", "offset").reason
    with pytest.raises(gz.InputError, match="called with numbers"):
        gz.check_certificate(gz.certify(orbit).document, law=hiding)
