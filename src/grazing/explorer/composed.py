"""Kernels for a page, composed of those of the package for any map: starts, orbits, rasters and classes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from grazing.explorer.webassembly import Argument, Entry
from grazing.kernel.primitives import inlined
from grazing.outcome import AMBIGUOUS, FATAL
from grazing.parameter import Parameter
from grazing.studies.cycles import settling
from grazing.studies.density import raster
from grazing.studies.recurrence import recurrence, spelled
from grazing.studies.starts import drawn_starts

INFINITY = float("inf")
#: Orbits that are counted together, so that columns of few starts fill the vectors of the loop, and their steps
#: between two looks at the raster: points then stay in the nearest cache.
TOGETHER, PIECE = 128, 32

Step = Callable[..., Any]

ROWS = Argument("rows", "float64", ("columns", "fields"), "parameter values, in the order of `fields`")
LANES = Argument("lanes", "float64", ("columns", "dimension", "starts"), "states; overwritten with the last ones")
TRANSIENT = Argument("transient", "int64", (), "steps that are passed over")


class Module(NamedTuple):
    """A module: its functions, and what describes the map in it. A field without a range is a choice."""

    entries: list[Entry]
    fields: tuple[Parameter | dict[str, Any], ...]
    coordinates: tuple[str, ...]
    letters: str | None


def sized(argument: Argument, **known: int) -> Argument:
    """Return an argument with the sizes that are the same for all calls."""
    shape = tuple(known.get(size, size) if isinstance(size, str) else size for size in argument.shape)
    return Argument(argument.name, argument.kind, shape, argument.meaning)


@inlined
def emptied(counts: Any, ended: Any, ambiguous: Any, q: int) -> None:
    """Put zeros where a column is counted."""
    ended[q], ambiguous[q] = 0, 0
    for k in range(counts.shape[1]):
        counts[q, k] = 0


@inlined
def fated(lanes: Any, outcome: int, q: int, j: int, ended: Any, ambiguous: Any) -> None:
    """Count an orbit among those of its column that ended, or that met a decision that could not be made."""
    lost = outcome & FATAL != 0
    for k in range(lanes.shape[1]):
        lost = lost or not abs(lanes[q, k, j]) < INFINITY
    ended[q] += 1 if lost else 0
    ambiguous[q] += 1 if outcome & AMBIGUOUS else 0


def counter_of(run: Step, dimension: int) -> Step:
    """Return the kernel that counts the orbits of a loop in a raster, column by column, and stores none."""

    def count(
        rows: Any, lanes: Any, transient: int, keep: int, i: int, low: float, high: float, bins: int, counts: Any,
        ended: Any, ambiguous: Any,
    ) -> None:  # fmt: skip
        columns, n = lanes.shape[0], lanes.shape[2]
        together = max(1, TOGETHER // n)
        for first in range(0, columns, together):
            last = min(first + together, columns)
            m = last - first
            outcomes = np.zeros((m, 1, n), np.int32)
            for q in range(first, last):
                emptied(counts, ended, ambiguous, q)
            done = -1
            while done < keep:
                steps = min(PIECE, keep - done) if done >= 0 else 0
                points, letters = np.empty((m, steps, dimension, n)), np.empty((m, steps, n), np.int32)
                passed = transient if done < 0 else 0
                run(rows[first:last], lanes[first:last], passed, points, letters, outcomes)
                raster(points, i, low, high, bins, counts[first:last])
                done = done + steps if done >= 0 else 0
            for q in range(first, last):
                for j in range(n):
                    fated(lanes, outcomes[q - first, 0, j], q, j, ended, ambiguous)

    return count


def classifier_of(tangent: Step, prepare: Step | None, kind: type, dimension: int, units: Sequence[float] = ()) -> Step:
    """Return the kernel that finds periods and words as :func:`grazing.studies.classify.settle_columns` does.

    Coordinates are measured in ``units``, those of models that come with the page in 1.
    """
    settle, units = settling(tangent, prepare, kind, dimension), tuple(units) or (1.0,) * dimension

    def classify(
        rows: Any, points: Any, letters: Any, outcomes: Any, tolerance: float, period: Any, key: Any, begin: Any,
        length: Any,
    ) -> None:  # fmt: skip
        columns, n = letters.shape[0], letters.shape[2]
        doubtful = np.empty((columns, n), np.int32)
        extents, tolerances = np.empty((columns, dimension, n)), np.empty((columns, dimension, n))
        unit = np.empty(dimension)
        for i in range(dimension):
            unit[i] = units[i]
        recurrence(points, letters, outcomes, tolerance, unit, period, doubtful, extents, tolerances)
        many = 0
        for q in range(columns):
            for j in range(n):
                many += 1 if doubtful[q, j] > 0 else 0
        which = np.empty((many, 4), np.int64)
        k = 0
        for q in range(columns):
            for j in range(n):
                if doubtful[q, j] > 0:
                    which[k, 0], which[k, 1], which[k, 2], which[k, 3] = q, j, q, doubtful[q, j]
                    k += 1
        settle(rows, points, letters, extents, tolerances, which, period)
        spelled(letters, period, key, begin, length)

    return classify


def rank(period: Any, key: Any, count: Any, first: Any) -> None:
    """Find the classes of equal period and word among the orbits of each column, the one with most orbits first.

    ``first`` becomes the number of the first orbit of each class, which breaks a tie as in a chart; of classes that
    are not there ``count`` is 0.
    """
    columns, n = period.shape
    for q in range(columns):
        found = 0
        for j in range(n):
            count[q, j], first[q, j] = 0, 0
        for j in range(n):
            k = 0
            while k < found and not (period[q, first[q, k]] == period[q, j] and key[q, first[q, k]] == key[q, j]):
                k += 1
            if k == found:
                first[q, k] = j
                found += 1
            count[q, k] += 1
        for k in range(1, found):  # insertion keeps the order of equals
            i = k
            while i > 0 and count[q, i] > count[q, i - 1]:
                count[q, i], count[q, i - 1] = count[q, i - 1], count[q, i]
                first[q, i], first[q, i - 1] = first[q, i - 1], first[q, i]
                i -= 1


def attractors(points: Any, period: Any, key: Any, begin: Any, length: Any, same: Any, label: Any) -> None:
    """Give numbers to the attractors that the orbits of each column are on, in the order of their first orbits.

    Orbits are on one attractor if period and word are equal and the points at which their words begin, of several the
    first in order, differ by no more than ``same`` along each coordinate. Orbits without a period have the label
    period - 1, below 0.
    """
    columns, keep, dimension, n = points.shape
    where = np.empty((n, dimension))
    first = np.empty(n, np.int64)
    for q in range(columns):
        found = 0
        for j in range(n):
            N, p = period[q, j], length[q, j]
            if N < 1:
                label[q, j] = N - 1
                continue
            start, best = keep - N, -1
            for k in range(N // p):  # a letter is that of the step to its point: the word begins one point earlier
                turn = start + (begin[q, j] - 1 - start + k * p + N) % N
                i = 0
                while best >= 0 and i < dimension - 1 and points[q, turn, i, j] == points[q, best, i, j]:
                    i += 1
                if best < 0 or points[q, turn, i, j] < points[q, best, i, j]:
                    best = turn
            k, alike = 0, False
            while k < found:
                other = first[k]
                alike = period[q, other] == N and key[q, other] == key[q, j]
                for i in range(dimension):
                    alike = alike and abs(where[k, i] - points[q, best, i, j]) <= same[i]
                if alike:
                    break
                k += 1
            if not alike:
                first[found] = j
                for i in range(dimension):
                    where[found, i] = points[q, best, i, j]
                found += 1
            label[q, j] = k


def arguments(text: str) -> tuple[Argument, ...]:
    """Return arguments from lines ``name: kind  meaning``, and of arrays ``name: kind[size, size]  meaning``."""
    found = []
    for line in text.strip().splitlines():
        front, _, meaning = line.strip().partition("  ")
        name, _, kind = front.partition(": ")
        kind, _, sizes = kind.rstrip("]").partition("[")
        shape = tuple(int(size) if size.isdigit() else size for size in sizes.split(", ") if size)
        found.append(Argument(name, kind, shape, " ".join(meaning.split())))
    return tuple(found)


def orbits_entry(run: Step, kind: type, dimension: int, name: str, meaning: str) -> Entry:
    """Return the function that iterates a map by a loop around its step."""
    fields = len(kind._fields)  # type: ignore[attr-defined]
    arrays = rows_lanes(fields, dimension), points_letters_outcomes(dimension)
    return Entry(
        name, run, ("columns", "starts", "keep"),
        (*arrays[0], TRANSIENT, *arrays[1]), meaning=meaning,
    )  # fmt: skip


def rows_lanes(fields: int, dimension: int) -> tuple[Argument, Argument]:
    """Return the arrays of parameters and of states."""
    return sized(ROWS, fields=fields), sized(LANES, dimension=dimension)


def points_letters_outcomes(dimension: int) -> tuple[Argument, Argument, Argument]:
    """Return the arrays of what orbits leave behind."""
    return (
        Argument("points", "float64", ("columns", "keep", dimension, "starts"), "the states that are kept"),
        Argument("letters", "int32", ("columns", "keep", "starts"), "the letters of those steps"),
        Argument("outcomes", "int32", ("columns", 1, "starts"), "bits that the outcomes of an orbit are added to"),
    )


def entries_of(
    run: Step, count: Step, tangent: Step, prepare: Step | None, kind: type, dimension: int,
    units: Sequence[float] = (),
) -> list[Entry]:  # fmt: skip
    """Return the functions that every map has: orbits, density, classify.

    ``run`` is a loop around the step, ``count`` what counts its orbits.
    """
    fields = len(kind._fields)  # type: ignore[attr-defined]
    rows, lanes = rows_lanes(fields, dimension)
    points, letters, outcomes = points_letters_outcomes(dimension)
    return [
        orbits_entry(run, kind, dimension, "orbits", "advance orbits by `transient` steps, then by `keep`"),
        Entry(
            "density", count, ("columns", "starts"),
            (rows, lanes, TRANSIENT, *arguments("""
                keep: int64  steps that are counted
                coordinate: int64  which coordinate is counted, from 0
                low: float64  lower end of the raster
                high: float64  upper end of the raster
                bins: int64  parts of the raster
                counts: int32[columns, bins + 3]  below, the parts, above, what is no number
                ended: int32[columns]  starts whose orbits ended
                ambiguous: int32[columns]  starts with a decision that could not be made
            """)),
            meaning="count orbits in a raster, the values of one coordinate in each column",
        ),
        Entry(
            "classify", classifier_of(tangent, prepare, kind, dimension, units), ("columns", "starts", "keep"),
            (rows, points, letters, outcomes, *arguments("""
                tolerance: float64  relative tolerance of recurrence
                period: int32[columns, starts]  0 undecided, -1 aperiodic as far as seen, -2 ended
                key: int64[columns, starts]  a number that only equal words share
                begin: int32[columns, starts]  with which of the kept letters the word begins
                length: int32[columns, starts]  letters of the word
            """)),
            meaning="find what orbits have settled on, from `orbits`",
        ),
        Entry(
            "attractors", attractors, ("columns", "starts", "keep"),
            (points, *arguments(f"""
                period: int32[columns, starts]  from `classify`
                key: int64[columns, starts]  from `classify`
                begin: int32[columns, starts]  from `classify`
                length: int32[columns, starts]  from `classify`
                same: float64[{dimension}]  how far points of one attractor may differ
                label: int32[columns, starts]  the attractor, from 0; below 0 without a period
            """)),
            meaning="tell attractors of equal word apart, for basins",
        ),
    ]  # fmt: skip


def common_entries(boxes: Step, fields: int, dimension: int) -> list[Entry]:
    """Return the functions for starts and for classes of orbits; ``boxes(rows, boxes)`` is the map's own kernel."""
    return [
        Entry(
            "boxes", boxes, ("columns",),
            (sized(ROWS, fields=fields), *arguments(f"""
                boxes: float64[columns, {dimension}, 2]  (low, high) of each coordinate
            """)),
            meaning="where random starts are drawn unless said",
        ),
        Entry(
            "draw", drawn_starts, ("columns", "starts", "axes"),
            (*arguments(f"""
                seed: float64  a whole number, 0 <= seed < 2^53
                names: float64[columns, axes]  the values of the parameters that vary
                boxes: float64[columns, {dimension}, 2]  where starts are drawn
            """), sized(LANES, dimension=dimension)),
            meaning="draw random starts, the same for a column whatever else is computed",
        ),
        Entry(
            "rank", rank, ("columns", "starts"),
            (*arguments("""
                period: int32[columns, starts]  from `classify`
                key: int64[columns, starts]  from `classify`
                count: int32[columns, starts]  orbits of each class, most first; 0 for no further one
                first: int32[columns, starts]  the first orbit of each class
            """),),
            meaning="sort the orbits of each column into classes of equal period and word",
        ),
    ]  # fmt: skip
