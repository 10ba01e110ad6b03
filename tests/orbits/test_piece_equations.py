"""Orbits of maps by pieces: virtual ones, collisions from both sides, loci of collisions, against closed forms."""

import pickle
from fractions import Fraction
from math import sqrt

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.map_equations import MapEquations
from grazing.orbits.piece_equations import PieceEquations
from tests.maps.test_bordered import LINES, THREE, border


def found(branch, admissible=True):
    return sorted((one.type, one.value) for one in branch.special if one.admissible is admissible)


def test_the_skew_tent_collides_at_zero_and_goes_on():
    T = LINES.replace(a=0.5, b=-0.6, mu=-0.2, l=0.0)
    (orbit,) = gz.periodic_orbits(T, 1, starts=40)
    branch = gz.continuation(T, orbit, "mu", (-0.5, 0.5))
    (one,) = branch.special
    assert one.type == "bcb" and one.converged and abs(one.value) < 1e-12 and one.to == 1
    assert [piece.orbits[-1].word for piece in branch.pieces] == ["L", "R"]
    last = branch.pieces[0].orbits[-1]  # L at mu = 0.5: a virtual fixed point at 1
    assert not last.admissible and last.depth == pytest.approx(1.0, abs=1e-12)
    assert last.multipliers[0] == pytest.approx(0.5, abs=1e-13)
    assert "virtual (1 beyond the border)" in repr(last)
    assert [orbit.admissible for orbit in branch.at(0.3)] == [False, True]


def test_a_map_with_a_gap_collides_at_rational_values():
    (orbit,) = gz.periodic_orbits(LINES, word="LR", starts=40)
    branch = gz.continuation(LINES, orbit, "mu", (-0.5, 0.5))
    assert found(branch) == [("bcb", pytest.approx(1 / 7, abs=1e-12)), ("bcb", pytest.approx(5 / 17, abs=1e-12))]
    assert all(one.converged and one.to == -1 for one in branch.special) and len(branch.pieces) == 1
    for value, depth in ((0.4, 0.25), (0.1, 1 / 12)):  # x0 = (1.7 mu - 0.5)/0.72, x1 = (1.4 mu - 0.2)/0.72
        (virtual,) = branch.at(value)
        assert not virtual.admissible and virtual.depth == pytest.approx(depth, abs=1e-12)
    (again,) = gz.periodic_orbits(
        LINES.replace(mu=0.4), word="LR", starts=40
    )  # none is admissible: the virtual one is listed
    assert not again.admissible and again.points == pytest.approx(branch.at(0.4)[0].points, abs=1e-12)


def test_the_loci_of_collisions_are_lines_and_meet():
    """The ends of LR are mu = -a l/(1 + a) and mu = -l/(1 + b): they meet where l = 0, or a = 1/b."""
    (orbit,) = gz.periodic_orbits(LINES, word="LR", starts=40)
    lower, upper = gz.continuation(LINES, orbit, "mu", (0.0, 0.5)).special
    curve = gz.locus(lower, ("mu", "l"), ((-0.5, 0.5), (-0.9, 0.6)), step=0.1)
    assert np.abs(curve.values[:, 0] + 0.4 / 1.4 * curve.values[:, 1]).max() < 1e-12
    (met,) = curve.meetings
    assert met.type == "bcb+bcb" and np.abs(met.values).max() < 1e-12 and met.converged
    inside = (curve.dataset.admissible.values == (curve.values[:, 1] <= 0.0)) | (np.abs(curve.values[:, 1]) < 1e-12)
    assert inside.all() and 0 < curve.dataset.admissible.sum() < len(curve.values)
    curve = gz.locus(upper, ("mu", "b"), ((-0.5, 1.5), (-0.9, 0.9)), step=0.1)
    assert np.abs(curve.values[:, 0] - 0.5 / (1.0 + curve.values[:, 1])).max() < 1e-11


def test_every_word_is_followed_by_the_same_calls():
    P = LINES.replace(a=0.9, b=-1.4, mu=0.3, l=0.0)
    known = gz.periodic_orbits(P, range(1, 5), virtual=True, starts=40)
    assert {orbit.word for orbit in known} == {"L", "R", "LR", "LLR", "LRR", "LLLR", "LLRR", "LRRR"}  # each has one
    assert "each word of the length beyond the border too" in known.statement
    for orbit in known:
        slope = np.prod([0.9 if letter == 0 else -1.4 for letter in orbit.letters])
        assert orbit.multipliers[0].real == pytest.approx(slope, abs=1e-10) and orbit.residual < 1e-14
        assert orbit.admissible == ((orbit.points[:, 0] >= 0.0) == np.array(orbit.letters)).all()
        back = gz.continuation(P, orbit, "mu", (-0.4, 0.4), step=0.2)
        assert any(abs(one.value) < 1e-12 for one in back.special) and {one.type for one in back.special} == {"bcb"}


def virtual_orbit(word, a, b, l, mu):
    """Return a piecewise-linear map, its orbit of a word wherever that lies, and its points A + B mu."""
    slope, jump = {"L": a, "R": b}, {"L": Fraction(0), "R": l}
    A, B, turn = Fraction(0), Fraction(0), Fraction(1)
    for c in word:
        A, B, turn = slope[c] * A + jump[c], slope[c] * B + 1, slope[c] * turn
    A, B, points = A / (1 - turn), B / (1 - turn), []
    for c in word:
        points.append((A, B))
        A, B = slope[c] * A + jump[c], slope[c] * B + 1
    P, x = LINES.replace(a=float(a), b=float(b), l=float(l), mu=float(mu)), [[float(A + B * mu)] for A, B in points]
    margins = np.array([v if c == "R" else -v for (v,), c in zip(x, word, strict=True)])
    orbit = gz.PieceOrbit(
        map=P, points=np.array(x), word=word, period=len(word), multipliers=np.zeros(1, complex), condition=1.0,
        admissible=bool((margins > 0.0).all()), residual=0.0, margins=margins,
        letters=tuple("LR".index(c) for c in word),
    )  # fmt: skip
    return P, orbit, points


@pytest.mark.parametrize(
    "word, a, b, l, mu", [("LLRLR", "0.63", "-1.47", "0.2", "0.11"), ("LRR", "-1.9", "0.7", "-0.83", "-0.5")]
)
def test_all_collisions_of_a_word_virtual_ones_too_are_the_rational_ones(word, a, b, l, mu):
    P, orbit, points = virtual_orbit(word, *map(Fraction, (a, b, l, mu)))
    branch = gz.continuation(P, orbit, "mu", (-1.5, 1.5), step=0.3)
    special = sorted((one for one in branch.special if one.piece == 0), key=lambda one: one.value)
    wanted = sorted(-A / B for A, B in points if abs(A / B) < Fraction(3, 2))
    assert [one.value for one in special] == pytest.approx([float(one) for one in wanted], abs=1e-12) and wanted
    for one in special:
        sides = [
            (A + B * Fraction(one.value)) * (1 if c == "R" else -1) for (A, B), c in zip(points, word, strict=True)
        ]
        assert one.type == "bcb" and one.converged and one.admissible == (min(sides) > -1e-9)


def nordmark_left(state, p):
    x, y = state
    return p.tau * x + y + p.mu, -p.det * x


def nordmark_right(state, p, root):
    x, y = state
    return p.tau * x + y + p.mu - p.g * root - p.jump, -p.det * x


PLANE = gz.Map(
    pieces={"L": nordmark_left, "R": nordmark_right}, border=border, coordinates=("x", "y"),
    box=((-1.0, 1.0), (-1.0, 1.0)), params={"tau": 0.5, "det": 0.1, "mu": 0.3, "g": 1.0, "jump": 0.0},
)  # fmt: skip


@pytest.mark.parametrize(
    "tau, det, g, jump", [(0.5, 0.1, 1.0, 0.0), (0.5, 0.1, -0.6, 0.0), (0.4, 0.05, -1.0, 0.1), (-0.5, 0.3, 0.8, -0.3)]
)
def test_a_square_root_map_of_the_plane_from_both_sides(tau, det, g, jump):
    """With the root s the fixed point R has mu = k s^2 + g s + jump, k = 1 - tau + det, also for s < 0: virtual."""
    P, k = PLANE.replace(tau=tau, det=det, g=g, jump=jump), 1.0 - tau + det
    points = [orbit for orbit in gz.periodic_orbits(P, 1, virtual=True, starts=40) if orbit.word == "R"]
    s = np.sort(np.roots([k, g, jump - 0.3]).real)
    assert sorted(orbit.points[0, 0] for orbit in points) == pytest.approx(sorted(s * s), abs=1e-12)
    orbit = max(points, key=lambda one: one.clearance)
    assert orbit.admissible and orbit.clearance == pytest.approx(s[1] ** 2, abs=1e-12)
    branch = gz.continuation(P, orbit, "mu", (-0.5, 0.6))
    zeros = {"pd": g / (2.0 * (1.0 + tau + det)), "lp": -g / (2.0 * k), "bcb": 0.0}
    wanted = sorted((type, k * s * s + g * s + jump) for type, s in zeros.items())
    wanted = [(type, value) for type, value in wanted if -0.5 < value < 0.6]
    first = [one for one in branch.special if one.piece == 0]
    assert sorted((one.type, one.value) for one in first) == [(t, pytest.approx(v, abs=1e-12)) for t, v in wanted]
    for one in first:
        assert one.converged and one.admissible == (zeros[one.type] >= 0.0)
    (collision,) = (one for one in first if one.type == "bcb")
    assert (collision.to >= 0) == (jump == 0.0)  # the map is continuous there, and the fixed point L goes on
    if jump == 0.0:
        assert found(branch)[0] == ("bcb", pytest.approx(0.0, abs=1e-12))
        assert {orbit.word for orbit in branch.pieces[collision.to].orbits} == {"L"}
    (left,) = (orbit for orbit in gz.periodic_orbits(P.replace(mu=-0.2), 1, starts=40) if orbit.word == "L")
    specials = gz.continuation(P.replace(mu=-0.2), left, "mu", (-0.5, 0.6)).special
    assert {one.type for one in specials if one.piece == 0} == {"bcb"}
    assert specials[0].value == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("s", [1e-13, 0.0, -1e-9, 0.3])
def test_functions_of_stability_have_no_pole_at_the_border(s):
    """Times 2 s, pd and lp of the fixed point R are 2 s (1 + tau + det) - g and 2 s (1 - tau + det) + g."""
    mu, names = 0.6 * s * s + s, ("mu",)
    for N in (1, 2):  # and gone round twice
        equations = PieceEquations(PLANE, names, (1,) * N)
        x, p = equations.unknowns(np.array([[s * s, -0.1 * s * s]] * N), np.array([s] * N)), np.array([mu])
        assert np.abs(equations.defects(x, p)[0]).max() < 1e-15
        pd, lp, ns = (test.value for test in equations.tests(x, p)[:3])
        one, other = 2.0 * s * 1.6 - 1.0, 2.0 * s * 0.6 + 1.0
        if N == 1:
            assert (pd, lp, ns) == pytest.approx((one, other, 2.0 * s * 0.9), rel=1e-11, abs=1e-24)
        else:
            assert (lp, ns) == pytest.approx((one * other, 4.0 * s * s * 0.99), rel=1e-11, abs=1e-22)


def clamped(state, p):
    x, y = state
    return p.tau * x + y + p.mu - p.g * sqrt(max(x, 0.0)) - p.jump, -p.det * x


def test_a_piece_that_takes_its_own_root_is_followed_up_to_the_graze():
    """It has no slope at the border: as on maps that are not by pieces nothing is invented beyond."""
    P = gz.Map(
        pieces={"L": nordmark_left, "R": clamped}, border=border, coordinates=("x", "y"), box=PLANE.box,
        params=dict(PLANE.params),
    )  # fmt: skip
    orbit = next(one for one in gz.periodic_orbits(P, 1, starts=100) if one.word == "R")
    special = gz.continuation(P, orbit, "mu", (-0.5, 0.6)).special
    assert sorted((one.type, one.value, one.converged) for one in special) == [
        ("gr", pytest.approx(0.0, abs=1e-12), True), ("pd", pytest.approx(0.37109375, abs=1e-12), True),
    ]  # fmt: skip


def test_collisions_and_doublings_of_the_plane_in_two_parameters():
    """In jump the collision is mu = jump, the doubling mu = jump + c; they meet in g, where s = 0."""
    orbit = next(one for one in gz.periodic_orbits(PLANE, 1, starts=40) if one.word == "R")
    branch = gz.continuation(PLANE, orbit, "mu", (-0.3, 0.6))
    bcb, pd = (next(one for one in branch.special if one.type == type) for type in ("bcb", "pd"))
    curve = gz.locus(bcb, ("mu", "jump"), ((-0.5, 0.6), (-0.2, 0.2)), step=0.1)
    assert np.abs(curve.values[:, 0] - curve.values[:, 1]).max() < 1e-12 and not curve.meetings
    curve = gz.locus(pd, ("mu", "g"), ((-0.5, 0.9), (-0.5, 1.2)), step=0.1)
    s = curve.values[:, 1] / 3.2
    assert np.abs(curve.values[:, 0] - 0.6 * s * s - curve.values[:, 1] * s).max() < 1e-11
    (met,) = curve.meetings  # where the root has no weight at all: lp vanishes as well
    assert met.type == "bcb+lp+pd" and met.values == pytest.approx((0.0, 0.0), abs=1e-12)


def gap_left(state, p):
    return (p.lam * state[0] + p.mu,)


def gap_right(state, p, root):
    return (p.mu - p.l - root,)


COPY = gz.Map(
    pieces={"L": gap_left, "R": gap_right}, border=border, params={"lam": 0.8, "mu": 0.5, "l": 1.0}, box=((-1.0, 1.0),)
)


@pytest.mark.parametrize("values", [{"lam": 0.8, "mu": 0.5, "l": 1.0}, {"lam": 0.6, "mu": 0.05, "l": 0.0}])
def test_a_copy_of_the_gap_map_gives_its_results(values):
    G, C = gz.gap_map(**values), COPY.replace(**values)
    x = np.linspace(-0.9, 0.9, 20)
    assert np.array_equal(G.run(x[None].copy(), 3, 4)[0], C.run(x[None].copy(), 3, 4)[0])
    copies = gz.periodic_orbits(C, range(1, 4), virtual=True, starts=100)
    for orbit in gz.periodic_orbits(G, range(1, 4), virtual=True):
        near = [one for one in copies if one.word == orbit.word and one.period == orbit.period]
        rolled = [np.roll(one.points, k, axis=0) for one in near for k in range(one.period)]
        assert min(np.abs(points - orbit.points).max() for points in rolled) < 1e-12
        assert orbit.admissible in {one.admissible for one in near}
        if orbit.word != "LLR" or not orbit.admissible:
            continue
        twin = next(one for one in near if one.admissible)
        ours, theirs = (gz.continuation(P, o, "mu", (-0.3, 0.9), step=0.1) for P, o in ((G, orbit), (C, twin)))
        # where all points collide at once, rounding tells which one is the first
        lists = [sorted((s.type, s.admissible, round(s.value, 9), s.value) for s in b.special) for b in (ours, theirs)]
        assert [one[:2] for one in lists[0]] == [one[:2] for one in lists[1]]
        assert [one[-1] for one in lists[0]] == pytest.approx([one[-1] for one in lists[1]], abs=1e-12)
        assert [piece.ends for piece in ours.pieces] == [piece.ends for piece in theirs.pieces]
        place = next(i for i, one in enumerate(ours.special) if one.type == "bcb" and one.value > 0.1)
        curves = [
            gz.locus(b.special[place], ("mu", "lam"), ((-0.3, 0.9), (0.1, 0.95)), step=0.1) for b in (ours, theirs)
        ]
        assert curves[0].values == pytest.approx(curves[1].values, abs=1e-12)
        assert [one.type for one in curves[0].meetings] == [one.type for one in curves[1].meetings]
        for one, other in zip(*(curve.meetings for curve in curves), strict=True):
            assert one.values == pytest.approx(other.values, abs=1e-12)


def smooth(state, p):
    return (p.a - state[0] ** 2,)


def beside(state, p):
    return state[0] - p.c


def test_a_border_at_which_a_map_is_smooth_changes_the_word_only():
    P = gz.Map(pieces={"A": smooth, "B": smooth}, border=beside, params={"a": 0.5, "c": 0.2}, box=((-2.0, 2.0),))
    (orbit,) = (one for one in gz.periodic_orbits(P, 1, starts=40) if one.word == "B")
    branch = gz.continuation(P, orbit, "a", (-0.5, 1.0))
    assert {one.type: one.value for one in branch.special} == pytest.approx({"pd": 0.75, "lp": -0.25}, abs=1e-12)
    (crossed,) = branch.relabellings
    assert crossed.value == pytest.approx(0.24, abs=1e-12) and (crossed.before, crossed.after) == ("B", "A")
    assert not any(orbit.depth > 1e-12 for orbit in branch)
    assert len(gz.continuation(P, orbit, "c", (-0.5, 1.0)).relabellings) == 1


def test_three_pieces_have_two_borders():
    """The piece B, x -> 0.7 x + mu - 0.5, has x = (mu - 0.5)/0.3 in [0, 1)."""
    P = THREE.replace(mu=0.6)
    orbit = next(one for one in gz.periodic_orbits(P, 1, starts=40) if one.word == "B")
    branch = gz.continuation(P, orbit, "mu", (0.3, 1.0))
    assert found(branch) == [("bcb", pytest.approx(0.5, abs=1e-12)), ("bcb", pytest.approx(0.8, abs=1e-12))]
    (virtual,) = branch.at(0.95)
    assert virtual.depth == pytest.approx(0.5, abs=1e-12)


def test_a_branch_of_pieces_is_copied_with_its_orbits():
    (orbit,) = gz.periodic_orbits(LINES, word="LR", starts=40)
    branch = gz.continuation(LINES, orbit, "mu", (0.0, 0.4), step=0.2)
    again = pickle.loads(pickle.dumps(branch))
    assert again == branch and again.at(0.2)[0] == branch.at(0.2)[0]


def test_an_orbit_at_the_border_begins_a_branch():
    G = gz.gap_map(lam=0.5, mu=0.1, l=0.1)
    orbit = gz.periodic_orbits(G, 1)[0]
    assert orbit.points[0, 0] == 0.0
    assert found(gz.continuation(G, orbit, "mu", (-0.3, 0.9), step=0.1)) == [
        ("bcb", pytest.approx(0.1, abs=1e-15)), ("pd", pytest.approx(0.85, abs=1e-12)),
    ]  # fmt: skip


@pytest.mark.parametrize("unit", [1.0, 2.0**-20, 2.0**20])
@pytest.mark.parametrize(
    ("word", "a", "b", "mu", "l"),
    [("R", -0.5, 1.75, 0.515625, 0.75), ("L", 1.125, -1.25, -0.109375, 1.375), ("LR", 1.25, -0.25, -1.484375, 1.25)],
)
def test_an_orbit_is_found_where_all_others_run_away(word, a, b, mu, l, unit):
    """They had not left the numbers after 250 steps, and guesses were drawn from where they were: 1e60 boxes away."""
    values = {"a": a, "b": b, "mu": mu * unit, "l": l * unit}
    P = gz.Map(pieces=LINES.pieces, border=border, params=values, box=((-2.0 * unit, 2.0 * unit),))
    slope, shift = Fraction(1), Fraction(0)
    for letter in word:
        s, c = (a, mu) if letter == "L" else (b, mu + l)
        slope, shift = Fraction(s) * slope, Fraction(s) * shift + Fraction(c)
    (orbit,) = gz.periodic_orbits(P, word=word)
    assert not orbit.admissible and orbit.multipliers[0] == pytest.approx(float(slope), rel=1e-8)
    assert np.abs(orbit.points[:, 0] / unit - float(shift / (1 - slope))).min() < 1e-12


@pytest.mark.parametrize("kind", ["step", "pieces"])
@pytest.mark.parametrize("multiplier", [-1.0, 1.0, -0.99999, 1.0001])
@pytest.mark.parametrize("place", [0.3, 1000.0, -1e6])
def test_multipliers_from_differences_decide_no_more_than_they_know(kind, multiplier, place):
    # far from 0 a difference knows fewer digits than rounding: -1 came out as stable or unstable by luck
    def smooth(state, p):
        z = state[0] - p.place
        return (p.place + p.m * z + 0.7 * z * z + z**3,)

    params = {"place": place, "m": multiplier}
    box = ((place - 1.0, place + 1.0),)
    if kind == "step":
        P = gz.Map(smooth, params=params, box=box)
        orbit = MapEquations(P, (), (0,)).orbit(np.array([place]), np.empty(0))
    else:
        other, border = lambda state, p: (p.place + 1e-9,), lambda state, p: state[0] - p.place - 0.3
        P = gz.Map(pieces={"L": smooth, "R": other}, border=border, params=params, box=box)
        orbit = PieceEquations(P, (), (0,)).orbit(np.array([place]), np.empty(0))
    assert abs(orbit.multipliers[0] - multiplier) <= max(orbit.doubt, 1e-12)
    if abs(multiplier) == 1.0:
        assert orbit.neutral and not orbit.stable
    else:
        assert not orbit.neutral and orbit.stable == (abs(multiplier) < 1.0)


def test_an_orbit_at_its_period_doubling_is_neutral_whatever_its_points_last_digits():
    # the orbit of period 2 that begins there is known to half of its digits: its multiplier 1 came out below by 7e-11
    P = gz.Map(lambda s, p: (p.a * s[0] * (1.0 - s[0]),), params={"a": 3.0}, box=((0.0, 1.0),))
    for orbit in gz.periodic_orbits(P, period=[1, 2]):
        assert orbit.neutral == (abs(orbit.points[0, 0] - 2.0 / 3.0) < 1e-3) and not orbit.stable
