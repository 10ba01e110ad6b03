"""What the page does at the ends of what it can: narrow axes, long computations, parameters a law does not have."""

import time

import pytest

from tests.explorer.browser import FEW, LOADED


@pytest.fixture
def kept():
    return True


def state(page, key):
    return page.page.evaluate(f"() => explorer.state().{key}")


def texts(page, ticks):
    """The texts of an axis from plot.js."""
    return page.page.evaluate(
        "async ([low, high, about]) => { const { scaled } = await import('./plot.js');"
        " const s = scaled(low, high, about); return [s.ticks.map(t => t.text), s.base, s.power]; }",
        list(ticks),
    )


# ---- narrow axes


def test_an_axis_too_narrow_for_double_precision_is_refused(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=20&bins=20&span=0.3:0.30000000000000004")
    assert "span=0.3:0.30000000000000004 is too narrow for double precision" in shown.problem()
    assert state(shown, "span") == [-0.1, 0.6]


@pytest.mark.parametrize("mu", [5000, 0])
def test_zooming_in_ends_where_double_precision_does(shown, address, mu):
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8&mu={mu}&span={mu - 1}:{mu + 1}")
    shown.page.focus("#gap-diagram")
    for _ in range(50):
        shown.page.keyboard.press("+")
        shown.page.evaluate("() => new Promise(requestAnimationFrame)")
    low, high = state(shown, "span")
    assert max(1e-12, 0.9e-10 * mu) <= high - low < max(1e-10, 1e-9 * mu) and low <= mu <= high
    shown.until("() => location.hash.includes(`span=${explorer.state().span.join(':')}`)")
    shown.page.reload()  # and its own link is taken
    shown.settle()
    assert (shown.problem(), state(shown, "span")) == ("", [low, high])


def test_the_numbers_of_an_axis_are_short_and_different(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8")
    assert texts(shown, (0.1, 0.5, 4)) == [["0.1", "0.2", "0.3", "0.4", "0.5"], 0, 0]
    assert texts(shown, (0.14, 0.14001, 5)) == [["0", "2", "4", "6", "8", "10"], 0.14, 6]
    assert texts(shown, (0.3, 0.30001, 3))[1:] == [0.3, 5]  # and not 0.29999
    for low, high in ((1, 1 + 1e-10), (0, 1e-12), (-5, -4.99999), (4999.9999999, 5000.0000001), (0, 3e8), (1e30, 2e30)):
        found, base, power = texts(shown, (low, high, 6))
        assert len(found) >= 4 and len(set(found)) == len(found)
        assert all(len(text) <= 7 for text in found)
        places = [base + float(text.replace("−", "-")) / 10.0**power for text in found]
        slack = 0.01 * (high - low)
        assert all(low - slack <= place <= high + slack for place in places)
    count = shown.page.evaluate("async () => (await import('./plot.js')).ticks(1e17, 1e17 + 16, 1e9).length")
    assert count <= 1000


# ---- long computations


def test_the_table_of_opacities_is_bounded(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8")
    found = shown.page.evaluate(
        "async () => { const { tonesOf } = await import('./diagram.js'); return [[2, 1e8], [600, 8000]].map("
        "([bins, total]) => { const { tones, scale } = tonesOf(bins, total); return [[...tones], scale]; }); }"
    )
    for (tones, _scale), entries in zip(found, (4100, 170), strict=True):
        assert len(tones) <= entries and tones[0] == 40 and tones[-1] == 255 and tones == sorted(tones)
    assert found[1][1] == 1  # where there are few counts each has a tone of its own


@LOADED
@pytest.mark.parametrize(
    ("heavy", "least"),  # the second has short jobs: it is enough to hold those that wait
    [
        ("view=gap&starts=1000&columns=4&bins=20&keep=100000", 1),
        ("view=chart&chart=oscillator&chart_columns=2000&chart_rows=2000", 0),
    ],
)
def test_a_view_that_is_left_gives_the_workers_back(shown, address, heavy, least):
    shown.page.goto(f"{address}#version=2&{heavy}")
    shown.until("() => globalThis.explorer?.views.gap && document.querySelector('canvas[data-stage]')")
    time.sleep(0.3)  # twice as long as a worker is given to finish a job that nobody waits for
    shown.page.evaluate(
        "location.hash = 'version=2&view=oscillator&columns=40&bins=40&flow_starts=2&flow_keep=20&reduced=no'"
    )
    shown.until("() => ['coarse', 'full', 'done'].includes(explorer.views.oscillator.diagram.stage)")
    shown.settle()  # the charts, which take hours, would not be over
    assert shown.page.evaluate("explorer.views.gap.diagram.pool.ended") >= least


#: The jobs that workers begin from when a search is asked, amid those of a diagram, until it is begun itself.
BEGUN = """() => new Promise((tell) => {
  let jobs;
  const send = Worker.prototype.postMessage, view = explorer.views.oscillator;
  const ask = () => {
    jobs = [];
    view.search.forget();
    view.show(explorer.state());
  };
  Worker.prototype.postMessage = function (message, ...more) {
    if (!jobs) setTimeout(ask);
    jobs?.push(message.job);
    if (jobs && message.job === "found") tell(jobs);
    jobs ??= [];
    return send.call(this, message, ...more);
  };
})"""


@LOADED
def test_what_a_click_asks_waits_for_no_diagram(shown, address):
    slow = "omega=0.2&offset=0.9&reach=0.5:1"
    shown.page.goto(f"{address}#version=2&view=oscillator&columns=2000&bins=40&reduced=no&{slow}")
    shown.until(
        "() => { const view = globalThis.explorer?.views.oscillator; "
        "return view?.diagram.stage === 'coarse' && !view.search.waiting; }"
    )
    assert shown.page.evaluate(BEGUN) == ["found"]


# ---- axes of a parameter


@pytest.mark.parametrize(
    ("fragment", "said", "reach"),
    [
        ("vary=omega&reach=-1:1", "reach=-1:1: omega = -1; allowed is omega > 0", [0.2, 6]),
        ("vary=r&reach=0:3", "reach=0:3: r = 3; allowed is r ≥ 0 and r ≤ 1", [0, 1]),
        ("second=r&heights=-1:1&vary=V&reach=0.1:0.2", "heights=-1:1: r = -1; allowed is r ≥ 0", [0.1, 0.2]),
        ("law=newton&vary=V", "vary=V; the law newton has no V", [0.05, 0.16]),
        ("law=active&vary=trigger", "vary=trigger; the law active has no trigger", [0.05, 0.16]),
        ("law=newton&second=V", "second=V; the law newton has no V", [0.05, 0.16]),
        ("t0=1e99", "t0=1e+99; allowed is |t0| ≤ 454545454545454.5 at omega = 2.2", [0.05, 0.16]),
        ("phase=-1e99", "phase=-1e+99; allowed is |phase| ≤ 454545454545454.5", [0.05, 0.16]),
        ("ball=0.1:0:1e300", "ball=0.1:0:1e+300; allowed is |time| ≤ 454545454545454.5", [0.05, 0.16]),
        ("vary=t0&reach=0:1e99", "reach=0:1e+99: allowed is |t0| ≤ 454545454545454.5", [0, 6]),
        ("vary=omega&t0=9&reach=1:1e99", "reach=1:1e+99: allowed is |t0| ≤ 1e-84", [0.2, 6]),
        ("sigma=1e300", "sigma = 1e+300; allowed is |sigma| ≤ 1e+100", [0.05, 0.16]),
        ("tour=3&view=ball", "tour=3 shows the view oscillator, not ball", [0.05, 0.16]),
    ],
)
def test_a_link_whose_parts_disagree_is_explained(shown, address, fragment, said, reach):
    view = "" if "view" in fragment else "&view=oscillator"
    shown.open(f"{address}#version=2{view}&columns=8&bins=8&{fragment}")
    assert said in shown.problem() and state(shown, "reach") == reach
    shown.page.click("#problem button")
    shown.until("() => document.getElementById('problem').hidden")
    assert shown.page.inner_text("#summary")


def test_zooming_out_stays_where_the_parameter_is(shown, address):
    link = f"{address}#version=2&view=oscillator&columns=8&bins=8&reduced=no&vary=r&reach=0:1&r=0.8"
    shown.open(link)
    shown.page.focus("#flow-diagram")
    for _ in range(3):
        shown.page.keyboard.press("-")
    shown.settle()
    assert state(shown, "reach") == [0, 1]
    box = shown.page.locator("#flow-diagram").bounding_box()
    shown.page.mouse.click(box["x"] + box["width"] - 2, box["y"] + 50)
    shown.settle()
    assert state(shown, "r") <= 1 and shown.problem() == ""
    shown.page.evaluate(
        "() => { const f = document.querySelector('[aria-label=\"r to\"]'); f.value = '2';"
        " f.dispatchEvent(new Event('change')); }"
    )
    assert "r = 2; allowed is r ≥ 0 and r ≤ 1" in shown.problem() and state(shown, "reach") == [0, 1]


def test_an_interval_is_cut_to_what_a_parameter_may_be(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8")
    cut = shown.page.evaluate(
        "async () => { const { allowed } = await import('./state.js'); const r = {low: 0, high: 1}, w = {low: 0,"
        " open_low: true}; return [allowed(r, [-1, 2]), allowed(r, [2, 3]), allowed(r, [-3, -2]), allowed(w, [-1, 1]),"
        " allowed(undefined, [-1, 1])]; }"
    )
    assert cut == [[0, 1], [0, 1], [0, 1], [0.002, 1], [-1, 1]]


def test_a_link_of_any_length_is_read_at_once(shown, address):
    """700,000 parts that cannot be read took a quarter of a minute, and were shown, each of them."""
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8")
    said = shown.page.evaluate(
        "async () => { const { fromFragment } = await import('./state.js');"
        " const links = ['%&'.repeat(7e5), 'version=2&lam=' + '9'.repeat(2e6), 'version=2&' + 'a%&b=1&'.repeat(900)];"
        " return links.map(link => fromFragment(link, {}).problems.join('; ')); }"
    )
    assert said[:2] == ["it has 1400000 characters, of 10000 at most", "it has 2000014 characters, of 10000 at most"]
    assert said[2].endswith("; 893 more") and len(said[2]) < 300
    shown.page.evaluate(f"location.hash = 'version=2&view=gap&columns=8&bins=8&lam={'9' * 20_000}'")
    shown.until("() => !document.getElementById('problem').hidden")
    assert shown.problem().startswith("Parts of the link could not be used: it has 20") and state(shown, "lam") == 0.8


def test_the_law_takes_its_parameters_with_it(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=8&bins=8&reduced=no&vary=V&reach=0.1:0.5")
    law = shown.page.locator("label:has-text('bumper') + select")
    law.select_option("newton")
    shown.settle()
    assert (state(shown, "vary"), state(shown, "reach"), state(shown, "second")) == ("offset", [0.05, 0.16], "r")
    assert not shown.page.is_visible("input[name=V]")
    offered = "() => [...document.querySelectorAll('select')].find(s => s.value === 'offset').selectedOptions[0]"
    options = f"{offered[6:]}.parentElement"
    values = f"() => [...{options}.options].filter(o => !o.disabled).map(o => o.value)"
    assert not {"V", "trigger"} & set(shown.page.evaluate(values))
    known = {}
    exec(shown.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), known)
    law.select_option("triggered")
    shown.settle()
    assert shown.page.is_visible("input[name=V]") and {"V", "trigger"} <= set(shown.page.evaluate(values))
    assert shown.problem() == ""


def test_a_link_that_comes_while_the_address_is_written_is_followed(shown, address):
    """The page writes its state to the address some time after a picture: also between a new link and its event."""
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8")
    shown.page.evaluate(
        "() => { const old = location.hash; location.hash = 'version=2&view=chart&chart_columns=4&chart_rows=4';"
        " history.replaceState(null, '', old); }"
    )
    shown.until("() => explorer.state().view === 'chart'")
    assert "view=chart" in shown.link()


def test_a_new_axis_is_seen_whole(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8")
    shown.page.evaluate("location.hash = 'version=2&view=chart&chart_columns=4&chart_rows=4'")
    shown.until("() => explorer.state().view === 'chart'")
    shown.page.select_option("label:has-text('chart of') + select", "oscillator")
    shown.until("() => explorer.state().chart === 'oscillator'")
    assert not shown.page.is_visible("#all")


# ---- what is said


def test_names_that_every_object_has_are_no_part_of_a_link(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8&constructor=2&toString=3&__proto__=1")
    said = "constructor is no part of a link; toString is no part of a link; __proto__ is no part of a link"
    assert said in shown.problem()


def test_numbers_beyond_double_precision_and_on_the_way_to_them(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8&lam=1e309")
    assert "lam is too large; numbers of double precision end at ±1.8e308" in shown.problem()
    shown.page.click("#problem button")
    field = shown.page.locator("input[type=number][name=lam]")
    field.fill("")
    before = state(shown, "lam")
    field.press_sequentially("0.5e30")
    shown.page.wait_for_timeout(700)
    assert state(shown, "lam") == before
    field.press("Enter")
    shown.until("() => explorer.state().lam === 5e29")
    field.fill("")
    field.press_sequentially("1e309")
    shown.until("() => document.querySelector('#problem p').textContent.includes('double precision end at ±1.8e308')")
    assert state(shown, "lam") == 5e29


def test_a_number_that_is_typed_acts_when_it_is_whole(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8&lam=0.5")
    shown.page.evaluate("""() => {
      const { gap } = explorer.views, show = gap.show.bind(gap);
      globalThis.lams = [];
      gap.show = (state) => (lams.push(state.lam), show(state));
    }""")
    field, seen = shown.page.locator("input[type=number][name=lam]"), "() => [...new Set(lams)]"
    field.fill("")
    field.press_sequentially("0.7")
    shown.until("() => explorer.state().lam === 0.7")  # after a pause
    field.press("Backspace")
    field.press("6")
    field.press("Enter")
    assert state(shown, "lam") == 0.6
    field.press("Backspace")
    field.press("8")
    field.blur()
    assert state(shown, "lam") == 0.8
    assert shown.page.evaluate(seen) == [0.7, 0.6, 0.8]
    field.press("ArrowUp")
    assert state(shown, "lam") not in (0.8, 0.6)


@LOADED
def test_what_cannot_be_shown_leaves_no_words_and_nothing_to_copy(shown, address):
    shown.open(f"{address}#version=2&view=edges&lam=0.5")
    assert shown.page.inner_text("#summary")
    shown.page.evaluate("""() => {
      const pen = explorer.views.edges.axes.context;
      globalThis.drawn = [];
      pen.fillText = (text) => drawn.push(text);
      pen.stroke = () => drawn.push("a line");
      location.hash = "version=2&view=edges&lam=1";
    }""")
    shown.until("() => explorer.state().lam === 1")
    assert "could not be made" in shown.problem() and shown.page.inner_text("#summary") == ""
    drawn = " ".join(shown.page.evaluate("drawn"))
    assert drawn.startswith("No picture: ") and "a line" not in drawn
    assert shown.page.get_attribute("#edges", "data-stage") == "failed"
    for kind in ("python", "command"):
        shown.page.click(f"[data-copy={kind}]")
        shown.until("() => document.getElementById('said').textContent.startsWith('there is no picture to copy')")
        shown.page.evaluate("() => document.getElementById('said').textContent = ''")


def test_fields_that_are_seen_have_names_of_their_own(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=8&bins=8&vary=V&reach=0.1:0.5")
    shown.page.evaluate("document.querySelectorAll('details').forEach(each => each.open = true)")
    names = (
        "() => [...document.querySelectorAll('#picture input[type=number]')].filter(e => e.offsetParent)"
        ".map(e => e.getAttribute('aria-label') ?? e.labels[0].textContent)"
    )
    seen = shown.page.evaluate(names)
    assert {"V from", "V to", "u from", "u to"} <= set(seen) and len(set(seen)) == len(seen)


# ---- the tour


def test_the_tour_keeps_the_focus_and_ends_with_its_view(shown, address):
    shown.open(f"{address}#version=2&view=ball&tour=10&columns=20")
    shown.page.evaluate(FEW)
    shown.page.focus("#next")
    shown.page.keyboard.press("Enter")
    shown.until("() => explorer.state().tour === 11 && document.activeElement.id === 'back'")
    shown.page.click("[data-view=ball]")
    shown.until("() => explorer.state().view === 'ball' && document.getElementById('guide').hidden")
    assert state(shown, "tour") == 0
    shown.page.click("#tour")
    shown.until("() => explorer.state().tour === 1")
    shown.page.focus("#leave")
    shown.page.keyboard.press("Enter")
    shown.until("() => document.activeElement.id === 'tour'")


def test_the_tour_says_the_graze_that_is_shown(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=8&bins=8&reduced=no")
    graze = shown.page.evaluate("() => explorer.views.oscillator.form.graze")
    step = shown.page.evaluate("async () => (await import('./tour.js')).TOUR[1]")
    assert f"d = k²a ≈ {graze:.5g}," in step["text"]
    (low, _high), begins = step["state"]["reach"], step["state"]["offset"]
    assert graze < low < graze + 1e-4 and begins > low + 5e-3  # the slider has room to fall, to a hair before it


def test_one_tick_alone_is_no_scale(shown, address):
    shown.page.goto(address)
    counts = shown.page.evaluate(
        "async () => { const { ticks } = await import('./plot.js'); return [[-0.4, 0.4, 1.6], [0.065, 0.095, 1], "
        "[0.05, 0.16, 2.2], [0.1309, 0.1311, 0]].map(each => ticks(...each).length); }"
    )
    assert min(counts) >= 2 and max(counts) <= 6
