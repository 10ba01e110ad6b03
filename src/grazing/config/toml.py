"""TOML files as they are read: unchecked, of bounded size, and nothing in them runs."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path
from typing import Any

from grazing.outcome import InputError
from grazing.paths import opened, path_of

#: Bytes of a configuration: room for a hundred thousand values, where a range says most things in a line.
LARGEST = 2**21
#: Parts of a key: TOML's reader looks at each once for every other, which takes hours for a million of them.
DEEPEST_KEY = 32
#: Keys of one table: a pinball table has 2000 objects at most, and each that is wrong takes time to be refused.
MOST_KEYS = 10_000
#: What TOML consists of. Nothing fails and is tried again elsewhere, so that the time does not grow faster than a text.
_TOKEN = re.compile(
    r'''#[^\n]*+|"""(?:[^"\\]|\\[\s\S]|"(?!""))*+"{0,5}|"(?:[^"\\\n]|\\.)*+"?'''
    r"""|'''(?:[^']|'(?!''))*+'{0,5}|'[^'\n]*+'?|[\w-]++|[ \t]++|[\s\S]"""
)


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return what a TOML file says, unchecked, or raise InputError."""
    source = path_of(path)
    text = read_text(source)
    if _deepest_key(text) > DEEPEST_KEY:
        raise InputError(f"{source} has a key of more than {DEEPEST_KEY} parts; no configuration has such tables")
    try:
        found = tomllib.loads(text)
        most = _most_keys(found)
    except RecursionError:
        raise InputError(f"{source} has too many tables or lists in each other") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{source} is not TOML: {error}") from None
    except ValueError:  # a limit of Python's, which speaks to its programmers
        raise InputError(f"{source} has a number of thousands of digits") from None
    if most > MOST_KEYS:
        raise InputError(f"{source} has a table of {most} keys; allowed are {MOST_KEYS}")
    return found


def _most_keys(table: dict[str, Any]) -> int:
    """Return how many keys the largest of a table and those within it has."""
    return max([len(table), *(_most_keys(one) for one in table.values() if isinstance(one, dict))])


def _deepest_key(text: str) -> int:
    """Return how many dots follow each other between words, outside of comments and texts."""
    if all(line.count(".") <= DEEPEST_KEY for line in text.split("\n")):
        return 0
    most = dots = 0
    for found in _TOKEN.finditer(text):
        token = found[0]
        if token == ".":
            dots += 1
            most = max(most, dots)
        elif not (token[0] in "\"'-_ \t" or token[0].isalnum()):
            dots = 0
    return most


def read_text(source: Path) -> str:
    """Return the text of a regular file of bounded size: a device has no end, and a pipe may never begin."""
    with opened(source) as file:
        data = file.read(LARGEST + 1) or b""  # nothing yet, of what only looks like a file
    if len(data) > LARGEST:
        raise InputError(
            f"{source} is larger than {LARGEST // 2**20} MiB, and no configuration; write values as ranges"
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{source} is no text; give a TOML file in UTF-8") from None
