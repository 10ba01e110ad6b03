"""Flippers whose sides and tips a ball just touches, and tables with flippers, for the tests of what turns."""

from math import cos, pi, sin

import numpy as np
from flint import arb, ctx

import grazing as gz
from tests.billiard.tables import ELASTIC, box

KINDS = "side", "other side", "tip"


def pair(player=None, rho=0.15, law=None, radius=(0.2, 0.12), tilt=0.5 * pi):
    """A box with two flippers, rails that lead to them, three bumpers, and a drain below."""
    law = law or gz.newton(0.9)
    stroke = {"up": 14.0, "down": 9.0}
    flippers = [
        gz.flipper("L", (1.2, 1.0), 1.45, radius, -0.5, 0.6, law, **stroke),
        gz.flipper("R", (4.8, 1.0), 1.45, radius, pi + 0.5, pi - 0.6, law, **stroke),
    ]
    rails = [gz.segment("rail", (0.0, 2.2), (0.9, 1.35), law), gz.segment("slope", (6.0, 2.2), (5.1, 1.35), law)]
    places = (1.8, 6.0), (4.2, 6.0), (3.0, 7.8)
    bumpers = [gz.disc(name, place, 0.5, gz.active(0.8, 1.0)) for name, place in zip("ABC", places, strict=True)]
    sides = [one for one in box(law=law) if one.name != "floor"]
    objects = [*flippers, *sides, *rails, *bumpers, gz.drain("out", (0.0, 0.0), (6.0, 0.0))]
    return gz.table(objects, rho, 1.0, tilt, *([player] if player is not None else []))


def grazing(kind, depth, random):
    """Return (table, state, t): a flight whose first graze of a flipper that turns, near t, is so deep.

    A negative depth stays clear. The flipper turns from the begin of the flight until after the graze, or begins to
    turn during it.
    """
    while True:
        g, rho, t = float(random.choice([0.0, 1.0])), random.uniform(0.1, 0.3), random.uniform(0.1, 0.4)
        hub, tip = random.uniform(0.15, 0.4), random.uniform(0.05, 0.3)
        length, omega = random.uniform(1.0, 2.0), random.uniform(0.3, 4.0)
        up, way = bool(random.integers(2)), float(random.choice([-1.0, 1.0]))
        angle, pause = random.uniform(-pi, pi), random.choice([0.0, 0.4]) * t  # at the graze; before it turns
        turning = way * omega * (1.0 if up else -1.0)
        begin, rest = angle - turning * (t - pause), 0.2
        side = {"side": 1.0, "other side": -1.0, "tip": 0.0}[kind]
        lean = np.arccos((hub - tip) / length)
        if side:
            normal, along = angle + side * lean, random.uniform(0.15, 0.85) * length * sin(lean)
            axis = normal - side * 0.5 * pi
            d = (hub + rho) * np.array([cos(normal), sin(normal)]) + along * np.array([cos(axis), sin(axis)])
        else:
            normal = angle + random.uniform(-0.8, 0.8) * lean
            d = length * np.array([cos(angle), sin(angle)]) + (tip + rho) * np.array([cos(normal), sin(normal)])
        n = np.array([cos(normal), sin(normal)])
        jn, spun = np.array([-n[1], n[0]]), turning * np.array([-d[1], d[0]])
        v = (n @ spun) * n + random.uniform(-2.0, 2.0) * jn  # the gap is at rest
        bend = -g * n[1] + 2.0 * turning * (jn @ v) - turning**2 * (n @ d)
        if not side:
            relative = jn @ v - turning * length * (jn @ np.array([-sin(angle), cos(angle)]))
            bend = relative**2 / (tip + rho) - g * n[1] + turning**2 * length * (n @ np.array([cos(angle), sin(angle)]))
        if not bend > 0.2:
            continue
        pivot = random.uniform(-2.0, 2.0, 2)
        place = pivot + d - depth * n
        state = *(place - v * t - [0.0, 0.5 * g * t * t]), v[0], v[1] + g * t
        stroke, speeds = omega * (t - pause + 0.3), {"up": omega, "down": omega}
        rest = begin if up else begin - way * stroke
        if up:
            times = [pause]
        else:  # long since raised, then released
            times = [pause - 10.0 - stroke / omega, pause]
        if stroke > pi:
            continue
        one = gz.flipper("A", pivot, length, (hub, tip), rest, rest + way * stroke, ELASTIC, **speeds)
        table = gz.table([one], rho, max(g, 1.0), 0.5 * pi if g else 0.0, gz.presses(A=times))
        beside = np.concatenate([np.linspace(0.0, t - 0.06, 40), np.linspace(t + 0.06, t + 0.12, 10)])
        way_by = zip(
            beside, state[0] + state[2] * beside, state[1] + (state[3] - 0.5 * g * beside) * beside, strict=True
        )
        if all(table.distances(x, y, s)["A"] > rho + 1e-6 for s, x, y in way_by):  # it meets nothing else around then
            return table, tuple(map(float, state)), t


def least_gap(table, state, t):
    """Return the least distance of a flight from the flipper "A" near a time, in 100 digits: the ball's radius off."""
    before, ctx.prec = ctx.prec, 400
    try:
        (one,) = table.objects
        p, g = {k: arb(v) for k, v in one.shape.items()}, arb(table.gravity)
        x, y, vx, vy = map(arb, state)
        _period, pieces = table.player.motion("A", one.shape, table.params)
        piece = [piece for piece in pieces if piece.begin <= t][-1]
        sine = (p["hub"] - p["tip"]) / p["length"]
        cosine = (1 - sine * sine).sqrt()

        def gap(s):
            angle = arb(piece.angle) + arb(piece.omega) * (s - arb(piece.begin))
            dx, dy = x + vx * s - p["x"], y + vy * s - g * s * s / 2 - p["y"]
            along, beside = dx * angle.cos() + dy * angle.sin(), abs(dy * angle.cos() - dx * angle.sin())
            foot = along * cosine - beside * sine
            if foot < 0:
                return (along * along + beside * beside).sqrt() - p["hub"] - table.rho
            if foot > p["length"] * cosine:
                along -= p["length"]
                return (along * along + beside * beside).sqrt() - p["tip"] - table.rho
            return along * sine + beside * cosine - p["hub"] - table.rho

        low, high, ratio = arb(t) - arb("1e-3"), arb(t) + arb("1e-3"), (arb(5).sqrt() - 1) / 2
        for _ in range(160):  # golden section: to 1e-33 of the interval, where the gap is flat
            a, b = (high - ratio * (high - low)).mid(), (low + ratio * (high - low)).mid()
            if gap(a).mid() < gap(b).mid():
                high = b
            else:
                low = a
        return float(gap((low + high) / 2).mid())
    finally:
        ctx.prec = before
