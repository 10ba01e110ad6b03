"""The end at every call to the system, torn writes included: what is there is right, and goes on to the same bytes."""

import os
import shutil

import pytest

import grazing as gz
import grazing.sweep.files
from grazing import sweep
from grazing.studies.plan import run_plan
from tests.sweep.plans import files
from tests.sweep.test_attack import CHUNK, plan, refuse_silence


class End(BaseException):
    """The process is no more: nothing that it would still do is done."""


class System:
    """The calls that change a disk, until the last one that is granted."""

    def __init__(self, granted):
        self.granted, self.calls = granted, 0

    def __getattr__(self, name):
        real = getattr(os, name)
        if name not in ("open", "write", "replace", "mkdir", "unlink", "fsync"):
            return real

        def call(*args, **options):
            if name == "open" and not args[1] & os.O_CREAT:
                return real(*args, **options)
            self.calls += 1
            if self.calls > self.granted:
                if name == "write" and self.calls == self.granted + 1:
                    real(args[0], args[1][: len(args[1]) // 2])
                raise End
            return real(*args, **options)

        return call


@pytest.fixture(scope="module")
def right(tmp_path_factory):
    store = tmp_path_factory.mktemp("crash") / "a.zarr"
    sweep.run(plan(), store, chunk=CHUNK, threads=1)
    return store, run_plan(plan())


def ended(monkeypatch, action, granted):
    """Run an action until its end; return how many calls it made, None if it was not cut short."""
    system = System(granted)
    with monkeypatch.context() as patch:
        patch.setattr(grazing.sweep.files, "os", system)
        try:
            action()
        except End:
            return True
    return False


def look(store, truth):
    if (store / "zarr.json").exists():
        refuse_silence(gz.load(store), truth, False)


def end_everywhere(monkeypatch, right, tmp_path, begin, action, step):
    whole, truth = right
    granted, before = 0, files(whole)
    while True:
        store = tmp_path / f"{granted}.zarr"
        begin(whole, store)
        cut = ended(monkeypatch, lambda store=store: action(store), granted)
        look(store, truth)
        assert sweep.run(plan(), store, chunk=CHUNK, threads=1).complete
        assert files(store) == before
        look(store, truth)
        assert [file for file in tmp_path.iterdir() if file.name != store.name] == []
        shutil.rmtree(store)
        if not cut:
            return granted
        granted += step


def nothing(_whole, _store):
    return


def three_missing(whole, store):
    shutil.copytree(whole, store)
    for place in ("0/0", "1/1", "2/0"):
        (store / "done" / "c" / place).unlink()


def run(store):
    sweep.run(plan(), store, chunk=CHUNK, threads=1)


def run_with_fsync(store):
    sweep.run(plan(), store, chunk=CHUNK, threads=1, fsync=True)


@pytest.mark.parametrize(("begin", "action", "step"), [(nothing, run, 11), (three_missing, run, 5)])
def test_the_end_at_some_calls(monkeypatch, right, tmp_path, begin, action, step):
    assert end_everywhere(monkeypatch, right, tmp_path, begin, action, step) > 40


@pytest.mark.long
@pytest.mark.parametrize("begin", [nothing, three_missing])
@pytest.mark.parametrize("action", [run, run_with_fsync])
def test_the_end_at_every_call(monkeypatch, right, tmp_path, begin, action):
    assert end_everywhere(monkeypatch, right, tmp_path, begin, action, 1) > 40


def test_the_end_at_every_call_of_a_repair(monkeypatch, right, tmp_path):
    whole, truth = right
    granted, cut, before = 0, True, files(whole)
    while cut:
        store = tmp_path / f"{granted}.zarr"
        shutil.copytree(whole, store)
        for key in ("zarr.json", "points/zarr.json", "mu/c/0", "manifest/chunks/3", "period/c/1/0"):
            (store / key).write_bytes(b"rubbish")
        repair = lambda store=store: sweep.verify(store, plan=plan(), repair=True, threads=1)  # noqa: E731
        cut = ended(monkeypatch, repair, granted)
        try:
            refuse_silence(gz.load(store), truth, False)
        except gz.InputError:
            pass
        repair()
        assert sweep.run(plan(), store, threads=1).complete
        assert {key: content for key, content in files(store).items() if not key.endswith(".partial")} == before
        shutil.rmtree(store)
        granted += 1
    assert granted > 9
