"""Who works the flippers: at which times their buttons are pressed and released, in turn or as recorded.

Between two such times a flipper turns uniformly until its stop. So its motion is a list of *pieces*, each with the time
at which it begins, the angle there and the angular velocity: all that a flight needs to know.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from math import copysign, inf
from types import MappingProxyType
from typing import Any, NamedTuple

from grazing.copies import ByValue
from grazing.outcome import InputError, listed, shown
from grazing.parameter import Parameter, real, refuse_late

PERIOD = Parameter("flips.period", "T", "time after which the buttons are pressed again", 0.0, open="low", units="s")
HOLD = Parameter("hold", "h", "for how long the button is pressed", 0.0, units="s")
PHASE = Parameter("phase", r"\psi", "time at which the button is pressed", units="s")
#: Switches of one flipper in a recording at most.
MOST = 100_000


class Piece(NamedTuple):
    """A part of a flipper's motion: from when on, the angle there, and the angular velocity."""

    begin: float
    angle: float
    omega: float


def switched(begin: float, angle: float, omega: float, t: float, goal: float, rate: float) -> tuple[float, float]:
    """Return the angle at t of a flipper in a piece of its motion, and when it is at ``goal`` if it turns from there.

    ``rate`` is the angular velocity with which it does. A kernel, and plain Python too.
    """
    now = angle + omega * (t - begin) if omega != 0.0 else angle
    return now, t + (goal - now) / rate


def pieces_of(shape: Mapping[str, float], times: Sequence[float]) -> list[Piece]:
    """Return the motion of a flipper whose button is pressed at the first time, released at the second, and so on."""
    way = copysign(1.0, shape["raised"] - shape["rest"])
    found = [Piece(0.0, shape["rest"], 0.0)]  # since ever
    for i, (begin, end) in enumerate(pairwise([*times, inf])):
        goal, speed = (shape["rest"], -shape["down"]) if i % 2 else (shape["raised"], shape["up"])
        angle, there = switched(*found[-1], begin, goal, way * speed)
        if there > begin:
            found.append(Piece(begin, angle, way * speed))
        if there < end:
            found.append(Piece(max(there, begin), goal, 0.0))
    return found


def angle_at(t: float, period: float, pieces: Sequence[Piece]) -> float:
    """Return the angle of a flipper at a time, from its motion."""
    if period > 0.0:
        t %= period
    one = pieces[max(bisect_right(pieces, t, key=lambda piece: piece.begin) - 1, 0)]
    return one.angle + one.omega * (t - one.begin) if one.omega else one.angle


@dataclass(frozen=True, eq=False)
class Flips(ByValue):
    """Buttons that are pressed periodically; made by :func:`flips`.

    ``hold`` and ``phase`` are numbers for all flippers, or by their names.
    """

    drains = ()

    period: float
    hold: float | Mapping[str, float]
    phase: float | Mapping[str, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "period", PERIOD.check(self.period))
        for known in (HOLD, PHASE):
            given = getattr(self, known.name)
            if isinstance(given, Mapping):
                checked = {name: replace(known, name=f"{name}.{known.name}").check(x) for name, x in given.items()}
                object.__setattr__(self, known.name, MappingProxyType(checked))
            else:
                object.__setattr__(self, known.name, known.check(given))

    def __reduce__(self) -> Any:
        plain = (dict(x) if isinstance(x, Mapping) else x for x in (self.hold, self.phase))
        return Flips, (self.period, *plain)

    def bound(self, names: Sequence[str]) -> Flips:
        """Return the player of these flippers: each with its own hold and phase."""
        found = {}
        for known in (HOLD, PHASE):
            given = getattr(self, known.name)
            if isinstance(given, Mapping):
                refuse_others(given, names, known.name)
                if missing := [name for name in names if name not in given]:
                    raise InputError(
                        f"{known.name} has nothing for the flipper {missing[0]!r}; give one number for all"
                    )
            found[known.name] = {name: given[name] if isinstance(given, Mapping) else given for name in names}
        return Flips(self.period, **found)

    @property
    def params(self) -> dict[str, float]:
        """The period, then hold and phase of each flipper."""
        hold, phase = (dict(x) if isinstance(x, Mapping) else {} for x in (self.hold, self.phase))
        each = {f"{name}.{known.name}": x[name] for name in hold for known, x in ((HOLD, hold), (PHASE, phase))}
        return {PERIOD.name: self.period, **each}

    def describe(self, name: str) -> Parameter | None:
        """Return what is known of one of its parameters."""
        if name not in self.params:
            return None
        owner, _dot, last = name.rpartition(".")
        known = {one.name: one for one in (HOLD, PHASE)}.get(last)
        if known is None:
            return replace(PERIOD, units="1")
        symbol = rf"{known.symbol}^\mathrm{{{owner}}}".replace("_", r"\_")
        return replace(known, name=name, symbol=symbol, meaning=f"{known.meaning} of {owner}", units="1")

    def at(self, params: Mapping[str, float]) -> Flips:
        """Return the player at values of its parameters."""
        hold, phase = (dict(x) if isinstance(x, Mapping) else {} for x in (self.hold, self.phase))
        return Flips(
            params[PERIOD.name],
            {name: params[f"{name}.{HOLD.name}"] for name in hold},
            {name: params[f"{name}.{PHASE.name}"] for name in phase},
        )

    def motion(self, name: str, shape: Mapping[str, float], params: Mapping[str, float]) -> tuple[float, list[Piece]]:
        """Return the period of a flipper's motion and its pieces from 0 on; the first one may begin before."""
        T, hold, phase = params[PERIOD.name], params[f"{name}.{HOLD.name}"], params[f"{name}.{PHASE.name}"]
        stroke = abs(shape["raised"] - shape["rest"])
        back = hold + min(stroke, hold * shape["up"]) / shape["down"]
        if not back < T:
            raise InputError(
                f"the flipper {name} needs {back:g} to go up and come back to rest, the period is {T:g}; make "
                f"{name}.{HOLD.name} smaller, or {PERIOD.name} or {name}.down larger"
            )
        refuse_late(phase, f"{name}.{PHASE.name}", T)
        begin = phase % T
        found = pieces_of(shape, [begin, begin + hold])[1:] if hold > 0.0 else []
        rounds = sorted(one._replace(begin=one.begin - T) if one.begin >= T else one for one in found)
        if not rounds:
            return T, [Piece(0.0, shape["rest"], 0.0)]
        if rounds[0].begin > 0.0:
            rounds.insert(0, rounds[-1]._replace(begin=rounds[-1].begin - T))
        return T, rounds


@dataclass(frozen=True, eq=False)
class Presses(ByValue):
    """Buttons that are pressed and released at given times; made by :func:`presses`."""

    drains = ()

    times: Mapping[str, tuple[float, ...]]

    def __post_init__(self) -> None:
        object.__setattr__(self, "times", MappingProxyType(dict(self.times)))

    def __reduce__(self) -> Any:
        return Presses, (dict(self.times),)

    @property
    def params(self) -> dict[str, float]:
        """Nothing: times are no parameters."""
        return {}

    def bound(self, names: Sequence[str]) -> Presses:
        """Return the player of these flippers."""
        refuse_others(self.times, names, "presses")
        return self

    def describe(self, _name: str) -> Parameter | None:
        """Return nothing."""
        return None

    def at(self, _params: Mapping[str, float]) -> Presses:
        """Return the player."""
        return self

    def motion(self, name: str, shape: Mapping[str, float], _params: Mapping[str, float]) -> tuple[float, list[Piece]]:
        """Return 0, as there is no period, and the pieces of a flipper's motion; before the first one it rests."""
        return 0.0, pieces_of(shape, self.times.get(name, ()))


NOBODY = Presses({})


def refuse_others(given: Iterable[str], names: Sequence[str], what: str) -> None:
    """Raise InputError for names of no flipper."""
    for name in given:
        if name not in names:
            raise InputError(
                f"{what} names {shown(name)}, which is no flipper of the table; allowed are {listed(names)}"
            )


def _times(name: object, given: Any) -> tuple[float, ...]:
    """Return times in rising order, or raise InputError."""
    try:
        items = list(islice(iter(given), MOST + 1))
    except Exception:  # of whatever object was given
        items = [None]
    found = tuple(real(x, f"a time of {name}", "give times in rising order: pressed, released, ...") for x in items)
    if len(found) > MOST or any(not a < b for a, b in pairwise(found)):
        raise InputError(
            f"the times of {name} are {shown(given)}; give at most {MOST} in rising order: pressed, released, ..."
        )
    return found


def flips(period: float, hold: float | Mapping[str, float], phase: float | Mapping[str, float] = 0.0) -> Flips:
    """Return a player who presses the buttons of the flippers periodically, whatever the ball does.

    The table is then periodic in time, and the phase a coordinate of its map.

    Parameters
    ----------
    period : float
        > 0.
    hold : float or mapping of names to floats
        For how long a button is pressed, >= 0, for all flippers or by their names. A flipper must be back at rest
        when it is pressed again.
    phase : float or mapping of names to floats
        When it is pressed first, and then once in a period.

    Returns
    -------
    Flips
        For ``player=`` of :func:`grazing.table`; parameters of the table are then ``flips.period``, and ``hold`` and
        ``phase`` of each flipper.

    Raises
    ------
    InputError
        For a value out of range.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.flips(period=2.0, hold=0.3, phase={"left": 0.0, "right": 1.0}).period
    2.0
    """
    return Flips(period, hold, phase)


def presses(**times: Iterable[float]) -> Presses:
    """Return a player who presses the buttons of the flippers at given times: a recording.

    Parameters
    ----------
    **times : iterables of float
        By the flipper's name, when its button is pressed, released, pressed again and so on, in rising order. Flippers
        that are not named stay at rest.

    Returns
    -------
    Presses
        For ``player=`` of :func:`grazing.table`.

    Raises
    ------
    InputError
        For times that do not rise.

    Examples
    --------
    >>> import grazing as gz
    >>> dict(gz.presses(left=[0.5, 0.7, 1.9]).times)
    {'left': (0.5, 0.7, 1.9)}
    """
    return Presses({name: _times(name, x) for name, x in times.items()})
