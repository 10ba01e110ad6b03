"""Ends of pieces of maps of one's own: closed forms in rational numbers, square roots, names that mean nothing."""

from fractions import Fraction
from math import floor, sqrt

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.branch import continuation
from grazing.orbits.one_sided import distances, slope


def piecewise(state, p):
    (x,) = state
    if x < 0.0:
        return (p.a * x + p.mu,), 0
    return (p.b * x + p.mu + p.l,), 1


def unnamed(state, p):
    (x,) = state
    if x < 0.0:
        return (p.a * x + p.mu,)
    return (p.b * x + p.mu + p.l,)


LINES = gz.Map(piecewise, params={"a": 0.5, "b": -0.6, "mu": -0.2, "l": 0.0}, box=((-1.0, 1.0),), letters="LR")


def orbit_of(P, points, word):
    points = np.atleast_2d(np.array(points, np.float64))
    return gz.Orbit(
        map=P, points=points, word=word, period=len(points), multipliers=np.zeros(P.dimension, np.complex128),
        admissible=True, condition=1.0, residual=0.0,
    )  # fmt: skip


def existence(word, a, b, l):
    """Return between which mu a word of the piecewise-linear map has its orbit, and its points A + B mu; or None."""
    slope_of, jump = {"L": a, "R": b}, {"L": Fraction(0), "R": l}
    A, B, turn = Fraction(0), Fraction(0), Fraction(1)
    for c in word:
        A, B, turn = slope_of[c] * A + jump[c], slope_of[c] * B + 1, slope_of[c] * turn
    if turn == 1:
        return None
    A, B = A / (1 - turn), B / (1 - turn)
    low, high, points = Fraction(-3, 2), Fraction(3, 2), []
    for c in word:
        points.append((A, B))
        if B == 0:
            if (A < 0) != (c == "L"):
                return None
        elif (c == "R") == (B > 0):
            low = max(low, -A / B)
        else:
            high = min(high, -A / B)
        A, B = slope_of[c] * A + jump[c], slope_of[c] * B + 1
    return (low, high, points) if low < high else None


def collisions(count, seed):
    """Draw words, slopes and gaps; hold every end that is reported to the rational one."""
    rng = np.random.default_rng(seed)
    words = gz.words("LR", 6)
    done = 0
    while done < count:
        a, b, l = (Fraction(int(rng.integers(-250, 250)), 100) for _ in range(3))
        word = words[rng.integers(len(words))]
        found = existence(word, a, b, l)
        if found is None or found[1] - found[0] < Fraction(1, 10**6):
            continue
        low, high, points = found
        mu = (low + high) / 2
        x = [[float(A + B * mu)] for A, B in points]
        if np.abs(x).max() > 3.0:
            continue
        P = LINES.replace(a=float(a), b=float(b), l=float(l), mu=float(mu))
        branch = continuation(P, orbit_of(P, x, word), "mu", (-1.5, 1.5))
        wanted = [float(end) for end in (low, high) if abs(end) != Fraction(3, 2)]
        special = sorted(branch.special, key=lambda one: one.value)
        assert [one.type for one in special] == ["bcb"] * len(wanted), (word, a, b, l, special)
        for one, value in zip(special, wanted, strict=True):
            assert one.converged and one.low <= value <= one.high, (word, a, b, l, one)
            assert abs(one.value - value) < 1e-12
        done += 1


def test_border_collisions_of_piecewise_linear_maps_are_the_rational_ones():
    collisions(12, 1)


@pytest.mark.long
def test_border_collisions_of_many_piecewise_linear_maps():
    collisions(300, 2)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("span", [1e-9, 1.0, 1e9])
def test_the_skew_tent_collides_at_zero_in_any_unit(size, span):
    def tent(state, p):
        (x,) = state
        if x < 0.0:
            return (0.5 * x + p.k * p.mu,), 0
        return (-0.6 * x + p.k * p.mu,), 1

    params = {"k": size / span, "mu": -0.2 * span}
    P = gz.Map(tent, params=params, box=((-size, size),), letters="LR")
    for high in (0.5, 0.0):  # the last one just where the piece ends
        (end,) = continuation(P, orbit_of(P, [[-0.4 * size]], "L"), "mu", (-0.5 * span, high * span)).special
        assert end.type == "bcb" and end.converged and end.low <= 0.0 <= end.high
        assert abs(end.value) < 1e-12 * span and end.high - end.low < 1e-12 * span


def test_two_collisions_nearer_than_a_step():
    """Points stay 1e-5 away from each other, and the orbit lives on an interval of length 3e-10 or less."""
    for b in (Fraction(2.000116194189468), Fraction(2.00011619419)):
        low, high, points = existence("LLRR", Fraction(1, 2), b, Fraction(-1))
        assert high - low < 1e-9
        mu = (low + high) / 2
        P = LINES.replace(a=0.5, b=float(b), l=-1.0, mu=float(mu))
        orbit = orbit_of(P, [[float(A + B * mu)] for A, B in points], "LLRR")
        ends = continuation(P, orbit, "mu", (-1.0, 1.0)).special
        assert sorted(end.value for end in ends) == pytest.approx([float(low), float(high)], abs=1e-14)
        assert all(end.converged for end in ends)


def test_a_map_that_does_not_name_its_pieces_has_no_invented_points():
    for b, l, types in ((-0.6, 0.0, []), (-1.5, 0.0, []), (1.5, 0.0, ["ep"]), (0.4, 0.3, ["ep"]), (-0.6, -0.2, ["ep"])):
        P = gz.Map(unnamed, params={"a": 0.5, "b": b, "mu": -0.2, "l": l}, box=((-1.0, 1.0),))
        special = continuation(P, orbit_of(P, [[-0.4]], "0"), "mu", (-0.5, 0.5)).special
        assert [one.type for one in special] == types
        for one in special:
            assert one.converged and one.low <= 0.0 <= one.high and abs(one.value) < 1e-12


def nordmark(state, p):
    x, y = state
    if x < 0.0:
        return (p.tau * x + y + p.mu, -p.det * x), 0
    return (p.tau * x + y + p.mu - p.g * sqrt(x) - p.jump, -p.det * x), 1


def nordmark_unnamed(state, p):
    x, y = state
    if x < 0.0:
        return (p.tau * x + y + p.mu, -p.det * x)
    return (p.tau * x + y + p.mu - p.g * sqrt(x) - p.jump, -p.det * x)


@pytest.mark.parametrize(
    "tau, det, g, jump, named",
    [
        (0.5, 0.1, 1.0, 0.0, True), (0.5, 0.1, 1.0, 0.0, False), (0.5, 0.1, -0.6, 0.0, True),
        (0.4, 0.05, -1.0, 0.1, True), (0.4, 0.05, -1.0, 0.1, False), (-0.5, 0.3, 0.8, -0.3, True),
    ],
)  # fmt: skip
def test_next_to_a_graze_of_a_square_root_map(tau, det, g, jump, named):
    """With s = sqrt(x) the fixed point has mu = k s^2 + g s + jump, k = 1 - tau + det; pd and lp are zeros in g/s."""
    params = {"tau": tau, "det": det, "mu": 0.3, "g": g, "jump": jump}
    step, letters = (nordmark, "LR") if named else (nordmark_unnamed, None)
    P = gz.Map(step, params=params, coordinates=("x", "y"), box=((-1.0, 1.0), (-1.0, 1.0)), letters=letters)
    k = 1.0 - tau + det
    s = max(np.roots([k, g, jump - 0.3]).real)
    special = continuation(P, orbit_of(P, [[s * s, -det * s * s]], "R"), "mu", (-0.5, 0.6)).special
    zeros = {"pd": g / (2.0 * (1.0 + tau + det)), "lp": -g / (2.0 * k)}
    wanted = {type: k * s * s + g * s + jump for type, s in zeros.items() if s > 0.0}
    wanted = {type: value for type, value in wanted.items() if -0.5 < value < 0.6} | {"gr": jump}
    assert sorted(one.type for one in special) == sorted(wanted)
    for one in special:
        assert one.low <= wanted[one.type] <= one.high or abs(one.value - wanted[one.type]) < 1e-12
        assert not one.converged or abs(one.value - wanted[one.type]) < 1e-12
        assert one.converged or (one.type == "gr" and not named)


def test_letters_that_mean_nothing_are_no_bifurcations():
    def logistic(state, p):
        (x,) = state
        return (p.a * x * (1.0 - x),), floor(10.0 * x)

    P = gz.Map(logistic, params={"a": 2.0}, box=((0.0, 1.0),), letters="0123456789")
    branch = continuation(P, orbit_of(P, [[0.5]], "5"), "a", (1.2, 3.9))
    (pd,) = branch.special
    assert pd.type == "pd" and pd.value == pytest.approx(3.0, abs=1e-12)
    crossed = sorted(one.value for one in branch.relabellings)
    assert crossed == pytest.approx([1.0 / (1.0 - j / 10.0) for j in (2, 3, 4, 5, 6, 7)], abs=1e-12)
    assert {orbit.word for orbit in branch} == set("1234567")
    (second,) = continuation(P, pd, "a", (1.2, 3.9)).special
    assert second.value == pytest.approx(1.0 + sqrt(6.0), abs=1e-11)


def test_a_fold_beyond_a_relabelling():
    def step(state, p):
        (x,) = state
        return (p.a - x * x,), 0 if x < p.c else 1

    P = gz.Map(step, params={"a": 0.5, "c": 0.2}, box=((-2.0, 2.0),), letters="AB")
    branch = continuation(P, orbit_of(P, [[0.5 * (sqrt(3.0) - 1.0)]], "B"), "a", (-0.5, 1.0))
    assert {one.type: one.value for one in branch.special} == pytest.approx({"pd": 0.75, "lp": -0.25}, abs=1e-12)
    (crossed,) = branch.relabellings
    assert crossed.value == pytest.approx(0.24, abs=1e-12) and (crossed.before, crossed.after) == ("B", "A")
    assert len(continuation(P, orbit_of(P, [[0.5 * (sqrt(3.0) - 1.0)]], "B"), "c", (-0.5, 1.0)).relabellings) == 1


@pytest.mark.parametrize("tl, dl, tr, dr", [(0.5, 0.2, -1.2, 0.4), (-0.8, 0.3, 0.6, -0.5), (1.4, 0.6, -1.6, 0.9)])
def test_the_border_collision_normal_form_and_the_lozi_map(tl, dl, tr, dr):
    def normal_form(state, p):
        x, y = state
        if x < 0.0:
            return (p.tl * x + y + p.mu, -p.dl * x), 0
        return (p.tr * x + y + p.mu, -p.dr * x), 1

    params = {"tl": tl, "dl": dl, "tr": tr, "dr": dr, "mu": -0.1}
    P = gz.Map(normal_form, params=params, coordinates=("x", "y"), box=((-1.0, 1.0), (-1.0, 1.0)), letters="LR")
    for t, d, side, word in ((tl, dl, -1.0, "L"), (tr, dr, 1.0, "R")):
        mu = side * 0.1 * np.sign(1.0 - t + d)
        x = mu / (1.0 - t + d)
        Q = P.replace(mu=mu)
        special = continuation(Q, orbit_of(Q, [[x, -d * x]], word), "mu", (-0.3, 0.3)).special
        assert [one.type for one in special] == ["bcb"] and special[0].low <= 0.0 <= special[0].high
        assert abs(special[0].value) < 1e-12 and special[0].converged


def test_a_slope_through_minus_one_doubles():
    found = continuation(LINES, orbit_of(LINES, [[-0.4]], "L"), "a", (-1.5, 0.7)).special
    assert [(one.type, one.converged) for one in found] == [("pd", True)] and abs(found[0].value + 1.0) < 1e-12


def test_ends_of_maps_of_ones_own_are_not_followed_in_two_parameters():
    (end,) = continuation(LINES, orbit_of(LINES, [[-0.4]], "L"), "mu", (-0.5, 0.5)).special
    with pytest.raises(gz.InputError, match="at several values of the second parameter"):
        gz.locus(end, ("mu", "a"), ((-0.5, 0.5), (0.2, 0.8)))


def test_differences_know_their_error():
    for f, exact in ((np.sin, np.cos), (np.exp, np.exp), (lambda x: x * x, lambda x: 2.0 * x)):
        for x in (0.3, -1.7, 0.0):
            h = distances(1.0, x)
            found = slope(np.array(f(x)), f(x - h), f(x + h), h, h)
            assert abs(found.value - exact(x)) < 1e-11 and abs(found.value - exact(x)) <= found.error + 1e-15
    for m in (1e-3, 1e-8, 1e-16):  # a square root, from one side
        h = distances(1.0, m)
        with np.errstate(invalid="ignore"):
            found = slope(np.sqrt(m), np.sqrt(m - h), np.sqrt(m + h), h, h)
        assert found.value == pytest.approx(0.5 / np.sqrt(m), rel=1e-6)
    for m in (1e-3, 1e-9, 0.0):  # a kink: the slope beside it, or an error as large as the kink
        h = distances(1.0, m)
        found = slope(np.array(m), np.abs(m - h), m + h, h, h)
        assert found.value == pytest.approx(1.0, abs=1e-10) or found.error > 1.0


def uneven(state, p):
    (x,) = state
    if x <= p.c:
        return (p.a * x - p.mu,), 0
    return (p.b * x - p.mu + p.h,), 1


@pytest.mark.parametrize("a", [0.5, 1.0, -0.25])
def test_a_kink_that_the_branch_does_not_feel_is_a_border_collision(a):
    """For b = -1 the orbit LR has x = h/(1 + a): at its collision the map is continuous, and along the branch smooth.

    Across the border its slope jumps from a to -1.
    """
    T = gz.Map(uneven, params={"a": a, "b": -1.0, "mu": -0.6, "h": 0.0, "c": 0.05}, box=((-3.0, 3.0),), letters="LR")
    (orbit,) = [one for one in gz.periodic_orbits(T, 2) if one.word == "LR"]
    branch = gz.continuation(T, orbit, "h", (-0.5, 0.5))
    (point,) = [one for one in branch.special if one.type not in ("pd", "lp")]
    assert (point.type, point.converged) == ("bcb", True)
    assert point.low <= 0.05 * (1.0 + a) <= point.high
    assert branch.relabellings == ()
