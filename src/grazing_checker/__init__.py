"""A checker of certificates that needs python-flint and Python's standard library only.

It runs from a copy of this folder, ``python -m grazing_checker FILE...``, and uses nothing of the program that found
the proofs. What it reads are claims: every number in a certificate may be wrong, and what is said follows from the data
or is rejected.
"""

import sys

if (
    sys.argv[:1] == ["-m"]
    and any(one.endswith("grazing_checker") for one in sys.orig_argv)  # also in -mgrazing_checker
    and not sys.flags.safe_path
):
    del sys.path[0]  # the folder that this runs in: packages would be looked for beside a certificate, and be run

from grazing_checker.check import TRUSTED_BASE, check
from grazing_checker.envelope import VERSION
from grazing_checker.reading import Rejected

__all__ = ["TRUSTED_BASE", "VERSION", "Rejected", "check"]
