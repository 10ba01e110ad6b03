"""Edges of windows that doubles cannot tell apart, against mpmath with formulas of its own."""

import mpmath as mp
import numpy as np
import pytest

import grazing as gz
from grazing.orbits.exact_edges import before_fold, ordered
from grazing.orbits.survey import families

N = 4
MODEL = {"alpha": 3.0, "k": 1.4387518284798846, "omega": 1.8484749924305577, "r": 0.4467934265212999}
V, FOLD, PHASE = 0.39976223652663856, 0.3627360408020997, 4.950653344284824


def orbit(phi, d, model, V):
    """Return (G, v, trace, det) of an over-damped flight of N periods from the two exponentials of its equation."""
    a, k, om, r = (mp.mpf(model[x]) for x in ("alpha", "k", "omega", "r"))
    root = mp.sqrt(a * a / 4 - k * k)
    l1, l2, L = -a / 2 + root, -a / 2 - root, 2 * mp.pi * N / om
    e1, e2 = mp.exp(l1 * L), mp.exp(l2 * L)
    h = 1 / mp.mpc(k * k - om * om, a * om) * mp.expj(phi)  # the steady response is Re h + d/k^2, and periodic
    Y, dY = h.real + d / (k * k), (h * mp.mpc(0, om)).real
    E11, E12 = (l1 * e2 - l2 * e1) / (l1 - l2), (e1 - e2) / (l1 - l2)
    E21, E22 = -k * k * E12, (l1 * e1 - l2 * e2) / (l1 - l2)
    # 0 = Y + E11 (0 - Y) + E12 (w - Y'), v = Y' + E21 (0 - Y) + E22 (w - Y'), w = V - r v
    w = (E11 * Y - Y) / E12 + dY
    v = dY - E21 * Y + E22 * (w - dY)
    F = mp.cos(phi) + d
    fall, lift = F - a * v, F - a * w
    S = mp.matrix([[w / v, 0], [(lift + r * fall) / v, -r]])
    J = mp.matrix([[E11, E12], [E21, E22]]) * S
    return w - (V - r * v), v, J[0, 0] + J[1, 1], J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]


def newton(f, x):
    """Solve f(x) = 0 by Newton's method with differences."""
    x, h = [mp.mpf(one) for one in x], mp.mpf(10) ** -25
    for _ in range(15):
        here = mp.matrix(f(*x))
        J = mp.matrix(len(x))
        for i in range(len(x)):
            moved = [one + (h if i == j else 0) for j, one in enumerate(x)]
            J[:, i] = (mp.matrix(f(*moved)) - here) / h
        step = mp.lu_solve(J, here)
        x = [one - step[i] for i, one in enumerate(x)]
    assert mp.norm(step) < mp.mpf(10) ** -40
    return tuple(x)


def slope(phi, d, model, V):
    """Return dG/dphi; of one harmonic G is A cos + B sin + C."""
    quarter = mp.pi / 2
    return (orbit(phi + quarter, d, model, V)[0] - orbit(phi - quarter, d, model, V)[0]) / 2


def solved(model, V, phi, d):
    """Return the fold and the period doubling, each as (phi, d)."""

    def fold(phi, d):
        return orbit(phi, d, model, V)[0], slope(phi, d, model, V)

    def doubling(phi, d):
        G, v, trace, det = orbit(phi, d, model, V)
        return G, v * (1 + trace + det)

    at = newton(fold, (phi, d))
    return at, newton(doubling, at)


def truth(model, V, phi, d):
    """Return (type, value) at the end of the branch that has v < 0 before it, and how far apart the candidates are."""
    fold, doubling = solved(model, V, phi, d)
    below = fold[1] - mp.mpf(10) ** -9  # a point before the fold on either branch; the right one hits faster
    bend = mp.sqrt(mp.mpf(10) ** -9)
    sides = []
    for side in (-1, 1):
        x = newton(lambda x: [orbit(x, below, model, V)[0]], [fold[0] + side * bend])[0]
        sides.append((orbit(x, below, model, V)[1], x))
    before = min(sides)[1]
    on_branch = (doubling[0] - fold[0]) * (before - fold[0]) > 0
    return ("pd", doubling[1]) if on_branch else ("lp", fold[1]), fold[1] - doubling[1]


@pytest.fixture(autouse=True)
def digits():
    with mp.workdps(60):
        yield


@pytest.mark.parametrize("nearer", [0.0, 1e-9, -1e-9, 1e-7, -1e-7, 3e-6, -3e-6, 3e-5, -3e-5])
def test_a_doubling_beside_a_fold(nearer):
    """From the fold to the doubling is 1e-19 ... 1e-10: which of them ends the window changes with V."""
    kick = V * (1.0 + nearer)
    (kind, value), apart = truth(MODEL, kick, mp.mpf(PHASE), mp.mpf(FOLD))
    assert abs(apart) < 1e-8
    table = gz.windows(gz.pinball(**MODEL, V=kick), "d", N=N, span=(0.36, 0.37), samples=100)
    ends = [(table.high_type[i].item(), table.high[i].item()) for i in range(table.sizes["window"])]
    assert [end[0] for end in ends] == [kind]
    assert ends[0][1] == pytest.approx(float(value), rel=3e-16 if kind == "pd" else 1e-12)


def test_the_example():
    table = gz.windows(gz.pinball(**MODEL, V=V), "d", N=N)
    assert (table.high_type.item(), table.high_status.item()) == ("pd", "zero")
    assert table.high.item() == pytest.approx(0.36273604080173865, rel=2e-16)


@pytest.mark.parametrize("shift", [("r", 0.02), ("k", -0.01), ("omega", 0.01), ("alpha", 0.02)])
def test_coincidences_of_other_models(shift):
    """Follow the point at which the fold has speed 0 to another model; next to it pd and lp change places."""
    name, share = shift
    model, at = dict(MODEL), (mp.mpf(PHASE), mp.mpf(FOLD), mp.mpf(V))
    for _ in range(4):
        model[name] *= 1.0 + share / 4

        def corner(phi, d, kick, model=model):
            G, v, *_ = orbit(phi, d, model, kick)
            return G, slope(phi, d, model, kick), v

        at = newton(corner, at)
    seen = set()
    for off in (-1e-5, -1e-6, 1e-6, 1e-5):
        kick = float(at[2]) * (1.0 + off)
        (kind, value), apart = truth(model, kick, at[0], at[1])
        assert abs(apart) < 1e-9
        low, high = float(at[1]) - 0.003, float(at[1]) + 0.003
        table = gz.windows(gz.pinball(**model, V=kick), "d", N=N, span=(low, high), samples=100)
        ends = [i for i in range(table.sizes["window"]) if abs(table.high[i].item() - float(at[1])) < 1e-8]
        if not ends:
            continue  # the orbit is not stable on either side
        assert table.high_type[ends[0]].item() == kind
        assert table.high[ends[0]].item() == pytest.approx(float(value), rel=3e-16 if kind == "pd" else 1e-12)
        seen.add(kind)
    assert seen


def test_the_order_of_edges_below_rounding():
    (family,) = families(gz.pinball(**MODEL, V=V), N, "d")
    fold, doubling = solved(MODEL, V, mp.mpf(PHASE), mp.mpf(FOLD))
    found = ordered(family, [("lp", PHASE, FOLD), ("pd", PHASE, FOLD)])
    assert [i for i, _ in found] == ([1, 0] if doubling[1] < fold[1] else [0, 1])
    assert [value for _, value in found] == sorted([float(doubling[1]), float(fold[1])])
    assert ordered(family, [("pd", PHASE + 1.0, FOLD + 0.3), ("gr", PHASE, 40.0)]) is None


def test_nothing_is_met_before_an_ordinary_fold():
    (family,) = families(gz.pinball(**MODEL, V=V), N, "d")
    assert before_fold(family, PHASE - 1e-6, np.full(7, -1.0), FOLD + 0.2, PHASE) is None
