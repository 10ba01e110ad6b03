"""The period in ball arithmetic: against the reference, beside every edge, exact ties, laws, budgets."""

import math
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from flint import arb, ctx

import grazing as gz
from grazing.maps.map import CHATTER_LETTER, STUCK_LETTER
from grazing.maps.starting import paper_box
from grazing.oscillator import exact, exact_flight, exact_motion
from grazing.oscillator.constants import forcing
from grazing.oscillator.exact import Frame, Period, exact_period, followed
from grazing.oscillator.exact_flight import rounded
from grazing.oscillator.exact_motion import Motion
from grazing.oscillator.flight import anchored, flight, modes
from grazing.oscillator.sure import Beyond, Sure, Undecided
from grazing.outcome import AMBIGUOUS, BAD_LAW, CHATTER, GRAZE, STUCK, TOO_MANY_IMPACTS, TOO_MANY_SWINGS
from tests.models import MODELS, model_of, packed
from tests.reference import PROBLEMS, Problem, active, advance, load_dips, load_orbits, newton, trigger

ORBITS, DIPS = load_orbits(), load_dips()


def letter(period):
    if period.outcome & CHATTER:
        return CHATTER_LETTER
    return STUCK_LETTER if period.lay else period.impacts


def in_doubles(m, state):
    """One step of the map in plain Python, which gives the bits of compiled code: state, letter, outcome."""
    P = gz.stroboscopic_map(m)
    return P.step(state, packed(P))


def constant(F, reset, alpha=0.0, k=0.0, omega=1.0):
    """A ball under a constant force."""
    return gz.Oscillator(alpha, k, gz.Forcing(omega=omega, offset=F, cos=(0.0,)), reset)


# ---- against the reference


@pytest.mark.parametrize("name", PROBLEMS)
def test_orbits_of_the_reference(name):
    """Three periods of every stored orbit; rounding at the strobes is all that may grow."""
    m = model_of(PROBLEMS[name])
    for stored in (orbit for orbit in ORBITS if orbit.problem == name):
        state = (stored.u, stored.v)
        for n, strobe in enumerate(stored.strobes[:3], start=1):
            period = exact_period(m, state)
            state = period.state
            assert max(abs(state[0] - strobe.u), abs(state[1] - strobe.v)) <= 1e-15 * n * strobe.factor
            assert letter(period) in ((CHATTER_LETTER,) if strobe.impacts is None else (strobe.impacts, STUCK_LETTER))


@pytest.mark.parametrize("exponent", range(3, 14))
def test_dips_and_clearances_of_every_depth(exponent):
    """Rounded to the last bit or two: at every depth, a dip or a clearance of every problem."""
    chosen = [dip for i, dip in enumerate(DIPS) if dip.depth == float(f"1e-{exponent}") and i % 4 == i // 4 % 2]
    assert {dip.hits for dip in chosen} == {True, False}
    for dip in chosen:
        period = exact_period(model_of(PROBLEMS[dip.problem]), (dip.u, dip.v))
        assert period.state == pytest.approx((dip.strobe.u, dip.strobe.v), rel=4e-16, abs=1e-18)
        assert dip.strobe.impacts in (None, period.impacts)


# ---- against double precision


@pytest.mark.parametrize("name", MODELS)
def test_agrees_where_double_precision_decides(name):
    m, rng, compared = MODELS[name], np.random.default_rng(5), 0
    (low, high), (down, up) = gz.stroboscopic_map(m).box
    starts = [(m.sigma, -0.3), (m.sigma, 0.0), (m.sigma, 0.2)]
    starts += [(float(rng.uniform(low, high)), float(rng.uniform(down, up))) for _ in range(12)]
    for start in starts:
        point, said, outcome = in_doubles(m, start)
        if outcome & (AMBIGUOUS | TOO_MANY_IMPACTS) or said > 1000:  # too many impacts to follow here
            continue
        period = exact_period(m, start)
        assert period.state == pytest.approx(point, rel=1e-13, abs=1e-13)
        assert (letter(period), period.outcome) == (said, outcome)
        compared += 1
    assert compared >= 10


@pytest.mark.parametrize("bits", [16, 24, 32, 53])
def test_few_bits_say_undecided_but_never_what_is_wrong(bits, monkeypatch):
    monkeypatch.setattr(exact_flight, "GOOD", 2)
    decided = 0
    for dip in DIPS[::18]:
        m = model_of(PROBLEMS[dip.problem])
        true = exact_period(m, (dip.u, dip.v))
        with ctx.workprec(bits):
            try:
                period = followed(m, 0.0, dip.u, dip.v)
            except Undecided:
                continue
        decided += 1
        assert (period.impacts, period.outcome) == (true.impacts, true.outcome)
    assert decided > 0 or bits == 16


def edge(decides, lo, hi):
    """Return two neighbouring doubles between lo and hi: the first answers as lo does, the second does not."""
    left = decides(lo)
    assert left != decides(hi)
    while True:
        middle = 0.5 * (lo + hi)
        if middle in (lo, hi):
            return lo, hi
        lo, hi = (middle, hi) if decides(middle) == left else (lo, middle)


def beside(x, n, towards):
    """Return n doubles from x on."""
    found = [x]
    for _ in range(n - 1):
        found.append(float(np.nextafter(found[-1], towards)))
    return found


@pytest.mark.parametrize("name", [*MODELS, "trigger, chatter", "resonance", "pressed"])
def test_beside_an_edge_every_double_is_decided(name):
    """Where the number of impacts changes, down to neighbouring doubles: one side has one number, the other another."""
    m = MODELS[name] if name in MODELS else model_of(PROBLEMS[name])
    rng = np.random.default_rng(2)
    (_, high), (down, up) = paper_box(m.sigma, m.period)  # near the wall, where chatter and edges are

    def impacts(u):
        return exact_period(m, (u, v)).impacts

    def letters():
        return sorted(in_doubles(m, (u, v))[1] for u in (lo, hi))

    lo, hi, v = high, high, up
    for _ in range(2000):
        if 0 <= letters()[0] < letters()[1] < 10:
            break
        v = float(rng.uniform(3.0 * down, up))
        lo, hi = (float(x) for x in m.sigma + (high - m.sigma) * rng.uniform(0.0, 6.0, 2))
    lo, hi = edge(impacts, lo, hi)
    assert all(in_doubles(m, (u, v))[2] & AMBIGUOUS for u in (lo, hi))
    outwards = math.copysign(math.inf, lo - hi)
    for near, far in ((lo, outwards), (hi, -outwards)):
        assert len({impacts(u) for u in beside(near, 6, far)}) == 1


@pytest.mark.parametrize("name", ["standard d=0.09", "critical", "under-damped", "three harmonics", "high obstacle"])
def test_the_reference_agrees_between_neighbouring_doubles(name):
    problem = PROBLEMS[name]
    m = model_of(problem)

    def impacts(u):
        return exact_period(m, (u, v)).impacts

    for v, start in ((dip.v, dip.u) for dip in DIPS if dip.problem == name and dip.depth == 1e-6):
        if impacts(start) == impacts(start + 1e-3):
            continue  # another impact is lost or won
        for u in edge(impacts, start, start + 1e-3):
            strobe, period = advance(problem, u, v, 1, digits=60)[0], exact_period(m, (u, v))
            assert period.impacts == len(strobe.impacts)
            assert period.state == (float(strobe.u), float(strobe.v))
        return
    raise AssertionError("no dip ends")


def test_the_trigger_speed_is_decided_to_the_last_bit():
    """As the trigger grows through the speed of the impact the bumper stops firing, once, between two doubles."""
    law = trigger(0.8, 0.4, 0.27829748540636534)
    m = model_of(Problem(3.0, 1.0, 2.2, 0.10880780956697578, 0.006967415105215757, law=law))
    start = (0.1120386337877902, 0.12909475671487403)
    kicked = exact_period(m.replace(trigger=law.speed - 1e-9), start).state[1]

    def fires(speed):
        return abs(exact_period(m.replace(trigger=speed), start).state[1] - kicked) < 1e-6

    lo, hi = edge(fires, law.speed - 1e-9, law.speed + 1e-9)
    assert all(in_doubles(m.replace(trigger=x), start)[2] & AMBIGUOUS for x in (lo, hi))
    assert all(fires(x) for x in beside(lo, 6, -math.inf))
    assert not any(fires(x) for x in beside(hi, 6, math.inf))


def test_an_impact_beside_the_strobe_is_decided():
    """A ball without forces reaches the wall at the end of the period, which is no double."""
    m = constant(0.0, gz.newton(r=0.5))
    v = -0.25

    def hits(u):
        return exact_period(m, (u, v)).impacts

    lo, hi = edge(hits, 1.0, 2.0)
    assert (hits(lo), hits(hi)) == (1, 0)
    assert math.pi / 2.0 in (lo, hi)
    assert exact_period(m, (hi, v)).state[0] < 1e-15


def test_chatter_or_release_is_decided_where_double_precision_is_not_asked():
    """Hops of 1e-18 before the forcing releases the ball: the reference counts as many."""
    m = MODELS["chatter"]
    problem = Problem(m.alpha, m.k, m.forcing.omega, 0.0, m.forcing.offset, law=newton(0.3))
    for start in ((0.28417221410177673, -0.1779268555943102), (0.21523009641154156, 0.00709297482015403)):
        impacts = advance(problem, *start, 1, digits=60)[0].impacts
        assert all(impact.v_plus > 0 for impact in impacts)
        assert exact_period(m, start).impacts == len(impacts)
    assert exact_period(m, (0.21150387156487616, 0.01709258673871694)).outcome == CHATTER | STUCK


# ---- formulas and matrix exponentials

#: Damped, undamped and over-damped, of negative stiffness and damping, near resonance and near critical damping.
RATES = [(0.2, 1.1), (0.0, 1.3), (3.0, 1.0), (0.3, -0.4), (-0.1, 1.2), (0.01, 2.8901), (2.0, 1.001), (0.0, 0.0)]


@pytest.mark.parametrize(("alpha", "stiffness"), RATES)
def test_formulas_and_matrix_exponentials_agree(monkeypatch, alpha, stiffness):
    """Their balls overlap at all times, and the periods are the same; near singular cases there are no formulas."""
    force = gz.Forcing(omega=1.7, offset=-0.1, cos=(1.0, 0.2), sin=(0.3, 0.0))
    m = gz.Oscillator(alpha=alpha, stiffness=stiffness, forcing=force, reset=gz.newton(0.8))
    motion = Frame(m, 0, 0.3).motion
    assert bool(motion.formulas) is ((alpha, stiffness) in RATES[:5])
    flight = exact_flight.Flight(motion, arb(0.4), arb(0.1), arb(-0.3))
    starts = [(0.01 * i, 0.3 - 0.05 * i) for i in range(12)]
    found = [exact_period(m, start) for start in starts]
    times = [arb(x) for x in (1e-6, 1e-3, 0.1, 1.0, 3.0)]
    seen = [flight.at(s) for s in times]
    motion.formulas = False
    for (y, v), (y0, v0) in zip(seen, (flight.at(s) for s in times), strict=True):
        assert y.overlaps(y0) and v.overlaps(v0) and max(y.rad(), v.rad()) < 1e-12
    monkeypatch.setattr(exact_motion, "NEAR", math.inf)  # nothing is as far from singular cases as that
    assert not Frame(m, 0, 0.3).motion.formulas
    again = [exact_period(m, start) for start in starts]
    assert [(each.state, each.impacts, each.outcome) for each in again] == [
        (each.state, each.impacts, each.outcome) for each in found
    ]


@pytest.mark.parametrize(("alpha", "stiffness"), RATES)
@pytest.mark.parametrize("bits", [53, 128, 1024])
def test_series_and_matrix_exponentials_agree(monkeypatch, alpha, stiffness, bits):
    """Their balls overlap up to the longest time of a series, and a series is known no worse; so it is in any unit."""
    monkeypatch.setattr(ctx, "prec", bits)
    for unit in (1.0, 2.0**-40):
        force = gz.Forcing(omega=1.7 / unit, offset=-0.1, cos=(1.0, 0.2), sin=(0.3, 0.0))
        spring = stiffness / unit**2
        m = gz.Oscillator(alpha=alpha / unit, stiffness=spring, forcing=force, reset=gz.newton(0.8))
        motion = Frame(m, 0, 0.3 * unit).motion
        motion.formulas = False
        flight = exact_flight.Flight(motion, arb(0.4 * unit), arb(0.1 * unit**2), arb(-0.3 * unit))
        times = [arb(2) ** -n / motion.rate for n in (-0.99, 0, 3, 10, 200)]
        seen = [flight.at(s) for s in times]
        monkeypatch.setattr(exact_flight, "REACH", -1)
        for pair, other in zip(seen, (flight.at(s) for s in times), strict=True):
            for a, b in zip(pair, other, strict=True):
                assert a.overlaps(b) and (a.rad() <= 4 * b.rad() or a.rel_accuracy_bits() >= bits - 4)
        monkeypatch.undo()
        monkeypatch.setattr(ctx, "prec", bits)


# ---- ties


@pytest.mark.parametrize(
    ("m", "start"),
    [
        (constant(2.0, gz.active(0.8, 0.4)), (1.0, -2.0)),  # u = (t - 1)^2
        (constant(-1.0, gz.triggered(0.5, 1.0, 1.0)), (0.5, 0.0)),  # falls from 1/2: hits at speed 1
    ],
)
def test_an_exact_tie_stays_undecided(m, start):
    assert exact_period(m, start) is None


def test_beside_an_exact_graze():
    m = constant(2.0, gz.active(0.8, 0.4))
    assert in_doubles(m, (1.0, -2.0))[2] == GRAZE | AMBIGUOUS
    below, above = (exact_period(m, (float(np.nextafter(1.0, side)), -2.0)) for side in (0.0, 2.0))
    assert (below.impacts, above.impacts) == (1, 0)
    assert (below.outcome, above.outcome) == (0, 0)
    assert above.near == pytest.approx(2.0**-52)  # u = 2^-52 + (t - 1)^2
    assert below.slow == pytest.approx(2.0 * math.sqrt(2.0**-53))  # u = -2^-53 + (t - 1)^2
    assert (below.near, above.slow) == (math.inf, math.inf)
    assert below.state[1] - above.state[1] == pytest.approx(0.4, abs=1e-7)


def test_a_tie_of_exact_numbers_is_decided():
    """Without forces the ball hits at the very speed it started with."""
    bumper = gz.triggered(r=0.5, V=1.0, trigger=0.5)
    period = exact_period(constant(0.0, bumper), (0.25, -0.5))
    assert period.state[1] == 1.25
    assert exact_period(constant(0.0, bumper), (0.0, -0.5)).state[1] == 1.25


# ---- windows


def signs(m, bits=128):
    with ctx.workprec(bits):
        return [(float(window.end), window.sign) for window in Frame(m, 0, 0.0).windows]


def test_windows_of_a_zero_at_the_strobe():
    """F = sin t vanishes at the strobes themselves, exactly."""
    m = gz.Oscillator(1.0, 1.0, gz.Forcing(omega=1.0, cos=(0.0,), sin=(1.0,)), gz.newton(0.5))
    assert signs(m) == [(math.pi, 1), (2.0 * math.pi, -1)]


def test_windows_as_narrow_as_doubles_allow():
    ends = signs(gz.pinball(omega=1.0, t0=0.5, d=-math.nextafter(1.0, 0.0)))
    assert [window for _, window in ends] == [-1, 1, -1]
    assert ends[1][0] - ends[0][0] == pytest.approx(2.0 * math.sqrt(2.0**-52), rel=1e-7)


@pytest.mark.parametrize("t0", [0.0, -2.0])
def test_a_double_zero_is_no_edge(t0):
    """F = cos - 1 touches 0 and stays: decided as algebra, with any number of bits, at the strobe and inside."""
    assert signs(gz.pinball(omega=1.0, t0=t0, d=-1.0)) == [(2.0 * math.pi, -1)]
    assert signs(gz.pinball(omega=1.0, t0=t0, d=-math.nextafter(1.0, 2.0))) == [(2.0 * math.pi, -1)]
    m = gz.pinball(omega=1.0, t0=t0, d=-1.0, V=0.0)
    assert exact_period(m, (0.0, 0.0)) == Period((0.0, 0.0), (), True, STUCK, math.inf, math.inf)


@pytest.mark.parametrize("a", [0.1875, 0.25, 0.3125])
def test_a_zero_of_second_or_fourth_order_is_no_edge(a):
    """F = 1 - cos t + a (cos 2t - 1) = 2 sin^2(t/2) (1 - 4a cos^2(t/2))."""
    m = gz.Oscillator(1.0, 1.0, gz.Forcing(omega=1.0, t0=-2.0, offset=1.0 - a, cos=(-1.0, a)), gz.newton(0.5))
    half = 2.0 * math.acos(math.sqrt(0.25 / a)) if a > 0.25 else None
    ends = [2.0 - half, 2.0 + half] if half else []
    windows = signs(m)
    assert [t for t, _ in windows] == pytest.approx([*ends, 2.0 * math.pi])
    assert [sign for _, sign in windows] == ([1, -1, 1] if half else [1])


def test_a_flight_over_a_double_zero_is_decided():
    m = gz.pinball(omega=1.0, t0=-2.0, d=-1.0, V=0.3)
    point, said, _ = in_doubles(m, (0.5, 1.0))
    period = exact_period(m, (0.5, 1.0))
    assert period.state == pytest.approx(point, abs=1e-14)
    assert period.impacts == said


def test_zeros_of_fourth_order():
    q = np.polynomial.polynomial.polymul([1.0, -2.0, 1.0], [-0.3, 1.0])
    mean, *cos = np.polynomial.chebyshev.poly2cheb(q)
    for t0 in np.linspace(0.0, 6.2, 8):
        for side in (1.0, -1.0):
            problem = Problem(0.5, 1.0, 1.0, t0, side * mean, tuple(side * x for x in cos), law=active(0.8, 0.4))
            strobe, period = advance(problem, 0.3, 0.1, 1)[0], exact_period(model_of(problem), (0.3, 0.1))
            assert period.impacts == len(strobe.impacts)
            assert period.state == (float(strobe.u), float(strobe.v))


def test_a_phase_is_a_shift_of_time():
    m = gz.pinball(d=0.09, t0=0.25)
    assert exact_period(m, (0.1, 0.1), phase=0.5) == exact_period(m.replace(t0=0.75), (0.1, 0.1))


def test_thirty_harmonics():
    cos, sin = np.random.default_rng(30).normal(size=(2, 30)) / 30.0
    m = gz.Oscillator(1.0, 1.0, gz.Forcing(omega=1.0, offset=0.1, cos=cos, sin=sin), gz.active(0.8, 0.4))
    point, said, _ = in_doubles(m, (0.1, -0.1))
    period = exact_period(m, (0.1, -0.1))
    assert period.state == pytest.approx(point, rel=1e-12)
    assert period.impacts == said


# ---- the wall and the law


@pytest.mark.parametrize(
    ("m", "start", "expected"),
    [
        (constant(0.0, gz.newton(0.5)), (0.0, 0.0), Period((0.0, 0.0), (), False, 0, math.inf, math.inf)),
        (constant(-1.0, gz.newton(0.5)), (0.0, 0.0), Period((0.0, 0.0), (), True, STUCK, math.inf, math.inf)),
        (constant(-1.0, gz.newton(0.0)), (0.0, -1.0), Period((0.0, 0.0), (0,), False, STUCK, math.inf, 1.0)),
        (constant(-1.0, gz.newton(0.5)), (0.0, -1.0), Period((0.0, 0.0), (0,), False, STUCK | CHATTER, math.inf, 1.0)),
        (
            gz.pinball(d=-1.5, V=0.0, sigma=0.5, k=0.0),
            (0.5, 0.0),
            Period((0.5, 0.0), (), True, STUCK, math.inf, math.inf),
        ),
    ],
)
def test_rest(m, start, expected):
    assert exact_period(m, start) == expected
    point, said, outcome = in_doubles(m, start)
    assert (tuple(point), said, outcome) == (expected.state, letter(expected), expected.outcome)


def breaks(v, p):
    """A law that breaks its promise for middling impacts only."""
    if -0.9 < v < -0.3:
        return -0.1 if p.kind == 0.0 else math.inf
    return 0.1


@pytest.mark.parametrize("kind", [0.0, 1.0])
def test_a_law_that_breaks_its_promise(kind):
    m = gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2, offset=0.1), gz.reset(breaks, kind=kind))
    period = exact_period(m, (0.1, -0.9))
    assert period.outcome == BAD_LAW
    assert np.isnan(period.state).all()


def wordy(v, p):
    """Every operation that a law may use."""
    speed = abs(+v)
    gentle = 1.0 - p.r + 2.0 * p.r - (p.r - 0.5) - 0.5
    if speed != 0.0 and speed <= 10.0 and speed >= 1e-9 and not (v == 0.0):
        return max(
            gentle * -v / (1 - p.c * v) + 0.5 * speed**2 / (2.0 + speed) ** 1 + 1.0 / 2.0**speed - 1.0, p.c * speed
        )
    return p.c if bool(v) else 0.0


def test_a_law_of_many_operations():
    m = gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2, offset=0.1), gz.reset(wordy, r=0.8, c=0.1))
    for start in ((0.1, -0.3), (0.3, -1.0), (0.0, -0.5)):
        point, said, outcome = in_doubles(m, start)
        period = exact_period(m, start)
        assert period.state == pytest.approx(point, abs=1e-14)
        assert (period.impacts, period.outcome) == (said, outcome & ~AMBIGUOUS)


@pytest.mark.parametrize("law", [lambda v, p: math.sqrt(-v), lambda v, p: float(-v), lambda v, p: -v if True else ""])
def test_a_law_that_needs_floats_is_left_alone(law):
    m = gz.Oscillator(3.0, 1.0, gz.Forcing(omega=2.2, offset=0.1), gz.reset(law))
    assert (exact_period(m, (0.1, -0.9)) is None) == (
        "math" in law.__code__.co_names or "float" in law.__code__.co_names
    )


def test_numbers_for_laws_compare_only_what_is_certain():
    wide, one = Sure(arb(1.0, 1e-9)), Sure(1)
    assert wide < 2
    assert wide > Sure(0.5)
    assert 0.5 < wide <= 2.0
    assert one == 1.0
    assert wide != 2.0
    for ask in (lambda: wide < one, lambda: wide == 1.0, lambda: wide >= 1, lambda: bool(wide - 1.0)):
        with pytest.raises(Undecided):
            ask()
    for what in ("1", True, None, 1j):
        with pytest.raises(TypeError, match="is not a number that a ball can hold"):
            Sure(what)


def test_a_state_is_rounded_only_when_it_is_known():
    assert rounded(arb(0.5, 1e-30), 1.0) == 1.5
    assert rounded(arb(0), 1.0) == 1.0
    assert rounded(arb(0, arb(2) ** -1000), 1.0) == 1.0
    with pytest.raises(Undecided):
        rounded(arb(0.5, 1e-15), 1.0)
    with pytest.raises(Beyond):
        rounded(arb(1e308), 1e308)


# ---- bounds of the work


@pytest.mark.parametrize(
    ("m", "flag"),
    [
        (constant(-1.0, gz.newton(r=1.0)), TOO_MANY_IMPACTS),
        (gz.pinball(alpha=0.0, d=-0.1, sigma=-5.0, omega=1e-7), TOO_MANY_SWINGS),
        (gz.pinball(alpha=0.0, k=3e4, omega=1.0), 0),  # some 60,000 half turns
        (gz.pinball(omega=1e-60), 0),
    ],
)
def test_work_is_bounded(m, flag, monkeypatch):
    work = []
    monkeypatch.setattr(Motion, "count", lambda self, n, count=Motion.count: work.append(n) or count(self, n))
    start = (m.sigma, 1e-4)
    assert exact_period(m, start) is None
    assert sum(work) <= len(exact.PRECISIONS) * (exact_motion.BUDGET + 10)
    assert not flag or in_doubles(m, start)[2] & flag


@pytest.mark.parametrize("state", [(-0.1, 0.0), (math.nan, 0.0), (0.1, math.inf)])
def test_a_state_that_is_not_allowed_has_no_period(state):
    assert exact_period(gz.pinball(), state) is None


@pytest.mark.parametrize("V", [1e308, 1.7e308])
def test_a_ball_that_leaves_faster_than_doubles_tell(V):
    """The power of two above its speed was an OverflowError, out of a sweep."""
    m = gz.Oscillator(alpha=0.1, k=1.0, forcing=gz.Forcing(omega=2.2, cos=(1.0,)), reset=gz.active(r=0.8, V=V))
    assert exact_period(m, (0.0, 0.0), 1.0) is None
    assert exact_period(m.replace(V=1e300), (0.0, 0.0), 1.0).state[0] > 1e299


def test_the_precision_of_others_is_left_as_it_was():
    before = ctx.prec
    exact_period(constant(2.0, gz.active(0.8, 0.4)), (1.0, -2.0))
    assert ctx.prec == before


def test_threads_do_not_disturb_each_other():
    starts = [(0.1 + 0.01 * n, -0.1) for n in range(12)] + [(1.0, -2.0)]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda start: exact_period(gz.pinball(), start), starts))
    assert together == [exact_period(gz.pinball(), start) for start in starts]


def test_importing_it_is_cheap():
    source = str(Path(exact.__file__).parents[2])
    code = f"import sys; sys.path.insert(0, {source!r}); import grazing.oscillator.exact; print('flint' in sys.modules)"
    run = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["False"]


def beside_the_wall(m, random):
    """Return a start hardly above the wall at sigma = 0, which turns just above it, hits it, or is pressed on it."""
    c = packed(gz.stroboscopic_map(m))
    F = forcing(0.0, c)[0]
    if random.random() < 0.4:  # a graze after a millionth to a hundredth of a period
        s, depth = c.T * 10.0 ** random.uniform(-7.0, -2.0), 10.0 ** random.uniform(-26.0, -15.0)
        y, v = flight(s, anchored(0.0, 0.0, 0.0, c), c)
        start = np.linalg.solve(np.array(modes(s, c)).reshape(2, 2), [random.choice((1.0, -1.0)) * depth - y, -v])
        if start[0] > 0.0:
            return float(start[0]), float(start[1])
    y = 10.0 ** random.uniform(-320.0, -12.0)
    v = math.sqrt(2.0 * abs(F) * y) * (1.0 + random.choice((-1.0, 1.0)) * 10.0 ** random.uniform(-13.0, 0.0))
    return y, random.choice((-v, -v, v, 0.0, -(10.0 ** random.uniform(-160.0, -3.0))))


@pytest.mark.parametrize("law", [gz.active(0.8, 0.4), gz.triggered(0.6, 0.5, 1e-30)], ids=str)
def test_starts_beside_the_wall(law):
    """The search for an impact or a lowest point ends relative to the way that is left, however short that is."""
    random = np.random.default_rng(7)
    hits = decided = 0
    for i in range(75):
        alpha, k = random.choice((0.0, 0.3, 3.0)), random.choice((0.0, 1.0, 2.0))
        force = gz.Forcing(omega=random.uniform(1.0, 4.0), t0=random.uniform(-3.0, 3.0), offset=random.uniform(-1, 1))
        m = gz.Oscillator(alpha=alpha, k=k, forcing=force, reset=law)
        start = beside_the_wall(m, random)
        truth, orbit = exact_period(m, start), gz.stroboscopic_map(m).orbit(start, 1)
        if truth is None or orbit.outcomes[0] & AMBIGUOUS:
            continue
        decided, hits = decided + 1, hits + (truth.impacts > 0)
        letter = CHATTER_LETTER if truth.outcome & CHATTER else STUCK_LETTER if truth.lay else truth.impacts
        assert orbit.letters[0] == letter, (i, m, start)
        speed = min(1.0, truth.slow) if not truth.outcome & CHATTER else 1.0
        error = np.abs(orbit.points[-1] - truth.state).max()
        assert error * speed < 1e-13 or error < 1e-9, (i, m, start)
    assert decided > 60 and hits > 25
