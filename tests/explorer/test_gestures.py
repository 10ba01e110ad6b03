"""What hands do in the pictures, by mouse, finger and key: the state that follows, and that the picture shows it."""

import json

import numpy as np
import pytest

import grazing as gz

SMALL = "chart_columns=24&chart_rows=20&columns=60&bins=60&flow_starts=2&flow_transient=40&flow_keep=30"
#: Views whose pictures move: the fragment, the canvas, the parts of the state that change, and its axes.
PICTURES = {
    "gap": ("view=gap", "gap-diagram", ["span", "range"], "explorer.views.gap.diagram.axes"),
    "oscillator": ("view=oscillator", "flow-diagram", ["reach", "window"], "explorer.views.oscillator.diagram.axes"),
    "ball": ("view=ball", "ball-diagram", ["reach"], "explorer.views.ball.diagram.axes"),
    "edges": ("view=edges&lam=0.9&span=0:1&gaps=0.1:1", "edges", ["gaps", "span"], "explorer.views.edges.axes"),
    "chart": ("view=chart&gaps=0.1:0.6", "chart", ["span", "gaps"], "explorer.views.chart.axes"),
    "basins": ("view=chart&chart=basins&positions=0.1:0.5", "chart", ["positions", "velocities"],
               "explorer.views.chart.axes"),
    "strobe": ("view=strobe&omega=2.1&t0=2.2&offset=0.11&V=0.2", "strobe", ["line"], "explorer.views.strobe.axes"),
}  # fmt: skip


#: Heights that follow the orbits, and what of the state says where they do not.
FOLLOWED = {"gap": "range", "oscillator": "window", "ball": "window"}
#: For tests in which the ball must fly: in the others nothing moves by itself.
FLYING = pytest.mark.parametrize("motion", ["no-preference"])


@pytest.fixture
def kept():
    return True


def state(shown, key):
    return shown.page.evaluate(f"() => explorer.state().{key}")


def place(shown, canvas, x, y):
    """A share of a canvas across and down, in the window."""
    shown.page.locator(f"#{canvas}").scroll_into_view_if_needed()
    box = shown.page.locator(f"#{canvas}").bounding_box()
    return box["x"] + x * box["width"], box["y"] + y * box["height"]


def ends(shown, axes):
    return np.array(shown.page.evaluate(f"() => {{ const a = {axes}; return [[a.x0, a.x1], [a.y0, a.y1]]; }}"))


def touch(shown, kind, *points):
    given = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
    shown.fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": given})


def drag(shown, start, end, steps=5):
    shown.page.mouse.move(*start)
    shown.page.mouse.down()
    shown.page.mouse.move(*end, steps=steps)
    shown.page.mouse.up()


def at(shown, axes, x, y):
    """What stands on the axes at a place in the canvas."""
    return np.array(
        shown.page.evaluate(
            f"([x, y]) => {{ const a = {axes}, {{ left, top }} = a.canvas.getBoundingClientRect(); "
            "return [a.atX(x - left), a.atY(y - top)]; }",
            [x, y],
        )
    )


# ---- pictures that zoom and move


@pytest.mark.parametrize("scene", PICTURES)
def test_the_wheel_zooms_about_the_pointer_and_a_drag_moves(shown, address, scene):
    fragment, canvas, keys, axes = PICTURES[scene]
    shown.open(f"{address}#version=2&{SMALL}&{fragment}")
    before, picture = ends(shown, axes), shown.pixels(canvas)
    mouse = place(shown, canvas, 0.35, 0.4)  # beside the line of the parameter, which a drag would take
    held = at(shown, axes, *mouse)
    shown.page.mouse.move(*mouse)
    shown.page.mouse.wheel(0, -300)
    shown.until(f"() => {axes}.x1 - {axes}.x0 < {0.9 * np.ptp(before[0])}")
    shown.settle()
    near = ends(shown, axes)
    size = 2 ** (-300 * 0.002)
    follows = scene in FOLLOWED  # then the height is that of the orbits
    both = slice(0, len(keys) if not follows else 1)
    np.testing.assert_allclose((np.ptp(near, axis=1) / np.ptp(before, axis=1))[both], size, rtol=2e-3)
    np.testing.assert_allclose(
        at(shown, axes, *mouse)[both], held[both], atol=2e-3 * np.ptp(before, axis=1)[both].min()
    )
    assert shown.pixels(canvas) != picture and f"{keys[0]}=" in shown.link()
    assert not follows or state(shown, FOLLOWED[scene]) is None
    shown.page.wait_for_timeout(200)  # the turn of the wheel is over
    drag(shown, mouse, place(shown, canvas, 0.25, 0.5))
    shown.until(f"() => {axes}.x0 !== {near[0][0]}")
    shown.settle()
    moved = ends(shown, axes)
    np.testing.assert_allclose(np.ptp(moved, axis=1)[both], np.ptp(near, axis=1)[both], rtol=2e-3)  # moved, not zoomed
    there = at(shown, axes, *place(shown, canvas, 0.25, 0.5))
    np.testing.assert_allclose(there[both], held[both], atol=4e-3 * np.ptp(before, axis=1)[both].max())
    assert not follows or state(shown, FOLLOWED[scene]) is None
    if len(keys) == 1:
        return
    # at an axis, that axis alone
    shown.page.wait_for_timeout(200)
    shown.page.mouse.move(*place(shown, canvas, 0.01, 0.5))
    shown.page.mouse.wheel(0, -300)
    shown.until(f"() => {axes}.y1 - {axes}.y0 < {0.9 * np.ptp(moved[1])}")
    shown.settle()
    upright = ends(shown, axes)
    np.testing.assert_array_equal(upright[0], moved[0])
    np.testing.assert_allclose(np.ptp(upright[1]) / np.ptp(moved[1]), size, rtol=2e-3)
    shown.page.wait_for_timeout(200)
    x, y = place(shown, canvas, 0.5, 1.0)
    shown.page.mouse.move(x, y - 8)
    shown.page.mouse.wheel(0, -300)
    shown.until(f"() => {axes}.x1 - {axes}.x0 < {0.9 * np.ptp(upright[0])}")
    shown.settle()
    np.testing.assert_array_equal(ends(shown, axes)[1], upright[1])


@pytest.mark.parametrize("scene", ["gap", "ball", "basins"])
def test_fingers_that_part_zoom_in(phone, address, scene):
    fragment, canvas, _keys, axes = PICTURES[scene]
    phone.open(f"{address}#version=2&{SMALL}&{fragment}")
    x, y = place(phone, canvas, 0.55, 0.5)
    before, picture = ends(phone, axes), phone.pixels(canvas)
    scrolled = phone.page.evaluate("() => scrollY")
    touch(phone, "touchStart", (x - 30, y))
    touch(phone, "touchStart", (x - 30, y), (x + 30, y))
    for k in range(1, 7):
        touch(phone, "touchMove", (x - 30 - 5 * k, y), (x + 30 + 5 * k, y))
    touch(phone, "touchEnd")
    phone.until(f"() => {axes}.x1 - {axes}.x0 < {0.7 * np.ptp(before[0])}")
    phone.settle()
    after = ends(phone, axes)
    assert abs(np.ptp(after[0]) / np.ptp(before[0]) - 0.5) < 0.02  # the fingers are twice as far apart
    assert phone.pixels(canvas) != picture and phone.page.evaluate("() => scrollY") == scrolled
    touch(phone, "touchStart", (x - 60, y))
    touch(phone, "touchStart", (x - 60, y), (x + 60, y))
    for k in range(1, 7):
        touch(phone, "touchMove", (x - 60 + 5 * k, y), (x + 60 - 5 * k, y))
    touch(phone, "touchEnd")
    phone.until(f"() => {axes}.x1 - {axes}.x0 > {1.5 * np.ptp(after[0])}")  # and together, out again


def test_fingers_zoom_where_one_of_them_is_at_the_line(phone, address):
    fragment, canvas, _keys, axes = PICTURES["gap"]
    phone.open(f"{address}#version=2&{SMALL}&{fragment}")
    _x, y = place(phone, canvas, 0.5, 0.5)
    x = phone.page.evaluate(f"() => {axes}.canvas.getBoundingClientRect().left + {axes}.x(explorer.state().mu)")
    before, mu = ends(phone, axes), state(phone, "mu")
    touch(phone, "touchStart", (x, y))
    touch(phone, "touchStart", (x, y), (x - 60, y))
    for k in range(1, 7):
        touch(phone, "touchMove", (x + 5 * k, y), (x - 60 - 5 * k, y))
    touch(phone, "touchEnd")
    phone.until(f"() => {axes}.x1 - {axes}.x0 < {0.7 * np.ptp(before[0])}")
    phone.settle()
    assert abs(np.ptp(ends(phone, axes)[0]) / np.ptp(before[0]) - 0.5) < 0.02 and state(phone, "mu") == mu


def test_one_finger_scrolls_the_page_and_a_tap_picks(phone, address):
    phone.open(f"{address}#version=2&view=chart&chart_columns=20&chart_rows=20")
    phone.page.set_viewport_size({"width": 390, "height": 570})  # a picture that does not stick
    x, y = place(phone, "chart", 0.6, 0.5)
    before = state(phone, "span"), phone.page.evaluate("() => scrollY")
    touch(phone, "touchStart", (x, y))
    for k in range(1, 9):
        touch(phone, "touchMove", (x, y - 15 * k))
    touch(phone, "touchEnd")
    phone.until(f"() => scrollY > {before[1] + 40}")
    assert state(phone, "span") == before[0]
    phone.page.wait_for_timeout(600)  # until the page has come to rest
    phone.page.touchscreen.tap(*place(phone, "chart", 0.8, 0.3))
    phone.until("() => explorer.state().mu > 0.35")


@pytest.mark.parametrize("canvas", ["gap-diagram", "ball-diagram"])
def test_a_finger_drags_the_line(phone, address, canvas):
    view, name = canvas.partition("-")[0], {"gap-diagram": "mu", "ball-diagram": "offset"}[canvas]
    phone.open(f"{address}#version=2&view={view}&{SMALL}")
    axes = f"explorer.views.{view}.diagram.axes"
    _x, y = place(phone, canvas, 0.5, 0.5)
    x = phone.page.evaluate(f"() => {axes}.canvas.getBoundingClientRect().left + {axes}.x(explorer.state().{name})")
    before, whole = state(phone, name), ends(phone, axes)
    touch(phone, "touchStart", (x, y))
    for k in range(1, 9):
        touch(phone, "touchMove", (x - 6 * k, y))
    touch(phone, "touchEnd")
    phone.until(f"() => explorer.state().{name} < {before}")
    np.testing.assert_array_equal(ends(phone, axes)[0], whole[0])


def test_a_double_click_shows_all_and_picks_nothing(shown, address):
    shown.open(f"{address}#version=2&view=gap&{SMALL}&mu=0.2&span=0.1:0.4&range=-0.5:0.2")
    shown.page.mouse.dblclick(*place(shown, "gap-diagram", 0.8, 0.5))
    shown.until("() => explorer.state().span[0] === -0.1")
    assert state(shown, "mu") == 0.2 and state(shown, "range") is None  # the height follows the orbits
    shown.open(f"{address}#version=2&view=chart&chart=basins&{SMALL}&positions=0.1:0.4")
    shown.page.mouse.dblclick(*place(shown, "chart", 0.8, 0.5))
    shown.until("() => explorer.state().positions[0] === 0")
    assert state(shown, "ball") is None


def test_two_taps_show_all_and_pick_nothing(phone, address):
    phone.open(f"{address}#version=2&view=gap&{SMALL}&mu=0.2&span=0.1:0.4")
    at_once = place(phone, "gap-diagram", 0.8, 0.4)
    for _ in range(2):
        touch(phone, "touchStart", at_once)
        touch(phone, "touchEnd")
        phone.page.wait_for_timeout(60)
    phone.until("() => explorer.state().span[0] === -0.1")
    assert state(phone, "mu") == 0.2


def test_a_click_moves_nothing(shown, address):
    shown.open(f"{address}#version=2&view=gap&{SMALL}")
    x, y = place(shown, "gap-diagram", 0.7, 0.5)
    before = ends(shown, "explorer.views.gap.diagram.axes")
    drag(shown, (x, y), (x + 3, y + 2), steps=1)
    shown.until("() => explorer.state().mu > 0.35")
    np.testing.assert_array_equal(ends(shown, "explorer.views.gap.diagram.axes"), before)


# ---- the ball is slung


def preview(shown):
    return shown.page.evaluate(
        "() => { const { aim } = explorer.views.ball.sling; "
        "return aim && { u: aim.u, v: aim.v, at: [...aim.flight.times], path: aim.flight.u }; }"
    )


def in_python(u, v, times):
    flown = gz.trajectory(gz.pinball(d=0.12, V=0.4), (u, v), 0.0, float(times[-1]))
    return flown


@FLYING
@pytest.mark.parametrize("canvas", ["phase", "strip"])
def test_the_ball_is_slung_and_its_flight_foreseen(shown, address, canvas):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&V=0.4")
    quiet = shown.pixels(canvas)
    start, end = place(shown, canvas, 0.5, 0.4), place(shown, canvas, 0.5, 0.6)
    if canvas == "strip":
        shown.page.mouse.click(*start)
        assert state(shown, "ball") is None and preview(shown) is None  # a click throws nothing
    shown.page.mouse.move(*start)
    shown.page.mouse.down()
    shown.page.mouse.move(*end, steps=4)
    aimed, moved = preview(shown), shown.page.evaluate("() => explorer.views.ball.now")
    seen = shown.pixels(canvas)
    shown.page.wait_for_timeout(120)
    assert seen != quiet and shown.page.evaluate("() => explorer.views.ball.now") == moved  # it waits
    assert aimed["u"] > 0 and (aimed["v"] > 0.05 if canvas == "strip" else aimed["v"] < 0)
    shown.page.mouse.up()
    shown.until("() => explorer.state().ball !== null")
    u, v, time = state(shown, "ball")
    assert preview(shown) is None and time == 0
    np.testing.assert_allclose([u, v], [aimed["u"], aimed["v"]], atol=1e-3)
    assert "ball=" in shown.link()
    shown.page.click("#play")  # the ball need not fly while Python computes
    # what was foreseen is what the equations say
    P = gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4))
    T = 2 * np.pi / 2.2
    here = np.array([aimed["u"], aimed["v"]])
    for n in range(1, 4):
        here = np.asarray(P(here)[0])
        k = int(np.argmin(np.abs(np.array(aimed["at"]) - n * T)))
        assert abs(aimed["path"][k] - here[0]) < 0.01


@FLYING
@pytest.mark.parametrize("canvas", ["phase", "strip"])
def test_keys_aim_and_throw(shown, address, canvas):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&V=0.4")
    shown.page.focus(f"#{canvas}")
    shown.page.keyboard.press("ArrowUp")
    first = preview(shown)
    shown.page.keyboard.press("ArrowUp")
    shown.page.keyboard.press("ArrowRight")
    then = preview(shown)
    assert then["v"] > first["v"] and then["u"] > first["u"]
    shown.page.keyboard.press("Escape")
    assert preview(shown) is None and state(shown, "ball") is None
    shown.page.keyboard.press("ArrowRight")
    want = preview(shown)
    shown.page.keyboard.press("Enter")
    shown.until("() => explorer.state().ball !== null")
    assert abs(state(shown, "ball")[0] - want["u"]) < 1e-3


@FLYING
def test_a_finger_takes_the_ball_and_scrolls_elsewhere(phone, address):
    phone.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&V=0.4")
    phone.page.click("#play")  # it stands still
    box = phone.page.locator("#strip").bounding_box()
    x, y = phone.page.evaluate("() => explorer.views.ball.strip.ball")
    x, y = x + box["x"], y + box["y"]
    scrolled = phone.page.evaluate("() => scrollY")
    touch(phone, "touchStart", (x, y))
    for k in range(1, 9):
        touch(phone, "touchMove", (x, y + 8 * k))
    aimed = preview(phone)
    touch(phone, "touchEnd")
    phone.until("() => explorer.state().ball !== null")
    assert aimed["v"] > 0.05 and phone.page.evaluate("() => scrollY") == scrolled
    before = state(phone, "ball")
    touch(phone, "touchStart", (60, y))
    for k in range(1, 9):
        touch(phone, "touchMove", (60, y - 10 * k))
    touch(phone, "touchEnd")
    assert preview(phone) is None and state(phone, "ball") == before
    phone.page.tap("#sweeps")
    phone.page.evaluate("() => scrollTo(0, 0)")
    box = phone.page.locator("#ball-diagram").bounding_box()
    assert box["y"] + box["height"] < 844  # what the button did is seen


# ---- the cobweb


def follow(lam, mu, l, x, steps):
    found = [x]
    for _ in range(steps):
        found.append(lam * found[-1] + mu if found[-1] < 0 else mu - l - np.sqrt(found[-1]))
    return found


def test_a_cobweb_is_stepped_from_a_start_that_is_dragged(shown, address):
    shown.open(f"{address}#version=2&view=gap&{SMALL}&lam=0.8&l=1&mu=0.5")
    canvas = shown.page.evaluate("() => { const { box } = explorer.views.gap.cobweb.axes; return [box.w, box.h]; }")
    assert canvas[0] == canvas[1]  # slopes are seen as they are
    picture = shown.pixels("cobweb")
    drag(shown, place(shown, "cobweb", 0.5, 0.5), place(shown, "cobweb", 0.7, 0.5))
    x0 = state(shown, "x0")
    np.testing.assert_allclose(
        x0, at(shown, "explorer.views.gap.cobweb.axes", *place(shown, "cobweb", 0.7, 0.5))[0], atol=1e-3
    )
    assert state(shown, "web") == 1 and shown.pixels("cobweb") != picture
    for _ in range(5):
        shown.page.click("#web-step")
    shown.page.focus("#cobweb")
    shown.page.keyboard.press("s")
    shown.page.keyboard.press("Backspace")
    shown.until("() => explorer.state().web === 6")
    walked = shown.page.evaluate("() => explorer.views.gap.web().walk.map(([x]) => x)")
    np.testing.assert_allclose(walked, follow(0.8, 0.5, 1, x0, 6), atol=1e-12)
    word = "".join("L" if x < 0 else "R" for x in walked[:-1])
    assert f": {word}, now x =" in shown.page.inner_text("#summary")
    shown.page.keyboard.press("ArrowLeft")
    shown.until(f"() => explorer.state().x0 < {x0}")
    link = shown.link()
    assert "web=6" in link and "x0=" in link
    shown.page.click("#web-none")
    shown.until("() => explorer.state().web === 0")


def test_a_finger_drags_the_start_of_the_cobweb(phone, address):
    phone.open(f"{address}#version=2&view=gap&{SMALL}&lam=0.8&l=1&mu=0.5&web=3")
    axes = "explorer.views.gap.cobweb.axes"
    phone.page.locator("#cobweb").scroll_into_view_if_needed()
    x, y = phone.page.evaluate(
        f"() => {{ const a = {axes}, b = a.canvas.getBoundingClientRect(), x = explorer.state().x0; "
        "return [b.left + a.x(x), b.top + a.y(x)]; }"
    )
    touch(phone, "touchStart", (x, y))
    for k in range(1, 6):
        touch(phone, "touchMove", (x + 8 * k, y + 4 * k))
    touch(phone, "touchEnd")
    phone.until("() => explorer.state().x0 > 0.06")


# ---- sliders


def slider(shown, name):
    return shown.page.locator(f".control[data-name={name}] input[type=range]")


def test_fine_steps_by_key_and_by_dragging_up(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    knob = slider(shown, "offset")
    step = float(knob.get_attribute("step"))
    knob.focus()
    shown.page.keyboard.press("ArrowRight")
    shown.until(f"() => Math.abs(explorer.state().offset - {0.12 + 10 * step}) < 1e-9")
    shown.page.keyboard.press("Shift+ArrowRight")
    shown.until(f"() => Math.abs(explorer.state().offset - {0.12 + 11 * step}) < 1e-9")
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    knob.scroll_into_view_if_needed()
    box = knob.bounding_box()
    share = (0.12 - 0.05) / (0.16 - 0.05)
    x, y = box["x"] + 11 + share * (box["width"] - 22), box["y"] + box["height"] / 2
    shown.page.mouse.move(x, y)
    shown.page.mouse.down()
    begun = state(shown, "offset")
    shown.page.mouse.move(x, y - 25, steps=5)
    shown.until(f"() => Math.abs(explorer.state().offset - {begun + 25 * step}) < 11 * {step}")
    fine = state(shown, "offset")
    shown.page.mouse.move(x, y - 26)
    shown.until(f"() => Math.abs(explorer.state().offset - {fine + step}) < 1e-9")  # a pixel is a fine step
    shown.page.mouse.move(x + 120, y - 26, steps=4)
    shown.until("() => explorer.state().offset > 0.13")  # and across it goes as before
    shown.page.mouse.up()
    assert json.loads(knob.evaluate("e => e.value")) == state(shown, "offset")


def test_a_finger_moves_a_slider_and_goes_on_in_fine_steps(phone, address):
    phone.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    knob = slider(phone, "offset")
    knob.scroll_into_view_if_needed()
    box, step = knob.bounding_box(), float(knob.get_attribute("step"))
    x, y = box["x"] + 11 + (0.12 - 0.05) / (0.16 - 0.05) * (box["width"] - 22), box["y"] + box["height"] / 2
    touch(phone, "touchStart", (x, y))
    for k in range(1, 7):
        touch(phone, "touchMove", (x + 5 * k, y))
    phone.until("() => explorer.state().offset > 0.125")
    across = state(phone, "offset")
    for k in range(1, 13):
        touch(phone, "touchMove", (x + 30, y - k))
    phone.until(f"() => Math.abs(explorer.state().offset - {across + 12 * step}) < 1e-9")
    touch(phone, "touchEnd")
    assert abs(state(phone, "offset") - across - 12 * step) < 1e-9


@FLYING
def test_between_walls_the_ball_is_slung_and_a_wall_that_comes_down_takes_it_along(shown, address):
    shown.open(f"{address}#version=2&view=ball&two=yes&columns=20&bins=20")
    start, end = place(shown, "phase", 0.5, 0.4), place(shown, "phase", 1.0, 0.3)  # far into the upper wall
    shown.page.mouse.move(*start)
    shown.page.mouse.down()
    shown.page.mouse.move(*end, steps=4)
    aimed = preview(shown)
    shown.page.mouse.up()
    shown.until("() => explorer.state().ball !== null")
    u, _v, time = state(shown, "ball")
    assert u == 0.2 and time == 0
    height = shown.page.locator("[data-name=sigma_B] input[type=range]")
    height.focus()
    for _ in range(12):
        height.press("ArrowLeft")
    shown.until("() => explorer.state().sigma_B < 0.2")
    assert state(shown, "ball")[0] <= state(shown, "sigma_B") and shown.problem() == ""
    assert shown.page.evaluate("() => explorer.views.ball.place[0]") <= state(shown, "sigma_B")
    quiet = shown.pixels("strip")
    shown.page.click("text=a second wall, above the ball")
    shown.until("() => !explorer.state().two")
    assert shown.pixels("strip") != quiet and "two" not in shown.link()
    shown.page.click("#play")  # the ball need not fly while Python computes
    model = gz.Oscillator(3.0, 1.0, forcing=gz.Forcing(2.2, 0.0, 0.12, (1.0,)), walls=[
        gz.wall(0.0, gz.active(0.8, 0.4)), gz.wall(0.2, gz.active(0.8, 0.2), side="above")])  # fmt: skip
    at = np.array(aimed["at"])
    flown = gz.trajectory(model, (aimed["u"], aimed["v"]), 0.0, float(at[-1]), samples=20_000)
    np.testing.assert_allclose(aimed["path"], np.interp(at, flown["t"], flown["u"]), atol=2e-4)
    assert 0.0 <= min(aimed["path"]) and max(aimed["path"]) <= 0.2


@pytest.mark.parametrize(("canvas", "axes"), [("phase", "axes"), ("strip", "strip.axes")])
def test_the_wheel_zooms_the_portrait_and_the_turns_of_the_strip(shown, address, canvas, axes):
    shown.open(f"{address}#version=2&view=ball&columns=20&bins=20")
    shown.until("() => !explorer.views.ball.search.waiting")
    axes, ball = f"explorer.views.ball.{axes}", state(shown, "ball")
    before, (x, y) = ends(shown, axes), place(shown, canvas, 0.6, 0.4)
    under = at(shown, axes, x, y)
    shown.page.mouse.move(x, y)
    shown.page.mouse.wheel(0, -200)
    shown.until(f"() => {axes}.x1 - {axes}.x0 < {0.9 * np.diff(before[0])[0]}")
    if canvas == "phase":
        np.testing.assert_allclose(at(shown, axes, x, y), under, atol=1e-3)
        assert np.diff(ends(shown, axes)[1]) < 0.9 * np.diff(before[1])
    shown.page.focus(f"#{canvas}")
    shown.page.keyboard.press("0")
    np.testing.assert_allclose(ends(shown, axes), before)
    # a box with Shift is the part that is seen then: of the strip, so many turns
    corners = [place(shown, canvas, 0.3, 0.25), place(shown, canvas, 0.6, 0.6)]
    boxed = np.transpose([at(shown, axes, *corner) for corner in corners])
    shown.page.keyboard.down("Shift")
    drag(shown, *corners)
    shown.page.keyboard.up("Shift")
    after = ends(shown, axes)
    if canvas == "phase":
        np.testing.assert_allclose(after, np.sort(boxed), rtol=1e-6)
    else:
        assert abs(np.ptp(after[0]) - np.ptp(boxed[0])) < 0.02
    assert state(shown, "ball") == ball  # nothing was thrown


@pytest.mark.parametrize(("canvas", "axes"), [("phase", "axes"), ("strip", "strip.axes")])
def test_two_fingers_zoom_the_portrait_and_the_turns_of_the_strip(phone, address, canvas, axes):
    phone.open(f"{address}#version=2&view=ball&columns=20&bins=20")
    axes, ball = f"explorer.views.ball.{axes}", state(phone, "ball")
    (x, y), before = place(phone, canvas, 0.6, 0.4), ends(phone, axes)
    scrolled = phone.page.evaluate("() => scrollY")
    for first, sign, grown in ((30, 1, 0.5), (60, -1, 2)):
        was = np.ptp(ends(phone, axes)[0])
        touch(phone, "touchStart", (x - first, y))
        touch(phone, "touchStart", (x - first, y), (x + first, y))
        for k in range(1, 7):
            touch(phone, "touchMove", (x - first - sign * 5 * k, y), (x + first + sign * 5 * k, y))
        touch(phone, "touchEnd")
        is_there = f"Math.abs(({axes}.x1 - {axes}.x0) / {was} - {grown}) < 0.1"
        phone.until(f"() => {is_there}")
    # two that go on side by side move the portrait along
    touch(phone, "touchStart", (x - 60, y))
    touch(phone, "touchStart", (x - 60, y), (x, y))
    for k in range(1, 7):
        touch(phone, "touchMove", (x - 60 + 5 * k, y), (x + 5 * k, y))
    touch(phone, "touchEnd")
    if canvas == "phase":
        phone.until(f"() => {axes}.x0 < {before[0][0] - 0.05 * np.ptp(before[0])}")
    assert state(phone, "ball") == ball and not phone.page.evaluate("() => explorer.views.ball.sling.aim")
    assert phone.page.evaluate("() => scrollY") == scrolled
