"""The server of the explorer: its files and no others, with the right types, and an end."""

import http.client
import os
import signal
import socket
import subprocess
import sys
import threading

import pytest

from grazing.explorer.server import FOLDER, HOST, TYPES, copy_to, files, server
from grazing.outcome import InputError


@pytest.fixture(scope="module")
def running():
    with server() as ours:
        thread = threading.Thread(target=ours.serve_forever, kwargs={"poll_interval": 0.05})
        thread.start()
        yield ours
        ours.shutdown()
        thread.join()


def asked(running, path, method="GET", **headers):
    connection = http.client.HTTPConnection(*running.server_address[:2], timeout=10)
    try:
        connection.putrequest(method, path, skip_host="Host" in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, dict(answer.getheaders()), answer.read()
    finally:
        connection.close()


def test_it_listens_on_this_machine_only(running):
    assert running.server_address[0] == HOST == "127.0.0.1"
    assert running.address == f"http://127.0.0.1:{running.server_address[1]}/page/"


@pytest.mark.parametrize("path", sorted(files()))
def test_every_file_has_its_type_and_its_bytes(running, path):
    file = files()[path]
    status, headers, body = asked(running, path)
    assert status == 200 and body == file.read_bytes()
    assert headers["Content-Type"] == TYPES[file.suffix]
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert int(headers["Content-Length"]) == len(body)


def test_types_that_browsers_insist_on():
    assert TYPES[".wasm"] == "application/wasm"
    assert TYPES[".mjs"].startswith("text/javascript") and TYPES[".js"].startswith("text/javascript")


def test_the_root_leads_to_the_page(running):
    status, headers, body = asked(running, "/")
    assert (status, headers["Location"], body) == (302, "/page/", b"")


def test_a_query_does_not_matter(running):
    assert asked(running, "/page/main.js?x=1")[0] == 200


@pytest.mark.parametrize(
    "path",
    [
        "/page/../server.py", "/page/%2e%2e/server.py", "/../../../../etc/passwd", "//etc/passwd", "/%2fetc%2fpasswd",
        "/page/..%5cserver.py", "/server.py", "/kernels", "/kernels/", "/page", "/page/none.js", "/page/main.js/",
        "/page/main.js%00.html", "/__init__.py",
    ],
)  # fmt: skip
def test_nothing_else_is_there(running, path):
    status, _headers, body = asked(running, path)
    assert status == 404
    assert b"InputError" not in body and b"root:" not in body and b"gap.wasm" not in body


def test_head_says_the_same_and_sends_nothing(running):
    status, headers, body = asked(running, "/kernels/gap.wasm", "HEAD")
    assert (status, body) == (200, b"")
    assert int(headers["Content-Length"]) == (FOLDER / "kernels" / "gap.wasm").stat().st_size


def test_nothing_can_be_sent(running):
    assert asked(running, "/page/", "POST")[0] == 501


def test_a_page_elsewhere_cannot_ask_under_its_own_name(running):
    assert asked(running, "/page/", Host="example.org")[0] == 403
    assert asked(running, "/page/", Host=f"localhost:{running.server_address[1]}")[0] == 200


@pytest.mark.parametrize("port", [-1, 65536])
def test_a_port_out_of_range(port):
    with pytest.raises(InputError, match=rf"port = {port}; allowed is a whole number from 0 to 65535"):
        server(port)


def test_a_port_in_use():
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        with pytest.raises(InputError, match=r"cannot be used .*choose another one"):
            server(taken.getsockname()[1])


def test_a_copy_for_any_server(tmp_path):
    page = copy_to(tmp_path / "site")
    assert page.read_bytes() == (FOLDER / "page" / "index.html").read_bytes()
    copied = {f"/{path.relative_to(tmp_path / 'site').as_posix()}" for path in page.parents[1].rglob("*.*")}
    assert copied == files().keys() - {"/page/"}


def test_a_copy_where_nothing_can_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot write to .*choose a folder"):
        copy_to(tmp_path / "file")


RUN = "from grazing.cli.explore import explore; raise SystemExit(explore(no_open=True))"


@pytest.mark.skipif(os.name != "posix", reason="sends the signal of Ctrl-C, which other systems name otherwise")
def test_the_command_says_its_address_and_ends_when_interrupted():
    settings = {**os.environ, "PYTHONPATH": str(FOLDER.parents[1])}
    command = [sys.executable, "-c", RUN]
    with subprocess.Popen(command, env=settings, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        line = run.stdout.readline()
        assert line.startswith("explorer at http://127.0.0.1:")
        port = int(line.split(":")[2].partition("/")[0])
        connection = http.client.HTTPConnection(HOST, port, timeout=10)
        connection.request("GET", "/page/")
        assert connection.getresponse().status == 200
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=20)
        assert (run.returncode, out, err) == (0, "", "")
        connection.close()
