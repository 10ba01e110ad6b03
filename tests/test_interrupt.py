"""An interrupt waits where it would leave something half done, and is lost nowhere."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from grazing import interrupt, late
from grazing.interrupt import held_back, interrupt_in, none_lost
from tests.processes import python

MAIN = pytest.mark.skipif(threading.current_thread() is not threading.main_thread(), reason="needs the main thread")


@pytest.fixture(autouse=True)
def usual():
    """Ctrl-C as Python has it: packages that other tests import may take it for themselves."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@MAIN
def test_an_interrupt_comes_at_the_end_of_the_block_once():
    reached = []
    with pytest.raises(KeyboardInterrupt), held_back():
        signal.raise_signal(signal.SIGINT)
        with held_back():
            signal.raise_signal(signal.SIGINT)
            reached.append("inner")
        reached.append("outer")
    assert reached == ["inner", "outer"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@MAIN
def test_who_handles_interrupts_keeps_them():
    came = []
    for handler in (lambda *what: came.append(what), signal.SIG_IGN):
        before = signal.signal(signal.SIGINT, handler)
        try:
            with held_back():
                signal.raise_signal(signal.SIGINT)
                assert len(came) == (handler is signal.SIG_IGN)
            assert signal.getsignal(signal.SIGINT) is handler and len(came) == 1
        finally:
            signal.signal(signal.SIGINT, before)
    with held_back():  # somebody chooses another one meanwhile
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    assert signal.signal(signal.SIGINT, before) is signal.SIG_IGN


def test_another_thread_holds_nothing_back():
    ended = []

    def work():
        with held_back():
            ended.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert ended == [signal.getsignal(signal.SIGINT)]


#: Where Python is a part of a program another thread may import threading first, which takes it for the main one.
ANOTHER = """
import _thread, sys, time
path, ended = sys.argv[1:], []
def work():
    try:
        sys.path[:0] = path
        from grazing.interrupt import held_back
        with held_back():
            print("done", flush=True)
    finally:
        ended.append(True)
assert "threading" not in sys.modules
_thread.start_new_thread(work, ())
while not ended:
    time.sleep(0.01)
"""


def test_a_thread_that_is_taken_for_the_main_one_holds_nothing_back():
    command = [sys.executable, "-I", "-S", "-c", ANOTHER, Path(interrupt.__file__).parents[1]]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.stdout == "done\n", ended.stderr


@MAIN
def test_a_package_is_imported_as_a_whole(tmp_path, monkeypatch):
    (tmp_path / "halved.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\nwhole = True\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(late.PACKAGES, "halved", "halved")
    with pytest.raises(KeyboardInterrupt):
        _ = late.halved
    assert late.halved.whole  # not imported again
    del late.halved
    with pytest.raises(AttributeError, match="has no attribute 'other'"):
        _ = late.other


#: Interrupted while numba enters into its tables what it can compile; the message was *generator raised StopIteration*.
AT_FIRST = """
import signal, sys
import grazing as gz
own = gz.Map(lambda x, p: (p.a * x[0] * (1.0 - x[0]),), {"a": 3.2})
left = int(sys.argv[1])
def seen(frame, event, _argument):
    global left
    if event == "call" and frame.f_code.co_name == "stream_list":
        left -= 1
        if left == 0:
            signal.raise_signal(signal.SIGINT)
sys.setprofile(seen)
try:
    own.orbit((0.3,), 5)
except KeyboardInterrupt:
    print("stopped")
sys.setprofile(None)
print(own.orbit((0.3,), 1).points[-1, 0])
"""


@pytest.mark.parametrize("at", [1, 10])
def test_an_interrupt_while_numba_fills_its_tables_leaves_them_whole(at):
    done = python(AT_FIRST, at)
    assert done.stdout.split() == ["stopped", f"{3.2 * 0.3 * 0.7}"], done.stderr[-500:]


#: Interrupted between what llvmlite calls and what it notes of that; the process ended with *double free detected*.
IN_A_CALL = """
import gc, signal, sys
import grazing as gz
from llvmlite.binding import ffi
name, own = sys.argv[1], gz.Map(lambda x, p: (p.a * x[0] * (1.0 - x[0]),), {"a": 3.2})
call = getattr(ffi.lib, name)
def interrupted(*given):
    ffi.lib._fntab[name] = call
    result = call(*given)
    signal.raise_signal(signal.SIGINT)
    return result
ffi.lib._fntab[name] = interrupted
try:
    own.orbit((0.3,), 5)
except KeyboardInterrupt:
    print("stopped")
gc.collect()
print(own.orbit((0.3,), 1).points[-1, 0])
"""


@pytest.mark.parametrize("name", ["LLVMPY_DisposeString", "LLVMPY_DisposeModule", "LLVMPY_AddModule"])
def test_an_interrupt_in_a_call_of_llvm_destroys_nothing_twice(name, tmp_path):
    done = python(IN_A_CALL, name, env=os.environ | {"GRAZING_CACHE": str(tmp_path)})
    assert done.stdout.split() == ["stopped", f"{3.2 * 0.3 * 0.7}"], done.stderr[-500:]
    assert not done.stderr


def test_an_import_that_fails_after_an_interrupt_was_interrupted():
    """So does numpy's: in C it clears the interrupt, and says that it cannot be imported."""
    assert interrupt_in(ImportError("numpy._core.multiarray failed to import")) is None
    with none_lost():
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        assert interrupt_in(ImportError("numpy._core.multiarray failed to import")) is not None
        assert interrupt_in(ValueError("another")) is None
    assert interrupt_in(ImportError("numpy._core.multiarray failed to import")) is None
