"""Claims on the local map (2.4)/(2.5): Figure 2.2."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from grazing.maps.discontinuity import zdm
from grazing.maps.normal_form import constants
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.constants import forcing
from grazing.oscillator.flight import modes
from grazing.oscillator.model import pinball
from grazing.paper.claims import Claim, claim
from grazing.paper.exact_zdm import flown
from grazing.paper.figure_2_2 import V0
from grazing.paper.run import Run


def local_map(run: Run) -> Iterator[Claim]:
    """Check (2.4), (2.5) and Figure 2.2: where each map jumps."""
    data = run.figure("2.2")
    flow, lowest = data["graphs"]["flow"], data["graphs"]["lowest"]
    u = flow.starts
    yield claim("2.2-graze", "Figure 2.2", "a graze occurs at u(0) of about", "0.038", data["graze"])
    yield claim("2.2-graze-exact", "reference", "the true graze is at u(0)", "0.0383355822", data["graze"])
    yield claim("2.2-graze-time", "reference", "and happens at t", "0.332406", data["time"])
    yield claim(
        "2.2-jump", "reference", "the map (2.4), with A at each state, jumps at u(0)", "0.0395865740", data["local"]
    )
    off = np.abs(flow.images - lowest.images).max(axis=1)
    first = float(u[np.flatnonzero(off > 1e-12)[-1] + 1])
    yield claim(
        "2.2-exact-from",
        "section 2.1",
        "both expressions agree exactly for u(0) above",
        "0.038",
        first,
        slip=13,
        note="between the two grazes they differ by the whole jump",
    )
    above = float(off[u >= data["local"]].max())
    yield claim(
        "2.2-exact", "section 2.1", "above the graze of (2.4) they agree, largest difference", 0, above, tolerance=1e-13
    )


def agreement(run: Run) -> Iterator[Claim]:
    """Check how the local map of Figure 2.2 and the flow differ below the graze."""
    data = run.figure("2.2")
    flow, lowest = data["graphs"]["flow"], data["graphs"]["lowest"]
    u = flow.starts
    between = (u >= data["graze"]) & (u < data["local"])
    least = float(np.abs(flow.images - lowest.images)[between, 0].min())
    jump, local_jump = (
        abs(float(np.diff(graph.images[:, 0])[np.flatnonzero(np.diff(graph.letters))[0]])) for graph in (flow, lowest)
    )
    yield claim(
        "2.2-between",
        "reference",
        "between the grazes both differ in u(T) by the whole jump of (2.4) or more",
        True,
        least >= local_jump - 1e-6,
        note=f"at least {least:.6f}; the jump is {local_jump:.6f} for (2.4), {jump:.6f} for the flow",
    )
    b = modes(data["model"].period - data["time"], constants(data["model"]))[1]
    yield claim(
        "2.2-jump-size",
        "section 2.1",
        "the jump is caused by V: u(T) jumps by V times the flow's response to a velocity",
        b * 0.2,
        jump,
        tolerance=1e-6,
    )
    yield claim(
        "2.2-root",
        "Figure 2.2",
        "next to the graze the flow map behaves like a square root, exponent",
        "0.5",
        square_root(flow.starts, flow.images[:, 0], data["graze"]),
        tolerance=0.03,
        note="regression over the distances 1e-5 to 1e-3",
    )


def closeness(run: Run) -> Iterator[Claim]:
    """Check how close both orders come to the flow, and what A is."""
    data = run.figure("2.2")
    flow, lowest, full = (data["graphs"][name] for name in ("flow", "lowest", "full"))
    hit = flow.starts < data["graze"]
    rms = {
        name: float(np.sqrt(np.mean((flow.images - graph.images)[hit] ** 2)))
        for name, graph in (("lowest", lowest), ("full", full))
    }
    size = float(np.ptp(flow.images[hit, 0]))
    yield claim(
        "2.2-close",
        "section 2.1",
        "the local map is close to the flow below the graze: within a tenth of its range",
        True,
        rms["lowest"] < 0.1 * size,
        note=f"root mean square difference {rms['lowest']:.6f}, range of u(T) {size:.6f}",
    )
    yield claim(
        "2.2-full-order",
        "reference",
        "in Figure 2.2 the lowest order is closer to the flow than the map with all terms of (2.2) and (2.3)",
        True,
        rms["lowest"] < rms["full"],
        note=f"root mean square difference {rms['full']:.6f} with all terms, {rms['lowest']:.6f} at lowest order",
    )
    F = forcing(0.0, constants(data["model"]))[0]
    yield claim(
        "2.2-acceleration",
        "section 2.1",
        "A is the acceleration: with A = f(0) the jump would be at u(0)",
        f"{V0 * V0 / (2.0 * F):.6f}",
        data["local"],
        slip=8,
        note="at a state (u, v) the acceleration is f − αv − k²u, here with αv = −0.69; it varies along the curve",
    )
    yield claim(
        "2.5-composed",
        "(2.5)",
        "P_T ∘ P_ZDM, with the zero-time map of (2.4), is P_T at the border, where its root vanishes: defect in u(T)",
        0,
        composed(run),
        tolerance=1e-9,
        slip=7,
        note="(2.5) is P_T alone: the zero-time map of (2.4) would add V to v",
    )


def square_root(u: NDArray[np.float64], image: NDArray[np.float64], graze: float) -> float:
    """Return the exponent of the image's change against the distance below the graze."""
    below = np.flatnonzero(u < graze)
    limit = image[below[-1]]
    distance = graze - u[below[:-1]]
    near = (distance > 1e-5) & (distance < 1e-3)
    return float(np.polyfit(np.log(distance[near]), np.log(np.abs(image[below[:-1]][near] - limit)), 1)[0])


def composed(run: Run) -> float:
    """Return how far P_T after the zero-time map of (2.4) is from P_T, in u(T), where its root vanishes."""
    data = run.figure("2.2")
    model, start = data["model"], (float(np.nextafter(data["local"], 0.0)), V0)
    kicked = zdm(model, order="lowest")(start)[0]
    after, free = (flown(model, 0.0, (float(u), float(v)), model.period) for u, v in (kicked, start))
    return abs(after[0] - free[0])


def jump_in_V(run: Run) -> Iterator[Claim]:
    """Check the abstract: the size of the discontinuity is proportional to V."""
    sizes = []
    for V in (0.1, 0.2):
        P = stroboscopic_map(pinball(alpha=3, k=1, omega=2.1, t0=2.2, r=0.8, d=0.11, V=V))
        graze = run.figure("2.2")["graze"]
        sizes.append(abs(float(P((graze, V0))[0][0] - P((np.nextafter(graze, 0.0), V0))[0][0])))
    yield claim(
        "jump-V",
        "abstract",
        "the jump of the map is proportional to V: twice V, the jump grows by",
        "2",
        sizes[1] / sizes[0],
        tolerance=1e-6,
    )


GROUPS = (
    (("2.2",), local_map),
    (("2.2",), agreement),
    (("2.2",), closeness),
    (("2.2",), jump_in_V),
)
