"""What is printed of a rig: gap and frequency, and which columns count downwards."""

import csv
import json

import numpy as np
import pytest

import grazing as gz
from grazing.catalogue import studies
from grazing.catalogue.bifurcations import found as diagram_rows
from grazing.catalogue.branch import found as branch_rows
from grazing.catalogue.rows import told
from grazing.cli.app import main
from grazing.cli.rig import as_given
from grazing.measured import downwards, measured

SI = "m=0.8,c=2.4,k=3200,force=2.5"
LAW = gz.newton(0.7)


def rig(**more):
    given = {"m": 0.8, "c": 2.4, "k": 3200, "force": 2.5, "gap": 1.2e-3, "frequency": 14, "reset": LAW}
    return gz.Oscillator.from_si(**given | more)


@pytest.fixture(scope="module")
def branch():
    P = gz.stroboscopic_map(rig(gap=2e-3))
    (free,) = (one for one in gz.periodic_orbits(P, 1, starts=50) if one.word == "0")
    return gz.continuation(P, free, "sigma", (-2e-3, -1e-4))


def test_a_branch_in_sigma_is_printed_in_gap(branch):
    given = branch_rows_of(branch.dataset)
    plain = branch.dataset
    assert [row["value"] for row in given["special"]] == (-plain["special_value"].values).tolist()
    for row, low, high in zip(given["special"], plain["special_low"].values, plain["special_high"].values, strict=True):
        assert (row["low"], row["high"]) == (-high, -low) and row["low"] <= row["value"] <= row["high"]
    shown = as_given(gz.in_units(branch, "mm"))
    np.testing.assert_allclose(shown["gap"], -1e3 * plain["sigma"], rtol=1e-15)
    assert shown.attrs["parameter"] == "gap" and shown["gap"].attrs["units"] == "mm"


def branch_rows_of(dataset):
    return branch_rows(as_given(dataset).assign(**{f"window_{key}": ("window", []) for key in WINDOW}))


WINDOW = ("word", "period", "low", "low_type", "high", "high_type")


def test_the_ends_of_windows_change_places_with_what_happens_there():
    P = gz.stroboscopic_map(rig())
    result = gz.bifurcation_diagram(P, "sigma", np.linspace(-2e-3, -4e-4, 5), starts=2, period=1, points=400)
    plain, given = diagram_rows(result)["windows"], diagram_rows(as_given(result))["windows"]
    for one, other in zip(plain, given, strict=True):
        assert other == one | {
            "low": -one["high"], "low_type": one["high_type"], "high": -one["low"], "high_type": one["low_type"]
        }  # fmt: skip
    assert {row["high_type"] for row in plain} != {row["low_type"] for row in plain}
    assert [row["ranges"] for row in told(studies()["diagram"], as_given(result))["attractors"]] == [
        [[-high, -low] for low, high in reversed(row["ranges"])]
        for row in told(studies()["diagram"], result)["attractors"]
    ]


def test_frequencies_are_in_hertz_unless_rad_s_is_asked_for():
    P = gz.stroboscopic_map(rig())
    result = gz.orbit_diagram(P, "omega", 2.0 * np.pi * np.array([12.0, 14.0]), starts=2, keep=4)
    given = as_given(result)
    assert given["frequency"].values == pytest.approx([12.0, 14.0]) and given["frequency"].attrs["units"] == "Hz"
    assert given.attrs["title"].endswith(" in frequency")
    assert "omega" in as_given(result, ["rad/s"]).coords
    assert as_given(gz.in_units(result, "Hz"), ["Hz"])["frequency"].values == pytest.approx([12.0, 14.0])
    assert as_given(gz.in_units(result, "rpm"))["frequency"].values == pytest.approx([720.0, 840.0])


def test_coexistence_tells_changes_in_gap():
    P = gz.stroboscopic_map(rig())
    result = gz.coexistence(P, "sigma", np.linspace(-1.2e-3, -7e-4, 4), starts=30, transient=200, keep=20)
    assert len(result["before"]) > 0
    given = as_given(result)
    assert given["before"].values.tolist() == (-result["before"].values).tolist()
    assert told(studies()["coexistence"], given)["parameter"] == "gap"


def test_what_is_not_of_a_rig_is_printed_as_it_is():
    result = gz.orbit_diagram(gz.stroboscopic_map(gz.pinball()), "sigma", [-0.1, 0.0], starts=2, keep=4)
    assert as_given(result) is result and downwards(result) == []
    slopes = gz.sensitivity(rig(), "sigma", N=1, span=(-1e-3, -9e-4))
    assert as_given(slopes) is slopes  # derivatives are in the model's parameters


@pytest.mark.parametrize("side", ["above", "below"])
def test_what_counts_downwards_is_what_figures_turn_over(side):
    model = rig(side=side)
    P = gz.stroboscopic_map(model)
    motion = gz.trajectory(model, (1e-3, 0.1), until=0.3)
    for result in (motion, gz.sample(motion, 1000.0), gz.orbit_diagram(P, "r", [0.6, 0.7], starts=2, keep=4)):
        turned = measured(result)
        differ = [
            str(name)
            for name, one in result.variables.items()
            if one.dtype.kind == "f" and not np.array_equal(one.values, turned[name].values, equal_nan=True)
        ]
        assert differ == downwards(result)
        assert downwards(turned) == []
    assert ("u" in downwards(motion)) == (side == "above")


def run(capsys, *args):
    assert main([*args, "-q"]) == 0
    return capsys.readouterr().out


def test_files_and_words_say_what_counts_downwards(capsys, tmp_path):
    args = ["history", "u=0", "v=0", "--until", "0.3", "--si", f"{SI},gap=1.2 mm,frequency=14", "--r", "0.7"]
    said = run(capsys, *args, "--units", "mm", "-o", f"{tmp_path}/h.csv", "-o", f"{tmp_path}/h.nc")
    assert "signs:   positive down: u, v, v_minus, ...; figures show x, upwards" in said
    with open(tmp_path / "h.csv", newline="") as file:
        head = next(csv.reader(file))
    assert head[:4] == ["t (s)", "u (mm positive down)", "v (m/s positive down)", "wall (mm positive down)"]
    run_export = main(["export", f"{tmp_path}/h.nc", f"{tmp_path}/again.csv"])
    assert run_export == 0 and (tmp_path / "again.csv").read_text() == (tmp_path / "h.csv").read_text()
    capsys.readouterr()
    assert json.loads(run(capsys, *args, "--json"))["down"] == ["u", "v", "v_minus", "v_plus", "wall"]
    below = run(capsys, *args[:6], f"{args[6]},side=below", *args[7:])
    assert "signs:" not in below


def test_a_study_in_gap_and_frequency_is_answered_in_them(capsys):
    rest = ["--si", f"{SI},frequency=14", "--r", "0.7", "--units", "mm"]
    said = run(capsys, "windows", "gap=0.5 mm:2 mm", "--N", "1", *rest)
    assert "windows of one-impact orbits in gap" in said and "searched: gap from 0.5 to 2 mm" in said
    assert "N  gap (mm) from" in said
    said = run(capsys, "response", "frequency=12:14:3", "--starts", "1", "--si", f"{SI},gap=1.2 mm", "--r", "0.7")
    assert "gr             12.92270452912 " in said and "special point  frequency (Hz)" in said


def test_what_the_force_of_a_base_depends_on_is_refused_in_the_words_of_the_rig(capsys):
    shaken = "m=0.8,c=2.4,k=3200,gap=1.2 mm,base=0.1 mm"
    for given in (["frequency=10:12", "--si", shaken], ["c=1:3", "--si", f"{shaken},frequency=10"]):
        assert main(["windows", *given, "--r", "0.8", "--samples", "4", "-q"]) == 2
        said = capsys.readouterr().err
        assert "on damper, spring and frequency" in said and not {"omega", "alpha"} & {*said.split()}


def test_a_history_is_written_as_sound(capsys, tmp_path):
    from scipy.io import wavfile

    args = ["history", "u=0", "v=0", "--until", "2", "--si", f"{SI},gap=1.2 mm,frequency=14", "--r", "0.7"]
    run(capsys, *args, "--units", "mm", "-o", f"{tmp_path}/rig.wav", "-o", f"{tmp_path}/rig.nc")
    rate, played = wavfile.read(tmp_path / "rig.wav")
    assert len(played) / rate == pytest.approx(2.0, abs=1e-4)  # seconds as they were, whatever the units of the rest
    gz.to_wav(gz.trajectory(rig(), (0.0, 0.0), until=2.0), tmp_path / "python.wav")
    assert (tmp_path / "python.wav").read_bytes() == (tmp_path / "rig.wav").read_bytes()
    model = gz.pinball(d=0.12, V=0.4)
    run(capsys, "history", "u=0.1", "v=0", "--until", "600", "--d", "0.12", "--V", "0.4", "-o", f"{tmp_path}/b.wav")
    rate, played = wavfile.read(tmp_path / "b.wav")
    assert len(played) / rate == pytest.approx(
        600.0 / (440.0 * model.period), abs=1e-3
    )  # the forcing is a tone of 440 Hz


def test_a_motion_that_rests_has_no_sound(capsys, tmp_path):
    rest = ["history", "u=0", "v=0", "--until", "600", "--d=-3", "--V", "0", "--r", "0.5", "-o", f"{tmp_path}/rest.wav"]
    assert main([*rest, "-q"]) == 2
    assert "the motion rests: its velocity does not change, and nothing sounds" in capsys.readouterr().err
    assert main(["sample", "u=0", "v=0", "--until", "6", "-o", f"{tmp_path}/rest.wav", "-q"]) == 2
    assert "allowed are png, pdf, svg, nc, csv, parquet, in small letters" in capsys.readouterr().err


def test_a_response_says_what_the_sweeps_could_not_show(capsys):
    """Where both begin inside the band they agree, and there are two stable orbits all the same."""
    args = ["--starts", "1", "--si", f"{SI},gap=1.2 mm", "--r", "0.7"]
    said = run(capsys, "response", "frequency=12:18:13", *args)
    assert "up and down differ at frequency = 13.5 to 16.5 Hz (7 values)" in said
    assert "two stable orbits at frequency = 12.9227 to 16.581 Hz" in said  # from the graze to the fold
    said = run(capsys, "response", "frequency=13.5:14:3", *args)
    assert "up and down agree at every value" in said and "two stable orbits at frequency = 13.5 to 14 Hz" in said
    said = run(capsys, "response", "frequency=18:19:3", *args)
    assert "up and down agree at every value" in said and "two stable" not in said


def test_sweeps_without_a_period_are_not_said_to_agree():
    P = gz.stroboscopic_map(gz.Oscillator(0.1, 1.0, gz.Forcing(omega=0.8), gz.newton(0.8), sigma=-2.0))
    result = gz.response(P, "sigma", [-4.0, -3.0, -2.8], starts=1)
    result["period"][0, :2] = -1
    found_in = told(studies()["response"], result)
    assert (found_in["compared"], found_in["values"]) == (2, 3)
    words = studies()["response"].words(found_in, result, {"vary": {"sigma": ""}})
    assert words[0] == "up and down agree at 2 of 3 values; the others have no period"


def test_a_dry_run_says_what_curves_take(capsys):
    assert "and its curves, in a figure, some 14 s" in run(
        capsys, "chart", "omega=2:3:4", "V=0:0.4:4", "--curves", "2:3", "--starts", "1", "--dry-run"
    )
    plain = run(capsys, "chart", "mu=0:0.4:4", "l=0:1:4", "--map", "gap", "--lam", "0.9", "--curves", "3", "--dry-run")
    assert "curves" not in plain
