"""A pinball table in a configuration: which map of it is meant, and what means nothing beside it."""

from __future__ import annotations

import os
from contextlib import suppress
from functools import partial
from math import cos, sin
from typing import Any

from grazing.catalogue import studies
from grazing.catalogue.study import COORDINATE
from grazing.config.own import LONGEST
from grazing.config.problems import Problem, unknown_key
from grazing.config.schema import TABLE_MAPS
from grazing.config.tables import read_table, shipped
from grazing.config.values import number
from grazing.outcome import GrazingError, shown


def usual_map(study: str) -> str | None:
    """Return the map of a table that a study is of unless one is named; None for one of the table itself."""
    known = studies().get(study)
    if known is not None and known.of == "model":
        return None
    return "launch" if known is not None and known.varies == COORDINATE else "collision"


def with_map(raw: dict[str, Any], folder: str) -> None:
    """Say which map of a table is meant where none is named, and take a file's place from a folder."""
    if (kind := usual_map(str(raw.get("study")))) is not None:
        raw.setdefault("map", kind)
    if raw["table"] not in shipped() and len(raw["table"]) <= LONGEST:
        with suppress(OSError, ValueError):  # what cannot be the name of a file is said where it is opened
            raw["table"] = os.path.realpath(os.path.join(folder, raw["table"]))
    study, settings = studies().get(str(raw.get("study"))), raw.get("settings", {})
    if study is not None and study.flown and study.tables and isinstance(settings, dict) and "state" not in settings:
        if (state := launched(raw["table"], raw.get("parameters"))) is not None:
            raw["settings"] = {**settings, "state": state}


def launched(file: str, parameters: Any) -> list[float] | None:
    """Return the state of a ball that a table's plunger launches, as fast as it can; None for a table without one.

    What is wrong with the table or its parameters is said later.
    """
    try:
        table = read_table(file)
        if not isinstance(parameters or {}, dict):
            return None
        given = {name: number(x, name) for name, x in (parameters or {}).items()}
        shot = table.replace(**given).plunger
    except GrazingError:
        return None
    return None if shot is None else [shot.x, shot.y, shot.fast * cos(shot.angle), shot.fast * sin(shot.angle)]


def beside_table(config: dict[str, Any]) -> Problem | None:
    """Return what means nothing for a table; or that there is none where one is needed."""
    study, kind = studies().get(config.get("study", "")), config["map"]
    if not config.get("table"):
        if study is None or not study.tables_only:
            return None
        return Problem(
            ("table",), f"missing; {study.name} are of a pinball table: {', '.join(shipped())} or a TOML file"
        )
    for key in ("law", "model", "walls", "mass", "base", "stop", "units", "order", "unfold"):
        if config.get(key) is not None:
            return Problem((key,), f"the table brings all that is on it; leave the {key} out")
    if study is not None and study.of == "model":
        if kind != "stroboscopic":
            return Problem(("map",), f"map = {shown(kind)}; a {study.name} is of the table itself: leave it out")
        return None if study.tables else Problem(("table",), f"{study.name} is offered for oscillators only")
    usual = usual_map(study.name) if study is not None and study.tables_only else None
    allowed = TABLE_MAPS if usual is None else {usual: TABLE_MAPS[usual]}
    if kind not in allowed:
        return Problem(("map",), partial(unknown_key, kind, allowed, f"map = {shown(kind)}"))
    return None
