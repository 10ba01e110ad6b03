"""What can happen, in words: outcomes of a step, trust in a result, and the exceptions.

Kernels never raise. They return an integer whose bits are the flags of :class:`Outcome`; wrong input raises
at once, before any kernel runs, with one of the exceptions below::

    GrazingError
    ├── InputError      a value out of range, an unknown name, a wrong shape (also a ValueError)
    ├── UserCodeError   a user's step or reset law that raises, or returns what it must not
    └── OutsideForm     a model that a closed form or a normal form does not cover, refused by name
"""

from __future__ import annotations

import operator
import os
import reprlib
import shlex
import sys
import traceback
import unicodedata
from collections.abc import Iterable
from enum import Enum, IntFlag
from typing import Any, Final

__all__ = ["GrazingError", "InputError", "Outcome", "OutsideForm", "Trust", "UserCodeError", "describe"]

#: Where the package lies: what is raised there is not a user's line.
HOME: Final = os.path.dirname(os.path.abspath(__file__)) + os.sep

# The bits as plain integers, because kernels fold them with `|`.
OK: Final = 0
GRAZE: Final = 1
AMBIGUOUS: Final = 2
STUCK: Final = 4
CHATTER: Final = 8
NO_IMPACT: Final = 16
DIVERGED: Final = 32
BAD_LAW: Final = 64
TOO_MANY_IMPACTS: Final = 128
INSIDE_WALL: Final = 256
TOO_MANY_SWINGS: Final = 512
ESCAPED: Final = 1024

#: Bits after which a step has no next state: the orbit ends there.
FATAL: Final = NO_IMPACT | DIVERGED | BAD_LAW | TOO_MANY_IMPACTS | INSIDE_WALL | TOO_MANY_SWINGS


class Outcome(IntFlag):
    """What happened during a step, as bits that add up over an orbit.

    Examples
    --------
    >>> from grazing import Outcome
    >>> Outcome(9)
    <Outcome.graze|chatter: 9>
    """

    ok = OK
    graze = GRAZE
    ambiguous = AMBIGUOUS
    stuck = STUCK
    chatter = CHATTER
    no_impact = NO_IMPACT
    diverged = DIVERGED
    bad_law = BAD_LAW
    too_many_impacts = TOO_MANY_IMPACTS
    inside_wall = INSIDE_WALL
    too_many_swings = TOO_MANY_SWINGS
    escaped = ESCAPED


class Trust(Enum):
    """How far a result can be trusted.

    ``certified``: every decision (impact or no impact) is right for the double-precision state it was given.
    ``numerical``: some part rests on floating-point evidence alone, such as a finite difference.
    ``ambiguous``: at least one decision was closer than the rounding error; the other answer is as likely.
    """

    certified = "certified"
    numerical = "numerical"
    ambiguous = "ambiguous"


_ADVICE = {
    Outcome.graze: ("the orbit touches the wall with zero speed", "vary the parameter to see both sides"),
    Outcome.ambiguous: (
        "impact or no impact could not be decided in double precision",
        "treat the orbit as either of the two",
    ),
    Outcome.stuck: (
        "the ball rests on the wall, for a while or for ever; on a table it slides or rests on an object",
        "nothing to do: it leaves the wall if the forcing ever releases it",
    ),
    Outcome.chatter: (
        "infinitely many impacts in finite time, completed in closed form",
        "nothing to do: the ball then sticks until released",
    ),
    Outcome.no_impact: (
        "no further impact within 1000 periods; on a table the ball rests, or slides to and fro, for ever",
        "use the stroboscopic map, which needs no impact",
    ),
    Outcome.diverged: ("the orbit left the region of interest", "look at the starting box and the parameters"),
    Outcome.bad_law: (
        "the reset law returned a velocity into the wall or not finite",
        "make the law return v_plus >= 0 for every v_minus < 0",
    ),
    Outcome.too_many_impacts: (
        "more than 10,000 impacts in one period; on a table more than were allowed, a ball at rest on a level one, one "
        "that is jammed, or bounces too small to tell apart on a flipper that turns",
        "choose r < 1 or a larger V, or declare the contraction of the law",
    ),
    Outcome.too_many_swings: (
        "more than 47,000 swings of the free ball in one period of the forcing; on a table more than a million turns "
        "of a flipper in one flight",
        "the time scales are too far apart for exact work: raise omega or alpha, lower k, flip less often",
    ),
    Outcome.escaped: (
        "the ball left through a drain, or for good without meeting anything",
        "nothing to do: that is no error",
    ),
    Outcome.inside_wall: (
        "the state lies inside the wall, u < sigma, or inside an object of a table",
        "start with u >= sigma, or where the ball is free",
    ),
}


def describe(outcome: int | Iterable[int]) -> str:
    """Say in words what an outcome means and what to do about it.

    Parameters
    ----------
    outcome : int or array_like of int
        Bits of :class:`Outcome`; of several outcomes, such as those of an orbit, all bits together.

    Returns
    -------
    str
        One sentence per bit; ``"ok"`` when no bit is set.

    Examples
    --------
    >>> from grazing import describe
    >>> describe(0)
    'ok'
    """
    if isinstance(outcome, range):
        outcome = outcome[: 2 * max(Outcome)]
    try:
        bits = 0
        for one in outcome if isinstance(outcome, Iterable) and not isinstance(outcome, str) else [outcome]:
            bits |= operator.index(one)
    except TypeError:
        raise InputError(f"outcome is {shown(outcome)}; give the integer, or integers, that a map returned") from None
    if not 0 <= bits < 2 * max(Outcome):
        raise InputError(f"outcome is {shown(bits)}; allowed are sums of the flags of gz.Outcome")
    outcome = bits
    said = [f"{flag.name}: {what}; {advice}" for flag, (what, advice) in _ADVICE.items() if outcome & flag]
    return ". ".join(said) or "ok"


_SHORT = reprlib.Repr()
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = _SHORT.maxset = _SHORT.maxarray = 8
_SHORT.maxstring = _SHORT.maxother = 120


def shown(value: object) -> str:
    """Return a value as a message shows it: as Python writes it, cut where that is long, and never an error.

    Examples
    --------
    >>> from grazing.outcome import shown
    >>> shown("a"), shown(range(10**9)), shown(list(range(10**6))), shown(10**9999)
    ("'a'", 'range(0, 1000000000)', '[0, 1, 2, 3, 4, 5, 6, 7, ...]', 'a whole number of 33216 bits')
    """
    if isinstance(value, int) and value.bit_length() > 400:  # Python writes no number of thousands of digits
        return f"a whole number of {value.bit_length()} bits"
    try:
        return " ".join(_SHORT.repr(value).splitlines())
    except Exception:  # of somebody else's object, or of one that holds itself or such a number
        return f"<{type(value).__name__}>"


def printable(text: str, newlines: bool = True) -> str:
    r"""Return a text as a terminal may have it: what files say must not move its cursor or pass for another line.

    Examples
    --------
    >>> from grazing.outcome import printable
    >>> printable("\x1b[2Jgone\n\u202ereversed")
    '\\x1b[2Jgone\n\\u202ereversed'
    """
    kept = "\n\t" if newlines else "\t"
    return "".join(
        letter if letter.isprintable() or letter in kept or unicodedata.category(letter) == "Zs"
        else letter.encode("unicode_escape").decode("ascii")
        for letter in text
    )  # fmt: skip


def quoted(word: str) -> str:
    r"""Return a word as a shell takes it, in one line that a terminal may have: the shell reads exactly this word.

    What a terminal must not get, or cannot, is written in octal, as bash, zsh and POSIX of 2024 read it.

    Examples
    --------
    >>> from grazing.outcome import quoted
    >>> print(quoted("a b.nc"), quoted("a\nb.nc"))
    'a b.nc' $'a\012b.nc'
    """
    lost = {letter for letter in word if not _shows(letter)}
    if printable(word, newlines=False) == word and "\t" not in word and not lost:
        return shlex.quote(word)
    plain = {letter: letter for letter in word if letter.isprintable() and letter not in "\\'" and letter not in lost}
    return "$'" + "".join(plain.get(one) or "".join(f"\\{byte:03o}" for byte in _bytes(one)) for one in word) + "'"


def _shows(letter: str) -> bool:
    """Say whether the standard output has a letter: one that it has not would be written as its number."""
    try:
        letter.encode(getattr(sys.stdout, "encoding", None) or "utf-8")
    except (UnicodeEncodeError, LookupError, TypeError):
        return False
    return True


def quoted_file(file: str) -> str:
    """Return the name of a file as :func:`quoted` has words; what begins with - is no option.

    Examples
    --------
    >>> from grazing.outcome import quoted_file
    >>> quoted_file("a.nc"), quoted_file("-o.nc")
    ('a.nc', './-o.nc')
    """
    return quoted(f"./{file}" if file.startswith("-") else file)


def _bytes(letter: str) -> bytes:
    """Return the bytes of a letter of a name: of one that no text has, those that the system gave."""
    try:
        return os.fsencode(letter)
    except UnicodeEncodeError:
        return letter.encode("utf-8", "surrogatepass")


#: Items of a list, and letters of a word, that are written out where an object says what it is.
ITEMS, LETTERS = 16, 60


def listed(items: Iterable[str], most: int = ITEMS) -> str:
    """Return items with commas between them; of many the first, and how many more there are.

    Examples
    --------
    >>> from grazing.outcome import listed
    >>> listed("abc"), listed(map(str, range(1000)), 3)
    ('a, b, c', '0, 1, 2 and 997 more')
    """
    every = list(items)
    more = len(every) - most
    return ", ".join(every) if more <= 0 else f"{', '.join(every[:most])} and {more} more"


def abridged(word: str) -> str:
    """Return a word; of a long one the beginning, and how many characters it has.

    Examples
    --------
    >>> from grazing.outcome import abridged
    >>> abridged("LLR"), abridged("L" * 99 + "R")[-24:]
    ('LLR', 'LLLL... (100 characters)')
    """
    return word if len(word) <= LETTERS else f"{word[:LETTERS]}... ({len(word)} characters)"


def in_one_line(error: object) -> str:
    """Return the first line of what an error says."""
    said = getattr(error, "strerror", None) or _words(error)
    return str(said).splitlines()[0] if said else type(error).__name__


def _words(error: object) -> str:
    """Return what an error says; nothing of somebody's class that fails when it is asked."""
    try:
        return str(error)
    except Exception:
        return ""


def raised(error: object) -> str:
    """Return what was raised: its type, and what it says if it says anything."""
    said = _words(error)
    return f"{type(error).__name__}: {said}" if said else type(error).__name__


def told(error: BaseException, code: Any = None) -> str:
    """Return what a user's code raised, with the line in which it did.

    That line is never one of the package: of a ``code`` that could not be called it is the one that defines it.

    Examples
    --------
    >>> from grazing.outcome import told
    >>> try:
    ...     1 / 0
    ... except ZeroDivisionError as error:
    ...     print(told(error))
    ZeroDivisionError: division by zero, in line ... of <doctest ...>: 1 / 0
    """
    said = raised(error)[:500]
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(HOME)]
    file = getattr(getattr(code, "__code__", None), "co_filename", None)
    frames = [frame for frame in frames if frame.filename == file] or frames  # rather than one of a library it calls
    if not frames:
        return said + defined(code)
    line = f": {frames[-1].line}" if frames[-1].line else ""
    return f"{said}, in line {frames[-1].lineno} of {frames[-1].filename}{line}"


def defined(code: Any) -> str:
    """Return where a user's function is defined, after what is said of it; nothing for one of the package."""
    place = getattr(code, "__code__", None)
    if place is None or place.co_filename.startswith(HOME):
        return ""
    return f" (defined in line {place.co_firstlineno} of {place.co_filename})"


def level_outside() -> int:
    """Return the ``stacklevel`` with which a warning names the line that called the package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(HOME):
        frame, level = frame.f_back, level + 1
    return level


class GrazingError(Exception):
    """Base of every exception that grazing raises on purpose; its message has a line for each argument.

    Names of files and what files say may hold line ends and what moves the cursor of a terminal: both are escaped.
    """

    def __init__(self, *lines: object) -> None:
        super().__init__(*(printable(str(line), newlines=False) for line in lines))

    def __str__(self) -> str:
        return "\n".join(self.args)


class InputError(GrazingError, ValueError):
    """A value that is not allowed: says what was got, what is allowed and what to do."""


class UserCodeError(GrazingError, RuntimeError):
    """A user's step or reset law raised, does not compile, or returned what it must not."""


class OutsideForm(GrazingError, ValueError):
    """A model lies outside a closed form or normal form; the message names the condition that fails."""
