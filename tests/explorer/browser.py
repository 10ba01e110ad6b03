"""A page of the explorer in a real browser, and what it shows."""

import os
import time
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

from benchmarks.explorer import chromium

CHROMIUM = chromium()
SECONDS = 60
AXE = Path(os.environ.get("GRAZING_AXE") or Path(__file__).parents[2] / "node_modules/axe-core/axe.min.js")
NEEDS_AXE = pytest.mark.skipif(not AXE.exists(), reason="no axe: sh scripts/page.sh tools brings it, where npm is")
#: What axe finds wrong, and in which elements; to tell of all that is right takes three times as long as to look.
WRONG = """async () => (await axe.run({ resultTypes: ["violations"] })).violations
  .map(({ id, nodes }) => [id, nodes.map(({ html }) => html)])"""
#: For tests of what is loaded, or of more than a link and `Shown.rest` bring back.
LOADED = pytest.mark.parametrize("kept", [False], ids=["loaded"])

#: Goes to a link; done when the page, which was told first, has had a frame.
GO = """(link) => new Promise((done) => {
  const shown = () => requestAnimationFrame(() => requestAnimationFrame(() => done(true)));
  if (location.hash === link) return shown();
  addEventListener("hashchange", shown, {once: true});
  location.hash = link;
})"""

#: Takes back what hands have done beside the link: details, a ball that stands or is fast, sound, focus, what was said.
REST = """async () => {
  if (globalThis.many) Object.assign((await import("./state.js")).DEFAULTS, globalThis.many);
  const { ball } = explorer.views;
  if (ball?.playing) document.getElementById("play").click();
  if (ball?.sound.on) document.getElementById("sound").click();
  if (ball) ball.speed = Number(document.getElementById("speed").value = 1);
  document.getElementById("end").click();
  for (const each of document.querySelectorAll("#controls details")) each.open = false;
  document.getElementById("said").textContent = "";
  document.getElementById("times").value = "1920";
  document.querySelector("#problem button").click();
  document.activeElement.blur();
  scrollTo(0, 0);
}"""
#: The same of the table's page, whose next link makes the rest anew.
TABLE_REST = """() => {
  const at = (id) => document.getElementById(id), pressed = (id) => at(id).getAttribute("aria-pressed") === "true";
  pinball.game().clear();
  for (const id of ["pause", "sound"]) if (pressed(id)) at(id).click();
  const pace = document.querySelector("#controls [name=pace]");
  pace.value = 1;
  pace.dispatchEvent(new Event("input"));
  at("end").click();
  at("copied").textContent = "";
  document.querySelector("#problem button").click();
  document.activeElement.blur();
  scrollTo(0, 0);
  history.replaceState(null, "", "#");
}"""
#: Lets the ball fly, or stand, as the reader wants it now.
CALM = """() => {
  const ball = globalThis.explorer?.views.ball, { matches: calm } = matchMedia("(prefers-reduced-motion: reduce)");
  if (ball && ball.playing === calm) document.getElementById("play").click();
}"""
#: Leaves the picture of exits at its first side.
COARSE = """async () => { (await import("./exits.js")).SIDES.length = 1; }"""
#: The same in a page that is about to load.
COARSE_FIRST = f"if (location.pathname.endsWith('table.html')) ({COARSE})();"
#: Makes small what links leave to the defaults, where the page goes to whole scenes by itself; REST takes it back.
FEW = """async () => {
  const { DEFAULTS } = await import("./state.js");
  const few = { columns: 40, bins: 40, flow_starts: 2, flow_transient: 60, flow_keep: 40 };
  Object.assign(few, { chart_columns: 12, chart_rows: 10 });
  globalThis.many = Object.fromEntries(Object.keys(few).map((name) => [name, DEFAULTS[name]]));
  Object.assign(DEFAULTS, few);
}"""
#: The view that computes and moves least.
STILL = "#version=2&view=edges"


class Shown:
    """A page with what it asked for, complained of and shows."""

    def __init__(self, page, media=None):
        self.page, self.media, self.asked, self.errors, self.kept = page, media, [], [], False
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("pageerror", lambda error: self.errors.append(str(error)))

    @cached_property
    def fingers(self):
        """What touches the page."""
        return self.page.context.new_cdp_session(self.page)

    def open(self, link):
        """Show a link of the explorer, and wait for its pictures."""
        self.go(link)
        self.settle()

    def go(self, link):
        """Go to a link; in a page that is kept open, and is there already, without loading it anew."""
        there, mark, fragment = link.partition("#")
        if self.kept and mark and self.page.url.partition("#")[0] == there:
            self.page.evaluate(GO, mark + fragment)
        else:
            self.page.goto(link)

    def rest(self):
        """Do nothing until the next test, for which it is as new."""
        self.kept = True
        self.asked.clear()
        self.page.mouse.move(0, 0)
        if self.page.evaluate("() => Boolean(globalThis.explorer)"):
            self.page.evaluate(REST)
            self.page.evaluate(GO, STILL)
        elif self.page.evaluate("() => Boolean(globalThis.pinball?.game())"):
            self.page.evaluate(TABLE_REST)

    def turn(self, size, media):
        """Be the page of another reader."""
        if self.page.viewport_size != size:
            self.page.set_viewport_size(size)
        if self.media != media:
            self.media = media
            self.page.emulate_media(**media)
        self.page.evaluate(CALM)

    def until(self, condition):
        end, pause = time.monotonic() + SECONDS, 0.02
        while not self.page.evaluate(condition):
            assert time.monotonic() < end, f"not within {SECONDS} s: {condition}; {self.problem()}"
            time.sleep(pause)
            pause = min(1.25 * pause, 0.1)  # to look is work as well

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

    def violations(self):
        """Return what axe finds wrong in the page as it is."""
        if not self.page.evaluate("() => Boolean(globalThis.axe)"):
            self.page.evaluate(AXE.read_text(encoding="utf-8"))
        return self.page.evaluate(WRONG)

    def raster(self, view):
        found = self.page.evaluate(
            f"() => {{ const d = explorer.views.{view}.diagram; return {{counts: [...d.counts], columns: d.columns, "
            f"bins: d.bins, low: d.spec.low, high: d.spec.high, ambiguous: d.ambiguous}}; }}"
        )
        return found, np.array(found["counts"]).reshape(found["columns"], found["bins"] + 3)

    def pixels(self, canvas):
        return self.page.evaluate(f"() => document.getElementById('{canvas}').toDataURL()")
