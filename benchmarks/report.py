"""What was measured, as one JSON file."""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median
from typing import Any

from .chatter import Chatter
from .explorer import Response
from .flippers import Basins, Flips
from .forms import Brought
from .measure import Result, beside, ratio
from .pinball import Rate
from .shallow import DEPTHS, Shallow
from .studies import Cost

PACKAGES = ("grazing", "numba", "numpy", "scipy", "heyoka", "diffrax", "jax", "scikit-sundae")


def write(
    file: Path,
    rounds: int,
    results: Sequence[Result],
    seen: Sequence[Shallow],
    bounces: Sequence[Chatter],
    costs: Sequence[Cost] = (),
    responses: Sequence[Response] = (),
    brought: Sequence[Brought] = (),
    balls: Sequence[Rate] = (),
    turned: Sequence[Flips] = (),
    ways: Basins | None = None,
) -> None:
    """Write everything to a JSON file; docs/benchmarks.md says what the fields mean."""
    content = {
        "schema": 1,
        "machine": {"system": platform.system(), "processor": platform.machine(), "cores": os.cpu_count()},
        "versions": {"python": platform.python_version(), **{name: installed(name) for name in PACKAGES}},
        "rounds": rounds,
        "rows": [row_fields(result, results) for result in results],
        "shallow": [{"name": s.name, "missing": s.missing, "depths": DEPTHS, "shares": s.shares} for s in seen],
        "chatter": [
            {
                "name": c.name,
                "r": c.r,
                "rest": c.rest,
                "missing": c.missing,
                **(c.followed._asdict() if c.followed else {}),
            }
            for c in bounces
        ],
        "studies": [asdict(one) for one in costs],
        "explorer": [asdict(one) for one in responses],
        "forms": [asdict(one) for one in brought],
        "pinball": [asdict(one) for one in balls],
        "flippers": [asdict(one) for one in turned],
        "basins": asdict(ways) if ways else None,
    }
    file.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def row_fields(result: Result, results: Sequence[Result]) -> dict[str, Any]:
    """Return one row of the speed table."""
    fields: dict[str, Any] = {
        "name": result.row.name,
        "unit": result.row.unit,
        "threads": result.row.threads,
        "missing": result.missing,
    }
    if not result.seconds or result.job is None:
        return fields
    other, rates, verdict = beside(result, results), result.rates, result.job.verdict
    return {
        **fields,
        "amount": result.job.amount,
        "seconds": result.seconds,
        "cpu": result.cpu,
        "rate": median(rates),
        "rate_min": min(rates),
        "rate_max": max(rates),
        "beside": other.row.name if other else None,
        "ratio": ratio(other, result) if other else None,
        "verdict": {name: finite(value) for name, value in verdict._asdict().items()} if verdict else None,
        "note": result.job.note,
    }


def finite(value: float | None) -> float | None:
    """Return the number, or None for what JSON cannot say."""
    return value if value is not None and math.isfinite(value) else None


def installed(name: str) -> str | None:
    """Return the version of a package, or None if it is not installed."""
    try:
        return version(name)
    except PackageNotFoundError:
        return None
