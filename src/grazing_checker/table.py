"""Check the certificate of a periodic orbit of a ball on a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from grazing_checker.balls import Ball, double, number, precision
from grazing_checker.gradient import derivative_of, variables
from grazing_checker.oscillator import Point, Rows, applied, box_of, preconditioner, spread
from grazing_checker.plane import OBJECTS, Apart, Flight, Reader, Thing, Vector, dot, values_text, words
from grazing_checker.reading import Inequalities, decimal, demand, keys, numbers, quoted, text_of_double, within

#: Bits of the balls, and most impacts.
BITS, IMPACTS = 256, 60
KEYS = ("objects", "rho", "g", "tilt", "impacts", "energy", "centre", "radius", "unique", "preconditioner", "claims")
CLAIMS = ("box", "apart", "least_period", "time", "incoming", "sums", "stability")
#: Parameters of the ball and the plane.
NUMBERS = ("rho", "g", "tilt")


def check_table_orbit(data: Mapping[str, Any], inequalities: Any) -> str:
    """Verify a certificate of a periodic orbit on a table and return the sentence that it proves, or raise Rejected.

    Impact i is at the coordinate u_i of a part of an object (:mod:`grazing_checker.plane`), and the flight after it
    takes t_i. With d = p_(i+1) - p_i it leaves with w_i = d/t_i - a t_i/2 and comes to the next impact with b_(i+1) =
    d/t_i + a t_i/2: it ends at p_(i+1) by definition. F consists of T_i.(w_i - b_i) and of n_i.w_i - law(n_i.b_i) for
    all i; or, with an energy E, of |w_i|^2/2 + g sin(tilt) y_i - E in place of the latter. What is proven:

    1. One zero of F within ``radius`` of ``centre``, and no other within ``unique``: Krawczyk's theorem, as in
       :func:`grazing_checker.orbit._existence`.
    2. Each impact comes with v = n.b < 0, leaves with n.w > 0, and is on its part. With an energy the laws must be -v
       (:meth:`grazing_checker.plane.Thing.elastic`): flights conserve energy, so |b_i| = |w_i| and n_i.w_i = +-n_i.b_i,
       of which the signs leave one.
    3. The flights are off all objects but for their own contacts (:class:`grazing_checker.plane.Apart`), drains too.
    4. What is claimed of its stability (:func:`_stability`) and of its least period (:func:`_least_period`).
    """
    with precision(BITS):
        rows = Inequalities(inequalities)
        table_rows(data, rows)
        rows.finish()
    return table_sentence(data)


class Dip(NamedTuple):
    """A stretch of a flight near a part of an object that it may touch, and a time inside; numbers count from 0."""

    flight: int
    thing: int
    part: str
    start: Ball
    stop: Ball
    time: Ball


class Table:
    """The table and the word of a certificate; ``unknown`` stands where a parameter has no value."""

    def __init__(self, data: Mapping[str, Any], unknown: Any = None) -> None:
        read = Reader(unknown)
        rho, g, tilt = (read(data[name]) for name in NUMBERS)
        demand(rho >= 0 and g >= 0 and tilt >= 0 and tilt < number(13, -3), "rho, g or tilt is out of range")
        self.g = g * tilt.sin_cos()[0]
        things = data["objects"]
        demand(isinstance(things, list) and 0 < len(things) <= OBJECTS, "the objects are no short list")
        self.things = [Thing(one, rho, read) for one in things]
        demand(not read.left, "the parameter that is unknown has a value")
        names = [one.name for one in self.things]
        demand(len(set(names)) == len(names), "two objects have one name")
        hits = data["impacts"]
        demand(isinstance(hits, list) and 0 < len(hits) <= IMPACTS, "the impacts are no short list")
        self.hits = []
        for hit in hits:
            demand(isinstance(hit, list) and len(hit) == 2 and hit[0] in names, "an impact is at no object")
            self.hits.append((names.index(hit[0]), hit[1]))
        self.n = len(self.hits)
        self.word = [self.things[k].surface(part) for k, part in self.hits]
        self.energy = None if data["energy"] is None else double(text_of_double(data["energy"]))
        if self.energy is not None:
            demand(all(self.things[k].elastic() for k, _part in self.hits), "a law is not surely elastic")

    def frames(self, x: Point) -> list[tuple[Vector, Vector, Ball]]:
        """Return place, normal and m of all impacts."""
        return [surface.frame(u) for surface, u in zip(self.word, x[: self.n], strict=True)]

    def speeds(self, x: Point, frames: list[tuple[Vector, Vector, Ball]]) -> list[tuple[Vector, Vector]]:
        """Return the velocities just after each impact and just before the next one."""
        found = []
        for i, t in enumerate(x[self.n :]):
            demand(t > 0, "a flight does not surely take time")
            (px, py), (qx, qy) = frames[i][0], frames[(i + 1) % self.n][0]
            mean, fall = ((qx - px) / t, (qy - py) / t), self.g * t / 2
            found.append(((mean[0], mean[1] + fall), (mean[0], mean[1] - fall)))
        return found

    def defect(self, x: list[Any]) -> list[Any]:
        """Return F, of balls or of balls with their derivatives."""
        frames = self.frames(x)
        speeds = self.speeds(x, frames)
        first, second = [], []
        for i, ((_px, py), (nx, ny), _m) in enumerate(frames):
            w, b = speeds[i][0], speeds[i - 1][1]
            first.append(-ny * (w[0] - b[0]) + nx * (w[1] - b[1]))
            if self.energy is None:
                thing = self.things[self.hits[i][0]]
                second.append(dot((nx, ny), w) - thing.after(dot((nx, ny), b)).x)
            else:
                second.append(dot(w, w) / 2 + self.g * py - self.energy)
        return first + second

    def derivative(self, x: Point) -> Rows:
        """Return the derivative of F by u and t over a box."""
        return derivative_of(self.defect(list(variables(x))), len(x))

    def flights(self, x: Point) -> list[Flight]:
        """Return the flights of a box."""
        frames = self.frames(x)
        speeds = self.speeds(x, frames)
        return [Flight(frames[i][0], speeds[i][0], x[self.n + i], self.g) for i in range(self.n)]


def table_rows(data: Mapping[str, Any], rows: Any) -> None:
    """Verify a certificate's data; inequalities are taken from ``rows``, or written by what stands in its place."""
    keys(data, KEYS, "the data")
    table, claims = Table(data), data["claims"]
    keys(claims, CLAIMS, "the claims")
    box = _existence(table, data, rows)
    incoming = bounces(table, box, rows)
    frames = table.frames(box)
    speeds = table.speeds(box, frames)
    _stability(table, frames, speeds, box, claims, rows)
    _least_period(table, frames, box, claims, rows)
    total = sum(box[table.n :], number(0))
    within(total, claims["time"], "the time of a turn")
    demand(isinstance(claims["incoming"], list) and len(claims["incoming"]) == table.n, "incoming is not complete")
    for v, text in zip(incoming, claims["incoming"], strict=True):
        within(v, text, "an incoming velocity")


def bounces(table: Table, box: Point, rows: Any, dip: Dip | None = None) -> list[Ball]:
    """Verify that all solutions in a box are motions, but for a dip; return the velocities before the impacts."""
    frames = table.frames(box)
    speeds = table.speeds(box, frames)
    incoming = []
    for i, (k, part) in enumerate(table.hits):
        place, normal, _m = frames[i]
        v = dot(normal, speeds[i - 1][1])
        incoming.append(v)
        rows.less(f"velocity before impact {i + 1}", v)
        rows.more(f"velocity after impact {i + 1}", dot(normal, speeds[i][0]))
        rows.more(f"place of impact {i + 1} on its part", table.things[k].on(part, box[i], place))
    work = [0]
    for i, flight in enumerate(table.flights(box)):
        (one, starts), (two, ends) = table.hits[i], table.hits[(i + 1) % table.n]
        for k, thing in enumerate(table.things):
            apart = Apart(thing, flight, starts if k == one else "", ends if k == two else "")
            but = (dip.part, dip.start, dip.stop) if dip is not None and (dip.flight, dip.thing) == (i, k) else None
            rows.more(f"flight {i + 1} off {thing.name}", apart.least(work, but))
    return incoming


def _existence(table: Table, data: Mapping[str, Any], rows: Any) -> Point:
    """Verify that the box holds exactly one zero of F and return it."""
    size = 2 * table.n
    centre, r, u = (numbers(data[name], size, name) for name in ("centre", "radius", "unique"))
    demand(all(a > 0 and b > a for a, b in zip(r, u, strict=True)), "the boxes are not one inside the other")
    C = preconditioner(data["preconditioner"], size)
    D = table.derivative(box_of(centre, u))
    demand(all(x.is_finite() for row in D for x in row), "the derivative is not finite over the box")
    image = [a + b for a, b in zip(applied(C, table.defect(centre)), spread(C, D, r), strict=True)]
    for i, x in enumerate(image):
        rows.less(f"existence, coordinate {i + 1}", x, data["radius"][i])
    rate = number(0)
    for a, b in zip(spread(C, D, u), u, strict=True):
        rate = rate if (a / b).upper() < rate else (a / b).upper()
    rows.less("uniqueness, contraction rate", rate, "1")
    box, claims = box_of(centre, r), data["claims"]
    demand(isinstance(claims["box"], list) and len(claims["box"]) == size, "the box claimed has the wrong size")
    demand(isinstance(claims["apart"], list) and len(claims["apart"]) == size, "the distances claimed are not complete")
    for i, x in enumerate(box):
        within(x, claims["box"][i], f"coordinate {i + 1}")
        apart, gap = decimal(claims["apart"][i]), u[i] - r[i]
        demand(apart <= gap, "the orbit is not proven to be alone within the distances claimed")
        demand(apart >= gap * 63 / 64, "the distances claimed do not fit the box of uniqueness")
    return box


def turned(table: Table, frames: list[Any], speeds: list[Any], box: Point) -> Rows:
    """Return the derivative of one turn in (x, y, vx, vy), from just after the first impact on.

    A flight over t moves dp by t dv. At an impact of the motion y' = f(y), a jump R where h = 0, dy is multiplied by
    DR + (f+ - DR f-) Dh/(Dh f-). Here h is the distance from the surface, whose normal turns by dn = k T (T.dp) with
    its curvature k, and R adds (law(v) - v) n to the velocity.
    """
    M = [[number(int(i == j)) for j in range(4)] for i in range(4)]
    for i in range(table.n):
        k, t = (i + 1) % table.n, box[table.n + i]
        M = [[M[r][c] + (t * M[r + 2][c] if r < 2 else 0) for c in range(4)] for r in range(4)]
        (_p, n, _m), b, w, word = frames[k], speeds[i][1], speeds[k][0], table.word[k]
        T, v = (-n[1], n[0]), dot(n, b)
        law = table.things[table.hits[k][0]].after(v)
        gain, kick = law.by_v - 1, law.x - v
        bend = word.sign / word.size if word.round else number(0)
        R = [[number(int(r == c)) for c in range(4)] for r in range(4)]
        for r in range(2):
            for c in range(2):
                R[2 + r][2 + c] += gain * n[r] * n[c]
                R[2 + r][c] += bend * (gain * dot(b, T) * n[r] + kick * T[r]) * T[c]
        slow, fast = (*b, number(0), -table.g), (*w, number(0), -table.g)
        jump = [fast[r] - sum((R[r][c] * slow[c] for c in range(4)), number(0)) for r in range(4)]
        S = [[R[r][c] + (jump[r] * n[c] / v if c < 2 else 0) for c in range(4)] for r in range(4)]
        M = [[sum((S[r][j] * M[j][c] for j in range(4)), number(0)) for c in range(4)] for r in range(4)]
    return M


def sums_of(M: Rows, conserved: bool) -> list[Ball]:
    """Return the sums of the multipliers, of their products in pairs, and their product; or L + 1/L.

    One eigenvalue of the turn is 1, along the motion; the others are the multipliers. By Faddeev and LeVerrier, from
    traces. Where energy is conserved another one is 1, and the last two are inverse to each other: the turn keeps the
    area across the motion at a fixed energy.
    """
    e, N, sign = [number(1)], [[number(0)] * 4 for _ in range(4)], 1
    for k in range(1, 5):
        N = [
            [
                sum((M[r][j] * (N[j][c] + (sign * e[k - 1] if j == c else 0)) for j in range(4)), number(0))
                for c in range(4)
            ]
            for r in range(4)
        ]
        e.append(sign * sum((N[r][r] for r in range(4)), number(0)) / k)
        sign = -sign
    if conserved:
        return [e[1] - 2]
    return [e[1] - 1, e[3] - e[4], e[4]]


def margins(sums: list[Ball]) -> dict[str, Ball]:
    """Return quantities that are all > 0 exactly if all multipliers are inside the unit circle (Jury).

    If one is < 0 a multiplier is outside: with all of them inside or on it, none is.
    """
    if len(sums) == 1:  # L + 1/L: never inside, and outside if it is beyond +-2
        return {"2 - |L + 1/L|": 2 - abs(sums[0])}
    a, b, c = sums
    pair = b - a * c
    return {
        "product of 1 - L": 1 - a + b - c,
        "product of 1 + L": 1 + a + b + c,
        "1 - c^2 - (b - a c)": 1 - c * c - pair,
        "1 - c^2 + (b - a c)": 1 - c * c + pair,
    }


def _stability(table: Table, frames: Any, speeds: Any, box: Point, claims: Mapping[str, Any], rows: Any) -> None:
    """Verify the sums of the multipliers and what is claimed of the stability.

    The map from impact to impact is smooth there: impacts come with v < 0, laws are smooth over the box, and all else
    is off. A fixed point is asymptotically stable if all its multipliers are inside the unit circle, and unstable if
    one is outside.
    """
    found = sums_of(turned(table, frames, speeds, box), table.energy is not None)
    demand(isinstance(claims["sums"], list) and len(claims["sums"]) == len(found), "the sums are not complete")
    for x, text in zip(found, claims["sums"], strict=True):
        within(x, text, "a sum of multipliers")
    claimed, quantities = claims["stability"], margins(found)
    demand(claimed in ("stable", "unstable", "undecided"), f"the stability claimed is {quoted(claimed)}")
    if claimed == "stable":
        demand(table.energy is None, "where energy is conserved nothing attracts")
        for name, x in quantities.items():
            rows.more(name, x)
    if claimed == "unstable":
        shown = 0
        for name, x in quantities.items():
            if rows.name == name:
                rows.less(name, x)
                shown += 1
        demand(shown, "nothing shows that the orbit is unstable")


def _least_period(table: Table, frames: Any, box: Point, claims: Mapping[str, Any], rows: Any) -> None:
    """Verify that the orbit has no shorter period, as far as that is claimed.

    A shorter period is n/q impacts for a prime q: then all impacts repeat after so many, at the same place and after
    the same time. For each q either an impact is at another part, or one place or time differs over all of the box.
    """
    claimed, n = claims["least_period"], table.n
    demand(claimed is True or claimed is False, "it is not clear whether a least period is claimed")
    for q in (q for q in range(2, n + 1) if claimed and n % q == 0 and all(q % p for p in range(2, q))):
        step = n // q
        if table.hits != [*table.hits[step:], *table.hits[:step]]:
            continue
        gaps = [number(0)]
        for i in range(n):
            j = (i + step) % n
            (ax, ay), (bx, by) = frames[i][0], frames[j][0]
            gaps += [abs(c).lower() for c in (ax - bx, ay - by, box[n + i] - box[n + j])]
        rows.more(f"least period, divisor {q}", max(gaps, key=float))


OUTSIDE = "of the map from impact to impact"
STABILITY = {
    "stable": f"it is asymptotically stable: all multipliers {OUTSIDE} are inside the unit circle",
    "unstable": f"it is unstable: a multiplier {OUTSIDE} is outside the unit circle",
    "undecided": "nothing is claimed of its stability",
}


def table_text(data: Mapping[str, Any]) -> str:
    """Return the ball and the table in words; a parameter without a value is named only."""
    plane = values_text({name: data[name] for name in ("g", "tilt")})
    radius = "rho" if data["rho"] is None else repr(float.fromhex(data["rho"]))
    return (
        f"a ball of radius {radius} that flies by x'' = 0, y'' = -g sin(tilt), {plane}, does not spin, and whose "
        f"velocity v < 0 along the normal is changed by what it hits, the rest of it staying, among "
        f"{words(data['objects'])}"
    )


def hits_text(data: Mapping[str, Any]) -> str:
    """Return what is hit, in its order."""
    names = ", ".join(map(part_text, data["impacts"]))
    return f"{names}{', in this order,' if len(data['impacts']) > 1 else ''}"


def part_text(hit: Sequence[str]) -> str:
    """Return a part of an object in words."""
    name, part = hit
    return f'{part} of "{name}"' if part != "disc" else f'"{name}"'


def coordinates(n: int) -> list[str]:
    """Return the names of the coordinates of an orbit."""
    return [f"{letter}_{i + 1}" for letter in "ut" for i in range(n)]


#: What the coordinates of an orbit mean.
MEANING = (
    "u_i are angles on round parts and lengths from the start on straight ones, t_i the times of the flights after the "
    "impacts"
)


def impacts_text(data: Mapping[str, Any]) -> str:
    """Return how many impacts a turn has."""
    n = len(data["impacts"])
    return f"{n} {'impacts' if n > 1 else 'impact'}"


def energy_text(data: Mapping[str, Any]) -> str:
    """Return the energy in words where it is conserved."""
    return "" if data["energy"] is None else f" with the energy {float.fromhex(data['energy'])!r} for a mass of 1"


def box_text(data: Mapping[str, Any]) -> str:
    """Return the box in words."""
    names = coordinates(len(data["impacts"]))
    return ", ".join(f"{name} in [{lo}, {hi}]" for name, (lo, hi) in zip(names, data["claims"]["box"], strict=True))


def table_sentence(data: Mapping[str, Any]) -> str:
    """Return the sentence of a certificate of a periodic orbit on a table."""
    claims = data["claims"]
    least = "of least period " if claims["least_period"] else "of period "
    return (
        f"For {table_text(data)}; all parameters and the numbers in the laws taken as these exact doubles, there is "
        f"a periodic orbit{energy_text(data)} {least}{impacts_text(data)} and a time in [{', '.join(claims['time'])}] "
        f"that hits {hits_text(data)} and meets nothing else, with {box_text(data)}; {MEANING}; no other solution of "
        f"the equations of such an orbit is within ({', '.join(claims['apart'])}) of it in these coordinates; "
        f"{STABILITY[claims['stability']]}."
    )
