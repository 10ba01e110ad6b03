"""A periodic force, or a periodic motion of a wall, as a Fourier series."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count, islice, takewhile
from math import pi
from typing import Any, TypeVar

import numpy as np

from grazing.oscillator.parameters import describe_parameter
from grazing.outcome import InputError, listed, shown
from grazing.parameter import in_order, real, refuse_late, whole

T = TypeVar("T")

#: Harmonics of a forcing: each is two parameters of the model and of every map that is made of it.
MOST_HARMONICS = 1000
#: Frequencies, and products of an amplitude and its frequency, whose squares a double still holds; forces that do not
#: move the ball by less than doubles hold. Flights are made of the fourth power of a frequency.
LOWEST, HIGHEST, WEAKEST, STRONGEST = 1e-60, 1e60, 1e-150, 1e150


@dataclass(frozen=True, slots=True)
class Forcing:
    """A periodic forcing: f(t) = offset + sum_j cos[j-1] cos(j omega (t + t0)) + sin[j-1] sin(j omega (t + t0)).

    Parameters
    ----------
    omega : float
        Frequency, > 0; the period is 2 pi/omega.
    t0 : float
        Time shift.
    offset : float
        Constant part.
    cos, sin : sequence of float
        Amplitudes of harmonics 1, 2, ..., at most 1000; the shorter one is filled up with zeros. If neither is given
        there is one cosine of amplitude 1; sines alone come without cosines. Flights are computed
        with at most 200, and a new number of harmonics is compiled first: a second for few, two minutes for 200.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.Forcing(omega=2.0, cos=(1.0,), sin=(0.0, 0.5)).cos
    (1.0, 0.0)
    """

    omega: float
    t0: float = 0.0
    offset: float = 0.0
    cos: Sequence[float] = None  # type: ignore[assignment]  # a sequence afterwards
    sin: Sequence[float] = ()

    def __post_init__(self) -> None:
        for name in ("omega", "t0", "offset"):
            object.__setattr__(self, name, describe_parameter(name).check(getattr(self, name)))
        refuse_out_of_range(self.omega)
        refuse_late(self.t0, "t0", 2.0 * pi / self.omega)
        if self.cos is None:
            object.__setattr__(self, "cos", () if hasattr(self.sin, "__len__") and len(self.sin) else (1.0,))
        cos, sin = _amplitudes(self.cos, "cos"), _amplitudes(self.sin, "sin")
        for name, found in (("cos", cos), ("sin", sin)):
            for j, value in enumerate(found, start=1):
                most = STRONGEST / max(1.0, j * self.omega)
                if abs(value) > most:  # flights would be looked at in millions of pieces
                    raise InputError(
                        f"{name}{j} = {value:g}; allowed is |{name}{j}| <= {most:g}: beyond, numbers overflow"
                    )
        largest = max(map(abs, (self.offset, *cos, *sin)))
        if 0.0 < largest < WEAKEST:
            raise InputError(
                f"the force is at most {largest:g}; allowed are 0 and amplitudes of which one is at least {WEAKEST:g}: "
                "below, numbers are lost; take another unit of length"
            )
        m = max(len(cos), len(sin), 1)
        object.__setattr__(self, "cos", cos + (0.0,) * (m - len(cos)))
        object.__setattr__(self, "sin", sin + (0.0,) * (m - len(sin)))

    @classmethod
    def from_samples(cls, samples: Sequence[float], omega: float, harmonics: int, *, t0: float = 0.0) -> Forcing:
        """Return the Fourier series of a periodic force that is given by its values.

        Parameters
        ----------
        samples : array_like, shape (n,)
            Values at the times j T/n - t0, j = 0, ..., n - 1, of one period T = 2 pi/omega: the value at its end is
            that at its beginning, and is not given again. At least 3.
        omega : float
            Frequency, > 0.
        harmonics : int
            How many are kept, at most (n - 1)/2.
        t0 : float
            Time shift.

        Returns
        -------
        Forcing

        Raises
        ------
        InputError
            For samples that are no list of finite numbers, or more harmonics than they determine.

        Warns
        -----
        UserWarning
            If the series differs from the samples by more than rounding: by how much at most. Beside a jump of the
            force that does not become less with more harmonics, only narrower.

        Examples
        --------
        >>> import grazing as gz, numpy as np
        >>> t = np.arange(16) / 16.0
        >>> force = gz.Forcing.from_samples(0.2 + np.cos(2 * np.pi * t), omega=3.0, harmonics=1)
        >>> round(force.offset, 12), [round(x, 12) for x in force.cos]
        (0.2, [1.0])
        """
        try:
            values = np.asarray(in_order(samples))
        except Exception:  # of whatever object was given
            values = np.empty(0)
        if values.ndim != 1 or len(values) < 3 or values.dtype.kind not in "iuf" or not np.isfinite(values).all():
            raise InputError(
                f"samples = {shown(samples)}; give the values of the force in one period, at least 3 finite numbers"
            )
        most = (len(values) - 1) // 2
        kept = whole(harmonics, "harmonics", 1)
        if kept > most:
            raise InputError(f"harmonics = {kept}; {len(values)} samples determine {most} at most")
        found = np.fft.rfft(values.astype(np.float64))
        within = np.zeros_like(found)
        within[: kept + 1] = found[: kept + 1]
        error = float(np.abs(values - np.fft.irfft(within, len(values))).max())
        if error > 1e-12 * float(np.abs(values).max()):
            warnings.warn(
                f"{kept} harmonics differ from the samples by up to {error:.2g}, of a force that goes from "
                f"{values.min():.4g} to {values.max():.4g}" + ("" if kept == most else f"; allowed are up to {most}"),
                stacklevel=2,
            )
        amplitudes = 2.0 / len(values) * found[1 : kept + 1]
        offset = float(found[0].real) / len(values)
        return cls(omega, t0, offset, amplitudes.real.tolist(), (-amplitudes.imag).tolist())

    def __repr__(self) -> str:
        said = [f"{name}={getattr(self, name)!r}" for name in ("omega", "t0", "offset")]
        for name, values in (("cos", self.cos), ("sin", self.sin)):
            said.append(f"{name}=({listed(map(repr, values), 8)}{',' if len(values) == 1 else ''})")
        return f"Forcing({', '.join(said)})"


def refuse_out_of_range(omega: float, name: str = "omega", unit: float = 1.0) -> None:
    """Raise InputError for a frequency whose square no double holds, given by a name in a unit of so many rad/s."""
    if not LOWEST <= omega <= HIGHEST:
        low, high = LOWEST / unit, HIGHEST / unit
        raise InputError(
            f"{name} = {omega / unit:g}; allowed is {low:.3g} <= {name} <= {high:.3g}: beyond, numbers overflow"
        )


def series_said(force: Any) -> str:
    """Say which forces are possible, to who gave something else."""
    if not callable(force):
        return "give a gz.Forcing(omega=..., ...)"
    return (
        "a force is a Fourier series here, not a function: give gz.Forcing(omega=..., offset=a0, cos=(a1, ...), "
        "sin=(b1, ...)) with its coefficients, or gz.Forcing.from_samples(values, omega, harmonics)"
    )


def _amplitudes(values: Any, name: str) -> tuple[float, ...]:
    try:
        items = tuple(islice(in_order(values), MOST_HARMONICS + 1))
    except Exception:  # of whatever object was given
        raise InputError(
            f"{name} = {shown(values)}; give one amplitude per harmonic, such as {name}=(1.0, 0.5)"
            + (f": {series_said(values)}" if callable(values) else "")
        ) from None
    if len(items) > MOST_HARMONICS:
        raise InputError(f"{name} has more than {MOST_HARMONICS} amplitudes, which are the most")
    return tuple(real(value, f"{name}{j + 1}", "any finite amplitude is allowed") for j, value in enumerate(items))


def amplitudes_in(values: Mapping[str, T], front: str = "") -> tuple[list[T], list[T]]:
    """Return the cosines and sines among flat parameters, those with ``front`` before their names.

    They are counted by their full names: one of a law may begin as theirs do.

    Examples
    --------
    >>> amplitudes_in({"cos1": 0.5, "sin1": 0.0, "cost": 3.0})
    ([0.5], [0.0])
    """
    js = list(takewhile(lambda j: f"{front}cos{j}" in values, count(1)))
    return [values[f"{front}cos{j}"] for j in js], [values[f"{front}sin{j}"] for j in js]
