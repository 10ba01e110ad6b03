"""Run the command line with ``python -m grazing``."""

import sys


def main() -> int:
    """Run the command line; an interrupt while its packages are still imported is no traceback, either."""
    try:
        from grazing.cli import main as run
    except KeyboardInterrupt:
        print("stopped: interrupted.", file=sys.stderr)
        return 130
    return run()


if __name__ == "__main__":
    raise SystemExit(main())
