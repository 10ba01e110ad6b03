"""Values from the edges of what Python and its scientific packages can hand over, and the limits of a trial."""

from __future__ import annotations

import contextlib
import decimal
import fractions
import math
import os
import signal
import traceback
import warnings

import numpy as np
import pandas as pd
import xarray as xr

from grazing import GrazingError

#: Seconds and bytes of one trial.
SECONDS, MEMORY = 30, 3 * 2**30
#: How warnings begin that answer.
OURS = "the reset law|the gap is|the search flies|a compiled kernel could not be kept|rate = "

NUMBERS = [
    0,
    -0.0,
    5e-324,
    -5e-324,
    2.2e-308,
    1e-300,
    1e-100,
    1e-17,
    1e-8,
    0.1,
    0.5,
    1.0 - 2.0**-53,
    1,
    1.0 + 2.0**-52,
    -1,
    2,
    3,
    7.5,
    -2.5,
    1e8,
    2**31,
    2**53 + 1,
    2**63,
    -(2**63),
    1e100,
    1.7e154,
    1e300,
    1e308,
    -1e308,
    math.nan,
    math.inf,
    -math.inf,
]
ODD = [
    True,
    False,
    None,
    "",
    "a",
    "1",
    "nan",
    "d",
    "mu",
    "x",
    "L",
    "0C",
    "\0",
    "é" * 3,
    "9" * 5000,
    b"1",
    10**400,
    -(10**400),
    10**5000,
    1j,
    complex(0.5, 0.0),
    np.float64(0.5),
    np.float32(0.1),
    np.int8(3),
    np.uint64(2**64 - 1),
    np.bool_(True),
    np.complex64(1.0),
    np.array(0.5),
    np.array([0.5]),
    np.array([]),
    np.zeros((2, 3)),
    np.zeros((2, 2, 2)),
    np.array(["a"]),
    np.array([None, 1.0], dtype=object),
    np.full(3, np.nan),
    np.array([1.0, np.inf]),
    np.datetime64("2000-01-01"),
    np.timedelta64(5),
    np.ma.masked,
    np.linspace(0.0, 1.0, 5),
    np.linspace(0.1, 0.2, 3)[::-1],
    np.zeros(3),
    np.zeros(100_000),
    pd.NA,
    pd.NaT,
    pd.Timestamp("2000-01-01"),
    pd.Series([0.1, 0.2]),
    pd.Series([], dtype=float),
    pd.DataFrame({"a": [0.1]}),
    xr.DataArray(0.5),
    xr.DataArray([0.1, 0.2]),
    xr.Dataset(),
    fractions.Fraction(1, 3),
    fractions.Fraction(10) ** 400,
    decimal.Decimal("0.5"),
    decimal.Decimal("NaN"),
    decimal.Decimal("sNaN"),
    decimal.Decimal("1e999"),
    [],
    [0.5],
    [0.1, 0.2],
    [0.2, 0.1],
    [0.1, 0.1],
    [[0.1, 0.2]],
    [[]],
    [None],
    ["a"],
    (),
    (0.1,),
    (0.1, 0.2),
    (0.2, 0.1),
    (0.0, 0.0),
    (1e308, -1e308),
    (-1e308, 1e308),
    (math.nan, 1.0),
    ((0.0, 1.0),),
    ((0.0, 1.0), (0.0, 1.0)),
    {},
    {"a": 1},
    {"mu": 0.1},
    {"mu": [0.1, 0.2]},
    {"d": [0.1]},
    {None: 1},
    {0.5: 0.5},
    {1, 2},
    set(),
    range(3),
    range(0),
    range(10**12),
    slice(3),
    object(),
    float,
    len,
    math,
    lambda *_a: 0.5,
    lambda *_a: 1 / 0,
    iter([1.0]),
    Ellipsis,
    type("Own", (), {"__float__": lambda _s: 1 // 0})(),
    type("Odd", (), {"__repr__": lambda _s: 1 // 0})(),
]


def extreme(random):
    """Return an extreme value: a number half of the time."""
    return random.choice(NUMBERS) if random.random() < 0.5 else random.choice(ODD)


def mutated(value, random):
    """Return a value with something in it replaced, or another one."""
    if random.random() < 0.5:
        if isinstance(value, dict) and value:
            key = random.choice(list(value))
            return {**value, key: mutated(value[key], random)}
        if type(value) in (list, tuple) and value:
            i = random.randrange(len(value))
            return type(value)([*value[:i], mutated(value[i], random), *value[i + 1 :]])
        if isinstance(value, np.ndarray) and value.size and value.dtype.kind == "f":
            other = value.copy()
            other.flat[random.randrange(other.size)] = random.choice(NUMBERS)
            return other
    return extreme(random)


class Hang(BaseException):
    """A trial that takes too long."""


@contextlib.contextmanager
def limited(seconds=SECONDS):
    """Let a trial take only so much time and memory, and take any warning that is not ours for an error."""
    import resource

    def late(*_args):
        raise Hang(f"longer than {seconds} s")

    before, kept = signal.signal(signal.SIGALRM, late), resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * os.sysconf("SC_PAGESIZE")
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, kept[1]))
    signal.alarm(seconds)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=OURS)
            yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, kept)


def defect(run):
    """Run a trial; return what is wrong with its end, None if it ended with a result or a message of ours."""
    try:
        with limited():
            run()
    except GrazingError as error:
        said = str(error)
        if len(said) > 20_000:
            return f"a message of {len(said)} letters: {said[:300]}"
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:
        frames = traceback.extract_tb(error.__traceback__)
        ours = [frame for frame in frames if "/grazing/" in frame.filename]
        if isinstance(error, TypeError) and (not ours or "os.PathLike" in str(error)):
            return None  # the call itself is none: an argument too many, or missing; a path is refused as Python does
        at = f"{ours[-1].filename.rpartition('/grazing/')[2]}:{ours[-1].lineno} {ours[-1].line}" if ours else "?"
        return f"{type(error).__name__}: {str(error)[:200]} at {at}"
    return None


def shown_safely(value):
    """Return a value as a report shows it, whatever it is."""
    try:
        return repr(value)[:100]
    except Exception:
        return f"<{type(value).__name__}>"
