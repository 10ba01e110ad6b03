"""Run a module of the explorer as the page does: arrays by address, numbers as they are."""

import ctypes

import numpy as np
import wasmtime

KINDS = {"float64": np.float64, "int64": np.int64, "int32": np.int32, "int8": np.int8}
PAGE = 65536


def whole(expression, sizes):
    """A size by name or number, or one plus a number."""
    if isinstance(expression, int):
        return expression
    name, _, more = expression.partition(" + ")
    return sizes[name] + int(more or 0)


class Module:
    """A module with its memory; ``call(name, **arguments)`` puts arrays into it and takes them out again.

    Parameters
    ----------
    code : bytes
    described : dict
        The module's part of kernels.json.
    """

    def __init__(self, code, described):
        engine = wasmtime.Engine()
        module = wasmtime.Module(engine, code)
        self.imports = [f"{item.module}.{item.name}" for item in module.imports]
        self.store = wasmtime.Store(engine)
        self.exports = wasmtime.Instance(self.store, module, []).exports(self.store)
        self.functions = {function["name"]: function for function in described["functions"]}
        self.memory = self.exports["memory"]

    def bytes(self):
        pointer = self.memory.data_ptr(self.store)
        size = self.memory.data_len(self.store)
        return np.ctypeslib.as_array(ctypes.cast(pointer, ctypes.POINTER(ctypes.c_uint8)), (size,))

    def call(self, name, **given):
        """Call a function; arrays in ``given`` are overwritten with what the module made of them."""
        function = self.functions[name]
        given = {key: value for key, value in given.items()}
        free = self.exports["__heap_base"].value(self.store)
        sizes = {size: given.pop(size) for size in function["sizes"]}
        values, arrays = [sizes[size] for size in function["sizes"]], []
        known = dict(sizes, **{key: value for key, value in given.items() if isinstance(value, int)})
        for argument in function["arguments"]:
            value = given.pop(argument["name"])
            if not argument["shape"]:
                values.append(float(value) if argument["kind"] == "float64" else int(value))
                continue
            shape = tuple(whole(size, known) for size in argument["shape"])
            assert value.dtype == KINDS[argument["kind"]], argument["name"]
            assert value.shape == shape and value.flags.c_contiguous, (argument["name"], value.shape, shape)
            place = (free + 63) // 64 * 64
            free = place + value.nbytes
            arrays.append((place, value))
            values.append(place)
        assert not given, f"{name} has no arguments {list(given)}"
        missing = (free + PAGE - 1) // PAGE - self.memory.size(self.store)
        if missing > 0:
            self.memory.grow(self.store, missing)
        for place, value in arrays:
            self.bytes()[place : place + value.nbytes] = np.frombuffer(value.tobytes(), np.uint8)
        self.exports["arena"](self.store, free)
        result = self.exports[name](self.store, *values)
        for place, value in arrays:
            found = self.bytes()[place : place + value.nbytes]
            value[...] = np.frombuffer(found.tobytes(), value.dtype).reshape(value.shape)
        return result


def fields_of(described):
    return [field["name"] for field in described["fields"]]


def row_of(described, law="", **params):
    """Parameter values in the order of a row; what a model does not have is 0."""
    choices = {field["name"]: field["choices"] for field in described["fields"] if "choices" in field}
    values = dict(params, law=choices["law"].index(law)) if law else params
    values.setdefault("offset", values.pop("d", 0.0))
    unknown = values.keys() - {*fields_of(described), "offset"}
    assert not unknown, unknown
    return np.array([values.get(name, 0.0) for name in fields_of(described)], float)


def draw(machine, dimension, rows, names, starts, seed, boxes=None):
    """Random starts of columns, (columns, dimension, starts)."""
    columns = len(rows)
    if boxes is None:
        boxes = np.empty((columns, dimension, 2))
        machine.call("boxes", columns=columns, rows=rows.copy(), boxes=boxes)
    lanes = np.empty((columns, dimension, starts))
    names = np.array(names, float).reshape(columns, -1)
    machine.call(
        "draw", columns=columns, starts=starts, axes=names.shape[1], seed=seed, names=names, boxes=boxes, lanes=lanes
    )
    return lanes


def raster(machine, rows, lanes, transient, keep, coordinate, low, high, bins):
    """Counts (columns, bins + 3), and ended and ambiguous starts (columns,)."""
    columns = len(rows)
    counts = np.empty((columns, bins + 3), np.int32)
    ended, ambiguous = np.empty(columns, np.int32), np.empty(columns, np.int32)
    machine.call(
        "density", columns=columns, starts=lanes.shape[2], rows=rows.copy(), lanes=lanes.copy(), transient=transient,
        keep=keep, coordinate=coordinate, low=low, high=high, bins=bins, counts=counts, ended=ended,
        ambiguous=ambiguous,
    )  # fmt: skip
    return counts, ended, ambiguous


def orbits(machine, rows, lanes, transient, keep, name="orbits"):
    """Points (columns, keep, dimension, starts), letters and outcomes."""
    columns, dimension, starts = lanes.shape
    points = np.empty((columns, keep, dimension, starts))
    letters = np.empty((columns, keep, starts), np.int32)
    outcomes = np.zeros((columns, 1, starts), np.int32)
    machine.call(
        name, columns=columns, starts=starts, keep=keep, rows=rows.copy(), lanes=lanes.copy(), transient=transient,
        points=points, letters=letters, outcomes=outcomes,
    )  # fmt: skip
    return points, letters, outcomes


def classes(machine, rows, points, letters, outcomes, tolerance):
    """Period, key, begin and length of each orbit (columns, starts), then count and first of the classes."""
    columns, keep, starts = letters.shape
    period, begin, length = (np.empty((columns, starts), np.int32) for _ in range(3))
    count, first = np.empty((columns, starts), np.int32), np.empty((columns, starts), np.int32)
    key = np.empty((columns, starts), np.int64)
    machine.call(
        "classify", columns=columns, starts=starts, keep=keep, rows=rows.copy(), points=points, letters=letters,
        outcomes=outcomes, tolerance=tolerance, period=period, key=key, begin=begin, length=length,
    )  # fmt: skip
    machine.call("rank", columns=columns, starts=starts, period=period, key=key, count=count, first=first)
    return period, key, begin, length, count, first
