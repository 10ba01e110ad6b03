"""Rows of what a study found: text, numbers, and lists and tables of them, as JSON can write them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from grazing.catalogue.study import Row, Study
from grazing.outcome import Outcome

#: The value of ``trust`` that says that a decision could not be made.
AMBIGUOUS = 2
#: The kinds of orbits that have no period, by what stands in its place.
KINDS = {0: "undecided", -1: "aperiodic as far as seen", -2: "ended"}
#: The attribute of a result that says that orbits left the box of their starts.
NOTE = "grazing_outside"
#: Variables whose units stand beside what is printed of them.
READ = ("t", "u", "v", "frequency", "amplitude", "exponent_per_time", "return_time")

Array = Any


def units_of(result: Any) -> dict[str, str]:
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


def ranges_of(grid: Array, where: Array) -> list[list[float]]:
    """Return the runs of neighbouring values at which something holds, each by its first and last value."""
    import numpy as np

    order = np.argsort(grid, kind="stable")
    return [[float(grid[order[i]]), float(grid[order[j - 1]])] for i, j in runs(where[order])]


def runs(chosen: Array) -> list[tuple[int, int]]:
    """Return begin and end of each run of True.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.catalogue.rows import runs
    >>> runs(np.array([True, True, False, True]))
    [(0, 2), (3, 4)]
    """
    import numpy as np

    steps = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in steps.reshape(-1, 2)]


def numbered(period: Array, word: Array) -> tuple[list[tuple[int, str]], Array]:
    """Return the attractors among orbits, by period and word, and the number of that of each orbit."""
    import numpy as np

    texts, spelled = np.unique(word.astype(np.str_), return_inverse=True)
    pairs = np.column_stack([period.ravel().astype(np.int64), spelled.ravel()])
    kinds, which = np.unique(pairs, axis=0, return_inverse=True)
    return [(int(p), str(texts[w])) for p, w in kinds], which.reshape(period.shape)


def attractor(period: int, word: str, **more: Any) -> Row:
    """Return the row of an attractor."""
    return {"word": word, "period": period, "kind": kind_of(period), **more}


def symbol(code: int, variable: Any) -> str:
    """Return a letter as words have it: a count, the walls that are hit, or the symbol of its code."""
    if "walls" in variable.attrs:
        from grazing.maps.hits import Struck

        return Struck(str(variable.attrs["walls"])).symbol(code)
    if "surfaces" in variable.attrs:
        from grazing.maps.hits import Hits

        return Hits(str(variable.attrs["surfaces"])).symbol(code)
    if "objects" in variable.attrs:
        from grazing.maps.hits import Bounces

        return Bounces(tuple(str(variable.attrs["objects"]).split())).symbol(code)
    flags = dict(zip(variable.attrs["flag_values"].tolist(), variable.attrs["flag_meanings"].split(), strict=True))
    said = str(flags.get(code, code))
    return {"completed_chatter": "C", "stuck_throughout": "S"}.get(said, said if len(said) == 1 else f"({said})")


def events(outcomes: Array) -> dict[str, int]:
    """Return at how many steps each outcome happened."""
    counts = {str(flag.name): int(((outcomes & flag.value) != 0).sum()) for flag in Outcome if flag}
    return {name: count for name, count in counts.items() if count}


def rows_of(result: Any, names: Mapping[str, str]) -> list[Row]:
    """Return variables on one dimension as rows, by new names."""
    columns = [result[name].values.tolist() for name in names.values()]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def unfinished(result: Any) -> dict[str, str]:
    """Return what a limit has cut off, if it was reached."""
    said = result.attrs.get("unfinished")
    return {} if said is None else {"unfinished": str(said)}


def special_rows(result: Any) -> list[Row]:
    """Return the special points of a result, with what happens there in words."""
    names = ("type", "value", "low", "high", "converged", "admissible", "period", "piece", "to", "wall")
    rows = rows_of(result, {name: f"special_{name}" for name in names if f"special_{name}" in result})
    words = meanings(result["special_type"])
    for row in rows:
        row["converged"], row["admissible"] = bool(row["converged"]), bool(row["admissible"])
        row["meaning"] = words.get(row["type"], "")
    return rows


def window_rows(result: Any) -> list[Row]:
    """Return the windows of branches."""
    return rows_of(
        result, {name: f"window_{name}" for name in ("word", "period", "low", "low_type", "high", "high_type")}
    )


def meanings(variable: Any) -> dict[str, str]:
    """Return what the types of edges and special points mean."""
    pairs = [item.partition(": ") for item in str(variable.attrs.get("meaning", "")).split("; ")]
    return {name: words for name, _colon, words in pairs}


def plain(value: Any) -> Any:
    """Return what JSON can write: null for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def proof_row(proof: Any) -> Row:
    """Return what a certificate says."""
    return {
        "proven": proof.proven,
        "statement": proof.statement,
        "reason": proof.reason,
        "enclosure": None if proof.value is None else list(proof.value),
        "proof": proof,
    }


def told(study: Study, result: Any) -> Row:
    """Return what a study found, with what is the same for all that are computed point by point.

    Returns
    -------
    dict
        Of a rig, ``unit`` is that of the parameter, and ``units`` are those of what else is measured, by name. ``note``
        says that orbits left the box of their starts.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.catalogue import studies
    >>> from grazing.catalogue.rows import told
    >>> reached = gz.basins(gz.gap_map(lam=0.5, mu=0.07, l=0.1), {"x": [-0.5, 0.0, 0.5]})
    >>> [(one["word"], one["kind"], one["share"]) for one in told(studies()["basins"], reached)["attractors"]]
    [('LLR', 'period 3', 1.0)]
    """
    said = study.found(result)
    if study.orbits:
        return said
    unit = str(result[said["parameter"]].attrs.get("units", "1")) if said.get("parameter") in result else "1"
    said |= {"unit": unit} if unit != "1" else {}
    units = units_of(result)
    said |= {"units": units} if units else {}
    return {**said, "note": str(result.attrs[NOTE])} if NOTE in result.attrs else said
