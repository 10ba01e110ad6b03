"""Kernels in a browser's machine code against the same studies in Python, bit for bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import grazing as gz
from grazing import theory
from grazing.explorer.gap import part_of
from grazing.explorer.oscillator import LAWS
from grazing.maps.discontinuity import ORDERS
from grazing.studies.basins import basins
from grazing.studies.chart import chart
from grazing.studies.classify import TOLERANCE, classify
from grazing.studies.density import density
from grazing.studies.density import raster as count_in_raster
from grazing.studies.starts import random_starts
from tests.explorer.machine import classes, draw, fields_of, orbits, raster, row_of
from tests.explorer.models import CASES, MORE_CASES


def rows_of(described, model, phase, name, values, order=0.0):
    rows = np.empty((len(values), len(described["fields"])))
    for i, value in enumerate(values):
        changed = model.replace(**{name: value}) if name != "phase" else model
        own = {**changed.params, "phase": phase, "paper": float(model.paper)}
        rows[i] = row_of(described, model.reset.name, order=order, **own)
    return rows


# ---- starts


@pytest.mark.parametrize("seed", [0, 1, 2**53 - 1])
@pytest.mark.parametrize("axes", [1, 2, 3])
def test_starts_are_those_of_python(machines, seed, axes):
    names = np.random.default_rng(seed).normal(size=(5, axes))
    names[0] = -0.0
    boxes = np.array([[[-1.0, 2.0], [0.5, 0.75]], *([[[-0.1, 0.1], [-3.0, 7.0]]] * 4)])
    found = draw(machines["oscillator"], 2, np.empty((5, 0)), names, 7, seed, boxes)
    np.testing.assert_array_equal(found, random_starts(seed, names, 7, boxes))


@pytest.mark.parametrize("case", MORE_CASES)
def test_boxes_are_those_of_the_map(machines, described, case):
    model, phase, name, ends = MORE_CASES[case]
    rows = rows_of(described["oscillator"], model, phase, name, ends)
    boxes = np.empty((2, 2, 2))
    machines["oscillator"].call("boxes", columns=2, rows=rows, boxes=boxes)
    for box, value in zip(boxes, ends, strict=True):
        assert box.tolist() == [list(pair) for pair in gz.stroboscopic_map(model.replace(**{name: value}), phase).box]


# ---- rasters


@pytest.mark.parametrize(
    ("params", "name", "ends", "range_", "bins", "starts", "transient", "keep"),
    [
        ((0.8, 0.1, 0.05), "mu", (-0.01, 0.3), (-0.8, 0.31), 33, 7, 40, 70),
        ((0.5, 0.1, 0.1), "mu", (-0.05, 0.4), (-1.0, 0.5), 600, 1, 0, 333),
        ((0.9, 0.1, 0.0), "l", (0.0, 1.5), (-1.7, 0.2), 101, 130, 11, 32),
        ((0.3, 0.2, 0.4), "lam", (-1.2, 1.2), (-2.0, 0.3), 64, 64, 5, 65),
        ((60.0, -0.1, 0.1), "mu", (-0.2, 0.2), (-2.0, 0.3), 50, 3, 120, 100),  # orbits that leave for infinity
        ((0.5, 0.0, 0.0), "l", (0.0, 0.2), (-1.0, 0.3), 40, 5, 2000, 30),  # orbits that reach x = 0 itself
    ],
)
def test_raster_of_the_gap_map(machines, params, name, ends, range_, bins, starts, transient, keep):
    G = gz.gap_map(*params)
    values = np.linspace(*ends, 41)
    settings = {"bins": bins, "range": range_, "starts": starts, "transient": transient, "keep": keep, "seed": 5}
    want = density(G, name, values, arithmetic="strict", **settings)
    rows = np.array([list(G.replace(**{name: value}).params.values()) for value in values])
    lanes = draw(machines["gap"], 1, rows, values, starts, 5)
    counts, ended, ambiguous = raster(machines["gap"], rows, lanes, transient, keep, 0, *range_, bins)
    np.testing.assert_array_equal(counts[:, 1:-2], want["count"])
    np.testing.assert_array_equal(counts[:, 0], want["below"])
    np.testing.assert_array_equal(counts[:, -2], want["above"])
    np.testing.assert_array_equal(ended, want["ended"])
    np.testing.assert_array_equal(ambiguous, want["ambiguous"])
    assert np.any(ended > 0) == (params[0] > 1.0) and np.any(ambiguous > 0) == (params[1] == 0.0)


@given(
    st.lists(st.floats() | st.floats(-1.5, 1.5), min_size=1, max_size=20), st.floats(-1.0, 0.9),
    st.floats(1e-3, 2.0) | st.sampled_from([1.0, 0.1]), st.integers(1, 1000),
)  # fmt: skip
def test_parts_are_those_of_a_density(points, low, width, bins):
    high = low + width
    points = [*points, low, high, np.nextafter(low, -2.0), np.nextafter(high, 4.0), np.nextafter(high, -2.0)]
    counts, expected = np.zeros((1, bins + 3), np.int64), np.zeros((1, bins + 3), np.int64)
    count_in_raster(np.array(points).reshape(1, -1, 1, 1), 0, low, high, bins, expected)
    for x in points:
        counts[0, part_of(x, low, high, bins / (high - low), bins)] += 1
    assert counts.tolist() == expected.tolist()


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("coordinate", ["u", "v"])
def test_raster_of_the_oscillator(machines, described, case, coordinate):
    model, phase, name, ends = CASES[case]
    P = gz.stroboscopic_map(model, phase)
    values = np.linspace(*ends, 12)
    i = P.coordinates.index(coordinate)
    settings = {"bins": 200, "starts": 9, "transient": 30, "keep": 40, "seed": 3, "coordinate": coordinate}
    want = density(P, name, values, arithmetic="strict", **settings)
    low, high = want[coordinate].attrs["low"], want[coordinate].attrs["high"]
    rows = rows_of(described["oscillator"], model, phase, name, values)
    lanes = draw(machines["oscillator"], 2, rows, values, 9, 3)
    counts, ended, ambiguous = raster(machines["oscillator"], rows, lanes, 30, 40, i, low, high, 200)
    sure = ambiguous == 0  # elsewhere Python decides in ball arithmetic
    assert sure.sum() >= 10
    np.testing.assert_array_equal(counts[sure, 1:-2], want["count"].values[sure])
    np.testing.assert_array_equal(counts[sure, 0], want["below"].values[sure])
    np.testing.assert_array_equal(ended[sure], want["ended"].values[sure])


def test_columns_do_not_depend_on_their_company(machines):
    values = np.linspace(0.0, 0.3, 30)
    rows = np.column_stack([np.full(30, 0.7), values, np.full(30, 0.1)])
    lanes = draw(machines["gap"], 1, rows, values, 6, 2)
    whole = raster(machines["gap"], rows, lanes, 20, 50, 0, -1.0, 0.4, 80)[0]
    halves = slice(0, 7), slice(7, 30)
    parts = [raster(machines["gap"], rows[q], lanes[q], 20, 50, 0, -1.0, 0.4, 80)[0] for q in halves]
    np.testing.assert_array_equal(whole, np.concatenate(parts))


# ---- orbits and classes


def followed(P, states, steps):
    """Orbits of a map in plain Python: points (steps, dim, n), letters and folded outcomes."""
    kind, row = P.packed()
    c = P.prepare(kind(*row.tolist()))
    points, letters = np.empty((steps, P.dimension, states.shape[1])), np.empty((steps, states.shape[1]), int)
    outcomes = np.zeros(states.shape[1], int)
    for j, state in enumerate(states.T.tolist()):
        for n in range(steps):
            state, letters[n, j], outcome = P.step(tuple(state), c)
            points[n, :, j] = state
            outcomes[j] |= outcome
    return points, letters, outcomes


@pytest.mark.parametrize("case", CASES)
def test_orbits_of_the_stroboscopic_map(machines, described, case):
    model, phase, name, ends = CASES[case]
    values = np.linspace(*ends, 3)
    rows = rows_of(described["oscillator"], model, phase, name, values)
    lanes = draw(machines["oscillator"], 2, rows, values, 4, 1)
    points, letters, outcomes = orbits(machines["oscillator"], rows, lanes, 3, 9)
    for q, value in enumerate(values):
        P = gz.stroboscopic_map(model.replace(**{name: value}), phase)
        want = followed(P, lanes[q], 12)
        np.testing.assert_array_equal(points[q], want[0][3:])
        np.testing.assert_array_equal(letters[q], want[1][3:])
        np.testing.assert_array_equal(outcomes[q, 0], want[2])


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("case", CASES)
def test_orbits_of_the_discontinuity_map(machines, described, case, order):
    model, phase, name, ends = CASES[case]
    rows = rows_of(described["oscillator"], model, phase, name, ends, ORDERS.index(order))
    lanes = np.random.default_rng(4).uniform(-0.3, 0.3, (2, 2, 6))
    points, letters, outcomes = orbits(machines["oscillator"], rows, lanes, 0, 4, "orbits_local")
    for q, value in enumerate(ends):
        want = followed(gz.discontinuity_map(model.replace(**{name: value}), order, phase), lanes[q], 4)
        np.testing.assert_array_equal(points[q], want[0])
        np.testing.assert_array_equal(letters[q], want[1])
        np.testing.assert_array_equal(outcomes[q, 0], want[2])


@pytest.mark.parametrize("case", CASES)
def test_periods_and_words_of_the_oscillator(machines, described, case):
    model, phase, name, ends = CASES[case]
    values = np.linspace(*ends, 6)
    machine = machines["oscillator"]
    rows = rows_of(described["oscillator"], model, phase, name, values)
    lanes = draw(machine, 2, rows, values, 6, 1)
    points, letters, outcomes = orbits(machine, rows, lanes, 200, 48)
    period, key, _begin, length, _count, _first = classes(machine, rows, points, letters, outcomes, TOLERANCE)
    spelled = {}
    for q, value in enumerate(values):
        P = gz.stroboscopic_map(model.replace(**{name: value}), phase)
        want = classify(P, points[q], letters[q].astype(np.int64), outcomes[q, 0].astype(np.int64))
        np.testing.assert_array_equal(period[q], want.period)
        assert ((length[q] > 0) == (want.word != "")).all()
        for one, text in zip(key[q].tolist(), want.word.tolist(), strict=True):
            assert spelled.setdefault(one, text) == text
    assert len(set(spelled.values())) == len(spelled)


@pytest.mark.parametrize(("lam", "l"), [(0.8, 0.05), (0.5, 0.1), (0.9, 0.6), (0.3, 0.0)])
def test_a_chart_of_the_gap_map(machines, lam, l):
    mus = np.linspace(0.0, 0.5, 40)
    want = chart(gz.gap_map(lam, 0.1, l), {"mu": mus, "l": [l, l + 0.1]}, seed=7, arithmetic="strict")
    cells = np.array([(mu, gap) for mu in mus for gap in (l, l + 0.1)])
    rows = np.column_stack([np.full(len(cells), lam), cells])
    lanes = draw(machines["gap"], 1, rows, cells, 8, 7)
    points, letters, outcomes = orbits(machines["gap"], rows, lanes, 500, 64)
    period, _key, _begin, length, count, first = classes(machines["gap"], rows, points, letters, outcomes, TOLERANCE)
    ranked = np.where(count > 0, np.take_along_axis(period, first, 1), -3)
    wanted = want["period"].values.reshape(ranked.shape)
    # a chart measures the exponent of an orbit without a period, and calls it undecided where that is negative
    np.testing.assert_array_equal(np.where(ranked == -1, wanted, ranked), wanted)
    assert set(wanted[ranked == -1].tolist()) <= {-1, 0}
    np.testing.assert_array_equal(count / 8, want["share"].values.reshape(ranked.shape))
    named = np.where(count > 0, np.take_along_axis(length, first, 1), 0)
    np.testing.assert_array_equal(named > 0, want["word"].values.reshape(ranked.shape) != "")
    assert len(set(wanted[wanted > 0].tolist())) > 2


@pytest.mark.parametrize("case", ["standard set", "triggered"])
def test_basins_of_the_oscillator(machines, described, case):
    model, phase, _name, _ends = CASES[case]
    P = gz.stroboscopic_map(model, phase)
    grid = {"u": np.linspace(*P.box[0], 8), "v": np.linspace(*P.box[1], 9)}
    want = basins(P, grid, transient=300, arithmetic="strict", preimages=0)
    states = np.array([(u, v) for u in grid["u"] for v in grid["v"]])
    row = row_of(described["oscillator"], model.reset.name, **P.params, paper=float(model.paper))[None]
    machine = machines["oscillator"]
    points, letters, outcomes = orbits(machine, row, np.ascontiguousarray(states.T[None]), 300, 64)
    period, key, begin, length, *_rest = classes(machine, row, points, letters, outcomes, TOLERANCE)
    basin = want["basin"].values.ravel()
    np.testing.assert_array_equal(period[0], want["period"].values[basin])
    extent = np.array([max(np.ptp(grid[x]), high - low) for x, (low, high) in zip("uv", P.box, strict=True)])
    label = np.empty((1, len(states)), np.int32)
    machine.call(
        "attractors", columns=1, starts=len(states), keep=64, points=points, period=period, key=key, begin=begin,
        length=length, same=1e-6 * extent, label=label,
    )  # fmt: skip
    pairs = set(zip(label[0].tolist(), basin.tolist(), strict=True))
    assert len(pairs) == len(set(basin.tolist())) == len(set(label[0].tolist()))  # the same parts of the grid


# ---- the ball in flight


@pytest.mark.parametrize("case", ["standard set", "two harmonics, kick", "free ball that falls, chatter", "triggered"])
def test_the_flight_of_the_ball(machines, described, case):
    model, phase, name, ends = CASES[case]
    model = model.replace(**{name: 0.3 * ends[0] + 0.7 * ends[1]})
    T, periods = model.period, 3
    start = (model.sigma + 0.05, 0.1)
    row = row_of(described["oscillator"], model.reset.name, **model.params, phase=phase)
    state = np.array([0.0, 0.0, start[0] - model.sigma, start[1], 0.0, 0.0, 0.0, 0.0])
    legs = np.zeros((400, 11))
    machine = machines["oscillator"]
    count = machine.call("legs", capacity=400, row=row, state=state, legs=legs, until=periods * T, patience=1e-6)
    legs = legs[:count].copy()
    want = gz.trajectory(model, start, phase, phase + periods * T, samples=37)
    hits = ~np.isnan(legs[:, 5])
    times = legs[hits, 0] * T + legs[hits, 4]
    inside = times <= periods * T
    np.testing.assert_array_equal(legs[hits, 5][inside], want["v_minus"])
    np.testing.assert_array_equal(legs[hits, 6][inside], want["v_plus"])
    np.testing.assert_allclose(phase + times[inside], want["impact_time"], rtol=1e-15)
    # the flight between: the trajectory's own points, away from jumps and from rounding of absolute time
    t = np.linspace(0.0, periods * T, 301)
    u, v = np.empty_like(t), np.empty_like(t)
    machine.call("sample", count=count, samples=len(t), row=row, legs=legs, times=t, u=u, v=v)
    away = np.abs(t[:, None] - np.concatenate([times, [-1.0]])).min(axis=1) > 1e-3
    own = gz.trajectory(model, start, phase, phase + periods * T, samples=4000)
    np.testing.assert_allclose(u[away], np.interp(phase + t[away], own["t"], own["u"]), atol=2e-5)
    np.testing.assert_allclose(v[away], np.interp(phase + t[away], own["t"], own["v"]), atol=2e-3)
    assert (u >= model.sigma).all()
    if state[0] == periods:  # and at the last strobe the state of the stroboscopic map, to the bit
        P = gz.stroboscopic_map(model, phase)
        np.testing.assert_array_equal((state[2] + model.sigma, state[3]), P.iterate(start, periods)[-1])


# ---- two walls, and walls that move


def between(law, other, sigma, high, motion=None, **params):
    """A model between two walls, or at one where there is no place of the other."""
    given = {"alpha": 0.3, "k": 1.0, "omega": 1.7, "t0": 0.2, "offset": 0.1, "cos": 1.0, "sin": 0.2, **params}
    # as many harmonics as the module has: rounding between walls knows how many there are
    waves = (given["cos"], 0.0, 0.2 * given["cos"]), (given["sin"], 0.0, 0.5 * given["sin"])
    forcing = gz.Forcing(given["omega"], given["t0"], given["offset"], *waves)
    wave = None if motion is None else gz.Forcing(given["omega"], given["t0"], cos=motion[:1], sin=motion[1:])
    walls = [gz.wall(sigma, law, motion=wave)]
    if high is not None:
        walls.append(gz.wall(high, other, side="above", motion=wave))
    return gz.Oscillator(given["alpha"], given["k"], forcing=forcing, walls=walls)


#: (model, phase, parameter, values)
WALLED = {
    "impact pair": (between(gz.newton(0.7), gz.newton(0.9), -0.4, 0.6), 0.0, "omega", (1.2, 2.4)),
    "two kicks": (between(gz.active(0.6, 0.3), gz.active(0.8, 0.1), -0.2, 0.9, alpha=1.0), 0.7, "A.V", (0.0, 0.5)),
    "shaken box": (between(gz.newton(0.8), gz.newton(0.8), -0.5, 0.5, (0.1, 0.3), cos=0.0, sin=0.0, k=0.0,
                           offset=-0.4), 0.3, "B.r", (0.3, 1.0)),
    "moving table": (between(gz.newton(0.5), None, 0.0, None, (0.2, 0.3), cos=0.0, sin=0.0, k=0.0, offset=-1.0),
                     0.0, "r", (0.1, 0.8)),
    "chatter at both": (between(gz.triggered(0.4, 0.5, 0.6), gz.triggered(0.3, 0.4, 0.7), -0.1, 0.1, omega=0.3), 0.0,
                        "offset", (-0.5, 0.5)),
}  # fmt: skip


def walled_rows(described, model, phase, name, values):
    """Rows of the module for a model with walls."""
    two = len(model.walls) > 1
    rows = np.empty((len(values), len(described["fields"])))
    for i, value in enumerate(values):
        given = dict(model.replace(**{name: value}).params)
        own = {"cos_A": given.pop("A.cos1", 0.0), "sin_A": given.pop("A.sin1", 0.0), "two": float(two), "phase": phase}
        for key, number in given.items():
            wall, _dot, last = key.rpartition(".")
            if last[:3] not in ("cos", "sin") or not wall:
                own[f"{last}_B" if wall == "B" else last] = number
        rows[i] = row_of(described, model.walls[0].law.name, **own)
    return rows


@pytest.mark.parametrize("case", WALLED)
def test_raster_between_walls(machines, described, case):
    model, phase, name, ends = WALLED[case]
    P, values = gz.stroboscopic_map(model, phase), np.linspace(*ends, 7)
    want = density(P, name, values, arithmetic="strict", bins=150, starts=6, transient=20, keep=30, seed=3)
    rows = walled_rows(described["oscillator"], model, phase, name, values)
    lanes = draw(machines["oscillator"], 2, rows, values, 6, 3)
    low, high = want["u"].attrs["low"], want["u"].attrs["high"]
    counts, ended, ambiguous = raster(machines["oscillator"], rows, lanes, 20, 30, 0, low, high, 150)
    sure = ambiguous == 0  # elsewhere Python decides in ball arithmetic
    assert sure.sum() >= 5
    np.testing.assert_array_equal(counts[sure, 1:-2], want["count"].values[sure])
    np.testing.assert_array_equal(ended[sure], want["ended"].values[sure])


@pytest.mark.parametrize("case", WALLED)
def test_the_flight_between_walls(machines, described, case):
    model, phase, name, ends = WALLED[case]
    T, periods = model.period, 3
    row = walled_rows(described["oscillator"], model, phase, name, [0.4 * ends[0] + 0.6 * ends[1]])[0]
    model = model.replace(**{name: 0.4 * ends[0] + 0.6 * ends[1]})
    start = (float(model.places_at(np.array([phase]))[0][0, 0]) + 0.05, 0.1)
    state, legs = np.array([0.0, 0.0, *start, 0.0, 0.0, 0.0, 0.0]), np.zeros((400, 11))
    machine = machines["oscillator"]
    count = machine.call("legs", capacity=400, row=row, state=state, legs=legs, until=periods * T, patience=1e-6)
    legs = legs[:count].copy()
    want = gz.trajectory(model, start, phase, phase + periods * T, samples=4000)
    hits = ~np.isnan(legs[:, 5]) & (legs[:, 0] * T + legs[:, 4] <= periods * T)
    np.testing.assert_array_equal(-legs[hits, 5], want["impact_speed"])
    assert ["AB"[int(wall)] for wall in legs[hits, 10]] == want["impact_wall"].values.tolist()
    t = np.linspace(0.0, periods * T, 301)
    u, v = np.empty_like(t), np.empty_like(t)
    machine.call("sample", count=count, samples=len(t), row=row, legs=legs, times=t, u=u, v=v)
    at = legs[hits, 0] * T + legs[hits, 4]
    away = np.abs(t[:, None] - np.concatenate([at, [-1.0]])).min(axis=1) > 2e-3
    np.testing.assert_allclose(u[away], np.interp(phase + t[away], want["t"], want["u"]), atol=2e-5)
    np.testing.assert_allclose(v[away], np.interp(phase + t[away], want["t"], want["v"]), atol=2e-3)


# ---- theory and reduction


@pytest.mark.parametrize("lam", [0.05, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("l", [0.0, 0.1, 2.0])
def test_edges_of_theory(machines, lam, l):
    table = np.empty((12, 3))
    machines["gap"].call("edges", periods=12, lam=lam, l=l, table=table)
    N = np.arange(1, 13)
    want = np.column_stack([theory.mu_gr(N, lam, l), theory.mu_pd(N, lam, l), theory.mu_bc(N, lam, l)])
    np.testing.assert_allclose(table, want, rtol=2e-14, atol=0.0)


@pytest.mark.parametrize(
    ("case", "name"),
    [
        ("standard set", "d"),
        ("standard set", "omega"),
        ("passive, wall moved", "offset"),
        ("passive, wall moved", "sigma"),
        ("lightly damped, two harmonics", "offset"),
        ("three harmonics, kick", "sigma"),
        ("standard set", "cos1"),
        ("lightly damped, two harmonics", "omega"),
        ("overdamped, strong kick", "d"),
    ],
)
def test_the_normal_form(machines, described, case, name):
    model, phase, _name, _ends = MORE_CASES[case]
    name = "d" if name == "offset" and "d" in model.params else name
    nf = gz.normal_form(model, name)
    fields = fields_of(described["oscillator"])
    which = fields.index("offset" if name == "d" else name)
    row = row_of(described["oscillator"], model.reset.name, **model.params, phase=phase)
    known = described["oscillator"]["fields"][which]
    now = model.params[name]
    far = 1e3 * max(1.0, abs(now))
    low = known["low"] if known["low"] is not None else now - far
    high = known["high"] if known["high"] is not None else now + far
    found = machines["oscillator"].call("graze", row=row, which=which, low=low, high=high, open_low=known["open_low"])
    assert found == nf.graze
    row[which] = found
    numbers = np.empty(13)
    machines["oscillator"].call("reduce", row=row, numbers=numbers)
    want = [nf.time, nf.acceleration, nf.lam, nf.l, nf.b, nf.det, nf.scale, nf.r, nf.V]
    np.testing.assert_array_equal(numbers[:9], want)
    values = found + np.array([-1e-2, 0.0, 3e-3])
    heights = np.empty(3)
    machines["oscillator"].call("clearance", count=3, row=row, which=which, values=values, heights=heights)
    np.testing.assert_array_equal(numbers[12] * heights, nf.mu(values))


def test_without_a_steady_response_there_is_no_graze(machines, described):
    model = CASES["resonance, no steady response"][0]
    row = row_of(described["oscillator"], model.reset.name, **model.params)
    found = machines["oscillator"].call("graze", row=row, which=4, low=-1.0, high=1.0, open_low=0)
    assert np.isnan(found)


# ---- what the page reads


def test_modules_import_nothing(machines):
    assert [machine.imports for machine in machines.values()] == [[], [], []]


def test_fields_are_described_as_in_python(described):
    from grazing.oscillator.parameters import damped, describe_parameter

    fields = {field["name"]: field for field in described["oscillator"]["fields"]}
    assert fields["law"]["choices"] == list(LAWS)
    for name in ("alpha", "omega", "r", "V", "sigma", "sin3", "phase"):
        known = damped(describe_parameter(name))  # the page knows no negative damping
        assert (fields[name]["meaning"], fields[name]["symbol"]) == (known.meaning, known.symbol)
        assert fields[name]["low"] == (known.low if np.isfinite(known.low) else None)
