"""Curves laid over a figure, each with its name on it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from grazing.compare.word_branches import loci_of
from grazing.oscillator.parameters import describe_parameter
from grazing.outcome import InputError
from grazing.plot.style import INK, drawable
from grazing.units import in_units

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

#: Points at which the distance between curves and names is looked at.
SAMPLES = 160


def curves_of(given: Any, result: xr.Dataset, first: str, second: str) -> tuple[Mapping[str, Any], dict[str, str]]:
    """Return curves by name, as they are given or made of boundaries, loci and branches in the plane of a result.

    Also the words of those that are of orbits, by the same names. Edges of one name are one line in pieces. Curves in
    other units are converted to those of the result.
    """
    from grazing.late import xarray as xr

    if given is None or (isinstance(given, Mapping) and not isinstance(given, xr.Dataset)):
        return given or {}, {}
    several = given if isinstance(given, (list, tuple)) else [given]
    pieces: dict[str, list[Floats]] = {}
    words: dict[str, str] = {}
    for one in several:
        for name, word, x, y in _lines(one, result, first, second):
            pieces.setdefault(name, []).append(np.append(np.stack([x, y]), [[np.nan], [np.nan]], axis=1))
            words |= {name: word} if word else {}
    return {name: tuple(np.concatenate(parts, axis=1)) for name, parts in pieces.items()}, words


def _lines(one: Any, result: xr.Dataset, first: str, second: str) -> Iterator[tuple[str, str, Floats, Floats]]:
    """Yield the lines of boundaries, of a locus or of a branch, each with its name and its word."""
    from grazing.late import xarray as xr

    found = one if isinstance(one, xr.Dataset) else getattr(one, "dataset", None)
    wanted = (
        f"gz.boundaries(P, ({first!r}, low, high), ({second!r}, low, high)), a gz.locus in {first} and {second}, "
        f"a branch in one of them"
    )
    if not isinstance(found, xr.Dataset) or not {"label", "meeting_type", "special_type"} & {*found.variables}:
        raise InputError(
            f"no curve can be drawn from this {type(one).__name__}; give {wanted}, a list of these, "
            "or a mapping of names to (x, y)"
        )
    loci = []
    if "special_type" in found:
        loci = [locus for locus in loci_of(found) if {first, second} == {*json.loads(locus.attrs["parameters"])}]
        found = _placed(found, {first, second})
    for name in (first, second):
        if name not in found:
            known = ", ".join(map(str, found.variables))
            raise InputError(f"curves have {known}, but no {name}; give {wanted}")
    x, y = (in_units_of(result, found, side) for side in (first, second))
    if "label" in found:
        for k, name in enumerate(found["label"].values):
            yield str(name), "", x[k], y[k]
        return
    if "special_type" in found:
        real = (found["admissible"].values == 1) & (found["stable"].values == 1)
        words, pieces = found["word"].values.astype(str), found["piece"].values
        for k in np.unique(pieces):
            there = real & (pieces == k)
            for word in np.unique(words[there]).tolist():
                own = there & (words == word)
                own[:-1] |= own[1:] & there[:-1]  # as far as the word before it
                yield word, word, np.where(own, x, np.nan), np.where(own, y, np.nan)
        for locus in loci:  # of its special points
            yield from _lines(locus, result, first, second)
        return
    there = found["admissible"].values == 1  # a chart shows what the map has
    word = str(found.attrs["word"])
    yield f"{word} {found.attrs['type']}", word, np.where(there, x, np.nan), np.where(there, y, np.nan)


def _placed(branch: xr.Dataset, plane: set[str]) -> xr.Dataset:
    """Return a branch with the other parameter of the plane, which keeps its value along it."""
    (other,) = plane - {branch.attrs["parameter"]} or {""}
    known = json.loads(branch.attrs["parameters"])
    if len(plane & {branch.attrs["parameter"]}) != 1 or other not in known:
        return branch
    units = describe_parameter(other).units if "mass" in branch.attrs else "1"
    return branch.assign({other: ("point", np.full(branch.sizes["point"], known[other]), {"units": units})})


def in_units_of(result: xr.Dataset, found: xr.Dataset, side: str) -> Floats:
    """Return what a curve, or points, say of an axis, in the axis' own units."""
    old, unit = (one[side].attrs.get("units") for one in (found, result))
    if unit in (None, "1", old):
        return np.asarray(found[side].values, np.float64)
    return np.asarray(in_units(found[[side]], unit)[side].values, np.float64)


def lay_curves(ax: Axes, curves: Mapping[str, Any], colours: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Draw curves with a light rim and write their names on them, where they are far from each other and the frame.

    Parameters
    ----------
    ax : matplotlib Axes
        With its limits set.
    curves : mapping of str to (x, y)
        NaN breaks a curve.
    colours : mapping of str to str, optional
        Of the curves by name; the others are black.

    Returns
    -------
    dict
        Name to ``(line, text)``; the text is None for a curve that is not in the axes.
    """
    plain = {str(name): _checked(str(name), curve) for name, curve in curves.items()}
    left, right, low, high = *ax.get_xlim(), *ax.get_ylim()
    drawn: dict[str, Any] = {}
    # a colour that the chart has, too, is seen by its rim
    rims = [[withStroke(linewidth=width, foreground="white", alpha=0.85)] for width in (2.0, 3.2)]
    samples = {name: _sampled(ax, *curve) for name, curve in plain.items()}
    taken: list[Floats] = []
    to_data = ax.transAxes + ax.transData.inverted()
    for name, (x, y) in plain.items():
        own = (colours or {}).get(name)
        (line,) = ax.plot(x, y, color=own or INK, lw=1.4 if own else 0.9, zorder=5, path_effects=rims[bool(own)])
        others = [s for other, s in samples.items() if other != name]
        place = _place(samples[name], others, taken)
        text = None
        if place is not None:
            at, ahead = place
            taken.append(at)
            here, there = to_data.transform([at, ahead])
            text = ax.text(
                float(here[0]),
                float(here[1]),
                drawable(name),
                rotation=float(np.degrees(np.arctan2(*(there - here)[::-1]))),
                rotation_mode="anchor",
                transform_rotates_text=True,
                ha="center",
                va="center",
                fontsize=7.0,
                color=INK,
                zorder=7,
                bbox={"facecolor": "white", "alpha": 0.85, "lw": 0, "pad": 0.8},
            )
        drawn[name] = (line, text)
    ax.set(xlim=(left, right), ylim=(low, high))
    return drawn


def _checked(name: str, curve: Any) -> tuple[Floats, Floats]:
    try:
        x, y = (np.asarray(part, np.float64) for part in curve)
    except (TypeError, ValueError):
        x = y = np.empty((0, 0))
    if x.ndim != 1 or x.shape != y.shape or not x.size:
        raise InputError(f"curve {name!r} is not a pair (x, y) of equally long, one-dimensional arrays of numbers")
    return x, y


def _sampled(ax: Axes, x: Floats, y: Floats) -> Floats:
    """Return points along a curve, in shares of the axes, those outside and at breaks left out."""
    to_axes = ax.transData + ax.transAxes.inverted()
    points = np.asarray(to_axes.transform(np.column_stack([x, y])), np.float64)
    steps = np.hypot(*np.diff(points, axis=0).T)
    joined = np.isfinite(steps)
    length = np.concatenate([[0.0], np.cumsum(np.where(joined, steps, 0.0))])
    if not joined.any() or length[-1] == 0.0:
        dense = points[np.isfinite(points).all(axis=1)]
    else:
        at = np.linspace(0.0, length[-1], 4 * SAMPLES)
        k = np.clip(np.searchsorted(length, at, side="right") - 1, 0, len(steps) - 1)
        share = np.where(joined[k], (at - length[k]) / np.where(joined[k] & (steps[k] > 0.0), steps[k], 1.0), 0.0)
        dense = points[k] + share[:, None] * (points[k + 1] - points[k])
    inside = (np.isfinite(dense) & (dense > 0.0) & (dense < 1.0)).all(axis=1)
    return dense[inside]


def _place(own: Floats, others: list[Floats], taken: list[Floats]) -> tuple[Floats, Floats] | None:
    """Return where a name stands best, and a point further along the curve towards which it is written."""
    if len(own) < 3:
        return None
    candidates = np.arange(1, len(own) - 1)[:: max(1, len(own) // SAMPLES)]
    # first of all clear of the frame and of other names, where there is such a place
    frame = np.minimum(own[candidates], 1.0 - own[candidates]).min(axis=1)
    apart = np.full(candidates.size, np.inf)
    for name in taken:
        apart = np.minimum(apart, np.hypot(*(own[candidates] - name).T))
    clear = (frame >= 0.07) & (apart >= 0.14)
    if clear.any():
        candidates, frame = candidates[clear], frame[clear]
    room = np.minimum(2.0 * frame, 0.36)  # a name is longer than high
    for points, weight in [*((s, 1.0) for s in others if len(s)), *((t[None, :], 0.6) for t in taken)]:
        gap = np.hypot(*(own[candidates][:, None, :] - points[None, :, :]).transpose(2, 0, 1)).min(axis=1)
        room = np.minimum(room, weight * gap)
    middle = 1e-3 * np.abs(np.linspace(-1.0, 1.0, candidates.size))  # of equally good places the middle one
    best = int(candidates[np.argmax(room - middle)])
    reach = max(1, len(own) // 20)
    before, after = own[max(0, best - reach)], own[min(len(own) - 1, best + reach)]
    along = after - before
    if along[0] < 0.0 or (along[0] == 0.0 and along[1] < 0.0):  # never upside down
        along = -along
    return own[best], own[best] + (along if np.any(along) else np.array([0.1, 0.0]))
