"""Marks on loops of which compiled code may take several turns at once, as vectors side by side.

A processor looks a few dozen operations ahead. Where each turn is one long chain of operations it waits most of the
time; taken two vectors at a time, operation by operation, one works while the other waits. The mark stands at the index
of the innermost loop, whose number of turns must be a multiple of those that are taken at once; sums over turns have no
place there, as their order would change. Nor may a turn read or write what another one writes: the compiler takes the
mark as a promise of that. It counts in kernels of the library, where :mod:`grazing.kernel.wide` is taken; the plain
form is the index and no more.
"""

from __future__ import annotations

from grazing.kernel.primitives import inlined


@inlined
def abreast(index: int) -> int:
    """Return an index; compiled code takes four turns of the loop around it at once: one vector."""
    return index


@inlined
def eights(index: int) -> int:
    """Return an index; compiled code takes eight turns of the loop around it at once."""
    return index
