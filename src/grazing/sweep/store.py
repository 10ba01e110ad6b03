"""A store that exists: opened with every check, its finished chunks, and what a chunk is read from and written to."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import ceil, prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import GrazingError, InputError, in_one_line
from grazing.paths import path_of
from grazing.studies.plan import Plan
from grazing.sweep.codec import CODECS, decode, encode, longest, type_named
from grazing.sweep.files import MISFIT, PARTIAL, Print, print_of, read_file, remove_file, write_file
from grazing.sweep.grid import Grid
from grazing.sweep.layout import DONE, LAYOUT, MADE_BY, MOST, RECIPE, UNBOUND, Layout, Spec
from grazing.sweep.letters import TEXT, encoded
from grazing.sweep.made_by import made_by
from grazing.sweep.manifest import (
    CHUNKS,
    MANIFEST,
    SEAL,
    Record,
    Template,
    read_record,
    read_seal,
    read_template,
    record_lines,
    seal_lines,
)

Arrays = Mapping[str, NDArray[Any]]
#: Locks, times and the history: what differs between two runs, and so is no part of the result.
ASIDE = ".grazing"
#: A cell of ``done``.
THERE = b"\x01"
Slices = tuple[slice, ...]


@dataclass(frozen=True, eq=False)
class Store:
    """A store on this machine.

    Parameters
    ----------
    path : pathlib.Path
    attrs : dict
        Attributes of the whole, as stored.
    layout : Layout
    arrays : dict of str to Spec
        What the metadata says of the arrays.
    template : Template or None
        What the manifest says of metadata and coordinates; None for a store that is *unbound*: version 0.1 wrote no
        manifest.
    seal : list of str or None
        The hashes of all records of a complete store, as they were when it was opened.
    token : str
        The identity of the store: what a worker has read is still what is there.
    fsync : bool
        Whether what is written is forced to the disk at once.
    """

    path: Path
    attrs: Mapping[str, Any]
    layout: Layout
    arrays: Mapping[str, Spec]
    template: Template | None
    seal: list[str] | None
    token: str
    fsync: bool = False

    @property
    def grid(self) -> Grid:
        """How the cells are cut."""
        return self.layout.grid

    @property
    def aside(self) -> Path:
        """The folder of what differs between two runs."""
        return self.path / ASIDE

    @property
    def locks(self) -> Path:
        """The folder of the lock files."""
        return self.aside / "locks"

    @property
    def recipe(self) -> dict[str, Any] | None:
        """From which the plan can be made again."""
        return json.loads(self.attrs[RECIPE]) if RECIPE in self.attrs else None

    @cached_property
    def begun_by(self) -> Mapping[str, str]:
        """Who began the sweep; of an unbound store less is known."""
        if MADE_BY in self.attrs:
            begun: dict[str, str] = json.loads(self.attrs[MADE_BY])
            return begun
        versions = json.loads(self.attrs["grazing_versions"])
        return {
            "code": self.attrs["grazing_code_sha256"],
            "processor": self.attrs.get("grazing_processor", ""),
            **versions,
        }

    # ---- which chunks are there

    def file(self, number: int) -> str:
        """Return the file that says whether a chunk is done."""
        return "/".join([DONE, "c", *map(str, self.grid.place(number))])

    def files(self, name: str, number: int | None) -> dict[str, Slices]:
        """Return the files of a chunk of a variable, or of a coordinate (number None), each with its part of it.

        That is the part along the dimensions that are not those of the cells; a cell that is huge has several files.
        """
        place = () if number is None else self.grid.place(number)
        above = "/".join([name, "c", *map(str, place)])
        return {above + below: part for below, part in self._parts[name].items()}

    @cached_property
    def _parts(self) -> dict[str, dict[str, Slices]]:
        found = {}
        for name, spec in self.arrays.items():
            n = len(self.grid.shape) if name in self.layout.variables else 0
            sides = list(zip(spec.shape[n:], spec.chunk[n:], strict=True))
            found[name] = {
                "".join(f"/{i}" for i in place): tuple(
                    slice(i * size, min((i + 1) * size, length)) for i, (length, size) in zip(place, sides, strict=True)
                )
                for place in product(*(range(ceil(length / size)) for length, size in sides))
            }
        return found

    def files_of(self, number: int) -> list[str]:
        """Return all files of a chunk."""
        data = [key for name in self.layout.variables for key in self.files(name, number)]
        return [*data, f"{CHUNKS}/{number}", self.file(number)]

    def is_done(self, number: int) -> bool:
        """Whether a chunk is finished."""
        try:
            return read_file(f"{self.path}/{self.file(number)}", 1) == THERE
        except (OSError, ValueError):
            return False

    def done(self) -> NDArray[np.bool_]:
        """Return which chunks are finished, by number."""
        return np.fromiter((self.is_done(number) for number in range(self.grid.count)), bool, self.grid.count)

    def record(self, number: int, sealed: bool = True) -> Record:
        """Return the record of a chunk.

        Raises
        ------
        OSError, ValueError
            If it is damaged, or not the record of this chunk of this store; if asked, also if it is another one than
            the store was sealed with.
        """
        record = read_record(self.path, self.token, number)
        if record.files.keys() != {key for name in self.layout.variables for key in self.files(name, number)}:
            raise ValueError("it names other files")
        if sealed and self.seal is not None and self.seal[number] != record.sha256:
            raise ValueError("it is not the one that the complete store was sealed with: it was put back or replaced")
        return record

    def is_whole(self, number: int) -> bool:
        """Whether a chunk is done, with a sound record and files of the right length; cheap, nothing is read."""
        if not self.is_done(number):
            return False
        if self.template is None:
            return True
        try:
            files = self.record(number, sealed=False).files
            return all(os.path.getsize(f"{self.path}/{key}") == length for key, (length, _digest) in files.items())
        except (OSError, ValueError):
            return False

    # ---- reading

    def read(self, name: str, number: int | None, prints: Mapping[str, Print] | None) -> NDArray[Any]:
        """Return a chunk of an array, or a coordinate (number None), held to its prints.

        Raises
        ------
        OSError, ValueError
            If a file is missing, or is not what was written there.
        """
        spec, cells = self.arrays[name], () if number is None else self.grid.block_shape(number)
        parts = self.files(name, number)
        array = np.empty((*cells, *spec.shape[len(cells) :]), spec.dtype)
        for key, inner in parts.items():
            block = decode(self._content(key, prints, longest(spec.chunk, spec.dtype)), spec.chunk, spec.dtype)
            shape = (*cells, *(part.stop - part.start for part in inner))
            if block.shape != shape:
                block = block[tuple(map(slice, shape))]
            if len(parts) == 1:
                return block
            array[_inside(inner)] = block
        return array

    def _content(self, key: str, prints: Mapping[str, Print] | None, most: int) -> bytes:
        """Return the bytes of a file, if they are those that were written there."""
        wanted = None if prints is None else prints[key]
        try:
            content = read_file(f"{self.path}/{key}", most if wanted is None else wanted[0])
        except (FileNotFoundError, NotADirectoryError) as error:
            raise ValueError(f"{key}: its file is missing") from error
        except (OSError, ValueError) as error:
            raise ValueError(f"{key}: {in_one_line(error)}") from error
        if wanted is not None and print_of(content) != tuple(wanted):
            raise ValueError(f"{key}: it does not hold what was written there")
        return content

    # ---- writing

    def write(self, plan: Plan, number: int, arrays: Arrays) -> None:
        """Write a chunk: its variables, their record, and last that it is done.

        Raises
        ------
        GrazingError
            If the disk is full, or the store cannot be written or has gone; the chunk then counts as missing.
        """
        files: dict[str, Print] = {}
        try:
            self.refuse_if_gone()
            remove_file(self.path, self.file(number))
            for name, values in stored_chunk(plan, self.grid.block_shape(number), arrays).items():
                for key, inner in self.files(name, number).items():
                    content = encode(values[_inside(inner)], self.arrays[name].chunk)
                    self._put(key, content)
                    files[key] = print_of(content)
            self._put(f"{CHUNKS}/{number}", record_lines(self.token, number, files, made_by(plan)))
            self._put(self.file(number), THERE)
        except OSError as error:
            raise self._lost(error) from error

    def seal_if_complete(self) -> None:
        """Write the seal if all chunks are there, each with its record."""
        try:
            if self.template is not None and self.done().all():
                records = [self.record(number, sealed=False).sha256 for number in range(self.grid.count)]
                self._put(SEAL, seal_lines(self.token, records))
        except OSError as error:
            raise self._lost(error) from error
        except ValueError:  # a record is damaged: not complete after all
            return

    def unseal(self) -> None:
        """Take the seal away, before anything is computed again."""
        try:
            remove_file(self.path, SEAL)
        except OSError as error:
            raise self._lost(error) from error

    def refuse_if_gone(self) -> None:
        """Raise FileNotFoundError if the store was removed, or moved, in the meantime."""
        if not os.path.isfile(self.path / "zarr.json"):
            raise FileNotFoundError(2, "it was removed while it was being computed")

    def _put(self, key: str, content: bytes) -> None:
        write_file(self.path, key, content, self.fsync)

    def _lost(self, error: OSError) -> GrazingError:
        try:
            self.refuse_if_gone()
        except OSError as gone:
            error = gone
        return GrazingError(
            f"{self.path} cannot be written: {error.strerror or error}. What is done is kept: "
            f"make room or put it right, and resume"
        )

    def remove_partials(self, numbers: Iterable[int] | None) -> None:
        """Remove what a killed process left beside these chunks; others may be about to finish theirs.

        None for all that lies anywhere, beside coordinates and metadata, too.
        """
        ours = None
        if numbers is not None:
            ours = {key for number in list(numbers) for key in self.files_of(number)} | {SEAL}
        else:
            for name in os.listdir(self.path):
                if PARTIAL.fullmatch(name):
                    remove_file(self.path, name)
        for name in [*self.layout.variables, *self.layout.coords, DONE, MANIFEST]:
            if os.path.islink(self.path / name):
                continue
            for folder, _folders, files in os.walk(self.path / name):
                for file in files:
                    found = PARTIAL.fullmatch(file)
                    where = Path(folder).relative_to(self.path).as_posix()
                    if found and (ours is None or f"{where}/{found['name']}" in ours):
                        remove_file(self.path, f"{where}/{file}")


def _inside(part: Slices) -> Any:
    """Return the index of a part along the last dimensions."""
    return (..., *part)


def stored_chunk(plan: Plan, shape: tuple[int, ...], arrays: Arrays) -> dict[str, NDArray[Any]]:
    """Return the arrays of the cells of a chunk as they are stored."""
    found = {}
    for name, variable in plan.variables.items():
        values = arrays[name]
        if variable.kind == "text":
            values = encoded(values, variable.longest, name)
        found[name] = values.reshape((*shape, *values.shape[1:]))
    return found


# ---- opening


def folder_of(path: str | os.PathLike[str]) -> Path:
    """Return the path of a store; addresses of remote stores are refused."""
    if not isinstance(path, (str, os.PathLike)) or "://" in str(path) or not str(path):
        raise InputError(f"store is {path!r}; give the path of a folder on a disk of this machine")
    return Path(os.path.abspath(path_of(path)))


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
            raise InputError(f"{path} is not a folder; a sweep is stored in a folder of its own: choose another name")
        ours, other = (path / ASIDE).is_dir() or (path / MANIFEST).is_dir(), any(path.iterdir())
        if (path / "zarr.json").is_file():  # since the first look another process gave its whole store this name
            return True
        if ours:
            raise damaged(path, "zarr.json", "it is missing")
        if other:
            raise InputError(f"{path} is not empty and holds no sweep; choose another folder, it is left alone")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}; choose another folder") from error
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
        listed = record["consolidated_metadata"]["metadata"] if layout.format == UNBOUND else {}
    except InputError as error:
        raise InputError(f"{path} cannot be opened: {error}") from None
    except MISFIT as error:
        raise damaged(path, "zarr.json", error) from error
    if hashlib.sha256(attrs["grazing_config"].encode()).hexdigest() != attrs["grazing_config_sha256"]:
        raise damaged(path, "zarr.json", "the configuration does not fit its hash")
    template = None if layout.format == UNBOUND else _template(path, layout, raw)
    arrays = {}
    for name in [*layout.variables, *layout.coords, DONE]:
        file = f"{name}/zarr.json"
        own, raw_own = _json(path, file)
        try:
            if template is None and {**own, "attributes": {}} != {**listed[name], "attributes": {}}:
                raise ValueError("it differs from what zarr.json of the store says")
            if template is not None and raw_own != template.metadata[file].encode():
                raise ValueError("it is not what the manifest says")
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
