"""Certificates from the command line: what is to be proven, where the proofs go, and what they say."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from grazing.cli import output
from grazing.config.build import model_near
from grazing.config.values import DEFAULT, extremes
from grazing.outcome import GrazingError, InputError

Row = dict[str, Any]


def orbit_proofs(found: Iterable[Any]) -> list[Row]:
    """Return a proof of each admissible orbit, or why there is none."""
    from grazing.proof.certify import certify

    proofs = []
    for i, one in enumerate(found):
        of = f"{one.word}, period {one.period}"
        row: Row = {"of": of, "orbit": i, "due": one.admissible, "stem": f"{one.word}-period-{one.period}"}
        if not one.admissible:
            proofs.append({**row, "proven": False, "reason": "it is virtual, no orbit of the map"})
            continue
        try:
            proofs.append({**row, **proof_row(certify(one))})
        except GrazingError as error:
            proofs.append({**row, "proven": False, "reason": str(error)})
    return proofs


def window_proofs(recipe: Mapping[str, Any], result: Any) -> list[Row]:
    """Return a proof of each edge of each window, or why there is none."""
    from grazing.config.orbits import edge_proofs

    [(name, written)] = recipe["vary"].items()
    model = model_near(dict(recipe), name, None if written == DEFAULT else tuple(extremes(written)))
    proofs = []
    for w, side, proof in edge_proofs(model, result):
        row = result.isel(window=w)
        N, kind = int(row["N"]), str(row[f"{side}_type"].values)
        head: Row = {"of": f"N = {N}, {side} edge, {kind}", "window": w, "side": side, "stem": f"N{N}-{side}-{kind}"}
        provable = not (isinstance(proof, str) and proof.startswith("a proof needs"))
        told = {"proven": False, "reason": proof} if isinstance(proof, str) else proof_row(proof)
        proofs.append({**head, "due": provable, **told})
    return proofs


def proof_row(proof: Any) -> Row:
    """Return what a certificate says."""
    return {
        "proven": proof.proven,
        "statement": proof.statement,
        "reason": proof.reason,
        "enclosure": None if proof.value is None else list(proof.value),
        "proof": proof,
    }


def certificates_at(target: Path) -> Path:
    """Return where certificates go, checked before anything is computed."""
    if target.suffix == ".json" and not os.path.isdir(target):
        output.targets([target], (".json",))
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


def proof_lines(tables: Mapping[str, Any]) -> list[str]:
    """Return the proofs in words."""
    said: list[str] = []
    for row in tables.get("proofs", ()):
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
