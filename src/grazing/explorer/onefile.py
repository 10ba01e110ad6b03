"""The explorer as one file, for whoever opens it from a folder or sends it: scripts, style and kernels lie in the page.

A browser gives a page from ``file://`` no modules of JavaScript and no other file. So the modules become functions of
one script, and the kernels and the script of the workers become data, of which ``where.js`` makes addresses.
"""

from __future__ import annotations

import hashlib
import json
import re
from base64 import b64encode
from pathlib import Path

from grazing.explorer.server import FOLDER, files
from grazing.outcome import InputError
from grazing.paths import path_of
from grazing.writing import whole_file

IMPORT = re.compile(r'^import \{([^}]*)\} from "\./([\w.]+)";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:const|function|class|async function) (\w+))", re.MULTILINE)
#: The only export of what a bundler wrote.
LIST = re.compile(r"export\{([^}]*)\};?\s*$")


def bundle(entry: str) -> str:
    """Return a module of the page with all that it imports as one script.

    Parameters
    ----------
    entry : str
        Its name, for example ``"main.js"``.

    Examples
    --------
    >>> from grazing.explorer.onefile import bundle
    >>> "import " in bundle("worker.js").split("/*")[0], "export " in bundle("worker.js").split("/*")[0]
    (False, False)
    """
    order: list[str] = []
    _visit(entry, order, ())
    parts = [f"modules[{json.dumps(name)}] = (() => {{\n{_function(name)}}})();\n" for name in order]
    return "const modules = {};\n" + "".join(parts)


def _text(name: str) -> str:
    return (FOLDER / "page" / name).read_text(encoding="utf-8")


def _visit(name: str, order: list[str], above: tuple[str, ...]) -> None:
    """Put a module behind those that it imports."""
    if name in above:
        raise InputError(f"modules of the page import one another: {' -> '.join((*above, name))}")
    if name in order:
        return
    for _names, needed in IMPORT.findall(_text(name)):
        _visit(needed, order, (*above, name))
    order.append(name)


def _function(name: str) -> str:
    """Return the body of a function that does what a module does, and returns what it exports."""
    text = _text(name)
    listed = LIST.search(text)
    if listed:
        pairs = [each.split(" as ") for each in listed.group(1).split(",")]
        return LIST.sub("", text) + f"\nreturn {{ {', '.join(f'{known[-1]}: {known[0]}' for known in pairs)} }};\n"
    text = IMPORT.sub(lambda found: f"const {{{_renamed(found[1])}}} = modules[{json.dumps(found[2])}];\n", text)
    exported = EXPORT.findall(text)
    return EXPORT.sub("", text) + f"return {{ {', '.join(exported)} }};\n"


def _renamed(names: str) -> str:
    return names.replace(" as ", ": ")


def _digest(text: str) -> str:
    """Return the name by which the page's rules allow what stands in it."""
    return f"'sha256-{b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def page(kernels: Path | None = None) -> str:
    """Return the whole explorer as the text of one page.

    Parameters
    ----------
    kernels : Path, optional
        See :func:`grazing.explorer.server.files`.

    Examples
    --------
    >>> from grazing.explorer.onefile import page
    >>> text = page()
    >>> text.startswith("<!doctype html>"), 'src="main.js"' in text
    (True, False)
    """
    style, script = _text("style.css"), bundle("main.js")
    inside = {
        name.lstrip("/"): b64encode(path.read_bytes()).decode()
        for name, path in files(kernels).items()
        if name.startswith("/kernels/") and "table" not in name  # the pinball table is a page of its own
    }
    inside["page/worker.js"] = b64encode(bundle("worker.js").encode()).decode()
    rules = (
        f"default-src 'none'; script-src {_digest(script)} 'wasm-unsafe-eval'; style-src {_digest(style)}; "
        "worker-src blob:; connect-src blob:; img-src data: blob:"
    )
    data = f'<script type="application/json" id="inside">{json.dumps(inside)}</script>'
    changes = {
        r'\n *<a href="table.html">[^<]*</a>': lambda _found: "",
        r'(http-equiv="Content-Security-Policy" content=")[^"]*': lambda found: found[1] + rules,
        r'<link rel="stylesheet"[^>]*>': lambda _found: f"<style>{style}</style>",
        r'<script type="module"[^>]*></script>': lambda _found: f'{data}\n<script type="module">{script}</script>',
    }
    text = _text("index.html")
    for pattern, change in changes.items():
        text, count = re.subn(pattern, change, text)
        if count != 1:
            raise InputError(f"index.html has {count} places for {pattern}; install grazing again")
    return text


def write_to(file: str | Path, kernels: Path | None = None) -> Path:
    """Write the explorer to one file; return it.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    target = path_of(file)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"cannot write to {file}: {error.strerror or error}; choose a folder that can be made"
        ) from None
    with whole_file(target) as new:
        new.write_text(page(kernels), encoding="utf-8", newline="\n")
    return target
