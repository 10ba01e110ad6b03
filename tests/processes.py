"""Processes that find the libraries imported: forked from one that has imported them, and nothing of the package.

To import numba, xarray and what they bring takes a processor a second or two, the package a tenth of that. A test that
asks for a process of its own, because kernels, files or memory must outlive one, asks for no more than that. What
libraries read of the environment when they are imported, and what is imported at all, is tested in processes that are
started: by :mod:`subprocess`.
"""

import atexit
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import types
from functools import cache
from pathlib import Path


def python(program, *arguments, env=None, cwd=None, timeout=120):
    """Run a program as ``python -c program arguments`` would; return its exit code and what it wrote, as text."""
    env, arguments = dict(os.environ if env is None else env), [str(each) for each in arguments]
    changed = read(env).items() ^ read(os.environ).items()
    assert not changed, f"numba has read {sorted(changed)} when it was imported: start a process"
    if sys.platform != "linux":  # libraries elsewhere do not all allow a fork
        command = [sys.executable, "-c", program, *arguments]
        return subprocess.run(command, capture_output=True, text=True, env=env, cwd=cwd, timeout=timeout)
    with tempfile.TemporaryDirectory() as folder:
        files = [f"{folder}/out", f"{folder}/err"]
        code = _forked([program, arguments, env, os.fspath(cwd or os.getcwd()), *files], timeout)
        out, err = (Path(file).read_text(encoding="utf-8") for file in files)
    return subprocess.CompletedProcess([sys.executable, "-c", program, *arguments], code, out, err)


def read(environment):
    """Return what numba alone reads when it is imported: whether to compile, the package asks as well, and later."""
    kept = {name for name in environment if name.startswith("NUMBA_")} - {"NUMBA_DISABLE_JIT"}
    return {name: environment[name] for name in kept}


def _forked(order, timeout):
    """Give an order to the process that forks; return the exit code, negative for a signal."""
    server = _server()
    server.stdin.write(json.dumps(order) + "\n")
    server.stdin.flush()
    pid = int(server.stdout.readline())
    ended = select.select([server.stdout], [], [], timeout)[0]
    if not ended:
        os.kill(pid, signal.SIGKILL)  # not reaped yet, so the number is still its own
    code = server.stdout.readline()
    if not ended:
        raise subprocess.TimeoutExpired(order[0], timeout)
    return int(code)


def _environment():
    """Return the environment of the process that forks, in which numba compiles."""
    return {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}


@cache
def _server():
    """Start the process that forks: one for each that runs tests."""
    command = [sys.executable, "-c", "import sys; sys.path.insert(0, sys.argv[1]); from processes import main; main()"]
    given = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "cwd": "/", "env": _environment()}
    server = subprocess.Popen([*command, str(Path(__file__).parent)], **given)
    atexit.register(server.communicate)  # its input ends, and so does it
    return server


def main():
    """Import libraries, then fork for each order."""
    del sys.path[0]  # of this file
    path = [each for each in sys.path if each not in os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    import numba  # noqa: F401
    import xarray

    xarray.Dataset(coords={"x": [0.0]})  # which imports more
    for line in sys.stdin:
        order = json.loads(line)
        pid = os.fork()
        if pid == 0:
            _become(path, *order)
        print(pid, flush=True)
        _pid, status = os.waitpid(pid, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


def _become(path, program, arguments, env, cwd, out, err):
    """Be the process that was asked for, and end."""
    for number, file in enumerate((os.devnull, out, err)):
        new = os.open(file, os.O_RDWR | os.O_CREAT, 0o600)
        os.dup2(new, number)
        os.close(new)
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env)
    tempfile.tempdir = None
    sys.dont_write_bytecode = bool(env.get("PYTHONDONTWRITEBYTECODE"))
    sys.argv = ["-c", *arguments]
    sys.path[:] = ["", *filter(None, env.get("PYTHONPATH", "").split(os.pathsep)), *path]
    sys.modules["__main__"] = there = types.ModuleType("__main__")
    del sys.modules["processes"]
    code = 1
    try:
        exec(compile(program, "<string>", "exec"), there.__dict__)
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
