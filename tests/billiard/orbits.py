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
