"""Configurations as TOML and as JSON Schema."""

import json
import re
import tomllib
from pathlib import Path

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
