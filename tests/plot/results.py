"""Small results in the layouts of the studies, made up: no study runs for them."""

import json

import numpy as np
import xarray as xr

ATTRS = {
    "title": "made up",
    "source": "grazing 0.0",
    "grazing_config": json.dumps({"study": "none", "map": "made up", "values": [1, 2]}),
    "grazing_config_sha256": "0" * 64,
}
COARSE, FINE, UNIT = np.linspace(3.4, 4.0, 60), np.linspace(3.4, 4.0, 120), np.linspace(0.0, 1.0, 80)


def logistic(values, steps=400, lanes=8):
    """Orbits of x -> r x (1 - x), shape (values, steps * lanes)."""
    r = np.asarray(values)[:, None]
    x = np.tile(np.linspace(0.1, 0.9, lanes), (len(r), 1))
    found = []
    for k in range(200 + steps):
        x = r * x * (1.0 - x)
        if k >= 200:
            found.append(x)
    return np.concatenate(found, axis=1)


def density(values=COARSE, bins=40, low=0.1, high=0.95, ended=0, steps=400):
    edges = np.linspace(low, high, bins + 1)
    points = logistic(values, steps)
    count = np.array([np.histogram(row, edges)[0] for row in points])
    result = xr.Dataset(
        {
            "count": (("r", "x"), count),
            "below": ("r", (points < low).sum(axis=1)),
            "above": ("r", (points > high).sum(axis=1)),
            "ended": ("r", np.full(len(values), ended)),
        },
        {"r": values, "x": 0.5 * (edges[1:] + edges[:-1])},
        ATTRS,
    )
    result["x"].attrs |= {"low": low, "high": high, "symbol": "x"}
    return result


def chart(nx=20, ny=16, ranks=4, x=None, y=None, seed=0, periods=(1, 2, 3, 4, 5)):
    """Tongues of the periods that overlap; chaos, undecided and ended corners."""
    x = np.linspace(-1.0, 1.0, nx) if x is None else np.asarray(x)
    y = np.linspace(0.0, 0.4, ny) if y is None else np.asarray(y)
    u, v = np.meshgrid(np.linspace(0, 1, len(x)), np.linspace(0, 1, len(y)), indexing="ij")
    at = np.linspace(0.1, 0.9, len(periods))
    inside = np.stack([np.abs(u - c) < 0.06 + 0.1 * v for c in at], axis=-1)
    weight = np.where(inside, 1.2 - np.abs(u[..., None] - at) / 0.16, 0.0)
    codes = np.array([*periods, -1, 0, -2])
    extra = np.stack([(weight.sum(-1) == 0) * 1.0, (v > 0.93) * 0.3, (u + v < 0.12) * 2.0], axis=-1)
    weight = np.concatenate([weight, extra], axis=-1)
    share = np.round(8 * weight / weight.sum(-1, keepdims=True)) / 8
    order = np.argsort(-share, axis=-1, kind="stable")[..., :ranks]
    share = np.take_along_axis(share, order, -1)
    period = np.where(share > 0, codes[order], -3).astype(np.int32)
    words = np.array(["L" * (p - 1) + "R" if p > 0 else "" for p in codes], object)
    exponent = np.where(period >= 1, -0.8 * np.sqrt(np.abs(u - 0.52))[..., None] - 0.02, 0.15 * v[..., None] + 0.01)
    exponent = np.where(period == -2, -np.inf, np.where(share > 0, exponent, np.nan))
    dims = ("mu", "l", "rank")
    result = xr.Dataset(
        {
            "period": (dims, period),
            "share": (dims, share),
            "word": (dims, np.where(share > 0, words[order], "").astype(object)),
            "exponent": (dims, exponent),
            "outcome": (dims, np.zeros(period.shape, np.int32)),
            "trust": (dims, np.zeros(period.shape, np.int8)),
        },
        {"mu": x, "l": y},
        ATTRS,
    )
    result["mu"].attrs["symbol"] = r"\mu"
    result["l"].attrs["symbol"] = "l"
    return result


def basins(n=60, periods=(2, 3, 3, -1), words=("12", "0(12)1", "011", ""), graze=True):
    u, v = np.linspace(-0.5, 0.12, n), np.linspace(-1.0, 1.0, n)
    p, q = np.meshgrid(u, v, indexing="ij")
    field = np.sin(7.0 * p + 3.0 * np.sin(4.0 * q)) + 0.5 * np.sin(11.0 * q - 5.0 * p)
    index = np.searchsorted(np.quantile(field, np.linspace(0, 1, len(periods) + 1)[1:-1] ** 0.7), field)
    fraction = np.bincount(index.ravel(), minlength=len(periods)) / index.size
    points = np.array([[-0.35 + 0.12 * k, 0.5 * (-1) ** k] for k in range(len(periods))], float).reshape(-1, 2)
    points[np.asarray(periods) < 1] = np.nan
    t = np.linspace(-0.9, 0.9, 80)
    curves = [np.column_stack([0.1 - 0.25 * t**2 - 0.06 * k, t + 0.05 * k]) for k in range(4)]
    curve = np.concatenate([np.vstack([c[:40], [[np.nan, np.nan]], c[40:]]) for c in curves])
    data = {
        "basin": (("u", "v"), index.astype(np.int32)),
        "period": ("attractor", np.array(periods, np.int32)),
        "word": ("attractor", np.array(words, object)),
        "fraction": ("attractor", fraction),
        "point": (("attractor", "coordinate"), points),
    }
    if graze:
        data |= {
            "graze": (("graze_point", "coordinate"), curve),
            "graze_order": ("graze_point", np.repeat(np.arange(4, dtype=np.int32), 81)),
        }
    result = xr.Dataset(data, {"u": u, "v": v, "coordinate": ["u", "v"]}, ATTRS)
    return result


def strip(n=400):
    x = np.linspace(-1.0, 0.5, n)
    index = (np.sin(40.0 / (1.1 + x)) > 0.2).astype(np.int32)
    return xr.Dataset(
        {
            "basin": ("x", index),
            "period": ("attractor", np.array([3, 4], np.int32)),
            "word": ("attractor", np.array(["LLR", "LLLR"], object)),
            "fraction": ("attractor", np.bincount(index) / n),
            "point": (("attractor", "coordinate"), [[-0.3], [0.2]]),
        },
        {"x": x, "coordinate": ["x"]},
        ATTRS,
    )


def lyapunov(values=FINE, starts=5, count=2, infinite=True, seed=0):
    rng = np.random.default_rng(seed)
    orbit = logistic(values, 400, 1)
    first = np.log(np.abs(values[:, None] * (1 - 2 * orbit)) + 1e-300).mean(axis=1)
    exponent = np.stack([first - 1.1 * k for k in range(count)], axis=-1)[:, None, :]
    exponent = exponent + 0.004 * rng.standard_normal((len(values), starts, count))
    if infinite:
        exponent[: len(values) // 6, :, -1] = -np.inf
        exponent[len(values) // 2, 0, :] = np.nan
        exponent[: len(values) // 10, 0, 0] = -np.inf
    dims = ("r", "start", "index")
    return xr.Dataset(
        {
            "exponent": (dims, exponent),
            "exponent_per_time": (dims, exponent / 2.0),
            "return_time": (dims[:2], np.full(exponent.shape[:2], 2.0)),
            "outcome": (dims[:2], np.zeros(exponent.shape[:2], np.int32)),
            "trust": (dims[:2], np.zeros(exponent.shape[:2], np.int8)),
        },
        {"r": values},
        ATTRS,
    )


def coexistence(values=UNIT, periods=(1, 2, 4, 3, 3, -1, 0), words=None, seed=0):
    rng = np.random.default_rng(seed)
    words = words or ("1", "01", "01", "0(12)1", "LLLLLLR", "", "")
    t = np.linspace(0.0, 1.0, len(values))
    centre, width = np.linspace(0.05, 0.95, len(periods)), 0.28
    weight = np.maximum(0.0, 1.0 - np.abs(t[:, None] - centre) / width) + 1e-9
    share = np.round(40 * weight / weight.sum(axis=1, keepdims=True) + rng.uniform(-0.4, 0.4, weight.shape)) / 40
    share = np.maximum(share, 0.0)
    share = share / share.sum(axis=1, keepdims=True)
    lifetime = np.where(
        share > 0, 8.0 + 200.0 * np.abs(t[:, None] - centre) ** 2 + rng.exponential(2.0, share.shape), np.nan
    )
    dims = (("mu", "attractor"),)
    change = np.linspace(values[0], values[-1], 9)[1:-1]
    kinds = ["appears", "doubles", "relabelled", "appears", "disappears", "disappears", "merges"]
    result = xr.Dataset(
        {
            "share": (*dims, share),
            "lifetime": (*dims, lifetime),
            "period": ("attractor", np.array(periods, np.int32)),
            "word": ("attractor", np.array(words, object)),
            "before": ("change", change),
            "after": ("change", change + 0.01),
            "word_before": ("change", np.array(["1"] * 7, object)),
            "word_after": ("change", np.array(["01"] * 7, object)),
            "kind": ("change", np.array(kinds, object)),
        },
        {"mu": values},
        ATTRS,
    )
    result["mu"].attrs["symbol"] = r"\mu"
    return result
