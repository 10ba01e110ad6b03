"""Branches with and without special points, and loci on a chart."""

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import InputError, plot
from grazing.cli import main
from grazing.plot.branch import drawn
from tests.plot import results


@pytest.fixture(scope="module")
def plain():
    """A branch on which nothing happens."""
    orbit = gz.periodic_orbits(gz.gap_map(lam=0.5, mu=0.1, l=0.2), period=2)[0]
    branch = gz.continuation(orbit.map, orbit, "mu", (0.099, 0.101))
    assert not branch.special
    return branch


@pytest.fixture(scope="module")
def locus():
    orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    special = next(s for s in gz.continuation(orbit.map, orbit, "d", (0.09, 0.13)).special if s.type == "pd")
    return gz.locus(special, ("d", "V"), ((0.08, 0.14), (0.35, 0.45)))


def test_a_branch_without_special_points_is_lines_alone(plain):
    for result in (plain, plain.dataset, [plain, plain]):
        drawn = plot.branch(result)
        assert drawn["lines"] and not drawn["markers"] and not drawn["names"]


def test_a_coordinate_that_is_no_name_is_refused(plain):
    for wrong in ("z", 3, np.zeros(4), np.array(["x"])):
        with pytest.raises(gz.InputError, match="allowed are x"):
            gz.plot.branch(plain, coordinate=wrong)


def test_grazes_carry_the_name_of_their_wall():
    walls = gz.wall(-0.4, gz.newton(0.7)), gz.wall(0.3, gz.newton(0.6))
    P = gz.stroboscopic_map(gz.Oscillator(0.2, 1.1, gz.Forcing(omega=1.7, cos=(1.0,)), walls=walls))
    branch = gz.continuation(P, gz.periodic_orbits(P, period=1, starts=10)[0], "B.sigma", (0.1, 0.9))
    grazes = {f"gr {one.wall}" for one in branch.special if one.type == "gr"}
    names = {text.get_text() for text in plot.branch(branch, virtual=True)["names"]}
    assert grazes and grazes == {name for name in names if name.startswith("gr")} and "pd " not in names


def test_the_command_draws_a_branch_without_special_points(tmp_path, capsys):
    tokens = ["branch", "mu=0.099:0.101", "--map", "gap", "--lam", "0.5", "--l", "0.2", "--word", "LR", "-q"]
    files = [tmp_path / name for name in ("a.png", "a.nc")]
    assert main([*tokens, *(part for file in files for part in ("-o", str(file)))]) == 0, capsys.readouterr().err
    assert all(file.stat().st_size for file in files)
    assert main(["plot", str(files[1]), "-o", str(tmp_path / "b.pdf")]) == 0, capsys.readouterr().err


def on_chart():
    return results.chart(x=np.linspace(0.08, 0.14, 9), y=np.linspace(0.35, 0.45, 7)).rename(mu="d", l="V")


def test_loci_are_curves_of_a_chart(locus):
    name = f"{locus.orbits[0].word} pd"
    for curves in (locus, locus.dataset, [locus], (locus, locus.dataset)):
        drawn = plot.chart(on_chart(), curves=curves)["curves"]
        assert list(drawn) == [name]
        line = drawn[name][0]
        there = np.array([orbit.admissible for orbit in locus.orbits])
        x, y = (np.asarray(side)[: len(there)] for side in (line.get_xdata(), line.get_ydata()))
        assert there.any()
        np.testing.assert_array_equal(x[there], locus.values[there, 0])
        np.testing.assert_array_equal(y[there], locus.values[there, 1])
        assert np.isnan(x[~there]).all()


@pytest.mark.parametrize("curves", [5, "pd", [1.0, 2.0], np.zeros((2, 3)), [None], {"a": 1.0}, {"a": "bc"}, [[]]])
def test_what_is_no_curve_is_refused_with_what_is_one(curves):
    with pytest.raises(InputError, match=r"gz\.boundaries.*gz\.locus.*mapping of names|not a pair"):
        plot.chart(results.chart(), curves=curves)


def test_a_locus_in_other_parameters_is_refused(locus):
    with pytest.raises(InputError, match=r"but no mu; give .*gz\.locus in mu and l"):
        plot.chart(results.chart(), curves=locus)


def test_a_line_goes_on_where_an_impact_crosses_the_strobe_but_not_where_the_coordinate_jumps():
    """The word changes there, nothing else: a gap of a whole step looked like values without the orbit."""
    p = np.linspace(0.0, 1.0, 9)
    later, one = p > 0.5, np.ones(9, int)
    columns = {"stable": one, "admissible": one, "event": 0 * one, "piece": 0 * one, "period": one}
    columns |= {"word": np.where(later, "(BA)", "(AB)"), "p": p}
    table = xr.Dataset({name: ("point", values) for name, values in columns.items()})
    table["u"] = ("point", "one"), (np.where(later, 0.3 * p + 0.15, 0.6 * p))[:, None]
    table["v"] = ("point", "one"), (np.where(later, 2.0, -1.0) + 0.1 * p)[:, None]
    _figure, (ax,) = plot.panels()
    ends = {}
    for name in ("u", "v"):
        for shades in (None, {"(AB)": "red", "(BA)": "blue"}):
            lines = drawn(table, ax, "p", name, True, shades)
            ends[name, shades is None] = [(line.get_xdata()[0], line.get_xdata()[-1]) for line in lines]
    assert ends["u", True] == [(0.0, 1.0)]
    assert ends["u", False] == [(0.0, 0.625), (0.625, 1.0)]  # each word in its colour
    assert ends["v", True] == ends["v", False] == [(0.0, 0.5), (0.625, 1.0)]


def test_a_line_has_gaps_where_two_impacts_cross_the_strobe_in_steps_beside_each_other():
    """Two leaps of a size, each was the measure of the other: a line was drawn through values that no orbit has."""
    at = np.arange(8.0)
    word = np.array(["(AB)"] * 3 + ["(BA)"] + ["(AA)"] * 4)
    one = np.ones(8, int)
    columns = {"stable": one, "admissible": one, "event": 0 * one, "piece": 0 * one, "period": one, "word": word}
    table = xr.Dataset({name: ("point", values) for name, values in (columns | {"p": at}).items()})
    table["v"] = ("point", "one"), (0.1 * at + (at > 2.0) + (at > 3.0))[:, None]
    _figure, (ax,) = plot.panels()
    lines = drawn(table, ax, "p", "v", True)
    assert [(line.get_xdata()[0], line.get_xdata()[-1]) for line in lines] == [(0.0, 2.0), (4.0, 7.0)]
