"""The plunger: where a ball is launched, in which direction, and between which speeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from grazing.billiard.objects import point_of
from grazing.copies import ByValue
from grazing.outcome import InputError
from grazing.parameter import Parameter

KNOWN = {
    one.name: one
    for one in (
        Parameter("plunger.x", "x_0", "x of the ball in the plunger's lane"),
        Parameter("plunger.y", "y_0", "y of the ball in the plunger's lane"),
        Parameter("plunger.angle", r"\varphi_0", "direction of the lane, from the x axis"),
        Parameter("plunger.slow", "v_0", "least speed of a launch", 0.0),
        Parameter("plunger.fast", "v_1", "greatest speed of a launch", 0.0, open="low"),
    )
}
PLACE = "plunger.x", "plunger.y"


@dataclass(frozen=True, eq=False)
class Plunger(ByValue):
    """What launches the ball; made by :func:`plunger`."""

    x: float
    y: float
    angle: float
    slow: float
    fast: float

    def __post_init__(self) -> None:
        for name, known in KNOWN.items():
            own = name.partition(".")[2]
            object.__setattr__(self, own, known.check(getattr(self, own)))
        if not self.slow < self.fast:
            raise InputError(f"a plunger launches from {self.slow:g} to {self.fast:g}; allowed is slow < fast")

    def __reduce__(self) -> Any:
        return Plunger, (self.x, self.y, self.angle, self.slow, self.fast)

    @property
    def params(self) -> dict[str, float]:
        """Its numbers, as parameters of a table."""
        return {name: getattr(self, name.partition(".")[2]) for name in KNOWN}

    @staticmethod
    def at(params: Mapping[str, float]) -> Plunger:
        """Return the plunger at values of its parameters."""
        return Plunger(*(params[name] for name in KNOWN))


def plunger(point: Sequence[float], angle: float, slow: float, fast: float) -> Plunger:
    """Return a plunger for ``plunger=`` of :func:`grazing.table`: where balls are launched, and how fast.

    Nothing of it is hit: walls of the lane, and what a ball falls back on, are objects of the table.

    Parameters
    ----------
    point : (x, y)
        The ball's centre when it is launched.
    angle : float
        The direction of the lane, from the x axis in radians.
    slow, fast : float
        Between which speeds it launches, 0 <= slow < fast.

    Returns
    -------
    Plunger
        Parameters of the table are then ``plunger.x``, ``plunger.y``, ``plunger.angle``, ``plunger.slow`` and
        ``plunger.fast``. :func:`grazing.launch_map` and :func:`grazing.launches` launch there unless they are given a
        point.

    Raises
    ------
    InputError
        For a value out of range.

    Examples
    --------
    >>> import grazing as gz
    >>> law, drain = gz.newton(0.9), gz.drain("out", (0, 0), (6, 0))
    >>> T = gz.table([gz.disc("A", (3, 4), 1.0, law), drain], rho=0.1, tilt=0.3, plunger=gz.plunger((5, 1), 1.6, 1, 3))
    >>> gz.launches(T).sizes["speed"], gz.launch_map(T).box[1]
    (200, (1.0, 3.0))
    """
    x, y = point_of(point, "a plunger", "point")
    return Plunger(x, y, angle, slow, fast)
