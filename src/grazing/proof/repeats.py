"""What is proven of how an orbit repeats itself: no shorter period, and that it is its own mirror image."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from grazing.proof.equations import Equations
from grazing_checker.walls import mirrored

if TYPE_CHECKING:
    from flint import arb


def shift_margins(equations: Equations, box: list[arb]) -> dict[int, arb]:
    """Return for every prime q that divides n how far the orbit is from one of period N T/q.

    A period N T/q takes n/q impacts, each to one at the same wall and with the same velocity after it; where the walls
    differ nothing is left to show. Whether q divides N is no matter: the forcing may itself have a period T/g.
    """
    n, hits, flow = equations.n, equations.hits, equations.flow(box)
    turn = equations.N * flow.T
    speeds = []
    for hit, t, w in zip(hits, box[:n], box[n:], strict=True) if n else ():
        rate = flow.seen.at(hit, t)[1].x
        speeds.append(rate + int(flow.seen.walls[hit].sign) * w)
    found: dict[int, arb] = {}
    for q in (q for q in range(2, n + 1) if n % q == 0 and all(q % p for p in range(2, q))):
        if hits != (*hits[n // q :], *hits[: n // q]):
            continue
        apart = []
        for i in range(n):
            laps, j = divmod(i + n // q, n)
            apart += [abs(box[j] + laps * turn - box[i] - turn / q), abs(speeds[j] - speeds[i])]
        found[q] = max((x.lower() for x in apart), key=float)
    return found


def is_own_image(
    equations: Equations, model: dict[str, Any], centre: list[arb], unique: list[arb], box: list[arb]
) -> bool:  # fmt: skip
    """Return whether an orbit is proven to be its own mirror image, half of its period later at the other walls.

    ``model`` is what the certificate says of the model; the image is an orbit only if that is exactly symmetric.
    """
    n, half = equations.n, equations.n // 2
    if n % 2 or equations.N % 2 == 0 or not mirrored(model):
        return False
    if equations.hits[half:] != tuple(1 - hit for hit in equations.hits[:half]):
        return False
    shift = equations.N * equations.flow(box).T / 2
    image = [box[(i + half) % n] - (shift if i < half else -shift) for i in range(n)]
    image += [box[n + (i + half) % n] for i in range(n)]
    return all(bool(abs(a - c) < u / 2) for a, c, u in zip(image, centre, unique, strict=True)) if n else True
