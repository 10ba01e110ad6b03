"""Studies of orbits from the command line: tables, figures and certificates."""

from __future__ import annotations

import json as text
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from grazing.cli import output, progress
from grazing.cli.certificates import certificates_at, orbit_proofs, proof_lines, window_proofs, written_proofs
from grazing.cli.orbit_rows import TABLES, plain
from grazing.cli.orbit_words import WORDS
from grazing.cli.rig import as_given, given_names
from grazing.cli.summary import lines
from grazing.config import command_of, result_of
from grazing.config.build import orbits_as_table, orbits_of

DONE, FAILED = 0, 1
#: What takes long, in words.
DOES = {"orbit": "searching for orbits", "branch": "following branches", "windows": "looking for windows"}


def compute(
    recipe: Mapping[str, Any], files: Sequence[Path], threads: int | None, units: Sequence[str], json: bool,
    quiet: bool, certify: bool, save: Path | None,
) -> int:  # fmt: skip
    """Compute a recipe, write its files, prove what is to be proven, and say what was found."""
    study, start = recipe["study"], time.monotonic()
    target = None if save is None else certificates_at(save)
    found: Any = None
    if study in ("bifurcations", "response"):
        with progress.counted("values", quiet, "points of branches") as show:
            result = result_of(recipe, threads=threads, progress=show)
    else:
        with progress.said(DOES[study], quiet):
            if study == "orbit":
                found = orbits_of(recipe, threads)
                result = orbits_as_table(found, dict(recipe))
            else:
                result = result_of(recipe, threads=threads)
    shown = output.converted_as_far(result, units)
    printed = as_given(shown, units)
    tables = TABLES[study](printed)
    good = True
    if certify:
        with progress.said("proving", quiet):
            proofs = orbit_proofs(found) if study == "orbit" else window_proofs(recipe, result)
        good = all(proof["proven"] or not proof["due"] for proof in proofs)
        tables["proofs"] = written_proofs(proofs, target)
    seconds = time.monotonic() - start
    written = [name for file in files for name in output.write(shown, file)]
    written += [proof["file"] for proof in tables.get("proofs", ()) if proof.get("file")]
    summary = {
        "study": study,
        **output.described(printed),
        "seconds": round(seconds, 3),
        "files": written,
        "config_sha256": result.attrs.get("grazing_config_sha256"),
        "command": command_of(recipe, [str(file) for file in files]),
    }
    if json:
        print(text.dumps(plain({**summary, **tables})))
    else:
        head, *rest = lines(summary)
        if study == "orbit" and not written:
            rest[-1] = "written: nothing; -o orbits.nc keeps the table, --save folder the proofs"
        print(
            "\n".join(
                [head, "", *WORDS[study](tables, printed, given_names(printed, recipe)), *proof_lines(tables), *rest]
            )
        )
    sys.stdout.flush()
    return DONE if good else FAILED
