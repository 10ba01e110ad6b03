"""The page of the pinball table, played: keys, thumbs, words, near balls, exits, links and programs."""

import re
from itertools import pairwise

import numpy as np
import pytest

import grazing as gz
from grazing.billiard.distance import distance
from grazing.explorer.table import described_tables
from tests.explorer.browser import COARSE, LOADED, NEEDS_AXE

GAME = "pinball.game()"
#: Whether all exits of the table that is shown are found.
FOUND = "() => pinball.exits().side >= 40 && pinball.exits().left === 0"


@pytest.fixture
def kept():
    return True


def opened(shown, address, fragment="#v=1&table=classic"):
    shown.go(address.replace("index.html", "") + "table.html" + fragment)
    shown.until("() => Boolean(window.pinball && pinball.game() && pinball.exits())")
    return shown.page


def hits(page):
    return page.evaluate(f"() => {GAME}.hits.map(h => {GAME}.names[h.owner])")


def play(page, seconds, fine=1 / 60):
    """Let the clock of the game run, as frames would."""
    page.evaluate(
        f"([s, d]) => {{ for (let i = 0; i < s / d && {GAME}.alive; i++) pinball.step(d); }}", [seconds, fine]
    )


def hold(page):
    """Stop the page's own clock: then tests move it."""
    page.evaluate("() => pinball.pause()")


def launch(page, state):
    """Launch a ball that only the test moves: not a frame of the page's own clock comes between."""
    page.evaluate("state => { pinball.launch(state); pinball.pause(); }", state)


def test_a_ball_is_launched_by_the_space_bar_held(shown, address):
    page = opened(shown, address)
    assert not page.evaluate(f"() => {GAME}.alive")
    page.keyboard.down(" ")
    page.wait_for_timeout(300)
    page.keyboard.up(" ")
    shown.until(f"() => {GAME}.t > 0.05")
    speed = page.evaluate(f"() => {GAME}.start[3]")
    low, high = page.evaluate(f"() => {GAME}.table.speeds")
    assert low < speed <= high
    shown.until(f"() => {GAME}.hits.length > 0")


def test_a_game_by_keys_is_the_same_in_python_and_from_its_link(shown, address):
    page = opened(shown, address)
    launch(page, [2.5, 6.0, 3.0, 9.0])
    random = np.random.default_rng(4)
    for _ in range(120):
        key = ["ArrowLeft", "ArrowRight"][int(random.integers(2))]
        page.keyboard.down(key)
        play(page, 0.1)
        page.keyboard.up(key)
        play(page, float(random.uniform(0.02, 0.2)))
    there, pressed = hits(page), page.evaluate(f"() => {GAME}.presses")
    assert len(there) > 20 and all(pressed.values())
    page.click("[data-copy=python]")
    program = page.evaluate("() => navigator.clipboard.readText()")
    assert "read_table" in program and "gz.presses(" in program
    scope = {}
    exec(program.replace("gz.plot.table(T, flown)", "").replace("print(", "found = ("), scope)
    print(scope["flown"].outcome, scope["flown"].trust.item(), program[:300])
    flown, unsure = scope["flown"], page.evaluate(f"() => {GAME}.unsure")
    assert unsure == 0 and flown.impact_wall.values.tolist() == there
    end = page.evaluate(f"() => {GAME}.end")
    assert flown.exit.item() == end
    page.click("[data-copy=link]")
    link = page.evaluate("() => navigator.clipboard.readText()")
    page.goto("about:blank")
    page.goto(link)
    shown.until("() => window.pinball && pinball.game()?.t > 0")
    hold(page)
    play(page, 60.0, 0.05)  # other frames than before: the same game
    assert hits(page) == there


def test_a_game_with_nudges_is_the_same_in_python_and_from_its_link(shown, address):
    page = opened(shown, address)
    launch(page, [2.5, 6.0, 3.0, 9.0])
    random = np.random.default_rng(7)
    for i in range(60):
        page.keyboard.press(["ArrowLeft", "ArrowUp", "ArrowRight", "a", "d"][i % 5])
        play(page, float(random.uniform(0.3, 0.9)))
    there, nudges = hits(page), page.evaluate(f"() => {GAME}.nudges.map(n => n.t)")
    assert len(there) > 20 and len(nudges) > 3
    page.click("[data-copy=python]")
    program, scope = page.evaluate("() => navigator.clipboard.readText()"), {}
    exec(program.replace("gz.plot.table(T, flown[-1])", "").replace("print(", "found = ("), scope)
    assert page.evaluate(f"() => {GAME}.unsure") == 0
    assert scope["found"] == (there, page.evaluate(f"() => {GAME}.end"))
    page.click("[data-copy=link]")
    link = page.evaluate("() => navigator.clipboard.readText()")
    page.goto("about:blank")
    page.goto(link)
    shown.until("() => window.pinball && pinball.game()?.t > 0")
    hold(page)
    play(page, 60.0, 0.05)  # other frames than before: the same game
    assert hits(page) == there and page.evaluate(f"() => {GAME}.nudges.map(n => n.t)") == nudges


def test_a_nudge_moves_the_balls_in_the_air_and_too_many_tilt(shown, address):
    page = opened(shown, address)
    page.evaluate("() => pinball.launch([2.5, 6.0, 0.1, 3.0])")
    hold(page)
    page.evaluate("() => { pinball.split(); pinball.step(0.02); }")
    speeds = f"() => [{GAME}.place[3], {GAME}.places[3]]"
    before = page.evaluate(speeds)
    page.keyboard.press("ArrowUp")
    page.evaluate("() => pinball.step(1e-9)")
    after, size = page.evaluate(speeds), 0.1 * page.evaluate(f"() => {GAME}.table.from[2]")
    np.testing.assert_allclose(np.subtract(after, before), size, rtol=1e-6)
    page.keyboard.down("ArrowLeft")
    assert page.evaluate(f"() => {GAME}.presses.left_flipper.length") == 1
    for key in "ad":
        page.evaluate("() => pinball.step(0.02)")
        page.keyboard.press(key)
    assert "TILT" in page.inner_text("#said") and page.evaluate(f"() => {GAME}.tilted")
    assert page.evaluate(f"() => {GAME}.presses.left_flipper.length") == 2  # it fell
    page.keyboard.up("ArrowLeft")
    page.keyboard.down("ArrowRight")
    assert page.evaluate(f"() => {GAME}.presses.right_flipper.length") == 0
    page.evaluate("() => pinball.plunge(0.7)")
    assert not page.evaluate(f"() => {GAME}.tilted")


@LOADED
def test_a_ball_that_has_hit_nothing_yet_is_in_its_link_and_a_link_says_who_opens_it(shown, address):
    page = opened(shown, address)
    launch(page, [2.55, 5.6, -1.0, 2.4])
    play(page, 0.1)
    assert hits(page) == []
    page.click("[data-copy=link]")
    assert "start=2.55%2C5.6%2C-1%2C2.4" in page.evaluate("() => navigator.clipboard.readText()")
    shown.until("() => document.querySelector('#copied').textContent")
    said = page.inner_text("#copied")
    assert "--out site" in said and "page.html" not in said  # which has no table
    page.clock.install()
    page.click("[data-copy=python]")
    shown.until("() => document.querySelector('#copied').textContent === 'Copied.'")
    page.clock.run_for(6000)  # and goes, for it lies over a picture
    assert page.inner_text("#copied") == ""


def test_flippers_work_as_long_as_the_ball_flies(shown, address):
    page = opened(shown, address)
    launch(page, [2.5, 6.0, 3.0, 9.0])
    switches = page.evaluate(
        """() => { const game = pinball.game(); let n = 0;
        for (; n < 3000; n++) { if (!game.alive) pinball.launch([2.5, 6.0, 3.0 + 1e-3 * n, 9.0]); pinball.pause();
          for (let i = 0; i < 900 && game.alive; i++) {
            game.press(i % 2, (i >> 1) % 2 === 0);
            game.advance(game.t + 0.004);
          }
          if (game.presses.left_flipper.length > 400) break; }
        return game.presses.left_flipper; }"""
    )
    assert len(switches) > 400 and all(a < b for a, b in pairwise(switches))
    start, t = page.evaluate(f"() => [{GAME}.start, {GAME}.t]")
    T, presses = gz.read_table("classic"), page.evaluate(f"() => {GAME}.presses")
    flown = gz.trajectory(gz.table(T.objects, T.rho, T.g, T.tilt, gz.presses(**presses)), start, until=t)
    assert hits(page)[:30] == flown.impact_wall.values.tolist()[:30]
    assert page.evaluate(f"() => {GAME}.unsure") > 0 or hits(page) == flown.impact_wall.values.tolist()


def test_letters_are_typed_as_bumpers_are_hit(shown, address):
    page = opened(shown, address)
    launch(page, [2.5, 6.0, 3.0, 9.0])
    play(page, 8.0)
    assert page.evaluate("() => pinball.letters()") == list("ABCDE")
    names = dict(zip(["bumper1", "bumper2", "bumper3", "left_sling", "right_sling"], "ABCDE", strict=True))
    word = "".join(names.get(name, "") for name in hits(page))
    assert word and page.inner_text("#word") == word[-40:]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("bumper1", "Missed A by"),
        ("left_sling", "Missed D by"),
        ("left_flipper", "Missed the left flipper by"),
        ("left_guide", "Missed the left guide by"),
        ("dome", "Missed the dome by"),
    ],
)
def test_what_is_missed_by_a_hair_is_told(shown, address, name, said):
    """The ball flies past, 1 mm off at its nearest; the least distance is that of Python's formulas."""
    page = opened(shown, address)
    T = gz.read_table("classic")
    one, g = T.objects[T.names.index(name)], T.gravity
    x, y, vx, vy = past(one, T.rho, g)
    page.evaluate("state => { pinball.launch(state); pinball.pause(); }", [float(v) for v in (x, y, vx, vy)])
    told = []
    for _ in range(30):
        page.evaluate("() => pinball.step(0.002)")
        told.append(page.inner_text("#said"))
    assert page.evaluate(f"() => {GAME}.hits.length") == 0
    (text,) = {each for each in told if each.startswith(said)}
    t = np.linspace(0.0, 0.06, 60_001)
    angle = one.shape.get("rest", 0.0)
    far = min(distance(one, x + vx * s, y + (vy - 0.5 * g * s) * s, angle) for s in t) - T.rho
    assert abs(far - 0.01) < 1e-3
    assert re.search(rf"by {far / 0.01:.2g}\d* mm: ", text) or text.startswith(f"{said} {far / 0.01:.2} mm: ")
    jump = name in ("bumper1", "left_sling")
    assert ("here your future splits in two" in text) == jump


def past(one, rho, g, off=0.01, late=0.03, speed=6.0):
    """Return a state from which a ball comes within ``off`` of an object after some time, and not nearer."""
    shape = one.shape
    if one.kind == "disc":
        px, py, nx, ny = shape["x"], shape["y"] + shape["radius"], 0.0, 1.0
    elif one.kind == "flipper":
        nx, ny = np.cos(shape["rest"]), np.sin(shape["rest"])
        px, py = shape["x"] + (shape["length"] + shape["tip"]) * nx, shape["y"] + (shape["length"] + shape["tip"]) * ny
    elif one.kind == "arc":  # from below, at the top of a flight that is bent more than the arc
        px, py, nx, ny, speed = shape["x"], shape["y"] + shape["radius"], 0.0, -1.0, 1.0
    else:  # the end that stands higher
        (px, py), (qx, qy) = sorted(((shape["x1"], shape["y1"]), (shape["x2"], shape["y2"])), key=lambda p: -p[1])
        nx, ny = np.array([px - qx, py - qy]) / np.hypot(px - qx, py - qy)
    x, y, vx, vy = px + (rho + off) * nx, py + (rho + off) * ny, speed * ny, -speed * nx
    return x - vx * late, y - vy * late - 0.5 * g * late**2, vx, vy + g * late


def test_near_balls_part_and_their_rate_is_told(shown, address):
    page = opened(shown, address)
    page.evaluate("() => pinball.plunge(0.7)")
    hold(page)
    play(page, 0.6)
    page.click("#fan")
    assert page.evaluate(f"() => {GAME}.flying.length") == 100
    # Space is the key of the plunger again, and does not press the button once more
    assert page.evaluate("() => document.activeElement.id") == "table"
    page.evaluate("() => pinball.plunge(0.7)")
    play(page, 0.6)
    page.keyboard.press("g")
    assert page.evaluate(f"() => {GAME}.flying.length") == 100
    first = page.evaluate(f"() => {GAME}.spread")
    play(page, 3.0)
    assert page.evaluate(f"() => {GAME}.spread") > first + np.log(100.0)
    rate = re.search(r"tenfold every (\d+\.\d+) s", page.inner_text("#parted"))[1]
    assert 0.1 < float(rate) < 0.5
    play(page, 20.0)  # they are as far apart as the table is large: that is no rate
    assert f"tenfold every {rate} s, as long as" in page.inner_text("#parted")


def test_a_pixel_of_the_exits_is_a_ball_that_leaves_there(shown, address):
    page = opened(shown, address)
    shown.until(FOUND)
    box = page.locator("#exits").bounding_box()
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    shown.until(f"() => {GAME}.alive")
    hold(page)
    state = page.evaluate(f"() => {GAME}.start")
    play(page, 300.0, 0.1)
    flown = gz.trajectory(gz.read_table("classic"), state, until=300.0)
    assert page.evaluate(f"() => {GAME}.end") == (flown.exit.item() or "stopped")


def test_keys_of_the_table_work_from_the_picture_of_exits_and_from_a_slider(shown, address):
    page = opened(shown, address)
    shown.until(FOUND)
    box = page.locator("#exits").bounding_box()
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    hold(page)
    assert page.evaluate("() => document.activeElement.id") == "exits"
    page.keyboard.press("g")
    assert page.evaluate(f"() => {GAME}.ghosts.length > 0")
    page.keyboard.down("z")
    assert page.evaluate(f"() => {GAME}.presses.left_flipper.length") == 1
    page.keyboard.up("z")
    before = page.evaluate("() => pinball.exits().chosen")
    said = page.evaluate(  # at once: a near miss may be told next
        "() => { const key = new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true, cancelable: true });"
        " document.activeElement.dispatchEvent(key); return document.getElementById('said').textContent; }"
    )
    assert page.evaluate("() => pinball.exits().chosen") != before and "arrows choose a launch" in said
    assert page.evaluate(f"() => {GAME}.presses.right_flipper.length") == 0
    page.focus("input[name=tilt]")
    page.keyboard.press("g")
    assert page.evaluate(f"() => {GAME}.ghosts.length > 0")


def test_nothing_of_one_table_is_left_on_another(shown, address):
    page = opened(shown, address, "#v=1&table=three_discs")
    shown.until(FOUND)
    chosen = f"""(name) => {{
      [...document.querySelectorAll("#rungs button")].find((each) => each.textContent === name).click();
      const {{ axes }} = pinball.exits(), {{ x, y, w, h }} = axes.box;
      const [left, top, wide, high] = [x + 3, y + 3, w - 6, h - 6].map((each) => Math.round(each * axes.ratio));
      const colours = new Set(new Uint32Array(axes.context.getImageData(left, top, wide, high).data.buffer)).size;
      return [colours, document.getElementById("shares").textContent, {GAME}.table.params.length];
    }}"""
    assert page.inner_text("#shares")
    colours, legend, params = page.evaluate(chosen, "Galton board")
    assert (colours, legend) == (1, "")
    shown.until("() => document.getElementById('shares').textContent")
    _, legend, again = page.evaluate(chosen, "Galton board")  # the same once more
    assert legend and again == params


def test_shares_of_exits_are_those_of_python(shown, address):
    page = opened(shown, address)
    shown.until(FOUND)
    x, y, _ = page.evaluate(f"() => {GAME}.table.from")
    side = page.evaluate("() => pinball.exits().side")
    shares = page.evaluate("() => [...pinball.exits().shares]")
    T = gz.read_table("classic")
    low, high, slow, fast = page.evaluate("() => pinball.exits().home")
    found = gz.launches(T, (x, y), np.linspace(low, high, side), np.linspace(slow, fast, side), hits=1500)
    drains = [one.name for one in T.objects if one.kind == "drain"]
    truth = [float((found.exit == name).mean()) for name in drains]
    np.testing.assert_allclose(shares[:-1], truth, atol=3e-3)  # what doubles cannot decide, Python decides exactly


@LOADED
def test_a_share_that_is_not_nothing_is_not_told_as_nothing(shown, address):
    page = opened(shown, address)
    shown.until(FOUND)
    few = (
        "() => { const e = pinball.exits(); e.shares = [0.9997, 3e-4, ...e.names.slice(2).map(() => 0)]; e.counted(); }"
    )
    page.evaluate(few)
    assert re.findall(r"[\w .]+ %", page.inner_text("#shares"))[1].endswith("under 0.1 %")


#: How many colours fill the picture of exits, of those that are not a rarity.
GRAIN = """() => {
  const { axes } = pinball.exits(), { x, y, w, h } = axes.box;
  const ratio = axes.canvas.width / axes.canvas.clientWidth * axes.zoom;
  const [p, q] = [Math.floor(w * ratio), Math.floor(h * ratio)];
  const { data } = axes.canvas.getContext("2d").getImageData(Math.ceil(x * ratio), Math.ceil(y * ratio), p, q);
  const pixels = new Uint32Array(data.buffer), seen = new Map();
  for (const each of pixels) seen.set(each, (seen.get(each) ?? 0) + 1);
  return [...seen.values()].filter((n) => n > 0.01 * pixels.length).length;
}"""


@pytest.mark.parametrize("table", ["classic", "galton", "three_discs", "one_bumper"])
def test_exits_are_seen_to_part_and_are_zoomed(shown, address, table):
    page = opened(shown, address, f"#v=1&table={table}")
    shown.until(FOUND)
    assert page.evaluate(GRAIN) > 1  # of three discs it was one grey rectangle
    shares = page.evaluate("() => [...pinball.exits().shares]")
    assert sum(shares) == pytest.approx(1.0)
    if table == "three_discs":
        low, high, bottom, top = page.evaluate("() => pinball.exits().home")
        x, _, speed = page.evaluate(f"() => {GAME}.table.from")
        heights, T = np.linspace(bottom, top, 40), gz.read_table("three_discs")
        launched = [gz.launches(T, (x, y), np.linspace(low, high, 40), [speed], hits=1500) for y in heights]
        hits = np.concatenate([each.hits.values.ravel() for each in launched])
        np.testing.assert_allclose(shares, np.bincount(np.minimum(hits, 7), minlength=8) / 1600, atol=2e-3)
        assert "hit" in page.inner_text("#shares") and "goes away" not in page.inner_text("#shares")
    before = page.evaluate("() => { const a = pinball.exits().axes; return [a.x0, a.x1, a.y0, a.y1]; }")
    box = page.locator("#exits").bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.4 * box["height"])
    page.wait_for_timeout(200)  # a turn of the wheel goes on for 150 ms: no hand changes the table in that time
    page.mouse.wheel(0, -300)
    shown.until(f"() => pinball.exits().axes.x1 - pinball.exits().axes.x0 < {0.9 * (before[1] - before[0])}")
    page.focus("#exits")
    page.keyboard.press("0")
    assert page.evaluate("() => { const a = pinball.exits().axes; return [a.x0, a.x1, a.y0, a.y1]; }") == before


def test_pictures_are_as_before_when_the_room_has_gone(shown, address):
    page = opened(shown, address)
    page.set_viewport_size({"width": 1280, "height": 720})
    shown.until(FOUND)
    size = "() => ['spread', 'exits'].map((id) => document.getElementById(id).clientHeight)"
    before = page.evaluate(size)
    page.click("#present")
    page.wait_for_timeout(100)
    page.click("#end")
    assert page.evaluate(size) == before
    link = page.locator("[data-copy=link]").bounding_box()
    assert link["y"] + link["height"] <= 720


def test_a_slider_changes_the_bumpers(shown, address):
    page = opened(shown, address)
    slider = page.locator("input[name='*.V']")
    slider.focus()
    page.keyboard.press("End")
    kicks = page.evaluate(f"() => [1, 2, 3].map(i => {GAME}.value(`bumper${{i}}.V`))")
    assert kicks == [16.0] * 3
    assert page.evaluate(f"() => {GAME}.value('left_sling.V')") == 8.0
    tilt = page.locator("input[name=tilt]")
    tilt.focus()
    page.keyboard.press("End")
    T = gz.read_table("classic").replace(tilt=0.25)
    assert page.evaluate(f"() => {GAME}.block[{GAME}.layout.GRAVITY]") == T.gravity


def test_tables_are_what_python_has_though_they_are_sent_in_fewer_letters(shown, address):
    page = opened(shown, address)
    made = page.evaluate(
        "async () => { const { unpacked } = await import('./played.js'), { tables } ="
        " await (await fetch('../kernels/tables.json')).json();"
        " return Object.fromEntries(Object.entries(tables).map(([name, one]) => [name, unpacked(one)])); }"
    )
    assert made == described_tables()["tables"]


@pytest.mark.parametrize("name", ["Galton board", "Three discs", "One bumper"])
def test_every_table_plays(shown, address, name):
    page = opened(shown, address)
    page.click(f"#rungs button:text-is('{name}')")
    page.evaluate("() => pinball.plunge(0.5)")
    hold(page)
    play(page, 20.0)
    assert hits(page)
    assert page.locator("[data-press]:visible").count() == 0  # they have no flippers


@LOADED
@pytest.mark.parametrize("motion", ["no-preference"])
def test_a_ball_that_nobody_launched_is_said_to_show_the_table(shown, address):
    page = opened(shown, address, fragment="")
    shown.until("() => document.getElementById('said').textContent.startsWith('A ball to show the table')")
    page.keyboard.press(" ")
    shown.until("() => !document.getElementById('said').textContent.includes('show the table')")


def test_thumbs_on_a_telephone(browser, address):
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, reduced_motion="reduce")
    page = context.new_page()
    page.goto(address.replace("index.html", "") + "table.html")
    page.evaluate(COARSE)
    page.wait_for_function("() => window.pinball && pinball.game() && pinball.exits()")
    assert page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")
    box = page.locator("#table").bounding_box()
    assert box["y"] + box["height"] <= 844
    page.touchscreen.tap(box["x"] + 40, box["y"] + 200)
    page.wait_for_function(f"() => {GAME}.alive")
    page.touchscreen.tap(box["x"] + 40, box["y"] + 200)
    assert page.evaluate(f"() => {GAME}.presses.left_flipper.length") == 2
    # all that one plays with is on the screen with the table
    for button in ("#plunger", "#fan", "[data-press='0']", "[data-press='1']"):
        place = page.locator(button).bounding_box()
        assert box["y"] + box["height"] < place["y"] and place["y"] + place["height"] < 844
    page.locator("#plunger").tap()  # and is not held
    assert page.evaluate(f"() => Math.hypot(...{GAME}.start.slice(2)) > 0.7 * {GAME}.table.speeds[1]")
    assert "Hold Launch" in page.inner_text("#said")
    page.locator("#fan").tap()
    assert page.evaluate(f"() => {GAME}.ghosts.length > 100")
    curve = page.locator("#spread-figure").bounding_box()["y"]
    assert curve < page.locator("#exits-figure").bounding_box()["y"]
    page.goto(address.replace("index.html", "") + "table.html#table=classic&note=Split it")  # which asks for the curve
    page.wait_for_function("() => document.getElementById('note').checkVisibility()")
    curve = page.locator("#spread").bounding_box()
    assert curve["height"] > 100 and curve["y"] + curve["height"] < 844
    context.close()


@pytest.mark.parametrize(
    ("fragment", "said"),
    [
        ("#table=nothing", "there is no table nothing"),
        ("#table=classic&start=1,2", "start needs four numbers"),
        ("#table=classic&bumper1.V=-1", "0 or more"),
        ("#table=classic&start=1,2,3,4&left_flipper.pressed=2,1", "do not rise"),
        ("#table=classic&tilt=abc", "no numbers"),
        ("#table=classic&start=1,2,3,4&nudges=1,2,3", "five numbers each"),
        ("#table=classic&start=1,2,3,4&nudges=2,1,1,1,1,1,1,1,1,1", "do not rise"),
        ("#v=99&table=classic", "newer version"),
        ("#table=classic&g=+", "no numbers"),
        ("#table=classic&start=5.275,,0,17", "no numbers"),
        ("#table=classic&tilt=0.1&tilt=0.2", "tilt is given twice"),
        ("#table=classic&bumper1.v=3", "bumper1.v is no part of a link"),
    ],
)
def test_a_link_that_cannot_be_read_is_explained(shown, address, fragment, said):
    page = opened(shown, address, fragment)
    assert said in page.inner_text("#problem p")
    assert page.evaluate(f"() => {GAME}.table.objects.length") > 10  # and the machine is there


def test_a_link_with_a_ball_that_hits_too_often_does_not_keep_the_page(shown, address):
    """Gravity of 1e12 made some 50 million impacts a look, and the page never came to its next picture."""
    page = opened(shown, address, "#v=1&table=classic&start=5.275,0.7,0,17&g=1e12")
    shown.until("() => document.getElementById('said').textContent.startsWith('The ball hits too often')")
    assert page.evaluate(f"() => {GAME}.hits.length") < 100_100


@LOADED
def test_what_cannot_be_loaded_is_said(shown, address):
    shown.page.route("**/tables.json", lambda route: route.abort())
    shown.page.goto(address.replace("index.html", "") + "table.html")
    shown.until("() => !document.getElementById('problem').hidden")
    assert "could not be loaded" in shown.page.inner_text("#problem p")
    assert shown.page.locator("#rungs button:disabled").count() == 4  # of none there is a table to choose


@NEEDS_AXE
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280])
def test_axe_reports_no_violation(pages, address, scheme, width):
    size = {"width": width, "height": 800}
    with pages(True, viewport=size, color_scheme=scheme, reduced_motion="reduce") as shown:
        page = opened(shown, address, "#table=nothing")  # with a message
        shown.until(FOUND)
        page.evaluate("() => { pinball.plunge(0.7); pinball.split(); pinball.step(2); pinball.pause(); }")
        assert shown.violations() == []


def test_pictures_are_drawn_anew_where_they_alone_change_in_size(shown, address):
    """Before a room the page stays as large as the screen: a message of a line less left the exits stretched, and a
    click in them launched another ball."""
    page = opened(shown, address)
    page.click("#present")
    shown.until(FOUND)
    drawn = """() => ['spread', 'exits'].map(id => document.getElementById(id))
      .every(c => c.height === Math.round(c.clientHeight * devicePixelRatio))"""
    shown.until(drawn)
    height = "() => document.getElementById('exits').clientHeight"
    before = page.evaluate(height)
    page.evaluate("() => { document.getElementById('lead').style.paddingBottom = '40px'; }")
    try:
        shown.until(drawn)
        assert page.evaluate(height) < before
    finally:
        page.evaluate("() => { document.getElementById('lead').style.paddingBottom = ''; }")
        page.click("#end")
