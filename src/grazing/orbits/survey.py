"""All one-impact orbits of a model at many values of one parameter, by one compiled loop."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.orbits.closure import FIRED, PASSIVE, WHOLE, closing, contact_after, impact_state, simple_zeros, turning
from grazing.oscillator.constants import HEAD, constants_of
from grazing.oscillator.frames import alone
from grazing.oscillator.model import checked_model
from grazing.oscillator.reset import active_law, newton_law, triggered_law
from grazing.oscillator.rig import Rig
from grazing.oscillator.windows import series
from grazing.outcome import OutsideForm
from grazing.parameter import parameter_tuple

#: Columns of a survey: phase, dG/dphi, then the values of :func:`grazing.orbits.closure.impact_state`, then the time
#: of the first contact where it was asked for.
PHASE, SLOPE, TAU, V_PLUS, V_MINUS, TRACE, DET = range(7)
FIRST_TEST, LAW, CLEARANCE, DIP, DIPS, CONTACT = 7, 11, 13, 14, 15, 16
COLUMNS = 17


class Family(NamedTuple):
    """One model with one piece of its reset law, N periods, and the parameter that varies."""

    kind: type
    harmonics: int
    row: NDArray[np.float64]  # alpha k omega t0 offset cos1 sin1 ... sigma r V trigger
    position: int  # of the parameter that varies in the row; -1 for none
    N: int
    law: int
    unit: float  # of the parameter that varies: a step where it is 0


def families(model: Rig, N: int, name: str | None = None) -> list[Family]:
    """Return the families of a model, one for each affine piece of its reset law.

    Raises
    ------
    InputError
        If it is no oscillator.
    OutsideForm
        For a reset law that is not known to be affine piece by piece.
    """
    model = checked_model(model)
    law = model.reset
    if law.law not in (newton_law, active_law, triggered_law):
        raise OutsideForm(
            f"one-impact orbits have a closed form for reset laws that are affine piece by piece (newton, active, "
            f"triggered), which {law.name} is not known to be; find its orbits on the map, with gz.orbit_diagram"
        )
    flight = {key: value for key, value in model.params.items() if key not in law.params}
    rules = {"r": 0.0, "V": 0.0, "trigger": 0.0, **law.params}
    names = tuple("offset" if key == model.offset_name else key for key in (*flight, *rules))
    row = np.array([*flight.values(), *rules.values()])
    index = [*flight, *rules].index(name) if name is not None else -1
    kicks = law.law is triggered_law and (rules["V"] > 0.0 or name == "V")
    pieces = (FIRED, PASSIVE) if kicks else (WHOLE,)
    unit = 1.0 if name is None else model.unit_of(name)
    return [Family(parameter_tuple(names), model.harmonics, row, index, N, piece, unit) for piece in pieces]


def survey(
    family: Family, values: NDArray[np.float64], contacts: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return every zero of the closing equation at every value.

    Parameters
    ----------
    family : Family
    values : ndarray, shape (n,)
        Values of the parameter that varies; ignored but for their number if none does.
    contacts : bool
        Whether to fly from each impact to the first contact, by the exact advance.

    Returns
    -------
    table : ndarray, shape (n, 2 m, COLUMNS)
        Zeros in increasing phase, then rows of NaN; m is the number of harmonics.
    counts : ndarray of int, shape (n,)
    """
    table = np.full((len(values), 2 * family.harmonics, COLUMNS), np.nan)
    counts = np.zeros(len(values), np.int64)
    run = _surveyor(family.harmonics)
    row = np.append(family.row, float("stiffness" in family.kind._fields))  # type: ignore[attr-defined]
    index, N, law = family.position, family.N, family.law
    call(run, row, index, values, N, law, contacts, table, counts, who="the closing equation")
    order = np.argsort(table[:, :, PHASE], axis=1)  # NaN last
    return table[np.arange(len(table))[:, None], order], counts


def extremum(family: Family, value: float, guess: float) -> tuple[float, float]:
    """Return the phase of the extremum of G nearest to ``guess`` at one value of the parameter, and G there."""
    out = np.empty(2)
    run = _turner(family.kind, family.harmonics)
    call(run, family.row.copy(), family.position, value, family.N, family.law, guess, out, who="the closing equation")
    return float(out[0]), float(out[1])


@lru_cache(maxsize=64)
def _surveyor(harmonics: int) -> Callable[..., None]:
    """Compile the loop, once for models by k and for those by their stiffness."""
    waves = [f"{name}{j}" for j in range(1, harmonics + 1) for name in ("cos", "sin")]
    kind = parameter_tuple((*HEAD, *waves, "sigma", "r", "V", "trigger", "direct"))
    unpack, constants = unpacker(kind), constants_of(harmonics)
    no_edges = (0.0,) * (2 * harmonics + 2)

    def run(row: Any, index: int, values: Any, N: int, law: int, contacts: bool, table: Any, counts: Any) -> None:
        for i in range(len(values)):
            if index >= 0:
                row[index] = values[i]
            c = constants(unpack(row))
            g = closing(N, law, c)
            zeros, count = simple_zeros(g.g0, g.gc, g.gs, no_edges)
            counts[i] = count
            for j in range(count):
                _G, slope = series(zeros[j], g.g0, g.gc, g.gs, 1.0, 0.0)
                state = impact_state(zeros[j], law, g, c)
                table[i, j, 0], table[i, j, 1] = zeros[j], slope
                for column in range(len(state)):
                    table[i, j, 2 + column] = state[column]
                if contacts:
                    table[i, j, 16], _b = contact_after(state[0], max(state[1], 0.0), False, N, alone(c))

    return compiled(run)


@lru_cache(maxsize=64)
def _turner(kind: type, harmonics: int) -> Callable[..., None]:
    unpack, constants = unpacker(kind), constants_of(harmonics)
    no_edges = (0.0,) * (2 * harmonics + 2)

    def run(row: Any, index: int, value: float, N: int, law: int, guess: float, out: Any) -> None:
        if index >= 0:
            row[index] = value
        out[0], out[1] = turning(closing(N, law, constants(unpack(row))), guess, no_edges)

    return compiled(run)
