"""Many oscillators in one kernel: the same bits in any company, every reset law, nothing compiled twice."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba.core import event

import grazing as gz
from grazing.kernel import elementary
from grazing.kernel.compile import _units as units_of
from grazing.kernel.content import digest
from grazing.maps import period
from grazing.maps.blocks import paced
from grazing.maps.ensemble import above_wall, ensemble
from grazing.maps.map import CHATTER_LETTER
from grazing.maps.stroboscopic import step_of
from grazing.maps.walled import between_walls
from grazing.orbits.contacts import PIECES, addresses
from grazing.oscillator import cells, contact, flight, taylor
from grazing.oscillator.certificate import certify
from grazing.oscillator.impacts import impacts_of
from grazing.oscillator.pointed import law_addresses, pointed_model
from grazing.oscillator.reset import active_law, difference_of, triggered_law
from grazing.oscillator.still import find_cycles
from grazing.outcome import BAD_LAW, CHATTER, FATAL, STUCK, TOO_MANY_IMPACTS
from grazing.parameter import parameter_tuple
from tests.models import cubic
from tests.processes import python
from tests.reference import Problem, advance, newton

SOURCE = str(Path(gz.__file__).parents[1])
ROOT = str(Path(__file__).parents[2])
WAYS = [("block", "fast"), ("block", "strict"), ("scalar", "fast"), ("scalar", "strict")]

#: One table: every damping, chatter, sticking, shifted walls, and a column that is left to the scalar routine.
CHANGES = (
    {}, {"d": 0.09}, {"alpha": 2.0, "sigma": 0.3}, {"alpha": 0.2, "k": 3.0, "V": 0.1, "d": 0.3},
    {"alpha": 0.0, "k": 0.0, "d": -0.5, "V": 0.2}, {"alpha": 1e-10, "k": 2.2, "r": 0.9, "V": 0.1}, {"k": 1e-8},
    {"alpha": 200.0}, {"V": 0.0, "r": 0.3, "d": -0.2}, {"V": 0.0, "r": 0.0}, {"V": 0.0}, {"omega": 0.7, "sin1": 0.4},
    {"t0": 0.3, "phase": 1.1, "d": -0.1}, {"d": 1.4},
)  # fmt: skip
P = gz.stroboscopic_map(gz.pinball())
ROWS = np.array([list({**P.params, **change}.values()) for change in CHANGES])
WALL = ROWS[:, list(P.params).index("sigma")][:, None]


def starts_of(n, seed=0):
    """Return n starts above the wall for each column."""
    random = np.random.default_rng(seed)
    shape = (len(ROWS), n)
    return np.stack([WALL + random.uniform(0.0, 0.3, shape), random.uniform(-0.5, 0.5, shape)], axis=1)


def flown(way, rows, starts, transient, keep, *, map=P, threads=1, records=1):
    """Return results and, after them, the last states."""
    lanes = np.ascontiguousarray(starts)
    lanes = lanes.copy() if lanes is starts else lanes
    found = map.run_columns(
        rows, lanes, transient, keep, records=records, algorithm=way[0], arithmetic=way[1], threads=threads
    )  # fmt: skip
    return (*found, lanes)


def same(one, two):
    return all(np.array_equal(a, b, equal_nan=a.dtype.kind == "f") for a, b in zip(one, two, strict=True))


def part(found, columns, starts):
    return [array[columns][..., starts] for array in found]


# ---- the same bits in any company


@pytest.mark.parametrize("way", WAYS)
def test_bits_depend_neither_on_neighbours_nor_on_threads(way):
    starts = starts_of(7)
    every = flown(way, ROWS, starts, 9, 8)
    assert same(flown(way, ROWS, starts, 9, 8, threads=2), every)
    order = np.random.default_rng(1).permutation(len(ROWS))
    shuffled = flown(way, ROWS[order], starts[order][..., ::-1], 9, 8)
    assert same(shuffled, part(every, order, slice(None, None, -1)))
    for q in range(len(ROWS)):
        one = slice(q, q + 1)
        assert same(flown(way, ROWS[one], starts[one], 9, 8), part(every, one, slice(None)))
        for i in (0, 6):
            alone = flown(way, ROWS[one], starts[one, :, i : i + 1], 9, 8)
            assert same(alone, part(every, one, slice(i, i + 1)))


@pytest.mark.parametrize("way", [("block", "fast"), ("block", "strict")])
@pytest.mark.parametrize("n", [8, 15, 16, 17, 63, 64, 170, 511, 512, 513, 1100])
def test_bits_do_not_depend_on_the_size_of_a_block(way, n):
    """Sizes about those of vectors, of blocks, and of what several columns share."""
    columns = slice(0, 5)
    few, many = starts_of(5, seed=2)[columns], starts_of(n, seed=3)[columns]
    alone = flown(way, ROWS[columns], few, 2, 3)
    for place in (0, n - 5):
        many[:, :, place : place + 5] = few
        for threads in (1, 2):
            crowd = flown(way, ROWS[columns], many, 2, 3, threads=threads)
            assert same(part(crowd, slice(None), slice(place, place + 5)), alone)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("way", [("block", "fast"), ("scalar", "strict")])
def test_bits_do_not_depend_on_how_many_blocks_are_a_tile(monkeypatch, way, threads):
    columns = np.tile(np.arange(len(ROWS)), 8)  # 56 blocks of two columns each, eight in a task
    starts = starts_of(170, seed=5)
    alone = part(flown(way, ROWS, starts, 2, 2), columns, slice(None))
    monkeypatch.setattr("grazing.maps.blocks.TASKS", 4)
    for blocks in (1, 3, 8):
        tiles = []
        monkeypatch.setattr(
            "grazing.maps.blocks.paced", lambda flown, _spent, paced=blocks, tiles=tiles: tiles.append(flown) or paced
        )
        assert same(flown(way, ROWS[columns], starts[columns], 2, 2, threads=threads), alone)
        assert set(tiles) == {1, blocks}


def test_tiles_grow_where_they_are_short_and_shrink_where_they_are_long():
    assert [paced(blocks, 0.001) for blocks in (1, 2, 4, 8)] == [2, 4, 8, 8]
    assert [paced(blocks, 0.3) for blocks in (1, 2, 4, 8)] == [1, 1, 2, 4]
    assert [paced(blocks, 0.08) for blocks in (1, 2, 4, 8)] == [1, 2, 4, 8]


@pytest.mark.parametrize("way", WAYS)
def test_bits_do_not_depend_on_where_a_long_run_is_cut(way):
    """A task takes 256 periods at a time; what is thrown away and what is kept go through the same numbers."""
    starts = starts_of(3)
    whole = flown(way, ROWS, starts, 0, 320)
    for transient in (300, 256, 255, 1):
        run = flown(way, ROWS, starts, transient, 320 - transient)
        assert same(run, [array[:, transient:] if i < 2 else array for i, array in enumerate(whole)])
    assert same(flown(way, ROWS, starts, 320, 0)[2:], whole[2:])


@pytest.mark.parametrize("way", WAYS)
def test_outcomes_are_kept_apart_or_together(way):
    starts = starts_of(4)
    apart, together = flown(way, ROWS, starts, 5, 30, records=30), flown(way, ROWS, starts, 5, 30)
    assert same([*apart[:2], *apart[3:]], [*together[:2], *together[3:]])
    assert np.array_equal(np.bitwise_or.reduce(apart[2], axis=1), together[2][:, 0])
    chattered = apart[2] & CHATTER != 0
    assert chattered[:, 1:].any() and not chattered.all()
    assert np.array_equal(chattered[:, 1:], (apart[1] == CHATTER_LETTER)[:, 1:])


def test_a_scalar_run_is_the_orbit_of_the_map():
    starts = starts_of(2)
    found = flown(("scalar", "strict"), ROWS, starts, 0, 12, records=12)
    for q, row in enumerate(ROWS):
        orbit = P.replace(**dict(zip(P.params, row.tolist(), strict=True))).orbit(starts[q, :, 1], 12)
        assert np.array_equal(orbit.points[1:], found[0][q, :, :, 1])
        assert np.array_equal(orbit.letters, found[1][q, :, 1])
        assert np.array_equal(orbit.outcomes, found[2][q, :, 1])
        assert (orbit.near_miss, orbit.slowest, orbit.undecided) == tuple(array[q, 1] for array in found[3:6])


def test_nothing_is_run_for_no_periods():
    starts = starts_of(3)
    for way in WAYS:
        found = flown(way, ROWS, starts, 0, 0)
        assert found[0].shape == (len(ROWS), 0, 2, 3)
        assert np.allclose(found[6], starts, rtol=1e-14, atol=1e-14)
        assert not found[2].any() and not found[5].any()


# ---- reset laws


def contracting(v, p):
    """Restitution that falls with the speed of impact, never above e."""
    return -p.e * v / (1.0 - p.c * v)


FORCING = gz.Forcing(omega=1.9, offset=-0.3)
LAWS = {
    "newton": gz.newton(r=0.7),
    "newton, dead stop": gz.newton(r=0.0),
    "active": gz.active(r=0.7, V=0.2),
    "triggered": gz.triggered(r=0.6, V=0.5, trigger=0.1),
    "triggered, high": gz.triggered(r=0.4, V=0.3, trigger=0.6),
    "own": gz.reset(cubic, e=0.9, c=0.5),
    "own, contracting": gz.reset(contracting, contraction=(0.6, 10.0), e=0.6, c=0.5),
}


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("d", [-0.3, 0.05])
def test_every_law_in_the_block_and_out_of_it(name, d):
    m = gz.Oscillator(0.7, 1.5, gz.Forcing(omega=1.9, offset=d), LAWS[name], sigma=0.1)
    Q = gz.stroboscopic_map(m)
    random = np.random.default_rng(5)
    starts = np.stack([0.1 + random.uniform(0.0, 0.5, (1, 40)), random.uniform(-0.8, 0.8, (1, 40))], axis=1)
    row = [list(Q.params.values())]
    block, scalar = (flown((way, "strict"), row, starts, 0, 3, map=Q, records=3) for way in ("block", "scalar"))
    assert np.array_equal(block[1], scalar[1])
    assert np.array_equal(block[2], scalar[2])
    speeds = np.minimum(scalar[4], 1.0)
    assert (np.abs(block[0] - scalar[0]).max(axis=(1, 2)) * speeds <= 1e-12).all()
    rests = (scalar[2] & STUCK).any(axis=-1).all()  # then every period is the scalar routine's
    assert rests or not np.array_equal(block[0], scalar[0])
    assert (scalar[1] != 0).any()
    chatters = d < 0.0 and name in ("newton", "triggered, high", "own, contracting")
    assert bool((scalar[2] & CHATTER).any()) or not chatters


NAN = float("nan")


def sometimes_nan(v, p):
    """No number for blows in a band of speeds."""
    return NAN if p.low < -v < p.high else -p.r * v


def sometimes_inwards(v, p):
    """Into the wall for blows in a band of speeds."""
    return p.r * v if p.low < -v < p.high else -p.r * v


@pytest.mark.parametrize("law", [sometimes_nan, sometimes_inwards])
@pytest.mark.parametrize("way", WAYS)
def test_a_bad_answer_of_a_law_ends_that_orbit_at_once(law, way):
    """Which orbits, and when, the reference says: those with a blow in the band, in the period of the first one."""
    low, high, n = 0.06, 0.08, 6
    forcing = gz.Forcing(omega=2.2, offset=0.12)
    Q = gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, forcing, gz.reset(law, r=0.8, low=low, high=high)))
    good = gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, forcing, gz.newton(r=0.8)))
    random = np.random.default_rng(6)
    starts = np.stack([random.uniform(0.0, 0.3, (1, 30)), random.uniform(-0.5, 0.5, (1, 30))], axis=1)
    words = rf"the reset law {law.__name__} returned (nan|-0.0\d+) for v_minus = -0.0[67]\d+; .* with outcome bad_law"
    with pytest.warns(RuntimeWarning, match=words):
        found = flown(way, [list(Q.params.values())], starts, 0, n, map=Q, records=n)
    right = flown(way, [list(good.params.values())], starts, 0, n, map=good, records=n)
    problem = Problem(3.0, 1.0, 2.2, offset=0.12, law=newton(0.8))
    ends = []
    for i in range(30):
        strobes = advance(problem, *starts[0, :, i], n)
        bad = [k for k, strobe in enumerate(strobes) if any(low < -float(x.v_minus) < high for x in strobe.impacts)]
        end = bad[0] if bad else n
        ends.append(end)
        assert (found[2][0, :, i] & BAD_LAW != 0).tolist() == [k >= end for k in range(n)]
        assert np.array_equal(found[0][0, :end, :, i], right[0][0, :end, :, i])
        assert np.isnan(found[0][0, end:, :, i]).all()
        assert np.isnan(found[6][0, :, i]).all() == (end < n)
    assert set(ends) >= {0, n} and len(set(ends)) > 2


def test_a_budget_of_impacts_ends_one_orbit_and_no_other():
    """An elastic ball under a steady push bounces without end; beside it others go on."""
    Q = gz.stroboscopic_map(gz.pinball(V=0.0, r=1.0, d=-5.0))
    starts = np.array([[[1e-9, 0.3], [0.0, 0.1]]])
    for way in WAYS:
        found = flown(way, [list(Q.params.values())], starts, 0, 1, map=Q)
        assert (found[2][0, 0] & TOO_MANY_IMPACTS != 0).tolist() == [True, False]
        assert np.isnan(found[0][0, 0, :, 0]).all() and np.isfinite(found[0][0, 0, :, 1]).all()


class Compiled:
    """The names of the functions that were compiled."""

    def __enter__(self):
        self.names = []
        self.listener = event.RecordingListener()
        event.register("numba:compile", self.listener)
        return self

    def __exit__(self, *_):
        event.unregister("numba:compile", self.listener)
        self.names = {record.data["dispatcher"].py_func.__name__ for _, record in self.listener.buffer}


@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
def test_a_new_law_compiles_the_law_and_nothing_else(arithmetic):
    starts = starts_of(3)[:1]
    flown(("block", arithmetic), ROWS[:1], starts, 0, 2)
    entry = ensemble(above_wall(1), 1, arithmetic)
    before = len(entry.overloads)
    shift = hashlib.sha256(os.urandom(8)).digest()[0] / 1e9  # a law that no cache has seen

    def unseen(v, p):
        return -p.r * v + shift

    Q = gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2, offset=0.1), gz.reset(unseen, r=0.8)))
    with Compiled() as seen:
        for algorithm in ("block", "scalar"):
            found = flown((algorithm, arithmetic), [list(Q.params.values())], starts, 0, 20, map=Q)
            assert found[1].any() and not (found[2] & FATAL).any()
    kinds = {name.split(f"_{arithmetic}_")[0] for name in seen.names}
    assert "unseen" in kinds and "run" not in kinds
    assert len(kinds) < 20  # the kernel is made of dozens
    assert ensemble(above_wall(1), 1, arithmetic) is entry and len(entry.overloads) == before == 1


def spelled(v, p):
    return -p.r * float(f"{v:g}")


@pytest.mark.parametrize("way", WAYS)
def test_a_law_that_does_not_compile_is_named_with_its_construct(way):
    Q = gz.stroboscopic_map(gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2), gz.reset(spelled, r=0.8)))
    words = r"the reset law spelled does not compile: .*(format|f-string|FORMAT|str).*Use arithmetic on floats"
    with pytest.raises(gz.UserCodeError, match=words):
        flown(way, [list(Q.params.values())], np.array([[[0.1], [0.0]]]), 0, 1, map=Q)
    with pytest.raises(gz.UserCodeError, match="the reset law spelled does not compile"):
        Q.orbit((0.1, 0.0), 1)


# ---- the cache of compiled kernels

DIGESTS = """
import sys
sys.path[:0] = [{source!r}, {root!r}]
from tests.maps.test_ensemble import digests
print(digests())
"""


def digests():
    """Return the hashes of a law, of what is built on it and of the whole kernel."""
    law = gz.triggered(r=0.5, V=0.1, trigger=0.1)
    built = (
        active_law, triggered_law, cubic, difference_of(cubic), step_of(law.law, law.slope, law.contraction),
        plain(kernel_of, 1, "strict"), plain(kernel_of, 3, "fast"),
    )  # fmt: skip
    return " ".join(digest(function)[:16] for function in built)


def kernel_of(harmonics, arithmetic):
    return ensemble.__wrapped__(above_wall.__wrapped__(harmonics), harmonics, arithmetic)


def plain(make, *args):
    """Return a kernel before it is compiled."""
    kept = os.environ.get("NUMBA_DISABLE_JIT")
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    try:
        return make(*args)
    finally:
        os.environ.pop("NUMBA_DISABLE_JIT") if kept is None else os.environ.update(NUMBA_DISABLE_JIT=kept)


def test_the_hash_of_a_kernel_is_the_same_in_every_process():
    """Else a kernel kept on disk would never be found again."""
    here = digests()
    for seed in ("1", "2"):
        env = {**os.environ, "PYTHONHASHSEED": seed}  # the same forms as here
        program = DIGESTS.format(source=SOURCE, root=ROOT)
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=env)
        assert done.returncode == 0, done.stderr
        assert done.stdout.split() == here.split()


def test_the_hash_of_the_kernel_sees_every_source_below_it(monkeypatch):
    def other(*args):
        return 0.0

    seen = [digest(plain(kernel_of, 1, "strict"))]
    edits = (
        (contact, "lowest", other),
        (period, "MAX_SWINGS", 7),
        (flight, "exp", other),
        (cells, "put_points", other),
        (taylor.expand, "__code__", other.__code__),
        (elementary.sincos, "__defaults__", (1.0,)),
    )
    for owner, name, edit in edits:
        with monkeypatch.context() as patch:
            patch.setattr(owner, name, edit)
            seen.append(digest(plain(kernel_of, 1, "strict")))
    seen.append(digest(plain(kernel_of, 2, "strict")))
    assert digest(plain(kernel_of, 1, "strict")) == seen[0]
    assert len(set(seen)) == len(seen)


LAW_PROGRAM = """
import sys
sys.path[:0] = [{source!r}, {folder!r}]
import numpy as np
from mine import law
from grazing.kernel.compile import compiled
from grazing.kernel.primitives import called, called_for_all, numbers
from grazing.oscillator.cells import LAW, table_size
from grazing.oscillator.pointed import law_addresses, strike_address
from grazing.oscillator.workspace import WIDTH, W, workspace_size
from grazing.oscillator.reset import difference_of
from grazing.parameter import parameter_tuple

def one(where, v, row):
    return called(where, v, row)

def many(where, work, table, runs):
    called_for_all(where, numbers(work), numbers(table), len(table), numbers(runs), 1)

kind = parameter_tuple(("r",))
places = *law_addresses(law, difference_of(law), "mine", kind, "strict"), strike_address(law, "mine", kind, "strict")
row = np.array([0.5])
work = np.zeros(workspace_size(1))
work[W.BEFORE] = -2.0
at = float(row.ctypes.data)
table, runs = np.zeros(table_size(1)), np.zeros(3 * WIDTH, np.int64)
table[LAW], runs[1] = at, 1
compiled(many)(places[2], work, table, runs)
print(compiled(one)(places[0], -2.0, at), compiled(one)(places[1], -2.0, at), work[W.AFTER])
"""


def test_an_edit_below_a_law_is_never_answered_from_the_cache(tmp_path):
    """The law behind an address, its slope and its loop; the file keeps its length and its time stamp."""
    (tmp_path / "mine.py").write_text("from below import part\n\ndef law(v, p):\n    return -p.r * part(v)\n")
    env = {**os.environ, "GRAZING_CACHE": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    env["NUMBA_DISABLE_JIT"] = "0"
    program = LAW_PROGRAM.format(source=SOURCE, folder=str(tmp_path))
    stamp, kept = None, []
    for factor in (2.0, 2.0, 4.0):
        below = tmp_path / "below.py"
        below.write_text(f"def part(v):\n    return {factor} * v\n")
        if stamp is not None:
            os.utime(below, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
        stamp = below.stat()
        done = python(program, env=env)
        assert done.returncode == 0, done.stderr
        value, slope, after = map(float, done.stdout.split())
        assert (value, after) == (factor, factor)
        assert slope == pytest.approx(-0.5 * factor, rel=1e-9)
        kept.append(len({file.name.partition(".")[0] for file in (tmp_path / "cache").glob("*.nbc")}))
    assert kept[0] == kept[1]  # the second process found all of it
    assert kept[2] == kept[0] + 3  # the law, its slope, its loop; the callers know nothing of the law


def test_laws_of_one_name_are_kept_apart():
    def made(factor):
        def law(v, p):
            return -factor * p.r * v

        return gz.reset(law, r=0.5)

    kind = parameter_tuple(("r",))
    places = {law_addresses(x.law, x.slope, x.name, kind, "strict") for x in (made(1.0), made(0.5))}
    assert len(places) == 2


def test_a_law_is_compiled_once_whatever_the_model_around_it():
    def bent(v, p):
        return -p.r * v / (1.0 - p.c * v)

    law = gz.reset(bent, r=0.5, c=0.3)
    waves = [gz.Forcing(omega=2.2, cos=(1.0,) * n) for n in (1, 2, 3)]
    models = [gz.Oscillator(3, 1, force, law) for force in waves]
    models += [gz.Oscillator(3, stiffness=1, forcing=waves[0], reset=law)]
    walled = gz.Oscillator(3, 1, waves[0], walls=(gz.wall(-0.3, law), gz.wall(0.3, law)))
    found = {tuple(pointed_model(model).row[-3:-1].tolist()) for model in models}
    assert {at[:2] for at in addresses(walled, (0, PIECES))} == found and len(found) == 1


# ---- plain Python

PLAIN = """
import sys
sys.path[:0] = [{source!r}, {root!r}]
from tests.maps.test_ensemble import some_bits
print(some_bits())
"""
#: Without stiffness and damping the flight is a sum of complex exponentials. NumPy's numbers, which plain Python gets
#: from arrays, compute with complex numbers in another way than compiled code: there the last bits differ.
COMPLEX = [i for i, change in enumerate(CHANGES) if change.get("k", 1.0) < 1e-7 or change.get("alpha") == 1e-10]


def some_bits():
    """Return the results of a few orbits, bit for bit, as text."""
    with np.errstate(all="ignore"):
        found = {
            way: [np.asarray(array, np.float64).view(np.int64).tolist() for array in
                  flown((way, "strict"), ROWS, starts_of(2), 1, 4)]
            for way in ("block", "scalar")
        }  # fmt: skip
    return json.dumps(found)


def test_plain_python_gives_the_bits_of_strict_compiled_code():
    env = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    program = PLAIN.format(source=SOURCE, root=ROOT)
    done = python(program, env=env)
    assert done.returncode == 0, done.stderr
    here, there = json.loads(some_bits()), json.loads(done.stdout)
    same_bits = [q for q in range(len(ROWS)) if q not in COMPLEX]
    assert len(same_bits) > 8
    for way in ("block", "scalar"):
        for ours, theirs in zip(here[way], there[way], strict=True):
            a, b = np.array(ours), np.array(theirs)
            assert np.array_equal(a[same_bits], b[same_bits])
            assert np.allclose(a[COMPLEX].view(float), b[COMPLEX].view(float), rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("walls", [1, 2])
def test_of_other_walls_what_is_large_is_not_compiled_anew(walls):
    """Tables, impacts over a wall and questions to the certificate are units, which kernels of all walls share."""
    over, walled = (
        set(units_of(getattr(getattr(entry, "py_func", entry), "original", entry)))
        for entry in (ensemble(setting, 1, "strict") for setting in (above_wall(1), between_walls(1, walls)))
    )
    assert {cells.fill_table, certify, find_cycles} <= over & walled
    assert (impacts_of(1) in over) and (impacts_of(1) in walled) is (walls == 1)
