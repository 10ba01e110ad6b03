from grazing import sweep
from grazing.sweep.lock import locked
from tests.sweep.plans import files, plan


def test_it_counts_and_says_who_works(tmp_path):
    store = tmp_path / "a.zarr"
    sweep.run(plan(5, 3), store, chunk={"mu": 2, "l": 2}, shard=(2, 2))
    with locked(store / ".grazing" / "locks", (1, 2)):
        found = sweep.status(store)
    assert (found.chunks, found.chunks_done, found.cells, found.cells_done) == (6, 3, 15, 5)
    assert (found.shape, found.chunk, found.complete) == ({"mu": 5, "l": 3}, {"mu": 2, "l": 2}, False)
    assert found.bytes == sum(map(len, files(store).values()))
    assert found.seconds > 0.0 and [lock.shard for lock in found.running] == ["1/2"]
    assert "3 of 6 chunks (50.0%), 5 of 15 cells" in str(found)
    assert "running: shard 1/2 (process " in str(found)


def test_times_of_a_killed_process_count_as_far_as_they_go(tmp_path):
    sweep.run(plan(), tmp_path / "a.zarr")
    times = tmp_path / "a.zarr" / ".grazing" / "times"
    before = sweep.status(tmp_path / "a.zarr").seconds
    (times / "elsewhere-1").write_bytes(b"0 1.5\n1 2.0\n2")
    (times / "elsewhere-2").write_bytes(b"\xff\n 7\n")
    assert round(sweep.status(tmp_path / "a.zarr").seconds - before, 9) == 3.5


def test_only_times_are_added(tmp_path):
    """A line with `nan` or `1e999` made `sweep status --json` no JSON."""
    sweep.run(plan(7), tmp_path / "a.zarr", chunk=2)
    (file,) = (tmp_path / "a.zarr" / ".grazing" / "times").iterdir()
    file.write_text("0 nan\n1 inf\n2 1e999\n3 -5\n0 1e308\n1 2.5\n2 x\n")
    assert sweep.status(tmp_path / "a.zarr").seconds == 2.5
