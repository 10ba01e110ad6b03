"""The grazing curve: the states at the strobe whose orbits touch the wall within a period, and its preimages.

There the stroboscopic map jumps, or its slope does: basins end at these curves. A touch is a state in closed form, at
rest on the wall; everything else follows from going back from there, see :mod:`grazing.orbits.touches`.
"""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.memory import refuse_too_large
from grazing.orbits.touches import MAX_IMPACTS, PATIENCE, SPACING, TOLERANCE, Ruler, ordered, pieces, proven, refined
from grazing.oscillator.model import Oscillator, checked_model, checked_phase
from grazing.oscillator.trajectory import refuse_swings
from grazing.parameter import checked_box, whole

if TYPE_CHECKING:
    import xarray as xr

#: Bytes that a contact time takes while its curve is refined.
CONTACT = 200
#: Highest order of preimages: each is followed through all periods, so that time grows with the square of the order.
MOST_PREIMAGES = 100
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def drawn(model: Oscillator, phase: float, preimages: int, points: int, box: Any) -> tuple[Floats, Ints, Floats, bool]:
    """Return points (u, v), orders and contact times, with rows of NaN between pieces, and whether time ran out."""
    up = np.array([model.sigma, 0.0])
    size = np.array([model.reach.height, model.reach.speed])
    natural = np.array([[0.0, size[0]], [-size[1], size[1]]])
    wanted = natural if box is None else np.array(box) - up[:, None]
    ruler = Ruler([natural] if box is None else [natural, wanted])
    leaves, spots = refined(model, phase, preimages, points, ruler)
    leaves, _place, joined = ordered(leaves, spots)
    inside = Ruler([wanted]).away(leaves.state) <= 1.0
    keep = inside.copy()  # a curve is drawn beyond the edge of the box by one point
    keep[:-1] |= inside[1:] & joined
    keep[1:] |= inside[:-1] & joined
    keep[keep] = proven(model, phase, leaves.at(keep), size)
    found, piece = pieces(leaves, spots, keep, ruler, SPACING / points)
    breaks = np.flatnonzero(np.diff(piece)) + 1
    state = np.insert(found.state + up, breaks, np.nan, axis=0)
    times = np.insert(model.period - found.back, breaks, np.nan)
    cut_short = len(spots) >= PATIENCE * points
    return state, np.insert(found.order, breaks, found.order[breaks]), times, cut_short


def grazing_arrays(
    model: Oscillator, phase: float = 0.0, preimages: int = 0, points: int = 2000, box: Any = None
) -> tuple[Floats, Ints]:
    """Return the grazing curve and its preimages as plain arrays, for studies that draw it under their own names.

    Parameters
    ----------
    model, phase, preimages, points, box
        As for :func:`grazing_curve`.

    Returns
    -------
    points : ndarray, shape (n, 2)
        States (u, v); a row of NaN between separate pieces.
    order : ndarray of int, shape (n,)
        Of the preimage; at a row of NaN that of the piece that follows.
    """
    state, order, _times, _cut_short = drawn(*_checked(model, phase, preimages, points, box))
    return state, order


def grazing_curve(
    model: Oscillator, phase: float = 0.0, *, preimages: int = 0, points: int = 2000, box: Any = None
) -> xr.Dataset:
    """Return the grazing curve of the stroboscopic map in its section, and its preimages.

    Parameters
    ----------
    model : Oscillator
        Any damping, stiffness, forcing, wall and reset law.
    phase : float
        Time of the section, from t = 0.
    preimages : int
        The highest order: a preimage of order k touches the wall k periods later, 0 to 100.
    points : int
        Contact times tried first in each period, >= 10; more are added until neighbouring points on a curve are less
        than 6/points of the box apart, and ends are found.
    box : ((u_low, u_high), (v_low, v_high)), optional
        What is drawn. Default: as high above the wall and as fast as orbits go, by the estimate that random starts are
        drawn from (``model.reach``).

    Returns
    -------
    xarray.Dataset
        ``graze`` (graze_point, coordinate): states (u, v), pieces one after the other with a row of NaN between;
        ``order`` (graze_point): 0 for the curve itself; ``contact_time`` (graze_point): time of the touch after the
        strobe of order 0, in (0, T]. The attribute ``cut_short`` is 1 where the search was ended before all was smooth:
        more ``points`` or a larger box draw more.

    Raises
    ------
    InputError
        For a model that is none, numbers that are not allowed, or a period with too many swings of the free ball.

    Notes
    -----
    A state of order 0 touches the wall with zero speed, lifted by the force, at some time in (0, T], after any number
    of impacts in that period. The touch is in closed form; from there the flight is followed backwards, contact by
    contact, each found as a single simple root in a bracket, and through the inverse of the reset law. There is none
    for a kick larger than the speed of departure, and there may be two for a trigger. A dead wall (r = 0) forgets the
    speed of impact, so that touches after one are left out. Every point drawn is then
    followed forwards by the exact routine: a preimage of order k must come back to its point on the curve to k 1e-6
    (relative), and that must have its impacts and touch the wall to 1e-9. What does not is left out.

    What can be missed: pieces that begin and end between two contact times tried, touches after more than 20 impacts
    in one period or a hop of less than 1e-3 of it (they pile up where chatter ends), what is left when 60 ``points``
    contact times have been tried, and, at the fourth preimage or so of a strongly damped ball, pieces narrower than the
    distance of neighbouring numbers.

    Examples
    --------
    >>> import grazing as gz
    >>> m = gz.pinball(d=0.12, V=0.4)
    >>> curve = gz.grazing_curve(m, preimages=1)
    >>> u, v = curve.graze[200].values
    >>> P = gz.stroboscopic_map(m)
    >>> P((u - 1e-9, v))[1], P((u + 1e-9, v))[1]
    (1, 0)
    """
    args = _checked(model, phase, preimages, points, box)
    state, order, times, cut_short = drawn(*args)
    model, phase, preimages, points, box = args
    config = {
        "model": repr(model),
        "params": {**model.params, "phase": phase},
        "preimages": preimages,
        "points": points,
        "box": box,
        "tolerance": TOLERANCE,
        "impacts": MAX_IMPACTS,
        "arithmetic": "strict",
    }

    from grazing.late import xarray as xr

    variables = {
        "graze": (
            ("graze_point", "coordinate"),
            state,
            {
                "long_name": "states that touch the wall within a period, and their preimages",
                "units": model.units_of(("u", "v")),
            },
        ),
        "order": ("graze_point", order.astype(np.int32), {"long_name": "order of the preimage", "units": "1"}),
        "contact_time": (
            "graze_point",
            times,
            model.describe("t").attributes | {"long_name": "time of the touch after the strobe of order 0"},
        ),
    }
    text = json.dumps(config, sort_keys=True, separators=(",", ":"), allow_nan=False)
    attributes = {
        "title": "grazing curve of the stroboscopic map and its preimages",
        "model": repr(model),
        "parameters": json.dumps(config["params"]),
        "grazing_config": text,
        "grazing_config_sha256": hashlib.sha256(text.encode()).hexdigest(),
        "arithmetic": "strict",
        "cut_short": int(cut_short),
        **model.attributes,
    }
    return xr.Dataset(variables, {"coordinate": ["u", "v"]}, attributes)


def _checked(model: Any, phase: Any, preimages: Any, points: Any, box: Any) -> tuple[Oscillator, float, int, int, Any]:
    """Return the arguments checked, or raise InputError."""
    checked_model(model)
    time = checked_phase(model, phase)
    orders, number = whole(preimages, "preimages", 0, MOST_PREIMAGES), whole(points, "points", 10)
    size = CONTACT * PATIENCE * float(number)
    refuse_too_large(size, f"reduce points ({number})", "the curve")
    refuse_swings(model)
    return model, time, orders, number, None if box is None else checked_box(box, ("u", "v"))
