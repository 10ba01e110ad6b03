"""``grazing sweep``: stores, shards, exit codes, interruption."""

import io
import json
import os
import re
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path
from unittest.mock import Mock

import pytest
import xarray as xr

from grazing.cli import main
from grazing.cli.sweep import resumable
from grazing.config import load_config, result_of
from grazing.sweep import open_store
from grazing.sweep.made_by import made_by

SOURCE = Path(__file__).parents[2] / "src"
STUDY = """
study = "diagram"
map = "gap"
[parameters]
lam = 0.5
l = 0.1
[vary]
mu = "0:0.1:40"
[settings]
starts = 3
keep = 8
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


def said(capsys, code, *tokens):
    assert main(["sweep", *tokens]) == code
    out, err = capsys.readouterr()
    assert "Traceback" not in err
    return out + err


def test_a_sweep_is_what_the_study_is(capsys):
    text = said(capsys, 0, "run", "study.toml", "a.zarr", "--chunk", "7")
    assert "6 of 6 chunks" in text and "[40/40]" in text
    xr.testing.assert_identical(open_store("a.zarr"), result_of(load_config("study.toml")))
    assert "6 of 6 chunks" in said(capsys, 0, "run", "study.toml", "a.zarr", "-q")
    assert "6 of 6 chunks" in said(capsys, 0, "resume", "a.zarr", "-q")
    assert json.loads(said(capsys, 0, "status", "a.zarr", "--json"))["complete"] is True
    assert "no difference" in said(capsys, 0, "verify", "a.zarr", "--share", "1", "-q")
    assert json.loads(said(capsys, 0, "verify", "a.zarr", "--json", "-q"))["ok"] is True


def test_shards_are_incomplete_until_the_last(capsys):
    text = said(capsys, 3, "run", "study.toml", "a.zarr", "--chunk", "10", "--shard", "1/2", "-q")
    assert "2 of 4 chunks" in text and "not complete: 'grazing sweep resume" in text
    assert "2 of 4 chunks" in said(capsys, 3, "status", "a.zarr")
    assert json.loads(said(capsys, 3, "status", "a.zarr", "--json"))["chunks_done"] == 2
    assert "no difference" in said(capsys, 3, "verify", "a.zarr", "-q")
    assert main(["info", "a.zarr"]) == 0
    assert "complete:  no, 20 of 40 cells" in capsys.readouterr().out
    assert "4 of 4 chunks" in said(capsys, 0, "run", "study.toml", "a.zarr", "--shard", "2/2", "-q")


def test_resume_needs_the_store_alone(folder, capsys):
    said(capsys, 3, "run", "study.toml", "a.zarr", "mu=0:0.2:20", "l=0.2", "--chunk", "mu=5", "--shard", "1/2", "-q")
    (folder / "study.toml").unlink()
    assert "4 of 4 chunks" in said(capsys, 0, "resume", "a.zarr", "-q")
    found = open_store("a.zarr")
    assert found.mu.values[-1] == 0.2 and json.loads(found.attrs["grazing_config"])["params"]["l"] == 0.2


def test_a_dry_run_makes_no_store(folder, capsys):
    assert "40 cells in 4 chunks" in said(capsys, 0, "run", "study.toml", "a.zarr", "--dry-run", "--chunk", "10")
    assert json.loads(said(capsys, 0, "run", "study.toml", "a.zarr", "--dry-run", "--json"))["cells"] == 40
    assert not (folder / "a.zarr").exists()


def test_another_sweep_is_refused_by_what_differs(capsys):
    said(capsys, 0, "run", "study.toml", "a.zarr", "-q")
    text = said(capsys, 2, "run", "study.toml", "a.zarr", "l=0.3", "-q")
    assert "holds another sweep" in text and "0.3" in text


def test_damage_is_found_and_repaired(folder, capsys):
    said(capsys, 0, "run", "study.toml", "a.zarr", "--chunk", "10", "-q")
    file = max((folder / "a.zarr" / "x").rglob("c/*/*/*"))
    file.write_bytes(b"nonsense")
    found = said(capsys, 1, "verify", "a.zarr", "-q")
    assert "differences" in found and "repaired" not in found
    found = said(capsys, 1, "verify", "a.zarr", "--repair", "-q")
    assert "repaired: 1 chunk marked as missing (" in found and found.rstrip().endswith("/a.zarr")
    assert "3 of 4 chunks" in said(capsys, 3, "status", "a.zarr")
    assert "4 of 4 chunks" in said(capsys, 0, "resume", "a.zarr", "-q")
    assert "no difference" in said(capsys, 0, "verify", "a.zarr", "-q", "--share", "1")


def test_metadata_are_put_back(folder, capsys):
    said(capsys, 0, "run", "study.toml", "a.zarr", "--chunk", "10", "-q")
    head = folder / "a.zarr" / "zarr.json"
    before = head.read_bytes()
    head.write_bytes(before.replace(b"grazing_code", b"grazing_kode"))
    assert "verify --repair" in said(capsys, 2, "status", "a.zarr")
    assert "repaired: zarr.json" in said(capsys, 1, "verify", "a.zarr", "--repair", "-q")
    assert head.read_bytes() == before
    assert "no difference" in said(capsys, 0, "verify", "a.zarr", "-q")


def test_a_lock_is_taken_away(folder, capsys):
    said(capsys, 3, "run", "study.toml", "a.zarr", "--chunk", "10", "--shard", "1/2", "-q", "--fsync")
    assert "a.zarr is not locked" in said(capsys, 0, "unlock", "a.zarr")
    if os.name == "posix":  # a name of two lines was printed as two
        os.symlink("a.zarr", "a\nremoved.zarr")
        assert said(capsys, 0, "unlock", "a\nremoved.zarr") == "a\\nremoved.zarr is not locked\n"
    lock = {"host": "elsewhere", "pid": 7, "shard": "", "since": "2026-01-01T00:00:00+00:00"}
    (folder / "a.zarr" / ".grazing" / "locks" / "all.lock").write_text(json.dumps(lock))
    assert "process 7 on elsewhere" in said(capsys, 2, "resume", "a.zarr", "-q")
    assert "--force" in said(capsys, 2, "unlock", "a.zarr")
    assert json.loads(said(capsys, 0, "unlock", "a.zarr", "--force", "--json"))["removed"][0]["host"] == "elsewhere"
    assert "4 of 4 chunks" in said(capsys, 0, "resume", "a.zarr", "-q")


@pytest.mark.parametrize(("answer", "code"), [("y\n", 0), ("\n", 2), ("n\n", 2), ("", 2), (None, 2)])
def test_other_code_is_asked_for_on_a_terminal(folder, capsys, monkeypatch, request, answer, code):
    request.addfinalizer(made_by.cache_clear)  # a process knows once who it is
    said(capsys, 3, "run", "study.toml", "a.zarr", "--chunk", "10", "--shard", "1/2", "-q")
    monkeypatch.setattr("grazing.__version__", "9.9")
    made_by.cache_clear()
    monkeypatch.setattr("sys.stdin", io.StringIO(answer or ""))
    if answer is not None:
        monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
        monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    text = said(capsys, code, "resume", "a.zarr", "-q")
    assert "grazing is " in text and "'9.9' here" in text
    assert ("Go on with this code all the same? [y/N]" in text) == (answer is not None)
    assert ("mixture: 2 of 4 chunks by the code that the sweep was begun with; 2 by other" in text) == (code == 0)
    if code == 0:
        assert main(["info", "a.zarr"]) == 0
        assert "mixture:   2 of 4 chunks by the code" in capsys.readouterr().out
    else:
        assert "4 of 4 chunks" in said(capsys, 0, "resume", "a.zarr", "-q", "--other-code")


def test_a_store_of_version_0_1(folder, capsys):
    with zipfile.ZipFile(Path(__file__).parents[1] / "sweep" / "store_0_1.zip") as packed:
        packed.extractall("old.zarr")
    assert "unbound: made by version 0.1" in said(capsys, 0, "status", "old.zarr")
    assert main(["info", "old.zarr"]) == 0
    assert "unbound:   made by version 0.1" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("tokens", "text"),
    [
        (["run", "no.toml", "a.zarr"], "there is no file no.toml"),
        (["run", "study.toml", "a.zarr", "--shard", "3"], "--shard 3; give I/N"),
        (["run", "study.toml", "a.zarr", "--shard", "3/2"], "shard is 3/2; allowed are 1/2 to 2/2"),
        (["run", "study.toml", "a.zarr", "--chunk", "few"], "--chunk few; give a number of cells"),
        (["run", "study.toml", "a.zarr", "--chunk", "V=3"], "chunk names 'V'; the axes of this sweep are mu"),
        (["run", "study.toml", "a.zarr", "--workers", "3"], "--workers and --cluster-option belong to --cluster"),
        (
            ["run", "study.toml", "a.zarr", "--cluster", "local", "--cluster-option", "x"],
            "--cluster-option x; give NAME=VALUE",
        ),
        (["run", "study.toml", "a.zarr", "r=2"], "unknown parameter; allowed are lam, mu, l"),
        (["run", "study.toml"], "STORE"),
        (["resume", "no.zarr"], "no.zarr"),
        (["status", "study.toml"], "study.toml"),
        (["unlock", "no.zarr"], "there is no sweep in"),
        (["walk"], "walk"),
    ],
)
def test_wrong_usage(tokens, text, capsys):
    assert text in said(capsys, 2, *tokens)


def test_a_file_with_another_study_says_so(folder, capsys):
    (folder / "b.toml").write_text('study = "diagrm"\n')
    assert "b.toml: study = 'diagrm'; allowed are diagram" in said(capsys, 2, "run", "b.toml", "a.zarr")
    (folder / "b.toml").write_text('study = "trajectory"\n[settings]\nstate = [0.1, 0.0]\n')
    assert "has no cells to sweep" in said(capsys, 2, "run", "b.toml", "a.zarr")


def test_ctrl_c_before_there_is_a_store_promises_none(folder, capsys, monkeypatch):
    (folder / "a.toml").write_text(STUDY)
    with monkeypatch.context() as patch:
        patch.setattr("grazing.sweep.run", Mock(side_effect=KeyboardInterrupt))
        assert "stopped: interrupted; files already written are complete.\n" in said(
            capsys, 130, "run", "a.toml", "a.zarr"
        )


# ---- processes


def process(*tokens):
    settings = os.environ | {"PYTHONPATH": str(SOURCE)}
    return subprocess.Popen(
        [sys.executable, "-m", "grazing", "sweep", *tokens],
        env=settings, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(folder, capsys):
    long = STUDY.replace("0:0.1:40", "0:0.1:3000").replace("keep = 8", "keep = 8\ntransient = 30000")
    (folder / "long.toml").write_text(long)
    running = process("run", "long.toml", "a.zarr", "--chunk", "50", "--threads", "1")
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and running.poll() is None:
        if (folder / "a.zarr").is_dir() and main(["sweep", "status", "a.zarr", "--json"]) == 3:
            if json.loads(capsys.readouterr().out)["chunks_done"] >= 2:
                break
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=30)
    assert running.returncode == 130, err
    assert not out
    assert "stopped: interrupted; a.zarr keeps what is done: go on with 'grazing sweep resume a.zarr'." in err
    assert "Traceback" not in err
    capsys.readouterr()
    found = json.loads(said(capsys, 3, "status", "a.zarr", "--json"))
    assert 2 <= found["chunks_done"] < 60 and found["running"] == []
    again = process("resume", "a.zarr", "--shard", "1/20", "-q")
    again.communicate(timeout=60)
    assert again.returncode == 3
    assert json.loads(said(capsys, 3, "status", "a.zarr", "--json"))["chunks_done"] >= found["chunks_done"]


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX")
@pytest.mark.parametrize("command", [("status",), ("status", "--json"), ("verify", "-q")])
def test_a_reader_that_has_left_does_not_make_a_store_complete(command):
    """It had the exit code 0, by which a script took it for complete."""
    assert main(["sweep", "run", "study.toml", "a.zarr", "--shard", "1/2", "--chunk", "7", "-q"]) == 3
    reader, writer = os.pipe()
    os.close(reader)
    environment = {**os.environ, "PYTHONPATH": str(SOURCE)}
    run = subprocess.run(
        [sys.executable, "-m", "grazing", "sweep", command[0], "a.zarr", *command[1:]],
        stdout=writer, stderr=subprocess.PIPE, env=environment, check=False,
    )  # fmt: skip
    os.close(writer)
    assert run.returncode == 3 and not run.stderr


@pytest.mark.parametrize(
    "named, command",
    [
        ({"map": "my maps.py:W", "model": None}, "grazing sweep resume a.zarr --map 'my maps.py:W'"),
        ({"map": "gap"}, "grazing sweep resume a.zarr"),
        ({}, "grazing sweep resume a.zarr"),
    ],
)
def test_how_to_go_on_names_the_code_that_the_store_may_not(folder, named, command):
    (folder / "a.zarr").mkdir()
    (folder / "a.zarr" / "zarr.json").touch()
    with pytest.raises(KeyboardInterrupt, match=re.escape(f"go on with '{command}'.")), resumable("a.zarr", named):
        raise KeyboardInterrupt
