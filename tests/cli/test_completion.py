"""Completion in a real bash: options, words that are allowed, and names of files."""

import shutil
import subprocess

import pytest

from grazing.cli.app import app

pytestmark = pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
# COMP_WORDS as bash makes them: `=` stands alone between the two words around it
ASK = """
source completion
COMP_WORDS=("$@"); COMP_CWORD=$(( $# - 1 ))
_grazing
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("completion")
    for name in ("study.toml", "a result.nc", "orbit.json", "own.py"):
        (folder / name).touch()
    (folder / "store.zarr").mkdir()
    (folder / "completion").write_text(app.generate_completion(prog_name="grazing", shell="bash"))
    return folder


def offered(folder, *words):
    command = ["bash", "--norc", "-c", ASK, "bash", "grazing", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return set(done.stdout.split("\n")) - {""}


@pytest.mark.parametrize(
    ("words", "some"),
    [
        (["diagram", "--law", ""], {"active", "newton", "triggered"}),
        (["diagram", "--law", "=", "n"], {"newton"}),
        (["chart", "--map", "ga"], {"gap"}),
        (["density", "--arithmetic", ""], {"fast", "strict"}),
        (["graph", "--order", ""], {"none", "lowest"}),
        (["paper", "--size", ""], {"small", "large"}),
        (["sweep", ""], {"run", "resume", "verify"}),
        (["dia"], {"diagram"}),
        (["diagram", "--dump"], {"--dump-config"}),
        (["diagram", "--config", "st"], {"study.toml", "store.zarr"}),
        (["branch", "-o", "a"], {"a result.nc"}),
        (["trajectory", "--model", "ow"], {"own.py"}),
        (["plot", "a"], {"a result.nc"}),
        (["info", "stu"], {"study.toml"}),
        (["config", "show", "stu"], {"study.toml"}),
        (["sweep", "run", "stu"], {"study.toml"}),
        (["sweep", "run", "study.toml", "sto"], {"store.zarr"}),
        (["sweep", "resume", "sto"], {"store.zarr"}),
        (["orbit", "check", "orb"], {"orbit.json"}),
        (["orbit", "--save", "orb"], {"orbit.json"}),
        (["explore", "--out", "sto"], {"store.zarr"}),
        (["paper", "--out", "sto"], {"store.zarr"}),
    ],
)
def test_words_and_files_are_offered(folder, words, some):
    assert some <= offered(folder, *words)


def test_every_option_with_choices_or_a_file_offers_them(folder):
    """Whatever help shows as a choice or a FILE is completed: no option is added without."""
    from cyclopts.completion._base import CompletionAction, extract_completion_data, get_completion_action

    seen = set()
    for data in extract_completion_data(app).values():
        for argument in data.arguments:
            metavar = str(argument.parameter.metavar or argument.name)
            if "|" in metavar and metavar.islower():
                seen.add(argument.name)
                assert argument.get_choices(force=True) == tuple(metavar.split("|")), argument.name
            if metavar in ("FILE", "RESULT", "CONFIG", "STORE", "CERTIFICATE", "FILE|FOLDER"):
                seen.add(metavar)
                assert get_completion_action(argument.hint) is CompletionAction.FILES, argument.name
    assert {"--law", "--arithmetic", "FILE", "RESULT", "CONFIG", "STORE"} <= seen
