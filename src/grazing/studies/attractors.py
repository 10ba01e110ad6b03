"""What the starts of an orbit diagram reach: the classes of orbits at each value, with their shares."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import xarray as xr


class Attractor(NamedTuple):
    """A class of orbits at one parameter value, with the share of starts that reach it."""

    value: float
    word: str
    period: int
    share: float


def attractors(diagram: xr.Dataset) -> list[Attractor]:
    """Return what the starts of an orbit diagram reach, per value each (word, period) with its share of starts.

    Parameters
    ----------
    diagram : xarray.Dataset
        From :func:`grazing.orbit_diagram`, or any result with ``period`` and ``word`` on (parameter, start).

    Returns
    -------
    list of Attractor
        In the order of the values, the greatest share first. Attractors with the same word and period are one;
        orbits without a word have their period's code: 0 undecided, -1 aperiodic as far as seen, -2 ended.

    Examples
    --------
    >>> import grazing as gz
    >>> from grazing.studies.attractors import attractors
    >>> from grazing.studies.orbit_diagram import orbit_diagram
    >>> diagram = orbit_diagram(gz.gap_map(lam=0.5, mu=0.1, l=0.1), "mu", [0.043])
    >>> [(a.word, a.period) for a in attractors(diagram)]
    [('LLR', 3), ('LLLR', 4)]
    """
    name = str(diagram["period"].dims[0])
    found = []
    for value, words, periods in zip(
        diagram[name].values.tolist(), diagram["word"].values.tolist(), diagram["period"].values.tolist(), strict=True
    ):
        counts: dict[tuple[str, int], int] = {}
        for key in zip(words, periods, strict=True):
            counts[key] = counts.get(key, 0) + 1
        order = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
        found += [Attractor(value, word, period, count / len(words)) for (word, period), count in order]
    return found
