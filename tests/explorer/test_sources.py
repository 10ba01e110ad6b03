"""Hashes of kernels: of their code and all that it names, whatever is said about it."""

import importlib.util

from grazing.explorer.sources import file_digest, source_digest
from grazing.kernel.compile import compiled


def one(x):
    # a comment
    return x + 1.0


def other(x):
    """Add one."""
    return x + 1.0


def outer(x):
    return one(x) * 2.0


def scaled_by(factor, function):
    def scaled(x):
        return factor * function(x)

    return scaled


def test_a_digest_depends_on_names_closures_and_callees():
    assert source_digest(scaled_by(2.0, one)) == source_digest(scaled_by(2.0, one))
    assert source_digest(scaled_by(2.0, one)) != source_digest(scaled_by(3.0, one))
    assert source_digest(scaled_by(2.0, one)) != source_digest(scaled_by(2.0, outer))
    assert source_digest(compiled(outer)) == source_digest(outer)


def written(folder, name, text):
    path = folder / f"{name}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location("a_kernel", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.f


def test_a_digest_ignores_comments_and_documentation_but_no_code(tmp_path):
    first = written(tmp_path, "a", "C = 2.0\n\ndef f(x):\n    return C * x\n")
    said = written(tmp_path, "b", 'C = 2.0\n\n\ndef f(x):\n    """Twice."""\n    # why\n    return C * x\n')
    changed = written(tmp_path, "c", "C = 2.0\n\ndef f(x):\n    return x * C\n")
    constant = written(tmp_path, "d", "C = 2.5\n\ndef f(x):\n    return C * x\n")
    assert source_digest(first) == source_digest(said)
    assert len({source_digest(f) for f in (first, changed, constant)}) == 3


def test_a_file_is_hashed_without_comments(tmp_path):
    texts = {"a": "x = 1\n", "b": '"""Said."""\n\nx = 1  # one\n', "c": "x = 2\n"}
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    a, b, c = (file_digest(tmp_path / name) for name in texts)
    assert a == b != c
