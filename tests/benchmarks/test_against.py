"""A kernel of another file: with contraction and without, and every way to name one wrongly."""

import numba
import pytest

from benchmarks.against import BadKernel, loaded, parsed, program_of
from benchmarks.models import family

KERNEL = """
import numpy as np

FM = {"contract", "nsz"}
SEEN = frozenset(FM)

def run(alpha, k, omega, r, V, d, u, v, transient, keep):
    shape = len(d), keep, u.shape[1]
    return np.full(shape, omega), np.full(shape, V), 3

def short(*args):
    return np.zeros(1), np.zeros(1)

def wrong(alpha):
    return alpha
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "kernels.py"
    path.write_text(KERNEL)
    return path


def test_the_function_is_called_with_the_model(file):
    u, v = program_of(*parsed(f"{file}:run"), contraction=True)(family(3, 4), 5, 2)
    assert u.shape == v.shape == (3, 2, 4)
    assert (u == 2.2).all() and (v == 0.4).all()


def test_contraction_is_taken_out_before_anything_is_compiled(file):
    assert loaded(file, contraction=True).SEEN == {"contract", "nsz"}
    assert loaded(file, contraction=False).SEEN == {"nsz"}


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("kernels.py", "give FILE:FUNCTION"),
        ("{}/none.py:run", "which does not exist"),
        ("{}/kernels.py:none", "has no function none; it has run, short, wrong"),
        ("{}/kernels.py:a b", "give FILE:FUNCTION"),
    ],
)
def test_bad_arguments(file, argument, message):
    with pytest.raises(BadKernel, match=message):
        parsed(argument.format(file.parent))


def test_not_python(tmp_path):
    (tmp_path / "notes.txt").write_text("this is no Python")
    with pytest.raises(BadKernel, match="is not a Python file"):
        parsed(f"{tmp_path}/notes.txt:run")


def test_a_file_that_raises(file):
    file.write_text("def run(): pass\n1/0")
    with pytest.raises(BadKernel, match=r"kernels.py does not run: ZeroDivisionError: division by zero"):
        loaded(file, contraction=True)


def test_a_function_that_raises_or_returns_something_else(file):
    with pytest.raises(BadKernel, match=r"wrong of kernels.py failed: TypeError"):
        program_of(file, "wrong", contraction=True)(family(1, 1), 0, 1)
    with pytest.raises(BadKernel, match=r"short returned arrays \(1,\) and \(1,\); wanted is \(2, 3, 4\)"):
        program_of(file, "short", contraction=True)(family(2, 4), 0, 3)


def test_the_threads_of_numba_are_put_back(file):
    before = numba.get_num_threads()
    program_of(file, "run", contraction=True)(family(1, 1), 0, 1)
    assert numba.get_num_threads() == before
