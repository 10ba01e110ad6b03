"""What the explorer says of what it shows, in a real browser: true words, true axes, and an answer while it computes."""

import pytest

import grazing as gz

#: Notes how long the page does not answer, from its first line on.
WATCH = """let before = performance.now();
globalThis.longest = 0;
setInterval(() => {
  const now = performance.now();
  globalThis.longest = Math.max(globalThis.longest, now - before);
  before = now;
}, 5);"""


def show(page, address, fragment):
    """Go to a state in the page that is open, and wait until it is shown."""
    page.page.evaluate("text => location.hash = text", f"version=1&{fragment}")
    page.until("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")


def said(page):
    return page.page.inner_text("#summary")


# ---- an answer while it computes


@pytest.mark.parametrize(
    "fragment",
    [
        "view=ball&omega=0.001",
        "view=ball&omega=0.001&ball=0.3:0:0",
        "view=oscillator&flow_transient=100000&columns=4&bins=20&flow_starts=1",
    ],
)
def test_the_page_answers_while_it_looks_for_attractors(shown, address, fragment):
    shown.open(f"{address}#version=1&view=edges")
    shown.page.evaluate(WATCH)
    show(shown, address, fragment)
    assert "Looking for what random starts settle on" in said(shown)
    shown.until("() => / of 16 starts/.test(document.getElementById('summary').textContent)")
    assert "Looking" not in said(shown)
    if "ball" in fragment:
        shown.page.click("#step")
    assert shown.page.evaluate("() => longest") < 600
    shown.page.evaluate("() => longest = 0")
    if "ball" in fragment:
        show(shown, address, fragment + "&alpha=2")  # begin again, and leave
    shown.page.click("[data-view=edges]")
    shown.until("() => document.getElementById('summary').textContent.includes('Period 3')")
    assert shown.page.evaluate("() => longest") < 600


# ---- axes


def test_an_axis_ends_where_its_parameter_does(shown, address):
    shown.open(f"{address}#version=1&view=oscillator&vary=r&reach=0.2:1&columns=20&bins=20&reduced=no&r=0.5")
    shown.page.focus("#flow-diagram")
    shown.page.keyboard.press("-")
    shown.until("() => explorer.state().reach[0] < 0.2")
    assert shown.page.evaluate("() => explorer.state().reach") == [0, 1]
    shown.page.keyboard.press("ArrowRight")
    assert shown.problem() == ""


@pytest.mark.parametrize(
    ("fragment", "view"),
    [
        ("view=gap&span=-1:-0.9999999999&mu=-1&columns=20&bins=30", "gap"),
        ("view=oscillator&reach=0.14:0.14001&columns=20&bins=30&reduced=no", "oscillator"),
        ("view=oscillator&reach=0.14:0.14001&columns=20&bins=30&coordinate=v&reduced=no", "oscillator"),
    ],
)
def test_a_narrow_range_holds_its_orbits(shown, address, fragment, view):
    shown.open(f"{address}#version=1&{fragment}")
    told, counts = shown.raster(view)
    assert told["low"] < told["high"]
    assert counts[:, 1:-2].sum() == counts.sum() > 0


# ---- words


@pytest.mark.parametrize(
    ("model", "words"),
    [
        ({"sigma": -0.3, "V": 0.0, "r": 0.3, "d": -0.5}, "impacts that die away in completed chatter, word C;"),
        ({"d": -1.0, "V": 0.0, "r": 0.0}, "at rest on the wall, word S;"),
    ],
)
def test_chatter_and_rest_are_named_as_in_python(shown, address, model, words):
    P = gz.stroboscopic_map(gz.pinball(**model))
    grid = {name: [model[name], model[name] + 1e-9] for name in ("d", "r")}
    word = gz.chart(P, grid, starts=2, transient=100, keep=32)["word"].values.ravel()[0]
    given = "&".join(f"{name}={value}" for name, value in model.items()).replace("d=", "offset=")
    shown.open(f"{address}#version=1&view=ball&{given}")
    assert f"{words}" in said(shown) and f"word {word};" in said(shown)
    show(shown, address, f"view=chart&chart=basins&{given}&positions=0:0.5&chart_columns=4&chart_rows=4")
    shown.settle()
    assert f"period 1, word {word}: 100 % of the picture" in said(shown)
