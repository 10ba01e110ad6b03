"""How a figure came about: what of a result is stored in a file, and reading it back."""

from __future__ import annotations

import json
import re
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO
from xml.etree import ElementTree

from grazing.outcome import InputError, shown
from grazing.paths import opened, path_of

#: Where each format keeps title, software and provenance.
PNG_FIELDS = {"Title": "title", "Software": "software", "Description": "provenance"}
PDF_FIELDS = {"Title": "title", "Creator": "software", "Subject": "provenance"}
DUBLIN_CORE = "{http://purl.org/dc/elements/1.1/}"
CREATIVE_COMMONS = "{http://creativecommons.org/ns#}"
SVG_FIELDS = {
    DUBLIN_CORE + "title": "title",
    DUBLIN_CORE + "creator": "software",
    DUBLIN_CORE + "description": "provenance",
}
#: Texts beyond this many bytes are not ours, nor is what stands farther from the beginning of an SVG file.
LONGEST = 1 << 24
#: Bytes of a PDF file, and parts of a PNG file, beyond which nothing of ours follows.
LARGEST, PARTS = 1 << 28, 100_000
#: Bytes of an SVG file that are parsed at a time: what is drawn, behind the metadata, is none of our business.
STEP = 1 << 16


def provenance_of(result: Any) -> dict[str, Any]:
    """Return what the file of a figure keeps of the result that was drawn.

    Parameters
    ----------
    result : xarray.Dataset
        Of a study.

    Returns
    -------
    dict
        The attributes ``title`` and ``source``, and all whose names begin with ``grazing_``; JSON among them is taken
        apart, so that it is not written twice over.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.plot.provenance import provenance_of
    >>> diagram = gz.orbit_diagram(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.04, 0.07], starts=2)
    >>> provenance_of(diagram)["grazing_config"]["parameter"]
    'mu'
    """
    attrs = getattr(result, "attrs", {})
    return {
        str(name): _plain(value)
        for name, value in attrs.items()
        if str(name) in ("title", "source") or str(name).startswith("grazing_")
    }


def _plain(value: Any) -> Any:
    """Return JSON text as what it says, NumPy's numbers as Python's, anything else as it is."""
    if isinstance(value, str) and value[:1] in ("{", "["):
        try:
            return json.loads(value)
        except (ValueError, RecursionError):
            return value
    return value.tolist() if hasattr(value, "tolist") else value


def provenance(path: str | Path) -> dict[str, Any]:
    """Return what a figure that :func:`grazing.plot.save` wrote says about itself.

    Parameters
    ----------
    path : str or Path
        A PNG, PDF or SVG file; its content says which, not its name.

    Returns
    -------
    dict
        ``title``, ``software`` and ``provenance``, the mapping that was stored.

    Raises
    ------
    InputError
        For a file that cannot be read, is damaged, or was not written by this package.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import grazing as gz
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = gz.plot.save(gz.plot.figure(), pathlib.Path(folder) / "empty.svg", provenance={"mu": 0.1})
    ...     gz.plot.provenance(path)["provenance"]
    {'mu': 0.1}
    """
    path = path_of(path)
    try:
        with opened(path) as file:
            head = file.read(512) or b""  # nothing yet, of what only looks like a file
            file.seek(0)
            if head.startswith(b"\x89PNG\r\n\x1a\n"):
                fields = _png(file)
            elif head.startswith(b"%PDF-"):
                fields = _pdf(file.read(LARGEST))
            elif re.match(rb"(\xef\xbb\xbf)?\s*<(\?xml|svg|!DOCTYPE svg)", head):
                fields = _svg(file.read(LONGEST))
            else:
                raise InputError(f"{path} is no figure; allowed are PNG, PDF and SVG files that grazing wrote")
    except InputError:
        raise
    except (ValueError, LookupError, zlib.error, struct.error, ElementTree.ParseError) as error:
        raise InputError(f"{path} is damaged ({error}); make the figure again") from None
    if not fields.get("software", "").startswith("grazing") or "provenance" not in fields:
        wrote = (
            f"was written by {shown(fields['software'])}" if fields.get("software") else "does not say what wrote it"
        )
        raise InputError(f"{path} {wrote} and holds no provenance; allowed are figures that grazing wrote")
    try:
        stored = json.loads(fields["provenance"])
        if not isinstance(stored, dict):
            raise ValueError("it is no mapping")
    except (ValueError, RecursionError) as error:
        raise InputError(f"the provenance in {path} is damaged ({error}); make the figure again") from None
    return {"title": fields.get("title", ""), "software": fields["software"], "provenance": stored}


# ---- PNG: chunks of length, type, data and checksum; text stands in tEXt, zTXt and iTXt


def _png(file: BinaryIO) -> dict[str, str]:
    fields: dict[str, str] = {}
    file.seek(8)
    for _ in range(PARTS):
        head = file.read(8)
        if len(head) < 8:
            raise ValueError("it ends before its end")
        length, kind = struct.unpack(">I4s", head)
        if kind == b"IEND":
            return fields
        if kind not in (b"tEXt", b"zTXt", b"iTXt") or length > LONGEST:
            file.seek(length + 4, 1)
            continue
        data, check = file.read(length), file.read(4)
        if len(check) < 4 or struct.unpack(">I", check)[0] != zlib.crc32(kind + data):
            raise ValueError("the checksum of a text does not fit")
        key, text = _text(kind, data)
        if key in PNG_FIELDS:
            fields[PNG_FIELDS[key]] = text
    raise ValueError(f"it has more than {PARTS} parts")


def _text(kind: bytes, data: bytes) -> tuple[str, str]:
    """Return keyword and text of a chunk."""
    key, _, rest = data.partition(b"\0")
    if kind == b"tEXt":
        return key.decode("latin-1"), rest.decode("latin-1")
    if kind == b"zTXt":
        return key.decode("latin-1"), _inflated(rest[1:]).decode("latin-1")
    packed = rest[:1] == b"\1"
    _language, _, rest = rest[2:].partition(b"\0")
    _translated, _, rest = rest.partition(b"\0")
    return key.decode("latin-1"), (_inflated(rest) if packed else rest).decode("utf-8")


def _inflated(data: bytes) -> bytes:
    """Return what was compressed, at most LONGEST bytes of it."""
    return zlib.decompressobj().decompress(data, LONGEST)


# ---- PDF: the trailer names the information dictionary, whose strings are (literal) or <hexadecimal>

_ESCAPES = {b"n": b"\n", b"r": b"\r", b"t": b"\t", b"b": b"\b", b"f": b"\f"}
_INFO = re.compile(rb"/Info\s+(\d{1,10})\s+(\d{1,10})\s+R")
_PIECE = re.compile(rb"\\([0-7]{1,3}|\r\n|[\s\S])|([()])|[^\\()]+")


def _pdf(data: bytes) -> dict[str, str]:
    trailer = data.rfind(b"trailer")
    found = _INFO.search(data, trailer, trailer + LONGEST) if trailer >= 0 else None
    if found is None:  # other programs keep it in a stream: not ours
        return {}
    starts = re.search(rb"(?:^|[\r\n])" + found[1] + rb"\s+" + found[2] + rb"\s+obj\b", data)
    if starts is None:
        raise ValueError("its information dictionary is missing")
    return {PDF_FIELDS[key]: text for key, text in _strings(data, starts.end()) if key in PDF_FIELDS}


def _strings(data: bytes, at: int) -> Iterator[tuple[str, str]]:
    """Yield the keys of a dictionary whose values are strings, with them."""
    key = ""
    token = re.compile(rb"\s*(/[^\s/()<>\[\]]*|\(|<<|>>|<[0-9A-Fa-f\s]*>|[^\s/()<>]+)")
    end = at + LONGEST
    while found := token.match(data, at, end):
        at, piece = found.end(), found[1]
        if piece in (b">>", b"endobj"):
            return
        if piece.startswith(b"/"):
            key = piece[1:].decode("latin-1")
        elif piece == b"(":
            raw, at = _literal(data, at)
            yield key, _decoded(raw)
        elif piece.startswith(b"<") and piece != b"<<":
            digits = re.sub(rb"\s", b"", piece[1:-1])
            yield key, _decoded(bytes.fromhex((digits + b"0" * (len(digits) % 2)).decode()))
    raise ValueError("its information dictionary does not end")


def _literal(data: bytes, at: int) -> tuple[bytes, int]:
    """Return the string that begins after a bracket, and where it ends."""
    out, depth = bytearray(), 1
    end = at + LONGEST
    while found := _PIECE.match(data, at, end):
        at = found.end()
        if found[1] is not None:
            code = found[1]
            if code[:1] in b"01234567":
                out.append(int(code, 8) & 0xFF)
            elif code not in (b"\n", b"\r", b"\r\n"):  # at the end of a line it continues the string
                out += _ESCAPES.get(code, code)
        elif found[2] is not None:
            depth += 1 if found[2] == b"(" else -1
            if not depth:
                return bytes(out), at
            out += found[2]
        else:
            out += found[0]
    raise ValueError("a text does not end")


def _decoded(raw: bytes) -> str:
    return raw[2:].decode("utf-16-be") if raw.startswith(b"\xfe\xff") else raw.decode("latin-1")


# ---- SVG: Dublin Core elements in <metadata>, before anything that is drawn


def _svg(data: bytes) -> dict[str, str]:
    if b"<!ENTITY" in data:  # a few letters can stand for gigabytes of them
        raise ValueError("it declares entities")
    parser: ElementTree.XMLPullParser[Any] = ElementTree.XMLPullParser()
    for first in range(0, len(data), STEP):
        parser.feed(data[first : first + STEP])
        if found := _described(parser):
            return found
    if len(data) < LONGEST:  # else it goes on, and is not ours
        parser.close()
    return {}


def _described(parser: ElementTree.XMLPullParser[Any]) -> dict[str, str]:
    for event in parser.read_events():
        element = list[Any](event)[1]
        if element.tag.endswith("}metadata"):
            # children of the Work only: its creator is an agent, who has a title of its own
            works = element.iter(CREATIVE_COMMONS + "Work")
            found = {SVG_FIELDS.get(child.tag): "".join(child.itertext()).strip() for work in works for child in work}
            return {field: text for field, text in found.items() if field and text}
    return {}
