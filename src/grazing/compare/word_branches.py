"""All branches of a word or a period over a range of a parameter: orbits found at several values, each followed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from grazing.compare.search import merged, same_points
from grazing.maps.map import Map
from grazing.orbits.branch import POINTS, Branch, checked_bounds, followed
from grazing.orbits.branch_search import SHARE, Work
from grazing.orbits.branch_table import branch_table
from grazing.orbits.branch_windows import windows_of
from grazing.orbits.locus import FOLLOWED, Locus, Meeting, same_meeting
from grazing.orbits.locus import locus as locus_of
from grazing.orbits.orbit import Orbit
from grazing.orbits.periodic import periodic_orbits
from grazing.orbits.special import Special
from grazing.outcome import GrazingError, InputError
from grazing.parameter import real, whole
from grazing.pool import Progress, checked_progress

if TYPE_CHECKING:
    import xarray as xr

#: Values of the parameter at which orbits are looked for, if none are given.
VALUES = 9
#: Orbits whose points differ by less than this part of the map's box are one.
SAME = 1e-6


def branches(
    P: Map,
    name: str,
    bounds: tuple[float, float],
    *,
    period: Sequence[int] | None = None,
    word: str | None = None,
    at: Sequence[float] | None = None,
    locus: Mapping[str, Sequence[float]] | None = None,
    virtual: bool = False,
    starts: int = 4000,
    seed: int = 0,
    step: float = 0.03,
    limit: int = 2000,
    points: int = POINTS,
    threads: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Find the orbits of a word or a period at several values of a parameter, and follow each over its whole range.

    Parameters
    ----------
    P : Map
    name : str
        Which parameter varies.
    bounds : (low, high)
        Its range.
    period, word, virtual, starts, seed, threads
        Which orbits are looked for, as in :func:`grazing.periodic_orbits`.
    at : sequence of float, optional
        Values at which they are looked for; 9 values evenly within the range by default.
    locus : mapping of str to (low, high), optional
        A second parameter and its range, in which the special points are followed, see :func:`grazing.locus`.
    step, limit
        As in :func:`grazing.continuation`. An orbit whose branch has reached the limit is followed again from the next
        value.
    points : int
        Most points of all branches together, some 5 ms each; one branch takes at most a quarter. Where the limit is
        reached, the attribute ``unfinished`` says so.
    progress : callable, optional
        ``progress(done, total)``, with numbers of values.

    Returns
    -------
    xarray.Dataset
        :attr:`grazing.Branch.dataset` of all branches together, with dimension ``window`` as
        :func:`grazing.bifurcation_diagram` has it; with ``locus`` also what :func:`with_loci` adds.

    Raises
    ------
    InputError
        If no orbit is found at any of the values, and for an input out of range.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.compare.word_branches import branches
    >>> P = gz.stroboscopic_map(gz.pinball(V=0.4))
    >>> table = branches(P, "d", (0.02, 0.14), word="001")
    >>> kinds = [kind for kind, kept in zip(table.special_type.values, table.special_admissible.values) if kept]
    >>> kinds, table.window_word.values.tolist()
    (['gr', 'pd', 'v0'], ['001'])
    """
    low, high = checked_bounds(P, name, bounds)
    values = np.linspace(low, high, VALUES + 2)[1:-1] if at is None else np.array([real(v, name, "") for v in at])
    found: list[Branch] = []
    unfollowed: list[str] = []
    size = np.array([b - a for a, b in P.box])
    most, progress = whole(points, "points", 2), checked_progress(progress)
    done = 0

    def told(_points: int = 0) -> None:
        if progress is not None:
            progress(done, len(values))

    work = Work(most, told)
    for value in values.tolist():
        if work.left < 2:
            break
        told()
        here = P.replace(**{name: value})
        known = [one for branch in found for one in branch.at(value)]
        for orbit in periodic_orbits(
            here, period, word=word, virtual=virtual, starts=starts, seed=seed, threads=threads
        ):
            if not (orbit.admissible or virtual) or _among(known, orbit, SAME * size):
                continue
            if work.left < 2:
                break
            try:
                part = work.part(int(SHARE * most))
                found.append(followed(here, orbit, name, (low, high), step, limit, part))
                known += found[-1].at(value)
            except GrazingError as error:
                unfollowed.append(f"{orbit!r} at {name} = {value:g}: {error}")
        else:
            done += 1
    told()
    if not found:
        what = f"of word {word}" if word is not None else f"of period {', '.join(map(str, period or ()))}"
        tried = ", ".join(f"{value:g}" for value in values[:VALUES])
        why = f"; not followed: {unfollowed[0]}" if unfollowed else ""
        raise InputError(
            f"no orbit {what} was found at {name} = {tried}{why}. Try other values (at), more starts (starts), "
            "another range, or begin at virtual orbits (virtual)"
        )
    branch = merged(found[0].map, name, (low, high), found)
    table = _with_windows(branch_table(branch), branch)
    table.attrs["values"] = values.tolist()
    if done < len(values):
        table.attrs["unfinished"] = (
            f"the limit of {most} points in all was reached at {name} = {values[done]:g}; a larger limit (points), "
            "a narrower range or fewer orbits are followed to their ends"
        )
    if unfollowed:
        table.attrs["not_followed"] = json.dumps(unfollowed)
    if locus is not None:
        [(other, ends)] = locus.items()
        loci, failed = _loci(branch.special, (name, other), ((low, high), (ends[0], ends[1])), virtual)
        table = with_loci(table, loci, (name, other))
        table.attrs["locus_not_followed"] = json.dumps(failed)
    return table


def _among(known: Sequence[Orbit], orbit: Orbit, tolerance: Any) -> bool:
    """Whether an orbit is among others at the same value."""
    return any(one.period == orbit.period and same_points(one.points, orbit.points, tolerance) for one in known)


def _loci(
    special: Sequence[Special], names: tuple[str, str], ranges: Any, virtual: bool
) -> tuple[list[Locus], list[str]]:
    """Follow the special points in two parameters; return the loci, and why others could not be followed."""
    loci: list[Locus] = []
    failed: list[str] = []
    for one in special:
        if not (one.admissible or virtual):
            continue
        if one.type not in FOLLOWED:
            failed.append(f"{one!r}: allowed are {', '.join(FOLLOWED)}")
            continue
        try:
            loci.append(locus_of(one, names, ranges))
        except GrazingError as error:
            failed.append(f"{one!r}: {error}")
    return each_meeting_once(loci), failed


def each_meeting_once(loci: Sequence[Locus]) -> list[Locus]:
    """Return loci of which each point of codimension two is on the first that it lies on only."""
    known: list[Meeting] = []
    kept = []
    for one in loci:
        spans = np.array([high - low for low, high in one.bounds])
        new = tuple(m for m in one.meetings if not any(same_meeting(m, other, spans) for other in known))
        known += new
        kept.append(replace(one, meetings=new))
    return kept


def _with_windows(table: xr.Dataset, branch: Branch) -> xr.Dataset:
    """Return the table of a branch with its windows."""
    about = dict(table[branch.parameter].attrs)
    windows = windows_of(branch)
    for side in ("low", "high"):
        table[f"window_{side}"] = "window", np.array([getattr(w, side) for w in windows], np.float64), about
        kinds = np.array([getattr(w, f"{side}_type") for w in windows], dtype=object)
        table[f"window_{side}_type"] = "window", kinds, {"long_name": f"special point at the {side} end"}
    table["window_word"] = "window", np.array([w.word for w in windows], dtype=object), {"long_name": "word"}
    table["window_period"] = "window", np.array([w.period for w in windows], np.int64), {"long_name": "period"}
    return table


def with_loci(table: xr.Dataset, loci: Sequence[Locus], names: tuple[str, str]) -> xr.Dataset:
    """Return the table of a branch with loci in the plane of two parameters.

    Dimension ``locus``: ``locus_type`` and ``locus_word``. Dimension ``locus_point``: ``locus_number``, both parameters
    by ``locus_`` and their names, ``locus_admissible``. Dimension ``meeting``: ``meeting_number`` (of the locus),
    ``meeting_type``, ``meeting_admissible``, both parameters by ``meeting_`` and their names.
    :func:`loci_of` takes them apart again.
    """
    from grazing.late import xarray as xr

    parts = [one.dataset for one in loci]
    new: dict[str, Any] = {
        "locus_type": ("locus", np.array([one.type for one in loci], dtype=object), {"long_name": "type"}),
        "locus_word": ("locus", np.array([one.orbits[0].word for one in loci], dtype=object), {"long_name": "word"}),
    }

    def joined(key: str, dtype: Any) -> Any:
        return np.concatenate([np.asarray(part[key].values, dtype) for part in parts] or [np.empty(0, dtype)])

    for dim, front in (("point", "locus"), ("meeting", "meeting")):
        counts = [part.sizes[dim] for part in parts]
        kept = f"{front}_point" if dim == "point" else "meeting"
        which = np.repeat(np.arange(len(parts), dtype=np.int64), np.array(counts, np.int64))
        new[f"{front}_number"] = kept, which, {"long_name": "number of the locus"}
        for name in names:
            key = name if dim == "point" else f"meeting_{name}"
            about = dict(parts[0][name].attrs) if parts else {"long_name": name}
            new[f"{front}_{name}"] = kept, joined(key, np.float64), about
    new["locus_admissible"] = "locus_point", joined("admissible", np.int8), {"long_name": "admissible"}
    new["meeting_admissible"] = "meeting", joined("meeting_admissible", np.int8), {"long_name": "admissible"}
    new["meeting_type"] = "meeting", joined("meeting_type", object), {"long_name": "what happens at once"}
    both = xr.Dataset(new)
    return table.merge(both).assign_attrs({**table.attrs, "locus_parameters": json.dumps(list(names))})


def loci_of(table: xr.Dataset) -> list[xr.Dataset]:
    """Return the loci in the table of a branch, each as :attr:`grazing.Locus.dataset` has it, for its figure.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.compare.word_branches import branches, loci_of
    >>> P = gz.stroboscopic_map(gz.pinball(V=0.4))
    >>> table = branches(P, "d", (0.08, 0.14), word="001", locus={"V": (0.3, 0.5)})
    >>> [one.attrs["type"] for one in loci_of(table)]
    ['gr', 'pd', 'v0']
    """
    from grazing.late import xarray as xr

    if "locus_parameters" not in table.attrs:
        return []
    names = json.loads(table.attrs["locus_parameters"])
    found = []
    for i, kind in enumerate(table["locus_type"].values.tolist()):
        points, meetings = (np.flatnonzero(table[f"{front}_number"].values == i) for front in ("locus", "meeting"))
        columns: dict[str, Any] = {}
        for name in names:
            at = table[f"locus_{name}"]
            columns[name] = "point", at.values[points], dict(at.attrs)
            columns[f"meeting_{name}"] = "meeting", table[f"meeting_{name}"].values[meetings], dict(at.attrs)
        columns["admissible"] = "point", table["locus_admissible"].values[points]
        columns["meeting_type"] = "meeting", table["meeting_type"].values[meetings]
        columns["meeting_admissible"] = "meeting", table["meeting_admissible"].values[meetings]
        attrs = {"type": kind, "word": str(table["locus_word"].values[i]), "parameters": json.dumps(names)}
        attrs |= {key: table.attrs[key] for key in ("mass", "stop", "base") if key in table.attrs}
        found.append(xr.Dataset(columns, attrs=attrs))
    return found
