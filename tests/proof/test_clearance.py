import pytest
from flint import arb, ctx

import grazing as gz
from grazing.oscillator.sure import Undecided
from grazing.proof.clearance import Through, clear
from grazing.proof.flow import Flow

# With alpha = k = 0 and a constant force F the ball flies on parabolas: y = w s + F s^2/2.


@pytest.fixture(autouse=True)
def precision():
    with ctx.workprec(256):
        yield


def falling(force=-2.0):
    return Flow(
        gz.Oscillator(alpha=0, k=0, forcing=gz.Forcing(omega=1.0, offset=force, cos=(0.0,)), reset=gz.newton(1))
    )


def test_a_parabola_is_clear_and_its_bounds_hold():
    flow, zero = falling(), arb(0)
    found = clear(flow, flow.start(zero, zero, arb(1.5)), zero, arb(1.5))
    a, b = float(found.start), float(found.end)
    assert 0 < a < 0.75 < b < 1.5
    assert 0 < found.up <= 1.5 - 2 * a
    assert 0 < found.down <= 2 * b - 1.5
    assert 0 < found.floor <= min(1.5 * s - s * s for s in (a, b))


@pytest.mark.parametrize("w", [1e-3, 1e-9, 1e-30])
def test_a_tiny_hop_is_clear_too(w):
    flow, zero = falling(), arb(0)
    found = clear(flow, flow.start(zero, zero, arb(w)), zero, arb(w))
    assert 0 < found.floor <= w * w / 4


def test_a_ball_of_flights_is_clear():
    flow, zero = falling(), arb(0)
    w = arb(1.5, 1e-9)
    found = clear(flow, flow.start(zero, zero, w), zero, w)
    assert found.end > 1.4 * found.start


def steady(d):
    """The steady response of the standard model from t = 0: it grazes at d = 0.130961869349..."""
    flow = Flow(gz.pinball(d=d))
    E = flow.transition(flow.T)
    end = flow.read(flow.fly(flow.start(arb(0), arb(0), arb(0)), arb(0), flow.T))
    det = (1 - E[0]) * (1 - E[3]) - E[1] * E[2]
    y, v = ((1 - E[3]) * end.y + E[1] * end.v) / det, (E[2] * end.y + (1 - E[0]) * end.v) / det
    return flow, flow.start(arb(0), y, v)


def test_heights_are_told_from_depths_down_to_the_precision():
    graze = gz.normal_form(gz.pinball(), "d").graze
    for above in (1e-3, 1e-9, 1e-15):
        flow, z = steady(graze + above)
        assert 0 < clear(flow, z, arb(0), flow.T, leaves=False, meets=False).floor < 1.1 * above
        flow, z = steady(graze - above)
        with pytest.raises(Through) as found:
            clear(flow, z, arb(0), flow.T, leaves=False, meets=False)
        assert -1.1 * above < found.value.height < 0


def test_one_dip_may_be_left_open():
    graze = gz.normal_form(gz.pinball(), "d").graze
    flow, z = steady(graze)
    found = clear(flow, z, arb(0), flow.T, leaves=False, meets=False, touch=True)
    assert found.dip is not None and found.bend > 0
    low, high = found.dip
    lowest = min((float(flow.read(flow.fly(z, arb(0), arb(s * 1e-3)))[0]), s * 1e-3) for s in range(1, 2850))[1]
    assert low < lowest < high
    assert found.floor > 0


def test_a_ball_that_leaves_at_rest_is_lifted_by_the_force_or_not_at_all():
    flow = Flow(gz.Oscillator(alpha=0, k=0, forcing=gz.Forcing(omega=1.0), reset=gz.newton(0)))  # y'' = cos t
    zero = arb(0)
    start, L = arb(-1), arb(0.5)  # only the departure is looked at: the flight does not come back
    with pytest.raises(Undecided):
        clear(flow, flow.start(start, zero, zero), start, L)
    with pytest.raises((Undecided, Through)):
        clear(flow, flow.start(arb(2), zero, zero), arb(2), arb(1.0))
