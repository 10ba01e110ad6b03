r"""Orders of convergence: how fast the error of each reduction falls as its windows approach the graze.

Let D be the distance of a window's edge from the graze; lengths and speeds below are in the units of (2.6), where
D ~ mu. As N grows, D falls like lambda^N for V > 0 and like lambda^(2N) for V = 0. At a border collision the speed of
the impact is s = mu^(1/2); at a period doubling s = lambda^(N-1)/2, so s ~ mu for V > 0 and s ~ mu^(1/2) for V = 0.
With kappa = s + l the kick, the orbit closes where K mu = s^2 + c kappa, c ~ lambda^(N-1): what a step of the ladder
changes in s^2 counts as it is, what it changes in kappa counts times c, and c ~ D for V > 0, c ~ D^(1/2) for V = 0.

flow, corrected
    The quadratic flight misses the jerk J of the steady response at its lowest point: the speed of impact, J s^2, and
    V times the square of the time to the wall, V s^2: D s^2. So order 2 at a border collision and 3 at a period
    doubling for V > 0. For V = 0 the terms are J s^2 and s^3: order 3/2, and 2 where J = 0, as for one harmonic.
corrected, full; full, lowest
    The acceleration after the impact differs by -alpha (kappa), and *lowest* leaves the position as it is: each
    changes the kick by kappa s. For V > 0 this is D s: order 3/2 at a border collision, 2 at a period doubling; for
    V = 0 it is D^(1/2) s^2: 3/2. The two steps have opposite signs: *full* may be farther away than *lowest*.
lowest, linearised
    v^2 is dropped, with v ~ mu at the section, and all coefficients are those at the graze: order 2, with a factor N
    where the parameter changes the rate of decay (alpha, k, omega).
linearised, gap
    Dropping y replaces the rate of decay, the eigenvalue nearest lambda - det/lambda, by lambda: a *relative* error of
    N det/lambda^2 that does not fall. So order 1, with a factor N; before it shows, the dropped lambda x of order 2
    (period doubling, V > 0) or 3/2 is seen.

All this is for real and different eigenvalues of the period without impact, lambda^2 > 4 det: else the free flight
oscillates, windows of large N end in folds on this side of the graze or beyond it, and no order is expected. Where a
step has a factor N its order is fitted to step/N. The order of an error is the least one of the steps from its rung up
to the flow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grazing.studies.boundary import line_through

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: To how many of the largest N an order is fitted.
LAST = 4
#: What is measured, and what it is.
NAMES = {
    "order": "exponent of the error in the distance from the graze",
    "order_error": "uncertainty of that exponent",
    "step_order": "exponent of the step to the next rung",
    "step_order_error": "uncertainty of that exponent",
    "expected": "exponent of the error in theory",
    "expected_step": "exponent of the step in theory",
}
#: Parameters that change the rate of decay over a period.
DECAY = ("alpha", "k", "omega")
#: Errors below this share of the value are rounding.
ROUNDING = 1e-14


def expected(rung: str, kind: str, gap: bool, jerk: bool) -> float:
    """Return the order in theory of the step from a rung to the next, NaN where there is none.

    Parameters
    ----------
    rung : str
        The lower rung.
    kind : {"gr", "pd"}
        The type of the edge.
    gap : bool
        Whether V > 0.
    jerk : bool
        Whether the steady response has a third derivative at the graze.

    Examples
    --------
    >>> from grazing.compare.orders import expected
    >>> expected("full", "pd", gap=True, jerk=False), expected("full", "pd", gap=False, jerk=False)
    (2.0, 1.5)
    """
    if kind not in ("gr", "pd"):
        return np.nan
    middle = 2.0 if gap and kind == "pd" else 1.5
    last = (3.0 if kind == "pd" else 2.0) if gap else (1.5 if jerk else 2.0)
    return {"gap": 1.0, "linearised": 2.0, "lowest": middle, "full": middle, "corrected": last}.get(rung, np.nan)


def fitted(distance: Floats, error: Floats) -> tuple[float, float]:
    """Return the exponent q of error ~ distance^q by least squares in logarithms, and its uncertainty.

    The uncertainty is the larger one of the standard error and the spread of the slopes between neighbouring points,
    which tells a drift: what is measured is not yet the limit.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.compare.orders import fitted
    >>> D = 0.3 ** np.arange(5)
    >>> q, uncertainty = fitted(D, 7.0 * D**1.5)
    >>> round(q, 12), uncertainty < 1e-12
    (1.5, True)
    """
    x, y = np.log(distance), np.log(error)
    slope, scatter = line_through(x, y)
    return slope, max(scatter, float(np.ptp(np.diff(y) / np.diff(x))))


def with_orders(result: xr.Dataset, jerk: bool, decays: bool, last: int) -> xr.Dataset:
    """Return the result of a ladder with the measured orders of its errors and steps, and the expected ones.

    Edges count that have the same type on both rungs, the most frequent one of the flow's.
    """
    rungs, periods = result["rung"].values.tolist(), result["N"].values.astype(np.float64)
    table = {name: np.full((len(rungs), result.sizes["side"]), np.nan) for name in NAMES}
    edge, types = result["edge"].values, result["type"].values
    for side in range(result.sizes["side"]):
        kinds, often = np.unique(types[-1, np.isfinite(edge[-1, :, side]), side], return_counts=True)
        if not kinds.size:
            continue
        kind, distance = str(kinds[np.argmax(often)]), result["distance"].values[:, side]
        alike = (types[..., side] == kind) & np.isfinite(edge[..., side])
        steps = [expected(rung, kind, result.attrs["l"] != 0.0, jerk) if decays else np.nan for rung in rungs[:-1]]
        for i, rung in enumerate(rungs[:-1]):
            table["expected"][i, side], table["expected_step"][i, side] = min(steps[i:]), steps[i]
            for name, of in (("order", "error"), ("step_order", "step")):
                above = (
                    _next(np.isfinite(edge[..., side]), i) if of == "step" else np.full(len(periods), len(rungs) - 1)
                )
                size = np.abs(result[of].values[i, :, side])
                good = alike[i] & alike[above, np.arange(len(periods))] & alike[-1] & (distance > 0.0)
                good &= size > ROUNDING * np.maximum(np.abs(edge[-1, :, side]), distance)
                used = np.flatnonzero(good)[-last:]
                # a rate of decay that is wrong by a little is so N times over
                rate = rung == "linearised" and result.attrs["parameter"] in DECAY
                many = rung == "gap" or (rate and (of == "step" or steps[i] <= min(steps[i:])))
                if len(used) >= 3:
                    found = fitted(distance[used], size[used] / (periods[used] if many else 1.0))
                    table[name][i, side], table[name + "_error"][i, side] = found
    return result.assign(
        {name: (("rung", "side"), table[name], {"long_name": text, "units": "1"}) for name, text in NAMES.items()}
    )


def _next(there: NDArray[np.bool_], i: int) -> NDArray[np.int64]:
    """Return, for each N, the number of the next rung that has an edge."""
    many = len(there)
    return np.array([next((j for j in range(i + 1, many) if there[j, n]), many - 1) for n in range(there.shape[1])])
