"""The tour with its questions, whose answers are held against the library, and notes that a link carries."""

import re
from pathlib import Path
from urllib.parse import quote, unquote

import numpy as np
import pytest

import grazing as gz
from tests.explorer.browser import FEW


@pytest.fixture
def kept():
    return True


@pytest.fixture(scope="module")
def tour(browser, address):
    page = browser.new_page()
    page.goto(f"{address}presets.js")  # any file of the same host
    yield page.evaluate("async () => (await import('./tour.js')).TOUR")
    page.close()


def asked(tour, title):
    return next(step["question"] for step in tour if step["title"] == title)


def right(tour, title):
    question = asked(tour, title)
    return question["choices"][question["right"]]


def map_of(step, **changes):
    known = {"alpha": 3, "k": 1, "omega": 2.2, "offset": 0.12, "r": 0.8, "V": 0.4} | step["state"] | changes
    own = {name: known[name] for name in ("alpha", "k", "omega", "r", "V")}
    return gz.stroboscopic_map(gz.pinball(d=known["offset"], **own))


def words(P, starts=24):
    return set(gz.lyapunov(P, "d", [P.params["d"]], starts=starts, seed=0).word.values.ravel().tolist())


# ---- what the tour calls right


def test_a_touch_makes_the_motion_jump_with_a_kick_and_grow_steeply_without(tour):
    assert right(tour, "The graze") == "At once by much"
    assert right(tour, "The jump") == "No: it grows from nothing, at first steeply"
    graze, depths = gz.normal_form(gz.pinball(), "d").graze, np.array([1e-7, 4e-7, 1.6e-6])
    spans = {}
    for V in (0.4, 0.0):
        P = gz.stroboscopic_map(gz.pinball(V=V))
        seen = gz.orbit_diagram(P, "d", graze - depths, starts=2, transient=600, keep=64, seed=0)
        u = seen.u.values.reshape(len(depths), -1)
        spans[V] = np.nanmax(u, axis=1) - np.nanmin(u, axis=1)
    assert (spans[0.4] > 0.09).all()
    assert (spans[0.0] < 0.01).all() and np.allclose(spans[0.0][1:] / spans[0.0][:-1], 2.0, rtol=0.35)  # a square root


def test_one_more_period_of_flight_is_added(tour):
    assert right(tour, "Adding") == "00001"
    step = next(each for each in tour if each["title"] == "Adding")
    seen = [words(map_of(step, offset=d)) for d in (0.09, 0.112, 0.1255, 0.129)]
    assert seen == [{"01"}, {"001"}, {"0001"}, {"00001"}]


def test_both_orbits_of_an_overlap_are_reached(tour):
    assert right(tour, "Overlap") == "Some on 3 and some on 4"
    step = next(each for each in tour if each["title"] == "Overlap")
    assert words(map_of(step), starts=120) == {"001", "0001"}


def test_a_ball_that_lives_on_jumps_later_on_each_way(tour):
    assert right(tour, "Hysteresis") == "No: later on each way"
    P, values = gz.stroboscopic_map(gz.pinball()), np.linspace(0.095, 0.107, 61)
    jump = {}
    for way in ("up", "down"):
        seen = gz.orbit_diagram(P, "d", values, starts=1, transient=200, keep=12, seed=0, sweep=way)
        two = np.array([len(set(np.round(each[np.isfinite(each)], 6))) == 2 for each in seen.u.values.reshape(61, -1)])
        jump[way] = values[two].max()
    assert jump["up"] - jump["down"] > 0.003


def test_windows_overlap_from_the_gap_that_is_told(tour):
    assert right(tour, "The gap") == "They grow, and overlap"
    assert f"l = {gz.theory.l_coexist(3, 0.5):.3g} on" in asked(tour, "The gap")["told"]


def test_the_exponent_that_is_told(tour):
    assert "about 0.4 a period" in asked(tour, "Chaos")["told"]
    step = next(each for each in tour if each["title"] == "Chaos")
    P = map_of(step)
    found = gz.lyapunov(P, "d", [P.params["d"]], starts=4, seed=1)
    assert np.abs(found.exponent.values[..., 0] - 0.4).max() < 0.05
    assert np.log(10.0) / 0.4 == pytest.approx(6.0, abs=0.5)  # periods for which a digit more helps


def test_hits_without_end_come_to_rest(tour):
    assert right(tour, "Chatter") == "Yes, after a finite time"
    step = next(each for each in tour if each["title"] == "Chatter")
    assert words(map_of(step)) == {"C"}


def test_a_single_step_next_to_the_graze_is_as_steep_as_one_likes(tour):
    assert right(tour, "Cobweb") == "As large as you like"
    state = next(each for each in tour if each["title"] == "Cobweb")["state"]
    G = gz.gap_map(lam=state["lam"], l=state["l"], mu=state["mu"])
    x = np.array([1e-4, 1e-8, 1e-12])
    slopes = [(G((a * (1 + 1e-6),))[0] - G((a,))[0]) / (1e-6 * a) for a in x]
    assert np.allclose(np.ravel(slopes), -0.5 / np.sqrt(x), rtol=1e-3)


def test_exercises_begin_where_they_say(browser, address, described):
    text = (Path(__file__).parents[2] / "docs" / "exercises.md").read_text(encoding="utf-8")
    links = re.findall(r"^#version=2&.*$", text, re.MULTILINE)
    page = browser.new_page()
    page.goto(f"{address}presets.js")
    found = page.evaluate(
        "async ([links, all]) => { const { fromFragment, toFragment } = await import('./state.js'); "
        "const fields = Object.fromEntries(Object.values(all).flatMap(m => m.fields).map(f => [f.name, f])); "
        "return links.map(link => { const { state, problems } = fromFragment(link, fields); "
        "return [problems, toFragment(state).split('&').length]; }); }",
        [links, described],
    )
    page.close()
    assert len(links) == 6 and "\n#table=classic\n" in text
    for link, (problems, parts) in zip(links, found, strict=True):
        assert problems == [] and parts >= len(link.split("&")) - 1, link


# ---- the page

#: Where the pictures that are seen end, down the page.
ENDS = """() => [...document.querySelectorAll('.view canvas')].filter(c => c.offsetParent)
  .map(c => c.getBoundingClientRect().bottom + scrollY)"""


def test_every_question_is_answered_by_a_picture(shown, address, tour):
    shown.open(f"{address}#version=2&view=ball&offset=0.13&columns=20&bins=20")
    shown.page.evaluate(FEW)
    shown.page.click("#tour")
    shown.page.evaluate(
        "() => { const { diagram } = explorer.views.ball, { show } = diagram; explorer.computed = 0; "
        "diagram.show = (...given) => (explorer.computed++, show.apply(diagram, given)); }"
    )
    for n, step in enumerate(tour, 1):
        shown.until(f"() => explorer.state().tour === {n}")
        assert shown.page.inner_text("#guide-title") == f"{n} of {len(tour)}: {step['title']}"
        question = step.get("question")
        assert shown.page.is_visible("#question") == bool(question) and not shown.page.is_visible("#told")
        if question:
            chosen = 1 + (question["right"] + n) % len(question["choices"])
            before = shown.page.evaluate("() => explorer.computed")
            shown.page.click(f"#choices button:nth-child({chosen})")
            shown.until(f"() => explorer.state().answer === {chosen}")
            assert shown.page.inner_text("#told") == question["told"].replace("_", "")  # subscripts are set as such
            assert shown.page.inner_text("#choices .right") == f"✓ {question['choices'][question['right']]}"
            wrong = shown.page.query_selector("#choices .wrong")
            assert (wrong is None) == (chosen - 1 == question["right"])
            state = shown.page.evaluate("() => explorer.state()")
            assert {name: state[name] for name in question["shown"]} == question["shown"]
            if state["view"] == "ball" and not {"offset", "reach", "V"} & question["shown"].keys():
                assert shown.page.evaluate("() => explorer.computed") == before, step["title"]  # it is the same diagram
            if step["title"] == "Chatter":
                shown.page.fill("input[type=number][name=offset]", "-0.32")
                assert "d = −0.5 (now −0.32). Each hit" in shown.page.inner_text("#guide-text")
                shown.page.fill("input[type=number][name=offset]", "-0.5")
                assert "d = −0.5. Each hit" in shown.page.inner_text("#guide-text")
        assert shown.problem() == ""
        ends = shown.page.evaluate(ENDS)
        assert ends and max(ends) <= 800, (step["title"], ends)  # nobody scrolls to see the answer
        if n < len(tour):
            shown.page.click("#next")
    assert shown.page.is_disabled("#next") and shown.page.get_attribute("#guide-link", "href") == "table.html?tour"
    shown.page.click("#leave")
    shown.until("() => document.getElementById('guide').hidden && !location.hash.includes('tour')")


def test_an_answer_is_part_of_a_link_and_back_takes_it_back(shown, address):
    shown.open(f"{address}#version=2&view=gap&tour=8&columns=8&bins=8&lam=0.5")
    shown.page.click("#choices button")
    shown.until("() => location.hash.includes('answer=1')")
    assert shown.page.inner_text("#choices .wrong").startswith("✗ ")
    shown.page.go_back()
    shown.until("() => explorer.state().answer === 0")
    assert not shown.page.is_visible("#told") and shown.page.is_visible("#question")


@pytest.mark.parametrize(
    ("fragment", "said"),
    [
        ("view=gap&tour=8&answer=7", "answer=7; there are 2 answers"),
        ("view=gap&answer=1", "answer=1; nothing is asked"),
        ("view=gap&tour=5&answer=1", "tour=5 shows the view chart, not gap"),
        (f"view=gap&note={'a' * 281}", "the note has 281 characters, of 280 at most"),
    ],
)
def test_an_answer_to_nothing_is_explained(shown, address, fragment, said):
    shown.open(f"{address}#version=2&columns=8&bins=8&{fragment}")
    assert said in shown.problem()


def test_a_note_travels_with_the_link_as_plain_text(shown, address):
    note = '<img src=x onerror="explorer.hurt = 1"> & μ = 0.3; look: 100 %'
    shown.open(f"{address}#version=2&view=gap&columns=8&bins=8&note={quote(note)}")
    assert shown.page.inner_text("#note") == note and shown.page.query_selector("#note *") is None
    assert shown.page.evaluate("() => explorer.hurt") is None
    shown.page.fill("#write", "Compare ε & δ = 5 %")
    shown.until("() => document.getElementById('note').textContent === 'Compare ε & δ = 5 %'")
    again = shown.link()
    shown.page.goto("about:blank")
    shown.open(again)
    assert shown.page.inner_text("#note") == "Compare ε & δ = 5 %"
    shown.page.fill("#write", "")
    shown.until("() => document.getElementById('note').hidden")
    assert "note" not in shown.link()


def test_nothing_answers_a_question_before_the_reader(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=30&bins=40&offset=0.1225&tour=5")
    shown.until("() => document.getElementById('summary').textContent.includes('0001')")
    assert shown.page.inner_text("#summary") == ""
    shown.page.click("#choices button:nth-child(3)")
    shown.until("() => document.getElementById('summary').innerText.includes('%')")


def test_exercises_are_chosen_beside_the_figures(shown, address):
    text = (Path(__file__).parents[2] / "docs" / "exercises.md").read_text(encoding="utf-8")
    asked = dict(re.findall(r"^## \d\. (.+)\n\n```text\n(#.+)\n```", text, re.MULTILINE))
    answers = [
        " ".join(told.replace("*", "").split())
        for told in re.findall(r"<summary>Answer</summary>\n(.+?)</details>", text, re.DOTALL)
    ]
    shown.open(f"{address}#version=2&view=edges")
    listed = shown.page.eval_on_selector_all("#preset optgroup option", "all => all.map(o => [o.text, o.value])")
    assert {title: link.partition("&note=")[0] for title, link in listed} == asked
    words = " ".join(text.split())
    assert listed[-1][0] == "The table"
    told = shown.page.evaluate(
        "async () => Object.values((await import('./presets.js')).EXERCISES).map((each) => each[2])"
    )
    assert told == answers
    for title, link in listed:
        question = unquote(link.partition("&note=")[2])
        assert question in words.replace("*", "")
        if title in ("The graze", "Cobweb"):
            shown.page.select_option("#preset", link)
            shown.until("() => document.getElementById('note').checkVisibility()")
            assert shown.page.inner_text("#note") == f"{question}\nAnswer" and shown.problem() == ""
            shown.page.click("#note summary")
            assert shown.page.inner_text("#note p") == answers[[name for name, _ in listed].index(title)]
    shown.page.select_option("#preset", "3.2")
    shown.until("() => !document.getElementById('note').checkVisibility()")


def test_what_an_exercise_asks_does_not_stay_above_a_view_of_which_it_says_nothing(shown, address):
    shown.open(f"{address}#version=2&view=edges")
    shown.page.evaluate(FEW)
    shown.page.select_option("#preset", label="Coexistence and hysteresis")
    shown.until("() => document.getElementById('note').checkVisibility()")
    for view, stays in (("chart", True), ("ball", True), ("strobe", False)):
        shown.page.click(f"[data-view={view}]")
        shown.until(f"() => explorer.state().view === {view!r}")
        assert shown.page.is_visible("#note") == stays, view
        shown.link()
    shown.page.go_back()
    shown.until("() => explorer.state().view === 'ball' && document.getElementById('note').checkVisibility()")
    shown.open(f"{address}#version=2&view=ball&columns=20&note=Mine")  # what is one's own stays
    shown.page.click("[data-view=strobe]")
    shown.until("() => explorer.state().view === 'strobe' && document.getElementById('note').checkVisibility()")


def test_what_an_exercise_asks_takes_one_line_once_a_hand_has_acted(shown, address):
    shown.page.set_viewport_size({"width": 1280, "height": 720})
    shown.open(
        f"{address}#version=2&view=ball&columns=20&note={'How%20long%20is%20it%20until%20it%20lies%20still?%20' * 6}"
    )
    high = "() => document.getElementById('note').offsetHeight"
    shown.page.keyboard.press("p")
    whole = shown.page.evaluate(high)
    slider = shown.page.locator(".control.turned input[type=range]").bounding_box()
    shown.page.mouse.move(slider["x"] + 100, slider["y"] + 10)
    shown.page.mouse.down()
    shown.page.mouse.move(slider["x"] + 130, slider["y"] + 10)
    shown.until("() => explorer.state().offset !== 0.12")
    assert shown.page.evaluate(high) == whole > 100  # nothing moves under the hand
    shown.page.mouse.up()
    shown.until(f"() => ({high})() < 60")
    shown.page.click("#note")
    assert shown.page.evaluate(high) == whole
    shown.page.keyboard.press("p")
    shown.page.evaluate("() => { location.hash = location.hash.replace(/note=[^&]*/, 'note=Another'); }")
    shown.until("() => document.getElementById('note').className === '' && explorer.state().note === 'Another'")


@pytest.mark.parametrize("width", [390, 1280])
def test_the_answer_is_one_click_away_once_a_hand_has_acted(shown, address, width):
    shown.page.set_viewport_size({"width": width, "height": 720})
    shown.open(f"{address}#version=2&view=oscillator&columns=20&bins=8")
    shown.page.select_option("#preset", label="The graze")
    shown.until("() => document.getElementById('note').checkVisibility()")
    for present in (False, True):
        if present:
            shown.page.keyboard.press("p")
        shown.page.fill(".control.turned input[type=number]", "0.13" if present else "0.135")
        shown.page.keyboard.press("Enter")
        shown.until("() => document.getElementById('note').className === 'folded'")
        shown.page.evaluate("() => document.activeElement.blur()")
        for told in (True, False):
            shown.page.click("#note summary", timeout=3000)
            assert shown.page.is_visible("#note p") == told
