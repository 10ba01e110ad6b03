"""The tables of speeds: the oscillator, the gap map, and what is to be reached."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from rich.console import Console

from .fixed import Verdict
from .goals import Goal, reached
from .measure import Result, attention, beside, ratio
from .table import show

#: With less than this share of a core, speeds are those of a busy machine.
QUIET = 0.97


def show_speeds(out: Console, results: Sequence[Result]) -> None:
    """Print the tables of the oscillator and of the gap map."""
    orbits = [result for result in results if result.row.unit == "orbit-period"]
    loops = [result for result in results if result.row.unit == "iterate"]
    if orbits:
        head = ("#", "program", "op/s", "min..max", "times slower", "missed dips", "false dips", "worst error")
        lines = [(str(n), *orbit_line(result, orbits)) for n, result in enumerate(orbits, 1)]
        show(out, "Oscillator: orbit-periods per second and core (op/s)", head, lines, left=2)
    if loops:
        columns = ("loop", "ns/iterate", "min..max", "times slower", "")
        show(out, "Gap map: time of one iterate", columns, [loop_line(result, loops) for result in loops])

    share = attention(results)
    if share < QUIET:
        out.print(f"\nThe machine was busy: rows got {share:.2f} of a core. Trust the ratios; measure speeds again.")


def orbit_line(result: Result, results: Sequence[Result]) -> tuple[str, ...]:
    """Return the cells of one program."""
    if not result.seconds or result.job is None:
        return absent(result, 6)
    rates = result.rates
    spread = f"{short(min(rates))}..{short(max(rates))}"
    return result.row.name, short(median(rates)), spread, slower(result, results), *verdict(result.job.verdict)


def loop_line(result: Result, results: Sequence[Result]) -> tuple[str, ...]:
    """Return the cells of one loop."""
    if not result.seconds or result.job is None:
        return absent(result, 4)
    times = [1e9 / rate for rate in result.rates]
    other = beside(result, results)
    times_slower = f"{ratio(other, result):.2f}" if other not in (None, result) else ""
    spread = f"{min(times):.3f}..{max(times):.3f}"
    return result.row.name, f"{median(times):.3f}", spread, times_slower, result.job.note


def absent(result: Result, cells: int) -> tuple[str, ...]:
    """Return the cells of a row that could not run."""
    return f"{result.row.name} ({result.missing})", *("",) * cells


def slower(result: Result, results: Sequence[Result]) -> str:
    """Return how many times slower a program is than the one it is compared with, and which that is."""
    other = beside(result, results)
    if other is None or other is result:
        return ""
    number = ratio(other, result)
    digits = f"{number:.3g}" if number < 100.0 else f"{number:,.0f}"
    return f"{digits} (#{results.index(other) + 1})"


def verdict(found: Verdict | None) -> tuple[str, str, str]:
    """Return missed and false dips of those tried, and the worst error."""
    if found is None:
        return "", "", ""
    worst = f"{found.worst:.0e}"
    if found.dips is None:
        return "", "", worst
    return f"{found.missed}/{found.dips}", f"{found.false}/{found.clearances}", worst


def short(rate: float) -> str:
    """Return a rate with three digits: 1.23 M."""
    for unit, size in (("M", 1e6), ("k", 1e3)):
        if rate >= size:
            return f"{rate / size:.3g} {unit}"
    return f"{rate:.0f}"


def show_goals(out: Console, wanted: Sequence[Goal], results: Sequence[Result]) -> None:
    """Print what is to be reached, as far as both rows ran."""
    lines = []
    for goal in wanted:
        found = reached(goal, results)
        if found is not None:
            answer = "yes" if found >= goal.wanted else "no"
            lines.append((goal.row, goal.other, f"{goal.wanted:.2f}", f"{found:.2f}", answer))
    if lines:
        head = ("row", "against", "goal", "measured", "reached")
        show(out, "Goals: how many times as fast, all cores of a row together", head, lines, left=2)
