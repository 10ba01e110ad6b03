"""Proofs that a periodic orbit on a table exists, meets nothing else, and is stable or unstable: the finder.

Newton's method in balls and the choice of the boxes; what the checker demands of them is in grazing_checker/table.py.
"""

from __future__ import annotations

from math import frexp, hypot
from typing import Any

import numpy as np
from flint import arb

from grazing.billiard import table as tables
from grazing.billiard.objects import ARC, DISC, Thing
from grazing.orbits.bounce_orbit import BounceOrbit
from grazing.orbits.bounces import Surface, solid_surfaces
from grazing.pool import LOCK
from grazing.proof.expression import NotAnExpression, expression
from grazing.proof.gap import Writer
from grazing.proof.law import law_of
from grazing.proof.reasons import NotProven
from grazing.proof.report import loose
from grazing.proof.text import below, enclosed, exact_text, short
from grazing_checker.balls import precision
from grazing_checker.oscillator import box_of, spread
from grazing_checker.reading import Rejected
from grazing_checker.table import BITS, Table, margins, sums_of, table_rows, turned

#: Half-widths in sizes of the coordinates, as powers of two: of the orbit, and of the box of uniqueness, widest first.
ORBIT, WIDEST, NARROWEST = -120, -3, -90
#: Bits of the middles, and Newton steps with one inverse, each of which gains about as many as a double has.
MIDDLE, STEPS = 180, 24


class TableWriter(Writer):
    """Writes down the inequalities; ``name`` is that of the quantity that shows an orbit to be unstable."""

    name = ""


def prove_bounces(orbit: BounceOrbit) -> tuple[dict[str, Any], list[dict[str, str]]]:
    """Return data and inequalities of the certificate of an orbit on a table, or raise NotProven."""
    if not orbit.admissible:
        raise NotProven("the orbit is virtual: something is in its way, or an impact is off its object")
    with LOCK, precision(BITS):
        try:
            data = described(orbit)
            return _proof(orbit, data)
        except Rejected as error:
            raise NotProven(str(error)) from None
        except NotAnExpression as error:
            raise NotProven(
                f"a reset law cannot be written as an expression ({error}); write it with arithmetic, comparisons and "
                "abs of its arguments only"
            ) from None


def described(orbit: BounceOrbit) -> dict[str, Any]:
    """Return what a certificate says of a table and of the word of an orbit."""
    table = orbit.map.origin.impacts_on
    by_number = {surface.number: surface for surface in solid_surfaces(table)}
    word = [by_number[number] for number in orbit.surfaces]
    speeds = [float(speed) for speed in orbit.points[:, 2]]
    return {
        **described_table(table, speeds),
        "impacts": [[table.names[surface.owner], part_of(table.objects[surface.owner], surface)] for surface in word],
        "energy": orbit.energy.hex() if orbit.conserves else None,
    }


def described_table(table: tables.Table, speeds: list[float]) -> dict[str, Any]:
    """Return what a certificate says of a table, whose laws are looked at about these speeds of impacts."""
    return {
        "objects": [_object(one, speeds) for one in table.objects],
        **{name: getattr(table, name).hex() for name in ("rho", "g", "tilt")},
    }


def _object(one: Thing, speeds: list[float]) -> dict[str, Any]:
    found: dict[str, Any] = {"name": one.name, "kind": one.kind}
    found["shape"] = {name: float(x).hex() for name, x in one.shape.items()}
    if one.law is not None:
        params = dict(one.law.params)
        tree = expression(one.law.law, params, tuple(params), [-speed for speed in speeds])
        found["law"] = law_of({name: float(x).hex() for name, x in params.items()}, tree)
    return found


def part_of(one: Thing, surface: Surface) -> str:
    """Return the part of an object that a surface is, as certificates call it."""
    shape = one.shape
    if not surface.round:
        return "right" if surface.sign > 0.0 else "left"
    if one.kind == DISC:
        return "disc"
    if one.kind == ARC and (surface.x, surface.y) == (shape["x"], shape["y"]):
        return "outer" if surface.sign > 0.0 else "inner"
    if one.kind == ARC:
        angles = shape["start"], shape["stop"]
        ends = [(shape["x"] + shape["radius"] * np.cos(a), shape["y"] + shape["radius"] * np.sin(a)) for a in angles]
    else:
        ends = [(shape["x1"], shape["y1"]), (shape["x2"], shape["y2"])]
    start, stop = (hypot(x - surface.x, y - surface.y) for x, y in ends)
    return "start" if start < stop else "stop"


def _proof(orbit: BounceOrbit, data: dict[str, Any]) -> tuple[dict[str, Any], list[dict[str, str]]]:
    n = orbit.period
    guess = [float(x) for x in (*orbit.along, *orbit.durations)]
    data |= {"centre": [], "radius": [], "unique": [], "preconditioner": [], "claims": {}}
    table = Table(data)
    units = [1.0 if surface.round else float(surface.length) for surface in table.word] + [orbit.time / n] * n
    units = [2.0 ** (frexp(unit)[1] - 1) for unit in units]
    C = _inverse(table, [arb(x) for x in guess])
    centre = _centre(table, C, guess, units)
    radius = [arb(2) ** ORBIT * unit for unit in units]
    unique = _unique(table, C, centre, units)
    box = box_of(centre, radius)
    frames = table.frames(box)
    speeds = table.speeds(box, frames)
    sums = sums_of(turned(table, frames, speeds, box), table.energy is not None)
    quantities = margins(sums)
    outside = [name for name, x in quantities.items() if x < 0]
    inside = table.energy is None and all(x > 0 for x in quantities.values())
    incoming = [
        normal[0] * speeds[i - 1][1][0] + normal[1] * speeds[i - 1][1][1] for i, (_p, normal, _m) in enumerate(frames)
    ]
    data |= {
        "centre": [exact_text(x) for x in centre],
        "radius": [exact_text(x) for x in radius],
        "unique": [exact_text(x) for x in unique],
        "preconditioner": [[x.hex() for x in row] for row in C],
        "claims": {
            "box": [enclosed(x) for x in box],
            "apart": [below(u - r, 3) for u, r in zip(unique, radius, strict=True)],
            "least_period": True,
            "time": loose(sum(box[n:], arb(0))),
            "incoming": [loose(v) for v in incoming],
            "sums": [loose(x) for x in sums],
            "stability": "unstable" if outside else "stable" if inside else "undecided",
        },
    }
    writer = TableWriter()
    writer.name = outside[0] if outside else ""
    table_rows(data, writer)
    return data, writer.rows


def _inverse(table: Table, x: list[arb]) -> list[list[float]]:
    rows = np.array([[float(entry) for entry in row] for row in table.derivative(x)])
    try:
        found = np.linalg.inv(rows)
    except np.linalg.LinAlgError:
        raise NotProven("the equations of the orbit are singular: two orbits meet, or it is one of a family") from None
    return [[float(entry) for entry in row] for row in found]


def _centre(table: Table, C: list[list[float]], guess: list[float], units: list[float]) -> list[arb]:
    """Return the zero near a guess to many bits."""
    x, small = [arb(one) for one in guess], arb(2) ** (ORBIT - 20)
    for _ in range(STEPS):
        F = table.defect(x)
        moves = [sum((arb(c) * f for c, f in zip(row, F, strict=True)), arb(0)).mid() for row in C]
        x = [short(a - move, MIDDLE) for a, move in zip(x, moves, strict=True)]
        if all(abs(move) < small * unit for move, unit in zip(moves, units, strict=True)):
            break
    else:
        raise NotProven(f"Newton's method does not converge from the places and times given: {guess}")
    if any(abs(a - arb(b)) > arb(1e-4) * unit for a, b, unit in zip(x, guess, units, strict=True)):
        raise NotProven("Newton's method went from the places and times given to another orbit")
    return x


def _unique(table: Table, C: list[list[float]], centre: list[arb], units: list[float]) -> list[arb]:
    """Return the half-widths of the widest box on which steps contract to a half."""
    factors = [[arb(c) for c in row] for row in C]
    for power in range(WIDEST, NARROWEST, -3):
        unique = [arb(2) ** power * unit for unit in units]
        try:
            D = table.derivative(box_of(centre, unique))
            rates = [a / b for a, b in zip(spread(factors, D, unique), unique, strict=True)]
        except Rejected:
            continue
        if all(rate.is_finite() and rate < 0.5 for rate in rates):
            return unique
    raise NotProven("the orbit is not proven to be alone in any box: two orbits may be very near each other")
