"""Free flight against the arbitrary-precision reference: every damping, resonance, no stiffness; the error bound."""

import math

import flint
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import grazing as gz
from grazing.kernel.compile import compiled
from grazing.maps.stroboscopic import stroboscopic_map
from grazing.oscillator.constants import roots
from grazing.oscillator.flight import anchored, divided2, divided3, duhamel, flight, modes, noise
from grazing.parameter import parameters
from tests.examples import examples
from tests.models import PLAIN, packed
from tests.reference import Problem, free_flight, newton


def problem_of(m):
    f = m.forcing
    return Problem(m.alpha, m.k, f.omega, f.t0, f.offset, f.cos, f.sin, m.sigma, newton(0.5))


def error(m, c, t, y, v, s):
    """Return (errors of y and v, bound on the first) of one flight."""
    a = anchored(t, y, v, c)
    got = flight(s, a, c)
    exact = free_flight(problem_of(m), t, y + m.sigma, v, s)
    ey = abs(float(exact[0] - flint.arb(m.sigma) - flint.arb(got[0])))
    return ey, abs(float(exact[1] - flint.arb(got[1]))), noise(s, a, c)


@pytest.mark.parametrize("name", PLAIN)
def test_flight_and_its_error_bound(name):
    m = PLAIN[name].replace(sigma=0.0) if PLAIN[name].sigma else PLAIN[name]
    c = packed(stroboscopic_map(m))
    rng = np.random.default_rng(7)
    ratios = []
    for _ in range(60):
        t = float(rng.uniform(0.0, c.T))
        y, v = float(rng.uniform(0.0, 1.0)), float(rng.uniform(-1.0, 1.0))
        s = float(rng.uniform(0.0, 1.0) ** 3 * (c.T - t))
        ey, ev, bounds = error(m, c, t, y, v, s)
        ratios.append((ey / bounds[0], ev / bounds[1]))
    assert np.max(ratios) <= 0.8


@given(
    alpha=st.one_of(st.just(0.0), st.floats(0.0, 300.0)),
    k=st.one_of(st.just(0.0), st.floats(1e-9, 50.0)),
    omega=st.floats(0.1, 10.0),
    offset=st.floats(-2.0, 2.0),
    y=st.floats(0.0, 1.0),
    v=st.floats(-1.0, 1.0),
    part=st.floats(0.0, 1.0),
)
@settings(max_examples=examples(150), deadline=None)
def test_bound_holds_for_any_model(alpha, k, omega, offset, y, v, part):
    m = gz.pinball(alpha=alpha, k=k, omega=omega, d=offset)
    c = packed(stroboscopic_map(m))
    s = part * min(c.T, c.piece)
    ey, ev, bounds = error(m, c, 0.0, y, v, s)
    assert ey <= bounds[0]
    assert ev <= bounds[1]


@pytest.mark.parametrize("k", [1e-8, 1e-6, 1.0])
@pytest.mark.parametrize("alpha", [0.0, 1e-10, 2e-8, 2.0, 2.0 + 1e-13, 2.0 - 1e-13])
@pytest.mark.parametrize("omega", [1.0, 1e-8 + 1.0])
def test_places_where_plain_formulas_lose_their_digits(alpha, k, omega):
    m = gz.pinball(alpha=alpha, k=k, omega=omega, d=0.3)
    c = packed(stroboscopic_map(m))
    for s in (1e-6, 0.1, 1.0, 0.9 * min(c.T, c.piece)):
        ey, ev, _ = error(m, c, 0.0, 0.2, -0.3, s)
        assert max(ey, ev) <= 4e-15 * max(1.0, s * s)


@pytest.mark.parametrize("name", ["standard", "under-damped", "critical", "three harmonics", "stiff"])
def test_both_forms_of_the_forced_part_agree(name):
    c = packed(stroboscopic_map(PLAIN[name]))
    assert c.steady
    plain = c._replace(steady=False)
    for s in np.linspace(0.02, 0.98, 9) * min(c.T, c.piece):
        a, b = anchored(0.3, 0.2, -0.1, c), anchored(0.3, 0.2, -0.1, plain)
        assert flight(s, a, c) == pytest.approx(flight(s, b, plain), abs=4e-15)


@pytest.mark.parametrize("name", PLAIN)
def test_flights_compose(name):
    c = packed(stroboscopic_map(PLAIN[name]))
    for t, s1, s2 in ((0.0, 0.1, 0.2), (0.3, 0.01, 0.6), (0.5, 0.4, 0.02)):
        t, s1, s2 = (x * min(c.T, c.piece) for x in (t, s1, s2))
        middle = flight(s1, anchored(t, 0.3, -0.2, c), c)
        end = flight(s2, anchored(t + s1, *middle, c), c)
        assert end == pytest.approx(flight(s1 + s2, anchored(t, 0.3, -0.2, c), c), abs=1e-14 * max(1.0, c.size, c.rate))


@given(st.floats(0.0, 40.0), st.floats(0.0, 20.0), st.floats(0.0, 3.0))
@settings(deadline=None)
def test_modes_are_the_exponential_of_b(alpha, k, s):
    c = packed(stroboscopic_map(gz.pinball(alpha=alpha, k=k)))
    if c.spread * s > 50.0:
        return
    B = flint.arb_mat([[0, flint.arb(s)], [-(flint.arb(k) ** 2) * flint.arb(s), -flint.arb(alpha) * flint.arb(s)]])
    exact = B.exp()
    E = modes(s, c)
    for i in range(4):
        # E21 carries k^2, and the phase of an oscillation its own rounding
        allowed = 1e-15 * (1.0 + k * k * s + c.spread * s) * max(1.0, k)
        assert abs(float(exact[i // 2, i % 2]) - E[i]) <= allowed
    assert compiled(modes)(s, c) == E


@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-6, 1e-3, 0.3, 2.0, 50.0])
def test_divided_differences_with_close_and_distant_nodes(apart):
    def exact2(a, b, s):
        if a == b:
            return s * (a * s).exp()
        return ((a * s).exp() - (b * s).exp()) / (a - b)

    with flint.ctx.workprec(600) if hasattr(flint.ctx, "workprec") else _precision(600):
        for direction in (1.0, 1j, 1 + 1j):
            a, b, c = complex(-0.3, 0.2), complex(-0.3, 0.2) + apart * direction * 0.5, complex(0.0, 1.1)
            A, B, C = (flint.acb(z.real, z.imag) for z in (a, b, c))
            for s in (1e-3, 0.5, 2.0):
                S = flint.arb(s)
                two = exact2(A, B, S)
                size = abs(complex(two)) + s * max(1.0, math.exp(max(a.real, b.real) * s))
                assert abs(complex(two) - divided2(a, b, s)) <= 4e-15 * size * max(1.0, abs(b) * s)
                if A != C and B != C:
                    three = (two - exact2(B, C, S)) / (A - C)
                    size = abs(complex(three)) + 0.5 * s * s
                    assert abs(complex(three) - divided3(a, b, c, s)) <= 1e-14 * size * max(1.0, abs(b) * s) * max(
                        1.0, math.exp(b.real * s)
                    )


class _precision:
    def __init__(self, bits):
        self.bits = bits

    def __enter__(self):
        self.old, flint.ctx.prec = flint.ctx.prec, self.bits

    def __exit__(self, *_):
        flint.ctx.prec = self.old


def test_short_flights_keep_their_relative_digits():
    """A hop of 1e-7: y/s has all its digits although y is 1e-14."""
    m = gz.pinball(V=0.0, d=-0.5)
    c = packed(stroboscopic_map(m))
    s, v = 1e-7, 4e-8
    a = anchored(1.0, 0.0, v, c)
    exact = free_flight(problem_of(m), 1.0, 0.0, v, s)
    assert flight(s, a, c)[0] == pytest.approx(float(exact[0]), rel=1e-13)
    assert duhamel(s, 1.0, c)[0] < 0.0


@pytest.mark.parametrize(("alpha", "k"), [(3.0, 1.0), (0.0, 0.0), (1e8, 1e-4), (5.0, 0.0)])
def test_roots_without_cancellation(alpha, k):
    q2, spread, l1, l2 = roots(parameters({"alpha": alpha, "k": k}))
    assert q2 >= 0.0
    assert l1 + l2 == pytest.approx(-alpha, rel=1e-15)
    assert l1 * l2 == pytest.approx(k * k, rel=1e-15)
    assert spread == pytest.approx(0.5 * (l1 - l2), rel=1e-15)
