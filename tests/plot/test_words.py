"""Words in figures: a colour for each, the same orbits as by period, free and impacting ones told apart."""

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgba

import grazing as gz
from grazing import plot
from grazing.plot.style import PERIODS
from grazing.plot.words import OTHERS, worded
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


def test_another_way_is_refused():
    with pytest.raises(gz.InputError, match="by is 'words'; allowed are 'period', 'word'"):
        plot.orbit_diagram(results.chart(), by="words")
