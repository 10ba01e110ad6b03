"""Figures of grazes: curves where the result has them, alone or on the picture of exits."""

import numpy as np
import pytest

import grazing as gz
from tests.maps.test_grazes import TABLE, WIDE

POINT = 3.0, 2.0


@pytest.fixture(scope="module")
def found():
    return gz.grazes(TABLE, POINT, **WIDE, order=0, cells=(16, 8))


def test_lines_are_the_curves_and_say_which_kick(found):
    drawn = gz.plot.grazes(found)
    kicked = found.kick.values[found["row"].values] > 0.0
    assert list(drawn["lines"]) == ["graze with a kick"] or set(drawn["lines"]) == {"graze", "graze with a kick"}
    x, y = drawn["lines"]["graze with a kick"].get_data()
    np.testing.assert_array_equal(x[kicked], found.angle.values[kicked])
    np.testing.assert_array_equal(y[kicked], found.speed.values[kicked])
    assert np.isnan(x[~kicked]).all()
    [ax] = drawn["figure"].axes
    assert ax.get_xlim() == WIDE["angle"] and ax.get_ylim() == WIDE["speed"]
    assert [text.get_text() for text in drawn["legend"].get_texts()] == list(drawn["lines"])


def test_on_the_picture_of_exits_limits_and_legend_stay(found):
    exits = gz.launches(TABLE, POINT, np.linspace(*WIDE["angle"], 9), np.linspace(*WIDE["speed"], 7))
    below = gz.plot.launches(exits)
    [ax] = below["figure"].axes
    limits, said = (ax.get_xlim(), ax.get_ylim()), [text.get_text() for text in below["legend"].get_texts()]
    drawn = gz.plot.grazes(found, ax)
    assert (ax.get_xlim(), ax.get_ylim()) == limits
    assert [text.get_text() for text in drawn["legend"].get_texts()] == said + list(drawn["lines"])


def test_another_result_is_refused(found):
    with pytest.raises(gz.InputError, match=r"plot.grazes finds no kick"):
        gz.plot.grazes(found.drop_vars("kick"))
