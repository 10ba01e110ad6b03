"""What stands on a table: names, ranges, laws."""

import copy
import pickle
from math import pi

import pytest

import grazing as gz
from grazing.billiard.objects import GEOMETRY

LAW = gz.active(r=0.9, V=0.4)
ALL = (
    gz.disc("bumper", (2, 6), 0.5, LAW), gz.segment("left", (0, 0), (0, 10), LAW),
    gz.arc("dome", (3, 7), 3.0, 0.0, pi, LAW), gz.drain("out", (0, 0), (6, 0)),
)  # fmt: skip


@pytest.mark.parametrize("one", ALL, ids=lambda one: one.kind)
def test_objects_are_frozen_values(one):
    assert pickle.loads(pickle.dumps(one)) == one == copy.deepcopy(one)
    assert list(one.shape) == [known.name for known in GEOMETRY[one.kind]]
    assert one.replaced(one.params) == one
    with pytest.raises(AttributeError):
        one.name = "other"
    with pytest.raises(TypeError):
        one.shape["x"] = 0.0
    assert one.name in repr(one) and one.describe("nothing") is None
    for name in one.params:
        known = one.describe(name)
        assert known.name == f"{one.name}.{name}" and known.meaning.endswith(one.name)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: gz.disc("1st", (0, 0), 1.0, LAW), "name of a disc is '1st'; allowed are letters"),
        (lambda: gz.disc("a.b", (0, 0), 1.0, LAW), "name of a disc is 'a.b'"),
        (lambda: gz.disc(3, (0, 0), 1.0, LAW), "name of a disc is 3"),
        (lambda: gz.drain("_out", (0, 0), (1, 0)), "name of a drain is '_out'"),
        (lambda: gz.disc("A", (0, 0), -1.0, LAW), r"A.radius = -1; allowed is A.radius >= 0"),
        (lambda: gz.arc("A", (0, 0), 0.0, 0.0, 1.0, LAW), r"A.radius = 0; allowed is A.radius > 0"),
        (lambda: gz.disc("A", (0, 0, 0), 1.0, LAW), r"centre of 'A' is \(0, 0, 0\); give a point"),
        (lambda: gz.disc("A", "xy", 1.0, LAW), "centre of 'A' is 'xy'"),
        (lambda: gz.segment("A", (0, float("nan")), (1, 0), LAW), "start of 'A' = nan is not finite"),
        (lambda: gz.segment("A", (1, 2), (1, 2), LAW), r"both ends of A are at \(1, 2\)"),
        (lambda: gz.arc("A", (0, 0), 1.0, 1.0, 1.0, LAW), "A goes from 1 to 1; allowed is start < stop"),
        (lambda: gz.arc("A", (0, 0), 1.0, 0.0, 7.0, LAW), "A goes from 0 to 7"),
        (lambda: gz.disc("A", (0, 0), 1.0, 0.9), "law of A is 0.9; give gz.newton"),
        (lambda: gz.disc("A", (0, 0), 1.0, gz.reset(lambda v, p: -p.x * v, x=0.5)), "parameter 'x', as its shape has"),
        (lambda: gz.active(r=0.9, V=-1.0), "V = -1; allowed is V >= 0"),
    ],
)
def test_wrong_objects_are_refused(make, said):
    with pytest.raises(gz.InputError, match=said):
        make()
