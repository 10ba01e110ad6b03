"""Reset laws by address: a kernel that gets its law so is compiled once for every law, the user's own included."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import address
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import called
from grazing.oscillator.block import strike_of
from grazing.oscillator.constants import HEAD, refuse_to_compile
from grazing.oscillator.reset import Reset
from grazing.parameter import parameter_tuple

if TYPE_CHECKING:
    from grazing.oscillator.model import Oscillator

Floats = NDArray[np.float64]

#: What a kernel needs of a reset law: contraction near zero speed, the addresses, and where its numbers lie.
LAW = ("ratio", "speed", "law", "slope", "row")


def pointed_law(v: float, p: Any) -> float:
    """Call the reset law by its address."""
    return called(p.law, v, p.row)


def pointed_slope(v: float, p: Any) -> float:
    """Call the slope of the reset law by its address."""
    return called(p.slope, v, p.row)


def pointed_contraction(p: Any) -> tuple[float, float]:
    """Return what is known of the law near zero speed."""
    return p.ratio, p.speed


@lru_cache(maxsize=64)
def flight_fields(harmonics: int) -> tuple[str, ...]:
    """Return the names of the numbers that a flight needs, without those of a reset law.

    ``direct`` is 1 where the second one is the stiffness itself, not k.
    """
    waves = [f"{name}{j}" for j in range(1, harmonics + 1) for name in ("cos", "sin")]
    return (*HEAD, *waves, "sigma", "phase", "direct", *LAW)


#: The law, its slope and what is known of it near zero speed, for a kernel that gets them by address.
POINTED = pointed_law, pointed_slope, pointed_contraction


@lru_cache(maxsize=64)
def flight_kind(harmonics: int) -> type:
    """Return the named tuple of :func:`flight_fields`."""
    return parameter_tuple(flight_fields(harmonics))


def law_kind(law: Reset) -> type:
    """Return the named tuple that a law gets, of its own parameters: so it is compiled once for all models."""
    return parameter_tuple(tuple(law.params))


def law_start(harmonics: int, law: Reset) -> int:
    """Return by how many bytes the parameters of a law lie behind the first of a model's; 0 if it has none."""
    return 8 * (len(HEAD) + 2 * harmonics + 1) if law.params else 0


@lru_cache(maxsize=256)
def law_addresses(
    law: Callable[..., float], slope: Callable[..., float], name: str, kind: type, arithmetic: str
) -> tuple[float, float]:
    """Compile a reset law of parameters ``kind``, and its slope; return where their code lies."""
    unpack = unpacker(kind)

    def law_at(v: float, row: Any) -> float:
        return 1.0 * law(v, unpack(row))  # a float, whatever numbers the law returns: so it is called by its address

    def slope_at(v: float, row: Any) -> float:
        return 1.0 * slope(v, unpack(row))

    who = f"the reset law {name}"
    return address(law_at, "value", arithmetic, who), address(slope_at, "value", arithmetic, who)


@lru_cache(maxsize=256)
def strike_address(law: Callable[..., float], name: str, kind: type, arithmetic: str) -> float:
    """Compile the loop of a reset law over impacts, see :func:`strike_of`; return where its code lies."""
    return address(strike_of(law, unpacker(kind)), "sweep", arithmetic, f"the reset law {name}")


@lru_cache(maxsize=64)
def contractions(contraction: Callable[..., Any], kind: type, rows: bytes) -> Floats:
    """Return what a law says of its contraction, (columns, 2), at rows of parameters: pieces of a run ask again."""
    table = np.frombuffer(rows).reshape(-1, len(kind._fields))  # type: ignore[attr-defined]
    return np.array([contraction(kind(*row)) for row in table.tolist()], np.float64).reshape(-1, 2)


def pointed_rows(harmonics: int, law: Reset, kind: type, rows: Floats, arithmetic: str) -> Floats:
    """Return the numbers of :func:`flight_fields` for rows of a map's parameters.

    Parameters
    ----------
    harmonics : int
    law : Reset
    kind : type
        The named tuple of the map's parameters: those of the flight, of the law, and for a map with a section its
        phase, which is 0 for others.
    rows : ndarray, shape (columns, parameters)
        In one piece; must live as long as the result is used.
    arithmetic : {"strict", "fast"}
    """
    refuse_to_compile(harmonics)  # before the law is: its parameters are as many
    law_at, slope_at = law_addresses(law.law, law.slope, law.name, law_kind(law), arithmetic)
    flight = len(HEAD) + 2 * harmonics + 1
    found = np.empty((len(rows), flight + 7))  # written in place: of one row, as of a single orbit, joining took longer
    found[:, :flight] = rows[:, :flight]
    found[:, flight] = rows[:, -1] if kind._fields[-1] == "phase" else 0.0  # type: ignore[attr-defined]
    found[:, flight + 1] = 1.0 if "stiffness" in kind._fields else 0.0  # type: ignore[attr-defined]
    found[:, flight + 2 : flight + 4] = contractions(law.contraction, kind, rows.tobytes())
    found[:, flight + 4], found[:, flight + 5] = law_at, slope_at
    first = rows.ctypes.data + law_start(harmonics, law)
    found[:, flight + 6] = first + rows.strides[0] * np.arange(len(rows), dtype=np.float64)
    return found


class Pointed(NamedTuple):
    """The numbers of a model as a kernel gets them, ``row``; it points into ``source``, which must live as long."""

    row: Floats
    source: Floats


def pointed_model(model: Oscillator, phase: float = 0.0) -> Pointed:
    """Return the numbers of :func:`flight_fields` for a model seen at a phase, in strict arithmetic."""
    source = np.array([[*model.params.values(), phase]], np.float64)
    kind = parameter_tuple((*model.params, "phase"))
    return Pointed(pointed_rows(model.harmonics, model.reset, kind, source, "strict")[0], source)
