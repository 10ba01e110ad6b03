"""Chatter, sticking and release against impacts followed one by one in 60 digits, down to speeds of 1e-25.

The reference (`tests.reference`) flies by Taylor series in ball arithmetic and knows neither windows nor closed forms.
Where it says that the ball rests, the ball has made some hundred to some thousand impacts.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from flint import arb

import grazing as gz
from grazing.kernel.compile import jit_disabled
from grazing.maps import period
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.oscillator.constants import forcing
from grazing.oscillator.contact import window_of
from grazing.oscillator.departure import chatter_completes, hop_bounds
from grazing.outcome import AMBIGUOUS, CHATTER, STUCK, TOO_MANY_IMPACTS
from tests.models import cubic, packed
from tests.reference import Law, Problem, advance, force

THREE = {"omega": 0.9, "t0": 0.4, "cos": (1.0, 0.3, -0.2), "sin": (0.1, 0.0, 0.25)}
TWO = {"omega": 0.9, "t0": 0.4, "cos": (1.0, 0.3, 0.0), "sin": (0.1, -0.2, 0.0)}
SYSTEMS = {
    "over-damped": Problem(3.0, 1.0, offset=-0.7, **THREE),
    "critically damped, raised wall": Problem(2.0, 1.0, offset=-0.4, sigma=0.3, **THREE),
    "under-damped, lowered wall": Problem(0.2, 3.0, offset=-1.7, sigma=-0.1, **TWO),
    "no stiffness": Problem(0.5, 0.0, offset=-0.9, **TWO),
    "no stiffness, no damping": Problem(0.0, 0.0, offset=-0.9, **THREE),
    "negative stiffness": Problem(0.3, 0.0, offset=-0.9, stiffness=-0.2, **TWO),
    "negative damping": Problem(-0.15, 1.0, offset=-0.9, **TWO),
    "both negative, raised wall": Problem(-0.1, 0.0, offset=-1.0, sigma=0.2, stiffness=-0.1, **THREE),
}


@dataclass(frozen=True)
class Softening(Law):
    """The law `cubic` of the models for the reference: restitution r/(1 + c |v|)."""

    c: float = 0.0

    def __call__(self, v):
        return -self.r * v / (1 - self.c * v)


def oscillator(problem, reset=None):
    """Make the library's model; one law, which is Newton's for V = 0 and a bumper for speed = 0, is compiled once."""
    law = problem.law
    own = reset or gz.triggered(r=law.r, V=law.V, trigger=law.speed)
    shaken = gz.Forcing(problem.omega, problem.t0, problem.offset, problem.cos, problem.sin)
    k = problem.k if problem.stiffness is None else None
    return gz.Oscillator(problem.alpha, k, shaken, own, problem.sigma, stiffness=problem.stiffness)


def constant(g=1.0, omega=0.5, **law):
    """A ball under a constant force: every hop of speed w lasts 2 w/g and lands with w."""
    return oscillator(Problem(0.0, 0.0, omega, offset=-g, cos=(0.0,) * 3, law=Law(**law)))


def plain_step(m, state):
    P = gz.stroboscopic_map(m)
    return P.step(state, packed(P))


def orbit(m, state, periods):
    """Iterate the map compiled and plain; both must agree to the last bit, where doubles decide."""
    P = gz.stroboscopic_map(m)
    segment, c = P.orbit(state, periods), packed(P)
    for n in range(0 if jit_disabled() else periods):
        point, letter, outcome = P.step(tuple(float(x) for x in segment.points[n]), c)
        assert (point, letter) == (tuple(segment.points[n + 1]), segment.letters[n])
        assert outcome & ~AMBIGUOUS == segment.outcomes[n]
    return segment


def rests(strobe):
    return any(impact.v_plus == 0 for impact in strobe.impacts)


def same(segment, strobes, r, tolerance=5e-15, edge=False):
    """Compare states, letters and outcomes; errors may grow as far as the reference says; an edge may be ambiguous."""
    for point, letter, outcome, strobe in zip(
        segment.points[1:], segment.letters, segment.outcomes, strobes, strict=True
    ):
        assert np.abs(point - (float(strobe.u), float(strobe.v))).max() <= tolerance * (strobe.factor or 1.0)
        assert letter == (CHATTER_LETTER if rests(strobe) and r > 0.0 else len(strobe.impacts))
        assert outcome & ~(AMBIGUOUS if edge else 0) == (
            0 if not rests(strobe) else CHATTER | STUCK if r > 0.0 else STUCK
        )


# ---- passive walls


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("r", [0.0, 0.1, 0.7])
def test_three_periods_with_an_infinity_of_impacts_each(name, r):
    problem = replace(SYSTEMS[name], law=Law(r))
    state = (problem.sigma + 0.02, -0.1)
    strobes = advance(problem, *state, 3)
    same(orbit(oscillator(problem), state, 3), strobes, r)
    assert all(rests(strobe) for strobe in strobes)
    assert r == 0.0 or min(len(strobe.impacts) for strobe in strobes) >= 25


def test_chatter_of_two_thousand_impacts():
    problem = replace(SYSTEMS["critically damped, raised wall"], law=Law(0.97))
    (strobe,) = advance(problem, 0.32, -0.1, 1)
    assert len(strobe.impacts) > 1700
    same(orbit(oscillator(problem), (0.32, -0.1), 1), [strobe], 0.97)


def test_the_least_restitution_that_keeps_the_ball_bouncing():
    """Between chatter and release lies one value of r: bisected with the map, found again by the reference."""
    problem = SYSTEMS["no stiffness, no damping"]
    P = gz.stroboscopic_map(oscillator(replace(problem, law=Law(0.5))))
    lo, hi = 0.5, 0.999
    while hi - lo > 1e-11:  # a tenth of what is asked of the reference below
        middle = 0.5 * (lo + hi)
        if P.replace(r=middle).orbit((0.02, -0.1), 1).letters[0] == CHATTER_LETTER:
            lo = middle
        else:
            hi = middle
    assert 0.9 < lo < 0.91
    for r, completes in ((lo * (1.0 - 1e-10), True), (hi * (1.0 + 1e-10), False)):
        law = replace(problem, law=Law(r))
        (strobe,) = advance(law, 0.02, -0.1, 1)
        assert rests(strobe) is completes
        same(P.replace(r=r).orbit((0.02, -0.1), 1), [strobe], r, edge=True)


# ---- where it ends: the trajectory


@pytest.mark.parametrize("name", ["over-damped", "under-damped, lowered wall"])
def test_impacts_rest_and_release_in_continuous_time(name):
    """Every listed impact is right; rest begins at most one geometric sum early; release is where F changes sign."""
    r = 0.7
    problem = replace(SYSTEMS[name], law=Law(r))
    flown = gz.trajectory(oscillator(problem), (problem.sigma + 0.02, -0.1), until=2.0 * float(problem.period))
    impacts = [impact for strobe in advance(problem, problem.sigma + 0.02, -0.1, 2) for impact in strobe.impacts]
    last = [n for n, impact in enumerate(impacts) if impact.v_plus == 0]
    stops = np.flatnonzero(flown.v_plus.values == 0.0)
    assert (len(stops), flown.attrs["chatter"], flown.trust.item()) == (2, 1, "certified")
    assert (flown.v_plus.values >= 0.0).all()
    first = 0
    begin = 0
    for stop, rest in zip(stops, last, strict=True):
        t, v = flown.impact_time.values[begin : stop + 1], flown.v_minus.values[begin : stop + 1]
        listed = impacts[first : first + len(t)]
        assert 35 < len(t) < 50  # down to 1e-6 of the first speed
        assert t == pytest.approx([float(impact.t) for impact in listed], abs=1e-13)
        assert v == pytest.approx([float(impact.v_minus) for impact in listed], rel=1e-11)
        # the hops that are not listed take 2 r |v|/(|F| (1 - r)) in all
        g = -float(force(problem, t[-1]))
        left = float(impacts[rest].t) - t[-1]
        assert left == pytest.approx(-2.0 * r * v[-1] / (g * (1.0 - r)), rel=1e-4)
        # on the wall until F changes sign from - to +
        lying = flown.t.values[(flown.u.values == problem.sigma) & (flown.v.values == 0.0) & (flown.t.values >= t[-1])]
        gaps = np.flatnonzero(np.diff(lying) > 0.1)
        release = lying[gaps[0]] if gaps.size else lying[-1]
        assert force(problem, release - 4e-15) < 0
        assert force(problem, release + 4e-15) > 0
        first, begin = rest + 1, stop + 1


# ---- a bumper with a trigger: V > 0, and yet it chatters


@pytest.mark.parametrize("name", ["over-damped", "under-damped, lowered wall", "no stiffness"])
@pytest.mark.parametrize(("v", "fired"), [(-0.05, False), (-0.9, True)])
def test_a_trigger_law_chatters_below_its_threshold(name, v, fired):
    law = Law(0.4, V=0.3, speed=0.8)
    problem = replace(SYSTEMS[name], law=law)
    state = (problem.sigma, v)
    (strobe,) = advance(problem, *state, 1, jacobian=True)
    assert any(impact.v_minus < -law.speed for impact in strobe.impacts) is fired
    same(orbit(oscillator(problem), state, 1), [strobe], law.r)
    flown = gz.trajectory(oscillator(problem), state, until=float(problem.period))
    kicked = flown.v_minus.values <= -law.speed
    assert kicked.any() == fired
    passive = flown.v_plus.values > 0.0
    expected = -law.r * flown.v_minus.values + np.where(kicked, law.V, 0.0)
    assert np.array_equal(flown.v_plus.values[passive], expected[passive])


def test_a_bumper_that_always_fires_has_no_chatter():
    problem = replace(SYSTEMS["over-damped"], law=Law(0.4, V=0.02))
    state = (problem.sigma, -0.05)
    (strobe,) = advance(problem, *state, 1, jacobian=True)
    assert not rests(strobe)
    assert len(strobe.impacts) > 20
    same(orbit(oscillator(problem), state, 1), [strobe], 0.4)


# ---- a law of one's own


def own(e, promise):
    return gz.reset(cubic, contraction=lambda p: (p.promise, math.inf), e=e, c=0.5, promise=promise)


@pytest.mark.parametrize("name", ["over-damped", "under-damped, lowered wall"])
@pytest.mark.parametrize("e", [0.3, 0.8])
def test_a_law_that_promises_to_contract(name, e):
    problem = replace(SYSTEMS[name], law=Softening(e, c=0.5))
    state = (problem.sigma + 0.02, -0.1)
    (strobe,) = advance(problem, *state, 1)
    assert rests(strobe)
    point, letter, outcome = plain_step(oscillator(problem, own(e, promise=e)), state)
    assert point == pytest.approx((float(strobe.u), float(strobe.v)), abs=5e-15)
    assert (letter, outcome) == (CHATTER_LETTER, CHATTER | STUCK)


def sticky(v, p):
    """A slow ball stays where it lands."""
    return 0.0 if -v < p.floor else -p.e * v


@dataclass(frozen=True)
class Sticky(Law):
    """The same for the reference."""

    floor: float = 0.0

    def __call__(self, v):
        return arb(0) if -v < self.floor else -self.r * v


def test_a_law_without_a_promise_is_followed_impact_by_impact():
    """As far as a law that ends the sequence itself; with the promise the same state comes without following."""
    problem = replace(SYSTEMS["over-damped"], law=Sticky(0.8, floor=1e-12))
    (strobe,) = advance(problem, 0.02, -0.1, 1)
    assert rests(strobe)
    followed, count, said = plain_step(oscillator(problem, gz.reset(sticky, e=0.8, floor=1e-12)), (0.02, -0.1))
    assert (count, said) == (len(strobe.impacts), STUCK)
    assert count > 100
    assert followed == pytest.approx((float(strobe.u), float(strobe.v)), abs=5e-15)
    promised = gz.reset(sticky, contraction=(0.8, math.inf), e=0.8, floor=1e-12)
    assert plain_step(oscillator(problem, promised), (0.02, -0.1)) == (followed, CHATTER_LETTER, CHATTER | STUCK)


def test_chatter_without_a_promise_ends_at_the_budget(monkeypatch):
    monkeypatch.setattr(period, "MAX_IMPACTS", 300)
    m = oscillator(SYSTEMS["over-damped"], own(0.8, promise=1.0))
    nowhere, count, said = plain_step(m, (0.02, -0.1))
    assert np.isnan(nowhere).all()
    assert (count, said) == (301, TOO_MANY_IMPACTS)


# ---- no chatter, but many impacts


def test_hops_are_counted_up_to_the_budget():
    """A steady speed w = V/(1 - r) makes |F| L/(2 w) impacts in a time L, plus the one at its start."""
    P, T = gz.stroboscopic_map(constant(r=0.5)), 4.0 * math.pi
    for r, V, w in ((1.0, 0.0, 1e-2), (1.0, 0.0, 6.3e-4), (0.5, 4e-4, 8e-4), (0.9, 1e-4, 1e-3)):
        segment = P.replace(r=r, V=V, trigger=0.0).orbit((0.0, -w), 1)
        assert (segment.letters[0], segment.outcomes[0]) == (math.floor(T / (2.0 * w)) + 1, 0)


@pytest.mark.parametrize(
    ("r", "V", "w"), [(1.0, 0.0, 6.2e-4), (1.0, 0.0, 1e-300), (0.5, 3e-4, 6e-4), (0.5, 5e-324, 0.1), (0.0, 1e-12, 0.3)]
)
def test_too_many_impacts_end_by_name_after_a_bounded_number(r, V, w):
    P = gz.stroboscopic_map(constant(r=0.5)).replace(r=r, V=V, trigger=0.0)
    segment = P.orbit((0.0, -w), 2)
    assert (segment.letters[0], segment.outcomes[0]) == (period.MAX_IMPACTS + 1, TOO_MANY_IMPACTS)
    assert np.isnan(segment.points[1:]).all()


def test_the_budget_in_plain_python(monkeypatch):
    monkeypatch.setattr(period, "MAX_IMPACTS", 50)
    for law in ({"r": 1.0}, {"r": 0.5, "V": 1e-9}):
        point, letter, outcome = plain_step(constant(**law), (0.0, -1e-9))
        assert np.isnan(point).all()
        assert (letter, outcome) == (51, TOO_MANY_IMPACTS)


def test_the_elastic_ball_is_never_at_rest():
    """r = 1 under a force that varies: hundreds of impacts, the same as the reference's, and no chatter."""
    problem = replace(SYSTEMS["no stiffness, no damping"], offset=-3.0, law=Law(1.0))
    (strobe,) = advance(problem, 0.0, -0.02, 1, jacobian=True)
    assert len(strobe.impacts) > 400
    segment = gz.stroboscopic_map(oscillator(problem)).orbit((0.0, -0.02), 1)
    same(segment, [strobe], 1.0)


def test_a_vanishing_kick_approaches_chatter():
    """States differ from those with V = 0 by O(V), impacts grow like 1/V; then the budget ends the period."""
    m = oscillator(replace(SYSTEMS["critically damped, raised wall"], law=Law(0.5)))
    P = gz.stroboscopic_map(m)
    limit = P.orbit((0.32, -0.1), 1).points[1]
    counts = []
    for V in (1e-2, 1e-3, 3e-4):
        segment = P.replace(V=V).orbit((0.32, -0.1), 1)
        assert segment.outcomes[0] == 0
        assert 0.1 * V < np.abs(segment.points[1] - limit).max() < V
        counts.append(V * segment.letters[0])
    assert counts == pytest.approx([1.1] * 3, abs=0.08)
    for V in (1e-5, 1e-100, 5e-324):
        assert P.replace(V=V).orbit((0.32, -0.1), 1).outcomes[0] == TOO_MANY_IMPACTS


# ---- the inequalities behind it


def random_hops(count, dampings=(0.0, 0.3, 2.0, 8.0), stiffnesses=(0.0, 1.0, 16.0)):
    """Departures from the wall with speed w in a window with F < 0, for all dampings, springs and walls."""
    rng = np.random.default_rng(5)
    while count:
        alpha, stiffness = float(rng.choice(dampings)), float(rng.choice(stiffnesses))
        sigma = rng.uniform(-1.0, 1.0)
        offset = rng.uniform(-1.0, 0.5) + stiffness * sigma
        cos, sin = tuple(rng.uniform(-0.5, 0.5, 3)), tuple(rng.uniform(-0.5, 0.5, 3))
        k, own = (math.sqrt(stiffness), None) if stiffness >= 0.0 else (0.0, stiffness)
        problem = Problem(alpha, k, 0.9, 0.4, offset, cos, sin, sigma, stiffness=own)
        c = packed(gz.stroboscopic_map(oscillator(problem)))
        t, w = rng.uniform(0.0, c.T), 10.0 ** rng.uniform(-3.0, 0.0)
        i = window_of(t, 0, c)
        if forcing(t, c)[0] < 0.0:
            count -= 1
            yield problem, c, t, c.edges[i + 1], w


def test_a_hop_is_short_and_lands_slowly():
    """Where m <= -F <= M a hop lasts at most 2w/m and lands with at most sqrt(M/m) w, with damping and a spring."""
    longest = fastest = 0.0
    hops = 0
    for problem, c, t, end, w in random_hops(120):
        (strobe,) = advance(replace(problem, law=Law(0.0)), problem.sigma, w, 1, start=t)
        if not strobe.impacts or t + (hop := float(strobe.impacts[0].t) - t) >= end:
            continue
        pull = np.array([-forcing(float(s), c)[0] for s in np.linspace(t, t + hop, 201)])
        slack = 0.125 * c.bend * (hop / 200.0) ** 2
        m, M = pull.min() - slack, pull.max() + slack
        if m <= 0.0:
            continue
        hops += 1
        longest = max(longest, hop * m / (2.0 * w))
        fastest = max(fastest, -float(strobe.impacts[0].v_minus) / (w * math.sqrt(M / m)))
    assert hops > 60
    assert 0.99 < longest <= 1.0 + 1e-12  # attained by short hops
    assert 0.95 < fastest <= 1.0 + 1e-12


SIGNS = {"dampings": (-2.0, -0.3, 0.0, 0.3, 2.0), "stiffnesses": (-9.0, -1.0, -0.1, 0.0, 1.0)}


def test_a_hop_is_short_and_lands_slowly_with_negative_damping_or_stiffness():
    """(5a) and (5b) of docs/chatter.md hold, and the bounds for alpha, k >= 0 would not."""
    longest = fastest = old = 0.0
    hops = 0
    for problem, c, t, end, w in random_hops(400, **SIGNS):
        if c.grows == 0.0:
            continue
        (strobe,) = advance(replace(problem, law=Law(0.0)), problem.sigma, w, 1, digits=24, start=t)
        if not strobe.impacts or t + (hop := float(strobe.impacts[0].t) - t) >= end:
            continue
        pull = np.array([-forcing(float(s), c)[0] for s in np.linspace(t, t + hop, 201)])
        slack = 0.125 * c.bend * (hop / 200.0) ** 2
        m, M = pull.min() - slack, pull.max() + slack
        n, s = hop_bounds(m, M, w, c) if m > 0.0 else (0.0, math.inf)
        if n <= 0.0:
            continue
        hops += 1
        x = -float(strobe.impacts[0].v_minus)
        longest, fastest = max(longest, hop * n / (2.0 * w)), max(fastest, x / (w * s))
        old = max(old, hop * m / (2.0 * w), x / (w * math.sqrt(M / m)))
    assert hops > 60
    assert 0.99 < longest <= 1.0 + 1e-12
    assert 0.95 < fastest <= 1.0 + 1e-12
    assert old > 1.02


@pytest.mark.parametrize("signs", [{}, SIGNS])
def test_chatter_is_over_when_and_as_slow_as_promised(signs):
    """Take the earliest end and the least speed for which completion is promised: the reference keeps to both."""
    promises = 0
    for problem, c, t, end, w in random_hops(60, **signs):
        # ends that make F vary much on the way
        r = 0.1 + 0.6 * (w % 1e-3) * 1e3
        e = (end - t) * 2.0 ** -(1e4 * w % 4.0)
        w = -forcing(t, c)[0] * (1.0 - r) * e / 4.0
        while t + e <= end and not chatter_completes(t, w, t + e, r, math.inf, c):
            e *= 2.0
        if t + e > end:
            continue
        lo, hi = 1.0, 1.0 / r
        for _ in range(40):
            middle = 0.5 * (lo + hi)
            lo, hi = (lo, middle) if chatter_completes(t, w, t + e, r, middle * w, c) else (middle, hi)
        assert not chatter_completes(t, w, t + 0.999 * e, r, math.inf, c)
        impacts = advance(replace(problem, law=Law(r)), problem.sigma, w, 1, digits=24, start=t)[0].impacts
        rest = next(n for n, impact in enumerate(impacts) if impact.v_plus == 0)
        assert impacts[rest].t < t + e
        assert max(-float(impact.v_minus) for impact in impacts[: rest + 1]) <= hi * w * (1.0 + 1e-12)
        promises += 1
    assert promises > 15


# ---- sticking and release


def turning(a):
    """F = sin t + a sin 2t, which turns from - to + at t = 0: simply for a > -1/2, to third order for a = -1/2."""
    return oscillator(Problem(0.5, 1.0, 1.0, cos=(0.0,) * 3, sin=(1.0, a, 0.0), law=Law(0.5)))


@pytest.mark.parametrize(("a", "order", "when"), [(0.2, 1, 1e-15), (-0.5, 3, 1e-7)])
def test_the_ball_leaves_as_the_first_derivative_that_does_not_vanish_says(a, order, when):
    """y ~ F^(n) s^(n+2)/(n+2)!, n odd; the next terms are smaller by a factor s."""
    derivative = 1.0 + 2.0 * a if order == 1 else -1.0 - 8.0 * a
    errors = []
    for s in (0.1, 0.05, 0.025):
        flown = gz.trajectory(turning(a), (0.0, 0.0), start=-1.0, until=s)
        lying = flown.t.values[(flown.u.values == 0.0) & (flown.v.values == 0.0)]
        assert abs(lying.max()) <= when
        errors.append(flown.u.values[-1] / (derivative * s ** (order + 2) / math.factorial(order + 2)) - 1.0)
        assert flown.sizes["impact"] == 0
    assert 0.0 < abs(errors[0]) < 0.05
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.2)
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(("above", "letters"), [(0.0, [CHATTER_LETTER, STUCK_LETTER, STUCK_LETTER]), (1e-6, None)])
def test_a_double_zero_does_not_release(above, letters):
    """F = cos - 1 touches zero once a period; a little more and the ball leaves, and chatters back."""
    m = oscillator(Problem(0.5, 1.0, 1.0, t0=2.0, offset=above - 1.0, cos=(1.0, 0.0, 0.0), law=Law(0.5)))
    segment = orbit(m, (0.01, 0.0), 3)
    assert segment.points[1:].tolist() == [[0.0, 0.0]] * 3
    assert segment.letters.tolist() == (letters or [CHATTER_LETTER] * 3)
    assert segment.undecided == 0
    flown = gz.trajectory(m, (0.0, 0.0), until=2.0 * math.pi)
    assert (flown.sizes["impact"] > 0) is (above > 0.0)
    assert flown.trust.item() == ("certified" if above > 0.0 else "ambiguous")  # doubles alone do not decide a tie


def test_what_happened_before_the_rest_is_forgotten():
    """A neighbourhood of starts ends in one state, to the last bit: the Jacobian is zero."""
    P = gz.stroboscopic_map(oscillator(replace(SYSTEMS["critically damped, raised wall"], law=Law(0.6))))
    point, letter, outcome, J = P.tangent((0.32, -0.1), packed(P))
    assert (letter, outcome, J) == (CHATTER_LETTER, CHATTER | STUCK, (0.0, 0.0, 0.0, 0.0))
    for u, v in ((0.3, -0.5), (0.33, -0.1), (0.3, 0.2), (0.3, 0.0)):
        assert P.step((u, v), packed(P))[0] == point


def unpromised(share, law=None, **promise):
    """Return a model in which a law of one's own chatters, by default one that takes a share of the speed."""

    def softer(v, p):
        return -p.share * v

    forcing = gz.Forcing(omega=1.1, offset=-0.8)
    return gz.Oscillator(alpha=0.2, k=1.0, forcing=forcing, reset=gz.reset(law or softer, share=share, **promise))


@pytest.mark.parametrize("share", [0.25, 0.7])
def test_a_map_proves_that_a_law_contracts_which_does_not_say_so(share):
    """As the documentation says: each step is certified, as with the promise; speeds as small as 5e-324 are no rest."""
    mute, told = unpromised(share), unpromised(share, contraction=(share, math.inf))
    followed, completed = (gz.stroboscopic_map(m).orbit((0.3, 0.0), 4) for m in (mute, told))
    assert CHATTER_LETTER in completed.letters and completed.letters.tolist() == followed.letters.tolist()
    assert completed.outcomes.tolist() == followed.outcomes.tolist() and followed.undecided == 0
    assert np.abs(followed.points - completed.points).max() < 1e-13


@pytest.mark.parametrize("share", [0.25, 0.7])
def test_a_rest_that_rests_on_no_proof_is_not_called_certified(share):
    """A trajectory has doubles only; a law that is no arithmetic has no proof, and neither has one that jumps at 0."""

    def rooted(v, p):
        return p.share * math.sqrt(v * v)

    until = 2 * unpromised(share).period
    mute = gz.trajectory(unpromised(share), (0.3, 0.0), until=until)
    told = gz.trajectory(unpromised(share, contraction=(share, math.inf)), (0.3, 0.0), until=until)
    assert (mute.trust.item(), told.trust.item()) == ("ambiguous", "certified")
    assert abs(float(mute.u[-1]) - float(told.u[-1])) < 1e-12
    orbit = gz.stroboscopic_map(unpromised(share, rooted)).orbit((0.3, 0.0), 2)
    assert orbit.undecided > 0 and (orbit.outcomes & AMBIGUOUS).any()


def test_a_law_that_ends_its_sequence_itself_is_certified_without_a_promise():
    """The dead stop is the law's own, not a speed that rounds to 0."""

    def sticky(v, p):
        return -p.share * v if v < -1e-3 else 0.0

    flown = gz.trajectory(unpromised(0.5, sticky), (0.3, 0.0), until=8.0)
    assert flown.trust.item() == "certified" and (flown.v_plus.values == 0.0).any()
