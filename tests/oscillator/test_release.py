"""A ball at rest is released where the force truly turns: pairs of zeros however close, against other arithmetic."""

import math

import numpy as np
import pytest

import grazing as gz
from grazing.oscillator.exact import exact_period
from grazing.oscillator.windows import window_edges
from grazing.outcome import AMBIGUOUS, CHATTER
from grazing.parameter import parameters
from tests.reference.exact import Law, Problem, advance

KICKED = gz.triggered(r=0.5, V=0.4, trigger=1e-30)
DEAD = gz.newton(r=0.0)
TRUTH = (0.15823, -0.33175)


def touched(offset, law):
    """Return the map whose force is below 0 but for a moment in the middle of the period."""
    m = gz.Oscillator(alpha=0.3, k=1.0, forcing=gz.Forcing(omega=2.0, offset=offset, cos=(1.0,)), reset=law)
    return gz.stroboscopic_map(m, phase=1.0)


def plain_step(P, state):
    return P.step(state, P.prepare(parameters(P.params)))


@pytest.mark.parametrize("above", [1e-15, 1e-13, 1e-10, 1e-6])
@pytest.mark.parametrize("law", [KICKED, DEAD])
def test_a_ball_is_released_however_short_the_force_lifts_it(above, law):
    P = touched(-1.0 + above, law)
    orbit = P.orbit((0.0, 0.0), 1)
    strobe = advance(problem_of(P.model), 0.0, 0.0, 1, digits=60, start=1.0)[0]
    assert (orbit.letters.tolist(), orbit.undecided) == ([len(strobe.impacts)], 0)
    if law is KICKED and above < 1e-12:
        assert orbit.points[1] == pytest.approx(TRUTH, abs=1e-5)
    close = 1e-14 if above < 1e-8 else 1e-9  # doubles are sure of their decisions, and lose digits at slow impacts
    assert orbit.points[1] == pytest.approx((float(strobe.u), float(strobe.v)), rel=close, abs=1e-30)


@pytest.mark.parametrize("above", [0.0, -1e-16])
@pytest.mark.parametrize("law", [KICKED, DEAD])
def test_a_force_that_does_not_rise_above_0_releases_no_ball(above, law):
    """Not even in doubt, and for as many periods as one likes: what changes nothing is asked once."""
    orbit = touched(-1.0 + above, law).orbit((0.0, 0.0), 500)
    assert (orbit.undecided, set(orbit.letters.tolist())) == (0, {-2})
    assert not (orbit.outcomes & AMBIGUOUS).any()


@pytest.mark.parametrize(
    ("above", "sure"), [(0.0, False), (1e-15, False), (1e-13, False), (1e-11, False), (1e-6, True)]
)
def test_doubles_alone_say_what_they_do_not_know(above, sure):
    """The impact map asks for no more digits; where zeros are further apart nothing is in doubt."""
    Q = gz.impact_map(touched(-1.0 + above, KICKED).model)
    assert (plain_step(Q, (1.0, 0.0))[2] & AMBIGUOUS == 0) is sure


def test_a_zero_at_the_strobe_itself_is_in_no_doubt():
    """F = sin presses the ball up to the very end of the period; with a cosine of 1e-17 it could be just before."""
    m = gz.Oscillator(0.3, 1.0, gz.Forcing(omega=2.0, cos=(0.0,), sin=(1.0,)), DEAD)
    assert [plain_step(gz.stroboscopic_map(x), (0.0, 0.0))[2] & AMBIGUOUS for x in (m, m.replace(cos1=1e-17))] == [
        0,
        AMBIGUOUS,
    ]


def window(below, above):
    """Return the coefficients of e^{i phi} .. e^{-i phi} of a factor that is 0 at two phases."""
    middle, half = 0.5 * (below + above), 0.5 * (above - below)
    return np.array([0.5 * np.exp(1j * middle), -math.cos(half), 0.5 * np.exp(-1j * middle)])


def near_pairs(count, seed, more=1):
    """Yield maps with random forcings, two or more zeros of which are 1e-2 ... 1e-12 of a turn apart, and starts.

    The strobe is before the pair, in it, or within 1e-7 T; ``more`` pairs make clusters of zeros.
    """
    rng = np.random.default_rng(seed)
    for _ in range(count):
        near, gap = rng.uniform(0.0, 2.0 * np.pi), 2.0 * np.pi * 10.0 ** rng.uniform(-12.0, -2.0)
        product = window(near - gap / 2, near + gap / 2)
        for _ in range(rng.integers(0, more + 1)):
            wide = 2.0 * np.pi * 10.0 ** rng.uniform(-8.0, -1.0)
            other = near + rng.uniform(-1.0, 1.0) * wide
            pairs = (window(other - wide / 2, other + wide / 2), window(*np.sort(rng.uniform(0.0, 6.28, 2))))
            product = np.convolve(product, pairs[rng.integers(0, 2)])
        size = rng.choice([1.0, -1.0, 1e-9, 1e9])
        product = product * (size / np.abs(product).max())
        m = len(product) // 2
        mean = product[m].real
        for _ in range(rng.integers(0, 4)):
            mean = np.nextafter(mean, rng.choice([-math.inf, math.inf]))
        omega, t0 = 10.0 ** rng.uniform(-1.0, 1.0), rng.choice([0.0, rng.uniform(-3.0, 3.0)])
        k, sigma = rng.choice([0.0, 1.0]), rng.choice([0.0, 0.0, -0.25])
        cos, sin = (2.0 * product[m + 1 :].real).tolist(), (-2.0 * product[m + 1 :].imag).tolist()
        law = gz.triggered(*((0.5, 0.4 * abs(size), 1e-150), (0.0, 0.0, 1.0), (0.8, 0.0, 1.0))[rng.integers(0, 3)])
        forcing = gz.Forcing(omega, t0, float(mean + k * k * sigma), cos, sin)
        model = gz.Oscillator(rng.choice([0.0, 0.3, 3.0]), k, forcing, law, sigma)
        before = (rng.uniform(0.0, 0.05) * model.period, rng.uniform(-1, 1) * gap / omega, 1e-7 * model.period)
        phase = near / omega - t0 - before[rng.integers(0, 3)]
        start = (sigma, 0.0) if rng.random() < 0.7 else (sigma + 0.1 * rng.random(), rng.normal())
        yield gz.stroboscopic_map(model, float(phase)), start


def problem_of(m):
    law = Law(m.reset.params["r"], m.reset.params.get("V", 0.0), m.reset.params.get("trigger", 0.0))
    f = m.forcing
    return Problem(m.alpha, m.k, f.omega, f.t0, f.offset, tuple(f.cos), tuple(f.sin), m.sigma, law)


def compared(P, start):
    """Compare a step in doubles with balls; return whether it was sure."""
    m = P.model
    point, letter, outcome = plain_step(P, start)
    if outcome & AMBIGUOUS:
        return False
    period = exact_period(m, start, P.params["phase"])
    if period is None:  # too much work
        return False
    truth = -1 if period.outcome & CHATTER else (-2 if period.lay else period.impacts)
    assert letter == truth, (m, P.params["phase"], start)
    c = P.prepare(parameters(P.params))
    size = max(c.size, abs(m.sigma), *map(abs, start), *map(abs, period.state))
    slow = min(1.0, period.slow / size)
    assert np.abs(np.subtract(point, period.state)).max() * slow < 1e-12 * size * max(1.0, c.rate)
    return True


def test_no_sure_step_is_wrong_beside_near_zeros():
    sure = [compared(P, start) for P, start in near_pairs(40, 8)]
    assert 8 < sum(sure) < 35


@pytest.mark.long
@pytest.mark.parametrize("seed", range(10))
def test_no_sure_step_is_wrong_beside_many_near_zeros(seed):
    for P, start in near_pairs(200, seed, more=2):
        compared(P, start)


def test_balls_agree_with_a_program_that_knows_no_windows():
    """The reference expands the force and the flight in Taylor series at every step and asks for no sign of F."""
    for P, (u, v) in near_pairs(15, 80):
        period = exact_period(P.model, (u, v), P.params["phase"])
        if period is None or P.model.reset.params["V"] == 0.0:
            continue  # it follows chatter to the end impact by impact
        strobe = advance(problem_of(P.model), u, v, 1, digits=80, start=P.params["phase"])[0]
        assert period.impacts == len(strobe.impacts)
        scale = max(abs(float(strobe.u)), abs(float(strobe.v)), 1e-300)
        assert np.abs(np.subtract(period.state, (float(strobe.u), float(strobe.v)))).max() < 1e-14 * scale


def test_windows_without_doubt_are_those_of_the_algebra():
    """Wherever the doubles are sure of all windows, balls find as many edges, at the same times."""
    from flint import ctx

    from grazing.oscillator.exact import Frame

    sure = 0
    for P, _ in near_pairs(80, 81):
        c = P.prepare(parameters(P.params))
        if any(c.doubtful):
            continue
        with ctx.workprec(256):
            windows = Frame(P.model, 0, P.params["phase"]).windows
        inside = [edge for edge in c.edges[1:] if edge < c.T]
        assert inside == pytest.approx([float(w.end) for w in windows[:-1]], rel=0.0, abs=2e-12 * c.T)
        assert c.first == windows[0].sign
        sure += 1
    assert sure > 10


def test_a_quadruple_zero_is_in_doubt():
    """F = (1 - cos)^2 - e: nothing between 1e-5 and 1e-4 of a turn can be told apart in doubles."""
    for e in (0.0, 1e-17, 1e-13):
        doubtful = window_edges(1.5 - e, (-2.0, 0.5), (0.0, 0.0), 1.0, 2.0, 2.0 * math.pi, 4.0, (0.0,) * 6)[2]
        assert doubtful[0] == 1.0
