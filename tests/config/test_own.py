"""Maps and models from a user's own file."""

import copy
import json
import os
import pickle
import re
import tomllib

import pytest

from grazing import InputError, UserCodeError
from grazing.cli.app import main
from grazing.config import checked, command_of, load_config, plan_of, result_of
from grazing.config.own import Named, NotNamed, located, own_object

FILE = """
import grazing as gz

def step(state, p):
    (x,) = state
    return (p.r * x * (1.0 - x),)

logistic = gz.Map(step, params={"r": 3.2, "shift": 0.0}, coordinates=("x",), box=((0.1, 0.9),))

def soft(v, p):
    return -p.r * v / (1.0 - p.c * v)

ball = gz.Oscillator(alpha=0.1, k=1, forcing=gz.Forcing(omega=2.8), sigma=-0.1, reset=gz.reset(soft, r=0.8, c=0.1))
def right(state, p):
    return (p.r * state[0],)

def border(state, p):
    return state[0] - p.shift

pieces = gz.Map(pieces={"L": step, "R": right}, border=border, params={"r": 0.5, "shift": 0.3})
number = 3
"""


@pytest.fixture
def own(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(FILE)
    return file


def test_a_map_of_ones_own_has_its_own_parameters_and_ranges(own):
    config = {"study": "diagram", "map": f"{own}:logistic", "vary": {"r": "2.8:3.8:5"}, "settings": {"starts": 3}}
    found = checked(config, code="trust")
    assert found["parameters"] == {"shift": 0.0}
    result = result_of(config, code="trust")
    assert result.sizes["r"] == 5
    assert result.period.values[0].tolist() == [1, 1, 1]
    with pytest.raises(InputError, match=r"parameters.alpha: unknown parameter; allowed are r, shift"):
        checked({**config, "parameters": {"alpha": 1.0}}, code="trust")
    with pytest.raises(InputError, match=r"parameters.shift = 'x' is not a real number"):
        checked({**config, "parameters": {"shift": "x"}}, code="trust")


def test_a_map_by_pieces_is_named_and_travels_as_any_other(own):
    with pytest.raises(NotNamed):
        own_object(f"{own}:pieces")
    P = own_object(Named(f"{own}:pieces"))
    assert P.letters == "LR" and pickle.loads(pickle.dumps(P)) == P == copy.deepcopy(P)
    config = {"study": "diagram", "map": f"{own}:pieces", "vary": {"r": "0.2:0.4:3"}}
    assert checked(config, code="trust")["parameters"] == {"shift": 0.3}
    assert plan_of(config, code="trust").P == P.replace(r=plan_of(config, code="trust").P.params["r"])


def test_a_model_of_ones_own(own):
    config = {"study": "diagram", "model": f"{own}:ball", "vary": {"c": "0:0.2:3"}, "parameters": {"r": 0.7}}
    assert plan_of(config, code="trust").P.params["r"] == 0.7
    with pytest.raises(InputError, match="law: the model brings its own reset law"):
        checked({**config, "law": "newton"}, code="trust")
    with pytest.raises(InputError, match=r"vary.r = 1.5; allowed is 0 <= r <= 1"):
        checked({**config, "vary": {"r": "0:1.5:3"}}, code="trust")


def test_an_oscillator_in_the_place_of_a_map_is_its_stroboscopic_map(own):
    found = checked({"study": "diagram", "map": f"{own}:ball", "vary": {"c": "0:0.2:3"}}, code="trust")
    assert (found["map"], found["model"]) == ("stroboscopic", f"{own}:ball")
    assert command_of(found) == f"grazing diagram c=0:0.2:3 --model {own}:ball"


def test_a_file_is_found_from_the_folder_of_the_configuration(own, tmp_path, monkeypatch):
    (tmp_path / "study.toml").write_text('study = "diagram"\nmap = "mine.py:logistic"\nvary = { r = "3:4:5" }\n')
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert load_config(tmp_path / "study.toml")["map"] == f"{own}:logistic"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nothing", "has no name 'nothing'; it has ball, logistic"),
        ("number", "number in .* is a int; allowed are a gz.Map, a gz.Oscillator and a gz.System"),
    ],
)
def test_what_is_not_there_is_said(own, name, said):
    with pytest.raises(InputError, match=said):
        checked({"study": "diagram", "map": f"{own}:{name}", "vary": {"r": "3:4:5"}}, code="trust")


def test_a_map_is_no_model_and_a_gap_has_none(own):
    with pytest.raises(InputError, match=r"is a gz.Map; give it as the map"):
        checked({"study": "diagram", "model": f"{own}:logistic", "vary": {"d": "0:1:2"}}, code="trust")
    gap = {"study": "diagram", "map": "gap", "parameters": {"lam": 0.5, "l": 0.1}, "vary": {"mu": "0:1:2"}}
    with pytest.raises(InputError, match="model: the map gap is not made of an oscillator"):
        checked({**gap, "model": f"{own}:ball"}, code="trust")
    with pytest.raises(InputError, match="both name an oscillator"):
        checked(
            {"study": "diagram", "map": f"{own}:ball", "model": f"{own}:ball", "vary": {"d": "0:1:2"}}, code="trust"
        )


def test_a_file_that_fails_is_named(tmp_path):
    (tmp_path / "bad.py").write_text("1/0\n")
    with pytest.raises(InputError, match=r"bad.py cannot be run: ZeroDivisionError"):
        checked({"study": "diagram", "map": f"{tmp_path}/bad.py:P", "vary": {"d": "0:1:2"}}, code="trust")
    with pytest.raises(UserCodeError):
        own_object(Named(f"{tmp_path}/bad.py:P"))
    with pytest.raises(InputError, match=r"map: there is no file"):
        checked({"study": "diagram", "map": f"{tmp_path}/none.py:P", "vary": {"d": "0:1:2"}}, code="trust")


@pytest.mark.parametrize("line", ["import sys; sys.exit(0)", "exit()", "raise SystemExit('done')"])
def test_a_file_that_ends_itself_is_named(tmp_path, capsys, line):
    """A program without a guard around its end was run, nothing was computed, and the exit code was that: 0."""
    (tmp_path / "program.py").write_text(f"{line}\n{FILE}")
    assert main(["diagram", "--map", f"{tmp_path}/program.py:logistic", "r=2.5:3.5:3"]) == 2
    assert re.fullmatch(r"error: --map: \S+program\.py cannot be run: SystemExit: .+\n", capsys.readouterr().err)


@pytest.mark.parametrize("line", ["raise GeneratorExit", "class E(BaseException): pass\nraise E('x')"])
def test_a_file_that_raises_what_is_no_exception_is_named(tmp_path, capsys, line):
    """It escaped as a traceback."""
    (tmp_path / "program.py").write_text(f"{line}\n")
    assert main(["diagram", "a=0:1:3", "--map", f"{tmp_path}/program.py:P"]) == 2
    said = capsys.readouterr().err
    assert re.fullmatch(r"error: --map: \S+program\.py cannot be run: (GeneratorExit|\S*E: x)\n", said)


RAISES = """
class Odd(gz.Oscillator):
    @property
    def params(self):
        raise KeyError("mine")

odd = Odd(0.1, 1.0, gz.Forcing(2.8), gz.newton(0.8))
"""
ENDS = RAISES.replace('KeyError("mine")', "SystemExit")
MUTE = "\nclass Mute(Exception):\n    def __str__(self):\n        raise ValueError\n\nraise Mute\n"


@pytest.mark.parametrize(
    ("lines", "code", "said"),
    [(RAISES, 1, "line 26 of {file} raised KeyError: 'mine'"),
     (RAISES.replace('KeyError("mine")', "GeneratorExit"), 1, "line 26 of {file} raised GeneratorExit"),
     (MUTE, 2, "--model: {file} cannot be run: Mute"),
     (ENDS, 1, "code of your own, or of a package, called sys.exit(None); leave that away.")],
)  # fmt: skip
def test_what_a_class_of_ones_own_raises_is_no_defect_of_the_library(own, capsys, lines, code, said):
    own.write_text(FILE + lines)
    assert main(["diagram", "--model", f"{own}:odd", "alpha=0.1:0.2:2"]) == code
    assert capsys.readouterr().err == f"error: {said.format(file=own)}\n"


def test_what_a_file_names_is_text_and_runs_nothing(tmp_path, own):
    """Without consent the file is not looked at; what needs it says what to add."""
    marker = tmp_path / "ran"
    own.write_text(f"open({str(marker)!r}, 'w').close()\n{FILE}")
    config = {"study": "diagram", "map": f"{own}:logistic", "vary": {"r": "2.8:3.8:5"}, "parameters": {"shift": 0.5}}
    found = checked(config)
    assert found["map"] == f"{own}:logistic" and found["parameters"] == {"shift": 0.5}
    assert command_of(found) == f"grazing diagram r=2.8:3.8:5 --map {own}:logistic shift=0.5"
    for run in (plan_of, result_of):
        with pytest.raises(NotNamed, match=f"name it in this call: --map {own}:logistic; in Python code='trust'"):
            run(config)
    with pytest.raises(NotNamed, match="--model"):
        plan_of({"study": "diagram", "model": f"{own}:ball", "vary": {"c": "0:0.2:3"}})
    with pytest.raises(InputError, match=r"parameters.shift = 'x' is not a real number"):
        checked({**config, "parameters": {"shift": "x"}})
    with pytest.raises(InputError, match=r"code = 'yes'; allowed are None, which runs none, and 'trust'"):
        checked(config, code="yes")
    assert not marker.exists()
    plan_of(config, code="trust")
    assert marker.exists()


def test_only_what_a_call_names_can_be_executed(own):
    """No decoder makes a Named, copies of one stay one, and any other text is refused before the file is looked at."""
    with pytest.raises(NotNamed):
        own_object("no such file.py:P")
    text = Named(f"{own}:logistic")
    for copied in (copy.deepcopy(text), pickle.loads(pickle.dumps(text)), located(text, "/")):
        assert isinstance(copied, Named) and own_object(copied).name == own_object(text).name
    for decoded in (json.loads(json.dumps(text)), tomllib.loads(f"a = {json.dumps(text)}")["a"], str(text), text[:]):
        assert not isinstance(decoded, Named)
    # the recipe of a plan is text again as soon as it has been written
    plan = plan_of({"study": "diagram", "map": text, "vary": {"r": "3:4:3"}})
    assert isinstance(plan.recipe["map"], Named)
    with pytest.raises(NotNamed):
        plan_of(json.loads(json.dumps(plan.recipe)))


def test_what_lies_compiled_beside_a_file_is_not_run(tmp_path):
    """Python takes __pycache__ for the file itself, if time and size fit: who reads the file reads something else."""
    import importlib.util
    import py_compile
    import shutil

    text = "import grazing as gz\nP = gz.gap_map(0.5, 0.1, {})\n"
    file, evil = tmp_path / "mine.py", tmp_path / "evil.py"
    file.write_text(text.format("0.2"))
    evil.write_text(text.format("0.7"))
    os.utime(evil, ns=(file.stat().st_atime_ns, file.stat().st_mtime_ns))
    compiled = importlib.util.cache_from_source(str(file))
    (tmp_path / "__pycache__").mkdir()
    shutil.move(py_compile.compile(str(evil), str(tmp_path / "evil.pyc")), compiled)
    assert own_object(Named(f"{file}:P")).params["l"] == 0.2


def test_two_edits_with_one_time_are_two_files(tmp_path):
    """As of a copy that keeps its time, or within one tick of the disk."""
    file = tmp_path / "mine.py"
    for value in (0.5, 0.7):
        file.write_text(f"import grazing as gz\nG = gz.gap_map(lam={value}, mu=0.1, l=0.2)\n")
        os.utime(file, ns=(10**18, 10**18))
        assert own_object(Named(f"{file}:G")).params["lam"] == value


def test_a_file_without_end_is_no_program(tmp_path):
    """It was read into memory."""
    file = tmp_path / "mine.py"
    with file.open("wb") as opened:
        opened.truncate(2**24 + 1)  # nothing but a hole
    with pytest.raises(InputError, match=r"mine\.py is larger than 16777216 bytes"):
        own_object(Named(f"{file}:P"))
