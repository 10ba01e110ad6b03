"""No forged certificate is accepted that says anything false."""

import json
from collections import Counter
from importlib.resources import files

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from mpmath import mp, mpf

from grazing_checker import Rejected, check
from tests.grazing_checker.bases import GAP_NAMES, KINDS, TABLE_NAMES, TABLE_VALUE_NAMES, bases
from tests.grazing_checker.documents import NAMES
from tests.grazing_checker.forgeries import elsewhere, forgeries
from tests.grazing_checker.truth import is_true
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


@given(st.lists(st.floats(-100.0, 100.0), min_size=25, max_size=25), st.floats(0.0, 1.3))
def test_the_exponentials_by_which_truth_is_told_are_right(numbers, t):
    M = mp.matrix([[mpf(x) for x in numbers[i : i + 5]] for i in range(0, 25, 5)])
    with mp.workdps(36):
        found = exponential(entries_of(M), mpf(t))
    with mp.workdps(400):
        right = mp.expm(M * mpf(t))
        off, size = (max(abs(x) for x in one) for one in (found - right, right))
    assert off <= mpf(10) ** -35 * size
