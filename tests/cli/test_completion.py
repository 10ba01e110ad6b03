"""Completion in a real bash, zsh and fish: options, words that are allowed, and names of files."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from grazing.cli.app import app

# COMP_WORDS as bash makes them: `=` stands alone between the two words around it
ASK = """
source completion
COMP_WORDS=("$@"); COMP_CWORD=$(( $# - 1 ))
_grazing
printf '%s\\n' "${COMPREPLY[@]}"
"""
SCRIPTS = {"bash": "completion", "zsh": "functions/_cyclopts_grazing", "fish": "completion.fish"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("completion")
    for name in ("study.toml", "a result.nc", "orbit.json", "own.py"):
        (folder / name).touch()
    (folder / "store.zarr").mkdir()
    (folder / "functions").mkdir()
    for shell, name in SCRIPTS.items():  # each takes a second or two
        (folder / name).write_text(app.generate_completion(prog_name="grazing", shell=shell))
    return folder


def in_bash(folder, *words):
    command = ["bash", "--norc", "-c", ASK, "bash", "grazing", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout


def in_zsh(folder, *words):
    for name in ("offered", "ready", "ended"):
        (folder / name).unlink(missing_ok=True)
    (folder / "offered").touch()
    line = " ".join(["grazing", *words]).replace(" = ", "=")
    command = ["zsh", "-f", str(Path(__file__).with_name("completed.zsh")), "functions", line]
    subprocess.run(command, cwd=folder, capture_output=True, stdin=subprocess.DEVNULL, check=True, timeout=60)
    assert (folder / "ended").exists()
    return (folder / "offered").read_text().replace("\\ ", " ")


def in_fish(folder, *words):
    line = " ".join(["grazing", *words]).replace(" = ", "=")
    command = ["fish", "--no-config", "-c", "source completion.fish; complete -C $argv[1]", line]
    env = {**os.environ, "HOME": str(folder), "XDG_DATA_HOME": str(folder)}
    said = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True, env=env).stdout
    found = [row.partition("\t")[0].rstrip("/") for row in said.splitlines()]
    return "\n".join(one.rpartition("=")[2] if "=" in line else one for one in found)


SHELLS = {"bash": in_bash, "zsh": in_zsh, "fish": in_fish}


def offered(shell, folder, *words):
    if shutil.which(shell) is None:
        pytest.skip(f"needs {shell}")
    return {one.strip() for one in SHELLS[shell](folder, *words).split("\n")} - {""}


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize(
    ("words", "some"),
    [
        (["diagram", "--law", ""], {"active", "newton", "triggered"}),
        (["diagram", "--law", "=", "n"], {"newton"}),
        (["chart", "--map", "ga"], {"gap"}),
        (["chart", "--map", ""], {"gap", "own.py"}),
        (["chart", "--map", "=", "ow"], {"own.py"}),
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
        (["plot", "a.nc", "--curves", "a"], {"a result.nc"}),
        (["chart", "--curves", "a"], {"a result.nc"}),
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
def test_words_and_files_are_offered(shell, folder, words, some):
    assert some <= offered(shell, folder, *words)


def typed_in_bash(folder, line):
    """Type a line and a tab into an interactive bash, then the end of the line; return what the command gets."""
    import pty
    import select

    got, ready = folder / "got", b"ready> "
    (folder / "rc").write_text(
        f"PS1='{ready.decode()}'; bind 'set bell-style none'; set +o history; source completion; cd odd\n"
        "grazing() { printf '%s\\0' \"$@\" > ../part; mv ../part ../got; }\n"
    )
    process, terminal = pty.fork()
    if process == 0:
        os.chdir(folder)
        os.execvpe("bash", ["bash", "--noprofile", "--rcfile", "rc", "-i"], {**os.environ, "LC_ALL": "C.UTF-8"})
    said = b""
    for ready_for, sent in ((ready, f"grazing {line}\t".encode()), (b"grazing", b" \n")):
        while ready_for not in said and select.select([terminal], [], [], 20)[0]:
            said += os.read(terminal, 10_000)
        os.write(terminal, sent)
    for _ in range(1000):
        if got.exists():
            break
        if select.select([terminal], [], [], 0.02)[0]:
            os.read(terminal, 10_000)
    os.close(terminal)
    os.waitpid(process, 0)
    found = got.read_bytes().decode().split("\0")[:-1]
    got.unlink()
    return found


@pytest.mark.skipif(shutil.which("bash") is None or not hasattr(os, "fork"), reason="needs bash and a terminal")
@pytest.mark.parametrize(
    ("begun", "name"),
    [("info \\$", "$(touch ran).nc"), ("info \\[", "[a].nc"), ("info two", "two\nlines.nc"), ("info \\*", "*.nc"),
     ("info q", "q'u\"o`t`e;touch ran.nc"), ("chart --map my", "my map.py"), ("chart --map x", "x$(touch ran).py")],
)  # fmt: skip
def test_a_file_of_any_name_is_completed_to_itself_and_nothing_is_run(folder, begun, name):
    """[a].nc was completed to a.nc, *.nc to all files, and a name of two lines or words to the first of them."""
    odd = folder / "odd"
    odd.mkdir(exist_ok=True)
    for one in ("a.nc", "b.nc", name):
        (odd / one).touch()
    assert typed_in_bash(folder, begun)[-1] == name
    (odd / name).unlink()
    assert {one.name for one in odd.iterdir()} == {"a.nc", "b.nc"}


@pytest.mark.parametrize("shell", SHELLS)
def test_what_begins_otherwise_is_not_offered(shell, folder):
    assert offered(shell, folder, "chart", "--map", "ga") == {"gap"}
    assert "trajectory" not in offered(shell, folder, "dia")


def quotes_close(script):
    """Whether every quote of a script is closed."""
    quote, i = "", 0
    while i < len(script):
        c = script[i]
        if c == "\\" and quote != "'":
            i += 1
        elif quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c == "#" and script[i - 1] in " \n":
            i = script.index("\n", i)
        i += 1
    return not quote


@pytest.mark.parametrize("shell", SHELLS)
def test_the_script_is_whole_in_every_shell_and_offers_what_the_others_do(shell, folder):
    """Without the shells: every command, option and word stands in each script, and its quotes close."""
    script = (folder / SCRIPTS[shell]).read_text()
    assert quotes_close(script) and not quotes_close(script[:-2] + "'")
    for one in ("diagram", "basins", "install-completion", "active", "newton", "normal-form", "*.py", "dump-config"):
        assert one in script
    if shutil.which(shell):
        checked = subprocess.run([shell, "-n", "/dev/stdin"], input=script, text=True, capture_output=True)
        assert checked.returncode == 0 and not checked.stderr


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
            if metavar in ("FILE", "RESULT", "CONFIG", "STORE", "CERTIFICATE", "FILE|FOLDER", "LIST|FILE"):
                seen.add(metavar)
                assert get_completion_action(argument.hint) is CompletionAction.FILES, argument.name
    assert {"--law", "--arithmetic", "FILE", "RESULT", "CONFIG", "STORE"} <= seen
