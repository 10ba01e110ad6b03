"""Configurations as TOML and as JSON Schema."""

import json
import os
import re
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grazing import InputError
from grazing.config import checked, json_schema, load_config, toml_of

VALUES = st.recursive(
    st.one_of(st.integers(-(2**60), 2**60), st.floats(allow_nan=False, allow_infinity=False), st.text(max_size=20)),
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=8,
)


@given(
    st.dictionaries(st.text(min_size=1, max_size=8), VALUES, max_size=4),
    st.dictionaries(st.text(max_size=8), VALUES, min_size=1, max_size=4),
)
def test_toml_comes_back_as_it_was(plain, table):
    config = {**{f"k{name}": value for name, value in plain.items()}, "table": table}
    assert tomllib.loads(toml_of(config)) == config


def test_numbers_of_numpy_come_back_and_what_toml_cannot_write_is_refused():
    """Text was made of them: np.float64(0.1), "b'chart'", "None"."""
    table = {"d": np.float64(0.1), "N": np.int64(3), "on": np.bool_(True), "row": np.array([1.0, 2.0]), "p": Path("a")}
    plain = {"d": 0.1, "N": 3, "on": True, "row": [1.0, 2.0], "p": "a"}
    assert tomllib.loads(toml_of({**table, "table": table})) == {**plain, "table": plain}
    for wrong in (b"chart", None, 1j, {1}, [None]):
        with pytest.raises(InputError, match="give numbers, texts, lists and tables"):
            toml_of({"study": wrong})


def test_a_configuration_comes_back_as_it_was(tmp_path):
    config = checked(
        {
            "study": "chart", "map": "discontinuity", "order": "full", "law": "triggered",
            "parameters": {"cos": [1.0, 0.25], "trigger": 0.1, "alpha": 1e-17, "k": 1, "omega": 2, "r": 1},
            "vary": {"d": "0.05:0.16:40", "V": [0.1, 0.2]},
            "settings": {"starts": [[0.1, -0.2]], "box": [[0.0, 0.1], [-1.0, 1.0]]},
        }
    )  # fmt: skip
    (tmp_path / "a.toml").write_text(toml_of(config))
    again = load_config(tmp_path / "a.toml")
    assert again == config
    assert list(again["vary"]) == ["d", "V"]


def test_errors_in_a_file_name_it_and_their_paths(tmp_path):
    file = tmp_path / "study.toml"
    file.write_text('study = "diagram"\n[parameters]\nr = 2\n[vary]\nd = "0:1"\n[settings]\nkeap = 1\n')
    with pytest.raises(InputError) as error:
        load_config(file)
    lines = str(error.value).splitlines()
    assert lines[0] == f"{file} has 3 errors:"
    assert [line.split()[0].rstrip(":") for line in lines[1:]] == ["parameters.r", "settings.keap", "vary.d"]
    file.write_text('study = "diagram"\n[vary]\nd = "0:1:2"\n[parameters]\nr = 2\n')
    with pytest.raises(InputError) as error:
        load_config(file)
    assert str(error.value) == f"{file}: parameters.r = 2; allowed is 0 <= r <= 1 (coefficient of restitution)"


def test_syntax_has_a_line(tmp_path):
    file = tmp_path / "study.toml"
    file.write_text('study = "diagram"\nmap = stroboscopic\n')
    with pytest.raises(InputError, match=r"is not TOML: .*line 2"):
        load_config(file)
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="give a TOML file in UTF-8"):
        load_config(file)
    file.write_text('study = "diagram"\n[parameters]\nd = ' + "1" * 5000)
    with pytest.raises(InputError, match=r"has a number of thousands of digits$"):  # and nothing of Python's settings
        load_config(file)
    with pytest.raises(InputError, match="there is no file"):
        load_config(tmp_path / "missing.toml")
    with pytest.raises(InputError, match="cannot be read"):
        load_config(tmp_path)


def test_the_schema_says_ranges_meanings_and_defaults():
    schema = json_schema()
    json.dumps(schema)
    parameters = schema["$defs"]["Parameters"]["properties"]
    assert parameters["r"]["minimum"] == 0.0 and parameters["r"]["maximum"] == 1.0
    assert parameters["omega"]["exclusiveMinimum"] == 0.0 and parameters["omega"]["default"] == 2.2
    assert "coefficient of restitution" in parameters["r"]["description"]
    assert set(schema["discriminator"]["mapping"]) >= {"diagram", "chart", "basins", "trajectory"}
    settings = schema["$defs"]["DiagramSettings"]["properties"]
    assert settings["transient"]["default"] == 200 and settings["transient"]["minimum"] == 0
    assert schema["$defs"]["DiagramConfig"]["additionalProperties"] is False


def test_the_example_in_the_documentation_is_a_configuration(tmp_path):
    page = Path(__file__).parents[2] / "docs" / "command-line.md"
    (example,) = re.findall(r"^```toml\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    (tmp_path / "chart.toml").write_text(example)
    found = load_config(tmp_path / "chart.toml")
    assert found["vary"] == {"d": "0.05:0.16:400", "V": "0:0.4:400"} and found["parameters"]["cos"] == [1.0, 0.2]


# ---- files that are no configuration, or would take for ever


def refused(file):
    """What is said of a configuration, also by a call that trusts the code it names: then files are looked for."""
    with pytest.raises(InputError) as error:
        load_config(file, code="trust")
    assert len(str(error.value)) < 20_000
    return str(error.value)


@pytest.mark.skipif(not Path("/dev/zero").exists() or not hasattr(os, "mkfifo"), reason="POSIX devices and pipes")
def test_what_has_no_end_is_not_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    for file in (tmp_path / "pipe.toml", "/dev/zero"):
        assert "is a device or a pipe" in refused(file)
    large = tmp_path / "large.toml"
    with large.open("wb") as hole:
        hole.truncate(2**40)
    assert "larger than 2 MiB" in refused(large)


def test_a_mark_of_the_byte_order_is_no_syntax(tmp_path):
    file = tmp_path / "study.toml"
    file.write_bytes(b'\xef\xbb\xbfstudy = "diagram"\n[vary]\nd = "0:1:2"\n')
    assert load_config(file)["vary"] == {"d": "0:1:2"}


@pytest.mark.parametrize(
    "text",
    [
        "study = " + "[" * 2000,
        "study = " + "[" * 2000 + "]" * 2000,
        "study = " + "{a=" * 2000 + "1" + "}" * 2000,
        "study" + ".a" * 2000 + " = 1",
        "[" + "a." * 2000 + "a]",
        "study = " + "9" * 5000,
        "[parameters]\nd = 0x" + "f" * 5000,
        "study = 1979-13-45",
        'map = "a\\u0000b.py:P"\nstudy = "diagram"',
        f'map = "{"a" * 5000}.py:P"\nstudy = "diagram"',
        'model = "."\nstudy = "diagram"\n"" = 1',
    ],
)
def test_a_file_that_was_made_to_break_the_reader_is_refused(tmp_path, text):
    file = tmp_path / "study.toml"
    file.write_text(text)
    assert str(file) in refused(file)


def test_links_in_a_circle_are_no_file(tmp_path):
    for name in ("circle.py", "circle.toml"):
        (tmp_path / name).symlink_to(name)
    assert "cannot be read" in refused(tmp_path / "circle.toml")
    file = tmp_path / "study.toml"
    for key in ("map", "model"):
        file.write_text(f'study = "diagram"\n{key} = "circle.py:P"\nvary.a = "0:1:2"\n')
        assert "circle.py" in refused(file)


@pytest.mark.parametrize("form", ["[k{}]\n", "k{}=1\n", "settings.k{}=1\n", "[objects.k{}]\n"])
def test_a_table_of_very_many_keys_is_refused_by_their_number(tmp_path, form):
    """Something was said of each: that took up to ten seconds."""
    file = tmp_path / "study.toml"
    file.write_text("".join(map(form.format, range(11_000))))
    assert refused(file) == f"{file} has a table of 11000 keys; allowed are 10000"


@pytest.mark.parametrize("table", ["", "[parameters]\n", "[settings]\n", "[vary]\n"])
def test_very_many_errors_are_counted_and_not_listed(tmp_path, table):
    file, many = tmp_path / "study.toml", 5000
    file.write_text('study = "diagram"\n' + table + "".join(f"k{i} = {i}\n" for i in range(many)))
    lines = refused(file).splitlines()
    assert len(lines) < 30 and lines[-1].strip().startswith("... and ")
    assert int(re.search(r"has (\d+) errors", lines[0])[1]) >= many


def test_a_configuration_that_holds_itself_is_refused():
    config = {"study": "diagram"}
    config["settings"] = config
    with pytest.raises(InputError, match="in each other"):
        checked(config)


@pytest.mark.parametrize("study", ["", "study = [1]\n", "study = 1\n", 'study = "diagrm"\n', 'study = "trajectory"\n'])
@pytest.mark.parametrize("wrong", ["[parameters]\ncos = 1", "[settings]\nfixed = 1", "[settings]\nlocus = 1",
                                   "[settings]\nbox = 1", "[parameters]\nsin = 'a'", "[vary]\nd = 1"])  # fmt: skip
def test_what_stands_beside_an_error_is_judged_by_values_that_are_sound(tmp_path, study, wrong):
    file = tmp_path / "study.toml"
    file.write_text(study + wrong)
    assert str(file) in refused(file)


M = 2**20


@pytest.mark.parametrize(
    "text",
    [
        "a." * M + "b = 1", "[" + "a." * M + "b]", "x = {" + "a . " * (M // 2) + "b = 1}", "'a'." * (M // 2) + "b = 1",
        '"\\""."\\"".' * (M // 6) + "b = 1", 'x = {a = """ " """, ' + "k." * (M - 40) + 'k = " "}',
        "x = {a = ''' ' ''', " + "k." * (M - 40) + "k = ' '}", "# '\"\n" + "k." * (M - 9) + "k = 1",
        "study = 'diagram'\nmap = '" + "a/" * (M - 40) + "b.py:P'",
        "study = 'diagram'\nmodel = '" + "../" * 600_000 + ".py:P'",
        "study = 'diagram'\nparameters.cos = [" + "1," * (M - 40) + "1]",
    ],
    ids=["key", "table", "inline", "quoted", "escaped", "behind a text", "behind another", "behind a comment", "file",
         "above", "amplitudes"],
)  # fmt: skip
def test_two_megabytes_of_anything_are_refused_in_time(tmp_path, text):
    """Dotted keys took TOML's reader hours, the name of a file three minutes, amplitudes one and 4 GB."""
    file = tmp_path / "study.toml"
    file.write_text(text if text.startswith("study") else text + "\n")
    begun = time.process_time()
    assert str(file) in refused(file)
    assert time.process_time() - begun < 15.0


def test_dots_that_are_none_of_a_key_are_read(tmp_path):
    file = tmp_path / "study.toml"
    many = ", ".join(["0.1"] * 99)
    file.write_text(
        f'# {"a." * 99}\nstudy = "diagram"\nvary.d = [{many}]\n"map" = "{"../" * 40}x.py:P" # {"a." * 40}\n'
    )
    assert len(load_config(file)["vary"]["d"]) == 99


@pytest.mark.parametrize("name", ["a\0b", "\ud800", "a" * 5000])
@pytest.mark.parametrize("key", ["table", "map", "model", "curves"])
def test_what_cannot_be_the_name_of_a_file_is_refused_in_a_sentence(key, name):
    """A zero byte or half a letter, which a recipe in a file may name as its table, came out as a ValueError."""
    for study in ("trajectory", "launches", "diagram", None):
        with pytest.raises(InputError) as said:
            checked({"study": study, key: name})
        assert "\0" not in str(said.value)
