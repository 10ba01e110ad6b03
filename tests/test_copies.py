"""Whatever a session holds can be pickled, copied and sent to another process, and is the same there."""

import copy
import importlib
import inspect
import os
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from importlib.util import MAGIC_NUMBER
from multiprocessing import get_context

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.outline import Outline
from grazing.copies import alike
from grazing.maps.columns import Columns
from grazing.orbits.one_impact import one_impact_orbits
from grazing.studies.graph import graph_of
from tests.processes import python
from tests.systems.balls import bouncing


def soft(v, p):
    return -p.r * v / (1.0 - p.c * v)


def logistic(state, p):
    (x,) = state
    return (p.a * x * (1.0 - x),)


def halved(p):
    return p


def softer(state, p):
    (x,) = state
    return (0.5 * p.a * (1.0 - x),)


def border(state, p):
    return state[0] - 0.5


def models():
    yield "pinball", gz.pinball(d=0.12, V=0.4)
    forced = gz.Forcing(2.8, t0=0.1, offset=0.05, cos=(1.0, 0.2), sin=(0.1,))
    for name, law in laws():
        yield name, gz.Oscillator(0.1, 1.0, forced, law, sigma=-0.1)
    shaken = gz.wall(0.5, gz.newton(0.6), motion=gz.Forcing(5.6, t0=0.3, cos=(0.01,)))
    yield "walls", gz.Oscillator(0.1, 0.5, forced, walls=(gz.wall(-0.5, gz.newton(0.8)), shaken))


def laws():
    yield "newton", gz.newton(0.8)
    yield "active", gz.active(0.8, 0.2)
    yield "triggered", gz.triggered(r=0.5, V=0.4, trigger=0.1)
    yield "own law", gz.reset(soft, r=0.8, c=0.1)
    yield "own law, contraction", gz.reset(soft, r=0.8, c=0.1, contraction=(0.9, 0.5))


def maps():
    ball = gz.pinball(d=0.12, V=0.4)
    yield "gap", gz.gap_map(0.8, 0.05, 0.1)
    yield "linearised", gz.linearised_map(0.8, 0.05, 0.1, 0.1)
    yield "own map", gz.Map(logistic, {"a": 3.2}, ("x",), ((0.1, 0.9),))
    yield "own map, prepared", gz.Map(logistic, {"a": 3.2}, ("x",), ((0.1, 0.9),), prepare=halved, letters="L")
    yield "own map, by pieces", gz.Map(pieces={"L": logistic, "R": softer}, border=border, params={"a": 3.2})
    yield "impact", gz.impact_map(ball)
    yield "discontinuity", gz.discontinuity_map(ball, "full", phase=0.3)
    yield "zdm", gz.zdm(ball)
    yield "own law", gz.stroboscopic_map(ball.replace(V=0.2), phase=0.4)
    yield "xy", gz.normal_form(ball, "d").xy_map()
    for name, model in models():
        yield f"strobe, {name}", gz.stroboscopic_map(model)


def falls(state, p):
    return state[3] < -0.5


def systems():
    left = gz.flipper("L", (1.5, 1.5), 1.5, 0.2, -0.5, 0.5, gz.newton(0.8), up=8.0, down=4.0)
    for player in (gz.flips(1.0, {"L": 0.2}), gz.strategy(falls, {"L": ((1.5, 3.0), (3.0, 3.0))}, hold=0.2)):
        yield f"table, {type(player).__name__}", gz.table([left], rho=0.1, tilt=0.3, player=player)
    yield "system", bouncing(height=0.7)
    yield "surface", bouncing().surfaces[0]


def found():
    G = gz.gap_map(0.8, 0.5, 1.0)
    orbits = gz.periodic_orbits(G, 2)
    ball = gz.pinball(d=0.12, V=0.4)
    yield "orbits", orbits
    yield "orbit", orbits[0]
    yield "searched", orbits.searched
    branch = gz.continuation(G, orbits[0], "mu", (0.4, 0.6))
    yield "branch", branch
    yield "special point", branch.special[0]
    yield "orbit of pieces", next(iter(branch))
    yield "impact orbit", one_impact_orbits(ball, 3)[-1]
    discs = [gz.disc(name, (x, 0.0), 1.0, gz.newton(1.0)) for name, x in (("A", 0.0), ("B", 6.0))]
    yield "bounce orbit", gz.periodic_orbits(gz.collision_map(gz.table(discs)), word="AB")[0]
    yield "normal form", gz.normal_form(ball, "d")
    logistic_map = dict(maps())["own map"]
    yield "own branch", gz.continuation(logistic_map, gz.periodic_orbits(logistic_map, 1)[0], "a", (2.5, 3.3))


def proofs():
    """Dear ones: a locus, and certificates of both kinds of orbits."""
    orbit = gz.one_impact_orbits(gz.pinball(d=0.11, V=0.4), 3)[0]
    special = gz.continuation(orbit.map, orbit, "d", (0.09, 0.13)).special[0]
    yield "locus", gz.locus(special, ("d", "V"), ((0.0, 0.14), (0.2, 0.6)))
    yield "proof of an orbit of the gap map", gz.certify(gz.periodic_orbits(gz.gap_map(0.8, 0.5, 1.0), 2)[0])
    yield "certificate", gz.certify(gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)[-1])


def plans():
    G, own, x = gz.gap_map(0.8, 0.1, 0.2), dict(maps())["own map"], np.linspace(0.1, 0.9, 3)
    small = {"transient": 20, "keep": 10}
    yield "density", gz.plans.density(G, "mu", x, starts=2, bins=4, **small)
    yield "diagram", gz.plans.orbit_diagram(own, "a", [2.5, 3.0, 3.5], starts=2, sweep="up", **small)
    yield "chart", gz.plans.chart(G, {"mu": x, "l": x}, starts=2, exponent_steps=5, **small)
    yield "basins", gz.plans.basins(own, {"x": x}, **small)
    yield "lyapunov", gz.plans.lyapunov(own, "a", [3.0, 3.9], starts=2, steps=20, **small)
    yield "coexistence", gz.plans.coexistence(G, "mu", x, starts=3, **small)


THINGS = {
    f"{kind.__name__}: {name}": thing
    for kind in (laws, models, maps, systems)
    for name, thing in [*kind(), *([("forcing", gz.Forcing(2.0))] if kind is laws else [])]
}


PROVEN = {"Locus", "Certificate"}


def there(thing):
    """What another process says of a thing."""
    return repr(thing), thing


def copies(thing):
    yield from (pickle.loads(pickle.dumps(thing, protocol)) for protocol in (2, pickle.HIGHEST_PROTOCOL))
    yield from (copy.copy(thing), copy.deepcopy(thing))


def same(thing):
    for other in copies(thing):
        assert type(other) is type(thing) and repr(other) == repr(thing)
        assert other == thing and not other != thing and hash(other) == hash(thing)


@pytest.mark.parametrize("name", THINGS)
def test_laws_models_and_maps(name):
    same(THINGS[name])
    thing = THINGS[name]
    if isinstance(thing, gz.Map):
        start = [0.5 * (low + high) for low, high in thing.box]
        with np.errstate(all="ignore"):
            assert all(alike(tuple(other.orbit(start, 5)), tuple(thing.orbit(start, 5))) for other in copies(thing))
        assert pickle.loads(pickle.dumps(thing)).replace(**thing.params) == thing
        name = next(iter(thing.params))
        assert thing.replace(**{name: 0.75 * thing.params[name]}) != thing


def test_orbits_branches_and_normal_forms():
    for _name, thing in found():
        same(thing)
    branch = dict(found())["branch"]
    assert pickle.loads(pickle.dumps(branch)).at(0.5) == branch.at(0.5)


def test_loci_and_certificates():
    kinds = set()
    for _name, thing in proofs():
        same(thing)
        kinds.add(type(thing).__name__)
    assert kinds == {*PROVEN, "GapProof"}


def test_plans_and_what_they_compute():
    from grazing.studies.plan import run_plan

    for _name, plan in plans():
        for other in (pickle.loads(pickle.dumps(plan)), copy.deepcopy(plan)):
            assert other == plan and other.document == plan.document
        assert run_plan(pickle.loads(pickle.dumps(plan))).identical(run_plan(plan))


def test_other_values_are_not_equal():
    laws_, models_, maps_ = dict(laws()), dict(models()), dict(maps())
    for group in (laws_, models_, maps_, dict(plans())):
        things = list(group.values())
        assert all((a == b) == (i == j) for i, a in enumerate(things) for j, b in enumerate(things)), group
        assert len({hash(thing) for thing in things}) > len(things) // 2
    assert gz.newton(0.8) != gz.newton(0.7) and gz.newton(0.8) != 0.8


def test_spawned_workers_run_them():
    wanted = [maps_ for name, maps_ in maps() if name in ("gap", "own map", "strobe, own law")]
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        for thing in [*wanted, next(plans())[1], gz.reset(soft, r=0.8, c=0.1)]:
            said, back = pool.submit(there, thing).result(timeout=300)
            assert said == repr(thing) and back == thing
        P = wanted[0]
        assert pool.submit(P.iterate, (0.1,), 20).result(timeout=300).tolist() == P.iterate((0.1,), 20).tolist()


# ---- functions that no module has at its top


def made(factor):
    def law(v, p):
        return -p.r * factor * v

    return law


def test_a_function_that_no_other_process_could_find_travels_whole_or_says_why_not(monkeypatch):
    things = [
        gz.reset(lambda v, p: -p.r * v, r=0.5),
        gz.reset(made(0.9), r=0.5),
        gz.Map(lambda state, p: (p.a * state[0],), {"a": 0.5}),
        gz.strategy(lambda state, p: state[3] < 0.0, {"L": ((0.0, 0.0), (1.0, 0.0))}, hold=0.1),
    ]
    things.append(gz.Oscillator(0.1, 1.0, gz.Forcing(2.0), things[1]))
    pytest.importorskip("cloudpickle")
    for thing in things:
        assert pickle.loads(pickle.dumps(thing)) == thing
        assert copy.deepcopy(thing) == thing
    assert gz.reset(made(0.9), r=0.5) != gz.reset(made(0.8), r=0.5)
    monkeypatch.setitem(sys.modules, "cloudpickle", None)
    for thing in things:
        with pytest.raises(
            gz.InputError, match=r"cannot be pickled.* define it at the top of a module with def, or pip"
        ):
            pickle.dumps(thing)
        assert copy.deepcopy(thing) == thing  # nothing leaves this process


def test_a_map_from_a_file_of_ones_own_travels_whole(tmp_path):
    """Its module has a name that no other process knows."""
    pytest.importorskip("cloudpickle")
    from grazing.config.own import Named, own_object

    (tmp_path / "mine.py").write_text(
        "import grazing as gz\ndef step(state, p):\n    return (p.a * state[0],)\nP = gz.Map(step, {'a': 0.5})\n"
    )
    (tmp_path / "a.pickle").write_bytes(pickle.dumps(own_object(Named(f"{tmp_path}/mine.py:P"))))
    program = f"import pickle; print(pickle.load(open({str(tmp_path / 'a.pickle')!r}, 'rb')).iterate((8.0,), 3)[-1, 0])"
    done = python(program)
    assert (done.stdout, done.returncode) == ("1.0\n", 0), done.stderr


LAW = """
import types
from math import exp
HERE = types.ModuleType("here")
HERE.GAIN, FACTOR, PAIR = 1.0, 0.9, (1.0, 3.0)
BELOW = types.ModuleType("below"), 1
BELOW[0].LOSS = 1.0
def helper(v, *, scale=1.0):
    return 2.0 * v * exp(0.0) * scale * PAIR[0]
def law(v, p):
    return -0.5 * p.r * FACTOR * HERE.GAIN * helper(v) * BELOW[0].LOSS
"""


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("-0.5", "-0.4"), ("0.9", "0.8"), ("2.0", "1.9"), ("-0.5 * p.r", "-p.r / 2"),
        ("= 1.0,", "= 1.1,"), ("from math", "from cmath"), ("(1.0, 3", "(1.1, 3"), ("=1.0)", "=0.9)"),
        ("LOSS = 1.0", "LOSS = 0.9"),
    ],
)  # fmt: skip
def test_a_function_of_the_same_name_is_not_taken_for_the_one_that_was_pickled(tmp_path, monkeypatch, before, after):
    """A law that was edited since, or the number or function that it names, was taken in silence."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "theirs.py").write_text(LAW)
    theirs = importlib.import_module("theirs")
    try:
        packed = pickle.dumps([gz.reset(theirs.law, r=0.8), gz.Map(logistic, {"a": 3.2})])
        player = pickle.dumps(gz.strategy(theirs.law, {"L": ((0.0, 0.0), (1.0, 0.0))}, hold=0.1))
        exec(f"# moved\n\n{LAW}", vars(theirs))
        assert pickle.loads(packed)[0] == gz.reset(theirs.law, r=0.8)
        exec(LAW.replace(before, after), vars(theirs))
        for one in (packed, player):
            with pytest.raises(gz.InputError, match=r"theirs\.law is not the function that was pickled"):
                pickle.loads(one)
        exec("law = float", vars(theirs))
        with pytest.raises(gz.InputError, match="is not the function that was pickled"):
            pickle.loads(packed)
    finally:
        del sys.modules["theirs"]


def test_a_function_that_takes_more_than_one_number_of_a_module_is_found_in_another_process(tmp_path):
    """They were compared in the order of a set of texts, which is another one in every process."""
    (tmp_path / "numbers_of_theirs.py").write_text("A, B, C, D, E = 1.0, 2.0, 3.0, 4.0, 5.0\n")
    (tmp_path / "theirs.py").write_text(
        "import numbers_of_theirs as n\ndef law(v, p):\n    return -p.r * v * (n.A + n.B + n.C + n.D + n.E)\n"
    )
    path = os.pathsep.join([str(tmp_path), os.path.dirname(os.path.dirname(gz.__file__))])
    told = (
        "import sys, pickle, theirs; from grazing.copies import Code\n"
        "if sys.argv[1:]: pickle.loads(bytes.fromhex(sys.argv[1]))\n"
        "print(pickle.dumps(Code(theirs.law)).hex())"
    )
    found = ""
    for seed in "123":
        done = subprocess.run(
            [sys.executable, "-c", told, *found.split()],
            env={**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        found = done.stdout


@pytest.mark.parametrize("gone", ["del law", "FACTOR = 1", None, "raise ValueError('broken')", "import nothing_at_all"])
def test_a_function_that_is_gone_is_named(tmp_path, monkeypatch, gone):
    """That was an AttributeError, or whatever the module raised, without a word on what to do."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "theirs.py").write_text(LAW)
    theirs = importlib.import_module("theirs")
    try:
        law = gz.reset(theirs.law, r=0.8)
        packed = [pickle.dumps(law), pickle.dumps(gz.Oscillator(0.1, 1.0, gz.Forcing(2.0), law))]
    finally:
        del sys.modules["theirs"]
    source = tmp_path / "theirs.py"
    source.write_text("" if gone is None else f"{gone}\n" if gone != "del law" else f"{LAW}\n{gone}\n")
    if gone is None:
        source.unlink()
    importlib.invalidate_caches()
    for one in packed:
        with pytest.raises(gz.InputError, match=r"theirs\.law, which was pickled by its name, is not found here \("):
            pickle.loads(one)
    sys.modules.pop("theirs", None)


def test_a_function_that_travelled_whole_needs_its_python_and_cloudpickle(monkeypatch):
    pytest.importorskip("cloudpickle")
    packed = pickle.dumps(gz.reset(lambda v, p: -p.r * v, r=0.5))
    with pytest.raises(gz.InputError, match="takes the version of Python that pickled it"):
        pickle.loads(packed.replace(MAGIC_NUMBER, b"\0\0\r\n"))
    monkeypatch.setattr("grazing.copies.find_spec", lambda _name: None)
    with pytest.raises(gz.InputError, match="takes cloudpickle: pip install it"):
        pickle.loads(packed)


def test_functions_of_a_program_travel_to_another_one(tmp_path):
    """They were sought by name in whatever program opened the pickle."""
    pytest.importorskip("cloudpickle")
    (tmp_path / "one.py").write_text(
        f"import pickle, grazing as gz\n{LAW}\npickle.dump(gz.reset(law, r=0.8), open('a.pickle', 'wb'))\n"
    )
    (tmp_path / "two.py").write_text(
        "import pickle\nfrom types import SimpleNamespace\ndef law(v, p):\n    return 0.0\n"
        "theirs = pickle.load(open('a.pickle', 'rb'))\nprint(theirs.law(-1.0, SimpleNamespace(r=1.0)))\n"
    )
    for name, said in (("one.py", ""), ("two.py", "0.9\n")):
        done = subprocess.run([sys.executable, name], cwd=tmp_path, capture_output=True, text=True)
        assert (done.returncode, done.stdout) == (0, said), done.stderr


def test_a_set_of_texts_in_a_law_is_the_same_in_every_process():
    """Its order is another one in each, and made of the same law another one."""
    program = "from grazing.kernel.content import digest; print(digest(lambda x: x in {'a', 'b', 'c', 'd', 'e'}))"
    made = [
        subprocess.run(
            [sys.executable, "-c", program], env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, text=True
        ).stdout
        for seed in "12"
    ]
    assert made[0] == made[1] != ""


def test_every_public_class_is_here():
    """A new one has to be added above: of each there is an object that was copied, or a reason why not."""
    plain = {"GrazingError", "InputError", "OutsideForm", "UserCodeError", "Outcome", "Trust"}
    covered = {type(thing).__name__ for thing in [*THINGS.values(), *dict(found()).values()]}
    covered |= {base.__name__ for thing in dict(found()).values() for base in type(thing).__mro__}
    public = {name for name in gz.__all__ if inspect.isclass(getattr(gz, name))}
    assert public - covered - plain == {"Attractor", *PROVEN}
    for name in plain:
        kind = getattr(gz, name)
        one = next(iter(kind)) if hasattr(kind, "__members__") else kind("said")
        assert repr(pickle.loads(pickle.dumps(one))) == repr(one)
    attractor = gz.attractors(gz.orbit_diagram(gz.gap_map(0.8, 0.5, 1.0), "mu", [0.5], starts=2))[0]
    assert alike(pickle.loads(pickle.dumps(attractor)), attractor)


def test_what_has_arrays_in_it_compares_by_value():
    """A tuple asks whether all of an array is true or not: ValueError, even for an object and itself."""
    m, P = gz.pinball(d=0.12), gz.gap_map(lam=0.5, mu=0.1, l=0.1)
    made = {
        "zdm_points": lambda u: gz.zdm_points(m, (0.02, -0.3 * u)),
        "orbit": lambda u: P.orbit((0.01 * u,), 5),
        "columns": lambda u: Columns(*(np.full((1, 2), u) for _ in range(6))),
        "graph": lambda u: graph_of(P, [-0.1, 0.1 * u]),
        "outline": lambda u: Outline("a", np.full((3, 2), u), True, False, False, "a"),
    }
    for make in made.values():
        one, same, other = make(1), make(1), make(2)
        assert one == same and not one != same and hash(one) == hash(same)
        assert one != other and not one == other and one != tuple(one) and len({one, same, other}) == 2
        assert copy.deepcopy(one) == one == pickle.loads(pickle.dumps(one))
