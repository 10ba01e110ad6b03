"""The command line: `python -m benchmarks [PART ...] [options]`; the parts are those of PARTS."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from fnmatch import fnmatch
from pathlib import Path

from rich.console import Console

from .against import BadKernel, parsed
from .chatter import FOLLOWERS, chatter, show_bounces
from .explorer import respond, show_responses
from .finders import FINDERS
from .flippers import basins, flippers, show_flippers
from .forms import forms, show_forms
from .goals import goals
from .measure import measure
from .pinball import pinball, show_pinball
from .report import write
from .rows import rows
from .shallow import shallow, show_shares
from .speeds import show_goals, show_speeds
from .studies import cost, show_costs

PARTS = ("speed", "shallow", "chatter", "studies", "explorer", "forms", "pinball")
#: Parts that are no rows of programs, which --only could choose from.
WHOLE = {"studies", "explorer", "forms", "pinball"}
#: Studies take seconds each: so many rounds are enough.
STUDY_ROUNDS = 5
QUICK = 0.2  # share of the work, of the fixed set and of the rounds in a quick run


class BadInput(ValueError):
    """What is wrong with the command line."""


def parser() -> argparse.ArgumentParser:
    """Return the options."""
    options = argparse.ArgumentParser(prog="benchmarks", description="Compare grazing with other programs, in one run.")
    options.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(PARTS)}; default: all of them")
    quick = "less work, fewer rounds: under a minute once compiled, five for explorer"
    options.add_argument("--quick", action="store_true", help=quick)
    options.add_argument("--rounds", type=int, help="how often each row is timed (default 15, quick 3)")
    options.add_argument(
        "--only",
        action="append",
        metavar="PATTERN",
        help="only rows whose name holds it, * for anything; may be repeated",
    )
    options.add_argument("--against", metavar="FILE:FUNCTION", help="add a numba kernel of another file as rows")
    options.add_argument("--json", metavar="FILE", type=Path, help="write what was measured to a file")
    return options


def selected(names: Iterable[str], patterns: Sequence[str] | None) -> list[str]:
    """Return the names that hold one of the patterns, in which * stands for anything."""
    wanted = [f"*{pattern.lower()}*" for pattern in patterns or [""]]
    return [name for name in names if any(fnmatch(name.lower(), pattern) for pattern in wanted)]


def writable(file: Path) -> bool:
    """Whether a file can be written."""
    return not file.is_dir() and os.access(file if file.exists() else file.parent, os.W_OK)


def teller() -> Callable[[str], None]:
    """Return what says on one line of a terminal what is being done; silent elsewhere."""
    if not sys.stderr.isatty():
        return lambda what: None
    return lambda what: print(f"\r\x1b[K{what}", end="", file=sys.stderr, flush=True)


def run(tokens: Sequence[str] | None = None) -> None:
    """Do what the command line asks for; raise BadInput for what cannot be done."""
    options = parser().parse_args(tokens)
    parts = set(options.parts or PARTS)
    if unknown := sorted(parts - set(PARTS)):
        raise BadInput(f"there is no part {unknown[0]!r}; choose from {', '.join(PARTS)}")
    rounds = options.rounds if options.rounds is not None else (3 if options.quick else 15)
    if rounds < 1:
        raise BadInput(f"--rounds is {rounds}; give 1 or more")
    if options.json is not None and not writable(options.json):
        raise BadInput(f"--json is {options.json}; give a file in a folder that exists and can be written to")
    other = parsed(options.against) if options.against else None

    every = {row.name: row for row in rows(other)} if "speed" in parts else {}
    finders = list(FINDERS) if "shallow" in parts else []
    followers = list(FOLLOWERS) if "chatter" in parts else []
    names = [selected(group, options.only) for group in (every, finders, followers)]
    if not any(names) and (not parts <= WHOLE or options.only):
        known = "; ".join(dict.fromkeys([*every, *finders, *followers]))
        raise BadInput(f"--only {' '.join(options.only)!r} fits no row; there are: {known}")

    tell, out, share = teller(), Console(), QUICK if options.quick else 1.0
    results = measure([every[name] for name in names[0]], rounds, share, tell)
    tell("")
    show_speeds(out, results)
    show_goals(out, goals(other[1] if other else None), results)
    count = round(100 * share)
    seen = shallow(names[1], count, tell)
    tell("")
    if seen:
        show_shares(out, seen, count)
    bounces = chatter(names[2], tell)
    tell("")
    if bounces:
        show_bounces(out, bounces)
    costs = cost(min(rounds, STUDY_ROUNDS), share, tell) if "studies" in parts and not options.only else []
    tell("")
    if costs:
        show_costs(out, costs)
    responses = respond(share, tell) if "explorer" in parts and not options.only else []
    tell("")
    if responses:
        show_responses(out, responses)
    brought = forms(rounds, share, tell) if "forms" in parts and not options.only else []
    tell("")
    if brought:
        show_forms(out, brought)
    tables = "pinball" in parts and not options.only
    balls = pinball(rounds, share, tell) if tables else []
    turned = flippers(rounds, tell) if tables else []
    ways = basins(share, tell) if tables else None
    tell("")
    if ways:
        show_pinball(out, balls)
        show_flippers(out, turned, ways)
    if options.json is not None:
        write(options.json, rounds, results, seen, bounces, costs, responses, brought, balls, turned, ways)


def main(tokens: Sequence[str] | None = None) -> int:
    """Run and return the exit status; what is wrong with the input is said in one line."""
    try:
        run(tokens)
    except (BadInput, BadKernel) as error:
        print(f"benchmarks: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("benchmarks: stopped", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
