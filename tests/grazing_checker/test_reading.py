"""What stands between the text of a certificate and the numbers of its checker: each demand, at its limit."""

import pytest

from grazing_checker import check
from grazing_checker.balls import Ball, number, precision
from grazing_checker.reading import (
    Inequalities,
    Rejected,
    decimal,
    exact,
    keys,
    numbers,
    text_of_double,
    whole,
    within,
)
from tests.grazing_checker.bases import KINDS, bases
from tests.grazing_checker.documents import resealed

ROW = {"name": "size", "left": "0.5", "relation": ">", "right": "0"}
HALF = number(1, -1)
NEAR = Ball(0.5, 1e-9)  # on both sides of 1/2


@pytest.fixture(autouse=True)
def bits():
    with precision(256):
        yield


def refused(said, call, *args):
    with pytest.raises(Rejected, match=said):
        call(*args)


def rows(**changes):
    return Inequalities([{**ROW, **changes}])


def test_a_quantity_is_more_than_its_bound_and_the_bound_no_less_than_0():
    rows().more("size", number(3, -2))
    rows(left="0").more("size", number(1, -300))
    for x in (HALF, NEAR, number(1, -2), -HALF, Ball("nan"), Ball(1, "inf")):
        refused("does not hold", rows().more, "size", x)
    refused("does not hold", rows(left="0").more, "size", number(0))
    refused("is false", rows(left="-1E-90").more, "size", number(1))


def test_a_quantity_is_less_than_its_bound_and_the_bound_no_more_than_what_is_asked():
    def less(right, **changes):
        return Inequalities([{**ROW, "relation": "<", "right": right, **changes}]).less

    less("0x1p-1")("size", number(1, -2), "0x1p-1")  # the bound may be what is asked
    less("1")("size", number(1, -2), "1")
    less("0", left="-0.5")("size", -number(1))
    for x in (HALF, NEAR, number(3, -2), Ball("nan")):
        refused("does not hold", less("1"), "size", x, "1")
    for left, right in (("0.51", "0x1p-1"), ("1.001", "1"), ("1E-90", "0"), ("0.5", "0")):
        refused("is false", less(right, left=left), "size", -number(1), right)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"name": "other"}, "expected is 'size'"), ({"relation": "<"}, "expected is '>'"),
        ({"relation": ">="}, "expected is '>'"), ({"right": "0.0"}, "expected is '0'"),
        ({"right": "-1"}, "expected is '0'"), ({"left": 0.5}, "no decimal"), ({"left": "0x1p-1"}, "no decimal"),
        ({"more": 1}, "adds more"),
    ],
)  # fmt: skip
def test_an_inequality_is_the_one_that_is_asked_for(changes, said):
    refused(said, rows(**changes).more, "size", number(1))


def test_inequalities_are_taken_one_after_the_other_and_all_of_them():
    some = Inequalities([ROW, {**ROW, "name": "next"}])
    refused("'size' is not one of this proof", some.finish)
    some.more("size", number(1))
    assert some.name == "next"
    refused("'next' is not one of this proof", some.finish)
    some.more("next", number(1))
    some.finish()
    assert some.name == ""
    refused("'last' is missing", some.more, "last", number(1))


@pytest.mark.parametrize("kind", KINDS)
def test_no_certificate_has_an_inequality_more(kind):
    document = next(one for one in bases().values() if one["kind"] == kind)
    more = resealed({**document, "inequalities": [*document["inequalities"], ROW]})
    refused("'size' is not one of this proof", check, more)


def test_a_number_lies_in_the_interval_that_is_claimed_for_it():
    within(HALF, ["0.5", "0.5"], "it")
    within(Ball(0.5, 1e-9), ["0.499999998", "0.500000002"], "it")
    for texts in (
        ["0.4999999998", "0.500000002"], ["0.499999998", "0.5000000002"], ["0.500000002", "0.499999998"],
        ["0.500000002", "0.500000003"], ["0.499999997", "0.499999998"],
    ):  # fmt: skip
        refused("which does not hold", within, NEAR, texts, "it")
    refused("which does not hold", within, Ball("nan"), ["0", "1"], "it")
    for texts in ([], ["0.5"], ["0.5"] * 3, "0.5", None, {"0.5": 1, "0.6": 2}):
        refused("no pair", within, HALF, texts, "it")


def test_an_interval_that_is_claimed_is_nearly_as_narrow_as_the_number_is_known():
    within(number(-1), ["-1.0000000004", "-0.9999999996"], "it")  # of 2^-30 of its size
    refused("far too wide", within, number(-1), ["-1.0000000005", "-0.9999999995"], "it")
    refused("far too wide", within, number(1, -40), ["0", "1E-11"], "it")
    wide = Ball(0, 2.0**-16)
    within(wide, ["-0.5", "0.5"], "it")
    refused("far too wide", within, wide, ["-0.6", "0.6"], "it")


def test_exact_numbers_decimals_and_doubles_are_what_their_texts_say():
    assert exact("-0x2bp-7") == number(-43, -7) and exact("0x0p0").is_zero()
    assert abs(decimal("-12.5E-1") * 4 + 5) < 1e-60 and decimal("0.1").contains(number(1) / 10)
    assert text_of_double("-0x1.8000000000000p+1") == -3.0
    for text in ("0x1", "1p0", "0x1P0", "0xAp0", "+0x1p0", "0x1p+1", "0x1p10000", "0x1.8p0", " 0x1p0", "0x1p0\n", 1):
        refused("no exact number", exact, text)
    for text in ("", ".5", "5.", "1e5", "+1", "inf", "nan", "1/3", "0x1", "1E10000", "1\n", "\u0661", 0.5, None):
        refused("no decimal number", decimal, text)
    for text in ("0x1p0", "1.0", "inf", "-inf", "nan", "0x1.0p+2000", "0x1.8p+1", "", 1.0, None):
        refused("double", text_of_double, text)


def test_lists_mappings_and_whole_numbers_have_their_shapes():
    assert [float(x) for x in numbers(["0x1p0", "0x3p-1"], 2, "it")] == [1.0, 1.5]
    for texts in (["0x1p0"], ["0x1p0"] * 3, ("0x1p0", "0x1p0"), "ab", None):
        refused("no list of 2 numbers", numbers, texts, 2, "it")
    keys({"a": 1, "b": 2}, ("b", "a"), "it")
    for some, said in (({"a": 1}, "adds b"), ({"a": 1, "b": 2, "c": 3}, "adds c"), (["a", "b"], "no mapping")):
        refused(said, keys, some, ("a", "b"), "it")
    assert whole(3, 3, "it") == 3
    for x in (2, -3, 3.0, True, "3", None):
        refused("not a whole number >= 3", whole, x, 3, "it")
