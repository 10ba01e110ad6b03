"""The command line as a process: start-up, streams that fail, terminals, locales, interruption."""

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import grazing

SOURCE = Path(__file__).parents[2] / "src"
HEAVY = {"numba", "llvmlite", "numpy", "scipy", "xarray", "pandas", "matplotlib", "flint", "pydantic", "zarr", "dask"}
# A stand-in for the report, put in place before the command line starts.
PRELUDE = """
import sys, time, types
module = types.ModuleType("grazing.paper.report")
def report(out, figures, size, progress):
    for i in range(3):
        progress(i + 1, 3, "Figure [1.6] \\u03bc")
        time.sleep({pause})
    return dict(folder="\\u03bb", figures=["1.6"], files=["index.html"], claims=1, differs=[],
                verdicts=dict(agrees=1, corrected=0, differs=0))
module.report = report
sys.modules["grazing.paper.report"] = module
from grazing.cli import main
raise SystemExit(main(sys.argv[1:]))
"""


def command(*tokens, pause=0.0):
    return [sys.executable, "-c", PRELUDE.format(pause=pause), *tokens]


def settings(**changes):
    kept = {name: value for name, value in os.environ.items() if name not in ("LC_ALL", "LANG", "NO_COLOR", "TERM")}
    return kept | {"PYTHONPATH": str(SOURCE)} | changes


def run(*tokens, env=None, **options):
    return subprocess.run(command(*tokens), env=env or settings(), capture_output=True, text=True, **options)


# ---- start-up


@pytest.mark.parametrize("tokens", [[], ["--help"], ["--version"], ["paper", "--help"], ["papr"]])
def test_help_and_version_load_nothing_heavy(tokens):
    code = f"import sys; from grazing.cli import main; main({tokens!r}); print('modules:', *sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], env=settings(), capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in done.stdout.rpartition("modules:")[2].split()}
    assert "cyclopts" in loaded
    assert loaded.isdisjoint(HEAVY)


def test_it_runs_as_a_module_from_any_folder(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "grazing", "--version"], cwd=tmp_path, env=settings(), capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, f"grazing {grazing.__version__}\n")


@pytest.mark.parametrize("where", ["mine", "cyclopts"])
def test_an_interrupt_in_code_that_python_was_given_as_text_ends_with_its_exit_code(tmp_path, where):
    """As while a named tuple is made: Python would end by the signal, although the interrupt was caught."""
    (tmp_path / f"{where}.py").write_text("exec('raise KeyboardInterrupt')\n")
    given = ["diagram", "a=0:1:3", "--map", "mine.py:P", "-o", "a.nc"]
    env = settings(PYTHONPATH=os.pathsep.join([str(tmp_path), str(SOURCE)]))
    done = subprocess.run(
        [sys.executable, "-m", "grazing", *given], cwd=tmp_path, env=env, capture_output=True, text=True
    )
    assert done.returncode == 130 and "stopped: interrupted" in done.stderr


def interrupted(folder):
    """Run the command line with packages of a folder; Ctrl-C reaches it, as it does not in the background."""
    ours = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)"
    return subprocess.run(
        [sys.executable, "-c", f"{ours}; from grazing.__main__ import main; sys.exit(main())"],
        cwd=folder, env=settings(), capture_output=True, text=True,
    )  # fmt: skip


def test_an_interrupt_while_packages_are_imported_is_no_traceback(tmp_path):
    (tmp_path / "cyclopts.py").write_text("raise KeyboardInterrupt")
    done = interrupted(tmp_path)
    assert (done.returncode, done.stderr) == (130, "stopped: interrupted.\n")


@pytest.mark.parametrize(
    "lost",
    [
        "class Ended:\n    def __del__(self):\n        signal.raise_signal(signal.SIGINT)\nEnded()",
        "try:\n    signal.raise_signal(signal.SIGINT)\nexcept BaseException:\n    pass",  # as packages in C do
    ],
)
def test_an_interrupt_that_python_or_a_package_drops_is_not_lost(lost, tmp_path):
    """The command went on as if nobody had stopped it."""
    (tmp_path / "cyclopts.py").write_text(f"import signal, time\n{lost}\ntime.sleep(20)\n")
    started = time.monotonic()
    done = interrupted(tmp_path)
    assert (done.returncode, done.stderr) == (130, "stopped: interrupted.\n")
    assert time.monotonic() - started < 15


def test_an_interrupt_that_takes_long_to_end_a_command_comes_once(tmp_path):
    """What is put in order on the way is not interrupted again."""
    slow = "try:\n    signal.raise_signal(signal.SIGINT)\nfinally:\n    time.sleep(0.3)\n    print('in order')\n"
    (tmp_path / "cyclopts.py").write_text(f"import signal, time\n{slow}")
    done = interrupted(tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (130, "in order\n", "stopped: interrupted.\n")


def test_an_interrupt_in_the_making_of_a_class_is_no_traceback(tmp_path):
    """Python says of it that a name cannot be set."""
    named = "class Named:\n    def __set_name__(self, owner, name):\n        raise KeyboardInterrupt\n"
    (tmp_path / "cyclopts.py").write_text(f"{named}class Owner:\n    name = Named()\n")
    done = interrupted(tmp_path)
    assert (done.returncode, done.stderr) == (130, "stopped: interrupted.\n")


# ---- streams


@pytest.mark.parametrize("language", [{"LC_ALL": "C"}, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
                                      {"PYTHONIOENCODING": "ascii"}])  # fmt: skip
def test_letters_that_a_locale_lacks_are_escaped(language):
    done = run("paper", env=settings(**language))
    assert done.returncode == 0, done.stderr
    assert "agree: 1" in done.stdout and "index.html" in done.stdout
    assert "Figure [1.6]" in done.stderr
    assert run("paper", "--help", env=settings(**language)).returncode == 0


@pytest.mark.parametrize(
    "tokens", [["paper", "-q"], ["paper", "-q", "--json"], ["paper", "--help"], ["--help"], ["chart", "--help"], []]
)
def test_a_reader_that_left_is_no_failure(tokens):
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(command(*tokens), env=settings(), stdout=writing, stderr=subprocess.PIPE, text=True)
    os.close(writing)
    assert "Traceback" not in done.stderr and "Exception ignored" not in done.stderr
    assert done.returncode == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a Linux device")
def test_a_full_disk_is_a_failure():
    with open("/dev/full", "w") as full:
        done = subprocess.run(command("paper", "-q"), env=settings(), stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert "No space left" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.skipif(os.name != "posix", reason="needs a POSIX shell")
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_closed_streams_are_no_failure(closed):
    line = [f'exec "$@" {closed}', "sh", *command("paper")]
    done = subprocess.run(["sh", "-c", *line], env=settings(), capture_output=True, text=True)
    assert done.returncode == 0
    assert "Traceback" not in done.stderr


# ---- terminals


def on_a_terminal(*tokens, pause=0.0, interrupt=False, **changes):
    """Run with stderr on a terminal; return (exit code, stdout, what the terminal got)."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        command(*tokens, pause=pause), env=settings(**{"TERM": "xterm-256color"} | changes),
        stdout=subprocess.PIPE, stderr=theirs, stdin=theirs,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    os.close(theirs)
    shown = b""
    while True:
        ready, _, _ = select.select([ours], [], [], 30)
        try:
            piece = os.read(ours, 65536) if ready else b""
        except OSError:
            piece = b""
        if not piece:
            break
        shown += piece
        if interrupt and b"1/3" in shown:
            process.send_signal(signal.SIGINT)
            interrupt = False
    out = process.communicate(timeout=30)[0].decode()
    os.close(ours)
    return process.returncode, out, shown.decode()


def test_a_terminal_gets_a_bar_that_goes_away():
    code, out, shown = on_a_terminal("paper", "--json", pause=0.2)
    assert code == 0
    assert json.loads(out)["folder"] == "λ"
    assert "━" in shown and "Figure [1.6]" in shown
    assert "\x1b[2K" in shown  # the line is erased


def test_no_color_is_honoured():
    colours = re.compile(r"\x1b\[[0-9;]*3[0-9](;[0-9;]*)?m")
    assert colours.search(on_a_terminal("paper", pause=0.2)[2])
    assert not colours.search(on_a_terminal("paper", pause=0.2, NO_COLOR="1")[2])


@pytest.mark.parametrize("terminal", ["dumb", ""])
def test_a_dumb_terminal_gets_lines(terminal):
    _code, _out, shown = on_a_terminal("paper", TERM=terminal)
    assert "\x1b" not in shown
    assert shown.count("\n") == 3


def test_interruption_on_a_terminal():
    start = time.monotonic()
    code, out, shown = on_a_terminal("paper", pause=5.0, interrupt=True)
    assert time.monotonic() - start < 14.0
    assert code == 130
    assert not out
    assert "stopped: interrupted" in shown and "Traceback" not in shown


def test_no_terminal_gets_plain_lines():
    done = run("paper")
    assert [line[:5] for line in done.stderr.splitlines()] == ["[1/3]", "[2/3]", "[3/3]"]
    assert "\x1b" not in done.stderr + done.stdout


TAKEN = ("numpy", "html", "tomllib", "cyclopts", "json", "shlex", "typing", "re", "enum", "pathlib", "urllib")


def unsafe():
    return {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"} | {"PYTHONPATH": str(SOURCE)}


@pytest.mark.parametrize("called", [["-m", "grazing"], ["-mgrazing"]])
def test_a_file_beside_that_is_called_as_a_package_is_not_run(tmp_path, called):
    """Python looks for packages in the folder where -m was said: a file there was run by whatever only reads."""
    for name in TAKEN:
        (tmp_path / f"{name}.py").write_text("open('ran', 'a').write(__name__)\nraise SystemExit(7)\n")
    (tmp_path / "a.toml").write_text('study = "diagram"\nvary.d = "0:1:3"\n')
    env, asked = unsafe(), [sys.executable, *called]
    found = subprocess.run(
        [*asked, "info", "a.toml"], cwd=tmp_path, env=env, capture_output=True, text=True, timeout=60
    )
    assert not (tmp_path / "ran").exists() and found.returncode == 0, found.stderr
    assert found.stdout.startswith("a.toml: configuration")
    at_home = subprocess.run([*asked, "--version"], cwd=SOURCE, env=env, capture_output=True, timeout=60)
    assert at_home.returncode == 0


@pytest.mark.parametrize("called", [["-m", "grazing.prepare"], ["-Bmgrazing.prepare"], ["-mgrazing.explorer.build"]])
def test_nor_by_a_module_of_the_package(tmp_path, called):
    for name in TAKEN:
        (tmp_path / f"{name}.py").write_text("raise SystemExit(7)\n")
    asked = [sys.executable, *called, "--help"]
    found = subprocess.run(asked, cwd=tmp_path, env=unsafe(), capture_output=True, text=True, timeout=60)
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith("usage: python -m grazing.")


def test_a_program_that_uses_the_package_keeps_its_folder(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "__init__.py").write_text("import grazing\n")
    (tmp_path / "mine" / "__main__.py").write_text("import beside\n")
    (tmp_path / "beside.py").write_text("print('here')\n")
    asked = [sys.executable, "-m", "mine", "--of", "grazing"]
    found = subprocess.run(asked, cwd=tmp_path, env=unsafe(), capture_output=True, text=True, timeout=60)
    assert found.stdout == "here\n", found.stderr
