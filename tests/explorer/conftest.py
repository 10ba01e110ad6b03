import json
import os
from pathlib import Path

import pytest

from grazing.explorer.build import DESCRIPTION, FOLDER, MODULES

#: The modules that are tested: those of the package, or those that another linker made of the same kernels.
KERNELS = Path(os.environ.get("GRAZING_KERNELS") or FOLDER)


@pytest.fixture(scope="session")
def described():
    return json.loads((KERNELS / DESCRIPTION).read_text(encoding="utf-8"))["modules"]


@pytest.fixture(scope="session")
def machines(described):
    """The modules, running."""
    from tests.explorer.machine import Module

    return {name: Module((KERNELS / described[name]["file"]).read_bytes(), described[name]) for name in MODULES}
