"""Windows along a branch whose test functions are known: all zeros, those that matter, and branches that are lost."""

import numpy as np
import pytest

from grazing.compare.branches import Point
from grazing.compare.edges import march, windows_on


class Known:
    """A rung with given test functions of s; there is no orbit beyond ``end``."""

    def __init__(self, pd, lp, left, end=np.inf):
        self.N, self.functions, self.left, self.end = 1 + len(left), (pd, lp), left, end

    def at(self, s, near):
        if s > self.end:
            return None
        tests = np.array([self.functions[0](s), self.functions[1](s), 1.0])
        return Point(s, 0.0, 10.0 - s * s, tests, np.array([f(s) for f in self.left]))


def windows(rung, speeds=None):
    speeds = np.linspace(0.05, 4.0, 40).tolist() if speeds is None else speeds
    return windows_on(rung, march(rung, speeds, len(speeds) // 2, None))


def above(zero):
    return lambda s: s - zero


def below(zero):
    return lambda s: zero - s


def test_edges_are_the_zeros():
    (window,) = windows(Known(above(0.7), lambda s: 1.0, [below(3.0), below(2.0), below(3.5)]))
    assert (window.slow.type, window.slow.dip, window.slow.point.s) == ("pd", 0, pytest.approx(0.7, abs=1e-15))
    # of three points left of the border the second one reaches it first: two dips before the impact
    assert (window.fast.type, window.fast.dip, window.fast.point.s) == ("gr", 2, pytest.approx(2.0, abs=1e-15))
    assert window.fast.value == pytest.approx(6.0)


def test_several_windows_and_a_zero_that_changes_nothing():
    found = windows(Known(lambda s: (s - 1.0) * (s - 1.5) * (s - 3.0), lambda s: 1.0, []))
    assert [(w.slow.point.s, w.fast.point.s) for w in found] == [
        (pytest.approx(1.0), pytest.approx(1.5)),
        (pytest.approx(3.0), 4.0),
    ]
    assert found[1].fast.type == "end"
    # lp is positive from 0.5 on, pd from 2 on: one window
    (window,) = windows(Known(above(2.0), above(0.5), []))
    assert window.slow.type == "pd" and window.fast.type == "end"
    assert windows(Known(lambda s: -1.0, lambda s: 1.0, [])) == []


def test_a_branch_that_is_lost_ends_there():
    rung = Known(above(0.7), lambda s: 1.0, [], end=2.5)
    (window,) = windows(rung)
    assert window.fast.type == "end" and 2.4 < window.fast.point.s <= 2.5
    assert windows(Known(above(0.7), lambda s: 1.0, [], end=0.01)) == []
    assert march(rung, [1.0, 3.0], 1, None) == []
