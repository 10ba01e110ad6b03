"""Histories and spectra as figures: what is drawn is the result, broken where it jumps."""

import numpy as np
import pytest
import xarray as xr

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
    assert [text.get_text() for text in drawn["legend"].get_texts()] == ["before an impact", "after it"]
    np.testing.assert_array_equal(before.get_ydata(), result.v_minus)
    np.testing.assert_array_equal(after.get_ydata(), result.v_plus)


def test_the_position_is_drawn_above_its_wall_with_every_impact_in_sight(flown):
    drawn = gz.plot.history(flown.isel(t=slice(1000, 3000)))
    t, u = drawn["motion"].get_data()
    np.testing.assert_array_equal(u, flown.u[1000:3000])
    (impacts,) = drawn["impacts"]
    assert [text.get_text() for text in drawn["legend"].get_texts()] == ["impact"]
    assert gz.plot.history(flown.isel(t=slice(0, 2)))["legend"] is None
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


@pytest.mark.parametrize("of", ["u", "v"])
def test_many_swings_are_drawn_finer_than_they_are_apart(of):
    m = gz.pinball(d=0.12, V=0.4)
    widths, sizes = [], []
    for periods in (10, 100, 400, 2000):
        drawn = gz.plot.history(gz.trajectory(m, (0.1, 0.0), until=periods * m.period, samples=12), of=of)
        ax = drawn["figure"].axes[0]
        apart = ax.get_window_extent().width * 72.0 / drawn["figure"].dpi / periods
        widths.append(drawn["motion"].get_linewidth())
        sizes.append(drawn["impacts"][0].get_markersize())
        if 1.0 < apart:  # a third of the orbit's periods have an impact
            assert widths[-1] <= 0.4 * apart and sizes[-1] <= 3 * apart
    assert widths[0] == 1.0 and sizes[0] == 3.2  # as ever
    assert widths == sorted(widths, reverse=True) and sizes == sorted(sizes, reverse=True)
    assert widths[-1] >= 0.25 and sizes[-1] >= 0.8  # still seen


def test_marks_of_a_coarse_sample_stand_where_walls_are_hit_and_its_flights_end_there():
    shake = gz.Forcing(omega=2.0, cos=(0.3,))
    walls = [gz.wall(x, gz.newton(0.6), motion=shake) for x in (-0.5, 0.5)]
    m = gz.Oscillator(alpha=0.1, k=1, forcing=gz.Forcing(omega=2.0, cos=(1.0,)), walls=walls)
    coarse = gz.sample(gz.trajectory(m, (0.0, 0.0), until=20.0), 2.0)
    hits, struck = coarse.impact_time.values, coarse.impact_wall.values == "B"
    expected = m.places_at(hits)[0][struck.astype(int), np.arange(len(hits))]
    (marks,) = gz.plot.history(coarse)["impacts"]
    np.testing.assert_array_equal(marks.get_ydata(), expected)
    low, high = marks.axes.get_ylim()
    assert low < expected.min() and expected.max() < high
    drawn = gz.plot.trajectory(coarse)
    assert [line.get_xdata()[0] for line in drawn["impacts"]] == expected.tolist()
    assert np.isnan(drawn["flights"].get_xdata()).sum() == len(hits) > 10


def test_a_system_of_ones_own_in_u_and_v_is_drawn_with_its_own_impacts():
    floor = gz.Surface("A", lambda t, state, p: (state[0] + 0.1 * t, state[1] + 0.1), lambda t, w, state, p: 1.0)

    def fall(t, t0, state, p):
        s = t - t0
        return state[0] + (state[1] - 0.5 * s) * s, state[1] - s

    ball = gz.System(("u",), ("v",), {"r": 0.5}, fall, [floor], ((0.1, 0.3), (-0.3, 0.3)), period=1.0)
    flown = gz.trajectory(ball, (0.2, 0.0), until=1.5)
    at, after = (flown[name].sel(coordinate=one).values for name, one in (("before", "u"), ("after", "v")))
    drawn = gz.plot.history(flown)
    assert drawn["wall"] is None and drawn["impacts"][0].get_ydata().tolist() == at.tolist() != []
    assert gz.plot.history(flown, of="v")["impacts"][1].get_ydata().tolist() == after.tolist()
    assert [line.get_ydata()[1] for line in gz.plot.trajectory(flown)["impacts"]] == after.tolist()


def made_up(amplitude, harmonics=1, lines=1000):
    """A spectrum with ten lines an order."""
    frequency = 0.7 * np.arange(lines)
    attrs = {f"parameter_{wave}{j}": 1.0 * (wave == "cos") for j in range(1, harmonics + 1) for wave in ("cos", "sin")}
    order = ("frequency", 0.1 * np.arange(lines), {"units": "1"})
    coords = {"frequency": ("frequency", frequency, {"units": "Hz"}), "order": order}
    return xr.Dataset({"amplitude": ("frequency", amplitude(0.1 * np.arange(lines)))}, coords, {**attrs, "mass": 0.8})


@pytest.mark.parametrize(
    ("amplitude", "harmonics", "last"),
    [
        (lambda n: np.where(n <= 20.0, 1.0, 9e-4), 1, 21.0),  # what is below a thousandth is not shown
        (lambda n: np.where(n == 1.0, 1.0, 1e-9), 1, 4.0),  # a sine: some orders beside it
        (lambda n: 1.0 / np.maximum(n, 0.1), 1, 40.0),  # a velocity with impacts
        (lambda n: 1.0 / np.maximum(n, 0.1), 2, 80.0),
        (lambda n: 0.0 * n, 1, 4.0),
        (lambda n: np.where(n == 0.0, 1e6, np.where(n <= 20.0, 1.0, 0.0)), 1, 21.0),  # the mean is no line
    ],
)
@pytest.mark.parametrize("over", ["frequency", "order"])
def test_a_spectrum_is_shown_as_far_as_it_has_lines(amplitude, harmonics, last, over):
    (ax,) = gz.plot.spectrum(made_up(amplitude, harmonics), over=over)["figure"].axes
    end, moves = ax.get_xlim()[1], amplitude(np.ones(1))[0] > 0.0
    assert [text.get_text() for text in ax.texts] == ([] if moves else ["all amplitudes are 0"])
    assert end == pytest.approx(last * (7.0 if over == "frequency" else 1.0), rel=1e-12)


def test_a_spectrum_is_shown_no_farther_than_it_reaches_and_as_far_as_is_said():
    found = made_up(lambda n: 1.0 + 0.0 * n, lines=100)
    assert gz.plot.spectrum(found)["figure"].axes[0].get_xlim() == (0.0, pytest.approx(69.3))
    assert gz.plot.spectrum(found, until=20.0)["figure"].axes[0].get_xlim() == (0.0, 20.0)
    for wrong in (0.0, -1.0, np.nan, "far"):
        with pytest.raises(gz.InputError, match=r"until = .*allowed is until > 0|until = 'far' is not a real number"):
            gz.plot.spectrum(found, until=wrong)


def test_units_stand_at_the_axes(recorded):
    recorded.t.attrs["units"], recorded.u.attrs["units"] = "s", "m"
    assert gz.plot.history(recorded)["figure"].axes[0].get_xlabel() == "time $t$ (s)"
    drawn = gz.plot.spectrum(gz.spectrum(recorded))["figure"].axes[0]
    assert (drawn.get_xlabel(), drawn.get_ylabel()) == ("frequency $f$ (Hz)", "amplitude of the position $u$ (m)")


def test_what_cannot_be_drawn_is_named_in_few_words():
    table = gz.table([gz.drain("out", (0, 0), (3, 0))], tilt=0.3)
    for wrong in (gz.trajectory(table, (1, 1, 0, 0)), gz.launches(table, (1, 1), 0.3, 1.0)):
        for draw in (gz.plot.history, gz.plot.trajectory):
            with pytest.raises(gz.InputError, match=rf"^plot\.{draw.__name__} finds no u: .*table; gz\.plot\.table"):
                draw(wrong)
    many = xr.Dataset({f"reading{i}": 0.0 for i in range(90)})
    with pytest.raises(gz.InputError, match=r"^plot\.history finds no u in .*reading5 and 84 more; allowed is the"):
        gz.plot.history(many)
    with pytest.raises(gz.InputError, match=r"^plot\.history cannot draw a int; .* grazing\.trajectory returns"):
        gz.plot.history(3)


def test_what_is_wrong_is_said(flown, recorded):
    with pytest.raises(gz.InputError, match="of = 'w'; allowed are u, the position"):
        gz.plot.history(flown, of="w")
    with pytest.raises(gz.InputError, match="over is 'w'; allowed are 'frequency', 'order'"):
        gz.plot.spectrum(gz.spectrum(recorded), over="w")
    with pytest.raises(gz.InputError, match=r"plot\.spectrum finds no amplitude"):
        gz.plot.spectrum(flown)
