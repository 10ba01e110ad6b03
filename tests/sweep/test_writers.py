import asyncio

import numpy as np
import pytest

from grazing.sweep.writers import wait_for_zarr


@pytest.mark.parametrize("kind", ["get", "set"])
def test_after_a_failure_the_others_are_waited_for(tmp_path, monkeypatch, kind):
    import zarr
    from zarr.storage import LocalStore

    array = zarr.create_array(tmp_path / "a.zarr", shape=8, chunks=1, dtype="f8")
    array[...] = np.arange(8.0)
    whole, ended = getattr(LocalStore, kind), []

    async def slow(self, key, *args, **options):
        if key.endswith("c/0"):
            raise OSError(28, "No space left on device")
        await asyncio.sleep(0.3)
        found = await whole(self, key, *args, **options)
        ended.append(key)
        return found

    monkeypatch.setattr(LocalStore, kind, slow)
    with pytest.raises(OSError, match="No space left"):
        if kind == "get":
            array[...]
        else:
            array[...] = np.ones(8)
    assert not ended
    wait_for_zarr()
    assert sorted(ended) == [f"c/{i}" for i in range(1, 8)]


def test_with_nothing_to_wait_for_it_returns():
    wait_for_zarr()
