"""The contact rule and the searches for a contact: the lemma, chatter bounds, every branch, compiled and plain."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import grazing as gz
from grazing.kernel.compile import compiled
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator import contact
from grazing.oscillator.constants import forcing
from grazing.oscillator.contact import (
    NO_LAUNCH,
    Ball,
    carried,
    next_contact,
    next_launch,
    placed,
    window_of,
    window_sign,
)
from grazing.oscillator.departure import FLIES, LIES, RELEASED, chatter_completes, departure_of
from grazing.oscillator.flight import anchored, flight
from grazing.outcome import BAD_LAW, CHATTER, OK, STUCK
from tests.examples import examples
from tests.models import PLAIN, packed


def constants_for(name):
    return packed(stroboscopic_map(PLAIN[name]))


@pytest.mark.parametrize("name", PLAIN)
def test_no_scan_finds_an_earlier_contact(name):
    """A fine scan of the free flight never sees the ball below the wall before the contact that was found."""
    c = constants_for(name)
    rng = np.random.default_rng(3)
    for _ in range(25):
        y, v = float(rng.uniform(1e-3, 0.3)), float(rng.uniform(-0.5, 0.5))
        hit, ball, *_ = next_contact(placed(0.0, y, v, 0), c)
        t = ball.t
        first, then = 0.0, anchored(0.0, y, v, c)
        scan = np.array([flight(float(s), then, c)[0] for s in np.linspace(first, t, 400)])
        if c.q2 >= 0.0 or c.spread * c.T < 40.0:
            assert scan.min() >= -2e-14 * max(1.0, c.size)
        if hit:
            assert ball.v <= 0.0
            assert ball.y == 0.0
            assert abs(flight(t, then, c)[0]) <= 1e-13 * max(1.0, c.size)
            assert ball.i == window_of(t, 0, c) or c.edges[ball.i + 1] >= t
        else:
            assert t == c.T


@given(
    alpha=st.floats(0.0, 8.0),
    k=st.floats(0.0, 8.0),
    offset=st.floats(-2.0, 2.0),
    y=st.floats(1e-6, 1.0),
    v=st.floats(-2.0, 2.0),
)
@settings(max_examples=examples(60))
def test_lemma_one_contact_in_a_window_of_one_sign(alpha, k, offset, y, v):
    """In a window with F < 0 a flight from above crosses the wall at most once; with F > 0 it has one low point."""
    c = packed(stroboscopic_map(gz.pinball(alpha=alpha, k=k, d=offset)))
    for i in range(len(c.edges) - 1):
        length = min(c.edges[i + 1] - c.edges[i], c.piece)
        if length <= 1e-6:
            continue
        a = anchored(c.edges[i], y, v, c)
        s = np.linspace(0.0, length, 200)
        flown = np.array([flight(float(x), a, c) for x in s])
        above = flown[:, 0] > 1e-13
        if window_sign(i, c) < 0.0:
            changes = np.flatnonzero(np.diff(above.astype(int)))
            assert len(changes) <= 1
        else:
            psi = np.array([contact.slope_of_phi(float(x), length, c) for x in s])
            g = flown[:, 1] - psi * flown[:, 0]
            rising = g > 1e-12 * (1.0 + np.abs(psi))
            falling = g < -1e-12 * (1.0 + np.abs(psi))
            assert not (np.flatnonzero(falling).max(initial=-1) > np.flatnonzero(rising).min(initial=999))


def test_window_of_looks_forward_only_to_real_edges():
    c = constants_for("standard")
    edges = [edge for edge in c.edges if 0.0 < edge < c.T]
    assert len(edges) == 2
    assert [window_of(t, 0, c) for t in (0.0, edges[0], edges[1], c.T)] == [0, 1, 2, 2]
    assert [window_sign(i, c) for i in range(3)] == [1.0, -1.0, 1.0]
    for i in range(3):
        middle = 0.5 * (c.edges[i] + c.edges[i + 1])
        assert np.sign(forcing(middle, c)[0]) == window_sign(i, c)


@given(w=st.floats(1e-9, 0.1), ratio=st.floats(0.0, 0.8), where=st.floats(0.0, 0.8))
@settings(max_examples=examples(80), suppress_health_check=[HealthCheck.filter_too_much])
def test_chatter_that_is_said_to_complete_does(w, ratio, where):
    """Hop by hop with exact flights: the ball is at rest before the end that was promised."""
    m = gz.pinball(V=0.0, r=min(ratio, 1.0), d=-0.4, alpha=0.5, k=1.2)
    c = packed(stroboscopic_map(m))
    i = next(i for i in range(len(c.edges) - 1) if window_sign(i, c) < 0.0)
    start, end = c.edges[i], c.edges[i + 1]
    t = start + where * (end - start)
    assume(chatter_completes(t, w, end, ratio, math.inf, c))
    v = w
    for _ in range(2000):
        hit, ball, *_ = next_contact(placed(t, 0.0, v, i), c)
        t, i = ball.t, ball.i
        assert hit
        assert t < end
        v = -ratio * ball.v
        if v < 1e-13:
            break
    assert v < 1e-13


def test_chatter_under_a_force_as_weak_as_its_rounding_is_an_open_question():
    """Taken one way and the other by more than all of it, the force answers yes and no: that makes a step ambiguous."""
    c = constants_for("chatter")
    i = next(i for i in range(len(c.edges) - 1) if window_sign(i, c) < 0.0)
    t, end = c.edges[i] + 1e-7 * (c.edges[i + 1] - c.edges[i]), c.edges[i + 1]
    F = forcing(t, c)[0]
    assert -1e-3 < F < 0.0
    case = t, 1e-30, end, 0.3, math.inf, c
    assert chatter_completes(*case, -2.0 * F)
    assert chatter_completes(*case, -2.0 * F) == compiled(chatter_completes)(*case, -2.0 * F)


def test_chatter_is_not_promised_where_it_need_not_happen():
    c = constants_for("chatter")
    i = next(i for i in range(len(c.edges) - 1) if window_sign(i, c) < 0.0)
    start, end = c.edges[i], c.edges[i + 1]
    middle = 0.5 * (start + end)
    assert chatter_completes(middle, 1e-3, end, 0.3, math.inf, c)
    assert not chatter_completes(middle, 1e-3, end, 1.0, math.inf, c)  # elastic
    assert not chatter_completes(middle, 5.0, end, 0.3, math.inf, c)  # too fast for the window
    assert not chatter_completes(middle, 1e-3, end, 0.3, 1e-4, c)  # faster than the law is known to contract
    assert not chatter_completes(0.5 * (end + c.edges[i + 2]), 1e-3, c.T, 0.3, math.inf, c)  # F > 0


class Law:
    """Laws for the table below."""

    @staticmethod
    def half(v, p):
        return -0.5 * v

    @staticmethod
    def kick(v, p):
        return -0.5 * v + 0.3

    @staticmethod
    def dead(v, p):
        return 0.0

    @staticmethod
    def wrong(v, p):
        return -1.0

    @staticmethod
    def wrong_at_rest(v, p):
        return 0.0 if v < 0.0 else math.nan

    @staticmethod
    def slope(v, p):
        return -0.5

    @staticmethod
    def halves(p):
        return 0.5, math.inf

    @staticmethod
    def unknown(p):
        return 1.0, 0.0


@pytest.mark.parametrize(
    ("law", "contraction", "pressed", "v", "kind", "speed", "flags"),
    [
        (Law.half, Law.halves, False, -0.4, FLIES, 0.2, OK),
        (Law.half, Law.halves, False, 0.0, FLIES, 0.0, OK),  # lifts off
        (Law.half, Law.halves, True, -5.0, FLIES, 2.5, OK),
        (Law.half, Law.halves, True, -1e-4, RELEASED, 0.0, CHATTER | STUCK),
        (Law.half, Law.unknown, True, -1e-4, FLIES, 5e-5, OK),
        (Law.half, Law.halves, True, 0.0, RELEASED, 0.0, STUCK),
        (Law.kick, Law.unknown, True, 0.0, FLIES, 0.3, OK),  # an impact of zero speed
        (Law.kick, Law.unknown, False, -0.2, FLIES, 0.4, OK),
        (Law.dead, Law.unknown, True, -0.2, RELEASED, 0.0, STUCK),
        (Law.dead, Law.unknown, False, -0.2, FLIES, 0.0, OK),
        (Law.wrong, Law.unknown, False, -0.2, FLIES, -1.0, BAD_LAW),
        (Law.wrong_at_rest, Law.unknown, True, -0.2, FLIES, math.nan, BAD_LAW),
    ],
)
def test_contact_rule(law, contraction, pressed, v, kind, speed, flags):
    m = gz.pinball(d=0.1)  # windows + - +
    c = packed(stroboscopic_map(m))
    i = 1 if pressed else 0
    t = 0.5 * (c.edges[i] + c.edges[i + 1])
    departure = departure_of(law, Law.slope, contraction)
    results = [departure(placed(t, 0.0, v, i), math.inf, c)]
    if not (flags & BAD_LAW):
        results.append(compiled(_frozen(departure, c))(t, v, i))
    for how, ball, said in results:
        assert (how, said) == (kind, flags)
        assert ball.t == (c.edges[i + 1] if kind == RELEASED else t)
        assert np.array_equal(ball.v, speed, equal_nan=True)
        assert ball.i == (i + 1 if kind == RELEASED else i)


def _frozen(departure, c):
    """The departure with the constants unpacked from a row, as compiled code has them."""
    from grazing.oscillator.constants import constants_of, section_phase

    prepare = constants_of(1, section_phase)
    p = c.p

    def entry(t, v, i):
        return departure(placed(t, 0.0, v, i), math.inf, prepare(p))

    return entry


def test_pressed_up_to_the_strobe_lies_until_it():
    m = gz.pinball(d=-1.5, V=0.0, r=0.5)
    c = packed(stroboscopic_map(m))
    departure = departure_of(m.reset.law, m.reset.slope, m.reset.contraction)
    assert departure(placed(1.0, 0.0, 0.0, 0), math.inf, c) == (LIES, placed(c.T, 0.0, 0.0, 0), STUCK)
    assert departure(placed(1.0, 0.0, -1e-9, 0), math.inf, c) == (LIES, placed(c.T, 0.0, 0.0, 0), CHATTER | STUCK)


def test_patience_keeps_chatter_going_hop_by_hop():
    m = gz.pinball(d=-1.5, V=0.0, r=0.5)
    c = packed(stroboscopic_map(m))
    departure = departure_of(m.reset.law, m.reset.slope, m.reset.contraction)
    falling = placed(1.0, 0.0, -0.2, 0)
    assert departure(falling, math.inf, c)[0] == LIES
    how, ball, flags = departure(falling, 0.05, c)
    assert (how, ball[:4], flags) == (FLIES, (1.0, 0.0, 0.1, 0), OK)


def test_the_smallest_hop_does_not_hang():
    P = gz.stroboscopic_map(gz.pinball(alpha=1.0, d=-1000.0, r=0.5, V=0.0))
    assert P((0.0, -1e-323))[0].tolist() == [0.0, 0.0]


def test_a_slow_impact_magnifies_the_errors_before_it():
    """An impact at 1e-6 makes errors of 1e-15 into 1e-9: later decisions that close are ambiguous."""
    c = packed(stroboscopic_map(gz.pinball()))
    for v, least, most in ((-1e-6, 1e-10, 1e-8), (-0.5, 1e-16, 1e-14)):
        ball = Ball(1.0, 0.0, v, window_of(1.0, 0, c), 1e-15, 1e-15, NO_LAUNCH)
        launch, unsure = next_launch(ball, 0.4 - 0.8 * v, -0.8, c)
        assert next_launch(ball, 0.4, 0.0, c)[1] == unsure  # a law that forgets the speed does not make it known
        assert least < launch.late < most
        assert launch.off < most
        assert least < carried(1.5, launch, c) < most


def test_errors_grow_as_orbits_part_and_no_faster():
    """An elastic ball under gravity: after n hops time errors have grown like n^2, not exponentially."""
    m = gz.Oscillator(0.0, 0.0, gz.Forcing(omega=0.01, offset=-1.0, cos=(0.0,)), gz.newton(r=1.0))
    c = packed(stroboscopic_map(m))
    departure = departure_of(m.reset.law, m.reset.slope, m.reset.contraction)
    ball, lates = placed(0.0, 0.0, 0.1, 0), []
    for _ in range(200):
        _, ball, *_ = next_contact(ball, c)
        _, ball, _ = departure(ball, math.inf, c)
        lates.append(ball.launch.late)
    assert lates[199] < 4.0 * 200.0**2 * lates[0]
