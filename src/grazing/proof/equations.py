"""The equations of a periodic orbit in balls: residual, derivative and multipliers from its flights.

Unknowns are the times t_1 ... t_n of the impacts and the velocities w_1 ... w_n after them; flight i leaves the wall
at (t_i, w_i) and ends at t_{i+1}, the last one at t_1 + N T. The equations are y(end of flight i) = 0 and w_{i+1} =
g(v_i), with v_i the velocity at that end. Heights and velocities are those that a wall sees, at the start of a flight
the one that it leaves and at its end the one that it meets. An orbit without impacts has the unknowns (y, v) at t = 0,
as the first wall sees them, and the equations (y, v)(N T) = (y, v)(0).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from grazing.oscillator.rig import Rig
from grazing.proof.expression import expression
from grazing.proof.flow import Flow, Moment
from grazing.proof.law import Law
from grazing.proof.seen import Dual, alone

if TYPE_CHECKING:
    from flint import arb

Matrix = list[list["arb"]]
Quadruple = tuple["arb", "arb", "arb", "arb"]


class Leg(NamedTuple):
    """The walls at both ends of a flight, where it starts, how long it is, when it ends, and that by the parameter."""

    one: int
    two: int
    t: arb
    y: arb
    w: arb
    L: arb
    end: arb
    late: arb


class Flight(NamedTuple):
    """A flight from start to end, and the impact there: w_next = g(v) with slope and derivative by the parameter.

    w and ``push`` are as wall ``one`` sees them, which it leaves; all else is what wall ``two`` sees, which it meets. E
    takes what the one sees of an unforced flight at the start to what the other sees at the end.
    """

    one: int
    two: int
    t: arb
    L: arb
    w: arb
    y: arb
    v: arb
    dy: arb
    dv: arb
    push: arb  # acceleration at the start
    pull: arb  # acceleration at the end
    E: Quadruple
    g: arb
    slope: arb
    dg: arb


class Equations:
    """The equations of orbits with n impacts in N periods; a named parameter is the last coordinate of a point.

    Parameters
    ----------
    model : Rig
        The model; its parameters are exact.
    n, N : int
        Impacts, and periods of the forcing.
    name : str, optional
        A parameter that is unknown too: points then have 2n + 1 coordinates (3 for n = 0).
    speeds : sequence of float
        Velocities of the orbit's impacts, about which the laws are held against their expressions.
    hits : sequence of int
        The walls of the impacts, by their numbers; the first one unless said.
    """

    def __init__(
        self, model: Rig, n: int, N: int, name: str | None = None, speeds: Sequence[float] = (),
        hits: Sequence[int] = (),
    ) -> None:  # fmt: skip
        self.model, self.n, self.N, self.name = model, n, N, name
        self.hits = tuple(hits) or (0,) * n
        self.size = 2 * n if n else 2
        self.trees = [expression(one.reset.law, one.reset.params, tuple(one.params), speeds) for one in model.seen]
        self._fixed: dict[int, Flow] = {}

    @property
    def walls(self) -> range:
        """The numbers of the walls."""
        return range(len(self.trees))

    def flow(self, x: list[arb], derivative: bool = False, wall: int = 0) -> Flow:
        """Return the flow that a wall sees, at the parameters of a point."""
        if self.name is not None:
            return Flow(self.model, self.name, x[self.size], derivative, wall)
        if wall not in self._fixed:
            self._fixed[wall] = Flow(self.model, wall=wall)
        return self._fixed[wall]

    def scales(self, x: list[arb], flights: list[Flight]) -> list[arb]:
        """Return the natural scale of each coordinate of an orbit but the parameter."""
        from flint import arb

        flow = self.flow(x)
        speed = arb(max(max(float(abs(f.w)), float(abs(f.v))) for f in flights) or 1.0)
        if self.n == 0:
            speed = max(speed, abs(x[0]) * flow.scale, key=float)
            return [speed / flow.scale, speed]
        return [1 / flow.scale] * self.n + [speed] * self.n

    def flows(self, x: list[arb], derivative: bool = False) -> list[Flow]:
        """Return the flow of every wall."""
        return [self.flow(x, derivative, wall) for wall in self.walls]

    def laws(self, flow: Flow) -> list[Law]:
        """Return the reset laws of the walls at the parameters of a flow."""
        return [Law(tree, *flow.seen.law(j)) for j, tree in enumerate(self.trees)]

    def flights(self, x: list[arb], derivative: bool = False) -> list[Flight]:
        """Return the flights of all points in a small box, each coordinate a ball."""
        flows = self.flows(x, derivative)
        made = []
        for leg in self._legs(x, flows[0]):
            flow = flows[leg.one]
            z = flow.fly(flow.start(leg.t, leg.y, leg.w), leg.t, leg.L)
            made.append(self._flight(flows, leg, _met(flow, leg, leg.end, flow.read(z)), flow.transition(leg.L)))
        return made

    def wide_flights(self, centre: list[arb], x: list[arb]) -> list[Flight]:
        """Return the flights of all points in a box around a centre, sharp to first order in its size.

        A flight of the box is the one of the centre plus an unforced one, from the difference of the states where it
        starts; so nothing grows along the flight but that difference. The centre's is taken as the wall sees it that
        is met, before it is flown to the ends of the others.
        """
        flows = self.flows(x)
        made = []
        for mid, leg in zip(self._legs(centre, flows[0]), self._legs(x, flows[0]), strict=True):
            left, met = flows[leg.one], flows[leg.two]
            middle = left.start(mid.t, mid.y, mid.w)
            beside = left.read(left.shifted(middle, leg.t - mid.t))
            there = _met(left, mid, mid.end, left.read(left.fly(middle, mid.t, mid.L)))
            after = met.read(met.shifted(met.start(mid.end, there.y, there.v), leg.end - mid.end))
            E = _product(left.transition(mid.L), left.transition_near(leg.L - mid.L))
            turn = left.seen.turn(leg.one, leg.two)
            dy, dv = turn * (leg.y - beside.y), turn * (leg.w - beside.v)
            y, v = after.y + E[0] * dy + E[1] * dv, after.v + E[2] * dy + E[3] * dv
            made.append(self._flight(flows, leg, Moment(y, v, 0 * y, 0 * v), E))
        return made

    def residual(self, x: list[arb], flights: list[Flight]) -> list[arb]:
        """Return the left-hand sides, 0 at an orbit."""
        n = self.n
        if n == 0:
            return [flights[0].y - x[0], flights[0].v - x[1]]
        return [f.y for f in flights] + [x[n + (i + 1) % n] - f.g for i, f in enumerate(flights)]

    def jacobian(self, flights: list[Flight]) -> Matrix:
        """Return the derivative of the residual by all coordinates; the parameter's column needs its derivatives."""
        from flint import arb

        n, size = self.n, self.size
        rows = [[arb(0)] * (size + (self.name is not None)) for _ in range(size)]
        if n == 0:
            (f,) = flights
            rows[0][:2], rows[1][:2] = [f.E[0] - 1, f.E[1]], [f.E[2], f.E[3] - 1]
            if self.name is not None:
                rows[0][2], rows[1][2] = f.dy, f.dv
            return rows
        for i, f in enumerate(flights):
            after = (i + 1) % n
            by_start = -(f.E[0] * f.w + f.E[1] * f.push), -(f.E[2] * f.w + f.E[3] * f.push)
            height, jump = rows[i], rows[n + i]
            height[i] += by_start[0]
            height[after] += f.v
            height[n + i] += f.E[1]
            jump[i] -= f.slope * by_start[1]
            jump[after] -= f.slope * f.pull
            jump[n + i] -= f.slope * f.E[3]
            jump[n + after] += 1
            if self.name is not None:
                height[size] = f.dy
                jump[size] = -(f.slope * f.dv + f.dg)
        return rows

    def trace_and_det(self, flights: list[Flight], flow: Flow) -> tuple[arb, arb]:
        """Return trace and determinant of the derivative of the return map, by flights and saltation matrices."""
        det = (-flow.alpha * self.N * flow.T).exp()
        if self.n == 0:
            return flights[0].E[0] + flights[0].E[3], det
        J = None
        for i, f in enumerate(flights):
            w = flights[(i + 1) % self.n].w
            # S = [[w/v, 0], [(a_plus - g' a_minus)/v, g']]; F = pull + alpha v at the wall
            F = f.pull + flow.alpha * f.v
            lower = ((F - flow.alpha * w) - f.slope * f.pull) / f.v
            turn = _product((w / f.v, 0 * w, lower, f.slope), f.E)
            J = turn if J is None else _product(turn, J)
            det = det * f.slope * w / f.v
        assert J is not None
        return J[0] + J[3], det

    def unit(self, _x: list[arb]) -> float:
        """Return the natural scale of the parameter."""
        assert self.name is not None
        return self.model.unit_of(self.name)

    def sums(self, x: list[arb], flights: list[Flight]) -> list[arb]:
        """Return trace and determinant."""
        return list(self.trace_and_det(flights, self.flow(x)))

    def ordered(self, x: list[arb]) -> bool:
        """Return whether the impacts of a point surely follow each other, and all parameters are allowed."""
        if self.name is not None and not _allowed(self.model, self.name, x[self.size]):
            return False
        return all(leg.L > 0 for leg in self._legs(x, self.flow(x)))

    def _legs(self, x: list[arb], flow: Flow) -> list[Leg]:
        from flint import arb

        n, whole, late = self.n, self.N * flow.T, self.N * flow.dT
        if n == 0:
            return [Leg(0, 0, arb(0), x[0], x[1], whole, whole, late)]
        ends = [*x[1:n], x[0] + whole]
        lates = [arb(0)] * (n - 1) + [late]
        to = (*self.hits[1:], self.hits[0])
        return [Leg(self.hits[i], to[i], x[i], arb(0), x[n + i], ends[i] - x[i], ends[i], lates[i]) for i in range(n)]

    def _flight(self, flows: list[Flow], leg: Leg, arrival: Moment, E: Quadruple) -> Flight:
        from flint import arb

        y, v, dy, dv = arrival
        left, met = flows[leg.one], flows[leg.two]
        push, pull = left.acceleration(leg.t, leg.y, leg.w), met.acceleration(leg.end, y, v)
        g, slope, dg = self.laws(met)[leg.two](v) if self.n else (v, arb(1), arb(0))
        turn = left.seen.turn(leg.one, leg.two)
        E = tuple(turn * e for e in E)  # type: ignore[assignment]
        return Flight(
            leg.one, leg.two, leg.t, leg.L, leg.w, y, v, dy + v * leg.late, dv + pull * leg.late, push, pull, E, g,
            slope, dg,
        )  # fmt: skip


def _met(flow: Flow, leg: Leg, t: arb, end: Moment) -> Moment:
    """Return what the wall sees that a flight meets at time t, of what the wall sees that it left."""
    y, v = flow.seen.across(leg.one, leg.two, t, Dual(end.y, end.dy), Dual(end.v, end.dv))
    return Moment(y.x, v.x, y.d, v.d)


def _allowed(model: Rig, name: str, value: arb) -> bool:
    """Return whether a parameter surely is in its range."""
    known = model.describe(name)
    low = max(known.low, 0.0) if name == "alpha" and alone(model) else known.low
    above = value > low if known.open == "low" else value >= low
    return bool(above and value <= known.high)


def _product(a: Quadruple, b: Quadruple) -> Quadruple:
    """Return the product of two 2 x 2 matrices, row by row."""
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )
