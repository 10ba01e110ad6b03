"""``python -m grazing_checker FILE...``: print what each certificate proves; exit 1 if one proves nothing."""

import os
import re
import sys

from grazing_checker import Rejected, check

#: A name of a file that is printed as it is; a sentence is none.
PLAIN = re.compile(r"[\w./\\:~+=@,-]+")


def main(files: list[str]) -> int:
    """Check certificates; 0 if all are right, 1 if one is rejected, 2 if none is named."""
    if not files or any(name.startswith("-") for name in files):
        print("usage: python -m grazing_checker FILE...", file=sys.stderr)
        return 2
    anything = getattr(sys.stdout, "reconfigure", None)
    if anything is not None:  # the name of a file need not be text
        anything(errors="backslashreplace")
    try:
        wrong = max([_checked(name) for name in files])
        print(end="", flush=True)
    except OSError as error:  # of the output: its reader has left, or its disk is full
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left of it goes nowhere
        wrong = 1
        if not isinstance(error, BrokenPipeError):
            print(f"what certificates prove cannot be written: {error.strerror}", file=sys.stderr)
    return wrong


def _checked(name: str) -> int:
    """Print what a certificate proves; 1 if it is rejected."""
    shown = name if PLAIN.fullmatch(name) else repr(name)
    try:
        print(f"{shown}: {check(name)}")
    except Rejected as error:
        print(f"{shown}: rejected: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
