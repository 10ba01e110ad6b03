"""The report end to end on a reduced size, and what its figures show."""

import json
import os
import re
import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import grazing
from grazing.outcome import InputError
from grazing.paper import FIGURES
from grazing.paper import report as reporting
from grazing.paper.report import BESIDE, chosen_groups, report, selected
from grazing.paper.run import Run, figure_module
from grazing.paper.slips import SLIPS
from grazing.plot.style import figure


@pytest.fixture(scope="module")
def run():
    return Run("small")


@pytest.fixture(scope="module")
def whole(tmp_path_factory, run):
    place = tmp_path_factory.mktemp("paper")
    told = []
    with pytest.MonkeyPatch.context() as patch:  # what other tests look at is computed here, once
        patch.setattr("grazing.paper.run.Run", lambda size: run)
        return place, report(place, size="small", progress=lambda *step: told.append(step)), told


def test_all_files_are_there(whole):
    place, result, _told = whole
    expected = {f"figure-{name}.{kind}" for name in (*FIGURES, BESIDE) for kind in ("png", "pdf")}
    assert set(os.listdir(place)) == expected | {"index.html", "claims.json"} == set(result["files"])


def test_no_claim_differs_and_every_slip_is_shown(whole):
    place, result, _told = whole
    records = json.loads((place / "claims.json").read_text(encoding="utf-8"))
    assert result["differs"] == []
    assert len(records) == result["claims"] == sum(result["verdicts"].values())
    assert len({record["id"] for record in records}) == len(records)
    for record in records:
        assert record["verdict"] == ("agrees" if record["slip"] is None else "corrected"), record
    assert {record["slip"] for record in records} - {None} == set(SLIPS)


def test_claims_come_last_and_progress_reaches_its_end(whole):
    place, _result, told = whole
    times = {name: (place / name).stat().st_mtime_ns for name in os.listdir(place)}
    assert max(times, key=times.__getitem__) == "claims.json"
    assert [step[0] for step in told] == list(range(1, told[0][1] + 1))
    assert {f"Figure {name}" for name in FIGURES} <= {step[2] for step in told}


def test_the_page_needs_nothing_from_elsewhere(whole):
    place, _result, _told = whole
    page = (place / "index.html").read_text(encoding="utf-8")
    links = re.findall(r'(?:src|href)="([^"#]+)"', page)
    assert links
    for link in links:
        assert (place / link).is_file(), link
    for anchor in re.findall(r'href="#([^"]+)"', page):
        assert f'id="{anchor}"' in page
    assert page.count("<tr>") > 180
    assert not re.search(r"https?://", page)


def test_a_selection_draws_and_claims_what_belongs_to_it(tmp_path):
    result = report(tmp_path, figures=["3.4"], size="small")
    assert set(result["files"]) == {"figure-3.4.png", "figure-3.4.pdf", "index.html", "claims.json"}
    assert 0 < result["claims"] < 20
    assert "1 of 13 figures" in (tmp_path / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["1.2", "1.5"])
def test_a_portrait_alone_has_its_claims(tmp_path, name):
    result = report(tmp_path, figures=name, size="small")
    assert result["differs"] == []
    records = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert {f"{name}-period", f"{name}-impacts"} <= {record["id"] for record in records}
    other = {"1.2": "1.5", "1.5": "1.2"}[name]
    assert not any(record["id"].startswith(other) for record in records)


def test_every_figure_alone_has_claims():
    assert all(list(chosen_groups((name,))) for name in FIGURES)


def test_a_selection_without_claims_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr("grazing.paper.report.chosen_groups", lambda names: [])
    result = report(tmp_path, figures="3.1", size="small")
    assert result["claims"] == 0
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert page.count("No claims belong to these figures.") == 2
    assert "with their claims" not in page


def test_verdicts_are_counted_in_a_sentence():
    from grazing.paper.page import summary

    records = [{"verdict": verdict} for verdict in ("agrees", "agrees", "corrected")]
    said = summary(FIGURES, records)
    assert re.sub("<[^>]+>", "", said) == "3 claims, each computed in this run: 2 agree, 1 corrected, 0 differ."
    assert 'class="verdict differs"' not in said
    said = summary(FIGURES, [{"verdict": "differs"}])
    assert 'class="verdict differs">1 differs' in said


def test_every_group_belongs_to_figures_of_the_paper():
    from importlib import import_module

    from grazing.paper.report import CLAIMS

    for module in CLAIMS:
        for about, group in import_module(f"grazing.paper.{module}").GROUPS:
            assert set(about) <= set(FIGURES), group
    assert len(list(chosen_groups(("3.4",)))) == 1


def test_selected_keeps_the_order_of_the_paper():
    assert selected(None) == FIGURES
    assert selected("3.1") == ("3.1",)
    assert selected(["3.1", "1.2", "3.1"]) == ("1.2", "3.1")


@pytest.mark.parametrize("figures", ["1.1", "9.9", ["1.2", "figure"]])
def test_an_unknown_figure_is_refused_before_anything_is_written(tmp_path, figures):
    with pytest.raises(InputError, match=r"figure '.*' is not one that can be drawn; allowed are 1.2, .*3.7.*choose"):
        report(tmp_path / "out", figures=figures)
    assert os.listdir(tmp_path) == []


def test_an_empty_selection_and_an_unknown_size_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"no figure is selected; allowed are 1\.2"):
        report(tmp_path / "out", figures=[])
    with pytest.raises(InputError, match="size is 'huge'; allowed are small, paper, large"):
        report(tmp_path / "out", size="huge")
    with pytest.raises(InputError, match="size is 'huge'"):
        Run("huge")
    assert os.listdir(tmp_path) == []


def test_a_file_in_the_place_of_the_folder_stays(tmp_path):
    path = tmp_path / "out"
    path.write_text("mine")
    with pytest.raises(InputError, match="cannot write to"):
        report(path, figures="3.4", size="small")
    assert path.read_text() == "mine"


def test_an_interrupted_run_leaves_old_files_whole(tmp_path):
    report(tmp_path, figures="3.4", size="small")
    before = {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)}

    def interrupt(_done, _total, _what):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        report(tmp_path, figures="3.4", size="small", progress=interrupt)
    assert {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)} == before


def in_another_process(code, *arguments, **environment):
    """Run code with this checkout, whatever else is installed."""
    path = str(Path(grazing.__file__).parents[1])
    env = {**os.environ, "PYTHONPATH": path, **environment}
    return subprocess.run(
        [sys.executable, "-P", "-c", code, *arguments], check=True, capture_output=True, text=True, env=env
    ).stdout


def test_the_same_run_gives_the_same_bytes_in_another_process(tmp_path):
    code = "import sys; from grazing.paper.report import report; report(sys.argv[1], ['2.1', '3.4'], 'small')"
    report(tmp_path / "here", ["2.1", "3.4"], "small")
    in_another_process(code, str(tmp_path / "there"), PYTHONHASHSEED="1")
    here, there = (
        {name: (tmp_path / place / name).read_bytes() for name in sorted(os.listdir(tmp_path / place))}
        for place in ("here", "there")
    )
    assert here == there


def test_the_list_of_figures_is_cheap():
    loaded = in_another_process("import sys; import grazing.paper; print(*sys.modules)").split()
    assert "grazing.paper" in loaded
    assert not {"numba", "matplotlib", "scipy", "xarray"} & {name.split(".")[0] for name in loaded}


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_says_what_it_shows(name):
    module = figure_module(name)
    for text in (module.TITLE, module.CAPTION, module.SEE):
        assert len(text) > 15
    assert module.PARAMETERS


def test_phase_portraits(run):
    for name, period, V in (("1.2", 2, 0.0), ("1.5", 3, 0.4)):
        data = run.figure(name)
        (ax,) = figure_module(name).draw(data).axes
        assert data["cycle"].period == period
        assert len(data["flight"]["v_minus"]) == 1
        jump = next(line for line in ax.lines if len(line.get_xdata()) == 2 and np.ptp(line.get_ydata()) > 0.1)
        before, after = jump.get_ydata()
        assert after == pytest.approx(-0.8 * before + V, abs=1e-12)


def test_the_bifurcation_diagram_marks_its_graze(run):
    data = run.figure("1.6")
    main, close = figure_module("1.6").draw(data).axes
    for ax in (main, close):
        dashed = [line for line in ax.lines if list(line.get_xdata()) == [data["graze"]] * 2]
        assert len(dashed) == 1
    low, high = main.get_xlim()
    assert 0.05 - 0.02 * 0.11 <= low < 0.05 and 0.16 < high <= 0.16 + 0.02 * 0.11  # the outermost columns are whole
    assert data["graze"] == pytest.approx(0.130961869350, abs=1e-12)


def test_the_zero_time_map_has_four_computed_points(run):
    data = run.figure("2.1")
    (ax,) = figure_module("2.1").draw(data).axes
    dots = next(line for line in ax.lines if line.get_marker() == "o" and len(line.get_xdata()) == 4)
    assert np.array_equal(np.column_stack([dots.get_ydata(), dots.get_xdata()]), data["points"].points)
    assert ax.get_ylabel() == "position $U$"


def test_both_jumps_of_the_local_map(run):
    data = run.figure("2.2")
    assert data["graze"] == pytest.approx(0.0383355822, abs=5e-11)
    assert data["local"] == pytest.approx(0.0395865740, abs=5e-11)
    ax = figure_module("2.2").draw(data).axes[0]
    ends = sorted({float(line.get_xdata()[0]) for line in ax.lines if len(line.get_xdata()) > 2} - {0.01})
    assert ends == [data["graze"], data["local"]]


def test_diagrams_of_the_gap_map(run):
    data = run.figure("3.3")
    axes = figure_module("3.3").draw(data).axes
    assert len(axes) == 3
    for ax, each in zip(axes, data["panels"], strict=True):
        low, high = each["windows"][3]
        assert any(
            p.get_x() == low and p.get_width() == pytest.approx(min(high, ax.get_xlim()[1]) - low) for p in ax.patches
        )


def test_edges_against_the_gap(run):
    data = run.figure("3.6")
    (ax,) = figure_module("3.6").draw(data).axes
    assert len([line for line in ax.lines if len(line.get_xdata()) == 401]) == 6
    assert data["appear"][4] == pytest.approx(0.0800077500, abs=1e-12)
    assert data["appear"][5] == pytest.approx(0.1796237775, abs=1e-12)
    assert data["meet"][(3, 4)] == pytest.approx(0.62724375, abs=1e-12)


def test_a_figure_is_laid_out_once_and_drawn_once_for_each_file(tmp_path, monkeypatch):
    draws, layouts = [], []
    fig = figure(80.0, 60.0)
    fig.subplots().plot([0.0, 1.0])
    engine = type(fig.get_layout_engine())
    lay_out = engine.execute
    monkeypatch.setattr(engine, "execute", lambda self, figure: (layouts.append(1), lay_out(self, figure)))
    monkeypatch.setattr(fig, "draw", lambda renderer, draw=fig.draw: (draws.append(1), draw(renderer)))
    monkeypatch.setattr(reporting, "module_of", lambda name: SimpleNamespace(draw=lambda data: fig, TITLE="a line"))
    data = Future()
    data.set_result(None)
    assert reporting.drawn(tmp_path, "0.0", data, "quick") == ["figure-0.0.png", "figure-0.0.pdf"]
    assert (len(layouts), len(draws)) == (1, 2)


IMPORTS = """
import sys, threading
from grazing.paper import report

class Seen:
    def find_spec(self, name, path=None, target=None):
        if threading.current_thread() is threading.main_thread():
            print(name)

def pool(count, make=report.ThreadPoolExecutor):
    sys.meta_path.insert(0, Seen())
    return make(count)

report.ThreadPoolExecutor = pool
report.report(sys.argv[1], "3.1", "small", lambda *step: sys.meta_path.pop(0) if step[0] == 1 else None)
"""


def test_no_package_that_draws_is_imported_while_another_thread_imports(tmp_path):
    """An interrupt in the import of backend_pdf left the other thread waiting, and the command hung."""
    imported = in_another_process(IMPORTS, str(tmp_path))
    assert not re.findall(r"^(?:matplotlib\.backends|grazing)\b.*", imported, re.MULTILINE)
