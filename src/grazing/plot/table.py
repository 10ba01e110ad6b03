"""A pinball table to scale, and the way of a ball on it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from grazing.outcome import InputError, shown
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.spread import laid_out
from grazing.plot.style import GRAZE, INK, SINGLE, WALL, axes, plain, root, styled

Floats = NDArray[np.float64]
#: Height of a figure at most, as a share of its width, and the room around the objects as a share of their extent.
TALL, ROOM = 1.6, 0.04
WAY = "#0064a4"
#: Points of the arrow of a plunger.
LANE = 14.0
#: Widths of its name that a line is long at least, for the name to stand on it, and heights between names.
LONG, APART = 1.8, 1.3
#: How far a chord may be from the flight that it stands for, as a share of the extent, and chords between two points of
#: a trajectory at most.
FLAT, CHORDS = 5e-4, 1000


@inline
def table(table: Any, flown: Any = None, ax: Axes | None = None, *, names: bool = True) -> dict[str, Any]:
    """Draw a pinball table to scale, with the way of a ball where one is given.

    Parameters
    ----------
    table : Table
        From :func:`grazing.table`. Objects that kick are red, drains are dashed, flippers where they are at the
        end; an arrow shows the plunger.
    flown : xarray.Dataset, optional
        Of :func:`grazing.trajectory` on this table: the way of the ball's centre, and the ball, to scale, where it
        begins and ends.
    ax : matplotlib Axes, optional
        Default: a new figure one column wide. Its aspect becomes equal.
    names : bool
        Whether the objects' names stand on them or beside them, as far as there is room.

    Returns
    -------
    dict
        ``objects``, lines by the objects' names, ``bodies``, what those that are closed are filled with, ``way``,
        ``ball``, ``plunger``, ``figure``.

    Raises
    ------
    InputError
        For anything but a table, or a trajectory that is none of a table.

    Examples
    --------
    >>> import grazing as gz
    >>> bumper = gz.disc("bumper", (1, 2), 0.5, gz.active(r=0.9, V=0.4))
    >>> T = gz.table([bumper, gz.drain("out", (-1, 0), (3, 0))], rho=0.1, tilt=0.3)
    >>> gz.plot.table(T, gz.trajectory(T, (1.1, 4.0, 0.0, 0.0), until=9.0))
    <Drawn: figure, objects, bodies, way, ball, plunger>
    """
    if not hasattr(table, "outlines"):
        raise InputError(f"plot.table cannot draw a {type(table).__name__}; allowed is what gz.table([...]) returns")
    if not isinstance(names, (bool, np.bool_)):
        raise InputError(f"names is {shown(names)}; give True or False")
    if flown is not None:
        expect(flown, "trajectory", dict.fromkeys(("x", "y", "vx", "vy"), ("t",)), "table")
    lines = table.outlines(0.0 if flown is None else float(flown.t[-1]))
    x, y = (np.concatenate([line.points[:, i] for line in lines]) for i in (0, 1))
    shot = table.plunger
    if shot is not None:
        x, y = np.append(x, shot.x), np.append(y, shot.y)
    if flown is not None:
        inside = flown.y.values >= y.min() - 0.5 * np.ptp(y)  # a ball may fall or fly on for ever
        inside &= (np.abs(flown.x.values - x.mean()) <= np.ptp(x)) & (flown.y.values <= y.max() + 0.5 * np.ptp(y))
        x, y = np.append(x, flown.x.values[inside]), np.append(y, flown.y.values[inside])
    wide, high = max(np.ptp(x), 1e-3 * np.ptp(y)), max(np.ptp(y), 1e-3 * np.ptp(x))
    edge = ROOM * max(wide, high) + table.rho
    with styled():
        ax = axes(ax, SINGLE, SINGLE * min(max(high / wide, 0.4), TALL))
        found, bodies, way, arrow = {}, {}, None, None
        ball: list[Artist] = []
        for line in lines:
            colour = GRAZE if line.kicks else INK
            (drawn,) = ax.plot(*line.points.T, color=colour, lw=1.2, ls=(0, (3, 2)) if line.opens else "-", zorder=3)
            if line.closed:
                solid = {"color": colour, "alpha": 0.35} if line.kicks else {"color": WALL}
                (bodies[line.name],) = ax.fill(*line.points.T, **solid, lw=0)
            found[line.name] = drawn
        if shot is not None:  # it pushes the ball from behind
            tail = -LANE * np.cos(shot.angle), -LANE * np.sin(shot.angle)
            kind = {"arrowstyle": "->", "color": GRAZE, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
            arrow = ax.annotate("", (shot.x, shot.y), tail, textcoords="offset points", arrowprops=kind, zorder=3)
        if flown is not None:
            (way,) = ax.plot(*way_of(flown, table.gravity, FLAT * max(wide, high))[:2], color=WAY, lw=0.7, zorder=4)
            hits = flown["before"].values
            ax.plot(hits[:, 0], hits[:, 1], ".", color=WAY, ms=2.5, zorder=4)
            for i, face in ((0, "white"), (-1, WAY)):
                centre = float(flown.x[i]), float(flown.y[i])
                if table.rho > 0.0:
                    ball.append(ax.add_patch(Circle(centre, table.rho, fc=face, ec=WAY, lw=0.8, zorder=6)))
                else:
                    ball += ax.plot(*centre, "o", mfc=face, mec=WAY, ms=3.0, mew=0.8, zorder=6)
        ax.set_aspect("equal")
        ax.set(xlim=(x.min() - edge, x.max() + edge), ylim=(y.min() - edge, y.max() + edge), xlabel="$x$", ylabel="$y$")
        if names:
            name_objects(ax, lines)
    return {"figure": root(ax), "objects": found, "bodies": bodies, "way": way, "ball": ball, "plunger": arrow}


def name_objects(ax: Axes, lines: list[Any]) -> None:
    """Write the names on the objects, along those that are straight, or beside them; one without room is not seen.

    Those that kick come first. A name is as good as a row of spots, as far apart as it is high.
    """
    renderer = laid_out(ax)
    ax.apply_aspect()
    drawn = {line.name: _spots(ax.transData.transform(line.points)) for line in lines}
    taken = np.empty((0, 2))
    for line in sorted(lines, key=lambda line: (not line.kicks, not line.closed)):
        look: dict[str, Any] = {"ha": "center", "va": "center", "size": 6, "color": GRAZE if line.kicks else INK}
        behind = {"fc": "white", "ec": "none", "pad": 0.3}
        text = ax.text(0.0, 0.0, plain(line.name), zorder=3.5, rotation_mode="anchor", bbox=behind, **look)
        box = text.get_window_extent(renderer)
        others = np.concatenate([np.empty((0, 2)), *(spots for name, spots in drawn.items() if name != line.name)])
        for at, angle, inside in _places(ax.transData.transform(line.points), line, ax, box):
            along = np.array([np.cos(angle), np.sin(angle)])
            half = max(0.5 * (box.width - box.height), 0.0)
            spots = at + np.linspace(-half, half, 2 + int(2.0 * half / box.height))[:, None] * along
            if all(ax.bbox.padded(-0.5 * box.height).contains(*spot) for spot in spots) and not (
                _near(spots, taken, APART * box.height) or _near(spots, others, 0.6 * box.height)
            ):
                text.set(position=ax.transData.inverted().transform(at), rotation=np.degrees(angle))
                if inside:
                    text.set_bbox(None)
                taken = np.concatenate([taken, spots])
                break
        else:
            text.set_visible(False)


def _places(points: Floats, line: Any, ax: Axes, box: Any) -> Iterator[tuple[Floats, float, bool]]:
    """Yield where a name may stand, in pixels: its middle, its angle, whether that is inside of the object."""
    middle = np.asarray(ax.transData.transform(line.label))
    if line.closed:
        if np.ptp(points[:, 0]) > box.width and np.ptp(points[:, 1]) > box.height:
            yield middle, 0.0, True
        high, wide = (
            0.5 * np.ptp(points[:, 1]) + box.height,
            0.5 * (np.ptp(points[:, 0]) + box.width) + 0.4 * box.height,
        )
        for x, y in ((0, -high), (0, high), (wide, 0), (-wide, 0)):
            yield middle + np.array([x, y]), 0.0, False
        return
    straight = points[1] - points[0] if len(points) == 2 else np.zeros(2)
    angle = float(np.arctan2(straight[1], straight[0]) % np.pi)
    angle -= np.pi * (angle > 0.501 * np.pi)  # never upside down
    across = 0.9 * box.height * np.array([-np.sin(angle), np.cos(angle)])
    covered = len(points) == 2 and np.hypot(*straight) < LONG * box.width
    for far in (1.0, -1.0) if covered else (0.0, 1.0, -1.0):
        for share in (0.0, 0.25, -0.25):
            yield middle + far * across + share * straight, angle, False


def _spots(points: Floats) -> Floats:
    """Return points of a line, in pixels, no farther apart than a few of them."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    length = np.append(0.0, np.cumsum(steps))
    at = np.linspace(0.0, length[-1], 2 + int(min(length[-1] / 3.0, 2000.0)))
    return np.column_stack([np.interp(at, length, column) for column in points.T])


def _near(spots: Floats, others: Floats, far: float) -> bool:
    """Say whether any of some spots is near another."""
    return bool((np.hypot(*(spots[:, None] - others[None]).transpose(2, 0, 1)) < far).any())


def way_of(flown: Any, gravity: float, off: float) -> tuple[Floats, Floats, Floats]:
    """Return (x, y, t), the way of a ball with points between those of its trajectory, each chord near its flight.

    The chord of a flight over a time w is gravity w^2/8 off it at most.
    """
    t, x, y, vx, vy = (np.asarray(flown[name].values, np.float64) for name in ("t", "x", "y", "vx", "vy"))
    w = np.diff(t)
    with np.errstate(invalid="ignore", over="ignore"):
        count = np.nan_to_num(np.ceil(w * np.sqrt(gravity / (8.0 * off))), nan=1.0)
    count = np.append(np.clip(count, 1, CHORDS).astype(int), 1)
    begin = np.repeat(np.arange(len(t)), count)
    part = (np.arange(len(begin)) - np.repeat(np.cumsum(count) - count, count)) / count[begin]
    s = part * np.append(w, 0.0)[begin]
    return x[begin] + vx[begin] * s, y[begin] + (vy[begin] - 0.5 * gravity * s) * s, t[begin] + s
