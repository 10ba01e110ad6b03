"""The parameters that a configuration may set: names, meanings, ranges and defaults, read from the models and maps.

Meaning and range come from :func:`grazing.oscillator.model.describe_parameter` and its like for the gap map, a
default from the signature of the function that has it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import inf
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema, create_model

from grazing.config import values
from grazing.maps.gap import PARAMETERS as GAP_MAP
from grazing.oscillator import reset as laws
from grazing.oscillator.forcing import MOST_HARMONICS
from grazing.oscillator.model import pinball
from grazing.oscillator.parameters import describe_parameter
from grazing.oscillator.reset import Reset
from grazing.outcome import InputError
from grazing.parameter import Parameter

LAWS: dict[str, Callable[..., Reset]] = {"active": laws.active, "newton": laws.newton, "triggered": laws.triggered}


class Table(BaseModel):
    """A table of a configuration: its keys and no others."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def optional(check: Callable[[Any], Any], schema: Mapping[str, Any]) -> Any:
    """Return the type of a key that may be left out, from the check of its value and its JSON Schema."""
    checked = BeforeValidator(lambda value: None if value is None else check(value))
    return Annotated[Any, checked, WithJsonSchema(dict(schema))]


def described(name: str) -> Parameter:
    """Return what is known of a parameter of any of our maps; of ``A.r`` as of r."""
    known = GAP_MAP[name] if name in GAP_MAP else describe_parameter(name.rpartition(".")[2])
    return replace(known, name=name) if "." in name else known


def law_names(law: str) -> list[str]:
    """Return the parameters of a reset law."""
    return list(inspect.signature(LAWS[law]).parameters)


def defaults_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the defaults in a function's signature."""
    known = inspect.signature(function).parameters
    return {name: item.default for name, item in known.items() if item.default is not inspect.Parameter.empty}


#: Parameters of the flight, the laws and the section, then those of the gap map, in the order they are shown.
FLIGHT = [name for name in inspect.signature(pinball).parameters if name not in law_names("active")]
OF_LAWS = list(dict.fromkeys(name for law in LAWS for name in law_names(law)))
GAP = list(GAP_MAP)
#: In place of k, where it is named: of either sign.
STIFFNESS = "stiffness"
AMPLITUDES = ("cos", "sin")


def _parameter_field(name: str) -> Any:
    known = described(name)
    schema: dict[str, Any] = {"type": "number"}
    if known.low > -inf:
        schema["exclusiveMinimum" if known.open == "low" else "minimum"] = known.low
    if known.high < inf:
        schema["maximum"] = known.high
    kind = optional(lambda value: known.check(values.number(value, name, f"allowed is {known.allowed}")), schema)
    usual = defaults_of(pinball).get(name)  # what the models take if nothing is said; for us that is None
    extra = None if usual is None else {"default": usual}
    return kind, Field(default=None, description=meaning(name), json_schema_extra=extra)


def spring_in(config: Mapping[str, Any]) -> str:
    """Return the name of the spring's parameter in a configuration: k, unless it names a stiffness."""
    named = any(STIFFNESS in (config.get(key) or ()) for key in ("parameters", "vary"))
    return STIFFNESS if named else "k"


def meaning(name: str) -> str:
    """Return the meaning and range of a parameter in a line of help."""
    known = described(name)
    unlimited = known.low == -inf and known.high == inf
    return known.meaning if unlimited else f"{known.meaning}; {known.allowed}"


def _amplitudes_field(name: str) -> Any:
    def check(value: Any) -> list[float]:
        found = values.numbers(value, name, 0)
        if len(found) > MOST_HARMONICS:
            raise InputError(f"{name} has {len(found)} amplitudes; allowed are at most {MOST_HARMONICS}")
        return found

    word = describe_parameter(f"{name}1").meaning.partition(" ")[0]
    kind = optional(check, {"type": "array", "items": {"type": "number"}})
    return kind, Field(default=None, description=f"{word} amplitudes of harmonics 1, 2, ... of the forcing")


def parameter_names() -> list[str]:
    """Return the names of all parameters of our own maps."""
    return [*FLIGHT, STIFFNESS, *AMPLITUDES, *OF_LAWS, "phase", *GAP]


class OpenTable(Table):
    """A table with further names: the parameters of a user's own map or reset law."""

    model_config = ConfigDict(extra="allow", frozen=True)


def _parameter_fields() -> dict[str, Any]:
    return {
        name: _amplitudes_field(name) if name in AMPLITUDES else _parameter_field(name) for name in parameter_names()
    }


Parameters: type[OpenTable] = create_model(
    "Parameters",
    __base__=OpenTable,
    __doc__="Values of the parameters that do not vary; those left out are the pinball's if nothing else is named, "
    "no law but its own, cos, sin or sigma. Else only t0, sigma, sin and phase may be left out: they are 0.",
    **_parameter_fields(),
)
