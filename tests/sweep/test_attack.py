"""Stores that were harmed: what is read is exactly what was written, or it is a plain error; and repair restores it.

A generator of harm, `damage`, changes copies of four stores and of one that version 0.1 made. Whatever it does, a
store gives the right numbers, or says what is wrong: it never gives others, waits for ever or falls over.
"""

import random
import shutil
import signal
import tempfile
import zipfile
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

import grazing as gz
from grazing import sweep
from grazing.studies.plan import Plan, Variable, run_plan
from tests.sweep.damage import HARMS
from tests.sweep.plans import files
from tests.sweep.plans import plan as orbits

pytestmark = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs POSIX signals and files")

OLD = Path(__file__).with_name("store_0_1.zip")
CHUNK = {"mu": 2, "l": 2}
#: Seconds that nothing here may take.
LONGEST = 20.0


def plan(shift=0.0, slip=False):
    """A plan whose cells take no time; ``slip`` says that they are computed wrong."""

    def compute(cells, arrays):
        yield
        for i, cell in enumerate(cells):
            arrays["points"][i] = np.arange(12.0).reshape(3, 4) + 100.0 * cell + shift + slip
            arrays["period"][i] = int(cell) % 5 + slip
            arrays["word"][i] = "LR" * (int(cell) % 3)

    return Plan(
        P=gz.gap_map(lam=0.5 + shift, mu=0.1, l=0.1),
        title="cells to be harmed",
        config={"study": "attack"},
        axes={"mu": np.linspace(0.0, 1.0, 5), "l": np.linspace(0.0, 1.0, 3)},
        sizes={"start": 3, "n": 4},
        variables={
            "points": Variable(("start", "n"), "float64", {"long_name": "points", "units": "1"}),
            "period": Variable((), "int32", {"long_name": "period"}),
            "word": Variable((), "text", {"long_name": "word"}, longest=4),
        },
        compute=compute,
        together=2,
        work=1,
    )


@contextmanager
def in_time():
    def late(*_):
        raise TimeoutError("it waits for ever")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, LONGEST)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def nursery(tmp_path_factory):
    """Stores to be harmed, by name, those that harm them, and what is right."""
    folder = tmp_path_factory.mktemp("attack")
    there = {}
    for name, some, options in (
        ("whole", plan(), {}),
        ("half", plan(), {"shard": (1, 2)}),
        ("other", plan(shift=0.25), {}),
        ("half of other", plan(shift=0.25), {"shard": (2, 2)}),
    ):
        there[name] = folder / name
        sweep.run(some, there[name], chunk=CHUNK, threads=1, **options)
    # an older version of the very store, of which other code has made wrong numbers
    there["older"] = folder / "older"
    with pytest.MonkeyPatch.context() as patch:
        sweep.run(plan(), there["older"], chunk=CHUNK, shard=(7, 7))  # begun by the right code
        patch.setattr(gz, "__version__", "0.0.9")
        sweep.run(plan(slip=True), there["older"], threads=1, other_code=True)
    there["unbound"] = folder / "unbound"
    with zipfile.ZipFile(OLD) as packed:
        packed.extractall(there["unbound"])
    return there, run_plan(plan()), files(there["whole"])


def plain(action):
    """Give what an action returns, or None if it says what is wrong in one of our sentences."""
    with in_time():
        try:
            return action()
        except gz.GrazingError as error:
            assert str(error).strip() and "Traceback" not in str(error)
            return None


def refuse_silence(found, truth, sealed):
    """Fail if a result has a wrong number that it does not confess."""
    done = found.done.values if "done" in found else np.ones(truth.period.shape, bool)
    assert done.all() or "grazing_incomplete" in found.attrs
    other = found.made_by.values > 0 if "made_by" in found else np.zeros_like(done)
    assert not other.any() or (not sealed and "grazing_mixture" in found.attrs)
    for name in truth.variables:
        right, here = truth[name], found[name]
        assert here.dtype == right.dtype and here.dims == right.dims and here.attrs == right.attrs, name
        if name in truth.data_vars:
            assert np.array_equal(here.values[done & ~other], right.values[done & ~other]), name
            if here.dtype.kind == "f":
                assert np.isnan(here.values[~done]).all()
        else:
            assert np.array_equal(here.values, right.values), name
    for key, value in truth.attrs.items():
        assert found.attrs[key] == value


def attack(nursery, seed, folder):
    """Harm one store, and look at it in every way."""
    there, truth, right = nursery
    dice = random.Random(seed)
    name = dice.choice(["whole", "whole", "half", "unbound"])
    store = folder / "a.zarr"
    shutil.copytree(there[name], store)
    done_by = []
    for _ in range(dice.choice((1, 1, 1, 2, 4))):
        action = dice.choice(HARMS)
        done_by.append(action.__name__)
        with suppress(OSError, IndexError):
            action(store, dice, there[dice.choice(["other", "half of other", "older", "whole"])])
    said = f"seed {seed}: {name}, {', '.join(done_by)}"
    try:
        sealed = (store / "manifest" / "seal").is_file()
        plain(lambda: sweep.status(store))
        found = plain(lambda: gz.load(store))
        if name == "unbound":
            assert found is None or "grazing_unbound" in found.attrs
            assert plain(lambda: sweep.run(plan(), store)) is None
            plain(lambda: sweep.verify(store, 0.0, plan=orbits(3), other_code=True, threads=1))
            return found is not None
        if found is not None:
            assert "grazing_unbound" not in found.attrs
            refuse_silence(found, truth, sealed)
        seen = plain(lambda: sweep.verify(store, 0.0, plan=plan(), threads=1))
        mixed = found is not None and "grazing_mixture" in found.attrs  # of which computing again may see more
        assert (found is not None) == (seen is not None and seen.ok) or (mixed and seen is not None)
        mended = plain(lambda: sweep.verify(store, 1.0, plan=plan(), repair=True, threads=1))
        if mended is None:  # so much is gone that nobody can say what it was
            assert found is None
            return False
        again = sweep.run(plan(), store, threads=1)
        assert again.complete and not again.damaged
        if again.mixture:  # a record says, with a hash that fits, that right numbers were made by something else
            assert "forge_record" in done_by and sweep.verify(store, 1.0, plan=plan(), threads=1).ok
            return True
        assert {key: (store / key).read_bytes() for key in right} == right
        return True
    except BaseException as error:
        raise AssertionError(said) from error


def attacks(nursery, seeds):
    mended = 0
    for seed in seeds:
        with tempfile.TemporaryDirectory() as folder:
            mended += attack(nursery, seed, Path(folder))
    return mended


@pytest.mark.parametrize("part", range(3))
def test_harm_is_found_or_does_none(nursery, part):
    assert attacks(nursery, range(30 * part, 30 * part + 30)) > 15


@pytest.mark.long
def test_harm_is_found_or_does_none_thousands_of_times(nursery):
    assert attacks(nursery, range(10_000, 15_000)) > 2500
