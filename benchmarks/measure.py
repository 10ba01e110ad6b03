"""Interleaved rounds: every row once a round, so that what slows the machine for a while slows all of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import median
from time import perf_counter, process_time

from .program import Missing
from .row import Job, Row

#: ``tell(what)`` says what is being done.
Tell = Callable[[str], None]


@dataclass
class Result:
    """A row and what was measured: the seconds of each round, or why there are none."""

    row: Row
    job: Job | None = None
    missing: str = ""
    seconds: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)  # seconds of processor time, all threads together

    @property
    def rates(self) -> list[float]:
        """Units per second and core in each round."""
        return [self.job.amount / s / self.row.threads for s in self.seconds] if self.job else []


def measure(rows: Sequence[Row], rounds: int, share: float, tell: Tell) -> list[Result]:
    """Make all rows ready, judge them, then time them in rounds."""
    results = []
    for row in rows:
        tell(f"making ready: {row.name}")
        results.append(prepared(row, share))
    for n in range(rounds):
        for result in results:
            if result.job is not None:
                tell(f"round {n + 1} of {rounds}: {result.row.name}")
                start, cpu = perf_counter(), process_time()
                result.job.run()
                result.seconds.append(perf_counter() - start)
                result.cpu.append(process_time() - cpu)
    return results


def attention(results: Sequence[Result]) -> float:
    """Return the share of a core that one-thread rows got, in the median: 1 on a machine with nothing else to do."""
    shares = [
        c / s for result in results if result.row.threads == 1 for c, s in zip(result.cpu, result.seconds, strict=True)
    ]
    return median(shares) if shares else 1.0


def prepared(row: Row, share: float) -> Result:
    """Make one row ready; its first run, which may still compile, is not timed."""
    try:
        job = row.prepare(share)
        job.run()
    except Missing as reason:
        return Result(row, missing=str(reason))
    return Result(row, job)


def beside(result: Result, results: Sequence[Result]) -> Result | None:
    """Return what a row is compared with: the first of the rows it names that ran."""
    ran = {other.row.name: other for other in results if other.seconds}
    return next((ran[name] for name in result.row.beside if name in ran), None)


def ratio(fast: Result, slow: Result) -> float:
    """Return how many times faster, per core, the first is: the median of the ratios in each round."""
    return median(a / b for a, b in zip(fast.rates, slow.rates, strict=True))
