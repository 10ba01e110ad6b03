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
from grazing_checker.reading import Inequalities, decimal, demand, keys, numbers, quoted, within
from grazing_checker.sentence import active_harmonics, orbit_sentence
from grazing_checker.walls import mirrored

KEYS = ("model", "impacts", "periods", "precision", "centre", "radius", "unique", "preconditioner", "cuts", "claims")
CLAIMS = ("box", "apart", "least_period", "incoming", "trace", "det", "multipliers", "stability")


def check_orbit(data: Mapping[str, Any], inequalities: list[Any]) -> str:
    """Verify a certificate of a periodic orbit and return the sentence that it proves, or raise Rejected.

    What is proven, and where each hypothesis is demanded:

    1. One solution of the equations within ``radius`` of ``centre``, and no other within ``unique``
       (:func:`_existence`).
    2. It is a motion: impacts in the order of time, with v < 0 and w >= 0, and no other contact
       (:func:`grazing_checker.oscillator.check_flights`).
    3. Its multipliers (:func:`_stability`). The map from impact to impact is smooth there, as v < 0 and the law is
       smooth over the box.
    4. Its least period (:func:`_least_period`).
    """
    keys(data, (*KEYS, "law"), "the data")
    keys(data["claims"], CLAIMS, "the claims")
    return _checked(data, inequalities)


def check_walled_orbit(data: Mapping[str, Any], inequalities: list[Any]) -> str:
    """Verify a certificate of a periodic orbit with walls of its own, one or two, which may move.

    It is :func:`check_orbit` with a list of walls in place of one (:mod:`grazing_checker.walls`), and that the orbit
    is its own mirror image, where that is claimed (:func:`_symmetric`).
    """
    keys(data, (*KEYS, "walls"), "the data")
    keys(data["claims"], (*CLAIMS, "symmetric"), "the claims")
    return _checked(data, inequalities)


def _checked(data: Mapping[str, Any], inequalities: list[Any]) -> str:
    with precision(precision_of(data)):
        problem = Problem(data)
        rows = Inequalities(inequalities)
        box = _existence(problem, data, rows)
        legs = problem.legs(box)
        check_flights(problem, box, legs, data["cuts"], rows)
        _stability(problem, box, legs, data["claims"], rows)
        _least_period(problem, box, data, rows)
        if "symmetric" in data["claims"]:
            _symmetric(problem, box, data)
        _incoming(problem.n, legs, data["claims"])
        rows.finish()
    return orbit_sentence(data)


def _existence(problem: Problem, data: Mapping[str, Any], rows: Inequalities) -> list[Ball]:
    """Verify that the box holds exactly one solution and return it.

    Krawczyk's theorem: let F be smooth on the box X of half-widths u about c, D hold its derivative on all of X, C be
    any matrix and 0 < r < u. If |I - C D| u < u in every row, x -> x - C F(x) contracts X in the norm with weights u,
    so X holds one fixed point at most; and C D, hence C, is regular (its distance from I is below 1), so that fixed
    points are zeros of F. If |C F(c)| + |I - C D| r < r, the map takes the box of half-widths r into itself and has one
    there.

    Demanded: 0 < r < u, both inequalities strictly, D over X with the reset law smooth and the impacts in order on X
    (:class:`Problem` rejects others). A singular C cannot pass: |I - C D| has then the eigenvalue 1, at least.
    """
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


def _incoming(n: int, legs: list[Leg], claims: Mapping[str, Any]) -> None:
    found = claims["incoming"]
    demand(isinstance(found, list) and len(found) == n, "the incoming velocities are not complete")
    for i, text in enumerate(found):
        within(legs[i].v, text, f"incoming velocity {i + 1}")


def _stability(
    problem: Problem, box: list[Ball], legs: list[Leg], claims: Mapping[str, Any], rows: Inequalities
) -> None:
    """Verify trace, determinant, multipliers and what is claimed of the stability.

    Jury: both eigenvalues of a real 2 x 2 matrix are inside the unit circle exactly if 1 + tr + det, 1 - tr + det and
    1 - det are > 0; if one of these is < 0, an eigenvalue is outside. A fixed point of a smooth map is asymptotically
    stable in the first case and unstable in the second. That the motion is stable as the fixed point is, is demanded by
    :meth:`grazing_checker.oscillator.Problem.followed`. Nothing else is claimed.
    """
    trace, det = problem.trace_and_det(box, legs)
    within(trace, claims["trace"], "the trace")
    within(det, claims["det"], "the determinant")
    _multipliers(trace, det, claims["multipliers"])
    claimed, found = claims["stability"], margins(trace, det)
    demand(claimed in ("stable", "unstable", "undecided"), f"the stability claimed is {quoted(claimed)}")
    if claimed == "stable":
        demand(problem.followed(box), "an impact leaves with w = 0, and the law may throw slow impacts back")
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
    """Verify that the motion has no shorter period, as far as that is claimed.

    The periods of a motion u(t) that is not at rest are the multiples of the least one. So if N T is not the least
    period, N T/q is a period for a prime q. It shifts the impacts, all of which are known, by n/q places, each to one
    at the same wall, as u' jumps up at one below the ball and down at one above it: q divides n, t_(i + n/q) = t_i + N
    T/q and the velocity u' after both is the same, for all i. For every prime q that divides n one of these 2n
    equations must fail over all of the box, or the walls differ. Whether q divides N is no matter, as the forcing may
    have a shorter period itself. With n = 1 nothing is left to show.

    Without impacts u'' + alpha u' + k^2 u = f has one solution of period N T, as D is regular. f has the least period
    T/g (:func:`grazing_checker.sentence.active_harmonics`), so u, shifted by T/g, is the same solution. And f, made of
    u and its derivatives, has every period that u has: T/g is the least one, whatever N is.
    """
    claimed = data["claims"]["least_period"]
    demand(claimed is True or claimed is False, "it is not clear whether a least period is claimed")
    if not claimed:
        return
    n, frames = problem.n, problem.frames(box)
    turn = problem.N * frames[0].motion.period
    if n == 0:
        demand(active_harmonics(data["model"]) > 0, "a constant force has no least period, nor has the rest it makes")
        return
    seen = [frames[hit] for hit in problem.hits]
    speeds = [one.at(t)[1] + one.sign * w for one, t, w in zip(seen, box[:n], box[n:], strict=True)]
    for q in (q for q in range(2, n + 1) if n % q == 0 and all(q % p for p in range(2, q))):
        step = n // q
        if problem.hits != [*problem.hits[step:], *problem.hits[:step]]:
            continue
        gaps = [number(0)]
        for i in range(n):
            laps, j = divmod(i + step, n)
            gaps += [abs(box[j] + laps * turn - box[i] - turn / q).lower(), abs(speeds[j] - speeds[i]).lower()]
        rows.more(f"least period, divisor {q}", max(gaps))


def _symmetric(problem: Problem, box: list[Ball], data: Mapping[str, Any]) -> None:
    """Verify that the orbit is its own mirror image half of its period later, where that is claimed.

    The model is its own mirror image half a period T/2 later (:func:`grazing_checker.walls.mirrored`), and so it is N
    T/2 later, as N is odd. So the image of the orbit is a motion, too, whose impacts are those of the orbit at the
    other wall, N T/2 earlier or later, with the same velocities. If these, in the order that they then have, are at the
    walls of the orbit's own impacts and in the box of uniqueness, the image is the orbit. Without impacts both solve
    one linear equation, which has one solution of period N T, as D is regular.
    """
    claimed = data["claims"]["symmetric"]
    demand(claimed is True or claimed is False, "it is not clear whether a symmetry is claimed")
    if not claimed:
        return
    n, half = problem.n, problem.n // 2
    demand(n % 2 == 0 and problem.N % 2 == 1, "no such orbit is its own mirror image")
    demand(mirrored(data), "the model is not its own mirror image")
    if n == 0:
        return
    demand(problem.hits[half:] == [1 - hit for hit in problem.hits[:half]], "the impacts are not at the other walls")
    centre, u = (numbers(data[name], 2 * n, name) for name in ("centre", "unique"))
    shift = problem.N * problem.motion(box).period / 2
    for i in range(n):
        j = (i + half) % n
        late = shift if i < half else -shift
        held = abs(box[j] - late - centre[i]) < u[i] and abs(box[n + j] - centre[n + i]) < u[n + i]
        demand(held, "the mirror image is not proven to be the orbit itself")
