"""The parameters of a model in balls, and what each of its walls sees of the motion; one parameter may be unknown.

Each number carries its derivative by the unknown parameter. For what a wall sees see :mod:`grazing.oscillator.walled`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from grazing.oscillator.forcing import amplitudes_in
from grazing.oscillator.rig import Rig
from grazing.oscillator.spring import spring_of

if TYPE_CHECKING:
    from flint import arb


@dataclass(frozen=True, slots=True)
class Dual:
    """A number and its derivative by the unknown parameter."""

    x: arb
    d: arb

    def __add__(self, other: Dual) -> Dual:
        return Dual(self.x + other.x, self.d + other.d)

    def __sub__(self, other: Dual) -> Dual:
        return Dual(self.x - other.x, self.d - other.d)

    def __mul__(self, other: Dual) -> Dual:
        return Dual(self.x * other.x, self.d * other.x + self.x * other.d)

    def times(self, factor: Any) -> Dual:
        """Return a multiple, by a number that is known exactly."""
        return Dual(self.x * factor, self.d * factor)

    def turned(self) -> tuple[Dual, Dual]:
        """Return cosine and sine."""
        sine, cosine = self.x.sin_cos()
        return Dual(cosine, -sine * self.d), Dual(sine, cosine * self.d)

    @property
    def nothing(self) -> bool:
        """Whether it is 0, and stays 0."""
        return bool(self.x.is_zero() and self.d.is_zero())


class Seen:
    """The parameters of a model; ``name`` takes ``value`` instead of its own."""

    def __init__(self, model: Rig, name: str | None = None, value: arb | None = None) -> None:
        from flint import arb

        self.model, self.name, self.walls = model, name, model.walls
        self.all = {key: Dual(arb(x), arb(1 if key == name else 0)) for key, x in model.params.items()}
        if name is not None and value is not None:
            self.all[name] = Dual(value, arb(1))

    @property
    def stiffness(self) -> Dual:
        """The stiffness: k^2, or as it was given."""
        name, _value = spring_of(self.model)
        return self.all[name] if name == "stiffness" else self.all[name] * self.all[name]

    def place_of(self, j: int) -> tuple[str, str]:
        """Return what stands in front of the names of a wall's position and law, and of its motion."""
        if not self.model.walled:
            return "", "no motion "
        own = f"{self.walls[j].name}."
        return own if len(self.walls) > 1 else "", own

    def law(self, j: int) -> tuple[dict[str, arb], str | None]:
        """Return the parameters of the law of a wall by their own names, and which of them is unknown."""
        front, _own = self.place_of(j)
        names = {key: f"{front}{key}" for key in self.walls[j].law.params}
        known = next((key for key, full in names.items() if full == self.name), None)
        return {key: self.all[full].x for key, full in names.items()}, known

    def position(self, j: int) -> Dual:
        """Return where a wall is, in the middle of its motion."""
        return self.all[f"{self.place_of(j)[0]}sigma"]

    def waves(self, front: str) -> list[tuple[int, Dual, Dual]]:
        """Return number, cosine and sine of each harmonic of the force, or of a wall's motion: its name is in front."""
        return [(j, c, s) for j, (c, s) in enumerate(zip(*amplitudes_in(self.all, front), strict=True), start=1)]

    def motion(self, j: int) -> tuple[Dual, list[tuple[int, Dual, Dual]]]:
        """Return the constant part and the harmonics of the force on a ball, as a wall sees it from y = 0."""
        sign, k2, alpha, omega = int(self.walls[j].sign), self.stiffness, self.all["alpha"], self.all["omega"]
        level = self.all[self.model.offset_name]
        level = (level - k2 * self.position(j)).times(sign)
        waves: Mapping[int, tuple[Dual, Dual]] = {i: (c, s) for i, c, s in self.waves("")}
        force = dict(waves)
        for i, c, s in self.waves(self.place_of(j)[1]):
            W = omega.times(i)
            inertia, drag, none = W * W - k2, alpha * W, c - c
            a, b = force.get(i, (none, none))
            force[i] = a + inertia * c - drag * s, b + inertia * s + drag * c
        return level, [(i, c.times(sign), s.times(sign)) for i, (c, s) in sorted(force.items())]

    def at(self, j: int, t: arb) -> tuple[Dual, Dual]:
        """Return where a wall is at time t, and how fast it moves."""
        place, rate = self.position(j), self.position(j).times(0)
        omega, late = self.all["omega"], Dual(t, 0 * t) + self.all["t0"]
        for i, c, s in self.waves(self.place_of(j)[1]):
            W = omega.times(i)
            cosine, sine = (W * late).turned()
            place, rate = place + c * cosine + s * sine, rate + W * (s * cosine - c * sine)
        return place, rate

    def turn(self, one: int, two: int) -> int:
        """Return -1 for two walls that look at each other, 1 for a wall and itself."""
        return int(self.walls[one].sign * self.walls[two].sign)

    def across(self, one: int, two: int, t: arb, y: Dual, v: Dual) -> tuple[Dual, Dual]:
        """Return height and velocity, as one wall sees them at time t, as another sees them."""
        if one == two:
            return y, v
        here, there, sign, turn = self.at(one, t), self.at(two, t), int(self.walls[two].sign), self.turn(one, two)
        return (here[0] - there[0]).times(sign) + y.times(turn), (here[1] - there[1]).times(sign) + v.times(turn)


def alone(model: Rig) -> bool:
    """Whether certificates speak of a model as of one over a wall at rest, damped or not and with a frequency k."""
    return not model.walled and model.stiffness is None and model.alpha >= 0.0
