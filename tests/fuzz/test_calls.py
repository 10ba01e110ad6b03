"""The public functions with extreme arguments: a result, or a message of ours; no bare error, no hang, no flood.

Every public callable has a call that works below, found by introspection, so none is left out. A trial replaces one to
three of its arguments, or something in them.
"""

import contextlib
import functools
import inspect
import random
import types

import matplotlib.pyplot as plt
import numpy as np
import pytest

import grazing as gz
from tests.fuzz.extremes import defect, mutated, shown_safely
from tests.plot import results

MU = np.array([0.05, 0.1, 0.15])
D = np.array([0.1, 0.12])


@functools.cache
def things():
    """What calls need: models, maps, orbits and results, small."""
    G, m = gz.gap_map(lam=0.5, mu=0.1, l=0.2), gz.pinball(d=0.11, V=0.4)
    P = gz.stroboscopic_map(m)
    orbit = gz.one_impact_orbits(m, 3)[0]
    gap_orbit = gz.periodic_orbits(G, period=2)[0]
    branch = gz.continuation(P, orbit, "d", (0.09, 0.13))
    return types.SimpleNamespace(
        saddle=gz.one_impact_orbits(gz.pinball(d=0.105, V=0.4), 2)[-1],
        G=G,
        ball=gz.System(
            ("x",),
            ("v",),
            {"g": 1.0, "r": 0.5},
            falling,
            [gz.Surface("A", fallen, gravity)],
            ((0.1, 1.0), (-1.0, 1.0)),
            period=1.0,
        ),
        m=m,
        P=P,
        Q=gz.impact_map(m),
        orbit=orbit,
        gap_orbit=gap_orbit,
        branch=branch,
        special=branch.special[0],
        locus=gz.locus(branch.special[0], ("d", "V"), ((0.08, 0.14), (0.39, 0.41))),
        diagram=gz.orbit_diagram(G, "mu", MU, starts=3, transient=10, keep=8),
        flown=gz.trajectory(m, (0.1, 0.0), until=5.0),
        segment=G.orbit(0.1, 10),
    )


def bent(state, p):
    return (p.a * state[0] * (1.0 - state[0]),)


def middle(state, p):
    return state[0] - 0.5


def step(x, p):
    return (p.a * x[0] * (1.0 - x[0]),)


def falling(t, t0, state, p):
    s = t - t0
    return state[0] + (state[1] - 0.5 * p.g * s) * s, state[1] - p.g * s


def fallen(t, state, p):
    return state[0], state[1]


def gravity(t, w, state, p):
    return abs(p.g)


def soft(v, p):
    return -p.r * v / (1.0 - p.c * v)


TABLE = gz.table([gz.disc("A", (0.0, 2.0), 0.5, gz.newton(0.5)), gz.drain("out", (-9, -1), (9, -1))], rho=0.1, tilt=0.3)


def never(state, p):
    return False


FLIPPER = gz.flipper("L", (1.2, 1.0), 1.4, (0.2, 0.1), -0.5, 0.6, gz.newton(0.5), up=14.0, down=9.0)
OPEN = gz.collision_map(
    gz.table([gz.disc(name, (x, 3.0), 1.0, gz.newton(1.0)) for name, x in (("A", 3.0), ("B", 6.0), ("C", 9.0))])
)
SMALL = {"starts": 2, "transient": 5, "keep": 4, "seed": 0, "threads": 1}


@functools.cache
def calls():
    """Return by name the function and a call of it that works, and is small."""
    t = things()
    maps = [(t.G, "mu", MU), (t.P, "d", D)]
    found = {
        "Forcing": dict(omega=2.0, t0=0.1, offset=0.1, cos=(1.0, 0.5), sin=(0.1,)),
        "Map": dict(step=step, params={"a": 3.2}, coordinates=("x",), box=((0.0, 1.0),), letters="LR", escape=10.0),
        "Map, by pieces": dict(
            pieces={"L": bent, "R": bent},
            border=middle,
            params={"a": 3.2},
            coordinates=("x",),
            box=((0.0, 1.0),),
        ),
        "Oscillator": dict(alpha=0.1, k=1.0, forcing=gz.Forcing(omega=2.0), reset=gz.newton(0.5), sigma=-0.1),
        "active": dict(r=0.5, V=0.4),
        "newton": dict(r=0.5),
        "triggered": dict(r=0.5, V=0.4, trigger=0.1),
        "wall": dict(position=-0.5, law=gz.newton(0.5), side="below", motion=gz.Forcing(omega=2.0), name="A"),
        "disc": dict(name="A", centre=(0.0, 2.0), radius=0.5, law=gz.newton(0.5)),
        "segment": dict(name="A", start=(0.0, 2.0), stop=(1.0, 2.0), law=gz.newton(0.5)),
        "arc": dict(name="A", centre=(0.0, 2.0), radius=0.5, start=0.0, stop=3.0, law=gz.newton(0.5)),
        "drain": dict(name="A", start=(0.0, 2.0), stop=(1.0, 2.0)),
        "flipper": dict(
            name="L",
            pivot=(1.2, 1.0),
            length=1.4,
            radius=(0.2, 0.1),
            rest=-0.5,
            raised=0.6,
            law=gz.newton(0.5),
            up=14.0,
            down=9.0,
        ),
        "flips": dict(period=2.0, hold=0.3, phase={"L": 0.5}),
        "presses": dict(L=[0.4, 0.7]),
        "strategy": dict(flip=never, gates={"L": ((0.0, 1.0), (1.0, 1.0))}, hold=0.2),
        "plunger": dict(point=(0.5, 0.0), angle=1.5, slow=0.0, fast=2.0),
        "read_table": dict(source="one_bumper"),
        "table": dict(objects=[gz.disc("A", (0.0, 2.0), 0.5, gz.newton(0.5))], rho=0.1, g=1.0, tilt=0.3),
        "table, flipper": dict(objects=[FLIPPER], rho=0.1, g=1.0, tilt=0.3, player=gz.flips(2.0, 0.3)),
        "trajectory, table": dict(model=TABLE, state=(0.1, 3.0, 0.0, 0.0), start=0.0, until=9.0, samples=10),
        "collision_map": dict(table=TABLE, on="A"),
        "escape_rate": dict(P=OPEN, orbits=100, transient=1, steps=2, populations=2, stir=0.02, threads=1),
        "launch_map": dict(table=TABLE, point=(0.5, 0.0), hits=100),
        "grazes": dict(
            table=TABLE, point=(0.5, 0.0), angle=(0.7, 1.0), speed=(0.5, 1.5), order=0, objects=["A"], cells=(2, 2)
        ),
        "launches": dict(table=TABLE, point=(0.5, 0.0), angle=[0.7, 1.0], speed=[0.5, 1.5], hits=100),
        "plot.table": dict(table=TABLE, names=True),
        "testing.check_table": dict(table=TABLE, states=1, seed=0),
        "Surface": dict(name="A", gap=fallen, bound=gravity, law=None),
        "System": dict(
            positions=("x",),
            velocities=("v",),
            params={"g": 1.0, "r": 0.5},
            flight=falling,
            surfaces=[gz.Surface("A", fallen, gravity)],
            box=((0.1, 1.0), (-1.0, 1.0)),
            period=1.0,
            rounding=None,
            name="ball",
        ),
        "System.replace": dict(self=t.ball, g=0.5, r=0.2),
        "testing.check_system": dict(system=t.ball, states=1, seed=0),
        "trajectory, system": dict(model=t.ball, state=(0.5, 0.0), start=0.0, until=2.5, samples=10),
        "stroboscopic_map, system": dict(model=t.ball, phase=0.0),
        "reset": dict(law=soft, contraction=(0.9, 1.0), r=0.8, c=0.1),
        "pinball": dict(alpha=0.3, k=1.0, omega=2.0, t0=0.0, d=0.1, r=0.8, V=0.4, sigma=0.0),
        "gap_map": dict(lam=0.5, mu=0.1, l=0.2),
        "linearised_map": dict(lam=0.5, det=0.1, mu=0.1, l=0.2, root=1.0),
        "stroboscopic_map": dict(model=t.m, phase=0.0),
        "impact_map": dict(model=t.m),
        "discontinuity_map": dict(model=t.m, order="lowest", phase=0.0),
        "zdm": dict(model=t.m, order="full", phase=0.0),
        "zdm_points": dict(model=t.m, state=(0.0, -0.5), phase=0.0),
        "normal_form": dict(model=t.m, name="d"),
        "adding_tree": dict(lam=0.5, l=0.2, depth=2, between=("L", "R"), span=None),
        "attractors": dict(diagram=t.diagram),
        "cite": dict(style="bibtex"),
        "describe": dict(outcome=3),
        "words": dict(letters="LR", length=4, impacts=None),
        "basins": dict(
            P=t.P,
            grid={"u": np.array([0.1, 0.2]), "v": np.array([0.0, 0.1])},
            fixed=None,
            transient=5,
            keep=4,
            preimages=0,
            threads=1,
        ),
        "bifurcation_diagram": dict(P=t.G, name="mu", values=MU, **SMALL, period=2),
        "boundaries": dict(P=t.G, x=("l", 0.1, 0.3), y=("mu", 0.0, 0.2), N=3),
        "certify": dict(orbit=t.gap_orbit),
        "enclose": dict(orbit=t.orbit, kind="pd", name="d"),
        "check_certificate": dict(certificate={}),
        "chart": dict(P=t.G, params={"mu": MU, "l": np.array([0.1, 0.2])}, exponent_steps=5, **SMALL),
        "coexistence": dict(P=t.G, name="mu", values=MU, **SMALL),
        "continuation": dict(P=t.P, orbit=t.orbit, name="d", bounds=(0.105, 0.115), step=0.1, limit=20),
        "density": dict(P=t.G, name="mu", values=MU, bins=10, range=(-1.0, 1.0), coordinate="x", **SMALL),
        "graph": dict(P=t.P, name="u", values=D, fixed={"v": 0.0}, order="lowest"),
        "grazing_curve": dict(model=t.m, phase=0.0, preimages=0, points=20, box=None),
        "ladder": dict(model=t.m, name="d", N=3, rungs=("gap",), span=None, last=3),
        "locus": dict(special=t.special, names=("d", "V"), bounds=((0.08, 0.14), (0.39, 0.41)), step=0.1, limit=20),
        "portrait": dict(P=maps[1][0], across="u", up="v", bins=5, within=((0.0, 1.0), (-1.0, 1.0)), **SMALL),
        "word_statistics": dict(P=t.G, name="mu", values=MU, length=2, most=3, **SMALL),
        "lyapunov": dict(P=t.G, name="mu", values=MU, steps=10, **SMALL),
        "manifolds": dict(orbit=t.saddle, side="unstable", length=0.1, spacing=0.1, box=None, steps=5),
        "one_impact_orbits": dict(model=t.m, N=3),
        "orbit_diagram": dict(P=t.P, name="d", values=D, sweep=None, **SMALL),
        "periodic_orbits": dict(P=t.G, period=2, word=None, virtual=False, starts=10, seed=0, threads=1),
        "response": dict(P=t.P, name="d", values=D, **SMALL, period=1),
        "sensitivity": dict(model=t.m, name="d", N=3, span=(0.1, 0.12), samples=10),
        "trajectory": dict(model=t.m, state=(0.1, 0.0), start=0.0, until=5.0, samples=10),
        "validity": dict(model=t.m, params={"d": D, "V": np.array([0.3, 0.4])}, rung="gap", **SMALL),
        "windows": dict(model=t.m, name="d", N=3, span=(0.1, 0.12), samples=10),
        "zero_one": dict(series=np.sin(np.arange(100.0) ** 2), frequencies=5, seed=0),
        "Map.iterate": dict(self=t.G, state=0.1, n=5),
        "Map.orbit": dict(self=t.P, state=(0.1, 0.0), n=5),
        "Map.__call__": dict(self=t.Q, state=(0.1, 0.5)),
        "Map.jacobian": dict(self=t.P, state=(0.1, 0.0)),
        "Map.replace": dict(self=t.P, d=0.1, phase=0.1),
        "Oscillator.replace": dict(self=t.m, d=0.1, V=0.3),
        "load": dict(path="nothing.nc"),
        "save": dict(result=t.diagram, path="/nowhere/a.nc"),
        "to_dataframe": dict(result=t.flown, dimension="impact"),
        "to_csv": dict(result=t.diagram, path="/nowhere/a.csv"),
        "to_parquet": dict(result=t.diagram, path="/nowhere/a.parquet"),
        "Oscillator.from_si": dict(
            m=0.8,
            c=2.4,
            k="3.2 N/mm",
            gap="1.2 mm",
            reset=gz.newton(0.7),
            force=[2.5, 0.1],
            side="above",
            base=1e-3,
            moves="stop",
            load=-0.5,
            frequency=14.0,
        ),
        "in_units": dict(result=t.flown),
        "sample": dict(trajectory=t.flown, rate=20.0),
        "spectrum": dict(recorded=gz.sample(t.flown, 20.0), of="u", window="hann"),
        "to_wav": dict(trajectory=t.flown, path="/nowhere/a.wav", speed=100.0, of="v", rate=8000),
        "testing.check_map": dict(P=t.G, states=2, steps=2, seed=0),
        "config.checked": dict(
            mapping={
                "study": "diagram",
                "vary": {"d": "0:1:3"},
                "parameters": {"r": 0.7},
                "settings": {"starts": 2, "box": [[0.0, 1.0], [0.0, 1.0]]},
            }
        ),
        "config.command_of": dict(config={"study": "chart", "vary": {"d": "0:1:3", "V": [0.1, 0.2]}}, out=["a.png"]),
        "config.toml_of": dict(config={"study": "chart", "vary": {"d": "0:1:3"}}),
        "config.plan_of": dict(
            config={
                "study": "density",
                "map": "gap",
                "parameters": {"lam": 0.5, "l": 0.1},
                "vary": {"mu": "0:0.1:3"},
                "settings": {"range": [0.0, 1.0], "starts": 2},
            }
        ),
        "config.result_of": dict(
            config={
                "study": "cobweb",
                "map": "gap",
                "parameters": {"lam": 0.5, "mu": 0.1, "l": 0.1},
                "settings": {"state": [0.0], "steps": 3},
            }
        ),
        "config.boundaries_of": dict(
            config={
                "study": "chart",
                "map": "gap",
                "parameters": {"lam": 0.9},
                "curves": "3",
                "vary": {"l": "0:1:3", "mu": "0:0.4:3"},
            }
        ),
        "config.recipe_of": dict(attrs=dict(t.diagram.attrs)),
        "config.load_config": dict(path="nothing.toml"),
        "plot.branch": dict(result=t.branch, coordinate="u"),
        "plot.locus": dict(result=t.locus),
        "plot.orbit_diagram": dict(result=t.diagram),
        "plot.trajectory": dict(result=t.flown),
        "plot.history": dict(result=t.flown),
        "plot.spectrum": dict(result=gz.spectrum(gz.sample(t.flown, 20.0))),
        "plot.chart": dict(result=results.chart(5, 4), by="period", curves=None),
        "plot.basins": dict(result=results.basins(8)),
        "plot.density": dict(result=results.density(bins=5)),
        "plot.lyapunov": dict(result=results.lyapunov()),
        "plot.coexistence": dict(result=results.coexistence()),
        "plot.portrait": dict(result=gz.portrait(maps[1][0], bins=5, **SMALL)),
        "plot.word_statistics": dict(result=gz.word_statistics(t.G, length=2, **SMALL)),
    }
    both = {"coexistence", "chart", "lyapunov", "density", "orbit_diagram"}
    for name in both & {*found}:  # of the oscillator, too
        P, key, values = maps[1]
        given = {**found[name], "P": P}
        given |= {"params": {"d": D, "V": D}} if name == "chart" else {"name": key, "values": values}
        given |= {"coordinate": "u"} if name == "density" else {}
        found[f"{name}, oscillator"] = given
    for module, several in (("theory", gz.theory), ("plans", gz.plans)):
        for name in several.__all__:
            function = getattr(several, name)
            if module == "plans":
                found[f"plans.{name}"] = {
                    k: v for k, v in found[name].items() if k in inspect.signature(function).parameters
                }
            elif callable(function) and not inspect.isclass(function):
                usual = {
                    "N": 3,
                    "N_max": 4,
                    "lam": 0.9,
                    "mu": 0.02,
                    "l": 0.1,
                    "word": "LR",
                    "longest": 4,
                    "length": 3,
                    "M": 4,
                    "n": 3,
                    "ratio": 6.0,
                    "cycles": gz.theory.three_disc_cycles(6.0, 3),
                }
                names = inspect.signature(function).parameters
                found[f"theory.{name}"] = {key: usual[key] for key, p in names.items() if key in usual}
    return found


#: Public names that are no functions to call, and those drawn or swept by tests of their own.
NOT_CALLED = {
    "Attractor",
    "BounceOrbit",
    "Branch",
    "Certificate",
    "GrazingError",
    "ImpactOrbit",
    "InputError",
    "Locus",
    "NormalForm",
    "Orbit",
    "Orbits",
    "Outcome",
    "OutsideForm",
    "PieceOrbit",
    "Searched",
    "Trust",
    "UserCodeError",
    "__version__",
    "config",
    "plans",
    "plot",
    "sweep",
    "testing",
    "theory",
}


#: Counts of work: a large one that is allowed takes long because it was asked for.
COUNTS = {
    "starts",
    "transient",
    "keep",
    "steps",
    "exponent_steps",
    "n",
    "length",
    "bins",
    "points",
    "samples",
    "limit",
    "preimages",
    "depth",
    "frequencies",
    "states",
    "until",
    "spacing",
    "rate",
}


def asks_for_long_work(key, value):
    if type(value) not in (int, float, np.int8, np.uint64):
        return False
    return (key in COUNTS and 1e5 < abs(value) < 2.0**63) or (key == "spacing" and 0.0 < value < 1e-3)


def function_of(name):
    at = gz
    for part in name.partition(",")[0].split("."):
        at = getattr(at, part)
    return at


def trial(seed, names=None):
    """Return the call of a seed and what is wrong with its end."""
    known = calls()
    chosen = random.Random(seed)
    name = chosen.choice(sorted(names or known))
    given = dict(known[name])
    for key in chosen.sample(sorted(given), min(len(given), chosen.choice((1, 1, 2, 3)))):
        changed = mutated(given[key], chosen)
        if key not in ("threads", "self") and not asks_for_long_work(key, changed):
            given[key] = changed
    inner = given.pop("self", None)
    function = function_of(name)
    positional = () if inner is None else (inner,)
    try:
        found = defect(lambda: function(*positional, **given))
    finally:
        plt.close("all")
    return f"{name}({', '.join(f'{key}={shown_safely(value)}' for key, value in given.items())})", found


def test_every_public_function_is_called():
    known = {name.partition(",")[0].partition(".")[0] for name in calls()}
    assert {*gz.__all__} - NOT_CALLED <= known
    assert {f"theory.{name}" for name in gz.theory.__all__ if inspect.isfunction(getattr(gz.theory, name))} <= {
        *calls()
    }
    assert {f"config.{name}" for name in gz.config.__all__} - {"config.json_schema"} <= {*calls()}


def test_the_calls_work_as_they_are():
    files = {
        "load",
        "save",
        "to_csv",
        "to_parquet",
        "to_wav",
        "check_certificate",
        "config.load_config",
    }  # that are not there
    for name, given in calls().items():
        inner = [given["self"]] if "self" in given else []
        with contextlib.suppress(*[gz.InputError] if name in files else [gz.OutsideForm] if "theory" in name else []):
            function_of(name)(*inner, **{key: value for key, value in given.items() if key != "self"})
    plt.close("all")


def failures(seeds):
    found = [(seed, *trial(seed)) for seed in seeds]
    return [f"seed {seed}: {call}\n    {wrong}" for seed, call, wrong in found if wrong]


def test_extreme_arguments_are_answered():
    wrong = failures(range(300))
    assert not wrong, "\n".join(wrong)


@pytest.mark.long
@pytest.mark.parametrize("part", range(10))
def test_very_many_extreme_arguments_are_answered(part):
    wrong = failures(range(1000 + 300 * part, 1300 + 300 * part))
    assert not wrong, "\n".join(wrong)


HOLDS_ITSELF: list = []
HOLDS_ITSELF.append(HOLDS_ITSELF)
LOOPED: dict = {}
LOOPED["a"] = LOOPED


@pytest.mark.parametrize(
    "call",
    [
        lambda: gz.zdm_points(gz.pinball(), (0.0, 0.5)),
        lambda: gz.boundaries(gz.gap_map(lam=0.5, mu=0.1, l=0.2), np.array([]), ("l", 0.0, 1.0), N=3),
        lambda: gz.config.plan_of({"study": "diagram"}, code=np.zeros(2)),
        lambda: gz.config.toml_of(LOOPED),
        lambda: gz.theory.cycle_expansion([], per=np.zeros(2)),
        lambda: gz.plot.density(HOLDS_ITSELF),
        lambda: gz.check_certificate(10**5000),
    ],
)
def test_arrays_in_the_place_of_a_word_and_what_holds_itself_are_refused(call):
    """A division by zero, RecursionError, and ValueError about the truth of an array."""
    with pytest.raises(gz.GrazingError):
        call()
