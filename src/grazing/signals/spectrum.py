"""The spectrum of a sampled motion: an amplitude for each frequency."""

from __future__ import annotations

from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from grazing.outcome import InputError, shown
from grazing.signals.sample import model_of

if TYPE_CHECKING:
    import xarray as xr

#: What has a spectrum.
OF = {"u": "position", "v": "velocity"}
#: Attributes that say of what rig the motion is.
RIG = ("mass", "stop", "base")


def spectrum(recorded: xr.Dataset, of: str = "u", window: str = "hann") -> xr.Dataset:
    """Return the amplitude spectrum of a sampled motion.

    Parameters
    ----------
    recorded : xarray.Dataset
        From :func:`grazing.sample`. A trajectory itself has points at unequal times.
    of : {"u", "v"}
        Position or velocity; its mean is taken away.
    window : str
        Any window of ``scipy.signal.get_window``. ``"boxcar"`` is exact for a whole number of cycles; ``"hann"`` keeps
        lines apart from each other for any length, and shows a line between two frequencies up to 15 % too low,
        ``"flattop"`` 0.1 %.

    Returns
    -------
    xarray.Dataset
        ``amplitude`` on ``frequency``, in cycles per unit of time, from 0 to half the rate: a sine of amplitude A that
        falls on a line has A there; at half the rate, where samples take turns, what they have of it. ``order`` on
        ``frequency`` counts in the frequency of the forcing: a motion of n periods of the forcing has lines at
        multiples of 1/n.

    Raises
    ------
    InputError
        For samples at unequal times, fewer than 8 of them, or another window.

    Examples
    --------
    >>> import grazing as gz, numpy as np
    >>> m = gz.pinball(d=0.5)
    >>> tr = gz.trajectory(m, (0.5, 0.0), until=60 * m.period)
    >>> free = gz.sample(tr, rate=64 / m.period).isel(t=slice(20 * 64, 60 * 64))
    >>> found = gz.spectrum(free, window="boxcar")
    >>> strongest = found.isel(frequency=int(np.argmax(found.amplitude.values)))
    >>> round(float(strongest.order), 9), bool(np.isclose(strongest.amplitude, 1 / np.hypot(1 - 2.2**2, 3 * 2.2)))
    (1.0, True)
    """
    from grazing.late import signal
    from grazing.late import xarray as xr

    period = model_of(recorded).period
    if not isinstance(of, str) or of not in OF:
        raise InputError(f"of = {shown(of)}; allowed are u, the position, and v, the velocity")
    rate = recorded.attrs.get("sample_rate")
    t, x = recorded["t"].values, recorded[of].values
    if not isinstance(rate, Real) or not np.allclose(np.diff(t) * rate, 1.0, rtol=0.0, atol=1e-6):
        raise InputError("the times are not equally spaced; take samples first: gz.sample(trajectory, rate)")
    if len(t) < 8:
        raise InputError(f"there are {len(t)} samples; a spectrum needs 8 or more: choose a higher rate")
    try:
        with np.errstate(all="ignore"):  # a parameter that is too large for it gives nan
            weights = signal.get_window(window, len(t))
    except Exception as error:  # of whatever was given
        raise InputError(
            f"window = {shown(window)}; give one of scipy.signal.get_window with what it needs, such as 'hann', "
            "'boxcar' or ('kaiser', 14)"
        ) from error
    if not np.isfinite(weights).all() or not weights.any():
        raise InputError(f"window = {shown(window)} gives weights that are no numbers, or all 0; choose another one")
    frequency, power = signal.periodogram(x, fs=rate, window=weights, detrend="constant", scaling="spectrum")
    power[1 : (len(t) + 1) // 2] *= 2.0  # of a sine it is half; at 0 and at half the rate samples have all of it
    found = xr.Dataset(
        {"amplitude": ("frequency", np.sqrt(power), _said(recorded[of].attrs, of))},
        coords={
            "frequency": (
                "frequency",
                frequency,
                {"long_name": "frequency", "units": _per(recorded["t"]), "symbol": "f"},
            ),
            "order": (
                "frequency",
                frequency * period,
                {"long_name": "frequency over that of the forcing", "units": "1"},
            ),
        },
    )
    kept = {name: value for name, value in recorded.attrs.items() if name.startswith("parameter_") or name in RIG}
    title = str(recorded.attrs.get("title", "a motion"))
    return found.assign_attrs({"title": f"spectrum of {of}: {title}", "sample_rate": rate, **kept})


def _said(attrs: dict[str, Any], of: str) -> dict[str, Any]:
    return attrs | {"long_name": f"amplitude of the {attrs.get('long_name', of)}"}


def _per(t: xr.DataArray) -> str:
    """Return the unit of a frequency."""
    unit = t.attrs.get("units", "1")
    return {"1": "1", "s": "Hz"}.get(unit, f"1/{unit}")
