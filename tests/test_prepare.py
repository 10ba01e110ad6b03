"""What is prepared is all that the first hour needs: the ten lines of the README and each study compile nothing."""

import json
import os
import re
import sys
import types
from pathlib import Path

import pytest

import grazing
from grazing import prepare
from grazing.kernel.prepared import stamp
from grazing.kernel.wide import plain
from tests.processes import python

ROOT = Path(__file__).parents[1]
SOURCE = str(Path(grazing.__file__).parents[1])
TEN_LINES = re.search(r"## Ten lines to paste\n\n```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)[1]
STUDIES = """
import numpy as np
import grazing as gz

m = gz.pinball(alpha=3, k=1, omega=2.2, d=0.12, r=0.8, V=0.4)
P = gz.stroboscopic_map(m)
gz.chart(P, {"d": np.linspace(0.05, 0.16, 10), "V": np.linspace(0.1, 0.4, 10)})
gz.lyapunov(P.replace(d=0.05))
gz.basins(P)
orbits = gz.periodic_orbits(P, range(1, 5))
gz.continuation(P, orbits[0], "d", (0.0, 0.16))
gz.trajectory(m, (0.1, 0.0))
gz.impact_map(m).orbit((0.0, 0.5), 50)
for order in ("lowest", "full", "corrected"):
    D = gz.discontinuity_map(m, order=order)
    D.orbit((0.1, 0.0), 50)
    gz.orbit_diagram(D, "d", [0.1, 0.12], starts=2, transient=10)
"""
TABLES = """
import grazing as gz

classic = gz.read_table("classic")
gz.trajectory(classic, (5.275, 0.7, 0.0, 17.0), until=5.0)
gz.launches(classic, speed=[14.0, 15.0])
launch = gz.launch_map(classic)
P = gz.collision_map(gz.table([each for each in classic.objects if each.kind in ("disc", "segment")], rho=0.1))
for each in P, gz.collision_map(classic):
    each.orbit([0.5 * (low + high) for low, high in each.box], 5)
gz.orbit_diagram(P, "g", [1.0, 1.1], starts=2, transient=5)
gz.lyapunov(P, "g", [1.0, 1.1], transient=5)
floor = gz.table([gz.segment("floor", (0, 0), (5, 0), gz.active(r=0.9, V=0.3))], rho=0.1, tilt=0.2)
grid = {"place": [2.0, 2.1], "speed": [3.0, 3.5]}
gz.basins(gz.collision_map(floor), grid, fixed={"angle": 0.0}, transient=10)  # a ball that settles, slowly
gz.basins(launch, {"angle": [1.5, 1.6], "speed": [14.0, 15.0]}, transient=5)
gz.orbit_diagram(launch, "g", [1.0, 1.1], starts=2, transient=5)
"""
WALLS = """
import grazing as gz

walls = gz.wall(-0.3, gz.newton(0.8)), gz.wall(0.3, gz.newton(0.7))
for cos in (1.0,), (1.0, 0.2):
    m = gz.Oscillator(0.2, 1.1, gz.Forcing(omega=1.7, cos=cos), walls=walls)
    gz.trajectory(m, (0.1, 0.0))
    for P, start in (gz.stroboscopic_map(m), (0.1, 0.0)), (gz.impact_map(m), (0.0, 0.5)):
        P.orbit(start, 20)
        P.jacobian(start)
        gz.orbit_diagram(P, "offset", [0.0, 0.1], starts=2, transient=10)
"""
OWN = """
import numpy as np
import grazing as gz

def step(x, p):
    return p.a - 1.0009765625 * x[0] * x[0] + p.b * x[1], x[0]

P = gz.Map(step, {"a": 1.2, "b": 0.3}, ("x", "y"), box=((-1.0, 1.0), (-1.0, 1.0)), escape=10.0)
values = np.linspace(1.0, 1.4, 5)
gz.orbit_diagram(P, "a", values)
gz.chart(P, {"a": values, "b": [0.2, 0.3]})
gz.lyapunov(P, "a", values)
gz.basins(P)
gz.bifurcation_diagram(P, "a", np.linspace(0.2, 0.8, 4))
gz.continuation(P, gz.periodic_orbits(P, 1)[0], "a", (1.0, 1.3))

def longer(x, p):
    return p.a - 1.0009765625 * x[0] * x[0] + p.b * x[2], x[0], x[1]

P = gz.Map(longer, {"a": 1.2, "b": 0.3}, ("x", "y", "z"), box=((-1.0, 1.0),) * 3, escape=10.0)
gz.orbit_diagram(P, "a", values, starts=2)
gz.lyapunov(P, "a", values, starts=2)
gz.basins(P, {"x": [0.0, 0.5], "y": [0.0, 0.5]}, fixed={"z": 0.0}, transient=20)
gz.periodic_orbits(P, 1)
"""
SYSTEM = """
import grazing as gz

def fall(t, t0, state, p):
    s = t - t0
    return state[0] + (state[1] - 0.5 * s) * s, state[1] - s

def gap(t, state, p):
    return state[0] - p.low, state[1]

def bound(t, w, state, p):
    return 1.0009765625

floor = gz.Surface("A", gap, bound)
ball = gz.System(("x",), ("v",), {"low": 0.1, "r": 0.5}, fall, [floor], box=((0.5, 1.0), (-1.0, 1.0)), period=1.0)
gz.trajectory(ball, (0.5, 0.0), until=1.0)
P = gz.stroboscopic_map(ball)
P.jacobian(P((0.5, 0.1))[0])
"""
PROGRAM = """
import json, sys
sys.path.insert(0, {source!r})
from numba.core import event

class Heard(event.Listener):
    def on_start(self, said):
        heard.append(said.data["dispatcher"].py_func.__name__.rpartition("_")[0])
    def on_end(self, said):
        pass

heard = []
event.register("numba:compile", Heard())
exec({text!r}, {{}})
print(json.dumps(heard))
"""


def compiled_by(text, folder):
    """Return what is compiled while a program runs with a new cache."""
    if plain() or not stamp().exists() or stamp().read_text() != prepare._made_from(""):
        pytest.skip("no kernels are prepared from these sources: make prepared")
    program = PROGRAM.format(source=SOURCE, text=text)
    done = python(program, env={**os.environ, "GRAZING_CACHE": str(folder)})
    assert done.returncode == 0 and "compiling" not in done.stderr, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize(
    "text", [TEN_LINES, STUDIES, WALLS, TABLES], ids=["the ten lines", "the studies", "walls", "tables"]
)
def test_the_first_calls_wait_for_no_compiler(tmp_path, text):
    assert compiled_by(text, tmp_path) == [] and not list(tmp_path.iterdir())


def test_of_a_map_of_ones_own_nothing_but_the_step_is_compiled(tmp_path):
    assert compiled_by(OWN, tmp_path)
    kept = {file.name.partition("-")[0] for file in tmp_path.iterdir()}
    assert kept == {"block", "derive"}  # a step, and its derivative


def test_of_a_system_of_ones_own_nothing_but_the_first_contact_is_compiled(tmp_path):
    assert compiled_by(SYSTEM, tmp_path)
    assert [file.name.partition("-")[0] for file in tmp_path.iterdir()] == ["answer"]  # one, strict, for all of it


def test_a_family_that_this_processor_does_not_run_is_refused(monkeypatch):
    monkeypatch.setattr(prepare, "machines", lambda own: [own])
    monkeypatch.setattr(sys, "argv", ["prepare", "--family", "x86-64-v2"])
    with pytest.raises(SystemExit, match="this processor does not run code for x86-64-v2"):
        prepare.main()


def test_two_that_prepare_at_the_same_time_both_end_well(tmp_path, monkeypatch):
    """The second one begins and ends while the first one is about to give a file its name."""
    monkeypatch.setattr(prepare, "folder", lambda: tmp_path)
    names = ["a.nbc", "b.nbc"]
    replace, inside = Path.replace, []

    def compiled(command, env, **_given):
        for name in names:
            (Path(env["GRAZING_CACHE"]) / name).write_text(name)
        return types.SimpleNamespace(communicate=lambda: ("", ""), returncode=0)

    def meanwhile(self, target):
        if not inside:
            inside.append(True)
            assert prepare.prepared() == 2
        return replace(self, target)

    monkeypatch.setattr(prepare.subprocess, "Popen", compiled)
    monkeypatch.setattr(prepare, "stamp", lambda _family: tmp_path / "stamp")
    monkeypatch.setattr(Path, "replace", meanwhile)
    assert prepare.prepared() == 2 and inside
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.nbc", "b.nbc", "stamp"]
    assert [(tmp_path / name).read_text() for name in names] == names
