"""What docs/explorer.md tells a lecturer to do, done: each row of its table shows what it says."""

import re
from contextlib import nullcontext
from pathlib import Path

from tests.explorer.browser import COARSE, FEW

ROWS = re.findall(
    r"^\| ([a-z ]+) \| ([A-Z][\w ]+) \| (.+?) \| (.+?) \|$",
    (Path(__file__).parents[2] / "docs" / "explorer.md").read_text(encoding="utf-8"),
    re.MULTILINE,
)


def said(shown, what, words):
    shown.until(f"() => document.querySelector({what!r}).innerText.includes({words!r})")


def number(shown, name, value):
    shown.page.fill(f"input[type=number][name={name}]", str(value))
    shown.page.keyboard.press("Enter")


def graze(shown, _then, _see):
    said(shown, "#lead", "never hits")
    number(shown, "offset", 0.1305)
    said(shown, "#lead", "hits once in")


def adding(shown, then, see):
    box = shown.page.locator("#flow-diagram").bounding_box()
    for d, word in zip(re.findall(r"0\.\d+", then), re.findall(r"[01]{3,}", see), strict=True):
        x = shown.page.evaluate(f"() => explorer.views.oscillator.diagram.axes.x({d})")
        shown.page.mouse.click(box["x"] + x, box["y"] + box["height"] / 2)
        said(shown, "#summary", f"word {word};")


def hysteresis(shown, _then, _see):
    shown.until("() => explorer.views.ball.company.sweeps.found")
    differ = shown.page.evaluate("() => explorer.views.ball.company.sweeps.differ()")
    assert any(low <= 0.1225 <= high for low, high in differ)
    shown.page.click("[data-view=chart]")
    shown.until("() => explorer.state().view === 'chart' && explorer.state().chart === 'basins'")
    for word in ("0001", "001"):
        said(shown, "#summary", word)


def cobweb(shown, then, _see):
    web = shown.page.evaluate("() => explorer.state().web")
    shown.page.click("#web-step")
    shown.page.keyboard.press("s")
    shown.page.focus("#gap-diagram")  # as when it is presented
    shown.page.keyboard.press("S")
    shown.until(f"() => explorer.state().web === {web + 3}")
    said(shown, "#summary", "word LLR")
    number(shown, "mu", float(re.search(r"0\.\d+", then)[0]) + 1e-3)
    shown.until("() => !document.querySelector('#summary').innerText.includes('word LLR')")


def chaos(shown, _then, _see):
    shown.page.click("#twin")
    shown.until("() => /λ = 0[.][345]/.test(document.querySelector('#rate').innerText)")


def chatter(shown, _then, _see):
    for _ in range(3):
        shown.page.click("#step")
    heights = "[...explorer.views.ball.past.marks].map(m => m.turn)"
    assert shown.page.evaluate(f"() => {heights}.length") >= 2
    said(shown, "#lead", "ever faster")


def table(shown, _then, _see):
    shown.until("() => globalThis.pinball?.game()")
    shown.page.evaluate(COARSE)
    assert shown.page.inner_text("#note").startswith("Launch a ball and split it")
    shown.page.keyboard.down(" ")
    shown.page.wait_for_timeout(200)
    shown.page.keyboard.up(" ")
    shown.until("() => pinball.game().t > 0")
    shown.page.keyboard.press("g")
    said(shown, "#parted", "distances grew")


DONE = [graze, adding, hysteresis, cobweb, chaos, chatter, table]


def test_what_a_lecturer_is_told_to_do_shows_what_it_says(shown, address):
    assert len(ROWS) == len(DONE)
    shown.open(f"{address}#version=2&view=edges")
    shown.page.evaluate(FEW)
    for (_what, exercise, then, see), do in zip(ROWS, DONE, strict=True):
        with shown.page.expect_navigation() if do is table else nullcontext():
            shown.page.select_option("#preset", label=exercise)
        shown.until("() => document.querySelector('#note').checkVisibility()")
        do(shown, then, see)
        assert shown.problem() == ""
