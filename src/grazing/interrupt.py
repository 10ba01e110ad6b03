"""Ctrl-C: an interrupt ends a command once, also where Python, or a package in C, has lost it."""

from __future__ import annotations

import signal
import sys
import threading
import time
from _thread import get_ident, interrupt_main, start_new_thread
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

#: Seconds between two looks at what became of an interrupt; after two at which nobody ends by it, it is lost.
LOOK = 0.05
#: Whether an interrupt came while a command ran: numpy, where it is imported, says of one that it cannot be.
CAME = threading.Event()


def causes(error: BaseException) -> list[BaseException]:
    """Return an error, what it came from, and so on; somebody else's may come from itself."""
    found: list[BaseException] = []
    one: BaseException | None = error
    while one is not None and not any(one is other for other in found):
        found.append(one)
        one = one.__cause__ or one.__context__
    return found


def interrupt_in(error: BaseException) -> KeyboardInterrupt | None:
    """Return the interrupt that an error came from; None for none."""
    found = next((one for one in causes(error) if isinstance(one, KeyboardInterrupt)), None)
    return KeyboardInterrupt() if found is None and isinstance(error, ImportError) and CAME.is_set() else found


def taken() -> None:
    """Let Python end with our exit code although there was an interrupt.

    It keeps in mind that one left code that it was given as text, as that of a named tuple, and then ends by the
    signal, although it was caught. The next such code makes it forget.
    """
    exec("")


@contextmanager
def held_back() -> Iterator[None]:
    """Let an interrupt wait until the block has ended: what it would leave half done stays broken for the session.

    That is so of a package that is imported, of tables that numba fills, and of what llvmlite closes. Such a block has
    to be short: an import of the largest takes a second or so.
    """
    before, came = signal.getsignal(signal.SIGINT), []

    def note(*what: Any) -> None:
        came.append(what)

    # none of what is no function of Python's leaves anything half done
    if callable(before):
        with suppress(ValueError):  # no interrupt comes into another thread; threading can be wrong on which it is
            signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        if signal.getsignal(signal.SIGINT) is note:
            signal.signal(signal.SIGINT, before)
        if came and callable(before):
            before(*came[0])


@contextmanager
def none_lost() -> Iterator[None]:
    """Interrupt once more where an interrupt was lost.

    Python drops one in a finaliser or a callback, and packages in C clear it as they clear an error of their own:
    numpy does so where it asks whether a class is one of ctypes.
    """
    before, here, over, watched = sys.unraisablehook, get_ident(), False, False

    def watch() -> None:
        nonlocal watched
        if not watched:
            watched = True
            with suppress(RuntimeError):  # no thread can be had
                start_new_thread(again, ())  # not by threading, whose locks a finaliser may have come upon

    def again() -> None:
        nonlocal watched
        missed = 0
        while not over and missed < 2:
            time.sleep(LOOK)
            missed = 0 if _ending(here) else missed + 1
        watched = False
        if over:
            return
        if hasattr(signal, "pthread_kill"):  # which ends what waits, too
            signal.pthread_kill(here, signal.SIGINT)
        else:  # pragma: no cover
            interrupt_main()

    def interrupted(number: int, frame: Any) -> None:
        CAME.set()
        try:
            watch()
        finally:
            signal.default_int_handler(number, frame)

    def dropped(what: sys.UnraisableHookArgs) -> None:
        if issubclass(what.exc_type, KeyboardInterrupt):
            watch()
        else:
            before(what)

    sys.unraisablehook = dropped
    # in the background it is ignored, and stays so; only the main thread may choose
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    ours = ours and threading.current_thread() is threading.main_thread()
    if ours:
        signal.signal(signal.SIGINT, interrupted)
    try:
        yield
    finally:
        sys.unraisablehook, over = before, True
        CAME.clear()
        if ours and signal.getsignal(signal.SIGINT) is interrupted:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _ending(thread: int) -> bool:
    """Whether a thread is ending what it does because of an interrupt."""
    handled: Any = sys._current_exceptions().get(thread)
    error = handled[1] if isinstance(handled, tuple) else handled  # a tuple up to Python 3.11
    return error is not None and interrupt_in(error) is not None
