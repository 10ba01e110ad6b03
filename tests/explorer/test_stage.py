"""The page before a room, and what can be read from where: sizes of letters, and what needs no scrolling."""

from contextlib import ExitStack

import pytest

from tests.explorer.browser import AXE, FEW, LOADED, NEEDS_AXE

VIEWS = {
    "ball": "view=ball&offset=0.1225&twin=yes&columns=60",
    "gap": "view=gap&columns=60&web=4",
    "oscillator": "view=oscillator&columns=30&bins=40",
    "chart": "view=chart&chart_columns=20&chart_rows=16",
    "strobe": "view=strobe",
    "edges": "view=edges",
    "tour": "view=ball&tour=2&offset=0.1305&columns=60",
}
PHONE = (390, 844)
#: What can be read of the page: the least size of a letter, and whose it is.
SMALLEST = """() => {
  let least = [Infinity, ""];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode());) {
    const { parentElement: box } = node;
    if (!node.data.trim() || !box.checkVisibility() || box.closest("noscript, option, script")) continue;
    const range = document.createRange();
    range.selectNode(node);
    if (!range.getBoundingClientRect().width) continue;
    const size = parseFloat(getComputedStyle(box).fontSize);
    if (size < least[0]) least = [size, `${box.tagName} ${node.data}`];
  }
  for (const field of document.querySelectorAll("select, input[type=number]")) {
    if (field.checkVisibility()) least = [Math.min(least[0], parseFloat(getComputedStyle(field).fontSize)), least[1]];
  }
  return least;
}"""
#: Whether the picture of exits is where it was ten frames ago: what stands above it may still find its height.
AT_REST = """() => new Promise((tell) => {
  const where = () => JSON.stringify(document.querySelector("#exits").getBoundingClientRect()), before = where();
  let left = 10;
  const look = () => (left-- > 0 ? requestAnimationFrame(look) : tell(where() === before));
  look();
})"""
#: Pictures and buttons that all controls or the tabs lie over, and tabs that their line cuts; the tour has none.
COVERED = """() => {
  const box = (e) => e.getBoundingClientRect();
  const seen = (s) => [...document.querySelectorAll(s)].filter((e) => e.checkVisibility());
  const top = box(document.querySelector("#controls")).top, line = box(document.querySelector("header"));
  return [...seen("#guide, .view :is(figure, button)").filter((e) => box(e).bottom > top || box(e).top < line.bottom),
    ...seen("nav > *").filter((e) => line.width > 1 && (box(e).bottom > line.bottom || box(e).right > line.right))]
    .map((e) => e.outerHTML);
}"""
#: The sizes of letters in the pictures that are seen, in CSS pixels: what is written is measured as it is drawn.
DRAWN = """async () => {
  const sizes = [], write = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
    const size = parseFloat(/([\\d.]+)px/.exec(this.font)[1]);
    if (this.canvas.offsetParent) sizes.push(size * this.getTransform().a / devicePixelRatio);
    return write.call(this, text, ...rest);
  };
  for (const { draw } of explorer.views[explorer.state().view].panels()) draw();
  CanvasRenderingContext2D.prototype.fillText = write;
  return Math.min(...sizes);
}"""


def presenting(shown):
    return shown.page.evaluate("() => document.body.classList.contains('presenting')")


@pytest.fixture
def kept():
    return True


@pytest.fixture
def opened(pages, address):
    """Give pages of a size that show a view, and stay open for the next test."""
    with ExitStack() as shown_ones:

        def one(view, size=(1280, 800), more="", **reader):
            common = {
                "viewport": {"width": size[0], "height": size[1]},
                "reduced_motion": "reduce",
                "color_scheme": "light",
            }
            shown = shown_ones.enter_context(pages(True, **(common | reader)))
            shown.open(f"{address}#version=2&{VIEWS[view]}{more}")
            return shown

        yield one


@pytest.mark.parametrize("view", VIEWS)
def test_before_a_room_nothing_is_smaller_than_24_pixels(opened, view):
    shown = opened(view, (1920, 1080))
    shown.page.keyboard.press("p")
    shown.settle()
    assert presenting(shown)
    for more in (False, True):
        if more:
            shown.page.click("#more")
            assert shown.page.evaluate(COVERED) == []
        size, whose = shown.page.evaluate(SMALLEST)
        assert size >= 24, whose
    shown.page.click("#more")
    assert shown.page.evaluate(DRAWN) >= 24
    # the picture fills the screen, and the controls lie over its foot
    bottom, right = shown.page.evaluate(
        "() => [document.documentElement.scrollHeight, document.documentElement.scrollWidth]"
    )
    assert (bottom, right) == (1080, 1920)
    boxes = shown.page.evaluate(
        "() => [...document.querySelectorAll('main canvas')].filter(c => c.offsetParent).map(c => { "
        "const { width, height, bottom } = c.getBoundingClientRect(); return [width * height, height, bottom]; })"
    )
    assert sum(box[0] for box in boxes) > 0.4 * 1920 * 1080 and all(box[1] > 150 and box[2] <= 1080 for box in boxes)


def test_before_a_room_all_orbits_are_named_and_no_coordinates(opened, address):
    shown = opened("oscillator", (1920, 1080))
    shown.page.goto(f"{address}#version=2&view=oscillator&columns=30&bins=40&offset=0.1225")
    shown.until("() => document.getElementById('summary').innerText.includes('word')")
    assert "(0.0" in shown.page.inner_text("#summary")
    shown.page.keyboard.press("p")
    said = shown.page.inner_text("#summary")
    assert "word 0001" in said and "word 001;" in said and "(0." not in said
    bottoms = shown.page.evaluate(
        "() => [...document.querySelectorAll('#summary .chip')].map(e => e.getBoundingClientRect().bottom)"
    )
    assert len(bottoms) == 2 and max(bottoms) < shown.page.evaluate(
        "() => document.querySelector('.below').getBoundingClientRect().bottom"
    )
    shown.page.click("#more")
    assert shown.page.inner_text("#more") == "Fewer controls"
    shown.page.click("[data-view=gap]")
    shown.until("() => explorer.state().view === 'gap'")
    shown.page.go_back()
    shown.until("() => explorer.state().view === 'oscillator'")
    shown.page.click("#more")
    assert shown.page.inner_text("#more") == "All controls"
    shown.page.goto(f"{address}#version=2&view=oscillator&columns=30&bins=40&offset=0.1305&tour=3&answer=1")
    shown.until("() => explorer.state().answer === 1")
    box = shown.page.locator("#figures > .below").bounding_box()  # one line: the step has the room
    assert shown.page.inner_text("#summary").startswith("At d = 0.1305:") and box["height"] < 2 * 24
    # what is wrong with a link lies over nothing
    shown.page.goto(f"{address}#version=2&view=oscillator&columns=30&bins=40&foo=1")
    shown.until("() => !document.getElementById('problem').hidden")
    ends = [shown.page.locator(what).bounding_box() for what in ("#problem", "#summary", "#stage", "#flow-diagram")]
    assert ends[0]["y"] + ends[0]["height"] <= ends[1]["y"] and ends[0]["x"] + ends[0]["width"] <= ends[2]["x"]
    assert ends[3]["height"] > 300 and shown.page.evaluate("() => document.documentElement.scrollHeight") == 1080


def test_it_begins_and_ends_by_key_and_button(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=60")
    before = shown.pixels("strip")
    shown.page.click("#present")
    assert presenting(shown) and shown.page.is_hidden("nav") and shown.page.is_visible("#end")
    shown.page.click("#end")
    assert not presenting(shown) and shown.page.evaluate("() => document.activeElement.id") == "present"
    shown.page.keyboard.press("P")
    assert presenting(shown) and shown.pixels("strip") != before
    shown.page.click("#more")
    assert shown.page.evaluate(COVERED) == []
    shown.page.click("#more")
    box = shown.page.locator("#ball-diagram").bounding_box()
    shown.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    shown.page.mouse.wheel(0, -200)
    shown.until("() => explorer.state().reach[0] > 0.05")  # in full screen too
    shown.page.keyboard.press("p")
    assert not presenting(shown)
    shown.page.keyboard.press("p")
    shown.page.keyboard.press("ArrowUp")
    shown.page.keyboard.press("Escape")  # lets go of the ball that is aimed
    assert presenting(shown)
    shown.page.keyboard.press("Escape")
    assert not presenting(shown)
    shown.page.focus("input[type=number][name=V]")
    shown.page.keyboard.press("p")  # a letter in a field is none of this
    assert not presenting(shown)


@pytest.mark.parametrize("times", [5, 6])
def test_who_begins_and_ends_in_haste_has_what_was_asked_for_last(shown, address, times):
    """The end of a full screen that the page had left was taken for the browser's own key."""
    shown.open(f"{address}#version=2&view=ball&columns=60")
    for _ in range(4):
        for _ in range(times):
            shown.page.keyboard.press("p")
        shown.page.wait_for_timeout(300)  # all that is under way has arrived
        assert presenting(shown) == (times % 2 == 1)
        assert shown.page.evaluate("() => Boolean(document.fullscreenElement)") == (times % 2 == 1)
        if times % 2:
            shown.page.keyboard.press("Escape")
            shown.until("() => !document.body.classList.contains('presenting') && !document.fullscreenElement")


@pytest.mark.parametrize("how", ["mouse", "keys"])
def test_who_has_chosen_with_a_mouse_leaves_the_keys_to_the_page(shown, address, how):
    """The menu kept P and S after an exercise was chosen; by keys one may go on in it."""
    shown.open(f"{address}#version=2&view=ball&columns=60")
    shown.page.dispatch_event("#preset", "pointerdown")
    if how == "keys":
        shown.page.focus("#preset")
        shown.page.keyboard.press("Tab")
        shown.page.keyboard.press("Shift+Tab")
        shown.page.keyboard.press("ArrowDown")
    shown.page.select_option("#preset", label="Chaos")
    shown.until("() => explorer.state().omega === 6")
    shown.page.keyboard.press("p")
    assert presenting(shown) == (how == "mouse")
    assert (shown.page.evaluate("() => document.activeElement.id") == "preset") == (how == "keys")
    if how == "mouse":
        shown.page.keyboard.press("p")


@pytest.mark.parametrize("view", ["ball", "gap", "oscillator", "tour"])
def test_a_narrow_screen_is_filled_too(opened, view):
    shown = opened(view, PHONE, has_touch=True, is_mobile=True)
    shown.page.tap("#present")
    assert presenting(shown)
    shown.until(f"async () => await ({DRAWN})() > 17.999")
    assert shown.page.evaluate(SMALLEST)[0] >= 18
    size = "() => [document.documentElement.scrollHeight, document.documentElement.scrollWidth]"
    assert shown.page.evaluate(size) == [844, 390]
    picture = shown.page.locator("main .view:not([hidden]) .first").bounding_box()
    slider = shown.page.locator(".control.turned").bounding_box()
    assert picture["height"] > 200 and picture["y"] + picture["height"] <= slider["y"]
    assert slider["y"] + slider["height"] <= 844
    cut = """() => [...document.querySelectorAll("#controls :is(input, label, select)")]
      .filter((e) => e.checkVisibility() && e.getBoundingClientRect().bottom > innerHeight - 8).map((e) => e.name)"""
    assert shown.page.evaluate(cut) == []
    if AXE.exists():
        assert shown.violations() == []
    shown.page.tap("#end")
    assert not presenting(shown)


def test_on_a_phone_before_a_room_each_step_of_the_tour_is_seen_from_its_title(phone, address):
    phone.open(f"{address}#version=2&view=ball&columns=20")
    page = phone.page
    page.keyboard.press("p")
    page.tap("#more")
    page.tap("#tour")  # all controls lie where the tour would be: they give way
    phone.until("() => explorer.state().tour === 1")
    assert page.is_visible("#guide-title") and page.is_visible("#next") and page.inner_text("#more") == "All controls"
    phone.open(f"{address}#version=2&view=ball&columns=20&omega=6&V=0&offset=-0.2&tour=9")
    assert page.evaluate("() => { const { guide } = window; guide.scrollTop = 90; return guide.scrollTop; }") > 40
    page.tap("#next")  # the answer of the step before was read to its end
    phone.until("() => explorer.state().tour === 10")
    assert page.evaluate("() => window.guide.scrollTop") == 0


@pytest.mark.parametrize("motion", ["no-preference"])
def test_keys_are_at_hand_before_a_room(shown, address):
    shown.open(f"{address}#version=2&view=ball&offset=0.14&tour=1&columns=60")
    shown.page.keyboard.press("p")
    # where the screen is low the step stands beside its pictures, which have room
    guide, strip, diagram = (shown.page.locator(f"#{id}").bounding_box() for id in ("guide", "strip", "ball-diagram"))
    assert guide["x"] + guide["width"] < strip["x"] and min(strip["height"], diagram["height"]) > 200
    shown.page.keyboard.press(" ")
    assert presenting(shown) and not shown.page.evaluate("() => explorer.views.ball.playing")
    shown.page.keyboard.press("PageDown")  # of a remote control
    shown.until("() => explorer.state().tour === 2")
    shown.page.keyboard.press("PageDown")
    shown.until("() => explorer.state().tour === 3 && explorer.state().view === 'oscillator'")
    shown.page.keyboard.press("PageUp")
    shown.until("() => explorer.state().tour === 2")
    shown.page.focus(".control[data-name=offset] input[type=range]")  # as after a drag: the page is turned, no slider
    shown.page.keyboard.press("PageDown")
    shown.until("() => explorer.state().tour === 3")
    shown.page.wait_for_timeout(100)
    assert shown.page.evaluate("() => explorer.state().offset") == 0.1305
    shown.page.fill("input[type=number][name=offset]", "0.13")
    shown.page.keyboard.press("PageUp")  # nor is a field
    shown.until("() => explorer.state().tour === 2")
    assert presenting(shown) and shown.problem() == ""
    shown.page.keyboard.press("Escape")
    shown.until("() => !document.body.classList.contains('presenting')")


def test_hands_do_the_same_before_a_room(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=60&mu=0.12345678")
    shown.page.keyboard.press("p")
    shown.settle()
    width = "e => [e.scrollWidth, e.clientWidth]"
    whole, room = shown.page.eval_on_selector("input[type=number][name=mu]", width)
    assert whole <= room and "μ = 0.123457," in shown.page.inner_text("#summary")
    axes = "explorer.views.gap.diagram.axes"
    box = shown.page.locator("#gap-diagram").bounding_box()
    x, y = box["x"] + 0.7 * box["width"], box["y"] + 0.4 * box["height"]
    under = (
        f"([x, y]) => {{ const a = {axes}, [across, down] = a.place({{ clientX: x, clientY: y }}); "
        "return [a.atX(across), a.atY(down)]; }"
    )
    before = shown.page.evaluate(under, [x, y])
    width = shown.page.evaluate(f"() => {axes}.x1 - {axes}.x0")
    shown.page.mouse.click(x, y)
    shown.until(f"() => Math.abs(explorer.state().mu - {before[0]}) < 2e-3")
    shown.page.mouse.wheel(0, -300)
    shown.until(f"() => {axes}.x1 - {axes}.x0 < {0.9 * width}")
    shown.settle()
    after = shown.page.evaluate(under, [x, y])
    assert abs(after[0] - before[0]) < 4e-3 * width


@NEEDS_AXE
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("view", ["ball", "gap", "chart", "strobe", "tour"])
def test_axe_reports_no_violation_before_a_room(opened, view, scheme):
    shown = opened(view, color_scheme=scheme)
    shown.page.keyboard.press("p")
    shown.page.click("#more")
    assert shown.violations() == []


# ---- as it is used


@pytest.mark.parametrize("view", VIEWS)
def test_at_a_desk_nothing_is_smaller_than_14_pixels(opened, view):
    shown = opened(view)
    size, whose = shown.page.evaluate(SMALLEST)
    assert size >= 14, whose
    assert shown.page.evaluate(DRAWN) >= 14


def test_all_sliders_of_the_opening_are_seen_without_scrolling(opened):
    for view, size in (("ball", (1280, 800)), ("ball", (1920, 1080))):
        shown = opened(view, size)
        bottoms = shown.page.evaluate(
            "() => [...document.querySelectorAll('#oscillator-sliders > .control')].filter(e => e.offsetParent)"
            ".map(e => e.getBoundingClientRect().bottom)"
        )
        assert len(bottoms) == 7 and max(bottoms) <= size[1]


@pytest.mark.parametrize(("tour", "height"), [("", 450), ("&tour=2", 350)])
def test_the_opening_needs_no_scrolling(opened, address, tour, height):
    shown = opened("ball", (1920, 1080))
    shown.open(f"{address}#version=2&view=ball&columns=60{tour}")
    shown.until("() => document.getElementById('summary').textContent.includes('starts')")
    assert shown.page.evaluate("() => document.documentElement.scrollHeight") == 1080
    assert shown.page.locator("#strip").bounding_box()["height"] > height


def test_a_slider_is_named_in_words_and_by_its_symbol(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=60")
    names = shown.page.evaluate(
        "() => [...document.querySelectorAll('#oscillator-sliders .control[data-name] label')].map(e => e.textContent)"
    )
    assert {
        "steady push d",
        "kick of the bumper V",
        "bounce r",
        "damping α",
        "pace of the pushes ω",
        "spring k",
    } <= set(names)
    exact = shown.page.get_attribute(".control[data-name=offset] label", "title")
    assert exact == "constant part of the forcing"  # and what it is exactly is there to be asked


def test_every_parameter_has_words(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    missing = shown.page.evaluate(
        "async () => { const { WORDS } = await import('./names.js'); const all = '.control[data-name]'; "
        "return [...document.querySelectorAll(all)].map(e => e.dataset.name).filter(n => !WORDS[n]); }"
    )
    assert missing == []


@pytest.mark.parametrize("view", ["chart", "edges", "oscillator"])
def test_on_a_phone_the_words_stand_under_the_picture(opened, view):
    shown = opened(view, PHONE, "&reduced=no", has_touch=True, is_mobile=True)
    tops = shown.page.evaluate(
        "() => ['main .view:not([hidden]) .first', '#summary', '#controls', '[data-copy=link]', '#hint']"
        ".map(e => document.querySelector(e).getBoundingClientRect().top)"
    )
    assert tops == sorted(tops)


def test_the_title_of_a_step_and_its_buttons_share_a_line_before_a_room(opened):
    shown = opened("tour", (1920, 1080))
    shown.page.keyboard.press("p")
    shown.until("() => document.body.classList.contains('presenting')")
    top = "id => document.getElementById(id).getBoundingClientRect().top"
    assert abs(shown.page.evaluate(top, "guide-title") - shown.page.evaluate(top, "next")) < 20


@pytest.mark.parametrize(("size", "least"), [((1920, 1080), 24), ((1280, 800), 24), ((390, 844), 18)])
def test_the_table_before_a_room(pages, address, size, least):
    shape = {"width": size[0], "height": size[1]}
    with pages(False, viewport=shape, has_touch=size[0] < 700) as shown:
        table_before_a_room(shown, address, size, least)


def table_before_a_room(shown, address, size, least):
    shown.page.goto(f"{address.removesuffix('index.html')}table.html")
    shown.until("() => window.pinball && pinball.game()?.t > 0 && pinball.exits()?.shares")
    shown.page.evaluate("() => pinball.pause()")
    keys = [each.inner_text() for each in shown.page.query_selector_all(".buttons kbd") if each.is_visible()]
    assert keys == ([] if size[0] < 720 else ["K", "G"])  # a phone has none to press
    shown.page.click("#present")
    assert presenting(shown) and shown.page.evaluate(SMALLEST)[0] >= least
    around = "() => [document.documentElement.scrollHeight, document.documentElement.scrollWidth]"
    assert shown.page.evaluate(around) == [size[1], size[0]]
    box = shown.page.locator("#table").bounding_box()
    assert box["height"] > 0.6 * size[1] and box["y"] + box["height"] <= size[1]
    shown.page.click("#more")  # all that can be done is at hand, and nothing is cut
    assert shown.page.is_visible("#rungs") and shown.page.is_visible("#fan") and shown.page.is_visible("[name=pace]")
    assert shown.page.evaluate(SMALLEST)[0] >= least and shown.page.evaluate(around) == [size[1], size[0]]
    assert size[0] < 720 or shown.page.evaluate(COVERED) == []
    shown.page.click("#more")
    assert shown.page.is_hidden("#rungs") and shown.page.is_hidden("#fan")
    if least == 24:  # where a hand points is where the picture says, once that has come to rest
        shown.until(AT_REST)
        x, y, right, up = shown.page.evaluate(
            "() => { const a = pinball.exits().axes, r = a.canvas.getBoundingClientRect(); "
            "const at = (f, pixel) => (pixel / a.zoom - f(0)) / (f(1) - f(0)), x = (v) => a.x(v), y = (v) => a.y(v); "
            "return [at(x, 0.6 * r.width), at(y, 0.6 * r.height), ...[x, y].map(f => Math.abs(1 / (f(1) - f(0))))]; }"
        )
        box = shown.page.locator("#exits").bounding_box()
        shown.page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.6 * box["height"])
        shown.until("() => pinball.exits().chosen")  # the words of a launch may move the picture then
        angle, speed = shown.page.evaluate("() => pinball.exits().chosen")
        assert abs(angle - x) <= right and abs(speed - y) <= up and 0 < angle < 6.3 and speed > 0
    if AXE.exists():
        assert shown.violations() == []
    shown.page.keyboard.press("p")
    assert not presenting(shown)


def corner(box):
    return (box["x"], box["width"]), (box["y"], box["height"])


def test_one_key_presents_on_both_pages_and_the_stage_is_kept_on_the_way(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=40")
    page = shown.page
    page.keyboard.press("p")
    page.click("#more")
    assert page.is_visible("#tour") and page.is_visible("#preset") and "Page Down" in page.inner_text("#tour")
    assert not page.is_visible("#present")
    page.click("#tour")
    shown.until("() => explorer.state().tour === 1")
    assert page.is_visible("[data-view=chart]") and page.evaluate(COVERED) == []
    page.click("#more")
    assert not page.is_visible("#tour")
    page.click("#more")
    page.click("nav a")
    shown.until("() => window.pinball && document.body.classList.contains('presenting')")
    shown.until("() => pinball.exits()?.game")
    page.keyboard.press("k")
    assert page.inner_text("#said").startswith("Paused")
    page.keyboard.press("k")
    assert page.inner_text("#said") == ""
    page.keyboard.press("p")
    assert not presenting(shown)
    page.go_back()
    page.reload()
    shown.until("() => window.explorer")
    page.wait_for_timeout(50)
    assert not presenting(shown)


#: A slider, and whether its page scrolls.
SLIDERS = {
    "index.html#version=2&view=ball&columns=20": ".control[data-name=offset] input[type=range]",
    "table.html": "[name='*.V']",
}


@pytest.mark.parametrize("where", SLIDERS)
def test_a_finger_that_scrolls_sets_no_slider(phone, address, where):
    page = phone.page
    page.goto(address.removesuffix("index.html") + where)
    phone.until("() => window.explorer || window.pinball?.exits()?.game")
    slider = page.locator(SLIDERS[where])
    slider.scroll_into_view_if_needed()
    page.evaluate("() => scrollBy(0, -60)")
    box, before, top = slider.bounding_box(), slider.input_value(), page.evaluate("() => scrollY")
    x, y = box["x"] + 0.2 * box["width"], box["y"] + box["height"] / 2

    def touch(kind, *points):
        places = [{"x": px, "y": py} for px, py in points]
        phone.fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})

    touch("touchStart", (x, y))
    for i in range(1, 9):
        touch("touchMove", (x, y - 15 * i))
    touch("touchEnd")
    phone.until(f"() => scrollY > {top}")
    here = "new Promise((done) => setTimeout(done, 100, scrollY))"
    phone.until(f"() => {here}.then((y) => y === scrollY)")  # it goes on for a moment
    assert slider.input_value() == before
    box = slider.bounding_box()
    x, y = box["x"] + 0.2 * box["width"], box["y"] + box["height"] / 2
    touch("touchStart", (x, y))
    for i in range(1, 9):
        touch("touchMove", (x + 10 * i, y))
    touch("touchEnd")
    phone.until(f"() => document.querySelector({SLIDERS[where]!r}).value !== '{before}'")


@LOADED
@pytest.mark.parametrize("file", ["index.html#version=2&view=ball&columns=20", "table.html"])
def test_the_key_that_presents_waits_for_no_kernels(shown, address, file):
    held, page = [], shown.page
    page.route("**/kernels.json", lambda route: held.append(route))
    with page.expect_request("**/kernels.json"):
        page.goto(address + file)
    page.keyboard.press("p")
    assert page.evaluate("() => document.body.classList.contains('presenting')")
    page.evaluate("() => dispatchEvent(new Event('resize'))")
    page.wait_for_timeout(50)
    held[0].continue_()
    shown.until("() => globalThis.explorer?.views.ball.flight || globalThis.pinball?.game()")
    assert page.evaluate("() => document.body.classList.contains('presenting')")


#: Sentences of the words that are cut: neither all seen nor none of it.
CUT = """() => {
  const { top, bottom } = document.querySelector(".below").getBoundingClientRect();
  return [...document.querySelectorAll("#summary p")].filter((e) => e.checkVisibility()).filter((e) => {
    const lines = [...e.getClientRects()], seen = lines.filter((l) => l.top > top - 1 && l.bottom < bottom + 1);
    return seen.length && seen.length < lines.length || lines.some((l) => l.top < bottom - 4 && l.bottom > bottom + 4);
  }).map((e) => e.textContent);
}"""


def test_on_a_low_screen_the_cobweb_is_large_and_no_sentence_is_cut(opened, address):
    shown = opened("gap", (1280, 720))
    page = shown.page
    page.keyboard.press("p")
    at = "&l=0.1&lam=0.5&mu=0.15"
    side = "() => { const { box, zoom } = explorer.views.gap.cobweb.axes; return box.w * zoom; }"
    for more, least in (
        ("", 280),
        (f"&tour=7{at}", 320),
        (f"&tour=7&answer=3{at}", 320),
    ):
        page.goto(f"{address}#version=2&view=gap&columns=60&web=4{more}")
        shown.until(f"() => explorer.state().tour === {7 if more else 0} && document.querySelector('#summary p')")
        page.wait_for_timeout(100)
        assert page.evaluate(side) > least and page.evaluate(CUT) == []
    assert page.is_hidden("#gap-diagram")
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("s")  # the picture that is seen has the keys
    shown.until("() => explorer.state().web === 5")
    page.goto(
        f"{address}#version=2&view=gap&columns=60&tour=8&answer=2&l=0.1&lam=0.5&mu=0.1&pinned=view%3Dgap%26lam%3D0.5%26l%3D0%26columns%3D60"
    )
    shown.until("() => document.querySelector('#pinned:not([hidden])')")
    box = page.locator("#gap-diagram").bounding_box()
    assert box["width"] > 600 and page.is_hidden("#cobweb")
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("ArrowRight")
    shown.until("() => explorer.state().mu > 0.1")


def test_at_a_desk_the_cobweb_fills_its_card(opened):
    shown = opened("gap")
    left, right, under = shown.page.evaluate(
        "() => { const { box, canvas, zoom } = explorer.views.gap.cobweb.axes, card = canvas.parentElement; "
        "return [box.x, canvas.clientWidth - box.x - box.w, card.clientHeight - box.h]; }"
    )
    assert under < 130 and left + right < 120


def test_on_a_low_screen_an_exercise_leaves_room_for_its_pictures(opened, address):
    shown = opened("ball", (1280, 720))
    note = "%20many%20words%20of%20a%20question" * 5
    shown.open(f"{address}#version=2&view=ball&columns=60&twin=yes&V=0&omega=6&offset=-0.2&reach=-0.3:0&note=Say{note}")
    shown.page.keyboard.press("p")
    shown.until("() => document.querySelector('#rate').innerText.includes('λ')")
    shown.page.wait_for_timeout(100)
    for canvas in ("strip", "ball-diagram"):
        assert shown.page.locator(f"#{canvas}").bounding_box()["height"] > 220


#: Buttons of the ball that are seen whole, and under no other thing, with how high they are.
PRESSED = """() => ["play", "step", "settle", "twin", "sweeps"].map((id) => {
  const button = document.getElementById(id), { x, y, width, height } = button.getBoundingClientRect();
  return button.contains(document.elementFromPoint(x + width / 2, y + height / 2)) ? height : 0;
})"""


@pytest.mark.parametrize("more", ["", "&note=For which d do two orbits live?", "&tour=6", "&tour=9&answer=2"])
def test_on_a_phone_before_a_room_the_buttons_of_the_ball_are_at_hand(phone, address, more):
    phone.open(f"{address}#version=2&view=ball&columns=20&omega=6&V=0&offset=-0.2&reach=-0.3:0{more}")
    phone.page.keyboard.press("p")
    phone.until("() => document.getElementById('stage').checkVisibility()")
    for everything in (False, True):
        if everything:
            phone.page.tap("#more")
        heights = phone.page.evaluate(PRESSED)
        assert min(heights) >= 44, heights
    phone.page.tap("#more")
    phone.page.tap("#play")  # measured while the ball flies
    phone.page.tap("#twin")
    phone.until("() => document.getElementById('rate').innerText.includes('±')")
    rate, slider = (phone.page.locator(what).bounding_box() for what in ("#rate", ".control.turned"))
    assert rate["y"] + rate["height"] <= slider["y"]
    phone.page.tap("#sweeps")  # and its picture is seen
    assert phone.page.locator("#ball-diagram").bounding_box()["height"] > 90


def test_on_a_phone_the_slider_of_an_exercise_is_in_the_first_screen(phone, address):
    note = "Let d fall until the ball just touches the bumper. Where is that, and which formula gives it?"
    phone.open(f"{address}#version=2&view=ball&columns=20&offset=0.14&note={note}")
    slider = phone.page.locator(".control.turned").bounding_box()
    assert slider["y"] + slider["height"] < 844


@pytest.mark.parametrize(("view", "words"), [("ball", "#lead"), ("oscillator", "#summary")])
def test_with_all_controls_the_word_stays_in_sight(opened, view, words):
    shown = opened(view, (1280, 720))
    shown.page.keyboard.press("p")
    shown.page.click("#more")
    shown.until(f"() => /[01]{{3}}/.test(document.querySelector('{words}').innerText)")
    box = shown.page.locator(words).bounding_box()
    assert box["height"] > 20 and box["y"] > 70 and box["y"] + 30 < 720


#: How wide and how high the cobweb is between its axes, in CSS pixels, and where that ends.
WEB = """() => {
  const { axes } = explorer.views.gap.cobweb, { left, top } = axes.canvas.getBoundingClientRect();
  const { x, y, w, h } = axes.box;
  return [w, h, x + w, y + h].map((each, i) => each * axes.zoom + [0, 0, left, top][i]);
}"""
ASKED = (
    "&note=Let mu rise until the orbit of period 3 ends, and fall until it doubles. What does the point do at each end?"
)


@pytest.mark.parametrize("more", [ASKED, "", "&tour=7", "&tour=7&answer=3"], ids=["exercise", "plain", "asked", "told"])
def test_on_a_phone_before_a_room_the_cobweb_is_as_wide_as_the_screen(phone, address, more):
    phone.open(f"{address}#version=2&view=gap&lam=0.5&l=0.1&span=0.01:0.3&mu=0.15&x0=0.1&web=3&columns=60{more}")
    phone.page.keyboard.press("p")
    phone.until("() => document.getElementById('stage').checkVisibility()")
    width, height, right, bottom = phone.page.evaluate(WEB)
    assert min(width, height) > 280 and right <= 390
    slider = phone.page.locator(".control.turned").bounding_box()
    step = phone.page.locator("#web-step").bounding_box()
    assert bottom < step["y"] and step["y"] + step["height"] <= slider["y"]
    words = phone.page.locator("#guide" if "tour" in more else "#note" if more else "#gap-diagram").bounding_box()
    assert words["height"] > 60 and words["y"] + words["height"] < bottom - height
    phone.page.tap("#web-none")
    phone.until("() => explorer.state().web === 0")
    assert phone.page.evaluate(WEB) == [width, height, right, bottom]


def test_on_a_phone_the_stairs_are_seen_while_a_slider_is_moved(phone, address):
    phone.open(f"{address}#version=2&view=gap&lam=0.5&l=0.1&span=-0.05:0.35&mu=0.15&web=3&columns=60")
    phone.page.locator(".control[data-name=mu] input[type=range]").scroll_into_view_if_needed()
    for far in (0, -150):
        phone.page.evaluate("(far) => scrollBy(0, far)", far)
        _, height, _, bottom = phone.page.evaluate(WEB)
        slider = phone.page.locator(".control[data-name=mu] input[type=range]").bounding_box()
        assert height > 250 and 0 < bottom - height and bottom < slider["y"] < 844
        at = phone.page.locator("#cobweb").bounding_box()
        seen = "([x, y]) => document.elementFromPoint(x, y).id"
        assert phone.page.evaluate(seen, [at["x"] + 200, bottom - height + 20]) == "cobweb"


@pytest.mark.parametrize(
    ("link", "picture"),
    [
        ("view=ball&V=0&r=0.7&offset=-0.5&note=The force hardly changes while the ball hops. How long?", "strip"),
        ("view=ball&omega=6&V=0&offset=-0.2&twin=yes&tour=9&answer=2", "strip"),
        ("view=chart&chart=basins&offset=0.1225&chart_columns=12&chart_rows=10&note=For which d do two live?", "chart"),
    ],
)
def test_with_all_controls_the_picture_is_no_ribbon(shown, address, link, picture):
    shown.page.set_viewport_size({"width": 1280, "height": 720})
    shown.open(f"{address}#version=2&columns=20&{link}")
    shown.page.keyboard.press("p")
    if "V=0&r" in link:  # an exercise has its portrait
        assert shown.page.locator("#phase").bounding_box()["height"] > 200
    shown.page.click("#more")
    assert shown.page.locator(f"#{picture}").bounding_box()["height"] > 240
    shown.page.click("#end")


def test_the_key_that_begins_again_is_first_the_cobwebs(shown, address):
    shown.open(f"{address}#version=2&view=gap&lam=0.5&l=0.1&span=-0.05:0.35&mu=0.15&x0=0.2&web=3&columns=20")
    whole = shown.page.evaluate("() => { const { axes } = explorer.views.gap.cobweb; return axes.x1; }")
    assert whole > 0.2  # the start is in the picture
    shown.page.keyboard.press("p")
    shown.page.focus(".control[data-name=mu] input[type=range]")
    shown.page.keyboard.press("ArrowRight")
    for key, web, zoomed in (("0", 0, True), ("0", 0, False)):
        shown.page.keyboard.press(key)
        shown.until(f"() => explorer.state().web === {web}")
        assert (shown.page.evaluate("() => explorer.state().span[0]") == -0.05) == zoomed
    shown.page.click("#end")


@pytest.mark.parametrize(("size", "exercise", "name"), [
    ((1280, 720), "Chatter", "r"), (PHONE, "Chatter", "r"), ((1280, 720), "The graze", "omega"),
])  # fmt: skip
def test_before_a_room_a_slider_is_seen_that_an_exercise_asks_for(opened, size, exercise, name):
    shown = opened("ball", size)
    shown.page.evaluate(FEW)
    shown.page.select_option("#preset", label=exercise)
    shown.until("() => document.getElementById('note').checkVisibility()")
    shown.page.keyboard.press("p")
    for each in (name, "offset"):
        seen = """(name) => {
          const slider = document.querySelector(`.control[data-name=${name}] input[type=range]`);
          const { x, y, width, height } = slider.getBoundingClientRect();
          return document.elementFromPoint(x + width / 2, y + height / 2) === slider;
        }"""
        assert shown.page.evaluate(seen, each), each
    assert shown.page.evaluate(COVERED) == [] or size == PHONE
    shown.page.click("#end")


def test_the_first_step_of_a_cobweb_stays_in_the_picture(shown, address):
    shown.open(f"{address}#version=2&view=gap&lam=0.5&l=0.1&span=-0.05:0.35&mu=0.15&x0=0.9&web=1&columns=20")
    low = shown.page.evaluate("() => explorer.views.gap.cobweb.axes.x0")
    assert low < 0.15 - 0.1 - 0.9**0.5


def test_on_a_phone_before_a_room_the_word_stays_beside_what_the_table_is_asked(phone, address):
    phone.page.goto(address.replace("index.html", "") + "table.html")
    ask = phone.page.evaluate("async () => (await import('./presets.js')).EXERCISES['The table'][0]")
    phone.page.evaluate("(ask) => { location.hash = `#table=classic&note=${encodeURIComponent(ask)}`; }", ask)
    phone.page.reload()
    phone.until("() => window.pinball?.exits()?.shares && document.getElementById('note').checkVisibility()")
    phone.page.keyboard.press("p")
    phone.page.evaluate("() => { pinball.plunge(0.8); for (let i = 0; i < 200; i++) pinball.step(1 / 60); }")
    box = phone.page.locator("#word").bounding_box()
    assert len(phone.page.inner_text("#word")) > 3 and box["y"] + box["height"] <= 844
    assert phone.page.locator("#table").bounding_box()["height"] > 180
    phone.page.keyboard.press("p")
