"""The same numbers from plain Python as from compiled code, in strict arithmetic: every study at a small size."""

import json
import os
import sys

import numpy as np
import pytest

import grazing as gz
from tests.processes import python

SMALL = {"arithmetic": "strict", "transient": 25, "keep": 12}
STARTS = {**SMALL, "starts": 3}


def numbers(result):
    """Every number of a result, exactly, and every text."""
    return {
        name: [repr(value) for value in np.ravel(array.values).tolist()]
        for name, array in result.variables.items()
        if name not in ("graze", "graze_order")
    }


def henon(state, p):
    x, y = state
    return (1.0 - p.a * x * x + y, 0.3 * x), (0 if x < 0.0 else 1)


def studies(kind):
    if kind == "gap map":
        P, name, values, other = gz.gap_map(0.5, 0.1, 0.1), "mu", [0.043, 0.07], {"l": [0.0, 0.1]}
        grid = {"x": np.linspace(-1, 1, 12)}
    elif kind == "henon":  # some orbits end
        P = gz.Map(henon, {"a": 1.0, "b": 0.0}, ("x", "y"), ((-1.0, 1.0),) * 2, "LR", escape=50.0)
        name, values, other, grid = "a", [0.9, 2.5], {"b": [0.0]}, {"y": [0.1, 2.0, 9.0], "x": [-1.0, 0.3, 1.0]}
    else:
        P = {"oscillator": gz.stroboscopic_map, "impact map": gz.impact_map}[kind](gz.pinball(V=0.4))
        name, values, other = "d", [0.1, 0.12], {"V": [0.0, 0.4]}
        grid = {P.coordinates[0]: [0.1, 0.4], P.coordinates[1]: [0.0, 0.3]}
    yield gz.orbit_diagram(P, name, values, **STARTS)
    yield gz.orbit_diagram(P, name, values, sweep="down", **STARTS)
    yield gz.density(P, name, values, bins=9, range=(-0.5, 0.5), **STARTS)
    yield gz.chart(P, {name: values, **other}, exponent_steps=15, **STARTS)
    yield gz.lyapunov(P, name, values, steps=15, **STARTS)
    yield gz.coexistence(P, name, values, **STARTS)
    yield gz.basins(P, grid, preimages=0, **SMALL)


@pytest.mark.parametrize("kind", ["gap map", "henon", "impact map", "oscillator"])
def test_plain_python_gives_the_bits_of_compiled_code(kind):
    ours = [numbers(result) for result in studies(kind)]
    code = (
        "import json, warnings; warnings.simplefilter('ignore')\n"
        "from tests.studies.test_without_jit import numbers, studies\n"
        f"print(json.dumps([numbers(result) for result in studies({kind!r})]))"
    )
    env = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    done = python(code, env=env, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    theirs = json.loads(done.stdout.splitlines()[-1])
    assert len(theirs) == len(ours) == 7
    for one, other in zip(ours, theirs, strict=True):
        for name in one:
            if name in (
                "exponent",
                "exponent_error",
                "exponent_per_time",
                "lifetime",
                "return_time",
                "point",
            ):  # sums and solves in NumPy
                a, b = (np.array(list(map(float, x[name]))) for x in (one, other))
                assert np.allclose(a, b, rtol=1e-9, atol=1e-9, equal_nan=True), name
            else:
                assert one[name] == other[name], name
