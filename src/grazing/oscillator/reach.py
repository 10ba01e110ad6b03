"""How far and how fast the ball of an oscillator goes: the scale in which its starts are drawn and its law is probed.

In units of length and time of any size: every number here is made of the model's own.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import Any, NamedTuple

from grazing.kernel.elementary import exp, length

#: The least share of its speed that a ball is taken to lose from impact to impact; without it, r = 1 knows no bound.
LEAST_LOSS = 0.02
#: How far from resonance a ball that hits is at least, as a share of k^2 + omega^2: impacts break the phase.
DETUNED = 0.25
#: Periods of travel beyond which no start is drawn.
LONGEST = 1000.0
#: Numbers that go no further, so that no product of them is lost.
SMALL, LARGE = 1e-150, 1e150


class Reach(NamedTuple):
    """Where orbits stay as a rule: the wall, the period, the height above the wall, speeds in flight, after an impact.

    Estimated from force, spring, gap, frequency and the law.
    """

    sigma: float
    period: float
    height: float
    speed: float
    after: float


def natural(stiffness: float) -> float:
    """Return the natural frequency of a stiffness, 0 where it holds nothing back."""
    return sqrt(max(stiffness, 0.0))


def drive_of(alpha: float, k: float, omega: float, F0: float, cos: Any, sin: Any) -> tuple[float, float]:
    """Return how far the force moves the ball between impacts, and how fast."""
    width, speed = 0.0, 0.0
    for j in range(len(cos)):
        W = (j + 1) * omega
        amplitude = length(cos[j], sin[j])
        a, b = k * k - W * W, alpha * W
        response = amplitude / max(sqrt(a * a + b * b), DETUNED * (k * k + W * W))
        width += response
        speed += W * response
    if speed == 0.0:  # what a constant force does in a quarter of a period
        rest = 0.5 * pi / max(omega, k)
        width, speed = 0.5 * abs(F0) * rest * rest, abs(F0) * rest
    return width, speed


def reach_of(
    alpha: float, k: float, omega: float, F0: float, cos: Any, sin: Any, sigma: float, r: float, V: float
) -> tuple[float, float, float]:
    """Return the height above the wall and the speeds, in flight and after an impact, that orbits stay below.

    An impact loses (1 - r) of the speed and flight what the damping takes; the drive and the kick V give it back. That
    balance is the speed after an impact, and the constant force and the spring say how high it goes.
    """
    T = 2.0 * pi / omega
    width, drive = drive_of(alpha, k, omega, F0, cos, sin)
    kept = r * exp(-0.5 * alpha * (min(pi / k, T) if k > 0.0 else T))
    speed = ((1.0 + r) * drive + V) / max(1.0 - kept, LEAST_LOSS)
    if speed <= SMALL:  # nothing moves it: any unit of length is as good, the gap's the best
        speed = omega * (abs(sigma) if sigma != 0.0 else 1.0)
    speed = max(min(speed, LARGE), SMALL)
    fall = sqrt(F0 * F0 + k * k * speed * speed)
    travel = T * (speed + abs(F0) * T)
    height, fastest = travel, speed
    if F0 < 0.0:
        height = speed * (speed / (fall - F0))
    elif k > 0.0:
        height = min((F0 + fall) / k / k, LONGEST * travel)  # k * k may be below all doubles
        fastest = min(fall / k, LONGEST * travel / T)
    height = max(min(height, LONGEST * travel) + width, 1e-6 * abs(sigma))
    return max(min(height, LARGE), SMALL), min(fastest, LARGE), speed


def before_saddle(reach: tuple[float, float, float], F0: float, stiffness: float) -> tuple[float, float, float]:
    """Return the reach cut to where a negative stiffness does not carry the ball away; else as it is.

    At the height F0/k^2 it balances a force F0 < 0 towards the wall. Unforced orbits below it stay where
    |v| < |k| (F0/k^2 - y); half of that height, with half of that speed at the wall, lies within.
    """
    if not (stiffness < 0.0 and F0 < 0.0):
        return reach
    height, speed = 0.5 * (F0 / stiffness), 0.5 * (-F0 / sqrt(-stiffness))
    return min(reach[0], height), min(reach[1], speed), min(reach[2], speed)
