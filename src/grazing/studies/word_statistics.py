"""The statistics of words: how often orbits spell which letters in a row, and what the next letter still tells."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grazing.maps.map import Map
from grazing.memory import refuse_too_large
from grazing.orbits.word import spelled
from grazing.outcome import AMBIGUOUS, FATAL, InputError
from grazing.parameter import checked_name, whole
from grazing.studies import labels
from grazing.studies.plan import Arrays, Plan, Progress, Variable, planned
from grazing.studies.runs import Runs, checked_map, checked_runs, describe_values

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

#: Names of variables and dimensions of the result, which a parameter must not have.
TAKEN = (
    "word", "share", "share_error", "rank", "length", "words", "counted", "entropy", "entropy_error",
    "conditional_entropy", "conditional_entropy_error", "left", "ended", "ambiguous", "outside",
)  # fmt: skip
#: Groups of orbits, and of steps where there are fewer orbits, whose differences tell the statistical errors.
GROUPS = 20
#: Longest words, arrays of letters in use at a time while they are counted, and bytes of a word in the list.
LONGEST, ARRAYS, RANK = 64, 8, 48


@planned
def word_statistics(
    P: Map,
    name: str | None = None,
    values: ArrayLike | None = None,
    *,
    length: int = 4,
    most: int = 20,
    starts: int | ArrayLike = 100,
    transient: int = 200,
    keep: int = 500,
    seed: int = 0,
    threads: int | None = None,
    arithmetic: str = "fast",
    box: Sequence[tuple[float, float]] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """Return how often orbits spell which words, and the entropies of these, at one or many values of a parameter.

    Parameters
    ----------
    P : Map
        Any map, such as :func:`grazing.collision_map`, whose letters are the objects that a ball hits.
    name, values : str and array_like, optional
        A parameter that varies, with its values; None for the map as it is.
    length : int
        Letters in a row that are counted as a word, 1 to 64.
    most : int
        How many words are listed, the most frequent ones.
    starts, transient, keep, seed, threads, arithmetic, box, progress
        As in :func:`grazing.orbit_diagram`. Balls that leave a table within ``transient`` do not count: give 0 to see
        whole games.

    Returns
    -------
    xarray.Dataset
        On (name, "rank"): ``word``, letters in the order of the steps, neither rotated nor shortened, and ``share``,
        its part of all words of this length, with ``share_error``. On (name, "length"), for words of 1 to ``length``
        letters: ``words``, how many different ones occur, ``counted``, how many in all; ``entropy``, in nats, that of
        their shares, and ``conditional_entropy``, that of the last letter for one who knows those before it, each with
        its error. On (name): ``left``, the orbits that have left, as down a drain, which is their last letter, and
        ``ended``, those that ended otherwise; ``ambiguous``, those with a decision that could not be made.
        Errors are standard ones, by the jackknife over 20 groups of orbits, or of the steps of few orbits. It also
        adds to the entropies what is missing on average because words are few; where most words occur once, that is
        not enough: compare ``words`` with ``counted``.

    Raises
    ------
    InputError
        For an input out of range, or words longer than ``keep``.

    Notes
    -----
    With words of n letters and shares p, the entropy is H = -sum p log p and the conditional entropy H less that of
    the first n - 1 letters of the same words. As n grows it falls to the entropy a step that the letters show: of an
    orbit with a period 0, of a closed system, if letters tell orbits apart, the sum of the positive Lyapunov exponents.

    References
    ----------
    J. P. Crutchfield and D. P. Feldman, Chaos 13 (2003) 25-54, on entropies of words and their limits.
    S. Zahl, Ecology 58 (1977) 907-913, on the jackknife for entropies.

    Examples
    --------
    >>> import grazing as gz, numpy as np
    >>> def tent(state, p):
    ...     left = state[0] < p.a
    ...     return (state[0] / p.a if left else (1.0 - state[0]) / (1.0 - p.a),), 0 if left else 1
    >>> T = gz.Map(tent, params={"a": 0.3}, coordinates=("x",), box=((0.0, 1.0),), letters="LR")
    >>> found = gz.word_statistics(T, length=2)
    >>> sorted(found.word.values[:4].tolist()), bool(abs(found.share[0] - 0.49) < 5 * found.share_error[0])
    (['LL', 'LR', 'RL', 'RR'], True)
    >>> h = -0.3 * np.log(0.3) - 0.7 * np.log(0.7)
    >>> bool((abs(found.conditional_entropy - h) < 4 * found.conditional_entropy_error).all())
    True
    """
    checked_map(P)
    if (name is None) != (values is None):
        raise InputError("give a parameter's name with its values, or neither of them")
    axes = {} if name is None else {checked_name(name, P.params, P.name or "the map"): values}
    runs = checked_runs(P, axes, starts, transient, keep, seed, arithmetic, box, TAKEN, as_they_come=True)  # type: ignore[arg-type]
    length, most = whole(length, "length", 1, LONGEST), whole(most, "most", 1)
    if length > runs.settings.keep:
        raise InputError(f"length = {length} is more than keep = {runs.settings.keep}, the letters of an orbit")
    refuse_too_large(RANK * most, f"reduce most ({most})", "the words of one cell")
    lanes, keep = runs.settings.lanes, runs.settings.keep
    letters = 8 * ARRAYS * keep * lanes
    refuse_too_large(letters, f"reduce starts ({lanes}) or keep ({keep})", "the letters of one cell")
    return Plan(
        P=P,
        title=f"word statistics of the {P.name}" + (f" in {name}" if name else ""),
        config={
            "study": "word_statistics",
            **({} if name is None else {"parameter": name, "values": describe_values(runs.axes[name])}),
            "length": length,
            "most": most,
            **runs.config,
        },
        axes=runs.axes,
        axis_attrs={name: labels.quantity(P, name) for name in runs.axes},
        sizes={"rank": most, "length": length},
        coords={
            "rank": ("rank", np.arange(1, most + 1), {"long_name": "place of the word, 1 the most frequent"}),
            "length": ("length", np.arange(1, length + 1), {"long_name": "letters of the words"}),
        },
        variables=_variables(P, length) | runs.variables,
        compute=partial(_compute, runs, length, most),
        together=runs.together,
        work=runs.work,
        working=runs.piece_size + letters,
    )


plan = word_statistics.plan


def _variables(P: Map, length: int) -> dict[str, Variable]:
    ranked, by_length = ("rank",), ("length",)

    def count(says: str) -> labels.Attributes:
        return {"long_name": says, "units": "1"}

    found = {
        "word": Variable(
            ranked,
            "text",
            {"long_name": "letters in the order of the steps; empty where there are fewer words"},
            labels.longest_word(length, P.letters),
        ),
        "share": Variable(ranked, "float64", count("share of all words of this length")),
        "share_error": Variable(ranked, "float64", count("standard error of the share")),
        "words": Variable(by_length, "int64", count("different words")),
        "counted": Variable(by_length, "int64", count("words that were counted")),
    }
    for name, says in (
        ("entropy", "entropy of the words"),
        ("conditional_entropy", "entropy of a letter that follows a known word"),
    ):
        found[name] = Variable(by_length, "float64", {"long_name": says, "units": "nat"})
        found[f"{name}_error"] = Variable(
            by_length, "float64", {"long_name": f"standard error of the {says}", "units": "nat"}
        )
    return found | {
        "left": Variable((), "int64", count("orbits that have left")),
        "ended": Variable((), "int64", count("orbits that ended otherwise")),
        "ambiguous": Variable((), "int64", count("orbits with an ambiguous decision")),
    }


def _compute(runs: Runs, length: int, most: int, cells: Ints, arrays: Arrays) -> Iterator[None]:
    """Compute cells, see :class:`grazing.studies.plan.Plan`."""
    parts, known, last = list[Ints](), list[Bools](), np.empty((len(cells), runs.P.dimension, 0))
    lost, doubtful = np.zeros((2, len(cells), runs.settings.lanes), np.int64)
    ahead = min(runs.settings.transient, 1)  # the step before the first one tells what has left by then
    settings = runs.settings._replace(transient=runs.settings.transient - ahead, keep=runs.settings.keep + ahead)
    for part in Runs(runs.P, runs.axes, settings, runs.moving).pieces(cells):
        parts.append(part.letters)
        known.append(np.asarray(np.isfinite(part.points).all(axis=2)))
        lost |= part.outcomes[:, 0] & FATAL
        doubtful |= part.outcomes[:, 0] & AMBIGUOUS
        if part.points.shape[1]:
            last = part.points[:, -1]
        yield
    letters, stays = np.concatenate(parts, axis=1), np.concatenate(known, axis=1)
    left = runs.P.origin.left(letters)
    stays[:, 1:] &= ~np.logical_or.accumulate(left, axis=1)[:, :-1]  # the step that leaves is the last one
    runs.say_outside(cells, last, arrays)
    arrays["left"][...], arrays["ended"][...] = left.any(axis=1).sum(axis=1), np.count_nonzero(lost, axis=1)
    arrays["ambiguous"][...] = np.count_nonzero(doubtful, axis=1)
    letters, stays = letters[:, ahead:], stays[:, ahead:]
    for i in range(len(cells)):
        found = counted(letters[i], stays[i], length, most)
        arrays["word"][i] = [spelled(one, runs.P.letters) for one in found.first] + [""] * (most - len(found.first))
        for name in ("share", "share_error"):
            arrays[name][i] = np.nan
            arrays[name][i, : len(found.first)] = getattr(found, name)
        for name in ("words", "counted", "entropy", "entropy_error", "conditional", "conditional_error"):
            arrays[name.replace("conditional", "conditional_entropy")][i] = getattr(found, name)
        yield


class Counted(NamedTuple):
    """What :func:`counted` finds: the first words with their shares, and entropies by the number of letters."""

    first: list[list[int]]
    share: Floats
    share_error: Floats
    words: Ints
    counted: Ints
    entropy: Floats
    entropy_error: Floats
    conditional: Floats
    conditional_error: Floats


def counted(letters: Ints, stays: Bools, length: int, most: int) -> Counted:
    """Count the words of orbits.

    Parameters
    ----------
    letters : ndarray of int, shape (steps, orbits)
    stays : ndarray of bool, same shape
        Which letters count: the first ones of each orbit, up to its end.
    length, most : int
        Letters of a word, and how many words are wanted, the most frequent ones.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.studies.word_statistics import counted
    >>> letters = np.array([0, 1, 0, 0, 1])[:, None]
    >>> found = counted(letters, letters >= 0, 2, 9)
    >>> found.first, found.share.tolist(), found.words.tolist(), found.counted.tolist()
    ([[0, 1], [0, 0], [1, 0]], [0.5, 0.25, 0.25], [2, 3], [5, 4])
    """
    steps, orbits = letters.shape
    alphabet, ids = np.unique(letters, return_inverse=True)
    ids = ids.reshape(letters.shape).astype(np.int64)
    parts = -(-GROUPS // max(orbits, 1))  # of the steps of an orbit, where there are few orbits
    group = (np.arange(orbits) * parts + (np.arange(steps) * parts // max(steps, 1))[:, None]) * GROUPS
    group //= max(orbits * parts, 1)
    numbers, each = np.zeros((2, length), np.int64), np.full((4, length), np.nan)
    codes = np.zeros((steps + 1, orbits), np.int64)
    levels, found = list[Ints](), np.zeros((GROUPS, 0), np.int64)
    for n in range(1, length + 1):
        codes = codes[: max(steps - n + 1, 0)] * len(alphabet) + ids[n - 1 :]
        here = stays[n - 1 :]  # all letters before one that counts do
        words, which = np.unique(codes[here], return_inverse=True)
        codes = np.zeros_like(codes)
        codes[here] = which.ravel()
        levels.append(words)
        found = np.bincount(
            group[: len(codes)][here] * max(len(words), 1) + which.ravel(), minlength=GROUPS * len(words)
        ).reshape(GROUPS, len(words))
        numbers[:, n - 1] = len(words), found.sum()
        if not len(words):
            continue
        shorter = np.zeros((GROUPS, len(levels[n - 2]) if n > 1 else 1), np.int64)
        np.add.at(shorter.T, words // len(alphabet), found.T)
        each[:2, n - 1] = jackknifed(found, entropy_of)
        both = np.hstack([found, shorter])
        each[2:, n - 1] = jackknifed(both, partial(conditional_of, words=len(words)))
    total = found.sum(axis=0)
    order = np.argsort(-total, kind="stable")[:most]  # equal ones in the order of their letters
    shares = total[order] / max(total.sum(), 1)
    errors = np.array([jackknifed(found, partial(share_of, which=k))[1] for k in order.tolist()])
    first = list[list[int]]()
    for code in order.tolist():
        word = list[int]()
        for words in reversed(levels):
            code, last = divmod(int(words[code]), len(alphabet))
            word.insert(0, int(alphabet[last]))
        first.append(word)
    return Counted(first, shares, errors, numbers[0], numbers[1], *each)


def entropy_of(counts: Ints) -> Floats:
    """Return the entropies of shares, in nats, from counts (..., words); not a number where there are none.

    Examples
    --------
    >>> import numpy as np
    >>> from grazing.studies.word_statistics import entropy_of
    >>> round(float(entropy_of(np.array([1, 1, 0, 2])) / np.log(2.0)), 12)
    1.5
    """
    total = counts.sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = counts / total[..., None]
        return np.where(total > 0, -np.where(counts > 0, shares * np.log(shares), 0.0).sum(axis=-1), np.nan) + 0.0


def conditional_of(counts: Ints, words: int) -> Floats:
    """Return the entropies of the last letter of words, counts of which stand before those of their beginnings."""
    return np.maximum(entropy_of(counts[..., :words]) - entropy_of(counts[..., words:]), 0.0)  # rounding


def share_of(counts: Ints, which: int) -> Floats:
    """Return the share of one word."""
    return np.asarray(counts[..., which] / counts.sum(axis=-1))


def jackknifed(counts: Ints, of: Any) -> tuple[float, float]:
    """Return what a function says of all counts (groups, words), less its bias of first order, and the standard error.

    Of a single group nothing is known of either.

    References
    ----------
    B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM (1982).
    """
    counts = counts[counts.any(axis=1)]
    total, many = counts.sum(axis=0), len(counts)
    if many < 2:
        return float(of(total)), float("nan")
    pseudo = many * of(total) - (many - 1) * of(total - counts)
    return float(pseudo.mean()), float(pseudo.std(ddof=1) / np.sqrt(many))
