"""Functions inside a kernel become part of it, and nothing else; the way through the compiler changes no number."""

import gc
import os
from types import FunctionType

import numba
import numpy as np
import pytest
from llvmlite import binding

from grazing.kernel import compile as layer
from grazing.kernel.compile import address, compiled
from grazing.kernel.primitives import called, inlined
from grazing.kernel.wide import plain

WIDE = pytest.mark.skipif(bool(plain()), reason=f"plain forms are taken: {plain()}")


@WIDE
def test_no_machine_code_is_made_of_what_is_only_linked():
    unseen = float.fromhex(f"0x1.{os.urandom(4).hex()}p0")  # no kernel on the disk has it

    def inner(x):
        return unseen * x + np.zeros(3).sum()

    def outer(x):
        return inner(x) - 1.0

    assert compiled(outer)(2.0) == 2.0 * unseen - 1.0
    (found,) = layer._inner[layer.digest(inner), "strict"].overloads.values()
    (entry,) = layer._outer[outer, "strict"].overloads.values()
    engine = entry.library._codegen._engine
    assert engine.is_symbol_defined(entry.fndesc.llvm_func_name)
    assert not engine.is_symbol_defined(found.fndesc.llvm_func_name)


def test_of_a_kernel_that_is_reached_by_its_address_no_entry_for_python_is_made():
    unseen = float.fromhex(f"0x1.{os.urandom(4).hex()}p0")

    def law(v, _row):
        return -unseen * v

    def calls(place, v):
        return called(place, v, 0.0)

    assert compiled(calls)(address(law, "value"), -2.0) == 2.0 * unseen
    (found,) = (each for key, kept in layer._outer.items() if key[0] is law for each in kept.overloads.values())
    engine = found.library._codegen._engine
    assert engine.is_symbol_defined(found.fndesc.llvm_func_name)
    assert not engine.is_symbol_defined(found.fndesc.llvm_cpython_wrapper_name)


@WIDE
def test_a_module_that_the_linker_took_is_not_destroyed_again_after_an_interrupt(monkeypatch):
    """Python raises it as the call ends, before llvmlite notes that the module is gone: the process ended."""

    def interrupted(_target, _source):  # what was linked would be destroyed by now
        raise KeyboardInterrupt

    compiled(lambda x: x)
    monkeypatch.setattr("grazing.kernel.uninterrupted._link", interrupted)
    target, source = binding.parse_assembly(""), binding.parse_assembly("")
    destroyed = []
    monkeypatch.setattr(source, "_dispose", lambda: destroyed.append(source))
    with pytest.raises(KeyboardInterrupt):
        target.link_in(source)
    source.close()
    assert destroyed == []


def test_whether_it_must_become_part_of_its_callers_is_not_taken_from_the_first_of_them():
    unseen = float.fromhex(f"0x1.{os.urandom(4).hex()}p0")

    def inner(x):
        return unseen * x

    @inlined
    def between(x):
        return inner(x)

    compiled(lambda x: between(x))(2.0)
    (found,) = layer._inner[layer.digest(inner), "strict"].overloads.values()
    assert "alwaysinline" not in found.library.get_llvm_str()


def test_a_function_may_be_inside_one_kernel_and_be_another():
    def shared(x):
        return 2.0 * x

    def outer(x):
        return shared(x) + 1.0

    assert compiled(outer)(3.0) == 7.0
    assert compiled(shared)(3.0) == 6.0
    assert compiled(lambda x: shared(x) - 1.0)(3.0) == 5.0


def mixed(x, n):
    """Operators of numbers, truths and tuples, with constants on either side; powers with and without one."""
    sides, total, bits = (x, 2.0), 0.0, 1
    for i in range(n):
        y = 3.0 - sides[0] * i / (1 + i) + x**2 + x**i - (i**2 - 7 % (i + 1) + (i << 2) // 3)
        total += y if (i & 1 == 0) & (y < 2) | (x > 1.5) else -sides[1]
        bits |= i << 3
    return total + bits + (n // 2) ** 2


@pytest.mark.parametrize("own", [True, False])
@pytest.mark.parametrize("x", [0.3, 1.7, -0.9])
def test_operators_are_those_of_numba(own, x):
    place = {"__name__": "grazing.kernel.tried" if own else "tried", "__builtins__": __builtins__}
    function = FunctionType(mixed.__code__, place, "mixed")
    function.__module__ = place["__name__"]
    wanted = numba.njit(error_model="numpy")(mixed)(x, 9)
    assert compiled(function)(x, 9) == wanted == pytest.approx(mixed(x, 9), rel=1e-14)


@WIDE
def test_registers_that_are_put_on_the_stack_lie_in_one_line_of_the_cache():
    unseen = float.fromhex(f"0x1.{os.urandom(4).hex()}p0")

    def outer(x):
        return unseen * x

    outer.__module__ = "grazing.tried"
    entry = compiled(outer)
    assert entry(2.0) == 2.0 * unseen
    (found,) = entry.overloads.values()
    able = found.library.codegen.magic_tuple()[2]
    wide = 64 if "+avx512f" in able else 32 if "+avx" in able else 0
    assert (f"alignstack={wide} " in found.library.get_llvm_str()) == (wide > 0)


def test_laws_of_others_may_hold_what_kernels_do_not():
    def listed(x):
        steps = [x * k for k in range(4)]
        return sum([step + 1.0 for step in steps])

    assert compiled(listed)(2.0) == 16.0


def test_garbage_is_looked_for_again_after_a_compilation():
    assert gc.isenabled()
    compiled(lambda x: x + 41.5)(1.0)
    assert gc.isenabled()
    with pytest.raises(numba.errors.TypingError):
        compiled(lambda x: x.nothing)(1.0)
    assert gc.isenabled()
    gc.disable()
    try:
        compiled(lambda x: x + 42.5)(1.0)
        assert not gc.isenabled()
    finally:
        gc.enable()
