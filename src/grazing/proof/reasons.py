"""Why there is no proof, and of what the precision at hand leaves open."""

from __future__ import annotations

from typing import Any

from grazing.oscillator.sure import Undecided

#: Where the test function of a Neimark-Sacker bifurcation is 0, and there is none.
SADDLE = "two real multipliers have the product 1 there, a neutral saddle: no complex pair is on the unit circle"


class NotProven(Exception):
    """Why there is no proof, and what to try."""


class Virtual(NotProven):
    """The orbit passes through a wall."""


class Open(Exception):
    """What the precision at hand does not decide."""


class Stage:
    """Says what was being decided when a ball was too wide."""

    def __init__(self, said: str) -> None:
        self.said = said

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if isinstance(error, Undecided):
            raise Open(self.said) from None
