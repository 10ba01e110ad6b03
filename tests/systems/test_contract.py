"""The contract: what is wrong with a system is said when it is made."""

import pytest

import grazing as gz
from tests.systems.balls import bouncing, parabola, table, table_bound

PARAMS = {"g": 1.0, "A": 0.1, "omega": 1.0, "r": 0.5}


def made(**changes):
    given = {"positions": ("x",), "velocities": ("v",), "params": PARAMS, "flight": parabola,
             "surfaces": [gz.Surface("B", table, table_bound)], "box": ((0.2, 0.4), (-0.5, 0.5))}  # fmt: skip
    return gz.System(**given | changes)


@pytest.mark.parametrize(
    ("changes", "error", "said"),
    [
        ({"velocities": ("v", "w")}, gz.InputError, "there are 1 positions .* and 2 velocities"),
        ({"velocities": ("x",)}, gz.InputError, "x is the name of two coordinates or parameters"),
        ({"positions": ("A",)}, gz.InputError, "A is the name of two"),
        ({"positions": ("phase",)}, gz.InputError, "phase cannot be the name"),
        ({"params": {**PARAMS, "t": 1.0}}, gz.InputError, "t cannot be the name"),
        ({"params": {"g": 1.0, "A": 0.1, "omega": 1.0}}, gz.InputError, "no parameter 'B.r' or 'r' for Newton's"),
        ({"surfaces": []}, gz.InputError, "give a list of gz.Surface"),
        ({"surfaces": [gz.Surface("B", table, table_bound)] * 2}, gz.InputError, "two surfaces are called B"),
        ({"flight": 3}, gz.InputError, r"give a function flight\(t, t0, state, p\)"),
        ({"box": ((0.2, 0.4),)}, gz.InputError, "box has 1 intervals for 2 coordinates"),
        ({"period": -1.0}, gz.InputError, "allowed is period > 0"),
        ({"period": lambda p: p.nothing}, gz.UserCodeError, "the period of system raised AttributeError"),
        ({"flight": lambda t, t0, state, p: state[0]}, gz.UserCodeError, "the flight returned .*must return a state"),
        ({"flight": lambda t, t0, state, p: 1 / 0}, gz.UserCodeError, "the flight raised ZeroDivisionError.*in line"),
        ({"surfaces": gz.Surface("B", lambda t, state, p: 1.0, table_bound)}, gz.UserCodeError, r"return \(h, dh\)"),
        ({"surfaces": gz.Surface("B", table, lambda t, w, state, p: -1.0)}, gz.UserCodeError, "allowed is M >= 0"),
        (
            {"surfaces": gz.Surface("B", table, table_bound, lambda t, state, p: (0.0, float("nan")))},
            gz.UserCodeError,
            "the law of surface B returned",
        ),
    ],
)
def test_what_does_not_fit_is_refused(changes, error, said):
    with pytest.raises(error, match=said):
        made(**changes)


@pytest.mark.parametrize("name", [None, "", "C", "S", "a", "AB", 3])
def test_a_surface_needs_a_letter_for_a_name(name):
    with pytest.raises(gz.InputError, match=r"name of a surface is .*one capital letter other than C and S"):
        gz.Surface(name, table, table_bound)


def test_a_surface_needs_functions():
    with pytest.raises(gz.InputError, match=r"gap of surface A is None; give a function gap\(t, state, p\)"):
        gz.Surface("A", None, table_bound)


def test_parameters_are_replaced_by_name():
    assert bouncing().replace(r=0.25).params["r"] == 0.25
    with pytest.raises(gz.InputError, match="unknown parameter 'q' of system"):
        bouncing().replace(q=1.0)


def test_without_a_period_there_is_no_stroboscopic_map():
    with pytest.raises(gz.InputError, match="system has no period"):
        gz.stroboscopic_map(made())
