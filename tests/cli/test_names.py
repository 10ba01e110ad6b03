"""Files of any name: what is said of them is one line, in which nothing moves the cursor of a terminal."""

import io
import os
import pickle
import random
import shutil
import subprocess

import pytest

from grazing.cli import main
from grazing.config.problems import Problem, refusal
from grazing.outcome import GrazingError, InputError, UserCodeError, quoted

NAMES = ["two\nlines", "a\x1b[2Jb", "\u202ereversed", "\r\n", "a\x85b", "a\u2028b", "\x7f"]
COMMANDS = [
    "info {}.nc", "info {}.toml", "info {}.png", "info {}.zarr", "info {}.json", "info {}", "info --config {}.nc",
    "plot {}.nc -o a.png", "plot {}/a.nc -o a.png", "plot a.nc -o {}.png", "plot text.nc -o {}.png", "plot a.nc -o {}",
    "plot a.nc -o {}/a.png", "plot a.nc -o a.png --curves {}.nc", "plot a.nc -o a.png --style {}",
    "export {}.nc -o a.csv", "export a.nc -o {}/a.csv", "sweep status {}.zarr", "sweep verify {}.zarr",
    "sweep unlock {}.zarr", "sweep resume {}.zarr", "sweep run {}.toml", "sweep run a.toml -o {}/a.zarr",
    "orbit check {} -q", "config show {}.toml", "diagram --config {}.toml", "diagram {}=1",
    "diagram {}", "diagram mu=0:1:3 -o {}", "diagram mu=0:1:3 -o {}/a.nc", "diagram mu=0:1:3 --map {}.py:P",
    "trajectory u=0 v=0 --model {}.py:m", "trajectory u=0 v=0 --model bad.py:{}", "trajectory u={} v=0",
    "orbit --N 3 --save {}", "explore --copy-to {}/a", "{}", "diagram --{}", "--{}",
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_said_of_a_name_is_one_line(command, tmp_path, monkeypatch, capsys):
    """A name with a line end was printed as it is: on two lines, the second of which could say anything."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.py").write_text("import grazing as gz\nraise ValueError('two\\nlines')\n")
    for name in ("text.nc", *(f"{name}{ending}" for name in NAMES for ending in (".nc", ".toml", ".json", ".png"))):
        (tmp_path / name).write_text("no such thing\n")
    for name in NAMES:
        code = main([part.replace("{}", name) for part in command.split()])
        said = capsys.readouterr().err
        assert code in (1, 2) and said.endswith("\n"), said
        first, *more = said[:-1].split("\n")
        assert first.startswith("error: ") and all(line.startswith("  ") for line in more if "errors:" in first), said
        assert not more or "errors:" in first, said
        assert first.isprintable() and all(line.isprintable() for line in more)


def test_a_message_has_a_line_for_each_argument_and_travels_as_it_is():
    assert str(InputError("a\nb")) == "a\\nb" and str(GrazingError()) == ""
    assert str(InputError("two errors:", "  a\nb")) == "two errors:\n  a\\nb"
    several = refusal([Problem(("a",), "one"), Problem(("b",), "two\nlines")], "c\nd")
    assert str(several).splitlines() == ["c\\nd has 2 errors:", "  a: one", "  b: two lines"]
    for error in (several, InputError("a\nb"), UserCodeError("a", "b")):
        copy = pickle.loads(pickle.dumps(error))
        assert str(copy) == str(error) and copy.args == error.args and type(copy) is type(error)


@pytest.mark.skipif(shutil.which("bash") is None, reason="reads words as bash does")
def test_a_shell_reads_every_quoted_word_as_it_is():
    rng = random.Random(1)
    letters = [*map(chr, range(1, 256)), *"\u202e\u2028\u3000\u6f22\U0001f600\udcff\udc80", *"'\\$`!*-~\n\t01" * 3]
    words = ["", *("".join(rng.choice(letters) for _ in range(rng.randrange(1, 9))) for _ in range(2000))]
    line = "printf '%s\\0' " + " ".join(map(quoted, words))
    assert all(letter.isprintable() or letter == "\u3000" or ord(letter) == 0xA0 for letter in line)
    read = subprocess.run(["bash", "-c", os.fsencode(line)], capture_output=True, check=True, timeout=60)
    assert [os.fsdecode(word) for word in read.stdout.split(b"\0")[:-1]] == words


@pytest.mark.skipif(shutil.which("bash") is None, reason="reads words as bash does")
@pytest.mark.parametrize("name", ["two\nlines.svg", "tab\t'.nc", "-o.svg", "a\x1b[2J.nc", "\u202e.svg", "a\udcff b.nc"])
def test_the_command_in_a_file_writes_a_file_of_that_name(name, tmp_path, monkeypatch, capsys):
    """It named another: a line end was printed as its escape, and - in front was an option."""
    monkeypatch.chdir(tmp_path)
    begin = ["cobweb", "x=0.3", *"--map gap --lam 0.5 --mu 0.1 --l 0.2 --steps 3".split()]
    assert main([*begin, "-o", f"./{name}", "-q"]) == 0
    capsys.readouterr()
    assert main(["info", f"./{name}"]) == 0
    command = capsys.readouterr().out.splitlines()[-1].removeprefix("again:     grazing ")
    os.remove(name)
    words = subprocess.run(["bash", "-c", f"printf '%s\\0' {command}"], capture_output=True, check=True, timeout=60)
    assert main(["-q" if word == b"" else os.fsdecode(word) for word in words.stdout.split(b"\0")]) == 0
    assert os.listdir() == [name]


def test_a_letter_that_the_output_lacks_is_quoted_by_its_bytes(monkeypatch):
    """A terminal without UTF-8 got the number of the letter, between quotes that keep it a number."""
    assert quoted("\u6f22.svg") == "'\u6f22.svg'"
    monkeypatch.setattr("sys.stdout", io.TextIOWrapper(io.BytesIO(), "ascii", "backslashreplace"))
    assert quoted("\u6f22.svg") == r"$'\346\274\242.svg'"
    monkeypatch.setattr("sys.stdout", None)
    assert quoted("\u6f22.svg") == "'\u6f22.svg'"


@pytest.mark.parametrize("option", ["--model", "--map"])
def test_a_file_whose_name_is_in_another_encoding_is_said(capsys, option):
    """As in the C locale; what was said is how pydantic reads a text."""
    assert main(["diagram", "mu=0:0.1:4", option, "m\udcc3\udcb6del.py:make"]) == 2
    said = capsys.readouterr().err
    assert "rename the file, or choose a locale of UTF-8" in said and "raw data" not in said
