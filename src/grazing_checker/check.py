"""Check any certificate: what it proves follows from its data alone, by what is listed in its trusted base."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from grazing_checker import gap
from grazing_checker.envelope import VERSION, opened
from grazing_checker.law import law_values
from grazing_checker.orbit import check_orbit, check_walled_orbit
from grazing_checker.plane import SHAPES
from grazing_checker.reading import Rejected, demand, quoted
from grazing_checker.sentence import orbit_sentence, value_sentence
from grazing_checker.table import check_table_orbit, table_sentence
from grazing_checker.table_value import check_table_value, table_value_sentence
from grazing_checker.value import check_value, check_walled_value

#: All that is imported from the standard library.
STANDARD_LIBRARY = (
    "__future__", "collections.abc", "contextlib", "fractions", "hashlib", "itertools", "json", "math", "os", "pathlib",
    "re", "stat", "sys", "threading", "typing",
)  # fmt: skip
#: What every certificate rests on.
TRUSTED_BASE = (
    "Arb, the ball arithmetic of FLINT, called through python-flint",
    f"Python, 3.11 or later, with these modules of its standard library: {', '.join(STANDARD_LIBRARY)}",
    f"the source of grazing_checker for version {VERSION} of certificates",
    "the model as written in the statement, with its parameters the exact doubles given",
)
KRAWCZYK = "the theorems of Brouwer and Banach, as used by Krawczyk's test"
FLIGHTS = "the Taylor series of a flight and the bound of its rest, as derived in grazing_checker/flight.py"
SEEN = "that a wall that moves, or is above the ball, sees another force, as derived in grazing_checker/walls.py"
MULTIPLIERS = "Jury's criterion, and that the multipliers of a map that is smooth at a fixed point decide its stability"
BETWEEN = "the intermediate value theorem, on the curve of orbits that depends continuously on one coordinate"

TABLES = "the places, flights and turns of a ball on a table, as derived in grazing_checker/plane.py and table.py"
CYCLES = "that the equations of a word are those of its cycles, as derived in grazing_checker/gap.py"
STRETCHING = "the argument in grazing_checker/gap.py that blocks of the gap map stretch sqrt(s) ds, s = sqrt(x)"


class Kind(NamedTuple):
    """What checks a kind of certificate, ``check(data, inequalities) -> statement``, and the theorems that it uses.

    ``sentence(data)`` writes the statement of data that hold.
    """

    check: Callable[[Mapping[str, Any], list[Any]], str]
    sentence: Callable[[Mapping[str, Any]], str]
    theorems: tuple[str, ...]


KINDS = {
    "periodic orbit": Kind(check_orbit, orbit_sentence, (KRAWCZYK, FLIGHTS, MULTIPLIERS)),
    "periodic orbit with walls": Kind(check_walled_orbit, orbit_sentence, (KRAWCZYK, FLIGHTS, SEEN, MULTIPLIERS)),
    "periodic orbit on a table": Kind(check_table_orbit, table_sentence, (KRAWCZYK, TABLES, MULTIPLIERS)),
    "bifurcation value": Kind(check_value, value_sentence, (KRAWCZYK, FLIGHTS, MULTIPLIERS, BETWEEN)),
    "bifurcation value with walls": Kind(
        check_walled_value, value_sentence, (KRAWCZYK, FLIGHTS, SEEN, MULTIPLIERS, BETWEEN)
    ),
    "bifurcation value on a table": Kind(
        check_table_value, table_value_sentence, (KRAWCZYK, TABLES, MULTIPLIERS, BETWEEN)
    ),
    "gap map orbit": Kind(gap.check_gap_orbit, gap.orbit_sentence, (KRAWCZYK, CYCLES)),
    "gap map edge": Kind(gap.check_gap_edge, gap.edge_sentence, (KRAWCZYK, CYCLES)),
    "gap map without attracting orbits": Kind(gap.check_no_attractor, gap.no_attractor_sentence, (STRETCHING,)),
}


def trusted_base(kind: str) -> list[str]:
    """Return what a certificate of a kind rests on."""
    return [*TRUSTED_BASE, *KINDS[kind].theorems]


def check(certificate: str | Path | Mapping[str, Any]) -> str:
    """Verify a certificate and return the sentence that it proves.

    Parameters
    ----------
    certificate : path or dict
        A file, or its document.

    Returns
    -------
    str
        The statement, derived anew from the data: it holds if the trusted base does.

    Raises
    ------
    Rejected
        If it is no certificate, was changed, or does not prove its statement: says what is wrong first.
    """
    document = opened(certificate)
    kind = document["kind"]
    demand(kind in KINDS, f"its kind is {quoted(kind)}; allowed are {', '.join(KINDS)}")
    data, rows = document["data"], document["inequalities"]
    try:
        said = KINDS[kind].check(data, rows)
        if said != document["statement"]:  # the data hold in any order, so that nothing is proven again
            said = KINDS[kind].sentence(in_order(data))
    except Rejected:
        raise
    except Exception as error:  # the data are not ours: whatever they break, they prove nothing
        raise Rejected(f"its data cannot be used ({type(error).__name__}: {error})") from None
    demand(document["trusted_base"] == trusted_base(kind), "the trusted base is not that of this checker")
    demand(document["statement"] == said, f"the statement does not follow from the data; what follows is: {said}")
    return said


def in_order(data: Any) -> Any:
    """Return data with the parameters of each law as its formula names them, and the numbers of shapes by their kind.

    A sentence lists them as the file does. Another program may have put the keys of a file in another order.
    """
    if isinstance(data, list):
        return [in_order(each) for each in data]
    if not isinstance(data, Mapping):
        return data
    found = {name: in_order(each) for name, each in data.items()}
    if {"parameters", "after"} <= found.keys():
        found["parameters"] = law_values(found)
    if {"kind", "shape"} <= found.keys():
        found["shape"] = {name: found["shape"][name] for name in SHAPES[found["kind"]]}
    return found
