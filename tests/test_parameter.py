"""One name for a number of several walls: r, where each has its own A.r and B.r."""

import json
import pickle
from fractions import Fraction

import numpy as np
import pytest

import grazing as gz
from grazing.config import checked, command_of, plan_of, recipe_of, result_of
from grazing.parameter import checked_box, foreign, named_by, parameter_tuple, spread, value_of

LAW = gz.newton(0.6)


def rattle(**more):
    walls = (gz.wall(-1.0, LAW), gz.wall(1.0, more.pop("upper", LAW)))
    force = gz.Forcing(omega=1, cos=(), sin=(0.9,))
    return gz.Oscillator(alpha=0.1, k=0, forcing=force, walls=walls).replace(**more)


@pytest.mark.parametrize("names", [("r",), ("A.r", "B.r", "k"), ()])
def test_parameters_come_back_from_a_file_as_the_same_type(names):
    """A kernel from the disk has been compiled for a type that it brings along: another one of these names is none."""
    kind = parameter_tuple(names)
    assert pickle.loads(pickle.dumps(kind)) is kind


def test_a_name_stands_for_what_walls_share_and_never_for_their_places():
    names = [*rattle(upper=gz.active(0.6, 0.1)).params]
    assert named_by("r", names) == ["A.r", "B.r"] and named_by("V", names) == ["B.V"]
    assert named_by("alpha", names) == ["alpha"] and named_by("A.r", names) == ["A.r"]
    for none in ("sigma", "cos2", "q", "C.r", "", None, 3):
        assert named_by(none, names) == []
    assert spread({"r": 0.5, "k": 1.0}, names, "it") == {"A.r": 0.5, "B.r": 0.5, "k": 1.0}
    for twice in ({"r": 0.5, "A.r": 0.6}, {"A.r": 0.6, "r": 0.5}):
        with pytest.raises(gz.InputError, match=r"r stands for A\.r, too, which is given beside it"):
            spread(twice, names, "it")


def test_models_and_maps_take_one_value_for_all_walls():
    one = rattle(r=0.7)
    assert dict(one.params) == dict(rattle(**{"A.r": 0.7, "B.r": 0.7}).params)
    P = gz.stroboscopic_map(rattle()).replace(r=0.7)
    assert dict(P.params) == dict(gz.stroboscopic_map(one).params)
    with pytest.raises(gz.InputError, match=r"A\.r = 1\.5; allowed is 0 <= A\.r <= 1"):
        rattle(r=1.5)
    with pytest.raises(gz.InputError, match=r"unknown parameter 'sigma' of the model\. Did you mean 'B\.sigma'"):
        rattle(sigma=0.0)


def test_a_study_of_both_is_at_each_value_the_study_there():
    P, values = gz.stroboscopic_map(rattle()), [0.5, 0.6, 0.75]
    starts = [[0.1, 0.2], [-0.3, 0.4]]
    found = gz.orbit_diagram(P, "r", values, starts=starts, arithmetic="strict")
    for value in values:
        alone = gz.orbit_diagram(P.replace(r=value), "sin1", [0.9], starts=starts, arithmetic="strict")
        np.testing.assert_array_equal(found.u.sel(r=value).values, alone.u.values[0])
    assert "A.r" not in json.loads(found.attrs["grazing_config"])["params"]
    chart = gz.chart(P, {"r": values, "sin1": [0.8, 0.9]}, starts=2)
    assert chart.period.dims[:2] == ("r", "sin1")
    with pytest.raises(gz.InputError, match=r"r and A\.r stand for one parameter, A\.r"):
        gz.chart(P, {"r": values, "A.r": values}, starts=2)


def test_branches_follow_both():
    P = gz.stroboscopic_map(rattle(sin1=0.7))
    (orbit,) = gz.periodic_orbits(P, word="(BA)", starts=20)
    branch = gz.continuation(P, orbit, "r", (0.4, 0.8))
    (there,) = branch.at(0.7)
    (own,) = gz.periodic_orbits(P.replace(r=0.7), word="(BA)", starts=20)
    assert there.map.params["A.r"] == there.map.params["B.r"] == 0.7
    np.testing.assert_allclose(there.points, own.points, atol=1e-12)
    assert gz.bifurcation_diagram(P, "r", [0.5, 0.6], starts=2, period=1).window_high.values.tolist() == [0.6]
    apart = P.replace(**{"A.r": 0.5})
    (other,) = gz.periodic_orbits(apart, word="(BA)", starts=20)
    with pytest.raises(gz.InputError, match=r"r stands for A\.r = 0\.5 and B\.r = 0\.6; begin where they are equal"):
        gz.continuation(apart, other, "r", (0.4, 0.8))
    assert value_of("r", P.params) == 0.6


def test_loci_and_windows_are_in_both_and_an_enclosure_is_of_one():
    shake, still = gz.Forcing(omega=1.0, sin=(1.0,), cos=()), gz.Forcing(omega=1.0, cos=())
    walls = [gz.wall(place, gz.newton(0.5), motion=shake) for place in (-1.35, 1.35)]
    P = gz.stroboscopic_map(gz.Oscillator(alpha=0, k=0, forcing=still, walls=walls))
    (orbit,) = (one for one in gz.periodic_orbits(P, word="(BA)", starts=20) if one.stable)
    (special,) = (one for one in gz.continuation(P, orbit, "r", (0.4, 0.8)).special if one.type == "bp")

    def room(r):  # between walls, where the symmetry of the orbit to and fro breaks
        return (np.pi**2 / 2 - 2) * np.sin(np.arctan(2 * (1 + r) / (np.pi * (1 - r))))

    assert abs(room(special.value) - 2.7) < 1e-11
    curve = gz.locus(special, ("r", "sin1"), ((0.4, 0.8), (-0.1, 0.1)))
    for value, one in zip(curve.values, curve.orbits, strict=True):
        assert one.map.params["A.r"] == one.map.params["B.r"] == value[0]
    with pytest.raises(gz.InputError, match=r"r stands for A\.r, too"):
        gz.locus(special, ("r", "A.r"), ((0.4, 0.8), (0.4, 0.8)))

    found = gz.windows(P.walled, "r", 1, (0.4, 0.8), 2, "AB").isel(window=0)
    assert (found.low_type, found.high_type, bool(found.symmetric)) == ("end", "bp", True)
    assert abs(found.high - special.value) < 1e-12
    with pytest.raises(gz.InputError, match=r"^r stands for A\.r and B\.r; an enclosure is of one of them"):
        gz.enclose(special.orbit, "lp", "r")


def test_files_and_the_shell_take_one_value_for_all_walls():
    walls = {"A": "newton", "B": "newton"}
    given = {"alpha": 0.1, "k": 0.5, "omega": 2.0, "cos": [2.0], "A.sigma": -0.5, "B.sigma": 0.5}
    recipe = checked({"study": "diagram", "walls": walls, "parameters": given | {"r": 0.7}, "vary": {"cos1": "1:2:3"}})
    assert (recipe["parameters"]["A.r"], recipe["parameters"]["B.r"]) == (0.7, 0.7)
    config = {"study": "diagram", "walls": walls, "parameters": given, "vary": {"r": "0.2:0.9:4"}}
    plan = plan_of(config)
    assert list(plan.axes) == ["r"] and plan.P.params["B.r"] == 0.2
    assert command_of(config).startswith("grazing diagram r=0.2:0.9:4 --walls A=newton,B=newton")

    result = result_of({**config, "settings": {"starts": 2, "transient": 5, "keep": 4}})
    again = recipe_of(result.attrs)
    assert again["vary"] == {"r": "0.2:0.9:4"} and "A.r" not in again["parameters"]
    with pytest.raises(gz.InputError, match=r"r stands for A\.r, too, which is given beside it"):
        checked({**config, "parameters": given | {"r": 0.7, "A.r": 0.5}, "vary": {"cos1": "1:2:3"}})
    with pytest.raises(gz.InputError, match=r"B\.r: missing"):
        checked({**config, "parameters": given | {"A.r": 0.7}, "vary": {"cos1": "1:2:3"}})


def masked(*values):
    return np.ma.array(values, mask=[0] * (len(values) - 1) + [1])


BALL, G = gz.pinball(d=0.12, V=0.4), gz.gap_map(lam=0.5, mu=0.1, l=0.2)
NORMAL = gz.normal_form(BALL, "d")
WITHOUT_ORDER_OR_MASKED = {
    "state": lambda: gz.stroboscopic_map(BALL)(masked(0.1, 0.2)),
    "start": lambda: gz.trajectory(BALL, masked(0.1, 0.2), until=1.0),
    "ball": lambda: gz.read_table("one_bumper").trajectory(masked(0.3, 4.0, 0.0, 1.0), 0.0, 1.0, 3),
    "values": lambda: gz.orbit_diagram(G, "mu", masked(0.1, 0.2), starts=2, transient=2, keep=2),
    "starts": lambda: gz.orbit_diagram(G, "mu", [0.1], starts=masked(0.1, 0.2)[:, None], transient=2, keep=2),
    "rows": lambda: G.run_columns(masked(0.5, 0.1, 0.2)[None], np.zeros((1, 1, 1)), 0, 2),
    "lanes": lambda: G.run(masked(0.1, 0.2)[None], 0, 2),
    "series": lambda: gz.zero_one(masked(*range(500))),
    "samples": lambda: gz.Forcing.from_samples(masked(1.0, 0.0, -1.0, 0.0), omega=1.0, harmonics=1),
    "mu": lambda: NORMAL.mu(masked(0.1, 0.2)),
    "points": lambda: NORMAL.to_xy(masked(0.1, 0.2)),
    "lam": lambda: gz.theory.mu_pd(3, masked(0.5, 0.9), 0.1),
    "angle": lambda: gz.launches(gz.read_table("one_bumper"), (0.3, 4.0), masked(0.1, 0.2), 1.0),
    "amplitudes": lambda: gz.Forcing(omega=1.0, cos={1.0, 2.0}),
    "place": lambda: gz.disc("a", {0.0, 2.0}, 1.0, law=LAW),
    "shard": lambda: gz.sweep.run(gz.plans.density(G, "mu", [0.1], starts=2), "none.zarr", shard={1, 2}),
    "dates": lambda: gz.orbit_diagram(G, "mu", np.array(["2000"], "M8[D]"), starts=2, transient=2, keep=2),
    "durations": lambda: G(np.array([3], "m8[s]")),
    "complex": lambda: G(np.array([0.5 + 0j])),
}


@pytest.mark.parametrize("call", WITHOUT_ORDER_OR_MASKED.values(), ids=WITHOUT_ORDER_OR_MASKED)
def test_masked_values_sets_and_dates_are_no_lists_of_numbers(call):
    """What a mask hides was computed with, and the numbers of a set became x and y in whatever order it gave them."""
    with pytest.raises(gz.InputError):
        call()


ODD = [[1], {"a": 1}, np.array([0.1, 0.2]), np.array([]), {1, 2}, object(), b"x", 3.5]
RECORDED, FLOWN = gz.sample(gz.trajectory(BALL, (0.1, 0.0), until=5.0), rate=20), gz.trajectory(BALL, (0.1, 0.0))
NO_WORDS = {
    "of": lambda odd: gz.spectrum(RECORDED, of=odd),
    "of a sound": lambda odd: gz.to_wav(FLOWN, "none.wav", of=odd),
    "arithmetic": lambda odd: G.run_columns([[0.5, 0.1, 0.2]], np.zeros((1, 1, 1)), 1, 1, arithmetic=odd),
    "algorithm": lambda odd: G.run_columns([[0.5, 0.1, 0.2]], np.zeros((1, 1, 1)), 1, 1, algorithm=odd),
    "records": lambda odd: G.run_columns([[0.5, 0.1, 0.2]], np.zeros((1, 1, 1)), 1, 1, records=odd),
    "describe": BALL.describe,
    "describe of a map": G.describe,
    "describe of walls": rattle().describe,
    "describe of a table": gz.read_table("one_bumper").describe,
    "unit": BALL.unit_of,
    "changes": lambda odd: BALL.changed({1: 1} if isinstance(odd, dict) else odd),
    "kind": lambda odd: gz.sweep.cluster(odd).__enter__(),
    "prepare": lambda odd: gz.Map(lambda x, p: (x[0] * p.a,), params={"a": 0.5}, prepare=odd),
    "name": lambda odd: gz.Map(lambda x, p: (x[0] * p.a,), params={"a": 0.5}, name=odd),
}


@pytest.mark.parametrize("call", NO_WORDS.values(), ids=NO_WORDS)
def test_what_is_no_word_is_named(call):
    """Lists, arrays and numbers in the place of a word were unhashable, ambiguous or without an attribute."""
    for odd in ODD:
        with pytest.raises(gz.InputError):
            call(odd)


def test_a_letter_that_no_name_has_is_named_and_no_other():
    with pytest.raises(gz.InputError, match=r"'laμ' of gap map \(its 'μ' is U\+03BC, GREEK SMALL LETTER MU\)\. Did"):
        gz.gap_map(lam=0.5, mu=0.1, l=0.2).replace(laμ=0.1)
    assert foreign("xμ", ["μ", "x"]) == foreign("", ["a"]) == foreign("b", ["a"]) == ""
    assert foreign("\x85", ["a"]) == " (its '\\x85' is U+0085, a letter without a name)"


def test_ends_of_a_box_are_numbers_of_any_type():
    """A fraction, which Python before 3.12 cannot format, ended in a TypeError."""
    ((low, high),) = checked_box([(Fraction(1, 4), 1)], ("x",))
    assert (low, high) == (0.25, 1.0) and type(low) is type(high) is float
