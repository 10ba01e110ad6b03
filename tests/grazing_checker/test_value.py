"""Attacks on certificates of bifurcation values: each hypothesis is broken, with the sentence that then fits."""

from contextlib import nullcontext
from copy import deepcopy
from types import SimpleNamespace

import pytest

from grazing.proof.text import enclosed
from grazing_checker import Rejected, check, value
from grazing_checker.balls import Ball, double, number, pi, precision
from grazing_checker.oscillator import inside
from grazing_checker.reading import exact
from tests.grazing_checker.bases import bases
from tests.grazing_checker.documents import WALLED_VALUES, changed, claiming, documents
from tests.grazing_checker.forgeries import Pen, elsewhere, fitting_matrix, sealed, text_of

VALUES = ("pd", "gr", "lp", "ns", *WALLED_VALUES)


def refused(document, said=None):
    with pytest.raises(Rejected, match=said):
        check(claiming(document))


def negative(row):
    return [x if x.startswith("-") else f"-{x}" for x in row]


@pytest.mark.parametrize("kind", VALUES)
def test_half_widths_of_the_curve_and_of_its_ends_are_positive(kind):
    document = documents()[kind]
    size = len(document["data"]["radius"])
    for radius in (negative, lambda r: ["0x0p0"] * size):
        refused(changed(document, ("data", "radius"), radius), "half-width is not positive")
    for i in range(size):
        one = changed(document, ("data", "radius", i), lambda r: "0x0p0")
        refused(one, "half-width is not positive")
    for i in range(2):
        refused(changed(document, ("data", "ends", i, "radius"), negative), r"is not positive|not at the end")


@pytest.mark.parametrize("kind", VALUES)
def test_ends_are_two_ends_of_the_same_curve(kind):
    document = documents()[kind]
    ends = document["data"]["ends"]
    for pair in ([ends[0]] * 2, [ends[1]] * 2, ends[::-1], ends[:1], [], [*ends, ends[0]]):
        refused(changed(document, ("data", "ends"), lambda _old, pair=pair: pair), "end")
    wide = document["data"]["radius"]
    pinned = document["data"]["pinned"]
    large = [x if i != pinned else "0x0p0" for i, x in enumerate(wide)]
    refused(changed(document, ("data", "ends", 0, "radius"), lambda _old: large), "end 1")


@pytest.mark.parametrize("kind", VALUES)
def test_the_pinned_coordinate_and_the_preconditioner_belong_to_the_curve(kind):
    document = documents()[kind]
    size = len(document["data"]["radius"])
    for other in {*range(-1, size + 1)} - {document["data"]["pinned"]}:
        refused(changed(document, ("data", "pinned"), lambda _old, other=other: other))
    C = document["data"]["preconditioner"]
    for rows in ([C[0]] * len(C), C[::-1], [[(0.0).hex()] * len(C)] * len(C)):
        if rows != C:
            said = "curve, coordinate .' does not hold"
            refused(changed(document, ("data", "preconditioner"), lambda _old, rows=rows: rows), said)


@pytest.mark.parametrize("kind", VALUES)
def test_the_curve_stays_in_its_box_all_along_and_its_ends_are_solutions(kind):
    document = documents()[kind]
    data = document["data"]
    pinned, radius = data["pinned"], [exact(text) for text in data["radius"]]
    longer = changed(document, ("data", "radius", pinned), lambda _old: text_of(2**12 * radius[pinned]))
    if kind != "table lp":  # its w_1 is always the same, and the parameter nearly so where it folds
        refused(longer, "curve, coordinate .' does not hold")
    i = 0 if pinned else 1
    with precision(256):
        beside = text_of(exact(data["ends"][0]["centre"][i]) + radius[i] / 16)
    refused(changed(document, ("data", "ends", 0, "centre", i), lambda _old: beside), "end 1, coordinate")


@pytest.mark.parametrize("kind", [kind for kind in VALUES if kind.endswith("gr")])
def test_the_dip_of_a_graze_is_inside_its_flight_and_looked_at_inside_itself(kind):
    """Beside its stretch the acceleration has no bound, nor before or after its flight: its height there is none."""
    document = documents()[kind]
    dip = document["data"]["dip"]
    outside, beside = "the dip is not inside its flight", "the dip is not looked at where it is"
    for wrong, said in (
        ({"from": "0x0p0"}, outside), ({"to": "0x1p9"}, outside), ({"from": dip["to"], "to": dip["from"]}, outside),
        ({"time": dip["from"]}, beside), ({"time": dip["to"]}, beside), ({"time": "-" + dip["time"]}, beside),
        ({"time": "0x1p9"}, beside), ({"flight": 0}, "the flight of the dip"), ({"flight": 9}, "no such flight"),
        ({"flight": 1.0}, "the flight of the dip"), ({"flight": True}, "the flight of the dip"),
    ):  # fmt: skip
        refused(changed(document, ("data", "dip"), lambda d, wrong=wrong: {**d, **wrong}), said)


def test_the_dip_of_a_graze_is_between_the_cuts_of_its_flight_and_there_where_one_is_needed():
    document = documents()["gr"]
    dip = document["data"]["dip"]
    start, end = document["data"]["cuts"][0]
    for wrong in ({"from": start}, {"to": end}):
        refused(changed(document, ("data", "dip"), lambda d, wrong=wrong: {**d, **wrong}), "not inside its flight")
    refused(changed(document, ("data", "dip"), lambda d: {}), "lacks")
    pd = documents()["pd"]
    refused(changed(pd, ("data", "dip"), lambda _old: dip), "a dip in a certificate that needs none")


@pytest.mark.parametrize("kind", VALUES)
def test_the_unknown_parameter_is_named_with_its_name_space(kind):
    """One parameter has no value, and it is the one that is named; law and model do not hide each other's names."""
    document = documents()[kind]
    parameter = document["data"]["parameter"]
    others = [
        {"of": "law", "name": "offset"}, {"of": "model", "name": "V"}, {"of": "model", "name": "offset_name"},
        {"of": "model", "name": "cos"}, {"of": "model", "name": "cos9"}, {"of": "", "name": parameter["name"]},
        {"of": parameter["of"], "name": ""}, {"of": ["law"], "name": "r"}, {"of": "law", "name": {}},
        {"of": "model" if parameter["of"] == "law" else "law", "name": parameter["name"]},
        {"of": "model", "name": "alpha"}, {"of": "A", "name": "alpha"}, {"of": "law of Z", "name": "r"},
        {"of": "law of model", "name": "k"},
    ]  # fmt: skip
    for other in others:
        forged = changed(document, ("data", "parameter"), lambda _old, other=other: other)
        with pytest.raises(Rejected):
            check({**document, "data": forged["data"]})
        try:
            sealed = claiming(forged)
        except (KeyError, TypeError):
            continue
        with pytest.raises(Rejected):
            check(sealed)
    law = ("law",) if "law" in document["data"] else ("walls", 0, "law")
    for place in (("model", "alpha"), (*law, "parameters", "r")):
        if place[-1] != parameter["name"]:
            refused(changed(document, ("data", *place), lambda _old: None), "no double")


def test_a_parameter_of_the_law_is_called_by_its_own_name():
    assert "there is a value of p.V in [" in documents()["pd"]["statement"]
    assert "there is a value of p.r in [" in documents()["ns"]["statement"]
    assert "there is a value of d in [" in documents()["gr"]["statement"]
    assert "p.V =" not in documents()["pd"]["statement"]


def test_a_fold_is_not_parametrised_by_its_parameter():
    document = documents()["pd"]
    size = len(document["data"]["radius"]) - 1
    assert document["data"]["pinned"] == size
    refused(changed(document, ("data", "type"), lambda _old: "lp"), "no curve over its parameter")


def test_a_neimark_sacker_pair_is_complex_on_all_of_the_curve():
    """Without its row, or with a pair that is real, the sign of 1 - det shows nothing."""
    document = documents()["ns"]
    assert document["inequalities"][-1]["name"] == "trace^2/4 - det"
    refused(changed(document, ("inequalities",), lambda rows: rows[:-1]), "is missing")
    refused(changed(documents()["pd"], ("data", "type"), lambda _old: "ns"), "does not surely change its sign")


@pytest.mark.parametrize("kind", ["pd", "lp", "ns"])
@pytest.mark.parametrize("same", ["stable", "unstable"])
def test_the_ends_are_not_both_stable_nor_both_unstable(kind, same):
    """Of these three the orbit loses its stability, at one end or the other."""
    refused(changed(documents()[kind], ("data", "claims", "ends"), lambda _old: [same, same]), "the orbit at end")


@pytest.mark.parametrize("kind", ["pd", "lp", "ns", "gr"])
@pytest.mark.parametrize("signs", [(1, 1), (-1, -1), (0, 1), (1, 0), (0, -1), (-1, 0), (0, 0)])
def test_a_quantity_of_one_sign_or_of_none_shows_nothing(monkeypatch, kind, signs):
    """Its rows would hold, each with the sign that there is."""
    data = {"type": kind}
    dip = "a dip" if kind == "gr" else None
    with precision(256):
        values = [Ball(sign, 0.5) for sign in signs]
        monkeypatch.setattr(value, "_heights", lambda *_known: values)
        monkeypatch.setattr(value, "margins", lambda x: {value.TESTED[kind]: x})
        problem = SimpleNamespace(size=3, trace_and_det=lambda x: (x,))
        curve = SimpleNamespace(pinned=1)
        with pytest.raises(Rejected, match="does not surely change its sign"):
            value._change_of_sign(problem, data, curve, [(x,) for x in values], dip, Pen([]))


def test_a_dip_has_a_sign_only_where_its_least_height_has_one():
    """y'' > 2 on the stretch, so that 0.1 with the velocity 1 may go on to -0.15: 0.1 is no least height."""
    with precision(256):
        for y, v, least in ((0.3, 1.0, 0.05), (0.3, -1.0, 0.05), (-0.1, 0.0, -0.1), (-0.1, 1.0, -0.1)):
            assert abs(float(value.least_height(double(y), double(v), number(2))) - least) < 1e-15
        for y, v in ((0.1, 1.0), (0.1, -1.0), (0.0, 0.0), (0.0, 1.0)):
            with pytest.raises(Rejected, match="does not surely change its sign"):
                value.least_height(double(y), double(v), number(2))


@pytest.mark.parametrize("name", ["gr", "rattle gr", "aloft gr", "post gr", "tip gr"])
def test_a_dip_that_is_below_at_both_ends_is_no_graze_wherever_it_is_looked_at(name):
    """Beside its lowest point its height may change its sign: at the end where it is > 0 that shows nothing."""
    base = bases()[name]
    found = []
    for by in (2, -2):
        data = deepcopy(base["data"])
        elsewhere(SimpleNamespace(randrange=lambda _n: 0, choice=lambda _ways, by=by: by, random=lambda: 0.0), data, [])
        with pytest.raises(Rejected, match="does not surely change its sign") as refusal:
            check(sealed(base["kind"], data, base["inequalities"]))
        found.append(data["dip"]["time"] != base["data"]["dip"]["time"])
        assert "at an end it has none" in str(refusal.value) or not found[-1]
    assert sorted(found) == [False, True]  # off the wall on one side of the graze, below it on the other


@pytest.mark.parametrize("later", [0, 1])
def test_nothing_but_the_dip_touches(later):
    """Gone round twice a free orbit has its dip twice, and only one of them is named."""
    base = documents()["aloft gr"]
    data = {**deepcopy(base["data"]), "periods": 2}
    with precision(256):
        turn = 2 * pi() / double(float.fromhex(data["model"]["omega"]))
        data["dip"] |= {name: text_of(exact(data["dip"][name]) + later * turn) for name in ("from", "to", "time")}
    fitting_matrix(None, data, [])
    with pytest.raises(Rejected, match="distance of the orbit from wall A is not proven"):
        check(sealed(base["kind"], data, base["inequalities"]))


@pytest.mark.parametrize("name", [kind for kind in VALUES if kind.endswith("gr")])
def test_the_acceleration_of_a_dip_is_proven_and_not_said(name):
    """With a large one every height is as good as the least, so that a dip may be looked at where it crosses."""
    base = documents()[name]
    rows = [{**row, "left": "1E9"} if row["name"] == "acceleration in the dip" else row for row in base["inequalities"]]
    for by in (2, -2):
        data = deepcopy(base["data"])
        elsewhere(SimpleNamespace(randrange=lambda _n: 0, choice=lambda _ways, by=by: by, random=lambda: 0.0), data, [])
        with pytest.raises(Rejected, match="the acceleration in the dip is not proven"):
            check(sealed(base["kind"], data, rows))


@pytest.mark.parametrize("claimed", ["stable", "unstable"])
@pytest.mark.parametrize("follows", [True, False])
@pytest.mark.parametrize("det", [0, 1, 2])
def test_an_end_is_stable_only_if_the_motions_beside_it_are_followed(claimed, follows, det):
    """As an orbit is: one that leaves the wall with w = 0 may be thrown off by slow impacts beside it."""
    held = {0: claimed == "stable" and follows, 1: False, 2: claimed == "unstable"}[det]
    with precision(256):
        x = [Ball(1, 1e-12), Ball(2, 1e-12)]
        sums = number(0), number(det)
        problem = SimpleNamespace(size=1, trace_and_det=lambda *_end: sums, followed=lambda _box: follows)
        claims = {"box": [enclosed(x[0])], "value": enclosed(x[1]), "ends": [claimed] * 2}
        with nullcontext() if held else pytest.raises(Rejected, match=f"at end 1 is not proven '{claimed}'"):
            value._claims(problem, {"claims": claims}, SimpleNamespace(box=x), [(x, []), (x, [])])


@pytest.mark.parametrize("side", [-1, 1])
def test_a_box_that_ends_less_than_a_rounding_outside_another_is_not_inside(side):
    """Both bounds are rounded to the same number."""
    with precision(256):
        tiny = number(1, -10)
        large, near = (Ball(number(1) - side * number(1, e), tiny) for e in (-300, -301))
        middle = Ball(number(1), tiny / 2)
        ends = [(one.lower(), one.upper()) for one in (near, large)]
        assert ends[0][side > 0].contains(ends[1][side > 0])
        assert not inside([near], [large]) and inside([middle], [large])


def test_a_dip_at_a_wall_that_is_left_ends_before_each_flight_of_the_box_does():
    """Flight 2 goes from B to A: its length is in a ball, and what is beyond its end is no motion."""
    document = documents()["rattle gr"]
    data = document["data"]
    assert data["impacts"] == ["A", "B"] and (data["dip"]["flight"], data["dip"]["wall"]) == (2, "B")
    with precision(256):
        first, second = (exact(text) for text in data["centre"][:2])
        length = first + 2 * pi() * data["periods"] / double(float.fromhex(data["model"]["omega"])) - second
        late = text_of(length)
    refused(changed(document, ("data", "dip", "to"), lambda _old: late), "the dip is not inside its flight")
