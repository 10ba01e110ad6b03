"""Samples of a trajectory at equal times: each computed by the flight that it lies on, none interpolated."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing.measured import of_table
from grazing.memory import refuse_too_large
from grazing.oscillator.forcing import Forcing, amplitudes_in
from grazing.oscillator.legs import flown, heights
from grazing.oscillator.model import Oscillator
from grazing.oscillator.parameters import COORDINATES
from grazing.oscillator.reset import newton
from grazing.oscillator.wall import Wall, wall
from grazing.oscillator.walled import Walled
from grazing.oscillator.walled_trajectory import above_first
from grazing.outcome import InputError, listed, shown
from grazing.parameter import real

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Bytes of a sample while it is computed.
SAMPLE = 200
#: What a trajectory has.
NEEDED = ("t", "u", "v", "impact_time")
#: Variables of something else that a message names.
SHOWN = 6
#: Units that a model knows.
CONVERTED = {name: COORDINATES[name] for name in ("t", "u", "v")}


def sample(trajectory: xr.Dataset, rate: float) -> xr.Dataset:
    """Return position and velocity at equal times.

    Parameters
    ----------
    trajectory : xarray.Dataset
        From :func:`grazing.trajectory`, also loaded from a file.
    rate : float
        Samples per unit of time (in hertz where time is in seconds), positive.

    Returns
    -------
    xarray.Dataset
        ``u``, ``v`` on ``t``, from the first instant of the trajectory at steps of 1/rate; the impacts and the
        attributes of the trajectory. A sample at the instant of an impact has the velocity after it.

    Raises
    ------
    InputError
        For something that is no trajectory, or a rate that is not positive.

    Warns
    -----
    UserWarning
        If the rate is below twice the frequency of the highest harmonic of the forcing: what is above half the rate
        appears at other frequencies. Impacts have no highest frequency: take the rate as high as the spectrum asks for.

    Notes
    -----
    Every sample follows from the point of the trajectory before it in closed form, so that its error is that of the
    trajectory, and the samples of one trajectory at two rates agree where they meet.

    Examples
    --------
    >>> import grazing as gz
    >>> tr = gz.trajectory(gz.pinball(d=0.12, V=0.4), (0.1, 0.0), until=20.0)
    >>> recorded = gz.sample(tr, rate=50.0)
    >>> recorded.sizes["t"], round(float(recorded.t[1]), 3)
    (1001, 0.02)
    """
    model = model_of(trajectory)
    rate = real(rate, "rate", "any positive number of samples per unit of time is allowed")
    if not rate > 0.0:
        raise InputError(f"rate = {rate:g}; any positive number of samples per unit of time is allowed")
    t, u, v = (np.ascontiguousarray(trajectory[name].values, np.float64) for name in "tuv")
    refuse_too_large(SAMPLE * (t[-1] - t[0]) * rate, "choose a lower rate or a shorter trajectory", "the samples")
    _warn_if_low(model, rate)
    times = t[0] + np.arange(int((t[-1] - t[0]) * rate * (1.0 + 1e-12)) + 1) / rate
    times = np.minimum(times, t[-1])
    us, vs = _between(model, t, u, v, times)
    kept = trajectory.drop_dims("t")
    found = kept.assign({"u": ("t", us, trajectory["u"].attrs), "v": ("t", vs, trajectory["v"].attrs)})
    if isinstance(model, Walled):
        places, _speeds = model.places_at(times)
        found = found.assign(wall_position=(("wall", "t"), places, trajectory["wall_position"].attrs))
    found = found.assign_coords(t=("t", times, trajectory["t"].attrs))
    found = found[["u", "v", *(name for name in found.data_vars if name not in ("u", "v"))]]  # first in tables, too
    return found.assign_attrs(trajectory.attrs | {"sample_rate": rate})


def model_of(trajectory: Any) -> Oscillator | Walled:
    """Return the oscillator whose flights a trajectory follows; its impacts are those that are recorded.

    Raises
    ------
    InputError
        For something that is no trajectory.
    """
    names = getattr(trajectory, "variables", ())
    if not (isinstance(names, Mapping) and all(name in names for name in NEEDED) and trajectory["u"].dims == ("t",)):
        if of_table(trajectory):
            raise InputError(
                "the trajectory is that of a ball on a table; samples, sounds and spectra are of oscillators: its own "
                "points are as many as samples= of gz.trajectory says"
            )
        found = f"a dataset with {listed(map(str, names), SHOWN)}" if isinstance(names, Mapping) else shown(trajectory)
        raise InputError(f"trajectory is {found}; give a dataset as gz.trajectory returns it")
    shapes = {trajectory[name].dims for name in CONVERTED}
    if shapes != {("t",)} or not trajectory.sizes["t"] or any(trajectory[name].dtype.kind != "f" for name in CONVERTED):
        raise InputError("t, u and v of the trajectory are not numbers along t; it was changed: compute it again")
    if any(trajectory[name].attrs.get("units", "1") not in ("1", known.units) for name, known in CONVERTED.items()):
        raise InputError("the trajectory is in other units than its model; take samples first, then gz.in_units")
    has = {str(k).removeprefix("parameter_"): v for k, v in trajectory.attrs.items() if k.startswith("parameter_")}
    try:
        cos, sin = amplitudes_in(has)
        offset = has["offset"] if "offset" in has else has["d"]
        forcing = Forcing(omega=has["omega"], t0=has["t0"], offset=offset, cos=cos, sin=sin)
        spring = {name: has[name] for name in (("stiffness",) if "stiffness" in has else ("k",))}
        if "wall_position" in names:
            walls = _walls(trajectory, has, forcing)
            return Walled(has["alpha"], forcing=forcing, walls=walls, **({"k": None} | spring))
        return Oscillator(has["alpha"], forcing=forcing, reset=newton(1.0), sigma=has["sigma"], **spring)
    except KeyError as missing:
        raise InputError(f"the trajectory does not say its parameter {missing}; give one from gz.trajectory") from None


def _walls(trajectory: xr.Dataset, has: dict[str, Any], forcing: Forcing) -> list[Wall]:
    """Return the walls of a trajectory, whatever their laws."""
    found = []
    for name, side in zip(trajectory["wall"].values.tolist(), trajectory["side"].values.tolist(), strict=True):
        cos, sin = amplitudes_in(has, f"{name}.")
        motion = Forcing(forcing.omega, forcing.t0, cos=cos, sin=sin) if cos else None
        at = has[f"{name}.sigma"] if f"{name}.sigma" in has else has["sigma"]
        found.append(wall(at, newton(1.0), side, motion, name))
    return found


def _warn_if_low(model: Oscillator | Walled, rate: float) -> None:
    f = model.forcing
    highest = max((j for j, wave in enumerate(zip(f.cos, f.sin, strict=True), 1) if any(wave)), default=0)
    enough = 2.0 * highest / model.period
    if rate < enough:
        warnings.warn(
            f"rate = {rate:g} is below {enough:g}, twice the frequency of harmonic {highest} of the forcing: "
            "what is above half the rate appears at other frequencies",
            stacklevel=3,
        )


def _between(model: Oscillator | Walled, t: Floats, u: Floats, v: Floats, times: Floats) -> tuple[Floats, Floats]:
    """Return positions and velocities at times, each by the flight from the point before it."""
    if isinstance(model, Walled):
        return _between_walls(model, t, u, v, times)
    before = np.searchsorted(t, times, side="right") - 1  # the later one of two points at an impact
    after = np.minimum(before + 1, len(t) - 1)
    rests = (u[before] == model.sigma) & (v[before] == 0.0) & (u[after] == model.sigma) & (v[after] == 0.0)
    phases = np.fmod(t[before] - t[0], model.period)
    us, vs = flown(model, t[0], phases, u[before] - model.sigma, v[before], times - t[before])
    us[rests], vs[rests] = model.sigma, 0.0
    exact = times == t[before]
    us[exact], vs[exact] = u[before][exact], v[before][exact]
    return us, vs


def _between_walls(model: Walled, t: Floats, u: Floats, v: Floats, times: Floats) -> tuple[Floats, Floats]:
    """Return the same between walls: flights as without them, rests on the wall that carries."""
    before = np.searchsorted(t, times, side="right") - 1  # the later one of two points at an impact
    after = np.minimum(before + 1, len(t) - 1)
    free = above_first(model)
    phases = np.fmod(t[before] - t[0], model.period)
    hs, vs = heights(free, t[0], phases, u[before] - free.sigma, v[before], times - t[before])
    us = hs + free.sigma
    (now, speed), (places, speeds) = model.places_at(times), model.places_at(t)
    for at, moving, here, then in zip(now, speed, places, speeds, strict=True):
        rides = (u == here) & (v == then)
        rests = rides[before] & rides[after]
        us[rests], vs[rests] = at[rests], moving[rests]
    exact = times == t[before]
    us[exact], vs[exact] = u[before][exact], v[before][exact]
    return us, vs
