"""Who is working on a store: lock files with host, process and shard; those of dead processes are taken over.

A lock file is complete, and locked by the operating system, before it gets its name. That system lock goes away with
its process however it ends, so that nobody has to guess from a process number. Across machines, where it may not
reach, a running process touches its file now and then; one that has not been touched for two minutes, or that was
touched in the future, is taken over. That is safe even if its process is only asleep: two processes that compute a
chunk write the same bytes.
"""

from __future__ import annotations

import json
import os
import socket
import stat
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from threading import Event, Thread
from uuid import uuid4

from grazing.outcome import InputError
from grazing.sweep.files import Place, is_own, place
from grazing.sweep.opened import open_existing
from grazing.sweep.store import ASIDE, folder_of

try:
    import fcntl
except ImportError:  # pragma: no cover  (Windows: the touched files decide)
    fcntl = None  # type: ignore[assignment]

#: Seconds between two touches of a lock file, and after how many an untouched one is taken over.
TOUCH, STALE = 15.0, 120.0
#: Seconds to wait for another process that is just looking at the locks.
PATIENCE = 20.0

#: System locks are inherited by a fork, and would outlive us in it.
_held: set[int] = set()


def _drop_inherited() -> None:
    for handle in _held:
        with suppress(OSError):
            os.close(handle)
    _held.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_drop_inherited)


@dataclass(frozen=True)
class Lock:
    """Who works on a store: ``shard`` is ``"1/3"``, or empty for all of it; ``seen`` is its last sign of life."""

    host: str
    pid: int
    shard: str
    since: str
    seen: str = ""

    def __str__(self) -> str:
        what = f"shard {self.shard}" if self.shard else "a run of the whole sweep"
        seen = f", last seen {self.seen}" if self.seen else ""
        return f"{what} (process {self.pid} on {self.host}, since {self.since}{seen})"


#: What is said of a lock that nobody can read.
UNKNOWN = Lock("an unknown machine", 0, "", "an unknown time")


@contextmanager
def locked(folder: Path, shard: tuple[int, int] | None) -> Iterator[None]:
    """Hold the lock of a store, or of one shard of it.

    Parameters
    ----------
    folder : path
        Where the lock files are; made if missing.
    shard : (int, int), optional
        Which of how many; shards of the same number work together, all else is refused.

    Raises
    ------
    InputError
        If somebody else works on the store, naming who; or if the folder is not writable.
    """
    me = Lock(socket.gethostname(), os.getpid(), "" if shard is None else f"{shard[0]}/{shard[1]}", _now())
    name = "all.lock" if shard is None else f"shard-{shard[0]}-of-{shard[1]}.lock"
    with ExitStack() as stack:
        try:
            locks = stack.enter_context(_locks_of(folder, make=True))
            with _one_at_a_time(locks) as now:
                _refuse_others(locks, me, "", now)
                handle = _put(locks, name, me)
                stack.callback(_release, locks, name, handle)
                # where the system has no locks, both of two that start together stop
                _refuse_others(locks, me, name, now)
        except OSError as error:
            raise InputError(
                f"{folder.parent.parent} cannot be written: {error.strerror or error}; "
                f"a sweep needs a folder that it may write to"
            ) from error
        over = Event()
        stack.callback(over.set)
        Thread(target=_touch, args=(handle, over), name="grazing-lock", daemon=True).start()
        yield


def holders(folder: Path) -> list[Lock]:
    """Return who works on a store now."""
    with suppress(OSError), _locks_of(folder) as locks:
        return [lock for _name, lock in _living(locks, time.time())]
    return []


def unlock(store: str | os.PathLike[str], force: bool = False) -> list[Lock]:
    """Remove the locks of a store whose holders are dead.

    A run does that by itself; this is for a lock that it believes. The lock of a process that still runs is removed
    by force only, and that loses nothing: two processes that compute the same chunk write the same bytes.

    Parameters
    ----------
    store : path-like
    force : bool
        Remove the locks of living holders, too.

    Returns
    -------
    list of Lock
        Whose locks were removed, with the time of the last sign of life.

    Raises
    ------
    InputError
        If there is no store, or somebody works on it, naming who and since when; then nothing is removed.

    Examples
    --------
    >>> import tempfile, numpy as np, grazing as gz
    >>> from grazing import sweep
    >>> G = gz.gap_map(lam=0.8, mu=0.1, l=0.2)
    >>> plan = gz.plans.density(G, "mu", np.linspace(0.0, 0.3, 8), starts=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = sweep.run(plan, f"{folder}/a.zarr")
    ...     sweep.unlock(f"{folder}/a.zarr")
    []
    """
    path = folder_of(store)
    folder = path / ASIDE / "locks"
    if not is_own(path, f"{ASIDE}/locks"):
        open_existing(path)  # there may be none, which is said there
        return []
    try:
        with _locks_of(folder) as locks, _one_at_a_time(locks) as now:
            living = dict(_living(locks, now))
            if living and not force:
                raise InputError(
                    f"{path} is being worked on by {'; '.join(map(str, living.values()))}. Wait until it has ended or "
                    f"stop it; force=True (--force) removes the lock all the same"
                )
            removed = []
            for name in locks.names(".lock"):
                removed.append(living.get(name) or _read(locks, name) or UNKNOWN)
                locks.remove(name)
            return removed
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}") from error


def process_exists(pid: int) -> bool:
    """Whether a process of this machine exists; True where that cannot be told."""
    if os.name != "posix":  # pragma: no cover  (elsewhere os.kill is no question, it kills)
        return True
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


# ---- files


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _locks_of(folder: Path, make: bool = False) -> AbstractContextManager[Place]:
    """Open the folder of the locks of a store."""
    return place(folder.parents[1], f"{folder.parent.name}/{folder.name}", make)


@contextmanager
def _one_at_a_time(locks: Place) -> Iterator[float]:
    """Let one process at a time look at the locks and place its own; give the time, by the clock of the disk."""
    known = locks.look("gate")
    if known is not None and not _is_only_name(known):
        locks.remove("gate")
    handle = locks.open("gate", os.O_RDWR | os.O_CREAT)
    try:
        if not _is_only_name(os.fstat(handle)):
            raise FileExistsError(17, "something else has just taken the place of its gate")
        os.write(handle, b".")
        os.ftruncate(handle, 0)
        last = time.monotonic() + PATIENCE
        while _try_lock(handle) is False and time.monotonic() < last:
            time.sleep(0.01)
        yield os.fstat(handle).st_mtime
    finally:
        os.close(handle)


def _is_only_name(known: os.stat_result) -> bool:
    """Whether something is a file that no hard link shares: the other one is somebody's, and would be emptied."""
    return stat.S_ISREG(known.st_mode) and known.st_nlink == 1


def _try_lock(handle: int, alone: bool = True) -> bool | None:
    """Lock a file: True if we have it now, False if another has it, None where the system cannot tell.

    Not alone: only to see whether somebody has it; several may look at once.
    """
    if fcntl is None:  # pragma: no cover
        return None
    try:
        fcntl.flock(handle, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return None
    return True


def _put(locks: Place, name: str, me: Lock) -> int:
    """Put our lock file in its place, already written and locked; return its handle."""
    unnamed = f"{uuid4().hex}.new"
    handle = locks.open(unnamed, os.O_RDWR | os.O_CREAT | os.O_EXCL)
    here, there, where = locks.called(unnamed), locks.called(name), locks.handle
    try:
        os.write(handle, json.dumps(asdict(me)).encode())
        _try_lock(handle)
        try:
            os.link(here, there, src_dir_fd=where, dst_dir_fd=where)
        except FileExistsError:  # it must be gone or dead: we have looked
            raise InputError(f"another process is starting on {locks.path.parents[1]}; try again") from None
        except OSError:  # a file system without links
            os.replace(here, there, src_dir_fd=where, dst_dir_fd=where)
        finally:
            locks.remove(unnamed)
    except BaseException:
        os.close(handle)
        raise
    _held.add(handle)
    return handle


def _release(locks: Place, name: str, handle: int) -> None:
    try:
        with suppress(OSError):  # a lock that cannot be removed is a dead one
            if _is(locks, name, handle):
                locks.remove(name)
    finally:
        if handle in _held:  # not in a fork, which dropped it
            _held.discard(handle)
            os.close(handle)


def _is(locks: Place, name: str, handle: int) -> bool:
    """Whether a name still stands for the file that we have open."""
    try:
        known = locks.look(name)
        return known is not None and os.path.samestat(known, os.fstat(handle))
    except OSError:
        return False


def _touch(handle: int, over: Event) -> None:
    while os.utime in os.supports_fd and not over.wait(TOUCH):
        with suppress(OSError):
            os.utime(handle)


# ---- who else is there


def _refuse_others(locks: Place, me: Lock, own: str, now: float) -> None:
    """Raise InputError if somebody works on the store who is no other shard of the same number; bury the dead."""
    count = me.shard.partition("/")[2]
    for name, lock in _living(locks, now, bury=True):
        if name == own or (me.shard and lock.shard.partition("/")[2] == count and lock.shard != me.shard):
            continue
        raise InputError(
            f"{locks.path.parents[1]} is being worked on by {lock}; wait until it has ended, or stop it. "
            f"Only shards of the same number work on a store together; sweep.unlock removes a lock that is in the way"
        )


def _living(locks: Place, now: float, bury: bool = False) -> list[tuple[str, Lock]]:
    """Return the lock files of living processes; if asked, remove those of dead ones."""
    found = []
    for name in locks.names(".new") if bury else ():
        with suppress(OSError):
            known = locks.look(name)
            if known is not None and abs(now - known.st_mtime) > STALE:
                locks.remove(name)
    for name in locks.names(".lock"):
        handle = _opened(locks, name)
        try:
            lock = None if handle is None else _read_from(handle)
            if handle is not None and lock is not None and not _dead(now, handle, lock):
                found.append((name, lock))
            elif bury and (handle is None or _is(locks, name, handle)):
                locks.remove(name)
        finally:
            if handle is not None:
                os.close(handle)
    return found


def _opened(locks: Place, name: str) -> int | None:
    """Open a lock file; None for what is none, such as a pipe, a folder or a link."""
    for way in (os.O_RDWR, os.O_RDONLY):  # one that is not ours to lock can still be read
        try:
            handle = locks.open(name, way)
        except OSError:
            continue
        if stat.S_ISREG(os.fstat(handle).st_mode):
            return handle
        os.close(handle)
    return None


def _read(locks: Place, name: str) -> Lock | None:
    handle = _opened(locks, name)
    if handle is None:
        return None
    try:
        return _read_from(handle)
    finally:
        os.close(handle)


def _read_from(handle: int) -> Lock | None:
    """Return what a lock file says; None if it was not written by us, or torn by a power cut."""
    try:
        said = json.loads(os.read(handle, 10_000))
        lock = Lock(str(said["host"]), int(said["pid"]), str(said["shard"]), str(said["since"]))
        return replace(lock, seen=datetime.fromtimestamp(os.fstat(handle).st_mtime, UTC).isoformat(timespec="seconds"))
    except (ValueError, TypeError, KeyError, OSError, OverflowError, RecursionError):
        return None


def _dead(now: float, handle: int, lock: Lock) -> bool:
    free = _try_lock(handle, alone=False)
    if free is False:
        return False
    if lock.host == socket.gethostname() and (free or not process_exists(lock.pid)):
        return True
    # By the clock of the disk, since machines differ in theirs; a file of the future is touched by nobody any more.
    with suppress(OSError):
        return abs(now - os.fstat(handle).st_mtime) > STALE
    return False
