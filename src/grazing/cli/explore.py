"""``grazing explore``: the explorer in a browser."""

from __future__ import annotations

import os
import sys
import webbrowser
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

from cyclopts import Parameter

from grazing.cli import output
from grazing.cli.whole import as_written, whole_number


def explore(
    *,
    port: Annotated[int, Parameter(converter=whole_number, show_default=False, metavar="N")] = 0,
    no_open: Annotated[bool, Parameter(help="Print the address and open no browser.", show_default=False)] = False,
    out: Annotated[
        Path | None,
        Parameter(
            alias="-o",
            converter=as_written,
            help="Write the page to this folder, for any web server, or to one file FILE.html, and end.",
        ),
    ] = None,
    model: Annotated[
        str | None,
        Parameter(help="file.py:name of a gz.Oscillator, for example with a reset law, or a gz.Map.", metavar="NAME"),
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
        Folder for a copy of the page, which a web server serves; a name that ends in .html, for all of it in one file.
    model
        What the page opens on. A reset law or a map of one's own is compiled to WebAssembly where a linker is (lld or
        ziglang), which takes a minute the first time; elsewhere the server computes.
    """
    from grazing.explorer import onefile
    from grazing.explorer.server import copy_to, serve
    from grazing.outcome import InputError

    if out is not None and not str(out).strip():
        raise InputError("--out names no folder; give one, for example --out page, or a file, --out page.html")

    def opened(address: str) -> None:
        print(f"explorer at {address} (Ctrl-C ends it)")
        sys.stdout.flush()
        if not no_open and not in_browser(address):
            print("no browser with windows was found; open the address in one", file=sys.stderr)

    with ExitStack() as stack:
        kernels, calls = None, None
        if model is not None:
            from grazing.explorer.own import prepared

            kernels = Path(stack.enter_context(TemporaryDirectory()))
            calls = prepared(model, kernels, out is not None, lambda text: print(text, file=sys.stderr, flush=True))
        if out is not None:
            to = Path(out)
            whole = to.suffix.lower() == ".html"
            print(output.named([str(onefile.write_to(to, kernels) if whole else copy_to(to, kernels))]))
        else:
            serve(port, opened, kernels, calls)
    return 0


def in_browser(address: str) -> bool:
    """Open an address; whether there was a browser. One in the terminal would take it over, and runs no WebAssembly."""
    try:
        first = webbrowser.get()  # those with windows come before those without
    except webbrowser.Error:
        return False
    if type(first) is webbrowser.GenericBrowser and not os.environ.get("BROWSER"):
        return False
    return webbrowser.open(address)
