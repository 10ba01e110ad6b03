"""Special points of a branch: what happens there, where, and how surely."""

from __future__ import annotations

from typing import Any, NamedTuple

from grazing.copies import alike
from grazing.orbits.orbit import Orbit
from grazing.outcome import abridged

#: What happens at a special point, in words.
SPECIAL = {
    "lp": "fold: two orbits meet, a multiplier is +1",
    "pd": "period doubling: a multiplier is -1",
    "ns": "Neimark-Sacker: complex multipliers lie on the unit circle",
    "bp": "branch point: another branch crosses this one",
    "gr": "graze: the orbit touches the wall",
    "bcb": "border collision: a point reaches the border between two letters",
    "ep": "end of the piece: the map jumps or has a kink, and the orbit goes no farther",
    "v0": "the speed of an impact is 0, the bumper kicks: the orbit jumps",
    "law": "the speed of an impact reaches the trigger",
    "st": "sticking: a ball left at rest is no longer lifted off at once",
    "ch": "onset of chatter: the impacts accumulate just when the forcing releases the ball",
}


class Special(NamedTuple):
    """A special point of a branch.

    Parameters
    ----------
    type : str
        One of lp pd ns bp gr bcb ep v0 law st ch; :data:`SPECIAL` has them in words.
    value : float
        Of the parameter.
    low, high : float
        Bracket of the value. Where it has converged, what rounding of the equations and of the test function can do
        lies inside, see :mod:`grazing.orbits.rounding`; else the test function has different signs there. At an end the
        orbit is there on one side only.
    converged : bool
        Whether the test function is zero there to rounding, or the bracket of an end is as narrow as 1e-12 of the
        range; False where the search failed.
    orbit : Orbit
        The orbit at this value.
    admissible : bool
        Whether it is one of the map, or on the edge of being one; False on a virtual part of the branch.
    where : int
        Which impact (v0, law, st), flight (gr) or point (bcb) it is about; -1 for the whole orbit. Between two walls,
        flights to the upper one are counted on after those to the lower one.
    piece : int
        The piece of the branch that it lies on.
    to : int
        The piece that begins there, -1 for none.
    direction : ndarray
        Unit tangent of the branch, in scaled unknowns and the parameter.
    wall : str
        The wall of an impact or of a graze, by its letter; empty for what is not about one.
    """

    type: str
    value: float
    low: float
    high: float
    converged: bool
    orbit: Orbit
    admissible: bool
    where: int
    piece: int
    to: int = -1
    direction: Any = None
    wall: str = ""

    @property
    def meaning(self) -> str:
        """What happens, in words."""
        return SPECIAL[self.type]

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and alike(tuple(self), tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash((self.type, self.value, self.where, self.piece))

    def __repr__(self) -> str:
        return f"<{self.type} at {self.value:.12g}: {abridged(self.orbit.word)}, period {self.orbit.period}>"


class Relabelling(NamedTuple):
    """An impact crosses the strobe, or a point a border at which its map is smooth: the word changes and no more."""

    value: float
    before: str
    after: str
    piece: int
