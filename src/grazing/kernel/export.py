"""Kernels for another machine: the compiler's own intermediate code, emitted as WebAssembly.

What numba makes of a kernel before it optimises is LLVM's intermediate code for a machine with 64-bit addresses. Here
that code is told of another machine, loses all that speaks of Python, and goes through LLVM once more. Nothing is
contracted or reordered, exponentials and sines are our own (:mod:`grazing.kernel.elementary`), and square roots and
roundings are instructions of both machines: the same kernel gives the same bits in a browser and in Python.

It is a tool for building: it must run in a process with :data:`ENVIRONMENT`, set before numba is imported, because what
numba has optimised or kept on disk no longer fits another machine.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Sequence
from typing import Any

from grazing.kernel.compile import compiled
from grazing.kernel.elementary import exp, log, power, remainder
from grazing.outcome import InputError

#: Of a process that exports: the code must not be optimised for the machine it runs on.
ENVIRONMENT = {
    "NUMBA_OPT": "0",
    "NUMBA_LOOP_VECTORIZE": "0",
    "NUMBA_SLP_VECTORIZE": "0",
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
    "GRAZING_UNITS": "0",
}
#: Machine, its layout of memory as LLVM spells it, and the instructions that every browser has since 2023.
TRIPLE = "wasm32-unknown-unknown"
LAYOUT = "e-m:e-p:32:32-p10:8:8-p20:8:8-i64:64-i128:128-n32:64-S128-ni:1:10:20"
FEATURES = "+simd128,+bulk-memory,+nontrapping-fptoint,+sign-ext"
#: Effort of the optimiser: 3 makes the modules a tenth larger and not faster.
SPEED = 2

#: Functions of the C library, what stands for them, and of how many numbers: a module has no library.
OWN: dict[str, tuple[Callable[..., float], int]] = {
    "exp": (exp, 1),
    "log": (log, 1),
    "pow": (power, 2),
    "fmod": (remainder, 2),
}


#: Functions of the C library whose last digits differ from one to another.
LIBRARY = frozenset(
    "acos acosh asin asinh atan atan2 atanh cbrt cos cosh erf erfc exp exp2 expm1 gamma hypot lgamma log log10 log1p "
    "log2 pow sin sinh tan tanh tgamma".split()
)


def borrowed_by(text: str) -> set[str]:
    """Return the functions of the C library that intermediate code calls, but for those that are exact everywhere."""
    return {*re.findall(r"@(?:llvm\.|numba_)?(\w+?)(?:\.f64)?\(", text)} & LIBRARY


def refuse_elsewhere() -> None:
    """Raise InputError in a process without :data:`ENVIRONMENT`."""
    wrong = {name: value for name, value in ENVIRONMENT.items() if os.environ.get(name) != value}
    if wrong:
        raise InputError(
            f"kernels are exported in a process of their own, started with {wrong}; run python -m grazing.explorer"
        )


def lowered(
    name: str,
    function: Callable[..., Any],
    sizes: Sequence[str],
    arguments: Sequence[tuple[str, str, Sequence[str | int]]],
    result: str,
) -> tuple[str, str]:
    """Compile a kernel as a function of numbers and addresses.

    Parameters
    ----------
    name : str
    function : callable
        A plain Python function of ``arguments``.
    sizes : sequence of str
        Whole numbers that come first and say how large arrays are.
    arguments : sequence of tuple
        Of each its name, the kind of its numbers, and if it is an array its sizes, by name or number.
    result : str
        Kind of number, or empty.

    Returns
    -------
    tuple of str
        What the function is called in its intermediate code, and that code.
    """
    import numba
    from numba import carray, types

    names, values, signature = list(sizes), [], [types.int64] * len(sizes)
    for argument, number, shape in arguments:
        kind = getattr(types, number)
        names.append(argument)
        signature.append(types.CPointer(kind) if shape else kind)
        values.append(f"carray({argument}, ({', '.join(map(str, shape))},))" if shape else argument)
    source = f"def {name}({', '.join(names)}):\n    return kernel({', '.join(values)})\n"
    scope: dict[str, Any] = {"kernel": compiled(function), "carray": carray}
    exec(source, scope)
    returned = getattr(types, result) if result else types.void
    dispatcher = numba.njit(returned(*signature), error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
    found = dispatcher(scope[name])
    (made,) = found.overloads.values()
    return made.fndesc.llvm_func_name, made.library.get_llvm_str()


def emitted(texts: Sequence[str], visible: Collection[str]) -> bytes:
    """Return intermediate code as an object file for the linker.

    Parameters
    ----------
    texts : sequence of str
        What is linked together; the first may be called by those behind it.
    visible : collection of str
        The functions that are seen from outside.

    Raises
    ------
    InputError
        If a function is needed that the machine does not have.
    """
    from llvmlite import binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    module = llvm.parse_assembly(_for_machine(texts[0]))
    for text in texts[1:]:
        module.link_in(llvm.parse_assembly(_for_machine(text)))
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name not in visible:
            each.linkage = "internal"
    machine = llvm.Target.from_triple(TRIPLE).create_target_machine(
        cpu="generic", features=FEATURES, opt=3, reloc="static"
    )
    tuning = llvm.create_pipeline_tuning_options(speed_level=SPEED)
    tuning.loop_vectorization = tuning.slp_vectorization = True
    passes = llvm.create_pass_builder(machine, tuning)
    passes.getModulePassManager().run(module, passes)
    missing = [f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")]
    if missing:
        raise InputError(f"the kernels need {', '.join(missing)}, which a module that imports nothing cannot have")
    return bytes(machine.emit_object(module))


def _for_machine(text: str) -> str:
    """Return intermediate code as the other machine wants it, without what only Python's exceptions need."""
    text = re.sub(r"^target .*\n", "", text, flags=re.MULTILINE)
    text = f'target datalayout = "{LAYOUT}"\ntarget triple = "{TRIPLE}"\n{text}'
    text = text.replace("= common ", "= internal ")
    text = re.sub(r"ptr @\.const\.picklebuf\.[\w.]+", "ptr null", text)  # an error traps, whatever it would say
    text = re.sub(r"^attributes (#\d+) = \{ noinline \}", r"attributes \1 = { alwaysinline }", text, flags=re.MULTILINE)
    for name in ("sqrt", "floor", "ceil"):
        text = re.sub(rf"@{name}\(", f"@llvm.{name}.f64(", text)
    text, many = re.subn(r"= frem double ([^,\n]+), ([^,\n]+)", r"= call double @fmod(double \1, double \2)", text)
    text += "\ndeclare double @fmod(double, double)\n" if many else ""
    for name in OWN:
        text = re.sub(rf"@(llvm\.{name}\.f64|{name})\(", f"@grazing_own_{name}(", text)
    return text.replace("@llvm.smul.with.overflow.i64(", "@grazing_product(")
