"""``grazing info``: what a file is, where it comes from, and the command that makes it again."""

from __future__ import annotations

import json as text
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from grazing.cli import output
from grazing.outcome import GrazingError, InputError, printable, quoted_file

#: Letters of a command beyond which a file says it better.
LONGEST = 4000


def info(
    file: Annotated[
        Path,
        Parameter(
            name="FILE",
            help="Figure (png, pdf, svg), result (nc), store (zarr), certificate (json) or configuration (toml).",
        ),
    ],
    /,
    *,
    config: Annotated[
        bool, Parameter(help="Print the configuration as TOML instead, complete.", show_default=False)
    ] = False,
    json: Annotated[bool, Parameter(help="Print all that is known as one JSON object.", show_default=False)] = False,
) -> int:
    """Tell what a file is, where it comes from, and the command that makes it again."""
    found = described(file)
    if config:
        if found["recipe"] is None:
            raise InputError(f"{file} cannot be made again by a command: {found['why_not']}")
        from grazing.config import toml_of

        print(toml_of(found["recipe"]), end="")
        return 0
    from grazing.kernel.wide import plain

    found |= {"plain_forms": plain() or None}
    print(text.dumps(found, default=str) if json else "\n".join(lines(found)))
    return 0


def described(path: Path) -> dict[str, Any]:
    """Return what is known of a file.

    Raises
    ------
    InputError
        If it is missing, or nothing of ours.
    """
    try:
        os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"there is no file {path}") from None
    except OSError as error:  # in a folder that others keep closed, links in a circle
        raise InputError(f"{path} cannot be read: {error.strerror}") from None
    kind = path.suffix.lower()
    if kind in (".csv", ".parquet"):
        raise InputError(f"{path} is a table, which says nothing of where it comes from; ask a .nc of the same result")
    found: dict[str, Any] = {"file": str(path)}
    if kind == ".toml":
        from grazing.config import load_config

        found |= {"kind": "configuration"}
        return found | again({"grazing_recipe": load_config(path)}, {}, ())
    if kind == ".json":
        return found | certificate(path)
    if kind in output.FIGURES:
        from grazing.plot import provenance

        stored = provenance(path)
        attrs = stored["provenance"]
        found |= {"kind": "figure", "title": stored["title"], "source": told(attrs, "source") or stored["software"]}
        found |= {"config_sha256": told(attrs, "grazing_config_sha256"), "versions": versions(attrs)}
        return found | again(attrs, {}, (str(path),))
    from grazing.cli.stored import axes_of, loaded

    result = loaded(str(path))
    found |= {"kind": "store" if os.path.isdir(path) else "result", "title": told(result.attrs, "title")}
    found |= {"source": told(result.attrs, "source"), "created": told(result.encoding, "date_created")}
    found |= {"config_sha256": told(result.attrs, "grazing_config_sha256")}
    found |= {"versions": versions(result.attrs)}
    found |= {"sizes": {str(name): size for name, size in result.sizes.items()}}
    found |= {"variables": {str(name): str(item.attrs.get("long_name", "")) for name, item in result.data_vars.items()}}
    if os.path.isdir(path):
        from grazing.sweep import status

        known = status(path)
        found |= {"complete": known.complete, "progress": f"{known.cells_done} of {known.cells} cells"}
        found |= {"bound": known.bound, "mixture": known.mixture}
    return found | again(result.attrs, axes_of(result), (str(path),))


def told(attrs: Mapping[str, Any], name: str) -> str | None:
    """Return the text of an attribute; None for what is no text."""
    return attrs[name] if isinstance(attrs.get(name), str) else None


def versions(attrs: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the versions that a file names, if it does."""
    said = attrs.get("grazing_versions")
    try:
        said = text.loads(said) if isinstance(said, str) else said
    except (ValueError, RecursionError):
        return None
    return said if isinstance(said, dict) else None


def certificate(path: Path) -> dict[str, Any]:
    """Return what a certificate says of itself; whether it proves that is for the checker to say."""
    from grazing.proof.check import opened_certificate

    document = opened_certificate(path)
    why = f"a certificate is checked, not made again: grazing orbit check {quoted_file(str(path))}"
    return {
        "kind": "certificate, not checked here",
        "title": document["statement"],
        "recipe": None,
        "command": None,
        "why_not": why,
    }


def again(attrs: Mapping[str, Any], axes: Mapping[str, Any], out: tuple[str, ...]) -> dict[str, Any]:
    """Return the recipe and the command that make a thing again, or why there are none."""
    from grazing.config import command_of, recipe_of

    try:
        recipe = recipe_of(attrs, axes)
    except GrazingError as error:
        return {"recipe": None, "command": None, "why_not": str(error)}
    command = command_of(recipe, out)
    if len(command) > LONGEST:
        return {"recipe": recipe, "command": None, "why_not": "its values make a long command; --config prints a file"}
    return {"recipe": recipe, "command": command, "why_not": None}


def lines(found: Mapping[str, Any]) -> list[str]:
    """Return what is known in words."""
    versions = ", ".join(
        f"{name} {number}" for name, number in (found.get("versions") or {}).items() if name != "grazing"
    )
    title = f": {found['title']}" if found.get("title") else ""
    said = [f"{found['file']}: {found['kind']}{title}"]
    if found.get("source"):
        said.append(f"made by:   {found['source']}{f' ({versions})' if versions else ''}")
    if found.get("created"):
        said.append(f"saved:     {found['created']}")
    if "progress" in found:
        said.append(f"complete:  {'yes' if found['complete'] else 'no'}, {found['progress']}")
    if found.get("bound") is False:
        said.append("unbound:   made by version 0.1, without a manifest that says what its files must hold")
    if found.get("mixture"):
        said.append(f"mixture:   {found['mixture']}")
    if found.get("sizes"):
        said.append(f"sizes:     {', '.join(f'{name} {size}' for name, size in found['sizes'].items())}")
    if found.get("variables"):
        said += ["variables: " + ", ".join(found["variables"])]
    if found.get("config_sha256"):
        said.append(f"config:    sha256 {str(found['config_sha256'])[:16]}")
    if found.get("plain_forms"):
        said.append(f"here:      kernels are slower than they could be: {found['plain_forms']}")
    again = found["command"] or f"no command: {found['why_not']}"
    return [printable(line, newlines=False) for line in (*said, f"again:     {again}")]
