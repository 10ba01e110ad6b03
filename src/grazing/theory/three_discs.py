"""The cycles of three equal discs at the corners of an equilateral triangle, to any number of digits."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import Decimal, getcontext, localcontext

from grazing.outcome import InputError, shown
from grazing.theory.cycles import DOUBLE, SPARE, Cycle

#: Sweeps towards a shortest way, and Newton steps for it.
SWEEPS, STEPS = 12, 60
#: Ratios below which some words of three discs have no orbit: K. T. Hansen, Nonlinearity 6 (1993) 753-769.
PRUNED = 2.0482142

Vector = tuple[Decimal, Decimal]
#: A point of a unit circle about the origin, and the tangent there.
Place = tuple[Vector, Vector]


def primitive_words(length: int) -> Iterable[tuple[int, ...]]:
    """Yield the words of 0 and 1 of a length that repeat nothing shorter and come first among their rotations."""
    for code in range(2**length):
        w = tuple(code >> i & 1 for i in reversed(range(length)))
        if all(w < w[k:] + w[:k] for k in range(1, length)):
            yield w


def three_disc_cycles(ratio: float, length: int, digits: int = DOUBLE) -> tuple[Cycle, ...]:
    """Return the cycles of three equal discs at the corners of an equilateral triangle, with their symmetry taken out.

    Parameters
    ----------
    ratio : float
        Distance of the centres in radii, R : a > 2.0482142; below some words have no orbit.
    length : int
        Most impacts of a cycle, 1 to 16.
    digits : int
        To which they are solved, 5 to 1000.

    Returns
    -------
    tuple of Cycle
        One for each word of 0, back to the disc before, and 1, on to the third one: the motion in a sixth of the plane,
        of which six copies, rotated and mirrored, make the whole. In units of the radius, at speed 1. What escapes
        slowest has the symmetry of the discs, so that these cycles give the same rate as those of the whole plane, with
        half as many impacts for as many digits.

    Raises
    ------
    InputError
        For values out of range.

    Notes
    -----
    A cycle is the shortest way from a disc to itself, turned or mirrored, over the discs of its word; Newton's method
    in the places of its impacts, which are points of the unit circle. Its time is its length, and its multiplier that
    of the product of (1, l; 0, 1) for flights and -(1, 0; 2/cos(phi), 1) for impacts, with the sign of the symmetry.

    Examples
    --------
    >>> import grazing as gz
    >>> one, other = gz.theory.three_disc_cycles(6.0, 1, digits=15)
    >>> print(round(one.time, 12), round(one.transverse[0], 12), round(other.time, 12), round(other.transverse[0], 11))
    4.000000000000 9.898979485566 4.267949192431 -11.77145519639
    """
    size = float(ratio) if isinstance(ratio, int | float) and not isinstance(ratio, bool) else float("nan")
    if not PRUNED < size < float("inf"):
        raise InputError(f"ratio is {shown(ratio)}; allowed are numbers > {PRUNED}: below some words have no orbit")
    for name, value, low, high in (("length", length, 1, 16), ("digits", digits, 5, 1000)):
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise InputError(f"{name} is {shown(value)}; allowed is a whole number from {low} to {high}")
    with localcontext() as context:
        context.prec = digits + SPARE
        found = [_cycle(word, Decimal(size)) for n in range(1, length + 1) for word in primitive_words(n)]
        context.prec = digits
        return tuple(Cycle(one.period, +one.time, tuple(+root for root in one.transverse)) for one in found)


class _Way:
    """The closed ways of a word: the discs that they visit, from 1, where they come from 0, and what closes them."""

    def __init__(self, word: Sequence[int], R: Decimal) -> None:
        far = R / Decimal(3).sqrt()
        self.centres = ((Decimal(0), far), (-R / 2, -far / 2), (R / 2, -far / 2))
        self.discs, before = [1], 0
        for symbol in word:
            before, after = self.discs[-1], before if symbol == 0 else 3 - before - self.discs[-1]
            self.discs.append(after)
        self.n, self.R, self.first = len(word), R, before
        (ax, ay), (bx, by) = self.centres[0], self.centres[1]
        (cx, cy), (dx, dy) = self.centres[before], self.centres[self.discs[-1]]
        area = ax * by - ay * bx
        # the symmetry that takes disc 0 to the last but one, and disc 1 to the last
        self.turn = tuple(
            x for p, q in ((cx, dx), (cy, dy)) for x in ((p * by - q * ay) / area, (q * ax - p * bx) / area)
        )
        self.sign = 1 if self.turn[0] * self.turn[3] - self.turn[1] * self.turn[2] > 0 else -1

    def guess(self) -> list[Place]:
        """Return places near those of the shortest way, by sweeps in which each halves the angle to its neighbours."""
        zero = Decimal(0), Decimal(0)
        found = [(zero, zero)] * self.n  # the centres
        for _ in range(SWEEPS):
            for i in range(self.n):
                (bx, by), (ax, ay) = self.seen(found, i)
                far, near = (ax * ax + ay * ay).sqrt(), (bx * bx + by * by).sqrt()
                x, y = ax / far + bx / near, ay / far + by / near
                size = (x * x + y * y).sqrt()
                found[i] = (x / size, y / size), (-y / size, x / size)
        return found

    def seen(self, places: Sequence[Place], i: int) -> tuple[Vector, Vector]:
        """Return the places before and after one, from the centre of its disc."""
        (cx, cy), (nx, ny) = self.centres[self.discs[i]], self.centres[self.discs[i + 1]]
        (ex, ey), _tangent = self.ends(places, i)[1]
        after = nx + ex - cx, ny + ey - cy
        if i > 0:
            (px, py), ((ex, ey), _tangent) = self.centres[self.discs[i - 1]], places[i - 1]
            return (px + ex - cx, py + ey - cy), after
        a, b, c, d = self.turn  # the last leg, turned back
        (px, py), ((ex, ey), _tangent) = self.centres[self.discs[self.n - 1]], places[-1]
        x, y = px + ex, py + ey
        return (a * x + c * y - cx, b * x + d * y - cy), after

    def ends(self, places: Sequence[Place], i: int) -> tuple[Place, Place]:
        """Return the places between which leg i goes; the last one goes to the image of the first place."""
        if i + 1 < self.n:
            return places[i], places[i + 1]
        (ex, ey), (tx, ty) = places[0]
        a, b, c, d = self.turn
        return places[i], ((a * ex + b * ey, c * ex + d * ey), (a * tx + b * ty, c * tx + d * ty))

    def leg(self, one: Place, other: Place, i: int) -> tuple[Decimal, Decimal, Decimal]:
        """Return the vector from the end of leg i back to its begin, and its length."""
        (cx, cy), (dx, dy) = self.centres[self.discs[i]], self.centres[self.discs[i + 1]]
        x, y = cx + one[0][0] - dx - other[0][0], cy + one[0][1] - dy - other[0][1]
        return x, y, (x * x + y * y).sqrt()

    def slopes(self, places: Sequence[Place]) -> tuple[list[Decimal], list[list[Decimal]]]:
        """Return first and second derivatives of the length by the angles of the places."""
        n = self.n
        first, second = [Decimal(0)] * n, [[Decimal(0)] * n for _ in range(n)]
        for i in range(n):
            k = (i + 1) % n
            one, other = self.ends(places, i)
            x, y, length = self.leg(one, other, i)
            (ex, ey), (tx, ty) = one
            (fx, fy), (ux, uy) = other
            a, b = (x * tx + y * ty) / length, -(x * ux + y * uy) / length
            first[i] += a
            first[k] += b
            second[i][i] += (1 - a * a - x * ex - y * ey) / length
            second[k][k] += (1 - b * b + x * fx + y * fy) / length
            cross = -(tx * ux + ty * uy + a * b) / length
            second[i][k] += cross
            second[k][i] += cross
        return first, second

    def cycle(self, places: Sequence[Place]) -> Cycle:
        """Return length and multipliers of the shortest way."""
        total, m = Decimal(0), (Decimal(1), Decimal(0), Decimal(0), Decimal(1))
        for i in range(self.n):
            one, other = self.ends(places, i)
            x, y, length = self.leg(one, other, i)
            kick = 2 * length / abs(x * other[0][0] + y * other[0][1])
            a, b, c, d = m
            a, b = a + length * c, b + length * d
            m = -a, -b, -(c + kick * a), -(d + kick * b)
            total += length
        trace = (m[0] + m[3]) * self.sign
        root = (abs(trace) + (trace * trace - 4).sqrt()) / 2
        root = root if trace > 0 else -root
        return Cycle(self.n, total, (root, 1 / root))


def solved(rows: list[list[Decimal]], right: list[Decimal]) -> list[Decimal]:
    """Solve a symmetric positive definite system by elimination, which needs no pivots."""
    n, rows, right = len(right), [list(row) for row in rows], list(right)
    for i in range(n):
        for j in range(i + 1, n):
            share = rows[j][i] / rows[i][i]
            if share:
                for k in range(i, n):
                    rows[j][k] -= share * rows[i][k]
                right[j] -= share * right[i]
    x = [Decimal(0)] * n
    for i in reversed(range(n)):
        x[i] = (right[i] - sum((rows[i][k] * x[k] for k in range(i + 1, n)), Decimal(0))) / rows[i][i]
    return x


def turned(place: Place, by: Decimal) -> Place:
    """Return a place moved by an angle, to third order in that, and exactly on the circle."""
    half = by / 2
    size = 1 + half * half
    c, s = (1 - half * half) / size, by / size
    (ex, ey), _tangent = place
    x, y = c * ex - s * ey, s * ex + c * ey
    size = (x * x + y * y).sqrt()
    return (x / size, y / size), (-y / size, x / size)


def _cycle(word: tuple[int, ...], R: Decimal) -> Cycle:
    """Return the cycle of a word, to the precision at hand."""
    way = _Way(word, R)
    places, small = way.guess(), Decimal(10) ** -(getcontext().prec // 2 + 2)  # the next error is about its square
    for _ in range(STEPS):
        first, second = way.slopes(places)
        moves = solved(second, first)
        longest = max(map(abs, moves))
        share = min(Decimal(1), Decimal("0.5") / longest) if longest else Decimal(1)
        places = [turned(place, -share * move) for place, move in zip(places, moves, strict=True)]
        if longest < small:
            return way.cycle(places)
    raise ArithmeticError(f"Newton's method did not find the cycle of {word}")
