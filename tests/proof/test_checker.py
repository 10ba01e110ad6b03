"""The checker accepts what is proven and nothing else: every field is changed, and the document sealed again."""

import json
import subprocess
import sys
from copy import deepcopy
from math import nextafter
from pathlib import Path

import pytest

import grazing as gz
from grazing.proof.certify import certify
from grazing.proof.checker import check_certificate
from grazing.proof.enclose import enclose
from grazing.proof.envelope import seal
from grazing.proof.sentence import orbit_sentence, value_sentence
from tests.models import cubic
from tests.proof.orbits import attractor, closed, doubled, without_impacts

FINDER = ("certify", "enclose", "search", "flow", "equations", "krawczyk", "clearance", "law", "report", "text")


def documents():
    model = gz.pinball(d=0.12, V=0.4)
    (orbit,) = gz.one_impact_orbits(model, 3)
    (fold,) = (o for o in gz.one_impact_orbits(gz.pinball(alpha=0.2, omega=2.8, V=0.0, d=0.55), 2) if o.stable)
    (ns,) = gz.one_impact_orbits(gz.pinball(alpha=0.05, d=0.1), 1)
    found = {
        "stable": certify(orbit),
        "unstable": certify(doubled(model, 3, "d", 0.12328144964392065, 0.11)),
        "free": certify(without_impacts(gz.pinball(d=0.14))),
        "pd": enclose(orbit, "pd", "V"),
        "gr": enclose(orbit, "gr", "d"),
        "lp": enclose(fold, "lp", "d"),
        "ns": enclose(ns, "ns", "r"),
    }
    return {name: certificate.document for name, certificate in found.items()}


@pytest.fixture(scope="module")
def made():
    found = documents()
    for document in found.values():
        assert check_certificate(document) == document["statement"]
    return found


#: Numbers that only help to prove: not unique, and not part of the statement.
WITNESSES = {("data", "preconditioner"), ("data", "ends")}
KINDS = ("stable", "unstable", "free", "pd", "gr", "lp", "ns")


def resealed(document):
    return seal(*(document[name] for name in ("kind", "statement", "trusted_base", "data", "inequalities")))


def leaves(value, path=()):
    """Every path to something that is no list and no mapping, and to every empty one."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    if not value or not isinstance(value, (dict, list)):
        yield path
    for key, item in items:
        yield from leaves(item, (*path, key))


def changed(document, path, new):
    other = deepcopy(document)
    place = other
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = new(place[path[-1]])
    return other


def other_value(value):
    """Something of the same type that means something else."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
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


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_that_changes_is_found_even_sealed_again(made, kind):
    document = made[kind]
    paths = [path for path in leaves(document) if path[0] != "sha256"]
    assert len(paths) > 60
    for path in paths:
        forged = changed(document, path, other_value)
        with pytest.raises(gz.InputError):
            check_certificate(forged)
        if path[0] in ("format", "version"):
            continue
        try:
            said = check_certificate(resealed(forged))
        except gz.InputError as error:
            assert "rejected" in str(error)
        else:  # another witness of the same theorem: the sentence is still proven
            assert path[:2] in WITNESSES
            assert said == document["statement"]


@pytest.mark.parametrize("kind", KINDS)
def test_witnesses_must_do_their_work(made, kind):
    document = made[kind]
    for path in leaves(document):
        if path[:2] in WITNESSES and path[-2:] != ("radius", document["data"].get("pinned")):
            worse = changed(document, path, lambda text: "0x1p9" if "." not in text else (1e9).hex())
            with pytest.raises(gz.InputError, match="rejected"):
                check_certificate(resealed(worse))


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_is_needed_and_none_may_be_added(made, kind):
    document = made[kind]
    for place in ((), ("claims",), ("model",), ("law",)):
        for key in list(_at(document["data"], place)):
            other = deepcopy(document)
            del _at(other["data"], place)[key]
            with pytest.raises(gz.InputError, match="rejected"):
                check_certificate(resealed(other))
        other = deepcopy(document)
        _at(other["data"], place)["more"] = 1
        with pytest.raises(gz.InputError, match="lacks or adds more"):
            check_certificate(resealed(other))
    for i in range(len(document["inequalities"])):
        other = deepcopy(document)
        del other["inequalities"][i]
        with pytest.raises(gz.InputError, match=r"rejected: (the|inequality|nothing)"):
            check_certificate(resealed(other))


def _at(value, place):
    for key in place:
        value = value[key]
    return value


@pytest.mark.parametrize("name", ["alpha", "k", "omega", "t0", "offset", "sigma"])
def test_a_parameter_that_moves_by_its_last_bit_is_found(made, name):
    """Also with the sentence made anew: the box is far smaller than the orbit moves."""

    def moved(text):
        return nextafter(float.fromhex(text), 9.0).hex() if float.fromhex(text) else (2.0**-80).hex()

    forged = changed(made["stable"], ("data", "model", name), moved)
    forged["statement"] = orbit_sentence(forged["data"])
    with pytest.raises(gz.InputError, match="existence, coordinate"):
        check_certificate(resealed(forged))


def test_a_claim_that_is_not_proven_is_rejected_with_a_sentence_that_fits(made):
    document = made["stable"]
    for path, value, said in [
        (("claims", "stability"), "unstable", "the relation of"),
        (("claims", "apart"), ["0.1", "0.1"], "alone within"),
        (("claims", "box"), [["2.2", "2.3"], ["0.4", "0.45"]], "far too wide"),
        (("periods",), 4, "existence"),
        (("impacts",), 2, "list of 4"),
        (("cuts",), [["0x1p0", "0x7p0"]], "not proven"),
    ]:
        forged = changed(document, ("data", *path), lambda _old, value=value: value)
        if path != ("impacts",):
            forged["statement"] = orbit_sentence(forged["data"])
        with pytest.raises(gz.InputError, match=said):
            check_certificate(resealed(forged))
    forged = changed(made["unstable"], ("data", "claims", "stability"), lambda _old: "stable")
    forged["statement"] = orbit_sentence(forged["data"])
    with pytest.raises(gz.InputError, match="rejected"):
        check_certificate(resealed(forged))


def test_a_value_that_is_not_proven_is_rejected_with_a_sentence_that_fits(made):
    for kind in ("pd", "gr", "lp", "ns"):
        document = made[kind]
        low, high = (float(x) for x in document["data"]["claims"]["value"])
        forged = changed(document, ("data", "claims", "value"), lambda _old, x=high: [str(x), str(x + 1.0)])
        forged["statement"] = value_sentence(forged["data"])
        with pytest.raises(gz.InputError, match="the value is claimed"):
            check_certificate(resealed(forged))
        swapped = changed(document, ("data", "ends"), lambda ends: ends[::-1])
        with pytest.raises(gz.InputError, match="end 1 is not at the end"):
            check_certificate(resealed(swapped))
        assert low < high
    other = changed(made["pd"], ("data", "type"), lambda _old: "lp")
    other["statement"] = value_sentence(other["data"])
    with pytest.raises(gz.InputError, match="does not surely change its sign"):
        check_certificate(resealed(other))


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
    forged["statement"] = orbit_sentence(forged["data"])
    with pytest.raises(gz.InputError, match="height of flight 1 between its cuts is not proven"):
        check_certificate(resealed(forged))


def test_a_law_of_the_users_is_asked_for():
    model = gz.Oscillator(
        alpha=1.5, k=1.2, forcing=gz.Forcing(omega=2.2, offset=0.05), sigma=0.02, reset=gz.reset(cubic, e=0.8, c=0.5)
    )
    certificate = certify(attractor(model, (0.2, 0.1), 1))
    assert check_certificate(certificate.document, law=cubic) == certificate.statement
    assert "the reset law cubic of code" in certificate.statement
    with pytest.raises(gz.InputError, match="give it too: check_certificate"):
        check_certificate(certificate.document)
    with pytest.raises(gz.InputError, match="is not the reset law 'cubic'"):
        check_certificate(certificate.document, law=lambda v, p: -p.e * v)


def test_what_is_no_certificate_is_refused(made, tmp_path):
    path = tmp_path / "c.json"
    path.write_text(json.dumps(made["stable"])[:-5])
    with pytest.raises(gz.InputError, match="not the JSON"):
        check_certificate(path)
    with pytest.raises(
        gz.InputError, match="its kind is 'theorem'; allowed are periodic orbit, bifurcation value, gap"
    ):
        check_certificate(resealed({**made["stable"], "kind": "theorem"}))
    with pytest.raises(gz.InputError, match="rejected"):
        check_certificate(resealed({**made["stable"], "kind": "bifurcation value"}))


def test_the_checker_uses_nothing_of_the_finder():
    code = "import sys, grazing.proof.checker; print(*(m for m in sys.modules if m.startswith('grazing.proof.')))"
    source = str(Path(__file__).parents[2] / "src")
    run = subprocess.run(
        [sys.executable, "-P", "-c", f"import sys; sys.path.insert(0, {source!r}); {code}"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    loaded = {name.removeprefix("grazing.proof.") for name in run.stdout.split()}
    assert "checker_flight" in loaded
    assert loaded.isdisjoint(FINDER)


def test_twice_the_orbit_is_accepted_without_a_least_period(made):
    (orbit,) = gz.one_impact_orbits(gz.pinball(d=0.12, V=0.4), 3)
    shift = 3 * orbit.model.period
    twice, _r = closed(orbit.model, 6, [orbit.tau, orbit.tau + shift], [orbit.v_plus] * 2, orbit.incoming.repeat(2))
    document = certify(twice).document
    assert check_certificate(document) == document["statement"]
    forged = changed(document, ("data", "claims", "least_period"), lambda _old: True)
    forged["statement"] = orbit_sentence(forged["data"])
    with pytest.raises(gz.InputError, match="least period is not proven"):
        check_certificate(resealed(forged))
