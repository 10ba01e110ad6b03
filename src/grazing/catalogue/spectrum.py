"""The spectrum of a motion, as it is asked for and told."""

from __future__ import annotations

from typing import Any

from grazing.catalogue.study import Row, Study
from grazing.catalogue.words import headed, of, short, table

#: Lines that are listed have this share of the strongest.
FAINTEST = 1e-3


def found(result: Any) -> Row:
    """Return the strongest lines, and how fine and how far the spectrum is."""
    import numpy as np

    y, order, frequency = (result[name].values for name in ("amplitude", "order", "frequency"))
    inner = np.arange(1, len(y) - 1)
    peaks = inner[(y[inner] > y[inner - 1]) & (y[inner] >= y[inner + 1]) & (y[inner] >= FAINTEST * y[1:].max())]
    peaks = peaks[np.argsort(-y[peaks], kind="stable")]
    names = {"frequency": frequency, "order": order, "amplitude": y}
    return {
        "lines": [{key: float(values[i]) for key, values in names.items()} for i in peaks.tolist()],
        "resolution": float(frequency[1]),
        "until": float(frequency[-1]),
    }


def words(found: Row, *_of: Any) -> list[str]:
    """Return the strongest lines, and how fine and how far the spectrum is."""
    rows = [[short(row[key]) for key in ("frequency", "order", "amplitude")] for row in found["lines"]]
    hertz = of("frequency", found)
    head = [headed("frequency", hertz), "order", headed("amplitude", of("amplitude", found))]
    said = table(head, rows) or ["no lines: nothing moves"]
    return [*said, f"from 0 to {short(found['until'])} in steps of {short(found['resolution'])} {hertz}".rstrip()]


STUDY = Study(
    name="spectrum", place=100, compute="grazing.signals.record:spectrum_of", of="model",
    says="amplitudes of one orbit by frequency",
    help="Take a motion apart into lines at their frequencies.",
    example="u=0 v=0 --until 600 --since 100 --d 0.12 --V 0.4 -o spectrum.png",
    prints="the strongest lines with frequency, order and amplitude, how fine and how far it is",
    found=found, words=words, figure="spectrum",
)  # fmt: skip
