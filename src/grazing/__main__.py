"""Run the command line with ``python -m grazing``."""

import sys

from grazing.interrupt import interrupt_in, none_lost, taken


def main() -> int:
    """Run the command line; an interrupt while its packages are still imported is no traceback, either."""
    try:
        with none_lost():
            from grazing.cli import main as run

            return run()
    except BaseException as error:  # Python says of one in the making of a class that a name cannot be set
        if interrupt_in(error) is None:
            raise
    taken()
    print("stopped: interrupted.", file=sys.stderr)
    return 130


if __name__ == "__main__":
    raise SystemExit(main())
