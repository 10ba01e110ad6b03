"""Bifurcations of orbits on tables are enclosed: where formulas, branches and other units have them."""

from math import asin, pi, sqrt

import numpy as np
import pytest

import grazing as gz
from tests.billiard.orbits import active_discs, beside_a_tip, bowl, bowl_and_disc, in_a_row, posted
from tests.models import cubic


def found(table, word, **more):
    return gz.periodic_orbits(gz.collision_map(table), word=word, starts=20, **more)


def enclosed(orbit, kind, name):
    """The two ends of an enclosure that the checker confirms."""
    certificate = gz.enclose(orbit, kind, name)
    assert certificate.proven, certificate.reason
    assert gz.check_certificate(certificate.document) == certificate.statement
    return certificate.value


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e6])
def test_a_ball_at_the_bottom_of_a_bowl_doubles_where_its_speed_is_the_root_of_g_r(scale):
    """It leaves with w = V/(1 - r); with v = r w + V = w, one turn has -1 among its multipliers at w^2 = g R."""
    table = bowl(radius=2.0 * scale, r=0.78, V=0.3 * sqrt(scale))
    (orbit,) = found(table, "(bowl)")
    exact = {
        "bowl.r": 1.0 - 0.3 / sqrt(2.0),
        "bowl.V": 0.22 * sqrt(2.0 * scale),
        "bowl.radius": scale * (0.3 / 0.22) ** 2,
        "g": 0.5 * (0.3 / 0.22) ** 2,
    }
    for name, value in exact.items():
        low, high = enclosed(orbit, "pd", name)
        assert low <= value * (1 + 1e-15) and value * (1 - 1e-15) <= high and high - low < 3e-13 * value


def test_without_loss_it_doubles_at_an_energy():
    """E = w^2/2 - g R and w^2 = g R: at R = -2 E/g."""
    (orbit,) = found(bowl(radius=1.9, r=1.0, V=0.0), "(bowl)", energy=-1.0)
    low, high = enclosed(orbit, "pd", "bowl.radius")
    assert low < 2.0 < high and high - low < 1e-12
    proof = gz.enclose(orbit, "ns", "bowl.radius")
    assert not proof.proven and "multipliers stay on the unit circle" in proof.reason


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_a_post_is_touched_where_geometry_has_it(scale):
    """The ball flies from A to B along y = 0.5 and from C to A along a line at 60 degrees."""
    (orbit,) = found(posted(0.69, scale), "ABC")
    low, high = enclosed(orbit, "gr", "post.y")
    assert low <= 0.7 * scale <= high and high - low < 1e-12 * scale
    (far,) = found(posted(1.19, scale), "ABC")
    line = 0.5 + (1.5 - 0.5 * sqrt(3.0)) * sqrt(3.0)  # its height at the post, on the way to A's impact
    low, high = enclosed(far, "gr", "post.y")
    distance = abs(0.5 * (low + high) / scale - line) / 2.0
    assert distance == pytest.approx(0.2, abs=1e-12) and low < high


def test_the_object_is_touched_that_the_parameter_moves():
    """Another one, which it does not move, is nearer to the way of the ball."""
    nearer = gz.disc("nearer", (2.5, 0.695), 0.19, gz.newton(0.5))
    (orbit,) = found(gz.table([*posted(0.71).objects, nearer]), "ABC")
    low, high = enclosed(orbit, "gr", "post.y")
    assert low <= 0.7 <= high


def test_the_values_are_those_of_branches():
    """A fold, a doubling and a pair on the unit circle, of three orbits."""
    (orbit, *_others) = found(bowl(r=0.8, V=0.262), "(bowl)", period=3)
    branch = gz.continuation(orbit.map, orbit, "bowl.V", (0.25, 0.3))
    kinds = {point.type: point for point in branch.special}
    assert set(kinds) == {"lp", "pd"}
    for kind, point in kinds.items():
        low, high = enclosed(point.orbit, kind, "bowl.V")
        assert 0.5 * (low + high) == pytest.approx(point.value, rel=1e-10)
    (_other, turning) = found(bowl_and_disc(r=0.7943), "(bowl)A")
    branch = gz.continuation(turning.map, turning, "bowl.r", (0.79425, 0.7943))
    (pair,) = (point for point in branch.special if point.type == "ns")
    low, high = enclosed(pair.orbit, "ns", "bowl.r")
    assert 0.5 * (low + high) == pytest.approx(pair.value, rel=1e-9)


@pytest.mark.parametrize("scale", [1.0, 1e6])
def test_a_fold_is_found_in_any_unit_of_length(scale):
    (orbit, *_others) = found(bowl(radius=2.0 * scale, r=0.8, V=0.262 * scale, g=scale), "(bowl)", period=3)
    low, high = enclosed(orbit, "lp", "bowl.V")
    assert low / scale < 0.26106498194244282 < high / scale


def test_an_object_whose_name_no_certificate_holds_is_named():
    disc = gz.disc("Ä", (9.0, 9.0), 1.0, gz.newton(0.5))
    (orbit,) = found(gz.table([*bowl(r=0.78).objects, disc], tilt=0.5 * pi), "(bowl)")
    assert "an object cannot be called 'Ä'" in gz.enclose(orbit, "pd", "bowl.r").reason


def test_a_tip_is_touched_and_the_sentence_says_so():
    orbit = found(beside_a_tip(-0.85), "(bowl)", period=3)[1]
    certificate = gz.enclose(orbit, "gr", "wire.y2")
    assert 'the ball touches stop of "wire" on the flight after impact' in certificate.statement
    assert 'of y2 of "wire" in [' in certificate.statement and "y2 = " not in certificate.statement
    assert repr(certificate).startswith("<Certificate: gr of the periodic orbit (bowl) on a table, wire.y2 = -0.8685")


def test_what_is_no_bifurcation_is_not_proven():
    (orbit,) = found(in_a_row(1.05), "AC")
    proof = gz.enclose(orbit, "gr", "B.y")
    assert not proof.proven and "1 and 2 touch at once, as on an orbit that comes back the way it went" in proof.reason
    post = gz.disc("post", (0.52, -0.9), 0.5, gz.newton(0.5))  # beside the way up and down
    (upright,) = found(gz.table([*bowl(r=0.8).objects, post], tilt=0.5 * pi), "(bowl)")
    assert "the flight after impact 1 touches twice at once" in gz.enclose(upright, "gr", "post.x").reason
    saddle = found(active_discs(3.0), "ABC")[0]
    assert "two real multipliers have the product 1" in gz.enclose(saddle, "ns", "A.radius").reason
    alone = found(active_discs(3.0), "AB")[0]
    for kind in ("pd", "lp", "gr"):
        assert not gz.enclose(alone, kind, "C.V").proven


def test_names_and_kinds_that_are_none_are_refused():
    orbit = found(active_discs(3.0), "AB")[0]
    with pytest.raises(gz.InputError, match="kind is 'bp'; allowed are pd, lp, ns, gr"):
        gz.enclose(orbit, "bp", "A.V")
    with pytest.raises(gz.InputError, match="kind is array"):
        gz.enclose(orbit, np.array("pd"), "A.V")
    with pytest.raises(gz.InputError, match=r"V stands for A\.V and B\.V and C\.V; name one of them"):
        gz.enclose(orbit, "pd", "V")
    with pytest.raises(gz.InputError, match=r"unknown parameter 'D\.V' of the table\. Did you mean 'C\.V'"):
        gz.enclose(orbit, "pd", "D.V")


def test_a_certificate_is_held_against_a_table():
    (orbit,) = found(bowl(r=0.78), "(bowl)")
    proof = gz.enclose(orbit, "pd", "bowl.r")
    assert gz.check_certificate(proof.document, model=bowl(r=0.5)) == proof.statement  # the parameter that varies
    with pytest.raises(gz.InputError, match=r"another model: its objects bowl law V is 0\.3, here it is 0\.4"):
        gz.check_certificate(proof.document, model=bowl(r=0.78, V=0.4))


def test_the_angle_of_a_table_may_vary():
    (orbit,) = found(gz.table(bowl(r=0.78).objects, g=1.2, tilt=1.0), "(bowl)")
    low, high = enclosed(orbit, "pd", "tilt")
    assert 0.5 * (low + high) == pytest.approx(asin((0.3 / 0.22) ** 2 / 2.4), rel=1e-12) and high < 0.5 * pi


def test_a_search_that_digits_do_not_follow_ends_in_words():
    """Flights of no length at all were divided by; and what 256 bits lose was told in a traceback."""
    disc = gz.disc("A", (0.0, 1.5), 0.118, gz.triggered(0.732, V=0.456, trigger=0.127))
    above = gz.table([disc], rho=0.05, g=1.0, tilt=0.2)
    for hop in found(above, "A"):
        assert not gz.enclose(hop, "lp", "A.trigger").proven
    law = gz.reset(cubic, e=0.9, c=-0.2)
    disc = gz.disc("A", (-0.567, 0.34), 0.5, gz.triggered(0.662, V=0.34, trigger=0.12))
    ring = gz.table([gz.arc("ring", (0.0, 0.0), 2.0, 0.0, 2.0 * pi, law), disc], g=1.0, tilt=0.2)
    reasons = [gz.enclose(orbit, "lp", "g").reason for orbit in found(ring, "(ring)")]
    assert any("256 bits do not follow" in reason for reason in reasons), reasons
