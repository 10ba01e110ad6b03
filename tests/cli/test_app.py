"""The command line, its report replaced by a stand-in: what it parses, prints and returns."""

import json
import os
import sys
import types
import typing
import warnings
from pathlib import Path

import pytest

from grazing import InputError, OutsideForm, UserCodeError, __version__
from grazing.cli import main
from grazing.cli.app import _once
from grazing.cli.paper import paper
from grazing.paper import FIGURES

SUMMARY = {
    "folder": "a", "figures": ["1.6"], "size": "paper", "files": ["claims.json", "figure-1.6.png", "index.html"],
    "claims": 3, "verdicts": {"agrees": 2, "corrected": 1, "differs": 0}, "differs": [],
}  # fmt: skip


@pytest.fixture
def report(monkeypatch):
    """The stand-in; `calls` has its arguments, `raises` what it is to raise."""
    module = types.ModuleType("grazing.paper.report")
    module.calls, module.raises, module.warns = [], None, None

    def run(**arguments):
        module.calls.append(arguments)
        arguments["progress"](1, 2, "Figure 1.6 λ")
        if module.warns:
            warnings.warn(module.warns, RuntimeWarning, stacklevel=1)
        if module.raises is not None:
            raise module.raises
        return dict(SUMMARY)

    module.report = run
    monkeypatch.setitem(sys.modules, "grazing.paper.report", module)
    monkeypatch.delenv("GRAZING_DEBUG", raising=False)
    return module


def asked(report):
    (call,) = report.calls
    return {name: value for name, value in call.items() if name != "progress"}


# ---- what is parsed


def test_without_options_all_figures_are_asked_for(report):
    assert main(["paper"]) == 0
    assert asked(report) == {"out": "out/paper", "figures": None, "size": "paper"}


@pytest.mark.parametrize(
    "tokens",
    [
        ["--figures", "1.6,3.2"],
        ["--figures=1.6,3.2"],
        ["--figures", "1.6", "--figures", "3.2"],
        ["--figures", "1.6", "3.2"],
        ["--figures", " 1.6 ,, 3.2,1.6"],
    ],
)
def test_figures_can_be_named_in_every_usual_way(report, tokens):
    assert main(["paper", *tokens, "--size", "small", "--out", "a folder/b"]) == 0
    assert asked(report) == {"out": "a folder/b", "figures": ["1.6", "3.2"], "size": "small"}


def test_sizes_are_those_of_the_report():
    from grazing.paper.run import SIZES

    assert typing.get_args(typing.get_type_hints(paper)["size"]) == tuple(SIZES)


# ---- what is printed


def test_json_is_one_object_and_progress_goes_elsewhere(report, capsys):
    assert main(["paper", "--json"]) == 0
    out, err = capsys.readouterr()
    printed = json.loads(out)
    assert printed.pop("seconds") >= 0.0
    assert printed == SUMMARY
    assert out.count("\n") == 1
    assert "[1/2]" in err and "Figure 1.6" in err


def test_the_summary_in_words(report, capsys, monkeypatch):
    assert main(["paper", "-q"]) == 0
    out = capsys.readouterr().out
    assert "claims:  3 (agree: 2, corrected: 1, differ: 0)\n" in out
    assert f"{Path('a') / 'index.html'} and 2 more files" in out
    assert "differ:  " not in out
    monkeypatch.setitem(SUMMARY, "differs", ["graze"])
    assert main(["paper", "-q"]) == 0
    assert "differ:  graze\n" in capsys.readouterr().out


def test_quiet_shows_no_progress(report, capsys):
    assert main(["paper", "--quiet"]) == main(["paper", "-q"]) == 0
    out, err = capsys.readouterr()
    assert out and not err


def test_warnings_that_differ_in_numbers_alone_are_one():
    said = [
        "the law f returned nan for v_minus = -0.25; 3 of 8 orbits ended there",
        "the law f returned -1e-05 for v_minus = -7; 4 of 8 orbits ended there",
        "the law f2 returned nan for v_minus = -0.25; 3 of 8 orbits ended there",
        "another warning",
        "the law f returned inf for v_minus = -2.5e+01; 8 of 8 orbits ended there",
    ]
    code = f"import warnings; [warnings.warn(each) for each in {said}]"
    show = _once()
    shown = []
    with warnings.catch_warnings(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("builtins.print", lambda text, **_more: shown.append(text))
        warnings.simplefilter("always")
        warnings.showwarning = show
        exec(code)
    assert shown == [f"warning: {said[i]}" for i in (0, 2, 3)]


def test_a_warning_is_one_line(report, capsys):
    report.warns = "kernels go elsewhere"
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert main(["paper", "-q"]) == 0
    assert capsys.readouterr().err == "warning: kernels go elsewhere\n"


def test_help_lists_all(capsys):
    assert main([]) == main(["--help"]) == main(["-h"]) == 0
    assert "paper" in capsys.readouterr().out
    assert main(["paper", "--help"]) == 0
    out = capsys.readouterr().out
    for word in ("--out", "--figures", "--size", "--json", "--quiet", "small", "out/paper", "Exit codes", *FIGURES):
        assert word in out
    assert "--no-" not in out and "--empty-" not in out


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"grazing {__version__}\n"


# ---- what goes wrong


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        (["papr"], ['"papr"', 'Did you mean "paper"', "grazing --help"]),
        (["--foo"], ['"--foo"', "grazing --help"]),
        (["paper", "--figure", "1.6"], ["--figure", "Did you mean --figures", "grazing paper --help"]),
        (["paper", "--sise", "small"], ["--sise", "Did you mean --size"]),
        (["paper", "--no-json"], ["--no-json"]),
        (["paper", "--size", "tiny"], ["tiny", "small", "paper", "large"]),
        (["paper", "--out"], ["--out needs a value behind it"]),
        (["paper", "1.6"], ["Unexpected argument '1.6'", "grazing paper --help"]),
        (["paper", "--out="], ["--out is empty", "out/paper"]),
        (["paper", "--figures", ","], ["--figures is empty", "1.6"]),
        (["paper", "--figures"], ["--figures is empty", "1.6"]),
        (["diagram", "d=0:1:3", "-o", "--quiet"], ["-o needs a value behind it. 'grazing diagram"]),
        (["paper", "--json=perhaps"], ["--json is 'perhaps': it takes no value"]),
        (["sweep", "verify", "a.zarr", "--seed", "1e-4"], ["Invalid value for --seed: '1e-4' is no whole number"]),
    ],
)
def test_wrong_usage_is_answered_with_what_to_do(report, capsys, tokens, said):
    assert main(tokens) == 2
    out, err = capsys.readouterr()
    assert not out and not report.calls
    assert err.startswith("error: ") and err.count("\n") == 1
    assert all(words in err for words in said), err


def from_another(error, cause):
    """Return an error that comes from another one, and that from the first, as somebody's may."""
    error.__cause__, cause.__context__ = cause, error
    return error


@pytest.mark.parametrize(
    "before", [[], ["diagram", "--"], ["info"], ["diagram", "d=0:1:3", "--threads"], ["paper"], ["sweep"]]
)
def test_a_word_of_thousands_of_letters_is_not_repeated(capsys, before):
    long = "q" * 3000
    tokens = [*before[:-1], f"--{long}"] if before[-1:] == ["--"] else [*before, long]
    assert main(tokens) == 2
    said = capsys.readouterr().err
    assert len(said) < 700 and "qqqq..." in said
    assert main([*before[:1], *("x " * 3000).split()]) == 2
    assert len(capsys.readouterr().err) < 700


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (InputError("no figure '9.9'; allowed are 1.2"), 2, "error: no figure '9.9'; allowed are 1.2\n"),
        (OutsideForm("b <= 0"), 2, "error: b <= 0\n"),
        (UserCodeError("the law raised"), 1, "error: the law raised\n"),
        (OSError(28, "No space left on device"), 1, "No space left on device"),
        (ImportError("No module named 'numba'"), 1, "numba"),
        (MemoryError(), 1, "out of memory"),
        (from_another(ImportError("no module"), OSError("x.so: failed to map segment")), 1, "out of memory"),
        (from_another(OSError("x.so not found"), ImportError("Cannot allocate memory")), 1, "out of memory"),
        (from_another(ImportError("no module"), ImportError("No module named 'numba'")), 1, "'numba'); install"),
        (RuntimeError("can't start new thread"), 1, "memory or processes are short; ask for fewer threads"),
        (KeyboardInterrupt(), 130, "stopped: interrupted"),
        (from_another(ImportError("numpy failed to import"), KeyboardInterrupt()), 130, "stopped: interrupted"),
        (from_another(RuntimeError("Error calling __set_name__"), KeyboardInterrupt()), 130, "stopped: interrupted"),
        (from_another(ZeroDivisionError("by zero"), ValueError("first")), 1, "unexpected error: ZeroDivisionError"),
        (ZeroDivisionError("by zero"), 1, "unexpected error: ZeroDivisionError: by zero\nThis is a defect in grazing"),
    ],
)
def test_an_error_becomes_a_message_and_a_code(report, capsys, error, code, said):
    report.raises = error
    assert main(["paper", "-q"]) == code
    out, err = capsys.readouterr()
    assert not out
    assert said in err
    assert "Traceback" not in err


def test_a_defect_says_how_to_report_it_and_where_it_is_on_request(report, capsys, monkeypatch):
    report.raises = ZeroDivisionError("by zero")
    main(["paper"])
    assert "GRAZING_DEBUG=1" in capsys.readouterr().err
    monkeypatch.setenv("GRAZING_DEBUG", "1")
    assert main(["paper"]) == 1
    err = capsys.readouterr().err
    assert "Traceback" in err and "test_app.py" in err


# ---- with the report itself


def test_an_unknown_figure_is_refused_and_nothing_made(tmp_path, capsys):
    assert main(["paper", "--figures", "3.1,1.1", "--out", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert "'1.1'" in err and "1.2, 1.3" in err
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_to_is_refused(tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("kept")
    for out in (file, file / "below"):
        assert main(["paper", "--figures", "3.1", "--out", str(out)]) == 2
        err = capsys.readouterr().err
        assert str(out) in err and "cannot write" in err
    assert file.read_text() == "kept"


# ---- what stands around


@pytest.mark.parametrize(
    ("columns", "wide"), [("0", "20"), ("1", "20"), ("9" * 30, "10000"), ("72", "72"), ("\u00b2", None), ("x", None)]
)
def test_a_terminal_of_any_width_gets_its_help(columns, wide, monkeypatch, capsys):
    """In one column or two the writer of the help never ended, and in 10^30 it failed."""
    monkeypatch.setenv("COLUMNS", columns)
    assert main(["paper", "--help"]) == 0 and capsys.readouterr().out
    assert os.environ.get("COLUMNS") == wide


def test_a_terminal_that_says_how_narrow_it_is(monkeypatch):
    monkeypatch.setattr(os, "get_terminal_size", lambda stream: os.terminal_size((1, 1)))
    monkeypatch.setenv("COLUMNS", "")
    assert main(["--version"]) == 0 and os.environ["COLUMNS"] == "20"


@pytest.mark.parametrize("name", ["NUMBA_NUM_THREADS", "ZARR_ARRAY__ORDER", "ZARR_THREADING__MAX_WORKERS"])
def test_a_setting_with_which_another_package_cannot_work_is_not_passed_on(name, monkeypatch):
    monkeypatch.setenv(name, "0")
    assert main(["--version"]) == 0 and name not in os.environ


@pytest.mark.parametrize("room", [400_000_000, 999_999_999])
def test_too_few_addresses_are_said_before_packages_that_would_not_end(room, monkeypatch, report, capsys):
    """SciPy's BLAS asks again and again for what it does not get."""
    monkeypatch.setattr(sys.modules["grazing.cli.app"], "address_space", lambda: room)
    assert main(["paper"]) == 1 and not report.calls
    said = capsys.readouterr().err
    assert said.startswith("error: this process may take ") and "ulimit -v" in said


def test_threads_that_nobody_asked_for_are_not_begun(monkeypatch):
    for given, kept in ((None, "1"), ("3", "3")):
        monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
        if given:
            monkeypatch.setenv("OPENBLAS_NUM_THREADS", given)
        assert main(["--version"]) == 0 and os.environ["OPENBLAS_NUM_THREADS"] == kept


def test_a_full_disk_under_the_standard_output_is_named(report, capsys):
    report.raises = OSError(28, "No space left on device")
    assert main(["paper"]) == 1
    said = "error: cannot write to the standard output: No space left on device; send it elsewhere.\n"
    assert capsys.readouterr().err.endswith(said)


def test_a_folder_that_is_gone_is_named(report, monkeypatch, capsys):
    def gone():
        raise FileNotFoundError(2, "No such file or directory")

    report.raises = FileNotFoundError(2, "No such file or directory")
    monkeypatch.setattr(os, "getcwd", gone)
    assert main(["paper"]) == 1
    assert capsys.readouterr().err.endswith("error: the folder that this runs in is gone; change to another.\n")


def test_a_configuration_of_somebody_else_is_blamed_on_it(report, capsys):
    """A file that dask cannot read was "a defect in grazing": xarray says it after it has tried and failed."""
    theirs = {"__name__": "theirs.config"}
    exec("def read():\n    raise ValueError('their file is malformed\\nin line 1')", theirs)
    try:
        try:
            theirs["read"]()
        except ValueError as error:
            raise ValueError("could not convert") from error
    except ValueError as error:
        report.raises = error
    assert main(["paper"]) == 1
    said = "the configuration of theirs that is found here cannot be used: their file is malformed; mend or remove it."
    assert capsys.readouterr().err.endswith(f"error: {said}\n")


def test_a_warning_with_a_traceback_in_it_is_one_line(capsys):
    _once()("Environment variable 'NUMBA_OPT'\ncould not be parsed.\nTraceback (most recent call last):\n  File")
    assert capsys.readouterr().err == "warning: Environment variable 'NUMBA_OPT' could not be parsed.\n"
