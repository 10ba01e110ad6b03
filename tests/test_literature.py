"""The page of the literature: its own calls, held to each paper's equation by SciPy and to closed forms."""

import contextlib
import io
import re
import sys
import types

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import grazing as gz
from tests.test_docs import ROOT, blocks, read

PAGE = ROOT / "docs" / "from-the-literature.md"


@pytest.fixture(scope="module")
def page():
    """The names that the page defines, and what each of its blocks printed."""
    session = types.ModuleType("literature")
    session.printed = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "literature", session)
        for text, line in blocks(PAGE, "python"):
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile("\n" * (line - 1) + text, str(PAGE), "exec"), session.__dict__)
            session.printed.append((text, out.getvalue()))
        yield session


def test_each_comment_is_what_its_line_prints(page):
    for text, printed in page.printed:
        said = [line.split(")  # ", 1)[1] for line in text.splitlines() if line.lstrip().startswith("print(")]
        assert said and "; ".join(said) == "; ".join(printed.splitlines())


def test_each_paper_has_a_table_and_a_call():
    sections = re.split(r"^## ", read(PAGE), flags=re.MULTILINE)[1:]
    assert len(sections) == 10
    for section in sections:
        assert "| theirs | here |" in section and "```python\nimport grazing as gz\n" in section, section[:40]
        assert re.search(r"^    \S.*(=|→).*$", section, re.MULTILINE), section[:40]


# ---- a paper's equation, integrated


def flown(force, wall, side, law, state, span, count, longest=0.05):
    """Impacts of x'' = force(t, x, x'), kept on one side of a wall: rows (time, x' before, x' after).

    ``wall(t)`` is (position, velocity); side 1 for x above it, -1 for x below; ``law`` acts on the velocity relative
    to the wall.
    """

    def gap(t, y):
        return side * (y[0] - wall(t)[0])

    def field(t, y):
        return y[1], force(t, *y)

    gap.terminal, gap.direction = True, -1.0
    (t, end), rows = span, []
    while len(rows) < count:
        run = solve_ivp(field, (t, end), state, events=gap, method="DOP853", rtol=1e-12, atol=1e-13, max_step=longest)
        assert run.t_events[0].size and run.t_events[0][0] > t, "too few impacts, or a flight shorter than a step"
        t = run.t_events[0][0]
        at, speed = wall(t)
        before = run.y_events[0][0, 1]
        state = (at, speed + law(before - speed))
        rows.append((t, before, state[1]))
    return np.array(rows)


def same_flight(model, state, force, wall, law=None, *, side=-1, r=None, count=6, longest=0.05):
    """Hold the impacts of a model to those of a paper's equation with a fixed wall; side -1: x = -u."""
    law = law or (lambda v: -r * v)
    theirs = flown(force, lambda t: (wall, 0.0), side, law, state, (0.0, 200.0), count, longest)
    ours = gz.trajectory(model, (side * state[0], side * state[1]), until=theirs[-1, 0] + 1e-3)
    rows = np.stack([ours.impact_time, side * ours.v_minus, side * ours.v_plus], axis=-1)
    assert rows.shape == theirs.shape
    np.testing.assert_allclose(rows, theirs, rtol=0.0, atol=1e-7)


# ---- orbits with one impact in n periods, from the matrix exponential


class OneImpact:
    """x'' + c x' + K x = F cos(phase), phase = omega t + phi at an impact, wall at s: all one-impact orbits by phi.

    The impact's phase fixes the forced response; that the flight closes and the law holds is linear in s.
    """

    def __init__(self, c, K, F, omega, r, n, phi):
        G = F / complex(K - omega * omega, c * omega) * np.exp(1j * phi)
        X, W = G.real, (1j * omega * G).real
        E = expm(np.array([[0.0, 1.0], [-K, -c]]) * 2.0 * np.pi * n / omega)
        up = (1.0 - E[0, 0]) / E[0, 1]
        arrives = E[1, 0] + E[1, 1] * up
        d = -(1.0 + r) * W / (up + r * arrives)
        self.wall = X + d
        self.before = W + d * arrives
        after = -r * self.before
        f = F * np.cos(phi) - K * self.wall
        jump = ((f - c * after) + r * (f - c * self.before)) / self.before
        self.jacobian = np.array([[-r, 0.0], [jump, -r]]) @ E

    def test(self, multiplier):
        """det(J - multiplier), for a multiplier 1 or -1."""
        J = self.jacobian
        return 1.0 - multiplier * np.trace(J) + np.linalg.det(J)


def doubling_at_zero(c, r, n, low, high):
    """Frequency at which the (1, n) orbit with its wall at 0 doubles, K = 1: the amplitude drops out."""

    def height(omega):
        # the wall is a sine of the phase: two values say where it is at 0
        first, second = (OneImpact(c, 1.0, 1.0, omega, r, n, 0.3 + quarter).wall for quarter in (0.0, np.pi / 2.0))
        return OneImpact(c, 1.0, 1.0, omega, r, n, 0.3 + np.arctan2(-first, second)).test(-1.0)

    return brentq(height, low, high, xtol=1e-14)


# ---- the papers


def test_the_general_call_flies_as_its_equation_says(page):
    zeta, omega0, P, F, omega, phi, sigma, r = 0.04, 1.7, 0.3, 1.2, 2.3, 0.9, 0.15, 0.7

    def force(t, x, v):
        return P + F * np.cos(omega * t + phi) - 2.0 * zeta * omega0 * v - omega0**2 * x

    same_flight(page.wall_above(zeta, omega0, P, F, omega, phi, sigma, r), (sigma - 0.5, 0.2), force, sigma, r=r)


@pytest.mark.parametrize("P", [0.0, 0.7])
def test_the_general_call_grazes_at_the_amplitude_of_the_free_response(page, P):
    m = page.wall_above(0.05, 3.0, P, 2.0, 4.0, 0.5, 0.1, 0.8)
    top = P / 9.0 + 2.0 / np.hypot(9.0 - 16.0, 2.0 * 0.05 * 3.0 * 4.0)
    assert -gz.normal_form(m, "sigma").graze == pytest.approx(top, abs=1e-13)


@pytest.mark.parametrize("values", [(0.05, 1.0, 2.0, 0.1, 0.8), (0.2, 2.5, 1.3, -0.4, 0.5)])
def test_shaw_and_holmes_fly_as_their_equation_says(page, values):
    alpha, beta, omega, x0, r = values
    same_flight(
        page.shaw_holmes(*values),
        (x0 - 0.7, 0.4),
        lambda t, x, v: beta * np.cos(omega * t) - 2.0 * alpha * v - x,
        x0,
        r=r,
    )


@pytest.mark.parametrize("beta", [1.0, 2.5])
def test_shaw_and_holmes_double_where_the_multipliers_say(page, beta):
    found = gz.windows(page.shaw_holmes(0.05, beta, 2.0, 0.0, 0.8), "omega", N=1, span=(1.2, 3.5))
    edges = [doubling_at_zero(0.1, 0.8, 1, *span) for span in ((1.2, 1.5), (2.3, 3.2))]
    assert [found.low.item(), found.high.item()] == pytest.approx(edges, abs=1e-10)


@pytest.mark.parametrize("values", [(0.05, 1.0, 2.2, 1.0), (0.1, 0.7, 3.9, 0.9)])
def test_thompson_and_ghaffari_fly_as_their_equation_says(page, values):
    zeta, F, omega, r = values
    same_flight(
        page.thompson_ghaffari(*values),
        (0.3, 0.5),
        lambda t, x, v: F * np.sin(omega * t) - 2.0 * zeta * v - x,
        0.0,
        side=1,
        r=r,
    )


@pytest.mark.parametrize("n", [1, 2, 3])
def test_thompson_and_ghaffari_hit_at_resonance_as_the_closed_form_says(page, n):
    # half a free swing takes n periods and keeps e of its speed: v- = X' - e w, v+ = X' + w = -v-, X' where X = 0
    zeta, F = 0.05, 1.3
    damped = np.sqrt(1.0 - zeta**2)
    omega = 2.0 * n * damped
    e = np.exp(-zeta * np.pi / damped)
    crossing = omega * F / np.hypot(1.0 - omega**2, 2.0 * zeta * omega)
    orbits = gz.one_impact_orbits(page.thompson_ghaffari(zeta, F, omega), n)
    (orbit,) = [orbit for orbit in orbits if orbit.admissible]
    assert -orbit.v_minus == pytest.approx(crossing * (1.0 + e) / (1.0 - e), rel=1e-12)
    assert orbit.stable


@pytest.mark.parametrize("values", [(2.8, 0.2, 0.8), (1.7, -0.3, 0.6)])
def test_budd_and_dux_fly_as_their_equation_says(page, values):
    omega, sigma, r = values
    same_flight(page.budd_dux(*values), (sigma - 0.6, -0.3), lambda t, x, v: np.cos(omega * t) - x, sigma, r=r)


@pytest.mark.parametrize(("n", "spans"), [(1, ((1.1, 1.5), (2.3, 3.0))), (2, ((3.1, 3.6), (4.3, 5.0)))])
def test_budd_and_dux_double_where_the_trace_says(page, n, spans):
    r = 0.8

    def height(omega):
        C = np.cos(2.0 * np.pi * n / omega)
        return 1.0 + (1.0 + r) ** 2 * (1.0 - omega**2) * (1.0 + C) / 2.0 - 2.0 * r * C + r * r

    edges = [brentq(height, *span, xtol=1e-15) for span in spans]
    # the same by the matrix exponential, which knows no trace in closed form
    assert edges == pytest.approx([doubling_at_zero(0.0, r, n, *span) for span in spans], abs=1e-11)
    found = gz.windows(page.budd_dux(2.0, 0.0, r), "omega", N=n, span=(1.05, 6.0))
    assert [found.low.item(), found.high.item()] == pytest.approx(edges, abs=1e-11)


def test_budd_and_dux_chatter_as_their_equation_says(page):
    omega, sigma, r = 2.0, 0.3, 0.8
    m = page.budd_dux(omega, sigma, r)
    same_flight(m, (sigma, -0.02), lambda t, x, v: np.cos(omega * t) - x, sigma, r=r, count=12, longest=5e-4)
    speeds = gz.trajectory(m, (-sigma, 0.02), until=0.6).v_minus.values
    ratios = speeds[1:] / speeds[:-1]
    assert len(ratios) > 50 and ratios[-1] == pytest.approx(r, abs=1e-6)
    late = (ratios - r)[-20:]
    np.testing.assert_allclose(late[1:] / late[:-1], r, rtol=1e-3)  # what is left falls with the speed
    released = gz.impact_map(m).iterate((0.0, 0.02), 60)
    rest = released[released[:, 1] == 0.0]
    assert len(rest) and rest[0, 0] == pytest.approx(np.arccos(sigma) / omega, abs=1e-14)


def longest_climb(N, alpha, gamma, tau):
    """Ends in rho of the orbit L...LR of period N of Chin et al.: {"pd": rho, "gr": rho}, by linear algebra.

    With z = sqrt(x) at the point x > 0 the orbit is linear in (z^2, y, rho), and 1 + tr + det = 0 linear in 1/z.
    """
    A = np.array([[alpha, 1.0], [-gamma, 0.0]])
    power = np.linalg.matrix_power(A, N - 1)
    total = sum((np.linalg.matrix_power(A, k) for k in range(N - 1)), np.zeros((2, 2)))
    e = np.array([1.0, 0.0])

    def closed(z):
        """(y, rho) of the orbit with its point at x = z^2, and the last point before it."""
        right = power @ np.array([-z, -gamma * tau**2 * z * z])
        M = np.stack([power @ e - np.array([0.0, 1.0]), (power + total) @ e], axis=1)
        y, rho = np.linalg.solve(M, np.array([z * z, 0.0]) - right)
        return y, rho, np.linalg.solve(A, np.array([z * z - rho, y]))

    # J = power @ ((-1/2z, 1), (-gamma tau^2, 0))
    bend = power @ np.array([[-0.5, 0.0], [0.0, 0.0]])
    rest = power @ np.array([[0.0, 1.0], [-gamma * tau**2, 0.0]])
    det = np.linalg.det(power) * gamma * tau**2
    doubling = closed(-np.trace(bend) / (1.0 + np.trace(rest) + det))[1]
    border = closed(brentq(lambda z: closed(z)[2][0], 1e-9, 2.0, xtol=1e-15))[1]
    return {"pd": doubling, "gr": border}


@pytest.mark.parametrize(("alpha", "gamma", "tau", "rho", "N"), [(0.5, 0.05, 0.8, 0.05, 3), (0.6, 0.02, 0.5, 0.1, 3)])
def test_chin_et_al_lose_their_orbits_where_algebra_says(page, alpha, gamma, tau, rho, N):
    found = page.window(page.chin(alpha, gamma, tau, rho), "L" * (N - 1) + "R")
    assert found == pytest.approx(longest_climb(N, alpha, gamma, tau), rel=1e-9)


def test_chin_et_al_without_gamma_are_the_gap_map(page):
    found = page.window(page.chin_damped(0.5, 0.05), "LLR")
    assert [*found.values()] == pytest.approx([3.0 / 112.0, 1.0 / 9.0], rel=1e-12)
    assert [*longest_climb(3, 0.5, 1e-300, 0.8).values()] == pytest.approx([3.0 / 112.0, 1.0 / 9.0], rel=1e-9)


def test_the_regimes_of_chin_et_al_are_where_windows_meet_and_vanish():
    # gamma = 0, N large: the window of N is (3/4 (1 - a) a^(2N - 2), (1 - a)^2 a^(2N - 4)), and that of N + 1 below it
    def vanishes(a):
        return 0.75 * (1.0 - a) * a**2 - (1.0 - a) ** 2

    def meets(a):
        return 0.75 * (1.0 - a) - (1.0 - a) ** 2

    gone, apart = brentq(vanishes, 0.5, 0.9, xtol=1e-15), brentq(meets, 0.1, 0.5, xtol=1e-15)
    assert (gone, apart) == pytest.approx((2.0 / 3.0, 0.25), abs=1e-14)
    names = [gz.theory.regime(a + d).name for a in (apart, gone) for d in (-1e-9, 1e-9)]
    assert names == ["overlapping", "separated", "separated", "chaotic"]


def test_the_symbols_of_chin_et_al_are_those_of_a_normal_form(page):
    # trace and determinant of a period without impact, by the matrix exponential
    m = page.shaw_holmes(0.05, 1.0, 1.7, 0.5, 0.8)
    nf = gz.normal_form(m, "sigma")
    E = expm(np.array([[0.0, 1.0], [-1.0, -0.1]]) * 2.0 * np.pi / 1.7)
    assert (nf.lam, nf.det, nf.r) == pytest.approx((np.trace(E), np.linalg.det(E), 0.8), abs=1e-12)
    # an impact multiplies the determinant of a period by the square of the restitution, as theirs does
    P = gz.stroboscopic_map(nf.model.replace(sigma=nf.graze + 0.01))
    start = P.iterate((1.0, 0.0), 40)[-1]
    (_new, hits), J = P(start), P.jacobian(start)
    assert hits == 1 and np.linalg.det(J) == pytest.approx(nf.det * 0.8**2, rel=1e-10)
    C = page.chin(nf.lam, nf.det, nf.r, 0.0)
    assert np.linalg.det(C.jacobian((0.1, 0.0))) == pytest.approx(nf.det * 0.8**2, rel=1e-8)


def test_the_distance_of_chin_et_al_is_that_of_the_free_response(page):
    m = page.wall_above(zeta=0.05, omega0=3.0, P=0.0, F=2.0, omega=14.0, phi=0.0, sigma=0.1, r=0.8)
    nf = gz.normal_form(m, "sigma")
    assert nf.b > 0.0 and nf.lam > 0.0
    above = 1e-3 * abs(nf.graze)  # by how much the wall is higher than the lowest point of the free response, at rest
    x = 2.0 * nf.acceleration * above / nf.scale
    rho = x * (1.0 - nf.lam + nf.det)  # as that response is the fixed point of (αx + y + ρ, -γx)
    assert nf.mu(nf.graze + above) == pytest.approx(rho, rel=1e-9)
    theirs, ours = page.chin(nf.lam, nf.det, nf.r, rho), nf.xy_map(nf.graze + above)
    for q in ((-0.3, 0.1), (0.2, -0.4)):
        image = np.array(theirs(q)[0]) * nf.scale
        found = np.array(ours(tuple(nf.scale * np.array(q)))[0])
        if q[0] <= 0.0:
            np.testing.assert_allclose(found, image, rtol=1e-9)
        else:  # they leave out αx, and for y have τ² more
            np.testing.assert_allclose(found[0] - nf.scale * nf.lam * q[0], image[0], rtol=1e-9)
            np.testing.assert_allclose(found[1] * nf.r**2, image[1], rtol=1e-9)


@pytest.mark.parametrize(("ratio", "negative"), [(1.3, False), (1.35, True), (3.9, True), (4.1, False)])
def test_the_trace_is_negative_between_four_thirds_and_four_free_frequencies(page, ratio, negative):
    free = 3.0 * np.sqrt(1.0 - 0.05**2)
    m = page.wall_above(zeta=0.05, omega0=3.0, P=0.0, F=2.0, omega=ratio * free, phi=0.0, sigma=0.1, r=0.8)
    assert (gz.normal_form(m, "sigma").lam < 0.0) == negative


@pytest.mark.parametrize("values", [(0.05, 1.0, 1.9, 0.3, 0.8), (0.1, 2.0, 2.7, 0.1, 0.6)])
def test_foale_flies_as_the_equation_says(page, values):
    zeta, F, omega, a, r = values
    same_flight(page.foale(*values), (a - 0.4, 0.3), lambda t, x, v: F * np.cos(omega * t) - 2.0 * zeta * v - x, a, r=r)


@pytest.mark.parametrize(("shift", "kind", "multiplier"), [(-0.05, "lp", 1.0), (0.05, "pd", -1.0)])
def test_foale_folds_below_the_resonance_and_doubles_above(page, shift, kind, multiplier):
    zeta, F, r = 0.05, 1.0, 0.8
    omega = 2.0 * np.sqrt(1.0 - zeta**2) + shift

    def orbit(phi):
        return OneImpact(2.0 * zeta, 1.0, F, omega, r, 1, phi)

    # the orbit grows out of the graze, whose phase is that of the response's maximum
    top = -np.angle(1.0 / complex(1.0 - omega**2, 2.0 * zeta * omega))
    phis = top + np.linspace(-0.5, 0.5, 401) + 1e-5
    tests = np.array([orbit(phi).test(multiplier) for phi in phis])
    walls = [orbit(brentq(lambda phi: orbit(phi).test(multiplier), phis[i], phis[i + 1], xtol=1e-15)).wall
             for i in np.flatnonzero(tests[1:] * tests[:-1] < 0.0)]  # fmt: skip
    a, found = page.edge(zeta, F, omega, r)
    assert found == kind
    assert min(abs(np.array(walls) - a)) < 1e-10


def test_foale_meets_all_three_at_twice_the_damped_frequency(page):
    zeta, F, r = 0.05, 1.0, 0.8
    resonance = 2.0 * np.sqrt(1.0 - zeta**2)
    for sign in (-1.0, 1.0):
        distances = []
        for shift in (0.01, 0.02):
            omega = resonance + sign * shift
            graze = F / np.hypot(1.0 - omega**2, 2.0 * zeta * omega)
            assert gz.normal_form(page.foale(zeta, F, omega, 0.3, r), "sigma").graze == pytest.approx(-graze, abs=1e-13)
            distances.append(page.edge(zeta, F, omega, r)[0] - graze)
        assert distances[1] / distances[0] == pytest.approx(4.0, rel=0.1)  # a touch, not a crossing


def test_luck_and_mehta_fly_as_their_equation_says(page):
    g, omega, eta, Gamma = 9.81, 30.0, 0.7, 2.3
    A = Gamma * g / omega**2

    def table(t):
        return A * np.sin(omega * t), A * omega * np.cos(omega * t)

    z, w = 2.0 * A, 0.3
    theirs = flown(lambda t, x, v: -g, table, 1, lambda v: -eta * v, (z, w), (0.0, 10.0), 6, longest=0.002)
    s, drift = table(theirs[:, 0])
    theirs[:, 1:] -= drift[:, None]
    s, drift = table(0.0)
    units = {"luck_mehta": (omega, g / omega), "si": (1.0, 1.0)}  # of 1/time and of speed
    models = {"luck_mehta": page.luck_mehta(Gamma, eta), "si": page.luck_mehta_si(A, omega, g, eta)}
    for name, (rate, speed) in units.items():
        start = (z - s) * rate / speed, (w - drift) / speed
        ours = gz.trajectory(models[name], start, until=theirs[-1, 0] * rate + 1e-4)
        rows = np.stack([ours.impact_time / rate, ours.v_minus * speed, ours.v_plus * speed], axis=-1)
        np.testing.assert_allclose(rows, theirs, rtol=0.0, atol=1e-8, err_msg=name)


@pytest.mark.parametrize(("eta", "n"), [(0.5, 1), (0.5, 2), (0.8, 3), (0.0, 1), (0.0, 2)])
def test_luck_and_mehta_lock_between_their_closed_forms(page, eta, n):
    found = gz.windows(page.luck_mehta(2.0, eta), "sin1", N=n, span=(0.5, 8.0))
    first = n * np.pi * (1.0 - eta) / (1.0 + eta)
    low = first if eta > 0.0 else np.hypot(1.0, n * np.pi)
    high = np.hypot(first, 2.0 * (1.0 + eta**2) / (1.0 + eta) ** 2)
    assert (found.low.item(), found.high.item()) == pytest.approx((low, high), rel=1e-14)


@pytest.mark.parametrize("alpha", [0.4, 0.9])
def test_holmes_is_the_ball_of_luck_and_mehta_high_above_the_table(page, alpha):
    # units of g = omega = 1; the table at Gamma sin(t), so that phi = t + pi
    Gamma, t, w = 3.0, 0.7, 5e5
    flight = brentq(
        lambda s: Gamma * (np.sin(t) - np.sin(t + s)) + w * s - 0.5 * s * s, 2.0 * w - 1.0, 2.0 * w + 1.0, xtol=1e-9
    )
    drift = Gamma * np.cos(t + flight)
    after = drift - alpha * (w - flight - drift)
    (phi, v), _letter = page.holmes(alpha, 2.0 * (1.0 + alpha) * Gamma)((t + np.pi, 2.0 * w))
    assert np.exp(1j * phi) == pytest.approx(np.exp(1j * (t + flight + np.pi)), abs=1e-4)
    assert v - 2.0 * alpha * w == pytest.approx(2.0 * (after - alpha * w), abs=1e-4 * Gamma)


@pytest.mark.parametrize("n", [1, 2])
def test_holmes_bounces_between_his_closed_forms(page, n):
    alpha = 0.5
    low = 2.0 * np.pi * n * (1.0 - alpha)
    high = 2.0 * np.hypot(n * np.pi * (1.0 - alpha), 1.0 + alpha)
    H = page.holmes(alpha, 0.5 * (low + high))
    (orbit,) = [o for o in gz.periodic_orbits(H, 1) if o.stable and abs(o.points[0, 1] - 2.0 * np.pi * n) < 1.0]
    assert orbit.points[0, 1] == pytest.approx(2.0 * np.pi * n, rel=1e-12)
    ends = {point.type: point.value for point in gz.continuation(H, orbit, "gamma", (0.9 * low, 1.1 * high)).special}
    assert ends == pytest.approx({"lp": low, "pd": high}, rel=1e-9)
    # Gamma = gamma/(2 (1 + alpha)): the saddle-node is that of the exact ball
    exact = gz.windows(page.luck_mehta(low, alpha), "sin1", N=n, span=(0.5, 8.0)).low.item()
    assert low / (2.0 * (1.0 + alpha)) == pytest.approx(exact, rel=1e-14)


def climb_ends(n, a, b, l):
    """Ends in mu of the orbit L^n R of Jain and Banerjee, where a point next to the border reaches it."""
    S = (1.0 - a**n) / (1.0 - a)
    return sorted([-(a**n) * l / (S + a**n), -(a**n) * l / (S + a**n * (1.0 + b) - 1.0)])


@pytest.mark.parametrize(("word", "n"), [("1", 1), ("2", 2)])
def test_church_and_fortin_print_solutions_of_the_closing_equations(page, word, n):
    """Each flight meets the table again at its end; what passes through it between is virtual, by its depth."""
    e, g, tau = 0.8, 9.81, 2.0 * np.pi
    for o in gz.periodic_orbits(page.P, 1, word=word, virtual=True, starts=200):
        hits = o.times, o.incoming + tau * np.cos(tau * o.times)
        depth = np.inf
        for t, w, end in zip(*hits, [*o.times[1:], o.times[0] + 1.0], strict=True):
            after = (1.0 + e) * tau * np.cos(tau * t) - e * w
            s = np.linspace(0.0, end - t, 20_001)
            gap = np.sin(tau * t) + after * s - 0.5 * g * s * s - np.sin(tau * (t + s))
            assert abs(gap[-1]) < 1e-12
            depth = min(depth, gap.min())
        assert o.admissible == (depth > -1e-12) and not o.stable
        assert o.admissible or o.clearance == pytest.approx(depth, abs=1e-7)
        found = np.stack(hits)
        if n == 1:
            angle = np.arccos((1.0 - e) * g / (2.0 * tau * (1.0 + e))) / tau
            assert found[:, 0] == pytest.approx((angle if o.admissible else 1.0 - angle, -g / 2.0), abs=1e-13)
    if n == 2:  # the last one, as printed
        np.testing.assert_allclose(
            np.add(found.T[::-1], [[0, 0], [1, 0]]),
            [[0.770007347, -6.373271421], [1.246735567, 1.839916716]],
            atol=6e-10,
        )


def test_church_and_fortins_orbit_that_the_ball_has_is_proven_to_be_unstable(page):
    (orbit,) = gz.periodic_orbits(page.P, 1, word="1", starts=200)
    proof = gz.certify(orbit)
    assert (
        proof.proven
        and proof.claims["stability"] == "unstable"
        and orbit.times[0] == pytest.approx(0.236177618990, abs=1e-12)
    )
    (same,) = gz.periodic_orbits(
        gz.impact_map(page.P.model), 1, word="1", starts=200
    )  # whose last impact ends the flight
    assert gz.certify(same).claims == proof.claims


@pytest.mark.parametrize(("a", "b", "l"), [(0.5, 0.5, -1.0), (0.7, 0.3, -0.6), (0.5, -0.5, -1.0)])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_jain_and_banerjee_have_windows_where_their_lines_say(page, a, b, l, n):
    low, high = climb_ends(n, a, b, l)
    P = page.jain_banerjee(a, b, 0.4 * low + 0.6 * high, l)
    assert page.existence(P, "L" * n + "R") == pytest.approx([low, high], abs=1e-12)


def test_jain_and_banerjee_are_mirrored_by_turning_x_round(page):
    # x -> -x takes (a, b, mu, l) to (b, a, -mu - l, l): R^n L exists where L^n R does after that
    low, high = climb_ends(2, 0.5, 0.5, -1.0)
    P = page.jain_banerjee(0.5, 0.5, 0.75, -1.0)
    assert page.existence(P, "LRR") == pytest.approx([1.0 - high, 1.0 - low], abs=1e-12)


def test_jain_and_banerjee_add_periods_or_let_them_coexist(page):
    values = [0.1, 0.148, 0.25, 0.36, 0.6]
    sets = {}
    for b in (0.5, -0.5):
        diagram = gz.orbit_diagram(page.jain_banerjee(0.5, b, 0.5, -1.0), "mu", values, starts=200)
        sets[b] = [set(row.tolist()) for row in diagram.period.values]
    assert all(len(periods) == 1 and min(periods) > 1 for periods in sets[0.5])
    ends = {n + 1: climb_ends(n, 0.5, -0.5, -1.0) for n in range(1, 12)}
    assert sets[-0.5] == [{period for period, (low, high) in ends.items() if low < mu < high} for mu in values]
    assert [len(periods) for periods in sets[-0.5]] == [1, 2, 1, 2, 1]


def test_jain_and_banerjee_have_two_fixed_points_for_a_jump_up(page):
    a, b, mu, l = 0.5, 0.3, -0.4, 1.0
    found = gz.periodic_orbits(page.jain_banerjee(a, b, mu, l), 1, starts=400)
    points = {orbit.word: orbit.points[0, 0] for orbit in found if orbit.stable}
    assert points == pytest.approx({"L": mu / (1.0 - a), "R": (mu + l) / (1.0 - b)}, abs=1e-12)


@pytest.mark.parametrize("values", [(0.0, 2.2, 0.1, 0.6), (0.1, 1.4, -0.2, 0.9)])
def test_peterka_flies_as_the_equation_says(page, values):
    beta, eta, rho, R = values
    same_flight(page.peterka(*values), (rho - 0.5, 0.2), lambda t, x, v: np.cos(eta * t) - 2.0 * beta * v - x, rho, r=R)


@pytest.mark.parametrize(("n", "eta", "rho"), [(1, 2.2, 0.1), (1, 1.4, 0.1), (2, 3.5, 0.1), (1, 2.2, -0.05)])
def test_peterka_hits_as_fast_as_the_closed_form_says(page, n, eta, rho):
    # X = q cos(s) + q t sin(s) + response, s from the impact: both ends of the flight lie at rho
    R, t = 0.6, np.tan(np.pi * n / eta)
    side = (t * (1.0 - R) / ((1.0 + R) * eta)) ** 2
    q = np.roots([1.0 + side, -2.0 * rho, rho * rho - (1.0 - eta * eta) ** -2])
    speeds = 2.0 * abs(t * q) / (1.0 + R)
    orbits = gz.one_impact_orbits(page.peterka(0.0, eta, rho, R), n)
    stable = [orbit for orbit in orbits if orbit.stable and orbit.admissible]
    assert len(stable) == 1 and sum(int(letter) for letter in stable[0].word) == 1 and len(stable[0].word) == n
    assert [min(abs(speeds / -orbit.v_minus - 1.0)) < 1e-12 for orbit in stable] == [True]
