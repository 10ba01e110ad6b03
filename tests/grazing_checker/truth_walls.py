"""The oscillator with walls of its own, for :mod:`tests.grazing_checker.truth`: flown in u, and not as a wall sees it.

A state holds u, u', 1 and the cosines and sines of the force. A wall's distance is then a fixed row times the state,
and its rate that row times M. Derivatives are difference quotients.
"""

from functools import lru_cache
from itertools import pairwise

import numpy as np
from mpmath import mp, mpf

TINY = mpf(10) ** -15
#: Bits of an exponential beyond those that are asked for.
GUARD = 192


def entries_of(M):
    """The rows of a matrix, by which its exponentials are remembered."""
    return tuple(map(tuple, M.tolist()))


@lru_cache(maxsize=256)
def exponential(entries, t):
    """The exponential of a matrix times t: Newton's method asks for the same flights again and again.

    By its series and squaring, in whole numbers of 2^-bits, as matrices of mpmath take several times as long.
    """
    bits, n = mp.prec + GUARD, range(len(entries))
    with mp.workprec(bits):
        size = max(sum(abs(x) for x in row) for row in entries) * abs(t)
        halvings = max(int(mp.ceil(mp.log(size, 2))), 0) + 8 if size else 0  # as many more as save terms of the series
        part = [[int(mp.floor(mp.ldexp(x * t, bits - halvings))) for x in row] for row in entries]

    def product(a, b):
        columns = list(zip(*b, strict=True))
        return [[sum(x * y for x, y in zip(row, column, strict=True) if x) >> bits for column in columns] for row in a]

    total = term = [[(i == j) << bits for j in n] for i in n]
    k = 0
    while any(abs(x) > 1 for row in term for x in row):  # -1 is what rounding down leaves of little
        k += 1
        term = [[x // k for x in row] for row in product(term, part)]
        total = [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)]
    for _ in range(halvings):
        total = product(total, total)
    return mp.matrix([[mp.ldexp(mpf(x), -bits) for x in row] for row in total])


class WalledRig:
    """The model of a certificate of an orbit with walls."""

    def __init__(self, data, hold, tree, value=None):
        def number(text):
            return value if text is None else mpf(float.fromhex(text))

        model = data["model"]
        self.hold, self.tree, self.walls = hold, tree, data["walls"]
        alpha, omega, t0, offset = (number(model[name]) for name in ("alpha", "omega", "t0", "offset"))
        k2 = number(model["stiffness"]) if "stiffness" in model else number(model["k"]) ** 2
        self.omega, self.t0 = omega, t0
        self.cos, self.sin = ([number(x) for x in model[name]] for name in ("cos", "sin"))
        self.signs = [1 if wall["side"] == "below" else -1 for wall in self.walls]
        self.names = [wall["name"] for wall in self.walls]
        self.hits = [self.names.index(name) for name in data["impacts"]]
        self.n, self.N = len(self.hits), data["periods"]
        self.turn = self.N * 2 * mp.pi / omega
        self.H = max(len(self.cos), *(len(wall["cos"]) for wall in self.walls))
        M = mp.zeros(3 + 2 * self.H)
        M[0, 1], M[1, 0], M[1, 1], M[1, 2] = 1, -k2, -alpha, offset
        for j in range(self.H):
            W = (j + 1) * omega
            M[3 + 2 * j, 4 + 2 * j], M[4 + 2 * j, 3 + 2 * j] = -W, W
            if j < len(self.cos):
                M[1, 3 + 2 * j], M[1, 4 + 2 * j] = self.cos[j], self.sin[j]
        self.M, self.rows, self.entries = M, [], entries_of(M)
        self.laws = [{name: number(text) for name, text in w["law"]["parameters"].items()} for w in self.walls]
        for sign, wall in zip(self.signs, self.walls, strict=True):
            row = mp.zeros(1, 3 + 2 * self.H)
            row[0], row[2] = sign, -sign * number(wall["sigma"])
            for j, (c, s) in enumerate(zip(wall["cos"], wall["sin"], strict=True)):
                row[3 + 2 * j], row[4 + 2 * j] = -sign * number(c), -sign * number(s)
            self.rows.append(row)
        self.middle = sum(number(wall["sigma"]) for wall in self.walls)

    def flow(self, t):
        """The exponential of M t."""
        return exponential(self.entries, t)

    def seen(self, wall, z):
        """Distance from a wall and its rate."""
        row = self.rows[wall]
        return (row * z)[0], (row * self.M * z)[0]

    def leaving(self, wall, t, x, w):
        """The state at distance x from a wall, with a velocity relative to it and away from it."""
        z = mp.matrix([mpf(0), mpf(0), mpf(1), *(mpf(0) for _ in range(2 * self.H))])
        for j in range(self.H):
            phase = (j + 1) * self.omega * (t + self.t0)
            z[3 + 2 * j], z[4 + 2 * j] = mp.cos(phase), mp.sin(phase)
        at, rate = self.seen(wall, z)
        sign = self.signs[wall]
        z[0] = sign * (x - at)
        rate = self.seen(wall, z)[1]  # of a ball at rest there
        z[1] = sign * (w - rate)
        return z

    def law_of(self, wall, v):
        return self.tree(self.walls[wall]["law"]["after"], v, self.laws[wall])

    def flights(self, x):
        """Walls at both ends, the state at the start, the length and the state at the end of every flight."""
        n = self.n
        if n == 0:
            z = self.leaving(0, mpf(0), x[0], x[1])
            return [(0, 0, z, self.turn, self.flow(self.turn) * z)]
        ends, made = [*x[1:n], x[0] + self.turn], []
        for i in range(n):
            L, z = ends[i] - x[i], self.leaving(self.hits[i], x[i], mpf(0), x[n + i])
            self.hold(0 < L < 2 * self.turn, "the impacts are not in the order of time")
            made.append((self.hits[i], self.hits[(i + 1) % n], z, L, self.flow(L) * z))
        return made

    def incoming(self, x):
        return [self.seen(two, end)[1] for _one, two, _z, _L, end in self.flights(x)] if self.n else []

    def equations(self, x):
        flights = self.flights(x)
        if self.n == 0:
            y, v = self.seen(0, flights[0][4])
            return [y - x[0], v - x[1]]
        ends = [self.seen(two, end) for _one, two, _z, _L, end in flights]
        laws = [self.law_of(one[1], v) for one, (_y, v) in zip(flights, ends, strict=True)]
        after = [x[self.n + (i + 1) % self.n] for i in range(self.n)]
        return [y for y, _v in ends] + [w - g for w, g in zip(after, laws, strict=True)]

    def trace_and_det(self, x):
        """Of the map from (time, velocity) after one impact to the next, by difference quotients."""
        if self.n == 0:
            E = self.flow(self.turn)
            return E[0, 0] + E[1, 1], E[0, 0] * E[1, 1] - E[0, 1] * E[1, 0]
        total, n = mp.eye(2), self.n
        for i in range(n):
            one, two = self.hits[i], self.hits[(i + 1) % n]
            at = [x[i], x[n + i], x[i + 1] if i + 1 < n else x[0] + self.turn]

            def leg(t, w, end, one=one, two=two):
                y, v = self.seen(two, self.flow(end - t) * self.leaving(one, t, mpf(0), w))
                return mp.matrix([y, self.law_of(two, v)])

            slopes, speed = [], abs(at[1]) + abs(self.seen(two, self.flights(x)[i][4])[1])
            for c, d in enumerate((TINY * self.turn, TINY * speed, TINY * self.turn)):
                ahead, behind = ([a + e * (k == c) for k, a in enumerate(at)] for e in (d, -d))
                slopes.append((leg(*ahead) - leg(*behind)) / (2 * d))
            by_t, by_w, by_end = slopes
            lates = [-by_t[0] / by_end[0], -by_w[0] / by_end[0]]
            rows = [lates, [by_t[1] + by_end[1] * lates[0], by_w[1] + by_end[1] * lates[1]]]
            total = mp.matrix(rows) * total
        return total[0, 0] + total[1, 1], total[0, 0] * total[1, 1] - total[0, 1] * total[1, 0]

    def off_the_walls(self, x, dip=None, count=400):
        """Every impact from its own side, and no distance that is 0 between: on a grid, and each dip to all digits.

        Where a dip is to touch a wall, its flight may be a rounding inside that.
        """
        touching = (dip["flight"] - 1, self.names.index(dip["wall"])) if dip else None
        for i, (one, two, z, L, end) in enumerate(self.flights(x)):
            if self.n:
                v = self.seen(two, end)[1]
                self.hold(v < 0, "an impact does not arrive from the wall's own side")
                self.hold(self.law_of(two, v) >= 0, "the law returns a velocity into the wall")
            step = np.array(self.flow(L / count).tolist(), dtype=float)
            states = [np.array(z.tolist(), dtype=float)[:, 0]]
            for _ in range(count):
                states.append(step @ states[-1])
            for wall, row in enumerate(self.rows):
                of, rate = (np.array(r.tolist(), dtype=float)[0] for r in (row, row * self.M))
                inner = states[1 if self.n and wall == one else 0 : -1 if self.n and wall == two else None]
                least = -1e-10 if touching == (i, wall) else 0
                self.hold(min(float(of @ s) for s in inner) > least, f"flight {i + 1} meets wall {self.names[wall]}")
                rates = [float(rate @ s) for s in states]
                if self.n and wall == one:
                    rates[0] = max(rates[0], 0.0)  # w = 0 is a rounding below 0 in floats, and no dip
                for j, (a, b) in enumerate(pairwise(rates)):
                    if a < 0 < b:
                        low = self.lowest(wall, z, L * (j + mpf(0.5)) / count)
                        self.hold(low > least, f"flight {i + 1} meets wall {self.names[wall]} in a dip")

    def height_of(self, x, dip, time):
        """The height of the local minimum that is near a time of a flight."""
        return self.lowest(self.names.index(dip["wall"]), self.flights(x)[dip["flight"] - 1][2], time)

    def lowest(self, wall, z, time):
        row = self.rows[wall]
        for _ in range(60):
            here = self.flow(time) * z
            step = (row * self.M * here)[0] / (row * self.M * self.M * here)[0]
            time -= step
            if abs(step) < mpf(10) ** -25:
                break
        return (row * (self.flow(time) * z))[0]

    def steps(self, x):
        """Wall, time and the ball's own velocity after every impact."""
        flights = self.flights(x)
        return [(one, x[i], z[1]) for i, (one, _two, z, _L, _end) in enumerate(flights)] if self.n else []

    def position(self, x, t):
        """u at a time within the period of the orbit."""
        starts = [*x[: self.n], x[0] + self.turn] if self.n else [mpf(0), self.turn]
        t = starts[0] + (t - starts[0]) % self.turn
        i = max(k for k in range(len(starts) - 1) if starts[k] <= t)
        return (self.flow(t - starts[i]) * self.flights(x)[i][2])[0]

    def hold_symmetry(self, x):
        start = x[0] if self.n else mpf(0)
        for share in (0.013, 0.21, 0.377, 0.54, 0.71, 0.93):
            t = start + share * self.turn
            off = self.position(x, t + self.turn / 2) + self.position(x, t) - self.middle
            self.hold(abs(off) < mpf(10) ** -20, "it is not its own mirror image")
