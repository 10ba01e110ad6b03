"""What tests of kernels share."""

import pytest

from grazing.kernel import disk


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "kept").mkdir(mode=0o700)
    monkeypatch.setenv("GRAZING_CACHE", str(tmp_path / "kept"))
    disk.folders.cache_clear()
    yield tmp_path / "kept"
    disk.folders.cache_clear()
