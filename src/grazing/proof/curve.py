"""A curve of orbits through a small box, one for every value of one coordinate, and the orbits at its ends."""

from __future__ import annotations

from math import frexp
from typing import TYPE_CHECKING, Any, NamedTuple

from grazing.oscillator.sure import Undecided
from grazing.proof.certify import balls
from grazing.proof.krawczyk import Closing, columns, inverse, newton, remainder, replaced, residual_of, without
from grazing.proof.text import short

if TYPE_CHECKING:
    from flint import arb

    Point = list[arb]

#: Half-width of the pinned coordinate, as a power of 1/2, tried before a very small one.
WIDTH = 44


class End(NamedTuple):
    """An orbit at one end of the curve: a box that holds it, the sums of its multipliers, and Krawczyk's test."""

    centre: Point
    radius: Point
    flights: Any
    sums: list[arb]
    test: list[tuple[arb, arb]]


def units_of(equations: Closing, x: Point) -> Point:
    """Return sizes by which boxes are measured where a coordinate is near 0: an eighth of the natural ones, or less.

    They are powers of two; the last one is the parameter's.
    """
    from flint import arb

    sizes = [float(one) for one in equations.scales(x, equations.flights(x))]
    return [arb(2) ** (frexp(size)[1] - 4) for size in (*sizes, equations.unit(x))]


def enclosed_curve(
    equations: Closing, centre: Point, units: Point, pinned: int, bits: int
) -> tuple[list[list[float]], Point, list[list[arb]]]:
    """Return preconditioner, half-widths of a box and the derivative over it, for which Krawczyk's test holds.

    For every value of the pinned coordinate in the box there is then exactly one orbit in it.
    """
    from flint import arb

    thin = equations.jacobian(equations.flights(centre, True))
    C = inverse([without(row, pinned) for row in thin])
    for power in (WIDTH, bits // 4):
        try:
            return C, *_curve_of_width(equations, centre, units, C, pinned, arb(2) ** -power)
        except Undecided:
            if power != WIDTH:
                raise
    raise Undecided


def _curve_of_width(
    equations: Closing, centre: Point, units: Point, C: list[list[float]], pinned: int, share: arb
) -> tuple[Point, list[list[arb]]]:
    """Return half-widths and derivative of :func:`enclosed_curve` for one width of the pinned coordinate."""
    from flint import arb

    width = short(share * (units[pinned] + abs(centre[pinned])), 24)
    radius = [width if i == pinned else arb(0) for i in range(len(centre))]
    rows = equations.jacobian(equations.flights(balls(centre, radius), True))
    moved, _u = curve_image(equations, centre, radius, C, rows, pinned)
    floors = [
        share / 8 * (unit + abs(x)) for x, unit in zip(*(without(a, pinned) for a in (centre, units)), strict=True)
    ]
    radius = replaced(radius, pinned, [short((2 * a + b).upper(), 24) for a, b in zip(moved, floors, strict=True)])
    rows = equations.jacobian(equations.flights(balls(centre, radius), True))
    image = curve_image(equations, centre, radius, C, rows, pinned)
    if not all(a < b for a, b in zip(*image, strict=True)):
        raise Undecided
    return radius, rows


def curve_image(
    equations: Closing, centre: Point, radius: Point, C: list[list[float]], rows: list[list[arb]], pinned: int
) -> tuple[Point, Point]:
    """Return what Krawczyk's operator makes of the half-widths of the free coordinates, and these.

    ``rows`` is the derivative over the box by all coordinates: the pinned one moves the free ones by C times its
    column.
    """
    u = without(radius, pinned)
    moved = residual_of(C, equations, centre, equations.flights(centre))
    turned = columns(C, [row[pinned] for row in rows])
    rest = remainder(C, [without(row, pinned) for row in rows], u)
    image = [a + abs(b).abs_upper() * radius[pinned] + c for a, b, c in zip(moved, turned, rest, strict=True)]
    return image, u


def end_of(
    equations: Closing, centre: Point, radius: Point, C: list[list[float]], rows: list[list[arb]], pinned: int,
    sign: int, bits: int,
) -> End:  # fmt: skip
    """Return the orbit at one end of the curve, in a much smaller box inside the other."""
    from flint import arb

    guess = list(centre)
    guess[pinned] = centre[pinned] + sign * radius[pinned]
    x = [short(a, 3 * bits // 4) if i != pinned else a for i, a in enumerate(newton(equations, guess, pinned))]
    u = without(radius, pinned)
    residual = residual_of(C, equations, x, equations.flights(x))
    factor = max([arb(2) ** -(bits // 4), *(4 * a / b for a, b in zip(residual, u, strict=True))], key=float)
    r = [short(factor.upper() * b, 24) for b in u]
    rest = remainder(C, [without(row, pinned) for row in rows], r)
    image = [a + b for a, b in zip(residual, rest, strict=True)]
    if not all(a < b for a, b in zip(image, r, strict=True)):
        raise Undecided
    free, middle = without(x, pinned), without(centre, pinned)
    if not all(abs(a - b) + c < d for a, b, c, d in zip(free, middle, r, u, strict=True)):
        raise Undecided
    full = replaced([arb(0)] * len(x), pinned, r)
    box = balls(x, full)
    flights = equations.flights(box)
    return End(x, full, flights, equations.sums(box, flights), list(zip(image, r, strict=True)))
