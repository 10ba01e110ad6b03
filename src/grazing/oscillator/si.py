"""From mass, damper, spring and stop in SI units to the numbers of the model, which have no mass and a wall below."""

from __future__ import annotations

from math import inf, pi, sqrt
from typing import Any, NamedTuple

from grazing.outcome import InputError, shown
from grazing.parameter import Parameter, real
from grazing.units import magnitude

M = Parameter("m", "m", "mass", 0.0, inf, "low", "kg")
C = Parameter("c", "c", "viscous damping", 0.0, units="N s/m")
K = Parameter("k", "k", "stiffness of the spring", 0.0, units="N/m")
GAP = Parameter("gap", "g", "distance from the rest position to the stop", 0.0, units="m")
LOAD = Parameter("load", "F_0", "constant force, positive upwards", units="N")
FREQUENCY = Parameter("frequency", "f", "frequency of the forcing in turns", 0.0, inf, "low", "Hz")
OMEGA = Parameter("omega", r"\omega", "frequency of the forcing", 0.0, inf, "low", "rad/s")
SI = {known.name: known for known in (M, C, K, GAP, LOAD, FREQUENCY, OMEGA)}
#: Whether u points up or down: it is the height above the stop that counts, seen from the stop.
SIDES = {"below": 1.0, "above": -1.0}
#: What a moving base carries along.
MOVES = ("both", "spring", "stop")


class Numbers(NamedTuple):
    """What the model is made of: damping, natural frequency, forcing and wall, per unit of mass."""

    mass: float
    alpha: float
    k: float
    omega: float
    offset: float
    cos: tuple[float, ...]
    sin: tuple[float, ...]
    sigma: float


def si_numbers(
    m: Any, c: Any, k: Any, force: Any, gap: Any, side: Any, base: Any, moves: Any, load: Any, frequency: Any,
    omega: Any,
) -> Numbers:  # fmt: skip
    """Return the numbers of the model; see :meth:`grazing.Oscillator.from_si` for what is given.

    With x upwards from the place where the spring is relaxed, m x'' + c x' + k x = F(t) + load, and z the motion of
    the base, y = x - z is what a moving stop sees. Then u = y for a stop below, u = -y for one above.
    """
    if not isinstance(side, str) or side not in SIDES:
        raise InputError(f"side = {shown(side)}; allowed are 'above' and 'below', where the stop is")
    if not isinstance(moves, str) or moves not in MOVES:
        raise InputError(
            f"moves = {shown(moves)}; allowed are 'both', 'spring' and 'stop', what the base carries along"
        )
    mass, damping, stiffness = _checked(M, m), _checked(C, c), _checked(K, k)
    distance = real(magnitude(gap, GAP.units, "gap"), "gap", f"allowed is {GAP.allowed} ({GAP.meaning})")
    if distance < 0.0:
        other = "below" if side == "above" else "above"
        raise InputError(
            f"gap = {distance:g} m; it is a distance, >= 0, and side says where the stop is: for one on the other side "
            f"give side={other!r}; for a spring that presses the mass onto the stop, gap=0 and that force as load"
        )
    w = _frequency(frequency, omega)
    pushes, shakes = _amplitudes(force, "force", "N"), _amplitudes(base, "base", "m")
    sign = SIDES[side] / mass
    cos, sin = list[float](), list[float]()
    for j in range(1, max(len(pushes), len(shakes), 1) + 1):
        push, z, jw = _at(pushes, j), _at(shakes, j), j * w
        inertia = mass * jw * jw * z if moves != "spring" else 0.0
        spring = {"both": 0.0, "spring": stiffness * z, "stop": -stiffness * z}[moves]
        damper = {"both": 0.0, "spring": -damping * jw * z, "stop": damping * jw * z}[moves]
        cos.append(sign * (push + inertia + spring) + 0.0)
        sin.append(sign * damper + 0.0)  # no negative zero
    return Numbers(
        mass, damping / mass, sqrt(stiffness / mass), w, sign * _checked(LOAD, load) + 0.0, tuple(cos), tuple(sin),
        0.0 - distance,
    )  # fmt: skip


def _checked(known: Parameter, value: Any) -> float:
    return known.check(magnitude(value, known.units, known.name))


def _frequency(frequency: Any, omega: Any) -> float:
    """Return the frequency of the forcing in rad/s."""
    if (frequency is None) == (omega is None):
        both = "neither is" if omega is None else "both are"
        raise InputError(f"{both} given; give frequency, in Hz, or omega, in rad/s")
    return _checked(OMEGA, omega) if frequency is None else 2.0 * pi * _checked(FREQUENCY, frequency)


def _amplitudes(values: Any, name: str, units: str) -> tuple[float, ...]:
    """Return the amplitudes of harmonics 1, 2, ...; one number is that of the first."""
    found = magnitude(values, units, name)
    several = [found] if getattr(found, "ndim", 1) == 0 or not hasattr(found, "__len__") else found
    return tuple(
        real(magnitude(one, units, f"{name}[{j}]"), f"{name}[{j}]", f"any finite amplitude in {units} is allowed")
        for j, one in enumerate(several)
    )


def _at(amplitudes: tuple[float, ...], j: int) -> float:
    return amplitudes[j - 1] if j <= len(amplitudes) else 0.0
