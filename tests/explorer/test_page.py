"""The page of the explorer: its files, and what it does in a real browser."""

import json
import math
import re
import time

import numpy as np
import pytest

import grazing as gz
from grazing.explorer.build import shipped
from grazing.explorer.server import FOLDER, files
from grazing.plot.classes import attractor_colours
from grazing.plot.style import PERIODS
from tests.explorer.browser import FEW, LOADED, NEEDS_AXE

PAGE = FOLDER / "page"
#: What the pages and all they need may weigh, in bytes: 893,000, of which 69,000 are parts of d3, 226,000 the table,
#: 38,000 a second wall and walls that move, 9,000 reset laws and 17,000 maps of one's own, 18,000 what is said
#: and shown before a room.
HEAVIEST = 898_500


@pytest.fixture
def kept():
    return True


def text_of(name):
    return (PAGE / name).read_text(encoding="utf-8")


# ---- files


def test_no_file_names_another_host():
    for path in PAGE.iterdir():
        # names, of XML: asked of nobody
        text = re.sub(r'xmlns(:\w+)?="[^"]*"|"http://www\.w3\.org/[\w/]+"', "", path.read_text(encoding="utf-8"))
        found = re.findall(r"(?:https?:|wss?:)?//[\w.-]+\.\w+", text)
        assert not found, (path.name, found)


def test_modules_import_files_that_are_there():
    for path in PAGE.glob("*.js"):
        for name in re.findall(r'(?:from|import) "([^"]+)"', path.read_text(encoding="utf-8")):
            assert name.startswith("./") and (PAGE / name).exists(), (path.name, name)
    named = re.findall(r'(?:src|href)="([^"#:]+)"', text_of("index.html"))
    assert named and all((PAGE / name).exists() for name in named)


def test_a_tab_names_the_cobweb():
    assert re.search(r'data-view="gap"[^>]* title="[^"]*cobweb"', text_of("index.html"))


def test_size():
    sizes = {name: path.stat().st_size for name, path in files().items() if not name.endswith("/")}
    assert sum(sizes.values()) < HEAVIEST, sizes


def literal(name, constant):
    """The names in a literal of a script."""
    body = re.search(rf"export const {constant} = (\{{.*?\n?\}});", text_of(name), re.DOTALL).group(1)
    return json.loads(re.sub(r",\s*\}", "}", re.sub(r"(\w+):", r'"\1":', body)))


def test_every_slider_is_a_parameter_of_a_kernel():
    modules = shipped()["modules"]
    for constant, module in (("GAP_EXTENTS", "gap"), ("OSCILLATOR_EXTENTS", "oscillator")):
        fields = {field["name"]: field for field in modules[module]["fields"] if "choices" not in field}
        extents = literal("state.js", constant)
        assert extents.keys() == fields.keys()
        for name, (low, high) in extents.items():
            least, most = fields[name]["low"], fields[name]["high"]
            assert (least if least is not None else -math.inf) <= low < high <= (most if most is not None else math.inf)
            assert not (fields[name]["open_low"] and low == least)


def test_colours_are_those_of_the_figures():
    assert json.loads(re.search(r"export const PERIODS = (\[.*?\]);", text_of("colours.js")).group(1)) == list(PERIODS)


def test_choices_are_those_of_the_kernels():
    fields = {field["name"]: field for field in shipped()["modules"]["oscillator"]["fields"]}
    named = re.search(r"LAWS = \{(.*?) \};", text_of("laws.js")).group(1)
    assert re.findall(r"(\w+): \[", named) == fields["law"]["choices"]
    orders = re.search(r"ORDERS = (\[.*?\])", text_of("state.js")).group(1)
    assert json.loads(orders) == fields["order"]["choices"]


# ---- in a browser


@pytest.mark.parametrize(
    "fragment",
    [
        "version=2&view=gap&lam=0.5&l=0.1&span=-0.05:0.35&columns=90&bins=200&starts=7&transient=90&keep=130&seed=3",
        "version=2&view=gap&lam=0.9&l=0.8&span=0.002:0.06&range=-0.9:0.1&columns=70&bins=333&keep=200",
    ],
)
def test_the_raster_of_the_gap_map_is_that_of_python(shown, address, fragment):
    shown.open(f"{address}#{fragment}")
    told, counts = shown.raster("gap")
    program = shown.page.evaluate("() => explorer.texts().python")
    known = {}
    exec(program.replace("gz.plot.save", "(lambda *_: None)"), known)
    want = known["result"]
    np.testing.assert_array_equal(counts[:, 1:-2], want["count"])
    np.testing.assert_array_equal(counts[:, 0], want["below"])
    np.testing.assert_array_equal(counts[:, -2], want["above"])
    assert told["low"] == want["x"].attrs["low"] and want["count"].values.any(axis=1).all()


@pytest.mark.parametrize(
    "fragment",
    [
        "version=2&view=oscillator&columns=40&bins=150&seed=4",
        "version=2&view=oscillator&law=newton&alpha=0.4&sin1=0.2&cos2=0.3&sigma=0.1&vary=omega&reach=1.8:2.6&phase=0.3"
        "&coordinate=v&columns=24&bins=120",
        "version=2&view=oscillator&law=triggered&alpha=0.5&trigger=0.2&vary=V&reach=0.1:0.9&columns=20&bins=80",
        "version=2&view=oscillator&two=yes&alpha=1&vary=V_B&reach=0.1:0.9&columns=7&bins=80&phase=0.3",
        "version=2&view=oscillator&two=yes&law=newton&k=0&cos1=0&sin_A=0.3&cos_A=0.1&alpha=0.3&sigma=-0.5&sigma_B=0.5"
        "&vary=r&reach=0.5:1&coordinate=v&columns=12&bins=80",
        "version=2&view=oscillator&law=newton&k=0&offset=-1&cos1=0&sin_A=0.3&alpha=0&vary=r&reach=0.2:0.8&columns=12&bins=80",
    ],
)
def test_the_raster_of_the_oscillator_is_that_of_python(shown, address, fragment):
    shown.open(f"{address}#{fragment}")
    told, counts = shown.raster("oscillator")
    program = shown.page.evaluate("() => explorer.texts().python")
    known = {}
    exec(program.replace("gz.plot.save", "(lambda *_: None)"), known)
    sure = known["result"]["ambiguous"].values == 0  # elsewhere Python decides in ball arithmetic
    assert told["ambiguous"] == 0 or sure.sum() > 0.8 * len(sure)
    np.testing.assert_array_equal(counts[sure, 1:-2], known["result"]["count"].values[sure])


@pytest.mark.parametrize(
    "view",
    [
        "gap&lam=0.6&columns=30&bins=50",
        "oscillator&V=0.3&columns=12&bins=40&law=newton",
        "oscillator&V=0.3&columns=12&bins=40",  # the pinball, whose starts have a box of their own
        "oscillator&V=0.3&columns=12&bins=40&cos1=0.9",
        "oscillator&two=yes&columns=12&bins=40",
        "oscillator&two=yes&law=newton&sin_A=0.05&cos_A=0.02&columns=12&bins=40&vary=r_B&reach=0.3:0.6",
        "oscillator&law=newton&k=0&offset=-1&sin_A=0.3&columns=12&bins=40&vary=r&reach=0.3:0.6",
    ],
)
def test_the_command_makes_the_same_raster(shown, address, view, tmp_path):
    from shlex import split

    from grazing.cli.app import main

    shown.open(f"{address}#version=2&view={view}")
    _told, counts = shown.raster(view.partition("&")[0])
    words = split(shown.page.evaluate("() => explorer.texts().command"))
    words[words.index("density.png")] = str(tmp_path / "density.nc")
    assert words[0] == "grazing" and main([*words[1:], "--quiet"]) == 0
    np.testing.assert_array_equal(counts[:, 1:-2], gz.load(tmp_path / "density.nc")["count"])


@LOADED
def test_no_request_leaves_the_host(shown, address):
    for view in ("gap", "oscillator", "ball", "chart"):
        shown.open(f"{address}#version=2&view={view}&columns=20&chart_columns=20&chart_rows=16")
    assert shown.asked and all(url.startswith((address.removesuffix("page/"), "data:")) for url in shown.asked)


def test_a_slider_changes_picture_link_and_words(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=200")
    before = shown.pixels("gap-diagram"), shown.page.inner_text("#summary"), shown.link()
    shown.page.locator("#gap-sliders input[type=range]").nth(1).focus()
    for _ in range(40):
        shown.page.keyboard.press("ArrowRight")
    shown.until("() => explorer.state().l > 0.23")
    shown.settle()
    after = shown.pixels("gap-diagram"), shown.page.inner_text("#summary"), shown.link()
    assert all(one != other for one, other in zip(before, after, strict=True))


def test_a_click_picks_and_a_box_zooms(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=300&bins=200")
    box = shown.page.locator("#gap-diagram").bounding_box()
    middle = box["y"] + box["height"] / 2
    shown.page.mouse.click(box["x"] + 0.3 * box["width"], middle)
    shown.until("() => explorer.state().mu !== 0.3")
    mu, first = shown.page.evaluate("() => explorer.state().mu"), shown.raster("gap")[1]
    assert -0.1 < mu < 0.3
    shown.page.keyboard.down("Shift")
    shown.page.mouse.move(box["x"] + 0.4 * box["width"], middle - 80)
    shown.page.mouse.down()
    shown.page.mouse.move(box["x"] + 0.6 * box["width"], middle + 80, steps=4)
    shown.page.mouse.up()
    shown.page.keyboard.up("Shift")
    shown.until("() => location.hash.includes('span=')")
    shown.settle()
    low, high = shown.page.evaluate("() => explorer.state().span")
    assert -0.1 < low < high < 0.6 and not np.array_equal(first, shown.raster("gap")[1])
    shown.page.click("#all")
    shown.until("() => !location.hash.includes('span=')")


def test_keys_move_and_zoom(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=100&mu=0.2")
    shown.page.focus("#gap-diagram")
    shown.page.keyboard.press("ArrowRight")
    shown.until("() => explorer.state().mu > 0.2")
    shown.page.keyboard.press("+")
    shown.until("() => explorer.state().span[1] - explorer.state().span[0] < 0.36")
    shown.page.keyboard.press("0")
    shown.until("() => explorer.state().span[1] - explorer.state().span[0] > 0.69")


def test_a_link_round_trip(shown, address):
    fragment = "version=2&view=oscillator&alpha=2.5&V=0.3&vary=V&reach=0.1:0.5&columns=60&bins=90&theory=no"
    shown.open(f"{address}#{fragment}")
    state, counts = shown.page.evaluate("() => explorer.state()"), shown.raster("oscillator")[1]
    link = shown.page.evaluate("() => location.href")
    shown.page.goto("about:blank")
    shown.open(link)
    assert shown.page.evaluate("() => explorer.state()") == state
    assert shown.page.evaluate("() => location.href") == link
    assert set(fragment.split("&")) <= set(link.partition("#")[2].split("&")) | {"V=0.3"}
    np.testing.assert_array_equal(shown.raster("oscillator")[1], counts)


@pytest.mark.parametrize(
    ("fragment", "said"),
    [
        ("version=2&view=nowhere&columns=20", "view=nowhere; allowed are ball, oscillator, gap, edges, chart, strobe"),
        ("version=7&view=gap", "the link has version 7; this page reads version 2"),
        ("view=gap&lam=0.5", "the link does not say its version"),
        ("version=2&view=gap&lam=much&columns=20", "lam=much is not a number"),
        ("version=2&view=oscillator&r=1.5&columns=20", "r = 1.5; allowed is r ≥ 0 and r ≤ 1"),
        ("version=2&view=oscillator&omega=0&columns=20", "omega = 0; allowed is omega > 0"),
        ("version=2&view=gap&two=yes&sigma_B=-1&columns=20", "allowed is sigma_B ≥ 0.02"),
        ("version=2&view=gap&vary=V_B&columns=20", "vary=V_B; there is no second wall"),
        ("version=2&view=gap&columns=1e9", "columns=1e9; allowed is a whole number from 2 to 4000"),
        ("version=2&view=gap&span=0.5:0.1&columns=20", "span=0.5:0.1; give low:high with low < high"),
        ("version=2&%E0%A4%A&&=&colour=perhaps&columns=20", "colour=perhaps; allowed are yes, no"),
    ],
)
def test_a_mangled_link_is_explained_and_a_picture_shown(shown, address, fragment, said):
    shown.open(f"{address}#{fragment}")
    assert said in shown.problem()
    assert shown.page.inner_text("#summary")


def test_a_number_out_of_range_is_explained_and_the_picture_stays(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=20")
    before = shown.page.evaluate("() => location.href")
    shown.page.fill("input[type=number][name=r]", "1.5")
    shown.until("() => !document.getElementById('problem').hidden")
    assert "r = 1.5; allowed is r ≥ 0 and r ≤ 1" in shown.problem()
    assert shown.page.get_attribute("input[type=number][name=r]", "aria-invalid") == "true"
    assert shown.page.evaluate("() => location.href") == before
    shown.page.fill("input[type=number][name=r]", "0.7")
    shown.until("() => location.hash.includes('r=0.7') && document.getElementById('problem').hidden")


@LOADED
def test_a_module_that_fails_to_load_is_named_and_the_rest_works(shown, address):
    shown.page.route("**/oscillator.wasm", lambda route: route.abort())
    shown.open(f"{address}#version=2&view=gap&columns=50")
    assert "oscillator.wasm could not be loaded" in shown.problem()
    assert "period-3 orbit, word LLR" in shown.page.inner_text("#summary")
    shown.page.click("[data-view=ball]")
    shown.until("() => document.getElementById('problem').textContent.includes('choose another view')")
    shown.page.click("[data-view=gap]")
    shown.settle()


@LOADED
def test_without_kernels_the_page_says_what_to_do(shown, address):
    shown.page.route("**/kernels.json", lambda route: route.fulfill(status=404))
    shown.page.goto(address)
    shown.until("() => !document.getElementById('problem').hidden")
    assert "grazing explore" in shown.problem()


def test_words_of_what_is_shown(shown, address):
    shown.open(f"{address}#version=2&view=gap&lam=0.8&l=1&mu=0.5&columns=20")
    said = shown.page.inner_text("#summary")
    assert "period-3 orbit, word LLR, multiplier −0.632317" in said and "−1.00608" in said
    shown.open(f"{address}#version=2&view=gap&lam=0.5&l=0.1&mu=0.168&columns=20")  # one start in eleven comes to LLR
    said = shown.page.inner_text("#summary")
    assert "word LR," in said and "word LLR," in said and "of 64 starts" in said
    shown.open(f"{address}#version=2&view=ball&offset=0.12&V=0.4&columns=20")
    assert "period-3 orbit, one impact, word 001" in shown.page.inner_text("#summary")


def test_the_normal_form_of_the_oscillator(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=30&bins=60")
    nf = gz.normal_form(gz.pinball(), "d")
    found = shown.page.evaluate("() => { const f = explorer.views.oscillator.form; return [f.graze, f.lam, f.l]; }")
    assert found == [nf.graze, nf.lam, nf.l]
    mu = shown.page.evaluate("() => [...explorer.views.oscillator.mu]")
    np.testing.assert_array_equal(mu, nf.mu(np.linspace(0.05, 0.16, 30)))
    assert shown.page.is_visible("#reduced-diagram")
    shown.page.uncheck("text=reduced diagram below")
    shown.until("() => document.getElementById('reduced-figure').hidden")


@pytest.mark.parametrize("motion", ["no-preference"])
def test_the_ball_moves_pauses_and_steps_from_impact_to_impact(shown, address):
    shown.open(f"{address}#version=2&view=ball&offset=0.12&V=0.4&columns=20")
    ball = "explorer.views.ball"
    shown.until(f"() => {ball}.now > 1")
    shown.page.click("#play")
    paused = shown.page.evaluate(f"() => {ball}.now")
    time.sleep(0.2)
    assert shown.page.evaluate(f"() => {ball}.now") == paused
    times = []
    for _ in range(4):
        shown.page.click("#step")
        times.append(shown.page.evaluate(f"() => {ball}.now"))
    T = 2 * math.pi / 2.2
    np.testing.assert_allclose(np.diff(times), 3 * T, atol=1e-6)  # one impact in three periods


#: Whether all pictures that are seen show something: to compute them to the end is most of the work.
BEGUN = """() => {
  const seen = [...document.querySelectorAll("canvas[data-stage]")].filter((c) => c.offsetParent);
  return seen.length > 0 && seen.every((c) => c.dataset.stage !== "empty");
}"""


def test_figures_by_their_numbers(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    shown.page.evaluate(FEW)
    for name, wanted in (
        ("3.2", "lam=0.34"),
        ("2.2", "view=strobe"),
        ("3.5a", "lam=0.9"),
        ("1.3", "V=0"),
        ("1.5", "view=ball"),
    ):
        shown.page.select_option("#preset", name)
        shown.until(f"() => location.hash.includes('{wanted}')")
        shown.until(BEGUN)
        assert shown.problem() == ""


def test_every_field_has_a_name(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=20")
    nameless = shown.page.evaluate(
        "() => [...document.querySelectorAll('input, select, canvas, button')]"
        ".filter(e => !(e.getAttribute('aria-label') || (e.labels && e.labels.length) || e.textContent.trim()))"
        ".map(e => e.outerHTML)"
    )
    assert nameless == []


def test_a_phone_shows_all_of_its_width(pages, address):
    with pages(False, viewport={"width": 375, "height": 700}, reduced_motion="reduce") as page:
        for view in ("gap", "edges", "oscillator", "ball", "chart", "strobe"):
            page.open(f"{address}#version=2&view={view}&columns=30&chart_columns=30&chart_rows=20&flow_starts=2")
            page.until(f"() => explorer.state().view === '{view}'")
            assert page.page.evaluate("() => document.documentElement.scrollWidth") <= 375


def test_copy_buttons_give_what_is_on_screen(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=20&lam=0.7")
    texts = {**shown.page.evaluate("() => explorer.texts()"), "link": shown.link()}
    for kind, text in texts.items():
        shown.page.click(f"[data-copy={kind}]")
        shown.until("() => document.getElementById('said').textContent.includes('copied')")
        assert shown.page.evaluate("() => navigator.clipboard.readText()") == text
        shown.page.evaluate("() => document.getElementById('said').textContent = ''")
    compile(texts["python"], "copied", "exec")


@LOADED
def test_a_range_is_copied_and_shown_once_it_is_that_of_the_picture(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=20&bins=20")
    shown.page.evaluate("""() => {
      const {pool} = explorer.views.oscillator.diagram, never = new Promise(() => {});
      pool.batch = () => ({live: () => true, run: () => never});
      location.hash = "#version=2&view=oscillator&columns=20&bins=20&coordinate=v";
    }""")
    shown.until("() => explorer.views.oscillator.diagram.stage === 'computing'")
    for kind in ("python", "command"):
        shown.page.click(f"[data-copy={kind}]")
        assert shown.page.inner_text("#said") == "the picture is not there yet"


@pytest.mark.parametrize("columns", [2, 20])
def test_a_diagram_of_few_columns_is_as_high_as_its_orbits(shown, address, columns):
    shown.open(f"{address}#version=2&view=oscillator&bins=20&two=yes&sigma_B=0.3&columns={columns}")
    _found, counts = shown.raster("oscillator")
    assert counts[:, [0, -2]].sum() < 0.05 * counts.sum()


def test_a_picture_is_saved(shown, address, tmp_path):
    from PIL import Image

    shown.open(f"{address}#version=2&view=gap&columns=200")
    with shown.page.expect_download() as download:
        shown.page.click("[data-save=png]")
    download.value.save_as(tmp_path / "seen.png")
    pixels = np.asarray(Image.open(tmp_path / "seen.png").convert("RGB"))
    assert download.value.suggested_filename == "grazing-gap.png"
    assert len(np.unique(pixels @ [1 << 16, 1 << 8, 1])) > 20


def test_the_program_of_the_ball_flies_the_same_orbit(shown, address):
    shown.open(f"{address}#version=2&view=ball&offset=0.12&V=0.4&columns=20")
    known = {}
    exec(shown.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), known)
    hits = shown.page.evaluate("() => explorer.views.ball.attractor.hits.map(h => [h.before, h.after])")
    found = known["result"]
    np.testing.assert_array_equal(np.array(hits).T, [found["v_minus"], found["v_plus"]])


@pytest.mark.parametrize("more", ["", "&cos_A=0.02&sin_A=0.03&phase=0.4"])
def test_a_ball_between_two_walls_hits_both_as_in_python(shown, address, more):
    shown.open(f"{address}#version=2&view=ball&two=yes&columns=20&bins=20{more}")
    assert "between two bumpers that kick" in shown.page.inner_text("#headline")
    shown.page.evaluate("() => { for (let i = 0; i < 8; i++) explorer.views.ball.step(); }")
    letters = shown.page.evaluate("() => [...explorer.views.ball.past.letters.values()].join('')")
    assert set("AB") <= set(letters) <= set("0AB")
    marks = shown.page.evaluate("() => explorer.views.ball.past.marks.map(m => m.wall)")
    assert {0, 1} == set(marks)
    shown.page.click("#settle")
    known = {}
    exec(shown.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), known)
    told = shown.page.evaluate(
        "() => explorer.views.ball.attractor.hits.map(h => [h.name, h.speed, h.before, h.after])"
    )
    names, *numbers = zip(*told, strict=True)
    found = known["result"]
    assert list(names) == found["impact_wall"].values.tolist()
    np.testing.assert_array_equal(numbers[0], found["impact_speed"])
    np.testing.assert_allclose(numbers[1:], [found["v_minus"], found["v_plus"]], rtol=0, atol=1e-14)


def test_the_local_map_says_that_it_is_of_one_wall(shown, address):
    shown.page.goto(f"{address}#version=2&view=strobe&two=yes")
    shown.until("() => !document.getElementById('problem').hidden")
    assert "one wall at rest; take the second wall away" in shown.problem()
    assert shown.page.get_attribute("#strobe", "data-stage") == "failed"
    # no frame stands empty
    assert shown.page.is_hidden("#zero-time") and shown.page.locator("#strobe").bounding_box()["height"] < 150
    shown.page.click("text=a second wall, above the ball")
    shown.settle()
    assert shown.problem() == "" and "two" not in shown.link() and shown.page.is_visible("#zero-time")


@NEEDS_AXE
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(
    "view",
    [
        "gap&tour=7&web=5&note=x&columns=40",
        "gap&tour=8&answer=1&columns=40",
        "oscillator&columns=20",
        "ball&columns=20",
        "ball&twin=yes&sweeps=yes&offset=0.1225&columns=40",
        "ball&two=yes&sin_A=0.02&columns=20",
        "gap&lam=x&columns=40",
        "chart&chart_columns=20&chart_rows=16",
        "strobe",
        "edges",
    ],
)
def test_axe_reports_no_violation(pages, address, view, scheme):
    with pages(True, viewport={"width": 1280, "height": 720}, color_scheme=scheme, reduced_motion="reduce") as page:
        page.open(f"{address}#version=2&view={view}")
        assert page.violations() == []


@NEEDS_AXE
def test_axe_reports_what_is_wrong(shown, address):
    shown.open(f"{address}#version=2&view=edges")
    shown.page.evaluate("() => document.querySelector('main').insertAdjacentHTML('beforeend', '<img id=bare src=x>')")
    try:
        assert shown.violations() == [["image-alt", ['<img id="bare" src="x">']]]
    finally:
        shown.page.evaluate("() => document.getElementById('bare').remove()")


@pytest.mark.parametrize(
    "fragment",
    [
        "version=2&view=chart&lam=0.8&span=-0.05:0.5&gaps=0:0.6&chart_columns=31&chart_rows=22",
        "version=2&view=chart&chart=oscillator&reach=0.1:0.14&heights=0.05:0.6&chart_columns=12&chart_rows=9",
        "version=2&view=chart&chart=oscillator&law=newton&alpha=0.5&cos2=0.2&vary=omega&reach=1.8:2.6&second=cos2"
        "&heights=0:0.5&chart_columns=9&chart_rows=8",
    ],
)
def test_a_chart_is_that_of_python(shown, address, fragment, tmp_path):
    from shlex import split

    from grazing.cli.app import main

    shown.open(f"{address}#{fragment}")
    codes = np.array(shown.page.evaluate("() => [...explorer.views.chart.codes]"))
    known = {}
    exec(shown.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), known)
    want = known["result"]["period"].values
    want = want[..., 0] if want.ndim == 3 else want
    np.testing.assert_array_equal(codes.reshape(want.shape[::-1]).T, np.maximum(want, 0))
    assert len(np.unique(want[want > 0])) > 1
    words = split(shown.page.evaluate("() => explorer.texts().command"))
    words[words.index("chart.png")] = str(tmp_path / "chart.nc")
    assert main([*words[1:], "--quiet"]) == 0
    np.testing.assert_array_equal(gz.load(tmp_path / "chart.nc")["period"], known["result"]["period"])


def test_a_click_in_the_chart_picks_both_parameters(shown, address):
    shown.open(f"{address}#version=2&view=chart&chart_columns=20&chart_rows=20")
    box = shown.page.locator("#chart").bounding_box()
    shown.page.mouse.click(box["x"] + 0.8 * box["width"], box["y"] + 0.3 * box["height"])
    shown.until("() => explorer.state().mu > 0.4 && explorer.state().l > 0.5")
    shown.page.keyboard.press("ArrowLeft")
    shown.page.select_option("label:has-text('chart of') + select", "oscillator")
    shown.until("() => location.hash.includes('chart=oscillator')")
    shown.settle()
    assert shown.problem() == ""


@pytest.mark.parametrize("order", ["lowest", "full", "corrected"])
def test_one_period_by_both_maps(shown, address, order):
    link = f"{address}#version=2&view=strobe&omega=2.1&t0=2.2&offset=0.11&V=0.2&order={order}"
    shown.open(link)
    seen = shown.page.evaluate(
        "() => { const { full, local } = explorer.views.strobe; "
        "return [[[...full.u], [...full.v]], [[...local.u], [...local.v]], [[...full.letters], [...local.letters]]]; }"
    )
    known = {}
    exec(shown.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), known)
    found = known["result"]
    for k in (0, 1):
        np.testing.assert_array_equal(seen[k], [found["image_u"][k], found["image_v"][k]])
    np.testing.assert_array_equal(seen[2], found["letter"])
    at = re.search(r"below u\(0\) = ([\d.]+)", shown.page.inner_text("#summary"))
    assert at.group(1) == "0.0383356"  # the graze of Figure 2.2


@pytest.mark.parametrize(
    ("model", "attractors"),
    [
        ("offset=0.1225", 2),  # of periods 3 and 4
        ("omega=1.1&cos1=0&cos2=1&offset=0.05", 2),  # period 2 of half the clock: two of period 1 with the same word
    ],
)
def test_basins_are_those_of_python(shown, address, tmp_path, model, attractors):
    from shlex import split

    from grazing.cli.app import main

    shown.open(f"{address}#version=2&view=chart&chart=basins&{model}&chart_columns=13&chart_rows=11")
    rows, reached = shown.page.evaluate(
        "() => { const chart = explorer.views.chart, all = chart.attractors(); return "
        "[[...chart.codes].map(code => all.findIndex(each => each.row === code)), all]; }"
    )
    known = {}
    exec(shown.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), known)
    want = known["result"]
    np.testing.assert_array_equal(np.array(rows).reshape(11, 13).T, want["basin"])
    assert [(each["period"], each["word"]) for each in reached] == list(
        zip(want["period"].values.tolist(), want["word"].values.tolist(), strict=True)
    )
    np.testing.assert_allclose([each["point"] for each in reached], want["point"], atol=1e-6)
    assert [each["cells"] / 143 for each in reached] == want["fraction"].values.tolist()
    assert [each["colour"] for each in reached] == attractor_colours(want["period"].values.tolist())
    assert len(reached) == attractors
    words = split(shown.page.evaluate("() => explorer.texts().command"))
    words[words.index("basins.png")] = str(tmp_path / "basins.nc")
    assert main([*words[1:], "--quiet"]) == 0
    np.testing.assert_array_equal(gz.load(tmp_path / "basins.nc")["basin"], known["result"]["basin"])
