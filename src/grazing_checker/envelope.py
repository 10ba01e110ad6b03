"""The envelope of a certificate: what it says, what that rests on, and a hash over all of it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from stat import S_ISREG
from typing import Any

from grazing_checker.reading import Rejected, listed, quoted

FORMAT, VERSION = "grazing certificate", 2
#: The fields of an envelope, all of them hashed but the last.
FIELDS = ("format", "version", "kind", "statement", "trusted_base", "data", "inequalities", "sha256")
#: Most bytes of a file that is read, most values in it, most characters of a number: those that need more are texts.
LARGEST, VALUES, DIGITS = 2**24, 2**19, 30


def seal(
    kind: str,
    statement: str,
    trusted_base: Sequence[str],
    data: Mapping[str, Any],
    inequalities: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """Return a certificate as a JSON document.

    Parameters
    ----------
    kind : str
        What it certifies, such as ``"periodic orbit"``.
    statement : str
        One sentence: exactly what is proven.
    trusted_base : sequence of str
        What a reader has to trust, such as the ball arithmetic.
    data : mapping
        What the proof is about and what the checker needs: JSON values only, no NaN; numbers that must be exact as
        text.
    inequalities : sequence of mapping
        What was checked: name and both sides of each.

    Returns
    -------
    dict
        With ``sha256``, the hash of the canonical JSON of everything else. The hash finds accidents; against a forger
        stands the checker, which proves the statement again.

    Examples
    --------
    >>> document = seal("sum", "1 + 1 = 2.", ["addition"], {"terms": ["1", "1"]}, [])
    >>> document["version"], opened(document)["statement"]
    (2, '1 + 1 = 2.')
    """
    body = {
        "format": FORMAT,
        "version": VERSION,
        "kind": kind,
        "statement": statement,
        "trusted_base": list(trusted_base),
        "data": dict(data),
        "inequalities": [dict(one) for one in inequalities],
    }
    return {**body, "sha256": digest_of(body)}


def opened(source: str | Path | Mapping[str, Any]) -> dict[str, Any]:
    """Return the certificate in a file, or a document, whose format, version, fields and hash are right.

    A document is written and read once, so that what is checked is what a file could hold: JSON and nothing else.
    """
    text = _written(source) if isinstance(source, Mapping) else _read(source)
    if sum(map(text.count, ",[{")) > VALUES:  # before it is read: an empty list of three bytes takes 64 in memory
        raise Rejected(f"it has more than {VALUES} values: it is no certificate that this program follows")
    try:
        document = json.loads(
            text,
            object_pairs_hook=_no_repeats,
            parse_constant=_no_constant,
            parse_int=_short(int),
            parse_float=_short(float),
        )
        _check_envelope(document)
    except Rejected:
        raise
    except RecursionError:
        raise Rejected("its lists lie too deep in each other: this is not the JSON of a certificate") from None
    except ValueError as error:
        raise Rejected(f"this is not the JSON of a certificate: {error}; get it again from where it was made") from None
    return dict(document)


def _written(document: Mapping[str, Any]) -> str:
    try:
        return json.dumps(dict(document), allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise Rejected(f"the certificate holds what JSON cannot: {error}; make it anew") from None


def _read(source: str | Path) -> str:
    try:
        with open(os.fspath(source), "rb", opener=_at_once) as file:
            if not S_ISREG(os.fstat(file.fileno()).st_mode):  # a device or a pipe may have no end
                raise OSError("it is a device or a pipe")
            content = file.read(LARGEST + 1) or b""  # nothing yet, of what only looks like a file
        if len(content) > LARGEST:
            raise OSError(f"it is larger than {LARGEST} bytes")
        return content.decode()
    except (OSError, TypeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        plain = str(source) if isinstance(source, Path) else source
        named = repr(plain) if isinstance(plain, (str, bytes)) else f"a value of type {type(source).__name__}"
        raise Rejected(f"no certificate can be read from {named}: {reason}; give its path or the document") from None


def _at_once(path: str, flags: int) -> int:
    """Open a file; nothing waits for a pipe, not even for one that has just taken the place of a file."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _check_envelope(document: Any) -> None:
    """Raise Rejected if this is no certificate, or of another version, or was changed after it was sealed."""
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        got = document.get("format") if isinstance(document, dict) else type(document).__name__
        raise Rejected(f"this is no certificate: its format is {quoted(got)}; allowed is {FORMAT!r}")
    version = document.get("version")
    if type(version) is not int or version != VERSION:
        raise Rejected(
            f"the certificate has version {quoted(version)} of the format, this program reads {VERSION}; prove it "
            "again with this version of grazing: gz.certify(orbit).save(file), or "
            "gz.enclose(orbit, kind, name).save(file)"
        )
    if set(document) != set(FIELDS):
        wrong = sorted(set(document) ^ set(FIELDS))
        raise Rejected(f"the certificate lacks or adds fields: {listed(wrong)}; allowed are {', '.join(FIELDS)}")
    types = {"kind": str, "statement": str, "trusted_base": list, "data": dict, "inequalities": list, "sha256": str}
    for name, kind in types.items():
        if not isinstance(document[name], kind):
            raise Rejected(f"{name} of the certificate is {quoted(document[name])}; allowed is a {kind.__name__}")
    expected = digest_of({name: value for name, value in document.items() if name != "sha256"})
    if document["sha256"] != expected:
        raise Rejected(
            f"the certificate was changed after it was sealed: its contents have the SHA-256 {expected[:12]}..., "
            f"but it says {document['sha256'][:12]}...; get it again from where it was made"
        )


def digest_of(body: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the canonical JSON of a document: sorted keys, no blanks, ASCII."""
    canonical = json.dumps(body, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return sha256(canonical.encode("ascii")).hexdigest()


def _no_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Refuse a key that appears twice: readers differ in which of the values they take."""
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("a key appears twice")
    return found


def _no_constant(name: str) -> Any:
    raise ValueError(f"{name} is not a number of JSON")


def _short(kind: Callable[[str], Any]) -> Callable[[str], Any]:
    """Return what reads a number of JSON if it is short: a long one takes time that grows with its length squared."""

    def read(digits: str) -> Any:
        if len(digits) > DIGITS:
            raise ValueError(f"a number has {len(digits)} characters; at most {DIGITS} are read")
        return kind(digits)

    return read
