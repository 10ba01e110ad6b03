"""What is given away: a folder and a single file that show the page, links that keep working, and the way back."""

import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest
from PIL import Image

from grazing.cli.app import main
from grazing.cli.explore import explore
from grazing.explorer.onefile import bundle, page
from grazing.outcome import InputError
from tests.explorer.browser import FEW, LOADED, Shown


@pytest.fixture
def kept():
    return True


#: What all of it may weigh in one file, in bytes.
HEAVIEST = 900_000


def state(shown, key):
    return shown.page.evaluate(f"() => explorer.state().{key}")


class Silent(SimpleHTTPRequestHandler):
    def log_message(self, *_given):
        pass


@pytest.fixture
def hosted(tmp_path):
    """A folder on a host that knows nothing of us."""
    explore(out=tmp_path / "site")
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Silent, directory=tmp_path / "site")) as host:
        thread = threading.Thread(target=host.serve_forever, kwargs={"poll_interval": 0.05})
        thread.start()
        yield f"http://127.0.0.1:{host.server_address[1]}"
        host.shutdown()
        thread.join()


@LOADED
@pytest.mark.parametrize("where", ["/", "/page/"])
def test_a_folder_shows_the_page_at_its_root_and_where_older_links_lead(shown, hosted, where):
    shown.open(f"{hosted}{where}#version=2&view=gap&lam=0.8&l=1&mu=0.5&columns=50")
    assert shown.problem() == "" and "word LLR" in shown.page.inner_text("#summary")
    assert shown.page.evaluate("() => getComputedStyle(document.querySelector('main')).display") == "grid"
    assert all(url.startswith((hosted, "data:")) for url in shown.asked)


@LOADED
def test_the_last_step_of_the_tour_leads_to_the_table(shown, hosted):
    shown.open(f"{hosted}/#version=2&view=gap&tour=11&columns=50")
    shown.page.click("#guide-link")
    shown.until("() => window.pinball && pinball.game()")
    shown.page.click("#rungs >> text=Galton board")
    shown.page.click("#rungs >> text=One bumper")
    shown.page.go_back()  # a table is a step of the history, too
    shown.until("() => pinball.game() && document.querySelector('#headline').textContent.startsWith('No bumper')")
    shown.page.click("#rungs >> text=The paper")
    shown.until("() => window.explorer && explorer.state().tour === 11")


def test_the_paper_is_its_ball_whole_in_this_tab_and_in_another(shown, hosted):
    whole = "() => window.explorer && explorer.state().view === 'ball' && explorer.state().V === 0.4"
    shown.open(f"{hosted}/#version=2&view=gap&lam=0.5&columns=50")
    with shown.page.context.expect_page() as opened:
        shown.page.click("nav a", modifiers=["Control"])
    opened.value.click("#paper")  # nothing lies behind it
    opened.value.wait_for_function(whole)
    opened.value.close()
    shown.page.click("nav a")
    shown.page.wait_for_function("() => window.pinball && pinball.game()")
    shown.page.click("#rungs >> text=One bumper")
    shown.page.click("#paper")
    shown.page.wait_for_function(whole)


def test_a_folder_that_is_opened_from_the_disk_says_what_to_do(browser, tmp_path):
    explore(out=tmp_path)
    page = browser.new_page()
    page.goto((tmp_path / "index.html").as_uri())
    page.wait_for_selector("#unread", state="visible")
    assert "grazing explore --out page.html" in page.inner_text("#unread")
    page.close()


def test_what_is_said_of_a_page_that_does_not_start_is_gone_when_it_does(shown, address):
    shown.open(f"{address}#version=2&view=edges")
    assert shown.page.query_selector("#unread") is None


@pytest.fixture(scope="module")
def single(tmp_path_factory):
    file = tmp_path_factory.mktemp("one") / "deep" / "page.html"
    assert explore(out=file) == 0
    return file


def test_a_single_file_works_from_the_disk(browser, single):
    assert single.stat().st_size < HEAVIEST
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    shown = Shown(context.new_page())
    shown.open(f"{single.as_uri()}#version=2&view=ball&columns=20&offset=0.12")
    assert shown.problem() == ""  # workers were started
    assert "It hits once in three pushes: 001." in shown.page.inner_text(".lead")
    shown.page.click("[data-view=gap]")
    shown.settle()
    assert "view=gap" in shown.link()
    shown.page.reload()
    shown.settle()
    assert state(shown, "view") == "gap"
    shown.open(f"{single.as_uri()}#version=2&view=gap&columns=20&tour=11")
    assert shown.page.is_visible("#guide") and not shown.page.is_visible("#guide-link")  # no table lies in the file
    assert all(url.startswith(("file:", "blob:", "data:")) for url in shown.asked)
    context.close()
    assert shown.errors == []


def test_the_single_file_shows_what_the_page_shows(browser, shown, single, address):
    fragment = "version=2&view=gap&lam=0.7&columns=60&bins=50"
    shown.open(f"{address}#{fragment}")
    want, counts = shown.raster("gap")
    other = Shown(browser.new_page())
    other.open(f"{single.as_uri()}#{fragment}")
    found, same = other.raster("gap")
    other.page.close()
    assert (found, same.tolist()) == (want, counts.tolist())


def test_a_file_is_renewed_and_its_folder_made(tmp_path):
    file = tmp_path / "new" / "page.html"
    explore(out=file)
    file.write_text("old")
    explore(out=file)
    assert file.read_bytes() == page().encode()  # line for line on every system: the page's rules are digests of them
    assert page().count("</script>") == 2 and page().count("</style>") == 1  # nothing in them ends them early


def test_a_file_where_none_can_be(tmp_path):
    (tmp_path / "page.html").mkdir()
    with pytest.raises(InputError, match=r"is a folder; give the name of a file"):
        explore(out=tmp_path / "page.html")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot write to .*choose a folder"):
        explore(out=tmp_path / "file" / "page.html")


def test_modules_that_import_one_another_are_refused(monkeypatch, tmp_path):
    (tmp_path / "page").mkdir()
    for one, other in (("a", "b"), ("b", "a")):
        (tmp_path / "page" / f"{one}.js").write_text(f'import {{ x }} from "./{other}.js";\n')
    monkeypatch.setattr("grazing.explorer.onefile.FOLDER", tmp_path)
    with pytest.raises(InputError, match=r"a\.js -> b\.js -> a\.js"):
        bundle("a.js")


def test_the_command_says_what_it_wrote(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["explore", "--out", "page.html"]) == 0
    assert "page.html" in capsys.readouterr().out and (tmp_path / "page.html").is_file()


# ---- links


#: Links of earlier versions of the page, and what they must still show.
OLDER = {
    "version=1&view=gap&lam=0.5&l=0.1&span=-0.05:0.35&mu=0.12": {"view": "gap", "l": 0.1, "mu": 0.12},
    "version=1&view=ball&columns=30&offset=0.12&V=0.4&ball=0.2:0.1:0.25": {"view": "ball", "V": 0.4},
    "version=1&view=oscillator&columns=30&vary=V&reach=0.1:0.5&reduced=no&theory=no": {"vary": "V", "reduced": False},
    "version=1&view=chart&chart=basins&offset=0.1225&chart_columns=20&chart_rows=16": {"chart": "basins"},
    "version=1&view=strobe&omega=2.1&t0=2.2&offset=0.11&V=0.2&order=full": {"order": "full", "u0": 0.03},
    "version=1&view=edges&lam=0.9&periods=3:5&gaps=0:1&span=0:1&l=0.7": {"periods": [3, 5]},
    "version=1&view=ball&columns=30&tour=2&offset=0.1305": {"tour": 2, "offset": 0.1305},
}


@pytest.mark.parametrize("link", OLDER)
def test_older_links_keep_working(shown, address, link):
    shown.open(f"{address}#{link}")
    assert shown.problem() == ""
    assert {key: state(shown, key) for key in OLDER[link]} == OLDER[link]


# ---- pictures


@pytest.mark.parametrize("view", ["ball", "gap", "chart&chart_columns=40&chart_rows=30"])
def test_a_picture_is_saved_at_a_chosen_size(shown, address, tmp_path, view):
    shown.open(f"{address}#version=2&view={view}&columns=60")
    found = []
    for times in ("0", "3840"):
        shown.page.select_option("#times", times)
        with shown.page.expect_download() as download:
            shown.page.click("[data-save=png]")
        download.value.save_as(tmp_path / "seen.png")
        found.append(Image.open(tmp_path / "seen.png").convert("L"))
    small, large = found
    assert large.width == 3840 and abs(large.height - 3840 * small.height / small.width) <= 1
    seen = "[...document.querySelectorAll('main canvas')].filter(c => c.offsetParent)"
    assert shown.page.evaluate(f"() => {seen}.every(c => c.width === c.clientWidth)")  # the screen is as before
    # the same picture, finer: averaged it is the small one, and it is no enlargement of it
    mean = np.asarray(large.resize(small.size, Image.Resampling.BOX)).astype(float)
    assert np.abs(mean - np.asarray(small)).mean() < 4
    blown = np.asarray(small.resize(large.size, Image.Resampling.NEAREST)).astype(float)
    assert np.abs(blown - np.asarray(large)).mean() > 0.5


# ---- the way back


@pytest.mark.parametrize("motion", ["no-preference"])
def test_every_change_of_scene_is_a_step_back(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    shown.link()
    shown.page.evaluate(FEW)
    shown.page.click("[data-view=gap]")
    shown.settle()
    shown.link()
    shown.page.fill("input[type=number][name=lam]", "0.6")
    shown.until("() => explorer.state().lam === 0.6")
    shown.page.click("[data-view=chart]")  # at once: what was typed is kept with its scene
    shown.until("() => location.hash.includes('view=chart')")
    shown.page.select_option("#preset", "1.6")
    shown.until("() => location.hash.includes('view=oscillator')")
    shown.page.click("#tour")
    shown.until("() => location.hash.includes('tour=1')")
    shown.page.click("#next")
    shown.until("() => location.hash.includes('tour=2')")
    for wanted in ("tour === 1", "view === 'oscillator'", "view === 'chart'", "view === 'gap'", "view === 'ball'"):
        shown.page.go_back()
        shown.until(f"() => explorer.state().{wanted}")
        if "gap" in wanted:
            assert state(shown, "lam") == 0.6
    shown.page.go_forward()
    shown.until("() => explorer.state().view === 'gap'")
    assert shown.problem() == ""


@pytest.mark.parametrize("motion", ["no-preference"])
@LOADED  # a history has 50 steps at most
def test_moves_of_a_slider_are_no_steps(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20")
    shown.link()
    before = shown.page.evaluate("() => history.length")
    knob = shown.page.locator(".control[data-name=offset] input[type=range]")
    knob.focus()
    for _ in range(6):
        shown.page.keyboard.press("ArrowRight")
        shown.page.wait_for_timeout(180)
    shown.link()
    assert shown.page.evaluate("() => history.length") == before
