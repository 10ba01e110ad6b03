import pytest

from grazing.explorer.build import FOLDER, MODULES, shipped


@pytest.fixture(scope="session")
def described():
    return shipped()["modules"]


@pytest.fixture(scope="session")
def machines(described):
    """The shipped modules, running."""
    from tests.explorer.machine import Module

    return {name: Module((FOLDER / described[name]["file"]).read_bytes(), described[name]) for name in MODULES}
