"""Numbers as certificates write them: exact dyadic ones, and decimals rounded to the safe side."""

from __future__ import annotations

import json
from collections.abc import Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grazing.paths import path_of
from grazing.writing import whole_file

if TYPE_CHECKING:
    from flint import arb

#: Significant digits of the decimals.
DIGITS = 17


def exact_text(x: arb) -> str:
    """Return the midpoint of a ball exactly, such as ``-0x2bp-7`` for -43/128.

    Examples
    --------
    >>> from flint import arb
    >>> exact_text(arb(-43) / 128)
    '-0x2bp-7'
    """
    mantissa, exponent = (int(part) for part in x.mid().man_exp())
    return f"{mantissa:#x}p{exponent}"


def short(x: arb, bits: int) -> arb:
    """Return the midpoint of a ball, rounded to so many bits."""
    from flint import ctx

    with ctx.workprec(bits):
        return (+x.mid()).mid()


def below(x: arb, digits: int = DIGITS) -> str:
    """Return a decimal that is at most every number in the ball.

    Examples
    --------
    >>> from flint import arb
    >>> below(arb(1) / 3, 4), above(arb(1) / 3, 4)
    ('0.3333', '0.3334')
    """
    return _decimal(x.lower(), ROUND_FLOOR, digits)


def above(x: arb, digits: int = DIGITS) -> str:
    """Return a decimal that is at least every number in the ball."""
    return _decimal(x.upper(), ROUND_CEILING, digits)


def enclosed(x: arb, digits: int = DIGITS) -> list[str]:
    """Return decimals below and above a ball."""
    return [below(x, digits), above(x, digits)]


def about(low: str, high: str) -> str:
    """Return an interval between two decimals by its middle and how far it reaches from there, at least.

    Examples
    --------
    >>> about("0.12328144964385", "0.12328144964399")
    '0.12328144964392 to within 7.0e-14'
    """
    bounds = Fraction(low), Fraction(high)
    middle = f"{float(sum(bounds) / 2):.15g}"
    reach = max(abs(x - Fraction(middle)) for x in bounds)
    up = Context(prec=2, rounding=ROUND_CEILING)
    return f"{middle} to within {up.divide(Decimal(reach.numerator), Decimal(reach.denominator)):.1e}"


def _decimal(x: arb, rounding: str, digits: int) -> str:
    mantissa, exponent = (int(part) for part in x.man_exp())
    context = Context(prec=digits, rounding=rounding, Emin=-(10**9), Emax=10**9)
    number, scale = Decimal(mantissa), Decimal(2 ** abs(exponent))
    if exponent < 0:
        return str(context.divide(number, scale))
    return str(context.plus(Decimal(mantissa * 2**exponent)))


def write_certificate(document: Mapping[str, Any], path: str | Path) -> Path:
    """Write a certificate to a file, readable by eye, whole or not at all, and return the path.

    Raises
    ------
    InputError
        If it cannot be written; what was there stays.
    """
    target = path_of(path)
    text = json.dumps(document, indent=1, ensure_ascii=True, allow_nan=False) + "\n"
    with whole_file(target) as part:
        part.write_text(text, encoding="ascii")
    return target
