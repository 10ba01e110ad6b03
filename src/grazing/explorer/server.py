"""A server for the explorer's files, on this machine only: the page computes everything itself.

It knows the folders ``page`` and ``kernels`` and nothing else, so there is nothing to list and no way out of them. For
a reset law that could not be compiled for the browser it computes what the page calls, see
:mod:`grazing.explorer.calls`.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import stat
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from socket import SHUT_RDWR
from threading import BoundedSemaphore, Lock, Thread
from time import monotonic
from typing import Any
from urllib.parse import unquote, urlsplit

from grazing.explorer.calls import CALLS, LARGEST_CALL
from grazing.outcome import GrazingError, InputError
from grazing.paths import path_of
from grazing.writing import PARTIAL, whole_file

HOST = "127.0.0.1"
FOLDER = Path(__file__).parent
#: Connections at a time, and seconds for a request and its answer.
MOST, PATIENCE = 64, 30.0
#: Bytes of all calls at a time, from before they are read until they are answered; of a small one a share is taken.
ROOM = 4 * LARGEST_CALL
#: Bytes of a file that is looked at to see whose it is.
LARGEST = 2**22
#: Said by us and not by the machine: some name no type for modules, others a wrong one for scripts.
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".mjs": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".wasm": "application/wasm",
}


#: The type of calls and of their answers.
BYTES = "application/octet-stream"
#: What answers calls.
Answers = Callable[[bytes], bytes]
#: The folders that are served, and the file that each of them cannot do without.
PARTS = {"page": "index.html", "kernels": "kernels.json"}
#: Modules that the page of a map of the user's own never asks for.
OTHERS = ("gap", "oscillator")


def files(kernels: Path | None = None) -> dict[str, Path]:
    """Return what is served: the path of each file in an address, and the file.

    Parameters
    ----------
    kernels : Path, optional
        Folder with files that stand in for those of the same name in ``kernels``.

    Raises
    ------
    InputError
        If files are missing.
    """
    for part, needed in PARTS.items():
        if not (FOLDER / part / needed).is_file():
            raise InputError(f"{part}/{needed} is missing from {FOLDER}; install grazing again")
    found = {
        f"/{path.relative_to(FOLDER).as_posix()}": path
        for part in PARTS
        for path in sorted((FOLDER / part).iterdir())
        if path.suffix in TYPES
    }
    own = {} if kernels is None else {f"/kernels/{path.name}": path for path in sorted(kernels.iterdir())}
    for name in OTHERS if _is_of_map(own.get("/kernels/kernels.json")) else ():
        del found[f"/kernels/{name}.wasm"]
    return found | own | {"/page/": found["/page/index.html"]}


def _is_of_map(description: Path | None) -> bool:
    """Whether a description of kernels is that of a page with a map of the user's own, which shows that map alone."""
    return description is not None and bool(json.loads(description.read_bytes()).get("model", {}).get("map"))


class Handler(BaseHTTPRequestHandler):
    """Answer GET and HEAD for the files of the explorer, and POST for what the server computes."""

    server_version, sys_version = "grazing", ""
    protocol_version = "HTTP/1.1"
    server: Server

    def handle_one_request(self) -> None:
        """Answer a request, in the time that there is for it."""
        self.server.begun(self.connection)
        super().handle_one_request()

    def do_GET(self) -> None:
        """Send a file."""
        self.answer(body=True)

    def do_HEAD(self) -> None:
        """Send what would be said of a file."""
        self.answer(body=False)

    def do_POST(self) -> None:
        """Answer a call of a kernel, of a page of this server and of no other."""
        calls, size = self.server.calls, self.headers.get("Content-Length", "")
        refused = None
        if calls is None:
            refused = HTTPStatus.NOT_IMPLEMENTED
        elif not self.known() or self.headers.get("Origin", self.origin) != self.origin:
            refused = HTTPStatus.FORBIDDEN
        elif self.path != CALLS:
            refused = HTTPStatus.NOT_FOUND
        elif self.headers.get("Content-Type") != BYTES:  # a form of a page elsewhere has another one
            refused = HTTPStatus.UNSUPPORTED_MEDIA_TYPE
        elif not re.fullmatch("[0-9]{1,12}", size):
            refused = HTTPStatus.LENGTH_REQUIRED
        elif int(size) > LARGEST_CALL:
            refused = HTTPStatus.REQUEST_ENTITY_TOO_LARGE
        room = 0 if refused else max(int(size), ROOM // MOST)
        if not refused and not self.server.taken(room):
            refused = HTTPStatus.SERVICE_UNAVAILABLE
        if refused is not None or calls is None:
            self.close_connection = True  # what follows is no request
            self.send_error(refused or HTTPStatus.NOT_IMPLEMENTED)
            return
        try:
            self.compute(calls, int(size))
        finally:
            self.server.taken(-room)

    def compute(self, calls: Answers, size: int) -> None:
        """Read a call, and answer it on a processor that nobody else has until the answer is sent."""
        body = self.rfile.read(size)
        status, kind = HTTPStatus.OK, BYTES
        with self.server.computing(self.connection):
            try:
                found = calls(body)
            except (GrazingError, MemoryError) as error:
                status, kind, found = HTTPStatus.BAD_REQUEST, "text/plain; charset=utf-8", str(error).encode()
            self.server.begun(self.connection)
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(found)))
            self.send_header("X-Content-Type-Options", "nosniff")
            self.end_headers()
            self.wfile.write(found)

    def answer(self, body: bool) -> None:
        """Send a file, the way to the page, or 404."""
        if self.headers.get("Content-Length", "0") != "0" or "Transfer-Encoding" in self.headers:
            self.close_connection = True  # what follows is no request
        if not self.known():
            self.send_error(HTTPStatus.FORBIDDEN, "asked for under another name")
            return
        try:
            path = unquote(urlsplit(self.path).path)
        except ValueError:  # a host in brackets without an end
            self.send_error(HTTPStatus.BAD_REQUEST)
            return
        if path == "/":
            self.send_response(HTTPStatus.FOUND)
            self.send_header("Location", "/page/")
            self.send_header("Content-Length", "0")
            self.end_headers()
            return
        file = self.server.files.get(path)
        try:
            data = b"" if file is None else file.read_bytes()
        except OSError:  # another version is being installed
            file = None
        if file is None:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", TYPES[file.suffix])
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Cache-Control", "no-cache")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()
        if body:
            self.wfile.write(data)

    def known(self) -> bool:
        """Whether the request was sent to this machine by name: pages elsewhere cannot read through us."""
        name = self.headers.get("Host", HOST).rpartition(":")[0] or self.headers.get("Host", HOST)
        return name in (HOST, "localhost")

    @property
    def origin(self) -> str:
        """What a browser says of who asks, if that is the page of this server."""
        return f"http://{self.headers.get('Host', HOST)}"

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing: a terminal shows the address and no more."""


class Server(ThreadingHTTPServer):
    """The server; :attr:`address` is what to open."""

    daemon_threads = True
    #: Elsewhere this lets a port be used again at once; Windows would let two servers share one.
    allow_reuse_address = os.name != "nt"
    request_queue_size = MOST

    def __init__(self, port: int = 0, kernels: Path | None = None, calls: Answers | None = None) -> None:
        self.files, self.calls = files(kernels), calls
        #: When each connection began with its request, the oldest first.
        self._since: dict[Any, float] = {}
        self._one, self._room = Lock(), ROOM
        self._free = BoundedSemaphore(os.cpu_count() or 1)
        super().__init__((HOST, port), Handler)

    def begun(self, connection: Any) -> None:
        """Note that a connection waits for its next request; beyond so many the one that waits longest is closed."""
        with self._one:
            self._since.pop(connection, None)
            self._since[connection] = monotonic()
            for oldest in [*self._since][:-MOST]:
                self._close(oldest)

    @contextmanager
    def computing(self, connection: Any) -> Iterator[None]:
        """Have a processor for an answer: the time that it takes is not that of whoever asked."""
        with self._one:
            self._since.pop(connection, None)
        with self._free:
            yield

    def taken(self, room: int) -> bool:
        """Take room for a call, or give it back; whether there was as much."""
        with self._one:
            enough = room <= self._room
            self._room -= room if enough else 0
        return enough

    def service_actions(self) -> None:
        """Close connections that take too long, however often they say a letter or read one."""
        with self._one:
            for connection in [each for each, since in self._since.items() if monotonic() - since > PATIENCE]:
                self._close(connection)

    def _close(self, connection: Any) -> None:
        del self._since[connection]
        with suppress(OSError):
            connection.shutdown(SHUT_RDWR)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a connection in a thread of its own."""
        self.begun(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection that has ended."""
        with self._one:
            self._since.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: object, client_address: object) -> None:
        """Say nothing of a browser that left in the middle of an answer; anything else is shown."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]

    @property
    def address(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self.server_address[1]}/page/"


def server(port: int = 0, kernels: Path | None = None, calls: Answers | None = None) -> Server:
    """Return a server that listens; ``serve_forever`` answers.

    Parameters
    ----------
    port : int
        0 for any free one.
    kernels : Path, optional
        See :func:`files`.
    calls : callable, optional
        Computes for the page, see :class:`grazing.explorer.calls.Calls`.

    Raises
    ------
    InputError
        For a port out of range or in use.

    Examples
    --------
    >>> from grazing.explorer.server import server
    >>> with server() as ours:
    ...     ours.address.startswith("http://127.0.0.1:")
    True
    """
    if not 0 <= port <= 65535:
        raise InputError(f"port = {port}; allowed is a whole number from 0 to 65535, 0 for any free one")
    try:
        return Server(port, kernels, calls)
    except OSError as error:
        raise InputError(
            f"port {port} cannot be used ({error.strerror}); choose another one, or none for any free one"
        ) from None


def serve(port: int, opened: Callable[[str], None], kernels: Path | None = None, calls: Answers | None = None) -> None:
    """Serve until interrupted; ``opened`` is told the address once it is answered."""
    with (
        suppress(KeyboardInterrupt),
        server(port, kernels, calls) as ours,
    ):  # closed while the interrupt is on its way, not lost
        thread = Thread(target=ours.serve_forever, kwargs={"poll_interval": 0.2}, daemon=True)
        thread.start()
        try:
            opened(ours.address)
            while thread.is_alive():
                thread.join(0.5)  # without an end, some systems would not look for Ctrl-C
        finally:
            ours.shutdown()


def ours(file: Path) -> bool:
    """Whether a file is one of the explorer's, of whatever version."""
    try:
        if not stat.S_ISREG(os.lstat(file).st_mode):  # a pipe may never begin, and a device never end
            return False
        with file.open("rb") as opened:
            return b"grazing" in opened.read(LARGEST)
    except OSError:
        return False


def rooted() -> str:
    """Return the page as it stands beside its folder, and not in it."""
    text = (FOLDER / "page" / "index.html").read_text(encoding="utf-8")
    return re.sub(r'(href|src)="(?=[\w.]+\.(?:css|js|html)")', r'\1="page/', text)


def _not_complete(marks: Iterable[Path]) -> None:
    """Let a copy say that it is not complete: of two versions, its numbers would be those of neither."""
    for mark in marks:
        with whole_file(mark) as new:
            new.write_text("This copy of the grazing explorer is not complete. Make it again.\n", encoding="utf-8")


def copy_to(folder: str | Path, kernels: Path | None = None) -> Path:
    """Copy the page and its kernels to a folder, for any web server; return the page, at its root.

    A copy that is there already is renewed, or stays if it cannot be; other files in the folder stay.

    Raises
    ------
    InputError
        If the folder cannot be written to, or holds an ``index.html``, ``page`` or ``kernels`` of somebody else.
    """
    source, to = files(kernels), path_of(folder)
    root = to / PARTS["page"]
    marks = [root, *(to / part / needed for part, needed in PARTS.items())]  # by which a copy is known
    goals = {to / name.lstrip("/"): path for name, path in source.items() if not name.endswith("/")}
    try:
        for there, mark in zip((root, *(to / part for part in PARTS)), marks, strict=True):
            if os.path.isdir(there):
                taken = not all(PARTIAL.fullmatch(each.name) for each in there.iterdir())
            else:
                taken = os.path.exists(there)
            if os.path.islink(there) or (taken and not ours(mark)):
                raise InputError(f"{there} is there and not a copy of the explorer; choose another folder")
        for goal, path in goals.items():
            goal.parent.mkdir(parents=True, exist_ok=True)
            if os.path.exists(goal) and not os.path.islink(goal) and goal.samefile(path):
                raise shutil.SameFileError("its page is the same file")
        _not_complete(mark for mark in marks if not mark.exists())
        with ExitStack() as stack:  # all is written before any of it gets its name; the marks get theirs last
            stack.enter_context(whole_file(root)).write_text(rooted(), encoding="utf-8", newline="\n")
            for goal in sorted(goals, key=lambda goal: goal not in marks):
                shutil.copyfile(goals[goal], stack.enter_context(whole_file(goal)))
            _not_complete(marks)
    except OSError as error:
        raise InputError(
            f"cannot write to {folder}: {error.strerror or error}; choose a folder that can be made and written to"
        ) from None
    return root
