"""How a checker reads a certificate: exact numbers, decimals, and inequalities that must hold as stated."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from grazing_checker.balls import Ball, number

#: Exact numbers have three times the digits of the finder's, and exponents beyond those of all doubles.
EXACT = re.compile(r"(-?)0x([0-9a-f]{1,600})p(-?[0-9]{1,4})")
DECIMAL = re.compile(r"-?[0-9]{1,60}(\.[0-9]{1,60})?(E[+-]?[0-9]{1,4})?")


#: Widest interval that a claim may give for a number, relative to its size, as a power of two.
BLUNT = -30


#: Most characters of a message, of a list of names in it, and of a value.
LONGEST, LIST, QUOTED = 10_000, 500, 80


class Rejected(ValueError):
    """A certificate that does not prove its statement, with the first thing that is wrong.

    The message is one line that can be read: what it quotes of a certificate may hold line ends and the like.
    """

    def __init__(self, said: str) -> None:
        short = said if len(said) <= LONGEST else f"{said[:LONGEST]}..."
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in short))


def quoted(text: Any) -> str:
    """Return what a certificate holds, for a message: the beginning if it is long."""
    said = repr(text)
    return said if len(said) <= QUOTED else f"{said[:QUOTED]}..."


def listed(names: Sequence[Any]) -> str:
    """Return names that a certificate holds, for a message: the first ones if there are many."""
    said = ", ".join(map(str, names[:QUOTED]))
    return said if len(said) <= LIST and len(names) <= QUOTED else f"{said[:LIST]}..."


def demand(holds: object, said: str) -> None:
    """Raise Rejected unless something holds."""
    if not holds:
        raise Rejected(said)


def exact(text: Any) -> Ball:
    """Return the number that an exact text such as ``-0x2bp-7`` means."""
    found = EXACT.fullmatch(text) if isinstance(text, str) else None
    if found is None:
        raise Rejected(f"{quoted(text)} is no exact number: 0x, at most 600 digits, p, at most 4 digits of an exponent")
    return number(int(found[2], 16) * (-1 if found[1] else 1), int(found[3]))


def text_of_double(text: Any) -> float:
    """Return the double that a text as of ``float.hex`` means."""
    try:
        x = float.fromhex(text)
    except (TypeError, ValueError, OverflowError):
        raise Rejected(f"{quoted(text)} is no double in hexadecimal") from None
    demand(x.hex() == text and abs(x) < float("inf"), f"{quoted(text)} is no finite double as float.hex writes it")
    return x


def decimal(text: Any) -> Ball:
    """Return a ball around the number that a decimal means."""
    if not (isinstance(text, str) and DECIMAL.fullmatch(text)):
        raise Rejected(
            f"{quoted(text)} is no decimal number: at most 60 digits before and after the point, and 4 of an exponent"
        )
    fraction = Fraction(text)
    return number(fraction.numerator) / fraction.denominator


def keys(document: Any, names: Sequence[str], where: str) -> None:
    """Demand that a mapping has these keys and no others."""
    demand(isinstance(document, Mapping), f"{where} is no mapping")
    wrong = sorted(set(document) ^ set(names))
    demand(not wrong, f"{where} lacks or adds {listed(wrong)}")


def numbers(texts: Any, count: int, where: str) -> list[Ball]:
    """Return a list of exact numbers of the right length."""
    demand(isinstance(texts, list) and len(texts) == count, f"{where} is no list of {count} numbers")
    return [exact(text) for text in texts]


def whole(number: Any, low: int, where: str) -> int:
    """Return an int that is at least ``low``."""
    demand(type(number) is int and number >= low, f"{where} is {quoted(number)}, not a whole number >= {low}")
    return int(number)


def within(x: Ball, texts: Any, where: str) -> None:
    """Demand that a ball lies between two decimals, which are close to it."""
    demand(isinstance(texts, list) and len(texts) == 2, f"{where} is no pair of decimals")
    low, high = (decimal(text) for text in texts)
    demand(low <= x and x <= high, f"{where} is claimed to lie in [{texts[0]}, {texts[1]}], which does not hold")
    room = abs(x).upper() * number(1, BLUNT) + 2**16 * x.rad()
    demand(high - low <= room, f"{where} is claimed with far too wide an interval")


class Inequalities:
    """The inequalities of a certificate, taken one after the other and verified.

    Each says that a quantity x is > left >= right, or < left <= right; x and right come from the checker.
    """

    def __init__(self, rows: Any) -> None:
        self.rows, self.at = rows, 0

    @property
    def name(self) -> str:
        """Name of the next inequality, empty at the end."""
        row = self.rows[self.at] if self.at < len(self.rows) else {}
        return str(row.get("name", "")) if isinstance(row, Mapping) else ""

    def left(self, name: str, relation: str, right: str = "0") -> Ball:
        """Return the left side of the next inequality, which must have this name and be true as it stands."""
        demand(self.at < len(self.rows), f"the inequality {name!r} is missing")
        row = self.rows[self.at]
        self.at += 1
        keys(row, ("name", "left", "relation", "right"), f"inequality {self.at}")
        demand(row["name"] == name, f"inequality {self.at} is {quoted(row['name'])}; expected is {name!r}")
        demand(
            row["relation"] == relation,
            f"the relation of {name!r} is {quoted(row['relation'])}; expected is {relation!r}",
        )
        demand(row["right"] == right, f"the right side of {name!r} is {quoted(row['right'])}; expected is {right!r}")
        left = decimal(row["left"])
        limit = exact(right) if "x" in right else decimal(right)
        held = left >= limit if relation == ">" else left <= limit
        demand(held, f"the inequality {name!r} is false: {row['left']} {relation} {right}")
        return left

    def more(self, name: str, x: Ball) -> None:
        """Verify x > left >= 0."""
        demand(x > self.left(name, ">"), f"the inequality {name!r} does not hold")

    def less(self, name: str, x: Ball, right: str = "0") -> None:
        """Verify x < left <= right."""
        demand(x < self.left(name, "<", right), f"the inequality {name!r} does not hold")

    def finish(self) -> None:
        """Demand that there is no further inequality."""
        demand(self.at == len(self.rows), f"the inequality {quoted(self.name)} is not one of this proof")
