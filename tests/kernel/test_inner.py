"""Functions inside a kernel become part of it, and nothing else."""

import numpy as np

from grazing.kernel import compile as layer
from grazing.kernel.compile import compiled


def test_no_machine_code_is_made_of_what_is_only_linked():
    def inner(x):
        return 3.0 * x + np.zeros(3).sum()

    def outer(x):
        return inner(x) - 1.0

    assert compiled(outer)(2.0) == 5.0
    (found,) = layer._inner[inner, "strict"].overloads.values()
    (entry,) = layer._outer[outer, "strict"].overloads.values()
    engine = entry.library._codegen._engine
    assert engine.is_symbol_defined(entry.fndesc.llvm_func_name)
    assert not engine.is_symbol_defined(found.fndesc.llvm_func_name)


def test_a_function_may_be_inside_one_kernel_and_be_another():
    def shared(x):
        return 2.0 * x

    def outer(x):
        return shared(x) + 1.0

    assert compiled(outer)(3.0) == 7.0
    assert compiled(shared)(3.0) == 6.0
    assert compiled(lambda x: shared(x) - 1.0)(3.0) == 5.0
