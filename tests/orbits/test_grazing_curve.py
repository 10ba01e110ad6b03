import json

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.backward import touches
from grazing.orbits.grazing_curve import grazing_arrays, grazing_curve
from grazing.outcome import InputError


def soft(v, p):
    return -p.r * v / (1.0 - p.c * v)


def oscillator(alpha, k, omega, reset, offset=0.0, sigma=0.0, t0=0.0, **forcing):
    forces = gz.Forcing(omega=omega, t0=t0, offset=offset, **forcing)
    return gz.Oscillator(alpha=alpha, k=k, forcing=forces, reset=reset, sigma=sigma)


# model, phase, box
MODELS = {
    "active": (gz.pinball(d=0.12), 0.0, ((0.0, 1.0), (-1.0, 1.0))),
    "passive": (gz.pinball(d=0.12, V=0.0), 0.4, ((0.0, 1.0), (-1.0, 1.0))),
    "light": (oscillator(0.1, 1.0, 2.8, gz.newton(0.9), -0.2, -0.1), 0.0, ((-0.1, 1.5), (-1.5, 1.5))),
    "no spring, two harmonics": (
        oscillator(0.2, 0.0, 1.7, gz.active(0.6, 0.5), -0.3, 0.3, 0.3, cos=(1.0, 0.4), sin=(0.0, 0.5)),
        0.7, ((0.3, 2.3), (-1.5, 1.5)),
    ),
    "critical, own law": (
        oscillator(2.0, 1.0, 2.2, gz.reset(soft, r=0.8, c=0.3), 0.1), 1.3, ((0.0, 1.0), (-1.0, 1.0))
    ),
    "trigger": (
        oscillator(0.5, 1.5, 2.2, gz.triggered(0.7, 0.6, 0.3), 0.1, 0.1), 0.0, ((0.1, 1.0), (-1.0, 1.0))
    ),
    "slow forcing": (oscillator(0.05, 3.0, 1.0, gz.newton(0.8), 0.3, -0.05), 0.0, ((-0.05, 0.5), (-1.0, 1.0))),
    "undamped, dead wall": (oscillator(0.0, 1.0, 1.9, gz.newton(0.0), 0.4), 0.0, ((0.0, 1.0), (-1.0, 1.0))),
}  # fmt: skip


@pytest.fixture(scope="module", params=MODELS, ids=str)
def drawn(request):
    model, phase, box = MODELS[request.param]
    return request.param, model, phase, box, grazing_curve(model, phase, preimages=2, points=600, box=box)


def points_of(curve, order):
    """Points and contact times of one order, without the breaks."""
    kept = (curve.order.values == order) & np.isfinite(curve.contact_time.values)
    return curve.graze.values[kept], curve.contact_time.values[kept]


def distance(point, pieces, extent):
    """Distance of a point from a curve in pieces, in parts of the extent of the box."""
    a, b = pieces[:-1] / extent, pieces[1:] / extent
    alone = np.isnan(b).any(axis=1)
    b = np.where(alone[:, None], a, b)
    a, b = (part[~np.isnan(a).any(axis=1)] for part in (a, b))
    along = b - a
    length = np.maximum((along**2).sum(axis=1), 1e-300)
    share = np.clip(((point / extent - a) * along).sum(axis=1) / length, 0.0, 1.0)
    return float(np.hypot(*(point / extent - a - share[:, None] * along).T).min(initial=np.inf))


def test_a_ball_without_spring_and_damping_by_hand():
    # y'' = d + cos(omega t) with the touch at s: y = d (t-s)^2/2 - (cos(omega t) - cos(omega s))/omega^2
    # - (t-s) sin(omega s)/omega
    d, omega = 1.5, 2.0
    model = oscillator(0.0, 0.0, omega, gz.newton(0.0), d)
    curve = grazing_curve(model, points=500, box=((0.0, 9.0), (-9.0, 9.0)))
    points, s = points_of(curve, 0)
    assert len(s) > 100 and s.min() < 0.01 and s.max() > np.pi - 0.01
    u = 0.5 * d * s**2 - (1.0 - np.cos(omega * s)) / omega**2 + s * np.sin(omega * s) / omega
    v = -d * s - np.sin(omega * s) / omega
    assert points[:, 0] == pytest.approx(u, abs=1e-14)
    assert points[:, 1] == pytest.approx(v, abs=1e-14)
    assert not np.isnan(curve.graze.values).any()  # the force lifts at all times: one piece


def test_the_jump_of_figure_2_2():
    model = gz.pinball(alpha=3, k=1, omega=2.1, t0=2.2, r=0.8, d=0.11, V=0.2)
    curve = grazing_curve(model, box=((0.0, 0.06), (-0.3, -0.1)))
    points, times = points_of(curve, 0)
    near = np.argsort(np.abs(points[:, 1] + 0.23))[:4]
    near = near[np.argsort(points[near, 1])]
    assert np.interp(-0.23, points[near, 1], points[near, 0]) == pytest.approx(0.0383355822, abs=1e-7)
    assert np.interp(-0.23, points[near, 1], times[near]) == pytest.approx(0.332406, abs=1e-5)


def test_the_result_says_what_it_is(drawn):
    name, model, phase, box, curve = drawn
    assert curve.graze.dims == ("graze_point", "coordinate") and curve.coordinate.values.tolist() == ["u", "v"]
    assert {*np.unique(curve.order.values)} <= {0, 1, 2}
    assert (np.diff(curve.order.values) >= 0).all()
    broken = np.isnan(curve.graze.values)
    assert (broken[:, 0] == broken[:, 1]).all() and (broken[:, 0] == np.isnan(curve.contact_time.values)).all()
    assert not broken[[0, -1]].any() and not (broken[1:] & broken[:-1]).any()
    assert (curve.graze.values[~broken[:, 0], 0] >= model.sigma).all()
    times = curve.contact_time.values[~broken[:, 0]]
    assert (times > 0.0).all() and (times <= model.period * (1.0 + 1e-15)).all()
    assert curve.attrs["cut_short"] == 0
    config = json.loads(curve.attrs["grazing_config"])
    assert config["points"] == 600 and config["preimages"] == 2 and np.shape(config["box"]) == (2, 2)
    assert all(value.attrs["long_name"] and value.attrs["units"] for value in curve.data_vars.values())
    if name == "active":
        points, order = grazing_arrays(model, phase, 2, 600, box)
        assert np.array_equal(points, curve.graze.values, equal_nan=True)
        assert np.array_equal(order, curve.order.values)


def test_neighbouring_points_of_a_piece_are_close(drawn):
    *_rest, box, curve = drawn
    steps = np.abs(np.diff(curve.graze.values, axis=0)) / np.ptp(np.array(box), axis=1)
    steps = steps.max(axis=1)[~np.isnan(steps).any(axis=1)]
    assert np.quantile(steps, 0.95) < 7.0 / 600 and steps.max() < 30.0 / 600


def test_a_hair_beside_the_curve_the_ball_hits_or_does_not(drawn):
    _name, model, phase, _box, curve = drawn
    P = gz.stroboscopic_map(model, phase)
    points, _times = points_of(curve, 0)
    checked = 0
    for point in points[5::11]:
        if point[0] - model.sigma < 1e-3:
            continue
        beside = [P.orbit(point + step, 1) for step in 1e-9 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])]
        if min(orbit.letters[0] for orbit in beside) < 0:
            continue
        if max(orbit.letters[0] for orbit in beside) > 3:  # many impacts, each of which magnifies the hair
            continue
        misses = [orbit.near_miss < 1e-6 for orbit in beside]
        hits = [orbit.slowest < 1e-3 for orbit in beside]
        assert any(misses) and any(hits) and np.array_equal(misses, ~np.array(hits))
        if model.reset.name == "newton":  # no kick: the orbits stay together and differ by that one impact
            letters = np.array([orbit.letters[0] for orbit in beside])
            assert set(letters[hits]) == {letters[misses][0] + 1}
        checked += 1
    assert checked >= (1 if "trigger" in _name else 5)


@pytest.mark.parametrize("order", [1, 2])
def test_preimages_come_back_to_the_curve(drawn, order):
    _name, model, phase, _box, curve = drawn
    points, times = points_of(curve, order)
    P = gz.stroboscopic_map(model, phase)
    for point, time in list(zip(points, times, strict=True))[3::23]:
        image = P.iterate(point, order)[-1]
        height, _impacts = touches(model, phase, image[None], np.array([time]), np.array([time]))
        assert abs(height[0]) < 1e-5 * (1.0 + np.abs(image).max())


def changes(P, starts, ends, k):
    """Where the letters of k periods change between two states, by halving: both sides, the first
    period that differs and the impacts before it."""
    for a, b in zip(starts, ends, strict=True):
        one, other = P.orbit(a, k), P.orbit(b, k)
        if one.letters.tolist() == other.letters.tolist() or min(one.letters.min(), other.letters.min()) < 0:
            continue
        for _ in range(36):  # not to the last bits: there each step asks for ball arithmetic
            middle = 0.5 * (a + b)
            if (middle == a).all() or (middle == b).all():
                break
            found = P.orbit(middle, k)
            if found.letters.tolist() == one.letters.tolist():
                a, one = middle, found
            else:
                b, other = middle, found
        same = one.letters == other.letters
        yield a, b, int(np.argmin(same)), max(one.letters[: int(np.argmin(same))].sum(), 0)


def test_where_a_touch_changes_the_letters_there_is_a_curve(drawn):
    # Letters also change where an impact crosses the strobe, or a jump of the law, and in chatter: no touch is near
    # then. A touch it is where one side barely misses, or barely hits, in the first period that differs.
    name, model, phase, box, curve = drawn
    P = gz.stroboscopic_map(model, phase)
    extent = np.ptp(np.array(box), axis=1)
    rng = np.random.default_rng(7)
    low, high = np.array(box).T
    starts = low + rng.random((250, 2)) * (high - low)
    ends = np.clip(starts + 0.1 * extent * rng.choice([-1.0, 1.0], (250, 2)), low, high)
    found = 0
    for a, b, first, before in changes(P, starts, ends, 3):
        first_a, first_b = P.iterate(a, first)[-1], P.iterate(b, first)[-1]
        segments = [P.orbit(state, 1) for state in (first_a, first_b)]
        if min(min(piece.near_miss, piece.slowest**2) for piece in segments) > 1e-8:
            continue
        if model.params["r"] == 0.0 and (before or max(piece.letters[0] for piece in segments) > 1):
            continue  # a dead wall forgets the speed: behind an impact there is no curve
        if max(piece.letters[0] for piece in segments) > 15 or min(piece.letters[0] for piece in segments) < 0:
            continue
        pieces = curve.graze.values[curve.order.values == first]
        assert distance(a, pieces, extent) < 0.01, (name, a, first)
        found += 1
    assert found >= (1 if name in ("trigger", "undamped, dead wall") else 5)


def test_a_dead_wall_has_no_curve_behind_an_impact():
    model = oscillator(0.3, 1.0, 2.0, gz.newton(0.0), 0.1)
    curve = grazing_curve(model, preimages=2, points=500)
    P = gz.stroboscopic_map(model)
    for order in (0, 1, 2):
        points, _times = points_of(curve, order)
        for point in points[1::29]:
            assert (P.orbit(point, order + 1).letters[:order] == 0).all()


def test_a_force_that_never_lifts_has_no_curve():
    model = oscillator(0.3, 1.0, 2.0, gz.newton(0.5), -2.0)
    curve = grazing_curve(model, preimages=1)
    assert curve.sizes["graze_point"] == 0
    assert grazing_arrays(model)[0].shape == (0, 2)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"model": 3}, "give an oscillator"),
        ({"phase": "soon"}, "phase = 'soon' is not a real number"),
        ({"preimages": -1}, "preimages = -1; allowed is a whole number >= 0"),
        ({"points": 3}, "points = 3; allowed is a whole number >= 10"),
        ({"box": ((0, 1),)}, "box has 1 intervals for 2 coordinates"),
        ({"model": oscillator(0.0, 1e7, 1.0, gz.newton(0.5))}, "swings"),
    ],
)
def test_wrong_input_is_refused(change, said):
    with pytest.raises(InputError, match=said.replace("(", r"\(").replace(">=", ">=")):
        grazing_curve(**{"model": gz.pinball(), **change})
