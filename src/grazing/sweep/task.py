"""Compute chunks: the one task that threads, shards and workers on a cluster all run."""

from __future__ import annotations

import hashlib
import io
import json
import os
import pickle
import socket
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from threading import Lock
from time import perf_counter
from types import MappingProxyType
from typing import Any

from grazing.outcome import GrazingError, InputError, in_one_line
from grazing.studies.plan import Plan, empty_arrays
from grazing.sweep.files import append_line, place, read_file, write_file
from grazing.sweep.made_by import made_by
from grazing.sweep.opened import open_existing
from grazing.sweep.same import listed, refuse_another
from grazing.sweep.store import ASIDE, Arrays, Store

#: The folder of the times, beside locks and history.
TIMES = "times"
#: Seconds beyond which, or below zero, a line there is not the time of a chunk.
MOST_SECONDS = 1e9
#: Plans that a worker keeps.
KEPT = 4
#: Path and token of a store, the name of the plan, who makes chunks, whether others may, and whether to force the disk.
Asked = tuple[str, str, str, str, bool, bool]
#: By all that a run says to its workers, which may serve the next one too.
_plans: dict[Asked, tuple[Plan, Store]] = {}
_lock = Lock()


def computed(plan: Plan, store: Store, number: int, arrays: Arrays) -> Iterator[None]:
    """Compute the cells of a chunk, tile by tile."""
    cells = store.grid.cells(number)
    step = max(1, plan.together)
    for first in range(0, len(cells), step):
        part = slice(first, first + step)
        yield from plan.compute(cells[part], {name: array[part] for name, array in arrays.items()})


def chunk_task(plan: Plan, store: Store, number: int) -> Iterator[None]:
    """Compute a chunk and write it."""
    begun = perf_counter()
    arrays = empty_arrays(plan, store.grid.size(number))
    yield from computed(plan, store, number, arrays)
    store.write(plan, number, arrays)
    note_time(store, number, perf_counter() - begun)


# ---- how long it took, beside the result


def note_time(store: Store, number: int, seconds: float) -> None:
    """Append the time that a chunk took to a file of this process."""
    key = f"{ASIDE}/{TIMES}/{socket.gethostname()}-{os.getpid()}"
    with suppress(OSError):  # the chunk is safe; a disk that is full says so with the next one
        append_line(store.path, key, f"{number} {seconds:.6f}")


def time_of_work(store: Store) -> float:
    """Return the seconds that finished chunks took, over all processes."""
    total = 0.0
    with suppress(OSError):
        for file in (store.aside / TIMES).iterdir():
            with suppress(OSError, ValueError):
                for line in read_file(file).decode("ascii", "replace").splitlines():
                    number, _, seconds = line.partition(" ")
                    with suppress(ValueError):  # the last line of a killed process
                        if number and 0.0 <= float(seconds) < MOST_SECONDS:
                            total += float(seconds)
    return total


# ---- workers: they get indices; the plan they find in the store


def send_plan(plan: Plan, store: Store, other_code: bool = False) -> Asked:
    """Put a plan where workers find it; return what :func:`compute_chunk` takes but for the chunk.

    Parameters
    ----------
    plan : Plan
    store : Store
    other_code : bool
        Whether workers may have other code than this process.

    Raises
    ------
    InputError
        For a plan that has no recipe and cannot be pickled.
    """
    name = ""
    if store.recipe is None:
        content = _pickled(plan)
        name = hashlib.sha256(content).hexdigest()
        file = store.aside / f"plan-{name}.pickle"
        try:
            write_file(store.path, f"{ASIDE}/{file.name}", content, store.fsync)
            with place(store.path, ASIDE) as aside:
                for old in aside.names(".pickle"):
                    if old.startswith("plan-") and old != file.name:
                        aside.remove(old)
        except OSError as error:
            raise GrazingError(f"{store.path} cannot be written: {error.strerror or error}") from error
    asked = (os.fspath(store.path), store.token, name, code_of(plan), other_code, store.fsync)
    _keep(asked, (plan, store))
    return asked


def compute_chunk(
    path: str,
    token: str,
    name: str,
    code: str,
    other_code: bool,
    fsync: bool,
    number: int,
    own: Mapping[str, str] | None = None,
) -> int:
    """Compute one chunk on a worker and write it.

    Parameters
    ----------
    path : str
        The store, on a disk that the worker sees.
    token : str
        Of the store that is meant, see :class:`grazing.sweep.store.Store`.
    name : str
        Of the plan beside the store, empty for that of its recipe.
    code : str
        Who makes chunks in the run, see :func:`code_of`.
    other_code : bool
        Whether workers may differ from it.
    fsync : bool
        Whether to force what is written to the disk.
    number : int
        The chunk.
    own : mapping, optional
        What :func:`own_of` returned: code that the call of the run named. What the store names runs nothing.
    """
    return finish_chunk(*_plan_on_worker((path, token, name, code, other_code, fsync), own), number)


def finish_chunk(plan: Plan, store: Store, number: int) -> int:
    """Compute one chunk where the plan is at hand, and write it."""
    for _tile in chunk_task(plan, store, number):
        pass
    return number


def code_of(plan: Plan) -> str:
    """Return one hash of all that says who makes the chunks of a plan in this process."""
    return hashlib.sha256(json.dumps(made_by(plan), sort_keys=True).encode()).hexdigest()


def own_of(plan: Plan) -> dict[str, str]:
    """Return the files of the user that made a plan, as the call that made it named them."""
    from grazing.config.own import KEYS, Named

    recipe = plan.recipe or {}
    return {key: str(recipe[key]) for key in KEYS if isinstance(recipe.get(key), Named)}


def _plan_on_worker(asked: Asked, own: Mapping[str, str] | None) -> tuple[Plan, Store]:
    with _lock:
        if asked in _plans:
            return _plans[asked]
    path, token, name, code, other_code, fsync = asked
    where = f"worker {os.getpid()} on {socket.gethostname()}"
    try:
        store = open_existing(Path(path), fsync)
    except InputError as error:
        raise GrazingError(f"{where}: {error}. The store must be on a disk that all workers share") from error
    if store.token != token:
        raise GrazingError(f"{where}: {path} is not the store that the run began with")
    plan = _unpickled(store, name, where) if name else plan_from_recipe(store, own=own)
    try:
        refuse_another(store, plan, other_code=True)  # whether that is allowed, the run has decided
    except InputError as error:
        raise GrazingError(f"{where} has another plan than the run: {error}") from error
    if not other_code and code_of(plan) != code:
        differs = listed(store.begun_by, made_by(plan)) or "the run has other code than the sweep was begun with"
        raise GrazingError(
            f"{where} has other code than the run: {differs}. Use the same Python, packages and kind of processor "
            f"there, or allow the mixture with other_code=True"
        )
    _keep(asked, (plan, store))
    return plan, store


def _keep(asked: Asked, found: tuple[Plan, Store]) -> None:
    with _lock:
        _plans[asked] = found
        while len(_plans) > KEPT:
            del _plans[next(iter(_plans))]


def plan_from_recipe(store: Store, code: str | None = None, own: Mapping[str, str] | None = None) -> Plan:
    """Make the plan of a store again.

    Parameters
    ----------
    store : Store
    code : {"trust"}, optional
        Run the file that the recipe names, if it is one of the user's own.
    own : mapping, optional
        Files that this call names, by the keys of a configuration, in the place of those in the recipe.

    Raises
    ------
    InputError
        If the store keeps no recipe, or one that names code which this call does not.
    """
    if store.recipe is None:
        raise InputError(f"{store.path} keeps no recipe of its plan; give the plan itself")
    from grazing.config import plan_of
    from grazing.config.own import Named, named

    here = {key: Named(text) for key, text in (own or {}).items()}
    plan: Plan = plan_of(named({**store.recipe, **here}, code))
    return plan


def frozen(mapping: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    """Return a mapping that cannot be changed; its own type has no name that a pickle could find."""
    return MappingProxyType(mapping)


def _pickled(plan: Plan) -> bytes:
    try:
        base: Any = import_module("cloudpickle").Pickler  # functions that no module has travel too: every map has some
    except ImportError as error:
        raise InputError(
            f"a plan without a recipe needs a package to reach workers ({error}); pip install 'grazing[cluster]', "
            f"give a plan with a recipe, or run it on threads or by shards"
        ) from error

    class PlanPickler(base):  # type: ignore[misc]
        def reducer_override(self, value: Any) -> Any:
            if isinstance(value, MappingProxyType):
                return frozen, (dict(value),)
            return super().reducer_override(value)

    buffer = io.BytesIO()
    try:
        PlanPickler(buffer, protocol=pickle.HIGHEST_PROTOCOL).dump(plan)
    except Exception as error:  # whatever an object says that cannot be pickled
        raise InputError(
            f"the plan cannot be sent to workers: {error}. Run it on threads or by shards, or give a plan with a recipe"
        ) from error
    return buffer.getvalue()


def _unpickled(store: Store, name: str, where: str) -> Plan:
    try:
        content = read_file(store.aside / f"plan-{name}.pickle", sys.maxsize)
    except (OSError, ValueError) as error:
        raise GrazingError(f"{where} finds no plan in {store.path}: {in_one_line(error)}") from error
    if hashlib.sha256(content).hexdigest() != name:  # a pickle runs code: only the one that the run wrote is opened
        raise GrazingError(f"{where}: the plan in {store.path} is not the one that the run put there")
    try:
        plan: Plan = pickle.loads(content)
    except Exception as error:  # such as a module that the worker does not have
        raise GrazingError(f"{where} cannot make the plan: {type(error).__name__}: {error}") from error
    return plan


def note_run(store: Store, line: dict[str, Any]) -> None:
    """Append a line to the history of the store."""
    with suppress(OSError):
        append_line(store.path, f"{ASIDE}/history.jsonl", json.dumps(line))
