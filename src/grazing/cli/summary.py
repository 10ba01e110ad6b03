"""The summary of what a command did, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from grazing.catalogue.study import Study
from grazing.cli import output, progress
from grazing.outcome import printable

#: Names of variables that a line shows, of each unit or sign.
MOST = 3


def lines(summary: Mapping[str, Any], study: Study) -> list[str]:
    """Return the summary in words."""
    sizes = ", ".join(f"{name} {size}" for name, size in summary["sizes"].items())
    time = f"time:    {progress.duration(summary['seconds'])}"
    units = [*units_line(summary["units"]), *signs_line(summary)]
    said = [printable(summary["title"], newlines=False), *([f"sizes:   {sizes}"] if sizes else []), *units, time]
    none = f"nothing; -o {study.name}.png or -o result.nc keeps it"
    if not study.drawn_by:
        none = f"nothing; -o {study.name}s.nc keeps the table{', --save folder the proofs' if study.proves else ''}"
    return [*said, f"written: {output.named(summary['files']) or none}"]


def units_line(units: Mapping[str, Sequence[str]]) -> list[str]:
    """Return what has which units in a line, cut where many have the same; nothing of a dimensionless result."""
    said = [f"{unit} ({some(names)})" for unit, names in units.items()]
    return [f"units:   {', '.join(said)}"] if said else []


def signs_line(summary: Mapping[str, Any]) -> list[str]:
    """Return which variables count downwards, as those of a rig with its stop above do, in a line or none."""
    down = summary.get("down", [])
    return [f"signs:   positive down: {some(down)}; figures show x, upwards"] if down else []


def some(names: Sequence[str]) -> str:
    """Return the first of several names, with dots where there are more."""
    return ", ".join([*names[:MOST], *(["..."] if len(names) > MOST else [])])
