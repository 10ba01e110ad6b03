"""Links in a store that somebody handed over: what lies behind them is neither removed nor written."""

import os
import shutil
from contextlib import suppress

import pytest

from grazing import sweep
from grazing.outcome import GrazingError
from grazing.sweep import files
from grazing.sweep.opened import open_existing
from grazing.sweep.task import note_run, note_time
from tests.sweep.plans import plan
from tests.sweep.swaps import at_call
from tests.sweep.test_forged import around

pytestmark = pytest.mark.skipif(os.name == "nt", reason="links need rights there")

#: What may lie behind a link: names that a store has, too.
THEIRS = ("poetry.lock", "all.lock", "old.new", "gate", "seal", "template", "0", "1", "history.jsonl", "plan-mine",
          "0.0123456789abcdef0123456789abcdef.partial", "seal.0123456789abcdef0123456789abcdef.partial",
          "zarr.json")  # fmt: skip


@pytest.fixture
def store(tmp_path):
    """Half of a sweep, and somebody's folder beside it."""
    home = tmp_path / "home" / "theirs"
    home.mkdir(parents=True)
    for name in THEIRS:
        (home / name).write_text("precious")
        os.utime(home / name, (0, 0))
    (home / "c").mkdir()
    for name in THEIRS[6:8]:
        (home / "c" / name).write_text("precious")
    sweep.run(plan(7), tmp_path / "home" / "a.zarr", chunk=2, shard=(1, 2))
    return tmp_path / "home" / "a.zarr"


FOLDERS = [".grazing", ".grazing/locks", ".grazing/times", "manifest", "manifest/chunks", "done", "done/c", "mean",
           "mean/c", "mu", "mu/c"]  # fmt: skip
FILES = [".grazing/history.jsonl", ".grazing/locks/gate", ".grazing/locks/all.lock", "manifest/template",
         "manifest/seal", "manifest/chunks/0", "done/c/0", "done/c/1", "mean/c/0", "mean/c/1", "zarr.json"]  # fmt: skip


def linked(store, key, target):
    there = store / key
    there.parent.mkdir(parents=True, exist_ok=True)
    if there.is_dir():
        there.rename(store.parents[1] / "before")
    elif there.exists():
        there.unlink()
    there.symlink_to(target, target_is_directory=target.is_dir())


def everything(store):
    yield lambda: sweep.status(store)
    yield lambda: sweep.unlock(store, force=True)
    yield lambda: sweep.verify(store, plan=plan(7))
    yield lambda: sweep.run(plan(7), store, shard=(1, 2))
    yield lambda: sweep.resume(store, plan(7))
    yield lambda: note_run(open_existing(store), {"a": 1})
    yield lambda: note_time(open_existing(store), 1, 1.0)
    yield lambda: open_existing(store).unseal()
    yield lambda: open_existing(store).remove_partials(range(4))
    yield lambda: sweep.verify(store, plan=plan(7), repair=True)
    yield lambda: sweep.resume(store, plan(7))


@pytest.mark.parametrize("key", FOLDERS)
@pytest.mark.parametrize("same", [True, False])
def test_a_folder_behind_a_link_is_left_alone(store, key, same):
    """The link leads to somebody's folder, or to a copy of what was there: with that the store even opens."""
    theirs = store.parent / "theirs"
    linked(store, key, theirs)
    if same and (store.parents[1] / "before").is_dir():
        for file in (store.parents[1] / "before").rglob("*"):
            goal = theirs / file.relative_to(store.parents[1] / "before")
            goal.mkdir(exist_ok=True) if file.is_dir() else goal.write_bytes(file.read_bytes())
    before = around(store)
    for call in everything(store):
        with suppress(GrazingError):
            call()
        assert around(store) == before


@pytest.mark.parametrize("key", FILES)
@pytest.mark.parametrize("gone", [True, False])
def test_a_file_behind_a_link_is_left_alone(store, key, gone):
    target = store.parent / "theirs" / "poetry.lock"
    target = target.with_name("not there") if gone else target
    linked(store, key, target)
    before = around(store)
    for call in everything(store):
        with suppress(GrazingError):
            call()
        assert around(store) == before
    assert sweep.resume(store, plan(7)).complete
    assert sweep.verify(store, plan=plan(7)).ok


@pytest.mark.skipif(os.open not in os.supports_dir_fd, reason="needs open folders")
@pytest.mark.parametrize("call", ["write", "append", "remove", "clear"])
def test_a_folder_that_becomes_a_link_after_it_was_looked_at_leads_nowhere(store, call, monkeypatch):
    """Somebody swaps the folder in the very moment before the file in it is opened, or removed."""
    theirs, swapped = store.parent / "theirs", []
    names = {
        "write": ("open", ".partial"),
        "append": ("open", "0"),
        "remove": ("unlink", "0"),
        "clear": ("unlink", "0"),
    }
    what, ending = names[call]
    real = getattr(os, what)

    def late(path, *args, **options):
        if str(path).endswith(ending) and not swapped:
            swapped.append(True)
            (store / "mean" / "c").rename(store / "mean" / "before")
            (store / "mean" / "c").symlink_to(theirs, target_is_directory=True)
        return real(path, *args, **options)

    before = around(store)
    monkeypatch.setattr(os, what, late)
    act = {
        "write": lambda: files.write_file(store, "mean/c/0", b"evil"),
        "append": lambda: files.append_line(store, "mean/c/0", "evil"),
        "remove": lambda: files.remove_file(store, "mean/c/0"),
        "clear": lambda: files.clear_way(store, "mean/c/0"),
    }
    act[call]()
    assert swapped and around(store) == before


ACTIONS = {
    "unlock": lambda store: sweep.unlock(store, force=True),
    "resume": lambda store: sweep.resume(store, plan(7), threads=1),
    "repair": lambda store: sweep.verify(store, plan=plan(7), repair=True, threads=1),
}


def swapped_at(call, store, key, action):
    """Do something in a store of which a folder becomes a link before that call; return how many calls there were."""
    theirs = store.parent / "theirs"
    before = {path: path.is_file() and path.read_bytes() for path in theirs.rglob("*")}

    def swap():
        if (store / key).is_dir() and not (store / key).is_symlink():
            (store / key).rename(store.parents[1] / "before")
            (store / key).symlink_to(theirs, target_is_directory=True)

    def during():
        with suppress(GrazingError):
            ACTIONS[action](store)

    calls = at_call(call, swap, during)
    assert {path: path.is_file() and path.read_bytes() for path in theirs.rglob("*")} == before
    return calls


@pytest.mark.skipif(os.open not in os.supports_dir_fd, reason="needs open folders")
@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.parametrize("every", [97, pytest.param(2, marks=pytest.mark.long)])
def test_a_folder_that_becomes_a_link_before_any_call_leads_nowhere(store, tmp_path, action, every):
    """Whenever it happens: nothing of theirs is touched, and there is no other error than a sentence."""
    for inner in ("locks", "chunks"):
        shutil.copytree(store.parent / "theirs", tmp_path / inner)
        shutil.move(tmp_path / inner, store.parent / "theirs" / inner)
    for key in ("mean/c/1", "manifest/seal"):
        (store / key).with_name(f"{(store / key).name}.{'0123456789abcdef' * 2}.partial").write_text(
            "left by a killed one"
        )
    if action == "repair":
        (store / "manifest" / "chunks" / "0").write_bytes(b"rubbish")
    whole = tmp_path / "whole"
    store.parent.rename(whole)
    for i, key in enumerate(FOLDERS):
        call = 1 + i if action == "unlock" else 1 + 7 * i % every
        while True:
            shutil.copytree(whole, store.parent)
            calls = swapped_at(call, store, key, action)
            shutil.rmtree(store.parent)
            shutil.rmtree(tmp_path / "before", ignore_errors=True)
            if calls is not None:
                break
            call += every


@pytest.mark.parametrize("key", [".grazing/locks/gate", ".grazing/history.jsonl"])
def test_a_second_name_of_somebodys_file_is_left_alone(store, key):
    """The gate of the locks emptied it, and the history grew in it."""
    theirs = store.parent / "theirs" / "poetry.lock"
    (store / key).unlink()
    os.link(theirs, store / key)
    before = around(store)
    for call in everything(store):
        with suppress(GrazingError):
            call()
        assert around(store) == before
    assert sweep.resume(store, plan(7)).complete
