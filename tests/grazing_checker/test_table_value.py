"""What the checker demands of a bifurcation on a table, one thing after the other: each is refused where it fails."""

from copy import deepcopy
from itertools import combinations
from math import pi

import numpy as np
import pytest
from flint import arb

from grazing_checker import Rejected, check, table_value
from grazing_checker.balls import number, precision
from grazing_checker.reading import exact
from tests.grazing_checker.bases import TABLE_VALUE_NAMES, table_value_bases
from tests.grazing_checker.forgeries import Pen, elsewhere, sealed, text_of

KIND = "bifurcation value on a table"


def changed(name, change):
    """Return a certificate whose data a forger has changed, and made all else fit, as far as the checker lets him."""
    base = table_value_bases()[name]
    data = deepcopy(base["data"])
    change(data)
    return sealed(KIND, data, base["inequalities"])


def refused(name, change, said):
    with pytest.raises(Rejected, match=said):
        check(changed(name, change))


def put(*path):
    """Return what puts its last word at the end of a path."""

    def change(data):
        place = data
        for step in path[:-2]:
            place = place[step]
        place[path[-2]] = path[-1]

    return change


@pytest.mark.parametrize("name", TABLE_VALUE_NAMES)
def test_what_a_forger_begins_with_is_right(name):
    said = check(changed(name, lambda data: None))
    assert said.split(" there is a value")[0] == table_value_bases()[name]["statement"].split(" there is a value")[0]


def test_one_parameter_and_no_other_is_unknown():
    refused("bowl pd", put("objects", 0, "law", "parameters", "V", None), "None is no double")
    refused("bowl pd", put("g", None), "None is no double")
    refused("bowl pd", put("objects", 0, "law", "parameters", "r", (0.78).hex()), "has a value")
    refused("bowl pd", put("parameter", {"of": "law of bowl", "name": "V"}), "has a value")
    refused("bowl pd", put("parameter", {"of": "bowl", "name": "r"}), "does not exist")
    refused("bowl pd", put("parameter", {"of": "law of Z", "name": "r"}), "does not exist")
    refused("bowl pd", put("parameter", {"of": "the table", "name": "energy"}), "does not exist")
    refused("elastic pd", put("parameter", {"of": "the table", "name": "energy"}), "does not exist")
    refused("bowl pd", put("parameter", {"of": ["law of bowl"], "name": "r"}), "no parameter is unknown")
    refused("bowl pd", put("parameter", {"of": "law of bowl"}), "lacks or adds name")


def test_no_object_has_a_name_of_the_plane_or_of_a_law():
    for name in ("the table", "law of bowl"):

        def named(data, name=name):
            data["objects"].append({**deepcopy(data["objects"][0]), "name": name})

        refused("bowl pd", named, "cannot be called|does not exist")


def test_what_changes_its_sign_is_what_is_said():
    for name in ("bowl pd", "bowl lp", "bowl ns"):
        for kind in {"pd", "lp", "ns"} - {table_value_bases()[name]["data"]["type"]}:
            refused(name, put("type", kind), "does not surely change its sign|a fold is no curve")
    refused("bowl pd", put("type", "bp"), "the type of bifurcation is 'bp'")
    refused("bowl pd", put("type", ["pd"]), "the type of bifurcation is")
    refused("elastic pd", put("type", "ns"), "multipliers stay on the unit circle")
    refused("post gr", put("type", "pd"), "there is a dip in a certificate that needs none")


@pytest.mark.parametrize("signs", [(1, 1), (-1, -1), (0, 1), (1, 0), (0, -1), (-1, 0), (0, 0)])
def test_a_quantity_of_one_sign_or_of_none_shows_nothing(signs):
    rows = Pen([])  # takes whatever is written
    with precision(256):
        values = [arb(sign, 0.5) for sign in signs]
        with pytest.raises(Rejected, match="does not surely change its sign"):
            table_value._change_of_sign("a quantity", values, rows)


def test_a_fold_is_no_curve_over_its_parameter():
    refused("bowl lp", put("pinned", 6), "curve, coordinate|a fold is no curve")


def test_the_boxes_have_an_inside_and_the_ends_are_the_ends():
    size = len(table_value_bases()["bowl pd"]["data"]["centre"])
    for i in range(size):
        refused("bowl pd", put("radius", i, "0x0p0"), "a half-width is not positive")
        refused("bowl pd", put("radius", i, "-0x1p-40"), "a half-width is not positive")
    refused("bowl pd", lambda data: data["ends"].reverse(), "end 1 is not at the end")
    refused("bowl pd", put("ends", 1, deepcopy(table_value_bases()["bowl pd"]["data"]["ends"][0])), "end 2 is not at")
    refused("bowl pd", put("ends", 0, "radius", 0, "-0x1p-60"), "not positive")
    refused("bowl pd", lambda data: data["ends"].pop(), "has not two ends")


@pytest.mark.parametrize("name", TABLE_VALUE_NAMES)
def test_the_box_of_an_end_lies_in_that_of_the_curve(name):
    """Outside of it derivatives have no bound; its inequalities hold the better the larger it is."""
    base = table_value_bases()[name]
    data, rows = deepcopy(base["data"]), deepcopy(base["inequalities"])
    free = [i for i in range(len(data["radius"])) if i != data["pinned"]]
    for i, one in zip(free, (row for row in rows if row["name"].startswith("end 2, coordinate")), strict=True):
        larger = 2 * exact(data["radius"][i])
        data["ends"][1]["radius"][i] = one["right"] = text_of(larger)
        one["left"] = f"{0.99 * float(larger):.6E}"
    with pytest.raises(Rejected, match="the box of end 2 is not inside the other"):
        check(sealed(KIND, data, rows, honest=False))


def test_a_dip_lies_in_its_flight_and_on_its_part():
    base = table_value_bases()["post gr"]["data"]["dip"]
    assert base["flight"] == 2 and base["object"] == "post" and base["part"] == "disc"
    said = "not looked at where it is"
    for change in (
        {"from": "-0x1p-3"}, {"from": "0x0p0"}, {"to": "0x1p9"}, {"time": base["from"]}, {"time": base["to"]},
    ):  # fmt: skip
        refused("post gr", put("dip", base | change), said)
    refused("post gr", put("dip", base | {"from": base["to"], "to": base["from"]}), f"{said}|not surely off post")
    for change, said in (
        ({"flight": 4}, "no such flight"),
        ({"flight": 0}, "the flight of the dip"),
        ({"flight": True}, "the flight of the dip"),
        ({"flight": 1}, "not surely off post|before the dip|after the dip|does not surely change"),
        ({"object": "Z"}, "a dip is at no object"),
        ({"object": ["post"]}, "a dip is at no object"),
        ({"object": "A"}, "not surely off post|distance|curvature"),
        ({"part": "left"}, "has no part"),
        ({"part": ["disc"]}, "has no part"),
    ):
        refused("post gr", put("dip", base | change), said)
    refused("post gr", put("dip", {}), "the dip lacks or adds")
    refused("post gr", put("dip", base | {"more": 1}), "the dip lacks or adds more")


def test_beside_the_end_of_a_wire_nothing_is_touched():
    """Its line is passed by the ball, but not the wire; and the tip is one part, the line another."""
    base = table_value_bases()["tip gr"]["data"]["dip"]
    for part in ("left", "right", "start"):
        refused("tip gr", put("dip", base | {"part": part}), "place of the dip|distance|curvature|not surely off")


def test_beside_the_ends_of_an_arc_nothing_is_touched():
    """In place of a post that the ball touches from below: a bow below its middle, or above it, of the same circle."""

    with precision(256):
        time = exact(table_value_bases()["post gr"]["data"]["dip"]["time"])

    def bow(middle):
        def change(data):
            (post,) = (one for one in data["objects"] if one["name"] == "post")
            post["kind"] = "arc"
            data["dip"] |= {"part": "outer", "from": text_of(time - number(1, -5)), "to": text_of(time + number(1, -5))}
            post["shape"] |= {"start": (middle - 1.4).hex(), "stop": (middle + 1.4).hex()}

        return change

    assert 'the ball touches outer of "post"' in check(changed("post gr", bow(-pi / 2)))
    for middle in (0.0, pi / 2, pi):
        refused("post gr", bow(middle), "'place of the dip on its part' is false")


def test_a_stretch_that_is_too_short_or_too_long_is_refused():
    """At its ends the ball must be off; and elsewhere nothing but the dip is left out."""
    base = table_value_bases()["post gr"]["data"]["dip"]
    with precision(256):
        time = exact(base["time"])
        narrow = {"from": text_of(time - arb(2) ** -70), "to": text_of(time + arb(2) ** -70)}
    refused("post gr", put("dip", base | narrow), "before the dip|after the dip|not surely off post")


@pytest.mark.parametrize("side", [-1, 1])
def test_nothing_but_the_dip_touches(side):
    """The stretch is beside it, before or after."""
    base = table_value_bases()["post gr"]["data"]["dip"]
    with precision(256):
        times = sorted((exact(base["time"]) + side * number(1, e) for e in (-3, -4, -5)), key=float)
    beside = dict(zip(("from", "time", "to"), map(text_of, times), strict=True))
    refused("post gr", put("dip", base | beside), "a flight is not surely off post")


def test_what_is_in_the_way_is_found():
    law = deepcopy(table_value_bases()["post gr"]["data"]["objects"][0]["law"])

    def more(x, y, radius):
        shape = {"x": float(x).hex(), "y": float(y).hex(), "radius": float(radius).hex()}
        return lambda data: data["objects"].append({"name": "new", "kind": "disc", "shape": shape, "law": law})

    refused("post gr", more(2.5, 0.5, 0.05), "off new")
    refused("post gr", more(1.5, 0.3, 0.2), "off new")  # touched from below, by the same flight
    assert check(changed("post gr", more(2.5, 1.0, 0.2)))


def test_claims_say_no_more_than_is_proven():
    value = table_value_bases()["bowl pd"]["data"]["claims"]["value"]
    refused("bowl pd", put("claims", "ends", ["stable", "stable"]), "the orbit at end")
    refused("elastic pd", put("claims", "ends", ["stable", "unstable"]), "the orbit at end")
    assert "nothing is claimed" in check(changed("bowl lp", put("claims", "ends", ["undecided", "undecided"])))
    with pytest.raises(Rejected, match="the value is claimed"):
        base = table_value_bases()["bowl pd"]
        data = deepcopy(base["data"])
        data["claims"]["value"] = [value[1], value[1][:-1] + "9"]
        check(sealed(KIND, data, base["inequalities"], honest=False))


def test_a_curve_beside_the_bifurcation_shows_none():
    import random

    rng, said = random.Random(3), set()
    for _ in range(6):
        data = deepcopy(table_value_bases()["bowl pd"]["data"])
        elsewhere(rng, data, [])
        try:
            check(sealed(KIND, data, table_value_bases()["bowl pd"]["inequalities"]))
        except Rejected as error:
            said.add(str(error))
    assert any("does not surely change its sign" in one for one in said)


@pytest.mark.parametrize("seed", range(3))
def test_quantities_vanish_where_multipliers_say(seed):
    random = np.random.default_rng(seed)
    for _ in range(200):
        pair = random.normal() + 1j * random.normal() * random.integers(0, 2)
        roots = [random.normal(), pair, pair.conjugate() if pair.imag else random.normal()]
        a, b, c = np.poly(roots)[1:].real * (-1, 1, -1)
        with precision(64):
            sums = [arb(x) for x in (a, b, c)]
            found = {kind: float(table_value.tested(sums, kind)[1]) for kind in ("pd", "lp", "ns")}
            apart = float(table_value.discriminant(sums))
        known = {
            "pd": np.prod([1 + one for one in roots]),
            "lp": np.prod([1 - one for one in roots]),
            "ns": np.prod([1 - one * two for one, two in combinations(roots, 2)]),
        }
        for kind, value in known.items():
            assert found[kind] == pytest.approx(value.real, abs=1e-9 * (1 + max(map(abs, roots))) ** 6)
        assert (apart < 0) == bool(pair.imag)


@pytest.mark.parametrize("length", [900, 1100])
def test_a_parameter_is_of_the_size_of_doubles(length):
    """Beyond them the law might be another one than it is at the speeds at which it is asked whether it is elastic."""
    time = length - 300

    def units(data):
        """The same orbit with the energy -4^300, its lengths and times by these powers of two."""
        speed, sizes = length - time, (0, time, length)

        def scaled(texts):
            return [one if one == "0x0p0" else f"{one.partition('p')[0]}p{int(one.partition('p')[2]) + k}"
                    for one, k in zip(texts, sizes, strict=True)]  # fmt: skip

        for one in (data, *data["ends"]):
            one |= {name: scaled(one[name]) for name in ("centre", "radius")}
        C = [[float.fromhex(one) for one in row] for row in data["preconditioner"]]
        data["preconditioner"] = [
            [(C[i][j] * 2.0 ** (sizes[i] - (j + 1) * speed)).hex() for j in range(2)] for i in range(2)
        ]
        data["g"], data["energy"] = (2.0 ** (speed - time)).hex(), (-(2.0 ** (2 * speed))).hex()

    if length == 900:
        assert check(changed("elastic pd", units))
    else:
        refused("elastic pd", units, "the parameter is larger than all doubles")


def test_where_energy_is_conserved_the_multipliers_are_those_at_one_energy():
    """Across all energies one more is 1, so that the product of 1 - L has no sign."""
    said = "of the map from impact to impact at this energy is"
    assert [name for name in TABLE_VALUE_NAMES if said in table_value_bases()[name]["statement"]] == ["elastic pd"]
