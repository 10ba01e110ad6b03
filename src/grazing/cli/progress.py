"""Progress on stderr: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Progress = Callable[[int, int, str], None]
Counted = Callable[[int, int], None]
#: Seconds between plain lines about a count: at first, and at most.
SOON, LATE = 5.0, 60.0


@contextmanager
def shown(quiet: bool = False) -> Iterator[Progress]:
    """Give a function ``progress(done, total, what)`` that shows how far a command of named steps is.

    Parameters
    ----------
    quiet : bool
        Show nothing.
    """
    if quiet:
        yield lambda done, total, what: None
    elif on_terminal():
        with _bar() as progress:
            yield progress
    else:
        yield _lines()


@contextmanager
def said(what: str, quiet: bool = False) -> Iterator[None]:
    """Say what is going on, for a step of unknown length: beside a spinner on a terminal, in a line elsewhere.

    Parameters
    ----------
    what : str
    quiet : bool
        Say nothing.
    """
    if quiet:
        yield
    elif on_terminal():
        from rich.console import Console
        from rich.markup import escape

        with Console(stderr=True).status(escape(what)):
            yield
    else:
        print(what, file=sys.stderr, flush=True)
        yield


@contextmanager
def counted(what: str, quiet: bool = False, then: str = "", first: str = "") -> Iterator[Counted]:
    """Give a function ``progress(done, total)`` that shows how far a study is, with rate and time left.

    Parameters
    ----------
    what : str
        What is counted, such as ``"values"``.
    quiet : bool
        Show nothing.
    then : str
        What follows when all are done, where that takes long; it may be counted too, up to a limit.
    first : str
        What is going on, said at once where no bar shows it and the first count may take long.
    """
    if quiet:
        yield lambda done, total: None
    elif on_terminal():
        with _counting_bar(what, then) as progress:
            yield progress
    else:
        if first:
            print(first, file=sys.stderr, flush=True)
        yield _counting_lines(what, then)


def on_terminal() -> bool:
    """Say whether stderr can show a bar."""
    return sys.stderr.isatty() and os.environ.get("TERM", "") not in ("", "dumb")


def _lines() -> Progress:
    """Return progress as one line per step."""
    start = time.monotonic()

    def progress(done: int, total: int, what: str) -> None:
        width = len(str(total))
        print(f"[{done:{width}}/{total}] {time.monotonic() - start:6.1f} s  {what}", file=sys.stderr, flush=True)

    return progress


def _counting_lines(what: str, then: str) -> Counted:
    """Return progress as a line now and then, ever more rarely, and one at the end."""
    start = last = time.monotonic()
    base: tuple[float, int] | None = None
    wait, before, limited = SOON, -1, False

    def progress(done: int, total: int) -> None:
        nonlocal base, before, last, limited, what, then, wait
        now = time.monotonic()
        if before not in (-1, total):  # what follows is counted as well
            base, what, then, limited = (last, 0), then or what, "", True
        before = total
        if base is None:  # compiling comes before it, and what a resumed sweep has already
            base = now, done
        if done < total and now - last < wait:
            return
        wait = wait if last == start else min(2.0 * wait, LATE)
        last = now
        width = len(str(total))
        said = f"[{done:{width}}{' of at most ' if limited else '/'}{total}] {now - start:6.1f} s"
        if done > base[1]:
            rate = (done - base[1]) / max(now - base[0], 1e-9)
            left = "" if done >= total or limited else f", {duration((total - done) / rate)} left"
            said += f"  {rate:.3g} {what}/s{left}"
        print(said + (f"; {then}" if then and done >= total else ""), file=sys.stderr, flush=True)

    return progress


def duration(seconds: float) -> str:
    """Return a time in words.

    Examples
    --------
    >>> duration(0.25), duration(75.0), duration(40000.0), duration(1e6)
    ('0.25 s', '1 min 15 s', '11 h 6 min', '11 d 13 h')
    """
    if seconds < 60.0:
        return f"{seconds:.2g} s" if seconds < 10.0 else f"{seconds:.0f} s"
    minutes = round(seconds) // 60
    if minutes < 60:
        return f"{minutes} min {round(seconds) % 60} s"
    hours = minutes // 60
    return f"{hours} h {minutes % 60} min" if hours < 48 else f"{hours // 24} d {hours % 24} h"


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


@contextmanager
def _counting_bar(what: str, then: str) -> Iterator[Counted]:
    """Give progress as a bar with rate and time left, which goes away when the command is done."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(compact=True), TextColumn("{task.fields[left]}"),
    )  # fmt: skip
    with Bar(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False) as bar:
        task = bar.add_task(what, total=None, rate="", left="left")
        before, limited = -1, False

        def progress(done: int, total: int) -> None:
            nonlocal before, limited, what, then
            if before not in (-1, total):  # what follows is counted as well
                what, then, limited = then or what, "", True
                bar.reset(task, rate="", left="")
                bar.tasks[0].total = None  # how much there will be is not known
            before = total
            speed = bar.tasks[0].speed
            shown = then if then and done >= total else what
            rate = f"{speed:.3g}/s" if speed else ""
            bar.update(task, completed=done, total=None if limited else total, description=shown, rate=rate)

        yield progress
