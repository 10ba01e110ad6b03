import ast
import subprocess
import sys
from pathlib import Path

from grazing import theory


def test_the_public_list_is_sorted_complete_and_documented():
    assert theory.__all__ == sorted(theory.__all__)
    assert {name for name in vars(theory) if not name.startswith("_")} >= set(theory.__all__)
    for name in theory.__all__:
        assert getattr(theory, name).__doc__


def test_functions_carry_an_example_and_what_they_raise():
    for name in theory.__all__:
        if name[0].islower():
            text = getattr(theory, name).__doc__
            assert all(part in text for part in ("Parameters", "Returns", "Raises", "Examples", ">>> "))


def test_no_public_name_hides_a_file_of_the_folder():
    files = {path.stem for path in Path(theory.__file__).parent.glob("*.py")}
    assert not files & set(theory.__all__)


def test_it_rests_on_numpy_and_the_outcomes_alone():
    allowed = (
        "__future__",
        "collections.abc",
        "dataclasses",
        "decimal",
        "enum",
        "itertools",
        "math",
        "numpy",
        "numpy.typing",
        "typing",
    )
    for path in Path(theory.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert name in (*allowed, "grazing.outcome") or name.startswith("grazing.theory"), (
                    path.name,
                    name,
                )


def test_importing_it_loads_neither_scipy_nor_numba():
    code = "import sys, grazing.theory; sys.exit(bool({'scipy', 'numba', 'xarray'} & set(sys.modules)))"
    assert (
        subprocess.run([sys.executable, "-c", code], env={"PYTHONPATH": ":".join(sys.path)}, check=False).returncode
        == 0
    )
