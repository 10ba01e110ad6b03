import dataclasses

import numpy as np
import pytest

import grazing as gz
from grazing.orbits.periodic import Orbits, _one_of_each_continuum, periodic_orbits
from grazing.orbits.word import word
from grazing.outcome import InputError
from grazing.studies.classify import classify
from tests.models import MODELS

TEN = (-0.1, -0.02, 0.02, 0.035, 0.05, 0.07, 0.09, 0.105, 0.12, 0.14)


def logistic(state, p):
    (x,) = state
    return (p.a * x * (1.0 - x),)


def henon(state, p):
    x, y = state
    return (1.0 - p.a * x * x + y, p.b * x)


def verify(P, orbit):
    """The map itself goes round the orbit, with the letters of its word, and no sooner."""
    path = P.orbit(orbit.points[0], orbit.period)
    size = np.abs(orbit.points).max() + 1e-3
    growth = 1.0 + abs(orbit.multipliers[0])
    assert orbit.residual < 1e-9
    assert np.abs(path.points[-1] - orbit.points[0]).max() < 1e-11 * size * growth * growth, orbit
    assert word(path.letters, P.letters) == orbit.word, orbit
    for n in range(1, orbit.period):
        if orbit.period % n == 0:
            assert np.abs(orbit.points[n] - orbit.points[0]).max() > 1e-7 * size, orbit


def attractors(P, starts, seed, longest):
    """Points of the periodic attractors that random starts reach, by the classification of the studies."""
    random = np.random.default_rng(seed)
    box = np.array(P.box)
    states = (box[:, :1] + (box[:, 1:] - box[:, :1]) * random.uniform(size=(2, starts)))[None].copy()
    row = P.packed()[1][None]
    found = P.run_columns(row, states, 600, 60)
    said = classify(P, found.points[0], found.letters[0], found.outcomes[0, 0])
    cycles = [(int(n), found.points[0, -1, :, i]) for i, n in enumerate(said.period) if 1 <= n <= longest]
    return cycles, said


def listed(orbits, n, point):
    return any(
        orbit.period == n and np.abs(orbit.points - point).max(axis=1).min() < 1e-6 * (1.0 + np.abs(point).max())
        for orbit in orbits
        if orbit.admissible
    )


def no_attractor_is_missing(P, starts, longest):
    orbits = periodic_orbits(P, range(1, longest + 1))
    for orbit in orbits:
        assert orbit.admissible
        verify(P, orbit)
    cycles, _said = attractors(P, starts, 7, longest)
    distinct = {(n, *np.round(point, 7)): point for n, point in cycles}
    for (n, *_rest), point in distinct.items():
        reached = listed(orbits, n, point) or listed(orbits, n, P.iterate(point, 6000)[-1])
        assert reached, (n, point, orbits)
    assert orbits.searched.attempts > 0
    assert "no proof" in orbits.statement or "others may exist" in orbits.statement
    return orbits, len(distinct)


@pytest.mark.parametrize("d", [0.02, 0.09, 0.12])
def test_the_standard_model_lacks_no_attractor(d):
    _orbits, seen = no_attractor_is_missing(gz.stroboscopic_map(gz.pinball(d=d, V=0.4)), 10_000, 6)
    assert seen > 0


@pytest.mark.long
@pytest.mark.parametrize("V", [0.4, 0.0])
@pytest.mark.parametrize("d", TEN)
def test_the_standard_model_lacks_no_attractor_of_ten_values(d, V):
    no_attractor_is_missing(gz.stroboscopic_map(gz.pinball(d=d, V=V)), 100_000, 6)


@pytest.mark.parametrize("name", ["passive", "under-damped", "critical", "chatter", "stick", "trigger", "elastic"])
def test_other_models_lack_no_attractor(name):
    no_attractor_is_missing(gz.stroboscopic_map(MODELS[name]), 500, 3)


@pytest.mark.long
@pytest.mark.parametrize("name", MODELS)
def test_no_model_lacks_an_attractor(name):
    no_attractor_is_missing(gz.stroboscopic_map(MODELS[name]), 5_000, 4)


@pytest.mark.parametrize("section", ["strobe at another phase", "impact"])
def test_sections_see_the_same_orbits(section):
    m = gz.pinball(d=0.03, V=0.4)
    P = gz.stroboscopic_map(m, phase=0.7) if section != "impact" else gz.impact_map(m)
    orbits = periodic_orbits(P, (1, 2), starts=500)
    known = periodic_orbits(gz.stroboscopic_map(m), (1, 2), starts=500)
    assert len(known) == 2
    for orbit in orbits:
        verify(P, orbit)
    same = [max(abs(np.sort_complex(a.multipliers) - np.sort_complex(b.multipliers))) < 1e-9
            for a in known for b in orbits]  # fmt: skip
    assert sum(same) == 2


def test_the_free_orbit_is_one_without_impacts():
    (orbit,) = periodic_orbits(gz.stroboscopic_map(gz.pinball(d=0.3)), 1, starts=50)
    assert orbit.word == "0" and orbit.impacts == 0 and orbit.stable


@pytest.mark.parametrize(("r", "spelled"), [(0.3, "C"), (0.0, "1")])
def test_orbits_that_rest_are_superstable(r, spelled):
    P = gz.stroboscopic_map(gz.pinball(V=0.0, r=r, d=-0.2))
    (orbit,) = [one for one in periodic_orbits(P, 1, starts=50) if not one.multipliers.any()]
    assert orbit.word == spelled and orbit.stable and orbit.admissible
    assert np.array_equal(P(orbit.points[0])[0], orbit.points[0])


def test_a_ball_that_is_always_pressed_rests_for_ever():
    P = gz.stroboscopic_map(gz.pinball(V=0.0, r=0.3, d=-2.0, sigma=0.0))
    (orbit,) = periodic_orbits(P, 1, starts=50)
    assert orbit.word == "S" and orbit.points.tolist() == [[0.0, 0.0]]


def test_all_cycles_of_the_logistic_map_are_found():
    P = gz.Map(logistic, params={"a": 4.0}, coordinates=("x",), box=((0.0, 1.0),))
    orbits = periodic_orbits(P, range(1, 8), starts=1000)
    count = [sum(orbit.period == n for orbit in orbits) for n in range(1, 8)]
    assert count == [2, 1, 2, 3, 6, 9, 18]  # necklaces of two letters without a shorter period
    inner = [orbit for orbit in orbits if orbit.points.max() > 1e-6]  # conjugate to the tent map, of slope 2
    assert len(inner) == len(orbits) - 1
    assert all(abs(orbit.multipliers[0]) == pytest.approx(2.0**orbit.period, rel=1e-6) for orbit in inner)


@pytest.mark.parametrize("a", [0.9, 1.1, 2.5])
def test_an_orbit_that_repels_is_found_where_no_orbit_stays(a):
    P = gz.Map(logistic, params={"a": a}, coordinates=("x",), box=((-2.0, 2.0),))
    found = sorted(float(orbit.points[0, 0]) for orbit in periodic_orbits(P, 1, starts=10))
    assert found == pytest.approx(sorted([0.0, (a - 1.0) / a]), abs=1e-12)


def test_all_cycles_of_the_henon_map_are_found():
    # Biham and Wenzel, Phys. Rev. Lett. 63 (1989) 819: numbers of orbits of a = 1.4, b = 0.3
    P = gz.Map(henon, params={"a": 1.4, "b": 0.3}, coordinates=("x", "y"), box=((-1.5, 1.5), (-0.4, 0.4)))
    orbits = periodic_orbits(P, range(1, 9))
    assert [sum(orbit.period == n for orbit in orbits) for n in range(1, 9)] == [2, 1, 0, 1, 0, 2, 4, 7]


def test_the_gap_map_is_solved_by_algebra():
    orbits = periodic_orbits(gz.gap_map(lam=0.8, mu=0.5, l=1.0), range(1, 7), virtual=True)
    assert orbits.searched.complete and "by algebra" in orbits.statement
    assert [orbit.word for orbit in orbits if orbit.stable and orbit.admissible] == ["LLR"]
    assert orbits.searched.virtual == sum(not orbit.admissible for orbit in orbits) > 0


def test_virtual_orbits_only_on_request():
    P = gz.stroboscopic_map(gz.pinball(d=0.09, V=0.4))
    some, every = (periodic_orbits(P, (2, 3), virtual=virtual, starts=300) for virtual in (False, True))
    assert all(orbit.admissible for orbit in some)
    assert [repr(orbit) for orbit in some] == [repr(orbit) for orbit in every if orbit.admissible]
    assert len(every) - len(some) == every.searched.virtual > 0


def test_a_word_is_looked_for_and_virtual_where_it_is_not_admissible():
    m = gz.pinball(d=0.12, V=0.4)
    (orbit,) = periodic_orbits(gz.stroboscopic_map(m), word="100", starts=300)
    assert orbit.word == "001" and orbit.admissible
    other = periodic_orbits(gz.stroboscopic_map(gz.pinball(d=0.08, V=0.4)), word="001", starts=300)
    assert other and not any(orbit.admissible for orbit in other)
    assert "of word 001" in other.statement and "virtual" in other.statement


def test_the_list_depends_on_the_seed_alone():
    P = gz.stroboscopic_map(gz.pinball(d=0.03, V=0.4))
    one, other = (periodic_orbits(P, (1, 2, 3), starts=300, seed=3, threads=n, virtual=True) for n in (1, 3))
    assert one.searched == other.searched
    assert all(np.array_equal(a.points, b.points) for a, b in zip(one, other, strict=True))


def test_a_list_of_orbits_is_a_tuple_that_says_what_was_done():
    orbits = periodic_orbits(gz.gap_map(lam=0.8, mu=0.5, l=1.0), 3)
    assert isinstance(orbits, Orbits) and isinstance(orbits, tuple)
    assert orbits.statement in repr(orbits)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"period": 0}, "whole number >= 1"),
        ({"period": -2}, "whole number >= 1"),
        ({"period": 1.5}, "whole number >= 1"),
        ({"period": ()}, "empty list"),
        ({}, "period is missing"),
        ({"period": 1000}, "gz.continuation"),
        ({"period": 1, "starts": 0}, "starts"),
        ({"period": 1, "seed": -1}, "seed"),
        ({"word": "0x"}, "at position 1"),
        ({"word": 3}, "give a text"),
        ({"word": "001", "period": 4}, "multiples"),
        ({"word": "0C"}, "never rests"),
        ({"word": "S"}, "never rests"),
        ({"word": "09"}, "holds at most"),
        ({"period": 1, "virtual": np.array([])}, "give True or False"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_a_reason(asked, said):
    with pytest.raises(InputError, match=said):
        periodic_orbits(gz.stroboscopic_map(gz.pinball(d=0.12, V=0.4)), **asked)


@pytest.mark.parametrize(
    ("P", "spelled", "said"),
    [
        (gz.stroboscopic_map(gz.pinball(V=0.0, r=0.5)), "0S", "come to rest before"),
        (gz.stroboscopic_map(gz.pinball(V=0.0, r=1.0)), "C", "not known to contract"),
        (gz.impact_map(gz.pinball()), "00", "at least one is positive"),
        (gz.impact_map(gz.pinball()), "C", "none is C or S"),
        (gz.gap_map(lam=0.8, mu=0.5, l=1.0), "LX", "allowed are L, R"),
        ("a map", "L", "give a map"),
    ],
)
def test_words_that_a_map_cannot_have(P, spelled, said):
    with pytest.raises(InputError, match=said):
        periodic_orbits(P, word=spelled)


def test_an_empty_list_says_what_was_tried_and_what_to_try():
    orbits = periodic_orbits(gz.stroboscopic_map(gz.pinball(d=0.3)), 2, starts=50)
    assert len(orbits) == 0
    assert "Newton attempts" in orbits.statement and "more starts" in orbits.statement


def test_the_doubled_orbit_beside_a_subcritical_period_doubling_is_found():
    # the closed form puts the period doubling of 001 at d = 0.12328145; the unstable doubled orbit lies below it
    P = gz.stroboscopic_map(gz.pinball(d=0.1232, V=0.4))
    (orbit,) = periodic_orbits(P, 6, word="001", starts=200)
    assert orbit.period == 6 and orbit.word == "001" and orbit.admissible and not orbit.stable
    verify(P, orbit)
    (beyond,) = periodic_orbits(gz.stroboscopic_map(gz.pinball(d=0.1234, V=0.4)), (3, 6), word="001", starts=200)
    assert beyond.period == 3 and not beyond.stable


def test_more_starts_find_no_more():
    P = gz.stroboscopic_map(gz.pinball(d=0.1232, V=0.4))
    few, many = (periodic_orbits(P, range(1, 7), starts=n, seed=n) for n in (200, 4000))
    assert [orbit.word for orbit in few] == [orbit.word for orbit in many] and len(few) > 1


def test_a_word_of_many_impacts_costs_bounded_work_and_says_so():
    P = gz.stroboscopic_map(gz.pinball(V=0.0))
    found = gz.periodic_orbits(P, word="0(60)", starts=50)
    assert found.searched.attempts < 4000
    assert " random guesses of the word instead of 4000" in found.statement
    assert "random guesses" not in gz.periodic_orbits(P, word="01", starts=50).statement
    with pytest.raises(gz.InputError, match=r"have 999 impacts; allowed are 200.*letter C"):
        gz.periodic_orbits(P, word="0(999)")


def test_of_a_trigger_no_orbit_has_its_pieces_in_another_order_than_its_impacts():
    force = gz.Forcing(omega=0.9, offset=-0.3, cos=(1.0,))
    m = gz.Oscillator(alpha=0.1, k=1.0, forcing=force, reset=gz.triggered(0.6, 0.4, 0.5), sigma=-0.2)
    found = gz.periodic_orbits(gz.stroboscopic_map(m), [1, 2], starts=200, virtual=True)
    assert len(found) > 50 and max(orbit.residual for orbit in found) < 1e-9


def test_a_ball_that_falls_for_ever_has_no_orbit_without_impacts():
    # exp(-B T) has the multiplier 1 but for rounding: the orbit would lie 1e16 deep in the wall
    m = gz.Oscillator(alpha=0.1, k=0, forcing=gz.Forcing(omega=1.0, offset=-1.0, cos=(2.0,)), reset=gz.newton(0.8))
    assert all(orbit.impacts for orbit in gz.periodic_orbits(gz.stroboscopic_map(m), 1, starts=50))


def test_a_continuum_of_orbits_is_listed_once_and_neutral():
    """Without a spring the ball flies between two walls wherever it likes: multipliers 1 and exp(-alpha T)."""
    walls = (gz.wall(-1.0, gz.newton(0.6)), gz.wall(1.0, gz.newton(0.6)))
    rattle = gz.Oscillator(alpha=0.1, k=0.0, forcing=gz.Forcing(omega=1.0, cos=(), sin=(0.3,)), walls=walls)
    found = gz.periodic_orbits(gz.stroboscopic_map(rattle), 1, starts=40)
    (free,) = (orbit for orbit in found if orbit.word == "0")
    assert free.neutral and not free.stable and "neutral" in repr(free)
    assert abs(free.multipliers) == pytest.approx([1.0, np.exp(-0.1 * rattle.period)], abs=1e-12)
    assert 0.5 < free.clearance < 1.0 and ", 1 neutral and " in found.statement
    assert "(of word 0 and period 1 a continuum: the one in the middle is listed)" in found.statement
    with pytest.raises(gz.InputError, match=r"is one of a continuum at sin1 = 0\.3: a multiplier is 1, and no branch"):
        gz.continuation(found.map, free, "sin1", (0.2, 0.4))
    (above,) = gz.periodic_orbits(
        gz.stroboscopic_map(gz.Oscillator(0.1, 0, rattle.forcing, gz.newton(0.6))), 1, starts=40
    )
    assert above.neutral and above.impacts == 0 and above.clearance > 0.0


def test_what_a_search_meets_of_a_continuum_is_listed_once():
    force = gz.Forcing(omega=1.0, cos=(), sin=(0.3,))
    (free,) = gz.periodic_orbits(gz.stroboscopic_map(gz.Oscillator(0.1, 0, force, gz.newton(0.6))), 1, starts=40)
    one, *others = (dataclasses.replace(free, word="1", points=free.points + up) for up in (0.0, 0.1, 0.2))
    assert _one_of_each_continuum([one, *others]) == ([one], (("1", 1, 3),))
    assert _one_of_each_continuum([one, others[0]]) == ([one, others[0]], ())  # as many as meet at a fold
    assert _one_of_each_continuum([free]) == ([free], (("0", 1, 1),))  # a flight is linear: there is no fold


def test_a_search_names_orbits_that_differ_from_the_word_by_the_strobe_alone():
    # it said that there is none of (AB), and not that (BA) is the same impacts
    walls = [gz.wall(-0.3, gz.newton(0.7)), gz.wall(0.5, gz.newton(0.8))]
    push = gz.Forcing(2.4, offset=-0.138, cos=(1.0,))
    P = gz.stroboscopic_map(gz.Oscillator(alpha=0.1, k=1.0, forcing=push, walls=walls))
    there, none = (gz.periodic_orbits(P, word=word, starts=30, threads=1) for word in ("(BA)", "(AB)"))
    assert {one.word for one in there} == {"(BA)"} and len(none) == 0
    assert there.searched.turned == () and none.searched.turned == ("(BA)",)
    assert "another one first after the strobe: (BA)" in none.statement
    rest = gz.periodic_orbits(P, word="(CA)", starts=30, threads=1)
    assert rest.searched.turned == ()


def test_orbits_far_beyond_their_box_are_listed_without_a_warning():
    found = gz.periodic_orbits(gz.gap_map(lam=1e-300, mu=1e300, l=0.0), word="LR", virtual=True)
    assert [orbit.word for orbit in found] == ["LR"]


def test_a_derivative_whose_square_is_beyond_all_doubles_is_not_warned_of():
    P = gz.Map(lambda x, p: (x[0] * p.a,), params={"a": 1e200}, box=((-1.0, 1.0),))
    assert [orbit.stable for orbit in gz.periodic_orbits(P, 1, starts=10)] == [False]
