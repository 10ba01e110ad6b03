"""A motion from a state to a time, drawn, sampled or taken apart into lines: what the command line asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from grazing.oscillator.model import Oscillator
from grazing.oscillator.trajectory import trajectory
from grazing.outcome import InputError, shown
from grazing.parameter import real
from grazing.signals.sample import sample
from grazing.signals.spectrum import OF, spectrum
from grazing.systems.contract import System

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import ArrayLike

#: Samples in a period of the forcing, where no rate is given.
USUAL = 128
#: A sample nearer than this to the end, in steps, is the end.
WHOLE = 1e-6


def _refuse_system(model: Any, what: str) -> None:
    """Raise InputError for a system of one's own, which has no u and v."""
    if isinstance(model, System):
        raise InputError(
            f"{model!r} is a system of your own; {what} of an oscillator only; gz.trajectory takes any system"
        )


def _since(record: xr.Dataset, start: float, until: float, since: float | None) -> xr.Dataset:
    """Return a motion, what was before ``since`` left out."""
    if since is None:
        return record
    first = real(since, "since", "any time of the motion is allowed")
    if not start <= first < until:
        raise InputError(f"since = {first:g}; allowed is start = {start:g} <= since < until = {until:g}")
    kept: dict[str, Any] = {"t": record["t"].values >= first, "impact": record["impact_time"].values >= first}
    if "rest_time" in record:
        kept["rest"] = record["rest_time"].values[:, 1] >= first
    return record.isel(kept)


def history(
    model: Oscillator,
    state: ArrayLike,
    start: float = 0.0,
    until: float = 50.0,
    since: float | None = None,
    samples: int = 200,
    of: str = "u",
) -> xr.Dataset:
    """Return a trajectory, what was before ``since`` left out, whose figure is position or velocity over time."""
    _refuse_system(model, "there is a history")
    if not isinstance(of, str) or of not in OF:
        raise InputError(f"of = {shown(of)}; allowed are u, the position, and v, the velocity")
    motion = trajectory(model, state, start, until, samples).assign_attrs(history_of=of)
    return _since(motion, start, until, since)


def sampled(
    model: Oscillator,
    state: ArrayLike,
    start: float = 0.0,
    until: float = 50.0,
    since: float | None = None,
    rate: float | None = None,
) -> xr.Dataset:
    """Return a motion at equal times, what was before ``since`` left out."""
    _refuse_system(model, "there are samples and spectra")
    recorded = sample(trajectory(model, state, start, until), USUAL / model.period if rate is None else rate)
    return _since(recorded, start, until, since)


def spectrum_of(
    model: Oscillator,
    state: ArrayLike,
    start: float = 0.0,
    until: float = 50.0,
    since: float | None = None,
    rate: float | None = None,
    of: str = "u",
    window: str = "hann",
) -> xr.Dataset:
    """Return the spectrum of :func:`sampled`, without the end of a record of whole cycles: it is their beginning."""
    recorded = sampled(model, state, start, until, since, rate)
    last = recorded["t"].values[-1]
    if abs(last - until) * recorded.attrs["sample_rate"] < WHOLE:
        recorded = recorded.isel(t=slice(None, -1))
    return spectrum(recorded, of, window)
