"""What the checkers of the oscillator share: the model read anew, the equations of an orbit, their derivative."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from grazing_checker.balls import Ball, around, between_0_and, double, number
from grazing_checker.flight import Checked, Matrix, Motion, Path, Work, exceeds, product, transition
from grazing_checker.law import Jet, check_law, constant, evaluate
from grazing_checker.reading import Inequalities, Rejected, demand, keys, numbers, text_of_double, whole

Point = list[Ball]
Rows = list[list[Ball]]

SCALARS = ("alpha", "k", "omega", "t0", "offset", "sigma")
#: Precisions of the finder; the checker works with the same.
PRECISIONS = (256, 512, 1024)
#: Most impacts and periods that a certificate may speak of, and most harmonics.
LARGEST, HARMONICS = 10_000, 1000


class Leg(NamedTuple):
    """One flight of an orbit, over a box or a point, and the impact that ends it."""

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


class Problem:
    """The equations of a certificate, built from its data; the last coordinate of a point may be a parameter.

    Parameters of the model and of the law are kept apart: ``unknown`` is a pair of ``"model"`` or ``"law"`` and a name.
    """

    def __init__(self, data: Mapping[str, Any], unknown: tuple[str, str] | None = None) -> None:
        self.n, self.N = whole(data["impacts"], 0, "impacts"), whole(data["periods"], 1, "periods")
        demand(self.n <= LARGEST and self.N <= LARGEST, "the orbit has too many impacts or periods")
        self.size = 2 * self.n if self.n else 2
        self.unknown = unknown
        self.work = Work()
        self.work.spend(20 * self.size**2)  # for the products of matrices
        self.nodes = check_law(data["law"])
        self.after = data["law"]["after"]
        texts = {"model": model_parameters(data["model"]), "law": dict(data["law"]["parameters"])}
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

    def motion(self, x: Point) -> Motion:
        """Return the forcing at the parameter of a point."""
        p = self.parameters("model", x)
        demand(p["alpha"] >= 0 and p["k"] >= 0 and p["omega"] > 0, "alpha, k or omega is out of range")
        demand(all(value.is_finite() for value in p.values()), "a parameter is not finite")
        js = range(1, sum(name.startswith("cos") for name in p) + 1)
        return Motion(
            p["alpha"], p["k"], p["omega"], p["t0"], p["offset"], p["sigma"],
            cos=[p[f"cos{j}"] for j in js], sin=[p[f"sin{j}"] for j in js], slopes=self.slope("model"),
        )  # fmt: skip

    def impact(self, x: Point, v: Ball) -> Jet:
        """Return the velocity after an impact at v, with its derivatives."""
        self.work.spend(10 * self.nodes)
        known, slopes = self.parameters("law", x), self.slope("law")
        leaves = {name: Jet(value, number(0), slopes.get(name, number(0))) for name, value in known.items()}
        after = evaluate(self.after, {**leaves, "v": Jet(v, number(1), number(0))})
        demand(all(one.is_finite() for one in after), "the reset law is not finite over the box")
        return after

    def followed(self, x: Point) -> bool:
        """Return whether motions near that in a box are followed by its map from impact to impact.

        That map says what becomes of all of them, if every impact leaves with w > 0. Beside one that leaves with w = 0
        there are motions that meet the wall there with any small velocity before the force lifts them off. The law
        must not throw these back, nor through the wall: it has to be smooth at small v <= 0, to make 0 of 0, and not to
        grow with v, so that it makes no velocity < 0.
        """
        if all(w > 0 for w in x[self.n : 2 * self.n]):
            return True
        try:
            slow = self.impact(x, between_0_and(number(-1, -1000)))
        except Rejected:
            return False
        return bool(slow.by_v <= 0 and self.impact(x, number(0)).x.is_zero())

    def legs(self, x: Point, sensitive: bool = False) -> list[Leg]:
        """Return the flights of a point, or of a small box."""
        motion = self.motion(x)
        flights = Checked(motion, sensitive, self.work)
        made = []
        for t, y, w, L, end in self._starts(x, motion):
            path = Path(flights, t, y, w, L)
            made.append(self._leg(x, motion, path, (t, end, w, y), path.y, path.v, transition(flights, L)))
        return made

    def wide_legs(self, centre: Point, x: Point) -> list[Leg]:
        """Return the flights of a box about a centre, each as the centre's plus an unforced one."""
        motion = self.motion(x)
        flights = Checked(motion, work=self.work)
        made = []
        for (tc, yc, wc, Lc, endc), (t, y, w, L, end) in zip(
            self._starts(centre, motion), self._starts(x, motion), strict=True
        ):
            path = Path(flights, tc, yc, wc, Lc)
            E = product(transition(flights, Lc), transition(flights, L - Lc))
            first, last = path.pieces[0], flights.expanded(endc, path.y, path.v)
            dy, dw = y - first(t - tc), w - first(t - tc, 1)
            late = end - endc
            y_end = last(late) + E[0] * dy + E[1] * dw
            v_end = last(late, 1) + E[2] * dy + E[3] * dw
            made.append(self._leg(x, motion, path, (t, end, w, y), y_end, v_end, E))
        return made

    def _starts(self, x: Point, motion: Motion) -> list[tuple[Ball, Ball, Ball, Ball, Ball]]:
        """Return time, height, velocity, length and end of every flight."""
        n, turn = self.n, self.N * motion.period
        if n == 0:
            return [(number(0), x[0], x[1], turn, turn)]
        ends = [*x[1:n], x[0] + turn]
        demand(all(b > a for a, b in zip(x[:n], ends, strict=True)), "the impacts are not in the order of time")
        return [(x[i], number(0), x[n + i], ends[i] - x[i], ends[i]) for i in range(n)]

    def _leg(
        self, x: Point, motion: Motion, path: Path, start: tuple[Ball, Ball, Ball, Ball], y: Ball, v: Ball, E: Matrix
    ) -> Leg:
        t, end, w, y0 = start
        push = motion.force(t) - motion.alpha * w - motion.k2 * y0
        pull = motion.force(end) - motion.alpha * v - motion.k2 * y
        after = self.impact(x, v) if self.n else constant(v)
        return Leg(path, t, end, w, y, v, path.dy, path.dv, E, push, pull, after)

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
            # a later start moves the state there by -(w, push)
            y_t, v_t = -leg.E[0] * leg.w - leg.E[1] * leg.push, -leg.E[2] * leg.w - leg.E[3] * leg.push
            to, g = (i + 1) % n, leg.after.by_v
            for column, y_x, v_x in ((i, y_t, v_t), (to, leg.v, leg.pull), (n + i, leg.E[1], leg.E[3])):
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
            y_t, v_t = -leg.E[0] * leg.w - leg.E[1] * leg.push, -leg.E[2] * leg.w - leg.E[3] * leg.push
            a, b, g = -y_t / leg.v, -leg.E[1] / leg.v, leg.after.by_v
            total = product((a, b, g * (v_t + leg.pull * a), g * (leg.E[3] + leg.pull * b)), total)
            det *= g * legs[(i + 1) % self.n].w / leg.v
        return total[0] + total[3], det


def model_parameters(model: Any) -> dict[str, Any]:
    """Return the texts of the parameters of a model by their names; None for one that is unknown."""
    keys(model, (*SCALARS, "cos", "sin", "offset_name"), "the model")
    cos, sin = model["cos"], model["sin"]
    demand(isinstance(cos, list) and isinstance(sin, list), "cos and sin are no lists")
    demand(1 <= len(cos) == len(sin) <= HARMONICS, "cos and sin do not match")
    demand(model["offset_name"] in ("offset", "d"), "the constant force has a strange name")
    texts = {name: model[name] for name in SCALARS}
    for j, (c, s) in enumerate(zip(cos, sin, strict=True), start=1):
        texts |= {f"cos{j}": c, f"sin{j}": s}
    return texts


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


def check_flights(problem: Problem, legs: list[Leg], cuts: Any, rows: Inequalities, dip: Any = None) -> None:
    """Verify that all solutions in a box are motions: what happens at impacts, and no contact between them.

    An impact comes with v < 0 and leaves with w > 0, or with w = 0 exactly. Then flight i, from y = 0, back at y = 0
    after a time L that is in a ball, is above the wall between if, with 0 < start < end < L for all of that ball,

    - v > 0 on [0, start]; if it leaves with w = 0, y'' > 0 there, so that v > 0 on (0, start];
    - y > 0 on [start, end], but for a dip in its inside;
    - v < 0 on [end, L], so that y > y(L) = 0 before L.

    Without impacts y > 0 must hold on the whole of [0, N T]. Every bound holds for all solutions in the box at once.
    """
    n = problem.n
    if n == 0:
        demand(cuts == [], "an orbit without impacts has no cuts")
        _check_height(legs[0].path, "height of the orbit", number(0), legs[0].end - legs[0].t, rows, dip)
        return
    for i, leg in enumerate(legs):
        rows.less(f"velocity before impact {(i + 1) % n + 1}", leg.v)
        demand(leg.after.x > 0 or leg.after.x.is_zero(), "the reset law does not surely return a velocity >= 0")
    demand(isinstance(cuts, list) and len(cuts) == n, "there are not two cuts for every flight")
    for i, leg in enumerate(legs):
        start, end = numbers(cuts[i], 2, f"cuts of flight {i + 1}")
        L = leg.end - leg.t
        demand(start > 0 and end > start and L > end, f"the cuts of flight {i + 1} are not in order")
        resting = legs[i - 1].after.x.is_zero()
        path = leg.path if not resting else Path(leg.path.flights, leg.t, number(0), number(0), L)
        first = f"{'acceleration' if resting else 'velocity'} of flight {i + 1} up to its first cut"
        shown = exceeds(path, number(0), start, 2 if resting else 1, rows.left(first, ">"))
        demand(shown, f"{first} is not proven")
        _check_height(path, f"height of flight {i + 1} between its cuts", start, end, rows, dip, i + 1)
        last = f"velocity of flight {i + 1} after its last cut"
        demand(exceeds(path, end, L.upper(), 1, -rows.left(last, "<"), sign=-1), f"{last} is not proven")


def _check_height(
    path: Path, name: str, low: Ball, high: Ball, rows: Inequalities, dip: Any, flight: int = 1
) -> None:  # fmt: skip
    """Verify y > left >= 0 on a stretch, but for a dip of this flight, which must lie inside."""
    floor = rows.left(name, ">")
    if dip is None or dip["flight"] != flight:
        demand(exceeds(path, low, high, 0, floor), f"{name} is not proven")
        return
    one, two = numbers([dip["from"], dip["to"]], 2, "the dip")
    demand(one > low and two > one and high > two, "the dip is not inside its flight")
    demand(exceeds(path, low, one, 0, floor) and exceeds(path, two, high, 0, floor), f"{name} is not proven")


def inside(small: Point, large: Point) -> bool:
    """Return whether a box surely lies inside another; bounds are rounded outwards, so that equal ones show nothing."""
    return all(bool(a.lower() > b.lower() and a.upper() < b.upper()) for a, b in zip(small, large, strict=True))
