"""An orbit of a one-dimensional map, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.rows import events, symbol
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import between, event_words, short
from grazing.outcome import FATAL

#: Letters of an orbit that are listed.
LETTERS = 60


def found(result: Any) -> Row:
    """Return the letters of an orbit, its range, its last point and what happened."""
    import numpy as np

    name = str(result["image"].attrs.get("symbol", ""))
    name = next(str(key) for key in result.data_vars if result[key].dims == ("n",)) if name not in result else name
    x, letters = result[name].values, result["letter"].values
    ended = np.flatnonzero(result["outcome"].values & FATAL)
    spelled = [symbol(code, result["letter"]) for code in letters[:LETTERS].tolist()]
    finite = x[np.isfinite(x)]
    return {
        "coordinate": name,
        "steps": len(letters),
        "letters": "".join(spelled),
        "range": [float(finite.min()), float(finite.max())] if finite.size else None,
        "last": float(x[-1]),
        "ended": int(ended[0]) if ended.size else None,
        "events": events(result["outcome"].values),
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return the letters, the range and the end of an orbit."""
    dots = "..." if found["steps"] > len(found["letters"]) else ""
    said = [f"letters: {found['letters']}{dots}"]
    if found["range"] is not None:  # else it had ended before the first point
        said.append(f"{found['coordinate']} {between(found['range'])}; last {short(found['last'])}")
    if found["ended"] is not None:
        said.append(f"ended at step {found['ended']}")
    return [*said, *event_words(found["events"])]


STUDY = Study(
    name="cobweb", place=110, compute="grazing.studies.cobweb:cobweb", dimension=1,
    says="one orbit of a one-dimensional map, step by step",
    help="Draw an orbit of a one-dimensional map.",
    example="x=0.1 --map gap --lam 0.8 --mu 0.05 --l 0.1 -o cobweb.png",
    prints="letters, where they change, how far the discontinuity map is from the exact one",
    found=found, words=words,
)  # fmt: skip
