"""A pinball table to scale, and the way of a ball on it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from grazing.outcome import InputError, shown
from grazing.plot.drawn import inline
from grazing.plot.expected import expect
from grazing.plot.style import GRAZE, INK, SINGLE, WALL, axes, plain, root, styled

Floats = NDArray[np.float64]
#: Height of a figure at most, as a share of its width, and the room around the objects as a share of their extent.
TALL, ROOM = 1.6, 0.04
WAY = "#0064a4"
#: Points of the arrow of a plunger.
LANE = 14.0
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
        Whether the objects' names stand beside them.

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
            if names:
                behind = None if line.closed else {"fc": "white", "ec": "none", "pad": 0.6}
                x0, y0 = line.label
                ax.text(x0, y0, plain(line.name), ha="center", va="center", size=6, color=colour, bbox=behind, zorder=5)
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
        ax.set_xlim(x.min() - edge, x.max() + edge)
        ax.set_ylim(y.min() - edge, y.max() + edge)
        ax.set_xlabel("$x$")
        ax.set_ylabel("$y$")
    return {"figure": root(ax), "objects": found, "bodies": bodies, "way": way, "ball": ball, "plunger": arrow}


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
