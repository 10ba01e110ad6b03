"""What is no whole number is refused, not rounded."""

import pytest

from grazing.cli import main

COMMANDS = (
    ("--port", "explore --no-open --port {}"),
    ("--threads", "density mu=0:1:20 --map gap --threads {}"),
    ("--threads", "sweep run none.toml none.zarr --threads {}"),
    ("--workers", "sweep run none.toml none.zarr --cluster local --workers {}"),
)


@pytest.mark.parametrize("written", ["1.5", "2.0", "many", "1e3"])
@pytest.mark.parametrize(("option", "command"), COMMANDS)
def test_a_fraction_is_refused(option, command, written, capsys):
    assert main(command.format(written).split()) == 2
    assert f"Invalid value for {option}: {written!r} is no whole number." in " ".join(capsys.readouterr().err.split())
