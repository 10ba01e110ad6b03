"""Solutions that rounding has moved are one orbit, and orbits that are truly near to each other stay different."""

from math import pi, sqrt, tanh

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.one_orbit import NEAR, moved


@pytest.mark.parametrize("e", [1e-8, 1e-9, 1e-10, 1e-12])
def test_a_table_whose_law_takes_hardly_any_speed_has_one_orbit(e: float) -> None:
    law = gz.active(r=1.0 - e, V=1.2 * e)
    table = gz.table([gz.arc("bowl", (0, 0), 2.0, pi, 2.0 * pi, law)], g=1.0, tilt=pi / 2.0)
    (orbit,) = gz.periodic_orbits(gz.collision_map(table), word="(bowl)", starts=30)
    assert orbit.points[0, 2] == pytest.approx(law.params["V"] / (1.0 - law.params["r"]), abs=1e-15 / e)


@pytest.mark.parametrize("e", [1e-9, 1e-10])
def test_a_map_near_the_identity_has_each_fixed_point_once(e: float) -> None:
    def step(x: tuple[float, ...], c: gz.Map) -> tuple[float, ...]:
        return (x[0] + c.e * (0.3 - x[0] * x[0]),)  # type: ignore[attr-defined]

    P = gz.Map(step, params={"e": e}, coordinates=("x",), box=((0.0, 2.0),))
    found = sorted(orbit.points[0, 0] for orbit in gz.periodic_orbits(P, period=1, starts=200))
    assert found == pytest.approx([-sqrt(0.3), sqrt(0.3)], abs=1e-15 / e)


def test_an_oscillator_that_loses_hardly_any_speed_has_each_orbit_once() -> None:
    e = 1e-9
    force = gz.Forcing(omega=1, offset=-1, cos=(3.0 * e,))
    P = gz.impact_map(gz.Oscillator(alpha=0, k=0, forcing=force, reset=gz.newton(1.0 - e)))
    found = gz.periodic_orbits(P, period=1, word="1", starts=200)
    assert len(found) == 2 and abs(found[0].points[0, 0] - found[1].points[0, 0]) > 1.0


@pytest.mark.parametrize("s", [1e-6, 1e-9])
def test_orbits_that_are_truly_near_stay_different(s: float) -> None:
    def step(x: tuple[float, ...], c: gz.Map) -> tuple[float, ...]:
        return (2.0 * c.s * tanh(x[0] / c.s),)  # type: ignore[attr-defined]

    P = gz.Map(step, params={"s": s}, coordinates=("x",), box=((-1.0, 1.0),))
    found = sorted(orbit.points[0, 0] / s for orbit in gz.periodic_orbits(P, period=1) if orbit.stable)
    assert found == pytest.approx([-1.9150080481545374, 1.9150080481545374], rel=1e-9)  # of x = 2 tanh x


@pytest.mark.parametrize("s", [1e-4, 1e-6, 1e-8])
def test_orbits_of_one_piece_that_are_truly_near_stay_different(s: float) -> None:
    pieces = {
        "L": lambda x, c: (-0.1 * x[0] - 1.0,),
        "R": lambda x, c: (0.5 + 2.0 * c.s * tanh((x[0] - 0.5) / c.s),),
    }
    box = ((-2.0, 2.0),)
    P = gz.Map(pieces=pieces, border=lambda x, c: x[0], params={"s": s}, coordinates=("x",), box=box)
    right = [orbit for orbit in gz.periodic_orbits(P, period=1) if orbit.word == "R" and orbit.stable]
    found = sorted((orbit.points[0, 0] - 0.5) / s for orbit in right)
    assert found == pytest.approx([-1.9150080481545374, 1.9150080481545374], rel=1e-6)


def test_what_rounding_may_do_grows_with_the_condition_until_it_is_a_family() -> None:
    one, none = np.ones(1), np.zeros(1)
    off = [float(moved(none, np.array([[slope]]), one, 2e-16 * one, one, 1e-8)[0]) for slope in (1.0, 1e-9, 0.0)]
    assert off[0] == NEAR and 1e-7 < off[1] < 1e-5
    assert off[2] == 1e-8
