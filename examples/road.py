"""From the pinball table to the oscillator: what each step drops, and the square root with a gap that stays.

Each panel is the same experiment on one rung of docs/road.md. One number decides how deep a ball grazes a bumper, below
0 for a miss; drawn is by how much what comes next moves, for a passive bumper and an active one, points by simulation
and lines by formula. Run it with `python examples/road.py`; it writes road.png.
"""

import argparse
from math import pi, sqrt

import numpy as np
from scipy.optimize import brentq

import grazing as gz

R, STEP = 0.8, 1e-6  # restitution of the bumpers; of differences


class Rung:
    """A system with a bumper, and a number that controls how deep a ball grazes it.

    Each rung says how it flies without the bumper: ``passing``, ``frame`` and ``comes``; and with it: ``whole``.
    """

    def graze(self):
        """Return the control at which the ball touches the bumper."""
        return brentq(lambda control: self.passing(control)[3], *self.span, xtol=1e-15, rtol=1e-15)

    def predicted(self, V):
        """Return the gap and the coefficient of the square root of the depth, by the formula of docs/road.md."""
        t, p, w, _depth = self.passing(self.graze())
        n, A, change = self.frame(t, p, w)
        kicked = w + V * n
        dp, dw = V * n, (1.0 + R) * A * n + V * change
        moved = self.comes(t, p + STEP * dp, kicked + STEP * dw) - self.comes(t, p - STEP * dp, kicked - STEP * dw)
        return self.comes(t, p, kicked) - self.comes(t, p, w), moved / (2.0 * STEP) * sqrt(2.0 / A)

    def measured(self, V, width=1e-7):
        """Return the same by simulation, from two balls that hit: the rest is of first order in the depth."""
        origin, edge = self.comes(*self.passing(self.graze())[:3]), self.graze()
        way = np.sign(self.passing(self.span[1])[3])
        controls = [edge + way * share * abs(self.span[1] - self.span[0]) * width for share in (1.0, 0.25, 0.0625)]
        roots = np.sqrt([self.passing(control)[3] for control in controls])
        moved = [self.whole(control, V) - origin for control in controls]
        _square, slope, gap = np.polyfit(roots, moved, 2)
        return gap, slope


class OnTable(Rung):
    """A table whose bumper is a disc: ``begin(control)`` is a start and its time, ``before`` the impacts until then."""

    def __init__(self, name, table, bumper, begin, before, span):
        self.name, self.table, self.bumper, self.begin, self.before, self.span = (
            name,
            table,
            bumper,
            begin,
            before,
            span,
        )
        others = [one for one in table.objects if one.name != bumper]
        self.bare = gz.table(others, table.rho, table.g, table.tilt, table.player)
        self.centre = np.array([table.params[f"{bumper}.x"], table.params[f"{bumper}.y"]])
        self.size = table.params[f"{bumper}.radius"] + table.rho
        _place, nx, ny = self.impact(self.bare, *self.begin(self.graze()), before)
        self.along = np.array([-ny, nx])  # the surface on which the ball lands that grazes

    def impact(self, table, state, t, number):
        """Return where an impact is, after so many others, and the normal there."""
        flown = gz.trajectory(table, state, start=t, until=t + 10.0)
        before, after = flown.before.values[number], flown.after.values[number]
        push = after[2:] - before[2:]
        return after[:2], *(push / np.hypot(*push))

    def passing(self, control):
        """Return (time, place, velocity, depth) where the ball is deepest in the bumper if that is not there."""
        state, start = self.begin(control)
        flown = gz.trajectory(self.bare, state, start=start, until=start + 10.0)
        x, y, vx, vy = flown.after.values[self.before - 1]
        g, (dx, dy) = self.table.gravity, np.array([x, y]) - self.centre
        t = np.roots([0.5 * g * g, -1.5 * g * vy, vx * vx + vy * vy - g * dy, dx * vx + dy * vy])
        t = t[(abs(t.imag) < 1e-9) & (t.real > 0.0)].real
        away = np.hypot(dx + vx * t, dy + (vy - 0.5 * g * t) * t)
        t, least = t[away.argmin()], away.min()
        place = np.array([x + vx * t, y + (vy - 0.5 * g * t) * t])
        return flown.impact_time.values[self.before - 1] + t, place, np.array([vx, vy - g * t]), self.size - least

    def frame(self, _t, place, velocity):
        """Return the normal, the acceleration of the gap, and how fast a kick of 1 changes by turns or drag."""
        n = (place - self.centre) / np.hypot(*(place - self.centre))
        tau = np.array([-n[1], n[0]])
        along = velocity @ tau
        return n, along**2 / self.size - self.table.gravity * n[1], -along / self.size * tau

    def comes(self, t, place, velocity):
        """Return what comes next after a flight without the bumper, a number."""
        return self.impact(self.bare, (*place, *velocity), t, 0)[0] @ self.along

    def whole(self, control, V):
        """Return the same from the begin on, with the bumper."""
        table = self.table.replace(**{f"{self.bumper}.V": V, f"{self.bumper}.r": R})
        hit = self.passing(control)[3] > 0.0
        return self.impact(table, *self.begin(control), self.before + hit)[0] @ self.along


class OnLine(Rung):
    """A ball on a line: ``model(there, V)`` with and without the bumper, a wall at ``at`` with the normal ``n``.

    The control is the velocity at t = 0. Between the times ``turn`` the ball turns back; the gap accelerates by A(t).
    What comes next is the time of an impact with the floor, a wall called A, or the place at the strobe, if any.
    """

    def __init__(self, name, model, n, at, u0, span, turn, A, strobe=None):
        self.name, self.model, self.at, self.u0, self.span, self.turn = name, model, at, u0, span, turn
        self.n, self.A, self.strobe = np.array([n]), A, strobe

    def passing(self, control):
        """Return (time, place, velocity, depth) where the ball is deepest in the bumper if that is not there."""

        def state(t):
            flown = gz.trajectory(self.model(False, 0.0), (self.u0, control), until=t)
            return flown.u.values[-1], flown.v.values[-1]

        t = brentq(lambda t: state(t)[1], *self.turn, xtol=1e-15, rtol=1e-15)
        u, _v = state(t)
        return t, np.array([u]), np.zeros(1), self.n[0] * (self.at - u)

    def frame(self, t, _place, _velocity):
        """Return the normal, the acceleration of the gap, and how fast a kick of 1 changes by turns or drag."""
        return self.n, self.A(t), -self.model(True, 0.0).params["alpha"] * self.n

    def seen(self, model, state, t, floors):
        """Return what comes next, after so many impacts with the floor."""
        flown = gz.trajectory(model, state, start=t, until=self.strobe or t + 12.0)
        if self.strobe:
            return flown.u.values[-1]
        return flown.impact_time.values[flown.impact_wall.values == "A"][floors]

    def comes(self, t, place, velocity):
        """Return what comes next after a flight without the bumper, a number."""
        return self.seen(self.model(False, 0.0), (place[0], velocity[0]), t, 0)

    def whole(self, control, V):
        """Return the same from the begin on, with the bumper."""
        return self.seen(self.model(True, V), (self.u0, control), 0.0, 1)


def machine():
    """Make the machine that ships, worked by a clock: the plunger's speed decides how deep the second bumper is hit."""
    table = gz.read_table("classic")
    player = gz.flips(0.5, 0.15, {"left_flipper": 0.0, "right_flipper": 0.25})
    table = gz.table(table.objects, table.rho, table.g, table.tilt, player)
    return OnTable("classic", table, "bumper2", lambda v: ((5.275, 0.7, 0.0, v), 0.0), 1, (14.09, 14.1))


def one_bumper():
    """Put one bumper above two flippers worked by a clock: when the ball is dropped decides how it is hit."""
    law, stroke = gz.newton(0.85), {"up": 25.0, "down": 15.0}
    points = {"left": (0.3, 10, 0.3, 2.6), "right": (4.75, 2.6, 4.75, 10), "top": (4.75, 10, 0.3, 10)}
    points |= {"left_lane": (0.3, 2.6, 1.38, 1.83), "right_lane": (4.75, 2.6, 3.67, 1.83)}
    objects = [
        gz.disc("bumper", (2.525, 7.0), 0.4, gz.active(r=R, V=8.0)),
        gz.flipper("L", (1.5, 1.7), 0.8, (0.11, 0.06), -0.5, 0.5, gz.newton(0.7), **stroke),
        gz.flipper("R", (3.55, 1.7), 0.8, (0.11, 0.06), pi + 0.5, pi - 0.5, gz.newton(0.7), **stroke),
        *(gz.segment(name, (a, b), (c, d), law) for name, (a, b, c, d) in points.items()),
        gz.drain("out", (0.3, 0), (4.75, 0)),
    ]
    table = gz.table(objects, rho=0.135, g=98.1, tilt=0.113, player=gz.flips(1.0, 0.1))
    return OnTable("one bumper", table, "bumper", lambda t: ((1.45, 3.5, 0.0, 0.0), t), 2, (0.18, 0.2))


def returned():
    """Let a ball fall on a moving floor, a flipper that is always there, below the bumper."""

    def model(there, V):
        floor = gz.wall(0.0, gz.newton(0.7), motion=gz.Forcing(omega=2.0, sin=(0.3,), cos=()))
        bumper = [gz.wall(3.0, gz.active(R, V), side="above")] if there else []
        gravity = gz.Forcing(omega=2.0, offset=-1.0, cos=())
        return gz.Oscillator(alpha=0, k=0, forcing=gravity, walls=[floor, *bumper])

    return OnLine("returned", model, -1.0, 3.0, 2.0, (-2.5, -2.0), (1.2, 4.0), lambda t: 1.0)


def oscillator():
    """Make the oscillator (1.1): a spring and a periodic force return the ball."""

    def model(there, V):
        return gz.pinball(d=0.12, r=R, V=V, sigma=0.0 if there else -9.0)

    return OnLine(
        "oscillator", model, 1.0, 0.0, 0.05, (0.2, 0.5), (2.0, 2.6), lambda t: np.cos(2.2 * t) + 0.12, 2.0 * pi / 2.2
    )


def main(tokens=None):
    """Draw the picture of each rung, and return measured and predicted (gap, coefficient) by rung and kick."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=60, help="points a panel and kick")
    parser.add_argument("--out", default="road.png", help="file to write: .png, .pdf or .svg")
    options = parser.parse_args(tokens)

    fig, axes = gz.plot.panels(174, 60, columns=4)
    found = {}
    for rung, kick, ax in zip(
        (machine(), one_bumper(), returned(), oscillator()), (8.0, 8.0, 0.3, 0.2), axes, strict=True
    ):
        edge = rung.graze()
        origin, wide = rung.comes(*rung.passing(edge)[:3]), 0.001 * (rung.span[1] - rung.span[0])
        controls = edge + wide * np.linspace(-1.0, 1.0, options.points)
        depths = np.array([rung.passing(control)[3] for control in controls])
        for V, colour in ((0.0, "C0"), (kick, "C1")):
            (gap, slope), (by_gap, by_slope) = rung.predicted(V), rung.measured(V)
            found[rung.name, V] = (by_gap, by_slope), (gap, slope)
            moved = [rung.whole(control, V) - origin for control in controls]
            line = np.linspace(0.0, depths.max(), 100)
            ax.plot(1e3 * depths, moved, ".", ms=2, color=colour, label=f"V = {V:g}")
            ax.plot(1e3 * line, gap + slope * np.sqrt(line), lw=0.8, color=colour)
            print(f"{rung.name:10s} V = {V:<3g}  gap {by_gap:+.6f}, by formula {gap:+.6f}"
                  f"  coefficient {by_slope:+.5f}, by formula {slope:+.5f}")  # fmt: skip
        ax.set_title(rung.name)
        ax.set_xlabel("depth of the graze × 1000")
        ax.legend(frameon=False, fontsize="x-small", handletextpad=0.0)
    axes[0].set_ylabel("by how much what comes next moves")
    print(f"written: {gz.plot.save(fig, options.out)}")
    return found


if __name__ == "__main__":
    main()
