"""What the explorer says of what it shows, in a real browser: true words and axes, and answers while it computes."""

import re
import time
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

import grazing as gz
from tests.explorer.browser import GO, LOADED


@pytest.fixture
def kept():
    return True


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
    page.page.evaluate(GO, f"#version=2&{fragment}")


def said(page):
    return page.page.inner_text("#summary")


# ---- an answer while it computes


@pytest.mark.parametrize("motion", ["no-preference"])
@pytest.mark.parametrize(
    "fragment",
    [
        "view=ball&omega=0.004&columns=20&alpha=0&r=1&V=0",
        "view=ball&omega=0.004&columns=20&alpha=0&r=1&V=0&ball=0.3:0:0",
        "view=oscillator&flow_transient=20000&columns=4&bins=20&flow_starts=1&alpha=0&r=1&V=0",
        "view=oscillator&omega=0.004&columns=8&bins=20&reduced=no&alpha=0&r=1&V=0",
    ],
)
@LOADED  # orbits that lose nothing: others are soon back at a state, and found at once
def test_the_page_answers_while_it_looks_for_attractors(shown, address, fragment):
    shown.open(f"{address}#version=2&view=edges")
    shown.page.evaluate(WATCH)
    begun = time.perf_counter()
    show(shown, address, fragment)
    assert "Looking for what random starts settle on" in said(shown)
    shown.until("() => / of 16 starts/.test(document.getElementById('summary').textContent)")
    took = 1000 * (time.perf_counter() - begun)
    assert "Looking" not in said(shown)
    if "ball" in fragment:
        shown.page.click("#step")
    assert shown.page.evaluate("() => longest") < took / 3  # a machine that is busy makes both longer
    shown.page.evaluate("() => longest = 0")
    if "ball" in fragment:
        show(shown, address, fragment + "&alpha=2")  # begin again, and leave
    shown.page.click("[data-view=edges]")
    shown.until("() => document.getElementById('summary').textContent.includes('Period 3')")
    assert shown.page.evaluate("() => longest") < took / 3


# ---- axes


def test_an_axis_ends_where_its_parameter_does(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&vary=r&reach=0.2:1&columns=20&bins=20&reduced=no&r=0.5")
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
    shown.open(f"{address}#version=2&{fragment}")
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
    shown.open(f"{address}#version=2&view=ball&columns=20&{given}")
    assert f"{words}" in said(shown) and f"word {word};" in said(shown)
    show(shown, address, f"view=chart&chart=basins&{given}&positions=0:0.5&chart_columns=4&chart_rows=4")
    shown.settle()
    assert f"period 1, word {word}: 100 % of the picture" in said(shown)


@LOADED
def test_the_start_of_the_zero_time_map(shown, address):
    shown.open(f"{address}#version=2&view=strobe")
    assert "has 0 impacts below" in said(shown) or "has 1 impact" in said(shown)
    write = "() => { const c = explorer.views.strobe.zero.context, old = c.fillText; globalThis.written = [];"
    write += " c.fillText = function (text, ...rest) { written.push(text); return old.call(this, text, ...rest); }; }"
    shown.page.evaluate(write)
    for fragment, words in (
        ("", "at constant acceleration the ball turns before the wall."),
        ("&v0=0.1", "the ball does not move towards the wall."),
        ("&u0=-3", "u(0) = −3 lies behind the wall at 0: there is no zero-time map of it."),
    ):
        show(shown, address, f"view=strobe&u0=0.055{fragment}")
        assert words in said(shown) and ("is the identity" in said(shown)) == ("behind" not in words)
        written = shown.page.evaluate("() => written.splice(0).join(' ')")
        assert words in written and "no impact" not in written
        assert shown.problem() == ""


def test_no_table_of_windows_at_a_gap_below_0(shown, address):
    shown.open(f"{address}#version=2&view=edges&l=-0.5")
    assert "The windows of theory are known for l ≥ 0." in said(shown) and "stable for" not in said(shown)
    show(shown, address, "view=edges&l=0.3")
    assert "Period 3: stable for" in said(shown)


def test_a_wall_above_0_leaves_basins_and_ball(shown, address):
    shown.open(f"{address}#version=2&view=chart&chart=basins&sigma=0.1&ball=0.05:0:0&chart_columns=9&chart_rows=8")
    assert shown.problem() == "" and "np.linspace(0.1, 0.5, 9)" in shown.page.evaluate("() => explorer.texts().python")
    assert "(0.05, 0) lies behind the wall at 0.1." in said(shown)
    show(shown, address, "view=chart&chart=basins&sigma=0.6")
    assert "positions run to 0.5, behind the wall at 0.6" in shown.problem()
    show(shown, address, "view=chart&chart=basins&two=yes&sigma_B=0.2&positions=0.3:0.5")
    assert "positions run from 0.3, behind the wall at 0.2; choose some below it" in shown.problem()
    show(shown, address, "view=ball&ball=0.15:0.1:0.2")
    shown.page.fill("input[type=number][name=offset]", "0.11")
    shown.page.click("#controls details summary")
    shown.page.fill("input[type=number][name=sigma]", "0.2")
    shown.until("() => explorer.state().sigma === 0.2 && explorer.state().ball[0] === 0.2")
    assert shown.problem() == "" and "Thrown from (0.2, 0.1)" in said(shown)


def test_words_of_the_ball(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&law=triggered&trigger=0.3")
    assert "a bumper with V = 0.4, passive below the impact speed vs = 0.3" in said(shown)
    shown.page.click("#step")
    shown.until("() => document.getElementById('summary').textContent.includes('the link and the copied')")
    assert "Stopped at (" in said(shown) and "Thrown" not in said(shown)
    box = shown.page.locator("#phase").bounding_box()
    shown.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    shown.until("() => document.getElementById('summary').textContent.includes('Thrown from')")


def test_every_period_of_a_chart_is_named(shown, address):
    fragment = "view=chart&chart=gap&lam=0.8&span=0:0.02&gaps=0.2:0.6&chart_columns=70&chart_rows=60"
    shown.open(f"{address}#version=2&{fragment}")
    periods = shown.page.evaluate(
        "() => [...new Set(explorer.views.chart.codes)].filter(Boolean).sort((a, b) => a - b)"
    )
    assert len(periods) > 12 and f"Periods in the picture: {', '.join(map(str, periods))}" in said(shown)
    assert set(periods) >= {9, 25} and "for 9 and 25" in said(shown)
    texts = "() => { const c = explorer.views.chart.axes.context, old = c.fillText; let all = [];"
    texts += (
        " c.fillText = (text, x, y) => y === 11 && all.push(text); explorer.views.chart.paint(); delete c.fillText;"
    )
    texts += " return all; }"
    legend = shown.page.evaluate(texts)
    more = re.fullmatch(r"and (\d+) more", legend[-1])
    codes = shown.page.evaluate("() => new Set(explorer.views.chart.codes).size")
    assert len(legend) == codes or (more and len(legend) - 1 + int(more.group(1)) == codes)
    shown.page.set_viewport_size({"width": 390, "height": 844})
    shown.until("() => explorer.views.chart.canvas.clientWidth < 390")
    legend = shown.page.evaluate(texts)
    assert len(legend) - 1 + int(re.fullmatch(r"and (\d+) more", legend[-1]).group(1)) == codes


# ---- a phone


@pytest.mark.parametrize(
    "view", ["gap&columns=60", "oscillator&columns=20&bins=40", "strobe&omega=2.1&t0=2.2&offset=0.11&V=0.2"]
)
def test_on_a_phone_pictures_lie_together_on_the_page_and_in_files(phone, address, tmp_path, view):
    phone.open(f"{address}#version=2&view={view}")
    first, second = (
        phone.page.locator(f"{name}:visible").bounding_box() for name in ("figure.first", "figure:not(.first)")
    )
    assert 0 <= second["y"] - first["y"] - first["height"] < 20  # the further picture is the next thing below
    phone.page.evaluate("() => scrollTo(0, document.body.scrollHeight)")  # the first one stays at the top: sticky
    phone.page.select_option("#times", label="as on screen")
    with phone.page.expect_download() as download:
        phone.page.click("[data-save=png]")
    download.value.save_as(tmp_path / "seen.png")
    pixels = np.asarray(Image.open(tmp_path / "seen.png").convert("RGB")).astype(int)
    heights = phone.page.evaluate(
        "() => [...document.querySelectorAll('main canvas')].filter(c => c.offsetParent).map(c => c.clientHeight)"
    )
    assert len(heights) == 2 and pixels.shape[0] == sum(heights) + 26
    filled = (pixels != pixels[0, 0]).any(axis=(1, 2))
    assert np.diff(np.flatnonzero(filled)).max() < 60  # no blank between
    assert filled[: heights[0]].any() and filled[heights[0] + 26 :].any()


def test_the_key_of_one_period_fits_above_the_picture(phone, address):
    phone.open(f"{address}#version=2&view=strobe&order=corrected")
    seen = phone.page.evaluate(
        "() => { const { axes } = explorer.views.strobe, c = axes.context, old = c.fillText, all = [];"
        " c.fillText = (text, x, y) => /exact|map/.test(text) && all.push([x + c.measureText(text).width, y]);"
        " explorer.views.strobe.paint(); delete c.fillText; return [all, axes.canvas.clientWidth, axes.box.y]; }"
    )
    places, width, top = seen
    assert len(places) == 2 and all(x <= width and y < top for x, y in places)


def test_the_names_of_both_diagrams_stand_below_their_axes(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=20&bins=20")
    for diagram, name in (("diagram", "full oscillator"), ("reduced", "reduced map (2.6)")):
        y, low = shown.page.evaluate(
            "([which, name]) => { const d = explorer.views.oscillator[which], c = d.axes.context; let at = NaN;"
            " c.fillText = (text, x, y) => { if (text === name) at = y; }; d.draw(); delete c.fillText;"
            " return [at, d.axes.box.y + d.axes.box.h]; }",
            [diagram, name],
        )
        assert y > low + 18


#: Whatever is written below the axis of a diagram, from where to where.
BELOW = """() => {
  const d = explorer.views.oscillator.diagram, c = d.axes.context, { box } = d.axes, all = [];
  d.stage = "full";
  d.axes.progress = Object.getPrototypeOf(d.axes).progress.bind(d.axes, 0.5, -1e9);
  c.fillText = (text, x, y) => {
    const wide = c.measureText(text).width, left = x - { left: 0, center: wide / 2, right: wide }[c.textAlign];
    if (y > box.y + box.h + 18) all.push([left, left + wide]);
  };
  d.draw();
  delete c.fillText;
  delete d.axes.progress;
  d.stage = "done";
  d.draw();
  return all.sort((a, b) => a[0] - b[0]);
}"""


def test_on_a_phone_the_name_of_a_diagram_and_its_progress_share_no_place(phone, address):
    phone.open(f"{address}#version=2&view=oscillator&columns=20&bins=20")
    for presented in (False, True):
        if presented:
            phone.page.keyboard.press("p")
        texts = phone.page.evaluate(BELOW)
        assert len(texts) >= 2 and all(a[1] < b[0] for a, b in pairwise(texts)), texts
    phone.page.click("#end")


def test_words_stand_above_the_windows_of_the_oscillator(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&reach=0.12:0.1312&reduced=no&columns=20&bins=20")
    found = shown.page.evaluate(
        "() => { const { axes } = explorer.views.oscillator.diagram, c = axes.context, all = []; "
        "c.fillText = (text, x, y) => { if (/^0+1$/.test(text)) all.push([text, axes.atX(x)]); }; "
        "explorer.views.oscillator.diagram.draw(); delete c.fillText; return all; }"
    )
    windows = gz.windows(gz.pinball(), "d", N=range(3, 7))
    assert [word for word, _ in found][:3] == ["001", "0001", "00001"]
    for (_word, at), low, high in zip(found, windows.low.values, windows.high.values, strict=False):
        assert low < at < high


def test_which_box_starts_are_from_is_said_where_their_shares_are(shown, address):
    """Random starts of the ball and the states of a chart are from different boxes, and so their shares differ."""
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.1225")
    shown.until("() => / of 16 starts/.test(document.getElementById('summary').textContent)")
    (u0, u1), (v0, v1) = gz.stroboscopic_map(gz.pinball(d=0.1225)).box
    said = shown.page.evaluate("() => document.getElementById('summary').textContent").replace("−", "-")
    ends = map(float, re.search(r"with (\S+) ≤ u ≤ (\S+) and (\S+) ≤ v ≤ ([-\d.]+);", said).groups())
    assert list(ends) == pytest.approx([u0, u1, v0, v1], rel=1e-2)
    few = "chart_columns=6&chart_rows=6&positions=0:0.4&velocities=-0.7:0.8"
    shown.open(f"{address}#version=2&view=chart&chart=basins&offset=0.1225&{few}")
    assert "with 0 ≤ u ≤ 0.4 and −0.7 ≤ v ≤ 0.8, by" in shown.page.inner_text("#summary")


def test_a_ball_on_its_way_to_an_orbit_is_said_to_be(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&ball=0.3:0:0")
    shown.page.evaluate("() => { explorer.views.ball.play(false); explorer.views.ball.begin(); }")
    lead = "document.getElementById('lead').textContent"
    shown.until(f"() => {lead} === 'It may be on its way to this: it hits once in three pushes: 001.'")
    shown.page.evaluate("() => { explorer.views.ball.speed = 30; explorer.views.ball.play(true); }")
    shown.until(f"() => {lead} === 'It hits once in three pushes: 001.'")
