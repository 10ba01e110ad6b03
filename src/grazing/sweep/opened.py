"""Opening a store that exists: what its files say is checked before anything is read."""

from __future__ import annotations

import hashlib
import json
import os
from math import ceil, prod
from pathlib import Path
from typing import Any

from grazing.outcome import InputError, in_one_line
from grazing.paths import remedy
from grazing.sweep.codec import CODECS, type_named
from grazing.sweep.files import MISFIT, read_file
from grazing.sweep.layout import DONE, LAYOUT, MADE_BY, MOST, RECIPE, UNBOUND, Layout, Spec
from grazing.sweep.letters import TEXT
from grazing.sweep.manifest import MANIFEST, SEAL, Template, read_seal, read_template
from grazing.sweep.store import ASIDE, Store


def exists(path: Path) -> bool:
    """Whether a store is there; an empty folder is none, and anything else is refused.

    Raises
    ------
    InputError
        For a file, a folder that holds something else, or one that cannot be read.
    """
    try:
        if (path / "zarr.json").is_file():
            return True
        if not path.exists() and not path.is_symlink():
            return False
        if not path.is_dir():
            raise InputError(f"{path} is not a folder; a sweep is stored in a folder of its own")
        ours, other = (path / ASIDE).is_dir() or (path / MANIFEST).is_dir(), any(path.iterdir())
        if (path / "zarr.json").is_file():  # since the first look another process gave its whole store this name
            return True
        if ours:
            raise damaged(path, "zarr.json", "it is missing")
        if other:
            raise InputError(f"{path} is a folder without a sweep; a sweep is stored in a folder of its own")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}; {remedy(error)}") from error
    return False


def open_existing(path: Path, fsync: bool = False) -> Store:
    """Open a store with every check that needs no plan: its metadata are what the manifest says, byte for byte.

    Raises
    ------
    InputError
        If there is none, if it was written by something else, or if its metadata is damaged.
    """
    if not exists(path):
        raise InputError(f"there is no sweep in {path}")
    record, raw = _json(path, "zarr.json")
    attrs = record.get("attributes", {})
    if not isinstance(attrs, dict):
        raise damaged(path, "zarr.json", "it has no attributes")
    if LAYOUT not in attrs:
        if os.path.isdir(path / MANIFEST):
            raise damaged(path, "zarr.json", "it says nothing of a sweep")
        raise InputError(f"{path} was written by something else: it holds no sweep; choose another folder")
    try:
        layout = Layout.read(attrs[LAYOUT])
        for part in ("grazing_config", "grazing_config_sha256", "grazing_code_sha256", "grazing_versions", "source"):
            attrs[part].encode()
        for part in ("grazing_config", "grazing_versions", *({RECIPE, MADE_BY} & attrs.keys())):
            dict(json.loads(attrs[part]))
        names = [*layout.variables, *layout.coords, DONE]
        listed = dict(record["consolidated_metadata"]["metadata"])
        if listed.keys() != {*names}:
            raise ValueError("it lists other arrays")
    except InputError as error:
        raise InputError(f"{path} cannot be opened: {error}") from None
    except MISFIT as error:
        raise damaged(path, "zarr.json", error) from error
    if hashlib.sha256(attrs["grazing_config"].encode()).hexdigest() != attrs["grazing_config_sha256"]:
        raise damaged(path, "zarr.json", "the configuration does not fit its hash")
    template = None if layout.format == UNBOUND else _template(path, layout, raw)
    arrays = {}
    for name in names:
        file = f"{name}/zarr.json"
        own, raw_own = _json(path, file)
        try:
            if template is not None and raw_own != template.metadata[file].encode():
                raise ValueError("it is not what the manifest says")
            if own != listed[name]:  # which other tools read in its place
                raise ValueError("it differs from what zarr.json of the store says")
            arrays[name] = _spec(own, name)
            _refuse_misfit(arrays[name], name, layout)
        except MISFIT as error:
            raise damaged(path, file, error) from error
    if template is None:
        return Store(path, attrs, layout, arrays, None, None, hashlib.sha256(raw).hexdigest(), fsync)
    try:
        seal = read_seal(path, template.identity, layout.grid.count)
    except (OSError, ValueError) as error:
        raise damaged(path, SEAL, error) from error
    return Store(path, attrs, layout, arrays, template, seal, template.identity, fsync)


def _json(path: Path, file: str) -> tuple[dict[str, Any], bytes]:
    """Return a file of metadata, and its bytes."""
    try:
        raw = read_file(path / file)
        record = json.loads(raw)
        if not isinstance(record, dict):
            raise ValueError("it is no metadata of Zarr")
    except (OSError, ValueError, RecursionError) as error:
        raise damaged(path, file, error) from error
    return record, raw


def _template(path: Path, layout: Layout, raw: bytes) -> Template:
    """Return the template, if it is that of this store."""
    try:
        template = read_template(path)
        wanted = {"zarr.json", *(f"{name}/zarr.json" for name in [*layout.variables, *layout.coords, DONE])}
        fits = raw == template.metadata.get("zarr.json", "").encode()
        if fits and template.metadata.keys() != wanted:
            raise ValueError("it names other arrays")
    except (OSError, ValueError) as error:
        raise damaged(path, f"{MANIFEST}/template", error) from error
    if not fits:
        raise damaged(path, "zarr.json", "it is not what the manifest says")
    return template


def _spec(own: dict[str, Any], name: str) -> Spec:
    """Return what the metadata of an array says, if it is an array as stores have them."""
    codecs = tuple(codec["name"] for codec in own["codecs"])
    endian = own["codecs"][0].get("configuration", {}).get("endian", "little")
    if codecs != (CODECS[:1] if name == DONE else CODECS) or endian != "little" or own.get("storage_transformers"):
        raise ValueError("its codecs are not those of a store")
    key, grid = own["chunk_key_encoding"], own["chunk_grid"]
    if (
        key["name"] != "default"
        or key.get("configuration", {}).get("separator", "/") != "/"
        or grid["name"] != "regular"
    ):
        raise ValueError("its chunks are not cut as those of a store")
    data_type = type_named(own["data_type"], "biufc")
    shape, chunk = (tuple(map(int, sizes)) for sizes in (own["shape"], grid["configuration"]["chunk_shape"]))
    dims = tuple(map(str, own.get("dimension_names") or ()))
    attrs, kind = own.get("attributes", {}), str(data_type)
    if not isinstance(attrs, dict):
        raise ValueError("it has no attributes")
    if own["fill_value"] != ("NaN" if data_type.kind == "f" else [0, 0] if data_type.kind == "c" else 0):
        raise ValueError("it has other numbers where nothing is computed")
    if not len(shape) == len(chunk) == len(dims) or min(shape, default=0) < 0 or min(chunk, default=1) < 1:
        raise ValueError("its shape is none")
    return Spec(dims, shape, chunk, "text" if TEXT in attrs else kind, attrs)


def _refuse_misfit(spec: Spec, name: str, layout: Layout) -> None:
    """Raise ValueError if an array does not have the shape and the type that the sweep gave it."""
    grid, n = layout.grid, len(layout.grid.shape)
    if prod(ceil(length / size) for length, size in zip(spec.shape, spec.chunk, strict=True)) > MOST:
        raise ValueError(f"it has more than {MOST} files")
    if any(size > max(1, length) for length, size in zip(spec.shape, spec.chunk, strict=True)):
        raise ValueError("its chunks are larger than itself")  # a file is read and written whole
    if name == DONE:
        if (spec.shape, spec.chunk, spec.kind) != (grid.counts, (1,) * n, "uint8"):
            raise ValueError("its shape is not that of the sweep")
        return
    if name in layout.variables:
        if spec.shape[:n] != grid.shape or spec.chunk[:n] != grid.chunk or spec.dims[:n] != layout.axes:
            raise ValueError("its shape is not that of the sweep")
        if spec.kind != layout.variables[name]:
            raise ValueError("its type is not that of the sweep")
    if spec.kind == "text" and not spec.shape:
        raise ValueError("it is no text")


def damaged(path: Path, file: str, error: object) -> InputError:
    """Return what to say of a store with a file that cannot be used."""
    if isinstance(error, PermissionError):
        return InputError(f"{path} cannot be read: {error.strerror or error} ({file})")
    return InputError(
        f"{path} is damaged: {file} cannot be used ({in_one_line(error)}). "
        f"Put that file back from a copy, or let sweep.verify(..., repair=True) (grazing sweep verify --repair) do it"
    )
