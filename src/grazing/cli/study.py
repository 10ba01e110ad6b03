"""The commands of the studies, made from the schema: ``grazing diagram``, ``density``, ``chart`` and so on."""

from __future__ import annotations

import json as text
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from inspect import Parameter as Argument
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from grazing.cli import output, progress
from grazing.cli.figures import style_of
from grazing.cli.found_words import words_of
from grazing.cli.options import RUN, recipe_from, signature_of
from grazing.cli.orbit_rows import plain
from grazing.cli.rig import as_given
from grazing.cli.summary import lines
from grazing.cli.whole import whole_number
from grazing.config import command_of, plan_of, result_of, toml_of
from grazing.config.settings import SINGLE, STUDIES, WHOLE
from grazing.outcome import InputError
from grazing.parameter import whole
from grazing.studies.found import found as found_in

DONE, INCOMPLETE = 0, 3
#: What a study can prove.
PROVEN = {"orbit": "each admissible orbit", "windows": "the edges of the windows"}
#: What follows when all cells are computed, where that takes long.
THEN = {"basins": "following the attractors and the grazing curve", "coexistence": "following the attractors"}


def run_arguments(study: str) -> list[Argument]:
    """Return the options that are the same for every study."""

    def one(argument: str, kind: Any, default: Any, says: str, **more: Any) -> Argument:
        annotation = Annotated[kind, Parameter(help=says, group=RUN, show_default=False, negative=(), **more)]
        return Argument(argument, Argument.KEYWORD_ONLY, default=default, annotation=annotation)

    files = output.HELP if study not in WHOLE else output.HELP.rpartition(", zarr")[0] + "."
    if study == "orbit":
        files = "File to write; may be repeated. Its ending chooses the format: nc (result), csv or parquet (tables)."
    found = [
        one("out", list[Path] | None, None, files, name=("--out", "-o"), metavar="FILE"),
        one("config", Path | None, None, "TOML file that gives defaults; options override.", metavar="FILE"),
    ]
    if study in PROVEN:
        found.append(
            one("certify", bool, False, f"Prove {PROVEN[study]} in ball arithmetic; exit code 1 if one fails.")
        )
        says = "Write the certificates: FILE.json, numbered if there are several, or FOLDER. Implies --certify."
        found.append(one("save", Path | None, None, says, metavar="FILE|FOLDER"))
    if study not in (*SINGLE, "graph", "windows"):
        says = "Threads; one per processor if not given. The result does not depend on it."
        found.append(one("threads", int | None, None, says, metavar="N", converter=whole_number))
    if study not in WHOLE:
        found.append(one("dry_run", bool, False, "Print size, memory and estimated time, and compute nothing."))
    return [
        *found,
        one("dump_config", bool, False, "Print the configuration as TOML, complete, and compute nothing."),
        one("json", bool, False, "Print a summary as one JSON object."),
        one("quiet", bool, False, "Show no progress.", alias="-q"),
    ]


def command(study: str) -> Callable[..., int]:
    """Return the command of a study."""

    def run(
        *given: str,
        out: list[Path] | None = None,
        config: Path | None = None,
        threads: int | None = None,
        dry_run: bool = False,
        dump_config: bool = False,
        json: bool = False,
        quiet: bool = False,
        certify: bool = False,
        save: Path | None = None,
        **options: str | bool | None,
    ) -> int:
        recipe = recipe_from(study, given, options, config)
        if dump_config:
            print(toml_of(recipe), end="")
            return DONE
        if threads is not None:
            whole(threads, "--threads", 1)
        if dry_run:
            return estimated(plan_of(recipe), threads, json)
        files, shown = output.targets(out, endings(study)), output.checked_units(recipe.get("units"))
        if study in ("orbit", "branch", "windows", "bifurcations", "response"):
            from grazing.cli.orbit_study import compute as found

            return found(recipe, files, threads, shown, json, quiet, certify or save is not None, save)
        return compute(recipe, files, threads, shown, json, quiet)

    run.__signature__ = signature_of(study, run_arguments(study))  # type: ignore[attr-defined]
    run.__annotations__ = {name: item.annotation for name, item in run.__signature__.parameters.items()}  # type: ignore[attr-defined]
    run.__name__ = study
    return run


def endings(study: str) -> tuple[str, ...]:
    """Return the endings of the files that a study can write."""
    if study == "orbit":
        return (".nc", ".csv")
    return output.ENDINGS if study not in WHOLE else output.ENDINGS[:-1]


def compute(
    recipe: Mapping[str, Any], files: Sequence[Path], threads: int | None, units: Sequence[str], json: bool, quiet: bool
) -> int:
    """Compute a recipe, write its files and say what was done."""
    drawn = [str(file) for file in files if file.suffix in output.FIGURES]
    if drawn and recipe["study"] == "lyapunov" and not recipe["vary"]:
        raise InputError(
            f"-o {drawn[0]}: there is no figure of exponents at one value; vary a parameter, or give -o a.nc"
        )
    start = time.monotonic()
    what = "values" if len(recipe["vary"]) == 1 else "cells"
    stores = [file for file in files if file.suffix == output.STORE]
    style = style_of(recipe, quiet) if drawn else {}  # before the long computation: what is wrong is said at once
    with progress.counted(what, quiet, THEN.get(recipe["study"], "")) as show:
        if stores:
            result = swept(plan_of(recipe), stores[0], threads, show)
        else:
            result = result_of(recipe, threads=threads, progress=show)
    seconds = time.monotonic() - start
    result = output.converted_as_far(result, units)
    written = [str(file) for file in stores]
    for file in files:
        if file not in stores:
            written += output.write(result, file, **style)
    result = as_given(result, units)
    found = found_in(recipe["study"], result)
    summary = {
        "study": recipe["study"],
        **output.described(result),
        "seconds": round(seconds, 3),
        "files": written,
        "config_sha256": result.attrs.get("grazing_config_sha256"),
        "command": command_of(recipe, [str(file) for file in files]),
        "found": plain(found),
    }
    head, *rest = lines(summary)
    print(text.dumps(summary) if json else "\n".join([head, "", *words_of(recipe["study"], found), *rest]))
    sys.stdout.flush()
    return DONE


def swept(plan: Any, store: Path, threads: int | None, show: progress.Counted) -> Any:
    """Compute a plan chunk by chunk into a store, which can be resumed, and open it."""
    from grazing.cli.sweep import asked, resumable
    from grazing.sweep import open_store, run

    with resumable(store):
        asked(partial(run, plan, store, threads=threads, progress=show), False)
    return open_store(store, plan)


def estimated(plan: Any, threads: int | None, json: bool) -> int:
    """Print what a plan would take."""
    if plan.sequential:
        size = plan.memory(plan.cells, 1)
        summary = {"title": plan.title, "cells": plan.cells, "bytes": size}
        words = f"{plan.title}: {plan.cells} cells, each after its neighbour\n{size / 1e6:.3g} MB"
        print(text.dumps(summary) if json else words)
        return DONE
    from grazing.sweep import estimate

    found = estimate(plan, threads=threads)
    print(text.dumps(asdict(found)) if json else str(found))
    return DONE


def __getattr__(name: str) -> Callable[..., int]:
    """Make the command of a study when it is first asked for."""
    if name not in STUDIES:
        raise AttributeError(name)
    return command(name)
