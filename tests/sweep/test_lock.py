import json
import os
import socket
import threading
from contextlib import suppress

import pytest

import grazing as gz
from grazing import sweep
from grazing.sweep import lock
from grazing.sweep.lock import holders, locked
from tests.sweep.plans import plan

OTHER = {"host": "elsewhere", "pid": 7, "shard": "", "since": "2026-01-01T00:00:00+00:00"}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "a.zarr").mkdir()
    return tmp_path / "a.zarr" / ".grazing" / "locks"


def put(folder, name, content, age=0.0):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(content if isinstance(content, str) else json.dumps(content))
    (folder / "gate").touch()
    now = (folder / "gate").stat().st_mtime
    os.utime(folder / name, (now - age, now - age))


def test_a_lock_says_who_and_goes_away(folder):
    with locked(folder, None):
        (found,) = holders(folder)
        assert (found.pid, found.host, found.shard) == (os.getpid(), socket.gethostname(), "")
        assert str(found).startswith(f"a run of the whole sweep (process {os.getpid()} on ")
    assert holders(folder) == []
    assert [file.name for file in folder.iterdir()] == ["gate"]


@pytest.mark.parametrize(
    ("first", "second", "fits"),
    [
        (None, None, False),
        (None, (1, 2), False),
        ((1, 2), None, False),
        ((1, 2), (1, 2), False),
        ((1, 2), (1, 3), False),
        ((1, 2), (2, 2), True),
        ((2, 11), (11, 11), True),
    ],
)
def test_who_may_work_together(folder, first, second, fits):
    with locked(folder, first):
        if fits:
            with locked(folder, second):
                assert len(holders(folder)) == 2
        else:
            with pytest.raises(
                gz.InputError, match=r"a\.zarr is being worked on by .*process .*Only shards of the same"
            ):
                with locked(folder, second):
                    pass
        assert len(holders(folder)) == 1
    with locked(folder, second):
        pass


def test_a_lock_goes_away_with_an_exception(folder):
    with pytest.raises(KeyboardInterrupt), locked(folder, (1, 2)):
        raise KeyboardInterrupt
    assert holders(folder) == []


def test_what_ended_the_work_is_said_although_its_lock_cannot_be_removed(folder, monkeypatch):
    """On a disk that can only be read since, all that was said was ``[Errno 30] ... 'all.lock'``."""

    def refused(*_given):
        raise OSError(30, "Read-only file system")

    with pytest.raises(gz.GrazingError, match="resume"), locked(folder, None):
        monkeypatch.setattr(lock.Place, "remove", refused)
        raise gz.GrazingError("make room, and resume")
    assert holders(folder) == [] and not lock._held


def test_the_lock_of_a_dead_process_of_this_machine_is_taken_over(folder):
    put(folder, "all.lock", OTHER | {"host": socket.gethostname(), "pid": os.getpid()})  # its number lives, it does not
    put(folder, "shard-1-of-2.lock", OTHER | {"host": socket.gethostname(), "shard": "1/2"})
    assert holders(folder) == []
    with locked(folder, (2, 3)):
        assert [found.shard for found in holders(folder)] == ["2/3"]


def test_another_machine_is_believed_while_it_touches_its_lock(folder):
    put(folder, "all.lock", OTHER, age=lock.STALE / 2)
    with pytest.raises(gz.InputError, match=r"process 7 on elsewhere, since 2026-01-01"), locked(folder, None):
        pass
    put(folder, "all.lock", OTHER, age=lock.STALE * 2)
    with locked(folder, None):
        assert [found.pid for found in holders(folder)] == [os.getpid()]


def test_a_running_process_touches_its_lock(folder, monkeypatch):
    monkeypatch.setattr(lock, "TOUCH", 0.01)
    with locked(folder, None):
        file = folder / "all.lock"
        os.utime(file, (0, 0))
        for _ in range(500):
            if file.stat().st_mtime > 0:
                break
            threading.Event().wait(0.01)
        assert file.stat().st_mtime > 0


@pytest.mark.parametrize("content", ["", "{", "[]", '{"host": "a"}', "3"])
def test_rubbish_is_no_lock(folder, content):
    put(folder, "all.lock", content)
    with locked(folder, None):
        assert len(holders(folder)) == 1


def test_unnamed_files_of_killed_processes_go_away(folder):
    put(folder, "0123.new", OTHER, age=lock.STALE * 2)
    put(folder, "4567.new", OTHER)
    with locked(folder, None):
        assert sorted(file.name for file in folder.iterdir()) == ["4567.new", "all.lock", "gate"]


def test_a_lock_that_was_taken_over_is_left_alone(folder):
    with locked(folder, None):
        (folder / "all.lock").unlink()
        put(folder, "all.lock", OTHER)
    assert json.loads((folder / "all.lock").read_text()) == OTHER


def test_a_folder_that_went_away(folder):
    import shutil

    with locked(folder, None):
        shutil.rmtree(folder)
    assert not folder.exists()  # nor is it made again to take the lock away


@pytest.mark.parametrize("without", ["flock", "link"])
def test_where_the_system_has_no_locks_or_links(folder, monkeypatch, without):
    def refused(*_args, **_options):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(lock.fcntl if without == "flock" else os, without, refused)
    with locked(folder, None):
        with pytest.raises(gz.InputError, match=r"is being worked on"), locked(folder, (1, 2)):
            pass
        assert len(holders(folder)) == 1
    with locked(folder, None):
        pass


@pytest.mark.parametrize("shard", [None, (1, 2)])
@pytest.mark.parametrize("system", ["with locks", "without"])
def test_of_many_that_start_at_once_at_most_one_goes_on(folder, monkeypatch, system, shard):
    if system == "without":
        monkeypatch.setattr(lock, "_try_lock", lambda handle, alone=True: None)
    gate, inside, refused, most = threading.Barrier(12), [], [], []

    def start():
        gate.wait()
        try:
            with locked(folder, shard):
                inside.append(1)
                most.append(len(inside))
                threading.Event().wait(0.02)
                inside.pop()
        except gz.InputError:
            refused.append(1)

    threads = [threading.Thread(target=start) for _ in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most, default=1) == 1 and len(most) + len(refused) == 12
    assert most or system == "without"  # then those that start together may all stop
    assert holders(folder) == []


def test_a_fork_does_not_keep_the_lock(folder):
    # A child of a killed run, such as a worker that waits for ever, must not look like the run.
    if not hasattr(os, "fork"):
        pytest.skip("no fork here")
    read, write = os.pipe()
    lock._held.add(write)
    try:
        lock._drop_inherited()
        with pytest.raises(OSError):
            os.write(write, b"x")
    finally:
        os.close(read)


def test_whether_a_process_exists():
    assert lock.process_exists(os.getpid()) and lock.process_exists(1)
    assert not lock.process_exists(2**22 + 1) and not lock.process_exists(10**30)


# ---- what a hand, or another clock, leaves


def test_a_lock_from_the_future_is_taken_over(folder):
    put(folder, "all.lock", OTHER, age=-lock.STALE * 2)
    with locked(folder, None):
        assert [found.pid for found in holders(folder)] == [os.getpid()]


@pytest.mark.parametrize("kind", ["pipe", "folder", "link to nothing", "loop", "endless"])
@pytest.mark.parametrize("name", ["all.lock", "gate", "0123.new"])
def test_what_is_no_file_is_no_lock(folder, kind, name):
    folder.mkdir(parents=True)
    if kind == "pipe":
        os.mkfifo(folder / name)
    elif kind == "folder":
        (folder / name / "inner").mkdir(parents=True)
    else:
        (folder / name).symlink_to({"loop": name, "endless": "/dev/zero"}.get(kind, "/nowhere/at all"))
    assert holders(folder) == []
    with locked(folder, None):
        assert len(holders(folder)) == 1


@pytest.mark.parametrize(
    "changed",
    [{"host": ["a"]}, {"pid": "7"}, {"pid": 10**30}, {"pid": -1}, {"shard": 3}, {"since": None}, {"pid": None}],
)
def test_a_lock_with_odd_entries_is_plain(folder, changed):
    put(folder, "all.lock", OTHER | changed)
    for found in holders(folder):
        assert "process" in str(found)
    with suppress(gz.InputError), locked(folder, (1, 2)):
        pass


@pytest.fixture
def store(tmp_path):
    sweep.run(plan(), tmp_path / "a.zarr", chunk=2, shard=(1, 2))
    return tmp_path / "a.zarr"


def test_unlocking_says_who_and_removes_what_is_dead(store):
    folder = store / ".grazing" / "locks"
    assert sweep.unlock(store) == []
    put(folder, "all.lock", OTHER, age=lock.STALE * 2)
    put(folder, "shard-1-of-2.lock", "rubbish")
    (one, two) = sweep.unlock(store)
    assert (one.host, one.pid, one.since) == ("elsewhere", 7, OTHER["since"]) and "last seen 20" in str(one)
    assert "unknown" in str(two)
    assert [file.name for file in folder.iterdir()] == ["gate"]


def test_unlocking_the_living_needs_force(store):
    folder = store / ".grazing" / "locks"
    put(folder, "all.lock", OTHER)
    with pytest.raises(gz.InputError, match=r"process 7 on elsewhere, since 2026-01-01.*last seen 20.*force=True"):
        sweep.unlock(store)
    assert (folder / "all.lock").exists()
    with pytest.raises(gz.InputError, match=r"sweep.unlock removes a lock that is in the way"):
        sweep.run(plan(), store)
    assert [found.pid for found in sweep.unlock(store, force=True)] == [7]
    assert sweep.run(plan(), store).complete
    with locked(folder, None):
        with pytest.raises(gz.InputError, match=rf"process {os.getpid()} on"):
            sweep.unlock(store)
        assert len(sweep.unlock(store, force=True)) == 1
    assert sweep.unlock(store) == []


def test_unlocking_what_is_no_store(tmp_path):
    with pytest.raises(gz.InputError, match=r"there is no sweep in"):
        sweep.unlock(tmp_path / "b.zarr")
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(gz.InputError, match=r"is a folder without a sweep"):
        sweep.unlock(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["thesis.tex"]
