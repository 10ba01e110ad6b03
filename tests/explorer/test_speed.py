"""How much work the page does for a picture, counted: seconds are measured by `python -m benchmarks explorer`."""

import numpy as np
import pytest

from grazing.explorer.oscillator import FIELDS as OSCILLATOR


@pytest.fixture
def motion():
    return "no-preference"


#: Of a diagram: the jobs sent to the workers, and its pictures as they come, with the state and what they hold.
WATCH = """
(view) => {
  const {diagram} = explorer.views[view];
  const seen = globalThis.seen = {jobs: [], pictures: []};
  const send = Worker.prototype.postMessage;
  Worker.prototype.postMessage = function (message, ...more) {
    const {job, given, id} = message;
    const columns = given?.values?.length ?? 1, steps = given?.starts * (given?.transient + given?.keep);
    if (job) seen.jobs.push({job, columns, steps, row: [...given.row], id});
    return send.call(this, message, ...more);
  };
  const {batch} = diagram.pool; // what the page computes itself
  diagram.pool.batch = (channel) => {
    const made = batch(channel), {now} = made;
    if (now) made.now = (machine, job, given) => {
      seen.jobs.push({job, columns: given.values.length, steps: given.starts * (given.transient + given.keep),
        row: [...given.row], id: -1});
      return now(machine, job, given);
    };
    return made;
  };
  let last;
  const paint = diagram.paint.bind(diagram);
  diagram.paint = () => {
    paint();
    if (diagram.stage !== "coarse" || diagram.drawn === last) return;
    last = diagram.drawn;
    seen.pictures.push({row: [...last.row], points: diagram.counts.reduce((sum, count) => sum + count, 0)});
  };
}
"""
#: Moves a slider in every frame.
DRAG = """
([name, values]) => new Promise((done) => {
  const slider = document.querySelector(`input[name=${name}]`).closest(".control").querySelector("input[type=range]");
  const move = () => {
    if (!values.length) return done();
    slider.value = String(values.shift());
    slider.dispatchEvent(new Event("input", {bubbles: true}));
    requestAnimationFrame(move);
  };
  move();
})
"""


def moved(shown, name, values):
    shown.page.evaluate(DRAG, [name, list(values)])
    shown.settle()
    return shown.page.evaluate("seen")


def workers(shown, view):
    return shown.page.evaluate(f"explorer.views.{view}.diagram.pool.workers.length")


def test_the_first_picture_of_the_gap_map_has_a_million_iterates(shown, address):
    shown.open(f"{address}#version=2&view=gap")
    shown.page.evaluate(WATCH, "gap")
    seen = moved(shown, "l", [0.25])
    (picture,) = seen["pictures"]
    # one job in the page, or one for each worker where the page is too slow, and nothing before
    first = seen["jobs"][: 1 if seen["jobs"][0]["id"] == -1 else workers(shown, "gap")]
    assert sum(job["columns"] for job in first) == 800
    assert sum(job["columns"] * job["steps"] for job in first) == 998_400
    assert picture["points"] == 800 * 4 * 112 and picture["row"][2] == 0.25
    rest = [job for job in seen["jobs"][len(first) :] if job["job"] == "raster"]
    assert sum(job["columns"] * job["steps"] for job in rest) == 800 * 16 * 1000
    assert max(job["columns"] * job["steps"] for job in rest) <= 5e5  # a new picture waits for no more than this


def test_the_pictures_of_the_oscillator(shown, address):
    shown.open(f"{address}#version=2&view=oscillator&columns=20&reduced=no")
    shown.page.evaluate(WATCH, "oscillator")
    shown.open(f"{address}#version=2&view=oscillator&columns=1000&reduced=no&V=0.3")  # what takes long, once
    seen = shown.page.evaluate("seen")
    (picture,) = seen["pictures"]
    jobs = [job for job in seen["jobs"] if job["job"] != "found"]  # what starts settle on, on a busy machine
    first = jobs[: 1 if jobs[0]["id"] == -1 else workers(shown, "oscillator")]
    assert picture["row"][OSCILLATOR.index("V")] == 0.3
    assert sum(job["columns"] * job["steps"] for job in first) == 63 * 4 * 90  # every sixteenth
    assert {job["job"] for job in first} == {"points"}  # the same orbits say how high the picture is
    rest = jobs[len(first) :]
    assert sum(job["columns"] for job in rest) == 1000
    # what settles an orbit is done once, for its points and for its period
    assert {job["job"] for job in rest} == {"raster"}
    assert sum(job["columns"] * job["steps"] for job in rest) == 1000 * 8 * 184
    assert max(job["columns"] * job["steps"] for job in rest) <= 15_000


def test_a_slider_that_is_dragged_shows_every_picture_that_it_began(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=200")
    shown.page.evaluate(WATCH, "gap")
    values = np.round(np.linspace(0.05, 0.6, 40), 3)
    seen = moved(shown, "l", values)
    begun = {job["row"][2] for job in seen["jobs"]}
    assert [picture["row"][2] for picture in seen["pictures"]] == sorted(begun)
    skipped = shown.page.evaluate("explorer.views.gap.diagram.skipped")
    assert (
        len(begun) + skipped >= len(values) - 1 and values[-1] in begun
    )  # of two events in a frame one may be left out
    assert all(picture["points"] == 200 * 4 * 112 for picture in seen["pictures"])


def test_refinement_makes_way_for_a_new_picture(shown, address):
    shown.open(f"{address}#version=2&view=gap&columns=400&starts=100")  # the whole picture takes long
    shown.page.evaluate(WATCH, "gap")
    shown.page.evaluate(DRAG, ["l", [0.3]])
    shown.until("() => explorer.views.gap.diagram.stage === 'coarse'")
    seen = moved(shown, "l", [0.4])
    rows = [job["row"][2] for job in seen["jobs"]]
    assert 0.3 in rows and rows.index(0.4) > 0
    assert set(rows[rows.index(0.4) :]) == {0.4}  # no job of the picture before is begun any more
    assert rows.count(0.3) < rows.count(0.4)


def test_the_ball_moves_by_the_time_of_every_frame(shown, address):
    shown.open(f"{address}#version=2&view=ball&columns=20&offset=0.12&V=0.4")
    shown.until("() => explorer.views.ball.now > 0.5")
    frames = shown.page.evaluate(
        """() => new Promise((done) => {
          const {ball} = explorer.views, frames = [], {call} = ball.machine;
          let calls = 0;
          ball.machine.call = function (...given) { calls++; return call.apply(this, given); };
          const tick = (at) => {
            frames.push([at, ball.now, calls]);
            calls = 0;
            if (frames.length < 91) requestAnimationFrame(tick);
            else { ball.machine.call = call; done(frames); }
          };
          requestAnimationFrame(tick);
        })"""
    )
    at, now, calls = np.array(frames).T
    T = shown.page.evaluate("explorer.views.ball.T")
    steps = np.minimum(np.diff(at), 100.0) / 1000.0 * 0.7 * T
    np.testing.assert_allclose(np.diff(now), steps, atol=1e-9)
    assert calls[1:].max() <= 2  # the flight further ahead, now and then, and the places to draw
    assert calls[1:].sum() < 1.2 * 90


#: Ten minutes of play in frames of a tenth of a second, a minute at a call: the page's clock is turned by hand.
BALL = """
() => {
  const { ball } = explorer.views;
  let at = globalThis.at ?? 0;
  globalThis.requestAnimationFrame = (then) => { globalThis.frame = then; return 1; };
  ball.frame = 0;
  ball.play(true);
  for (let i = 0; i < 600; i++) { const then = globalThis.frame; globalThis.frame = null; then?.((at += 100)); }
  globalThis.at = at;
}
"""
TABLE = """
() => {
  for (let i = 0; i < 3600; i++) {
    if (!pinball.game().alive) { pinball.plunge(0.5 + 1e-4 * (i % 4000)); pinball.pause(); pinball.split(); }
    if (i % 7 === 0) pinball.press(i % 2, (i / 7) % 4 < 2);
    if (i % 500 === 0) pinball.nudge(0, 1);
    pinball.step(1 / 60);
  }
}
"""


@pytest.mark.long
@pytest.mark.parametrize("coarse", [False], ids=["whole"])
@pytest.mark.parametrize(
    ("page", "ready", "minute", "memory"),
    [
        ("index.html#version=2&view=ball&offset=0.1225&twin=yes", "explorer.views.ball.now > 0.1", BALL,
         "explorer.views.ball.machine"),
        ("index.html#version=2&view=ball&omega=6&V=0&offset=-0.2&twin=yes", "explorer.views.ball.now > 0.1", BALL,
         "explorer.views.ball.machine"),
        ("table.html", "pinball.exits()?.side === 320", TABLE, "pinball.game().machine"),
    ],
    ids=["ball", "chaos", "table"],
)  # fmt: skip
def test_memory_is_steady_over_ten_minutes(shown, address, page, ready, minute, memory):
    shown.page.goto(f"{address.removesuffix('index.html')}{page}")
    shown.until(f"() => globalThis.{ready.split('.')[0].split('(')[0]} && {ready}")
    session = shown.page.context.new_cdp_session(shown.page)

    def used():
        session.send("HeapProfiler.collectGarbage")
        kernels = shown.page.evaluate(f"() => {memory}.exports.memory.buffer.byteLength")
        return session.send("Runtime.getHeapUsage")["usedSize"], kernels

    sizes = []
    for _ in range(10):
        shown.page.evaluate(minute)
        sizes.append(used())
    print(sizes)
    heap, kernels = np.array(sizes).T
    assert kernels[-1] == kernels[1]
    assert max(heap[5:]) < max(heap[1:5]) + 200_000, sizes


#: Impacts in a period between two walls at d = 0.12, and on one that kicks what is pressed on it, counted, and as the
#: page estimates them; a letter of one wall is a count.
COUNTED = """async () => {
  const {machine, state} = explorer.views.oscillator;
  const {crossings} = await import("./walls.js"), {rowOf} = await import("./flow.js");
  const count = (k) => (k > 0 ? 1 + count(Math.floor(k / 3)) : 0);
  const counted = (each, u, count) => {
    const {letters} = machine.call("orbits", {columns: 1, starts: 1, keep: 25, rows: rowOf(machine, each),
      lanes: Float64Array.of(u, 0.1), transient: 12}, ["letters"]);
    return [letters.reduce((sum, k) => sum + count(k), 0) / 25, crossings(each)];
  };
  const one = [{offset: -10}, {offset: -100}, {offset: -100, V: 0.1}, {sigma: 50}, {sigma: 20, k: 3}, {offset: -1e4}];
  const alone = one.map((part) => counted({...state, ...part}, (part.sigma ?? 0) + 0.05, (k) => k));
  return [...alone, ...[[0.12, 0.4, 0], [0.2, 0.4, 0.2], [0.5, 0.4, 0.4], [0.15, 0, 0], [1.5, 0.2, 0],
    [0.2, 0, 0, 0.5], [0.5, 0, 0, 0.5]].map(([sigma_B, V, V_B, cos_A = 0]) => {
    const each = {...state, two: true, sigma_B, V, V_B, cos_A, alpha: 0.1, omega: 2.6};
    return counted(each, 0.05 + cos_A, count);
  })];
}"""


def test_the_page_knows_how_often_walls_are_hit(shown, address):
    shown.page.goto(f"{address}#version=2&view=oscillator&columns=20")
    shown.settle()
    for counted, guessed in shown.page.evaluate(COUNTED):
        assert guessed < 3.0 * max(counted, 1.0) and counted < 3.0 * max(guessed, 1.0), (counted, guessed)


@pytest.mark.parametrize("view", ["ball", "oscillator"])
@pytest.mark.parametrize("pressed", ["offset=-10000", "sigma=1e100"])
def test_a_ball_that_is_pressed_on_a_wall_that_kicks_does_not_keep_the_page(shown, address, view, pressed):
    """The page counted one impact in a period where there are thousands, and did by itself what takes minutes."""
    shown.page.goto(f"{address}#version=2&view={view}&vary=r&reach=0.5:0.9&columns=20&{pressed}")
    shown.until("() => new Promise((done) => requestAnimationFrame(() => setTimeout(() => done(true), 300)))")


def test_a_picture_that_takes_long_begins_with_few_orbits_and_says_how_far_it_is(shown, address):
    shown.page.goto(f"{address}#version=2&view=oscillator&columns=20")
    shown.settle()
    shown.page.evaluate(WATCH, "oscillator")
    shown.page.evaluate("""() => {
      const {context} = explorer.views.oscillator.diagram.axes, fill = context.fillText;
      globalThis.said = [];
      context.fillText = function (text, ...at) { said.push(text); return fill.call(this, text, ...at); };
    }""")
    shown.page.goto(f"{address}#version=2&view=oscillator&two=yes&sigma_B=0.12&V_B=0&columns=400")
    shown.until("() => said.some(text => /^[1-9]\\d? %$/.test(text))")
    jobs = shown.page.evaluate("seen.jobs.filter(({job}) => job === 'points' || job === 'raster')")
    first = jobs[0]["steps"]
    assert sum(job["columns"] * job["steps"] for job in jobs if job["steps"] == first) <= 2500  # periods
    shown.page.goto(f"{address}#version=2&view=oscillator&columns=20")
    shown.settle()
    shown.page.evaluate("said.length = 0; explorer.views.oscillator.diagram.draw()")
    assert not shown.page.evaluate("said.some(text => /%/.test(text))")


#: The cells of a chart in the order in which they are computed, by their values along the axes.
CELLS = """
() => {
  globalThis.cells = [];
  const send = Worker.prototype.postMessage;
  Worker.prototype.postMessage = function (message, ...more) {
    if (["chart", "basins"].includes(message.job)) cells.push(...message.given.values);
    return send.call(this, message, ...more);
  };
}
"""


@pytest.mark.parametrize("chart", ["gap", "basins"])
def test_a_chart_computes_each_cell_once_and_boundaries_first(shown, address, chart):
    W, H = 72, 40
    shown.open(f"{address}#version=2&view=edges")
    shown.page.evaluate(CELLS)
    shown.open(f"{address}#version=2&view=chart&chart={chart}&chart_columns={W}&chart_rows={H}&offset=0.1225")
    x, y = np.reshape(shown.page.evaluate("cells"), (-1, 2)).T
    assert len(x) == W * H
    i, j = (np.unique(ends, return_inverse=True)[1] for ends in (x, y))
    assert len(set(zip(i, j, strict=True))) == W * H
    first = (W // 8) * (H // 8)
    assert set(i[:first] % 8) == {0} and set(j[:first] % 8) == {0}
    when = np.empty((H, W))
    when[j, i] = np.arange(W * H)
    codes = np.reshape(shown.page.evaluate("() => [...explorer.views.chart.codes]"), (H, W))
    edge = np.zeros((H, W), bool)
    edge[:, 1:] |= codes[:, 1:] != codes[:, :-1]
    edge[1:] |= codes[1:] != codes[:-1]
    assert 0.02 < edge.mean() < 0.6
    assert when[edge].mean() < 0.7 * when[~edge].mean()
