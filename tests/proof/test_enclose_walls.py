"""Bifurcation values between walls and at a moving one: closed forms and values of branches are in the enclosures."""

import numpy as np
import pytest
from mpmath import mp, mpf

import grazing as gz
from grazing.proof.check import check_certificate
from grazing.proof.enclose import enclose
from tests.grazing_checker.documents import found_in, inverted, rattle, vibrating_table, walled_orbits
from tests.proof.orbits import closed


def enclosed(orbit, kind, name):
    certificate = enclose(orbit, kind, name)
    assert certificate.proven, certificate.reason
    assert check_certificate(certificate.document) == certificate.statement
    low, high = (mpf(x) for x in certificate.claims["value"])
    assert high - low < mpf("1e-12") * (1 + abs(low))
    return certificate, low, high


def flip_of(r):
    """Amplitude at which the ball that bounces once a period doubles, over g/omega^2."""
    r = mpf(r)
    return mp.sqrt((mp.pi * (1 - r) / (1 + r)) ** 2 + (2 * (1 + r * r) / (1 + r) ** 2) ** 2)


@pytest.mark.parametrize(("r", "amplitude"), [(0.5, 1.4), (0.3, 2.0), (0.75, 1.1)])
def test_the_vibrating_table_folds_and_flips_where_it_should(r, amplitude):
    with mp.workdps(40):
        orbit = found_in(vibrating_table(r, amplitude), "1", stable=True)
        flip, fold = flip_of(r), mp.pi * (1 - mpf(r)) / (1 + mpf(r))
        certificate, low, high = enclosed(orbit, "pd", "A.sin1")
        assert low <= flip <= high and "value of A.sin_1 in [" in certificate.statement
        assert certificate.claims["ends"] == ["stable", "unstable"]
        _certificate, low, high = enclosed(orbit, "lp", "A.sin1")  # at t = 0, where a time has no size of its own
        assert low <= fold <= high
        A = mpf(amplitude)
        for name, value in (("omega", mp.sqrt(flip / A)), ("offset", -A / flip), ("A.cos1", mp.sqrt(flip**2 - A**2))):
            _certificate, low, high = enclosed(orbit, "pd", name)
            assert low <= abs(value) <= high or low <= value <= high


def test_a_parameter_of_a_law_is_called_by_the_wall():
    certificate, low, high = enclosed(found_in(vibrating_table(0.5, 1.4), "1", stable=True), "pd", "r")
    assert 'a value of p.r of the wall "A" in [' in certificate.statement
    with mp.workdps(40):
        assert flip_of(low) >= mpf(1.4) >= flip_of(high)


def dropping(omega, times, incoming):
    """A ball over a vibrating wall, with an orbit of two periods."""
    wall = gz.wall(
        0.0, gz.newton(0.6520179756892707),
        motion=gz.Forcing(omega, cos=(0.17093294575310342,), sin=(0.7994009568833862,)),
    )  # fmt: skip
    model = gz.Oscillator(0.0, 0.0, gz.Forcing(omega, offset=-1.0, cos=()), walls=[wall])
    v = -np.array(incoming)
    return closed(model, 2, np.array(times), -0.6520179756892707 * v, v)[0]


def test_a_dip_just_after_a_slow_impact_is_seen():
    """Within one step of its flight, which rises at both ends."""
    orbit = dropping(
        1.518675456005691,
        [3.41852344, 3.67036938, 3.86993586, 4.03676161, 4.18988588, 7.28712902, 9.24180116, 10.8577435, 11.356835],
        [0.44124391, 0.26443363, 0.15458258, 0.08756182, 0.04608692, 2.22306394, 0.02509707, 1.05533987, 0.71134909],
    )
    certificate, low, high = enclosed(orbit, "gr", "omega")
    assert certificate.document["data"]["dip"]["flight"] == 5
    assert float(low) < 1.518675456005691 < float(high)  # where the branch has it


def test_of_several_dips_that_which_touches_is_meant():
    """At a graze of a virtual orbit, another dip is in the wall: its own graze, one per cent away, is not that one."""
    times, incoming = [3.6420548, 7.00926961, 10.57796562, 11.15136871], [0.46525412, 2.19767952, 1.3134314, 0.841821]
    proof = enclose(dropping(1.5787433333994432, times, incoming), "gr", "omega")
    assert not proof.proven and "the orbit is virtual" in proof.reason


def test_a_free_response_grazes_a_moving_wall_where_the_distance_says():
    (orbit,) = (one for name, one in walled_orbits().items() if name == "aloft")
    certificate, low, high = enclosed(orbit, "gr", "A.sigma")
    assert 'a dip touches the wall "A" (graze)' in certificate.statement
    with mp.workdps(40):
        p = orbit.model.params
        lag = mpf(1) - 4 + mp.mpc(0, 1) * 2 * mpf(0.5)  # k^2 - omega^2 + i alpha omega

        def over(t):
            u = (mpf(p["cos1"]) * mp.exp(mp.mpc(0, 2) * t) / lag).real
            return u - mpf(p["A.cos2"]) * mp.cos(4 * t) - mpf(p["A.sin2"]) * mp.sin(4 * t)

        grid = [mp.pi * j / 200 for j in range(200)]
        least = over(mp.findroot(lambda t: mp.diff(over, t), min(grid, key=over)))
        assert low <= least <= high


@pytest.mark.parametrize("name", ["B.sigma", "omega"])
def test_special_points_of_branches_between_walls_are_enclosed(name):
    orbit = found_in(rattle(), "(BAB)", stable=True)
    span = {"B.sigma": (0.39, 0.7), "omega": (1.8, 2.3)}[name]
    branch = gz.continuation(orbit.map, orbit, name, span)
    points = [point for point in branch.special if point.type in ("pd", "lp", "gr") and point.orbit.impacts < 4]
    assert {point.type for point in points} >= {"lp", "gr"}
    for point in points:
        certificate, low, high = enclosed(point.orbit, point.type, name)
        assert low - 1e-11 < point.value < high + 1e-11
        if point.type == "gr":
            assert certificate.document["data"]["dip"]["wall"] == point.wall


def test_a_doubling_of_an_inverted_pendulum_between_stops_is_enclosed():
    orbits = gz.periodic_orbits(gz.stroboscopic_map(inverted()), word="(BA)", starts=30)
    stable = next(one for one in orbits if one.stable)
    branch = gz.continuation(stable.map, stable, "stiffness", (-1.5, -0.9))
    (point,) = (one for one in branch.special if one.type == "pd")
    certificate, low, high = enclosed(point.orbit, "pd", "stiffness")
    assert low - 1e-11 < point.value < high + 1e-11 and "a value of stiffness in [-1.3" in certificate.statement


def test_over_one_wall_at_rest_no_value_of_a_negative_damping_is_enclosed():
    """Its certificates know alpha >= 0 only; at a moving table the same doubling, at alpha = -0.0345, is one."""
    moving = found_in(vibrating_table(0.5, 1.4), "1", stable=True)
    push = gz.Forcing(omega=1.0, offset=-1.0, sin=(1.4,), cos=())
    still = found_in(gz.Oscillator(0.0, 0.0, push, gz.newton(0.5)), "1", stable=True)
    assert np.allclose(moving.times, still.times, atol=1e-12)
    assert not enclose(still, "pd", "alpha").proven
    certificate, _low, high = enclosed(moving, "pd", "alpha")
    assert -0.04 < high < 0 and certificate.document["kind"] == "bifurcation value with walls"


def test_no_value_is_enclosed_that_the_force_of_a_base_depends_on():
    """With its amplitude kept the base's force grows with omega: one of the same force is the value of another rig."""
    stops = [gz.wall(-0.8e-3, gz.newton(0.7)), gz.wall(1.2e-3, gz.newton(0.7))]
    rig = gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, base=1e-3, moves="both", frequency=14, walls=stops)
    orbit = found_in(rig, "(BA)")
    for name in ("omega", "alpha", "k", "cos1"):
        with pytest.raises(gz.InputError, match="does not know that the force of a moving base depends"):
            enclose(orbit, "gr", name)
    assert enclose(orbit, "gr", "A.sigma").title.startswith("gr of the periodic orbit")
