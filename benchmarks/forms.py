"""What each wide form of a primitive brings: block and launches with all of them, and without one after the other.

Each way is a process of its own, because a process compiles a kernel once. The processes stand side by side and take
turns, run by run; processor time is compared, so that others on the machine matter little.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import process_time

from rich.console import Console

from .measure import Tell
from .models import PASSIVE, STANDARD, Model, family
from .ours import program_of
from .pinball import launches
from .table import show

#: What is left out in each way; ``None`` for all, with numba's own way through its compiler.
WAYS: dict[str, Sequence[str] | None] = {
    "all forms wide": (),
    "without all_passed": ("all_passed",),
    "without first_failed": ("first_failed",),
    "without transposed": ("transposed",),
    "without listed": ("listed",),
    "without abreast, eights": ("abreast", "eights"),
    "all plain, numba's own pipeline": None,
}
#: The work of the block: model, columns and starts.
BLOCK: dict[str, tuple[Model, int, int]] = {
    "100 starts": (STANDARD, 400, 100),
    "10 starts": (STANDARD, 4000, 10),
    "V = 0": (PASSIVE, 400, 100),
}
#: All work: launches among so many discs, too.
DISCS = 8
WORK = (*BLOCK, f"{DISCS} discs")


@dataclass(frozen=True)
class Brought:
    """How many times as long each piece of work takes in a way: the median of the rounds."""

    way: str
    times: dict[str, float]


def forms(rounds: int, share: float, tell: Tell) -> list[Brought]:
    """Measure all ways; none where the plain forms are taken anyway."""
    from grazing.kernel.wide import plain

    if plain():
        return []
    with ExitStack() as stack:
        ways = {}
        for way, left_out in WAYS.items():
            tell(f"making ready: {way}")
            ways[way] = stack.enter_context(started(left_out, share))
            answer(ways[way])
        seconds: dict[tuple[str, str], list[float]] = {}
        for n in range(rounds):
            for work in WORK:
                for way in list(ways)[:: 1 if n % 2 == 0 else -1]:
                    tell(f"round {n + 1} of {rounds}: {way}")
                    ask(ways[way], work)
                    seconds.setdefault((way, work), []).append(float(answer(ways[way])))
        for process in ways.values():
            ask(process, "")
    first = next(iter(WAYS))
    return [
        Brought(
            way,
            {
                work: median(a / b for a, b in zip(seconds[way, work], seconds[first, work], strict=True))
                for work in WORK
            },
        )
        for way in WAYS
    ]


def started(left_out: Sequence[str] | None, share: float) -> subprocess.Popen[str]:
    """Start the process of a way."""
    env = {**os.environ, **({"GRAZING_WIDE": "0"} if left_out is None else {})}
    command = [sys.executable, "-m", "benchmarks.forms", ",".join(left_out or ()), str(share)]
    folder, pipe = Path(__file__).parents[1], subprocess.PIPE
    return subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True, env=env, cwd=folder)


def ask(process: subprocess.Popen[str], what: str) -> None:
    """Send a line."""
    assert process.stdin is not None
    process.stdin.write(f"{what}\n")
    process.stdin.flush()


def answer(process: subprocess.Popen[str]) -> str:
    """Return the next line."""
    assert process.stdout is not None
    return process.stdout.readline().strip()


def show_forms(out: Console, found: Sequence[Brought]) -> None:
    """Print how many times as long the work takes without a form."""
    lines = [(one.way, *(f"{one.times[work]:.2f}" for work in WORK)) for one in found]
    show(out, "Wide forms: time of the work, as a multiple of that with all of them", ("way", *WORK), lines)


def serve(left_out: Sequence[str], share: float) -> None:
    """Compile without some wide forms, then fly when asked to and say how long it took."""
    from grazing.kernel.wide import forms as registered

    listed = registered()
    for primitive in [each for each in listed if each.__name__ in left_out]:
        del listed[primitive]
    fly, _hits = launches()
    ready: dict[str, Callable[[], object]] = {name: job(*work, share) for name, work in BLOCK.items()}
    ready[WORK[-1]] = lambda: fly(DISCS, share)
    for run in ready.values():
        run()
    print("ready", flush=True)
    for line in sys.stdin:
        if not line.strip():
            return
        before = process_time()
        ready[line.strip()]()
        print(process_time() - before, flush=True)


def job(model: Model, columns: int, starts: int, share: float) -> Callable[[], object]:
    """Return a piece of work of the block."""
    program, work = program_of(model), family(max(round(columns * share), 8), starts)
    return lambda: program(work, 240, 10)


if __name__ == "__main__":
    serve(sys.argv[1].split(","), float(sys.argv[2]))
