"""Progress on stderr: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Progress = Callable[[int, int, str], None]


@contextmanager
def shown(quiet: bool = False) -> Iterator[Progress]:
    """Give a function ``progress(done, total, what)`` that shows how far a command is.

    Parameters
    ----------
    quiet : bool
        Show nothing.
    """
    if quiet:
        yield lambda done, total, what: None
    elif sys.stderr.isatty() and os.environ.get("TERM", "") not in ("", "dumb"):
        with _bar() as progress:
            yield progress
    else:
        yield _lines()


def _lines() -> Progress:
    """Return progress as one line per step."""
    start = time.monotonic()

    def progress(done: int, total: int, what: str) -> None:
        width = len(str(total))
        print(f"[{done:{width}}/{total}] {time.monotonic() - start:6.1f} s  {what}", file=sys.stderr, flush=True)

    return progress


@contextmanager
def _bar() -> Iterator[Progress]:
    """Give progress as a bar, which goes away when the command is done."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Bar(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False) as bar:
        task = bar.add_task("starting", total=None)

        def progress(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=escape(what))

        yield progress
