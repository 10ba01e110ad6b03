"""A page of the explorer in a real browser, and what it shows."""

import os
import shutil
import time

import numpy as np

CHROMIUM = os.environ.get("GRAZING_CHROMIUM") or next(
    filter(
        None,
        map(shutil.which, ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "chrome")),
    ),
    None,
)
SECONDS = 60


class Shown:
    """A page with what it asked for, complained of and shows."""

    def __init__(self, page):
        self.page, self.asked, self.errors = page, [], []
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("pageerror", lambda error: self.errors.append(str(error)))

    def open(self, link):
        self.page.goto(link)
        self.settle()

    def until(self, condition):
        end = time.monotonic() + SECONDS
        while not self.page.evaluate(condition):
            assert time.monotonic() < end, f"not within {SECONDS} s: {condition}; {self.problem()}"
            time.sleep(0.02)

    def settle(self):
        self.until(
            "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => {"
            " const seen = [...document.querySelectorAll('canvas[data-stage]')].filter(c => c.offsetParent);"
            " done(seen.length > 0 && seen.every(c => c.dataset.stage === 'done')); })))"
        )

    def link(self):
        """Return the address once it says what is shown: it follows when the hand has rested."""
        self.until("() => location.hash === explorer.link()")
        return self.page.url

    def problem(self):
        return self.page.inner_text("#problem p") if self.page.is_visible("#problem") else ""

    def raster(self, view):
        found = self.page.evaluate(
            f"() => {{ const d = explorer.views.{view}.diagram; return {{counts: [...d.counts], columns: d.columns, "
            f"bins: d.bins, low: d.spec.low, high: d.spec.high, ambiguous: d.ambiguous}}; }}"
        )
        return found, np.array(found["counts"]).reshape(found["columns"], found["bins"] + 3)

    def pixels(self, canvas):
        return self.page.evaluate(f"() => document.getElementById('{canvas}').toDataURL()")
