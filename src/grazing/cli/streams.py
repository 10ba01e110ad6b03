"""Standard output and error that hold: closed, closed early, or unable to show a letter."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO


@contextmanager
def prepared() -> Iterator[None]:
    """Make stdout and stderr safe to write to: a missing one is replaced, letters they lack are escaped."""
    before = sys.stdout, sys.stderr
    opened: list[TextIO] = []
    with suppress(OSError):  # of a machine whose own is broken
        while (number := os.open(os.devnull, os.O_RDWR)) < 3:  # else a file of ours gets it, and what libraries print
            pass
        os.close(number)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            stream = open(os.devnull, "w", encoding="utf-8")
            opened.append(stream)
            setattr(sys, name, stream)
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
            if stream is sys.__stderr__ and isinstance(stream, io.TextIOWrapper):
                stream.flush()
                sys.stderr = io.TextIOWrapper(
                    _Said(stream.fileno()), stream.encoding, "backslashreplace", write_through=True
                )
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before
        for stream in opened:
            stream.close()


class _Said(io.RawIOBase):
    """What a command says beside its result: on a full disk, or to a reader that left, it is lost, and no more."""

    def __init__(self, number: int) -> None:
        self._number = number

    def write(self, content: Any) -> int:
        """Write all that can be written."""
        left = memoryview(content)
        with suppress(OSError):
            while left:
                left = left[os.write(self._number, left) :]
        return len(content)

    def writable(self) -> bool:
        """Say that it can be written to."""
        return True

    def fileno(self) -> int:
        """Return the number of the stream."""
        return self._number

    def isatty(self) -> bool:
        """Say whether it is a terminal."""
        return os.isatty(self._number)


def flushed(code: int) -> int:
    """Flush both streams and return the exit code: 1 if what was written could not be kept, as on a full disk.

    A reader that closed the pipe (``| head``) has what it wanted: that is no failure.
    """
    for stream in (sys.stdout, sys.stderr):
        if closed(stream):
            continue
        try:
            stream.flush()
        except BrokenPipeError:
            _discard(stream)
        except OSError as error:
            _discard(stream)
            if stream is sys.stdout and code == 0:
                print(f"error: cannot write to the standard output: {error.strerror}", file=sys.stderr)
                code = 1
    return code


def closed(stream: TextIO | None) -> bool:
    """Say whether code that was run has closed a stream, or taken it away."""
    return stream is None or stream.closed


def _discard(stream: object) -> None:
    """Send what is left in a broken stream's buffer nowhere, or the interpreter complains at exit."""
    try:
        target = os.open(os.devnull, os.O_WRONLY)
        os.dup2(target, stream.fileno())  # type: ignore[attr-defined]
        os.close(target)
    except (OSError, ValueError):
        pass
