"""Results as tidy tables."""

import contextlib
import csv
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

import grazing as gz
from grazing import InputError, export, late, writing
from grazing.export import tables, to_csv, to_parquet


def read(file):
    with file.open(newline="", encoding="utf-8") as opened:
        return list(csv.DictReader(opened))


@pytest.fixture
def result():
    rng = np.random.default_rng(0)
    return xr.Dataset(
        {
            "u": (("d", "start", "n"), rng.normal(size=(4, 3, 2))),
            "period": (("d", "start"), rng.integers(0, 9, (4, 3)).astype(np.int32)),
            "mean": ("start", [0.1, np.nan, np.inf]),
            "graze": ("d", np.arange(4) > 1),
            "word": ("attractor", np.array(["01", "a,b", 'say "x"'], object)),
            "point": (("attractor", "coordinate"), rng.normal(size=(3, 2))),
            "trust": ((), "certified"),
        },
        coords={"d": [0.1, 0.2, 0.3, 1e-300], "coordinate": ["u", "v"], "phase": ("d", [1, 2, 3, 4])},
    )


def test_variables_on_the_same_dimensions_share_a_table(result, tmp_path):
    files = to_csv(result, tmp_path / "out.csv")
    assert [file.name for file in files] == ["out.csv", "out-attractor.csv"]
    rows = read(files[0])
    assert list(rows[0]) == ["d", "start", "n", "phase", "u", "period", "mean", "graze", "trust"]
    assert len(rows) == 24
    for row in rows:
        at = {"d": float(row["d"]), "start": int(row["start"]), "n": int(row["n"])}
        assert float(row["u"]) == float(result.u.sel(**at))
        assert int(row["period"]) == int(result.period.sel(d=at["d"], start=at["start"]))
        assert row["graze"] == str(bool(result.graze.sel(d=at["d"])))
    assert {row["start"]: row["mean"] for row in rows} == {"0": "0.1", "1": "", "2": "inf"}
    rows = read(files[1])
    assert list(rows[0]) == ["attractor", "word", "point_u", "point_v"]
    assert [row["word"] for row in rows] == ["01", "a,b", 'say "x"']
    assert [float(row["point_v"]) for row in rows] == result.point.sel(coordinate="v").values.tolist()


def test_the_table_of_the_first_variable_comes_first_however_small_it_is(tmp_path):
    runs = {"amplitude": (("f", "run"), np.ones((2, 2))), "difference": ("part", [1.0, 2.0, 3.0])}
    result = xr.Dataset(runs, {"f": [1.0, 2.0], "run": ["up", "down"]})
    result["branch"] = ("point", np.arange(100.0))
    assert [dims for dims, _names in tables(result.isel(run=0, drop=True))] == [("f",), ("point",), ("part",)]
    first, *rest = to_csv(result, tmp_path / "out.csv")
    assert list(read(first)[0]) == ["f", "amplitude_up", "amplitude_down"]
    assert [file.name for file in rest] == ["out-point.csv", "out-part.csv"]
    assert list(gz.to_dataframe(result)) == ["f", "amplitude_up", "amplitude_down"]


@pytest.mark.parametrize("rows", [3, 200_000])
def test_rows_that_only_fill_up_are_left_out(tmp_path, monkeypatch, rows):
    monkeypatch.setattr(export, "ROWS", rows)
    period = np.array([[3, -3, -3], [2, 5, -3], [-1, -2, 0]], np.int32)
    flags = {
        "flag_values": np.array([0, -1, -2, -3], np.int32),
        "flag_meanings": "undecided aperiodic ended no_further_x",
    }
    share = np.array([[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.4, 0.3, 0.3]])
    result = xr.Dataset(
        {"period": (("d", "rank"), period, flags), "share": (("d", "rank"), share), "grazes": ("d", [-3, 0, 1])},
    )
    (file,) = to_csv(result, tmp_path / "out.csv")
    found = [(row["d"], row["rank"], row["period"], row["grazes"]) for row in read(file)]
    assert found == [
        ("0", "0", "3", "-3"), ("1", "0", "2", "0"), ("1", "1", "5", "0"),
        ("2", "0", "-1", "1"), ("2", "1", "-2", "1"), ("2", "2", "0", "1"),
    ]  # fmt: skip


def test_a_row_that_says_something_in_one_of_two_columns_stays(tmp_path):
    flags = {"flag_values": [0, -3], "flag_meanings": "undecided no_further_attractor"}
    result = xr.Dataset({"flow": ("rank", [2, 3, -3], flags), "map": ("rank", [2, -3, -3], flags)})
    (file,) = to_csv(result, tmp_path / "out.csv")
    assert [(row["flow"], row["map"]) for row in read(file)] == [("2", "2"), ("3", "-3")]


def test_pieces_make_one_table(result, tmp_path, monkeypatch):
    to_csv(result, tmp_path / "whole.csv")
    monkeypatch.setattr(export, "ROWS", 5)
    to_csv(result, tmp_path / "pieces.csv")
    assert (tmp_path / "pieces.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_the_files_have_one_order_in_every_process(tmp_path):
    """Tables of one size came in the order of a set, which a seed of each process decides."""
    program = (
        "import sys, xarray as xr\nfrom grazing.export import tables\n"
        "print(tables(xr.Dataset({name: (name + name, [1.0, 2.0]) for name in 'abcdefgh'})))"
    )
    said = set()
    for seed in ("1", "2"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", program]
        said.add(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)
    (one,) = said
    assert one.startswith("[(('aa',), ['a']), (('bb',), ['b']),")


def test_dimensions_in_another_order_are_put_in_order(tmp_path):
    data = np.arange(6.0).reshape(2, 3)
    result = xr.Dataset({"a": (("x", "y"), data), "b": (("y", "x"), data.T)})
    (file,) = to_csv(result, tmp_path / "a.csv")
    assert all(row["a"] == row["b"] for row in read(file))


def test_scalars_and_nothing(tmp_path):
    (file,) = to_csv(xr.Dataset({"a": 1.5}), tmp_path / "a.csv")
    assert read(file) == [{"a": "1.5"}]
    (file,) = to_csv(xr.Dataset({"a": ("x", np.zeros(0))}), tmp_path / "b.csv")
    assert file.read_text() == "x,a\n"
    assert tables(xr.Dataset(coords={"x": [1, 2]})) == [(("x",), [])]


def test_what_cannot_be_written_is_said_and_leaves_nothing(result, tmp_path):
    with pytest.raises(InputError, match=r"ends in '.txt'; allowed is '.csv'"):
        to_csv(result, tmp_path / "a.txt")
    with pytest.raises(InputError, match="cannot be written"):
        to_csv(result, tmp_path / "no" / "a.csv")
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(InputError, match="is a folder; give the name of a file"):
        to_csv(result, tmp_path / "a.csv")
    assert [file.name for file in tmp_path.iterdir()] == ["a.csv"]


# ---- Parquet


def test_on_a_full_disk_no_table_is_that_of_another_result(result, tmp_path, monkeypatch):
    written, full = export._csv, iter([False, True])

    def to_full(*given):
        if next(full):
            raise OSError(28, "No space left on device")
        written(*given)

    before = {file: file.read_bytes() for file in to_csv(result, tmp_path / "a.csv")}
    assert len(before) > 1
    monkeypatch.setattr(export, "_csv", to_full)
    with pytest.raises(InputError, match="No space left on device"):
        to_csv(result.assign(u=2 * result.u), tmp_path / "a.csv")
    assert {file: file.read_bytes() for file in tmp_path.iterdir()} == before


@pytest.mark.parametrize("call", ["fsync", "replace"])
@pytest.mark.parametrize("left", [1, 2])
def test_a_disk_that_is_full_at_the_last_moment_leaves_all_tables_of_one_result(tmp_path, monkeypatch, call, left):
    """A disk with a quota, or of another machine, may say so only then: one table was new and the other old."""
    result = xr.Dataset({"a": ("x", [1.0, 2.0]), "b": ("y", [3.0])})
    calls, real = [], getattr(os, call)

    def full(*given, **options):
        calls.append(given)
        if len(calls) == left:
            raise OSError(28, "No space left on device")
        real(*given, **options)

    for before in ({}, {file: file.read_bytes() for file in to_csv(result, tmp_path / "a.csv")}):
        for file in tmp_path.iterdir():
            before or file.unlink()
        calls.clear()
        with monkeypatch.context() as patch, pytest.raises(InputError, match=r"a.csv, .*a-y.csv cannot be written: No"):
            patch.setattr(os, call, full)
            to_csv(result + 1.0, tmp_path / "a.csv")
        assert {file: file.read_bytes() for file in tmp_path.iterdir()} == before
        to_csv(result, tmp_path / "a.csv")


@pytest.mark.skipif(os.name != "posix", reason="forks")
def test_tables_of_two_processes_that_write_the_same_do_not_mix(tmp_path, monkeypatch):
    """The first gives its first table a name, and waits before the second one until the other process is done."""
    real, number = os.replace, iter([])

    def seen(name):
        end = time.monotonic() + 0.5  # the other one may have to wait for us
        while not (tmp_path / name).exists() and time.monotonic() < end:
            time.sleep(0.01)

    def slow(part, target):
        real(part, target)
        if next(number, None) == 0:
            (tmp_path / "begun").touch()
            seen("ended")

    monkeypatch.setattr(os, "replace", slow)
    children = []
    for value in (1.0, 2.0):
        if not (child := os.fork()):
            if value == 1.0:
                number = iter([0])
            else:
                seen("begun")
            with contextlib.suppress(BaseException):
                to_csv(xr.Dataset({"a": ("x", [value]), "b": ("y", [value] * 2)}), tmp_path / "a.csv")
                (tmp_path / "ended").touch()
            os._exit(0)
        children.append(child)
    for child in children:
        os.waitpid(child, 0)
    assert (tmp_path / "begun").exists() and (tmp_path / "ended").exists()
    assert read(tmp_path / "a.csv")[0]["a"] == read(tmp_path / "a-y.csv")[0]["b"]


def test_a_folder_that_another_process_holds_is_said(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")
    monkeypatch.setattr(writing, "TURN", 0.05)
    handle = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        with pytest.raises(InputError, match=r"has been locked by another process for 0.05 s; end it, or wait"):
            to_csv(xr.Dataset({"a": ("x", [1.0]), "b": ("y", [1.0])}), tmp_path / "a.csv")
    finally:
        os.close(handle)
    assert not [*tmp_path.iterdir()]


def test_the_next_writer_leaves_what_an_undo_takes_the_first_tables_from(tmp_path, monkeypatch):
    """The tables before are nobody's while others get their names: another process took them for left, and away."""
    pytest.importorskip("fcntl")
    result = xr.Dataset({"a": ("x", [1.0, 2.0]), "b": ("y", [3.0])})
    before = {file: file.read_bytes() for file in to_csv(result, tmp_path / "a.csv")}
    real, calls = os.replace, []

    def full(part, target):
        calls.append(target)
        if len(calls) == 2:
            writing.remove_left(tmp_path)  # as one who writes another file there begins with
            raise OSError(28, "No space left on device")
        real(part, target)

    with monkeypatch.context() as patch, pytest.raises(InputError, match="No space left on device"):
        patch.setattr(os, "replace", full)
        to_csv(result + 1.0, tmp_path / "a.csv")
    assert {file: file.read_bytes() for file in tmp_path.iterdir()} == before


@pytest.mark.skipif(os.name != "posix", reason="forks")
def test_a_process_that_is_forked_meanwhile_does_not_hold_the_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(writing, "TURN", 0.2)
    result, real, children = xr.Dataset({"a": ("x", [1.0]), "b": ("y", [1.0])}), os.replace, []

    def forks(part, target):
        real(part, target)
        if not children:  # as a pool in another thread does
            if not (child := os.fork()):
                time.sleep(60.0)
                os._exit(0)
            children.append(child)

    try:
        with monkeypatch.context() as patch:
            patch.setattr(os, "replace", forks)
            to_csv(result, tmp_path / "a.csv")
        to_csv(result + 1.0, tmp_path / "a.csv")
    finally:
        os.kill(children[0], signal.SIGKILL)
        os.waitpid(children[0], 0)
    assert read(tmp_path / "a.csv")[0]["a"] == read(tmp_path / "a-y.csv")[0]["b"] == "2.0"


@pytest.mark.skipif(os.name != "posix", reason="forks, kills and links")
@pytest.mark.parametrize("call, at", [("link", 2), ("replace", 1)])
def test_who_is_killed_before_the_first_name_leaves_all_tables_and_the_next_removes_the_rest(tmp_path, call, at):
    """A link that had the name is kept as one, which has no lock: it was left for good."""
    result = xr.Dataset({"a": ("x", [1.0]), "b": ("y", [1.0])})
    to_csv(result, tmp_path / "a.csv")
    (tmp_path / "a.csv").rename(tmp_path / "far")
    (tmp_path / "a.csv").symlink_to("far")
    if not (child := os.fork()):
        real, calls = getattr(os, call), []

        def killed(*given, **options):
            calls.append(given)
            if len(calls) == at:
                os.kill(os.getpid(), signal.SIGKILL)
            real(*given, **options)

        setattr(os, call, killed)
        with contextlib.suppress(BaseException):
            to_csv(result + 1.0, tmp_path / "a.csv")
        os._exit(0)
    assert os.waitpid(child, 0)[1] == signal.SIGKILL
    assert read(tmp_path / "a.csv")[0]["a"] == read(tmp_path / "a-y.csv")[0]["b"] == "1.0"
    to_csv(result, tmp_path / "a.csv")
    assert {file.name for file in tmp_path.iterdir()} == {"a.csv", "a-y.csv", "far"}


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_an_interrupt_before_the_file_is_locked_leaves_nothing(tmp_path, monkeypatch):
    real, before = writing._lock, signal.signal(signal.SIGINT, signal.default_int_handler)

    def interrupted(handle, how):
        if [*tmp_path.glob(".*.partial")]:
            os.kill(os.getpid(), signal.SIGINT)
        return real(handle, how)

    monkeypatch.setattr(writing, "_lock", interrupted)
    try:
        with pytest.raises(KeyboardInterrupt):
            to_csv(xr.Dataset({"a": ("x", [1.0])}), tmp_path / "a.csv")
    finally:
        signal.signal(signal.SIGINT, before)
    assert not [*tmp_path.iterdir()]


def parquet(file):
    from pyarrow import parquet

    return parquet.read_table(file)


@pytest.mark.parametrize("rows", [3, 200_000])
def test_parquet_holds_the_tables_of_csv_with_their_types_and_bits(result, tmp_path, monkeypatch, rows):
    monkeypatch.setattr(export, "ROWS", rows)
    files = to_parquet(result, tmp_path / "out.parquet")
    assert [file.name for file in files] == ["out.parquet", "out-attractor.parquet"]
    first, second = map(parquet, files)
    kinds = {name: str(first.schema.field(name).type) for name in first.schema.names}
    assert kinds == {
        "d": "double", "start": "int64", "n": "int64", "phase": "int64", "u": "double", "period": "int32",
        "mean": "double", "graze": "bool", "trust": "string",
    }  # fmt: skip
    assert first["u"].to_numpy().tobytes() == np.ascontiguousarray(result.u.values).tobytes()
    mean = first["mean"].to_numpy()
    assert np.isnan(mean).sum() == 8 and np.isinf(mean).sum() == 8 and first["mean"].null_count == 0
    assert second["word"].to_pylist() == ["01", "a,b", 'say "x"']
    said = to_csv(result, tmp_path / "out.csv")
    for table, file in zip((first, second), said, strict=True):
        rows = read(file)
        assert table.num_rows == len(rows) and table.schema.names == list(rows[0])


def test_parquet_leaves_out_rows_that_only_fill_up(tmp_path):
    flags = {"flag_values": [0, -3], "flag_meanings": "undecided no_further_attractor"}
    (file,) = to_parquet(xr.Dataset({"flow": ("rank", [2, 3, -3], flags)}), tmp_path / "a.parquet")
    assert parquet(file)["flow"].to_pylist() == [2, 3]
    (file,) = to_parquet(xr.Dataset({"a": ("x", np.zeros(0))}), tmp_path / "b.parquet")
    assert parquet(file).num_rows == 0 and parquet(file).schema.names == ["x", "a"]


def test_parquet_that_cannot_be_written_is_said_and_leaves_nothing(result, tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"ends in '.csv'; allowed is '.parquet'"):
        to_parquet(result, tmp_path / "a.csv")
    with pytest.raises(InputError, match="cannot be written"):
        to_parquet(result, tmp_path / "no" / "a.parquet")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for name in ("parquet", "pyarrow"):
        monkeypatch.delitem(vars(late), name, raising=False)
    with pytest.raises(InputError, match=r"needs pyarrow: pip install 'grazing\[parquet\]'"):
        to_parquet(result, tmp_path / "a.parquet")
    assert not list(tmp_path.iterdir())


# ---- data frames


def test_a_trajectory_is_one_row_an_instant_and_one_row_an_impact(tmp_path):
    motion = gz.trajectory(gz.pinball(d=0.12, V=0.4), (0.1, 0.0), until=20.0)
    table, impacts = gz.to_dataframe(motion), gz.to_dataframe(motion, "impact")
    assert list(table) == ["t", "u", "v", "wall", "trust"] and len(table) == motion.sizes["t"]
    assert table["u"].to_numpy().tobytes() == motion["u"].values.tobytes()
    assert list(impacts) == ["impact", "impact_time", "v_minus", "v_plus"] and len(impacts) == 3
    files = to_csv(motion, tmp_path / "a.csv")
    assert [file.name for file in files] == ["a.csv", "a-impact.csv"]
    for file, frame in zip(files, (table, impacts), strict=True):
        rows = read(file)
        assert list(rows[0]) == list(frame) and len(rows) == len(frame)
    assert [float(row["v"]) for row in read(files[0])] == table["v"].tolist()


def test_a_frame_is_the_table_of_the_file_and_refuses_what_is_no_dimension(result):
    assert list(gz.to_dataframe(result)) == read_head(result)
    with pytest.raises(InputError, match=r"dimension is 'no'; allowed are 'd', 'start', 'n'"):
        gz.to_dataframe(result, "no")
    with pytest.raises(InputError, match=r"give an xarray\.Dataset"):
        gz.to_dataframe([1.0])


def read_head(result):
    dims, names = tables(result)[0]
    return [*dims, *names]


def test_a_column_has_the_units_of_its_own_coordinate(tmp_path):
    """Those of names along a dimension are given together, where they differ."""
    both = xr.Dataset(
        {"state": (("n", "coordinate"), np.zeros((2, 2)), {"units": "mm, mm/s"}),
         "same": (("n", "coordinate"), np.ones((2, 2)), {"units": "s"})},
        coords={"coordinate": ["u", "v"]},
    )  # fmt: skip
    (file,) = gz.to_csv(both, tmp_path / "a.csv")
    assert file.read_text().splitlines()[0] == "n,state_u (mm),state_v (mm/s),same_u (s),same_v (s)"


def test_a_column_of_texts_is_not_taken_for_names(tmp_path):
    """Each text got a column of its own: of equal ones all but the last were lost, and 100,000 took minutes."""
    words = xr.Dataset({"x": ("word", np.arange(3.0)), "y": ("n", [1.0])}, {"word": ["L", "R", "L"]})
    assert to_csv(words, tmp_path / "a.csv")[0].read_text().splitlines() == ["word,x", "L,0.0", "R,1.0", "L,2.0"]
    many = xr.Dataset({"x": ("word", np.arange(1e5))}, {"word": np.arange(100_000).astype(str)})
    assert len(to_csv(many, tmp_path / "b.csv")[0].read_text().splitlines()) == 100_001
    clash = xr.Dataset({"x": ("of", [1.0, 2.0]), "x_u": 3.0}, {"of": ["u", "v"]})
    with pytest.raises(InputError, match="two columns would be called 'x_u'"):
        to_csv(clash, tmp_path / "c.csv")
    three = xr.Dataset({"x": ("of", [1.0, 2.0, 3.0], {"units": "m, s"})}, {"of": ["u", "v", "w"]})
    assert to_csv(three, tmp_path / "d.csv")[0].read_text().startswith('"x_u (m, s)","x_v (m, s)","x_w (m, s)"')
