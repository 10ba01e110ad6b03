"""The page of the explorer in a real browser: from a key on a slider, or its thumb being dragged, to the new picture.

Times are from the time stamp that the browser gave the event to a task after the frame in which the picture was drawn,
so the frame's own work on the page is in them; what the compositor and the screen take after that is not.
"""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import median
from time import sleep
from typing import Any

from rich.console import Console

from .program import Missing
from .table import show

#: A window in which the gap map's diagram is about 800 pixels wide.
WINDOW: Any = {"width": 1564, "height": 900}
#: Pictures of a row, seconds of an animation, and how many frames late a frame may be and still count as in time.
PICTURES, SECONDS, LATE = 40, 4.0, 1.5
#: Milliseconds between two places of a thumb that is dragged.
BETWEEN = 16

#: Puts the pictures of one diagram down, each with the last event that it shows, and what they hold.
WATCH = """
([view, parameter]) => {
  const {diagram, machine} = explorer.views[view];
  const field = document.querySelector(`input[name=${parameter}]`);
  const slider = field.closest(".control").querySelector("input[type=range]");
  const which = machine.fields.indexOf(parameter);
  const seen = globalThis.seen = {asked: [], pictures: []};
  const after = (then) => requestAnimationFrame(() => {
    const {port1, port2} = new MessageChannel();
    port1.onmessage = then;
    port2.postMessage(0);
  });
  // before the page's own listener, which may draw at once
  addEventListener("input", ({target, timeStamp: at}) => {
    if (target === slider) seen.asked.push({value: Number(slider.value), at});
  }, true);
  // what the raster holds was counted; what was passed over before is known from that
  const iterates = ({counts, drawn: {quick}}) =>
    (counts.reduce((sum, count) => sum + count, 0) / quick.stride) * (1 + quick.transient / quick.keep);
  let picture;
  new MutationObserver(() => {
    const {stage} = diagram.axes.canvas.dataset;
    const shown = diagram.drawn.row[which];
    if (stage === "coarse" || (stage === "computing" && picture?.shown !== shown)) {
      const asked = seen.asked.findLast(({value}) => Math.abs(value - shown) < 1e-9);
      if (!asked || picture?.asked === asked) return;
      const mine = picture = {asked, shown, iterates: iterates(diagram)};
      after(() => { mine.first = performance.now() - asked.at; seen.pictures.push(mine); });
    } else if (stage === "done" && picture) {
      const mine = picture;
      after(() => { mine.full = performance.now() - mine.asked.at; });
    }
  }).observe(diagram.axes.canvas, {attributes: true, attributeFilter: ["data-stage"]});
  slider.focus();
}
"""
#: Counts frames of the ball for a while, and the milliseconds of work in each.
FRAMES = """
(seconds) => new Promise((done) => {
  const work = [], times = [];
  const begun = performance.now();
  const tick = (at) => {
    times.push(at);
    // all callbacks of a frame run before the message: the ball's own is in the time
    const {port1, port2} = new MessageChannel();
    port1.onmessage = () => work.push(performance.now() - at);
    port2.postMessage(0);
    if (performance.now() - begun < 1000 * seconds) requestAnimationFrame(tick);
    else done({times, work});
  };
  requestAnimationFrame(tick);
})
"""


@dataclass(frozen=True)
class Response:
    """How a page answers: milliseconds of each picture, or why there are none."""

    name: str
    first: Sequence[float] = ()
    full: Sequence[float] = ()
    note: str = ""
    missing: str = ""


def chromium() -> str | None:
    """Return the browser that is found here, or named in GRAZING_CHROMIUM; None for none."""
    names = ("chromium", "chromium-browser", "google-chrome", "chrome")
    return os.environ.get("GRAZING_CHROMIUM") or next(filter(None, map(shutil.which, names)), None)


@contextmanager
def page() -> Iterator[tuple[Any, str]]:
    """Give a page of a browser, and the address of the explorer."""
    from grazing.explorer.server import server

    try:
        from playwright.sync_api import sync_playwright
    except ModuleNotFoundError:
        raise Missing("no playwright: pip install 'grazing[test]'") from None
    found = chromium()
    if found is None:
        raise Missing("no Chromium found: install one, or name it in GRAZING_CHROMIUM")
    with server() as ours, sync_playwright() as playwright:
        threading.Thread(target=ours.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        try:
            yield browser.new_page(viewport=WINDOW), ours.address
        finally:
            browser.close()
            ours.shutdown()


def opened(shown: Any, address: str, fragment: str, view: str) -> None:
    """Open a view and wait until all of it is there."""
    shown.goto(f"{address}#version=1&view={fragment}")
    shown.reload()
    finished(shown, view)


def finished(shown: Any, view: str) -> None:
    """Wait for the last stage of a diagram."""
    shown.wait_for_function(f"() => globalThis.explorer?.views.{view}.diagram.stage === 'done'")


def keys(shown: Any, view: str, parameter: str, count: int) -> list[dict[str, Any]]:
    """Press a key on a slider, each time when the picture is complete."""
    shown.evaluate(WATCH, [view, parameter])
    for i in range(count):
        shown.keyboard.press("ArrowRight")
        shown.wait_for_function(f"() => seen.pictures.length > {i} && seen.pictures[{i}].full")
    return list(shown.evaluate("seen.pictures"))


def dragged(shown: Any, view: str, parameter: str, count: int) -> list[dict[str, Any]]:
    """Drag the thumb of a slider, to a new place in every frame."""
    shown.evaluate(WATCH, [view, parameter])
    slider = shown.locator(f"input[name={parameter}]").locator("xpath=..").locator("input[type=range]")
    box = slider.bounding_box()
    x, y, width = box["x"] + 12.0, box["y"] + box["height"] / 2.0, box["width"] - 24.0
    shown.mouse.move(x, y)
    shown.mouse.down()
    for i in range(count):
        shown.mouse.move(x + width * (i + 1) / count, y)
        sleep(BETWEEN / 1000.0)
    shown.mouse.up()
    finished(shown, view)
    return list(shown.evaluate("seen.pictures"))


def diagrams(count: int) -> list[tuple[str, str, str, str, Callable[..., list[dict[str, Any]]], int]]:
    """Return the rows of diagrams: name, view, fragment, parameter, how it is moved, how often."""
    gap, oscillator = "gap map, 800 x 600", "oscillator, 1000 x 600"
    thousand = "oscillator&columns=1000&reduced=no"
    return [
        (f"{gap}, key on a slider", "gap", "gap", "l", keys, count),
        (f"{gap}, thumb dragged", "gap", "gap", "l", dragged, 2 * count),
        (f"{oscillator}, key on a slider", "oscillator", thousand, "V", keys, max(3, count // 4)),
    ]  # fmt: skip


def respond(share: float, tell: Callable[[str], None]) -> list[Response]:
    """Measure all rows."""
    count, found = max(5, round(PICTURES * share)), []
    try:
        with page() as (shown, address):
            for name, view, fragment, parameter, move, often in diagrams(count):
                tell(f"explorer: {name}")
                opened(shown, address, fragment, view)
                move(shown, view, parameter, 4)  # the first ones are compiled in haste
                opened(shown, address, fragment, view)
                pictures = [each for each in move(shown, view, parameter, often) if "first" in each]
                note = f"{len(pictures)} pictures of {median(each['iterates'] for each in pictures):,.0f} iterates"
                full = [each["full"] for each in pictures if "full" in each] if move is keys else []
                found.append(Response(name, [each["first"] for each in pictures], full, note))
            tell("explorer: ball in motion")
            found.append(animated(shown, address, SECONDS * share))
    except Missing as reason:
        return [Response("explorer", missing=str(reason))]
    return found


def animated(shown: Any, address: str, seconds: float) -> Response:
    """Watch the ball."""
    shown.goto(f"{address}#version=1&view=ball")
    shown.reload()
    shown.wait_for_function("() => globalThis.explorer?.views.ball.now > 1")
    seen = shown.evaluate(FRAMES, seconds)
    steps = [b - a for a, b in zip(seen["times"], seen["times"][1:], strict=False)]
    late = sum(step > LATE * 1000.0 / 60.0 for step in steps)
    note = f"{len(steps) / (sum(steps) / 1000.0):.1f} frames a second, {late} of {len(steps)} late; work in a frame"
    return Response("ball in motion", seen["work"], (), note)


def show_responses(out: Console, found: Sequence[Response]) -> None:
    """Print the table."""
    lines = []
    for one in found:
        if one.missing:
            lines.append((f"{one.name} ({one.missing})", "", "", "", ""))
            continue
        spread = f"{min(one.first):.0f}..{max(one.first):.0f}"
        full = f"{median(one.full):.0f}" if one.full else ""
        lines.append((one.name, f"{median(one.first):.1f}", spread, full, one.note))
    show(
        out,
        "Explorer: milliseconds from an event to the picture",
        ("page", "first picture", "min..max", "complete", ""),
        lines,
    )
