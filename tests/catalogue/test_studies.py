"""A study is said once: what a record says is found in commands, configurations, sweeps and tables."""

import json
from pathlib import Path

import pytest

from grazing.catalogue import studies
from grazing.late import named
from tests.processes import python

MAKE = Path(__file__).parents[2] / "docs" / "make_api.py"

#: A study of one's own in a file of its own: how many of the starts are left of zero.
OWN = """
from grazing.catalogue.study import Study
from grazing.studies.plan import Plan, Variable, planned


@planned
def below(P, name, values, *, starts=100, seed=0, level=0.0, threads=None, progress=None):
    import numpy as np

    def compute(cells, arrays):
        for i, cell in enumerate(cells.tolist()):
            moved = P.replace(**{name: float(axis[cell])})
            arrays["share"][i] = np.mean([moved.iterate((x,), 5)[-1, 0] < level for x in np.linspace(0.0, 1.0, starts)])
            yield

    axis = np.asarray(values, float)
    said = {"study": "below", "parameter": name, "starts": starts}
    share = Variable((), "float64", {"long_name": "share of the starts"})
    return Plan(P=P, title=f"below in {name}", config=said, axes={name: axis}, variables={"share": share},
                compute=compute, together=1, work=5 * starts)


STUDY = Study(
    name="below", place=65, compute="grazing.catalogue.below:below",
    least=1, most=1, says="how many orbits end below a level", help="Count the orbits that end below a level.",
    example="mu=0:1:5", prints="the greatest share",
    options={"level": ("number", "where to cut")},
    found=lambda result: {"greatest": float(result["share"].max())},
    words=lambda found, *_of: [f"at most {found['greatest']:.3g} of them"],
)
"""
DRAWN = """
from grazing.plot.style import axes, root


def below(result, ax=None, *, colour="#ff0000"):
    ax = axes(ax)
    ax.plot(result["share"].values, color=colour)
    return {"figure": root(ax)}
"""
ASKED = """
import sys
from pathlib import Path
import grazing.catalogue
import grazing.plot
grazing.catalogue.__path__.append(sys.argv[1])
grazing.plot.__path__.append(sys.argv[1] + "/plot")
from grazing.cli.app import app, main
def run(*tokens):
    code = main(list(tokens))
    assert code == 0, (tokens, code)
gap = ["--map", "gap", "--lam", "0.5", "--l", "0.1", "-q"]
"""


@pytest.fixture
def asked(tmp_path):
    (tmp_path / "plot").mkdir()
    (tmp_path / "below.py").write_text(OWN)
    (tmp_path / "plot" / "below.py").write_text(DRAWN)

    def run(code):
        done = python(ASKED + code, tmp_path, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def test_a_study_of_ones_own_has_a_command_and_help(asked):
    out = asked("run('--help'); run('below', '--help'); run('below', 'mu=0.1:0.3:3', *gap, '--level', '0.1')")
    listed = [line.split()[1] for line in out.splitlines() if line.startswith("\u2502 ")]
    assert listed.index("coexistence") < listed.index("below") < listed.index("trajectory")
    assert "--level NUMBER" in out and "where to cut" in out and "--dry-run" in out and "at most " in out
    words = " ".join(out.replace("\u2502", "").split())
    assert "Its ending chooses the format: png, pdf, svg (figure), nc (result, NetCDF), csv or parquet" in words


def test_it_is_in_the_schema_and_completed(asked):
    out = asked("import json; from grazing.config import json_schema; print(json.dumps(json_schema()));"
                "[print(app.generate_completion(shell=shell)) for shell in ('bash', 'zsh', 'fish')]")  # fmt: skip
    schema, _newline, scripts = out.partition("\n")
    table = json.loads(schema)["$defs"]["BelowSettings"]["properties"]
    assert [*table] == ["starts", "seed", "level"] and table["level"]["description"] == "where to cut"
    assert scripts.count("Count the orbits that end below a level.") >= 2 and "--level" in scripts


def test_it_is_swept_and_the_command_is_known_again(asked):
    out = asked(
        'Path(\'a.toml\').write_text(\'study = "below"\\nmap = "gap"\\nvary.mu = "0:1:4"\\n'
        "parameters = {lam = 0.5, l = 0.1}\\nsettings = {level = 0.2, starts = 10}')\n"
        "run('sweep', 'run', 'a.toml', 'a.zarr', '-q'); run('info', 'a.zarr')"
    )
    assert "grazing below mu=0:1:4 --map gap --lam 0.5 --l 0.1 --starts 10 --level 0.2" in out


def test_it_is_drawn_by_the_function_of_its_name(asked):
    asked(
        "run('below', 'mu=0.1:0.3:3', *gap, '-o', 'a.svg', '-o', 'a.nc')\n"
        "run('plot', 'a.nc', '-o', 'b.svg', '--style', 'colour=#00ff00')\n"
        "a, b = (Path(file).read_text() for file in ('a.svg', 'b.svg'))\n"
        "assert '#00ff00' in b and '#00ff00' not in a and '#ff0000' in a"
    )


def test_it_is_in_the_table_of_the_documentation(asked):
    out = asked(f"import runpy; print(runpy.run_path({str(MAKE)!r})['studies_table']())")
    assert "| `below` | the greatest share |" in out.splitlines()


@pytest.mark.parametrize("study", studies().values(), ids=studies())
def test_a_record_names_what_there_is(study):
    from grazing import plans, plot

    assert callable(named(study.compute)) and study.plan in (None, getattr(plans, study.function, None))
    assert not study.drawn_by or callable(getattr(plot, study.drawn_by))
    assert (study.proves == "") == (study.prove is None)
    assert study.help.endswith(".") and study.least <= study.most
