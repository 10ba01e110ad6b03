"""Who is working on a store: lock files with host, process and shard; those of dead processes are taken over.

A lock file is complete, and locked by the operating system, before it gets its name. That system lock goes away with
its process however it ends, so that nobody has to guess from a process number. Across machines, where it may not
reach, a running process touches its file now and then; one that has not been touched for two minutes is taken
over. That
is safe even if its process is only asleep: two processes that compute a chunk write the same bytes.
"""

from __future__ import annotations

import json
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from threading import Event, Thread
from uuid import uuid4

from grazing.outcome import InputError

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
    """Who works on a store: ``shard`` is ``"1/3"``, or empty for all of it."""

    host: str
    pid: int
    shard: str
    since: str

    def __str__(self) -> str:
        what = f"shard {self.shard}" if self.shard else "a run of the whole sweep"
        return f"{what} (process {self.pid} on {self.host}, since {self.since})"


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
    file = folder / ("all.lock" if shard is None else f"shard-{shard[0]}-of-{shard[1]}.lock")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with _one_at_a_time(folder):
            _refuse_others(folder, me, None)
            handle = _place(file, me)
            try:
                _refuse_others(folder, me, file)  # where the system has no locks, both of two that start together stop
            except InputError:
                _release(file, handle)
                raise
    except OSError as error:
        raise InputError(
            f"{folder.parent.parent} cannot be written: {error.strerror or error}; "
            f"a sweep needs a folder that it may write to"
        ) from error
    over = Event()
    Thread(target=_touch, args=(handle, over), name="grazing-lock", daemon=True).start()
    try:
        yield
    finally:
        over.set()
        _release(file, handle)


def holders(folder: Path) -> list[Lock]:
    """Return who works on a store now."""
    return [lock for _file, lock in _living(folder)]


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


@contextmanager
def _one_at_a_time(folder: Path) -> Iterator[None]:
    """Let one process at a time look at the locks and place its own; touches the file, for the clock of the disk."""
    handle = os.open(folder / "gate", os.O_RDWR | os.O_CREAT, 0o666)
    try:
        os.write(handle, b".")
        os.ftruncate(handle, 0)
        last = time.monotonic() + PATIENCE
        while _try_lock(handle) is False and time.monotonic() < last:
            time.sleep(0.01)
        yield
    finally:
        os.close(handle)


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


def _place(file: Path, me: Lock) -> int:
    """Put our lock file in its place, already written and locked; return its handle."""
    unnamed = file.with_name(f"{uuid4().hex}.new")
    handle = os.open(unnamed, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        os.write(handle, json.dumps(asdict(me)).encode())
        _try_lock(handle)
        try:
            os.link(unnamed, file)
        except FileExistsError:  # it must be gone or dead: we have looked
            raise InputError(f"another process is starting on {file.parent.parent.parent}; try again") from None
        except OSError:  # a file system without links
            os.replace(unnamed, file)
    except BaseException:
        os.close(handle)
        raise
    finally:
        unnamed.unlink(missing_ok=True)
    _held.add(handle)
    return handle


def _release(file: Path, handle: int) -> None:
    if _is(file, handle):
        file.unlink(missing_ok=True)
    if handle in _held:  # not in a fork, which dropped it
        _held.discard(handle)
        os.close(handle)


def _is(file: Path, handle: int) -> bool:
    """Whether a name still stands for the file that we have open."""
    try:
        return os.path.samestat(os.stat(file), os.fstat(handle))
    except OSError:
        return False


def _touch(handle: int, over: Event) -> None:
    while os.utime in os.supports_fd and not over.wait(TOUCH):
        with suppress(OSError):
            os.utime(handle)


# ---- who else is there


def _refuse_others(folder: Path, me: Lock, own: Path | None) -> None:
    """Raise InputError if somebody works on the store who is no other shard of the same number; bury the dead."""
    count = me.shard.partition("/")[2]
    for file, lock in _living(folder, bury=True):
        if file == own or (me.shard and lock.shard.partition("/")[2] == count and lock.shard != me.shard):
            continue
        raise InputError(
            f"{folder.parent.parent} is being worked on by {lock}; wait until it has ended, or stop it. "
            f"Only shards of the same number work on a store together"
        )


def _living(folder: Path, bury: bool = False) -> list[tuple[Path, Lock]]:
    """Return the lock files of living processes; if asked, remove those of dead ones."""
    found = []
    for file in folder.glob("*.new") if bury else ():
        with suppress(OSError):
            if (folder / "gate").stat().st_mtime - file.stat().st_mtime > STALE:
                file.unlink()
    for file in sorted(folder.glob("*.lock")):
        try:
            handle = os.open(file, os.O_RDWR)
        except FileNotFoundError:
            continue
        except OSError:  # not ours to lock; it can still be read
            handle = os.open(file, os.O_RDONLY)
        try:
            lock = Lock(**json.loads(os.read(handle, 10_000)))
            if not _dead(folder, handle, lock):
                found.append((file, lock))
            elif bury and _is(file, handle):
                file.unlink(missing_ok=True)
        except (ValueError, TypeError):  # not written by us, or torn by a power cut
            if bury:
                file.unlink(missing_ok=True)
        finally:
            os.close(handle)
    return found


def _dead(folder: Path, handle: int, lock: Lock) -> bool:
    free = _try_lock(handle, alone=False)
    if free is False:
        return False
    if lock.host == socket.gethostname() and (free or not process_exists(lock.pid)):
        return True
    with suppress(OSError):  # by the clock of the disk, which the gate has; machines differ in theirs
        return (folder / "gate").stat().st_mtime - os.fstat(handle).st_mtime > STALE
    return False
