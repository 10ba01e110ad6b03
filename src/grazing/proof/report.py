"""What a certificate of the oscillator writes down: the model, the claims with their bounds, the inequalities."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from grazing.oscillator.forcing import amplitudes_in
from grazing.oscillator.spring import spring_of
from grazing.proof.clearance import Cleared
from grazing.proof.equations import Equations, Flight, Matrix
from grazing.proof.krawczyk import contraction, remainder
from grazing.proof.law import law_of
from grazing.proof.seen import Seen, alone
from grazing.proof.text import above, below, enclosed, exact_text
from grazing_checker.oscillator import Problem

if TYPE_CHECKING:
    from flint import arb


def described(equations: Equations, bits: int) -> dict[str, Any]:
    """Return what every certificate of the oscillator says of its model; the unknown parameter has no value."""
    model, name = equations.model, equations.name
    text = {key: None if key == name else float(x).hex() for key, x in model.params.items()}
    said: dict[str, Any] = {"periods": equations.N, "precision": bits}
    if not alone(model):
        found = _walled(equations, text)
        return {**found, **said} if name is None else {**found, **said, "parameter": _unknown(equations, name)}
    known: dict[str, Any] = {key: text[key] for key in ("alpha", "k", "omega", "t0")}
    known |= {"offset": text[model.offset_name], "sigma": text["sigma"], "offset_name": model.offset_name}
    known |= _waves(text)
    own = {key: text[key] for key in model.walls[0].law.params}
    said |= {"model": known, "law": law_of(own, equations.trees[0]), "impacts": equations.n}
    if name is None:
        return said
    of, name = "law" if name in own else "model", "offset" if name == model.offset_name else name
    return {**said, "parameter": {"of": of, "name": name}}


def _walled(equations: Equations, text: dict[str, str | None]) -> dict[str, Any]:
    """Return what a certificate says of a model with walls of its own, and at which of them impacts are."""
    model = equations.model
    spring, seen = spring_of(model)[0], Seen(model)
    known: dict[str, Any] = {key: text[key] for key in ("alpha", spring, "omega", "t0")}
    known |= {"offset": text[model.offset_name], **_waves(text)}
    walls = []
    for j, wall in enumerate(seen.walls):
        front, own = seen.place_of(j)
        law = law_of({key: text[f"{front}{key}"] for key in wall.law.params}, equations.trees[j])
        place = {"sigma": text[f"{front}sigma"], **_waves(text, own)}
        walls.append({"name": wall.name, "side": wall.side, **place, "law": law})
    return {"model": known, "walls": walls, "impacts": [walls[hit]["name"] for hit in equations.hits]}


def _unknown(equations: Equations, name: str) -> dict[str, str]:
    """Return the group and the name of the unknown parameter among those of a model with walls of its own."""
    seen, model = Seen(equations.model), equations.model
    for j, wall in enumerate(seen.walls):
        front, own = seen.place_of(j)
        if name in {f"{front}{key}" for key in wall.law.params}:
            return {"of": f"law of {wall.name}", "name": name.removeprefix(front)}
        if name == f"{front}sigma" or name.startswith(own):
            return {"of": str(wall.name), "name": name.removeprefix(own).removeprefix(front)}
    return {"of": "model", "name": "offset" if name == model.offset_name else name}


def _waves(text: dict[str, str | None], front: str = "") -> dict[str, list[str | None]]:
    """Return the amplitudes of the force, or of the motion whose names have something in front."""
    return dict(zip(("cos", "sin"), amplitudes_in(text, front), strict=True))


def jury(trace: arb, det: arb) -> dict[str, arb]:
    """Return the quantities that are all > 0 exactly if both multipliers are inside the unit circle."""
    return {"1 + trace + det": 1 + trace + det, "1 - trace + det": 1 - trace + det, "1 - det": 1 - det}


def stability_of(margins: dict[str, arb], model: dict[str, Any], box: list[arb]) -> str:
    """Return stable, unstable or undecided; a negative margin means a multiplier outside the unit circle.

    Where an impact leaves with w = 0, an orbit is stable only if the law, too, lets slow impacts be slow.
    """
    if all(x > 0 for x in margins.values()):
        unknown = model.get("parameter")
        problem = Problem(model, unknown and (unknown["of"], unknown["name"]))
        return "stable" if problem.followed(box) else "undecided"
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


def clear_rows(cleared: list[Cleared], equations: Equations, flights: list[Flight]) -> list[dict[str, str]]:
    """Return the inequalities of the flights."""
    made, names = [], [str(wall.name) for wall in equations.model.walls]
    for i, one in enumerate(cleared):
        flight = f"flight {i + 1}" if equations.n else "the orbit"
        if alone(equations.model):
            heights = [f"height of {flight}{' between its cuts' if equations.n else ''}"]
        else:
            heights = [f"distance of {flight} from wall {name}" for name in names]
        rows = [bound(name, floor, ">", 0) for name, floor in zip(heights, one.floors, strict=True)]
        if equations.n:
            first = "acceleration" if flights[i - 1].g.is_zero() else "velocity"
            rows.insert(0, bound(f"{first} of {flight} up to its first cut", one.up, ">", 0))
            rows.append(bound(f"velocity of {flight} after its last cut", -one.down, "<", 0))
        made += rows
    return made


def stability_rows(margins: dict[str, arb], stability: str) -> list[dict[str, str]]:
    """Return the inequalities of the multipliers."""
    if stability == "stable":
        return [bound(name, x, ">", 0) for name, x in margins.items()]
    return [bound(name, x, "<", 0) for name, x in margins.items() if stability == "unstable" and x < 0]
