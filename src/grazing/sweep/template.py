"""Create a store: all of its arrays at once, in a temporary folder that takes the name of the store when complete."""

from __future__ import annotations

import json
import os
import re
import shutil
import socket
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from itertools import product
from math import ceil
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np

from grazing.outcome import InputError
from grazing.paths import remedy
from grazing.studies.plan import Plan
from grazing.sweep.codec import encode, fill_value
from grazing.sweep.files import Print, fsync_folder, print_of, read_file, write_file
from grazing.sweep.grid import Grid
from grazing.sweep.layout import DONE, LAYOUT, MADE_BY, RECIPE, Layout, Spec, laid_out
from grazing.sweep.letters import stored_attrs
from grazing.sweep.lock import process_exists
from grazing.sweep.made_by import made_by
from grazing.sweep.manifest import TEMPLATE, template_lines
from grazing.sweep.store import ASIDE
from grazing.sweep.writers import wait_for_zarr
from grazing.writing import is_left

_HALF_MADE = re.compile(r"\.(?P<name>.+)-(?P<host>[^-]*)-(?P<pid>\d+)-[0-9a-f]{12}\.partial")
#: How often, and how many seconds apart, a half-made template is removed until it stays away.
PATIENCE, PAUSE = 20, 0.05


def create(path: Path, plan: Plan, grid: Grid, fsync: bool = False) -> None:
    """Create the store of a plan, whole or not at all; nothing happens if another process was faster.

    Raises
    ------
    InputError
        If the folder above is missing or not writable.
    """
    path = Path(os.path.realpath(path))  # a link to an empty folder is as good as the folder
    if not os.path.isdir(path.parent):
        raise InputError(f"there is no folder {path.parent}; make it first")
    half = path.with_name(f".{path.name}-{_host()}-{os.getpid()}-{uuid4().hex[:12]}.partial")
    try:
        half.mkdir()
        write_template(half, plan, grid, fsync)
        (half / ASIDE).mkdir()
        try:
            os.rename(half, path)
            if fsync:
                fsync_folder(path.parent)
        except OSError:
            if not os.path.isfile(path / "zarr.json"):  # else another process made the store in the meantime
                raise
    except OSError as error:
        raise InputError(f"{path} cannot be made: {error.strerror or error}; {remedy(error)}") from error
    finally:
        _remove(half)


def _remove(half: Path) -> None:
    """Remove a half-made template; after a failure Zarr's other writers may still add to it for a moment."""
    if os.path.exists(half):
        wait_for_zarr()
    for _ in range(PATIENCE):
        if not os.path.exists(half):
            return
        shutil.rmtree(half, ignore_errors=True)
        time.sleep(PAUSE)


def _host() -> str:
    return re.sub(r"[^\w.]", "_", socket.gethostname())


def tidy(path: Path) -> None:
    """Remove the half-made templates of processes that are no more."""
    path = Path(os.path.realpath(path))
    with suppress(OSError):  # one went away by itself, or there is no such folder, which is said elsewhere
        for other in path.parent.glob(".*.partial"):
            found = _HALF_MADE.fullmatch(other.name)
            if found is None or found["name"] != path.name:
                continue
            dead = found["host"] == _host() and not process_exists(int(found["pid"]))
            if dead or is_left(other):
                shutil.rmtree(other, ignore_errors=True)


def attrs_of_all(plan: Plan, layout: Layout) -> dict[str, Any]:
    """Return what a store says of the whole, but for its layout and its recipe."""
    attrs = stored_attrs(plan.document, "", {}) | {MADE_BY: json.dumps(made_by(plan), sort_keys=True)}
    extra = sorted(set(layout.coords) - set(plan.axes))
    if extra:
        attrs["coordinates"] = " ".join(extra)  # how xarray tells a coordinate from a variable
    return attrs


def write_template(folder: Path, plan: Plan, grid: Grid, fsync: bool = False) -> None:
    """Write the metadata of all arrays, the numbers of the coordinates, and what the manifest says of both."""
    from grazing.late import zarr

    layout, specs = laid_out(plan, grid)
    attrs = attrs_of_all(plan, layout) | {LAYOUT: layout.text()}
    if plan.recipe is not None:
        attrs[RECIPE] = json.dumps(plan.recipe, sort_keys=True)
    group = zarr.open_group(str(folder), mode="w", zarr_format=3, attributes=attrs)
    for name, spec in specs.items():
        _array(group, name, spec)
    _consolidate(folder, specs)
    coordinates = {}
    for key, content in coordinate_files(specs).items():
        write_file(folder, key, content, fsync)
        coordinates[key] = print_of(content)
    write_file(folder, TEMPLATE, manifest_of(folder, list(specs), coordinates), fsync)
    for file in ["zarr.json", *(f"{name}/zarr.json" for name in specs)] if fsync else ():
        write_file(folder, file, read_file(folder / file), fsync)


def coordinate_files(specs: Mapping[str, Spec]) -> dict[str, bytes]:
    """Return the files of the coordinates."""
    found = {}
    for name, spec in specs.items():
        if spec.data is None:
            continue
        counts = (range(ceil(length / size)) for length, size in zip(spec.shape, spec.chunk, strict=True))
        for place in product(*counts):
            part = tuple(slice(i * size, (i + 1) * size) for i, size in zip(place, spec.chunk, strict=True))
            values = np.asarray(spec.data).astype(spec.dtype, copy=False)[part]
            found["/".join([name, "c", *map(str, place)])] = encode(np.asarray(values), spec.chunk)
    return found


def manifest_of(folder: Path, names: Iterable[str], coordinates: Mapping[str, Print]) -> bytes:
    """Return what the manifest says of the metadata that are in a folder, and of coordinates."""
    files = ["zarr.json", *(f"{name}/zarr.json" for name in names)]
    return template_lines({file: read_file(folder / file).decode() for file in files}, coordinates)


def _array(group: Any, name: str, spec: Spec) -> None:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    # A checksum behind every chunk: a flipped byte becomes an error, never a number. A cell of `done` is one bare byte.
    codecs = None if name == DONE else [ZstdCodec(level=0), Crc32cCodec()]
    group.create_array(
        name,
        shape=spec.shape,
        chunks=spec.chunk,
        dtype=np.dtype(spec.dtype),
        compressors=codecs,
        filters=None,
        fill_value=fill_value(spec.dtype),
        attributes=dict(spec.attrs),
        dimension_names=spec.dims,
    )


def _consolidate(folder: Path, specs: Mapping[str, Spec]) -> None:
    """Repeat the metadata of the arrays in that of the group, in our order, so that opening reads one file."""
    root = json.loads((folder / "zarr.json").read_text(encoding="utf-8"))
    metadata = {name: json.loads((folder / name / "zarr.json").read_text(encoding="utf-8")) for name in specs}
    root["consolidated_metadata"] = {"kind": "inline", "must_understand": False, "metadata": metadata}
    (folder / "zarr.json").write_text(json.dumps(root, indent=2), encoding="utf-8")
