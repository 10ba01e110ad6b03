"""The free flight as the finder of proofs sees it: one matrix exponential of a linear system, stepped in balls.

The forcing joins the state: z = (y, v, F0, a_1, b_1, ...) with a_j the force of harmonic j, so that z' = M z has no
singular case. A parameter may be a ball; the derivative by it then obeys the same kind of system, twice as large.
Velocities and forces are scaled by a rate, a power of two, so that all entries of M are of one size.
"""

from __future__ import annotations

from math import ceil, frexp
from typing import TYPE_CHECKING, NamedTuple

from grazing.oscillator.rig import Rig
from grazing.proof.seen import Seen

if TYPE_CHECKING:
    from flint import arb, arb_mat

#: Most steps in one flight; beyond, a proof gives up.
MOST_STEPS = 20_000


class TooLong(ArithmeticError):
    """The flight has too many time scales to be followed in steps."""


class Blurred(TooLong):
    """The balls grow so much on the way that the digits at hand are lost."""


class Moment(NamedTuple):
    """Height, velocity and their derivatives by the parameter (0 without one) at one time of a flight."""

    y: arb
    v: arb
    dy: arb
    dv: arb


class Flow:
    """Free flights of a model, as one of its walls sees them, at the working precision.

    Parameters
    ----------
    model : Rig
        Its parameters are exact doubles.
    name : str, optional
        A parameter that takes ``value`` instead; derivatives by it are carried along if ``derivative`` is set.
    wall : int
        The wall, by its number.
    """

    def __init__(
        self, model: Rig, name: str | None = None, value: arb | None = None, derivative: bool = False, wall: int = 0
    ) -> None:
        from flint import arb, arb_mat

        self.seen = Seen(model, name, value)
        p, k2 = self.seen.all, self.seen.stiffness
        level, waves = self.seen.motion(wall)
        self.alpha, self.k2, self.omega = p["alpha"].x, k2.x, p["omega"].x
        self.t0, self.dt0, self.domega = p["t0"].x, p["t0"].d, p["omega"].d
        self.level, self.dlevel = level.x, level.d
        self.T = 2 * arb.pi() / self.omega
        self.dT = -self.T / self.omega * self.domega
        self.waves = [(j, c.x, s.x, c.d, s.d) for j, c, s in waves if not (c.nothing and s.nothing)]
        fastest = max((j for j, *_rest in self.waves), default=0) * model.forcing.omega
        rate = max(abs(model.alpha) + abs(model.k2) ** 0.5 + fastest, model.forcing.omega)
        self.reach: float = 0.5 / rate  # of one step
        self.fresh = 4  # steps after which the harmonics are put anew
        self.scale = arb(2) ** (frexp(rate)[1] - 1)
        s, size = self.scale, 3 + 2 * len(self.waves)
        rows = [[arb(0)] * size for _ in range(size)]
        slopes = [[arb(0)] * size for _ in range(size)]
        rows[0][1], rows[1][0], rows[1][1], rows[1][2] = s, -self.k2 / s, -self.alpha, s
        slopes[1][0], slopes[1][1] = -k2.d / s, -p["alpha"].d
        for i, (j, *_rest) in enumerate(self.waves):
            a, b = 3 + 2 * i, 4 + 2 * i
            rows[1][a], rows[a][b], rows[b][a] = s, j * self.omega, -j * self.omega
            slopes[a][b], slopes[b][a] = j * self.domega, -j * self.domega
        self.size, self.derivative = size, derivative
        if derivative:
            none = [arb(0)] * size
            rows = [row + none for row in rows] + [slope + row for slope, row in zip(slopes, rows, strict=True)]
        self.system = arb_mat(rows)

    def start(self, t: arb, y: arb, v: arb) -> arb_mat:
        """Return the state z of a flight that is at (y, v) at time t."""
        from flint import arb, arb_mat

        s2 = self.scale**2
        z, dz = [y, v / self.scale, self.level / s2], [arb(0), arb(0), self.dlevel / s2]
        swing, dswing = self._swing(t)
        return arb_mat([[x] for x in (z + swing + dz + dswing if self.derivative else z + swing)])

    def _swing(self, t: arb) -> tuple[list[arb], list[arb]]:
        """Return the part of the state at time t that belongs to the harmonics, and its derivatives."""
        s2 = self.scale**2
        swing, dswing = [], []
        for j, c, s, dc, ds in self.waves:
            sine, cosine = (j * self.omega * (t + self.t0)).sin_cos()
            a, b = c * cosine + s * sine, s * cosine - c * sine
            swing += [a / s2, b / s2]
            if self.derivative:
                turned = j * (self.domega * (t + self.t0) + self.omega * self.dt0)
                dswing += [(dc * cosine + ds * sine + b * turned) / s2, (ds * cosine - dc * sine - a * turned) / s2]
        return swing, dswing

    def refresh(self, z: arb_mat, t: arb) -> None:
        """Put the harmonics of a state at time t anew: stepping would let their balls grow with every turn."""
        swing, dswing = self._swing(t)
        for i, x in enumerate(swing):
            z[3 + i, 0] = x
        for i, x in enumerate(dswing):
            z[self.size + 3 + i, 0] = x

    def force(self, t: arb) -> arb:
        """Return F at time t."""
        total = self.level
        for j, c, s, _dc, _ds in self.waves:
            sine, cosine = (j * self.omega * (t + self.t0)).sin_cos()
            total = total + c * cosine + s * sine
        return total

    def acceleration(self, t: arb, y: arb, v: arb) -> arb:
        """Return y'' at time t."""
        return self.force(t) - self.alpha * v - self.k2 * y

    def step(self, h: arb) -> arb_mat:
        """Return exp(M h)."""
        return (self.system * h).exp()

    def cell(self, h: arb) -> arb_mat:
        """Return a ball around all exp(M s), 0 <= s <= h."""
        from flint import arb

        return (self.system * (h * arb(0.5, 0.5))).exp()

    def count(self, L: arb) -> int:
        """Return the number of steps of a flight of length L."""
        steps = float(L.abs_upper()) / self.reach
        if not steps < MOST_STEPS:
            raise TooLong
        return max(1, ceil(steps))

    def fly(self, z: arb_mat, t: arb, L: arb) -> arb_mat:
        """Return the state after a flight of time L from time t."""
        m = self.count(L)
        h = L / m
        step = self.step(h)
        for i in range(1, m + 1):
            z = step * z
            if i % self.fresh == 0:
                self.refresh(z, t + i * h)
        return z

    def shifted(self, z: arb_mat, h: arb) -> arb_mat:
        """Return the state a short time h, of either sign, later."""
        return self.step(h) * z

    def transition(self, L: arb) -> tuple[arb, arb, arb, arb]:
        """Return the unforced flight E(L) of (y, v), row by row: E11, E12, E21, E22."""
        from flint import arb_mat

        m = self.count(L)
        one = self.step(L / m)
        two = arb_mat([[one[0, 0], one[0, 1]], [one[1, 0], one[1, 1]]])
        E = two**m
        return E[0, 0], E[0, 1] / self.scale, E[1, 0] * self.scale, E[1, 1]

    def transition_near(self, h: arb) -> tuple[arb, arb, arb, arb]:
        """Return E(h) of a short time h of either sign."""
        one = self.step(h)
        return one[0, 0], one[0, 1] / self.scale, one[1, 0] * self.scale, one[1, 1]

    def read(self, z: arb_mat) -> Moment:
        """Return what a state says of the ball."""
        from flint import arb

        if not self.derivative:
            return Moment(z[0, 0], z[1, 0] * self.scale, arb(0), arb(0))
        D = self.size
        return Moment(z[0, 0], z[1, 0] * self.scale, z[D, 0], z[D + 1, 0] * self.scale)
