import json
import os
import threading
from contextlib import contextmanager
from itertools import chain
from pathlib import Path

import pytest

from grazing.explorer.build import DESCRIPTION, FOLDER, MODULES
from grazing.explorer.server import server
from tests.explorer.browser import CHROMIUM, COARSE_FIRST, Shown

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
    """Whether the reader wants things to move: a ball that flies where no test looks is a third of the work."""
    return "reduce"


@pytest.fixture(scope="session")
def pages(browser):
    """Give a page, in which nothing may go wrong unseen: loaded, or kept open from test to test."""
    open_ones = {}

    @contextmanager
    def one(kept, viewport, reduced_motion="no-preference", color_scheme="light", coarse=True, **device):
        size, media = viewport, {"reduced_motion": reduced_motion, "color_scheme": color_scheme}
        key = json.dumps([reduced_motion, coarse, device])  # what a flight leaves behind is none of a calm page
        left = open_ones.setdefault(key, [])
        page = left.pop() if kept and left else None
        if page is None:
            context = browser.new_context(viewport=size, **media, **device)
            context.grant_permissions(["clipboard-read", "clipboard-write"])
            if coarse:
                context.add_init_script(COARSE_FIRST)
            page = Shown(context.new_page(), media)
        else:
            page.turn(size, media)
        yield page
        errors = page.errors
        if kept and not errors:
            page.rest()
            left.append(page)
        else:
            page.page.context.close()
        assert errors == []

    yield one
    for page in chain.from_iterable(open_ones.values()):
        page.page.context.close()


@pytest.fixture
def kept():
    """Whether a page stays open for the next test, which goes to its link there: to load one is most of the work."""
    return False


@pytest.fixture
def coarse():
    """Whether the picture of exits stays at its first side: the finer ones are 80 times as many launches."""
    return True


@pytest.fixture
def shown(pages, motion, kept, coarse):
    with pages(kept, viewport={"width": 1280, "height": 800}, reduced_motion=motion, coarse=coarse) as page:
        yield page


@pytest.fixture
def phone(pages, motion, kept):
    size = {"width": 390, "height": 844}
    with pages(kept, viewport=size, reduced_motion=motion, has_touch=True, is_mobile=True) as page:
        yield page
