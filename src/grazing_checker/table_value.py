"""Check the certificate of a bifurcation value of an orbit of a ball on a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grazing_checker.balls import Ball, around, number, precision
from grazing_checker.gradient import Gradient, derivative_of, variables
from grazing_checker.oscillator import Point, Rows
from grazing_checker.plane import Flight, Polynomial, dot, over, value
from grazing_checker.reading import Inequalities, decimal, demand, exact, keys, quoted, whole, within
from grazing_checker.sentence import STABILITY as SHORT
from grazing_checker.table import (
    BITS,
    MEANING,
    NUMBERS,
    OUTSIDE,
    Dip,
    Table,
    bounces,
    box_text,
    coordinates,
    energy_text,
    hits_text,
    impacts_text,
    margins,
    part_text,
    sums_of,
    table_text,
    turned,
)
from grazing_checker.value import Curve, least_height

KEYS = (
    "objects", "rho", "g", "tilt", "impacts", "energy", "parameter", "type", "pinned", "centre", "radius",
    "preconditioner", "dip", "ends", "claims",
)  # fmt: skip
CLAIMS = ("value", "box", "ends")
#: Whose parameters rho, g and tilt are; no object can be called so.
PLANE = "the table"
OPPOSITE = "has opposite signs at the ends of the curve"
EVENTS = {
    "pd": f"a multiplier {OUTSIDE} is -1 (as at a period doubling), and the product of 1 + L over its multipliers L "
    f"{OPPOSITE}",
    "lp": f"a multiplier {OUTSIDE} is +1 (as at a fold), and the product of 1 - L over its multipliers L {OPPOSITE}",
    "ns": f"a pair of complex multipliers {OUTSIDE} is on the unit circle (as at a Neimark-Sacker bifurcation), and "
    f"the product of 1 - L L' over pairs of its multipliers {OPPOSITE}",
}


def check_table_value(data: Mapping[str, Any], inequalities: Any) -> str:
    """Verify a certificate of a bifurcation value on a table and return the sentence that it proves, or raise Rejected.

    The equations are those of :func:`grazing_checker.table.check_table_orbit`, with one parameter as a further unknown.
    What is proven, and where each hypothesis is demanded:

    1. A curve of solutions, one for each value of the pinned coordinate, that depends continuously on it, and two small
       boxes that hold its ends (:class:`grazing_checker.value.Curve`).
    2. All of the curve are motions, but for the dip of a graze (:func:`grazing_checker.table.bounces`); every parameter
       is in its range over the box (:class:`grazing_checker.table.Table`).
    3. A quantity that is continuous along the curve has opposite signs at its ends, so it is 0 between
       (:func:`_change_of_sign`). That it is 0 once only is not claimed.
    """
    with precision(BITS):
        rows = Inequalities(inequalities)
        value_rows(data, rows)
        rows.finish()
    return table_value_sentence(data)


class Problem:
    """The equations of a certificate; the last coordinate of a point is the parameter."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.data, self.size = data, 2 * len(data["impacts"])

    def legs(self, x: Point, sensitive: bool = False) -> Table:
        """Return the table at the parameter of a point, which may depend on it: ``sensitive``.

        It is not beyond the doubles, of which :meth:`grazing_checker.plane.Thing.elastic` takes all numbers to be.
        """
        demand(abs(x[self.size]) < number(1, 1024), "the parameter is larger than all doubles")
        return Table(self.data, Gradient(x[self.size], {self.size: number(1)}) if sensitive else x[self.size])

    def defect(self, x: Point, table: Table) -> Point:
        """Return F."""
        F: Point = table.defect(x[: self.size])
        return F

    def derivative(self, x: Point, table: Table) -> Rows:
        """Return the derivative of F by all coordinates over a box, of a sensitive table."""
        return derivative_of(table.defect(list(variables(x[: self.size]))), self.size + 1)


def value_rows(data: Mapping[str, Any], rows: Any) -> None:
    """Verify a certificate's data; inequalities are taken from ``rows``, or written by what stands in its place."""
    keys(data, KEYS, "the data")
    keys(data["claims"], CLAIMS, "the claims")
    kind = data["type"]
    demand(isinstance(kind, str) and kind in (*EVENTS, "gr"), f"the type of bifurcation is {quoted(kind)}")
    _unknown(data)
    demand(isinstance(data["impacts"], list), "the impacts are no list")
    problem = Problem(data)
    curve = Curve(problem, data, rows)
    box, table = curve.box[: problem.size], problem.legs(curve.box)
    dip = _dip(data, table)
    bounces(table, box, rows, dip)
    ends = [curve.end(data["ends"][i], i, rows) for i in range(2)]
    found = [end_sums(x[: problem.size], at) for x, at in ends]
    demand(kind != "lp" or curve.pinned < problem.size, "a fold is no curve over its parameter")
    if dip is not None:
        touching(table, box, dip, rows)
        bend = curvature(table, box, dip, rows)
        name, values = "distance in the dip", [height(at, x[: problem.size], dip, bend) for x, at in ends]
    else:
        name, _sign = tested(found[0], kind)
        values = [tested(sums, kind)[1] for sums in found]
    _change_of_sign(name, values, rows)
    if kind == "ns":
        rows.less("discriminant of the multipliers", discriminant(end_sums(box, table)))
    _claims(data, curve, found)


def _unknown(data: Mapping[str, Any]) -> None:
    """Demand that the parameter has no value; that none besides lacks one is demanded where they are read."""
    keys(data["parameter"], ("of", "name"), "the parameter")
    of, name, values = data["parameter"]["of"], data["parameter"]["name"], None
    demand(isinstance(of, str) and isinstance(name, str), "no parameter is unknown")
    if of == PLANE:
        values = {key: data[key] for key in NUMBERS}
    objects = data["objects"] if isinstance(data["objects"], list) else []
    for one in objects:
        known = isinstance(one, Mapping) and isinstance(one.get("name"), str)
        if known and of == one["name"]:
            values = one.get("shape")
        if known and of == f"law of {one['name']}" and isinstance(one.get("law"), Mapping):
            values = one["law"].get("parameters")
    demand(isinstance(values, Mapping) and name in values, "the parameter that is unknown does not exist")
    assert values is not None
    demand(values[name] is None, "the parameter that is unknown has a value")


def _dip(data: Mapping[str, Any], table: Table) -> Dip | None:
    """Return the dip that touches a part of an object; None where none should."""
    if data["type"] != "gr":
        demand(data["dip"] == {}, "there is a dip in a certificate that needs none")
        return None
    dip, names = data["dip"], [one.name for one in table.things]
    keys(dip, ("flight", "object", "part", "from", "to", "time"), "the dip")
    flight = whole(dip["flight"], 1, "the flight of the dip")
    demand(flight <= table.n, "no such flight")
    demand(isinstance(dip["object"], str) and dip["object"] in names, "a dip is at no object")
    thing = names.index(dip["object"])
    table.things[thing].surface(dip["part"])  # it has such a part
    return Dip(flight - 1, thing, dip["part"], *(exact(dip[name]) for name in ("from", "to", "time")))


def _path(table: Table, x: Point, dip: Dip) -> tuple[Flight, Polynomial]:
    """Return the flight of a dip, and its height above the part."""
    flight = table.flights(x)[dip.flight]
    return flight, flight.height(table.things[dip.thing].surface(dip.part))


def touching(table: Table, box: Point, dip: Dip, rows: Any) -> None:
    """Verify that a ball which is at the part within the stretch of the dip touches it, and is off it at its ends.

    Demanded, over the whole curve: the stretch lies inside its flight; the place is one of a contact with the part all
    along it; the height is > 0 at both ends.
    """
    flight, h = _path(table, box, dip)
    demand(number(0) < dip.start and dip.start < dip.time, "the dip is not looked at where it is")
    demand(dip.time < dip.stop and dip.stop < flight.t, "the dip is not looked at where it is")
    thing, middle = table.things[dip.thing], (dip.start + dip.stop) / 2
    p = flight.place(around(middle, (dip.stop - dip.start).upper() / 2))
    u = dot(thing.e, (p[0] - thing.ends[0][0], p[1] - thing.ends[0][1])) if thing.kind == "segment" else number(0)
    rows.more("place of the dip on its part", thing.on(dip.part, u, p))
    rows.more("distance before the dip", value(h, dip.start))
    rows.more("distance after the dip", value(h, dip.stop))


def curvature(table: Table, box: Point, dip: Dip, rows: Any) -> Ball:
    """Verify that the height has a second derivative > b > 0 in the dip, over the whole curve, and return b."""
    _flight, h = _path(table, box, dip)
    twice = [k * (k - 1) * c for k, c in enumerate(h)][2:]
    b = over(twice, around((dip.start + dip.stop) / 2, (dip.stop - dip.start).upper() / 2))
    rows.more("curvature of the distance in the dip", b)
    return b


def height(table: Table, x: Point, dip: Dip, bend: Ball) -> Ball:
    """Return a bound on the least height h of the dip (:func:`grazing_checker.value.least_height`).

    With h'' > b > 0 on the stretch there is one lowest point, which depends continuously on the orbit; where its height
    is 0 it is not at an end of the stretch, as h > 0 there: h' = 0, a touch.
    """
    _flight, h = _path(table, x, dip)
    return least_height(value(h, dip.time), value([k * c for k, c in enumerate(h)][1:], dip.time), bend)


def end_sums(x: Point, table: Table) -> list[Ball]:
    """Return the sums of the multipliers of an orbit."""
    frames = table.frames(x)
    return sums_of(turned(table, frames, table.speeds(x, frames), x), table.energy is not None)


def tested(sums: list[Ball], kind: str) -> tuple[str, Ball]:
    """Return the quantity that changes its sign, and what it is called.

    The product of 1 + L is 0 exactly if a multiplier is -1, that of 1 - L if one is +1. The product of 1 - L L' over
    the three pairs is 1 - c^2 - (b - a c).
    Where energy is conserved L and 1/L are left: (1 + L)(1 + 1/L) = 2 + (L + 1/L).
    """
    if len(sums) == 1:
        demand(kind != "ns", "where energy is conserved multipliers stay on the unit circle")
        return ("2 + (L + 1/L)", 2 + sums[0]) if kind == "pd" else ("2 - (L + 1/L)", 2 - sums[0])
    name = {"pd": "product of 1 + L", "lp": "product of 1 - L"}.get(kind, "1 - c^2 - (b - a c)")
    return name, margins(sums)[name]


def discriminant(sums: list[Ball]) -> Ball:
    """Return what is < 0 exactly if one multiplier is real and two are complex: of x^3 - a x^2 + b x - c.

    Then 1 - L L' is 0 for the complex pair only: the product of the real one, if it is not 0, and another is not real.
    So that pair is on the unit circle.
    """
    a, b, c = sums
    return a * a * b * b - 4 * b * b * b - 4 * a * a * a * c + 18 * a * b * c - 27 * c * c


def _change_of_sign(name: str, values: list[Ball], rows: Any) -> None:
    """Verify that a test function has opposite signs at the ends of the curve."""
    one, two = values
    demand((one > 0 and two < 0) or (one < 0 and two > 0), f"{name} does not surely change its sign")
    for i, x in enumerate(values):
        (rows.more if x > 0 else rows.less)(f"{name} at end {i + 1}", x)


def _claims(data: Mapping[str, Any], curve: Curve, found: list[list[Ball]]) -> None:
    """Verify the value, the box and the stability that are claimed."""
    claims, size = data["claims"], len(curve.box) - 1
    within(curve.box[size], claims["value"], "the value")
    demand(decimal(claims["value"][0]) < decimal(claims["value"][1]), "the value is claimed without a width")
    demand(isinstance(claims["box"], list) and len(claims["box"]) == size, "the box claimed has the wrong size")
    for i, x in enumerate(curve.box[:size]):
        within(x, claims["box"][i], f"coordinate {i + 1}")
    demand(isinstance(claims["ends"], list) and len(claims["ends"]) == 2, "the stability is not claimed at two ends")
    for i, sums in enumerate(found):
        held = claims["ends"][i] in ("undecided", stability(sums))
        demand(held, f"the orbit at end {i + 1} is not proven {quoted(claims['ends'][i])}")


def stability(sums: list[Ball]) -> str:
    """Return what is known of the stability of an orbit."""
    quantities = margins(sums).values()
    if len(sums) > 1 and all(x > 0 for x in quantities):
        return "stable"
    return "unstable" if any(x < 0 for x in quantities) else "undecided"


def parameter_text(data: Mapping[str, Any]) -> str:
    """Return the parameter that is unknown in words."""
    of, name = data["parameter"]["of"], data["parameter"]["name"]
    if of == PLANE:
        return str(name)
    return f'p.{name} of "{of[7:]}"' if of.startswith("law of ") else f'{name} of "{of}"'


def table_value_sentence(data: Mapping[str, Any]) -> str:
    """Return the sentence of a certificate of a bifurcation value on a table."""
    claims, name, dip = data["claims"], parameter_text(data), data["dip"]
    low, high = claims["value"]
    ends = [SHORT[one].partition(":")[0] for one in claims["ends"]]
    along = [*coordinates(len(data["impacts"])), name][data["pinned"]]
    if data["type"] == "gr":
        event = (
            f"the ball touches {part_text((dip['object'], dip['part']))} on the flight after impact {dip['flight']} "
            "(graze), which is off it at one end of the curve and would pass through it at the other"
        )
        rest = ", but for that dip, in which they are continued as if it were not there"
    else:
        event = EVENTS[data["type"]]
        if data["energy"] is not None:  # across all energies one multiplier more is 1, and a product with it 0
            event = event.replace(OUTSIDE, f"{OUTSIDE} at this energy")
        rest = f"; of the orbit at the first end of the curve: {ends[0]}, at the second: {ends[1]}"
    return (
        f"For {table_text(data)}; all parameters and the numbers in the laws taken as these exact doubles, there is a "
        f"value of {name} in [{low}, {high}] at which, for a periodic orbit{energy_text(data)} of {impacts_text(data)} "
        f"that hits {hits_text(data)} with {box_text(data)}, {event}; {MEANING}; the curve is one of such orbits in "
        f"that box, along which {along} grows, and they meet nothing else{rest}."
    )
