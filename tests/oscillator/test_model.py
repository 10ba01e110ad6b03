"""The model: flat parameters, replace, and the words of its errors."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.oscillator.parameters import describe_parameter
from tests.models import MODELS, THREE_HARMONICS


def test_params_are_flat_and_in_a_fixed_order():
    assert list(gz.pinball().params) == ["alpha", "k", "omega", "t0", "d", "cos1", "sin1", "sigma", "r", "V"]
    three = THREE_HARMONICS
    assert list(three.params) == [
        "alpha",
        "k",
        "omega",
        "t0",
        "offset",
        *(f"{f}{j}" for j in (1, 2, 3) for f in ("cos", "sin")),
        "sigma",
        "r",
    ]


@pytest.mark.parametrize("name", MODELS)
def test_replace_changes_one_parameter_only(name):
    m = MODELS[name]
    for parameter in m.params:
        changed = m.replace(**{parameter: 0.25})
        assert changed.params == {**m.params, parameter: 0.25}
        assert type(changed) is type(m)
    assert m.replace().params == m.params


def test_pinball_is_an_oscillator():
    m = gz.pinball(alpha=1.0, k=2.0, omega=3.0, t0=0.1, d=0.2, r=0.5, V=0.3, sigma=-0.4)
    same = gz.Oscillator(
        alpha=1.0, k=2.0, forcing=gz.Forcing(omega=3.0, t0=0.1, offset=0.2), sigma=-0.4, reset=gz.active(r=0.5, V=0.3)
    )
    start = (0.1, 0.2)
    assert np.array_equal(gz.stroboscopic_map(m).iterate(start, 9), gz.stroboscopic_map(same).iterate(start, 9))
    assert m.period == same.period == 2.0 * math.pi / 3.0


def test_forcing_fills_up_the_shorter_list():
    f = gz.Forcing(omega=1.0, cos=(), sin=(0.0, 2.0))
    assert (f.cos, f.sin) == ((0.0, 0.0), (0.0, 2.0))
    assert gz.Forcing(omega=1.0, cos=(), sin=()).cos == (0.0,)
    assert gz.Forcing(omega=1.0).cos == gz.Forcing(omega=1.0, sin=()).cos == (1.0,)
    assert gz.Forcing(omega=1.0, sin=np.array([2.0])).cos == (0.0,)  # nothing is forced that was not named
    assert gz.Forcing(omega=1.0, cos=np.array([1.0, 2.0])).cos == (1.0, 2.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: gz.pinball(k=-1.0),
            r"k = -1; allowed is k >= 0, finite \(natural frequency; the stiffness is k\^2\)",
        ),
        (lambda: gz.pinball(k=math.inf), r"k = inf is not finite"),
        (
            lambda: gz.pinball(omega=0.0),
            r"omega = 0; allowed is omega > 0, finite \(frequency of the forcing\)",
        ),
        (
            lambda: gz.pinball(omega=1e-163),
            r"omega = 1e-163; allowed is 1e-60 <= omega <= 1e\+60: beyond, numbers overflow",
        ),
        (lambda: gz.Forcing(omega=2.2, cos=(1.0, -1e160)), r"cos2 = -1e\+160; allowed is \|cos2\| <= 2.27273e\+149"),
        (lambda: gz.pinball(alpha=1e160), r"alpha = 1e\+160; allowed is alpha <= 1e\+60"),
        (lambda: gz.Forcing(omega=2.2, cos=(1e-170,)), r"the force is at most 1e-170; allowed are 0 and amplitudes of"),
        (lambda: gz.pinball(d=math.nan), r"d = nan is not finite"),
        (lambda: gz.pinball(V=-0.4), r"V = -0.4; allowed is V >= 0"),
        (lambda: gz.pinball(t0=None), r"t0 = None is not a real number"),
        (
            lambda: gz.pinball().replace(D=0.1),
            r"unknown parameter 'D' of the model.* Allowed are: alpha, k, omega, t0, d, cos1",
        ),
        (lambda: gz.pinball().replace(omga=0.1), r"unknown parameter 'omga' of the model. Did you mean 'omega'\?"),
        (lambda: gz.pinball().replace(r=2.0), r"r = 2; allowed is 0 <= r <= 1"),
        (
            lambda: gz.Forcing(omega=1.0, cos=1.0),
            r"cos = 1.0; give one amplitude per harmonic, such as cos=\(1.0, 0.5\)",
        ),
        (lambda: gz.Forcing(omega=1.0, sin=(0.0, math.nan)), r"sin2 = nan is not finite"),
        (lambda: gz.Oscillator(1.0, 1.0, 2.2, gz.newton(0.5)), r"forcing is 2.2; give a gz.Forcing"),
        (lambda: gz.Oscillator(1.0, 1.0, gz.Forcing(omega=1.0), 0.8), r"reset is 0.8; give gz.newton\(r\)"),
    ],
)
def test_bad_input_is_answered_in_words(make, words):
    with pytest.raises(gz.InputError, match=words):
        make()


def test_every_parameter_is_described_once():
    for m in MODELS.values():
        for name in m.params:
            known = describe_parameter(name)
            assert known.name == name
            assert known.meaning
            assert known.symbol
    assert describe_parameter("cos2").symbol == "c_{2}"


def test_models_are_frozen_and_short_to_print():
    m = gz.pinball()
    with pytest.raises(AttributeError):
        m.alpha = 2.0
    assert len(repr(m)) < 120
