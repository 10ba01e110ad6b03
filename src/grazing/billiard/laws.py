"""The laws of a table's objects by address, compiled or for plain Python: kernels get them in the table's block."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.kernel.compile import address
from grazing.kernel.lanes import unpacker
from grazing.kernel.primitives import pointed
from grazing.oscillator.reset import Reset, in_python
from grazing.parameter import parameter_tuple


@lru_cache(maxsize=256)
def law_at(law: Callable[..., float], kind: type) -> Callable[[float, Any], float]:
    """Return a law, or its slope, that gets its parameters as numbers in a row."""
    unpack = unpacker(kind)

    def law_at_row(v: float, row: Any) -> float:
        return 1.0 * law(v, unpack(row))

    return law_at_row


@lru_cache(maxsize=256)
def _in_python(law: Callable[..., float], kind: type) -> float:
    pointed.append(law_at(in_python(law), kind))
    return float(len(pointed) - 1)


def addresses(law: Reset | None, arithmetic: str) -> tuple[float, float]:
    """Return where a law and its slope lie: compiled in an arithmetic, or with "python" for plain Python."""
    if law is None:  # of a drain
        return 0.0, 0.0
    kind = parameter_tuple(tuple(law.params))
    if arithmetic == "python":
        return _in_python(law.law, kind), _in_python(law.slope, kind)
    who = f"the reset law {law.name}"
    return (
        address(law_at(law.law, kind), "value", arithmetic, who),
        address(law_at(law.slope, kind), "value", arithmetic, f"the slope of {law.name}"),
    )
