"""A branch as a labelled table: what figures are drawn from and files hold."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.orbits.impact_orbit import ImpactOrbit
from grazing.orbits.piece_orbit import PieceOrbit
from grazing.orbits.special import SPECIAL

if TYPE_CHECKING:
    import xarray as xr

    from grazing.orbits.branch import Branch
    from grazing.orbits.branch_search import Piece
    from grazing.orbits.orbit import Orbit
    from grazing.orbits.special import Special

#: Special points of two pieces that are nearer, as a share of the range, are one.
SAME = 1e-9


def shifts(piece: Piece) -> NDArray[np.int64]:
    """Return by how many periods each orbit's points are numbered later than along the branch."""
    at = zip(piece.unknowns, piece.values[:, None], strict=True)
    return np.array([piece.equations.begins_in(x, p) for x, p in at], np.int64)


def events_of(branch: Branch) -> NDArray[np.int8]:
    """Return for each orbit whether it is one at a special point, on the edge of what is before and after."""
    flags = []
    for piece in branch.pieces:
        one = np.zeros(len(piece.orbits), np.int8)
        one[list(piece.events)] = 1
        flags.append(one)
    return _joined(flags, np.int8)


def _joined(parts: list[NDArray[Any]], kind: type) -> NDArray[Any]:
    """Return arrays as one: of a branch without pieces none, of the same kind."""
    return np.concatenate(parts) if parts else np.empty(0, kind)


def impact_columns(orbits: Sequence[Orbit], rolls: NDArray[np.int64]) -> dict[str, Any]:
    """Return one row for each impact of orbits: the number of its orbit, when it comes, and how fast.

    ``rolls`` are the periods by which each orbit's points are numbered later than its times say, see :func:`shifts`.
    """
    hit = [(i, one) for i, one in enumerate(orbits) if isinstance(one, ImpactOrbit)]

    def column(values: list[NDArray[Any]], name: str) -> Any:
        return "impact", _joined(values, np.float64), hit[0][1].model.describe(name).attributes if hit else {}

    rows = [np.full(one.impacts, i) for i, one in hit]
    walls = np.array([letter for _i, one in hit for letter in one.walls], dtype=object)
    named = bool(hit) and hit[0][1].model.walled
    return {
        **({"impact_wall": ("impact", walls, {"long_name": "wall that is hit"})} if named else {}),
        "impact_point": ("impact", _joined(rows, np.int64), {"long_name": "row of the orbit"}),
        "impact_time": column([one.times + rolls[i] * one.model.period for i, one in hit], "t"),
        "v_minus": column([one.incoming for _i, one in hit], "v_minus"),
        "v_plus": column([one.outgoing for _i, one in hit], "v_plus"),
    }


def _depths(orbits: list[Orbit], column: Any) -> dict[str, Any]:
    """Return how far orbits of a map by pieces lie beyond their borders; nothing for other maps."""
    if not any(isinstance(orbit, PieceOrbit) for orbit in orbits):
        return {}
    depths = [orbit.depth if isinstance(orbit, PieceOrbit) else 0.0 for orbit in orbits]
    return {"depth": column("point", depths, "how far a virtual orbit lies beyond the border of its letters")}


def special_once(branch: Branch) -> list[Special]:
    """Return the special points of a branch in order, those where two of its pieces meet once and not of both."""
    near = SAME * (branch.bounds[1] - branch.bounds[0])
    kept: list[Special] = []
    for one in branch.special:
        met = ((other.type, other.piece, other.to) == (one.type, one.to, one.piece) for other in kept)
        apart = (abs(other.value - one.value) for other in kept)
        if not any(same and far <= near for same, far in zip(met, apart, strict=True)):
            kept.append(one)
    return kept


def branch_table(branch: Branch) -> xr.Dataset:
    """Return a branch as a labelled table.

    Parameters
    ----------
    branch : Branch

    Returns
    -------
    xarray.Dataset
        Dimension ``point``, the orbits in order, with ``piece``, the parameter by its name, ``period``, ``word``,
        ``impacts`` (-1 for a map that counts none), ``stable``, ``admissible``, for a map by pieces ``depth`` (how far
        beyond its border a virtual orbit lies), ``event`` (at a special point),
        ``condition``, ``multiplier_real`` and ``multiplier_imag`` (point, multiplier), and the orbit's points by
        coordinate (point, n), filled up with NaN. Dimension ``special``, with ``special_type``, ``special_value``,
        ``special_low``, ``special_high``, ``special_converged``, ``special_admissible``, ``special_piece``,
        ``special_to``, ``special_period`` and the first point by coordinate: where two pieces meet in one row.
        Dimension ``relabelling`` with value and words. Dimension ``impact``, one row an impact of the oscillator:
        ``impact_point``, the row of its orbit, ``impact_time``, counted from the first of the orbit's points and smooth
        along a piece, ``v_minus`` and ``v_plus``.
    """
    from grazing.late import xarray as xr

    P, name = branch.map, branch.parameter
    orbits = list(branch)
    # orbits of the impact map are followed as those of the stroboscopic map at phase 0
    coordinates = orbits[0].map.coordinates if orbits else P.coordinates
    most = max((orbit.period for orbit in orbits), default=1)
    points = np.full((len(orbits), most, len(coordinates)), np.nan)
    rolls = _joined([shifts(piece) for piece in branch.pieces], np.int64)
    for i, (orbit, roll) in enumerate(zip(orbits, rolls.tolist(), strict=True)):
        points[i, : orbit.period] = np.roll(orbit.points, roll, axis=0)
    about = P.describe(name)
    value = about.attributes
    special = special_once(branch)

    def column(dim: str, values: Any, long_name: str, **more: str) -> Any:
        return dim, np.array(list(values)), {"long_name": long_name, **more}

    def text(dim: str, values: Any, long_name: str, **more: str) -> Any:
        return dim, np.array(list(values), dtype=object), {"long_name": long_name, **more}

    roots = np.array([orbit.multipliers for orbit in orbits]).reshape(len(orbits), len(coordinates))
    words = "; ".join(f"{kind}: {meaning}" for kind, meaning in SPECIAL.items())
    table: dict[str, Any] = {
        name: ("point", _joined([piece.values for piece in branch.pieces], np.float64), value),
        "piece": column("point", np.repeat(range(len(branch.pieces)), [len(p.orbits) for p in branch.pieces]), "piece"),
        "period": column("point", [orbit.period for orbit in orbits], "period", units="1"),
        "word": text("point", [orbit.word for orbit in orbits], "word"),
        "impacts": column("point", [o.impacts if isinstance(o, ImpactOrbit) else -1 for o in orbits], "impacts"),
        "stable": column("point", [int(orbit.stable) for orbit in orbits], "whether the orbit is stable"),
        "admissible": column("point", [int(orbit.admissible) for orbit in orbits], "whether the orbit is admissible"),
        **_depths(orbits, column),
        "event": ("point", events_of(branch), {"long_name": "whether a special point lies there"}),
        "condition": column("point", [orbit.condition for orbit in orbits], "condition number", units="1"),
        "multiplier_real": (("point", "multiplier"), roots.real, {"long_name": "multiplier, real part", "units": "1"}),
        "multiplier_imag": (("point", "multiplier"), roots.imag, {"long_name": "multiplier, imaginary part"}),
        "special_type": text("special", [one.type for one in special], "type of special point", meaning=words),
        "special_value": ("special", np.array([one.value for one in special], np.float64), value),
        "special_low": ("special", np.array([one.low for one in special], np.float64), value),
        "special_high": ("special", np.array([one.high for one in special], np.float64), value),
        "special_converged": column("special", np.array([one.converged for one in special], np.int8), "converged"),
        "special_admissible": column("special", np.array([one.admissible for one in special], np.int8), "admissible"),
        "special_piece": column("special", np.array([one.piece for one in special], np.int64), "piece"),
        "special_to": column("special", np.array([one.to for one in special], np.int64), "piece that begins, or -1"),
        "special_period": column("special", np.array([one.orbit.period for one in special], np.int64), "period"),
        "relabelling_value": ("relabelling", np.array([one.value for one in branch.relabellings], np.float64), value),
        "relabelling_before": text("relabelling", [one.before for one in branch.relabellings], "word before"),
        "relabelling_after": text("relabelling", [one.after for one in branch.relabellings], "word after"),
    }
    if P.walled is not None:
        table["special_wall"] = text("special", [one.wall for one in special], "wall of the impact or of the graze")
    table |= impact_columns(orbits, rolls)
    for j, coordinate in enumerate(coordinates):
        said = P.describe(coordinate).attributes
        table[coordinate] = ("point", "n"), points[:, :, j], said
        first = np.array([one.orbit.points[0, j] for one in special], np.float64)
        table[f"special_{coordinate}"] = "special", first, said
    attributes = {
        "title": f"branch in {name} of {P.name}",
        "parameter": name,
        "bounds": list(branch.bounds),
        "map": P.name or "map",
        "parameters": json.dumps(dict(P.params)),
        "ends": json.dumps([list(piece.ends) for piece in branch.pieces]),
        "coordinate_names": json.dumps(list(coordinates)),
        "arithmetic": "strict",
        **({"unfinished": branch.unfinished} if branch.unfinished else {}),
        **P.origin.attributes,
    }
    return xr.Dataset(table, attrs=attributes)
