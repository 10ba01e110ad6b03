"""Certificates from the command line: where they go, and what they say."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from grazing.catalogue.study import Row
from grazing.cli import output
from grazing.outcome import InputError


def certificates_at(target: Path) -> Path:
    """Return where certificates go, checked before anything is computed."""
    if target.suffix == ".json" and not os.path.isdir(target):
        output.targets([target], (".json",), "--save")
        return target
    if target.suffix and not os.path.isdir(target):
        raise InputError(f"--save {target}: give a file that ends in .json, or a folder")
    if os.path.exists(target) and not os.path.isdir(target):
        raise InputError(f"--save {target}: that is a file and does not end in .json; give a file .json, or a folder")
    if not os.path.isdir(target if os.path.exists(target) else target.parent):
        raise InputError(f"--save {target}: there is no folder {target.parent}; make it first")
    if not os.access(target if os.path.exists(target) else target.parent, os.W_OK):
        raise InputError(f"--save {target} cannot be written: permission denied; choose another folder")
    return target


def written_proofs(proofs: Sequence[Row], target: Path | None) -> list[Row]:
    """Write the certificates of what is proven; return the rows with their files."""
    proven = [row for row in proofs if row["proven"]]
    names: list[str] = []
    for row in proven if target is not None else ():
        assert target is not None
        if target.suffix == ".json":
            number = "" if len(proven) == 1 else f"-{len(names) + 1}"
            file = target.with_name(f"{target.stem}{number}.json")
        else:
            made(target)
            again = sum(name.startswith(f"{row['stem']}-") or name == row["stem"] for name in names)
            file = target / f"{row['stem']}{f'-{again + 1}' if again else ''}.json"
        names.append(file.stem)
        row["file"] = str(row["proof"].save(file))
    return [{key: item for key, item in row.items() if key not in ("proof", "stem")} for row in proofs]


def made(folder: Path) -> None:
    """Make a folder, if there is none.

    Raises
    ------
    InputError
        If it cannot be made, as on a full disk.
    """
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder} cannot be made: {error.strerror or error}; choose another one") from error


def proof_lines(found: Mapping[str, Any]) -> list[str]:
    """Return the proofs in words."""
    said: list[str] = []
    for row in found.get("proofs", ()):
        if not row["proven"]:
            said.append(f"{row['of']}: not proven: {row['reason']}")
            continue
        if row.get("enclosure"):
            low, high = row["enclosure"]
            said.append(f"{row['of']}: proven in [{low!r}, {high!r}], of width {high - low:.1e}")
        else:
            said.append(f"{row['of']}: proven")
            said.append(f"  {row['statement']}")
        if row["reason"]:
            said.append(f"  but {row['reason']}")
    return [*said, ""] if said else []
