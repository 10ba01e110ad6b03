"""One step of a map along a line of states, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.rows import events, ranges_of, symbol
from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import event_words, headed, places, short, table


def found(result: Any) -> Row:
    """Return where each map takes each letter, and how far two maps differ where their letters agree."""
    import numpy as np

    name = next(str(dim) for dim in result["letter"].dims if dim != "map")
    grid, letters = result[name].values.astype(np.float64), result["letter"].values
    rows = []
    for of, codes in zip(result["map"].values.tolist(), letters, strict=True):
        for code in np.unique(codes).tolist():
            here = codes == code
            rows.append(
                {"map": of, "letter": symbol(code, result["letter"]), "states": int(here.sum()),
                 "ranges": ranges_of(grid, here)}
            )  # fmt: skip
    said: Row = {"coordinate": name, "states": len(grid), "letters": rows, "events": events(result["outcome"].values)}
    if len(letters) == 2:
        same = letters[0] == letters[1]
        said["agree"] = int(same.sum())
        images = [str(key) for key in result.data_vars if str(key).startswith("image_")]
        gaps = {key: np.abs(np.diff(result[key].values, axis=0))[0][same] for key in images}
        said["differ"] = {
            key.removeprefix("image_"): float(gap[np.isfinite(gap)].max())
            for key, gap in gaps.items() if np.isfinite(gap).any()
        }  # fmt: skip
    return said


def words(found: Row, *_of: Any) -> list[str]:
    """Return where each letter is taken, and how far the two maps differ."""
    name = found["coordinate"]
    rows = [[row["map"], row["letter"], str(row["states"]), places(row["ranges"])] for row in found["letters"]]
    said = table(["map", "letter", "states", f"{headed(name, found.get('unit', ''))} from"], rows)
    if "agree" in found:
        gaps = ", ".join(f"{short(gap, 3)} in {key}" for key, gap in found["differ"].items())
        agree = f"letters agree at {found['agree']} of {found['states']} states"
        said.append(f"{agree}; there the images differ by at most {gaps}" if gaps else agree)
    return [*said, *event_words(found["events"])]


STUDY = Study(
    name="graph", place=120, compute="grazing.studies.graph:graph", least=1, most=1, varies="coordinate",
    says="one step of the map along a line of states",
    help="Draw one step of a map along a line of states, beside the discontinuity map of the oscillator.",
    example="u=0.01:0.06:600 v=-0.23 --omega 2.1 --t0 2.2 --d 0.11 --V 0.2 -o graph.png",
    prints="letters, where they change, how far the discontinuity map is from the exact one",
    found=found, words=words, beside=("coordinate",),
)  # fmt: skip
