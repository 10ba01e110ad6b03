"""Basins: every cell is what its own orbit says; attractors of one word are kept apart; what may be asked."""

import json

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import memory, theory
from grazing.catalogue import studies
from grazing.catalogue.rows import told
from grazing.orbits.word import letters_of
from grazing.orbits.word import word as word_of
from grazing.studies.basins import basins, plan
from grazing.studies.classify import classify
from grazing.studies.plan import empty_arrays, labelled
from tests.studies.maps import DOUBLE_WELL, FOLLOWER, HENON, LOGISTIC, PLANE_WELLS, SMOOTH

GAP = gz.gap_map(0.5, 0.043, 0.1)
BALL = gz.stroboscopic_map(gz.pinball(V=0.4, d=0.1))
CASES = {
    "gap map": (GAP, {"x": np.linspace(-1, 1, 301)}, {}),
    "one axis of two": (BALL, {"v": np.linspace(-0.5, 0.5, 40)}, {"u": 0.2}),
    "oscillator": (BALL, {"u": np.linspace(0.0, 0.8, 15), "v": np.linspace(-0.5, 0.5, 13)}, {}),
    "axes the other way": (BALL, {"v": np.linspace(-0.5, 0.5, 9), "u": [0.7, 0.1, 0.3]}, {}),
    "Henon, some escape": (HENON.replace(a=1.06), {"x": np.linspace(-2, 2, 21), "y": np.linspace(-2, 2, 17)}, {}),
    "three dimensions": (FOLLOWER, {"z": np.linspace(-1, 1, 7), "x": np.linspace(0.1, 1.2, 12)}, {"y": 0.3}),
    "wells": (DOUBLE_WELL, {"x": np.linspace(-1.7, 1.7, 101)}, {}),
    "wells in the plane": (PLANE_WELLS.replace(a=2.1), {"y": [-1.0, 0.0, 1.0], "x": np.linspace(-1.2, 1.2, 30)}, {}),
    "impact map": (
        gz.impact_map(gz.pinball(V=0.4, d=0.1)),
        {"tau": np.linspace(0, 2.8, 9), "v_plus": [0.1, 0.5, 0.9]},
        {},
    ),
}
SMALL = {"transient": 300, "keep": 40, "preimages": 0}


@pytest.mark.parametrize("kind", CASES)
def test_a_cell_is_what_its_own_orbit_says(kind):
    P, grid, fixed = CASES[kind]
    found = basins(P, grid, fixed=fixed, arithmetic="strict", **SMALL)
    assert found.basin.dims == tuple(grid)
    shape = tuple(len(values) for values in grid.values())
    for place in np.ndindex(shape):
        state = {name: np.asarray(values)[i] for (name, values), i in zip(grid.items(), place, strict=True)}
        middle = {name: 0.5 * sum(ends) for name, ends in zip(P.coordinates, P.box, strict=True)}
        start = np.array([{**middle, **fixed, **state}[name] for name in P.coordinates])
        points, letters, outcomes = P.run(start[:, None], 300, 40)
        alone = classify(P, points, letters, outcomes[0])
        k = found.basin.values[place]
        assert (found.period.values[k], found.word.values[k]) == (alone.period[0], alone.word[0])
        assert found.outcome.values[place] == outcomes[0, 0] and found.trust.values[place] == alone.trust[0]
        if alone.period[0] > 0:  # the point of the row is on the orbit
            distance = np.abs(points[-alone.period[0] :, :, 0] - found.point.values[k]).max(axis=1).min()
            assert distance < 1e-2  # one that is named by its multiplier is still under way


@pytest.mark.parametrize("kind", CASES)
def test_fractions_and_tables(kind):
    P, grid, fixed = CASES[kind]
    found = basins(P, grid, fixed=fixed, **SMALL)
    assert found.fraction.sum() == pytest.approx(1.0)
    assert (np.diff(found.fraction.values) <= 0).all()
    counts = np.bincount(found.basin.values.ravel(), minlength=found.sizes["attractor"])
    assert counts / counts.sum() == pytest.approx(found.fraction.values)
    without = found.period.values < 1
    assert np.isnan(found.point.values[without]).all() and np.isfinite(found.point.values[~without]).all()
    assert (found.word.values[without] == "").all()
    for N, point, word in zip(found.period.values, found.point.values, found.word.values, strict=True):
        if N > 0:  # a point of the cycle, the one at which its word begins
            orbit = P.orbit(point, int(N))
            assert np.allclose(orbit.points[-1], point, rtol=1e-9, atol=1e-9)
            assert word_of(orbit.letters.tolist(), P.letters) == word
            spelled = letters_of(word, P.letters)
            assert spelled == tuple(orbit.letters[: len(spelled)].tolist())


def test_fixed_points_with_one_word_are_kept_apart():
    found = basins(DOUBLE_WELL, {"x": np.linspace(-1.2, 1.2, 240)}, transient=400)
    assert found.word.values.tolist() == ["0", "0"] and found.period.values.tolist() == [1, 1]
    assert sorted(found.point.values[:, 0].tolist()) == pytest.approx([-np.sqrt(0.5), np.sqrt(0.5)], abs=1e-12)
    assert found.fraction.values.tolist() == [0.5, 0.5]
    which = found.point.values[found.basin.values, 0]
    assert (np.sign(which) == np.sign(found.x.values)).all()


def test_cycles_with_one_word_are_kept_apart():
    a = 2.1  # each well has a cycle of period 2 of its own
    for P, grid in (
        (DOUBLE_WELL.replace(a=a), {"x": np.linspace(-1.2, 1.2, 100)}),
        (PLANE_WELLS.replace(a=a), {"x": np.linspace(-1.2, 1.2, 40), "y": np.linspace(-1, 1, 5)}),
    ):
        found = basins(P, grid, transient=1000)
        assert found.period.values.tolist() == [2, 2] and found.word.values.tolist() == ["0", "0"]
        one, other = found.point.values[:, 0]
        images = [P.orbit(point, 1).points[1] for point in found.point.values]
        assert one * other < 0
        for point, image in zip(found.point.values, images, strict=True):
            assert point[0] < image[0]  # of the two, the one that comes first in order


def test_a_cycle_is_one_attractor_wherever_orbits_are_on_it():
    for P, N in (
        (SMOOTH.replace(a=3.2), 2),
        (SMOOTH.replace(a=3.5), 4),
        (SMOOTH.replace(a=3.55), 8),
        (LOGISTIC.replace(a=3.83), 3),
    ):
        found = basins(P, {"x": np.linspace(0.01, 0.99, 200)}, transient=3000)
        assert found.period.values.tolist() == [N], P


def test_points_that_differ_in_a_later_coordinate_only():
    """The first coordinates of the points of the cycle agree but for rounding: the order must not hang on that."""

    def step(state, p):
        x, y = state
        return 0.7 * x + 0.1, p.a * y * (1.0 - y)

    P = gz.Map(step, params={"a": 3.2}, coordinates=("x", "y"), box=((0.0, 1.0), (0.05, 0.95)))
    found = basins(P, {"x": np.linspace(0, 1, 23), "y": np.linspace(0.07, 0.93, 22)}, transient=100)
    assert found.period.values.tolist() == [2]


def test_slow_orbits_and_fast_ones_are_on_one_attractor():
    """Just inside a period doubling orbits are still away from their cycle when they are named."""
    mu = theory.mu_pd(3, 0.5, 0.1) * (1 + 1e-3)
    orbit = theory.maximal_orbit(3, 0.5, mu, 0.1)
    starts = orbit[0] + np.linspace(-3e-4, 3e-4, 50)
    found = basins(gz.gap_map(0.5, mu, 0.1), {"x": starts}, transient=100)
    assert (found.word.values.tolist(), found.period.values.tolist()) == (["LLR"], [3])
    assert found.point.values[0, 0] == pytest.approx(orbit[0], abs=1e-12)


@pytest.mark.parametrize("kind", ["gap map", "oscillator", "Henon, some escape"])
def test_neither_threads_nor_pieces_change_a_bit(kind):
    P, grid, fixed = CASES[kind]
    one = basins(P, grid, fixed=fixed, threads=1, **SMALL)
    xr.testing.assert_identical(one, basins(P, grid, fixed=fixed, threads=3, **SMALL))
    made = plan(P, grid, fixed=fixed, **SMALL)
    arrays = empty_arrays(made, made.cells)
    for cells in np.array_split(np.random.default_rng(0).permutation(made.cells), 5):
        some = empty_arrays(made, len(cells))
        for _ in made.compute(cells, some):
            pass
        for name, array in arrays.items():
            array[cells] = some[name]
    xr.testing.assert_identical(labelled(made, arrays), one)


def test_theory_says_what_coexists():
    found = basins(GAP, {"x": np.linspace(-1, 1, 400)}, transient=3000)
    words = {"L" * (N - 1) + "R" for N in range(1, 20) if 0.043 in theory.window(N, 0.5, 0.1).stability}
    assert set(found.word.values.tolist()) == words == {"LLR", "LLLR"}
    for word, point in zip(found.word.values, found.point.values[:, 0], strict=True):
        assert point == pytest.approx(theory.maximal_orbit(len(word), 0.5, 0.043, 0.1)[0], abs=1e-11)


def test_the_grazing_curve_comes_with_a_stroboscopic_map_only():
    found = basins(BALL, {"u": np.linspace(0, 0.8, 6), "v": np.linspace(-0.5, 0.5, 6)}, transient=50, preimages=1)
    assert found.graze.dims == ("graze_point", "coordinate")
    assert set(found.graze_order.values.tolist()) == {0, 1}
    for P, grid in ((GAP, {"x": [0.1, 0.2]}), (gz.impact_map(gz.pinball()), {"tau": [0.1], "v_plus": [0.2, 0.4]})):
        assert "graze" not in basins(P, grid, transient=5)


def test_without_a_grid_it_is_the_box():
    found = basins(gz.Map(HENON.step, HENON.params, ("x", "y"), ((-0.5, 0.5), (-0.3, 0.3)), "LR"), transient=5, keep=4)
    assert found.x.values.tolist() == np.linspace(-0.5, 0.5, 200).tolist()
    assert found.y.values.tolist() == np.linspace(-0.3, 0.3, 200).tolist()
    assert dict(basins(GAP, transient=5, keep=4).sizes)["x"] == 200


def test_other_coordinates_are_in_the_middle_of_the_box_unless_said():
    P, x = FOLLOWER, {"x": [0.2, 0.7]}
    config = json.loads(basins(P, x, transient=5).attrs["grazing_config"])
    assert config["fixed"] == {"y": 0.0, "z": 0.0}
    config = json.loads(basins(P, x, fixed={"z": -0.5}, transient=5).attrs["grazing_config"])
    assert config["fixed"] == {"y": 0.0, "z": -0.5}


def test_smallest_grids():
    found = basins(GAP, {"x": [0.3]}, transient=0, keep=1)
    assert found.period.values.tolist() == [0] and found.fraction.item() == 1.0
    assert np.isnan(found.attrs["basin_entropy"]) and np.isnan(found.attrs["boundary_dimension"])
    equal = basins(GAP, {"x": [0.3, 0.3, 0.3]})
    assert equal.basin.values.tolist() == [0, 0, 0]


def test_the_boundary_of_two_wells_is_smooth():
    found = basins(PLANE_WELLS, {"x": np.linspace(-1.2, 1.1, 100), "y": np.linspace(-1, 1, 100)}, transient=500)
    assert found.attrs["boundary_dimension"] == pytest.approx(1.0, abs=0.03)
    assert 0.0 < found.attrs["basin_entropy"] < 0.1
    assert found.attrs["boundary_basin_entropy"] <= np.log(2)


def test_files(tmp_path):
    found = basins(BALL, {"u": np.linspace(0, 0.8, 12), "v": np.linspace(-0.5, 0.5, 12)}, transient=50, preimages=1)
    loaded = gz.load(gz.save(found, tmp_path / "basins.nc"))
    xr.testing.assert_equal(loaded, found)
    assert loaded.attrs.keys() == found.attrs.keys()


@pytest.mark.parametrize(
    ("arguments", "more", "said"),
    [
        ((GAP, {}), {}, r"grid is \{\}; give one or two of x with their values"),
        ((GAP, [0.1, 0.2]), {}, r"grid is \[0.1, 0.2\]; give one or two of x with their values"),
        ((FOLLOWER, {"x": [0.1], "y": [0.1], "z": [0.1]}), {}, "give one or two of x, y, z with their values"),
        ((GAP, {"y": [0.1]}), {}, "'y' is no coordinate of the gap map; give one or two of x"),
        ((GAP, {"x": []}), {}, r"values have shape \(0,\); give finite values of x"),
        ((GAP, {"x": [np.nan]}), {}, r"values\[0\] = nan is not finite"),
        (
            (BALL, {"u": [-0.1, 0.2], "v": [0.0]}),
            {},
            "the ball starts inside the wall: u = -0.1, sigma = 0; start with",
        ),
        ((BALL, {"v": [0.0]}), {"fixed": {"u": -1.0}}, "the ball starts inside the wall: u = -1"),
        ((BALL, {"v": [0.0]}), {"fixed": {"v": 1.0}}, "fixed has 'v'; allowed are u"),
        (
            (BALL, {"u": [0.1], "v": [0.0]}),
            {"fixed": {"u": 1.0}},
            "fixed has 'u'; allowed are none: all coordinates vary",
        ),
        ((BALL, {"v": [0.0]}), {"fixed": {"u": np.inf}}, "u = inf is not finite; give a finite number"),
        ((GAP, {"x": [0.1]}), {"preimages": -1}, "preimages = -1; allowed is a whole number >= 0"),
        ((GAP, {"x": [0.1]}), {"keep": 0}, "keep = 0; allowed is a whole number >= 1"),
        ((GAP, {"x": [0.1]}), {"arithmetic": "exact"}, "arithmetic is 'exact'; allowed are 'strict' and 'fast'"),
        (
            (gz.Map(lambda s, p: (p.a * s[0],), {"a": 0.5}, ("word",)), {"word": [0.1]}),
            {},
            "'word' names a dimension or",
        ),
        ((gz.pinball(), {"u": [0.1]}), {}, "the first argument is .*; give a map"),
    ],
)
def test_error_texts(arguments, more, said):
    with pytest.raises(gz.InputError, match=said):
        basins(*arguments, **more)


def test_a_grid_may_be_a_line_in_the_plane_or_a_point():
    """The grazing curve, which belongs to a plane, asked for a box of some width when all cells were computed."""
    for grid in ({"u": [0.1], "v": [0.0, 0.1]}, {"v": [0.1, 0.1], "u": [0.1, 0.2]}):
        found = basins(BALL, grid, transient=5, keep=4)
        assert found.sizes["attractor"] > 0 and "graze" not in found


def test_the_wall_is_looked_for_inside_the_grid_too():
    """Values need not be in order: a state inside the wall is refused wherever it stands."""
    with pytest.raises(gz.InputError, match="the ball starts inside the wall"):
        basins(BALL, {"u": [0.1, -0.5, 0.3], "v": [0.0, 0.1]}, transient=5)


def test_too_many_cells_are_refused_at_once(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 10**8)
    with pytest.raises(gz.InputError, match=r"reduce x \(5000\), y \(5000\)"):
        basins(HENON, {"x": np.linspace(0, 1, 5000), "y": np.linspace(0, 1, 5000)})


def test_a_continuum_of_neutral_motions_is_one_row():
    """A gear that does not rattle stays where it is: that was said to be 55 attractors and chaos."""
    walls = (gz.wall(-0.25e-3, gz.newton(0.8)), gz.wall(0.25e-3, gz.newton(0.8)))
    force = gz.Forcing(omega=188.4955592, cos=(1.0,))
    P = gz.stroboscopic_map(gz.Oscillator(alpha=2, k=0, forcing=force, walls=walls))
    found = basins(P, {"u": np.linspace(-2e-4, 2e-4, 9), "v": [-0.004, 0.002]}, transient=400)
    free = found.neutral.values == 1
    assert found.word.values[free].tolist() == ["0"] and found.period.values[free].tolist() == [1]
    assert found.fraction.values[free][0] > 0.5
    state = P.orbit(found.point.values[free][0], 1).points
    assert np.allclose(state[1], state[0], rtol=0.0, atol=1e-15)
    kinds = {row["word"]: (row["kind"], row["neutral"]) for row in told(studies()["basins"], found)["attractors"]}
    assert kinds["0"] == ("period 1, a neutral continuum", True)
    assert all(not idle for word, (_kind, idle) in kinds.items() if word != "0")
    legend = [text.get_text() for text in gz.plot.basins(found)["legend"].get_texts()]
    assert legend[0].startswith("0, period 1, neutral: ")


def test_isolated_attractors_of_one_word_stay_apart():
    found = basins(DOUBLE_WELL, {"x": np.linspace(-1.7, 1.7, 50)}, **SMALL)
    assert found.word.values.tolist().count("0") == 2 and not found.neutral.values.any()
