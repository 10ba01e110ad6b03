"""Tables whose periodic orbits are tested."""

from math import pi, sqrt

import grazing as gz
from tests.billiard.tables import ELASTIC, box


def active_discs(distance, r=0.8, V=0.25, scale=1.0):
    """Three active discs at the corners of a triangle, of radius ``scale``."""
    corners = {"A": (0.0, 0.0), "B": (distance, 0.0), "C": (0.5 * distance, 0.5 * sqrt(3.0) * distance)}
    law = gz.active(r, V * scale)
    return gz.table([gz.disc(name, (scale * x, scale * y), scale, law) for name, (x, y) in corners.items()])


def pinball(V=0.4, scale=1.0):
    """Two bumpers over a drain, between walls that take energy; lengths and speeds in units of ``scale``."""
    walls = [one for one in box(6.0 * scale, 10.0 * scale, gz.newton(0.9)) if one.name != "floor"]
    bumper = gz.active(r=0.9, V=V * scale)
    bumpers = [gz.disc(name, (x * scale, 6.0 * scale), 0.5 * scale, bumper) for name, x in (("P", 2.0), ("Q", 4.0))]
    drain = gz.drain("out", (0.0, 0.0), (6.0 * scale, 0.0))
    return gz.table([*bumpers, *walls, drain], rho=0.1 * scale, g=scale, tilt=0.2)


def bowl(radius=2.0, r=0.5, V=0.3, rho=0.0, g=1.0):
    """An active bowl, open above."""
    return gz.table([gz.arc("bowl", (0.0, 0.0), radius, pi, 2.0 * pi, gz.active(r, V))], rho=rho, g=g, tilt=0.5 * pi)


def in_a_row(beside=0.0):
    """Three equal discs side by side; the one in the middle is moved up."""
    places = {"A": (0.0, 0.0), "B": (3.0, beside), "C": (6.0, 0.0)}
    return gz.table([gz.disc(name, place, 1.0, ELASTIC) for name, place in places.items()])


def posted(y, scale=1.0):
    """Three active discs, and a post near the way from one to another."""
    table = active_discs(4.0, scale=scale)
    return gz.table([*table.objects, gz.disc("post", (1.5 * scale, y * scale), 0.2 * scale, gz.newton(0.5))])


def bowl_and_disc(r=0.8):
    """An active bowl with a small active disc above it."""
    disc = gz.disc("A", (0.1, -0.6), 0.3, gz.active(0.9, 0.1))
    return gz.table([*bowl(r=r).objects, disc], g=1.0, tilt=0.5 * pi)


def beside_a_tip(y):
    """An active bowl with a wire that ends above the way of a ball with a radius."""
    wire = gz.segment("wire", (0.4, 1.0), (0.4, y), gz.newton(0.5))
    return gz.table([*bowl(r=0.8, V=0.2554, rho=0.1).objects, wire], rho=0.1, g=1.0, tilt=0.5 * pi)
