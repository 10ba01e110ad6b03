"""A wall that a ball hits: where it is, what it does to the ball, from which side, and how it moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, sin
from typing import Any

from grazing.oscillator.forcing import MOST_HARMONICS, Forcing
from grazing.oscillator.reset import Reset
from grazing.outcome import InputError, shown
from grazing.parameter import real
from grazing.units import magnitude

SIDES = ("below", "above")
#: Names that walls get unless they have one. C and S mean chatter and sticking in words.
NAMES = "AB"
#: How far a motion's frequency may be from a whole multiple of the forcing's, as a share of it.
SAME = 1e-12


@dataclass(frozen=True, slots=True)
class Wall:
    """A wall: the ball flies above one that is below it, and below one that is above it. Made by :func:`wall`."""

    position: float
    law: Reset
    side: str | None = None
    motion: Forcing | None = None
    name: str | None = None
    metres: bool = False

    @property
    def sign(self) -> float:
        """1 for a wall below the ball, -1 for one above it."""
        return -1.0 if self.side == "above" else 1.0


def wall(
    position: Any, law: Reset, side: str | None = None, motion: Forcing | None = None, name: str | None = None
) -> Wall:
    """Return a wall for ``gz.Oscillator(..., walls=...)``.

    Parameters
    ----------
    position : float
        Where it is, or the middle of its motion. For :meth:`Oscillator.from_si` also with units: ``"1.2 mm"``.
    law : Reset
        What an impact does to the velocity relative to the wall: :func:`newton`, :func:`active`, :func:`triggered` or
        :func:`reset`.
    side : {"below", "above"}, optional
        Of the ball. Default: below it, and of two walls the higher one above it.
    motion : Forcing, optional
        The wall is at position + motion(t). Its frequency is a whole multiple of the forcing's.
    name : str, optional
        One capital letter, which stands for an impact in words and in front of the wall's parameters, as in ``A.r``.
        Default: A and B, from below.

    Returns
    -------
    Wall

    Raises
    ------
    InputError
        For a wall without a law, a side that does not exist, or a name that is no capital letter; C and S are taken.

    Examples
    --------
    >>> import grazing as gz
    >>> pair = gz.wall(-0.5, gz.newton(0.8)), gz.wall(0.5, gz.newton(0.6))
    >>> m = gz.Oscillator(alpha=0.1, k=0, forcing=gz.Forcing(omega=2.0), walls=pair)
    >>> m.params["B.r"]
    0.6
    """
    given = magnitude(position, "m", "position")
    place = real(given, "position", "any finite number is allowed")
    if not isinstance(law, Reset):
        raise InputError(f"law of a wall is {shown(law)}; give gz.newton(r), gz.active(r, V) or gz.reset(law, ...)")
    if side is not None and (not isinstance(side, str) or side not in SIDES):
        raise InputError(f"side = {shown(side)}; allowed are 'below' and 'above', where the wall is seen from the ball")
    if motion is not None and not isinstance(motion, Forcing):
        raise InputError(f"motion is {shown(motion)}; give a gz.Forcing(omega=..., cos=(...), sin=(...))")
    if motion is not None and motion.offset != 0.0:
        raise InputError(f"motion has offset = {motion.offset:g}; add it to the position, the middle of the motion")
    proper = isinstance(name, str) and len(name) == 1 and "A" <= name <= "Z" and name not in "CS"
    if name is not None and not proper:
        raise InputError(f"name of a wall is {shown(name)}; allowed is one capital letter other than C and S")
    return Wall(place, law, side, motion, name, given is not position)


def checked_walls(walls: Any) -> tuple[Wall, ...]:
    """Return one wall, or two from below, each with its side and its name, or raise InputError."""
    wanted = "give one or two of gz.wall(position, law)"
    several = (walls,) if isinstance(walls, Wall) else tuple(walls) if isinstance(walls, Sequence) else ()
    if not several or not all(isinstance(one, Wall) for one in several):
        raise InputError(f"walls are {shown(walls)}; {wanted}")
    if len(several) > 2:
        raise InputError(f"there are {len(several)} walls; a ball on a line touches two at most: {wanted}")
    if len(several) == 1:
        return (replace(several[0], side=several[0].side or "below", name=several[0].name or NAMES[0]),)
    low, high = sorted(several, key=lambda one: one.position)
    if not low.position < high.position:
        raise InputError(f"both walls are at {low.position:g}; the ball needs room between them")
    if low.side == "above" or high.side == "below":
        raise InputError(
            f"the wall at {low.position:g} is {low.side or 'below'} the ball and the one at {high.position:g} "
            f"{high.side or 'above'} it; the ball flies between two walls, so the lower one is below it"
        )
    free = [name for name in NAMES if name not in (low.name, high.name)]
    low = replace(low, side="below", name=low.name or free.pop(0))
    high = replace(high, side="above", name=high.name or free.pop(0))
    if low.name == high.name:
        raise InputError(f"both walls are called {low.name}; give them different names")
    return low, high


def harmonics_of(motion: Forcing, forcing: Forcing) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return a motion's amplitudes, cosines and sines, as harmonics of a forcing's frequency and at its time shift."""
    ratio = motion.omega / forcing.omega
    times = round(ratio)
    if times < 1 or abs(ratio - times) > SAME * ratio:
        raise InputError(
            f"a wall moves with omega = {motion.omega:g}, which is no whole multiple of the forcing's "
            f"{forcing.omega:g}: there would be no period; give a multiple"
        )
    if times * len(motion.cos) > MOST_HARMONICS:
        raise InputError(
            f"the motion of a wall has harmonic {times * len(motion.cos)} of the forcing's frequency; "
            f"allowed are at most {MOST_HARMONICS}"
        )
    cosines, sines = [0.0] * (times * len(motion.cos)), [0.0] * (times * len(motion.cos))
    for j, (c, s) in enumerate(zip(motion.cos, motion.sin, strict=True), start=1):
        shift = j * motion.omega * (motion.t0 - forcing.t0)
        turn = (cos(shift), sin(shift)) if shift != 0.0 else (1.0, 0.0)
        cosines[j * times - 1] = c * turn[0] + s * turn[1]
        sines[j * times - 1] = s * turn[0] - c * turn[1]
    return tuple(cosines), tuple(sines)


def in_harmonics(motion: Forcing | None, forcing: Forcing) -> Forcing | None:
    """Return the same motion at a forcing's frequency and time shift: one that is given in two ways is one model."""
    if motion is None:
        return None
    cosines, sines = harmonics_of(motion, forcing)
    return Forcing(forcing.omega, forcing.t0, motion.offset, cosines, sines)
