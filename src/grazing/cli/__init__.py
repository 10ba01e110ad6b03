"""The command line: it parses, calls and reports, and does no mathematics.

Exit codes: 0 done, 1 failed, 2 wrong usage or input, 3 incomplete (a sweep that can be resumed), 130 interrupted.
"""

from grazing.cli.app import app, main

__all__ = ["app", "main"]
