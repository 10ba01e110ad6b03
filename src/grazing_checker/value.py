"""Check the certificate of a bifurcation value of the oscillator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from grazing_checker.balls import Ball, precision
from grazing_checker.flight import exceeds
from grazing_checker.oscillator import (
    Dip,
    Leg,
    Point,
    Problem,
    Rows,
    applied,
    box_of,
    check_flights,
    inside,
    margins,
    precision_of,
    preconditioner,
    spread,
)
from grazing_checker.reading import Inequalities, decimal, demand, exact, keys, numbers, quoted, whole, within
from grazing_checker.sentence import EVENTS, value_sentence

KEYS = (
    "model", "impacts", "periods", "precision", "parameter", "type", "pinned", "centre", "radius",
    "preconditioner", "cuts", "dip", "ends", "claims",
)  # fmt: skip
CLAIMS = ("value", "box", "ends")
#: The quantity that changes its sign.
TESTED = {"pd": "1 + trace + det", "lp": "1 - trace + det", "ns": "1 - det"}


def check_value(data: Mapping[str, Any], inequalities: list[Any]) -> str:
    """Verify a certificate of a bifurcation value and return the sentence that it proves, or raise Rejected.

    What is proven, and where each hypothesis is demanded:

    1. A curve of solutions, one for each value of the pinned coordinate, that depends continuously on it
       (:class:`Curve`), and two small boxes that hold its ends (:meth:`Curve.end`).
    2. All of the curve are motions, but for the dip of a graze (:func:`grazing_checker.oscillator.check_flights`);
       every parameter is in its range over the box (:class:`Problem`).
    3. A quantity that is continuous along the curve has opposite signs at its ends, so it is 0 between
       (:func:`_change_of_sign`). That it is 0 once only is not claimed.
    """
    keys(data, (*KEYS, "law"), "the data")
    return _checked(data, inequalities)


def check_walled_value(data: Mapping[str, Any], inequalities: list[Any]) -> str:
    """Verify a certificate of a bifurcation value with walls of its own: :func:`check_value` with a list of walls."""
    keys(data, (*KEYS, "walls"), "the data")
    return _checked(data, inequalities)


def _checked(data: Mapping[str, Any], inequalities: list[Any]) -> str:
    keys(data["claims"], CLAIMS, "the claims")
    demand(
        isinstance(data["type"], str) and data["type"] in EVENTS, f"the type of bifurcation is {quoted(data['type'])}"
    )
    keys(data["parameter"], ("of", "name"), "the parameter")
    unknown = data["parameter"]["of"], data["parameter"]["name"]
    demand(all(isinstance(one, str) for one in unknown), "no parameter is unknown")
    with precision(precision_of(data)):
        problem = Problem(data, unknown)
        demand(problem.n > 0 or data["type"] == "gr", "an orbit without impacts has a graze only")
        rows = Inequalities(inequalities)
        curve = Curve(problem, data, rows)
        dip = _dip(data, problem)
        check_flights(problem, curve.box, curve.legs, data["cuts"], rows, dip)
        ends = [curve.end(data["ends"][i], i, rows) for i in range(2)]
        _change_of_sign(problem, data, curve, ends, dip, rows)
        _claims(problem, data, curve, ends)
        rows.finish()
    return value_sentence(data)


class Equations(Protocol):
    """Equations of orbits F(x) = 0, ``size`` of them, in one coordinate more: a parameter, the last one."""

    size: int

    def legs(self, x: Point, sensitive: bool = False) -> Any:
        """Return what the others need of a point, also for derivatives by the parameter: ``sensitive``."""

    def defect(self, x: Point, legs: Any) -> Point:
        """Return F."""

    def derivative(self, x: Point, legs: Any) -> Rows:
        """Return the derivative of F by all coordinates."""


class Curve:
    """The curve of solutions through a box, one for every value of the pinned coordinate, verified when made.

    Krawczyk's theorem with a parameter s, the pinned coordinate, in [c_s - r_s, c_s + r_s]: let D and d hold the
    derivatives of F by the free coordinates x and by s over the whole box, u the half-widths of x, C any matrix. By the
    mean value theorem |C F(c_x, s)| <= |C F(c)| + |C d| r_s. If |C F(c)| + |C d| r_s + |I - C D| u < u in every row, x
    -> x - C F(x, s) takes the box into itself and contracts it by one factor for all s: it has exactly one fixed point
    for each s, which depends continuously on s; and C is regular, so that fixed points are zeros of F.

    Demanded: u > 0, r_s > 0, the inequalities strictly, the law smooth and the impacts in order on the box.
    """

    def __init__(self, problem: Equations, data: Mapping[str, Any], rows: Any) -> None:
        size = problem.size
        self.problem, self.pinned = problem, whole(data["pinned"], 0, "the pinned coordinate")
        demand(self.pinned <= size, "the pinned coordinate does not exist")
        self.centre, self.radius = (numbers(data[name], size + 1, name) for name in ("centre", "radius"))
        demand(all(r > 0 for r in self.radius), "a half-width is not positive")
        self.C = preconditioner(data["preconditioner"], size)
        self.box = box_of(self.centre, self.radius)
        self.legs = problem.legs(self.box, sensitive=True)
        D = problem.derivative(self.box, self.legs)
        self.D = [self.free(row) for row in D]
        u, texts = self.free(self.radius), self.free(data["radius"])
        ahead = applied(self.C, [row[self.pinned] for row in D])
        at = applied(self.C, problem.defect(self.centre, problem.legs(self.centre)))
        rest = spread(self.C, self.D, u)
        for i in range(size):
            x = at[i] + ahead[i] * self.radius[self.pinned] + rest[i]
            rows.less(f"curve, coordinate {i + 1}", x, texts[i])
        demand(isinstance(data["ends"], list) and len(data["ends"]) == 2, "the curve has not two ends")

    def free(self, row: list[Any]) -> list[Any]:
        """Return a row of coordinates without the pinned one."""
        return row[: self.pinned] + row[self.pinned + 1 :]

    def end(self, described: Any, i: int, rows: Any) -> tuple[Point, Any]:
        """Verify where the curve ends: a small box in the other that holds its solution at that end.

        With s at its end and 0 < r, |C F(c')| + |I - C D| r < r proves a solution in the box of half-widths r about c',
        if that box lies in the large one, where D holds. The large one has one solution at this s: it is the curve's.
        """
        problem = self.problem
        keys(described, ("centre", "radius"), f"end {i + 1}")
        centre, radius = (numbers(described[name], problem.size + 1, f"end {i + 1}") for name in ("centre", "radius"))
        at = self.centre[self.pinned] + (2 * i - 1) * self.radius[self.pinned]
        exactly = described["radius"][self.pinned] == "0x0p0"  # one text for 0, as in the schema
        demand(exactly and (centre[self.pinned] - at).is_zero(), f"end {i + 1} is not at the end")
        r = self.free(radius)
        demand(all(x > 0 for x in r), f"a half-width at end {i + 1} is not positive")
        moved = applied(self.C, problem.defect(centre, problem.legs(centre)))
        texts = self.free(described["radius"])
        for m, (a, b) in enumerate(zip(moved, spread(self.C, self.D, r), strict=True)):
            rows.less(f"end {i + 1}, coordinate {m + 1}", a + b, texts[m])
        box = box_of(centre, radius)
        demand(inside(self.free(box), self.free(self.box)), f"the box of end {i + 1} is not inside the other")
        return box, problem.legs(box)


def _dip(data: Mapping[str, Any], problem: Problem) -> Dip | None:
    """Return the dip that touches a wall; None where none should."""
    if data["type"] != "gr":
        demand(data["dip"] == {}, "there is a dip in a certificate that needs none")
        return None
    dip, names = data["dip"], [wall.name for wall in problem.walls]
    named = ("wall",) if "walls" in data else ()
    keys(dip, ("flight", "from", "to", "time", *named), "the dip")
    flight = whole(dip["flight"], 1, "the flight of the dip")
    demand(flight <= max(problem.n, 1), "no such flight")
    demand(not named or (isinstance(dip["wall"], str) and dip["wall"] in names), "no such wall")
    wall = names.index(dip["wall"]) if named else 0
    return Dip(flight - 1, wall, *(exact(dip[name]) for name in ("from", "to", "time")))


def _change_of_sign(
    problem: Problem, data: Mapping[str, Any], curve: Curve, ends: list[tuple[Point, list[Leg]]],
    dip: Dip | None, rows: Inequalities,
) -> None:  # fmt: skip
    """Verify that the test function has opposite signs at the ends of the curve.

    1 + tr + det = 0 is a multiplier -1 and 1 - tr + det = 0 a multiplier +1. 1 - det = 0 is a pair on the unit circle
    if it is complex: tr^2/4 < det is demanded of the whole curve. The lowest height of a dip (:func:`_heights`) is 0
    where the dip touches the wall: not at an end of its stretch, as y > 0 there, but inside, with v = 0.

    At a fold the derivative by the orbit's own coordinates is singular, so the parameter cannot be the pinned one.
    """
    demand(data["type"] != "lp" or curve.pinned < problem.size, "a fold is no curve over its parameter")
    if dip is not None:
        values, name = _heights(problem, curve, ends, dip, rows), "height of the dip"
    else:
        name = TESTED[data["type"]]
        values = [margins(*problem.trace_and_det(*end))[name] for end in ends]
    one, two = values
    demand((one > 0 and two < 0) or (one < 0 and two > 0), f"{name} does not surely change its sign")
    for i, x in enumerate(values):
        (rows.more if x > 0 else rows.less)(f"{name} at end {i + 1}", x)
    if data["type"] == "ns":
        trace, det = problem.trace_and_det(curve.box, curve.legs)
        rows.less("trace^2/4 - det", trace * trace / 4 - det)


def _heights(
    problem: Problem, curve: Curve, ends: list[tuple[Point, list[Leg]]], dip: Dip, rows: Inequalities
) -> list[Ball]:
    """Return bounds on the least height of the dip at both ends (:func:`least_height`).

    Demanded: the time s inside the stretch, the stretch inside its flight (``check_flights``), y'' > b > 0 over the
    whole curve, so that there is one lowest point, which depends continuously on the orbit.
    """
    demand(dip.start < dip.time and dip.time < dip.stop, "the dip is not looked at where it is")
    b = rows.left("acceleration in the dip", ">")
    path = problem.seen(curve.box, curve.legs[dip.flight], dip.wall)
    demand(b > 0 and exceeds(path, dip.start, dip.stop, 2, b), "the acceleration in the dip is not proven")
    heights = []
    for box, legs in ends:
        path = problem.seen(box, legs[dip.flight], dip.wall)
        heights.append(least_height(path.at(dip.time), path.at(dip.time, 1), b))
    return heights


def least_height(y: Ball, v: Ball, b: Ball) -> Ball:
    """Return a bound on the least height of a dip: from below where it is surely positive, from above where negative.

    With y'' > b > 0 on the stretch, y is at least y(s) - v(s)^2/(2 b) there, for any s in it, and at most y(s) at its
    lowest. Demanded: one of the two shows a sign. Far from the lowest point y(s) > 0 does not, nor a bound < 0.
    """
    least = y - v * v / (2 * b)
    demand(least > 0 or y < 0, "the height of the dip does not surely change its sign: at an end it has none")
    return least if least > 0 else y


def _claims(problem: Problem, data: Mapping[str, Any], curve: Curve, ends: list[tuple[Point, list[Leg]]]) -> None:
    """Verify the value, the box and the stability that are claimed."""
    claims, size = data["claims"], problem.size
    within(curve.box[size], claims["value"], "the value")
    demand(decimal(claims["value"][0]) < decimal(claims["value"][1]), "the value is claimed without a width")
    demand(isinstance(claims["box"], list) and len(claims["box"]) == size, "the box claimed has the wrong size")
    for i, x in enumerate(curve.box[:size]):
        within(x, claims["box"][i], f"coordinate {i + 1}")
    demand(isinstance(claims["ends"], list) and len(claims["ends"]) == 2, "the stability is not claimed at two ends")
    for i, end in enumerate(ends):
        found = margins(*problem.trace_and_det(*end)).values()
        held = {
            "stable": all(x > 0 for x in found) and problem.followed(end[0]),
            "unstable": any(x < 0 for x in found),
            "undecided": True,
        }.get(claims["ends"][i], False)
        demand(held, f"the orbit at end {i + 1} is not proven {quoted(claims['ends'][i])}")
