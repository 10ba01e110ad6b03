"""Write the stored reference data: `python -m tests.reference.build` from the root of the project."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from flint import arb, ctx

from .dips import dips
from .exact import Problem, Strobe, advance
from .problems import PERIODS, PROBLEMS, STARTS

COMMAND = "python -m tests.reference.build"
DATA = Path(__file__).parent / "data"
DIGITS = 40  # of the computation
STORED = 25  # of the results in the files
PER_CELL = 4  # states for one problem and one depth
DEPTHS = tuple(float(f"1e-{n}") for n in range(3, 14))
# no moment at which the force points away from the wall, or no flight back of a reasonable size
NO_DIPS = {
    "soft",
    "no stiffness, no damping",
    "pressed",
    "many impacts",
    "very stiff",
    "resonance, growing",
}


def decimal(x: arb) -> str:
    """x with the stored number of digits."""
    with ctx.workdps(DIGITS + 20):
        return x.str(STORED, radius=False)


def parameters(problem: Problem) -> dict[str, object]:
    """The parameters of a problem with hexadecimal floats, to detect that it was changed."""
    law = problem.law
    names = ("alpha", "k", "omega", "t0", "offset", "sigma")
    return {
        **{name: getattr(problem, name).hex() for name in names},
        "cos": [c.hex() for c in problem.cos],
        "sin": [s.hex() for s in problem.sin],
        "law": [law.r.hex(), law.V.hex(), law.speed.hex()],
    }


def row(problem: Problem, strobe: Strobe) -> list[object]:
    """u, v, number of impacts (null with a completed chatter, which has infinitely many), factor."""
    rests = any(impact.v_plus == 0 for impact in strobe.impacts)
    count = None if rests and problem.law.r > 0 else len(strobe.impacts)
    return [decimal(strobe.u), decimal(strobe.v), count, float(f"{strobe.factor:.3g}")]


def orbits() -> Iterator[dict[str, object]]:
    """The strobe states of every named problem and start."""
    for name, problem in PROBLEMS.items():
        for u, v in STARTS[name]:
            strobes = advance(problem, u, v, PERIODS[name], DIGITS, jacobian=True)
            rows = [row(problem, strobe) for strobe in strobes]
            yield {"problem": name, "u": u.hex(), "v": v.hex(), "rows": rows}


def stress() -> Iterator[dict[str, object]]:
    """The dip and clearance states with their state one period later."""
    for name, problem in PROBLEMS.items():
        if name in NO_DIPS:
            continue
        for depth in DEPTHS:
            if depth * max(problem.alpha, problem.omega) ** 2 > 0.05:  # deeper than so short a flight goes
                continue
            for dip in dips(problem, depth, PER_CELL, seed=1):
                after = advance(problem, dip.u, dip.v, 1, DIGITS, jacobian=True)[0]
                yield {
                    "problem": name,
                    "u": dip.u.hex(),
                    "v": dip.v.hex(),
                    "depth": depth,
                    "hits": dip.hits,
                    "t_m": float(f"{dip.t_m:.12g}"),
                    "row": row(problem, after),
                }


def write(name: str, entries: Iterator[dict[str, object]], columns: str) -> None:
    """Write one data file, one entry a line."""
    head = {
        "command": COMMAND,
        "digits": DIGITS,
        "columns": columns,
        "problems": {key: parameters(problem) for key, problem in PROBLEMS.items()},
    }
    lines = [json.dumps(entry, separators=(",", ":")) for entry in entries]
    text = json.dumps(head, separators=(",", ":"))[:-1] + ',"entries":[\n' + ",\n".join(lines) + "\n]}\n"
    DATA.mkdir(exist_ok=True)
    (DATA / f"{name}.json").write_text(text, encoding="utf-8")


def main() -> None:
    """Build both files."""
    columns = "u, v, impacts in the period (null: completed chatter), factor"
    write("orbits", orbits(), columns)
    write("dips", stress(), columns)


if __name__ == "__main__":
    main()
