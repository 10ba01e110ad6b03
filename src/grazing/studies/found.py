"""What a study found, as a few plain values: attractors with their shares, exponents, impacts, letters."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.maps.hits import Hits, Struck
from grazing.outcome import FATAL, Outcome
from grazing.studies.outside import NOTE

if TYPE_CHECKING:
    import xarray as xr

Row = dict[str, Any]

#: The value of ``trust`` that says that a decision could not be made.
AMBIGUOUS = 2
#: Impacts, and letters of an orbit, that are listed.
FIRST = 5
LETTERS = 60
#: Lines of a spectrum that are listed have this share of the strongest.
FAINTEST = 1e-3
#: The kinds of orbits that have no period, by what stands in its place.
#: Variables whose units stand beside what is printed of them.
READ = ("t", "u", "v", "frequency", "amplitude", "exponent_per_time", "return_time")
KINDS = {0: "undecided", -1: "aperiodic as far as seen", -2: "ended"}


def found(study: str, result: xr.Dataset) -> Row:
    """Return what a study found, computed from its result alone.

    Parameters
    ----------
    study : str
        As the command line names it: diagram, density, chart, basins, lyapunov, coexistence, trajectory, history,
        sample, spectrum, cobweb, graph.
    result : xarray.Dataset
        Of that study.

    Returns
    -------
    dict
        Text, numbers, and lists and dicts of them. Of a rig, ``unit`` is that of the parameter, and ``units`` are those
        of what else is measured, by name. ``note`` says that orbits left the box of their starts.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.found import found
    >>> reached = gz.basins(gz.gap_map(lam=0.5, mu=0.07, l=0.1), {"x": [-0.5, 0.0, 0.5]})
    >>> [(one["word"], one["kind"], one["share"]) for one in found("basins", reached)["attractors"]]
    [('LLR', 'period 3', 1.0)]
    """
    said = FOUND[study](result)
    unit = str(result[said["parameter"]].attrs.get("units", "1")) if said.get("parameter") in result else "1"
    said |= {"unit": unit} if unit != "1" else {}
    units = units_of(result)
    said |= {"units": units} if units else {}
    return {**said, "note": str(result.attrs[NOTE])} if NOTE in result.attrs else said


def units_of(result: xr.Dataset) -> dict[str, str]:
    """Return the units of what is read from a result: of times, states, rates and lines."""
    units = {name: str(result[name].attrs.get("units", "1")) for name in READ if name in result.variables}
    if "point" in result and "coordinate" in result.coords:
        each = str(result["point"].attrs.get("units", "1")).split(", ")
        names = [str(name) for name in result["coordinate"].values]
        units |= dict(zip(names, each * (len(names) if len(each) == 1 else 1), strict=True))
    return {name: unit for name, unit in units.items() if unit != "1"}


def kind_of(period: int) -> str:
    """Return what an orbit is, in words."""
    return f"period {period}" if period > 0 else KINDS[period]


def ranges_of(grid: NDArray[np.float64], where: NDArray[np.bool_]) -> list[list[float]]:
    """Return the runs of neighbouring values at which something holds, each by its first and last value."""
    order = np.argsort(grid, kind="stable")
    x, there = grid[order], where[order]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(np.int8)))
    return [[float(x[i]), float(x[j - 1])] for i, j in edges.reshape(-1, 2)]


def numbered(period: NDArray[Any], word: NDArray[Any]) -> tuple[list[tuple[int, str]], NDArray[np.int64]]:
    """Return the attractors among orbits, by period and word, and the number of that of each orbit."""
    texts, spelled = np.unique(word.astype(np.str_), return_inverse=True)
    pairs = np.column_stack([period.ravel().astype(np.int64), spelled.ravel()])
    kinds, which = np.unique(pairs, axis=0, return_inverse=True)
    return [(int(p), str(texts[w])) for p, w in kinds], which.reshape(period.shape)


def attractor(period: int, word: str, **more: Any) -> Row:
    """Return the row of an attractor."""
    return {"word": word, "period": period, "kind": kind_of(period), **more}


def in_diagram(result: xr.Dataset) -> Row:
    """Return the attractors of an orbit diagram, those that most orbits reach first, and where each was reached."""
    name = str(result["period"].dims[0])
    grid = result[name].values.astype(np.float64)
    kinds, which = numbered(result["period"].values, result["word"].values)
    rows = []
    for i, (period, word) in enumerate(kinds):
        here = which == i
        reached = here.any(axis=1)
        rows.append(
            attractor(
                period, word, share=float(here.mean()), values=int(reached.sum()), ranges=ranges_of(grid, reached)
            )
        )
    rows.sort(key=lambda row: -row["share"])
    doubtful = int((result["trust"].values == AMBIGUOUS).sum())
    return {"parameter": name, "values": len(grid), "orbits": which.size, "attractors": rows, "ambiguous": doubtful}


def in_chart(result: xr.Dataset) -> Row:
    """Return the attractors of a chart with their shares of the cells, and the shares that say more of all of them."""
    period, word = result["period"].values, result["word"].values
    held = period >= min(KINDS)
    kinds, which = numbered(np.where(held, period, 0), np.where(held, word, ""))
    rows = []
    for i, (p, w) in enumerate(kinds):
        here = (which == i) & held
        if here.any():
            share, first = float(here.any(axis=-1).mean()), float(here[..., 0].mean())
            rows.append(attractor(p, w, share=share, first=first))
    rows.sort(key=lambda row: (-row["share"], -row["first"]))
    doubtful = ((result["trust"].values == AMBIGUOUS) & held).any(axis=-1)
    stretched = (result["exponent"].values > 0.0).any(axis=-1)
    return {
        "cells": int(np.prod(period.shape[:-1])),
        "attractors": rows,
        "several": float((held.sum(axis=-1) > 1).mean()),
        "positive": float(stretched.mean()),
        "ambiguous": int(doubtful.sum()),
    }


def in_basins(result: xr.Dataset) -> Row:
    """Return the attractors with their shares of the grid, and what the boundary between them is like."""
    columns = (result[name].values.tolist() for name in ("period", "word", "fraction", "point"))
    rows = [attractor(p, w, share=share, point=point) for p, w, share, point in zip(*columns, strict=True)]
    said = {
        "states": int(result["basin"].size),
        "coordinates": result["coordinate"].values.tolist(),
        "attractors": rows,
        "ambiguous": int((result["trust"].values == AMBIGUOUS).sum()),
    }
    about = ("basin_entropy", "uncertainty_exponent", "uncertainty_error", "boundary_dimension")
    return said | {name: float(x) for name in about if np.isfinite(x := result.attrs.get(name, np.nan))}


def in_lyapunov(result: xr.Dataset) -> Row:
    """Return the exponents of each attractor at one value; over a range how the largest one varies and changes sign."""
    exponent = result["exponent"].values
    if result["period"].ndim == 1:
        return {"attractors": measured(result), "starts": len(exponent)}
    name = str(result["period"].dims[0])
    grid, order = result[name].values.astype(np.float64), np.argsort(result[name].values, kind="stable")
    every = np.where(np.isnan(exponent[..., 0]), -np.inf, exponent[..., 0])
    known = ~np.isnan(exponent[..., 0]).all(axis=1)
    x, largest = grid[order][known[order]], every.max(axis=1)[order][known[order]]
    said: Row = {"parameter": name, "values": len(grid), "known": int(known.sum())}
    if not x.size:
        return said
    up = largest > 0.0
    turns = np.flatnonzero(up[1:] != up[:-1])
    return said | {
        "least": {"exponent": float(largest.min()), name: float(x[largest.argmin()])},
        "greatest": {"exponent": float(largest.max()), name: float(x[largest.argmax()])},
        "positive": int(up.sum()),
        "sign_changes": [[float(x[i]), float(x[i + 1])] for i in turns],
    }


def measured(result: xr.Dataset) -> list[Row]:
    """Return the attractors at one value with the ranges of their exponents, the greatest exponent first."""
    kinds, which = numbered(result["period"].values, result["word"].values)
    rows = []
    for i, (period, word) in enumerate(kinds):
        here = which == i
        row = attractor(period, word, share=float(here.mean()))
        for name in ("exponent", "exponent_per_time", "return_time"):
            if name in result:
                numbers = result[name].values[here]
                row[name] = (
                    np.column_stack([numbers.min(axis=0), numbers.max(axis=0)]).tolist()
                    if numbers.ndim > 1
                    else [float(numbers.min()), float(numbers.max())]
                )
        rows.append(row)
    return sorted(rows, key=lambda row: -row["share"])


def in_coexistence(result: xr.Dataset) -> Row:
    """Return the attractors with where they were reached and their greatest share, and the changes in order."""
    share = result["share"].values
    name = next(str(dim) for dim in result["share"].dims if dim != "attractor")
    grid = result[name].values.astype(np.float64)
    columns = result["period"].values.tolist(), result["word"].values.tolist(), share.T
    rows = [
        attractor(p, w, values=int((s > 0.0).sum()), greatest=float(s.max()), ranges=ranges_of(grid, s > 0.0))
        for p, w, s in zip(*columns, strict=True)
    ]
    names = "before", "after", "kind", "word_before", "word_after", "period_before", "period_after"
    changes = zip(*(result[key].values.tolist() for key in names), strict=True)
    return {
        "parameter": name,
        "values": len(grid),
        "attractors": rows,
        "most_at_once": int((share > 0.0).sum(axis=1).max()),
        "changes": [dict(zip(names, change, strict=True)) for change in changes],
        "ambiguous": int((result["trust"].values == AMBIGUOUS).sum()),
    }


def in_density(result: xr.Dataset) -> Row:
    """Return how many points were counted, how many fell beyond the ends, and how much of the range was visited."""
    name, coordinate = (str(dim) for dim in result["count"].dims)
    count = result["count"].values
    said = {key: int(result[key].values.sum()) for key in ("below", "above", "ended", "ambiguous")}
    about = result[coordinate].attrs
    return {
        "parameter": name,
        "coordinate": coordinate,
        "range": [float(about["low"]), float(about["high"])],
        "counted": int(count.sum()),
        **said,
        "visited": float((count > 0).mean()),
    }


def in_trajectory(result: xr.Dataset) -> Row:
    """Return the number of impacts, the first of them, the rests on the wall and how far to trust them."""
    names = "impact_time", "v_minus", "v_plus"
    first = zip(*(result[name].values[:FIRST].tolist() for name in names), strict=True)
    of = "u" if "u" in result else str(result["coordinate"].values[0])  # a system of one's own has other names
    t, u = result["t"].values, result[of].values
    if of != "u":
        lies = []
    elif "rest_time" in result:  # of several walls, or one that moves
        lies = result["rest_time"].values.tolist()
    else:
        wall = float(result["wall"]) if "wall" in result else float(result.attrs.get("parameter_sigma", 0.0))
        lies = rests(t, u, result["v"].values, wall)
    said: Row = {
        "impacts": int(result.sizes["impact"]),
        "first": [dict(zip(("t", "v_minus", "v_plus"), impact, strict=True)) for impact in first],
        "coordinate": of,
        of: [float(u.min()), float(u.max())],
        "rests": lies,
        "chatter": bool(result.attrs.get("chatter", 0)),
        "trust": str(result["trust"].values),
    }
    if said["impacts"]:
        speeds = result["impact_speed"].values if "impact_speed" in result else -result["v_minus"].values
        said["speeds"] = [float(speeds.min()), float(speeds.max())]
    return said


def in_sample(result: xr.Dataset) -> Row:
    """Return how many samples there are, over which time and at which rate, and what is said of a trajectory."""
    t = result["t"].values
    count = {"samples": len(t), "rate": float(result.attrs["sample_rate"]), "t": [float(t[0]), float(t[-1])]}
    return {**count, **in_trajectory(result)}


def in_spectrum(result: xr.Dataset) -> Row:
    """Return the strongest lines, and how fine and how far the spectrum is."""
    y, order, frequency = (result[name].values for name in ("amplitude", "order", "frequency"))
    inner = np.arange(1, len(y) - 1)
    peaks = inner[(y[inner] > y[inner - 1]) & (y[inner] >= y[inner + 1]) & (y[inner] >= FAINTEST * y[1:].max())]
    peaks = peaks[np.argsort(-y[peaks], kind="stable")]
    names = {"frequency": frequency, "order": order, "amplitude": y}
    return {
        "lines": [{key: float(values[i]) for key, values in names.items()} for i in peaks.tolist()],
        "resolution": float(frequency[1]),
        "until": float(frequency[-1]),
    }


def rests(t: NDArray[np.float64], u: NDArray[np.float64], v: NDArray[np.float64], wall: float) -> list[list[float]]:
    """Return when the ball lies on the wall, each time by its begin and end."""
    still = (u == wall) & (v == 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(np.int8))).reshape(-1, 2)
    return [[float(t[i]), float(t[j - 1])] for i, j in edges if t[j - 1] > t[i]]


def symbol(code: int, variable: Any) -> str:
    """Return a letter as words have it: a count, the walls that are hit, or the symbol of its code."""
    if "walls" in variable.attrs:
        return Struck(str(variable.attrs["walls"])).symbol(code)
    if "surfaces" in variable.attrs:
        return Hits(str(variable.attrs["surfaces"])).symbol(code)
    flags = dict(zip(variable.attrs["flag_values"].tolist(), variable.attrs["flag_meanings"].split(), strict=True))
    said = str(flags.get(code, code))
    return {"completed_chatter": "C", "stuck_throughout": "S"}.get(said, said if len(said) == 1 else f"({said})")


def events(outcomes: NDArray[Any]) -> dict[str, int]:
    """Return at how many steps each outcome happened."""
    counts = {str(flag.name): int(((outcomes & flag.value) != 0).sum()) for flag in Outcome if flag}
    return {name: count for name, count in counts.items() if count}


def in_cobweb(result: xr.Dataset) -> Row:
    """Return the letters of an orbit, its range, its last point and what happened."""
    name = str(result["image"].attrs.get("symbol", ""))
    name = next(str(key) for key in result.data_vars if result[key].dims == ("n",)) if name not in result else name
    x, letters = result[name].values, result["letter"].values
    ended = np.flatnonzero(result["outcome"].values & FATAL)
    spelled = [symbol(code, result["letter"]) for code in letters[:LETTERS].tolist()]
    finite = x[np.isfinite(x)]
    return {
        "coordinate": name,
        "steps": len(letters),
        "letters": "".join(spelled),
        "range": [float(finite.min()), float(finite.max())] if finite.size else None,
        "last": float(x[-1]),
        "ended": int(ended[0]) if ended.size else None,
        "events": events(result["outcome"].values),
    }


def in_graph(result: xr.Dataset) -> Row:
    """Return where each map takes each letter, and how far two maps differ where their letters agree."""
    name = next(str(dim) for dim in result["letter"].dims if dim != "map")
    grid, letters = result[name].values.astype(np.float64), result["letter"].values
    rows = []
    for of, codes in zip(result["map"].values.tolist(), letters, strict=True):
        for code in np.unique(codes).tolist():
            here = codes == code
            rows.append(
                {"map": of, "letter": symbol(code, result["letter"]), "states": int(here.sum()),
                 "ranges": ranges_of(grid, here)}
            )  # fmt: skip
    said: Row = {"coordinate": name, "states": len(grid), "letters": rows, "events": events(result["outcome"].values)}
    if len(letters) == 2:
        same = letters[0] == letters[1]
        said["agree"] = int(same.sum())
        images = [str(key) for key in result.data_vars if str(key).startswith("image_")]
        gaps = {key: np.abs(np.diff(result[key].values, axis=0))[0][same] for key in images}
        said["differ"] = {
            key.removeprefix("image_"): float(gap[np.isfinite(gap)].max())
            for key, gap in gaps.items() if np.isfinite(gap).any()
        }  # fmt: skip
    return said


FOUND: dict[str, Callable[[Any], Row]] = {
    "diagram": in_diagram, "density": in_density, "chart": in_chart, "basins": in_basins, "lyapunov": in_lyapunov,
    "coexistence": in_coexistence, "trajectory": in_trajectory, "history": in_trajectory, "sample": in_sample,
    "spectrum": in_spectrum, "cobweb": in_cobweb, "graph": in_graph,
}  # fmt: skip
