"""No forged certificate is accepted that says anything false."""

import json
from collections import Counter
from copy import deepcopy
from importlib.resources import files
from math import ldexp

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from mpmath import mp, mpf

from grazing_checker import Rejected, check
from tests.grazing_checker.bases import GAP_NAMES, KINDS, TABLE_NAMES, TABLE_VALUE_NAMES, bases
from tests.grazing_checker.documents import NAMES, documents
from tests.grazing_checker.forgeries import elsewhere, forgeries, sealed
from tests.grazing_checker.truth import is_true, rig_of
from tests.grazing_checker.truth_walls import entries_of, exponential

WHOLE = Draft202012Validator(json.loads((files("grazing_checker") / "schema.json").read_text()))
#: Forgeries of each kind in a short run and in a long one.
SHORT = dict(zip(KINDS, (40, 60, 60, 30, 30, 40, 170, 160, 100), strict=True))
LONG = dict(zip(KINDS, (900, 1200, 1200, 700, 700, 1200, 3200, 3200, 2000), strict=True))


def attack(kind, count, seed, only=()):
    """Return how many forgeries were refused, and how many accepted because they are true, and fit the schema."""
    known = {one["statement"] for one in bases().values()}
    found = Counter()
    for ways, document in forgeries(kind, list(bases().values()), count, seed, only):
        try:
            said = check(document)
        except Rejected:
            found["refused"] += 1
            continue
        assert said == document["statement"] and WHOLE.is_valid(document)
        if said not in known:
            true, why = is_true(kind, document["data"])
            assert true, f"{ways}: accepted, but {why}: {said}"
            known.add(said)
        found["true"] += 1
    return found


@pytest.mark.parametrize("name", [*NAMES, *GAP_NAMES, *TABLE_NAMES, *TABLE_VALUE_NAMES])
def test_true_certificates_are_accepted_and_true(name):
    document = bases()[name]
    assert check(document) == document["statement"]
    assert is_true(document["kind"], document["data"]) == (True, "")


@pytest.mark.parametrize("kind", KINDS)
def test_no_forgery_is_accepted_that_is_false(kind):
    found = attack(kind, SHORT[kind], "short")
    assert found.total() == SHORT[kind]
    assert 0.5 * SHORT[kind] < found["refused"] < SHORT[kind]  # those that are true pass, so the forger gets far


VALUES = ("bifurcation value", "bifurcation value with walls", "bifurcation value on a table")


@pytest.mark.parametrize("name", [*NAMES, *TABLE_NAMES, *TABLE_VALUE_NAMES])
def test_the_forger_writes_all_the_numbers_that_are_claimed(name):
    """Where he stops before the end all is refused for the claims that stay, and nothing else is tried."""
    base = bases()[name]
    data = deepcopy(base["data"])
    claims = data["claims"]
    intervals = [claims[key] for key in ("value", "time", "trace", "det") if key in claims]
    for interval in [*intervals, *claims["box"], *claims.get("incoming", ()), *claims.get("sums", ())]:
        interval[:] = ["0", "0"]
    forged = sealed(base["kind"], data, base["inequalities"])
    assert check(forged) == forged["statement"]


def elsewhere_only(kind, count, seed):
    """Curves of orbits that are right, each with its ends and its matrix, but beside the bifurcation, or over it."""
    found = attack(kind, count, seed, (elsewhere,))
    assert found.total() == count and found["refused"] > 0
    return found


@pytest.mark.parametrize("kind", VALUES)
def test_no_curve_beside_a_bifurcation_is_accepted(kind):
    elsewhere_only(kind, 4, "short")


@pytest.mark.long
@pytest.mark.parametrize("kind", VALUES)
def test_no_curve_of_many_beside_a_bifurcation_is_accepted(kind):
    assert elsewhere_only(kind, 300, "long")["true"] > 0


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_no_forgery_of_very_many_is_accepted_that_is_false(kind):
    found = attack(kind, LONG[kind], "long")
    assert found.total() == LONG[kind]
    assert 0.5 * LONG[kind] < found["refused"] < LONG[kind]


def test_there_are_500_and_10000():
    assert sum(SHORT.values()) >= 500 and min(SHORT.values()) >= 30
    assert sum(LONG.values()) >= 10_000 and min(LONG.values()) >= 500


#: What numbers of a model are in units of length and of time, as powers.
UNITS = {"alpha": (0, -1), "k": (0, -1), "omega": (0, -1), "t0": (0, 1), "offset": (1, -2), "sigma": (1, 0)}


@pytest.mark.parametrize("length, time", [(0, 14), (20, -14)])
def test_truth_is_told_in_any_unit(length, time):
    """Differences of 1e-15 and flights shorter than 1000, whatever the unit, called right certificates false."""
    data = documents()["rattle"]["data"]
    other, n = deepcopy(data), len(data["impacts"])

    def scaled(text, powers):
        return ldexp(float.fromhex(text), powers[0] * length + powers[1] * time).hex()

    for part, amplitude in ((other["model"], (1, -2)), *((wall, (1, 0)) for wall in other["walls"])):
        part |= {name: scaled(part[name], powers) for name, powers in UNITS.items() if name in part}
        part |= {name: [scaled(text, amplitude) for text in part[name]] for name in ("cos", "sin")}
    with mp.workdps(36):
        x = [sum(map(mpf, one)) / 2 for one in data["claims"]["box"]]
        there = [mp.ldexp(one, time if i < n else length - time) for i, one in enumerate(x)]
        for one, two in zip(rig_of(data).trace_and_det(x), rig_of(other).trace_and_det(there), strict=True):
            assert abs(one - two) < mpf(10) ** -18 * abs(one)


@given(st.lists(st.floats(-100.0, 100.0), min_size=25, max_size=25), st.floats(0.0, 1.3))
def test_the_exponentials_by_which_truth_is_told_are_right(numbers, t):
    M = mp.matrix([[mpf(x) for x in numbers[i : i + 5]] for i in range(0, 25, 5)])
    with mp.workdps(36):
        found = exponential(entries_of(M), mpf(t))
    with mp.workdps(400):
        right = mp.expm(M * mpf(t))
        off, size = (max(abs(x) for x in one) for one in (found - right, right))
    assert off <= mpf(10) ** -35 * size
