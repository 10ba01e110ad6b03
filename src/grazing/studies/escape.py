"""Escape rates by simulation: populations that are filled up again, so that late times have as many orbits as early."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.copies import ByValue
from grazing.kernel.random import uniform
from grazing.maps.map import Map
from grazing.memory import refuse_too_large
from grazing.outcome import ESCAPED, FATAL, InputError, shown
from grazing.parameter import checked_name, real, whole
from grazing.pool import Progress
from grazing.studies import labels
from grazing.studies.runs import checked_map, checked_values

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
#: Steps for which it is remembered how many orbits of a population stayed.
KEPT = 10
#: By how much copies are moved: the angle of a ball, whose density is smooth in it, and coordinates of other maps.
BALLS, OTHERS = 0.02, 0.002


@dataclass(frozen=True, eq=False)
class EscapeRate(ByValue):
    """How fast orbits escape, from several populations; made by :func:`escape_rate`.

    Parameters
    ----------
    rates : ndarray, shape (populations,)
        What each population adds: pseudo-values of the jackknife, whose mean is the rate. Read-only.
    orbits, steps : int
        Orbits of a population, and the steps that the mean is over.
    lost : int
        Orbits that ended otherwise than by escaping; they count neither as staying nor as escaping.
    """

    rates: Floats
    orbits: int
    steps: int
    lost: int

    def __post_init__(self) -> None:
        rates = np.array(self.rates, np.float64)
        rates.flags.writeable = False
        object.__setattr__(self, "rates", rates)

    @property
    def rate(self) -> float:
        """The escape rate a step."""
        return float(self.rates.mean())

    @property
    def error(self) -> float:
        """Its standard error, by how much the populations differ."""
        return float(self.rates.std(ddof=1) / np.sqrt(len(self.rates)))

    def __repr__(self) -> str:
        many = f"{len(self.rates)} populations of {self.orbits} orbits over {self.steps} steps"
        return f"<EscapeRate: {self.rate:.6g} +- {self.error:.1g} a step, {many}>"


def escape_rate(
    P: Map,
    *,
    orbits: int = 10_000,
    transient: int = 40,
    steps: int = 40,
    populations: int = 8,
    stir: float | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> EscapeRate:
    """Measure how fast orbits of a map escape, such as balls from a pinball table, with its statistical error.

    Parameters
    ----------
    P : Map
        Of which orbits escape: outcome *escaped*, as of :func:`grazing.collision_map`. Starts are drawn from its box.
    orbits : int
        Orbits of a population, >= 100.
    transient, steps : int
        Steps before anything counts, and those that do, >= 1. Between active bumpers the speed takes many impacts to
        settle.
    populations : int
        How many independent ones there are, >= 2: the error is by how much they differ.
    stir : float, optional
        By how much copies are moved, > 0: in radians for the angle of a ball, 0.02 unless said; for other maps in sizes
        of the box, 0.002.
    seed : int
        Equal seeds give equal numbers.
    threads : int, optional
        None for one per processor; the result does not depend on it.

    Returns
    -------
    EscapeRate
        ``rate`` and ``error`` a step of the map; an impact, for a collision map.

    Raises
    ------
    InputError
        If nothing escapes, or everything at once.

    Notes
    -----
    After each step the orbits that have escaped are replaced by copies of others, drawn at random: without them after n
    impacts only exp(-rate n) of all balls are left. A copy is moved a little, or it would do as its original does; that
    smooths the density in the direction in which it is smooth, and moves the rate by some part of the square of
    ``stir``: measured for three discs, by 0.001 at 0.1 and by less than 0.0003 at 0.03. Where the density jumps within
    the box, as that of a map with a hole does, it is some part of ``stir`` itself. Copies take a few steps to
    part, so that orbits are not independent; populations are. One in which few orbits stay then has copies of these,
    of which more stay than of all: a mean of logarithms of shares is too large by some part of 1/``orbits``. So each
    population counts as many times as orbits would be left in it without copies, over the last 10 steps, and the
    jackknife over populations takes away what is left of that error and says the statistical one.

    References
    ----------
    B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM (1982), on pseudo-values.
    P. Grassberger, Comput. Phys. Commun. 147 (2002) 64-70, on populations that are split ("go with the winners").

    Examples
    --------
    >>> import grazing as gz
    >>> corners = {"A": (0.0, 0.0), "B": (3.0, 0.0), "C": (1.5, 1.5 * 3**0.5)}
    >>> discs = [gz.disc(name, corner, 1.0, gz.newton(1.0)) for name, corner in corners.items()]
    >>> found = gz.escape_rate(gz.collision_map(gz.table(discs)), orbits=2000, transient=8, steps=8)
    >>> abs(found.rate - 0.783594) < 4.0 * found.error < 0.1
    True
    """
    if not isinstance(P, Map):
        raise InputError(f"P is {shown(P)}; give a map of which orbits escape, such as gz.collision_map(table)")
    orbits, populations = whole(orbits, "orbits", 100), whole(populations, "populations", 2)
    transient, steps = whole(transient, "transient", 0), whole(steps, "steps", 1)
    stir = (BALLS if P.origin.stirred else OTHERS) if stir is None else stir
    seed, stir = whole(seed, "seed", 0, 2**53), real(stir, "stir", "give a small number > 0, such as 0.02")
    if not stir > 0.0:
        raise InputError(
            f"stir is {stir:g}; give a small number > 0, such as 0.02: copies that are not moved stay equal"
        )
    warm = min(transient, KEPT)
    room = 8.0 * (4 * (P.dimension + 4) * orbits + 2 * populations * (warm + steps))
    refuse_too_large(
        room, f"reduce orbits ({orbits}), populations ({populations}) or steps ({steps})", "the populations"
    )
    box, left = np.array(P.box), 0
    names = P.origin.stirred or P.coordinates
    moved = np.array([P.coordinates.index(name) for name in names])
    size = np.ones(len(names)) if P.origin.stirred else (box[:, 1] - box[:, 0])[moved]
    shares, lost = np.empty((populations, warm + steps)), 0
    for i in range(populations):
        states = (box[:, 0] + (box[:, 1] - box[:, 0]) * uniform(seed, (float(i), -1.0), orbits, len(box))).T
        for k in range(transient + steps):
            found = P.run_columns(P.packed()[1][None], states[None].copy(), 0, 1, threads=threads)
            outcomes = found.outcomes[0, 0]
            gone = (outcomes & ESCAPED) != 0
            stays = np.flatnonzero(~gone & ((outcomes & FATAL) == 0))
            if len(stays) == 0:
                raise InputError(f"all {orbits} orbits have ended after {k + 1} steps; more orbits= may stay longer")
            lost += orbits - len(stays) - int(gone.sum())
            left += int(gone.sum())
            if k >= transient - warm:
                shares[i, k - transient + warm] = len(stays) / (len(stays) + int(gone.sum()))
            drawn = uniform(seed, (float(i), float(k)), orbits - len(stays), 1 + len(names))
            of = stays[(drawn[:, 0] * len(stays)).astype(np.int64)]
            states = found.points[0, 0][:, np.concatenate([stays, of])]
            by = stir * size[:, None] * np.sqrt(3.0) * (2.0 * drawn[:, 1:].T - 1.0)
            states[moved, len(stays) :] = aside(states[moved, len(stays) :], by, box[moved])
    if left == 0:
        raise InputError(f"none of {orbits} orbits has escaped in {transient + steps} steps: there may be no way out")
    return EscapeRate(rates_of(shares, warm), orbits, steps, lost)


def aside(x: Floats, by: Floats, box: Floats) -> Floats:
    """Return coordinates, shape (dim, n), moved by so much; what is in the box stays in it, reflected at its ends.

    A density need not fall to 0 at the ends: copies that leave the box would escape for having been moved.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.studies.escape import aside
    >>> aside(np.array([[0.75, 0.5, 1.5]]), np.array([[0.5, 0.25, 0.25]]), np.array([[0.0, 1.0]])).tolist()
    [[0.75, 0.75, 1.75]]
    """
    low, high = box[:, :1], box[:, 1:]
    to, side = x + by, high - low
    turn = (to - low) % (2.0 * side)
    leaves = (low <= x) & (x <= high) & ((to < low) | (to > high))
    return np.where(leaves, low + np.minimum(turn, 2.0 * side - turn), to)


def rates_of(shares: Floats, warm: int) -> Floats:
    """Return the pseudo-values, shape (populations,), whose mean is the rate, of the shares that stay at each step.

    The first ``warm`` steps only weigh the populations.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.studies.escape import rates_of
    >>> rates_of(np.full((2, 5), 0.5), 2).round(6).tolist()
    [0.693147, 0.693147]
    """
    logs = np.log(shares)
    many, steps = len(shares), shares.shape[1] - warm
    rate, without = 0.0, np.zeros(many)
    for k in range(warm, warm + steps):
        stood = logs[:, max(0, k - KEPT) : k].sum(axis=1)
        weights = np.exp(stood - stood.max())
        stayed = weights * shares[:, k]
        rate -= np.log(stayed.sum() / weights.sum()) / steps
        without -= np.log((stayed.sum() - stayed) / (weights.sum() - weights)) / steps
    return np.asarray(many * rate - (many - 1) * without)


def escape(
    P: Map,
    name: str | None = None,
    values: ArrayLike | None = None,
    *,
    orbits: int = 10_000,
    transient: int = 40,
    steps: int = 40,
    populations: int = 8,
    stir: float = 0.02,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return what :func:`grazing.escape_rate` does, as one parameter varies or at the values of a map.

    Parameters
    ----------
    P : Map
        Of which orbits escape.
    name, values : str and array_like, optional
        The parameter that varies, and its values.
    orbits, transient, steps, populations, stir, seed, threads
        As in :func:`grazing.escape_rate`.
    progress : callable, optional
        ``progress(done, total)``, called after each value.

    Returns
    -------
    xarray.Dataset
        ``rate``, ``error`` and ``lost`` on the parameter; without dimension where none varies.

    Raises
    ------
    InputError
        As :func:`grazing.escape_rate` does.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.escape import escape
    >>> corners = {"A": (0.0, 0.0), "B": (3.0, 0.0), "C": (1.5, 1.5 * 3**0.5)}
    >>> discs = [gz.disc(name, corner, 1.0, gz.newton(1.0)) for name, corner in corners.items()]
    >>> P = gz.collision_map(gz.table(discs))
    >>> found = escape(P, "A.r", [0.8, 1.0], orbits=500, transient=4, steps=4, populations=2)
    >>> found.rate.dims, bool((found.rate > 0.6).all())
    (('A.r',), True)
    """
    import xarray as xr

    P = checked_map(P)
    axis = {}
    if name is not None:
        name = checked_name(name, P.params, P.name or "the map")
        axis = {name: checked_values(name, () if values is None else values, P)}
    maps = [P.replace(**{name: x}) for name, each in axis.items() for x in each.tolist()] or [P]
    found = []
    for i, each in enumerate(maps):
        found.append(
            escape_rate(
                each, orbits=orbits, transient=transient, steps=steps, populations=populations, stir=stir, seed=seed,
                threads=threads,
            )
        )  # fmt: skip
        if progress is not None:
            progress(i + 1, len(maps))
    dims = tuple(axis)

    def column(name: str, says: str) -> tuple[object, ...]:
        numbers = np.array([getattr(one, name) for one in found])
        return dims, numbers if dims else numbers[0], {"long_name": says, "units": "1"}

    varied = "".join(f" in {name}" for name in axis)
    return xr.Dataset(
        {
            "rate": column("rate", "escape rate a step"),
            "error": column("error", "its standard error"),
            "lost": column("lost", "orbits that ended otherwise than by escaping"),
        },
        coords={name: (name, each, labels.quantity(P, name)) for name, each in axis.items()},
        attrs={
            "title": f"escape rate of the {P.name}{varied}",
            "orbits": found[0].orbits,
            "populations": len(found[0].rates),
            "steps": found[0].steps,
            **{f"parameter_{key}": value for key, value in P.params.items() if key not in axis},
        },
    )
