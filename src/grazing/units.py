"""Units: numbers of quantities that carry them, and results in the units that somebody reads."""

from __future__ import annotations

import json
import re
from math import pi
from typing import TYPE_CHECKING, Any

from grazing.memory import refuse_too_large
from grazing.outcome import InputError, in_one_line, shown

if TYPE_CHECKING:
    import xarray as xr

#: A number and its units as a text. What computes, such as a power of a power, is no quantity.
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(.*?)\s*")
_UNITS = re.compile(
    r"[^\W\d]{1,30}(?:\^-?\d)?(?:(?: ?[*/·] ?| )[^\W\d]{1,30}(?:\^-?\d)?){0,6}|1/[^\W\d]{1,30}(?:\^\d)?"
)
#: Units of results.
MEASURED = ("m", "m/s", "s", "1/s", "rad/s", "Hz", "N/kg", "N s/kg")
#: What an angular frequency is divided by, to be one in turns.
TURN = r"/2\pi"
#: Attributes of a whole result that are ends of the parameter that varies.
SEARCHED = ("span", "bounds")
#: The attribute that keeps the units that were asked for, for the command that makes the result again.
ASKED = "grazing_units"
#: Attributes of a variable that are numbers in its own units.
ENDS = ("low", "high")


def magnitude(value: Any, units: str, name: str) -> Any:
    """Return the number, or the array, of a quantity in given units; what carries no units is returned as it is.

    Parameters
    ----------
    value : float, array_like, str or pint.Quantity
        A text is a number and its units: "1.2 mm".
    units : str
        As pint reads them; ``"1"`` for a number, empty where nobody knows them.
    name : str
        Of what is given, for messages.

    Raises
    ------
    InputError
        If the units do not match, for a text that is no quantity, or without pint. Hertz, turns and radians are told
        apart: 1 Hz is 2 pi rad/s, and 1/s is neither.
    """
    said = f"{name} = {shown(value)}"
    if isinstance(value, (list, tuple)) and any(isinstance(one, str) or hasattr(one, "magnitude") for one in value):
        return [magnitude(one, units, f"{name}[{i}]") for i, one in enumerate(value)]
    if isinstance(value, str):
        try:
            number, unit = _read(value, said)
        except InputError as error:  # of whatever unit, it is said of what
            raise InputError(str(error) if str(error).startswith(said) else f"{said}; {error}") from None
    elif hasattr(value, "to") and hasattr(value, "magnitude") and hasattr(value, "units"):
        number, unit = value.magnitude, value.units
    else:
        return value
    if not units:
        raise InputError(f"{said}; the units of {name} are not known: give a number")
    factor = _factor(unit, units)
    if factor is None:
        wanted = "a number without units" if units == "1" else f"a quantity such as '1 {units}'"
        fault = "it has no units" if str(unit) == "dimensionless" else "its units do not match"
        raise InputError(f"{said}; {fault}: give {wanted}")
    return number * factor


def in_units(result: Any, *units: str) -> xr.Dataset:
    """Return a result in other units: every variable whose units match one of them.

    Parameters
    ----------
    result : xarray.Dataset, or what has one
        Of a model with units, see :meth:`grazing.Oscillator.from_si`; a branch or a locus is taken as its ``dataset``.
    *units : str
        Such as ``"mm"``, ``"mm/s"``, ``"Hz"``, ``"ms"``, ``"N"`` or ``"N s"``. Forces and impulses are per unit of mass
        in a result; these two multiply by the mass.

    Returns
    -------
    xarray.Dataset
        Figures of it and files made from it show these units. Attributes of the whole, such as the parameters, stay
        in SI units, but for the ends of what was searched. What was opened in chunks, as by ``xarray.open_zarr``, is
        read and converted when it is asked for.

    Raises
    ------
    InputError
        For units that match nothing in the result, two that match the same variable, without pint, or if the
        numbers in both units take more than half of the memory.

    Examples
    --------
    >>> import grazing as gz
    >>> rig = gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, force=2.5, gap=1.2e-3, frequency=14, reset=gz.newton(0.7))
    >>> tr = gz.in_units(gz.trajectory(rig, (0, 0), until=0.5), "mm", "ms")
    >>> tr.u.attrs["units"], tr.v.attrs["units"], round(float(tr.u.min()), 9)
    ('mm', 'm/s', -1.2)
    """
    from grazing.late import xarray as xr

    found = getattr(result, "dataset", result)
    if not isinstance(found, xr.Dataset):
        raise InputError(f"result is {shown(result)}; give a dataset as studies return it")
    try:
        return _in_units(found, units)
    except InputError:
        raise
    except (ValueError, TypeError, LookupError, ArithmeticError) as error:  # attributes of a file may say anything
        raise InputError(
            f"the result does not hold the numbers that its units are of ({type(error).__name__}: "
            f"{in_one_line(error)}); it was changed: compute it again"
        ) from error


def _in_units(found: xr.Dataset, units: tuple[str, ...]) -> xr.Dataset:
    mass = found.attrs.get("mass")
    factors, matched = {}, set()
    for name, variable in found.variables.items():
        # a point of a section has a unit for each of its coordinates
        parts = [_fitting(str(name), old, units, mass) for old in _units_of(variable)]
        matched |= {unit for unit, _factor in parts}
        if any(factor != 1.0 for _unit, factor in parts):
            factors[name] = parts
    for unit in units:
        if unit not in matched:
            has = sorted({old for one in found.variables.values() for old in _units_of(one)})
            there = f"it has {', '.join(has)}" if has else "it is dimensionless: make the model with Oscillator.from_si"
            raise InputError(f"{shown(unit)} matches nothing in the result; {there}")
    # the numbers in their own units, and those made of them; what is in chunks is read when it is asked for
    size = sum(2 * found.variables[name].nbytes for name in factors if found.variables[name].chunks is None)
    refuse_too_large(size, "take a part of it, or open it in chunks: xarray.open_zarr(store, chunks={})", "its numbers")
    converted = found.assign(
        {
            name: _scaled(found.variables[name], [factor for _unit, factor in parts], ", ".join(u for u, _ in parts))
            for name, parts in factors.items()
        }
    )
    ends = _searched(found, {name: parts[0][1] for name, parts in factors.items()})
    asked = _asked(found, units, mass)
    return converted.assign_attrs(ends | ({ASKED: ",".join(asked)} if asked else {}))


def _asked(found: xr.Dataset, units: tuple[str, ...], mass: float | None) -> list[str]:
    """Return the units that were asked for, earlier ones too where none of these takes their place."""
    earlier = [unit for unit in str(found.attrs.get(ASKED, "")).split(",") if unit and unit not in units]
    return [unit for unit in earlier if all(_factor(unit, new, mass) is None for new in units)] + list(units)


def _searched(found: xr.Dataset, factors: dict[Any, float]) -> dict[str, Any]:
    """Return the ends of what was searched in other units: of one parameter, or as JSON those of each of a locus."""
    ends: dict[str, Any] = {}
    along = found.attrs.get("parameter") if found.attrs.get("parameter") in found else "low"
    for key in SEARCHED:
        given = found.attrs.get(key)
        if isinstance(given, str):
            names, bounds = json.loads(found.attrs["parameters"]), json.loads(given)
            if any(name in factors for name in names):
                scales = [factors.get(name, 1.0) for name in names]
                ends[key] = json.dumps([[end * x for end in one] for one, x in zip(bounds, scales, strict=True)])
        elif given is not None and along in factors:
            ends[key] = [float(end) * factors[along] for end in given]
    return ends


def _units_of(variable: xr.Variable) -> list[str]:
    """Return the units of a variable: none of a number or a text, several of points of a section."""
    units = str(variable.attrs.get("units", "1"))
    return [] if units == "1" else units.split(", ")


def _fitting(name: str, old: str, units: tuple[str, ...], mass: float | None) -> tuple[str, float]:
    """Return which of the units matches an old one, and the factor to it; the old one and 1 if none does."""
    factors = {unit: _factor(old, unit, mass) for unit in units}
    found = [(unit, factor) for unit, factor in factors.items() if factor is not None]
    if len(found) > 1:
        raise InputError(f"{' and '.join(repr(unit) for unit, _ in found)} both match {name}, in {old}: give one")
    return found[0] if found else (old, 1.0)


def matching(unit: str) -> bool:
    """Whether a result of a model in SI units may hold something that a unit measures; raise InputError for none."""
    return any(_factor(old, unit, 1.0) is not None for old in MEASURED)


def checked_units(units: Any, name: str) -> tuple[str, ...]:
    """Return the units in a list, or in a text with commas; raise InputError for those that no result has."""
    parts = units.split(",") if isinstance(units, str) else units
    if not isinstance(parts, (list, tuple)) or not all(isinstance(one, str) for one in parts):
        raise InputError(f"{name} = {shown(units)}; give units with commas between them, such as mm,Hz,N s")
    found = tuple(one.strip() for one in parts)
    for unit in found:
        if not matching(unit):
            raise InputError(f"{shown(unit)} matches nothing that a result has; give some of mm,mm/s,Hz,N,N s")
    return found


def _scaled(variable: xr.Variable, factors: list[float], unit: str) -> xr.Variable:
    """Return a variable in another unit, with what is said of it; several are those along its coordinates."""
    import numpy as np

    factor: Any = factors[0]
    if len(factors) > 1:
        where = variable.dims.index("coordinate")
        factor = np.reshape(factors, [-1 if i == where else 1 for i in range(variable.ndim)])
    old, attrs = variable.attrs["units"], variable.attrs | {"units": unit}
    attrs |= {end: attrs[end] * factor for end in ENDS if end in attrs}
    if "/kg" in old:
        attrs["long_name"] = str(attrs.get("long_name", "")).removesuffix(", per unit of mass")
        attrs |= {"symbol": f"m{attrs['symbol']}"} if "symbol" in attrs and "/kg" not in unit else {}
    elif "symbol" in attrs:  # an angular frequency in turns and back
        symbol = str(attrs["symbol"]).removesuffix(TURN)
        angular = old == "rad/s" or symbol != attrs["symbol"]
        attrs["symbol"] = symbol + (TURN if angular and _turns(unit) else "")
    numbers = variable.values if variable.chunks is None else variable.data
    return variable.copy(data=numbers * factor)._replace(attrs=attrs)


def _pint(why: str) -> Any:
    """Return pint's registry of the application."""
    try:
        import pint
    except ImportError:
        raise InputError(f"{why}; units need pint: pip install 'grazing[units]'") from None
    return pint.get_application_registry()  # type: ignore[no-untyped-call]


def _unit(text: str) -> Any:
    """Return a unit of pint, or raise InputError."""
    registry = _pint(repr(text))
    try:
        if not _UNITS.fullmatch(text):
            raise ValueError
        return registry.parse_units(text)
    except Exception:  # pint has many
        raise InputError(
            f"{shown(text)} is no unit; allowed are those of pint, such as 'mm', 'N s/m' or 'Hz'"
        ) from None


def _read(text: str, said: str) -> tuple[float, Any]:
    """Return the number and the unit of a text, or raise InputError."""
    parts = _QUANTITY.fullmatch(text) if len(text) < 200 else None
    if re.match(r"\s*[-+]?\d+,\d", text):
        raise InputError(f"{said} has a comma; write a decimal point")
    if parts is None:
        raise InputError(f"{said} is no quantity; give a number and its units, such as '1.2 mm'")
    return float(parts[1]), _unit(parts[2]) if parts[2] else _pint(said).Unit("")


def _turns(unit: Any) -> bool:
    """Whether a unit counts turns in a time, as hertz does."""
    return "hertz" in str(_unit(unit) if isinstance(unit, str) else unit)


def _factor(old: Any, new: str, mass: float | None = None) -> float | None:
    """Return by what numbers in one unit are multiplied to be in another; None if they do not match."""
    target = _pint(new).Unit("") if new == "1" else _unit(new)
    try:
        source = _unit(old) if isinstance(old, str) else target._REGISTRY.Unit(str(old))  # of whatever registry
        return _between(source, target, old, new, mass)
    except InputError:
        raise
    except Exception:  # pint has many for units that are no factors of others, such as decibels
        return None


def _between(source: Any, target: Any, old: Any, new: str, mass: float | None) -> float | None:
    """Return :func:`_factor` of units that pint knows."""
    per_mass = mass is not None and "/kg" in str(old)
    if isinstance(old, str) and "/kg" in old and not per_mass and source != target:
        return None
    angles = ["radian" in str((1 * unit).to_root_units().units) for unit in (source, target)]
    turns = [_turns(unit) for unit in (source, target)]
    scale = 1.0
    if any(turns) or new == "rad/s":
        if not all(angle or turn for angle, turn in zip(angles, turns, strict=True)):
            return None
        scale = {(True, False): 2.0 * pi, (False, True): 0.5 / pi}.get((turns[0], turns[1]), 1.0)
    amount = (1.0 * source) * (mass * target._REGISTRY.kg if per_mass and source != target else 1.0)
    return scale * float(amount.to(target).magnitude) if amount.is_compatible_with(target) else None
