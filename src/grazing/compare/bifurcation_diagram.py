"""Scan and branches together: what random starts reach, the branches through it, and where the two disagree."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.compare.search import Disagreement, Search, merged
from grazing.maps.map import Map
from grazing.orbits.branch import POINTS, Branch
from grazing.orbits.branch_table import branch_table
from grazing.orbits.branch_windows import Window, windows_of
from grazing.outcome import InputError, shown
from grazing.parameter import whole
from grazing.studies import labels
from grazing.studies.orbit_diagram import orbit_diagram
from grazing.studies.plan import Progress

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]


def bifurcation_diagram(
    P: Map,
    name: str,
    values: ArrayLike,
    *,
    starts: int | ArrayLike = 40,
    transient: int = 400,
    keep: int = 48,
    seed: int = 0,
    period: int = 16,
    points: int = POINTS,
    box: Sequence[tuple[float, float]] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Scan a parameter, follow every attractor that was reached and the unstable branches between, and compare.

    Parameters
    ----------
    P : Map
        Any map.
    name : str
        Which of ``P.params`` varies.
    values : array_like, shape (m,)
        Its values, at least 2 different ones; branches are followed from the least to the greatest.
    starts, transient, keep, seed, box, threads, progress
        Of the scan, as in :func:`grazing.orbit_diagram`. Branches go on with ``progress(points, limit)``.
    period : int
        Attractors of longer periods are listed and not followed.
    points : int
        Most points of all branches together, some 5 ms each; one branch takes at most a quarter. Short periods are
        followed first. Where the limit is reached, the attribute ``unfinished`` says how much was left.

    Returns
    -------
    xarray.Dataset
        The scan as :func:`grazing.orbit_diagram` returns it; all branches as :attr:`grazing.Branch.dataset` has them,
        its variables with ``branch_`` in front but for those of special points; dimension ``window`` with
        ``window_low``, ``window_high``, ``window_low_type``, ``window_high_type``, ``window_word``,
        ``window_period``; dimension ``disagreement`` with ``disagreement_kind``, ``disagreement_low``,
        ``disagreement_high``, ``disagreement_values``, ``disagreement_word``, ``disagreement_period``,
        ``disagreement_reason``.

        A window is a range in which an orbit of a branch is stable and admissible. Its types say what happens at its
        ends: lp fold; pd period doubling; ns Neimark-Sacker; bp branch point; gr graze; bcb border collision; ep end
        of the piece of the map; v0 an impact without speed, where the bumper kicks; law an impact as fast as its
        trigger; st sticking; ch onset of chatter. *end* is none of these: there the range ends, or the branch does.

    Raises
    ------
    InputError
        For an input out of range, or an oscillator at a section other than that of its branches.

    Notes
    -----
    A branch is begun at each attractor of the scan that lies on no branch yet, at each period doubling and branch
    point of an admissible orbit, and where the orbit of an oscillator without impacts is stable and no start reached
    it: its basin can be small. A scanned orbit lies on a branch if Newton's method from the branch ends at
    its points. That no start reaches a stable orbit is no error: its basin may be small, or lie outside of the box.

    Examples
    --------
    >>> import grazing as gz, numpy as np
    >>> P = gz.stroboscopic_map(gz.pinball(V=0.4))
    >>> result = gz.bifurcation_diagram(P, "d", np.linspace(0.09, 0.12, 7), starts=10)
    >>> sorted(set(result.window_word.values.tolist()))
    ['001', '01']
    """
    refuse_other_sections(P)
    longest = whole(period, "period", 1)
    scan = orbit_diagram(P, name, values, starts, transient, keep, seed, threads, "fast", box, progress)
    grid = np.unique(scan[name].values)
    if len(grid) < 2:
        raise InputError(f"values of {name} are {grid.tolist()}; give at least 2 different ones")
    most = whole(points, "points", 2)
    search = Search(P, name, (float(grid[0]), float(grid[-1])), longest, keep // 2, transient + keep, most, progress)
    search.scanned(scan)
    branch = merged(P, name, search.bounds, search.branches)
    found = [*search.missed(), *search.unreached(scan)]
    result = labelled(scan, branch, windows_of(branch), found, name)
    result.attrs |= documented(P, result.attrs["title"], scan, "bifurcation_diagram", search)
    return with_limit(result, search)


def documented(P: Map, title: str, scan: xr.Dataset, study: str, search: Search) -> labels.Attributes:
    """Return the attributes of a study that follows branches through a scan: what decides the numbers of both."""
    config = json.loads(scan.attrs["grazing_config"])
    own = {key: value for key, value in config.items() if key not in ("map", "coordinates", "params")}
    return labels.document(P, title, own | {"study": study, "period": search.longest, "points": search.points})


def with_limit(result: xr.Dataset, search: Search) -> xr.Dataset:
    """Return a result that says, in the attribute ``unfinished``, what the limit of points has cut off."""
    return result.assign_attrs(unfinished=search.unfinished) if search.unfinished else result


def refuse_other_sections(P: Map) -> None:
    """Raise InputError for an oscillator that is not seen where its branches are: at the strobe at phase 0."""
    if isinstance(P, Map) and P.section is not None and (P.section != "strobe" or P.params.get("phase") != 0.0):
        raise InputError(
            f"branches of an oscillator have the points of its stroboscopic map at phase 0, and {shown(P)} has others; "
            "give gz.stroboscopic_map(model)"
        )


def labelled(
    scan: xr.Dataset, branch: Branch, windows: list[Window], found: list[Disagreement], name: str
) -> xr.Dataset:
    """Return scan, branches, windows and disagreements as one table."""
    table = branch_table(branch)
    renamed = table.rename(
        {key: f"branch_{key}" for key in [*table.variables, *table.dims] if not str(key).startswith("special")}
    )
    result = scan.merge(renamed)
    about = dict(scan[name].attrs)

    def text(dim: str, values: list[str], long_name: str) -> Any:
        return dim, np.array(values, dtype=object), {"long_name": long_name}

    for side in ("low", "high"):
        result[f"window_{side}"] = "window", np.array([getattr(w, side) for w in windows], np.float64), about
        types = [getattr(w, f"{side}_type") for w in windows]
        result[f"window_{side}_type"] = text("window", types, f"special point at the {side} end")
        result[f"disagreement_{side}"] = "disagreement", np.array([getattr(d, side) for d in found], np.float64), about
    result["window_word"] = text("window", [w.word for w in windows], "word")
    result["window_period"] = "window", np.array([w.period for w in windows], np.int64), {"long_name": "period"}
    result["disagreement_kind"] = text("disagreement", [d.kind for d in found], "what differs")
    result["disagreement_word"] = text("disagreement", [d.word for d in found], "word")
    result["disagreement_reason"] = text("disagreement", [d.reason for d in found], "why")
    for key in ("values", "period"):
        numbers = np.array([getattr(d, key) for d in found], np.int64)
        result[f"disagreement_{key}"] = "disagreement", numbers, {"long_name": key}
    result.attrs = {**scan.attrs, "title": f"bifurcation diagram of the {branch.map.name} in {name}"}
    result.attrs["bounds"] = list(branch.bounds)
    result.attrs["ends"] = table.attrs["ends"]
    return result
