"""Whether the statement of a certificate is true: by numbers of 36 digits, and by other means than finder and checker.

Flights are exponentials of the linear system with its forcing as further states, orbits come from Newton's method, and
the gap map is iterated. Nothing of grazing_checker is used, and of the certificate only what its sentence is made of.
"""

from functools import cache, partial
from itertools import pairwise

import numpy as np
from mpmath import mp, mpf

from grazing import theory
from tests.grazing_checker import truth_table
from tests.grazing_checker.truth_walls import WalledRig, entries_of, exponential

word_edges = cache(theory.word_edges)
DIGITS = 36
TINY = mpf(10) ** -30


def is_true(kind, data):
    """Return whether what the data claim holds, and where not, what."""
    before, mp.dps = mp.dps, DIGITS
    try:
        TRUTHS[kind](data)
    except Untrue as error:
        return False, str(error)
    finally:
        mp.dps = before
    return True, ""


class Untrue(Exception):
    """What is false."""


def hold(condition, said):
    if not condition:
        raise Untrue(said)


def inside(x, texts, said):
    low, high = (mpf(text) for text in texts)
    slack = TINY * (1 + abs(x))
    hold(low - slack <= x <= high + slack, f"{said} = {mp.nstr(x, 20)} is not in {texts}")


def middle(texts):
    return (mpf(texts[0]) + mpf(texts[1])) / 2


def doubles(data, *names):
    return [mpf(float.fromhex(data[name])) for name in names]


# The gap map


def right_first(word):
    """The word turned so that it begins with its first R."""
    first = word.index("R")
    return word[first:] + word[:first]


def slope_of(word, roots, lam):
    turn = lam ** word.count("L")
    for s in roots:
        turn *= -1 / (2 * s)
    return turn


def gap_equations(word, s, lam, mu, l):
    """s_i^2 less the point that the root before flies to, for every R of the word, by iteration."""
    found, n = [], len(word)
    rights = [j for j, letter in enumerate(word) if letter == "R"]
    for i, j in enumerate(rights):
        x = mu - l - s[i - 1]
        for step in range(n):
            if (rights[i - 1] + 1 + step) % n == j:
                break
            x = lam * x + mu
        found.append(s[i] ** 2 - x)
    return found


def left_points(word, s, lam, mu, l):
    """The points with letter L by their numbers."""
    found, n = {}, len(word)
    rights = [j for j, letter in enumerate(word) if letter == "R"]
    for i, start in enumerate(rights):
        x, j = mu - l - s[i], (start + 1) % n
        while word[j] == "L":
            found[j + 1] = x
            x, j = lam * x + mu, (j + 1) % n
    return found


def newton(f, x, steps=40):
    """A zero near x, by central differences."""
    h = mpf(10) ** -16
    for _ in range(steps):
        value = mp.matrix(f(x))
        J = mp.matrix(len(x), len(x))
        for j in range(len(x)):
            ahead, behind = ([*x[:j], x[j] + d, *x[j + 1 :]] for d in (h, -h))
            for i, (a, b) in enumerate(zip(f(ahead), f(behind), strict=True)):
                J[i, j] = (a - b) / (2 * h)
        try:
            step = mp.lu_solve(J, -value)
        except ZeroDivisionError:
            raise Untrue("the equations are singular") from None
        x = [a + step[i] for i, a in enumerate(x)]
        if max(abs(one) for one in step) < mpf(10) ** -32:
            return x
    raise Untrue("Newton's method does not converge")


def same_letters(word, s, lam, mu, l, but=0):
    rights = [j + 1 for j, letter in enumerate(word) if letter == "R"]
    hold(all(x > 0 for j, x in zip(rights, s, strict=True) if j != but), "a root is not positive")
    points = left_points(word, s, lam, mu, l)
    hold(all(x < 0 for j, x in points.items() if j != but), "a point with letter L is not negative")


def gap_orbit(data):
    lam, mu, l = doubles(data, "lam", "mu", "l")
    word, claims = data["word"], data["claims"]
    s = newton(lambda at: gap_equations(word, at, lam, mu, l), [middle(one) for one in claims["roots"]])
    for root, texts in zip(s, claims["roots"], strict=True):
        inside(root, texts, "a root")
    same_letters(word, s, lam, mu, l)
    first = right_first(word)
    x, letters, seen = s[0] ** 2, "", []
    for _ in word:  # the map itself
        seen.append(x)
        letters += "L" if x < 0 else "R"
        x = lam * x + mu if x < 0 else mu - l - mp.sqrt(x)
    hold(letters == first, f"the map visits {letters}")
    hold(abs(x - s[0] ** 2) < mpf(10) ** -20, "the orbit does not close")
    n = len(word)
    for d in range(1, n):
        hold(n % d or max(abs(seen[i] - seen[i - d]) for i in range(n)) > mpf(10) ** -20, f"its least period is {d}")
    turn = slope_of(word, s, lam)
    inside(turn, claims["multiplier"], "the multiplier")
    hold((abs(turn) < 1) == claims["stable"], "the stability is wrong")
    root = word[: (word + word).index(word, 1)]
    for spelled in {word, root}:
        for other in theory.word_orbits(spelled, float(lam), float(mu), float(l)):
            roots = list(other.roots) * (len(word) // len(spelled))
            off = max(abs(a - b) for a, b in zip(roots, s, strict=True))
            hold(off < 1e-6 or off > float(claims["apart"]), "another orbit is as near")


def gap_edge(data):
    lam, l = doubles(data, "lam", "l")
    word, claims, kind, at = data["word"], data["claims"], data["edge"], data["at"]
    k = word.count("R")

    def equations(z):
        s, mu = z[:k], z[k]
        if kind == "gr":
            last = s[word[: at - 1].count("R")]
        elif kind == "bc":
            last = left_points(word, s, lam, mu, l)[at]
        else:
            last = 1 / slope_of(word, s, lam) - (-1 if kind == "pd" else 1)
        return [*gap_equations(word, s, lam, mu, l), last]

    z = newton(equations, [middle(one) for one in claims["roots"]] + [middle(claims["value"])])
    for root, texts in zip(z, claims["roots"], strict=False):
        inside(root, texts, "a root")
    inside(z[k], claims["value"], "mu")
    same_letters(word, z[:k], lam, z[k], l, at)
    hold((word + word).index(word, 1) == len(word), "the word is no primitive one")
    if at:
        hold(word[at - 1] == {"gr": "R", "bc": "L"}[kind], "the point has another letter")
    elif 0 < lam < 1:
        values = getattr(word_edges(word, float(lam), float(l)), kind)
        near = [value for value in values if abs(value - z[k]) < 1e-7 * (1 + abs(z[k]))]
        hold(near, f"theory knows no {kind} there")


def no_attractor(data):
    lam, l, low, high = (float.fromhex(data[name]) for name in ("lam", "l", "low", "high"))
    hold(0 < lam < 1 and l >= 0 and 0 <= low < high, "the range is another")
    for N in range(1, 400):
        window = theory.stability_interval(N, lam, l)
        if not window.empty:
            hold(window.high <= low * (1 + 1e-11) or window.low >= high * (1 - 1e-11), f"L^{N - 1} R attracts")
    for share in (0.999, 0.7, 0.31, 0.05):
        mu = low + share * (high - low)
        x, slope = 0.1234 * mu, 0.0
        for i in range(1200):
            if i > 200:
                slope += mp.log(lam) if x < 0 else -mp.log(2) - mp.log(max(x, 1e-300)) / 2
            x = lam * x + mu if x < 0 else mu - l - x**0.5
        hold(slope > 0, f"orbits converge at mu = {mu!r}")


# The oscillator


def tree(law, v, p):
    """The velocity after an impact."""
    if isinstance(law, str):
        return v if law == "v" else p[law] if law in p else mpf(float.fromhex(law))
    head, *rest = law
    if head == "if":
        (how, a, b), yes, no = rest
        a, b = tree(a, v, p), tree(b, v, p)
        held = {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b}[how]
        return tree(yes if held else no, v, p)
    values = [tree(one, v, p) for one in rest]
    if head == "abs":
        return abs(values[0])
    if head == "-":
        return -values[0] if len(values) == 1 else values[0] - values[1]
    a, b = values
    return {"+": lambda: a + b, "*": lambda: a * b, "/": lambda: a / b, "^": lambda: a**b}[head]()


class Rig:
    """The oscillator of a certificate at one value of its unknown parameter."""

    def __init__(self, data, value=None):
        def number(text):
            return value if text is None else mpf(float.fromhex(text))

        model, self.law = data["model"], data["law"]
        self.alpha, self.k, self.omega, self.t0, offset, sigma = (
            number(model[name]) for name in ("alpha", "k", "omega", "t0", "offset", "sigma")
        )
        self.cos, self.sin = ([number(x) for x in model[name]] for name in ("cos", "sin"))
        self.level = offset - self.k**2 * sigma
        self.p = {name: number(text) for name, text in self.law["parameters"].items()}
        self.n, self.N = data["impacts"], data["periods"]
        self.turn = self.N * 2 * mp.pi / self.omega
        J = len(self.cos)
        M = mp.zeros(3 + 2 * J)
        M[0, 1], M[1, 0], M[1, 1], M[1, 2] = 1, -(self.k**2), -self.alpha, self.level
        for j in range(J):
            W = (j + 1) * self.omega
            M[1, 3 + 2 * j], M[1, 4 + 2 * j] = self.cos[j], self.sin[j]
            M[3 + 2 * j, 4 + 2 * j], M[4 + 2 * j, 3 + 2 * j] = -W, W
        self.M, self.entries = M, entries_of(M)

    def flow(self, t):
        """The exponential of M t."""
        return exponential(self.entries, t)

    def state(self, t, y, w):
        z = [y, w, mpf(1)]
        for j in range(1, len(self.cos) + 1):
            phase = j * self.omega * (t + self.t0)
            z += [mp.cos(phase), mp.sin(phase)]
        return mp.matrix(z)

    def after(self, v):
        """The answer of the law and its slope."""
        h = mpf(10) ** -15
        return tree(self.law["after"], v, self.p), (
            tree(self.law["after"], v + h, self.p) - tree(self.law["after"], v - h, self.p)
        ) / (2 * h)

    def law_of(self, _wall, v):
        return self.after(v)[0]

    def flights(self, x):
        """Start, length, exponential and final state of every flight."""
        n = self.n
        if n == 0:
            starts = [(mpf(0), x[0], x[1], self.turn)]
        else:
            ends = [*x[1:n], x[0] + self.turn]
            starts = [(x[i], mpf(0), x[n + i], ends[i] - x[i]) for i in range(n)]
        made = []
        for t, y, w, L in starts:
            hold(0 < L < 2 * self.turn, "the impacts are not in the order of time")
            E, z = self.flow(L), self.state(t, y, w)
            made.append((z, L, E, E * z))
        return made

    def equations(self, x):
        flights = self.flights(x)
        if self.n == 0:
            end = flights[0][3]
            return [end[0] - x[0], end[1] - x[1]]
        after = [x[self.n + (i + 1) % self.n] for i in range(self.n)]
        return [one[3][0] for one in flights] + [
            w - self.after(one[3][1])[0] for w, one in zip(after, flights, strict=True)
        ]

    def trace_and_det(self, x):
        flights = self.flights(x)
        if self.n == 0:
            E = flights[0][2]
            return E[0, 0] + E[1, 1], E[0, 0] * E[1, 1] - E[0, 1] * E[1, 0]
        total = mp.eye(2)
        for z, _L, E, end in flights:
            # a later start turns the forcing on, at the same height and velocity
            later = self.M * z
            later[0], later[1] = mpf(0), mpf(0)
            by_t, by_w = E * later, E[:, 1]
            a, g = (self.M * end)[1], self.after(end[1])[1]
            dL = [-by_t[0] / end[1], -by_w[0] / end[1]]
            total = mp.matrix([[1 + dL[0], dL[1]], [g * (by_t[1] + a * dL[0]), g * (by_w[1] + a * dL[1])]]) * total
        return total[0, 0] + total[1, 1], total[0, 0] * total[1, 1] - total[0, 1] * total[1, 0]

    def incoming(self, x):
        return [one[3][1] for one in self.flights(x)] if self.n else []

    def steps(self, x):
        """Wall, time and velocity after every impact."""
        return [(0, x[i], x[self.n + i]) for i in range(self.n)]

    def off_the_walls(self, x, dip=None):
        off_the_wall(self, x, dip["flight"] - 1 if dip else None)

    def height_of(self, x, dip, time):
        return self.lowest(x, dip["flight"] - 1, time)

    def dips(self, x, flight, count=400):
        """The lowest heights of a flight: by floats on a grid, and each dip between to all digits."""
        z, L, _E, _end = self.flights(x)[flight]
        step = np.array(self.flow(L / count).tolist(), dtype=float)
        states = [np.array(z.tolist(), dtype=float)[:, 0]]
        for _ in range(count):
            states.append(step @ states[-1])
        turns = [i for i, (one, two) in enumerate(pairwise(states)) if one[1] < 0 < two[1]]
        return min(one[0] for one in states[1:-1]), [self.lowest(x, flight, L * (i + mpf(0.5)) / count) for i in turns]

    def lowest(self, x, flight, time):
        """The height of the local minimum of a flight that is near a time."""
        z = self.flights(x)[flight][0]
        for _ in range(60):
            here = self.flow(time) * z
            step = here[1] / (self.M * here)[1]
            time -= step
            if abs(step) < mpf(10) ** -25:
                return (self.flow(time) * z)[0]
        raise Untrue("the dip is not found")


def solved(equations, x):
    try:
        return newton(equations, x, steps=12)
    except (ZeroDivisionError, ValueError, OverflowError):
        raise Untrue("the equations have no solution near") from None


def off_the_wall(rig, x, but=None):
    flights = rig.flights(x)
    for i, (_z, _L, _E, end) in enumerate(flights):
        if rig.n:
            hold(end[1] < 0, "an impact does not arrive from above")
            hold(rig.after(end[1])[0] >= 0, "the law returns a velocity into the wall")
        seen, dips = rig.dips(x, i)
        least = -1e-10 if i == but else 0
        hold(seen > min(least, -1e-13) and all(dip > least for dip in dips), f"flight {i + 1} meets the wall")


def multipliers(trace, det):
    root = mp.sqrt(mp.mpc(trace**2 / 4 - det))
    return sorted((trace / 2 + root, trace / 2 - root), key=abs, reverse=True)


def check_stability(claimed, trace, det):
    largest = abs(multipliers(trace, det)[0])
    hold(claimed == "undecided" or (claimed == "stable") == (largest < 1), f"it is not {claimed}: {largest}")


def rig_of(data, value=None):
    """The model of a certificate at a value of its unknown parameter."""
    return WalledRig(data, hold, tree, value) if "walls" in data else Rig(data, value)


def check_slow_impacts(rig, walls):
    """Where an impact leaves with w = 0, motions beside the orbit meet the wall once more, as slowly as can be."""
    for wall in walls:
        for v in (-(mpf(10) ** -e) for e in (40, 60, 80)):
            held = 0 <= rig.law_of(wall, v) <= mpf(10) ** 20 * -v
            hold(held, "slow impacts beside one that leaves with w = 0 are not")


def oscillator_orbit(data):
    rig = rig_of(data)
    claims, n = data["claims"], rig.n
    start = [middle(one) for one in claims["box"]]
    x = solved(rig.equations, start)
    for i, (one, texts) in enumerate(zip(x, claims["box"], strict=True)):
        inside(one, texts, f"coordinate {i + 1}")
    rig.off_the_walls(x)
    for one, texts in zip(rig.incoming(x), claims["incoming"], strict=True):
        inside(one, texts, "an incoming velocity")
    trace, det = rig.trace_and_det(x)
    inside(trace, claims["trace"], "the trace")
    inside(det, claims["det"], "the determinant")
    for one, value in zip(claims["multipliers"], multipliers(trace, det), strict=bool(claims["multipliers"])):
        inside(value.real, one["real"], "a multiplier")
        hold(abs(abs(value.imag) - abs(middle(one["imag"]))) < 1e-6, "a multiplier")
    check_stability(claims["stability"], trace, det)
    steps = rig.steps(x)
    if claims["stability"] == "stable":
        check_slow_impacts(rig, [wall for i, (wall, _t, _speed) in enumerate(steps) if x[n + i] < mpf(10) ** -25])
    if claims["least_period"]:
        for q in range(2, n + 1):
            if n % q == 0:
                shifts = [divmod(i + n // q, n) for i in range(n)]
                off = max(
                    max(
                        abs(steps[j][1] + laps * rig.turn - steps[i][1] - rig.turn / q),
                        abs(steps[j][2] - steps[i][2]),
                        abs(steps[j][0] - steps[i][0]),
                    )
                    for i, (laps, j) in enumerate(shifts)
                )
                hold(off > mpf(10) ** -20, f"its period is a {q}th of that")
        amplitudes = [j for j, (c, s) in enumerate(zip(rig.cos, rig.sin, strict=True), start=1) if c or s]
        hold(n or amplitudes, "rest has no least period")
    if claims.get("symmetric"):
        rig.hold_symmetry(x)
    apart = [mpf(text) for text in claims["apart"]]
    guess = [a + b * (-1) ** i / 2 for i, (a, b) in enumerate(zip(x, apart, strict=True))]
    try:
        other = solved(rig.equations, guess)
    except Untrue:
        return
    off = [abs(a - b) for a, b in zip(other, x, strict=True)]
    hold(max(off) < mpf(10) ** -20 or any(a > b for a, b in zip(off, apart, strict=True)), "another is as near")


def oscillator_value(data):
    claims, n, size, kind = data["claims"], data["impacts"], len(data["claims"]["box"]), data["type"]

    def equations(full):
        return rig_of(data, full[size]).equations(full[:size])

    def test(full):
        rig = rig_of(data, full[size])
        if kind == "gr":
            return rig.height_of(full[:size], data["dip"], exact(data["dip"]["time"]))
        trace, det = rig.trace_and_det(full[:size])
        return {"pd": 1 + trace + det, "lp": 1 - trace + det, "ns": 1 - det}[kind]

    zero, ends = bifurcation(data, equations, test)
    rig = rig_of(data, zero[size])
    rig.off_the_walls(zero[:size], data["dip"] or None)
    if kind == "ns":
        trace, det = rig.trace_and_det(zero[:size])
        hold(trace**2 / 4 < det, "the multipliers are real")
    for claimed, end in zip(claims["ends"], ends, strict=True):
        trace, det = rig_of(data, end[size]).trace_and_det(end[:size])
        check_stability(claimed, trace, det)
    hold(n or kind == "gr", "a free ball bifurcates nowhere")


def bifurcation(data, equations, test):
    """The zero of a test function along the curve of a certificate, and the ends of that as they are claimed."""
    claims, pinned = data["claims"], data["pinned"]
    texts = [*claims["box"], claims["value"]]
    guess = [middle(one) for one in texts]

    def along(value):
        """The orbit at a value of the coordinate that runs along the curve."""
        fixed = partial(put, pinned, value)
        return fixed(solved(lambda z: equations(fixed(z)), guess[:pinned] + guess[pinned + 1 :]))

    s = [mpf(text) for text in texts[pinned]]
    ends = [along(value) for value in s]
    values = [test(one) for one in ends]
    hold(values[0] * values[1] <= 0, f"the test function has the signs of {mp.nstr(values, 5)}")
    for _ in range(60):
        new = s[0] - values[0] * (s[1] - s[0]) / (values[1] - values[0])
        zero = along(new)
        value = test(zero)
        at = 0 if (value < 0) == (values[0] < 0) else 1
        s[at], values[at] = new, value
        if abs(value) < mpf(10) ** -22 * (1 + abs(values[0]) + abs(values[1])):
            break
    for one, text in zip(zero, texts, strict=True):
        low, high = map(mpf, text)
        hold(low - mpf(10) ** -18 <= one <= high + mpf(10) ** -18, "the bifurcation lies elsewhere")
    return zero, ends


def put(pinned, value, rest):
    return [*rest[:pinned], value, *rest[pinned:]]


def exact(text):
    mantissa, exponent = text.split("p")
    return mpf(int(mantissa, 16)) * mpf(2) ** int(exponent)


def table_orbit(data):
    """An orbit on a table: its sums are those of the eigenvalues of a turn by differences."""

    def check_sums(J, claims, level):
        roots = [mp.mpc(root) for root in mp.eig(J, left=False, right=False)]
        if level:
            del roots[min(range(3), key=lambda k: abs(roots[k] - 1))]
            roots_sums = [sum(roots)]
        else:
            a, b, c = roots
            roots_sums = [a + b + c, a * b + b * c + c * a, a * b * c]
        hold(len(claims["sums"]) == len(roots_sums), "another number of sums")
        size = max(1, *map(abs, roots_sums))
        for found, (low, high) in zip(roots_sums, claims["sums"], strict=True):
            slack = mpf(10) ** -14 * size**2
            hold(mpf(low) - slack <= mp.re(found) <= mpf(high) + slack, "a sum of multipliers is another")
        outside = max(map(abs, roots))
        if claims["stability"] == "stable":
            hold(outside < 1 and not level, f"a multiplier is {mp.nstr(outside, 10)}")
        if claims["stability"] == "unstable":
            hold(outside > 1, f"the largest multiplier is {mp.nstr(outside, 10)}")

    truth_table.table_orbit(data, Untrue, inside, check_sums)


def table_value(data):
    truth_table.table_value(data, Untrue, partial(bifurcation, data))


TRUTHS = {
    "bifurcation value on a table": table_value,
    "periodic orbit on a table": table_orbit,
    "gap map orbit": gap_orbit,
    "gap map edge": gap_edge,
    "gap map without attracting orbits": no_attractor,
    "periodic orbit": oscillator_orbit,
    "periodic orbit with walls": oscillator_orbit,
    "bifurcation value": oscillator_value,
    "bifurcation value with walls": oscillator_value,
}
