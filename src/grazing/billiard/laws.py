"""Laws of a table's objects, and a strategy, by address: compiled or in plain Python. Kernels get them in the block."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from grazing.billiard.strategy import Strategy
from grazing.kernel.compile import address, jit_disabled
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


@lru_cache(maxsize=256)
def strategy_at(flip: Callable[..., bool], kind: type) -> Callable[..., None]:
    """Return a strategy that writes 1 or 0 down, and gets its parameters as numbers in a row."""
    unpack = unpacker(kind)

    def strategy_at_row(state: Any, row: Any, found: Any, said: Any) -> None:
        found[0] = 1.0 * flip((state[0], state[1], state[2], state[3]), unpack(row))

    return strategy_at_row


@lru_cache(maxsize=256)
def _asked_in_python(player: Strategy, names: tuple[str, ...]) -> float:
    def asked(state: Any, row: Any, found: Any, _said: Any) -> None:
        found[0] = float(player.asked(tuple(state), dict(zip(names, row[: len(names)], strict=True))))

    pointed.append(asked)
    return float(len(pointed) - 1)


def strategy_address(player: Strategy, names: tuple[str, ...], arithmetic: str) -> float:
    """Return where a strategy lies: compiled in an arithmetic, or with "python" for plain Python."""
    if arithmetic == "python" or jit_disabled():
        return _asked_in_python(player, names)
    return address(strategy_at(player.flip, parameter_tuple(names)), "derivative", arithmetic, "the strategy")
