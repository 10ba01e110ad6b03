"""The same values in another coat, as a list, a view or a column of a table: the same result, or a message of ours.

Every argument of every call of :mod:`tests.fuzz.test_calls`, and everything in it, is given in all coats of its type.
"""

import array
import collections
import decimal
import fractions
import functools
import itertools
import types

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr

import grazing as gz
from grazing.copies import alike
from tests.fuzz.extremes import defect
from tests.fuzz.test_calls import calls, function_of, never, step


class Text(str):
    __slots__ = ()


class Real(float):
    """A number that says of itself what is not so."""

    __slots__ = ()

    def __repr__(self):
        return "0.25"


class Listed:
    """A sequence by its length and items alone."""

    def __init__(self, values):
        self.values = values

    def __len__(self):
        return len(self.values)

    def __getitem__(self, i):
        return self.values[i]


def spread(values):
    """Return every second number of an array that has others between."""
    wide = np.full(tuple(2 * n for n in values.shape), np.nan)
    view = wide[tuple(slice(None, None, 2) for _ in values.shape)]
    view[...] = values
    return view


def locked(values):
    other = values.copy()
    other.flags.writeable = False
    return other


COATS = {
    float: [Real, np.float64, np.longdouble, np.array, decimal.Decimal, fractions.Fraction, xr.DataArray, repr, complex,
            lambda v: np.array(v, ">f8"), lambda v: np.array(v, object), lambda v: [v], lambda v: np.ma.array(v)],
    int: [np.uint8, float, np.array, str, complex, fractions.Fraction, xr.DataArray, lambda v: np.array(v, ">i4")],
    str: [Text, np.str_, np.array, str.encode, list, lambda v: [v]],
    tuple: [list, np.array, iter, set, collections.deque, Listed, pd.Series, xr.DataArray,
            lambda v: dict.fromkeys(v).keys(), lambda v: dict(enumerate(v)).values()],
    dict: [types.MappingProxyType, collections.OrderedDict, lambda v: list(v.items()), pd.Series,
           lambda v: {Text(key): value for key, value in v.items()}],
    np.ndarray: [spread, locked, list, iter, set, np.ma.array, pd.Series, pd.Index, xr.DataArray, memoryview, tuple,
                 lambda v: pd.Series(v, index=range(len(v))[::-1]), lambda v: v.astype(">f8"), lambda v: v.astype(str),
                 lambda v: v.astype(object), lambda v: v.astype(complex), lambda v: array.array("d", v),
                 lambda v: xr.DataArray(v, dims="d", coords={"d": v[::-1]}), np.asfortranarray, Listed],
}  # fmt: skip
COATS[list] = COATS[tuple]


def sites(value, path=()):
    """Return where a value, or something in it, can have another coat, and which."""
    for number in range(len(COATS.get(type(value), ()))):
        yield path, number
    items = value.items() if type(value) is dict else enumerate(value) if type(value) in (list, tuple) else ()
    for key, inner in items:
        yield from sites(inner, (*path, key))


def dressed(value, path, number):
    """Return a value with that coat at that place."""
    if not path:
        return COATS[type(value)][number](value)
    inner = dressed(value[path[0]], path[1:], number)
    if type(value) is dict:
        return {**value, path[0]: inner}
    return type(value)([*value[: path[0]], inner, *value[path[0] + 1 :]])


def same(one, other):
    """Say whether two results are equal; of figures and tables only that there are any."""
    if isinstance(one, xr.Dataset):
        attrs = [{key: str(text) for key, text in given.attrs.items()} for given in (one, other)]
        return one.equals(other) and attrs[0] == attrs[1]
    if isinstance(one, (pd.DataFrame, dict)):
        return type(one) is type(other)
    if isinstance(one, (int, float, np.ndarray)):
        return np.array_equal(one, np.ravel(other)[0] if np.ndim(other) > np.ndim(one) else other)
    return alike(one, other)


def ended(name, given):
    given = dict(given)
    inner = [given.pop("self")] if "self" in given else []
    try:
        return function_of(name)(*inner, **given)
    finally:
        plt.close("all")


def wrong(name, key, path, number):
    """Return what is wrong with a call in which one value has another coat."""
    given, results = known()[name], []
    try:
        changed = {**given, key: dressed(given[key], path, number)}
    except (TypeError, ValueError):
        return None  # there is no such coat for it
    said = defect(lambda: results.append(ended(name, changed)))
    if said is None and results and not same(expected(name), results[0]):
        said = f"{results[0]!r:.300} instead of {expected(name)!r:.300}"
    return said and f"{name}, {key}{list(path)} as {changed[key]!r:.100}: {said}"


@functools.cache
def known():
    return calls()


@functools.cache
def expected(name):
    return ended(name, known()[name])


#: Calls that write or read a file that is not there, and those whose result is a text of what they were given.
LEFT_OUT = {
    "save",
    "load",
    "to_csv",
    "to_parquet",
    "to_wav",
    "check_certificate",
    "config.load_config",
    "config.toml_of",
}


def test_a_strategy_keeps_its_gates_as_numbers():
    """They were kept as they came: a generator was used up, and a strategy was never equal to itself read again."""
    told = gz.strategy(never, {"L": ((0.0, 1.0), (1.0, 1.0))}, 0.2)
    for line in (iter([(0.0, 1.0), (1.0, 1.0)]), np.array([[0.0, 1.0], [1.0, 1.0]]), [(Real(0.0), 1), [True + 0, 1.0]]):
        found = gz.strategy(never, {np.str_("L"): line}, 0.2)
        assert found == told and found.config == told.config
    with pytest.raises(gz.InputError, match="ends"):
        gz.strategy(never, {"L": {(0.0, 1.0), (1.0, 1.0)}}, 0.2)


def test_a_set_of_amplitudes_has_no_order():
    rig = dict(m=0.8, c=2.4, k=3200.0, gap=1.2e-3, frequency=14.0, reset=gz.newton(0.7))
    with pytest.raises(gz.InputError, match="order"):
        gz.Oscillator.from_si(force={2.5, 0.1}, **rig)


@pytest.mark.parametrize("between", [{"L", "R"}, ["L", ["R"]], {"L": 1, "R": 2}.keys(), (b"L", b"R"), ("L", ("R",))])
def test_words_are_texts_in_order(between):
    """Bare errors of a set that has no first, and of lists that are no texts."""
    with pytest.raises(gz.InputError, match="between"):
        gz.adding_tree(0.5, 0.2, 1, between)


def test_names_are_texts_whatever_they_come_from():
    """A name out of an array of names made another model, and bytes were the name of a system."""
    assert gz.disc(np.str_("A"), (0.0, 2.0), 0.5, gz.newton(0.5)) == gz.disc("A", (0.0, 2.0), 0.5, gz.newton(0.5))
    told, found = (gz.Map(step, params={one("a"): 3.2}, coordinates=(one("x"),)) for one in (str, np.str_))
    assert told == found and repr(told) == repr(found)
    with pytest.raises(gz.InputError, match="name"):
        gz.System(("x",), ("v",), {"r": 0.5}, never, [], ((0.0, 1.0), (0.0, 1.0)), name=b"ball")
    with pytest.raises(gz.InputError, match="rung"):
        gz.ladder(gz.pinball(), "d", rungs=xr.DataArray("a"))


@pytest.mark.parametrize(
    "letters", [5, b"LR", "", "LL", "L R", "\n\t", {"L": 1}, object(), range(10**12), itertools.repeat("L")]
)
def test_letters_are_characters_that_a_word_can_be_read_from(letters):
    """Words of an orbit were the same for different letters, and numbers ended in a TypeError of a study."""
    with pytest.raises(gz.InputError, match="letters"):
        gz.Map(step, params={"a": 0.5}, letters=letters)
    assert gz.Map(step, params={"a": 0.5}, letters=("L", "R")) == gz.Map(step, params={"a": 0.5}, letters="LR")


@pytest.mark.parametrize("escape", ["10", None, 1j, [1], -1.0, 0, np.nan, 10**400, np.array([1, 2])])
def test_a_place_from_which_orbits_escape_is_a_positive_number(escape):
    """-1 let every orbit escape at once, and a text failed in the compiler."""
    with pytest.raises(gz.InputError, match=r"escape.*; with inf, none does"):
        gz.Map(step, params={"a": 0.5}, escape=escape)


@pytest.mark.parametrize("number", [float, np.float32, np.float64, np.longdouble])
def test_orbits_may_escape_nowhere(number):
    assert type(gz.Map(step, params={"a": 0.5}, escape=number(np.inf)).escape) is float


@pytest.mark.long
@pytest.mark.parametrize("part", range(8))
def test_a_coat_changes_nothing(part):
    names = sorted(name for name in known() if name not in LEFT_OUT and "theory" not in name)
    tries = [
        (name, key, *site)
        for name in names[part::8]
        for key, value in known()[name].items()
        if key != "self"
        for site in sites(value)
    ]
    found = [said for given in tries if (said := wrong(*given))]
    assert tries and not found, "\n".join(found)
