"""``grazing orbit``, ``branch``, ``windows``, ``bifurcations``, ``response``: tables, figures and certificates."""

from __future__ import annotations

import json as text
import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, Parameter

from grazing.cli import output, progress
from grazing.cli.certificates import certificates_at, orbit_proofs, proof_lines, window_proofs, written_proofs
from grazing.cli.orbit_rows import TABLES, plain
from grazing.cli.orbit_words import WORDS
from grazing.cli.streams import printable
from grazing.cli.study import command, lines
from grazing.config import command_of, result_of
from grazing.config.build import RECIPE, orbits_as_table, orbits_of
from grazing.outcome import InputError

DONE, FAILED = 0, 1
#: What takes long, in words.
DOES = {"orbit": "searching for orbits", "branch": "following branches", "windows": "looking for windows"}

orbit = App(name="orbit", help_format="plaintext", default_parameter=Parameter(negative=(), json_list=False))
orbit.default(command("orbit"))


@orbit.command
def check(
    files: Annotated[list[Path], Parameter(name="CERTIFICATE", help="Files .json that --save wrote.")],
    /,
    *,
    model: Annotated[
        Path | None,
        Parameter(
            help="file.py:name of a gz.Oscillator whose reset law is compared with the proven ones.", metavar="NAME"
        ),
    ] = None,
    json: Annotated[
        bool, Parameter(help="Print the verdicts as JSON objects, a line each.", show_default=False)
    ] = False,
) -> int:
    """Verify certificates anew, without the code that found them.

    Prints the sentences that are proven; exit code 1 if one is not.
    """
    from grazing.proof.check import check_certificate

    for file in files:
        if not os.path.isfile(file):
            raise InputError(f"there is no file {file}; give a certificate, which 'grazing orbit --save' writes")
    law = None
    if model is not None:
        from grazing.config.maps import own_model
        from grazing.config.own import Named

        law = own_model(Named(str(model))).reset.law
    every = True
    for file in files:
        try:
            said, good = check_certificate(file, law=law), True
        except InputError as error:
            said, good = str(error), False
        every = every and good
        if json:
            print(text.dumps({"file": str(file), "verified": good, "statement" if good else "reason": said}))
        else:
            where = sys.stdout if good else sys.stderr
            print(
                f"{output.named([str(file)])}: {'verified' if good else 'NOT verified'}\n{printable(said)}", file=where
            )
    return DONE if every else FAILED


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
    tables = TABLES[study](shown)
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
        "title": str(result.attrs.get("title", "")),
        "sizes": {str(name): size for name, size in result.sizes.items()},
        "units": output.units_of(shown),
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
        print("\n".join([head, "", *WORDS[study](tables, shown, recipe), *proof_lines(tables), *rest]))
    sys.stdout.flush()
    return DONE if good else FAILED


# ---- figures


def branch_figure(result: Any, **style: Any) -> Mapping[str, Any]:
    """Draw a branch, and beside it the loci of its special points if there are any."""
    from grazing import plot
    from grazing.compare.word_branches import loci_of

    recipe = text.loads(result.attrs.get(RECIPE, "{}"))
    if recipe:
        style = {"virtual": bool(recipe["settings"].get("virtual")), **style}
    loci = loci_of(result)
    if not loci:
        return plot.branch(result, plot.panels(174.0, 80.0)[1][0], **style)
    figure, (left, right) = plot.panels(174.0, 80.0, columns=2)
    plot.branch(result, left, **style)
    plot.locus(loci, right, virtual=style.get("virtual", True), names=style.get("names", True))
    return {"figure": figure}
