"""Where orbits go, seen by a short trial: the ends of a raster that nobody has given."""

from __future__ import annotations

import warnings
from math import prod

import numpy as np

from grazing.outcome import InputError, level_outside
from grazing.studies.runs import Runs

#: A raster reaches so much farther than the points of a trial, of their extent.
ROOM = 0.05
#: A trial looks at so many values, starts and steps, after at most so many: it precedes a dry run, too.
TRIAL = 64, 20, 100, 1000


def trial_ranges(runs: Runs, coordinates: list[int], give: str) -> list[tuple[float, float]]:
    """Return where a few orbits at some of the values of one parameter have coordinates, and a little more.

    What has left, as a ball that is down a drain, counts only where nothing else is seen. ``give`` is what can be given
    instead.
    """
    settings, (values, starts, steps, before) = runs.settings, TRIAL
    cells = prod(runs.shape)
    some = np.unique(np.linspace(0, cells - 1, values).round().astype(np.int64))
    few = min(settings.starts, starts) if isinstance(settings.starts, int) else settings.starts[:starts]
    short = settings._replace(starts=few, transient=min(settings.transient, before), keep=min(settings.keep, steps))
    trial = Runs(runs.P, {name: grid[some] for name, grid in runs.axes.items()}, short, runs.moving)
    ends = np.array([[[np.inf, -np.inf]] * 2] * len(coordinates))  # of what is there, and of all
    with warnings.catch_warnings(record=True) as said:  # the study itself says what is wrong with a law
        warnings.simplefilter("always")
        for part in trial.pieces(np.arange(len(some))):
            left = runs.P.origin.left(part.letters)
            for which, i in enumerate(coordinates):
                x = part.points[:, :, i]
                for k, there in enumerate((np.isfinite(x) & ~left, np.isfinite(x))):
                    if there.any():
                        low, high = ends[which, k]
                        ends[which, k] = min(low, float(x[there].min())), max(high, float(x[there].max()))
    found = []
    for i, (there, all_of_it) in zip(coordinates, ends.tolist(), strict=True):
        low, high = there if there[0] <= there[1] else all_of_it
        if not low <= high:
            for one in said:
                warnings.warn(one.message, stacklevel=level_outside())
            raise InputError(f"every orbit of a trial ended before its first point; give {give}")
        room = max(ROOM * (high - low), 1e-6 * max(abs(high), runs.P.box[i][1] - runs.P.box[i][0]))
        if not np.isfinite((high + room) - (low - room)):
            raise InputError(f"the orbits of a trial have no range that a double holds; give {give}")
        found.append((low - room, high + room))
    return found
