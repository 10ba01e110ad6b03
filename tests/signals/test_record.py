"""Histories, samples and spectra in one call: what Python makes of the same trajectory, in the shell as well."""

import json

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing.cli import main
from grazing.io import load
from grazing.signals.record import USUAL, history, sampled, spectrum_of

SI = "m=0.8,c=2.4,k=3200,force=2.5,gap=1.2 mm,frequency=14 Hz"


@pytest.fixture(scope="module")
def rig():
    return gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, force=2.5, gap=1.2e-3, frequency=14, reset=gz.newton(0.7))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_they_are_those_of_the_trajectory(rig):
    flown = gz.trajectory(rig, (0.0, 0.0), until=1.0)
    recorded = sampled(rig, (0.0, 0.0), until=1.0, rate=500.0)
    xr.testing.assert_identical(recorded, gz.sample(flown, 500.0))
    late = sampled(rig, (0.0, 0.0), until=1.0, since=0.6, rate=500.0)
    np.testing.assert_array_equal(late.u, recorded.u.values[300:])
    assert (late.impact_time >= 0.6).all() and 0 < late.sizes["impact"] < recorded.sizes["impact"]
    found = spectrum_of(rig, (0.0, 0.0), until=1.0, since=0.6, rate=500.0, of="v", window="boxcar")
    xr.testing.assert_identical(found, gz.spectrum(late.isel(t=slice(None, -1)), "v", "boxcar"))
    cycles = spectrum_of(rig, (0.0, 0.0), until=1.0, since=0.5, rate=560.0, window="boxcar")
    assert np.abs(cycles.order.values - 1.0).min() < 1e-12  # of seven whole ones a line is where it must be
    assert sampled(rig, (0.0, 0.0), until=0.2).attrs["sample_rate"] == USUAL * 14.0
    seen = history(rig, (0.0, 0.0), until=1.0, of="v")
    xr.testing.assert_equal(seen, flown)
    assert gz.plot.history(seen)["figure"].axes[0].get_ylabel().startswith("velocity")
    late = history(rig, (0.0, 0.0), until=1.0, since=0.6)
    assert late.t.values.tolist() == flown.t.values[flown.t.values >= 0.6].tolist()
    np.testing.assert_array_equal(late.u, flown.u.values[flown.t.values >= 0.6])
    assert (late.impact_time >= 0.6).all() and 0 < late.sizes["impact"] < flown.sizes["impact"]
    assert gz.plot.history(seen, of="u")["figure"].axes[0].get_ylabel().startswith("position")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda m: sampled(m, (0.0, 0.0), until=1.0, since=1.0),
            "since = 1; allowed is start = 0 <= since < until = 1",
        ),
        (lambda m: sampled(m, (0.0, 0.0), until=1.0, since=-0.1), "since = -0.1"),
        (
            lambda m: history(m, (0.0, 0.0), until=1.0, since=2.0),
            "since = 2; allowed is start = 0 <= since < until = 1",
        ),
        (lambda m: sampled(m, (0.0, 0.0), until=1.0, rate=-1.0), "rate = -1"),
        (lambda m: history(m, (0.0, 0.0), until=1.0, of="w"), "of = 'w'; allowed are u, the position"),
        (lambda m: spectrum_of(m, (0.0, 0.0), until=0.1, rate=50.0), "there are 5 samples"),
    ],
)
def test_what_is_wrong_is_said(rig, call, said):
    with pytest.raises(gz.InputError, match=said):
        call(rig)


def test_rests_that_ended_before_are_left_out():
    """Between walls they were told of all the same."""
    walls = gz.wall(-0.1, gz.newton(0.0)), gz.wall(0.1, gz.newton(0.0))
    m = gz.Oscillator(0.1, 1.0, gz.Forcing(omega=1.0, cos=(1.0,)), walls=walls)
    whole, middle = gz.trajectory(m, (0.0, 0.0), until=20.0).rest_time.values, 10.0
    after = whole[whole[:, 1] >= middle]
    assert 0 < len(after) < len(whole) and after[0, 0] < middle  # one goes on at that time
    for late in (
        history(m, (0.0, 0.0), until=20.0, since=middle),
        sampled(m, (0.0, 0.0), until=20.0, since=middle),
    ):
        np.testing.assert_array_equal(late.rest_time, after)


def test_the_shell_prints_what_was_found_and_writes_it(folder, capsys):
    rig = ["u=0", "v=0", "--si", SI, "--r", "0.7", "--until", "2", "--units", "mm", "-q"]
    assert main(["history", *rig, "--of", "v", "-o", "a.png", "-o", "a.nc"]) == 0
    assert "27 impacts, certified" in capsys.readouterr().out
    assert main(["history", *rig, "--since", "1", "-o", "late.nc"]) == 0
    assert "14 impacts, certified" in capsys.readouterr().out and load("late.nc").t[0] >= 1.0
    assert main(["info", "late.nc"]) == 0 and "--since 1.0" in capsys.readouterr().out
    assert main(["sample", *rig, "--rate", "2000", "--since", "1", "-o", "b.csv", "-o", "b.nc", "-o", "b.pdf"]) == 0
    assert "2001 samples, 2000 per s, t from 1 to 2 s" in capsys.readouterr().out
    assert (folder / "b.csv").read_text().startswith("t (s),u (mm positive down),v (m/s positive down)")
    assert main(["spectrum", *rig, "--since", "1", "--window", "boxcar", "-o", "c.nc", "-o", "c.svg", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    first = said["found"]["lines"][0]
    assert first["order"] == pytest.approx(1.0, abs=0.01) and said["units"]["mm"] == ["amplitude"]
    amplitude = load("c.nc").amplitude
    assert first["amplitude"] == float(amplitude.max()) == pytest.approx(1.5, rel=0.05)
    heights = [line["amplitude"] for line in said["found"]["lines"]]
    assert heights == sorted(heights, reverse=True) and heights[-1] >= 1e-3 * heights[0]
    for name in "abc":  # each knows its figure, and the command that makes it again
        assert main(["plot", f"{name}.nc", "-o", f"{name}2.png"]) == 0
        assert main(["info", f"{name}.nc"]) == 0
        out = capsys.readouterr().out
        assert f"grazing {dict(a='history', b='sample', c='spectrum')[name]} " in out
    assert main(["plot", "c.nc", "-o", "d.png", "--style", "over=order", "--style", "until=9"]) == 0


def test_a_rest_is_a_rest_in_millimetres(folder, capsys):
    still = "m=0.8,c=2.4,k=3200,force=0.1,gap=0,load=5,frequency=14"
    rig = ["trajectory", "u=0", "v=0", "--si", still, "--r", "0.5", "--until", "0.2", "-q", "--json"]
    found = []
    for units in ([], ["--units", "mm"]):
        assert main([*rig, *units]) == 0
        found.append(json.loads(capsys.readouterr().out)["found"]["rests"])
    assert found[0] == found[1] != []


def test_motion_below_any_line_is_said(folder, capsys):
    still = "m=0.8,c=2.4,k=3200,force=0.1,gap=0,load=5,frequency=14"
    assert main(["spectrum", "u=0", "v=0", "--si", still, "--r", "0.5", "--until", "1", "-q", "-o", "a.png"]) == 0
    assert "no lines: nothing moves" in capsys.readouterr().out
