"""Files of a stranger: results, tables and figures that say anything; every error is a sentence, nothing is taken."""

import json
import os
import struct
import subprocess
import sys
import time
import zlib
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing.cli.app import main
from grazing.export import to_csv
from grazing.outcome import InputError
from tests.processes import python

# ---- results


@pytest.fixture
def result():
    found = xr.Dataset({"x": ("d", [1.0, 2.0, np.nan]), "word": ("d", ["L", "", "RR"]), "z": ("d", [1j, 2, 3])})
    found["x"].attrs = {"list": [1, 2], "whole": 3, "np": np.float32(1)}
    return found.assign_coords(d=[0.1, 0.2, 0.3])


def rewritten(path, change):
    """Change the record of a file."""
    with xr.open_dataset(path, engine="scipy", decode_cf=False) as opened:
        stored = opened.load()
    record = json.loads(stored.attrs["grazing_file"])
    record = change(record) or record
    stored.attrs["grazing_file"] = record if isinstance(record, str) else json.dumps(record)
    stored.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")


def places(node, path=()):
    yield path
    if isinstance(node, (dict, list)):
        for key, inner in list(node.items() if isinstance(node, dict) else enumerate(node)):
            yield from places(inner, (*path, key))


VALUES = [None, [], {}, "x", "O", "V8", "<M8[s]", "f8,(100000000,)i8", "<U999999999", 1e999, -1, True, {"names": ["a"]},
          "python 1 <U500000000", "python 1 object", "1 2 3 4", "<i4"]  # fmt: skip


def test_a_record_of_any_kind_is_a_sentence(result, tmp_path):
    path = gz.save(result, tmp_path / "a.nc")
    whole = path.read_bytes()
    with xr.open_dataset(path, engine="scipy", decode_cf=False) as opened:
        record = json.loads(opened.attrs["grazing_file"])
    every = [(where, value) for where in places(record) for value in (*VALUES, KeyError)]
    for i in np.random.default_rng(3).choice(len(every), 250, replace=False):
        where, value = every[i]

        def change(record, where=where, value=value):
            node = record
            for key in where[:-1]:
                node = node[key]
            if not where:
                return json.dumps(None if value is KeyError else value)
            if value is KeyError:
                del node[where[-1]]
            else:
                node[where[-1]] = value

        path.write_bytes(whole)
        rewritten(path, change)
        try:
            gz.load(path)
        except InputError as error:
            assert str(path) in str(error)
    for text in ("", "[" * 100_000, "9" * 10_000, '{"format": 1e999}', "\x1b[2J"):
        path.write_bytes(whole)
        rewritten(path, lambda _record, text=text: text or " ")
        with pytest.raises(InputError, match=r"damaged|format"):
            gz.load(path)


def changed(path, change):
    """Change what a file holds, with another tool, and leave its record as it is."""
    with xr.open_dataset(path, engine="scipy", decode_cf=False) as opened:
        stored = change(opened.load())
    stored.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")


@pytest.mark.parametrize(
    ("given", "values"),
    [([1, 2], [np.nan, 1.0]), ([1, 2], [1.5, 2.0]), ([1, 2], [1e300, 1.0]), ([True, False], np.array([2, 0], "i1")),
     (np.array([1, 2], "u1"), np.array([300, -1], "i4")), (np.array([1, 2], "f4"), [1.0 + 1e-12, 1.0]),
     (np.array([1, 2], "f4"), [1e300, 1.0]), (["L", "RR"], ["L", "RRRR"]), ([1.0, 2.0], ["1", "2"]),
     ([1.0, 2.0], ["", "x"]), (["L", "RR"], [1.0, 2.0]), ([1j, 2.0], [1.0, 2.0])],
)  # fmt: skip
def test_numbers_are_not_bent_into_the_type_that_was_saved(given, values, tmp_path):
    """What another tool had put there was rounded, cut off or wrapped around, in silence: 300 in a byte became 44."""
    path = gz.save(xr.Dataset({"x": ("d", given)}), tmp_path / "a.nc")
    changed(path, lambda stored: stored.drop_vars("x").assign(x=("d", values)))
    with pytest.raises(
        InputError, match=r"is damaged and cannot be read: (its record names a type|variable 'x' has not)"
    ):
        gz.load(path)


@pytest.mark.parametrize("dims", [("real_imaginary", "d"), ("d", "e")])
def test_complex_numbers_have_two_parts(dims, tmp_path):
    """Parts that were transposed were taken for numbers, and a third was left out."""
    path = gz.save(xr.Dataset({"x": ("d", [1j, 2.0])}), tmp_path / "a.nc")
    changed(path, lambda stored: stored.drop_vars("x").assign(x=(dims, np.ones((2, 3 if dims[1] == "e" else 2)))))
    with pytest.raises(InputError, match="variable 'x' has not the parts of complex numbers"):
        gz.load(path)


@pytest.mark.parametrize(("saved", "values"), [(3, 3.5), (np.int8(3), np.int32(300)), ([1, 2], np.array([0.5, 1.0]))])
def test_an_attribute_is_not_bent_into_the_type_that_was_saved(saved, values, tmp_path):
    path = gz.save(xr.Dataset({"x": ("d", [1.0, 2.0], {"a": saved})}), tmp_path / "a.nc")
    changed(path, lambda stored: stored.assign(x=stored.x.assign_attrs(a=values)))
    with pytest.raises(InputError, match="its record names a type int"):
        gz.load(path)


@pytest.mark.parametrize(
    "attrs",
    [{"scale_factor": 2.0, "add_offset": 1.0}, {"_FillValue": 1.0}, {"missing_value": 2.0}, {"_Unsigned": "true"},
     {"units": "days since 2000-01-01"}, {"calendar": "standard"}, {"valid_range": [0, 1]}, {"coordinates": "x"},
     {"dtype": "bool"}, {"_Encoding": "ascii"}, {"date_created": "never"}, {"grazing_file": "{}"}],
    ids=lambda attrs: next(iter(attrs)),
)  # fmt: skip
@pytest.mark.parametrize(
    "values", [[1.0, 2.0], [1, 2], [True, False], ["a", "b"]], ids=["float", "int", "bool", "text"]
)
def test_no_attribute_changes_a_number(attrs, values, tmp_path):
    """What NetCDF reads into an attribute is nothing that the result meant: it comes back, or is not saved."""
    for given in (xr.Dataset({"x": ("d", values, attrs)}), xr.Dataset({"x": ("d", values)}, attrs=attrs)):
        try:
            path = gz.save(given, tmp_path / "a.nc")
        except InputError:
            continue
        xr.testing.assert_identical(gz.load(path), given)


def test_a_pipe_is_not_waited_for(tmp_path):
    if not hasattr(os, "mkfifo"):
        pytest.skip("no pipes here")
    paths = [str(tmp_path / name) for name in ("a.nc", "a.png", "a.json", "a.toml", "a.zarr")]
    for path in paths:
        os.mkfifo(path)
    program = "import sys; from grazing.cli import main; print([main(['info', path]) for path in sys.argv[1:]])"
    done = python(program, *paths)
    assert done.stdout == f"{[2] * len(paths)}\n", done


def head_of(record, count):
    """The head of a file with so many variables of one number."""
    text = record + b" " * (-len(record) % 4)
    head = b"CDF\x02" + struct.pack(">III", 0, 0, 0)
    head += struct.pack(">III12sII", 12, 1, 12, b"grazing_file", 2, len(text)) + text
    each = (struct.pack(">I8sIIIIIq", 6, b"%06d" % i, 0, 0, 0, 6, 8, 64) for i in range(count))
    return head + struct.pack(">II", 11, count) + b"".join(each)


def test_a_head_that_takes_for_ever_is_not_read(tmp_path):
    """A hundred thousand variables took half a minute, and lists of nothing thirty times their bytes of memory."""
    for record, count in ((b"{}", 100_000), (b"[" + b"[]," * 6_000_000 + b"[]]", 0)):
        (tmp_path / "a.nc").write_bytes(head_of(record, count))
        begun = time.process_time()
        with pytest.raises(InputError, match=r"is damaged and cannot be read: it(s record)? (has|names) more than"):
            gz.load(tmp_path / "a.nc")
        assert time.process_time() - begun < 15.0
    with pytest.raises(InputError, match="at most 10000"):
        gz.save(xr.Dataset({f"x{i}": 0 for i in range(10_001)}), tmp_path / "b.nc")


@pytest.mark.parametrize("dense", [False, True])
def test_a_file_that_counts_for_ever_is_not_read(tmp_path, dense):
    """Two thousand million dimensions of no name in a file that takes no room, or some millions in one that does."""
    count = 5_000_000 if dense else 2**31 - 1
    with open(tmp_path / "a.nc", "wb") as file:
        file.write(b"CDF\x02" + struct.pack(">III", 0, 10, count))
        file.truncate(8 * count)
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    os.truncate(tmp_path / "a.png", 2**38)
    begun = time.process_time()
    with pytest.raises(InputError, match=r"names more than it holds|would take .* GB"):
        gz.load(tmp_path / "a.nc")
    with pytest.raises(InputError, match="it has more than 100000 parts"):
        gz.plot.provenance(tmp_path / "a.png")
    assert time.process_time() - begun < 10.0


CUT = """
import os, sys
import grazing as gz, grazing.io

def cutting(module, name, path):
    real = getattr(module, name)

    def call(*arguments, **options):
        os.truncate(path, 100)
        return real(*arguments, **options)

    setattr(module, name, call)

result, figure = sys.argv[1:]
cutting(grazing.io, "_record", result)
print(gz.load(result).x.values.sum())
gz.plot.provenance
cutting(sys.modules["grazing.plot.provenance"], "_pdf", figure)
print(gz.plot.provenance(figure)["title"])
"""


def test_a_file_that_another_process_cuts_off_while_it_is_read(tmp_path):
    """What is mapped into memory ends the process when it goes away."""
    gz.save(xr.Dataset({"x": ("d", np.ones(10**6))}), tmp_path / "a.nc")
    gz.plot.save(gz.plot.figure(), tmp_path / "a.pdf", title="a title")
    done = python(CUT, tmp_path / "a.nc", tmp_path / "a.pdf")
    assert (done.returncode, done.stdout) == (0, "1000000.0\na title\n"), done


def test_an_attribute_is_not_taken_for_a_part_of_the_reader(tmp_path):
    """SciPy keeps attributes among its own: mode, data, variables, ... One broke the file, others its reader."""
    from scipy.io import netcdf_file

    with netcdf_file(tmp_path / "b.nc", "w") as file:
        own = sorted({*dir(file), *dir(file.createVariable("x", "i", ()))})
    for of in ("file", "variable"):
        for name in own:
            result = xr.Dataset({"x": ("d", [1.0, 2.0])})
            (result if of == "file" else result.x).attrs = {name: 3, "kept": 1}
            with pytest.raises(InputError, match=r"rename it"):
                gz.save(result, tmp_path / "a.nc")
    assert not (tmp_path / "a.nc").exists()


# ---- tables


@pytest.mark.parametrize("dim", ["../e", "a/b", "/abs", "a\0b", "a\x1b[2J", "\ud800", "x" * 300, "a\\b", "a-b", ".."])
def test_a_dimension_names_no_other_file(dim, tmp_path):
    (tmp_path / "in").mkdir()
    result = xr.Dataset({"x": ("n", np.arange(9.0)), "y": ((dim,), np.ones(3)), "q": (("a", "b"), np.ones((2, 2)))})
    try:
        written = to_csv(result, tmp_path / "in" / "t.csv")
    except InputError:
        written = []
    assert len({*written}) == len(written)
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == {*written}
    assert all(path.parent == tmp_path / "in" for path in written)


@pytest.mark.parametrize(
    ("result", "refused"),
    [
        (xr.Dataset({"w": ("d", ["\ud800", "a"])}), "nc csv parquet"),
        (xr.Dataset({"a\ud800": ("d", [1.0])}), "nc csv parquet"),
        (xr.Dataset({3: ("d", [1.0])}), "nc csv parquet"),
        (xr.Dataset({"w": ((3,), [1.0])}), "nc csv parquet"),
        (xr.Dataset({"w": ((("a", "b"),), [1.0])}), "nc csv parquet"),
        (xr.Dataset({"w": ("d", np.array([b"a\xff"]))}), "nc parquet"),
        (xr.Dataset({"w": ("d", [1j])}), "parquet"),
        (xr.Dataset({"w": ("d", np.zeros(2, "V4"))}), "nc parquet"),
        (xr.Dataset({"w": ("d", np.array([1.0, 2.0], ">f8"))}), ""),
        (xr.Dataset({"w": ("d", np.array(["a"], np.dtypes.StringDType()))}), "nc parquet"),
        (xr.Dataset({"w": (("d", "e"), np.ones((3, 0)))}), "nc"),
        (xr.Dataset({"w": (("d", "e"), np.ones((0, 3)))}), ""),
        (xr.Dataset({"w": 1}, attrs={"a": "x\0"}), "nc"),
        (xr.Dataset({"w": 1}, attrs={"a": [[1], [1, 2]]}), "nc"),
    ],
    ids=str,
)
def test_what_a_file_cannot_hold_is_said_and_the_rest_comes_back(result, refused, tmp_path):
    for ending, write in (("nc", gz.save), ("csv", to_csv), ("parquet", gz.to_parquet)):
        if ending in refused.split():
            with pytest.raises(InputError) as said:
                write(result, tmp_path / f"a.{ending}")
            assert "\n" not in str(said.value)
        else:
            write(result, tmp_path / f"a.{ending}")
            assert ending != "nc" or gz.load(tmp_path / "a.nc").identical(result)
    assert len(list(tmp_path.iterdir())) == 3 - len(refused.split())


def test_no_message_has_the_lines_of_what_was_given(tmp_path):
    for given in (xr.DataArray([1.0]), "a\nb", np.ones((3, 3))):
        with pytest.raises(InputError) as said:
            gz.to_wav(given, tmp_path / "a.wav")
        assert len(str(said.value).splitlines()) == 1


# ---- figures


@pytest.mark.filterwarnings("ignore:Glyph")
@pytest.mark.parametrize("title", ["a\x01b", "\ud800", "a\0b", "\ufffe", "]]>", "a -- b", "λ", "📈", "a\nb"])
def test_a_figure_of_any_title_and_label_can_be_read(title, tmp_path):
    figure = gz.plot.figure(20, 20)
    if title.isprintable() or title == "a\x01b":
        figure.text(0.5, 0.5, title, gid=title)
    for ending in ("png", "pdf", "svg"):
        path = gz.plot.save(figure, tmp_path / f"a.{ending}", title=title, provenance={"a": title})
        found = gz.plot.provenance(path)
        assert found["provenance"] == {"a": title} and found["title"].isprintable()
        assert found["title"] == title or not title.isprintable()
        if ending == "svg":
            ElementTree.parse(path)
    for none in (None, 3, b"a"):
        with pytest.raises(InputError, match=r"title = .*; give text"):
            gz.plot.save(figure, tmp_path / "b.svg", title=none)


def png(*chunks):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*each) for each in (*chunks, (b"IEND", b"")))


def svg(text, before=""):
    return (
        f'<?xml version="1.0"?>{before}<svg xmlns="http://www.w3.org/2000/svg"><metadata>'
        '<rdf:RDF xmlns:dc="http://purl.org/dc/elements/1.1/" xmlns:cc="http://creativecommons.org/ns#" '
        'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><cc:Work><dc:creator>grazing</dc:creator>'
        f"<dc:description>{text}</dc:description></cc:Work></rdf:RDF></metadata></svg>"
    ).encode()


def pdf(text):
    return (
        b"%PDF-1.4\n1 0 obj\n<< /Creator (grazing) /Subject ("
        + text.encode()
        + (b") >>\nendobj\ntrailer\n<< /Info 1 0 R >>\n")
    )


TEXTS = ["[" * 100_000, "3", "null", "[]", '"x"', "9" * 10_000, '{"grazing_versions": 3}', '{"grazing_versions": [1]}',
         '{"grazing_config_sha256": 7, "grazing_recipe": []}', '{"source": {"a": 1}}', '{"grazing_recipe": "{"}',
         '{"grazing_config": {"study": []}}', '{"grazing_config": "[]"}', '{"title": [1]}',
         '{"grazing_config": {"study": "density", "map": 3, "params": 4}}',
         '{"grazing_config": {"study": "density", "map": "gap map", "params": [1]}}',
         '{"grazing_config": {"study": "density", "map": "gap map", "params": {}, "parameter": "mu", "values": []}}',
         '{"grazing_config": {"study": "density", "map": "gap map", "params": {}, "parameter": [], "values": 1}}',
         '{"grazing_config": {"study": "density", "map": "stroboscopic map", "params": {"cos99999999": 1}}}',
         '{"grazing_config": {"study": "density", "map": "gap map", "params": {}, "parameter": "mu", "values": '
         '{"first": 0, "last": 1, "count": 1e15, "sha256": ""}}}',
         '{"grazing_config": {"study": "density", "map": "gap map", "params": {}, "parameter": "mu", "values": '
         '{"first": 0, "last": 1, "count": 1000000000000, "sha256": ""}}}']  # fmt: skip


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (svg("{}").replace(b'"1.0"', b'"1.0" encoding="umf-8"'), "is damaged"),
        (svg("{}").replace(b'"1.0"', b'"1.0" encoding="rot13"'), "is damaged"),
        (svg("{}").replace(b">grazing<", b">else\n  grazing<"), "was written by"),
        (png((b"tEXt", b"Software\0" + b"\x1b[2J\n" * 9), (b"tEXt", b"Description\0{}")), "was written by"),
        (pdf("{}").replace(b"(grazing)", b"(\x1b[2J\nelse)"), "was written by"),
    ],
)
def test_what_made_a_figure_is_said_in_one_line(content, said, tmp_path):
    (tmp_path / "a").write_bytes(content)
    with pytest.raises(InputError, match=said) as error:
        gz.plot.provenance(tmp_path / "a")
    assert str(error.value).isprintable()


def figures(text):
    yield "png", png((b"tEXt", b"Software\0grazing"), (b"iTXt", b"Description\0\0\0\0\0" + text.encode()))
    yield "svg", svg(text)
    yield "pdf", pdf(text)


@pytest.mark.parametrize("text", TEXTS, ids=range(len(TEXTS)))
def test_what_a_figure_says_of_itself_is_data(text, tmp_path, capsys):
    for ending, content in figures(text):
        path = tmp_path / f"a.{ending}"
        path.write_bytes(content)
        try:
            assert isinstance(gz.plot.provenance(path)["provenance"], dict)
        except InputError:
            pass
        code = main(["info", str(path)])
        assert code in (0, 2), capsys.readouterr().err
        assert main(["info", "--config", str(path)]) == 2


BIG = """
import os, resource, sys
import grazing as gz
import xarray, scipy.io
gz.plot.provenance, gz.load
with open("/proc/self/statm") as file:
    now = int(file.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (now + 2**29, now + 2**29))
for path in sys.argv[1:]:
    try:
        (gz.load if path.endswith("nc") else gz.plot.provenance)(path)
    except gz.InputError as error:
        pass
"""


def netcdf(count):
    """A file of which many variables are the same bytes."""
    size = 10**6
    name = [struct.pack(">I4s", 3, f"{i:03}\0".encode()) for i in range(count)]
    head = b"CDF\x02" + struct.pack(">I", 0) + struct.pack(">IIII4sI", 10, 1, 1, 0, b"", 0)[:12]
    head += struct.pack(">I4sI", 1, b"d\0\0\0", size)
    record = {"dtype": "<f8", "coordinate": False, "attrs": {}}
    said = {"format": 1, "attrs": {}, "variables": {f"{i:03}": record for i in range(count)}}
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 4)
    head += struct.pack(">III12sII", 12, 1, 12, b"grazing_file", 2, len(text)) + text
    begin = len(head) + 8 + count * (8 + 4 + 4 + 8 + 4 + 4 + 8)
    each = b"".join(
        one + struct.pack(">II", 1, 0) + struct.pack(">II", 0, 0) + struct.pack(">IIq", 6, 8 * size, begin)
        for one in name
    )
    return head + struct.pack(">II", 11, count) + each, begin + 8 * size


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs the size of a process")
def test_what_a_file_announces_is_not_taken_from_memory(tmp_path):
    bomb = zlib.compress(b" " * 2**24)
    chunks = [(b"zTXt", f"Description{i}\0\0".encode() + zlib.compress(bomb + b" " * 2**24)) for i in range(50)]
    (tmp_path / "a.png").write_bytes(png((b"tEXt", b"Software\0grazing"), *chunks))
    entities = "".join(f'<!ENTITY e{i + 1} "{f"&e{i};" * 20}">' for i in range(8))
    (tmp_path / "a.svg").write_bytes(svg("&e8;", f'<!DOCTYPE svg [<!ENTITY e0 "{"x" * 1000}">{entities}]>'))
    (tmp_path / "deep.svg").write_bytes(b'<?xml version="1.0"?>' + b"<a>" * 10**6)
    with open(tmp_path / "long.svg", "wb") as file:
        file.write(b'<?xml version="1.0"?><svg>')
        file.truncate(2**33)
    with open(tmp_path / "long.pdf", "wb") as file:
        file.write(b"%PDF-1.4\ntrailer /Info 1 0 R\n1 0 obj\n<< /Creator (")
        file.truncate(2**28)
    header, length = netcdf(100)
    with open(tmp_path / "same.nc", "wb") as file:
        file.write(header)
        file.truncate(length)
    paths = [str(path) for path in sorted(tmp_path.iterdir())]
    done = subprocess.run([sys.executable, "-c", BIG, *paths], capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr[-2000:]


# ---- terminals


@pytest.mark.parametrize("evil", ["\x1b[2J\x1b]0;owned\x07", "\x9b31m", "\u202e", "\r", "\x08" * 9, "\nagain:  rm"])
def test_no_text_of_a_file_moves_the_cursor(evil, tmp_path, capsys):
    config = json.dumps({"study": evil, "map": evil})
    name = evil.encode("latin-1", "replace").decode("latin-1")  # names in a NetCDF file
    result = xr.Dataset({f"x{name}": (f"d{name}", [1.0], {"long_name": evil})})
    result.attrs = {"title": evil, "source": evil, "grazing_config": config, "grazing_recipe": json.dumps({evil: evil}),
                    "grazing_versions": json.dumps({evil: evil})}  # fmt: skip
    gz.save(result, tmp_path / "a.nc")
    text = json.dumps({"grazing_config": {"study": evil}, "source": evil, "grazing_versions": {evil: evil}})
    for ending, content in figures(text):
        (tmp_path / f"a.{ending}").write_bytes(content)
    (tmp_path / "a.toml").write_text(f'study = "density"\n{json.dumps(evil)} = {json.dumps(evil)}\n')
    for path in sorted(tmp_path.iterdir()):
        for command in (["info"], ["info", "--json"], ["plot", "-o", str(tmp_path / "b.png")], ["config", "show"]):
            main([*command, str(path)])
            said = "".join(capsys.readouterr())
            assert all(letter.isprintable() or letter == "\n" for letter in said), (command, path.name, said)
            assert "\nagain:  rm" not in said or path.suffix == ".toml"


@pytest.mark.skipif(os.name != "posix", reason="names that other systems do not take")
@pytest.mark.parametrize(
    "name", ["a\nerror: b", "a\x1b[2J", "\u202eabc", "a\r", "\udcff", "[x]", "[1]", "%s{0}", "#h", "a,b=c", "a'b"]
)
def test_no_name_of_a_file_moves_the_cursor_or_is_taken_for_anything_else(name, tmp_path, capsys, monkeypatch):
    """The names of what was written came out as they are, and -o took one in brackets for a list in JSON."""
    monkeypatch.chdir(tmp_path)
    os.rename(gz.save(gz.trajectory(gz.pinball(V=0.4), (0.1, 0.0), until=3.0), tmp_path / "a.nc"), f"{name}.nc")
    motion = ["trajectory", "--state", "0.1,0", "--until", "3", "-q", "-o", f"{name}.svg"]
    for command in (motion, ["plot", f"{name}.nc", "-o", f"{name}.pdf"], ["export", f"{name}.nc", f"{name}.csv"]):
        assert main(command) == 0, capsys.readouterr().err
        last = capsys.readouterr().out.splitlines()[-1]
        assert last.startswith("written: ") and last.isprintable()
    assert {file.name for file in tmp_path.iterdir()} == {
        f"{name}{end}" for end in (".nc", ".svg", ".pdf", ".csv", "-impact.csv")
    }


# ---- results that are drawn, configurations that are printed


def test_drawing_a_result_that_says_anything_is_a_sentence(tmp_path, capsys):
    """Variables dropped, made texts or not finite, attributes of any kind: drawn, or refused in a sentence."""
    G = gz.gap_map(lam=0.8, mu=0.05, l=0.1)
    whole = {
        "lyapunov": gz.lyapunov(G, "mu", np.linspace(0.0, 0.3, 4), starts=2),
        "coexistence": gz.coexistence(G, "mu", np.linspace(0.0, 0.3, 4), starts=3),
    }
    refused = 0
    for result in whole.values():
        cases = [result.drop_vars(name) for name in [*result.variables][:6]]
        cases += [
            result.assign({name: (result[name].dims, np.full(result[name].shape, value))})
            for name in [*result.data_vars][:6]
            for value in ("$\\frac{", np.nan)
        ]
        cases += [result.assign_attrs({"grazing_config": said}) for said in ("no JSON", "[1]", "[" * 5000)]
        for case in cases[::2]:
            gz.save(case, tmp_path / "a.nc")
            code = main(["plot", str(tmp_path / "a.nc"), "-o", str(tmp_path / "a.png")])
            error = capsys.readouterr().err
            assert code in (0, 2) and "unexpected" not in error
            refused += code == 2
    assert refused > 3


@pytest.mark.filterwarnings("ignore:(?s).*was not run")
def test_what_a_configuration_says_makes_no_line_and_moves_no_cursor(tmp_path, capsys):
    from grazing.config import toml_of

    text = "/a\x1b[2J\x9b\u202e\x7f\n/b.py:P"
    (tmp_path / "a.toml").write_text(toml_of({"study": "diagram", "map": text, "vary": {"d": "0:1:3"}}))
    assert main(["config", "show", str(tmp_path / "a.toml")]) == 0
    said = capsys.readouterr().out
    assert all(letter.isprintable() or letter == "\n" for letter in said)
    assert toml_of({"map": text}).count("\n") == 1
    (tmp_path / "b.toml").write_text('study = "diagram"\n"a\\nerror: all is lost\\u001b" = 1\n"c" = 2\n')
    assert main(["config", "show", str(tmp_path / "b.toml")]) == 2
    assert not [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: all")]


# ---- results that were changed


@pytest.mark.parametrize(
    ("change", "call"),
    [
        (lambda result: result.assign_coords(t=result.t + 1j), gz.sample),
        (lambda result: result.assign_coords(t=result.t.astype(str)), gz.sample),
        (lambda result: result.assign(v=result.v[0]), gz.sample),
        (lambda result: result.isel(t=slice(0)), gz.sample),
        (
            lambda result: gz.sample(result, 10.0).assign_attrs(sample_rate="10"),
            lambda result, _rate: gz.spectrum(result),
        ),
        (lambda result: result.u.assign_attrs(low="x", units="m").to_dataset(), lambda result, _rate: in_mm(result)),
        (lambda result: result.u.assign_attrs(units="m, m").to_dataset(), lambda result, _rate: in_mm(result)),
        (
            lambda result: xr.Dataset({"t": (("t", "n"), np.ones((3, 2))), "u": ("t", np.ones(3))}),
            lambda result, _rate: gz.to_dataframe(result),
        ),
    ],
)
def test_a_result_that_was_changed_is_a_sentence(change, call):
    result = change(gz.trajectory(gz.pinball(V=0.4), (0.1, 0.0), until=3.0))
    with pytest.raises(InputError) as said:
        call(result, 10.0)
    assert "\n" not in str(said.value)


def in_mm(result):
    return gz.in_units(result, "mm")


def test_attributes_that_are_no_texts_are_not_told(tmp_path, capsys):
    result = gz.trajectory(gz.pinball(V=0.4), (0.1, 0.0), until=3.0)
    odd = dict.fromkeys(("title", "source", "grazing_config_sha256", "grazing_versions"), np.array([1.0, 2.0]))
    gz.save(result.assign_attrs(odd), tmp_path / "a.nc")
    assert main(["info", str(tmp_path / "a.nc")]) == 0
    assert "made by" not in capsys.readouterr().out
