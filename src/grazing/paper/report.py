"""The report: all figures, a contact sheet, and the claims of the paper with their verdicts."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grazing.interrupt import held_back
from grazing.outcome import InputError
from grazing.paper import FIGURES
from grazing.paper.drawn import BESIDE, module_of
from grazing.paper.files import folder, write

if TYPE_CHECKING:
    from grazing.paper.claims import Claim
    from grazing.paper.run import Run

Progress = Callable[[int, int, str], None]

#: Modules with the claims, in the order of the paper.
CLAIMS = (
    "claims_introduction",
    "claims_flow_windows",
    "claims_zero_time",
    "claims_local_map",
    "claims_reduction",
    "claims_gap_map",
    "claims_chaos",
    "claims_propositions",
    "claims_asymptotics",
)
#: The order of computation: what compiles and runs quickly first, so that there is something to draw meanwhile.
ORDER = ("3.1", "3.2", "3.4", "3.6", "3.3", "3.5", "3.7", "1.2", "1.5", "2.2", "2.1", "1.6", "1.3")

#: What draws, imported while there is one thread: an import that is interrupted can leave that of another waiting.
DRAWS = ("matplotlib.style", "matplotlib.backends.backend_pdf", "grazing.plot.style")


def report(
    out: str | Path = "out/paper",
    figures: str | Iterable[str] | None = None,
    size: str = "paper",
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Draw the figures of the paper, check its claims and write both to a folder.

    Parameters
    ----------
    out : str or Path
        The folder; made if need be.
    figures : str or iterable of str, optional
        Which of :data:`grazing.paper.FIGURES`, such as ``"1.6"`` or ``["1.6", "3.2"]``; default: all. With a selection
        the claims are those that belong to these figures.
    size : {"small", "paper", "large"}
        How many parameter values and random starts.
    progress : callable, optional
        ``progress(done, total, what)`` after each step.

    Returns
    -------
    dict
        ``folder``, ``figures`` (names), ``files`` (all written, in order), ``claims`` (their number), ``verdicts``
        (number of each), ``differs`` (ids of the claims that differ).

    Raises
    ------
    InputError
        For an unknown figure or size, or a folder that cannot be written to; nothing is overwritten then.

    Notes
    -----
    Every file is written whole: beside its place under another name, then renamed. ``claims.json`` comes last.
    """
    names = selected(figures)
    from grazing.paper.run import SIZES, Run

    if size not in SIZES:
        raise InputError(f"size is {size!r}; allowed are {', '.join(SIZES)}: choose one of them")
    place = folder(out)
    groups = list(chosen_groups(names))
    beside = [BESIDE] if {"1.6", "3.2"} <= set(names) else []
    tell = _Teller(progress, len(names) + len(beside) + len(groups))
    run = Run(size)
    files: list[str] = []
    for module in DRAWS:
        with held_back():
            import_module(module)
    with ThreadPoolExecutor(1) as pool:
        pending = {pool.submit(_data, run, name): name for name in [*sorted(names, key=ORDER.index), *beside]}
        try:
            for done in as_completed(pending):
                files += drawn(place, pending[done], done, size)
                tell(f"Figure {pending[done]}")
        except BaseException:
            run.stop()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    claims: list[Claim] = []
    for title, group in groups:
        claims += group(run)
        tell(title)
    from grazing.paper.page import page

    records = [claim.record() for claim in claims]
    files.append(write(place / "index.html", page(names, records, run, size, bool(beside))).name)
    text = json.dumps(records, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    files.append(write(place / "claims.json", text).name)
    return {"folder": str(place), "figures": list(names), "size": size, "files": sorted(files), **counted(records)}


def counted(records: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the number of claims and of each verdict, and which claims differ."""
    verdicts = Counter(record["verdict"] for record in records)
    return {
        "claims": len(records),
        "verdicts": {verdict: verdicts[verdict] for verdict in ("agrees", "corrected", "differs")},
        "differs": [record["id"] for record in records if record["verdict"] == "differs"],
    }


def selected(figures: str | Iterable[str] | None) -> tuple[str, ...]:
    """Return the names of figures in the order of the paper, or refuse those that do not exist."""
    if figures is None:
        return FIGURES
    wanted = [str(name) for name in ([figures] if isinstance(figures, str) else figures)]
    for name in wanted:
        if name not in FIGURES:
            raise InputError(
                f"figure {name!r} is not one that can be drawn; allowed are {', '.join(FIGURES)} "
                "(1.1 and 1.4 are photographs): choose from these"
            )
    if not wanted:
        raise InputError(
            f"no figure is selected; allowed are {', '.join(FIGURES)}: name one or leave the selection out"
        )
    return tuple(name for name in FIGURES if name in wanted)


def chosen_groups(names: tuple[str, ...]) -> Iterator[tuple[str, Callable[[Run], Iterator[Claim]]]]:
    """Return the groups of claims that belong to the figures, each with a title."""
    for module in CLAIMS:
        for about, group in import_module(f"grazing.paper.{module}").GROUPS:
            if set(about) <= set(names):
                yield f"claims: {group.__name__.replace('_', ' ')}", group


def drawn(place: Path, name: str, data: Future[Any], size: str) -> list[str]:
    """Draw a figure and write it as PNG and PDF."""
    from grazing.plot.style import rendered, styled

    module = module_of(name)
    parameters = getattr(module, "PARAMETERS", {})
    fig = module.draw(data.result())
    fig.get_layout_engine().execute(fig)
    with styled():
        fig.set_layout_engine(None)  # laid out once: both files look the same, and are drawn once each
    origin = {"figure": name, "parameters": parameters, "size": size, "seed": 0}
    return [
        write(place / f"figure-{name}.{kind}", rendered(fig, kind, f"Figure {name}: {module.TITLE}", origin)).name
        for kind in ("png", "pdf")
    ]


def _data(run: Run, name: str) -> Any:
    return run.once("beside", lambda: module_of(BESIDE).compute(run)) if name == BESIDE else run.figure(name)


class _Teller:
    """Counts the steps of the report and tells them."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self.progress, self.total, self.done = progress, total, 0

    def __call__(self, what: str) -> None:
        self.done += 1
        if self.progress is not None:
            self.progress(self.done, self.total, what)
