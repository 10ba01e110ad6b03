"""Check a certificate about the gap map again, with ball arithmetic and without the code that found it.

Only the standard library and python-flint are used here. What a certificate says is built anew from its data, every
inequality is evaluated anew, and both are compared with what the certificate claims.

The gap map is ``x -> lam x + mu`` for x < 0 (letter L) and ``x -> mu - l - sqrt(x)`` for x >= 0 (letter R). With s_i
the roots of the points right of the border, c = lam^m, K = 1 + ... + lam^m for a block L^m R, an orbit solves
``s_i^2 + c_i s_(i-1) - K_i mu + c_i l = 0``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from hashlib import sha256
from typing import Any

from flint import arb, ctx, fmpz

ORBIT, EDGE, CHAOS = "gap map orbit", "gap map edge", "gap map without attracting orbits"
#: Bits of the balls.
BITS = 160
SHARED = (
    "the gap map x -> lam x + mu for x < 0, mu - l - sqrt(x) for x >= 0 (Pring and Budd 2011, equation (2.6))",
    "ball arithmetic of FLINT (arb) at 160 bits, called by python-flint",
    "the checker grazing.proof.gap_checker",
)
KRAWCZYK = "the theorem of Krawczyk: a box that is mapped into its own interior holds exactly one zero"
METRIC = "the argument in grazing.proof.gap_checker that blocks stretch the length sqrt(s) ds, s = sqrt(x)"
TRUSTED = {ORBIT: [*SHARED, KRAWCZYK], EDGE: [*SHARED, KRAWCZYK], CHAOS: [*SHARED, METRIC]}
#: What vanishes at an edge, in words.
MEANING = {
    "gr": "a point with letter R at the border (graze)",
    "bc": "a point with letter L at the border (border collision)",
    "pd": "multiplier -1 (period doubling)",
    "lp": "multiplier +1 (fold)",
}

#: The fields of the data.
FIELDS = {
    ORBIT: {"lam", "mu", "l", "word", "roots", "inverse", "radius", "unique", "multiplier", "stable"},
    EDGE: {"lam", "l", "word", "edge", "at", "centre", "inverse", "radius"},
    CHAOS: {"lam", "l", "low", "high", "turns"},
}

Inequality = tuple[str, Any, Any]


class Rejected(ValueError):
    """A certificate that is not right, with the reason."""


def check_gap_certificate(document: Any) -> str:
    """Check a certificate about the gap map and return its statement.

    Parameters
    ----------
    document : dict
        As read from its JSON file.

    Returns
    -------
    str
        The sentence that is proven.

    Raises
    ------
    Rejected
        If anything in it is not right: the hash, the statement, the trusted base, an inequality.

    Examples
    --------
    >>> from grazing.proof.gap import certify_gap_orbit
    >>> check_gap_certificate(certify_gap_orbit("R", 0.5, 1.0, 0.0).document).startswith("For lam = 0.5")
    True
    """
    body = _opened(document)
    kind, data = body["kind"], body["data"]
    if kind not in TRUSTED:
        raise Rejected(f"the kind of certificate is {kind!r}; allowed are {', '.join(TRUSTED)}")
    if body["trusted_base"] != TRUSTED[kind]:
        raise Rejected("the trusted base is not that of this kind of certificate")
    with_bits(lambda: _compare(body["inequalities"], inequalities_of(kind, data)))
    said: str = with_bits(lambda: statement_of(kind, data))
    if body["statement"] != said:
        raise Rejected(f"the statement does not follow from the data; what follows is: {said}")
    return said


def inequalities_of(kind: str, data: Any) -> list[Inequality]:
    """Return every inequality of a proof, as name and the balls of its two sides; raise Rejected for bad data."""
    if not isinstance(data, dict) or set(data) != FIELDS[kind]:
        raise Rejected(f"the data must have the fields {', '.join(sorted(FIELDS[kind]))}")
    made = {ORBIT: _orbit_inequalities, EDGE: _edge_inequalities, CHAOS: _chaos_inequalities}[kind]
    try:
        found = made(data)
    except (KeyError, TypeError, IndexError, AttributeError, ValueError) as error:
        raise error if isinstance(error, Rejected) else Rejected(f"the data cannot be read: {error!r}") from None
    for name, left, right in found:
        if not left < right:
            raise Rejected(f"{name} fails: {ball(left)} < {ball(right)} is not proven")
    return found


def statement_of(kind: str, data: Any) -> str:
    """Return the sentence that a proof with these data proves."""
    lam, l = (float.fromhex(data[name]) for name in ("lam", "l"))
    if kind == CHAOS:
        low, high = (float.fromhex(data[name]) for name in ("low", "high"))
        start = "(" if low == 0.0 else "["
        return (
            f"For lam = {lam!r}, l = {l!r} and every mu in {start}{low!r}, {high!r}] the gap map has no attracting "
            "periodic orbit: every periodic orbit has a multiplier of modulus above 1."
        )
    word = data["word"]
    if kind == EDGE:
        mu = exact(data["centre"][-1])
        return (
            f"For lam = {lam!r}, l = {l!r} exactly one mu within {power(data['radius'])} of {ball(mu)} has an orbit of "
            f"word {word} of the gap map, with roots as near to the stored ones, that has {MEANING[data['edge']]}; "
            "all its other points lie strictly on the side of their letter."
        )
    mu = float.fromhex(data["mu"])
    stability = "stable" if data["stable"] else "unstable"
    low, high = (exact(end) for end in data["multiplier"])
    return (
        f"For lam = {lam!r}, mu = {mu!r}, l = {l!r} the gap map has a periodic orbit of word {word} and least period "
        f"{len(word)}, the only one with roots within {power(data['unique'])} of the stored ones; its multiplier lies "
        f"in {low.union(high).str(15)}, so it is {stability}."
    )


def with_bits(call: Callable[[], Any]) -> Any:
    """Call a function with balls of the agreed number of bits."""
    before, ctx.prec = ctx.prec, BITS
    try:
        return call()
    finally:
        ctx.prec = before


def exact(text: str) -> Any:
    """Return the number m 2^e written as ``"m p e"``."""
    m, e = text.split("p")
    return arb(fmpz(m)) * arb(2) ** fmpz(e)


def written(number: Any) -> str:
    """Write the middle of a ball exactly, as ``"m p e"``."""
    m, e = number.mid().man_exp()
    return f"{int(m)}p{int(e)}"


def power(text: str) -> str:
    """Write a radius for a reader, exactly."""
    m, e = text.split("p")
    return f"2^{int(e)}" if int(m) == 1 else f"{int(m)} 2^{int(e)}"


def ball(number: Any) -> str:
    """Write a ball in decimals, rounded outwards."""
    return str(number.str(25))


def _opened(document: Any) -> Any:
    """Return a document whose envelope is right."""
    names = {"format", "version", "kind", "statement", "trusted_base", "data", "inequalities", "sha256"}
    if not isinstance(document, dict) or set(document) != names:
        raise Rejected(f"this is no certificate; its fields must be {', '.join(sorted(names))}")
    if document["format"] != "grazing certificate" or document["version"] != 2:
        raise Rejected("the format must be 'grazing certificate', version 2")
    body = {name: document[name] for name in names - {"sha256"}}
    canonical = json.dumps(body, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    if document["sha256"] != sha256(canonical.encode("ascii")).hexdigest():
        raise Rejected("the hash is wrong: the certificate was changed after it was sealed")
    return document


def _compare(stored: Any, found: list[Inequality]) -> None:
    """Hold the inequalities that a certificate lists against those of its data."""
    if not isinstance(stored, list) or [one.get("name") for one in stored] != [name for name, _l, _r in found]:
        raise Rejected("the inequalities listed are not those of the proof")
    for one, (name, left, right) in zip(stored, found, strict=True):
        if set(one) != {"name", "left", "relation", "right"} or one["relation"] != "<":
            raise Rejected(f"inequality {name!r} must have name, left, relation < and right")
        try:
            sides = arb(one["left"]), arb(one["right"])
        except (TypeError, ValueError):
            raise Rejected(f"inequality {name!r} has a side that is no ball") from None
        if not (sides[0].overlaps(left) and sides[1].overlaps(right) and sides[0] < sides[1]):
            raise Rejected(f"inequality {name!r} is listed as {one['left']} < {one['right']}, which is not the proof's")


# Orbits and edges: one system of equations, proven solvable by Krawczyk's operator


def _word(data: Any) -> tuple[str, tuple[int, ...]]:
    """Return the word and the numbers of letters L in its blocks, the first block after the last R."""
    word = data["word"]
    if not word or set(word) - {"L", "R"} or "R" not in word:
        raise Rejected(f"word {word!r}: allowed are letters L and R, at least one R")
    length = (word + word).index(word, 1)
    if len(word) // length > 2:
        raise Rejected(f"word {word!r} repeats a shorter one more than twice")
    last = word.rindex("R") + 1
    return word, tuple(len(run) for run in (word[last:] + word[:last])[:-1].split("R"))


def _coefficients(counts: tuple[int, ...], lam: Any) -> tuple[list[Any], list[Any]]:
    """Return c = lam^m and K = 1 + ... + lam^m of every block."""
    c = [lam**m for m in counts]
    return c, [sum((lam**i for i in range(m + 1)), arb(0)) for m in counts]


def _left_points(counts: tuple[int, ...], roots: list[Any], lam: Any, mu: Any, l: Any) -> list[Any]:
    """Return the points with letter L, block by block."""
    found = []
    for i, m in enumerate(counts):
        x = mu - l - roots[i - 1]
        for _ in range(m):
            found.append(x)
            x = lam * x + mu
    return found


def _box(centre: list[Any], radius: Any) -> list[Any]:
    return [arb(m.mid(), radius) for m in centre]


def _krawczyk(
    name: str,
    f: Callable[[list[Any]], list[Any]],
    slope: Callable[[list[Any]], list[list[Any]]],
    centre: list[Any],
    radius: Any,
    inverse: list[list[Any]],
) -> list[Inequality]:
    """Return |Y f(m)| + |I - Y Df(box)| r < r, component by component."""
    n = len(centre)
    value, J = f(centre), slope(_box(centre, radius))
    found = []
    for i in range(n):
        off = abs(sum((inverse[i][k] * value[k] for k in range(n)), arb(0)))
        spread = arb(0)
        for j in range(n):
            entry = arb(int(i == j)) - sum((inverse[i][k] * J[k][j] for k in range(n)), arb(0))
            spread += abs(entry).upper()
        found.append((f"{name}, component {i + 1}", off + spread * radius, radius))
    return found


def _orbit_inequalities(data: Any) -> list[Inequality]:
    word, counts = _word(data)
    k = len(counts)
    lam, mu, l = (arb(float.fromhex(data[name])) for name in ("lam", "mu", "l"))
    c, K = _coefficients(counts, lam)
    centre = [exact(text) for text in data["roots"]]
    inverse = [[arb(float.fromhex(entry)) for entry in row] for row in data["inverse"]]
    radius, unique = exact(data["radius"]), exact(data["unique"])
    if len(centre) != k or len(inverse) != k or any(len(row) != k for row in inverse):
        raise Rejected(f"a word with {k} letters R needs {k} roots and a matrix of that size")

    def f(s: list[Any]) -> list[Any]:
        return [s[i] ** 2 + c[i] * s[i - 1] - K[i] * mu + c[i] * l for i in range(k)]

    def slope(s: list[Any]) -> list[list[Any]]:
        J = [[arb(0) for _ in range(k)] for _ in range(k)]
        for i in range(k):
            J[i][i] += 2 * s[i]
            J[i][i - 1] += c[i]
        return J

    found = _krawczyk("Krawczyk, existence", f, slope, centre, radius, inverse)
    found += [("the ball of existence lies in that of uniqueness", radius, unique)]
    found += _krawczyk("Krawczyk, uniqueness", f, slope, centre, unique, inverse)
    box = _box(centre, radius)
    found += _sides(counts, box, lam, mu, l)
    if (word + word).index(word, 1) < len(word):
        far = max((abs(box[i] - box[i - k // 2]) for i in range(k)), key=lambda at: float(at.lower()))
        found.append(("the two halves of the orbit differ", arb(0), far))
    turn = arb(1)
    for i in range(k):
        turn *= -c[i] / (2 * box[i])
    low, high = (exact(end) for end in data["multiplier"])
    found += [("multiplier, from below", low, turn), ("multiplier, from above", turn, high)]
    if data["stable"] is True:
        found += [("the multiplier is above -1", arb(-1), low), ("the multiplier is below 1", high, arb(1))]
    elif data["stable"] is False:
        found.append(("the multiplier is outside [-1, 1]", arb(1), low if low > 0 else -high))
    else:
        raise Rejected("stable must be true or false")
    return found


def _sides(
    counts: tuple[int, ...], box: list[Any], lam: Any, mu: Any, l: Any, left: int = -1, right: int = -1
) -> list[Inequality]:
    """Return the signs of all points but the one that lies on the border."""
    found = [(f"root {i + 1} is positive", arb(0), s) for i, s in enumerate(box) if i != right]
    points = _left_points(counts, box, lam, mu, l)
    return found + [(f"point {i + 1} with letter L is negative", x, arb(0)) for i, x in enumerate(points) if i != left]


def _edge_inequalities(data: Any) -> list[Inequality]:
    word, counts = _word(data)
    kind, at, k = data["edge"], data["at"], len(counts)
    if (word + word).index(word, 1) < len(word) or kind not in MEANING or type(at) is not int:
        raise Rejected("an edge needs a primitive word, one of gr, bc, pd, lp, and the place of the point that is 0")
    lam, l = (arb(float.fromhex(data[name])) for name in ("lam", "l"))
    c, K = _coefficients(counts, lam)
    centre = [exact(text) for text in data["centre"]]
    inverse = [[arb(float.fromhex(entry)) for entry in row] for row in data["inverse"]]
    radius = exact(data["radius"])
    places = {"gr": k, "bc": sum(counts)}.get(kind, 1)
    size = k + 1
    if not 0 <= at < places or len(centre) != size or len(inverse) != size or any(len(r) != size for r in inverse):
        raise Rejected(f"an edge of a word with {k} letters R needs {size} unknowns, a matrix of that size, a place")
    sign = (-1) ** k if kind == "pd" else -((-1) ** k)

    def last(z: list[Any]) -> Any:
        if kind == "gr":
            return z[at]
        if kind == "bc":
            return _left_points(counts, z[:k], lam, z[k], l)[at]
        product, limit = arb(1), arb(sign)
        for s, one in zip(z[:k], c, strict=True):
            product, limit = product * 2 * s, limit * one
        return product + limit

    def f(z: list[Any]) -> list[Any]:
        return [*(z[i] ** 2 + c[i] * z[(i - 1) % k] - K[i] * z[k] + c[i] * l for i in range(k)), last(z)]

    def slope(z: list[Any]) -> list[list[Any]]:
        J = [[arb(0) for _ in range(size)] for _ in range(size)]
        for i in range(k):
            J[i][i] += 2 * z[i]
            J[i][(i - 1) % k] += c[i]
            J[i][k] = -K[i]
        J[k] = _last_slope(kind, at, counts, lam, z)
        return J

    found = _krawczyk("Krawczyk", f, slope, centre, radius, inverse)
    box = _box(centre, radius)
    on_left, on_right = (at if kind == "bc" else -1), (at if kind == "gr" else -1)
    return found + _sides(counts, box[:k], lam, box[k], l, on_left, on_right)


def _last_slope(kind: str, at: int, counts: tuple[int, ...], lam: Any, z: list[Any]) -> list[Any]:
    """Return the derivative of the condition that makes an edge."""
    k = len(counts)
    row = [arb(0) for _ in range(k + 1)]
    if kind == "gr":
        row[at] = arb(1)
    elif kind == "bc":  # x = lam^q (mu - l - s_(i-1)) + (1 + ... + lam^(q-1)) mu
        i, q = next((i, q) for i, q, place in _places(counts) if place == at)
        row[(i - 1) % k] = -(lam**q)
        row[k] = sum((lam**p for p in range(q + 1)), arb(0))
    else:
        for i in range(k):
            row[i] = arb(2)
            for j in range(k):
                if j != i:
                    row[i] *= 2 * z[j]
    return row


def _places(counts: tuple[int, ...]) -> Iterable[tuple[int, int, int]]:
    """Yield block, steps since its beginning and running number of the points with letter L."""
    place = 0
    for i, m in enumerate(counts):
        for q in range(m):
            yield i, q, place
            place += 1


# No attracting orbit: the first return to x >= 0 stretches the length weighted by sqrt(s)


def _chaos_inequalities(data: Any) -> list[Inequality]:
    """Return what proves that every periodic orbit repels, for every mu > 0 in [low, high].

    Every periodic orbit comes back to 0 <= x <= mu by blocks L^(n-1) R, ``s'^2 = C - c s`` with ``c = lam^(n-1)``, ``C
    = K_n mu - c l``. The length ``sqrt(s) ds`` is stretched by ``c/(2 sqrt(s s'))``, and ``c s s' = s' (C - s'^2)`` is
    at most ``2 (C/3)^(3/2)``; so the stretching is ``(3 c^2/(4 C))^(3/4)`` at least: above 1 if ``K_n mu < c l + 3
    c^2/4``. A block of n > 1 letters does not occur if the lowest start, s = sqrt(mu), has come to x_(n-1) >= 0: if
    ``K_(n-1) mu >= lam^(n-2) (l + sqrt(mu))``. The first holds for all smaller mu too, the second for all greater
    ones, and for all longer blocks. At l = 0 a block that occurs has ``sqrt(mu) < c/(K_n - 1)``, so the first holds
    whenever ``(3 K_n - 1)(K_n - 3) >= 0``.
    """
    lam, l = (arb(float.fromhex(data[name])) for name in ("lam", "l"))
    low, high = (float.fromhex(data[name]) for name in ("low", "high"))
    if not (bool(l >= 0) and low >= 0.0):
        raise Rejected("allowed are l >= 0 and low >= 0")
    found = [("lam is positive", arb(0), lam), ("lam is below 1", lam, arb(1)), ("low < high", arb(low), arb(high))]
    turns = [float.fromhex(turn) for turn in data["turns"]]
    if not turns:
        raise Rejected("blocks of one letter always occur, and are not looked at")
    c, K = arb(1), arb(1)
    for n, turn in enumerate(turns, start=1):
        if not low <= turn <= high:
            raise Rejected(f"the turn of block {n} lies outside the interval of mu")
        if turn > low:
            found.append((f"block {n} stretches up to mu = {turn!r}", K * turn, c * l + c**2 * 3 / 4))
        if turn < high:
            if n == 1:
                raise Rejected("a block of one letter always occurs")
            found.append(_absent(n, turn, lam, l))
        c *= lam
        K += c
    n = len(turns) + 1
    if low > 0.0:
        return [*found, _absent(n, low, lam, l)]
    if not l == 0:
        raise Rejected("an interval that begins at 0 needs l = 0")
    return [*found, (f"K_{n} > 3: longer blocks stretch wherever they occur", arb(3), K)]


def _absent(n: int, mu: float, lam: Any, l: Any) -> Inequality:
    """Return the inequality that a block of n letters does not occur from mu on."""
    K = sum((lam**i for i in range(n - 1)), arb(0))
    return f"block {n} does not occur from mu = {mu!r} on", lam ** (n - 2) * (l + arb(mu).sqrt()), K * mu
