"""``grazing explore``: the explorer in a browser."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def explore(
    *,
    port: int = 0,
    no_open: Annotated[bool, Parameter(help="Print the address and open no browser.", show_default=False)] = False,
    out: Annotated[
        str | None,
        Parameter(alias="-o", help="Write the page to this folder instead, for any web server, and end."),
    ] = None,
) -> int:
    """Explore the pictures in a browser; everything is computed there, by the same kernels.

    Parameters
    ----------
    port
        Port on this machine; any free one if not given.
    no_open
        Open no browser.
    out
        Folder for a copy of the page.
    """
    from grazing.explorer.server import copy_to, serve

    if out is not None:
        print(copy_to(Path(out)))
        return 0

    def opened(address: str) -> None:
        print(f"explorer at {address} (Ctrl-C ends it)")
        sys.stdout.flush()
        if not no_open:
            webbrowser.open(address)

    serve(port, opened)
    return 0
