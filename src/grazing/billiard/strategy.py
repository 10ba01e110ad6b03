"""A player who looks at the ball: a function is asked where it enters a zone whether to press a button.

A *gate* is the line that a ball crosses when it enters a zone. To the kernels it is a drain: where the ball crosses it
is found as all contacts are, in flight and on a slide. There a flight ends without an impact, the function is asked,
and the ball goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import copysign, inf
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.billiard.objects import FLIPPER, Thing, drain, two_of
from grazing.billiard.players import HOLD, Flips, Piece, Presses, pieces_of, refuse_others
from grazing.copies import ByValue, made_of, packed
from grazing.kernel.content import identity
from grazing.outcome import InputError, UserCodeError, raised, shown
from grazing.parameter import Parameter

Floats = NDArray[np.float64]
#: Pieces of the motion of a flipper that a gate works: up, there, down, at rest.
MOTION = 4


class Named(dict[str, float]):
    """Parameters by name, ``p["A.V"]``, and as kernels have them, ``p.A_V``."""

    def __getattr__(self, name: str) -> float:
        for known, value in self.items():
            if known.replace(".", "_") == name:
                return value
        raise AttributeError(f"no parameter {name!r}; there are {', '.join(self)}")


@dataclass(frozen=True, eq=False)
class Strategy(ByValue):
    """A player who looks at the ball; made by :func:`strategy`."""

    flip: Callable[..., bool]
    gates: Mapping[str, Any]
    hold: float
    drains: tuple[Thing, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not callable(self.flip):
            raise InputError(f"flip is {shown(self.flip)}; give a function flip(state, p) that returns True or False")
        if not isinstance(self.gates, Mapping) or not self.gates:
            raise InputError(f"gates is {shown(self.gates)}; give a line ((x1, y1), (x2, y2)) by the flipper's name")
        object.__setattr__(self, "hold", HOLD.check(self.hold))
        if not self.hold > 0.0:
            raise InputError("hold = 0; give for how long a button is pressed, > 0")
        lines = []
        for name, line in self.gates.items():
            ends = two_of(line)
            if len(ends) != 2:
                raise InputError(f"the gate of {shown(name)} is {shown(line)}; give its ends ((x1, y1), (x2, y2))")
            lines.append(drain(f"gate_of_{name}", *ends))
        gates = {str(name): _ends(line) for name, line in zip(self.gates, lines, strict=True)}
        object.__setattr__(self, "gates", MappingProxyType(gates))
        object.__setattr__(self, "drains", tuple(lines))

    def __reduce__(self) -> Any:
        return made_of, (Strategy, tuple(packed(item) for item in (self.flip, self.gates, self.hold)))

    @property
    def params(self) -> dict[str, float]:
        """Nothing: its numbers are no parameters."""
        return {}

    @property
    def times(self) -> Mapping[str, tuple[float, ...]]:
        """Nothing is known before a ball flies."""
        return MappingProxyType({})

    def gate_of(self, number: int) -> str:
        """Return the name of the flipper of a gate."""
        return list(self.gates)[number]

    @property
    def config(self) -> str:
        """What decides a result: the function by content, the gates and how long buttons are pressed."""
        return f"{identity(self.flip)[:16]} {dict(self.gates)!r} {self.hold!r}"

    def bound(self, names: Sequence[str]) -> Strategy:
        """Return the player of these flippers."""
        refuse_others(self.gates, names, "gates")
        return self

    def describe(self, _name: str) -> Parameter | None:
        """Return nothing."""
        return None

    def at(self, _params: Mapping[str, float]) -> Strategy:
        """Return the player."""
        return self

    def motion(self, name: str, shape: Mapping[str, float], _params: Mapping[str, float]) -> tuple[float, list[Piece]]:
        """Return the motion of a flipper whose button was never pressed, with room for one whose button is."""
        still = pieces_of(shape, ())
        return 0.0, still + [still[0]._replace(begin=inf)] * (MOTION - 1 if name in self.gates else 0)

    def pressed_before(self, motions: Sequence[float], shapes: Mapping[str, Any]) -> dict[str, list[float]]:
        """Return a recording after which flippers have turned and stay pressed, two numbers for each gate, at t = 0."""
        found = {}
        for name, turned, held in zip(self.gates, motions[::2], motions[1::2], strict=True):
            shape = shapes[name]
            stroke = abs(shape["raised"] - shape["rest"])
            if held > 0.0:
                found[name] = [-turned / shape["up"], held]
            elif turned > 0.0:
                end = -(stroke - turned) / shape["down"]
                found[name] = [end - 2.0 * stroke / shape["up"], end]
        return found

    def rows(self, things: Sequence[Thing], params: Mapping[str, float]) -> Floats:
        """Return what kernels know of the gates, see :mod:`grazing.billiard.gates`: at first, flippers at rest."""
        flippers, found = [one.name for one in things if one.kind == FLIPPER], []
        for name in self.gates:
            rest, raised, up, down = (params[f"{name}.{what}"] for what in ("rest", "raised", "up", "down"))
            way = copysign(1.0, raised - rest)
            found += [flippers.index(name), rest, way, abs(raised - rest), up, down, self.hold, 0.0, 0.0, 0.0]
        return np.array(found)

    def tried(self, params: Mapping[str, float]) -> None:
        """Ask the function once at the middle of each gate; raise UserCodeError if it fails."""
        for (x1, y1), (x2, y2) in self.gates.values():
            self.asked((0.5 * (x1 + x2), 0.5 * (y1 + y2), 0.0, 0.0), params)

    def asked(self, state: tuple[float, ...], params: Mapping[str, float]) -> bool:
        """Ask the function; raise UserCodeError for one that fails, or does not say yes or no."""
        try:
            said = self.flip(state, Named(params))
        except Exception as error:
            raise UserCodeError(
                f"the strategy raised {raised(error)} for the ball {shown(state)}; let it return True or False"
            ) from error
        if not isinstance(said, (bool, np.bool_)):
            raise UserCodeError(
                f"the strategy returned {shown(said)} for the ball {shown(state)}; return True or False"
            )
        return bool(said)


def _ends(line: Thing) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the ends of a gate."""
    x1, y1, x2, y2 = line.shape.values()
    return (x1, y1), (x2, y2)


Player = Flips | Presses | Strategy


def strategy(flip: Callable[..., bool], gates: Mapping[str, Any], hold: float) -> Strategy:
    """Return a player who looks at the ball, and presses a button, or not, where the ball enters a zone.

    What happens is decided by the ball alone. A gate lies where the zone begins; it is crossed from either side and
    stops nothing. While a button is pressed nobody asks again.

    Parameters
    ----------
    flip : callable
        ``flip(state, p)`` returns True to press the button: ``state`` (x, y, vx, vy) of the ball's centre at the gate,
        ``p`` the parameters of the table by name, ``p["A.V"]`` or ``p.A_V``. For maps it is compiled: plain arithmetic.
    gates : mapping of names to lines
        ``((x1, y1), (x2, y2))`` by the flipper's name.
    hold : float
        For how long the button is then pressed, > 0.

    Returns
    -------
    Strategy
        For ``player=`` of :func:`grazing.table`; :func:`grazing.trajectory`, :func:`grazing.launches` and
        :func:`grazing.launch_map` follow it from flippers at rest, :func:`grazing.collision_map` from any state. A
        trajectory says in ``attrs["presses"]`` what was pressed, as :func:`grazing.presses` takes it.

    Raises
    ------
    InputError
        For no function, no gates, or a line that is none.
    UserCodeError
        When it is followed, for a function that raises, or returns anything but True or False.

    Examples
    --------
    >>> import grazing as gz
    >>> L = gz.flipper("L", (1, 1), 1.5, (0.2, 0.1), -0.4, 0.4, gz.newton(0.8), up=14, down=9)
    >>> player = gz.strategy(lambda state, p: state[0] > 1.5, {"L": ((1, 1.9), (3, 1.9))}, hold=0.2)
    >>> T = gz.table([L, gz.drain("out", (0, -3), (9, -3))], rho=0.1, tilt=0.5, player=player)
    >>> gz.trajectory(T, (2.0, 4.0, 0.0, 0.0), until=5.0).attrs["presses"]
    {'L': [2.9598..., 3.1598...]}
    """
    return Strategy(flip, gates, hold)
