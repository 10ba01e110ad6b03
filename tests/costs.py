"""Where the processor time of the suite goes: by file, and by kernel that is compiled.

    GRAZING_COSTS=FOLDER python -m pytest -p tests.costs -n 2 ...
    python -m tests.costs FOLDER

Each process writes what it used: collection, each test with its own time, that of the processes it started, a browser's
included, and each compilation. Seconds are those of a processor, not of a clock.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

FOLDER = os.environ.get("GRAZING_COSTS")


def own() -> float:
    return time.process_time()


def others() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime + running()


def running() -> float:
    """Return what processes that still run have used, with those they waited for: a browser, and its pages."""
    parents, ticks = {}, {}
    for stat in Path("/proc").glob("[0-9]*/stat"):  # none but on Linux
        with contextlib.suppress(OSError):  # it has ended
            said = stat.read_text().rpartition(")")[2].split()
            parents[int(stat.parent.name)] = int(said[1])
            ticks[int(stat.parent.name)] = sum(map(int, said[11:15]))
    ours, of = 0, os.getpid()
    for pid in parents:
        above = parents[pid]
        while above in parents and above != of:
            above = parents[above]
        ours += ticks[pid] if above == of else 0
    return ours / os.sysconf("SC_CLK_TCK")


class Costs:
    """What one process used."""

    def __init__(self) -> None:
        self.tests: list[tuple[str, float, float, float]] = []
        self.kernels: list[tuple[str, float]] = []
        self.collection = self.compiled = 0.0
        self.depth, self.begun = 0, 0.0

    def listen(self) -> None:
        """Hear of each compilation; those within another belong to it."""
        from numba.core import event

        costs = self

        class Clock(event.Listener):  # type: ignore[misc]
            def on_start(self, _event: Any) -> None:
                if costs.depth == 0:
                    costs.begun = own()
                costs.depth += 1

            def on_end(self, said: Any) -> None:
                costs.depth -= 1
                if costs.depth == 0:
                    function = said.data["dispatcher"].py_func
                    file = Path(function.__code__.co_filename)
                    seconds = own() - costs.begun
                    costs.compiled += seconds
                    costs.kernels.append((f"{file.parent.name}.{file.stem}.{function.__name__}", seconds))

        event.register("numba:compile", Clock())

    def write(self, folder: Path) -> None:
        """Write down what was used."""
        folder.mkdir(parents=True, exist_ok=True)
        said = {
            "worker": os.environ.get("PYTEST_XDIST_WORKER", "main"),
            "own": own(),
            "others": others(),
            "collection": self.collection,
            "tests": self.tests,
            "kernels": self.kernels,
        }
        (folder / f"{os.getpid()}.json").write_text(json.dumps(said))


costs = Costs()


def pytest_configure(config: pytest.Config) -> None:
    """Begin to listen, if numba compiles at all."""
    if FOLDER and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
        costs.listen()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Note what collecting took, with all imports until here."""
    costs.collection = own()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> Iterator[None]:
    """Note what a test took, with its fixtures."""
    before = own(), others(), costs.compiled
    result = yield
    waited = max(0.0, others() - before[1])  # what was ended without being waited for is no longer seen
    costs.tests.append((item.nodeid, own() - before[0], waited, costs.compiled - before[2]))
    return result


def pytest_unconfigure(config: pytest.Config) -> None:
    """Write it down when the process ends."""
    if FOLDER:
        costs.write(Path(FOLDER))


def main(folder: Path) -> None:
    """Print the tables."""
    found = [json.loads(file.read_text()) for file in sorted(folder.glob("*.json"))]
    tests = [test for one in found for test in one["tests"]]
    kernels = [kernel for one in found for kernel in one["kernels"]]
    compiled = sum(seconds for _name, seconds in kernels)
    collected = sum(one["collection"] for one in found)
    waited = sum(test[2] for test in tests)
    work = sum(test[1] - test[3] for test in tests)
    print(f"{'all':40} {sum(one['own'] for one in found) + waited:8.1f} s, {len(tests)} tests")
    rows = (("compilation", compiled), ("processes", waited), ("collection", collected), ("work", work))
    for name, seconds in rows:
        print(f"  {name:38} {seconds:8.1f}")
    files: dict[str, list[float]] = {}
    for name, mine, theirs, compiling in tests:
        row = files.setdefault(name.partition("::")[0], [0.0, 0.0, 0.0, 0])
        for i, value in enumerate((compiling, theirs, mine - compiling, 1)):
            row[i] += value
    print(f"\n{'file':52} {'all':>8} {'compile':>8} {'process':>8} {'work':>8} {'tests':>6}")
    for name, row in sorted(files.items(), key=lambda pair: -sum(pair[1][:3])):
        print(f"{name:52} {sum(row[:3]):8.1f} {row[0]:8.1f} {row[1]:8.1f} {row[2]:8.1f} {row[3]:6.0f}")
    count: Counter[str] = Counter()
    spent: Counter[str] = Counter()
    for name, seconds in kernels:
        short = name.rpartition("_")[0]
        count[short] += 1
        spent[short] += seconds
    print(f"\n{'kernel':60} {'times':>6} {'seconds':>8}")
    for name, seconds in spent.most_common(60):
        print(f"{name:60} {count[name]:6} {seconds:8.1f}")
    print(f"\n{'slowest tests':100}")
    for name, mine, theirs, compiling in sorted(tests, key=lambda test: -(test[1] + test[2]))[:60]:
        print(f"{mine + theirs:8.1f} {compiling:8.1f} {theirs:8.1f} {name}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
