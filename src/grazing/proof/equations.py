"""The equations of a periodic orbit in balls: residual, derivative and multipliers from its flights.

Unknowns are the times t_1 ... t_n of the impacts and the velocities w_1 ... w_n after them; flight i leaves the wall at
(t_i, w_i) and ends at t_{i+1}, the last one at t_1 + N T. The equations are y(end of flight i) = 0 and
w_{i+1} = g(v_i), with v_i the velocity at that end. An orbit without impacts has the unknowns (y, v) at t = 0 and
the equations (y, v)(N T) = (y, v)(0).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from grazing.oscillator.model import Oscillator
from grazing.oscillator.parameters import describe_parameter
from grazing.proof.expression import expression
from grazing.proof.flow import Flow, Moment
from grazing.proof.law import Law

if TYPE_CHECKING:
    from flint import arb

Matrix = list[list["arb"]]
Quadruple = tuple["arb", "arb", "arb", "arb"]


class Leg(NamedTuple):
    """Where a flight starts, how long it is, when it ends, and the derivative of that time by the parameter."""

    t: arb
    y: arb
    w: arb
    L: arb
    end: arb
    late: arb


class Flight(NamedTuple):
    """A flight from start to end, and the impact there: w_next = g(v) with slope and derivative by the parameter."""

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
    model : Oscillator
        The model; its parameters are exact.
    n, N : int
        Impacts, and periods of the forcing.
    name : str, optional
        A parameter that is unknown too: points then have 2n + 1 coordinates (3 for n = 0).
    speeds : sequence of float
        Velocities of the orbit's impacts, about which the law is held against its expression.
    """

    def __init__(
        self, model: Oscillator, n: int, N: int, name: str | None = None, speeds: Sequence[float] = ()
    ) -> None:
        self.model, self.n, self.N, self.name = model, n, N, name
        self.size = 2 * n if n else 2
        self.law_tree = expression(model.reset.law, model.reset.params, tuple(model.params), speeds)
        self._fixed: Flow | None = None

    def flow(self, x: list[arb], derivative: bool = False) -> Flow:
        """Return the flow at the parameters of a point."""
        if self.name is not None:
            return Flow(self.model, self.name, x[self.size], derivative)
        if self._fixed is None:
            self._fixed = Flow(self.model)
        return self._fixed

    def law(self, flow: Flow) -> Law:
        """Return the reset law at the parameters of a flow."""
        return Law(self.law_tree, flow.params, self.name)

    def flights(self, x: list[arb], derivative: bool = False) -> list[Flight]:
        """Return the flights of all points in a small box, each coordinate a ball."""
        flow = self.flow(x, derivative)
        law = self.law(flow)
        made = []
        for leg in self._legs(x, flow):
            arrival = flow.read(flow.fly(flow.start(leg.t, leg.y, leg.w), leg.t, leg.L))
            made.append(self._flight(flow, law, leg, arrival, flow.transition(leg.L)))
        return made

    def wide_flights(self, centre: list[arb], x: list[arb]) -> list[Flight]:
        """Return the flights of all points in a box around a centre, sharp to first order in its size.

        A flight of the box is the one of the centre plus an unforced one, from the difference of the states where it
        starts; so nothing grows along the flight but that difference.
        """
        flow = self.flow(x)
        law = self.law(flow)
        made = []
        for mid, leg in zip(self._legs(centre, flow), self._legs(x, flow), strict=True):
            middle = flow.start(mid.t, mid.y, mid.w)
            beside = flow.read(flow.shifted(middle, leg.t - mid.t))
            after = flow.read(flow.shifted(flow.fly(middle, mid.t, mid.L), leg.end - mid.end))
            E = _product(flow.transition(mid.L), flow.transition_near(leg.L - mid.L))
            dy, dv = leg.y - beside.y, leg.w - beside.v
            y, v = after.y + E[0] * dy + E[1] * dv, after.v + E[2] * dy + E[3] * dv
            made.append(self._flight(flow, law, leg, Moment(y, v, 0 * y, 0 * v), E))
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

    def ordered(self, x: list[arb]) -> bool:
        """Return whether the impacts of a point surely follow each other, and all parameters are allowed."""
        if self.name is not None and not _allowed(self.name, x[self.size]):
            return False
        return all(leg.L > 0 for leg in self._legs(x, self.flow(x)))

    def _legs(self, x: list[arb], flow: Flow) -> list[Leg]:
        from flint import arb

        n, whole, late = self.n, self.N * flow.T, self.N * flow.dT
        if n == 0:
            return [Leg(arb(0), x[0], x[1], whole, whole, late)]
        ends = [*x[1:n], x[0] + whole]
        lates = [arb(0)] * (n - 1) + [late]
        return [Leg(x[i], arb(0), x[n + i], ends[i] - x[i], ends[i], lates[i]) for i in range(n)]

    def _flight(self, flow: Flow, law: Law, leg: Leg, arrival: Moment, E: Quadruple) -> Flight:
        from flint import arb

        y, v, dy, dv = arrival
        push, pull = flow.acceleration(leg.t, leg.y, leg.w), flow.acceleration(leg.end, y, v)
        g, slope, dg = law(v) if self.n else (v, arb(1), arb(0))
        return Flight(leg.t, leg.L, leg.w, y, v, dy + v * leg.late, dv + pull * leg.late, push, pull, E, g, slope, dg)


def _allowed(name: str, value: arb) -> bool:
    """Return whether a parameter surely is in its range."""
    known = describe_parameter(name)
    above = value > known.low if known.open == "low" else value >= known.low
    return bool(above and value <= known.high)


def _product(a: Quadruple, b: Quadruple) -> Quadruple:
    """Return the product of two 2 x 2 matrices, row by row."""
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )
