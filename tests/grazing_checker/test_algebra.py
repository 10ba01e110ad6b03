"""What the checker differentiates, bounds and multiplies, of random models: against differences and identities.

Nothing here is an orbit: the equations, their derivatives and the multipliers are defined at any times and velocities.
"""

import random
from copy import deepcopy
from itertools import chain

import pytest

from grazing_checker.balls import double, number, precision
from grazing_checker.oscillator import Problem, box_of
from grazing_checker.table import Table, turned
from grazing_checker.table_value import Problem as OnTable
from tests.examples import examples

H = number(1, -60)
CLOSE = number(1, -80)
KICK = ["+", ["*", ["-", ["*", "a", "a"]], "v"], ["/", "b", ["+", (1.0).hex(), ["^", "v", (2.0).hex()]]]]
BEND = ["if", ["<", "v", (0.1).hex()], ["*", ["abs", "v"], ["^", "a", "b"]], ["*", "b", ["^", "v", (3.0).hex()]]]
PARTS = {"disc": ("disc",), "segment": ("left", "right", "start", "stop"), "arc": ("outer", "inner", "start", "stop")}
HITS = [(kind, part) for kind, parts in PARTS.items() for part in parts]


def law(rng):
    return {"parameters": {name: rng.uniform(0.2, 0.9).hex() for name in "ab"}, "after": rng.choice((KICK, BEND))}


def waves(rng, count):
    return {name: [rng.choice((0.0, rng.uniform(-0.5, 0.5))).hex() for _ in range(count)] for name in ("cos", "sin")}


def rig(rng, both=False):
    """Data of an oscillator with any walls, springs and harmonics, and the impacts of a word; of two that move."""
    scalars = {"alpha": rng.uniform(-1, 2), "omega": rng.uniform(0.3, 3), "t0": rng.uniform(-2, 2), "offset": 0.3}
    scalars |= rng.choice(({"k": rng.uniform(0.1, 2)}, {"stiffness": rng.uniform(-2, 2)}, {"stiffness": 0.0}))
    pair = ("A", "below"), ("B", "above")
    sides = pair if both else rng.choice((pair[:1], (("A", "above"),), pair))
    places = [{"name": name, "side": side, "sigma": rng.uniform(-2, 2).hex()} for name, side in sides]
    walls = [{**place, **waves(rng, rng.randint(both, 3)), "law": law(rng)} for place in places]
    names = [name for name, _side in sides]
    model = {name: x.hex() for name, x in scalars.items()} | waves(rng, rng.randint(1, 2))
    data = {
        "model": model,
        "walls": walls,
        "impacts": ["A", "B"] if both else [rng.choice(names) for _ in range(rng.randint(0, 3))],
    }
    return data | {"periods": rng.randint(1, 2)}


def point(rng, data):
    """Times in their order and velocities, or the state of an orbit without impacts."""
    n, turn = len(data["impacts"]), 6.28 * data["periods"] / float.fromhex(data["model"]["omega"])
    times = sorted(rng.uniform(0, turn) for _ in range(n))
    return [double(x) for x in [*times, *(rng.uniform(0.1, 2) for _ in range(n or 2))]]


def numbers_of(data):
    """Every parameter of a rig: its group, its name, and where its text is."""
    for of, part in (("model", data["model"]), *((one["name"], one) for one in data["walls"])):
        for name, x in part.items():
            if name in ("cos", "sin"):
                yield from ((of, f"{name}{j + 1}", (x, j)) for j in range(len(x)))
            elif name not in ("name", "side", "law"):
                yield of, name, (part, name)
    for one in data["walls"] if data["impacts"] else ():
        yield from ((f"law of {one['name']}", name, (one["law"]["parameters"], name)) for name in "ab")


def with_unknown(data, pick):
    """The problem with one parameter unknown, and the value that it had."""
    of, name, (place, key) = pick(list(numbers_of(data)))
    value, place[key] = double(float.fromhex(place[key])), None
    return Problem(data, (of, name)), value


def differ(defect, x, D, columns=None):
    """The largest distance of derivatives from central differences, relative to 1 and to their size."""
    worst = number(0)
    for j in range(len(x)) if columns is None else columns:
        ahead, behind = (defect([*x[:j], x[j] + by, *x[j + 1 :]]) for by in (H, -H))
        for row, one, two in zip(D, ahead, behind, strict=True):
            worst = max(worst, (abs((one - two) / (2 * H) - row[j]) / (1 + abs(row[j]))).upper())
    return worst


@pytest.mark.parametrize("seed", range(examples(25)))
def test_equations_have_their_derivatives_by_every_parameter_of_any_model(seed):
    rng = random.Random(seed)
    data = rig(rng, both=seed % 2 == 0)
    with precision(256):
        x = point(rng, data)
        for i in range(len(list(numbers_of(data)))):
            problem, value = with_unknown(deepcopy(data), lambda names, i=i: names[i])
            at, size = [*x, value], problem.size
            D = problem.derivative(at, problem.legs(at, sensitive=True))
            columns = [size] if i else None  # those of times and velocities are the same for all
            found = differ(lambda z, problem=problem: problem.defect(z, problem.legs(z)), at, D, columns)
            assert found < CLOSE, problem.unknown


def determinant(rows):
    """By the first row."""
    if not rows:
        return number(1)
    total, sign = number(0), 1
    for j, x in enumerate(rows[0]):
        if not x.is_zero():
            total += sign * x * determinant([[*row[:j], *row[j + 1 :]] for row in rows[1:]])
        sign = -sign
    return total


@pytest.mark.parametrize("seed", range(examples(40)))
def test_the_equations_are_singular_exactly_where_a_multiplier_is_1(seed):
    """|det D| is the product of the |v| times |1 - trace + det|, by eliminating what happens at the impacts."""
    rng = random.Random(seed)
    data = rig(rng)
    with precision(256):
        x, problem = point(rng, data), Problem(data)
        legs = problem.legs(x)
        trace, det = problem.trace_and_det(x, legs)
        known = 1 - trace + det
        for leg in legs if problem.n else ():
            known *= leg.v
        found = determinant(problem.derivative(x, legs))
        size = 1 + abs(found)
        assert abs(abs(found) - abs(known)) < CLOSE * size


@pytest.mark.parametrize("seed", range(examples(25)))
def test_a_box_holds_what_each_of_its_points_has(seed):
    rng = random.Random(seed)
    data = rig(rng)
    problem, value = with_unknown(deepcopy(data), rng.choice)
    plain = Problem(data)
    with precision(256):
        c = [*point(rng, data), value]
        u = [double(rng.uniform(0.1, 1) * 1e-4) for _ in c]
        box, corner = box_of(c, u), [a + b * rng.choice((-1, 1)) for a, b in zip(c, u, strict=True)]

        def seen(problem, x, legs):
            return [*chain(*problem.derivative(x, legs)), *problem.trace_and_det(x, legs), *problem.defect(x, legs)]

        large = seen(problem, box, problem.legs(box, sensitive=True))
        small = seen(problem, corner, problem.legs(corner, sensitive=True))
        large += seen(plain, box[:-1], plain.wide_legs(c[:-1], box[:-1]))
        small += seen(plain, corner[:-1], plain.legs(corner[:-1]))
        assert all(a.is_finite() and a.overlaps(b) for a, b in zip(large, small, strict=True))


def table(rng, *parts):
    """Data of a table of one object of each kind, and the impacts of a word that begins with some parts."""
    shapes = {
        "disc": {"radius": 0.7},
        "segment": {"x2": 1.5, "y2": 0.5},
        "arc": {"radius": 1.1, "start": -1.0, "stop": 1.5},
    }
    objects = []
    for kind, shape in shapes.items():
        one, two = ("x1", "y1") if kind == "segment" else ("x", "y")
        shape = {one: rng.uniform(-3, 1), two: rng.uniform(-3, 3), **shape}
        shape = {name: x.hex() for name, x in shape.items()}
        objects.append({"name": kind, "kind": kind, "shape": shape, "law": law(rng)})
    others = [rng.choice(HITS) for _ in range(rng.randint(1, 2))]
    plane = {"rho": (0.15).hex(), "g": rng.uniform(0.5, 2).hex(), "tilt": rng.uniform(0.1, 1.5).hex()}
    return {"objects": objects, "impacts": [*map(list, parts), *map(list, others)], "energy": None} | plane


def hits(rng, n):
    return [double(rng.uniform(-2, 2)) for _ in range(n)] + [double(rng.uniform(0.3, 1.5)) for _ in range(n)]


@pytest.mark.parametrize("hit", HITS, ids=" ".join)
def test_equations_on_a_table_have_their_derivatives_by_every_parameter(hit):
    rng = random.Random(" ".join(hit))
    data = table(rng, hit)
    groups = [data, *(one["shape"] for one in data["objects"]), *(one["law"]["parameters"] for one in data["objects"])]
    with precision(256):
        x = hits(rng, len(data["impacts"]))
        for part in groups:
            for name in [name for name, text in part.items() if isinstance(text, str)]:
                text, part[name] = part[name], None
                problem, at = OnTable(data), [*x, double(float.fromhex(text))]
                D = problem.derivative(at, problem.legs(at, sensitive=True))
                found = differ(lambda z, problem=problem: problem.defect(z, problem.legs(z)), at, D)
                part[name] = text
                assert found < CLOSE, name


@pytest.mark.parametrize("hit", HITS, ids=" ".join)
def test_a_turn_on_a_table_is_that_of_balls_beside_it(hit):
    """The derivative of each flight and impact, from balls that start beside it and fly as long."""
    rng = random.Random(" ".join(hit))
    data = table(rng, hit)
    with precision(256):
        balls = Table(data)
        x, n, g = hits(rng, balls.n), balls.n, balls.g
        frames = balls.frames(x)
        speeds = balls.speeds(x, frames)

        def bounced(k, v):  # what the law makes of a velocity at impact k
            return balls.things[balls.hits[k][0]].after(v).x

        for k, (_p, (a, b), _m) in enumerate(frames):
            (bx, by), way = speeds[k - 1][1], a * speeds[k - 1][1][0] + b * speeds[k - 1][1][1]
            kick = bounced(k, way) - way
            speeds[k] = (bx + kick * a, by + kick * b), speeds[k][1]
        found = turned(balls, frames, speeds, x)

        def flown(i, state):  # to impact i + 1 and on, as long as the flight itself
            k, t, word = (i + 1) % n, x[n + i], balls.word[(i + 1) % n]
            px, py, vx, vy = state

            def seen(s):  # distance and normal at time s, and the velocity along it
                qx, qy, wy = px + vx * s - word.at[0], py + vy * s - g * s * s / 2 - word.at[1], vy - g * s
                nx, ny = word.sign * word.e[1], -word.sign * word.e[0]
                if word.round:
                    far = (qx * qx + qy * qy).sqrt()
                    nx, ny = word.sign * qx / far, word.sign * qy / far
                    return word.sign * (far - word.size), nx, ny, nx * vx + ny * wy
                return nx * qx + ny * qy - word.size, nx, ny, nx * vx + ny * wy

            s = t
            for _ in range(6):
                height, _nx, _ny, v = seen(s)
                s = (s - height / v).mid()
            _height, nx, ny, v = seen(s)
            kick, late = bounced(k, v) - v, t - s
            wx, wy = vx + kick * nx, vy - g * s + kick * ny
            low = py + vy * s - g * s * s / 2
            return [px + vx * s + wx * late, low + wy * late - g * late * late / 2, wx, wy - g * late]

        M = [[number(int(r == c)) for c in range(4)] for r in range(4)]
        for i in range(n):
            (px, py), (bx, by), t = frames[(i + 1) % n][0], speeds[i][1], x[n + i]
            start = [px - bx * t, py - by * t - g * t * t / 2, bx, by + g * t]
            columns = []
            for j in range(4):
                ahead, behind = (flown(i, [*start[:j], start[j] + h, *start[j + 1 :]]) for h in (H, -H))
                columns.append([(one - two) / (2 * H) for one, two in zip(ahead, behind, strict=True)])
            M = [[sum((columns[j][r] * M[j][c] for j in range(4)), number(0)) for c in range(4)] for r in range(4)]
        size = sum((abs(one) for row in M for one in row), number(1))
        apart = max(
            abs(a - b).upper() for one, two in zip(M, found, strict=True) for a, b in zip(one, two, strict=True)
        )
        assert apart < CLOSE * size
