"""Results of a rig as they are printed: with the parameters that a rig has, gap and frequency."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from grazing.measured import STOP, WALLS
from grazing.outcome import InputError
from grazing.units import TURN

#: The rig's own names of parameters of the model.
NAMES = {"omega": "frequency"}
#: The attribute that holds those that a result no longer has, each with the name in its place.
GIVEN = "given"
#: Attributes that hold a range of the parameter.
RANGES = ("span", "bounds")


def as_given(result: Any, units: Sequence[str] = (), gaps: Mapping[str, tuple[str, float]] | None = None) -> Any:
    """Return a result of a rig whose sigma has become gap = -sigma, and whose omega has become frequency, in Hz.

    Between walls a position becomes a gap where that is what was asked for.

    Parameters
    ----------
    result : xarray.Dataset
        Of a study; one that is not of a rig is returned as it is, and so is one with derivatives in its parameters.
    units : sequence of str
        The result is in them already. With rad/s among them omega stays.
    gaps : mapping of str to (str, float), optional
        Between walls: of each position that was asked for as a gap, that name and the sign of the position.
    """
    if STOP not in result.attrs or "derivative" in result:
        return result
    omegas = _of(result, "omega")
    if omegas and "rad/s" not in units:
        result = _named(_in_turns(result, omegas), "omega", NAMES["omega"])
    for old, (new, sign) in ((gaps or {}) if result.attrs[STOP] == WALLS else {"sigma": ("gap", -1.0)}).items():
        sigmas = _of(result, old)
        if sigmas:
            result = _named(_turned(result, sigmas) if sign < 0.0 else result, old, new)
    return result


def given_names(result: Any, recipe: Any) -> dict[str, Any]:
    """Return a recipe that calls what varies as a result of :func:`as_given` does."""
    new = result.attrs.get(GIVEN, {})
    return {**recipe, "vary": {new.get(name, name): values for name, values in recipe["vary"].items()}}


def _of(result: Any, name: str) -> list[str]:
    """Return the variables that hold values of a parameter; a wall over time is none."""
    front, _dot, last = name.rpartition(".")
    symbol = f"\\{last}^{{{front}}}" if front else f"\\{last}"
    symbols = {str(name): str(one.attrs.get("symbol", "")) for name, one in result.variables.items()}
    found = [one for one, said in symbols.items() if said.removesuffix(TURN).partition("=")[0] == symbol]
    about = [str(key) for key in ("before", "after") if key in result and name in result.dims]
    return [one for one in [*found, *about] if one != "wall"]


def _in_turns(result: Any, omegas: Sequence[str]) -> Any:
    """Return a result with frequencies in Hz; as it is, if they are in another unit already or pint is missing."""
    from grazing.units import in_units

    if all(result[name].attrs.get("units") != "rad/s" for name in omegas):
        return result
    try:
        return in_units(result, "Hz")
    except InputError:
        return result


def _turned(result: Any, sigmas: Sequence[str]) -> Any:
    """Return a result with the other sign of some variables; what was the low end of a range is the high one."""
    turned = result.assign({name: one.copy(data=-one.data) for name in sigmas for one in [result.variables[name]]})
    fronts = {name.removesuffix("low") for name in sigmas if name.endswith("low")}
    ends = [str(name) for name in result.variables if any(str(name).startswith(f"{one}low") for one in fronts)]
    pairs = [(low, high) for low in ends if (high := low.replace("low", "high")) in result]
    swapped = {a: turned.variables[b] for low, high in pairs for a, b in ((low, high), (high, low))}
    ranges = {
        key: [-float(end) for end in result.attrs[key]][::-1]
        for key in RANGES
        if key in result.attrs and not isinstance(result.attrs[key], str)
    }
    return turned.assign(swapped).assign_attrs(ranges)


def _named(result: Any, old: str, new: str) -> Any:
    """Return a result that calls a parameter as the rig does, in names, titles and what lists its names."""
    if old == "omega" and any(result[name].attrs.get("units") == "rad/s" for name in _of(result, old)):
        return result
    names = {
        name: f"{str(name).removesuffix(old)}{new}"
        for name in [*result.variables, *result.dims]
        if str(name) == old or str(name).endswith(f"_{old}")
    }
    attrs = dict(result.attrs)
    for key in ("parameter", "locus_parameters"):
        if key in attrs:
            attrs[key] = str(attrs[key]).replace(old, new)
    title = str(attrs.get("title", ""))
    attrs["title"] = title.replace(f" in {old}", f" in {new}").replace(f" and {old}", f" and {new}")
    return result.rename(names).assign_attrs(attrs | {GIVEN: {**attrs.get(GIVEN, {}), old: new}})
