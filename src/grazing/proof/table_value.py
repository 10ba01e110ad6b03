"""Proven enclosures of the parameter values at which an orbit on a table bifurcates: the finder.

What the checker demands of the curve, its ends and the dip is in grazing_checker/table_value.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot, inf
from typing import Any, NamedTuple

import numpy as np
from flint import arb

from grazing.billiard.objects import Thing
from grazing.orbits.bounce_orbit import BounceOrbit
from grazing.oscillator.sure import Undecided
from grazing.outcome import InputError, shown
from grazing.parameter import checked_name, named_by
from grazing.pool import LOCK
from grazing.proof.curve import enclosed_curve, end_of, units_of
from grazing.proof.expression import NotAnExpression
from grazing.proof.flow import Blurred
from grazing.proof.krawczyk import NoConvergence
from grazing.proof.reasons import SADDLE, NotProven, Open, Stage
from grazing.proof.search import Along
from grazing.proof.table import TableWriter, described
from grazing.proof.text import enclosed, exact_text, short
from grazing_checker import table_value as checker
from grazing_checker.balls import precision
from grazing_checker.plane import PARTS, Polynomial, dot, value
from grazing_checker.reading import Rejected
from grazing_checker.table import BITS, NUMBERS, Dip, Table

Point = list[arb]
#: So near, in sizes of the orbit, is a touch; and so far from it, as part of its time in the flight, another one.
TOUCH, AGAIN = 1e-12, 1e-6
#: Share of the parameter's size over which the change of heights is looked at.
AHEAD = 1e-6
#: The stretch of a dip is halved so often, beginning with a quarter of its flight.
HALVINGS = 60


class At(NamedTuple):
    """A point, and the table there, which depends on its last coordinate."""

    x: Point
    table: Table


class TableEquations:
    """The checker's equations of an orbit on a table, as the search along a curve of orbits asks for them."""

    def __init__(self, data: dict[str, Any], name: str, size: float) -> None:
        self.problem, self.parameter, self.length = checker.Problem(data), name, size
        self.name: str | None = name
        self.size = self.problem.size

    def flights(self, x: Point, _derivative: bool = False) -> At:
        """Return the table at the parameter of a point; Undecided where there surely is none."""
        try:
            return At(x, self.problem.legs(x, sensitive=True))
        except Rejected:
            raise Undecided from None

    def jacobian(self, at: At) -> list[list[arb]]:
        """Return the derivative of the residual by all coordinates."""
        try:
            return self.problem.derivative(*at)
        except Rejected:
            raise Undecided from None

    def residual(self, x: Point, _at: At) -> list[arb]:
        """Return the left-hand sides, 0 at an orbit."""
        try:
            return self.problem.defect(x, self.problem.legs(x))
        except Rejected:
            raise Undecided from None

    def ordered(self, x: Point) -> bool:
        """Return whether all flights surely take time, and there is such a table."""
        try:
            self.problem.legs(x)
        except Rejected:
            return False
        return all(t > 0 for t in x[self.size // 2 : self.size])

    def scales(self, x: Point, _at: At) -> list[arb]:
        """Return the size of each coordinate: of angles 1, of places that of the word, of times their mean."""
        n = self.size // 2
        mean = sum((abs(t) for t in x[n : self.size]), arb(0)).mid() / n
        table = self.problem.legs([one.mid() for one in x])
        return [arb(1) if surface.round else arb(self.length) for surface in table.word] + [mean] * n

    def unit(self, x: Point) -> float:
        """Return the size of the parameter: its own, or for 0 one that is made of lengths and times."""
        of, kind = self.problem.data["parameter"]["of"], self.parameter.rpartition(".")[2]
        time = float(self.scales(x, self.flights(x))[-1])
        if kind in ("tilt", "start", "stop"):
            return 1.0
        if kind == "g" and of == checker.PLANE:
            return float(abs(x[-1])) or self.length / time**2
        return float(abs(x[-1])) or (self.length / time if of.startswith("law of ") else self.length)

    def sums(self, x: Point, _at: At) -> list[arb]:
        """Return the sums of the multipliers."""
        try:
            return checker.end_sums(x[: self.size], self.problem.legs(x))
        except Rejected:
            raise Undecided from None


class Low(NamedTuple):
    """A local minimum of the height of a flight above a part of an object."""

    flight: int
    thing: int
    part: str
    time: arb
    height: arb
    distance: float


class TableSearch(Along):
    """Finds a bifurcation of an orbit on a table."""

    equations: TableEquations

    def __init__(self, equations: TableEquations, kind: str, start: Point) -> None:
        self.low: Low | None = None
        super().__init__(equations, kind, start)

    def test(self, x: Point) -> arb:
        """Return the test function at an orbit."""
        if self.kind != "gr":
            return checker.tested(self.equations.sums(x, self.equations.flights(x)), self.kind)[1].mid()
        was, table = self.low, self.equations.problem.legs(x)
        lows = list(lows_of(table, x[: self.equations.size]))
        if was is None:
            if not lows:
                raise NotProven("no flight of the orbit comes near to an object that it might touch")
            self.low = self._next(x, lows)
        else:
            same = [one for one in lows if one[:3] == was[:3]]
            if not same:
                raise NotProven("the dip that was to touch an object vanishes; give an orbit nearer to the graze")
            self.low = min(same, key=lambda one: abs(float(one.time - was.time)))
        return self.low.height

    def _next(self, x: Point, lows: list[Low]) -> Low:
        """Return the dip that touches, or will first along the parameter as the heights change there."""
        touching = [one for one in lows if abs(one.distance) < TOUCH * self.equations.length]
        if touching:
            return touching[0]
        ahead = self._guess(x, self._tangent(x), arb(AHEAD * self.unit(x)))
        then = list(lows_of(self.equations.problem.legs(ahead), ahead[: self.equations.size]))

        def way(one: Low) -> float:
            same = [two for two in then if two[:3] == one[:3]]
            if not same:
                return inf
            moved = min(same, key=lambda two: abs(float(two.time - one.time))).height - one.height
            return abs(float(one.height)) / abs(float(moved)) if moved != 0 else inf

        return min(lows, key=lambda one: (way(one), abs(one.distance)))


def lows_of(table: Table, x: Point) -> Iterator[Low]:
    """Yield the local minima of the heights of all flights above the parts of objects, where they may touch them."""
    for i, flight in enumerate(table.flights(x)):
        long = float(flight.t)
        for k, thing in enumerate(table.things):
            for part in PARTS[thing.kind]:
                try:
                    surface = thing.surface(part)
                except Rejected:  # a ball without a radius meets no end
                    continue
                h = flight.height(surface)
                for time in _lowest(h, long):
                    p = flight.place(time)
                    u = _foot(thing, p)
                    on, height = thing.on(part, u, p), value(h, time).mid()
                    own = (i, k) in ((i, table.hits[i][0]), (i, table.hits[(i + 1) % table.n][0]))
                    if not on > 0 or (own and min(float(time), long - float(time)) < 1e-6 * long):
                        continue
                    d = p[0] - surface.at[0], p[1] - surface.at[1]
                    distance = float(height) / (float(dot(d, d).sqrt()) + float(surface.size) if surface.round else 1.0)
                    yield Low(i, k, part, time, height, distance)


def _foot(thing: Any, p: tuple[arb, arb]) -> arb:
    if thing.kind != "segment":
        return arb(0)
    return dot(thing.e, (p[0] - thing.ends[0][0], p[1] - thing.ends[0][1])).mid()


def _lowest(h: Polynomial, long: float) -> list[arb]:
    """Return the times inside a flight at which a polynomial is lowest near by: roots of its derivative, polished."""
    slope = [k * c for k, c in enumerate(h)][1:]
    bend = [k * c for k, c in enumerate(slope)][1:]
    found = []
    for root in np.roots([float(c) for c in reversed(slope)] if len(slope) > 1 else []):
        if abs(root.imag) > 1e-9 * long or not 0.0 < root.real < long:
            continue
        s = arb(float(root.real))
        for _ in range(9):
            s = (s - value(slope, s) / value(bend, s)).mid()
            if not s.is_finite():
                break
        if s.is_finite() and value(bend, s) > 0 and 0 < s < long:
            found.append(s)
    return found


def prove_table_value(orbit: BounceOrbit, kind: str, name: str) -> tuple[dict[str, Any], list[dict[str, str]]]:
    """Return data and inequalities of the certificate of a bifurcation on a table, or raise NotProven."""
    table = orbit.map.origin.impacts_on
    if not isinstance(kind, str) or kind not in (*checker.EVENTS, "gr"):
        raise InputError(f"kind is {shown(kind)}; allowed are {', '.join((*checker.EVENTS, 'gr'))}")
    name, *others = named_by(checked_name(name, table.params, "the table"), table.params)
    if others:
        raise InputError(f"{name.rpartition('.')[2]} stands for {' and '.join([name, *others])}; name one of them")
    with LOCK, precision(BITS):
        try:
            data = {**described(orbit), **unknown(orbit, name)}
            start = [arb(float(x)) for x in (*orbit.along, *orbit.durations, table.params[name])]
            _clear(data, name)
            checker.Problem(data).legs(start)  # says which name of an object or which law is none
            (xs, ys) = orbit.corners.T
            size = hypot(float(np.ptp(xs)), float(np.ptp(ys))) or float(np.abs(orbit.corners).max()) or 1.0
            return _proof(TableEquations(data, name, size), data, kind, start)
        except (Rejected, Open) as error:
            raise NotProven(str(error)) from None
        except Undecided:
            raise NotProven("the equations of the orbit are not decided near it; give another orbit") from None
        except NoConvergence:
            raise NotProven("Newton's method does not converge at an end of the curve; give another orbit") from None
        except Blurred:
            raise NotProven(
                f"{BITS} bits do not follow the orbit towards the bifurcation; give one nearer to it"
            ) from None
        except NotAnExpression as error:
            raise NotProven(
                f"a reset law cannot be written as an expression ({error}); write it with arithmetic, comparisons and "
                "abs of its arguments only"
            ) from None


def unknown(orbit: BounceOrbit, name: str) -> dict[str, Any]:
    """Return whose parameter a name is, as certificates call it."""
    front, _dot, own = name.rpartition(".")
    if not front:
        return {"parameter": {"of": checker.PLANE, "name": own}}
    thing: Thing = next(one for one in orbit.map.origin.impacts_on.objects if one.name == front)
    return {"parameter": {"of": front if own in thing.shape else f"law of {front}", "name": own}}


def _clear(data: dict[str, Any], name: str) -> None:
    """Take the value of the parameter out of the data of a certificate."""
    front, _dot, own = name.rpartition(".")
    if own in NUMBERS and not front:
        data[own] = None
    for one in data["objects"]:
        if one["name"] == front:
            part = one["shape"] if own in one["shape"] else one["law"]["parameters"]
            part[own] = None


def _proof(
    equations: TableEquations, data: dict[str, Any], kind: str, start: Point
) -> tuple[dict[str, Any], list[dict[str, str]]]:
    with Stage("the orbit near the bifurcation is singular"):
        search = TableSearch(equations, kind, start)
        centre = search.zero()
        _one_touch(equations, search, centre)
        if kind == "ns" and checker.discriminant(equations.sums(centre, equations.flights(centre))) > 0:
            raise NotProven(SADDLE)
    centre, pinned = [short(x, BITS // 2) for x in centre], search.pinned
    units = units_of(equations, centre)
    centre[pinned] = (
        short(centre[pinned] + units[pinned], BITS // 2) - units[pinned]
    )  # the ends, beside, are then exact
    with Stage("the curve of orbits through the bifurcation is not enclosed"):
        C, radius, rows = enclosed_curve(equations, centre, units, pinned, BITS)
        ends = [end_of(equations, centre, radius, C, rows, pinned, sign, BITS) for sign in (-1, 1)]
    box = [x + arb(0, 1) * r for x, r in zip(centre, radius, strict=True)]
    data |= {
        "type": kind,
        "pinned": pinned,
        "centre": [exact_text(x) for x in centre],
        "radius": [exact_text(x) for x in radius],
        "preconditioner": [[x.hex() for x in row] for row in C],
        "dip": {} if search.low is None else dip_text(equations, search.low, box),
        "ends": [
            {"centre": [exact_text(x) for x in end.centre], "radius": [exact_text(x) for x in end.radius]}
            for end in ends
        ],
        "claims": {
            "value": enclosed(box[equations.size], 24),
            "box": [enclosed(x) for x in box[: equations.size]],
            "ends": [checker.stability(end.sums) for end in ends],
        },
    }
    writer = TableWriter()
    checker.value_rows(data, writer)
    return data, writer.rows


def _one_touch(equations: TableEquations, search: TableSearch, x: Point) -> None:
    """Raise NotProven where an object is touched at another time as well: on an orbit that comes back as it went."""
    found = search.low
    if found is None:
        return
    for low in lows_of(equations.problem.legs(x), x[: equations.size]):
        again = low[:3] != found[:3] or abs(float(low.time - found.time)) > AGAIN * float(found.time)
        if again and abs(low.distance) < TOUCH * equations.length:
            first, last = sorted((found.flight + 1, low.flight + 1))
            both = f"flights after impacts {first} and {last} touch"
            once = f"flight after impact {first} touches twice"
            raise NotProven(
                f"the {both if first != last else once} at once, as on an orbit that comes back the way it went; one "
                "touch alone is proven"
            )


def dip_text(equations: TableEquations, low: Low, box: Point) -> dict[str, Any]:
    """Return the dip that touches, as text: the longest stretch tried for which the checker's conditions hold."""
    table, x = equations.problem.legs(box), box[: equations.size]
    time = short(low.time, 128)
    reach = table.flights(x)[low.flight].t.mid()
    for k in range(2, HALVINGS):
        half = short(reach * arb(2) ** -k, 24)
        dip = Dip(low.flight, low.thing, low.part, time - half, time + half, time)
        try:
            checker.touching(table, x, dip, TableWriter())
            checker.curvature(table, x, dip, TableWriter())
        except Rejected:
            continue
        return {
            "flight": low.flight + 1,
            "object": table.things[low.thing].name,
            "part": low.part,
            "from": exact_text(dip.start),
            "to": exact_text(dip.stop),
            "time": exact_text(dip.time),
        }
    raise NotProven("the dip is too flat, or too near to an end of its flight or of its part, to be told from others")
