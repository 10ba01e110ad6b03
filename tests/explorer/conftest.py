import json
import os
import threading
from pathlib import Path

import pytest

from grazing.explorer.build import DESCRIPTION, FOLDER, MODULES
from grazing.explorer.server import server
from tests.explorer.browser import CHROMIUM, Shown

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


@pytest.fixture(scope="session")
def address():
    """Where the page is served."""
    with server() as ours:
        thread = threading.Thread(target=ours.serve_forever, kwargs={"poll_interval": 0.05})
        thread.start()
        yield ours.address
        ours.shutdown()
        thread.join()


@pytest.fixture(scope="session")
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
    if CHROMIUM is None:
        pytest.skip("no Chromium found: install one, or name it in GRAZING_CHROMIUM")
    with playwright.sync_playwright() as found:
        running = found.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield running
        running.close()


@pytest.fixture
def motion():
    """Whether the reader wants things to move: where nobody looks, a ball's flight is a third of the work."""
    return "no-preference"


@pytest.fixture
def shown(browser, motion):
    """A page of its own, in which nothing may go wrong unseen."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion=motion)
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    page = Shown(context.new_page())
    yield page
    errors = page.errors
    context.close()
    assert errors == []
