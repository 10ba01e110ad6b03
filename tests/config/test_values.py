"""Numbers, ranges, states and boxes as text and as lists."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grazing import InputError
from grazing.config import checked
from grazing.config.settings import text_of
from grazing.config.values import (
    bounds_of,
    by_name,
    count,
    extremes,
    number,
    numbers,
    other_range,
    pairs,
    range_of,
    states,
    values_of,
    written_as,
)

FINITE = st.floats(-1e9, 1e9, allow_nan=False).filter(lambda x: x == 0.0 or abs(x) > 1e-9)


def test_a_range_in_words_is_what_numpy_makes_of_it():
    assert np.array_equal(values_of("0.05:0.16:500"), np.linspace(0.05, 0.16, 500))
    assert np.array_equal(values_of("0.16:0.05:7"), np.linspace(0.16, 0.05, 7))
    assert np.array_equal(values_of("1e-3:1:10:log"), np.geomspace(1e-3, 1.0, 10))
    assert values_of("0.3:0.3:1").tolist() == [0.3]
    assert values_of(range_of("0.1,0.4", "d")).tolist() == [0.1, 0.4]
    assert values_of(range_of([1, 2], "d")).tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("0:1", "give start:stop:count"),
        ("0:1:2:3", "give start:stop:count"),
        ("a:1:5", "start = 'a' is not a real number"),
        ("0:inf:5", "stop = inf is not finite"),
        ("0:1:0", "allowed is a whole number >= 1"),
        ("0:1:2.5", "allowed is a whole number >= 1"),
        ("0:1:1e3", "allowed is a whole number >= 1"),
        ("0:1:999999999999", "are more than 100000000"),
        ("0:1:5:log", "a logarithm needs both ends > 0"),
        ("1:1:5", "give different ends or count 1"),
        ("-1e308:1e308:5", "too far apart"),
        ("0.1", "give start:stop:count"),
        (0.1, "give start:stop:count"),
        (True, "give start:stop:count"),
        ([], "give a list of numbers"),
        ([0.1, "x"], "d[1] = 'x' is not a real number"),
        ([True], "d[0] = True is not a real number"),
    ],
)
def test_what_is_no_range(written, said):
    with pytest.raises(InputError) as error:
        range_of(written, "d")
    assert said in str(error.value)
    assert str(error.value).startswith("d")


@given(FINITE, FINITE, st.integers(2, 50))
def test_evenly_spaced_values_are_written_shortly(start, stop, count):
    if start == stop:
        return
    values = np.linspace(start, stop, count)
    written = written_as(values)
    assert np.array_equal(values_of(written), values)
    assert isinstance(written, str)
    low, high = extremes(written)
    assert low == values.min() and high == values.max()


@given(st.lists(FINITE, min_size=1, max_size=8))
def test_any_values_are_written_so_that_they_come_back(items):
    values = np.array(items)
    assert np.array_equal(values_of(written_as(values)), values)
    assert extremes(written_as(values)) == (values.min(), values.max())


@pytest.mark.parametrize(
    ("name", "check", "value"),
    [
        ("box", pairs, [[0.0, 1.0], [-2.0, 2.0]]),
        ("starts", states, [[0.1, 0.0], [0.2, -0.5]]),
        ("starts", states, [[0.1]]),
        ("starts", states, [[0.1], [0.2]]),
        ("starts", states, 17),
        ("state", numbers, [0.1, -1e-300]),
        ("state", numbers, [0.25]),
        ("fixed", by_name, {"v": 0.5, "w": -1.0}),
    ],
)
def test_text_and_lists_say_the_same(name, check, value):
    assert check(value, name) == value
    assert check(text_of(name, value), name) == value


@pytest.mark.parametrize(
    ("check", "value", "said"),
    [
        (pairs, "0:1:2", "give low:high"),
        (pairs, [[1.0, 0.0]], "the lower end must come first"),
        (pairs, [[-1e308, 1e308]], "so far apart that no double holds how far"),
        (pairs, [[1.0, 1.0]], "box = 1:1; both ends are the same"),
        (pairs, 3, "low:high for each coordinate"),
        (states, 0, "a whole number >= 1, or states"),
        (states, "many", "a whole number >= 1, or states"),
        (states, "0.1", "0.1; is one of one number"),
        (states, "0.1,x;0.2,0", "is not a real number"),
        (numbers, {}, "give a list of numbers"),
        (by_name, "v", "give coordinate=value"),
        (by_name, 3, "give a table of coordinates"),
        (by_name, "v=x", "box.v = 'x' is not a real number"),
    ],
)
def test_what_is_not_allowed_is_said(check, value, said):
    with pytest.raises(InputError) as error:
        check(value, "box")
    assert said in str(error.value)


@pytest.mark.parametrize("text", ["5-25", "5..25", "5 - 25", "5 to 25", "5;25", "[5,25]", "(5, 25)", "5…25", "5–25"])
def test_a_range_that_is_written_in_another_way_is_told_how_it_is_written_here(text):
    with pytest.raises(InputError, match="give start:stop:count, such as 5:25:100"):
        range_of(text, "d")
    with pytest.raises(InputError, match="give low:high, here 5:25"):
        bounds_of(text, "d")


@pytest.mark.parametrize(
    "text", ["1e-3", "-1e-3", "5", "5,25", "5:25:3", "9.81 m/s^-2", "3 s-1", "1.2 mm", "nan", "a-b"]
)
def test_what_is_no_other_range(text):
    assert other_range(text) is None


def test_ends_keep_signs_and_exponents():
    assert other_range("-1e-3--1e-4") == ("-1e-3", "-1e-4") and other_range("1e-3-2") == ("1e-3", "2")


def test_text_keeps_every_bit():
    x = math.nextafter(0.1, 1.0)
    assert numbers(text_of("state", [x]), "state") == [x]


def test_a_seed_may_use_all_64_bits_and_counts_what_a_kernel_counts_to():
    from grazing.config import checked

    config = {"study": "diagram", "vary": {"d": "0:1:3"}, "settings": {"seed": 2**64 - 1}}
    assert checked(config)["settings"]["seed"] == 2**64 - 1
    for key, value in (("seed", 2**64), ("keep", 2**63)):
        with pytest.raises(InputError, match=f"{key} = {value}; allowed is a whole number from"):
            checked({**config, "settings": {key: value}})


@pytest.mark.parametrize(
    "value",
    [np.array("0.3", object), np.array(True, object), bytearray(b"0.3"), np.array([0.3], object), np.void(b"a")],
)
def test_what_hides_a_text_or_a_truth_value_is_no_number(value):
    """An array of no dimension around an object was taken for what its object can be turned into."""
    with pytest.raises(InputError):
        number(value, "x")
    with pytest.raises(InputError):
        count(value, "x", 0)
    assert number(np.array(0.3, object), "x") == 0.3


@pytest.mark.parametrize("study", ["density", "windows"])
@pytest.mark.parametrize("value", [np.array([0.1, 0.2]), np.array([0.1]), np.void(b"ab"), np.array([["default"] * 2])])
def test_what_varies_is_no_array(study, value):
    """What is said of it was a ValueError about the truth of an array."""
    with pytest.raises(InputError, match=r"vary\.d = "):
        checked({"study": study, "vary": {"d": value}})
