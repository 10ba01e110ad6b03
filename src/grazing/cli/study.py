"""The commands of the studies, made from the schema: ``grazing diagram``, ``density``, ``chart`` and so on."""

from __future__ import annotations

import json as text
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict
from functools import partial
from inspect import Parameter as Argument
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from grazing.catalogue import studies
from grazing.catalogue.rows import plain, told
from grazing.catalogue.study import Study
from grazing.catalogue.words import words_of
from grazing.cli import output, progress
from grazing.cli.certificates import certificates_at, proof_lines, written_proofs
from grazing.cli.figures import style_of
from grazing.cli.options import RUN, Asked, asked_from, signature_of
from grazing.cli.rig import as_given, given_names
from grazing.cli.summary import lines
from grazing.cli.whole import whole_number
from grazing.config import command_of, plan_of, toml_of
from grazing.config.build import Made, made_of
from grazing.outcome import InputError
from grazing.parameter import whole

DONE, FAILED, INCOMPLETE = 0, 1, 3


def run_arguments(study: Study) -> list[Argument]:
    """Return the options that are the same for every study."""

    def one(argument: str, kind: Any, default: Any, says: str, **more: Any) -> Argument:
        annotation = Annotated[kind, Parameter(help=says, group=RUN, show_default=False, negative=(), **more)]
        return Argument(argument, Argument.KEYWORD_ONLY, default=default, annotation=annotation)

    files = output.help_of(endings(study))
    found = [
        one("out", list[Path] | None, None, files, name=("--out", "-o"), metavar="FILE"),
        one("config", Path | None, None, "TOML file that gives defaults; options override.", metavar="FILE"),
    ]
    if study.proves:
        found.append(one("certify", bool, False, f"Prove {study.proves} in ball arithmetic; exit code 1 if one fails."))
        says = "Write the certificates: FILE.json, numbered if there are several, or FOLDER. Implies --certify."
        found.append(one("save", Path | None, None, says, metavar="FILE|FOLDER"))
    if study.has("threads"):
        says = "Threads; one per processor if not given. The result does not depend on it."
        found.append(one("threads", int | None, None, says, metavar="N", converter=whole_number))
    if study.plan:
        found.append(one("dry_run", bool, False, "Print size, memory and estimated time, and compute nothing."))
    return [
        *found,
        one("dump_config", bool, False, "Print the configuration as TOML, complete, and compute nothing."),
        one("json", bool, False, "Print a summary as one JSON object."),
        one("quiet", bool, False, "Show no progress.", alias="-q"),
    ]


def command(study: Study) -> Callable[..., int]:
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
        asked = asked_from(study.name, given, options, config)
        recipe = asked.recipe
        if dump_config:
            print(toml_of(recipe), end="")
            return DONE
        if threads is not None:
            whole(threads, "--threads", 1)
        if dry_run:
            return estimated(plan_of(recipe), threads, json, seconds_of_curves(recipe))
        files, shown = output.targets(out, endings(study)), output.checked_units(recipe.get("units"))
        return compute(study, asked, files, threads, shown, json, quiet, certify or save is not None, save)

    run.__signature__ = signature_of(study.name, run_arguments(study))  # type: ignore[attr-defined]
    run.__annotations__ = {name: item.annotation for name, item in run.__signature__.parameters.items()}  # type: ignore[attr-defined]
    run.__name__ = study.name
    return run


def endings(study: Study) -> tuple[str, ...]:
    """Return the endings of the files that a study can write."""
    drawn, stored = output.FIGURES if study.drawn_by else (), (output.STORE,) if study.plan else ()
    return (
        *drawn,
        *output.DATA,
        *stored,
        *((output.SOUND,) if study.sounds else ()),
        *((output.FILM,) if study.tables else ()),
    )


def compute(
    study: Study, asked: Asked, files: Sequence[Path], threads: int | None, units: Sequence[str], json: bool,
     quiet: bool, certify: bool = False, save: Path | None = None,
) -> int:  # fmt: skip
    """Compute a recipe, write its files, prove what is to be proven, and say what was found."""
    recipe = asked.recipe
    drawn = [str(file) for file in files if file.suffix in output.FIGURES]
    if drawn and study.undrawn and not recipe["vary"]:
        raise InputError(f"-o {drawn[0]}: {study.undrawn}; vary a parameter, or give -o a.nc")
    target = None if save is None else certificates_at(save)
    start = time.monotonic()
    stores = [file for file in files if file.suffix == output.STORE]
    style = style_of(recipe, quiet) if drawn else {}  # before the long computation: what is wrong is said at once
    with underway(study, recipe, quiet) as show:
        if stores:
            result = swept(plan_of(recipe), stores[0], threads, show)
            made = Made(None, result, result)
        else:
            made = made_of(recipe, threads, show)
    result = output.converted_as_far(made.result, units)
    given = as_given(result, units, asked.gaps)
    found = told(study, given)
    if certify and study.prove is not None:
        with progress.said("proving", quiet):
            proofs = study.prove(made.of, made.found)
        found["proofs"] = written_proofs(proofs, target)
    seconds = time.monotonic() - start
    written = [str(file) for file in stores]
    for file in files:
        if file not in stores:
            written += output.write(made.result if file.suffix == output.SOUND else result, file, **style)
    written += [proof["file"] for proof in found.get("proofs", ()) if proof.get("file")]
    summary = {
        "study": study.name,
        **output.described(given),
        "seconds": round(seconds, 3),
        "files": written,
        "config_sha256": result.attrs.get("grazing_config_sha256"),
        "command": command_of(recipe, [str(file) for file in files]),
    }
    if json:
        print(text.dumps({**summary, **(plain(found) if study.orbits else {"found": plain(found)})}))
    else:
        head, *rest = lines(summary, study)
        print(
            "\n".join(
                [head, "", *words_of(study, found, given, given_names(given, recipe)), *proof_lines(found), *rest]
            )
        )
    sys.stdout.flush()
    return DONE if all(proof["proven"] or not proof["due"] for proof in found.get("proofs", ())) else FAILED


def underway(study: Study, recipe: Mapping[str, Any], quiet: bool) -> AbstractContextManager[progress.Counted | None]:
    """Give what shows how far a study is: a count, or what is going on where it has nothing to count."""
    if study.takes_long and not study.has("progress"):
        return progress.said(study.takes_long, quiet)
    what = "steps" if not study.most else "values" if len(recipe["vary"]) == 1 else "cells"
    if study.form == "bounds":  # values of its own choice, each of which may take long
        return progress.counted(what, quiet, first=study.takes_long)
    return progress.counted(what, quiet, then=study.takes_long)


def swept(plan: Any, store: Path, threads: int | None, show: progress.Counted | None) -> Any:
    """Compute a plan chunk by chunk into a store, which can be resumed, and open it."""
    from grazing.cli.sweep import asked, resumable
    from grazing.sweep import open_store, run

    with resumable(store, plan.recipe or {}):
        asked(partial(run, plan, store, threads=threads, progress=show), False)
    return open_store(store, plan)


def seconds_of_curves(recipe: Mapping[str, Any]) -> int:
    """Return about how long the exact curves of a chart take beside its cells; those of the gap map take no time."""
    from grazing.orbits.boundaries import SECONDS

    periods = [one for one in recipe.get("curves") or () if isinstance(one, int)]
    return SECONDS * len(periods) if recipe["map"] != "gap" else 0


def estimated(plan: Any, threads: int | None, json: bool, curves: int = 0) -> int:
    """Print what a plan would take, and the seconds that its curves would, in a figure, where there are some."""
    if plan.sequential:
        size = plan.memory(plan.cells, 1)
        summary = {"title": plan.title, "cells": plan.cells, "bytes": size}
        words = f"{plan.title}: {plan.cells} cells, each after its neighbour\n{size / 1e6:.3g} MB"
        print(text.dumps(summary) if json else words)
        return DONE
    from grazing.sweep import estimate

    found = estimate(plan, threads=threads)
    beside = f"\nand its curves, in a figure, some {curves} s" if curves else ""
    print(text.dumps(asdict(found) | ({"seconds_of_curves": curves} if curves else {})) if json else f"{found}{beside}")
    return DONE


def __getattr__(name: str) -> Callable[..., int]:
    """Make the command of a study when it is first asked for."""
    if name not in studies():
        raise AttributeError(name)
    return command(studies()[name])
