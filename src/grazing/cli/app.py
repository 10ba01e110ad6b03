"""The command ``grazing``: its subcommands, and what it says when something goes wrong."""

from __future__ import annotations

import os
import sys
import traceback
import warnings
from collections.abc import Sequence

from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

from grazing import __version__
from grazing.cli import streams
from grazing.cli.paper import paper
from grazing.outcome import GrazingError, InputError, OutsideForm

DONE, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130

app = App(
    name="grazing",
    help="Oscillators that hit things: impacts, grazing bifurcations and the maps that describe them.",
    help_format="plaintext",
    help_epilogue="Exit codes: 0 done, 1 failed, 2 wrong usage or input, 130 interrupted.",
    version=f"grazing {__version__}",
    default_parameter=Parameter(negative=()),
    suppress_keyboard_interrupt=False,
)
app.command(paper)


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    tokens : sequence of str, optional
        What follows ``grazing``; default: the arguments of this process.

    Returns
    -------
    int
        The exit code.
    """
    with streams.prepared(), warnings.catch_warnings():
        warnings.showwarning = _show_warning
        code = _guarded(list(sys.argv[1:] if tokens is None else tokens))
        return streams.flushed(code)


def _guarded(tokens: list[str]) -> int:
    """Run a command; whatever it raises becomes one message and an exit code."""
    try:
        result = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
        return result if isinstance(result, int) else DONE
    except CycloptsError as error:
        command = " ".join(["grazing", *(error.command_chain or ())])
        return _fail(f"{_reworded(error)} '{command} --help' lists what is allowed.", USAGE)
    except (InputError, OutsideForm) as error:
        return _fail(str(error), USAGE)
    except GrazingError as error:
        return _fail(str(error), FAILED)
    except KeyboardInterrupt:
        return _fail("interrupted; files already written are complete.", INTERRUPTED, "stopped")
    except BrokenPipeError:
        return DONE
    except ImportError as error:
        return _fail(f"a package that grazing needs cannot be imported ({error}); install grazing again.", FAILED)
    except OSError as error:
        return _fail(str(error), FAILED)
    except MemoryError:
        return _fail("out of memory; ask for a smaller --size or fewer figures.", FAILED)
    except Exception as error:
        return _fail(
            f"{type(error).__name__}: {error}\nThis is a defect in grazing {__version__}. Please report it with the "
            "command you gave and the output\nof the same command with GRAZING_DEBUG=1 in front, which shows where "
            "it happened.",
            FAILED,
            "unexpected error",
        )


def _reworded(error: CycloptsError) -> str:
    """Return the parser's message as a sentence."""
    if isinstance(error, UnusedCliTokensError):
        extra = " ".join(error.unused_tokens or ())
        return f"Unexpected argument {extra!r}: options begin with --, and an option's value follows its name."
    return str(error)


def _fail(message: str, code: int, kind: str = "error") -> int:
    """Write one message to stderr, with the traceback if GRAZING_DEBUG asks for it; return the code."""
    if os.environ.get("GRAZING_DEBUG", "0") not in ("", "0"):
        traceback.print_exc()
    print(f"{kind}: {message}", file=sys.stderr)
    return code


def _show_warning(message: Warning | str, *_where: object, **_more: object) -> None:
    """Write a warning as one line."""
    print(f"warning: {message}", file=sys.stderr)
