"""Run the command line with ``python -m grazing``."""

from grazing.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
