"""A row of the table: a program with its share of the work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from .fixed import EACH, ORBITS, Verdict, judge
from .models import MODELS, Model, family
from .program import Program


class Job(NamedTuple):
    """A row made ready: ``run()`` does ``amount`` units of work."""

    run: Callable[[], object]
    amount: int
    verdict: Verdict | None = None
    note: str = ""


@dataclass(frozen=True)
class Row:
    """A line of the table.

    ``prepare(share)`` compiles, judges and returns the job with that share of the row's work; it raises
    :class:`.program.Missing` where the program cannot run. ``beside`` names the rows that the speed is compared with:
    the first of them that runs.
    """

    name: str
    prepare: Callable[[float], Job]
    beside: tuple[str, ...]
    unit: str = "orbit-period"
    threads: int = 1


def oscillator_row(
    name: str,
    program: Callable[[], Program],
    model: Model,
    columns: int,
    starts: int,
    beside: tuple[str, ...],
    periods: tuple[int, int] = (240, 10),
    each: int = EACH,
    orbits: int = ORBITS,
    threads: int = 1,
    least: int = 1,
) -> Row:
    """Return the row of a program on its share of the family: columns of starts, (thrown away, kept) periods.

    ``each`` and ``orbits`` say how much of the fixed set it is judged by, ``least`` how many columns it needs at least.
    """

    def prepare(share: float) -> Job:
        ready = program()
        known = model in MODELS.values()
        verdict = judge(ready, model, part(each, share), part(orbits, share)) if known else None
        work = family(max(part(columns, share), least), starts)
        return Job(lambda: ready(work, *periods), work.u.size * sum(periods), verdict)

    return Row(name, prepare, beside, threads=threads)


def part(whole: int, share: float) -> int:
    """Return a share of a number, at least 1."""
    return max(1, round(whole * share))
