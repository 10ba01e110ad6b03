"""What a study found, in a few lines of words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from grazing.cli.orbit_words import aligned, headed, short

Found = Mapping[str, Any]

#: Rows of a table, ranges of a row, and letters of a word that are printed; --json has all.
ROWS, RANGES, LONGEST = 6, 2, 24


def words_of(study: str, found: Found) -> list[str]:
    """Return what a study found as lines, with an empty line at the end."""
    said = WORDS[study](found)
    if found.get("ambiguous"):
        of = {"chart": "cells", "basins": "initial states", "density": "starts"}.get(study, "orbits")
        said.append(f"{found['ambiguous']} {of} are ambiguous: a decision was closer than rounding")
    if "note" in found:
        said.append(f"note: {found['note']}")
    return [*said, ""]


def share(part: float, whole: int) -> str:
    """Return a share in percent: no finer than one of the whole, and all or nothing only where it is so."""
    digits = max(0, min(2, int(math.log10(max(whole, 1))) - 2))
    text = f"{100.0 * part:.{digits}f}"
    least = f"{10.0**-digits:.{digits}f}"
    if part < 1.0 and float(text) == 100.0:
        return f"over {100.0 - float(least):.{digits}f} %"
    return f"under {least} %" if part > 0.0 and float(text) == 0.0 else f"{text} %"


def of(name: str, found: Found) -> str:
    """Return the unit of something measured, nothing where it is dimensionless."""
    return str(found.get("units", {}).get(name, ""))


def between(ends: Sequence[float], digits: int = 6) -> str:
    """Return a range, or one number if both ends read the same."""
    low, high = (short(end, digits) for end in ends)
    return low if low == high else f"{low} to {high}"


def places(ranges: Sequence[Sequence[float]]) -> str:
    """Return where something holds; of many ranges the first, and where the last one ends."""
    if len(ranges) <= RANGES:
        return ", ".join(map(between, ranges))
    return f"{between(ranges[0])}, ... up to {short(ranges[-1][1])} ({len(ranges)} ranges)"


def named(row: Found) -> list[str]:
    """Return the word and the kind of an attractor."""
    word = row["word"] or "-"
    return [word if len(word) <= LONGEST else f"{word[: LONGEST - 3]}...", row["kind"]]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the first rows as a table, and how many there are beyond."""
    more = len(rows) - ROWS
    shown = aligned(head, rows[:ROWS]) if rows else []
    return [*shown, f"and {more} more; --json lists them"] if more > 0 else shown


def diagram_words(found: Found) -> list[str]:
    """Return the attractors of a diagram, with the values at which each was reached."""
    name, many = found["parameter"], found["orbits"]
    rows = [
        [*named(row), share(row["share"], many), f"{row['values']} of {found['values']}", places(row["ranges"])]
        for row in found["attractors"]
    ]
    return table(["word", "", "orbits", "values", f"{headed(name, found.get('unit', ''))} from"], rows)


def chart_words(found: Found) -> list[str]:
    """Return the attractors of a chart, with their shares of the cells."""
    many = found["cells"]
    rows = [[*named(row), share(row["share"], many), share(row["first"], many)] for row in found["attractors"]]
    said = table(["word", "", "cells", "most starts in"], rows)
    said.append(f"more than one attractor in {share(found['several'], many)} of the cells")
    return [*said, f"an exponent is positive in {share(found['positive'], many)} of the cells"]


def basins_words(found: Found) -> list[str]:
    """Return the attractors with their basins, and the dimension of the boundary."""
    many = found["states"]
    rows = []
    for row in found["attractors"]:
        point = ", ".join(short(x) for x in row["point"]) if all(map(math.isfinite, row["point"])) else "-"
        rows.append([*named(row), share(row["share"], many), point])
    point = ", ".join(f"{name} {of(name, found)}".rstrip() for name in found["coordinates"])
    said = table(["word", "", "share", f"point ({point})"], rows)
    if "boundary_dimension" in found:
        dimension, error = short(found["boundary_dimension"], 3), short(found["uncertainty_error"], 1)
        said.append(f"dimension of the boundary {dimension}, standard error {error}")
    return said


def lyapunov_words(found: Found) -> list[str]:
    """Return the exponents, or over a range how the largest one varies."""
    if "starts" in found:
        return exponent_words(found)
    name, known, unit = found["parameter"], found["known"], found.get("unit", "")
    if not known:
        return ["no value has an orbit with exponents"]
    ends = [
        f"{short(found[end]['exponent'], 4)} at {name} = {short(found[end][name])} {unit}".rstrip()
        for end in ("least", "greatest")
    ]
    said = [f"largest exponent per step: from {ends[0]} to {ends[1]}"]
    said.append(f"positive at {found['positive']} of {known} values")
    turns = found["sign_changes"]
    if turns:
        first = ", ".join(between(turn) for turn in turns[:ROWS])
        more = f" and {len(turns) - ROWS} more" if len(turns) > ROWS else ""
        said.append(f"changes sign between neighbours {name} = {first}{more}")
    if known < found["values"]:
        said.append(f"none at {found['values'] - known} values: no orbit has a derivative there")
    return said


def exponent_words(found: Found) -> list[str]:
    """Return the exponents at one value: of a cycle from its multipliers, else the means that the starts gave."""
    rows = []
    for row in found["attractors"]:
        digits = 6 if row["period"] > 0 else 3
        cells = ["; ".join(between(ends, digits) for ends in row["exponent"])]
        if "return_time" in row:
            cells += ["; ".join(between(ends, digits) for ends in row["exponent_per_time"])]
            cells += [between(row["return_time"], digits)]
        rows.append([*named(row), share(row["share"], found["starts"]), *cells])
    timed = any("return_time" in row for row in found["attractors"])
    times = [("per time", "exponent_per_time"), ("time of a step", "return_time")] if timed else []
    head = ["word", "", "starts", "exponents per step", *(headed(says, of(name, found)) for says, name in times)]
    return table(head, rows)


def coexistence_words(found: Found) -> list[str]:
    """Return the attractors, where each was reached, and how many changes there are."""
    name = found["parameter"]
    ranked = sorted(found["attractors"], key=lambda row: -row["values"])
    rows = [
        [
            *named(row),
            f"{row['values']} of {found['values']}",
            f"{100.0 * row['greatest']:.0f} %",
            places(row["ranges"]),
        ]
        for row in ranked
    ]
    said = table(["word", "", "values", "most starts", f"{headed(name, found.get('unit', ''))} from"], rows)
    said.append(f"at most {found['most_at_once']} at one value")
    kinds: dict[str, int] = {}
    for change in found["changes"]:
        kinds[change["kind"]] = kinds.get(change["kind"], 0) + 1
    told = ", ".join(f"{kind} {count}" for kind, count in kinds.items())
    return [*said, f"changes between neighbouring values: {told or 'none'}"]


def density_words(found: Found) -> list[str]:
    """Return how many points were counted, and how many lie beyond the range."""
    low, high = (short(end) for end in found["range"])
    over = f"{found['coordinate']} from {low} to {high} {of(found['coordinate'], found)}".rstrip()
    said = [f"{found['counted']} points counted over {over}"]
    said.append(f"{found['below']} below and {found['above']} above that range")
    said.append(f"visited: {100.0 * found['visited']:.2g} % of the parts")
    return [*said, f"{found['ended']} orbits ended"] if found["ended"] else said


def trajectory_words(found: Found) -> list[str]:
    """Return the impacts, the rests and the trust."""
    count = found["impacts"]
    said = [f"{count or 'no'} impact{'' if count == 1 else 's'}, {found['trust']}"]
    rows = [[short(row[key]) for key in ("t", "v_minus", "v_plus")] for row in found["first"]]
    t, v = of("t", found), of("v", found)
    said += aligned([headed("impact at t", t), headed("v before", v), headed("v after", v)], rows) if rows else []
    if count > len(rows):
        said.append(f"and {count - len(rows)} more; speeds before impact {between(found['speeds'])} {v}".rstrip())
    if found["chatter"]:
        said.append("chatter: impacts without end in a finite time, completed in closed form")
    if found["rests"]:
        spans = ", ".join(between(span) for span in found["rests"][:RANGES])
        times = f"rests on the wall {len(found['rests'])} times, t = {spans} {t}".rstrip()
        said.append(times.replace(" 1 times", " once"))
    name = found["coordinate"]
    return [*said, f"{name} {between(found[name])} {of(name, found)}".rstrip() + " at the instants of the table"]


def sample_words(found: Found) -> list[str]:
    """Return how much was recorded, and the impacts."""
    t = of("t", found)
    said = f"{found['samples']} samples, {short(found['rate'])} per {'s' if t else 'unit of time'}, "
    said += f"t from {between(found['t'])} {t}".rstrip()
    return [said, *trajectory_words(found)]


def spectrum_words(found: Found) -> list[str]:
    """Return the strongest lines, and how fine and how far the spectrum is."""
    rows = [[short(row[key]) for key in ("frequency", "order", "amplitude")] for row in found["lines"]]
    hertz = of("frequency", found)
    head = [headed("frequency", hertz), "order", headed("amplitude", of("amplitude", found))]
    said = table(head, rows) or ["no lines: nothing moves"]
    return [*said, f"from 0 to {short(found['until'])} in steps of {short(found['resolution'])} {hertz}".rstrip()]


def cobweb_words(found: Found) -> list[str]:
    """Return the letters, the range and the end of an orbit."""
    dots = "..." if found["steps"] > len(found["letters"]) else ""
    said = [f"letters: {found['letters']}{dots}"]
    if found["range"] is not None:  # else it had ended before the first point
        said.append(f"{found['coordinate']} {between(found['range'])}; last {short(found['last'])}")
    if found["ended"] is not None:
        said.append(f"ended at step {found['ended']}")
    return [*said, *event_words(found["events"])]


def graph_words(found: Found) -> list[str]:
    """Return where each letter is taken, and how far the two maps differ."""
    name = found["coordinate"]
    rows = [[row["map"], row["letter"], str(row["states"]), places(row["ranges"])] for row in found["letters"]]
    said = table(["map", "letter", "states", f"{headed(name, found.get('unit', ''))} from"], rows)
    if "agree" in found:
        gaps = ", ".join(f"{short(gap, 3)} in {key}" for key, gap in found["differ"].items())
        agree = f"letters agree at {found['agree']} of {found['states']} states"
        said.append(f"{agree}; there the images differ by at most {gaps}" if gaps else agree)
    return [*said, *event_words(found["events"])]


def event_words(events: Mapping[str, int]) -> list[str]:
    """Return what happened at some steps."""
    told = ", ".join(f"{name.replace('_', ' ')} at {count} steps" for name, count in events.items())
    return [told.replace(" 1 steps", " 1 step")] if told else []


WORDS: dict[str, Callable[[Found], list[str]]] = {
    "diagram": diagram_words, "density": density_words, "chart": chart_words, "basins": basins_words,
    "lyapunov": lyapunov_words, "coexistence": coexistence_words, "trajectory": trajectory_words,
    "history": trajectory_words, "sample": sample_words, "spectrum": spectrum_words, "cobweb": cobweb_words,
    "graph": graph_words,
}  # fmt: skip
