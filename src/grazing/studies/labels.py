"""What a study writes beside its numbers: CF-style attributes, and the configuration with its hash.

Attributes are text, numbers or arrays of numbers, so that they survive NetCDF: no dict, None or bool.
"""

from __future__ import annotations

import hashlib
import json
import math
import sys
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.kernel.compile import processor
from grazing.kernel.content import identity
from grazing.maps.hits import Alphabet
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER, Map
from grazing.outcome import Outcome

Attributes = dict[str, Any]

REFERENCE = "Pring and Budd, IMA Journal of Applied Mathematics 76 (2011) 67-84"


def quantity(P: Map, name: str) -> Attributes:
    """Return the attributes of a parameter or coordinate of a map."""
    return P.describe(name).attributes


def period_attributes(limit: int) -> Attributes:
    """Return the attributes of a period, sought up to a limit."""
    return {
        "long_name": "period of the orbit",
        "units": "1",
        "flag_values": np.array([0, -1, -2], np.int32),
        "flag_meanings": "undecided aperiodic_as_far_as_seen ended",
        "period_limit": limit,
    }


def word_attributes() -> Attributes:
    """Return the attributes of a word."""
    return {"long_name": "primitive cyclic word in its least rotation; empty where there is no period"}


def longest_word(limit: int, symbols: str | Alphabet | None = None) -> int:
    """Return how many characters a word of so many letters may take: a count is at most 10,001, in parentheses."""
    return (symbols.most + 2 if isinstance(symbols, Alphabet) else 7) * max(limit, 1)


def letter_attributes(P: Map) -> Attributes:
    """Return the attributes of the letters of a map."""
    if P.letters is None:
        special = np.array([CHATTER_LETTER, STUCK_LETTER], np.int32)
        meanings = "completed_chatter stuck_throughout"
        return {"long_name": "letter of the step: a count", "flag_values": special, "flag_meanings": meanings}
    if isinstance(P.letters, Alphabet):
        return P.letters.attributes
    codes = np.arange(len(P.letters), dtype=np.int32)
    return {"long_name": "letter of the step", "flag_values": codes, "flag_meanings": " ".join(P.letters)}


def outcome_attributes() -> Attributes:
    """Return the attributes of an outcome; its bits add up, so that CF asks for masks."""
    flags = [flag for flag in Outcome if flag]
    return {
        "long_name": "what happened along the orbit, transient included",
        "flag_masks": np.array([flag.value for flag in flags], np.int32),
        "flag_meanings": " ".join(str(flag.name) for flag in flags),
    }


def trust_attributes() -> Attributes:
    """Return the attributes of the trust in the letters and points of an orbit."""
    return {
        "long_name": "how far to trust letters and points",
        "flag_values": np.array([0, 1, 2], np.int8),
        "flag_meanings": "certified numerical ambiguous",
    }


def units(P: Map, *names: str) -> str:
    """Return the units of coordinates of the oscillator, "u", "v" or "t", one after the other; "1" of other maps."""
    return P.origin.units_of(names)


def nearness_attributes(P: Map) -> dict[str, Attributes]:
    """Return the attributes of how near an orbit came to being another one."""
    miss, slow = "height of the narrowest miss of the wall", "speed of the slowest impact"
    return {
        "near_miss": {"long_name": f"{miss}, infinity for none", "units": units(P, "u")},
        "slowest": {"long_name": f"{slow}, infinity for none", "units": units(P, "v")},
        "undecided": {"long_name": "steps with a decision that could not be made for certain", "units": "1"},
    }


def document(P: Map, title: str, config: Mapping[str, Any]) -> Attributes:
    """Return the attributes of a whole result.

    Parameters
    ----------
    P : Map
    title : str
    config : mapping
        All that decides the numbers, as JSON can write it; the map's name, coordinates and parameters are added.

    Returns
    -------
    dict
        ``title``, ``source``, ``references``, ``grazing_config`` (JSON, keys sorted), ``grazing_config_sha256`` of
        that text, ``grazing_code_sha256`` of the map's bytecode, see :func:`map_code` (another Python, another
        bytecode: that is why it stands beside the configuration), ``grazing_versions`` (JSON), and
        ``grazing_processor``, for which fast arithmetic was compiled: *any* for strict arithmetic; of a model in SI
        units ``mass``, in kg.
    """
    described = {"map": P.name, "coordinates": list(P.coordinates), "params": dict(P.params), **config}
    described |= P.origin.config
    described |= {"escape": P.escape} if math.isfinite(P.escape) else {}
    described |= {"letters": P.letters} if isinstance(P.letters, str) and is_own(P) else {}
    text = json.dumps(described, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return {
        "title": title,
        "source": f"grazing {own_version()}",
        "references": REFERENCE,
        "Conventions": "CF-1.11",
        "grazing_config": text,
        "grazing_config_sha256": hashlib.sha256(text.encode()).hexdigest(),
        "grazing_code_sha256": map_code(P),
        "grazing_versions": json.dumps(versions(), sort_keys=True),
        **P.origin.attributes,
        "grazing_processor": "any" if config.get("arithmetic") == "strict" else processor(),
    }


def is_own(P: Map) -> bool:
    """Whether a map is none of the library's."""
    return P.origin.replace is None


def map_code(P: Map) -> str:
    """Return a hash of the code of a map: of its step, and of all functions of one of the user's own."""
    return identity(P.step, P.prepare, P.tangent) if is_own(P) else identity(P.step)


def own_version() -> str:
    """Return the version of this package."""
    return str(sys.modules["grazing"].__version__)  # it is imported: we are inside it


def versions() -> dict[str, str]:
    """Return the versions of what computes the numbers."""
    python = ".".join(map(str, sys.version_info[:3]))
    return {"grazing": own_version(), "python": python} | {
        package: installed(package) for package in ("llvmlite", "numba", "numpy")
    }


@cache
def installed(package: str) -> str:
    """Return the version of a package, which is looked for in the folders of all packages: once."""
    try:
        return version(package)
    except PackageNotFoundError:  # pragma: no cover
        return "unknown"


def fingerprint(array: NDArray[np.float64]) -> str:
    """Return the SHA-256 of an array's numbers, the same on every machine."""
    return hashlib.sha256(np.ascontiguousarray(array, "<f8").tobytes()).hexdigest()
