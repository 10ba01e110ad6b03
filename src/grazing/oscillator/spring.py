"""The spring of a model: a natural frequency, or a stiffness of either sign."""

from __future__ import annotations

from typing import Any

from grazing.oscillator.reach import natural
from grazing.outcome import InputError, OutsideForm


def spring_of(model: Any) -> tuple[str, float]:
    """Return the name and the value of the second parameter, k or the stiffness, of which one is given."""
    if (model.k is None) == (model.stiffness is None):
        raise InputError("give k, the natural frequency, or stiffness, which is k^2 or negative: one of the two")
    return ("k", model.k) if model.stiffness is None else ("stiffness", model.stiffness)


def frequency_of(model: Any) -> float:
    """Return the natural frequency, 0 where the spring holds nothing back."""
    return float(model.k) if model.stiffness is None else natural(model.stiffness)


def refuse_stiffness(model: Any, what: str) -> None:
    """Raise OutsideForm for a model with a negative damping, or with a stiffness in place of k."""
    if model.stiffness is not None or model.alpha < 0.0:
        has = f"alpha = {model.alpha:g}" if model.stiffness is None else "a stiffness in place of k"
        raise OutsideForm(
            f"{what} is for oscillators with alpha >= 0 and a natural frequency k, not for one with {has}. Others have "
            "trajectories, stroboscopic and impact maps and their studies, gz.periodic_orbits and gz.continuation"
        )
