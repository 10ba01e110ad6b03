"""All rows of the speed table, in their order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from . import against, gap, ours, plain
from .models import BETWEEN, NARROW, PASSIVE, STANDARD, THREE_HARMONICS, UNDER_DAMPED, Model
from .peers import diffrax, heyoka, scipy, sundae
from .program import Program, foreign
from .row import Job, Row, oscillator_row

MAIN, STRICT, SCALAR = "grazing, block fast", "grazing, block strict", "grazing, scalar strict"
FORMER, FORMER_STRICT = "{}, as it stands", "{}, no contraction"
UNDER, THREE, WALLS, TIGHT = ", under-damped", ", three harmonics", ", two walls", ", two walls, narrow"
PASSIVE_ROW, FEW, TWO, OWN = MAIN + ", V = 0", MAIN + ", 10 starts", MAIN + ", two threads", MAIN + ", own law"
BATCH = "heyoka, batch of 16"
GAP, ROOTS = "gap map, fast", "square roots alone"


def rows(other: tuple[Path, str] | None = None) -> list[Row]:
    """Return the rows; ``other`` is the file and function of --against."""
    return [*our_rows(), *(other_rows(*other) if other else []), *peer_rows(), *gap_rows()]


def our_rows() -> list[Row]:
    """Return the rows of this library."""

    def row(name: str, model: Model = STANDARD, columns: int = 1600, starts: int = 100, **how: Any) -> Row:
        program = partial(ours.program_of, model, **how)
        return oscillator_row(name, program, model, columns, starts, (MAIN, SCALAR), threads=how.get("threads", 1))

    return [
        row(MAIN),
        row(TWO, threads=2),
        row(STRICT, arithmetic="strict"),
        row(PASSIVE_ROW, PASSIVE),
        row(FEW, columns=16_000, starts=10),
        row(MAIN + UNDER, UNDER_DAMPED, columns=400),
        row(MAIN + THREE, THREE_HARMONICS, columns=400),
        row(OWN, own_law=True),
        row(MAIN + WALLS, BETWEEN, columns=400),
        row(MAIN + TIGHT, NARROW, columns=400),
        row(SCALAR, columns=10, arithmetic="strict", algorithm="scalar"),
        row(SCALAR + ", two threads", columns=10, arithmetic="strict", algorithm="scalar", threads=2),
    ]


def other_rows(path: Path, name: str) -> list[Row]:
    """Return the rows of a kernel from a file."""

    def row(title: str, contraction: bool, beside: str) -> Row:
        program = partial(against.program_of, path, name, contraction)
        return oscillator_row(title.format(name), program, STANDARD, 400, 100, (beside, SCALAR))

    return [row(FORMER, True, MAIN), row(FORMER_STRICT, False, STRICT)]


def peer_rows() -> list[Row]:
    """Return the rows of all other programs; the slow ones get less to do."""

    def row(name: str, program: Callable[[Model], Program], columns: int, starts: int, **what: Any) -> Row:
        model = what.pop("model", STANDARD)
        beside = (MAIN, SCALAR) if model == STANDARD else (f"{MAIN}, {model.name}",)
        made = oscillator_row(name, partial(program, model), model, columns, starts, beside, **what)
        return replace(made, prepare=partial(guarded, made.prepare))

    slow: dict[str, Any] = {"columns": 10, "starts": 2, "periods": (10, 10), "each": 2}
    many: dict[str, Any] = {"columns": 40, "starts": 50, "periods": (10, 10), "each": 10, "least": 40}
    return [
        row("numba, plain closed form", plain.program_of, 20, 100),
        row(BATCH, heyoka.batch, 40, 16),
        row(BATCH + ", fast_math", partial(heyoka.batch, fast_math=True), 40, 16),
        row(BATCH + UNDER, heyoka.batch, 40, 16, model=UNDER_DAMPED),
        row(BATCH + THREE, heyoka.batch, 40, 16, model=THREE_HARMONICS),
        row(BATCH + WALLS, heyoka.batch, 40, 16, model=BETWEEN),
        row(BATCH + TIGHT, heyoka.batch, 40, 16, model=NARROW),
        row("heyoka, scalar", heyoka.scalar, 40, 4),
        row("diffrax Dopri8", partial(diffrax.solver, method="Dopri8"), **many),
        row("diffrax Tsit5", partial(diffrax.solver, method="Tsit5"), **many),
        row("CVODE Adams (scikit-sundae)", partial(sundae.cvode, method="Adams"), **slow),
        row("CVODE BDF (scikit-sundae)", partial(sundae.cvode, method="BDF"), **slow),
        row("SciPy LSODA", partial(scipy.solver, method="LSODA"), **slow),
        row("SciPy DOP853", partial(scipy.solver, method="DOP853"), **slow),
    ]


def guarded(prepare: Callable[[float], Job], share: float) -> Job:
    """Prepare a row that may fail without stopping the others."""
    with foreign():
        return prepare(share)


def gap_rows() -> list[Row]:
    """Return the gap map and its limit."""

    def row(name: str, prepare: Callable[[], Job]) -> Row:
        return Row(name, lambda share: prepare(), (ROOTS,), unit="iterate")  # too short to be shared out

    return [
        row(ROOTS, gap.roots_job),
        row(GAP, partial(gap.map_job, arithmetic="fast")),
        row("gap map, strict", partial(gap.map_job, arithmetic="strict")),
    ]
