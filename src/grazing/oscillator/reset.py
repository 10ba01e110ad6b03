"""Reset laws: the velocity just after an impact from the velocity just before, v_minus < 0 <= v_plus."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import lru_cache
from math import inf
from types import MappingProxyType
from typing import Any

from grazing.copies import ByValue, packed, plain
from grazing.outcome import InputError, UserCodeError, defined, listed, shown, told
from grazing.parameter import Parameter, checked_params, parameters, real

R = Parameter("r", "r", "coefficient of restitution", 0.0, 1.0)
V = Parameter("V", "V", "extra velocity given by an active bumper", 0.0, units="m/s")
TRIGGER = Parameter("trigger", "v_s", "least speed of impact that fires the bumper", 0.0, units="m/s")
#: Speeds at which a law is tried before it belongs to a model, whose own speeds are tried then: slow in any unit.
SLOW = 1e-6
#: How many times faster than its orbits a law is tried for what it does to fast impacts, and that squared.
FAST = 100.0
KNOWN = {parameter.name: parameter for parameter in (R, V, TRIGGER)}


def newton_law(v: float, p: Any) -> float:
    """Newton's law of restitution, equation (1.2)."""
    return -p.r * v  # type: ignore[no-any-return]


def newton_slope(v: float, p: Any) -> float:
    """Return d v_plus/d v_minus of Newton's law."""
    return -p.r  # type: ignore[no-any-return]


def newton_contraction(p: Any) -> tuple[float, float]:
    """Every impact contracts by r."""
    return p.r, inf


def active_law(v: float, p: Any) -> float:
    """Active bumper, equation (1.3): restitution plus a kick."""
    return -p.r * v + p.V  # type: ignore[no-any-return]


def active_contraction(p: Any) -> tuple[float, float]:
    """Only without a kick do impacts contract."""
    return (p.r, inf) if p.V == 0.0 else (1.0, 0.0)


def triggered_law(v: float, p: Any) -> float:
    """Active bumper whose switch needs a minimum blow: passive below the trigger speed."""
    return -p.r * v + (p.V if -v >= p.trigger else 0.0)  # type: ignore[no-any-return]


def triggered_contraction(p: Any) -> tuple[float, float]:
    """Below the trigger speed impacts contract by r."""
    return (p.r, inf) if p.V == 0.0 else (p.r, p.trigger * (1.0 - 1e-15))


def no_contraction(p: Any) -> tuple[float, float]:
    """Nothing is known: chatter is followed impact by impact, and to call its end a rest takes a proof."""
    return 1.0, 0.0


@lru_cache(maxsize=256)
def difference_of(law: Callable[..., float]) -> Callable[..., float]:
    """Return the slope of a law by differences, good to about ten digits; a law is asked for v <= 0 only."""

    def slope(v: float, p: Any) -> float:
        h = 6e-6 * max(abs(v), 1e-3 * law(v, p))  # in any unit of speed; of a kick differences have few digits
        h = h if h > 0.0 else 6e-9
        if v + h > 0.0:
            return (3.0 * law(v, p) - 4.0 * law(v - h, p) + law(v - 2.0 * h, p)) / (2.0 * h)
        return (law(v + h, p) - law(v - h, p)) / (2.0 * h)

    slope.made_by = difference_of, (law,)  # type: ignore[attr-defined]
    return slope


@lru_cache(maxsize=256)
def constant_contraction(ratio: float, speed: float) -> Callable[..., tuple[float, float]]:
    """Return a contraction that does not depend on the parameters."""

    def contraction(p: Any) -> tuple[float, float]:
        return ratio, speed

    contraction.made_by = constant_contraction, (ratio, speed)  # type: ignore[attr-defined]
    return contraction


@dataclass(frozen=True, slots=True, eq=False)
class Reset(ByValue):
    """A reset law with its parameters; made by :func:`newton`, :func:`active`, :func:`triggered` or :func:`reset`.

    ``slope`` is d v_plus/d v_minus, ``exact_slope`` says whether it is exact or a central difference; ``affine``
    says whether the law is affine piece by piece, as closed forms need.
    """

    law: Callable[..., float]
    params: Mapping[str, float]
    slope: Callable[..., float]
    contraction: Callable[..., Any]
    exact_slope: bool = True
    name: str = field(default="")
    affine: bool = False

    def __repr__(self) -> str:
        values = listed(f"{name}={value:g}" for name, value in self.params.items())
        return f"{self.name}({values})"

    @property
    def own(self) -> bool:
        """Whether the law is a user's, which its name and parameters do not tell."""
        return self.law not in (newton_law, active_law, triggered_law)

    def __reduce__(self) -> Any:
        return _again, tuple(packed(getattr(self, field.name)) for field in fields(self))

    def __call__(self, v_minus: float, **params: float) -> float:
        """Return v_plus for one incoming velocity, in plain Python."""
        return checked_velocity(self, v_minus, {**self.params, **params})

    def replace(self, **changes: float) -> Reset:
        """Return the law with other parameter values."""
        return Reset(
            self.law, _checked({**self.params, **changes}), self.slope, self.contraction,
            self.exact_slope, self.name, self.affine,
        )  # fmt: skip


def _again(law: Any, params: Any, slope: Any, contraction: Any, exact_slope: bool, name: str, affine: bool) -> Reset:
    """Return a law from the parts that a pickle keeps."""
    parts = (plain(law), _checked(params), plain(slope), plain(contraction))
    return Reset(*parts, exact_slope, name, affine)


def _checked(params: Mapping[str, Any]) -> Mapping[str, float]:
    for name, value in params.items():
        if name in KNOWN:
            KNOWN[name].check(value)
    return MappingProxyType(checked_params(params))


def newton(r: float) -> Reset:
    """Return the passive wall, Newton's law of restitution: v_plus = -r v_minus (1.2).

    Parameters
    ----------
    r : float
        Coefficient of restitution, 0 <= r <= 1.

    Examples
    --------
    >>> import grazing as gz
    >>> gz.newton(r=0.5)(-2.0)
    1.0
    """
    return Reset(newton_law, _checked({"r": r}), newton_slope, newton_contraction, name="newton", affine=True)


def active(r: float, V: float) -> Reset:
    """Return the active bumper of a pinball table: v_plus = -r v_minus + V (1.3).

    Parameters
    ----------
    r : float
        Coefficient of restitution, 0 <= r <= 1.
    V : float
        Extra velocity, V >= 0; 0 is the passive wall.

    References
    ----------
    Pring and Budd, IMA J. Appl. Math. 76 (2011) 67-84, equation (1.3).

    Examples
    --------
    >>> import grazing as gz
    >>> gz.active(r=0.5, V=0.25)(-2.0)
    1.25
    """
    return Reset(active_law, _checked({"r": r, "V": V}), newton_slope, active_contraction, name="active", affine=True)


def triggered(r: float, V: float, trigger: float) -> Reset:
    """Return an active bumper that fires only for impacts of at least the trigger speed.

    Parameters
    ----------
    r : float
        Coefficient of restitution, 0 <= r <= 1.
    V : float
        Extra velocity when fired, V >= 0.
    trigger : float
        Least speed of impact that fires it, >= 0.

    Examples
    --------
    >>> import grazing as gz
    >>> bumper = gz.triggered(r=0.5, V=1.0, trigger=0.1)
    >>> bumper(-0.2), bumper(-0.02)
    (1.1, 0.01)
    """
    params = _checked({"r": r, "V": V, "trigger": trigger})
    return Reset(triggered_law, params, newton_slope, triggered_contraction, name="triggered", affine=True)


def reset(
    law: Callable[..., float], contraction: tuple[float, float] | Callable[..., Any] | None = None, **params: float
) -> Reset:
    """Return a reset law of your own.

    Parameters
    ----------
    law : callable
        ``law(v_minus, p) -> v_plus`` in plain scalar Python, v_minus <= 0, v_plus >= 0 and finite; ``p`` has the
        keywords below as fields.
    contraction : (ratio, speed) or callable, optional
        Says that v_plus <= ratio |v_minus| whenever |v_minus| <= speed, with ratio < 1: chatter is then completed
        in closed form. A callable gets ``p``. Without it chatter is followed impact by impact, and the rest that it
        leads to is *ambiguous*, unless ball arithmetic proves the contraction.
    **params : float
        Parameters of the law; they become parameters of the model: swept, shown and saved.

    Returns
    -------
    Reset

    Raises
    ------
    UserCodeError
        If the law raises, or returns a velocity into the wall or not finite, at rest or for a very slow impact. At
        the speeds of a model it is tried when it becomes part of it.

    Examples
    --------
    >>> import grazing as gz
    >>> def soft(v, p):
    ...     return -p.r * v / (1.0 - p.c * v)
    >>> gz.reset(soft, r=0.8, c=0.1)
    soft(r=0.8, c=0.1)
    """
    if not callable(law):
        raise InputError(f"law is {shown(law)}; give a function law(v_minus, p) -> v_plus")
    if contraction is None:
        known: Callable[..., Any] = no_contraction
    elif callable(contraction):
        known = contraction
    else:
        try:
            ratio, speed = (x if x == inf else real(x, "contraction", "") for x in contraction)
        except Exception:  # of whatever object was given
            raise InputError(f"contraction is {shown(contraction)}; give (ratio, speed) or a function of p") from None
        if not (0.0 <= ratio < 1.0 and speed > 0.0):
            raise InputError(f"contraction is ({ratio}, {speed}); allowed is 0 <= ratio < 1 and speed > 0")
        known = constant_contraction(float(ratio), float(speed))
    name = getattr(law, "__name__", "law")
    made = Reset(law, _checked(params), difference_of(law), known, exact_slope=False, name=name)
    probe(made, SLOW)
    return made


def probe(made: Reset, scale: float) -> None:
    """Try a law at rest and at a few speeds up to a scale, and where it is said to contract; raise if it is wrong."""
    ratio, speed = contraction_at(made, parameters(made.params))
    for v in (
        0.0,
        -1e-3 * scale,
        -0.1 * scale,
        -scale,
        *([-speed, -0.1 * speed] if ratio < 1.0 and speed < inf else ()),
    ):
        w = made(v)
        if ratio < 1.0 and -v <= speed and w > ratio * -v * (1.0 + 1e-12):
            raise InputError(
                f"contraction says v_plus <= {ratio:g} |v_minus| for speeds up to {speed:g}, "
                f"but the law gives {w:g} for v_minus = {v:g}; correct one of them"
            )


def warn_of_gain(made: Reset, speed: float) -> None:
    """Warn of a law that makes fast impacts faster: what flight loses may not be enough to keep orbits bounded."""
    for v in (FAST * speed, FAST * FAST * speed):
        try:
            w = made(-v)
        except UserCodeError:  # so fast it need not hold
            return
        if not w > v * (1.0 + 1e-9):
            return
    _warn_once(made.law, made.name)


@lru_cache(maxsize=256)
def _warn_once(law: Callable[..., float], name: str) -> None:
    """Warn of a law that makes fast impacts faster: once, though a study makes a model for each of its values."""
    warnings.warn(
        f"the reset law {name} makes fast impacts faster, v_plus > |v_minus|: orbits may grow without bound, and "
        "those that do end as diverged",
        RuntimeWarning,
        stacklevel=5,
    )


def linear_part(made: Reset, params: Mapping[str, float], speed: float) -> tuple[float, float]:
    """Return (r, V) of the law v_plus = r |v_minus| + V that is most like a law at rest and at a speed."""
    try:
        kick = made(0.0, **params)
        gain = (made(-speed, **params) - kick) / speed if speed > 0.0 else 1.0
    except UserCodeError:  # not at these values: the study says where
        return 1.0, 0.0
    return min(max(gain, 0.0), 1.0), kick


def contraction_at(made: Reset, p: Any) -> tuple[float, float]:
    """Return (ratio, speed) of a law at its parameters, in plain Python."""
    try:
        ratio, speed = (float(x) for x in made.contraction(p))
    except Exception as error:
        raise UserCodeError(
            f"the contraction of the reset law {made.name} raised {told(error, made.contraction)}; "
            "it must return (ratio, speed)"
        ) from error
    return ratio, speed


def checked_velocity(made: Reset, v_minus: float, params: Mapping[str, float]) -> float:
    """Apply a law in plain Python and say what is wrong with its answer, if anything."""
    v_minus = real(v_minus, "v_minus", "give a velocity towards the wall, v_minus <= 0")
    if v_minus > 0.0:
        raise InputError(f"v_minus = {v_minus:g} points away from the wall; give v_minus <= 0")
    p = parameters(params)
    try:
        v_plus = made.law(v_minus, p)
    except Exception as error:
        raise UserCodeError(_raised(made.name, made.law, error, v_minus, params)) from error
    if isinstance(v_plus, bool) or not isinstance(v_plus, (int, float)) or not 0.0 <= v_plus < inf:
        raise UserCodeError(
            f"the reset law {made.name} returned {shown(v_plus)} for v_minus = {v_minus:g}; "
            f"allowed is a finite v_plus >= 0, away from the wall{defined(made.law)}"
        )
    return float(v_plus)


@lru_cache(maxsize=256)
def in_python(law: Callable[..., float]) -> Callable[..., float]:
    """Return a law, or its slope, for plain Python: what it raises there comes with its name and its own line."""

    def tried(v: float, p: Any) -> float:
        try:
            return law(v, p)
        except Exception as error:
            raise UserCodeError(_raised(getattr(law, "__name__", "law"), law, error, v, p._asdict())) from error

    return tried


def _raised(name: str, law: Callable[..., float], error: Exception, v: float, params: Mapping[str, float]) -> str:
    return f"the reset law {name} raised {told(error, law)} (v_minus = {v:g}, {dict(params)})"
