"""Option strings at random over all commands, found by introspection: taken, or refused with exit code 2.

What takes long has a stand-in: studies, stores, the explorer and the report of the paper are run by tests of their own.
"""

import contextlib
import functools
import random
import sys
import types

import pytest
from cyclopts.completion._base import extract_completion_data

from grazing.cli import main
from grazing.cli.app import app
from tests.fuzz.configurations import TEXTS, configuration, text_of
from tests.fuzz.extremes import defect

FILES = [
    "study.toml",
    "broken.toml",
    "missing.toml",
    "text.nc",
    "text.png",
    "text.pdf",
    "text.svg",
    "text.json",
    "text.csv",
    "folder",
    "empty.zarr",
    "loop.toml",
    "a.png",
    "a.nc",
    "none/a.png",
    "",
    ".",
    "-",
    "/dev/null",
    "own.py:P",
    "own.py:m",
    "own.py:nothing",
    "broken.py:P",
    "a b.svg",
    "e.PNG",
    ".zarr",
    "a.zarr",
    "b.zarr",
    "x" * 300 + ".nc",
]
ASSIGNED = [
    "d=0.05:0.16:5",
    "V=0:0.4:3",
    "u=0.1",
    "v=0",
    "x=0.1",
    "mu=0:0.1:3",
    "d=0.1:0.2",
    "d",
    "d=",
    "=",
    "=1",
    "d==1",
    "d=0.12",
    "--",
    "-",
    "-1",
    "q=1",
    "cos1=0.5",
    "phase=1",
    "d=nan",
    "d=1e400",
    "u=0:0.1:3",
    "d=1:2:3:4",
    "é=1",
]


@functools.cache
def commands():
    """Return every command, by its words, with its options and whether each takes a value."""
    found = {}
    for path, data in extract_completion_data(app).items():
        names = {
            name: not argument.is_flag() for argument in data.arguments for name in argument.names if name[0] == "-"
        }
        names |= {name: False for argument in data.arguments for name in argument.negatives if name[0] == "-"}
        found[path] = names | {"--help": False, "--version": False}
    return found


def line(random):
    """Return a command line."""
    path = random.choice(list(commands()))
    options, tokens = commands()[path], list(path)
    if random.random() < 0.05:
        tokens = [random.choice(TEXTS)] if random.random() < 0.5 else [path[0][:-1]] if path else ["papr"]
    words = [*TEXTS, *FILES, *ASSIGNED]
    for _ in range(random.randrange(3)):
        tokens.append(random.choice(random.choice([ASSIGNED, FILES, words])))
    for _ in range(random.randrange(5)):
        name = (
            random.choice(list(options))
            if random.random() < 0.95
            else random.choice(["--q", "--D", "-x", "--no-json", "---"])
        )
        value = random.choice(random.choice([TEXTS, FILES, ASSIGNED, ["1", "0.5", "-1", "0", "2:3", "1e9"]]))
        if random.random() < 0.3:
            tokens.append(f"{name}={value}")
        else:
            tokens += [name, value] if options.get(name, True) and random.random() < 0.95 else [name]
    if random.random() < 0.2:
        random.shuffle(tokens)
    if "--install-completion" in tokens or any(token.startswith("--install") for token in tokens):
        return ["--help"]
    return [token for token in tokens if "\0" not in token]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with files of every kind, most of them broken; what would take long is stood in for."""
    chosen = random.Random(0)
    (tmp_path / "study.toml").write_text('study = "diagram"\n[vary]\nd = "0.05:0.16:3"\n')
    (tmp_path / "broken.toml").write_bytes(text_of(chosen, configuration(chosen))[:40] + b"\xff[")
    for name in ("text.nc", "text.png", "text.pdf", "text.svg", "text.json", "text.csv", "broken.py"):
        (tmp_path / name).write_text("no such thing (\n")
    for name in ("folder", "empty.zarr"):
        (tmp_path / name).mkdir()
    (tmp_path / "loop.toml").symlink_to("loop.toml")
    (tmp_path / "own.py").write_text(
        "import grazing as gz\nP = gz.Map(lambda x, p: (p.a * x[0],), params={'a': 0.5})\nm = gz.pinball(V=0.3)\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GRAZING_DEBUG", raising=False)
    report = types.ModuleType("grazing.paper.report")
    report.report = lambda **_given: {
        "folder": "a", "figures": [], "files": ["a"], "claims": 0, "differs": [],
        "verdicts": {"agrees": 0, "corrected": 0, "differs": 0},
    }  # fmt: skip
    monkeypatch.setitem(sys.modules, "grazing.paper.report", report)
    import grazing.cli.study
    import grazing.explorer.server
    import grazing.sweep

    @contextlib.contextmanager
    def nothing(*_given, **_more):
        yield None

    for name in ("compute", "estimated"):
        monkeypatch.setattr(grazing.cli.study, name, lambda *_given: 0)
    monkeypatch.setattr(grazing.explorer.server, "serve", lambda *_given: None)
    monkeypatch.setattr(grazing.explorer.server, "copy_to", lambda folder, _kernels: folder)
    status = types.SimpleNamespace(complete=True, path="a.zarr")
    monkeypatch.setattr(grazing.sweep, "run", lambda *_given, **_more: status)
    monkeypatch.setattr(grazing.sweep, "estimate", lambda *_given, **_more: status)
    monkeypatch.setattr(grazing.sweep, "cluster", nothing)
    monkeypatch.setattr("grazing.cli.sweep.asdict", lambda _status: {})
    return tmp_path


def trial(seed, capsys):
    """Return what is wrong with the answer to a command line."""
    tokens, ended = line(random.Random(seed)), []
    wrong = defect(lambda: ended.append(main(tokens)))
    said = capsys.readouterr().err
    if wrong is None:
        code, checks = ended[0], tokens[:2] == ["orbit", "check"]
        if code not in (0, 2, *((1,) if checks else ())) or "unexpected" in said or "Traceback" in said:
            wrong = f"exit code {code}: {said[:400]}"
        elif code == 2 and not said.strip():
            wrong = "exit code 2 without a word"
        elif len(said) > 20_000:
            wrong = f"a message of {len(said)} letters"
    return f"seed {seed}: grazing {tokens!r:.500}\n    {wrong}" if wrong else None


def test_every_command_is_among_them():
    assert {("diagram",), ("sweep", "run"), ("orbit", "check"), ("config", "show"), ("paper",), ("plot",)} <= {
        *commands()
    }
    assert commands()["chart",]["--curves"] and not commands()["chart",]["--json"]


def test_option_strings_are_taken_or_refused(folder, capsys):
    wrong = [found for seed in range(500) if (found := trial(seed, capsys))]
    assert not wrong, "\n".join(wrong)


@pytest.mark.long
def test_very_many_option_strings_are_taken_or_refused(folder, capsys):
    wrong = [found for seed in range(1000, 5000) if (found := trial(seed, capsys))]
    assert not wrong, "\n".join(wrong)
