"""Where a reduction holds: its words beside those of the flow, cell by cell over two parameters.

Both maps start from the same balls. The flow is seen half a period after the graze, so that impacts near the graze
fall in the middle of a period and the number of impacts in it, 0 or 1, is the letter L or R of the reduced maps, which
stand at the phase of the graze. A start reaches them by a free flight of half a period, as (2.5) has it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.compare.reductions import Reductions
from grazing.maps.map import Map
from grazing.maps.pieces import joined, pieces
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.model import Oscillator, checked_model
from grazing.oscillator.spring import refuse_stiffness
from grazing.outcome import InputError, shown
from grazing.parameter import unknown
from grazing.studies import labels
from grazing.studies.classify import APERIODIC, UNDECIDED, settled_columns
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import Runs, checked_runs, describe_values, tolerance_config

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
#: What an orbit settles on: word and period.
Label = tuple[str, int]

#: The maps that can stand beside the flow.
REDUCTIONS = ("gap", "linearised", "lowest", "full", "corrected")
#: How flow and reduction agree in a cell.
AGREEMENT = {
    0: "same: the same set of words and periods",
    1: "partly: some of them in common",
    2: "none: none in common",
    3: "beyond: no orbit of the flow has a word in L and R, since all have several impacts in a period, chatter or lie",
    4: "outside_form: the model has no such reduction here",
}
SAME, PARTLY, NONE, BEYOND, OUTSIDE = AGREEMENT
#: Attractors of a cell that are listed at most.
RANKS = 6
#: The period of a rank that no attractor holds.
UNUSED = -3
TAKEN = (
    "rank", "agreement", "overlap", "graze", "flow_word", "flow_period", "flow_share", "reduced_word",
    "reduced_period", "reduced_share",
)  # fmt: skip


@planned
def validity(
    model: Oscillator,
    params: Mapping[str, ArrayLike],
    *,
    rung: str = "gap",
    starts: int | ArrayLike = 16,
    transient: int = 500,
    keep: int = 64,
    seed: int = 0,
    threads: int | None = None,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """Return where a reduction of the oscillator has the words of the oscillator, as two parameters vary.

    Parameters
    ----------
    model : Oscillator
        Any damped model.
    params : mapping of str to array_like
        Two of its parameters with their values, such as ``{"d": ..., "V": ...}``. The graze must depend on one.
    rung : {"gap", "linearised", "lowest", "full", "corrected"}
        The reduction: the gap map (2.6), the map in (x, y) before it, or a discontinuity map.
    starts, transient, keep, seed, threads, arithmetic, box, progress
        As in :func:`grazing.chart`; starts are states (u, v) of the flow, half a period after the graze.

    Returns
    -------
    xarray.Dataset
        On the dimensions of the parameters: ``agreement``, 0 same, 1 partly, 2 none, 3 beyond the reduction (each
        orbit of the flow has a period with several impacts, chatters or lies), 4 outside its form; ``overlap`` of the
        shares of the words, 1 less their distance in total variation.
        Also on "rank", the most common first: ``flow_word``, ``flow_period``, ``flow_share``, ``reduced_word``,
        ``reduced_period`` and ``reduced_share``, with words in L and R; period 0 stands for none seen, -2 for orbits
        that ended, -3 for no further attractor. ``graze`` on the other parameter: where the steady response grazes.

    Raises
    ------
    InputError
        For an input out of range.
    OutsideForm
        If the graze depends on neither parameter.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.compare.validity import validity
    >>> found = validity(gz.pinball(V=0.4), {"d": [0.05, 0.127], "V": [0.1, 0.4]}, starts=8)
    >>> found.agreement.sel(V=0.1).values.tolist(), found.flow_word.sel(d=0.127, V=0.4).values[0]
    ([2, 0], 'LLLR')
    """
    checked_model(model)
    refuse_stiffness(model, "the validity of a reduction")
    if not isinstance(rung, str) or rung not in REDUCTIONS:
        raise InputError(f"rung is {shown(rung)}; allowed are {', '.join(REDUCTIONS)}")
    if not isinstance(params, Mapping) or len(params) != 2:
        raise InputError(
            f"params is {shown(params)}; give two parameters with their values, such as {{'d': ..., 'V': ...}}"
        )
    for name in params:
        if name not in model.params:
            raise unknown(name, model.params, "the model")
    P = stroboscopic_map(model)
    runs = checked_runs(P, params, starts, transient, keep, seed, arithmetic, box, TAKEN)
    reductions = Reductions(model, runs, rung)
    ranks = min(runs.settings.lanes, RANKS)

    def compute(cells: Ints, arrays: Arrays) -> Iterator[None]:
        places = [reductions.place(cell) for cell in cells.tolist()]
        rows, lanes = runs.rows(cells), runs.states(cells)
        rows[:, -1] = [place.strobe for place in places]  # the phase comes last
        inside = np.array([place.row is not None for place in places])
        reduced = np.array([place.start(w) for place, w in zip(places, lanes, strict=True) if place.row is not None])
        flow = yield from settle(P, rows, lanes, runs)
        other: list[list[Label]] = []
        if inside.any():
            own = np.array([place.row for place in places if place.row is not None])
            other = yield from settle(reductions.map, own, reduced, runs)
        following = iter(other)
        for i, (seen, good) in enumerate(zip(flow, inside.tolist(), strict=True)):
            write(arrays, i, in_letters(seen), in_letters(next(following)) if good else None, ranks)

    names = " and ".join(runs.axes)
    return Plan(
        P=P,
        title=f"where the words of the {reductions.map.name} are those of the flow, in {names}",
        config={
            "study": "validity",
            "rung": rung,
            "axes": list(runs.axes),
            "parameters": {name: describe_values(values) for name, values in runs.axes.items()},
            **runs.config,
            **tolerance_config(runs.settings.keep),
        },
        axes=runs.axes,
        axis_attrs={name: labels.quantity(P, name) for name in runs.axes},
        sizes={"rank": ranks},
        variables=_variables(runs.settings.keep),
        compute=compute,
        together=runs.together,
        work=2 * runs.work,
        finish=reductions.finish,
    )


plan = validity.plan


def _variables(keep: int) -> dict[str, Variable]:
    agreement = {
        "long_name": "agreement of the words of flow and reduction",
        "flag_values": np.array(list(AGREEMENT), np.int8),
        "flag_meanings": " ".join(text.partition(":")[0] for text in AGREEMENT.values()),
        "meaning": "; ".join(AGREEMENT.values()),
    }
    period = labels.period_attributes(keep // 2)
    period["flag_values"] = np.array([0, -2, UNUSED], np.int32)
    period["flag_meanings"] = "none_seen ended no_further_attractor"
    found = {
        "agreement": Variable((), "int8", agreement),
        "overlap": Variable(
            (),
            "float64",
            {"long_name": "overlap of the shares of the words: 1 less their distance in total variation", "units": "1"},
        ),
    }
    for of in ("flow", "reduced"):
        found |= {
            f"{of}_word": Variable(("rank",), "text", labels.word_attributes(), labels.longest_word(keep // 2)),
            f"{of}_period": Variable(("rank",), "int32", period),
            f"{of}_share": Variable(("rank",), "float64", {"long_name": "share of the starts", "units": "1"}),
        }
    return found


def settle(P: Map, rows: Floats, lanes: Floats, runs: Runs) -> Any:
    """Run orbits of a map; an iterator that returns word and period of each, cell by cell."""
    _starts, transient, keep, _seed, arithmetic, _box = runs.settings
    parts = []
    for part in pieces(P, rows, np.ascontiguousarray(lanes), transient, keep, arithmetic):
        parts.append(part)
        yield
    settled = settled_columns(P, rows, joined(parts))
    yield
    period = np.where(settled.period == APERIODIC, UNDECIDED, settled.period)
    pairs = zip(settled.words.tolist(), period.tolist(), strict=True)
    return [list(zip(words, periods, strict=True)) for words, periods in pairs]


def in_letters(orbits: list[Label]) -> list[Label]:
    """Return labels with numbers of impacts as letters, 0 as L and 1 as R; as they are if a period has more."""
    return [
        (word.replace("0", "L").replace("1", "R"), period) if set(word) <= {"0", "1"} else (word, period)
        for word, period in orbits
    ]


def write(arrays: Arrays, i: int, flow: list[Label], reduced: list[Label] | None, ranks: int) -> None:
    """Write how the labels of one cell agree."""
    shares = [Counter(flow), Counter(reduced or [])]
    sets = [set(share) for share in shares]
    if reduced is None:
        arrays["agreement"][i] = OUTSIDE
    elif all(word and not set(word) <= {"L", "R"} for word, _period in flow):
        arrays["agreement"][i] = BEYOND
    else:
        arrays["agreement"][i] = SAME if sets[0] == sets[1] else PARTLY if sets[0] & sets[1] else NONE
    alike = sum((shares[0] & shares[1]).values())
    arrays["overlap"][i] = np.nan if reduced is None else alike / len(flow)
    for of, share in zip(("flow", "reduced"), shares, strict=True):
        arrays[f"{of}_period"][i] = UNUSED
        several = sorted(share.items(), key=lambda item: (-item[1], item[0][1], item[0][0]))
        for rank, ((word, period), count) in enumerate(several[:ranks]):
            arrays[f"{of}_word"][i, rank], arrays[f"{of}_period"][i, rank] = word, period
            arrays[f"{of}_share"][i, rank] = count / len(flow)
