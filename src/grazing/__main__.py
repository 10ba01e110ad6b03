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

from grazing.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
