"""Which words an orbit can have at all: what is impossible is refused before anything is searched."""

from __future__ import annotations

from math import ceil, inf

import numpy as np

from grazing.maps.hits import Struck
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER, Map
from grazing.orbits.free_equations import FreeEquations
from grazing.oscillator.forcing import Forcing
from grazing.oscillator.model import Oscillator
from grazing.oscillator.reset import active_law, contraction_at, newton
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import InputError, shown
from grazing.parameter import parameters


def refuse_impossible(P: Map, text: str, letters: tuple[int, ...]) -> None:
    """Raise InputError for a word that no orbit of a section of an oscillator can have."""
    if P.model is not None and P.section == "strobe":
        _check_rests(P.model, text, letters)
        _check_counts(P.model, text, letters)
    elif P.section == "impact" and isinstance(P.letters, Struck):
        if not any(map(P.letters.strobes, letters)):
            raise InputError(
                f"no orbit of the impact map has word {shown(text)}: it passes no strobe, and an orbit takes a period "
                f"at least; write the strobes in front of the wall that is hit then, such as 1{P.letters.names[0]}"
            )
    elif P.section == "impact" and (min(letters) < 0 or sum(letters) == 0):
        raise InputError(
            f"no orbit of the impact map has word {shown(text)}: its letters count the strobes from one "
            f"impact to the next, so none is C or S, and at least one is positive"
        )


def _check_rests(model: Oscillator, text: str, letters: tuple[int, ...]) -> None:
    """Raise InputError for a rest that the law, or the letter before it, does not allow."""
    if min(letters) >= 0:
        return
    law = model.reset
    kick = law(0.0)
    if kick > 0.0:
        raise InputError(
            f"no orbit has word {shown(text)}: with {shown(law)} a ball that touches the wall leaves it at "
            f"{kick:g}, so it never rests; C and S need a law that gives 0 for no speed (V = 0)"
        )
    ratio, speed = contraction_at(law, parameters(law.params))
    if CHATTER_LETTER in letters and not (0.0 < ratio < 1.0 and speed > 0.0):
        raise InputError(
            f"no orbit has word {shown(text)}: {shown(law)} is not known to contract slow impacts, so no "
            f"chatter is completed; C needs 0 < r < 1, or a law that declares its contraction"
        )
    for before, now in zip((letters[-1], *letters[:-1]), letters, strict=True):
        if now == STUCK_LETTER and before == 0:
            raise InputError(
                f"no orbit has word {shown(text)}: a ball that rests throughout a period (S) has come to "
                f"rest before it, so the letter before S is S, C or a period with impacts, not 0"
            )


def _check_counts(model: Oscillator, text: str, letters: tuple[int, ...]) -> None:
    """Raise InputError for more impacts in a period than there is time for."""
    most = most_impacts(model)
    if max(letters) > most:
        raise InputError(
            f"no orbit has word {shown(text)}: with {shown(model.reset)} a ball leaves the wall at V = "
            f"{model.params['V']:g} or "
            f"more and needs {model.period / (most - 1):.3g} or more to come back, so one period holds at most "
            f"{most:g} impacts"
        )


def most_impacts(model: Oscillator) -> float:
    """Return a bound on the impacts in one period; infinite where a ball may leave the wall as slowly as it likes.

    While it is above the wall a ball is not below one that leaves with V under the constant force -max|F|, by
    comparison; so no flight is shorter than the first flight of that one.
    """
    V = model.params["V"] if model.reset.law is active_law else 0.0
    if V == 0.0:
        return inf
    c = FreeEquations(model, ()).constants(np.empty(0))
    pressed = Oscillator(
        model.alpha, model.k, Forcing(model.forcing.omega, 0.0, -c.force, (0.0,)), newton(0.0),
        stiffness=model.stiffness,
    )  # fmt: skip
    path = trajectory(pressed, (0.0, V), until=c.T, samples=2)
    if len(path.impact_time) == 0:
        return 1.0 + 1.0
    return float(ceil(c.T / float(path.impact_time[0]))) + 1.0
