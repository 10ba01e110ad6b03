"""A certificate that was changed is refused, field by field, also where the hash was made anew."""

import copy
import json
from hashlib import sha256

import pytest

from grazing.proof.gap import certify_gap_edge, certify_gap_orbit
from grazing.proof.gap_chaos import prove_no_attractor
from grazing.proof.gap_checker import CHAOS, Rejected, check_gap_certificate, inequalities_of

DOCUMENTS = {
    "orbit": certify_gap_orbit("LLRLR", 0.9, 0.1, 0.05).document,
    "double": certify_gap_orbit("LLRLLR", 0.8, 0.4, 1.0).document,
    "bc": certify_gap_edge("LLR", "bc", 0.9, 0.4)[0].document,
    "pd": certify_gap_edge("LLLR", "pd", 0.9, 0.4)[0].document,
    "small": prove_no_attractor(0.9, 0.0, 0.0, 0.18).document,
    "between": prove_no_attractor(0.9, 0.4, 0.28, 0.3).document,
}


def resealed(document):
    """What a forger hands over: changed, with a hash that fits."""
    body = {name: value for name, value in document.items() if name != "sha256"}
    canonical = json.dumps(body, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return {**body, "sha256": sha256(canonical.encode()).hexdigest()}


def leaves(value, path=()):
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from leaves(inner, (*path, name))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from leaves(inner, (*path, i))
    else:
        yield path, value


def changed(value):
    """Another value of the same kind."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    return value + " " if not value or not value[-1].isalnum() else value[:-1] + ("1" if value[-1] != "1" else "2")


def put(document, path, value):
    new = copy.deepcopy(document)
    at = new
    for step in path[:-1]:
        at = at[step]
    at[path[-1]] = value
    return new


@pytest.mark.parametrize("name", DOCUMENTS)
def test_as_made_it_passes(name):
    document = json.loads(json.dumps(DOCUMENTS[name]))
    assert check_gap_certificate(document) == document["statement"]


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_single_change_is_refused(name):
    tried = 0
    for path, value in leaves(DOCUMENTS[name]):
        with pytest.raises(Rejected):
            check_gap_certificate(put(DOCUMENTS[name], path, changed(value)))
        tried += 1
    assert tried > 20


#: What a forger would have to change, and what gives him away even with a new hash.
FORGED = [
    ("orbit", ("data", "mu"), (0.1001).hex()),
    ("orbit", ("data", "lam"), (0.9001).hex()),
    ("orbit", ("data", "l"), (0.051).hex()),
    ("orbit", ("data", "word"), "LLLRR"),
    ("orbit", ("data", "stable"), True),
    ("orbit", ("data", "stable"), "yes"),
    ("orbit", ("data", "radius"), "1p-1"),
    ("orbit", ("data", "radius"), "-1p-80"),
    ("orbit", ("data", "unique"), "1p4"),
    ("orbit", ("data", "unique"), "1p-120"),
    ("orbit", ("data", "multiplier", 0), "0p0"),
    ("orbit", ("data", "multiplier", 1), "1p1"),
    ("orbit", ("data", "roots", 0), "1p-1"),
    ("orbit", ("data", "roots", 0), "x"),
    ("orbit", ("data", "inverse", 0, 0), (0.0).hex()),
    ("double", ("data", "word"), "LLR"),
    ("double", ("data", "word"), "LLRLLRLLR"),
    ("double", ("data", "roots", 1), DOCUMENTS["double"]["data"]["roots"][0]),
    ("bc", ("data", "edge"), "pd"),
    ("bc", ("data", "at"), 0),
    ("bc", ("data", "at"), 7),
    ("bc", ("data", "l"), (0.41).hex()),
    ("bc", ("data", "centre", 1), "1p-2"),
    ("bc", ("data", "radius"), "1p-1"),
    ("pd", ("data", "edge"), "lp"),
    ("pd", ("data", "word"), "LLR"),
    ("small", ("data", "high"), (0.19).hex()),
    ("small", ("data", "l"), (0.01).hex()),
    ("small", ("data", "lam"), (0.6).hex()),
    ("small", ("data", "turns"), []),
    ("small", ("data", "turns", 0), (0.5).hex()),
    ("between", ("data", "high"), (0.31).hex()),
    ("between", ("data", "low"), (0.27).hex()),
    ("between", ("data", "low"), (0.0).hex()),
    ("between", ("data", "turns", 0), (0.28).hex()),
    ("between", ("data", "turns", 1), (0.28).hex()),
    ("between", ("data", "turns", 2), (0.28).hex()),
]


@pytest.mark.parametrize(("name", "path", "value"), FORGED)
def test_a_new_hash_does_not_help(name, path, value):
    forged = resealed(put(DOCUMENTS[name], path, value))
    with pytest.raises(Rejected) as caught:
        check_gap_certificate(forged)
    assert "hash" not in str(caught.value)
    # nor does a statement or a list of inequalities to go with it
    forged["inequalities"] = []
    with pytest.raises(Rejected):
        check_gap_certificate(resealed(forged))


def test_the_fixed_point_right_of_the_border_cannot_be_left_out():
    # at mu = 2 blocks of two letters and more do not occur, but R attracts
    data = {"lam": (0.9).hex(), "l": (0.0).hex(), "low": (2.0).hex(), "high": (3.0).hex(), "turns": []}
    for turns in ([], [(2.0).hex()], [(2.5).hex()], [(3.0).hex()]):
        with pytest.raises(Rejected):
            inequalities_of(CHAOS, {**data, "turns": turns})


@pytest.mark.parametrize("name", DOCUMENTS)
def test_statement_trusted_base_and_inequalities_are_held_against_the_data(name):
    document = DOCUMENTS[name]
    first = document["inequalities"][0]
    for path, value, said in (
        (("statement",), "The gap map is chaotic.", "what follows is"),
        (("trusted_base",), document["trusted_base"][:-1], "trusted base"),
        (("kind",), "gap map", "the kind of certificate"),
        (("version",), 2, "version 1"),
        (("inequalities",), document["inequalities"][1:], "not those of the proof"),
        (("inequalities", 0, "left"), "[-9 +/- 0.1]", "which is not the proof's"),
        (("inequalities", 0, "right"), "[1e9 +/- 0.1]", "which is not the proof's"),
        (("inequalities", 0, "relation"), ">", "relation <"),
        (("inequalities", 0, "right"), "much", "no ball"),
        (("inequalities", 0, "name"), first["name"] + "!", "not those of the proof"),
    ):
        with pytest.raises(Rejected, match=said):
            check_gap_certificate(resealed(put(document, path, value)))


def test_what_is_no_certificate_is_refused():
    for document in (None, [], {}, {"format": "grazing certificate"}, {**DOCUMENTS["bc"], "more": 1}):
        with pytest.raises(Rejected, match="this is no certificate"):
            check_gap_certificate(document)
    more = put(DOCUMENTS["bc"], ("data", "note"), "hello")
    with pytest.raises(Rejected, match="the data must have the fields"):
        check_gap_certificate(resealed(more))
