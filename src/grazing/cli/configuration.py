"""``grazing config``: the schema of configurations, and a look at one."""

from __future__ import annotations

import json as text
import warnings
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

app = App(
    name="config",
    help="Configuration files: their schema, and what one says.",
    help_format="plaintext",
    default_parameter=Parameter(negative=(), json_list=False),
)


@app.command
def schema() -> int:
    """Print the JSON Schema of configurations, for editors and other programs."""
    from grazing.config import json_schema

    print(text.dumps(json_schema(), indent=2))
    return 0


@app.command
def show(
    file: Annotated[Path, Parameter(name="CONFIG", help="TOML file.")],
    /,
    *,
    json: Annotated[bool, Parameter(help="Print it as one JSON object.", show_default=False)] = False,
) -> int:
    """Check a configuration and print it complete, with all that was left out."""
    from grazing.config import load_config, toml_of
    from grazing.config.own import unnamed

    found = load_config(file)
    key = unnamed(found)
    if key is not None:
        warnings.warn(f"{key} = {found[key]!r} was not run: what only that code knows is not checked", stacklevel=2)
    print(text.dumps(found) if json else toml_of(found), end="\n" if json else "")
    return 0
