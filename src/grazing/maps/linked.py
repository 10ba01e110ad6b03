"""Changes along the sides of cells, linked to curves: cell by cell, and finer where it is not clear how."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import hypot
from typing import NamedTuple

from grazing.maps.borders import ANGLE, SPEED, Borders, Box, Change, Side

#: How often a cell is halved at most.
DEPTH = 4
#: Changes on the outline of a cell of which all ways to link them are compared.
MATCHED = 8
Place = tuple[int, int, int]
#: A change on the outline of a cell, whether the object is hit behind it, counterclockwise, and on which side it is.
Met = tuple[Change, bool, int]


class Curve(NamedTuple):
    """Changes in a row, with the launches that hit on the left; the first one once more at the end if it is closed."""

    changes: list[Change]
    closed: bool


def curves_of(borders: Borders, cells: tuple[int, int], asked: Callable[[Change], bool]) -> list[Curve]:
    """Find the changes that are asked for on a grid of cells, and link them to curves."""
    size = 2**DEPTH
    leaves = {(i * size, j * size, size) for i in range(cells[0]) for j in range(cells[1])}
    borders.search(side for cell in sorted(leaves) for side in sides_of(cell))
    probed: set[Place] = set()
    looked = leaves
    while unclear := sorted(cell for cell in looked if not _clear(_met(borders, cell, asked))):
        borders.news.clear()
        coarse = [cell for cell in unclear if cell[2] > 1]
        borders.split(side for cell in coarse for side in sides_of(cell))
        finer = [part for cell in coarse for part in _quarters(cell)]
        borders.search(side for part in finer for side in sides_of(part))
        leaves = (leaves - set(coarse)).union(finer)
        fine = [cell for cell in unclear if cell[2] == 1]
        borders.probe(side for cell in fine for side in sides_of(cell))
        probed |= set(fine)
        # what is new on a side may make its other cell unclear
        looked = leaves.intersection(finer + [cell for side in borders.news for cell in _beside(side)]) - probed
    links = [link for cell in sorted(leaves) for link in _links(_met(borders, cell, asked), borders.box)]
    following = dict(links)
    back = {one for one, other in links if following.get(other) is one}  # a strip too thin to be seen beside this side
    following = {one: other for one, other in links if one not in back}
    return list(_chained([one for one in borders.all() if asked(one)], following))


def sides_of(cell: Place) -> tuple[Side, Side, Side, Side]:
    """Return the sides of a cell: below, right, above, left."""
    i, j, size = cell
    return (
        (ANGLE, j, i, i + size), (SPEED, i + size, j, j + size), (ANGLE, j + size, i, i + size), (SPEED, i, j, j + size)
    )  # fmt: skip


def _beside(side: Side) -> list[Place]:
    """Return the cells of all sizes that a side may belong to."""
    axis, across, low, high = side
    sizes = [size for size in (2**k for k in range(DEPTH + 1)) if size >= high - low]
    places = [(low // size * size, k // size * size, size) for size in sizes for k in (across, across - 1)]
    return places if axis == ANGLE else [(j, i, size) for i, j, size in places]


def _quarters(cell: Place) -> list[Place]:
    i, j, size = cell
    half = size // 2
    return [(i + a, j + b, half) for a in (0, half) for b in (0, half)]


def _met(borders: Borders, cell: Place, asked: Callable[[Change], bool]) -> dict[object, list[Met]]:
    """Return the changes on the outline of a cell, counterclockwise, by what they have in common."""
    found: dict[object, list[Met]] = {}
    for number, side in enumerate(sides_of(cell)):
        changes = borders.changes(side)
        for one in changes if number < 2 else reversed(changes):
            if asked(one):
                found.setdefault(one.label, []).append((one, one.hit_above == (number < 2), number))
    return found


def _clear(met: dict[object, list[Met]]) -> bool:
    """Say whether there is one way only to link what is met: curves come in on a side and go out on another."""
    for one in met.values():
        sides = [side for _change, _behind, side in one]
        turns = all(one[k - 1][1] != one[k][1] for k in range(len(one)))
        if len(set(sides)) != 2 or sides.count(sides[0]) * 2 != len(sides) or not turns:
            return False
    return True


def _links(met: dict[object, list[Met]], box: Box) -> Iterator[tuple[Change, Change]]:
    """Give pairs that are linked, hits on the left."""
    for left in met.values():
        while len(left) > MATCHED or len(left) % 2:  # the nearest ones first, and what remains is the end of a curve
            pairs = [(left[k - 1], left[k]) for k in range(len(left)) if left[k - 1][1] != left[k][1]]
            if not pairs:
                break
            pair = min(pairs, key=lambda two: _apart(two[0], two[1], box))
            yield _directed(*pair)
            left = [one for one in left if one not in pair]
        best = min(_matchings(left), key=lambda pairs: _cost(pairs, box), default=[])
        yield from (_directed(*pair) for pair in best)


def _matchings(ring: list[Met]) -> Iterator[list[tuple[Met, Met]]]:
    """Give all ways to link changes on the outline of a cell that do not cross."""
    if not ring:
        yield []
    for k in range(1, len(ring), 2):
        if ring[0][1] != ring[k][1]:
            for inner in _matchings(ring[1:k]):
                yield from ([(ring[0], ring[k]), *inner, *outer] for outer in _matchings(ring[k + 1 :]))


def _directed(one: Met, other: Met) -> tuple[Change, Change]:
    return (other[0], one[0]) if one[1] else (one[0], other[0])


def _apart(one: Met, other: Met, box: Box) -> tuple[bool, float]:
    """Return whether two changes are on one side, and their distance in sides of the box."""
    places = zip(one[0].place, other[0].place, box, strict=True)
    return one[2] == other[2], hypot(*((a - b) / (high - low) for a, b, (low, high) in places))


def _cost(pairs: list[tuple[Met, Met]], box: Box) -> tuple[int, float]:
    """Return how many pairs are on one side, as a strip is that goes through the cell, and how long all links are."""
    each = [_apart(*pair, box) for pair in pairs]
    return sum(same for same, _length in each), sum(length for _same, length in each)


def _chained(changes: list[Change], following: dict[Change, Change]) -> Iterator[Curve]:
    """Give the curves that links make, open ones first, and changes that nothing is linked to."""
    reached, left = set(following.values()), dict.fromkeys(changes)
    for start in [*(one for one in changes if one not in reached), *changes]:
        chain, at = [], start
        while at in left:
            chain.append(at)
            del left[at]
            at = following.get(at, at)
        if chain:
            closed = len(chain) > 1 and at is chain[0]
            yield Curve(chain + chain[:1] if closed else chain, closed)
