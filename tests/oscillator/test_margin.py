"""The rounding budget of the block kernel, held against ball arithmetic: no row of a table is off by its margin.

A row is affine in the pair (c1, c2), and so is the margin, in absolute values. So a table whose three numbers a row are
right to their parts of the margin is right for *every* pair: of a table, the whole range is covered. Models are drawn
from all that get a table; over these it is a sample.
"""

from math import pi

import numpy as np
import pytest
from flint import arb, arb_poly, ctx

import grazing as gz
from grazing.oscillator import cells
from grazing.oscillator.cells import (
    ALWAYS,
    CERTIFICATE,
    COUNT,
    MARGIN,
    MAX_DECAY,
    MAX_ROWS,
    NEVER,
    POINTS,
    ROW_COUNT,
    ROWS,
    fill_table,
    table_size,
)  # fmt: skip
from grazing.oscillator.taylor import cosh_root, sinhc_root
from tests.models import MODELS, packed
from tests.oscillator.shadow import exact, shadowed


def shares(model, monkeypatch):
    """Return the largest errors of the two kinds of rows as shares of the margin; none where there is no table.

    The height at an end of a cell matters for every pair: its three numbers are compared, each with its part of the
    margin. A chord matters for pairs between the two grazing states that it joins. Beyond them it may be off by more:
    in a window of hardly any length the two are one, and the slope of the chord is rounding.
    """
    chords = []

    def chord(f1, f2, g1, g2, h1, h2, band):
        row = plain_chord(f1, f2, g1, g2, h1, h2, band)
        chords.append((row[:3], (g1.exact, g2.exact), (h1.exact, h2.exact)))
        return row

    with shadowed(monkeypatch) as patch:
        patch.setattr(cells, "chord", chord)
        c = packed(gz.stroboscopic_map(model))
        t, x = [0.0] * table_size(len(c.cos)), [0.0] * (9 * POINTS)
        filled = fill_table(t, x, c, 1.0)
        if not filled:
            return ()
        margin = [exact(float(part)) for part in t[MARGIN : MARGIN + 3]]
        ends, joined = [arb(0)], [arb(0)]
        for start, count in ((CERTIFICATE, COUNT), (ROWS, ROW_COUNT)):
            for i in range(start, start + int(t[count])):
                p, q, r, place = (t[i + j * MAX_ROWS] for j in range(4))
                if float(r) < NEVER and place % 2 == 0:
                    ends += errors((r, p, q), margin)
        for (p, q, r), one, two in chords:
            if float(r) > ALWAYS:
                joined += [share((p, q, r), state, margin) for state in (one, *between(one, two), two)]
        return tuple(max(float(x.upper()) for x in found) for found in (ends, joined))


plain_chord = cells.chord


def errors(row, margin):
    """The errors of a row, each as a share of its part of the margin; a row says the same times a number near 1."""
    _size, largest = max((abs(float(x)) / float(part), i) for i, (x, part) in enumerate(zip(row, margin, strict=True)))
    factor = float(row[largest]) / exact(row[largest])
    assert abs(factor - 1) < 1e-6
    return [abs(factor * exact(x) - float(x)) / part for x, part in zip(row, margin, strict=True)]


def share(row, state, margin):
    """The error of a row at a pair, as a share of the margin there."""
    off = [exact(x) - float(x) for x in row]
    size = margin[0] + margin[1] * abs(state[0]) + margin[2] * abs(state[1])
    return abs(off[0] * state[0] + off[1] * state[1] + off[2]) / size


def between(one, two):
    """The pairs between two at which a coordinate vanishes: there the margin has its corners."""
    for a, b in zip(one, two, strict=True):
        if (a > 0 and b < 0) or (a < 0 and b > 0):
            part = a / (a - b)
            yield tuple(x + part * (y - x) for x, y in zip(one, two, strict=True))


def drawn(random):
    """Draw a model from everything that gets a table, in any unit of length and time, its corners more often."""
    T, length = 10.0 ** random.uniform(-4.0, 4.0, 2)
    kind = random.integers(8)
    damping = 0.0 if kind == 0 else 10.0 ** random.uniform(-12.0, np.log10(1.2 * MAX_DECAY))  # alpha T
    stiffness = 0.0 if kind == 1 else 10.0 ** random.uniform(-12.0, np.log10(2.0 * MAX_DECAY))  # k T
    if kind == 2:  # critical damping, and beside it
        damping = 2.0 * stiffness * (1.0 + random.choice([0.0, -1.0, 1.0]) * 10.0 ** random.uniform(-16.0, -2.0))
    if kind == 3:  # the longest decay that a table may have
        damping = MAX_DECAY * (1.0 + 10.0 ** random.uniform(-16.0, -1.0) * random.choice([-1.0, 1.0]))
        stiffness = 10.0 ** random.uniform(-6.0, 1.0)
    harmonics = int(random.integers(1, 5))
    if kind == 4:  # resonance of a harmonic
        damping = 10.0 ** random.uniform(-14.0, 0.0)
        stiffness = 2.0 * pi * random.integers(1, harmonics + 1) * (1.0 + 10.0 ** random.uniform(-16.0, -2.0))
    waves = random.normal(size=(2, harmonics)) * 10.0 ** random.uniform(-6.0, 0.0, (2, harmonics))
    waves[0, 0] = waves[0, 0] if waves.any() else 1.0
    offset = random.choice([-1.0, 1.0]) * np.abs(waves).sum() * 10.0 ** random.uniform(-6.0, 3.0)
    if kind == 5:  # windows that shrink to nothing
        phases = np.linspace(0.0, 2.0 * pi, 2001)
        force = sum(
            waves[0, j] * np.cos((j + 1) * phases) + waves[1, j] * np.sin((j + 1) * phases) for j in range(harmonics)
        )
        offset = -(force.max() if random.random() < 0.5 else force.min()) * (1.0 - 10.0 ** random.uniform(-15.0, -2.0))
    force = length / T**2
    return gz.Oscillator(
        alpha=damping / T,
        k=stiffness / T,
        forcing=gz.Forcing(
            omega=2.0 * pi / T,
            t0=0.0 if kind == 6 else T * random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-3.0, 4.0),
            offset=offset * force,
            cos=tuple(waves[0] * force),
            sin=tuple(waves[1] * force),
        ),
        sigma=0.0 if random.random() < 0.5 else length * random.normal(),
        reset=gz.newton(r=0.5),
    )


#: Largest part of the margin that the rows may use up; the rest is for the few roundings of asking them.
PART = 1.0 / 16.0


@pytest.mark.parametrize("name", [name for name in MODELS if name != "stiff"])
def test_rows_are_right_to_a_hundredth_of_the_margin(name, monkeypatch):
    assert max(shares(MODELS[name], monkeypatch)) < 0.01


def test_rows_of_any_table_are_right_to_a_part_of_the_margin(monkeypatch):
    random = np.random.default_rng(1)
    found = [shares(drawn(random), monkeypatch) for _ in range(60)]
    assert max(max(one) for one in found if one) < PART
    assert sum(not one for one in found) < 20


def test_a_row_that_is_off_by_a_millionth_is_noticed(monkeypatch):
    """What is compared is no copy of itself: a free flight that is wrong in the ninth digit uses up the margin."""
    from tests.oscillator import shadow

    right = shadow.exp
    monkeypatch.setattr(shadow, "exp", lambda x: shadow.Shadow(float(right(x)) * (1.0 + 1e-9), exact(right(x))))
    assert max(shares(MODELS["standard"], monkeypatch)) > 1.0


@pytest.mark.long
@pytest.mark.parametrize("seed", range(10))
def test_rows_of_ten_thousand_tables(seed, monkeypatch):
    random = np.random.default_rng([20, seed])
    found = [shares(drawn(random), monkeypatch) for _ in range(1000)]
    assert max(max(one) for one in found if one) < PART


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_nobody_who_climbs_leaves_the_margin(seed, monkeypatch):
    """From the worst of some models uphill, one change of the parameters after the other."""
    random = np.random.default_rng([30, seed])
    begun = (drawn(random) for _ in range(300))
    worst, model = max(((max(shares(m, monkeypatch), default=0.0), m) for m in begun), key=first)
    for _ in range(1000):
        moved = {
            name: abs(x) * (1.0 + random.normal() * 10.0 ** random.uniform(-12.0, 0.0)) * (1.0 if x >= 0.0 else -1.0)
            for name, x in model.params.items()
            if name != "r" and random.random() < 0.4
        }
        moved |= {name: abs(moved[name]) for name in ("alpha", "k", "omega") if name in moved}
        other = model.replace(**moved)
        share = max(shares(other, monkeypatch), default=0.0)
        worst, model = max((worst, model), (share, other), key=first)
    assert worst < PART


def first(pair):
    return pair[0]


@pytest.mark.parametrize(("function", "first_factorial", "said"), [(cosh_root, 0, 4.5e-17), (sinhc_root, 1, 5e-18)])
def test_what_a_polynomial_of_an_impact_leaves_out_on_its_whole_range(function, first_factorial, said):
    """The polynomial less the series is a polynomial itself, but for a tail: it is taken on balls that cover all."""
    with ctx.workprec(200):
        series = arb_poly([1 / arb(2 * n + first_factorial + 1).gamma() for n in range(14)])
        tail = 2 * arb(0.09) ** 14 / arb(29 + first_factorial).gamma()
        difference = function(arb_poly([0, 1])) - series
        pieces = 2000
        balls = (arb(0.09) / pieces * (2 * i + 1 - pieces) + arb(0, 1) * arb(0.09) / pieces for i in range(pieces))
        most = float(max((abs(difference(ball)) + tail).upper() for ball in balls))
    assert 0.5 * said < most < said  # the claim holds, and says no more than is so
