"""Which chunks of a store were made by what: all by the code that it was begun with, or a mixture."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from grazing.sweep.manifest import Record
from grazing.sweep.same import listed
from grazing.sweep.store import Store


@dataclass(frozen=True)
class Shares:
    """Who made the chunks: ``who[number]`` counts through ``makers``, of which the first began the sweep."""

    makers: tuple[Mapping[str, str], ...]
    who: Mapping[int, int]

    @property
    def mixed(self) -> bool:
        """Whether any chunk was made by another code than the first."""
        return any(self.who.values())

    @property
    def attrs(self) -> dict[str, Any]:
        """Attributes of the variable that says who made a cell."""
        return {
            "long_name": "which code made a cell",
            "flag_values": np.arange(-1, len(self.makers), dtype=np.int32),
            "flag_meanings": " ".join(["missing", "begun_by", *(f"other_{i}" for i in range(1, len(self.makers)))]),
            "makers": json.dumps([dict(maker) for maker in self.makers]),
        }

    def __str__(self) -> str:
        counts = Counter(self.who.values())
        parts = [f"{counts[0]} of {len(self.who)} chunks by the code that the sweep was begun with"]
        for i, maker in enumerate(self.makers[1:], start=1):
            differs = listed(self.makers[0], maker, ("there", "in these"))
            parts.append(f"{counts[i]} by other code ({differs})")
        return "; ".join(parts)


def shares_of(store: Store, records: Mapping[int, Record | None]) -> Shares:
    """Return who made the chunks of some records."""
    makers: dict[str, int] = {_text(store.begun_by): 0}
    who = {
        number: makers.setdefault(_text(record.made_by), len(makers))
        for number, record in records.items()
        if record is not None
    }
    return Shares(tuple(json.loads(text) for text in makers), who)


def _text(maker: Mapping[str, str]) -> str:
    return json.dumps(dict(maker), sort_keys=True)
