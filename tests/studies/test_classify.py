"""Period, word and trust: theory's windows, closed forms, and the plain twin over many maps."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import grazing as gz
from grazing import theory
from grazing.orbits.word import least_rotation, least_start, primitive
from grazing.outcome import AMBIGUOUS, DIVERGED
from grazing.studies.classify import classify
from grazing.studies.recurrence import root_length
from grazing.studies.starts import random_starts
from tests.studies import twin
from tests.studies.maps import DOUBLE_WELL, FOLLOWER, HENON, PLANE_WELLS, SMOOTH, SPIRAL, states_in


def logistic(state, p):
    (x,) = state
    return (p.a * x * (1.0 - x),)


LOGISTIC = gz.Map(logistic, params={"a": 3.2}, coordinates=("x",), box=((0.0, 1.0),))


def settled(P, starts=60, transient=200, keep=50):
    lanes = random_starts(0, tuple(P.params.values()), starts, P.box)
    points, letters, outcomes = P.run(lanes, transient, keep)
    return classify(P, points, letters, outcomes[0])


WINDOWS = [
    (N, lam, l)
    for lam in (0.2, 0.34, 0.5, 0.9)
    for l in (0.0, 0.21, 0.8)
    for N in (2, 3, 4, 6)
    if theory.mu_pd(N, lam, l) < theory.mu_bc(N, lam, l)
]


@pytest.mark.parametrize(("N", "lam", "l"), WINDOWS)
def test_inside_a_window_the_maximal_orbit_is_named(N, lam, l):
    # Proposition 3.1: L^(N-1) R attracts for mu_pd < mu < mu_bc
    low, high = theory.mu_pd(N, lam, l), theory.mu_bc(N, lam, l)
    for share in (0.02, 0.5, 0.98):
        mu = low + share * (high - low)
        orbit = theory.maximal_orbit(N, lam, mu, l)
        P = gz.gap_map(lam, mu, l)
        points, letters, outcomes = P.run(np.array([[orbit[0]]]) * (1 + 1e-6), 200, 50)
        found = classify(P, points, letters, outcomes[0])
        assert (found.period[0], found.word[0], found.trust[0]) == (N, "L" * (N - 1) + "R", 0)


@pytest.mark.parametrize(("lam", "mu", "l"), [(0.34, 0.05, 0.21), (0.8, 0.5, 1.0), (0.5, 0.08, 0.0)])
def test_the_periods_found_are_those_whose_window_holds_mu(lam, mu, l):
    found = settled(gz.gap_map(lam, mu, l), transient=2000)
    held = {N for N in range(1, 12) if theory.mu_pd(N, lam, l) < mu < (theory.mu_bc(N, lam, l) if N > 1 else np.inf)}
    assert set(found.period.tolist()) <= held
    assert held


@pytest.mark.parametrize("beyond", [1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize(("N", "lam", "l"), [(3, 0.5, 0.1), (2, 0.34, 0.21), (4, 0.9, 0.8)])
def test_slow_alternation_at_a_period_doubling_is_not_a_doubled_orbit(N, lam, l, beyond):
    mu = theory.mu_pd(N, lam, l) * (1 + beyond)
    multiplier = theory.multiplier(N, lam, mu, l)
    assert -1 < multiplier < -0.95
    orbit = np.asarray(theory.maximal_orbit(N, lam, mu, l))
    P = gz.gap_map(lam, mu, l)
    for size in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11):
        starts = orbit[:1, None] * (1 + size * (1 + multiplier) ** 0.5)  # inside the unstable doubled orbit
        points, letters, outcomes = P.run(starts.copy(), 0, 50)
        found = classify(P, points, letters, outcomes[0])
        assert (found.period[0], found.word[0]) == (N, "L" * (N - 1) + "R")


def test_recurrence_alone_would_have_said_twice_the_period():
    N, lam, l = 3, 0.5, 0.1
    mu = theory.mu_pd(N, lam, l) * (1 + 1e-7)
    orbit = np.asarray(theory.maximal_orbit(N, lam, mu, l))
    P = gz.gap_map(lam, mu, l)
    points, letters, outcomes = P.run(orbit[:1, None] + 1e-6, 0, 50)
    extent = np.ptp(points)
    assert np.abs(points[6:] - points[:-6]).max() < 1e-9 * extent < np.abs(points[3:] - points[:-3]).max()
    assert classify(P, points, letters, outcomes[0]).period[0] == 3


def test_before_the_period_doubling_the_orbit_is_not_named():
    mu = theory.mu_pd(3, 0.5, 0.1) * (1 - 1e-4)
    orbit = np.asarray(theory.maximal_orbit(3, 0.5, mu, 0.1))
    P = gz.gap_map(0.5, mu, 0.1)
    points, letters, outcomes = P.run(orbit[:1, None] * (1 + 1e-5), 0, 50)
    assert (letters[3:] == letters[:-3]).all()  # it still looks like the orbit
    assert classify(P, points, letters, outcomes[0]).period[0] == -1


@pytest.mark.parametrize("l", [0.0, 0.001])
def test_chaos_has_no_period(l):
    found = settled(gz.gap_map(lam=0.9, mu=0.1, l=l), starts=300)
    assert set(found.period.tolist()) == {-1}
    assert set(found.word.tolist()) == {""}


@pytest.mark.parametrize("a", [3.58, 3.6, 3.64, 3.7, 3.9, 4.0])
def test_chaos_without_letters_has_no_period(a):
    # one to four bands: letters say nothing here, and every band returns near itself
    assert set(settled(LOGISTIC.replace(a=a)).period.tolist()) == {-1}


@pytest.mark.parametrize(
    ("a", "period"),
    [(0.9, 1), (2.0, 1), (2.99, 1), (2.9999, 1), (3.2, 2), (3.44, 2), (3.5, 4), (3.55, 8), (3.566, 16), (3.83, 3)],
)
def test_logistic_map(a, period):
    found = settled(LOGISTIC.replace(a=a), transient=2000 if a != 0.9 else 100)
    assert set(found.period.tolist()) == {period}
    assert set(found.word.tolist()) == {"0"}
    assert set(found.trust.tolist()) == {1}  # no exact tangent


def test_just_beyond_a_supercritical_doubling_the_doubled_orbit_is_named():
    assert set(settled(LOGISTIC.replace(a=3.001), transient=20_000).period.tolist()) == {2}
    assert set(settled(LOGISTIC.replace(a=2.999), transient=200).period.tolist()) == {1}


def test_a_map_in_three_dimensions():
    # a driven cycle of period 4 in two phases that do not feel each other, and a contraction that follows
    def step(state, p):
        x, y, z = state
        return (-y, x, p.c * z + x), (1 if x > 0.0 else 0), 0

    P = gz.Map(
        step, params={"c": 0.5}, coordinates=("x", "y", "z"), box=((0.1, 1.0),) * 3, letters="-+", name="spinning"
    )
    found = settled(P)
    assert set(found.period.tolist()) == {4}
    assert set(found.word.tolist()) == {"--++"}

    def turning(state, p):
        x, y, z = state
        return (0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y, p.c * z + x), 0, 0  # an angle that is no part of a turn

    Q = gz.Map(turning, params={"c": 0.5}, coordinates=("x", "y", "z"), box=((0.1, 1.0),) * 3)
    assert set(settled(Q).period.tolist()) == {-1}


def test_a_slow_spiral_into_a_fixed_point():
    def step(state, p):
        x, y = state
        return p.r * (0.8 * x - 0.6 * y) + 1.0, p.r * (0.6 * x + 0.8 * y)

    P = gz.Map(step, params={"r": 0.995}, coordinates=("x", "y"), box=((-1.0, 1.0), (-1.0, 1.0)))
    assert set(settled(P, transient=100).period.tolist()) == {1}


@pytest.mark.parametrize("turn", [1.3, 2.0, math.pi])
def test_a_fixed_point_that_rounding_goes_round_is_no_cycle(turn):
    # so much rounding in each step, 1/(1 - r) times as much away from the point: more than the tolerance
    P = SPIRAL.replace(r=1.0 - 1e-4, turn=turn, shift=0.6)
    found = settled(P, transient=400_000)
    assert set(found.period.tolist()) == {1}


@pytest.mark.parametrize(("V", "d", "word"), [(0.4, 0.12, "001"), (0.0, 0.12, "01"), (0.4, 0.15, "0")])
def test_oscillator(V, d, word):
    found = settled(gz.stroboscopic_map(gz.pinball(alpha=3, k=1, omega=2.2, t0=0, r=0.8, V=V, d=d)))
    assert set(found.word.tolist()) == {word}
    assert set(found.period.tolist()) == {len(word)}
    assert 1 not in found.trust


@pytest.mark.parametrize("phase", [0.3, 1.1, 2.5])
def test_the_strobe_does_not_change_a_one_impact_word(phase):
    assert set(settled(gz.stroboscopic_map(gz.pinball(), phase)).word.tolist()) == {"001"}


@pytest.mark.parametrize("power", range(-20, 21, 4))
def test_what_drifts_for_ever_has_no_period(power):
    """Its multiplier is 1 to rounding. Where that came out below, a cycle beyond all numbers was "approached"."""
    T, rng = 2.0**power, np.random.default_rng(0)
    for alpha, omega, force in rng.uniform((0.05, 0.3, 0.05), (3.0, 4.0, 0.5), (60, 3)):
        push = gz.Forcing(omega / T, offset=force / T**2, cos=(0.7 / T**2,))
        P = gz.stroboscopic_map(gz.Oscillator(alpha / T, 0.0, push, gz.newton(0.5)))
        points, letters, outcomes = P.run(np.array([[0.1, 0.3], [0.2 / T, -0.1 / T]]), 150, 24)
        assert classify(P, points, letters, outcomes[0]).period.tolist() == [-1, -1]


def test_ended_ambiguous_and_undecided():
    points = np.zeros((50, 1, 4))
    points[10:, 0, 1] = np.nan
    letters = np.zeros((50, 4), np.int64)
    outcomes = np.array([DIVERGED, 0, AMBIGUOUS, 0])
    G = gz.gap_map(0.5, 0.1, 0.1)
    found = classify(G, points, letters, outcomes)
    assert found.period.tolist() == [-2, -2, 1, 1]
    assert found.word.tolist() == ["", "", "L", "L"]
    assert found.trust.tolist() == [0, 0, 2, 0]
    assert classify(G, points[:1], letters[:1], outcomes * 0).period.tolist() == [0, 0, 0, 0]


def test_letters_must_repeat_as_well():
    points = np.zeros((12, 2, 1))
    G = gz.gap_map(0.5, 0.1, 0.1)
    letters = np.array([0, 1] * 6)[:, None]
    found = classify(G, points, letters, np.zeros(1, np.int64))
    assert (found.period[0], found.word[0]) == (2, "LR")
    letters = np.array([0, 1, *[0] * 10])[:, None]  # once, and long ago
    assert classify(G, points, letters, np.zeros(1, np.int64)).period[0] == -1


def test_one_coincidence_is_not_a_period():
    rng = np.random.default_rng(1)
    points = rng.random((40, 1, 3))
    points[-1 - 7] = points[-1]  # the last point was there before, the others were not
    letters = np.zeros((40, 3), np.int64)
    assert classify(LOGISTIC, points, letters, np.zeros(3, np.int64)).period.tolist() == [-1, -1, -1]


def test_the_tolerance_counts():
    cycle = np.array([1.0, 2.0, 4.0])
    rng = np.random.default_rng(0)
    points = np.tile(cycle, 10)[:, None, None] + 1e-7 * rng.random((30, 1, 1))
    letters = np.tile([0, 0, 1], 10)[:, None]
    zero = np.zeros(1, np.int64)
    G = gz.gap_map(0.5, 0.1, 0.1)
    assert classify(G, points, letters, zero, tolerance=1e-6).period[0] == 3
    assert classify(G, points, letters, zero).period[0] == -1


def test_orbits_do_not_decide_about_each_other():
    P = gz.gap_map(0.5, theory.mu_pd(3, 0.5, 0.1) + 1e-3, 0.1)
    points, letters, outcomes = P.run(random_starts(0, (1.0,), 60, P.box), 200, 50)
    together = classify(P, points, letters, outcomes[0])
    assert len(set(together.period.tolist())) > 1
    for i in range(60):
        alone = classify(P, points[:, :, i : i + 1], letters[:, i : i + 1], outcomes[0, i : i + 1])
        assert (alone.period[0], alone.word[0]) == (together.period[i], together.word[i])


def doubtful_gap_maps():
    """Gap maps on both sides of the edges of their windows, where classification is hard."""
    for N, lam, l in ((2, 0.5, 0.1), (3, 0.5, 0.1), (4, 0.9, 0.8), (3, 0.34, 0.21)):
        edges = theory.mu_pd(N, lam, l), theory.mu_bc(N, lam, l)
        for edge in edges:
            for off in (-1e-2, -1e-4, -1e-7, 1e-7, 1e-4, 1e-2):
                yield gz.gap_map(lam, edge * (1 + off), l)


def rattle(alpha, offset, unit=1.0):
    """A mass without a spring between two walls, forced so weakly that it need not touch them."""
    walls = (gz.wall(-unit, gz.newton(0.6)), gz.wall(unit, gz.newton(0.6)))
    force = gz.Forcing(omega=1.0, offset=offset * unit, cos=(0.2 * unit,))
    return gz.Oscillator(alpha=alpha, k=0.0, forcing=force, walls=walls)


MANY = {
    "gap maps": [gz.gap_map(lam, mu, l) for lam in (0.3, 0.8) for l in (0.0, 0.2) for mu in (0.03, 0.1, 0.4)],
    "gap maps at edges": list(doubtful_gap_maps()),
    "logistic": [LOGISTIC.replace(a=a) for a in (0.9, 1.0, 2.99, 3.0, 3.001, 3.4495, 3.5, 3.5441, 3.57, 3.828427)],
    "logistic, own derivative": [SMOOTH.replace(a=a) for a in (2.99, 3.01, 3.449, 3.55, 3.83, 3.9)],
    "Henon": [HENON.replace(a=a) for a in (0.2, 0.36, 0.368, 0.9, 0.912, 1.0, 1.06, 1.25, 1.4, 3.0)],
    "spirals": [SPIRAL.replace(turn=t, r=r) for t in (0.0, 0.3, 1.0, np.pi / 2, 2.0, 3.0, np.pi) for r in (0.5, 0.97)],
    "a turn without damping": [SPIRAL.replace(r=1.0, turn=t) for t in (1.0, np.pi / 2, 2 * np.pi / 5)],
    "three dimensions": [FOLLOWER.replace(a=a, c=c) for a in (2.9, 2.995, 3.2, 3.45, 3.5, 3.9) for c in (-0.3, 0.97)],
    "wells": [DOUBLE_WELL.replace(a=a) for a in (0.5, 1.5, 1.99, 2.001, 2.2, 2.3, 2.7)],
    "wells in the plane": [PLANE_WELLS.replace(a=a) for a in (1.5, 1.999, 2.1, 2.25)],
    "oscillator": [
        gz.stroboscopic_map(model)
        for model in (
            gz.pinball(V=0.4, d=0.12), gz.pinball(V=0.0, d=0.05), gz.pinball(V=0.4, d=0.0985), gz.pinball(r=0.3, V=0.0),
            gz.pinball(V=0.4, d=0.1232), gz.pinball(alpha=0.1, V=0.1), gz.pinball(alpha=0.0, r=1.0, V=0.0),
        )
    ],
    "impact map": [gz.impact_map(gz.pinball(V=0.4, d=d)) for d in (0.05, 0.12)],
    "no spring": [gz.stroboscopic_map(rattle(alpha, offset)) for alpha in (0.02, 0.1, 2.0) for offset in (0.0, 1e-3)],
}  # fmt: skip


@pytest.mark.parametrize("kind", MANY)
@pytest.mark.parametrize(("transient", "keep"), [(0, 40), (60, 64), (400, 50), (30, 7)])
def test_many_orbits_are_what_the_plain_rule_says(kind, transient, keep):
    for P in MANY[kind]:
        points, letters, outcomes = P.run(states_in(P, 5), transient, keep)
        found = classify(P, points, letters, outcomes[0])
        said = found.period.tolist(), found.word.tolist(), found.trust.tolist()
        assert said == twin.classified(P, points, letters, outcomes[0]), P


@pytest.mark.parametrize("tolerance", [1e-12, 1e-6, 1e-3])
def test_the_tolerance_is_that_of_the_plain_rule(tolerance):
    for P in (LOGISTIC.replace(a=3.57), gz.gap_map(0.5, 0.0405, 0.1), HENON.replace(a=1.06), SPIRAL.replace(r=0.99)):
        points, letters, outcomes = P.run(states_in(P, 10), 100, 60)
        found = classify(P, points, letters, outcomes[0], tolerance)
        assert found.period.tolist() == twin.classified(P, points, letters, outcomes[0], tolerance)[0]


@pytest.mark.parametrize("unit", [1.0, 2.5e-4])
def test_a_flight_that_no_spring_holds_has_the_period_of_the_one_that_it_approaches(unit):
    """Velocities settle by exp(-alpha T) a period, and where the ball ends is a matter of where it began."""
    P = gz.stroboscopic_map(rattle(0.1, 0.0, unit))
    for transient in (10, 60, 500):
        points, letters, outcomes = P.run(unit * np.array([[-0.3, 0.0, 0.2], [0.02, 0.0, -0.01]]), transient, 50)
        found = classify(P, points, letters, outcomes[0])
        assert found.period.tolist() == [1, 1, 1] and found.word.tolist() == ["0", "0", "0"]
        assert len(np.unique(points[-1, 0].round(9))) == 3 or unit < 1.0
    force = gz.Forcing(omega=1.0, offset=-1e-4, cos=(0.0,))
    falling = gz.stroboscopic_map(gz.Oscillator(0.1, 0, force, gz.newton(0.6), sigma=-1e6))
    points, letters, outcomes = falling.run(np.array([[1.0], [0.0]]), 500, 50)
    assert classify(falling, points, letters, outcomes[0]).period.tolist() == [-1]  # it drifts


def test_an_orbit_that_arrives_while_it_is_watched():
    # superstable: at the fixed point to the last bit after six steps or so
    for a, start in ((2.0, 0.3), (2.0, 0.9), (2.2, 0.5)):
        P = SMOOTH.replace(a=a)
        points, letters, outcomes = P.run(np.array([[start]]), 0, 64)
        assert (points[40:] == points[-1]).all() or a != 2.0
        assert classify(P, points, letters, outcomes[0]).period[0] == 1
    P = SPIRAL.replace(r=0.3, turn=0.25)
    points, letters, outcomes = P.run(np.array([[0.5], [0.5]]), 20, 60)
    assert classify(P, points, letters, outcomes[0]).period[0] == 1


def test_the_period_limit_is_half_of_what_is_kept():
    for N in (2, 3, 4, 5):
        lam, l = 0.5, 0.4
        w = theory.window(N, lam, l).stability
        P = gz.gap_map(lam, 0.5 * (w.low + w.high), l)
        x = theory.maximal_orbit(N, lam, P.params["mu"], l)[:1, None]
        for keep in range(2, 4 * N):
            points, letters, outcomes = P.run(x.copy(), 0, keep)
            assert classify(P, points, letters, outcomes[0]).period[0] == (N if keep >= 2 * N else -1)


@given(st.lists(st.integers(-2, 3), min_size=1, max_size=24), st.integers(1, 3))
def test_roots_and_rotations_are_those_of_words(letters, times):
    s = np.array([9, 9, *letters * times], np.int64)
    p = root_length(s, 2, len(letters) * times)
    assert p == len(primitive(letters))
    start = least_start(s, 2, p)
    assert tuple(s[2 + (start + n) % p] for n in range(p)) == least_rotation(primitive(letters))


def test_words_of_many_letters_are_kept_apart():
    rng = np.random.default_rng(0)
    keep, n = 64, 4000
    half = rng.integers(0, 2, (keep // 2, n))
    letters = np.concatenate([half, half])
    points = letters[:, None] + np.concatenate(
        [(np.arange(keep // 2)[:, None, None] * 0.01 + 1.0) * np.ones((1, 1, n))] * 2
    )
    found = classify(gz.gap_map(0.5, 0.1, 0.1), points, letters, np.zeros(n, np.int64))
    assert set(found.period.tolist()) == {keep // 2}
    for j in range(n):
        assert found.word[j] == "".join("LR"[k] for k in least_rotation(primitive(half[:, j])))


def test_not_a_number_infinite_and_huge_points():
    G = gz.gap_map(0.5, 0.1, 0.1)
    x = np.ones((20, 1, 5))
    x[3, 0, 0], x[3, 0, 1], x[-1, 0, 2] = np.nan, np.inf, -np.inf
    x[:, 0, 3] = 1e300 * np.where(np.arange(20) % 2, 1.0, -1.0)
    x[:, 0, 4] = 0.0
    found = classify(G, x, np.zeros((20, 5), np.int64), np.zeros(5, np.int64))
    assert found.period.tolist() == [-2, -2, -2, 2, 1]


def test_a_small_coordinate_beside_a_large_one_has_a_tolerance_of_its_own():
    # the absolute part of the tolerance was made of the largest coordinate, here ten times what the other one moves by
    P = gz.Map(lambda state, p: (-state[0], state[1]), coordinates=("x", "y"), box=((-1e-8, 1e-8), (0.0, 2e6)))
    points, letters, outcomes = P.run(np.array([[1e-8], [1e6]]), 0, 40)
    assert classify(P, points, letters, outcomes[0]).period.tolist() == [2]


@pytest.mark.parametrize("T", [2.0**-40, 2.0**40])
def test_periods_do_not_depend_on_the_unit_of_time(T):
    def periods(T):
        push = gz.Forcing(2.2 / T, offset=0.1 / T**2, cos=(1.0 / T**2,))
        P = gz.stroboscopic_map(gz.Oscillator(3.0 / T, 1.0 / T, push, gz.active(0.8, 0.4 / T)))
        offsets = np.linspace(0.09, 0.13, 40) / T**2
        starts = np.array([[0.1, 0.2], [0.5, -0.3]]) * (1.0, 1.0 / T)
        found = gz.orbit_diagram(P, "offset", offsets, starts=starts, transient=20, keep=40, arithmetic="strict")
        return found.period.values.tolist()

    plain = periods(1.0)
    assert len(np.unique(plain)) > 2 and periods(T) == plain


def test_beside_a_multiplier_of_one_a_search_ends_undecided():
    """Every number of steps brings such an orbit nearer; cycles of all of them were sought, for minutes."""
    settled = classify(LOGISTIC.replace(a=1.0), *algebraic(3000))
    assert settled.period.tolist() == [0]


def algebraic(keep):
    x = [0.5]
    for _ in range(keep - 1):
        x.append(x[-1] * (1.0 - x[-1]))
    return np.array(x)[:, None, None], np.zeros((keep, 1), np.int64), np.zeros(1, np.int64)
