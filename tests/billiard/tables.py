"""Tables, flights that graze, and slow twins, for the tests of pinball tables."""

from math import cos, pi, sin, sqrt

import numpy as np
from flint import arb, ctx

import grazing as gz

ELASTIC = gz.newton(1.0)


def box(width=6.0, height=10.0, law=ELASTIC):
    """Four walls, the inside on their left."""
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    names = "floor", "right", "ceiling", "left"
    return [gz.segment(name, corners[i], corners[(i + 1) % 4], law) for i, name in enumerate(names)]


def layout(count, width=6.0, height=10.0, radius=0.5, law=ELASTIC):
    """Discs in shifted rows, as in the speed measurements."""
    nx = int(np.ceil(sqrt(count * width / height)))
    ny = int(np.ceil(count / nx))
    places = [((i + 0.5 + 0.25 * (j % 2)) * width / (nx + 0.25), (j + 0.5) * height / ny)
              for j in range(ny) for i in range(nx)]  # fmt: skip
    return [gz.disc(f"disc{k}", place, radius, law) for k, place in enumerate(places[:count])]


def three_discs(distance):
    """The three-disc scatterer: unit discs at the corners of a triangle."""
    corners = {"A": (0.0, 0.0), "B": (distance, 0.0), "C": (0.5 * distance, 0.5 * sqrt(3.0) * distance)}
    return gz.table([gz.disc(name, corner, 1.0, ELASTIC) for name, corner in corners.items()])


def mixed(rho, tilt=0.5 * pi):
    """A box with discs, an arc and a slanted segment in it."""
    inside = [
        gz.disc("post", (1.5, 3.0), 0.4, gz.newton(0.95)), gz.disc("bumper", (4.4, 2.4), 0.6, gz.active(0.8, 0.6)),
        gz.arc("dome", (3.0, 6.0), 1.7, 0.3, 2.6, ELASTIC), gz.segment("slope", (4.3, 5.0), (5.4, 4.4), ELASTIC),
    ]  # fmt: skip
    return gz.table([*box(), *inside], rho=rho, tilt=tilt)


def grazing(kind, depth, random):
    """Return (table, state, t): a flight whose first graze, near t, is so deep; a negative depth stays clear."""
    while True:
        g = float(random.choice([0.0, 1.0])) if kind in ("disc", "end", "arc outside") else 1.0
        t, rho = random.uniform(0.4, 1.2), 0.0 if kind == "disc" else random.uniform(0.1, 0.4)
        px, py = random.uniform(-2, 2, 2)
        radius = {"disc": random.uniform(0.3, 1.0), "end": 0.0, "face": 0.0}.get(kind, random.uniform(0.8, 1.6))
        size = radius - rho if kind == "arc inside" else radius + rho
        angle = random.uniform(0.35, 0.65) * pi if kind == "arc inside" else random.uniform(0.0, 2.0 * pi)
        if kind == "face":  # a ceiling that the ball just reaches, or does not
            angle = -random.uniform(0.3, 0.7) * pi
        nx, ny = cos(angle), sin(angle)  # from the centre, or from the face, to the ball
        fast = random.uniform(0.5, 2.0) * (sqrt(max(g * size * ny, 0.0)) / 2.0 if kind == "arc inside" else 1.0)
        vx, vy = -ny * fast, nx * fast
        bend = fast * fast - g * size * ny
        if kind == "face":
            bend = -g * ny
        if kind == "arc inside":
            bend = -bend
        if not bend > 0.2:
            continue
        state = px - vx * t, py - vy * t - 0.5 * g * t * t, vx, vy + g * t
        reach = size + depth if kind == "arc inside" else size - depth
        x, y = px - reach * nx, py - reach * ny
        law, half = ELASTIC, random.uniform(1.0, 1.5)
        if kind == "disc":
            one = gz.disc("A", (x, y), radius, law)
        elif kind == "end":  # the other end lies behind it
            one = gz.segment("A", (x, y), (x - 3.0 * nx, y - 3.0 * ny), law)
        elif kind == "face":
            one = gz.segment("A", (x - 4.0 * ny, y + 4.0 * nx), (x + 4.0 * ny, y - 4.0 * nx), law)
        else:
            one = gz.arc("A", (x, y), radius, angle - half, angle + half, law)
        table = gz.table([one], rho=rho, g=max(g, 1.0), tilt=0.5 * pi if g else 0.0)
        before = np.linspace(0.0, t - 0.2, 40)
        way = zip(state[0] + state[2] * before, state[1] + (state[3] - 0.5 * g * before) * before, strict=True)
        if all(table.distances(*place)["A"] > rho + 1e-3 for place in way):  # it meets nothing else before
            return table, state, t


def least_gap(table, state, t):
    """Return the least distance of a flight from the object "A" near a time, in 100 digits: the ball's radius off."""
    before, ctx.prec = ctx.prec, 400
    try:
        (one,) = table.objects
        p, g = {k: arb(v) for k, v in one.shape.items()}, arb(table.gravity)
        x, y, vx, vy = map(arb, state)

        def gap(t):
            px, py = x + vx * t, y + vy * t - g * t * t / 2
            if one.kind == "segment":
                ex, ey = p["x2"] - p["x1"], p["y2"] - p["y1"]
                along = ((px - p["x1"]) * ex + (py - p["y1"]) * ey) / (ex * ex + ey * ey)
                along = arb(0) if along < 0 else along
                dx, dy = px - p["x1"] - along * ex, py - p["y1"] - along * ey
                return (dx * dx + dy * dy).sqrt() - table.rho
            dx, dy = px - p["x"], py - p["y"]
            far = (dx * dx + dy * dy).sqrt() - p["radius"]
            return (far if one.kind == "disc" else abs(far)) - table.rho

        low, high, ratio = arb(t) - arb("1e-3"), arb(t) + arb("1e-3"), (arb(5).sqrt() - 1) / 2
        for _ in range(220):  # golden section: to 1e-46 of the interval, where the gap is flat
            a, b = (high - ratio * (high - low)).mid(), (low + ratio * (high - low)).mid()
            if gap(a).mid() < gap(b).mid():
                high = b
            else:
                low = a
        return float(gap((low + high) / 2).mid())
    finally:
        ctx.prec = before


def dense(table, state, until, steps=20_000):
    """Return (object, time) of the first contact by a dense search, None for none: distances alone, and bisection."""
    x, y, vx, vy = state
    g = table.gravity

    def room(t):
        now = table.distances(x + vx * t, y + vy * t - 0.5 * g * t * t)
        return min((now[one.name] - table.rho, one.name) for one in table.objects)

    times = np.linspace(0.0, until, steps + 1)[1:]
    for before, after in zip([1e-9, *times[:-1]], times, strict=True):
        if room(after)[0] < 0.0:
            low, high = before, after
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if room(middle)[0] < 0.0 else (middle, high)
            return room(high)[1], high
    return None


def far_from(table, place):
    """Say whether a ball fits at a place."""
    return table.overlap(*place)[0] == 0.0


def unit_cell(radius):
    """A quarter-symmetric cell of the square Lorentz gas: a disc in the middle of a square of mirrors."""
    return gz.table([gz.disc("disc", (0.5, 0.5), radius, ELASTIC), *box(1.0, 1.0)])


def direction(angle, speed=1.0):
    """Return a velocity."""
    return speed * cos(angle), speed * sin(angle)


def energy(flown, g):
    """Return kinetic and potential energy along a trajectory."""
    return 0.5 * (flown.vx.values**2 + flown.vy.values**2) + g * flown.y.values
