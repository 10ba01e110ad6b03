"""The page of the explorer in a real browser: what it must reach, each line measured.

Times of pictures are from the time stamp that the browser gave the event to a task after the frame in which the picture
was drawn, so the frame's own work on the page is in them; what the compositor and the screen take after that is not.
"""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import linear_regression, median
from time import monotonic, sleep
from typing import Any

from rich.console import Console

from .program import Missing, foreign
from .table import show

#: A window in which the gap map's diagram is about 800 pixels wide.
WINDOW: Any = {"width": 1564, "height": 900}
#: Pictures of a row, charts, how often the page is opened, seconds of play whose frames are counted, minutes of a heap.
PICTURES, CHARTS, OPENED, SECONDS, MINUTES = 40, 3, 10, 8.0, 10.0
#: Columns of the oscillator's diagram, cells of charts; the side of the picture of exits that is waited for.
COLUMNS, CELLS, SIDE = 1000, (300, 200), 320
#: Milliseconds between two places of a thumb that is dragged; looks at a heap, of which the first fifth warms up.
BETWEEN, LOOKS = 16, 20
#: Milliseconds after which a picture is no longer waited for.
PATIENCE = 600_000
#: Bytes by which a steady heap may seem to grow: three times what comes of sizes that scatter by 0.2 MB.
STEADY = 500_000.0

#: Runs a function after the frame that is being made; in every page that is opened.
AFTER = """
globalThis.afterFrame = (then) => requestAnimationFrame(() => {
  const {port1, port2} = new MessageChannel();
  port1.onmessage = () => then(performance.now());
  port2.postMessage(0);
});
"""
#: Puts down when the ball is first seen.
FIRST = """
new MutationObserver((_, own) => {
  if (document.getElementById("strip")?.dataset.stage !== "done") return;
  own.disconnect();
  afterFrame((now) => { globalThis.firstSeen = now; });
}).observe(document, {subtree: true, childList: true, attributes: true, attributeFilter: ["data-stage"]});
"""
#: Puts the pictures of a view down: `first` and `full` are milliseconds from the event that asked for each.
WATCH = """
([view, parameter]) => {
  const shown = explorer.views[view], {diagram} = shown;
  const field = document.querySelector(`input[name="${parameter}"]`), hidden = field.closest("details");
  const pictures = globalThis.pictures = [], asked = new Map();
  let at = performance.now(), last = diagram?.drawn, key = shown.key, mine;
  // before the page's own listeners, which may draw at once
  for (const event of ["keydown", "input"]) addEventListener(event, ({timeStamp}) => { at = timeStamp; }, true);
  const take = (which) => { const one = mine; afterFrame((now) => { one[which] ??= now - one.at; }); };
  if (diagram) {
    const {show, paint} = diagram;
    diagram.show = (spec) => { asked.set(spec, at); show.call(diagram, spec); };
    diagram.paint = () => {
      paint.call(diagram);
      const {drawn} = diagram;
      if (drawn !== last && asked.has(drawn)) {
        const {stride, starts, transient, keep} = drawn.quick;
        const iterates = Math.ceil(diagram.columns / stride) * starts * (transient + keep);
        pictures.push(mine = {at: asked.get(last = drawn), iterates});
        take("first");
      }
      if (mine && diagram.stage === "done") take("full");
    };
  } else {
    const {show, done} = shown;
    shown.show = (state) => {
      show.call(shown, state);
      if (shown.key !== key) pictures.push(mine = {at});
      key = shown.key;
    };
    shown.done = () => { // after each grid of cells
      done();
      if (mine) take("first");
      if (mine && shown.canvas.dataset.stage === "done") take("full");
    };
  }
  if (hidden) hidden.open = true;
  field.closest(".control").querySelector("input[type=range]").focus();
}
"""
#: Counts frames for a while, and the milliseconds of work in each.
FRAMES = """
(seconds) => new Promise((done) => {
  const work = [], times = [], begun = performance.now();
  const tick = (at) => {
    times.push(at);
    // all callbacks of a frame run before the message: the page's own are in the time
    const {port1, port2} = new MessageChannel();
    port1.onmessage = () => work.push(performance.now() - at);
    port2.postMessage(0);
    if (performance.now() - begun < 1000 * seconds) requestAnimationFrame(tick);
    else done({times, work});
  };
  requestAnimationFrame(tick);
})
"""
#: Plays on, with a hundred near balls in flight.
PLAY = """
() => setInterval(() => {
  if (pinball.game().alive && pinball.game().flying.length >= 100) return;
  pinball.plunge(0.8);
  pinball.split();
}, 20)
"""


@dataclass(frozen=True)
class Response:
    """What was measured of the page, or why it was not; ``goal`` is the most that it may be, or the least."""

    name: str
    values: Sequence[float] = ()
    unit: str = "ms"
    goal: float | None = None
    least: bool = False
    note: str = ""
    missing: str = ""

    @property
    def reached(self) -> bool | None:
        """Whether the median reaches the goal, None where there is nothing to compare."""
        if self.goal is None or not self.values:
            return None
        return median(self.values) >= self.goal if self.least else median(self.values) <= self.goal


def chromium() -> str | None:
    """Return the browser that is found here, or named in GRAZING_CHROMIUM; None for none."""
    names = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "chrome")
    return os.environ.get("GRAZING_CHROMIUM") or next(filter(None, map(shutil.which, names)), None)


@dataclass(frozen=True)
class Explorer:
    """The explorer as it is served, and the browser in which it is opened."""

    browser: Any
    address: str

    @contextmanager
    def page(self, path: str = "", slower: float = 1.0) -> Iterator[Any]:
        """Give a new page of its own process, whose processor is so many times slower."""
        context = self.browser.new_context(viewport=WINDOW)
        try:
            shown = context.new_page()
            shown.set_default_timeout(PATIENCE)
            shown.add_init_script(AFTER + FIRST)
            context.new_cdp_session(shown).send("Emulation.setCPUThrottlingRate", {"rate": slower})
            shown.goto(self.address.removesuffix("index.html") + path)
            yield shown
        finally:
            context.close()


@contextmanager
def explorer() -> Iterator[Explorer]:
    """Serve the explorer, and start the browser."""
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
            yield Explorer(browser, ours.address)
        finally:
            browser.close()
            ours.shutdown()


def finished(shown: Any, view: str) -> None:
    """Wait for the last stage of a picture."""
    shown.wait_for_function(
        f"() => {{ const one = globalThis.explorer?.views.{view}; "
        "return one && (one.diagram?.stage ?? one.canvas.dataset.stage) === 'done'; }"
    )


Move = Callable[[Any, str, str, int], None]


def keys(shown: Any, view: str, parameter: str, count: int) -> None:
    """Press a key on a slider, each time when the picture is complete."""
    for i in range(count):
        shown.keyboard.press("ArrowRight")
        shown.wait_for_function(f"() => pictures[{i}]?.full")


def dragged(shown: Any, view: str, parameter: str, count: int) -> None:
    """Drag the thumb of a slider, to a new place in every frame."""
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


def pictures(ours: Explorer, fragment: str, parameter: str, move: Move, count: int) -> list[dict[str, float]]:
    """Return the pictures that a hand gets on a slider; the first ones are compiled in haste, and left out."""
    view = fragment.partition("&")[0]
    with ours.page(f"#version=2&view={fragment}") as shown:
        for often in (min(4, max(1, count // 2)), count):
            shown.reload()
            finished(shown, view)
            shown.evaluate(WATCH, [view, parameter])
            move(shown, view, parameter, often)
        return [each for each in shown.evaluate("pictures") if "first" in each]


def sliders(ours: Explorer, share: float) -> Iterator[Response]:
    """Measure from an event on a slider to the picture."""
    count, few = max(2, round(PICTURES * share)), max(1, round(CHARTS * share))
    across, up = CELLS
    gap, flow, chart = "gap map, 800 x 600", f"oscillator, {COLUMNS} x 600", f"chart of the {{}}, {across} x {up}"
    thousand, size = f"oscillator&columns={COLUMNS}&reduced=no", f"chart_columns={across}&chart_rows={up}"
    for name, fragment, parameter, move, often, goals in (
        (f"{gap}, key on a slider", "gap", "l", keys, count, (20.0, None)),
        (f"{gap}, thumb dragged", "gap", "l", dragged, 2 * count, (20.0, None)),
        (f"{flow}, key on a slider", thousand, "V", keys, max(2, count // 4), (40.0, 800.0)),
        (chart.format("gap map"), f"chart&chart=gap&{size}", "lam", keys, few, (300.0, 30e3)),
        (chart.format("oscillator"), f"chart&chart=oscillator&{size}", "r", keys, few, (300.0, 30e3)),
    ):  # fmt: skip
        seen = pictures(ours, fragment, parameter, move, often)
        note = f"{len(seen)} pictures"
        if "iterates" in seen[0]:
            note += f" of {median(each['iterates'] for each in seen):,.0f} iterates"
        yield Response(f"{name}: first", [each["first"] for each in seen], goal=goals[0], note=note)
        if move is keys:
            yield Response(f"{name}: complete", [each["full"] for each in seen], goal=goals[1])


def frames(ours: Explorer, share: float) -> Iterator[Response]:
    """Count frames a second of the ball, and of a game with a hundred near balls."""
    ball, table = "#version=2&view=ball", "table.html#v=1&table=classic"
    for name, path, slower, goal in (
        ("ball in motion", ball, 1.0, 60.0),
        ("table, 100 near balls", table, 1.0, 60.0),
        ("table, 100 near balls, processor 4 x slower", table, 4.0, 30.0),
    ):
        with ours.page(path, slower) as shown:
            play(shown, path)
            shown.evaluate(FRAMES, 1.0)  # compiled in haste
            seen = shown.evaluate(FRAMES, max(2.0, SECONDS * share))
        begun, times = seen["times"][0], seen["times"]
        whole = max(1, int((times[-1] - begun) / 1000.0))
        counts = [sum(1000.0 * i <= at - begun < 1000.0 * (i + 1) for at in times) for i in range(whole)]
        yield Response(
            name,
            [float(n) for n in counts],
            "frames a second",
            goal,
            least=True,
            note=f"work in a frame {median(seen['work']):.1f} ms, at most {max(seen['work']):.0f} ms",
        )


def play(shown: Any, path: str) -> None:
    """Wait until the page is there, and let it play."""
    if path.startswith("table"):
        shown.wait_for_function(f"() => globalThis.pinball?.exits()?.side >= {SIDE}")
        shown.evaluate(PLAY)
    else:
        shown.wait_for_function("() => globalThis.explorer?.views.ball.now > 1")


def heaps(ours: Explorer, share: float) -> Iterator[Response]:
    """Look at the heaps of two pages that play at the same time, each in a process of its own."""
    ball, table = "#version=2&view=ball&offset=0.1225&twin=yes", "table.html#v=1&table=classic"
    minutes, sizes = MINUTES * share, {ball: list[tuple[float, float]](), table: list[tuple[float, float]]()}
    with ours.page(ball) as one, ours.page(table) as other:
        shown = {ball: one, table: other}
        for path, page in shown.items():
            play(page, path)
        sessions = {path: page.context.new_cdp_session(page) for path, page in shown.items()}
        begun = monotonic()
        for _ in range(LOOKS):
            one.wait_for_timeout(60e3 * minutes / LOOKS)
            for path, session in sessions.items():
                session.send("HeapProfiler.collectGarbage")
                used = session.send("Runtime.getHeapUsage")["usedSize"]
                sizes[path].append(((monotonic() - begun) / 60.0, used))
    for name, path in (("heap of the ball with its twin", ball), ("heap of the table, 100 near balls", table)):
        at, used = zip(*sizes[path][LOOKS // 5 :], strict=True)
        slope = linear_regression(at, used).slope
        note = f"{used[0] / 1e6:.2f} MB to {used[-1] / 1e6:.2f} MB in {at[-1]:.1f} minutes"
        yield Response(name, [slope / 1000.0], "kB a minute", STEADY / 1000.0 / minutes, note=note)


def opened(ours: Explorer, share: float) -> Iterator[Response]:
    """Open the page, with nothing of it kept, until the ball is seen."""
    for name, slower, goal in (
        ("page opened, ball seen", 1.0, 1000.0),
        ("page opened, ball seen, processor 6 x slower", 6.0, 3000.0),
    ):
        times = []
        for _ in range(max(2, round(OPENED * share))):
            with ours.page(slower=slower) as shown:
                shown.wait_for_function("() => globalThis.firstSeen")
                times.append(shown.evaluate("firstSeen"))
        yield Response(name, times, goal=goal)


def weight(ours: Explorer, share: float) -> Iterator[Response]:
    """Weigh all that the page may ask for."""
    from grazing.explorer.server import files

    sizes = [path.stat().st_size for name, path in files().items() if not name.endswith("/")]
    yield Response("page, all in", [sum(sizes) / 1000.0], "kB", 900.0, note=f"{len(sizes)} files")


PARTS: dict[str, Callable[[Explorer, float], Iterator[Response]]] = {
    "sliders": sliders,
    "frames": frames,
    "opened": opened,
    "weight": weight,
    "heaps": heaps,
}


def respond(share: float, tell: Callable[[str], None]) -> list[Response]:
    """Measure all rows; one that fails says so, and the others go on."""
    found: list[Response] = []
    before = os.getloadavg()[0]
    try:
        with explorer() as ours:
            for name, part in PARTS.items():
                tell(f"explorer: {name}")
                try:
                    with foreign():
                        for response in part(ours, share):
                            found.append(response)
                            tell(f"explorer: after {response.name}")
                except Missing as reason:
                    found.append(Response(f"explorer, {name}", missing=str(reason)))
    except Missing as reason:
        return [Response("explorer", missing=str(reason))]
    load = [before, os.getloadavg()[0]]
    return [*found, Response("load of the machine, before and after", load, "", note=f"{os.cpu_count()} cores")]


def show_responses(out: Console, found: Sequence[Response]) -> None:
    """Print the table."""
    lines = []
    for one in found:
        if one.missing:
            lines.append((f"{one.name} ({one.missing})", "", "", "", "", "", ""))
            continue
        spread = f"{min(one.values):.4g}..{max(one.values):.4g}" if len(one.values) > 1 else ""
        goal = "" if one.goal is None else f"{'≥' if one.least else '≤'} {one.goal:.4g}"
        reached = {None: "", True: "yes", False: "no"}[one.reached]
        lines.append((one.name, f"{median(one.values):.4g}", one.unit, spread, goal, reached, one.note))
    show(
        out,
        "Explorer: what the page reaches",
        ("page", "median", "unit", "min..max", "goal", "reached", ""),
        lines,
    )
