"""The balls that everything here is computed with; the one file that names python-flint.

A ball is an ``arb``: it surely holds the number that is meant. All that the checker asks of balls is

- ``+ - * /`` and unary ``-`` and ``abs``, with balls and whole numbers; ``**`` with a whole exponent >= 0,
- ``<``, ``<=``, ``>``, ``>=``, true only if they hold for all numbers of both balls,
- ``sqrt``, ``exp``, ``log``, ``sin_cos``; ``is_finite``, ``is_zero`` (0 and nothing else),
- ``mid``, ``lower``, ``upper``, ``rad``: exact balls; ``man_exp`` and ``float`` of an exact ball,

and the functions below. Another arithmetic that does this may stand in the place of ``flint``.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import RLock

from flint import arb, arb_poly, ctx

Ball = arb
#: The working precision belongs to the process, so one certificate is checked at a time.
LOCK = RLock()
if hasattr(os, "register_at_fork"):  # a fork has none of the other threads, and waits for none
    os.register_at_fork(after_in_child=LOCK._at_fork_reinit)  # type: ignore[attr-defined]


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Compute with middles of so many bits."""
    with LOCK:
        before, ctx.prec = ctx.prec, bits
        try:
            yield
        finally:
            ctx.prec = before


def working_bits() -> int:
    """Return the bits of the middles."""
    return int(ctx.prec)


def number(mantissa: int, exponent: int = 0) -> Ball:
    """Return m 2^e, exactly."""
    return Ball((mantissa, exponent))


def double(x: float) -> Ball:
    """Return a double, exactly."""
    return Ball(x)


def around(centre: Ball, radius: Ball) -> Ball:
    """Return a ball of all numbers within a radius, >= 0, of a centre."""
    return centre + Ball(0, 1) * radius


def between_0_and(reach: Ball) -> Ball:
    """Return a ball of all numbers from 0 to an exact reach."""
    return Ball(0.5, 0.5) * reach


def polynomial(terms: Sequence[Ball], s: Ball, order: int = 0) -> Ball:
    """Return a derivative, at s, of the polynomial with these coefficients, the constant first."""
    found = arb_poly(terms)
    for _ in range(order):
        found = found.derivative()
    return found(s)


def pi() -> Ball:
    """Return a ball around pi."""
    return Ball.pi()
