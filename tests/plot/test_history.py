"""Histories and spectra as figures: what is drawn is the result, broken where it jumps."""

import numpy as np
import pytest

import grazing as gz


@pytest.fixture(scope="module")
def flown():
    m = gz.pinball(d=0.12, V=0.4)
    return gz.trajectory(m, (0.1, 0.0), until=20 * m.period)


@pytest.fixture
def recorded(flown):
    return gz.sample(flown, 50.0)


@pytest.mark.parametrize("which", ["flown", "recorded"])
def test_the_velocity_is_broken_at_every_impact_and_nowhere_else(which, request):
    result = request.getfixturevalue(which)
    drawn = gz.plot.history(result, of="v")
    t, v = drawn["motion"].get_data()
    gaps = np.flatnonzero(np.isnan(v))
    assert len(gaps) == result.sizes["impact"] > 3
    assert np.abs(np.diff(v)[~np.isnan(np.diff(v))]).max() < 0.1 < np.abs(np.diff(result.v)).max()
    assert (t[gaps - 1] <= result.impact_time).all() and (t[gaps + 1] >= result.impact_time).all()
    np.testing.assert_array_equal(np.delete(v, gaps), result.v)
    before, after = drawn["impacts"]
    np.testing.assert_array_equal(before.get_ydata(), result.v_minus)
    np.testing.assert_array_equal(after.get_ydata(), result.v_plus)


def test_the_position_is_drawn_above_its_wall_with_every_impact_in_sight(flown):
    drawn = gz.plot.history(flown.isel(t=slice(1000, 3000)))
    t, u = drawn["motion"].get_data()
    np.testing.assert_array_equal(u, flown.u[1000:3000])
    (impacts,) = drawn["impacts"]
    hits = flown.impact_time.values
    np.testing.assert_array_equal(impacts.get_xdata(), hits[(hits >= t[0]) & (hits <= t[-1])])
    assert drawn["figure"].axes[0].get_ylabel() == "position $u$"
    assert drawn["wall"] is not None


@pytest.mark.parametrize("over", ["frequency", "order"])
def test_a_spectrum_is_drawn_over_frequencies_or_orders(recorded, over):
    found = gz.spectrum(recorded)
    x, y = gz.plot.spectrum(found, over=over)["lines"].get_data()
    np.testing.assert_array_equal(x, found[over][1:])
    assert y.max() == found.amplitude[1:].max()


def test_units_stand_at_the_axes(recorded):
    recorded.t.attrs["units"], recorded.u.attrs["units"] = "s", "m"
    assert gz.plot.history(recorded)["figure"].axes[0].get_xlabel() == "time $t$ (s)"
    drawn = gz.plot.spectrum(gz.spectrum(recorded))["figure"].axes[0]
    assert (drawn.get_xlabel(), drawn.get_ylabel()) == ("frequency $f$ (Hz)", "amplitude of the position $u$ (m)")


def test_what_is_wrong_is_said(flown, recorded):
    with pytest.raises(gz.InputError, match="of = 'w'; allowed are u, the position"):
        gz.plot.history(flown, of="w")
    with pytest.raises(gz.InputError, match="over = 'w'; allowed are frequency and order"):
        gz.plot.spectrum(gz.spectrum(recorded), over="w")
    with pytest.raises(gz.InputError, match=r"plot\.spectrum finds no amplitude"):
        gz.plot.spectrum(flown)
