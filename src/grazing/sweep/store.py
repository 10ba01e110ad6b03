"""A store that exists: opened with every check, its finished chunks, and what a chunk is read from and written to."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import GrazingError, InputError, in_one_line
from grazing.paths import path_of
from grazing.studies.plan import Plan
from grazing.sweep.codec import decode, encode, longest
from grazing.sweep.files import PARTIAL, Print, print_of, read_file, remove_file, write_file
from grazing.sweep.grid import Grid
from grazing.sweep.layout import DONE, MADE_BY, RECIPE, Layout, Spec
from grazing.sweep.letters import encoded
from grazing.sweep.made_by import made_by
from grazing.sweep.manifest import CHUNKS, MANIFEST, SEAL, Record, Template, read_record, record_lines, seal_lines

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
            content = read_file(f"{self.path}/{key}", most if wanted is None else min(most, wanted[0]))
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


def folder_of(path: str | os.PathLike[str]) -> Path:
    """Return the path of a store; addresses of remote stores are refused."""
    if not isinstance(path, (str, os.PathLike)) or "://" in str(path) or not str(path):
        raise InputError(f"store is {path!r}; give the path of a folder on a disk of this machine")
    return Path(os.path.abspath(path_of(path)))
