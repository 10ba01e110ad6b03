"""What one sees first, and is shown by the tour: nothing empty, nothing out of sight, every sign set as it is read."""

import re

import pytest


@pytest.fixture
def kept():
    return True


OUT_OF_SIGHT = """async () => {
  const { TOUR } = await import("./tour.js"), { DEFAULTS } = await import("./state.js"), found = [];
  TOUR.forEach((step, i) => {
    const asked = step.question ? [step.state, { ...step.state, ...step.question.shown }] : [step.state];
    for (const own of asked) {
      const state = { ...DEFAULTS, ...own }, gap = state.view === "gap";
      const [low, high] = gap ? state.span : state.reach, value = gap ? state.mu : state[state.vary];
      if (state.view !== "chart" && !(value >= low && value <= high)) found.push(`${i + 1}: ${value}`);
    }
  });
  return found;
}"""


def test_each_step_of_the_tour_has_its_parameter_in_the_diagram(shown, address):
    shown.page.goto(f"{address}presets.js")  # any file of the same host
    assert shown.page.evaluate(OUT_OF_SIGHT) == []


@pytest.mark.parametrize(
    ("link", "field", "value", "axis"),
    [
        ("view=ball&columns=40", "offset", 0.3, "reach"),
        ("view=oscillator&columns=24&bins=20&reduced=no", "offset", -0.2, "reach"),
        ("view=gap&columns=40", "mu", 0.9, "span"),
    ],
)
def test_a_diagram_goes_along_with_its_parameter(shown, address, link, field, value, axis):
    shown.open(f"{address}#version=2&{link}")
    low, high = shown.page.evaluate(f"() => explorer.state().{axis}")
    shown.page.fill(f"input[type=number][name={field}]", str(value))
    shown.page.keyboard.press("Enter")
    shown.until(f"() => explorer.state().{field} === {value}")
    ends = shown.page.evaluate(f"() => explorer.state().{axis}")
    assert ends[0] < value < ends[1] and abs((ends[1] - ends[0]) - (high - low)) < 1e-6
    shown.settle()
    view = shown.page.evaluate("() => explorer.state().view")
    x0, x1 = shown.page.evaluate(f"() => {{ const a = explorer.views.{view}.diagram.axes; return [a.x0, a.x1]; }}")
    assert [x0, x1] == ends  # and the picture with it
    assert shown.problem() == ""


def test_one_period_opens_on_a_hit(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    shown.page.click("[data-view=strobe]")
    shown.until("() => document.getElementById('summary').textContent.includes('Zero-time map at')")


def test_signs_are_set_below(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=40")
    assert [each.text_content() for each in shown.page.query_selector_all("#hint sub")] == ["PD", "BC"]
    shown.open(f"{address}#version=2&view=gap&tour=8&answer=2&lam=0.5&l=0.1&span=-0.05:0.35&mu=0.1&columns=40")
    assert "_" not in shown.page.inner_text("#told") and shown.page.locator("#told sub").count() == 2


def test_the_answer_about_the_gap_shows_both(shown, address):
    shown.open(f"{address}#version=2&view=gap&tour=8&lam=0.5&l=0&span=-0.05:0.35&mu=0.1&columns=40")
    shown.page.locator("#choices button").nth(1).click()
    shown.settle()
    shown.until("() => document.getElementById('pinned').getAttribute('aria-label').includes('pinned: l = 0,')")
    assert shown.page.is_visible("#pinned")
    shown.page.click("#next")
    shown.until("() => explorer.state().tour === 9 && explorer.state().pinned === ''")


@pytest.mark.parametrize("page", ["index.html", "table.html"])
def test_on_a_phone_no_place_is_out_of_sight(phone, address, page):
    phone.page.goto(f"{address.removesuffix('index.html')}{page}")
    phone.until("() => document.querySelectorAll('nav > *').length > 4")
    ends = phone.page.evaluate(
        "() => [...document.querySelectorAll('nav > *')].map(e => e.getBoundingClientRect().right)"
    )
    assert max(ends) <= 390
    tops = phone.page.evaluate(
        "() => [...document.querySelectorAll('header > h1, .tools > *')].map(e => e.getBoundingClientRect().bottom)"
    )
    assert max(tops) < 60  # one line


@pytest.mark.parametrize("size", [(1280, 800), (1920, 1080)])
def test_a_game_is_copied_without_scrolling(pages, address, size):
    with pages(True, viewport={"width": size[0], "height": size[1]}, reduced_motion="reduce") as shown:
        shown.page.goto(f"{address.removesuffix('index.html')}table.html")
        shown.until("() => window.pinball && pinball.game()")
        box = shown.page.locator("[data-copy=link]").bounding_box()
        table = shown.page.locator("#table").bounding_box()
        assert box["y"] + box["height"] <= size[1] and table["height"] > 0.7 * size[1]


def test_growth_is_told_in_words(shown, address):
    shown.page.goto(f"{address.removesuffix('index.html')}table.html")
    shown.until("() => window.pinball && pinball.game() && pinball.exits()")
    shown.page.evaluate("() => { pinball.plunge(0.7); pinball.pause(); pinball.split(); }")
    shown.page.evaluate("() => { for (let i = 0; i < 200; i++) pinball.step(1 / 60); }")
    said = shown.page.inner_text("#parted")
    assert "e+" not in said and re.search(r"distances grew \d{1,3}(,\d{3})+ times: tenfold every \d\.\d+ s", said)


def test_between_walls_nothing_is_said_of_the_normal_form(shown, address):
    """It is that of one wall at rest: neither hint nor switches speak of windows, and the diagram has their room."""
    shown.open(f"{address}#version=2&view=oscillator&columns=20&bins=20")
    height = "() => document.getElementById('flow-diagram').getBoundingClientRect().height"
    low = shown.page.evaluate(height)
    switches = [shown.page.locator(f"text={words}") for words in ("windows of theory", "reduced diagram below")]
    assert "normal form" in shown.page.inner_text("#hint") and all(each.is_visible() for each in switches)
    shown.page.click("text=a second wall, above the ball")
    shown.settle()
    hint = shown.page.inner_text("#hint")
    assert "normal form" not in hint and "A below and B above" in hint
    assert not any(each.is_visible() for each in switches)
    assert shown.page.evaluate(height) > 1.5 * low
    shown.page.evaluate("() => (location.hash = '#version=2&view=oscillator&columns=20&bins=20&sin_A=0.1')")
    shown.until("() => !explorer.state().two && !/normal form|above/.test(document.getElementById('hint').textContent)")


def test_between_walls_velocities_have_true_minus_signs(shown, address):
    shown.open(f"{address}#version=2&view=ball&two=yes&sigma_B=0.3&columns=20&bins=20")
    shown.until("() => document.getElementById('summary').textContent.includes('Hits at')")
    said = next(line for line in shown.page.inner_text("#summary").splitlines() if line.startswith("Hits at"))
    assert "leaves with −" in said and "-" not in said


@pytest.mark.parametrize("motion", ["no-preference"])
@pytest.mark.parametrize("way", ["gap", "oscillator", "link", "room", "failed"])
def test_a_ball_whose_button_says_pause_runs(shown, address, way):
    shown.open(f"{address}#version=2&view=ball&columns=40")
    page, now = shown.page, "explorer.views.ball.now"
    if way == "link":
        shown.open(f"{address}#version=2&view=edges")
        page.go_back()
    elif way == "failed":  # a state that cannot be shown, and back
        page.evaluate("() => { location.hash = '#version=2&view=ball&columns=40&ball=-3:0:0'; }")
        shown.until("() => document.getElementById('main').classList.contains('failed')")
        page.evaluate("() => { location.hash = '#version=2&view=ball&columns=40&offset=0.12'; }")
        shown.until("() => !document.getElementById('main').classList.contains('failed')")
    else:
        page.click(f"[data-view={'gap' if way == 'room' else way}]")
        shown.until("() => explorer.state().view !== 'ball'")
        if way == "room":
            page.keyboard.press("p")
            page.click("#more")
        page.click("[data-view=ball]")
    shown.until("() => explorer.state().view === 'ball'")
    assert page.inner_text("#play") == "Pause"
    page.evaluate(f"() => {{ globalThis.then = {now}; }}")
    shown.until(f"() => {now} > globalThis.then + 0.1")


@pytest.mark.parametrize("motion", ["no-preference"])
def test_keys_of_the_hint_need_no_picture_to_be_chosen(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=40")
    page = shown.page
    page.keyboard.press(" ")
    assert page.inner_text("#play") == "Play" and page.evaluate("() => scrollY") == 0
    impacts = page.evaluate("() => explorer.views.ball.impacts")
    page.keyboard.press("s")
    assert page.evaluate("() => explorer.views.ball.impacts") == impacts + 1
    for button in ("#play", "#twin"):  # a mouse presses it, and the key is still the ball's
        page.click(button)
        said = page.inner_text("#play")
        page.keyboard.press(" ")
        assert page.inner_text("#play") != said
        assert page.get_attribute("#twin", "aria-pressed") == str(button == "#twin").lower()
    page.focus("#twin")
    page.keyboard.press(" ")  # who goes by keys alone presses it
    assert page.get_attribute("#twin", "aria-pressed") == "false"
    page.focus(".control[data-name=V] input[type=range]")
    said = page.inner_text("#play")
    page.keyboard.press(" ")
    assert page.inner_text("#play") != said
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("ArrowUp")
    assert page.evaluate("() => Boolean(explorer.views.ball.sling.aim)")
    page.click("#twin")  # a ball that is held is let go of: it would stand still, and nothing say why
    assert not page.evaluate("() => Boolean(explorer.views.ball.sling.aim)")
