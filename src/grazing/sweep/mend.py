"""Repair a store: metadata from the manifest, coordinates from the plan; chunks are left to be computed again."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from grazing.outcome import InputError, in_one_line
from grazing.studies.plan import Plan
from grazing.sweep.files import MISFIT, Print, clear_way, is_plain, print_of, read_file, write_file
from grazing.sweep.grid import Grid
from grazing.sweep.layout import DONE, FORMAT, LAYOUT, Layout, laid_out
from grazing.sweep.manifest import MANIFEST, SEAL, TEMPLATE, identities_named, read_seal, read_template, template_of
from grazing.sweep.store import Store
from grazing.sweep.template import coordinate_files, manifest_of, write_template


def mend_metadata(path: Path, plan: Plan | None) -> list[str]:
    """Put back the metadata that are not what the manifest says, and the manifest's own if need be.

    Parameters
    ----------
    path : path
        A folder; one that is no store, or an unbound one, is left alone.
    plan : Plan, optional
        Needed if the manifest and the metadata are both damaged.

    Returns
    -------
    list of str
        The files that were put back or removed.

    Raises
    ------
    InputError
        If what is left does not say what was there.
    """
    if not os.path.isdir(path / MANIFEST) and _format(path) != FORMAT:
        return []
    mended = []
    try:
        template = read_template(path)
    except (OSError, ValueError) as error:
        content = _template_again(path, plan, error)
        _put(path, TEMPLATE, content)
        mended.append(TEMPLATE)
        template = template_of(content)
    for file, text in template.metadata.items():
        try:
            if is_plain(path, file) and read_file(path / file) == text.encode():
                continue
        except (OSError, ValueError):
            pass
        _put(path, file, text.encode())
        mended.append(file)
    try:
        count = Layout.read(json.loads(template.metadata["zarr.json"])["attributes"][LAYOUT]).grid.count
        read_seal(path, template.identity, count)
    except (OSError, *MISFIT):
        with said(path):
            clear_way(path, SEAL)
        mended.append(SEAL)
    return mended


def mend_coordinates(store: Store, plan: Plan, names: Iterable[str]) -> list[str]:
    """Put back the files of coordinates; return those that were.

    Raises
    ------
    InputError
        If another version of Zarr's codecs compresses them in another way.
    """
    specs = laid_out(plan, store.grid)[1]
    mended = []
    for key, content in coordinate_files({name: specs[name] for name in names}).items():
        if store.template is None or print_of(content) != store.template.coordinates.get(key):
            raise InputError(f"{store.path}: {key} cannot be put back with the versions here; begin another store")
        _put(store.path, key, content)
        mended.append(key)
    return mended


def forget_chunks(store: Store, numbers: Iterable[int]) -> None:
    """Count chunks as missing, and remove what stands where their files belong, and what killed processes left."""
    with said(store.path):
        store.remove_partials(None)
        for number in numbers:
            clear_way(store.path, store.file(number))  # first of all: from now on the others say nothing
            for key in store.files_of(number):
                clear_way(store.path, key)


def _put(path: Path, key: str, content: bytes) -> None:
    with said(path):
        clear_way(path, key)
        write_file(path, key, content)


@contextmanager
def said(path: Path) -> Iterator[None]:
    """Say in a sentence what the system does not let happen to a store."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}") from error


def _format(path: Path) -> int | None:
    """Return the format that the metadata of the whole name, if any."""
    try:
        return int(json.loads(json.loads(read_file(path / "zarr.json"))["attributes"][LAYOUT])["format"])
    except (OSError, *MISFIT):
        return None


def _template_again(path: Path, plan: Plan | None, error: Exception) -> bytes:
    """Make the manifest's template again: it is the right one if the old one, or a record, names its identity."""
    with said(path):
        named = identities_named(path)
    content = None
    for content in _candidates(path, plan):
        if template_of(content).identity in named:
            return content
    if content is not None and not named and plan is not None:  # no chunk claims anything: all are computed again
        return content
    raise InputError(
        f"{path} is damaged: {TEMPLATE} cannot be used ({in_one_line(error)}), and neither its metadata nor a plan "
        f"make it again. Give the plan, with the versions that it was begun with, or begin another store"
    )


def _candidates(path: Path, plan: Plan | None) -> Iterator[bytes]:
    """Yield templates: of the metadata that are there, and of the plan."""
    try:
        layout = Layout.read(json.loads(read_file(path / "zarr.json"))["attributes"][LAYOUT])
        names = [*layout.variables, *layout.coords, DONE]
        files = (file for name in layout.coords for file in sorted((path / name / "c").rglob("*")))
        prints: dict[str, Print] = {
            file.relative_to(path).as_posix(): print_of(read_file(file)) for file in files if file.is_file()
        }
        if all(os.path.isdir(path / name) for name in names):
            yield manifest_of(path, names, prints)
    except (OSError, *MISFIT):
        layout = None
    if plan is not None:
        grids = {layout.grid} if layout is not None else _grids(path, plan)
        for grid in grids:
            with tempfile.TemporaryDirectory() as folder:
                write_template(Path(folder), plan, grid)
                yield read_file(Path(folder) / TEMPLATE)


def _grids(path: Path, plan: Plan) -> set[Grid]:
    """Return what the arrays that can still be read say of the chunks."""
    n, found = len(plan.shape), set()
    for name in plan.variables:
        try:
            chunk = json.loads(read_file(path / name / "zarr.json"))["chunk_grid"]["configuration"]["chunk_shape"]
            found.add(Grid(plan.shape, tuple(map(int, chunk[:n]))))
        except (OSError, *MISFIT):
            continue
    return found
