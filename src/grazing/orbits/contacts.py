"""What equations know of walls: which of them an impact is at, which piece of its law acts there, what each sees.

An oscillator over one wall at rest is a rig with one wall below the ball; its frames are made of less.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.maps.hits import LATER, Hits, Struck
from grazing.maps.map import Map
from grazing.orbits.closure import FIRED, PASSIVE, WHOLE
from grazing.oscillator.constants import HEAD, constants_of
from grazing.oscillator.frames import Frames, alone, frames_kind, frames_of, link_rows
from grazing.oscillator.pointed import flight_fields, flight_kind, law_addresses, law_kind, law_start
from grazing.oscillator.reset import active_law, newton_law, newton_slope, triggered_law
from grazing.oscillator.rig import Rig

Floats = NDArray[np.float64]
#: Pieces of a law: WHOLE, FIRED, PASSIVE. A contact is a piece of the law of a wall: PIECES times its number, and that.
PIECES = 3


def model_of(P: Map) -> Rig | None:
    """Return the oscillator that a map sees exactly, over one wall or between several; None for another map."""
    return P.origin.rig if P.section is not None else None


def on_wall(model: Rig, j: int, t: float) -> tuple[float, float]:
    """Return the state (u, v) of a ball that lies on a wall at a time."""
    at, speed = model.places_at(np.array([t]))
    return float(at[j, 0]), float(speed[j, 0])


def letters_of_walls(model: Rig) -> Hits | None:
    """Return the letters of a stroboscopic map, the walls that are hit; None for one wall, whose impacts count."""
    return Hits(model.names) if len(model.walls) > 1 else None


def numbered(model: Rig, names: Iterable[str]) -> list[int]:
    """Return the numbers of walls by their names."""
    return [model.names.index(name) for name in names]


def strobes_of(P: Map, letters: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many strobes steps of an impact map pass, from their letters."""
    return letters % LATER if isinstance(P.letters, Struck) else letters


def left_walls(model: Rig, after: Floats) -> NDArray[np.int64]:
    """Return the number of the wall that a ball leaves, from the velocity in a state of an impact map."""
    return np.where(np.signbit(after), len(model.walls) - 1, 0)


def signs_of(model: Rig) -> Floats:
    """Return for each wall 1 if it is below the ball, -1 if above."""
    return np.array([wall.sign for wall in model.walls])


def wall_of(contact: int) -> int:
    """Return the number of the wall of a contact, from below."""
    return contact // PIECES


def piece_of(contact: int) -> int:
    """Return which piece of the wall's law acts."""
    return contact % PIECES


def contacts_of(model: Rig) -> tuple[int, ...]:
    """Return every contact that an impact can be: of a trigger the pieces apart."""
    found: list[int] = []
    for j, wall in enumerate(model.walls):
        pieces = (FIRED, PASSIVE) if wall.law.law is triggered_law else (WHOLE,)
        found += [PIECES * j + piece for piece in pieces]
    return tuple(found)


def pieces_of(model: Rig, incoming: Floats, walls: Sequence[int] | None = None) -> tuple[int, ...]:
    """Return the contacts of impacts with these velocities before them, at walls by number; without, at the first."""
    laws = [wall.law for wall in model.walls]
    found = []
    for j, v in zip([0] * len(incoming) if walls is None else walls, incoming, strict=True):
        piece = WHOLE
        if laws[j].law is triggered_law:
            piece = FIRED if -v >= laws[j].params["trigger"] else PASSIVE
        found.append(PIECES * int(j) + piece)
    return tuple(found)


def flight_rows(model: Rig, values: Floats, seen: Sequence[Floats], phase: float = 0.0) -> Floats:
    """Return the numbers (k, ...) that flights need, as :func:`framer` takes them; the fields of laws are 0.

    ``seen`` is what :meth:`Rig.rows_seen` returns at these values (k, ...); local time 0 is the phase.
    """
    n, head = len(flight_fields(model.harmonics)), len(HEAD) + 2 * model.harmonics + 1  # alpha to sigma
    ends, links = ((seen[0], seen[-1]), [link_rows(model, values)]) if model.walled else ((seen[0],), [])
    rows = np.zeros((len(values), n * len(ends) + sum(one.shape[1] for one in links)))
    for j, numbers in enumerate(ends):
        rows[:, j * n : j * n + head] = numbers[:, :head]
        rows[:, j * n + head] = phase
        rows[:, j * n + head + 1] = 1.0 if model.stiffness is not None else 0.0  # direct
    for link in links:
        rows[:, n * len(ends) :] = link
    return rows


def room_in(model: Rig, rows: Floats) -> Floats:
    """Return the room between the walls, from rows of :func:`flight_rows`; infinite over one wall."""
    if not model.walled:
        return np.full(len(rows), np.inf)
    return rows[:, 2 * len(flight_fields(model.harmonics)) + 2]


@lru_cache(maxsize=64)
def framer(harmonics: int, walled: bool) -> Callable[[Any], Frames]:
    """Return the kernel ``frames(row) -> Frames`` for rows of :func:`flight_rows`.

    ``walled`` is that of the model, :class:`grazing.oscillator.rig.Rig`.
    """
    if walled:
        unpack_walls, of_walls = unpacker(frames_kind(harmonics)), frames_of(harmonics)

        def between(row: Any) -> Any:
            return of_walls(unpack_walls(row))

        return between
    unpack, constants = unpacker(flight_kind(harmonics)), constants_of(harmonics)

    def over(row: Any) -> Any:
        return alone(constants(unpack(row)))

    return over


def frames_at(model: Rig, values: Floats, phase: float = 0.0) -> Frames:
    """Return the frames of a model as numbers of Python; local time 0 is the phase."""
    rows = flight_rows(model, values[None], model.rows_seen(values[None]), phase)
    return framed(model, rows[0])


def framed(model: Rig, row: Floats) -> Frames:
    """Return the frames of a model at a row of :func:`flight_rows`, as numbers of Python."""
    found: Frames = call(compiled(framer(model.harmonics, model.walled)), row, who="the frames of walls")
    return found


def addresses(model: Rig, contacts: Sequence[int]) -> list[tuple[float, float, int]]:
    """Return for each impact where the piece of the law lies that acts there, its slope, and in a row its parameters.

    The last in bytes behind what a wall sees, see :meth:`Rig.rows_seen`. A piece of a trigger goes on smoothly beyond
    the trigger's speed, so that Newton's method and virtual orbits can.
    """
    walls, found = model.walls, []
    for contact in contacts:
        law = walls[wall_of(contact)].law
        known = {
            WHOLE: (law.law, law.slope, law.name),
            FIRED: (active_law, newton_slope, "active"),
            PASSIVE: (newton_law, newton_slope, "newton"),
        }
        code = law_addresses(*known[piece_of(contact)], law_kind(law), "strict")
        found.append((*code, law_start(model.harmonics, law)))
    return found


def sizes_of(model: Rig) -> tuple[float, float]:
    """Return how far and how fast the ball goes, by an estimate; of two walls as the one sees it that sees less."""
    reach = [one.reach for one in model.seen]
    return min(one.height for one in reach), min(one.speed for one in reach)


def relative(model: Rig, walls: Sequence[int], times: Floats, velocities: Floats) -> Floats:
    """Return velocities as the walls see them that are hit at these times."""
    speed = model.places_at(times)[1][walls, np.arange(len(times))] if len(times) else times
    return np.array([model.walls[wall].sign for wall in walls]) * (velocities - speed)


def kick_of(model: Rig, wall: int = 0) -> float:
    """Return the velocity that the law of a wall gives a ball that touches it with no speed."""
    return model.walls[wall].law(0.0)
