"""Units: quantities in, results in the units that somebody reads."""

import json
import pickle
import sys

import numpy as np
import pint
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import grazing as gz
from grazing.io import load, save
from grazing.outcome import InputError
from grazing.units import in_units, magnitude

UNITS = pint.UnitRegistry()
LAW = gz.newton(0.7)


@pytest.fixture(scope="module")
def rig():
    return gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, force=2.5, gap=1.2e-3, frequency=14, reset=LAW)


@pytest.fixture(scope="module")
def in_millimetres(rig):
    """The same model, made by hand with millimetres for metres and nothing said of units."""
    f = gz.Forcing(omega=rig.forcing.omega, cos=[1e3 * a for a in rig.forcing.cos])
    return gz.Oscillator(rig.alpha, rig.k, f, LAW, -1.2)


@pytest.fixture(scope="module")
def response(rig):
    return gz.response(gz.stroboscopic_map(rig), "omega", 2 * np.pi * np.array([13.0, 14.0, 15.0]), starts=3)


# ---- numbers of quantities


@pytest.mark.parametrize(
    ("given", "units", "value"),
    [
        ("1.2 mm", "m", 1.2e-3), ("1 Hz", "rad/s", 2 * np.pi), ("60 rpm", "Hz", 1.0), ("60 rpm", "rad/s", 2 * np.pi),
        ("2 rad/s", "Hz", 1 / np.pi), ("360 degree/s", "Hz", 1.0), ("3", "1", 3.0), (" -2e-3 m/s ", "m/s", -2e-3),
        ("2.4 N*s/m", "kg/s", 2.4), ("1e3 g", "kg", 1.0), ("5 µm", "m", 5e-6), (0.3, "m", 0.3), (None, "m", None),
        (UNITS.Quantity(3.0, "kHz"), "rad/s", 6e3 * np.pi), ("9.81 m/s^2", "N/kg", 9.81), ("2 1/s", "1/s", 2.0),
    ],
)  # fmt: skip
def test_a_quantity_in_the_units_that_are_wanted(given, units, value):
    found = magnitude(given, units, "x")
    assert found == value if value is None else found == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("given", "units"),
    [("1 1/s", "rad/s"), ("1 1/s", "Hz"), ("1 rad/s", "m"), ("1 Hz", "s"), ("1 m", "1"), ("1 m", ""), ("1", "m")],
)
def test_units_that_do_not_match_are_refused(given, units):
    with pytest.raises(InputError, match=r"x = '1.*(do not match|not known|has no units)"):
        magnitude(given, units, "x")


def test_lists_of_quantities_and_of_texts():
    found = magnitude(["1 mm", UNITS.Quantity(2.0, "cm"), 3.0], "m", "x")
    assert found == pytest.approx([1e-3, 2e-2, 3.0], rel=1e-15)
    with pytest.raises(InputError, match=r"x\[1\] = '2 kg'; its units do not match"):
        magnitude(["1 mm", "2 kg"], "m", "x")
    plain = [0.1, 0.2]
    assert magnitude(plain, "m", "x") is plain


def test_changes_of_attractors_are_in_the_units_of_what_varies(rig):
    found = gz.coexistence(gz.stroboscopic_map(rig), "omega", 2 * np.pi * np.linspace(16.0, 17.0, 3), starts=12)
    shown = in_units(found, "Hz")
    assert found.sizes["change"] == 1 and 16.0 <= shown.before.item() < shown.after.item() <= 17.0
    drawn = gz.plot.coexistence(shown)
    low, high = drawn["figure"].axes[0].get_xlim()
    assert all(low < x < high for marks in drawn["changes"].values() for x in marks.get_xdata())
    assert gz.to_dataframe(shown, "change").before.tolist() == shown.before.values.tolist()


def test_names_of_a_rig_are_translated(rig):
    P = gz.stroboscopic_map(rig)
    for name, said in (("frequency", "omega = 2 pi frequency"), ("gap", "sigma = -gap"), ("c", "alpha = c/m")):
        with pytest.raises(InputError, match=f"unknown parameter '{name}' of .*Here that is {said}"):
            gz.orbit_diagram(P, name, [1.0, 2.0])


def test_heads_of_columns_have_units(rig, tmp_path):
    tr = in_units(gz.trajectory(rig, (0.0, 0.0), until=0.2), "mm")
    gz.to_csv(tr, tmp_path / "a.csv")
    down = [f"{name} ({unit} positive down)" for name, unit in (("u", "mm"), ("v", "m/s"), ("wall", "mm"))]
    assert (tmp_path / "a.csv").read_text().startswith(f"t (s),{','.join(down)},trust\n")


@pytest.mark.parametrize(
    "text", ["", "mm", "1.2.3 mm", "9**9**9", "1 m**9**9**9", "1 (m)", "1 __import__('os')", "1 m; m", "1 " + 300 * "m",
             "nan m", "1e9999 m", "1 m^99999999", "\x001 m", "2 dB", "2 dBm", "2 m dB", "2 Np", "2 degC"],
)  # fmt: skip
def test_a_text_that_is_no_quantity_is_refused(text):
    with pytest.raises(InputError):
        magnitude(text, "m", "x")


@given(st.text(max_size=40))
def test_no_text_is_computed_or_breaks_anything(text):
    try:
        found = magnitude(text, "m", "x")
    except InputError:
        return
    assert isinstance(found, float)


def test_without_pint_numbers_work_and_units_say_what_to_install(rig, monkeypatch):
    monkeypatch.setitem(sys.modules, "pint", None)
    kwargs = {"m": 0.8, "c": 2.4, "k": 3200, "force": 2.5, "frequency": 14, "reset": LAW}
    assert gz.Oscillator.from_si(gap=1.2e-3, **kwargs).params == rig.params
    for call in (
        lambda: gz.Oscillator.from_si(gap="1.2 mm", **kwargs),
        lambda: in_units(gz.trajectory(rig, (0.0, 0.0), until=0.2), "mm"),
    ):
        with pytest.raises(InputError, match=r"pip install 'grazing\[units\]'"):
            call()


# ---- where quantities may be given


def test_values_of_studies_and_changes_of_models(rig):
    P, hertz = gz.stroboscopic_map(rig), np.array([13.0, 14.0])
    plain = gz.orbit_diagram(P, "omega", 2 * np.pi * hertz, starts=2, keep=4)
    for values in (UNITS.Quantity(hertz, "Hz"), UNITS.Quantity(60 * hertz, "rpm")):
        found = gz.orbit_diagram(P, "omega", values, starts=2, keep=4)
        np.testing.assert_allclose(found.omega, plain.omega, rtol=1e-15)
    assert gz.basins(P, {"u": UNITS.Quantity([0.0, 1.0], "mm"), "v": [0.0, 0.1]}).u.values.tolist() == [0.0, 1e-3]
    with pytest.raises(InputError, match="units do not match"):
        gz.orbit_diagram(P, "omega", UNITS.Quantity(hertz, "mm"))
    with pytest.raises(InputError, match="a number without units"):
        gz.pinball().replace(sigma=UNITS.Quantity(1.0, "mm"))


def test_a_model_keeps_its_units_in_maps_copies_and_changes(rig):
    P = gz.stroboscopic_map(rig)
    for one in (P, P.replace(omega=80.0), pickle.loads(pickle.dumps(P)), gz.impact_map(rig)):
        assert one.model.mass == 0.8 and one.describe("sigma").units == "m"
    assert pickle.loads(pickle.dumps(P)) == P
    assert gz.stroboscopic_map(gz.pinball()).describe("sigma").units == "1"
    own = gz.reset(lambda v, p: -p.e * v, e=0.5)
    with_own = gz.Oscillator(rig.alpha, rig.k, rig.forcing, own, rig.sigma, mass=0.8)
    assert "units" not in with_own.describe("e").attributes


# ---- results


def test_every_result_says_its_units(rig, response):
    P = gz.stroboscopic_map(rig)
    said = {
        "omega": "rad/s", "amplitude": "m", "mean": "m", "rms_velocity": "m/s", "impulse": "N s/kg", "branch_u": "m",
        "impacts_per_period": "1", "special_value": "rad/s", "branch_impact_time": "s", "branch_v_minus": "m/s",
    }  # fmt: skip
    assert {name: response[name].attrs["units"] for name in said} == said
    assert response.attrs["mass"] == 0.8
    tr = gz.trajectory(rig, (0.0, 0.0), until=0.3)
    assert [tr[name].attrs["units"] for name in ("t", "u", "v", "impact_time", "v_plus", "wall")] == [
        "s", "m", "m/s", "s", "m/s", "m",
    ]  # fmt: skip
    exponents = gz.lyapunov(P, "omega", [80.0, 81.0], steps=50)
    assert exponents.exponent_per_time.attrs["units"] == "1/s" and exponents.return_time.attrs["units"] == "s"
    assert gz.windows(rig, "omega", 1, span=(70.0, 110.0)).low.attrs["units"] == "rad/s"
    assert gz.boundaries(rig, ("omega", 80.0, 90.0), ("sigma", -2e-3, -1e-3), N=1).sigma.attrs["units"] == "m"
    assert gz.trajectory(gz.pinball(), (0.1, 0.0)).u.attrs["units"] == "1"


def test_readings_are_those_of_the_same_rig_in_millimetres(response, in_millimetres):
    other = gz.response(gz.stroboscopic_map(in_millimetres), "omega", response.omega.values, starts=3)
    found = in_units(response, "mm", "mm/s")
    for name in ("amplitude", "mean", "peak_velocity", "rms_velocity", "impact_speed"):
        both = (one[name].sel(run=["up", "down"]).values for one in (found, other))
        np.testing.assert_allclose(*both, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(
        in_units(response, "mN s").impulse.sel(run="up"), 0.8 * other.impulse.sel(run="up"), rtol=1e-9
    )


def test_frequencies_in_hertz_and_impulses_with_the_mass(response):
    found = in_units(response, "Hz", "mm", "N s")
    np.testing.assert_allclose(found.omega, [13.0, 14.0, 15.0], rtol=1e-15)
    np.testing.assert_allclose(found.special_value, response.special_value / (2 * np.pi), rtol=1e-15)
    np.testing.assert_allclose(found.impulse, 0.8 * response.impulse, rtol=1e-15)
    assert found.omega.attrs["symbol"] == r"\omega/2\pi" and "per unit of mass" not in found.impulse.attrs["long_name"]
    assert found.peak_velocity.identical(response.peak_velocity.assign_coords(found.coords))  # nobody asked
    label = gz.plot.response(found, by="impulse")["figure"].axes[0]
    assert label.get_xlabel() == r"$\omega/2\pi$ (Hz)" and label.get_ylabel().endswith("(N s)")


def test_there_and_back_is_the_same_and_survives_a_file(response, tmp_path):
    back = in_units(in_units(response, "Hz", "mm"), "rad/s", "m")
    for name in response.variables:
        if response[name].dtype.kind == "f":
            np.testing.assert_allclose(back[name], response[name], rtol=1e-15, err_msg=name)
    assert back.omega.attrs["units"] == "rad/s" and back.omega.attrs["symbol"] == r"\omega"
    save(in_units(response, "mm"), tmp_path / "a.nc")
    assert load(tmp_path / "a.nc").amplitude.attrs["units"] == "mm"


def test_points_of_a_section_are_converted_coordinate_by_coordinate(rig):
    P = gz.stroboscopic_map(rig)
    plain = gz.basins(P, {"u": np.linspace(-1e-3, 4e-3, 9), "v": np.linspace(-0.2, 0.2, 7)})
    found = in_units(plain, "mm")
    np.testing.assert_allclose(found.point, plain.point * [1e3, 1.0], rtol=1e-15)
    np.testing.assert_allclose(found.graze, plain.graze * [1e3, 1.0], rtol=1e-15)
    assert found.point.attrs["units"] == "mm, m/s"
    assert in_units(found, "mm/s").point.attrs["units"] == "mm, mm/s"
    drawn = gz.plot.basins(found)["figure"].axes[0]
    assert (drawn.get_xlabel(), drawn.get_ylabel()) == ("$x$ (mm)", r"$\dot{x}$ (m/s)")


def test_the_wall_of_a_figure_is_where_its_units_say(rig):
    tr = gz.trajectory(rig, (0.0, 0.0), until=0.3)
    for draw in (gz.plot.history, gz.plot.trajectory):
        ax = draw(in_units(tr, "mm"))["figure"].axes[0]
        high = (ax.get_ylim() if draw is gz.plot.history else ax.get_xlim())[1]
        assert 1.2 < high < 1.8


def test_the_raster_of_a_density_keeps_its_ends(rig):
    P = gz.stroboscopic_map(rig)
    plain = gz.density(P, "omega", [80.0, 90.0], starts=3, keep=20, bins=16)
    found = in_units(plain, "mm", "Hz")
    assert found.u.attrs["low"] == pytest.approx(1e3 * plain.u.attrs["low"], rel=1e-15)
    assert gz.plot.density(found)["figure"].axes[0].get_ylabel() == "$x$ (mm)"


def test_samples_of_a_converted_trajectory_are_refused(rig):
    tr = gz.trajectory(rig, (0.0, 0.0), until=0.3)
    for units in (("mm",), ("ms",), ("mm/s",)):
        with pytest.raises(InputError, match="take samples first"):
            gz.sample(in_units(tr, *units), rate=1000)
    found = in_units(gz.spectrum(gz.sample(tr, rate=1000)), "mm", "kHz")
    assert found.frequency.attrs["units"] == "kHz" and found.frequency.attrs["symbol"] == "f"
    assert found.amplitude.attrs["units"] == "mm"


def test_curves_are_laid_over_a_chart_in_its_units(rig):
    P = gz.stroboscopic_map(rig)
    hertz, gaps = 2 * np.pi * np.linspace(12.0, 17.0, 4), np.linspace(-1.5e-3, -1e-3, 3)
    chart = in_units(gz.chart(P, {"omega": hertz, "sigma": gaps}, starts=2, keep=8, transient=40), "Hz", "mm")
    orbit = gz.periodic_orbits(P.replace(omega=90.0), 1)[0]
    branch = gz.continuation(P, orbit, "omega", (80.0, 100.0))
    edges = gz.boundaries(rig, ("omega", 75.0, 100.0), ("sigma", -1.5e-3, -1e-3), N=1)
    drawn = gz.plot.chart(chart, curves=[branch, edges])
    lines = {name: line for name, (line, _text) in drawn["curves"].items()}
    (word,) = {orbit.word}
    x, y = (np.asarray(values, float) for values in lines[word].get_data())
    assert np.nanmax(np.abs(y + 1.2)) < 1e-12
    # the branch of impacting or of free orbits ends at a graze within, and at the bounds
    assert 80 / (2 * np.pi) - 1e-12 <= np.nanmin(x) < np.nanmax(x) <= 100 / (2 * np.pi) + 1e-12
    for name, line in lines.items():
        if name != word:
            assert -1.5 - 1e-9 <= np.nanmin(line.get_ydata()) <= np.nanmax(line.get_ydata()) <= -1.0 + 1e-9
    assert len(lines) == 1 + len({*edges.label.values.tolist()})  # none of pieces where no orbit is stable


def test_what_was_searched_has_the_units_of_what_was_found(rig):
    table = gz.windows(rig, "omega", 1, span=(70.0, 110.0))
    found = in_units(table, "Hz")
    np.testing.assert_allclose(found.attrs["span"], np.array([70.0, 110.0]) / (2 * np.pi), rtol=1e-15)
    assert in_units(gz.windows(rig, "sigma", 1, span=(-2e-3, -1e-3)), "mm").attrs["span"] == [-2.0, -1.0]
    ax = gz.plot.windows(found)["figure"].axes[0]
    low, high = ax.get_xlim()
    assert 70.0 <= 2 * np.pi * low < 2 * np.pi * high <= 110.0 and ax.get_xlabel() == r"$\omega/2\pi$ (Hz)"
    orbit = gz.one_impact_orbits(rig, 1)[0]
    branch = gz.continuation(gz.stroboscopic_map(rig), orbit, "omega", (85.0, 90.0))
    assert in_units(branch, "mm").attrs["bounds"] == [85.0, 90.0]
    np.testing.assert_allclose(in_units(branch, "Hz").attrs["bounds"], np.array([85.0, 90.0]) / (2 * np.pi), rtol=1e-15)


def test_a_locus_is_converted_with_its_bounds(rig, tmp_path):
    orbit = gz.one_impact_orbits(rig, 1)[0]
    bounds = ((80.0, 100.0), (2.0, 4.0))
    places = np.array([[85.0, 3.0], [90.0, 3.5]])
    made = gz.Locus("gr", ("omega", "cos1"), bounds, places, (orbit, orbit), (), ("bounds", "bounds"))
    save(made.dataset, tmp_path / "locus.nc")
    for one in (made, load(tmp_path / "locus.nc")):
        found = in_units(one, "Hz", "N")
        np.testing.assert_allclose(found.omega, places[:, 0] / (2 * np.pi), rtol=1e-15)
        np.testing.assert_allclose(found.cos1, 0.8 * places[:, 1], rtol=1e-15)
        hertz, newtons = json.loads(found.attrs["bounds"])
        np.testing.assert_allclose(hertz, np.array(bounds[0]) / (2 * np.pi), rtol=1e-15)
        np.testing.assert_allclose(newtons, 0.8 * np.array(bounds[1]), rtol=1e-15)
        assert json.loads(in_units(one, "N").attrs["bounds"])[0] == [80.0, 100.0]


@pytest.mark.parametrize(
    ("units", "said"),
    [(("kg",), r"'kg' matches nothing in the result; it has .*m/s"), (("mm", "cm"), "'mm' and 'cm' both match"),
     (("mmm",), "'mmm' is no unit"), (("N",), "'N' matches nothing")],
)  # fmt: skip
def test_units_that_the_result_has_not(rig, units, said):
    with pytest.raises(InputError, match=said):
        in_units(gz.trajectory(rig, (0.0, 0.0), until=0.2), *units)


def test_numbers_in_chunks_are_read_when_they_are_asked_for(rig):
    pytest.importorskip("dask")
    whole = gz.trajectory(rig, (0.0, 0.0), until=0.2)
    found = in_units(whole.chunk({"t": 5}), "mm")
    assert found.u.chunks and xr.testing.assert_identical(found.compute(), in_units(whole, "mm")) is None


def test_numbers_beyond_the_memory_are_refused(rig, monkeypatch):
    found = gz.trajectory(rig, (0.0, 0.0), until=0.2)
    monkeypatch.setattr("grazing.memory.physical_memory", lambda: 4 * found.u.nbytes - 1)
    with pytest.raises(InputError, match=r"its numbers would take .* open it in chunks"):
        in_units(found, "mm")


def test_what_has_no_units(rig):
    with pytest.raises(InputError, match=r"it is dimensionless: make the model with Oscillator\.from_si"):
        in_units(gz.trajectory(gz.pinball(), (0.1, 0.0)), "mm")
    with pytest.raises(InputError, match="give a dataset as studies return it"):
        in_units(3.0, "mm")
    odd = xr.Dataset({"a": ("x", [1.0, 2.0], {"units": "furlongs per fortnight ("})})
    with pytest.raises(InputError, match="is no unit"):
        in_units(odd, "mm")


@pytest.mark.parametrize("mass", [-0.8, 0.0, np.nan, "heavy", True])
def test_a_mass_that_is_none(mass):
    with pytest.raises(InputError, match="mass"):
        gz.Oscillator(0.0, 1.0, gz.Forcing(omega=1.0), LAW, mass=mass)
