"""Whether the statement of a certificate of an orbit on a table is true: shooting, roots of polynomials, differences.

Balls are flown from impact to impact as states (x, y, vx, vy), each impact being a root of a polynomial in time; the
orbit is the fixed point of one turn. Nothing of grazing_checker is used.
"""

from copy import deepcopy
from itertools import combinations
from math import prod

import numpy as np
from mpmath import mp, mpc, mpf

TINY = mpf(10) ** -20


def expj(x):
    return mpc(mp.cos(x), mp.sin(x))


def number(text):
    """A number of a certificate, or one in its place."""
    return text if isinstance(text, mpf) else mpf(float.fromhex(text))


class Ball:
    """A ball on the table of a certificate."""

    def __init__(self, data, untrue):
        self.untrue = untrue
        self.rho, g, tilt = (number(data[name]) for name in ("rho", "g", "tilt"))
        self.hold(self.rho >= 0 and g >= 0 and 0 <= tilt < 1.6, "no such ball")
        self.g = g * mp.sin(tilt)
        self.objects = {one["name"]: one for one in data["objects"]}
        self.hold(len(self.objects) == len(data["objects"]), "two objects have one name")
        self.shapes = {name: {key: number(x) for key, x in one["shape"].items()} for name, one in self.objects.items()}
        self.energy = None if data["energy"] is None else mpf(float.fromhex(data["energy"]))

    def hold(self, condition, said):
        if not condition:
            raise self.untrue(said)

    # what is hit

    def ends(self, name):
        kind, p = self.objects[name]["kind"], self.shapes[name]
        if kind == "arc":
            return [mpc(p["x"], p["y"]) + p["radius"] * expj(p[key]) for key in ("start", "stop")]
        return [mpc(p["x1"], p["y1"]), mpc(p["x2"], p["y2"])]

    def circle(self, name, part):
        """Centre, radius and side of a part that is round; None for one that is straight."""
        kind, p = self.objects[name]["kind"], self.shapes[name]
        if part in ("start", "stop"):
            return self.ends(name)[part == "stop"], self.rho, 1
        if kind in ("segment", "drain"):
            return None
        sign = -1 if part == "inner" else 1
        return mpc(p["x"], p["y"]), p["radius"] + sign * self.rho, sign

    def normal(self, name, part, p):
        """The normal to the ball at a place of a part."""
        found = self.circle(name, part)
        if found is not None:
            return found[2] * (p - found[0]) / abs(p - found[0])
        one, two = self.ends(name)
        return (two - one) / abs(two - one) * (1j if part == "left" else -1j)

    def gap(self, name, part, p):
        """How far the place is in front of a part."""
        found = self.circle(name, part)
        if found is not None:
            return found[2] * (abs(p - found[0]) - found[1])
        n = self.normal(name, part, p)
        rho = mpf(0) if self.objects[name]["kind"] == "drain" else self.rho
        return ((p - self.ends(name)[0]) * mp.conj(n)).real - rho

    def distance(self, name, p):
        """How far the surface of the ball is from an object; of a drain, its centre."""
        kind, s = self.objects[name]["kind"], self.shapes[name]
        if kind == "disc":
            return abs(p - mpc(s["x"], s["y"])) - s["radius"] - self.rho
        one, two = self.ends(name)
        if kind == "arc":
            d = p - mpc(s["x"], s["y"])
            span = s["stop"] - s["start"]
            turn = (mp.arg(d) - s["start"]) % (2 * mp.pi)
            near = abs(abs(d) - s["radius"]) if turn <= span else min(abs(p - one), abs(p - two))
            return near - self.rho
        along = ((p - one) * mp.conj(two - one)).real / abs(two - one) ** 2
        foot = one + min(max(along, mpf(0)), mpf(1)) * (two - one)
        return abs(p - foot) - (self.rho if kind != "drain" else 0)

    def law(self, name, v):
        law = self.objects[name]["law"]
        p = {key: number(x) for key, x in law["parameters"].items()}

        def at(tree):
            if isinstance(tree, str):
                return v if tree == "v" else p[tree] if tree in p else mpf(float.fromhex(tree))
            head, *rest = tree
            if head == "if":
                (how, a, b), yes, no = rest
                a, b = at(a), at(b)
                held = {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b}[how]
                return at(yes if held else no)
            values = [at(one) for one in rest]
            if head == "abs":
                return abs(values[0])
            if head == "-" and len(values) == 1:
                return -values[0]
            return {"+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b,
                    "^": lambda a, b: a**b}[head](*values)  # fmt: skip

        return at(law["after"])

    # flights

    def flown(self, state, t):
        p, w = state
        return p + w * t - 0.5j * self.g * t * t, w - 1j * self.g * t

    def lands(self, state, name, part, t):
        """The time near t at which a flight is at a part, by secants."""
        return mp.findroot(lambda s: self.gap(name, part, self.flown(state, s)[0]), (t, t * (1 + mpf(10) ** -9)))

    def struck(self, name, part, state):
        p, b = state
        n = self.normal(name, part, p)
        v = (b * mp.conj(n)).real
        return (p, b + (self.law(name, v) - v) * n), v

    def turn(self, state, word, times):
        """The state after one turn, with the times of its flights, and the velocities before its impacts."""
        found, speeds = [], []
        for i, t in enumerate(times):
            name, part = word[(i + 1) % len(word)]
            t = self.lands(state, name, part, t)
            state, v = self.struck(name, part, self.flown(state, t))
            found.append(t)
            speeds.append(v)
        return state, found, speeds

    def start(self, word, x):
        """The state just after the first impact, at coordinates (u, direction, speed)."""
        (name, part), (u, direction, speed) = word[0], x
        found = self.circle(name, part)
        if found is not None:
            p = found[0] + found[1] * expj(u)
        else:
            one, two = self.ends(name)
            p = one + u * (two - one) / abs(two - one) + self.rho * self.normal(name, part, one)
        return p, speed * expj(direction)

    def coordinates(self, word, state):
        (name, part), (p, w) = word[0], state
        found = self.circle(name, part)
        if found is not None:
            u = mp.arg(p - found[0])
        else:
            one, two = self.ends(name)
            u = ((p - one) * mp.conj(two - one)).real / abs(two - one)
        return [u, mp.arg(w), abs(w)]


def near(a, b):
    """An angle, turned to be near another."""
    return a + 2 * mp.pi * mp.nint((b - a) / (2 * mp.pi))


def table_orbit(data, untrue, inside, check_sums):
    """Raise ``untrue`` unless the statement of a certificate of an orbit on a table holds."""
    ball, claims = Ball(data, untrue), data["claims"]
    word = [tuple(hit) for hit in data["impacts"]]
    n = len(word)
    for name, part in word:
        kind = ball.objects[name]["kind"]
        parts = {"disc": ["disc"], "segment": ["left", "right", "start", "stop"]}
        ball.hold(part in parts.get(kind, ["outer", "inner", "start", "stop"]) and kind != "drain", "no such part")
    box = [(mpf(low) + mpf(high)) / 2 for low, high in claims["box"]]
    u, times = box[:n], box[n:]
    places = [ball.start([hit], (x, mpf(0), mpf(1)))[0] for hit, x in zip(word, u, strict=True)]
    w = (places[1 % n] - places[0]) / times[0] + 0.5j * ball.g * times[0]
    guess = [u[0], mp.arg(w), abs(w)]
    level = ball.energy is not None

    def after(x):
        state, found, _speeds = ball.turn(ball.start(word, x), word, times)
        y = ball.coordinates(word, state)
        if ball.circle(*word[0]) is not None:
            y[0] = near(y[0], x[0])
        y[1] = near(y[1], x[1])
        return y, found

    def off(*x):
        y, _found = after(x)
        F = [a - b for a, b in zip(y, x, strict=True)]
        if level:  # at a fixed energy the speed comes back by itself
            p, v = ball.start(word, x)
            F[2] = abs(v) ** 2 / 2 + ball.g * p.imag - ball.energy
        return F

    x = list(mp.findroot(off, guess, tol=mpf(10) ** -30, maxsteps=40))
    state = ball.start(word, x)
    _end, times, speeds = ball.turn(state, word, times)
    inside(sum(times), claims["time"], "the time")
    states, now = [], state
    for i, t in enumerate(times):
        states.append(now)
        name, part = word[i]
        u = ball.coordinates([word[i]], now)[0]
        u = near(u, box[i]) if ball.circle(name, part) is not None else u
        inside(u, claims["box"][i], f"u_{i + 1}")
        inside(t, claims["box"][n + i], f"t_{i + 1}")
        inside(speeds[i - 1], claims["incoming"][i], f"speed {i + 1}")
        ball.hold(abs(ball.distance(name, now[0])) < TINY * (1 + abs(now[0])), f"impact {i + 1} is no contact")
        leaves = (now[1] * mp.conj(ball.normal(name, part, now[0]))).real
        ball.hold(speeds[i - 1] < 0 < leaves, f"impact {i + 1} is none")
        now, _v = ball.struck(*word[(i + 1) % n], ball.flown(now, t))
    if level:
        for i, (name, _part) in enumerate(word):
            v = speeds[i - 1]
            ball.hold(all(abs(ball.law(name, k * v) + k * v) < TINY * abs(v) for k in (1, 2, 0.25)), "no elastic law")
    for i, (start, t) in enumerate(zip(states, times, strict=True)):
        clear(ball, start, t, word[i], word[(i + 1) % n], i)
    J = differences(lambda y: after(y)[0], x)
    check_sums(J, claims, level)
    if claims["least_period"]:
        for step in (k for k in range(1, n) if n % k == 0):
            same = word[step:] + word[:step] == word and all(
                abs(states[i][0] - states[(i + step) % n][0]) + abs(times[i] - times[(i + step) % n]) < TINY
                for i in range(n)
            )
            ball.hold(not same, f"it repeats after {step} impacts")


def table_value(data, untrue, bifurcation):
    """Raise ``untrue`` unless the statement of a certificate of a bifurcation on a table holds.

    Its equations are velocities: what leaves an impact is what the law makes of what came. The multipliers are those of
    a turn by differences.
    """
    word, kind, dip = [tuple(hit) for hit in data["impacts"]], data["type"], data["dip"]
    n, level = len(word), data["energy"] is not None

    def ball_of(full):
        return Ball(placed(data, full[2 * n], untrue), untrue)

    def flights(ball, full):
        """Places, velocities after the impacts, and before them."""
        places = [ball.start([hit], (x, mpf(0), mpf(1)))[0] for hit, x in zip(word, full[:n], strict=True)]
        times = full[n : 2 * n]
        w = [(places[(i + 1) % n] - places[i]) / t + 0.5j * ball.g * t for i, t in enumerate(times)]
        b = [w[i - 1] - 1j * ball.g * times[i - 1] for i in range(n)]
        return places, w, b, times

    def equations(full):
        ball = ball_of(full)
        places, w, b, _times = flights(ball, full)
        found = []
        for i, (name, part) in enumerate(word):
            off = w[i] - ball.struck(name, part, (places[i], b[i]))[0][1]
            normal = ball.normal(name, part, places[i])
            across, along = (off * mp.conj(normal)).real, (off * mp.conj(normal)).imag
            if level:
                across = abs(w[i]) ** 2 / 2 + ball.g * places[i].imag - ball.energy
            found += [across, along]
        return found

    def roots_of(full):
        ball = ball_of(full)
        _places, w, _b, times = flights(ball, full)
        x = [full[0], mp.arg(w[0]), abs(w[0])]

        def after(y):
            end = ball.coordinates(word, ball.turn(ball.start(word, y), word, times)[0])
            end[0] = near(end[0], y[0]) if ball.circle(*word[0]) is not None else end[0]
            return [end[0], near(end[1], y[1]), end[2]]

        roots = [mp.mpc(one) for one in mp.eig(differences(after, x), left=False, right=False)]
        if level:
            del roots[min(range(3), key=lambda k: abs(roots[k] - 1))]
        return roots

    def test(full):
        if kind == "gr":
            ball = ball_of(full)
            places, w, _b, _times = flights(ball, full)
            i, hit = dip["flight"] - 1, (dip["object"], dip["part"])
            return lowest(ball, (places[i], w[i]), hit, dip)
        roots = roots_of(full)
        if kind == "ns":
            return prod(1 - a * b for a, b in combinations(roots, 2)).real
        return prod(1 + (1 if kind == "pd" else -1) * one for one in roots).real

    zero, ends = bifurcation(equations, test)
    ball = ball_of(zero)
    places, w, b, times = flights(ball, zero)
    for i, (name, part) in enumerate(word):
        ball.hold(abs(ball.distance(name, places[i])) < TINY * (1 + abs(places[i])), f"impact {i + 1} is no contact")
        normal = ball.normal(name, part, places[i])
        ball.hold((b[i] * mp.conj(normal)).real < 0 < (w[i] * mp.conj(normal)).real, f"impact {i + 1} is none")
        touched = dip if dip and dip["flight"] == i + 1 else None
        clear(ball, (places[i], w[i]), times[i], word[i], word[(i + 1) % n], i, touched)
    if kind == "ns":
        ball.hold(max(abs(one.imag) for one in roots_of(zero)) > mpf(10) ** -9, "the multipliers are real")
    for claimed, end in zip(data["claims"]["ends"], ends, strict=True):
        outside = max(map(abs, roots_of(end))) if kind != "gr" else None
        ball.hold(kind == "gr" or claimed != "stable" or (outside < 1 and not level), "the orbit is not stable")
        ball.hold(kind == "gr" or claimed != "unstable" or outside > 1, "the orbit is not unstable")


def differences(function, x):
    """The derivative of a function of three numbers."""
    h, J = mpf(10) ** -12, mp.zeros(3, 3)
    for j in range(3):
        up, down = (function([x[k] + s * h * (k == j) for k in range(3)]) for s in (1, -1))
        for k in range(3):
            J[k, j] = (up[k] - down[k]) / (2 * h)
    return J


def placed(data, value, untrue):
    """The data with a number in the place of the parameter that has none."""
    data, of, name = deepcopy(data), data["parameter"]["of"], data["parameter"]["name"]
    groups = {"the table": data}
    for one in data["objects"]:
        groups |= {one["name"]: one["shape"], f"law of {one['name']}": one.get("law", {}).get("parameters", {})}
    if of not in groups or groups[of].get(name, 0) is not None:
        raise untrue("no such parameter is unknown")
    groups[of][name] = value
    return data


def lowest(ball, start, hit, dip):
    """The least height of a flight above a part of an object, near the time of a dip."""

    def rise(s):
        p, v = ball.flown(start, s)
        return (v * mp.conj(ball.normal(*hit, p))).real

    low, high, time = (exact(dip[name]) for name in ("from", "to", "time"))
    s = mp.findroot(rise, (time, time * (1 + mpf(10) ** -9)), tol=mpf(10) ** -50)
    ball.hold(low < s < high, "the dip is elsewhere")
    return ball.gap(*hit, ball.flown(start, s)[0])


def exact(text):
    mantissa, exponent = text.split("p")
    return mpf(int(mantissa, 16)) * mpf(2) ** int(exponent)


def clear(ball, start, t, one, two, i, dip=None):
    """A flight is off everything inside: at the ends of the pieces on which its distances rise or fall.

    But for a touch in a dip.
    """
    (p, w), g = start, ball.g
    for name, thing in ball.objects.items():
        times = [t * k / 64 for k in range(1, 64)]
        points = ball.ends(name) if thing["kind"] != "disc" else []
        if thing["kind"] in ("disc", "arc"):
            points = [*points, mpc(ball.shapes[name]["x"], ball.shapes[name]["y"])]
        for centre in points:  # where the distance from a point is least or greatest
            d = p - centre
            c = [g * g / 2, -1.5 * g * w.imag, abs(w) ** 2 - g * d.imag, (d * mp.conj(w)).real]
            times += real_roots(c)
        if thing["kind"] in ("segment", "drain"):
            a, b = ball.ends(name)
            for e in ((b - a) / abs(b - a), 1j * (b - a) / abs(b - a)):
                for shift in (a, b):  # where the foot is an end, and where the centre is on the line
                    times += real_roots([-g * e.imag / 2, (w * mp.conj(e)).real, ((p - shift) * mp.conj(e)).real])
                times += real_roots([-g * e.imag, (w * mp.conj(e)).real])
        if thing["kind"] == "arc":
            centre, R = mpc(ball.shapes[name]["x"], ball.shapes[name]["y"]), ball.shapes[name]["radius"]
            d = p - centre
            square = [g * g / 4, -g * w.imag, abs(w) ** 2 - g * d.imag, 2 * (d * mp.conj(w)).real, abs(d) ** 2 - R * R]
            times += real_roots(square)
        edge = mpf(10) ** -9 * t
        for s in times:
            if edge < s < t - edge:
                deep = ball.distance(name, ball.flown(start, s)[0])
                own = (name in (one[0],) and s < 1e-3 * t) or (name in (two[0],) and s > (1 - 1e-3) * t)
                touch = dip and name == dip["object"] and exact(dip["from"]) < s < exact(dip["to"])
                ball.hold(
                    deep > 0 or own or (touch and deep > -TINY * (1 + abs(p))),
                    f"flight {i + 1} meets {name} at {mp.nstr(s, 8)}, {mp.nstr(deep, 5)}",
                )


def real_roots(c):
    """The real roots of a polynomial, its highest coefficient first; both of two that nearly meet."""
    size = max(map(abs, c))
    c = [one / size for one in c] if size else []
    while c and abs(c[0]) < mpf(10) ** -30:
        c = c[1:]
    if len(c) < 2:
        return []
    found = np.roots([float(one) for one in c])
    return [polished(c, mpf(r.real)) for r in map(complex, found.tolist()) if abs(r.imag) < 1e-6 * (1 + abs(r))]


def polished(c, x):
    for _ in range(4):
        value = slope = mpf(0)
        for one in c:
            value, slope = value * x + one, slope * x + value
        if slope == 0 or abs(value / slope) > abs(x) + 1:
            break
        x -= value / slope
    return x
