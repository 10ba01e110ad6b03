"""Every study through a store: the same labelled result as from memory."""

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import sweep
from grazing.config import plan_of
from grazing.studies.plan import run_plan

G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
MU = np.linspace(0.0, 0.3, 5)
PLANS = {
    "portrait": lambda: gz.plans.portrait(gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4)), starts=5, keep=20, bins=7),
    "word_statistics": lambda: gz.plans.word_statistics(
        gz.gap_map(0.5, 0.07, 0.1), "mu", [0.05, 0.06, 0.07, 0.1], starts=5, keep=20, length=2
    ),
    "orbit_diagram": lambda: gz.plans.orbit_diagram(G, "mu", MU, starts=3),
    "density": lambda: gz.plans.density(G, "mu", MU, starts=3),
    "chart": lambda: gz.plans.chart(G, {"mu": MU, "l": MU[:3]}, starts=3),
    "basins": lambda: gz.plans.basins(G, {"x": np.linspace(-0.5, 0.5, 7)}),
    "lyapunov": lambda: gz.plans.lyapunov(G, "mu", MU, starts=3),
    "coexistence": lambda: gz.plans.coexistence(G, "mu", MU, starts=8),
    "oscillator": lambda: gz.plans.orbit_diagram(gz.stroboscopic_map(gz.pinball()), "V", [0.0, 0.1, 0.2], starts=2),
}


@pytest.mark.parametrize("name", PLANS)
def test_a_sweep_is_what_the_study_returns(tmp_path, name):
    plan = PLANS[name]()
    assert sweep.run(plan, tmp_path / "a.zarr", chunk=2).chunks > (0 if name == "portrait" else 1)
    found, expected = sweep.open_store(tmp_path / "a.zarr", plan), run_plan(plan)
    xr.testing.assert_identical(found, expected)
    assert list(found.variables) == list(expected.variables)
    for variable in expected.variables:
        assert found[variable].dtype == expected[variable].dtype, variable
    assert sweep.verify(tmp_path / "a.zarr", 1.0, plan=plan).ok
    with xr.open_zarr(tmp_path / "a.zarr") as raw:
        assert set(plan.variables) <= set(raw.data_vars)


def test_every_plan_is_tried():
    assert set(gz.plans.__all__) <= set(PLANS)


def test_a_configuration_is_kept_and_goes_on_by_itself(tmp_path):
    config = {"study": "density", "map": "gap", "parameters": {"lam": 0.8, "l": 0.2}, "vary": {"mu": "0:0.3:6"}}
    plan, store = plan_of(config), tmp_path / "a.zarr"
    sweep.run(plan, store, chunk=2, shard=(2, 2))
    assert sweep.resume(store).complete
    assert sweep.verify(store).ok
    found = sweep.open_store(store)
    xr.testing.assert_identical(found.drop_attrs(deep=False), run_plan(plan).drop_attrs(deep=False))
    assert "grazing_recipe" in found.attrs and "grazing_note" not in found.attrs
