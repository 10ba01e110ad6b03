"""Stable and unstable manifolds of saddles of a map with two coordinates, cut where the map is not smooth."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.manifold_growth import FIRST, Image, Piece, Ruler, along, image_of
from grazing.orbits.manifold_saddle import Saddle, refuse_no_saddle, saddle_of, short_pieces
from grazing.orbits.manifold_steps import Backwards, Forwards, Leaves, Ray, Solved, Steps, traced
from grazing.orbits.orbit import Orbit
from grazing.orbits.word import spelled
from grazing.outcome import InputError
from grazing.parameter import checked_box, real, whole

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: The diagonal of a box, in sides of it.
DIAGONAL = math.sqrt(2.0)
#: Turns are taken together until they stretch the short piece by this.
STRETCH = 1.5
#: A branch is at its end when its last image is this part of a spacing long.
SETTLED = 1e-2
#: Images far outside the box after which a branch is given up.
PATIENCE = 12
#: Points computed for one image of the short piece, at most.
MOST = 400_000
#: How a branch ends, in words.
ENDS = {
    "length": "the length asked for",
    "settled": "it comes to an attractor, or backwards to a repeller: its images get ever shorter",
    "lost": "no point of it has an image, or a preimage, less than a million half widths of the box away",
    "away": "it has left the box for good",
    "steps": "the number of steps asked for",
    "points": "too many points: ask for less length, a larger spacing or a smaller box",
}


def manifolds(
    orbit: Orbit,
    side: str = "unstable",
    *,
    length: float | None = None,
    spacing: float | None = None,
    box: Any = None,
    steps: int = 1000,
) -> xr.Dataset:
    """Return the unstable or the stable manifold of a saddle, in pieces that are smooth.

    Parameters
    ----------
    orbit : Orbit
        A saddle of a map with two coordinates: one multiplier outside the unit circle and one inside, both real. Any
        period; see :func:`grazing.one_impact_orbits`.
    side : {"unstable", "stable"}
        The states that came from the saddle, or those that come to it.
    length : float, optional
        Arc length inside the box after which each branch is ended, in sides of the box: each coordinate is measured by
        its own side, so that no unit matters. Default: ten diagonals of the box, 14.1.
    spacing : float, optional
        Distance of neighbouring points, at most, in sides of the box; they are closer where the curve bends. Default:
        a 300th of the diagonal, 0.0047.
    box : ((low, high), (low, high)), optional
        What is drawn; a curve that leaves it is followed until it comes back. Default: the box of the map and the
        points of the orbit, twice as wide.
    steps : int
        Steps of the map from the saddle, at most, >= 1.

    Returns
    -------
    xarray.Dataset
        ``manifold`` (point, coordinate): the states, piece after piece with a row of NaN between two pieces. ``piece``
        (point) is a row of the table on dimension "piece": ``order``, the number of steps between the saddle's
        neighbourhood and the piece; ``start``, which point of the saddle is there; ``word``, the letters that the map
        writes on them, in the order of time; ``branch``; ``piece_length``; ``cut_first`` and ``cut_last``, whether
        the map is discontinuous or has a kink at that end or on its way. ``seed`` (point): with the ``start`` of the
        piece, ``saddle[start] + seed * direction[start]`` comes to the point in ``order`` steps, or the point comes
        to it. The table on dimension "branch", two for each point of the orbit: ``saddle_point``, ``sign``,
        ``branch_length`` and ``branch_end``, one of length settled lost away steps points (in words: attribute
        ``meaning``). ``saddle`` and ``direction`` (saddle_index, coordinate). All lengths are in sides of the box,
        and so a direction is one side long.

    Raises
    ------
    InputError
        For an orbit that is no saddle of a map with two coordinates, a virtual one, a law without an inverse on the
        stable side, or numbers that are not allowed.

    Notes
    -----
    The manifold is all images of a short straight piece along the eigenvector, in forward time or backward. That piece
    is so short that its own bend is less than 1e-4 of it, and the error it starts with, of second order in its length,
    shrinks with every turn by the other multiplier. New points are computed from the saddle on, never interpolated,
    where neighbours are farther apart than ``spacing``, or turn by more than 0.2, or a chord times its turn is more
    than 0.02 spacings. Where the letters of neighbours differ, or their distance does not shrink, their starts are
    bisected until they are neighbouring numbers: the curve ends there on both sides and no line joins them. On the
    side with the impact the curve comes to its end like a square root, so that its last point can be as far away as
    the root of the rounding error.

    Backwards the oscillator is flown from contact to contact and through every branch of the inverse law; a state
    that the law cannot make (a departure slower than the kick) ends the curve. The preimages of any other map are
    solved for by Newton's method along the curve; those that are not connected to the saddle by it are not found.
    Either way a point is kept only if the map takes it back, to 1e-8 relative. Preimages with more than 20 impacts in
    one period are left out.

    References
    ----------
    Hobson, J. Comput. Phys. 104 (1993) 14-22; Krauskopf and Osinga, J. Comput. Phys. 146 (1998) 404-419, whose
    criteria for distance and angle these are; Nordmark, J. Sound Vib. 145 (1991) 279-297, for the square root.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.manifold import manifolds
    >>> saddle = gz.one_impact_orbits(gz.pinball(d=0.105, V=0.4), 2)[-1]
    >>> grown = manifolds(saddle, "unstable", length=1.0)
    >>> grown.sizes["branch"], set(grown.branch_end.values.tolist()), grown.word.values[:3].tolist()
    (4, {'settled'}, ['', '01', '0101'])
    """
    refuse_no_saddle(orbit, side)
    frame = _box(orbit, box)
    saddle = saddle_of(orbit, side, frame[:, 1] - frame[:, 0])
    reach = 10.0 * DIAGONAL if length is None else _positive(length, "length")
    fine = DIAGONAL / 300.0 if spacing is None else _positive(spacing, "spacing")
    most = whole(steps, "steps", 1)
    grown, branches = _grown(saddle, Ruler(frame), reach, fine, most)
    return _dataset(saddle, grown, branches, {"length": reach, "spacing": fine, "box": frame.tolist(), "steps": most})


# ---- growth


class Branch:
    """One of the two ways from one point of a saddle: how long it is so far, the last image, and why it ended."""

    def __init__(self) -> None:
        self.length, self.last, self.empty, self.end = 0.0, 0.0, 0, ""

    def extend(self, image: Image, order: int, spacing: float) -> None:
        """Add an image and decide whether it is the last."""
        self.length += image.length
        self.empty = 0 if image.near else self.empty + 1
        if image.cut_short:
            self.end = "points"
        elif image.full:
            self.end = "length"
        elif not image.alive:
            self.end = "lost"
        elif self.empty > PATIENCE:
            self.end = "away"
        elif image.near and image.extent < min(SETTLED * spacing, self.last):
            self.end = "settled"
        self.last = image.extent if order > 0 else 0.0  # the first piece begins at the saddle and is longer


class Grown(NamedTuple):
    """A piece with the number of its branch, its order, the point its starts lie next to, and their distances."""

    branch: int
    order: int
    start: int
    piece: Piece
    seed: Floats


def _grown(saddle: Saddle, ruler: Ruler, reach: float, spacing: float, most: int) -> tuple[list[Grown], list[Branch]]:
    """Return all pieces of all branches, those of one branch in the order in which they were grown."""
    p = saddle.orbit.period
    # so many steps are taken together that they stretch the short piece by STRETCH
    stride = max(1, math.ceil(p * math.log(STRETCH) / math.log(saddle.stretch) - 1e-9))
    far = short_pieces(saddle)
    near = far * saddle.stretch ** (-stride / p)
    movers = _movers(saddle, far, stride)
    branches = {(point, sign): Branch() for point in range(p) for sign in (1, -1)}
    numbers = {key: number for number, key in enumerate(branches)}
    t = {key: np.linspace(0.0, 1.0, FIRST) for key in branches}
    leaves: dict[tuple[int, int], Leaves] = {}
    grown: list[Grown] = []
    for order in range(0, most + 1, stride):
        for start, sign in branches:
            to = saddle.reached(start, sign, order)
            branch = branches[to]
            if branch.end:
                continue
            distance = sign * np.array([0.0 if order == 0 else near[start], far[start]])
            room, steps, first = reach - branch.length, movers[start, sign], t[start, sign]
            if (start, sign) in leaves:  # from where they were at the order before
                here = steps.further(leaves[start, sign], order - leaves[start, sign].letters.shape[1])
            else:
                here = traced(steps, first, along(first, distance), order)
            image = image_of(steps, distance, order, first, here, ruler, spacing, room, MOST)
            if order > 0:
                t[start, sign], leaves[start, sign] = image.t, image.leaves
            grown += [Grown(numbers[to], order, start, one, along(one.t, distance)) for one in image.pieces]
            branch.extend(image, order, spacing)
        if all(branch.end for branch in branches.values()):
            break
    for branch in branches.values():
        branch.end = branch.end or "steps"
    return sorted(grown, key=lambda one: (one.branch, one.order)), list(branches.values())


def _movers(saddle: Saddle, far: Floats, stride: int) -> dict[tuple[int, int], Steps]:
    """Return what takes starts along the manifold, for both sides of each point of the saddle."""
    orbit, P = saddle.orbit, saddle.orbit.map
    movers: dict[tuple[int, int], Steps] = {}
    solved: dict[tuple[int, int], Solved] = {}

    def anchor_of(start: int, sign: int) -> Callable[[int], Floats | None]:
        def anchor(k: int) -> Floats | None:
            if k <= stride:  # still next to the saddle
                return np.asarray(orbit.points[(start - k) % orbit.period])
            # the image of the short piece begins where the one before ends
            point, side = saddle.reached(start, sign, stride)
            seeds, states, _images = solved[point, side].known.get(k - stride, (np.empty(0), np.empty((0, 2)), None))
            whole_piece = len(seeds) > 0 and seeds[-1] >= (1.0 - 1e-9) * far[point]
            return np.asarray(states[-1]) if whole_piece else None

        return anchor

    for start in range(orbit.period):
        for sign in (1, -1):
            ray = Ray(orbit.points[start], saddle.directions[start])
            if saddle.forwards:
                movers[start, sign] = Forwards(P, ray)
            elif P.model is not None and P.section == "strobe":
                movers[start, sign] = Backwards(P, ray, saddle.box)
            else:
                movers[start, sign] = solved[start, sign] = Solved(P, ray, saddle.box, anchor_of(start, sign))
    return movers


# ---- arguments


def _positive(value: Any, name: str) -> float:
    number = real(value, name, "allowed is a number > 0")
    if not number > 0.0:
        raise InputError(f"{name} = {number:g}; allowed is a number > 0")
    return number


def _box(orbit: Orbit, box: Any) -> Floats:
    """Return the box that is drawn, shape (2, 2), checked, or the default one."""
    if box is not None:
        return np.array(checked_box(box, tuple(orbit.map.coordinates)))
    own = np.array(orbit.map.box)
    low = np.minimum(own[:, 0], orbit.points.min(axis=0))
    high = np.maximum(own[:, 1], orbit.points.max(axis=0))
    middle, half = 0.5 * (low + high), high - low
    return np.column_stack([middle - half, middle + half])


# ---- result


def _dataset(saddle: Saddle, grown: list[Grown], branches: list[Branch], about: dict[str, Any]) -> xr.Dataset:
    """Return the pieces as a labelled table."""
    from grazing.late import xarray as xr

    orbit, P = saddle.orbit, saddle.orbit.map
    gap = np.full((1, 2), np.nan)
    rows, seeds, piece = [np.empty((0, 2))], [np.empty(0)], [np.empty(0, np.int64)]
    for number, one in enumerate(grown):
        last = number == len(grown) - 1
        rows += [one.piece.state] if last else [one.piece.state, gap]
        seeds += [one.seed] if last else [one.seed, gap[0, :1]]
        piece.append(np.full(len(one.piece.state) + (not last), number))
    words = np.array([spelled(one.piece.letters, P.letters) for one in grown], dtype=object)
    count, state = {"units": "1"}, P.origin.units_of(P.coordinates)
    ends = "; ".join(f"{end}: {said}" for end, said in ENDS.items())
    points = np.repeat(np.arange(orbit.period), 2)

    def column(dimension: str, values: Any, dtype: Any, long_name: str, **more: str) -> Any:
        return dimension, np.array(values, dtype), {"long_name": long_name, **more}

    variables = {
        "manifold": (
            ("point", "coordinate"),
            np.concatenate(rows),
            {"long_name": f"{saddle.side} manifold", "units": state},
        ),
        "piece": column("point", np.concatenate(piece), np.int64, "row of the table of pieces", **count),
        "seed": column("point", np.concatenate(seeds), np.float64, "distance of the start, in directions", **count),
        "order": column("piece", [g.order for g in grown], np.int64, "steps from the neighbourhood of the saddle"),
        "start": column("piece", [g.start for g in grown], np.int64, "point of the saddle next to the starts"),
        "word": ("piece", words, {"long_name": "letters on these steps, in the order of time"}),
        "branch": column("piece", [g.branch for g in grown], np.int64, "row of the table of branches"),
        "piece_length": column(
            "piece", [g.piece.length for g in grown], np.float64, "length, in sides of the box", **count
        ),
        "cut_first": column("piece", [g.piece.cut[0] for g in grown], bool, "not smooth at the first point"),
        "cut_last": column("piece", [g.piece.cut[1] for g in grown], bool, "not smooth at the last point"),
        "saddle_point": column("branch", points, np.int64, "point of the saddle that the branch leaves"),
        "sign": column("branch", [1, -1] * orbit.period, np.int64, "of the seeds next to that point"),
        "branch_length": column("branch", [b.length for b in branches], np.float64, "length in the box, in its sides"),
        "branch_end": column("branch", [b.end for b in branches], "<U8", "why the branch ends", meaning=ends),
        "saddle": (("saddle_index", "coordinate"), np.array(orbit.points), {"long_name": "the saddle", "units": state}),
        "box": (("coordinate", "end"), np.array(about["box"]), {"long_name": "what is drawn", "units": state}),
        "direction": (
            ("saddle_index", "coordinate"),
            saddle.directions,
            {"long_name": f"{saddle.side} direction, one side of the box long", "units": state},
        ),
    }
    config = {"side": saddle.side, "params": dict(P.params), "points": orbit.points.tolist(), **about}
    attributes = {
        "title": f"{saddle.side} manifold of a saddle of the {P.name}",
        "side": saddle.side,
        "multiplier": saddle.multiplier,
        "period": orbit.period,
        "orbit_word": orbit.word,
        "box": np.array(about["box"]).ravel(),
        "model": repr(P),
        "parameters": json.dumps(dict(P.params)),
        "grazing_config": json.dumps(config, sort_keys=True, separators=(",", ":"), allow_nan=False),
        "arithmetic": "strict",
        **P.origin.attributes,
    }
    return xr.Dataset(variables, {"coordinate": list(P.coordinates)}, attributes)
