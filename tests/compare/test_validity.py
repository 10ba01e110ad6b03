"""A validity map against a naive twin, its classes, and that it does not depend on how it is cut into tasks."""

from collections import Counter

import numpy as np
import pytest

import grazing as gz
from grazing.compare.validity import AGREEMENT, BEYOND, NONE, OUTSIDE, PARTLY, SAME, UNUSED, plan, validity, write
from grazing.outcome import InputError, OutsideForm
from grazing.studies.plan import empty_arrays
from tests.models import TWO

S = gz.pinball(alpha=3, k=1, omega=2.2, r=0.8, V=0.4)


def naive(model, name, rung, start, steps=400, keep=12):
    """The letters of flow and reduction from one state at half a period after the graze, step by step."""
    form = gz.normal_form(model, name)
    T = model.period
    flow = gz.stroboscopic_map(model, phase=form.time + 0.5 * T)
    state = flow.iterate(start, steps)[-1]
    first = flow.orbit(state, keep).letters
    # free flight of half a period: no wall
    free = gz.trajectory(model.replace(sigma=-1e3), start, start=form.time + 0.5 * T, until=form.time + T, samples=2)
    at = np.array([free.u.values[-1], free.v.values[-1]])
    if rung == "gap":
        P = form.gap_map(model.params[name])
        at = form.to_xy(at)[:1] / form.scale
    else:
        P = gz.discontinuity_map(model, order=rung, phase=form.time)
    second = P.orbit(P.iterate(at, steps)[-1], keep).letters
    return first.tolist(), second.tolist()


def spelled(letters, period):
    """The least rotation of the last letters as a word in L and R."""
    s = "".join("LR"[letter] for letter in letters[-period:])
    return min(s[i:] + s[:i] for i in range(period))


@pytest.mark.parametrize("rung", ["gap", "corrected"])
def test_against_the_maps_one_by_one(rung):
    starts = np.array([[0.02, 0.1], [0.06, -0.1], [0.09, 0.25]])
    values = {"d": [0.1, 0.127], "V": [0.2, 0.4]}
    found = validity(S, values, rung=rung, starts=starts)
    for d in values["d"]:
        for V in values["V"]:
            cell = found.sel(d=d, V=V)
            pairs = [naive(S.replace(d=d, V=V), "d", rung, start) for start in starts]
            for of, i in (("flow", 0), ("reduced", 1)):
                periods = cell[f"{of}_period"].values
                words = Counter()
                for pair in pairs:
                    N = next(n for n in range(1, 7) if pair[i][n:] == pair[i][:-n])
                    words[spelled(pair[i], N), N] += 1
                listed = {
                    (str(w), int(p)): round(3 * float(s))
                    for w, p, s in zip(cell[f"{of}_word"].values, periods, cell[f"{of}_share"].values, strict=True)
                    if p != UNUSED
                }
                assert listed == dict(words)


def test_a_reduction_holds_near_the_graze_and_not_far_from_it():
    near = validity(S, {"d": np.linspace(0.129, 0.1308, 8), "r": [0.7, 0.8]}, starts=8, rung="corrected")
    assert (near.agreement == SAME).mean() > 0.6
    assert near.overlap.mean() > 0.9
    far = validity(S, {"d": [-0.1, -0.05], "V": [0.0, 0.1]}, starts=8, rung="corrected")
    assert (far.agreement != SAME).all() and far.overlap.max() == 0.0
    assert near.graze.values == pytest.approx(np.full(2, 0.1309618693499))
    assert near.graze.dims == ("r",)


def test_above_the_graze_nothing_hits():
    for rung in ("gap", "linearised"):
        found = validity(S, {"V": [0.1, 0.4], "d": [0.14, 0.2]}, starts=4, rung=rung)
        assert (found.agreement == SAME).all() and (found.overlap == 1.0).all()
        assert (found.flow_word.sel(rank=0) == "L").all() and (found.reduced_word.sel(rank=0) == "L").all()


def test_several_impacts_in_a_period_are_beyond_the_reduction():
    found = validity(S, {"d": [-0.4, -0.3], "V": [0.0, 0.05]}, starts=4)
    assert (found.agreement.sel(V=0.0) == BEYOND).all()
    assert not set("".join(found.flow_word.sel(V=0.0, rank=0).values)) <= {"L", "R"}


def test_outside_its_form():
    found = validity(gz.pinball(alpha=0.5, k=1.0, V=0.1), {"omega": [1.2, 1.3], "d": [1.0]}, starts=2)
    codes = dict(zip(found.omega.values.tolist(), found.agreement.values[:, 0].tolist(), strict=True))
    forms = gz.normal_form(gz.pinball(alpha=0.5, k=1.0, V=0.1, d=1.0), "omega")
    assert set(codes.values()) == {OUTSIDE} if forms.b <= 0.0 else OUTSIDE not in codes.values()
    cells = validity(gz.pinball(alpha=0.5, k=1.0, omega=1.3), {"d": [1.0], "V": [0.0, 0.1]}, starts=2)
    assert (cells.agreement == OUTSIDE).all() and cells.overlap.isnull().all()
    assert (cells.reduced_period == UNUSED).all() and (cells.flow_period.sel(rank=0) >= 1).all()
    assert "b = -0.308335 <= 0" in cells.attrs["outside"]
    linear = validity(gz.pinball(alpha=0.5, k=1.0, omega=1.3), {"d": [1.04], "V": [0.01]}, starts=2, rung="linearised")
    assert (linear.agreement == SAME).all() and linear.flow_word.values[0, 0, 0] == "R"


def test_the_flow_and_its_graze_are_the_same_outside_the_form():
    # where b <= 0 the flow was seen at phase 0, where these starts go elsewhere, and the graze was not told
    push = gz.Forcing(3.52, t0=-5.39, offset=0.685, cos=(1.08,), sin=(-0.7,))
    model = gz.Oscillator(1.07, 1.983, push, gz.triggered(0.9465, 0.2168, 0.4287), 0.024)
    starts = [(0.0808, -2.1724), (0.2763, -0.4838), (0.2493, 0.6784)]
    values = {"offset": [0.685], "V": [0.2168]}
    gap, linear = (validity(model, values, starts=starts, transient=80, rung=rung) for rung in ("gap", "linearised"))
    assert gap.agreement.item() == OUTSIDE != linear.agreement.item()
    for name in ("flow_word", "flow_period", "flow_share", "graze"):
        assert np.array_equal(gap[name], linear[name]), name


def test_harmonics_and_a_wall_that_moves():
    model = gz.Oscillator(2.5, 1.1, TWO, sigma=-0.3, reset=gz.active(r=0.7, V=0.2))
    graze = gz.normal_form(model, "sigma").graze
    found = validity(
        model, {"sigma": graze + np.array([-0.05, 2e-3, 5e-3]), "r": [0.5, 0.9]}, starts=4, rung="linearised"
    )
    assert found.attrs["unfolds"] == "sigma"
    assert (found.flow_word.isel(sigma=0, rank=0) == "L").all()
    assert (found.agreement == SAME).mean() >= 0.5
    assert (found.flow_word.isel(sigma=slice(1, None), rank=0) != "L").all()


def written(flow, reduced, ranks=3):
    made = plan(S, {"d": [0.1], "V": [0.1]}, starts=3)
    arrays = {name: np.zeros((1, *((ranks,) if v.dims else ())), object if v.kind == "text" else v.dtype)
              for name, v in made.variables.items()}  # fmt: skip
    write(arrays, 0, flow, reduced, ranks)
    return int(arrays["agreement"][0]), float(arrays["overlap"][0]), arrays


def test_the_classes():
    a, b, c = ("LR", 2), ("LLR", 3), ("02", 2)
    assert written([a, a, b, b], [a, b, b, b])[:2] == (SAME, 0.75)
    assert written([a, a, b, b], [a, a, a, a])[:2] == (PARTLY, 0.5)
    assert written([a, a, a, a], [b, b, b, b])[:2] == (NONE, 0.0)
    assert written([a, a, a, a], [("LR", 4)] * 4)[:2] == (NONE, 0.0)  # a doubled orbit is another one
    assert written([c, c, c, c], [b, b, b, b])[:2] == (BEYOND, 0.0)
    assert written([c, c, a, a], [a, a, a, a])[:2] == (PARTLY, 0.5)
    assert written([("", 0)] * 4, [("", 0)] * 4)[:2] == (SAME, 1.0)
    assert written([("", 0)] * 4, [a] * 4)[0] == NONE
    code, overlap, arrays = written([a, a, b, b], None)
    assert code == OUTSIDE and np.isnan(overlap) and (arrays["reduced_period"] == UNUSED).all()
    assert arrays["flow_period"].tolist() == [[2, 3, UNUSED]]
    assert len(AGREEMENT) == 5


def test_the_cut_into_tasks_does_not_matter():
    grid = {"d": np.linspace(0.09, 0.13, 7), "V": [0.1, 0.3]}
    whole = validity(S, grid, starts=5, seed=3, threads=1)
    made = plan(S, grid, starts=5, seed=3)
    for cell in (0, 5, 13):
        arrays = empty_arrays(made, 1)
        for _ in made.compute(np.array([cell]), arrays):
            pass
        at = dict(zip(("d", "V"), np.unravel_index(cell, made.shape), strict=True))
        for name, values in arrays.items():
            assert values[0].tolist() == whole[name].isel(at).values.tolist()
    assert validity(S, grid, starts=5, seed=3, threads=2).equals(whole)


def test_it_can_be_swept(tmp_path):
    made = plan(S, {"d": [0.1, 0.12], "V": [0.2, 0.4]}, starts=4)
    gz.sweep.run(made, tmp_path / "validity.zarr")
    memory = validity(S, {"d": [0.1, 0.12], "V": [0.2, 0.4]}, starts=4)
    gz.save(memory, tmp_path / "validity.nc")
    again = gz.load(tmp_path / "validity.nc")
    assert again.agreement.equals(memory.agreement) and again.flow_word.equals(memory.flow_word)
    stored = gz.load(tmp_path / "validity.zarr")
    for name in ("agreement", "overlap", "flow_share", "reduced_period"):
        assert stored[name].equals(memory[name])
    assert made.document["grazing_config_sha256"] == memory.attrs["grazing_config_sha256"]


def test_what_is_refused():
    grid = {"d": [0.1], "V": [0.1]}
    with pytest.raises(InputError, match="rung is 'flow'; allowed are gap, linearised"):
        validity(S, grid, rung="flow")
    with pytest.raises(InputError, match="give two parameters"):
        validity(S, {"d": [0.1]})
    with pytest.raises(InputError, match="unknown parameter 'phase' of the model"):
        validity(S, {"d": [0.1], "phase": [0.0]})
    with pytest.raises(OutsideForm, match="the graze depends on neither r nor V"):
        validity(S, {"r": [0.1], "V": [0.1]})
    with pytest.raises(InputError, match="model"):
        validity(gz.gap_map(0.5, 0.1, 0.1), grid)
    with pytest.raises(InputError, match="starts"):
        validity(S, grid, starts=0)
    assert plan(S, grid, rung="gap").axes["V"].tolist() == [0.1]
