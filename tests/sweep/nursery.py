"""A process that forks runs of a sweep, warm and at once, so that a test can kill many of them."""

import json
import os
import subprocess
import sys
import traceback
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]


class Run:
    """One forked run."""

    def __init__(self, nursery, pid):
        self.nursery, self.pid = nursery, pid

    def signal(self, number):
        os.kill(self.pid, number)  # not reaped yet, so the number is still its own

    def wait(self):
        """Its exit code; negative for the signal that ended it."""
        self.nursery.stdin.write(f"{self.pid}\n")
        self.nursery.stdin.flush()
        return int(self.nursery.stdout.readline())


@contextmanager
def nursery():
    """Give ``start(store, plan, **options)``, which runs ``plans.plan(**plan)`` in a process of its own."""
    settings = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)])}
    command = [sys.executable, "-W", "error", "-m", "tests.sweep.nursery"]
    with subprocess.Popen(
        command, cwd=ROOT, env=settings, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "ready\n"

        def start(store, plan, **options):
            process.stdin.write(json.dumps([str(store), plan, options]) + "\n")
            process.stdin.flush()
            return Run(process, int(process.stdout.readline()))

        try:
            yield start
        finally:
            process.stdin.close()


def main():
    import numba  # noqa: F401
    import xarray  # noqa: F401
    import zarr  # noqa: F401

    from grazing import sweep
    from grazing.outcome import GrazingError
    from grazing.studies.plan import run_plan
    from tests.sweep import plans

    run_plan(plans.plan(), threads=1)  # no thread may run when we fork
    print("ready", flush=True)
    for line in sys.stdin:
        order = json.loads(line)
        if isinstance(order, int):
            print(os.waitstatus_to_exitcode(os.waitpid(order, 0)[1]), flush=True)
            continue
        store, plan, options = order
        pid = os.fork()
        if pid == 0:
            code = 1
            try:
                shard = options.pop("shard", None)
                sweep.run(plans.plan(**plan), store, shard=shard and tuple(shard), **options)
                code = 0
            except KeyboardInterrupt:
                code = 130
            except GrazingError as error:
                print(error, file=sys.stderr)
                code = 2
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(code)
        print(pid, flush=True)


if __name__ == "__main__":
    main()
