"""Trajectories between walls, or at one that moves or is above: flights and impacts in continuous time."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.oscillator.legs import (
    END,
    FLAGS,
    HIT,
    LEG,
    MAX_IMPACTS,
    PERIOD,
    SEEN,
    START,
    V_MINUS,
    V_PLUS,
    V,
    Y,
    flown,
    flown_legs,
)
from grazing.oscillator.model import Oscillator
from grazing.oscillator.reset import newton
from grazing.oscillator.rig import Rig
from grazing.oscillator.spring import spring_of
from grazing.oscillator.walled import Walled
from grazing.outcome import AMBIGUOUS, CHATTER, Trust

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]


def above_first(model: Rig) -> Oscillator:
    """Return an oscillator that flies as a model does, above the place where its first wall is, or has its middle."""
    if not model.walled:
        return model.seen[0]
    name, value = spring_of(model)
    spring: dict[str, Any] = {name: value}
    return Oscillator(model.alpha, forcing=model.forcing, reset=newton(1.0), sigma=model.walls[0].position, **spring)


def rests_in(begins: Floats, ends: Floats, lies: NDArray[np.bool_]) -> Floats:
    """Return from when until when the ball lies, shape (rests, 2); legs end at strobes, a rest need not."""
    on = lies & (ends > begins)
    first, last = begins[on], ends[on]
    new = np.append(True, first[1:] != last[:-1])[: len(first)]
    return np.column_stack([first[new], last[np.append(new, True)[1:]]])


def walled_trajectory(
    model: Walled, state: tuple[float, float], start: float, until: float, samples: int
) -> xr.Dataset:
    """Follow the ball in continuous time; :func:`grazing.trajectory` calls this."""
    from grazing.late import xarray as xr

    model.refuse_inside(state[0], start)
    legs = flown_legs(model, state, start, until, MAX_IMPACTS)
    T, names = model.period, list(model.names)
    begins = start + legs[:, PERIOD] * T + legs[:, START]
    ends = np.where(legs[:, END] >= T, start + (legs[:, PERIOD] + 1.0) * T, start + legs[:, PERIOD] * T + legs[:, END])
    times, us, vs = [], [], []
    seen = model.seen
    for leg, begin, end in zip(legs, begins, np.minimum(ends, until), strict=True):
        if begin > end:
            continue
        length = min(end - begin, leg[END] - leg[START])
        s = np.linspace(0.0, length, max(2, ceil(samples * length / T) + 1))
        t, j = np.minimum(begin + s, end), int(leg[SEEN])
        t[-1] = end
        at, speed = model.places_at(t)
        sign, whole = model.walls[j].sign, end >= begin + leg[END] - leg[START]
        if leg[LEG]:
            u, v = at[j], speed[j]
        else:
            first, height, speed_then = np.full((3, len(s)), leg[[START, Y, V]][:, None])
            y, w = flown(seen[j], start, first, height, speed_then, s)
            y -= seen[j].sigma
            y[0], w[0] = leg[Y], leg[V]  # the ends of a flight are known better than by a formula
            u, v = at[j] + sign * y, speed[j] + sign * w
            if not np.isnan(leg[V_MINUS]) and whole:
                i = int(leg[HIT])
                u[-1], v[-1] = at[i, -1], speed[i, -1] + model.walls[i].sign * leg[V_MINUS]
            u = np.clip(u, at[0] if model.walls[0].sign > 0.0 else None, at[-1] if model.walls[-1].sign < 0.0 else None)
        times.append(t)
        us.append(u)
        vs.append(v)
    hits = ~np.isnan(legs[:, V_MINUS]) & (ends <= until)
    struck = legs[hits, HIT].astype(int)
    sign = np.array([wall.sign for wall in model.walls])[struck]
    struck_at, carried = np.array(model.places_at(ends[hits]))[:, struck, np.arange(len(struck))]
    flags = int(np.bitwise_or.reduce(legs[:, FLAGS].astype(int)))
    trust = Trust.ambiguous if flags & AMBIGUOUS else Trust.certified
    about = {name: model.describe(name).attributes for name in ("t", "u", "v", "v_minus", "v_plus")}
    t = np.concatenate(times)
    before, after = (carried + sign * legs[hits, column] for column in (V_MINUS, V_PLUS))
    return xr.Dataset(
        {
            "u": ("t", np.concatenate(us), about["u"]),
            "v": ("t", np.concatenate(vs), about["v"]),
            "impact_time": ("impact", ends[hits], about["t"] | {"long_name": "time of impact"}),
            "v_minus": ("impact", before, about["v_minus"]),
            "v_plus": ("impact", after, about["v_plus"]),
            "impact_wall": ("impact", np.array(names)[struck], {"long_name": "wall that is hit"}),
            "impact_position": (
                "impact",
                struck_at,
                {"long_name": "position of the wall that is hit", "units": model.units_of("u")},
            ),
            "impact_speed": (
                "impact",
                -legs[hits, V_MINUS],
                {"long_name": "speed of approach to the wall", "units": model.units_of("v")},
            ),
            "rest_time": (
                ("rest", "end"),
                rests_in(begins, np.minimum(ends, until), legs[:, LEG] != 0.0),
                about["t"] | {"long_name": "when the ball lies on a wall: from, until"},
            ),
            "wall_position": (
                ("wall", "t"),
                model.places_at(t)[0],
                {"long_name": "position of the wall", "units": model.units_of("u")},
            ),
            "side": ("wall", [str(wall.side) for wall in model.walls], {"long_name": "side of the ball"}),
            "trust": ((), trust.value),
        },
        coords={"t": ("t", t, about["t"]), "wall": ("wall", names)},
        attrs=said_of(model, flags),
    )


def said_of(model: Rig, flags: int) -> dict[str, Any]:
    """Return what the trajectory of a model says of it, and of what happened."""
    return {
        "title": f"trajectory of {model!r}",
        "grazing_outcome": flags,
        "chatter": int(bool(flags & CHATTER)),
        **model.attributes,
        **{f"parameter_{name}": value for name, value in model.params.items()},
    }
