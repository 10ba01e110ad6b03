"""Derivatives that come along with balls: against differences, and against the rules for numbers that are none."""

import operator

import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from grazing_checker.balls import number, precision
from grazing_checker.gradient import Gradient, derivative_of, lifted, variables

H = arb(2) ** -60
NUMBERS = st.floats(0.1, 3.0)
BINARY = (operator.add, operator.sub, operator.mul, operator.truediv)
UNARY = (
    operator.neg, lambda x: x.sqrt(), lambda x: x.exp(), lambda x: x.log(), lambda x: x.sin_cos()[0],
    lambda x: x.sin_cos()[1], lambda x: x**3, lambda x: x**1, lambda x: x**0, lambda x: 2 + x, lambda x: 2 - x,
    lambda x: x * 3, lambda x: 3 / x, lambda x: arb(2) / x, lambda x: arb(2) - x,
)  # fmt: skip


def slopes(f, *points):
    """The derivatives by central differences, to some thirty digits."""
    found = []
    for j in range(len(points)):
        up, down = (f(*(x + s * H * (k == j) for k, x in enumerate(points))) for s in (1, -1))
        found.append((up - down) / (2 * H))
    return found


@given(NUMBERS, NUMBERS, st.sampled_from(BINARY), st.sampled_from(UNARY))
def test_derivatives_are_those_of_differences(a, b, binary, unary):
    def f(x, y):
        return unary(binary(x, y) * binary(x, y) + 1) * x

    with precision(256):
        points = [arb(a), arb(b)]
        found = f(*variables(points))
        assert (found.x - f(*points)).contains(0)
        for one, known in zip(derivative_of([found], 2)[0], slopes(f, *points), strict=True):
            assert abs(one - known) < 1e-25 * (1 + abs(known))


@given(NUMBERS, NUMBERS, st.floats(0.0, 0.05), st.floats(-1, 1), st.sampled_from(BINARY), st.sampled_from(UNARY))
def test_over_a_ball_they_enclose_those_of_its_numbers(a, b, r, s, binary, unary):
    def f(x, y):
        return unary(binary(x, y) * binary(x, y) + 1)

    with precision(128):
        wide = f(*variables([arb(a, r), arb(b, r)]))
        inner = f(*variables([arb(a) + arb(r) * arb(s), arb(b) - arb(r) * arb(s)]))
        for one, two in zip(derivative_of([wide], 2)[0], derivative_of([inner], 2)[0], strict=True):
            assert not one.is_finite() or (one - two).contains(0)


def test_comparisons_look_at_the_value_only():
    x = Gradient(arb(1, 0.5), {0: number(7)})
    assert x > 0 and x < 2 and x >= arb(0.25) and not x >= 1 and not x < 1 and x <= arb(2)
    assert arb(0) < x and arb(2) > x and number(2) >= x and not arb(1) <= x
    assert Gradient(number(0), {0: number(1)}).is_zero() and not x.is_zero()


def test_what_is_not_finite_is_told():
    assert not Gradient(number(1), {0: number(1) / arb(0, 1)}).is_finite()
    assert not Gradient(number(1) / arb(0, 1), {}).is_finite() and lifted(3).is_finite()


def test_a_number_depends_on_nothing():
    assert derivative_of([arb(3), lifted(2) + variables([arb(1), arb(1)])[1]], 2) == [[0, 0], [0, 1]]
    with pytest.raises(AttributeError):
        lifted(2).other = 1
