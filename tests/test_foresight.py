"""What a study will take is known from its sizes: what does not fit is refused before anything is allocated."""

import inspect
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest

import grazing as gz
from grazing import plans
from grazing.config.settings import STUDIES, WHOLE, settings_of
from grazing.studies.plan import run_plan

#: Sizes that no machine has room for, of what is held in memory. (Steps that pass by only take time.)
HUGE = 10**13
HELD = {"starts", "keep", "bins"}
#: What varies, in commands that are otherwise complete: a gap map, which needs no compiler worth speaking of.
COMMANDS = {
    "diagram": "mu=0:0.1:4", "density": "mu=0:0.1:4", "chart": "mu=0:0.1:3 l=0:0.1:3", "basins": "x=0:0.1:4 mu=0.1",
    "lyapunov": "mu=0:0.1:4", "coexistence": "mu=0:0.1:4",
}  # fmt: skip
PROGRAM = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
import grazing.memory
grazing.memory.physical_memory = lambda: 2 << 30  # so that the machine's own size decides nothing
from grazing.cli import main
for line in sys.stdin.read().splitlines():
    sys.stderr.write("\\n>" + line + "\\n")
    print(main(line.split()), flush=True)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
"""


def sizes(study):
    """What a study holds in memory; a density uses its points up as they come."""
    return [
        name for name in settings_of(study).model_fields if name in HELD - ({"keep"} if study == "density" else set())
    ]


def test_every_study_has_its_command_here():
    assert set(COMMANDS) == set(STUDIES) - set(WHOLE)
    assert {size for study in COMMANDS for size in sizes(study)} == HELD


def test_no_size_is_allocated_before_it_is_refused():
    """Each study with each of its sizes out of all proportion, run and dry, in a process of little memory."""
    lines = [
        f"{study} {varies} --map gap --lam 0.8 {'' if study == 'chart' else '--l 0.1'} -q --{size} {HUGE}{dry}"
        for study, varies in COMMANDS.items()
        for size in sizes(study)
        for dry in ("", " --dry-run")
    ]
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], input="\n".join(lines), capture_output=True, text=True, timeout=300
    )
    *codes, peak = done.stdout.split()
    assert codes == ["2"] * len(lines), done.stderr
    assert done.stderr.count("more than half of the memory") == len(lines)
    assert int(peak) < 600  # megabytes, most of them the compiler


def examples(cells=40, starts=60):
    """A plan of each study that takes some megabytes; every function of grazing.plans has one."""
    G, x = gz.gap_map(0.8, 0.1, 0.2), np.linspace(0.02, 0.3, cells)
    yield plans.orbit_diagram(G, "mu", x, starts=starts, transient=50, keep=300)
    yield plans.orbit_diagram(G, "mu", x, starts=starts, transient=50, keep=300, sweep="up")
    yield plans.density(G, "mu", x, starts=starts, transient=50, keep=3000, bins=20_000)
    yield plans.chart(G, {"mu": x, "l": x[::4]}, starts=8, transient=50, keep=100, exponent_steps=20)
    yield plans.lyapunov(G, "mu", x, starts=starts, transient=50, keep=200, steps=50)
    yield plans.coexistence(G, "mu", x, starts=starts, transient=50, keep=200)
    yield plans.basins(G, {"x": np.linspace(-1, 1, 20_000)}, transient=50, keep=64)


def test_every_plan_says_what_it_takes():
    found = list(examples())
    made = {plan.config["study"] for plan in found}
    assert made == {name for name, kind in vars(plans).items() if inspect.isfunction(kind)}
    small = [run_plan(plan, threads=1) for plan in examples(cells=4, starts=3)]  # compiles
    assert len(small) == len(found)
    for plan in found:
        tracemalloc.start()
        try:
            run_plan(plan, threads=1)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        stated = plan.memory(plan.cells, 1)
        assert 0.1 * stated < peak < 1.2 * stated + 2e6, (plan, peak, stated)


def test_what_does_not_fit_says_what_to_lower(monkeypatch):
    monkeypatch.setattr("grazing.memory.physical_memory", lambda: 10**8)
    G = gz.gap_map(0.8, 0.1, 0.2)
    for size, advice in (
        ({"starts": 10**6}, r"the orbits of one cell would take .* reduce starts \(1000000\) or keep \(500\)"),
        ({"bins": 10**7, "range": (-1.0, 1.0)}, r"bins would take .* reduce bins \(10000000\)"),
    ):
        with pytest.raises(gz.InputError, match=advice):
            plans.density(G, "mu", [0.1], **size)
    with pytest.raises(gz.InputError, match=r"reduce mu \(3000\), start \(100\), n \(50\), or sweep into"):
        gz.orbit_diagram(G, "mu", np.linspace(0.0, 0.1, 3000))


def test_a_dry_run_takes_little_and_leaves_the_compiler_out():
    from grazing import sweep

    G = gz.gap_map(0.8, 0.1, 0.2)
    plan = plans.density(G, "mu", [0.1, 0.2], starts=2 * 10**6, keep=10, range=(-1.0, 1.0))
    tracemalloc.start()
    try:
        found = sweep.estimate(plan)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found.rough and found.memory > 10 * peak and found.seconds > 0.0
    assert "roughly" in str(found) and "too large to be tried" in str(found)

    def slow_to_compile(state, p):
        (x,) = state
        for a, b in ((1.0, 2.0), (3.0, 4.0), (5.0, 6.0)):
            x = x + 0.0 * a * b
        return (p.a * x,)

    fresh = gz.Map(slow_to_compile, {"a": 0.5}, ("x",), ((0.1, 0.9),))
    few = plans.density(fresh, "a", [0.1, 0.2], starts=2, keep=10, transient=10, range=(-1.0, 1.0))
    first = sweep.estimate(few, threads=1)
    assert not first.rough and first.seconds < 0.5  # the compiler takes longer than that
