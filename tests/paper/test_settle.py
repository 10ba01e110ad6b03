import pytest

from grazing.maps.gap import gap_map
from grazing.oscillator.model import pinball
from grazing.paper.exact_zdm import flown, orders, sample
from grazing.paper.settle import settled, words


def test_a_cycle_is_found_and_chaos_is_none():
    cycle = settled(gap_map(0.8, 0.5, 1.0), (-0.5,))
    assert (cycle.period, cycle.word) == (3, "001")
    assert settled(gap_map(0.9, 0.1, 0.0), (-0.05,), transient=500).period == 0


def test_words_of_random_starts():
    assert words(gap_map(0.5, 0.0427, 0.1), 200, 2000) == {"001", "0001"}
    assert words(gap_map(0.9, 0.1, 0.0), 8, 2000) == {""}


def test_free_flight_runs_backwards():
    m = pinball()
    there = flown(m, 0.3, (0.2, -0.1), -0.05)
    assert flown(m, 0.25, there, 0.05) == pytest.approx((0.2, -0.1), abs=1e-14)


def test_the_exact_zero_time_map_closes_over_no_time():
    """Forward through the impact by the time to the wall and a bit, from both ends, is the same state."""
    m = pinball(V=0.2)
    each = sample(m, 0.33, 0.02, 0.01)
    after = flown(m, each["phase"], each["exact"], 0.05)
    rebound = flown(m, 0.33, (0.0, 0.8 * 0.02 + 0.2), 0.04)
    assert after == pytest.approx(rebound, abs=1e-14)


def test_orders_of_the_local_map():
    found = orders(pinball(V=0.0), 0.33, 1.0)
    assert found["full"] == pytest.approx((3.0, 2.0), abs=0.1)
    assert found["lowest"] == pytest.approx((2.0, 2.0), abs=0.1)
    active = orders(pinball(V=0.4), 0.33, 1.0)
    assert active["full"] == pytest.approx((2.0, 1.0), abs=0.1)
    assert active["lowest"] == pytest.approx((1.0, 1.0), abs=0.1)
