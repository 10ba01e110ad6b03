"""Compile the kernels of this package before the first call: ``python -m grazing.prepare``.

Every study is run once, on very little, in processes whose kernels go to the folder of prepared kernels. What is there
already and still right is kept; what belongs to older sources is removed.

Usage: python -m grazing.prepare [--family NAME] [--part NAME]
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grazing.kernel.disk import others_can_write
from grazing.kernel.prepared import FAMILIES, folder, machines, own, stamp, used
from grazing.writing import put, remove_left

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from grazing.maps.map import Map
    from grazing.oscillator.model import Oscillator

    Floats = NDArray[np.float64]

#: Who may read prepared kernels: everybody, as the sources.
RIGHTS = 0o644
#: The parts of the package that kernels come from.
SOURCES = (
    "kernel", "systems", "billiard", "oscillator", "maps", "orbits", "studies", "prepare.py", "parameter.py",
    "outcome.py",
)  # fmt: skip


def one_wave() -> None:
    """Compile for forces of one harmonic: the pinball's kernels and those of all studies of them, then its other maps.

    What is large the kernels of all walls share, so another process would compile it once more.
    """
    import grazing as gz

    m = gz.pinball(alpha=3, k=1, omega=2.2, d=0.12, r=0.8, V=0.4)
    _studies(m, "d")
    for order in ("lowest", "full", "corrected"):
        D = gz.discontinuity_map(m, order=order)
        D.orbit((0.1, 0.0), 20)
        D.jacobian((0.1, 0.0))
        for arithmetic in ("fast", "strict"):
            gz.orbit_diagram(D, "d", [0.1, 0.12], starts=4, transient=10, arithmetic=arithmetic)
    _walls(1.0)


def two_waves() -> None:
    """Compile for forces of two harmonics."""
    import grazing as gz

    forcing = gz.Forcing(omega=2.2, offset=0.12, cos=(1.0, 0.1))
    _studies(gz.Oscillator(alpha=3, k=1, forcing=forcing, reset=gz.newton(0.8)), "offset")
    _walls(1.0, 0.1)


def _walls(*cos: float) -> None:
    """Run what is done between two walls, and over one that moves, with a force of these harmonics."""
    import numpy as np

    import grazing as gz

    pair = gz.wall(-0.3, gz.newton(0.8)), gz.wall(0.3, gz.newton(0.7))
    forcing = gz.Forcing(omega=1.7, cos=cos)
    m: Oscillator = gz.Oscillator(0.2, 1.1, forcing, walls=pair)  # type: ignore[call-arg]
    gz.trajectory(m, (0.1, 0.0))
    P = gz.stroboscopic_map(m)
    values = np.linspace(0.0, 0.1, 3)
    P.orbit((0.1, 0.0), 60)
    P.jacobian((0.1, 0.0))
    for arithmetic in ("fast", "strict"):
        gz.orbit_diagram(P, "offset", values, starts=4, transient=10, arithmetic=arithmetic)
    gz.lyapunov(P, transient=20)
    gz.coexistence(P, "offset", values[:2], starts=20)
    gz.periodic_orbits(P, 1, starts=20)
    Q = gz.impact_map(m)
    Q.orbit((0.0, 0.5), 20)
    Q.jacobian((0.0, 0.5))
    gz.orbit_diagram(Q, "offset", values, starts=4, transient=10)
    table = gz.wall(-0.3, gz.newton(0.8), motion=gz.Forcing(omega=1.7, cos=(0.1,)))
    m = gz.Oscillator(0.2, 1.1, forcing, walls=[table])  # type: ignore[call-arg]
    gz.orbit_diagram(gz.stroboscopic_map(m), "offset", values, starts=4, transient=10)


def tables() -> None:
    """Compile for pinball tables: launches, maps with flippers and without, with one or two gates, and of strobes."""
    import numpy as np

    import grazing as gz

    corners = ((0.0, 0.0), (6.0, 0.0), (6.0, 10.0), (0.0, 10.0))
    elastic = gz.newton(1.0)  # a level table is chaotic then, so that exponents are measured
    laws = elastic, elastic, elastic, gz.triggered(r=1.0, V=0.0, trigger=0.1)
    floor, right, top, left = (
        gz.segment(name, corners[i], corners[(i + 1) % 4], laws[i])
        for i, name in enumerate(("floor", "right", "top", "left"))
    )
    things = gz.disc("a", (2, 5), 0.5, gz.active(r=1.0, V=0.0)), gz.arc("b", (3, 6), 2.5, 0.3, 2.6, elastic)
    level = gz.table([*things, floor, right, top, left], rho=0.1)
    sloped = gz.table([*things, right, top, left, gz.drain("out", (0, 0), (6, 0))], rho=0.1, tilt=0.1)
    gz.trajectory(sloped, (3.2, 8.0, 0.0, 0.0), until=60.0)
    gz.trajectory(level, (4.0, 5.6, -1.0, 0.0), until=3.0)  # along a disc: decided exactly
    gz.trajectory(gz.table([floor], rho=0.1, tilt=0.1), (1.0, 0.1, 1.0, 0.0), until=9.0)  # slides
    gz.launches(sloped, (3.2, 8.0), [1.0, 2.0], [1.0, 2.0])
    _each(gz.launch_map(sloped, (3.2, 8.0)), "g", np.array([1.0, 1.1]), "tilt")
    P = gz.collision_map(level)
    _each(P, "a.V", np.array([0.0, 0.1]), "rho")
    kicks = gz.segment("floor", corners[0], corners[1], gz.active(r=0.9, V=0.4))  # a ball on it settles, slowly
    grid = {"place": [3.0, 3.1], "speed": [3.0, 3.5]}
    gz.basins(gz.collision_map(gz.table([kicks], rho=0.1, tilt=0.1)), grid, fixed={"angle": 0.0}, transient=10)
    assert P.origin.settle is not None
    P.origin.settle(list(P.params.values()), (0.5, 0.0, 1.0))
    L = gz.flipper("L", (1.5, 1.5), 1.5, 0.2, -0.5, 0.5, gz.newton(0.8), up=8.0, down=4.0)
    R = gz.flipper("R", (4.5, 1.5), 1.5, 0.2, 3.64, 2.64, gz.newton(0.8), up=8.0, down=4.0)
    gates = {"L": ((1.5, 3.0), (3.0, 3.0)), "R": ((3.0, 3.0), (4.5, 3.0))}

    def falls(state: Any, p: Any) -> bool:
        return state[3] < -0.5  # type: ignore[no-any-return]

    one, two = gz.strategy(falls, {"L": gates["L"]}, hold=0.2), gz.strategy(falls, gates, hold=0.2)
    for player in gz.flips(1.0, 0.2), one, two:
        table = gz.table([*things, floor, right, top, left, L, R], rho=0.1, tilt=0.3, player=player)
        _each(gz.collision_map(table), "g", np.array([1.0, 1.1]), "rho")
        if table.period < np.inf:
            _each(gz.stroboscopic_map(table), "g", np.array([1.0, 1.1]), "rho")
    _each(gz.launch_map(table, (3.2, 8.0), hits=10), "g", np.array([1.0, 1.1]), "rho")


def formulas() -> None:
    """Compile what is needed for maps that are formulas: the gap map of the paper, and maps of one's own."""
    import numpy as np

    import grazing as gz

    def in_one(x: Any, p: Any) -> Any:
        return (p.a - x[0] * x[0] + p.b,)

    def in_two(x: Any, p: Any) -> Any:
        return p.a - x[0] * x[0] + p.b * x[1], x[0]

    _formula(gz.gap_map(lam=0.8, mu=0.5, l=1.0), "mu", np.linspace(0.1, 0.5, 4))

    def in_three(x: Any, p: Any) -> Any:
        return p.a - x[0] * x[0] + p.b * x[2], x[0], x[1]

    for names, step in (("x", in_one), ("xy", in_two), ("xyz", in_three)):
        P = gz.Map(step, {"a": 0.5, "b": 0.3}, tuple(names), box=((-1.0, 1.0),) * len(names), escape=10.0)
        _formula(P, "a", np.linspace(0.1, 1.4, 4))  # at the last one chaotic


def systems() -> None:
    """Compile what is needed for systems of one's own, of one and of two positions."""
    import numpy as np

    import grazing as gz

    def flight(t: float, t0: float, state: Any, p: Any) -> Any:
        x, v = state
        s = t - t0
        return x + (v - 0.5 * s) * s, v - s

    def gap(t: float, state: Any, p: Any) -> Any:
        return state[0], state[1]

    def two(t: float, t0: float, state: Any, p: Any) -> Any:
        x, y, v, w = state
        (x, v), (y, w) = flight(t, t0, (x, v), p), flight(t, t0, (y, w), p)
        return x, y, v, w

    def lower(t: float, state: Any, p: Any) -> Any:
        return state[0] + state[1], state[2] + state[3]

    def bound(t: float, w: float, state: Any, p: Any) -> float:
        return 2.0

    for names, fly, low in ((("x",), flight, gap), (("x", "y"), two, lower)):
        floor, box = gz.Surface("A", low, bound), ((0.1, 0.5),) * (2 * len(names))
        ball = gz.System(names, [f"v{x}" for x in names], {"r": 0.8}, fly, [floor], box, period=1.0)
        gz.trajectory(ball, (0.5,) * len(box), until=2.0)
        P = gz.stroboscopic_map(ball)
        P.jacobian((0.5,) * len(box))
        for arithmetic in ("fast", "strict"):
            gz.orbit_diagram(P, "r", np.linspace(0.1, 0.8, 4), transient=10, arithmetic=arithmetic)


def _each(P: Map, name: str, values: Floats, other: str) -> None:
    """Run each study of a map of a table once, in two of its parameters."""
    import numpy as np

    import grazing as gz

    start = [0.5 * (low + high) for low, high in P.box]
    P.orbit(start, 20)
    P.jacobian(start)
    for arithmetic in ("fast", "strict"):
        gz.orbit_diagram(P, name, values, starts=4, transient=10, arithmetic=arithmetic)
    gz.chart(P, {name: values, other: [0.1, 0.11]}, transient=20)
    gz.lyapunov(P, name, values, transient=5)
    gz.basins(P, {x: np.linspace(*P.box[i], 3) for i, x in enumerate(P.coordinates[:2])}, transient=20)


def _formula(P: Map, name: str, values: Floats) -> None:
    """Run each study of a map that is a formula once, but those that need no kernel more."""
    import grazing as gz

    last = list(P.params)[-1]
    P.orbit(0.1 * values[: P.dimension], 60)
    P.jacobian(0.1 * values[: P.dimension])
    for arithmetic in ("fast", "strict"):
        gz.orbit_diagram(P, name, values, transient=10, arithmetic=arithmetic)
    gz.coexistence(P, name, values, starts=20, transient=10)
    gz.density(P, name, values, starts=4, coordinate=P.coordinates[0])
    gz.chart(P, {name: values, last: [0.1, 0.2]}, transient=50)
    gz.lyapunov(P, name, values, transient=5)  # so short that some have no period: their exponents are measured
    gz.periodic_orbits(P, range(1, 4))


def _studies(m: Oscillator, name: str) -> None:
    """Run each study once, but those that need no kernel more."""
    import numpy as np

    import grazing as gz

    P, values = gz.stroboscopic_map(m), np.linspace(0.05, 0.16, 4)
    P.orbit((0.1, 0.0), 60)
    for arithmetic in ("fast", "strict"):  # so short that some orbits have not settled
        gz.orbit_diagram(P, name, np.linspace(0.05, 0.16, 30), starts=20, transient=10, arithmetic=arithmetic)
    gz.windows(m, name, N=range(2, 4))
    gz.chart(P, {name: values, "alpha": [2.9, 3.0]}, transient=50)
    gz.lyapunov(P.replace(**{name: 0.05}))
    gz.basins(P, {x: np.linspace(*P.box[i], 9) for i, x in enumerate(P.coordinates)}, transient=50, preimages=1)
    gz.periodic_orbits(P, range(1, 4), starts=200)
    gz.trajectory(m, (0.1, 0.0))
    Q = gz.impact_map(m)
    Q.orbit((0.0, 0.5), 20)
    gz.orbit_diagram(Q, name, values, starts=4)
    gz.density(P, name, values, starts=4)
    gz.coexistence(P, name, values[:2], starts=20)


#: The first holds what all others need as well, and they find it. Tables take longest, and come to that late.
PARTS: dict[str, Callable[[], None]] = {
    "formulas": formulas,
    "tables": tables,
    "one wave": one_wave,
    "two waves": two_waves,
    "systems": systems,
}


def prepared(family: str = "") -> int:
    """Fill the folder of prepared kernels; return how many there are.

    Parameters
    ----------
    family : str
        One of :data:`grazing.kernel.prepared.FAMILIES`, which this processor must belong to; empty for this processor.
    """
    made_from, known = _made_from(family), stamp(family)
    if known.exists() and known.read_text(encoding="ascii") == made_from:
        return len(list(folder().glob("*.nbc")))
    folder().mkdir(exist_ok=True)
    print("grazing: compiling kernels (once; two or three minutes)", file=sys.stderr, flush=True)
    with tempfile.TemporaryDirectory(prefix="grazing-") as scratch:
        environment = {**os.environ, "GRAZING_CACHE": scratch, "MPLBACKEND": "Agg"}
        if family:
            environment |= {"NUMBA_CPU_NAME": family, "NUMBA_CPU_FEATURES": FAMILIES[family]}
        pipe = subprocess.PIPE

        def begun(part: str) -> subprocess.Popen[str]:
            command = [sys.executable, "-m", "grazing.prepare", "--part", part]
            return subprocess.Popen(command, env=environment, stdout=pipe, stderr=pipe, text=True)

        running = [begun(part) for part in list(PARTS)[:2]]
        said = [running[0].communicate()]
        running += [begun(part) for part in list(PARTS)[2:]]
        said += [each.communicate() for each in running[1:]]
        failed = [error.strip() for each, (_names, error) in zip(running, said, strict=True) if each.returncode]
        if failed:
            raise SystemExit(f"grazing: the kernels could not be compiled beforehand:\n{failed[0]}")
        kept = {name for names, _error in said for name in names.split()}
        for file in sorted(Path(scratch).glob("*.nbc")):
            kept.add(file.name)
            put(folder() / file.name, file.read_bytes(), RIGHTS)
    if not family:  # a wheel holds several families, a checkout what is right for it
        remove_left(folder())
        for file in (*folder().glob("*.nbc"), *folder().glob("stamp-*")):
            if file.name not in kept:
                file.unlink(missing_ok=True)
    put(known, made_from.encode("ascii"), RIGHTS)
    return len(list(folder().glob("*.nbc")))


def _made_from(family: str) -> str:
    """Return a hash of all that the kernels depend on: sources, versions, processor."""
    found = hashlib.sha256(f"{sys.version} {version('numba')} {version('llvmlite')} {family} {own()}".encode())
    root = Path(__file__).parent
    files = [file for part in SOURCES for file in (root / part, *(root / part).rglob("*")) if file.suffix == ".py"]
    for file in sorted(files):
        found.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return found.hexdigest()


def main() -> None:
    """Prepare kernels, or one part of them in a process of its own."""
    options = argparse.ArgumentParser(prog="python -m grazing.prepare", description=__doc__.splitlines()[0])
    options.add_argument("--family", choices=list(FAMILIES), default="", help="for a family of processors (wheels)")
    options.add_argument("--part", choices=list(PARTS), help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.part:
        warnings.simplefilter("ignore")
        PARTS[given.part]()
        print("\n".join(sorted(used)))
        return
    if given.family and given.family not in [name for _system, name, _features in machines(own())]:
        raise SystemExit(f"grazing: this processor does not run code for {given.family}")
    if others_can_write(folder().parent):
        raise SystemExit(f"grazing: {folder().parent}: {others_can_write(folder().parent)}")
    try:
        count = prepared(given.family)
    except OSError as error:  # a folder that is only read, a full disk
        raise SystemExit(f"grazing: kernels cannot be kept in {folder()}: {error.strerror or error}") from None
    print(f"grazing: {count} kernels are prepared", file=sys.stderr)


if __name__ == "__main__":
    main()
