"""The orbits behind all studies: cells, starts, boxes that move, and what an input may be."""

import numpy as np
import pytest

import grazing as gz
from grazing.maps.ensemble import padded
from grazing.maps.pieces import joined
from grazing.oscillator.workspace import LANES
from grazing.studies.runs import FEW, MANY, TOGETHER, Settings, checked_runs, checked_values, describe_values
from grazing.studies.starts import random_starts
from tests.studies.maps import FOLLOWER

GAP = gz.gap_map(0.5, 0.1, 0.1)
BALL = gz.stroboscopic_map(gz.pinball(V=0.4))


def runs_of(P, axes, starts=4, transient=30, keep=10, seed=0, arithmetic="fast", box=None, taken=()):
    return checked_runs(P, axes, starts, transient, keep, seed, arithmetic, box, taken)


AXES = {
    "gap map": (GAP, {"mu": [0.1, -0.05, 0.3], "l": [0.0, 0.2]}),
    "three dimensions": (FOLLOWER, {"c": [0.1, -0.5], "a": [2.5, 3.2, 3.9]}),
    "oscillator": (BALL, {"sigma": [-0.2, 0.0, 0.1], "omega": [2.0, 2.5]}),
    "impact map": (gz.impact_map(gz.pinball(V=0.4)), {"omega": [1.5, 2.2], "d": [0.05, 0.1]}),
}


@pytest.mark.parametrize("kind", AXES)
def test_a_cell_is_the_map_at_its_values(kind):
    P, axes = AXES[kind]
    runs = runs_of(P, axes, arithmetic="strict")
    cells = np.arange(len(next(iter(axes.values()))) * len(list(axes.values())[1]))
    found = joined(list(runs.pieces(cells)))
    (a, first), (b, second) = axes.items()
    values = [(x, y) for x in first for y in second]
    assert runs.values(cells).tolist() == [list(map(float, pair)) for pair in values]
    for cell, (x, y) in enumerate(values):
        at = P.replace(**{a: x, b: y})
        assert dict(runs.map_at(cell).params) == dict(at.params)
        assert runs.rows(cells)[cell].tolist() == list(at.params.values())
        starts = random_starts(0, (x, y), 4, at.box)
        assert np.array_equal(runs.states(cells)[cell], starts)
        for j in range(4):
            orbit = at.orbit(starts[:, j], 40)
            assert np.array_equal(found.points[cell, :, :, j], orbit.points[31:], equal_nan=True)
            assert np.array_equal(found.letters[cell, :, j], orbit.letters[30:])
            assert found.outcomes[cell, 0, j] == np.bitwise_or.reduce(orbit.outcomes)


@pytest.mark.parametrize("kind", AXES)
def test_two_parameters_are_one_parameter_at_a_time(kind):
    """Given the same starts, cells along one axis are those of the map with the other parameter replaced."""
    P, axes = AXES[kind]
    (a, first), (b, second) = axes.items()
    box = np.array(P.replace(**{a: max(first)}).box)
    starts = np.random.default_rng(0).uniform(box[:, 0], box[:, 1], (6, P.dimension))
    both = joined(list(runs_of(P, axes, starts).pieces(np.arange(len(first) * len(second)))))
    for i, x in enumerate(first):
        alone = runs_of(P.replace(**{a: x}), {b: second}, starts)
        found = joined(list(alone.pieces(np.arange(len(second)))))
        part = slice(i * len(second), (i + 1) * len(second))
        for one, other in zip(both, found, strict=True):
            assert np.array_equal(one[part], other, equal_nan=True)


def test_starts_are_named_by_their_values_alone():
    one = runs_of(GAP, {"mu": [0.3, 0.1, 0.2]}, starts=7)
    other = runs_of(GAP, {"mu": [0.1, 0.7]}, starts=3)
    assert np.array_equal(one.states(np.array([1]))[0][:, :3], other.states(np.array([0]))[0])
    assert np.array_equal(one.states(np.array([2, 0]))[1], one.states(np.array([0]))[0])
    swapped = runs_of(GAP, {"l": [0.1], "mu": [0.3]})
    assert not np.array_equal(
        swapped.states(np.array([0])), runs_of(GAP, {"mu": [0.3], "l": [0.1]}).states(np.array([0]))
    )


@pytest.mark.parametrize(
    ("axes", "moving"),
    [
        ({"d": [0.1, 0.2]}, ()),
        ({"sigma": [-0.1, 0.1]}, (0,)),
        ({"sigma": [0.0]}, ()),
        ({"sigma": [0.1]}, (0,)),  # one value, but not that of the map
        ({"omega": [20.0, 25.0], "sigma": [0.1, 0.2]}, (0, 1)),
        ({"omega": [20.0, 25.0], "d": [0.1, 0.2]}, (0,)),
        ({"d": [0.1], "sigma": [-0.1, 0.1]}, (1,)),
        ({"V": [0.1, 0.5], "r": [0.1, 1.0]}, ()),
    ],
)
def test_which_axes_move_the_box(axes, moving):
    P = gz.stroboscopic_map(gz.pinball(omega=20.0))  # so fast that the forcing's push, and the box, depend on omega
    runs = runs_of(P, axes)
    assert runs.moving == moving
    cells = np.arange(np.prod([len(values) for values in axes.values()]))
    for cell in cells.tolist():
        assert runs.boxes(cells)[cell].tolist() == [list(ends) for ends in runs.map_at(cell).box]


def test_a_box_of_ones_own_does_not_move():
    box = ((0.5, 0.6), (-0.1, 0.1))
    runs = runs_of(BALL, {"sigma": [-0.1, 0.1], "omega": [2.0, 9.0]}, box=box)
    assert (runs.boxes(np.arange(4)) == np.array(box)).all()
    states = runs.states(np.arange(4))
    assert (states[:, 0] >= 0.5).all() and (states[:, 0] < 0.6).all()


def test_orbits_can_go_on_from_given_states():
    runs = runs_of(GAP, {"mu": [0.1, 0.2]}, starts=3, transient=5, keep=5, arithmetic="strict")
    cells = np.array([1, 0])
    states = np.full((2, 1, 3), 0.25)
    *pieces, found = runs.columns(cells, states)
    assert pieces == [None] * len(pieces)
    for q, mu in enumerate((0.2, 0.1)):
        assert found.points[q, :, 0, 0].tolist() == GAP.replace(mu=mu).iterate((0.25,), 10)[6:, 0].tolist()
    assert np.array_equal(states[:, 0], found.points[:, -1, 0])  # they are the last ones now


def test_no_axis_is_the_map_as_it_is():
    runs = runs_of(GAP, {})
    assert runs.rows(np.array([0])).tolist() == [[0.5, 0.1, 0.1]]
    assert np.array_equal(runs.states(np.array([0]))[0], random_starts(0, (), 4, GAP.box))


def test_a_map_without_parameters():
    P = gz.Map(lambda state, p: (0.5 * state[0],), params={})
    runs = runs_of(P, {}, transient=0, keep=3, arithmetic="strict")
    found = joined(list(runs.pieces(np.array([0]))))
    assert np.allclose(found.points[0, 0], 0.5 * runs.states(np.array([0]))[0])
    with pytest.raises(gz.InputError, match="unknown parameter 'a'"):
        runs_of(P, {"a": [1.0]})


@pytest.mark.parametrize(("starts", "lanes"), [(1, 1), (100, 100), ([[0.1], [0.2]], 2)])
def test_what_cells_are_worth_computing_together(starts, lanes):
    for P, many in ((GAP, MANY), (BALL, TOGETHER)):
        given = np.array(starts) if P is GAP or isinstance(starts, int) else np.full((lanes, 2), 0.5)
        runs = runs_of(P, {next(iter(P.params)): [0.5, 0.6]}, starts if isinstance(starts, int) else given)
        assert runs.settings.lanes == lanes
        full = LANES // padded(lanes) if P is BALL else 1  # blocks of oscillators are full
        assert runs.together == max(1, many // lanes // full * full)
        strict = runs_of(P, runs.axes, starts if isinstance(starts, int) else given, arithmetic="strict")
        assert strict.together == max(1, (MANY if P is GAP else FEW) // lanes)
        assert runs.work == lanes * 40


def test_configuration_names_what_decides_the_numbers():
    config = runs_of(GAP, {"mu": [0.1]}, seed=9).config
    assert config["params"] == {"lam": 0.5, "l": 0.1}
    assert config["starts"] == {"random": 4, "seed": 9, "box": ((-1.0, 1.0),)}
    given = runs_of(GAP, {"mu": [0.1]}, [[0.1]]).config["starts"]
    assert given["given"] == 1 and len(given["sha256"]) == 64
    assert describe_values(np.array([3.0, 1.0]))["first"] == 3.0


def test_given_starts_must_be_allowed_at_every_value():
    runs_of(BALL, {"sigma": [0.0, 0.05]}, [[0.1, 0.0]])
    with pytest.raises(gz.InputError, match=r"the ball starts inside the wall: u = 0.1, sigma = 0.2; start with"):
        runs_of(BALL, {"sigma": [0.0, 0.2]}, [[0.1, 0.0]])
    with pytest.raises(gz.InputError, match="inside the wall"):
        runs_of(BALL, {"d": [0.1], "sigma": [0.0, 0.2]}, [[0.1, 0.0]])


def law_step(state, p):
    return (p.x * state[0],)


@pytest.mark.parametrize(
    ("P", "axes", "more", "said"),
    [
        (3, {}, {}, "the first argument is 3; give a map, such as"),
        (GAP, {"nu": [0.1]}, {}, "unknown parameter 'nu' of gap map. Allowed are: lam, mu, l"),
        (GAP, {"mu": [0.1], "l": [np.inf]}, {}, r"values\[0\] = inf is not finite; give finite values of l"),
        (GAP, {"mu": "abc"}, {}, "values are not numbers: 'abc'; give finite values of mu"),
        (GAP, {"mu": None}, {}, "give finite values of mu"),
        (GAP, {"mu": [[0.1], [0.2]]}, {}, r"values have shape \(2, 1\)"),
        (GAP, {"mu": [1j]}, {}, "values are not numbers"),
        (GAP, {"mu": [0.1]}, {"taken": ("mu",)}, "'mu' names a dimension or variable of the result; rename"),
        (GAP, {"mu": [0.1]}, {"taken": ("x",)}, "'x' names a dimension or variable of the result; rename"),
        (gz.Map(law_step, {"x": 0.5}), {"x": [0.5]}, {}, "'x' names a dimension or variable of the result"),
        (GAP, {"mu": [0.1]}, {"starts": [[np.nan]]}, "start 0 is not finite"),
        (GAP, {"mu": [0.1]}, {"starts": []}, r"starts have shape \(0,\)"),
        (GAP, {"mu": [0.1]}, {"starts": -3}, "starts = -3; allowed is a whole number >= 1"),
        (GAP, {"mu": [0.1]}, {"starts": None}, "starts = None; allowed is a whole number >= 1"),
        (GAP, {"mu": [0.1]}, {"transient": 0.5}, "transient = 0.5; allowed is a whole number >= 0"),
        (GAP, {"mu": [0.1]}, {"keep": 0}, "keep = 0; allowed is a whole number >= 1"),
        (GAP, {"mu": [0.1]}, {"seed": 2**64}, "seed = 18446744073709551616; allowed is a whole number below"),
        (GAP, {"mu": [0.1]}, {"arithmetic": None}, "arithmetic is None; allowed are 'strict' and 'fast'"),
        (GAP, {"mu": [0.1]}, {"box": ((1, 0),)}, r"box of x is \(1, 0\); the lower end must come first"),
        (BALL, {"r": [0.5, -0.1]}, {}, "r = -0.1; allowed is 0 <= r <= 1"),
        (BALL, {"d": [0.1], "omega": [1.0, 0.0]}, {}, "omega = 0; allowed is omega > 0"),
    ],
)
def test_error_texts(P, axes, more, said):
    with pytest.raises(gz.InputError, match=said):
        runs_of(P, axes, **more)


def test_values_are_copied_and_keep_their_order():
    mine = np.array([0.3, 0.1])
    grid = checked_values("mu", mine)
    mine[0] = 7.0
    assert grid.tolist() == [0.3, 0.1]
    assert checked_values("mu", (1, 2)).dtype == np.float64
    assert Settings(3, 0, 1, 0, "fast", None).lanes == 3
