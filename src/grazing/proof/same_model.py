"""Whether a certificate is about a given model: walls, objects, laws and values of parameters, one by one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from grazing.late import named
from grazing.outcome import InputError, shown
from grazing.proof.expression import NotAnExpression

if TYPE_CHECKING:
    from grazing.billiard.table import Table
    from grazing.maps.map import Map
    from grazing.oscillator.rig import Rig

#: What certificates say of a model, and not of an orbit of it.
PARTS = ("model", "law", "walls", "objects", "rho", "g", "tilt", "lam", "mu", "l")


def speeds_in(data: Mapping[str, Any]) -> list[float]:
    """Return the velocities before the impacts of a certificate, where it claims them."""
    return [float(low) for low, _high in data.get("claims", {}).get("incoming", [])]


def same_model(data: Mapping[str, Any], model: Any) -> None:
    """Raise InputError unless the data of a right certificate are about a model.

    A parameter that the certificate encloses may have any value, mu one in the interval that it is about.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.proof.same_model import same_model
    >>> model = gz.pinball(d=0.12, V=0.4)
    >>> proof = gz.certify(gz.one_impact_orbits(model, 3)[-1])
    >>> same_model(proof.document["data"], model)
    >>> same_model(proof.document["data"], model.replace(V=0.3))
    Traceback (most recent call last):
    ...
    grazing.outcome.InputError: the certificate is right, but about another model: its law V is 0.4, here it is 0.3
    """
    theirs = dict(_leaves({name: data[name] for name in PARTS if name in data}))
    ours = dict(_leaves(_described(model, data)))
    enclosed = {at for at, text in theirs.items() if text is None}
    if "edge" in data or "turns" in data:
        enclosed.add(("mu",))
    for at in dict.fromkeys([*theirs, *ours]):
        if theirs.get(at) != ours.get(at) and not (at in enclosed and at in ours):
            _refuse(at, *(_value(one.get(at)) for one in (theirs, ours)))
    if "turns" in data:
        low, high, mu = (float.fromhex(x) for x in (data["low"], data["high"], ours[("mu",)]))
        if not (mu > 0.0 and low <= mu <= high):
            _refuse(("mu",), f"{'above' if low == 0.0 else 'at least'} {low!r} and at most {high!r}", repr(mu))


def _refuse(at: tuple[Any, ...], said: Any, here: Any) -> None:
    """Raise InputError for a value, named by where it is."""
    name = " ".join(str(step) for step in (*(one for one in at[:-1] if one not in ("model", "parameters")), at[-1]))
    raise InputError(f"the certificate is right, but about another model: its {name} is {said}, here it is {here}")


def of_rig(model: Rig, speeds: list[float]) -> dict[str, Any]:
    """Return what certificates say of an oscillator, whose laws they hold at these velocities before impacts."""
    from grazing.proof.equations import Equations
    from grazing.proof.report import described

    return described(Equations(model, 0, 1, speeds=speeds), 0)


def of_table(table: Table, speeds: list[float]) -> dict[str, Any]:
    """Return what certificates say of a table."""
    from grazing.proof.table import described_table

    return described_table(table, [-v for v in speeds])


def of_gap_map(P: Map, speeds: list[float]) -> dict[str, Any]:
    """Return what certificates say of a gap map."""
    return {name: float(P.params[name]).hex() for name in ("lam", "mu", "l")}


def _described(model: Any, data: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a certificate would say of a model."""
    place = getattr(getattr(model, "origin", model), "certified_as", "")
    if not place:
        raise InputError(f"model is {shown(model)}; give a gz.Oscillator, a gz.table or a gap map")
    try:
        found = named(place)(model, speeds_in(data))
    except NotAnExpression as error:
        raise InputError(f"the reset law of {shown(model)} is no expression to hold against it: {error}") from None
    return {name: found[name] for name in PARTS if name in found}


def _leaves(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Yield the place of each number and word in data, and what it is; no two have one place, whatever their names.

    What the constant force is called is no difference, nor is the sign of a zero.
    """
    if isinstance(value, Mapping):
        for key, inner in value.items():
            if key != "offset_name":
                yield from _leaves(inner, (*at, key))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            named = inner.get("name") if isinstance(inner, Mapping) else None
            yield from _leaves(inner, (*at, named or i + 1))
    else:
        yield at, (0.0).hex() if value == (-0.0).hex() else value


def _value(text: Any) -> Any:
    """Return a number as it is written in a sentence."""
    if isinstance(text, str) and text.lstrip("-").startswith("0x"):
        return repr(float.fromhex(text))
    return "none" if text is None else text
