"""A proof that a flight stays off a wall between its ends.

The flight, as the wall sees it, is cut into cells. At first, while v > 0, the ball cannot come back to the wall that
it left; at last, while v < 0, it falls towards the arrival and so is above it; between, y > 0. A cell of which none of
the three is known is halved. From a wall that is met only, or left only, or neither, one of the stretches or both are
missing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from grazing.oscillator.sure import Undecided
from grazing.proof.equations import Equations, Flight
from grazing.proof.flow import Flow
from grazing.proof.reasons import NotProven, Stage, Virtual
from grazing.proof.seen import Dual, alone

if TYPE_CHECKING:
    from flint import arb, arb_mat

#: Halvings of a step, and cells in all, after which nothing is decided.
DEEPEST, MOST = 220, 60_000
#: Halvings of a step after which a dip that cannot be told from a touch is taken for one, where touches are asked for.
TOUCHING = 5


class Through(ArithmeticError):
    """The flight passes through the wall: time after its start and height, below 0."""

    def __init__(self, time: float, height: float) -> None:
        super().__init__(time, height)
        self.time, self.height = time, height


class Clear(NamedTuple):
    """What is proven: v > up on [0, start], y > floor on [start, end], v < -down on [end, L].

    For a flight that leaves with w = 0 exactly ``up`` bounds y'' instead. ``dip`` is a stretch with y'' > ``bend``
    that begins with v < 0 and ends with v > 0; on it y > floor is not claimed: there the flight may touch.
    """

    start: arb
    end: arb
    floor: arb
    up: arb
    down: arb
    dip: tuple[arb, arb] | None = None
    bend: arb | None = None


class Cleared(NamedTuple):
    """What is proven of a flight: its cuts, the bounds up to the first and after the last, and that of every wall.

    For ``dip`` and ``bend`` see :class:`Clear`.
    """

    start: arb
    end: arb
    up: arb
    down: arb
    floors: list[arb]
    dip: tuple[arb, arb] | None = None
    bend: arb | None = None


class Grid:
    """Cells of one flight, [index, index + 1] h / 2^level, with what all cells of one level share."""

    def __init__(self, flow: Flow, L: arb) -> None:
        self.flow, self.count = flow, flow.count(L)
        self.h: arb = L.upper() / self.count
        self._steps: dict[int, arb_mat] = {}
        self._around: dict[int, arb_mat] = {}

    def step(self, level: int) -> arb_mat:
        """Return exp(M h) of a cell."""
        if level not in self._steps:
            self._steps[level] = self.flow.step(self.width(level))
        return self._steps[level]

    def around(self, level: int) -> arb_mat:
        """Return a ball around all exp(M s) up to the length of a cell."""
        if level not in self._around:
            self._around[level] = self.flow.cell(self.width(level))
        return self._around[level]

    def width(self, level: int) -> arb:
        """Return the length of a cell."""
        width: arb = self.h / 2**level
        return width

    def time(self, index: int, level: int) -> arb:
        """Return when a cell starts."""
        at: arb = index * self.width(level)
        return at


class Cell:
    """A cell of a flight: its state at the start, and bounds on y, v and y'' over it."""

    __slots__ = ("bend", "index", "level", "v", "y", "z")

    def __init__(self, grid: Grid, index: int, level: int, z: arb_mat) -> None:
        from flint import arb

        flow, h = grid.flow, grid.width(level)
        self.index, self.level, self.z = index, level, z
        crude = grid.around(level) * z
        self.bend = (flow.system * crude)[1, 0] * flow.scale
        y, v = z[0, 0], z[1, 0] * flow.scale
        s = arb(0.5, 0.5)
        self.v = v + s * h * self.bend
        self.y = y + s * h * v + s * (h * h / 2) * self.bend

    def halves(self, grid: Grid) -> tuple[Cell, Cell]:
        """Return the two halves."""
        level, index = self.level + 1, 2 * self.index
        return Cell(grid, index, level, self.z), Cell(grid, index + 1, level, grid.step(level) * self.z)


def clear(
    flow: Flow, z: arb_mat, t: arb, L: arb, leaves: bool = True, meets: bool = True, touch: bool = False
) -> Clear:
    """Prove that a flight is above a wall between its ends.

    Parameters
    ----------
    flow : Flow
        The flow.
    z : arb_mat
        States in which the flights start.
    t, L : arb
        Times at which they start, and lengths of the flights; the true flight is back at the wall after it.
    leaves, meets : bool
        Whether the flight starts at the wall, and whether it ends there; otherwise y > 0 is proven up to that end.
    touch : bool
        Whether one dip may be left open, which may then touch the wall.

    Raises
    ------
    Through
        If a flight is below the wall in between.
    Undecided
        If the precision does not tell.
    """
    grid = Grid(flow, L)
    cells = []
    for i in range(grid.count):
        cells.append(Cell(grid, i, 0, z))
        z = grid.step(0) * z
        if i % flow.fresh == 0:
            flow.refresh(z, t + grid.time(i + 1, 0))
    lifted = leaves and cells[0].z[1, 0].is_zero()
    alone = leaves != meets
    if alone and len(cells) == 1:
        cells = [*cells[0].halves(grid)]
    while True:
        first, last = _departing(cells, lifted) if leaves else 0, _arriving(cells) if meets else len(cells)
        if alone:  # of a flight that rises all the time, or falls, one cell is left for y > 0
            first, last = min(first, len(cells) - 1), max(last, 1)
        open_cells = [i for i in range(first, last) if not cells[i].y > 0]
        if first >= last:  # the whole flight is monotone: not a flight back to the wall
            raise Undecided
        dip = _dip(cells, open_cells, grid) if touch else None
        if not open_cells or dip is not None:
            break
        _look_through(cells, open_cells, grid)
        if len(cells) > MOST or any(cells[i].level >= DEEPEST for i in open_cells):
            raise Undecided
        opened = set(open_cells)
        cells = [c for i, cell in enumerate(cells) for c in (cell.halves(grid) if i in opened else (cell,))]
    return _claims(cells, first, last, set(open_cells), grid, lifted, dip)


def _departing(cells: list[Cell], lifted: bool) -> int:
    """Return the number of cells at the start on which the ball surely rises."""
    count = 0
    while count < len(cells) and (cells[count].bend > 0 if lifted else cells[count].v > 0):
        count += 1
    return count


def _arriving(cells: list[Cell]) -> int:
    """Return the index of the first of the cells at the end on which the ball surely falls."""
    count = len(cells)
    while count > 0 and cells[count - 1].v < 0:
        count -= 1
    return count


def _look_through(cells: list[Cell], open_cells: list[int], grid: Grid) -> None:
    """Raise Through if a cell starts below the wall."""
    below = [i for i in open_cells if cells[i].z[0, 0] < 0]
    if below:
        i = min(below, key=lambda i: float(cells[i].z[0, 0]))
        raise Through(float(grid.time(cells[i].index, cells[i].level)), float(cells[i].z[0, 0]))


def _dip(cells: list[Cell], open_cells: list[int], grid: Grid) -> tuple[arb, arb] | None:
    """Return the one stretch of open cells if it holds one dip: y'' > 0, from v < 0 to v > 0."""
    if not open_cells or open_cells[-1] - open_cells[0] != len(open_cells) - 1:
        return None
    one, two = cells[open_cells[0]], cells[open_cells[-1]]
    if min(cells[i].level for i in open_cells) < TOUCHING or not all(cells[i].bend > 0 for i in open_cells):
        return None
    after = grid.step(two.level) * two.z
    if not (one.z[1, 0] < 0 and after[1, 0] > 0):
        return None
    return grid.time(one.index, one.level), grid.time(two.index + 1, two.level)


def _claims(
    cells: list[Cell], first: int, last: int, opened: set[int], grid: Grid, lifted: bool, dip: tuple[arb, arb] | None
) -> Clear:
    """Collect the bounds."""
    from flint import arb

    def least(values: list[arb]) -> arb:
        return min((x.lower() for x in values), key=float) if values else arb(0)

    end = grid.h * grid.count if last == len(cells) else grid.time(cells[last].index, cells[last].level)
    return Clear(
        start=grid.time(cells[first].index, cells[first].level),
        end=end,
        floor=least([cells[i].y for i in range(first, last) if i not in opened]),
        up=least([cells[i].bend if lifted else cells[i].v for i in range(first)]),
        down=least([-cells[i].v for i in range(last, len(cells))]),
        dip=dip,
        bend=least([cells[i].bend for i in sorted(opened)]) if dip else None,
    )


def check_impacts(flights: list[Flight], n: int) -> None:
    """Raise unless every impact arrives with v < 0 and leaves with w >= 0."""
    for i, f in enumerate(flights if n else []):
        if f.v >= 0:
            raise Virtual(
                f"the orbit is virtual: flight {i + 1} arrives at the wall with a velocity of {float(f.v):.3g}, not < 0"
            )
        if f.g < 0:
            raise NotProven(
                f"the reset law returns {float(f.g):.3g} after impact {(i + 1) % n + 1}, a velocity into the wall"
            )
        if not (f.L > 0 and f.v < 0 and (f.g > 0 or f.g.is_zero())):
            raise Undecided


def started(equations: Equations, f: Flight, box: list[arb], flow: Flow, wall: int) -> arb_mat:
    """Return the state in which a flight starts, as a wall sees it."""
    from flint import arb

    nothing = arb(0)
    y, w = (Dual(x, nothing) for x in ((nothing, f.w) if equations.n else (box[0], box[1])))
    seen = flow.seen.across(f.one, wall, f.t, y, w)
    return flow.start(f.t, seen[0].x, seen[1].x)


def cleared_flight(
    equations: Equations, flights: list[Flight], i: int, box: list[arb], touch: int | None = None
) -> Cleared:  # fmt: skip
    """Return the proof that a flight is off all walls, or raise NotProven or Open; it may touch the wall ``touch``."""
    f, n, flows = flights[i], equations.n, equations.flows(box)
    f = f._replace(w=flights[i - 1].g) if n and flights[i - 1].g.is_zero() else f
    label = f"flight {i + 1}" if n else "the orbit"
    found = []
    for wall, flow in enumerate(flows):
        start = started(equations, f, box, flow, wall)
        named = "the wall" if alone(equations.model) else f"wall {flow.seen.walls[wall].name}"
        leaves, meets = n > 0 and wall == f.one, n > 0 and wall == f.two
        with Stage(f"{label} comes closer to {named} than can be told from a touch, or leaves it too slowly"):
            try:
                found.append(clear(flow, start, f.t, f.L, leaves, meets, wall == touch))
            except Through as below:
                lower = "u - sigma" if alone(equations.model) else "the distance"
                raise Virtual(
                    f"the orbit is virtual: {label} passes through {named}, {lower} = {below.height:.3g} at "
                    f"t = {float(f.t) + below.time:.9g}; it satisfies its equations but is no motion of the oscillator"
                ) from None
    left, met = found[f.one], found[f.two]
    dip = next((one for one in found if one.dip is not None), left)
    return Cleared(left.start, met.end, left.up, met.down, [one.floor for one in found], dip.dip, dip.bend)
