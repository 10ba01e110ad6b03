"""The starts of a reduced map are those of the flow, half a period of free flight later."""

import numpy as np
import pytest

import grazing as gz
from grazing.compare.reductions import Reductions
from grazing.studies.runs import checked_runs


def reductions(model, params, rung):
    P = gz.stroboscopic_map(model)
    return Reductions(model, checked_runs(P, params, 2, 10, 10, 0, "fast", None), rung)


@pytest.mark.parametrize("model", [gz.pinball(V=0.3, sigma=0.2, d=0.4, t0=1.0), gz.pinball(alpha=0.4, k=0.8, V=0.1)])
@pytest.mark.parametrize("rung", ["lowest", "linearised", "gap"])
def test_starts(model, rung):
    params = {"omega": [2.1, 2.3], "V": [0.1, 0.5]}
    place = reductions(model, params, rung).place(3)
    here = model.replace(omega=2.3, V=0.5)
    states = np.array([[0.3, 0.4], [0.2, -0.1]]) + np.array([[here.sigma], [0.0]])
    free = here.replace(sigma=-1e3)
    form = gz.normal_form(model.replace(V=0.5), "omega")
    half = 0.5 * here.period
    assert place.strobe == pytest.approx((form.time + half) % here.period)
    expected = []
    for state in states.T:
        flight = gz.trajectory(free, state, start=place.strobe, until=place.strobe + half, samples=2)
        expected.append([flight.u.values[-1], flight.v.values[-1]])
    found = place.start(states).T
    if rung == "lowest":
        assert found == pytest.approx(np.array(expected), abs=1e-11)
        assert place.row == pytest.approx([*here.params.values(), form.time])
    else:
        at = form.to_xy(expected) / form.scale
        assert found == pytest.approx(at[:, :1] if rung == "gap" else at, rel=1e-9, abs=1e-9)
        assert form.mu(2.3) in place.row and form.l in place.row and form.lam in place.row


def test_the_parameter_on_which_the_graze_depends_unfolds_it():
    for params in ({"d": [0.1], "r": [0.5]}, {"r": [0.5], "d": [0.1]}, {"t0": [0.3], "d": [0.1]}):
        assert reductions(gz.pinball(), params, "gap").name == "d"
    assert reductions(gz.pinball(), {"omega": [2.2], "d": [0.1]}, "gap").name == "omega"
