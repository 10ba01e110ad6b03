"""The density: the histogram of the orbit diagram, without its points."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import memory
from grazing.studies.density import BLOCK, compiled_raster, density, plan, raster
from grazing.studies.orbit_diagram import orbit_diagram
from grazing.studies.trial import ROOM
from tests.studies.maps import FOLLOWER, HENON, LOGISTIC

GAP = gz.gap_map(0.9, 0.1, 0.0)
BALL = gz.stroboscopic_map(gz.pinball(V=0.4))
CASES = {
    "gap map": (GAP, "mu", np.linspace(0.2, -0.05, 7), "x", (-0.3, 0.1)),
    "logistic": (LOGISTIC, "a", [3.2, 3.7, 4.0], "x", (0.25, 0.75)),
    "Henon, some escape": (HENON, "a", [1.4, 1.55, 2.0], "y", (-0.2, 0.3)),
    "three dimensions": (FOLLOWER, "c", [-0.3, 0.8], "z", (0.0, 2.0)),
    "oscillator": (BALL, "d", np.linspace(0.05, 0.15, 5), "v", (-0.2, 0.1)),
    "moving box": (BALL, "sigma", [-0.2, 0.0, 0.1], "u", (-0.1, 0.3)),
    "impact map": (gz.impact_map(gz.pinball(V=0.1)), "d", [0.05, 0.12], "tau", (0.0, 2.0)),
}
SMALL = {"starts": 30, "transient": 40, "keep": 300}


@pytest.mark.parametrize("arithmetic", ["fast", "strict"])
@pytest.mark.parametrize("kind", CASES)
def test_counts_are_the_histogram_of_the_orbit_diagram(kind, arithmetic):
    P, name, values, shown, (low, high) = CASES[kind]
    more = {**SMALL, "seed": 4, "arithmetic": arithmetic}
    found = density(P, name, values, bins=37, coordinate=shown, range=(low, high), **more)
    points = orbit_diagram(P, name, values, **more)
    assert found["count"].dims == (name, shown) and found["count"].dtype == np.int64
    for q in range(len(values)):
        x = points[shown].values[q]
        assert found["count"].values[q].tolist() == np.histogram(x, 37, (low, high))[0].tolist()
        assert found.below.values[q] == (x < low).sum() and found.above.values[q] == (x > high).sum()
        assert found.ended.values[q] == (points.period.values[q] == -2).sum()
        assert found["count"].values[q].sum() + found.below[q] + found.above[q] == np.isfinite(x).sum()
    assert (found[name] == points[name]).all()
    assert found[shown].values == pytest.approx(low + (np.arange(37) + 0.5) * (high - low) / 37)
    assert (found[shown].attrs["low"], found[shown].attrs["high"]) == (low, high)


@pytest.mark.parametrize("kind", ["gap map", "oscillator", "moving box"])
def test_neither_threads_nor_order_nor_neighbours_change_a_count(kind):
    P, name, values, shown, ends = CASES[kind]
    one = density(P, name, values, bins=20, coordinate=shown, range=ends, threads=1, **SMALL)
    xr.testing.assert_identical(
        one, density(P, name, values, bins=20, coordinate=shown, range=ends, threads=4, **SMALL)
    )
    alone = density(P, name, values[2:3], bins=20, coordinate=shown, range=ends, **SMALL)
    assert np.array_equal(alone["count"].values[0], one["count"].values[2])


@pytest.mark.parametrize("kind", CASES)
def test_the_raster_of_the_trial_holds_what_the_trial_saw(kind):
    P, name, values, shown, _ends = CASES[kind]
    some = density(P, name, values, bins=10, coordinate=shown, starts=12, transient=50, keep=80)
    x = orbit_diagram(P, name, values, starts=12, transient=50, keep=80)[shown].values
    low, high = np.nanmin(x), np.nanmax(x)
    assert some[shown].attrs["low"] == pytest.approx(low - ROOM * (high - low), rel=1e-12)
    assert some[shown].attrs["high"] == pytest.approx(high + ROOM * (high - low), rel=1e-12)
    assert not some.below.any() and not some.above.any()
    config = json.loads(some.attrs["grazing_config"])
    assert config["range"] == [some[shown].attrs["low"], some[shown].attrs["high"]]


def test_the_trial_looks_at_some_values_and_starts_only():
    plan(GAP, "mu", np.linspace(0, 0.3, 100_000), starts=1000, keep=10**7, transient=300)  # within a moment
    given = np.linspace(-1, 1, 500)[:, None]
    found = plan(GAP, "mu", [0.1, 0.2], starts=given, keep=200)
    x = orbit_diagram(GAP, "mu", [0.1, 0.2], starts=given[:20], keep=100).x.values
    assert found.config["range"][0] == pytest.approx(x.min() - ROOM * np.ptp(x), rel=1e-12)


def test_a_fixed_point_has_a_raster_around_it():
    found = density(gz.gap_map(0.5, -0.2, 0.1), "mu", [-0.2], bins=3, starts=5)
    low, high = found.x.attrs["low"], found.x.attrs["high"]
    assert low < -0.4 < high and high - low < 1e-4
    assert found["count"].values.sum() == 5 * 500


def counted(x, low, high, bins):
    counts = np.zeros((1, bins + 3), np.int64)
    compiled_raster()(np.asarray(x, np.float64)[None, None, None], 0, low, high, bins, counts)
    plain = np.zeros((1, bins + 3), np.int64)
    raster(np.asarray(x, np.float64)[None, None, None], 0, low, high, bins, plain)
    assert np.array_equal(counts, plain)
    return counts[0].tolist()


def test_ends_infinities_and_what_is_not_a_number():
    inf, nan = np.inf, np.nan
    assert counted([0.0, 0.25, 0.5, 1.0], 0.0, 1.0, 4) == [0, 1, 1, 1, 1, 0, 0]  # both ends count
    assert counted([np.nextafter(0.0, -1.0), np.nextafter(1.0, 2.0)], 0.0, 1.0, 4) == [1, 0, 0, 0, 0, 1, 0]
    assert counted([inf, -inf, nan, 1e308, -1e308], 0.0, 1.0, 2) == [2, 0, 0, 2, 1]
    assert counted([-0.0], 0.0, 1.0, 1) == [0, 1, 0, 0]
    assert counted([0.3], 0.3, np.nextafter(0.3, 1.0), 5)[1] == 1  # the narrowest raster there is


@pytest.mark.parametrize("n", [1, BLOCK - 1, BLOCK, BLOCK + 1, 5 * BLOCK + 3])
def test_every_lane_is_counted(n):
    x = np.random.default_rng(n).normal(size=n)
    counts = counted(x, -1.0, 1.0, 11)
    assert counts[1:-2] == np.histogram(x, 11, (-1.0, 1.0))[0].tolist()
    assert sum(counts) == n


@pytest.mark.parametrize("width", [1e-300, 1e300])
def test_rasters_of_extreme_width(width):
    x = np.array([0.0, 0.3, 0.7, 1.0]) * width
    assert counted(x, 0.0, width, 2)[1:-2] == [2, 2]


def test_orbits_that_end_at_once_leave_an_empty_raster():
    found = density(HENON, "a", [1.4, 50.0], starts=20, keep=50, range=(-2.0, 2.0), bins=8)
    assert found.ended.values.tolist() == [0, 20]
    assert found["count"].sum("x").values.tolist() == [20 * 50, 0]
    with pytest.raises(gz.InputError, match=r"every orbit of a trial ended before its first point; give range=\(low"):
        density(HENON, "a", [50.0], starts=20)
    with pytest.raises(gz.InputError, match="no range that a double holds"):
        density(
            gz.gap_map(lam=0.5, mu=0.184, l=1.469),
            "lam",
            [1e154, 1.7e308],
            starts=1,
            transient=0,
            keep=4,
            box=((0.0, 0.3),),
        )


MEMORY = """
import re, resource, sys, numpy as np, grazing as gz
def peak():
    try:  # the peak of getrusage begins with that of the process that started this one
        return int(re.search(r"VmHWM:\\s*(\\d+) kB", open("/proc/self/status").read())[1]) / 1e6
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e9 if sys.platform == "darwin" else 1e6)
G = gz.gap_map(0.9, 0.1, 0.0)
gz.density(G, "mu", [0.1], bins=10, starts=2, keep=10)
before = peak()
found = gz.density(G, "mu", np.linspace(0.0, 0.3, 100), bins=1000, starts=1000, transient=200, keep={keep})
points = found["count"].sum() + found.below.sum() + found.above.sum()
print(before, peak(), int(points))
"""


def peak(keep):
    code = MEMORY.format(keep=keep)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=os.environ, timeout=600)
    assert done.returncode == 0, done.stderr
    before, after, points = done.stdout.split()
    return float(before), float(after), int(points)


@pytest.mark.skipif(sys.platform == "win32", reason="needs the resource module")
def test_a_density_takes_the_memory_of_its_picture():
    before, after, points = peak(100)
    assert points == 10**7  # 80 MB if they were stored, with letters twice as many
    assert after - before < 0.1
    assert after < 1.0


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="needs the resource module")
def test_a_density_of_a_billion_points_stays_below_a_gigabyte():
    _before, after, points = peak(10_000)
    assert points == 10**9
    assert after < 1.0


@pytest.mark.parametrize(
    ("P", "name", "more", "said"),
    [
        (GAP, "mu", {"coordinate": "y"}, "coordinate = 'y'; allowed are x"),
        (BALL, "d", {"coordinate": "w"}, "coordinate = 'w'; allowed are u, v"),
        (GAP, "mu", {"bins": 0}, "bins = 0; allowed is a whole number >= 1"),
        (GAP, "mu", {"bins": 2.5}, "bins = 2.5; allowed is a whole number >= 1"),
        (GAP, "mu", {"range": (1.0, 0.0)}, r"range = \(1.0, 0.0\); give \(low, high\), finite, low < high"),
        (GAP, "mu", {"range": (0.0, np.nan)}, r"range = \(0.0, nan\); give \(low, high\), finite"),
        (GAP, "mu", {"range": (-1e308, 1e308)}, r"range = \(-1e\+308, 1e\+308\); give \(low, high\), finite"),
        (GAP, "mu", {"range": (0.0, 10**400)}, r"range = \(0.0, 10+.*; give \(low, high\), finite"),
        (GAP, "mu", {"range": "12"}, r"range = '12'; give \(low, high\), finite"),
        (GAP, "mu", {"range": {1, 2}}, r"range = \{1, 2\}; give \(low, high\), finite"),
        (GAP, "mu", {"range": 3}, r"range = 3; give \(low, high\)"),
        (GAP, "mu", {"range": (0.0, 0.0)}, r"range = \(0.0, 0.0\); give \(low, high\)"),
        (gz.Map(lambda s, p: (p.count * s[0],), {"count": 0.5}), "count", {}, "'count' names a dimension or variable"),
        (gz.Map(lambda s, p: (p.a * s[0],), {"a": 0.5}, ("ended",)), "a", {}, "'ended' names a dimension or variable"),
        (3, "mu", {}, "the first argument is 3; give a map"),
    ],
)
def test_error_texts(P, name, more, said):
    with pytest.raises(gz.InputError, match=said):
        density(P, name, [0.1, 0.2], **more)


def test_a_range_is_not_called_a_box():
    with pytest.raises(gz.InputError) as error:
        density(GAP, "mu", [0.1], range=(1.0, 0.0))
    assert "range" in str(error.value) and "box" not in str(error.value)


def test_a_raster_larger_than_half_the_memory_is_refused_at_once(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 10**9)
    with pytest.raises(gz.InputError, match=r"reduce mu \(10000\), x \(100000\), or sweep"):
        density(GAP, "mu", np.linspace(0, 1, 10_000), bins=100_000)


def test_the_middles_of_bins_near_the_largest_number_are_finite():
    found = gz.density(
        gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.1], bins=2, range=(1e308, 1.5e308), starts=1, keep=1
    )
    np.testing.assert_allclose(found["x"], [1.125e308, 1.375e308])
