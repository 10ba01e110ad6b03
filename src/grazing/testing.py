"""Laws that every map and every model must keep: for what we ship, and for yours.

``check_map`` and ``check_model`` raise AssertionError with the law that failed and the state at which it did.
"""

from __future__ import annotations

from math import prod

from grazing.billiard.check import check as check_flights
from grazing.billiard.table import Table
from grazing.maps.check import check as check_steps
from grazing.maps.check_model import check as check_motion
from grazing.maps.collisions import checked_table
from grazing.maps.map import Map
from grazing.oscillator.model import Oscillator, checked_model
from grazing.outcome import InputError, shown
from grazing.parameter import whole
from grazing.studies.starts import checked_seed
from grazing.systems.check import check
from grazing.systems.contract import System

#: States, times the steps or periods of each, that are looked at in some 30 seconds.
MAP, MODEL, SYSTEM, TABLE = 50_000, 12_000, 1_000, 10_000


def check_map(P: Map, states: int = 24, steps: int = 12, seed: int = 0) -> None:
    """Hold a map to the laws of the protocol.

    Parameters
    ----------
    P : Map
        Any map; states are drawn from its box.
    states : int
        How many.
    steps : int
        How far each is followed.
    seed : int

    Raises
    ------
    AssertionError
        Names the law and the state. The laws: compiled code gives the bits of the plain Python step; n steps are n
        times one step; results do not depend on how many orbits run side by side; ``replace`` keeps what it does
        not change; the Jacobian agrees with central differences wherever the letter is locally constant; pieces give
        the bits of the step, and borders choose its letter; a ``block``
        twin makes the decisions of the step, within four units in the last place a period, and its bits depend
        neither on threads nor on the size of a block.
    UserCodeError
        For a step that raises, or a reset law that raises or returns what it must not, in one of these steps.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.testing.check_map(gz.gap_map(lam=0.5, mu=0.1, l=0.2))
    """
    if not isinstance(P, Map):
        raise InputError(f"P is {shown(P)}; give a map, such as gz.stroboscopic_map(model); models go to check_model")
    states, steps = _amount(MAP, states=states, steps=steps)
    check_steps(P, states, steps, checked_seed(seed))


def check_model(model: Oscillator, states: int = 12, periods: int = 12, seed: int = 0) -> None:
    """Hold a model to the laws of motion.

    Parameters
    ----------
    model : Oscillator
    states : int
        Random starts.
    periods : int
        How long each is followed.
    seed : int

    Raises
    ------
    AssertionError
        Names the law and the start. The laws: the ball is never inside the wall; every impact is at the wall, moves
        towards it before and away after, as the reset law says; between impacts the equation of motion holds;
        the stroboscopic map and the trajectory agree; so do the impact map and the list of impacts; both section
        maps keep the laws of :func:`check_map`; no impact is missed or invented beside grazes built on purpose, as
        ball arithmetic says.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.testing.check_model(gz.pinball(d=0.1), states=3)
    """
    checked_model(model)
    states, periods = _amount(MODEL, states=states, periods=periods)
    check_motion(model, states, periods, checked_seed(seed))


def check_system(system: System, states: int = 8, seed: int = 0) -> None:
    """Hold a system of your own to what its functions promise.

    Parameters
    ----------
    system : System
    states : int
        Random states of its box that are tried.
    seed : int

    Raises
    ------
    AssertionError
        Names the promise, with a counterexample. The promises, in ball arithmetic of 500 bits: a flight is made of its
        halves, velocities are the rates of positions, and all repeats itself after the period; ``dh`` is the rate of
        the gap; abs(h'') is within the bound at many places of random intervals; gap and rate are computed with no more
        than the errors that are said. A dense search finds no impact that was missed, laws leave the surface and do not
        move away from it, and near grazes, built on purpose, none is missed or invented.
    UserCodeError
        For a function that raises, or cannot work in ball arithmetic.

    Examples
    --------
    >>> import grazing as gz
    >>> def flight(t, t0, state, p):
    ...     x, v = state
    ...     return x + v * (t - t0), v
    >>> def gap(t, state, p):
    ...     return 1.0 - state[0], state[1]
    >>> def bound(t, w, state, p):
    ...     return 0.0
    >>> wall = gz.Surface("A", gap, bound)
    >>> wrong = gz.System(("x",), ("v",), {"r": 1.0}, flight, [wall], box=((0.0, 1.0), (0.5, 1.0)))
    >>> gz.testing.check_system(wrong)
    Traceback (most recent call last):
    AssertionError: along the flight from ... the gap of surface A changes at -0.63..., but says dh = 0.63...
    """
    if not isinstance(system, System):
        raise InputError(f"system is {shown(system)}; give a gz.System, models go to check_model and maps to check_map")
    (states,) = _amount(SYSTEM, states=states)
    check(system, states, checked_seed(seed))


def check_table(table: Table, states: int = 8, seed: int = 0) -> None:
    """Check a pinball table: every impact is found, by exact algebra and a dense search, and does what its law says.

    Parameters
    ----------
    table : Table
        Of :func:`grazing.table`.
    states : int
        Random starts; forty flights of each are looked at.
    seed : int

    Raises
    ------
    AssertionError
        For the first thing that is wrong, with the flight.
    InputError
        If a ball of its radius fits nowhere among the objects.
    UserCodeError
        If a law raises, or returns what it must not.

    Examples
    --------
    >>> import grazing as gz
    >>> discs = [gz.disc(name, (x, 0), 1.0, gz.newton(1.0)) for name, x in (("A", 0), ("B", 3))]
    >>> gz.testing.check_table(gz.table(discs, rho=0.2), states=2)
    """
    (states,) = _amount(TABLE, states=states)
    check_flights(checked_table(table), states, checked_seed(seed))


def _amount(most: int, **counts: int) -> list[int]:
    """Return how much is looked at, or raise InputError for what would run for hours."""
    found = [whole(count, name, 1) for name, count in counts.items()]
    if prod(found) > most:
        said = " x ".join(f"{name} ({shown(count)})" for name, count in zip(counts, found, strict=True))
        raise InputError(f"{said} would run for long; at most {most} at a time, and more by another seed")
    return found
