"""The chart of two parameters, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.rows import AMBIGUOUS, KINDS, attractor, numbered
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import named, share, table


def found(result: Any) -> Row:
    """Return the attractors of a chart with their shares of the cells, and the shares that say more of all of them."""
    import numpy as np

    period, word = result["period"].values, result["word"].values
    held = period >= min(KINDS)
    kinds, which = numbered(np.where(held, period, 0), np.where(held, word, ""))
    rows = []
    for i, (p, w) in enumerate(kinds):
        here = (which == i) & held
        if here.any():
            share, first = float(here.any(axis=-1).mean()), float(here[..., 0].mean())
            rows.append(attractor(p, w, share=share, first=first))
    rows.sort(key=lambda row: (-row["share"], -row["first"]))
    doubtful = ((result["trust"].values == AMBIGUOUS) & held).any(axis=-1)
    stretched = (result["exponent"].values > 0.0).any(axis=-1)
    return {
        "cells": int(np.prod(period.shape[:-1])),
        "attractors": rows,
        "several": float((held.sum(axis=-1) > 1).mean()),
        "positive": float(stretched.mean()),
        "ambiguous": int(doubtful.sum()),
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return the attractors of a chart, with their shares of the cells."""
    many = found["cells"]
    rows = [[*named(row), share(row["share"], many), share(row["first"], many)] for row in found["attractors"]]
    said = table(["word", "", "cells", "most starts in"], rows)
    said.append(f"more than one attractor in {share(found['several'], many)} of the cells")
    return [*said, f"an exponent is positive in {share(found['positive'], many)} of the cells"]


STUDY = Study(
    name="chart", place=30, compute="grazing.studies.chart:chart", least=2, most=2,
    says="periods and words as two parameters vary",
    help="Show which attractors there are, by period and word, as two parameters vary.",
    example="d=0.05:0.16:400 V=0:0.4:400 -o chart.png",
    prints="the attractors with their shares of the cells, where there is more than one, where an exponent is positive",
    found=found, words=words, beside=("curves",), counts="cells",
)  # fmt: skip
