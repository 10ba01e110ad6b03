"""Stores of a forger, all hashes fit: nothing is written elsewhere or asked of memory, every error is a sentence."""

import json
import os
import shutil
import subprocess
import sys
import time
from contextlib import suppress

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import sweep
from grazing.config import plan_of
from grazing.config.build import RECIPE
from grazing.outcome import GrazingError
from grazing.sweep import manifest
from tests.sweep.forger import bound, compact, forged
from tests.sweep.plans import plan


@pytest.fixture
def store(tmp_path):
    (tmp_path / "home").mkdir()
    sweep.run(plan(7), tmp_path / "home" / "a.zarr", chunk=2)
    return tmp_path / "home" / "a.zarr"


def calls(store):
    """Everything that is done to a store that somebody handed over."""
    yield lambda: gz.load(store)
    yield lambda: sweep.status(store)
    yield lambda: sweep.verify(store, share=1, plan=plan(7))
    yield lambda: sweep.verify(store, share=1, plan=plan(7), repair=True)
    yield lambda: sweep.resume(store, plan(7))
    yield lambda: sweep.unlock(store)


def around(store):
    """What lies outside of the store."""
    top = store.parents[1]
    return {
        str(path): path.read_bytes() if path.is_file() else None
        for path in sorted(top.rglob("*"))
        if store not in path.parents
    }


def attacked(store):
    """Do everything; return what was said. Nothing outside may change, and every error is one that is meant."""
    before, said = around(store), []
    for call in calls(store):
        try:
            call()
        except GrazingError as error:
            said.append(str(error))
        assert around(store) == before
    return said


OUTSIDE = ["../evil", "../../evil", "{top}/evil", "x/../../evil", "..", ".", "", "a\\b", "a\0b", "a\x1b[2J", "\ud800"]


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.parametrize("what", ["metadata", "prints", "variable", "coordinate"])
def test_no_name_leads_out_of_the_store(store, name, what):
    name = name.format(top=store.parents[1])

    def change(metadata, layout, prints):
        if what == "metadata":
            metadata[f"{name}/zarr.json"] = {"any": "text"}
        elif what == "prints":
            prints[f"{name}/c/0"] = prints["mu/c/0"]
        else:
            old, into = ("mean", "variables") if what == "variable" else ("mu", "coords")
            layout[into] = {(name if key == old else key): kind for key, kind in layout[into].items()}
            metadata[f"{name}/zarr.json"] = metadata.pop(f"{old}/zarr.json")

    try:
        forged(store, change)
    except (ValueError, OSError):  # a name that no disk has: what is left is damaged
        pass
    assert attacked(store)


VALUES = [None, [], {}, "x", 1e999, -1, 1.5, [[]], [1e999], [None], {"a": 1}, 10**30, [10**30], True, 0, "", ["x"] * 3]


def entries(node, path=()):
    """Every entry of JSON, at any depth; of what is listed for other tools only that it is."""
    for key, inner in list(node.items() if isinstance(node, dict) else enumerate(node)):
        yield (*path, key)
        if isinstance(inner, (dict, list)) and path != ("consolidated_metadata", "metadata"):
            yield from entries(inner, (*path, key))


def opened(metadata, layout, prints):
    """All that a store says of itself, by what says it; JSON within texts as what it says."""
    texts = metadata["zarr.json"]["attributes"].items()
    prints.update({file: list(both) for file, both in prints.items()})
    inner = {key: json.loads(text) for key, text in texts if text[:1] in ("{", "[") and key != "grazing_sweep"}
    return {**metadata, "layout": layout, "prints": prints, **inner}


def said(call):
    """What a call returns, None for a sentence."""
    try:
        return call()
    except GrazingError:
        return None


def raw(store):
    """What other tools read, None if they read nothing."""
    try:
        with xr.open_zarr(store, decode_cf=False, chunks=None) as found:
            return found.load().drop_attrs(deep=False)
    except Exception:  # whatever they raise
        return None


@pytest.mark.parametrize("turn", [0, *(pytest.param(turn, marks=pytest.mark.long) for turn in range(1, len(VALUES)))])
def test_whatever_an_entry_says_is_a_sentence_or_found_or_nothing_new(tmp_path, turn):
    """Each entry of all that a store says of itself becomes each value, and every hash fits."""
    store, some = tmp_path / "a.zarr", plan(2)
    sweep.run(some, store, chunk=1)
    honest, plain, template = gz.load(store), raw(store), manifest.read_template(store)
    every = []

    def look(metadata, layout, prints):
        every.extend((what, path) for what, node in opened(metadata, layout, prints).items() for path in entries(node))

    forged(store, look)
    for i, (what, path) in enumerate(every):
        value = VALUES[(i + turn) % len(VALUES)]

        def change(metadata, layout, prints, what=what, path=path, value=value):
            documents = opened(metadata, layout, prints)
            node = documents[what]
            for key in path[:-1]:
                node = node[key]
            node[path[-1]] = value
            if what not in (*metadata, "layout", "prints"):
                metadata["zarr.json"]["attributes"][what] = compact(documents[what])

        with suppress(AttributeError, TypeError):  # nothing is left into which the rest could be put
            forged(store, change)
        found = said(lambda: gz.load(store))
        said(lambda: sweep.status(store))
        seen = said(lambda: sweep.verify(store, share=1, plan=some))
        if seen is not None and seen.ok:
            assert found is not None and found.identical(honest), (what, path)
            others = raw(store)
            assert others is None or others.identical(plain), (what, path)
        for key, text in template.metadata.items():
            (store / key).write_text(text)
        bound(store, template.metadata, template.coordinates)
    assert len(every) > 200 and gz.load(store).identical(honest)


def test_records_of_any_kind_are_a_sentence(store):
    identity = manifest.read_template(store).identity
    file = store / manifest.CHUNKS / "1"
    body = json.loads(file.read_bytes().split(b"\n")[0])
    for key in body:
        for value in (None, [], {}, 1e999, "x", {"a": 1}, {"a": [1e999, "x"]}, {"a": [10**30, 3]}, [[1, 2]], -1):
            file.write_bytes(manifest.lines({**body, key: value}))
            attacked_only = [gz.load, sweep.status, lambda path: sweep.verify(path, plan=plan(7))]
            for call in attacked_only:
                try:
                    call(store)
                except GrazingError:
                    pass
    for records in (None, 3, [None] * 4, [1e999] * 4, [[]] * 4, {"a": 1}):
        (store / manifest.SEAL).write_bytes(manifest.lines({"store": identity, "records": records}))
        for call in attacked_only:
            with pytest.raises(GrazingError) if call is gz.load else _either():
                call(store)


class _either:
    def __enter__(self):
        return self

    def __exit__(self, kind, error, _where):
        return kind is None or issubclass(kind, GrazingError)


# ---- memory


def many_files(metadata, _layout, prints):
    """A coordinate in as many files as it has numbers."""
    own = metadata["mu/zarr.json"]
    own["shape"], own["chunk_grid"]["configuration"]["chunk_shape"] = [10**14], [1]


def long_words(metadata, _layout, _prints):
    own = metadata["word/zarr.json"]
    own["shape"][-1] = own["chunk_grid"]["configuration"]["chunk_shape"][-1] = 10**11


def wide_words(metadata, layout, _prints):
    layout["coords"]["mu"] = "<U999999999"
    metadata["mu/zarr.json"]["attributes"]["grazing_text"] = ""
    metadata["mu/zarr.json"]["data_type"] = "uint8"
    metadata["mu/zarr.json"]["shape"] = metadata["mu/zarr.json"]["chunk_grid"]["configuration"]["chunk_shape"] = [7, 8]
    metadata["mu/zarr.json"]["dimension_names"] = ["mu", "letters"]


def long_coordinate(metadata, _layout, _prints):
    own = metadata["mu/zarr.json"]
    own["shape"], own["chunk_grid"]["configuration"]["chunk_shape"] = [10**11], [10**11]


def wide_type(metadata, layout, _prints):
    metadata["mu/zarr.json"]["data_type"] = layout["coords"]["mu"] = "<U2000000000"


def wide_attribute(metadata, layout, _prints):
    layout["types"]["mean/long_name"] = "<U500000000 0"


def wide_attributes(metadata, layout, _prints):
    metadata["mean/zarr.json"]["attributes"]["many"] = ["a"] * 1000
    layout["types"]["mean/many"] = "<U500000000 1"


def object_type(metadata, layout, _prints):
    metadata["mu/zarr.json"]["data_type"] = layout["coords"]["mu"] = "object"


def large_chunks(metadata, layout, _prints):
    """Seven cells in a chunk of a thousand million."""
    layout["chunk"] = [10**9]
    for name in ("points", "mean", "period", "word"):
        metadata[f"{name}/zarr.json"]["chunk_grid"]["configuration"]["chunk_shape"][0] = 10**9
    metadata["done/zarr.json"]["shape"] = [1]


BOMBS = [
    large_chunks,
    many_files,
    long_words,
    wide_words,
    long_coordinate,
    wide_type,
    wide_attribute,
    wide_attributes,
    object_type,
]
ATTACK = """
import resource, sys, threading
import numpy as np
from grazing import sweep
import grazing as gz
from grazing.outcome import GrazingError
from tests.sweep.plans import plan
plan(7).document
gz.InputError
import xarray, zarr, numcodecs.zstd, google_crc32c
with open("/proc/self/statm") as file:
    now = int(file.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (now + 2**30, now + 2**30))
for store in sys.argv[1:]:
    for call in (gz.load, sweep.status, lambda path: sweep.verify(path, share=1, plan=plan(7))):
        try:
            call(store)
            print(store, "went well")
        except GrazingError as error:
            pass
"""


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs the size of a process")
def test_what_a_store_announces_is_not_taken_from_memory(store, tmp_path):
    stores = []
    for bomb in BOMBS:
        copy = tmp_path / f"{bomb.__name__}.zarr"
        shutil.copytree(store, copy)
        stores.append(forged(copy, bomb))
    done = subprocess.run(
        [sys.executable, "-c", ATTACK, *map(str, stores)], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr[-2000:]


def test_chunks_larger_than_the_array_are_refused(store):
    with pytest.raises(gz.InputError, match="its chunks are larger than itself"):
        gz.load(forged(store, large_chunks))


@pytest.mark.parametrize(
    ("file", "key", "value"),
    [("zarr.json", "title", "chart"), ("zarr.json", "Conventions", None), ("mean/zarr.json", "units", "mm"),
     ("mu/zarr.json", "long_name", "time"), ("zarr.json", "grazing_code_sha256", "0"),
     ("zarr.json", "grazing_made_by", "{}"), ("zarr.json", "coordinates", "label x0 mean")],
)  # fmt: skip
def test_attributes_are_held_to_the_plan(store, file, key, value):
    """What a result says of its numbers was believed: metres became millimetres, and every hash fitted."""

    def change(metadata, _layout, _prints):
        metadata[file]["attributes"][key] = value

    forged(store, change)
    for repair in (False, True):
        found = sweep.verify(store, plan=plan(7), repair=repair)
        assert [one.variable for one in found.differences] == [file.removesuffix("/zarr.json")]
        assert f"its attributes {key} are not those of the plan; begin another store" in str(found)
    assert not found.ok and not found.mended and not found.missing


@pytest.mark.parametrize(
    "recipe", [{"study": "diagram", "map": name, "vary": {"mu": "0:0.1:7"}} for name in ("gap", "mine.py:P", "none")]
)
def test_a_recipe_that_was_put_in_is_held_to_the_plan(store, recipe):
    """``grazing info`` says from it by what command the result is made again; one that names code runs nothing."""

    def change(metadata, _layout, _prints):
        metadata["zarr.json"]["attributes"][RECIPE] = json.dumps(recipe)

    forged(store, change)
    found = sweep.verify(store, plan=plan(7))
    if recipe["map"] == "mine.py:P":
        assert found.ok
    else:
        assert str(found).partition("zarr.json: ")[2].startswith("its recipe is of another sweep (")


def test_a_recipe_of_another_sweep_adds_nothing(tmp_path):
    """It was taken: a table of attractors from other starts in silence, and a bare KeyError from another study."""
    gap = {"map": "gap", "parameters": {"lam": 0.8, "l": 0.1}}
    config = {"study": "coexistence", **gap, "vary": {"mu": "-0.1:0.3:4"}, "settings": {"starts": 5}}
    store = tmp_path / "a.zarr"
    sweep.run(plan_of(config), store)
    assert "attractor" in gz.load(store).sizes
    basins = {"study": "basins", "map": "gap", "parameters": {"l": 0.1, "mu": 0.1, "lam": 0.5}, "vary": {"x": "0:1:4"}}
    for other in ({**config, "settings": {"starts": 7}}, {**config, "vary": {"mu": "0.5:0.9:4"}}, basins):

        def change(metadata, _layout, _prints, other=other):
            metadata["zarr.json"]["attributes"]["grazing_recipe"] = json.dumps(other)

        found = gz.load(forged(store, change))
        assert "recipe is of another sweep" in found.attrs["grazing_note"]
        assert "attractor" not in found.sizes


def coexisting(folder):
    gap = {"map": "gap", "parameters": {"lam": 0.8, "l": 0.1}}
    config = {"study": "coexistence", **gap, "vary": {"mu": "-0.1:0.3:4"}, "settings": {"starts": 5}}
    sweep.run(plan_of(config), folder / "a.zarr")
    return config, folder / "a.zarr"


def listed(metadata):
    return metadata["zarr.json"]["consolidated_metadata"]["metadata"]


def other_units(metadata, _layout, _prints):
    listed(metadata)["mean"]["attributes"]["units"] = "mm"


def one_more_array(metadata, _layout, _prints):
    listed(metadata)["more"] = listed(metadata)["mean"]


def numbers_of_missing_cells(metadata, _layout, _prints):
    for of_mean in (metadata["mean/zarr.json"], listed(metadata)["mean"]):
        of_mean["fill_value"] = 7.0


@pytest.mark.parametrize("forgery", [other_units, one_more_array, numbers_of_missing_cells])
def test_what_other_tools_read_of_a_store_is_held_to_its_arrays(store, forgery):
    """``xarray.open_zarr`` read other units, one more array, sevens where nothing was computed; ``verify`` agreed."""
    forged(store, forgery)
    for call in (gz.load, lambda path: sweep.verify(path, share=1, plan=plan(7))):
        with pytest.raises(GrazingError, match=r"zarr\.json cannot be used"):
            call(store)


def test_lists_of_nothing_are_not_read(store):
    """JSON of 128 MB that holds nothing but lists takes 5 GB and half a minute, once for each file."""
    for file in ("zarr.json", "mean/zarr.json", manifest.TEMPLATE, manifest.SEAL, f"{manifest.CHUNKS}/0"):
        whole = (store / file).read_bytes()
        (store / file).write_bytes(b"[" + b"[]," * 6_000_000 + b"[]]")
        with pytest.raises(GrazingError, match="more than it can have"):
            gz.load(store)
        (store / file).write_bytes(whole)


def test_a_recipe_of_anything_is_a_note(tmp_path):
    """Studies without cells made the store "a folder" that cannot be opened; a density's range was sought for ever."""
    config, store = coexisting(tmp_path)
    gap = {"map": "gap", "parameters": {"lam": 0.8, "l": 0.1}}
    dear = {"starts": 1000, "transient": 10**12}
    recipes = [{}, {"study": "xx"}, {"study": ["diagram"]}, {"study": "trajectory", "settings": {"state": [0.1, 0]}},
               {"study": "orbit", **gap, "settings": {"period": "1:3"}}, {**config, "curves": [2]},
               {"study": "density", **gap, "vary": {"mu": "0:1:1000"}, "settings": dear},
               {**config, "vary": {"mu": "-0.1:0.3:99999999"}}, {**config, "vary": [["mu", "0:1:99999999"]]},
               {**config, "vary": 3}, {**config, "vary": [3]}, {**config, "settings": {"starts": 10**8}}]  # fmt: skip
    for recipe in recipes:

        def change(metadata, _layout, _prints, recipe=recipe):
            metadata["zarr.json"]["attributes"]["grazing_recipe"] = json.dumps(recipe)

        begun = time.process_time()
        found = gz.load(forged(store, change))
        assert "recipe is of another sweep" in found.attrs["grazing_note"] and "reached_word" in found
        assert time.process_time() - begun < 5.0


def test_numbers_that_would_take_for_ever_to_finish_are_a_note(tmp_path):
    """Recipe, configuration and hashes fit; only to follow the attractors again would take days."""
    config, store = coexisting(tmp_path)
    assert "attractor" in gz.load(store).sizes
    dear = plan_of({**config, "settings": {"starts": 5, "transient": 10**12}})

    def change(metadata, _layout, _prints):
        attrs = metadata["zarr.json"]["attributes"]
        attrs |= dear.document | {"grazing_recipe": json.dumps(dear.recipe)}

    begun = time.process_time()
    found = gz.load(forged(store, change))
    assert "takes more than" in found.attrs["grazing_note"] and "reached_word" in found
    assert time.process_time() - begun < 5.0


def test_what_basins_would_take_is_seen_in_their_numbers():
    P = gz.gap_map(lam=0.8, mu=0.05, l=0.1)
    plan = gz.plans.basins(P, {"x": np.linspace(0.0, 1.0, 1000)})
    honest, period = np.zeros((1000, 1)), np.ones(1000, np.int32)
    words = np.full(1000, "L", object)
    told = []
    for points in (honest, np.random.default_rng(1).random((1000, 1))):
        result = xr.Dataset({"reached_period": ("x", period), "reached_word": ("x", words),
                             "reached_point": (("x", "coordinate"), points)})  # fmt: skip
        told.append(plan.finish_work(result))
    assert told[1] > told[0] + 1000.0


@pytest.mark.parametrize("key", ["mean/c/0", "mu/c/0"])
def test_a_length_that_a_manifest_claims_is_not_read(store, key):
    """A sparse file of some GB, announced by a record or the template, was read into memory and hashed."""
    long = 2**31
    template = manifest.read_template(store)
    prints = dict(template.coordinates)
    if key in prints:
        prints[key] = (long, "0" * 64)
    bound(store, template.metadata, prints)
    if key not in prints:
        file = store / manifest.CHUNKS / "0"
        body = json.loads(file.read_bytes().split(b"\n")[0])
        body["files"][key] = [long, "0" * 64]
        file.write_bytes(manifest.lines(body))
        (store / manifest.SEAL).unlink()
    os.truncate(store / key, long)
    with pytest.raises(GrazingError, match="more than it can have"):
        gz.load(store)
    assert "more than it can have" in str(sweep.verify(store, plan=plan(7)))
