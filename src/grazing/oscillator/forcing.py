"""A periodic force, or a periodic motion of a wall, as a Fourier series."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from grazing.oscillator.parameters import describe_parameter
from grazing.outcome import InputError, listed, shown
from grazing.parameter import real

#: Harmonics of a forcing: each is two parameters of the model and of every map that is made of it.
MOST_HARMONICS = 1000
#: Angles beyond which a double is too coarse for a phase.
LATEST = 1e15
#: Frequencies, and products of an amplitude and its frequency, whose squares a double still holds.
LOWEST, HIGHEST, STRONGEST = 1e-100, 1e100, 1e150
TOO_LATE = "beyond, a double has no phase in a period of the forcing; take whole periods off"


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
        if abs(self.t0) * self.omega > LATEST:
            raise InputError(f"t0 = {self.t0:g}; allowed is |t0| <= {LATEST / self.omega:g}: {TOO_LATE}")
        if self.cos is None:
            object.__setattr__(self, "cos", () if hasattr(self.sin, "__len__") and len(self.sin) else (1.0,))
        for name, values in (("cos", self.cos), ("sin", self.sin)):
            if hasattr(values, "__len__") and len(values) > MOST_HARMONICS:
                raise InputError(f"{name} has {len(values)} amplitudes; allowed are at most {MOST_HARMONICS}")
        cos, sin = _amplitudes(self.cos, "cos"), _amplitudes(self.sin, "sin")
        for name, found in (("cos", cos), ("sin", sin)):
            for j, value in enumerate(found, start=1):
                most = STRONGEST / max(1.0, j * self.omega)
                if abs(value) > most:  # flights would be looked at in millions of pieces
                    raise InputError(
                        f"{name}{j} = {value:g}; allowed is |{name}{j}| <= {most:g}: beyond, numbers overflow"
                    )
        m = max(len(cos), len(sin), 1)
        object.__setattr__(self, "cos", cos + (0.0,) * (m - len(cos)))
        object.__setattr__(self, "sin", sin + (0.0,) * (m - len(sin)))

    def __repr__(self) -> str:
        said = [f"{name}={getattr(self, name)!r}" for name in ("omega", "t0", "offset")]
        for name, values in (("cos", self.cos), ("sin", self.sin)):
            said.append(f"{name}=({listed(map(repr, values), 8)}{',' if len(values) == 1 else ''})")
        return f"Forcing({', '.join(said)})"


def refuse_out_of_range(omega: float) -> None:
    """Raise InputError for a frequency whose square no double holds."""
    if not LOWEST <= omega <= HIGHEST:
        raise InputError(f"omega = {omega:g}; allowed is {LOWEST:g} <= omega <= 1e100: beyond, numbers overflow")


def series_said(force: Any) -> str:
    """Say which forces are possible, to who gave something else."""
    if not callable(force):
        return "give a gz.Forcing(omega=..., ...)"
    return (
        "a force is a Fourier series here, not a function: give gz.Forcing(omega=..., offset=a0, cos=(a1, ...), "
        "sin=(b1, ...)) with its coefficients, which numpy.fft.rfft finds from a period of samples"
    )


def _amplitudes(values: Any, name: str) -> tuple[float, ...]:
    try:
        items = tuple(values)
    except TypeError:
        raise InputError(
            f"{name} = {shown(values)}; give one amplitude per harmonic, such as {name}=(1.0, 0.5)"
            + (f": {series_said(values)}" if callable(values) else "")
        ) from None
    return tuple(real(value, f"{name}{j + 1}", "any finite amplitude is allowed") for j, value in enumerate(items))
