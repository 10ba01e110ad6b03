"""The command ``grazing``: its subcommands, and what it says when something goes wrong."""

from __future__ import annotations

import errno
import os
import re
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from difflib import get_close_matches
from typing import Any

from cyclopts import (
    App,
    CoercionError,
    CycloptsError,
    Group,
    MissingArgumentError,
    Parameter,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from grazing import __version__
from grazing.catalogue import studies
from grazing.cli import streams
from grazing.cli.paper import paper
from grazing.interrupt import causes, interrupt_in, taken
from grazing.memory import address_space
from grazing.outcome import GrazingError, InputError, OutsideForm, abridged, in_one_line, printable, raised, shown
from grazing.parameter import called_here, foreign

DONE, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130
#: Columns between which help is written: in one or two its writer never ends, in 10^30 it fails.
NARROW, WIDE = 20, 10_000
#: Bytes of addresses below which packages in C, while they are imported, fail or try again without an end.
LEAST = 10**9
#: What packages say that find no memory while they are imported: of a library of their own that is not loaded, for one.
NO_MEMORY = ("Cannot allocate memory", "failed to map segment")
#: What Python says where the machine, or a limit of the shell's, allows no more threads.
NO_THREAD = "can't start new thread"
#: A word that no message needs whole: no file has such a name.
_LONG_WORD = re.compile(r"\S{1000,}")
_NUMBER = re.compile(r"(?<!\w)[-+]?(\d+\.?\d*(e[-+]?\d+)?|nan|inf)(?!\w)")

#: Studies whose commands have commands of their own.
WITH_MORE = {"orbit": "grazing.cli.orbits:orbit"}
RESULTS = {
    "sweep": ("grazing.cli.sweep:app", "Compute a study chunk by chunk into a store; stop and resume it at will."),
    "plot": ("grazing.cli.plot:plot", "Draw any stored result."),
    "export": ("grazing.cli.export:export", "Write a stored result as tables (csv, parquet) or in one file (nc)."),
    "info": ("grazing.cli.info:info", "Tell what a file is, and the command that makes it again."),
    "table": ("grazing.cli.table:table", "Tell what stands on a pinball table, and draw it."),
    "explore": ("grazing.cli.explore:explore", "Explore in a browser, which computes by the same kernels."),
    "config": ("grazing.cli.configuration:app", "Print the schema of configuration files, or what one says."),
}


class Commands(App):
    """All commands, with completion that offers files of one's own for --map, and in bash names with spaces."""

    def generate_completion(self, **where: Any) -> str:
        """Return the script that completes our commands in a shell."""
        found: str = super().generate_completion(**where)
        for before, after in COMPLETED:
            found = found.replace(before, after)
        return found


#: Files in bash: readline finds and quotes them itself, whatever they are called; bash 3 cannot be asked for that.
FILES = """_grazing_files() {
  COMPREPLY=()
  compopt -o default -o filenames 2>/dev/null && return
  local _x
  while IFS= read -r _x; do COMPREPLY+=("$_x"); done < <(compgen -f -- "$1")
}

"""
#: What the scripts of completion say, and what they should: bash, zsh (--map=VALUE, then --map VALUE), fish.
COMPLETED = (
    ("_grazing() {\n  local cur", FILES + "_grazing() {\n  local cur"),
    ('COMPREPLY=( $(compgen -f -- "${cur}") )', '_grazing_files "${cur}"'),
    (
        '"normal-form")',
        '"normal-form"); while IFS= read -r _x; do [[ -e $_x ]] && _c+=("$_x"); done < <(compgen -G "*.py")',
    ),
    ("'gap' 'normal-form'", "'gap' 'normal-form' *.py(N)"),
    (
        ":map:(stroboscopic impact discontinuity gap normal-form)",
        ":map:{compadd -- stroboscopic impact discontinuity gap normal-form *.py(N)}",
    ),
    ("gap normal-form' -d", 'gap normal-form (string match -- "*.py" *)\' -d'),
)
app = Commands(
    name="grazing",
    help="Oscillators that hit things: impacts, grazing bifurcations and the maps that describe them.",
    help_format="plaintext",
    help_epilogue="Exit codes: 0 done, 1 failed, 2 wrong usage or input,\n"
    "3 incomplete: a sweep that can be resumed, 130 interrupted.",
    version=f"grazing {__version__}",
    default_parameter=Parameter(negative=(), json_list=False),
    suppress_keyboard_interrupt=False,
)
_studies, _orbits, _results = (
    Group("Studies", sort_key=1), Group("Orbits and branches", sort_key=2), Group("Results", sort_key=3)
)  # fmt: skip
# The commands of the studies are made from the schema when they are asked for: --help needs none of it.
for _study in studies().values():
    _help = f"{_study.help}\n\nExample: grazing {_study.name} {_study.example}"
    _group = _orbits if _study.orbits else _studies
    _where = WITH_MORE.get(_study.name, f"grazing.cli.study:{_study.name}")
    app.command(_where, name=_study.name, help=_help, group=_group, sort_key=_study.place)
for _order, (_name, (_where, _says)) in enumerate(RESULTS.items()):
    app.command(_where, name=_name, help=_says, group=_results, sort_key=_order)
app.command(paper, group=_results, sort_key=len(RESULTS))
app.register_install_completion_command(help="Install completion for your shell.")


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
        warnings.showwarning = _once()
        code = _guarded(list(sys.argv[1:] if tokens is None else tokens))
        return streams.flushed(code)


def _guarded(tokens: list[str]) -> int:
    """Run a command; whatever it raises becomes one message and an exit code."""
    try:
        _prepare_environment()
        result = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
        return result if isinstance(result, int) else DONE
    except CycloptsError as error:
        command = " ".join(["grazing", *(error.command_chain or ())])
        said = printable(_reworded(error), newlines=False)
        return _fail(f"{said} '{command} --help' lists what is allowed.", USAGE)
    except (InputError, OutsideForm) as error:
        return _fail(str(error), USAGE)
    except GrazingError as error:
        return _fail(str(error), FAILED)
    except KeyboardInterrupt as error:
        return _interrupted(error)
    except BrokenPipeError:
        return DONE
    except SystemExit as stop:  # how the writer of the help says that its reader has left
        if isinstance(stop.__context__, BrokenPipeError):
            return DONE
        return _fail(
            f"code of your own, or of a package, called sys.exit({shown(stop.code)}); leave that away.", FAILED
        )
    except (ImportError, OSError, MemoryError) as error:
        # Modules in C say of an interrupt that reaches them that something cannot be imported.
        asked = interrupt_in(error) if isinstance(error, ImportError) else None
        return _failed(error) if asked is None else _interrupted(asked)
    except BaseException as error:  # of whatever kind: a class of the user's may raise any
        if asked := interrupt_in(error):  # Python says of one in the making of a class that a name cannot be set
            return _interrupted(asked)
        if theirs := _misconfigured(error):
            return _fail(f"the configuration {theirs}; mend or remove it.", FAILED)
        if str(error) == NO_THREAD:
            return _fail("no thread can be started: memory or processes are short; ask for fewer threads.", FAILED)
        if streams.closed(sys.stdout):
            return _fail("code of your own, or of a package, closed the standard output; leave that away.", FAILED)
        if theirs := _in_own_code(error):
            return _fail(printable(theirs, newlines=False), FAILED)
        return _fail(
            f"{raised(error)}\nThis is a defect in grazing {__version__}. Please report it with the "
            "command you gave and the output\nof the same command with GRAZING_DEBUG=1 in front, which shows where "
            "it happened.",
            FAILED,
            "unexpected error",
        )


def _interrupted(stop: KeyboardInterrupt) -> int:
    """Say that the user ended it."""
    taken()
    return _fail(str(stop) or "interrupted; files already written are complete.", INTERRUPTED, "stopped")


def _failed(error: ImportError | OSError | MemoryError) -> int:
    """Say what the machine, or what is installed on it, did not do."""
    found = causes(error)
    if any(isinstance(one, MemoryError) or any(said in raised(one) for said in NO_MEMORY) for one in found):
        return _fail(
            "out of memory; ask for less: fewer values, starts or figures, a smaller --size, or a sweep into a store.",
            FAILED,
        )
    if not isinstance(error, OSError):
        return _fail(
            f"a package that grazing needs cannot be imported ({raised(found[-1])}); install grazing again.", FAILED
        )
    if error.errno == errno.ENAMETOOLONG:
        return _fail(f"a name of {len(str(error.filename))} letters is too long for a file; give a path.", USAGE)
    if error.filename is None and error.errno in (errno.ENOSPC, errno.EFBIG, errno.EIO):  # writers name their file
        return _fail(f"cannot write to the standard output: {error.strerror}; send it elsewhere.", FAILED)
    return _fail(str(error) if _somewhere() else "the folder that this runs in is gone; change to another.", FAILED)


def _prepare_environment() -> None:
    """See to it that what stands in the environment is nothing that libraries stumble over."""
    room = address_space()
    if room is not None and room < LEAST:
        raise GrazingError(
            f"this process may take {room / 1e9:.3g} GB (ulimit -v); the packages that compute take "
            f"{LEAST / 1e9:.0f} GB before they begin: raise the limit"
        )
    if "matplotlib" not in sys.modules:  # figures go to files, whatever backend there is, or is not
        os.environ["MPLBACKEND"] = "agg"
    try:
        time.time()
    except OverflowError:  # whoever asks for the time ends there, also in Python's own packages
        raise InputError(
            "the clock of this machine is outside the years 1678 to 2261, which Python cannot tell; set it"
        ) from None
    stamp = os.environ.get("SOURCE_DATE_EPOCH", "0")
    if not (stamp.isascii() and stamp.isdigit() and len(stamp) < 12):
        raise InputError(f"SOURCE_DATE_EPOCH = {shown(stamp)}; give a whole number of seconds, or unset it")
    # With 0 threads numba cannot be imported, and none are used. A store is the same whatever is preferred of others.
    for name in [name for name in os.environ if name == "NUMBA_NUM_THREADS" or name.startswith("ZARR_")]:
        del os.environ[name]
    # Our matrices are small, and each thread of a library that is told nothing takes tens of megabytes.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    wide = _columns()
    if wide and not NARROW <= wide <= WIDE:
        os.environ["COLUMNS"] = str(min(max(wide, NARROW), WIDE))


def _columns() -> int | None:
    """Return how wide the terminal is, or is said to be."""
    said = os.environ.get("COLUMNS", "")
    if said.isascii() and said.isdigit():
        return int(said[:9]) or 1
    os.environ.pop("COLUMNS", None)
    for stream in range(3):  # the first that is a terminal, as those who write the help look for it
        with suppress(OSError):
            return os.get_terminal_size(stream).columns
    return None


def _misconfigured(error: BaseException) -> str:
    """Return whose configuration, in a file or a variable, is why something failed, and how; empty for nobody's."""
    for one in causes(error):
        frames = [frame for frame, _line in traceback.walk_tb(one.__traceback__)][-1:]
        raised = [str(frame.f_globals.get("__name__", "")) for frame in frames]
        for where in (*raised, f"{type(one).__module__}.{type(one).__name__}"):
            package, _, inside = where.partition(".")
            if package != "grazing" and "config" in inside.lower():
                return f"of {package} that is found here cannot be used: {in_one_line(one)}"
    return ""


def _in_own_code(error: BaseException) -> str:
    """Return what a file of one's own raised, such as a property of a class in it; nothing if it was no such file."""
    from grazing.copies import OWN_MODULE

    frames = [*traceback.walk_tb(error.__traceback__)]
    modules = [str(frame.f_globals.get("__name__", "")) for frame, _line in frames]
    last = max((i for i, name in enumerate(modules) if name.startswith(("grazing.", OWN_MODULE))), default=-1)
    if last < 0 or not modules[last].startswith(OWN_MODULE):
        return ""
    frame, line = frames[last]
    return f"line {line} of {frame.f_code.co_filename} raised {raised(error)}"


def _somewhere() -> bool:
    """Whether the folder that this process runs in is there."""
    try:
        return bool(os.getcwd())
    except OSError:
        return False


def _reworded(error: CycloptsError) -> str:
    """Return the parser's message as a sentence."""
    if isinstance(error, UnusedCliTokensError):
        extra = shown(" ".join(error.unused_tokens or ()))
        return f"Unexpected argument {extra}: options begin with --, and an option's value follows its name."
    if isinstance(error, MissingArgumentError) and error.keyword and type(error) is MissingArgumentError:
        return f"{error.keyword} needs a value behind it."  # the parser takes other options for this one, misspelt
    if isinstance(error, CoercionError) and error.token is not None and error.target_type in (bool, int):
        option, value = error.token.keyword, shown(error.token.value)
        if error.target_type is bool:
            return f"{option} is {value}: it takes no value."
        return f"Invalid value for {option}: {value} is no whole number."
    if isinstance(error, UnknownCommandError) and error.app is app:  # the parser would load every command to name it
        known = [*studies(), *RESULTS, "paper"]
        token = (error.unused_tokens or [""])[0]
        near = get_close_matches(token[:200], known, n=1)
        hint = f'Did you mean "{near[0]}"? ' if near else ""
        return f'Unknown command "{token}"{foreign(token, known)}. {hint}Commands are {", ".join(known)}.'
    if isinstance(error, UnknownOptionError) and error.argument_collection:
        given = (error.token.keyword or error.token.value).partition("=")[0]
        options = {name.lstrip("-"): name for argument in error.argument_collection for name in argument.names}
        word = given.lstrip("-")
        near = [name for name in options if name.lower() == word.lower()]  # names keep their case: --V is a velocity
        if said := "" if near else called_here(word, options):
            return f"Unknown option: {given}. Here that is {said}; a rig with a {word} is given by --si."
        near = near or get_close_matches(word[:200], options, n=1)  # without the dashes, in which all are alike
        hint = f" Did you mean {options[near[0]]}?" if near else _as_parameter(word, error)
        return f"Unknown option: {given}{foreign(word, options)}.{hint}"
    return str(error)


def _as_parameter(word: str, error: CycloptsError) -> str:
    """Say how a parameter is given that has no option, where an unknown one may be meant for that."""
    from grazing.config.settings import SETTINGS  # where a study is asked for, it is imported already

    if (error.command_chain or ("",))[0] not in studies() or word.replace("-", "_") in SETTINGS:
        return ""
    named = word.isascii() and word.replace(".", "").isidentifier()
    return f" A parameter that has no option is given as {word}=VALUE." if named else ""


def _fail(message: str, code: int, kind: str = "error") -> int:
    """Write one message to stderr, with the traceback if GRAZING_DEBUG asks for it; return the code."""
    if os.environ.get("GRAZING_DEBUG", "0") not in ("", "0"):
        traceback.print_exc()
    said = _LONG_WORD.sub(lambda word: abridged(word[0]), printable(message))
    print(f"{kind}: {said}", file=sys.stderr)
    return code


def _once() -> Callable[..., None]:
    """Return what writes a warning as one line; of those that differ in their numbers alone, the first of a command.

    A library's may have a traceback in it: what comes before says what there is to say.
    """
    told: set[str] = set()

    def show(message: Warning | str, *_where: object, **_more: object) -> None:
        kind = _NUMBER.sub("", str(message))
        if kind not in told:
            told.add(kind)
            said = " ".join(str(message).partition("\nTraceback")[0].splitlines())
            print(f"warning: {printable(said)}", file=sys.stderr)

    return show
