"""A ball that flies over a plane among objects: places on them, flights, and what keeps a flight off an object.

The ball has radius rho >= 0 and centre p, and flies with p'' = a = (0, -g sin tilt). It touches a disc if p is R + rho
from its centre, a segment or an arc if the nearest point of that is rho from p. So the places of p at a contact are

==============  =============================================  ========================  =====================
part            p at the coordinate u                          normal n, to the ball     where it is a contact
==============  =============================================  ========================  =====================
disc            c + (R + rho) (cos u, sin u)                   (cos u, sin u)            everywhere
left, right     P + u e + rho n, e from start to stop          e turned left, right      0 < u < L
start, stop     E + rho (cos u, sin u), at an end E            (cos u, sin u)            beyond that end
outer           c + (R + rho) (cos u, sin u)                   (cos u, sin u)            between the arc's ends
inner           c + (R - rho) (cos u, sin u)                   -(cos u, sin u)           between the arc's ends
==============  =============================================  ========================  =====================

A drain is met where p is on it. T is n turned by a quarter; dp/du = m T, and dn/du = T where p goes round, else 0.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from grazing_checker.balls import Ball, around, double, number
from grazing_checker.law import Jet, check_law, evaluate, law_text
from grazing_checker.reading import demand, keys, quoted, text_of_double

SHAPES = {
    "disc": ("x", "y", "radius"),
    "segment": ("x1", "y1", "x2", "y2"),
    "arc": ("x", "y", "radius", "start", "stop"),
    "drain": ("x1", "y1", "x2", "y2"),
}
PARTS = {
    "disc": ("disc",), "segment": ("left", "right", "start", "stop"), "arc": ("outer", "inner", "start", "stop"),
    "drain": (),
}  # fmt: skip
#: Names of objects, and most of them.
NAME, OBJECTS = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}"), 100
#: Most pieces that the times of all flights of a certificate are cut into.
PIECES = 100_000
#: Most halvings of one of them, one after the other.
DEEP = 100

Vector = tuple[Ball, Ball]
Polynomial = list[Ball]


def dot(a: Vector, b: Vector) -> Ball:
    """Return a.b."""
    return a[0] * b[0] + a[1] * b[1]


class Surface(NamedTuple):
    """A part of an object: a point, a size, which side; for a face its direction and length."""

    round: bool
    at: Vector
    size: Ball
    sign: int
    e: Vector
    length: Ball

    def frame(self, u: Ball) -> tuple[Vector, Vector, Ball]:
        """Return p, n, and m at a coordinate."""
        (x, y), s = self.at, self.sign
        if self.round:
            sine, cosine = u.sin_cos()
            return (x + self.size * cosine, y + self.size * sine), (s * cosine, s * sine), s * self.size
        n = s * self.e[1], -s * self.e[0]
        return (x + u * self.e[0] + self.size * n[0], y + u * self.e[1] + self.size * n[1]), n, number(s)


class Reader:
    """Reads the numbers of a table: doubles, and one unknown in the place of the one that has no value."""

    def __init__(self, unknown: Any = None) -> None:
        self.unknown, self.left = unknown, int(unknown is not None)

    def __call__(self, text: Any) -> Any:
        """Return the number that a text means, or the unknown."""
        if text is None and self.left:
            self.left -= 1
            return self.unknown
        return double(text_of_double(text))


class Thing:
    """An object of a certificate."""

    def __init__(self, data: Any, rho: Any, read: Reader) -> None:
        demand(isinstance(data, Mapping), "an object is no mapping")
        self.kind = data.get("kind")
        demand(isinstance(self.kind, str) and self.kind in SHAPES, f"the kind of an object is {quoted(self.kind)}")
        keys(data, ("name", "kind", "shape", *(("law",) if self.kind != "drain" else ())), "an object")
        self.name = data["name"]
        named = isinstance(self.name, str) and NAME.fullmatch(self.name)
        demand(named, f"an object cannot be called {quoted(self.name)}")
        keys(data["shape"], SHAPES[self.kind], f"the shape of {self.name}")
        p = {name: read(data["shape"][name]) for name in SHAPES[self.kind]}
        self.law, self.rho = data.get("law"), rho if self.kind != "drain" else number(0)
        if self.law is not None:
            check_law(self.law)
            values = self.law["parameters"].items()
            self.leaves = {name: Jet(read(x), number(0), number(0)) for name, x in values}
        self.ends: tuple[Vector, ...]
        if self.kind in ("segment", "drain"):
            self.ends = (p["x1"], p["y1"]), (p["x2"], p["y2"])
            way = p["x2"] - p["x1"], p["y2"] - p["y1"]
            self.length = dot(way, way).sqrt()
            demand(self.length > 0, f"the ends of {self.name} are one point")
            self.e = way[0] / self.length, way[1] / self.length
            return
        self.centre, self.radius = (p["x"], p["y"]), p["radius"]
        demand(self.radius >= 0, f"the radius of {self.name} is out of range")
        if self.kind == "arc":
            self.half = (p["stop"] - p["start"]) / 2
            demand(self.radius > 0 and self.half > 0, f"the arc {self.name} is none")
            demand(self.half < number(13, -2), f"the arc {self.name} is longer than a turn")
            self.open = bool(self.half < number(25, -3))
            self.middle = self._to((p["start"] + p["stop"]) / 2)
            self.ends = tuple(
                (p["x"] + self.radius * x, p["y"] + self.radius * y) for x, y in map(self._to, (p["start"], p["stop"]))
            )

    def _to(self, angle: Ball) -> Vector:
        sine, cosine = angle.sin_cos()
        return cosine, sine

    def surface(self, part: Any) -> Surface:
        """Return a part of it, or raise Rejected."""
        demand(isinstance(part, str) and part in PARTS[self.kind], f"{self.name} has no part {quoted(part)}")
        none = number(0), number(0)
        if part in ("left", "right"):
            return Surface(False, self.ends[0], self.rho, 1 if part == "right" else -1, self.e, self.length)
        if part in ("start", "stop"):
            demand(self.rho > 0, "a ball without a radius meets no free end")
            demand(self.kind != "arc" or self.open, f"the ends of {self.name} are too near to each other")
            return Surface(True, self.ends[part == "stop"], self.rho, 1, none, number(0))
        if part == "inner":
            demand(self.radius > self.rho, f"the ball does not fit into {self.name}")
            return Surface(True, self.centre, self.radius - self.rho, -1, none, number(0))
        return Surface(True, self.centre, self.radius + self.rho, 1, none, number(0))

    def on(self, part: str, u: Ball, p: Vector) -> Ball:
        """Return what is > 0 exactly if the place p of a part, at coordinate u, is one of a contact."""
        if self.kind == "segment":
            if part in ("left", "right"):
                return (u * (self.length - u)) if u > 0 else u
            foot = dot(self.e, (p[0] - self.ends[0][0], p[1] - self.ends[0][1]))
            return -foot if part == "start" else foot - self.length
        if self.kind == "arc":
            return -self.between(p) if part in ("start", "stop") else self.between(p)
        return number(1)

    def between(self, p: Vector) -> Ball:
        """Return what is > 0 only if a place, seen from the centre, is between the ends of an arc.

        It is < 0 only beyond them, if the arc is open: less than half a turn either way from its middle.
        """
        d = p[0] - self.centre[0], p[1] - self.centre[1]
        ahead: Ball = dot(d, self.middle) - dot(d, d).sqrt() * self.half.sin_cos()[1]
        return ahead

    def after(self, v: Ball) -> Jet:
        """Return what the law makes of a velocity, with its slope."""
        found = evaluate(self.law["after"], {**self.leaves, "v": Jet(v, number(1), number(0))})
        demand(all(one.is_finite() for one in found), "the law is not finite over the box")
        return found

    def elastic(self) -> bool:
        """Return whether the law is -v for all v <= 0 that there are: 0 of 0, with the slope -1 everywhere.

        Flights of an energy E in doubles have v^2 <= 2 (E - g sin(tilt) y), and |y| is less than 2^1027: |v| < 2^1100.
        """
        every = self.after(around(number(-1, 1100), number(1, 1100)))
        return bool((every.by_v + 1).is_zero() and self.after(number(0)).x.is_zero())


class Flight(NamedTuple):
    """A flight from p with velocity w over a time t, under gravity g along -y; all over a box."""

    p: Vector
    w: Vector
    t: Ball
    g: Ball

    def distance(self, n: Vector, at: Vector) -> Polynomial:
        """Return n.(p(s) - at) as a polynomial of the time s."""
        d = self.p[0] - at[0], self.p[1] - at[1]
        return [dot(n, d), dot(n, self.w), -self.g * n[1] / 2]

    def square(self, at: Vector) -> Polynomial:
        """Return |p(s) - at|^2 as a polynomial of the time s."""
        d, (_vx, vy), g = (self.p[0] - at[0], self.p[1] - at[1]), self.w, self.g
        return [dot(d, d), 2 * dot(d, self.w), dot(self.w, self.w) - g * d[1], -g * vy, g * g / 4]

    def height(self, surface: Surface) -> Polynomial:
        """Return a polynomial of the time s that is > 0 exactly if the ball is in front of a part, as if it went on.

        |p - c|^2 - size^2 in front of a round part, its negative inside an arc; the distance from the line of a face.
        """
        sign, size = surface.sign, surface.size
        if surface.round:
            h = self.square(surface.at)
            return [sign * (h[0] - size * size), *(sign * c for c in h[1:])]
        e = surface.e
        h = self.distance((sign * e[1], -sign * e[0]), surface.at)
        return [h[0] - size, *h[1:]]

    def place(self, s: Ball) -> Vector:
        """Return p(s)."""
        return self.p[0] + self.w[0] * s, self.p[1] + self.w[1] * s - self.g * s * s / 2


def factored(h: Polynomial, starts: bool, ends: bool, t: Ball) -> Polynomial:
    """Return h, h/s, h/(t - s) or h/(s (t - s)): the zeros at 0 and t are those of contacts, exactly.

    With h(t) = 0 it is sum over k of c_k (s^k - t^k), and s^k - t^k is (s - t) times sum of s^j t^(k - 1 - j).
    """
    h = h[1:] if starts else h
    if not ends:
        return h
    found = []
    for j in range(len(h) - 1):
        power, total = number(1), number(0)
        for k in range(j + 1, len(h)):
            total -= h[k] * power
            power *= t
        found.append(total)
    return found


def value(h: Polynomial, s: Ball) -> Ball:
    """Return a polynomial at a time."""
    total = number(0)
    for c in reversed(h):
        total = total * s + c
    return total


def over(h: Polynomial, s: Ball) -> Ball:
    """Return a bound from below of a polynomial over a ball of times: by the mean value theorem."""
    middle = s.mid()
    slope = [k * c for k, c in enumerate(h)][1:]
    return (value(h, middle) + value(slope, s) * (s - middle)).lower()


class Apart:
    """The ways to show that a flight is off a part of an object: one of several functions is > 0 at each time.

    Polynomials, or arcs whose ends the ball is beyond.
    """

    def __init__(self, thing: Thing, flight: Flight, starts: str, ends: str) -> None:
        """Take the parts of this object at which the flight begins and ends, empty for none."""
        self.thing, self.flight = thing, flight

        def cut(h: Polynomial, part: str) -> Polynomial:
            return factored(h, starts == part, ends == part, flight.t)

        self.ways: list[list[Polynomial]] = []  # for each part, what may be > 0
        self.beyond = thing.kind == "arc" and thing.open
        if thing.kind == "disc":
            h = flight.square(thing.centre)
            self.ways.append([cut([h[0] - (thing.radius + thing.rho) ** 2, *h[1:]], "disc")])
            return
        if thing.kind == "arc":
            h = flight.square(thing.centre)
            outer = cut([h[0] - (thing.radius + thing.rho) ** 2, *h[1:]], "outer")
            inner = cut([(thing.radius - thing.rho) ** 2 - h[0], *(-c for c in h[1:])], "inner")
            self.ways.append([outer, *([inner] if thing.radius > thing.rho else [])])
        else:
            (x, y), e = thing.ends[0], thing.e
            foot = flight.distance(e, (x, y))
            sides = []
            for part, s in (("left", -1), ("right", 1)):
                f = flight.distance((s * e[1], -s * e[0]), (x, y))
                sides.append(cut([f[0] - thing.rho, *f[1:]], part))
            self.ways.append([*sides, [-c for c in foot], [foot[0] - thing.length, *foot[1:]]])
        if thing.kind != "drain":
            for part, end in zip(("start", "stop"), thing.ends, strict=True):
                h = flight.square(end)
                self.ways.append([cut([h[0] - thing.rho**2, *h[1:]], part)])

    def least(self, work: list[int], but: tuple[str, Ball, Ball] | None = None) -> Ball:
        """Return a number > 0 below the greatest of the functions of each part, at all times; or raise Rejected.

        Times are halved until one function is surely > 0 over each piece, and its bound there more than a quarter of
        its value in the middle, so that another arithmetic finds much the same; ``work`` counts the pieces. ``but``
        names a part, and from when to when it is not asked for.
        """
        found, long = None, self.flight.t.upper()
        for number_of_part, ways in enumerate(self.ways):
            left = [(number(0), long)]
            if but is not None and number_of_part == {"start": 1, "stop": 2}.get(but[0], 0):
                left = [(number(0), but[1]), (but[2], long)]
            while left:
                low, high = left.pop()
                work[0] += 1
                demand(work[0] <= PIECES and len(left) < DEEP, f"a flight is not surely off {self.thing.name}")
                middle = ((low + high) / 2).mid()
                s = around(middle, (high - low).upper() / 2)
                bounds = [(over(h, s), value(h, middle)) for h in ways]
                if self.beyond and number_of_part == 0:
                    beyond = [-self.thing.between(self.flight.place(time)) for time in (s, middle)]
                    bounds.append((beyond[0].lower(), beyond[1]))
                best, there = max(bounds, key=lambda one: float(one[0]))
                if best > 0 and 4 * best > there.lower():
                    found = best if found is None or best < found else found
                else:
                    left += [(low, middle), (middle, high)]
        assert found is not None
        return found


def values_text(values: Mapping[str, str | None], front: str = "") -> str:
    """Return numbers in words; one without a value is left out."""
    return ", ".join(f"{front}{name} = {float.fromhex(x)!r}" for name, x in values.items() if x is not None)


def words(things: Sequence[Any]) -> str:
    """Return objects in words."""
    said = []
    for one in things:
        numbers = values_text(one["shape"])
        law = ", met where the centre of the ball is on it"
        if "law" in one:
            inside = values_text(one["law"]["parameters"], "p.")
            law = f", which makes {law_text(one['law']['after'])} of v{f' with {inside}' if inside else ''}"
        said.append(f'the {one["kind"]} "{one["name"]}" ({numbers}){law}')
    return "; ".join(said)
