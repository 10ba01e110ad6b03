"""``grazing sweep``: studies of any size, chunk by chunk into a store that can be stopped and resumed."""

from __future__ import annotations

import json as text
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, Parameter

from grazing.cli import progress
from grazing.cli.own import OwnMap, OwnModel, named_here
from grazing.cli.whole import whole_number
from grazing.outcome import InputError, printable, quoted_file, shown

DONE, FAILED, INCOMPLETE = 0, 1, 3

app = App(
    name="sweep",
    help="Compute a study chunk by chunk into a store; stop and resume it at will.",
    help_format="plaintext",
    default_parameter=Parameter(negative=(), json_list=False),
)

Store = Annotated[Path, Parameter(name="STORE", help="Folder of the store, such as chart.zarr.")]
Changes = Annotated[str, Parameter(name="NAME=...", help="Changes to the file: d=0.05:0.16:500 or V=0.3.")]
Shard = Annotated[
    str | None, Parameter(help="Compute share I of N; shards may run at the same time, on any machines.", metavar="I/N")
]
Chunk = Annotated[
    str | None,
    Parameter(help="Cells in a chunk, or along axes: d=10,V=20. About a second's work if not given.", metavar="N"),
]
Cluster = Annotated[
    str | None,
    Parameter(
        help="Dask cluster: local, an address such as tcp://host:8786, or a queue such as slurm. Threads if not given.",
        metavar="KIND",
    ),
]
Workers = Annotated[
    int | None,
    Parameter(help="Processes of a local cluster, or jobs in the queue.", metavar="N", converter=whole_number),
]
Extra = Annotated[
    list[str] | None,
    Parameter(
        help="Setting of the cluster, such as cores=8 or walltime=02:00:00; may be repeated.", metavar="NAME=VALUE"
    ),
]
Threads = Annotated[
    int | None,
    Parameter(
        help="Threads; one per processor if not given. The result does not depend on it.",
        metavar="N",
        converter=whole_number,
    ),
]
OtherCode = Annotated[
    bool,
    Parameter(
        help="Go on although this is other code, or another version, than the store was begun with. "
        "On a terminal it is asked for.",
        show_default=False,
    ),
]
Fsync = Annotated[bool, Parameter(help="Force every chunk to the disk before it counts as done.", show_default=False)]
Json = Annotated[bool, Parameter(help="Print the result as one JSON object.", show_default=False)]
Quiet = Annotated[bool, Parameter(help="Show no progress.", show_default=False, alias="-q")]


@app.command(sort_key=0)
def run(
    config: Annotated[Path, Parameter(name="CONFIG", help="TOML file, such as one that --dump-config printed.")],
    store: Store,
    /,
    *given: Changes,
    map: OwnMap = None,
    model: OwnModel = None,
    shard: Shard = None,
    chunk: Chunk = None,
    cluster: Cluster = None,
    workers: Workers = None,
    cluster_option: Extra = None,
    threads: Threads = None,
    dry_run: Annotated[
        bool, Parameter(help="Print size, memory and estimated time, and compute nothing.", show_default=False)
    ] = False,
    other_code: OtherCode = False,
    fsync: Fsync = False,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compute a study into a store; what is there already is kept.

    Exit code 0 when the store is complete, 3 when shards are still missing.
    """
    from grazing import sweep
    from grazing.catalogue import studies
    from grazing.cli.options import asked_from
    from grazing.config import plan_of
    from grazing.config.toml import read_toml

    share, pieces = _shard(shard), _chunk(chunk)
    study = read_toml(config).get("study")
    if not isinstance(study, str) or study not in studies():
        said = "study is missing; give one of" if study is None else f"study = {shown(study)}; allowed are"
        raise InputError(f"{config}: {said} {', '.join(studies())}")
    plan = plan_of(asked_from(study, given, {"map": map, "model": model}, config).recipe)
    if dry_run:
        found = sweep.estimate(plan, pieces, threads=threads)
        return _say(asdict(found), str(found), json)
    with (
        resumable(store, {"map": map, "model": model}),
        _executor(cluster, workers, cluster_option) as executor,
        progress.counted("cells", quiet) as show,
    ):
        options = {"shard": share, "executor": executor, "threads": threads, "progress": show, "fsync": fsync}
        status = asked(partial(sweep.run, plan, store, chunk=pieces, **options), other_code)
    return _report(status, json)


@app.command(sort_key=1)
def resume(
    store: Store,
    /,
    *,
    map: OwnMap = None,
    model: OwnModel = None,
    shard: Shard = None,
    cluster: Cluster = None,
    workers: Workers = None,
    cluster_option: Extra = None,
    threads: Threads = None,
    other_code: OtherCode = False,
    fsync: Fsync = False,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Go on with a sweep: compute the chunks that are missing.

    Exit code 0 when the store is complete, 3 when shards are still missing.
    """
    from grazing import sweep

    share = _shard(shard)
    with (
        resumable(store, {"map": map, "model": model}),
        _executor(cluster, workers, cluster_option) as executor,
        progress.counted("cells", quiet) as show,
    ):
        options = {"shard": share, "executor": executor, "threads": threads, "progress": show, "fsync": fsync}
        status = asked(partial(sweep.resume, store, _plan(store, map, model), **options), other_code)
    return _report(status, json)


@app.command(sort_key=2)
def status(store: Store, /, *, json: Json = False) -> int:
    """Say how far a sweep is; it may be running.

    Exit code 0 when the store is complete, 3 when it is not.
    """
    from grazing import sweep

    return _report(sweep.status(store), json, hint=False)


@app.command(sort_key=3)
def verify(
    store: Store,
    /,
    *,
    map: OwnMap = None,
    model: OwnModel = None,
    share: Annotated[float, Parameter(help="Share of the chunks that are computed again.")] = 0.01,
    seed: Annotated[int, Parameter(help="Chooses the chunks.")] = 0,
    repair: Annotated[
        bool,
        Parameter(
            help="Put back metadata and coordinates, and mark chunks with differences as missing, so that resume "
            "computes them again.",
            show_default=False,
        ),
    ] = False,
    threads: Threads = None,
    other_code: OtherCode = False,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Read a store, compute a sample of it again and compare the bits.

    Exit codes: 0 no differences, 1 differences (or files put back), 3 no differences in a store that is not complete.
    """
    from grazing import sweep

    with progress.counted("chunks", quiet) as show:
        plan = _plan(store, map, model)
        found = sweep.verify(
            store, share, seed, plan, repair=repair, other_code=other_code, threads=threads, progress=show
        )
    _say(asdict(found) | {"ok": found.ok}, str(found), json)
    if not found.ok:
        return FAILED
    return DONE if sweep.status(store).complete else INCOMPLETE


@app.command(sort_key=4)
def unlock(
    store: Store,
    /,
    *,
    force: Annotated[
        bool, Parameter(help="Remove the lock of a process that still seems to run, too.", show_default=False)
    ] = False,
    json: Json = False,
) -> int:
    """Remove the locks of processes that are dead, and say whose they were."""
    from grazing import sweep

    removed = sweep.unlock(store, force)
    none = f"{printable(str(store), newlines=False)} is not locked"
    words = "\n".join(f"removed the lock of {lock}" for lock in removed) or none
    return _say({"removed": [asdict(lock) for lock in removed]}, words, json)


def asked(go: Callable[..., Any], other_code: bool) -> Any:
    """Run or resume; on a terminal, ask whether other code may go on."""
    from grazing.sweep.same import OtherCodeError

    try:
        return go(other_code=other_code)
    except OtherCodeError as error:
        if not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise
        print(f"{error}\nGo on with this code all the same? [y/N] ", end="", file=sys.stderr, flush=True)
        if sys.stdin.readline().strip().lower() not in ("y", "yes"):
            raise
        return go(other_code=True)


@contextmanager
def resumable(store: str | Path, named: Mapping[str, Any]) -> Iterator[None]:
    """Say after Ctrl-C how to go on, if there is a store already, with the code of one's own that this call named."""
    try:
        yield
    except KeyboardInterrupt:
        if not os.path.isfile(Path(store) / "zarr.json"):
            raise
        from grazing.config.own import KEYS, is_own

        own = [f"--{key} {quoted_file(named[key])}" for key in KEYS if named.get(key) and is_own(named[key])]
        command = " ".join(["grazing sweep resume", quoted_file(str(store)), *own])
        raise KeyboardInterrupt(f"interrupted; {store} keeps what is done: go on with '{command}'.") from None


def _plan(store: Path, map: str | None, model: str | None) -> Any:
    """Return the plan of a store that is made of code which this call names; None if it names none."""
    if map is None and model is None:
        return None
    from grazing.sweep.opened import open_existing
    from grazing.sweep.store import folder_of
    from grazing.sweep.task import plan_from_recipe

    found = open_existing(folder_of(store))
    return plan_from_recipe(found, own=named_here(found.recipe, map, model, store))


def _shard(shard: str | None) -> tuple[int, int] | None:
    if shard is None:
        return None
    found = re.fullmatch(r"\s*(\d+)\s*/\s*(\d+)\s*", shard)
    if not found:
        raise InputError(f"--shard {shard}; give I/N, share I of N, such as 3/100")
    return int(found[1]), int(found[2])


def _chunk(chunk: str | None) -> int | dict[str, int] | None:
    if chunk is None:
        return None
    try:
        if "=" not in chunk:
            return int(chunk)
        return {name.strip(): int(size) for name, _, size in (part.partition("=") for part in chunk.split(","))}
    except ValueError:
        raise InputError(f"--chunk {chunk}; give a number of cells, or numbers along axes: d=10,V=20") from None


def _executor(kind: str | None, workers: int | None, options: list[str] | None) -> Any:
    """Return a cluster as a context, or one of nothing: threads of this process."""
    if kind is None:
        if workers is not None or options:
            raise InputError("--workers and --cluster-option belong to --cluster; threads are chosen with --threads")
        return nullcontext()
    from grazing.sweep import cluster

    given = {}
    for item in options or ():
        name, equals, value = item.partition("=")
        if not equals or not name.isidentifier():
            raise InputError(f"--cluster-option {item}; give NAME=VALUE, such as cores=8")
        given[name] = int(value) if value.isdigit() else value
    return cluster(kind, workers, **given)


def _report(status: Any, json: bool, hint: bool = True) -> int:
    """Print how far a sweep is, and say by the exit code whether it is complete."""
    summary = asdict(status) | {"complete": status.complete}
    go_on = f"\nnot complete: 'grazing sweep resume {quoted_file(str(status.path))}' goes on"
    _say(summary, str(status) + (go_on if hint and not status.complete else ""), json)
    return DONE if status.complete else INCOMPLETE


def _say(summary: Mapping[str, Any], words: str, json: bool) -> int:
    with suppress(BrokenPipeError):  # who reads no further may still ask for the exit code
        print(text.dumps(summary, default=str) if json else printable(words))
        sys.stdout.flush()
    return DONE
