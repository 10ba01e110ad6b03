"""Files of any name: what is said of them is one line, in which nothing moves the cursor of a terminal."""

import pickle

import pytest

from grazing.cli import main
from grazing.config.problems import Problem, refusal
from grazing.outcome import GrazingError, InputError, UserCodeError

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
