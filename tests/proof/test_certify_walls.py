"""Orbits between walls, at one that moves or is above the ball: proven, and what closed forms say lies in the boxes."""

import re

import numpy as np
import pytest
from mpmath import mp, mpf

import grazing as gz
from grazing.proof.certify import certify
from grazing.proof.check import check_certificate
from tests.grazing_checker.documents import found_in, impact_pair, inverted, rattle, vibrating_table, walled
from tests.models import cubic
from tests.proof.orbits import without_impacts


def proven(orbit):
    certificate = certify(orbit)
    assert certificate.proven, certificate.reason
    assert check_certificate(certificate.document) == certificate.statement
    return certificate


def overlap(one, two):
    (a, b), (c, d) = ([mpf(x) for x in pair] for pair in (one, two))
    return max(a, c) <= min(b, d)


@pytest.mark.parametrize(("r", "gap"), [(0.5, 3.0), (0.3, 2.5), (0.8, 2.2), (0.5, 4.0)])
def test_the_phase_of_the_impact_pair_is_in_the_box(r, gap):
    """cos phi + 2 s sin phi = -s L/a, s = (1 - r)/((1 + r) pi), phi the phase of the upper wall at its impact."""
    P = gz.stroboscopic_map(impact_pair(r, gap))
    (orbit,) = (one for one in gz.periodic_orbits(P, word="(BA)", starts=60) if one.symmetric)
    certificate = proven(orbit)
    assert certificate.claims["symmetric"] and "its own mirror image" in certificate.statement
    with mp.workdps(40):
        s = (1 - mpf(r)) / ((1 + mpf(r)) * mp.pi)
        phi = mp.atan(2 * s) + mp.acos(-s * mpf(gap) / mp.sqrt(1 + 4 * s * s))
        away = (mpf(gap) + 2 * mp.sin(phi)) / mp.pi + mp.cos(phi)  # from the upper wall, relative to it
        i = orbit.walls.index("B")
        (low, high), (slow, fast) = ([mpf(x) for x in certificate.claims["box"][k]] for k in (i, 2 + i))
        turns = mp.nint((low - phi) / (2 * mp.pi))
        assert low <= phi + 2 * mp.pi * turns <= high and high - low < 1e-15
        assert slow <= away <= fast and fast - slow < 1e-15


def test_beyond_the_breaking_of_symmetry_no_orbit_says_that_it_is_symmetric():
    """L = a (pi^2/2 - 2) sin phi, tan phi = -2 (1 + r)/(pi (1 - r)): 2.5999 for r = 0.5."""
    orbits = gz.periodic_orbits(gz.stroboscopic_map(impact_pair(0.5, 2.55)), word="(BA)", starts=100)
    kinds = {(certificate.claims["symmetric"], certificate.claims["stability"]) for certificate in map(proven, orbits)}
    assert kinds == {(True, "unstable"), (False, "stable")}


def church_fortin():
    shake, fall = (gz.Forcing(omega=2.0 * np.pi, offset=a, sin=s, cos=()) for a, s in ((0.0, (1.0,)), (-9.81, ())))
    return walled(0.0, {"k": 0.0}, fall, gz.wall(0.0, gz.newton(0.8), motion=shake))


def test_church_and_fortins_orbits_on_the_moving_table():
    P = gz.stroboscopic_map(church_fortin())
    said = []
    for word in "12":
        for orbit in gz.periodic_orbits(P, word=word, virtual=True, starts=100):
            certificate = certify(orbit)
            assert certificate.proven == orbit.admissible
            if not certificate.proven:
                assert "virtual" in certificate.reason
                said.append(round(float(certificate.reason.split("it is ")[-1].split(" deep")[0]), 4))
                continue
            proven(orbit)
            assert certificate.claims["stability"] == "unstable"
            (low, high), _w = ([float(x) for x in pair] for pair in certificate.claims["box"])
            assert low <= 0.236177618990 + 5e-13 and high >= 0.236177618990 - 5e-13 and high - low < 1e-15
            ((before, _high),) = certificate.claims["incoming"]
            assert float(before) + 2.0 * np.pi * np.cos(2.0 * np.pi * low) == pytest.approx(-4.905, abs=1e-12)
    assert sorted(said) == [0.0503, 0.7712, 0.9543]


def test_a_moving_table_and_the_same_table_at_rest_have_the_same_boxes():
    push = gz.Forcing(omega=2.0 * np.pi, offset=-9.81, sin=((2.0 * np.pi) ** 2,), cos=())
    still = gz.Oscillator(0, 0, push, gz.newton(0.8))
    one, two = (proven(found_in(model, "1")).claims for model in (still, church_fortin()))
    for a, b in zip(one["box"], two["box"], strict=True):  # the push is a rounded number
        assert float(a[0]) == pytest.approx(float(b[0]), abs=1e-14)
    assert [float(one[key][0]) for key in ("trace", "det")] == pytest.approx(
        [float(two[key][0]) for key in ("trace", "det")]
    )


def test_a_wall_out_of_reach_changes_no_box():
    law, force = gz.active(r=0.8, V=0.4), gz.Forcing(omega=2.2, offset=0.12)
    one = gz.Oscillator(3.0, 1.0, force, law)
    two = walled(3.0, {"k": 1.0}, force, gz.wall(0.0, law), gz.wall(50.0, gz.newton(0.5)))
    a, b = proven(found_in(one, "001")), proven(found_in(two, "00A"))
    assert all(overlap(*pair) for pair in zip(a.claims["box"], b.claims["box"], strict=True))
    assert all(overlap(a.claims[key], b.claims[key]) for key in ("trace", "det"))
    assert "periodic orbit with walls" == b.document["kind"] != a.document["kind"]


def upside_down(model):
    """The same ball with u turned round: the wall below it is above."""
    f = model.forcing
    turned = gz.Forcing(f.omega, f.t0, -f.offset, cos=[-c for c in f.cos], sin=[-s for s in f.sin])
    return walled(model.alpha, {"k": model.k}, turned, gz.wall(-model.sigma, model.reset, side="above"))


@pytest.mark.parametrize("law", [gz.newton(0.6), gz.triggered(0.6, 0.3, 0.1), gz.reset(cubic, e=0.8, c=0.5)], ids=repr)
def test_a_wall_above_is_one_below_seen_upside_down(law):
    model = gz.Oscillator(0.2, 1.0, gz.Forcing(omega=2.0, cos=(1.0,), sin=(0.3,)), law, sigma=-0.2)
    word = "1"
    a, b = (proven(found_in(one, word)) for one in (model, upside_down(model)))
    assert all(overlap(*pair) for pair in zip(a.claims["box"], b.claims["box"], strict=True))
    assert overlap(a.claims["trace"], b.claims["trace"])
    assert 'u < z_A at the wall "A"' in b.statement and "z_A' - u' = v < 0" in b.statement


NOD = gz.Forcing(omega=4.0, t0=0.3, cos=(0.05,), sin=(0.02,))
MODELS = {
    "moving": walled(
        0.1, {"k": 0.5}, gz.Forcing(omega=2.0, t0=0.3, cos=(2.0,)),
        gz.wall(-0.5, gz.newton(0.8), motion=NOD), gz.wall(0.6, gz.reset(cubic, e=0.8, c=0.5)),
    ),
    "trigger": walled(
        0.1, {"k": 0.5}, gz.Forcing(omega=2.0, cos=(2.0,)),
        gz.wall(-0.5, gz.triggered(0.6, 0.4, 0.1), name="L"), gz.wall(0.6, gz.active(0.6, 0.2), name="R"),
    ),
    "inverted": inverted(),
    "fed": walled(
        -0.1, {"k": 1.0}, gz.Forcing(omega=2.0, cos=(1.5,)),
        gz.wall(-0.4, gz.newton(0.6)), gz.wall(0.4, gz.newton(0.6)),
    ),
    "rattle": rattle(),
}  # fmt: skip


@pytest.mark.parametrize("name", MODELS)
def test_orbits_of_all_kinds_of_models_with_walls_are_proven(name):
    orbits = gz.periodic_orbits(gz.stroboscopic_map(MODELS[name]), [1], starts=60)
    assert len(orbits) > 2
    for orbit in orbits:
        certificate = proven(orbit)
        assert certificate.claims["stability"] == ("stable" if orbit.stable else "unstable")
        assert certificate.claims["symmetric"] == orbit.symmetric and certificate.claims["least_period"]
        if orbit.impacts:
            t, w = np.split(np.array([float(low) for low, _high in certificate.claims["box"]]), 2)
            np.testing.assert_allclose(t, orbit.times, atol=1e-9)
            np.testing.assert_allclose(w, orbit.outgoing, atol=1e-9)
            v = [float(low) for low, _high in certificate.claims["incoming"]]
            np.testing.assert_allclose(np.roll(v, 1), orbit.incoming, atol=1e-9)
        mu = [complex(float(m["real"][0]), float(m["imag"][0])) for m in certificate.claims["multipliers"]]
        np.testing.assert_allclose(np.sort_complex(mu), np.sort_complex(orbit.multipliers), atol=1e-6, rtol=1e-6)


def test_an_oscillator_over_one_wall_with_a_negative_stiffness_is_proven():
    model = gz.Oscillator(
        0.3, stiffness=-1.0, forcing=gz.Forcing(omega=2.0, cos=(1.5,)), reset=gz.newton(0.6), sigma=-0.4
    )
    orbits = [one for one in gz.periodic_orbits(gz.stroboscopic_map(model), [1], starts=60) if one.impacts]
    assert orbits
    for orbit in orbits:
        assert "u'' + alpha u' + stiffness u" in proven(orbit).statement


def test_a_doubled_orbit_between_walls_has_its_least_period():
    certificate = proven(found_in(vibrating_table(0.5, 1.6), "1", period=2))
    assert "of least period 2 T," in certificate.statement
    assert certificate.document["inequalities"][-1]["name"] == "least period, divisor 2"


def test_a_ball_that_comes_to_rest_is_refused_in_words():
    orbits = gz.periodic_orbits(gz.stroboscopic_map(vibrating_table(0.5, 1.4)), [1], starts=60)
    (resting,) = (one for one in orbits if not hasattr(one, "times"))
    with pytest.raises(gz.InputError, match="comes to rest on a wall"):
        certify(resting)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_parameter_of_a_law_may_begin_like_an_amplitude(count):
    """The proof is that of the same law under another name."""

    def claims(name):
        law = gz.reset(lambda v, p: -getattr(p, name) * v, **{name: 0.6})
        force, nod = gz.Forcing(omega=2.0, cos=(2.0,)), gz.Forcing(omega=2.0, cos=(0.01,))
        sides = gz.wall(-0.5, law, motion=nod), gz.wall(0.5, law)
        if count:
            model = walled(0.1, {"k": 0.5}, force, *sides[:count])
        else:
            model = gz.Oscillator(0.1, 0.5, force, law, sigma=-0.5)
        orbits = gz.periodic_orbits(gz.stroboscopic_map(model), [1], starts=20)
        return proven(next(one for one in orbits if one.impacts)).claims

    assert claims("cosine") == claims("e")


@pytest.mark.parametrize("side", ["below", "above"])
def test_what_is_said_of_an_orbit_without_impacts_is_its_distance_from_the_wall_and_the_rate_of_that(side):
    """Against the response in closed form, u = 0.3 + Re A e^(2it) with A (1 - 4 + i) = 1/2."""
    away = {"below": 1, "above": -1}[side]
    force = gz.Forcing(omega=2.0, offset=0.3, cos=(0.5,))
    model = walled(0.5, {"k": 1.0}, force, gz.wall(0.3 - away, gz.newton(0.6), side=side))
    said = proven(without_impacts(model)).statement
    A = 0.5 / (-3 + 1j)
    names = {"below": ("u - z_A", "u' - z_A'"), "above": ("z_A - u", "z_A' - u'")}[side]
    for name, value in zip(names, (1 + away * A.real, away * (2j * A).real), strict=True):
        low, high = re.search(rf"(?:with|,) {name} at t = 0 in \[(\S+), (\S+)\]", said).groups()
        assert float(low) <= value + 1e-15 and value - 1e-15 <= float(high)
