"""``grazing orbit``, and ``grazing orbit check``, which verifies certificates."""

from __future__ import annotations

import json as text
import os
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from grazing.cli import output
from grazing.cli.study import __getattr__ as command_of
from grazing.outcome import InputError, printable
from grazing.paths import opened

DONE, FAILED = 0, 1

orbit = App(name="orbit", help_format="plaintext", default_parameter=Parameter(negative=(), json_list=False))
orbit.default(command_of("orbit"))


@orbit.command
def check(
    files: Annotated[list[Path], Parameter(name="CERTIFICATE", help="Files .json that --save wrote.")],
    /,
    *,
    model: Annotated[
        Path | None,
        Parameter(
            help="file.py:name of a gz.Oscillator that the proofs must be about, with its law and values.",
            metavar="NAME",
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
        with opened(file):  # what cannot be read is no certificate that fails
            pass
    own = None
    if model is not None:
        from grazing.config.maps import own_model
        from grazing.config.own import Named

        own = own_model(Named(str(model)))
    every = True
    for file in files:
        try:
            said, good = check_certificate(file, model=own), True
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
