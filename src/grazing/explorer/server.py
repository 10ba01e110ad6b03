"""A server for the explorer's files, on this machine only: the page computes everything itself.

It knows the folders ``page`` and ``kernels`` and nothing else, so there is nothing to list and no way out of them.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urlsplit

from grazing.outcome import InputError

HOST = "127.0.0.1"
FOLDER = Path(__file__).parent
#: Said by us and not by the machine: some name no type for modules, others a wrong one for scripts.
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".mjs": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".wasm": "application/wasm",
}


def files() -> dict[str, Path]:
    """Return what is served: the path of each file in an address, and the file."""
    found = {
        f"/{path.relative_to(FOLDER).as_posix()}": path
        for part in ("page", "kernels")
        for path in sorted((FOLDER / part).iterdir())
        if path.suffix in TYPES
    }
    return found | {"/page/": found["/page/index.html"]}


class Handler(BaseHTTPRequestHandler):
    """Answer GET and HEAD for the files of the explorer."""

    server_version, sys_version = "grazing", ""
    protocol_version = "HTTP/1.1"
    #: Seconds after which a connection that says nothing is closed.
    timeout = 30

    def do_GET(self) -> None:
        """Send a file."""
        self.answer(body=True)

    def do_HEAD(self) -> None:
        """Send what would be said of a file."""
        self.answer(body=False)

    def answer(self, body: bool) -> None:
        """Send a file, the way to the page, or 404."""
        if not self.ours():
            self.send_error(HTTPStatus.FORBIDDEN, "asked for under another name")
            return
        path = unquote(urlsplit(self.path).path)
        if path == "/":
            self.send_response(HTTPStatus.FOUND)
            self.send_header("Location", "/page/")
            self.send_header("Content-Length", "0")
            self.end_headers()
            return
        file = self.server.files.get(path)  # type: ignore[attr-defined]
        if file is None:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        data = file.read_bytes()
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", TYPES[file.suffix])
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Cache-Control", "no-cache")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()
        if body:
            self.wfile.write(data)

    def ours(self) -> bool:
        """Whether the request was sent to this machine by name: pages elsewhere cannot read through us."""
        name = self.headers.get("Host", HOST).rpartition(":")[0] or self.headers.get("Host", HOST)
        return name in (HOST, "localhost")

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing: a terminal shows the address and no more."""


class Server(ThreadingHTTPServer):
    """The server; :attr:`address` is what to open."""

    daemon_threads = True

    def __init__(self, port: int = 0) -> None:
        self.files = files()
        super().__init__((HOST, port), Handler)

    @property
    def address(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self.server_address[1]}/page/"


def server(port: int = 0) -> Server:
    """Return a server that listens; ``serve_forever`` answers.

    Parameters
    ----------
    port : int
        0 for any free one.

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
        return Server(port)
    except OSError as error:
        raise InputError(
            f"port {port} cannot be used ({error.strerror}); choose another one, or none for any free one"
        ) from None


def serve(port: int, opened: Callable[[str], None]) -> None:
    """Serve until interrupted; ``opened`` is told the address."""
    with server(port) as ours:
        opened(ours.address)
        try:
            ours.serve_forever(poll_interval=0.2)
        except KeyboardInterrupt:
            return


def copy_to(folder: Path) -> Path:
    """Copy the page and its kernels to a folder, for any web server; return the page.

    Raises
    ------
    InputError
        If the folder cannot be written to.
    """
    try:
        for name, path in files().items():
            if not name.endswith("/"):
                goal = folder / name.lstrip("/")
                goal.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, goal)
    except OSError as error:
        raise InputError(f"cannot write to {folder}: {error.strerror}; choose a folder that can be made") from None
    return folder / "page" / "index.html"
