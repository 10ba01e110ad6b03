"""The server of the explorer: its files and no others, with the right types, and an end."""

import http.client
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import webbrowser
from contextlib import closing, suppress
from errno import ENOSPC

import pytest

from grazing.explorer.server import FOLDER, HOST, TYPES, copy_to, files, rooted, serve, server
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
    assert page == tmp_path / "site" / "index.html"
    inner = (FOLDER / "page" / "index.html").read_text(encoding="utf-8")
    named = re.findall(r'(?:href|src)="([\w./]+)"', page.read_text(encoding="utf-8"))
    assert named == [f"page/{name}" for name in re.findall(r'(?:href|src)="([\w./]+)"', inner)]
    assert all((page.parent / name).is_file() for name in named)
    copied = {f"/{path.relative_to(page.parent).as_posix()}" for path in page.parent.rglob("*.*")}
    assert copied == files().keys() - {"/page/"} | {"/index.html"}


def test_a_copy_with_a_map_of_ones_own_has_that_module_and_the_table(tmp_path):
    own = tmp_path / "own"
    own.mkdir()
    (own / "map.wasm").write_bytes(b"")
    for model, others in (
        ({"map": "mine"}, set()),
        ({"law": "soft"}, {"/kernels/gap.wasm", "/kernels/oscillator.wasm"}),
    ):
        (own / "kernels.json").write_text(json.dumps({"model": model}))
        modules = {name for name in files(own) if name.endswith(".wasm")}
        assert modules == {"/kernels/map.wasm", "/kernels/table.wasm"} | others


def test_a_copy_is_renewed_and_other_files_stay(tmp_path):
    (tmp_path / "own.html").write_text("mine")
    page = copy_to(tmp_path)
    page.write_text("an older grazing explorer")
    (tmp_path / "page" / "gone.js").write_text("")
    assert copy_to(tmp_path).read_text(encoding="utf-8") == rooted()
    assert (tmp_path / "own.html").read_text() == "mine"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="POSIX links and pipes")
@pytest.mark.parametrize("kind", ["file", "hard", "folder", "pipe", "device"])
def test_a_copy_goes_through_no_link_and_waits_for_no_pipe(tmp_path, kind):
    """A folder that somebody handed over: its links lead to what is precious, its page is a pipe."""
    precious, site = tmp_path / "precious", tmp_path / "site"
    copy_to(site)
    precious.mkdir()
    (precious / "file").write_text("precious")
    goal = site / "page" / "main.js"
    if kind in ("file", "hard"):
        goal.unlink()
        goal.symlink_to(precious / "file") if kind == "file" else os.link(precious / "file", goal)
        copy_to(site)
        assert goal.read_bytes() == (FOLDER / "page" / "main.js").read_bytes()
    else:
        if kind == "folder":
            (site / "page").rename(precious / "page")
            (site / "page").symlink_to(precious / "page")
        else:
            (site / "page" / "index.html").unlink()
            os.mkfifo(site / "page" / "index.html") if kind == "pipe" else (site / "page" / "index.html").symlink_to(
                "/dev/zero"
            )
        with pytest.raises(InputError, match="not a copy of the explorer"):
            copy_to(site)
    assert (precious / "file").read_text() == "precious"


def test_a_copy_that_was_interrupted_is_completed(monkeypatch, tmp_path):
    def copied(path, goal):
        if path.suffix == ".js":
            raise KeyboardInterrupt
        goal.write_bytes(path.read_bytes())

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr("grazing.explorer.server.shutil.copyfile", copied)
        copy_to(tmp_path)
    copy_to(tmp_path)
    assert all((tmp_path / name.lstrip("/")).exists() for name in files() if not name.endswith("/"))


def test_a_copy_that_another_process_has_just_begun_is_no_other_site(tmp_path):
    (tmp_path / "kernels").mkdir()
    (tmp_path / "kernels" / f".{'0' * 32}.partial").touch()
    assert copy_to(tmp_path).read_text(encoding="utf-8") == rooted()


def test_a_copy_on_a_full_disk_stays_the_older_one(monkeypatch, tmp_path):
    """Half renewed, it had the description of one law beside the kernels of another."""
    page = copy_to(tmp_path)
    for file in (page, tmp_path / "page" / "main.js", tmp_path / "kernels" / "oscillator.wasm"):
        file.write_text("an older grazing explorer")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.*")}

    def copied(path, goal):
        if path.name == "table.wasm":
            raise OSError(ENOSPC, "No space left on device")
        goal.write_bytes(path.read_bytes())

    monkeypatch.setattr("grazing.explorer.server.shutil.copyfile", copied)
    with pytest.raises(InputError, match="No space left on device"):
        copy_to(tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*.*")} == before


@pytest.mark.parametrize("count", [1, 2, 3, 4, 30])
def test_a_copy_that_is_killed_says_that_it_is_not_complete(monkeypatch, tmp_path, count):
    copy_to(tmp_path)
    (tmp_path / "kernels" / "oscillator.wasm").write_bytes(b"older")
    replace, left = os.replace, iter(range(count))

    def replaced(*given):
        if next(left, None) is None:
            raise KeyboardInterrupt
        replace(*given)

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr("grazing.writing.os.replace", replaced)
        copy_to(tmp_path)
    marks = [tmp_path / name for name in ("index.html", "page/index.html", "kernels/kernels.json")]
    assert sum("not complete" in mark.read_text(encoding="utf-8") for mark in marks) == min(count, 3)
    copy_to(tmp_path)
    assert not any("not complete" in mark.read_text(encoding="utf-8") for mark in marks)
    assert (tmp_path / "kernels" / "oscillator.wasm").read_bytes() != b"older"


@pytest.mark.parametrize(
    ("part", "made"),
    [
        ("page", "file"),
        ("page", "site"),
        ("kernels", "file"),
        ("kernels", "site"),
        ("index.html", "file"),
        ("index.html", "link"),
    ],
)
def test_a_folder_of_somebody_else_is_not_written_to(tmp_path, part, made):
    if made == "file":
        (tmp_path / part).write_text("")
    elif made == "link":
        (tmp_path / "grazing").write_text("grazing")
        (tmp_path / part).symlink_to(tmp_path / "grazing")
    else:
        (tmp_path / part).mkdir()
        (tmp_path / part / "index.html").write_text("<title>Another site</title>")
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InputError, match=r"is there and not a copy of the explorer; choose another folder"):
        copy_to(tmp_path)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_copy_onto_itself():
    with pytest.raises(InputError, match=r"cannot write to .*same file"):
        copy_to(FOLDER)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="who may do everything may write here too")
def test_a_copy_into_a_folder_that_may_only_be_read(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match=r"cannot write to .*Permission denied; choose a folder"):
        copy_to(tmp_path / "site")


@pytest.mark.parametrize("out", ["", " "])
def test_a_copy_to_no_folder(out):
    from grazing.cli.explore import explore

    with pytest.raises(InputError, match=r"--out names no folder; give one"):
        explore(out=out)


def test_missing_files_are_named(monkeypatch, tmp_path):
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "index.html").write_text("")
    monkeypatch.setattr("grazing.explorer.server.FOLDER", tmp_path)
    with pytest.raises(InputError, match=r"kernels/kernels\.json is missing from .*install grazing again"):
        server()


def test_a_browser_that_leaves_in_the_middle_is_not_worth_a_word(running, capfd):
    for _ in range(5):
        with socket.create_connection(running.server_address[:2]) as leaving:
            leaving.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # a reset, not an end
            leaving.sendall(b"GET /kernels/oscillator.wasm HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    assert asked(running, "/page/")[0] == 200
    assert capfd.readouterr() == ("", "")


def test_whatever_is_sent_is_answered_or_dropped_and_nothing_is_said(running, capfd):
    """Lines from the edges of what a request can be: the terminal stays as it is, and the server answers."""
    targets = [
        "http://[::1", "http://[", "//[", "http://]/", "http://a:b/", "http://[v1.x]/", "http://[::1]/page/", "%",
        "%zz", "/%ff%fe", "/page/%00", "/../../etc/passwd", "*", "\\\\a", "/page/" + "a" * 60_000, "/" + "a" * 70_000,
        "/\u00e9", "", " ", "/page/?" + "&" * 5000, "/#", "?", ";", "http://\u2100/",
        "/page/index.html HTTP/9.9", "/ HTTP/1.1 x",
    ]  # fmt: skip
    lines = [f"GET {target} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n" for target in targets]
    lines += [
        "GET / HTTP/1.1\r\nHost: [\r\n\r\n", "GET / HTTP/1.1\r\nHost: \u00e9:\u00e9\r\nConnection: close\r\n\r\n",
        "\r\n\r\n", "GET\r\n\r\n", "\x00\x01\x02\r\n\r\n", "GET / HTTP/1.1\r\n" + "A: b\r\n" * 300 + "\r\n",
        "GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\nConnection: close\r\n\r\n",
        "GET / HTTP/1.1\r\n" + "A" * 70_000 + ": b\r\n\r\n", "GET / HTTP/1.1\r\n: \r\n\r\n",
    ]  # fmt: skip
    for line in lines:
        with socket.create_connection(running.server_address[:2], timeout=10) as asking:
            try:
                asking.sendall(line.encode("utf-8"))
                asking.shutdown(socket.SHUT_WR)
                while asking.recv(65536):
                    pass
            except ConnectionError:
                pass
    assert asked(running, "/page/")[0] == 200
    told = capfd.readouterr()
    assert (told.out, told.err) == ("", "")


PAGE = b"GET /page/ HTTP/1.1\r\nHost: localhost\r\n\r\n"


def closed_within(seconds, connection, say):
    """Whether the server closes a connection on which something is said again and again."""
    end = time.monotonic() + seconds
    connection.settimeout(0.05)
    while time.monotonic() < end:
        try:
            connection.sendall(say)
            if say == b"x" and not connection.recv(1):
                return True
        except TimeoutError:
            continue
        except OSError:
            return True
    return False


@pytest.mark.parametrize("say", [b"x", PAGE], ids=["writes a letter now and then", "reads nothing"])
def test_who_is_slow_on_purpose_is_not_served_for_ever(running, monkeypatch, capfd, say):
    monkeypatch.setattr("grazing.explorer.server.PATIENCE", 0.5)
    with socket.create_connection(running.server_address[:2]) as slow:
        if say == b"x":
            slow.sendall(b"GET /")
        assert closed_within(15.0, slow, say)
    monkeypatch.undo()
    assert asked(running, "/page/")[0] == 200 and capfd.readouterr() == ("", "")


def test_who_asks_again_and_again_keeps_the_connection(running, monkeypatch):
    monkeypatch.setattr("grazing.explorer.server.PATIENCE", 1.5)
    connection = http.client.HTTPConnection(*running.server_address[:2], timeout=10)
    connection.connect()
    first = connection.sock
    for _ in range(5):
        connection.request("GET", "/page/main.js")
        assert connection.getresponse().read() and connection.sock is first
        time.sleep(0.5)
    connection.close()


def test_many_who_say_nothing_leave_room_for_the_page(running):
    held = [socket.create_connection(running.server_address[:2], timeout=10) for _ in range(150)]
    for each in held:
        with suppress(OSError):
            each.sendall(b"GET /page/ HT")
    assert asked(running, "/page/")[0] == 200
    for _ in range(100):
        if threading.active_count() < 90:
            break
        time.sleep(0.1)
    assert threading.active_count() < 90
    for each in held:
        each.close()


@pytest.mark.parametrize("size, most", [(1, 64), (2**25, 8)])
def test_calls_that_wait_for_a_processor_hold_no_more_than_there_is_room_for(size, most):
    """Whoever asks without an end is told that there is no room, the page is sent, and the room is free again."""
    slow = threading.Event()

    def answered(call):
        slow.wait(30)
        return call[:1]

    with server(calls=answered) as ours:
        threading.Thread(target=ours.serve_forever, daemon=True).start()
        head = "POST /calls/own HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/octet-stream\r\n"
        held = [socket.create_connection(ours.server_address[:2], timeout=10) for _ in range(most)]
        for each in held:
            each.sendall(f"{head}Content-Length: {size}\r\n\r\n".encode() + b"x")
        for _ in range(100):
            if ours._room == 0:
                break
            time.sleep(0.1)
        connection = http.client.HTTPConnection(*ours.server_address[:2], timeout=10)
        connection.request("POST", "/calls/own", b"x", {"Content-Type": "application/octet-stream"})
        assert connection.getresponse().status == 503
        assert asked(ours, "/page/")[0] == 200
        slow.set()
        for each in held:
            each.shutdown(socket.SHUT_WR)
            assert each.recv(12) == b"HTTP/1.1 200"
            each.close()
        connection.request("POST", "/calls/own", b"x", {"Content-Type": "application/octet-stream"})
        assert connection.getresponse().read() == b"x"
        connection.close()
        ours.shutdown()


@pytest.mark.parametrize(
    "how", [b"Content-Length: %d\r\n\r\n%s", b"Transfer-Encoding: chunked\r\n\r\n%x\r\n%s\r\n0\r\n\r\n"]
)
def test_a_body_is_not_taken_for_the_next_request(running, how):
    with socket.create_connection(running.server_address[:2], timeout=10) as asking:
        asking.sendall(PAGE[:-2] + how % (len(PAGE), PAGE))
        said = b""
        with suppress(ConnectionError):
            while part := asking.recv(65536):
                said += part
    assert said.count(b"HTTP/1.1 ") == 1


def test_a_file_that_went_away_is_not_found_and_nothing_is_said(running, capfd, monkeypatch):
    monkeypatch.setitem(running.files, "/page/gone.js", FOLDER / "page" / "gone.js")
    assert asked(running, "/page/gone.js")[0] == 404
    assert capfd.readouterr() == ("", "")


def test_two_at_once_have_their_own_ports(running):
    with server() as other:
        assert other.address != running.address


class Browser:
    """Stands for a browser with a window."""

    def __init__(self, answered):
        self.answered = answered

    def open(self, address):
        return self.answered


@pytest.mark.parametrize(
    ("browser", "chosen", "answered"),
    [
        (Browser(True), "", True),
        (Browser(False), "", False),
        (webbrowser.GenericBrowser("true"), "", False),  # in the terminal
        (webbrowser.GenericBrowser("true"), "true", True),  # what the user named is taken
        (None, "", False),
    ],
)
def test_only_browsers_with_windows_are_opened(monkeypatch, browser, chosen, answered):
    from grazing.cli.explore import in_browser

    def get():
        if browser is None:
            raise webbrowser.Error("none")
        return browser

    monkeypatch.setattr(webbrowser, "get", get)
    monkeypatch.setattr(webbrowser, "open", lambda address: browser.open(address))
    monkeypatch.setenv("BROWSER", chosen)
    assert in_browser("http://127.0.0.1:1/page/") is answered


def test_the_address_is_answered_when_it_is_told(capfd):
    """A browser that holds up the command until it has the page does get it."""
    statuses = []

    def opened(address):
        connection = http.client.HTTPConnection(HOST, int(address.split(":")[2].partition("/")[0]), timeout=10)
        connection.request("GET", "/page/")
        statuses.append(connection.getresponse().status)
        connection.close()
        raise KeyboardInterrupt  # Ctrl-C at that moment

    serve(0, opened)
    assert statuses == [200] and capfd.readouterr() == ("", "")


def test_a_copy_where_nothing_can_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot write to .*choose a folder"):
        copy_to(tmp_path / "file")


RUN = "import sys; sys.argv[1:] = ['explore', '--no-open']; from grazing.__main__ import main; sys.exit(main())"


@pytest.mark.skipif(os.name != "posix", reason="sends the signal of Ctrl-C, which other systems name otherwise")
def test_the_command_says_its_address_and_ends_when_interrupted():
    settings = {**os.environ, "PYTHONPATH": str(FOLDER.parents[1])}
    command = [sys.executable, "-c", RUN]
    with subprocess.Popen(command, env=settings, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        try:
            line = run.stdout.readline()
            assert line.startswith("explorer at http://127.0.0.1:")
            port = int(line.split(":")[2].partition("/")[0])
            with closing(http.client.HTTPConnection(HOST, port, timeout=10)) as connection:
                connection.request("GET", "/page/")
                assert connection.getresponse().status == 200
                run.send_signal(signal.SIGINT)
                out, err = run.communicate(timeout=20)
            assert (run.returncode, out, err) == (0, "", "")
        finally:
            run.kill()  # else whoever does not end is waited for without an end
