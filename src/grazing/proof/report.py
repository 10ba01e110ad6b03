"""What a certificate of the oscillator writes down: the model, the claims with their bounds, the inequalities."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from grazing.oscillator.model import Oscillator
from grazing.oscillator.reset import Reset, active_law, fingerprint, newton_law, triggered_law
from grazing.proof.clearance import Clear
from grazing.proof.equations import Flight, Matrix
from grazing.proof.krawczyk import contraction, remainder
from grazing.proof.text import above, below, enclosed, exact_text

if TYPE_CHECKING:
    from flint import arb

BUILT_IN = {newton_law: "newton", active_law: "active", triggered_law: "triggered"}


def described(model: Oscillator, n: int, N: int, bits: int) -> dict[str, Any]:
    """Return what every certificate of the oscillator says of its model."""
    forcing, reset = model.forcing, model.reset
    return {
        "model": {
            "alpha": model.alpha.hex(), "k": model.k.hex(), "omega": forcing.omega.hex(), "t0": forcing.t0.hex(),
            "offset": forcing.offset.hex(), "sigma": model.sigma.hex(),
            "cos": [x.hex() for x in forcing.cos], "sin": [x.hex() for x in forcing.sin],
            "offset_name": model.offset_name,
        },
        "law": law_of(reset),
        "impacts": n, "periods": N, "precision": bits,
    }  # fmt: skip


def law_of(reset: Reset) -> dict[str, Any]:
    """Return name, parameters and, for a law of the user's, the fingerprint of its code."""
    name = BUILT_IN.get(reset.law)
    code = "" if name else fingerprint(reset)
    return {
        "name": name or reset.name,
        "params": {key: float(x).hex() for key, x in reset.params.items()},
        "code": code,
    }


def jury(trace: arb, det: arb) -> dict[str, arb]:
    """Return the quantities that are all > 0 exactly if both multipliers are inside the unit circle."""
    return {"1 + trace + det": 1 + trace + det, "1 - trace + det": 1 - trace + det, "1 - det": 1 - det}


def stability_of(margins: dict[str, arb]) -> str:
    """Return stable, unstable or undecided; a negative margin means a multiplier outside the unit circle."""
    if all(x > 0 for x in margins.values()):
        return "stable"
    return "unstable" if any(x < 0 for x in margins.values()) else "undecided"


def loose(x: arb) -> list[str]:
    """Return decimals around a ball that leave room for another way of evaluating it."""
    from flint import arb

    room = 4 * x.rad() + abs(x.mid()) * arb(2) ** -50
    return enclosed(x + arb(0, 1) * room.upper())


def multiplier_text(trace: arb, det: arb) -> list[dict[str, list[str]]]:
    """Return both multipliers, largest modulus first, or none if it is not known whether they are real."""
    half, gap = trace / 2, trace**2 / 4 - det
    if gap > 0:
        root = gap.sqrt()
        large = half + root if half.mid() >= 0 else half - root
        return [{"real": loose(x), "imag": ["0", "0"]} for x in (large, det / large)]
    if gap < 0:
        root = (-gap).sqrt()
        return [{"real": loose(half), "imag": loose(x)} for x in (root, -root)]
    return []


def bound(name: str, x: arb, relation: str, limit: int | arb) -> dict[str, str]:
    """Return an inequality: a bound of x half way to the limit, so that another way of evaluating x can reach it.

    ``left`` bounds x from below for ``>``, from above for ``<``; the checker proves x > left >= right or
    x < left <= right.
    """
    from flint import arb

    middle = (x + arb(limit)) / 2
    left = below(middle, 6) if relation == ">" else above(middle, 6)
    right = str(limit) if isinstance(limit, int) else exact_text(limit)
    return {"name": name, "left": left, "relation": relation, "right": right}


def existence_rows(
    residual: list[arb], rows: Matrix, C: list[list[float]], radius: list[arb], unique: list[arb]
) -> list[dict[str, str]]:
    """Return the inequalities of Krawczyk's test."""
    image = [a + b for a, b in zip(residual, remainder(C, rows, radius), strict=True)]
    made = [
        bound(f"existence, coordinate {i + 1}", a, "<", r) for i, (a, r) in enumerate(zip(image, radius, strict=True))
    ]
    return [*made, bound("uniqueness, contraction rate", contraction(C, rows, unique), "<", 1)]


def impact_rows(flights: list[Flight], n: int) -> list[dict[str, str]]:
    """Return the inequalities of the impacts."""
    return [bound(f"velocity before impact {(i + 1) % n + 1}", f.v, "<", 0) for i, f in enumerate(flights) if n]


def clear_rows(cleared: list[Clear], n: int, flights: list[Flight]) -> list[dict[str, str]]:
    """Return the inequalities of the flights."""
    if n == 0:
        return [bound("height of the orbit", cleared[0].floor, ">", 0)]
    made = []
    for i, one in enumerate(cleared):
        first = "acceleration" if flights[i - 1].g.is_zero() else "velocity"
        made += [
            bound(f"{first} of flight {i + 1} up to its first cut", one.up, ">", 0),
            bound(f"height of flight {i + 1} between its cuts", one.floor, ">", 0),
            bound(f"velocity of flight {i + 1} after its last cut", -one.down, "<", 0),
        ]
    return made


def stability_rows(margins: dict[str, arb], stability: str) -> list[dict[str, str]]:
    """Return the inequalities of the multipliers."""
    if stability == "stable":
        return [bound(name, x, ">", 0) for name, x in margins.items()]
    return [bound(name, x, "<", 0) for name, x in margins.items() if stability == "unstable" and x < 0]
