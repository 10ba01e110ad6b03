"""States at the strobe as pairs (c1, c2), and pairs as states."""

from __future__ import annotations

from typing import Any

from grazing.kernel.primitives import inlined
from grazing.oscillator.cells import CERTIFICATE, MARGIN, MAX_ROWS, PAIR, SIGMA, STATE, TABLED, UPRIGHT
from grazing.oscillator.workspace import FRESH, HELD, NAN, W


@inlined
def margin_of(t: Any, x: float, y: float) -> float:
    """Return the margin of a pair."""
    return t[MARGIN] + (t[MARGIN + 1] * abs(x) + t[MARGIN + 2] * abs(y))  # type: ignore[no-any-return]


def held_back(w: Any, i: int, t: Any) -> float:
    """Turn the state of orbit i into a pair as well: FRESH; return HELD where the block must not have it.

    That is a ball on the wall, or so near that the certificate cannot tell. A fresh state is what the scalar routine
    gets if it must fly the next period: the way to a pair and back would cost a rounding.
    """
    if t[TABLED] > 0.0:
        y, v = (w[W.U + i] - t[SIGMA]) - t[STATE], w[W.V + i] - t[STATE + 3]
        x, y = t[PAIR] * y + t[PAIR + 1] * v, t[PAIR + 2] * y + t[PAIR + 3] * v
        margin = margin_of(t, x, y)
        height = t[CERTIFICATE] * x + (t[CERTIFICATE + MAX_ROWS] * y + t[CERTIFICATE + 2 * MAX_ROWS])
        if height > 2.0 * margin:
            w[W.C1 + i], w[W.C2 + i], w[W.NEED + i] = x, y, margin - t[UPRIGHT] * x
            return FRESH
    w[W.C1 + i], w[W.C2 + i], w[W.NEED + i] = NAN, NAN, NAN  # fails every row of the certificate, the first one first
    return HELD


def state_of(x: float, y: float, t: Any) -> tuple[float, float]:
    """Return the state at the strobe of a pair (c1, c2)."""
    u = t[SIGMA] + (t[STATE] + (t[STATE + 1] * x + t[STATE + 2] * y))
    return u, t[STATE + 3] + (t[STATE + 4] * x + t[STATE + 5] * y)
