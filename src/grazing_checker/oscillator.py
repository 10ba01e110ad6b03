"""What the checkers of the oscillator share: the model read anew, the equations of an orbit, their derivative."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from grazing_checker.balls import Ball, around, between_0_and, double, number
from grazing_checker.flight import Checked, Matrix, Motion, Path, Work, exceeds, product, transition
from grazing_checker.law import Jet, constant, evaluate
from grazing_checker.reading import Inequalities, Rejected, demand, numbers, text_of_double, whole
from grazing_checker.walls import LARGEST, Frame, Wall, frame, read

Point = list[Ball]
Rows = list[list[Ball]]
Start = tuple[int, int, Ball, Ball, Ball, Ball, Ball]

#: Precisions of the finder; the checker works with the same.
PRECISIONS = (256, 512, 1024)


class Leg(NamedTuple):
    """One flight of an orbit, over a box or a point, and the impact that ends it.

    It leaves wall ``one`` at time t with velocity w and acceleration ``push``, as that wall sees them. All else is what
    wall ``two`` sees, at which it ends; ``turn`` is -1 if the two look at each other.
    """

    one: int
    two: int
    path: Path
    t: Ball
    end: Ball
    w: Ball
    y: Ball
    v: Ball
    dy: Ball
    dv: Ball
    E: Matrix
    push: Ball
    pull: Ball
    after: Jet
    turn: int

    @property
    def by_start(self) -> tuple[Ball, Ball]:
        """The derivative of height and velocity at the end by t: a later start moves the state there by -(w, push)."""
        E = self.E
        return -self.turn * (E[0] * self.w + E[1] * self.push), -self.turn * (E[2] * self.w + E[3] * self.push)

    @property
    def by_speed(self) -> tuple[Ball, Ball]:
        """The derivative of height and velocity at the end by w."""
        return self.turn * self.E[1], self.turn * self.E[3]


class Dip(NamedTuple):
    """A stretch of a flight above a wall, by their numbers, that may touch it, and a time inside."""

    flight: int
    wall: int
    start: Ball
    stop: Ball
    time: Ball


class Problem:
    """The equations of a certificate, built from its data; the last coordinate of a point may be a parameter.

    Parameters of the model, of each wall and of each law are kept apart: ``unknown`` is a pair of such a group, as
    :func:`grazing_checker.walls.read` calls it, and a name.
    """

    def __init__(self, data: Mapping[str, Any], unknown: tuple[str, str] | None = None) -> None:
        self.walls, texts, self.hits = read(data)
        self.n, self.N = len(self.hits), whole(data["periods"], 1, "periods")
        demand(self.N <= LARGEST, "the orbit has too many impacts or periods")
        self.size = 2 * self.n if self.n else 2
        self.unknown = unknown
        self.work = Work()
        self.work.spend(20 * self.size**2)  # for the products of matrices
        if unknown is not None:
            demand(unknown[1] in texts.get(unknown[0], {}), "the parameter that is unknown does not exist")
            demand(texts[unknown[0]].pop(unknown[1]) is None, "the parameter that is unknown has a value")
        self.values = {of: {name: text_of_double(text) for name, text in some.items()} for of, some in texts.items()}

    def parameters(self, of: str, x: Point) -> dict[str, Ball]:
        """Return the parameters of the model or of the law at a point."""
        found = {name: double(value) for name, value in self.values[of].items()}
        if self.unknown is not None and self.unknown[0] == of:
            found[self.unknown[1]] = x[self.size]
        return found

    def slope(self, of: str) -> dict[str, Ball]:
        """Return the parameters that have a derivative by the unknown one, which is 1."""
        return {self.unknown[1]: number(1)} if self.unknown is not None and self.unknown[0] == of else {}

    def frames(self, x: Point) -> list[Frame]:
        """Return what each wall sees at the parameter of a point."""
        found, p = [], self.parameters("model", x)
        demand(p["omega"] > 0, "omega is out of range")
        demand("k" not in p or p["k"] >= 0, "k is out of range")
        demand(self.walls[0].name or p["alpha"] >= 0, "alpha is out of range")
        for wall in self.walls:
            q = p if wall.place == "model" else self.parameters(wall.place, x)
            demand(all(value.is_finite() for value in (*p.values(), *q.values())), "a parameter is not finite")
            found.append(frame(wall, p, q, self.slope("model"), self.slope(wall.place)))
        return found

    def motion(self, x: Point) -> Motion:
        """Return the motion as the first wall sees it: rates and the period are those of all."""
        return self.frames(x)[0].motion

    def impact(self, x: Point, v: Ball, wall: Wall) -> Jet:
        """Return the velocity after an impact at v, with its derivatives."""
        self.work.spend(10 * wall.nodes)
        known, slopes = self.parameters(wall.law, x), self.slope(wall.law)
        leaves = {name: Jet(value, number(0), slopes.get(name, number(0))) for name, value in known.items()}
        after = evaluate(wall.after, {**leaves, "v": Jet(v, number(1), number(0))})
        demand(all(one.is_finite() for one in after), "the reset law is not finite over the box")
        return after

    def followed(self, x: Point) -> bool:
        """Return whether motions near that in a box are followed by its map from impact to impact.

        That map says what becomes of all of them, if every impact leaves with w > 0. Beside one that leaves with w = 0
        there are motions that meet the wall there with any small velocity before the force lifts them off. Its law
        must not throw these back, nor through the wall: it has to be smooth at small v <= 0, to make 0 of 0, and not to
        grow with v, so that it makes no velocity < 0.
        """
        for wall in {hit for i, hit in enumerate(self.hits) if not x[self.n + i] > 0}:
            try:
                slow = self.impact(x, between_0_and(number(-1, -1000)), self.walls[wall])
            except Rejected:
                return False
            if not (slow.by_v <= 0 and self.impact(x, number(0), self.walls[wall]).x.is_zero()):
                return False
        return True

    def legs(self, x: Point, sensitive: bool = False) -> list[Leg]:
        """Return the flights of a point, or of a small box."""
        frames, self.work.kept = self.frames(x), 0
        flights = [Checked(one.motion, sensitive, self.work) for one in frames]
        made = []
        for start in self._starts(x, frames):
            one, two, t, y, w, L, _end = start
            slopes = frames[one].slope_seen_by(frames[two], t) if sensitive else None
            path = Path(flights[two], t, *frames[one].seen_by(frames[two], t, y, w), L, slopes)
            made.append(self._leg(x, frames, path, start, path.y, path.v, transition(flights[two], L)))
        return made

    def wide_legs(self, centre: Point, x: Point) -> list[Leg]:
        """Return the flights of a box about a centre, each as the centre's plus an unforced one.

        The unforced one is what the flights differ by where they start, as the wall sees it that they leave.
        """
        frames, self.work.kept = self.frames(x), 0
        flights = [Checked(one.motion, work=self.work) for one in frames]
        made = []
        for mid, start in zip(self._starts(centre, frames), self._starts(x, frames), strict=True):
            one, two, tc, yc, wc, Lc, endc = mid
            t, y, w, L, end = start[2:]
            path = Path(flights[two], tc, *frames[one].seen_by(frames[two], tc, yc, wc), Lc)
            E = product(transition(flights[two], Lc), transition(flights[two], L - Lc))
            first, last = flights[one].expanded(tc, yc, wc), flights[two].expanded(endc, path.y, path.v)
            turn = frames[one].sign * frames[two].sign
            dy, dw = turn * (y - first(t - tc)), turn * (w - first(t - tc, 1))
            late = end - endc
            y_end = last(late) + E[0] * dy + E[1] * dw
            v_end = last(late, 1) + E[2] * dy + E[3] * dw
            made.append(self._leg(x, frames, path, start, y_end, v_end, E))
        return made

    def seen(self, x: Point, leg: Leg, to: int, resting: bool = False) -> Path:
        """Return a flight as a wall sees it; ``resting`` says that it leaves with w = 0 exactly."""
        if to == leg.two and not resting:
            return leg.path
        frames = self.frames(x)
        start = number(0) if self.n else x[0], number(0) if resting else leg.w
        flights = Checked(frames[to].motion, work=self.work)
        return Path(flights, leg.t, *frames[leg.one].seen_by(frames[to], leg.t, *start), leg.end - leg.t)

    def _starts(self, x: Point, frames: list[Frame]) -> list[Start]:
        """Return the walls at both ends, time, height, velocity, length and end of every flight."""
        n, turn = self.n, self.N * frames[0].motion.period
        if n == 0:
            return [(0, 0, number(0), x[0], x[1], turn, turn)]
        ends = [*x[1:n], x[0] + turn]
        demand(all(b > a for a, b in zip(x[:n], ends, strict=True)), "the impacts are not in the order of time")
        to = [*self.hits[1:], self.hits[0]]
        return [(self.hits[i], to[i], x[i], number(0), x[n + i], ends[i] - x[i], ends[i]) for i in range(n)]

    def _leg(self, x: Point, frames: list[Frame], path: Path, start: Start, y: Ball, v: Ball, E: Matrix) -> Leg:
        one, two, t, y0, w, _L, end = start
        left, met = frames[one].motion, frames[two].motion
        push = left.force(t) - left.alpha * w - left.k2 * y0
        pull = met.force(end) - met.alpha * v - met.k2 * y
        after = self.impact(x, v, self.walls[two]) if self.n else constant(v)
        turn = frames[one].sign * frames[two].sign
        return Leg(one, two, path, t, end, w, y, v, path.dy, path.dv, E, push, pull, after, turn)

    def defect(self, x: Point, legs: list[Leg]) -> Point:
        """Return what must vanish: heights at the impacts, and velocities after them less what the law gives."""
        if self.n == 0:
            return [legs[0].y - x[0], legs[0].v - x[1]]
        after = [x[self.n + (i + 1) % self.n] for i in range(self.n)]
        return [leg.y for leg in legs] + [w - leg.after.x for w, leg in zip(after, legs, strict=True)]

    def derivative(self, x: Point, legs: list[Leg]) -> Rows:
        """Return the derivative of :meth:`defect` by all coordinates."""
        n, size = self.n, self.size
        D = [[number(0) for _ in range(size + bool(self.unknown))] for _ in range(size)]
        slower = self.N * self.motion(x).period_slope()
        for i, leg in enumerate(legs):
            late = slower if i == len(legs) - 1 else number(0)
            dy, dv = leg.dy + leg.v * late, leg.dv + leg.pull * late
            if n == 0:
                D = [[leg.E[0] - 1, leg.E[1], dy], [leg.E[2], leg.E[3] - 1, dv]]
                return [row[: 2 + bool(self.unknown)] for row in D]
            to, g = (i + 1) % n, leg.after.by_v
            for column, (y_x, v_x) in ((i, leg.by_start), (to, (leg.v, leg.pull)), (n + i, leg.by_speed)):
                D[i][column] += y_x
                D[n + i][column] -= g * v_x
            D[n + i][n + to] += 1
            if self.unknown:
                D[i][size], D[n + i][size] = dy, -(g * dv + leg.after.by_p)
        return D

    def trace_and_det(self, x: Point, legs: list[Leg]) -> tuple[Ball, Ball]:
        """Return trace and determinant of the return map's derivative.

        It is taken in (time, velocity) just after impact 1, by eliminating the heights: dt' = -(y_t dt + y_w dw)/v and
        dw' = g' (v_t dt + v_w dw + pull dt'). Without impacts it is the unforced flight.
        """
        motion = self.motion(x)
        if self.n == 0:
            E = legs[0].E
            return E[0] + E[3], (-motion.alpha * self.N * motion.period).exp()
        total = (number(1), number(0), number(0), number(1))
        det = (-motion.alpha * self.N * motion.period).exp()
        for i, leg in enumerate(legs):
            (y_t, v_t), (y_w, v_w) = leg.by_start, leg.by_speed
            a, b, g = -y_t / leg.v, -y_w / leg.v, leg.after.by_v
            total = product((a, b, g * (v_t + leg.pull * a), g * (v_w + leg.pull * b)), total)
            det *= g * legs[(i + 1) % self.n].w / leg.v
        return total[0] + total[3], det


def precision_of(data: Any) -> int:
    """Return the precision that a certificate asks for."""
    bits = whole(data["precision"], 1, "precision")
    demand(bits in PRECISIONS, "the precision is none of the finder's")
    return bits


def box_of(centre: Point, radius: Point) -> Point:
    """Return a box as balls."""
    demand(all(r >= 0 for r in radius), "a half-width is negative")
    return [around(c, r) for c, r in zip(centre, radius, strict=True)]


def preconditioner(rows: Any, size: int) -> Rows:
    """Return the approximate inverse of a certificate."""
    shaped = isinstance(rows, list) and len(rows) == size and all(isinstance(r, list) and len(r) == size for r in rows)
    demand(shaped, "the preconditioner has the wrong shape")
    return [[double(text_of_double(x)) for x in row] for row in rows]


def applied(C: Rows, F: Point) -> Point:
    """Return bounds on |C F|."""
    return [abs(sum((c * f for c, f in zip(row, F, strict=True)), number(0))).upper() for row in C]


def spread(C: Rows, D: Rows, u: Point) -> Point:
    """Return bounds on |I - C D| u; few entries of D are not 0."""
    filled = [[(j, x) for j, x in enumerate(row) if not x.is_zero()] for row in D]
    bounds = []
    for i, factors in enumerate(C):
        row = [number(0)] * len(C)
        row[i] = number(-1)
        for factor, entries in zip(factors, filled, strict=True):
            for j, x in entries:
                row[j] = row[j] + factor * x
        bounds.append(sum((abs(x).upper() * w for x, w in zip(row, u, strict=True)), number(0)).upper())
    return bounds


def margins(trace: Ball, det: Ball) -> dict[str, Ball]:
    """Return Jury's three quantities, all > 0 exactly if both multipliers are inside the unit circle."""
    return {"1 + trace + det": 1 + trace + det, "1 - trace + det": 1 - trace + det, "1 - det": 1 - det}


def check_flights(
    problem: Problem, x: Point, legs: list[Leg], cuts: Any, rows: Inequalities, dip: Dip | None = None
) -> None:  # fmt: skip
    """Verify that all solutions in a box are motions: what happens at impacts, and no contact between them.

    An impact comes with v < 0 and leaves with w > 0, or with w = 0 exactly. Then flight i, which leaves one wall at y
    = 0 and after a time L that is in a ball is at y = 0 of the other or of the same, is off all walls between if, with
    0 < start, end < L for all of that ball, and start < end if the walls are the same,

    - as the wall sees it that it leaves, v > 0 on [0, start]; if it leaves with w = 0, y'' > 0 there, so that v > 0 on
      (0, start]; and y > 0 on [start, L];
    - as the wall sees it that it meets, y > 0 on [0, end], and v < 0 on [end, L], so that y > y(L) = 0 before L. If
      that is the same wall, y > 0 on [start, end] instead of both stretches, but for a dip in its inside;
    - as any other wall sees it, y > 0 on [0, L].

    Without impacts y > 0 must hold on the whole of [0, N T] for each wall. Every bound holds for all solutions in the
    box at once. A dip at a wall that the flight does not end at lies before L as well, for all of that ball.
    """
    n, kept = problem.n, problem.work.kept
    if n == 0:
        demand(cuts == [], "an orbit without impacts has no cuts")
    for i, leg in enumerate(legs if n else ()):
        rows.less(f"velocity before impact {(i + 1) % n + 1}", leg.v)
        demand(leg.after.x > 0 or leg.after.x.is_zero(), "the reset law does not surely return a velocity >= 0")
    demand(isinstance(cuts, list) and len(cuts) == n, "there are not two cuts for every flight")
    for i, leg in enumerate(legs):
        L = leg.end - leg.t
        start, end = numbers(cuts[i], 2, f"cuts of flight {i + 1}") if n else (number(0), L.upper())
        if n:
            ordered = end > start or leg.one != leg.two
            demand(
                start > 0 and end > 0 and ordered and L > start and L > end,
                f"the cuts of flight {i + 1} are not in order",
            )
        resting = n > 0 and legs[i - 1].after.x.is_zero()
        problem.work.kept = kept
        paths = [problem.seen(x, leg, to, resting) for to in range(len(problem.walls))]
        if n:
            first = f"{'acceleration' if resting else 'velocity'} of flight {i + 1} up to its first cut"
            shown = exceeds(paths[leg.one], number(0), start, 2 if resting else 1, rows.left(first, ">"))
            demand(shown, f"{first} is not proven")
        for j, path in enumerate(paths):
            low, high = start if j == leg.one else number(0), end if j == leg.two else L.upper()
            here = dip if dip is not None and dip[:2] == (i, j) else None
            demand(here is None or n == 0 or L > here.stop, "the dip is not inside its flight")
            _check_height(path, _height(problem, i, j), low, high, rows, here)
        if n:
            last = f"velocity of flight {i + 1} after its last cut"
            shown = exceeds(paths[leg.two], end, L.upper(), 1, -rows.left(last, "<"), sign=-1)
            demand(shown, f"{last} is not proven")


def _height(problem: Problem, i: int, j: int) -> str:
    """Return what the height of a flight above a wall is called."""
    name = problem.walls[j].name
    flight = f"flight {i + 1}" if problem.n else "the orbit"
    if name:
        return f"distance of {flight} from wall {name}"
    return f"height of {flight}{' between its cuts' if problem.n else ''}"


def _check_height(path: Path, name: str, low: Ball, high: Ball, rows: Inequalities, dip: Dip | None) -> None:
    """Verify y > left >= 0 on a stretch, but for a dip, which must lie inside."""
    floor = rows.left(name, ">")
    if dip is None:
        demand(exceeds(path, low, high, 0, floor), f"{name} is not proven")
        return
    one, two = dip.start, dip.stop
    demand(one > low and two > one and high > two, "the dip is not inside its flight")
    demand(exceeds(path, low, one, 0, floor) and exceeds(path, two, high, 0, floor), f"{name} is not proven")


def inside(small: Point, large: Point) -> bool:
    """Return whether a box surely lies inside another; bounds are rounded outwards, so that equal ones show nothing."""
    return all(bool(a.lower() > b.lower() and a.upper() < b.upper()) for a, b in zip(small, large, strict=True))
