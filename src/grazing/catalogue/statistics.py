"""Word statistics, as they are asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import LONGEST, of, short, table

Rows = list[Row]


def found(result: Any) -> Row:
    """Return the most frequent words and the entropies at one value; over a range a few of them at each value."""
    dims = [str(dim) for dim in result["left"].dims]
    said: Row = {"length": int(result["length"].values[-1])}
    said |= {key: int(result[key].values.sum()) for key in ("left", "ended", "ambiguous")}
    if not dims:
        columns = {
            key: result[key].values.tolist()
            for key in ("length", "words", "counted", "entropy", "conditional_entropy", "conditional_entropy_error")
        }
        each = zip(*columns.values(), strict=True)
        return said | {"words": listed(result), "entropies": [dict(zip(columns, row, strict=True)) for row in each]}
    rows = []
    for i, value in enumerate(result[dims[0]].values.tolist()):
        here = result.isel({dims[0]: i})
        last = {
            key: float(here[key].values[-1]) for key in ("entropy", "conditional_entropy", "conditional_entropy_error")
        }
        rows.append({dims[0]: value, "words": int(here["words"].values[-1]), **last, "first": listed(here)[:1]})
    return said | {"parameter": dims[0], "values": rows}


def listed(result: Any) -> Rows:
    """Return the words at one value, the most frequent first."""
    columns = (result[key].values.tolist() for key in ("word", "share", "share_error"))
    return [{"word": word, "share": p, "error": e} for word, p, e in zip(*columns, strict=True) if word]


def words(found: Row, *_of: Any) -> list[str]:
    """Return a table of words and one of entropies, or a row for each value."""
    n = found["length"]
    ended = [f"{found[key]} orbits {says}" for key, says in (("left", "left"), ("ended", "ended")) if found[key]]
    if "parameter" in found:
        name = found["parameter"]
        head = [f"{name} {of(name, found)}".rstrip(), "words", "next letter (nat)", "error", "most frequent", "share"]
        rows = []
        for row in found["values"]:
            first: Row = row["first"][0] if row["first"] else {"word": "-", "share": float("nan")}
            rows.append(
                [
                    short(row[name]), str(row["words"]), short(row["conditional_entropy"], 5),
                    short(row["conditional_entropy_error"], 1), cut(first["word"]), short(first["share"], 3),
                ]
            )  # fmt: skip
        return [f"words of {n} letters", *table(head, rows), *ended]
    if not found["words"]:
        return [
            f"no word of {n} letters was counted: orbits left or ended before; give a smaller --transient or --length",
            *ended,
        ]
    listing = [[cut(row["word"]), short(row["share"], 3), short(row["error"], 1)] for row in found["words"]]
    lengths = [
        [
            str(row["length"]), str(row["words"]), str(row["counted"]), short(row["entropy"], 5),
            short(row["conditional_entropy"], 5), short(row["conditional_entropy_error"], 1),
        ]
        for row in found["entropies"]
    ]  # fmt: skip
    entropies = table(["letters", "words", "counted", "entropy (nat)", "next letter (nat)", "error"], lengths)
    return [*table([f"words of {n} letters", "share", "error"], listing), "", *entropies, *ended]


def cut(word: str) -> str:
    """Return a word, its beginning if it is long."""
    return word if len(word) <= 2 * LONGEST else f"{word[: 2 * LONGEST - 3]}..."


STUDY = Study(
    name="statistics", place=52, compute="grazing.studies.word_statistics:word_statistics", most=1,
    says="how often orbits spell which words, and the entropies of these",
    help="Count which words orbits spell, such as bumpers in a row, and their entropies.",
    example="--table classic --transient 0 -o words.png",
    prints="at one value the most frequent words, and for each length the entropy and that of the next letter; over a "
    "range the latter and the most frequent word at each value",
    found=found, words=words,
    options={
        "length": ("whole", 1, "letters in a row that are counted as a word, at most 64"),
        "most": ("whole", 1, "how many words are listed, the most frequent ones"),
    },
)  # fmt: skip
