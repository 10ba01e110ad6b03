"""The manifest: what every file of a store must hold, and who made it.

A folder ``manifest`` beside the arrays::

    template    the metadata of the whole and of every array, word for word, and the coordinates' files
    chunks/12   the record of chunk 12: its files, each with length and SHA-256, and what made them
    seal        when all chunks are there: the hashes of all records

Each has two lines, JSON and the SHA-256 of it. The hash of the template is the identity of the store; every record
names it, and its own number, so that a record fits one place in one store only. The manifest finds accidents and
mix-ups. It is no signature: somebody who writes all of it anew, hashes included, is not found by reading.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grazing.sweep.files import MISFIT, Print, is_name, read_file

MANIFEST = "manifest"
TEMPLATE, CHUNKS, SEAL = f"{MANIFEST}/template", f"{MANIFEST}/chunks", f"{MANIFEST}/seal"
#: Bytes of a seal: its frame, and the hash of a record with its quotes and comma.
LONG_SEAL, HASH = 1000, 67
_HASH = re.compile(r"[0-9a-f]{64}")
#: Files of an array, below its folder.
_METADATA, _NUMBERS = re.compile(r"zarr\.json"), re.compile(r"c(/[0-9]+)*")


@dataclass(frozen=True)
class Template:
    """What a store was begun with: texts of metadata by file, prints of coordinates by file, its identity."""

    metadata: Mapping[str, str]
    coordinates: Mapping[str, Print]
    identity: str


@dataclass(frozen=True)
class Record:
    """What a task has written: prints by file, who made it, and the hash of the record."""

    files: Mapping[str, Print]
    made_by: Mapping[str, str]
    sha256: str


def lines(body: Any) -> bytes:
    """Return JSON and its hash, one line each."""
    text = json.dumps(body, sort_keys=True, separators=(",", ":")).encode()
    return text + b"\n" + hashlib.sha256(text).hexdigest().encode() + b"\n"


def template_lines(metadata: Mapping[str, str], coordinates: Mapping[str, Print]) -> bytes:
    """Return the file of a template."""
    return lines({"metadata": metadata, "coordinates": coordinates})


def record_lines(store: str, number: int, files: Mapping[str, Print], made_by: Mapping[str, str]) -> bytes:
    """Return the file of a record."""
    return lines({"store": store, "chunk": number, "files": files, "made_by": made_by})


def seal_lines(store: str, records: Sequence[str]) -> bytes:
    """Return the file of a seal."""
    return lines({"store": store, "records": records})


def read_template(path: Path) -> Template:
    """Return the template of a store.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, or is not what was written.
    """
    return template_of(read_file(path / TEMPLATE))


def template_of(content: bytes) -> Template:
    """Return the template that :func:`template_lines` wrote.

    Raises
    ------
    ValueError
        If it is not what was written.
    """
    with _ours():
        body, digest = _opened(content)
        metadata = {key: str(text) for key, text in body["metadata"].items()}
        if "zarr.json" not in metadata:
            raise ValueError("it is none of ours")
        coordinates = _prints(body["coordinates"])
        _refuse_elsewhere([key for key in metadata if key != "zarr.json"], _METADATA)
        _refuse_elsewhere(coordinates, _NUMBERS)
        for text in metadata.values():
            text.encode()
        return Template(metadata, coordinates, digest)


def read_record(path: Path, identity: str, number: int) -> Record:
    """Return the record of a chunk.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, is not what was written, or belongs to another place or another store.
    """
    with _ours():
        body, digest = _opened(read_file(path / CHUNKS / str(number)))
        if body["store"] != identity:
            raise ValueError("it belongs to another store")
        if body["chunk"] != number:
            raise ValueError(f"it belongs to chunk {body['chunk']}")
        made_by = {key: str(value) for key, value in body["made_by"].items()}
        return Record(_prints(body["files"]), made_by, digest)


def read_seal(path: Path, identity: str, count: int) -> list[str] | None:
    """Return the hashes of all records of a complete store, None if it is not sealed.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, is not what was written, or belongs to another store.
    """
    try:
        content = read_file(path / SEAL, LONG_SEAL + count * HASH)
    except FileNotFoundError:
        return None
    with _ours():
        body, _digest = _opened(content)
        if body["store"] != identity:
            raise ValueError("it belongs to another store")
        if len(body["records"]) != count:
            raise ValueError("it belongs to another number of chunks")
        return [str(record) for record in body["records"]]


def identities_named(path: Path) -> set[str]:
    """Return the identities that a damaged template and the records of a store name."""
    named = set()
    try:
        named.add(read_file(path / TEMPLATE).rstrip(b"\n").rpartition(b"\n")[2].decode("ascii", "replace"))
    except (OSError, ValueError):
        pass
    for file in (path / CHUNKS).glob("*"):
        try:
            with _ours():
                named.add(_opened(read_file(file))[0]["store"])
        except (OSError, ValueError):
            continue
    return {name for name in named if _HASH.fullmatch(str(name))}


@contextmanager
def _ours() -> Iterator[None]:
    """Say of JSON that fits its hash but not our form that it is none of ours."""
    try:
        yield
    except MISFIT as error:
        if type(error) is ValueError:
            raise
        raise ValueError("it is none of ours") from error


def _opened(content: bytes) -> tuple[dict[str, Any], str]:
    """Return what :func:`lines` wrote, and its hash."""
    text, _, digest = content.rstrip(b"\n").rpartition(b"\n")
    if hashlib.sha256(text).hexdigest().encode() != digest:
        raise ValueError("it does not fit its hash")
    body = json.loads(text)
    if not isinstance(body, dict):
        raise ValueError("it is none of ours")
    return body, digest.decode()


def _refuse_elsewhere(files: Iterable[str], below: re.Pattern[str]) -> None:
    """Raise ValueError for a file that is none of an array: repairing would write it, wherever that is."""
    for file in files:
        name, _, inner = file.partition("/")
        if not is_name(name) or not below.fullmatch(inner):
            raise ValueError(f"it names {file!r}, which is no file of a store")


def _prints(files: Mapping[str, Any]) -> dict[str, Print]:
    return {str(key): (int(length), str(digest)) for key, (length, digest) in files.items()}
