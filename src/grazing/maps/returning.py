"""From one impact to the next: what impact maps share, over one wall or between several."""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

from grazing.kernel.elementary import length
from grazing.maps.period import log_size
from grazing.oscillator.constants import forcing
from grazing.oscillator.contact import Ball, Launch
from grazing.oscillator.flight import modes

#: Periods without an impact after which the step gives up by name.
MAX_PERIODS = 1000
INFINITY = float("inf")
NAN = float("nan")


class Doubt(NamedTuple):
    """How wrong a ball may be that has flown for many periods: bounds on y and v, and one on sqrt(k^2 y^2 + v^2)."""

    y: float
    v: float
    energy: float


NO_DOUBT = Doubt(0.0, 0.0, 0.0)


def within_period(tau: float, T: float) -> float:
    """Return a time less whole periods, in [0, T]; 0 where so large a double has no phase, and little is left of it.

    Fast arithmetic finds the rest exactly, of a number of periods that is rounded: it may be below 0 by many of them.
    """
    start = tau - T * (tau // T)
    return start if 0.0 <= start <= T else 0.0


def next_period(ball: Ball, doubt: Doubt, c: Any) -> tuple[Ball, Doubt]:
    """Return the ball at the end of a period as the same ball at the beginning of the next, and how wrong it may be.

    Bounds that go from piece to piece by the sizes of the modes grow with every piece, where the errors themselves
    fade: the free ball gains no energy. Here the errors of each period are added up, and go on as those of a departure.
    Where it may gain energy they grow with the modes alone; beyond all doubles they are infinite.
    """
    E11, E12, E21, E22 = modes(c.T, c)
    y = abs(E11) * doubt.y + abs(E12) * doubt.v + ball.error_y
    v = abs(E21) * doubt.y + abs(E22) * doubt.v + ball.error_v
    if c.grows > 0.0:
        y, v = (y if y >= 0.0 else INFINITY), (v if v >= 0.0 else INFINITY)
        return Ball(0.0, ball.y, ball.v, 0, 0.0, 0.0, Launch(0.0, 1.0, 0.0, y, v)), Doubt(y, v, INFINITY)
    root = sqrt(c.k2)
    energy = doubt.energy + length(root * ball.error_y, ball.error_v)
    y = energy / root if energy < root * y else y
    v = min(v, energy)
    return Ball(0.0, ball.y, ball.v, 0, 0.0, 0.0, Launch(0.0, 1.0, 0.0, y, v)), Doubt(y, v, energy)


def derivative(start: float, w: float, end: float, v: float, g: float, turn: float, left: Any, c: Any) -> Any:
    """Return the Jacobian of (tau, w) -> (tau', w') from the flight between the impacts, and the logarithm of |det J|.

    g = law'(v), and c is what the wall sees that is hit, ``left`` what the one sees that was left; ``turn`` is -1
    where the two are on different sides of the ball, else 1. NaN for v = 0. The flight keeps w dtau dw but for damping,
    so det J = g w/v exp(-alpha s).
    """
    if v == 0.0:
        return NAN, NAN, NAN, NAN, NAN
    E11, E12, E21, E22 = modes(end - start, c)
    F0, _dF0 = forcing(start, left)
    F1, _dF1 = forcing(end - c.T * (end // c.T), c)
    lift, fall = F0 - c.alpha * w, F1 - c.alpha * v
    # starting later by dtau is starting at (-w dtau, -lift dtau) in the flight's own time
    y_tau, v_tau = -turn * (E11 * w + E12 * lift), -turn * (E21 * w + E22 * lift)
    tau_tau, tau_w = -y_tau / v, -turn * E12 / v
    area = log_size(g * w / v) - c.alpha * (end - start)
    return tau_tau, tau_w, g * (v_tau + fall * tau_tau), g * (turn * E22 + fall * tau_w), area
