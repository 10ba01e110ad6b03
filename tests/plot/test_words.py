"""Words in figures: a colour for each, the same orbits as by period, free and impacting ones told apart."""

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgba

import grazing as gz
from grazing import plot
from grazing.compare.word_branches import branches as tables_of
from grazing.compare.word_branches import loci_of
from grazing.plot.style import PERIODS
from grazing.plot.words import OTHERS, with_words, worded, words_in
from tests.plot import results


def test_words_are_sorted_and_orbits_without_period_keep_their_code():
    period = np.array([[1, 1, 2], [-1, 0, -3]])
    word = np.array([["1", "0", "01"], ["", "", ""]], object)
    found = worded(period, word, np.ones(period.shape))
    assert found.words == ["0", "1", "01"]
    assert found.codes.tolist() == [[2, 1, 3], [-1, 0, -3]]
    assert [found.colours[code] for code in (1, 2, 3)] == list(PERIODS[:3])
    said = [entry.get_label() for entry in found.entries]
    assert said == ["0", "1", "01", "aperiodic", "undecided"]


def test_the_most_common_words_have_a_colour_of_their_own():
    words = np.array([f"({n})" for n in range(10, 13 + len(PERIODS))], object)
    weight = np.arange(1.0, len(words) + 1.0)
    found = worded(np.ones(len(words), int), words, weight)
    assert len(found.words) == len(set(found.colours[i + 1] for i in range(len(PERIODS)))) == len(PERIODS)
    rare = len(PERIODS) + 1
    assert found.codes.tolist()[:3] == [rare] * 3 and rare not in found.codes.tolist()[3:]
    assert found.colours[rare] == OTHERS and found.entries[-1].get_label() == "other words"


@pytest.mark.parametrize("stripes", [True, False])
def test_a_chart_by_word_has_the_colour_of_each_cell(stripes):
    result = results.chart(9, 7, ranks=1)
    drawn = plot.chart(result, by="word", stripes=stripes)
    shown = worded(result.period.values, result.word.values, result.share.values)
    image = np.asarray(drawn["image"].get_array())
    expected = np.vectorize(lambda code: shown.colours[code])(shown.codes[..., 0])
    seen = {to_hex(pixel / 255) for pixel in image.reshape(-1, image.shape[-1])[:, :3]}
    assert {to_hex(to_rgba(colour)) for colour in expected.ravel()} == seen
    assert drawn["legend"].get_title().get_text() == "word"


def test_free_and_impacting_orbits_of_period_one_are_told_apart():
    law, forcing = gz.newton(0.7), gz.Forcing(omega=88.0, cos=(-2.5 / 0.8,))
    rig = gz.Oscillator(alpha=3.0, k=np.sqrt(4000.0), forcing=forcing, sigma=-1.2e-3, reset=law)
    P, at = gz.stroboscopic_map(rig), np.array([85.0, 90.0, 95.0])
    result = gz.orbit_diagram(P, "omega", at, starts=12)
    by_period, by_word = plot.orbit_diagram(result), plot.orbit_diagram(result, by="word")
    assert list(by_period["points"]) == [1] and list(by_word["points"]) == ["0", "1"]
    free, hits = (by_word["points"][word].get_color() for word in ("0", "1"))
    assert free != hits
    points = np.concatenate([line.get_xydata() for line in by_word["points"].values()])
    assert {tuple(xy) for xy in points} == {tuple(xy) for xy in by_period["points"][1].get_xydata()}


@pytest.fixture(scope="module")
def rig():
    law = gz.newton(0.7)
    return gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, force=2.5, gap=1.2e-3, omega=90.0, reset=law)


@pytest.fixture(scope="module")
def branches(rig):
    """The stable orbits of period 1, without and with an impact, and the locus of the fold of the latter."""
    P = gz.stroboscopic_map(rig)
    return [gz.continuation(P, orbit, "omega", (80.0, 106.0)) for orbit in gz.periodic_orbits(P, 1)[:2]]


def listed(drawn):
    """The colours in a legend by what it says."""
    legend = drawn["figure"].axes[0].get_legend()
    handles = zip(legend.get_texts(), legend.legend_handles, strict=True)
    return {text.get_text(): to_hex(handle.get_facecolor()) for text, handle in handles if hasattr(handle, "get_hatch")}


def test_a_word_has_one_colour_in_a_chart_with_its_branch_and_locus(rig, branches):
    P = gz.stroboscopic_map(rig)
    axes = {"omega": np.linspace(85.0, 105.0, 4), "sigma": np.linspace(-1.3e-3, -1.1e-3, 3)}
    result = gz.chart(P, axes, starts=4, keep=8, transient=60)
    (fold,) = (one for one in branches[1].special if one.type == "lp")
    locus = gz.locus(fold, ("omega", "sigma"), ((80.0, 106.0), (-1.3e-3, -1.1e-3)))
    drawn = plot.chart(result, by="word", curves=[*branches, locus])
    legend = listed(drawn)
    lines = {name: line.get_color() for name, (line, _text) in drawn["curves"].items()}
    assert lines == {"0": legend["0"], "1": legend["1"], "1 lp": legend["1"]} and legend["0"] != legend["1"]
    image = np.asarray(drawn["image"].get_array())
    seen = {to_hex(pixel / 255) for pixel in np.unique(image.reshape(-1, image.shape[-1])[:, :3], axis=0)}
    assert {legend["0"], legend["1"]} <= seen
    black = plot.chart(result, curves=[*branches, locus])["curves"]
    assert {line.get_color() for line, _text in black.values()} == {"#1a1a1a"}


def test_a_table_of_branches_brings_its_loci(rig):
    span = (-1.3e-3, -1.1e-3)
    table = tables_of(gz.stroboscopic_map(rig), "omega", (86.0, 106.0), word="1", at=[95.0], locus={"sigma": span})
    axes = {"omega": np.linspace(88.0, 105.0, 4), "sigma": np.linspace(*span, 3)}
    result = gz.chart(gz.stroboscopic_map(rig), axes, starts=1, keep=8, transient=20)
    lines = {name: line for name, (line, _text) in plot.chart(result, by="word", curves=table)["curves"].items()}
    assert {"1", "1 lp"} <= lines.keys() and lines["1"].get_color() == lines["1 lp"].get_color()
    (fold,) = (one for one in loci_of(table) if one.attrs["type"] == "lp")
    assert {*fold.sigma.values} <= {*lines["1 lp"].get_ydata()}
    assert plot.locus(loci_of(table))["figure"].axes[0].get_ylabel() == r"$\sigma=-\mathrm{gap}$ (m)"


def test_a_word_of_curves_alone_has_a_colour_and_an_entry():
    result = results.chart(9, 7, ranks=1)
    period, word = result.period.values, result.word.values
    found = worded(period, word, result.share.values, {}, ["02"])
    assert "02" not in found.words and "02" in [entry.get_label() for entry in found.entries]
    colours = [to_hex(entry.get_facecolor()) for entry in found.entries[: len(found.words) + 1]]
    assert len(set(colours)) == len(colours)


def test_curves_have_their_colours_where_words_are_many():
    words = np.array([f"({n})" for n in range(10, 13 + len(PERIODS))], object)
    known = {}
    found = worded(np.ones(len(words), int), words, np.arange(1.0, len(words) + 1.0), known, ["(10)", "0"])
    assert {"(10)", "0"} <= known.keys() and len(known) == len(PERIODS)
    assert found.colours[found.codes[0]] == known["(10)"] and found.colours[found.codes[1]] == OTHERS
    assert with_words(known, ["1"]) == known and "1" not in known  # no colour is left


def test_branches_over_a_diagram_have_the_colours_of_its_points(rig, branches):
    result = gz.orbit_diagram(gz.stroboscopic_map(rig), "omega", [85.0, 95.0, 106.0], starts=6)
    drawn = plot.orbit_diagram(result, by="word")
    lines = plot.branch(branches, drawn["figure"].axes[0])["lines"]
    legend = listed(drawn)
    assert {word: line.get_color() for word, line in drawn["points"].items() if word} == legend
    assert {line.get_color() for line in lines} == {*legend.values()}
    texts = [text.get_text() for text in drawn["figure"].axes[0].get_legend().get_texts()]
    assert texts[:2] == ["0", "1"] and "unstable" in texts
    plain = plot.branch(branches)  # in a figure of its own
    assert {line.get_color() for line in plain["lines"]} == {"#1a1a1a"} and not words_in(plain["figure"])


def test_branches_by_word_and_their_special_points(branches):
    drawn = plot.branch(branches, by="word", virtual=False)
    legend = listed(drawn)
    by_type = {artist.get_marker(): artist.get_markeredgecolor() for artist in drawn["markers"]}
    assert by_type["o"] == legend["1"] and list(legend) == ["0", "1"]
    with pytest.raises(gz.InputError, match="by is 'w'; allowed are 'period', 'word'"):
        plot.branch(branches, by="w")


def test_a_bifurcation_diagram_by_word(rig):
    result = gz.bifurcation_diagram(gz.stroboscopic_map(rig), "omega", np.linspace(80.0, 106.0, 5), starts=3)
    drawn = plot.bifurcation_diagram(result, by="word")
    legend = {what: colour for what, colour in listed(drawn).items() if what != "shaded: stable"}
    assert {word: line.get_color() for word, line in drawn["points"].items()} == legend
    assert {line.get_color() for line in drawn["lines"]} == {*legend.values()} and len(legend) == 2
    assert {to_hex(band.get_facecolor()) for band in drawn["windows"]} <= {*legend.values()}


def test_another_way_is_refused():
    with pytest.raises(gz.InputError, match="by is 'words'; allowed are 'period', 'word'"):
        plot.orbit_diagram(results.chart(), by="words")
