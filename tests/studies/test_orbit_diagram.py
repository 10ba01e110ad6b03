import json

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import memory, theory
from grazing.catalogue import diagram
from grazing.studies.attractors import attractors
from grazing.studies.orbit_diagram import drift_of, orbit_diagram
from grazing.studies.starts import random_starts
from tests.studies.maps import SMOOTH
from tests.systems.balls import bouncing

GAP = gz.gap_map(lam=0.5, mu=0.1, l=0.1)
BALL = gz.stroboscopic_map(gz.pinball(V=0.4))
SMALL = {"starts": 9, "transient": 60, "keep": 12}


def hybrid(state, p):
    x, y, z = state
    return (p.a - x * x + 0.3 * y, x, 0.5 * z + x), (1 if x > 0.0 else 0), 0


CUBE = gz.Map(
    hybrid, params={"a": 1.0}, coordinates=("x", "y", "z"), box=((-0.1, 0.1),) * 3, letters="LR", escape=100.0
)


def test_dimensions_types_and_attributes():
    values = np.linspace(0.1, 0.13, 4)
    result = orbit_diagram(BALL, "d", values, **SMALL)
    assert dict(result.sizes) == {"d": 4, "start": 9, "n": 12}
    assert (result.d == values).all()
    assert result.u.dims == result.v.dims == result.letter.dims == ("d", "start", "n")
    assert result.period.dims == result.word.dims == result.outcome.dims == result.trust.dims == ("d", "start")
    assert result.d.attrs == {"long_name": "constant part of the forcing", "units": "1", "symbol": "d"}
    assert result.u.attrs["units"] == result.v.attrs["units"] == "1"
    assert result.period.attrs["period_limit"] == 6
    for name in ("letter", "period", "trust"):
        assert result[name].attrs["flag_values"].dtype == result[name].dtype
        assert len(result[name].attrs["flag_meanings"].split()) == len(result[name].attrs["flag_values"])
    assert result.outcome.attrs["flag_masks"].tolist() == [int(flag) for flag in gz.Outcome if flag]
    assert result.attrs["source"] == f"grazing {gz.__version__}"


def test_points_are_those_of_the_map():
    values = [0.03, 0.07, 0.11]
    result = orbit_diagram(GAP, "mu", values, starts=7, transient=20, keep=5, seed=3, arithmetic="strict")
    for value in values:
        P = GAP.replace(mu=value)
        starts = random_starts(3, (value,), 7, P.box)
        for i in range(7):
            orbit = P.orbit(starts[:, i], 25)
            here = result.sel(mu=value).isel(start=i)
            assert here.x.values.tolist() == orbit.points[21:, 0].tolist()
            assert here.letter.values.tolist() == orbit.letters[20:].tolist()


@pytest.mark.parametrize("arithmetic", ["fast", "strict"])
@pytest.mark.parametrize(
    ("P", "name", "values"),
    [
        (BALL, "d", np.linspace(0.09, 0.13, 9)),
        (gz.stroboscopic_map(gz.pinball(alpha=0.3, V=0.1)), "alpha", np.linspace(0.2, 2.0, 9)),
        (GAP, "mu", np.linspace(0.2, 0.0, 9)),
        (gz.gap_map(0.9, 0.1, 0.0), "lam", np.linspace(0.3, 0.95, 9)),
        (CUBE, "a", np.linspace(0.2, 1.2, 9)),
    ],
    ids=["oscillator", "damping", "gap map", "slope", "three dimensions"],
)
def test_neither_threads_nor_order_nor_neighbours_change_a_bit(P, name, values, arithmetic):
    more = {"starts": 70, "transient": 100, "keep": 20, "arithmetic": arithmetic}
    one = orbit_diagram(P, name, values, threads=1, **more)
    xr.testing.assert_identical(one, orbit_diagram(P, name, values, threads=4, **more))
    shuffled = np.random.default_rng(0).permutation(len(values))
    other = orbit_diagram(P, name, values[shuffled], threads=2, **more)
    few = orbit_diagram(P, name, values[[4]], **{**more, "starts": 3})
    for variable in ("letter", "period", "word", "outcome", "trust", *P.coordinates):
        assert np.array_equal(other[variable].values, one[variable].values[shuffled], equal_nan=variable in "uvxyz")
        assert np.array_equal(few[variable].values[0], one[variable].values[4, :3], equal_nan=variable in "uvxyz")


def test_starts_follow_the_seed_and_the_box():
    a, b = (orbit_diagram(GAP, "mu", [0.1], seed=s, **SMALL) for s in (1, 2))
    assert not (a.x == b.x).all()
    box = ((0.5, 0.6),)
    first = orbit_diagram(GAP, "mu", [0.1], starts=20, transient=0, keep=1, box=box)
    assert (first.x >= 0.1 - 0.1 - np.sqrt(0.6)).all() and (first.x <= 0.1 - 0.1 - np.sqrt(0.5)).all()


def test_the_box_moves_with_the_wall():
    result = orbit_diagram(gz.stroboscopic_map(gz.pinball()), "sigma", [-0.2, 0.0, 0.3], **SMALL)
    assert (result.outcome.values & gz.Outcome.inside_wall == 0).all()
    assert (result.u >= result.sigma).all()


def test_given_starts():
    starts = np.array([[-0.5], [0.25]])
    result = orbit_diagram(GAP, "mu", [0.1, 0.2], starts=starts, transient=0, keep=1, arithmetic="strict")
    assert result.x[:, :, 0].values.tolist() == [[0.1 - 0.25, 0.1 - 0.1 - 0.5], [0.2 - 0.25, 0.2 - 0.1 - 0.5]]
    assert starts.tolist() == [[-0.5], [0.25]]
    with pytest.raises(gz.InputError, match="the ball starts inside the wall: u = -1, sigma = 0"):
        orbit_diagram(BALL, "d", [0.12], starts=[[0.1, 0.0], [-1.0, 0.0]])


def test_a_law_with_a_slope_by_differences_is_numerical():
    law = gz.reset(lambda v, p: -p.e * v + 0.4, e=0.8)
    model = gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2, offset=0.12), law)
    result = orbit_diagram(gz.stroboscopic_map(model), "offset", [0.12], starts=3)
    assert (result.trust == 1).all()
    assert (result.period == 3).all()


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # overflow, which plain Python mentions
def test_orbits_that_end_are_recorded_and_not_raised():
    result = orbit_diagram(CUBE, "a", [0.5, 30.0], **SMALL)
    assert (result.period.sel(a=30.0) == -2).all()
    assert (result.outcome.sel(a=30.0).values & gz.Outcome.diverged).all()
    assert (result.word.sel(a=30.0) == "").all()
    assert (result.period.sel(a=0.5) == 2).all()


def test_periods_follow_the_windows_of_the_gap_map():
    lam, l = 0.34, 0.21
    values = np.linspace(0.01, 0.3, 40)
    result = orbit_diagram(gz.gap_map(lam, 0.1, l), "mu", values, starts=20, transient=1000)
    for found in attractors(result):
        low = theory.mu_pd(found.period, lam, l)
        high = theory.mu_bc(found.period, lam, l) if found.period > 1 else np.inf
        assert low < found.value < high
        assert found.word == "L" * (found.period - 1) + "R"


def test_windows_overlap():
    # lam = 0.5, l = 0.1: periods 3 and 4 coexist for 0.0410714 < mu < 0.0443812
    result = orbit_diagram(GAP, "mu", [0.043, 0.05], transient=1000)
    found = attractors(result)
    assert [(a.value, a.word, a.period) for a in found] == [(0.043, "LLR", 3), (0.043, "LLLR", 4), (0.05, "LLR", 3)]
    assert found[0].share + found[1].share == pytest.approx(1.0)
    assert 0.0 < found[1].share < found[0].share


def test_configuration():
    result = orbit_diagram(GAP, "mu", [0.3, 0.2], seed=5, **SMALL)
    config = json.loads(result.attrs["grazing_config"])
    assert config["params"] == {"lam": 0.5, "l": 0.1}
    assert config["starts"] == {"random": 9, "seed": 5, "box": [[-1.0, 1.0]]}
    assert config["values"]["first"] == 0.3
    assert (config["parameter"], config["keep"], config["transient"]) == ("mu", 12, 60)
    again = orbit_diagram(GAP.replace(mu=0.9), "mu", [0.3, 0.2], seed=5, threads=1, **SMALL)
    assert again.attrs == result.attrs  # the swept parameter's own value does not count
    changes = ({"seed": 6}, {"keep": 13}, {"arithmetic": "strict"}, {"box": ((0, 1),)}, {"starts": [[0.5]]})
    others = [orbit_diagram(GAP, "mu", [0.3, 0.2], **{"seed": 5, **SMALL, **change}) for change in changes]
    others.append(orbit_diagram(GAP.replace(l=0.2), "mu", [0.3, 0.2], seed=5, **SMALL))
    others.append(orbit_diagram(GAP, "mu", [0.2, 0.3], seed=5, **SMALL))
    assert len({other.attrs["grazing_config_sha256"] for other in [result, *others]}) == 8


def test_another_step_of_the_same_name_is_another_code():
    def steps(power):
        def step(state, p):
            return (p.a * state[0] ** power,)

        return gz.Map(step, params={"a": 0.5})

    one, same, other = (orbit_diagram(steps(power), "a", [0.5], **SMALL).attrs for power in (1, 1, 2))
    assert one == same
    assert one["grazing_config"] == other["grazing_config"]
    assert one["grazing_code_sha256"] != other["grazing_code_sha256"]


def test_saved_and_loaded(tmp_path):
    from grazing.io import load, save

    for P, name in ((BALL, "d"), (GAP, "mu"), (CUBE, "a")):
        result = orbit_diagram(P, name, [0.12, 0.13], **SMALL)
        loaded = load(save(result, tmp_path / "diagram.nc"))
        xr.testing.assert_identical(loaded, result)
        assert [v.dtype for v in loaded.variables.values()] == [v.dtype for v in result.variables.values()]


def test_progress():
    said = []
    orbit_diagram(GAP, "mu", [0.1, 0.2, 0.3], progress=lambda *done: said.append(done), **SMALL)
    assert said[-1] == (3, 3)


def clash(state, p):
    return (p.n * state[0],)


@pytest.mark.parametrize(
    ("P", "name", "values", "more", "said"),
    [
        (GAP.step, "mu", [0.1], {}, "the first argument is <function gap_step .*; give a map, such as"),
        (GAP, "muu", [0.1], {}, "unknown parameter 'muu' of gap map. Did you mean 'mu'"),
        (GAP, "mu", [], {}, r"values have shape \(0,\); give finite values of mu in a list"),
        (GAP, "mu", 0.1, {}, r"values have shape \(\); give finite values of mu"),
        (GAP, "mu", [[0.1]], {}, r"values have shape \(1, 1\); give finite values of mu"),
        (GAP, "mu", [0.1, np.nan], {}, r"values\[1\] = nan is not finite; give finite values of mu"),
        (GAP, "mu", ["a"], {}, r"values are not numbers: \['a'\]; give finite values of mu"),
        (GAP, "mu", [0.1], {"starts": 0}, "starts = 0; allowed is a whole number >= 1"),
        (GAP, "mu", [0.1], {"starts": [[1.0, 2.0]]}, r"starts have shape \(1, 2\); give a whole number"),
        (GAP, "mu", [0.1], {"keep": 0}, "keep = 0; allowed is a whole number >= 1"),
        (GAP, "mu", [0.1], {"transient": -1}, "transient = -1; allowed is a whole number >= 0"),
        (GAP, "mu", [0.1], {"seed": "x"}, "seed = 'x'; allowed is a whole number >= 0"),
        (GAP, "mu", [0.1], {"threads": 0}, "threads = 0; allowed is a whole number >= 1"),
        (GAP, "mu", [0.1], {"arithmetic": "exact"}, "arithmetic is 'exact'; allowed are 'strict' and 'fast'"),
        (GAP, "mu", [0.1], {"box": ((0, 1), (0, 1))}, "box has 2 intervals for 1 coordinates; give one"),
        (BALL, "r", [0.5, 1.5], {}, "r = 1.5; allowed is 0 <= r <= 1"),
        (gz.Map(clash, {"n": 0.5}), "n", [0.5], {}, "'n' names a dimension or variable of the result; rename it"),
        (gz.Map(clash, {"n": 0.5}, ("n",)), "n", [0.5], {}, "'n' names a dimension or variable"),
    ],
)
def test_error_texts(P, name, values, more, said):
    with pytest.raises(gz.InputError, match=said):
        orbit_diagram(P, name, values, **more)


def test_a_result_larger_than_half_the_memory_is_refused_at_once(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 10**9)
    said = r"would take 6[0-9.]+ GB, more than half .* reduce mu \(1000\), start \(1000\), n \(5000\), or sweep into"
    with pytest.raises(gz.InputError, match=said):
        orbit_diagram(GAP, "mu", np.linspace(0, 1, 1000), starts=1000, keep=5000)


def test_a_letter_without_a_symbol_is_said():
    def step(state, p):
        return (p.a * state[0],), 7, 0

    P = gz.Map(step, params={"a": 0.5}, letters="LR")
    with pytest.raises(gz.InputError, match="letter 7 has no symbol in 'LR'"):
        orbit_diagram(P, "a", [0.5], **SMALL)


def followed(P, name, values, starts, transient, keep, up):
    """A sweep by hand: begin where the neighbour ended; anew where an orbit ended or the wall has passed it."""
    order = np.argsort(values, kind="stable")
    found, states = {}, starts(values[order[0] if up else order[-1]])
    for i in order if up else order[::-1]:
        at = P.replace(**{name: values[i]})
        fresh = starts(values[i])
        lost = ~np.isfinite(states).all(axis=0)
        if "sigma" in at.params and "u" in P.coordinates:
            lost |= states[0] < at.params["sigma"]
        states = np.where(lost, fresh, states)
        orbits = [at.orbit(states[:, j], transient + keep) for j in range(states.shape[1])]
        found[i] = np.array([orbit.points[transient + 1 :] for orbit in orbits])
        states = np.array([orbit.points[-1] for orbit in orbits]).T
    return np.array([found[i] for i in range(len(values))])  # (values, starts, keep, dim)


@pytest.mark.parametrize("sweep", ["up", "down"])
@pytest.mark.parametrize(
    ("P", "name", "values"),
    [
        (GAP, "mu", [0.05, 0.03, 0.04, 0.06]),
        (BALL, "d", [0.09, 0.1, 0.12]),
        (BALL, "sigma", [-0.1, 0.0, -0.05]),
        (CUBE, "a", [0.5, 1.0, 30.0, 1.2, 0.3]),
    ],
    ids=["gap map", "oscillator", "moving wall", "some end"],
)
def test_a_sweep_goes_on_where_the_neighbour_ended(P, name, values, sweep):
    result = orbit_diagram(P, name, values, sweep=sweep, arithmetic="strict", **SMALL)
    twin = followed(
        P,
        name,
        values,
        lambda value: random_starts(0, (value,), 9, P.replace(**{name: value}).box),
        60,
        12,
        sweep == "up",
    )
    for k, coordinate in enumerate(P.coordinates):
        assert np.array_equal(result[coordinate].values, twin[..., k], equal_nan=True)


def test_a_wall_that_moves_into_the_ball_gives_it_a_new_start():
    """Where the wall has passed the last state it is no state any more: the orbit begins anew and does not end."""
    model = gz.pinball(V=0.0, d=-0.5, r=0.3)  # it lies on the wall for a while in every period
    values = np.linspace(-0.2, 0.2, 5)
    result = orbit_diagram(gz.stroboscopic_map(model), "sigma", values, sweep="up", **SMALL)
    assert (result.period.values != -2).all()
    assert (result.outcome.values & gz.Outcome.inside_wall == 0).all()


def test_hysteresis_shows_where_two_windows_overlap_and_nowhere_else():
    lam, l = 0.5, 0.1
    low, high = theory.mu_pd(3, lam, l), theory.mu_bc(4, lam, l)  # LLR attracts above low, LLLR below high
    mus = np.linspace(low - 2e-3, high + 2e-3, 41)
    more = {"starts": 3, "transient": 3000, "keep": 40}
    up, down = (orbit_diagram(GAP, "mu", mus, sweep=sweep, **more) for sweep in ("up", "down"))
    sure = (
        np.minimum(np.abs(mus - low), np.abs(mus - high)) > 3e-4
    )  # nearer, a step of the sweep leaves a basin that shrinks
    inside = (mus > low) & (mus < high)
    assert (up.word.values[sure & (mus < high)] == "LLLR").all() and (
        up.word.values[sure & (mus > high)] == "LLR"
    ).all()
    assert (down.word.values[sure & (mus > low)] == "LLR").all() and (
        down.word.values[sure & (mus < low)] == "LLLR"
    ).all()
    differ = (up.word.values != down.word.values).any(axis=1)
    assert (differ == inside)[sure].all() and (inside & sure).sum() > 12


def test_a_sweep_is_one_task_in_order():
    made = gz.plans.orbit_diagram(GAP, "mu", [0.1, 0.2], sweep="up")
    assert made.sequential and not gz.plans.orbit_diagram(GAP, "mu", [0.1, 0.2]).sequential
    assert made.config["sweep"] == "up" and "sweep" not in gz.plans.orbit_diagram(GAP, "mu", [0.1, 0.2]).config
    mus = np.linspace(0.03, 0.05, 20)
    one = orbit_diagram(GAP, "mu", mus, sweep="down", threads=1, **SMALL)
    xr.testing.assert_identical(one, orbit_diagram(GAP, "mu", mus, sweep="down", threads=4, **SMALL))
    said = []
    orbit_diagram(GAP, "mu", mus, sweep="down", progress=lambda *done: said.append(done), **SMALL)
    assert said[-1] == (20, 20)


def test_the_order_of_the_values_does_not_change_a_sweep():
    mus = np.linspace(0.03, 0.05, 9)
    shuffled = np.random.default_rng(0).permutation(9)
    one = orbit_diagram(GAP, "mu", mus, sweep="up", **SMALL)
    other = orbit_diagram(GAP, "mu", mus[shuffled], sweep="up", **SMALL)
    assert np.array_equal(other.x.values, one.x.values[shuffled])


def test_a_sweep_with_given_starts_and_one_value():
    given = [[-0.3], [0.2]]
    one = orbit_diagram(GAP, "mu", [0.04], starts=given, sweep="up", transient=5, keep=3)
    xr.testing.assert_equal(one, orbit_diagram(GAP, "mu", [0.04], starts=given, transient=5, keep=3))


@pytest.mark.parametrize("sweep", ["left", True, 1, ""])
def test_a_sweep_has_a_direction(sweep):
    with pytest.raises(gz.InputError, match=f"sweep = {sweep!r}; allowed are 'up', 'down' and None"):
        orbit_diagram(GAP, "mu", [0.1], sweep=sweep)


def bent(state, p):
    """Two slopes and a parabola, in units of scale."""
    x = state[0] / p.scale
    return (p.scale * (p.move + (p.left if x < 0.0 else p.right) * x - p.c * x * x),)


def test_orbits_of_own_maps_that_grow_without_bound_have_diverged():
    """Numbers as large as 1e200 were aperiodic, with the exponent of chaos, until they overflowed."""
    P = gz.Map(bent, {"left": 0.5, "right": 0.5, "c": 0.0, "move": 0.3, "scale": 1.0})
    for slopes in ({"left": -0.8, "right": -2.7}, {"left": 1.05, "right": 1.05, "move": -1.2}):
        found = gz.orbit_diagram(P.replace(**slopes), "scale", [0.5, 1.0], starts=3, transient=1000)
        assert (found.outcome.values == gz.Outcome.diverged).all() and np.isnan(found.x.values).all()
    by_turns = P.replace(left=-4.0, right=-0.26, move=0.0)  # near again after every step away
    found = gz.orbit_diagram(by_turns, "c", [0.0], starts=3, transient=1000)
    assert (found.outcome.values == gz.Outcome.diverged).all()
    for bounded in (
        {"left": 3.8, "right": 3.8, "c": 3.8, "move": 0.0, "scale": 1e6},  # chaos far from the box
        {"left": 0.99, "right": 0.99, "move": 1.0, "scale": 1e6},  # on the way to 1e8
        {"left": 1.0, "right": 1.0, "move": 1e-3, "scale": 1e8},  # evenly on
    ):
        found = gz.orbit_diagram(P.replace(**bounded), "c", [bounded.get("c", 0.0)], starts=3, transient=100)
        assert (found.outcome.values == gz.Outcome.ok).all()


def test_orbits_that_grow_without_bound_have_diverged():
    def gain(v, p):
        return -p.r * v * (1.0 + p.c * v * v / (1.0 + v * v))

    law = gz.reset(gain, r=0.8, c=0.5)
    with pytest.warns(RuntimeWarning, match=r"reset law gain makes fast impacts faster.*diverged"):
        P = gz.stroboscopic_map(gz.Oscillator(0.05, 1.0, gz.Forcing(2.2, cos=(1.0,)), law))
    found = gz.orbit_diagram(P, "d" if "d" in P.params else "offset", [0.0], starts=5)
    assert (found.period.values == -2).all() and np.isnan(found.u.values).all()
    assert (found.outcome.values == gz.Outcome.diverged).all()
    reached = gz.basins(P, {"u": [0.0, 1.0], "v": [1.0, 1.5]}, transient=200, keep=30)
    assert (reached.outcome.values == gz.Outcome.diverged).all()
    softer = gz.reset(gain, r=0.5, c=0.5)  # gives back less at every speed: no warning, and nothing diverges
    P = gz.stroboscopic_map(gz.Oscillator(0.05, 1.0, gz.Forcing(2.2, cos=(1.0,)), softer))
    assert (gz.orbit_diagram(P, "offset", [0.0], starts=5).outcome.values == 0).all()


def test_an_orbit_on_its_way_to_its_cycle_says_how_far_it_moves():
    """Beside the period doubling of the logistic map at a = 3 the cycle is x = 1 - 1/a, of multiplier 2 - a."""
    values = [2.8, 2.999, 3.001, 3.9]
    found = orbit_diagram(SMOOTH, "a", values, starts=5, transient=200)
    assert found.period.values[:, 0].tolist() == [1, 1, 2, -1]
    x, side = found.x.values, 0.9
    assert found.drift.values[:2] == pytest.approx(np.abs(x[:2, :, -1] - x[:2, :, -2]) / side, rel=1e-12)
    assert found.drift.values[2] == pytest.approx(np.abs(x[2, :, -1] - x[2, :, -3]) / side, rel=1e-12)
    assert (found.drift.values[0] < 1e-12).all() and (found.drift.values[1] > 0.004).all()
    away = np.abs(x[1, :, -1] - (1.0 - 1.0 / 2.999)) / side
    assert found.drift.values[1] == pytest.approx(away * (1.0 + 1.0 / 0.999), rel=0.02)
    assert np.isnan(found.drift.values[3]).all()
    longer = orbit_diagram(SMOOTH, "a", values[1:2], starts=5, transient=20_000)
    assert (longer.drift.values < 1e-6).all()
    told = diagram.words(diagram.found(found))
    assert "on their way" in told[-1] and diagram.found(found)["unsettled"] >= 5
    assert not any("on their way" in line for line in diagram.words(diagram.found(longer)))


@pytest.mark.parametrize("sweep", ["up", "down"])
def test_a_system_of_your_own_is_swept_from_start_to_start(sweep):
    P = gz.stroboscopic_map(bouncing())
    one = {"sweep": sweep, "starts": 1, "transient": 3, "keep": 4, "seed": 1}
    found = orbit_diagram(P, "A", [0.1, 0.11], **one)  # where no orbit was before, its gap is not asked
    assert np.isfinite(found.x.values).all() and "sweep" in found.attrs["grazing_config"]


def test_an_orbit_that_is_infinite_has_no_drift_and_is_not_warned_of():
    gone = np.full((1, 3, 1, 1), np.inf)
    assert np.isnan(drift_of(gone, np.array([[-2]], np.int32), np.array([[[0.0, 1.0]]]))).all()
