import dataclasses

import pytest

from grazing.theory import Interval


def test_an_open_interval_leaves_out_its_ends():
    interval = Interval(-1.0, 2.0)
    assert 0.0 in interval
    assert -1.0 not in interval and 2.0 not in interval
    assert interval.width == 3.0 and not interval.empty
    assert tuple(interval) == (-1.0, 2.0)


def test_a_closed_interval_keeps_them():
    assert -1.0 in Interval(-1.0, 2.0, closed=True) and 2.0 in Interval(-1.0, 2.0, closed=True)
    assert 2.0000001 not in Interval(-1.0, 2.0, closed=True)


@pytest.mark.parametrize("interval", [Interval(1.0, 1.0), Interval(2.0, 1.0), Interval(2.0, 1.0, closed=True)])
def test_empty(interval):
    assert interval.empty and interval.width == 0.0
    assert 1.5 not in interval and 1.0 not in interval


def test_a_single_point_is_not_empty_when_closed():
    assert not Interval(1.0, 1.0, closed=True).empty and 1.0 in Interval(1.0, 1.0, closed=True)


def test_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Interval(0.0, 1.0).low = 0.5  # type: ignore[misc]
