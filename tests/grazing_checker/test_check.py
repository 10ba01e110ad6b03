"""The checker accepts what is proven and nothing else: every field is changed, and the document sealed again."""

import json
import re
from copy import deepcopy
from math import nextafter

import pytest

import grazing as gz
from grazing.proof.certify import certify
from grazing.proof.gap import certify_gap_orbit
from grazing_checker import Rejected, check
from grazing_checker.check import KINDS
from tests.grazing_checker.bases import GAP_NAMES, TABLE_NAMES, TABLE_VALUE_NAMES, bases
from tests.grazing_checker.documents import (
    NAMES,
    WALLED,
    WALLED_VALUES,
    WITNESSES,
    alike,
    at,
    changed,
    claiming,
    documents,
    leaves,
    resealed,
)
from tests.grazing_checker.forgeries import is_decimal
from tests.grazing_checker.truth import is_true
from tests.models import cubic
from tests.proof.orbits import closed


@pytest.fixture(scope="module")
def made():
    found = documents()
    for document in found.values():
        assert check(document) == document["statement"]
    return found


def other_value(value):
    """Something of the same type that means something else."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    if value is None:
        return (1.0).hex()
    if isinstance(value, (list, dict)):
        return ["0x1p0"] if isinstance(value, list) else {"x": 1}
    if value.startswith(("0x", "-0x")) and "." not in value:  # an exact number: twice as large
        mantissa, exponent = value.split("p")
        return f"{mantissa}p{int(exponent) + 1}" if mantissa != "0x0" else "0x1p-20"
    if value.startswith(("0x", "-0x")):  # a double
        number = float.fromhex(value)
        return (2 * number if number else 1e-6).hex()
    try:
        return str(-2 * float(value) if float(value) else 1.0).upper()
    except ValueError:
        return value + "x"


# The rest of them in the long run; the generator of forgeries takes all of them in either.
QUICK = ("stable", "free", "pd", "pair", "aloft", "table pd")
EVERY = [pytest.param(kind, marks=[] if kind in QUICK else pytest.mark.long) for kind in NAMES]


@pytest.mark.parametrize("kind", EVERY)
def test_every_field_that_changes_is_found_even_sealed_again(made, kind):
    document = made[kind]
    paths = [path for path in leaves(document) if path[0] != "sha256"]
    assert len(paths) > 60
    for path in alike(paths):
        forged = changed(document, path, other_value)
        with pytest.raises(Rejected):
            check(forged)
        if path[0] in ("format", "version"):
            continue
        try:  # the sentence that a forger would write, where the data still make one
            sealed = claiming(forged) if path[0] in ("data", "inequalities") else resealed(forged)
        except (KeyError, ValueError, TypeError, AttributeError, IndexError):
            sealed = resealed(forged)
        try:
            said = check(sealed)
        except Rejected:
            continue
        if path == ("data", "claims", "least_period"):
            assert said == re.sub(r", of least period [^,]*,", "", document["statement"])  # less is claimed
        elif path == ("data", "claims", "symmetric"):
            assert said == re.sub(r"; it is its own mirror image, [^;]*;", ";", document["statement"])  # likewise
        elif path[:2] in (("data", "law"), ("data", "walls")):  # of a wall not met, or where no spring is
            assert is_true(sealed["kind"], sealed["data"]) == (True, "")
        else:  # another witness of the same theorem
            assert path[:2] in WITNESSES or (kind in (*WALLED, *WALLED_VALUES) and path[1] in ("cuts", "dip"))
            assert said == document["statement"]


@pytest.mark.parametrize("kind", NAMES)
def test_witnesses_must_do_their_work(made, kind):
    document = made[kind]
    for path in alike(leaves(document)):
        if path[:2] in WITNESSES and path[-2:] != ("radius", document["data"].get("pinned")):
            worse = changed(document, path, lambda text: "0x1p9" if "." not in text else (1e9).hex())
            with pytest.raises(Rejected):
                check(resealed(worse))


def finer(text):
    """Another exact number, larger by less than a thousandth."""
    mantissa, exponent = text.split("p")
    return f"{int(mantissa, 16) * 1024 + 1:#x}p{int(exponent) - 10}"


@pytest.mark.parametrize(
    ("path", "new"),
    [
        (("inequalities", -1, "left"), lambda text: str(0.99 * float(text))), (("data", "cuts", 0, 0), finer),
        (("data", "unique", 0), finer), (("data", "centre", 0), finer),
        (("data", "claims", "trace", 0), lambda text: str(float(text) - 1e-12)),
    ],
)  # fmt: skip
def test_numbers_that_help_to_prove_may_be_others_of_one_sentence(made, path, new):
    """The page on certificates named three kinds of them, and no more."""
    other = changed(made["stable"], path, new)
    assert other["data"] != made["stable"]["data"] or other["inequalities"] != made["stable"]["inequalities"]
    assert check(resealed(other)) == made["stable"]["statement"]


@pytest.mark.parametrize("kind", NAMES)
def test_every_field_is_needed_and_none_may_be_added(made, kind):
    document = made[kind]
    for place in (
        (),
        ("claims",),
        ("model",),
        *(part for part in (("law",), ("walls", 0), ("walls", -1, "law")) if part[0] in document["data"]),
        *((("parameter",),) if "parameter" in document["data"] else ()),
    ):
        for key in list(at(document["data"], place)):
            other = deepcopy(document)
            del at(other["data"], place)[key]
            with pytest.raises(Rejected, match="lacks or adds"):
                check(resealed(other))
        other = deepcopy(document)
        at(other["data"], place)["more"] = 1
        with pytest.raises(Rejected, match="lacks or adds more"):
            check(resealed(other))
    names = [(re.sub(r"\d+", "*", one["name"]), i) for i, one in enumerate(document["inequalities"])]
    for i in (i for *_same, i in alike((*name.split("*"), i) for name, i in names)):
        other = deepcopy(document)
        del other["inequalities"][i]
        with pytest.raises(Rejected, match=r"(the|inequality|nothing)"):
            check(resealed(other))


@pytest.mark.parametrize("name", [*NAMES, *GAP_NAMES, *TABLE_NAMES, *TABLE_VALUE_NAMES])
def test_each_inequality_is_held_against_its_quantity(name):
    """A bound that nothing reaches stands as it is, and is refused for what it is a bound of."""
    document = bases()[name]
    rows = document["inequalities"]
    for i in {re.sub(r"\d+", "*", one["name"]): i for i, one in enumerate(rows)}.values():
        beyond = {">": "1E9999", "<": "-1E9999"}[rows[i]["relation"]]
        with pytest.raises(Rejected, match=r"does not hold|not proven"):
            check(resealed(changed(document, ("inequalities", i, "left"), lambda _old, beyond=beyond: beyond)))


@pytest.mark.parametrize("name", [*TABLE_NAMES, *TABLE_VALUE_NAMES])
def test_each_number_claimed_on_a_table_is_held_against_its_quantity(name):
    """Those of other kinds are among the fields that change, here and in test_gap."""
    document = bases()[name]
    for path in alike(leaves(document["data"]["claims"])):
        if is_decimal(at(document["data"]["claims"], path)):
            forged = changed(document, ("data", "claims", *path), other_value)
            with pytest.raises(Rejected, match=r"claimed|alone within the distance"):
                check(resealed(forged))


@pytest.mark.parametrize(
    ("kind", "place"),
    [
        *((kind, (name,)) for kind in ("unstable", "pair") for name in ("box", "apart", "incoming", "multipliers")),
        *((kind, (name,)) for kind in ("pd", "aloft gr") for name in ("box", "ends", "value")),
        ("free", ("box",)), ("free", ("apart",)), ("stable", ("trace",)), ("pair", ("box", -1)),
    ],
)  # fmt: skip
def test_a_claim_is_made_of_each_and_of_no_more(made, kind, place):
    """A list that is too short says nothing of the rest, one that is too long what nothing is held against."""
    for other in (lambda old: old[:-1], lambda old: [*old, old[-1]]):
        forged = changed(made[kind], ("data", "claims", *place), other)
        try:
            sealed = claiming(forged)
        except (IndexError, ValueError):  # no sentence can be made of it
            sealed = resealed(forged)
        with pytest.raises(Rejected, match=r"wrong size|not complete|not two mult|at two ends|no pair"):
            check(sealed)


@pytest.mark.parametrize("name", ["alpha", "k", "omega", "t0", "offset", "sigma"])
def test_a_parameter_that_moves_by_its_last_bit_is_found(made, name):
    """Also with the sentence made anew: the box is far smaller than the orbit moves."""

    def moved(text):
        return nextafter(float.fromhex(text), 9.0).hex() if float.fromhex(text) else (2.0**-80).hex()

    forged = changed(made["stable"], ("data", "model", name), moved)
    with pytest.raises(Rejected, match="existence, coordinate"):
        check(claiming(forged))


def test_a_claim_that_is_not_proven_is_rejected_with_a_sentence_that_fits(made):
    document = made["stable"]
    for path, value, said in [
        (("claims", "stability"), "unstable", "the relation of"),
        (("claims", "apart"), ["0.1", "0.1"], "alone within"),
        (("claims", "box"), [["2.2", "2.3"], ["0.4", "0.45"]], "far too wide"),
        (("periods",), 4, "existence"),
        (("cuts",), [["0x1p0", "0x7p0"]], "not proven"),
    ]:
        forged = changed(document, ("data", *path), lambda _old, value=value: value)
        with pytest.raises(Rejected, match=said):
            check(claiming(forged))
    forged = changed(document, ("data", "impacts"), lambda _old: 2)
    with pytest.raises(Rejected, match="list of 4"):
        check(resealed(forged))
    with pytest.raises(Rejected):
        check(claiming(changed(made["unstable"], ("data", "claims", "stability"), lambda _old: "stable")))


@pytest.mark.parametrize("kind", ["pd", "gr", "lp", "ns", *WALLED_VALUES])
def test_a_value_that_is_not_proven_is_rejected_with_a_sentence_that_fits(made, kind):
    document = made[kind]
    low, high = (float(x) for x in document["data"]["claims"]["value"])
    assert low < high
    forged = changed(document, ("data", "claims", "value"), lambda _old: [str(high), str(high + 1.0)])
    with pytest.raises(Rejected, match="the value is claimed"):
        check(claiming(forged))
    swapped = changed(document, ("data", "ends"), lambda ends: ends[::-1])
    with pytest.raises(Rejected, match="end 1 is not at the end"):
        check(claiming(swapped))
    for other in {"pd", "lp", "ns"} - {document["data"]["type"]}:
        forged = changed(document, ("data", "type"), lambda _old, other=other: other)
        with pytest.raises(Rejected, match=r"change its sign|no curve over its parameter|a dip in a|a graze only"):
            check(claiming(forged))


def test_a_virtual_orbit_cannot_be_sealed(made):
    """The numbers of a virtual orbit in a certificate of an admissible one: its flight is found below the wall."""
    model = gz.pinball(d=0.098, V=0.4)  # beyond the graze at 0.09845
    (virtual,) = gz.one_impact_orbits(model, 3)
    assert not virtual.admissible
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.099, V=0.4), 3)
    good = certify(orbit).document
    from flint import arb, ctx

    from grazing.proof.equations import Equations
    from grazing.proof.krawczyk import inverse, newton
    from grazing.proof.text import exact_text, short

    with ctx.workprec(256):
        equations = Equations(model, 1, 3)
        centre = newton(equations, [arb(virtual.tau), arb(virtual.v_plus)])
        C = inverse(equations.jacobian(equations.flights(centre)))
        forged = deepcopy(good)
        forged["data"]["model"]["offset"] = (0.098).hex()
        forged["data"]["centre"] = [exact_text(short(x, 128)) for x in centre]
        forged["data"]["preconditioner"] = [[x.hex() for x in row] for row in C]
        wide = [[str(float(x) - 1e-12), str(float(x) + 1e-12)] for x in centre]
        forged["data"]["claims"]["box"] = wide
    with pytest.raises(Rejected, match="height of flight 1 between its cuts is not proven"):
        check(claiming(forged))


def test_a_law_given_is_held_against_the_one_in_the_certificate(made):
    document = made["own"]
    assert gz.check_certificate(document, law=cubic) == document["statement"]
    assert "makes u' = (-p.e)*v/(1.0 - p.c*v) with p.e = 0.8, p.c = 0.5" in document["statement"]
    with pytest.raises(gz.InputError, match="another law"):
        gz.check_certificate(document, law=lambda v, p: -p.e * v)
    with pytest.raises(gz.InputError, match="no expression"):
        gz.check_certificate(document, law=lambda v, p: int(v))
    with pytest.raises(gz.InputError, match="rejected"):
        gz.check_certificate({**document, "statement": "So it is."})


def test_between_walls_a_law_given_is_held_against_that_of_each(made):
    def law(v, p):
        return -p.r * v

    assert gz.check_certificate(made["rattle"], law=law) == made["rattle"]["statement"]
    with pytest.raises(gz.InputError, match=r"no expression to hold against the certificate's at wall L: Attribute"):
        gz.check_certificate(made["aloft"], law=law)
    with pytest.raises(gz.InputError, match=r"another law at wall A: v\+ = \(-p\.r\)\*v; the one given is v\+ = -v"):
        gz.check_certificate(made["rattle"], law=lambda v, p: -v)
    with pytest.raises(gz.InputError, match="a map without a reset law; leave law away"):
        gz.check_certificate(certify_gap_orbit("R", 0.5, 0.9, 0.0).document, law=law)


def test_what_is_no_certificate_is_refused(made, tmp_path):
    path = tmp_path / "c.json"
    path.write_text(json.dumps(made["stable"])[:-5])
    with pytest.raises(Rejected, match="not the JSON"):
        check(path)
    with pytest.raises(Rejected, match="its kind is 'theorem'; allowed are periodic orbit, periodic orbit with walls"):
        check(resealed({**made["stable"], "kind": "theorem"}))
    with pytest.raises(Rejected, match="lacks or adds"):
        check(resealed({**made["stable"], "kind": "bifurcation value"}))


def test_twice_the_orbit_is_accepted_without_a_least_period(made):
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    shift = 3 * orbit.model.period
    twice, _r = closed(orbit.model, 6, [orbit.tau, orbit.tau + shift], [orbit.v_plus] * 2, orbit.incoming.repeat(2))
    document = certify(twice).document
    assert check(document) == document["statement"]
    forged = changed(document, ("data", "claims", "least_period"), lambda _old: True)
    with pytest.raises(Rejected, match="'least period, divisor 2' is missing"):
        check(claiming(forged))


def test_a_statement_that_does_not_follow_costs_no_second_proof(made, monkeypatch):
    for kind, document in {document["kind"]: document for document in made.values()}.items():
        rule, proofs = KINDS[kind], []

        def counted(data, rows, rule=rule, proofs=proofs):
            proofs.append(rule)
            return rule.check(data, rows)

        monkeypatch.setitem(KINDS, kind, rule._replace(check=counted))
        with pytest.raises(Rejected, match="the statement does not follow"):
            check(resealed({**document, "statement": "Something else."}))
        assert len(proofs) == 1, kind
