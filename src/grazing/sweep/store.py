"""A store that exists: opened with every check, its finished chunks, and what a chunk is read from and written to."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import GrazingError, InputError
from grazing.studies.plan import Plan
from grazing.sweep.grid import Grid
from grazing.sweep.layout import DONE, LAYOUT, RECIPE, Layout
from grazing.sweep.letters import encoded
from grazing.sweep.template import ASIDE
from grazing.sweep.writers import wait_for_zarr

Arrays = Mapping[str, NDArray[Any]]
#: What Zarr writes beside a chunk before the chunk gets its name.
_PARTIAL = re.compile(r"(?P<last>[^.]+)\.[0-9a-f]{32}\.partial")
_setting = Lock()


@dataclass(frozen=True, eq=False)
class Store:
    """A store on this machine.

    Parameters
    ----------
    path : pathlib.Path
    attrs : dict
        Attributes of the whole, as stored.
    layout : Layout
    arrays : dict
        The open Zarr arrays.
    token : str
        SHA-256 of the metadata of the whole: what a worker has read is still what is there.
    """

    path: Path
    attrs: Mapping[str, Any]
    layout: Layout
    arrays: Mapping[str, Any]
    token: str

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

    def file(self, name: str, number: int) -> Path:
        """Return the file that holds the first corner of a chunk of an array."""
        further = self.arrays[name].ndim - len(self.grid.shape) if name != DONE else 0
        place = (*self.grid.place(number), *(0,) * further)
        return self.path.joinpath(name, "c", *map(str, place))

    def is_done(self, number: int) -> bool:
        """Whether a chunk is finished."""
        try:
            return self.file(DONE, number).read_bytes() == b"\x01"
        except (FileNotFoundError, NotADirectoryError):
            return False

    def done(self) -> NDArray[np.bool_]:
        """Return which chunks are finished, by number."""
        return np.fromiter((self.is_done(number) for number in range(self.grid.count)), bool, self.grid.count)

    def read(self, name: str, number: int) -> NDArray[Any]:
        """Return a chunk of an array that is done.

        Raises
        ------
        FileNotFoundError
            If its file is missing, where Zarr would answer with its fill value.
        """
        if not self.file(name, number).is_file():
            raise FileNotFoundError("its file is missing")
        return np.asarray(self.arrays[name][self.grid.block(number)])

    def write(self, plan: Plan, number: int, arrays: Arrays) -> None:
        """Write a chunk: its variables, and last that it is done.

        Raises
        ------
        GrazingError
            If the disk is full, or the store cannot be written or has gone; the chunk then counts as missing.
        """
        try:
            if not (self.path / "zarr.json").is_file():  # Zarr would make the missing folders again
                raise FileNotFoundError(2, "it was removed while it was being computed")
            for name, values in stored_chunk(plan, self.grid.block_shape(number), arrays).items():
                self.arrays[name][self.grid.block(number)] = values
            self.arrays[DONE][self.grid.place(number) or ...] = 1
        except OSError as error:
            wait_for_zarr()
            raise GrazingError(
                f"{self.path} cannot be written: {error.strerror or error}. What is done is kept: "
                f"make room or put it right, and resume"
            ) from error

    def remove_partials(self, numbers: Iterable[int]) -> None:
        """Remove what a killed process left beside these chunks; others may be about to finish theirs."""
        ours = {self.grid.place(number) for number in numbers}
        n = len(self.grid.shape)
        for name in [*self.layout.variables, DONE]:
            base = self.path / name / "c"
            for folder, _folders, files in os.walk(base if n else base.parent):
                above = Path(folder).relative_to(base).parts if n else ()
                for file in files:
                    found = _PARTIAL.fullmatch(file)
                    if found and (not n or tuple(map(int, (*above, found["last"])[:n])) in ours):
                        Path(folder, file).unlink(missing_ok=True)


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
    return Path(os.path.abspath(path))


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
        if (path / ASIDE).is_dir():
            raise _damaged(path, "zarr.json", "it is missing")
        if any(path.iterdir()):
            raise InputError(f"{path} is not empty and holds no sweep; choose another folder, it is left alone")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}; choose another folder") from error
    return False


def open_existing(path: Path, writable: bool = False) -> Store:
    """Open a store with every check that needs no plan.

    Raises
    ------
    InputError
        If there is none, if it was written by something else, or if its metadata is damaged.
    """
    if not exists(path):
        raise InputError(f"there is no sweep in {path}")
    try:
        raw = (path / "zarr.json").read_bytes()
        record = json.loads(raw)
        attrs = dict(record.get("attributes", {}))
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}") from error
    except (ValueError, TypeError, AttributeError) as error:
        raise _damaged(path, "zarr.json", error) from error
    if LAYOUT not in attrs:
        raise InputError(f"{path} was written by something else: it holds no sweep; choose another folder")
    try:
        layout = Layout.read(attrs[LAYOUT])
        for part in ("grazing_config", "grazing_config_sha256", "grazing_code_sha256", "source"):
            attrs[part]
    except InputError as error:
        raise InputError(f"{path} cannot be opened: {error}") from None
    except (ValueError, TypeError, KeyError) as error:
        raise _damaged(path, "zarr.json", error) from error
    if hashlib.sha256(attrs["grazing_config"].encode()).hexdigest() != attrs["grazing_config_sha256"]:
        raise _damaged(path, "zarr.json", "the configuration does not fit its hash")
    listed = record.get("consolidated_metadata", {}).get("metadata", {})
    arrays = _arrays(path, layout, listed, "r+" if writable else "r")
    return Store(path, attrs, layout, arrays, hashlib.sha256(raw).hexdigest())


def _arrays(path: Path, layout: Layout, listed: Any, mode: str) -> dict[str, Any]:
    """Open the arrays of a store; each must be what the whole says it is."""
    import zarr

    arrays = {}
    for name in [*layout.variables, *layout.coords, DONE]:
        file = path / name / "zarr.json"
        try:
            own = json.loads(file.read_bytes())
            if {**own, "attributes": {}} != {**listed[name], "attributes": {}}:  # anybody may add a note
                raise ValueError("it differs from what zarr.json of the store says")
            # a file that is missing shall be damage, not zeros; and the setting is one for all threads
            with _setting, zarr.config.set({"array.write_empty_chunks": True}):
                array = zarr.open_array(str(path / name), mode=mode, zarr_format=3)
        except Exception as error:  # what is not what it should be can fail anywhere in the reader
            raise _damaged(path, f"{name}/zarr.json", error) from error
        arrays[name] = array
        cells = layout.grid.shape if name in layout.variables else ()
        if (
            tuple(array.shape[: len(cells)]) != cells
            or tuple(array.chunks[: len(cells)]) != layout.grid.chunk[: len(cells)]
        ):
            raise _damaged(path, f"{name}/zarr.json", "its shape is not that of the sweep")
    return arrays


def _damaged(path: Path, file: str, error: object) -> InputError:
    return InputError(
        f"{path} is damaged: {file} cannot be used ({in_one_line(error)}). "
        f"Put that file back from a copy, or begin another store"
    )


def in_one_line(error: object) -> str:
    """Return the first line of what an error says."""
    return str(error).splitlines()[0] if str(error) else type(error).__name__
