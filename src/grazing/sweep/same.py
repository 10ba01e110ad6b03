"""Whether a store holds the very sweep that a plan describes; if not, what differs, by name."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from grazing.outcome import InputError
from grazing.studies.plan import Plan
from grazing.sweep.grid import Chunk, grid_of
from grazing.sweep.layout import laid_out
from grazing.sweep.store import Store

#: Differences that are named, and letters of a value that are shown.
NAMED, SHOWN = 8, 60
_ABSENT = object()


def refuse_another(store: Store, plan: Plan, chunk: Chunk = None, other_code: bool = False) -> None:
    """Raise InputError if a store was not begun by this plan, naming what differs.

    Parameters
    ----------
    store : Store
    plan : Plan
    chunk : int or mapping, optional
        If given, it must be the one of the store.
    other_code : bool
        Accept another step or another version of this package.
    """
    here = plan.document
    if store.attrs["grazing_config_sha256"] != here["grazing_config_sha256"]:
        config = json.loads(store.attrs["grazing_config"]), json.loads(here["grazing_config"])
        raise InputError(
            f"{store.path} holds another sweep: {listed(*config)}. Give the values that it was begun with, "
            f"or another folder"
        )
    keys = ("grazing_code_sha256", "grazing_processor", "source")
    code = {key: store.attrs[key] for key in keys}, {key: here[key] for key in keys}
    if code[0] != code[1] and not other_code:
        versions = json.loads(store.attrs["grazing_versions"]), json.loads(here["grazing_versions"])
        also = f"; of the versions, {listed(*versions)}" if versions[0] != versions[1] else ""
        raise InputError(
            f"{store.path} was begun by other code: {listed(*code)}{also}. Go on with that code, give another folder, "
            f"or allow the mixture with other_code=True; strict arithmetic is the same on every processor"
        )
    if chunk is not None and grid_of(plan, chunk).chunk != store.grid.chunk:
        sizes = ", ".join(f"{name}: {size}" for name, size in zip(plan.axes, store.grid.chunk, strict=True))
        raise InputError(f"{store.path} was begun with chunks of {{{sizes}}}, which stay; leave chunk out")
    if laid_out(plan, store.grid)[0].text() != store.layout.text():
        raise InputError(
            f"{store.path} was begun by another version, which stored other variables; give another folder"
        )


def listed(there: Mapping[str, Any], here: Mapping[str, Any]) -> str:
    """Return the differences of two configurations in words."""
    found = list(_differences(there, here, ""))
    more = f"; and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return "; ".join(found[:NAMED]) + more


def _differences(there: Any, here: Any, name: str) -> Iterator[str]:
    if isinstance(there, Mapping) and isinstance(here, Mapping):
        for key in sorted({**there, **here}):
            inner = f"{name}.{key}" if name else str(key)
            yield from _differences(there.get(key, _ABSENT), here.get(key, _ABSENT), inner)
    elif isinstance(there, list) and isinstance(here, list) and len(there) == len(here):
        for i, pair in enumerate(zip(there, here, strict=True)):
            yield from _differences(*pair, f"{name}[{i}]")
    elif there is _ABSENT or here is _ABSENT:
        value, where = (here, "here only") if there is _ABSENT else (there, "there only")
        yield f"{name} is {_shown(value)} {where}"
    elif there != here:
        yield f"{name} is {_shown(there)} there and {_shown(here)} here"


def _shown(value: Any) -> str:
    text = json.dumps(value) if not isinstance(value, str) else repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"
