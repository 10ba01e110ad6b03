"""The largest deflection of a rig against its steady response at many frequencies; the warning of a gap beyond it."""

import warnings

import numpy as np
import pytest

import grazing as gz
from grazing.config import checked
from grazing.oscillator.deflection import largest_deflection
from grazing.oscillator.si import si_numbers

RIG = {"m": 0.8, "c": 2.4, "k": 3200.0}
LAW = gz.newton(0.7)


def numbers(**more):
    given = dict.fromkeys(("force", "base", "load", "acceleration"), 0.0)
    given |= {"gap": 0.0, "side": "above", "moves": "both", "frequency": 14.0, "omega": None, **RIG}
    return si_numbers(**given | more)


@pytest.mark.parametrize("c", [0.5, 2.4, 60.0, 300.0])
@pytest.mark.parametrize(
    "drive", [{"force": 2.5}, {"base": 3e-4}, {"base": 3e-4, "moves": "spring"}, {"base": 3e-4, "moves": "stop"}]
)
def test_it_is_the_largest_steady_response_at_any_frequency(c, drive):
    found = numbers(c=c, **drive)
    W = np.geomspace(1e-4, 1e4, 400001) * np.sqrt(RIG["k"] / RIG["m"])
    forces = [(found.cos[0], found.sin[0])] if found.base is None else found.base.forces(found.alpha, found.k**2, W)
    response = np.hypot(*forces[0]) / np.hypot(found.k**2 - W * W, found.alpha * W)
    assert 0.85 * response.max() <= largest_deflection(found) <= 1.001 * response.max()


def test_constant_forces_and_harmonics_add_up():
    assert largest_deflection(numbers(load=-16.0)) == pytest.approx(16.0 / 3200.0, rel=1e-12)
    one, both = (largest_deflection(numbers(force=force)) for force in (2.5, (2.5, 2.5)))
    assert both == pytest.approx(2.0 * one, rel=1e-12)
    assert largest_deflection(numbers(c=0.0, force=1.0)) == np.inf  # at resonance it grows for ever
    assert largest_deflection(numbers(k=0.0, force=1.0)) == np.inf


def test_metres_where_millimetres_were_meant_are_warned_of_once():
    with pytest.warns(
        UserWarning, match=r"the gap is 1\.25 m and the largest deflection .* 0\.0165 m: from rest"
    ) as told:
        rig = gz.Oscillator.from_si(**RIG, force=2.5, gap=1.25, frequency=14, reset=LAW)
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gz.Oscillator.from_si(**RIG, force=2.5, gap=1.25, frequency=14, reset=LAW)  # said already
        rig.replace(r=0.5)
        gz.Oscillator.from_si(**RIG, force=2.5, gap=0.16, frequency=14, reset=LAW)  # 9.7 times as far
        gz.Oscillator.from_si(**RIG, gap=1.0, frequency=14, reset=LAW)  # nothing moves it
        gz.Oscillator.from_si(m=1.0, c=0.0, k=1.0, gap=1e9, force=1.0, frequency=14, reset=LAW)


def table(vary, **si):
    rig = {"m": 0.8, "c": 2.4, "force": 2.5, **({} if "k" in vary else {"k": 3200.0}), **si}
    return {"study": "diagram", "si": rig, "parameters": {"r": 0.7}, "vary": vary}


def test_files_and_the_shell_warn_of_the_least_gap():
    with pytest.warns(UserWarning, match=r"the gap is 0\.55 m"):
        checked(table({"gap": "3:0.55:30"}, frequency=14.0))
    with pytest.warns(UserWarning, match=r"the gap is 1\.35 m"):
        checked(table({"frequency": "12:17:5"}, gap=1.35))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checked(table({"gap": "0.5 mm:3:30"}, frequency=14.0))
        checked(table({"gap": [0.7, 0.1]}, frequency=14.0))
        checked(table({"k": "3000:3200:3"}, gap=1.45, frequency=14.0))  # what holds it varies


def test_stops_on_either_side_are_warned_of_if_neither_is_reached():
    def between(low, high):
        return gz.Oscillator.from_si(**RIG, force=2.5, frequency=14, walls=(gz.wall(low, LAW), gz.wall(high, LAW)))

    with pytest.warns(UserWarning, match=r"the gap is 0\.61 m"):
        between(-0.8, 0.61)
    si = {"m": 0.8, "c": 2.4, "k": 3200.0, "force": 2.5, "frequency": 14.0}
    config = {"study": "diagram", "walls": {"A": "newton", "B": "newton"}, "si": si, "vary": {"r": "0.5:0.7:3"}}
    with pytest.warns(UserWarning, match=r"the gap is 0\.62 m"):
        checked(config | {"parameters": {"A.gap": 0.62, "B.gap": 0.7}})
    with pytest.warns(UserWarning, match=r"the gap is 0\.64 m"):
        checked(config | {"parameters": {"A.gap": 0.7, "r": 0.5}, "vary": {"B.gap": "0.64:0.9:3"}})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        between(-0.8, 0.01)  # one of them is
        between(-0.8, -0.1)  # the spring presses the mass onto the upper one
        checked(config | {"parameters": {"A.gap": 0.62, "B.gap": "0.6 mm"}})
    for odd in ("abc", None, {"a": 1}, [1, "x"]):
        with pytest.raises(gz.InputError):
            checked(config | {"parameters": {"A.sigma": odd, "B.sigma": 0.6}})
