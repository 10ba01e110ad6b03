"""A motion as sound."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from grazing.outcome import InputError, shown
from grazing.parameter import real, whole
from grazing.paths import path_of
from grazing.signals.sample import model_of, sample
from grazing.signals.spectrum import OF
from grazing.writing import whole_file

if TYPE_CHECKING:
    import xarray as xr

#: The largest number of 16 bits, less a little.
FULL = 32_000
#: The tone of the forcing of a motion without units, in hertz.
PITCH = 440.0
#: What moves less than this share of its largest value, or of how far or how fast its model goes, does not sound.
STILL = 1e-12


def to_wav(
    trajectory: xr.Dataset, path: str | os.PathLike[str], speed: float = 1.0, of: str = "v", rate: int = 44_100
) -> Path:
    """Write a motion as a sound of one channel and 16 bits, as loud as it can be.

    Parameters
    ----------
    trajectory : xarray.Dataset
        From :func:`grazing.trajectory`.
    path : path-like
        Must end in ``.wav``.
    speed : float
        Units of time played in a second: 1 plays seconds as they were; a dimensionless forcing of period 3 sounds at
        440 Hz with a speed of 1320.
    of : {"v", "u"}
        Velocity, in which impacts are clicks, or position.
    rate : int
        Samples per second of the file.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        For a motion that rests or is too short to be heard, another ending, or a folder that cannot be written to.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import grazing as gz
    >>> m = gz.pinball(d=0.12, V=0.4)
    >>> tr = gz.trajectory(m, (0.1, 0.0), until=300 * m.period)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     gz.to_wav(tr, pathlib.Path(folder) / "bumper.wav", speed=440 * m.period).stat().st_size
    60182
    """
    from grazing.late import wavfile

    target = path_of(path)
    if target.suffix.lower() != ".wav":
        raise InputError(f"{target} ends in {target.suffix or 'nothing'!r}; allowed is '.wav'")
    if not isinstance(of, str) or of not in OF:
        raise InputError(f"of = {shown(of)}; allowed are v, the velocity, and u, the position")
    speed = real(speed, "speed", "any positive number of units of time in a second is allowed")
    if not speed > 0.0:
        raise InputError(f"speed = {speed:g}; any positive number of units of time in a second is allowed")
    rate = whole(rate, "rate", 1000, 384_000)
    model = model_of(trajectory)
    seconds = float(trajectory["t"][-1] - trajectory["t"][0]) / speed
    if seconds * rate < 2.0:
        raise InputError(f"the motion lasts {seconds:g} s at speed {speed:g}; choose a lower speed or a later end")
    x = sample(trajectory, rate / speed)[of].values
    middle = 0.5 * (x.max() + x.min())
    swing = np.abs(x - middle).max()
    if swing <= STILL * max(np.abs(x).max(), scale_of(model, of)):
        raise InputError(f"the motion rests: its {OF[of]} does not change, and nothing sounds")
    with whole_file(target) as part:
        wavfile.write(part, rate, np.round((x - middle) * (FULL / swing)).astype(np.int16))
    return target


def audible(trajectory: xr.Dataset) -> float:
    """Return a speed at which a motion can be heard: seconds as they were, else its forcing at 440 Hz."""
    return 1.0 if "mass" in trajectory.attrs else PITCH * float(model_of(trajectory).period)


def scale_of(model: Any, of: str) -> float:
    """Return how far, or how fast, orbits of a model go: of a ball at rest all that is recorded may be rounding."""
    found = model.reach_at(list(model.params.values()))
    several = (found,) if hasattr(found, "speed") else found
    return max(float(one.speed if of == "v" else one.height) for one in several)
