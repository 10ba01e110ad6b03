"""Results of a rig as it is measured: positions and velocities upwards, with the stop where it is.

A model has its wall below: with a stop above, its u is -x. Figures show x, and each draws what :func:`measured`
returns; results themselves, files and tables keep the model's u, and tables say which columns count downwards.
"""

from __future__ import annotations

import re
from typing import Any

#: The attribute that says where the stop is, and the one that says so of what :func:`measured` has turned over.
STOP, TURNED = "stop", "stop_shown"
#: Where the stops are of a model with walls: at their own places, and u is x.
WALLS = "walls"
#: What changes its sign where the stop is above: variables, also with a word in front of these names.
SIGNED = ("u", "v", "v_minus", "v_plus", "mean", "wall")
#: Symbols in x, and in x - z where the stop moves with a base.
SYMBOLS = {"u": "x", "v": r"\dot{x}", "v^-": r"\dot{x}^-", "v^+": r"\dot{x}^+"}
RELATIVE = {"u": "x-z", "v": r"\dot{x}-\dot{z}", "v^-": r"(\dot{x}-\dot{z})^-", "v^+": r"(\dot{x}-\dot{z})^+"}
#: Those of a force per unit of mass, or times the mass.
_FORCE = re.compile(r"(m?)(?:d|c_\{(\d+)\})")


def measured(result: Any) -> Any:
    """Return a result, or a list of them, in the rig's own x; whatever is not of a rig is returned as it is.

    Parameters
    ----------
    result : xarray.Dataset, or what has one as ``dataset``, or several of them
        Of a model of :meth:`grazing.Oscillator.from_si`, in any units.

    Returns
    -------
    xarray.Dataset, list of them, or what was given
        Positions and velocities are those of x, upwards; relative to a base that carries the stop. Parameters keep
        their values, and their symbols say what they are of the rig.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.measured import measured
    >>> law = gz.newton(0.7)
    >>> rig = gz.Oscillator.from_si(m=0.8, c=2.4, k=3200, force=2.5, gap=1.2e-3, side="above", frequency=14, reset=law)
    >>> tr = gz.trajectory(rig, (0, 0), until=0.5)
    >>> float(tr.u.min()), float(measured(tr).u.max()), measured(tr).u.attrs["symbol"]
    (-0.0012, 0.0012, 'x')
    """
    if type(result) in (list, tuple):
        return [one if type(one) in (list, tuple) else measured(one) for one in result]
    found = getattr(result, "dataset", result)
    attrs = getattr(found, "attrs", {})
    if not isinstance(attrs, dict) or STOP not in attrs or not hasattr(found, "variables"):
        return result
    above = attrs[STOP] == "above"
    relative = str(attrs.get("base", "moves=spring")).partition(",")[0] != "moves=spring"
    gap = attrs[STOP] != WALLS
    changed = {
        name: _said(str(name), _turned(str(name), variable, found) if above else variable, above, relative, gap)
        for name, variable in found.variables.items()
    }
    changed = {name: variable for name, variable in changed.items() if variable is not found.variables[name]}
    turned = [dim for dim in found.dims if dim in found.coords and _signed(str(dim))] if above else []
    found = found.assign(changed).isel({dim: slice(None, None, -1) for dim in turned})  # in order again
    rest = {key: value for key, value in attrs.items() if key != STOP}
    if above and "box" in rest and "box" not in found:
        del rest["box"]
    return found.drop_attrs(deep=False).assign_attrs(rest | {TURNED: attrs[STOP]})


def sign_of(result: Any) -> float:
    """Return what a state of the model is multiplied by to be drawn over a result that is shown as measured."""
    return -1.0 if result.attrs.get(TURNED) == "above" else 1.0


def downwards(result: Any) -> list[str]:
    """Return the variables of a result whose positive direction is down: positions and velocities where u is -x."""
    above = getattr(result, "attrs", {}).get(STOP) == "above"
    return [str(name) for name in result.variables if above and _signed(str(name))]


def _signed(name: str) -> bool:
    return any(name == one or name.endswith(f"_{one}") for one in SIGNED)


def _turned(name: str, variable: Any, result: Any) -> Any:
    """Return a variable with the other sign, or as it is."""
    import numpy as np

    if variable.dtype.kind != "f":
        return variable
    if "coordinate" in variable.dims:
        signs = np.array([-1.0 if _signed(str(one)) else 1.0 for one in result["coordinate"].values])
        where = variable.dims.index("coordinate")
        data = variable.data * np.reshape(signs, [-1 if i == where else 1 for i in range(variable.ndim)])
        return variable.copy(data=np.sort(data, axis=variable.dims.index("end")) if "end" in variable.dims else data)
    if not _signed(name):
        return variable
    ends = {"low": "high", "high": "low"}
    attrs = {key: -variable.attrs[ends[key]] if key in ends else value for key, value in variable.attrs.items()}
    return variable.copy(data=-variable.data)._replace(attrs=attrs)


def _said(name: str, variable: Any, above: bool, relative: bool, gap: bool) -> Any:
    """Return a variable that says what it is of the rig."""
    symbol, words = variable.attrs.get("symbol"), str(variable.attrs.get("long_name", ""))
    attrs: dict[str, Any] = {}
    if symbol in SYMBOLS:
        attrs["symbol"] = (RELATIVE if relative else SYMBOLS)[symbol]
    of_motion = symbol in SYMBOLS or name.endswith(("amplitude", "velocity")) or (_signed(name) and name != "wall")
    if relative and of_motion:
        of = "position|velocity|speed" if re.search("position|velocity|speed", words) else "^amplitude"
        attrs["long_name"] = re.sub(of, r"relative \g<0>", words)
    if symbol == r"\sigma" and name != "wall" and gap:
        attrs["symbol"] = r"\sigma=-\mathrm{gap}"
    elif symbol is not None and (force := _FORCE.fullmatch(symbol)) and "N" in str(variable.attrs.get("units")):
        sign = "-" if above else ""
        attrs["symbol"] = f"{symbol}={sign}F_{{{force[2] or 0}}}{'' if force[1] else '/m'}"
    if name == "coordinate":
        table = RELATIVE if relative else SYMBOLS
        names = {"v_plus": "v^+", "v_minus": "v^-"}
        attrs["symbols"] = [table.get(names.get(str(one), str(one)), "") for one in variable.values]
    return variable.copy(deep=False)._replace(attrs=variable.attrs | attrs) if attrs else variable


def of_table(result: Any) -> bool:
    """Say whether a result is of a ball on a table: a trajectory, or launches."""
    return "exit" in getattr(result, "data_vars", ())
