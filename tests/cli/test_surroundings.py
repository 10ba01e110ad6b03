"""What stands around a command: its environment and its streams; whatever they are, it works or says what is wrong."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import grazing as gz
from grazing.cli import main, streams
from tests.processes import python

SOURCE = str(Path(gz.__file__).parents[1])

#: What may be refused, and what must work, also all of it at once.
REFUSED = {"SOURCE_DATE_EPOCH": ("abc", "-1", "1" * 30), "MPLBACKEND": ("nonsense", "module://theirs")}
TAKEN = {"TZ": ":../../x", "COLUMNS": "abc", "PYTHONWARNINGS": "error", "LC_ALL": "C", "TMPDIR": "/nowhere"}


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    G = gz.gap_map(lam=0.5, mu=0.1, l=0.2)
    result = gz.orbit_diagram(G, "mu", [0.0, 0.05, 0.1], starts=2, transient=10, keep=8)
    return gz.save(result, tmp_path_factory.mktemp("around") / "a.nc")


DRAW = f"import sys; sys.path.insert(0, {SOURCE!r})\nfrom grazing.__main__ import main\nraise SystemExit(main())"


@pytest.mark.parametrize("name", REFUSED)
def test_the_environment_can_say_anything(name, file, tmp_path):
    """A backend that there is not, or a date that is none, were unexpected errors, or a file that is "damaged"."""
    for value in REFUSED[name]:
        done = python(DRAW, "plot", file, "-o", tmp_path / "a.svg", env={**os.environ, name: value}, cwd=tmp_path)
        assert "unexpected" not in done.stderr and "damaged" not in done.stderr, done
        assert done.returncode == 0 or (done.returncode == 2 and done.stderr.startswith(f"error: {name} = ")), done


def test_what_others_read_of_the_environment_is_no_concern_of_a_figure(file, tmp_path):
    command = [sys.executable, "-m", "grazing", "plot", str(file), "-o", str(tmp_path / "a.svg")]
    settings = {**os.environ, **TAKEN, "PYTHONUTF8": "0"}  # read when Python begins
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=settings, cwd=tmp_path)
    assert done.returncode == 0 and not done.stderr, done


def test_a_clock_that_python_cannot_tell(monkeypatch, capsys):
    """A study was an unexpected error: the first package that asks for the time cannot be imported."""

    def time():
        raise OverflowError("timestamp too large to convert to C _PyTime_t")

    monkeypatch.setattr("time.time", time)
    assert main(["sweep", "status", "a.zarr"]) == 2
    assert capsys.readouterr().err.startswith("error: the clock of this machine is outside the years 1678 to 2261")


CLOSED = """
import os, sys
from grazing.cli import streams
with streams.prepared():
    said = open(sys.argv[1], "w")
    print([os.readlink(f"/proc/self/fd/{i}") for i in range(3)], file=said)
"""


@pytest.mark.skipif(not os.path.exists("/proc/self/fd"), reason="needs the list of open files")
def test_no_file_takes_the_place_of_a_closed_stream(tmp_path):
    """What a library prints would go into it."""
    (tmp_path / "say.py").write_text(CLOSED)
    command = f"exec {sys.executable} {tmp_path}/say.py {tmp_path}/said <&- >&- 2>&-"
    subprocess.run(["sh", "-c", command], timeout=60, check=False)
    assert (tmp_path / "said").read_text() == f"{['/dev/null'] * 3}\n"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a Linux device")
@pytest.mark.parametrize("there", ["/dev/full", "a pipe that nobody reads"])
def test_what_is_said_beside_the_result_may_be_lost(there, monkeypatch):
    """Progress on a full disk ended a computation with exit code 1, and to a reader that left with 0."""
    if there == "/dev/full":
        number = os.open(there, os.O_WRONLY)
    else:
        reader, number = os.pipe()
        os.close(reader)
    with open(number, "w", encoding="utf-8", buffering=1) as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setattr(sys, "__stderr__", stream)
        with streams.prepared():
            print("progress", file=sys.stderr, flush=True)
            assert (sys.stderr.fileno(), sys.stderr.isatty(), sys.stderr.encoding) == (number, False, "utf-8")
        assert sys.stderr is stream
        assert main(["info", "none"]) == 2


def test_what_is_said_arrives(tmp_path, monkeypatch):
    with open(tmp_path / "said", "w", encoding="ascii") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setattr(sys, "__stderr__", stream)
        assert main(["info", "\u03bb"]) == 2
    assert (tmp_path / "said").read_text() == "error: there is no file \\u03bb\n"


@pytest.mark.parametrize("line", ["sys.stdout.close()", "sys.stdout = None"])
def test_code_of_ones_own_that_closes_the_output_is_named(line, tmp_path):
    """That was an unexpected error, or a traceback behind it."""
    (tmp_path / "own.py").write_text(
        f"import sys\nimport grazing as gz\n{line}\nP = gz.Map(lambda x, p: (p.a * x[0],), params={{'a': 0.5}})\n"
    )
    command = ["cobweb", "x=0.1", "--map", "own.py:P", "--steps", "3", "-q"]
    done = subprocess.run([sys.executable, "-m", "grazing", *command], cwd=tmp_path, capture_output=True, text=True)
    said = "error: code of your own, or of a package, closed the standard output; leave that away.\n"
    assert (done.returncode, done.stderr) == (1, said)


def test_a_machine_without_a_sound_null_device(monkeypatch, capsys):
    """Where it may not be opened every command was a traceback."""
    monkeypatch.setattr(os, "devnull", "/none/null")
    assert main(["--version"]) == 0 and capsys.readouterr().out.startswith("grazing ")
