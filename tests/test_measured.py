"""Figures of a rig show its own x: upwards, with the stop where it is, whichever way the model's u points."""

import json

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing.config import checked, command_of, recipe_of
from grazing.config.build import map_in
from grazing.io import load, save
from grazing.measured import measured

NUMBERS = {"m": 0.8, "c": 2.4, "k": 3200, "force": 2.5, "gap": 1.2e-3, "frequency": 14, "reset": gz.newton(0.7)}


@pytest.fixture(scope="module")
def rig():
    return gz.Oscillator.from_si(**NUMBERS)


@pytest.fixture(scope="module")
def motion(rig):
    return gz.trajectory(rig, (0.0, 0.0), until=0.3)


@pytest.fixture(scope="module")
def below():
    """The mirror image: the stop below, and the force the other way; in its own x it moves the other way."""
    return gz.trajectory(gz.Oscillator.from_si(**NUMBERS | {"force": -2.5, "side": "below"}), (0.0, 0.0), until=0.3)


def labels(drawn):
    ax = drawn["figure"].axes[0]
    return ax.get_xlabel(), ax.get_ylabel()


def test_a_history_has_its_stop_above_and_hits_it_from_below(motion):
    drawn = gz.plot.history(gz.in_units(motion, "mm"))
    _t, x = drawn["motion"].get_data()
    np.testing.assert_allclose(x, -1e3 * motion.u, rtol=1e-15)
    ax = drawn["figure"].axes[0]
    wall = drawn["wall"].get_paths()[0].get_extents()
    assert wall.y0 == pytest.approx(1.2) and wall.y1 == pytest.approx(ax.get_ylim()[1])
    np.testing.assert_allclose(drawn["impacts"][0].get_ydata(), 1.2)
    assert labels(drawn) == ("time $t$ (s)", "position $x$ (mm)")
    speeds = gz.plot.history(motion, of="v")
    assert (speeds["impacts"][0].get_ydata() > 0.0).all()  # upwards, onto the stop
    assert labels(speeds)[1] == r"velocity $\dot{x}$ (m/s)"


def test_a_stop_below_stays_below_and_its_x_is_u(below, motion):
    drawn = gz.plot.history(below)
    np.testing.assert_array_equal(drawn["motion"].get_ydata(), below.u)
    np.testing.assert_array_equal(below.u, motion.u)
    assert labels(drawn)[1] == "position $x$ (m)" and drawn["wall"].get_paths()[0].get_extents().y1 == -1.2e-3


def test_a_phase_portrait_is_turned_with_the_states_laid_over_it(motion):
    drawn = gz.plot.trajectory(motion, strobe=[(1e-3, 0.1)])
    assert drawn["strobe"].get_xydata().tolist() == [[-1e-3, -0.1]]
    assert (
        min(drawn["wall"].get_corners()[:, 0]) == 1.2e-3
        and max(line.get_xdata()[0] for line in drawn["impacts"]) == 1.2e-3
    )
    assert labels(drawn) == ("position $x$ (m)", r"velocity $\dot{x}$ (m/s)")


def test_results_files_and_tables_keep_the_model(motion, tmp_path):
    before = motion.copy(deep=True)
    gz.plot.history(motion)
    xr.testing.assert_identical(motion, before)
    save(motion, tmp_path / "a.nc")
    again = load(tmp_path / "a.nc")
    assert again.attrs["stop"] == "above" and float(again.u.min()) == -1.2e-3
    assert float(measured(again).u.max()) == 1.2e-3


def test_it_is_turned_once(motion):
    once = measured(gz.in_units(motion, "mm"))
    xr.testing.assert_identical(measured(once), once)
    assert gz.plot.history(once)["motion"].get_ydata().max() == pytest.approx(1.2)


def test_basins_densities_and_diagrams_are_turned_and_in_order(rig):
    P, omegas = gz.stroboscopic_map(rig), 2 * np.pi * np.array([13.0, 14.0])
    found = gz.basins(P, {"u": np.linspace(-1.2e-3, 4e-3, 7), "v": np.linspace(-0.2, 0.3, 5)})
    seen = measured(found)
    assert seen.u.values.tolist() == (-found.u.values[::-1]).tolist()
    np.testing.assert_array_equal(seen.basin.values, found.basin.values[::-1, ::-1])
    np.testing.assert_array_equal(seen.point, -found.point)
    ax = gz.plot.basins(gz.in_units(found, "mm"))["figure"].axes[0]
    assert ax.get_xlim() == pytest.approx((-4.43, 1.63), abs=0.01) and ax.get_ylim()[0] < ax.get_ylim()[1]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$x$ (mm)", r"$\dot{x}$ (m/s)")
    plain = gz.density(P, "omega", omegas, starts=3, keep=20, bins=16)
    counted = measured(plain)
    assert (counted.u.attrs["low"], counted.u.attrs["high"]) == (-plain.u.attrs["high"], -plain.u.attrs["low"])
    np.testing.assert_array_equal(counted["count"], plain["count"].values[:, ::-1])
    image = gz.plot.density(plain)["figure"].axes[0]
    assert image.get_ylim() == pytest.approx((-plain.u.attrs["high"], -plain.u.attrs["low"]))
    diagram = gz.orbit_diagram(P, "omega", omegas, starts=2, keep=4)
    drawn = gz.plot.orbit_diagram(diagram)
    heights = np.concatenate([line.get_ydata() for line in drawn["points"].values()])
    assert {*heights} <= {*(-diagram.u.values).ravel()} and labels(drawn)[1] == "$x$ (m)"


def test_readings_keep_their_sign_but_for_the_mean(rig):
    found = gz.response(gz.stroboscopic_map(rig), "omega", 2 * np.pi * np.array([13.0, 14.0]), starts=2)
    seen = measured(found)
    for name in found.data_vars:
        if found[name].dtype.kind == "f" and name.startswith(("branch_", "special_")):
            turned = name.endswith(("_u", "_v", "_mean", "_v_minus", "_v_plus"))
            np.testing.assert_array_equal(seen[name], -found[name] if turned else found[name], err_msg=name)
    np.testing.assert_array_equal(seen["mean"], -found["mean"])
    np.testing.assert_array_equal(seen.amplitude, found.amplitude)
    lines = gz.plot.response(found, by="mean")["runs"]["up"].get_ydata()
    np.testing.assert_array_equal(lines, -found["mean"].sel(run="up"))


def test_a_branch_is_drawn_in_x(rig):
    orbit = gz.one_impact_orbits(rig, 1)[0]
    branch = gz.continuation(gz.stroboscopic_map(rig), orbit, "omega", (85.0, 90.0))
    heights = np.concatenate([line.get_ydata().ravel() for line in gz.plot.branch(branch)["lines"]])
    assert {*heights} == {*(-branch.dataset.u.values).ravel()}
    assert labels(gz.plot.branch(branch))[1] == "$x$ (m)"
    both = gz.plot.branch([branch, branch.dataset])
    assert labels(both)[1] == "$x$ (m)"


def test_a_manifold_lies_on_the_basins_that_it_bounds(rig):
    saddle = next(orbit for orbit in gz.one_impact_orbits(rig, 1) if not orbit.stable)
    grown = gz.manifolds(saddle, "stable", box=[(-1.2e-3, 4e-3), (-0.2, 0.2)], length=0.3)
    drawn = gz.plot.manifolds(gz.in_units(grown, "mm"))
    np.testing.assert_array_equal(drawn["line"].get_xydata(), -grown.manifold.values * [1e3, 1.0])
    np.testing.assert_allclose(drawn["saddle"].get_xydata(), -saddle.points * [1e3, 1.0], rtol=1e-15)
    assert labels(drawn) == ("$x$ (mm)", r"$\dot{x}$ (m/s)")
    low, high = drawn["figure"].axes[0].get_xlim()
    assert low < drawn["saddle"].get_xdata()[0] < high


def test_axes_of_parameters_say_what_they_are_of_the_rig(rig):
    P = gz.stroboscopic_map(rig)
    found = gz.chart(P, {"sigma": [-2e-3, -1e-3], "cos1": [-3.0, -2.0]}, starts=2, keep=8, transient=10)
    drawn = labels(gz.plot.chart(gz.in_units(found, "mm")))
    assert drawn == (r"$\sigma=-\mathrm{gap}$ (mm)", "$c_{1}=-F_{1}/m$ (N/kg)")
    assert labels(gz.plot.chart(gz.in_units(found, "N")))[1] == "$mc_{1}=-F_{1}$ (N)"


def test_a_spectrum_keeps_its_height_and_knows_its_rig(motion):
    found = gz.spectrum(gz.sample(motion, 1000.0))
    assert found.attrs["stop"] == "above" and found.attrs["mass"] == 0.8
    drawn = gz.plot.spectrum(found)
    assert (drawn["lines"].get_ydata() > 0.0).all()
    assert labels(drawn)[1] == "amplitude of the position $x$ (m)"


@pytest.mark.parametrize(
    ("moves", "symbol"), [("both", "relative position $x-z$ (m)"), ("stop", "relative position $x-z$ (m)"),
                          ("spring", "position $x$ (m)")],
)  # fmt: skip
def test_a_stop_that_moves_with_a_base_is_where_x_is_counted_from(moves, symbol):
    shaken = gz.Oscillator.from_si(**NUMBERS | {"force": 0.0}, base=1e-3, moves=moves)
    assert labels(gz.plot.history(gz.trajectory(shaken, (0.0, 0.0), until=0.1)))[1] == symbol
    found = measured(gz.response(gz.stroboscopic_map(shaken), "omega", [88.0, 90.0], starts=1, transient=5, keep=2))
    relative = "relative " if moves != "spring" else ""
    assert found.amplitude.attrs["long_name"] == f"{relative}amplitude, half of peak to peak"
    assert found.peak_velocity.attrs["long_name"] == f"greatest {relative}speed"


def test_a_graph_of_relative_states_has_brackets_and_units():
    shaken = gz.Oscillator.from_si(**NUMBERS | {"force": 0.0}, base=1e-3)
    found = gz.graph(gz.stroboscopic_map(shaken), "u", [0.0, 1e-3, 2e-3], order=None)
    assert labels(gz.plot.graph(found)) == ("$(x-z)_{n}$ (m)", "$(x-z)_{n+1}$ (m)")


def test_a_file_and_a_command_remember_the_side(rig):
    P = gz.stroboscopic_map(rig)
    assert P.replace(omega=80.0).model.stop == "above"
    found = gz.orbit_diagram(P, "sigma", [-2e-3, -1e-3], starts=2, keep=8)
    recipe = recipe_of(found.attrs)
    assert recipe["stop"] == "above" and "--stop above" in command_of(recipe)
    assert map_in(checked(json.loads(json.dumps(recipe)))).model.stop == "above"


def test_a_model_that_is_no_rig_is_drawn_as_it_is():
    plain = gz.trajectory(gz.pinball(), (0.1, 0.0), until=3.0)
    assert measured(plain) is plain and measured([plain, 3])[0] is plain
    assert labels(gz.plot.history(plain)) == ("time $t$", "position $u$")
    with pytest.raises(gz.InputError, match="stop = 'left'; allowed are 'above' and 'below'"):
        gz.Oscillator(0.1, 1.0, gz.Forcing(omega=2.0), gz.newton(0.9), mass=1.0, stop="left")
