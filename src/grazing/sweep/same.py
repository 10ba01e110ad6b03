"""Whether a store holds the very sweep that a plan describes; if not, what differs, by name."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from grazing.outcome import InputError
from grazing.studies.plan import Plan
from grazing.sweep.grid import Chunk, grid_of
from grazing.sweep.layout import Spec, laid_out
from grazing.sweep.made_by import made_by
from grazing.sweep.store import Store

#: Differences that are named, and letters of a value that are shown.
NAMED, SHOWN = 8, 60
_ABSENT = object()


class OtherCodeError(InputError):
    """The plan is that of the store, but what would compute it here is other code, or another version of a package."""


def refuse_another(store: Store, plan: Plan, chunk: Chunk = None, other_code: bool = False) -> None:
    """Raise InputError if a store was not begun by this plan, naming what differs.

    Parameters
    ----------
    store : Store
    plan : Plan
    chunk : int or mapping, optional
        If given, it must be the one of the store.
    other_code : bool
        Accept another step, or another version of this package or of one that it computes with.

    Raises
    ------
    OtherCodeError
        If that alone differs.
    """
    here = plan.document
    if store.attrs["grazing_config_sha256"] != here["grazing_config_sha256"]:
        config = json.loads(store.attrs["grazing_config"]), json.loads(here["grazing_config"])
        raise InputError(
            f"{store.path} holds another sweep: {listed(*config)}. Give the values that it was begun with, "
            f"or another folder"
        )
    layout, specs = laid_out(plan, store.grid)
    same = replace(layout, format=store.layout.format).text() == store.layout.text()
    if not same or any((spec.dims, spec.shape, spec.kind) != _form(store.arrays[name]) for name, spec in specs.items()):
        raise InputError(f"{store.path} was begun by another version, which stored other arrays; give another folder")
    begun, now = store.begun_by, made_by(plan)
    other = {key for key in begun if begun[key] != now.get(key)}
    if other and not other_code:
        there, here = ({key: one[key] for key in sorted(other) if key in one} for one in (begun, now))
        raise OtherCodeError(
            f"{store.path} was begun by other code: {listed(there, here)}. Go on with that code, give another folder, "
            f"or allow the mixture with other_code=True (--other-code), which the result then shows; strict "
            f"arithmetic is the same on every processor"
        )
    if chunk is not None and grid_of(plan, chunk).chunk != store.grid.chunk:
        sizes = ", ".join(f"{name}: {size}" for name, size in zip(plan.axes, store.grid.chunk, strict=True))
        raise InputError(f"{store.path} was begun with chunks of {{{sizes}}}, which stay; leave chunk out")


def _form(spec: Spec) -> tuple[tuple[str, ...], tuple[int, ...], str]:
    return spec.dims, spec.shape, spec.kind


def listed(there: Mapping[str, Any], here: Mapping[str, Any], words: tuple[str, str] = ("there", "here")) -> str:
    """Return the differences of two configurations in words."""
    found = list(_differences(there, here, "", words))
    more = f"; and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return "; ".join(found[:NAMED]) + more


def _differences(there: Any, here: Any, name: str, words: tuple[str, str]) -> Iterator[str]:
    if isinstance(there, Mapping) and isinstance(here, Mapping):
        for key in sorted({**there, **here}):
            inner = f"{name}.{key}" if name else str(key)
            yield from _differences(there.get(key, _ABSENT), here.get(key, _ABSENT), inner, words)
    elif isinstance(there, list) and isinstance(here, list) and len(there) == len(here):
        for i, pair in enumerate(zip(there, here, strict=True)):
            yield from _differences(*pair, f"{name}[{i}]", words)
    elif there is _ABSENT or here is _ABSENT:
        value, where = (here, words[1]) if there is _ABSENT else (there, words[0])
        yield f"{name} is {_shown(value)} {where} only"
    elif there != here:
        yield f"{name} is {_shown(there)} {words[0]} and {_shown(here)} {words[1]}"


def _shown(value: Any) -> str:
    text = json.dumps(value) if not isinstance(value, str) else repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"
