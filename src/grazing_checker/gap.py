"""Check certificates about the gap map: a periodic orbit, an edge of a word, mu without attracting orbits.

The gap map is ``x -> lam x + mu`` for x < 0 (letter L) and ``x -> mu - l - sqrt(x)`` for x >= 0 (letter R). Let s_i be
the roots of the points with letter R, in the order of the word. A point that comes q letters L after the image of
s_(i-1)^2 is ``K_q mu - lam^q (l + s_(i-1))`` with ``K_q = 1 + lam + ... + lam^q``. One with letter R is also s_i^2, and
these equations for all i are those of a periodic orbit of the word, for any real lam, mu and l.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from grazing_checker.balls import Ball, around, double, number, precision
from grazing_checker.reading import Inequalities, decimal, demand, exact, keys, numbers, text_of_double, within

#: Bits of the balls.
BITS = 160
#: Most letters of a word, most letters R of them, and most blocks that are gone through for an interval of mu.
LETTERS, ROOTS, BLOCKS = 1000, 300, 5000
ORBIT = ("lam", "mu", "l", "word", "centre", "radius", "unique", "preconditioner", "claims")
EDGE = ("lam", "l", "word", "edge", "at", "centre", "radius", "unique", "preconditioner", "claims")
NO_ATTRACTOR = ("lam", "l", "low", "high", "turns")
#: What the equation of an edge says, in words.
EVENTS = {
    "gr": "point {at} of it, with letter R, is 0 (graze)",
    "bc": "point {at} of it, with letter L, is 0 (border collision)",
    "pd": "its multiplier is -1 (as at a period doubling)",
    "lp": "its multiplier is +1 (as at a fold)",
}
MAP = "the gap map, x -> lam x + mu for x < 0 (letter L) and x -> mu - l - sqrt(x) for x >= 0 (letter R),"
EXACTLY = "taken as these exact doubles,"

Row = dict[int, Ball]


def check_gap_orbit(data: Mapping[str, Any], inequalities: Any) -> str:
    """Verify a certificate of a periodic orbit of the gap map and return the sentence that it proves.

    Theorem. Let lam, mu, l be real, F the equations of a word w (above) with k letters R, Y a k by k matrix, m a point,
    0 < r < u, and D an enclosure of the derivative of F over the box of points within u of m (maximum norm). Suppose

    1. ``|Y F(m)|_i + sum_j |I - Y D|_ij r < r`` for all i;
    2. for all roots within r of m: every s_i > 0, every point with letter L is < 0;
    3. w is primitive, or twice a primitive word with s_i != s_(i + k/2) for one i and all roots within r of m.

    Then F has exactly one zero within u of m, and it lies within r. It is a periodic orbit of the gap map of word w and
    least period ``len(w)``; its multiplier is the product of ``-lam^q/(2 s_i)``; it is asymptotically stable if that is
    inside (-1, 1), unstable if it is outside [-1, 1].

    Proof. As r > 0, (1) gives row sums of |I - Y D| below 1. So Y and all matrices in D are regular: a rank-deficient Y
    has a row sum of at least 1. ``x -> x - Y F(x)`` then contracts on the box of half-width u, where it has one fixed
    point at most, and maps the box of half-width r into itself (Krawczyk): so it has one there, a zero of F. By (2)
    the map takes the branch of each letter. The least period d divides len(w), and the letters repeat after d, so d
    is a multiple of the length of the primitive word; (3) excludes the half of len(w). No word that repeats a
    primitive one more often has an orbit: on the points of that word the map is monotone after it.
    """
    keys(data, ORBIT, "the data")
    keys(data["claims"], ("roots", "apart", "multiplier", "stable"), "the claims")
    with precision(BITS):
        rows = Inequalities(inequalities)
        orbit_rows(data, rows)
        rows.finish()
    return orbit_sentence(data)


def check_gap_edge(data: Mapping[str, Any], inequalities: Any) -> str:
    """Verify a certificate of an edge of a word of the gap map and return the sentence that it proves.

    Theorem. Let lam, l be real, w a primitive word, and mu an unknown beside the k roots. Let G be the equations of w
    and one more: a root is 0 (gr), a point with letter L is 0 (bc), ``prod 2 s_i = -(-1)^k prod lam^q`` (pd), or
    ``prod 2 s_i = (-1)^k prod lam^q`` (lp). With Y, m, 0 < r < u and D as for an orbit, of size k + 1, suppose (1), and
    (2) for all points but the one that the equation puts to 0. Then G has exactly one zero within u of m, within r. It
    is a cycle of word w under the two branches, of least period ``len(w)``, and has what its last equation says: as all
    s_i > 0 for pd and lp, the products are those of its multiplier -1 or +1.

    That the cycle doubles or folds, beyond its multiplier, is not claimed. A point with letter L at 0 is continued by
    the branch of L: it is the limit of points left of the border.
    """
    keys(data, EDGE, "the data")
    keys(data["claims"], ("roots", "apart", "value"), "the claims")
    with precision(BITS):
        rows = Inequalities(inequalities)
        edge_rows(data, rows)
        rows.finish()
    return edge_sentence(data)


def check_no_attractor(data: Mapping[str, Any], inequalities: Any) -> str:
    """Verify a certificate that no periodic orbit of the gap map attracts, and return the sentence that it proves.

    Theorem. Let 0 < lam < 1, l >= 0, 0 <= low < high, mu in [low, high] and mu > 0. With ``c = lam^(n-1)`` and
    ``K_n = 1 + ... + lam^(n-1)`` suppose, for blocks of n = 1, ..., B letters, B >= 1, and turns t_n in [low, high],

    1. ``K_n t_n < c l + 3 c^2/4`` if t_n > low,
    2. ``K_(n-1) t_n > lam^(n-2) (l + sqrt(t_n))`` and n > 1 if t_n < high,

    and for n = B + 1 either (2) at low > 0, or low = l = 0 and K_n > 3. Then every periodic orbit has a multiplier of
    modulus above 1 (infinite where a root is 0), so that none attracts; also with either letter at a point that is 0.

    Proof. As mu > 0 and 0 < lam < 1, no orbit stays left of 0; as l >= 0, a point right of it is at most mu. So a
    periodic orbit consists of blocks L^(n-1) R from one root s <= sqrt(mu) to the next, ``s'^2 = C - c s`` with
    ``C = K_n mu - c l``. A block multiplies the length ``sqrt(s) ds`` by ``c/(2 sqrt(s s'))``, and round an orbit these
    factors multiply to its multiplier. ``c s s' = s' (C - s'^2) <= 2 (C/3)^(3/2)`` makes each at least
    ``(3 c^2/(4 C))^(3/4)``, above 1 if ``K_n mu < c l + 3 c^2/4``: by (1) for mu <= t_n. A block of n > 1 letters needs
    its point n - 1 to be <= 0 for some s, hence for the greatest, sqrt(mu): ``K_(n-1) mu <= lam^(n-2) (l + sqrt(mu))``.
    (2) denies that at t_n, hence for all greater mu, and for all longer blocks, as points go on to rise. So all blocks
    to B stretch or do not occur, and those beyond do not occur if low > 0. At low = l = 0 one that occurs has
    ``sqrt(mu) <= c/(K_n - 1)``, and stretches because ``(3 K_n - 1)(K_n - 3) > 0``; longer blocks have a greater K_n.
    """
    keys(data, NO_ATTRACTOR, "the data")
    with precision(BITS):
        rows = Inequalities(inequalities)
        no_attractor_rows(data, rows)
        rows.finish()
    return no_attractor_sentence(data)


# The word, and where its points are


class Place(NamedTuple):
    """How a point follows: the number of the last root before it, and the letters L in between."""

    root: int
    q: int


class Word:
    """A word with an R, and the place of each of its points."""

    def __init__(self, letters: Any) -> None:
        demand(
            isinstance(letters, str) and 1 <= len(letters) <= LETTERS and set(letters) <= {"L", "R"} and "R" in letters,
            f"the word is not one of 1 to {LETTERS} letters L and R with an R",
        )
        demand(letters.count("R") <= ROOTS, f"the word has more than {ROOTS} letters R")
        self.letters: str = letters
        self.least = (letters + letters).index(letters, 1)
        rights = [j for j, letter in enumerate(letters) if letter == "R"]
        self.k = len(rights)
        self.places: list[Place] = []
        before, last = -1, rights[-1] - len(letters)
        for j, letter in enumerate(letters):
            self.places.append(Place(before % self.k, j - last - 1))
            if letter == "R":
                before, last = before + 1, j
        self.ends = [self.places[j] for j in rights]

    def letter(self, number: Any) -> str:
        """Return the letter of a point, counted from 1; empty if there is none."""
        return self.letters[number - 1] if type(number) is int and 1 <= number <= len(self.letters) else ""


class Powers:
    """lam^q and K_q = 1 + ... + lam^q of a word."""

    def __init__(self, word: Word, lam: Ball) -> None:
        self.c, self.K = [number(1)], [number(1)]
        for _ in range(max(place.q for place in word.places)):
            self.c.append(self.c[-1] * lam)
            self.K.append(self.K[-1] + self.c[-1])

    def point(self, place: Place, s: list[Ball], mu: Ball, l: Ball) -> Ball:
        """Return the point at a place."""
        return self.K[place.q] * mu - self.c[place.q] * (l + s[place.root])

    def product(self, word: Word) -> Ball:
        """Return the product of -lam^q over all blocks: the multiplier times the product of all 2 s_i."""
        product = number(1)
        for place in word.ends:
            product *= -self.c[place.q]
        return product


def equations(word: Word, powers: Powers, s: list[Ball], mu: Ball, l: Ball) -> list[Ball]:
    """Return what vanishes at an orbit of a word, one equation for every root."""
    return [root * root - powers.point(place, s, mu, l) for root, place in zip(s, word.ends, strict=True)]


def slopes(word: Word, powers: Powers, s: list[Ball]) -> list[Row]:
    """Return the derivatives of the equations by roots and, in column k, by mu."""
    D: list[Row] = []
    for i, place in enumerate(word.ends):
        row = {i: 2 * s[i]}
        row[place.root] = row.get(place.root, number(0)) + powers.c[place.q]
        D.append({**row, word.k: -powers.K[place.q]})
    return D


def without_mu(D: list[Row]) -> list[Row]:
    """Return the derivatives by the roots only."""
    return [{j: x for j, x in row.items() if j < len(D)} for row in D]


# Krawczyk's test, shared by orbits and edges


class Boxes(NamedTuple):
    """What a certificate encloses: a centre, the half-width of existence and that of uniqueness, and a matrix."""

    centre: list[Ball]
    radius: Ball
    unique: Ball
    Y: list[list[Ball]]

    def around(self, half: Ball) -> list[Ball]:
        """Return the box of some half-width about the centre."""
        return [around(m, half) for m in self.centre]


def _boxes(data: Mapping[str, Any], size: int) -> Boxes:
    """Return the boxes of a certificate, of the right size and sign."""
    centre, radius, unique = numbers(data["centre"], size, "the centre"), exact(data["radius"]), exact(data["unique"])
    demand(radius > 0 and unique > radius, "the radii are not 0 < radius < unique")
    rows = data["preconditioner"]
    shaped = isinstance(rows, list) and len(rows) == size and all(isinstance(r, list) and len(r) == size for r in rows)
    demand(shaped, f"the preconditioner is no {size} by {size} matrix")
    return Boxes(centre, radius, unique, [[double(text_of_double(entry)) for entry in row] for row in rows])


def spreads(Y: list[list[Ball]], D: list[Row]) -> list[Ball]:
    """Return bounds on the row sums of |I - Y D|."""
    sums = []
    for i, y in enumerate(Y):
        entries = {i: number(1)}
        for factor, row in zip(y, D, strict=True):
            for j, slope in row.items():
                entries[j] = entries.get(j, number(0)) - factor * slope
        sums.append(sum((abs(entry).upper() for entry in entries.values()), number(0)).upper())
    return sums


def _one_zero(boxes: Boxes, F: list[Ball], D: list[Row], data: Mapping[str, Any], rows: Any) -> None:
    """Verify |Y F(m)| + |I - Y D| r < r, with D over the box of uniqueness: one zero there, and it is within r."""
    for i, (y, spread) in enumerate(zip(boxes.Y, spreads(boxes.Y, D), strict=True)):
        shift = sum((factor * value for factor, value in zip(y, F, strict=True)), number(0))
        image = abs(shift).upper() + spread * boxes.radius
        rows.less(f"existence and uniqueness, coordinate {i + 1}", image, data["radius"])


def _claimed(boxes: Boxes, s: list[Ball], claims: Mapping[str, Any]) -> None:
    """Verify the roots that are claimed, and how far away the next solution is at least."""
    demand(isinstance(claims["roots"], list) and len(claims["roots"]) == len(s), "the roots claimed are not complete")
    for i, (root, texts) in enumerate(zip(s, claims["roots"], strict=True)):
        within(root, texts, f"root {i + 1}")
    apart, gap = decimal(claims["apart"]), boxes.unique - boxes.radius
    demand(apart > 0 and apart <= gap, "the solution is not proven to be alone within the distance claimed")


def _sides(word: Word, powers: Powers, s: list[Ball], mu: Ball, l: Ball, at: int, rows: Any) -> None:
    """Verify that every point but that of number ``at`` is strictly on the side of its letter."""
    i = 0
    for j, (letter, place) in enumerate(zip(word.letters, word.places, strict=True), start=1):
        if letter == "R":
            if j != at:
                rows.more(f"root of point {j}", s[i])
            i += 1
        elif j != at:
            rows.less(f"point {j}", powers.point(place, s, mu, l))


def orbit_rows(data: Mapping[str, Any], rows: Any) -> None:
    """Verify the data of a periodic orbit; ``rows`` verifies its inequalities, or writes them down."""
    word, claims = Word(data["word"]), data["claims"]
    k = word.k
    lam, mu, l = (double(text_of_double(data[name])) for name in ("lam", "mu", "l"))
    boxes, powers = _boxes(data, k), Powers(word, lam)
    D = without_mu(slopes(word, powers, boxes.around(boxes.unique)))
    _one_zero(boxes, equations(word, powers, boxes.centre, mu, l), D, data, rows)
    s = boxes.around(boxes.radius)
    _sides(word, powers, s, mu, l, 0, rows)
    demand(word.least in (len(word.letters), len(word.letters) / 2), "the word repeats a shorter one more than twice")
    if word.least < len(word.letters):
        gaps = [abs(s[i] - s[i - k // 2]).lower() for i in range(k)]
        rows.more("distance of the two halves of the orbit", max(gaps))
    multiplier = powers.product(word)
    for root in s:
        multiplier /= 2 * root
    within(multiplier, claims["multiplier"], "the multiplier")
    demand(claims["stable"] is True or claims["stable"] is False, "stable is not true or false")
    if claims["stable"]:
        rows.more("1 + multiplier", 1 + multiplier)
        rows.more("1 - multiplier", 1 - multiplier)
    else:
        rows.more("modulus of the multiplier - 1", abs(multiplier) - 1)
    _claimed(boxes, s, claims)


def edge_rows(data: Mapping[str, Any], rows: Any) -> None:
    """Verify the data of an edge; ``rows`` verifies its inequalities, or writes them down."""
    word, claims, kind, at = Word(data["word"]), data["claims"], data["edge"], data["at"]
    k = word.k
    demand(word.least == len(word.letters), "the word of an edge repeats a shorter one")
    demand(isinstance(kind, str) and kind in EVENTS, f"the edge is not one of {', '.join(EVENTS)}")
    letter = {"gr": "R", "bc": "L"}.get(kind, "")
    demand(word.letter(at) == letter if letter else type(at) is int and at == 0, "the edge has no such point")
    lam, l = (double(text_of_double(data[name])) for name in ("lam", "l"))
    boxes, powers = _boxes(data, k + 1), Powers(word, lam)
    z, wide = boxes.centre, boxes.around(boxes.unique)
    F, D = equations(word, powers, z[:k], z[k], l), slopes(word, powers, wide[:k])
    value, row = event(word, powers, kind, at, z, wide, l)
    _one_zero(boxes, [*F, value], [*D, row], data, rows)
    box = boxes.around(boxes.radius)
    _sides(word, powers, box[:k], box[k], l, at, rows)
    within(box[k], claims["value"], "the value")
    _claimed(boxes, box[:k], claims)


def event(word: Word, powers: Powers, kind: str, at: int, z: list[Ball], wide: list[Ball], l: Ball) -> tuple[Ball, Row]:
    """Return the last equation of an edge at a point z, and its derivative over a box."""
    k = word.k
    if kind == "gr":
        i = word.letters[: at - 1].count("R")
        return z[i], {i: number(1)}
    if kind == "bc":
        place = word.places[at - 1]
        return powers.point(place, z[:k], z[k], l), {place.root: -powers.c[place.q], k: powers.K[place.q]}
    # the product of all 2 s_i, less that of all -lam^q divided by the multiplier -1 or +1
    value, slopes = number(1), {}
    for root in z[:k]:
        value *= 2 * root
    for i in range(k):
        slopes[i] = number(2)
        for j in range(k):
            if j != i:
                slopes[i] *= 2 * wide[j]
    limit = powers.product(word)
    return (value + limit if kind == "pd" else value - limit), slopes


def no_attractor_rows(data: Mapping[str, Any], rows: Any) -> None:
    """Verify the data of an interval of mu; ``rows`` verifies its inequalities, or writes them down."""
    lam, l, low, high = (text_of_double(data[name]) for name in ("lam", "l", "low", "high"))
    demand(0.0 < lam < 1.0, "lam is not between 0 and 1")
    demand(l >= 0.0, "l is negative")
    demand(0.0 <= low < high, "the interval is not 0 <= low < high")
    demand(isinstance(data["turns"], list) and 1 <= len(data["turns"]) <= BLOCKS, f"there are not 1 to {BLOCKS} turns")
    turns = [text_of_double(text) for text in data["turns"]]
    a, gap = double(lam), double(l)
    c, K, c_before, K_before = number(1), number(1), number(0), number(0)

    def absent(mu: float) -> Ball:
        return K_before * double(mu) - c_before * (gap + double(mu).sqrt())

    for n, turn in enumerate(turns, start=1):
        demand(low <= turn <= high, f"the turn of block {n} lies outside the interval of mu")
        demand(n > 1 or turn == high, "a block of one letter always occurs")
        if turn > low:
            rows.more(f"block {n} stretches up to its turn", c * gap + c * c * 3 / 4 - K * double(turn))
        if turn < high:
            rows.more(f"block {n} does not occur from its turn on", absent(turn))
        c_before, K_before = c, K
        c *= a
        K += c
    n = len(turns) + 1
    if low > 0.0:
        rows.more(f"block {n} does not occur from low on", absent(low))
    else:
        demand(l == 0.0, "an interval that begins at 0 needs l = 0")
        rows.more(f"K_{n} - 3", K - 3)


# Sentences, from data that hold


def orbit_sentence(data: Mapping[str, Any]) -> str:
    """Return what a certificate of a periodic orbit proves."""
    lam, mu, l = (text_of_double(data[name]) for name in ("lam", "mu", "l"))
    word, claims = data["word"], data["claims"]
    low, high = claims["multiplier"]
    return (
        f"For lam = {lam!r}, mu = {mu!r}, l = {l!r}, {EXACTLY} {MAP} has a periodic orbit of word {word} and least "
        f"period {len(word)}; the roots of its points with letter R, in the order of the word, are {_roots(claims)}; "
        f"no other orbit of this word has all its roots within {claims['apart']} of these; its multiplier lies in "
        f"[{low}, {high}], so that it is {'asymptotically stable' if claims['stable'] else 'unstable'}."
    )


def edge_sentence(data: Mapping[str, Any]) -> str:
    """Return what a certificate of an edge proves."""
    lam, l = (text_of_double(data[name]) for name in ("lam", "l"))
    word, claims, event = data["word"], data["claims"], EVENTS[data["edge"]].format(at=data["at"])
    low, high = claims["value"]
    other = "other " if data["at"] else ""
    return (
        f"For lam = {lam!r}, l = {l!r}, {EXACTLY} there is a mu in [{low}, {high}] at which a cycle of word {word} and "
        f"least period {len(word)} under the branches of {MAP} is such that {event}; all its {other}points lie "
        "strictly on the side of their letter; the roots of its points with letter R, in the order of the word, are "
        f"{_roots(claims)}; no other mu with such a cycle has mu and all roots within {claims['apart']} of these."
    )


def no_attractor_sentence(data: Mapping[str, Any]) -> str:
    """Return what a certificate of an interval of mu proves."""
    lam, l, low, high = (text_of_double(data[name]) for name in ("lam", "l", "low", "high"))
    start = "(" if low == 0.0 else "["
    return (
        f"For lam = {lam!r}, l = {l!r} and every mu in {start}{low!r}, {high!r}], all {EXACTLY} {MAP} has no "
        "attracting periodic orbit: every periodic orbit has a multiplier of modulus above 1, or meets 0, where the "
        "slope of its letter R is infinite."
    )


def _roots(claims: Mapping[str, Any]) -> str:
    return ", ".join(f"s_{i} in [{low}, {high}]" for i, (low, high) in enumerate(claims["roots"], start=1))
