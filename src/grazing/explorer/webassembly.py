"""A WebAssembly module of kernels: what it exports, the memory that they share, and the linker that writes it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from grazing.kernel.export import OWN, borrowed_by, emitted, lowered, refuse_elsewhere
from grazing.outcome import InputError

#: Bytes of the stack, which lies below everything else, so that an overflow traps.
STACK = 65536

#: Kinds of numbers: the type in an array, and in the intermediate code.
KINDS = {"float64": "double", "int32": "i32", "int64": "i64", "int8": "i8"}

# Numbers of bytes, whose product cannot overflow 64 bits in a memory of 32.
SAFE = """
define { i64, i1 } @grazing_product(i64 %a, i64 %b) alwaysinline {
  %product = mul i64 %a, %b
  %pair = insertvalue { i64, i1 } { i64 undef, i1 false }, i64 %product, 0
  ret { i64, i1 } %pair
}
"""

# Arrays that a kernel makes and drops: a stack of blocks. A block is given back when it and all above it are dropped.
ARENA = """
%info = type { i64, ptr, ptr, ptr, i64 }
@__heap_base = external global i8
@grazing_free = internal global i32 0
@grazing_last = internal global ptr null
declare i32 @llvm.wasm.memory.size.i32(i32)
declare i32 @llvm.wasm.memory.grow.i32(i32, i32)
declare void @llvm.trap()

define void @grazing_arena(i32 %address) "wasm-export-name"="arena" {
  store i32 %address, ptr @grazing_free
  store ptr null, ptr @grazing_last
  ret void
}

define noalias ptr @NRT_MemInfo_alloc_aligned(i64 %wanted, i32 %align) noinline {
entry:
  %known = load i32, ptr @grazing_free
  %unset = icmp eq i32 %known, 0
  %base = ptrtoint ptr @__heap_base to i32
  %begin = select i1 %unset, i32 %base, i32 %known
  %room = add i32 %begin, 95
  %data = and i32 %room, -64
  %from = zext i32 %data to i64
  %to = add i64 %from, %wanted
  %large = icmp ugt i64 %to, 4294901760
  br i1 %large, label %fail, label %fits
fits:
  %end = trunc i64 %to to i32
  %pages = call i32 @llvm.wasm.memory.size.i32(i32 0)
  %top = add i32 %end, 65535
  %needed = lshr i32 %top, 16
  %short = icmp ugt i32 %needed, %pages
  br i1 %short, label %grow, label %done
grow:
  %more = sub i32 %needed, %pages
  %got = call i32 @llvm.wasm.memory.grow.i32(i32 0, i32 %more)
  %failed = icmp eq i32 %got, -1
  br i1 %failed, label %fail, label %done
fail:
  call void @llvm.trap()
  unreachable
done:
  store i32 %end, ptr @grazing_free
  %place = sub i32 %data, 32
  %info = inttoptr i32 %place to ptr
  %last = load ptr, ptr @grazing_last
  store i64 1, ptr %info
  %below = getelementptr %info, ptr %info, i32 0, i32 2
  store ptr %last, ptr %below
  %held = getelementptr %info, ptr %info, i32 0, i32 3
  %numbers = inttoptr i32 %data to ptr
  store ptr %numbers, ptr %held
  %start = getelementptr %info, ptr %info, i32 0, i32 4
  %begin64 = zext i32 %begin to i64
  store i64 %begin64, ptr %start
  store ptr %info, ptr @grazing_last
  ret ptr %info
}

define void @NRT_MemInfo_call_dtor(ptr %dropped) noinline {
entry:
  br label %next
next:
  %last = load ptr, ptr @grazing_last
  %none = icmp eq ptr %last, null
  br i1 %none, label %done, label %look
look:
  %count = load i64, ptr %last
  %used = icmp ne i64 %count, 0
  br i1 %used, label %done, label %pop
pop:
  %below = getelementptr %info, ptr %last, i32 0, i32 2
  %under = load ptr, ptr %below
  %start = getelementptr %info, ptr %last, i32 0, i32 4
  %begin64 = load i64, ptr %start
  %begin = trunc i64 %begin64 to i32
  store i32 %begin, ptr @grazing_free
  store ptr %under, ptr @grazing_last
  br label %next
done:
  ret void
}
"""


@dataclass(frozen=True, slots=True)
class Argument:
    """What a function of a module is given: a number, or the address of an array.

    Parameters
    ----------
    name : str
    kind : str
        ``float64`` or ``int64`` for a number (the second is passed as 32 bits); of an array the type of its numbers,
        one of :data:`KINDS`.
    shape : tuple of str or int
        Of an array: its sizes, by name or number, last index fastest; empty for a number.
    meaning : str
    """

    name: str
    kind: str
    shape: tuple[str | int, ...] = ()
    meaning: str = ""


@dataclass(frozen=True, slots=True)
class Entry:
    """A function of a module, around a kernel.

    Parameters
    ----------
    name : str
    kernel : callable
        A plain Python function of ``arguments``, arrays as arrays.
    sizes : tuple of str
        Whole numbers that come first and say how large the arrays are; the kernel itself reads shapes.
    arguments : tuple of Argument
    result : str
        ``float64``, ``int64`` (returned as 32 bits), or empty.
    meaning : str
    addressed : bool
        Whether the function that is exported, of nothing, says where the kernel lies, for those that call kernels by
        address.
    """

    name: str
    kernel: Callable[..., Any]
    sizes: tuple[str, ...]
    arguments: tuple[Argument, ...]
    result: str = ""
    meaning: str = ""
    addressed: bool = False


def linker() -> list[str] | None:
    """Return the command of the WebAssembly linker found here; None for none.

    That is what ``$GRAZING_WASM_LD`` says, else ``wasm-ld`` on the path, else the one of the package *ziglang*.
    """
    own = os.environ.get("GRAZING_WASM_LD")
    if own:
        return own.split()
    found = shutil.which("wasm-ld")
    if found is not None:
        return [found]
    return None if find_spec("ziglang") is None else [sys.executable, "-m", "ziglang", "wasm-ld"]


def linker_version(command: Sequence[str]) -> str:
    """Return what a linker says of itself, such as ``LLD 20.1.2``."""
    said = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True).stdout
    found = re.search(r"LLD [0-9.]+", said)
    return found.group() if found else said.strip()


def exported(entries: Sequence[Entry], borrowed: set[str] | None = None) -> bytes:
    """Compile kernels to a WebAssembly module that imports nothing.

    Parameters
    ----------
    entries : sequence of Entry
        What the module exports, beside ``memory``, ``__heap_base``, from where on memory is free, and
        ``arena(address)``, which says where kernels may put arrays of their own.
    borrowed : set of str, optional
        The functions of the C library are added that the step calls: it may have another last digit in the module.

    Returns
    -------
    bytes
        The module; the same bytes for the same kernels, numba, llvmlite and linker.

    Raises
    ------
    InputError
        In a process without :data:`grazing.kernel.export.ENVIRONMENT`, without a linker, or for a kernel that needs a
        function that the machine does not have.
    """
    refuse_elsewhere()
    command = linker()
    if command is None:
        raise InputError("no WebAssembly linker: install lld (apt) or ziglang (pip), or set GRAZING_WASM_LD")
    own = [
        Entry(f"own_{name}", function, (), tuple(Argument(x, "float64") for x in "xy"[:arguments]), "float64")
        for name, (function, arguments) in OWN.items()
    ]
    texts = [ARENA + SAFE]
    for entry in [*own, *entries]:
        arguments = [(argument.name, argument.kind, argument.shape) for argument in entry.arguments]
        name, text = lowered(entry.name, entry.kernel, entry.sizes, arguments, entry.result)
        texts += [text, _door(entry, name)]
        if borrowed is not None and entry.name == "orbits":
            borrowed |= borrowed_by(text)
            if missing := borrowed - OWN.keys():
                raise InputError(f"{', '.join(sorted(missing))}: a module that imports nothing cannot have that")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "kernels.o", Path(folder) / "kernels.wasm"
        source.write_bytes(emitted(texts, {"grazing_arena", *(f"grazing_{entry.name}" for entry in entries)}))
        flags = ["--no-entry", "--export=__heap_base", "--stack-first", "-z", f"stack-size={STACK}", "--strip-all"]
        done = subprocess.run([*command, str(source), "-o", str(target), *flags], capture_output=True, text=True)
        if done.returncode:
            raise InputError(f"the linker {' '.join(command)} failed: {done.stderr.strip()[:500]}")
        return target.read_bytes()


def _door(entry: Entry, name: str) -> str:
    """Return the code of the exported function: 32 bits for whole numbers, a trap for an error."""
    outer, inner = [], ["ptr %result", "ptr %error"]
    code, types = [], ["ptr", "ptr"]
    arguments = [Argument(size, "int64") for size in entry.sizes] + list(entry.arguments)
    for i, argument in enumerate(arguments):
        kind = "ptr" if argument.shape else KINDS[argument.kind]
        types.append(kind)
        if kind == "i64":
            outer.append(f"i32 %a{i}")
            code.append(f"  %w{i} = sext i32 %a{i} to i64")
            inner.append(f"i64 %w{i}")
        else:
            outer.append(f"{kind} %a{i}")
            inner.append(f"{kind} %a{i}")
    declared = f"declare i32 @{_quoted(name)}({', '.join(types)})"
    if entry.addressed:
        head = f'define i32 @grazing_{entry.name}() "wasm-export-name"="{entry.name}" {{'
        return "\n".join([declared, head, f"  ret i32 ptrtoint (ptr @{_quoted(name)} to i32)", "}", ""])
    room = KINDS[entry.result] if entry.result else "ptr"
    given = {"": "void", "float64": "double", "int64": "i32"}[entry.result]
    back = {
        "": ["  ret void"],
        "float64": ["  %value = load double, ptr %result", "  ret double %value"],
        "int64": ["  %value = load i64, ptr %result", "  %short = trunc i64 %value to i32", "  ret i32 %short"],
    }[entry.result]
    return "\n".join(
        [
            declared,
            "declare void @llvm.trap()",
            f'define {given} @grazing_{entry.name}({", ".join(outer)}) "wasm-export-name"="{entry.name}" {{',
            f"  %result = alloca {room}",
            "  %error = alloca ptr",
            *code,
            f"  %status = call i32 @{_quoted(name)}({', '.join(inner)})",
            "  %failed = icmp ne i32 %status, 0",
            "  br i1 %failed, label %fail, label %done",
            "fail:",
            "  call void @llvm.trap()",
            "  unreachable",
            "done:",
            *back,
            "}",
            "",
        ]
    )


def _quoted(name: str) -> str:
    return f'"{name}"'
