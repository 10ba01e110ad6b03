"""The portrait: the two-dimensional histogram of the orbit diagram, without its points."""

import numpy as np
import pytest

import grazing as gz
from grazing.catalogue import studies
from grazing.studies.portrait import counted, middles
from tests.studies.maps import FOLLOWER, HENON

BALL = gz.stroboscopic_map(gz.pinball(V=0.4, d=0.1))
CASES = {
    "Henon, some escape": (HENON.replace(a=1.55), "x", "y", ((-1.0, 1.2), (-0.2, 0.3))),
    "turned": (HENON, "y", "x", ((-0.4, 0.4), (-1.5, 1.5))),
    "three dimensions": (FOLLOWER, "x", "z", ((0.2, 0.8), (-3.0, 3.0))),
    "oscillator": (BALL, "v", "u", ((-0.2, 0.1), (0.0, 0.2))),
}
SMALL = {"starts": 30, "transient": 40, "keep": 300}


@pytest.mark.parametrize("arithmetic", ["fast", "strict"])
@pytest.mark.parametrize("kind", CASES)
def test_counts_are_the_histogram_of_the_orbit_diagram(kind, arithmetic):
    P, across, up, within = CASES[kind]
    starts = np.random.default_rng(4).uniform(*np.array(P.box).T, (30, P.dimension))
    more = {**SMALL, "starts": starts, "arithmetic": arithmetic}
    found = gz.portrait(P, across, up, bins=23, within=within, **more)
    name = next(iter(P.params))
    points = gz.orbit_diagram(P, name, [P.params[name]], **more)
    x, y = (points[one].values.ravel() for one in (across, up))
    assert found["count"].dims == (up, across)
    assert found["count"].values.T.tolist() == np.histogram2d(x, y, 23, within)[0].tolist()
    assert int(found["count"].sum() + found.beyond) == (np.isfinite(x) & np.isfinite(y)).sum()
    assert int(found.ended) == (points.period.values == -2).sum() and int(found.left) == 0
    assert found[across].values == pytest.approx(middles(*within[0], 23))


def test_it_is_of_the_first_two_coordinates_where_nobody_says_which():
    assert gz.portrait(FOLLOWER, bins=3, **SMALL)["count"].dims == FOLLOWER.coordinates[1::-1]
    x, y, _z = FOLLOWER.coordinates
    assert gz.portrait(FOLLOWER, y, bins=3, **SMALL)["count"].dims == (x, y)
    assert gz.portrait(FOLLOWER, up=x, bins=3, **SMALL)["count"].dims == (x, y)


def test_the_range_of_a_trial_holds_nearly_all_and_is_kept():
    found = gz.portrait(HENON, bins=10, starts=50, transient=100, keep=500)
    assert int(found.beyond) < 0.001 * 50 * 500 and (found["count"].sum("x") > 0).mean() > 0.7
    ends = [(found[name].attrs["low"], found[name].attrs["high"]) for name in ("x", "y")]
    assert found["count"].equals(gz.portrait(HENON, bins=10, starts=50, transient=100, keep=500, within=ends)["count"])


def test_a_cycle_is_shown_in_a_range_that_can_be_read():
    found = gz.portrait(BALL.replace(d=0.16), bins=9, starts=5, transient=300, keep=50)
    for name in ("u", "v"):
        low, high = found[name].attrs["low"], found[name].attrs["high"]
        assert high - low >= 1e-6 * max(abs(high), abs(low))
    assert int(found.beyond) == 0


def test_for_how_long_balls_are_where():
    """A ball that bounces without loss is at height y for a time that goes as 1 / speed."""
    floor = gz.segment("floor", (-9.0, 0.0), (9.0, 0.0), gz.newton(1.0))
    table = gz.table([floor], rho=0.1, g=1.0, tilt=np.pi / 2)
    starts = [(0.0, 0.1 + h, 0.0, 0.0) for h in np.linspace(0.99, 1.0, 50)]
    found = gz.portrait(
        gz.stroboscopic_map(table, period=0.01), bins=10, within=((-1.0, 1.0), (0.1, 1.1)), starts=starts,
        transient=0, keep=20_000,
    )  # fmt: skip
    share = found["count"].sum("x").values / found["count"].values.sum()
    edges = np.linspace(0.0, 1.0, 11)
    truth = np.zeros(10)
    for h in np.linspace(0.99, 1.0, 50):
        above = np.sqrt(np.maximum(1.0 - edges / h, 0.0))
        truth += (above[:-1] - above[1:]) / 50
    assert share == pytest.approx(truth, abs=2e-3)


@pytest.mark.parametrize("transient", [0, 40])
def test_a_ball_that_has_left_is_not_counted(transient):
    table = gz.table([gz.drain("out", (-5.0, 0.0), (5.0, 0.0))], tilt=0.3)
    P = gz.stroboscopic_map(table, period=0.1)
    starts = [(0.0, 0.5 * k, 0.1, 0.0) for k in range(1, 30)]
    found = gz.portrait(P, bins=7, within=((-5.0, 5.0), (0.0, 20.0)), starts=starts, transient=transient, keep=60)
    alive = 0
    for start in starts:
        fall = np.sqrt(2.0 * start[1] / table.gravity) / 0.1
        alive += min(int(np.ceil(fall)) - 1, transient + 60) - min(int(np.ceil(fall)) - 1, transient)
    assert int(found["count"].sum()) == alive and int(found.beyond) == 0
    gone = sum(np.sqrt(2.0 * start[1] / table.gravity) <= 0.1 * (transient + 60) for start in starts)
    assert int(found.left) == gone
    free = gz.portrait(P, bins=7, starts=starts, transient=0, keep=60)
    assert (
        free["y"].attrs["high"] < 20.0 and free["x"].attrs["high"] < 10.0
    )  # where balls lie that have left is no place


def test_the_last_part_is_closed_and_what_is_no_number_nowhere():
    count, beyond = np.zeros((2, 2), np.int64), np.zeros(1, np.int64)
    points = np.array([[[0.0, 1.0, 0.5, 1.5, np.nan]], [[0.0, 2.0, 1.0, 0.0, 0.0]]]).transpose(1, 0, 2)
    counted(points, np.ones((1, 5), bool), [(0.0, 1.0), (0.0, 2.0)], 2, count, beyond)
    assert (count.tolist(), beyond.tolist()) == ([[1, 0], [0, 2]], [1])


@pytest.mark.parametrize(
    ("P", "given", "says"),
    [
        (gz.gap_map(0.5, 0.07, 0.1), {}, "has one coordinate, x; gz.density"),
        (HENON, {"across": "z"}, "across = 'z'; allowed are x, y"),
        (HENON, {"up": 3}, "up = 3; allowed are x, y"),
        (HENON, {"across": "x", "up": "x"}, "across and up are both x"),
        (HENON, {"within": ((0, 1),)}, "within has 1 intervals for 2 coordinates"),
        (HENON, {"within": ((0, 1), (1, 1))}, "within of y"),
        (HENON, {"bins": 0}, "bins"),
        (HENON, {"bins": 10**8}, "reduce bins"),
    ],
)
def test_what_is_refused(P, given, says):
    with pytest.raises(gz.InputError, match=says):
        gz.portrait(P, **given)


def test_told_and_drawn():
    study, found = studies()["portrait"], gz.portrait(HENON.replace(a=1.55), bins=20, **SMALL)
    told = study.words(study.found(found))
    assert told[0].startswith(f"{int(found['count'].sum())} points counted over x from ") and " and y from " in told[0]
    assert told[-1] == f"{int(found.ended)} orbits ended"
    drawn = gz.plot.portrait(found, units="count")
    assert drawn["image"].get_array().sum() > 0 and f"{int(found.ended)} starts ended" in drawn["note"].get_text()
    assert drawn["figure"].axes[0].get_aspect() == "auto"
    floor = gz.drain("out", (-5.0, 0.0), (5.0, 0.0))
    seen = gz.portrait(gz.stroboscopic_map(gz.table([floor], tilt=0.3)), bins=9, starts=20, transient=0, keep=9)
    assert gz.plot.portrait(seen)["figure"].axes[0].get_aspect() == 1.0
