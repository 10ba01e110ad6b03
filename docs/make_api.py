"""Write docs/api.md from the documentation strings, and the table of studies: python docs/make_api.py [--check]."""

from __future__ import annotations

import enum
import inspect
import re
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import grazing
from grazing.catalogue import studies

PAGE = Path(__file__).with_name("api.md")
#: The page with the table of studies, and between what that stands.
COMMANDS, TABLE = Path(__file__).with_name("command-line.md"), ("<!-- studies -->\n", "<!-- end of studies -->\n")
#: Part of the package -> heading; a part that is not listed comes last under its own name.
HEADINGS = {
    "oscillator": "Models and trajectories",
    "systems": "Systems of your own",
    "billiard": "Pinball tables",
    "signals": "Signals",
    "maps": "Maps",
    "studies": "Studies",
    "plans": "Plans of studies, for sweeps: `gz.plans`",
    "orbits": "Orbits and windows",
    "theory": "Closed forms of the gap map: `gz.theory`",
    "plot": "Figures: `gz.plot`",
    "io": "Files",
    "testing": "Checks for your own maps and models: `gz.testing`",
    "outcome": "Outcomes, trust and errors",
    "citation": "Citation",
}
RESULTS = "Objects that functions return"
ABOUT_RESULTS = "You do not make these yourself."
INTRODUCTION = """\
# API reference

Made from the documentation strings by `python docs/make_api.py`; do not edit. All names below are found on the package,
after `import grazing as gz`. `help(gz.pinball)` shows the same text.
"""
ROLE = re.compile(r":(?:\w+):`~?(?:[\w.]*\.)?(\w+)`")


def public() -> dict[str, dict[str, Any]]:
    """Return heading -> shown name -> object, for everything on the public list, modules opened."""
    groups: dict[str, dict[str, Any]] = {heading: {} for heading in HEADINGS.values()}
    for name in grazing.__all__:
        value = getattr(grazing, name)
        if name.startswith("_"):
            continue
        part = (value.__name__ if isinstance(value, ModuleType) else value.__module__).split(".")[1]
        group = groups.setdefault(HEADINGS.get(part, part), {})
        if isinstance(value, ModuleType):
            listed_here = getattr(value, "__all__", None)  # what a module lists may come from another one
            names = listed_here or [n for n in vars(value) if not n.startswith("_")]
            own = {n: getattr(value, n) for n in names}
            home = "grazing." if listed_here else value.__name__
            group |= {
                f"{name}.{n}": o
                for n, o in own.items()
                if callable(o) and getattr(o, "__module__", "").startswith(home)
            }
        else:
            group[name] = value
    groups[RESULTS] = results(groups)
    return {heading: group for heading, group in groups.items() if group}


def results(groups: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the classes of the package that public functions return without being on the public list."""
    known = {id(value) for group in groups.values() for value in group.values()}
    found: dict[str, Any] = {}
    todo = [value for group in groups.values() for value in group.values()]
    while todo:
        value = todo.pop(0)
        members = [value] if inspect.isfunction(value) else [m for _name, m in methods(value)]
        for function in filter(inspect.isfunction, members):
            for name in re.findall(r"\w+", str(function.__annotations__.get("return", ""))):
                kind = function.__globals__.get(name)
                if inspect.isclass(kind) and kind.__module__.startswith("grazing.") and id(kind) not in known:
                    known.add(id(kind))
                    found[name] = kind
                    todo.append(kind)
    return dict(sorted(found.items()))


def methods(kind: Any) -> Iterator[tuple[str, Any]]:
    """Yield the documented public methods and properties of a class, bases within the package included."""
    if not inspect.isclass(kind) or issubclass(kind, (enum.Enum, BaseException)):
        return
    seen: set[str] = set()
    for base in kind.__mro__:
        if not base.__module__.startswith("grazing."):
            continue
        for name, member in vars(base).items():
            documented = isinstance(member, property) or inspect.isfunction(member)
            if documented and member.__doc__ and name not in seen and (name == "__call__" or not name.startswith("_")):
                seen.add(name)
                yield name, member


def signature(name: str, value: Any) -> str:
    """Return the call as one writes it: names and defaults."""
    try:
        parameters = list(inspect.signature(value).parameters.values())
    except (TypeError, ValueError):
        return name
    parameters = [p.replace(annotation=p.empty) for p in parameters if p.name != "self"]
    shown = str(inspect.Signature(parameters))
    return name + re.sub(r"<factory>|<[^>]*>", "...", shown)


def inline(text: str) -> str:
    """Turn the markup of documentation strings into Markdown."""
    return ROLE.sub(r"`\1`", text).replace("``", "`").replace("::\n", ":\n")


def sections(doc: str) -> Iterator[tuple[str, str]]:
    """Yield (title, body) of a numpydoc string; the title of the beginning is empty."""
    parts = re.split(r"^(\w[\w ]*)\n-{3,}\n", inspect.cleandoc(doc), flags=re.MULTILINE)
    yield "", parts[0].strip()
    for title, body in zip(parts[1::2], parts[2::2], strict=True):
        yield title, body.strip("\n")


def listed(body: str) -> str:
    """Return a numpydoc list of parameters as a Markdown list."""
    lines = []
    for entry in re.split(r"\n(?=\S)", body):
        head, _, rest = entry.partition("\n")
        name, _, kind = head.partition(" : ")
        text = " ".join(inline(textwrap.dedent(rest)).split())
        lines.append(f"- `{name}`" + (f" ({inline(kind)})" if kind else "") + (f": {text}" if text else ""))
    return "\n".join(lines)


def returned(body: str) -> str:
    """Return the section Returns: a list where values are named, else type and text."""
    if re.search(r"^\S.* : ", body, re.MULTILINE):
        return listed(body)
    head, _, rest = body.partition("\n")
    text = " ".join(inline(textwrap.dedent(rest)).split())
    return f"`{head}`" + (f": {text}" if text else "")


def documented(doc: str) -> str:
    """Return a documentation string as Markdown."""
    out = []
    for title, body in sections(doc):
        if title:
            out.append("**Advanced**" if title == "Other Parameters" else f"**{title}**")
        if title in ("Parameters", "Other Parameters", "Raises", "Attributes", "Yields"):
            out.append(listed(body))
        elif title == "Returns":
            out.append(returned(body))
        elif title == "Examples":
            out.append(f"```pycon\n{body.strip()}\n```")
        else:
            out.append(inline(body))
    return "\n\n".join(out)


def entry(name: str, value: Any, made_by_user: bool = True) -> str:
    """Return the Markdown of one object."""
    call = name if inspect.isclass(value) and issubclass(value, (enum.Enum, BaseException)) else signature(name, value)
    prefix = "gz." if made_by_user else ""
    text = f"### {name}\n\n```text\n{prefix}{call}\n```\n\n{documented(value.__doc__ or '')}\n"
    if inspect.isclass(value) and issubclass(value, enum.Enum):
        text += "\nMembers: " + ", ".join(f"`{m.name}` = `{m.value!r}`" for m in value) + "\n"
    for member, function in methods(value):
        title = "`()`" if member == "__call__" else f"`.{member}`"
        if inspect.isfunction(function):
            title = f"`{signature('' if member == '__call__' else '.' + member, function)}`"
        text += f"\n#### {title}\n\n{documented(function.__doc__)}\n"
    return text


def anchors(body: str) -> Iterator[tuple[str, str]]:
    """Yield (heading, anchor) as forges make them: lower case, no punctuation, repeated ones numbered."""
    seen: dict[str, int] = {}
    for heading in re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", body, flags=re.DOTALL), re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        count = seen[slug] = seen.get(slug, -1) + 1
        yield heading, f"{slug}-{count}" if count else slug


def page() -> str:
    """Return the whole page."""
    groups = public()
    parts = []
    for heading, group in groups.items():
        about = f"{ABOUT_RESULTS}\n\n" if heading == RESULTS else ""
        entries = "\n".join(entry(name, value, heading != RESULTS) for name, value in group.items())
        parts.append(f"## {heading}\n\n{about}{entries}")
    body = "\n".join(parts)
    links = dict(anchors(INTRODUCTION + body))
    contents = "\n".join(
        f"- {heading}: " + ", ".join(f"[`{name.split('.')[-1]}`](#{links[name]})" for name in group)
        for heading, group in groups.items()
    )
    return f"{INTRODUCTION}\n{contents}\n\n{body}"


def studies_table() -> str:
    """Return the table of what each study prints, those that print the same in one row."""
    rows: dict[str, list[str]] = {}
    for study in studies().values():
        rows.setdefault(study.prints, []).append(f"`{study.name}`")
    return (
        "\n".join(["| study | prints |", "|---|---|", *(f"| {', '.join(v)} | {k} |" for k, v in rows.items())]) + "\n"
    )


def commands() -> str:
    """Return the page of the command line with the table of studies that it should have."""
    before, _, rest = COMMANDS.read_text(encoding="utf-8").partition(TABLE[0])
    return before + TABLE[0] + studies_table() + TABLE[1] + rest.partition(TABLE[1])[2]


def main(tokens: list[str]) -> int:
    """Write the pages, or with --check say whether they are current."""
    pages = {PAGE: page(), COMMANDS: commands()}
    if tokens == ["--check"]:
        old = [
            file.name for file, text in pages.items() if not file.exists() or file.read_text(encoding="utf-8") != text
        ]
        print(f"docs/{' and '.join(old)} is old: run python docs/make_api.py" if old else "docs/api.md is current")
        return 1 if old else 0
    if tokens:
        print(f"unknown argument {tokens[0]!r}; allowed is --check", file=sys.stderr)
        return 2
    for file, text in pages.items():
        file.write_text(text, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
