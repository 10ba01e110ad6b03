"""The public list: every name exists, is documented, and is known to type checkers; other programs rely on it."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import grazing as gz

# Names in the design that other programs call; they are added to, never removed.
RELIED_ON = """
Forcing Map Oscillator active cite discontinuity_map gap_map impact_map load normal_form one_impact_orbits
orbit_diagram pinball plot reset stroboscopic_map testing theory trajectory windows zdm
""".split()


@pytest.mark.parametrize("name", gz.__all__)
def test_every_public_name_exists_and_is_documented(name):
    value = getattr(gz, name)
    if name != "__version__":
        assert inspect.getdoc(value), f"{name} has no docstring"
    assert name in dir(gz)


def test_names_that_other_programs_rely_on():
    assert set(RELIED_ON) <= set(gz.__all__)


def test_type_checkers_see_the_same_list():
    tree = ast.parse(Path(gz.__file__).read_text())
    checked = (node for node in tree.body if isinstance(node, ast.If))
    block = next(node for node in checked if ast.unparse(node.test) == "TYPE_CHECKING")
    seen = {alias.asname for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert seen | {"__version__"} == set(gz.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'grazing' has no attribute 'nothing'"):
        gz.nothing  # noqa: B018


@pytest.mark.parametrize("use", ["", "dir(grazing); grazing.__version__; grazing.Outcome"])
def test_importing_is_light(use):
    heavy = "{'numba', 'numpy', 'scipy', 'xarray', 'matplotlib', 'flint'}"
    source = str(Path(gz.__file__).parents[1])
    program = (
        f"import sys; sys.path.insert(0, {source!r}); import grazing; {use}\nprint(sorted({heavy} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-I", "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_outcomes_are_described():
    assert gz.describe(0) == "ok"
    for flag in gz.Outcome:
        if flag:
            assert gz.describe(flag).startswith(f"{flag.name}: ")
    assert gz.describe(gz.Outcome.graze | gz.Outcome.stuck).count(": ") >= 2
    assert gz.describe([1, 4, 0]) == gz.describe(5)
    for wrong in ("ok", 1.5, -1, 4096):
        with pytest.raises(gz.InputError, match="outcome is"):
            gz.describe(wrong)


def test_a_ball_that_is_pressed_on_for_ever_is_promised_no_release():
    pressed = gz.Oscillator(alpha=1, k=4, forcing=gz.Forcing(omega=1.9, offset=-2, cos=(1,)), reset=gz.newton(r=0))
    outcome = gz.trajectory(pressed, (0.5, 0.5), until=20.0).attrs["grazing_outcome"]
    assert outcome == gz.Outcome.stuck
    assert "for a while or for ever" in gz.describe(outcome)
    assert "if the forcing ever releases it" in gz.describe(outcome)


@pytest.mark.parametrize(
    "use", [gz.stroboscopic_map, gz.impact_map, gz.discontinuity_map, gz.zdm, gz.testing.check_model]
)
def test_what_needs_a_model_says_so(use):
    with pytest.raises(gz.InputError, match=r"model is <Map gap map.*give an oscillator, such as gz.pinball"):
        use(gz.gap_map(0.5, 0.1, 0.2))


def test_more_of_what_needs_a_model_or_a_map():
    with pytest.raises(gz.InputError, match="model is 'd'; give an oscillator"):
        gz.normal_form("d", gz.pinball())
    with pytest.raises(gz.InputError, match=r"model is .*; give an oscillator"):
        gz.trajectory(gz.gap_map(0.5, 0.1, 0.2), (0.1, 0.0))
    with pytest.raises(gz.InputError, match=r"P is <Oscillator.*give a map"):
        gz.testing.check_map(gz.pinball())


def test_the_page_of_a_map_shows_five_arguments_first_and_keeps_the_rest_as_advanced():
    first, rest = gz.Map.__doc__.split("Other Parameters")
    advanced = rest.partition("    Raises")[0]
    names = list(inspect.signature(gz.Map).parameters)
    assert [name for name in names if f"    {name} : " in first] == [*names[:5], "pieces", "border"]
    assert [name for name in names if f"    {name} : " in advanced] == [*names[5:7], *names[9:]]
    page = (Path(__file__).parents[1] / "docs" / "api.md").read_text()
    page = page.partition("\n### Map\n")[2].partition("**Raises**")[0]
    assert page.index("- `letters`") < page.index("**Advanced**") < page.index("- `prepare`")


def test_every_type_of_a_window_is_documented():
    from grazing.orbits.special import SPECIAL

    said = inspect.getdoc(gz.bifurcation_diagram).replace("\n", " ")
    assert all(f" {kind} " in said for kind in SPECIAL) and "*end*" in said


def test_the_notice_about_compiling_comes_once(capsys):
    from grazing.kernel.cache import say_once

    say_once("compiling something that only this test compiles")
    say_once("compiling something that only this test compiles")
    assert capsys.readouterr().err == "grazing: compiling something that only this test compiles\n"
