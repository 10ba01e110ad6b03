"""From mass, damper, spring and stop in SI units to the numbers of the model, which have no mass and a wall below."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite, pi, sqrt
from typing import Any, NamedTuple

from grazing.oscillator.forcing import MOST_HARMONICS, Forcing, refuse_out_of_range
from grazing.outcome import InputError, shown
from grazing.parameter import Parameter, in_order, real
from grazing.units import magnitude

M = Parameter("m", "m", "mass", 0.0, inf, "low", "kg")
C = Parameter("c", "c", "viscous damping", 0.0, units="N s/m")
K = Parameter("k", "k", "stiffness of the spring", 0.0, units="N/m")
GAP = Parameter("gap", "g", "distance from the rest position to the stop", 0.0, units="m")
LOAD = Parameter("load", "F_0", "constant force, positive upwards", units="N")
FREQUENCY = Parameter("frequency", "f", "frequency of the forcing in turns", 0.0, inf, "low", "Hz")
OMEGA = Parameter("omega", r"\omega", "frequency of the forcing", 0.0, inf, "low", "rad/s")
SI = {known.name: known for known in (M, C, K, GAP, LOAD, FREQUENCY, OMEGA)}
#: Amplitudes of harmonics, with their units.
AMPLITUDES = {"force": "N", "base": "m", "acceleration": "m/s^2"}
#: Whether u points up or down: it is the height above the stop that counts, seen from the stop.
SIDES = {"below": 1.0, "above": -1.0}
#: What a moving base carries along.
MOVES = ("both", "spring", "stop")


class Base(NamedTuple):
    """A base whose amplitude stays as it is while the frequency varies, and what else forces the mass.

    Harmonic j of the base is (displacement_j + acceleration_j/(j omega)^2) cos(j omega t), with the sign of u.
    ``cos`` and ``sin`` are the forces per unit of mass that do not come from the base. All have the same length.
    """

    moves: str
    displacement: tuple[float, ...]
    acceleration: tuple[float, ...]
    cos: tuple[float, ...]
    sin: tuple[float, ...]

    def forces(self, alpha: Any, k2: Any, omega: Any) -> list[tuple[Any, Any]]:
        """Return cosine and sine amplitude of each harmonic of the force per unit of mass; arrays are fine.

        ``k2`` is the stiffness per unit of mass.
        """
        found = []
        parts = zip(self.displacement, self.acceleration, self.cos, self.sin, strict=True)
        for j, (length, acceleration, cos, sin) in enumerate(parts, start=1):
            W = j * omega
            z = length + acceleration / (W * W)
            inertia = length * W * W + acceleration if self.moves != "spring" else 0.0
            side = {"both": 0.0, "spring": 1.0, "stop": -1.0}[self.moves]
            found.append((cos + inertia + side * k2 * z + 0.0, sin - side * alpha * W * z + 0.0))
        return found

    def row(self, values: Any, k2: Any) -> None:
        """Write the forces into all parameters of models of stiffness ``k2``, shape (..., parameters), in place."""
        for j, (cos, sin) in enumerate(self.forces(values[..., 0], k2, values[..., 2])):
            values[..., 5 + 2 * j], values[..., 6 + 2 * j] = cos, sin

    @property
    def made(self) -> tuple[str, ...]:
        """The parameters of the model that are made from the base."""
        return tuple(f"{name}{j}" for j in range(1, len(self.cos) + 1) for name in ("cos", "sin"))

    @property
    def alone(self) -> Base:
        """The base without the forces that do not come from it."""
        return self._replace(cos=(0.0,) * len(self.cos), sin=(0.0,) * len(self.sin))

    @property
    def text(self) -> str:
        """The base as one line, which :func:`base_of` reads."""
        parts = {name: values for name, values in zip(self._fields[1:], self[1:], strict=True) if any(values)}
        said = (f",{name}={' '.join(map(repr, values))}" for name, values in parts.items())
        return f"moves={self.moves}{''.join(said)}"


def base_of(text: Any) -> Base:
    """Return the base that :attr:`Base.text` has written.

    Raises
    ------
    InputError
        For anything else.
    """
    wanted = "give moves=both, spring or stop, and displacement=..., acceleration=..., cos=..., sin=... by harmonics"
    try:
        parts = dict(part.split("=") for part in text.split(","))
        moves = parts.pop("moves").strip()
        lists = {name.strip(): tuple(real(float(x), name, "") for x in part.split()) for name, part in parts.items()}
    except (AttributeError, ValueError, LookupError):
        raise InputError(f"base = {shown(text)}; {wanted}") from None
    if moves not in MOVES or not set(lists) <= set(Base._fields) or len(lists) == 0:
        raise InputError(f"base = {shown(text)}; {wanted}")
    return based(moves, *(lists.get(name, ()) for name in Base._fields[1:]))


def based_on(text: str | None, forcing: Forcing) -> Base | None:
    """Return the base that a text describes, with the force beside it; None for no text."""
    if text is None:
        return None
    moved = base_of(text)
    return based(moved.moves, moved.displacement, moved.acceleration, tuple(forcing.cos), tuple(forcing.sin))


def based(moves: str, *lists: tuple[float, ...]) -> Base:
    """Return a base of which all lists are as long as the longest one."""
    most = max(1, *map(len, lists))
    if most > MOST_HARMONICS:
        raise InputError(f"base and force have {most} harmonics; allowed are at most {MOST_HARMONICS}")
    return Base(moves, *((*one, *[0.0] * (most - len(one))) for one in lists))


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
    base: Base | None


def si_numbers(
    m: Any, c: Any, k: Any, force: Any, gap: Any, side: Any, base: Any, moves: Any, load: Any, frequency: Any,
    omega: Any, acceleration: Any = 0.0,
) -> Numbers:  # fmt: skip
    """Return the numbers of the model; see :meth:`grazing.Oscillator.from_si` for what is given.

    With x upwards from the place where the spring is relaxed, m x'' + c x' + k x = F(t) + load, and z the motion of
    the base, y = x - z is what a moving stop sees. Then u = y for a stop below, u = -y for one above.
    """
    checked_side(side, "side")
    _checked_moves(moves)
    mass, damping, stiffness = _checked(M, m), _checked(C, c), _checked(K, k)
    distance = _distance(gap, side)
    w = _frequency(frequency, omega)
    sign = SIDES[side] / mass
    amplitudes = (base, "base"), (acceleration, "acceleration"), (force, "force")
    shakes, jerks, pushes = (_amplitudes(value, name, AMPLITUDES[name]) for value, name in amplitudes)
    signed = [tuple(SIDES[side] * x for x in one) for one in (shakes, jerks)]
    moved = based(moves, *signed, tuple(sign * x + 0.0 for x in pushes), ())
    natural = sqrt(stiffness / mass)
    cos, sin = zip(*moved.forces(damping / mass, natural * natural, w), strict=True)
    offset, shaken = sign * _checked(LOAD, load) + 0.0, any(shakes) or any(jerks)
    if not all(map(isfinite, (damping / mass, natural, offset, *cos, *sin))):
        raise InputError(
            f"m = {mass:g} kg: damping, stiffness, load or forces divided by it are larger than any double; give a "
            f"mass that they belong to"
        )
    return Numbers(
        mass, damping / mass, natural, w, offset, cos, sin, 0.0 - distance, moved if shaken else None
    )  # fmt: skip


def checked_side(side: Any, name: str) -> str:
    """Return where a stop is, or raise InputError."""
    if not isinstance(side, str) or side not in SIDES:
        raise InputError(f"{name} = {shown(side)}; allowed are 'above' and 'below', where the stop is")
    return side


def _checked(known: Parameter, value: Any) -> float:
    return known.check(magnitude(value, known.units, known.name))


def _checked_moves(moves: Any) -> None:
    if not isinstance(moves, str) or moves not in MOVES:
        raise InputError(
            f"moves = {shown(moves)}; allowed are 'both', 'spring' and 'stop', what the base carries along"
        )


def _distance(gap: Any, side: Any) -> float:
    """Return the distance to the stop in m."""
    distance = real(magnitude(gap, GAP.units, "gap"), "gap", f"allowed is {GAP.allowed} ({GAP.meaning})")
    if distance < 0.0:
        other = "below" if side == "above" else "above"
        raise InputError(
            f"gap = {distance:g} m; it is a distance, >= 0, and side says where the stop is: for one on the other side "
            f"give side={other!r}; for a spring that presses the mass onto the stop, gap=0 and that force as load"
        )
    return distance


def faults_of(given: Mapping[str, Any]) -> dict[str, str]:
    """Return what is wrong with each of the numbers and words that :func:`si_numbers` takes, by its name."""
    found = {}
    for name, value in given.items():
        try:
            if name == "side":
                checked_side(value, name)
            elif name == "moves":
                _checked_moves(value)
            elif name.endswith("gap"):
                _distance(value, given.get("side", "above"))
            elif name in AMPLITUDES:
                _amplitudes(value, name, AMPLITUDES[name])
            elif value is not None or name not in ("frequency", "omega"):
                _checked(SI[name], value)
        except InputError as error:
            found[name] = str(error)
    return found


def _frequency(frequency: Any, omega: Any) -> float:
    """Return the frequency of the forcing in rad/s."""
    if (frequency is None) == (omega is None):
        both = "neither is" if omega is None else "both are"
        raise InputError(f"{both} given; give frequency, in Hz, or omega, in rad/s")
    unit = 1.0 if frequency is None else 2.0 * pi
    found = unit * (_checked(OMEGA, omega) if frequency is None else _checked(FREQUENCY, frequency))
    refuse_out_of_range(found, "omega" if frequency is None else "frequency", unit)  # its square divides forces
    return found


def _amplitudes(values: Any, name: str, units: str) -> tuple[float, ...]:
    """Return the amplitudes of harmonics 1, 2, ...; one number is that of the first."""
    wanted = f"any finite amplitude in {units} is allowed"
    try:
        found = in_order(magnitude(values, units, name))
    except TypeError as error:
        raise InputError(f"{name} = {shown(values)}; {error}: {wanted}, or several in order") from None
    several = [found] if getattr(found, "ndim", 1) == 0 or not hasattr(found, "__len__") else found
    return tuple(real(magnitude(one, units, f"{name}[{j}]"), f"{name}[{j}]", wanted) for j, one in enumerate(several))
