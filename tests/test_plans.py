"""gz.plans: the same arguments as the studies, less threads and progress, checked before anything runs."""

import inspect
import time

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing.studies.plan import Plan, empty_arrays, run_plan

G = gz.gap_map(0.5, 0.1, 0.1)
ARGUMENTS = {
    "orbit_diagram": ((G, "mu", [0.05, 0.1]), {"starts": 5, "transient": 20, "keep": 10}),
    "density": ((G, "mu", [0.05, 0.1]), {"starts": 5, "keep": 20, "bins": 7}),
    "chart": ((G, {"mu": [0.05, 0.1], "l": [0.1]}), {"starts": 3}),
    "basins": ((G, {"x": [0.1, -0.2, 0.5]}), {"transient": 50}),
    "lyapunov": ((G, "mu", [0.05, 0.1]), {"starts": 3, "steps": 20}),
    "coexistence": ((G, "mu", [0.05, 0.1]), {"starts": 5}),
    "portrait": ((gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4)),), {"starts": 5, "keep": 20, "bins": 7}),
    "word_statistics": ((G, "mu", [0.05, 0.1]), {"starts": 5, "keep": 20, "length": 2}),
}


def test_every_plan_is_that_of_a_study():
    assert sorted(gz.plans.__all__) == sorted(ARGUMENTS)
    assert all(callable(getattr(gz, name)) for name in ARGUMENTS)


@pytest.mark.parametrize("name", ARGUMENTS)
def test_arguments_are_those_of_the_study(name):
    study, plan = inspect.signature(getattr(gz, name)), inspect.signature(getattr(gz.plans, name))
    theirs = {key: (p.default, p.kind) for key, p in study.parameters.items() if key not in ("threads", "progress")}
    assert {key: (p.default, p.kind) for key, p in plan.parameters.items()} == theirs


@pytest.mark.parametrize("name", ARGUMENTS)
def test_running_the_plan_is_the_study(name):
    arguments, more = ARGUMENTS[name]
    made = getattr(gz.plans, name)(*arguments, **more)
    assert isinstance(made, Plan) and made.recipe is None
    result = getattr(gz, name)(*arguments, **more)
    xr.testing.assert_identical(run_plan(made), result)
    xr.testing.assert_identical(run_plan(made), result)  # a plan is not used up
    assert result.attrs["title"].startswith(made.title[:5])


@pytest.mark.parametrize("name", ARGUMENTS)
def test_cells_do_not_depend_on_which_are_asked_for(name):
    arguments, more = ARGUMENTS[name]
    made = getattr(gz.plans, name)(*arguments, **more)

    def computed(cells):
        arrays = empty_arrays(made, len(cells))
        for _ in made.compute(np.array(cells), arrays):
            pass
        return arrays

    whole = computed(range(made.cells))
    for i in range(made.cells):
        alone = computed([i])
        for key, array in alone.items():
            assert array.dtype == made.variables[key].dtype and array.shape == (1, *made.shape_of(key))
            equal_nan = array.dtype.kind == "f"
            assert np.array_equal(array[0], whole[key][i], equal_nan=equal_nan)
        for key, variable in made.variables.items():
            if variable.kind == "text":
                assert all(len(text) <= variable.longest for text in np.ravel(alone[key]).tolist())


@pytest.mark.parametrize("name", ARGUMENTS)
def test_results_survive_a_file(name, tmp_path):
    arguments, more = ARGUMENTS[name]
    result = getattr(gz, name)(*arguments, **more)
    loaded = gz.load(gz.save(result, tmp_path / "result.nc"))
    xr.testing.assert_identical(loaded, result)


def test_making_a_plan_computes_nothing():
    before = time.process_time()
    gz.plans.chart(G, {"mu": np.linspace(0, 1, 300), "l": np.linspace(0, 1, 300)}, transient=10**9)
    gz.plans.lyapunov(G, "mu", np.linspace(0, 1, 100), steps=10**9)
    gz.plans.coexistence(G, "mu", np.linspace(0, 1, 1000), transient=10**8)
    assert time.process_time() - before < 5.0


@pytest.mark.parametrize("name", ARGUMENTS)
def test_input_is_checked_when_the_plan_is_made(name):
    arguments, more = ARGUMENTS[name]
    with pytest.raises(gz.InputError, match="the first argument is None; give a map"):
        getattr(gz.plans, name)(None, *arguments[1:], **more)
    with pytest.raises(gz.InputError, match="keep = 0; allowed is a whole number >= 1"):
        getattr(gz.plans, name)(*arguments, **{**more, "keep": 0})
    with pytest.raises(gz.InputError, match="transient = -1; allowed is a whole number >= 0"):
        getattr(gz.plans, name)(*arguments, **{**more, "transient": -1})
    with pytest.raises(gz.InputError, match="arithmetic is 'quick'; allowed are 'strict' and 'fast'"):
        getattr(gz.plans, name)(*arguments, **{**more, "arithmetic": "quick"})
