"""A wheel that holds prepared kernels is one for its system, processor and Python; one without is for all."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Prepared(BuildHookInterface):  # type: ignore[type-arg]
    """Add the prepared kernels to a wheel, if there are any: see ``scripts/wheel.sh``."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Say what goes into the wheel, and for whom it is."""
        if version == "standard" and any(Path(self.root, "src/grazing/prepared").glob("stamp-*")):
            build_data["artifacts"].append("/src/grazing/prepared/")
            build_data["pure_python"], build_data["infer_tag"] = False, True
