"""Grazes of launches, against tangents in closed form, trajectories and a finer grid."""

from math import asin, atan2, hypot, pi

import numpy as np
import pytest
from scipy.optimize import brentq

import grazing as gz
from grazing.maps.borders import ANGLE, SEAM, SPEED, Borders
from grazing.maps.itineraries import Itineraries

LAW = gz.active(r=0.8, V=0.3)
BOX = {"angle": (0.1, 1.5), "speed": (1.0, 2.0)}


def curves(found):
    """Return object, word, and the points of each curve."""
    rows = found["row"].values
    points = np.column_stack([found.angle.values, found.speed.values])
    return [
        (str(found.object[k].item()), str(found.word[k].item()), points[(rows == k) & np.isfinite(points[:, 0])])
        for k in range(found.sizes["curve"])
    ]


def test_without_gravity_a_disc_is_grazed_at_its_tangents_at_any_speed():
    x, y, size = 3.0, 2.0, 0.6
    table = gz.table([gz.disc("A", (x, y), size - 0.1, LAW)], rho=0.1)
    found = gz.grazes(table, (0, 0), **BOX, order=0)
    middle, half = atan2(y, x), asin(size / hypot(x, y))
    means = sorted((points[:, 0].mean(), *np.ptp(points, axis=0)) for _object, _word, points in curves(found))
    np.testing.assert_allclose([one[0] for one in means], [middle - half, middle + half], rtol=1e-12)
    assert [one[2] for one in means] == [1.0, 1.0] and max(one[1] for one in means) < 1e-12
    assert found.kick.values.tolist() == [0.3, 0.3] and found.order.values.tolist() == [0, 0]
    assert 0.0 < found.angle_width.max() < 1e-12 and not found.speed_width.max()


def test_a_preimage_through_a_wall_is_the_tangent_of_the_mirror_image():
    wall = gz.segment("w", (4.0, -9.0), (4.0, 9.0), gz.newton(1.0))
    table = gz.table([gz.disc("A", (1.0, 2.0), 0.4, LAW), wall], rho=0.1)
    found = gz.grazes(table, (0, 0), **BOX)
    middle, half = atan2(2.0, 2 * 3.9 - 1.0), asin(0.5 / hypot(2 * 3.9 - 1.0, 2.0))
    seen = sorted(points[:, 0].mean() for one, word, points in curves(found) if (one, word) == ("A", "w"))
    np.testing.assert_allclose(seen, [middle - half, middle + half], rtol=1e-12)


def test_with_gravity_each_point_is_a_parabola_that_touches_the_circle():
    """The gap along the flight, a quartic, has a double root: its discriminant is 0."""
    table = gz.table([gz.disc("A", (2.0, 1.0), 0.5, LAW)], rho=0.1, tilt=pi / 2)
    found = gz.grazes(table, (0.0, 0.0), (0.2, 1.5), (1.5, 4.0), order=0)
    assert sum(len(points) for *_names, points in curves(found)) > 60
    for _object, _word, points in curves(found):
        for angle, speed in points:
            way = np.poly1d([speed * np.cos(angle), -2.0]), np.poly1d([-0.5, speed * np.sin(angle), -1.0])
            gap = way[0] ** 2 + way[1] ** 2 - 0.6**2
            turns = [t.real for t in gap.deriv().roots if abs(t.imag) < 1e-9 and t.real > 0]
            assert min(abs(gap(t)) for t in turns) < 1e-11


def test_a_disc_that_is_grazed_and_then_hit_by_the_same_flight_is_found():
    """Steeply past its left side, and down on its top: the words of both sides are the same."""
    table = gz.table([gz.disc("A", (0.5, 1.5), 0.4, LAW)], rho=0.1, tilt=pi / 2)
    found = gz.grazes(table, (-0.1, 0.0), (1.4, 1.6), (1.8, 2.6), order=0)
    twice = 0
    for _object, _word, points in curves(found):
        for angle, speed in points:
            hits = []
            for a in (angle - 1e-7, angle + 1e-7):
                flown = gz.trajectory(table, (-0.1, 0, speed * np.cos(a), speed * np.sin(a)), until=9.0, samples=2)
                hits.append(flown.v_minus.values[:1])
            twice += all(map(len, hits))
            assert min(abs(one[0]) for one in hits if len(one)) < 1e-2
    assert twice > 5


def flipped():
    """A table with a flipper that is pressed in time."""
    flipper = gz.flipper("L", (1.2, 1.0), 1.45, (0.2, 0.12), -0.5, 0.6, gz.newton(0.8), up=14.0, down=9.0)
    player = gz.flips(period=0.9, hold=0.3, phase={"L": 0.0})
    return gz.table([flipper, gz.disc("A", (2, 6), 0.5, LAW)], rho=0.1, tilt=0.5, player=player)


@pytest.mark.parametrize("name", ["one_bumper", "classic", "flipped"])
def test_the_speed_falls_as_a_square_root_beside_each_point_and_the_ball_passes_on_the_other_side(name):
    table = flipped() if name == "flipped" else gz.read_table(name)
    boxes = {"one_bumper": [(-1.0, 1.0), (1.0, 4.0)], "classic": [(1.2, 1.9), (12, 22)]}
    box = dict(zip(BOX, boxes.get(name, [(-2.5, -0.5), (0.5, 2.0)]), strict=True))
    x, y = (table.plunger.x, table.plunger.y) if table.plunger else (2.0, 4.0)
    found = gz.grazes(table, (x, y), **box, cells=(16, 8))
    assert found.sizes["curve"] > 3
    rows = np.flatnonzero(np.isfinite(found.angle.values))[::7]
    for row in rows:
        k = int(found["row"][row])
        order, axis = int(found.order[k]), int(found.angle_width[row] == 0.0)
        here = np.array([found.angle[row], found.speed[row]])
        speeds = []
        for share in (-4e-10, -1e-10, 1e-10, 4e-10):
            a, v = here + share * np.eye(2)[axis] * np.ptp(list(box.values())[axis])
            flown = gz.trajectory(table, (x, y, v * np.cos(a), v * np.sin(a)), until=60.0, samples=2)
            named = flown.impact_wall.values[: order + 1].tolist()
            hit = len(named) > order and named[order] == found.object[k].item()
            speeds.append(abs(float(flown.v_minus[order])) if hit else np.inf)
        below, above = speeds[:2][::-1], speeds[2:]
        near, far = below if below[0] < above[0] else above
        assert far / near == pytest.approx(2.0, rel=0.05)
        assert max(below[0], above[0]) > 2 * far


TABLE = gz.table(
    [
        gz.disc("A", (2.0, 6.0), 0.5, LAW),
        gz.disc("B", (4.0, 6.0), 0.5, LAW),
        gz.segment("left", (0, 10), (0, 0), gz.newton(0.9)),
        gz.segment("right", (6, 0), (6, 10), gz.newton(0.9)),
        gz.drain("out", (0, 0), (6, 0)),
    ],
    rho=0.1,
    tilt=0.2,
)
WIDE = {"angle": (0.3, pi - 0.3), "speed": (1.5, 2.5)}


def test_a_symmetric_table_has_symmetric_grazes():
    found = curves(gz.grazes(TABLE, (3.0, 2.0), **WIDE, cells=(16, 8)))
    other = str.maketrans("AB", "BA")

    def mirrored(name):
        return {"left": "right", "right": "left"}.get(name.strip("()"), name.translate(other)) if name else name

    points = {(one, word.strip("()")): [] for one, word, _points in found}
    for one, word, each in found:
        points[one, word.strip("()")].append(each)
    for (one, word), each in points.items():
        twin = np.concatenate(points[mirrored(one), mirrored(word)])
        here = np.concatenate(each)
        assert len(here) == len(twin)
        for angle, speed in here:
            assert np.abs(twin - (pi - angle, speed)).sum(axis=1).min() < 1e-11


def test_the_unit_of_length_does_not_matter():
    """All lengths, gravity with them, a thousand times as large: speeds are, and angles are the same."""
    scale = 1024.0
    lengths = {name: value * scale for name, value in TABLE.params.items() if name not in ("tilt", "A.r", "B.r")}
    lengths = {name: value for name, value in lengths.items() if not name.endswith((".r", "tilt"))}
    big = TABLE.replace(**lengths)
    one = gz.grazes(TABLE, (3.0, 2.0), **WIDE, cells=(16, 8))
    found = gz.grazes(big, (3.0 * scale, 2.0 * scale), WIDE["angle"], [v * scale for v in WIDE["speed"]], cells=(16, 8))
    np.testing.assert_allclose(found.angle, one.angle, rtol=1e-12)
    np.testing.assert_allclose(found.speed, one.speed * scale, rtol=1e-12)
    assert found.word.equals(one.word) and found.object.equals(one.object)


def test_borders_in_the_picture_of_exits_lie_on_changes():
    """Launches with two impacts at most that leave in other ways have a change between them: a graze, or a corner."""
    box = WIDE["angle"], WIDE["speed"]
    borders = Borders(Itineraries(TABLE, 3.0, 2.0, 3), box, (399, 8))
    borders.search((ANGLE, j, i, i + 1) for i in range(399) for j in range(9))
    angle, speed = np.linspace(*box[0], 400), [borders.along(SPEED, j) for j in range(9)]
    exits, seen = gz.launches(TABLE, (3.0, 2.0), angle, speed), 0
    for j, v in enumerate(speed):
        at = np.array([one.low for one in borders.all() if one.at == v and one.kind != SEAM])
        for i in np.flatnonzero(exits.exit.values[1:, j] != exits.exit.values[:-1, j]):
            if exits.hits.values[i : i + 2, j].max() <= 2:
                seen += 1
                assert ((at >= angle[i] - 1e-12) & (at <= angle[i + 1])).any()
    assert seen > 5


def test_a_box_of_hardly_any_width_has_the_same_graze():
    at, cells = asin(0.3), (2, 2)
    table = gz.table([gz.disc("A", (2.0, 6.0), 0.5, LAW)], rho=0.1)
    found = gz.grazes(table, (0.0, 6.0), (at - 1e-12, at + 1e-12), (1.0, 2.0), order=0, cells=cells)
    assert found.sizes["curve"] == 1 and abs(found.angle - at).max() < 2e-14  # that is what doubles decide


def test_strips_thinner_than_the_finest_cells_are_followed():
    """The bumper, and then a wall, is grazed along both sides of strips that are 1/2000 of the box wide."""
    found = gz.grazes(gz.read_table("one_bumper"), (0.3, 4.0), (-1.0, 1.0), (1.0, 4.0))
    assert found.sizes["curve"] == 10 and not found.closed.any()


def test_a_finer_grid_finds_no_other_curves():
    usual = gz.grazes(TABLE, (3.0, 2.0), **WIDE, order=0, cells=(16, 8))
    finer = gz.grazes(TABLE, (3.0, 2.0), **WIDE, order=0, cells=(64, 32))
    names = lambda found: sorted(zip(found.object.values, found.word.values, strict=True))  # noqa: E731
    assert names(usual) == names(finer)


def test_what_is_asked_for():
    only = gz.grazes(TABLE, (3.0, 2.0), **WIDE, objects="A", order=0, cells=(16, 8))
    assert set(only.object.values.tolist()) == {"A"} and not only.order.any()
    none = gz.grazes(TABLE, (3.0, 2.0), (1.5, 1.6), (0.1, 0.2), cells=(2, 3))
    assert none.sizes == {"point": 0, "curve": 0}
    for wrong, said in [
        ({"angle": 1.0}, r"angle is 1.0; give angle=\(low, high\), finite numbers"),
        ({"speed": (-1.0, 2.0)}, r"speed is \(-1, 2\); give speed=\(low, high\), finite numbers, both >= 0"),
        ({"speed": (2.0, 1.0)}, "the lower end must come first"),
        ({"order": -1}, "order = -1"),
        ({"objects": ["C"]}, "no object is called 'C'; allowed are A, B, left, right, out"),
        ({"angle": (1.0, 1.0 + 1e-13)}, r"too few doubles between for 64 cells"),
        ({"cells": 5}, "cells are 5; give how many there are along angle and speed"),
        ({"point": (2.0, 6.0)}, "overlaps A by 0.6; start where it is free"),
    ]:
        with pytest.raises(gz.InputError, match=said):
            gz.grazes(**{"table": TABLE, "point": (3.0, 2.0), **WIDE, **wrong})
    with pytest.raises(gz.InputError, match="no plunger; give"):
        gz.grazes(TABLE, (3.0, 2.0))


@pytest.mark.parametrize("slope", [3e-4, 5.7e-4, 1e-3])
def test_where_a_face_becomes_its_end_the_ball_hits_slowly_and_no_graze_is_listed(slope):
    """Beside it the square of the speed along the normal grows from v0^2, which looks as from 0 where v0 is small."""
    rho, near, far = 0.2, 2.0, 6.0
    high = rho + near * np.tan(slope)  # the ball comes down on the near end of the face at this slope
    table = gz.table([gz.segment("m", (near, 0.0), (far, 0.0), gz.newton(0.8))], rho=rho)
    found = gz.grazes(table, (0.0, high), (-1.0, 1.0), (1.0, 2.0), 0, cells=(7, 2))
    angles = found.angle.values[np.isfinite(found.angle.values)]
    over = [
        brentq(lambda p, x=x, s=s: high * np.cos(p) - x * np.sin(p) - s * rho, 0.0, 1.0)
        for x, s in ((far, 1), (near, -1))
    ]  # past the far end above, past the near one below
    assert len(angles) and all(np.abs(angle + over).min() < 1e-10 for angle in angles)
