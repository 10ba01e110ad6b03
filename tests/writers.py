"""All that writes one file, by its ending: each writes the same again and again."""

from functools import cache

import xarray as xr

import grazing as gz
from grazing.export import to_csv
from grazing.paper import files
from grazing.proof.text import write_certificate


@cache
def motion():
    m = gz.pinball(d=0.12, V=0.4)
    return gz.trajectory(m, (0.1, 0.0), until=30 * m.period), 30 * m.period


def to_wav(path):
    trajectory, length = motion()
    gz.to_wav(trajectory, path, speed=length)


RESULT = xr.Dataset({"x": ("d", [float(i) for i in range(5000)])})
WRITERS = {
    ".nc": lambda path: gz.save(RESULT, path),
    ".csv": lambda path: to_csv(RESULT, path),
    ".parquet": lambda path: gz.to_parquet(RESULT, path),
    ".wav": to_wav,
    ".png": lambda path: gz.plot.save(gz.plot.figure(), path),
    ".json": lambda path: write_certificate({"a": ["b"] * 5000}, path),
    ".html": lambda path: files.write(path, "c" * 50_000),
}
