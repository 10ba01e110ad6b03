"""What the checkers of the oscillator share: the model read anew, the equations of an orbit, their derivative."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from grazing.proof.checker_flight import Checked, Motion, Path, exceeds, transition
from grazing.proof.checker_law import Answer, Impact, impact_of
from grazing.proof.checker_reading import Inequalities, Rejected, demand, double, keys, numbers, whole

if TYPE_CHECKING:
    from flint import arb

    Point = list[arb]
    Matrix = list[list[arb]]

SCALARS = ("alpha", "k", "omega", "t0", "offset", "sigma")
#: Precisions of the finder; the checker works with the same.
PRECISIONS = (256, 512, 1024)
#: Most impacts and periods that a certificate may speak of.
LARGEST = 10_000


class Leg(NamedTuple):
    """One flight of an orbit, over a box or a point, and the impact that ends it."""

    path: Path
    t: arb
    end: arb
    w: arb
    y: arb
    v: arb
    dy: arb
    dv: arb
    E: tuple[arb, arb, arb, arb]
    push: arb
    pull: arb
    answer: Answer


class Problem:
    """The equations of a certificate, built from its data; the last coordinate of a point may be a parameter."""

    def __init__(self, data: Mapping[str, Any], code: Any) -> None:
        keys(data["model"], (*SCALARS, "cos", "sin", "offset_name"), "the model")
        keys(data["law"], ("name", "params", "code"), "the law")
        self.n, self.N = whole(data["impacts"], 0, "impacts"), whole(data["periods"], 1, "periods")
        demand(self.n <= LARGEST and self.N <= LARGEST, "the orbit has too many impacts or periods")
        self.data, self.code = data, code
        self.unknown = data.get("parameter", "")
        self.size = 2 * self.n if self.n else 2
        self._read()

    def _read(self) -> None:
        """Read the parameters; the unknown one is empty."""
        model, law = self.data["model"], self.data["law"]
        cos, sin = model["cos"], model["sin"]
        demand(
            isinstance(cos, list) and isinstance(sin, list) and len(cos) == len(sin) >= 1, "cos and sin do not match"
        )
        demand(isinstance(law["params"], Mapping) and isinstance(law["name"], str), "the law is not described")
        demand(model["offset_name"] in ("offset", "d"), "the constant force has a strange name")
        texts = {name: model[name] for name in ("alpha", "k", "omega", "t0", "offset")}
        for j, (c, s) in enumerate(zip(cos, sin, strict=True), start=1):
            texts |= {f"cos{j}": c, f"sin{j}": s}
        texts |= {"sigma": model["sigma"], **law["params"]}
        empty = [name for name, text in texts.items() if text == ""]
        demand(empty == ([self.unknown] if self.unknown else []), "it is not clear which parameter is unknown")
        self.values = {name: double(text) for name, text in texts.items() if text != ""}
        self.names, self.harmonics = list(texts), len(cos)

    def motion(self, x: Point) -> tuple[Motion, Impact]:
        """Return forcing and law at the parameter of a point."""
        from flint import arb

        p = {name: arb(self.values[name]) if name in self.values else x[self.size] for name in self.names}
        demand(p["alpha"] >= 0 and p["k"] >= 0 and p["omega"] > 0, "alpha, k or omega is out of range")
        js = range(1, self.harmonics + 1)
        slopes = {self.unknown: arb(1)} if self.unknown else {}
        cos, sin = [p[f"cos{j}"] for j in js], [p[f"sin{j}"] for j in js]
        motion = Motion(
            p["alpha"], p["k"], p["omega"], p["t0"], p["offset"], p["sigma"], cos=cos, sin=sin, slopes=slopes
        )
        inside = {name: p[name] for name in self.data["law"]["params"]}
        called = {self.data["model"]["offset_name"] if name == "offset" else name: value for name, value in p.items()}
        called_unknown = self.data["model"]["offset_name"] if self.unknown == "offset" else self.unknown
        return motion, impact_of(self.data["law"], inside, called, called_unknown, self.code)

    def legs(self, x: Point, sensitive: bool = False) -> list[Leg]:
        """Return the flights of a point, or of a small box."""
        motion, impact = self.motion(x)
        flights = Checked(motion, sensitive)
        made = []
        for t, y, w, L, end in self._starts(x, motion):
            path = Path(flights, t, y, w, L)
            made.append(self._leg(motion, impact, path, (t, end, w, y), path.y, path.v, transition(flights, L)))
        return made

    def wide_legs(self, centre: Point, x: Point) -> list[Leg]:
        """Return the flights of a box about a centre, each as the centre's plus an unforced one."""
        motion, impact = self.motion(x)
        flights = Checked(motion)
        made = []
        for (tc, yc, wc, Lc, endc), (t, y, w, L, end) in zip(
            self._starts(centre, motion), self._starts(x, motion), strict=True
        ):
            path = Path(flights, tc, yc, wc, Lc)
            E = transition(flights, Lc)
            short = transition(flights, L - Lc)
            E = (
                E[0] * short[0] + E[1] * short[2], E[0] * short[1] + E[1] * short[3],
                E[2] * short[0] + E[3] * short[2], E[2] * short[1] + E[3] * short[3],
            )  # fmt: skip
            first, last = path.pieces[0], flights.expanded(endc, path.y, path.v)
            dy, dw = y - first(t - tc), w - first(t - tc, 1)
            late = end - endc
            y_end = last(late) + E[0] * dy + E[1] * dw
            v_end = last(late, 1) + E[2] * dy + E[3] * dw
            made.append(self._leg(motion, impact, path, (t, end, w, y), y_end, v_end, E))
        return made

    def _starts(self, x: Point, motion: Motion) -> list[tuple[arb, arb, arb, arb, arb]]:
        """Return time, height, velocity, length and end of every flight."""
        from flint import arb

        n, turn = self.n, self.N * motion.period
        if n == 0:
            return [(arb(0), x[0], x[1], turn, turn)]
        ends = [*x[1:n], x[0] + turn]
        demand(all(b > a for a, b in zip(x[:n], ends, strict=True)), "the impacts are not in the order of time")
        return [(x[i], arb(0), x[n + i], ends[i] - x[i], ends[i]) for i in range(n)]

    def _leg(
        self, motion: Motion, impact: Impact, path: Path, start: tuple[arb, arb, arb, arb], y: arb, v: arb,
        E: tuple[arb, arb, arb, arb],
    ) -> Leg:  # fmt: skip
        from flint import arb

        t, end, w, y0 = start
        push = motion.force(t) - motion.alpha * w - motion.k2 * y0
        pull = motion.force(end) - motion.alpha * v - motion.k2 * y
        answer = impact(v) if self.n else Answer(v, arb(1), arb(0))
        return Leg(path, t, end, w, y, v, path.dy, path.dv, E, push, pull, answer)

    def defect(self, x: Point, legs: list[Leg]) -> Point:
        """Return what must vanish: heights at the impacts, and velocities after them less what the law gives."""
        if self.n == 0:
            return [legs[0].y - x[0], legs[0].v - x[1]]
        after = [x[self.n + (i + 1) % self.n] for i in range(self.n)]
        return [leg.y for leg in legs] + [w - leg.answer.w for w, leg in zip(after, legs, strict=True)]

    def derivative(self, x: Point, legs: list[Leg]) -> Matrix:
        """Return the derivative of :meth:`defect` by all coordinates."""
        from flint import arb

        n, size = self.n, self.size
        D = [[arb(0) for _ in range(size + bool(self.unknown))] for _ in range(size)]
        slower = self.N * self.motion(x)[0].period_slope()
        for i, leg in enumerate(legs):
            late = slower if i == len(legs) - 1 else arb(0)
            dy, dv = leg.dy + leg.v * late, leg.dv + leg.pull * late
            if n == 0:
                D = [[leg.E[0] - 1, leg.E[1], dy], [leg.E[2], leg.E[3] - 1, dv]]
                return [row[: 2 + bool(self.unknown)] for row in D]
            # a later start moves the state there by -(w, push)
            y_t, v_t = -leg.E[0] * leg.w - leg.E[1] * leg.push, -leg.E[2] * leg.w - leg.E[3] * leg.push
            to, g = (i + 1) % n, leg.answer.slope
            for column, y_x, v_x in ((i, y_t, v_t), (to, leg.v, leg.pull), (n + i, leg.E[1], leg.E[3])):
                D[i][column] += y_x
                D[n + i][column] -= g * v_x
            D[n + i][n + to] += 1
            if self.unknown:
                D[i][size], D[n + i][size] = dy, -(g * dv + leg.answer.change)
        return D

    def trace_and_det(self, x: Point, legs: list[Leg]) -> tuple[arb, arb]:
        """Return trace and determinant of the return map's derivative.

        It is taken in (time, velocity) just after impact 1, by eliminating the heights: dt' = -(y_t dt + y_w dw)/v and
        dw' = g' (v_t dt + v_w dw + pull dt'). Without impacts it is the unforced flight.
        """
        from flint import arb_mat

        motion, _impact = self.motion(x)
        if self.n == 0:
            E = legs[0].E
            return E[0] + E[3], (-motion.alpha * self.N * motion.period).exp()
        total = arb_mat([[1, 0], [0, 1]])
        det = (-motion.alpha * self.N * motion.period).exp()
        for i, leg in enumerate(legs):
            y_t, v_t = -leg.E[0] * leg.w - leg.E[1] * leg.push, -leg.E[2] * leg.w - leg.E[3] * leg.push
            a, b, g = -y_t / leg.v, -leg.E[1] / leg.v, leg.answer.slope
            total = arb_mat([[a, b], [g * (v_t + leg.pull * a), g * (leg.E[3] + leg.pull * b)]]) * total
            det *= g * legs[(i + 1) % self.n].w / leg.v
        return total[0, 0] + total[1, 1], det


def precision_of(data: Any) -> int:
    """Return the precision that a certificate asks for."""
    demand(isinstance(data, Mapping) and data.get("precision") in PRECISIONS, "the precision is none of the finder's")
    return int(data["precision"])


def box_of(centre: Point, radius: Point) -> Point:
    """Return a box as balls."""
    from flint import arb

    demand(all(r >= 0 for r in radius), "a half-width is negative")
    return [c + arb(0, 1) * r for c, r in zip(centre, radius, strict=True)]


def preconditioner(rows: Any, size: int) -> Matrix:
    """Return the approximate inverse of a certificate."""
    from flint import arb

    shaped = isinstance(rows, list) and len(rows) == size and all(isinstance(r, list) and len(r) == size for r in rows)
    demand(shaped, "the preconditioner has the wrong shape")
    return [[arb(double(x)) for x in row] for row in rows]


def applied(C: Matrix, F: Point) -> Point:
    """Return bounds on |C F|."""
    from flint import arb

    return [abs(sum((c * f for c, f in zip(row, F, strict=True)), arb(0))).upper() for row in C]


def spread(C: Matrix, D: Matrix, u: Point) -> Point:
    """Return bounds on |I - C D| u."""
    from flint import arb

    size = range(len(C))
    bounds = []
    for i in size:
        row = [sum((C[i][m] * D[m][j] for m in size), arb(0)) - (1 if i == j else 0) for j in size]
        bounds.append(sum((abs(x).upper() * w for x, w in zip(row, u, strict=True)), arb(0)).upper())
    return bounds


def check_flights(problem: Problem, x: Point, legs: list[Leg], cuts: Any, rows: Inequalities, dip: Any = None) -> None:
    """Verify that impacts come with v < 0, and that no flight meets the wall between its ends."""
    n = problem.n
    if n == 0:
        demand(cuts == [], "an orbit without impacts has no cuts")
        _check_height(legs[0].path, "height of the orbit", 0 * x[0], legs[0].end - legs[0].t, rows, dip)
        return
    for i, leg in enumerate(legs):
        rows.less(f"velocity before impact {(i + 1) % n + 1}", leg.v)
        demand(leg.answer.w > 0 or leg.answer.w.is_zero(), "the reset law does not surely return a velocity >= 0")
    demand(isinstance(cuts, list) and len(cuts) == n, "there are not two cuts for every flight")
    for i, leg in enumerate(legs):
        start, end = numbers(cuts[i], 2, f"cuts of flight {i + 1}")
        L = leg.end - leg.t
        demand(start > 0 and end > start and L > end, f"the cuts of flight {i + 1} are not in order")
        resting = legs[i - 1].answer.w.is_zero()
        path = leg.path if not resting else Path(leg.path.flights, leg.t, 0 * start, 0 * start, L)
        first = f"{'acceleration' if resting else 'velocity'} of flight {i + 1} up to its first cut"
        demand(exceeds(path, 0 * start, start, 2 if resting else 1, rows.left(first, ">")), f"{first} is not proven")
        one = dip if dip and dip["flight"] == i + 1 else None
        _check_height(path, f"height of flight {i + 1} between its cuts", start, end, rows, one)
        last = f"velocity of flight {i + 1} after its last cut"
        demand(exceeds(path, end, L.upper(), 1, -rows.left(last, "<"), sign=-1), f"{last} is not proven")


def _check_height(path: Path, name: str, low: arb, high: arb, rows: Inequalities, dip: Any) -> None:
    """Verify y > left on a stretch, but for a dip."""
    floor = rows.left(name, ">")
    if not dip:
        demand(exceeds(path, low, high, 0, floor), f"{name} is not proven")
        return
    one, two = numbers([dip["from"], dip["to"]], 2, "the dip")
    demand(one > low and two > one and high > two, "the dip is not inside its flight")
    demand(exceeds(path, low, one, 0, floor) and exceeds(path, two, high, 0, floor), f"{name} is not proven")


def inside(small: Point, large: Point) -> bool:
    """Return whether a box surely lies in another."""
    return all(bool(a.lower() >= b.lower() and a.upper() <= b.upper()) for a, b in zip(small, large, strict=True))


__all__ = [
    "Leg", "Problem", "Rejected", "applied", "box_of", "check_flights", "inside", "precision_of", "preconditioner",
    "spread",
]  # fmt: skip
