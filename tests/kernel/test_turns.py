"""Loops of which several turns are taken at once: the same numbers, in vectors side by side."""

import os
import re
from itertools import groupby

import numpy as np
import pytest
from llvmlite import binding

from grazing.kernel.compile import compiled
from grazing.kernel.primitives import numbers, picked
from grazing.kernel.turns import abreast, eights
from grazing.kernel.wide import plain

FEATURES = binding.get_host_cpu_features()


def chain(x):
    """A chain of operations, none of which can be left out."""
    for _ in range(12):
        x = x * x - 1.37
    return x


def by_registers(work, n):
    w = numbers(work)
    for base in range(0, n, 16):
        for k in range(16):
            i = base + abreast(k)
            w[i] = chain(w[i])


def by_eights(work, n):
    w = numbers(work)
    for base in range(0, n, 16):
        for k in range(16):
            i = base + eights(k)
            w[i] = chain(w[i])


def within(work, n):
    """Marks of two loops, inside a loop that has none, one of them behind a question."""
    w = numbers(work)
    for base in range(0, n, 16):
        if base != 16:
            for k in range(16):
                i = base + eights(k)
                w[i] = chain(w[i])
        for k in range(8):
            w[base + abreast(k)] += 1.0


for sweep in (by_registers, by_eights, within):
    sweep.__module__ = "grazing.tried"  # marks count in kernels of the library


@pytest.mark.parametrize("sweep", [by_registers, by_eights, within])
@pytest.mark.parametrize("arithmetic", ["strict", "fast"])
def test_the_numbers_are_those_of_one_turn_after_the_other(sweep, arithmetic):
    work = np.random.default_rng(3).uniform(-0.9, 0.9, 48)
    plain, fast = work.copy(), work.copy()
    sweep(plain, 48)
    compiled(sweep, arithmetic)(fast, 48)
    if arithmetic == "strict":
        assert np.array_equal(plain, fast)
    else:
        np.testing.assert_allclose(plain, fast, rtol=1e-9)


@pytest.mark.skipif(not FEATURES.get("avx2"), reason="counts registers of four numbers, or of eight")
@pytest.mark.skipif(bool(plain()), reason=f"plain forms are taken: {plain()}")
@pytest.mark.parametrize("turns", [4, 8])
def test_so_many_turns_stand_side_by_side(turns):
    """Of each operation there are so many in the loop, in vectors one after the other, before the next operation."""
    unseen = float.fromhex(f"0x1.{os.urandom(4).hex()}p0")  # no kernel on the disk has it

    def turn(w, i):
        x = w[i]
        for _ in range(12):
            x = x * x - unseen
        w[i] = x

    def in_registers(work, n):
        for base in range(0, n, 16):
            for k in range(16):
                turn(numbers(work), base + abreast(k))

    def in_eights(work, n):
        for base in range(0, n, 16):
            for k in range(16):
                turn(numbers(work), base + eights(k))

    sweep = in_registers if turns == 4 else in_eights
    sweep.__module__ = "grazing.tried"  # marks count in kernels of the library
    entry = compiled(sweep)
    entry(np.zeros(16), 16)
    (found,) = entry.overloads.values()
    operations = re.findall(r"= ((?:fmul|fadd) <\d x double>)", found.library.get_llvm_str())
    assert {int(name[6]) * len(list(alike)) for name, alike in groupby(operations)} == {turns}


@pytest.mark.skipif(not FEATURES.get("avx2"), reason="counts registers of four numbers, or of eight")
@pytest.mark.skipif(bool(plain()), reason=f"plain forms are taken: {plain()}")
def test_eight_turns_stand_side_by_side_where_rows_are_read_and_written():
    """Rows lie one behind the other: of so many turns as are not known some might read what others write."""
    unseen = float.fromhex(f"0x1.{os.urandom(4).hex()}p0")  # no kernel on the disk has it

    def sweep(work, n):
        w = numbers(work)
        for k in range(n):
            i = eights(k)
            x, y = w[i], w[64 + i]
            for _ in range(12):
                x = x * y - unseen
            w[64 + i], w[128 + i] = x, y

    sweep.__module__ = "grazing.tried"  # marks count in kernels of the library
    work = np.random.default_rng(3).uniform(-0.9, 0.9, 192)
    alone, entry = work.copy(), compiled(sweep)
    sweep(alone, 64)
    entry(work, 64)
    assert np.array_equal(work, alone)
    (found,) = entry.overloads.values()
    operations = re.findall(r"= ((?:fmul|fadd) <\d x double>)", found.library.get_llvm_str())
    assert {int(name[6]) * len(list(alike)) for name, alike in groupby(operations)} == {8}


@pytest.mark.skipif(not FEATURES.get("avx2") or FEATURES.get("avx512f"), reason="of processors that have no masks")
@pytest.mark.skipif(bool(plain()), reason=f"plain forms are taken: {plain()}")
def test_what_is_picked_is_neither_read_nor_written_by_a_mask():
    def sweep(work, n):
        w = numbers(work)
        for k in range(n):
            i = eights(k)
            w[i] = picked(w[64 + i] > 0.0, w[128 + i], w[i])

    sweep.__module__ = "grazing.tried"
    work = np.random.default_rng(3).uniform(-0.9, 0.9, 192)
    alone, entry = work.copy(), compiled(sweep)
    sweep(alone, 64)
    entry(work, 64)
    assert np.array_equal(work, alone)
    (found,) = entry.overloads.values()
    text = found.library.get_asm_str()
    assert "vblendvpd" in text and "maskmov" not in text


def test_a_mark_outside_of_every_loop_is_no_matter():
    def twice(k):
        return eights(k) + abreast(k)

    twice.__module__ = "grazing.tried"
    assert compiled(twice)(3) == 6
