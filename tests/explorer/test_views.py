"""What the views of the explorer show, beside the same from Python; that it can be saved, sent and reached."""

import importlib
import json
import re
from shlex import split
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import grazing as gz
from grazing.cli.app import main
from grazing.maps.discontinuity import zdm_points
from grazing.paper.run import Run
from tests.explorer.browser import Shown

SVG = "{http://www.w3.org/2000/svg}"
SHALLOW = "view=strobe&omega=2.1&t0=2.2&offset=0.11&V=0.2"
SCENES = {
    "gap": "view=gap&columns=200&bins=150",
    "edges": "view=edges&lam=0.9&span=0:1&l=0.7&mu=0.42",
    "oscillator": "view=oscillator&columns=60&bins=90",
    "ball": "view=ball&ball=0.3:-0.1:0.7&columns=60",
    "chart": "view=chart&chart_columns=40&chart_rows=30",
    "basins": "view=chart&chart=basins&offset=0.1225&chart_columns=24&chart_rows=20&ball=0.2:0.1:0",
    "strobe": SHALLOW,
}
#: Views that the keyboard zooms in both directions or one, the scene and the parts of the state that change.
ZOOMED = {
    "edges": ("edges", ["gaps", "span"]),
    "chart": ("chart", ["span", "gaps"]),
    "basins": ("chart", ["positions", "velocities"]),
    "strobe": ("strobe", ["line"]),
}


#: For tests that watch the ball fly: in the others nothing moves by itself.
FLYING = pytest.mark.parametrize("motion", ["no-preference"])


@pytest.fixture
def kept():
    return True


def known(page):
    """What the copied program computes; what it would draw to files is left out."""
    names = {}
    exec(page.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), names)
    return names


def state(page, key):
    return page.page.evaluate(f"() => explorer.state().{key}")


# ---- saved pictures


def saved(page, kind, folder):
    page.page.select_option("#times", "0")  # a bitmap as on the screen
    with page.page.expect_download() as download:
        page.page.click(f"[data-save={kind}]")
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


#: A page on its own canvas, in the browser: an image's pixels.
DRAWN = """async source => {
  const image = new Image();
  image.src = source;
  await image.decode();
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  canvas.getContext("2d").drawImage(image, 0, 0);
  return canvas.toDataURL();
}"""


def pixels_of(data):
    from base64 import b64decode
    from io import BytesIO

    return np.asarray(Image.open(BytesIO(b64decode(data.partition(",")[2]))).convert("RGB")).astype(int)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("scene", SCENES)
def test_a_picture_is_saved_whole_and_as_vectors(pages, address, tmp_path, scene, scheme):
    with pages(True, viewport={"width": 1280, "height": 800}, color_scheme=scheme, reduced_motion="reduce") as page:
        page.open(f"{address}#version=2&{SCENES[scene]}")
        if scene == "ball":
            page.page.click("#step")
        bitmap = np.asarray(Image.open(saved(page, "png", tmp_path)).convert("RGB")).astype(int)
        path = saved(page, "svg", tmp_path)
        sheets = page.page.evaluate(
            "() => [...document.querySelectorAll('main canvas')].filter(c => c.offsetParent).map(c => { "
            "const { left, top } = c.getBoundingClientRect(); return [left, top, c.toDataURL()]; })"
        )
        vectors = pixels_of(page.page.evaluate(DRAWN, f"data:image/svg+xml,{quoted(path.read_text(encoding='utf-8'))}"))
        link = page.link()
    # the bitmap holds every sheet that is seen, as it is seen
    assert len(sheets) == {"gap": 2, "oscillator": 2, "strobe": 2, "ball": 3}.get(scene, 1)
    left, top = (min(sheet[i] for sheet in sheets) for i in (0, 1))
    for x, y, data in sheets:
        seen = pixels_of(data)
        i, j = round(y - top), round(x - left)
        np.testing.assert_array_equal(bitmap[i : i + seen.shape[0], j : j + seen.shape[1]], seen)
    # the vectors give the same picture
    root = ElementTree.parse(path).getroot()
    assert root.tag == f"{SVG}svg" and root.find(f"{SVG}desc").text.endswith(link.partition("#")[2])
    assert len(root.findall(f".//{SVG}text")) > 8 and len(root.findall(f".//{SVG}path")) > 8
    assert len(root.findall(f".//{SVG}image")) == {"gap": 1, "oscillator": 2, "ball": 1, "chart": 1, "basins": 1}.get(
        scene, 0
    )
    assert vectors.shape == bitmap.shape
    differ = np.abs(vectors - bitmap).max(axis=2)
    assert (bitmap != bitmap[0, 0]).any(axis=2).mean() > 0.005
    for least, share in LIMITS.items():
        assert (differ > least).mean() < share


#: What share of the pixels may differ by more than so many of 255 steps; most measured: 0.0037, 0.000085 and 0.
LIMITS = {0: 0.01, 32: 2e-4, 96: 2e-5}


def quoted(text):
    from urllib.parse import quote

    return quote(text)


# ---- figures of the paper


def figure(number):
    return importlib.import_module(f"grazing.paper.figure_{number.rstrip('abc').replace('.', '_')}")


def ends(text):
    return tuple(float(word) for word in text.split(" to "))


@pytest.fixture(scope="module")
def run():
    return Run("small")


@pytest.fixture(scope="module")
def presets(browser, address):
    page = browser.new_page()
    page.goto(f"{address}presets.js")
    found = page.evaluate("async () => (await import('./presets.js')).PRESETS")
    page.close()
    return found


def opened(shown, address, preset, **smaller):
    """Show a preset by its link, with less to compute."""
    given = {**preset["state"], **smaller}
    words = [f"{key}={':'.join(map(str, value)) if isinstance(value, list) else value}" for key, value in given.items()]
    shown.open(f"{address}#version=2&{'&'.join(words)}")
    assert shown.problem() == ""


def test_every_figure_is_there(presets):
    from grazing.paper import FIGURES

    assert {number.rstrip("abc") for number in presets} == set(FIGURES)


@pytest.mark.parametrize("number", ["1.3", "1.6", "3.2", "3.3a", "3.3b", "3.3c", "3.5a", "3.5b", "3.5c", "3.7"])
def test_the_diagram_of_a_figure_is_that_of_python(shown, address, presets, number):
    given = dict(figure(number).PARAMETERS)
    view = presets[number]["state"]["view"]
    opened(shown, address, presets[number], columns=30, bins=80)
    told, counts = shown.raster(view)
    if view == "gap":
        gaps = [float(word) for word in str(given["l"]).split(",")]
        l = gaps["abc".index(number[-1])] if len(gaps) > 1 else gaps[0]
        P, name, coordinate, steps = (
            gz.gap_map(float(given["lambda"]), 0.1, l),
            "mu",
            "x",
            ("starts", "transient", "keep"),
        )
    else:
        model = gz.pinball(**{key: value for key, value in given.items() if key != "d"})
        P, name, coordinate = gz.stroboscopic_map(model), "d", "u"
        steps = ("flow_starts", "flow_transient", "flow_keep")
    starts, transient, keep = (state(shown, key) for key in steps)
    want = gz.density(
        P, name, np.linspace(*ends(given[name]), 30), bins=80, coordinate=coordinate, range=(told["low"], told["high"]),
        starts=starts, transient=transient, keep=keep, seed=0, arithmetic="strict",
    )  # fmt: skip
    sure = want["ambiguous"].values == 0  # elsewhere Python decides in ball arithmetic
    assert sure.mean() > 0.8 and counts[sure, 1:-2].sum() > 0.9 * counts[sure].sum() > 0
    np.testing.assert_array_equal(counts[sure, 1:-2], want["count"].values[sure])


@pytest.mark.parametrize("number", ["1.2", "1.5"])
def test_the_phase_portrait_of_a_figure(shown, address, presets, run, number):
    cycle, flight = (figure(number).compute(run)[key] for key in ("cycle", "flight"))
    opened(shown, address, presets[number], columns=20)
    seen = shown.page.evaluate(
        "() => { const b = explorer.views.ball; "
        "return [b.classes[0].period, b.classes[0].points, b.attractor.hits.map(h => [h.before, h.after])]; }"
    )
    assert seen[0] == cycle.period
    np.testing.assert_allclose(sorted(seen[1]), sorted(cycle.points.tolist()), atol=1e-9)
    np.testing.assert_allclose(np.array(seen[2]).T, [flight["v_minus"], flight["v_plus"]], atol=1e-9)


def test_the_zero_time_map_of_figure_2_1(shown, address, presets, run):
    four = figure("2.1").compute(run)["points"]
    opened(shown, address, presets["2.1"])
    seen = shown.page.evaluate("() => explorer.views.strobe.four")
    np.testing.assert_allclose(seen["points"], four.points, rtol=4e-15, atol=1e-17)
    np.testing.assert_allclose([seen["delta"], seen["acceleration"]], [four.delta, four.acceleration], rtol=4e-15)
    assert all(name in shown.page.inner_text("#summary") for name in ("(U₀, V₀) = (0.03, −0.23)", "(U₃, V₃) ="))


def test_the_zero_time_map_of_any_model(shown, address):
    shown.open(f"{address}#version=2&view=strobe")
    rng = np.random.default_rng(6)
    found = 0
    for k in range(60):
        law = ("newton", "active", "triggered")[k % 3]
        given = dict(
            zip(
                ("alpha", "k", "omega", "t0", "offset", "sigma", "r", "V", "trigger", "phase"),
                rng.uniform(0, 1, 10),
                strict=True,
            )
        )
        given["omega"] += 0.5
        cos, sin = rng.uniform(-1, 1, (2, 3))
        wave = {
            f"{name}{j + 1}": value for name, values in (("cos", cos), ("sin", sin)) for j, value in enumerate(values)
        }
        u, v = given["sigma"] + rng.uniform(0, 0.1), -rng.uniform(0.1, 0.8)
        reset = {
            "newton": gz.newton(given["r"]),
            "active": gz.active(given["r"], given["V"]),
            "triggered": gz.triggered(given["r"], given["V"], given["trigger"]),
        }[law]
        forcing = gz.Forcing(given["omega"], given["t0"], given["offset"], tuple(cos), tuple(sin))
        model = gz.Oscillator(given["alpha"], given["k"], forcing, reset, given["sigma"])
        seen = shown.page.evaluate(
            """async ([state, u, v]) => {
                const { machine } = explorer.views.strobe, { rowOf } = await import('./flow.js');
                return (await import('./zdm.js')).zeroTime(machine, rowOf(machine, state), u, v);
            }""",
            [{**given, **wave, "law": law}, u, v],
        )
        try:
            want = zdm_points(model, (u, v), given["phase"])
        except gz.OutsideForm:
            assert seen is None
            continue
        found += 1
        np.testing.assert_allclose(seen["points"], want.points, rtol=1e-12, atol=1e-14)
        assert abs(seen["acceleration"] - want.acceleration) < 1e-14
    assert 20 < found < 60


def test_both_grazes_of_figure_2_2(shown, address, presets, run):
    data = figure("2.2").compute(run)
    opened(shown, address, presets["2.2"])
    jumps = shown.page.evaluate("() => explorer.views.strobe.jumps")
    assert [jump["map"] for jump in jumps] == ["orbits", "orbits_local"]
    np.testing.assert_allclose([jump["at"] for jump in jumps], [data["graze"], data["local"]], rtol=4e-16)
    said = shown.page.inner_text("#summary")
    assert all(f"{data[place]:.6g}" in said for place in ("graze", "local"))
    assert "there the ball grazes the wall" in said
    shown.open(f"{address}#version=2&view=strobe")  # Python: a hit at −0.0078 appears, one at −0.0157 goes
    assert shown.page.inner_text("#summary").count("there the ball grazes the wall") == 2
    shown.page.select_option("label:has-text('coordinate') + select", "v")
    shown.until("() => location.hash.includes('coordinate=v')")
    shown.settle()


def test_the_orbit_of_figure_3_1(shown, address, presets, run):
    data = figure("3.1").compute(run)
    opened(shown, address, presets["3.1"], columns=30)
    period, word, points, multiplier = shown.page.evaluate(
        "() => { const c = explorer.views.gap.classes[0]; return [c.period, c.word, c.points.flat(), c.multiplier]; }"
    )
    assert (period, word) == (3, "LLR")
    np.testing.assert_allclose(sorted(points), data["cycle"].points[:, 0], atol=1e-12)
    assert abs(multiplier - data["multiplier"]) < 1e-12


@pytest.mark.parametrize("number", ["3.4", "3.6"])
def test_the_edges_of_a_figure(shown, address, presets, run, number):
    data = figure(number).compute(run)
    opened(shown, address, presets[number])
    l, edges, marks = shown.page.evaluate(
        "() => { const e = explorer.views.edges; return [[...e.l], "
        "e.edges.map(each => [each.N, [...each.doubling], [...each.collision]]), e.marks]; }"
    )
    np.testing.assert_array_equal(l, data["l"])
    assert [N for N, *_ in edges] == list(data["edges"])
    for N, doubling, collision in edges:
        np.testing.assert_allclose([doubling, collision], data["edges"][N], rtol=1e-15)
    wanted = {(N,): value for N, value in data["appear"].items()} | data["meet"]
    assert {tuple(mark["periods"]) for mark in marks} == set(wanted)
    for mark in marks:
        assert abs(mark["l"] - wanted[tuple(mark["periods"])]) < 1e-15
    said = shown.page.inner_text("#summary")
    for words in {"3.4": ["l = 0.0585938"], "3.6": ["l = 0.0800078", "l = 0.179624", "l = 0.627244"]}[number]:
        assert words in said


# ---- programs and commands


def test_the_program_and_the_command_of_the_windows(shown, address, tmp_path):
    shown.open(
        f"{address}#version=2&view=edges&lam=0.7&periods=1:4&gaps=0.1:0.6&span=0.05:0.9&chart_columns=5&chart_rows=4"
    )
    seen = shown.page.evaluate(
        "() => explorer.views.edges.edges.map(({ doubling, collision }) => "
        "[[...doubling], [...collision].map(x => x < 1e9 ? x : null)])"
    )
    names = known(shown)
    for N, (doubling, collision) in enumerate(seen, 1):
        np.testing.assert_allclose(doubling, names["doubling"][N], rtol=1e-15)
        np.testing.assert_allclose(np.array(collision, float) if N > 1 else np.inf, names["collision"][N], rtol=1e-15)
    words = split(shown.page.evaluate("() => explorer.texts().command"))
    words[words.index("edges.png")] = str(tmp_path / "edges.nc")
    assert main([*words[1:], "--quiet"]) == 0
    made = gz.load(tmp_path / "edges.nc")
    np.testing.assert_array_equal(made["l"], np.linspace(0.1, 0.6, 5))
    np.testing.assert_array_equal(made["mu"], np.linspace(0.05, 0.9, 4))


@pytest.mark.parametrize(
    "model",
    [
        "omega=2.1&t0=2.2&offset=0.11&V=0.2",  # of Figure 2.2
        "omega=2.1&t0=2.2&offset=0.11&V=0&order=full&phase=0.15&coordinate=v&line=-0.02:0.09",
        "law=newton&alpha=0&omega=2.6&offset=0.05&cos1=0.8&sigma=-0.1&line=-0.1:0.1&v0=-23e-2&order=corrected",
        "law=triggered&trigger=0.3&alpha=0.4&k=1.2&omega=1.7&offset=0.1&cos1=0.5&sin1=0.3&sin2=0.2&cos3=0.4&phase=0.3&r=0.7"
        "&V=0.2&sigma=0.15&line=0.16:0.35&order=corrected",  # with chatter
    ],
)
def test_the_program_and_the_command_of_one_period(shown, address, tmp_path, model):
    shown.open(f"{address}#version=2&view=strobe&{model}")
    seen = shown.page.evaluate(
        "() => { const { u, full, local } = explorer.views.strobe; return [[...u], "
        "...[full, local].map(each => [[...each.u], [...each.v], [...each.letters]])]; }"
    )
    shown.page.click("[data-copy=command]")
    shown.until("() => document.getElementById('said').textContent === 'command copied'")
    words = split(shown.page.evaluate("() => navigator.clipboard.readText()"))
    assert ["--coordinate", state(shown, "coordinate")] == words[words.index("--coordinate") :][:2]
    file = words.index("graph.png")
    words[file : file + 1] = [str(tmp_path / "graph.png"), "-o", str(tmp_path / "graph.nc")]
    assert main([*words[1:], "--quiet"]) == 0
    found = gz.load(tmp_path / "graph.nc")
    np.testing.assert_array_equal(found["u"], seen[0])
    for k, values in enumerate(seen[1:]):
        np.testing.assert_array_equal([found[name][k] for name in ("image_u", "image_v", "letter")], values)
        assert len(set(values[2])) > 1  # the line leads across a graze of both maps
    program = known(shown)["result"]
    assert program["map"].values.tolist() == found["map"].values.tolist()
    for name in ("u", "image_u", "image_v", "letter", "outcome"):
        np.testing.assert_array_equal(program[name], found[name])


# ---- the ball, anywhere


def hits(shown):
    return shown.page.evaluate("() => { const b = explorer.views.ball; return b.flash.map(h => [h.before, h.after]); }")


@FLYING
def test_a_thrown_ball_is_in_the_link_and_flies_as_in_python(shown, address, tmp_path):
    shown.open(f"{address}#version=2&view=ball&phase=0.4&alpha=1&columns=20")
    box = shown.page.locator("#phase").bounding_box()
    shown.page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.35 * box["height"])
    shown.until("() => location.hash.includes('ball=')")
    u, v, time = state(shown, "ball")
    assert u > 0 and v > 0 and time == 0.4
    shown.page.click("#play")
    link = shown.page.evaluate(
        "() => location.href.replace(/ball=[^&]*/, `ball=${explorer.views.ball.begun.join(':')}`)"
    )
    shown.page.goto("about:blank")
    shown.open(link)
    assert state(shown, "ball") == [u, v, time]
    command = split(shown.page.evaluate("() => explorer.texts().command"))
    flown = known(shown)["result"]
    for _ in range(3):
        shown.page.click("#step")
    seen = hits(shown)[:3]  # it flies while the page is made ready
    assert len(seen) == 3
    want = np.array([flown["v_minus"], flown["v_plus"]]).T
    np.testing.assert_array_equal(seen[: len(want)], want[:3])
    command[command.index("ball.png")] = str(tmp_path / "ball.nc")
    assert main([*command[1:], "--quiet"]) == 0
    np.testing.assert_array_equal(gz.load(tmp_path / "ball.nc")["v_minus"], flown["v_minus"])


@FLYING
def test_a_link_begins_where_the_ball_is(shown, address):
    shown.open(f"{address}#version=2&view=ball&offset=0.12&V=0.4&ball=0.2:0.1:0.25&columns=20")
    shown.page.click("#step")
    shown.page.click("#step")
    here = shown.page.evaluate("() => explorer.views.ball.trail.at(-1)")
    assert state(shown, "ball")[:2] == here
    link = shown.link()
    shown.page.click("#step")
    want = hits(shown)[-1]
    shown.page.goto("about:blank")
    shown.open(link)
    shown.page.click("#step")
    np.testing.assert_allclose(hits(shown)[-1], want, atol=1e-7)  # the step stands 1e-9 behind the impact
    shown.page.click("#settle")
    shown.until("() => !location.hash.includes('ball=')")


def test_a_ball_that_is_thrown_far_stays_in_sight(shown, address):
    shown.open(f"{address}#version=2&view=ball&ball=1.5:1:0&columns=20")
    x0, x1, y0, y1 = shown.page.evaluate(
        "() => { const a = explorer.views.ball.axes; return [a.x0, a.x1, a.y0, a.y1]; }"
    )
    m = known(shown)["m"]  # the copied flight begins where the ball is by now; this one where it was thrown from
    flown = gz.trajectory(m, (1.5, 1.0), 0.0, 3 * m.period)
    assert flown["u"].max() > 1.5 and x0 < 0 and flown["u"].max() < x1
    assert y0 < flown["v"].min() and flown["v"].max() < y1
    shown.page.click("#settle")
    shown.until("() => explorer.views.ball.axes.x1 < 0.6")


def test_a_state_of_the_basins_is_thrown(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    shown.page.evaluate(
        "() => { const chart = explorer.views.chart, told = []; chart.told = told; const done = chart.done; "
        "chart.done = () => (told.push(chart.summary().map(each => each.text)), done()); }"
    )
    shown.open(f"{address}#version=2&view=chart&chart=basins&offset=0.1225&chart_columns=20&chart_rows=20")
    first, *_, last = shown.page.evaluate("() => explorer.views.chart.told")
    assert first[0].endswith("so far:") and sum("%" in text for text in first) == 2 and "so far" not in last[0]
    box = shown.page.locator("#chart").bounding_box()
    shown.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.3 * box["height"])
    shown.until("() => location.hash.includes('ball=')")
    assert "the ball reaches: period" in shown.page.inner_text("#summary")
    lines = shown.page.evaluate("() => explorer.views.chart.summary()")  # before a room, without what is exact
    assert (
        sum("a point of it" in line.get("exact", "") for line in lines)
        == 2
        == sum("%" in each["text"] for each in lines)
    )
    before = state(shown, "ball")
    shown.page.keyboard.press("ArrowUp")
    shown.until(f"() => explorer.state().ball[1] > {before[1]}")
    shown.page.click("[data-view=ball]")
    shown.settle()
    assert shown.page.evaluate("() => explorer.views.ball.begun") == state(shown, "ball")


# ---- gestures


@pytest.mark.parametrize("scene", ZOOMED)
def test_a_box_zooms_and_a_double_click_shows_all(shown, address, scene):
    canvas, keys = ZOOMED[scene]
    shown.open(f"{address}#version=2&{SCENES[scene]}")
    whole = [state(shown, key) for key in keys]
    box = shown.page.locator(f"#{canvas}").bounding_box()
    at = lambda x, y: (box["x"] + x * box["width"], box["y"] + y * box["height"])  # noqa: E731
    shown.page.keyboard.down("Shift")
    shown.page.mouse.move(*at(0.35, 0.3))
    shown.page.mouse.down()
    shown.page.mouse.move(*at(0.7, 0.7), steps=4)
    shown.page.mouse.up()
    shown.page.keyboard.up("Shift")
    shown.until(f"() => JSON.stringify(explorer.state().{keys[0]}) !== '{json.dumps(whole[0], separators=(',', ':'))}'")
    shown.settle()
    near = [state(shown, key) for key in keys]
    for (a, b), (c, d) in zip(whole, near, strict=True):
        assert a < c < d < b and 0.25 < (d - c) / (b - a) < 0.55
    assert shown.problem() == "" and shown.page.is_visible("#all")
    shown.page.mouse.dblclick(*at(0.5, 0.5))
    shown.until(f"() => JSON.stringify(explorer.state().{keys[0]}) === '{json.dumps(whole[0], separators=(',', ':'))}'")
    assert [state(shown, key) for key in keys] == whole
    shown.page.keyboard.press("+")
    shown.until(f"() => document.activeElement.id === '{canvas}' && !document.getElementById('all').hidden")
    shown.page.keyboard.press("0")
    shown.until("() => document.getElementById('all').hidden")
    shown.settle()
    assert [state(shown, key) for key in keys] == whole


def test_a_zoomed_link_can_show_all(shown, address):
    shown.open(f"{address}#version=2&view=chart&span=0.1:0.2&gaps=0.3:0.4&chart_columns=20&chart_rows=20")
    shown.page.click("#all")
    shown.until("() => !location.hash.includes('span=') && !location.hash.includes('gaps=')")
    shown.settle()


def test_a_click_between_the_edges_chooses_gap_and_mu(shown, address):
    shown.open(f"{address}#version=2&view=edges&lam=0.9&span=0:1")
    place = shown.page.evaluate("() => { const a = explorer.views.edges.axes; return [a.x(0.7), a.y(0.55)]; }")
    box = shown.page.locator("#edges").bounding_box()
    shown.page.mouse.click(box["x"] + place[0], box["y"] + place[1])
    shown.until("() => location.hash.includes('l=')")
    assert abs(state(shown, "l") - 0.7) < 0.01 and abs(state(shown, "mu") - 0.55) < 0.01
    assert "period-3 orbit, word LLR" in shown.page.inner_text("#summary")
    shown.page.click("[data-view=gap]")
    shown.settle()
    assert "Inside Ω3" in shown.page.inner_text("#summary")


def test_a_click_in_one_period_chooses_the_start(shown, address):
    shown.open(f"{address}#version=2&{SHALLOW}")
    box = shown.page.locator("#strobe").bounding_box()
    before = shown.pixels("zero-time")
    shown.page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"])
    shown.until("() => location.hash.includes('u0=')")
    assert 0.01 < state(shown, "u0") < 0.03 and shown.pixels("zero-time") != before
    shown.page.fill("input[type=number][name=u0]", "0.055")
    shown.until("() => document.getElementById('summary').textContent.includes('is the identity')")


@pytest.mark.parametrize(
    ("fragment", "said"),
    [
        ("view=edges&periods=5:3", "periods=5:3; give first:last, whole numbers from 1 to 60"),
        ("view=edges&lam=1.2", "λ = 1.2; the windows of theory are known for 0 < λ < 1"),
        ("view=edges&gaps=-1:1", "l begins at -1; the windows of theory are known for l ≥ 0"),
        ("view=ball&ball=0.1:2", "ball=0.1:2; give u:v:time, three numbers"),
        ("view=ball&ball=-1:0:0", "the ball begins at u = -1, behind the wall at 0; begin at the wall or above"),
        ("view=strobe&line=-2:-1", "u(0) runs to -1, behind the wall at 0; choose starts above the wall"),
    ],
)
def test_what_cannot_be_shown_is_explained(shown, address, fragment, said):
    shown.page.goto(f"{address}#version=2&{fragment}&columns=20")
    shown.until("() => !document.getElementById('problem').hidden")
    assert said in shown.problem()
    shown.page.click("[data-view=gap]")
    shown.page.fill("input[type=number][name=lam]", "0.6")
    shown.settle()
    assert "At μ = 0.3, λ = 0.6" in shown.page.inner_text("#summary")


# ---- phone


@pytest.mark.parametrize("scene", SCENES)
def test_on_a_phone_the_picture_stays_while_a_slider_is_moved(phone, address, scene):
    phone.open(f"{address}#version=2&{SCENES[scene]}")
    assert phone.page.evaluate("() => document.documentElement.scrollWidth") <= 390
    figure, controls = (phone.page.locator(name) for name in (".first:visible", "#controls"))
    assert figure.bounding_box()["y"] < controls.bounding_box()["y"]
    sliders = phone.page.locator("#controls input[type=range]:visible")
    assert sliders.count() >= 3
    if (stairs := phone.page.locator("figure:has(#cobweb):visible")).count():
        figure = stairs  # the track of a slider has the colours of the diagram, not the stairs
    for i in (0, sliders.count() - 1):
        phone.page.evaluate("e => e.scrollIntoView({ block: 'center' })", sliders.nth(i).element_handle())
        seen, slider = figure.bounding_box(), sliders.nth(i).bounding_box()
        assert seen["y"] >= -1 and seen["y"] + seen["height"] < slider["y"]  # all of it, and nothing over the slider
        assert slider["y"] + slider["height"] < 844


# ---- browsers that lack something


def lacking(browser, script):
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    context.add_init_script(script)
    return context, Shown(context.new_page())


def test_without_a_canvas_the_words_are_there(browser, address):
    context, page = lacking(browser, "HTMLCanvasElement.prototype.getContext = () => null;")
    for scene, said in (
        ("gap", "period-3 orbit, word LLR"), ("oscillator", "Normal form"), ("edges", "Windows 3 and 4 overlap"),
        ("basins", "of the picture"), ("strobe", "Zero-time map"), ("ball", "period-3 orbit"),
    ):  # fmt: skip
        page.page.goto(f"{address}#version=2&{SCENES[scene]}")  # the first time, to the page; then within it
        page.until(f"() => document.getElementById('summary').textContent.includes('{said}')")
        assert page.problem().startswith("This browser gives the page no canvas: pictures cannot be drawn.")
        assert "grazing" in page.page.evaluate("() => explorer.texts().python")
    context.close()
    assert page.errors == []


def test_without_webassembly_the_page_says_so_and_makes_links(browser, address):
    context, page = lacking(browser, "delete window.WebAssembly;")
    page.page.goto(f"{address}#version=2&view=gap")
    page.until("() => !document.getElementById('problem').hidden")
    assert "This browser has no WebAssembly" in page.problem()
    page.page.fill("input[type=number][name=lam]", "0.6")
    page.until("() => location.hash.includes('lam=0.6')")
    page.page.click("[data-view=oscillator]")
    page.until("() => location.hash.includes('view=oscillator')")
    page.page.click("[data-save=svg]")
    page.until("() => document.getElementById('said').textContent === 'there is no picture to save'")
    context.close()
    assert page.errors == []


@pytest.mark.parametrize("way", ["refused", "not found", "not found, and late"])
def test_without_workers_the_page_computes_by_itself(browser, shown, address, way):
    script = "window.Worker = class { constructor() { throw new Error('no'); } };" if way == "refused" else ""
    context, page = lacking(browser, script)
    held = []  # answers about workers that are sent when the page has given them work
    if way == "not found":
        page.page.route("**/worker.js", lambda route: route.fulfill(status=404))
    elif "late" in way:
        page.page.route("**/worker.js", lambda route: held.append(route))
    page.page.goto(f"{address}#version=2&view=gap&columns=60&bins=50")
    if "late" in way:
        page.until("() => /computing|coarse/.test(globalThis.explorer?.views.gap.diagram.stage)")
        assert held
        page.page.evaluate(
            "() => { globalThis.failed = false; const box = document.getElementById('problem');"
            " new MutationObserver(() => { failed ||= box.textContent.includes('could not be computed'); })"
            ".observe(box, {subtree: true, childList: true, characterData: true}); }"
        )
        for route in held:  # one after the other: the page computes by itself when the second one is missed
            route.fulfill(status=404)
            page.page.wait_for_timeout(300)
        page.page.route("**/worker.js", lambda route: route.fulfill(status=404))
    page.until("() => !document.getElementById('problem').hidden")
    page.until("() => globalThis.explorer?.views.gap.diagram.stage === 'done'")
    assert "the page computes by itself" in page.problem() and "could not be computed" not in page.problem()
    assert "late" not in way or not page.page.evaluate("() => failed")
    counts = page.raster("gap")[1]
    page.page.goto("about:blank")
    page.page.goto(f"{address}#version=2&{SCENES['basins']}")
    page.until("() => globalThis.explorer?.views.chart.canvas.dataset.stage === 'done'")
    assert "of the picture" in page.page.inner_text("#summary")
    context.close()
    assert page.errors == []
    shown.open(f"{address}#version=2&view=gap&columns=60&bins=50")
    np.testing.assert_array_equal(counts, shown.raster("gap")[1])


def test_what_is_not_known_yet_has_the_colour_of_no_word(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=40&bins=60&reduced=no")
    colours = """(stage) => {
      const d = explorer.views.oscillator.diagram, was = d.stage, codes = [...d.codes];
      d.stage = stage;
      d.codes.fill(0);
      d.paint();
      const { data } = d.image.getContext("2d").getImageData(0, 0, d.image.width, d.image.height), seen = new Set();
      for (let i = 0; i < data.length; i += 4) if (data[i + 3] === 255) seen.add(data[i]);
      d.codes.set(codes);
      d.stage = was;
      return [...seen];
    }"""
    (unknown,), (none,) = shown.page.evaluate(colours, "coarse"), shown.page.evaluate(colours, "done")
    assert none == 0x6A and unknown > 0x80  # the grey of what has no word, and another one


def test_no_window_is_left_out_among_those_that_are_named(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=40&bins=20")
    named = shown.page.evaluate("""async () => {
      const { drawWindows } = await import("./gap.js"), { diagram: { axes }, windows } = explorer.views.gap, seen = [];
      const pen = axes.context, write = pen.fillText;
      pen.fillText = (text, x) => seen.push([text, x]);
      drawWindows(axes, pen, windows);
      pen.fillText = write;
      return seen;
    }""")
    texts, places = zip(*named, strict=True)
    assert len(texts) > 3 and texts == (*map(str, range(2, len(texts) + 1)), "…")
    assert (np.diff(places) < -16).all()


def test_numbers_in_words_have_the_digits_that_the_picture_needs(shown, address):
    """Six, and as in the boxes a ten-thousandth of what the picture spans."""
    few = "columns=60&bins=60&flow_starts=2&flow_transient=60&flow_keep=40"
    shown.open(f"{address}#version=2&view=edges&mu=0.12345678&{few}")
    for view in ("edges", "gap", "strobe", "oscillator"):
        shown.page.click(f"[data-view={view}]")
        shown.until(f"() => explorer.state().view === '{view}' && document.getElementById('summary').innerText")
        shown.settle()
        said = shown.page.inner_text("#summary")
        numbers = re.findall(r"\d+\.\d+", said)
        assert numbers and max(len(each.replace(".", "").lstrip("0")) for each in numbers) <= 6, said
        assert view not in {"edges", "gap"} or "μ = 0.123457" in said
    assert "at the graze d = 0.130962:" in said
    shown.page.evaluate("() => { location.hash = explorer.link() + '&offset=0.131&reach=0.1309:0.1311'; }")
    shown.until("() => document.getElementById('summary').innerText.includes('at the graze d = 0.13096187:')")
    shown.page.evaluate("() => { location.hash = explorer.link() + '&reach=0.104806:0.140806'; }")
    cut = "e => e.some(each => each.scrollWidth > each.clientWidth)"
    shown.until("() => document.querySelector('[aria-label=\"d from\"]').value === '0.104806'")
    assert not shown.page.eval_on_selector_all(".pair input", cut)


def test_subscripts_are_set_as_such(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=8&bins=8&two=yes&vary=sigma_B&reach=0.15:0.3")
    assert "σ<sub>B</sub> = 0.2" in shown.page.inner_html("#summary") and "_" not in shown.page.inner_text("#picture")
    drawn = shown.page.evaluate("""() => {
      const d = explorer.views.oscillator.diagram, pen = d.axes.context, fill = pen.fillText, said = [];
      pen.fillText = (text, x, y) => said.push([text, y, pen.font]);
      d.draw();
      pen.fillText = fill;
      return said;
    }""")
    at = [text for text, _y, _font in drawn].index("σ")
    (_sigma, y, font), (below, lower, smaller) = drawn[at : at + 2]
    assert below == "B" and lower > y and smaller != font
