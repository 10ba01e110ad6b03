"""Check the certificate of a periodic orbit of the oscillator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grazing_checker.balls import Ball, number, precision
from grazing_checker.oscillator import (
    Leg,
    Problem,
    applied,
    box_of,
    check_flights,
    margins,
    precision_of,
    preconditioner,
    spread,
)
from grazing_checker.reading import Inequalities, decimal, demand, keys, numbers, within
from grazing_checker.sentence import active_harmonics, orbit_sentence

KEYS = (
    "model", "law", "impacts", "periods", "precision", "centre", "radius", "unique", "preconditioner", "cuts", "claims"
)  # fmt: skip
CLAIMS = ("box", "apart", "least_period", "incoming", "trace", "det", "multipliers", "stability")


def check_orbit(data: Mapping[str, Any], inequalities: list[Any]) -> str:
    """Verify a certificate of a periodic orbit and return the sentence that it proves, or raise Rejected."""
    keys(data, KEYS, "the data")
    keys(data["claims"], CLAIMS, "the claims")
    with precision(precision_of(data)):
        problem = Problem(data)
        rows = Inequalities(inequalities)
        box = _existence(problem, data, rows)
        legs = problem.legs(box)
        check_flights(problem, box, legs, data["cuts"], rows)
        _stability(problem, box, legs, data["claims"], rows)
        _least_period(problem, box, data, rows)
        rows.finish()
        if problem.n:
            _incoming(legs, data["claims"])
        else:
            demand(data["claims"]["incoming"] == [], "an orbit without impacts has no incoming velocities")
    return orbit_sentence(data)


def _existence(problem: Problem, data: Mapping[str, Any], rows: Inequalities) -> list[Ball]:
    """Verify that the box holds exactly one orbit and return it."""
    size = problem.size
    centre, r, u = (numbers(data[name], size, name) for name in ("centre", "radius", "unique"))
    demand(all(a > 0 and b > a for a, b in zip(r, u, strict=True)), "the boxes are not one inside the other")
    C = preconditioner(data["preconditioner"], size)
    wide = box_of(centre, u)
    D = problem.derivative(wide, problem.wide_legs(centre, wide))
    moved = applied(C, problem.defect(centre, problem.legs(centre)))
    image = [a + b for a, b in zip(moved, spread(C, D, r), strict=True)]
    for i, x in enumerate(image):
        rows.less(f"existence, coordinate {i + 1}", x, data["radius"][i])
    limit = rows.left("uniqueness, contraction rate", "<", "1")
    demand(all(a < limit * b for a, b in zip(spread(C, D, u), u, strict=True)), "uniqueness is not proven")
    box = box_of(centre, r)
    claims = data["claims"]
    demand(isinstance(claims["box"], list) and len(claims["box"]) == size, "the box claimed has the wrong size")
    for i, x in enumerate(box):
        within(x, claims["box"][i], f"coordinate {i + 1}")
    demand(isinstance(claims["apart"], list) and len(claims["apart"]) == size, "the distances claimed are not complete")
    for text, a, b in zip(claims["apart"], r, u, strict=True):
        apart, gap = decimal(text), b - a
        demand(apart <= gap, "the orbit is not proven to be alone within the distances claimed")
        demand(apart >= gap * 63 / 64, "the distances claimed do not fit the box of uniqueness")
    return box


def _incoming(legs: list[Leg], claims: Mapping[str, Any]) -> None:
    found = claims["incoming"]
    demand(isinstance(found, list) and len(found) == len(legs), "the incoming velocities are not complete")
    for i, leg in enumerate(legs):
        within(leg.v, found[i], f"incoming velocity {i + 1}")


def _stability(
    problem: Problem, box: list[Ball], legs: list[Leg], claims: Mapping[str, Any], rows: Inequalities
) -> None:
    """Verify trace, determinant, multipliers and what is claimed of the stability."""
    trace, det = problem.trace_and_det(box, legs)
    within(trace, claims["trace"], "the trace")
    within(det, claims["det"], "the determinant")
    _multipliers(trace, det, claims["multipliers"])
    claimed, found = claims["stability"], margins(trace, det)
    demand(claimed in ("stable", "unstable", "undecided"), f"the stability claimed is {claimed!r}")
    if claimed == "stable":
        for name, x in found.items():
            rows.more(name, x)
    if claimed == "unstable":
        shown = 0
        for name, x in found.items():
            if rows.name == name:
                rows.less(name, x)
                shown += 1
        demand(shown, "nothing shows that the orbit is unstable")


def _multipliers(trace: Ball, det: Ball, claimed: Any) -> None:
    """Verify the multipliers claimed; none need be."""
    if claimed == []:
        return
    demand(isinstance(claimed, list) and len(claimed) == 2, "there are not two multipliers")
    for one in claimed:
        keys(one, ("real", "imag"), "a multiplier")
    gap = trace * trace / 4 - det
    demand(gap > 0 or gap < 0, "it is not known whether the multipliers are real")
    if gap < 0:
        root = (-gap).sqrt()
        for one, sign in zip(claimed, (1, -1), strict=True):
            within(trace / 2, one["real"], "the real part of a multiplier")
            within(sign * root, one["imag"], "the imaginary part of a multiplier")
        return
    root = gap.sqrt()
    large = trace / 2 + (root if trace.mid() >= 0 else -root)
    for one, x in zip(claimed, (large, det / large), strict=True):
        within(x, one["real"], "a multiplier")
        demand(one["imag"] == ["0", "0"], "a real multiplier has an imaginary part")


def _least_period(problem: Problem, box: list[Ball], data: Mapping[str, Any], rows: Inequalities) -> None:
    """Verify that the motion has no shorter period, as far as that is claimed."""
    claimed = data["claims"]["least_period"]
    demand(claimed is True or claimed is False, "it is not clear whether a least period is claimed")
    if not claimed:
        return
    n, turn = problem.n, problem.N * problem.motion(box).period
    if n == 0:
        demand(active_harmonics(data["model"]) > 0, "a constant force has no least period, nor has the rest it makes")
        return
    for q in (q for q in range(2, n + 1) if n % q == 0 and all(q % p for p in range(2, q))):
        gaps = [number(0)]
        for i in range(n):
            laps, j = divmod(i + n // q, n)
            gaps += [abs(box[j] + laps * turn - box[i] - turn / q).lower(), abs(box[n + j] - box[n + i]).lower()]
        rows.more(f"least period, divisor {q}", max(gaps, key=float))
