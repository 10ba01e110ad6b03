"""Steps by address: the bits of steps that are compiled in, and nothing but the step compiled for another map."""

import os

import numpy as np
import pytest

import grazing as gz
from grazing.kernel.compile import jit_disabled
from grazing.kernel.lanes import BLOCK, runner
from grazing.maps.columns import empty_columns, run_columns, step_tasks
from grazing.maps.derivative import Derived, differences_of, extended, tangent_runner, units_of
from grazing.maps.map import Map
from grazing.maps.pointed import Place, pointed_derivative, pointed_tangent
from grazing.studies.growth import stretcher

LARGE = 2**62 + 1


def henon(factor=1.0):
    def step(x, p):
        new = (p.a - factor * x[0] * x[0] + p.b * x[1], x[0])
        return new, (LARGE if x[0] < 0.0 else 3), (4 if x[0] > 1.2 else 0)

    return Map(step, {"a": 1.3, "b": 0.3}, ("x", "y"), box=((-1.0, 1.0), (-1.0, 1.0)), escape=3.0)


@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
@pytest.mark.parametrize(("columns", "lanes"), [(1, 1), (1, 2 * BLOCK + 3), (7, 5)])
def test_a_step_by_address_gives_the_bits_of_one_that_is_compiled_in(arithmetic, columns, lanes):
    P, rng = henon(), np.random.default_rng(columns)
    rows = np.column_stack([rng.uniform(0.3, 1.4, columns), rng.uniform(0.1, 0.3, columns)])
    starts = rng.uniform(-1.0, 1.0, (columns, 2, lanes))
    ours = P.run_columns(rows, starts.copy(), 20, 30, arithmetic=arithmetic)
    found, states = empty_columns(columns, 2, lanes, 30, 1), starts.copy()
    loop = runner(P._full_step, None, P.packed()[0], 2, arithmetic)
    run_columns(step_tasks(loop, rows, states, 20, found, "the step"), states, found, 1, None)
    for one, other in zip(ours, found, strict=True):
        assert np.array_equal(one, other, equal_nan=True)
    assert {LARGE, 3} == set(np.unique(ours.letters)) or lanes == 1


def test_a_derivative_by_address_gives_the_bits_of_one_that_is_compiled_in():
    P, rng, n = henon(), np.random.default_rng(3), 6
    rows, states = np.tile(P.packed()[1], (n, 1)), rng.uniform(-0.2, 0.2, (n, 2, 1))
    direct = extended(differences_of(P._full_step, 2, units_of(P.box)))
    kind = P.packed()[0]
    pointed = pointed_derivative(Derived(direct, None, kind, rows, rows), 2, "the step")
    results = []
    for tangent, fields, given in ((direct, kind, rows), (pointed_tangent(2), Place, pointed.rows)):
        lanes, frames, areas = states.copy(), np.tile(np.eye(2), (n, 1, 1, 1)), np.zeros((n, 1))
        sums, sides = np.zeros((n, 1, 2)), np.ones((n, 1, 2))
        letters, outcomes = np.zeros((n, 1), np.int64), np.zeros((n, 1), np.int64)
        out = frames, sums, sides, areas, letters, outcomes, states.copy(), np.ones((n, 1, 2), np.int64)
        stretcher(tangent, None, fields, 2)(given, np.ones(2), lanes, 40, *out)
        results.append((lanes, *out))
    for one, other in zip(*results, strict=True):
        assert np.array_equal(one, other, equal_nan=True)
    assert np.isfinite(results[0][3]).all() and (results[0][3] != 1.0).all()


@pytest.mark.parametrize("walls", [0, 2])
def test_what_is_prepared_for_a_step_is_read_by_it_at_its_address(walls):
    """Constants of an oscillator, of both frames between walls: the bits are those of a step that gets them itself."""
    m = gz.Oscillator(0.2, 1.1, gz.Forcing(1.7, offset=-0.1), reset=gz.newton(0.8))
    if walls:
        pair = gz.wall(-0.3, gz.newton(0.8)), gz.wall(0.3, gz.newton(0.7))
        m = gz.Oscillator(0.2, 1.1, gz.Forcing(omega=1.7), walls=pair)
    P, found = gz.stroboscopic_map(m), []
    rows = np.array([list(P.replace(offset=value).params.values()) for value in (-0.1, 0.02, 0.1)])
    for derived in (P.origin.derivative(rows), P.derivative(rows)):
        run = tangent_runner(derived.tangent, derived.prepare, derived.kind, 2)
        for row in derived.rows:
            state, J = np.array([[0.11], [-0.6]]), np.empty((2, 2))
            found.append((run(row, state, J), state, J))
    assert len(found) == 6
    for one, other in zip(found[:3], found[3:], strict=True):
        assert all(map(np.array_equal, one, other)) and np.isfinite(one[2]).all()
    assert len({float(J[0, 0]) for _outcome, _state, J in found}) == 3


@pytest.mark.skipif(jit_disabled(), reason="nothing is compiled")
def test_of_another_map_only_the_step_is_compiled():
    from numba.core import event

    class Heard(event.Listener):
        def on_start(self, said):
            names.append(said.data["dispatcher"].py_func.__name__.rpartition("_strict")[0].rpartition("_fast")[0])

        def on_end(self, _said):
            pass

    def all_studies(P):
        values = np.linspace(0.2, 1.3, 4)
        few = {"starts": 3, "transient": 10, "keep": 20}
        gz.orbit_diagram(P, "a", values, **few)
        gz.coexistence(P, "a", values, **few)
        gz.chart(P, {"a": values, "b": [0.1, 0.3]}, **few, exponent_steps=10)
        gz.lyapunov(P, "a", values, **few, steps=10)
        gz.basins(P, transient=10, keep=10)
        orbit = gz.periodic_orbits(P, 1)[0]
        gz.continuation(P, orbit, "a", (0.9, 1.4))
        P.jacobian((0.1, 0.1))

    entries = {"run", "close_all", "attract", "settle"}
    names: list[str] = []
    all_studies(henon())
    with event.install_listener("numba:compile", Heard()):
        all_studies(henon(float.fromhex(f"0x1.00{os.urandom(5).hex()}p0")))
    said = {name.partition("_strict")[0].partition("_fast")[0] for name in names}
    assert not said & entries


@pytest.mark.skipif(jit_disabled(), reason="nothing is compiled")
def test_a_step_that_does_not_compile_is_named():
    def step(x, p):
        return (float(eval("5.0")),) if x[0] > 5.0 else (0.5 * x[0] + p.a,)

    P = Map(step, {"a": 0.1}, ("x",), box=((0.0, 1.0),), name="the sum")
    with pytest.raises(gz.UserCodeError, match="the step of the sum does not compile"):
        P.orbit(0.1, 3)


def test_a_step_of_no_module_is_compiled():
    names = {}
    exec("def step(x, p):\n    return (p.a * x[0] * (1.0 - x[0]),)", {"__builtins__": {}}, names)
    P = Map(names["step"], {"a": 3.2}, ("x",), box=((0.0, 1.0),))
    assert names["step"].__module__ is None and P.orbit(0.3, 1).points.ravel().tolist() == [
        0.3,
        3.2 * 0.3 * (1.0 - 0.3),
    ]


def test_what_is_raised_on_the_way_ends_the_work_with_its_line(capfd):
    """A step and a law are called by address: what they raised was printed, and their place taken by nothing."""

    def step(state, p):
        (x,) = state
        if x > 0.9:
            raise ValueError("too far")
        return (p.a * x * (1.0 - x),)

    def law(v, p):
        if -3.3 < v < -3.0:
            raise ValueError("too fast")
        return -0.5 * v

    P = gz.Map(step, params={"a": 3.99}, coordinates=("x",), box=((0.05, 0.6),))
    ball = gz.Oscillator(alpha=0.1, k=1, forcing=gz.Forcing(2.8), reset=gz.reset(law))
    gz.stroboscopic_map(ball).orbit((0.1, 0.0), 1)
    capfd.readouterr()  # what is compiled for the first time says so
    for ask, line in (
        (lambda: P.orbit((0.3,), 20), "ValueError: too far, in line"),
        (lambda: gz.lyapunov(P, "a", [3.99]), "ValueError: too far, in line"),
        (lambda: gz.periodic_orbits(P, 2), "ValueError: too far, in line"),
        (lambda: gz.trajectory(ball, (0.001, -3.1), until=1.0), "ValueError: too fast, in line"),
        (lambda: gz.stroboscopic_map(ball).orbit((0.001, -3.1), 1), "ValueError: too fast, in line"),
    ):
        with pytest.raises(gz.UserCodeError, match=line):
            ask()
    assert capfd.readouterr() == ("", "")
