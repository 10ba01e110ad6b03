"""Where compiled kernels are kept, and the files that they are kept in.

What is read here is executed. So a file is opened only if nobody but its owner, who is this user or root, can write to
it; it is unpickled only if its SHA-256 fits its content and its own name, so that neither damage nor a file of another
kernel is ever taken for this one. Anything else is as good as none: the kernel is compiled again.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import stat
import tempfile
import warnings
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from grazing.kernel.prepared import folder, used
from grazing.writing import EFFECTIVE, put, remove_left

#: What a file begins with; its SHA-256 follows.
MAGIC = b"grazing kernel\n"
#: Bytes of a file beyond which it is none of ours, a hundred times the largest: it is not read.
LARGEST = 2**26


def cache_folder() -> Path | None:
    """Return the folder that compiled kernels are kept in; None where there is no place for any of them."""
    return folders()[0]


@cache
def folders() -> tuple[Path | None, Path | None]:
    """Return the folder that compiled kernels are kept in, and another one that they are read from.

    The first is ``$GRAZING_CACHE``, else the user's cache, else a temporary one, and None where no folder can be
    written. The second is the one that was chosen, if it can only be read, such as in a container or on a full disk.
    """
    home = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(home):  # which means nothing, says the standard
        home = os.path.join(os.path.expanduser("~"), ".cache")
    wanted, trusted = Path(os.environ.get("GRAZING_CACHE") or os.path.join(home, "grazing")), False
    try:
        wanted = wanted.absolute()  # so that it stays this folder when the process goes elsewhere
        if not os.environ.get("GRAZING_CACHE") and not os.path.isabs(home):
            raise OSError("this user has no home")
        wanted.parent.mkdir(parents=True, exist_ok=True)
        wanted.mkdir(mode=0o700, exist_ok=True)
        wanted = wanted.resolve()  # so that it stays this folder when a link on the way to it leads elsewhere
        reason = others_can_write(wanted)
        trusted = not reason and os.access(wanted, os.X_OK, effective_ids=EFFECTIVE)  # else no file in it can be opened
        if not reason:
            tempfile.TemporaryFile(dir=wanted).close()
            return wanted, None
    except OSError as error:
        reason = error.strerror or str(error)
    fallback, read = _private_folder(), wanted if trusted else None
    those = "they" if read is None else "those in it are used, new ones"
    instead = f"{those} go to {fallback}" if fallback else "nor in a temporary folder: every process makes its own"
    warnings.warn(
        f"compiled kernels cannot be kept in {wanted} ({reason}); {instead}. Set GRAZING_CACHE to choose",
        RuntimeWarning,
        stacklevel=3,
    )
    return fallback, read


def others_can_write(folder: Path) -> str:
    """Return how another user could put a file into a folder, or another folder in its place; empty if none can.

    Above the folder a sticky bit, as that of ``/tmp``, is as good as no permission.
    """
    if not hasattr(os, "getuid"):  # a system without such owners
        return ""
    real = folder.resolve()
    found = real.stat()
    if not _ours(found):
        return f"it belongs to user {found.st_uid}"
    if found.st_mode & 0o022:
        return "others can write to it: chmod go-w"
    for above in real.parents:
        mode = above.stat().st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return f"others can write to {above}"
    return ""


def _ours(found: os.stat_result) -> bool:
    """Say whether a file belongs to this user, or to root, who can do anything anyway."""
    return not hasattr(os, "getuid") or found.st_uid in (os.getuid(), 0)


def _private_folder() -> Path | None:
    """Return a temporary folder that nobody else can write to; None where there can be none."""
    user = os.getuid() if hasattr(os, "getuid") else "user"
    with suppress(OSError):
        folder = Path(tempfile.gettempdir()) / f"grazing-{user}"
        folder.mkdir(mode=0o700, exist_ok=True)
        linked = stat.S_ISLNK(folder.lstat().st_mode)
        if not linked and folder.is_dir() and not others_can_write(folder) and os.access(folder, os.W_OK | os.X_OK):
            return folder.resolve()
    with suppress(OSError):
        return Path(tempfile.mkdtemp(prefix="grazing-"))
    return None


class KernelFiles:
    """The files of one kernel, one for each signature that it was compiled for.

    It has the interface of numba's ``IndexDataCacheFile``, which keeps an index beside the files; this has none.

    Parameters
    ----------
    folder : path-like, optional
        None to keep nothing.
    name : str
        Different for different kernels.
    read : path-like, optional
        Another folder, which is only read.
    """

    def __init__(
        self, folder: str | os.PathLike[str] | None, name: str, read: str | os.PathLike[str] | None = None
    ) -> None:
        self._folder, self._name = None if folder is None else Path(folder), name
        self._read = None if read is None else Path(read)

    def called(self, key: Any) -> str:
        """Return the name of the file of a signature."""
        return f"{self._name}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"

    def load(self, key: Any) -> Any:
        """Return what was kept; None if nothing was, or if the file is not to be trusted, which is said."""
        found = None if self._folder is None else self._loaded(self._folder / self.called(key))
        if found is None and self._read is not None and os.access(file := self._read / self.called(key), os.R_OK):
            return self._loaded(file)
        return found

    def load_prepared(self, key: Any) -> Any:
        """Return what came with the package, which is trusted as far as the source of this function is."""
        found = self._loaded(folder() / self.called(key), os.stat(__file__))
        if found is not None:
            used.add(self.called(key))
        return found

    def _loaded(self, file: Path, source: os.stat_result | None = None) -> Any:
        """Return what a file keeps, None if it is not to be trusted: one of the cache is removed then."""
        try:
            return _opened(_read(file, source), file.name)
        except FileNotFoundError:
            return None
        except Exception as error:  # of whatever kind: a damaged file is as good as none
            kind = "compiled" if source is None else "prepared"
            said = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
            text = f"the {kind} kernel {file} cannot be used ({said}); it is compiled again"
            warnings.warn(text, RuntimeWarning, stacklevel=3)
        with suppress(OSError):
            if source is None:
                file.rmdir() if file.is_dir() and not file.is_symlink() else file.unlink()
        return None

    def save(self, key: Any, data: Any) -> None:
        """Keep a compiled kernel, and remove what killed processes have left half written."""
        from grazing.kernel.private import dumps

        if self._folder is None:
            return
        file, content = self._folder / self.called(key), dumps(data)
        remove_left(self._folder)
        put(file, MAGIC + _checksum(content, file.name) + content, 0o600)

    def flush(self) -> None:
        """Forget all that is kept of this kernel."""
        for file in () if self._folder is None else self._folder.glob(f"{self._name}.*.nbc"):
            file.unlink(missing_ok=True)


def _checksum(content: bytes, name: str) -> bytes:
    return hashlib.sha256(name.encode() + b"\0" + content).digest()


def _opened(content: bytes, name: str) -> Any:
    """Return what a file keeps, once it is known to be what was written under this name."""
    head = len(MAGIC) + hashlib.sha256().digest_size
    if content[: len(MAGIC)] != MAGIC or content[len(MAGIC) : head] != _checksum(content[head:], name):
        raise ValueError("it is damaged")
    return pickle.loads(content[head:])


def _read(file: Path, source: os.stat_result | None) -> bytes:
    """Return the bytes of a file that only this user can have written, or who could write our source as well."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    opened = os.open(file, flags)
    try:
        found = os.fstat(opened)
        if not stat.S_ISREG(found.st_mode):
            raise ValueError("it is no file")
        if found.st_size > LARGEST:
            raise ValueError(f"it is larger than {LARGEST} bytes")
        if not _ours(found) and not (source is not None and found.st_uid == source.st_uid):
            raise ValueError(f"it belongs to user {found.st_uid}")
        if hasattr(os, "getuid") and found.st_mode & 0o022 & ~(source.st_mode if source is not None else 0):
            raise ValueError("others can write to it")
        with open(opened, "rb", closefd=False) as stream:
            return stream.read()
    finally:
        os.close(opened)
