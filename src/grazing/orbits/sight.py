"""What a ball cannot meet next after a surface, and words of impacts that cannot repeat: proven, with the reason.

The normal n of a face points to its front. Along a flight the distance d = n.(p - P) - D of the ball's centre from the
line of a face obeys d'' = -g n_y. Just after an impact there d = 0 and d' > 0, so that for g n_y <= 0 the ball stays in
front of it; and just before an impact d = 0 and d' <= 0, so that for g n_y <= 0 it has been in front all along. On a
level table that holds for both sides of all faces, and a straight way that leaves a convex body does not come back.
Where one disc between two others reaches from one side of both to the other, every straight way between them meets it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

from grazing.billiard.objects import ARC, DISC
from grazing.billiard.table import Table
from grazing.orbits.bounces import Surface
from grazing.oscillator.reset import Reset, active_law, newton_law, triggered_law

#: What is nearer than this part of the sizes is not decided: rounding.
SLACK = 1e-13
#: Faces whose reflections leave a turn by less than this have orbits beside each other.
LEAN = 1e-9


def normal_of(face: Surface) -> tuple[float, float]:
    """Return the normal of a face."""
    return face.sign * face.ey, -face.sign * face.ex


def farthest(surface: Surface, nx: float, ny: float) -> float:
    """Return the largest n.p of the ball's centre p on a surface."""
    if surface.round:
        return nx * surface.x + ny * surface.y + surface.size  # of the whole circle: no less than that of a part
    mx, my = normal_of(surface)
    x, y = surface.x + surface.size * mx, surface.y + surface.size * my
    return max(nx * (x + s * surface.ex) + ny * (y + s * surface.ey) for s in (0.0, surface.high))


def behind(face: Surface, other: Surface, g: float) -> bool:
    """Whether no point of another surface is in front of a face whose front a flight does not change."""
    if face.round:
        return False
    nx, ny = normal_of(face)
    if g * ny > 0.0:
        return False
    if other.owner == face.owner and not other.round:
        return True
    reach = nx * face.x + ny * face.y + face.size
    size = abs(face.x) + abs(face.y) + face.size + abs(other.x) + abs(other.y) + other.size
    at_an_end = other.round and other.size == face.size and any(
        hypot(other.x - face.x - s * face.ex, other.y - face.y - s * face.ey) <= SLACK * size for s in (0.0, face.high)
    )  # fmt: skip
    return at_an_end or farthest(other, nx, ny) < reach - SLACK * size


def covered(table: Table, one: Surface, other: Surface) -> int:
    """Return a disc that every straight way from one disc to another meets between them, -1 for none.

    Such a way stays in the convex hull of both. The disc's chord across the line of centres, from one of the hull's
    tangents to the other, cuts it in two.
    """
    dx, dy = other.x - one.x, other.y - one.y
    far = hypot(dx, dy)
    if not (one.whole and other.whole and far > one.size + other.size):
        return -1
    ex, ey = dx / far, dy / far
    lean = (one.size - other.size) / far  # the outer tangents' normals are at angles +-acos(lean) from the line
    rise = (1.0 - lean * lean) ** 0.5
    for k, thing in enumerate(table.objects):
        if thing.kind != DISC or k in (one.owner, other.owner):
            continue
        x, y, radius = thing.shape["x"] - one.x, thing.shape["y"] - one.y, thing.shape["radius"] + table.rho
        along, beside = x * ex + y * ey, y * ex - x * ey
        between = one.size + SLACK * far < along < far - other.size - SLACK * far
        out = min(lean * along + rise * (radius + side * beside) for side in (1.0, -1.0))
        if between and out > one.size + SLACK * far:
            return k
    return -1


def unseen(table: Table, one: Surface, other: Surface) -> str:
    """Say why a ball cannot meet a surface next after another, as proven; empty if nothing forbids it."""
    g, names = table.gravity, table.names
    a, b = names[one.owner], names[other.owner]
    if behind(one, other, g) or behind(other, one, g):
        return f"{b} is not in front of {a}" if a != b else f"a flight from a side of {a} does not come back to it"
    if g == 0.0 and one.number == other.number and (not one.round or one.sign > 0.0):
        return f"a straight way that leaves {a} does not come back to it"
    disc = covered(table, one, other) if g == 0.0 else -1
    return f"{names[disc]} covers {b} from {a}" if disc >= 0 else ""


def gain_of(law: Reset | None) -> int | None:
    """Return 1 for a law of the library that gives energy at every impact, -1 for one that takes, 0 for neither."""
    if law is None or law.own:
        return None
    r, V = law.params["r"], law.params.get("V", 0.0)
    if law.law in (newton_law, active_law, triggered_law) and V == 0.0:
        return 0 if r == 1.0 else -1
    return 1 if r == 1.0 and law.law is active_law else None


def one_way(table: Table, owners: Sequence[int]) -> str:
    """Say why impacts with these objects do not repeat: they all give energy, or all take it; empty if they may."""
    gains = [gain_of(table.objects[owner].law) for owner in owners]
    if None in gains or not any(gains):
        return ""
    if min(gains) < 0 < max(gains):  # type: ignore[type-var, operator]
        return ""
    does = "take energy, and none gives any" if min(gains) < 0 else "give energy, and none takes any"  # type: ignore[type-var, operator]
    return f"the impacts {does}"


def one_at_most(table: Table, owners: Sequence[int]) -> bool:
    """Whether an isolated orbit of a word is its only one: elastic impacts on a level table between convex bodies.

    Each orbit is then a shortest closed way that visits the bodies in the order of the word: docs/table.md has the
    argument.
    """
    things = [table.objects[owner] for owner in owners]
    return table.gravity == 0.0 and all(one.kind != ARC and gain_of(one.law) == 0 for one in things)


def has_parallels(word: Sequence[Surface]) -> bool:
    """Whether elastic impacts with these surfaces, on a level table, have orbits beside each other: over faces only.

    Each face is reflected at those before it, so that ways become straight lines. All of these together must shift the
    plane, which an odd number does if gone round twice; orbits are the lines along the shift that meet each face from
    its front.
    """
    if len(word) % 2 == 1 or any(face.round for face in word):
        return False
    turn, shift, mirrored, seen = complex(1.0), complex(0.0), False, []
    for face in word:
        n, e = complex(*normal_of(face)), complex(face.ex, face.ey)
        start = complex(face.x, face.y) + face.size * n
        a, b, n = (z.conjugate() if mirrored else z for z in (start, start + face.high * e, n))
        a, b, n = shift + turn * a, shift + turn * b, turn * n
        over = (b - a) / (b - a).conjugate()
        turn, shift, mirrored = over * turn.conjugate(), a + over * (shift - a).conjugate(), not mirrored
        seen.append((a, b, n))
    size = max(abs(b - a) for a, b, _n in seen)
    if abs(turn - 1.0) > LEAN or abs(shift) <= LEAN * size:
        return False
    along = (shift / abs(shift)).conjugate()
    sides = [sorted(((along * a).imag, (along * b).imag)) for a, b, _n in seen]
    wide = min(high for _low, high in sides) - max(low for low, _high in sides)
    return wide > LEAN * size and all((along * n).real < 0.0 for _a, _b, n in seen)
