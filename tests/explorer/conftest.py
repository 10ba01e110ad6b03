import json
import os
import threading
from contextlib import contextmanager
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


@pytest.fixture(scope="session")
def pages(browser):
    """Give a page, in which nothing may go wrong unseen: loaded, or kept open from test to test."""
    open_ones = {}

    @contextmanager
    def one(kept, **reader):
        key = json.dumps(reader)
        page = open_ones.pop(key, None) if kept else None
        if page is None:
            context = browser.new_context(**reader)
            context.grant_permissions(["clipboard-read", "clipboard-write"])
            page = Shown(context.new_page())
        yield page
        errors = page.errors
        if kept and not errors:
            page.rest(reader["viewport"])
            open_ones[key] = page
        else:
            page.page.context.close()
        assert errors == []

    yield one
    for page in open_ones.values():
        page.page.context.close()


@pytest.fixture
def kept():
    """Whether a page stays open for the next test, which goes to its link there: to load one is most of the work."""
    return False


@pytest.fixture
def shown(pages, motion, kept):
    with pages(kept, viewport={"width": 1280, "height": 800}, reduced_motion=motion) as page:
        yield page


@pytest.fixture
def phone(pages, motion, kept):
    size = {"width": 390, "height": 844}
    with pages(kept, viewport=size, reduced_motion=motion, has_touch=True, is_mobile=True) as page:
        yield page
