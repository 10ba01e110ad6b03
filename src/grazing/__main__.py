"""Run the command line with ``python -m grazing``."""

import signal
import sys
import time
from _thread import get_ident, interrupt_main, start_new_thread
from collections.abc import Iterator
from contextlib import contextmanager


def main() -> int:
    """Run the command line; an interrupt while its packages are still imported is no traceback, either."""
    with _none_dropped():
        try:
            from grazing.cli import main as run
        except KeyboardInterrupt:
            print("stopped: interrupted.", file=sys.stderr)
            return 130
        return run()


@contextmanager
def _none_dropped() -> Iterator[None]:
    """Interrupt once more where Python has dropped an interrupt, as it does in a finaliser or a callback."""
    before, here, over = sys.unraisablehook, get_ident(), False

    def again() -> None:
        time.sleep(0.05)
        if over:
            return
        if hasattr(signal, "pthread_kill"):  # which ends what waits, too
            signal.pthread_kill(here, signal.SIGINT)
        else:  # pragma: no cover
            interrupt_main()

    def dropped(what: "sys.UnraisableHookArgs") -> None:
        if not issubclass(what.exc_type, KeyboardInterrupt):
            before(what)
        elif not over:  # not by threading, whose locks the finaliser may have come upon
            start_new_thread(again, ())

    sys.unraisablehook = dropped
    try:
        yield
    finally:
        sys.unraisablehook, over = before, True


if __name__ == "__main__":
    raise SystemExit(main())
