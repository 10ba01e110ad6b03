"""What is wrong with a configuration: every problem with its path, what was got and what is allowed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from grazing.outcome import InputError, listed, shown
from grazing.parameter import called_here, foreign

Path = tuple[str, ...]
Label = Callable[[Path], str]


#: What of a rig has its own name, and may vary, where it is given in SI units.
VARIED = ("frequency", "gap", "force", "load")
BY_SI = "it has its own name where the rig is given by --si, in a file by [si]; "
#: Problems that a message lists; the rest is counted.
MOST = 20
#: Names of which a message lists all.
NAMES = 40
#: Letters of a line.
LONGEST = 600


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong, and where; a message that takes long to find is found when it is shown."""

    path: Path
    message: str | Callable[[], str]

    def line(self, label: Label) -> str:
        """Return it in one line."""
        where = label(tuple(part if part.isprintable() and part.strip() else shown(part) for part in self.path))
        message = self.message if isinstance(self.message, str) else self.message()
        message = " ".join(message.split())
        if self.path and message.startswith(f"{self.path[-1]} = "):
            said = where + message.removeprefix(self.path[-1])
        else:
            said = f"{where}: {message}" if where else message
        return said if len(said) <= LONGEST else f"{said[:LONGEST]} ..."


def dotted(path: Path) -> str:
    """Return a path as TOML writes it."""
    return ".".join(path)


class Refusal(InputError):
    """A configuration that is refused, with all that is wrong in it."""

    problems: tuple[Problem, ...] = ()


def refusal(problems: Sequence[Problem], source: str, label: Label = dotted) -> Refusal:
    """Return the error that lists all problems, one a line."""
    found = Refusal(*_listed(problems, source, label))
    found.problems = tuple(problems)
    return found


def _listed(problems: Sequence[Problem], source: str, label: Label) -> list[str]:
    lines = list(dict.fromkeys(problem.line(label) for problem in problems[:MOST]))
    more = len(problems) - MOST
    if more > 0:
        lines.append(f"... and {more} more")
    if len(lines) == 1:
        return [f"{source}: {lines[0]}" if source else lines[0]]
    of = f"{source} has" if source else "there are"
    return [f"{of} {len(problems) if more > 0 else len(lines)} errors:", *(f"  {line}" for line in lines)]


def unknown_key(name: str, names: Iterable[str], what: str = "unknown key") -> str:
    """Return what to say of a name that does not exist."""
    known = list(names)
    near = get_close_matches(name[:200], known, n=1)
    hint = f"did you mean {shown(near[0])}? " if near else ""
    if said := called_here(name, known):
        hint = f"here that is {said}; {BY_SI if name in VARIED else ''}"
    what += foreign(name, known)
    return f"{what}; {hint}allowed are {listed(known, NAMES)}" if known else f"{what}; none is allowed here"


def found_by(error: ValidationError, schema: type[BaseModel]) -> list[Problem]:
    """Return what pydantic found, in our words."""
    return [_in_words(item, schema) for item in error.errors(include_url=False)]


def _in_words(item: Any, schema: type[BaseModel]) -> Problem:
    path = tuple(str(part) for part in item["loc"])
    kind, got = item["type"], item["input"]
    if kind == "value_error":
        return Problem(path, str(item["ctx"]["error"]))
    if kind == "extra_forbidden":
        inside = len(path) == 1 and path[0] in _fields(schema, ("settings",))
        what = "unknown key here; it belongs in [settings]" if inside else "unknown key"
        return Problem(path, partial(unknown_key, path[-1], _fields(schema, path[:-1]), what))
    if kind == "missing":
        field = _fields(schema, path[:-1]).get(path[-1])
        return Problem(path, f"missing; give {(field and field.description) or 'it'}")
    if kind == "literal_error":
        return Problem(path, f"{path[-1]} = {shown(got)}; allowed are {item['ctx']['expected'].replace(' or ', ', ')}")
    if kind in ("model_type", "dict_type"):
        if isinstance(got, list) and got and all(isinstance(one, dict) for one in got):
            return Problem(path, f"a list of tables; give one, [{path[-1]}] in place of [[{path[-1]}]]")
        return Problem(path, f"{path[-1]} = {shown(got)}; give a table")
    if kind == "string_type":
        return Problem(path, f"{path[-1]} = {shown(got)}; give a text")
    if kind == "string_unicode":  # as Python reads a name in another encoding than that of the system
        why = (
            "has bytes that are no letters in the encoding of this system; rename the file, or choose a locale of UTF-8"
        )
        return Problem(path, f"{path[-1]} = {shown(got)} {why}")
    return Problem(path, f"{path[-1]} = {shown(got)}: {item['msg']}")


def _fields(schema: type[BaseModel], path: Path) -> dict[str, FieldInfo]:
    """Return the fields of the table at a path, by their keys."""
    for part in path:
        inner = schema.model_fields[part].annotation
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return {}
        schema = inner
    return schema.model_fields
