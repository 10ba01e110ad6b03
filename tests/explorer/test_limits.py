"""What the page does at the ends of what it can: narrow axes, long computations, parameters that a law does not have."""

import time

import pytest

from tests.explorer.browser import Shown


def state(page, key):
    return page.page.evaluate(f"() => explorer.state().{key}")


def texts(page, ticks):
    """The texts of an axis from plot.js."""
    return page.page.evaluate(
        "async ([low, high, about]) => { const { scaled } = await import('./plot.js'); const s = scaled(low, high, about);"
        " return [s.ticks.map(t => t.text), s.base, s.power]; }",
        list(ticks),
    )


# ---- narrow axes


def test_an_axis_too_narrow_for_double_precision_is_refused(shown, address):
    shown.open(f"{address}#version=1&view=gap&columns=20&bins=20&span=0.3:0.30000000000000004")
    assert "span=0.3:0.30000000000000004 is too narrow for double precision" in shown.problem()
    assert state(shown, "span") == [-0.1, 0.6]


@pytest.mark.parametrize("mu", [5000, 0])
def test_zooming_in_ends_where_double_precision_does(shown, address, mu):
    shown.open(f"{address}#version=1&view=gap&columns=8&bins=8&mu={mu}&span={mu - 1}:{mu + 1}")
    shown.page.focus("#gap-diagram")
    for _ in range(60):
        shown.page.keyboard.press("+")
    low, high = state(shown, "span")
    assert max(1e-12, 0.9e-10 * mu) <= high - low < max(1e-10, 1e-9 * mu) and low <= mu <= high
    shown.until("() => location.hash.includes(`span=${explorer.state().span.join(':')}`)")
    shown.page.reload()  # and its own link is taken
    shown.settle()
    assert (shown.problem(), state(shown, "span")) == ("", [low, high])


def test_the_numbers_of_an_axis_are_short_and_different(shown, address):
    shown.open(f"{address}#version=1&view=gap&columns=8&bins=8")
    assert texts(shown, (0.1, 0.5, 4)) == [["0.1", "0.2", "0.3", "0.4", "0.5"], 0, 0]
    assert texts(shown, (0.14, 0.14001, 5)) == [["0", "2", "4", "6", "8", "10"], 0.14, 6]
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
    shown.open(f"{address}#version=1&view=gap&columns=8&bins=8")
    found = shown.page.evaluate(
        "async () => { const { tonesOf } = await import('./diagram.js'); return [[2, 1e8], [600, 8000]].map("
        "([bins, total]) => { const { tones, scale } = tonesOf(bins, total); return [[...tones], scale]; }); }"
    )
    for (tones, _scale), entries in zip(found, (4100, 170), strict=True):
        assert len(tones) <= entries and tones[0] == 40 and tones[-1] == 255 and tones == sorted(tones)
    assert found[1][1] == 1  # where there are few counts each has a tone of its own


@pytest.mark.parametrize(
    ("heavy", "least"),  # the second has short jobs: it is enough to hold those that wait
    [
        ("view=gap&starts=1000&columns=4&bins=20&keep=100000", 1),
        ("view=chart&chart=oscillator&chart_columns=2000&chart_rows=2000", 0),
    ],
)
def test_a_view_that_is_left_gives_the_workers_back(shown, address, heavy, least):
    shown.page.goto(f"{address}#version=1&{heavy}")
    shown.until("() => globalThis.explorer?.views.gap && document.querySelector('canvas[data-stage]')")
    time.sleep(1)
    begun = time.monotonic()
    shown.page.evaluate(
        "location.hash = 'version=1&view=oscillator&columns=40&bins=40&flow_starts=2&flow_keep=20&reduced=no'"
    )
    shown.until("() => ['coarse', 'full', 'done'].includes(explorer.views.oscillator.diagram.stage)")
    assert time.monotonic() - begun < 3
    shown.settle()
    assert shown.page.evaluate("explorer.views.gap.diagram.pool.ended") >= least
