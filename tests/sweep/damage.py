"""Ways in which a disk, a hand or a sync program harms a store; each takes the folder and a generator of numbers."""

import json
import os
import shutil

import google_crc32c

from grazing.sweep.manifest import lines

#: What the attack must never touch: everything else below the store is fair game.
HARMS = []


def harm(function):
    HARMS.append(function)
    return function


def all_files(store):
    return sorted(file for file in store.rglob("*") if file.is_file() and not file.is_symlink())


def some_file(store, dice):
    """Any file; data and manifest more often than locks and times."""
    found = all_files(store)
    ours = [file for file in found if ".grazing" not in file.parts]
    found = ours if dice.random() < 0.9 else found
    return dice.choice(found) if found else store / "nothing"


def data_files(store):
    return [file for file in all_files(store) if "c" in file.relative_to(store).parts[1:]]


def write(file, content):
    """Write, whatever stands there."""
    for folder in reversed(file.parents):
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            folder.unlink()
    file.parent.mkdir(parents=True, exist_ok=True)
    if file.is_dir() and not file.is_symlink():
        shutil.rmtree(file)
    elif file.is_symlink() or file.exists():
        file.unlink()
    file.write_bytes(content)


def two_of_one_array(store, dice):
    found = data_files(store)
    one = dice.choice(found)
    same = [file for file in found if file.relative_to(store).parts[0] == one.relative_to(store).parts[0]]
    return one, dice.choice(same)


@harm
def swap(store, dice, _other):
    one, two = two_of_one_array(store, dice)
    first, second = one.read_bytes(), two.read_bytes()
    write(one, second)
    write(two, first)


@harm
def swap_whole_chunks(store, dice, _other):
    """All variables of two chunks, and their records, so that everything fits but the place."""
    records = sorted(file.name for file in (store / "manifest" / "chunks").glob("*"))
    if len(records) > 1:
        a, b = dice.sample(records, 2)
        with_records = dice.random() < 0.5
        for array in sorted(store.glob("*/c")):
            here = sorted(array.rglob("*"))
            one, two = (
                next((file for file in here if file.is_file() and number(store, file) == int(n)), None) for n in (a, b)
            )
            if one and two:
                first, second = one.read_bytes(), two.read_bytes()
                write(one, second)
                write(two, first)
        if with_records:
            one, two = (store / "manifest" / "chunks" / name for name in (a, b))
            first, second = one.read_bytes(), two.read_bytes()
            write(one, second)
            write(two, first)


def number(store, file):
    """The number of the chunk that a file belongs to, in the stores of the attack: 3 x 2 chunks."""
    place = file.relative_to(store).parts[2:4]
    return int(place[0]) * 2 + int(place[1]) if len(place) == 2 and all(part.isdigit() for part in place) else -1


@harm
def copy(store, dice, _other):
    one, two = some_file(store, dice), some_file(store, dice)
    write(one, two.read_bytes())


@harm
def duplicate_in_array(store, dice, _other):
    one, two = two_of_one_array(store, dice)
    write(one, two.read_bytes())


@harm
def truncate(store, dice, _other):
    file = some_file(store, dice)
    content = file.read_bytes()
    write(file, content[: dice.randrange(len(content) + 1)])


@harm
def extend(store, dice, _other):
    file = some_file(store, dice)
    write(file, file.read_bytes() + dice.randbytes(dice.choice((1, 100))))


@harm
def flip(store, dice, _other):
    file = some_file(store, dice)
    content = bytearray(file.read_bytes())
    for _ in range(dice.choice((1, 3))):
        if content:
            content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
    write(file, bytes(content))


@harm
def delete(store, dice, _other):
    some_file(store, dice).unlink()


@harm
def delete_folder(store, dice, _other):
    folders = [folder for folder in store.rglob("*") if folder.is_dir() and not folder.is_symlink()]
    shutil.rmtree(dice.choice(folders))


@harm
def add(store, dice, _other):
    names = ("9", "-1", "x", "0.partial", f"x.{'0' * 32}.partial", f"1.{'a' * 32}.partial", "a b", "é", "zarr.json")
    folder = dice.choice([store, *(folder for folder in store.rglob("*") if folder.is_dir())])
    if not (folder / (name := dice.choice(names))).exists():
        (folder / name).write_bytes(some_file(store, dice).read_bytes())


@harm
def rename(store, dice, _other):
    one, two = two_of_one_array(store, dice)
    if one != two:
        write(two, one.read_bytes())
        one.unlink()


@harm
def transplant_file(store, dice, other):
    file = some_file(other, dice)
    write(store / file.relative_to(other), file.read_bytes())


@harm
def transplant_chunk(store, dice, other):
    """All files of a chunk, its record and that it is done, from a store of the same shape, or an older version."""
    n = dice.choice([int(file.name) for file in (other / "manifest" / "chunks").glob("*")])
    for file in all_files(other):
        if number(other, file) == n or file == other / "manifest" / "chunks" / str(n):
            write(store / file.relative_to(other), file.read_bytes())


@harm
def transplant_part(store, dice, other):
    part = dice.choice(["manifest", "done", "points", "manifest/chunks", "manifest/seal", "manifest/template", "mu"])
    if (other / part).is_dir():
        for file in all_files(other / part):
            write(store / file.relative_to(other), file.read_bytes())
    elif (other / part).is_file():
        write(store / part, (other / part).read_bytes())


CHANGES = {
    "data_type": ["float32", "int64", "uint8", "complex128", "nonsense", 3],
    "fill_value": [0, 1, "Infinity", None],
    "shape": [[5, 3], [50, 30], [10**9, 10**9], [], "x", [-1]],
    "codecs": [[{"name": "bytes"}], [{"name": "gzip"}], [], None],
    "dimension_names": [["l", "mu"], ["a", "b"], None],
    "chunk_grid": [{"name": "regular", "configuration": {"chunk_shape": [1, 1]}}, {}, None],
    "zarr_format": [2],
    "node_type": ["group"],
}


@harm
def change_metadata(store, dice, _other):
    """One value anywhere in zarr.json, there alone or also in the copy that the whole keeps."""
    found = [file for file in all_files(store) if file.name == "zarr.json"]
    if not found:
        return
    file = dice.choice(found)
    try:
        record = json.loads(file.read_bytes())
        if dice.random() < 0.5:
            attributes = record["attributes"]
            key = dice.choice([*attributes, "note", *["grazing_sweep"] * 9 * ("grazing_sweep" in attributes)])
            attributes[key] = dice.choice(["m", 7, [1], attributes.get(key, "x"), None, {"a": 1}])
            if isinstance(attributes[key], str) and key.startswith("grazing") and dice.random() < 0.5:
                attributes[key] = attributes[key].replace("0", str(dice.randrange(10)), dice.randrange(1, 9))
            if key == "grazing_sweep" and isinstance(attributes[key], str) and dice.random() < 0.7:
                layout = json.loads(attributes[key])  # what a store without a manifest has but its word for
                layout[dice.choice(list(layout))] = dice.choice(
                    [
                        None,
                        1,
                        "x",
                        [],
                        {},
                        [10**9, 10**9],
                        [1, 1],
                        {"points": "float64"},
                        {"points/bound": 3},
                        [0],
                        True,
                    ]
                )
                attributes[key] = json.dumps(layout)
        else:
            key = dice.choice(list(CHANGES))
            record[key] = dice.choice(CHANGES[key])
    except (ValueError, KeyError, TypeError, IndexError):
        return
    write(file, json.dumps(record, indent=2).encode())
    head = store / "zarr.json"
    if dice.random() < 0.5 and file != head and head.is_file():
        try:
            whole = json.loads(head.read_bytes())
            whole["consolidated_metadata"]["metadata"][file.parent.name] = record
        except (ValueError, KeyError, TypeError):
            return
        write(head, json.dumps(whole, indent=2).encode())


@harm
def done_bits(store, dice, _other):
    found = all_files(store / "done") if (store / "done").is_dir() else []
    for file in dice.sample(found, min(len(found), dice.randrange(1, 4))):
        if file.name != "zarr.json":
            write(file, dice.choice([b"\0", b"\2", b"", b"\1\1", b"\xff"]))


@harm
def mark_all_as_done(store, dice, _other):
    for i in range(3):
        for j in range(2):
            write(store / "done" / "c" / str(i) / str(j), b"\1")


@harm
def special_file(store, dice, _other):
    file = some_file(store, dice)
    content = file.read_bytes() if file.is_file() else b""
    file.unlink(missing_ok=True)
    kind = dice.randrange(7)
    if kind == 0:
        os.mkfifo(file)
    elif kind == 1:
        file.mkdir()
        (file / "inner").write_bytes(content)
    elif kind == 2:
        file.symlink_to(dice.choice(["/dev/zero", "/dev/full", "/nowhere", file.name]))
    elif kind == 3:  # a link to the very same bytes
        elsewhere = store.parent / f"elsewhere{dice.randrange(10**9)}"
        elsewhere.write_bytes(content)
        file.symlink_to(elsewhere)
    elif kind == 4:
        file.symlink_to(some_file(store, dice))
    elif kind == 5:
        os.link(some_file(store, dice), file)
    else:
        file.symlink_to(file.parent)


@harm
def special_folder(store, dice, _other):
    folders = [folder for folder in store.rglob("*") if folder.is_dir() and not folder.is_symlink()]
    folder = dice.choice(folders)
    aside = store.parent / f"folder{dice.randrange(10**9)}"
    kind = dice.randrange(4)
    os.rename(folder, aside)
    if kind == 0:
        folder.symlink_to(aside)
    elif kind == 1:
        folder.write_bytes(b"a file")
    elif kind == 2:
        os.mkfifo(folder)
    else:
        folder.symlink_to(folder.parent)


@harm
def bomb(store, dice, _other):
    """A frame that announces far more than a chunk holds, with a checksum that fits."""
    size = dice.choice([2**20, 2**31, 2**62])
    frame = b"\x28\xb5\x2f\xfd" + bytes([0b11100000]) + size.to_bytes(8, "little") + b"\x03\x00\x00\0"
    if dice.random() < 0.3:  # no size at all, and a block of 128 kB of one byte, many times
        frame = b"\x28\xb5\x2f\xfd" + bytes([0, 0x58]) + (b"\x02\x00\x10" + b"\0") * 5000 + b"\x01\x00\x00"
    file, _same = two_of_one_array(store, dice)
    write(file, frame + google_crc32c.value(frame).to_bytes(4, "little"))


@harm
def forge_record(store, dice, _other):
    """A record, seal or template that fits its own hash, and says something else."""
    found = [file for file in all_files(store) if "manifest" in file.parts]
    if not found:
        return
    file = dice.choice(found)
    try:
        body = json.loads(file.read_bytes().splitlines()[0])
        key = dice.choice(sorted(body))
        body[key] = dice.choice([None, 3, "x", [], {}, {"a": 1}, [1], True, -1])
    except (ValueError, IndexError, TypeError):
        return
    write(file, lines(body))


@harm
def unseal(store, dice, _other):
    (store / "manifest" / "seal").unlink(missing_ok=True)
