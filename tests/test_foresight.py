"""What a study will take is known from its sizes: what does not fit is refused before anything is allocated."""

import inspect
import json
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import grazing as gz
from grazing import plans
from grazing.catalogue import studies
from grazing.config.settings import settings_of
from grazing.config.values import range_of
from grazing.studies.cobweb import cobweb
from grazing.studies.plan import run_plan

#: Sizes that no machine has room for, of what is held in memory. (Steps that pass by only take time.)
HUGE = 10**13
HELD = {"starts", "keep", "bins"}
#: What varies, in commands that are otherwise complete: a gap map, which needs no compiler worth speaking of; of two
#: coordinates an oscillator.
COMMANDS = {
    "diagram": "mu=0:0.1:4", "density": "mu=0:0.1:4", "chart": "mu=0:0.1:3 l=0:0.1:3", "basins": "x=0:0.1:4 mu=0.1",
    "lyapunov": "mu=0:0.1:4", "coexistence": "mu=0:0.1:4", "statistics": "mu=0:0.1:4", "portrait": "d=0.1",
}  # fmt: skip
GAP = "--map gap --lam 0.8"
MADE = {"chart": GAP, "portrait": ""}
#: Megabytes at the most, of this process alone: what ``getrusage`` says begins with that of the one that started it.
PEAK = """
def peak():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) // 1024 for line in file if line.startswith("VmHWM"))
"""
PROGRAM = (
    PEAK
    + """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
import grazing.memory
grazing.memory.physical_memory = lambda: 2 << 30  # so that the machine's own size decides nothing
from grazing.cli import main
for line in sys.stdin.read().splitlines():
    sys.stderr.write("\\n>" + line + "\\n")
    print(main(line.split()), flush=True)
print(peak())
"""
)


pytestmark = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is measured as Linux does")


def sizes(study):
    """What a study holds in memory; a density and a portrait use their points up as they come."""
    passing = {"keep"} if study in ("density", "portrait") else set()
    return [name for name in settings_of(study).model_fields if name in HELD - passing]


def test_every_study_has_its_command_here():
    assert set(COMMANDS) == {name for name, study in studies().items() if study.plan}
    assert {size for study in COMMANDS for size in sizes(study)} == HELD


def test_no_size_is_allocated_before_it_is_refused():
    """Each study with each of its sizes out of all proportion, run and dry, in a process of little memory."""
    lines = [
        f"{study} {varies} {MADE.get(study, GAP + ' --l 0.1')} -q --{size} {HUGE}{dry}"
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
    yield plans.portrait(
        gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4)), starts=starts, transient=5, keep=3000, bins=900
    )
    yield plans.word_statistics(G, "mu", x, starts=starts, transient=50, keep=300)
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


def test_a_dry_run_of_very_many_steps_is_soon_done_and_says_how_long_they_take(monkeypatch):
    from grazing import sweep

    monkeypatch.setattr(sys.modules["grazing.sweep.estimate"], "PATIENCE", 0.02)

    G = gz.gap_map(0.8, 0.1, 0.2)
    for steps in ({"transient": 10**12}, {"keep": 10**12}):
        plan = plans.density(G, "mu", [0.1, 0.2], starts=500, **steps)  # with a trial for the range, which is short
        found = sweep.estimate(plan, threads=1)
        assert found.seconds >= 2 * 500 * 10**12 * 1e-9 and "roughly" in str(found)


def test_preimages_that_would_be_followed_for_hours_are_refused():
    """A dry run knew the cells alone, and said 0.001 s of what went on for ever after them."""
    P = gz.stroboscopic_map(gz.pinball(d=0.1))
    grid = {"u": np.array([0.1, 0.2]), "v": np.array([0.0, 0.1])}
    for call in (lambda n: gz.plans.basins(P, grid, preimages=n), lambda n: gz.grazing_curve(P.model, preimages=n)):
        with pytest.raises(gz.InputError, match="preimages = 101; allowed is a whole number from 0 to 100"):
            call(101)


def test_preimages_go_on_from_those_before_them(monkeypatch):
    """Each order was followed again from the touch: 40 of them took 1.5 million flights."""
    from grazing.orbits import touches

    flights, flown_back = [], touches.flown_back
    monkeypatch.setattr(
        touches, "flown_back", lambda seen, lines: (flights.append(len(lines)), flown_back(seen, lines))
    )
    free = gz.pinball(alpha=0, k=1.3, r=0.95, V=0, d=0.12)
    gz.grazing_curve(free, preimages=30, points=50)
    assert 1000 < sum(flights) < 20_000


def test_checks_that_would_run_for_hours_are_refused():
    G = gz.gap_map(0.8, 0.1, 0.2)
    for call, given in (
        (gz.testing.check_map, {"P": G, "states": 10**9}),
        (gz.testing.check_map, {"P": G, "states": 1, "steps": 10**9}),
        (gz.testing.check_model, {"model": gz.pinball(), "periods": 10**9}),
    ):
        with pytest.raises(gz.InputError, match=r"1000000000.* would run for long; at most \d+ at a time"):
            call(**given)


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


#: A complete call of every public function that computes, in a process of little memory; see ATTACK.
CALLS = """
import numpy as np
G, m, v = gz.gap_map(0.8, 0.5, 1.0), gz.pinball(d=0.12, V=0.4), np.linspace(0.4, 0.6, 3)
saddle = gz.one_impact_orbits(gz.pinball(d=0.105, V=0.4), 2)[-1]
one = gz.periodic_orbits(G, 2)[0]
T = gz.table([gz.drain("out", (0, -1), (9, -1))], tilt=0.5)
two = gz.table([gz.disc(name, (x, 3.0), 1.0, gz.newton(1.0)) for name, x in (("A", 3.0), ("B", 6.0))])
logistic = gz.Map(lambda x, p: (p.a * x[0] * (1.0 - x[0]),), {"a": 3.8})
CALLS = {
    "adding_tree": dict(lam=0.5, l=0.1, depth=2), "basins": dict(P=G, grid={"x": v}),
    "bifurcation_diagram": dict(P=G, name="mu", values=v),
    "boundaries": dict(P=m, x=("d", 0.05, 0.15), y=("V", 0.3, 0.4), N=2),
    "chart": dict(P=G, params={"mu": v, "l": v}), "coexistence": dict(P=G, name="mu", values=v),
    "escape_rate": dict(P=gz.collision_map(two)),
    "continuation": dict(P=G, orbit=one, name="mu", bounds=(0.4, 0.6)), "density": dict(P=G, name="mu", values=v),
    "launch_map": dict(table=T, point=(0.5, 0.0)),
    "launches": dict(table=T, point=(0.5, 0.0), angle=0.7, speed=[0.5, 1.5]),
    "grazes": dict(table=T, point=(0.5, 0.0), angle=(0.2, 0.7), speed=(0.5, 1.5), order=0, cells=(2, 2)),
    "grazing_curve": dict(model=m), "ladder": dict(model=m, name="d", N=2), "lyapunov": dict(P=G, name="mu", values=v),
    "manifolds": dict(orbit=saddle), "one_impact_orbits": dict(model=m, N=2),
    "orbit_diagram": dict(P=G, name="mu", values=v), "periodic_orbits": dict(P=logistic, period=2),
    "response": dict(P=gz.stroboscopic_map(m), name="d", values=v - 0.3),
    "sensitivity": dict(model=m, name="d", N=2), "trajectory": dict(model=m, state=(0.1, 0.0)),
    "validity": dict(model=m, params={"d": v, "V": v}), "windows": dict(model=m, name="d", N=2),
    "portrait": dict(P=gz.stroboscopic_map(m)), "word_statistics": dict(P=G),
    "words": dict(letters=2, length=3, impacts=2), "zero_one": dict(series=np.sin(np.arange(200.0))),
}
"""
#: Each call with each of its whole numbers out of all proportion, stopped by an interrupt after half a second.
ATTACK = (
    PEAK
    + """
import inspect, json, resource, signal, time, warnings
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
import grazing as gz, grazing.memory
from grazing.late import optimize, signal as _, xarray  # for what is imported an interrupt waits
grazing.memory.physical_memory = lambda: 2 << 30
warnings.simplefilter("ignore")
%s
signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
for name, call in CALLS.items():
    for what, item in inspect.signature(getattr(gz, name)).parameters.items():
        if "int" not in str(item.annotation).split(" | ")[0].split("[")[0] or what in ("seed", "threads"):
            continue
        begin, function = time.monotonic(), getattr(gz, name)
        signal.setitimer(signal.ITIMER_REAL, 0.5)
        try:
            function(**{**call, what: 10**13})
            end = "ended"
        except KeyboardInterrupt:
            end = "stopped"
        except gz.InputError as error:
            end = "refused"
        except BaseException as error:
            end = repr(error)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        print(json.dumps((name, what, end, round(time.monotonic() - begin, 1))), flush=True)
print(peak())
"""
)
#: Public functions without a whole number that sizes anything.
UNSIZED = {
    "active", "attractors", "certify", "check_certificate", "cite", "describe", "discontinuity_map", "enclose",
    "gap_map", "graph", "impact_map", "linearised_map", "load", "locus", "newton", "normal_form", "pinball", "reset",
    "in_units", "sample", "save", "spectrum", "stroboscopic_map", "to_csv", "to_dataframe", "to_parquet", "to_wav",
    "arc", "collision_map", "disc", "drain", "flipper", "flips", "plunger", "presses", "read_table", "segment",
    "strategy", "table", "triggered", "wall", "zdm", "zdm_points",
}  # fmt: skip
#: What only takes time, or is an upper limit that other things end before; such a run is stopped at once by Ctrl-C.
PASSING = {
    ("bifurcation_diagram", "period"), ("bifurcation_diagram", "points"),
    ("continuation", "limit"), ("continuation", "points"),
    ("density", "keep"), ("ladder", "last"), ("lyapunov", "steps"),
    ("manifolds", "steps"), ("portrait", "keep"), ("response", "period"), ("response", "points"), ("words", "impacts"),
}  # fmt: skip


def test_every_public_function_refuses_a_size_or_can_be_stopped():
    done = subprocess.run([sys.executable, "-c", ATTACK % CALLS], capture_output=True, text=True, timeout=300)
    *lines, peak = done.stdout.split("\n")[:-1]
    ends = [json.loads(line) for line in lines]
    called = {name for name, *_ in ends}
    functions = {name for name in gz.__all__ if inspect.isfunction(getattr(gz, name))}
    assert called == functions - UNSIZED, done.stderr[-2000:]
    for name, what, end, seconds in ends:
        passing = what == "transient" or (name, what) in PASSING
        assert end in (("ended", "stopped", "refused") if passing else ("refused",)), (name, what, end)
        assert seconds < 20.0, (name, what, seconds)  # most of it the compiler
    assert int(peak) < 700


def test_lists_of_periods_and_axes_have_a_bound(monkeypatch):
    model = gz.pinball(d=0.12, V=0.4)
    for N in (10**13, range(1, 10**13), [1, 1001]):
        for call in (
            lambda N: gz.windows(model, "d", N),
            lambda N: gz.sensitivity(model, "d", N),
            lambda N: gz.ladder(model, "d", N),
            lambda N: gz.boundaries(model, ("d", 0.1, 0.2), ("V", 0.3, 0.4), N=N),
        ):
            with pytest.raises(gz.InputError, match="whole number from 1 to 1000"):
                call(N)
    monkeypatch.setattr("grazing.memory.physical_memory", lambda: 10**9)
    with pytest.raises(gz.InputError, match=r"mu with 100000000 values would take 6.4 GB.*smaller count"):
        range_of("0:1:100000000", "mu")


def test_a_cobweb_throws_its_transient_away_step_by_step():
    G = gz.gap_map(0.8, 0.1, 0.2)
    cobweb(G, [0.1], steps=7, transient=9)  # compiles
    tracemalloc.start()
    try:
        found = cobweb(G, [0.1], steps=7, transient=10**6)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 8e6
    whole, late = G.orbit([0.1], 50), cobweb(G, [0.1], steps=7, transient=43)
    np.testing.assert_array_equal(late.x, whole.points[43:, 0])
    np.testing.assert_array_equal(late.letter, whole.letters[43:])
    assert found.sizes["n"] == 8
