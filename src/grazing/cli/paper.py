"""``grazing paper``: the figures of the paper and the check of its claims."""

from __future__ import annotations

import json as text
import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from grazing.cli import progress
from grazing.cli.whole import as_written
from grazing.outcome import InputError
from grazing.paper import FIGURES

_FIGURES_HELP = f"Figures to draw, such as 1.6 or 1.6,3.2; may be repeated. All by default: {', '.join(FIGURES)}."


def paper(
    *,
    out: Annotated[Path, Parameter(converter=as_written)] = Path("out/paper"),
    figures: Annotated[list[str] | None, Parameter(help=_FIGURES_HELP, consume_multiple=True)] = None,
    size: Literal["small", "paper", "large"] = "paper",
    json: bool = False,
    quiet: Annotated[bool, Parameter(alias="-q")] = False,
) -> int:
    """Draw the figures of the paper and check its claims.

    Parameters
    ----------
    out
        Folder for the results; made if it is not there.
    figures
        Figures to draw.
    size
        How much is computed: small to try it out, paper for print, large for a poster.
    json
        Print the summary as one JSON object.
    quiet
        Show no progress.
    """
    if not str(out):
        raise InputError("--out is empty; give a folder that can be made and written to, such as out/paper")
    chosen = split(figures)
    start = time.monotonic()
    with progress.shown(quiet) as show:
        from grazing.paper.report import report

        summary = report(out=str(out), figures=chosen, size=size, progress=show)
    summary |= {"seconds": round(time.monotonic() - start, 3)}
    print(text.dumps(summary) if json else "\n".join(lines(summary)))
    sys.stdout.flush()
    return 0


def split(figures: Sequence[str] | None) -> list[str] | None:
    """Return the figures asked for, commas split and repetitions dropped; None for all of them."""
    if figures is None:
        return None
    names = [name.strip() for item in figures for name in item.split(",")]
    names = list(dict.fromkeys(name for name in names if name))
    if not names:
        raise InputError(f"--figures is empty; allowed are {', '.join(FIGURES)}: name some, or leave the option out")
    return names


def lines(summary: Mapping[str, Any]) -> list[str]:
    """Return the summary of a report in words."""
    verdicts = summary["verdicts"]
    said = [
        f"figures: {', '.join(summary['figures'])}",
        f"claims:  {summary['claims']} (agree: {verdicts['agrees']}, corrected: {verdicts['corrected']}, "
        f"differ: {verdicts['differs']})",
        f"results: {os.path.join(summary['folder'], 'index.html')} and {len(summary['files']) - 1} more files, "
        f"in {summary['seconds']:.1f} s",
    ]
    if summary["differs"]:
        said.insert(2, f"differ:  {', '.join(summary['differs'])}")
    return said
