"""Who made a chunk: the code and the versions that its bits depend on."""

from __future__ import annotations

import hashlib
import platform
from functools import cache, lru_cache
from pathlib import Path

from grazing.kernel.compile import processor
from grazing.studies.labels import map_code, versions
from grazing.studies.plan import Plan

#: The parts of this package that numbers come from.
COMPUTING = (
    "kernel", "theory", "systems", "billiard", "oscillator", "maps", "orbits", "studies", "parameter.py", "outcome.py",
)  # fmt: skip
#: What does not matter in strict arithmetic, which has the same bits everywhere.
ANY = "any"


@lru_cache(maxsize=2)
def made_by(plan: Plan) -> dict[str, str]:
    """Return what makes the chunks of a plan in this process.

    ``code`` is the SHA-256 of the map's functions, ``package`` that of the text of this package as far as numbers come
    from it; then the arithmetic, the processor and the system, which are *any* in strict arithmetic, and the versions.
    """
    strict = plan.config.get("arithmetic") == "strict"
    return {
        "code": map_code(plan.P),
        "package": _package(),
        "arithmetic": str(plan.config.get("arithmetic", "")),
        "processor": ANY if strict else processor(),
        "machine": ANY if strict else f"{platform.system()} {platform.machine()}",
        **versions(),
    }


@cache
def _package() -> str:
    root, found = Path(__file__).parents[1], hashlib.sha256()
    for part in COMPUTING:
        for file in sorted((root / part).rglob("*.py")) or [root / part]:
            found.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return found.hexdigest()
