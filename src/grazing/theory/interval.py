"""An interval of the real line, such as the window of a periodic orbit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["Interval"]


@dataclass(frozen=True)
class Interval:
    """An interval from `low` to `high`, open at both ends unless said otherwise.

    Parameters
    ----------
    low, high : float
        The two ends; `high` may be infinite. Ends in the wrong order are kept and make the interval empty.
    closed : bool, optional
        Whether both ends belong to the interval.

    Examples
    --------
    >>> from grazing.theory import Interval
    >>> window = Interval(0.25, 0.5)
    >>> 0.3 in window, 0.25 in window, window.width, window.empty
    (True, False, 0.25, False)
    >>> low, high = window
    """

    low: float
    high: float
    closed: bool = False

    @property
    def empty(self) -> bool:
        """Whether no number lies in the interval."""
        return not (self.low <= self.high if self.closed else self.low < self.high)

    @property
    def width(self) -> float:
        """Length of the interval, 0 when it is empty."""
        return 0.0 if self.empty else self.high - self.low

    def __contains__(self, value: float) -> bool:
        """Tell whether `value` lies in the interval."""
        if self.closed:
            return self.low <= value <= self.high
        return self.low < value < self.high

    def __iter__(self) -> Iterator[float]:
        """Yield the two ends, so that ``low, high = interval``."""
        yield self.low
        yield self.high
