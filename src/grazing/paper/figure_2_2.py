"""Figure 2.2: the map (2.4)/(2.5) against the numerical stroboscopic map."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from grazing.maps.discontinuity import discontinuity_map
from grazing.maps.map import Map
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.model import pinball
from grazing.oscillator.trajectory import trajectory
from grazing.paper.drawing import mark
from grazing.paper.run import Run
from grazing.plot.map_graph import graph_of, map_graph
from grazing.plot.style import DOUBLE, GRAZE, INK, PERIODS, panels, styled

TITLE = "The local map against the flow"
V0 = -0.23
PARAMETERS: dict[str, Any] = {
    "alpha": 3,
    "k": 1,
    "omega": 2.1,
    "t0": 2.2,
    "r": 0.8,
    "V": 0.2,
    "d": 0.11,
    "v(0)": V0,
    "u(0)": "0.01 to 0.06",
}
CAPTION = (
    "State after one forcing period against u(0) for v(0) = −0.23: solid, the stroboscopic map of the full oscillator; "
    "dashed, the map (2.4)/(2.5) with A the acceleration at each start."
)
SEE = (
    "Each map jumps at its own graze; between the two they differ by the whole jump, above both they agree to "
    "rounding, below them the square root is met: u(T) differs by less than 0.007, most just below the true graze."
)


def compute(run: Run) -> dict[str, Any]:
    """Return both graphs, the place of each jump, and the time at which the grazing orbit is lowest."""
    model = pinball(**{name: float(value) for name, value in PARAMETERS.items() if "(" not in name})
    P, Z, full = stroboscopic_map(model), discontinuity_map(model), discontinuity_map(model, order="full")
    true, local = jump(P, 0.03, 0.05), jump(Z, 0.03, 0.05)
    flow = trajectory(model, (true, V0), until=1.0, samples=20_000)
    grid = np.union1d(np.linspace(0.01, 0.06, 4001), [true, np.nextafter(true, 0), local, np.nextafter(local, 0)])
    graphs = {name: graph_of(each, grid, "u", v=V0) for name, each in (("flow", P), ("lowest", Z), ("full", full))}
    return {
        "model": model,
        "graphs": graphs,
        "graze": true,
        "local": local,
        "time": turning(flow["t"].values, flow["v"].values),
    }


def turning(t: Any, v: Any) -> float:
    """Return the time at which a falling ball turns, between two samples."""
    i = int(np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))[0])
    return float(t[i] - v[i] * (t[i + 1] - t[i]) / (v[i + 1] - v[i]))


def jump(P: Map, hits: float, misses: float) -> float:
    """Return the u(0) at which the letter of a map changes, halved to the last bit: the first start that misses."""
    letter: Callable[[float], int] = lambda u: P((u, V0))[1]  # noqa: E731
    while True:
        middle = 0.5 * (hits + misses)
        if middle in (hits, misses):
            return misses
        hits, misses = (middle, misses) if letter(middle) else (hits, middle)


def draw(data: dict[str, Any]) -> Figure:
    """Draw u(T) and v(T) with both jumps marked."""
    fig, pair = panels(DOUBLE, 72, 1, 2, sharex=True)
    for ax, coordinate in zip(pair, "uv", strict=True):
        map_graph(data["graphs"]["flow"], ax, coordinate=coordinate, colour=INK, lw=1.3, label="flow")
        map_graph(
            data["graphs"]["lowest"],
            ax,
            coordinate=coordinate,
            colour=PERIODS[1],
            lw=1.5,
            ls=(0, (4, 1.5)),
            label="map (2.4)/(2.5)",
        )
        ax.axvspan(data["graze"], data["local"], color=GRAZE, alpha=0.08, lw=0)
        mark(
            ax, data["graze"], "" if coordinate == "v" else f"true graze\n{data['graze']:.10f}", height=0.5, side="left"
        )
        mark(
            ax,
            data["local"],
            "" if coordinate == "v" else f"graze of (2.4)\n{data['local']:.10f}",
            height=0.5,
            side="right",
            colour=PERIODS[4],
        )
        ax.set(xlabel="$u(0)$", ylabel=f"${coordinate}(T)$", xlim=(0.01, 0.06))
    with styled():
        pair[1].legend(loc="best")
    return fig
