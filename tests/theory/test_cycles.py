"""Cycle expansions where the escape rate is known in closed form, of tables, and of what is no list of cycles."""

from decimal import Decimal
from itertools import pairwise, product
from math import log, prod

import numpy as np
import pytest
from scipy.optimize import brentq

import grazing as gz
from grazing.theory import Cycle, cycle_expansion, three_disc_cycles
from grazing.theory.three_discs import primitive_words
from tests.billiard.orbits import active_discs
from tests.billiard.tables import three_discs

SLOPES, TIMES = (3.0, -4.0), (1.0, 1.5)


def linear(length, contraction=None):
    """The cycles of two linear branches that cover all, with these slopes and times; and what contracts beside them."""
    for n in range(1, length + 1):
        for word in primitive_words(n):
            roots = [prod(SLOPES[k] for k in word), *([contraction**n] if contraction else [])]
            yield Cycle(n, sum(TIMES[k] for k in word), tuple(roots))


@pytest.mark.parametrize("contracting", [True, False])
def test_two_linear_branches_let_go_of_what_their_slopes_say(contracting):
    """Of a unit length 1/3 + 1/4 stays an impact; in time the rate solves e^s/3 + e^(1.5 s)/4 = 1."""
    found = cycle_expansion(linear(9, 0.2), per="impact", contracting=contracting)
    assert abs(found.escape_rate + log(1 / 3 + 1 / 4)) < found.error + 1e-14 < 1e-7
    rate = brentq(lambda s: np.exp(s) / 3 + np.exp(1.5 * s) / 4 - 1, 0, 2, xtol=1e-15)
    found = cycle_expansion(linear(9))
    assert abs(found.escape_rate - rate) < found.error + 1e-14 < 1e-8 and found.estimates[-1] == found.value


def test_what_contracts_slowly_needs_longer_words_unless_it_is_left_away():
    exact = -log(1 / 3 + 1 / 4)
    errors = [cycle_expansion(linear(7, c), per="impact").escape_rate - exact for c in (0.1, 0.5)]
    assert abs(errors[0]) < 1e-6 < abs(errors[1])
    left_away = cycle_expansion(linear(7, 0.5), per="impact", contracting=False)
    assert left_away.escape_rate == pytest.approx(exact, abs=1e-9)


def test_a_closed_system_has_rate_zero_and_one_with_gain_a_negative_one():
    """Slopes 2 and 2 leave nothing out."""
    cycles = [Cycle(n, 1.0 * n, (2.0**n,)) for n in range(1, 9) for _word in primitive_words(n)]
    found = cycle_expansion(cycles)
    assert abs(found.escape_rate) < found.error < 1e-5
    double = [one._replace(transverse=(1.5**one.period,)) for one in cycles]
    assert cycle_expansion(double).escape_rate == pytest.approx(-log(2 / 1.5), abs=1e-3)


def test_the_rate_of_three_discs_has_thirty_digits():
    """0.4103384077693464893384613078192, and each length brings more digits than the one before."""
    found = cycle_expansion(three_disc_cycles(6.0, 11, digits=40), digits=40)
    assert str(found.value)[:33] == "0.4103384077693464893384613078192"
    changes = [abs(b - a) for a, b in pairwise(found.estimates)]
    assert all(b < a / 40 for a, b in pairwise(changes)) and found.error < 1e-27


def test_the_rate_of_three_discs_at_three_radii_is_confirmed_by_length():
    found = cycle_expansion(three_disc_cycles(3.0, 10, digits=20), digits=20)
    assert found.value == pytest.approx(Decimal("0.67792268959953"), abs=Decimal("1e-14"))
    assert found.estimates[-2] == pytest.approx(found.value, abs=Decimal("1e-13"))


@pytest.mark.parametrize(
    ("slopes", "c", "length"),
    [((-6.5, 2.4), -0.68, 6), ((-5.97, -7.14), 0.84, 8), ((6.38, -8.4), -0.83, 9), ((5.95, -8.16), -0.64, 9)],
)
def test_a_last_change_that_is_small_by_chance_is_no_error(slopes, c, length):
    """Where slopes have two signs, or a length had no zero: the last change was up to twelve times too small."""
    words = [w for n in range(1, length + 1) for w in primitive_words(n)]
    cycles = [Cycle(len(w), 1.0, (prod(slopes[k] for k in w), c ** len(w))) for w in words]
    found = cycle_expansion(cycles, per="impact")
    assert abs(found.escape_rate + log(sum(1 / abs(slope) for slope in slopes))) < found.error


@pytest.mark.parametrize("longest", [7, 8])
def test_two_discs_have_one_cycle_and_the_series_goes_as_far_as_it_was_looked_for_others(longest):
    """What stays follows one orbit, of multiplier (2 + sqrt(3))^2: it was cut off at its first turn."""
    P = gz.collision_map(gz.table([gz.disc(name, (x, 0.0), 1.0, gz.newton(1.0)) for name, x in (("A", 0), ("B", 3))]))
    found = cycle_expansion(gz.periodic_orbits(P, range(1, longest + 1), starts=40), per="impact")
    assert found.cycles == 1 and len(found.estimates) == longest
    assert abs(found.escape_rate - log(2.0 + 3.0**0.5)) < found.error < 0.01


def test_orbits_of_the_table_give_the_rate_of_their_sixth():
    """All words to length 7 in the whole plane, solved in doubles."""
    orbits = gz.periodic_orbits(gz.collision_map(three_discs(6.0)), range(1, 8))
    found = cycle_expansion(orbits)
    assert found.cycles == 41 and found.escape_rate == pytest.approx(0.41033840776935, abs=3e-7)
    assert abs(found.escape_rate - 0.41033840776935) < found.error


def test_balls_leave_three_discs_as_the_cycles_say():
    """Monte Carlo, impacts 3 to 7, within three standard errors; the rate counts impacts."""
    P, n = gz.collision_map(three_discs(3.0)), 1_000_000
    random = np.random.default_rng(1)
    lanes = np.array([random.uniform(0, 2 * np.pi, n), np.arcsin(random.uniform(-1, 1, n)), np.ones(n)])
    left = (P.run(lanes, 0, 7)[1] < 3).sum(axis=1)[2:]
    steps = len(left) - 1
    rate, error = np.log(left[0] / left[-1]) / steps, np.sqrt(1.0 / left[-1] - 1.0 / left[0]) / steps
    exact = cycle_expansion(three_disc_cycles(3.0, 9), per="impact")
    assert exact.error < 1e-6 and abs(rate - exact.escape_rate) < 3.0 * error < 0.02


def test_active_discs_keep_more_balls_once_they_have_their_speed():
    """0.770 +- 0.004 an impact at r = 0.8 for every V > 0, and a rate in time that grows as V does."""
    orbits = gz.periodic_orbits(gz.collision_map(active_discs(3.0)), range(1, 8), starts=60)
    found = cycle_expansion(orbits, per="impact", contracting=False)
    assert found.cycles == 41 and found.escape_rate == pytest.approx(0.770, abs=0.004) and found.error < 0.02
    slow = cycle_expansion(orbits, contracting=False)
    double = gz.periodic_orbits(gz.collision_map(active_discs(3.0, V=0.5)), range(1, 8), starts=60)
    fast = cycle_expansion(double, contracting=False)
    assert fast.escape_rate == pytest.approx(2.0 * slow.escape_rate, rel=1e-10)
    again = cycle_expansion(double, per="impact", contracting=False)
    assert again.escape_rate == pytest.approx(found.escape_rate, rel=1e-10)


@pytest.mark.parametrize(
    ("cycles", "said"),
    [
        ([], "there are no cycles"),
        ([1.0], "give Cycle"),
        ([Cycle(0, 1.0, (2.0,))], "period of a cycle is 0"),
        ([Cycle(1, 0.0, (2.0,))], "time of a cycle is 0"),
        ([Cycle(1, 1.0, (float("nan"),))], "multipliers of a cycle"),
        ([Cycle(1, 1.0, (1.0,))], "it is not hyperbolic"),
        ([Cycle(2, 1.0, (9.0,)), Cycle(2, 1.0, (-9.0,))], None),
    ],
)
def test_what_is_no_list_of_cycles_is_refused(cycles, said):
    if said is None:  # of period 2 only: nothing is known of period 1, and the series has a zero all the same
        assert cycle_expansion(cycles).estimates[0] is None
        return
    with pytest.raises(gz.InputError, match=said):
        cycle_expansion(cycles)


def test_options_that_are_none_are_refused():
    for options in ({"per": "hour"}, {"digits": 3}, {"digits": 20.0}, {"contracting": "no"}):
        with pytest.raises(gz.InputError, match=next(iter(options))):
            cycle_expansion(linear(3), **options)


def test_a_word_is_spelled_once():
    for n, many in ((1, 2), (2, 1), (3, 2), (4, 3), (5, 6), (6, 9)):
        words = list(primitive_words(n))
        every = {w[k:] + w[:k] for w in words for k in range(n)}
        assert len(words) == many and len(every) == n * many
        whole = sum(1 for w in product((0, 1), repeat=n) if not any(w == w[k:] + w[:k] for k in range(1, n)))
        assert len(every) == whole


def test_no_rate_is_greater_than_that_of_the_slowest_cycle():
    # cut at so few impacts the series of nearly touching discs has a zero far above, which was given as the rate
    cycles = three_disc_cycles(2.05, 6)
    with pytest.raises(gz.InputError, match="has no zero"):
        cycle_expansion(cycles)


def test_discs_far_apart_have_a_rate_beyond_many_mean_times():
    found = cycle_expansion(three_disc_cycles(1e12, 4))
    # a disc lets all but about one in 1e12 go: the rate is some 27 a flight, and the search ended at 20
    assert 0.0 < found.escape_rate * 1e12 < 30.0 and found.error < 1e-3 * found.escape_rate


def test_multipliers_whose_powers_are_no_doubles_count():
    cycles = [Cycle(1, 1.0, (1e40,)), Cycle(10, 10.0, (1e300,))]
    assert cycle_expansion(cycles).escape_rate == pytest.approx(69.0775527898)  # 30 ln 10 in a time
    with pytest.raises(gz.InputError, match="their powers are no doubles"):
        cycle_expansion([Cycle(1, 1.0, (1e200 + 1e200j, 1e200 - 1e200j)), Cycle(3, 3.0, (5.0,))])
    with pytest.raises(gz.InputError, match="cycles are 3"):
        cycle_expansion(3)


def test_virtual_orbits_are_refused():
    """Of three discs in a row, the way from the first one to the last one through that between: no ball goes there."""
    discs = [gz.disc(name, (x, 0.0), 1.0, gz.newton(1.0)) for name, x in (("A", 0.0), ("B", 3.0), ("C", 6.5))]
    orbits = gz.periodic_orbits(gz.collision_map(gz.table(discs)), [1, 2], starts=40, virtual=True)
    assert not all(one.admissible for one in orbits)
    with pytest.raises(gz.InputError, match="is virtual"):
        cycle_expansion(orbits)
