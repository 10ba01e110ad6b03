"""Figures of tables: to scale, every object, the way of a ball."""

from io import BytesIO

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, BboxTransformTo
from PIL import Image

import grazing as gz
from grazing.plot.animation import durations
from tests.billiard.flippers import pair
from tests.billiard.tables import mixed, three_discs
from tests.maps.test_collisions import pinball


def test_a_table_is_drawn_to_scale_with_every_object():
    table = mixed(0.2)
    drawn = gz.plot.table(table)
    ax = drawn["figure"].axes[0]
    assert list(drawn["objects"]) == list(table.names) and ax.get_aspect() == 1.0
    x, y = drawn["objects"]["bumper"].get_data()
    np.testing.assert_allclose(np.hypot(x - 4.4, y - 2.4), 0.6)
    assert drawn["objects"]["bumper"].get_color() != drawn["objects"]["post"].get_color()
    assert {text.get_text() for text in ax.texts} == {*table.names}
    assert not gz.plot.table(table, names=False)["figure"].axes[0].texts
    low, high = ax.get_xlim()
    assert low < 0.0 and high > 6.0


def test_names_cover_neither_each_other_nor_the_way_of_a_ball():
    pins = [gz.disc(f"pin_{i}", (0.5 * i, 1.0), 0.1, gz.newton(0.5)) for i in range(5)]
    walls = [gz.segment(f"wall_{i}", (2.4 + 0.2 * i, 0.0), (2.4, 2.0), gz.newton(0.5)) for i in range(2)]
    drawn = gz.plot.table(gz.table([*pins, *walls, gz.drain("out", (0, 0), (2, 0))], rho=0.01, tilt=0.3))
    figure, renderer = drawn["figure"], FigureCanvasAgg(drawn["figure"]).get_renderer()
    figure.draw_without_rendering()
    seen = [text for text in figure.axes[0].texts if text.get_visible() and text.get_text()]
    boxes = []
    for text in seen:
        angle = text.get_rotation()
        text.set_rotation(0.0)
        box = text.get_window_extent(renderer)
        turned = Affine2D().rotate_deg_around(*(0.5 * (box.min + box.max)), angle)
        boxes.append(Path([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]).transformed(BboxTransformTo(box) + turned))
    assert len(seen) >= 4 and all(figure.axes[0].bbox.padded(1).contains(*at) for one in boxes for at in one.vertices)
    assert not [i for i, one in enumerate(boxes) for other in boxes[:i] if one.intersects_path(other)]
    assert all(text.get_zorder() < 4.0 for text in seen)  # that of the way


@pytest.mark.parametrize("fps", [30, 35, 40, 50])
def test_a_film_lasts_as_long_as_it_says(fps):
    frames = int(0.2 * fps)
    lasts = durations(frames, fps)
    assert len(lasts) == frames and all(each % 10 == 0 for each in lasts)  # a GIF counts in hundredths of a second
    assert abs(sum(lasts) - 1000.0 * frames / fps) <= 5.0


def test_the_way_of_a_ball_is_that_of_the_trajectory():
    table = pinball()
    flown = gz.trajectory(table, (2.2, 9.0, 0.3, 0.0), until=60.0)
    drawn = gz.plot.table(table, flown)
    assert {*zip(flown.x.values, flown.y.values, strict=True)} <= {*zip(*drawn["way"].get_data(), strict=True)}
    first, last = drawn["ball"]
    assert first.center == (2.2, 9.0) and first.radius == table.rho == last.radius
    assert last.center == (float(flown.x[-1]), float(flown.y[-1]))
    assert drawn["objects"]["left_drain"].get_linestyle() == "--"


def test_a_plunger_is_an_arrow_to_where_balls_are_launched():
    drains = [gz.drain("out", (0, 0), (3, 0))]
    drawn = gz.plot.table(gz.table(drains, plunger=gz.plunger((5.0, 1.0), np.pi, 1.0, 2.0)))
    arrow, ax = drawn["plunger"], drawn["figure"].axes[0]
    assert arrow.xy == (5.0, 1.0) and arrow.xyann[0] > 0.0 and abs(arrow.xyann[1]) < 1e-12  # it comes from the right
    assert ax.get_xlim()[1] > 5.0 and ax.get_ylim()[1] > 1.0
    assert gz.plot.table(gz.table(drains))["plunger"] is None


def corners(x, y):
    """By how many degrees a way turns at each of its points."""
    dx, dy = np.diff(x), np.diff(y)
    moves = np.hypot(dx, dy) > 1e-9
    turn = np.diff(np.unwrap(np.arctan2(dy[moves], dx[moves])))
    return np.abs(np.degrees(turn))


@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_a_flight_is_drawn_without_corners_and_lies_on_its_parabola(unit):
    table = gz.table([gz.segment("floor", (0, 0), (8 * unit, 0), gz.newton(1.0))], g=unit, tilt=0.5 * np.pi)
    flown = gz.trajectory(table, (0.0, 2.0 * unit, unit, 0.0), until=8.0, samples=12)
    x, y = gz.plot.table(table, flown)["way"].get_data()
    assert (corners(x, y) > 10.0).sum() == flown.sizes["impact"] == 2
    assert (corners(flown.x.values, flown.y.values) > 10.0).sum() > 2  # the trajectory's own points have corners
    apart = np.abs((x / unit) % 4.0 - 2.0 * ((x / unit) % 4.0 > 2.0) * ((x / unit) % 4.0 - 2.0))
    np.testing.assert_allclose(y / unit, 2.0 - 0.5 * apart**2, atol=1e-12)
    level = gz.table([gz.disc("A", (4, 0), 1.0, gz.newton(1.0))])
    flown = gz.trajectory(level, (0.0, 0.3, 1.0, 0.0), until=9.0)
    assert gz.plot.table(level, flown)["way"].get_xdata().tolist() == flown.x.values.tolist()


def test_a_ball_that_flies_away_does_not_shrink_the_table():
    table = three_discs(6.0)
    drawn = gz.plot.table(table, gz.trajectory(table, (3.0, 1.0, 0.0, -1.0), until=900.0))
    assert drawn["figure"].axes[0].get_ylim()[0] > -20.0


def test_other_things_are_refused():
    with pytest.raises(gz.InputError, match=r"plot\.table cannot draw a Oscillator"):
        gz.plot.table(gz.pinball())
    with pytest.raises(gz.InputError, match=r"plot\.table finds no x in a result with u, v, .* and \d+ more;"):
        gz.plot.table(three_discs(6.0), gz.trajectory(gz.pinball(), (0.1, 0.0)))


def test_a_film_shows_the_ball_and_the_flippers_where_they_are(tmp_path):
    table = pair(gz.flips(0.9, 0.4))
    flown = gz.trajectory(table, (2.5, 5.0, 0.3, 0.0), start=0.1, until=1.1)
    path = gz.plot.animate(table, flown, tmp_path / "ball.gif", fps=10, speed=0.5)
    with Image.open(path) as film:
        assert film.n_frames == 21 and film.info["duration"] == 100
        frames = []
        for i in range(film.n_frames):
            film.seek(i)
            frames.append(np.asarray(film.convert("RGB"), dtype=int))
    drawn = gz.plot.table(table, names=False)
    with gz.plot.styled():
        drawn["figure"].savefig(BytesIO(), format="rgba", dpi=100)

    def colour(i, x, y):
        column, row = drawn["figure"].axes[0].transData.transform((x, y))
        return frames[i][int(len(frames[i]) - row), int(column)]

    for i in (0, 7, 20):
        end = np.searchsorted(flown.t.values, 0.1 + 0.05 * i, side="right") - 1
        s, now = 0.1 + 0.05 * i - float(flown.t[end]), flown.isel(t=end)
        red, _green, blue = colour(i, now.x + now.vx * s, now.y + now.vy * s - 0.5 * table.gravity * s * s)
        assert blue > red + 60
    raised, resting = ((1.2 + 1.4 * np.cos(angle), 1.0 + 1.4 * np.sin(angle)) for angle in (0.6, -0.5))
    for i, there, free in ((2, raised, resting), (12, resting, raised), (18, raised, resting)):  # t = 0.2, 0.7, 1.0
        assert colour(i, *there).sum() < 700 and colour(i, *free).sum() == 3 * 255


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"path": "ball.mp4"}, "a film is written as .gif; the file is called ball.mp4"),
        ({"fps": 0}, "fps = 0; allowed"),
        ({"fps": 0.5}, r"fps = 0\.5; allowed"),
        ({"speed": 0.0}, "speed = 0; allowed is speed > 0"),
        ({"speed": 1e-4}, "frames; allowed are 3000"),
    ],
)
def test_wrong_films_are_refused(more, said, tmp_path):
    flown = gz.trajectory(pinball(), (2.2, 9.0, 0.3, 0.0), until=2.0)
    with pytest.raises(gz.InputError, match=said):
        gz.plot.animate(pinball(), flown, **{"path": tmp_path / more.pop("path", "ball.gif"), **more})
    with pytest.raises(gz.InputError, match="trajectory"):
        gz.plot.animate(pinball(), None, tmp_path / "ball.gif")
    with pytest.raises(gz.InputError, match="cannot draw a"):
        gz.plot.animate(gz.pinball(), flown, tmp_path / "ball.gif")
    assert not list(tmp_path.iterdir())
