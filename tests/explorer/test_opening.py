"""What the page opens on: a ball above its bumper, whose word, sound and history follow a parameter that is turned."""

import math

import numpy as np
import pytest

import grazing as gz
from tests.explorer.browser import Shown


@pytest.fixture
def kept():
    return True


@pytest.fixture
def motion():
    return "no-preference"


BALL = "explorer.views.ball"


def ball(shown, what):
    return shown.page.evaluate(f"() => {BALL}.{what}")


def letters(shown):
    """The word as it is typed out, without the turn that is under way."""
    found = dict(shown.page.evaluate(f"() => [...{BALL}.past.letters]"))
    return "".join(str(found[n]) for n in sorted(found)[1:-1])


def faster(shown):
    shown.page.evaluate(f"() => {{ {BALL}.speed = 60; }}")


def turn(shown, value):
    """Turn the constant force in the steps of a hand."""
    shown.page.evaluate(
        """async (value) => {
          const box = document.querySelector("input[name=offset]").closest(".control");
          const slider = box.querySelector("input[type=range]");
          const from = Number(slider.value);
          for (let i = 1; i <= 8; i++) {
            slider.value = String(from + (i / 8) * (value - from));
            slider.dispatchEvent(new Event("input", { bubbles: true }));
            await new Promise(requestAnimationFrame);
          }
        }""",
        value,
    )
    shown.until(f"() => Math.abs(explorer.state().offset - {value}) < 1e-4")


def test_the_page_opens_on_the_ball(shown, address):
    shown.page.goto(address)
    shown.until("() => document.querySelector('.lead').innerText.includes('It hits once in three pushes: 001.')")
    assert shown.page.evaluate("() => explorer.state().view") == "ball"
    assert letters(shown)[:6] in {"001001", "010010", "100100"}  # there is something to see at once


@pytest.mark.parametrize("motion", ["reduce"])
@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("offset=0.14", "It swings and never hits."),
        (
            "offset=0.1225",
            "The start decides: it hits once in four pushes: 0001; or it hits once in three pushes: 001.",
        ),
        ("sigma=-0.3&V=0&r=0.3&offset=-0.5", "Its hits come ever faster, without end"),
        ("offset=-1&V=0&r=0", "It lies on the bumper."),
        ("alpha=0.05&V=0.9", "It hits on and on and no tune repeats."),
    ],
)
def test_what_it_does_is_said_in_words_of_a_visitor(shown, address, given, words):
    shown.open(f"{address}#version=2&view=ball&columns=20&{given}")
    assert words in shown.page.inner_text(".lead")
    if "V=0&" in f"{given}&":
        assert "above a wall" in shown.page.inner_text("#headline")
        # nothing says that this wall, or every wall of its law, kicks
        assert "adds the kick V" in shown.page.inner_text(".choice option:checked")


def test_chatter_is_one_letter_and_without_end(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&sigma=-0.3&V=0&r=0.3&offset=-0.5")
    faster(shown)
    shown.until(f"() => {BALL}.now > 20 * {BALL}.T")
    assert set(letters(shown)) == {"C"}


def test_the_ball_passes_the_section_where_the_map_says(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&ball=0.2:0.1:0&alpha=1")
    faster(shown)
    shown.until(f"() => {BALL}.visited.length >= 12")
    seen = ball(shown, "visited.slice(0, 12).map(([, u]) => u)")
    P = gz.stroboscopic_map(gz.pinball(alpha=1.0, d=0.12, V=0.4))
    state, want = np.array([0.2, 0.1]), []
    for _ in range(12):
        state = np.asarray(P(state)[0])
        want.append(state[0])
    np.testing.assert_allclose(seen, want, atol=1e-9)


def test_the_ball_lives_through_the_slider_and_its_word_changes(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    faster(shown)
    shown.until(f"() => {BALL}.now > 9 * {BALL}.T")
    turn(shown, 0.126)
    assert ball(shown, "lived")
    gaps = np.diff(np.array(ball(shown, "past.line.map(p => [p.turn, p.u])")), axis=0)
    assert gaps[:, 0].min() >= -1e-9 and np.abs(gaps[:, 1]).max() < 0.02  # one curve, that no slider broke
    shown.until(f"() => {BALL}.now > 60 * {BALL}.T")
    assert "000100010001" in letters(shown)
    assert "once in four pushes: 0001" in shown.page.inner_text("#lead")


def test_the_time_that_is_told_goes_on_as_the_slider_moves(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    faster(shown)
    shown.until(f"() => {BALL}.now > 3 * {BALL}.T")
    told = (
        f"() => {{ const b = {BALL}, c = b.strip.axes.context, fill = c.fillText, said = []; "
        "c.fillText = (text) => said.push(text); b.draw(); c.fillText = fill; "
        "return Number(/^t = ([\\d.]+)/.exec(said.find((text) => text.startsWith('t ')))[1]); }"
    )
    shown.page.evaluate(f"() => {BALL}.play(false)")
    before = shown.page.evaluate(told)
    turn(shown, 0.121)
    assert ball(shown, "lived") and shown.page.evaluate(told) >= before


def test_a_high_flight_is_seen_until_it_has_left(shown, address):
    """A ball that was kicked before the graze was passed may have flown higher than any that flies beyond it."""
    shown.open(f"{address}#version=2&view=ball&columns=20")
    shown.page.evaluate(f"() => {BALL}.play(false)")
    tops = [
        shown.page.evaluate(
            f"(ago) => {{ const b = {BALL}; b.past.line = [{{ turn: b.turn - ago, u: 2 }}]; b.draw(); "
            "return b.strip.axes.y1; }",
            ago,
        )
        for ago in (3, 12)
    ]
    assert 2 <= tops[0] < 2.1 and tops[1] < 0.6


def test_another_wall_begins_another_word(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    assert len(ball(shown, "past.line")) > 100
    shown.page.click("text=a second wall, above the ball")
    shown.until(f"() => explorer.state().two && {BALL}.past.line.length < 100")


def test_what_is_found_later_is_in_the_portrait(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    top = shown.page.evaluate(
        f"() => {{ const b = {BALL}; b.play(false); b.lived = true; b.axes.span(0, 0.1, 0, 0.1); "
        "b.search.told.found(); return [b.axes.x1, Math.max(...b.attractor.u)]; }"
    )
    assert top[0] > top[1]


def test_the_strip_names_what_is_hit(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    write = (
        f"() => {{ const b = {BALL}, pen = b.strip.axes.context, fill = pen.fillText, said = []; "
        "pen.fillText = (text) => said.push(text); b.draw(); pen.fillText = fill; return said; }"
    )
    assert {"bumper", "word"} <= set(shown.page.evaluate(write))
    shown.page.evaluate("location.hash = 'version=2&view=ball&columns=20&V=0'")
    shown.until("() => explorer.state().V === 0")
    said = shown.page.evaluate(write)
    assert "wall" in said and "bumper" not in said


def test_the_arrow_of_the_force_is_clear_of_what_is_written(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    shown.page.evaluate(
        f"() => {{ const b = {BALL}, c = b.strip.axes.context, line = c.lineTo, fill = c.fillText; "
        "window.ends = [0, 0]; "
        "c.lineTo = (x, y) => { const far = c.lineWidth === 3 && x > b.strip.axes.x(b.turn) + 1; "
        "if (far) window.ends[0] = Math.max(window.ends[0], x + 1.5); line.call(c, x, y); }; "
        "c.fillText = (text, x, y) => { "
        "if (text === 'bumper') window.ends[1] = x - c.measureText(text).width; fill.call(c, text, x, y); }; }"
    )
    shown.until("() => window.ends[0] && window.ends[1]")
    arrow, label = shown.page.evaluate("() => window.ends")
    assert arrow < label


def test_hysteresis(shown, address):
    """At d = 0.1225 two orbits live: from below the ball stays on the one, from above on the other."""
    found = {}
    for begin in (0.12, 0.126):
        shown.open(f"{address}#version=2&view=ball&columns=20&offset={begin}")
        faster(shown)
        turn(shown, 0.1225)
        shown.until(f"() => {BALL}.lived && {BALL}.now > 60 * {BALL}.T")
        found[begin] = letters(shown)
        assert len({value for value, _u in ball(shown, "visited")}) >= 2  # painted over the parameter
        shown.page.goto("about:blank")
    assert "001001001" in found[0.12] and "000100010001" in found[0.126]


def test_a_preset_and_a_link_begin_anew(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    turn(shown, 0.13)
    assert ball(shown, "lived")
    shown.page.select_option("#preset", "1.5")
    shown.until(f"() => explorer.state().offset === 0.12 && !{BALL}.lived")


@pytest.mark.parametrize("motion", ["reduce"])
def test_the_slider_spans_the_diagram_in_its_colours(shown, address):
    shown.open(f"{address}#version=2&view=ball&reach=0.118:0.128&columns=200")
    slider = "document.querySelector('input[name=offset]').closest('.control').querySelector('input[type=range]')"
    low, high, step = shown.page.evaluate(f"() => ['min', 'max', 'step'].map(k => Number({slider}[k]))")
    assert (low, high) == (0.118, 0.128) and step <= 1e-4
    colours = shown.page.evaluate(
        f"""async () => {{
          const image = new Image();
          image.src = {slider}.style.backgroundImage.slice(5, -2);
          await image.decode();
          const canvas = Object.assign(document.createElement("canvas"), {{ width: image.width, height: 2 }});
          const c = canvas.getContext("2d");
          c.drawImage(image, 0, 0);
          const at = (x, y) => [...c.getImageData(x * image.width, y, 1, 1).data].slice(0, 3).join();
          return [0.1, 0.45, 0.8].map((x) => [0, 1].map((y) => at(x, y)));
        }}"""
    )
    blue, sky = "0,100,164", "92,188,235"  # of periods 3 and 4; between them both are stable
    assert colours == [[blue, blue], [blue, sky], [sky, sky]]


@pytest.mark.parametrize(("view", "canvas", "name"), [("ball", "ball-diagram", "offset"), ("gap", "gap-diagram", "mu")])
def test_the_line_of_the_parameter_is_dragged(shown, address, view, canvas, name):
    shown.open(f"{address}#version=2&view={view}&columns=100")
    shown.page.locator(f"#{canvas}").scroll_into_view_if_needed()
    diagram = f"explorer.views.{view}.diagram"
    x = shown.page.evaluate(f"() => {diagram}.axes.x(explorer.state().{name})")
    box = shown.page.locator(f"#{canvas}").bounding_box()
    before = shown.page.evaluate(f"() => [explorer.state().{name}, {diagram}.axes.x0, {diagram}.axes.x1]")
    shown.page.mouse.move(box["x"] + x, box["y"] + 60)
    shown.page.mouse.down()
    shown.page.mouse.move(box["x"] + x - 40, box["y"] + 120, steps=4)
    moving = shown.page.evaluate(f"() => explorer.state().{name}")
    shown.page.mouse.up()
    after = shown.page.evaluate(f"() => [explorer.state().{name}, {diagram}.axes.x0, {diagram}.axes.x1]")
    want = before[0] - 40 * (before[2] - before[1]) / shown.page.evaluate(f"() => {diagram}.axes.box.w")
    assert moving < before[0] and math.isclose(after[0], want, abs_tol=2e-3 * (before[2] - before[1]))
    assert after[1:] == before[1:]  # and nothing zoomed


def test_impacts_sound_when_asked_for(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    shown.page.click("#step")
    assert ball(shown, "sound.played") == []
    shown.page.click("#sound")
    assert shown.page.get_attribute("#sound", "aria-pressed") == "true"
    shown.page.click("#step")
    (pitch,) = ball(shown, "sound.played")
    speed, fastest = ball(shown, "past.marks.at(-1).speed"), ball(shown, "axes.y1")
    assert math.isclose(pitch, 196 * 2 ** (2.5 * speed / fastest), rel_tol=1e-12)
    shown.page.click("#sound")
    shown.page.click("#step")
    assert len(ball(shown, "sound.played")) == 1


def test_without_sound_the_page_says_so(browser, address):
    context = browser.new_context()
    context.add_init_script("delete globalThis.AudioContext;")
    page = Shown(context.new_page())
    page.open(f"{address}#version=2&view=ball&columns=20")
    page.page.click("#sound")
    assert "no sound" in page.problem() and page.page.get_attribute("#sound", "aria-pressed") == "false"
    context.close()
    assert page.errors == []
