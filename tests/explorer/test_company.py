"""What keeps the ball company: all attractors with their shares, a twin that parts at a rate, and sweeps."""

import math
import re
from itertools import pairwise
from shlex import split

import numpy as np
import pytest

import grazing as gz
from grazing.cli.app import main
from tests.explorer.browser import LOADED


@pytest.fixture
def kept():
    return True


@pytest.fixture
def motion():
    return "no-preference"


BALL = "explorer.views.ball"
CHAOTIC = "alpha=0.2&omega=2.6&offset=0.14&V=0.1"


def faster(shown, speed=60):
    shown.page.evaluate(f"() => {{ {BALL}.speed = {speed}; }}")


# ---- attractors

#: What is written in the portrait, in order.
WRITTEN = f"""() => {{
  const {{ context: pen }} = {BALL}.axes, write = pen.fillText, seen = [];
  pen.fillText = (text) => seen.push(text);
  {BALL}.draw();
  {BALL}.diagram.draw();
  pen.fillText = write;
  return seen;
}}"""


@pytest.mark.parametrize("motion", ["reduce"])
def test_all_attractors_are_drawn_and_named_with_their_shares(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.1225")
    names, colours, flights = (
        shown.page.evaluate(f"() => {BALL}.orbits.map(o => o.{what})")
        for what in ("name", "colour", "flight.hits.length")
    )
    shares = {word: int(share) for word, share in (name.split(": ") for name in names)}
    assert shares.keys() == {"001", "0001"} and sum(shares.values()) == 16 and flights == [1, 1]
    said = shown.page.inner_text("#summary")
    for word, share in shares.items():
        assert re.search(rf"word {word}[;,].*\b{share} of 16 starts", said)
    # the same colours in the sentence, in the words below and in the portrait
    lead, below = (
        shown.page.evaluate(f"() => [...document.querySelectorAll('{where} i.chip')].map(i => i.style.backgroundColor)")
        for where in ("#lead", "#summary")
    )
    rgb = [f"rgb({', '.join(str(int(c[i : i + 2], 16)) for i in (1, 3, 5))})" for c in colours]
    assert lead == below == rgb
    painted = shown.page.evaluate(
        """() => {
          const canvas = document.getElementById("phase"), c = canvas.getContext("2d");
          const { data } = c.getImageData(0, 0, canvas.width, canvas.height), found = new Set();
          for (let i = 0; i < data.length; i += 4) found.add(`rgb(${data[i]}, ${data[i + 1]}, ${data[i + 2]})`);
          return [...found];
        }"""
    )
    assert set(rgb) <= set(painted)
    written = shown.page.evaluate(WRITTEN)
    assert [text for text in written if "0" in text or "starts" in text][-3:] == [*names, "of 16 starts"]
    shown.page.evaluate(f"() => {{ {BALL}.orbits = Array(6).fill({BALL}.orbits[0]); }}")
    assert shown.page.evaluate(WRITTEN)[-1] == "… of 16 starts"  # for all six there is no room


def test_the_ball_takes_the_colour_of_the_orbit_it_is_on(shown, address):
    """At d = 0.1225 two orbits live: the ball that came from below is on 001, and its letters say so in its colour."""
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.1225&ball=0.1171906:0.2250153:0")
    faster(shown)
    shown.until(f"() => {BALL}.now > 30 * {BALL}.T")
    heard = shown.page.evaluate(f"() => {BALL}.past.heard({BALL}.classes).word")
    letters = dict(shown.page.evaluate(f"() => [...{BALL}.past.letters]"))
    word = "".join(str(letters[n]) for n in sorted(letters)[1:-1])
    assert heard in {"001", "0001"} and heard in word
    assert word.count("1") == pytest.approx(len(word) / len(heard), abs=1.1)


# ---- the twin


#: The rate over so many turns from a state, by the class of the page and the module's map.
MEASURED = """async ([u, v, turns]) => {
  const { Rate } = await import("./twin.js"), { machine, model } = explorer.views.ball, rate = new Rate();
  const turn = (u, v) => [...machine.call("orbits", { columns: 1, starts: 1, keep: 1, rows: model.row,
    lanes: Float64Array.of(u, v), transient: 0 }, ["points"]).points];
  const above = (at) => Math.max(at, model.walls.sigma);
  for (let n = 0; n < turns; n++, [u, v] = turn(u, v)) rate.pass([u, v], turn, above, 0.5);
  return rate.exponent;
}"""


@pytest.mark.parametrize("motion", ["reduce"])
@pytest.mark.parametrize(
    ("given", "model", "close"),
    [
        ("offset=0.12&V=0.4", gz.pinball(d=0.12, V=0.4), 0.02),  # a periodic orbit: its multipliers say the rate
        ("offset=0.14&V=0.4", gz.pinball(d=0.14, V=0.4), 1e-3),  # no impact
        (CHAOTIC, gz.pinball(alpha=0.2, omega=2.6, d=0.14, V=0.1), 0.15),  # chaos: over so many turns
    ],
)
def test_the_rate_is_the_lyapunov_exponent_of_python(shown, address, given, model, close):
    shown.open(f"{address}#version=2&view=ball&columns=20&{given}")
    want = float(gz.lyapunov(gz.stroboscopic_map(model), starts=3)["exponent"].values[:, 0].mean())
    found = shown.page.evaluate(MEASURED, [0.2, 0.1, 1500])
    assert math.isclose(found, want, rel_tol=close) and (want > 0) == (given == CHAOTIC)


def test_balls_part_where_orbits_are_chaotic(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&{CHAOTIC}&twin=yes")
    faster(shown)
    pixels = f"() => {{ const {{ company, place, strip: {{ axes }} }} = {BALL}; company.begin(); "
    pixels += "return Math.abs(axes.y(company.twin.place[0]) - axes.y(place[0])); }"
    assert shown.page.evaluate(pixels) < 4  # it begins behind the ball
    height = shown.page.evaluate(f"() => {BALL}.axes.x1")
    apart = f"() => Math.abs({BALL}.company.twin.place[0] - {BALL}.place[0])"
    shown.until(f"{apart} > {0.3 * height}")  # it is seen
    shown.until(f"() => {BALL}.company.rate.turns >= 60")
    shown.until("() => document.getElementById('rate').textContent.includes('The twin parted within')")
    shown.until(f"() => {BALL}.company.rate.turns >= 100")  # enough to say how sure it is
    assert re.search(r"^λ = 0\.\d+ ± 0\.\d+ a push \(the next \d+\): near balls part\.", shown.page.inner_text("#rate"))


#: Seconds until the twin is a tenth of the picture from the ball, thrown at nine times of the forcing.
PARTING = f"""() => {{
  const ball = {BALL}, found = [], ask = requestAnimationFrame, due = [];
  let at = performance.now();
  globalThis.requestAnimationFrame = (then) => due.push(then); // the page's clock is turned by hand
  cancelAnimationFrame(ball.frame);
  ball.frame = 0;
  ball.speed = 10; // a long frame, too, is less than a turn
  for (let i = 0; i < 9; i++) {{
    ball.state.ball = [0.03, 0, (i * ball.T) / 9];
    ball.begin();
    const begun = ball.turn;
    ball.play(true);
    let far;
    for (let frames = 0; !far && frames < 900; frames++) {{
      at += 100;
      for (const each of due.splice(0)) each(at);
      far = ball.company.twin.distances.find(([, log]) => log > Math.log(0.1));
    }}
    found.push((far[0] - begun) / 0.7);
  }}
  globalThis.requestAnimationFrame = ask;
  ball.play(true);
  for (const each of due) ask(each);
  return found;
}}"""


def test_balls_are_seen_to_part_within_seconds_and_are_found_apart_later(shown, address):
    link = "omega=6&V=0&offset=-0.2&reach=-0.3:0"  # the exercise on chaos
    shown.open(f"{address}#version=2&view=ball&columns=20&{link}")
    shown.until(f"() => {BALL}.classes.length")
    shown.page.click("#twin")
    faster(shown)
    shown.until(f"() => {BALL}.company.twin.parted")
    parted, logs = shown.page.evaluate(f"() => [{BALL}.company.twin.parted, {BALL}.company.twin.distances]")
    begun = logs[0][0]
    visible = next(turn for turn, log in logs if log > math.log(0.1))
    assert logs[0][1] < math.log(0.02) and visible - begun <= parted
    assert "The twin parted within" in shown.page.inner_text("#rate")
    shown.until(f"() => {BALL}.turn > {logs[-1][0] + 6}")  # the ball goes on, and nobody puts the twin beside it again
    assert shown.page.evaluate(f"() => {BALL}.playing")
    assert shown.page.evaluate(f"() => {BALL}.company.twin.parted") == parted
    shown.page.evaluate(f"() => {{ {BALL}.speed = 1; }}")  # else they have parted again before anybody looks
    shown.page.click("#settle")
    shown.until(f"() => {BALL}.company.twin.parted === 0")
    seconds = sorted(shown.page.evaluate(PARTING))
    assert seconds[0] > 0.0 and seconds[4] < 8.0 and seconds[8] < 20.0, seconds


def test_hops_that_chatter_accumulate_as_they_are_stepped_through(shown, address):
    shown.open(f"{address}#version=2&view=ball&V=0&r=0.7&offset=-0.5&reach=-0.6:0.1&columns=20")
    shown.until(f"() => {BALL}.classes.length")
    thrown = f"{BALL}.state.ball = [1e-9, 0.2064, 1.2018]"  # a pause leaves the ball where it was just then
    shown.page.evaluate(f"() => {{ {BALL}.play(false); {thrown}; {BALL}.begin(); }}")
    said = []
    shown.page.evaluate(
        "() => { const pen = explorer.views.ball.strip.axes.context, write = pen.fillText;"
        " pen.fillText = (t, ...at) => { if (/impact/.test(t)) globalThis.counted = t; write.call(pen, t, ...at); }; }"
    )
    for _ in range(9):
        shown.page.click("#step")
        said.append(shown.page.evaluate("() => globalThis.counted.split('· ')[1]"))
    assert said == ["1 impact", *(f"{n} impacts" for n in range(2, 10))]
    # from near: the marks of seven of them are told apart
    xs = shown.page.evaluate(f"() => {BALL}.past.marks.slice(-9).map(m => {BALL}.strip.axes.x(m.turn))")
    assert sum(b - a > 2 for a, b in pairwise(xs)) >= 7
    shown.page.click("#play")
    shown.until("() => globalThis.counted.includes('∞')")


@pytest.mark.parametrize("motion", ["reduce"])
def test_the_ball_is_below_the_words_at_the_top_of_its_swing(shown, address):
    shown.open(f"{address}#version=2&view=ball&offset=0.14&columns=20&tour=2")
    shown.until(f"() => {BALL}.classes.length")
    highest = f"() => {BALL}.strip.axes.y(Math.max(...{BALL}.attractor.u))"
    assert shown.page.evaluate(highest) - 17 > 26


def test_balls_come_together_on_a_periodic_orbit(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&twin=yes")
    faster(shown)
    shown.until(f"() => {BALL}.company.rate.turns >= 100")
    assert re.search(r"^λ = −0\.\d+ ± 0\.\d+ a push .*: near balls come together", shown.page.inner_text("#rate"))
    shown.until(f"() => Math.abs({BALL}.company.twin.place[0] - {BALL}.place[0]) < 1e-3")


@LOADED
def test_every_push_counts_once_however_long_frames_take(shown, address):
    """Frames of 100 ms and more, as on a busy machine, end at a push now and then, but for rounding."""
    shown.page.add_init_script("let at = 0; window.requestAnimationFrame = (f) => setTimeout(() => f((at += 100)), 1);")
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    faster(shown, 10)
    shown.page.evaluate(f"() => {{ {BALL}.begin(); {BALL}.visited = []; }}")
    shown.until(f"() => {BALL}.now > 60 * {BALL}.T")
    visited, pushes = shown.page.evaluate(f"() => [{BALL}.visited.length, {BALL}.now / {BALL}.T]")
    assert abs(visited - pushes) < 1.0


def test_the_way_to_the_orbit_is_not_measured(shown, address):
    """While the search for the orbit takes long, the ball flies from elsewhere, past a graze that parts it."""
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12")
    shown.page.evaluate(f"() => {{ const ball = {BALL}; ball.change({{ twin: true }}); ball.home = [0.1, 0, 0]; }}")
    shown.page.evaluate(f"() => {BALL}.begin()")
    faster(shown)
    shown.until(f"() => {BALL}.company.rate.turns === 1000")
    way = shown.page.evaluate(f"() => {BALL}.company.rate.exponent")
    shown.page.evaluate(f"() => {BALL}.search.told.found()")
    shown.until(f"() => {BALL}.company.rate.turns === 1000")
    assert shown.page.evaluate(f"() => {BALL}.company.rate.exponent") != way
    assert re.search(r"^λ = −0\.\d+ ± 0\.\d+ a push .*: near balls come together", shown.page.inner_text("#rate"))


def test_the_rate_is_that_of_the_parameters_now(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&twin=yes")
    for d in (0.12, 0.125):
        shown.page.fill("input[type=number][name=offset]", str(d))
        shown.until(f"() => {BALL}.company.rate.turns === 1000")
        want = float(gz.lyapunov(gz.stroboscopic_map(gz.pinball(d=d, V=0.4)), starts=3)["exponent"].values[:, 0].mean())
        assert shown.page.evaluate(f"() => {BALL}.company.rate.exponent") == pytest.approx(want, rel=0.03)
    assert shown.page.evaluate(f"() => {BALL}.now / {BALL}.T") < 60  # what is to come is measured, and not waited for
    shown.page.click("#twin")
    shown.until(f"() => {BALL}.company.twin === null && !location.hash.includes('twin')")
    assert shown.page.inner_text("#rate") == ""


def test_a_ball_that_is_stopped_is_measured_to_the_end(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&twin=yes")
    shown.until(f"() => {BALL}.company.rate.turns")
    shown.page.evaluate(f"() => {{ {BALL}.play(true); {BALL}.company.begin(); {BALL}.play(false); }}")
    shown.until(f"() => {BALL}.company.rate.turns === 1000")


def test_chatter_brings_balls_together_without_end(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&sigma=-0.3&V=0&r=0.3&offset=-0.5&twin=yes")
    faster(shown)
    shown.until(f"() => {BALL}.company.rate.turns >= 3")
    assert "λ = −∞" in shown.page.inner_text("#rate")


@pytest.mark.parametrize("motion", ["reduce"])
def test_how_sure_the_rate_is_is_said_with_it(shown, address):
    """Of chaos the mean of independent runs lies within a few of the errors that each says."""
    shown.open(f"{address}#version=2&view=ball&columns=20&{CHAOTIC}")
    measured = MEASURED.replace("return rate.exponent", "return [rate.exponent, rate.error]")
    runs = [shown.page.evaluate(measured, [u, v, 400]) for u, v in ((0.2, 0.1), (0.3, -0.1), (0.15, 0.3), (0.25, 0.0))]
    model = gz.pinball(alpha=0.2, omega=2.6, d=0.14, V=0.1)
    want = float(gz.lyapunov(gz.stroboscopic_map(model), starts=8, steps=4000)["exponent"].values[:, 0].mean())
    assert all(0.0 < error < 0.2 * want and abs(rate - want) < 4 * error for rate, error in runs), (runs, want)


def test_a_twin_that_parts_on_a_stable_orbit_is_explained_and_stops_nothing(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&twin=yes")
    shown.until(f"() => {BALL}.company.rate.turns >= 100")
    shown.page.evaluate(f"() => {{ Object.assign({BALL}.company.twin, {{ parted: 2.4, met: 6.1 }}); }}")
    told = (
        "The twin, begun 1 % of the picture away, too far for that, parted within 3 pushes. It was back after 7 pushes."
    )
    shown.until(f"() => document.getElementById('rate').textContent.endsWith('{told}')")
    assert shown.page.evaluate(f"() => {BALL}.playing")


# ---- sweeps


@pytest.mark.parametrize("motion", ["reduce"])
def test_sweeps_follow_one_ball_as_in_python_and_differ_where_two_orbits_live(shown, address, tmp_path):
    shown.open(f"{address}#version=2&view=ball&columns=80&reach=0.118:0.128")
    plain = shown.pixels("ball-diagram")
    shown.page.click("#sweeps")
    shown.until(f"() => {BALL}.company.sweeps.found")
    shown.until("() => location.hash.includes('sweeps=yes')")
    assert shown.pixels("ball-diagram") != plain
    values, up, down = (
        np.array(shown.page.evaluate(f"() => [...{BALL}.company.sweeps.found.{name}]"))
        for name in ("values", "up", "down")
    )
    known = {}
    exec(shown.page.evaluate("() => explorer.texts().python").replace("gz.plot.save", "(lambda *_: None)"), known)
    kept = len(up) // len(values)
    up, down = up.reshape(-1, kept), down.reshape(-1, kept)
    np.testing.assert_array_equal(values, known["result"]["up"]["d"])
    np.testing.assert_array_equal(up, known["result"]["up"]["u"][:, 0])
    np.testing.assert_array_equal(down, known["result"]["down"]["u"][:, 0])
    for line, want in zip(shown.page.evaluate("() => explorer.texts().command").split("\n"), (up, down), strict=True):
        words = split(line)
        words[-1] = str(tmp_path / "way.nc")
        assert main([*words[1:], "--quiet"]) == 0
        np.testing.assert_array_equal(gz.load(tmp_path / "way.nc")["u"][:, 0], want)
    # where the diagram is two orbits, one is kept on the way up and the other on the way down
    period = lambda row: next((N for N in range(1, kept) if np.allclose(row[N:], row[:-N], atol=1e-6)), 0)  # noqa: E731
    middle = np.argmin(np.abs(values - 0.1225))
    assert (period(up[middle]), period(down[middle])) == (3, 4)
    said = re.search(r"different orbits for ([\d.]+) ≤ d ≤ ([\d.]+): hysteresis", shown.page.inner_text("#summary"))
    assert "shaded: hysteresis" in shown.page.evaluate(WRITTEN.replace("axes", "diagram.axes", 1))
    low, high = map(float, said.groups())
    apart = [v for v, a, b in zip(values, up, down, strict=True) if {period(a), period(b)} == {3, 4}]
    assert math.isclose(low, min(apart), rel_tol=1e-3) and math.isclose(high, max(apart), rel_tol=1e-3)
    assert (period(up[0]), period(down[0])) == (3, 3) and (period(up[-1]), period(down[-1])) == (4, 4)


@pytest.mark.parametrize("motion", ["reduce"])
def test_sweeps_of_the_wall_stay_above_it(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=40&vary=sigma&reach=-0.2:0.1&sweeps=yes")
    shown.until(f"() => {BALL}.company.sweeps.found")
    values, up = (
        np.array(shown.page.evaluate(f"() => [...{BALL}.company.sweeps.found.{n}]")) for n in ("values", "up")
    )
    rows = up.reshape(len(values), -1)
    assert np.isfinite(rows).all() and (rows >= values[:, None] - 1e-12).all()
