"""What is known of a parameter, said once: read by checks, docstrings, options and axis labels."""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache, lru_cache
from itertools import islice
from keyword import iskeyword
from typing import Any

from grazing.outcome import InputError, shown

#: What a rig in SI units calls in another way than the model that is made of it.
OF_A_RIG = {
    "frequency": "omega = 2 pi frequency, in SI units also '14 Hz'",
    "gap": "sigma = -gap",
    "m": "the mass by which forces are divided: make another model",
    "c": "alpha = c/m",
    "force": "cos1 = force/m, with its sign",
    "load": "offset = load/m, with its sign",
}
#: Most forcing periods between impacts that windows and boundary curves are computed for.
MANY_PERIODS = 1000
#: Times beyond which a double is too coarse: in periods, for a phase; in lengths of a motion that is flown on one clock
#: throughout, of which less than 20 binary digits are left.
LATEST, COARSE = 1e15 / (2.0 * math.pi), 2.0**33
#: What a kernel can count to.
LARGEST = 2**63 - 1
#: What the names of types of named parameters begin with; no other name does.
PREFIX = "Parameters:"


@dataclass(frozen=True, slots=True)
class Parameter:
    """A named real number with its symbol, meaning and allowed range.

    Parameters
    ----------
    name : str
        Name in Python, on the command line and in files.
    symbol : str
        LaTeX, without dollar signs.
    meaning : str
        What it is, in a few words.
    low, high : float
        Allowed range, ends included unless ``open`` says otherwise.
    open : str
        ``"low"`` when the lower end itself is not allowed, else empty.
    units : str
        Of its values: ``"1"`` for a number, empty where nobody knows.

    Examples
    --------
    >>> Parameter("r", "r", "coefficient of restitution", 0.0, 1.0).check(0.8)
    0.8
    """

    name: str
    symbol: str
    meaning: str
    low: float = -math.inf
    high: float = math.inf
    open: str = ""
    units: str = "1"

    @property
    def attributes(self) -> dict[str, Any]:
        """What stands beside its values in a result, as CF names it."""
        said = {"long_name": self.meaning, "units": self.units, "symbol": self.symbol}
        return said if self.units else {key: text for key, text in said.items() if key != "units"}

    @property
    def allowed(self) -> str:
        """The range in words, such as ``0 <= r <= 1``."""
        if self.low == -math.inf and self.high == math.inf:
            return f"any finite {self.name}"
        if self.high == math.inf:
            return f"{self.name} {'>' if self.open == 'low' else '>='} {self.low:g}, finite"
        return f"{self.low:g} {'<' if self.open == 'low' else '<='} {self.name} <= {self.high:g}"

    def check(self, value: Any) -> float:
        """Return the value as a float, or raise InputError saying what is allowed."""
        usual = type(value) is float and math.isfinite(value)  # then no words are needed
        number = value if usual else real(value, self.name, f"allowed is {self.allowed} ({self.meaning})")
        inside = self.low <= number <= self.high and not (self.open == "low" and number == self.low)
        if not inside:
            raise InputError(f"{self.name} = {number:g}; allowed is {self.allowed} ({self.meaning})")
        return number


@cache
def parameter_tuple(names: tuple[str, ...]) -> type:
    """Return the named tuple type of these fields; the same type for the same names, as compiled code needs it."""
    fields = tuple(name.replace(".", "_") for name in names)  # A.r is A_r in code
    made: Any = namedtuple("Parameters", fields or ("none",))  # type: ignore[misc]  # no tuple of nothing in a kernel
    # a name of its own, by which pickle finds it in any process: behind a dot it would look in what stands before it
    made.__qualname__ = f"{PREFIX}{','.join(names)}".replace(".", ":")
    return made


def __getattr__(name: str) -> Any:
    """Return the type of named parameters that pickle asks for, see :func:`parameter_tuple`."""
    if name.startswith(PREFIX):
        return parameter_tuple(tuple(name.removeprefix(PREFIX).replace(":", ".").split(",")) if name != PREFIX else ())
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def parameters(params: Mapping[str, float]) -> Any:
    """Return the named tuple of these parameters, as a kernel gets it."""
    return parameter_tuple(tuple(params))(*(params.values() or (0.0,)))


def checked_params(params: Any) -> dict[str, float]:
    """Return parameters as an ordered dict of finite floats, or raise InputError; names must work as attributes."""
    if not isinstance(params, Mapping):
        raise InputError(f"params is {shown(params)}; give a mapping of names to numbers, such as {{'a': 1.9}}")
    for name in params:
        if not (isinstance(name, str) and all(map(_is_name, name.split(".")))):
            raise InputError(f"parameter name {shown(name)}; allowed is a Python name, no keyword, no leading _")
    return {str(name): real(value, name, "allowed is any finite number") for name, value in params.items()}


@lru_cache(maxsize=4096)
def _is_name(text: str) -> bool:
    return text.isidentifier() and not iskeyword(text) and not text.startswith("_")


def checked_coordinates(names: Any) -> tuple[str, ...]:
    """Return the names of coordinates, or raise InputError."""
    several = isinstance(names, Sequence) and not isinstance(names, (str, bytes)) and len(names) > 0
    if not several or not all(isinstance(name, str) and name for name in names):
        raise InputError(f"coordinates are {shown(names)}; give their names, such as ('x', 'y')")
    return tuple(map(str, names))


def in_order(values: Any) -> Any:
    """Return several numbers whose order counts; raise TypeError for sets, masked or complex ones and dates."""
    if isinstance(values, (Set, Mapping)):
        raise TypeError("a set has no order")
    from numpy import ma  # not before: the command line starts without

    if ma.is_masked(values):
        raise TypeError("masked values are none")
    if getattr(getattr(values, "dtype", None), "kind", "") in ("c", "m", "M"):
        raise TypeError("complex values and dates are no real numbers")
    return values


def refuse_ends(low: float, high: float, said: str) -> None:
    """Raise InputError for the ends of a range, which are ``said``, unless the first is lower and the range finite."""
    if not low < high:
        raise InputError(f"{said}; {'both ends are the same' if low == high else 'the lower end must come first'}")
    if high - low == math.inf:
        raise InputError(f"{said}; the ends are so far apart that no double holds how far")


def checked_box(box: object, coordinates: Sequence[str], what: str = "box") -> tuple[tuple[float, float], ...]:
    """Return a box as pairs of floats, one per coordinate, or raise InputError."""
    wanted = f"give one (low, high) for each of {', '.join(coordinates)}"
    try:
        pairs = [(low, high) for low, high in box]  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        raise InputError(f"{what} is {shown(box)}; {wanted}") from None
    if len(pairs) != len(coordinates):
        raise InputError(f"{what} has {len(pairs)} intervals for {len(coordinates)} coordinates; {wanted}")
    checked = []
    for (low, high), name in zip(pairs, coordinates, strict=True):
        low, high = (real(end, f"{what} of {name}", "finite ends") for end in (low, high))
        refuse_ends(low, high, f"{what} of {name} is ({low:g}, {high:g})")
        checked.append((low, high))
    return tuple(checked)


def real(value: Any, name: str, allowed: str) -> float:
    """Return a finite float, or raise InputError; booleans, text, complex numbers and arrays are refused."""
    if type(value) is float and math.isfinite(value):
        return value
    try:
        if not _is_number(value):
            raise TypeError
        number = float(value)
    except Exception:  # of whatever object was given
        raise InputError(f"{name} = {shown(value)} is not a real number; {allowed}") from None
    if not math.isfinite(number):
        raise InputError(f"{name} = {number} is not finite; {allowed}")
    return number


def refuse_late(
    time: float, name: str, period: float, most: float = LATEST, advice: str = "take whole periods off"
) -> None:
    """Raise InputError for a time so far from 0 that a double has no phase in a period, or in all that is followed."""
    latest = most * period
    if abs(time) > latest:
        raise InputError(
            f"{name} = {time:g}; allowed is |{name}| <= {latest:g}: beyond, doubles are too coarse for what happens "
            f"within {period:g}; {advice}"
        )


def whole(value: Any, name: str, low: int, high: float = LARGEST) -> int:
    """Return an int from low to high, or raise InputError."""
    if type(value) is int and low <= value <= high:
        return value
    try:
        if not _is_number(value) or int(value) != value:
            raise TypeError
        number = int(value)
    except Exception:  # of whatever object was given
        raise InputError(f"{name} = {shown(value)}; allowed is a whole number >= {low}") from None
    if number < low:
        raise InputError(f"{name} = {shown(number)}; allowed is a whole number >= {low}")
    if number > high:
        raise InputError(f"{name} = {shown(number)}; allowed is a whole number from {low} to {high}")
    return number


def checked_periods(N: Any) -> list[int]:
    """Return numbers of forcing periods, each once and in order, or raise InputError; one number stands for itself."""
    wanted = f"give a whole number from 1 to {MANY_PERIODS} or several, such as range(1, 8)"
    try:
        alone = isinstance(N, (str, int, float)) or (hasattr(N, "dtype") and N.ndim == 0)
        several = [N] if alone else islice(N, MANY_PERIODS + 1)
        found = sorted({whole(n, "N", 1) for n in several})
    except TypeError:
        raise InputError(f"N is {shown(N)}; {wanted}") from None
    if found and (found[-1] > MANY_PERIODS or len(found) > MANY_PERIODS):
        raise InputError(f"N goes to {found[-1]}: that would run for days; {wanted}")
    return found


def _is_number(value: Any) -> bool:
    """Whether a value may stand for one number: of arrays only those of no dimension."""
    kind = getattr(getattr(value, "dtype", None), "kind", "f")
    if kind == "O" and getattr(value, "ndim", 1) == 0:  # an array around any object
        return _is_number(value.item())
    return not isinstance(value, (bool, str, bytes, bytearray)) and getattr(value, "ndim", 0) == 0 and kind in "fiu"


def called_here(name: object, names: Iterable[str]) -> str:
    """Return what a quantity of a rig is of a model with these parameters; nothing for any other name."""
    known = {*names}
    if not isinstance(name, str) or name not in OF_A_RIG or "omega" not in known:
        return ""
    return OF_A_RIG[name] if "offset" in known else OF_A_RIG[name].replace("offset", "d")


def foreign(name: str, names: Iterable[str]) -> str:
    """Return which letter of an unknown name none of the known ones has: it may look just like one of theirs.

    Examples
    --------
    >>> from grazing.parameter import foreign
    >>> foreign("co" + chr(0x455), ["cos"]).partition(" is ")[2], foreign("coz", ["cos"])
    ('U+0455, CYRILLIC SMALL LETTER DZE)', '')
    """
    known = {letter for one in names for letter in one}
    for letter in name[:200]:
        if not letter.isascii() and letter not in known:
            from unicodedata import name as called

            return f" (its {shown(letter)} is U+{ord(letter):04X}, {called(letter, 'a letter without a name')})"
    return ""


def unknown(name: object, names: Iterable[str], of: str) -> InputError:
    """Return the error for a name that does not exist, with the nearest one that does."""
    known = list(names)
    near = get_close_matches(name[:200], known, n=1) if isinstance(name, str) else []
    hint = f" Did you mean {near[0]!r}?" if near else ""
    if said := called_here(name, known):
        hint = f" Here that is {said}."
    letter = foreign(name, known) if isinstance(name, str) else ""
    return InputError(f"unknown parameter {shown(name)} of {of}{letter}.{hint} Allowed are: {', '.join(known)}")


def named_by(name: Any, names: Iterable[str]) -> list[str]:
    """Return the parameters that a name stands for: that one, or with ``r`` the ``A.r`` and ``B.r`` of the walls' laws.

    Places and motions of walls are each its own, and no name stands for several. Empty for a name of nothing.

    Examples
    --------
    >>> from grazing.parameter import named_by
    >>> known = ["alpha", "A.sigma", "A.r", "B.sigma", "B.r", "B.V"]
    >>> named_by("alpha", known), named_by("r", known), named_by("V", known), named_by("sigma", known)
    (['alpha'], ['A.r', 'B.r'], ['B.V'], [])
    """
    known = list(names)
    if not isinstance(name, str):
        return []
    if name in known:
        return [name]
    own = name == "sigma" or (name[:3] in ("cos", "sin") and name[3:].isdigit())
    return [] if own or "." in name else [one for one in known if one.endswith(f".{name}")]


def value_of(name: str, params: Mapping[str, float]) -> float:
    """Return the value of a parameter; raise InputError where a name stands for several with different values."""
    found = {one: params[one] for one in named_by(name, params)}
    if len({*found.values()}) > 1:
        differ = " and ".join(f"{one} = {value:g}" for one, value in found.items())
        raise InputError(f"{name} stands for {differ}; begin where they are equal, or name one of them")
    return float(next(iter(found.values()), float("nan")))


def checked_text(name: Any) -> str:
    """Return what may be the name of a parameter or a coordinate, or raise InputError."""
    if not isinstance(name, str):
        raise InputError(f"name is {shown(name)}; give the name of a parameter or a coordinate, a text")
    return str(name)


def checked_name(name: Any, names: Iterable[str], of: str) -> str:
    """Return the name of a parameter, or of several, see :func:`named_by`; raise InputError for anything else."""
    known = list(names)
    if not named_by(name, known):
        raise unknown(name, known, of)
    return str(name)


def spread(changes: Mapping[str, Any], names: Iterable[str], of: str) -> dict[str, Any]:
    """Return changes by the names of parameters, refusing names that do not exist, and one that is changed twice."""
    if not isinstance(changes, Mapping):
        raise InputError(f"changes of {of} are {shown(changes)}; give a mapping of names to values")
    known, found = list(names), dict[str, Any]()
    for name, value in changes.items():
        for one in named_by(checked_name(name, known, of), known):
            if one in found or (one != name and one in changes):
                raise InputError(f"{name} stands for {one}, too, which is given beside it; give one of them")
            found[one] = value
    return found


def updated(params: Mapping[str, float], changes: Mapping[str, Any], of: str) -> dict[str, Any]:
    """Return params with changes applied, refusing names that do not exist."""
    return {**params, **spread(changes, params, of)}
