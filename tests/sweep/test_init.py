import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src"


def test_importing_it_is_cheap():
    code = f"import sys; sys.path.insert(0, {str(SOURCE)!r}); import grazing.sweep; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in run.stdout.split()}
    assert loaded.isdisjoint({"xarray", "pandas", "matplotlib", "zarr", "dask", "distributed"})
