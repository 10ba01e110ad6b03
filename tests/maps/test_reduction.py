"""The kernels of the normal form: the lowest point of the steady response, and the search for a graze."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.maps.normal_form import constants
from grazing.maps.reduction import graze_search_of, has_steady_response, mu_factor, reduction_of, steady_low
from grazing.oscillator.constants import steady_response
from tests.models import MODELS


@pytest.mark.parametrize("name", MODELS)
def test_the_lowest_point_is_the_lowest(name):
    c = constants(MODELS[name])
    if not has_steady_response(c):
        pytest.skip("no steady response attracts")
    time, height = steady_low(c)
    heights = [steady_response(t, c)[0] for t in np.linspace(0.0, c.T, 2001)]
    assert 0.0 <= time < c.T
    assert height == steady_response(time, c)[0]
    assert height <= min(heights) + 1e-12 * c.size
    assert height >= min(heights) - 1e-5 * c.size


@pytest.mark.parametrize(
    ("root", "now", "low", "high"),
    [(0.3, 0.0, -9.0, 9.0), (-7.25, 1.0, -9.0, 9.0), (1e-5, 2.0, 0.0, 2.0), (4.0, 4.0, 0.0, 9.0)],
)
@pytest.mark.parametrize("slope", [1.0, -3.0])
def test_a_graze_is_found_to_the_last_digit(root, now, low, high, slope):
    search = graze_search_of(lambda value, context: slope * (value - context))
    found = search(root, now, low, high, False, 1.0)
    assert found in (root, math.nextafter(root, -9.0), math.nextafter(root, 9.0))


def test_the_nearest_graze_is_found():
    search = graze_search_of(lambda value, context: (value - 1.0) * (value + 0.4))
    assert search(None, 0.1, -9.0, 9.0, False, 1.0) == pytest.approx(-0.4, abs=1e-15)
    assert search(None, 0.5, -9.0, 9.0, False, 1.0) == pytest.approx(1.0, abs=1e-15)


def test_where_there_is_no_height_the_search_goes_on():
    search = graze_search_of(lambda value, context: math.nan if value < 0.5 and value != 0.1 else value - 0.8)
    assert search(None, 0.1, -9.0, 9.0, False, 1.0) == pytest.approx(0.8, abs=1e-15)


def test_an_excluded_end_is_not_asked():
    asked = []

    def height(value, context):
        asked.append(value)
        return 1.0

    assert math.isnan(graze_search_of(height)(None, 1.0, 0.0, 2.0, True, 1.0))
    assert 0.0 not in asked and 2.0 in asked
    graze_search_of(height)(None, 1.0, 0.0, 2.0, False, 1.0)
    assert 0.0 in asked


def test_numbers_at_a_graze_are_those_of_the_normal_form():
    model = gz.pinball(alpha=1.5, omega=2.6, V=0.3, sigma=0.1, d=0.2)
    nf = gz.normal_form(model, "d")
    law = nf.model.reset
    found = reduction_of(law.law, law.slope)(constants(nf.model))
    assert (found.lam, found.l, found.b, found.det, found.r, found.V) == (nf.lam, nf.l, nf.b, nf.det, nf.r, nf.V)
    factor = mu_factor(found.lam, found.det, found.acceleration, found.b, found.r)
    assert nf.mu(nf.graze + 1e-3) == factor * steady_low(constants(nf.model.replace(d=nf.graze + 1e-3)))[1]
