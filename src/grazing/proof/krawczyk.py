"""Newton's method in balls, and the two tests that make its answer a theorem.

With C an approximate inverse of the derivative at a centre c and R = |I - C DF(X)| over a box X of half-widths u:
if R u < u in every row, x -> x - C F(x) contracts on X in the maximum norm weighted by u, so X holds at most one zero;
if |C F(c)| + R r < r for half-widths r <= u, it maps the box c +- r into itself, so that this box holds one (Krawczyk).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from grazing.oscillator.sure import Undecided
from grazing.proof.equations import Matrix
from grazing.proof.flow import Blurred, TooLong

if TYPE_CHECKING:
    from flint import arb

#: Most Newton steps.
STEPS = 14


class Closing(Protocol):
    """Equations of orbits in balls, ``size`` of them; with a ``name`` that parameter is the last coordinate."""

    name: str | None
    size: int

    def flights(self, x: list[arb], derivative: bool = False, /) -> Any:
        """Return the flights of a small box, which the others ask for; ``derivative`` by the parameter, too."""

    def jacobian(self, flights: Any) -> Matrix:
        """Return the derivative of the residual by all coordinates."""

    def residual(self, x: list[arb], flights: Any) -> list[arb]:
        """Return the left-hand sides, 0 at an orbit."""

    def ordered(self, x: list[arb]) -> bool:
        """Return whether the impacts of a point surely follow each other, and all parameters are allowed."""

    def scales(self, x: list[arb], flights: Any) -> list[arb]:
        """Return the natural scale of each coordinate but the parameter."""

    def unit(self, x: list[arb]) -> float:
        """Return the natural scale of the parameter."""

    def sums(self, x: list[arb], flights: Any) -> list[arb]:
        """Return what decides the multipliers: their sums and products."""


class NoConvergence(ArithmeticError):
    """Newton's method does not converge from the guess."""


def inverse(rows: Matrix) -> list[list[float]]:
    """Return an approximate inverse of the midpoints, in doubles; raise Undecided if they are singular."""
    from flint import arb_mat

    try:
        inverted = arb_mat([[x.mid() for x in row] for row in rows]).inv()
    except ZeroDivisionError:
        raise Undecided from None
    return [[float(inverted[i, j].mid()) for j in range(len(rows))] for i in range(len(rows))]


def without(row: list[arb], pinned: int | None) -> list[arb]:
    """Return a row of coordinates without the pinned one."""
    return row if pinned is None else row[:pinned] + row[pinned + 1 :]


def replaced(x: list[arb], pinned: int | None, free: list[arb]) -> list[arb]:
    """Return a point with other free coordinates."""
    return free if pinned is None else [*free[:pinned], x[pinned], *free[pinned:]]


def newton(equations: Closing, x: list[arb], pinned: int | None = None) -> list[arb]:
    """Return the zero near x to working precision, as midpoints; the pinned coordinate stays.

    Raises
    ------
    NoConvergence
        If the steps do not shrink, or impacts change their order.
    TooLong
        If the flights of x have too many time scales; as Blurred, if no digit of what must vanish is left.
    """
    from flint import arb, arb_mat, ctx

    x = [a.mid() for a in x]
    small = arb(2) ** (16 - ctx.prec // 2)  # convergence is quadratic: the next error is its square
    for count in range(STEPS):
        if not all(a.is_finite() for a in x) or not equations.ordered(x):
            break
        try:
            flights = equations.flights(x, equations.name is not None and pinned != equations.size)
        except TooLong:
            if count:
                break
            raise
        rows = [without(row, pinned) for row in equations.jacobian(flights)]
        values = equations.residual(x, flights)
        try:
            step = arb_mat([[a.mid() for a in row] for row in rows]).solve(arb_mat([[-a.mid()] for a in values]))
        except ZeroDivisionError:
            break
        change = [step[i, 0].mid() for i in range(len(values))]
        x = replaced(x, pinned, [(a + b).mid() for a, b in zip(without(x, pinned), change, strict=True)])
        size = max((abs(a) for a in change), key=float)
        if size <= small * (1 + max(float(abs(a)) for a in x)):
            return x
        if all(a.contains(0) for a in values):
            raise Blurred
    raise NoConvergence


def columns(C: list[list[float]], values: list[arb]) -> list[arb]:
    """Return C times a vector."""
    from flint import arb

    return [sum((arb(c) * x for c, x in zip(row, values, strict=True)), arb(0)) for row in C]


def remainder(C: list[list[float]], rows: Matrix, u: list[arb]) -> list[arb]:
    """Return |I - C DF| u, row by row."""
    from flint import arb

    size, result = len(C), []
    for i in range(size):
        total = arb(0)
        for j in range(size):
            entry = sum((arb(C[i][m]) * rows[m][j] for m in range(size)), arb(0))
            total += abs((i == j) - entry).abs_upper() * u[j]
        result.append(total)
    return result


def contraction(C: list[list[float]], rows: Matrix, u: list[arb]) -> arb:
    """Return the contraction rate on a box of half-widths u, from the derivative over the box."""
    return max(
        ((a / b).abs_upper() for a, b in zip(remainder(C, rows, u), u, strict=True)),
        key=lambda x: float(x) if x.is_finite() else float("inf"),
    )


def residual_of(C: list[list[float]], equations: Closing, x: list[arb], flights: Any) -> list[arb]:
    """Return |C F| at a point, upper bounds."""
    return [a.abs_upper() for a in columns(C, equations.residual(x, flights))]
