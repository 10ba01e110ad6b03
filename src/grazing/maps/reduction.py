"""The numbers of the normal form as kernels: the graze of the steady response, and λ, μ and l there."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from grazing.kernel.elementary import length
from grazing.kernel.primitives import replaced
from grazing.oscillator.constants import Constants, forcing, steady_response
from grazing.oscillator.flight import modes
from grazing.oscillator.windows import window_edges

NAN = float("nan")
#: The search for a graze goes outwards in steps that grow so, from so small a share of the parameter.
GROWTH, FIRST_STEP = 1.3, 1e-3


class Reduced(NamedTuple):
    """What the reduction at a graze gives; :class:`grazing.maps.normal_form.NormalForm` says what it means."""

    time: float
    acceleration: float
    lam: float
    l: float
    b: float
    det: float
    scale: float
    r: float
    V: float
    a: float
    e21: float
    d: float


def has_steady_response(c: Constants) -> bool:
    """Say whether a steady response attracts: there is damping, and no constant force without a spring."""
    return c.alpha != 0.0 and not (c.k2 == 0.0 and c.F0 != 0.0)


def steady_low(c: Constants) -> tuple[float, float]:
    """Return (time in [0, T), height above the wall) of the lowest point of the steady response."""
    # zeros of Y': the derivative is a series of its own
    cos, sin, bend = c.hc, c.hs, 0.0
    for j in range(len(c.hc)):
        W = (j + 1) * c.omega
        cos, sin = replaced(cos, j, W * c.hs[j]), replaced(sin, j, -W * c.hc[j])
        bend += W * W * W * length(c.hc[j], c.hs[j])
    none = c.edges
    for i in range(len(none)):
        none = replaced(none, i, 0.0)
    edges, _first, _doubtful = window_edges(0.0, cos, sin, c.omega, c.theta, c.T, bend, none)
    time, height = NAN, NAN
    for i in range(len(edges)):
        if edges[i] < c.T:
            here = steady_response(edges[i], c)[0]
            if not here >= height:
                time, height = edges[i], here
    return time, height


@lru_cache(maxsize=64)
def reduction_of(law: Callable[..., float], slope: Callable[..., float]) -> Callable[..., Reduced]:
    """Return ``reduce(c) -> Reduced`` for one reset law, c being the constants at the graze."""

    def reduce(c: Any) -> Any:
        time, _height = steady_low(c)
        A = forcing(time, c)[0] - c.alpha * steady_response(time, c)[1]
        a, b, e21, d = modes(c.T, c)
        r, V = -slope(0.0, c.p), law(0.0, c.p)
        stretch = 1.0 + r
        bottom = 2.0 * A * b * stretch * stretch
        l = V / bottom if bottom != 0.0 else NAN
        root = 2.0 * A * b * stretch
        return Reduced(time, A, a + d, l, b, a * d - b * e21, root * root, r, V, a, e21, d)

    return reduce


def mu_factor(lam: float, det: float, acceleration: float, b: float, r: float) -> float:
    """Return μ per height of the steady response's lowest point."""
    stretch = 1.0 + r
    return -(1.0 - lam + det) / (2.0 * acceleration * b * b * stretch * stretch)


def graze_search_of(height: Callable[..., float]) -> Callable[..., float]:
    """Return ``search(context, now, low, high, open_low, unit)``: the graze nearest to ``now``, in growing steps.

    Parameters
    ----------
    height : callable
        ``height(value, context)``: that of the steady response's lowest point above the wall; not a number where there
        is none.

    Returns
    -------
    callable
        The value at which the height is 0, to the last digit; not a number if none is found up to 1000 times ``now``,
        or ``unit``, what the parameter is measured in where it is 0. ``low`` and ``high`` are the ends of its range,
        ``open_low`` whether the lower one is excluded.
    """

    def between(context: Any, low: float, high: float, at_low: float) -> float:
        """Bisect: the height has the sign of ``at_low`` at one end and the other sign at the other."""
        while True:
            middle = 0.5 * (low + high)
            if middle == low or middle == high:
                return middle
            here = height(middle, context)
            if here == 0.0:
                return middle
            if (here > 0.0) == (at_low > 0.0):
                low = middle
            else:
                high = middle

    def search(context: Any, now: float, low: float, high: float, open_low: bool, unit: float) -> float:
        here = height(now, context)
        if here == 0.0:
            return now
        below, above = now, now
        width = FIRST_STEP * max(abs(now), 1e-2 * unit)
        while below > low or above < high:
            for upwards in range(2):
                last = above if upwards == 1 else below
                edge = min(high, now + width) if upwards == 1 else max(low, now - width)
                if edge == last or (edge == low and open_low):
                    continue
                there = height(edge, context)
                if there != there:
                    continue
                if (there > 0.0) != (here > 0.0):
                    return between(context, last, edge, here) if upwards == 1 else between(context, edge, last, there)
                if upwards == 1:
                    above = edge
                else:
                    below = edge
            if width > 2e3 * max(unit, abs(now)):
                return NAN
            width *= GROWTH
        return NAN

    return search
