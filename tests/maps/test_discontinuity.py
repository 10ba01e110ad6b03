"""The zero-time discontinuity map: the paper's Figure 2.2, the four points, and the measured orders of error."""

from dataclasses import replace

import numpy as np
import pytest

import grazing as gz
from tests.models import MODELS

FIGURE_2_2 = gz.pinball(alpha=3, k=1, omega=2.1, t0=2.2, r=0.8, d=0.11, V=0.2)


def jump(P, low, high, v):
    """Where the number of impacts changes, to the last bit."""
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return high
        if P((middle, v))[1] == P((low, v))[1]:
            low = middle
        else:
            high = middle


def test_the_two_jumps_of_figure_2_2():
    assert jump(gz.stroboscopic_map(FIGURE_2_2), 0.01, 0.06, -0.23) == pytest.approx(0.0383355822, abs=5e-11)
    assert jump(gz.discontinuity_map(FIGURE_2_2), 0.01, 0.06, -0.23) == pytest.approx(0.0395865740, abs=5e-11)


def test_beyond_the_later_jump_the_maps_agree_exactly():
    P, Z = gz.stroboscopic_map(FIGURE_2_2), gz.discontinuity_map(FIGURE_2_2)
    for u in (0.0396, 0.045, 0.06):
        assert Z((u, -0.23))[0] == pytest.approx(P((u, -0.23))[0], abs=4e-16)
    between = 0.039  # one of them has an impact: they differ by the whole jump
    assert np.abs(Z((between, -0.23))[0] - P((between, -0.23))[0]).max() > 0.02


def test_four_points_close_the_loop():
    four = gz.zdm_points(FIGURE_2_2, (0.03, -0.23))
    (U0, V0), (U1, V1), (U2, V2), (U3, V3) = four.points
    A, delta = four.acceleration, four.delta
    assert U0 + V0 * delta + 0.5 * A * delta**2 == pytest.approx(U1, abs=1e-16)
    assert V0 + A * delta == pytest.approx(V1, abs=1e-16)
    assert (U1, U2, V2) == (0.0, 0.0, pytest.approx(-0.8 * V1 + 0.2))
    assert U2 - delta * V2 + 0.5 * A * delta**2 == pytest.approx(U3, abs=1e-16)
    assert V2 - delta * A == pytest.approx(V3, abs=1e-16)
    assert four.x == pytest.approx(V0**2 - 2.0 * A * U0)
    assert gz.zdm(FIGURE_2_2)((0.03, -0.23))[0] == pytest.approx([U3, V3], abs=1e-16)
    lowest = gz.zdm(FIGURE_2_2, order="lowest")((0.03, -0.23))[0]
    assert lowest == pytest.approx([U0, V0 + 0.2 + 1.8 * np.sqrt(four.x)], abs=1e-16)


def test_printed_form_of_u3_is_not_the_expansion_of_2_2():
    """(2.2) expands to U0 - delta (V + (1+r) sqrt(x)); the paper prints U0 + delta ((1+r) V0 + V)."""
    four = gz.zdm_points(FIGURE_2_2, (0.03, -0.23))
    (U0, V0), (U3, _) = four.points[0], four.points[3]
    assert U3 == pytest.approx(U0 - four.delta * (0.2 + 1.8 * np.sqrt(four.x)), abs=1e-16)
    assert abs(U3 - (U0 + four.delta * (1.8 * V0 + 0.2))) > 1e-3


def measured_order(m, order):
    """Regress the error of the local map against the size of the impact's approach, for (u, v) each."""
    P, Z = gz.stroboscopic_map(m), gz.discontinuity_map(m, order=order)
    sizes, errors = np.logspace(-1.5, -4, 9), []
    force = Z.params[m.offset_name] + sum(c for n, c in m.params.items() if n.startswith("cos"))
    for e in sizes:
        v = -e
        u = m.sigma + 0.3 * v * v / (2.0 * force)  # x > 0: an impact within a time of order e
        assert P((u, v))[1] == Z((u, v))[1] == 1
        errors.append(np.abs(P((u, v))[0] - Z((u, v))[0]))
    return [float(np.polyfit(np.log(sizes), np.log(column), 1)[0]) for column in np.array(errors).T]


LOCAL = {"d": 1.5, "omega": 1.0, "k": 1.2}  # one impact a period, F > 0 at the section


@pytest.mark.parametrize(("alpha", "r"), [(3.0, 0.8), (1.0, 0.5)])
@pytest.mark.parametrize(
    ("V", "order", "expected"),
    [
        (0.3, "lowest", 1.0),
        (0.3, "full", 1.0),
        (0.3, "corrected", 2.0),
        (0.0, "lowest", 2.0),
        (0.0, "full", 2.0),
        (0.0, "corrected", 2.0),
    ],
)
def test_measured_order_of_error(alpha, r, V, order, expected):
    m = gz.pinball(alpha=alpha, r=r, V=V, **LOCAL)
    for slope in measured_order(m, order):
        assert slope == pytest.approx(expected, abs=0.15)


def test_without_damping_the_full_form_gains_orders():
    """The first-order error of the full form is the jump -alpha (v+ - v-) of the acceleration: alpha = 0 removes it."""
    m = gz.pinball(alpha=0.0, r=0.8, V=0.3, omega=1.0, k=0.1, d=4.0)
    assert min(measured_order(m, "full")) > 1.8
    assert max(measured_order(m, "lowest")) < 1.2


@pytest.mark.parametrize("order", ["lowest", "full", "corrected"])
def test_images_below_the_wall_have_a_time_to_the_wall_in_the_past(order):
    Z = gz.discontinuity_map(gz.pinball(), order=order)
    state = np.array([-0.01, -0.2])
    assert Z.jacobian(state) == pytest.approx(replace(Z, tangent=None).jacobian(state), abs=1e-7)


def test_acceleration_may_vanish_or_be_negative():
    for d in (-1.0, -1.5):  # F(0) = 0 and F(0) < 0
        m = gz.pinball(d=d, alpha=1e-9, k=1e-9)
        four = gz.zdm_points(m, (0.01, -0.2))
        assert 0.01 - 0.2 * four.delta + 0.5 * four.acceleration * four.delta**2 == pytest.approx(0.0, abs=1e-16)
        assert four.delta > 0.0


@pytest.mark.parametrize("order", ["lowest", "full", "corrected"])
@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e3, 7.0, 3.0])
def test_the_steady_response_hits_where_it_goes_through_the_wall(unit, order):
    """At the phase of its lowest point v is 0, and rounding, which is another one in each unit, gives it a sign."""
    alpha, k, omega = 2.653650659113442, 1.1198641866969627, 2.260355380520523
    size, lag = 1.0 / np.hypot(k**2 - omega**2, alpha * omega), np.arctan2(alpha * omega, k**2 - omega**2)
    for depth in (1e-6, 0.005, 0.05):
        forcing = gz.Forcing(omega=omega, offset=(1.0 - depth) * size * k**2 * unit, cos=(unit,))
        m = gz.Oscillator(alpha=alpha, k=k, forcing=forcing, reset=gz.active(r=0.52, V=0.1 * unit))
        Z = gz.discontinuity_map(m, order, phase=(np.pi + lag) / omega)
        for v in (0.0, 1e-17 * unit, -1e-17 * unit):
            assert Z((-depth * size * unit, v))[1] == 1
        assert Z((-depth * size * unit, 1e-6 * unit))[1] == 0  # on the way up, as the paper has it


@pytest.mark.parametrize("name", ["standard", "two harmonics", "own law", "critical"])
def test_no_impact_is_the_flow(name):
    m = MODELS[name].replace(**({"d": 3.0} if "d" in MODELS[name].params else {"offset": 3.0}))
    P, Z = gz.stroboscopic_map(m), gz.discontinuity_map(m)
    state = (m.sigma + 1.0, 0.5)
    assert P(state)[1] == Z(state)[1] == 0
    assert Z(state)[0] == pytest.approx(P(state)[0], abs=1e-13)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (
            lambda: gz.discontinuity_map(FIGURE_2_2, order="second"),
            gz.InputError,
            r"order is 'second'; allowed are 'lowest'",
        ),
        (
            lambda: gz.zdm_points(FIGURE_2_2, (0.06, -0.23)),
            gz.OutsideForm,
            r"no impact follows from \(u, v\) = \(0.06, -0.23\)",
        ),
        (lambda: gz.zdm_points(FIGURE_2_2, (0.0, -1e300)), gz.InputError, r"v = -1e\+300 is so fast that its square"),
        (lambda: gz.zdm_points(FIGURE_2_2, (-0.5, -0.1)), gz.InputError, r"the ball starts inside the wall"),
    ],
)
def test_bad_input_is_answered_in_words(make, error, words):
    with pytest.raises(error, match=words):
        make()
