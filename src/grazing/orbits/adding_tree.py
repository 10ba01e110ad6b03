"""The tree of words that concatenation makes from two words of the gap map, with the windows of each."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from grazing.maps.gap import PARAMETERS
from grazing.memory import refuse_too_large
from grazing.orbits.word import letters_of, primitive, word
from grazing.outcome import InputError, shown
from grazing.parameter import in_order, real, whole
from grazing.theory import WordWindow
from grazing.theory.changes import both_windows

if TYPE_CHECKING:
    import xarray as xr

#: Bytes of a word beside its letters, and a depth whose size fits no machine.
NODE, DEEP = 1000, 100
#: What a word of a tree can be, in words.
STATUS = {
    "stable": "an admissible orbit is stable somewhere",
    "unstable": "admissible orbits exist, but none is stable anywhere",
    "virtual": "no orbit of the word is admissible anywhere",
}


class Node(NamedTuple):
    """A word of the tree: its level, and the running numbers of the two words that it joins, -1 for none."""

    word: str
    level: int
    left: int
    right: int


def adding_tree(
    lam: float,
    l: float,
    depth: int,
    between: tuple[str, str] = ("L", "R"),
    span: tuple[float, float] | None = None,
) -> xr.Dataset:
    """Return the words that concatenation makes from two words of the gap map, with their windows in mu.

    Parameters
    ----------
    lam : float
        Slope of the gap map for x < 0.
    l : float
        Gap.
    depth : int
        Levels of the tree, >= 1: there are 2^depth + 1 words, the two given ones included.
    between : (str, str)
        The two words at the ends; each further word joins its two neighbours of the levels above.
    span : (low, high), optional
        The values of mu searched; needed unless 0 < lam < 1.

    Returns
    -------
    xarray.Dataset
        Dimension ``node``, in the order of the tree from left to right, so that words lie between those that they
        join. Variables: ``word``, ``length``, ``right_letters``, ``level``, ``left`` and ``right`` (running numbers
        of the words that are joined, -1 for none), ``status`` (stable, unstable, virtual). ``low``, ``high``,
        ``low_type``, ``high_type``: widest interval of mu with a stable orbit, of which there are ``windows``;
        ``exists_low`` and ``exists_high``: first and last mu with an admissible orbit. NaN for none.

    Raises
    ------
    InputError
        For two words that are equal or no words, a depth below 1, or a bad number.

    Notes
    -----
    Farey's (or Stern and Brocot's) tree: period adding is the rule that between the windows of two words lies that of
    their concatenation. It needs slopes of one sign. The gap map falls right of the border, and for 0 < lam < 1, l >= 0
    only the words L^n R on the left branch of the tree have windows: periods are incremented, not added. A gap that
    jumps up, l < 0, turns words with RR, of positive slope, into windows, such as those between LRR and LLRR.

    References
    ----------
    Granados, Alseda and Krupa, SIAM Review 59 (2017) 225-292, on period adding and period incrementing.

    Examples
    --------
    >>> from grazing.orbits.adding_tree import adding_tree
    >>> tree = adding_tree(0.5, 0.1, 2)
    >>> list(zip(tree["word"].values.tolist(), tree["status"].values.tolist()))
    [('L', 'stable'), ('LLR', 'stable'), ('LR', 'stable'), ('LRR', 'virtual'), ('R', 'stable')]
    """
    lam, l = real(lam, "lam", "allowed is any finite number"), real(l, "l", "allowed is any finite number")
    levels = whole(depth, "depth", 1)
    # a word is as long as its two neighbours together, so that the letters of all levels are 3 times those before
    letters = min(levels, DEEP)
    ends = _ends(between)
    refuse_too_large(NODE * 2.0**letters + max(map(len, ends)) * 3.0**letters, f"reduce depth ({levels})", "the tree")
    nodes, order = _grown(ends, levels)
    place = {number: i for i, number in enumerate(order)} | {-1: -1}
    rows = [nodes[number] for number in order]
    stable, exist = zip(*(both_windows(node.word, lam, l, span) for node in rows), strict=True)
    best = [max(found, key=_width, default=None) for found in stable]
    nan = float("nan")

    def column(values: list[Any], dtype: Any, long_name: str, **more: str) -> Any:
        return "node", np.array(values, dtype), {"long_name": long_name, **more}

    from grazing.late import xarray as xr

    about = {"symbol": PARAMETERS["mu"].symbol, "units": "1"}
    return xr.Dataset(
        {
            "word": column([node.word for node in rows], np.str_, "word"),
            "length": column([len(node.word) for node in rows], np.int64, "letters of the word", units="1"),
            "right_letters": column([node.word.count("R") for node in rows], np.int64, "letters R", units="1"),
            "level": column([node.level for node in rows], np.int64, "level of the tree", units="1"),
            "left": column([place[node.left] for node in rows], np.int64, "node on the left that is joined"),
            "right": column([place[node.right] for node in rows], np.int64, "node on the right that is joined"),
            "status": column(
                ["stable" if a else "unstable" if b else "virtual" for a, b in zip(stable, exist, strict=True)],
                np.str_,
                "what became of the word",
                meaning="; ".join(f"{name}: {text}" for name, text in STATUS.items()),
            ),
            "windows": column([len(found) for found in stable], np.int64, "intervals with a stable orbit", units="1"),
            "low": column([w.low if w else nan for w in best], float, "lower end of the window", **about),
            "high": column([w.high if w else nan for w in best], float, "upper end of the window", **about),
            "low_type": column([w.low_type if w else "" for w in best], np.str_, "type of the lower end"),
            "high_type": column([w.high_type if w else "" for w in best], np.str_, "type of the upper end"),
            "exists_low": column([w[0].low if w else nan for w in exist], float, "first mu with an orbit", **about),
            "exists_high": column([w[-1].high if w else nan for w in exist], float, "last mu with an orbit", **about),
        },
        attrs={
            "title": f"words between {ends[0]} and {ends[1]}, gap map",
            "parameters": json.dumps({"lam": lam, "l": l}),
            "depth": levels,
            "between": list(ends),
            **({"span": list(span)} if span is not None else {}),
        },
    )


def _ends(between: Any) -> tuple[str, str]:
    """Return the two words at the ends, or raise InputError."""
    try:
        first, second = in_order(between)
        letters = [letters_of(one, "LR") for one in (first, second)]
    except (TypeError, ValueError) as error:
        said = f": {error}" if isinstance(error, InputError) else ""
        raise InputError(
            f"between = {shown(between)}; give two words of L and R, such as ('LRR', 'LLRR'){said}"
        ) from None
    if any(len(primitive(one)) < len(one) for one in letters) or word(letters[0]) == word(letters[1]):
        raise InputError(f"between = {shown(between)}; give two different words, neither of them a repetition")
    return str(first), str(second)


def _grown(ends: tuple[str, str], depth: int) -> tuple[list[Node], list[int]]:
    """Return the nodes, level by level, and their numbers in the order of the tree."""
    nodes = [Node(ends[0], 0, -1, -1), Node(ends[1], 0, -1, -1)]
    order = [0, 1]
    for level in range(1, depth + 1):
        wider = [order[0]]
        for a, b in pairwise(order):
            nodes.append(Node(nodes[a].word + nodes[b].word, level, a, b))
            wider += [len(nodes) - 1, b]
        order = wider
    turned = [node._replace(word=word(letters_of(node.word, "LR"), "LR")) for node in nodes]
    return turned, order


def _width(window: WordWindow) -> float:
    return window.high - window.low if math.isfinite(window.high - window.low) else math.inf
