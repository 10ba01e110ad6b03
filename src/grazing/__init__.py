"""grazing: the dynamics of oscillators that hit things.

Models are forced oscillators with an impact law; seen at a section they are maps; every study takes a map.
Importing this package imports none of numba, scipy, xarray or matplotlib: each name below is loaded when used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# name -> module that defines it; a module's own name stands for itself
_PUBLIC = {
    "GrazingError": "outcome",
    "InputError": "outcome",
    "Outcome": "outcome",
    "OutsideForm": "outcome",
    "Trust": "outcome",
    "UserCodeError": "outcome",
    "describe": "outcome",
    "Map": "maps.map",
    "gap_map": "maps.gap",
    "discontinuity_map": "maps.discontinuity",
    "zdm": "maps.discontinuity",
    "zdm_points": "maps.discontinuity",
    "normal_form": "maps.normal_form",
    "impact_map": "maps.impact",
    "stroboscopic_map": "maps.stroboscopic",
    "Forcing": "oscillator.model",
    "Oscillator": "oscillator.model",
    "pinball": "oscillator.model",
    "trajectory": "oscillator.trajectory",
    "active": "oscillator.reset",
    "newton": "oscillator.reset",
    "reset": "oscillator.reset",
    "triggered": "oscillator.reset",
    "testing": "testing",
    "theory": "theory",
}

__all__ = sorted([*_PUBLIC, "__version__"])

if TYPE_CHECKING:
    from grazing import theory as theory
    from grazing.maps.gap import gap_map as gap_map
    from grazing.maps.map import Map as Map
    from grazing.outcome import GrazingError as GrazingError
    from grazing.outcome import InputError as InputError
    from grazing.outcome import Outcome as Outcome
    from grazing.outcome import OutsideForm as OutsideForm
    from grazing.outcome import Trust as Trust
    from grazing.outcome import UserCodeError as UserCodeError
    from grazing.outcome import describe as describe


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'grazing' has no attribute {name!r}")
    module = import_module(f"grazing.{_PUBLIC[name]}")
    value = module if _PUBLIC[name] == name else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
