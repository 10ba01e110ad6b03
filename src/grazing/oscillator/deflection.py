"""How far the force on a rig can move its mass, and a warning where the stop lies far beyond."""

from __future__ import annotations

import warnings
from functools import lru_cache
from math import hypot, inf, sqrt

from grazing.oscillator.si import Numbers

#: How many times the largest deflection a gap may be: millimetres that are taken for metres make it 1000 times as wide.
FAR = 10.0
#: Frequencies, in natural ones, that stand for a very slow and a very fast forcing.
SLOW, FAST = 1e-3, 1e3


def largest_deflection(found: Numbers) -> float:
    """Return the largest distance from the rest position that a force or a base brings, at whatever frequency, in m.

    The sum of what the constant force and each harmonic do alone, in the steady motion without impacts; relative to the
    base, if that carries the stop. Infinite without a spring or damping: there is no such distance.
    """
    alpha, k = found.alpha, found.k
    if not (alpha > 0.0 and SLOW * k * SLOW * k > 0.0):
        return inf
    peak = sqrt(max(k * k - 0.5 * alpha * alpha, 0.0))  # where a constant amplitude of the force moves it most
    total = abs(found.offset) / k / k
    for j in range(1, len(found.cos) + 1):
        most = 0.0
        for W in (SLOW * k, peak or k, k, j * found.omega, FAST * k):
            cos, sin = (
                (found.cos[j - 1], found.sin[j - 1])
                if found.base is None
                else found.base.forces(alpha, k * k, W / j)[j - 1]
            )
            against = hypot(k * k - W * W, alpha * W)
            most = max(most, hypot(cos, sin) / against if against > 0.0 else inf)
        total += most
    return total


def warn_of_gap(found: Numbers, gap: float, stacklevel: int = 3) -> None:
    """Warn of a stop that no force brings the mass to: lengths in mm were perhaps given without their unit."""
    most = largest_deflection(found)
    if 0.0 < most and gap > FAR * most:
        _warn_once(float(gap), float(most), stacklevel)


@lru_cache(maxsize=256)
def _warn_once(gap: float, most: float, stacklevel: int) -> None:
    """Warn once of each rig, though a study makes many of it."""
    warnings.warn(
        f"the gap is {gap:g} m and the largest deflection that force and load bring, at any frequency, {most:.3g} m: "
        "from rest the mass never touches the stop. A plain number is in metres; write '1.2 mm' or 1.2e-3",
        UserWarning,
        stacklevel=stacklevel + 1,
    )
