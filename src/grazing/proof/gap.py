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
from grazing.maps.gap import gap_step
from grazing.orbits.orbit import Orbit
from grazing.oscillator.exact import LOCK
from grazing.outcome import InputError
from grazing.proof.envelope import seal, write_envelope
from grazing.proof.gap_checker import (
    EDGE,
    MEANING,
    ORBIT,
    TRUSTED,
    Inequality,
    Rejected,
    ball,
    exact,
    inequalities_of,
    statement_of,
    with_bits,
    written,
)
from grazing.theory import WordOrbit, word_edges, word_orbits

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
        The certificate, a JSON document that :func:`grazing.proof.gap_checker.check_gap_certificate` checks anew.
    """

    proven: bool
    statement: str
    document: dict[str, Any] | None

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
        return write_envelope(self.document, path)


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
    >>> proof.proven, proof.document["data"]["stable"]
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
    return in_balls(partial(_prove_orbit, solution, params, where))  # type: ignore[no-any-return]


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
    if edge not in MEANING:
        raise InputError(f"edge = {edge!r}; allowed are {', '.join(MEANING)}")
    if isinstance(word, str) and word and set(word) <= {"L", "R"}:
        if "R" not in word or (word + word).index(word, 1) < len(word):
            raise InputError(f"word = {word!r}; edges are proven for primitive words with an R, such as 'LLR'")
    values = getattr(word_edges(word, lam, l), edge)
    return tuple(in_balls(partial(_prove_edge, word, edge, float(lam), float(l), mu)) for mu in values)


def in_balls(call: Callable[[], Any]) -> Any:
    """Call a function with the bits of the checker; they belong to the process, so one proof at a time."""
    with LOCK:
        return with_bits(call)


def sealed(kind: str, data: dict[str, Any]) -> GapProof:
    """Return the certificate of data whose inequalities all hold, or the first that does not."""
    try:
        found: list[Inequality] = inequalities_of(kind, data)
    except Rejected as error:
        return _nothing(str(error))
    said = statement_of(kind, data)
    listed = [{"name": name, "left": ball(a), "relation": "<", "right": ball(b)} for name, a, b in found]
    return GapProof(True, said, seal(kind, said, TRUSTED[kind], data, listed))


def _nothing(why: str) -> GapProof:
    return GapProof(False, f"Nothing is proven: {why}.", None)


def _given(
    orbit: Orbit | str, lam: float | None, mu: float | None, l: float | None
) -> tuple[WordOrbit | None, dict[str, float]]:
    """Return the solution that is meant, and the parameters."""
    if isinstance(orbit, Orbit):
        if orbit.map.step is not gap_step:
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


def _counts(word: str) -> tuple[int, ...]:
    last = word.rindex("R") + 1
    return tuple(len(run) for run in (word[last:] + word[:last])[:-1].split("R"))


def _coefficients(word: str, lam: float) -> tuple[list[Any], list[Any]]:
    """Return c = lam^m and K = 1 + ... + lam^m of every block as balls."""
    a = arb(lam)
    counts = _counts(word)
    return [a**m for m in counts], [sum((a**i for i in range(m + 1)), arb(0)) for m in counts]


def _newton(f: Callable[[list[Any]], list[Any]], inverse: Floats, start: Floats) -> list[Any]:
    """Return the middle of a zero, by steps with one approximate inverse: each gains about 50 bits."""
    z = [arb(value) for value in start.tolist()]
    Y = [[arb(entry) for entry in row] for row in inverse.tolist()]
    for _ in range(12):
        value = f(z)
        z = [(z[i] - sum((Y[i][j] * value[j] for j in range(len(z))), arb(0))).mid() for i in range(len(z))]
    return z


def _hex(matrix: Floats) -> list[list[str]]:
    return [[float(entry).hex() for entry in row] for row in matrix]


def _power(e: int) -> str:
    return f"1p{-e}"


def _prove_orbit(solution: WordOrbit, params: dict[str, float], where: str) -> GapProof:
    word, k = solution.word, len(solution.roots)
    c, K = _coefficients(word, params["lam"])
    mu, l = arb(params["mu"]), arb(params["l"])

    def f(s: list[Any]) -> list[Any]:
        return [s[i] ** 2 + c[i] * s[i - 1] - K[i] * mu + c[i] * l for i in range(k)]

    J = np.diag(2.0 * np.array(solution.roots))
    J[np.arange(k), np.arange(k) - 1] += [float(one) for one in c]
    try:
        inverse = np.linalg.inv(J)
    except np.linalg.LinAlgError:
        return _nothing(f"the multiplier of {word} at {where} is 1 to double precision, where two orbits meet")
    roots = _newton(f, inverse, np.array(solution.roots))
    data: dict[str, Any] = {name: value.hex() for name, value in params.items()}
    data |= {"word": word, "roots": [written(s) for s in roots], "inverse": _hex(inverse)}
    proof = _nothing(f"no radius from 2^-{ORBIT_RADIUS} to 2^-{SMALLEST} works for {word} at {where}")
    for e in range(ORBIT_RADIUS, SMALLEST, 10):
        box = [arb(s, arb(2) ** -e) for s in roots]
        turn = arb(1)
        for i in range(k):
            turn *= -c[i] / (2 * box[i])
        slack = arb(2) ** -(e // 2) * (1 + abs(turn))
        low, high = (turn - slack).lower(), (turn + slack).upper()
        if not (bool(low > -1) and bool(high < 1)) and not (bool(low > 1) or bool(high < -1)):
            proof = _nothing(f"the multiplier of {word} at {where} cannot be told from 1 in modulus: {ball(turn)}")
            continue
        data |= {
            "radius": _power(e),
            "multiplier": [written(low), written(high)],
            "stable": bool(high < 1 and low > -1),
        }
        for unique in range(LARGEST, e):
            proof = sealed(ORBIT, {**data, "unique": _power(unique)})
            if proof.proven:
                return proof
    return proof


def _prove_edge(word: str, edge: str, lam: float, l: float, mu: float) -> GapProof:
    """Prove an edge near a value of mu, trying every point that may be the one on the border."""
    counts = _counts(word)
    solutions = _near(word, edge, lam, l, mu)
    if not solutions:
        return _nothing(f"{word} has no orbit near mu = {mu!r} to begin with")
    proof = _nothing("")
    for roots in solutions:
        places = range(1) if edge in ("pd", "lp") else _border(edge, counts, roots, lam, mu, l)
        for at in places:
            proof = _prove_at(word, edge, at, lam, l, np.append(roots, mu))
            if proof.proven:
                return proof
    return proof


def _near(word: str, edge: str, lam: float, l: float, mu: float) -> list[Floats]:
    """Return the roots of orbits of a word just beside an edge."""
    found = []
    for shift in (0.0, 1e-13, -1e-13, 1e-10, -1e-10, 1e-7, -1e-7):
        for one in word_orbits(word, lam, mu * (1.0 + shift), l):
            off = abs(abs(one.multiplier) - 1.0) if edge in ("pd", "lp") else float(np.abs(one.points).min())
            found.append((off, np.array(one.roots)))
    found.sort(key=lambda pair: pair[0])
    return [roots for _off, roots in found[:4]]


def _border(edge: str, counts: tuple[int, ...], roots: Floats, lam: float, mu: float, l: float) -> list[int]:
    """Return the number of the root, or of the point with letter L, that is nearest to the border."""
    if edge == "gr":
        return [int(np.argmin(roots))]
    points = []
    for i, m in enumerate(counts):
        x = mu - l - float(roots[i - 1])
        for _ in range(m):
            points.append(x)
            x = lam * x + mu
    return [int(np.argmin(np.abs(points)))] if points else []


def _prove_at(word: str, edge: str, at: int, lam: float, l: float, start: Floats) -> GapProof:
    """Solve for all roots and mu, and prove the solution."""
    counts, k = _counts(word), len(start) - 1
    c, K = _coefficients(word, lam)
    gap, sign = arb(l), (-1) ** k if edge == "pd" else -((-1) ** k)

    def last(z: list[Any]) -> Any:
        if edge == "gr":
            return z[at]
        if edge == "bc":
            return _left(counts, z, lam, gap)[at]
        product, limit = arb(1), arb(sign)
        for s, one in zip(z[:k], c, strict=True):
            product, limit = product * 2 * s, limit * one
        return product + limit

    def f(z: list[Any]) -> list[Any]:
        return [*(z[i] ** 2 + c[i] * z[(i - 1) % k] - K[i] * z[k] + c[i] * gap for i in range(k)), last(z)]

    point = start
    for _ in range(12):  # Newton's method from a start beside the edge
        value = np.array([float(one) for one in f([arb(v) for v in point.tolist()])])
        J = _slopes(f, point)
        try:
            inverse = np.linalg.inv(J)
        except np.linalg.LinAlgError:
            return _nothing(f"the equations of this edge of {word} are singular at lam = {lam!r}, l = {l!r}")
        point = point - inverse @ value
    if not np.isfinite(point).all() or np.abs(point - start).max() > 1e-2 * np.abs(start).max():
        return _nothing(f"Newton's method left the edge of {word} at mu = {float(start[-1])!r}")
    inverse = np.linalg.inv(_slopes(f, point))
    centre = _newton(f, inverse, point)
    data: dict[str, Any] = {"lam": lam.hex(), "l": l.hex(), "word": word, "edge": edge, "at": at}
    data |= {"centre": [written(z) for z in centre], "inverse": _hex(inverse)}
    proof = _nothing(f"no radius from 2^-{EDGE_RADIUS} to 2^-{SMALLEST} works for {word}")
    for e in range(EDGE_RADIUS, SMALLEST):
        proof = sealed(EDGE, {**data, "radius": _power(e)})
        if proof.proven:
            break
    return proof


def _left(counts: tuple[int, ...], z: list[Any], lam: float, gap: Any) -> list[Any]:
    """Return the points with letter L of the orbit with roots z[:-1] at mu = z[-1]."""
    found, mu = [], z[-1]
    for i, m in enumerate(counts):
        x = mu - gap - z[(i - 1) % len(counts)]
        for _ in range(m):
            found.append(x)
            x = arb(lam) * x + mu
    return found


def _slopes(f: Callable[[list[Any]], list[Any]], at: Floats) -> Floats:
    """Return the derivative of polynomial equations by central differences in balls, exact to double precision."""
    h = arb(2) ** -60
    columns = []
    for j in range(len(at)):
        ahead, behind = ([arb(v) + (step if i == j else 0) for i, v in enumerate(at.tolist())] for step in (h, -h))
        columns.append([float((p - q) / (2 * h)) for p, q in zip(f(ahead), f(behind), strict=True)])
    return np.array(columns).T
