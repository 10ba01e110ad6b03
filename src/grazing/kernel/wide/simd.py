"""What the wide forms are written with: numbers side by side, as wide as the processor takes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import ir

from grazing.kernel.private import cgutils

number, whole, short = ir.DoubleType(), ir.IntType(64), ir.IntType(32)


def features(context: Any) -> str:
    """Return what the processor that is compiled for can do."""
    return str(context.codegen().magic_tuple()[2])


def register_bytes(context: Any) -> int:
    """Return how long a register is."""
    able = features(context)
    return 64 if "+avx512f" in able else 32 if "+avx" in able else 16


def width_for(context: Any) -> int:
    """Return how many numbers a register holds, at least four: what is wider than a register takes several."""
    return max(register_bytes(context) // 8, 4)


class Lanes:
    """Numbers side by side, with the operators of a number."""

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    def __add__(self, other: Lanes) -> Lanes:
        return Lanes(self.builder, self.builder.fadd(self.value, other.value))

    def __sub__(self, other: Lanes) -> Lanes:
        return Lanes(self.builder, self.builder.fsub(self.value, other.value))

    def __mul__(self, other: Lanes) -> Lanes:
        return Lanes(self.builder, self.builder.fmul(self.value, other.value))

    def __abs__(self) -> Lanes:
        kind = self.value.type
        name = f"llvm.fabs.v{kind.count}f64"
        function = cgutils.get_or_insert_function(self.builder.module, ir.FunctionType(kind, [kind]), name)
        return Lanes(self.builder, self.builder.call(function, [self.value]))

    def lower(self, other: Lanes) -> Lanes:
        """Return the smaller numbers; those of ``other`` where there are none."""
        return self.where(self.builder.fcmp_ordered("<", self.value, other.value), other)

    def where(self, mask: Any, other: Lanes) -> Lanes:
        """Return the numbers where the mask is true, those of ``other`` elsewhere."""
        return Lanes(self.builder, self.builder.select(mask, self.value, other.value))


class Memory:
    """Numbers from an address on, in vectors of ``width``."""

    def __init__(self, builder: Any, address: Any, width: int) -> None:
        self.builder, self.address, self.kind = builder, address, ir.VectorType(number, width)

    def place(self, index: Any) -> Any:
        """Return the address of a vector."""
        return self.builder.bitcast(self.builder.gep(self.address, [index]), self.kind.as_pointer())

    def load(self, index: Any) -> Lanes:
        """Return the numbers from a place on."""
        found = self.builder.load(self.place(index))
        found.align = 8
        return Lanes(self.builder, found)

    def store(self, lanes: Lanes, index: Any) -> None:
        """Write numbers from a place on."""
        self.builder.store(lanes.value, self.place(index)).align = 8

    def everywhere(self, index: Any) -> Lanes:
        """Return the number at a place, in all lanes."""
        return equal(self.builder, self.builder.load(self.builder.gep(self.address, [index])), self.kind.count)


def equal(builder: Any, value: Any, width: int) -> Lanes:
    """Return equal numbers."""
    first = builder.insert_element(ir.Constant(ir.VectorType(number, width), ir.Undefined), value, short(0))
    kind = ir.Constant(ir.VectorType(short, width), [0] * width)
    return Lanes(builder, builder.shuffle_vector(first, first, kind))


def constant(builder: Any, value: float, width: int) -> Lanes:
    """Return equal numbers that are known now."""
    return Lanes(builder, ir.Constant(ir.VectorType(number, width), [value] * width))


class Held:
    """Lanes that a loop changes."""

    def __init__(self, lanes: Lanes) -> None:
        self.builder, self.slot = lanes.builder, cgutils.alloca_once_value(lanes.builder, lanes.value)

    def get(self) -> Lanes:
        """Return what is held."""
        return Lanes(self.builder, self.builder.load(self.slot))

    def set(self, lanes: Lanes) -> None:
        """Hold other numbers from now on."""
        self.builder.store(lanes.value, self.slot)


@contextmanager
def counted(builder: Any, start: Any, end: Any, step: int) -> Iterator[Any]:
    """Count from ``start`` on in steps, as long as a whole number is below ``end``."""
    with cgutils.for_range_slice(builder, start, end, whole(step), intp=whole) as (n, _count):
        yield n


def in_groups(builder: Any, start: Any, end: Any, width: int, size: int, body: Any) -> None:
    """Call ``body(places)`` for all vectors from ``start`` to ``end``, ``size`` of them at a time, then one by one.

    What is wanted of several at a time needs its constants once only.
    """
    several = size * width
    room = builder.sub(end, start)
    some = builder.add(start, builder.mul(builder.sdiv(room, whole(several)), whole(several)))
    with counted(builder, start, some, several) as n:
        body([builder.add(n, whole(k * width)) for k in range(size)])
    with counted(builder, some, end, width) as n:
        body([n])
