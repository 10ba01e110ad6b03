"""Run the command line with ``python -m grazing``."""

import sys
from pathlib import Path

if (
    __name__ == "__main__"
    and "-m" in sys.orig_argv
    and not sys.flags.safe_path
    and sys.path[0] != str(Path(__file__).parents[1])
):
    del sys.path[0]  # the folder that this runs in: packages would be looked for among its files, and be run


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
