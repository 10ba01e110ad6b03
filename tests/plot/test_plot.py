"""Figures hold the data they were given; nothing global changes; files are the same each time."""

import warnings

import matplotlib
import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import plot
from grazing.maps.discontinuity import zdm_points
from grazing.maps.gap import gap_map
from grazing.maps.impact import impact_map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.model import pinball
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import InputError
from grazing.plot.style import CHAOS, ENDED, INK, PERIODS, UNDECIDED, ink_on
from grazing.plot.words import OTHERS
from grazing.studies.cobweb import cobweb as followed
from grazing.studies.graph import graph as step_of


def diagram():
    x = np.array([[[0.1, 0.2, 0.1, 0.2], [0.5, 0.7, 0.6, 0.9]], [[0.3, 0.3, 0.3, 0.3], [0.3, 0.3, 0.3, 0.3]]])
    data = {"x": (("mu", "start", "n"), x), "period": (("mu", "start"), np.array([[2, -1], [1, 1]]))}
    result = xr.Dataset(data, coords={"mu": [0.0, 1.0]})
    result["mu"].attrs["symbol"] = r"\mu"
    return result


def test_a_trajectory_breaks_at_impacts():
    result = trajectory(pinball(d=0.12), (0.1, 0.0), until=20.0)
    drawn = plot.trajectory(result, strobe=[(0.1, 0.0)])
    assert len(drawn["impacts"]) == result.sizes["impact"] == 3
    assert np.isnan(drawn["flights"].get_xdata()).sum() == 3
    line = drawn["impacts"][0]
    assert list(line.get_ydata()) == [result["v_minus"].values[0], result["v_plus"].values[0]]
    assert drawn["strobe"].get_xdata().tolist() == [0.1]
    part = result.isel(t=result.t.values > result.impact_time.values[1])
    assert len(plot.trajectory(part)["impacts"]) == 1  # those before it are not in sight


@pytest.mark.parametrize("unit", [2.0**-100, 1.0, 2.0**100])
def test_a_motion_fills_its_axes_in_any_unit(unit):
    """Positions had an axis of at least 1e-13, in whatever unit, on which smaller motions were a line."""
    model = gz.Oscillator(3.0, 1.0, gz.Forcing(2.2, offset=0.12 * unit, cos=(unit,)), gz.active(0.8, 0.4 * unit))
    flown = gz.trajectory(model, (0.1 * unit, 0.0), until=10.0)
    (low, high), (floor, roof) = (
        plot.trajectory(flown)["figure"].axes[0].get_xlim(),
        plot.history(flown)["figure"].axes[0].get_ylim(),
    )
    assert (low, high) == (floor, roof) and flown.u.values.max() > 0.8 * (high - low)
    still = gz.trajectory(gz.Oscillator(0.1, 1.0, gz.Forcing(2.0, offset=-1.0), gz.newton(0.5)), (0.0, 0.0), until=5.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of limits that are equal
        plot.trajectory(still)


@pytest.mark.parametrize("side", ["below", "above"])
def test_states_at_the_strobe_are_where_the_motion_is_in_any_unit(side):
    """States in metres were drawn as if they were the millimetres of the trajectory."""
    rig = gz.Oscillator.from_si(
        m=0.8, c=2.4, k=3200, force=2.5, gap=1.2e-3, side=side, frequency=14, reset=gz.newton(0.7)
    )
    flown = gz.trajectory(rig, (0.0, 0.1), until=0.02)
    drawn = plot.trajectory(gz.in_units(flown, "mm", "mm/s"), strobe=[(0.0, 0.1), (1e-3, 0.2)])
    sign = -1.0 if side == "above" else 1.0
    assert drawn["strobe"].get_xdata() == pytest.approx([0.0, sign])
    assert drawn["strobe"].get_ydata() == pytest.approx([sign * 100.0, sign * 200.0])


def test_a_graph_jumps_where_the_letter_changes():
    graph = plot.graph_of(gap_map(0.8, 0.5, 1.0), np.linspace(-1.0, 1.0, 101))
    pieces = plot.map_graph(graph, label="map")["pieces"]
    assert len(pieces) == 2
    assert pieces[0].get_xdata()[-1] < 0.0 <= pieces[1].get_xdata()[0]
    assert pieces[0].get_ydata().tolist() == pytest.approx((0.8 * pieces[0].get_xdata() + 0.5).tolist())


def test_a_graph_of_a_plane_map_fixes_the_other_coordinate():
    P = stroboscopic_map(pinball())
    graph = plot.graph_of(P, [0.05, 0.1], "u", v=-0.1)
    assert np.allclose(graph.images[1], P((0.1, -0.1))[0])
    assert plot.map_graph(graph, coordinate="v")["pieces"][0].get_ydata()[-1] == graph.images[-1, 1]


def stepped(**more):
    P = stroboscopic_map(pinball(omega=2.1, t0=2.2, d=0.11, V=0.2))
    return step_of(P, "u", np.linspace(0.01, 0.06, 101), fixed={"v": -0.23}, **more)


@pytest.mark.parametrize("coordinate", [None, "u", "v"])
def test_the_graphs_of_two_maps_as_in_figure_2_2(coordinate):
    result = stepped(order="full")
    drawn = plot.graph(result, coordinate=coordinate)
    assert list(drawn["graphs"]) == ["stroboscopic map", "discontinuity map, full order"]
    for k, (pieces, colour) in enumerate(zip(drawn["graphs"].values(), (INK, PERIODS[1]), strict=True)):
        assert [line.get_color() for line in pieces] == [colour] * 2  # before and after the jump
        assert pieces[0].is_dashed() == (k == 1)
        assert np.array_equal(np.concatenate([line.get_xdata() for line in pieces]), result["u"])
        y = np.concatenate([line.get_ydata() for line in pieces])
        assert np.array_equal(y, result[f"image_{coordinate or 'u'}"][k])
        assert pieces[0].get_xdata().size == int((result["letter"][k] == 1).sum())
    assert [text.get_text() for text in drawn["legend"].get_texts()] == list(drawn["graphs"])
    (ax,) = drawn["figure"].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$u_{n}$", f"${coordinate or 'u'}_{{n+1}}$")
    assert drawn["provenance"]["grazing_config"]["order"] == "full"
    assert plot.graph(result, legend=False)["legend"] is None


def test_a_graph_alone_has_no_legend_and_shows_a_piece_of_one_point():
    drawn = plot.graph(step_of(gap_map(0.8, 0.5, 1.0), "x", [0.25, -1.0, -0.5]))
    (pieces,) = drawn["graphs"].values()
    assert drawn["legend"] is None
    assert [line.get_xdata().tolist() for line in pieces] == [[-1.0, -0.5], [0.25]]  # in order along the axis
    assert [line.get_marker() for line in pieces] == ["None", "o"]


def halved(state, p):
    return (p.a * state[0],)


def test_a_coordinate_with_an_index_is_set_as_mathematics(tmp_path):
    drawn = plot.graph(step_of(impact_map(pinball()), "v_plus", [0.4, 0.5]), coordinate="tau")
    (ax,) = drawn["figure"].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$v^+_{n}$", r"$\tau_{n+1}$")
    plot.save(drawn, tmp_path / "a.png")  # which sets them
    own = gz.Map(halved, params={"a": 0.5}, coordinates=("x_in",), box=((0.0, 1.0),))
    (ax,) = plot.graph(step_of(own, "x_in", [0.4, 0.5]))["figure"].axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$x_{\mathrm{in},n}$", r"$x_{\mathrm{in},n+1}$")


def test_what_is_no_graph():
    with pytest.raises(InputError, match="coordinate is 'w'; allowed are 'u', 'v'"):
        plot.graph(stepped(), coordinate="w")
    with pytest.raises(InputError, match=r"plot\.graph cannot draw a Map"):
        plot.graph(gap_map(0.8, 0.5, 1.0))
    with pytest.raises(InputError, match=r"plot\.graph finds no letter in a result with x, period"):
        plot.graph(diagram())


def test_a_cobweb_closes():
    points = [-1.0060750571225354, -0.3048600456980284, 0.2561119634415773]
    drawn = plot.cobweb(gap_map(0.8, 0.5, 1.0), points)
    path = np.column_stack([drawn["steps"].get_xdata(), drawn["steps"].get_ydata()])
    assert np.array_equal(path[0], [points[0], points[0]])
    assert path[-1, 1] == points[0]
    assert drawn["points"].get_xdata().tolist() == points


def test_a_cobweb_of_a_result_is_that_of_its_points():
    P = gap_map(0.8, 0.5, 1.0)
    result = followed(P, [-1.0], steps=30, transient=10)
    one = plot.cobweb(result)
    other = plot.cobweb(P, result.x.values, closed=False)
    for name in ("steps", "points"):
        assert np.array_equal(one[name].get_xydata(), other[name].get_xydata())
    for piece, twin in zip(one["graph"], other["graph"], strict=True):
        assert np.array_equal(piece.get_xydata(), twin.get_xydata())
    assert one["provenance"]["grazing_config"]["study"] == "cobweb"
    assert plot.cobweb(result, closed=True)["steps"].get_xdata()[-1] == result.x.values[0]
    with pytest.raises(InputError, match="points and a result are both given"):
        plot.cobweb(result, [0.1])
    with pytest.raises(InputError, match="needs points; give an orbit"):
        plot.cobweb(P)
    with pytest.raises(InputError, match=r"plot\.cobweb cannot draw a list"):
        plot.cobweb([0.1, 0.2])


def test_a_cobweb_needs_one_coordinate():
    with pytest.raises(InputError, match="stroboscopic map has coordinates u, v; a cobweb needs a map with one"):
        plot.cobweb(stroboscopic_map(pinball()), [(0.1, 0.0)])


def test_an_orbit_diagram_has_one_colour_for_each_period():
    points = plot.orbit_diagram(diagram())["points"]
    assert set(points) == {0, 1, 2}
    assert points[2].get_color() == PERIODS[1]
    assert points[0].get_color() == CHAOS
    assert sorted(points[2].get_ydata().tolist()) == [0.1, 0.2]  # repeated points are drawn once
    assert points[1].get_xdata().tolist() == [1.0]
    assert sorted(points[0].get_ydata().tolist()) == [0.5, 0.6, 0.7, 0.9]
    assert all(line.get_rasterized() for line in points.values())
    assert points[1].axes.get_xlabel() == r"$\mu$"


def test_ranges_in_which_every_orbit_ended_are_shaded_and_the_legend_says_why():
    ended = gz.Outcome.too_many_impacts | gz.Outcome.diverged
    values, period = [4.0, 0.0, 1.0, 2.0, 3.0], np.array([[-2, -2], [1, 1], [-2, -2], [-2, -2], [-2, 1]], np.int32)
    table = {"x": (("mu", "start", "n"), np.where(period == 1, 0.5, np.nan)[..., None])}
    table |= {"period": (("mu", "start"), period), "outcome": (("mu", "start"), np.where(period == -2, int(ended), 0))}
    made = xr.Dataset(table, {"mu": values}, diagram().attrs)
    drawn = plot.orbit_diagram(made)
    spans = [(band.get_x(), band.get_x() + band.get_width()) for band in drawn["ended"]]
    assert spans == [(0.5, 2.5), (3.5, 4.5)]  # at 3 an orbit goes on
    texts = [text.get_text() for text in drawn["legend"].get_texts()]
    assert texts == ["1", "ended: chatter,\ntoo many impacts"]
    made["outcome"][2:4] = int(gz.Outcome.no_impact)
    texts = [text.get_text() for text in plot.orbit_diagram(made)["legend"].get_texts()]
    assert texts[1:] == ["ended: chatter,\ntoo many impacts; no further impact"]
    assert plot.orbit_diagram(made.drop_vars("outcome"))["legend"].get_texts()[1].get_text() == "ended"


def test_windows_are_named_shaded_and_kept_apart():
    _fig, (ax,) = plot.panels()
    drawn = plot.windows({1: (0.5, 1.0), 2: (0.3, 0.6), 3: (0.4, 0.2), 4: (2.0, 3.0)}, ax)
    assert set(drawn["bars"]) == set(drawn["bands"]) == {1, 2}
    assert drawn["names"][2].get_text() == r"$\Omega_{2}$"
    assert drawn["bars"][1].get_y() > drawn["bars"][2].get_y()
    assert drawn["bars"][2].get_width() == pytest.approx(0.3)


def test_a_clipped_window_keeps_its_inner_edge():
    _fig, (ax,) = plot.panels()
    bar = plot.windows({1: (0.5, 9.0)}, ax, shade=0.0, names=False)["bars"][1]
    assert (bar.get_x(), bar.get_width()) == (0.5, 0.5)


def test_windows_of_a_dataset():
    columns = {"N": [2, 1, 1], "low": [0.3, 0.5, 0.05], "high": [0.6, 1.0, 0.1]}
    table = xr.Dataset({name: ("window", values) for name, values in columns.items()})
    _fig, (ax,) = plot.panels()
    drawn = plot.windows(table, ax)
    assert set(drawn["bars"]) == {1, 2}
    assert drawn["bars"][1].get_x() == 0.5
    assert len(ax.patches) == 6  # both windows of period 1


def test_windows_of_one_period_that_overlap_lie_above_each_other():
    """As those of several words between walls do: their bars ran into one, and no edge of them was seen."""
    columns = {"N": [1, 1, 1, 2], "low": [0.1, 0.4, 0.7, 0.1], "high": [0.6, 0.7, 0.9, 0.9]}
    table = xr.Dataset({name: ("window", values) for name, values in columns.items()})
    _fig, (ax,) = plot.panels()
    plot.windows(table, ax, shade=0.0)
    bars = [(bar.get_x(), bar.get_x() + bar.get_width(), bar.get_y()) for bar in ax.patches]
    assert len(bars) == 4
    for n, (low, high, row) in enumerate(bars):
        assert not any(row == other and min(high, y) - max(low, x) > 1e-9 for x, y, other in bars[:n])
    assert len({row for _low, _high, row in bars}) == 3  # two that only meet share a row


def test_windows_alone_are_drawn_over_the_range_that_they_take():
    far = gz.windows(gz.pinball(omega=2.2, V=0.4), "omega", N=[2, 3], span=(2.0, 9.0))
    drawn = plot.windows(far)
    axes = drawn["figure"].axes[0]
    low, high = axes.get_xlim()
    assert 2.0 <= low <= far.low.min() and far.high.max() <= high <= 9.0 and set(drawn["bars"]) == {*far.N.values}
    assert axes.get_xlabel() == r"$\omega$" and not axes.get_yticks().size
    assert "no window" not in [text.get_text() for text in axes.texts]
    (said,) = plot.windows({1: (2.0, 1.0)})["figure"].axes[0].texts
    assert said.get_text() == "no window"
    assert plot.windows({1: (70.0, 80.0)})["bars"][1].get_width() == 10.0  # beyond the limits of new axes


@pytest.mark.parametrize("edges", [{1: 0.5}, [(1, 0.2, 0.3)], {"a": (0.1, 0.2)}, xr.Dataset({"N": ("window", [1])})])
def test_windows_refuse_another_shape(edges):
    with pytest.raises(InputError, match=r"allowed are the xarray.Dataset .*N, low, high.* a mapping from N"):
        plot.windows(edges)


def test_the_zero_time_map_has_velocity_across():
    four = zdm_points(pinball(d=0.12), (0.02, -0.3))
    drawn = plot.zdm(four)
    assert drawn["points"].get_xdata().tolist() == four.points[:, 1].tolist()
    assert drawn["points"].get_ydata().tolist() == four.points[:, 0].tolist()
    assert drawn["fall"].get_ydata()[-1] == pytest.approx(0.0, abs=1e-15)
    assert drawn["back"].get_ydata()[-1] == pytest.approx(four.points[3, 0], abs=1e-15)


def lightness(colour):
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (red, green, blue)]
    y = float(np.dot(linear, [0.2126, 0.7152, 0.0722]))
    return 116 * y ** (1 / 3) - 16 if y > 0.008856 else 903.3 * y


def test_neighbouring_periods_differ_in_grey():
    values = [lightness(colour) for colour in PERIODS]
    for one, other in zip(values, [*values[1:], values[0]], strict=True):
        assert abs(one - other) > 20.0
    assert plot.period_colour(17) == PERIODS[0]
    assert [plot.period_colour(code) for code in (-1, 0, -2)] == [CHAOS, UNDECIDED, ENDED]
    assert len({*PERIODS, CHAOS, UNDECIDED, ENDED}) == 19
    assert (ink_on(PERIODS[0]), ink_on(PERIODS[1])) == ("#ffffff", "#1a1a1a")


def lab(colour):
    """CIE L*a*b* of an sRGB colour, white D65."""
    c = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(to_xyz @ linear / [0.9505, 1.0, 1.089])  # all colours of ours are light enough for the root
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_other_words_are_not_taken_for_what_has_no_period_or_another_word():
    for other in (*PERIODS, CHAOS, UNDECIDED, ENDED, "#ffffff"):
        assert np.linalg.norm(lab(OTHERS) - lab(other)) > 12.0, other


@pytest.mark.parametrize("where", ["axes", "figure"])
def test_a_dark_ground_is_warned_of(where):
    """Period 1 was drawn black on black, and so was the legend."""
    ax = plot.figure().add_subplot()
    (ax if where == "axes" else ax.figure).set_facecolor("black")
    with pytest.warns(UserWarning, match="the axes are dark"):
        plot.orbit_diagram(diagram(), ax=ax)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plot.orbit_diagram(diagram(), ax=plot.figure().add_subplot(facecolor="#eeeeee"))


def test_no_global_setting_changes():
    before = dict(matplotlib.rcParams)
    plot.orbit_diagram(diagram())
    assert dict(matplotlib.rcParams) == before


@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_the_same_figure_gives_the_same_bytes(kind):
    files = [plot.rendered(plot.orbit_diagram(diagram())["points"][1].figure, kind, "t", {"seed": 0}) for _ in range(2)]
    assert files[0] == files[1]


def test_provenance_is_in_the_file():
    fig = plot.orbit_diagram(diagram())["points"][1].figure
    png = plot.rendered(fig, "png", "a title", {"lam": 0.5})
    assert b"a title" in png
    assert b'{"lam": 0.5}' in png
    pdf = plot.rendered(fig, "pdf", "a title", {"lam": 0.5})
    assert b"CreationDate" not in pdf
    assert b"/Type3" not in pdf


@pytest.mark.parametrize("provenance", [2, "text", ["lam"]])
def test_provenance_that_is_no_mapping_is_refused(provenance):
    with pytest.raises(InputError, match="give a mapping or None"):
        plot.rendered(plot.figure(), "png", provenance=provenance)


def test_saving(tmp_path):
    fig = plot.orbit_diagram(diagram())["points"][1].figure
    assert plot.save(fig, tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]
    with pytest.raises(InputError, match="figure format 'jpg'; allowed are png, pdf, svg"):
        plot.save(fig, tmp_path / "a.jpg")
    with pytest.raises(InputError, match=r"cannot be written: No such file or directory"):
        plot.save(fig, tmp_path / "none" / "a.png")
    with pytest.raises(InputError, match="allowed are png, pdf, svg"):
        plot.rendered(fig, np.array(["png", "pdf"]))


def test_numbers_that_cannot_be_drawn(tmp_path):
    fig, (ax,) = plot.panels()
    with pytest.raises(InputError, match="points of the orbit cannot be drawn: they are too large"):
        plot.cobweb(gap_map(0.013, -0.012, 1.7e308), [0.1, -1.7e308], closed=False)
    ax.plot([0.0, 1.0], [-1.7e308, 1.7e308])
    with pytest.raises(InputError, match=r"the figure cannot be drawn .* too large or too far apart"):
        plot.save(fig, tmp_path / "a.png")
    assert not [*tmp_path.iterdir()]


def test_saving_what_a_function_returned(tmp_path):
    P, points = gap_map(0.8, 0.5, 1.0), [-1.0060750571225354, -0.3048600456980284, 0.2561119634415773]
    everything = [
        plot.cobweb(P, points),
        plot.graph(stepped()),
        plot.map_graph(plot.graph_of(P, [-1.0, 0.5])),
        plot.orbit_diagram(diagram()),
        plot.trajectory(trajectory(pinball(d=0.12), (0.1, 0.0), until=5.0)),
        plot.windows({1: (0.5, 0.2)}),
        plot.zdm(zdm_points(pinball(d=0.12), (0.02, -0.3))),
    ]
    for i, drawn in enumerate(everything):
        assert plot.save(drawn, tmp_path / f"{i}.png").read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(InputError, match="a dict without a figure cannot be written; allowed are a matplotlib Figure"):
        plot.save({"bars": {}}, tmp_path / "none.png")
