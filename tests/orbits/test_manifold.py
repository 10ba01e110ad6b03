"""Manifolds of saddles: against closed forms, a second method, invariance, the inverse, and the basins they bound."""

import dataclasses
import json

import numpy as np
import pytest

import grazing as gz
from grazing.orbits import manifold_steps
from grazing.orbits.manifold import manifolds
from grazing.orbits.manifold_saddle import saddle_of as side_of
from grazing.orbits.manifold_steps import Backwards, Forwards, Ray, swift, traced
from grazing.orbits.orbit import Orbit, condition_of
from tests.models import MODELS, changed_origin


def saddle_of(P, points, word="0"):
    """The orbit through exact points of a map, with its multipliers by the map's Jacobian."""
    points = np.array(points, np.float64)
    J = np.eye(2)
    for point in points:
        J = P.jacobian(point) @ J
    values = np.linalg.eigvals(J).astype(complex)
    return Orbit(
        map=P, points=points, word=word, period=len(points), multipliers=values[np.argsort(-np.abs(values))],
        admissible=True, condition=condition_of(J), residual=0.0,
    )  # fmt: skip


def linear(state, p):
    x, y = state
    return (p.a * x + p.c * y, p.b * y)


def henon(state, p):
    x, y = state
    return (1.0 - p.a * x * x + y, p.b * x)


def lozi(state, p):
    x, y = state
    return (1.0 - p.a * abs(x) + y, p.b * x), 1 if x >= 0.0 else 0


def broken(state, p):
    """Lozi's map with a jump where its kink is, as at an active impact."""
    x, y = state
    return (1.0 - p.a * abs(x) + y - (p.l if x >= 0.0 else 0.0), p.b * x), 1 if x >= 0.0 else 0


def made(step, box=((-2.0, 2.0), (-2.0, 2.0)), letters=None, **params):
    return gz.Map(step, params=params, coordinates=("x", "y"), box=box, letters=letters)


def one_impact_saddle(model, N, sign=1.0):
    """The admissible saddle with an unstable multiplier of one sign."""
    [found] = [
        orbit
        for orbit in gz.one_impact_orbits(model, N)
        if orbit.admissible and abs(orbit.multipliers[0]) > 1.0 > abs(orbit.multipliers[1])
        and sign * orbit.multipliers[0].real > 0.0
    ]  # fmt: skip
    return found


def wave(alpha, k, omega, offset, sigma, r, V):
    forcing = gz.Forcing(omega=omega, t0=0.4, offset=offset, cos=(1.0, 0.3), sin=(0.1, 0.25))
    return gz.Oscillator(alpha=alpha, k=k, forcing=forcing, sigma=sigma, reset=gz.active(r, V))


def trigger(alpha, k, omega, offset, r, V, at):
    return gz.Oscillator(
        alpha=alpha, k=k, forcing=gz.Forcing(omega=omega, offset=offset), reset=gz.triggered(r=r, V=V, trigger=at)
    )


LIGHT = gz.pinball(alpha=0.1, omega=3.27, d=0.57, r=0.9, V=0.1)
#: model, N, sign of the unstable multiplier
SADDLES = {
    "beyond the period doubling": (gz.pinball(d=0.105, V=0.4), 2, -1.0),
    "between period 1 and 2": (LIGHT, 2, 1.0),
    "between period 1 and 3": (LIGHT, 3, 1.0),
    "passive": (gz.pinball(alpha=0.1, omega=3.23, d=0.45, r=0.8, V=0.0), 3, 1.0),
    "below the origin": (gz.pinball(alpha=0.2, omega=3.07, d=0.0, sigma=-0.36, r=0.8, V=0.3), 2, 1.0),
    "two harmonics": (wave(0.56, 0.67, 2.11, -0.13, -0.11, 0.57, 0.24), 1, -1.0),
    "two harmonics, positive": (wave(0.28, 0.91, 1.72, 0.41, -0.02, 0.89, 0.37), 1, 1.0),
    "trigger": (trigger(0.26, 0.53, 3.17, -0.39, 0.57, 0.34, 0.33), 1, -1.0),
    "strongly damped trigger": (trigger(1.48, 0.87, 2.7, -0.02, 0.44, 0.13, 0.13), 1, -1.0),
}


@pytest.fixture(scope="module", params=SADDLES, ids=str)
def saddle(request):
    return one_impact_saddle(*SADDLES[request.param])


def rows_of(found):
    """The rows of points, without the breaks."""
    return np.flatnonzero(np.isfinite(found.manifold.values).all(axis=1))


def spelt(letters):
    """Counts of impacts as a word spells them."""
    return [{-1: "C", -2: "S"}.get(k, str(k) if k < 10 else f"({k})") for k in np.asarray(letters).tolist()]


def starts_of(found, rows):
    """The starts next to the saddle, from the table."""
    at = found.start.values[found.piece.values[rows]]
    return found.saddle.values[at] + found.seed.values[rows, None] * found.direction.values[at]


def distances(points, found):
    """Distance of points (n, 2) from the polylines."""
    curve = found.manifold.values
    a, b = curve[:-1], curve[1:]
    kept = np.isfinite(a + b).all(axis=1)
    a, b = a[kept], b[kept]
    along = b - a
    length = np.maximum((along**2).sum(axis=1), 1e-300)
    nearest = np.empty(len(points))
    for i, point in enumerate(points):
        share = np.clip(((point - a) * along).sum(axis=1) / length, 0.0, 1.0)
        nearest[i] = np.hypot(*(point - a - share[:, None] * along).T).min()
    return nearest


# ---- closed forms


@pytest.mark.parametrize("a, b, c", [(1.7, 0.4, 0.3), (-2.3, 0.5, 1.0), (1.05, -0.9, 0.2), (40.0, 1e-4, 3.0)])
def test_of_a_linear_map_they_are_straight_lines(a, b, c):
    P = made(linear, a=a, b=b, c=c)
    orbit = saddle_of(P, [[0.0, 0.0]])
    slow = np.array([c, b - a]) / np.hypot(c, b - a)
    for side, line, value in (("unstable", np.array([1.0, 0.0]), a), ("stable", slow, b)):
        found = manifolds(orbit, side, length=1.5 / 8.0)  # the box is twice as wide as the map's
        assert abs(found.direction.values[0] @ line) == pytest.approx(8.0, abs=1e-13)
        assert found.attrs["multiplier"] == pytest.approx(value, rel=1e-12)
        points = found.manifold.values[rows_of(found)]
        assert np.abs(points[:, 0] * line[1] - points[:, 1] * line[0]).max() < 1e-13
        assert found.branch_end.values.tolist() == ["length"] * 2
        assert found.branch_length.values == pytest.approx(1.5 / 8.0, abs=0.04 / 8.0)
        for sign in (1, -1):  # and nothing is left out of them
            run = np.sort(sign * points @ line)
            assert np.diff(run[run > -1e-9]).max() < 1.01 * 4 * np.sqrt(32) / 300 and run[-1] > 1.4
        assert not found.cut_first.values.any() and not found.cut_last.values.any()


def series_of(P, orbit, value, terms=40):
    """Coefficients (terms, 2) of the manifold's own parametrisation w(s) of Henon's map: P(w(s)) = w(value s)."""
    a, b = P.params["a"], P.params["b"]
    w = np.zeros((terms, 2))
    w[0] = orbit.points[0]
    J = P.jacobian(orbit.points[0])
    vector = np.array([J[0, 1], value - J[0, 0]])
    w[1] = vector / np.hypot(*(vector / (6.0, 2.0)))  # the sides of a box twice as wide as the map's
    for n in range(2, terms):
        square = sum(w[j, 0] * w[n - j, 0] for j in range(1, n))
        w[n] = np.linalg.solve(value**n * np.eye(2) - np.array([[-2 * a * w[0, 0], 1.0], [b, 0.0]]), [-a * square, 0.0])
    return w


@pytest.mark.parametrize("a, b", [(1.4, 0.3), (2.0, -0.3), (1.0, 0.6)])
@pytest.mark.parametrize("side", ["unstable", "stable"])
def test_of_henons_map_they_are_those_of_a_power_series(a, b, side):
    P = made(henon, box=((-1.5, 1.5), (-0.5, 0.5)), a=a, b=b)
    x = (b - 1.0 + np.sqrt((1.0 - b) ** 2 + 4.0 * a)) / (2.0 * a)
    orbit = saddle_of(P, [[x, b * x]])
    value = float(orbit.multipliers[0 if side == "unstable" else 1].real)
    found = manifolds(orbit, side, length=0.7, spacing=0.0033)
    series = series_of(P, orbit, value)
    rows = rows_of(found)
    points, order, seed = (
        found.manifold.values[rows],
        found.order.values[found.piece.values[rows]],
        found.seed.values[rows],
    )
    if float(series[1] @ found.direction.values[0]) < 0.0:
        seed = -seed
    # a point is w(s) with s = seed * value^n; from a smaller s, where the series is exact, n steps more lead there
    s = seed * value ** (order if side == "unstable" else -order)
    wanted = np.empty_like(points)
    for i, one in enumerate(s):
        steps = max(0, int(np.ceil(np.log(abs(one) / 0.003) / abs(np.log(abs(value)))))) if one else 0
        small = one * value ** (-steps if side == "unstable" else steps)
        state = np.polynomial.polynomial.polyval(small, series)
        for _ in range(steps):
            u, v = state
            state = np.array([1.0 - a * u * u + v, b * u]) if side == "unstable" else np.array(
                [v / b, u - 1.0 + a * (v / b) ** 2]
            )  # fmt: skip
        wanted[i] = state
    # the straight piece is off the curve by 1e-4 of 1e-6, which grows like the curve and shrinks across it
    assert np.abs(points - wanted).max() < 2e-3
    assert distances(wanted[:: len(wanted) // 40], found).max() < 1e-5
    # backwards Henon's map runs away to infinity
    assert set(found.branch_end.values) <= ({"length"} if side == "unstable" else {"length", "lost", "away"})
    assert float(found.branch_length.sum()) > (1.38 if side == "unstable" else 0.6)


def test_lozis_map_is_cut_where_it_has_its_kink():
    """Between cuts the unstable manifold is straight, and at a cut a state on the way lies on x = 0 to rounding."""
    P = made(lozi, letters="LR", a=1.7, b=0.5, box=((-1.5, 1.5), (-0.8, 0.8)))
    x = 1.0 / (1.0 + 1.7 - 0.5)
    orbit = saddle_of(P, [[x, 0.5 * x]], "R")
    found = manifolds(orbit, "unstable", length=3.0)
    ends = 0
    for number in range(found.sizes["piece"]):
        rows = np.flatnonzero((found.piece.values == number) & np.isfinite(found.seed.values))
        points, order = found.manifold.values[rows], int(found.order[number])
        chord = points[-1] - points[0]
        off = (points - points[0]) @ np.array([-chord[1], chord[0]]) / np.hypot(*chord)
        assert np.abs(off).max() < 1e-9  # the seeds' own rounding, stretched
        for end, cut in ((rows[0], found.cut_first), (rows[-1], found.cut_last)):
            if cut.values[number]:
                way = P.iterate(starts_of(found, [end])[0], order)
                assert np.abs(way[:-1, 0]).min() < 1e-9
                ends += 1
        assert len(found.word.values[number]) == order and set(found.word.values[number]) <= {"L", "R"}
    assert ends > 20
    # a kink is no jump: both sides of every cut end at one point
    ends = np.array([
        found.manifold.values[rows[side]]
        for number in range(found.sizes["piece"])
        for rows in [np.flatnonzero((found.piece.values == number) & np.isfinite(found.seed.values))]
        for side, cut in ((0, found.cut_first), (-1, found.cut_last)) if cut.values[number]
    ])  # fmt: skip
    apart = np.hypot(*(ends[:, None] - ends[None]).transpose(2, 0, 1)) + 9.0 * np.eye(len(ends))
    assert np.quantile(apart.min(axis=1), 0.9) < 1e-8


@pytest.mark.parametrize("lettered", [True, False])
def test_a_jump_is_no_line_even_if_the_map_writes_no_letters(lettered):
    step = broken if lettered else lambda state, p: broken(state, p)[0]
    if not lettered:

        def step(state, p):
            x, y = state
            return (1.0 - p.a * abs(x) + y - (p.l if x >= 0.0 else 0.0), p.b * x)

    P = made(step, letters="LR" if lettered else None, a=1.7, b=0.5, l=0.3, box=((-1.5, 1.5), (-0.8, 0.8)))
    x = (1.0 - 0.3) / (1.0 + 1.7 - 0.5)
    found = manifolds(saddle_of(P, [[x, 0.5 * x]], "R"), "unstable", length=1.5)
    curve = found.manifold.values
    steps = np.hypot(*(np.diff(curve, axis=0) / np.ptp(found.box.values, axis=1)).T)
    assert np.nanmax(steps) < 4.0 * json.loads(found.attrs["grazing_config"])["spacing"]
    # the two sides of the first cut are the jump apart
    rows = rows_of(found)
    images = np.array([P(point)[0] for point in curve[rows]])
    assert distances(images[found.order.values[found.piece.values[rows]] < 8], found).max() < 1e-3
    assert found.cut_last.values.any()


# ---- the oscillator


@pytest.mark.parametrize("side", ["unstable", "stable"])
def test_they_leave_the_saddle_along_its_eigenvectors(saddle, side):
    found = manifolds(saddle, side, length=0.015)
    value = saddle.multipliers[0 if side == "unstable" else 1].real
    P, p = saddle.map, saddle.period
    for j in range(p):
        J = np.eye(2)
        for k in range(p):
            J = P.jacobian(saddle.points[(j + k) % p]) @ J
        e = found.direction.values[j]
        assert np.abs(J @ e - value * e).max() < 1e-9 * np.abs(J).max()
    rows = rows_of(found)
    points, seed = found.manifold.values[rows], found.seed.values[rows]
    first = (found.order.values[found.piece.values[rows]] == 0) & (seed != 0.0)
    at = found.start.values[found.piece.values[rows]][first]
    away = (points[first] - found.saddle.values[at]) / seed[first, None]
    assert np.abs(away - found.direction.values[at]).max() < 1e-6


def test_every_point_is_what_the_map_makes_of_its_start(saddle):
    P = swift(saddle.map)  # at a cut decisions are left to rounding
    extent = np.ptp(np.concatenate([np.array(saddle.map.box).T, saddle.points]), axis=0)
    for side in ("unstable", "stable"):
        found = manifolds(saddle, side, length=0.6 / np.hypot(*extent) / np.sqrt(2.0))
        rows = rows_of(found)[::7]
        starts, pieces = starts_of(found, rows), found.piece.values[rows]
        for start, point, piece in zip(starts, found.manifold.values[rows], pieces, strict=True):
            order, word = int(found.order[piece]), str(found.word.values[piece])
            if side == "unstable":
                way = P.orbit(start, order)
                assert np.array_equal(way.points[-1], point)
                assert "".join(spelt(way.letters)) == word
            elif order:  # forwards errors along the unstable direction grow: step by step
                way = P.orbit(point, order)
                known = "".join(spelt(way.letters[: max(1, order // 2)]))
                assert known == word[: len(known)]
        assert (found.branch_length.values > 0.0).all()


def test_an_image_of_the_manifold_lies_on_it(saddle):
    """To a tolerance that shrinks with the spacing: the polyline's own error."""
    P, worst = saddle.map, []
    whole = manifolds(saddle, "unstable", length=0.3)
    rows = rows_of(whole)
    kept = rows[whole.order.values[whole.piece.values[rows]] <= np.quantile(whole.order.values, 0.5)][::5]
    images = np.array([P(point)[0] for point in whole.manifold.values[kept]])
    frame = np.array(whole.attrs["box"]).reshape(2, 2)
    images = images[((images > frame[:, 0]) & (images < frame[:, 1])).all(axis=1)]
    diagonal = float(np.hypot(*(frame[:, 1] - frame[:, 0])))
    for part in (50, 1600):
        found = manifolds(saddle, "unstable", length=0.9, spacing=np.sqrt(2.0) / part)
        worst.append(float(np.quantile(distances(images, found), 0.95)))
    assert worst[0] < 1e-3 * diagonal and worst[1] < max(0.1 * worst[0], 1e-9)


def test_points_of_the_unstable_manifold_come_from_the_saddle(saddle):
    """Flown back from contact to contact, an algorithm of its own, they pass the states nearer to it."""
    found = manifolds(saddle, "unstable", length=0.15)
    rows = rows_of(found)
    order = found.order.values[found.piece.values[rows]]
    size = float(np.abs(saddle.points).max())
    # errors grow backwards as much as they shrink forwards
    most = int(saddle.period * np.log(1e9) / -np.log(np.abs(saddle.multipliers[1])))
    away = []
    for n in np.unique(order[order >= 3]):
        k = min(int(n), max(1, most))
        some = rows[order == n]
        for row in some[:: max(1, len(some) // 4)]:
            point, start = found.manifold.values[row], starts_of(found, [row])[0]
            back = traced(Backwards(saddle.map, Ray(point, np.zeros(2)), size), np.zeros(1), np.zeros(1), k)
            if len(back):
                before = saddle.map.iterate(start, int(n) - k)[-1]
                away.append(float(np.abs(back.state - before).max(axis=1).min()) / size)
    # not all of them: behind many impacts in a period, as of a trigger's saddle, known states are met to 3e-4 only
    assert len(away) > 20 and np.quantile(away, 0.7) < 1e-6


def test_at_a_cut_the_ball_grazes_or_meets_the_strobe_on_its_way():
    """The start next to a cut is that of an orbit with a miss, or an impact, as near to none as rounding allows."""
    saddle = one_impact_saddle(gz.pinball(d=0.105, V=0.4), 2, -1.0)
    found = manifolds(saddle, "unstable", length=0.2)
    seen = 0
    for number in range(found.sizes["piece"]):
        rows = np.flatnonzero((found.piece.values == number) & np.isfinite(found.seed.values))
        for row, cut in ((rows[0], found.cut_first), (rows[-1], found.cut_last)):
            if cut.values[number]:
                way = saddle.map.orbit(starts_of(found, [row])[0], int(found.order[number]))
                assert min(way.near_miss, way.slowest**2) < 1e-6
                seen += 1
    assert seen >= 4


@pytest.mark.parametrize("tag", ["between period 1 and 2", "between period 1 and 3", "below the origin"])
def test_the_stable_manifold_bounds_basins(tag):
    """A little to one side of it and to the other, orbits come to different attractors."""
    saddle = one_impact_saddle(*SADDLES[tag])
    found = manifolds(saddle, "stable", length=0.3)
    curve = found.manifold.values
    steps = np.diff(curve, axis=0)
    inner = np.flatnonzero(np.isfinite(steps).all(axis=1) & (np.hypot(*steps.T) > 1e-4))[::3]
    across = np.column_stack([-steps[inner, 1], steps[inner, 0]]) / np.hypot(*steps[inner].T)[:, None]
    above = (curve[inner, 0] > saddle.model.sigma + 1e-3) & (curve[inner, 1] < 0.9 * np.nanmax(curve[:, 1]))
    words = []
    for side in (1e-7, -1e-7):
        lanes = (curve[inner] + side * across)[above].T.copy()
        _points, letters, _outcomes = saddle.map.run(lanes, 600, 6)
        words.append(letters.sum(axis=0))
    differ = words[0] != words[1]
    assert len(differ) > 60 and differ.mean() > 0.97
    assert {0, 6 // saddle.period} <= {int(n) for pair in words for n in pair}


def test_newtons_method_finds_what_flying_back_finds():
    """Two ways to the stable manifold: of the map without its model preimages are solved for."""
    saddle = one_impact_saddle(LIGHT, 2, 1.0)
    blind = dataclasses.replace(saddle, map=changed_origin(saddle.map, section=None))
    box = ((0.05, 1.0), (0.3, 1.8))
    flown = manifolds(saddle, "stable", length=0.8, box=box)
    solved = manifolds(blind, "stable", length=0.8, box=box, spacing=0.02)
    points = solved.manifold.values[rows_of(solved)]
    assert len(points) > 60 and float(solved.branch_length.sum()) > 0.8
    inside = ((points > np.array(box)[:, 0]) & (points < np.array(box)[:, 1])).all(axis=1)
    assert np.quantile(distances(points[inside], flown), 0.98) < 1e-5


def test_points_go_on_from_where_they_are():
    """In a + b steps from the saddle they come to what b steps make of them after a: nothing is grown again."""
    saddle = one_impact_saddle(LIGHT, 2, 1.0)
    t = np.linspace(0.0, 1.0, 9)
    unstable, stable = (
        Ray(saddle.points[0], side_of(saddle, side, np.ones(2)).directions[0]) for side in ("unstable", "stable")
    )
    for steps in (Forwards(saddle.map, unstable), Backwards(saddle.map, stable, 2.0)):
        here = traced(steps, t, 1e-3 * t, 4)
        for found, wanted in ((steps.further(here, 3), traced(steps, t, 1e-3 * t, 7)), (steps.further(here, 0), here)):
            assert len(found) == len(wanted) > 4
            for name in ("t", "seed", "code", "state", "letters"):
                assert np.array_equal(getattr(found, name), getattr(wanted, name)), name


def test_an_image_of_the_short_piece_begins_with_the_one_before(monkeypatch):
    """Or the work would grow like the square of the steps."""
    flown, plain = [], manifold_steps.stepped

    def counted(P, state, n):
        flown.append(len(state) * n)
        return plain(P, state, n)

    monkeypatch.setattr(manifold_steps, "stepped", counted)
    saddle = one_impact_saddle(*SADDLES["passive"])
    found = manifolds(saddle, "unstable", length=0.3)
    assert found.order.values.max() > 50 and sum(flown) < 4 * found.order.values.sum()


def test_a_branch_that_comes_to_an_attractor_is_ended_there():
    saddle = one_impact_saddle(*SADDLES["below the origin"])
    found = manifolds(saddle, "unstable", length=100.0)
    assert set(found.branch_end.values) == {"settled"}
    ends = [np.flatnonzero(found.branch.values == b)[-1] for b in range(found.sizes["branch"])]
    last = [found.manifold.values[np.flatnonzero(found.piece.values == n)[0]] for n in ends]
    later = saddle.map.run(np.array(last).T.copy(), 0, 2)[0]
    assert np.abs(later[1].T - np.array(last)).max() < 0.05  # period 2, or 1


def test_steps_end_a_branch_too():
    saddle = one_impact_saddle(LIGHT, 2, 1.0)
    found = manifolds(saddle, "unstable", steps=6)
    assert found.order.values.max() <= 6 and set(found.branch_end.values) == {"steps"}


# ---- conditions


def test_the_condition_is_how_far_an_orbit_moves_per_unit_of_error(saddle):
    """A small push in every turn moves the fixed point of the turned map by the condition, in the worst direction."""
    P, p, x = saddle.map, saddle.period, saddle.points[0]
    J = np.eye(2)
    for point in saddle.points:
        J = P.jacobian(point) @ J
    moved = []
    for angle in np.linspace(0.0, np.pi, 61):  # the worst lies within 1.5 degrees of one: off by 4e-4
        push = 1e-9 * np.array([np.cos(angle), np.sin(angle)])
        y = x + np.linalg.solve(np.eye(2) - J, push)
        for _ in range(3):  # Newton on P^p(y) + push = y
            y = y + np.linalg.solve(np.eye(2) - J, P.iterate(y, p)[-1] + push - y)
        moved.append(float(np.hypot(*(y - x))) / 1e-9)
    assert max(moved) == pytest.approx(saddle.condition, rel=2e-3)


@pytest.mark.parametrize("tag", [tag for tag in MODELS if tag not in ("own law",)])
def test_the_condition_is_finite_away_from_folds_and_at_least_the_nearest_multiplier_says(tag):
    for N in (1, 2, 3):
        for orbit in gz.one_impact_orbits(MODELS[tag], N):
            nearest = np.abs(1.0 - orbit.multipliers).min()
            assert orbit.condition >= (1.0 - 1e-9) / nearest > 0.0


def test_the_condition_grows_like_the_inverse_of_the_distance_to_one():
    edge = float(gz.windows(LIGHT, "omega", 2, (3.0, 3.5), 300).low[0])
    sizes = []
    for away in (1e-4, 1e-6, 1e-8):
        orbits = gz.one_impact_orbits(LIGHT.replace(omega=edge + away), 2)
        worst = max(orbits, key=lambda orbit: orbit.condition)
        sizes.append(worst.condition * float(np.abs(1.0 - worst.multipliers).min()))
    assert max(sizes) < 50.0 * min(sizes)


# ---- messages


def test_what_is_no_saddle_is_refused():
    stable = one_impact_saddle(gz.pinball(d=0.105, V=0.4), 2, -1.0)
    P = stable.map
    [node] = [orbit for orbit in gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3) if orbit.admissible]
    with pytest.raises(gz.InputError, match=r"no saddle: one multiplier"):
        manifolds(node, "unstable")
    with pytest.raises(gz.InputError, match="virtual"):
        manifolds(dataclasses.replace(stable, admissible=False))
    with pytest.raises(gz.InputError, match=r"give a gz.Orbit"):
        manifolds(P)
    with pytest.raises(gz.InputError, match="allowed are 'unstable' and 'stable'"):
        manifolds(stable, "both")
    with pytest.raises(gz.InputError, match="allowed are 'unstable' and 'stable'"):
        manifolds(stable, np.array([None, 1.0]))
    with pytest.raises(gz.InputError, match="allowed is a number > 0"):
        manifolds(stable, length=0.0)
    with pytest.raises(gz.InputError, match="spacing"):
        manifolds(stable, spacing=float("nan"))
    with pytest.raises(gz.InputError, match="steps"):
        manifolds(stable, steps=0)
    with pytest.raises(gz.InputError, match="box"):
        manifolds(stable, box=((1.0, 0.0), (0.0, 1.0)))


def test_maps_of_another_dimension_and_without_inverse_are_refused():
    G = gz.gap_map(lam=0.5, mu=0.2, l=0.1)
    one = Orbit(
        map=G, points=np.zeros((1, 1)), word="L", period=1, multipliers=np.array([2.0 + 0j]), admissible=True,
        condition=1.0, residual=0.0,
    )  # fmt: skip
    with pytest.raises(gz.InputError, match="manifolds need two"):
        manifolds(one)
    P = made(linear, a=2.0, b=0.0, c=1.0)
    flat = saddle_of(P, [[0.0, 0.0]])
    with pytest.raises(gz.InputError, match="no inverse"):
        manifolds(flat, "stable")
    assert manifolds(flat, "unstable", length=0.1).branch_end.values.tolist() == ["length"] * 2
