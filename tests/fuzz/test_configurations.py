"""Configurations at random: checked, written again as a command, or refused in plain words and with exit code 2."""

import random

import pytest

from grazing.cli import main
from grazing.config import checked, command_of, load_config, toml_of
from tests.fuzz.configurations import configuration, text_of
from tests.fuzz.extremes import defect


def trial(seed, file):
    """Return what is wrong with what becomes of a configuration."""
    chosen = random.Random(seed)
    config = configuration(chosen)
    file.write_bytes(text_of(chosen, config))

    def run():
        recipe = load_config(file)
        assert checked(recipe) == recipe
        assert command_of(recipe)
        file.write_text(toml_of(recipe), encoding="utf-8")
        assert load_config(file) == recipe

    wrong = defect(lambda: checked(config)) or defect(run)
    return f"seed {seed}: {config!r:.600}\n    {wrong}" if wrong else None


def commanded(seed, file, capsys):
    """Return what is wrong with what the command says of a configuration."""
    chosen = random.Random(seed)
    file.write_bytes(text_of(chosen, configuration(chosen)))
    ended = []
    wrong = defect(lambda: ended.append(main(["config", "show", str(file)])))
    said = capsys.readouterr().err
    if wrong is None and (ended[0] not in (0, 2) or "unexpected" in said or "Traceback" in said):
        wrong = f"exit code {ended[0]}: {said[:300]}"
    return f"seed {seed}: {file.read_bytes()[:600]!r}\n    {wrong}" if wrong else None


def test_configurations_are_taken_or_refused(tmp_path):
    wrong = [found for seed in range(400) if (found := trial(seed, tmp_path / "study.toml"))]
    assert not wrong, "\n".join(wrong)


def test_the_command_says_what_is_wrong_with_exit_code_2(tmp_path, capsys):
    wrong = [found for seed in range(100) if (found := commanded(seed, tmp_path / "study.toml", capsys))]
    assert not wrong, "\n".join(wrong)


@pytest.mark.long
def test_very_many_configurations_are_taken_or_refused(tmp_path, capsys):
    wrong = [found for seed in range(1000, 7000) if (found := trial(seed, tmp_path / "study.toml"))]
    wrong += [found for seed in range(7000, 8000) if (found := commanded(seed, tmp_path / "study.toml", capsys))]
    assert not wrong, "\n".join(wrong)
