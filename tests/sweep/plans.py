"""Small honest plans: gap-map orbits, one cell each a value of mu or a pair (mu, l)."""

import json
import time

import numpy as np

import grazing as gz
from grazing.studies.plan import Plan, Variable


def logistic(state, p):
    """A user's step."""
    (x,) = state
    return (p.a * x * (1.0 - x),)


def own_map():
    return gz.Map(logistic, params={"a": 3.2}, coordinates=("x",), box=((0.0, 1.0),), letters="L", name="logistic")


class Orbits:
    """Computes cells: last points, letters as a word, the mean; some cells NaN, empty or all zero."""

    def __init__(self, P, names, axes, keep, pause):
        self.P, self.names, self.axes, self.keep, self.pause = P, names, axes, keep, pause

    def rows(self, cells):
        shape = tuple(len(values) for values in self.axes)
        at = np.unravel_index(cells, shape) if shape else ()
        table = np.tile(list(self.P.params.values()), (len(cells), 1)).astype(float)
        for name, values, i in zip(self.names, self.axes, at, strict=True):
            table[:, list(self.P.params).index(name)] = values[i]
        return table

    def __call__(self, cells, arrays):
        starts = np.tile(np.linspace(-0.5, 0.5, 3), (len(cells), 1, 1))
        found = self.P.run_columns(self.rows(cells), starts, 50, self.keep, arithmetic="strict", threads=1)
        yield
        if self.pause:
            time.sleep(self.pause * len(cells))
        for i, cell in enumerate(cells):
            arrays["points"][i] = found.points[i, :, 0, :].T
            arrays["mean"][i] = np.nan if cell % 5 == 2 else found.points[i].mean()
            arrays["period"][i] = 0 if cell % 3 else int(cell) + 1
            for j in range(3):
                word = "".join("LR"[k] for k in found.letters[i, : (int(cell) + j) % (self.keep + 1), j])
                arrays["word"][i, j] = word
            yield


def finish(result):
    return result.assign(total=("start", result.points.sum(("mu", "n")).values)).assign_attrs(finished="yes")


def plan(
    n=7,
    m=None,
    keep=4,
    together=2,
    pause=0.0,
    seed=0,
    P=None,
    name="mu",
    finish=None,
    recipe=None,
    sequential=False,
    config=None,
    work=10**8,
):
    P = gz.gap_map(lam=0.5, mu=0.1, l=0.1) if P is None else P
    axes = {name: np.linspace(0.05, 0.15, n)}
    if m is not None:
        axes["l"] = np.linspace(0.05, 0.2, m)
    codes = {"flag_values": np.array([0, -1], np.int32), "flag_meanings": "undecided aperiodic", "valid_range": [0, 99]}
    return Plan(
        P=P,
        title=f"test orbits of {P.name}",
        config={
            "study": "test",
            "values": [[*map(float, axes[name])]],
            "m": m,
            "keep": keep,
            "seed": seed,
            **(config or {}),
        },
        axes=axes,
        sizes={"start": 3, "n": keep},
        variables={
            "points": Variable(("start", "n"), "float64", {"long_name": "points", "units": "1", "bound": np.inf}),
            "mean": Variable((), "float32", {"long_name": "mean", "weight": np.float64(0.25)}),
            "period": Variable((), "int32", codes),
            "word": Variable(("start",), "text", {"long_name": "word"}, longest=keep),
        },
        compute=Orbits(P, tuple(axes), tuple(axes.values()), keep, pause),
        together=together,
        work=work,
        axis_attrs={name: {"long_name": name, "units": "1"}},
        coords={
            "label": ("start", np.array(["a", "bβ", ""], object), {"long_name": "label"}),
            "x0": ("start", [1, 2, 3]),
        },
        finish=finish,
        sequential=sequential,
        recipe=recipe,
    )


def files(store):
    """Every file that belongs to the result, with its bytes."""
    return {
        file.relative_to(store).as_posix(): file.read_bytes()
        for file in sorted(store.rglob("*"))
        if file.is_file() and file.relative_to(store).parts[0] != ".grazing"
    }


def config_of(store):
    return json.loads(json.loads((store / "zarr.json").read_text())["attributes"]["grazing_config"])
