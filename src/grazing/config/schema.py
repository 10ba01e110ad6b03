"""The schema: what a configuration may say. Files, options, help and JSON Schema are all made from it."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema, create_model

from grazing.catalogue import studies
from grazing.config import values
from grazing.config.parameters import LAWS, Parameters, Table, optional
from grazing.config.settings import PAIR, STATE, settings_of
from grazing.config.si import SCHEMA
from grazing.config.walls import SAYS, Walls
from grazing.maps.discontinuity import ORDERS
from grazing.oscillator.parameters import MASS
from grazing.oscillator.si import SIDES, base_of
from grazing.outcome import InputError, shown
from grazing.units import checked_units

MAPS = {
    "stroboscopic": "the state (u, v) once per period of the forcing",
    "impact": "from one impact to the next, (tau, v_plus)",
    "discontinuity": "the local map near a graze, (2.4) and (2.5) of the paper",
    "gap": "the one-dimensional map with a gap, (2.6) of the paper",
    "normal-form": "the gap map that an oscillator has near its graze",
}

#: Maps of a pinball table.
TABLE_MAPS = {
    "collision": "of a table, from impact to impact",
    "launch": "of a table, a launch to its way out",
    "stroboscopic": "of a table, the ball once per period of its flips, or every so much time: period",
}


_RANGES = {
    "type": "object",
    "additionalProperties": {"anyOf": [{"type": "string", "pattern": "^[^:]+:[^:]+:[0-9]+(:log)?$"}, STATE]},
}


_BOUNDS = {
    "type": "object",
    "additionalProperties": {"anyOf": [{"type": "string", "pattern": "^[^:]+:[^:]+$|^default$"}, PAIR]},
}
#: What varies, by the form in which it is written.
VARIED: dict[str, tuple[Any, str]] = {
    "values": (_RANGES, f"what varies: {values.RANGE_FORM}; the first name is the horizontal axis"),
    "bounds": (_BOUNDS, "what varies: low:high, or default where the study chooses"),
}


#: The order of no discontinuity map: the graph of the stroboscopic map alone.
ALONE = "none"


Curves = optional(
    lambda value: values.curves(value, "curves"),
    {"type": "array", "items": {"anyOf": [{"type": "integer", "minimum": 1}, {"type": "string"}]}},
)
Mass = optional(
    lambda value: MASS.check(values.number(value, "mass", f"allowed is {MASS.allowed}")),
    {"type": "number", "exclusiveMinimum": 0.0},
)
Moved = optional(lambda value: base_of(value).alone.text, {"type": "string"})
Units = optional(
    lambda value: ",".join(checked_units(value, "units")),
    {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]},
)
#: Keys of the configurations of some studies alone: what the figure shows beside the result.
BESIDE: dict[str, tuple[Any, str]] = {
    "curves": (
        Curves,
        "drawn on top: the exact boundary curves of periods, where theory knows them (2,3,5 or 2:7), or a stored "
        "branch or locus",
    ),
    "coordinate": (str | None, "coordinate whose images are drawn; the one that varies if not given"),
}


def _in_order(value: Any) -> Any:
    """Take pairs for a table: recipes keep the order of what varies so, which JSON with sorted keys would lose."""
    if isinstance(value, list) and all(isinstance(item, (list, tuple)) and len(item) == 2 for item in value):
        table = {str(name): written for name, written in value}
        if len(table) < len(value):
            raise InputError(f"{shown(value)}: a name is given twice")
        return table
    return value


class Config(Table):
    """What is computed: a study of a map, at these parameter values."""

    study: Literal[tuple(studies())] = Field(description="what is computed")  # type: ignore[valid-type]
    map: Annotated[str, WithJsonSchema({"type": "string", "examples": [*MAPS, "file.py:name"]})] = Field(
        default="stroboscopic",
        description=f"{', '.join(MAPS)}, or file.py:name for a gz.Map of your own; of a table {', '.join(TABLE_MAPS)}",
    )
    order: Literal[ORDERS] | None = Field(default=None, description="terms of the discontinuity map")  # type: ignore[valid-type]
    unfold: str | None = Field(default=None, description="parameter that leads the normal form to its graze")
    model: str | None = Field(default=None, description="file.py:name for a gz.Oscillator or gz.System of your own")
    table: str | None = Field(
        default=None,
        description="a pinball table, not an oscillator: classic, galton, one_bumper, three_discs, or a TOML file",
    )
    law: Literal[tuple(LAWS)] | None = Field(default=None, description="reset law")  # type: ignore[valid-type]
    walls: Walls = Field(default=None, description=SAYS)  # type: ignore[valid-type]
    mass: Mass = Field(default=None, description="mass in kg: the numbers are in SI units, and results carry units")  # type: ignore[valid-type]
    base: Moved = Field(  # type: ignore[valid-type]
        default=None,
        description="a base whose amplitude a sweep keeps: moves=both,displacement=0.0003 or acceleration=5, with the "
        "sign of u, blanks between harmonics; cos and sin are what forces the mass beside it",
    )
    stop: Literal[tuple(SIDES)] | None = Field(  # type: ignore[valid-type]
        default=None, description="side of a rig's stop: figures show its x, upwards, which is -u for one above"
    )
    units: Units = Field(  # type: ignore[valid-type]
        default=None, description="units of what is printed, drawn and written, for a model in SI units: mm,Hz,N s"
    )
    si: Annotated[None, WithJsonSchema(SCHEMA)] = Field(
        default=None,
        description="mass, damping, stiffness and stop in SI units or with their own, in place of parameters: "
        "m=0.8,c=2.4,k=3200,force=2.5,gap=1.2mm,side=below,frequency=14Hz; then frequency, force, load, gap, c and k "
        "may vary, and be given as NAME=VALUE; the stop is above unless side, or --stop, says below",
    )
    parameters: Parameters = Field(  # type: ignore[valid-type]
        default_factory=Parameters, description=str(Parameters.__doc__)
    )
    vary: Annotated[dict[str, Any], BeforeValidator(_in_order), WithJsonSchema(_RANGES)] = Field(
        default_factory=dict, description=VARIED["values"][1]
    )
    settings: Any = Field(default_factory=dict, description="how it is computed")


@cache
def config_of(study: str) -> type[Config]:
    """Return the schema of one study's configuration."""
    known, table = studies()[study], settings_of(study)
    kind: Any = Literal[study]
    extra: dict[str, Any] = {
        key: (BESIDE[key][0], Field(default=None, description=BESIDE[key][1])) for key in known.beside
    }
    if known.has("order"):
        says = f"terms of the discontinuity map; {ALONE} leaves it out beside the stroboscopic map"
        extra["order"] = (Literal[(*ORDERS, ALONE)] | None, Field(default=None, description=says))
    if known.form != "values":
        form, what = VARIED[known.form]
        varied = Annotated[dict[str, Any], BeforeValidator(_in_order), WithJsonSchema(form)]
        extra["vary"] = (varied, Field(default_factory=dict, description=what))
    return create_model(
        f"{study.capitalize()}Config",
        __base__=Config,
        __doc__=known.says,
        study=(kind, Field(description=known.says)),
        settings=(table, Field(default_factory=dict, validate_default=True, description=str(table.__doc__))),
        **extra,
    )


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a configuration, for editors and other programs."""
    from pydantic import TypeAdapter

    kinds: Any = None
    for study in studies():
        kinds = config_of(study) if kinds is None else kinds | config_of(study)
    schema = TypeAdapter(Annotated[kinds, Field(discriminator="study")]).json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "grazing configuration", **schema}
