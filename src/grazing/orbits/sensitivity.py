"""How the edges of windows move with every parameter of the model: their derivatives, by the implicit function theorem.

At an edge an orbit satisfies the closing equation and one condition more; both are analytic in the phase of the impact
and in all parameters. One linear equation with their derivatives there gives how the edge moves.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grazing import late
from grazing.kernel.compile import call, compiled
from grazing.kernel.lanes import unpacker
from grazing.orbits.closure import TESTS, Closing, closing, impact_state, impact_velocities
from grazing.orbits.one_sided import EPS
from grazing.orbits.rounding import noise
from grazing.orbits.survey import PHASE, Family, families, survey
from grazing.orbits.windows import EDGES, windows
from grazing.orbits.word_windows import PIECES
from grazing.oscillator.constants import constants_of
from grazing.oscillator.flight import anchored, flight
from grazing.oscillator.model import Oscillator, checked_model
from grazing.oscillator.windows import series

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Columns of an evaluation: G, dG/dphi, then the test functions but the clearance, then height and velocity of the
#: flight at a given time after the impact.
G, FOLD, FIRST_TEST, HEIGHT, FALL = 0, 1, 2, 8, 9
COLUMNS = 10
#: Place of the frequency in the row of a family's parameters: alpha k omega ...
OMEGA = 2


def weights_of(nodes: Floats, order: int) -> Floats:
    """Return the weights of the values at nodes for the derivative at 0, of this order of accuracy."""
    near = np.argsort(np.abs(nodes), kind="stable")[: order + 1]
    powers = nodes[near][None, :] ** np.arange(order + 1)[:, None]
    weights = np.zeros(len(nodes))
    weights[near] = np.linalg.solve(powers, np.eye(order + 1)[1])
    return weights


#: Differences: nodes, weights of order 8 and of order 6. One-sided where the equations end, as for no damping at all.
CENTRAL, ONE_SIDED = (
    (nodes, weights_of(nodes, 8), weights_of(nodes, 6)) for nodes in (np.arange(-4.0, 5.0), np.arange(9.0))
)
#: Steps tried, in units of a quantity's size: the one whose two results agree best is taken.
STEPS = np.array([4.0**-k for k in range(2, 9)])
#: An edge counts as a solution of its equations if they put it no farther away than this, relative to the span.
AT_EDGE = 1e-6


def sensitivity(
    model: Oscillator,
    name: str,
    N: int | Iterable[int] = range(1, 8),
    span: tuple[float, float] | None = None,
    samples: int = 2000,
) -> xr.Dataset:
    """Return the derivatives of every edge of every window with respect to every parameter of the model.

    Parameters
    ----------
    model, name, N, span, samples
        As for :func:`grazing.windows`: the windows are intervals of the parameter ``name``.

    Returns
    -------
    xarray.Dataset
        ``derivative`` (window, edge, parameter): the change of the edge per unit of each parameter, the others but
        ``name`` held; 0 for ``name`` itself, which the edge does not depend on. ``error`` (window, edge, parameter):
        an estimate of its error. ``value`` and ``type`` (window, edge) are the edges, low and high; ``N`` and
        ``piece`` (window) as in :func:`grazing.windows`. NaN at an edge of type end, or one that was only bracketed.

    Raises
    ------
    InputError
        For an unknown parameter, a period that is no whole number >= 1, or a span out of range.
    OutsideForm
        For a reset law that is not known to be affine.

    Notes
    -----
    Unknown are the phase phi of the impact and the edge p, with G(phi, p, q) = 0 and one condition E(phi, p, q) = 0:
    the test function of a pd, ns, v0, law or st, dG/dphi at a fold (lp). At a graze there is one unknown more, the
    time s after the impact, and the flight's height and velocity vanish there. Then

        d(phi, p)/dq = -[d(G, E)/d(phi, p)]^-1 d(G, E)/dq.

    The equations are closed forms, their derivatives differences of order 8, with the step at which they agree best
    with those of order 6; ``error`` carries this difference, and rounding as it is measured, through the linear
    equation.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.orbits.sensitivity import sensitivity
    >>> moved = sensitivity(gz.pinball(V=0.4), "d", N=3)
    >>> upper = moved.derivative.sel(window=0, edge="high")
    >>> [f"{name} {float(upper.sel(parameter=name)):+.6f}" for name in ("r", "V", "cos1", "d")]
    ['r -0.000790', 'V -0.017171', 'cos1 +0.130150', 'd +0.000000']
    """
    checked_model(model)
    model.refuse_base("a sensitivity", list(model.params))
    table = windows(model, name, N, span, samples)
    names = list(model.params)
    shape = table.sizes["window"], 2, len(names)
    derivative, error = np.full(shape, np.nan), np.full(shape, np.nan)
    low, high = table.attrs["span"]
    for w in range(shape[0]):
        row = table.isel(window=w)
        [family] = [f for f in families(model, int(row["N"]), name) if PIECES[f.law] == str(row["piece"].values)]
        for e, side in enumerate(("low", "high")):
            kind, status = str(row[f"{side}_type"].values), str(row[f"{side}_status"].values)
            if kind == "end" or status != "zero":
                continue
            edge = Edge(family, kind, float(row[side]), int(row[f"{side}_dip"]))
            found = edge.moved(AT_EDGE * (high - low))
            if found is not None:
                derivative[w, e], error[w, e] = (part[: len(names)] for part in found)
                derivative[w, e, names.index(name)] = error[w, e, names.index(name)] = 0.0
    return _dataset(model, name, table, names, derivative, error)


# ---- one edge


class Edge:
    """An edge of a window as the solution of equations, analytic in all that they depend on.

    The variables are the phase of the impact, the time after it at which the flight touches the wall (for gr), then
    the row of the family's parameters. The two equations of the velocities are weighed by the fastest rate at the edge
    itself: off their solution the test functions depend on it, and it jumps where a harmonic of amplitude 0 begins.
    """

    def __init__(self, family: Family, kind: str, value: float, dip: int) -> None:
        self.family, self.kind, self.value, self.dip = family, kind, value, dip
        self.row = family.row.copy()
        self.row[family.position] = value
        self.own = [0, 1, 2 + family.position] if kind == "gr" else [0, 2 + family.position]
        if kind == "gr":
            self.columns = [G, HEIGHT, FALL]
        elif kind == "lp":
            self.columns = [G, FOLD]
        else:
            self.columns = [G, FIRST_TEST + TESTS.index(kind)]

    def moved(self, tolerance: float) -> tuple[Floats, Floats] | None:
        """Return the derivatives of the edge with respect to the family's parameters, and their errors.

        None where the equations are not satisfied at the edge, or do not determine it.
        """
        own = self.own
        for x in self.starts():
            slopes, errors, values = self.slopes(x)
            M = slopes[:, own]
            if not np.isfinite(slopes).all() or np.linalg.matrix_rank(M / np.abs(M).max(axis=1)[:, None]) < len(M):
                continue
            off = np.linalg.solve(M, values)
            if not abs(float(off[-1])) <= tolerance:
                continue
            x[own] -= off  # the edge itself to the last bits
            slopes, errors, _values = self.slopes(x)
            inverse = np.linalg.inv(slopes[:, own])
            moves = -inverse @ slopes[:, 2:]
            spread = np.abs(inverse) @ (errors[:, 2:] + errors[:, own] @ np.abs(moves))
            return moves[-1], spread[-1]
        return None

    def starts(self) -> list[Floats]:
        """Return the variables (phase, time, row) of orbits that may be the one at the edge, the likeliest first."""
        phases = self.phases()
        here = np.array([[phase, 0.0, *self.row] for phase in phases]).reshape(-1, 2 + len(self.row))
        values = np.abs(self.evaluated(here)[:, self.columns[1]]) if len(here) and self.kind != "gr" else None
        found = []
        for x in here if values is None else here[np.argsort(values, kind="stable")]:
            if self.kind == "gr":
                x[1] = self.touch(x)
            if np.isfinite(x).all():
                found.append(x)
        return found

    def phases(self) -> list[float]:
        """Return the phases of all orbits at the edge; at a fold, where two of them meet, the phase of the fold."""
        table, counts = survey(self.family, np.array([self.value]))
        phases = [float(phase) for phase in table[0, : counts[0], PHASE]]
        if self.kind != "lp":
            return phases
        grid = np.linspace(0.0, 2.0 * np.pi, 64 * self.family.harmonics + 1)
        rows = np.column_stack([grid, np.zeros(len(grid)), np.tile(self.row, (len(grid), 1))])
        slope = self.evaluated(rows)[:, FOLD]

        def bent(phase: float) -> float:
            return float(self.evaluated(np.array([[phase, 0.0, *self.row]]))[0, FOLD])

        return [
            float(late.optimize.brentq(bent, grid[i], grid[i + 1], xtol=1e-15, rtol=1e-15))
            for i in np.flatnonzero(slope[1:] * slope[:-1] < 0.0)
        ]

    def touch(self, x: Floats) -> float:
        """Return the time after the impact at the bottom of the dip that is the graze; NaN if there is none."""
        length = 2.0 * np.pi / self.row[OMEGA] * self.family.N
        grid = np.linspace(0.0, length, 256 * self.family.N * self.family.harmonics + 1)[1:-1]
        rows = np.tile(x, (len(grid), 1))
        rows[:, 1] = grid
        fall = self.evaluated(rows)[:, FALL]

        def velocity(s: float) -> float:
            return float(self.evaluated(np.array([[x[0], s, *x[2:]]]))[0, FALL])

        bottoms = np.flatnonzero((fall[:-1] < 0.0) & (fall[1:] >= 0.0))
        if not 1 <= self.dip <= len(bottoms):
            return float("nan")
        i = int(bottoms[len(bottoms) - self.dip])
        return float(late.optimize.brentq(velocity, grid[i], grid[i + 1], xtol=1e-15, rtol=1e-15))

    def slopes(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the derivatives (equations, variables) of the equations at x, their errors, and the values there."""
        values, scale = self.evaluated(x[None])[0, self.columns], np.maximum(np.abs(x), self.natural(x))
        moving = np.zeros(len(x))
        moving[self.own] = scale[self.own]  # in others equations may end or jump, as those of rest do in r and V
        loud = noise(lambda shifts: self.evaluated(x + shifts)[:, self.columns], values, moving)
        slopes, errors = np.empty((len(values), len(x))), np.empty((len(values), len(x)))
        which = np.arange(len(values))
        for j, size in enumerate(scale):
            for nodes, eighth, sixth in (CENTRAL, ONE_SIDED):
                rows = np.tile(x, (len(STEPS) * len(nodes), 1))
                rows[:, j] += size * (STEPS[:, None] * nodes).ravel()
                got = self.evaluated(rows)[:, self.columns].reshape(len(STEPS), len(nodes), len(values))
                h = size * STEPS[:, None]
                high, low = (np.einsum("skf,k->sf", got, weights) / h for weights in (eighth, sixth))
                rounding = np.maximum(loud, 4.0 * EPS * np.abs(got).max(axis=1)) * np.abs(eighth).sum() / h
                off = np.abs(high - low) + rounding
                off[~np.isfinite(off)] = np.inf
                best = np.argmin(off, axis=0)
                slopes[:, j], errors[:, j] = high[best, which], off[best, which]
                if np.isfinite(errors[:, j]).all():
                    break
        return slopes, errors, values

    def natural(self, x: Floats) -> Floats:
        """Return the sizes that variables near 0 count as, from the force and the frequency: no unit matters."""
        row, m = x[2:], self.family.harmonics
        rate, sigma = float(row[OMEGA]), 5 + 2 * m
        force = float(np.abs(row[4:sigma]).sum() + row[1] ** 2 * abs(row[sigma])) or 1.0
        height, speed = force / rate**2, force / rate
        times = [1.0, 1.0 / rate, rate, rate, rate, 1.0 / rate]
        return np.array([*times, *[force] * (1 + 2 * m), height, 1.0, speed, speed])

    def evaluated(self, rows: Floats) -> Floats:
        """Return what the equations need at variables (n, 2 + parameters), shape (n, COLUMNS)."""
        out = np.full((len(rows), COLUMNS), np.nan)
        run = _evaluator(self.family.kind, self.family.harmonics)
        given = np.ascontiguousarray(rows), self.row, self.family.N, self.family.law
        call(run, *given, out, who="the closing equation")
        return out


@lru_cache(maxsize=64)
def _evaluator(kind: type, harmonics: int) -> Callable[..., None]:
    unpack, constants = unpacker(kind), constants_of(harmonics)

    def run(rows: Any, edge: Any, N: int, law: int, out: Any) -> None:
        rate = constants(unpack(edge)).rate
        for i in range(len(rows)):
            c = constants(unpack(rows[i, 2:]))
            at = closing(N, law, c)
            g = Closing(at.L, rate, *at[2:])
            phi = rows[i, 0]
            out[i, 0], out[i, 1] = series(phi, g.g0, g.gc, g.gs, 1.0, 0.0)
            state = impact_state(phi, law, g, c)
            for test in range(6):
                out[i, 2 + test] = state[5 + test]
            w, _v = impact_velocities(phi, g)
            out[i, 8], out[i, 9] = flight(rows[i, 1], anchored(state[0], 0.0, w, c), c)

    return compiled(run)


# ---- result


def _dataset(
    model: Oscillator, name: str, table: xr.Dataset, names: list[str], derivative: Floats, error: Floats
) -> xr.Dataset:
    """Return the derivatives as a labelled table."""
    from grazing.late import xarray as xr

    about = {"long_name": f"derivative of the edge in {name}"}
    words = "; ".join(f"{kind}: {meaning}" for kind, meaning in EDGES.items())
    dims = ("window", "edge", "parameter")
    both = [np.array([table[f"{side}{part}"].values for side in ("low", "high")]).T for part in ("", "_type")]
    return xr.Dataset(
        {
            "derivative": (dims, derivative, about),
            "error": (dims, error, {"long_name": "estimated error of the derivative"}),
            "value": (("window", "edge"), both[0], model.describe(name).attributes),
            "type": (("window", "edge"), both[1], {"long_name": "type of the edge", "meaning": words}),
            "N": table["N"],
            "piece": table["piece"],
        },
        {"edge": ["low", "high"], "parameter": names},
        {
            "title": f"derivatives of the edges of windows in {name}",
            "parameter": name,
            "model": repr(model),
            "parameters": json.dumps(dict(model.params)),
            "span": table.attrs["span"],
            "samples": table.attrs["samples"],
            "arithmetic": "strict",
            **model.attributes,
        },
    )
