"""Kernels that were compiled before the first call: by the set-up of a checkout, or into a wheel.

They are the files of :mod:`grazing.kernel.disk`, in a folder of the package that is only read. A file is found by the
hash of all that its kernel is made of, so that an edited source, another numba or another Python finds none; and by the
processor that it was compiled for: this one, or a family that this one belongs to.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from grazing.interrupt import held_back

#: Families of processors, the ablest first: the name that the compiler knows, and what each of them can do. The last
#: of the oldest family makes vectors as wide as the registers, where the compiler by itself would not.
X86_64_V2 = "+cx16 +popcnt +sahf +sse3 +sse4.1 +sse4.2 +ssse3".split()
X86_64_V3 = [*X86_64_V2, *"+avx +avx2 +bmi +bmi2 +f16c +fma +lzcnt +movbe +xsave".split()]
X86_64_V4 = [*X86_64_V3, *"+avx512bw +avx512cd +avx512dq +avx512f +avx512vl".split()]
FAMILIES = {
    "x86-64-v4": ",".join([*sorted(X86_64_V4), "-prefer-256-bit"]),
    "x86-64-v3": ",".join(sorted(X86_64_V3)),
    "x86-64-v2": ",".join(sorted(X86_64_V2)),
}

#: Settings of numba by which it makes other code for one processor, and what they are unless it is told.
USUAL = {
    "OPT": "_OptLevel(3)",
    "LOOP_VECTORIZE": "1",
    "SLP_VECTORIZE": "0",
    "BOUNDSCHECK": "None",
    "DEBUGINFO_DEFAULT": "0",
    "EXTEND_VARIABLE_LIFETIMES": "0",
    "LLVM_REFPRUNE_PASS": "1",
    "USING_SVML": "False",
}

#: The files that this process has used.
used: set[str] = set()


def folder() -> Path:
    """Return where they are."""
    return Path(__file__).parents[1] / "prepared"


def machines(processor: tuple[str, str, str]) -> list[tuple[str, str, str]]:
    """Return the processors whose code runs on this one, as numba tells them: itself, then its families.

    Parameters
    ----------
    processor : tuple of str
        This processor: system, name and features.
    """
    system, _name, features = processor
    able = set(features.split(","))
    wanted = {name: {each for each in said.split(",") if each[0] == "+"} for name, said in FAMILIES.items()}
    return [processor, *((system, name, said) for name, said in FAMILIES.items() if wanted[name] <= able)]


@held_back()  # the compiler is imported
def own() -> tuple[str, str, str]:
    """Return the processor that is compiled for as :func:`machines` takes it, of no system.

    It is this one, unless the environment names another for numba, such as NUMBA_CPU_NAME=generic.
    """
    from llvmlite import binding
    from numba import config

    features = binding.get_host_cpu_features()
    features.update({name: False for name in features if name.startswith("avx") and not config.ENABLE_AVX})
    said = features.flatten() if config.CPU_FEATURES is None else config.CPU_FEATURES
    return "", config.CPU_NAME or binding.get_host_cpu_name(), said


@held_back()  # so is numba
def told() -> str:
    """Return what the environment tells numba, such as NUMBA_OPT=0, that makes other code; empty for nothing."""
    from numba import config

    said = {name: repr(getattr(config, name, None)) for name in USUAL}
    return " ".join(f"{name}={said[name]}" for name, usual in USUAL.items() if said[name] not in (usual, "None"))


def stamp(family: str = "") -> Path:
    """Return the file that says what prepared kernels were made from: for this processor, or for a family."""
    return folder() / (f"stamp-{family}" if family else "stamp")


@cache
def family(name: str, features: str) -> str:
    """Return the family whose prepared kernels a processor runs; empty where they are its own, or there are none."""
    others = [each for _system, each, _features in machines(("", name, features))[1:] if stamp(each).exists()]
    return others[0] if others and not stamp().exists() else ""
