"""The notebooks in examples/: each runs from top to bottom and prints what is stored in it."""

import base64
import os
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat", reason="needs nbclient and ipykernel, of the extra `test`")
nbclient = pytest.importorskip("nbclient", reason="needs nbclient and ipykernel, of the extra `test`")

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))
#: Bytes of a figure that is stored.
LARGEST = 100_000


def printed(notebook):
    """What the cells printed and returned, as text; of figures that there is one."""
    return [
        (
            cell["id"],
            one["output_type"],
            one.get("text") or one["data"]["text/plain"],
            "image/png" in one.get("data", {}),
        )
        for cell in notebook.cells
        for one in cell.get("outputs", [])
    ]


def test_there_are_three():
    assert [file.stem for file in NOTEBOOKS] == ["first_steps", "pring_and_budd", "rig_in_si_units"]


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_prints_what_is_stored(file, monkeypatch, tmp_path):
    stored = nbformat.read(file, 4)
    again = nbformat.read(file, 4)
    for cell in again.cells:
        if cell.cell_type == "code":
            cell.outputs = []
    path = os.pathsep.join([str(ROOT / "src"), os.environ.get("PYTHONPATH", "")])
    monkeypatch.setenv("PYTHONPATH", path)
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    resources = {"metadata": {"path": str(tmp_path)}}  # joined: what is printed over more than 0.2 s comes in pieces
    nbclient.NotebookClient(again, timeout=600, coalesce_streams=True, resources=resources).execute()
    assert printed(again) == printed(stored)
    assert any(figure for *_text, figure in printed(again))


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_is_executed_clean_and_small(file):
    stored = nbformat.read(file, 4)
    nbformat.validate(stored)
    for cell in stored.cells:
        for one in cell.get("outputs", []):
            assert one["output_type"] in ("stream", "execute_result") and one.get("name", "stdout") == "stdout"
            assert len(base64.b64decode(one.get("data", {}).get("image/png", ""))) < LARGEST
    counts = [cell.execution_count for cell in stored.cells if cell.cell_type == "code"]
    assert counts == list(range(1, len(counts) + 1))
