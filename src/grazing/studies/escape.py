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
#: Steps since an orbit was last moved, counted up to these; and the share of orbits, moved the longest ago, that count.
AGES, OLDEST = 16, 0.05
#: By how many of its own errors the rate of orbits moved still longer ago differs where more than chance is in it.
CLEARLY = 3.0
#: By how much each orbit is moved at each step: x -> 2 x mod 1 does not round, and runs out of digits after 53 steps.
DIGITS = 2.0**-40


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
    drift : float
        By how much the rate differs where orbits count half as many steps after they were moved; or, where that is
        more than chance, only those that were moved longer ago, or in the second half of the steps; of a single step,
        from that in the step before.
    """

    rates: Floats
    orbits: int
    steps: int
    lost: int
    drift: float = 0.0

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
        """Its standard error, by how much the populations differ and by the drift."""
        return float(np.hypot(self.rates.std(ddof=1) / np.sqrt(len(self.rates)), self.drift))

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
    stir: float = 0.02,
    seed: int = 0,
    threads: int | None = None,
) -> EscapeRate:
    """Measure how fast orbits of a map escape, such as balls from a pinball table, with its statistical error.

    Parameters
    ----------
    P : Map
        Of which orbits escape: outcome *escaped*, as of :func:`grazing.collision_map`; a step of your own says so by
        returning (state, letter, 1024). What ends otherwise, as beyond ``escape``, is *lost*. Starts are drawn from its
        box.
    orbits : int
        Orbits of a population, >= 100.
    transient, steps : int
        Steps before anything counts, and those that do, >= 1. Between active bumpers the speed takes many impacts to
        settle.
    populations : int
        How many independent ones there are, >= 2: the error is by how much they differ.
    stir : float
        By how much copies are moved, > 0: in radians for the angle of a ball, for other maps in sizes of the box.
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
    impacts only exp(-rate n) of all balls are left. A copy is moved a little, or it would do as its original does; one
    that is moved over an edge of the density, such as that of a hole, or off what never leaves, stays longer or less
    long than it should. So only orbits that were last moved some steps ago count: as many steps as leave a twentieth of
    all, or 16. Where half as many, or clearly more, give another rate, or clearly the second half of the steps (of one
    step, that before), that ``drift`` is part of the error, for decays that are no exponentials, too. Where orbits
    change between rooms in turn the rate goes round for ever, and ``steps`` of whole rounds are needed; a single step
    without a transient has nothing to compare with. Copies have to part within these steps:
    with a ``stir`` below some 0.01 the drift of maps that lose most orbits shows in the few that were moved the longest
    ago, if there are ``orbits`` enough to tell it from chance. Orbits are not independent; populations are. One in
    which few orbits stay then has copies of these, of which more stay than of all: a mean of logarithms of shares is
    too large by some part of 1/``orbits``. So each population counts as many times as orbits would be left in it
    without copies, over the last 10 steps, and the jackknife over populations takes away what is left of that error and
    says the statistical one. All orbits of maps of one's own are moved by 2^-40 of the box at each step, as rounding
    would: 2 x mod 1 takes every double to 0.

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
    if P.origin.rig is not None:
        raise InputError(f"nothing escapes from an oscillator, and {shown(P)} is one's; give gz.collision_map(table)")
    orbits, populations = whole(orbits, "orbits", 100), whole(populations, "populations", 2)
    transient, steps = whole(transient, "transient", 0), whole(steps, "steps", 1)
    seed, stir = whole(seed, "seed", 0, 2**53), real(stir, "stir", "give a small number > 0, such as 0.02")
    if not stir > 0.0:
        raise InputError(
            f"stir is {stir:g}; give a small number > 0, such as 0.02: copies that are not moved stay equal"
        )
    warm = min(transient, KEPT)
    room = 8.0 * (4 * (P.dimension + 5) * orbits + 4 * populations * (warm + steps) * (AGES + 1))
    refuse_too_large(
        room, f"reduce orbits ({orbits}), populations ({populations}) or steps ({steps})", "the populations"
    )
    box, lost = np.array(P.box), 0
    names = P.origin.stirred or P.coordinates
    moved = np.array([P.coordinates.index(name) for name in names])
    size = np.ones(len(names)) if P.origin.stirred else (box[:, 1] - box[:, 0])[moved]
    counts = np.zeros((2, populations, warm + steps, AGES + 1))
    for i in range(populations):
        drawn = uniform(seed, (float(i), -1.0), orbits, len(box) + len(names))
        states = (box[:, 0] + (box[:, 1] - box[:, 0]) * drawn[:, : len(box)]).T
        digits = (0.0 if P.origin.stirred else DIGITS) * size[:, None] * (drawn[:, len(box) :].T - 0.5)
        age = np.zeros(orbits, np.int64)
        for k in range(transient + steps):
            states[moved] = aside(states[moved], digits, box[moved])
            found = P.run_columns(P.packed()[1][None], states[None].copy(), 0, 1, threads=threads)
            outcomes = found.outcomes[0, 0]
            gone = (outcomes & ESCAPED) != 0
            stays = np.flatnonzero(~gone & ((outcomes & FATAL) == 0))
            if len(stays) == 0:
                raise InputError(f"all {orbits} orbits have ended after {k + 1} steps; more orbits= may stay longer")
            lost += orbits - len(stays) - int(gone.sum())
            if k >= transient - warm:
                for n, ages in enumerate((age[stays], age[gone])):
                    counts[n, i, k - transient + warm] = np.bincount(ages, minlength=AGES + 1)
            drawn = uniform(seed, (float(i), float(k)), orbits - len(stays), 1 + len(names))
            of = stays[(drawn[:, 0] * len(stays)).astype(np.int64)]
            states = found.points[0, 0][:, np.concatenate([stays, of])]
            by = stir * size[:, None] * np.sqrt(3.0) * (2.0 * drawn[:, 1:].T - 1.0)
            states[moved, len(stays) :] = aside(states[moved, len(stays) :], by, box[moved])
            age = np.concatenate([np.minimum(age[stays] + 1, AGES), np.zeros(len(of), np.int64)])
    if not counts[1].any():
        none = f"none of {orbits} orbits has escaped in {transient + steps} steps"
        if lost:
            raise InputError(
                f"{none}, and {lost} ended otherwise; a step of your own says that an orbit escapes by returning "
                f"(state, letter, {ESCAPED})"
            )
        raise InputError(f"{none}: there may be no way out")
    rates, drift = rates_of(counts[0], counts[1], warm)
    return EscapeRate(rates, orbits, steps, lost, drift)


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


def rates_of(stayed: Floats, gone: Floats, warm: int) -> tuple[Floats, float]:
    """Return the pseudo-values, shape (populations,), whose mean is the rate, and its drift.

    Parameters
    ----------
    stayed, gone : ndarray, shape (populations, steps, ages)
        How many orbits did at each step, by the steps since they were moved. The first ``warm`` steps only weigh the
        populations.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.studies.escape import rates_of
    >>> rates, drift = rates_of(np.ones((2, 5, 3)), np.ones((2, 5, 3)), 2)
    >>> rates.round(6).tolist(), drift
    ([0.693147, 0.693147], 0.0)
    """
    older = np.cumsum(np.array([stayed, stayed + gone])[..., ::-1], axis=-1)[..., ::-1]
    logs = np.log(older[0, :, :, 0] / older[1, :, :, 0])
    many, steps, ages = stayed.shape
    halves, alone = np.zeros((2, 2, many, ages)), steps - warm == 1  # of the steps; of one, that before and it
    for k in range(max(0, warm - alone), steps):
        stood = logs[:, max(0, k - KEPT) : k].sum(axis=1)
        weights = np.exp(stood - stood.max())
        half = int(k >= warm if alone else 2 * k >= warm + steps)
        halves[half] += (weights / weights.sum())[:, None] * older[:, :, k]
    each = halves[1] if alone else halves.sum(axis=0)
    share, known = each[1].sum(axis=0) / each[1, :, 0].sum(), each[0].all(axis=0)
    age = int(np.flatnonzero((share >= OLDEST) & known)[-1])
    each = each[:, :, known]  # the ages to which orbits of all populations stayed
    rate = -np.log(np.divide(*each.sum(axis=1)))
    rates = many * rate - (many - 1) * -np.log(np.divide(*(each.sum(axis=1, keepdims=True) - each)))
    stay, both = older[:, :, warm:, : len(rate)].sum(axis=(1, 2))
    apart, noise = np.abs(rate - rate[age]), np.sqrt((both - stay) / (stay * both))
    noise = np.maximum(noise, (rates - rates[:, age, None]).std(axis=0, ddof=1) / np.sqrt(many))
    drift = abs(float(rate[age] - rate[age // 2]))
    if (apart > CLEARLY * noise)[age:].any():
        drift = max(drift, float((apart - noise)[age:].max()))
    shared = np.flatnonzero(halves[:, 0, :, : age + 1].all(axis=(0, 1)))
    if len(shared):
        stay, both = halves[:, 0, :, shared[-1]], halves[:, 1, :, shared[-1]]
        early, late = -np.log(stay.sum(axis=-1) / both.sum(axis=-1))
        by_chance = np.diff(-np.log(stay / both), axis=0).std(ddof=1) / np.sqrt(many)
        if abs(late - early) > CLEARLY * max(by_chance, np.sqrt(2.0) * float(noise[age])):
            drift = max(drift, abs(float(late - early)))  # what decays slower is still coming through
    return rates[:, age], drift


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
    from grazing.late import xarray as xr

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
