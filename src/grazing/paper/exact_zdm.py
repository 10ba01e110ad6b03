"""The zero-time discontinuity map along the exact flow, and the measured orders of its approximations."""

from __future__ import annotations

from typing import Any

import numpy as np

from grazing.maps.discontinuity import ORDERS, zdm, zdm_points
from grazing.maps.normal_form import constants
from grazing.oscillator.flight import anchored, flight
from grazing.oscillator.model import Oscillator


def flown(model: Oscillator, time: float, state: tuple[float, float], span: float) -> tuple[float, float]:
    """Return the state after a span of free flight, forwards or backwards."""
    c = constants(model)
    y, v = flight(span, anchored(time, state[0] - model.sigma, state[1], c), c)
    return y + model.sigma, v


def sample(model: Oscillator, hit: float, speed: float, delta: float) -> dict[str, Any]:
    """Return the start that hits the wall after ``delta`` with v = -speed at time ``hit``, and where it is taken.

    The exact map flies forward to the wall, resets and flies back along the exact flow.
    """
    start = flown(model, hit, (model.sigma, -speed), -delta)
    rebound = -model.params["r"] * -speed + model.params["V"]
    exact = flown(model, hit, (model.sigma, rebound), -delta)
    phase = hit - delta
    return {"start": start, "exact": exact, "phase": phase}


def errors(model: Oscillator, hit: float, speed: float, deltas: Any) -> dict[str, Any]:
    """Return |error| in (U3, V3) of every order of the local map, arrays of shape (n, 2), one row per delta."""
    found: dict[str, Any] = {order: [] for order in ORDERS}
    for delta in deltas:
        # the speed falls with delta, as at a graze: v = -speed * delta, so that U0 is of second order
        each = sample(model, hit, speed * delta, delta)
        for order, rows in found.items():
            image, letter = zdm(model, order=order, phase=each["phase"])(each["start"])
            rows.append(np.abs(image - np.array(each["exact"])) if letter else (np.nan, np.nan))
    return {order: np.array(rows) for order, rows in found.items()}


def orders(model: Oscillator, hit: float, speed: float) -> dict[str, tuple[float, float]]:
    """Return the measured orders in delta of the errors in U3 and V3, by regression over two decades."""
    deltas = np.logspace(-4.0, -2.0, 9)
    return {
        order: tuple(float(np.polyfit(np.log(deltas), np.log(rows[:, i]), 1)[0]) for i in (0, 1))  # type: ignore[misc]
        for order, rows in errors(model, hit, speed, deltas).items()
    }


def substituted(model: Oscillator, start: tuple[float, float], phase: float = 0.0) -> dict[str, float]:
    """Return U3 by the expansion (2.2), as substituted in print below (2.3), and as it should read."""
    four = zdm_points(model, start, phase)
    r, V, root = model.params["r"], model.params["V"], four.x**0.5
    return {
        "expansion": float(four.points[3, 0]),
        "printed": start[0] + four.delta * ((1.0 + r) * start[1] + V),
        "right": start[0] - four.delta * (V + (1.0 + r) * root),
    }
