"""Plans: every cell once, in any pieces; progress, exceptions, Ctrl-C, memory and labels."""

import threading
import time

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import memory
from grazing.memory import physical_memory, refuse_too_large
from grazing.studies.plan import Plan, Variable, empty_arrays, labelled, run_plan
from tests.processes import python

P = gz.gap_map(0.5, 0.1, 0.1)


def sums(axes, together=1, seen=None, **more):
    """A plan whose cells hold the sum of their coordinates, twice over, and a text."""
    grids = np.meshgrid(*axes.values(), indexing="ij")
    total = np.add.reduce(grids).ravel()

    def compute(cells, arrays):
        for i, cell in enumerate(cells.tolist()):
            if seen is not None:
                seen.append(cell)
            arrays["sum"][i] = total[cell]
            arrays["both"][i] = total[cell], -total[cell]
            arrays["said"][i] = f"cell {cell}"
            yield

    variables = {
        "sum": Variable((), "float64", {"units": "1"}),
        "both": Variable(("side",), "float32", {}),
        "said": Variable((), "text", {"long_name": "what was said"}, longest=12),
    }
    return Plan(
        P=P, title="sums", config={"study": "sums"}, axes=axes, sizes={"side": 2}, variables=variables, compute=compute,
        together=together, work=1, **more,
    )  # fmt: skip


@pytest.mark.parametrize("threads", [1, 3, None])
@pytest.mark.parametrize("together", [0, 1, 5, 7, 1000])
def test_every_cell_is_computed_once(threads, together):
    seen = []
    plan = sums({"a": np.arange(57.0)}, together, seen)
    result = run_plan(plan, threads)
    assert sorted(seen) == list(range(57))
    assert (result["sum"] == result.a).all()
    if together == 1 and threads == 1:
        assert seen != sorted(seen)  # scattered, because neighbours cost alike


def test_cells_count_through_the_axes_the_last_one_fastest():
    axes = {"a": np.array([0.0, 10.0, 20.0]), "b": np.array([1.0, 3.0]), "c": np.array([0.5, 0.25, 0.0, -1.0])}
    result = run_plan(sums(axes, together=7))
    assert result["sum"].dims == ("a", "b", "c")
    assert result["both"].dims == ("a", "b", "c", "side")
    xr.testing.assert_equal(result["sum"], (result.a + result.b + result.c).drop_attrs())
    assert result.said.values.tolist()[1][0] == [f"cell {8 + i}" for i in range(4)]


def test_one_cell_without_axes():
    plan = sums({"a": np.arange(3.0)})
    alone = Plan(**{**plan.__dict__, "axes": {}})
    assert (alone.cells, alone.shape, alone.dims("both")) == (1, (), ("side",))
    result = run_plan(alone)
    assert result["sum"].shape == () and result["both"].shape == (2,)
    assert result.said.item() == "cell 0"


def test_no_cell_at_all():
    result = run_plan(sums({"a": np.empty(0)}))
    assert result["sum"].shape == (0,)


def test_types_labels_and_coordinates():
    plan = sums(
        {"a": np.arange(4.0)}, axis_attrs={"a": {"symbol": "\\alpha"}}, coords={"side": ("side", ["left", "right"])},
        finish=lambda result: result.assign(doubled=2 * result["sum"]),
    )  # fmt: skip
    result = run_plan(plan)
    assert result.a.attrs == {"symbol": "\\alpha"}
    assert result["sum"].attrs == {"units": "1"}
    assert result["sum"].dtype == np.float64 and result["both"].dtype == np.float32
    assert result.said.dtype == object and all(type(text) is str for text in result.said.values)
    assert result.side.values.tolist() == ["left", "right"]
    assert result.doubled.values.tolist() == [0.0, 2.0, 4.0, 6.0]
    assert result.attrs["title"] == "sums"
    assert '"study":"sums"' in result.attrs["grazing_config"] and '"map":"gap map"' in result.attrs["grazing_config"]
    assert result.attrs == plan.document


def test_sizes():
    plan = sums({"a": np.arange(6.0), "b": np.arange(5.0)})
    assert plan.cells == 30 and plan.shape == (6, 5)
    assert plan.shape_of("sum") == () and plan.shape_of("both") == (2,)
    assert plan.size_of_cell == 8 + 2 * 4 + 8
    arrays = empty_arrays(plan, 30)
    assert sum(array.nbytes for array in arrays.values()) == 30 * plan.size_of_cell
    assert arrays["said"].tolist() == [""] * 30 and not arrays["sum"].any()


def test_cells_in_any_order_and_pieces_are_the_same_cells():
    plan = gz.plans.orbit_diagram(P, "mu", np.linspace(0.0, 0.2, 11), starts=5, transient=20, keep=10)
    whole = run_plan(plan)
    arrays = empty_arrays(plan, plan.cells)
    rng = np.random.default_rng(0)
    for cells in np.array_split(rng.permutation(plan.cells), 4):
        some = empty_arrays(plan, len(cells))
        for _ in plan.compute(cells, some):
            pass
        for name, array in arrays.items():
            array[cells] = some[name]
    xr.testing.assert_identical(labelled(plan, arrays), whole)


@pytest.mark.parametrize("together", [1, 4, 7])
def test_progress_ends_at_the_number_of_cells_and_never_falls(together):
    said = []
    run_plan(sums({"a": np.arange(41.0)}, together), 2, lambda done, total: said.append((done, total)))
    assert said[-1] == (41, 41)
    assert said == sorted(said)


def sleepy(started, action, delay=0.005, **more):
    """A plan of 10,000 cells that calls ``action`` in the third one."""

    def compute(cells, arrays):
        for cell in cells.tolist():
            started.append(cell)
            if len(started) == 3:
                action()
            time.sleep(delay)
            yield

    variables = {"x": Variable((), "float64", {})}
    return Plan(
        P=P, title="sleep", config={}, axes={"a": np.arange(10_000.0)}, variables=variables, compute=compute,
        together=1, work=1, **more,
    )  # fmt: skip


def raising(error):
    def action():
        raise error

    return action


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("error", [ValueError("stop"), KeyboardInterrupt("stop"), gz.InputError("stop")])
def test_an_exception_stops_the_work(error, threads):
    started = []
    with pytest.raises(type(error), match="stop"):
        run_plan(sleepy(started, raising(error)), threads)
    assert len(started) < 1_000


def test_an_interrupt_in_the_calling_thread_stops_the_work():
    started = []

    def interrupted(done, total):
        raise KeyboardInterrupt

    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        run_plan(sleepy(started, lambda: None, 0.01), 2, interrupted)
    assert len(started) < 200
    assert threading.active_count() == before


def test_ctrl_c_stops_a_long_study_soon():
    """One cell of 10^12 steps: only the look between its pieces can end it."""
    code = (
        "import grazing as gz, threading, time, os, signal\n"
        "G = gz.gap_map(0.9, 0.1, 0.0)\n"
        "gz.density(G, 'mu', [0.1], range=(-1, 1), starts=10, keep=10)\n"
        "gone = []\n"
        "threading.Timer(0.5, lambda: (gone.append(time.time()), os.kill(os.getpid(), signal.SIGINT))).start()\n"
        "try:\n"
        "    gz.density(G, 'mu', [0.1, 0.2, 0.3], range=(-1, 1), starts=1000, keep=10**9)\n"
        "except KeyboardInterrupt:\n"
        "    print(time.time() - gone[0])\n"
    )
    done = python(code)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 3.0  # well under a second on an idle machine


@pytest.mark.parametrize("threads", [1, 4])
def test_a_sequential_plan_is_one_task(threads):
    calls = []

    def compute(cells, arrays):
        calls.append(cells.tolist())
        arrays["x"][...] = np.arange(len(cells))
        yield

    plan = Plan(
        P=P, title="in order", config={}, axes={"a": np.arange(50.0)}, compute=compute, together=3, work=1,
        variables={"x": Variable((), "float64", {})}, sequential=True,
    )  # fmt: skip
    said = []
    assert run_plan(plan, threads, lambda *done: said.append(done)).x.values.tolist() == list(range(50))
    assert calls == [list(range(50))]
    assert said[-1] == (50, 50)


def test_too_large_a_result_is_refused_before_it_is_begun(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 10_000)
    plan = sums({"a": np.arange(40.0), "b": np.arange(6.0)})
    with pytest.raises(gz.InputError, match=r"more than half .* reduce a \(40\), b \(6\), side \(2\), or sweep into"):
        run_plan(plan)
    monkeypatch.setattr(memory, "physical_memory", lambda: 2 * 240 * plan.size_of_cell)
    run_plan(plan)


def test_memory(monkeypatch):
    monkeypatch.setattr(memory, "physical_memory", lambda: 8_000_000_000)
    refuse_too_large(4_000_000_000, "reduce keep (50)")
    said = r"would take 4.5 GB, more than half of the memory \(8 GB\); reduce keep \(50\)"
    with pytest.raises(gz.InputError, match=said):
        refuse_too_large(4_500_000_000, "reduce keep (50)")
    monkeypatch.setattr(memory, "physical_memory", lambda: None)
    refuse_too_large(10**18, "keep (50)")


def test_this_machine_has_memory():
    memory = physical_memory()
    assert memory is None or memory > 10**8


@pytest.mark.parametrize("threads", [0, -1, 1.5, "two", True])
def test_threads_are_a_whole_number(threads):
    with pytest.raises(gz.InputError, match=f"threads = {threads!r}; allowed is a whole number >= 1"):
        run_plan(sums({"a": np.arange(3.0)}), threads)
