"""Proofs about periodic orbits of the gap map: that one exists and is stable or not, and where its edges lie."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf, nextafter
from pathlib import Path
from typing import Any

import numpy as np
from flint import arb
from numpy.typing import NDArray

from grazing.copies import ByValue
from grazing.orbits.orbit import Orbit
from grazing.outcome import InputError
from grazing.pool import LOCK
from grazing.proof.report import bound, loose
from grazing.proof.text import below, enclosed, exact_text, write_certificate
from grazing.theory import WordOrbit, word_edges, word_orbits
from grazing_checker.balls import around, precision
from grazing_checker.check import trusted_base
from grazing_checker.envelope import seal
from grazing_checker.gap import (
    BITS,
    EVENTS,
    Powers,
    Word,
    edge_rows,
    edge_sentence,
    equations,
    event,
    no_attractor_rows,
    no_attractor_sentence,
    orbit_rows,
    orbit_sentence,
    slopes,
    spreads,
    without_mu,
)
from grazing_checker.reading import Inequalities, Rejected, demand, exact

ORBIT, EDGE, NO_ATTRACTOR = "gap map orbit", "gap map edge", "gap map without attracting orbits"
#: What verifies the data of a kind, and what words the statement.
PROOFS = {
    ORBIT: (orbit_rows, orbit_sentence),
    EDGE: (edge_rows, edge_sentence),
    NO_ATTRACTOR: (no_attractor_rows, no_attractor_sentence),
}
Floats = NDArray[np.floating[Any]]
#: Radii are powers of 2, the first tried and the last.
LARGEST, SMALLEST = 2, 140
#: An orbit is enclosed so tightly, an edge loosely enough to hold its closed form in double precision.
ORBIT_RADIUS, EDGE_RADIUS = 80, 43


@dataclass(frozen=True, eq=False)
class GapProof(ByValue):
    """What came of an attempt to prove something about the gap map.

    Parameters
    ----------
    proven : bool
    statement : str
        One sentence: what is proven, or why nothing is.
    document : dict or None
        The certificate, a JSON document that :func:`grazing_checker.check` checks anew.
    """

    proven: bool
    statement: str
    document: dict[str, Any] | None

    def __repr__(self) -> str:
        return f"<GapProof: {self.statement}>"

    @property
    def reason(self) -> str:
        """Why nothing is proven; empty if something is."""
        return "" if self.proven else self.statement

    @property
    def value(self) -> tuple[float, float] | None:
        """Doubles around the mu of a proven edge; None for anything else."""
        if self.document is None or self.document["kind"] != EDGE:
            return None
        data = self.document["data"]
        centre, radius = exact(data["centre"][-1]), exact(data["radius"])
        low, high = float((centre - radius).lower()), float((centre + radius).upper())
        return nextafter(low, -inf), nextafter(high, inf)

    def save(self, path: str | Path) -> Path:
        """Write the certificate as JSON and return the path; InputError if nothing is proven."""
        if self.document is None:
            raise InputError(f"there is nothing to save: {self.statement}")
        return write_certificate(self.document, path)


def certify_gap_orbit(
    orbit: Orbit | str, lam: float | None = None, mu: float | None = None, l: float | None = None
) -> GapProof:
    """Prove that the gap map has a periodic orbit, that it is the only one nearby, and that it is stable or unstable.

    Parameters
    ----------
    orbit : Orbit or str
        An orbit of a gap map (:func:`grazing.orbits.gap_orbits.gap_orbits`); or a word, to prove its stable admissible
        orbit, or else its first admissible one.
    lam, mu, l : float
        Parameters of the gap map, with a word.

    Returns
    -------
    GapProof
        For the parameters as the doubles that they are.

    Raises
    ------
    InputError
        For an orbit of another map, or a word with a parameter missing.

    Notes
    -----
    Newton's method in balls solves ``s_i^2 + c_i s_(i-1) = K_i mu - c_i l`` for the roots of the points right of the
    border; the theorem of Krawczyk proves one solution in a ball of radius 2^-80 or less and no second one in the
    largest that works. Signs of all points and the multiplier are enclosed over the small ball.

    Examples
    --------
    >>> from grazing.proof.gap import certify_gap_orbit
    >>> proof = certify_gap_orbit("LLR", 0.8, 0.5, 1.0)
    >>> proof.proven, proof.document["data"]["claims"]["stable"]
    (True, True)
    >>> print(certify_gap_orbit("LLR", 0.8, 0.9, 1.0).statement)
    Nothing is proven: LLR has no admissible orbit at lam = 0.8, mu = 0.9, l = 1.0.
    """
    solution, params = _given(orbit, lam, mu, l)
    where = ", ".join(f"{name} = {value!r}" for name, value in params.items())
    if solution is None or not solution.admissible:
        spelled = orbit.word if isinstance(orbit, Orbit) else orbit
        return _nothing(f"{spelled} has no admissible orbit at {where}")
    if not solution.roots:
        return _nothing("the fixed point left of the border is mu/(1 - lam): there is nothing to enclose")
    if min(solution.roots) == 0.0:
        return _nothing(f"{solution.word} grazes at {where}: its slope is infinite there")
    return in_balls(partial(_prove_orbit, solution, params, where))


def certify_gap_edge(word: str, edge: str, lam: float, l: float) -> tuple[GapProof, ...]:
    """Enclose the values of mu at which the orbit of a word grazes, meets the border, doubles its period or folds.

    Parameters
    ----------
    word : str
        A primitive word with an R.
    edge : {"gr", "bc", "pd", "lp"}
    lam : float
        Slope of the gap map for x < 0, 0 < lam < 1.
    l : float
        Gap.

    Returns
    -------
    tuple of GapProof
        One for each value that :func:`grazing.theory.word_edges` finds, in ascending order, with the enclosure of mu
        in ``value``: at most 2^-42 wide, wide enough for the closed form in double precision.

    Raises
    ------
    InputError
        For a bad word, number or edge.

    Examples
    --------
    >>> from grazing.proof.gap import certify_gap_edge
    >>> (proof,) = certify_gap_edge("LLR", "pd", 0.9, 0.0)
    >>> low, high = proof.value
    >>> low < 0.18157749077490773 < high, high - low < 1e-12
    (True, True)
    """
    if edge not in EVENTS:
        raise InputError(f"edge = {edge!r}; allowed are {', '.join(EVENTS)}")
    if isinstance(word, str) and word and set(word) <= {"L", "R"}:
        if "R" not in word or (word + word).index(word, 1) < len(word):
            raise InputError(f"word = {word!r}; edges are proven for primitive words with an R, such as 'LLR'")
    values = getattr(word_edges(word, lam, l), edge)
    return tuple(in_balls(partial(_prove_edge, word, edge, float(lam), float(l), mu)) for mu in values)


def in_balls(call: Callable[[], GapProof]) -> GapProof:
    """Call a function with the bits of the checker; they belong to the process, so one proof at a time."""
    with LOCK, precision(BITS):
        try:
            return call()
        except Rejected as error:  # a word that is too long for the checker
            return _nothing(str(error))


class Writer:
    """Writes down the inequalities that the checker will verify, half way to their limits."""

    def __init__(self) -> None:
        self.rows: list[dict[str, str]] = []

    def more(self, name: str, x: arb) -> None:
        """Write x > left >= 0, or raise Rejected."""
        demand(x > 0, f"{name} is not surely above 0: {x.str(10)}")
        self.rows.append(bound(name, x, ">", 0))
        Inequalities(self.rows[-1:]).more(name, x)

    def less(self, name: str, x: arb, right: str = "0") -> None:
        """Write x < left <= right, or raise Rejected."""
        limit = exact(right) if "x" in right else arb(int(right))
        demand(x < limit, f"{name} is not surely below {limit.str(10)}: {x.str(10)}")
        self.rows.append(bound(name, x, "<", limit if "x" in right else int(right)))
        Inequalities(self.rows[-1:]).less(name, x, right)


def sealed(kind: str, data: dict[str, Any]) -> GapProof:
    """Return the certificate of data whose inequalities all hold, or the first that does not."""
    verify, sentence = PROOFS[kind]
    writer = Writer()
    try:
        verify(data, writer)
    except Rejected as error:
        return _nothing(str(error))
    said = sentence(data)
    return GapProof(True, said, seal(kind, said, trusted_base(kind), data, writer.rows))


def _nothing(why: str) -> GapProof:
    return GapProof(False, f"Nothing is proven: {why}.", None)


def _given(
    orbit: Orbit | str, lam: float | None, mu: float | None, l: float | None
) -> tuple[WordOrbit | None, dict[str, float]]:
    """Return the solution that is meant, and the parameters."""
    if isinstance(orbit, Orbit):
        if orbit.map.origin.orbits is None:
            raise InputError(f"the orbit belongs to {orbit.map!r}; give one of a gap map, gz.gap_map(...)")
        params = {name: orbit.map.params[name] for name in ("lam", "mu", "l")}
        spelled = orbit.word * (orbit.period // len(orbit.word))
        solutions = word_orbits(spelled, *params.values())
        # the orbit nearest to the one given, whatever its first point
        first = float(np.sort(orbit.points[:, 0])[0])
        return min(solutions, key=lambda one: abs(float(one.points.min()) - first), default=None), params
    if lam is None or mu is None or l is None:
        raise InputError("a word alone names no orbit; give lam, mu and l too, or an orbit of gap_orbits")
    solutions = word_orbits(orbit, lam, mu, l)
    admissible = sorted((one for one in solutions if one.admissible), key=lambda one: not one.stable)
    return (admissible[0] if admissible else None), {"lam": float(lam), "mu": float(mu), "l": float(l)}


def _newton(f: Callable[[list[Any]], list[Any]], inverse: Floats, start: Floats) -> list[Any]:
    """Return the middle of a zero, by steps with one approximate inverse: each gains about 50 bits."""
    z = [arb(value) for value in start.tolist()]
    Y = [[arb(entry) for entry in row] for row in inverse.tolist()]
    for _ in range(12):
        value = f(z)
        z = [(z[i] - sum((Y[i][j] * value[j] for j in range(len(z))), arb(0))).mid() for i in range(len(z))]
    return z


def _matrix(rows: list[dict[int, Any]], size: int) -> Floats:
    """Return sparse rows as a matrix of doubles."""
    return np.array([[float(row.get(j, 0.0)) for j in range(size)] for row in rows])


def _widest(inverse: Floats, derivative: Callable[[Any], list[dict[int, Any]]]) -> int:
    """Return e for the widest box, of half-width 2^-e, over which steps with the inverse contract to a half."""
    Y = [[arb(entry) for entry in row] for row in inverse.tolist()]
    fits = (e for e in range(LARGEST, SMALLEST) if all(x < 0.5 for x in spreads(Y, derivative(arb(2) ** -e))))
    return next(fits, SMALLEST)


def _boxes(centre: list[Any], inverse: Floats, e: int, unique: int) -> dict[str, Any]:
    """Return what a certificate says of its boxes, of half-widths 2^-e and 2^-unique."""
    return {
        "centre": [exact_text(z) for z in centre],
        "radius": f"0x1p{-e}",
        "unique": f"0x1p{-unique}",
        "preconditioner": [[float(entry).hex() for entry in row] for row in inverse],
    }


def _claims(roots: list[Any], e: int, unique: int, **more: Any) -> dict[str, Any]:
    """Return what a certificate claims of the roots, and more."""
    apart = arb(2) ** -unique - arb(2) ** -e
    return {"roots": [enclosed(s) for s in roots], "apart": below(apart, 3), **more}


def _prove_orbit(solution: WordOrbit, params: dict[str, float], where: str) -> GapProof:
    word = Word(solution.word)
    mu, l = arb(params["mu"]), arb(params["l"])
    powers = Powers(word, arb(params["lam"]))
    start = np.array(solution.roots)
    try:
        inverse = np.linalg.inv(_matrix(without_mu(slopes(word, powers, [arb(s) for s in solution.roots])), word.k))
    except np.linalg.LinAlgError:
        return _nothing(f"the multiplier of {word.letters} at {where} is 1 to double precision, where two orbits meet")
    roots = _newton(lambda s: equations(word, powers, s, mu, l), inverse, start)
    data: dict[str, Any] = {**{name: value.hex() for name, value in params.items()}, "word": word.letters}
    proof = _nothing(f"no radius from 2^-{ORBIT_RADIUS} to 2^-{SMALLEST} works for {word.letters} at {where}")
    unique = _widest(inverse, lambda half: without_mu(slopes(word, powers, [around(s, half) for s in roots])))
    for e in range(max(ORBIT_RADIUS, unique + 1), SMALLEST, 10):
        box = [around(s, arb(2) ** -e) for s in roots]
        turn = powers.product(word)
        for s in box:
            turn /= 2 * s
        stable = bool(turn > -1 and turn < 1)
        if not stable and not abs(turn) > 1:
            proof = _nothing(
                f"the multiplier of {word.letters} at {where} cannot be told from 1 in modulus: {turn.str(25)}"
            )
            continue
        claims = _claims(box, e, unique, multiplier=loose(turn), stable=stable)
        proof = sealed(ORBIT, {**data, **_boxes(roots, inverse, e, unique), "claims": claims})
        if proof.proven:
            break
    return proof


def _prove_edge(word: str, edge: str, lam: float, l: float, mu: float) -> GapProof:
    """Prove an edge near a value of mu, from each of the orbits just beside it."""
    proof = _nothing(f"{word} has no orbit near mu = {mu!r} to begin with")
    for one in _near(word, edge, lam, l, mu):
        letter = {"gr": "R", "bc": "L"}.get(edge)
        sizes = [abs(x) if on == letter else inf for on, x in zip(word, one.points.tolist(), strict=True)]
        at = 1 + int(np.argmin(sizes)) if letter else 0
        proof = _prove_at(Word(word), edge, at, lam, l, np.array([*one.roots, mu]))
        if proof.proven:
            break
    return proof


def _near(word: str, edge: str, lam: float, l: float, mu: float) -> list[WordOrbit]:
    """Return orbits of a word just beside an edge."""
    found = []
    for shift in (0.0, 1e-13, -1e-13, 1e-10, -1e-10, 1e-7, -1e-7):
        for one in word_orbits(word, lam, mu * (1.0 + shift), l):
            off = abs(abs(one.multiplier) - 1.0) if edge in ("pd", "lp") else float(np.abs(one.points).min())
            found.append((off, one))
    found.sort(key=lambda pair: pair[0])
    return [one for _off, one in found[:4]]


def _prove_at(word: Word, edge: str, at: int, lam: float, l: float, start: Floats) -> GapProof:
    """Solve for all roots and mu, and prove the solution."""
    k, gap, powers = word.k, arb(l), Powers(word, arb(lam))

    def f(z: list[Any]) -> list[Any]:
        value, _row = event(word, powers, edge, at, z, z, gap)
        return [*equations(word, powers, z[:k], z[k], gap), value]

    def derivative(z: list[Any]) -> list[dict[int, Any]]:
        _value, row = event(word, powers, edge, at, z, z, gap)
        return [*slopes(word, powers, z[:k]), row]

    def inverse_at(point: Floats) -> Floats:
        return np.linalg.inv(_matrix(derivative([arb(v) for v in point.tolist()]), k + 1))

    point = start
    try:
        for _ in range(12):  # Newton's method from a start beside the edge
            point = point - inverse_at(point) @ np.array([float(one) for one in f([arb(v) for v in point.tolist()])])
        if not np.isfinite(point).all() or np.abs(point - start).max() > 1e-2 * np.abs(start).max():
            return _nothing(f"Newton's method left the edge of {word.letters} at mu = {float(start[-1])!r}")
        inverse = inverse_at(point)
    except np.linalg.LinAlgError:
        return _nothing(f"the equations of this edge of {word.letters} are singular at lam = {lam!r}, l = {l!r}")
    centre = _newton(f, inverse, point)
    data: dict[str, Any] = {"lam": lam.hex(), "l": l.hex(), "word": word.letters, "edge": edge, "at": at}
    proof = _nothing(f"no radius from 2^-{EDGE_RADIUS} to 2^-{SMALLEST} works for {word.letters}")
    unique = _widest(inverse, lambda half: derivative([around(z, half) for z in centre]))
    for e in range(max(EDGE_RADIUS, unique + 1), SMALLEST):
        box = [around(z, arb(2) ** -e) for z in centre]
        claims = _claims(box[:k], e, unique, value=enclosed(box[k], 24))
        proof = sealed(EDGE, {**data, **_boxes(centre, inverse, e, unique), "claims": claims})
        if proof.proven:
            break
    return proof
