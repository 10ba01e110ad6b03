"""From mass, damper, spring and stop: held to an integration of the engineer's own equation, in his own coordinates."""

import pickle
from itertools import product

import numpy as np
import pint
import pytest
from scipy.integrate import solve_ivp

import grazing as gz
from grazing.outcome import InputError

#: A stop far out of reach lets the motion be the steady response of the closed form.
FREE = pytest.mark.filterwarnings("ignore:the gap is")
RIG = {"m": 0.8, "c": 2.4, "k": 3200.0, "force": 2.5, "gap": 1.2e-3, "frequency": 14.0, "reset": gz.newton(0.7)}


def by_hand(until, side="above", moves="both", base=(), force=(2.5,), load=0.0, r=0.7, **_):
    """Integrate m x'' = F + load - spring - damper, x upwards, with hits where x meets the stop: times and speeds."""
    m, c, k, gap, w = 0.8, 2.4, 3200.0, 1.2e-3, 2 * np.pi * 14.0
    sign = {"above": 1.0, "below": -1.0}[side]

    def z(t):
        return sum(a * np.cos((j + 1) * w * t) for j, a in enumerate(base))

    def dz(t):
        return sum(-a * (j + 1) * w * np.sin((j + 1) * w * t) for j, a in enumerate(base))

    foot, stop = moves in ("both", "spring"), moves in ("both", "stop")

    def flow(t, s):
        pushed = sum(a * np.cos((j + 1) * w * t) for j, a in enumerate(force)) + load
        stretched = s[0] - (z(t) if foot else 0.0), s[1] - (dz(t) if foot else 0.0)
        return [s[1], (pushed - k * stretched[0] - c * stretched[1]) / m]

    def touch(t, s):
        return gap - sign * (s[0] - (z(t) if stop else 0.0))

    touch.terminal, touch.direction = True, -1.0
    t, s = 0.0, [z(0.0) if stop else 0.0, dz(0.0) if stop else 0.0]  # at rest relative to the stop
    hits = []
    while t < until:
        leg = solve_ivp(flow, (t, until), s, events=touch, rtol=1e-11, atol=1e-14, max_step=0.002, method="DOP853")
        t, s = leg.t[-1], leg.y[:, -1].copy()
        if leg.status == 1:
            moving = dz(t) if stop else 0.0
            speed = sign * (s[1] - moving)
            hits.append((t, speed))
            s[1] = moving - sign * r * speed
    return np.array(hits)


CASES = [
    {"side": side, "moves": moves, "base": base, "force": force, "load": load}
    for side, moves, (base, force, load) in product(
        ["above", "below"],
        ["both", "spring", "stop"],
        [((1.1e-3,), (2.5,), 0.0), ((7e-4, -3e-4), (1.0, 0.5, 2.0), -0.9)],
    )
] + [{"side": side} for side in ("above", "below")]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=str)
def test_impacts_are_those_of_the_equation_in_its_own_coordinates(case):
    until = 0.8
    truth = by_hand(until, **case)
    model = gz.Oscillator.from_si(**{**RIG, **case})
    found = gz.trajectory(model, (0.0, 0.0), until=until)
    assert len(truth) >= 4
    np.testing.assert_allclose(found.impact_time.values, truth[:, 0], rtol=0, atol=2e-9)
    np.testing.assert_allclose(-found.v_minus.values, truth[:, 1], rtol=1e-6)


def test_quantities_in_any_unit_are_the_same_model():
    units = pint.UnitRegistry()
    plain = gz.Oscillator.from_si(**RIG)
    other = {
        "m": "800 g", "c": units.Quantity(2.4, "kg/s"), "k": "3.2 N/mm", "force": units.Quantity(2500.0, "mN"),
        "gap": units.Quantity(1.2, "mm"), "frequency": "840 rpm",
    }  # fmt: skip
    same = gz.Oscillator.from_si(**{**RIG, **other})
    assert list(same.params) == list(plain.params)
    np.testing.assert_allclose(list(same.params.values()), list(plain.params.values()), rtol=1e-15, atol=0)
    assert same.mass == plain.mass == 0.8
    turns = {"frequency": None, "omega": units.Quantity(14.0, "Hz")}
    assert gz.Oscillator.from_si(**{**RIG, **turns}).params == plain.params
    several = gz.Oscillator.from_si(**{**RIG, "force": units.Quantity([2500.0, 100.0], "mN")})
    assert several.forcing.cos == pytest.approx((-3.125, -0.125), rel=1e-15)


def test_the_numbers_are_those_of_the_equation_per_mass():
    model = gz.Oscillator.from_si(**RIG, load=-0.8)
    numbers = (model.alpha, model.k**2, model.sigma, *model.forcing.cos, model.forcing.offset)
    np.testing.assert_allclose(numbers, (3.0, 4000.0, -0.0012, -3.125, 1.0), rtol=1e-15)
    assert model.replace(omega=80.0).mass == 0.8
    assert model.replace(sigma="-2 mm").sigma == -0.002


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"m": -0.8}, r"m = -0\.8; allowed is m > 0"),
        ({"m": 0.0}, "allowed is m > 0"),
        ({"c": -1.0}, "allowed is c >= 0"),
        ({"k": -3200.0}, "allowed is k >= 0"),
        ({"gap": -1e-3}, "gap = -0.001 m; it is a distance, >= 0, .* give side='below'; .* gap=0"),
        ({"gap": -1e-3, "side": "below"}, "give side='above'"),
        ({"gap": "-1 mm"}, "gap = -0.001 m; it is a distance"),
        ({"gap": "1.2 kg"}, r"its units do not match: give a quantity such as '1 m'"),
        ({"k": "3 N s/m"}, r"its units do not match: give a quantity such as '1 N/m'"),
        ({"force": "2.5"}, "it has no units: give a quantity such as '1 N'"),
        ({"frequency": "14 1/s"}, "its units do not match: give a quantity such as '1 Hz'"),
        ({"frequency": None}, "neither is given; give frequency, in Hz, or omega, in rad/s"),
        ({"omega": 3.0}, "both are given"),
        ({"side": "left"}, "side = 'left'; allowed are 'above' and 'below'"),
        ({"moves": "frame"}, "moves = 'frame'; allowed are 'both', 'spring' and 'stop'"),
        ({"force": [1.0, "a"]}, "force\\[1\\] = 'a' is no quantity"),
        ({"force": None}, "force.* is not a real number"),
        ({"base": float("nan")}, "base.* is not finite"),
        ({"load": "9**9**9 N"}, "is no unit"),
        ({"gap": "1.2 mmm"}, "gap = '1.2 mmm'; 'mmm' is no unit"),
        ({"gap": np.nan}, "not finite"),
        ({"m": True}, "not a real number"),
        ({"reset": 0.7}, "reset is 0.7; give gz.newton"),
        ({"frequency": 1e-200}, "frequency = 1e-200; allowed is 1.59e-61 <= frequency"),
        ({"c": "2 dB"}, "its units do not match"),
        ({"m": 1e-320}, r"m = 9\.99989e-321 kg: damping, stiffness, .* are larger than any double; give a mass"),
        ({"base": [1e-4] * 1001}, "base and force have 1001 harmonics; allowed are at most 1000"),
    ],
)
def test_what_is_wrong_is_said(wrong, said):
    with pytest.raises(InputError, match=said):
        gz.Oscillator.from_si(**{**RIG, **wrong})


@FREE
def test_a_shaken_model_at_a_frequency_without_a_square():
    with pytest.raises(InputError, match="omega = 1e-200; allowed is 1e-60 <= omega"):
        shaken(base=3e-4).replace(omega=1e-200)


# ---- a base that keeps its amplitude over a sweep


def shaken(frequency=14.0, gap=1.0, **more):
    return gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, gap=gap, frequency=frequency, reset=gz.newton(0.7), **more)


def steady(omega, z, moves):
    """Return the amplitude of the free motion seen from the stop, from the equations of the rig in x and z."""
    m, c, k = 0.8, 2.4, 3200.0
    x = {
        "both": (k + 1j * omega * c) * z,
        "spring": (k + 1j * omega * c) * z,
        "stop": 0.0,
    }[moves] / (k - m * omega**2 + 1j * omega * c)
    return abs(x - (0.0 if moves == "spring" else z))


@FREE
@pytest.mark.parametrize("moves", ["both", "spring", "stop"])
@pytest.mark.parametrize("side", ["above", "below"])
def test_a_sweep_keeps_the_amplitude_of_a_base_as_the_closed_form_has_it(moves, side):
    P = gz.stroboscopic_map(shaken(14.0, base=3e-4, moves=moves, side=side))
    omega = 2.0 * np.pi * np.array([6.0, 9.0, 12.0])
    read = gz.response(P, "omega", omega, starts=[[0.0, 0.0]]).amplitude.sel(run="up").values
    assert read == pytest.approx([steady(w, 3e-4, moves) for w in omega], rel=1e-9)
    jerked = gz.stroboscopic_map(shaken(14.0, acceleration=2.0, moves=moves, side=side))
    read = gz.response(jerked, "omega", omega, starts=[[0.0, 0.0]]).amplitude.sel(run="up").values
    assert read == pytest.approx([steady(w, 2.0 / w**2, moves) for w in omega], rel=1e-9)


@FREE
def test_a_model_with_a_base_at_another_frequency_is_the_one_made_there():
    for more in ({"base": [3e-4, 1e-5], "moves": "stop"}, {"acceleration": 2.0, "force": 0.3, "moves": "spring"}):
        there = shaken(12.0, **more)
        assert shaken(14.0, **more).replace(omega=2.0 * np.pi * 12.0) == there
        assert pickle.loads(pickle.dumps(there)) == there and "base (moves=" in repr(there)
    model = shaken(base=3e-4)
    with pytest.raises(gz.InputError, match="cos1 is made by the moving base"):
        model.replace(cos1=1.0)
    P = gz.stroboscopic_map(model)
    with pytest.raises(gz.InputError, match="cos1 is made by the moving base"):
        gz.orbit_diagram(P, "cos1", [0.0, 1.0], starts=2)
    with pytest.raises(gz.InputError, match="windows does not know that the force of a moving base"):
        gz.windows(model, "omega", N=1)
    with pytest.raises(gz.InputError, match="sensitivity does not know"):
        gz.sensitivity(model, "sigma", N=1, span=(-1e-3, -9e-4))


@pytest.mark.parametrize("walls", [None, [gz.wall(-1e-3, gz.newton(0.7))]])
@pytest.mark.parametrize("moves", ["both", "spring", "stop"])
def test_a_base_drives_a_stiffness_as_it_drives_the_natural_frequency_of_the_same_spring(moves, walls):
    base = shaken(gap=1e-3, base=3e-4, acceleration=0.5, moves=moves).base
    stop = {"reset": gz.newton(0.7), "sigma": -1e-3} if walls is None else {"walls": walls}
    given = {"alpha": 3.0, "forcing": gz.Forcing(omega=80.0), "mass": 0.8, "base": base, **stop}
    as_k, as_stiffness = gz.Oscillator(k=64.0, **given), gz.Oscillator(stiffness=4096.0, **given)
    assert as_stiffness.forcing == as_k.forcing
    assert as_stiffness.replace(stiffness=6400.0, omega=75.0).forcing == as_k.replace(k=80.0, omega=75.0).forcing
    rows = [np.array([list(one.params.values())] * 3) for one in (as_k, as_stiffness)]
    rows[0][:, 1], rows[1][:, 1] = [50.0, 60.0, 70.0], [2500.0, 3600.0, 4900.0]
    made = [one.made_from_base(row) for one, row in zip((as_k, as_stiffness), rows, strict=True)]
    assert (np.delete(made[0], 1, axis=1) == np.delete(made[1], 1, axis=1)).all()
    with pytest.raises(gz.InputError, match="does not know that the force of a moving base"):
        as_stiffness.refuse_base("a proof", ["stiffness"])


def test_a_branch_of_a_shaken_rig_grazes_where_the_closed_form_says():
    P = gz.stroboscopic_map(shaken(9.0, gap=1.2e-3, base=3e-4))
    omega = 2.0 * np.pi * np.array([8.0, 9.5])
    found = gz.response(P, "omega", omega, starts=2)
    graze = found.special_value.values[found.special_type.values == "gr"][0]
    assert steady(graze, 3e-4, "both") == pytest.approx(1.2e-3, rel=1e-10)
    form = gz.normal_form(P.model, "omega")
    assert form.graze == pytest.approx(graze, rel=1e-12)


def test_a_result_of_a_shaken_rig_is_made_again_by_its_command():
    from grazing.config import command_of, recipe_of, result_of

    P = gz.stroboscopic_map(shaken(14.0, gap=1.2e-3, base=3e-4, force=0.1))
    found = gz.orbit_diagram(P, "omega", [80.0, 85.0, 90.0], starts=3)
    recipe = recipe_of(found.attrs, {"omega": found.omega.values})
    assert "--base moves=both,displacement=-0.0003" in command_of(recipe)
    again = result_of(recipe)
    assert (again.u.values == found.u.values).all() and again.attrs["base"] == found.attrs["base"]


def test_what_is_no_parameter_of_the_model_is_said_before_its_units():
    rig = gz.Oscillator.from_si(**RIG)  # its stop is above
    for changes, said in (
        ({"gap": "1 mm"}, "Here that is sigma = -gap"),
        ({"frequency": "16 Hz"}, "Here that is omega = 2 pi frequency, in SI units also '14 Hz'"),
        (
            {"k": "3.2 kN/m"},
            r"a quantity such as '1 rad/s'. That is the natural frequency sqrt\(k/m\), and no stiffness",
        ),
    ):
        with pytest.raises(gz.InputError, match=said):
            rig.replace(**changes)
    with pytest.raises(gz.InputError, match=r"u = -0\.002, sigma = -0\.0012; start with u >= sigma; here u is -x"):
        gz.trajectory(rig, (-0.002, 0.0))


def test_what_is_missing_of_a_stop_is_named_with_an_example():
    with pytest.raises(gz.InputError, match=r"reset is missing; give .* such as reset=gz\.newton\(r=0\.7\)"):
        gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, gap=1e-3, frequency=14)
    with pytest.raises(gz.InputError, match=r"gap is missing; give .* such as gap='1.2 mm'"):
        gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, reset=gz.newton(0.7), frequency=14)
