"""What tests ask of both forms, in this process and in one that takes the plain ones."""

import hashlib
import json
from typing import NamedTuple

import numpy as np

import grazing as gz
from grazing.kernel import wide
from grazing.kernel.compile import compiled, digest, processor
from grazing.kernel.primitives import numbers
from grazing.kernel.rows import all_passed, first_bit
from grazing.kernel.turns import eights
from grazing.kernel.vectors import appended


def lowest(bits):
    return first_bit(bits)


def asks(work, table):
    all_passed(numbers(work), 0, 8, 0, 8, 16, 24, numbers(table), 0, 4, 4, 0)


def squared(work, n):
    w = numbers(work)
    for base in range(0, n, 8):
        for k in range(8):
            w[base + eights(k)] *= w[base + k]


def gathers(work, n):
    return appended(numbers(work), 0, n, 0, (16,), (32,), 0)


class Rows(NamedTuple):
    A: int
    B: int


def reads(a, b):
    """Return a kernel that names a record."""
    scope = {"__name__": __name__, "W": Rows(a, b)}
    exec("def f(x):\n    return x[W.A] + x[W.B]", scope)
    return scope["f"]


def small():
    """Return results of kernels that compile quickly."""
    work = np.arange(48.0) - 7.5
    count = compiled(gathers)(work, 16)
    compiled(squared)(work, 16)
    asked = np.random.default_rng(1).normal(size=32)
    compiled(asks)(asked, np.linspace(-1.0, 3.0, 12))
    return [
        compiled(lowest)(96),
        count,
        *asked.tolist(),
        *work[: 32 + count].tolist(),
        compiled(reads(1, 2))((5.0, 6.0, 7.0)),
    ]


def bits():
    """Return the hash of orbits, some of which need the scalar routine: of all that is said of them."""
    P = gz.stroboscopic_map(gz.pinball(V=0.4))
    rows = np.tile(list(P.params.values()), (12, 1))
    rows[:, list(P.params).index("d")] = np.linspace(-0.3, 1.2, 12)
    rows[::2, list(P.params).index("V")] = 0.0
    random = np.random.default_rng(8)
    lanes = np.stack([random.uniform(0.0, 0.3, (12, 11)), random.uniform(-0.5, 0.5, (12, 11))], 1)
    found = P.run_columns(rows, lanes, 0, 30, arithmetic="strict", algorithm="block", threads=1)
    assert {0, 1, 2, 3} <= set(found.letters.ravel().tolist())
    together = b"".join(np.ascontiguousarray(each).tobytes() for each in (*found, lanes))
    return hashlib.sha256(together).hexdigest()


def told_apart():
    return [digest(asks), digest(squared), processor()]


def step():
    return digest(gz.stroboscopic_map(gz.pinball(V=0.4)).step)


def tell(all_of_it):
    found = {"why": wide.plain(), "small": small(), "apart": told_apart(), "step": step()}
    if all_of_it:
        found["bits"] = bits()
    print(json.dumps(found))
