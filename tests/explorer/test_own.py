"""A reset law or a map of one's own in the explorer: compiled for the browser, or computed by the server, as Python."""

import http.client
import json
import re
import shlex
import struct
import threading
from contextlib import contextmanager

import numpy as np
import pytest

import grazing as gz
from grazing.cli.app import main
from grazing.config.own import Named, own_object
from grazing.explorer import own
from grazing.explorer.build import shipped
from grazing.explorer.calls import CALLS, LARGEST_CALL, Calls
from grazing.explorer.oscillator import oscillator_module
from grazing.explorer.server import server
from grazing.explorer.webassembly import linker
from grazing.kernel.content import below, digest
from grazing.kernel.export import borrowed_by
from grazing.outcome import InputError, UserCodeError
from grazing.studies.basins import basins
from grazing.studies.chart import chart
from grazing.studies.classify import TOLERANCE
from grazing.studies.density import density
from tests.explorer.browser import NEEDS_AXE, Shown
from tests.explorer.machine import KINDS, Module, classes, draw, fields_of, orbits, raster, whole
from tests.explorer.test_kernels import followed

TEXT = """
import math

import grazing as gz


def soft(v, p):
    return -p.r * v / (1.0 - p.c * v) + p.kick


model = gz.Oscillator(
    0.3, 1.0, gz.Forcing(2.2, offset=0.12), gz.reset(soft, r=0.8, c=0.5, kick=0.2), sigma=-0.1
)
built_in = gz.Oscillator(0.3, 1.0, gz.Forcing(2.2, offset=0.12), gz.newton(0.7))
four = gz.Oscillator(0.3, 1.0, gz.Forcing(2.2, cos=(1.0, 0.0, 0.0, 0.2)), gz.newton(0.7))
damped = gz.Oscillator(-0.3, 1.0, gz.Forcing(2.2), gz.newton(0.7))
two = gz.Oscillator(
    0.3, 1.0, gz.Forcing(2.2), walls=[gz.wall(-1.0, gz.newton(0.7)), gz.wall(1.0, gz.newton(0.7), side="above")]
)
some_map = gz.gap_map(0.8, 0.1, 0.05)


def summed(v, p):
    return math.fsum((-p.r * v,))


broken = gz.Oscillator(0.3, 1.0, gz.Forcing(2.2), gz.reset(summed, r=0.8))


def left(state, p):
    return (p.a * state[0] + p.mu,)


def right(state, p, root):
    return (p.mu - p.b * root,)


def border(state, p):
    return state[0] / 1000.0


# a map by pieces in large units, with two attractors for some parameters
large = gz.Map(
    pieces={"L": left, "R": right}, border=border, params={"mu": 66.0, "a": 0.45, "b": 1000.0},
    coordinates=("q",), box=((-1000.0, 500.0),),
)


def henon(state, p):
    x, y = state
    return 1.0 - p.a * x * x + y, p.b * x


plane = gz.Map(
    henon, params={"a": 1.2, "b": 0.3}, coordinates=("x", "y"), box=((-1.0, 1.0), (-0.4, 0.4)), escape=100.0
)


def deep(state, p):
    return (p.a + 0.1 * state[0], state[0], state[1])


space = gz.Map(deep, params={"a": 1.0}, coordinates=("x", "y", "z"), box=((0.0, 1.0),) * 3)
bare = gz.Map(lambda state, p: (0.5 * state[0],))
vast = gz.Map(lambda state, p: (0.5 * state[0],), params={"a": 1e308})


def growing(state, p):
    return (state[0] * math.exp(p.r * (1.0 - state[0])),)


ricker = gz.Map(growing, params={"r": 2.2}, box=((0.1, 2.0),))
"""


#: Who computes: a module takes long to compile.
WAYS = [
    "server",
    pytest.param(
        "module", marks=[pytest.mark.long, pytest.mark.skipif(linker() is None, reason="no WebAssembly linker")]
    ),
]


def called(described, name, given):
    """A call of a kernel as the page sends it."""
    arrays = [each for each in described[name]["arguments"] if each["shape"]]
    numbers = {key: value for key, value in given.items() if not isinstance(value, np.ndarray)}
    names = [each["name"] for each in arrays if each["name"] in given]
    head = json.dumps({"name": name, "numbers": numbers, "given": names, "wanted": names}).encode()
    return b"".join([struct.pack("<I", len(head)), head, *(given[key].tobytes() for key in names)])


class Caller:
    """A module whose functions the server computes."""

    def __init__(self, calls, described):
        self.calls, self.functions = calls, {each["name"]: each for each in described["functions"]}

    def call(self, name, **given):
        answer = self.calls(called(self.functions, name, given))
        at = 8
        for argument in self.functions[name]["arguments"]:
            if argument["shape"]:
                value = given[argument["name"]]
                assert value.shape == tuple(whole(size, given) for size in argument["shape"])
                found = np.frombuffer(answer[at : at + value.nbytes], KINDS[argument["kind"]])
                value[...], at = found.reshape(value.shape), at + value.nbytes
        assert at == len(answer)
        return int(struct.unpack_from("<d", answer)[0])


@pytest.fixture(scope="session")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("own") / "rig.py"
    path.write_text(TEXT)
    return path


@pytest.fixture(scope="session")
def model(file):
    return own_object(Named(f"{file}:model"), "model")


@pytest.fixture(scope="session")
def told(model):
    """What the page is told of the module."""
    return own.described_module("oscillator", oscillator_module(model.reset))


@pytest.fixture(scope="session")
def caller(model, told):
    return Caller(Calls(oscillator_module(model.reset).entries, "the law"), told)


@pytest.fixture(scope="session", params=WAYS)
def machine(request, file, model, told):
    if request.param == "server":
        return request.getfixturevalue("caller")
    named = Named(f"{file}:model")
    return Module(own.module_of(named, own.brought(named), True, print), told)


def rows_of(told, model, name, values, **more):
    """Rows of the module for the model, of which one parameter takes values."""
    fields, rows = fields_of(told), np.zeros((len(values), len(told["fields"])))
    for i, value in enumerate(values):
        params = {own.field_of(key) if key in model.reset.params else key: number for key, number in
                  model.replace(**{name: value}).params.items()}  # fmt: skip
        for key, number in {**params, "law": 3.0, **more}.items():
            rows[i, fields.index(key)] = number
    return rows


# ---- the same numbers as in Python


@pytest.mark.parametrize("name", ["c", "offset"])
def test_a_diagram_is_that_of_python(machine, told, model, name):
    values = np.linspace(0.05, 0.6, 7)
    rows = rows_of(told, model, name, values)
    want = density(gz.stroboscopic_map(model), name, values, bins=90, starts=5, transient=20, keep=30, seed=3,
                   arithmetic="strict")  # fmt: skip
    lanes = draw(machine, 2, rows, values, 5, 3)
    low, high = want["u"].attrs["low"], want["u"].attrs["high"]
    counts, ended, ambiguous = raster(machine, rows, lanes, 20, 30, 0, low, high, 90)
    assert not ambiguous.any()
    np.testing.assert_array_equal(counts[:, 1:-2], want["count"].values)
    np.testing.assert_array_equal(ended, want["ended"].values)


def test_orbits_and_starts_are_those_of_python(machine, told, model):
    row, P = rows_of(told, model, "c", [0.5]), gz.stroboscopic_map(model)
    boxes = np.empty((1, 2, 2))
    machine.call("boxes", columns=1, rows=row.copy(), boxes=boxes)
    assert boxes[0].tolist() == [list(pair) for pair in P.box]
    lanes = draw(machine, 2, row, [0.5], 3, 1)
    points, letters, outcomes = orbits(machine, row, lanes, 2, 7)
    want = followed(P, lanes[0], 9)
    np.testing.assert_array_equal(points[0], want[0][2:])
    np.testing.assert_array_equal(letters[0], want[1][2:])
    np.testing.assert_array_equal(outcomes[0, 0], want[2])


def test_a_chart_is_that_of_python(machine, told, model):
    values, kicks = np.linspace(0.1, 0.6, 3), [0.1, 0.3]
    want = chart(gz.stroboscopic_map(model), {"c": values, "kick": kicks}, starts=4, transient=100, keep=64, seed=7,
                 arithmetic="strict")  # fmt: skip
    cells = np.array([(c, kick) for c in values for kick in kicks])
    rows = np.concatenate([rows_of(told, model.replace(kick=kick), "c", [c]) for c, kick in cells])
    lanes = draw(machine, 2, rows, cells, 4, 7)
    points, letters, outcomes = orbits(machine, rows, lanes, 100, 64)
    period, _key, _begin, _length, count, first = classes(machine, rows, points, letters, outcomes, TOLERANCE)
    ranked = np.where(count > 0, np.take_along_axis(period, first, 1), -3)
    wanted = want["period"].values.reshape(ranked.shape)
    np.testing.assert_array_equal(np.where(ranked == -1, wanted, ranked), wanted)
    assert (wanted[:, 0] > 0).any()


def test_basins_are_those_of_python(machine, told, model):
    P = gz.stroboscopic_map(model)
    grid = {"u": np.linspace(*P.box[0], 4), "v": np.linspace(*P.box[1], 5)}
    want = basins(P, grid, transient=300, arithmetic="strict", preimages=0)
    states = np.array([(u, v) for u in grid["u"] for v in grid["v"]])
    row = rows_of(told, model, "c", [0.5])
    points, letters, outcomes = orbits(machine, row, np.ascontiguousarray(states.T[None]), 300, 64)
    period, *_rest = classes(machine, row, points, letters, outcomes, TOLERANCE)
    np.testing.assert_array_equal(period[0], want["period"].values[want["basin"].values.ravel()])


def test_between_two_walls_each_has_the_law(machine, told, model):
    walls = [gz.wall(-0.4, model.reset), gz.wall(0.6, model.reset.replace(c=0.1, kick=0.0), side="above")]
    force = gz.Forcing(2.2, offset=0.12, cos=(1.0, 0.0, 0.0), sin=(0.0, 0.0, 0.0))
    rattle = gz.Oscillator(0.3, 1.0, forcing=force, walls=walls)
    P = gz.stroboscopic_map(rattle)
    above = {"two": 1.0, "sigma_B": 0.6, "r_B": 0.8, "B.c": 0.1, "B.kick": 0.0}
    row = rows_of(told, model.replace(sigma=-0.4), "c", [0.5], **above)
    boxes = np.empty((1, 2, 2))
    machine.call("boxes", columns=1, rows=row.copy(), boxes=boxes)
    assert boxes[0].tolist() == [list(pair) for pair in P.box]
    lanes = draw(machine, 2, row, [0.5], 3, 1)
    points, letters, outcomes = orbits(machine, row, lanes, 0, 6)
    want = followed(P, lanes[0], 6)
    np.testing.assert_array_equal(points[0], want[0])
    np.testing.assert_array_equal(letters[0], want[1])
    np.testing.assert_array_equal(outcomes[0, 0], want[2])


# ---- maps


@pytest.fixture(scope="session", params=["large", "plane"])
def mapped(request, file):
    """A map by its name, what the page is told of its module, and the map."""
    named = Named(f"{file}:{request.param}")
    found = own.brought(named)
    return named, found, own.described_module(found.name, found.module), own_object(named, "model")


@pytest.fixture(scope="session")
def map_calls(mapped):
    return Calls(mapped[1].module.entries, mapped[1].who)


@pytest.fixture(scope="session", params=WAYS)
def map_machine(request, mapped):
    named, found, told, _P = mapped
    if request.param == "server":
        return Caller(request.getfixturevalue("map_calls"), told)
    return Module(own.module_of(named, found, True, print), told)


def map_rows(P, name, values):
    return np.array([list(P.replace(**{name: value}).params.values()) for value in values])


def test_diagram_chart_and_basins_of_a_map_are_those_of_python(map_machine, mapped):
    P, names = mapped[3], list(mapped[3].params)
    centre = P.params[names[0]]
    values, others = np.linspace(0.6 * centre, 1.4 * centre, 9), P.params[names[1]] * np.array([0.7, 1.0])
    for i, coordinate in enumerate(P.coordinates):
        want = density(P, names[0], values, bins=90, coordinate=coordinate, starts=5, transient=20, keep=30, seed=3,
                       arithmetic="strict")  # fmt: skip
        rows = map_rows(P, names[0], values)
        ends = (want[coordinate].attrs[end] for end in ("low", "high"))
        counts, ended, _ambiguous = raster(
            map_machine, rows, draw(map_machine, P.dimension, rows, values, 5, 3), 20, 30, i, *ends, 90
        )
        np.testing.assert_array_equal(counts[:, 1:-2], want["count"].values)
        np.testing.assert_array_equal(ended, want["ended"].values)
    want = chart(P, {names[0]: values, names[1]: others}, starts=4, transient=200, keep=64, seed=7, arithmetic="strict")
    cells = np.array([(value, other) for value in values for other in others])
    rows = np.array([list(P.replace(**dict(zip(names, cell, strict=False))).params.values()) for cell in cells])
    made = orbits(map_machine, rows, draw(map_machine, P.dimension, rows, cells, 4, 7), 200, 64)
    period, _key, _begin, _length, count, first = classes(map_machine, rows, *made, TOLERANCE)
    ranked = np.where(count > 0, np.take_along_axis(period, first, 1), -3)[:, 0]
    np.testing.assert_array_equal(ranked, want["period"].values[..., 0].ravel())
    assert len({*ranked.tolist()}) > 1
    grid = {name: np.linspace(*ends, 6) for name, ends in zip(P.coordinates, P.box, strict=True)}
    want = basins(P, grid, transient=300, arithmetic="strict")
    states = np.stack(np.meshgrid(*grid.values(), indexing="ij"), -1).reshape(-1, P.dimension)
    row = map_rows(P, names[0], [centre])
    made = orbits(map_machine, row, np.ascontiguousarray(states.T[None]), 300, 64)
    np.testing.assert_array_equal(
        classes(map_machine, row, *made, TOLERANCE)[0][0], want["period"].values[want["basin"].values.ravel()]
    )


# ---- what the page shows, and what it does not


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("four", "four has 4 harmonics; the explorer shows"),
        ("damped", "damped has negative damping; the explorer shows"),
        ("two", "two is a gz.Walled; the explorer shows a gz.Oscillator above one wall"),
        ("some_map", "the map some_map is one of the library, which its own views show"),
        ("space", "the map space has 3 coordinates; the explorer shows a gz.Map of your own, of one or two"),
        ("bare", "the map bare has no parameters; the explorer shows"),
        ("vast", "the map vast has a parameter too large or too small for a slider; the explorer shows"),
        ("none", "has no name 'none'; it has"),
    ],
)
def test_what_the_page_cannot_show_is_said(file, tmp_path, name, said):
    with pytest.raises(InputError) as refused:
        own.prepared(f"{file}:{name}", tmp_path, False, print)
    assert said in str(refused.value) and not list(tmp_path.iterdir())


@pytest.mark.parametrize("given", ["pinball", "", "rig.py", "rig.py:"])
def test_what_is_no_name_of_a_model_is_said_as_it_was_given(given, capsys):
    assert main(["explore", "--model", given, "--no-open"]) == 2
    assert f"'{given}'" in capsys.readouterr().err


def test_a_law_that_does_not_compile_is_said(file):
    law = own_object(Named(f"{file}:broken"), "model").reset
    entries = [entry for entry in oscillator_module(law).entries if entry.name == "zero_time"]
    with pytest.raises(UserCodeError, match=r"the reset law summed does not compile: .*fsum.*rig\.py"):
        Calls(entries, "the reset law summed")


@pytest.fixture
def compiler(monkeypatch, tmp_path):
    """Stands for that of a machine with a linker; what it makes, and what it says, are to be set."""
    made = {"answer": (b"\0asm", ""), "asked": 0}

    def compiled_apart(_text):
        made["asked"] += 1
        return made["answer"]

    home = tmp_path / "kept"
    home.mkdir()
    monkeypatch.setattr(own, "linker", lambda: ["wasm-ld"])
    monkeypatch.setattr(own, "toolchain", dict)
    monkeypatch.setattr(own, "folders", lambda: (home, None))
    monkeypatch.setattr(own, "compiled_apart", compiled_apart)
    return made


def test_a_module_is_kept_and_one_that_was_damaged_compiled_anew(file, compiler, tmp_path):
    named = Named(f"{file}:ricker")
    for _ in range(2):
        assert own.module_of(named, own.brought(named), False, print) == b"\0asm" and compiler["asked"] == 1
    (kept,) = (tmp_path / "kept").iterdir()
    kept.write_bytes(kept.read_bytes().replace(b"\0asm", b"\0bad"))
    with pytest.warns(RuntimeWarning, match="it is damaged"):
        assert own.module_of(named, own.brought(named), False, print) == b"\0asm"
    assert compiler["asked"] == 2


def test_a_file_that_changes_while_it_is_compiled_is_said_and_nothing_is_kept(compiler, tmp_path, monkeypatch):
    """The process that compiles reads it a moment later: the module of another map was kept for this one."""
    file = tmp_path / "map.py"
    file.write_text(TEXT)
    named = Named(f"{file}:ricker")
    found, compile_it = own.brought(named), own.compiled_apart

    def edited(text):
        file.write_text(TEXT.replace("math.exp(p.r", "math.exp(2.0 * p.r"))
        return compile_it(text)

    monkeypatch.setattr(own, "compiled_apart", edited)
    with pytest.raises(InputError, match=r"map\.py has changed while the step of growing was compiled; start again"):
        own.module_of(named, found, False, print)
    monkeypatch.setattr(own, "compiled_apart", compile_it)
    file.write_text(TEXT)
    own.module_of(named, own.brought(named), False, print)
    assert compiler["asked"] == 2


def test_what_a_module_has_not_to_the_last_digit_is_computed_by_the_server(file, compiler):
    named, said = Named(f"{file}:ricker"), []
    compiler["answer"] = b"\0asm", "the step of growing takes exp of the library of this machine"
    assert own.module_of(named, own.brought(named), False, said.append) is None
    assert "takes exp of the library" in said[-1] and "the server computes" in said[-1]
    assert own.module_of(named, own.brought(named), True, said.append) == b"\0asm" and "last digit" in said[-1]
    compiler["answer"] = None, "sin: a module that imports nothing cannot have that"
    named = Named(f"{file}:large")
    assert own.module_of(named, own.brought(named), False, said.append) is None
    with pytest.raises(InputError, match="could not be compiled for the browser: sin"):
        own.module_of(named, own.brought(named), True, said.append)


def test_functions_of_the_library_are_seen_in_code():
    text = "%a = call double @llvm.exp.f64(x)\n@tan(y) @llvm.fabs.f64(z) @numba_gamma(w) @floor(x) @own_log1p(x)"
    assert borrowed_by(text) == {"exp", "tan", "gamma"}


def test_a_law_of_the_package_needs_no_compiler(file, tmp_path, monkeypatch):
    monkeypatch.setattr(own, "linker", lambda: None)
    assert own.prepared(f"{file}:built_in", tmp_path, True, pytest.fail) is None
    known = json.loads((tmp_path / "kernels.json").read_text(encoding="utf-8"))
    assert known["modules"] == shipped()["modules"] and known["model"]["own"] == []


def test_a_copy_without_a_linker_says_what_to_install(file, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(own, "linker", lambda: None)
    monkeypatch.setattr("grazing.explorer.build.linker", lambda: None)
    assert main(["explore", "--model", f"{file}:model", "--out", str(tmp_path / "page.html")]) == 2
    assert "no WebAssembly linker: install lld" in capsys.readouterr().err and not list(tmp_path.iterdir())


def held(function):
    """All that kernels below one hold in their closures."""
    for cell in function.__closure__ or ():
        yield cell.cell_contents
    for each in below(function):
        yield from held(each)


def test_a_law_that_was_compiled_before_is_known_again(file):
    """What it is kept under is the same for the same text, and no kernel holds a compiled one: that is never kept."""
    for entry in own.brought(Named(f"{file}:model")).module.entries:
        assert not any(hasattr(each, "py_func") for each in held(entry.kernel)), entry.name
    kept = [[digest(entry.kernel) for entry in own.brought(Named(f"{file}:model")).module.entries] for _ in range(2)]
    assert kept[0] == kept[1]


# ---- nothing but calls of kernels is answered


@pytest.fixture
def asked():
    """Send a POST to a server that computes, by what stands for kernels."""
    with server(0, None, lambda body: body[::-1]) as ours:
        thread = threading.Thread(target=ours.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()

        def ask(body=b"abc", path=CALLS, **headers):
            line = http.client.HTTPConnection("127.0.0.1", ours.server_address[1], timeout=10)
            line.request("POST", path, body, {"Content-Type": "application/octet-stream", **headers})
            answer = line.getresponse()
            found = answer.status, answer.read()
            line.close()
            return found

        ask.address = ours.address.removesuffix("/page/")
        yield ask
        ours.shutdown()
        thread.join()


def test_a_call_of_the_page_is_answered(asked):
    assert asked() == (200, b"cba") == asked(Origin=asked.address)


@pytest.mark.parametrize(
    ("status", "given"),
    [
        (403, {"Origin": "http://example.org"}),
        (403, {"Origin": "null"}),
        (403, {"Origin": "http://127.0.0.1:1"}),
        (403, {"Host": "example.org"}),
        (403, {"Host": "example.org", "Origin": "http://example.org"}),
        (404, {"path": "/page/"}),
        (415, {"Content-Type": "text/plain"}),
        (415, {"Content-Type": "application/x-www-form-urlencoded"}),
        (411, {"Content-Length": "-1"}),
        (411, {"Content-Length": "x"}),
        (413, {"Content-Length": str(LARGEST_CALL + 1)}),
    ],
)
def test_who_else_asks_is_refused(asked, status, given):
    found, body = asked(**given)
    assert found == status and b"cba" not in body


def draws(told, **changed):
    """A call that draws starts, with something changed in its head."""
    given = {"columns": 1, "starts": 2, "axes": 1, "seed": 1, "names": np.zeros((1, 1)), "boxes": np.ones((1, 2, 2))}
    body = called({each["name"]: each for each in told["functions"]}, "draw", given)
    (size,) = struct.unpack_from("<I", body)
    head = json.loads(body[4 : 4 + size])
    head["numbers"] |= changed.pop("numbers", {})
    text = json.dumps(head | changed).encode()
    return struct.pack("<I", len(text)) + text + body[4 + size :]


def test_what_is_no_call_is_refused_in_words(caller, told):
    calls = caller.calls
    good = draws(told)
    assert len(calls(good)) == 8 + 8 + 32
    wrong = [
        b"", b"\0", b"\xff\xff\xff\xff", struct.pack("<I", 4) + b"null", struct.pack("<I", 9) + b"[" * 9,
        struct.pack("<I", 10**5) + b"[" * 10**5, good[:-1], good + b"\0", draws(told, name="__init__"),
        draws(told, name=["draw"]), draws(told, given=3), draws(told, wanted=3), draws(told, numbers={"columns": -1}),
        draws(told, numbers={"columns": 0}), draws(told, numbers={"columns": 2**40}),
        draws(told, numbers={"columns": 1.5}), draws(told, numbers={"columns": "1e9"}),
        draws(told, numbers={"starts": 2**30}), draws(told, numbers={"seed": [1]}),
        draws(told, numbers={"axes": 1e400}),
    ]  # fmt: skip
    for body in wrong:
        with pytest.raises(InputError, match="this is no call of a kernel"):
            calls(body)


def test_a_long_head_of_a_call_is_not_read():
    """64 MiB of empty lists took 1.7 GB."""
    with pytest.raises(InputError, match="its head has 300001 bytes"):
        Calls([], "nobody")(struct.pack("<I", 300_001) + b"[" + b"[]," * 10**5)


def test_numbers_that_would_lead_out_of_arrays_are_refused(caller, told, model):
    row = rows_of(told, model, "c", [0.5])
    lanes, state = np.zeros((1, 2, 1)), np.zeros(8)
    sizes = {"columns": 1, "starts": 1, "keep": 2}
    counts, few = {"counts": np.zeros((1, 7), np.int32)}, np.zeros((1, 1), np.int32)
    density_ = {"columns": 1, "starts": 1, "rows": row, "lanes": lanes, "transient": 0, "keep": 1, "coordinate": 0,
                "low": 0.0, "high": 1.0, "bins": 4, **counts, "ended": few[0], "ambiguous": few[0]}  # fmt: skip
    legs = {"capacity": 4, "row": row[0], "state": state, "legs": np.zeros((4, 11)), "until": 1.0, "patience": 0.1}
    labels = {**sizes, "points": np.zeros((1, 2, 2, 1)), "period": few + 1, "key": few.astype(np.int64), "begin": few,
              "length": few + 1, "same": np.zeros(2), "label": few}  # fmt: skip
    heights = {"count": 1, "row": row[0], "which": 0, "values": np.zeros(1), "heights": np.zeros(1)}
    grazes = {"row": row[0], "which": 4, "low": -float("inf"), "high": float("inf"), "open_low": 0}
    nan = float("nan")
    for name, given, changes in [
        ("density", density_, [{"coordinate": 2}, {"coordinate": -1}, {"high": 0.0}, {"high": float("nan")},
                               {"low": -float("inf")}, {"high": 5e-324}, {"rows": row + np.inf}]),
        ("legs", legs, [{"state": state + 9.0}, {"state": state - 1.0}, {"state": state * np.nan}]),
        ("attractors", labels, [{"period": few + 3}, {"length": few}]),
        ("clearance", heights, [{"which": -1}, {"which": row.size}]),
        ("graze", grazes, [{"low": nan}, {"high": nan}]),  # the search went on for ever
    ]:  # fmt: skip
        caller.call(name, **{key: np.copy(value) if isinstance(value, np.ndarray) else value for key, value in
                             given.items()})  # fmt: skip
        for changed in changes:
            with pytest.raises(InputError, match="this is no call of a kernel"):
                caller.calls(called(caller.functions, name, given | changed))


# ---- in a browser


@pytest.fixture
def kept():
    return True


@contextmanager
def opened(said, folder, known):
    """The page with what is named, for which the server computes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(own, "linker", lambda: None)
        patch.setattr(own, "Calls", lambda *_given: known)
        calls = own.prepared(said, folder, False, lambda _text: None)
    with server(0, folder, calls) as ours:
        thread = threading.Thread(target=ours.serve_forever, kwargs={"poll_interval": 0.05})
        thread.start()
        yield ours.address
        ours.shutdown()
        thread.join()


@pytest.fixture(scope="session")
def rig(file, tmp_path_factory, caller):
    with opened(f"{file}:model", tmp_path_factory.mktemp("served"), caller.calls) as address:
        yield address


@pytest.fixture(scope="session")
def map_page(mapped, tmp_path_factory, map_calls):
    with opened(str(mapped[0]), tmp_path_factory.mktemp("mapped"), map_calls) as address:
        yield address


SMALL = "columns=20&bins=40&flow_starts=2&flow_transient=40&flow_keep=30"
LAW = "version=2&law=soft&omega=2.2&alpha=0.3&sigma=-0.1&offset=0.12&r=0.8&A.c=0.5&A.kick=0.2"


@pytest.mark.parametrize(
    "given",
    [
        "vary=A.c&reach=0:1&phase=0.4&t0=0.1",
        "vary=B.c&reach=0:1&two=yes&sigma_B=0.7&r_B=0.6&B.c=0.2&B.kick=0.1",
        "vary=A.kick&reach=0:0.5&cos_A=0.1&sin_A=0.05",
    ],
)
def test_a_diagram_on_the_page_is_that_of_the_program_it_gives(shown, rig, file, given):
    shown.open(f"{rig}#{LAW}&view=oscillator&{given}&columns=40&bins=60&flow_starts=3&flow_transient=40&flow_keep=30")
    known, texts = {}, shown.page.evaluate("() => explorer.texts()")
    exec(texts["python"].replace("gz.plot.save", "(lambda *_: None)"), known)
    np.testing.assert_array_equal(shown.raster("oscillator")[1][:, 1:-2], known["result"]["count"])
    # a command takes the oscillator of the file, which has one wall
    assert (f"--model {file}:model" in texts["command"]) == ("phase" in given)
    assert texts["command"].startswith("grazing density c=0" if "phase" in given else "# a command has the oscillator")
    assert shown.problem() == ""


def test_basins_on_the_page_are_those_of_the_program_it_gives(shown, rig):
    shown.open(f"{rig}#{LAW}&view=chart&chart=basins&positions=-0.1:2&velocities=-1.5:1.5&chart_columns=8&chart_rows=6")
    known, seen = {}, "explorer.views.chart"
    exec(shown.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), known)
    found = shown.page.evaluate(f"() => [...{seen}.codes].map(code => {seen}.reached[code].period)")
    want = known["result"]["period"].values[known["result"]["basin"].values].T
    np.testing.assert_array_equal(np.reshape(found, want.shape), want)
    assert len(np.unique(want)) > 1


def test_the_page_opens_on_the_model(shown, rig):
    shown.page.goto(rig)
    shown.until("() => document.getElementById('headline').innerText.includes('with the law soft')")
    assert "your law’s c" in shown.page.inner_text(".lead")
    link = shown.page.evaluate("() => explorer.link()")
    assert "law=soft" in link and link.endswith("&A.c=0.5&A.kick=0.2")  # whatever the file says when it is opened


def test_a_slider_of_the_law_is_moved(shown, rig):
    shown.open(f"{rig}#{LAW}&view=ball&{SMALL}")
    before = shown.pixels("phase")
    shown.page.focus("input[type=range][aria-label^='A.c']")
    for _ in range(3):
        shown.page.keyboard.press("ArrowRight")
    shown.until("() => location.hash.includes('A.c=0.503')")
    shown.settle()
    shown.until("() => !explorer.views.ball.search.waiting")
    assert shown.pixels("phase") != before
    said = shown.page.inner_text("#summary")
    assert re.search(r"a wall with the law soft of rig.py, r = 0.8, c = 0.503, kick = 0.2", said)


def test_a_link_of_a_law_that_the_page_does_not_have_says_so(shown, address):
    shown.open(f"{address}#version=2&view=ball&law=soft&A.c=0.5&columns=20")
    assert "soft" in shown.problem() and "grazing explore --model" in shown.problem()


FEW = "columns=40&bins=60&starts=3&transient=40&keep=30&chart_columns=8&chart_rows=6"


def hands_on(shown, P):
    """Zoom the diagram, drag the line and the start by the mouse, go back by a double click; leave all as it was."""
    page, before = shown.page, shown.page.evaluate("() => explorer.state()")
    name, (low, high) = before["vary"], before["reach"]
    box = page.locator("#gap-diagram").bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.4 * box["height"])
    page.mouse.wheel(0, -300)
    shown.until(f"() => {{ const [a, b] = explorer.state().reach; return b - a < {0.9 * (high - low)}; }}")
    assert page.evaluate("() => explorer.state().window") is None  # the height follows the orbits
    shown.settle()
    page.wait_for_timeout(200)
    page.mouse.dblclick(box["x"] + 0.3 * box["width"], box["y"] + 0.4 * box["height"])
    shown.until(f"() => explorer.state().reach[0] === {low} && explorer.state()[{name!r}] === {before[name]}")
    shown.settle()
    x = box["x"] + page.evaluate(f"() => explorer.views.map.diagram.axes.x(explorer.state()[{name!r}])")
    page.mouse.move(x, box["y"] + 0.4 * box["height"])
    page.mouse.down()
    page.mouse.move(x + 20, box["y"] + 0.4 * box["height"])
    page.mouse.up()
    shown.until(f"() => explorer.state()[{name!r}] > {before[name]}")
    shown.until("() => !explorer.views.map.search.waiting")  # the axes of the cobweb follow the orbits that are found
    shown.settle()
    picture, web = shown.pixels("cobweb"), page.locator("#cobweb").bounding_box()
    page.mouse.move(web["x"] + 0.55 * web["width"], web["y"] + 0.4 * web["height"])
    page.mouse.down()
    shown.settle()
    at = page.evaluate(  # on the axes as they are before the start moves on, which they may follow
        "([x, y]) => { const a = explorer.views.map.cobweb.axes; return [a.atX(x), a.atY(y)]; }",
        [0.6 * web["width"], 0.3 * web["height"]],
    )
    page.mouse.move(web["x"] + 0.6 * web["width"], web["y"] + 0.3 * web["height"])
    start = page.evaluate("() => [explorer.state().x0, explorer.state().y0]")
    page.mouse.up()
    sizes = [np.ptp(ends) for ends in P.box]
    assert all(abs(a - b) < 0.02 * size for a, b, size in zip(start, at, sizes, strict=False))
    assert shown.pixels("cobweb") != picture
    # of a graph that is too steep to be joined single places are seen
    black = """() => {
      const { cobweb } = explorer.views.map, { axes } = cobweb, web = cobweb.view.web(), given = cobweb.view.web;
      const at = [0.02, 0.3].map((part, i) => web.ends[i][0] + part * (web.ends[i][1] - web.ends[i][0]));
      const ink = () => axes.context.getImageData(axes.ratio * axes.x(at[0]), axes.ratio * axes.y(at[1]), 1, 1).data[0];
      const seen = [[], [[at]]].map(graph => {
        cobweb.view.web = () => ({ ...web, graph });
        cobweb.draw();
        return ink();
      });
      cobweb.view.web = given;
      return seen;
    }"""
    without, with_it = page.evaluate(black)
    assert P.dimension > 1 or with_it < without
    back = {key: before[key] for key in ("x0", "y0", name)} | {"web": 0}
    page.evaluate("back => explorer.views.map.cobweb.change(back)", back)
    shown.settle()


def test_the_views_of_a_map_are_those_of_the_programs_they_give(shown, map_page, mapped, tmp_path, capsys):
    P, page = mapped[3], shown.page
    shown.open(f"{map_page}#version=2&view=map&coordinate={P.coordinates[-1]}&{FEW}")
    assert page.eval_on_selector_all("nav button:not([hidden])", "all => all.map(each => each.innerText)") == [
        "Map",
        "Charts",
    ]
    texts = []

    def program():
        known = {}
        texts.append(page.evaluate("() => explorer.texts()"))
        exec(texts[-1]["python"].replace("gz.plot.save", "(lambda *_: None)"), known)
        return known["result"]

    np.testing.assert_array_equal(shown.raster("map")[1][:, 1:-2], program()["count"])
    assert all(f"map.{name}={value:g}" in shown.link() for name, value in P.params.items())
    hands_on(shown, P)
    page.click("#web-many")
    shown.until("() => document.getElementById('summary').innerText.includes('after 10 steps')")
    after = P.iterate([sum(ends) / 2 for ends in P.box], 10)[-1]
    said = page.inner_text("#summary").replace("−", "-").split("after 10 steps")[1]
    numbers = re.findall(r"-?\d+(?:\.\d+)?", said.split("=")[1])[: P.dimension]
    np.testing.assert_allclose([float(number) for number in numbers], after, 1e-5)
    page.click("[data-view=chart]")
    shown.settle()
    want = program()["period"].values[..., 0]
    found = page.evaluate("() => [...explorer.views.chart.codes]")
    np.testing.assert_array_equal(np.reshape(found, want.T.shape).T, np.maximum(want, 0))
    page.select_option("select:has(option[value=map-basins])", "map-basins")
    shown.settle()
    result = program()
    want = result["period"].values[result["basin"].values].T
    found = page.evaluate(
        "() => [...explorer.views.chart.codes].map(code => explorer.views.chart.reached[code].period)"
    )
    np.testing.assert_array_equal(np.reshape(found, want.shape), want)
    for text, name in zip(texts, ("count", "period", "basin"), strict=True):
        to = tmp_path / f"{name}.nc"
        words = shlex.split(re.sub(r"-o \S+$", f"-o {shlex.quote(str(to))}", text["command"]))
        assert words[0] == "grazing" and main(words[1:]) == 0, capsys.readouterr().err
        assert name in gz.load(to)
    assert shown.problem() == ""


def violations(pages, links, scheme):
    """What axe finds of each link, in one page that goes from one to the next."""
    size = {"width": 1280, "height": 720}
    with pages(True, viewport=size, color_scheme=scheme, reduced_motion="reduce") as page:
        for link in links:
            page.open(link)
            yield link, page.violations()


@NEEDS_AXE
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_reports_no_violation_of_a_map(pages, map_page, scheme):
    views = ("map&web=5", "chart&chart=map", "chart&chart=map-basins")
    for link, found in violations(pages, [f"{map_page}#version=2&view={view}&{FEW}" for view in views], scheme):
        assert found == [], link


@NEEDS_AXE
def test_axe_reports_no_violation_of_a_law(pages, rig):
    views = ("oscillator", "strobe", "chart&chart=oscillator&chart_columns=4&chart_rows=3")
    for link, found in violations(pages, [f"{rig}#{LAW}&view={view}&{SMALL}" for view in views], "dark"):
        assert found == [], link


def test_a_link_of_a_map_that_the_page_does_not_have_says_so(shown, address):
    shown.open(f"{address}#version=2&view=map&map.a=0.5&columns=20")
    assert shown.problem().count("a map of one’s own is shown by the page of “grazing explore --model”") == 2


def test_when_the_server_has_ended_the_page_says_what_to_do(browser, rig):
    context = browser.new_context(reduced_motion="reduce")
    page = Shown(context.new_page())
    page.open(f"{rig}#{LAW}&view=ball&{SMALL}")
    page.page.route("**/calls/*", lambda route: route.abort())
    page.page.fill("input[type=number][name=offset]", "0.2")
    page.until("() => document.getElementById('problem').innerText.includes('grazing explore')")
    context.close()
