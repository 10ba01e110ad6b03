"""What the checker demands of an orbit on a table, one thing after the other: each is refused where it fails."""

from copy import deepcopy

import numpy as np
import pytest
from flint import arb

import grazing as gz
from grazing_checker import Rejected, check
from grazing_checker.balls import number, precision
from grazing_checker.plane import Apart, Flight, Reader, Thing, factored, over, value
from grazing_checker.reading import exact
from grazing_checker.table import Table, margins, sums_of
from tests.billiard.orbits import bowl
from tests.grazing_checker.bases import TABLE_NAMES, table_bases
from tests.grazing_checker.forgeries import fit, fitting_matrix, newton, sealed, text_of

KIND = "periodic orbit on a table"


def changed(name, change, again=False):
    """Return a certificate whose data a forger has changed, and made all else fit, as far as the checker lets him."""
    base = table_bases()[name]
    data = deepcopy(base["data"])
    change(data)
    if again:
        with precision(256):
            newton(data)
        fitting_matrix(None, data, [])
    fit(data)
    return sealed(KIND, data, base["inequalities"])


def refused(name, change, said, again=False):
    with pytest.raises(Rejected, match=said):
        check(changed(name, change, again))


def shape(i, **numbers):
    def change(data):
        data["objects"][i]["shape"] |= {name: float(x).hex() for name, x in numbers.items()}

    return change


def more(kind, **numbers):
    def change(data):
        one = {"name": "new", "kind": kind, "shape": {name: float(x).hex() for name, x in numbers.items()}}
        data["objects"].append(one | ({} if kind == "drain" else {"law": data["objects"][0]["law"]}))

    return change


@pytest.mark.parametrize("name", TABLE_NAMES)
def test_half_widths_are_positive_and_smaller_than_those_of_uniqueness(name):
    """|C F(m)| + |I - C D| r < r holds for r < 0 where |I - C D| is large, whatever F(m) is."""
    base = table_bases()[name]["data"]
    r, u, size = base["radius"], base["unique"], len(base["radius"])
    negative = [f"-{text}" for text in r]
    for one, two in ((negative, u), (negative, [f"-{text}" for text in u]), (["0x0p0"] * size, u), (r, r), (u, r)):
        refused(name, lambda data, one=one, two=two: data.update(radius=one, unique=two), "one inside the other")
    for i in range(size):
        refused(name, lambda data, i=i: data["radius"].__setitem__(i, "0x0p0"), "one inside the other")


@pytest.mark.parametrize("name", TABLE_NAMES)
def test_the_centre_is_near_a_zero_of_the_equations(name):
    """Beside it by twice the half-width: what is bounded over the large box holds as before."""

    def beside(data):
        with precision(256):
            data["centre"][0] = text_of(exact(data["centre"][0]) + 2 * exact(data["radius"][0]))

    refused(name, beside, "'existence, coordinate 1' is false")


def test_a_claim_is_made_for_each_coordinate_and_for_no_more():
    wrong = {"box": "wrong size", "apart": "not complete", "incoming": "not complete", "sums": "not complete"}
    for name, said in wrong.items():

        def longer(data, name=name):
            data["claims"][name].append(data["claims"][name][0])

        data = deepcopy(table_bases()["kicked"]["data"])
        longer(data)
        with pytest.raises(Rejected, match=said):
            check(sealed(KIND, data, table_bases()["kicked"]["inequalities"], honest=False))


def test_what_is_in_the_way_is_found_and_what_is_beside_it_is_not():
    """Between A at 0 and B at 6 the ball flies along y = 0 from 1 to 5."""
    for beside in (1e-9, 0.2):
        assert check(changed("back and forth", more("disc", x=3, y=0.5 + beside, radius=0.5)))
        assert check(changed("back and forth", more("segment", x1=2, y1=beside, x2=4, y2=1)))
        assert check(changed("back and forth", more("drain", x1=2, y1=beside, x2=4, y2=1)))
        assert check(changed("back and forth", more("arc", x=3, y=0, radius=0.5, start=beside, stop=3.14)))
    for kind, numbers in (
        ("disc", {"x": 3, "y": 0.5, "radius": 0.5}),
        ("disc", {"x": 3, "y": 0.5 - 1e-12, "radius": 0.5}),
        ("disc", {"x": 3, "y": 0, "radius": 0}),
        ("segment", {"x1": 2, "y1": 0, "x2": 4, "y2": 1}),
        ("segment", {"x1": 2, "y1": -1e-12, "x2": 4, "y2": 1}),
        ("segment", {"x1": 2, "y1": 0, "x2": 4, "y2": 0}),
        ("drain", {"x1": 3, "y1": -1, "x2": 3, "y2": 1}),
        ("drain", {"x1": 3, "y1": 0, "x2": 3, "y2": 1}),
        ("arc", {"x": 3, "y": 0, "radius": 0.5, "start": -0.1, "stop": 3.0}),
        ("arc", {"x": 3, "y": 0, "radius": 0.5, "start": 0.2, "stop": 3.2}),
        ("arc", {"x": 3, "y": 0, "radius": 0.5, "start": 0.0, "stop": 6.28}),
    ):
        refused("back and forth", more(kind, **numbers), "not surely off new")


def test_the_sentence_says_that_a_drain_is_met_by_the_centre_of_the_ball():
    """On the tip the ball has a radius: a drain within it is not met, which "meets nothing else" alone denies."""
    data = table_bases()["on the tip"]["data"]
    assert float.fromhex(data["rho"]) == 0.1
    with precision(256):
        table = Table(data)
        (x, y), (nx, ny), _m = table.frames([exact(text) for text in data["centre"]])[0]
    x, y = float(x - nx * 0.05), float(y - ny * 0.05)  # half a radius below the lowest place of the centre
    said = check(changed("on the tip", more("drain", x1=x - 1e-3, y1=y, x2=x + 1e-3, y2=y)))
    assert 'the drain "new"' in said and "met where the centre of the ball is on it" in said


def test_an_impact_must_be_on_its_part():
    """The ceiling ends before the ball is there, the bowl where it bounces; the tip is no longer free."""
    names = [one["name"] for one in table_bases()["by the ceiling"]["data"]["objects"]]
    refused("by the ceiling", shape(names.index("ceiling"), x2=3.5), "place of impact|not surely off")
    refused("in the bowl", shape(0, start=4.3), "place of impact|not surely off")
    refused("in the bowl", shape(0, start=5.0, stop=4.9), "arc bowl is none")
    assert table_bases()["on the tip"]["data"]["impacts"] == [["bowl", "stop"]]
    assert check(changed("on the tip", shape(0, stop=7.0), again=True))  # the tip is elsewhere, and free above
    refused("on the tip", shape(0, start=-2.0, stop=3.5), "place of impact|not surely off", again=True)


def test_an_arc_of_nearly_a_turn_is_not_hit_where_it_is_open():
    """A gap of 0.01 at the bottom of a bowl, where a ball would bounce."""
    base = table_bases()["in the bowl"]["data"]
    gap = float(np.median([float(low) for low, _high in base["claims"]["box"][:2]]))
    for wide in (1.0, 0.2):
        where = gap if wide == 1.0 else float(base["claims"]["box"][0][0])
        refused("in the bowl", shape(0, start=where + wide / 2, stop=where + 2 * np.pi - wide / 2), "place of impact")


def test_elastic_laws_are_exactly_elastic():
    def almost(data):
        for one in data["objects"]:
            one["law"]["parameters"]["r"] = (1.0 - 2.0**-53).hex()

    refused("triangle", almost, "not surely elastic")

    def kicks(data):
        for one in data["objects"]:
            one["law"]["after"] = ["+", one["law"]["after"], (2.0**-1000).hex()]

    refused("triangle", kicks, "not surely elastic")

    def slowly(data):
        for one in data["objects"]:
            one["law"]["after"] = ["if", [">", "v", (-1e-30).hex()], (0.0).hex(), one["law"]["after"]]

    refused("triangle", slowly, "comparison in the reset law")

    def fast(data):  # a ball falls by 1e240 and more
        for one in data["objects"]:
            one["law"]["after"] = ["if", ["<", "v", (-(2.0**1000)).hex()], (0.0).hex(), one["law"]["after"]]

    refused("triangle", fast, "comparison in the reset law")

    def none(data):
        data["energy"] = None

    refused("triangle", none, "existence|uniqueness|finite|sums")
    refused("kicked", lambda data: data.update(energy=(0.5).hex()), "not surely elastic")


def test_an_orbit_gone_round_twice_has_no_longer_period():
    def twice(data):
        n = len(data["impacts"])
        data["impacts"] *= 2
        for where, names in ((data, ("centre", "radius", "unique")), (data["claims"], ("box", "apart"))):
            for name in names:
                where[name] = 2 * where[name][:n] + 2 * where[name][n:]
        data["claims"]["incoming"] *= 2
        data["claims"]["stability"] = "undecided"

    refused("kicked", twice, "least period, divisor 2", again=True)

    def honest(data):
        twice(data)
        data["claims"]["least_period"] = False

    document = changed("kicked", honest, again=True)
    assert "of period 6 impacts" in check(document)


@pytest.mark.parametrize("name", TABLE_NAMES)
def test_time_goes_on(name):
    """A flight back in time would leave a wire on one side and be off it on the other."""
    n = len(table_bases()[name]["data"]["impacts"])
    for i in range(n, 2 * n):

        def back(data, i=i):
            data["centre"][i] = f"-{data['centre'][i]}"

        refused(name, back, "does not surely take time")


def test_an_orbit_is_unstable_where_something_shows_it():
    kinds = set()
    for name in TABLE_NAMES:
        base = table_bases()[name]
        data, rows = deepcopy(base["data"]), base["inequalities"]
        names = [*margins([number(0)] * len(data["claims"]["sums"]))]
        data["claims"]["stability"] = "unstable"
        bare = [one for one in rows if one["name"] not in names]
        with pytest.raises(Rejected, match="nothing shows that the orbit is unstable"):
            check(sealed(KIND, data, bare, honest=False))
        kinds.add(base["data"]["claims"]["stability"])
    assert kinds >= {"stable", "unstable"}


def test_nothing_attracts_where_energy_is_conserved():
    def stable(data):
        data["claims"]["stability"] = "stable"

    refused("triangle", stable, "nothing attracts|nothing else|does not hold")
    refused("kicked", stable, "does not hold|is false")
    assert "nothing is claimed" in check(changed("kicked", lambda data: data["claims"].update(stability="undecided")))


def test_nothing_attracts_either_where_all_multipliers_are_on_the_unit_circle():
    """Motions beside it stay, and come no nearer: what is positive where multipliers are inside shows no attraction."""
    (one, *_) = gz.periodic_orbits(gz.collision_map(bowl(radius=1.5, r=1.0, V=0.0)), word="(bowl)", energy=-1.0)
    document = gz.certify(one).document
    data = document["data"]
    assert -2 < float(data["claims"]["sums"][0][0]) < float(data["claims"]["sums"][0][1]) < 2
    data["claims"]["stability"] = "stable"
    row = {"name": "2 - |L + 1/L|", "left": "1E-9", "relation": ">", "right": "0"}
    with pytest.raises(Rejected, match="where energy is conserved nothing attracts"):
        check(sealed(KIND, data, [*document["inequalities"], row], honest=False))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda data: data["objects"].clear(), "no short list"),
        (lambda data: data["objects"].append(deepcopy(data["objects"][0])), "two objects have one name"),
        (lambda data: data["objects"][0].update(kind="flipper"), "kind of an object"),
        (lambda data: data["objects"][0].update(name='A"'), "cannot be called"),
        (lambda data: data.update(rho=(-1.0).hex()), "out of range"),
        (lambda data: data.update(tilt=(2.0).hex()), "out of range"),
        (lambda data: data["impacts"][0].__setitem__(1, "left"), "has no part"),
        (lambda data: data["impacts"][0].__setitem__(0, "Z"), "at no object"),
        (lambda data: data.update(impacts=[]), "no short list"),
        (lambda data: data.update(impacts=data["impacts"] * 30), "no short list"),
    ],
)
def test_data_that_are_no_table_are_refused(change, said):
    refused("triangle", change, said)


def test_polynomials_lose_their_zeros_exactly():
    """3 s (2 - s) (s^2 + 1): its zeros at 0 and 2 are taken out, one or both, and positive it stays."""
    with precision(128):
        h = [arb(c) for c in (0, 6, -3, 6, -3)]
        for s in (0.0, 0.3, 1.7, 2.0):
            rest = 3 * (s * s + 1)
            for starts, ends, left in (
                (1, 1, rest),
                (1, 0, rest * (2 - s)),
                (0, 1, rest * s),
                (0, 0, rest * s * (2 - s)),
            ):
                assert abs(float(value(factored(h, bool(starts), bool(ends), arb(2)), arb(s))) - left) < 1e-14
        assert 0 < over(factored(h, True, True, arb(2)), arb(0.5, 0.1)) < 3 * (0.4**2 + 1)


def test_sums_of_multipliers_are_those_of_eigenvalues():
    random = np.random.default_rng(4)
    for conserved, roots in ((False, (0.5, -3.0, 0.2, 1.0)), (True, (7.0, 1 / 7.0, 1.0, 1.0))):
        P = random.normal(size=(4, 4))
        M = P @ np.diag(roots) @ np.linalg.inv(P)
        with precision(128):
            found = [float(x) for x in sums_of([[arb(x) for x in row] for row in M.tolist()], conserved)]
        a, b, c, _one = roots
        known = [a + b] if conserved else [a + b + c, a * b + b * c + c * a, a * b * c]
        np.testing.assert_allclose(found, known, rtol=1e-11)


@pytest.mark.parametrize("seed", range(4))
def test_margins_are_positive_exactly_inside_the_unit_circle(seed):
    random = np.random.default_rng(seed)
    for _ in range(300):
        pair = random.normal() + 1j * random.normal() * random.integers(0, 2)
        roots = [random.normal(), pair, pair.conjugate() if pair.imag else random.normal()]
        a, b, c = np.poly(roots)[1:].real * (-1, 1, -1)
        with precision(64):
            found = margins([arb(x) for x in (a, b, c)])
        inside = bool(max(map(abs, roots)) < 1)
        assert all(x > 0 for x in found.values()) is inside
        assert inside or any(x < 0 for x in found.values())


def test_a_flight_that_is_off_by_little_is_shown_in_few_pieces():
    with precision(256):
        zero = number(0)
        thing = Thing(table_bases()["back and forth"]["data"]["objects"][0], zero, Reader())
        for depth in (1e-3, 1e-9, 1e-15):
            flight, work = Flight((arb(-5), arb(1 + depth)), (arb(1), zero), arb(10), zero), [0]
            assert 0 < Apart(thing, flight, "", "").least(work) < 3 * depth and work[0] < 300
        flight = Flight((arb(-5), arb(1)), (arb(1), zero), arb(10), zero)
        with pytest.raises(Rejected, match="not surely off A"):
            Apart(thing, flight, "", "").least([0])


def test_the_bits_of_the_process_are_left_as_they_were():
    from flint import ctx

    before = ctx.prec
    check(table_bases()["triangle"])
    assert ctx.prec == before and isinstance(Table(table_bases()["triangle"]["data"]).n, int)
