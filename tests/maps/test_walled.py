"""An oscillator between walls: against one wall, mirrors, other integrators, closed forms, and built grazes."""

import math

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import grazing as gz
from grazing.maps.hits import CHATTER, LAY, MANY
from grazing.outcome import FATAL, Outcome
from grazing.parameter import parameters

#: Over-damped, under-damped, undamped, critical and free flights, with one harmonic or two.
FLIGHTS = {
    "over": (3.0, 1.0, gz.Forcing(omega=2.2, offset=0.12)),
    "under": (0.2, 1.1, gz.Forcing(omega=1.7, t0=0.2, offset=0.1, cos=(1.2, 0.3))),
    "undamped": (0.0, 2.0, gz.Forcing(omega=1.3, cos=(1.0, 0.4), sin=(0.2,))),
    "critical": (2.0, 1.0, gz.Forcing(omega=1.0, cos=(2.0,))),
    "free": (0.0, 0.0, gz.Forcing(omega=2.0, cos=(1.5,))),
    "dragged": (0.3, 0.0, gz.Forcing(omega=2.0, offset=-0.1, cos=(1.5,))),
}


def starts(P, n, seed=0):
    box = np.array(P.box)
    return np.random.default_rng(seed).uniform(box[:, 0], box[:, 1], (n, 2))


@pytest.mark.parametrize("walls", [(0.1,), (-0.5, 0.6), (0.9,)], ids=["below", "two", "above"])
@pytest.mark.parametrize(
    "moves", [None, gz.Forcing(omega=1.7, t0=0.2, cos=(0.1, 0.05), sin=(0.02,))], ids=["", "moves"]
)
def test_the_box_has_the_walls_where_the_map_has_them_at_the_strobe(walls, moves):
    alpha, k, force = FLIGHTS["under"]
    side = {"side": "above"} if walls == (0.9,) else {}
    m = gz.Oscillator(alpha, k, force, walls=[gz.wall(at, gz.newton(0.6), motion=moves, **side) for at in walls])
    P = gz.stroboscopic_map(m, phase=0.7)
    c, (low, high) = P.prepare(parameters(P.params)), P.box[0]
    ends = [(at - low) / (high - low) for at in ([c.za, c.zb] if c.two else [c.za])]
    np.testing.assert_allclose(ends, [-1e-3 / 0.998, 1.0 + 1e-3 / 0.998][-1 if side else 0 :][: len(walls)], rtol=1e-9)
    assert P.box[1][0] < min(c.wa, c.wb) and P.box[1][1] > max(c.wa, c.wb)


def test_more_harmonics_than_flights_are_compiled_for_are_refused_at_once():
    walls = gz.wall(-0.3, gz.newton(0.7)), gz.wall(0.5, gz.newton(0.8))
    model = gz.Oscillator(0.2, 1.3, gz.Forcing(omega=2.1, cos=(0.01,) * 201), walls=walls)
    with pytest.raises(gz.InputError, match="201 harmonics"):
        gz.stroboscopic_map(model)


def symbols(P, letters):
    return [P.letters.symbol(int(letter)) for letter in letters]


# ---- against one wall


@pytest.mark.parametrize("flight", FLIGHTS)
@pytest.mark.parametrize("law", [gz.active(r=0.8, V=0.4), gz.newton(0.6), gz.triggered(0.5, 0.4, 0.1)], ids=repr)
def test_a_wall_out_of_reach_changes_no_bit(flight, law):
    alpha, k, force = FLIGHTS[flight]
    far = gz.wall(1e3, gz.newton(0.5))
    one = gz.stroboscopic_map(gz.Oscillator(alpha, k, force, law, sigma=-0.1), phase=0.3)
    two = gz.stroboscopic_map(gz.Oscillator(alpha, k, force, walls=(gz.wall(-0.1, law), far)), phase=0.3)
    for start in starts(one, 6):
        a, b = one.orbit(start, 20), two.orbit(start, 20)
        np.testing.assert_array_equal(a.points, b.points)
        np.testing.assert_array_equal(a.outcomes, b.outcomes)
        plain = a.letters >= 0
        counted = np.array([symbol.count("A") for symbol in symbols(two, b.letters)])
        assert (counted[plain & (b.letters >= 0)] == a.letters[plain & (b.letters >= 0)]).all()
        assert (b.letters[~plain] == a.letters[~plain]).all()  # C and S of wall A have the codes of one wall
        np.testing.assert_array_equal(one.jacobian(start), two.jacobian(start))


@pytest.mark.parametrize("flight", FLIGHTS)
def test_a_single_wall_above_is_the_mirror_of_one_below(flight):
    alpha, k, force = FLIGHTS[flight]
    law = gz.active(r=0.7, V=0.1)
    turned = gz.Forcing(force.omega, force.t0, -force.offset, [-c for c in force.cos], [-s for s in force.sin])
    below = gz.stroboscopic_map(gz.Oscillator(alpha, k, force, law, sigma=-0.2))
    above = gz.stroboscopic_map(gz.Oscillator(alpha, k, turned, walls=[gz.wall(0.2, law, side="above")]))
    assert above.letters is None
    for start in starts(below, 6):
        a, b = below.orbit(start, 12), above.orbit(-start, 12)
        np.testing.assert_array_equal(a.points, -b.points)
        np.testing.assert_array_equal(a.letters, b.letters)


# ---- symmetry


@pytest.mark.parametrize("flight", FLIGHTS)
def test_turning_everything_round_swaps_the_walls(flight):
    alpha, k, force = FLIGHTS[flight]
    turned = gz.Forcing(force.omega, force.t0, -force.offset, [-c for c in force.cos], [-s for s in force.sin])
    laws = gz.active(r=0.7, V=0.1), gz.newton(0.9)
    models = (
        gz.Oscillator(alpha, k, force, walls=(gz.wall(-0.3, laws[0]), gz.wall(0.4, laws[1]))),
        gz.Oscillator(alpha, k, turned, walls=(gz.wall(-0.4, laws[1]), gz.wall(0.3, laws[0]))),
    )
    P, Q = map(gz.stroboscopic_map, models)
    swap = str.maketrans("AB", "BA")
    for start in starts(P, 8):
        state = start
        for _ in range(6):
            (a, la), (b, lb) = P(state), Q(-state)
            assert P.letters.symbol(la).translate(swap) == Q.letters.symbol(lb)
            np.testing.assert_allclose(a, -b, atol=2e-13)
            np.testing.assert_allclose(P.jacobian(state), Q.jacobian(-state), rtol=1e-9, atol=1e-11)
            state = a


def test_a_symmetric_model_repeats_itself_after_half_a_period_upside_down():
    law = gz.newton(0.75)
    m = gz.Oscillator(
        0.1, 0.7, gz.Forcing(omega=1.9, cos=(1.4,), sin=(0.3,)), walls=(gz.wall(-0.3, law), gz.wall(0.3, law))
    )
    T = m.period
    for start in starts(gz.stroboscopic_map(m), 6):
        one = gz.trajectory(m, start, until=4 * T)
        two = gz.trajectory(m, -start, start=T / 2, until=4.5 * T)
        np.testing.assert_allclose(one.impact_time + T / 2, two.impact_time, atol=1e-10)
        np.testing.assert_allclose(one.v_plus, -two.v_plus, atol=1e-9)
        assert "".join(one.impact_wall.values).translate(str.maketrans("AB", "BA")) == "".join(two.impact_wall.values)


# ---- against another integrator


def flown(m, places, force, state, start):
    """One period by SciPy, with events at walls given as functions of time; the impacts as text."""
    alpha, k = m.alpha, m.k
    t, x, hits, end = start, list(state), "", start + m.period
    laws = [(wall.law, wall.sign) for wall in m.walls]

    def event(j):
        place, sign = places[j][0], laws[j][1]

        def gap(t, x):
            return sign * (x[0] - place(t))

        gap.terminal, gap.direction = True, -1
        return gap

    events = [event(j) for j in range(len(places))]
    while t < end:
        run = solve_ivp(
            lambda t, x: [x[1], force(t) - alpha * x[1] - k * k * x[0]],
            (t, end), x, "DOP853", events=events, rtol=1e-12, atol=1e-13, max_step=0.02,
        )  # fmt: skip
        t, x = run.t[-1], run.y[:, -1].copy()
        if run.status == 1:
            j = next(j for j, found in enumerate(run.t_events) if len(found))
            law, sign = laws[j]
            at, speed = (function(t) for function in places[j])
            x = [at + sign * 1e-15, speed + sign * law(sign * (x[1] - speed))]
            hits += m.names[j]
    return np.array(x), hits


def test_moving_walls_agree_with_another_integrator():
    m = gz.Oscillator(
        0.2, 1.1, gz.Forcing(omega=1.7, offset=0.1, cos=(1.2, 0.3)),
        walls=(
            gz.wall(-0.4, gz.active(r=0.7, V=0.2), motion=gz.Forcing(omega=3.4, cos=(0.05,), t0=0.3)),
            gz.wall(0.6, gz.newton(0.6), motion=gz.Forcing(omega=1.7, cos=(), sin=(0.1,))),
        ),
    )  # fmt: skip
    places = (
        (lambda t: -0.4 + 0.05 * math.cos(3.4 * (t + 0.3)), lambda t: -0.17 * math.sin(3.4 * (t + 0.3))),
        (lambda t: 0.6 + 0.1 * math.sin(1.7 * t), lambda t: 0.17 * math.cos(1.7 * t)),
    )
    P = gz.stroboscopic_map(m, phase=0.7)

    def force(t):
        return 0.1 + 1.2 * math.cos(1.7 * t) + 0.3 * math.cos(3.4 * t)

    seen = set()
    for start in np.random.default_rng(2).uniform((-0.2, -1.5), (0.4, 1.5), (8, 2)):
        after, letter = P(start)
        said, hits = flown(m, places, force, start, 0.7)
        assert P.letters.symbol(letter).strip("()") == (hits or "0")
        np.testing.assert_allclose(after, said, atol=1e-11)
        seen.add(hits)
    assert len(seen) > 1


def test_a_moving_table_is_a_fixed_one_seen_by_who_moves_with_it():
    """u = y + z: the step in u and the step in y, transformed by hand, with the same impacts."""
    law, z = gz.newton(0.85), (math.sin(0.4), math.cos(0.4))
    move = gz.Forcing(omega=1.0, sin=(1.0,), cos=())
    table = gz.Oscillator(0, 0, gz.Forcing(omega=1.0, offset=-1.0, cos=()), walls=[gz.wall(0.0, law, motion=move)])
    still = gz.Oscillator(0, 0, gz.Forcing(omega=1.0, offset=-1.0, cos=(), sin=(1.0,)), law)
    P, Q = gz.stroboscopic_map(table, phase=0.4), gz.stroboscopic_map(still, phase=0.4)
    for start in np.random.default_rng(1).uniform((0.1, -1.0), (3.0, 1.0), (10, 2)):
        a, b = P.orbit(start + z, 3), Q.orbit(start, 3)
        np.testing.assert_allclose(a.points - z, b.points, atol=1e-11)
        np.testing.assert_array_equal(a.letters, b.letters)


# ---- closed forms


@pytest.mark.parametrize(("r", "L"), [(0.5, 3.0), (0.8, 2.5), (0.3, 4.0)])
def test_the_impact_pair_has_the_orbit_of_its_closed_form(r, L):
    """Box a sin wt: cos phi + 2 s sin phi = -s L/a, s = (1 - r)/((1 + r) pi), speed w (L + 2 a sin phi)/pi."""
    a, omega, s = 1.0, 1.3, (1 - r) / ((1 + r) * math.pi)
    move = gz.Forcing(omega=omega, cos=(), sin=(a,))
    walls = [gz.wall(x, gz.newton(r), motion=move) for x in (-L / 2, L / 2)]
    m = gz.Oscillator(0, 0, gz.Forcing(omega=omega, cos=()), walls=walls)
    lean, rest = math.atan2(2 * s, 1.0), -s * L / a / math.hypot(1.0, 2 * s)
    turn = np.array([lean + math.acos(rest), lean - math.acos(rest)])
    if (r, L) == (0.5, 3.0):
        known = 2.0965418499633213, -1.678332562315855
        assert sorted(np.mod(turn, 2 * np.pi)) == pytest.approx(sorted(np.mod(known, 2 * np.pi)), abs=1e-13)
    found = 0
    for phi in turn:
        speed = omega * (L + 2 * a * math.sin(phi)) / math.pi
        # at phase phi it meets the wall above and leaves it downwards; half a period later the one below
        t = phi / omega
        for sign in (1.0, -1.0):
            after = gz.trajectory(
                m, (sign * (L / 2) + a * math.sin(phi), -sign * speed), start=t, until=t + 0.9 * m.period
            )
            want = (phi + math.pi) / omega
            if sign > 0 and after.sizes["impact"] and abs(float(after.impact_time[0]) - want) < 1e-9:
                assert float(after.v_minus[0]) == pytest.approx(-speed, rel=1e-12)
                assert float(after.impact_time[0]) == pytest.approx(want, rel=1e-12)
                assert float(after.v_plus[0]) == pytest.approx(speed, rel=1e-10)
                found += 1
    assert found >= 1


@pytest.mark.parametrize("r", [0.1, 0.5, 0.85])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_bouncing_ball_doubles_where_luck_and_mehta_say(r, n):
    """Gamma^2 = Gamma_0^2 + (2 (1 + r^2)/(1 + r)^2)^2, Gamma_0 = n pi (1 - r)/(1 + r), with the wall moving."""
    first = n * math.pi * (1 - r) / (1 + r)
    gamma = math.hypot(first, 2 * (1 + r * r) / (1 + r) ** 2)

    def multiplier(gamma):
        """(1 + a)(1 + b) of the multipliers of the orbit with one impact in n periods: 0 where one of them is -1."""
        table = gz.wall(0.0, gz.newton(r), motion=gz.Forcing(omega=1.0, cos=(), sin=(gamma,)))
        m = gz.Oscillator(0, 0, gz.Forcing(omega=1.0, offset=-1.0, cos=()), walls=[table])
        # it leaves with n pi and comes back with -n pi after n periods, where the table moves with gamma cos(phase)
        phase, s = math.acos(first / gamma), 1.0
        P = gz.stroboscopic_map(m, phase=phase + s)
        start = gamma * math.sin(phase) + n * math.pi * s - 0.5 * s * s, n * math.pi - s
        back = P.iterate(start, n)
        np.testing.assert_allclose(back[-1], start, atol=1e-9)
        J = np.eye(2)
        for point in back[:-1]:
            J = P.jacobian(point) @ J
        return 1 + np.trace(J) + np.linalg.det(J)

    assert brentq(multiplier, gamma * (1 - 1e-3), gamma * (1 + 1e-3), xtol=1e-13) == pytest.approx(gamma, rel=1e-12)


# ---- rare branches


@pytest.mark.parametrize("up", [False, True], ids=["below", "above"])
def test_a_ball_chatters_to_rest_on_either_wall_and_rides_it(up):
    sign = -1.0 if up else 1.0
    move = gz.Forcing(omega=1.0, cos=(0.1,))
    walls = [gz.wall(-1.0, gz.newton(0.5), motion=move), gz.wall(1.0, gz.newton(0.4), motion=move)]
    m = gz.Oscillator(0.1, 0, gz.Forcing(omega=1.0, offset=-sign, cos=()), walls=walls)
    P = gz.stroboscopic_map(m)
    orbit = P.orbit((0.1, 0.0), 6)
    assert orbit.letters[0] == CHATTER - 2 * up and (orbit.letters[1:] == LAY - 2 * up).all()
    np.testing.assert_array_equal(orbit.points[2:], [[0.1 - sign, 0.0]] * 5)
    tr = gz.trajectory(m, (0.1, 0.0), until=3 * m.period)
    late = tr.t.values > 2 * m.period
    np.testing.assert_allclose(tr.u.values[late], -sign + 0.1 * np.cos(tr.t.values[late]), atol=1e-15)
    np.testing.assert_allclose(tr.v.values[late], -0.1 * np.sin(tr.t.values[late]), atol=1e-15)
    assert set(tr.impact_wall.values) == {"B" if up else "A"} and tr.trust == "certified"


def test_chatter_that_could_reach_the_other_wall_is_followed():
    """A hop as high as the room: the upper wall is hit before the ball comes to rest on the lower one."""
    m = gz.Oscillator(
        0,
        0,
        gz.Forcing(omega=0.1, offset=-1.0, cos=()),
        walls=(gz.wall(0.0, gz.newton(0.9)), gz.wall(0.1, gz.newton(0.5))),
    )
    P = gz.stroboscopic_map(m)
    tr = gz.trajectory(m, (0.0, 1.0), until=0.9 * m.period)
    assert "".join(tr.impact_wall.values[:3]) == "BAB"
    assert P.orbit((0.0, 1.0), 1).letters[0] == CHATTER


def test_more_impacts_than_a_letter_tells_apart_are_many():
    law = gz.newton(1.0)
    m = gz.Oscillator(0, 0, gz.Forcing(omega=1.0, cos=()), walls=(gz.wall(0.0, law), gz.wall(0.1, law)))
    P = gz.stroboscopic_map(m)
    for speed, hits in ((0.1, 6), (0.3, 19), (0.32, 20), (3.0, 189)):
        (letter,) = P.orbit((0.05, speed), 1).letters
        assert letter == MANY if hits > 19 else len(P.letters.symbol(int(letter)).strip("()")) == hits


def test_endless_impacts_end_in_a_named_outcome():
    law = gz.newton(1.0)
    m = gz.Oscillator(0, 0, gz.Forcing(omega=1.0, cos=()), walls=(gz.wall(0.0, law), gz.wall(1e-4, law)))
    (outcome,) = gz.stroboscopic_map(m).orbit((5e-5, 1.0), 1).outcomes
    assert outcome & FATAL and Outcome.too_many_impacts in Outcome(int(outcome))


@pytest.mark.parametrize("flight", FLIGHTS)
def test_the_laws_of_every_map_hold_between_walls(flight):
    alpha, k, force = FLIGHTS[flight]
    move = gz.Forcing(omega=force.omega, cos=(0.05, 0.02), sin=(0.01,))
    walls = gz.wall(-0.3, gz.active(r=0.7, V=0.1), motion=move), gz.wall(0.4, gz.newton(0.9))
    gz.testing.check_map(gz.stroboscopic_map(gz.Oscillator(alpha, k, force, walls=walls), phase=0.2), 3, 4)


# ---- grazes


def truth(m, moving, depth, when, j):
    """The state at time 0 of a ball that would come to within ``depth`` of wall j at ``when``, in 40 digits.

    None for a ball that meets a wall before that, or is pressed on the wall there.
    """
    with mp.workdps(40):
        alpha, k, f = mp.mpf(m.alpha), mp.mpf(m.k), m.forcing
        W, t0 = mp.mpf(f.omega), mp.mpf(f.t0)
        nodes = [(mp.mpf(c), mp.mpf(s), (i + 1) * W) for i, (c, s) in enumerate(zip(f.cos, f.sin, strict=True))]

        def steady(t):
            u, v = mp.mpf(f.offset) / k**2, mp.mpf(0)
            for c, s, w in nodes:
                z = (c - 1j * s) / (k**2 - w**2 + 1j * alpha * w) * mp.expj(w * (t + t0))
                u, v = u + z.real, v + (1j * w * z).real
            return u, v

        roots = [-alpha / 2 + x * mp.sqrt(mp.mpc(alpha**2 / 4 - k**2)) for x in (1, -1)]

        def wall(i, t):
            at, speed, bend = mp.mpf(m.walls[i].position), mp.mpf(0), mp.mpf(0)
            for c, s, w in moving[i]:
                at += c * mp.cos(w * (t + t0)) + s * mp.sin(w * (t + t0))
                speed += w * (s * mp.cos(w * (t + t0)) - c * mp.sin(w * (t + t0)))
                bend -= w * w * (c * mp.cos(w * (t + t0)) + s * mp.sin(w * (t + t0)))
            return at, speed, bend

        sign = mp.mpf(m.walls[j].sign)
        at, speed, bend = wall(j, when)
        u, v = at + sign * depth, speed
        pull = f.offset + sum((c - 1j * s) * mp.expj(w * (when + t0)) for c, s, w in nodes).real - alpha * v - k * k * u
        if sign * (pull - bend) < 0.3:
            return None
        Y, dY = steady(when)
        a, b = roots
        c1 = ((v - dY) - b * (u - Y)) / (a - b)
        c2 = (u - Y) - c1

        E, (Y, dY) = (c1 * mp.exp(-a * when), c2 * mp.exp(-b * when)), steady(mp.mpf(0))
        start = float((E[0] + E[1]).real + Y), float((a * E[0] + b * E[1]).real + dY)
        before = np.linspace(0.0, float(when), 60)[:-2]
        c1, c2, a, b = (complex(z) for z in (c1, c2, a, b))  # doubles are enough to see it stay away by a hundredth
        height = (c1 * np.exp(a * (before - float(when))) + c2 * np.exp(b * (before - float(when)))).real
        phase = float(W) * (before[:, None] + float(t0)) * np.arange(1, len(nodes) + 1)
        answers = [complex((c - 1j * s) / (k**2 - w**2 + 1j * alpha * w)) for c, s, w in nodes]
        height = height + float(f.offset / k**2) + (np.exp(1j * phase) @ np.array(answers)).real
        for i, other in enumerate(m.walls):
            at = float(other.position) + sum(
                c * np.cos(w * (before + f.t0)) + s * np.sin(w * (before + f.t0)) for c, s, w in moving[i]
            )
            if (other.sign * (height - at) < 0.02 * (float(when) - before)).any():
                return None
        return start


@pytest.mark.parametrize("flight", ["over", "under", "undamped"])
@pytest.mark.parametrize("moves", [False, True], ids=["still", "moving"])
def test_no_dip_is_missed_and_none_invented_on_either_wall(flight, moves):
    """Dips and clearances from 1e-4 to 1e-12 of either wall: hit if and only if the wall is crossed."""
    alpha, k, force = FLIGHTS[flight]
    waves = [(0.02, 0.01, force.omega), (0.0, 0.01, 2 * force.omega)] if moves else []
    motion = gz.Forcing(omega=force.omega, t0=force.t0, cos=(0.02, 0.0), sin=(0.01, 0.01)) if moves else None
    law = gz.active(r=0.8, V=0.4)
    walls = gz.wall(-0.6, law, motion=motion), gz.wall(0.7, law)
    m = gz.Oscillator(alpha, k, force, walls=walls)
    P, moving = gz.stroboscopic_map(m), [waves, []]
    random, asked, wrong = np.random.default_rng(3), [0, 0], []
    while min(asked) < 12:
        j, when = int(random.integers(2)), float(random.uniform(0.1, 0.9)) * m.period
        if asked[j] >= 12:
            continue
        size = 10.0 ** random.uniform(-12, -4)
        pair = [truth(m, moving, depth, mp.mpf(when), j) for depth in (-size, size)]
        if None in pair:
            asked[j] += 1 / 64  # such a graze may not exist on one of the walls
            continue
        asked[j] += 1
        for state, crosses in zip(pair, (True, False), strict=True):
            first = gz.trajectory(m, state, until=min(when + 0.01 * m.period, m.period))
            early = [
                n for t, n in zip(first.impact_time.values, first.impact_wall.values, strict=True) if t < when + 1e-3
            ]
            if (early == [m.names[j]]) != crosses:
                wrong.append((flight, size, crosses, early))
            outcome = P.orbit(state, 1)
            if size > 1e-11 and outcome.outcomes[0] & Outcome.ambiguous:
                wrong.append((flight, size, "ambiguous"))
    assert not wrong and sum(asked) > 2


def test_a_start_on_a_moving_wall_is_on_it_whatever_rounding_makes_of_its_place():
    """The place is a sum of cosines: who adds it up otherwise comes out a unit in the last place inside."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        cos, sin, t0, start = rng.normal(size=2), rng.normal(size=2), 1.7, float(rng.uniform(-5, 5))
        law, moved = gz.newton(0.5), gz.Forcing(omega=1.3, t0=t0, cos=tuple(cos), sin=tuple(sin))
        angles = 1.3 * np.array([1, 2]) * (start + t0)
        at = float(0.3 + (cos * np.cos(angles)).sum() + (sin * np.sin(angles)).sum())
        rate = float((1.3 * np.array([1, 2]) * (sin * np.cos(angles) - cos * np.sin(angles))).sum())
        weight = gz.Forcing(omega=1.3, offset=-20.0, cos=())
        for side, pull in (("below", weight), ("above", gz.Forcing(omega=1.3, offset=20.0, cos=()))):
            m = gz.Oscillator(alpha=0.3, k=0.0, forcing=pull, walls=[gz.wall(0.3, law, motion=moved, side=side)])
            sign = 1.0 if side == "below" else -1.0
            for u in (np.nextafter(at, -9.0), at, np.nextafter(at, 9.0)):
                flown = gz.trajectory(m, (u, rate - sign), start=start, until=start + 0.01, samples=2)
                step = gz.stroboscopic_map(m, phase=start).orbit((u, rate - sign), 1)
                assert abs(float(flown.impact_time[0]) - start) < 1e-14
                assert not step.outcomes[0] & FATAL


@pytest.mark.parametrize("walls", [1, 2])
def test_a_start_at_rest_on_a_moving_wall_is_undecided_but_for_the_bits_that_a_step_ends_with(walls):
    """An ulp beside the wall's velocity decided, certified, whether a ball lies or chatters: its letter."""
    ride = gz.Forcing(omega=1.3, t0=0.2, cos=(0.1,), sin=(0.05,))
    pair = gz.wall(0.4, gz.newton(0.3), motion=ride), gz.wall(2.4, gz.newton(0.5))
    m = gz.Oscillator(0.1, 0.3, gz.Forcing(omega=1.3, offset=-5.0, cos=(0.1,)), walls=pair[:walls])
    P = gz.stroboscopic_map(m, phase=0.7)
    lying = P.orbit((0.6, -1.0), 1).points[-1]
    rest = P.orbit(lying, 1)
    assert rest.letters[0] == LAY and not rest.outcomes[0] & Outcome.ambiguous
    for n in (0, 1):
        for way in (-np.inf, np.inf):
            near = lying.copy()
            near[n] = np.nextafter(near[n], way)
            assert P.orbit(near, 1).outcomes[0] & Outcome.ambiguous
            flown = gz.trajectory(m, near, start=0.7, until=2.0, samples=2)
            assert flown.trust == "ambiguous"
            near[1] -= 1e-6  # now it hits, wherever the wall is
            assert P.orbit(near, 1).letters[0] == CHATTER and not P.orbit(near, 1).outcomes[0] & Outcome.ambiguous
