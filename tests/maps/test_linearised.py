"""The linearised map is the (x, y) map of the normal form in the units of the gap map."""

import numpy as np
import pytest

import grazing as gz
from grazing.maps.linearised import linearised_map, linearised_of
from grazing.outcome import InputError
from grazing.testing import check_map
from tests.models import TWO, packed

MODELS = {
    "standard": (gz.pinball(V=0.4), "d"),
    "passive": (gz.pinball(V=0.0, sigma=0.2), "d"),
    "b < 0": (gz.pinball(alpha=0.5, k=1.0, omega=1.3, V=0.1), "d"),
    "lambda < 0": (gz.pinball(alpha=0.2, k=3.0, V=0.1), "d"),
    "two harmonics": (gz.Oscillator(2.5, 1.1, TWO, sigma=-0.3, reset=gz.active(r=0.7, V=0.3)), "offset"),
}


@pytest.fixture(params=list(MODELS))
def form(request):
    return gz.normal_form(*MODELS[request.param])


def stepped(P, state):
    """One step in plain Python: the state, as an array, and the letter."""
    new, letter = P.step(tuple(float(x) for x in state), packed(P))[:2]
    return np.array(new), letter


def test_it_is_the_map_in_x_and_y_divided_by_the_scale(form):
    value = form.graze - 0.01
    Q, plain = linearised_of(form, value), form.xy_map(value)
    for state in np.random.default_rng(3).uniform(-0.5, 0.5, (40, 2)):
        new, letter = stepped(Q, state)
        expected, same = stepped(plain, state * form.scale)
        assert new * form.scale == pytest.approx(expected, rel=1e-12, abs=1e-13 * form.scale)
        assert letter == same


def test_it_is_the_discontinuity_map_in_other_coordinates_up_to_the_squares_of_velocities(form):
    """Where the acceleration at the state is the one at the graze: alpha v = -k^2 y, and F there is A."""
    at = form.model
    Q, Z = linearised_of(form), gz.discontinuity_map(at, order="lowest", phase=form.time)
    a, d = form.entries[0], form.entries[3]
    seen = set()
    for v in (-1e-3, -0.2, -30.0 * form.acceleration, 0.1):
        y = -at.params["alpha"] * v / at.params["k"] ** 2
        state = np.array([at.sigma + y, v])
        image, letter = stepped(Z, state)
        (x, slow), same = stepped(Q, form.to_xy(state) / form.scale)
        if (v < 0.0) == (v * v >= 2.0 * form.acceleration * y):  # an impact still to come, or none at all
            seen.add(letter)
            assert letter == same
            x1, y1 = form.to_xy(image)
            # the kick enters v before the flight: v^2 of the state is dropped as it was before the kick
            assert x1 - image[1] ** 2 == pytest.approx(form.scale * x - a * v * v, rel=1e-9, abs=1e-12)
            assert y1 + d * image[1] ** 2 == pytest.approx(form.scale * slow + form.det * v * v, rel=1e-9, abs=1e-12)
    assert 1 in seen


@pytest.mark.parametrize("root", [1.0, -1.0])
def test_the_tangent_is_the_derivative(root):
    Q = linearised_map(0.6, 0.2, 0.1, 0.3 * root, root)
    check_map(Q)
    for x in (-0.4, 0.3):
        assert np.linalg.det(Q.jacobian((x, 0.2))) == pytest.approx(0.2)  # the kick does not change it


def test_without_det_it_is_the_gap_map_but_for_the_slope_on_the_right():
    Q, G = linearised_map(0.7, 0.0, 0.2, 0.4), gz.gap_map(0.7, 0.2, 0.4)
    for x in (-0.8, -0.1, 0.0, 0.3):
        (ours, same), (theirs, letter) = stepped(Q, (x, 0.0)), stepped(G, (x,))
        assert ours[0] - (0.7 * x if x >= 0.0 else 0.0) == pytest.approx(theirs[0], abs=1e-15)
        assert same == letter


def test_studies_take_it():
    Q = linearised_map(0.5, 0.01, 0.1, 0.1)
    found = gz.orbit_diagram(Q, "mu", [0.07], starts=6)
    assert (found.period == 3).all()
    assert Q.replace(mu=-0.1).params["mu"] == -0.1


def test_a_root_that_is_no_sign_is_refused():
    with pytest.raises(InputError, match=r"root = 0\.5; allowed are 1 .* and -1"):
        linearised_map(0.5, 0.1, 0.1, 0.1, 0.5)


def test_the_linearised_map_has_virtual_orbits_too():
    """Without y its branches are those of the gap map with lam x on the right, and end where x = 0: at mu = l, 0."""
    Q = linearised_map(lam=0.5, det=0.1, mu=0.3, l=0.1)
    x = np.random.default_rng(0).uniform(-1.0, 1.0, (30, 2))
    letters = np.array([Q(one)[1] for one in x])
    images, _borders = Q.images()(Q.packed()[1][None], 0, x, letters, np.sqrt(np.abs(x[:, 0])))
    assert np.array_equal(images, [Q(one)[0] for one in x])
    orbit = next(one for one in gz.periodic_orbits(Q, 1, starts=100) if one.word == "R")
    branch = gz.continuation(Q, orbit, "mu", (-0.1, 0.5), step=0.2)
    (end,) = (one for one in branch.special if one.type == "bcb")
    assert end.value == pytest.approx(0.1, abs=1e-12) and end.converged and end.admissible
    assert min(one.clearance for one in branch) < 0.0 < branch.dataset.depth.max()
