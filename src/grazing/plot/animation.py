"""A ball on a pinball table as a short film, a GIF."""

from __future__ import annotations

from itertools import pairwise
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patches import Circle
from PIL import Image

from grazing.outcome import InputError
from grazing.parameter import Parameter, whole
from grazing.paths import path_of
from grazing.plot.expected import expect
from grazing.plot.style import styled
from grazing.plot.table import FLAT, WAY, way_of
from grazing.plot.table import table as draw_table
from grazing.writing import whole_file

SPEED = Parameter("speed", "c", "time on the table in a second of the film", 0.0, open="low")
#: Frames a second at most: what a GIF can say. It counts in hundredths of a second.
FASTEST, TICKS = 50, 100
#: Frames of a film at most: they are held in memory, and a browser shows no longer one.
MOST = 3000
#: Seconds of the film for which the way of the ball stays in sight, and dots per inch.
TAIL, DPI = 0.8, 100


def durations(count: int, fps: int) -> list[int]:
    """Return for how many milliseconds frames are shown, so that each ends at the tick next to its end."""
    ends = [round(i * TICKS / fps) for i in range(count + 1)]
    return [(end - begin) * (1000 // TICKS) for begin, end in pairwise(ends)]


def animate(table: Any, flown: Any, path: str | Path, *, fps: int = 25, speed: float = 1.0) -> Path:
    """Write the way of a ball on a pinball table as an animated GIF, to scale, with flippers that move.

    Parameters
    ----------
    table : Table
        From :func:`grazing.table`.
    flown : xarray.Dataset
        Of :func:`grazing.trajectory` on this table. The film ends with it.
    path : str or Path
        A file that ends in ``.gif``. It is written whole or not at all.
    fps : int
        Frames a second, from 1 to 50.
    speed : float
        Time on the table in a second of the film, > 0.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For anything but a table and a trajectory on one, another ending, or a film of more than 3000 frames.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import grazing as gz
    >>> T = gz.read_table("one_bumper")
    >>> flown = gz.trajectory(T, (0.3, 4.0, 0.0, 0.0), until=2.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     gz.plot.animate(T, flown, pathlib.Path(folder) / "ball.gif", fps=5).stat().st_size > 1000
    True
    """
    target, fps, speed = path_of(path), whole(fps, "fps", 1, FASTEST), SPEED.check(speed)
    if target.suffix.lower() != ".gif":
        raise InputError(f"a film is written as .gif; the file is called {target.name}")
    expect(flown, "trajectory", dict.fromkeys(("x", "y", "vx", "vy"), ("t",)), "animate")
    t = np.asarray(flown.t.values, np.float64)
    frames = ceil((t[-1] - t[0]) * fps / speed) + 1
    if frames > MOST:
        raise InputError(
            f"the film has {frames} frames; allowed are {MOST}: choose a larger speed, fewer frames a second, or a "
            "shorter trajectory"
        )
    data = [np.asarray(flown[name].values, np.float64) for name in ("x", "y", "vx", "vy")]
    drawn = draw_table(table, names=False)
    figure = drawn["figure"]
    (ax,) = figure.axes
    extent = max(np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim()))
    way_x, way_y, moments = way_of(flown, table.gravity, FLAT * extent)
    (tail,) = ax.plot([], [], color=WAY, lw=0.7, zorder=4)
    ball = ax.add_patch(Circle((0.0, 0.0), max(table.rho, 0.006 * extent), fc=WAY, ec=WAY, lw=0.8, zorder=6))
    turning = list(table.angles(0.0))
    parts = [drawn[kind][name] for kind in ("bodies", "objects") for name in turning if name in drawn[kind]]
    shots: list[Image.Image] = []
    with styled():
        figure.set_dpi(DPI)
        canvas: Any = FigureCanvasAgg(figure)
        canvas.draw()
        figure.set_layout_engine("none")  # which would move the axes
        for part in (*parts, tail, ball):  # in this order they lie upon each other, and all upon what stands
            part.set_animated(True)
        canvas.draw()
        still = canvas.copy_from_bbox(figure.bbox)
        for now in t[0] + np.minimum(np.arange(frames) * speed / fps, t[-1] - t[0]):
            i = int(np.searchsorted(t, now, side="right")) - 1
            s, (x, y, vx, vy) = now - t[i], (one[i] for one in data)
            place = x + vx * s, y + (vy - 0.5 * table.gravity * s) * s
            ball.set_center(place)
            seen = (moments > now - TAIL * speed) & (moments <= now)
            tail.set_data(np.append(way_x[seen], place[0]), np.append(way_y[seen], place[1]))
            for line in table.outlines(float(now)) if turning else ():
                if line.name in turning:
                    drawn["objects"][line.name].set_data(*line.points.T)
                    if line.name in drawn["bodies"]:
                        drawn["bodies"][line.name].set_xy(line.points)
            canvas.restore_region(still)
            for part in (*parts, tail, ball):
                ax.draw_artist(part)
            shots.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    with whole_file(target) as file, file.open("wb") as film:
        shots[0].save(film, "GIF", save_all=True, append_images=shots[1:], duration=durations(frames, fps), loop=0)
    return target
