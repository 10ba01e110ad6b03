"""A second arithmetic, over mpmath's intervals, confirms certificates of every kind and refuses forged ones."""

import operator
import sys
from fractions import Fraction

import flint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import grazing_checker
from tests.examples import examples
from tests.grazing_checker import intervals
from tests.grazing_checker.bases import GAP_NAMES, KINDS, TABLE_NAMES, TABLE_VALUE_NAMES, bases
from tests.grazing_checker.documents import NAMES, WALLED
from tests.grazing_checker.forgeries import forgeries

NUMBERS = st.floats(-1e6, 1e6, allow_nan=False)
RADII = st.floats(0.0, 10.0) | st.just(0.0)


@pytest.fixture(scope="module")
def second():
    found = intervals.checker_on_intervals()
    assert sys.modules["flint"] is flint and found is not grazing_checker.check
    return found


#: Certificates that this arithmetic confirms in less than a few seconds.
QUICK = ("free", "ns", *WALLED, "table pd", *GAP_NAMES, *TABLE_NAMES, *TABLE_VALUE_NAMES)
OF_THE_GAP_MAP = tuple(kind for kind in KINDS if kind.startswith("gap map"))
OF_THE_OSCILLATOR = tuple(kind for kind in KINDS if kind not in OF_THE_GAP_MAP)


def test_there_are_certificates_of_every_kind(second):
    assert {one["kind"] for one in bases().values()} == set(KINDS) == set(second.KINDS)
    assert {bases()[name]["kind"] for name in QUICK} == set(KINDS)
    data = [one["data"] for one in bases().values()]
    assert {one["edge"] for one in data if "edge" in one} == {"gr", "bc", "pd", "lp"}
    assert {one["type"] for one in data if "type" in one} == {"gr", "ns", "pd", "lp"}


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(one, marks=pytest.mark.long) for one in NAMES if one not in QUICK)]
)
def test_it_confirms_certificates_with_the_same_sentence(second, name):
    document = bases()[name]
    assert second.check(document) == document["statement"]


@pytest.mark.parametrize(
    ("kind", "count"),
    [*((kind, 12) for kind in OF_THE_GAP_MAP), *((kind, 3) for kind in OF_THE_OSCILLATOR)]
    + [pytest.param(kind, 30, marks=pytest.mark.long) for kind in OF_THE_OSCILLATOR],
)
def test_it_refuses_what_the_balls_refuse(second, kind, count):
    refused = 0
    for _ways, document in forgeries(kind, list(bases().values()), count, "intervals"):
        try:
            said = grazing_checker.check(document)
        except grazing_checker.Rejected:
            refused += 1
            with pytest.raises(second.Rejected):
                second.check(document)
        else:
            assert second.check(document) == said
    assert refused >= count / 3


def man_exp(exact):
    m, e = exact.man_exp()
    return (int(m) * 2 ** int(e), 1) if e >= 0 else (int(m), 2 ** -int(e))


def between(low, high):
    one, two = (flint.arb(flint.fmpq(x.numerator, x.denominator)) for x in (low, high))
    return one.union(two)


@settings(deadline=None, max_examples=examples(150))
@given(NUMBERS, NUMBERS, RADII, RADII, st.floats(-1, 1), st.floats(-1, 1))
def test_operations_enclose_what_exact_arithmetic_finds(a, b, r, q, s, t):
    x, y = Fraction(a) + Fraction(r) * Fraction(s), Fraction(b) + Fraction(q) * Fraction(t)
    one, two = intervals.arb(a, r), intervals.arb(b, q)
    for operation in (operator.add, operator.sub, operator.mul, operator.truediv):
        found = operation(one, two)
        if not found.is_finite():
            assert operation is operator.truediv and not (two > 0 or two < 0)
            continue
        low, high = (Fraction(*man_exp(end)) for end in (found.lower(), found.upper()))
        assert low <= operation(x, y) <= high
    for found, exact in ((abs(one), abs(x)), (-one, -x), (one**3, x**3), (one**2, x**2)):
        low, high = (Fraction(*man_exp(end)) for end in (found.lower(), found.upper()))
        assert low <= exact <= high
    middle, reach = (Fraction(*man_exp(part)) for part in (one.mid(), one.rad()))
    assert middle - reach <= x <= middle + reach
    if one < two:
        assert x < y
    if one <= two:
        assert x <= y


@settings(deadline=None, max_examples=examples(100))
@given(st.floats(-40, 40), st.floats(0, 1) | st.just(0.0), st.floats(0.1, 50))
def test_functions_agree_with_balls(a, r, b):
    before, intervals.ctx.prec = intervals.ctx.prec, 100
    try:
        with flint.ctx.workprec(100):
            x, ball = intervals.arb(a, r), flint.arb(a, r)
            for found, known in zip(x.sin_cos(), ball.sin_cos(), strict=True):
                assert known.overlaps(between(*ends(found)))
            assert ball.exp().overlaps(between(*ends(x.exp())))
            y, other = intervals.arb(b), flint.arb(b)
            for name in ("sqrt", "log"):
                low, high = ends(getattr(y, name)())
                known = getattr(other, name)()
                assert known.overlaps(between(low, high)) and high - low < Fraction(1, 2**80)
            low, high = ends(intervals.arb.pi())
            assert low <= Fraction(*man_exp(flint.arb.pi().mid())) <= high
    finally:
        intervals.ctx.prec = before


def ends(interval):
    return [Fraction(*man_exp(one)) for one in (interval.lower(), interval.upper())]
