"""The table edited by hand: what is moved is hit where it is, overlaps nothing, and is the same in Python."""

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.table import distance
from tests.explorer.test_table_page import GAME, hits, hold, opened, play


@pytest.fixture
def kept():
    return True


def spot(page, name):
    """Return where a disc is on the screen."""
    return page.evaluate(
        "name => { const {x, y} = pinball.game().things.find(one => one.name === name).shape;"
        " const box = document.getElementById('table').getBoundingClientRect(), at = pinball.drawing();"
        " return [box.left + at.x(x), box.top + at.y(y)]; }",
        name,
    )


def place(page, name):
    return page.evaluate(f"name => ['x', 'y'].map(k => {GAME}.value(`${{name}}.${{k}}`))", name)


def drag(page, name, dx, dy):
    x, y = spot(page, name)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx, y + dy, steps=6)
    page.mouse.up()


def test_a_bumper_is_dragged_and_hit_where_it_stands_as_in_python(shown, address):
    page = opened(shown, address)
    before = place(page, "bumper3")
    page.click("#edit")
    drag(page, "bumper3", -40, 30)
    after = place(page, "bumper3")
    assert after[0] < before[0] - 0.1 and after[1] < before[1] - 0.1
    assert page.evaluate("() => pinball.edit().on")
    assert page.inner_text("#said").startswith("C: ")  # the letter that stands on it
    page.evaluate("() => pinball.launch([2.5, 6.0, 3.0, 9.0])")
    assert not page.evaluate("() => pinball.edit().on")
    hold(page)
    play(page, 6.0)
    there = hits(page)
    assert len(there) > 5
    page.click("[data-copy=python]")
    program = page.evaluate("() => navigator.clipboard.readText()")
    assert f'"bumper3.x": {after[0]}' in program
    known = {}
    exec(program.replace("print(", "(").replace("gz.plot.table(T, flown)", ""), known)
    found = known["flown"].impact_wall.values.tolist()[: len(there)]
    assert found == there
    page.click("[data-copy=link]")
    link = page.evaluate("() => navigator.clipboard.readText()")
    page.goto("about:blank")
    opened(shown, address, link[link.index("#") :])
    assert place(page, "bumper3") == after


def test_a_link_keeps_what_was_moved_and_what_was_turned(shown, address):
    page = opened(shown, address, "#v=1&table=classic&bumper1.x=1.6&bumper1.y=6.5&bumper1.V=3")
    assert shown.problem() == "" and place(page, "bumper1") == [1.6, 6.5]
    page.click("#edit")
    drag(page, "bumper1", 0, 0)
    label = page.locator("#controls label", has_text="Kick")
    assert "of A" in label.inner_text() and "3.00" in label.inner_text()


@pytest.mark.parametrize(
    ("fragment", "said"),
    [
        ("#v=1&table=classic&bumper1.x=3.4&bumper1.y=7.0", "a bumper overlaps something"),
        ("#v=1&table=classic&bumper1.y=-90", "a bumper overlaps something"),
        ("#v=1&table=classic&left_wall.x1=1", "left_wall.x1 cannot be changed on this page"),
        ("#v=1&table=classic&rho=0.5", "rho cannot be changed on this page"),
        ("#v=1&table=classic&bumper1.radius=2", "bumper1.radius cannot be changed on this page"),
    ],
)
def test_what_cannot_be_is_explained_and_not_shown(shown, address, fragment, said):
    page = opened(shown, address, fragment)
    assert said in shown.problem()
    assert page.evaluate(f"() => Object.keys({GAME}.changes).length") == 0


def test_bumpers_stay_where_python_would_have_them(shown, address):
    """Wherever a hand drags them, no two objects overlap, and the table of Python is made of the same numbers."""
    page = opened(shown, address)
    page.click("#edit")
    rng = np.random.default_rng(11)
    page.evaluate(
        "moves => { const edit = pinball.edit(); for (const [j, x, y] of moves) {"
        " edit.choose(edit.discs[j]); edit.move(x, y); } }",
        [[int(rng.integers(5)), float(rng.uniform(-1, 6.5)), float(rng.uniform(-1, 11.5))] for _ in range(400)],
    )
    changes = page.evaluate(f"() => {GAME}.changes")
    assert len(changes) >= 8
    T = gz.read_table("classic").replace(**changes)  # which refuses what overlaps
    discs = [one for one in T.objects if one.kind == "disc"]
    for one in discs:
        x, y, radius = one.shape["x"], one.shape["y"], one.shape["radius"]
        least = min(distance(other, x, y) for other in T.objects if other is not one and other.kind != "flipper")
        assert least >= radius * (1 - 1e-12)


def test_a_bumper_is_chosen_and_moved_by_key(shown, address):
    page = opened(shown, address)
    before = place(page, "bumper1")
    page.click("#edit")
    page.focus("#table")
    page.keyboard.press("]")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowRight")
    after = place(page, "bumper1")
    assert after[0] > before[0] and after[1] > before[1]
    page.keyboard.press("[")
    assert page.evaluate("() => pinball.edit().chosen === pinball.edit().discs.at(-1)")
    assert not page.evaluate(f"() => {GAME}.alive")
