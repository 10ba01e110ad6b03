"""Escape rates by populations: against cycles, closed forms, and themselves in another unit and on other threads."""

import numpy as np
import pytest

import grazing as gz
from grazing.outcome import ESCAPED
from grazing.studies.escape import aside
from tests.billiard.directions import cycles_of_directions
from tests.billiard.orbits import active_discs, bowl, pinball
from tests.billiard.tables import three_discs

#: Rates an impact from cycles: elastic, at r = 0.8 with a kick (tests/theory/test_cycles.py) and without (below).
ELASTIC, KICKED, PASSIVE = 0.78359404, 0.76935, 0.840742


def stretched(x, p):
    """A map that stretches [0, 1] by a slope; what leaves it has escaped."""
    y = p.slope * x[0] % (p.slope / p.kept)
    return (y,), 0, ESCAPED if y > 1.0 else 0


def leaky(slope=6.0, kept=2.0):
    return gz.Map(stretched, params={"slope": slope, "kept": kept}, coordinates=("x",), box=((0.0, 1.0),), name="leaky")


def test_a_piecewise_linear_map_lets_go_of_what_its_slopes_say():
    """Two branches of slope 6 onto [0, 3], of which [0, 1] stays: a third a step."""
    found = gz.escape_rate(leaky(), orbits=4000, transient=5, steps=20, stir=1e-3)
    assert abs(found.rate - np.log(3.0)) < 4.0 * found.error < 0.05
    assert found.lost == 0 and found.rates.shape == (8,) and "a step" in repr(found)


def test_many_small_populations_are_as_right_as_their_error_says():
    """Means of logarithms of shares, of populations with few orbits, were too large by twice the error."""
    found = gz.escape_rate(leaky(), orbits=400, transient=5, steps=10, populations=100, stir=0.02, threads=1)
    assert abs(found.rate - np.log(3.0)) < 2.5 * found.error < 0.03


def apart(x, p):
    """Two rooms, [0, 1] and [1, 2]: at each step a tenth leaves the one, a 20th the other; all change, or none."""
    y, room = 20.0 * (x[0] % 1.0), x[0] // 1.0
    return (abs(p.change - room) + y % 1.0,), 0, ESCAPED if y < 2.0 - room else 0


def test_a_decay_that_still_slows_down_is_in_the_error():
    """After 40 steps a tenth of those that stay is in the room of the faster decay: the rate was off by 15 errors."""
    found = gz.escape_rate(gz.Map(apart, {"change": 0.0}, box=((0.0, 2.0),), name="apart"), threads=1)
    assert 0.002 < found.rate + np.log(0.95) < 2.0 * found.error < 0.01


@pytest.mark.parametrize("transient", [1, 4, 25])
def test_a_single_step_of_a_decay_in_turns_has_its_error(transient):
    """All are in one room, then all in the other: what leaves in a step is not what does in two, by 16 errors."""
    P = gz.Map(apart, {"change": 1.0}, box=((0.0, 1.0),), name="apart")
    found = gz.escape_rate(P, orbits=4000, transient=transient, steps=1, threads=1)
    assert 0.01 < abs(found.rate + 0.5 * np.log(0.9 * 0.95)) < found.error < 0.1


def tent(x, p):
    """A tent of slope 3 over [0, 1], from below and above which everything escapes."""
    y = 3.0 * min(x[0], 1.0 - x[0])
    return (y,), 0, ESCAPED if x[0] < 0.0 or x[0] > 1.0 or y > 1.0 else 0


def test_copies_are_not_moved_out_of_the_box():
    """Those beside its ends escaped for having been moved: the rate was too large by seven times its error."""
    leaving = gz.Map(tent, coordinates=("x",), box=((0.0, 1.0),), name="tent")
    found = gz.escape_rate(leaving, orbits=10_000, transient=5, steps=20, threads=1)
    assert abs(found.rate - np.log(1.5)) < 3.0 * found.error < 0.02
    assert aside(np.array([[1.0]]), np.array([[5.25]]), np.array([[0.0, 2.0]])) == [[1.75]]


def doubling(x, p):
    """The doubling map, of which orbits escape from the hole [low, high)."""
    return (2.0 * x[0] % 1.0,), 0, ESCAPED if p.low <= x[0] < p.high else 0


@pytest.mark.parametrize(
    ("low", "high", "known", "within"),
    [
        (0.375, 0.5, -np.log((1.0 + 5.0**0.5) / 4.0), 0.01),  # no 011: 1/2 of the largest root of z^2 = z + 1
        (0.3125, 0.375, 0.060172861359, 0.002),  # no 0101: the largest root of z^4 - 2 z^3 + z^2 - 2 z + 1, over 2
        (0.25, 0.5, np.log(2.0), 0.1),  # no 01: n + 1 words of n digits are left, and the rate is log 2 - 1 / n
    ],
)
def test_a_hole_anywhere_in_the_doubling_map(low, high, known, within):
    """Copies moved over the edge of a hole, and zeros that 2 x mod 1 ends in, put it off by 160 times its error."""
    P = gz.Map(doubling, params={"low": low, "high": high}, box=((0.0, 1.0),), name="doubling")
    found = gz.escape_rate(P, orbits=5000, threads=1)
    assert abs(found.rate - known) < 2.5 * found.error < 2.5 * within


def test_copies_that_hardly_part_are_seen_in_those_moved_the_longest_ago():
    P = gz.Map(doubling, params={"low": 0.25, "high": 0.5}, box=((0.0, 1.0),), name="doubling")
    found = gz.escape_rate(P, orbits=3000, stir=0.002, threads=1)  # it was 7 errors off
    assert abs(found.rate - np.log(2.0)) < 2.5 * found.error < 0.3


@pytest.mark.parametrize(
    ("table", "known", "transient"), [(three_discs(3.0), ELASTIC, 8), (active_discs(3.0), KICKED, 30)]
)
def test_balls_leave_three_discs_as_fast_as_cycles_say(table, known, transient):
    found = gz.escape_rate(gz.collision_map(table), orbits=10_000, transient=transient, steps=15)
    assert abs(found.rate - known) < 4.0 * found.error < 0.02


def test_without_a_kick_balls_leave_as_fast_as_cycles_of_their_directions_say():
    """0.840742 an impact at r = 0.8: speed scales out, and tan(angle) grows by 1/r at each impact."""
    exact = gz.theory.cycle_expansion(cycles_of_directions(3.0, 0.8, 8), per="impact", contracting=False)
    assert exact.escape_rate == pytest.approx(PASSIVE, abs=1e-5) and exact.error < 1e-3
    found = gz.escape_rate(gz.collision_map(active_discs(3.0, V=0.0)), orbits=10_000, transient=10, steps=15)
    assert abs(found.rate - exact.escape_rate) < 4.0 * found.error < 0.02


def test_equal_seeds_give_equal_numbers_on_any_threads():
    P = gz.collision_map(active_discs(3.0))
    few = {"orbits": 1000, "transient": 3, "steps": 4, "populations": 2}
    one, two, other = (gz.escape_rate(P, **few, **more) for more in ({"threads": 1}, {"threads": 2}, {"seed": 1}))
    assert (one.rates == two.rates).all() and (one.rates != other.rates).all()


def test_a_table_in_other_units_lets_go_as_fast():
    few = {"orbits": 5000, "transient": 10, "steps": 10}
    small, large = (gz.escape_rate(gz.collision_map(pinball(0.8, scale)), **few) for scale in (1.0, 1024.0))
    assert small.rate == pytest.approx(large.rate, rel=1e-3) and small.lost == large.lost


def test_kicks_keep_balls_on_a_table_with_gravity():
    """The stronger they are the longer a ball stays over the drain."""
    rates = [
        gz.escape_rate(gz.collision_map(pinball(V)), orbits=3000, transient=20, steps=20).rate for V in (0.2, 0.4, 0.8)
    ]
    assert rates[0] > rates[1] + 0.05 > rates[2] + 0.05


def test_where_nothing_or_everything_escapes_it_says_so():
    closed = gz.collision_map(
        gz.table([*bowl().objects, gz.arc("lid", (0, 0), 2.0, 0.0, np.pi, gz.newton(0.9))], tilt=0.4)
    )
    with pytest.raises(gz.InputError, match="there may be no way out"):
        gz.escape_rate(closed, orbits=100, transient=1, steps=3)
    beyond = gz.Map(lambda x, p: (1.1 * x[0],), box=[(0.0, 1.0)], escape=1.0)  # diverged, which is something else
    with pytest.raises(gz.InputError, match=r"none .* ended otherwise; .* returning \(state, letter, 1024\)"):
        gz.escape_rate(beyond, orbits=100, transient=1, steps=3)
    with pytest.raises(gz.InputError, match="all 200 orbits have ended after 1 step"):
        gz.escape_rate(leaky(slope=1e9, kept=1e-9), orbits=200)
    with pytest.raises(gz.InputError, match="nothing escapes from an oscillator"):  # said after ten minutes of impacts
        gz.escape_rate(gz.stroboscopic_map(gz.pinball()))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"orbits": 10}, "orbits"), ({"steps": 0}, "steps"), ({"populations": 1}, "populations"),
        ({"stir": 0.0}, "stir is 0"), ({"stir": "much"}, "stir"), ({"transient": -1}, "transient"),
    ],
)  # fmt: skip
def test_options_out_of_range_are_refused(options, said):
    with pytest.raises(gz.InputError, match=said):
        gz.escape_rate(leaky(), **options)
    with pytest.raises(gz.InputError, match="give a map"):
        gz.escape_rate(three_discs(3.0))


@pytest.mark.long
@pytest.mark.parametrize(
    ("table", "transient", "exact"),
    [
        (three_discs(3.0), 10, ELASTIC), (active_discs(3.0, V=0.0), 40, PASSIVE),
        (active_discs(3.0, V=0.25), 40, KICKED), (active_discs(3.0, V=2.0), 40, KICKED),
    ],
)  # fmt: skip
def test_three_discs_with_errors_below_a_thousandth(table, transient, exact):
    """At r = 0.8 0.845 +- 0.01 without a kick and 0.770 +- 0.004 with any are known; impacts 40 to 80."""
    found = gz.escape_rate(gz.collision_map(table), orbits=100_000, transient=transient, populations=16)
    assert abs(found.rate - exact) < 4.0 * found.error < 0.004
