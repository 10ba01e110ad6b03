"""No forged certificate is accepted that says anything false."""

from collections import Counter

import pytest

from grazing_checker import Rejected, check
from tests.grazing_checker.bases import KINDS, bases
from tests.grazing_checker.forgeries import forgeries
from tests.grazing_checker.truth import is_true

#: Forgeries of each kind in a short run and a long one.
SHORT = {"periodic orbit": 70, "bifurcation value": 50, "gap map orbit": 150, "gap map edge": 150, KINDS[4]: 100}


def attack(kind, count, seed):
    """Return how many forgeries were refused, and how many accepted because they are true."""
    known = {one["statement"] for one in bases().values()}
    found = Counter()
    for ways, document in forgeries(kind, list(bases().values()), count, seed):
        try:
            said = check(document)
        except Rejected:
            found["refused"] += 1
            continue
        assert said == document["statement"]
        if said not in known:
            true, why = is_true(kind, document["data"])
            assert true, f"{ways}: accepted, but {why}: {said}"
            known.add(said)
        found["true"] += 1
    return found


@pytest.mark.parametrize("name", list(bases()))
def test_true_certificates_are_accepted_and_true(name):
    document = bases()[name]
    assert check(document) == document["statement"]
    assert is_true(document["kind"], document["data"]) == (True, "")


@pytest.mark.parametrize("kind", KINDS)
def test_no_forgery_is_accepted_that_is_false(kind):
    found = attack(kind, SHORT[kind], "short")
    assert found.total() == SHORT[kind]
    assert found["refused"] > 0.5 * SHORT[kind]


def test_the_short_run_has_500():
    assert sum(SHORT.values()) >= 500 and min(SHORT.values()) >= 50
