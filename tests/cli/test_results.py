"""``grazing plot``, ``info`` and ``config``: stored results, where they come from, what a configuration says."""

import json
import re
import shlex
import tomllib

import numpy as np
import pytest

import grazing as gz
from grazing.cli import main
from grazing.config import json_schema

DIAGRAM = ["diagram", "mu=0:0.1:5", "--map", "gap", "--lam", "0.5", "--l", "0.1", "--starts", "3", "--keep", "8", "-q"]
CHART = ["chart", "mu=0:0.1:3", "l=0:0.2:4", "--map", "gap", "--lam", "0.5", "--starts", "3", "--keep", "8", "-q"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def said(capsys, code, *tokens):
    capsys.readouterr()
    assert main(list(tokens)) == code
    out, err = capsys.readouterr()
    assert "Traceback" not in err
    return out + re.sub(r"\Areading \S+\.zarr\n", "", err)


# ---- boundary curves on a chart


def test_curves_are_drawn_told_and_kept(folder, capsys):
    main([*CHART, "-o", "plain.png", "-o", "plain.nc"])
    main([*CHART, "--curves", "2:3", "-o", "a.png", "-o", "a.nc"])
    assert (folder / "a.png").read_bytes() != (folder / "plain.png").read_bytes()
    assert "--curves 2,3 " in said(capsys, 0, "info", "a.png")
    assert "curves = [2, 3]" in said(capsys, 0, "info", "a.nc", "--config")
    main(["plot", "a.nc", "-o", "b.png"])
    main(["plot", "plain.nc", "--curves", "2,3", "-o", "c.png"])
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes() == (folder / "c.png").read_bytes()
    assert "a.nc is no chart" not in said(capsys, 0, "plot", "a.nc", "--curves", "4", "-o", "d.png")
    one, other = gz.load(folder / "plain.nc"), gz.load(folder / "a.nc")
    assert one.attrs["grazing_config_sha256"] == other.attrs["grazing_config_sha256"]  # the numbers are the same


@pytest.mark.filterwarnings("always")
def test_stored_branches_and_loci_lie_on_a_chart(folder, capsys):
    chart = ["chart", "d=0.08:0.14:4", "V=0:0.6:3", "--starts", "2", "--keep", "8", "-q", "-o", "chart.nc"]
    said(capsys, 0, *chart, "--alpha", "3", "--k", "1", "--omega", "2.2", "--r", "0.8")
    P = gz.stroboscopic_map(gz.pinball(alpha=3, k=1, omega=2.2, r=0.8, V=0.4))
    (orbit,) = gz.periodic_orbits(P.replace(d=0.12), word="001")
    branch = gz.continuation(P, orbit, "d", (0.09, 0.14))
    gz.save(branch.dataset, "branch.nc")
    graze = next(point for point in branch.special if point.type == "gr")
    gz.save(gz.locus(graze, ("d", "V"), ((0.08, 0.14), (0.1, 0.6))).dataset, "locus.nc")
    told = said(capsys, 0, "plot", "chart.nc", "--curves", "branch.nc", "--curves", "locus.nc", "-o", "both.svg")
    assert "written: both.svg" in told
    drawn = (folder / "both.svg").read_text()
    assert "<!-- 001 -->" in drawn and "<!-- 001 gr -->" in drawn
    # the study itself draws them in the same call, on top of boundaries too, and the figure's command says so
    every = ["--curves", "2", "--curves", "branch.nc", "--curves", "locus.nc"]
    pinball = ["--alpha", "3", "--k", "1", "--omega", "2.2", "--r", "0.8"]
    said(capsys, 0, *chart[:-1], "again.nc", *pinball, *every, "-o", "all.svg")
    labels = re.findall("<!-- (.*?) -->", (folder / "all.svg").read_text())
    assert {"001", "001 gr"} <= {*labels} and any(label.startswith("2 ") for label in labels)
    command = said(capsys, 0, "info", "all.svg").partition("again:     ")[2]
    assert f"--curves 2 --curves {folder / 'branch.nc'} --curves {folder / 'locus.nc'}" in command
    assert "the curves are left out" not in said(capsys, 0, "plot", "again.nc", "-o", "again.svg")
    assert re.findall("<!-- (.*?) -->", (folder / "again.svg").read_text()) == labels
    (folder / "branch.nc").rename(folder / "moved.nc")
    assert "the curves are left out: --curves = branch.nc; there" in said(capsys, 0, "plot", "again.nc", "-o", "b.svg")
    (folder / "moved.nc").rename(folder / "branch.nc")
    for other, reason in (
        ("no.nc", "--curves = no.nc; there is no such file, and periods are written 2,3,5 or 2:7"),
        ("chart.nc", "no curve can be drawn from this Dataset; give "),
        (".", "is a folder without a sweep"),
    ):
        assert reason in said(capsys, 2, "plot", "chart.nc", "--curves", other, "-o", "no.svg")
    assert "branch.nc is no chart" in said(capsys, 2, "plot", "branch.nc", "--curves", "locus.nc", "-o", "no.svg")


def test_curves_that_theory_does_not_know_are_refused_before_the_chart_is_computed(folder, capsys, monkeypatch):
    monkeypatch.setattr("grazing.cli.study.made_of", None)
    line = ["chart", "d=0:0.1:3", "V=0:0.2:4", "--map", "discontinuity", "--curves", "2", "-q", "-o", "a.png"]
    assert "has no boundaries in closed form" in said(capsys, 2, *line)
    line = ["chart", "mu=0.1,0.1", "l=0:0.2:4", "--map", "gap", "--lam", "0.5", "--curves", "2", "-q", "-o", "a.png"]
    assert "curves need a plane, but mu is always 0.1" in said(capsys, 2, *line)
    assert "--curves = 0; allowed is a whole number >= 1" in said(capsys, 2, *CHART, "--curves", "0")
    assert "nknown option" in said(capsys, 2, *DIAGRAM, "--curves", "2")


# ---- info


# ---- in another format


@pytest.mark.parametrize("stored", ["a.nc", "a.zarr"])
def test_a_stored_result_is_exported_as_it_would_have_been_written(folder, capsys, stored):
    main([*CHART, "-o", stored, "-o", "direct.csv", "-o", "direct.parquet"])
    text = said(capsys, 0, "export", stored, "again.csv")
    assert text == "chart of the gap map in mu and l\nwritten: again.csv\n"
    assert (folder / "again.csv").read_bytes() == (folder / "direct.csv").read_bytes()
    assert json.loads(said(capsys, 0, "export", stored, "again.parquet", "--json"))["files"] == ["again.parquet"]
    from pyarrow import parquet

    assert parquet.read_table("again.parquet").equals(parquet.read_table("direct.parquet"))
    said(capsys, 0, "export", stored, "again.nc")
    assert gz.load("again.nc").equals(gz.load(stored) if stored == "a.nc" else gz.sweep.open_store(stored).load())


def test_chosen_variables_are_exported_alone(folder, capsys):
    main([*CHART, "-o", "a.nc"])
    said(capsys, 0, "export", "a.nc", "some.csv", "--variables", "period, share")
    assert (folder / "some.csv").read_text().partition("\n")[0] == "mu,l,rank,period,share"
    told = said(capsys, 2, "export", "a.nc", "no.csv", "--variables", "period,shares")
    assert "--variables: unknown variable 'shares'; did you mean 'share'? allowed are period, word, share" in told


def test_what_is_not_exported_is_said(folder, capsys):
    main([*CHART, "-o", "a.nc"])
    assert "allowed are nc, csv, parquet, in small letters" in said(capsys, 2, "export", "a.nc", "a.png")
    assert "no.nc" in said(capsys, 2, "export", "no.nc", "a.csv")
    assert not (folder / "a.csv").exists()


@pytest.mark.parametrize("file", ["a.png", "a.pdf", "a.svg", "a.nc", "a.zarr"])
def test_every_file_tells_the_command_that_makes_it(file, capsys):
    main([*CHART, "-o", file])
    text = said(capsys, 0, "info", file)
    kind = {"nc": "result", "zarr": "store"}.get(file.partition(".")[2], "figure")
    assert text.startswith(f"{file}: {kind}: chart of the gap map in mu and l\n")
    command = "grazing chart mu=0:0.1:3 l=0:0.2:4 --map gap --lam 0.5 --starts 3 --keep 8"
    assert text.splitlines()[-1] == f"again:     {command} -o {file}"
    assert "made by:   grazing" in text and "sha256" in text
    found = json.loads(said(capsys, 0, "info", file, "--json"))
    assert found["kind"] == kind and found["recipe"]["study"] == "chart" and found["why_not"] is None
    recipe = tomllib.loads(said(capsys, 0, "info", file, "--config"))
    assert recipe["vary"] == {"mu": "0:0.1:3", "l": "0:0.2:4"}


def test_the_command_names_the_units_that_a_file_is_in(folder, capsys):
    rig = ["--si", "m=0.8,c=2.4,k=3200,force=2.5,gap=1.2 mm,frequency=14", "--r", "0.7"]
    said(capsys, 0, "history", "u=0", "v=0", "--until", "0.5", *rig, "--units", "mm,ms", "-o", "a.png", "-o", "a.nc")
    first = (folder / "a.png").read_bytes()
    for file in ("a.png", "a.nc"):
        _, command = said(capsys, 0, "info", file).split("again:     grazing ")
        assert "--units mm,ms" in command
        said(capsys, 0, *shlex.split(command))
        assert (folder / "a.png").read_bytes() == first
    assert 'units = "mm,ms"' in said(capsys, 0, "info", "a.nc", "--config")
    said(capsys, 0, "plot", "a.nc", "--units", "m", "-o", "b.png")  # metres take the place of millimetres
    assert "--units ms,m " in said(capsys, 0, "info", "b.png")
    said(capsys, 0, "history", "u=0", "v=0", "--until", "0.5", *rig, "-o", "c.png")
    assert "--units" not in said(capsys, 0, "info", "c.png")


def test_values_in_other_units_are_not_taken_for_those_of_the_model(folder, capsys):
    rig = gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, force=2.5, gap=1.2e-3, frequency=14, reset=gz.newton(0.7))
    diagram = gz.orbit_diagram(gz.stroboscopic_map(rig), "omega", [80.0, 85.0, 100.0], starts=1, keep=4)
    gz.save(diagram, "si.nc")
    gz.save(gz.in_units(diagram, "Hz"), "hertz.nc")
    assert "diagram omega=80.0,85.0,100.0 " in said(capsys, 0, "info", "si.nc")
    assert "no command: its values of omega were converted to other units" in said(capsys, 0, "info", "hertz.nc")


def test_a_configuration_tells_its_command(folder, capsys):
    (folder / "a.toml").write_text('study = "diagram"\nvary.d = "0.05:0.16:9"\nparameters.V = 0.2\n')
    assert "again:     grazing diagram d=0.05:0.16:9 --V 0.2" in said(capsys, 0, "info", "a.toml")


def test_what_has_no_command_says_why(folder, capsys):
    P = gz.Map(lambda state, p: (p.a * state[0],), params={"a": 0.5}, name="my map")
    gz.save(gz.orbit_diagram(P, "a", [0.1, 0.2], starts=2, keep=4), "a.nc")
    assert "no command: its map, my map, is known to Python alone" in said(capsys, 0, "info", "a.nc")
    assert "cannot be made again by a command" in said(capsys, 2, "info", "a.nc", "--config")
    values = np.sort(np.random.default_rng(0).uniform(0, 0.1, 500))
    gz.save(gz.orbit_diagram(gz.gap_map(0.5, 0.1, 0.1), "mu", values, starts=1, keep=4), "b.nc")
    assert "no command: its values make a long command; --config prints a file" in said(capsys, 0, "info", "b.nc")
    (folder / "b.toml").write_text(said(capsys, 0, "info", "b.nc", "--config"))
    main(["diagram", "--config", "b.toml", "-o", "c.nc", "-q"])
    assert np.array_equal(gz.load("c.nc").x.values, gz.load("b.nc").x.values)


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("loop.nc", "loop.nc cannot be read: Too many levels"),
        ("no.nc", "there is no file no.nc"),
        ("a.csv", "ask a .nc of the same result"),
        ("a.txt", "was not written by gz.save"),
        ("a.png", "is no figure"),
        ("a.toml", "is not TOML"),
        ("folder", "folder"),
    ],
)
def test_what_is_not_ours(file, text, folder, capsys):
    for name in ("a.csv", "a.txt", "a.png", "a.toml"):
        (folder / name).write_text("= nonsense")
    (folder / "folder").mkdir()
    (folder / "loop.nc").symlink_to("loop.nc")
    assert text in said(capsys, 2, "info", file)


# ---- plot


def test_a_stored_result_is_drawn(folder, capsys):
    main([*DIAGRAM, "-o", "a.nc", "-o", "a.png"])
    assert "written: b.png, b.pdf" in said(capsys, 0, "plot", "a.nc", "-o", "b.png", "-o", "b.pdf")
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes()
    assert json.loads(said(capsys, 0, "plot", "a.nc", "-o", "c.svg", "--json"))["files"] == ["c.svg"]
    main([*CHART, "-o", "c.zarr"])
    assert "written: c.png" in said(capsys, 0, "plot", "c.zarr", "-o", "c.png")
    assert main(["plot", "c.zarr", "-o", "c.png"]) == 0
    assert capsys.readouterr().err == "reading c.zarr\n"  # a large one takes many seconds


def test_a_motion_made_in_python_is_drawn_though_it_names_no_study(folder, capsys):
    motion = gz.trajectory(gz.pinball(d=0.12, V=0.4), (0.1, 0.0), until=50.0)
    for name, result in (("motion", motion), ("lines", gz.spectrum(gz.sample(motion, 20.0)))):
        gz.save(result, f"{name}.nc")
        assert f"written: {name}.svg" in said(capsys, 0, "plot", f"{name}.nc", "-o", f"{name}.svg")


def test_arguments_of_the_figure(folder, capsys):
    main([*CHART, "-o", "a.nc", "-o", "a.png"])
    assert main(["plot", "a.nc", "-o", "b.png", "--style", "by=exponent", "--style", "legend=no"]) == 0
    assert (folder / "a.png").read_bytes() != (folder / "b.png").read_bytes()
    assert "--style colour=red: unknown argument; allowed are by" in said(
        capsys, 2, "plot", "a.nc", "-o", "b.png", "--style", "colour=red"
    )
    assert "allowed are true and false" in said(capsys, 2, "plot", "a.nc", "-o", "b.png", "--style", "legend=maybe")
    for switch, there in (("yes", True), ("no", False)):
        assert main(["plot", "a.nc", "-o", "c.svg", "--style", f"legend={switch}"]) == 0
        assert ('id="legend_1"' in (folder / "c.svg").read_text()) is there
    assert "give NAME=VALUE" in said(capsys, 2, "plot", "a.nc", "-o", "b.png", "--style", "legend")
    assert "by" in said(capsys, 2, "plot", "a.nc", "-o", "b.png", "--style", "by=colour")
    main([*DIAGRAM, "-o", "d.nc"])
    assert "give a number" in said(capsys, 2, "plot", "d.nc", "-o", "b.png", "--style", "size=big")
    assert main(["plot", "d.nc", "-o", "b.png", "--style", "size=0.5", "--style", "longest=4"]) == 0


@pytest.mark.parametrize(
    ("tokens", "text"),
    [
        (["a.nc"], "nothing to write; give -o"),
        (["a.nc", "-o", "b.nc"], "allowed are png, pdf, svg"),
        (["no.nc", "-o", "b.png"], "there is no file no.nc"),
        (["x.nc", "-o", "b.png"], "there is no figure of a result that does not say its study"),
        ([], "RESULT"),
    ],
)
def test_what_cannot_be_drawn(tokens, text, capsys):
    import xarray as xr

    gz.save(xr.Dataset({"a": ("x", [1.0])}), "x.nc")
    assert text in said(capsys, 2, "plot", *tokens)


# ---- config


def test_the_schema_is_json(capsys):
    assert json.loads(said(capsys, 0, "config", "schema")) == json_schema()


def test_a_configuration_is_completed(folder, capsys):
    (folder / "a.toml").write_text('study = "diagram"\nvary.d = "0.05:0.16:9"\n')
    found = tomllib.loads(said(capsys, 0, "config", "show", "a.toml"))
    assert found["parameters"]["omega"] == 2.2 and found["settings"]["transient"] == 200
    assert json.loads(said(capsys, 0, "config", "show", "a.toml", "--json")) == found
    (folder / "a.toml").write_text('study = "diagram"\nvary.d = "0.05:0.16:9"\n[parameters]\nr = 3\nq = 1\n')
    text = said(capsys, 2, "config", "show", "a.toml")
    assert text.startswith("error: a.toml has 2 errors:\n  parameters.r = 3; allowed is 0 <= r <= 1")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_knows_options_with_their_case(shell, folder, monkeypatch):
    monkeypatch.setenv("HOME", str(folder))
    assert main(["--install-completion", "--shell", shell, "--output", str(folder / "completion")]) == 0
    text = (folder / "completion").read_text()
    assert "diagram" in text and "resume" in text
    assert ("--V" in text and "--omega" in text) or "-l V" in text


@pytest.mark.filterwarnings("always")
def test_an_unfinished_chart_is_drawn_in_the_memory_of_its_numbers():
    """One chunk of a wide chart with long words: the letters of all cells would take 10 times as much."""
    import tracemalloc

    from grazing import sweep

    G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    axes = {"mu": np.linspace(0.0, 0.3, 400), "l": np.linspace(0.0, 0.5, 300)}
    plan = gz.plans.chart(G, axes, starts=24, transient=20, keep=200, exponent_steps=5)
    sweep.run(plan, "a.zarr", chunk=300, shard=(1, 400))
    numbers = plan.cells * plan.size_of_cell
    tracemalloc.start()
    try:
        assert main(["plot", "a.zarr", "-o", "a.png"]) == 0
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    letters = plan.cells * 24 * plan.variables["word"].longest
    assert letters > 6 * numbers > 3e8  # what it once took, several times over
    assert peak < 3 * numbers, (peak, numbers)
