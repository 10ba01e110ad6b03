"""``grazing table``: what stands on a pinball table, and its figure."""

from __future__ import annotations

import json as text
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from grazing.cli import output
from grazing.outcome import InputError


def table(
    name: Annotated[str, Parameter(name="TABLE", help="classic, galton, one_bumper, three_discs, or a TOML file.")],
    /,
    *given: Annotated[str, Parameter(name="NAME=VALUE", help="Parameters: bumper1.V=3.", show=True)],
    out: Annotated[
        list[Path] | None,
        Parameter(name=("--out", "-o"), help="Figure to write, png, pdf or svg; may be repeated.", metavar="FILE"),
    ] = None,
    json: Annotated[bool, Parameter(help="Print a summary as one JSON object.", show_default=False)] = False,
) -> int:
    """Tell what stands on a pinball table, and draw it.

    Studies of it have --table: 'grazing trajectory --table classic x=5.275 y=0.7 vx=0 vy=17 -o shot.gif' plays a ball,
    'launches' and 'basins' say where balls leave and when, 'diagram' and 'lyapunov' are of the map from hit to hit.
    """
    from grazing.config.tables import read_table
    from grazing.parameter import real

    found, files, changes = read_table(name), output.targets(out, output.FIGURES), {}
    for token in given:
        parameter, equals, value = token.partition("=")
        if not equals or not parameter:
            raise InputError(f"{token!r} is not NAME=VALUE, such as {next(iter(found.params))}=0.1")
        if parameter not in found.params:
            from grazing.config.problems import unknown_key

            raise InputError(f"{parameter}: {unknown_key(parameter, list(found.params), 'unknown parameter')}")
        if parameter in changes:
            raise InputError(f"{token!r}: {parameter} is given twice")
        try:
            changes[parameter] = real(float(value), parameter, "give a finite number")
        except ValueError:
            raise InputError(f"{token!r}: {value!r} is no number") from None
    found = found.replace(**changes)
    written: list[str] = []
    if files:
        from grazing import plot

        drawn = plot.table(found)
        written = [
            str(plot.save(drawn, file, f"table {name}", {"grazing_table": name, "grazing_changed": changes}))
            for file in files
        ]
    things: list[dict[str, Any]] = [
        {"name": one.name, "kind": one.kind, "law": "" if one.law is None else repr(one.law)} for one in found.objects
    ]
    if json:
        print(text.dumps({"table": name, "objects": things, "params": dict(found.params), "files": written}))
        return 0
    own = ", ".join(f"{key} = {found.params[key]:g}" for key in ("rho", "g", "tilt"))
    print(f"table {name}: {own}")
    wide = max(len(one["name"]) for one in things)
    for one in things:
        print(f"{one['name']:{wide}}  {one['kind']:8} {one['law']}".rstrip())
    if found.plunger is not None:
        shot = found.plunger
        print(f"launched at ({shot.x:g}, {shot.y:g}), angle {shot.angle:g}, speeds {shot.slow:g} to {shot.fast:g}")
    if written:
        print(f"written: {output.named(written)}")
    return 0
