"""Maps and models from a user's own file."""

import pytest

from grazing import InputError, UserCodeError
from grazing.config import checked, command_of, load_config, plan_of, result_of

FILE = """
import grazing as gz

def step(state, p):
    (x,) = state
    return (p.r * x * (1.0 - x),)

logistic = gz.Map(step, params={"r": 3.2, "shift": 0.0}, coordinates=("x",), box=((0.1, 0.9),))

def soft(v, p):
    return -p.r * v / (1.0 - p.c * v)

ball = gz.Oscillator(alpha=0.1, k=1, forcing=gz.Forcing(omega=2.8), sigma=-0.1, reset=gz.reset(soft, r=0.8, c=0.1))
number = 3
"""


@pytest.fixture
def own(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(FILE)
    return file


def test_a_map_of_ones_own_has_its_own_parameters_and_ranges(own):
    config = {"study": "diagram", "map": f"{own}:logistic", "vary": {"r": "2.8:3.8:5"}, "settings": {"starts": 3}}
    found = checked(config)
    assert found["parameters"] == {"shift": 0.0}
    result = result_of(config)
    assert result.sizes["r"] == 5
    assert result.period.values[0].tolist() == [1, 1, 1]
    with pytest.raises(InputError, match=r"parameters.alpha: unknown parameter; allowed are r, shift"):
        checked({**config, "parameters": {"alpha": 1.0}})
    with pytest.raises(InputError, match=r"parameters.shift = 'x' is not a real number"):
        checked({**config, "parameters": {"shift": "x"}})


def test_a_model_of_ones_own(own):
    config = {"study": "diagram", "model": f"{own}:ball", "vary": {"c": "0:0.2:3"}, "parameters": {"r": 0.7}}
    assert plan_of(config).P.params["r"] == 0.7
    with pytest.raises(InputError, match="law: the model brings its own reset law"):
        checked({**config, "law": "newton"})
    with pytest.raises(InputError, match=r"vary.r = 1.5; allowed is 0 <= r <= 1"):
        checked({**config, "vary": {"r": "0:1.5:3"}})


def test_an_oscillator_in_the_place_of_a_map_is_its_stroboscopic_map(own):
    found = checked({"study": "diagram", "map": f"{own}:ball", "vary": {"c": "0:0.2:3"}})
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
        ("number", "number in .* is a int; allowed are a gz.Map and a gz.Oscillator"),
    ],
)
def test_what_is_not_there_is_said(own, name, said):
    with pytest.raises(InputError, match=said):
        checked({"study": "diagram", "map": f"{own}:{name}", "vary": {"r": "3:4:5"}})


def test_a_map_is_no_model_and_a_gap_has_none(own):
    with pytest.raises(InputError, match=r"is a gz.Map; give it as the map"):
        checked({"study": "diagram", "model": f"{own}:logistic", "vary": {"d": "0:1:2"}})
    gap = {"study": "diagram", "map": "gap", "parameters": {"lam": 0.5, "l": 0.1}, "vary": {"mu": "0:1:2"}}
    with pytest.raises(InputError, match="model: the map gap is not made of an oscillator"):
        checked({**gap, "model": f"{own}:ball"})
    with pytest.raises(InputError, match="both name an oscillator"):
        checked({"study": "diagram", "map": f"{own}:ball", "model": f"{own}:ball", "vary": {"d": "0:1:2"}})


def test_a_file_that_fails_is_named(tmp_path):
    (tmp_path / "bad.py").write_text("1/0\n")
    with pytest.raises(InputError, match=r"bad.py cannot be run: ZeroDivisionError"):
        checked({"study": "diagram", "map": f"{tmp_path}/bad.py:P", "vary": {"d": "0:1:2"}})
    from grazing.config.own import own_object

    with pytest.raises(UserCodeError):
        own_object(f"{tmp_path}/bad.py:P")
