"""A picture that is kept while settings change, above the present one on its scale."""

import pytest


@pytest.fixture
def kept():
    return True


GAP = "version=2&view=gap&lam=0.5&l=0&span=-0.05:0.35&columns=80&bins=60"
#: Whether the pinned picture is on screen; what a click changes is seen in the next frame.
SEEN = "document.getElementById('pinned').offsetParent"


def test_a_picture_is_kept_above_another_on_one_scale(shown, address):
    shown.open(f"{address}#{GAP}&theory=no")
    shown.settle()
    shown.page.click("#pin")
    shown.until(f"() => {SEEN}")
    shown.settle()
    kept = shown.page.evaluate("() => document.getElementById('pinned').toDataURL()")
    shown.page.fill("input[type=number][name=l]", "0.3")
    shown.until("() => explorer.views.gap.diagram.drawn.row.includes(0.3)")
    shown.settle()
    label = shown.page.get_attribute("#pinned", "aria-label")
    assert "pinned: l = 0" in label
    size = "id => { const c = document.getElementById(id); return [c.clientWidth, c.clientHeight]; }"
    sizes = [shown.page.evaluate(size, each) for each in ("pinned", "gap-diagram")]
    assert sizes[0] == sizes[1]
    assert (
        shown.page.evaluate("() => document.getElementById('pinned').toDataURL()") != kept
    )  # the scale of the new one
    # zoomed, both show the same part
    shown.page.evaluate("() => explorer.views.gap.diagram.events.zoom([0.1, 0.2], [-0.3, 0.1])")
    shown.settle()
    axes = shown.page.evaluate("() => { const a = explorer.views.gap.diagram.axes; return [a.x0, a.x1]; }")
    assert axes == [0.1, 0.2]
    shown.page.click("#pin")
    shown.until(f"() => !({SEEN})")
    assert shown.page.get_attribute("#pin", "aria-pressed") == "false"


#: Gather how far above the lower edge of a picture what is written of it stands.
SPY = """id => {
  const canvas = document.getElementById(id), pen = canvas.getContext("2d"), write = pen.fillText;
  canvas.written = {};
  pen.fillText = (text, x, y) => ((canvas.written[text] = canvas.clientHeight - y), write.call(pen, text, x, y));
}"""
WRITTEN = "id => document.getElementById(id).written"


def test_words_about_a_picture_stand_where_none_of_it_is(shown, address):
    shown.open(f"{address}#{GAP}")
    shown.page.click("#pin")
    shown.until(f"() => {SEEN}")
    for each in ("pinned", "gap-diagram"):
        shown.page.evaluate(SPY, each)
    shown.page.fill("input[type=number][name=l]", "0.3")
    shown.until("() => Object.keys(document.getElementById('pinned').written).some(t => t.startsWith('pinned: l'))")
    written = shown.page.evaluate(WRITTEN, "pinned")
    assert max(up for text, up in written.items() if text.startswith("pinned")) < 10 < written["3"]  # a window's period
    shown.page.evaluate("() => explorer.views.gap.diagram.axes.progress(0.5, -1e9)")
    assert shown.page.evaluate(WRITTEN, "gap-diagram")["50 %"] < 10


def test_what_cannot_be_compared_is_not_shown(shown, address):
    shown.open(f"{address}#{GAP}")
    shown.settle()
    shown.page.click("#pin")
    shown.page.click("[data-view=oscillator]")
    shown.settle()
    shown.until(f"() => !({SEEN})")
    assert shown.page.is_visible("#pin")
    shown.page.click("[data-view=ball]")
    shown.until("() => explorer.state().view === 'ball' && document.getElementById('pin').hidden")
    shown.page.click("[data-view=gap]")
    shown.until(f"() => {SEEN}")
    assert shown.problem() == ""


@pytest.mark.parametrize("law", ["newton", "active"])
def test_laws_that_differ_are_named(shown, address, law):
    shown.open(f"{address}#version=2&view=oscillator&law={law}&columns=24&bins=20&reduced=no")
    shown.settle()
    shown.page.click("#pin")
    other = {"newton": "active", "active": "newton"}[law]
    shown.page.select_option(".choice select >> nth=0", other)
    shown.settle()
    shown.until(f"() => document.getElementById('pinned').getAttribute('aria-label').includes('{law}')")


def test_no_line_is_lost_where_a_picture_is_made_smaller(shown, address):
    """Where five rows of the kept picture share a pixel, each column still shows the line of its orbit."""
    shown.open(f"{address}#version=2&view=gap&lam=0.5&l=0.1&span=0.2:0.35&mu=0.3&columns=80&bins=600&theory=no")
    shown.settle()
    shown.page.click("#pin")
    shown.page.evaluate("() => explorer.views.gap.diagram.events.zoom([0.2, 0.35], [-1.5, 1.5])")
    shown.settle()
    empty = shown.page.evaluate(
        """() => {
          const canvas = document.getElementById("pinned"), { ratio, box } = explorer.views.gap.diagram.axes;
          const c = canvas.getContext("2d"), [x, y] = [ratio * (box.x + 4), ratio * (box.y + 4)].map(Math.round);
          const [w, h] = [ratio * (box.w - 8), ratio * (box.h - 8)].map(Math.floor);
          const { data } = c.getImageData(x, y, w, h), all = many => Array.from({ length: many }, (_, i) => i);
          const plain = (i, j) => [0, 1, 2].every(k => data[4 * (j * w + i) + k] === data[k]);
          return all(w).filter(i => all(h).every(j => plain(i, j))).length;
        }"""
    )
    assert empty == 0


SHOWN_IN_PINNED = """() => {
  const canvas = document.getElementById("pinned"), c = canvas.getContext("2d");
  const { data } = c.getImageData(0, 0, canvas.width, canvas.height);
  let sum = 0;
  for (let i = 0; i < data.length; i += 4) sum = (31 * sum + data[i]) % 1000003;
  return [canvas.width, canvas.height, sum, canvas.getAttribute("aria-label")];
}"""


def settled(shown):
    shown.until("() => document.getElementById('pinned').dataset.stage === 'done'")
    shown.settle()


@pytest.mark.parametrize(
    ("link", "field", "value"),
    [(f"{GAP}&theory=no", "l", "0.3"), ("version=2&view=oscillator&columns=24&bins=20&reduced=no", "V", "0.1")],
)
def test_what_is_pinned_is_part_of_the_link(shown, address, link, field, value):
    shown.open(f"{address}#{link}")
    shown.page.click("#pin")
    shown.page.fill(f"input[type=number][name={field}]", value)
    shown.page.keyboard.press("Enter")
    settled(shown)
    link, seen = shown.link(), shown.page.evaluate(SHOWN_IN_PINNED)
    assert "pinned=" in link and f"{field} = " in seen[-1]
    shown.page.goto("about:blank")
    shown.open(link)
    settled(shown)
    assert shown.page.evaluate(SHOWN_IN_PINNED) == seen
    assert shown.problem() == ""
    shown.page.click("#pin")
    assert "pinned=" not in shown.link()


def test_a_figure_is_compared_with_another(shown, address):
    shown.open(f"{address}#{GAP}")
    shown.page.select_option("#preset", "3.3a")
    shown.settle()
    shown.page.click("#pin")
    shown.page.select_option("#preset", "3.3c")
    settled(shown)
    assert shown.page.get_attribute("#pinned", "aria-label").startswith("The pinned: l = 0,")
    assert shown.page.input_value("#preset") == "3.3c"


@pytest.mark.parametrize(
    ("pinned", "said"),
    [
        ("view%3Dchart", "the view chart is pinned"),
        ("view%3Dgap%26lam%3Dx", "lam=x is not a number"),
        ("view%3Dgap%26pinned%3Dview%253Dball", "the view ball is pinned"),
    ],
)
def test_a_pinned_setting_that_cannot_be_read_is_explained(shown, address, pinned, said):
    shown.open(f"{address}#{GAP}&pinned={pinned}")
    assert said in shown.problem()
    assert not shown.page.is_visible("#pinned")


def test_what_is_pinned_is_saved_with_the_picture(shown, address):
    shown.open(f"{address}#{GAP}&pinned={GAP.replace('version=2&', '').replace('=', '%3D').replace('&', '%26')}")
    settled(shown)
    with shown.page.expect_download() as kept:
        shown.page.click("[data-save=svg]")
    text = kept.value.path().read_text(encoding="utf-8")
    assert text.count("<image") == 2 and ">pinned<" in text
